!> Forces that depend on reactions, and events that see them.
module test_reactions
   use taut, only: assignment(=), automatic_system_t, block_diagonal_t, constrained_ode_t, error_t, integration_options_t, &
                   integration_result_t, jet_state_t, jet_t, method_t, new_ritz, norm2, observer_t, ode_system_t, operator(-), &
                   ritz_t, sample_t, simulate, state_t, status_event, tabulated_system_t, wp
   use taut_error, only: to_text
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_reactions

   real(wp), parameter :: g = 9.81_wp

   !> A point mass on an inclined plane, with friction of Coulomb's law, smooth in the velocity.
   type, extends(tabulated_system_t) :: block_t
      real(wp) :: m = 2.0_wp, slope = 0.5_wp, friction = 0.3_wp, slow = 1.0e-3_wp
   contains
      procedure :: mass => block_mass
      procedure :: force => block_force
      procedure :: constraint => block_constraint
      procedure :: jacobian => block_jacobian
      procedure :: acceleration_rhs => block_acceleration_rhs
      procedure :: reaction_force => block_reaction_force
      procedure :: energy => block_energy
      procedure :: power => block_power
   end type block_t

   !> The same, its forces of reactions linear: g = B lambda, with part of it along the constraints; in space, on a line.
   type, extends(tabulated_system_t) :: coupled_t
      real(wp) :: b(3, 2) = 0.0_wp
   contains
      procedure :: mass => coupled_mass
      procedure :: force => coupled_force
      procedure :: constraint => coupled_constraint
      procedure :: jacobian => coupled_jacobian
      procedure :: acceleration_rhs => coupled_acceleration_rhs
      procedure :: reaction_force => coupled_reaction_force
   end type coupled_t

   !> A point on a circle of radius 1 about the origin, lying on it from above or tied to its center; the event is the end of the
   !! force that keeps it there.
   type, extends(tabulated_system_t) :: circle_t
      logical :: tied = .false.
   contains
      procedure :: mass => circle_mass
      procedure :: force => circle_force
      procedure :: constraint => circle_constraint
      procedure :: jacobian => circle_jacobian
      procedure :: acceleration_rhs => circle_acceleration_rhs
      procedure :: reaction_event_values => circle_event_values
   end type circle_t

   !> Keeps the work at the last point.
   type, extends(observer_t) :: last_t
      real(wp) :: work = 0.0_wp
   contains
      procedure :: observe
   end type last_t

   !> The block with a force of reactions that nobody announced, and one without that is announced.
   type, extends(circle_t) :: silent_t
   contains
      procedure :: reaction_force => silent_reaction_force
   end type silent_t

   !> A pendulum of 1 m and 1 kg that is braked by what its rod carries, as `reaction_force` or by a formula for that.
   type, extends(automatic_system_t) :: braked_t
      logical :: by_formula = .false.
   contains
      procedure :: phi => braked_phi
      procedure :: force => braked_force
      procedure :: reaction_force => braked_reaction_force
   end type braked_t

