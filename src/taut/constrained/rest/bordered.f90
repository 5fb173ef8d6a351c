!> The matrix [K, A^T; A, 0] of a system at rest, of entries in the pattern of its tangent, and its factors: displacements that the
!! constraints allow, of forces.
module taut_constrained_rest_bordered
   use taut_kinds, only: wp
   use taut_constrained_saddle_point, only: column_of, entries_of_row, place_of
   use taut_linalg_csr, only: csr_t
   use taut_linalg_lu, only: lu_t
   use taut_linalg_lu_choose, only: choose_lu
   implicit none (type, external)
   private
   public :: bordered_t

   !> The matrix, scaled.
   type :: bordered_t
      !> Velocities that have a part in it: (n); the others do not move.
      logical, allocatable :: moves(:)
      !> What displacements are multiples of: (n).
      real(wp), allocatable :: scale(:)
      class(lu_t), allocatable, private :: lu
      !> Entries of the matrix; a right-hand side and its solution.
      real(wp), allocatable, private :: values(:), x(:)
   contains
      procedure :: init
      procedure :: factorize
      procedure :: divide
   end type bordered_t

contains

   !> Lays everything out.
   subroutine init(self, k, c, a)
      !> The matrix.
      class(bordered_t), intent(inout) :: self
      !> The pattern of K, symmetric and with its diagonal.
      type(csr_t), intent(in) :: k
      !> Number of constraints.
      integer, intent(in) :: c
      !> The pattern of A; not used without constraints.
      type(csr_t), intent(in) :: a
      integer, allocatable :: column(:), row(:)
      integer :: i, j, n, p

      n = k%n
      p = size(k%values) + n
      do i = 1, c
         p = p + 2*entries_of_row(a, i) + 1
      end do
      allocate (row(p), column(p))
      do i = 1, n
         row(k%first(i):k%first(i + 1) - 1) = i
      end do
      p = size(k%values)
      column(:p) = k%column
      row(p + 1:p + n) = [(i, i=1, n)]
      column(p + 1:p + n) = row(p + 1:p + n)
      p = p + n
      do i = 1, c
         do j = 1, entries_of_row(a, i)
            row(p + 1:p + 2) = [n + i, column_of(a, i, j)]
            column(p + 1:p + 2) = [column_of(a, i, j), n + i]
            p = p + 2
         end do
         p = p + 1
         row(p) = n + i
         column(p) = n + i
      end do
      call choose_lu(n + c, row, column, self%lu)
      allocate (self%values(size(row)), self%x(n + c), source=0.0_wp)
      allocate (self%scale(n), source=1.0_wp)
      allocate (self%moves(n), source=.true.)
   end subroutine init

   !> Factorizes it.
   subroutine factorize(self, k, shift, a, kept, info)
      !> The matrix, laid out.
      class(bordered_t), intent(inout) :: self
      !> Entries of K, scaled, zero where nothing moves.
      real(wp), intent(in) :: k(:)
      !> What is added to the diagonal.
      real(wp), intent(in) :: shift
      !> A; not used without constraints.
      type(csr_t), intent(in) :: a
      !> Rows that are independent: (c).
      logical, intent(in) :: kept(:)
      !> 0, or that of the factors.
      integer, intent(out) :: info
      real(wp) :: factor, largest
      integer :: i, j, n, p

      n = size(self%scale)
      p = size(k)
      self%values(:p) = k
      self%values(p + 1:p + n) = merge(shift, 1.0_wp, self%moves)
      p = p + n
      do i = 1, size(kept)
         largest = 0.0_wp
         do j = 1, entries_of_row(a, i)
            largest = max(largest, abs(a%values(place_of(a, i, j)))*self%scale(column_of(a, i, j)))
         end do
         factor = 0.0_wp
         if (kept(i) .and. largest > 0.0_wp) factor = 1.0_wp/largest
         do j = 1, entries_of_row(a, i)
            self%values(p + 1:p + 2) = a%values(place_of(a, i, j))*self%scale(column_of(a, i, j))*factor
            p = p + 2
         end do
         p = p + 1
         self%values(p) = merge(0.0_wp, 1.0_wp, factor > 0.0_wp)
      end do
      call self%lu%factorize(self%values, info)
   end subroutine factorize

   !> Displacements of forces, both scaled.
   subroutine divide(self, y)
      !> The matrix, factorized.
      class(bordered_t), intent(inout) :: self
      !> Forces, replaced by displacements: (n).
      real(wp), intent(inout), contiguous :: y(:)
      integer :: n

      n = size(y)
      self%x(:n) = merge(y, 0.0_wp, self%moves)
      self%x(n + 1:) = 0.0_wp
      call self%lu%solve(self%x)
      y = merge(self%x(:n), 0.0_wp, self%moves)
   end subroutine divide

end module taut_constrained_rest_bordered
