!> What solvers have in common that factorize S = L D L^T entry by entry, in an ordering of its rows that suits them.
!!
!! Rows that depend on those before them in the ordering are left out: their multipliers are zero instead of all being of
!! minimum norm, with the same reactions.
module taut_linalg_normal_solver_ordered
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_kinds, only: wp
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_csr, only: csr_t
   use taut_linalg_normal_matrix, only: normal_matrix_t
   use taut_linalg_normal_solver, only: normal_solver_t
   use taut_linalg_pivoted_cholesky, only: orthonormalize, remove_components
   use taut_linalg_rank, only: pivot_cut, rcond_of_pivots
   implicit none (type, external)
   private
   public :: ordered_solver_t

   !> A solver with S in an ordering.
   type, abstract, extends(normal_solver_t) :: ordered_solver_t
      !> S and A K^-1.
      type(normal_matrix_t) :: normal
      !> Size of a pivot, relative to its diagonal entry of S, that counts as zero.
      real(wp) :: rcond = rcond_of_pivots
      real(wp), allocatable, private :: z(:)
   contains
      procedure :: lay_out
      procedure(factorize_ordered), deferred :: factorize_ordered
      procedure(solve), deferred :: solve
      procedure(is_left_out), deferred :: is_left_out
      procedure :: factorize
      procedure :: multipliers
      procedure :: minimum_norm
      procedure :: correction
   end type ordered_solver_t

   abstract interface

      !> Factorizes S as it is in `normal`, finite, and sets `rank`.
      pure subroutine factorize_ordered(self, cut)
         import :: ordered_solver_t, wp
         implicit none (type, external)
         !> The solver.
         class(ordered_solver_t), intent(inout) :: self
         !> Pivots up to this part of their diagonal entry are zero.
         real(wp), intent(in) :: cut
      end subroutine factorize_ordered

      !> x := S^-1 x in the ordering; zero where a row is left out.
      pure subroutine solve(self, x)
         import :: ordered_solver_t, wp
         implicit none (type, external)
         !> The solver, after `factorize`.
         class(ordered_solver_t), intent(in) :: self
         !> Right-hand side, replaced by the solution: (c).
         real(wp), intent(inout), contiguous :: x(:)
      end subroutine solve

      !> Whether a row is left out.
      pure function is_left_out(self, i) result(left_out)
         import :: ordered_solver_t
         implicit none (type, external)
         !> The solver, after `factorize`.
         class(ordered_solver_t), intent(in) :: self
         !> Its place in the ordering.
         integer, intent(in) :: i
         !> Whether it was.
         logical :: left_out
      end function is_left_out

   end interface

