!> The balance of energy: what is worked by loads, dampers and drives is what the energy gains.
module test_balance
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut, only: archive_t, block_diagonal_t, constrained_ode_t, energy_balance_t, error_t, integration_options_t, &
                   integration_result_t, mechanical_system_t, method_t, observer_t, ode_system_t, pause_t, sample_t, simulate, &
                   simulation_t, state_t, wp
   use testing, only: check, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_balance

   real(wp), parameter :: mass_1 = 2.0_wp, mass_2 = 3.0_wp, stiffness = 50.0_wp, damping = 0.7_wp, load = 4.0_wp, omega = 3.0_wp, &
                          fast = 100.0_wp

   !> Two bodies on a line, the first on a spring with a damper and under a load, the second at a distance that a drive enlarges.
   type, extends(mechanical_system_t) :: bare_t
   contains
      procedure :: mass
      procedure :: force
      procedure :: constraint
      procedure :: jacobian
      procedure :: velocity_rhs
      procedure :: acceleration_rhs
      procedure :: energy
   end type bare_t

   !> The same, which states its power.
   type, extends(bare_t) :: pair_t
      !> Whether the power of the damper is forgotten.
      logical :: forgets_damper = .false.
   contains
      procedure :: power
   end type pair_t

   !> The same, the first body moved fast: nothing is free.
   type, extends(pair_t) :: given_t
      !> How fast the first body begins [m/s].
      real(wp) :: speed = 0.5_wp
   contains
      procedure :: constraint => given_positions
      procedure :: jacobian => given_jacobian
      procedure :: velocity_rhs => given_rates
      procedure :: acceleration_rhs => given_accelerations
   end type given_t

   !> Notes by how much energy and work differ at the points that it sees.
   type, extends(observer_t) :: watcher_t
      type(energy_balance_t) :: balance = energy_balance_t()
      type(sample_t) :: sample = sample_t()
      real(wp) :: worst = 0.0_wp
   contains
      procedure :: observe
   end type watcher_t

   !> Pauses once.
   type, extends(pause_t) :: once_t
      integer :: asked = 0
   contains
      procedure :: wanted
   end type once_t

