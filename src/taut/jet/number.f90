!> Numbers that carry derivatives along, and their arithmetic: see `taut_jet`.
!!
!! An operator is a call, and passes its result through memory: there are as many directions as two pairs of numbers, which a
!! processor handles at once, and no more.
module taut_jet_number
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use taut_kinds, only: wp
   implicit none (type, external)
   private
   public :: directions, jet_t, point, doubt, jet, assignment(=), operator(+), operator(-), operator(*), operator(/)

   !> How many directions a number has derivatives in.
   integer, parameter :: directions = 4

   !> A number with derivatives.
   type :: jet_t
      !> Value, and second derivative in the first direction.
      real(wp) :: v, dd
      !> First derivatives in each of the directions.
      real(wp) :: d(directions)
   end type jet_t

   interface jet
      module procedure :: jet_of_real, jet_of_path
   end interface jet

   interface assignment(=)
      module procedure :: assign_real, assign_integer
   end interface assignment(=)

   interface operator(+)
      module procedure :: plus, add, add_jet_real, add_real_jet, add_jet_integer, add_integer_jet
   end interface operator(+)

   interface operator(-)
      module procedure :: minus, subtract, subtract_jet_real, subtract_real_jet, subtract_jet_integer, subtract_integer_jet
   end interface operator(-)

   interface operator(*)
      module procedure :: multiply, multiply_jet_real, multiply_real_jet, multiply_jet_integer, multiply_integer_jet
   end interface operator(*)

   interface operator(/)
      module procedure :: divide, divide_jet_real, divide_real_jet, divide_jet_integer, divide_integer_jet
   end interface operator(/)

