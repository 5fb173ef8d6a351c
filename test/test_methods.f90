!> What each method keeps and what it lets drift, and that it converges to its own limit.
module test_methods
   use closed_forms, only: pendulum_motion
   use systems, only: new_compound, new_coupler, new_particle, sleigh_in_space
   use taut, only: block_diagonal_t, constrained_ode_t, error_t, integration_options_t, integration_result_t, mechanical_system_t, &
                   method_names, method_t, &
                   observer_t, ode_system_t, &
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

   !> A pendulum whose b'' is wrong.
   type, extends(pendulum_t) :: no_derivative_t
   contains
      procedure :: acceleration_rhs => wrong_second_derivative
   end type no_derivative_t

   !> A particle of 2 kg on the wire x = 1, in polar coordinates, so that M depends on them.
   type, extends(mechanical_system_t) :: polar_t
   contains
      procedure :: mass => polar_mass
      procedure :: force => polar_force
      procedure :: constraint => polar_constraint
      procedure :: jacobian => polar_jacobian
      procedure :: acceleration_rhs => polar_second_derivative
   end type polar_t

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
               new_test('minimal coordinates and redundant cranks', minimal_redundant), &
               new_test('the penalty of Bayo tends to Baumgarte''s method', bayo_limit), &
               new_test('the penalty of Bayo gives way by lambda/(alpha omega^2)', bayo_gives_way), &
               new_test('the augmented Lagrangian is Baumgarte''s method', augmented_is_baumgarte), &
               new_test('the elimination of Udwadia and Kalaba is that of Eq. (8)', udwadia_kalaba_is_baseline), &
               new_test('dummy derivatives: only the independent variables count', dummy_independent), &
               new_test('dummy derivatives keep all levels and switch', dummy_switches), &
               new_test('Gear, Gupta and Leimkuhler ask for no second derivative', no_second_derivative), &
               new_test('stabilized index 2 keeps two levels, with the second derivative three', stabilized_levels), &
               new_test('embedded projection: the impulse of the reactions is no velocity', embedded_impulse), &
               new_test('embedded projection keeps two levels and asks for no second derivative', embedded_levels), &
               new_test('embedded projection with masses that depend on coordinates', embedded_mass), &
               new_test('output between the steps changes no step', output_changes_nothing), &
               new_test('methods with full matrices refuse large systems', too_large)]
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
   subroutine swing(method, t_end, swung, failure, step, rtol, copies, output_dt)
      type(method_t), intent(in) :: method
      real(wp), intent(in) :: t_end
      type(swung_t), intent(out) :: swung
      character(:), allocatable, intent(inout) :: failure
      real(wp), intent(in), optional :: step, rtol, output_dt
      integer, intent(in), optional :: copies
      type(pendulum_t) :: model
      type(integration_options_t) :: options
      type(error_t), allocatable :: error
      integer :: stated

      stated = 1
      if (present(copies)) stated = copies
      if (present(output_dt)) options%output_dt = output_dt
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
      call order('augmented Lagrangian', method_t(name='augmented-lagrangian'), 5)
      call order('Udwadia and Kalaba', method_t(name='udwadia-kalaba'), 5)
      call order('dummy derivatives', method_t(name='dummy-derivatives'), 5)
      call order('Fuhrer and Leimkuhler', method_t(name='fuhrer-leimkuhler'), 5)
      call order('embedded projection', method_t(name='embedded-projection'), 5)
      call order('Gear, Gupta and Leimkuhler', method_t(name='gear-gupta-leimkuhler'), 3)
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
         call check(failure, seen > expected - 0.5_wp .and. seen < expected + 1.5_wp, name//': order '//to_text(seen))
         call check_below(failure, fine%levels%motion, 1.0e3_wp*(1.0_wp/128.0_wp)**expected, name//': motion')
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

   !> The distance falls as 1/alpha.
   subroutine bayo_limit(failure)
      character(:), allocatable, intent(inout) :: failure
      real(wp), parameter :: alpha(2) = [1.0e4_wp, 1.0e5_wp]
      type(swung_t) :: limit, swung
      type(method_t) :: method
      real(wp) :: distance(2)
      integer :: i

      method = method_t(name='baumgarte', alpha=6.0_wp, beta=10.0_wp)
      call swing(method, 2.0_wp, limit, failure, rtol=1.0e-11_wp)
      do i = 1, 2
         method = method_t(name='bayo-penalty', omega=10.0_wp, mu=0.6_wp, penalty_factor=alpha(i))
         call swing(method, 2.0_wp, swung, failure, rtol=1.0e-11_wp)
         distance(i) = maxval(abs([swung%at%x - limit%at%x, swung%at%v - limit%at%v]))
         call check(failure, swung%levels%phi > 0.1_wp*30.0_wp/(alpha(i)*100.0_wp), 'it gives way')
      end do
      call check_close(failure, log10(distance(1)/distance(2)), 1.0_wp, 0.05_wp, 'order in 1/alpha')
      call check_below(failure, distance(2), 1.0e-4_wp, 'distance')
   end subroutine bayo_limit

   !> A pendulum that hangs: the weight m g on m omega^2 times alpha/m.
   subroutine bayo_gives_way(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp), parameter :: alpha = 1.0e3_wp, omega = 8.0_wp, m = 2.0_wp

      options%rtol = 1.0e-11_wp
      options%atol = 1.0e-11_wp
      call new_pendulum(model, m, 1.0_wp, g, 1, error)
      at%x = [0.0_wp, -1.0_wp]
      at%v = [0.0_wp, 0.0_wp]
      call simulate(model, at, 4.0_wp, result, error, &
                    method_t(name='bayo-penalty', omega=omega, mu=1.0_wp, penalty_factor=alpha), options)
      call no_error(failure, error)
      call check_close(failure, -at%x(2), 1.0_wp + m*g/(alpha*omega**2), 1.0e-10_wp, 'length')
   end subroutine bayo_gives_way

   !> Whatever alpha: the gains omega mu and omega, reactions shared by redundant rows, few iterations.
   subroutine augmented_is_baumgarte(failure)
      character(:), allocatable, intent(inout) :: failure
      real(wp), parameter :: alpha(3) = [1.0e2_wp, 1.0e5_wp, 1.0e9_wp]
      type(swung_t) :: other, swung
      type(method_t) :: method
      real(wp) :: each(3)
      integer :: i

      call swing(method_t(name='baumgarte', alpha=6.0_wp, beta=10.0_wp), 2.0_wp, other, failure, rtol=1.0e-9_wp)
      do i = 1, 3
         method = method_t(name='augmented-lagrangian', omega=10.0_wp, mu=0.6_wp, penalty_factor=alpha(i))
         call swing(method, 2.0_wp, swung, failure, rtol=1.0e-9_wp)
         call check_below(failure, maxval(abs([swung%at%x - other%at%x, swung%at%v - other%at%v])), 1.0e-11_wp, 'motion')
         each(i) = real(swung%ode%projector%newton%iterations, wp)/swung%result%rhs_evaluations
      end do
      ! Each iteration leaves 1/(1 + alpha) of the violation, and 1e-12 is wanted.
      call check(failure, abs(each(1) - 6.0_wp) <= 0.5_wp .and. abs(each(2) - 3.0_wp) <= 0.5_wp .and. &
                 abs(each(3) - 2.0_wp) <= 0.5_wp, 'iterations: '//to_text(each(1))//', '//to_text(each(2))//', '//to_text(each(3)))
      method%penalty_factor = 1.0e4_wp
      call swing(method, 2.0_wp, swung, failure, rtol=1.0e-9_wp, copies=3)
      call check_below(failure, maxval(abs([swung%at%x - other%at%x, swung%at%v - other%at%v])), 1.0e-11_wp, 'three copies')
      call check_below(failure, maxval(abs(swung%ode%lambda - sum(swung%ode%lambda)/3.0_wp)), 1.0e-9_wp, 'a third each')
      call cranks('augmented-lagrangian', method_t(name='augmented-lagrangian'), failure)
   end subroutine augmented_is_baumgarte

   !> Accelerations and multipliers at states beside the constraints, of full and of lower rank, with M full and diagonal.
   subroutine udwadia_kalaba_is_baseline(failure)
      character(:), allocatable, intent(inout) :: failure
      type(state_t) :: at
      type(swung_t) :: swung

      allocate (at%w(0))
      at%x = [sin(1.0_wp), -cos(1.0_wp), 0.0_wp]
      at%v = [0.3_wp, 0.2_wp, 0.1_wp]
      call compare(new_coupler(3), 'redundant cranks')
      at%x = [0.6_wp, -0.8_wp, 0.6_wp, 0.8_wp]
      call compare(new_compound(), 'a quaternion of the plane')
      at%x = [0.9_wp, 0.6_wp, 0.7_wp, 0.1_wp]
      at%v = [0.4_wp, 2.1_wp, 1.7_wp, 0.3_wp]
      call compare(new_particle(sleigh_in_space), 'holonomic and non-holonomic')
      ! What is enforced is the acceleration, and the rest drifts.
      call swing(method_t(name='udwadia-kalaba'), 10.0_wp, swung, failure, rtol=1.0e-6_wp)
      call check_below(failure, swung%levels%phiddot, 1.0e-11_wp, 'accelerations')
      call check(failure, swung%levels%phi > 1.0e-7_wp .and. swung%levels%phidot > 1.0e-7_wp, 'positions and velocities drift')

   contains

      subroutine compare(model, name)
         class(mechanical_system_t), intent(in) :: model
         character(*), intent(in) :: name
         class(constrained_ode_t), allocatable :: baseline, ode
         type(sample_t) :: other, s
         type(error_t), allocatable :: error
         real(wp), allocatable :: dydt(:), expected(:), y(:)
         integer :: info

         call new_constrained_ode(baseline, model, method_t(name='baseline'), error)
         call new_constrained_ode(ode, model, method_t(name='udwadia-kalaba'), error)
         call no_error(failure, error)
         allocate (y(ode%size()), dydt(ode%size()), expected(ode%size()))
         call ode%pack(at, y)
         call ode%rhs(0.0_wp, y, dydt, info)
         call baseline%rhs(0.0_wp, y, expected, info)
         call check_below(failure, maxval(abs(dydt - expected)), 1.0e-11_wp, name//': derivative')
         call ode%sample(0.0_wp, y, s, info)
         call baseline%sample(0.0_wp, y, other, info)
         call check_below(failure, maxval(abs(s%lambda - other%lambda)), 1.0e-11_wp, name//': multipliers')
      end subroutine compare

   end subroutine udwadia_kalaba_is_baseline

   !> At {0.6, -0.8} the horizontal variables are independent, and the vertical ones dummies.
   subroutine dummy_independent(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      class(constrained_ode_t), allocatable :: ode
      type(error_t), allocatable :: error
      real(wp) :: dydt(4), other(4), y(4)
      integer :: info

      call new_pendulum(model, 1.0_wp, 1.0_wp, g, 1, error)
      call new_constrained_ode(ode, model, method_t(name='dummy-derivatives'), error)
      y = [0.6_wp, -0.8_wp, 0.8_wp, 0.6_wp]
      call ode%rhs(0.0_wp, y, dydt, info)
      call ode%rhs(0.0_wp, y + [0.0_wp, 0.05_wp, 0.0_wp, 0.3_wp], other, info)
      call check_below(failure, maxval(abs(other - dydt)), 1.0e-11_wp, 'dummies')
      call ode%rhs(0.0_wp, y + [0.05_wp, 0.0_wp, 0.0_wp, 0.0_wp], other, info)
      call check(failure, maxval(abs(other - dydt)) > 0.05_wp, 'the horizontal position')
      call ode%rhs(0.0_wp, y + [0.0_wp, 0.0_wp, 0.3_wp, 0.0_wp], other, info)
      call check(failure, maxval(abs(other - dydt)) > 0.1_wp, 'the horizontal velocity')
   end subroutine dummy_independent

   subroutine dummy_switches(failure)
      character(:), allocatable, intent(inout) :: failure
      type(swung_t) :: swung
      real(wp) :: angle, period, rate

      call pendulum_motion(0.0_wp, 1.0_wp, g, right_angle, angle, rate, period)
      call swing(method_t(name='dummy-derivatives'), period, swung, failure, rtol=1.0e-9_wp)
      call check(failure, index(swung%remark, 'switched 4 times') > 0, 'twice down and twice up again: '//swung%remark)
      call check_below(failure, max(swung%levels%phi, swung%levels%phidot), 1.0e-12_wp, 'positions and velocities')
      call check_below(failure, swung%levels%phiddot, 1.0e-11_wp, 'accelerations')
      call check_below(failure, swung%levels%motion, 1.0e-7_wp, 'motion')
      call check_below(failure, swung%levels%tension, 1.0e-6_wp, 'tension')
      call cranks('dummy-derivatives', method_t(name='dummy-derivatives'), failure)
   end subroutine dummy_switches

   pure subroutine wrong_second_derivative(self, at, value)
      class(no_derivative_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(:) = 1.0e3_wp
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine wrong_second_derivative

   !> With a b'' that is wrong, these methods do not care, and another does.
   subroutine no_second_derivative(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=24), parameter :: names(2) = [character(len=24) :: 'gear-gupta-leimkuhler', 'fuhrer-leimkuhler']
      type(no_derivative_t) :: model
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp) :: angle, period, rate
      integer :: i

      options%step_control = 'fixed'
      options%first_step = 1.0e-3_wp
      call pendulum_motion(1.0_wp, 1.0_wp, g, right_angle, angle, rate, period)
      do i = 1, size(names)
         call new_pendulum(model%pendulum_t, 1.0_wp, 1.0_wp, g, 1, error)
         at%x = [1.0_wp, 0.0_wp]
         at%v = [0.0_wp, 0.0_wp]
         call simulate(model, at, 1.0_wp, result, error, method_t(name=names(i)), options, look=.false.)
         call no_error(failure, error)
         call check(failure, maxval(abs(at%x - [sin(angle), -cos(angle)])) < 1.0e-4_wp .eqv. i == 1, trim(names(i))//': motion')
      end do
   end subroutine no_second_derivative

   !> What is met is met to round-off at every step; what is not shows.
   subroutine stabilized_levels(failure)
      character(:), allocatable, intent(inout) :: failure
      type(swung_t) :: swung

      call swing(method_t(name='gear-gupta-leimkuhler'), 5.0_wp, swung, failure, rtol=1.0e-6_wp)
      call check_below(failure, max(swung%levels%phi, swung%levels%phidot), 2.0e-12_wp, 'two levels: positions and velocities')
      call check(failure, swung%levels%phiddot > 1.0e-6_wp, 'two levels: accelerations are not met')
      call cranks('gear-gupta-leimkuhler', method_t(name='gear-gupta-leimkuhler'), failure)
      call swing(method_t(name='fuhrer-leimkuhler'), 5.0_wp, swung, failure, rtol=1.0e-9_wp)
      call check_below(failure, max(swung%levels%phi, swung%levels%phidot), 2.0e-12_wp, 'three levels: positions and velocities')
      call check_below(failure, swung%levels%phiddot, 1.0e-11_wp, 'three levels: accelerations')
      call check_below(failure, swung%levels%motion, 1.0e-6_wp, 'three levels: motion')
      call check_below(failure, swung%levels%tension, 1.0e-5_wp, 'three levels: tension')
      call cranks('fuhrer-leimkuhler', method_t(name='fuhrer-leimkuhler'), failure)
   end subroutine stabilized_levels

   !> At {0.6, -0.8}: what an impulse along the rod adds to v* moves nothing but turns with the rod; what is along the circle does.
   subroutine embedded_impulse(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      class(constrained_ode_t), allocatable :: ode
      type(sample_t) :: s
      type(error_t), allocatable :: error
      real(wp), parameter :: rod(2) = [0.6_wp, -0.8_wp], v(2) = [0.8_wp, 0.6_wp], impulse = 2.5_wp, since = 0.5_wp
      real(wp) :: dydt(7), y(7)
      integer :: info

      call new_pendulum(model, 1.0_wp, 1.0_wp, g, 1, error)
      call new_constrained_ode(ode, model, method_t(name='embedded-projection'), error)
      y = [rod, v, impulse*rod, since]
      call ode%rhs(0.0_wp, y, dydt, info)
      call check_below(failure, maxval(abs(dydt(1:2) - v)), 1.0e-14_wp, 'v is v* without the impulse')
      ! The rod turns with v: so does the impulse along it.
      call check_below(failure, maxval(abs(dydt(3:4) - ([0.0_wp, -g] + impulse*v))), 1.0e-7_wp, 'the impulse turns')
      y = [rod, v + impulse*rod, 0.0_wp, 0.0_wp, since]
      call ode%rhs(0.0_wp, y, dydt, info)
      call check_below(failure, maxval(abs(dydt(1:2) - v)), 1.0e-14_wp, 'the sum counts')
      call ode%sample(0.0_wp, y, s, info)
      call check_close(failure, s%lambda(1), impulse/since, 1.0e-13_wp, 'the reaction is its impulse over its time')
      y(3:4) = y(3:4) + 0.3_wp*v
      call ode%rhs(0.0_wp, y, dydt, info)
      call check_below(failure, maxval(abs(dydt(1:2) - 1.3_wp*v)), 1.0e-14_wp, 'along the circle')
   end subroutine embedded_impulse

   !> Positions and velocities to round-off, accelerations and multipliers to first order of the step, whatever b'' is.
   subroutine embedded_levels(failure)
      character(:), allocatable, intent(inout) :: failure
      type(swung_t) :: coarse, fine
      type(no_derivative_t) :: model
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp) :: angle, period, rate

      call swing(method_t(name='embedded-projection'), 5.0_wp, coarse, failure, rtol=1.0e-9_wp)
      call check_below(failure, max(coarse%levels%phi, coarse%levels%phidot), 2.0e-12_wp, 'positions and velocities')
      call check_below(failure, coarse%levels%motion, 1.0e-6_wp, 'motion')
      call check(failure, coarse%levels%phiddot > 1.0e-3_wp, 'accelerations are not met')
      call swing(method_t(name='embedded-projection'), 1.0_wp, coarse, failure, step=1.0_wp/256.0_wp)
      call swing(method_t(name='embedded-projection'), 1.0_wp, fine, failure, step=1.0_wp/512.0_wp)
      call check_close(failure, coarse%levels%tension/fine%levels%tension, 2.0_wp, 0.02_wp, 'multipliers: first order')
      call cranks('embedded-projection', method_t(name='embedded-projection'), failure)

      call pendulum_motion(1.0_wp, 1.0_wp, g, right_angle, angle, rate, period)
      call new_pendulum(model%pendulum_t, 1.0_wp, 1.0_wp, g, 1, error)
      at%x = [1.0_wp, 0.0_wp]
      at%v = [0.0_wp, 0.0_wp]
      options%rtol = 1.0e-9_wp
      options%atol = 1.0e-9_wp
      call simulate(model, at, 1.0_wp, result, error, method_t(name='embedded-projection'), options, look=.false.)
      call no_error(failure, error)
      call check_below(failure, maxval(abs(at%x - [sin(angle), -cos(angle)])), 1.0e-7_wp, 'motion with a b'''' that is wrong')
   end subroutine embedded_levels

   !> On a straight wire without forces the velocity stays, and nothing is lateral.
   subroutine embedded_mass(failure)
      character(:), allocatable, intent(inout) :: failure
      type(polar_t) :: model
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp) :: off(2)
      integer :: i

      call model%define(n=2, c=1, mass_blocks=[1, 1])
      options%step_control = 'fixed'
      do i = 1, 2
         options%first_step = 0.1_wp/i
         at%t = 0.0_wp
         at%x = [1.0_wp, 0.0_wp]
         at%v = [0.0_wp, 1.5_wp]
         call simulate(model, at, 2.0_wp, result, error, method_t(name='embedded-projection'), options)
         call no_error(failure, error)
         off(i) = abs(at%x(1)*sin(at%x(2)) - 3.0_wp)
      end do
      call check_below(failure, off(2), 1.0e-5_wp, 'motion')
      call check_close(failure, log(off(1)/off(2))/log(2.0_wp), 5.0_wp, 0.7_wp, 'order')
   end subroutine embedded_mass

   subroutine polar_mass(self, at, m)
      class(polar_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m

      call m%set_diagonal(2.0_wp*[1.0_wp, at%x(1)**2])
      associate (unused => self)
      end associate
   end subroutine polar_mass

   subroutine polar_force(self, at, value)
      class(polar_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(:) = 2.0_wp*at%x(1)*at%v(2)*[at%v(2), -2.0_wp*at%v(1)]
      associate (unused => self)
      end associate
   end subroutine polar_force

   subroutine polar_constraint(self, at, value)
      class(polar_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(:) = at%x(1)*cos(at%x(2)) - 1.0_wp
      associate (unused => self)
      end associate
   end subroutine polar_constraint

   subroutine polar_jacobian(self, at, a)
      class(polar_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)

      a(1, :) = [cos(at%x(2)), -at%x(1)*sin(at%x(2))]
      associate (unused => self)
      end associate
   end subroutine polar_jacobian

   subroutine polar_second_derivative(self, at, value)
      class(polar_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(:) = at%v(2)*(2.0_wp*sin(at%x(2))*at%v(1) + at%x(1)*cos(at%x(2))*at%v(2))
      associate (unused => self)
      end associate
   end subroutine polar_second_derivative

   !> What is looked up inside a step leaves no trace in the next one.
   subroutine output_changes_nothing(failure)
      character(:), allocatable, intent(inout) :: failure
      type(method_t) :: method
      type(swung_t) :: every, some
      integer :: i

      do i = 1, size(method_names)
         method = method_t(name=method_names(i), stiffness=1.0e4_wp)
         call swing(method, 2.0_wp, every, failure, rtol=1.0e-4_wp)
         call swing(method, 2.0_wp, some, failure, rtol=1.0e-4_wp, output_dt=0.01_wp)
         call check(failure, every%result%steps == some%result%steps .and. every%result%rejected == some%result%rejected, &
                    trim(method%name)//': steps')
      end do
   end subroutine output_changes_nothing

   subroutine too_large(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=24), parameter :: names(5) = [character(len=24) :: 'minimal-coordinates', 'bayo-penalty', &
                                                  'augmented-lagrangian', 'udwadia-kalaba', 'dummy-derivatives']
      class(constrained_ode_t), allocatable :: ode
      type(error_t), allocatable :: error
      integer :: i

      do i = 1, size(names)
         call new_constrained_ode(ode, new_coupler(2001), method_t(name=names(i)), error)
         call check(failure, allocated(error), trim(names(i))//': 2001 constraints are refused')
         if (allocated(error)) call check(failure, index(error%line(), '2001 constraints') > 0, error%line())
         if (allocated(error)) deallocate (error)
      end do
   end subroutine too_large

end module test_methods
