!> S = L D L^T in an ordering of its rows with little fill.
module taut_linalg_normal_solver_sparse
   use taut_kinds, only: wp
   use taut_linalg_csr, only: csr_t
   use taut_linalg_normal_solver_ordered, only: ordered_solver_t
   use taut_linalg_ordering, only: minimum_degree
   use taut_linalg_sparse_factor, only: sparse_factor_t
   implicit none (type, external)
   private
   public :: sparse_solver_t

   !> S with the entries that there are.
   type, extends(ordered_solver_t) :: sparse_solver_t
      !> The factor.
      type(sparse_factor_t) :: fill
   contains
      procedure :: init
      procedure :: work
      procedure :: factorize_ordered
      procedure :: solve
      procedure :: weakest
   end type sparse_solver_t

contains

   !> Finds an ordering and allocates the workspace.
   subroutine init(self, a, c, sizes)
      !> The solver.
      class(sparse_solver_t), intent(inout) :: self
      !> A matrix with the pattern of A.
      type(csr_t), intent(in) :: a
      !> How many of its rows are used, from the first one on.
      integer, intent(in) :: c
      !> Sizes of the blocks of K.
      integer, intent(in) :: sizes(:)
      type(csr_t) :: pattern
      integer, allocatable :: first(:), neighbor(:)
      integer :: thin(c)

      call self%lay_out(a, c, sizes, pattern, first, neighbor)
      call minimum_degree(first, neighbor, thin)
      call self%normal%reorder(pattern, thin)
      call self%fill%init(c, self%normal%row, self%normal%column)
   end subroutine init

   !> Multiplications of a factorization.
   pure function work(self) result(number)
      !> The solver.
      class(sparse_solver_t), intent(in) :: self
      !> Their number.
      real(wp) :: number

      number = self%fill%work()
   end function work

   !> Factorizes S.
   pure subroutine factorize_ordered(self)
      !> The solver.
      class(sparse_solver_t), intent(inout) :: self

      call self%fill%factorize(self%normal%s, self%normal%column, self%least)
   end subroutine factorize_ordered

   !> x := S^-1 x in the ordering.
   pure subroutine solve(self, x)
      !> The solver, after `factorize`.
      class(sparse_solver_t), intent(in) :: self
      !> Right-hand side, replaced by the solution: (c).
      real(wp), intent(inout), contiguous :: x(:)

      call self%fill%solve(x)
   end subroutine solve

   !> The smallest pivot of the kept rows relative to its diagonal entry.
   pure function weakest(self) result(pivot)
      !> The solver, after `factorize`.
      class(sparse_solver_t), intent(in) :: self
      !> 0 if a kept row was passed over.
      real(wp) :: pivot

      pivot = self%weakest_of(self%c, self%least, self%fill%reciprocal, self%normal%s)
   end function weakest

end module taut_linalg_normal_solver_sparse
