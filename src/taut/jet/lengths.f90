!> Roots and lengths of jets. At a length of zero only what does not move has derivatives; the others are not numbers.
module taut_jet_lengths
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_quiet_nan, ieee_value
   use taut_kinds, only: wp
   use taut_jet_number, only: directions, jet_t, jet, operator(-)
   implicit none (type, external)
   private
   public :: sqrt, hypot, norm2, distance

   interface sqrt
      module procedure :: sqrt_jet
   end interface sqrt

   interface hypot
      module procedure :: hypot_jet_jet, hypot_jet_real, hypot_real_jet
   end interface hypot

   interface norm2
      module procedure :: norm2_jet
   end interface norm2

   interface distance
      module procedure :: distance_jet_jet, distance_jet_real, distance_real_jet, distance_columns
   end interface distance

contains

   !> The length of a vector that is zero, or not a number: what moves the vector has no derivative.
   pure function vanished(length, a) result(c)
      real(wp), intent(in) :: length
      type(jet_t), intent(in) :: a(:)
      type(jet_t) :: c

      real(wp) :: d(directions), dd
      integer :: i

      d = 0.0_wp
      dd = 0.0_wp
      do i = 1, size(a)
         d = d + abs(a(i)%d)
         dd = dd + abs(a(i)%dd)
      end do
      c = jet_t(length, unless_zero(d(1) + dd), unless_zero(d))
   end function vanished

   !> Zero where the argument is, else not a number.
   elemental function unless_zero(d) result(c)
      real(wp), intent(in) :: d
      real(wp) :: c

      c = 0.0_wp
      if (ieee_is_nan(d)) then
         c = d
      else if (abs(d) > 0.0_wp) then
         c = ieee_value(c, ieee_quiet_nan)
      end if
   end function unless_zero

   !> Square root.
   elemental function sqrt_jet(a) result(c)
      !> The argument.
      type(jet_t), intent(in) :: a
      !> The function.
      type(jet_t) :: c
      real(wp) :: f, r

      f = sqrt(a%v)
      if (f > 0.0_wp) then
         r = 0.5_wp/f
         c = jet_t(f, r*(a%dd - r*a%d(1)*a%d(1)/f), r*a%d)
      else
         c = vanished(f, [a])
      end if
   end function sqrt_jet

   !> sqrt(a^2 + b^2).
   elemental function hypot_jet_jet(a, b) result(c)
      !> The first argument.
      type(jet_t), intent(in) :: a
      !> The second argument.
      type(jet_t), intent(in) :: b
      !> The length.
      type(jet_t) :: c

      c = norm2_jet([a, b])
   end function hypot_jet_jet

   !> sqrt(a^2 + b^2).
   elemental function hypot_jet_real(a, b) result(c)
      !> The first argument.
      type(jet_t), intent(in) :: a
      !> The second argument.
      real(wp), intent(in) :: b
      !> The length.
      type(jet_t) :: c

      c = hypot_jet_jet(a, jet(b))
   end function hypot_jet_real

   !> sqrt(a^2 + b^2).
   elemental function hypot_real_jet(a, b) result(c)
      !> The first argument.
      real(wp), intent(in) :: a
      !> The second argument.
      type(jet_t), intent(in) :: b
      !> The length.
      type(jet_t) :: c

      c = hypot_jet_jet(jet(a), b)
   end function hypot_real_jet

   !> Length of a vector.
   pure function norm2_jet(a) result(c)
      !> The vector.
      type(jet_t), intent(in) :: a(:)
      !> sqrt(a . a).
      type(jet_t) :: c
      type(jet_t) :: s
      integer :: i

      s = jet_t(0.0_wp, 0.0_wp, 0.0_wp)
      !GCC$ unroll 1
      do i = 1, size(a)
         call add_square(a(i)%v, a(i)%dd, a(i)%d, s)
      end do
      if (s%v > 0.0_wp) then
         c = root(s)
      else
         c = vanished(s%v, a)
      end if
   end function norm2_jet

   !> Distance of two points, |a - b|.
   pure function distance_jet_jet(a, b) result(c)
      !> A point.
      type(jet_t), intent(in), contiguous :: a(:)
      !> Another point, of as many coordinates.
      type(jet_t), intent(in), contiguous :: b(:)
      !> Their distance.
      type(jet_t) :: c
      type(jet_t) :: only(1)

      call measure(size(a), 1, a, b, only)
      c = only(1)
   end function distance_jet_jet

   !> Distances of pairs of points, which are columns.
   pure function distance_columns(a, b) result(c)
      !> Points.
      type(jet_t), intent(in), contiguous :: a(:, :)
      !> As many others, of as many coordinates.
      type(jet_t), intent(in), contiguous :: b(:, :)
      !> Distance of each pair.
      type(jet_t) :: c(size(a, 2))

      call measure(size(a, 1), size(a, 2), a, b, c)
   end function distance_columns

   !> Distances of m pairs of points with n coordinates.
   pure subroutine measure(n, m, a, b, c)
      integer, intent(in) :: n, m
      type(jet_t), intent(in) :: a(n, m), b(n, m)
      type(jet_t), intent(out) :: c(m)
      real(wp) :: r, x, x1, y, y1, z, z1
      integer :: i, k

      if (n /= 2) then
         do i = 1, m
            c(i) = norm2_jet(a(:, i) - b(:, i))
         end do
         return
      end if
      !GCC$ unroll 1
      do i = 1, m
         x = a(1, i)%v - b(1, i)%v
         y = a(2, i)%v - b(2, i)%v
         z = sqrt(x*x + y*y)
         if (z > 0.0_wp) then
            r = 1.0_wp/z
            x1 = a(1, i)%d(1) - b(1, i)%d(1)
            y1 = a(2, i)%d(1) - b(2, i)%d(1)
            z1 = r*(x*x1 + y*y1)
            c(i)%v = z
            c(i)%dd = r*(x1*x1 + x*(a(1, i)%dd - b(1, i)%dd) + y1*y1 + y*(a(2, i)%dd - b(2, i)%dd) - z1*z1)
            ! Two at a time.
            !GCC$ unroll 2
            do k = 1, directions
               c(i)%d(k) = r*(x*(a(1, i)%d(k) - b(1, i)%d(k)) + y*(a(2, i)%d(k) - b(2, i)%d(k)))
            end do
         else
            c(i) = vanished(z, a(:, i) - b(:, i))
         end if
      end do
   end subroutine measure

   !> Distance of two points, |a - b|.
   pure function distance_jet_real(a, b) result(c)
      !> A point.
      type(jet_t), intent(in) :: a(:)
      !> Another point, of as many coordinates.
      real(wp), intent(in) :: b(:)
      !> Their distance.
      type(jet_t) :: c
      type(jet_t) :: s
      integer :: i

      s = jet_t(0.0_wp, 0.0_wp, 0.0_wp)
      !GCC$ unroll 1
      do i = 1, size(a)
         call add_square(a(i)%v - b(i), a(i)%dd, a(i)%d, s)
      end do
      if (s%v > 0.0_wp) then
         c = root(s)
      else
         c = vanished(s%v, a)
      end if
   end function distance_jet_real

   !> Distance of two points, |a - b|.
   pure function distance_real_jet(a, b) result(c)
      !> A point.
      real(wp), intent(in) :: a(:)
      !> Another point, of as many coordinates.
      type(jet_t), intent(in) :: b(:)
      !> Their distance.
      type(jet_t) :: c

      c = distance_jet_real(b, a)
   end function distance_real_jet

   !> Adds the square of a number with derivatives, and half the derivatives of that.
   pure subroutine add_square(v, dd, d, s)
      real(wp), intent(in) :: v, dd, d(directions)
      type(jet_t), intent(inout) :: s

      s = jet_t(s%v + v*v, s%dd + d(1)*d(1) + v*dd, s%d + v*d)
   end subroutine add_square

   !> The root of a sum of such squares.
   pure function root(s) result(c)
      type(jet_t), intent(in) :: s
      type(jet_t) :: c
      real(wp) :: r

      c%v = sqrt(s%v)
      r = 1.0_wp/c%v
      c%d = r*s%d
      c%dd = r*(s%dd - c%d(1)*c%d(1))
   end function root

end module taut_jet_lengths
