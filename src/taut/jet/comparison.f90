!> Comparisons of jets: those of their values.
module taut_jet_comparison
   use taut_kinds, only: wp
   use taut_jet_number, only: jet_t
   implicit none (type, external)
   private
   public :: operator(==), operator(/=), operator(<), operator(<=), operator(>), operator(>=)

   interface operator(==)
      module procedure :: equal, equal_jet_real, equal_real_jet, equal_jet_integer, equal_integer_jet
   end interface operator(==)

   interface operator(/=)
      module procedure :: unequal, unequal_jet_real, unequal_real_jet, unequal_jet_integer, unequal_integer_jet
   end interface operator(/=)

   interface operator(<)
      module procedure :: less, less_jet_real, less_real_jet, less_jet_integer, less_integer_jet
   end interface operator(<)

   interface operator(<=)
      module procedure :: at_most, at_most_jet_real, at_most_real_jet, at_most_jet_integer, at_most_integer_jet
   end interface operator(<=)

   interface operator(>)
      module procedure :: greater, greater_jet_real, greater_real_jet, greater_jet_integer, greater_integer_jet
   end interface operator(>)

   interface operator(>=)
      module procedure :: at_least, at_least_jet_real, at_least_real_jet, at_least_jet_integer, at_least_integer_jet
   end interface operator(>=)

