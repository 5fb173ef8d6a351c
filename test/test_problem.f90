!> A constrained system in the hands of other integrators.
module test_problem
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_quiet_nan, ieee_value
   use systems, only: compound_t, new_compound, new_particle, particle_t, two_rods
   use taut, only: constrained_problem_t, error_t, integration_options_t, integration_result_t, method_t, sample_t, simulate, &
                   state_t, wp
   use taut_model_pendulum, only: new_pendulum, pendulum_t
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_problem

   !> A pendulum whose constraint is not defined beyond a fence.
   type, extends(pendulum_t) :: fenced_t
   contains
      procedure :: constraint => fenced_constraint
   end type fenced_t

contains

   !> All tests of this module.
   function collect_problem() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('what is evaluated beside the constraints is what is evaluated on them', evaluated_alike), &
               new_test('a projection behind an evaluation is the same as one alone', projected_alike), &
               new_test('a look between evaluation and projection spoils nothing', looked_between), &
               new_test('corrected forces are those of both forms and give the accelerations', balanced), &
               new_test('errors normal to the constraints do not count', filtered), &
               new_test('the start is brought to the constraints', started), &
               new_test('where nothing is defined it is said, or nothing is a number', undefined), &
               new_test('methods that project otherwise are refused', refused), &
               new_test('the classical Runge-Kutta method keeps its order', fourth_order)]
   end function collect_problem

   !> A compound pendulum that swings, in four coordinates and three velocities.
   subroutine new_problem(failure, problem, form)
      character(:), allocatable, intent(inout) :: failure
      type(constrained_problem_t), intent(out) :: problem
      character(*), intent(in), optional :: form
      type(compound_t) :: system
      type(state_t) :: at
      type(method_t) :: method
      type(error_t), allocatable :: error

      if (present(form)) method%form = form
      system = new_compound()
      at%x = [system%arm*sin(0.7_wp), -system%arm*cos(0.7_wp), cos(0.7_wp), sin(0.7_wp)]
      at%v = [system%arm*cos(0.7_wp), system%arm*sin(0.7_wp), 1.0_wp]*1.3_wp
      call problem%init(system, at, error, method)
      call no_error(failure, error)
   end subroutine new_problem

   !> A state beside the constraints.
   function beside(problem) result(y)
      type(constrained_problem_t), intent(in) :: problem
      real(wp) :: y(problem%n)

      y = problem%y + [1.0e-3_wp, -2.0e-3_wp, 1.5e-3_wp, 1.0e-3_wp, 3.0e-3_wp, -2.0e-3_wp, 1.0e-3_wp]
   end function beside

   subroutine evaluated_alike(failure)
      character(:), allocatable, intent(inout) :: failure
      type(constrained_problem_t) :: problem
      real(wp) :: y(7), off(7), on(7)
      integer :: info

      call new_problem(failure, problem)
      if (allocated(failure)) return
      y = beside(problem)
      call problem%rhs(0.0_wp, y, off)
      call problem%project(0.0_wp, y, info)
      call check(failure, info == 0, 'the projection failed')
      call problem%rhs(0.0_wp, y, on)
      call check_below(failure, maxval(abs(on - off)), 1.0e-10_wp, 'derivatives differ')
      call check(failure, problem%evaluations == 2, 'evaluations are not counted')
   end subroutine evaluated_alike

   subroutine projected_alike(failure)
      character(:), allocatable, intent(inout) :: failure
      type(constrained_problem_t) :: problem
      type(sample_t) :: seen
      real(wp) :: alone(7), behind(7), dydt(7)
      integer :: info

      call new_problem(failure, problem)
      if (allocated(failure)) return
      alone = beside(problem)
      behind = alone
      call problem%project(0.0_wp, alone, info)
      call problem%rhs(0.0_wp, behind, dydt)
      call problem%project(0.0_wp, behind, info)
      call check_below(failure, maxval(abs(alone - behind)), 1.0e-14_wp, 'projections differ')
      call check(failure, maxval(abs(alone - beside(problem))) > 1.0e-4_wp, 'nothing was projected')
      call problem%sample(0.0_wp, behind, seen, info)
      call check_below(failure, max(seen%phi, seen%phidot, seen%phiddot), 1.0e-12_wp, 'the constraints are not met')
   end subroutine projected_alike

   subroutine looked_between(failure)
      character(:), allocatable, intent(inout) :: failure
      type(constrained_problem_t) :: problem
      type(sample_t) :: seen
      real(wp) :: alone(7), between(7), dydt(7)
      integer :: info

      call new_problem(failure, problem)
      if (allocated(failure)) return
      alone = beside(problem)
      between = alone
      call problem%project(0.0_wp, alone, info)
      call problem%rhs(0.0_wp, between, dydt)
      call problem%sample(0.0_wp, problem%y + 0.1_wp, seen, info)
      call problem%project(0.0_wp, between, info)
      call check_below(failure, maxval(abs(alone - between)), 1.0e-14_wp, 'projections differ')
      ! Nor does an evaluation at another time, or at another state, stand for this one.
      between = beside(problem)
      call problem%rhs(0.0_wp, problem%y + 0.01_wp, dydt)
      call problem%project(0.0_wp, between, info)
      call check_below(failure, maxval(abs(alone - between)), 1.0e-14_wp, 'the projection is of another state')
   end subroutine looked_between

   subroutine balanced(failure)
      character(:), allocatable, intent(inout) :: failure
      type(constrained_problem_t) :: acceleration, force
      type(compound_t) :: system
      real(wp) :: dydt(7), f(3), other(3), xdot(4), y(7)
      integer :: info

      call new_problem(failure, acceleration)
      call new_problem(failure, force, 'force')
      if (allocated(failure)) return
      y = beside(acceleration)
      call acceleration%balance(0.0_wp, y, xdot, f, info=info)
      call force%balance(0.0_wp, y, xdot, other, info=info)
      call check_below(failure, maxval(abs(f - other)), 1.0e-12_wp, 'the two forms differ')
      call acceleration%rhs(0.0_wp, y, dydt)
      call check_below(failure, maxval(abs(xdot - dydt(:4))), 1.0e-14_wp, 'rates of coordinates differ')
      f = f/[system%m, system%m, system%inertia]
      call check_below(failure, maxval(abs(f - dydt(5:))), 1.0e-12_wp, 'M vdot is not the corrected force')
   end subroutine balanced

   subroutine filtered(failure)
      character(:), allocatable, intent(inout) :: failure
      type(constrained_problem_t) :: problem
      real(wp) :: dydt(7), e(7), along(7)

      call new_problem(failure, problem)
      if (allocated(failure)) return
      call problem%rhs(0.0_wp, problem%y, dydt)
      along = 0.0_wp
      along(5:) = problem%y(5:)
      e = along
      call problem%filter_error(e)
      call check_below(failure, maxval(abs(e - along)), 1.0e-14_wp, 'an error along the motion was taken off')
      ! The only motion that the constraints leave is along v: what is normal to it is gone.
      e = along + [0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, problem%y(6), -problem%y(5), 0.0_wp]
      call problem%filter_error(e)
      call check_below(failure, maxval(abs(e - along)), 1.0e-14_wp, 'an error normal to the constraints was left')
   end subroutine filtered

   subroutine started(failure)
      character(:), allocatable, intent(inout) :: failure
      type(constrained_problem_t) :: problem
      type(pendulum_t) :: system
      type(state_t) :: at, again
      type(error_t), allocatable :: error

      call new_pendulum(system, 1.0_wp, 1.0_wp, 9.81_wp, 1, error)
      at = state_t(t=0.5_wp, x=[3.0_wp, 4.0_wp]/4.0_wp, v=[1.0_wp, 0.0_wp])
      call problem%init(system, at, error)
      call no_error(failure, error)
      call check_below(failure, norm2(problem%y - [0.6_wp, 0.8_wp, 0.64_wp, -0.48_wp]), 1.0e-12_wp, 'it starts elsewhere')
      call check_close(failure, problem%start%moved_x, 0.2_wp, 1.0e-12_wp, 'how far it was moved')
      call check(failure, problem%start%freedoms == 1 .and. problem%n == 4 .and. abs(problem%t - 0.5_wp) <= 0.0_wp, 'sizes')
      call problem%unpack(problem%t, problem%y, again)
      call check_below(failure, norm2([again%x - at%x, again%v - at%v, again%t - 0.5_wp]), 0.0_wp, 'state and vector differ')
   end subroutine started

   subroutine fenced_constraint(self, at, value)
      class(fenced_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      call self%pendulum_t%constraint(at, value)
      if (at%x(1) > 2.0_wp) value = ieee_value(1.0_wp, ieee_quiet_nan)
   end subroutine fenced_constraint

   subroutine undefined(failure)
      character(:), allocatable, intent(inout) :: failure
      type(constrained_problem_t) :: problem
      type(fenced_t) :: system
      type(error_t), allocatable :: error
      type(state_t) :: at
      real(wp) :: y(4), dydt(4)
      integer :: info

      call new_pendulum(system%pendulum_t, 1.0_wp, 1.0_wp, 9.81_wp, 1, error)
      at = state_t(x=[1.0_wp, 0.0_wp], v=[0.0_wp, 0.0_wp])
      call problem%init(system, at, error)
      y = [3.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      call problem%rhs(0.0_wp, y, dydt, info)
      call check(failure, info > 0, 'a derivative was found')
      call problem%project(0.0_wp, y, info)
      call check(failure, info > 0, 'a projection was found')
      call check(failure, norm2(y) >= 3.0_wp, 'the state was not left alone')
      call problem%rhs(0.0_wp, y, dydt)
      call check(failure, all(ieee_is_nan(dydt)), 'the derivative is a number')
      call problem%project(0.0_wp, y)
      call check(failure, all(ieee_is_nan(y)), 'the state is a number')
   end subroutine undefined

   subroutine refused(failure)
      character(:), allocatable, intent(inout) :: failure
      type(constrained_problem_t) :: problem
      type(particle_t) :: system
      type(error_t), allocatable :: error
      type(state_t) :: at

      system = new_particle(two_rods, ratio=1.5_wp)
      at = state_t(x=[1.0_wp, 0.0_wp], v=[0.0_wp, 0.0_wp])
      call problem%init(system, at, error, method_t(name='yu-chen'))
      call check(failure, allocated(error), 'a method that corrects now and then was taken')
      if (allocated(error)) call check(failure, index(error%what, 'does not project each evaluation') > 0, error%line())
      deallocate (error)
      call problem%init(system, at, error)
      call check(failure, allocated(error), 'constraints that contradict each other were taken')
   end subroutine refused

   !> Against taut's own integrator; the error falls by 2^4 where the step is halved.
   subroutine fourth_order(failure)
      character(:), allocatable, intent(inout) :: failure
      type(constrained_problem_t) :: problem
      type(compound_t) :: system
      type(state_t) :: at
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      real(wp) :: coarse, fine
      integer :: i
      real(wp), parameter :: t_end = 1.0_wp

      call new_problem(failure, problem)
      if (allocated(failure)) return
      system = new_compound()
      call problem%unpack(0.0_wp, problem%y, at)
      call simulate(system, at, t_end, result, error, options=integration_options_t('dop853', 1.0e-12_wp, 1.0e-12_wp))
      call no_error(failure, error)
      coarse = error_of(50)
      fine = error_of(100)
      call check_close(failure, log(coarse/fine)/log(2.0_wp), 4.0_wp, 0.2_wp, 'order')

   contains

      real(wp) function error_of(steps)
         integer, intent(in) :: steps
         real(wp) :: h, k1(7), k2(7), k3(7), k4(7), t, y(7)

         h = t_end/steps
         y = problem%y
         do i = 1, steps
            t = (i - 1)*h
            call problem%rhs(t, y, k1)
            call problem%rhs(t + h/2, y + h/2*k1, k2)
            call problem%rhs(t + h/2, y + h/2*k2, k3)
            call problem%rhs(t + h, y + h*k3, k4)
            y = y + h/6*(k1 + 2*k2 + 2*k3 + k4)
            call problem%project(t + h, y)
         end do
         error_of = norm2(y(:4) - at%x)
      end function error_of

   end subroutine fourth_order

end module test_problem
