!> Matrices stored by rows, all entries or those of a pattern: constraint matrices.
module taut_linalg_csr
   use taut_kinds, only: wp
   implicit none (type, external)
   private
   public :: csr_t

   !> A matrix of c rows and n columns. The values are contiguous, row after row.
   type :: csr_t
      !> Rows and columns.
      integer :: c = 0, n = 0
      !> Whether all entries are stored, so that the values are those of the transposed matrix: (n, c).
      logical :: full = .true.
      !> First entry of each row, and the number of entries plus one at the end: (c + 1); not used if `full`.
      integer, allocatable :: first(:)
      !> Column of each entry, ascending within a row; not used if `full`.
      integer, allocatable :: column(:)
      !> The entries.
      real(wp), allocatable :: values(:)
      !> Columns that always come together, as those of a point: all rows are made of groups of so many, 1 to 3.
      integer :: group = 1
      !> The groups column by column: first of each column; row of each, and place of its first entry in `values`.
      integer, allocatable, private :: column_first(:), group_row(:), place(:)
      !> Room for all entries in column order, (c, n), where they have to be given like that; only if `full`.
      real(wp), allocatable :: all_entries(:, :)
   contains
      procedure :: init
      procedure :: set_pattern
      procedure :: set_dense
      procedure :: dense
      procedure :: multiply
      procedure :: subtract_transposed
   end type csr_t

