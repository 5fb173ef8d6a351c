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
   end subroutine set_pattern

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
         t = 0.0_wp
         if (present(b)) t = -b(i)
         do k = self%first(i), self%first(i + 1) - 1
            t = t + self%values(k)*v(self%column(k))
         end do
         r(i) = t
      end do
   end subroutine multiply

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
      do i = 1, size(lambda)
         do k = self%first(i), self%first(i + 1) - 1
            d(self%column(k)) = d(self%column(k)) - self%values(k)*lambda(i)
         end do
      end do
   end subroutine subtract_transposed

end module taut_linalg_sparse_rows
