!> Tests of the door through which a stepper comes in, and of systems that replace their state.
module test_stepper
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use taut_kinds, only: wp
   use taut_archive, only: archive_t
   use taut_error, only: error_t
   use taut_ode_event, only: events_t
   use taut_ode_integrate, only: integrator_t
   use taut_ode_observer, only: trajectory_t
   use taut_ode_options, only: integration_options_t, integration_result_t
   use taut_ode_status, only: status_reached_end, status_rhs_failed
   use taut_ode_step_control, only: controller_constants_t, step_control_t
   use taut_ode_stepper, only: stepper_t
   use taut_ode_system, only: ode_system_t, rhs_ok, step_end
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   use test_explicit_pair, only: smooth_solution, smooth_t
   implicit none (type, external)
   private
   public :: collect_stepper

   !> A point on the unit circle at unit speed, by one of its coordinates: y = {the other one, which, their signs}; the chart is
   !! changed at a step's end where the other one would lie better.
   type, extends(ode_system_t) :: circle_t
      integer :: changes = 0
      !> The derivative there is refused: what a change of charts ends in.
      logical :: refuses = .false.
   contains
      procedure :: rhs => circle_rhs
      procedure :: accepted => circle_accepted
   end type circle_t

   !> y = cos t + e^(-k t) by y' = -k (y - cos t) - sin t.
   type, extends(ode_system_t) :: stiff_t
      real(wp) :: k = 1.0e6_wp, factor(2) = 0.0_wp
      logical :: linear = .false.
   contains
      procedure :: rhs => stiff_rhs
      procedure :: linearize
      procedure :: factorize
      procedure :: solve
      procedure :: weigh_error
   end type stiff_t

   !> A stepper that is not one of ours: Rosenbrock's L-stable pair of order 2(1) with gamma = 1 - 1/sqrt 2.
   type, extends(stepper_t) :: rosenbrock_t
      real(wp), allocatable :: slope(:), slope_new(:), k(:, :), error(:, :), y0(:), y1(:)
      complex(wp), allocatable :: r(:)
   contains
      procedure :: init
      procedure :: start
      procedure :: first_step
      procedure :: try
      procedure :: accept
      procedure :: prepare_dense
      procedure :: interpolate
      procedure :: serialize
   end type rosenbrock_t

   !> The circle's two axes.
   type, extends(events_t) :: axes_t
   contains
      procedure :: evaluate => circle_axes
   end type axes_t

