!> S = L D L^T in an ordering of its rows with a small bandwidth.
module taut_linalg_normal_solver_banded
   use taut_kinds, only: wp
   use taut_linalg_banded_factor, only: banded_factor_t
   use taut_linalg_csr, only: csr_t
   use taut_linalg_normal_solver_ordered, only: ordered_solver_t
   use taut_linalg_ordering, only: bandwidth, reverse_cuthill_mckee
   implicit none (type, external)
   private
   public :: banded_solver_t

   !> S within a band.
   type, extends(ordered_solver_t) :: banded_solver_t
      !> The factor.
      type(banded_factor_t) :: band
   contains
      procedure :: init
      procedure :: work
      procedure :: factorize_ordered
      procedure :: solve
      procedure :: weakest
   end type banded_solver_t

contains

   !> Finds an ordering and allocates the workspace.
   subroutine init(self, a, c, sizes)
      !> The solver.
      class(banded_solver_t), intent(inout) :: self
      !> A matrix with the pattern of A.
      type(csr_t), intent(in) :: a
      !> How many of its rows are used, from the first one on.
      integer, intent(in) :: c
      !> Sizes of the blocks of K.
      integer, intent(in) :: sizes(:)
      type(csr_t) :: pattern
      integer, allocatable :: first(:), neighbor(:)
      integer :: i, narrow(c), width

      call self%lay_out(a, c, sizes, pattern, first, neighbor)
      width = bandwidth(first, neighbor, [(i, i=1, c)])
      if (width > 1) then
         call reverse_cuthill_mckee(first, neighbor, narrow)
         if (bandwidth(first, neighbor, narrow) < width) then
            width = bandwidth(first, neighbor, narrow)
            call self%normal%reorder(pattern, narrow)
         end if
      end if
      call self%band%init(c, width)
   end subroutine init

   !> Multiplications of a factorization.
   pure function work(self) result(number)
      !> The solver.
      class(banded_solver_t), intent(in) :: self
      !> Their number.
      real(wp) :: number

      number = real(self%c, wp)*self%band%width**2
   end function work

   !> Factorizes S.
   pure subroutine factorize_ordered(self)
      !> The solver.
      class(banded_solver_t), intent(inout) :: self

      call self%band%factorize(self%normal%s, self%normal%row, self%normal%column, self%least)
   end subroutine factorize_ordered

   !> x := S^-1 x in the ordering.
   pure subroutine solve(self, x)
      !> The solver, after `factorize`.
      class(banded_solver_t), intent(in) :: self
      !> Right-hand side, replaced by the solution: (c).
      real(wp), intent(inout), contiguous :: x(:)

      call self%band%solve(x)
   end subroutine solve

   !> The smallest pivot of the kept rows relative to its diagonal entry.
   pure function weakest(self) result(pivot)
      !> The solver, after `factorize`.
      class(banded_solver_t), intent(in) :: self
      !> 0 if a kept row was passed over.
      real(wp) :: pivot

      pivot = self%weakest_of(self%c, self%least, self%band%reciprocal, self%normal%s)
   end function weakest

end module taut_linalg_normal_solver_banded
