!> Roots and lengths of jets. At a length of zero only what does not move has derivatives; the others are not numbers.
!!
!! Sums and their derivatives are numbers of their own, not components of a jet: so they stay in registers.
module taut_jet_lengths
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_quiet_nan, ieee_value
   use taut_kinds, only: wp
   use taut_jet_number, only: jet_t, jet, operator(-)
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
      module procedure :: distance_jet_jet, distance_jet_real, distance_real_jet
   end interface distance

contains

   !> The length of a vector that is zero, or not a number: what moves the vector has no derivative.
   pure function vanished(length, a) result(c)
      real(wp), intent(in) :: length
      type(jet_t), intent(in) :: a(:)
      type(jet_t) :: c

      c = jet_t(length, unless_zero(sum(abs(a%d1)) + sum(abs(a%dd))), unless_zero(sum(abs(a%d1))), unless_zero(sum(abs(a%d2))), &
                unless_zero(sum(abs(a%d3))), unless_zero(sum(abs(a%d4))))
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
         c = jet_t(f, r*(a%dd - r*a%d1*a%d1/f), r*a%d1, r*a%d2, r*a%d3, r*a%d4)
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
      real(wp) :: d1, d2, d3, d4, dd, s, z
      integer :: i

      s = 0.0_wp
      dd = 0.0_wp
      d1 = 0.0_wp
      d2 = 0.0_wp
      d3 = 0.0_wp
      d4 = 0.0_wp
      !GCC$ unroll 1
      do i = 1, size(a)
         z = a(i)%v
         s = s + z*z
         dd = dd + a(i)%d1*a(i)%d1 + z*a(i)%dd
         d1 = d1 + z*a(i)%d1
         d2 = d2 + z*a(i)%d2
         d3 = d3 + z*a(i)%d3
         d4 = d4 + z*a(i)%d4
      end do
      z = sqrt(s)
      if (z > 0.0_wp) then
         s = 1.0_wp/z
         d1 = s*d1
         c = jet_t(z, s*(dd - d1*d1), d1, s*d2, s*d3, s*d4)
      else
         c = vanished(z, a)
      end if
   end function norm2_jet

   !> Distance of two points, |a - b|.
   pure function distance_jet_jet(a, b) result(c)
      !> A point.
      type(jet_t), intent(in) :: a(:)
      !> Another point, of as many coordinates.
      type(jet_t), intent(in) :: b(:)
      !> Their distance.
      type(jet_t) :: c
      real(wp) :: d1, d2, d3, d4, dd, rate, s, z
      integer :: i

      if (size(a) == 2) then
         c = distance_in_plane(a(1), a(2), b(1), b(2))
         return
      end if
      s = 0.0_wp
      dd = 0.0_wp
      d1 = 0.0_wp
      d2 = 0.0_wp
      d3 = 0.0_wp
      d4 = 0.0_wp
      !GCC$ unroll 1
      do i = 1, size(a)
         z = a(i)%v - b(i)%v
         rate = a(i)%d1 - b(i)%d1
         s = s + z*z
         dd = dd + rate*rate + z*(a(i)%dd - b(i)%dd)
         d1 = d1 + z*rate
         d2 = d2 + z*(a(i)%d2 - b(i)%d2)
         d3 = d3 + z*(a(i)%d3 - b(i)%d3)
         d4 = d4 + z*(a(i)%d4 - b(i)%d4)
      end do
      z = sqrt(s)
      if (z > 0.0_wp) then
         s = 1.0_wp/z
         d1 = s*d1
         c = jet_t(z, s*(dd - d1*d1), d1, s*d2, s*d3, s*d4)
      else
         c = vanished(z, a - b)
      end if
   end function distance_jet_jet

   !> The same in the plane: without a loop the compiler does two derivatives at a time.
   pure function distance_in_plane(a1, a2, b1, b2) result(c)
      type(jet_t), intent(in) :: a1, a2, b1, b2
      type(jet_t) :: c
      real(wp) :: d1, r, x, x1, y, y1, z

      x = a1%v - b1%v
      y = a2%v - b2%v
      z = sqrt(x*x + y*y)
      if (z > 0.0_wp) then
         r = 1.0_wp/z
         x1 = a1%d1 - b1%d1
         y1 = a2%d1 - b2%d1
         d1 = r*(x*x1 + y*y1)
         c = jet_t(z, r*(x1*x1 + x*(a1%dd - b1%dd) + y1*y1 + y*(a2%dd - b2%dd) - d1*d1), d1, &
                   r*(x*(a1%d2 - b1%d2) + y*(a2%d2 - b2%d2)), r*(x*(a1%d3 - b1%d3) + y*(a2%d3 - b2%d3)), &
                   r*(x*(a1%d4 - b1%d4) + y*(a2%d4 - b2%d4)))
      else
         c = vanished(z, [a1, a2] - [b1, b2])
      end if
   end function distance_in_plane

   !> Distance of two points, |a - b|.
   pure function distance_jet_real(a, b) result(c)
      !> A point.
      type(jet_t), intent(in) :: a(:)
      !> Another point, of as many coordinates.
      real(wp), intent(in) :: b(:)
      !> Their distance.
      type(jet_t) :: c
      real(wp) :: d1, d2, d3, d4, dd, s, z
      integer :: i

      s = 0.0_wp
      dd = 0.0_wp
      d1 = 0.0_wp
      d2 = 0.0_wp
      d3 = 0.0_wp
      d4 = 0.0_wp
      !GCC$ unroll 1
      do i = 1, size(a)
         z = a(i)%v - b(i)
         s = s + z*z
         dd = dd + a(i)%d1*a(i)%d1 + z*a(i)%dd
         d1 = d1 + z*a(i)%d1
         d2 = d2 + z*a(i)%d2
         d3 = d3 + z*a(i)%d3
         d4 = d4 + z*a(i)%d4
      end do
      z = sqrt(s)
      if (z > 0.0_wp) then
         s = 1.0_wp/z
         d1 = s*d1
         c = jet_t(z, s*(dd - d1*d1), d1, s*d2, s*d3, s*d4)
      else
         c = vanished(z, a)
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

end module taut_jet_lengths
