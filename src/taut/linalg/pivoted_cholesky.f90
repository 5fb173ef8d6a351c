!> Cholesky's factorization with pivoting of a symmetric positive semi-definite matrix: its rank at the price of its factor.
module taut_linalg_pivoted_cholesky
   use taut_kinds, only: wp
   use taut_linalg_lapack, only: dpstrf, dtrtrs
   implicit none (type, external)
   private
   public :: pivoted_cholesky_t, orthonormalize, remove_components

   !> Up to this order, loops are faster than calls of LAPACK.
   integer, parameter :: small = 48

   !> P^T S P = L L^T with pivots that do not increase, and an orthonormal basis of the null space where there is one.
   type :: pivoted_cholesky_t
      !> Squares of the diagonal of L: (n); zero beyond the last one that was found.
      real(wp), allocatable :: pivot(:)
      integer, private :: n = 0, rank = 0
      real(wp), allocatable, private :: l(:, :), reciprocal(:), null(:, :), x(:), work(:)
      integer, allocatable, private :: order(:)
   contains
      procedure :: init
      procedure :: factorize
      procedure :: set_rank
      procedure :: solve
   end type pivoted_cholesky_t

contains

   !> Allocates the workspace; nothing is allocated afterwards.
   subroutine init(self, n)
      !> The solver.
      class(pivoted_cholesky_t), intent(inout) :: self
      !> Order of the matrices.
      integer, intent(in) :: n

      self%n = n
      if (allocated(self%l)) deallocate (self%pivot, self%l, self%reciprocal, self%null, self%x, self%work, self%order)
      allocate (self%pivot(n), self%l(n, n), self%reciprocal(n), self%null(n, n), self%x(n), self%work(2*n), source=0.0_wp)
      allocate (self%order(n), source=0)
   end subroutine init

   !> Factorizes diag(scale) S diag(scale), with pivots down to a size below which there is round-off alone.
   subroutine factorize(self, s, scale, least)
      !> The solver; the result is in `pivot`.
      class(pivoted_cholesky_t), intent(inout) :: self
      !> The matrix: (n, n), finite; the lower triangle is read.
      real(wp), intent(in) :: s(:, :)
      !> Factors of rows and columns: (n).
      real(wp), intent(in) :: scale(:)
      !> Pivots up to this are zero.
      real(wp), intent(in) :: least
      integer :: i, info, j, n, rank

      n = self%n
      do j = 1, n
         do i = j, n
            self%l(i, j) = scale(i)*s(i, j)*scale(j)
         end do
      end do
      if (n <= small) then
         call factorize_small(n, self%l, self%order, least, rank)
      else
         call dpstrf('L', n, self%l, n, self%order, rank, least, self%work, info)
      end if
      do j = 1, n
         self%pivot(j) = 0.0_wp
         if (j <= rank) self%pivot(j) = self%l(j, j)**2
      end do
   end subroutine factorize

   !> The same, column by column, in place.
   pure subroutine factorize_small(n, l, order, least, rank)
      integer, intent(in) :: n
      real(wp), intent(inout) :: l(n, n)
      integer, intent(out) :: order(n), rank
      real(wp), intent(in) :: least
      integer :: i, j, k, p
      real(wp) :: t

      do i = 1, n
         order(i) = i
      end do
      do j = 1, n
         p = j
         do i = j + 1, n
            if (l(i, i) > l(p, p)) p = i
         end do
         if (l(p, p) <= least) then
            rank = j - 1
            return
         end if
         if (p /= j) then
            ! Rows and columns j and p change places, in the lower triangle.
            i = order(p)
            order(p) = order(j)
            order(j) = i
            t = l(p, p)
            l(p, p) = l(j, j)
            l(j, j) = t
            do k = 1, j - 1
               t = l(p, k)
               l(p, k) = l(j, k)
               l(j, k) = t
            end do
            do k = j + 1, p - 1
               t = l(p, k)
               l(p, k) = l(k, j)
               l(k, j) = t
            end do
            do k = p + 1, n
               t = l(k, p)
               l(k, p) = l(k, j)
               l(k, j) = t
            end do
         end if
         t = sqrt(l(j, j))
         l(j, j) = t
         t = 1.0_wp/t
         do i = j + 1, n
            l(i, j) = l(i, j)*t
         end do
         do k = j + 1, n
            do i = k, n
               l(i, k) = l(i, k) - l(i, j)*l(k, j)
            end do
         end do
      end do
      rank = n
   end subroutine factorize_small

   !> States how many pivots count, and finds the null space of S: diag(scale) P [-L1^-T L2^T; I].
   subroutine set_rank(self, rank, scale)
      !> The solver, after `factorize`.
      class(pivoted_cholesky_t), intent(inout) :: self
      !> Their number.
      integer, intent(in) :: rank
      !> Factors of rows and columns: (n).
      real(wp), intent(in) :: scale(:)
      integer :: i, j, k
      real(wp) :: t

      self%rank = rank
      do i = 1, rank
         self%reciprocal(i) = 1.0_wp/self%l(i, i)
      end do
      do j = 1, self%n - rank
         do i = 1, rank
            self%x(i) = -self%l(rank + j, i)
         end do
         do i = rank, 1, -1
            t = self%x(i)
            do k = i + 1, rank
               t = t - self%l(k, i)*self%x(k)
            end do
            self%x(i) = t*self%reciprocal(i)
         end do
         self%null(:, j) = 0.0_wp
         do i = 1, rank
            self%null(self%order(i), j) = self%x(i)*scale(self%order(i))
         end do
         self%null(self%order(rank + j), j) = scale(self%order(rank + j))
      end do
      if (rank < self%n) call orthonormalize(self%null, self%n - rank)
   end subroutine set_rank

   !> x = S^+ r.
   subroutine solve(self, scale, r, x)
      !> The solver, after `set_rank`.
      class(pivoted_cholesky_t), intent(inout) :: self
      !> Factors of rows and columns: (n).
      real(wp), intent(in) :: scale(:)
      !> Right-hand side: (n).
      real(wp), intent(in), contiguous :: r(:)
      !> Minimum-norm least-squares solution: (n).
      real(wp), intent(out), contiguous :: x(:)
      integer :: i, info, j, n, rank
      real(wp) :: t

      n = self%n
      rank = self%rank
      do i = 1, n
         x(i) = r(i)
      end do
      if (rank < n) call remove_components(self%null, n - rank, x)
      do i = 1, rank
         self%x(i) = scale(self%order(i))*x(self%order(i))
      end do
      if (rank <= small) then
         do j = 1, rank
            t = self%x(j)*self%reciprocal(j)
            self%x(j) = t
            do i = j + 1, rank
               self%x(i) = self%x(i) - self%l(i, j)*t
            end do
         end do
         do j = rank, 1, -1
            t = self%x(j)
            do i = j + 1, rank
               t = t - self%l(i, j)*self%x(i)
            end do
            self%x(j) = t*self%reciprocal(j)
         end do
      else
         call dtrtrs('L', 'N', 'N', rank, 1, self%l, n, self%x, n, info)
         call dtrtrs('L', 'T', 'N', rank, 1, self%l, n, self%x, n, info)
      end if
      do i = 1, rank
         x(self%order(i)) = scale(self%order(i))*self%x(i)
      end do
      do i = rank + 1, n
         x(self%order(i)) = 0.0_wp
      end do
      if (rank < n) call remove_components(self%null, n - rank, x)
   end subroutine solve

   !> Makes the first columns of a matrix, which are independent, orthonormal: Gram-Schmidt, twice.
   pure subroutine orthonormalize(q, columns)
      !> The matrix.
      real(wp), intent(inout), contiguous :: q(:, :)
      !> How many.
      integer, intent(in) :: columns
      integer :: j, k, round
      real(wp) :: t

      do j = 1, columns
         ! Columns may be of any size, so that their squares would overflow.
         q(:, j) = q(:, j)/maxval(abs(q(:, j)))
         do round = 1, 2
            do k = 1, j - 1
               t = dot_product(q(:, k), q(:, j))
               q(:, j) = q(:, j) - t*q(:, k)
            end do
            t = sqrt(dot_product(q(:, j), q(:, j)))
            q(:, j) = q(:, j)/t
         end do
      end do
   end subroutine orthonormalize

   !> x := x - Q Q^T x with the first columns of Q.
   pure subroutine remove_components(q, columns, x)
      !> Orthonormal columns.
      real(wp), intent(in), contiguous :: q(:, :)
      !> How many.
      integer, intent(in) :: columns
      !> What is left of it.
      real(wp), intent(inout), contiguous :: x(:)
      integer :: i, j
      real(wp) :: t

      do j = 1, columns
         t = 0.0_wp
         do i = 1, size(x)
            t = t + q(i, j)*x(i)
         end do
         do i = 1, size(x)
            x(i) = x(i) - t*q(i, j)
         end do
      end do
   end subroutine remove_components

end module taut_linalg_pivoted_cholesky
