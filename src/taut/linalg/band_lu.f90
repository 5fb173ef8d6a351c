!> Square sparse matrices, real or complex, factorized as bands by LAPACK after an ordering with a small bandwidth.
!!
!! The pattern is that of a symmetric matrix, the values need not be symmetric; row interchanges keep matrices stable whose
!! diagonal has zeros, such as those of saddle-point problems.
module taut_linalg_band_lu
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_kinds, only: wp
   use taut_linalg_lapack, only: dgbtrf, dgbtrs, zgbtrf, zgbtrs
   use taut_linalg_ordering, only: bandwidth, reverse_cuthill_mckee
   implicit none (type, external)
   private
   public :: band_pattern_t, real_band_lu_t, complex_band_lu_t

   !> Where the entries are, and where they go in a band.
   type :: band_pattern_t
      !> Order of the matrix.
      integer :: n = 0
      !> Diagonals above the main one, and as many below it, in the ordering.
      integer :: width = 0
      !> Row and column of each entry: (entries).
      integer, allocatable :: row(:), column(:)
      !> Place of each row in the ordering: (n).
      integer, allocatable :: place(:)
   contains
      procedure :: init
   end type band_pattern_t

   !> A real matrix and its factors.
   type :: real_band_lu_t
      real(wp), allocatable, private :: band(:, :), b(:)
      integer, allocatable, private :: pivot(:)
   contains
      procedure :: factorize => factorize_real
      procedure :: solve => solve_real
      procedure :: has_negative_determinant
   end type real_band_lu_t

   !> A complex matrix and its factors.
   type :: complex_band_lu_t
      complex(wp), allocatable, private :: band(:, :), b(:)
      integer, allocatable, private :: pivot(:)
   contains
      procedure :: factorize => factorize_complex
      procedure :: solve => solve_complex
   end type complex_band_lu_t

contains

   !> Takes a pattern and orders it.
   subroutine init(self, n, row, column)
      !> The pattern.
      class(band_pattern_t), intent(out) :: self
      !> Order of the matrix.
      integer, intent(in) :: n
      !> Row of each entry; an entry may be named more than once, its values then add up: (entries).
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

   !> Factorizes a matrix.
   subroutine factorize_real(self, pattern, values, info)
      !> The factors.
      class(real_band_lu_t), intent(inout) :: self
      !> The pattern.
      type(band_pattern_t), intent(in) :: pattern
      !> The entries: (entries of the pattern).
      real(wp), intent(in) :: values(:)
      !> 0; or the row and column, in the numbers of the matrix, at which it was found to be singular; -1 if an entry is
      !! not finite.
      integer, intent(out) :: info
      integer :: i, j, k, w

      w = pattern%width
      if (.not. allocated(self%band)) allocate (self%band(3*w + 1, pattern%n), self%b(pattern%n), self%pivot(pattern%n))
      self%band(:, :) = 0.0_wp
      info = -1
      do k = 1, size(values)
         if (.not. ieee_is_finite(values(k))) return
         i = pattern%place(pattern%row(k))
         j = pattern%place(pattern%column(k))
         self%band(2*w + 1 + i - j, j) = self%band(2*w + 1 + i - j, j) + values(k)
      end do
      call dgbtrf(pattern%n, pattern%n, w, w, self%band, 3*w + 1, self%pivot, info)
      if (info > 0) info = findloc(pattern%place, info, 1)
   end subroutine factorize_real

   !> Whether the determinant is below zero.
   pure logical function has_negative_determinant(self) result(negative)
      !> The factors of a regular matrix.
      class(real_band_lu_t), intent(in) :: self
      integer :: j, main

      ! Rows and columns are ordered alike, which leaves the sign as it is; an interchange of rows turns it.
      main = 2*((size(self%band, 1) - 1)/3) + 1
      negative = .false.
      do j = 1, size(self%pivot)
         if (self%pivot(j) /= j) negative = .not. negative
         if (self%band(main, j) < 0.0_wp) negative = .not. negative
      end do
   end function has_negative_determinant

   !> Solves with the factors.
   subroutine solve_real(self, pattern, x)
      !> The factors.
      class(real_band_lu_t), intent(inout) :: self
      !> The pattern.
      type(band_pattern_t), intent(in) :: pattern
      !> Right-hand side, replaced by the solution: (n).
      real(wp), intent(inout) :: x(:)
      integer :: i, info

      do i = 1, pattern%n
         self%b(pattern%place(i)) = x(i)
      end do
      call dgbtrs('N', pattern%n, pattern%width, pattern%width, 1, self%band, 3*pattern%width + 1, self%pivot, self%b, &
                  pattern%n, info)
      do i = 1, pattern%n
         x(i) = self%b(pattern%place(i))
      end do
   end subroutine solve_real

   !> Factorizes a matrix.
   subroutine factorize_complex(self, pattern, values, info)
      !> The factors.
      class(complex_band_lu_t), intent(inout) :: self
      !> The pattern.
      type(band_pattern_t), intent(in) :: pattern
      !> The entries: (entries of the pattern).
      complex(wp), intent(in) :: values(:)
      !> As for a real matrix.
      integer, intent(out) :: info
      integer :: i, j, k, w

      w = pattern%width
      if (.not. allocated(self%band)) allocate (self%band(3*w + 1, pattern%n), self%b(pattern%n), self%pivot(pattern%n))
      self%band(:, :) = 0.0_wp
      info = -1
      do k = 1, size(values)
         if (.not. (ieee_is_finite(real(values(k))) .and. ieee_is_finite(aimag(values(k))))) return
         i = pattern%place(pattern%row(k))
         j = pattern%place(pattern%column(k))
         self%band(2*w + 1 + i - j, j) = self%band(2*w + 1 + i - j, j) + values(k)
      end do
      call zgbtrf(pattern%n, pattern%n, w, w, self%band, 3*w + 1, self%pivot, info)
      if (info > 0) info = findloc(pattern%place, info, 1)
   end subroutine factorize_complex

   !> Solves with the factors.
   subroutine solve_complex(self, pattern, x)
      !> The factors.
      class(complex_band_lu_t), intent(inout) :: self
      !> The pattern.
      type(band_pattern_t), intent(in) :: pattern
      !> Right-hand side, replaced by the solution: (n).
      complex(wp), intent(inout) :: x(:)
      integer :: i, info

      do i = 1, pattern%n
         self%b(pattern%place(i)) = x(i)
      end do
      call zgbtrs('N', pattern%n, pattern%width, pattern%width, 1, self%band, 3*pattern%width + 1, self%pivot, self%b, &
                  pattern%n, info)
      do i = 1, pattern%n
         x(i) = self%b(pattern%place(i))
      end do
   end subroutine solve_complex

end module taut_linalg_band_lu
