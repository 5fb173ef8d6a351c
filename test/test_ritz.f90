!> Systems reduced to Ritz shapes.
module test_ritz
   use closed_forms, only: pendulum_motion
   use systems, only: compound_t, new_compound, new_particle, particle_t, two_rods
   use taut, only: consistent_start, constrained_ode_t, error_t, finding_t, integration_options_t, integration_result_t, method_t, &
                   name_length, new_ritz, ritz_t, sample_t, simulate, start_report_t, state_t, verify, wp
   use taut_constrained_model_events, only: model_events_t
   use taut_model_helicopter, only: helicopter_data_t, helicopter_t, new_helicopter
   use taut_model_pendulum, only: new_pendulum, pendulum_t
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_ritz

   real(wp), parameter :: g = 9.81_wp

   !> A pendulum that announces its passages of the bottom.
   type, extends(pendulum_t) :: watched_t
   contains
      procedure :: event_values => bottom
      procedure :: event_name => bottom_name
   end type watched_t

contains

   !> All tests of this module.
   function collect_ritz() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('a complete set of shapes changes nothing', complete_set), &
               new_test('reduced matrices pass the checker', reduced_is_consistent), &
               new_test('a spring in the place of a constraint, and outputs', spring_and_outputs), &
               new_test('events of the full system', events_pass), &
               new_test('shapes that cannot meet the constraints', mild_inconsistency), &
               new_test('bad input', bad_input)]
   end function collect_ritz

   function oblique() result(shapes)
      real(wp) :: shapes(2, 2)

      shapes = reshape([2.0_wp, 0.5_wp, 1.0_wp, 1.0_wp], [2, 2])
   end function oblique

   subroutine complete_set(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=16), parameter :: weight(3) = [character(len=16) :: 'identity', 'mass', 'given']
      type(pendulum_t) :: pendulum
      type(ritz_t) :: ritz
      type(method_t) :: method
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(state_t) :: at, there
      type(error_t), allocatable :: error
      real(wp) :: angle, period, rate
      integer :: i

      options%rtol = 1.0e-11_wp
      options%atol = 1.0e-11_wp
      call new_pendulum(pendulum, 1.0_wp, 1.0_wp, g, 1, error)
      call new_ritz(ritz, pendulum, oblique(), [1.0_wp, 0.0_wp], error)
      call no_error(failure, error)
      call pendulum_motion(3.0_wp, 1.0_wp, g, 0.5_wp*acos(-1.0_wp), angle, rate, period)
      do i = 1, 3
         method%weight = weight(i)
         at%t = 0.0_wp
         at%x = [0.0_wp, 0.0_wp]
         at%v = [0.0_wp, 0.0_wp]
         call simulate(ritz, at, 3.0_wp, result, error, method, options)
         call no_error(failure, error)
         there = ritz%full_state(at)
         call check_below(failure, maxval(abs(there%x - [sin(angle), -cos(angle)])), 1.0e-8_wp, 'motion')
         call check_below(failure, norm2(there%x) - 1.0_wp, 1.0e-12_wp, 'compliance')
      end do
   end subroutine complete_set

   subroutine reduced_is_consistent(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: pendulum
      type(ritz_t) :: ritz
      type(state_t) :: at
      type(finding_t), allocatable :: findings(:)
      type(error_t), allocatable :: error

      call new_pendulum(pendulum, 1.0_wp, 1.0_wp, g, 2, error)
      call new_ritz(ritz, pendulum, oblique(), [1.0_wp, 0.3_wp], error)
      at%x = [0.2_wp, -0.1_wp]
      at%v = [0.5_wp, 0.7_wp]
      call verify(ritz, at, findings, error)
      call no_error(failure, error)
      if (size(findings) > 0) call check(failure, .false., findings(1)%message)
   end subroutine reduced_is_consistent

   !> The blade reduced to shapes that leave nothing out: its control system's stiffness acts where the link does not, and the
   !! force of either is told.
   subroutine spring_and_outputs(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=16), parameter :: names(2) = [character(len=16) :: 'unconstrained', 'present']
      type(helicopter_data_t) :: data
      type(helicopter_t) :: blade
      type(ritz_t) :: ritz
      type(method_t) :: method
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(state_t) :: at, full, there
      type(sample_t) :: s, expected
      class(constrained_ode_t), allocatable :: ode
      type(error_t), allocatable :: error
      integer :: i, info

      options%rtol = 1.0e-10_wp
      options%atol = 1.0e-10_wp
      call new_helicopter(blade, data, error)
      call no_error(failure, error)
      call new_ritz(ritz, blade, oblique(), [0.0_wp, 0.0_wp], error)
      call no_error(failure, error)
      call check(failure, ritz%n_outputs == 1 .and. ritz%output_name(1) == 'link_force', 'the output is announced')
      call check(failure, size(ritz%quantities()) == size(blade%quantities()), 'quantities are those of the blade')
      do i = 1, 2
         method%name = names(i)
         method%weight = 'mass'
         full%t = 0.0_wp
         full%x = [0.02_wp, 0.01_wp]
         full%v = [0.0_wp, 0.0_wp]
         call simulate(blade, full, 0.1_wp, result, error, method, options, ode=ode)
         call no_error(failure, error)
         call ode%sample(0.1_wp, [full%x, full%v], expected, info)
         at%t = 0.0_wp
         ! X q = x_0: oblique() has the inverse [1, -1; -0.5, 2]/1.5.
         at%x = [0.02_wp - 0.01_wp, -0.01_wp + 0.02_wp]/1.5_wp
         at%v = [0.0_wp, 0.0_wp]
         call simulate(ritz, at, 0.1_wp, result, error, method, options, ode=ode)
         call no_error(failure, error)
         there = ritz%full_state(at)
         call check_below(failure, maxval(abs(there%x - full%x)), 1.0e-7_wp, trim(names(i))//': motion')
         call ode%sample(0.1_wp, [at%x, at%v], s, info)
         call check_close(failure, s%outputs(1), expected%outputs(1), 1.0e-4_wp*abs(expected%outputs(1)), &
                          trim(names(i))//': force')
      end do
   end subroutine spring_and_outputs

   subroutine events_pass(failure)
      character(:), allocatable, intent(inout) :: failure
      type(watched_t) :: pendulum
      type(ritz_t) :: ritz
      type(model_events_t) :: events
      type(state_t) :: at
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      real(wp) :: angle, period, rate

      call new_pendulum(pendulum%pendulum_t, 1.0_wp, 1.0_wp, g, 1, error)
      pendulum%n_events = 1
      call new_ritz(ritz, pendulum, oblique(), [1.0_wp, 0.0_wp], error)
      call no_error(failure, error)
      call check(failure, ritz%event_name(1) == 'bottom', 'name')
      call events%init(ritz)
      at%x = [0.0_wp, 0.0_wp]
      at%v = [0.0_wp, 0.0_wp]
      call simulate(ritz, at, 1.0_wp, result, error, events=events, &
                    options=integration_options_t(rtol=1.0e-10_wp, atol=1.0e-10_wp))
      call no_error(failure, error)
      call check(failure, size(result%events) == 1, 'one event')
      if (allocated(failure)) return
      call pendulum_motion(1.0_wp, 1.0_wp, g, 0.5_wp*acos(-1.0_wp), angle, rate, period)
      call check_close(failure, result%events(1)%t, 0.25_wp*period, 1.0e-8_wp, 'a quarter of the period')
   end subroutine events_pass

   !> x, whose sign changes at the bottom.
   subroutine bottom(self, at, values)
      class(watched_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: values(:)

      values(1) = at%x(1)
      associate (unused_system => self)
      end associate
   end subroutine bottom

   function bottom_name(self, i) result(name)
      class(watched_t), intent(in) :: self
      integer, intent(in) :: i
      character(len=name_length) :: name

      name = 'bottom'
      associate (unused_system => self, unused_index => i)
      end associate
   end function bottom_name

   !> Two rods of lengths 1 and 1.2 and a single shape: A X has rank 1, the least violation is 0.1 each.
   subroutine mild_inconsistency(failure)
      character(:), allocatable, intent(inout) :: failure
      type(ritz_t) :: ritz
      type(method_t) :: method
      type(start_report_t) :: report
      type(state_t) :: at
      type(error_t), allocatable :: error

      call new_ritz(ritz, new_particle(two_rods, ratio=1.2_wp), reshape([1.0_wp, 0.0_wp], [2, 1]), [1.0_wp, 0.0_wp], error)
      call no_error(failure, error)
      at%x = [0.0_wp]
      at%v = [0.0_wp]
      call consistent_start(ritz, method, at, report, error)
      call check(failure, allocated(error), 'refused')
      if (allocated(error)) then
         call check(failure, index(error%line(), 'inconsistent') > 0, error%line())
         deallocate (error)
      end if
      at%x = [0.0_wp]
      method%accept_inconsistent = .true.
      call consistent_start(ritz, method, at, report, error)
      call no_error(failure, error)
      call check_close(failure, at%x(1), 0.1_wp, 1.0e-12_wp, 'amplitude of least violation')
      call check_close(failure, report%phi_left, 0.1_wp, 1.0e-12_wp, 'what is left is reported')
      call check(failure, report%rank == 1, 'rank')
   end subroutine mild_inconsistency

   subroutine bad_input(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: pendulum
      type(ritz_t) :: ritz
      type(error_t), allocatable :: error

      call new_pendulum(pendulum, 1.0_wp, 1.0_wp, g, 1, error)
      call new_ritz(ritz, pendulum, reshape([1.0_wp, 2.0_wp, 2.0_wp, 4.0_wp], [2, 2]), [1.0_wp, 0.0_wp], error)
      call check(failure, allocated(error), 'dependent shapes')
      if (allocated(error)) deallocate (error)
      call new_ritz(ritz, pendulum, reshape([1.0_wp, 2.0_wp, 2.0_wp], [3, 1]), [1.0_wp, 0.0_wp], error)
      call check(failure, allocated(error), 'shapes of another size')
      if (allocated(error)) deallocate (error)
      call new_ritz(ritz, new_compound(), reshape([1.0_wp, 0.0_wp, 0.0_wp], [3, 1]), [1.0_wp, 0.0_wp, 0.0_wp], error)
      call check(failure, allocated(error), 'shapes over quasi-velocities')
   end subroutine bad_input

end module test_ritz
