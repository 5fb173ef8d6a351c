!> The integrator where it is easily wrong: ends that are no numbers, events at their own sign change, odd options.
module test_ode_edges
   use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_quiet_nan, ieee_value
   use systems, only: driven_pivot, new_particle
   use taut, only: block_diagonal_t, error_t, events_t, integration_options_t, integration_result_t, method_t, simulate, &
                   state_t, status_event, status_reached_end, wp
   use taut_model_pendulum, only: new_pendulum, pendulum_t
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_ode_edges

   real(wp), parameter :: g = 9.81_wp

   !> The pendulum at its lowest point: x changes its sign; in any unit.
   type, extends(events_t) :: lowest_t
      real(wp) :: unit = 1.0_wp
   contains
      procedure :: evaluate
   end type lowest_t

contains

   !> All tests of this module.
   function collect_ode_edges() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('an end that is no number is refused', no_number), &
               new_test('a start that is no number is refused', no_number_at_start), &
               new_test('a new start from an event does not meet it again', restart_from_event), &
               new_test('an event in a unit that underflows', tiny_event), &
               new_test('events that are not set up are refused', events_not_set), &
               new_test('a far end with a terminal event', far_end), &
               new_test('yu-chen with a tolerance of its own', rare_corrections), &
               new_test('a projection before the last stage costs no evaluation', projected_first), &
               new_test('steps that contradict each other are refused', contradictions), &
               new_test('a mass matrix that does not fit its blocks', mass_does_not_fit)]
   end function collect_ode_edges

   subroutine evaluate(self, t, y, g)
      class(lowest_t), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(out) :: g(:)

      g(1) = self%unit*y(1)
      associate (unused_time => t)
      end associate
   end subroutine evaluate

   !> A pendulum at rest in the horizontal.
   subroutine horizontal(model, at)
      type(pendulum_t), intent(out) :: model
      type(state_t), intent(out) :: at
      type(error_t), allocatable :: error

      call new_pendulum(model, 1.0_wp, 1.0_wp, g, 1, error)
      at%x = [1.0_wp, 0.0_wp]
      at%v = [0.0_wp, 0.0_wp]
   end subroutine horizontal

   !> Where F(P(y)) differs from F(y), the new state is projected first: six evaluations a step, and nothing else changes.
   subroutine projected_first(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(method_t) :: methods(3)
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp) :: phi(1)
      integer :: i

      methods(1)%stage_projection = 'none'
      methods(2)%name = 'coordinate-projection'
      methods(3)%name = 'yu-chen'
      methods(3)%correction_tolerance = 1.0e-9_wp
      options%rtol = 1.0e-8_wp
      do i = 1, 3
         call horizontal(model, at)
         call simulate(model, at, 2.0_wp, result, error, method=methods(i), options=options)
         call no_error(failure, error)
         call check(failure, result%rhs_evaluations == 6*(result%steps + result%rejected) + 2, &
                    trim(methods(i)%name)//': evaluations')
         call model%constraint(at, phi)
         call check_below(failure, phi(1), merge(1.0e-9_wp, 1.0e-12_wp, i == 3), trim(methods(i)%name)//': position')
         call check_below(failure, dot_product(at%x, at%v), merge(1.0e-9_wp, 1.0e-12_wp, i == 3), &
                          trim(methods(i)%name)//': velocity')
         call check_close(failure, 0.5_wp*dot_product(at%v, at%v) + g*at%x(2), 0.0_wp, 1.0e-6_wp, &
                          trim(methods(i)%name)//': energy')
      end do
   end subroutine projected_first

   subroutine no_number(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp) :: t_end(2)
      integer :: i

      t_end = [ieee_value(1.0_wp, ieee_quiet_nan), ieee_value(1.0_wp, ieee_positive_inf)]
      do i = 1, 2
         call horizontal(model, at)
         call simulate(model, at, t_end(i), result, error)
         call check(failure, allocated(error), 'it went on')
         if (allocated(error)) deallocate (error)
      end do
   end subroutine no_number

   subroutine no_number_at_start(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error

      call horizontal(model, at)
      at%v(2) = ieee_value(1.0_wp, ieee_quiet_nan)
      call simulate(model, at, 1.0_wp, result, error)
      call check(failure, allocated(error), 'it went on')
      if (allocated(error)) call check(failure, index(error%line(), 'velocity 2') > 0, error%line())
   end subroutine no_number_at_start

   subroutine restart_from_event(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(integration_result_t) :: result
      type(state_t) :: at
      type(lowest_t) :: events
      type(error_t), allocatable :: error
      real(wp) :: before
      integer :: i

      call horizontal(model, at)
      events%direction = [0]
      events%terminal = [.true.]
      do i = 1, 40
         before = at%t
         call simulate(model, at, 1000.0_wp, result, error, events=events)
         call no_error(failure, error)
         call check(failure, result%status == status_event, 'it stops')
         ! A quarter period to the first, half a period between the others.
         call check(failure, at%t - before > 0.5_wp, 'the same event again')
      end do
   end subroutine restart_from_event

   subroutine tiny_event(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(integration_result_t) :: result
      type(state_t) :: at
      type(lowest_t) :: events
      type(error_t), allocatable :: error

      call horizontal(model, at)
      events%direction = [0]
      events%terminal = [.true.]
      events%unit = 1.0e-200_wp
      call simulate(model, at, 10.0_wp, result, error, events=events)
      call no_error(failure, error)
      call check_below(failure, at%x(1), 1.0e-12_wp, 'x at the event')
   end subroutine tiny_event

   subroutine events_not_set(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(integration_result_t) :: result
      type(state_t) :: at
      type(lowest_t) :: events
      type(error_t), allocatable :: error

      call horizontal(model, at)
      call simulate(model, at, 1.0_wp, result, error, events=events)
      call check(failure, allocated(error), 'without direction and terminal')
      if (allocated(error)) deallocate (error)
      events%direction = [0, 0]
      events%terminal = [.true.]
      call horizontal(model, at)
      call simulate(model, at, 1.0_wp, result, error, events=events)
      call check(failure, allocated(error), 'of different sizes')
   end subroutine events_not_set

   subroutine far_end(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(integration_result_t) :: result
      type(state_t) :: at
      type(lowest_t) :: events
      type(error_t), allocatable :: error

      call horizontal(model, at)
      events%direction = [-1]
      events%terminal = [.true.]
      call simulate(model, at, 1.0e30_wp, result, error, events=events)
      call no_error(failure, error)
      call check(failure, result%status == status_event, 'it stops at the event')
      call check_close(failure, at%t, 2.3678_wp/4.0_wp, 1.0e-4_wp, 'after a quarter period')
   end subroutine far_end

   !> Violations gather over many steps: the correction moves the state by more than a step's tolerance.
   subroutine rare_corrections(failure)
      character(:), allocatable, intent(inout) :: failure
      type(method_t) :: method
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error

      method%name = 'yu-chen'
      method%correction_tolerance = 1.0e-7_wp
      options%rtol = 1.0e-8_wp
      options%atol = 1.0e-10_wp
      at%x = [0.6_wp, -0.8_wp]
      at%v = [0.0_wp, 0.2_wp]
      call simulate(new_particle(driven_pivot, rate=1.0_wp, amplitude=0.2_wp), at, 30.0_wp, result, error, method, options)
      call no_error(failure, error)
      call check(failure, result%status == status_reached_end, 'the end is reached')
   end subroutine rare_corrections

   subroutine contradictions(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_options_t) :: options(5)
      type(error_t), allocatable :: error
      integer :: i

      options(1)%first_step = 1.0e-5_wp
      options(1)%min_step = 1.0e-4_wp
      options(2)%step_control = 'fixed'
      options(2)%first_step = 1.0_wp
      options(2)%max_step = 0.1_wp
      options(3)%projection_limit = -1.0_wp
      options(4)%min_step = 2.0_wp
      options(4)%max_step = 1.0_wp
      options(5)%first_step = -1.0_wp
      do i = 1, size(options)
         call options(i)%check(error)
         call check(failure, allocated(error), 'taken')
         if (allocated(error)) deallocate (error)
      end do
   end subroutine contradictions

   subroutine mass_does_not_fit(failure)
      character(:), allocatable, intent(inout) :: failure
      type(block_diagonal_t) :: m
      integer :: info

      call m%init([1, 1])
      call m%set_dense(reshape([2.0_wp, 0.0_wp, 0.0_wp, 3.0_wp], [2, 2]))
      call m%factorize(info)
      call check(failure, info == 0 .and. abs(m%values(2) - 3.0_wp) <= 0.0_wp, 'a matrix that does fit')
      call m%set_dense(reshape([2.0_wp, 1.0_wp, 1.0_wp, 3.0_wp], [2, 2]))
      call m%factorize(info)
      call check(failure, info /= 0, 'entries outside the blocks')
      call m%set_diagonal([1.0_wp])
      call m%factorize(info)
      call check(failure, info /= 0, 'a diagonal that is too short')
   end subroutine mass_does_not_fit

end module test_ode_edges
