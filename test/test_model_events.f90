!> Tests of the events that a system announces: they are read from the state of whatever method runs it.
module test_model_events
   use taut, only: error_t, method_t, model_events_t, state_t, wp
   use taut_model_pendulum, only: new_pendulum, pendulum_t
   use taut_constrained_method_present, only: present_t
   use testing, only: check_below, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_model_events

   !> A pendulum that watches its height and its speed.
   type, extends(pendulum_t) :: watched_t
   contains
      procedure :: event_values
   end type watched_t

   !> A method whose state is {v; x}.
   type, extends(present_t) :: swapped_t
   contains
      procedure :: unpack
   end type swapped_t

contains

   !> All tests of this module.
   function collect_model_events() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('the method says what a state means', layout_of_method)]
   end function collect_model_events

   subroutine layout_of_method(failure)
      character(:), allocatable, intent(inout) :: failure
      type(watched_t) :: pendulum
      type(present_t) :: present
      type(swapped_t) :: swapped
      type(model_events_t) :: events
      type(error_t), allocatable :: error
      real(wp) :: g(2)

      call new_pendulum(pendulum%pendulum_t, 1.0_wp, 1.0_wp, 9.81_wp, 1, error)
      pendulum%n_events = 2
      call present%init(pendulum, method_t(), error)
      call swapped%init(pendulum, method_t(), error)
      call no_error(failure, error)
      if (allocated(failure)) return
      call events%init(pendulum)
      call events%evaluate(present, 0.5_wp, [1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp], g)
      call check_below(failure, maxval(abs(g - [2.0_wp, 3.5_wp])), 0.0_wp, '{x; v}')
      call events%evaluate(swapped, 0.5_wp, [3.0_wp, 4.0_wp, 1.0_wp, 2.0_wp], g)
      call check_below(failure, maxval(abs(g - [2.0_wp, 3.5_wp])), 0.0_wp, '{v; x}')
   end subroutine layout_of_method

   subroutine event_values(self, at, values)
      class(watched_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: values(:)

      values = [at%x(2), at%v(1) + at%t]
      associate (unused_system => self)
      end associate
   end subroutine event_values

   pure subroutine unpack(self, t, y, at)
      class(swapped_t), intent(in) :: self
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      type(state_t), intent(inout) :: at

      call self%present_t%unpack(t, [y(3:4), y(1:2)], at)
   end subroutine unpack

end module test_model_events
