!> Matrices stored by rows, all entries or those of a pattern: constraint matrices.
module taut_linalg_sparse_rows
   use taut_kinds, only: wp
   implicit none (type, external)
   private
   public :: sparse_rows_t

   !> A matrix of c rows and n columns. The values are contiguous, row after row.
   type :: sparse_rows_t
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
      !> The same column by column: first entry of each column, and the row and the place in `values` of each entry.
      integer, allocatable, private :: column_first(:), row(:), place(:)
      !> Room for all entries in column order, (c, n), where they have to be given like that; only if `full`.
      real(wp), allocatable :: all_entries(:, :)
   contains
      procedure :: init
      procedure :: set_pattern
      procedure :: set_dense
      procedure :: dense
      procedure :: multiply
      procedure :: subtract_transposed
   end type sparse_rows_t

contains

   !> Lays out a matrix with all its entries, zero at first.
   subroutine init(self, c, n)
      !> The matrix.
      class(sparse_rows_t), intent(out) :: self
      !> Rows and columns.
      integer, intent(in) :: c, n

      self%c = c
      self%n = n
      self%full = .true.
      allocate (self%first(0), self%column(0))
      allocate (self%values(c*n), self%all_entries(c, n), source=0.0_wp)
   end subroutine init

   !> Lays out a matrix with the entries of a pattern, zero at first.
   subroutine set_pattern(self, n, first, column)
      !> The matrix.
      class(sparse_rows_t), intent(out) :: self
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
      call transpose_pattern(self)
   end subroutine set_pattern

   !> The entries column by column.
   subroutine transpose_pattern(self)
      type(sparse_rows_t), intent(inout) :: self
      integer :: i, k, l

      allocate (self%column_first(self%n + 1), source=0)
      allocate (self%row(size(self%column)), self%place(size(self%column)))
      do k = 1, size(self%column)
         self%column_first(self%column(k) + 1) = self%column_first(self%column(k) + 1) + 1
      end do
      self%column_first(1) = 1
      do l = 1, self%n
         self%column_first(l + 1) = self%column_first(l + 1) + self%column_first(l)
      end do
      do i = 1, self%c
         do k = self%first(i), self%first(i + 1) - 1
            l = self%column(k)
            self%row(self%column_first(l)) = i
            self%place(self%column_first(l)) = k
            self%column_first(l) = self%column_first(l) + 1
         end do
      end do
      do l = self%n, 1, -1
         self%column_first(l + 1) = self%column_first(l)
      end do
      self%column_first(1) = 1
   end subroutine transpose_pattern

   !> Takes the entries from those of a dense matrix.
   pure subroutine set_dense(self, a)
      !> The matrix.
      class(sparse_rows_t), intent(inout) :: self
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
      class(sparse_rows_t), intent(in) :: self
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
      class(sparse_rows_t), intent(in) :: self
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
      do i = 1, size(r)
         r(i) = 0.0_wp
      end do
      if (present(b)) then
         do i = 1, size(r)
            r(i) = -b(i)
         end do
      end if
      call add_rows(size(r), self%first, self%column, self%values, v, r)
   end subroutine multiply

   !> r := r + A v.
   pure subroutine add_rows(rows, first, column, values, v, r)
      integer, intent(in) :: rows
      integer, intent(in) :: first(*), column(*)
      real(wp), intent(in) :: values(*), v(*)
      real(wp), intent(inout) :: r(*)
      real(wp) :: t
      integer :: i, k

      do i = 1, rows
         k = first(i)
         if (first(i + 1) - k == 4) then
            ! As of a rod in the plane; rows are short, so that the loop would cost more than what it does.
            r(i) = r(i) + ((values(k)*v(column(k)) + values(k + 1)*v(column(k + 1))) + &
                           (values(k + 2)*v(column(k + 2)) + values(k + 3)*v(column(k + 3))))
         else
            t = r(i)
            !GCC$ unroll 1
            do k = first(i), first(i + 1) - 1
               t = t + values(k)*v(column(k))
            end do
            r(i) = t
         end if
      end do
   end subroutine add_rows

   !> d := d - A^T lambda with the first rows, as many as lambda has.
   pure subroutine subtract_transposed(self, lambda, d)
      !> The matrix.
      class(sparse_rows_t), intent(in) :: self
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
      if (size(lambda) == self%c) then
         call subtract_columns(self%n, self%column_first, self%row, self%place, self%values, lambda, d)
         return
      end if
      do i = 1, size(lambda)
         do k = self%first(i), self%first(i + 1) - 1
            d(self%column(k)) = d(self%column(k)) - self%values(k)*lambda(i)
         end do
      end do
   end subroutine subtract_transposed

   !> d := d - A^T lambda column by column: no entry of d waits for another.
   pure subroutine subtract_columns(columns, first, row, place, values, lambda, d)
      integer, intent(in) :: columns
      integer, intent(in) :: first(*), row(*), place(*)
      real(wp), intent(in) :: values(*), lambda(*)
      real(wp), intent(inout) :: d(*)
      real(wp) :: t
      integer :: j, k

      do j = 1, columns
         k = first(j)
         if (first(j + 1) - k == 2) then
            d(j) = d(j) - (values(place(k))*lambda(row(k)) + values(place(k + 1))*lambda(row(k + 1)))
         else
            t = d(j)
            !GCC$ unroll 1
            do k = first(j), first(j + 1) - 1
               t = t - values(place(k))*lambda(row(k))
            end do
            d(j) = t
         end if
      end do
   end subroutine subtract_columns

end module taut_linalg_sparse_rows
