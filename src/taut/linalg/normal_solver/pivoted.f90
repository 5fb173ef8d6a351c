!> Cholesky's factorization of S_KK, scaled to a unit diagonal, with pivoting.
module taut_linalg_normal_solver_pivoted
   use taut_kinds, only: wp
   use taut_linalg_normal_solver_dense, only: basic_solver_t
   use taut_linalg_pivoted_cholesky, only: pivoted_cholesky_t
   use taut_linalg_rank, only: unit_diagonal
   implicit none (type, external)
   private
   public :: pivoted_solver_t

   !> The factor, and the scales of rows and columns.
   type, extends(basic_solver_t) :: pivoted_solver_t
      type(pivoted_cholesky_t), private :: cholesky
      real(wp), allocatable, private :: scale(:)
   contains
      procedure :: keep
      procedure :: invert
      procedure :: solve
      procedure :: weakest
   end type pivoted_solver_t

contains

   !> Takes the rows that are independent.
   subroutine keep(self, kept)
      !> The solver, after `init`.
      class(pivoted_solver_t), intent(inout) :: self
      !> Which they are: (c).
      logical, intent(in) :: kept(:)

      call self%keep_basis(kept)
      call self%cholesky%init(self%rank)
      if (allocated(self%scale)) deallocate (self%scale)
      allocate (self%scale(self%rank), source=1.0_wp)
   end subroutine keep

   !> Factorizes S_KK.
   subroutine invert(self, s, info)
      !> The solver.
      class(pivoted_solver_t), intent(inout) :: self
      !> S_KK, finite: (rank, rank).
      real(wp), intent(in) :: s(:, :)
      !> 0.
      integer, intent(out) :: info
      integer :: i

      info = 0
      do i = 1, self%rank
         self%scale(i) = unit_diagonal(s(i, i))
      end do
      call self%cholesky%factorize(s, self%scale, self%cut)
      ! Rows at a dead point are left to the others for the moment.
      call self%cholesky%set_rank(count(self%cholesky%pivot > self%cut), self%scale)
   end subroutine invert

   !> x = S_KK^-1 r.
   subroutine solve(self, r, x)
      !> The solver, after `invert`.
      class(pivoted_solver_t), intent(inout) :: self
      !> Right-hand side: (rank).
      real(wp), intent(in), contiguous :: r(:)
      !> Solution: (rank).
      real(wp), intent(out), contiguous :: x(:)

      call self%cholesky%solve(self%scale, r, x)
   end subroutine solve

   !> The smallest pivot of the scaled S_KK.
   pure function weakest(self) result(pivot)
      !> The solver, after `factorize`.
      class(pivoted_solver_t), intent(in) :: self
      !> 0 if a row was passed over.
      real(wp) :: pivot

      pivot = 1.0_wp
      if (self%rank > 0) pivot = minval(self%cholesky%pivot)
   end function weakest

end module taut_linalg_normal_solver_pivoted
