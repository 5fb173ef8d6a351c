!> Cholesky's factorization of S with pivoting, alone or with singular values for those S whose pivots leave a doubt.
module taut_linalg_normal_solver_pivoted
   use taut_kinds, only: wp
   use taut_linalg_csr, only: csr_t
   use taut_linalg_normal_solver_dense, only: dense_solver_t
   use taut_linalg_pseudo_inverse, only: by_either, by_pivots
   use taut_linalg_rank, only: rcond_of_pivots
   implicit none (type, external)
   private
   public :: pivoted_solver_t, pivoted_or_dgelsd_solver_t

   !> The rank is what the pivots say.
   type, extends(dense_solver_t) :: pivoted_solver_t
   contains
      procedure :: init
   end type pivoted_solver_t

   !> The rank is what the pivots say where they leave no doubt; otherwise DGELSD decides and solves.
   type, extends(dense_solver_t) :: pivoted_or_dgelsd_solver_t
   contains
      procedure :: init => init_either
   end type pivoted_or_dgelsd_solver_t

contains

   !> Allocates the workspace.
   subroutine init(self, a, c, sizes, rcond)
      !> The solver.
      class(pivoted_solver_t), intent(inout) :: self
      !> A matrix with the pattern of A.
      type(csr_t), intent(in) :: a
      !> How many of its rows are used, from the first one on.
      integer, intent(in) :: c
      !> Sizes of the blocks of K.
      integer, intent(in) :: sizes(:)
      !> Relative size below which pivots count as zero; 0 for the default.
      real(wp), intent(in) :: rcond

      self%s_plus%rcond = rcond_of_pivots
      call self%lay_out(a, c, sizes, rcond)
      call self%s_plus%init(c, by_pivots)
   end subroutine init

   !> Allocates the workspace.
   subroutine init_either(self, a, c, sizes, rcond)
      !> The solver.
      class(pivoted_or_dgelsd_solver_t), intent(inout) :: self
      !> A matrix with the pattern of A.
      type(csr_t), intent(in) :: a
      !> How many of its rows are used, from the first one on.
      integer, intent(in) :: c
      !> Sizes of the blocks of K.
      integer, intent(in) :: sizes(:)
      !> Relative size below which singular values count as zero; 0 for the default.
      real(wp), intent(in) :: rcond

      call self%lay_out(a, c, sizes, rcond)
      call self%s_plus%init(c, by_either)
   end subroutine init_either

end module taut_linalg_normal_solver_pivoted
