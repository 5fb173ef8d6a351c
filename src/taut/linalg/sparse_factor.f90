!> L D L^T of a sparse symmetric positive semi-definite matrix; rows without a pivot are passed over.
module taut_linalg_sparse_factor
   use taut_kinds, only: wp
   implicit none (type, external)
   private
   public :: sparse_factor_t, sort

   !> The factor, row by row, with the entries that the elimination fills in found out once.
   !!
   !! Source: T.A. Davis, Algorithm 849: a concise sparse Cholesky factorization
   !! package, ACM Trans. Math. Softw. 31 (2005) 587-591.
   type :: sparse_factor_t
      integer :: n = 0
      !> Reciprocals of the pivots; zero where a row is passed over.
      real(wp), allocatable :: reciprocal(:)
      !> Entries of L by columns: first of each column, row of each.
      integer, allocatable :: first(:), row(:)
      !> Entries of L by rows: first of each row, ascending column of each, and its place among those by columns.
      integer, allocatable :: row_first(:), column(:), place(:)
      !> Entries of L below its diagonal, by columns; column j times pivot j is that of the matrix.
      real(wp), allocatable :: l(:)
      integer, allocatable, private :: given_first(:)
      real(wp), allocatable, private :: y(:)
   contains
      procedure :: init
      procedure :: work
      procedure :: factorize
      procedure :: solve
   end type sparse_factor_t

contains

   !> Finds out where the entries of L are; nothing is allocated afterwards.
   subroutine init(self, n, row, column)
      !> The factor.
      class(sparse_factor_t), intent(out) :: self
      !> Rows.
      integer, intent(in) :: n
      !> Row of each entry below the diagonal, row by row.
      integer, intent(in) :: row(:)
      !> Its column.
      integer, intent(in) :: column(:)
      integer :: flag(n), parent(n), count_of(n), e, i, k, m, round

      self%n = n
      allocate (self%given_first(n + 1), source=0)
      do e = 1, size(row)
         self%given_first(row(e) + 1) = self%given_first(row(e) + 1) + 1
      end do
      self%given_first(1) = 1
      do k = 1, n
         self%given_first(k + 1) = self%given_first(k + 1) + self%given_first(k)
      end do
      ! Row k of L has the entries that lie on the paths from those of the matrix to k in the elimination tree.
      parent = 0
      allocate (self%row_first(n + 1), self%first(n + 1), source=0)
      do round = 1, 2
         count_of = 0
         flag = 0
         m = 0
         do k = 1, n
            flag(k) = k
            self%row_first(k) = m + 1
            do e = self%given_first(k), self%given_first(k + 1) - 1
               i = column(e)
               do while (flag(i) /= k)
                  if (parent(i) == 0) parent(i) = k
                  flag(i) = k
                  m = m + 1
                  if (round == 2) self%column(m) = i
                  count_of(i) = count_of(i) + 1
                  i = parent(i)
               end do
            end do
            if (round == 2) call sort(self%column(self%row_first(k):m))
         end do
         self%row_first(n + 1) = m + 1
         if (round == 1) allocate (self%column(m), self%place(m), self%row(m), source=0)
      end do
      self%first(1) = 1
      do k = 1, n
         self%first(k + 1) = self%first(k) + count_of(k)
      end do
      count_of = 0
      do k = 1, n
         do e = self%row_first(k), self%row_first(k + 1) - 1
            i = self%column(e)
            self%place(e) = self%first(i) + count_of(i)
            self%row(self%place(e)) = k
            count_of(i) = count_of(i) + 1
         end do
      end do
      allocate (self%l(m), self%y(n), self%reciprocal(n), source=0.0_wp)
   end subroutine init

   !> Ascending order, by shell sort.
   pure subroutine sort(list)
      !> The numbers.
      integer, intent(inout) :: list(:)
      integer :: gap, i, j, t

      gap = size(list)/2
      do while (gap > 0)
         do i = gap + 1, size(list)
            t = list(i)
            j = i
            do while (j > gap)
               if (list(j - gap) <= t) exit
               list(j) = list(j - gap)
               j = j - gap
            end do
            list(j) = t
         end do
         gap = gap/2
      end do
   end subroutine sort

   !> Multiplications of a factorization.
   pure function work(self) result(number)
      !> The factor.
      class(sparse_factor_t), intent(in) :: self
      !> Their number.
      real(wp) :: number

      number = sum(real(self%first(2:) - self%first(:self%n), wp)**2)
   end function work

   !> Factorizes the matrix whose lower triangle is given entry by entry.
   pure subroutine factorize(self, s, column, least)
      !> The factor.
      class(sparse_factor_t), intent(inout) :: self
      !> Entries, finite: the diagonal (n), then those below it, row by row.
      real(wp), intent(in), contiguous :: s(:)
      !> Column of those below the diagonal.
      integer, intent(in), contiguous :: column(:)
      !> Pivots up to this part of their diagonal entry are passed over: (n).
      real(wp), intent(in), contiguous :: least(:)
      integer :: e, k
      real(wp) :: d

      do k = 1, self%n
         do e = self%given_first(k), self%given_first(k + 1) - 1
            self%y(column(e)) = s(self%n + e)
         end do
         d = s(k)
         call eliminate_row(self%row_first(k), self%row_first(k + 1) - 1, self%column, self%place, self%first, self%row, &
                            self%reciprocal, self%l, self%y, d)
         if (d <= least(k)*s(k)) then
            self%reciprocal(k) = 0.0_wp
         else
            self%reciprocal(k) = 1.0_wp/d
         end if
      end do
   end subroutine factorize

   !> A row of L from what it is of S, in y, and the pivot from its diagonal entry. Most columns are short: no loop over them is
   !! worth unrolling.
   pure subroutine eliminate_row(begin, last, column, place, first, row, reciprocal, l, y, d)
      integer, intent(in) :: begin, last, column(*), place(*), first(*), row(*)
      real(wp), intent(in) :: reciprocal(*)
      real(wp), intent(inout) :: l(*), y(*), d
      integer :: e, p
      real(wp) :: t

      do e = begin, last
         t = y(column(e))
         y(column(e)) = 0.0_wp
         !GCC$ unroll 1
         do p = first(column(e)), place(e) - 1
            y(row(p)) = y(row(p)) - l(p)*t
         end do
         l(place(e)) = t*reciprocal(column(e))
         d = d - t*l(place(e))
      end do
   end subroutine eliminate_row

   !> x := S^-1 x; zero where a row is passed over.
   pure subroutine solve(self, x)
      !> The factor.
      class(sparse_factor_t), intent(in) :: self
      !> Right-hand side, replaced by the solution: (n).
      real(wp), intent(inout), contiguous :: x(:)

      call substitute(self%n, self%first, self%row, self%l, self%reciprocal, x)
   end subroutine solve

   !> The same with its arrays.
   pure subroutine substitute(n, first, row, l, reciprocal, x)
      integer, intent(in) :: n, first(n + 1), row(*)
      real(wp), intent(in) :: l(*), reciprocal(n)
      real(wp), intent(inout) :: x(n)
      integer :: j, p
      real(wp) :: t

      do j = 1, n
         t = x(j)
         !GCC$ unroll 1
         do p = first(j), first(j + 1) - 1
            x(row(p)) = x(row(p)) - l(p)*t
         end do
      end do
      do j = n, 1, -1
         t = x(j)*reciprocal(j)
         !GCC$ unroll 1
         do p = first(j), first(j + 1) - 1
            t = t - l(p)*x(row(p))
         end do
         x(j) = t
      end do
   end subroutine substitute

end module taut_linalg_sparse_factor
