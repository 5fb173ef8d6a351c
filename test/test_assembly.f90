!> Tests of assembling: what is drawn far off reaches the branch that is meant, or is refused by name.
module test_assembly
   use taut, only: assemble_mechanism, error_t, integration_options_t, integration_result_t, mechanism_builder_t, mechanism_t, &
                   method_t, simulate, start_report_t, state_t, time_function_t, wp
   use taut_model_mechanism_body, only: pose_t
   use taut_model_mechanism_function, only: function_sine
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_assembly

   real(wp), parameter :: o(3) = 0.0_wp, z(3) = [0.0_wp, 0.0_wp, 1.0_wp], pi = acos(-1.0_wp)

contains

   !> All tests of this module.
   function collect_assembly() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('a drive is met wherever it was drawn', drives), &
               new_test('axes are not upside down', axes), &
               new_test('what does not turn stands as it is meant', frames), &
               new_test('a four-bar follows its crank the long way', four_bar), &
               new_test('half a turn that is held is refused by name', held_back), &
               new_test('a start on the other branch is refused by name', other_branch), &
               new_test('long steps do not end half a turn off', long_steps)]
   end function collect_assembly

   !> An arm in the plane, drawn at 0 and driven about its end by offset + amplitude sin(2 t).
   subroutine driven_arm(offset, amplitude, mechanism, at, error)
      real(wp), intent(in) :: offset, amplitude
      type(mechanism_t), intent(out) :: mechanism
      type(state_t), intent(out) :: at
      type(error_t), allocatable, intent(inout) :: error
      type(mechanism_builder_t) :: builder

      builder%planar = .true.
      call builder%add_body('arm', mass=1.0_wp, shape='rod', from=o, to=[1.0_wp, 0.0_wp, 0.0_wp])
      call builder%add_function(time_function_t(name='g', kind=function_sine, offset=offset, amplitude=amplitude, omega=2.0_wp))
      call builder%add_joint('hinge', 'revolute', 'ground', 'arm', point=o, drive_angle='g')
      call builder%complete(mechanism, at, error)
   end subroutine driven_arm

   subroutine drives(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(start_report_t) :: report
      type(error_t), allocatable :: error
      real(wp), parameter :: angles(6) = [2.0_wp, 3.0_wp, pi, -2.5_wp, 0.5_wp*pi, 8.0_wp]
      integer :: i

      do i = 1, size(angles)
         call driven_arm(angles(i), 0.0_wp, mechanism, at, error)
         call no_error(failure, error)
         if (.not. allocated(failure)) call assemble_mechanism(mechanism, method_t(weight='mass'), at, report, error)
         call no_error(failure, error)
         if (allocated(failure)) return
         call check_close(failure, cos(at%x(3) - angles(i)), 1.0_wp, 1.0e-14_wp, 'angle')
         call check_close(failure, at%x(1), 0.5_wp*cos(angles(i)), 1.0e-12_wp, 'x')
      end do
   end subroutine drives

   !> A body whose axes are turned by a rotation vector from those of the ground, and a joint between both.
   subroutine turned_body(type, turn, it, failure)
      character(*), intent(in) :: type
      real(wp), intent(in) :: turn(3)
      type(pose_t), intent(out) :: it
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(start_report_t) :: report
      type(error_t), allocatable :: error

      call builder%add_body('b', mass=1.0_wp, inertia=[0.1_wp, 0.11_wp, 0.12_wp], orientation=turn)
      call builder%add_joint('j', type, 'ground', 'b', point_1=o, point_2=o, axis_1=z, axis_2=z, in_body_axes=.true.)
      call builder%complete(mechanism, at, error)
      if (.not. allocated(error)) call assemble_mechanism(mechanism, method_t(weight='mass'), at, report, error)
      call no_error(failure, error)
      if (.not. allocated(failure)) call mechanism%pose_of(at, 1, it)
   end subroutine turned_body

   subroutine axes(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=11), parameter :: types(3) = [character(len=11) :: 'revolute', 'cylindrical', 'planar']
      real(wp), parameter :: turns(3, 3) = reshape([2.5_wp, 0.0_wp, 0.0_wp, 0.0_wp, pi, 0.0_wp, 1.5_wp, -2.0_wp, 0.5_wp], [3, 3])
      type(pose_t) :: it
      integer :: i, k

      do i = 1, size(types)
         do k = 1, 3
            call turned_body(trim(types(i)), turns(:, k), it, failure)
            if (allocated(failure)) return
            call check_close(failure, it%r(3, 3), 1.0_wp, 1.0e-14_wp, trim(types(i))//': the axis')
         end do
      end do
   end subroutine axes

   !> A slide whose axes were drawn apart turns back about their common normal, and about nothing else.
   subroutine frames(failure)
      character(:), allocatable, intent(inout) :: failure
      real(wp), parameter :: turns(2) = [2.5_wp, pi]
      type(pose_t) :: it
      integer :: k

      do k = 1, size(turns)
         call turned_body('prismatic', [turns(k), 0.0_wp, 0.0_wp], it, failure)
         if (allocated(failure)) return
         call check_close(failure, it%r(1, 1) + it%r(2, 2) + it%r(3, 3), 3.0_wp, 1.0e-13_wp, 'not turned')
      end do
   end subroutine frames

   !> Crank 1 on ground points (0, 0), coupler 3, rocker 3 at (3, 0), drawn with the crank along x and the rocker above, and the
   !! crank asked to be at 2.5 rad: the rocker's end stays above the line from the crank's end to the rocker's bearing.
   subroutine four_bar(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(start_report_t) :: report
      type(error_t), allocatable :: error
      real(wp), parameter :: goal = 2.5_wp, link = 3.0_wp
      real(wp) :: b(3), c(3), d(3), half, middle(3), normal(3), wanted(3)

      b = [1.0_wp, 0.0_wp, 0.0_wp]
      d = [3.0_wp, 0.0_wp, 0.0_wp]
      c = [2.0_wp, sqrt(8.0_wp), 0.0_wp]
      builder%planar = .true.
      call builder%add_body('crank', mass=1.0_wp, shape='rod', from=o, to=b)
      call builder%add_body('coupler', mass=1.0_wp, shape='rod', from=b, to=c)
      call builder%add_body('rocker', mass=1.0_wp, shape='rod', from=c, to=d)
      call builder%add_function(time_function_t(name='g', offset=goal))
      call builder%add_joint('A', 'revolute', 'ground', 'crank', point=o, drive_angle='g')
      call builder%add_joint('B', 'revolute', 'crank', 'coupler', point=b)
      call builder%add_joint('C', 'revolute', 'coupler', 'rocker', point=c)
      call builder%add_joint('D', 'revolute', 'ground', 'rocker', point=d)
      call builder%complete(mechanism, at, error)
      if (.not. allocated(error)) call assemble_mechanism(mechanism, method_t(weight='mass'), at, report, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      b = [cos(goal), sin(goal), 0.0_wp]
      middle = 0.5_wp*(b + d)
      half = 0.5_wp*norm2(d - b)
      normal = [-(d(2) - b(2)), d(1) - b(1), 0.0_wp]/norm2(d - b)
      wanted = 0.5_wp*(d + middle + sqrt(link**2 - half**2)*normal)
      call check_below(failure, norm2(at%x(7:8) - wanted(1:2)), 1.0e-11_wp, 'the middle of the rocker')
   end subroutine four_bar

   subroutine held_back(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(start_report_t) :: report
      type(error_t), allocatable :: error
      logical :: held(3)

      call driven_arm(pi, 0.0_wp, mechanism, at, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      held = [.false., .false., .true.]
      call assemble_mechanism(mechanism, method_t(weight='mass'), at, report, error, held)
      call check(failure, allocated(error), 'it is refused')
      if (allocated(failure)) return
      call check(failure, index(error%line(), 'joint "hinge" is half a turn from where its drive "g" wants it') > 0, error%line())
   end subroutine held_back

   subroutine other_branch(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(integration_result_t) :: result
      type(error_t), allocatable :: error

      call driven_arm(2.0_wp, 0.0_wp, mechanism, at, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      call simulate(mechanism, at, 1.0_wp, result, error)
      call check(failure, allocated(error), 'it is refused')
      if (allocated(failure)) return
      call check(failure, index(error%line(), 'joint "hinge" is half a turn from where') > 0, error%line())
   end subroutine other_branch

   !> Steps of a fixed length in which the drive turns back and forth by many radians: one that ends on the other branch is refused.
   subroutine long_steps(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(integration_result_t) :: result
      type(integration_options_t) :: options
      type(error_t), allocatable :: error
      real(wp), parameter :: amplitude = 30.0_wp
      real(wp) :: t_end
      integer :: i, stopped

      stopped = 0
      options%step_control = 'fixed'
      do i = 1, 10
         options%first_step = 2.4_wp + 0.06_wp*i
         t_end = 4.0_wp*options%first_step
         call driven_arm(0.0_wp, amplitude, mechanism, at, error)
         call no_error(failure, error)
         if (allocated(failure)) return
         call simulate(mechanism, at, t_end, result, error, options=options)
         call check(failure, allocated(error) .eqv. allocated(result%error), 'the call says how it went')
         if (allocated(failure)) return
         if (allocated(error)) deallocate (error)
         if (allocated(result%error)) then
            stopped = stopped + 1
            call check(failure, index(result%error%line(), 'joint "hinge" is half a turn') > 0, result%error%line())
         end if
         call check_close(failure, cos(at%x(3) - amplitude*sin(2.0_wp*at%t)), 1.0_wp, 1.0e-12_wp, 'the branch')
      end do
      call check(failure, stopped > 0 .and. stopped < 10, 'steps that are too long')
   end subroutine long_steps

end module test_assembly