contains

   !> Of values.
   elemental function equal(a, b) result(c)
      !> The operand on the left.
      type(jet_t), intent(in) :: a
      !> The operand on the right.
      type(jet_t), intent(in) :: b
      !> The result.
      logical :: c

      c = a%v <= b%v .and. a%v >= b%v
   end function equal

   !> Of values.
   elemental function equal_jet_real(a, b) result(c)
      !> The operand on the left.
      type(jet_t), intent(in) :: a
      !> The operand on the right.
      real(wp), intent(in) :: b
      !> The result.
      logical :: c

      c = a%v <= b .and. a%v >= b
   end function equal_jet_real

   !> Of values.
   elemental function equal_real_jet(a, b) result(c)
      !> The operand on the left.
      real(wp), intent(in) :: a
      !> The operand on the right.
      type(jet_t), intent(in) :: b
      !> The result.
      logical :: c

      c = a <= b%v .and. a >= b%v
   end function equal_real_jet

   !> Of values.
   elemental function equal_jet_integer(a, b) result(c)
      !> The operand on the left.
      type(jet_t), intent(in) :: a
      !> The operand on the right.
      integer, intent(in) :: b
      !> The result.
      logical :: c

      c = a%v <= real(b, wp) .and. a%v >= real(b, wp)
   end function equal_jet_integer

   !> Of values.
   elemental function equal_integer_jet(a, b) result(c)
      !> The operand on the left.
      integer, intent(in) :: a
      !> The operand on the right.
      type(jet_t), intent(in) :: b
      !> The result.
      logical :: c

      c = real(a, wp) <= b%v .and. real(a, wp) >= b%v
   end function equal_integer_jet

   !> Of values.
   elemental function unequal(a, b) result(c)
      !> The operand on the left.
      type(jet_t), intent(in) :: a
      !> The operand on the right.
      type(jet_t), intent(in) :: b
      !> The result.
      logical :: c

      c = .not. (a%v <= b%v .and. a%v >= b%v)
   end function unequal

   !> Of values.
   elemental function unequal_jet_real(a, b) result(c)
      !> The operand on the left.
      type(jet_t), intent(in) :: a
      !> The operand on the right.
      real(wp), intent(in) :: b
      !> The result.
      logical :: c

      c = .not. (a%v <= b .and. a%v >= b)
   end function unequal_jet_real

   !> Of values.
   elemental function unequal_real_jet(a, b) result(c)
      !> The operand on the left.
      real(wp), intent(in) :: a
      !> The operand on the right.
      type(jet_t), intent(in) :: b
      !> The result.
      logical :: c

      c = .not. (a <= b%v .and. a >= b%v)
   end function unequal_real_jet

   !> Of values.
   elemental function unequal_jet_integer(a, b) result(c)
      !> The operand on the left.
      type(jet_t), intent(in) :: a
      !> The operand on the right.
      integer, intent(in) :: b
      !> The result.
      logical :: c

      c = .not. (a%v <= real(b, wp) .and. a%v >= real(b, wp))
   end function unequal_jet_integer

   !> Of values.
   elemental function unequal_integer_jet(a, b) result(c)
      !> The operand on the left.
      integer, intent(in) :: a
      !> The operand on the right.
      type(jet_t), intent(in) :: b
      !> The result.
      logical :: c

      c = .not. (real(a, wp) <= b%v .and. real(a, wp) >= b%v)
   end function unequal_integer_jet

   !> Of values.
   elemental function less(a, b) result(c)
      !> The operand on the left.
      type(jet_t), intent(in) :: a
      !> The operand on the right.
      type(jet_t), intent(in) :: b
      !> The result.
      logical :: c

      c = a%v < b%v
   end function less

   !> Of values.
   elemental function less_jet_real(a, b) result(c)
      !> The operand on the left.
      type(jet_t), intent(in) :: a
      !> The operand on the right.
      real(wp), intent(in) :: b
      !> The result.
      logical :: c

      c = a%v < b
   end function less_jet_real

   !> Of values.
   elemental function less_real_jet(a, b) result(c)
      !> The operand on the left.
      real(wp), intent(in) :: a
      !> The operand on the right.
      type(jet_t), intent(in) :: b
      !> The result.
      logical :: c

      c = a < b%v
   end function less_real_jet

   !> Of values.
   elemental function less_jet_integer(a, b) result(c)
      !> The operand on the left.
      type(jet_t), intent(in) :: a
      !> The operand on the right.
      integer, intent(in) :: b
      !> The result.
      logical :: c

      c = a%v < real(b, wp)
   end function less_jet_integer

   !> Of values.
   elemental function less_integer_jet(a, b) result(c)
      !> The operand on the left.
      integer, intent(in) :: a
      !> The operand on the right.
      type(jet_t), intent(in) :: b
      !> The result.
      logical :: c

      c = real(a, wp) < b%v
   end function less_integer_jet

   !> Of values.
   elemental function at_most(a, b) result(c)
      !> The operand on the left.
      type(jet_t), intent(in) :: a
      !> The operand on the right.
      type(jet_t), intent(in) :: b
      !> The result.
      logical :: c

      c = a%v <= b%v
   end function at_most

   !> Of values.
   elemental function at_most_jet_real(a, b) result(c)
      !> The operand on the left.
      type(jet_t), intent(in) :: a
      !> The operand on the right.
      real(wp), intent(in) :: b
      !> The result.
      logical :: c

      c = a%v <= b
   end function at_most_jet_real

   !> Of values.
   elemental function at_most_real_jet(a, b) result(c)
      !> The operand on the left.
      real(wp), intent(in) :: a
      !> The operand on the right.
      type(jet_t), intent(in) :: b
      !> The result.
      logical :: c

      c = a <= b%v
   end function at_most_real_jet

   !> Of values.
   elemental function at_most_jet_integer(a, b) result(c)
      !> The operand on the left.
      type(jet_t), intent(in) :: a
      !> The operand on the right.
      integer, intent(in) :: b
      !> The result.
      logical :: c

      c = a%v <= real(b, wp)
   end function at_most_jet_integer

   !> Of values.
   elemental function at_most_integer_jet(a, b) result(c)
      !> The operand on the left.
      integer, intent(in) :: a
      !> The operand on the right.
      type(jet_t), intent(in) :: b
      !> The result.
      logical :: c

      c = real(a, wp) <= b%v
   end function at_most_integer_jet

   !> Of values.
   elemental function greater(a, b) result(c)
      !> The operand on the left.
      type(jet_t), intent(in) :: a
      !> The operand on the right.
      type(jet_t), intent(in) :: b
      !> The result.
      logical :: c

      c = a%v > b%v
   end function greater

   !> Of values.
   elemental function greater_jet_real(a, b) result(c)
      !> The operand on the left.
      type(jet_t), intent(in) :: a
      !> The operand on the right.
      real(wp), intent(in) :: b
      !> The result.
      logical :: c

      c = a%v > b
   end function greater_jet_real

   !> Of values.
   elemental function greater_real_jet(a, b) result(c)
      !> The operand on the left.
      real(wp), intent(in) :: a
      !> The operand on the right.
      type(jet_t), intent(in) :: b
      !> The result.
      logical :: c

      c = a > b%v
   end function greater_real_jet

   !> Of values.
   elemental function greater_jet_integer(a, b) result(c)
      !> The operand on the left.
      type(jet_t), intent(in) :: a
      !> The operand on the right.
      integer, intent(in) :: b
      !> The result.
      logical :: c

      c = a%v > real(b, wp)
   end function greater_jet_integer

   !> Of values.
   elemental function greater_integer_jet(a, b) result(c)
      !> The operand on the left.
      integer, intent(in) :: a
      !> The operand on the right.
      type(jet_t), intent(in) :: b
      !> The result.
      logical :: c

      c = real(a, wp) > b%v
   end function greater_integer_jet

   !> Of values.
   elemental function at_least(a, b) result(c)
      !> The operand on the left.
      type(jet_t), intent(in) :: a
      !> The operand on the right.
      type(jet_t), intent(in) :: b
      !> The result.
      logical :: c

      c = a%v >= b%v
   end function at_least

   !> Of values.
   elemental function at_least_jet_real(a, b) result(c)
      !> The operand on the left.
      type(jet_t), intent(in) :: a
      !> The operand on the right.
      real(wp), intent(in) :: b
      !> The result.
      logical :: c

      c = a%v >= b
   end function at_least_jet_real

   !> Of values.
   elemental function at_least_real_jet(a, b) result(c)
      !> The operand on the left.
      real(wp), intent(in) :: a
      !> The operand on the right.
      type(jet_t), intent(in) :: b
      !> The result.
      logical :: c

      c = a >= b%v
   end function at_least_real_jet

   !> Of values.
   elemental function at_least_jet_integer(a, b) result(c)
      !> The operand on the left.
      type(jet_t), intent(in) :: a
      !> The operand on the right.
      integer, intent(in) :: b
      !> The result.
      logical :: c

      c = a%v >= real(b, wp)
   end function at_least_jet_integer

   !> Of values.
   elemental function at_least_integer_jet(a, b) result(c)
      !> The operand on the left.
      integer, intent(in) :: a
      !> The operand on the right.
      type(jet_t), intent(in) :: b
      !> The result.
      logical :: c

      c = real(a, wp) >= b%v
   end function at_least_integer_jet

end module taut_jet_comparison
