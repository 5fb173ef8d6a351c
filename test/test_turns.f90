!> Tests of angles that count their turns: in the plane, in space and where they are driven; springs, events and columns.
module test_turns
   use taut, only: error_t, integration_options_t, integration_result_t, mechanism_builder_t, mechanism_t, &
                   model_events_t, simulate, state_t, time_function_t, wp
   use taut_model_mechanism_body, only: pose_t
   use taut_model_mechanism_function, only: function_ramp
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_turns

   real(wp), parameter :: o(3) = 0.0_wp, axis(3) = [0.6_wp, 0.0_wp, 0.8_wp], pi = acos(-1.0_wp)

contains

   !> All tests of this module.
   function collect_turns() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('a torsion spring winds up', winds_up), &
               new_test('a torsion spring is wound', wound), &
               new_test('a stated angle keeps its turns', stated), &
               new_test('a driven angle has the turns of its drive', driven), &
               new_test('a rotor does not lose a turn', rotor), &
               new_test('an angle is passed once, and not half a turn away', passed), &
               new_test('counting turns changes no step', no_step_changes), &
               new_test('the angle is an output, and its turns a coordinate', one_output)]
   end function collect_turns

   !> A disc of 1 kg m^2 about a hinge, in the plane or in space, with a torsion spring of 1 N m/rad.
   subroutine disc(planar, speed, builder)
      logical, intent(in) :: planar
      real(wp), intent(in) :: speed
      type(mechanism_builder_t), intent(out) :: builder

      builder%planar = planar
      if (planar) then
         call builder%add_body('disc', mass=1.0_wp, inertia=[1.0_wp], angle_rate=speed)
         call builder%add_joint('pin', 'revolute', 'ground', 'disc', point=o)
      else
         call builder%add_body('disc', mass=1.0_wp, inertia=[1.0_wp, 1.0_wp, 1.0_wp], orientation=[0.3_wp, -0.2_wp, 0.1_wp], &
                               angular_velocity=speed*axis)
         call builder%add_joint('pin', 'revolute', 'ground', 'disc', point=o, axis=axis)
      end if
   end subroutine disc

   !> Takes everything out.
   subroutine clear(builder)
      type(mechanism_builder_t), intent(out) :: builder

      builder%planar = .false.
   end subroutine clear

   !> The angle of the first joint.
   real(wp) function angle_at(mechanism, at) result(angle)
      type(mechanism_t), intent(in) :: mechanism
      type(state_t), intent(in) :: at
      type(pose_t) :: one, two

      call mechanism%pose_of(at, mechanism%joints(1)%body_1, one)
      call mechanism%pose_of(at, mechanism%joints(1)%body_2, two)
      angle = mechanism%angle_of(at, mechanism%joints(1), one, two)
   end function angle_at

   !> 10 sin(t), by either integrator.
   subroutine winds_up(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(integration_result_t) :: result
      type(integration_options_t) :: options
      type(error_t), allocatable :: error
      character(len=6), parameter :: integrators(2) = [character(len=6) :: 'dopri5', 'radau ']
      real(wp), parameter :: times(3) = [1.0_wp, 0.5_wp*pi, 5.0_wp]
      integer :: i, j, k

      do k = 1, 2
         do j = 1, 2
            call disc(k == 1, 10.0_wp, builder)
            call builder%add_spring(joint='pin', stiffness=1.0_wp)
            call builder%complete(mechanism, at, error)
            call no_error(failure, error)
            options = integration_options_t(rtol=1.0e-9_wp, atol=1.0e-10_wp, integrator=integrators(j))
            do i = 1, size(times)
               if (allocated(failure)) return
               call simulate(mechanism, at, times(i), result, error, options=options)
               call no_error(failure, error)
               call check_close(failure, angle_at(mechanism, at), 10.0_wp*sin(times(i)), 1.0e-6_wp, integrators(j))
            end do
            call check_close(failure, mechanism%energy(at), 50.0_wp, 1.0e-5_wp, 'energy')
         end do
      end do
   end subroutine winds_up

   subroutine wound(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp), allocatable :: f(:)
      integer :: k

      do k = 1, 2
         call disc(k == 1, 0.0_wp, builder)
         call builder%add_spring(joint='pin', stiffness=1.0_wp, free_angle=8.0_wp)
         call builder%complete(mechanism, at, error)
         call no_error(failure, error)
         if (allocated(failure)) return
         allocate (f(mechanism%n))
         call mechanism%force(at, f)
         ! The only other velocities are those of the center of mass.
         call check_close(failure, norm2(f), 8.0_wp, 1.0e-12_wp, 'moment')
         deallocate (f)
      end do
   end subroutine wound

   !> Drawn at 8 rad, of which 2 pi cannot be seen; what is drawn is also where its spring is free.
   subroutine stated(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(error_t), allocatable :: error
      integer :: k

      do k = 1, 2
         call clear(builder)
         builder%planar = k == 1
         if (k == 1) then
            call builder%add_body('disc', mass=1.0_wp, inertia=[1.0_wp])
            call builder%add_joint('pin', 'revolute', 'ground', 'disc', point=o, angle=8.0_wp)
         else
            call builder%add_body('disc', mass=1.0_wp, inertia=[1.0_wp, 1.0_wp, 1.0_wp])
            call builder%add_joint('pin', 'revolute', 'ground', 'disc', point=o, axis=axis, angle=8.0_wp)
         end if
         call builder%add_spring(joint='pin', stiffness=1.0_wp)
         call builder%complete(mechanism, at, error)
         call no_error(failure, error)
         if (allocated(failure)) return
         call check_close(failure, angle_at(mechanism, at), 8.0_wp, 1.0e-12_wp, 'angle')
         call check_close(failure, mechanism%energy(at), 0.0_wp, 1.0e-12_wp, 'the spring')
      end do
   end subroutine stated

   subroutine driven(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      integer :: k

      do k = 1, 2
         call clear(builder)
         builder%planar = k == 1
         call builder%add_function(time_function_t(name='g', kind=function_ramp, rate=10.0_wp))
         if (k == 1) then
            call builder%add_body('disc', mass=1.0_wp, inertia=[1.0_wp])
            call builder%add_joint('pin', 'revolute', 'ground', 'disc', point=o, drive_angle='g')
         else
            call builder%add_body('disc', mass=1.0_wp, inertia=[1.0_wp, 1.0_wp, 1.0_wp])
            call builder%add_joint('pin', 'revolute', 'ground', 'disc', point=o, axis=axis, drive_angle='g')
         end if
         call builder%complete(mechanism, at, error)
         call no_error(failure, error)
         if (allocated(failure)) return
         call check(failure, size(mechanism%counting) == 0, 'nothing to count')
         call simulate(mechanism, at, 3.0_wp, result, error)
         call no_error(failure, error)
         call check_close(failure, angle_at(mechanism, at), 30.0_wp, 1.0e-11_wp, 'angle')
      end do
   end subroutine driven

   !> 1000 rad at a loose tolerance: the coordinate is the angle between the bodies, to round-off, and whole turns.
   subroutine rotor(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(integration_result_t) :: result
      type(error_t), allocatable :: error

      call disc(.false., -100.0_wp, builder)
      call builder%complete(mechanism, at, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      call simulate(mechanism, at, 10.0_wp, result, error, options=integration_options_t(rtol=1.0e-3_wp, atol=1.0e-5_wp))
      call no_error(failure, error)
      call check_close(failure, at%x(8), angle_at(mechanism, at), 1.0e-11_wp, 'the coordinate')
      call check_close(failure, at%x(8), -1000.0_wp, 3.0_wp, 'the turns')
   end subroutine rotor

   !> 10 sin(t) passes 8 at asin(0.8) and at pi less that, within 5 s, and nothing else.
   subroutine passed(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      type(model_events_t) :: events
      integer :: k

      do k = 1, 2
         call disc(k == 1, 10.0_wp, builder)
         call builder%add_spring(joint='pin', stiffness=1.0_wp)
         call builder%add_event('there', 'angle', 8.0_wp, joint='pin')
         call builder%complete(mechanism, at, error)
         call no_error(failure, error)
         if (allocated(failure)) return
         call events%init(mechanism)
         call simulate(mechanism, at, 5.0_wp, result, error, options=integration_options_t(rtol=1.0e-9_wp, atol=1.0e-10_wp), &
                       events=events)
         call no_error(failure, error)
         call check(failure, size(result%events) == 2, 'two of them')
         if (allocated(failure)) return
         call check_close(failure, result%events(1)%t, asin(0.8_wp), 1.0e-7_wp, 'the first')
         call check_close(failure, result%events(2)%t, pi - asin(0.8_wp), 1.0e-7_wp, 'the second')
      end do
   end subroutine passed

   !> A pendulum with and without its turns: the same steps, round-off aside, for sums are in another order.
   subroutine no_step_changes(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: mechanism
      type(state_t) :: at(2)
      type(integration_result_t) :: result(2)
      type(error_t), allocatable :: error
      integer :: k

      do k = 1, 2
         call clear(builder)
         builder%gravity = [0.0_wp, 0.0_wp, -9.81_wp]
         call builder%add_body('rod', mass=1.0_wp, shape='rod', from=o, to=[0.0_wp, 1.0_wp, 0.1_wp], angular_velocity=8.0_wp*axis)
         call builder%add_joint('pin', 'revolute', 'ground', 'rod', point=o, axis=axis)
         if (k == 2) call builder%show_joints([character(len=1) ::])
         call builder%complete(mechanism, at(k), error)
         call no_error(failure, error)
         if (allocated(failure)) return
         call check(failure, mechanism%n_x == merge(8, 7, k == 1), 'coordinates')
         call simulate(mechanism, at(k), 3.0_wp, result(k), error, options=integration_options_t(rtol=1.0e-5_wp, atol=1.0e-8_wp))
         call no_error(failure, error)
      end do
      call check(failure, result(1)%steps == result(2)%steps, 'steps')
      call check_below(failure, maxval(abs(at(1)%x(1:7) - at(2)%x)), 1.0e-9_wp, 'positions')
   end subroutine no_step_changes

   subroutine one_output(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(error_t), allocatable :: error
      character(:), allocatable :: name
      integer :: i, met

      call disc(.false., 1.0_wp, builder)
      call builder%complete(mechanism, at, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      name = trim(mechanism%x_name(8))
      call check(failure, name == 'pin.angle', name)
      met = 0
      do i = 1, mechanism%n_outputs
         name = mechanism%output_name(i)
         if (name == 'pin.angle') met = met + 1
      end do
      call check(failure, met == 1, 'an output')
   end subroutine one_output

end module test_turns
