!> Tests of the integrator on plain systems of ordinary differential equations.
module test_ode
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise
   use taut_ode_event, only: events_t
   use taut_ode_integrate, only: integrator_t
   use taut_ode_options, only: integration_options_t, integration_result_t
   use taut_ode_observer, only: observer_t, trajectory_t
   use taut_ode_status, only: status_event, status_not_finite, status_output_failed, status_reached_end, &
                              status_rhs_failed, status_step_too_small, status_too_many_steps
   use taut_ode_step_control, only: controller_constants_t, step_control_t
   use taut_ode_system, only: ode_system_t, rhs_failed, rhs_ok
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_ode

   !> y1 = exp(sin t), y2 = 1/(1 + t^2): not autonomous and not linear.
   integer, parameter :: smooth = 1, oscillator = 2, jump = 3, blow_up = 4, refuses = 5, ends = 6

   !> The test problems.
   type, extends(ode_system_t) :: problem_t
      integer :: kind = smooth
      real(wp) :: t_jump = 1.0_wp/3.0_wp
   contains
      procedure :: rhs
      procedure :: breakpoints
   end type problem_t

   !> y1 = 0 upward, y2 = 0 in both directions.
   type, extends(events_t) :: crossings_t
   contains
      procedure :: evaluate
   end type crossings_t

   !> An observer that fails after some points.
   type, extends(observer_t) :: failing_t
      integer :: points = 0
   contains
      procedure :: observe
   end type failing_t

