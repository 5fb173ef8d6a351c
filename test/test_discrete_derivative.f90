!> The discrete derivative of constraints: its property at long displacements, with full rows and with a pattern.
module test_discrete_derivative
   use taut, only: wp
   use taut_constrained_discrete_derivative, only: meet_difference
   use taut_linalg_csr, only: csr_t
   use testing, only: check_below, new_test, test_t
   implicit none (type, external)
   private
   public :: collect_discrete_derivative

contains

   !> All tests of this module.
   function collect_discrete_derivative() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('differences of phi are met, along the coordinates of each row', differences), &
               new_test('what is met already stays, and so do rows that nothing moves', stays)]
   end function collect_discrete_derivative

   !> phi = {x^3 + y^2, sin(z) - x}, from x to x + d, with A of the middle.
   subroutine differences(failure)
      character(:), allocatable, intent(inout) :: failure
      real(wp), parameter :: x(3) = [0.3_wp, -0.7_wp, 0.4_wp], d(3) = [0.5_wp, 0.8_wp, -1.1_wp]
      real(wp) :: met(2), middle(3), wanted(2)
      type(csr_t) :: a
      integer :: i

      middle = x + 0.5_wp*d
      wanted = phi(x + d) - phi(x)
      do i = 1, 2
         if (i == 1) then
            call a%init(2, 3)
            call a%set_dense(reshape([3.0_wp*middle(1)**2, -1.0_wp, 2.0_wp*middle(2), 0.0_wp, 0.0_wp, cos(middle(3))], [2, 3]))
         else
            call a%set_pattern(3, [1, 3, 5], [1, 2, 1, 3])
            a%values(:) = [3.0_wp*middle(1)**2, 2.0_wp*middle(2), -1.0_wp, cos(middle(3))]
         end if
         call meet_difference(a, d, wanted)
         call a%multiply(d, met)
         call check_below(failure, maxval(abs(met - wanted)), 8.0_wp*epsilon(1.0_wp), 'differences')
         ! Off the middle by no more than the square of d, and not at all where a row has no coordinate.
         if (i == 2) call check_below(failure, abs(a%values(4) - cos(middle(3))), 0.2_wp, 'near A')
      end do
   end subroutine differences

   subroutine stays(failure)
      character(:), allocatable, intent(inout) :: failure
      real(wp), parameter :: values(4) = [1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp]
      type(csr_t) :: a

      call a%set_pattern(3, [1, 3, 5], [1, 2, 2, 3])
      a%values(:) = values
      call meet_difference(a, [0.5_wp, 0.25_wp, -0.5_wp], [1.0_wp, -1.25_wp])
      call check_below(failure, maxval(abs(a%values - values)), 0.0_wp, 'a linear constraint')
      call meet_difference(a, [0.0_wp, 0.0_wp, 1.0_wp], [0.0_wp, 5.0_wp])
      call check_below(failure, maxval(abs(a%values(1:2) - values(1:2))), 0.0_wp, 'a row that nothing moves')
      call check_below(failure, abs(a%values(4) - 5.0_wp), epsilon(1.0_wp), 'the other one')
   end subroutine stays

   pure function phi(x) result(value)
      real(wp), intent(in) :: x(3)
      real(wp) :: value(2)

      value = [x(1)**3 + x(2)**2, sin(x(3)) - x(1)]
   end function phi

end module test_discrete_derivative
