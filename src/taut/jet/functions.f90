!> Powers and elementary functions of jets. Where a derivative does not exist it is not a number; `abs`, `sign`, `min` and `max`
!! have the derivative of the branch that they take.
module taut_jet_functions
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use taut_kinds, only: wp
   use taut_jet_number, only: jet_t, jet, operator(*), operator(-)
   implicit none (type, external)
   private
   public :: operator(**), exp, log, sin, cos, tan, asin, acos, sinh, cosh, tanh, abs, atan2, atan, min, max, sign

   interface operator(**)
      module procedure :: power_integer, power_real, power_jet, power_real_jet
   end interface operator(**)

   interface exp
      module procedure :: exp_jet
   end interface exp

   interface log
      module procedure :: log_jet
   end interface log

   interface sin
      module procedure :: sin_jet
   end interface sin

   interface cos
      module procedure :: cos_jet
   end interface cos

   interface tan
      module procedure :: tan_jet
   end interface tan

   interface asin
      module procedure :: asin_jet
   end interface asin

   interface acos
      module procedure :: acos_jet
   end interface acos

   interface sinh
      module procedure :: sinh_jet
   end interface sinh

   interface cosh
      module procedure :: cosh_jet
   end interface cosh

   interface tanh
      module procedure :: tanh_jet
   end interface tanh

   interface abs
      module procedure :: abs_jet
   end interface abs

   interface atan2
      module procedure :: atan2_jet_jet, atan2_jet_real, atan2_real_jet
   end interface atan2

   interface atan
      module procedure :: atan_jet, atan2_jet_jet, atan2_jet_real, atan2_real_jet
   end interface atan

   interface min
      module procedure :: min_jet_jet, min_jet_real, min_real_jet
   end interface min

   interface max
      module procedure :: max_jet_jet, max_jet_real, max_real_jet
   end interface max

   interface sign
      module procedure :: sign_jet_jet, sign_jet_real, sign_real_jet
   end interface sign

