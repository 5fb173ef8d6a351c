!> What makes a vector's columns of a matrix about as strong in all directions, whichever axes they are written in.
!!
!! Moments of forces on a rod that is 1e-6 as wide as long are as much smaller along it than across it, and the shares of rows of
!! forces in its translations differ as much: the smallest singular value of independent rows has the product of both. Beside
!! what is stretched along the weak directions it is as large as for parts of equal sides.
module taut_linalg_stretch
   use taut_kinds, only: wp
   use taut_linalg_rank, only: least_direction, weak_direction
   implicit none (type, external)
   private
   public :: find_stretch, needs_stretch, unstretched

contains

   !> Whether a direction may be weak, by the moments of the rows: quick, and never no where one is.
   pure function needs_stretch(gram) result(needed)
      !> Rows^T times rows: (m, m) with m = 2 or 3, of which the lower triangle is read.
      real(wp), intent(in) :: gram(:, :)
      !> False: none is.
      logical :: needed
      real(wp) :: det, trace

      if (size(gram, 1) == 2) then
         trace = gram(1, 1) + gram(2, 2)
         det = gram(1, 1)*gram(2, 2) - gram(2, 1)**2
         ! Of two positive numbers, the smaller is at least their product over their sum.
         needed = .not. det > weak_direction**2*trace**2
      else
         trace = gram(1, 1) + gram(2, 2) + gram(3, 3)
         det = gram(1, 1)*(gram(2, 2)*gram(3, 3) - gram(3, 2)**2) - gram(2, 1)*(gram(2, 1)*gram(3, 3) - gram(3, 2)*gram(3, 1)) + &
               gram(3, 1)*(gram(2, 1)*gram(3, 2) - gram(2, 2)*gram(3, 1))
         ! The product of the two larger ones is at most a quarter of the square of their sum.
         needed = .not. 4.0_wp*det > weak_direction**2*trace**3
      end if
   end function needs_stretch

   !> A symmetric matrix T so that no direction of the rows times T is weaker than a part of the strongest one; directions that
   !! are next to nothing stay that.
   !!
   !! By one-sided Jacobi rotations, to which small columns are as exact as large ones.
   !! Source: J. Demmel and K. Veselic, Jacobi's method is more accurate than QR, SIAM J. Matrix Anal. Appl. 13 (1992) 1204-1245.
   pure subroutine find_stretch(rows, t, most)
      !> What rows have of a vector: (rows, m), replaced by their shares in the principal directions.
      real(wp), intent(inout) :: rows(:, :)
      !> T: (m, m).
      real(wp), intent(out) :: t(:, :)
      !> The largest factor, 1 if no direction is stretched.
      real(wp), intent(out) :: most
      integer, parameter :: sweeps = 12
      real(wp) :: axes(size(rows, 2), size(rows, 2)), c, cross, s, strength(size(rows, 2)), tangent, zeta
      integer :: i, j, m, sweep
      logical :: turned

      m = size(rows, 2)
      axes(:, :) = 0.0_wp
      do i = 1, m
         axes(i, i) = 1.0_wp
      end do
      t(:, :) = axes
      most = 1.0_wp
      do sweep = 1, sweeps
         turned = .false.
         do i = 1, m - 1
            do j = i + 1, m
               strength(i) = norm2(rows(:, i))
               strength(j) = norm2(rows(:, j))
               cross = dot_product(rows(:, i), rows(:, j))
               ! What is left of dependent vectors may be too small to be divided by.
               if (abs(cross) <= 4.0_wp*max(epsilon(1.0_wp)*strength(i)*strength(j), &
                                            tiny(1.0_wp)*max(strength(i), strength(j))**2)) cycle
               turned = .true.
               zeta = 0.5_wp*(strength(j) - strength(i))*(strength(j) + strength(i))/cross
               tangent = sign(1.0_wp, zeta)/(abs(zeta) + hypot(1.0_wp, zeta))
               c = 1.0_wp/hypot(1.0_wp, tangent)
               s = c*tangent
               call turn(rows)
               call turn(axes)
            end do
         end do
         if (.not. turned) exit
      end do
      do i = 1, m
         strength(i) = norm2(rows(:, i))
      end do
      do i = 1, m
         if (strength(i) >= weak_direction*maxval(strength) .or. strength(i) <= least_direction*maxval(strength)) cycle
         c = weak_direction*maxval(strength)/strength(i)
         most = max(most, c)
         do j = 1, m
            t(:, j) = t(:, j) + (c - 1.0_wp)*axes(:, i)*axes(j, i)
         end do
      end do

   contains

      pure subroutine turn(a)
         real(wp), intent(inout) :: a(:, :)
         real(wp) :: before(size(a, 1))

         before(:) = a(:, i)
         a(:, i) = c*before - s*a(:, j)
         a(:, j) = s*before + c*a(:, j)
      end subroutine turn

   end subroutine find_stretch

   !> T^-1 x, by elimination.
   pure function unstretched(t, x) result(y)
      !> Symmetric and positive definite: (m, m).
      real(wp), intent(in) :: t(:, :)
      !> A vector: (m).
      real(wp), intent(in) :: x(:)
      !> T^-1 x: (m).
      real(wp) :: y(size(x))
      real(wp) :: a(size(x), size(x))
      integer :: i, j

      a(:, :) = t
      y(:) = x
      do i = 1, size(x)
         do j = i + 1, size(x)
            y(j) = y(j) - a(j, i)/a(i, i)*y(i)
            a(j, i + 1:) = a(j, i + 1:) - a(j, i)/a(i, i)*a(i, i + 1:)
         end do
      end do
      do i = size(x), 1, -1
         y(i) = (y(i) - dot_product(a(i, i + 1:), y(i + 1:)))/a(i, i)
      end do
   end function unstretched

end module taut_linalg_stretch
