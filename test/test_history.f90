!> What is kept of a motion: histories, output at given times, the motion between points, events of a system's own.
module test_history
   use systems, only: jumping_load, new_particle, particle_t
   use taut, only: automatic_system_t, error_t, history_t, integration_options_t, integration_result_t, jet_state_t, jet_t, &
                   name_length, operator(*), operator(-), hypot, simulate, state_t, status_event, status_too_many_steps, wp
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_history

   real(wp), parameter :: g = 9.81_wp
   character(*), parameter :: integrators(3) = [character(6) :: 'dopri5', 'dop853', 'radau']

   !> A pendulum of 1 kg and 1 m that has its kinetic energy as an output, and announces when it passes its lowest point.
   type, extends(automatic_system_t) :: watched_t
   contains
      procedure :: phi
      procedure :: potential
      procedure :: outputs
      procedure :: output_name
      procedure :: event_values
   end type watched_t

contains

   !> All tests of this module.
   function collect_history() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('a history has multipliers, energy, violations and outputs by name', complete), &
               new_test('output at given times, and at no others', given_times), &
               new_test('times that are not passed are refused', refused_times), &
               new_test('the motion between points is a function of time', between_points), &
               new_test('behind a jump the motion is that of the new load', behind_jump), &
               new_test('nothing is known of times that were not passed', not_passed), &
               new_test('a system''s own events are looked for', own_events), &
               new_test('a motion that ends early is an error', early_end), &
               new_test('a tolerance below round-off is refused', too_strict)]
   end function collect_history

   subroutine phi(self, at, value)
      class(watched_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value(:)

      value(1) = hypot(at%x(1), at%x(2)) - 1.0_wp
      associate (unused_system => self)
      end associate
   end subroutine phi

   subroutine potential(self, at, value)
      class(watched_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value

      value = g*at%x(2)
      associate (unused_system => self)
      end associate
   end subroutine potential

   subroutine outputs(self, at, lambda, values)
      class(watched_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: lambda(:)
      real(wp), intent(out) :: values(:)

      values = [0.5_wp*dot_product(at%v, at%v), lambda(1)]
      associate (unused_system => self)
      end associate
   end subroutine outputs

   function output_name(self, i) result(name)
      class(watched_t), intent(in) :: self
      integer, intent(in) :: i
      character(len=name_length) :: name

      name = trim(merge('kinetic', 'tension', i == 1))
      associate (unused_system => self)
      end associate
   end function output_name

   subroutine event_values(self, at, values)
      class(watched_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: values(:)

      values(:) = at%x(1)
      associate (unused_system => self)
      end associate
   end subroutine event_values

   !> Horizontal, at rest.
   subroutine hold(system, at)
      type(watched_t), intent(out) :: system
      type(state_t), intent(out) :: at

      call system%define(n=2, c=1, mass_blocks=[1, 1])
      system%diagonal_mass = [1.0_wp, 1.0_wp]
      system%n_outputs = 2
      at%x = [1.0_wp, 0.0_wp]
      at%v = [0.0_wp, 0.0_wp]
   end subroutine hold

   subroutine complete(failure)
      character(:), allocatable, intent(inout) :: failure
      type(watched_t) :: system
      type(state_t) :: at
      type(history_t) :: path
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      real(wp), allocatable :: kinetic(:), x2(:)
      integer :: i

      call hold(system, at)
      ! More points than there is room for at first, and a second run into the same history.
      do i = 1, 2
         call simulate(system, at, 3.0_wp*i, result, error, options=integration_options_t(rtol=1.0e-10_wp, output_dt=0.01_wp), &
                       observer=path)
         call no_error(failure, error)
      end do
      if (allocated(failure)) return
      call check(failure, path%points == 301 .and. size(path%t) == 301 .and. size(path%lambda, 2) == 301, 'points')
      call check_below(failure, maxval(abs(path%t - [(3.0_wp + 0.01_wp*i, i=0, 300)])), 1.0e-12_wp, 'times')
      call check_below(failure, max(maxval(path%phi), maxval(path%phidot), maxval(path%phiddot)), 1.0e-12_wp, 'violations')
      call check_below(failure, maxval(abs(path%energy)), 1.0e-7_wp, 'energy')
      ! The rod's tension is v^2 - g z for 1 kg and 1 m: -3 g z from rest at z = 0.
      call check_below(failure, maxval(abs(path%lambda(1, :) + 3.0_wp*g*path%x(2, :))), 1.0e-6_wp, 'tension')
      call path%series('kinetic', kinetic, error)
      call path%series('x2', x2, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      call check_below(failure, maxval(abs(kinetic + g*x2)), 1.0e-7_wp, 'kinetic energy')
      call check_below(failure, maxval(abs(path%outputs(2, :) - path%lambda(1, :))), 0.0_wp, 'an output that is a multiplier')
      call check_below(failure, maxval(abs(path%v(:, 301) - at%v)), 0.0_wp, 'last velocity')
      call check(failure, size(path%w, 1) == 0 .and. size(path%mu, 2) == 301, 'what there is none of')
      call path%series('height', x2, error)
      call check(failure, allocated(error), 'a name that there is not was found')
   end subroutine complete

   subroutine given_times(failure)
      character(:), allocatable, intent(inout) :: failure
      type(watched_t) :: system
      type(state_t) :: at, alone
      type(history_t) :: path
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      type(integration_options_t) :: options
      integer :: i
      real(wp), parameter :: times(5) = [0.0_wp, 0.1_wp, 0.1003_wp, 0.77_wp, 1.0_wp]

      options = integration_options_t(rtol=1.0e-10_wp, atol=1.0e-12_wp)
      options%output_times = times
      call hold(system, at)
      call simulate(system, at, 1.0_wp, result, error, options=options, observer=path)
      call no_error(failure, error)
      call check(failure, path%points == 5, 'points')
      if (allocated(failure)) return
      call check_below(failure, maxval(abs(path%t - times)), 0.0_wp, 'times')
      do i = 2, 5
         call hold(system, alone)
         call simulate(system, alone, times(i), result, error, options=integration_options_t('dop853', 1.0e-12_wp, 1.0e-12_wp))
         call check_below(failure, maxval(abs(path%x(:, i) - alone%x)), 1.0e-8_wp, 'state')
      end do
      ! Backwards, neither the start nor the end.
      options%output_times = [0.9_wp, 0.5_wp]
      call simulate(system, at, 0.0_wp, result, error, options=options, observer=path)
      call no_error(failure, error)
      call check(failure, path%points == 2, 'points backwards')
      if (allocated(failure)) return
      call check_below(failure, maxval(abs(path%t - [0.9_wp, 0.5_wp])), 0.0_wp, 'times backwards')
   end subroutine given_times

   subroutine refused_times(failure)
      character(:), allocatable, intent(inout) :: failure
      type(watched_t) :: system
      type(state_t) :: at
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      type(integration_options_t) :: options

      call hold(system, at)
      options%output_times = [0.5_wp, 0.4_wp]
      call simulate(system, at, 1.0_wp, result, error, options=options)
      call check(failure, allocated(error), 'times that do not ascend were taken')
      if (allocated(error)) call check(failure, index(error%what, 'output_times(2)') == 1, error%line())
      if (allocated(error)) deallocate (error)
      options%output_times = [0.5_wp, 1.5_wp]
      call simulate(system, at, 1.0_wp, result, error, options=options)
      call check(failure, allocated(error), 'a time behind the end was taken')
   end subroutine refused_times

   !> Against motions that end there.
   subroutine between_points(failure)
      character(:), allocatable, intent(inout) :: failure
      type(watched_t) :: system
      type(state_t) :: at, alone, inside
      type(history_t) :: path
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      real(wp) :: t
      integer :: i, k

      do k = 1, size(integrators)
         path = history_t(dense=.true.)
         call hold(system, at)
         call simulate(system, at, 2.0_wp, result, error, observer=path, &
                       options=integration_options_t(integrators(k), 1.0e-9_wp, 1.0e-10_wp, output_dt=1.0_wp))
         call no_error(failure, error)
         call check(failure, path%points == 3, 'the steps have become output points')
         do i = 0, 7
            t = 0.29_wp*i
            if (i == 7) t = 2.0_wp
            call hold(system, alone)
            call simulate(system, alone, t, result, error, options=integration_options_t('dop853', 1.0e-12_wp, 1.0e-12_wp))
            call path%state_at(t, inside, error)
            call no_error(failure, error)
            if (allocated(failure)) return
            call check_below(failure, maxval(abs(inside%x - alone%x)), 1.0e-7_wp, integrators(k)//': position')
            call check_below(failure, maxval(abs(inside%v - alone%v)), 1.0e-6_wp, integrators(k)//': velocity')
            call check_below(failure, hypot(inside%x(1), inside%x(2)) - 1.0_wp, 1.0e-12_wp, integrators(k)//': length')
            call check_below(failure, inside%t - t, 0.0_wp, 'time')
         end do
      end do
   end subroutine between_points

   subroutine behind_jump(failure)
      character(:), allocatable, intent(inout) :: failure
      type(particle_t) :: system
      type(state_t) :: at, alone, inside
      type(history_t) :: path
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      integer :: i
      real(wp), parameter :: times(3) = [0.499_wp, 0.5_wp, 0.501_wp]

      system = new_particle(jumping_load, ratio=0.5_wp)
      at = state_t(x=[0.0_wp, -1.0_wp], v=[1.0_wp, 0.0_wp])
      path%dense = .true.
      call simulate(system, at, 1.0_wp, result, error, options=integration_options_t(rtol=1.0e-9_wp), observer=path)
      do i = 1, 3
         alone = state_t(x=[0.0_wp, -1.0_wp], v=[1.0_wp, 0.0_wp])
         call simulate(system, alone, times(i), result, error, options=integration_options_t('dop853', 1.0e-12_wp, 1.0e-12_wp))
         call path%state_at(times(i), inside, error)
         call no_error(failure, error)
         if (allocated(failure)) return
         call check_below(failure, maxval(abs(inside%v - alone%v)), 1.0e-7_wp, 'velocity')
      end do
   end subroutine behind_jump

   subroutine not_passed(failure)
      character(:), allocatable, intent(inout) :: failure
      type(watched_t) :: system
      type(state_t) :: at, inside
      type(history_t) :: path
      type(integration_result_t) :: result
      type(error_t), allocatable :: error

      call hold(system, at)
      call simulate(system, at, 1.0_wp, result, error, observer=path)
      call path%state_at(0.5_wp, inside, error)
      call check(failure, allocated(error), 'a history that is not dense has answered')
      if (allocated(error)) deallocate (error)
      path%dense = .true.
      call simulate(system, at, 0.0_wp, result, error, observer=path)
      call no_error(failure, error)
      call path%state_at(0.5_wp, inside, error)
      call no_error(failure, error)
      call path%state_at(1.1_wp, inside, error)
      call check(failure, allocated(error), 'a time before the start was answered')
   end subroutine not_passed

   !> The lowest point is passed at K(sin 45 deg)/sqrt(g), and again after twice that.
   subroutine own_events(failure)
      character(:), allocatable, intent(inout) :: failure
      type(watched_t) :: system
      type(state_t) :: at
      type(history_t) :: path
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      real(wp) :: quarter
      real(wp), parameter :: pi = acos(-1.0_wp)

      quarter = gamma(0.25_wp)**2/(4.0_wp*sqrt(pi*g))
      call hold(system, at)
      system%n_events = 1
      call simulate(system, at, 2.0_wp, result, error, options=integration_options_t(rtol=1.0e-10_wp))
      call check(failure, size(result%events) == 2, 'both ways')
      call hold(system, at)
      system%n_events = 1
      system%event_direction = [1]
      system%event_terminal = [.true.]
      path%dense = .true.
      call simulate(system, at, 2.0_wp, result, error, options=integration_options_t(rtol=1.0e-10_wp), observer=path)
      call no_error(failure, error)
      call check(failure, result%status == status_event .and. size(result%events) == 1, 'the first upwards')
      call check_close(failure, result%t, 3.0_wp*quarter, 1.0e-7_wp, 'time')
      call check_below(failure, at%x(1), 1.0e-12_wp, 'place')
      ! What the history knows ends there too.
      call path%state_at(result%t, at, error)
      call no_error(failure, error)
      call check_below(failure, at%x(1), 1.0e-9_wp, 'place by the history')
      call path%state_at(result%t + 1.0e-6_wp, at, error)
      call check(failure, allocated(error), 'the history goes on behind the event')
   end subroutine own_events

   subroutine early_end(failure)
      character(:), allocatable, intent(inout) :: failure
      type(watched_t) :: system
      type(state_t) :: at
      type(integration_result_t) :: result
      type(error_t), allocatable :: error

      call hold(system, at)
      call simulate(system, at, 2.0_wp, result, error, options=integration_options_t(max_steps=5))
      call check(failure, allocated(error), 'it was no error')
      call check(failure, result%status == status_too_many_steps .and. at%t > 0.0_wp .and. result%steps == 5, 'what was reached')
   end subroutine early_end

   subroutine too_strict(failure)
      character(:), allocatable, intent(inout) :: failure
      type(watched_t) :: system
      type(state_t) :: at
      type(integration_result_t) :: result
      type(error_t), allocatable :: error

      call hold(system, at)
      call simulate(system, at, 2.0_wp, result, error, options=integration_options_t(rtol=1.0e-16_wp))
      call check(failure, allocated(error), 'it was taken')
      if (allocated(error)) call check(failure, index(error%what, 'below the round-off') > 0, error%line())
   end subroutine too_strict

end module test_history
