!> Which motions a tangent stiffness resists, and by how much they give way.
!!
!! A motion that nothing resists has no stiffness but for round-off, and round-off knows nothing of small and large: a slender
!! beam that is bent has less stiffness for its size than the noise of its stretching. So no bound on a size tells them apart.
!! Samples of the error do: of one motion they show just that round-off which its own stiffness has.
module taut_constrained_resistance
   use taut_kinds, only: wp
   use taut_linalg_lapack, only: dgecon, dgesvd, dgetrf, dgetrs
   implicit none (type, external)
   private
   public :: stiffness_t, solve_regular, solve_doubtful, part_weak, is_loaded, beyond_doubt, round_off

   !> A tangent stiffness in some motions, and what it is worth.
   type :: stiffness_t
      !> The stiffness: (n, n).
      real(wp), allocatable :: k(:, :)
      !> What round-off of each entry is a part of: (n, n).
      real(wp), allocatable :: sizes(:, :)
      !> Samples of its error: (n, n, samples).
      real(wp), allocatable :: errors(:, :, :)
   contains
      procedure :: project
      procedure :: project_errors
      procedure :: worth
   end type stiffness_t

   !> Reciprocal condition number above which a tangent is certainly regular, and the part of what round-off is a part of that is
   !! certainly more than an error of differences. Slender beams have 1e-12 and less.
   real(wp), parameter :: regular = 1.0e-3_wp, no_error = 1.0e-4_wp
   !> A stiffness counts if it is so many times as large as the samples: two samples of a round-off are both as much too small once
   !! in ten thousand times.
   real(wp), parameter :: beyond_doubt = 100.0_wp
   !> This part of what a sum is made of is round-off.
   real(wp), parameter :: round_off = 10.0_wp*epsilon(1.0_wp)
   !> A load along a motion that nothing resists counts above this part of the largest load, for such a motion is known as well as
   !! its stiffness; once the others are in balance it is the largest.
   real(wp), parameter :: small_load = 1.0e-3_wp

