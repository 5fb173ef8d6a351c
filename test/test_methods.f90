!> What each method keeps and what it lets drift, and that it converges to its own limit.
module test_methods
   use closed_forms, only: pendulum_motion
   use systems, only: new_coupler
   use taut, only: constrained_ode_t, error_t, integration_options_t, integration_result_t, method_t, observer_t, ode_system_t, &
                   sample_t, simulate, state_t, status_reached_end, wp
   use taut_constrained_method_choose, only: new_constrained_ode
   use taut_error, only: to_text
   use taut_model_pendulum, only: new_pendulum, pendulum_t
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_methods

   real(wp), parameter :: g = 9.81_wp, right_angle = 0.5_wp*acos(-1.0_wp)

   !> The worst of every level along a motion.
   type, extends(observer_t) :: levels_t
      real(wp) :: phi = 0.0_wp, phidot = 0.0_wp, phiddot = 0.0_wp, motion = 0.0_wp, tension = 0.0_wp
   contains
      procedure :: observe
   end type levels_t

   !> How a pendulum, released from the horizontal at rest, has swung.
   type :: swung_t
      type(levels_t) :: levels
      type(integration_result_t) :: result
      class(constrained_ode_t), allocatable :: ode
      type(state_t) :: at
      character(:), allocatable :: remark
   end type swung_t

