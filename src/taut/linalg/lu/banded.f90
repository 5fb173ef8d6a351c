!> Factors of sparse matrices as bands, by LAPACK, after an ordering with a small bandwidth.
module taut_linalg_lu_banded
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_kinds, only: wp
   use taut_linalg_lapack, only: dgbtrf, dgbtrs, zgbtrf, zgbtrs
   use taut_linalg_lu, only: lu_not_finite, lu_t, lu_too_large
   use taut_linalg_ordering, only: bandwidth, reverse_cuthill_mckee
   implicit none (type, external)
   private
   public :: banded_lu_t

   !> Real numbers that a band may have; twice as many, those of a complex one, are 8 GiB, and LAPACK counts no further.
   real(wp), parameter :: most_numbers = 2.0_wp**29

   !> The bands and their factors.
   type, extends(lu_t) :: banded_lu_t
      !> Diagonals above the main one, and as many below it, in the ordering.
      integer :: width = 0
      !> Place of each row in the ordering: (n).
      integer, allocatable, private :: place(:)
      real(wp), allocatable, private :: real_band(:, :), real_b(:)
      complex(wp), allocatable, private :: complex_band(:, :), complex_b(:)
      integer, allocatable, private :: real_pivot(:), complex_pivot(:)
   contains
      procedure :: init
      procedure :: work
      procedure :: numbers
      procedure :: factorize_real
      procedure :: factorize_complex
      procedure :: solve_real
      procedure :: solve_complex
      procedure :: has_negative_determinant
   end type banded_lu_t