contains

   !> Z^T K Z.
   subroutine project(self, z, k)
      !> The stiffness.
      class(stiffness_t), intent(out) :: self
      !> The motions: (all, n).
      real(wp), intent(in) :: z(:, :)
      !> K in all motions: (all, all).
      real(wp), intent(in) :: k(:, :)
      integer :: n

      n = size(z, 2)
      self%k = matmul(transpose(z), matmul(k, z))
      ! Of z, too, no entry is zero but for round-off.
      self%sizes = spread(sum(matmul(abs(k), abs(z)), 1), 1, n) + spread(sum(matmul(transpose(abs(z)), abs(k)), 2), 2, n)
   end subroutine project

   !> The same of samples of the error of K.
   subroutine project_errors(self, z, errors)
      !> The stiffness.
      class(stiffness_t), intent(inout) :: self
      !> The motions: (all, n).
      real(wp), intent(in) :: z(:, :)
      !> The samples: (all, all, samples).
      real(wp), intent(in) :: errors(:, :, :)
      integer :: i

      allocate (self%errors(size(z, 2), size(z, 2), size(errors, 3)))
      do i = 1, size(errors, 3)
         self%errors(:, :, i) = matmul(transpose(z), matmul(errors(:, :, i), z))
      end do
   end subroutine project_errors

   !> How large p^T K q may be though it is zero.
   pure function worth(self, p, q) result(noise)
      !> The stiffness.
      class(stiffness_t), intent(in) :: self
      !> Forces are weighed with this: (n).
      real(wp), intent(in) :: p(:)
      !> The motion: (n).
      real(wp), intent(in) :: q(:)
      !> The bound.
      real(wp) :: noise
      integer :: i

      noise = 0.0_wp
      do i = 1, size(self%errors, 3)
         noise = noise + dot_product(p, matmul(self%errors(:, :, i), q))**2
      end do
      noise = beyond_doubt*sqrt(noise/max(1, size(self%errors, 3))) + &
              round_off*dot_product(abs(p), matmul(self%sizes, abs(q)))
   end function worth

   !> y := K^-1 y, if K is regular beyond doubt; otherwise y stays.
   subroutine solve_regular(stiffness, y, solved)
      !> The tangent; its errors need not be known.
      type(stiffness_t), intent(in) :: stiffness
      !> Forces; displacements if it is solved.
      real(wp), intent(inout) :: y(:)
      !> Whether it is.
      logical, intent(out) :: solved
      real(wp) :: columns(size(y)), factor(size(y), size(y)), norm, rcond, rows(size(y)), work(4*size(y))
      integer :: info, iwork(size(y)), n, pivot(size(y))

      n = size(y)
      solved = n == 0
      if (solved) return
      call scale(stiffness%k, no_error*stiffness%sizes, rows, columns)
      factor = stiffness%k*spread(rows, 2, n)*spread(columns, 1, n)
      norm = maxval(sum(abs(factor), 1))
      call dgetrf(n, n, factor, n, pivot, info)
      if (info /= 0) return
      call dgecon('1', n, factor, n, norm, rcond, work, iwork, info)
      if (info /= 0 .or. .not. rcond >= regular) return
      y = rows*y
      call dgetrs('N', n, 1, factor, n, pivot, y, n, info)
      y = columns*y
      solved = info == 0
   end subroutine solve_regular

   !> y := K^-1 y where K resists; along the other motions nothing moves.
   subroutine solve_doubtful(stiffness, uncertain, y, unresisted, loaded, info)
      !> The tangent.
      type(stiffness_t), intent(in) :: stiffness
      !> How much of each force is not to be relied on: (n).
      real(wp), intent(in) :: uncertain(:)
      !> Forces, then displacements.
      real(wp), intent(inout) :: y(:)
      !> Motions that nothing resists.
      integer, intent(out) :: unresisted
      !> One of them that is loaded: (n); not allocated if there is none.
      real(wp), allocatable, intent(out) :: loaded(:)
      !> 0, or LAPACK's code.
      integer, intent(out) :: info
      real(wp), dimension(size(y)) :: columns, load, rows
      real(wp), dimension(size(y), size(y)) :: factor, free
      type(stiffness_t) :: scaled
      real(wp), allocatable :: s(:), u(:, :), v(:, :)
      integer, allocatable :: weak(:)
      integer :: i, j, n

      n = size(y)
      unresisted = 0
      ! A row that is nothing but noise is not to be made as large as the others.
      call scale(stiffness%k, 1.0e4_wp*max(maxval(abs(stiffness%errors), 3), round_off*stiffness%sizes), rows, columns)
      factor = spread(rows, 2, n)*spread(columns, 1, n)
      scaled%k = stiffness%k*factor
      scaled%sizes = stiffness%sizes*factor
      scaled%errors = stiffness%errors*spread(factor, 3, size(stiffness%errors, 3))
      call part_weak(scaled, u, v, weak, info, s)
      if (info /= 0) return
      load = rows*y
      y = 0.0_wp
      do i = 1, n
         if (any(weak == i)) then
            unresisted = unresisted + 1
            free(:, unresisted) = columns*v(:, i)
            if (.not. allocated(loaded) .and. is_loaded(u(:, i), load, rows*uncertain)) loaded = columns*v(:, i)
         else
            y = y + dot_product(u(:, i), load)/s(i)*v(:, i)
         end if
      end do
      y = columns*y
      ! What is least in scaled columns is not without such motions.
      do i = 1, unresisted
         do j = 1, i - 1
            free(:, i) = free(:, i) - dot_product(free(:, j), free(:, i))*free(:, j)
         end do
         free(:, i) = free(:, i)/norm2(free(:, i))
         y = y - dot_product(free(:, i), y)*free(:, i)
      end do
   end subroutine solve_doubtful

   !> Which of the singular motions nothing resists.
   subroutine part_weak(stiffness, u, v, weak, info, s)
      !> The tangent, scaled.
      type(stiffness_t), intent(in) :: stiffness
      !> Singular vectors that forces are weighed with: (n, n).
      real(wp), allocatable, intent(out) :: u(:, :)
      !> Those that are motions: (n, n).
      real(wp), allocatable, intent(out) :: v(:, :)
      !> Which are not resisted.
      integer, allocatable, intent(out) :: weak(:)
      !> 0, or LAPACK's code.
      integer, intent(out) :: info
      !> Singular values: (n).
      real(wp), allocatable, intent(out), optional :: s(:)
      real(wp), allocatable :: factor(:, :), values(:), vt(:, :), work(:)
      real(wp) :: query(1)
      integer :: i, n

      n = size(stiffness%k, 1)
      allocate (u(n, n), vt(n, n), values(n), source=0.0_wp)
      factor = stiffness%k
      call dgesvd('A', 'A', n, n, factor, n, values, u, n, vt, n, query, -1, info)
      allocate (work(int(query(1))), source=0.0_wp)
      call dgesvd('A', 'A', n, n, factor, n, values, u, n, vt, n, work, size(work), info)
      if (info /= 0) return
      v = transpose(vt)
      allocate (weak(0))
      do i = 1, n
         if (.not. values(i) > stiffness%worth(u(:, i), v(:, i))) weak = [weak, i]
      end do
      if (present(s)) s = values
   end subroutine part_weak

   !> Whether forces do work along a motion that nothing resists, beyond what they are worth.
   pure logical function is_loaded(p, load, uncertain)
      !> The motion, as forces are weighed with it: (n).
      real(wp), intent(in) :: p(:)
      !> The forces: (n).
      real(wp), intent(in) :: load(:)
      !> How much of each is not to be relied on: (n).
      real(wp), intent(in) :: uncertain(:)

      is_loaded = abs(dot_product(p, load)) > small_load*maxval(abs(load)) + dot_product(abs(p), uncertain)
   end function is_loaded

   !> Factors that bring the largest entry of each row and column to one, or below it.
   pure subroutine scale(k, floor, rows, columns)
      real(wp), intent(in) :: k(:, :), floor(:, :)
      real(wp), intent(out) :: rows(:), columns(:)
      integer :: i

      do i = 1, size(k, 1)
         rows(i) = inverse(max(maxval(abs(k(i, :))), maxval(floor(i, :))))
      end do
      do i = 1, size(k, 1)
         columns(i) = inverse(max(maxval(rows*abs(k(:, i))), maxval(rows*floor(:, i))))
      end do

   contains

      !> 1/x; zeros are not scaled.
      pure real(wp) function inverse(x)
         real(wp), intent(in) :: x

         inverse = 1.0_wp
         if (x > 1.0e-100_wp) inverse = 1.0_wp/x
      end function inverse

   end subroutine scale

end module taut_constrained_resistance
