!> Tests of what is told of joints that all but repeat each other.
module test_near
   use taut, only: error_t, mechanism_builder_t, mechanism_t, state_t, time_function_t, wp
   use taut_model_mechanism_function, only: function_ramp
   use testing, only: check, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_near

   real(wp), parameter :: o(3) = 0.0_wp, z(3) = [0.0_wp, 0.0_wp, 1.0_wp]

contains

   !> All tests of this module.
   function collect_near() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('an axis that is a little off', tilted), &
               new_test('a drive near its dead point', dead_point), &
               new_test('rods that all but fit', parallel_rods)]
   end function collect_near

   !> Four hinges in space, the last of which is tilted: from round-off to what is no mechanism any more.
   subroutine tilted(failure)
      character(:), allocatable, intent(inout) :: failure
      character(:), allocatable :: text
      real(wp), parameter :: tilts(7) = [0.0_wp, 1.0e-10_wp, 1.0e-8_wp, 1.0e-6_wp, 1.0e-4_wp, 1.0e-2_wp, 0.5_wp], &
                             b(3) = [0.0_wp, 0.4_wp, 0.0_wp], c(3) = [1.0_wp, 0.9_wp, 0.0_wp], d(3) = [1.0_wp, 0.0_wp, 0.0_wp]
      integer :: i

      do i = 1, size(tilts)
         block
            type(mechanism_builder_t) :: builder

            call builder%add_body('crank', mass=1.0_wp, shape='rod', thickness=0.02_wp, from=o, to=b)
            call builder%add_body('coupler', mass=1.0_wp, shape='rod', thickness=0.02_wp, from=b, to=c)
            call builder%add_body('rocker', mass=1.0_wp, shape='rod', thickness=0.02_wp, from=d, to=c)
            call builder%add_joint('A', 'revolute', 'ground', 'crank', point=o, axis=z)
            call builder%add_joint('B', 'revolute', 'crank', 'coupler', point=b, axis=z)
            call builder%add_joint('C', 'revolute', 'coupler', 'rocker', point=c, axis=z)
            call builder%add_joint('D', 'revolute', 'ground', 'rocker', point=d, axis=[0.0_wp, tilts(i), 1.0_wp])
            call diagnosis(builder, text, failure)
         end block
         if (allocated(failure)) return
         if (i == 1 .or. i == size(tilts)) then
            call check(failure, text == '', text)
         else
            call check(failure, index(text, 'A, B, C and D') == 1 .and. index(text, 'the axis of D is 1.000E-0') > 0, 'D: '//text)
         end if
      end do
   end subroutine tilted

   !> A crank-rocker whose rocker is driven, near where crank and coupler are in a line, and far from it.
   subroutine dead_point(failure)
      character(:), allocatable, intent(inout) :: failure
      character(:), allocatable :: text
      real(wp), parameter :: angles(3) = [1.0_wp, 1.0e-3_wp, 1.0e-5_wp]
      real(wp) :: a(3), b(3), d(3)
      integer :: i

      do i = 1, size(angles)
         block
            type(mechanism_builder_t) :: builder

            builder%planar = .true.
            a = [0.5_wp, 0.0_wp, 0.0_wp]
            b = a + 1.2_wp*[cos(angles(i)), sin(angles(i)), 0.0_wp]
            d = [1.4_wp, -0.7_wp, 0.0_wp]
            call builder%add_function(time_function_t(name='turn', kind=function_ramp, rate=0.5_wp))
            call builder%add_body('crank', mass=0.5_wp, shape='rod', from=o, to=a)
            call builder%add_body('coupler', mass=1.2_wp, shape='rod', from=a, to=b)
            call builder%add_body('rocker', mass=0.8_wp, shape='rod', from=d, to=b)
            call builder%add_joint('O', 'revolute', 'ground', 'crank', point=o)
            call builder%add_joint('A', 'revolute', 'crank', 'coupler', point=a)
            call builder%add_joint('B', 'revolute', 'coupler', 'rocker', point=b)
            call builder%add_joint('C', 'revolute', 'ground', 'rocker', point=d, drive_angle='turn')
            call diagnosis(builder, text, failure)
         end block
         if (allocated(failure)) return
         if (i == 1) then
            call check(failure, text == '', text)
         else
            call check(failure, index(text, 'a dead point, where C cannot be driven') > 0, 'C: '//text)
         end if
      end do
   end subroutine dead_point

   !> A parallelogram with a third rod, which is a little askew: it holds still.
   subroutine parallel_rods(failure)
      character(:), allocatable, intent(inout) :: failure
      character(:), allocatable :: text
      real(wp), parameter :: askew(2) = [0.0_wp, 1.0e-9_wp]
      real(wp) :: from(3), to(3)
      character :: rod
      integer :: i, k

      do i = 1, 2
         block
            type(mechanism_builder_t) :: builder

            builder%planar = .true.
            call builder%add_body('beam', mass=1.0_wp, shape='rod', from=[0.0_wp, 1.0_wp, 0.0_wp], to=[2.0_wp, 1.0_wp, 0.0_wp])
            do k = 1, 3
               rod = achar(iachar('0') + k)
               from = [k - 1.0_wp, 0.0_wp, 0.0_wp]
               to = from + [0.0_wp, 1.0_wp, 0.0_wp]
               if (k == 3) from(1) = from(1) + askew(i)
               call builder%add_body('rod'//rod, mass=1.0_wp, shape='rod', from=from, to=to)
               call builder%add_joint('low'//rod, 'revolute', 'ground', 'rod'//rod, point=from)
               call builder%add_joint('high'//rod, 'revolute', 'rod'//rod, 'beam', point=to)
            end do
            call diagnosis(builder, text, failure)
         end block
         if (allocated(failure)) return
         if (i == 1) then
            call check(failure, text == '', text)
         else
            call check(failure, index(text, 'low3') > 0 .and. index(text, 'leave one out') > 0, 'the third: '//text)
         end if
      end do
   end subroutine parallel_rods

   !> What is told of a mechanism where it starts; empty if nothing is.
   subroutine diagnosis(builder, text, failure)
      type(mechanism_builder_t), intent(inout) :: builder
      character(:), allocatable, intent(out) :: text
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_t) :: mechanism
      type(error_t), allocatable :: error
      type(state_t) :: at

      call builder%complete(mechanism, at, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      call mechanism%diagnose(at, text)
      if (.not. allocated(text)) text = ''
   end subroutine diagnosis

end module test_near