contains

   !> All tests of this module.
   function collect_methods() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('order of convergence to the closed form', orders), &
               new_test('minimal coordinates keep the velocities and let the positions drift', minimal_drift), &
               new_test('minimal coordinates: only the independent velocities count', minimal_independent), &
               new_test('minimal coordinates choose others where those at hand wear out', minimal_switches), &
               new_test('minimal coordinates and redundant cranks', minimal_redundant)]
   end function collect_methods

   subroutine observe(self, ode, t, h, y, error)
      class(levels_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t, h
      real(wp), intent(in), contiguous :: y(:)
      type(error_t), allocatable, intent(inout) :: error
      type(sample_t) :: s
      real(wp) :: angle, period, rate
      integer :: info

      select type (ode)
      class is (constrained_ode_t)
         call ode%sample(t, y, s, info)
      end select
      call pendulum_motion(t, 1.0_wp, g, right_angle, angle, rate, period)
      self%phi = max(self%phi, s%phi)
      self%phidot = max(self%phidot, s%phidot)
      self%phiddot = max(self%phiddot, s%phiddot)
      self%motion = max(self%motion, maxval(abs(y(1:4) - [sin(angle), -cos(angle), rate*cos(angle), rate*sin(angle)])))
      self%tension = max(self%tension, abs(sum(s%lambda) - 3.0_wp*g*cos(angle)))
      associate (unused_step => h, unused_error => error)
      end associate
   end subroutine observe

   !> A pendulum by a method, with steps of one length or by tolerance.
   subroutine swing(method, t_end, swung, failure, step, rtol, copies)
      type(method_t), intent(in) :: method
      real(wp), intent(in) :: t_end
      type(swung_t), intent(out) :: swung
      character(:), allocatable, intent(inout) :: failure
      real(wp), intent(in), optional :: step, rtol
      integer, intent(in), optional :: copies
      type(pendulum_t) :: model
      type(integration_options_t) :: options
      type(error_t), allocatable :: error
      integer :: stated

      stated = 1
      if (present(copies)) stated = copies
      if (present(step)) then
         options%step_control = 'fixed'
         options%first_step = step
      end if
      if (present(rtol)) then
         options%rtol = rtol
         options%atol = rtol
      end if
      call new_pendulum(model, 1.0_wp, 1.0_wp, g, stated, error)
      swung%at%x = [1.0_wp, 0.0_wp]
      swung%at%v = [0.0_wp, 0.0_wp]
      call simulate(model, swung%at, t_end, swung%result, error, method, options, swung%levels, ode=swung%ode)
      call no_error(failure, error)
      if (allocated(swung%ode)) call swung%ode%remark(swung%remark)
   end subroutine swing

   !> Half the step, a 2^order-th of the error.
   subroutine orders(failure)
      character(:), allocatable, intent(inout) :: failure

      call order('null space', method_t(name='minimal-coordinates'), 5)
      call order('partitioning', method_t(name='minimal-coordinates', independent='partitioning'), 5)
      call order('positions that drift', &
                 method_t(name='minimal-coordinates', stage_projection='none', state_projection='none'), 5)

   contains

      subroutine order(name, method, expected)
         character(*), intent(in) :: name
         type(method_t), intent(in) :: method
         integer, intent(in) :: expected
         type(swung_t) :: coarse, fine
         real(wp) :: seen

         call swing(method, 2.0_wp, coarse, failure, step=1.0_wp/64.0_wp)
         call swing(method, 2.0_wp, fine, failure, step=1.0_wp/128.0_wp)
         seen = log(coarse%levels%motion/fine%levels%motion)/log(2.0_wp)
         call check(failure, seen > expected - 0.5_wp, name//': order '//to_text(seen))
         call check_below(failure, fine%levels%motion, 1.0e-4_wp, name//': motion')
      end subroutine order

   end subroutine orders

   !> Velocities meet their constraints by construction; positions are integrals, and drift with the tolerance.
   subroutine minimal_drift(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=16), parameter :: independent(2) = [character(len=16) :: 'null-space', 'partitioning']
      type(method_t) :: method
      type(swung_t) :: kept, loose, tight
      integer :: i

      method%name = 'minimal-coordinates'
      do i = 1, size(independent)
         method%independent = independent(i)
         method%stage_projection = 'none'
         method%state_projection = 'none'
         call swing(method, 10.0_wp, loose, failure, rtol=1.0e-6_wp)
         call swing(method, 10.0_wp, tight, failure, rtol=1.0e-9_wp)
         call check_below(failure, max(loose%levels%phidot, tight%levels%phidot), 1.0e-13_wp, 'velocities')
         call check_below(failure, max(loose%levels%phiddot, tight%levels%phiddot), 1.0e-11_wp, 'accelerations')
         call check(failure, loose%levels%phi > 1.0e-7_wp .and. tight%levels%phi < 1.0e-2_wp*loose%levels%phi .and. &
                    tight%levels%phi > 1.0e-10_wp, 'positions drift with the tolerance')
         method%stage_projection = 'newton'
         method%state_projection = 'position-velocity'
         call swing(method, 10.0_wp, kept, failure, rtol=1.0e-9_wp)
         call check_below(failure, max(kept%levels%phi, kept%levels%phidot), 1.0e-12_wp, 'positions that are projected')
         call check_below(failure, kept%levels%motion, 1.0e-6_wp, 'motion')
         call check_below(failure, kept%levels%tension, 1.0e-5_wp, 'tension')
      end do
   end subroutine minimal_drift

   !> At {0.6, -0.8} the horizontal velocity has the larger pivot; a basis of the null space is {0.8, 0.6}.
   subroutine minimal_independent(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=16), parameter :: independent(2) = [character(len=16) :: 'null-space', 'partitioning']
      type(pendulum_t) :: model
      type(method_t) :: method
      class(constrained_ode_t), allocatable :: ode
      type(error_t), allocatable :: error
      real(wp) :: dydt(4), other(4), y(4)
      integer :: i, info

      call new_pendulum(model, 1.0_wp, 1.0_wp, g, 1, error)
      method%name = 'minimal-coordinates'
      do i = 1, size(independent)
         method%independent = independent(i)
         call new_constrained_ode(ode, model, method, error)
         y = [0.6_wp, -0.8_wp, 0.8_wp, 0.6_wp]
         call ode%rhs(0.0_wp, y, dydt, info)
         if (i == 1) y(3:4) = y(3:4) + 0.3_wp*[0.6_wp, -0.8_wp]
         if (i == 2) y(4) = y(4) + 0.3_wp
         call ode%rhs(0.0_wp, y, other, info)
         call check_below(failure, maxval(abs(other - dydt)), 1.0e-14_wp, trim(independent(i))//': dependent velocities')
         y(3) = y(3) + 0.3_wp
         call ode%rhs(0.0_wp, y, other, info)
         call check(failure, maxval(abs(other - dydt)) > 0.1_wp, trim(independent(i))//': independent ones')
      end do
   end subroutine minimal_independent

   !> A pendulum from the horizontal: its height tells its velocity until it hangs, its other coordinate from there on.
   subroutine minimal_switches(failure)
      character(:), allocatable, intent(inout) :: failure
      type(method_t) :: method
      type(swung_t) :: swung
      real(wp) :: angle, period, rate

      call pendulum_motion(0.0_wp, 1.0_wp, g, right_angle, angle, rate, period)
      method%name = 'minimal-coordinates'
      method%independent = 'partitioning'
      call swing(method, period, swung, failure, rtol=1.0e-9_wp)
      call check(failure, index(swung%remark, 'chosen anew 4 times') > 0, 'twice down and twice up again: '//swung%remark)
      call check_below(failure, swung%levels%motion, 1.0e-7_wp, 'motion')
      call swing(method, period, swung, failure, step=0.01_wp*period)
      call check_below(failure, swung%levels%motion, 1.0e-5_wp, 'motion in steps of one length')
      ! A choice that stays knows nothing of the motion where the rod hangs, and steps that do not shrink there tell.
      method%independent = 'constant'
      call swing(method, 0.2_wp*period, swung, failure, step=0.01_wp*period)
      call check_below(failure, swung%levels%motion, 1.0e-5_wp, 'a constant choice before the rod hangs')
      call swing(method, period, swung, failure, step=0.01_wp*period)
      call check(failure, swung%levels%motion > 1.0e-2_wp, 'a constant choice behind')
   end subroutine minimal_switches

   !> Three parallel cranks: rank 2 on the constraints, 3 beside them; each carries a third.
   subroutine minimal_redundant(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=16), parameter :: independent(2) = [character(len=16) :: 'null-space', 'partitioning']
      integer :: i

      do i = 1, size(independent)
         call cranks('minimal-coordinates, '//trim(independent(i)), &
                     method_t(name='minimal-coordinates', independent=independent(i)), failure)
      end do
   end subroutine minimal_redundant

   subroutine cranks(name, method, failure)
      character(*), intent(in) :: name
      type(method_t), intent(in) :: method
      character(:), allocatable, intent(inout) :: failure
      real(wp), parameter :: angle_0 = 1.0_wp
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      class(constrained_ode_t), allocatable :: ode
      type(sample_t) :: s
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp), allocatable :: y(:)
      real(wp) :: angle, period, rate
      integer :: info

      options%rtol = 1.0e-9_wp
      options%atol = 1.0e-9_wp
      at%x = [sin(angle_0), -cos(angle_0), 0.0_wp]
      at%v = [0.0_wp, 0.0_wp, 0.0_wp]
      call simulate(new_coupler(3), at, 5.0_wp, result, error, method, options, ode=ode)
      call no_error(failure, error)
      call check(failure, result%status == status_reached_end, name//': the end is reached')
      if (allocated(failure)) return
      call pendulum_motion(5.0_wp, 1.0_wp, g, angle_0, angle, rate, period)
      call check_below(failure, maxval(abs(at%x - [sin(angle), -cos(angle), 0.0_wp])), 1.0e-6_wp, name//': motion')
      allocate (y(ode%size()))
      call ode%pack(at, y)
      call ode%sample(at%t, y, s, info)
      call check(failure, s%rank == 2, name//': rank')
      call check_below(failure, maxval(abs(s%lambda - sum(s%lambda)/3.0_wp)), 1.0e-6_wp, name//': shares of the load')
   end subroutine cranks

end module test_methods
