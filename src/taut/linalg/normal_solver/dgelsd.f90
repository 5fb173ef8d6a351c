!> The Moore-Penrose inverse of S by DGELSD.
module taut_linalg_normal_solver_dgelsd
   use taut_kinds, only: wp
   use taut_linalg_csr, only: csr_t
   use taut_linalg_normal_solver_dense, only: dense_solver_t
   use taut_linalg_pseudo_inverse, only: by_singular_values
   implicit none (type, external)
   private
   public :: dgelsd_solver_t

   !> The rank is what the singular values say.
   type, extends(dense_solver_t) :: dgelsd_solver_t
   contains
      procedure :: init
   end type dgelsd_solver_t

contains

   !> Allocates the workspace.
   subroutine init(self, a, c, sizes, rcond)
      !> The solver.
      class(dgelsd_solver_t), intent(inout) :: self
      !> A matrix with the pattern of A.
      type(csr_t), intent(in) :: a
      !> How many of its rows are used, from the first one on.
      integer, intent(in) :: c
      !> Sizes of the blocks of K.
      integer, intent(in) :: sizes(:)
      !> Relative size below which singular values count as zero; 0 for the default.
      real(wp), intent(in) :: rcond

      call self%lay_out(a, c, sizes, rcond)
      call self%s_plus%init(c, by_singular_values)
   end subroutine init

end module taut_linalg_normal_solver_dgelsd