contains

   !> All tests of this module.
   function collect_balance() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('work of loads, dampers and drives, with every integrator', integrators), &
               new_test('work with every method', methods), &
               new_test('work of a motion that is all given', given), &
               new_test('what is held stands still in few steps', held), &
               new_test('a system that states no power is not balanced', unstated), &
               new_test('a damper that is forgotten is noticed', forgotten), &
               new_test('steps do not depend on the balance', same_steps), &
               new_test('work goes through a pause bit for bit', paused)]
   end function collect_balance

   subroutine mass(self, at, m)
      class(bare_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m

      call m%set_diagonal([mass_1, mass_2])
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine mass

   subroutine force(self, at, value)
      class(bare_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(1) = -stiffness*at%x(1) - damping*at%v(1) + load*cos(omega*at%t)
      value(2) = 0.0_wp
      associate (unused_system => self)
      end associate
   end subroutine force

   subroutine constraint(self, at, value)
      class(bare_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(1) = at%x(2) - at%x(1) - 1.0_wp - 0.2_wp*at%t**3
      associate (unused_system => self)
      end associate
   end subroutine constraint

   subroutine jacobian(self, at, a)
      class(bare_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)

      a(1, :) = [-1.0_wp, 1.0_wp]
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine jacobian

   subroutine velocity_rhs(self, at, value)
      class(bare_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(1) = 0.6_wp*at%t**2
      associate (unused_system => self)
      end associate
   end subroutine velocity_rhs

   subroutine acceleration_rhs(self, at, value)
      class(bare_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(1) = 1.2_wp*at%t
      associate (unused_system => self)
      end associate
   end subroutine acceleration_rhs

   function energy(self, at)
      class(bare_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp) :: energy

      energy = 0.5_wp*(mass_1*at%v(1)**2 + mass_2*at%v(2)**2 + stiffness*at%x(1)**2)
      associate (unused_system => self)
      end associate
   end function energy

   function power(self, at)
      class(pair_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp) :: power

      power = load*cos(omega*at%t)*at%v(1)
      if (.not. self%forgets_damper) power = power - damping*at%v(1)**2
   end function power

   subroutine given_positions(self, at, value)
      class(given_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      call self%pair_t%constraint(at, value(:1))
      value(2) = at%x(1) - 0.1_wp - self%speed/fast*sin(fast*at%t)
   end subroutine given_positions

   subroutine given_jacobian(self, at, a)
      class(given_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)

      call self%pair_t%jacobian(at, a(:1, :))
      a(2, :) = [1.0_wp, 0.0_wp]
   end subroutine given_jacobian

   subroutine given_rates(self, at, value)
      class(given_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      call self%pair_t%velocity_rhs(at, value(:1))
      value(2) = self%speed*cos(fast*at%t)
   end subroutine given_rates

   subroutine given_accelerations(self, at, value)
      class(given_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      call self%pair_t%acceleration_rhs(at, value(:1))
      value(2) = -self%speed*fast*sin(fast*at%t)
   end subroutine given_accelerations

   subroutine observe(self, ode, t, h, y, error)
      class(watcher_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t, h
      real(wp), intent(in), contiguous :: y(:)
      type(error_t), allocatable, intent(inout) :: error
      integer :: info

      select type (ode)
      class is (constrained_ode_t)
         call ode%sample(t, y, self%sample, info)
         call self%balance%see(ode, self%sample)
         if (ode%has_integral) self%worst = max(self%worst, abs(self%balance%off()))
      end select
      associate (unused_step => h, unused_error => error)
      end associate
   end subroutine observe

   logical function wanted(self)
      class(once_t), intent(inout) :: self

      self%asked = self%asked + 1
      wanted = self%asked == 5
   end function wanted

   function start() result(at)
      type(state_t) :: at

      at%x = [0.1_wp, 1.1_wp]
      at%v = [0.5_wp, 0.5_wp]
   end function start

   function bare() result(system)
      type(bare_t) :: system

      call system%define(n=2, c=1, mass_blocks=[1, 1], constant_mass=.true.)
   end function bare

   function pair() result(system)
      type(pair_t) :: system

      call system%define(n=2, c=1, mass_blocks=[1, 1], constant_mass=.true.)
   end function pair

   subroutine integrators(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=17), parameter :: names(4) = [character(len=17) :: 'dopri5', 'dop853', 'radau', 'generalized-alpha']
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(watcher_t) :: watcher
      type(state_t) :: at
      type(error_t), allocatable :: error
      character(:), allocatable :: text
      integer :: i

      do i = 1, size(names)
         options = integration_options_t(integrator=names(i), rtol=1.0e-8_wp, atol=1.0e-10_wp, output_dt=0.013_wp)
         watcher = watcher_t()
         at = start()
         call simulate(pair(), at, 2.0_wp, result, error, options=options, observer=watcher)
         call no_error(failure, error)
         call check(failure, watcher%balance%drift > 5.0_wp, trim(names(i))//': work is done')
         call check(failure, watcher%worst < merge(1.0e-4_wp, 1.0e-6_wp, i == 4), &
                    trim(names(i))//': at every point it is what the energy gains')
         call watcher%balance%remark(options, result, 0.0_wp, text)
         call check(failure, text == '', trim(names(i))//': nothing to remark')
      end do
   end subroutine integrators

   subroutine given(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=17), parameter :: names(3) = [character(len=17) :: 'dopri5', 'dop853', 'radau']
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(given_t) :: system
      type(watcher_t) :: watcher
      type(state_t) :: at
      type(error_t), allocatable :: error
      integer :: i

      call system%define(n=2, c=2, mass_blocks=[1, 1], constant_mass=.true.)
      do i = 1, size(names)
         options = integration_options_t(integrator=names(i), rtol=1.0e-6_wp, atol=1.0e-9_wp)
         watcher = watcher_t()
         at = start()
         call simulate(system, at, 1.0_wp, result, error, options=options, observer=watcher)
         call no_error(failure, error)
         ! Of some 60 J that go to and fro.
         call check_close(failure, watcher%balance%off(), 0.0_wp, 5.0e-5_wp, trim(names(i))//': work is what the energy gains')
      end do
   end subroutine given

   subroutine held(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_result_t) :: result
      type(given_t) :: system
      type(state_t) :: at
      type(error_t), allocatable :: error

      ! Velocities that are round-off, so that work is.
      call system%define(n=2, c=2, mass_blocks=[1, 1], constant_mass=.true.)
      system%speed = 1.0e-17_wp
      at = start()
      at%v(:) = 0.0_wp
      call simulate(system, at, 1.0_wp, result, error)
      call no_error(failure, error)
      call check(failure, result%steps < 100, 'few steps')
   end subroutine held

   subroutine methods(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=21), parameter :: names(7) = [character(len=21) :: 'present', 'baseline', 'baumgarte', 'yu-chen', &
                                                  'coordinate-projection', 'braun-goldfarb', 'unconstrained']
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(watcher_t) :: watcher
      type(method_t) :: method
      type(state_t) :: at
      type(error_t), allocatable :: error
      integer :: i

      options = integration_options_t(rtol=1.0e-9_wp, atol=1.0e-11_wp)
      do i = 1, size(names)
         method%name = names(i)
         watcher = watcher_t()
         at = start()
         call simulate(pair(), at, 2.0_wp, result, error, method=method, options=options, observer=watcher)
         call no_error(failure, error)
         call check(failure, watcher%worst < 1.0e-7_wp, trim(names(i))//': work is what the energy gains')
      end do
      ! Constraints that are springs work too.
      method%name = 'penalty'
      method%stiffness = 1.0e3_wp
      method%damping = 1.0_wp
      watcher = watcher_t()
      at = start()
      call simulate(pair(), at, 2.0_wp, result, error, method=method, options=options, observer=watcher)
      call check(failure, watcher%worst < 1.0e-7_wp, 'penalty: work is what the energy gains')
   end subroutine methods

   subroutine unstated(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(watcher_t) :: watcher
      type(state_t) :: at
      type(error_t), allocatable :: error
      character(:), allocatable :: text

      at = start()
      call simulate(bare(), at, 0.5_wp, result, error, observer=watcher)
      call no_error(failure, error)
      call check(failure, .not. ieee_is_finite(watcher%balance%work), 'no work is told')
      call watcher%balance%remark(options, result, 0.0_wp, text)
      call check(failure, index(text, 'not balanced') > 0, 'it is told that there is none')
      call check(failure, index(text, 'integrator') > 0, 'it may be the integrator that counts none')
   end subroutine unstated

   subroutine forgotten(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pair_t) :: system
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(watcher_t) :: watcher
      type(state_t) :: at
      type(error_t), allocatable :: error
      character(:), allocatable :: text

      system = pair()
      system%forgets_damper = .true.
      at = start()
      call simulate(system, at, 2.0_wp, result, error, observer=watcher)
      call watcher%balance%remark(options, result, 0.0_wp, text)
      call check(failure, index(text, 'off by') > 0, 'the balance is off')
   end subroutine forgotten

   subroutine same_steps(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=17), parameter :: names(4) = [character(len=17) :: 'dopri5', 'dop853', 'radau', 'generalized-alpha']
      type(integration_result_t) :: result(2)
      type(state_t) :: at(2)
      type(error_t), allocatable :: error
      integer :: i

      do i = 1, size(names)
         at(1) = start()
         at(2) = start()
         call simulate(pair(), at(1), 2.0_wp, result(1), error, options=integration_options_t(integrator=names(i)))
         call simulate(bare(), at(2), 2.0_wp, result(2), error, options=integration_options_t(integrator=names(i)))
         call check(failure, result(1)%steps == result(2)%steps .and. result(1)%rhs_evaluations == result(2)%rhs_evaluations .and. &
                    all(abs(at(1)%x - at(2)%x) <= 0.0_wp), trim(names(i))//': bit for bit the same')
      end do
   end subroutine same_steps

   subroutine paused(failure)
      character(:), allocatable, intent(inout) :: failure
      type(simulation_t) :: before, behind, whole
      type(archive_t) :: archive
      type(once_t) :: once
      type(error_t), allocatable :: error

      call whole%init(pair(), error)
      call whole%run(start(), 2.0_wp, error)
      call before%init(pair(), error)
      call before%run(start(), 2.0_wp, error, pause=once)
      call archive%clear()
      call before%serialize(archive)
      call archive%rewind()
      call behind%init(pair(), error)
      call behind%serialize(archive)
      call behind%resume()
      call no_error(failure, error)
      call check(failure, abs(whole%ode%integral) > 1.0_wp, 'there is work')
      call check_close(failure, behind%ode%integral, whole%ode%integral, 0.0_wp, 'the same work')
      call check_close(failure, behind%ode%integral_error, whole%ode%integral_error, 0.0_wp, 'the same uncertainty')
   end subroutine paused

end module test_balance