contains

   !> A constant.
   elemental function jet_of_real(v) result(c)
      !> Its value.
      real(wp), intent(in) :: v
      !> With derivatives of zero.
      type(jet_t) :: c

      c = jet_t(v, 0.0_wp, 0.0_wp)
   end function jet_of_real

   !> A number on a path.
   elemental function jet_of_path(v, rate, second) result(c)
      !> Value, first and second derivative along the path.
      real(wp), intent(in) :: v, rate, second
      !> With derivatives of zero in the other directions.
      type(jet_t) :: c

      c = jet_t(v, second, [rate, 0.0_wp, 0.0_wp, 0.0_wp])
   end function jet_of_path

   !> A constant.
   elemental subroutine assign_real(c, v)
      !> The jet, and its value.
      type(jet_t), intent(out) :: c
      real(wp), intent(in) :: v

      c = jet_t(v, 0.0_wp, 0.0_wp)
   end subroutine assign_real

   !> A constant.
   elemental subroutine assign_integer(c, v)
      !> The jet, and its value.
      type(jet_t), intent(out) :: c
      integer, intent(in) :: v

      c = jet_t(real(v, wp), 0.0_wp, 0.0_wp)
   end subroutine assign_integer

   !> a.
   elemental function plus(a) result(c)
      !> The operand.
      type(jet_t), intent(in) :: a
      !> The result.
      type(jet_t) :: c

      c = a
   end function plus

   !> -a.
   elemental function minus(a) result(c)
      !> The operand.
      type(jet_t), intent(in) :: a
      !> The result.
      type(jet_t) :: c

      c = jet_t(-a%v, -a%dd, -a%d)
   end function minus

   !> a + b.
   elemental function add(a, b) result(c)
      !> The operand on the left.
      type(jet_t), intent(in) :: a
      !> The operand on the right.
      type(jet_t), intent(in) :: b
      !> The result.
      type(jet_t) :: c

      c = jet_t(a%v + b%v, a%dd + b%dd, a%d + b%d)
   end function add

   !> a + b.
   elemental function add_jet_real(a, b) result(c)
      !> The operand on the left.
      type(jet_t), intent(in) :: a
      !> The operand on the right.
      real(wp), intent(in) :: b
      !> The result.
      type(jet_t) :: c

      c = jet_t(a%v + b, a%dd, a%d)
   end function add_jet_real

   !> a + b.
   elemental function add_real_jet(a, b) result(c)
      !> The operand on the left.
      real(wp), intent(in) :: a
      !> The operand on the right.
      type(jet_t), intent(in) :: b
      !> The result.
      type(jet_t) :: c

      c = jet_t(a + b%v, b%dd, b%d)
   end function add_real_jet

   !> a + b.
   elemental function add_jet_integer(a, b) result(c)
      !> The operand on the left.
      type(jet_t), intent(in) :: a
      !> The operand on the right.
      integer, intent(in) :: b
      !> The result.
      type(jet_t) :: c

      c = jet_t(a%v + real(b, wp), a%dd, a%d)
   end function add_jet_integer

   !> a + b.
   elemental function add_integer_jet(a, b) result(c)
      !> The operand on the left.
      integer, intent(in) :: a
      !> The operand on the right.
      type(jet_t), intent(in) :: b
      !> The result.
      type(jet_t) :: c

      c = jet_t(real(a, wp) + b%v, b%dd, b%d)
   end function add_integer_jet

   !> a - b.
   elemental function subtract(a, b) result(c)
      !> The operand on the left.
      type(jet_t), intent(in) :: a
      !> The operand on the right.
      type(jet_t), intent(in) :: b
      !> The result.
      type(jet_t) :: c

      c = jet_t(a%v - b%v, a%dd - b%dd, a%d - b%d)
   end function subtract

   !> a - b.
   elemental function subtract_jet_real(a, b) result(c)
      !> The operand on the left.
      type(jet_t), intent(in) :: a
      !> The operand on the right.
      real(wp), intent(in) :: b
      !> The result.
      type(jet_t) :: c

      c = jet_t(a%v - b, a%dd, a%d)
   end function subtract_jet_real

   !> a - b.
   elemental function subtract_real_jet(a, b) result(c)
      !> The operand on the left.
      real(wp), intent(in) :: a
      !> The operand on the right.
      type(jet_t), intent(in) :: b
      !> The result.
      type(jet_t) :: c

      c = jet_t(a - b%v, -b%dd, -b%d)
   end function subtract_real_jet

   !> a - b.
   elemental function subtract_jet_integer(a, b) result(c)
      !> The operand on the left.
      type(jet_t), intent(in) :: a
      !> The operand on the right.
      integer, intent(in) :: b
      !> The result.
      type(jet_t) :: c

      c = jet_t(a%v - real(b, wp), a%dd, a%d)
   end function subtract_jet_integer

   !> a - b.
   elemental function subtract_integer_jet(a, b) result(c)
      !> The operand on the left.
      integer, intent(in) :: a
      !> The operand on the right.
      type(jet_t), intent(in) :: b
      !> The result.
      type(jet_t) :: c

      c = jet_t(real(a, wp) - b%v, -b%dd, -b%d)
   end function subtract_integer_jet

   !> a b.
   elemental function multiply(a, b) result(c)
      !> The operand on the left.
      type(jet_t), intent(in) :: a
      !> The operand on the right.
      type(jet_t), intent(in) :: b
      !> The result.
      type(jet_t) :: c

      c = jet_t(a%v*b%v, a%v*b%dd + 2.0_wp*a%d(1)*b%d(1) + a%dd*b%v, a%v*b%d + a%d*b%v)
   end function multiply

   !> a b.
   elemental function multiply_jet_real(a, b) result(c)
      !> The operand on the left.
      type(jet_t), intent(in) :: a
      !> The operand on the right.
      real(wp), intent(in) :: b
      !> The result.
      type(jet_t) :: c

      c = jet_t(a%v*b, a%dd*b, a%d*b)
   end function multiply_jet_real

   !> a b.
   elemental function multiply_real_jet(a, b) result(c)
      !> The operand on the left.
      real(wp), intent(in) :: a
      !> The operand on the right.
      type(jet_t), intent(in) :: b
      !> The result.
      type(jet_t) :: c

      c = jet_t(a*b%v, a*b%dd, a*b%d)
   end function multiply_real_jet

   !> a b.
   elemental function multiply_jet_integer(a, b) result(c)
      !> The operand on the left.
      type(jet_t), intent(in) :: a
      !> The operand on the right.
      integer, intent(in) :: b
      !> The result.
      type(jet_t) :: c

      c = jet_t(a%v*b, a%dd*b, a%d*b)
   end function multiply_jet_integer

   !> a b.
   elemental function multiply_integer_jet(a, b) result(c)
      !> The operand on the left.
      integer, intent(in) :: a
      !> The operand on the right.
      type(jet_t), intent(in) :: b
      !> The result.
      type(jet_t) :: c

      c = jet_t(a*b%v, a*b%dd, a*b%d)
   end function multiply_integer_jet

   !> a/b.
   elemental function divide(a, b) result(c)
      !> The operand on the left.
      type(jet_t), intent(in) :: a
      !> The operand on the right.
      type(jet_t), intent(in) :: b
      !> The result.
      type(jet_t) :: c
      real(wp) :: r

      r = 1.0_wp/b%v
      c%v = a%v/b%v
      c%d = r*(a%d - c%v*b%d)
      c%dd = r*(a%dd - 2.0_wp*c%d(1)*b%d(1) - c%v*b%dd)
   end function divide

   !> a/b.
   elemental function divide_jet_real(a, b) result(c)
      !> The operand on the left.
      type(jet_t), intent(in) :: a
      !> The operand on the right.
      real(wp), intent(in) :: b
      !> The result.
      type(jet_t) :: c

      c = jet_t(a%v/b, a%dd/b, a%d/b)
   end function divide_jet_real

   !> a/b.
   elemental function divide_real_jet(a, b) result(c)
      !> The operand on the left.
      real(wp), intent(in) :: a
      !> The operand on the right.
      type(jet_t), intent(in) :: b
      !> The result.
      type(jet_t) :: c

      c = divide(jet_of_real(a), b)
   end function divide_real_jet

   !> a/b.
   elemental function divide_jet_integer(a, b) result(c)
      !> The operand on the left.
      type(jet_t), intent(in) :: a
      !> The operand on the right.
      integer, intent(in) :: b
      !> The result.
      type(jet_t) :: c

      c = jet_t(a%v/b, a%dd/b, a%d/b)
   end function divide_jet_integer

   !> a/b.
   elemental function divide_integer_jet(a, b) result(c)
      !> The operand on the left.
      integer, intent(in) :: a
      !> The operand on the right.
      type(jet_t), intent(in) :: b
      !> The result.
      type(jet_t) :: c

      c = divide(jet_of_real(real(a, wp)), b)
   end function divide_integer_jet

   !> Sets the derivative in a direction to one, if there is a direction of that number.
   elemental subroutine point(direction, z)
      !> From 1 to `directions`.
      integer, intent(in) :: direction
      !> The jet.
      type(jet_t), intent(inout) :: z

      if (direction >= 1 .and. direction <= size(z%d)) z%d(direction) = 1.0_wp
   end subroutine point

   !> Makes the derivative in a direction not a number, if there is a direction of that number; so it is in
   !! every result that depends on it.
   elemental subroutine doubt(direction, z)
      !> From 1 to `directions`.
      integer, intent(in) :: direction
      !> The jet.
      type(jet_t), intent(inout) :: z

      if (direction >= 1 .and. direction <= size(z%d)) z%d(direction) = ieee_value(z%v, ieee_quiet_nan)
   end subroutine doubt

end module taut_jet_number
