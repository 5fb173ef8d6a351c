!> Spaces that hold the lowest modes of a large system, M ddot d + C dot d + K d = 0 with A d = 0: Krylov's, of its flexibility near
!! rest.
!!
!! s begins where K + s M is certainly positive, so that whatever is unstable is seen however fast it grows, and comes down by steps
!! between which a space sees a negative value: no pivots are counted. What is not symmetric of K is left out of that.
module taut_constrained_modes_lowest
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_kinds, only: wp
   use taut_constrained_resistance, only: beyond_doubt, round_off
   use taut_constrained_rest_sparse, only: sparse_rest_t
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_csr, only: csr_t
   use taut_linalg_lapack, only: dsygv
   implicit none (type, external)
   private
   public :: descend, krylov_space

   !> Blocks of a space, and how far s comes down between two: a value that is negative there is at least this part of s, and a
   !! polynomial of so many degrees leaves e^-12 of what hides it.
   integer, parameter :: degrees = 12
   real(wp), parameter :: down = 16.0_wp
   !> Vectors of the first block.
   integer, parameter :: block = 4
   !> s is near enough below the lowest value where it is less than this part of it.
   real(wp), parameter :: near = 0.1_wp

   !> What a displacement has to have besides others: less is round-off.
   real(wp), parameter :: little = 1.0e-9_wp

