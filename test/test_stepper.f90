!> Tests of steppers: the pairs by their tableaus, and the door through which any other comes in.
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
   use taut_ode_stepper_choose, only: choose_stepper, integrator_names
   use taut_ode_stepper_explicit_pair, only: explicit_pair_t
   use taut_ode_system, only: ode_system_t, rhs_ok, step_end
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_stepper

   !> y1 = exp(sin t), y2 = 1/(1 + t^2): not autonomous and not linear.
   type, extends(ode_system_t) :: smooth_t
   contains
      procedure :: rhs => smooth_rhs
   end type smooth_t

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

   !> All rooted trees up to order 8: their orders, their densities gamma, and what the stages make of them.
   type :: trees_t
      integer :: count = 0, order(200) = 0
      real(wp) :: gamma(200) = 0.0_wp
      real(wp), allocatable :: weight(:, :)
   end type trees_t

   !> The derivative is the unit vector of its own number.
   type, extends(ode_system_t) :: numbered_t
      integer :: next = 0
   contains
      procedure :: rhs => numbered_rhs
   end type numbered_t

   !> The circle's two axes.
   type, extends(events_t) :: axes_t
   contains
      procedure :: evaluate => circle_axes
   end type axes_t

contains

   !> All tests of this module.
   function collect_stepper() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('the nodes are the row sums', nodes_are_row_sums), &
               new_test('the order conditions of every pair', order_conditions), &
               new_test('the orders of a step, its estimates and its dense output', orders_of_a_step), &
               new_test('a stiff stepper of one''s own', stiff_stepper), &
               new_test('a system that cannot be linearized says so', cannot_linearize), &
               new_test('the state is replaced at an accepted step', state_replaced), &
               new_test('a state that was replaced badly ends it', replaced_badly)]
   end function collect_stepper

   subroutine smooth_rhs(self, t, y, dydt, info)
      class(smooth_t), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(out), contiguous :: dydt(:)
      integer, intent(out) :: info

      info = rhs_ok
      dydt = [y(1)*cos(t), -2.0_wp*t*y(2)**2]
      associate (unused => self)
      end associate
   end subroutine smooth_rhs

   pure function smooth_solution(t) result(y)
      real(wp), intent(in) :: t
      real(wp) :: y(2)

      y = [exp(sin(t)), 1.0_wp/(1.0_wp + t*t)]
   end function smooth_solution

   !> A pair by its name.
   subroutine new_pair(name, n, pair, failure)
      character(*), intent(in) :: name
      integer, intent(in) :: n
      class(explicit_pair_t), allocatable, intent(out) :: pair
      character(:), allocatable, intent(inout) :: failure
      class(stepper_t), allocatable :: stepper
      type(error_t), allocatable :: error

      call choose_stepper(name, stepper, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      select type (stepper)
      class is (explicit_pair_t)
         allocate (pair, source=stepper)
         call pair%init(n)
      end select
   end subroutine new_pair

   subroutine nodes_are_row_sums(failure)
      character(:), allocatable, intent(inout) :: failure
      class(explicit_pair_t), allocatable :: pair
      real(wp) :: y(1)
      integer :: i, j

      do j = 1, size(integrator_names)
         if (integrator_names(j) == 'radau') cycle
         call new_pair(integrator_names(j), 1, pair, failure)
         if (allocated(failure)) return
         pair%k(:, :) = 1.0_wp
         do i = 2, size(pair%node)
            call pair%stage_state(i, 1.0_wp, [0.0_wp], y)
            call check_close(failure, y(1), pair%node(i), 2.0e-14_wp, 'row sum')
         end do
         call pair%estimate(1.0_wp, pair%k, pair%error)
         call check_below(failure, maxval(abs(pair%error)), 2.0e-15_wp, 'sum of the error weights')
      end do
   end subroutine nodes_are_row_sums

   subroutine numbered_rhs(self, t, y, dydt, info)
      class(numbered_t), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(out), contiguous :: dydt(:)
      integer, intent(out) :: info

      info = rhs_ok
      dydt = 0.0_wp
      self%next = self%next + 1
      dydt(self%next) = 1.0_wp
      associate (unused_time => t, unused_state => y)
      end associate
   end subroutine numbered_rhs

   !> Adds the trees of an order whose branches, from a given one on, take `left` vertices more.
   recursive subroutine grow(trees, a, order, left, first, weight, gamma)
      type(trees_t), intent(inout) :: trees
      real(wp), intent(in) :: a(:, :)
      integer, intent(in) :: order, left, first
      real(wp), intent(in) :: weight(:), gamma
      integer :: i, known

      if (left == 0) then
         trees%count = trees%count + 1
         trees%order(trees%count) = order
         trees%gamma(trees%count) = order*gamma
         trees%weight(:, trees%count) = weight
         return
      end if
      known = trees%count
      do i = first, known
         if (trees%order(i) <= left .and. trees%order(i) < order) &
            call grow(trees, a, order, left - trees%order(i), i, weight*matmul(a, trees%weight(:, i)), gamma*trees%gamma(i))
      end do
   end subroutine grow

   !> Largest violation of sum_j b_j u_j = theta^order/gamma over the trees of orders between two bounds.
   pure real(wp) function violation(trees, b, theta, lowest, highest)
      type(trees_t), intent(in) :: trees
      real(wp), intent(in) :: b(:), theta
      integer, intent(in) :: lowest, highest
      integer :: i

      violation = 0.0_wp
      do i = 1, trees%count
         if (trees%order(i) < lowest .or. trees%order(i) > highest) cycle
         violation = max(violation, abs(dot_product(b, trees%weight(:, i)) - theta**trees%order(i)/trees%gamma(i)))
      end do
   end function violation

   !> Of the solution, the error estimates and the continuous extension. The coefficients are read off what the pair makes of
   !! derivatives that are unit vectors.
   subroutine order_conditions(failure)
      character(:), allocatable, intent(inout) :: failure
      integer, parameter :: solution(2) = [5, 8], dense(2) = [4, 7], lower(2, 2) = reshape([4, 0, 5, 3], [2, 2])
      class(explicit_pair_t), allocatable :: pair
      type(trees_t) :: trees
      type(numbered_t) :: problem
      real(wp), allocatable :: a(:, :), b(:), rest(:)
      integer :: i, info, j, s
      real(wp) :: theta

      do j = 1, 2
         call new_pair(integrator_names(j), 1, pair, failure)
         if (allocated(failure)) return
         s = size(pair%node)
         call new_pair(integrator_names(j), s, pair, failure)
         if (allocated(trees%weight)) deallocate (trees%weight)
         allocate (trees%weight(s, 200))
         a = reshape([(0.0_wp, i=1, s*s)], [s, s])
         rest = a(:, 1)
         b = rest
         pair%k(:, :) = a
         do i = 1, s
            pair%k(i, i) = 1.0_wp
         end do
         do i = 2, s
            call pair%stage_state(i, 1.0_wp, rest, b)
            a(i, :) = b
         end do
         trees%count = 0
         do i = 1, 8
            call grow(trees, a, i, i - 1, 1, [(1.0_wp, info=1, s)], 1.0_wp)
         end do
         call check(failure, trees%count == 200, 'number of trees')

         b = a(pair%stages, :)
         call check_below(failure, violation(trees, b, 1.0_wp, 1, solution(j)), 1.0e-13_wp, 'solution')
         if (solution(j) < 8) call check(failure, violation(trees, b, 1.0_wp, solution(j) + 1, 8) > 1.0e-4_wp, 'order too low')
         call pair%estimate(1.0_wp, pair%k, pair%error)
         do i = 1, size(pair%error, 2)
            call check_below(failure, violation(trees, b - pair%error(:, i), 1.0_wp, 1, lower(i, j)), 1.0e-13_wp, 'estimate')
            call check(failure, violation(trees, b - pair%error(:, i), 1.0_wp, lower(i, j) + 1, lower(i, j) + 1) > 1.0e-4_wp, &
                       'the estimate sees nothing')
         end do
         problem%next = pair%stages
         call pair%prepare_dense(problem, 0.0_wp, rest, 1.0_wp, 1.0_wp, b, info)
         call check(failure, problem%next == s, 'evaluations of dense output')
         do i = 0, 10
            theta = 0.1_wp*i
            call pair%interpolate(theta, b)
            call check_below(failure, violation(trees, b, theta, 1, dense(j)), 1.0e-12_wp, 'dense output')
         end do
         call pair%interpolate(0.3_wp, b)
         call check(failure, violation(trees, b, 0.3_wp, dense(j) + 1, dense(j) + 1) > 1.0e-9_wp, 'dense output of higher order')
      end do
   end subroutine order_conditions

   !> One step from t = 0.3: error at its end, size of the estimates, error inside.
   subroutine step_of(name, h, e, failure)
      character(*), intent(in) :: name
      real(wp), intent(in) :: h
      real(wp), intent(out) :: e(4)
      character(:), allocatable, intent(inout) :: failure
      class(explicit_pair_t), allocatable :: pair
      type(smooth_t) :: problem
      real(wp) :: y(2), y0(2), y1(2)
      integer :: i, info

      call new_pair(name, 2, pair, failure)
      e = 0.0_wp
      if (allocated(failure)) return
      y0 = smooth_solution(0.3_wp)
      call problem%rhs(0.3_wp, y0, pair%k(:, 1), info)
      do i = 2, pair%stages
         call pair%stage_state(i, h, y0, y1)
         call problem%rhs(0.3_wp + pair%node(i)*h, y1, pair%k(:, i), info)
      end do
      e(1) = maxval(abs(y1 - smooth_solution(0.3_wp + h)))
      call pair%estimate(h, pair%k, pair%error)
      do i = 1, size(pair%error, 2)
         e(1 + i) = maxval(abs(pair%error(:, i)))
      end do
      call pair%prepare_dense(problem, 0.3_wp, y0, 0.3_wp + h, h, y1, info)
      call pair%interpolate(0.0_wp, y)
      call check_below(failure, maxval(abs(y - y0)), 0.0_wp, 'start of the step')
      call pair%interpolate(1.0_wp, y)
      call check_below(failure, maxval(abs(y - y1)), 1.0e-15_wp, 'end of the step')
      do i = 1, 9
         call pair%interpolate(0.1_wp*i, y)
         e(4) = max(e(4), maxval(abs(y - smooth_solution(0.3_wp + 0.1_wp*i*h))))
      end do
   end subroutine step_of

   !> On a problem that is not autonomous, by halving a step.
   subroutine orders_of_a_step(failure)
      character(:), allocatable, intent(inout) :: failure
      real(wp), parameter :: h(2) = [0.1_wp, 0.6_wp]
      integer, parameter :: order(4, 2) = reshape([6, 5, 0, 5, 9, 6, 4, 8], [4, 2])
      real(wp) :: e(4), half(4)
      integer :: i, j

      do j = 1, 2
         call step_of(integrator_names(j), h(j), e, failure)
         call step_of(integrator_names(j), 0.5_wp*h(j), half, failure)
         if (allocated(failure)) return
         do i = 1, 4
            if (order(i, j) > 0) &
               call check_close(failure, log(e(i)/half(i))/log(2.0_wp), real(order(i, j), wp), 0.6_wp, 'local order')
         end do
      end do
   end subroutine orders_of_a_step

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