contains

   !> Takes a pattern and orders it.
   subroutine init(self, n, row, column)
      !> The factors.
      class(banded_lu_t), intent(inout) :: self
      !> Order of the matrix.
      integer, intent(in) :: n
      !> Row of each entry: (entries).
      integer, intent(in) :: row(:)
      !> Column of each entry: (entries).
      integer, intent(in) :: column(:)
      integer, allocatable :: first(:), neighbor(:), order(:)
      integer :: i

      self%n = n
      self%row = row
      self%column = column
      call neighbors(n, row, column, first, neighbor)
      allocate (order(n))
      call reverse_cuthill_mckee(first, neighbor, order)
      if (bandwidth(first, neighbor, order) >= bandwidth(first, neighbor, [(i, i=1, n)])) order = [(i, i=1, n)]
      self%width = bandwidth(first, neighbor, order)
      allocate (self%place(n))
      self%place(order) = [(i, i=1, n)]
   end subroutine init

   !> The graph of a symmetric pattern, without loops and double edges.
   pure subroutine neighbors(n, row, column, first, neighbor)
      integer, intent(in) :: n, row(:), column(:)
      integer, allocatable, intent(out) :: first(:), neighbor(:)
      integer :: count(n + 1), last(n), i, j, k, found
      integer, allocatable :: all_first(:), all_of(:)

      count = 0
      do k = 1, size(row)
         if (row(k) == column(k)) cycle
         count(row(k)) = count(row(k)) + 1
         count(column(k)) = count(column(k)) + 1
      end do
      allocate (all_first(n + 1), all_of(sum(count)))
      all_first(1) = 1
      do i = 1, n
         all_first(i + 1) = all_first(i) + count(i)
      end do
      count(:n) = all_first(:n)
      do k = 1, size(row)
         if (row(k) == column(k)) cycle
         all_of(count(row(k))) = column(k)
         count(row(k)) = count(row(k)) + 1
         all_of(count(column(k))) = row(k)
         count(column(k)) = count(column(k)) + 1
      end do
      allocate (first(n + 1))
      last = 0
      found = 0
      do i = 1, n
         first(i) = found + 1
         do k = all_first(i), all_first(i + 1) - 1
            j = all_of(k)
            if (last(j) == i) cycle
            last(j) = i
            found = found + 1
            ! What was read already is written over.
            all_of(found) = j
         end do
      end do
      first(n + 1) = found + 1
      neighbor = all_of(:found)
   end subroutine neighbors

   !> Multiplications of the factorization.
   function work(self) result(number)
      !> The factors, laid out.
      class(banded_lu_t), intent(in) :: self
      !> How many: rows that are interchanged widen the upper factor.
      real(wp) :: number

      number = 2.0_wp*real(self%n, wp)*real(self%width, wp)**2
   end function work

   !> Numbers of the band, with room for what interchanges fill in.
   function numbers(self) result(number)
      !> The factors, laid out.
      class(banded_lu_t), intent(in) :: self
      !> How many.
      real(wp) :: number

      number = real(self%n, wp)*(3*self%width + 1)
   end function numbers

   !> Factorizes a real matrix.
   subroutine factorize_real(self, values, info)
      !> The factors.
      class(banded_lu_t), intent(inout) :: self
      !> The entries: (entries of the pattern).
      real(wp), intent(in) :: values(:)
      !> As `lu_t` has it.
      integer, intent(out) :: info
      integer :: i, j, k, status, w

      w = self%width
      if (.not. allocated(self%real_band)) then
         info = lu_too_large
         if (self%numbers() > most_numbers) return
         allocate (self%real_band(3*w + 1, self%n), self%real_b(self%n), self%real_pivot(self%n), stat=status)
         if (status /= 0) return
      end if
      self%real_band(:, :) = 0.0_wp
      info = lu_not_finite
      do k = 1, size(values)
         if (.not. ieee_is_finite(values(k))) return
         i = self%place(self%row(k))
         j = self%place(self%column(k))
         self%real_band(2*w + 1 + i - j, j) = self%real_band(2*w + 1 + i - j, j) + values(k)
      end do
      call dgbtrf(self%n, self%n, w, w, self%real_band, 3*w + 1, self%real_pivot, info)
      if (info > 0) info = findloc(self%place, info, 1)
   end subroutine factorize_real

   !> Factorizes a complex matrix.
   subroutine factorize_complex(self, values, info)
      !> The factors.
      class(banded_lu_t), intent(inout) :: self
      !> The entries: (entries of the pattern).
      complex(wp), intent(in) :: values(:)
      !> As `lu_t` has it.
      integer, intent(out) :: info
      integer :: i, j, k, status, w

      w = self%width
      if (.not. allocated(self%complex_band)) then
         info = lu_too_large
         if (self%numbers() > most_numbers) return
         allocate (self%complex_band(3*w + 1, self%n), self%complex_b(self%n), self%complex_pivot(self%n), stat=status)
         if (status /= 0) return
      end if
      self%complex_band(:, :) = (0.0_wp, 0.0_wp)
      info = lu_not_finite
      do k = 1, size(values)
         if (.not. (ieee_is_finite(real(values(k))) .and. ieee_is_finite(aimag(values(k))))) return
         i = self%place(self%row(k))
         j = self%place(self%column(k))
         self%complex_band(2*w + 1 + i - j, j) = self%complex_band(2*w + 1 + i - j, j) + values(k)
      end do
      call zgbtrf(self%n, self%n, w, w, self%complex_band, 3*w + 1, self%complex_pivot, info)
      if (info > 0) info = findloc(self%place, info, 1)
   end subroutine factorize_complex

   !> Solves with the factors of the real matrix.
   subroutine solve_real(self, x)
      !> The factors.
      class(banded_lu_t), intent(inout) :: self
      !> Right-hand side, replaced by the solution: (n).
      real(wp), intent(inout) :: x(:)
      integer :: i, info

      do i = 1, self%n
         self%real_b(self%place(i)) = x(i)
      end do
      call dgbtrs('N', self%n, self%width, self%width, 1, self%real_band, 3*self%width + 1, self%real_pivot, self%real_b, &
                  self%n, info)
      do i = 1, self%n
         x(i) = self%real_b(self%place(i))
      end do
   end subroutine solve_real

   !> Solves with the factors of the complex matrix.
   subroutine solve_complex(self, x)
      !> The factors.
      class(banded_lu_t), intent(inout) :: self
      !> Right-hand side, replaced by the solution: (n).
      complex(wp), intent(inout) :: x(:)
      integer :: i, info

      do i = 1, self%n
         self%complex_b(self%place(i)) = x(i)
      end do
      call zgbtrs('N', self%n, self%width, self%width, 1, self%complex_band, 3*self%width + 1, self%complex_pivot, self%complex_b, &
                  self%n, info)
      do i = 1, self%n
         x(i) = self%complex_b(self%place(i))
      end do
   end subroutine solve_complex

   !> Whether the determinant of the real matrix is below zero.
   pure logical function has_negative_determinant(self) result(negative)
      !> The factors of a regular matrix.
      class(banded_lu_t), intent(in) :: self
      integer :: j, main

      ! Rows and columns are ordered alike, which leaves the sign as it is; an interchange of rows turns it.
      main = 2*self%width + 1
      negative = .false.
      do j = 1, self%n
         if (self%real_pivot(j) /= j) negative = .not. negative
         if (self%real_band(main, j) < 0.0_wp) negative = .not. negative
      end do
   end function has_negative_determinant

end module taut_linalg_lu_banded
