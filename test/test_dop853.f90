!> The pair of order 8 on constrained motions: orders, compliance, its cost, events, allocation.
module test_dop853
   use, intrinsic :: iso_fortran_env, only: int64
   use allocation_counter, only: allocations, counts_matter
   use taut, only: constrained_ode_t, error_t, events_t, integration_options_t, integration_result_t, integrator_t, &
                   mechanical_system_t, method_t, new_constrained_ode, observer_t, ode_system_t, sample_t, simulate, state_t, &
                   status_reached_end, trajectory_t, wp
   use taut_model_pendulum, only: new_pendulum, pendulum_t
   use taut_model_rigid_bodies, only: new_rigid_bodies, rigid_bodies_t, rigid_body_t, spherical_joint_t
   use testing, only: check, check_below, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_dop853

   !> The lowest point.
   type, extends(events_t) :: lowest_t
   contains
      procedure :: evaluate => abscissa
   end type lowest_t

   !> Sees every point and keeps none.
   type, extends(observer_t) :: quiet_t
      integer :: points = 0
   contains
      procedure :: observe => count_points
   end type quiet_t

   !> Keeps the largest violations.
   type, extends(observer_t) :: violations_t
      real(wp) :: phi = 0.0_wp, phidot = 0.0_wp, phiddot = 0.0_wp
   contains
      procedure :: observe => watch
   end type violations_t