contains

   !> All tests of this module.
   function collect_reactions() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('a block slides down a rough incline', slides), &
               new_test('a block that is slow enough creeps and does not slide', creeps), &
               new_test('a pendulum is braked by what it carries, with explicit and implicit steps', braked), &
               new_test('reactions that act on themselves are consistent', consistent), &
               new_test('where friction jams it is said', jams), &
               new_test('forces of reactions are announced or refused', announced), &
               new_test('forces of reactions are reduced with their system', reduced), &
               new_test('a body leaves a sphere where nothing presses any more', leaves), &
               new_test('a rope that is slack from the start is an event there', slack)]
   end function collect_reactions

   subroutine block_mass(self, at, m)
      class(block_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m

      call m%set_diagonal(spread(self%m, 1, size(at%v)))
   end subroutine block_mass

   subroutine block_force(self, at, value)
      class(block_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = [0.0_wp*at%t, -self%m*g]
   end subroutine block_force

   subroutine block_constraint(self, at, value)
      class(block_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(1) = sin(self%slope)*at%x(1) + cos(self%slope)*at%x(2)
   end subroutine block_constraint

   subroutine block_jacobian(self, at, a)
      class(block_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)

      a(1, :) = [sin(self%slope), cos(self%slope)] + 0.0_wp*at%t
   end subroutine block_jacobian

   subroutine block_acceleration_rhs(self, at, value)
      class(block_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = 0.0_wp*at%t*self%m
   end subroutine block_acceleration_rhs

   !> Against the velocity down the slope.
   subroutine block_reaction_force(self, at, lambda, value)
      class(block_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: lambda(:)
      real(wp), intent(out) :: value(:)
      real(wp) :: along(2)

      along = [cos(self%slope), -sin(self%slope)]
      value = -self%friction*abs(lambda(1))*tanh(dot_product(along, at%v)/self%slow)*along
   end subroutine block_reaction_force

   function block_energy(self, at) result(energy)
      class(block_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp) :: energy

      energy = 0.5_wp*self%m*dot_product(at%v, at%v) + self%m*g*at%x(2)
   end function block_energy

   !> But for friction, nothing.
   function block_power(self, at) result(power)
      class(block_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp) :: power

      power = 0.0_wp*at%t*self%m
   end function block_power

   subroutine coupled_mass(self, at, m)
      class(coupled_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m

      call m%set_diagonal(spread(1.0_wp, 1, self%n) + 0.0_wp*at%t)
   end subroutine coupled_mass

   subroutine coupled_force(self, at, value)
      class(coupled_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = [1.0_wp, 2.0_wp, -g] + 0.0_wp*at%t*self%n
   end subroutine coupled_force

   subroutine coupled_constraint(self, at, value)
      class(coupled_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = at%x(2:3) + 0.0_wp*self%n
   end subroutine coupled_constraint

   subroutine coupled_jacobian(self, at, a)
      class(coupled_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)

      a = 0.0_wp*at%t*self%n
      a(1, 2) = 1.0_wp
      a(2, 3) = 1.0_wp
   end subroutine coupled_jacobian

   subroutine coupled_acceleration_rhs(self, at, value)
      class(coupled_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = 0.0_wp*at%t*self%n
   end subroutine coupled_acceleration_rhs

   subroutine coupled_reaction_force(self, at, lambda, value)
      class(coupled_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: lambda(:)
      real(wp), intent(out) :: value(:)

      value = matmul(self%b, lambda) + 0.0_wp*at%t
   end subroutine coupled_reaction_force

   subroutine circle_mass(self, at, m)
      class(circle_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m

      call m%set_diagonal(spread(1.0_wp, 1, self%n) + 0.0_wp*at%t)
   end subroutine circle_mass

   subroutine circle_force(self, at, value)
      class(circle_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = [0.0_wp*at%t*self%n, -g]
   end subroutine circle_force

   subroutine circle_constraint(self, at, value)
      class(circle_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(1) = norm2(at%x) - 1.0_wp + 0.0_wp*self%n
   end subroutine circle_constraint

   subroutine circle_jacobian(self, at, a)
      class(circle_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)

      a(1, :) = at%x/norm2(at%x) + 0.0_wp*self%n
   end subroutine circle_jacobian

   subroutine circle_acceleration_rhs(self, at, value)
      class(circle_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      real(wp) :: r

      r = norm2(at%x)
      value(1) = ((dot_product(at%x, at%v)/r)**2 - dot_product(at%v, at%v))/r + 0.0_wp*self%n
   end subroutine circle_acceleration_rhs

   !> The pull of the rope, or the pressure: the force of the constraint is -lambda outwards.
   subroutine circle_event_values(self, at, lambda, values)
      class(circle_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: lambda(:)
      real(wp), intent(out) :: values(:)

      values(1) = merge(lambda(1), -lambda(1), self%tied) + 0.0_wp*at%t
   end subroutine circle_event_values

   subroutine silent_reaction_force(self, at, lambda, value)
      class(silent_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: lambda(:)
      real(wp), intent(out) :: value(:)

      value = 0.0_wp*at%v*lambda(1)*self%n
   end subroutine silent_reaction_force

   subroutine observe(self, ode, t, h, y, error)
      class(last_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t, h
      real(wp), intent(in), contiguous :: y(:)
      type(error_t), allocatable, intent(inout) :: error
      type(sample_t) :: seen
      integer :: info

      select type (ode)
      class is (constrained_ode_t)
         call ode%sample(t, y, seen, info)
         self%work = seen%work
      end select
      associate (unused_step => h, unused_error => error)
      end associate
   end subroutine observe

   subroutine slides(failure)
      character(:), allocatable, intent(inout) :: failure
      type(block_t) :: system
      type(state_t) :: at
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      type(last_t) :: last
      real(wp) :: acceleration, down
      integer :: i, k
      character(*), parameter :: integrators(2) = [character(6) :: 'dopri5', 'radau'], forms(2) = [character(12) :: &
                                                                                                  'acceleration', 'force']
      real(wp), parameter :: v = 1.0_wp, t_end = 1.0_wp

      call system%define(n=2, c=1, mass_blocks=[1, 1], constant_mass=.true., reactive=.true.)
      acceleration = g*(sin(system%slope) - system%friction*cos(system%slope))
      do i = 1, 2
         do k = 1, 2
            at = state_t(x=[0.0_wp, 0.0_wp], v=v*[cos(system%slope), -sin(system%slope)])
            call simulate(system, at, t_end, result, error, method_t(form=forms(k)), &
                          integration_options_t(integrators(i), 1.0e-9_wp), last)
            call no_error(failure, error)
            if (allocated(failure)) return
            down = at%x(1)*cos(system%slope) - at%x(2)*sin(system%slope)
            call check_close(failure, down, v*t_end + 0.5_wp*acceleration*t_end**2, 1.0e-9_wp, integrators(i)//forms(k))
            call check_below(failure, at%x(1)*sin(system%slope) + at%x(2)*cos(system%slope), 1.0e-12_wp, 'on the plane')
            call check_close(failure, last%work, -system%friction*system%m*g*cos(system%slope)*down, 1.0e-6_wp, 'work of friction')
         end do
      end do
   end subroutine slides

   !> Where friction is stronger than the slope, the smooth law lets it creep where mu cos tanh(v/slow) = sin.
   subroutine creeps(failure)
      character(:), allocatable, intent(inout) :: failure
      type(block_t) :: system
      type(state_t) :: at
      type(integration_result_t) :: result
      type(error_t), allocatable :: error

      call system%define(n=2, c=1, mass_blocks=[1, 1], constant_mass=.true., reactive=.true.)
      system%friction = 0.8_wp
      at = state_t(x=[0.0_wp, 0.0_wp], v=[0.0_wp, 0.0_wp])
      call simulate(system, at, 1.0_wp, result, error, options=integration_options_t('radau', 1.0e-8_wp, 1.0e-12_wp))
      call no_error(failure, error)
      call check_close(failure, norm2(at%v), system%slow*atanh(tan(system%slope)/system%friction), 1.0e-9_wp, 'velocity')
   end subroutine creeps

   subroutine braked_phi(self, at, value)
      class(braked_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value(:)

      value(1) = norm2(at%x) - 1.0_wp
      associate (unused_system => self)
      end associate
   end subroutine braked_phi

   subroutine braked_force(self, at, value)
      class(braked_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = [0.0_wp, -g]
      if (self%by_formula) value = value + brake(at, dot_product(at%x, value)/norm2(at%x) + dot_product(at%v, at%v))
   end subroutine braked_force

   subroutine braked_reaction_force(self, at, lambda, value)
      class(braked_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: lambda(:)
      real(wp), intent(out) :: value(:)

      value = 0.0_wp
      if (.not. self%by_formula) value = brake(at, lambda(1))
   end subroutine braked_reaction_force

   !> Coulomb's law with a coefficient of 0.8.
   pure function brake(at, lambda) result(force)
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: lambda
      real(wp) :: force(2), forth(2)

      forth = [-at%x(2), at%x(1)]/norm2(at%x)
      force = -0.8_wp*abs(lambda)*tanh(dot_product(forth, at%v)/1.0e-3_wp)*forth
   end function brake

   !> lambda grows with the square of the velocity, and the brake with lambda; it is soft, but stiff for explicit steps.
   subroutine braked(failure)
      character(:), allocatable, intent(inout) :: failure
      type(braked_t) :: system
      type(state_t) :: at, expected
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      character(*), parameter :: integrators(2) = [character(6) :: 'dopri5', 'radau']
      integer :: i, of_formula, of_reactions

      call system%define(n=2, c=1, mass_blocks=[1, 1], reactive=.true.)
      system%diagonal_mass = [1.0_wp, 1.0_wp]
      system%by_formula = .true.
      expected = state_t(x=[1.0_wp, 0.0_wp], v=[0.0_wp, 0.0_wp])
      call simulate(system, expected, 2.0_wp, result, error, options=integration_options_t('dopri5', 1.0e-10_wp, 1.0e-11_wp))
      call no_error(failure, error)
      call iterations_of(of_formula)
      system%by_formula = .false.
      call iterations_of(of_reactions)
      if (allocated(failure)) return
      do i = 1, 2
         at = state_t(x=[1.0_wp, 0.0_wp], v=[0.0_wp, 0.0_wp])
         call simulate(system, at, 2.0_wp, result, error, options=integration_options_t(integrators(i), 1.0e-8_wp, 1.0e-9_wp))
         call no_error(failure, error)
         if (allocated(failure)) return
         call check_close(failure, maxval(abs([at%x, at%v] - [expected%x, expected%v])), 0.0_wp, 1.0e-6_wp, integrators(i))
      end do
      call check(failure, result%steps < 500 .and. result%newton_iterations < 6*result%steps, 'iterations of implicit steps')
      call check(failure, 100*of_reactions <= 105*of_formula, to_text(of_reactions)//' iterations where the formula takes '// &
                 to_text(of_formula))

   contains

      !> Newton's iterations of implicit steps.
      subroutine iterations_of(iterations)
         integer, intent(out) :: iterations

         at = state_t(x=[1.0_wp, 0.0_wp], v=[0.0_wp, 0.0_wp])
         call simulate(system, at, 2.0_wp, result, error, options=integration_options_t('radau', 1.0e-8_wp, 1.0e-9_wp))
         call no_error(failure, error)
         iterations = result%newton_iterations
      end subroutine iterations_of

   end subroutine braked

   !> (1 - A B) lambda = A f.
   subroutine consistent(failure)
      character(:), allocatable, intent(inout) :: failure
      type(coupled_t) :: system
      type(state_t) :: at
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      real(wp) :: along, lambda(2), matrix(2, 2)
      integer :: i
      character(*), parameter :: integrators(2) = [character(6) :: 'dopri5', 'radau']

      call system%define(n=3, c=2, mass_blocks=[1, 1, 1], constant_mass=.true., reactive=.true.)
      do i = 1, 2
         ! By substitution alone it would grow with each iteration.
         system%b = reshape([0.7_wp, 3.0_wp, -1.5_wp, 0.4_wp, 2.0_wp, -2.5_wp], [3, 2])
         matrix = reshape([1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [2, 2]) - system%b(2:, :)
         lambda = [matrix(2, 2)*2.0_wp + matrix(1, 2)*g, -matrix(2, 1)*2.0_wp - matrix(1, 1)*g]/ &
                  (matrix(1, 1)*matrix(2, 2) - matrix(1, 2)*matrix(2, 1))
         along = 1.0_wp + dot_product(system%b(1, :), lambda)
         at = state_t(x=[0.0_wp, 0.0_wp, 0.0_wp], v=[0.0_wp, 0.0_wp, 0.0_wp])
         call simulate(system, at, 1.0_wp, result, error, options=integration_options_t(integrators(i), 1.0e-9_wp))
         call no_error(failure, error)
         call check_close(failure, at%x(1), 0.5_wp*along, 1.0e-8_wp, integrators(i)//': acceleration')
      end do
   end subroutine consistent

   !> With A B = 1 whatever the constraint answers is taken back.
   subroutine jams(failure)
      character(:), allocatable, intent(inout) :: failure
      type(coupled_t) :: system
      type(state_t) :: at
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      character(*), parameter :: integrators(2) = [character(6) :: 'dopri5', 'radau']
      integer :: i

      call system%define(n=3, c=2, mass_blocks=[1, 1, 1], constant_mass=.true., reactive=.true.)
      system%b(3, 2) = 1.0_wp
      do i = 1, 2
         at = state_t(x=[0.0_wp, 0.0_wp, 0.0_wp], v=[0.0_wp, 0.0_wp, 0.0_wp])
         call simulate(system, at, 1.0_wp, result, error, options=integration_options_t(integrators(i)))
         call check(failure, allocated(error), 'it went on')
         if (.not. allocated(error)) return
         call check(failure, index(error%what, 'friction that jams') > 0, error%line())
         deallocate (error)
      end do
   end subroutine jams

   subroutine announced(failure)
      character(:), allocatable, intent(inout) :: failure
      type(silent_t) :: silent
      type(circle_t) :: circle
      type(state_t) :: at
      type(integration_result_t) :: result
      type(error_t), allocatable :: error

      call silent%define(n=2, c=1)
      at = state_t(x=[1.0_wp, 0.0_wp], v=[0.0_wp, 0.0_wp])
      call simulate(silent, at, 1.0_wp, result, error)
      call check(failure, allocated(error), 'a force that would not be asked was left')
      if (allocated(error)) call check(failure, index(error%remedy, 'reactive=.true.') > 0, error%line())
      if (allocated(error)) deallocate (error)
      if (allocated(error)) deallocate (error)
      call silent%define(n=2, c=1, reactive=.true.)
      call simulate(silent, at, 1.0_wp, result, error, method_t(name='minimal-coordinates'))
      call check(failure, allocated(error), 'a method without multipliers has taken it')
      if (allocated(error)) deallocate (error)
      call circle%define(n=2, c=1, reactive=.true.)
      call simulate(circle, at, 1.0_wp, result, error)
      call check(failure, allocated(error), 'a force that is missing was not missed')
      if (allocated(error)) call check(failure, index(error%what, 'no procedure reaction_force') > 0, error%line())
   end subroutine announced

   !> All motions are kept, so that nothing changes.
   subroutine reduced(failure)
      character(:), allocatable, intent(inout) :: failure
      type(block_t) :: system
      type(ritz_t) :: shapes
      type(state_t) :: at
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      real(wp) :: acceleration

      call system%define(n=2, c=1, mass_blocks=[1, 1], constant_mass=.true., reactive=.true.)
      call new_ritz(shapes, system, reshape([1.0_wp, 0.0_wp, 1.0_wp, 1.0_wp], [2, 2]), [0.0_wp, 0.0_wp], error)
      call no_error(failure, error)
      acceleration = g*(sin(system%slope) - system%friction*cos(system%slope))
      ! x = X q: down the slope it is q = {cos + sin; -sin}.
      at = state_t(x=[0.0_wp, 0.0_wp], v=[cos(system%slope) + sin(system%slope), -sin(system%slope)])
      call simulate(shapes, at, 1.0_wp, result, error, options=integration_options_t(rtol=1.0e-9_wp))
      call no_error(failure, error)
      if (allocated(failure)) return
      call check_close(failure, -at%x(2)/sin(system%slope), 1.0_wp + 0.5_wp*acceleration, 1.0e-8_wp, 'way')
   end subroutine reduced

   !> From rest at the top but for a push v: at cos = 2/3 + v^2/(3 g).
   subroutine leaves(failure)
      character(:), allocatable, intent(inout) :: failure
      type(circle_t) :: system
      type(state_t) :: at
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      real(wp), parameter :: v = 0.5_wp

      call system%define(n=2, c=1, constant_mass=.true.)
      system%n_events = 1
      system%events_see_reactions = .true.
      system%event_direction = [-1]
      system%event_terminal = [.true.]
      system%event_from_start = [.true.]
      at = state_t(x=[0.0_wp, 1.0_wp], v=[v, 0.0_wp])
      call simulate(system, at, 10.0_wp, result, error, options=integration_options_t(rtol=1.0e-10_wp))
      call no_error(failure, error)
      call check(failure, result%status == status_event, 'it does not leave')
      call check_close(failure, at%x(2), 2.0_wp/3.0_wp + v**2/(3.0_wp*g), 1.0e-8_wp, 'where')
      call check_close(failure, dot_product(at%v, at%v), v**2 + 2.0_wp*g*(1.0_wp - at%x(2)), 1.0e-8_wp, 'how fast')
   end subroutine leaves

   subroutine slack(failure)
      character(:), allocatable, intent(inout) :: failure
      type(circle_t) :: system
      type(state_t) :: at
      type(integration_result_t) :: result
      type(error_t), allocatable :: error

      call system%define(n=2, c=1, constant_mass=.true.)
      system%tied = .true.
      system%n_events = 1
      system%events_see_reactions = .true.
      system%event_direction = [-1]
      system%event_terminal = [.true.]
      ! At rest above its center: the rope would have to push.
      at = state_t(t=3.0_wp, x=[0.6_wp, 0.8_wp], v=[0.0_wp, 0.0_wp])
      call simulate(system, at, 3.1_wp, result, error)
      call check(failure, size(result%events) == 0, 'a sign that does not change is no event')
      system%event_from_start = [.true.]
      at = state_t(t=3.0_wp, x=[0.6_wp, 0.8_wp], v=[0.0_wp, 0.0_wp])
      call simulate(system, at, 4.0_wp, result, error)
      call no_error(failure, error)
      call check(failure, result%status == status_event .and. size(result%events) == 1 .and. result%steps == 0, 'at the start')
      call check_below(failure, at%t - 3.0_wp, 0.0_wp, 'time')
      ! With all of its pull used up, at the side: slack as soon as it moves.
      at = state_t(t=3.0_wp, x=[1.0_wp, 0.0_wp], v=[0.0_wp, 0.0_wp])
      call simulate(system, at, 3.1_wp, result, error)
      call check(failure, size(result%events) == 0, 'falling pulls')
   end subroutine slack

end module test_reactions