contains

   !> All tests of this module.
   function collect_ode() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('order 5 on a non-autonomous problem', order_five), &
               new_test('the error follows the tolerance', error_follows_tolerance), &
               new_test('six evaluations per step', six_evaluations), &
               new_test('backwards in time', backwards), &
               new_test('no time at all', no_time), &
               new_test('events located, recorded and in order', events_recorded), &
               new_test('a terminal event stops', terminal_event), &
               new_test('events backwards in time', events_backwards), &
               new_test('a jump at a breakpoint costs nothing', jump_at_breakpoint), &
               new_test('a breakpoint backwards in time', jump_backwards), &
               new_test('output every dt', output_every_dt), &
               new_test('every status', statuses), &
               new_test('retry until the step is too small', refused_region), &
               new_test('an observer can end it', observer_ends), &
               new_test('the signed error test of 2009', signed_error_test), &
               new_test('rms and max norms', norms), &
               new_test('steps within their bounds', step_bounds), &
               new_test('options that are not valid', bad_options)]
   end function collect_ode

   !> The right-hand sides.
   subroutine rhs(self, t, y, dydt, info)
      class(problem_t), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(out), contiguous :: dydt(:)
      integer, intent(out) :: info

      info = rhs_ok
      select case (self%kind)
      case (smooth)
         dydt = [y(1)*cos(t), -2.0_wp*t*y(2)**2]
      case (oscillator)
         dydt = [y(2), -y(1)]
      case (jump)
         dydt = 0.0_wp
         if (t >= self%t_jump) dydt(1) = 4.0_wp*t**3
      case (blow_up)
         dydt = y**2
      case (refuses)
         dydt = -1.0_wp
         if (y(1) < 0.0_wp) dydt(1) = ieee_value(dydt(1), ieee_quiet_nan)
      case default
         dydt = 1.0_wp
         if (t > 0.5_wp) info = rhs_failed
      end select
   end subroutine rhs

   function breakpoints(self) result(times)
      class(problem_t), intent(in) :: self
      real(wp), allocatable :: times(:)

      allocate (times(0))
      ! Times outside the interval, and twice the same, do no harm.
      if (self%kind == jump) times = [5.0_wp, self%t_jump, -1.0_wp, self%t_jump]
   end function breakpoints

   subroutine evaluate(self, ode, t, y, g)
      class(crossings_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(out) :: g(:)

      g = y(1:2)
      associate (unused_events => self, unused_time => t, unused_ode => ode)
      end associate
   end subroutine evaluate

   subroutine observe(self, ode, t, h, y, error)
      class(failing_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t, h
      real(wp), intent(in), contiguous :: y(:)
      type(error_t), allocatable, intent(inout) :: error

      self%points = self%points + 1
      if (self%points == 4) call raise(error, 'observer', 'enough')
      associate (unused_ode => ode, unused_time => t, unused_step => h, unused_state => y)
      end associate
   end subroutine observe

   !> One integration.
   subroutine solve(kind, options, t0, t1, y, result, failure, observer, events)
      integer, intent(in) :: kind
      type(integration_options_t), intent(in) :: options
      real(wp), intent(in) :: t0, t1
      real(wp), intent(inout) :: y(:)
      type(integration_result_t), intent(out) :: result
      character(:), allocatable, intent(inout) :: failure
      class(observer_t), intent(inout), optional :: observer
      class(events_t), intent(inout), optional :: events
      type(problem_t) :: problem
      type(integrator_t) :: integrator
      type(error_t), allocatable :: error
      real(wp) :: t

      problem%kind = kind
      call integrator%init(size(y), options, error)
      call no_error(failure, error)
      if (allocated(error)) return
      t = t0
      call integrator%run(problem, t, y, t1, result, observer, events)
      call check_close(failure, result%t, t, 0.0_wp, 'time in the result')
   end subroutine solve

   function fixed_steps(h) result(options)
      real(wp), intent(in) :: h
      type(integration_options_t) :: options

      options%step_control = 'fixed'
      options%first_step = h
   end function fixed_steps

   function smooth_solution(t) result(y)
      real(wp), intent(in) :: t
      real(wp) :: y(2)

      y = [exp(sin(t)), 1.0_wp/(1.0_wp + t*t)]
   end function smooth_solution

   subroutine order_five(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_result_t) :: result
      real(wp) :: e(3), y(2)
      integer :: i

      do i = 1, 3
         y = smooth_solution(0.0_wp)
         call solve(smooth, fixed_steps(0.1_wp/2**i), 0.0_wp, 2.0_wp, y, result, failure)
         e(i) = maxval(abs(y - smooth_solution(2.0_wp)))
         call check(failure, result%steps == 20*2**i, 'number of fixed steps')
      end do
      call check_close(failure, log(e(2)/e(3))/log(2.0_wp), 5.0_wp, 0.25_wp, 'order')
   end subroutine order_five

   subroutine error_follows_tolerance(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      real(wp) :: y(2)
      integer :: i

      do i = 4, 12, 2
         options%rtol = 10.0_wp**(-i)
         options%atol = options%rtol
         y = smooth_solution(0.0_wp)
         call solve(smooth, options, 0.0_wp, 10.0_wp, y, result, failure)
         call check_below(failure, maxval(abs(y - smooth_solution(10.0_wp))), 30.0_wp*options%rtol, 'error')
      end do
   end subroutine error_follows_tolerance

   subroutine six_evaluations(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      real(wp) :: y(2)

      y = smooth_solution(0.0_wp)
      call solve(smooth, options, 0.0_wp, 10.0_wp, y, result, failure)
      ! One to begin, one for the automatic first step.
      call check(failure, result%rhs_evaluations == 6*(result%steps + result%rejected) + 2, 'evaluations')
   end subroutine six_evaluations

   subroutine backwards(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(trajectory_t) :: path
      real(wp) :: y(2)

      options%rtol = 1.0e-10_wp
      options%atol = 1.0e-10_wp
      options%output_dt = 0.5_wp
      y = smooth_solution(3.0_wp)
      call solve(smooth, options, 3.0_wp, -1.0_wp, y, result, failure, path)
      call check(failure, result%status == status_reached_end, 'status')
      call check_below(failure, maxval(abs(y - smooth_solution(-1.0_wp))), 1.0e-8_wp, 'error')
      call check(failure, path%points == 9, 'points')
      call check_close(failure, path%t(3), 2.0_wp, 0.0_wp, 'third point')
      call check_below(failure, maxval(abs(path%y(:, 3) - smooth_solution(2.0_wp))), 1.0e-8_wp, 'error at the third point')
   end subroutine backwards

   subroutine no_time(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(trajectory_t) :: path
      real(wp) :: y(2)

      y = 1.0_wp
      call solve(smooth, options, 2.0_wp, 2.0_wp, y, result, failure, path)
      call check(failure, result%status == status_reached_end .and. result%steps == 0 .and. path%points == 1, &
                 'nothing happens')
   end subroutine no_time

   subroutine events_recorded(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(crossings_t) :: events
      real(wp), parameter :: pi = acos(-1.0_wp), half_turns(4) = [1.0_wp, 1.5_wp, 2.0_wp, 3.0_wp]
      real(wp) :: y(2)
      integer :: i

      options%rtol = 1.0e-11_wp
      options%atol = 1.0e-11_wp
      events%direction = [1, 0]
      events%terminal = [.false., .false.]
      ! y1 = cos t crosses zero upward at 3/2 pi, 7/2 pi; y2 = -sin t crosses at pi, 2 pi, ... ; not at the start.
      y = [1.0_wp, 0.0_wp]
      call solve(oscillator, options, 0.0_wp, 10.5_wp, y, result, failure, events=events)
      call check(failure, size(result%events) == 4, 'number of events')
      if (allocated(failure)) return
      call check(failure, all(result%events%index == [2, 1, 2, 2]), 'their order')
      do i = 1, 4
         call check_close(failure, result%events(i)%t, pi*half_turns(i), 1.0e-9_wp, 'time of an event')
         call check_below(failure, result%events(i)%y(result%events(i)%index), 1.0e-14_wp, 'function at an event')
      end do
   end subroutine events_recorded

   subroutine terminal_event(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(crossings_t) :: events
      type(trajectory_t) :: path
      real(wp), parameter :: pi = acos(-1.0_wp)
      real(wp) :: y(2)

      options%rtol = 1.0e-11_wp
      options%atol = 1.0e-11_wp
      options%output_dt = 0.5_wp
      options%first_step = 1.0_wp
      events%direction = [1, -1]
      events%terminal = [.true., .false.]
      y = [1.0_wp, 0.0_wp]
      call solve(oscillator, options, 0.0_wp, 100.0_wp, y, result, failure, path, events)
      call check(failure, result%status == status_event, 'status')
      call check_close(failure, result%t, 1.5_wp*pi, 1.0e-9_wp, 'time')
      call check_close(failure, y(2), 1.0_wp, 1.0e-9_wp, 'state')
      call check(failure, path%points == 11, 'points: 0 to 4.5 and the event')
      if (allocated(failure)) return
      call check_close(failure, path%t(11), result%t, 0.0_wp, 'last point')
   end subroutine terminal_event

   subroutine events_backwards(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(crossings_t) :: events
      real(wp), parameter :: pi = acos(-1.0_wp)
      real(wp) :: y(2)

      options%rtol = 1.0e-11_wp
      options%atol = 1.0e-11_wp
      events%direction = [0, 0]
      events%terminal = [.true., .false.]
      y = [1.0_wp, 0.0_wp]
      call solve(oscillator, options, 0.0_wp, -100.0_wp, y, result, failure, events=events)
      call check_close(failure, result%t, -0.5_wp*pi, 1.0e-9_wp, 'time')
   end subroutine events_backwards

   !> y' = 0 before 1/3 s and 4 t^3 after it: integrated exactly if no stage sees the wrong side.
   subroutine jump_at_breakpoint(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      real(wp) :: y(2)

      y = 0.0_wp
      call solve(jump, options, 0.0_wp, 1.0_wp, y, result, failure)
      call check_close(failure, y(1), 1.0_wp - (1.0_wp/3.0_wp)**4, 1.0e-15_wp, 'integral')
      call check(failure, result%rejected == 0, 'no step is rejected')
      y = 0.0_wp
      call solve(jump, fixed_steps(0.25_wp), 0.0_wp, 1.0_wp, y, result, failure)
      call check_close(failure, y(1), 1.0_wp - (1.0_wp/3.0_wp)**4, 1.0e-15_wp, 'integral with fixed steps')
      call check(failure, result%steps == 5, 'two steps to the jump, three from there')
   end subroutine jump_at_breakpoint

   subroutine jump_backwards(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      real(wp) :: y(2)

      y = 0.0_wp
      call solve(jump, options, 1.0_wp, 0.0_wp, y, result, failure)
      call check_close(failure, y(1), (1.0_wp/3.0_wp)**4 - 1.0_wp, 1.0e-15_wp, 'integral')
      call check(failure, result%rejected == 0, 'no step is rejected')
   end subroutine jump_backwards

   subroutine output_every_dt(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(trajectory_t) :: path
      real(wp) :: y(2)
      integer :: i

      options%rtol = 1.0e-9_wp
      options%atol = 1.0e-9_wp
      options%output_dt = 0.1_wp
      y = smooth_solution(0.0_wp)
      call solve(smooth, options, 0.0_wp, 2.05_wp, y, result, failure, path)
      call check(failure, path%points == 22, '0 to 2.0 and the end')
      if (allocated(failure)) return
      do i = 1, 21
         call check_close(failure, path%t(i), (i - 1)*0.1_wp, 0.0_wp, 'time of a point')
         call check_below(failure, maxval(abs(path%y(:, i) - smooth_solution(path%t(i)))), 1.0e-7_wp, 'error at a point')
      end do
      call check_close(failure, path%t(22), 2.05_wp, 0.0_wp, 'the end')
      ! Steps that fall on the output points, but for round-off, give each point once.
      options = fixed_steps(0.1_wp)
      options%output_dt = 0.1_wp
      path%points = 0
      y = smooth_solution(0.0_wp)
      call solve(smooth, options, 0.0_wp, 2.0_wp, y, result, failure, path)
      call check(failure, path%points == 21, 'points of equal steps')
   end subroutine output_every_dt

   subroutine statuses(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(trajectory_t) :: path
      real(wp) :: y(2)

      y = 1.0_wp
      options%max_steps = 5
      call solve(smooth, options, 0.0_wp, 100.0_wp, y, result, failure, path)
      call check(failure, result%status == status_too_many_steps .and. result%steps == 5 .and. path%points == 6, &
                 'too many steps, points kept')
      call check(failure, allocated(result%error), 'there is a reason')
      options%max_steps = 100000
      y = 1.0_wp
      call solve(blow_up, options, 0.0_wp, 2.0_wp, y, result, failure)
      call check(failure, result%status == status_step_too_small .or. result%status == status_not_finite, &
                 'pole at t = 1')
      call check_close(failure, result%t, 1.0_wp, 1.0e-6_wp, 'time of the pole')
      options%min_step = 0.01_wp
      y = 1.0_wp
      call solve(blow_up, options, 0.0_wp, 2.0_wp, y, result, failure)
      call check(failure, result%status == status_step_too_small, 'smallest step')
      options%min_step = 0.0_wp
      y = 0.0_wp
      call solve(ends, options, 0.0_wp, 1.0_wp, y, result, failure)
      call check(failure, result%status == status_rhs_failed, 'right-hand side that stops')
      call check_close(failure, y(1), result%t, 1.0e-14_wp, 'state and time belong together')
   end subroutine statuses

   !> A right-hand side that is not defined beyond a point: the solution is carried up to it.
   subroutine refused_region(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      real(wp) :: y(2)

      y = 1.0_wp
      call solve(refuses, options, 0.0_wp, 2.0_wp, y, result, failure)
      call check(failure, result%status == status_not_finite, 'status')
      call check_close(failure, result%t, 1.0_wp, 1.0e-12_wp, 'time reached')
      call check(failure, result%rejected > 10, 'smaller steps were tried')
      y = 1.0_wp
      call solve(refuses, options, 0.0_wp, 0.99_wp, y, result, failure)
      call check(failure, result%status == status_reached_end, 'stops short of it')
   end subroutine refused_region

   subroutine observer_ends(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(failing_t) :: observer
      real(wp) :: y(2)

      y = smooth_solution(0.0_wp)
      call solve(smooth, options, 0.0_wp, 10.0_wp, y, result, failure, observer)
      call check(failure, result%status == status_output_failed .and. result%steps == 3, 'status')
      call check(failure, observer%points == 4, 'points seen')
      call check_below(failure, maxval(abs(y - smooth_solution(result%t))), 1.0e-4_wp, 'state and time belong together')
   end subroutine observer_ends

   subroutine signed_error_test(failure)
      character(:), allocatable, intent(inout) :: failure
      type(step_control_t) :: control
      type(error_t), allocatable :: error
      real(wp) :: h_next
      logical :: accepted

      call control%init(2, integration_options_t(step_control='odepkg-2009', rtol=1.0e-3_wp, atol=1.0e-6_wp), 5, &
                        controller_constants_t(), error)
      call no_error(failure, error)
      ! An error of any size passes if it is negative.
      call control%decide(0.1_wp, column([-1.0_wp, -1.0_wp]), [1.0_wp, 1.0_wp], [1.0_wp, 1.0_wp], h_next, accepted)
      call check(failure, accepted .and. h_next > 0.1_wp, 'negative errors pass')
      ! A negative state has the absolute tolerance only: tau = max(rtol y, atol).
      call control%decide(0.1_wp, column([1.0e-5_wp, 0.0_wp]), [-1.0_wp, 1.0_wp], [-1.0_wp, 1.0_wp], h_next, accepted)
      call check(failure, .not. accepted, 'negative states are held to atol')
      call check_close(failure, h_next, 0.08_wp*0.1_wp**0.2_wp, 1.0e-15_wp, 'next step')
      call control%decide(0.1_wp, column([1.0e-5_wp, 0.0_wp]), [1.0_wp, 1.0_wp], [1.0_wp, 1.0_wp], h_next, accepted)
      call check(failure, accepted, 'positive states to rtol')
   end subroutine signed_error_test

   !> A vector as the only column of a matrix.
   pure function column(values) result(matrix)
      real(wp), intent(in) :: values(2)
      real(wp) :: matrix(2, 1)

      matrix(:, 1) = values
   end function column

   subroutine norms(failure)
      character(:), allocatable, intent(inout) :: failure
      type(step_control_t) :: control
      type(error_t), allocatable :: error

      call control%init(2, integration_options_t(norm='rms', rtol=0.1_wp, atol=1.0_wp), 5, controller_constants_t(), error)
      call check_close(failure, control%norm([3.3_wp, 4.4_wp], [0.0_wp, 1.0_wp], [1.0_wp, -1.0_wp]), sqrt(12.5_wp), &
                       1.0e-14_wp, 'rms')
      call control%init(2, integration_options_t(norm='max', rtol=0.1_wp, atol=1.0_wp), 5, controller_constants_t(), error)
      call check_close(failure, control%norm([3.3_wp, -4.4_wp], [0.0_wp, 1.0_wp], [1.0_wp, -1.0_wp]), 4.0_wp, &
                       1.0e-14_wp, 'max')
      call control%init(2, integration_options_t(norm='max', rtol=1.0e-9_wp, atol_of=[1.0_wp, 10.0_wp]), 5, &
                        controller_constants_t(), error)
      call check_close(failure, control%norm([1.0_wp, 20.0_wp], [0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp]), 2.0_wp, &
                       1.0e-14_wp, 'atol_of')
   end subroutine norms

   subroutine step_bounds(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(trajectory_t) :: path
      real(wp) :: y(2)

      options%max_step = 0.05_wp
      y = smooth_solution(0.0_wp)
      call solve(smooth, options, 0.0_wp, 1.0_wp, y, result, failure, path)
      call check_below(failure, maxval(path%t(2:path%points) - path%t(:path%points - 1)), 0.05_wp*1.011_wp, 'largest step')
      call check(failure, result%steps >= 20 .and. result%steps <= 25, 'number of steps')
   end subroutine step_bounds

   subroutine bad_options(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_options_t) :: options(11)
      type(integrator_t) :: integrator
      type(error_t), allocatable :: error
      integer :: i

      options(1)%rtol = 0.0_wp
      options(2)%rtol = -1.0_wp
      options(3)%atol = 0.0_wp
      options(4)%max_step = 0.0_wp
      options(5)%step_control = 'unheard'
      options(6)%norm = 'unheard'
      options(7)%step_control = 'fixed'
      options(8)%max_steps = 0
      options(9)%output_dt = -1.0_wp
      options(10)%atol_of = [1.0_wp, 1.0_wp, 1.0_wp]
      options(11)%integrator = 'unheard'
      do i = 1, size(options)
         if (allocated(error)) deallocate (error)
         call integrator%init(2, options(i), error)
         call check(failure, allocated(error), 'an option that is not valid was taken')
      end do
   end subroutine bad_options

end module test_ode
