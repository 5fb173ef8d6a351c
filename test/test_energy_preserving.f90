!> Constraints within an energy-preserving discretization: energy to round-off, order, every kind of constraint, refusals.
module test_energy_preserving
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use closed_forms, only: pendulum_motion
   use systems, only: actuator, bead, driven_pivot, new_compound, new_coupler, new_particle, sleigh_in_space
   use taut, only: constrained_ode_t, error_t, integration_options_t, integration_result_t, mechanical_system_t, method_t, &
                   observer_t, ode_system_t, sample_t, simulate, state_t, status_reached_end, wp
   use taut_model_pendulum, only: new_pendulum, pendulum_t
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_energy_preserving

   real(wp), parameter :: g = 9.81_wp, right_angle = 0.5_wp*acos(-1.0_wp)

   !> The worst of a run.
   type, extends(observer_t) :: worst_t
      real(wp) :: energy = 0.0_wp, start = -huge(1.0_wp), phi = 0.0_wp, phidot = 0.0_wp
   contains
      procedure :: observe
   end type worst_t

contains

   !> All tests of this module.
   function collect_energy_preserving() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('energy to round-off at steps of any length', keeps_energy), &
               new_test('order 2, constraints of all kinds', orders), &
               new_test('its own steps', controlled), &
               new_test('refused where it does not belong', refused)]
   end function collect_energy_preserving

   subroutine observe(self, ode, t, h, y, error)
      class(worst_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t, h
      real(wp), intent(in), contiguous :: y(:)
      type(error_t), allocatable, intent(inout) :: error
      type(sample_t) :: s
      integer :: info

      select type (ode)
      class is (constrained_ode_t)
         call ode%sample(t, y, s, info)
      end select
      if (ieee_is_finite(s%energy)) then
         if (self%start <= -huge(1.0_wp)) self%start = s%energy
         self%energy = max(self%energy, abs(s%energy - self%start))
      end if
      self%phi = max(self%phi, s%phi)
      self%phidot = max(self%phidot, s%phidot)
      associate (unused_step => h, unused_error => error)
      end associate
   end subroutine observe

   !> A run of steps of one length, or by a tolerance.
   subroutine run(model, at, t_end, failure, step, rtol, integrator, worst, result)
      class(mechanical_system_t), intent(in) :: model
      type(state_t), intent(inout) :: at
      real(wp), intent(in) :: t_end
      character(:), allocatable, intent(inout) :: failure
      real(wp), intent(in), optional :: step, rtol
      character(*), intent(in), optional :: integrator
      type(worst_t), intent(out), optional :: worst
      type(integration_result_t), intent(out), optional :: result
      type(integration_options_t) :: options
      type(integration_result_t) :: how
      type(worst_t) :: seen
      type(error_t), allocatable :: error

      options%integrator = 'energy-preserving'
      if (present(integrator)) options%integrator = integrator
      if (present(step)) options%step_control = 'fixed'
      if (present(step)) options%first_step = step
      if (present(rtol)) options%rtol = rtol
      if (present(rtol)) options%atol = rtol
      call simulate(model, at, t_end, how, error, method_t(state_projection='position'), options, seen)
      call no_error(failure, error)
      call check(failure, how%status == status_reached_end, 'the end is reached')
      if (present(worst)) worst = seen
      if (present(result)) result = how
   end subroutine run

   !> A pendulum, its constraint stated once and three times, in steps of a tenth and a hundredth of a second.
   subroutine keeps_energy(failure)
      character(:), allocatable, intent(inout) :: failure
      real(wp), parameter :: step(2) = [0.1_wp, 0.01_wp]
      type(pendulum_t) :: pendulum
      type(state_t) :: at
      type(worst_t) :: worst
      type(error_t), allocatable :: error
      integer :: i

      do i = 1, 2
         call new_pendulum(pendulum, 1.0_wp, 1.0_wp, g, 2*i - 1, error)
         at = state_t(x=[1.0_wp, 0.0_wp], v=[0.0_wp, 0.0_wp])
         call run(pendulum, at, 20.0_wp, failure, step(i), worst=worst)
         call check_below(failure, worst%energy, 1.0e-11_wp, 'energy')
         call check_below(failure, worst%phi, 1.0e-12_wp, 'positions')
         call check(failure, worst%phidot > 1.0e-5_wp, 'velocities are met on the average only')
      end do
      ! A is not its own discrete derivative where a body turns.
      do i = 1, 2
         at = state_t(x=[0.3_wp, -0.4_wp, 0.8_wp, 0.6_wp], v=[0.0_wp, 0.0_wp, 0.0_wp])
         call run(new_compound(), at, 10.0_wp, failure, 0.5_wp*step(i), worst=worst)
         call check_below(failure, worst%energy, 1.0e-11_wp, 'energy of a body')
         call check_below(failure, worst%phi, 1.0e-12_wp, 'positions of a body')
      end do
      ! Another method of order 2 does not keep it.
      at = state_t(x=[1.0_wp, 0.0_wp], v=[0.0_wp, 0.0_wp])
      call run(pendulum, at, 20.0_wp, failure, 0.01_wp, integrator='generalized-alpha', worst=worst)
      call check(failure, worst%energy > 1.0e-5_wp, 'generalized-alpha does not')
   end subroutine keeps_energy

   subroutine orders(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: pendulum
      type(error_t), allocatable :: error

      call new_pendulum(pendulum, 1.0_wp, 1.0_wp, g, 1, error)
      call order('pendulum', pendulum, [1.0_wp, 0.0_wp], [0.0_wp, 0.0_wp], [real(wp) ::])
      call order('a bead on a turning wire', new_particle(bead, rate=1.3_wp), [1.0_wp, 0.0_wp], [0.0_wp, 1.3_wp], [real(wp) ::])
      call order('rheonomic', new_particle(driven_pivot, rate=5.0_wp, amplitude=0.2_wp), [1.0_wp, 0.0_wp], [0.0_wp, 0.0_wp], &
                 [real(wp) ::])
      call order('non-holonomic and holonomic', new_particle(sleigh_in_space), [0.0_wp, 0.0_wp, 0.3_wp, 0.0_wp], &
                 [1.0_wp, 0.3_wp, 0.4_wp, 0.0_wp], [real(wp) ::])
      call order('coordinates of their own', new_compound(), [0.3_wp, -0.4_wp, 0.8_wp, 0.6_wp], [0.0_wp, 0.0_wp, 0.0_wp], &
                 [real(wp) ::])
      call order('redundant at times', new_coupler(3), [0.6_wp, -0.8_wp, 0.0_wp], [0.0_wp, 0.0_wp, 0.0_wp], [real(wp) ::])
      call order('other states', new_particle(actuator), [0.0_wp], [0.0_wp], [3.0_wp])

   contains

      subroutine order(name, model, x, v, w)
         character(*), intent(in) :: name
         class(mechanical_system_t), intent(in) :: model
         real(wp), intent(in) :: x(:), v(:), w(:)
         type(state_t) :: at, exact
         real(wp) :: off(2)
         integer :: i

         exact = state_t(x=x, v=v, w=w)
         call run(model, exact, 1.0_wp, failure, rtol=1.0e-12_wp, integrator='dopri5')
         do i = 1, 2
            at = state_t(x=x, v=v, w=w)
            call run(model, at, 1.0_wp, failure, step=0.02_wp/i)
            off(i) = maxval(abs([at%x - exact%x, at%v - exact%v, at%w - exact%w]))
         end do
         call check_close(failure, log(off(1)/off(2))/log(2.0_wp), 2.0_wp, 0.2_wp, name)
      end subroutine order

   end subroutine orders

   !> The error follows the tolerance.
   subroutine controlled(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: pendulum
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp) :: angle, off(2), period, rate
      integer :: i, steps(2)

      call pendulum_motion(2.0_wp, 1.0_wp, g, right_angle, angle, rate, period)
      call new_pendulum(pendulum, 1.0_wp, 1.0_wp, g, 1, error)
      do i = 1, 2
         at = state_t(x=[1.0_wp, 0.0_wp], v=[0.0_wp, 0.0_wp])
         call run(pendulum, at, 2.0_wp, failure, rtol=merge(1.0e-4_wp, 1.0e-7_wp, i == 1), result=result)
         off(i) = maxval(abs(at%x - [sin(angle), -cos(angle)]))
         steps(i) = result%steps
      end do
      call check_below(failure, off(1), 2.0e-2_wp, 'loose')
      call check_below(failure, off(2), 2.0e-4_wp, 'tight')
      call check(failure, steps(2) > 5*steps(1) .and. steps(2) < 20*steps(1), 'steps by the cube root of the tolerance')
   end subroutine controlled

   subroutine refused(failure)
      character(:), allocatable, intent(inout) :: failure

      call refuse(method_t(name='baseline', state_projection='position'), 'does not take its right-hand side')
      call refuse(method_t(), 'state_projection = "position-velocity"')

   contains

      subroutine refuse(method, words)
         type(method_t), intent(in) :: method
         character(*), intent(in) :: words
         type(pendulum_t) :: pendulum
         type(state_t) :: at
         type(integration_result_t) :: result
         type(error_t), allocatable :: error

         call new_pendulum(pendulum, 1.0_wp, 1.0_wp, g, 1, error)
         at = state_t(x=[1.0_wp, 0.0_wp], v=[0.0_wp, 0.0_wp])
         call simulate(pendulum, at, 1.0_wp, result, error, method, integration_options_t(integrator='energy-preserving'))
         call check(failure, allocated(error), words)
         if (allocated(error)) call check(failure, index(error%line(), words) > 0, error%line())
      end subroutine refuse

   end subroutine refused

end module test_energy_preserving
