!> The value of a number's last bit.
module test_kinds
   use taut_error, only: to_text
   use taut_kinds, only: last_place, wp
   use testing, only: check, new_test, test_t
   implicit none (type, external)
   private
   public :: collect_kinds

contains

   !> All tests of this module.
   function collect_kinds() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('the last bit of numbers of any size', any_size)]
   end function collect_kinds

   !> It is the distance to the next number, at powers of two and on both sides of them.
   subroutine any_size(failure)
      character(:), allocatable, intent(inout) :: failure
      real(wp) :: number(4)
      integer :: i, power

      do power = -960, 1020, 60
         number(1) = 2.0_wp**power
         number(2) = nearest(number(1), -1.0_wp)
         number(3) = nearest(number(1), 1.0_wp)
         number(4) = 1.7_wp*number(1)
         do i = 1, size(number)
            call check(failure, abs(last_place(number(i)) - spacing(number(i))) <= 0.0_wp, 'last place of '//to_text(number(i)))
         end do
      end do
   end subroutine any_size

end module test_kinds