contains

   !> Lays out a matrix with all its entries, zero at first.
   subroutine init(self, c, n)
      !> The matrix.
      class(csr_t), intent(out) :: self
      !> Number of rows.
      integer, intent(in) :: c
      !> Number of columns.
      integer, intent(in) :: n

      self%c = c
      self%n = n
      self%full = .true.
      allocate (self%first(0), self%column(0))
      allocate (self%values(c*n), self%all_entries(c, n), source=0.0_wp)
   end subroutine init

   !> Lays out a matrix with the entries of a pattern, zero at first.
   subroutine set_pattern(self, n, first, column)
      !> The matrix.
      class(csr_t), intent(out) :: self
      !> Columns.
      integer, intent(in) :: n
      !> First entry of each row, and the number of entries plus one at the end: (c + 1).
      integer, intent(in) :: first(:)
      !> Column of each entry, ascending within a row.
      integer, intent(in) :: column(:)

      self%c = size(first) - 1
      self%n = n
      self%full = .false.
      allocate (self%first, source=first)
      allocate (self%column, source=column)
      allocate (self%values(size(column)), source=0.0_wp)
      self%group = 3
      do while (.not. made_of_groups(self, self%group))
         self%group = self%group - 1
      end do
      call find_groups(self)
   end subroutine set_pattern

   !> Whether the columns of all rows are whole groups of a size, counted from the first column of the matrix.
   pure function made_of_groups(self, group) result(made)
      type(csr_t), intent(in) :: self
      integer, intent(in) :: group
      logical :: made
      integer :: i, k

      made = group == 1
      if (made .or. mod(self%n, group) /= 0) return
      do i = 1, self%c
         if (mod(self%first(i + 1) - self%first(i), group) /= 0) return
         do k = self%first(i), self%first(i + 1) - 1, group
            if (mod(self%column(k) - 1, group) /= 0) return
            if (self%column(k + group - 1) /= self%column(k) + group - 1) return
         end do
      end do
      made = .true.
   end function made_of_groups

   !> The groups column by column.
   subroutine find_groups(self)
      type(csr_t), intent(inout) :: self
      integer :: g, i, k, l, groups

      g = self%group
      groups = size(self%column)/g
      allocate (self%group_row(groups), self%place(groups))
      allocate (self%column_first(self%n/g + 1), source=0)
      do k = 1, groups
         l = (self%column((k - 1)*g + 1) - 1)/g + 1
         self%column_first(l + 1) = self%column_first(l + 1) + 1
      end do
      self%column_first(1) = 1
      do l = 1, self%n/g
         self%column_first(l + 1) = self%column_first(l + 1) + self%column_first(l)
      end do
      do i = 1, self%c
         do k = (self%first(i) - 1)/g + 1, (self%first(i + 1) - 1)/g
            l = (self%column((k - 1)*g + 1) - 1)/g + 1
            self%group_row(self%column_first(l)) = i
            self%place(self%column_first(l)) = (k - 1)*g + 1
            self%column_first(l) = self%column_first(l) + 1
         end do
      end do
      do l = self%n/g, 1, -1
         self%column_first(l + 1) = self%column_first(l)
      end do
      self%column_first(1) = 1
   end subroutine find_groups

   !> Takes the entries from those of a dense matrix.
   pure subroutine set_dense(self, a)
      !> The matrix.
      class(csr_t), intent(inout) :: self
      !> All entries: (c, n).
      real(wp), intent(in) :: a(self%c, self%n)
      integer :: i, j, k

      if (self%full) then
         do i = 1, self%c
            do j = 1, self%n
               self%values((i - 1)*self%n + j) = a(i, j)
            end do
         end do
         return
      end if
      do i = 1, self%c
         do k = self%first(i), self%first(i + 1) - 1
            self%values(k) = a(i, self%column(k))
         end do
      end do
   end subroutine set_dense

   !> The matrix with all its zeros.
   pure function dense(self) result(a)
      !> The matrix.
      class(csr_t), intent(in) :: self
      !> All entries: (c, n).
      real(wp) :: a(self%c, self%n)
      integer :: i, k

      if (self%full) then
         a = transpose(reshape(self%values, [self%n, self%c]))
         return
      end if
      a = 0.0_wp
      do i = 1, self%c
         do k = self%first(i), self%first(i + 1) - 1
            a(i, self%column(k)) = self%values(k)
         end do
      end do
   end function dense

   !> r = A v - b for the first rows, as many as r has; b is zero if it is not given.
   pure subroutine multiply(self, v, r, b)
      !> The matrix.
      class(csr_t), intent(in) :: self
      !> (n).
      real(wp), intent(in), contiguous :: v(:)
      !> (at most c).
      real(wp), intent(out), contiguous :: r(:)
      !> (as r).
      real(wp), intent(in), contiguous, optional :: b(:)
      real(wp) :: t
      integer :: i, j, k

      if (self%full) then
         do i = 1, size(r)
            t = 0.0_wp
            if (present(b)) t = -b(i)
            k = (i - 1)*self%n
            do j = 1, self%n
               t = t + self%values(k + j)*v(j)
            end do
            r(i) = t
         end do
         return
      end if
      if (self%group == 2) then
         call multiply_pairs(size(r), self%first, self%column, self%values, v, r)
      else if (self%group == 3) then
         call multiply_threes(size(r), self%first, self%column, self%values, v, r)
      else
         call multiply_rows(size(r), self%first, self%column, self%values, v, r)
      end if
      if (present(b)) then
         do i = 1, size(r)
            r(i) = r(i) - b(i)
         end do
      end if
   end subroutine multiply

   !> r = A v with groups of two, as those of points in a plane.
   pure subroutine multiply_pairs(rows, first, column, values, v, r)
      integer, intent(in) :: rows
      integer, intent(in) :: first(*), column(*)
      real(wp), intent(in) :: values(*), v(*)
      real(wp), intent(inout) :: r(*)
      real(wp) :: t1, t2
      integer :: i, j, k, l

      do i = 1, rows
         k = first(i)
         if (first(i + 1) - k == 4) then
            ! Most constraints join two things.
            j = column(k)
            l = column(k + 2)
            t1 = values(k)*v(j) + values(k + 2)*v(l)
            t2 = values(k + 1)*v(j + 1) + values(k + 3)*v(l + 1)
         else
            t1 = 0.0_wp
            t2 = 0.0_wp
            do k = first(i), first(i + 1) - 1, 2
               j = column(k)
               t1 = t1 + values(k)*v(j)
               t2 = t2 + values(k + 1)*v(j + 1)
            end do
         end if
         r(i) = t1 + t2
      end do
   end subroutine multiply_pairs

   !> r = A v with groups of three, as those of bodies in space.
   pure subroutine multiply_threes(rows, first, column, values, v, r)
      integer, intent(in) :: rows
      integer, intent(in) :: first(*), column(*)
      real(wp), intent(in) :: values(*), v(*)
      real(wp), intent(inout) :: r(*)
      real(wp) :: t
      integer :: i, j, k

      do i = 1, rows
         t = 0.0_wp
         do k = first(i), first(i + 1) - 1, 3
            j = column(k)
            t = t + values(k)*v(j)
            t = t + values(k + 1)*v(j + 1)
            t = t + values(k + 2)*v(j + 2)
         end do
         r(i) = t
      end do
   end subroutine multiply_threes

   !> r = A v.
   pure subroutine multiply_rows(rows, first, column, values, v, r)
      integer, intent(in) :: rows
      integer, intent(in) :: first(*), column(*)
      real(wp), intent(in) :: values(*), v(*)
      real(wp), intent(inout) :: r(*)
      real(wp) :: t
      integer :: i, k

      do i = 1, rows
         t = 0.0_wp
         !GCC$ unroll 1
         do k = first(i), first(i + 1) - 1
            t = t + values(k)*v(column(k))
         end do
         r(i) = t
      end do
   end subroutine multiply_rows

   !> d := d - A^T lambda with the first rows, as many as lambda has.
   pure subroutine subtract_transposed(self, lambda, d)
      !> The matrix.
      class(csr_t), intent(in) :: self
      !> (at most c).
      real(wp), intent(in), contiguous :: lambda(:)
      !> (n).
      real(wp), intent(inout), contiguous :: d(:)
      integer :: i, j, k

      if (self%full) then
         do i = 1, size(lambda)
            k = (i - 1)*self%n
            do j = 1, self%n
               d(j) = d(j) - self%values(k + j)*lambda(i)
            end do
         end do
         return
      end if
      if (size(lambda) < self%c) then
         do i = 1, size(lambda)
            do k = self%first(i), self%first(i + 1) - 1
               d(self%column(k)) = d(self%column(k)) - self%values(k)*lambda(i)
            end do
         end do
         return
      end if
      if (self%group == 2) then
         call subtract_columns_of_pairs(self%n/2, self%column_first, self%group_row, self%place, self%values, lambda, d)
      else
         call subtract_columns(self%group, self%n/self%group, self%column_first, self%group_row, self%place, self%values, lambda, d)
      end if
   end subroutine subtract_transposed

   !> d := d - A^T lambda column by column with groups of two.
   pure subroutine subtract_columns_of_pairs(columns, first, row, place, values, lambda, d)
      integer, intent(in) :: columns
      integer, intent(in) :: first(*), row(*), place(*)
      real(wp), intent(in) :: values(*), lambda(*)
      real(wp), intent(inout) :: d(2, *)
      real(wp) :: t1, t2
      integer :: j, k, p, q

      do j = 1, columns
         k = first(j)
         if (first(j + 1) - k == 2) then
            p = place(k)
            q = place(k + 1)
            t1 = values(p)*lambda(row(k)) + values(q)*lambda(row(k + 1))
            t2 = values(p + 1)*lambda(row(k)) + values(q + 1)*lambda(row(k + 1))
         else
            t1 = 0.0_wp
            t2 = 0.0_wp
            !GCC$ unroll 1
            do k = first(j), first(j + 1) - 1
               p = place(k)
               t1 = t1 + values(p)*lambda(row(k))
               t2 = t2 + values(p + 1)*lambda(row(k))
            end do
         end if
         d(1, j) = d(1, j) - t1
         d(2, j) = d(2, j) - t2
      end do
   end subroutine subtract_columns_of_pairs

   !> d := d - A^T lambda column by column, with groups of one or three: no entry of d waits for another.
   pure subroutine subtract_columns(g, columns, first, row, place, values, lambda, d)
      integer, intent(in) :: g, columns
      integer, intent(in) :: first(*), row(*), place(*)
      real(wp), intent(in) :: values(*), lambda(*)
      real(wp), intent(inout) :: d(g, *)
      integer :: j, k, p
      real(wp) :: t1, t2, t3

      if (g == 1) then
         do j = 1, columns
            t1 = d(1, j)
            !GCC$ unroll 1
            do k = first(j), first(j + 1) - 1
               t1 = t1 - values(place(k))*lambda(row(k))
            end do
            d(1, j) = t1
         end do
         return
      end if
      do j = 1, columns
         t1 = d(1, j)
         t2 = d(2, j)
         t3 = d(3, j)
         !GCC$ unroll 1
         do k = first(j), first(j + 1) - 1
            p = place(k)
            t1 = t1 - values(p)*lambda(row(k))
            t2 = t2 - values(p + 1)*lambda(row(k))
            t3 = t3 - values(p + 2)*lambda(row(k))
         end do
         d(1, j) = t1
         d(2, j) = t2
         d(3, j) = t3
      end do
   end subroutine subtract_columns

end module taut_linalg_csr