contains

   !> Comes down to just below the lowest value of the symmetric part of K.
   subroutine descend(rest, m, s, info)
      !> The system at rest, with A and K found.
      type(sparse_rest_t), intent(inout) :: rest
      !> M.
      type(block_diagonal_t), intent(in) :: m
      !> K + s M is positive [1/s^2].
      real(wp), intent(out) :: s
      !> 0; not 0 where a matrix could not be factorized.
      integer, intent(out) :: info
      type(csr_t) :: k
      real(wp), allocatable :: basis(:, :), mu(:), worths(:)
      integer :: dimensions, i, j, l

      k = rest%tangent%k
      do i = 1, k%n
         do l = k%first(i), k%first(i + 1) - 1
            j = k%column(l)
            k%values(l) = 0.5_wp*(rest%tangent%k%values(l) + rest%tangent%k%values(rest%tangent%coupling%place(j, i)))
         end do
      end do
      call scale_by_mass(rest, m)
      s = bound(rest)
      dimensions = min(block*degrees, count(rest%is_free) - rest%rank)
      do
         call krylov(rest, k%values, m, s, dimensions, block, basis, info)
         if (info /= 0) return
         call ritz(k, m, basis, mu, info)
         if (info /= 0) return
         worths = [(worth(rest, basis(:, i)), i=1, size(mu))]
         if (mu(1) < -worths(1)) then
            if (s <= 2.0_wp*abs(mu(1))) return
            s = max(s/down, -1.5_wp*mu(1))
         else
            i = findloc(abs(mu) > worths, .true., 1)
            if (i == 0) i = size(mu)
            if (s <= near*abs(mu(i)) .or. s <= worths(i)) return
            s = s/down
         end if
      end do
   end subroutine descend

   !> A space with the modes that are lowest.
   subroutine krylov_space(rest, m, c, s, dimensions, block, basis, info)
      !> The system at rest, after `descend`.
      type(sparse_rest_t), intent(inout) :: rest
      !> M.
      type(block_diagonal_t), intent(in) :: m
      !> C, in the pattern of K.
      real(wp), intent(in) :: c(:)
      !> K + s M is positive [1/s^2].
      real(wp), intent(in) :: s
      !> Of the space.
      integer, intent(in) :: dimensions
      !> Vectors that it begins with: more than there are modes of one frequency.
      integer, intent(in) :: block
      !> Its basis, of unit masses: (n, at most the dimensions).
      real(wp), allocatable, intent(out) :: basis(:, :)
      !> 0; not 0 where the matrix could not be factorized.
      integer, intent(out) :: info

      if (any(abs(c) > 0.0_wp)) then
         call krylov(rest, rest%tangent%k%values, m, s, dimensions, block, basis, info, c)
      else
         call krylov(rest, rest%tangent%k%values, m, s, dimensions, block, basis, info)
      end if
   end subroutine krylov_space

   !> Coordinates in which the diagonal of M is one.
   subroutine scale_by_mass(rest, m)
      type(sparse_rest_t), intent(inout) :: rest
      type(block_diagonal_t), intent(in) :: m
      integer :: b, i, k, size_of_block

      k = 0
      do b = 1, size(m%first) - 1
         size_of_block = m%first(b + 1) - m%first(b)
         do i = m%first(b), m%first(b + 1) - 1
            rest%bordered%scale(i) = 1.0_wp/sqrt(m%values(k + (i - m%first(b))*(size_of_block + 1) + 1))
         end do
         k = k + size_of_block**2
      end do
      rest%bordered%moves = rest%is_free
   end subroutine scale_by_mass

   !> More than any value is below zero, by the disks of what of K may be negative; some of what is largest if nothing is.
   function bound(rest) result(s)
      type(sparse_rest_t), intent(in) :: rest
      real(wp) :: s
      real(wp) :: largest, negative, part
      integer :: i, j, l

      largest = 0.0_wp
      negative = 0.0_wp
      associate (k => rest%tangent%k, scale => rest%bordered%scale)
         do i = 1, k%n
            part = 0.0_wp
            do l = k%first(i), k%first(i + 1) - 1
               j = k%column(l)
               if (.not. (rest%is_free(i) .and. rest%is_free(j))) cycle
               ! Elastic rows whose forces are no gradient are negative by as much as they are not symmetric.
               part = part + (abs(rest%tangent%soft(l)) + abs(k%values(l) - k%values(rest%tangent%coupling%place(j, i))))* &
                      scale(i)*scale(j)
               if (i == j) largest = max(largest, abs(k%values(l))*scale(i)*scale(j))
            end do
            negative = max(negative, part)
         end do
      end associate
      s = max(2.0_wp*negative, 1.0e-6_wp*largest, tiny(1.0_wp))
   end function bound

   !> How large q^T K q may be though it is zero.
   function worth(rest, q) result(noise)
      type(sparse_rest_t), intent(in) :: rest
      real(wp), intent(in) :: q(:)
      real(wp) :: noise
      real(wp) :: sizes, sums(size(rest%tangent%errors, 2))
      integer :: i, l

      sums = 0.0_wp
      sizes = 0.0_wp
      associate (k => rest%tangent%k)
         do i = 1, k%n
            do l = k%first(i), k%first(i + 1) - 1
               sums = sums + q(i)*rest%tangent%errors(l, :)*q(k%column(l))
               sizes = sizes + abs(q(i)*k%values(l)*q(k%column(l)))
            end do
         end do
      end associate
      noise = beyond_doubt*norm2(sums)/sqrt(real(size(sums), wp)) + round_off*sizes
   end function worth

   !> A basis of the Krylov space of (K + s M)^-1 M, of unit masses; with damping, of that and of (K + s M)^-1 C.
   subroutine krylov(rest, k, m, s, dimensions, block, basis, info, c)
      type(sparse_rest_t), intent(inout) :: rest
      real(wp), intent(in) :: k(:)
      type(block_diagonal_t), intent(in) :: m
      real(wp), intent(in) :: s
      integer, intent(in) :: dimensions, block
      real(wp), allocatable, intent(out) :: basis(:, :)
      integer, intent(out) :: info
      real(wp), intent(in), optional :: c(:)
      type(csr_t) :: damper
      real(wp), allocatable :: of_basis(:, :)
      real(wp) :: values(size(k)), x(m%n), mx(m%n), length
      integer :: from, i, kept, n, steps
      logical :: by_damper

      n = m%n
      call shifted(rest, k, m, s, values)
      call rest%bordered%factorize(values, 0.0_wp, rest%linear%a, rest%kept, info)
      if (info /= 0) return
      if (present(c)) then
         damper = rest%tangent%k
         damper%values = c
      end if
      allocate (basis(n, dimensions), of_basis(n, dimensions))
      kept = 0
      from = 1
      by_damper = .false.
      do steps = 1, 5*dimensions
         if (steps <= block .or. from > kept) then
            ! Numbers without a pattern; again where a space is exhausted.
            x = [(modulo(12345.6789_wp*sin(12.9898_wp*i + 78.233_wp*steps), 1.0_wp) - 0.5_wp, i=1, n)]
         else
            x = of_basis(:, from)
            if (by_damper) call damper%multiply(basis(:, from), x)
            if (by_damper .or. .not. present(c)) from = from + 1
            by_damper = present(c) .and. .not. by_damper
            x = rest%bordered%scale*x
         end if
         call rest%bordered%divide(x)
         x = rest%bordered%scale*x
         length = norm2(x)
         do i = 1, 2
            x = x - matmul(basis(:, :kept), matmul(x, of_basis(:, :kept)))
         end do
         if (.not. ieee_is_finite(norm2(x))) then
            info = 1
            return
         end if
         if (norm2(x) <= little*length) cycle
         call m%multiply(x, mx)
         length = sqrt(dot_product(x, mx))
         kept = kept + 1
         basis(:, kept) = x/length
         of_basis(:, kept) = mx/length
         if (kept == dimensions) exit
      end do
      basis = basis(:, :kept)
   end subroutine krylov

   !> K + s M, scaled.
   subroutine shifted(rest, k, m, s, values)
      type(sparse_rest_t), intent(in) :: rest
      real(wp), intent(in) :: k(:), s
      type(block_diagonal_t), intent(in) :: m
      real(wp), intent(out) :: values(:)
      integer :: b, i, j, l, p

      values = k
      p = 0
      do b = 1, size(m%first) - 1
         do j = m%first(b), m%first(b + 1) - 1
            do i = m%first(b), m%first(b + 1) - 1
               p = p + 1
               l = rest%tangent%coupling%place(i, j)
               values(l) = values(l) + s*m%values(p)
            end do
         end do
      end do
      associate (pattern => rest%tangent%k, scale => rest%bordered%scale, moves => rest%bordered%moves)
         do i = 1, pattern%n
            do l = pattern%first(i), pattern%first(i + 1) - 1
               j = pattern%column(l)
               if (moves(i) .and. moves(j)) then
                  values(l) = values(l)*scale(i)*scale(j)
               else
                  values(l) = 0.0_wp
               end if
            end do
         end do
      end associate
   end subroutine shifted

   !> Ritz's values in a space, ascending, and their shapes in the place of the basis.
   subroutine ritz(k, m, basis, mu, info)
      type(csr_t), intent(in) :: k
      type(block_diagonal_t), intent(in) :: m
      real(wp), allocatable, intent(inout) :: basis(:, :)
      real(wp), allocatable, intent(out) :: mu(:)
      integer, intent(out) :: info
      real(wp), allocatable :: masses(:, :), small(:, :), work(:)
      real(wp) :: image(m%n)
      integer :: j, n

      n = size(basis, 2)
      allocate (mu(n), small(n, n), masses(n, n), work(34*n), source=0.0_wp)
      do j = 1, n
         call k%multiply(basis(:, j), image)
         small(:, j) = matmul(image, basis)
         call m%multiply(basis(:, j), image)
         masses(:, j) = matmul(image, basis)
      end do
      call dsygv(1, 'V', 'L', n, small, n, masses, n, mu, work, size(work), info)
      basis = matmul(basis, small)
   end subroutine ritz

end module taut_constrained_modes_lowest