contains

   !> All tests of this module.
   function collect_dop853() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('order 8 on the pendulum, order 7 between the steps', pendulum_orders), &
               new_test('order 8 on a top with quaternions', top_orders), &
               new_test('all levels comply, at and between the steps', compliance), &
               new_test('twelve evaluations a step, three where output is between', evaluations), &
               new_test('events at full accuracy', events_accurate), &
               new_test('fewer evaluations than order 5 where it matters', fewer_evaluations), &
               new_test('nothing is allocated inside a step', nothing_allocated)]
   end function collect_dop853

   subroutine abscissa(self, ode, t, y, g)
      class(lowest_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(out) :: g(:)

      g = y(1)
      associate (unused_events => self, unused_time => t, unused_ode => ode)
      end associate
   end subroutine abscissa

   subroutine watch(self, ode, t, h, y, error)
      class(violations_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t, h
      real(wp), intent(in), contiguous :: y(:)
      type(error_t), allocatable, intent(inout) :: error
      type(sample_t) :: s
      integer :: info

      select type (ode)
      class is (constrained_ode_t)
         call ode%sample(t, y, s, info)
         self%phi = max(self%phi, s%phi)
         self%phidot = max(self%phidot, s%phidot)
         self%phiddot = max(self%phiddot, s%phiddot)
      end select
      associate (unused_step => h, unused_error => error)
      end associate
   end subroutine watch

   subroutine count_points(self, ode, t, h, y, error)
      class(quiet_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t, h
      real(wp), intent(in), contiguous :: y(:)
      type(error_t), allocatable, intent(inout) :: error

      self%points = self%points + 1
      associate (unused_ode => ode, unused_time => t, unused_step => h, unused_state => y, unused_error => error)
      end associate
   end subroutine count_points

   function fixed(integrator, h) result(options)
      character(*), intent(in) :: integrator
      real(wp), intent(in) :: h
      type(integration_options_t) :: options

      options%integrator = integrator
      options%step_control = 'fixed'
      options%first_step = h
   end function fixed

   function tight(integrator) result(options)
      character(*), intent(in) :: integrator
      type(integration_options_t) :: options

      options%integrator = integrator
      options%rtol = 1.0e-13_wp
      options%atol = 1.0e-14_wp
   end function tight

   subroutine pendulum(model, at)
      type(pendulum_t), intent(out) :: model
      type(state_t), intent(out) :: at
      type(error_t), allocatable :: error

      call new_pendulum(model, 1.0_wp, 1.0_wp, 9.81_wp, 1, error)
      at%x = [0.6_wp, -0.8_wp]
      at%v = [0.8_wp, 0.6_wp]
   end subroutine pendulum

   !> A heavy top on a spherical joint, leaning and spinning.
   subroutine top(model, at, failure)
      type(rigid_bodies_t), intent(out) :: model
      type(state_t), intent(out) :: at
      character(:), allocatable, intent(inout) :: failure
      type(rigid_body_t) :: body
      type(error_t), allocatable :: error

      body%m = 1.5_wp
      body%s = [0.0_wp, 0.0_wp, 0.6_wp]
      body%j(1, 1) = 0.35_wp
      body%j(2, 2) = 0.35_wp
      body%j(3, 3) = 0.05_wp
      call new_rigid_bodies(model, [body], [spherical_joint_t(1, 0)], [0.0_wp, 0.0_wp, -9.81_wp], error)
      call no_error(failure, error)
      at%x = [0.0_wp, 0.0_wp, 0.0_wp, cos(0.2_wp), sin(0.2_wp), 0.0_wp, 0.0_wp]
      at%v = [0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.5_wp, 12.0_wp]
   end subroutine top

   !> End state of a motion.
   function motion(model, start, t_end, options, failure, path) result(y)
      class(mechanical_system_t), intent(in) :: model
      type(state_t), intent(in) :: start
      real(wp), intent(in) :: t_end
      type(integration_options_t), intent(in) :: options
      character(:), allocatable, intent(inout) :: failure
      class(observer_t), intent(inout), optional :: path
      real(wp), allocatable :: y(:)
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error

      at = start
      call simulate(model, at, t_end, result, error, options=options, observer=path)
      call no_error(failure, error)
      call check(failure, result%status == status_reached_end, 'the end is reached')
      y = [at%x, at%v]
   end function motion

   !> Order between two lengths of the step, against the pair of order 5 at a tolerance at which it is right to round-off.
   real(wp) function order_of(model, start, h, failure)
      class(mechanical_system_t), intent(in) :: model
      type(state_t), intent(in) :: start
      real(wp), intent(in) :: h
      character(:), allocatable, intent(inout) :: failure
      real(wp), allocatable :: reference(:)

      reference = motion(model, start, 1.2_wp, tight('dopri5'), failure)
      order_of = log(maxval(abs(motion(model, start, 1.2_wp, fixed('dop853', h), failure) - reference))/ &
                     maxval(abs(motion(model, start, 1.2_wp, fixed('dop853', 0.5_wp*h), failure) - reference)))/log(2.0_wp)
   end function order_of

   subroutine pendulum_orders(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(state_t) :: at
      type(trajectory_t) :: reference, path
      type(integration_options_t) :: options
      real(wp), allocatable :: y(:)
      real(wp) :: e(2)
      integer :: i

      call pendulum(model, at)
      call check(failure, order_of(model, at, 0.1_wp, failure) > 7.6_wp, 'order at the end')
      options = tight('dopri5')
      options%output_dt = 0.03_wp
      y = motion(model, at, 1.2_wp, options, failure, reference)
      do i = 1, 2
         if (i == 2) path = trajectory_t()
         options = fixed('dop853', 0.3_wp/i)
         options%output_dt = 0.03_wp
         y = motion(model, at, 1.2_wp, options, failure, path)
         e(i) = maxval(abs(path%y(:, :path%points) - reference%y(:, :reference%points)))
      end do
      ! Local errors of order 7 + 1.
      call check(failure, log(e(1)/e(2))/log(2.0_wp) > 7.3_wp, 'order between the steps')
   end subroutine pendulum_orders

   subroutine top_orders(failure)
      character(:), allocatable, intent(inout) :: failure
      type(rigid_bodies_t) :: model
      type(state_t) :: at

      call top(model, at, failure)
      call check(failure, order_of(model, at, 0.04_wp, failure) > 7.6_wp, 'order')
   end subroutine top_orders

   subroutine compliance(failure)
      character(:), allocatable, intent(inout) :: failure
      type(rigid_bodies_t) :: model
      type(state_t) :: at
      type(violations_t) :: violations
      type(integration_options_t) :: options
      real(wp), allocatable :: y(:)

      call top(model, at, failure)
      options%integrator = 'dop853'
      y = motion(model, at, 1.0_wp, options, failure, violations)
      options%output_dt = 0.0123_wp
      y = motion(model, at, 1.0_wp, options, failure, violations)
      call check_below(failure, violations%phi, 1.0e-12_wp, 'position')
      call check_below(failure, violations%phidot, 1.0e-12_wp, 'velocity')
      call check_below(failure, violations%phiddot, 1.0e-11_wp, 'acceleration')
   end subroutine compliance

   subroutine evaluations(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(state_t) :: at, start
      type(integration_result_t) :: result
      type(integration_options_t) :: options
      type(trajectory_t) :: path
      type(error_t), allocatable :: error

      call pendulum(model, start)
      options%integrator = 'dop853'
      at = start
      call simulate(model, at, 5.0_wp, result, error, options=options)
      call no_error(failure, error)
      call check(failure, result%rhs_evaluations == 12*(result%steps + result%rejected) + 2, 'twelve a step')
      options%output_dt = 1.0_wp
      at = start
      call simulate(model, at, 5.0_wp, result, error, options=options, observer=path)
      call check(failure, result%rhs_evaluations == 12*(result%steps + result%rejected) + 2 + 3*4, 'three for each output point')
   end subroutine evaluations

   subroutine events_accurate(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(state_t) :: at
      type(integration_result_t) :: result(2)
      type(integration_options_t) :: options
      type(lowest_t) :: events
      type(error_t), allocatable :: error
      character(len=6), parameter :: names(2) = ['dopri5', 'dop853']
      integer :: i

      events%direction = [0]
      events%terminal = [.false.]
      do i = 1, 2
         call pendulum(model, at)
         options = tight(names(i))
         call simulate(model, at, 5.0_wp, result(i), error, options=options, events=events)
         call no_error(failure, error)
      end do
      call check(failure, size(result(1)%events) == size(result(2)%events) .and. size(result(1)%events) > 3, 'number')
      if (allocated(failure)) return
      call check_below(failure, maxval(abs(result(1)%events%t - result(2)%events%t)), 1.0e-11_wp, 'times')
   end subroutine events_accurate

   subroutine fewer_evaluations(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(state_t) :: at
      type(integration_result_t) :: result(2)
      type(integration_options_t) :: options
      type(error_t), allocatable :: error
      character(len=6), parameter :: names(2) = ['dopri5', 'dop853']
      integer :: i

      do i = 1, 2
         call pendulum(model, at)
         options%integrator = names(i)
         options%rtol = 1.0e-10_wp
         options%atol = 1.0e-10_wp
         call simulate(model, at, 5.0_wp, result(i), error, options=options)
         call no_error(failure, error)
      end do
      call check(failure, 2*result(2)%rhs_evaluations < result(1)%rhs_evaluations, 'half of them at 1e-10')
   end subroutine fewer_evaluations

   subroutine nothing_allocated(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(state_t) :: at
      class(constrained_ode_t), allocatable :: ode
      type(integrator_t) :: integrator
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(quiet_t) :: observer
      type(error_t), allocatable :: error
      integer(int64) :: before, counted(2)
      real(wp) :: t, y(4)
      integer :: i

      call pendulum(model, at)
      options%integrator = 'dop853'
      options%max_step = 0.02_wp
      options%output_dt = 0.007_wp
      call new_constrained_ode(ode, model, method_t(), error)
      call no_error(failure, error)
      call integrator%init(4, options, error)
      call no_error(failure, error)
      do i = 1, 2
         t = 0.0_wp
         y = [at%x, at%v]
         before = allocations
         call integrator%run(ode, t, y, real(i, wp), result, observer)
         counted(i) = allocations - before
      end do
      call check(failure, counted(1) == counted(2) .or. .not. counts_matter, 'more allocations for more steps')
      call check(failure, observer%points > 200, 'points')
   end subroutine nothing_allocated

end module test_dop853
