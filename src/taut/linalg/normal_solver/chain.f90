!> Rows of a chain: each has a pair of columns in common with the next one and with no other, so that S = A K^-1 A^T is
!! tridiagonal. S is made and factorized in one pass, and a vector is projected in two.
!!
!! Row i has four entries, those at 4 (i - 1) + 1 - missing and so on in the columns 2 (i - 1) + 1 - missing and so on; the first
!! row may miss the first two, the last row the last two. K is diagonal. The elimination goes from both ends to the middle:
!! two recurrences that do not wait for each other, with all else done while they wait for themselves.
module taut_linalg_normal_solver_chain
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_kinds, only: wp
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_csr, only: csr_t
   use taut_linalg_normal_solver_banded, only: banded_solver_t
   implicit none (type, external)
   private
   public :: chain_solver_t, are_chained

   !> S within a band of one, by passes of its own.
   type, extends(banded_solver_t) :: chain_solver_t
      !> How many entries the first row misses.
      integer, private :: missing = 0
   contains
      procedure :: init
      procedure :: factorize
      procedure :: project
   end type chain_solver_t

contains

   !> Allocates the workspace.
   subroutine init(self, a, c, sizes)
      !> The solver.
      class(chain_solver_t), intent(inout) :: self
      !> A matrix with the pattern of A, for which `are_chained` holds.
      type(csr_t), intent(in) :: a
      !> All of its rows are used.
      integer, intent(in) :: c
      !> Sizes of the blocks of K, all 1.
      integer, intent(in) :: sizes(:)

      call self%banded_solver_t%init(a, c, sizes)
      self%missing = 4 - (a%first(2) - a%first(1))
   end subroutine init

   !> Takes a new A, and K factorized.
   subroutine factorize(self, a, k, identity, info)
      !> The solver.
      class(chain_solver_t), intent(inout) :: self
      !> The constraint matrix.
      type(csr_t), intent(in) :: a
      !> The metric, factorized; not used if it is the identity.
      type(block_diagonal_t), intent(in) :: k
      !> Whether K = I.
      logical, intent(in) :: identity
      !> 0, or 1 if there are entries that are not finite.
      integer, intent(out) :: info

      self%identity = identity
      if (self%is_new) call self%set_least()
      if (identity) then
         call factorize_chained(self%c, self%missing, self%n, a%values, a%values, self%least, self%normal%s, self%band%l, &
                                self%band%reciprocal, info)
      else
         call k%divide(self%normal%a_kinv%column, a%values, self%normal%a_kinv%values)
         call factorize_chained(self%c, self%missing, self%n, a%values, self%normal%a_kinv%values, self%least, self%normal%s, &
                                self%band%l, self%band%reciprocal, info)
      end if
      if (info /= 0 .or. .not. self%is_new) return
      call self%judge(self%weakest())
      call self%set_least()
   end subroutine factorize

   !> d := d - K^-1 A^T lambda with lambda = S^-1 r, r = A d - b.
   subroutine project(self, a, b, d, r, lambda)
      !> The solver, after `factorize`.
      class(chain_solver_t), intent(inout) :: self
      !> The constraint matrix of `factorize`.
      type(csr_t), intent(in) :: a
      !> What A d shall be: (c).
      real(wp), intent(in) :: b(self%c)
      !> What is projected: (n).
      real(wp), intent(inout) :: d(self%n)
      !> The violation: (c).
      real(wp), intent(inout) :: r(self%c)
      !> The multipliers, those of rows that are not kept zero: (c).
      real(wp), intent(inout) :: lambda(self%c)

      if (self%identity) then
         call project_chained(self%c, self%missing, self%n, a%values, a%values, self%band%l, self%band%reciprocal, &
                              b, d, r, lambda)
      else
         call project_chained(self%c, self%missing, self%n, a%values, self%normal%a_kinv%values, self%band%l, &
                              self%band%reciprocal, b, d, r, lambda)
      end if
   end subroutine project

   !> Whether rows are those of a chain, of three rows at least.
   pure logical function are_chained(a)
      !> A matrix with the pattern.
      type(csr_t), intent(in) :: a
      integer :: i, k, missing

      are_chained = .false.
      if (a%full .or. a%c < 3) return
      missing = 4 - (a%first(2) - a%first(1))
      if (missing /= 0 .and. missing /= 2) return
      if (a%n /= 2*(a%c + 1) - missing .and. a%n /= 2*a%c - missing) return
      do i = 1, a%c
         if (a%first(i + 1) /= min(4*i - missing, size(a%column)) + 1) return
         do k = a%first(i), a%first(i + 1) - 1
            if (a%column(k) /= k - 2*(i - 1)) return
         end do
      end do
      are_chained = size(a%column) == 4*a%c - missing - (2*(a%c + 1) - missing - a%n)
   end function are_chained

   !> S and its factor L D L^T, eliminated from both ends as `banded_factor_t` does it.
   pure subroutine factorize_chained(c, missing, n, a, a_kinv, least, s, l, reciprocal, info)
      !> Rows, missing entries of the first one, columns.
      integer, intent(in) :: c, missing, n
      !> Entries of A and of A K^-1.
      real(wp), intent(in) :: a(*), a_kinv(*)
      !> Pivots up to this part of their diagonal entry are passed over: (c).
      real(wp), intent(in) :: least(*)
      !> S: the diagonal (c), then what is below it (c - 1).
      real(wp), intent(inout) :: s(*)
      !> L, the multipliers between neighbors: (c - 1); reciprocals of the pivots, zero where a row is passed over: (c).
      real(wp), intent(inout) :: l(*), reciprocal(*)
      !> 0, or 1 if an entry of A is not finite.
      integer, intent(out) :: info
      real(wp) :: below, down, e, lost, of_down, of_up, q, up
      integer :: i, j, k, middle

      info = 1
      middle = (c + 1)/2
      k = 4 - missing
      of_down = a(k - 1)*a_kinv(k - 1) + a(k)*a_kinv(k)
      if (missing == 0) of_down = of_down + (a(1)*a_kinv(1) + a(2)*a_kinv(2))
      k = 4*(c - 1) - missing
      of_up = a(k + 1)*a_kinv(k + 1) + a(k + 2)*a_kinv(k + 2)
      if (n > 2*c - missing) of_up = of_up + (a(k + 3)*a_kinv(k + 3) + a(k + 4)*a_kinv(k + 4))
      if (.not. (ieee_is_finite(of_down) .and. ieee_is_finite(of_up))) return
      s(1) = of_down
      s(c) = of_up
      down = of_down
      up = of_up
      lost = 0.0_wp
      j = c
      if (mod(c, 2) == 0) then
         call invert(up, least(c)*of_up, q)
         reciprocal(c) = q
         j = c - 1
         call multiply_rows(a, a_kinv, 4*j - missing, -4, of_up, below)
         if (.not. ieee_is_finite(of_up)) return
         s(j) = of_up
         s(c + j) = below
         lost = (below*below)*q
         l(j) = below*q
         up = of_up - lost
      end if
      do i = 1, middle - 1
         call invert(down, least(i)*of_down, q)
         reciprocal(i) = q
         call multiply_rows(a, a_kinv, 4*i - missing, 0, of_down, e)
         s(i + 1) = of_down
         s(c + i) = e
         ! The next pivot waits for as few operations as possible.
         down = of_down - (e*e)*q
         l(i) = e*q
         call invert(up, least(j)*of_up, q)
         reciprocal(j) = q
         j = j - 1
         call multiply_rows(a, a_kinv, 4*j - missing, -4, of_up, below)
         s(j) = of_up
         s(c + j) = below
         lost = (below*below)*q
         l(j) = below*q
         up = of_up - lost
         if (.not. (ieee_is_finite(of_down) .and. ieee_is_finite(of_up))) return
      end do
      ! Both neighbors of the middle are eliminated.
      call invert(down - lost, least(middle)*of_up, reciprocal(middle))
      info = 0
   end subroutine factorize_chained

   !> 1/pivot, or zero.
   pure subroutine invert(pivot, least, value)
      real(wp), intent(in) :: pivot, least
      real(wp), intent(out) :: value

      if (pivot > least) then
         value = 1.0_wp/pivot
      else
         value = 0.0_wp
      end if
   end subroutine invert

   !> The entry of S between two neighbors, the later of which begins after k; and that on the diagonal, of one of the two.
   pure subroutine multiply_rows(a, a_kinv, k, begin, diagonal, below)
      real(wp), intent(in) :: a(*), a_kinv(*)
      integer, intent(in) :: k, begin
      real(wp), intent(out) :: diagonal, below
      integer :: m

      m = k + begin
      diagonal = (a(m + 1)*a_kinv(m + 1) + a(m + 3)*a_kinv(m + 3)) + (a(m + 2)*a_kinv(m + 2) + a(m + 4)*a_kinv(m + 4))
      below = a(k - 1)*a_kinv(k + 1) + a(k)*a_kinv(k + 2)
   end subroutine multiply_rows

   !> d := d - K^-1 A^T lambda with lambda = S^-1 r, r = A d - b.
   pure subroutine project_chained(c, missing, n, a, a_kinv, l, reciprocal, b, d, r, lambda)
      !> Rows, missing entries of the first one, columns.
      integer, intent(in) :: c, missing, n
      !> Entries of A and of A K^-1.
      real(wp), intent(in) :: a(*), a_kinv(*)
      !> What `factorize_chained` has found.
      real(wp), intent(in) :: l(*), reciprocal(*)
      !> What A d shall be: (c).
      real(wp), intent(in) :: b(*)
      !> What is projected: (n).
      real(wp), intent(inout) :: d(*)
      !> The violation and the multipliers: (c).
      real(wp), intent(inout) :: r(*), lambda(*)
      real(wp) :: down, t, up, x, y
      integer :: i, j, k, m, middle

      middle = (c + 1)/2
      ! To the middle: lambda holds the solution with L.
      k = 4 - missing
      t = (a(k - 1)*d(3 - missing) + a(k)*d(4 - missing)) - b(1)
      if (missing == 0) t = t + (a(1)*d(1) + a(2)*d(2))
      r(1) = t
      lambda(1) = t
      down = t
      k = 4*(c - 1) - missing
      m = 2*(c - 1) - missing
      t = (a(k + 1)*d(m + 1) + a(k + 2)*d(m + 2)) - b(c)
      if (n > 2*c - missing) t = t + (a(k + 3)*d(m + 3) + a(k + 4)*d(m + 4))
      r(c) = t
      lambda(c) = t
      up = t
      j = c - 1
      if (mod(c, 2) == 0) then
         t = residual(j)
         r(j) = t
         up = t - l(j)*up
         lambda(j) = up
         j = j - 1
      end if
      do i = 2, middle - 1
         k = 4*(i - 1) - missing
         m = 2*(i - 1) - missing
         t = ((a(k + 1)*d(m + 1) + a(k + 3)*d(m + 3)) + (a(k + 2)*d(m + 2) + a(k + 4)*d(m + 4))) - b(i)
         r(i) = t
         down = t - l(i - 1)*down
         lambda(i) = down
         k = 4*(j - 1) - missing
         m = 2*(j - 1) - missing
         t = ((a(k + 1)*d(m + 1) + a(k + 3)*d(m + 3)) + (a(k + 2)*d(m + 2) + a(k + 4)*d(m + 4))) - b(j)
         r(j) = t
         up = t - l(j)*up
         lambda(j) = up
         j = j - 1
      end do
      t = residual(middle)
      r(middle) = t
      t = ((t - l(middle - 1)*down) - l(middle)*up)*reciprocal(middle)
      lambda(middle) = t
      ! And back: a pair of d is done when both of its multipliers are known.
      up = t
      down = t
      j = middle
      do i = middle - 1, 1, -1
         k = 4*i - missing
         m = 2*i - missing
         x = lambda(i)*reciprocal(i) - l(i)*up
         d(m + 1) = d(m + 1) - (a_kinv(k - 1)*x + a_kinv(k + 1)*up)
         d(m + 2) = d(m + 2) - (a_kinv(k)*x + a_kinv(k + 2)*up)
         lambda(i) = x
         up = x
         k = 4*j - missing
         m = 2*j - missing
         y = lambda(j + 1)*reciprocal(j + 1) - l(j)*down
         d(m + 1) = d(m + 1) - (a_kinv(k - 1)*down + a_kinv(k + 1)*y)
         d(m + 2) = d(m + 2) - (a_kinv(k)*down + a_kinv(k + 2)*y)
         lambda(j + 1) = y
         down = y
         j = j + 1
      end do
      if (j < c) then
         k = 4*j - missing
         m = 2*j - missing
         y = lambda(c)*reciprocal(c) - l(j)*down
         d(m + 1) = d(m + 1) - (a_kinv(k - 1)*down + a_kinv(k + 1)*y)
         d(m + 2) = d(m + 2) - (a_kinv(k)*down + a_kinv(k + 2)*y)
         lambda(c) = y
      end if
      if (missing == 0) then
         d(1) = d(1) - a_kinv(1)*lambda(1)
         d(2) = d(2) - a_kinv(2)*lambda(1)
      end if
      if (n > 2*c - missing) then
         k = 4*c - missing
         m = 2*c - missing
         d(m + 1) = d(m + 1) - a_kinv(k - 1)*lambda(c)
         d(m + 2) = d(m + 2) - a_kinv(k)*lambda(c)
      end if

   contains

      !> A d - b in a row with four entries.
      pure function residual(row) result(value)
         integer, intent(in) :: row
         real(wp) :: value
         integer :: p, q

         p = 4*(row - 1) - missing
         q = 2*(row - 1) - missing
         value = ((a(p + 1)*d(q + 1) + a(p + 3)*d(q + 3)) + (a(p + 2)*d(q + 2) + a(p + 4)*d(q + 4))) - b(row)
      end function residual

   end subroutine project_chained

end module taut_linalg_normal_solver_chain
