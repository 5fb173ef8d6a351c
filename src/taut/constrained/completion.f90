!> Mass matrices that are singular, but definite along the constraints: coordinates without mass, rates of unit quaternions,
!! equations without derivatives.
!!
!! With A vdot = b'', M vdot + A^T lambda = f is the same as (M + A^T D A) vdot + A^T (lambda - D b'') = f for any D >= 0, and
!! M + A^T D A is positive definite. D is diagonal and brings the rows of A to the scale of M, so that their scaling does not
!! matter.
module taut_constrained_completion
   use taut_kinds, only: wp
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_csr, only: csr_t
   use taut_linalg_lapack, only: dsygv
   implicit none (type, external)
   private
   public :: completion_t

   !> A pivot of this part of its diagonal entry is round-off: a matrix of 30 rows leaves no more than 1e-14 of it.
   real(wp), parameter :: no_pivot = 1.0e-13_wp
   !> An eigenvalue as far below zero, in units of the largest, is no round-off.
   real(wp), parameter :: negative = 1.0e-10_wp

   !> Whether a matrix was completed, and D.
   type :: completion_t
      !> Whether the matrix is M + A^T D A.
      logical :: is_on = .false.
      !> The diagonal of D: (c).
      real(wp), allocatable :: d(:)
   contains
      procedure :: factorize
      procedure :: add_rates
   end type completion_t

contains

   !> Factorizes M, or what completes it.
   subroutine factorize(self, m, a, bad_row)
      !> The completion.
      class(completion_t), intent(inout) :: self
      !> M; M + A^T D A on return if that was needed.
      type(block_diagonal_t), intent(inout) :: m
      !> Constraint matrix.
      type(csr_t), intent(in) :: a
      !> 0, or a row of M at which it is neither definite nor can be completed.
      integer, intent(out) :: bad_row

      self%is_on = .false.
      call m%factorize(bad_row)
      if (bad_row == 0) then
         if (m%least_certain_pivot() > no_pivot) return
      end if
      ! In one dense block alone A^T D A has room.
      if (a%full .and. size(m%first) == 2 .and. a%c > 0) then
         call complete(self, m, a, bad_row)
      else if (bad_row == 0) then
         if (m%smallest_pivot() <= no_pivot) bad_row = m%n
      end if
   end subroutine factorize

   !> M + A^T D A, factorized.
   subroutine complete(self, m, a, bad_row)
      type(completion_t), intent(inout) :: self
      type(block_diagonal_t), intent(inout) :: m
      type(csr_t), intent(in) :: a
      integer, intent(out) :: bad_row
      real(wp) :: largest, square
      integer :: i, j, k, n

      n = m%n
      if (.not. allocated(self%d)) then
         call find_negative(n, m%values, bad_row)
         if (bad_row > 0) return
         allocate (self%d(a%c))
      end if
      largest = maxval(abs(m%values))
      do k = 1, a%c
         square = 0.0_wp
         do i = 1, n
            square = square + a%values((k - 1)*n + i)**2
         end do
         self%d(k) = 0.0_wp
         if (square > 0.0_wp) self%d(k) = largest/square
      end do
      do k = 1, a%c
         do j = 1, n
            do i = 1, n
               m%values((j - 1)*n + i) = m%values((j - 1)*n + i) + self%d(k)*a%values((k - 1)*n + j)*a%values((k - 1)*n + i)
            end do
         end do
      end do
      call m%factorize(bad_row)
      if (bad_row == 0 .and. m%smallest_pivot() <= no_pivot) bad_row = n
      self%is_on = bad_row == 0
   end subroutine complete

   !> The row that has most of the direction in which a matrix is negative; 0 if there is none.
   subroutine find_negative(n, matrix, row)
      integer, intent(in) :: n
      real(wp), intent(in) :: matrix(n, n)
      integer, intent(out) :: row
      real(wp) :: unit(n, n), values(n), vectors(n, n), work(34*n)
      integer :: i, info

      vectors = matrix
      unit = 0.0_wp
      do i = 1, n
         unit(i, i) = 1.0_wp
      end do
      call dsygv(1, 'V', 'L', n, vectors, n, unit, n, values, work, size(work), info)
      row = 0
      if (values(1) < -negative*maxval(abs(values))) row = maxloc(abs(vectors(:, 1)), 1)
   end subroutine find_negative

   !> lambda := lambda + D b'', where the matrix was completed.
   pure subroutine add_rates(self, b_second, lambda)
      !> The completion.
      class(completion_t), intent(in) :: self
      !> b'': (c).
      real(wp), intent(in), contiguous :: b_second(:)
      !> Multipliers of the completed equation, replaced by those of the given one: (c).
      real(wp), intent(inout), contiguous :: lambda(:)

      if (self%is_on) lambda(:) = lambda + self%d*b_second
   end subroutine add_rates

end module taut_constrained_completion
