!> L D L^T of a symmetric positive semi-definite band matrix; rows without a pivot are passed over.
module taut_linalg_banded_factor
   use taut_kinds, only: wp
   implicit none (type, external)
   private
   public :: banded_factor_t

   !> The factor of a matrix of n rows that has no entries farther than `width` from its diagonal.
   !!
   !! Rows whose pivots are too small against their own diagonal entries are passed over: their unknowns are set to zero.
   !!
   !! A tridiagonal matrix is eliminated from both ends at once, and its unknowns are found from the middle.
   type :: banded_factor_t
      integer :: n = 0, width = 0
      !> Reciprocals of the pivots; zero where a row is passed over.
      real(wp), allocatable :: reciprocal(:)
      !> Column j of L below the diagonal: (width, n). Of a tridiagonal matrix: (1, n - 1), the multiplier between rows j and
      !! j + 1.
      real(wp), allocatable :: l(:, :)
      real(wp), allocatable, private :: below(:)
   contains
      procedure :: init
      procedure :: factorize
      procedure :: solve
   end type banded_factor_t

contains

   !> Allocates the workspace; nothing is allocated afterwards.
   subroutine init(self, n, width)
      !> The factor.
      class(banded_factor_t), intent(out) :: self
      !> Rows.
      integer, intent(in) :: n
      !> Largest distance of an entry from the diagonal.
      integer, intent(in) :: width

      self%n = n
      self%width = width
      allocate (self%reciprocal(n), self%l(width, n), source=0.0_wp)
      if (width == 1) allocate (self%below(n), source=0.0_wp)
   end subroutine init

   !> Factorizes the matrix whose lower triangle is given entry by entry.
   pure subroutine factorize(self, s, row, column, least)
      !> The factor.
      class(banded_factor_t), intent(inout) :: self
      !> Entries, finite: the diagonal (n), then those below it.
      real(wp), intent(in), contiguous :: s(:)
      !> Row of each entry below the diagonal.
      integer, intent(in), contiguous :: row(:)
      !> Its column.
      integer, intent(in), contiguous :: column(:)
      !> Pivots up to this part of their diagonal entry are passed over: (n).
      real(wp), intent(in), contiguous :: least(:)
      integer :: i, j, k

      if (self%width == 1 .and. size(row) == self%n - 1) then
         ! Entry n + i lies between the rows i and i + 1.
         call factorize_tridiagonal(self%n, s, s(self%n + 1:), least, self%l, self%reciprocal)
         return
      end if
      do j = 1, self%n
         do i = 1, self%width
            self%l(i, j) = 0.0_wp
         end do
      end do
      do k = 1, size(row)
         self%l(row(k) - column(k), column(k)) = s(self%n + k)
      end do
      if (self%width == 1) then
         self%below(:) = self%l(1, :)
         call factorize_tridiagonal(self%n, s, self%below, least, self%l, self%reciprocal)
         return
      end if
      call factorize_band(self%n, self%width, s, least, self%l, self%reciprocal)
   end subroutine factorize

   !> Column by column: most are short, and no loop over them is worth unrolling.
   pure subroutine factorize_band(n, width, s, least, l, reciprocal)
      integer, intent(in) :: n, width
      real(wp), intent(in) :: s(n), least(n)
      real(wp), intent(inout) :: l(width, n), reciprocal(n)
      real(wp) :: factor, inverse
      integer :: i, j, k, last

      do j = 1, n
         reciprocal(j) = s(j)
      end do
      do j = 1, n
         if (reciprocal(j) <= least(j)*s(j)) then
            reciprocal(j) = 0.0_wp
            do i = 1, width
               l(i, j) = 0.0_wp
            end do
            cycle
         end if
         inverse = 1.0_wp/reciprocal(j)
         reciprocal(j) = inverse
         last = min(width, n - j)
         !GCC$ unroll 1
         do k = 1, last
            if (.not. abs(l(k, j)) > 0.0_wp) cycle
            factor = l(k, j)*inverse
            reciprocal(j + k) = reciprocal(j + k) - factor*l(k, j)
            !GCC$ unroll 1
            do i = k + 1, last
               l(i - k, j + k) = l(i - k, j + k) - factor*l(i, j)
            end do
         end do
         !GCC$ unroll 1
         do k = 1, last
            l(k, j) = l(k, j)*inverse
         end do
      end do
   end subroutine factorize_band

   !> From both ends to the middle: two rows at a time that do not wait for each other.
   pure subroutine factorize_tridiagonal(n, s, below, least, l, reciprocal)
      integer, intent(in) :: n
      real(wp), intent(in) :: s(*), below(*), least(*)
      real(wp), intent(inout) :: l(*), reciprocal(*)
      real(wp) :: down, up, e
      integer :: i, middle, j

      middle = (n + 1)/2
      down = s(1)
      up = s(n)
      j = n
      do i = 1, middle - 1
         if (down <= least(i)*s(i)) then
            reciprocal(i) = 0.0_wp
         else
            reciprocal(i) = 1.0_wp/down
         end if
         e = below(i)
         l(i) = e*reciprocal(i)
         down = s(i + 1) - e*l(i)
         if (j > middle + 1) then
            if (up <= least(j)*s(j)) then
               reciprocal(j) = 0.0_wp
            else
               reciprocal(j) = 1.0_wp/up
            end if
            j = j - 1
            e = below(j)
            l(j) = e*reciprocal(j + 1)
            up = s(j) - e*l(j)
         end if
      end do
      ! What is left: rows from the middle to j, of which there are one or two.
      do while (j > middle)
         reciprocal(j) = 0.0_wp
         if (up > least(j)*s(j)) reciprocal(j) = 1.0_wp/up
         j = j - 1
         e = below(j)
         l(j) = e*reciprocal(j + 1)
         if (j > middle) then
            up = s(j) - e*l(j)
         else
            down = down - e*l(j)
         end if
      end do
      reciprocal(middle) = 0.0_wp
      if (down > least(middle)*s(middle)) reciprocal(middle) = 1.0_wp/down
   end subroutine factorize_tridiagonal

   !> x := S^-1 x; zero where a row is passed over.
   pure subroutine solve(self, x)
      !> The factor.
      class(banded_factor_t), intent(in) :: self
      !> Right-hand side, replaced by the solution: (n).
      real(wp), intent(inout), contiguous :: x(:)

      if (self%width == 1) then
         call solve_tridiagonal(self%n, self%l, self%reciprocal, x)
         return
      end if
      call solve_band(self%n, self%width, self%l, self%reciprocal, x)
   end subroutine solve

   !> The same for a band: of each sum the term that was found last comes last, so that little has to be waited for. To the others
   !! a row that is passed over gives nothing.
   pure subroutine solve_band(n, width, l, reciprocal, x)
      integer, intent(in) :: n, width
      real(wp), intent(in) :: l(width, n), reciprocal(n)
      real(wp), intent(inout) :: x(n)
      integer :: i, j
      real(wp) :: t

      do j = 1, n
         if (.not. reciprocal(j) > 0.0_wp) cycle
         t = x(j)
         !GCC$ unroll 1
         do i = min(width, j - 1), 1, -1
            t = t - l(i, j - i)*x(j - i)
         end do
         x(j) = t
      end do
      do j = n, 1, -1
         x(j) = x(j)*reciprocal(j)
         if (.not. reciprocal(j) > 0.0_wp) cycle
         t = x(j)
         !GCC$ unroll 1
         do i = min(width, n - j), 1, -1
            t = t - l(i, j)*x(j + i)
         end do
         x(j) = t
      end do
   end subroutine solve_band

   !> The same for a tridiagonal matrix.
   pure subroutine solve_tridiagonal(n, l, reciprocal, x)
      integer, intent(in) :: n
      real(wp), intent(in) :: l(n), reciprocal(n)
      real(wp), intent(inout) :: x(n)
      integer :: i, j, middle
      real(wp) :: down, up

      middle = (n + 1)/2
      down = x(1)
      up = x(n)
      j = n - 1
      do i = 2, middle - 1
         down = x(i) - l(i - 1)*down
         x(i) = down
         if (j > middle) then
            up = x(j) - l(j)*up
            x(j) = up
            j = j - 1
         end if
      end do
      do i = j, middle + 1, -1
         up = x(i) - l(i)*up
         x(i) = up
      end do
      if (middle > 1) x(middle) = x(middle) - l(middle - 1)*x(middle - 1)
      if (middle < n) x(middle) = x(middle) - l(middle)*x(middle + 1)
      x(middle) = x(middle)*reciprocal(middle)
      down = x(middle)
      up = down
      j = middle + 1
      do i = middle - 1, 1, -1
         up = x(i)*reciprocal(i) - l(i)*up
         x(i) = up
         if (j <= n) then
            down = x(j)*reciprocal(j) - l(j - 1)*down
            x(j) = down
            j = j + 1
         end if
      end do
      do i = j, n
         down = x(i)*reciprocal(i) - l(i - 1)*down
         x(i) = down
      end do
   end subroutine solve_tridiagonal

end module taut_linalg_banded_factor