contains

   !> All tests of this module.
   function collect_stepper() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('a stiff stepper of one''s own', stiff_stepper), &
               new_test('a system that cannot be linearized says so', cannot_linearize), &
               new_test('the state is replaced at an accepted step', state_replaced), &
               new_test('a state that was replaced badly ends it', replaced_badly)]
   end function collect_stepper

   subroutine stiff_rhs(self, t, y, dydt, info)
      class(stiff_t), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(out), contiguous :: dydt(:)
      integer, intent(out) :: info

      info = rhs_ok
      dydt = [-self%k*(y(1) - cos(t)) - sin(t)]
   end subroutine stiff_rhs

   subroutine linearize(self, t, y, info)
      class(stiff_t), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      integer, intent(out) :: info

      info = rhs_ok
      self%linear = .true.
      associate (unused_time => t, unused_state => y)
      end associate
   end subroutine linearize

   subroutine factorize(self, slot, shift, info)
      class(stiff_t), intent(inout) :: self
      integer, intent(in) :: slot
      complex(wp), intent(in) :: shift
      integer, intent(out) :: info

      info = rhs_ok
      self%factor(slot) = real(shift, wp) + self%k
   end subroutine factorize

   subroutine solve(self, slot, r)
      class(stiff_t), intent(inout) :: self
      integer, intent(in) :: slot
      complex(wp), intent(inout), contiguous :: r(:)

      r = r/self%factor(slot)
   end subroutine solve

   subroutine weigh_error(self, h, error)
      class(stiff_t), intent(in) :: self
      real(wp), intent(in) :: h
      real(wp), intent(inout), contiguous :: error(:)

      if (self%linear) error = error*min(1.0_wp, abs(h))
   end subroutine weigh_error

   subroutine init(self, n)
      class(rosenbrock_t), intent(inout) :: self
      integer, intent(in) :: n

      self%n = n
      self%order = 2
      self%constants = controller_constants_t(exponent=0.5_wp)
      allocate (self%slope(n), self%slope_new(n), self%k(n, 2), self%error(n, 1), self%y0(n), self%y1(n), self%r(n))
   end subroutine init

   subroutine start(self, ode, t, y, info)
      class(rosenbrock_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      integer, intent(out) :: info

      call self%evaluate(ode, t, y, self%slope, info)
   end subroutine start

   subroutine first_step(self, ode, control, t, y, longest, h)
      class(rosenbrock_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      type(step_control_t), intent(in) :: control
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(in) :: longest
      real(wp), intent(out) :: h

      h = sign(min(1.0e-3_wp, abs(longest)), longest)
      associate (unused_stepper => self, unused_ode => ode, unused_control => control, unused_time => t, unused_state => y)
      end associate
   end subroutine first_step

   subroutine try(self, ode, control, t, y, t_new, h, y_new, h_next, accepted, info)
      class(rosenbrock_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      type(step_control_t), intent(inout) :: control
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(in) :: t_new, h
      real(wp), intent(out), contiguous :: y_new(:)
      real(wp), intent(out) :: h_next
      logical, intent(out) :: accepted
      integer, intent(out) :: info
      real(wp), parameter :: gamma = 1.0_wp - sqrt(0.5_wp)
      real(wp) :: dt
      logical :: stale

      accepted = .false.
      h_next = h
      y_new = y
      call ode%linearize(t, y, info)
      self%work%jacobians = self%work%jacobians + 1
      if (info == rhs_ok) call ode%factorize(1, cmplx(1.0_wp/(gamma*h), 0.0_wp, wp), info)
      if (info /= rhs_ok) return
      self%work%factorizations = self%work%factorizations + 1
      ! df/dt by a difference; then (1/(gamma h) - J) k1 = f + gamma h f_t, and so on.
      dt = 1.0e-7_wp
      call self%evaluate(ode, t + dt, y, self%k(:, 1), info)
      self%k(:, 1) = (self%k(:, 1) - self%slope)/dt
      self%r = cmplx((self%slope + gamma*h*self%k(:, 1))/(gamma*h), 0.0_wp, wp)
      self%k(:, 2) = self%k(:, 1)
      call ode%solve(1, self%r)
      self%k(:, 1) = real(self%r, wp)
      call self%evaluate(ode, t_new, y + h*self%k(:, 1), self%slope_new, info)
      self%r = cmplx((self%slope_new - gamma*h*self%k(:, 2) - 2.0_wp*self%k(:, 1))/(gamma*h), 0.0_wp, wp)
      call ode%solve(1, self%r)
      self%k(:, 2) = real(self%r, wp)
      y_new = y + h*(1.5_wp*self%k(:, 1) + 0.5_wp*self%k(:, 2))
      self%error(:, 1) = 0.5_wp*h*(self%k(:, 1) + self%k(:, 2))
      call ode%filter_error(self%error(:, 1))
      call ode%weigh_error(h, self%error(:, 1))
      call control%decide(h, self%error, y, y_new, h_next, accepted)
      if (.not. accepted) return
      call ode%project(t_new, y_new, step_end, stale, info)
      call self%evaluate(ode, t_new, y_new, self%slope_new, info)
   end subroutine try

   subroutine accept(self)
      class(rosenbrock_t), intent(inout) :: self

      self%slope = self%slope_new
   end subroutine accept

   subroutine prepare_dense(self, ode, t, y, t_new, h, y_new, info)
      class(rosenbrock_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(in) :: t_new, h
      real(wp), intent(in), contiguous :: y_new(:)
      integer, intent(out) :: info

      info = rhs_ok
      self%y0 = y
      self%y1 = y_new
      associate (unused_ode => ode, unused_start => t, unused_end => t_new, unused_step => h)
      end associate
   end subroutine prepare_dense

   subroutine interpolate(self, theta, y)
      class(rosenbrock_t), intent(in) :: self
      real(wp), intent(in) :: theta
      real(wp), intent(out), contiguous :: y(:)

      y = (1.0_wp - theta)*self%y0 + theta*self%y1
   end subroutine interpolate

   subroutine serialize(self, archive)
      class(rosenbrock_t), intent(inout) :: self
      type(archive_t), intent(inout) :: archive

      call archive%item('slope', self%slope)
   end subroutine serialize

   !> Explicit steps would be as long as 3/k.
   subroutine stiff_stepper(failure)
      character(:), allocatable, intent(inout) :: failure
      type(stiff_t) :: problem
      type(rosenbrock_t) :: stepper
      type(integrator_t) :: integrator
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(trajectory_t) :: path
      type(error_t), allocatable :: error
      real(wp) :: t, y(1)
      integer :: i

      options%rtol = 1.0e-4_wp
      options%atol = 1.0e-4_wp
      options%output_dt = 0.1_wp
      call integrator%init(1, options, error, stepper)
      call no_error(failure, error)
      t = 0.0_wp
      y = 1.0_wp
      call integrator%run(problem, t, y, 2.0_wp, result, path)
      call check(failure, result%status == status_reached_end, 'status')
      call check(failure, result%steps < 300, 'a stiff problem in few steps')
      call check(failure, result%jacobians == result%steps + result%rejected .and. result%factorizations == result%jacobians, &
                 'counts')
      do i = 1, path%points
         call check_close(failure, path%y(1, i), cos(path%t(i)), 5.0e-3_wp, 'solution inside the steps')
      end do
      call check(failure, path%points == 21, 'points')
      call check_close(failure, y(1), cos(2.0_wp), 3.0e-4_wp, 'solution at the end')
   end subroutine stiff_stepper

   subroutine cannot_linearize(failure)
      character(:), allocatable, intent(inout) :: failure
      type(smooth_t) :: problem
      type(rosenbrock_t) :: stepper
      type(integrator_t) :: integrator
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      real(wp) :: t, y(2)

      call integrator%init(2, integration_options_t(), error, stepper)
      call no_error(failure, error)
      t = 0.0_wp
      y = smooth_solution(t)
      call integrator%run(problem, t, y, 1.0_wp, result)
      call check(failure, result%status == status_rhs_failed .and. result%rejected == 0, 'it ends at once')
      call check(failure, allocated(result%error), 'with a reason')
      if (allocated(failure)) return
      call check(failure, index(result%error%line(), 'linearization') > 0, result%error%line())
   end subroutine cannot_linearize

   subroutine circle_rhs(self, t, y, dydt, info)
      class(circle_t), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(out), contiguous :: dydt(:)
      integer, intent(out) :: info
      real(wp) :: point(2)

      info = rhs_ok
      point = circle_point(y)
      dydt = 0.0_wp
      ! The speed grows with time, so that a wrong time shows.
      if (y(2) < 1.5_wp) then
         dydt(1) = -t*point(2)
      else
         dydt(1) = t*point(1)
      end if
      if (self%refuses .and. self%changes > 0) dydt(1) = ieee_value(dydt(1), ieee_quiet_nan)
   end subroutine circle_rhs

   !> y(1) is coordinate nint(y(2)), y(3) the sign of the other one.
   pure function circle_point(y) result(point)
      real(wp), intent(in) :: y(3)
      real(wp) :: point(2)
      integer :: i

      i = nint(y(2))
      point(i) = y(1)
      point(3 - i) = sign(sqrt(max(0.0_wp, 1.0_wp - y(1)**2)), y(3))
   end function circle_point

   subroutine circle_accepted(self, t, y, replaced)
      class(circle_t), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), intent(inout), contiguous :: y(:)
      logical, intent(out) :: replaced
      real(wp) :: point(2)
      integer :: i

      i = nint(y(2))
      replaced = abs(y(1)) > 0.8_wp
      if (.not. replaced) return
      point = circle_point(y)
      y = [point(3 - i), real(3 - i, wp), sign(1.0_wp, point(i))]
      self%changes = self%changes + 1
      associate (unused => t)
      end associate
   end subroutine circle_accepted

   subroutine circle_axes(self, ode, t, y, g)
      class(axes_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(out) :: g(:)

      g = circle_point(y)
      associate (unused_events => self, unused_time => t, unused_ode => ode)
      end associate
   end subroutine circle_axes

   subroutine run_circle(circle, result, y, failure)
      type(circle_t), intent(inout) :: circle
      type(integration_result_t), intent(out) :: result
      real(wp), intent(out) :: y(3)
      character(:), allocatable, intent(inout) :: failure
      type(integrator_t) :: integrator
      type(integration_options_t) :: options
      type(axes_t) :: events
      type(error_t), allocatable :: error
      real(wp) :: t

      options%rtol = 1.0e-10_wp
      options%atol = 1.0e-10_wp
      options%max_step = 0.05_wp
      call integrator%init(3, options, error)
      call no_error(failure, error)
      events%direction = [0, 0]
      events%terminal = [.false., .false.]
      t = 0.0_wp
      y = [0.6_wp, 2.0_wp, 1.0_wp]
      call integrator%run(circle, t, y, 4.0_wp, result, events=events)
   end subroutine run_circle

   subroutine state_replaced(failure)
      character(:), allocatable, intent(inout) :: failure
      type(circle_t) :: circle
      type(integration_result_t) :: result
      real(wp), parameter :: pi = acos(-1.0_wp)
      real(wp) :: angle, point(2), y(3)
      integer :: i

      call run_circle(circle, result, y, failure)
      call check(failure, result%status == status_reached_end .and. circle%changes > 4, 'charts are changed')
      if (allocated(failure)) return
      angle = asin(0.6_wp) + 8.0_wp
      point = circle_point(y)
      call check_below(failure, maxval(abs(point - [cos(angle), sin(angle)])), 1.0e-8_wp, 'where it is')
      ! Turned by pi/2, pi, ... from asin(0.6) by t^2/2: each axis is met once, whatever the chart.
      call check(failure, size(result%events) == 5, 'events')
      if (allocated(failure)) return
      do i = 1, 5
         call check_close(failure, result%events(i)%t, sqrt(2.0_wp*(0.5_wp*pi*i - asin(0.6_wp))), 1.0e-8_wp, 'time of an event')
      end do
   end subroutine state_replaced

   subroutine replaced_badly(failure)
      character(:), allocatable, intent(inout) :: failure
      type(circle_t) :: circle
      type(integration_result_t) :: result
      real(wp) :: y(3)

      circle%refuses = .true.
      call run_circle(circle, result, y, failure)
      call check(failure, allocated(result%error) .and. circle%changes == 1, 'it ends where the state was replaced')
   end subroutine replaced_badly

end module test_stepper