contains

   !> Lays out S in the given order and finds which rows share coordinates.
   subroutine lay_out(self, a, c, sizes, rcond, pattern, first, neighbor)
      !> The solver.
      class(ordered_solver_t), intent(inout) :: self
      !> A matrix with the pattern of A.
      type(csr_t), intent(in) :: a
      !> How many of its rows are used.
      integer, intent(in) :: c
      !> Sizes of the blocks of K.
      integer, intent(in) :: sizes(:)
      !> Size of a pivot that counts as zero, or 0 for the default.
      real(wp), intent(in) :: rcond
      !> The pattern of A; where all entries are stored, that which says so.
      type(csr_t), intent(out) :: pattern
      !> First neighbor of each row, as of `graph` of `normal_matrix_t`.
      integer, allocatable, intent(out) :: first(:)
      !> The neighbors.
      integer, allocatable, intent(out) :: neighbor(:)
      integer :: i, j

      self%c = c
      self%n = a%n
      if (rcond > 0.0_wp) self%rcond = rcond
      if (a%full) then
         call pattern%set_pattern(a%n, [(i*a%n + 1, i=0, c)], [((j, j=1, a%n), i=1, c)])
      else
         pattern = a
      end if
      call self%normal%init(pattern, c, sizes)
      call self%normal%graph(first, neighbor)
      allocate (self%z(c), source=0.0_wp)
   end subroutine lay_out

   !> Takes a new A, and K factorized.
   subroutine factorize(self, a, k, identity, info, noise)
      !> The solver.
      class(ordered_solver_t), intent(inout) :: self
      !> The constraint matrix.
      type(csr_t), intent(in) :: a
      !> The metric, factorized; not used if it is the identity.
      type(block_diagonal_t), intent(in) :: k
      !> Whether K = I.
      logical, intent(in) :: identity
      !> 0, or 1 if there are entries that are not finite.
      integer, intent(out) :: info
      !> Relative error of the rows of A.
      real(wp), intent(in) :: noise
      integer :: i
      logical :: finite

      self%identity = identity
      call self%normal%assemble(a, k, identity)
      ! What is not finite in a row of A is not finite on the diagonal.
      finite = .true.
      do i = 1, self%c
         finite = finite .and. ieee_is_finite(self%normal%s(i))
      end do
      info = 1
      if (.not. finite) return
      info = 0
      call self%factorize_ordered(pivot_cut(self%rcond, noise))
   end subroutine factorize

   !> Multipliers S^+ r, those of rows that are left out zero.
   subroutine multipliers(self, r, lambda)
      !> The solver, after `factorize`.
      class(ordered_solver_t), intent(inout) :: self
      !> Violation at the level concerned: (c).
      real(wp), intent(in) :: r(self%c)
      !> The multipliers: (c).
      real(wp), intent(out) :: lambda(self%c)
      integer :: i

      if (self%normal%natural) then
         do i = 1, self%c
            lambda(i) = r(i)
         end do
         call self%solve(lambda)
      else
         do i = 1, self%c
            self%z(i) = r(self%normal%order(i))
         end do
         call self%solve(self%z)
         do i = 1, self%c
            lambda(self%normal%order(i)) = self%z(i)
         end do
      end if
   end subroutine multipliers

   !> Takes off multipliers what makes no reaction.
   subroutine minimum_norm(self, lambda)
      !> The solver, after `factorize`.
      class(ordered_solver_t), intent(inout) :: self
      !> Multipliers, replaced: (c).
      real(wp), intent(inout), contiguous :: lambda(:)
      real(wp), allocatable :: null(:, :), x(:)
      integer :: i, j, l

      if (self%rank == self%c) return
      ! Null vectors of S: one for each row that was left out, made up for by the others.
      allocate (null(self%c, self%c - self%rank), x(self%c), source=0.0_wp)
      j = 0
      do i = 1, self%c
         if (.not. self%is_left_out(i)) cycle
         j = j + 1
         x(:) = 0.0_wp
         do l = 1, size(self%normal%row)
            if (self%normal%column(l) == i) x(self%normal%row(l)) = -self%normal%s(self%c + l)
            if (self%normal%row(l) == i) x(self%normal%column(l)) = -self%normal%s(self%c + l)
         end do
         call self%solve(x)
         x(i) = 1.0_wp
         do l = 1, self%c
            null(self%normal%order(l), j) = x(l)
         end do
      end do
      call orthonormalize(null, j)
      call remove_components(null, j, lambda)
   end subroutine minimum_norm

   !> d := d - K^-1 A^T lambda.
   pure subroutine correction(self, a, lambda, d)
      !> The solver, after `factorize`.
      class(ordered_solver_t), intent(in) :: self
      !> The constraint matrix of `factorize`.
      type(csr_t), intent(in) :: a
      !> Multipliers: (c).
      real(wp), intent(in) :: lambda(self%c)
      !> What is corrected: (n).
      real(wp), intent(inout) :: d(self%n)

      if (self%identity .and. self%normal%diagonal) then
         call a%subtract_transposed(lambda, d)
      else
         call self%normal%a_kinv%subtract_transposed(lambda, d)
      end if
   end subroutine correction

end module taut_linalg_normal_solver_ordered