contains

   !> f(a), given f and its derivatives at the value of a.
   elemental function chained(a, f, f1, f2) result(c)
      type(jet_t), intent(in) :: a
      real(wp), intent(in) :: f, f1, f2
      type(jet_t) :: c

      c = jet_t(f, f1*a%dd + f2*a%d(1)*a%d(1), f1*a%d)
   end function chained

   !> f(a, b), given f and its derivatives.
   elemental function chained_2(a, b, f, fa, fb, faa, fab, fbb) result(c)
      type(jet_t), intent(in) :: a, b
      real(wp), intent(in) :: f, fa, fb, faa, fab, fbb
      type(jet_t) :: c

      c = jet_t(f, fa*a%dd + fb*b%dd + faa*a%d(1)*a%d(1) + 2.0_wp*fab*a%d(1)*b%d(1) + fbb*b%d(1)*b%d(1), fa*a%d + fb*b%d)
   end function chained_2

   !> 1/z; not a number where z is zero.
   elemental function inverse(z) result(c)
      real(wp), intent(in) :: z
      real(wp) :: c

      if (abs(z) > 0.0_wp) then
         c = 1.0_wp/z
      else
         c = ieee_value(z, ieee_quiet_nan)
      end if
   end function inverse

   !> a**n.
   elemental function power_integer(a, n) result(c)
      !> Base.
      type(jet_t), intent(in) :: a
      !> Exponent.
      integer, intent(in) :: n
      !> The result.
      type(jet_t) :: c
      real(wp) :: f2

      select case (n)
      case (0)
         c = jet(1.0_wp)
      case (1)
         c = a
      case (2)
         c = a*a
      case default
         f2 = a%v**(n - 2)
         c = chained(a, f2*a%v*a%v, n*f2*a%v, real(n, wp)*(n - 1)*f2)
      end select
   end function power_integer

   !> a**p.
   elemental function power_real(a, p) result(c)
      !> Base.
      type(jet_t), intent(in) :: a
      !> Exponent.
      real(wp), intent(in) :: p
      !> The result.
      type(jet_t) :: c

      if (abs(p - anint(p)) <= 0.0_wp .and. abs(p) < 1.0e9_wp) then
         c = power_integer(a, nint(p))
      else
         c = chained(a, a%v**p, p*lower_power(a%v, p - 1.0_wp), p*(p - 1.0_wp)*lower_power(a%v, p - 2.0_wp))
      end if
   end function power_real

   !> v**p; not a number where that is infinite.
   elemental function lower_power(v, p) result(c)
      real(wp), intent(in) :: v, p
      real(wp) :: c

      if (p < 0.0_wp .and. abs(v) <= 0.0_wp) then
         c = ieee_value(c, ieee_quiet_nan)
      else
         c = v**p
      end if
   end function lower_power

   !> a**b, a positive.
   elemental function power_jet(a, b) result(c)
      !> Base.
      type(jet_t), intent(in) :: a
      !> Exponent.
      type(jet_t), intent(in) :: b
      !> The result.
      type(jet_t) :: c

      c = exp_jet(b*log_jet(a))
   end function power_jet

   !> a**b, a positive.
   elemental function power_real_jet(a, b) result(c)
      !> Base.
      real(wp), intent(in) :: a
      !> Exponent.
      type(jet_t), intent(in) :: b
      !> The result.
      type(jet_t) :: c

      c = exp_jet(b*log(a))
   end function power_real_jet

   !> Exponential function.
   elemental function exp_jet(a) result(c)
      !> The argument.
      type(jet_t), intent(in) :: a
      !> The function.
      type(jet_t) :: c
      real(wp) :: f

      f = exp(a%v)
      c = chained(a, f, f, f)
   end function exp_jet

   !> Natural logarithm.
   elemental function log_jet(a) result(c)
      !> The argument.
      type(jet_t), intent(in) :: a
      !> The function.
      type(jet_t) :: c
      real(wp) :: f

      f = 1.0_wp/a%v
      c = chained(a, log(a%v), f, -f*f)
   end function log_jet

   !> Sine [rad].
   elemental function sin_jet(a) result(c)
      !> The argument.
      type(jet_t), intent(in) :: a
      !> The function.
      type(jet_t) :: c
      real(wp) :: f

      f = sin(a%v)
      c = chained(a, f, cos(a%v), -f)
   end function sin_jet

   !> Cosine [rad].
   elemental function cos_jet(a) result(c)
      !> The argument.
      type(jet_t), intent(in) :: a
      !> The function.
      type(jet_t) :: c
      real(wp) :: f

      f = cos(a%v)
      c = chained(a, f, -sin(a%v), -f)
   end function cos_jet

   !> Tangent [rad].
   elemental function tan_jet(a) result(c)
      !> The argument.
      type(jet_t), intent(in) :: a
      !> The function.
      type(jet_t) :: c
      real(wp) :: f, g

      f = tan(a%v)
      g = 1.0_wp + f*f
      c = chained(a, f, g, 2.0_wp*f*g)
   end function tan_jet

   !> Inverse of the sine [rad].
   elemental function asin_jet(a) result(c)
      !> The argument.
      type(jet_t), intent(in) :: a
      !> The function.
      type(jet_t) :: c
      real(wp) :: f

      f = inverse(sqrt((1.0_wp - a%v)*(1.0_wp + a%v)))
      c = chained(a, asin(a%v), f, a%v*f*f*f)
   end function asin_jet

   !> Inverse of the cosine [rad].
   elemental function acos_jet(a) result(c)
      !> The argument.
      type(jet_t), intent(in) :: a
      !> The function.
      type(jet_t) :: c
      real(wp) :: f

      f = inverse(sqrt((1.0_wp - a%v)*(1.0_wp + a%v)))
      c = chained(a, acos(a%v), -f, -a%v*f*f*f)
   end function acos_jet

   !> Inverse of the tangent [rad].
   elemental function atan_jet(a) result(c)
      !> The argument.
      type(jet_t), intent(in) :: a
      !> The function.
      type(jet_t) :: c
      real(wp) :: f

      f = 1.0_wp/(1.0_wp + a%v*a%v)
      c = chained(a, atan(a%v), f, -2.0_wp*a%v*f*f)
   end function atan_jet

   !> Hyperbolic sine.
   elemental function sinh_jet(a) result(c)
      !> The argument.
      type(jet_t), intent(in) :: a
      !> The function.
      type(jet_t) :: c
      real(wp) :: f

      f = sinh(a%v)
      c = chained(a, f, cosh(a%v), f)
   end function sinh_jet

   !> Hyperbolic cosine.
   elemental function cosh_jet(a) result(c)
      !> The argument.
      type(jet_t), intent(in) :: a
      !> The function.
      type(jet_t) :: c
      real(wp) :: f

      f = cosh(a%v)
      c = chained(a, f, sinh(a%v), f)
   end function cosh_jet

   !> Hyperbolic tangent.
   elemental function tanh_jet(a) result(c)
      !> The argument.
      type(jet_t), intent(in) :: a
      !> The function.
      type(jet_t) :: c
      real(wp) :: f, g

      f = tanh(a%v)
      g = 1.0_wp - f*f
      c = chained(a, f, g, -2.0_wp*f*g)
   end function tanh_jet

   !> Absolute value.
   elemental function abs_jet(a) result(c)
      !> The argument.
      type(jet_t), intent(in) :: a
      !> a, or -a if it is negative.
      type(jet_t) :: c

      c = a
      if (a%v < 0.0_wp) c = -a
   end function abs_jet

   !> Angle of the point whose coordinates are a upward and b to the right [rad].
   elemental function atan2_jet_jet(a, b) result(c)
      !> The first argument.
      type(jet_t), intent(in) :: a
      !> The second argument.
      type(jet_t), intent(in) :: b
      !> From -pi to pi.
      type(jet_t) :: c
      real(wp) :: fa, fb, r

      r = inverse(a%v*a%v + b%v*b%v)
      fa = b%v*r
      fb = -a%v*r
      c = chained_2(a, b, atan2(a%v, b%v), fa, fb, 2.0_wp*fa*fb, fb*fb - fa*fa, -2.0_wp*fa*fb)
   end function atan2_jet_jet

   !> Angle of the point whose coordinates are a upward and b to the right [rad].
   elemental function atan2_jet_real(a, b) result(c)
      !> The first argument.
      type(jet_t), intent(in) :: a
      !> The second argument.
      real(wp), intent(in) :: b
      !> From -pi to pi.
      type(jet_t) :: c

      c = atan2_jet_jet(a, jet(b))
   end function atan2_jet_real

   !> Angle of the point whose coordinates are a upward and b to the right [rad].
   elemental function atan2_real_jet(a, b) result(c)
      !> The first argument.
      real(wp), intent(in) :: a
      !> The second argument.
      type(jet_t), intent(in) :: b
      !> From -pi to pi.
      type(jet_t) :: c

      c = atan2_jet_jet(jet(a), b)
   end function atan2_real_jet

   !> Smaller of two.
   elemental function min_jet_jet(a, b) result(c)
      !> The first argument.
      type(jet_t), intent(in) :: a
      !> The second argument.
      type(jet_t), intent(in) :: b
      !> The first where they are equal.
      type(jet_t) :: c

      c = b
      if (a%v <= b%v) c = a
   end function min_jet_jet

   !> Smaller of two.
   elemental function min_jet_real(a, b) result(c)
      !> The first argument.
      type(jet_t), intent(in) :: a
      !> The second argument.
      real(wp), intent(in) :: b
      !> The first where they are equal.
      type(jet_t) :: c

      c = min_jet_jet(a, jet(b))
   end function min_jet_real

   !> Smaller of two.
   elemental function min_real_jet(a, b) result(c)
      !> The first argument.
      real(wp), intent(in) :: a
      !> The second argument.
      type(jet_t), intent(in) :: b
      !> The first where they are equal.
      type(jet_t) :: c

      c = min_jet_jet(jet(a), b)
   end function min_real_jet

   !> Larger of two.
   elemental function max_jet_jet(a, b) result(c)
      !> The first argument.
      type(jet_t), intent(in) :: a
      !> The second argument.
      type(jet_t), intent(in) :: b
      !> The first where they are equal.
      type(jet_t) :: c

      c = b
      if (a%v >= b%v) c = a
   end function max_jet_jet

   !> Larger of two.
   elemental function max_jet_real(a, b) result(c)
      !> The first argument.
      type(jet_t), intent(in) :: a
      !> The second argument.
      real(wp), intent(in) :: b
      !> The first where they are equal.
      type(jet_t) :: c

      c = max_jet_jet(a, jet(b))
   end function max_jet_real

   !> Larger of two.
   elemental function max_real_jet(a, b) result(c)
      !> The first argument.
      real(wp), intent(in) :: a
      !> The second argument.
      type(jet_t), intent(in) :: b
      !> The first where they are equal.
      type(jet_t) :: c

      c = max_jet_jet(jet(a), b)
   end function max_real_jet

   !> |a| with the sign of b.
   elemental function sign_jet_jet(a, b) result(c)
      !> The first argument.
      type(jet_t), intent(in) :: a
      !> The second argument.
      type(jet_t), intent(in) :: b
      !> With the derivatives of |a|.
      type(jet_t) :: c

      c = a
      if (sign(1.0_wp, a%v)*sign(1.0_wp, b%v) < 0.0_wp) c = -a
   end function sign_jet_jet

   !> |a| with the sign of b.
   elemental function sign_jet_real(a, b) result(c)
      !> The first argument.
      type(jet_t), intent(in) :: a
      !> The second argument.
      real(wp), intent(in) :: b
      !> With the derivatives of |a|.
      type(jet_t) :: c

      c = sign_jet_jet(a, jet(b))
   end function sign_jet_real

   !> |a| with the sign of b.
   elemental function sign_real_jet(a, b) result(c)
      !> The first argument.
      real(wp), intent(in) :: a
      !> The second argument.
      type(jet_t), intent(in) :: b
      !> With the derivatives of |a|.
      type(jet_t) :: c

      c = sign_jet_jet(jet(a), b)
   end function sign_real_jet

end module taut_jet_functions
