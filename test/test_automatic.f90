!> Systems without derivatives: what follows from phi, potentials and masses against what was written by hand.
module test_automatic
   use automatic_systems, only: borrowed_t, without_derivatives
   use car_axis, only: car_axis_start, end_of_axle, new_car_axis
   use squeezer, only: new_squeezer, squeezer_start
   use systems, only: new_particle, sleigh
   use taut, only: automatic_system_t, block_diagonal_t, error_t, finding_t, integration_options_t, integration_result_t, &
                   jet_state_t, mechanical_system_t, new_rigid_bodies, posed_system_t, quaternion_of_vector, rigid_bodies_t, &
                   rigid_body_t, simulate, spherical_joint_t, state_t, status_reached_end, verify, wp
   use taut_jet
   use taut_model_chain, only: chain_t, new_chain
   use taut_model_helicopter, only: helicopter_data_t, helicopter_t, new_helicopter
   use taut_model_n_four_bar, only: n_four_bar_t, new_n_four_bar
   use taut_model_pendulum, only: new_pendulum, pendulum_t
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_automatic

   !> Two rods on spherical joints.
   type, extends(posed_system_t) :: rods_t
      type(rigid_bodies_t) :: hand
   contains
      procedure :: mass => rods_mass
      procedure :: force => rods_force
      procedure :: phi => rods_phi
   end type rods_t

   !> A knife edge that is like `sleigh` of the systems by hand, or with a row that is not linear.
   type, extends(automatic_system_t) :: edge_t
      class(mechanical_system_t), allocatable :: hand
      logical :: linear = .true.
   contains
      procedure :: mass => edge_mass
      procedure :: force => edge_force
      procedure :: nonholonomic => edge_row
   end type edge_t

   !> A double pendulum in the angles of its rods to the vertical, and what may be wrong with it.
   type, extends(automatic_system_t) :: angles_t
      logical :: turned = .false.
   contains
      procedure :: masses => angles_masses
      procedure :: potential => angles_potential
      procedure :: kinematics => angles_kinematics
   end type angles_t

   !> Nothing but sizes and masses.
   type, extends(automatic_system_t) :: empty_t
   contains
      procedure :: masses => empty_masses
   end type empty_t

contains

   !> All tests of this module.
   function collect_automatic() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('derivatives are those written by hand', derivatives), &
               new_test('trajectories are the same', trajectories), &
               new_test('the car axis as published', published), &
               new_test('quaternions', quaternions), &
               new_test('a row that is not holonomic', not_holonomic), &
               new_test('a double pendulum from energies', energies), &
               new_test('the pattern of a long chain', long_chain), &
               new_test('what is wrong has a name', faults)]
   end function collect_automatic

   !> Any state near a given one.
   function shaken(at) result(near)
      type(state_t), intent(in) :: at
      type(state_t) :: near
      integer :: i

      near = at
      near%t = at%t + 0.1_wp
      near%x = at%x + [(0.05_wp*sin(3.0_wp*i), i=1, size(at%x))]
      near%v = at%v + [(0.7_wp*cos(2.0_wp*i), i=1, size(at%v))]
   end function shaken

   !> A, b' and b'' of two systems.
   subroutine compare(failure, name, hand, model, at)
      character(:), allocatable, intent(inout) :: failure
      character(*), intent(in) :: name
      class(mechanical_system_t), intent(in) :: hand, model
      type(state_t), intent(in) :: at
      real(wp), allocatable :: a(:, :), a_hand(:, :), b(:), b_hand(:)

      allocate (a(hand%c, hand%n), a_hand(hand%c, hand%n), b(hand%c), b_hand(hand%c), source=7.0_wp)
      call hand%constraint(at, b_hand(:hand%n_phi))
      call model%constraint(at, b(:hand%n_phi))
      call check_below(failure, maxval(abs(b - b_hand)), 1.0e-14_wp, name//': phi')
      call hand%jacobian(at, a_hand)
      call model%jacobian(at, a)
      call check_below(failure, maxval(abs(a - a_hand)), 1.0e-13_wp*maxval(abs(a_hand)), name//': A')
      call hand%velocity_rhs(at, b_hand)
      call model%velocity_rhs(at, b)
      call check_below(failure, maxval(abs(b - b_hand)), 1.0e-13_wp*(1.0_wp + maxval(abs(b_hand))), name//': b''')
      call hand%acceleration_rhs(at, b_hand)
      call model%acceleration_rhs(at, b)
      call check_below(failure, maxval(abs(b - b_hand)), 1.0e-12_wp*(1.0_wp + maxval(abs(b_hand))), name//': b''''')
   end subroutine compare

   !> Does something with each system, and its start.
   subroutine with_each(failure, act)
      character(:), allocatable, intent(inout) :: failure
      interface
         subroutine act(failure, name, hand, at, t_end)
            import :: mechanical_system_t, state_t, wp
            implicit none (type, external)
            character(:), allocatable, intent(inout) :: failure
            character(*), intent(in) :: name
            class(mechanical_system_t), intent(in) :: hand
            type(state_t), intent(in) :: at
            real(wp), intent(in) :: t_end
         end subroutine act
      end interface
      type(pendulum_t) :: pendulum
      type(chain_t) :: chain
      type(n_four_bar_t) :: four_bar
      type(helicopter_t) :: blade
      type(helicopter_data_t) :: data
      type(error_t), allocatable :: error
      type(state_t) :: at

      call new_pendulum(pendulum, 1.0_wp, 1.0_wp, 9.81_wp, 2, error)
      at%x = [1.0_wp, 0.0_wp]
      at%v = [0.0_wp, 0.0_wp]
      allocate (at%w(0))
      call act(failure, 'pendulum', pendulum, at, 2.0_wp)
      data%b_cosine = [0.0_wp, 0.0_wp, 0.01_wp]
      call new_helicopter(blade, data, error)
      at%x = [0.0_wp, 0.0_wp]
      call act(failure, 'helicopter', blade, at, 0.1_wp)
      call new_chain(chain, 9, 1.0_wp, 1.0_wp, 9.81_wp, error)
      call chain%start(0.3_wp, at)
      call act(failure, 'chain', chain, at, 0.5_wp)
      call new_n_four_bar(four_bar, 3, 1.0_wp, 1.0_wp, 9.81_wp, error)
      call four_bar%start(0.0_wp, 1.0_wp, at)
      call act(failure, 'four-bar', four_bar, at, 0.5_wp)
      call act(failure, 'squeezer', new_squeezer(), squeezer_start(), 0.01_wp)
      call act(failure, 'car axis', new_car_axis(), car_axis_start(), 0.5_wp)
      call no_error(failure, error)
   end subroutine with_each

   subroutine derivatives(failure)
      character(:), allocatable, intent(inout) :: failure

      call with_each(failure, compare_derivatives)
   end subroutine derivatives

   subroutine compare_derivatives(failure, name, hand, at, t_end)
      character(:), allocatable, intent(inout) :: failure
      character(*), intent(in) :: name
      class(mechanical_system_t), intent(in) :: hand
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: t_end
      class(borrowed_t), allocatable :: model

      model = without_derivatives(hand)
      call compare(failure, name, hand, model, shaken(at))
      call model%find_structure(at)
      call compare(failure, name//' of known structure', hand, model, shaken(at))
      associate (unused_time => t_end)
      end associate
   end subroutine compare_derivatives

   subroutine trajectories(failure)
      character(:), allocatable, intent(inout) :: failure

      call with_each(failure, compare_trajectories)
   end subroutine trajectories

   subroutine compare_trajectories(failure, name, hand, at, t_end)
      character(:), allocatable, intent(inout) :: failure
      character(*), intent(in) :: name
      class(mechanical_system_t), intent(in) :: hand
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: t_end
      class(borrowed_t), allocatable :: model
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(state_t) :: one, other
      type(error_t), allocatable :: error

      options%rtol = 1.0e-9_wp
      options%atol = 1.0e-9_wp
      one = at
      call simulate(hand, one, t_end, result, error, options=options)
      call no_error(failure, error)
      model = without_derivatives(hand)
      call model%find_structure(at)
      other = at
      call simulate(model, other, t_end, result, error, options=options)
      call no_error(failure, error)
      call check(failure, result%status == status_reached_end, name//': the end')
      call check_below(failure, maxval(abs(one%x - other%x)), 1.0e-9_wp*maxval(abs(one%x)), name//': x')
      call check_below(failure, maxval(abs(one%v - other%v)), 1.0e-9_wp*(1.0_wp + maxval(abs(one%v))), name//': v')
   end subroutine compare_trajectories

   subroutine published(failure)
      character(:), allocatable, intent(inout) :: failure
      class(borrowed_t), allocatable :: model
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error

      options%rtol = 1.0e-10_wp
      options%atol = 1.0e-10_wp
      model = without_derivatives(new_car_axis())
      at = car_axis_start()
      call simulate(model, at, 3.0_wp, result, error, options=options)
      call no_error(failure, error)
      call check_below(failure, maxval(abs([at%x, at%v] - end_of_axle)), 1.0e-7_wp, 'the end')
   end subroutine published

   subroutine quaternions(failure)
      character(:), allocatable, intent(inout) :: failure
      type(rods_t) :: model
      type(rigid_body_t) :: body
      type(state_t) :: at
      type(finding_t), allocatable :: findings(:)
      type(error_t), allocatable :: error
      real(wp) :: direct(14), jets(14)
      type(jet_t) :: rate(14)
      type(jet_state_t) :: there
      type(jet_t), target :: x(14), v(12)
      integer :: i

      body%m = 1.5_wp
      body%s = [0.0_wp, 0.1_wp, 0.6_wp]
      do i = 1, 3
         body%j(i, i) = 0.5_wp + 0.1_wp*i
      end do
      call new_rigid_bodies(model%hand, [body, body], &
                            [spherical_joint_t(1, 0, [0.1_wp, 0.2_wp, 0.3_wp], [0.0_wp, 0.1_wp, 0.0_wp]), &
                             spherical_joint_t(2, 1, [0.1_wp, -0.2_wp, 0.3_wp], [0.4_wp, 0.1_wp, 0.0_wp])], &
                            [0.1_wp, 0.2_wp, -9.81_wp], error)
      call no_error(failure, error)
      model%poses = 2
      call model%define(n=12, c=6, n_x=14, mass_blocks=[6, 6], constant_mass=.false.)
      allocate (at%w(0))
      at%x = [0.3_wp, 0.2_wp, -0.4_wp, quaternion_of_vector([0.5_wp, -0.7_wp, 0.3_wp]), &
              0.1_wp, 0.6_wp, -0.9_wp, quaternion_of_vector([-0.2_wp, 1.7_wp, 0.9_wp])]
      at%v = [(cos(1.7_wp*i), i=1, 12)]
      call compare(failure, 'rods', model%hand, model, at)
      call model%find_structure(at)
      call compare(failure, 'rods of known structure', model%hand, model, at)
      call model%x_rate(at, at%v, direct)
      x = jet(at%x)
      v = jet(at%v)
      there%x => x
      there%v => v
      call model%kinematics(there, rate)
      jets = rate%v
      call check_below(failure, maxval(abs(direct - jets)), 1.0e-15_wp, 'H')
      call verify(model, at, findings, error)
      call no_error(failure, error)
      if (size(findings) > 0) call check(failure, .false., findings(1)%message)
   end subroutine quaternions

   subroutine not_holonomic(failure)
      character(:), allocatable, intent(inout) :: failure
      type(edge_t) :: model
      type(state_t) :: at
      type(integration_result_t) :: result
      type(error_t), allocatable :: error

      model%hand = new_particle(sleigh)
      call model%define(n=3, c=1, nonholonomic=1, mass_blocks=model%hand%mass_blocks)
      at%x = [0.3_wp, -0.2_wp, 0.4_wp]
      at%v = [0.5_wp, 0.7_wp, -1.3_wp]
      allocate (at%w(0))
      call compare(failure, 'sleigh', model%hand, model, at)
      call model%find_structure(at)
      call compare(failure, 'sleigh of known structure', model%hand, model, at)
      model%linear = .false.
      call simulate(model, at, 1.0_wp, result, error)
      call check(failure, allocated(error), 'a row that is not linear')
      if (allocated(error)) &
         call check(failure, index(error%line(), 'constraint 1 is not linear in the velocities') > 0, error%line())
   end subroutine not_holonomic

   !> f and M against the equations of motion of textbooks, and the energy along a motion.
   subroutine energies(failure)
      character(:), allocatable, intent(inout) :: failure
      type(angles_t) :: model
      type(state_t) :: at
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      real(wp) :: f(2), start

      call model%define(n=2, c=0)
      at%x = [1.2_wp, -0.4_wp]
      at%v = [0.9_wp, -1.7_wp]
      allocate (at%w(0))
      call model%force(at, f)
      call check_close(failure, f(1), -2.0_wp*9.81_wp*sin(1.2_wp) - 1.7_wp**2*sin(1.6_wp), 1.0e-13_wp, 'first')
      call check_close(failure, f(2), -9.81_wp*sin(-0.4_wp) + 0.9_wp**2*sin(1.6_wp), 1.0e-13_wp, 'second')
      start = model%energy(at)
      call check_close(failure, start, 0.9_wp**2 + 0.5_wp*1.7_wp**2 - 0.9_wp*1.7_wp*cos(1.6_wp) &
                       - 9.81_wp*(2.0_wp*cos(1.2_wp) + cos(0.4_wp)), 1.0e-13_wp, 'energy')
      options%rtol = 1.0e-11_wp
      options%atol = 1.0e-11_wp
      call simulate(model, at, 5.0_wp, result, error, options=options)
      call no_error(failure, error)
      call check_close(failure, model%energy(at), start, 1.0e-8_wp, 'energy after five seconds')
   end subroutine energies

   subroutine long_chain(failure)
      character(:), allocatable, intent(inout) :: failure
      type(chain_t) :: chain
      class(borrowed_t), allocatable :: model
      type(state_t) :: at
      type(error_t), allocatable :: error
      integer, allocatable :: column(:), expected_column(:), expected_first(:), first(:)
      real(wp), allocatable :: entries(:), entries_at_once(:), value(:), value_at_once(:)

      call new_chain(chain, 2000, 1.0_wp, 1.0_wp, 9.81_wp, error)
      call no_error(failure, error)
      call chain%start(0.3_wp, at)
      model = without_derivatives(chain)
      call model%find_structure(at)
      call chain%pattern(expected_first, expected_column)
      call model%pattern(first, column)
      call check(failure, allocated(first), 'a pattern')
      if (.not. allocated(first)) return
      call check(failure, all(first == expected_first) .and. size(column) == size(expected_column), 'rows')
      if (size(column) == size(expected_column)) call check(failure, all(column == expected_column), 'columns')
      ! Four columns stand for all: phi and A come out of one evaluation, as out of two.
      call check(failure, model%linearizes, 'phi and A at once')
      allocate (entries(size(column)), entries_at_once(size(column)), value(model%c), value_at_once(model%c), source=7.0_wp)
      at = shaken(at)
      call model%constraint(at, value)
      call model%jacobian_entries(at, entries)
      call model%linearization(at, value_at_once, entries_at_once)
      call check(failure, .not. any(abs(value - value_at_once) > 0.0_wp), 'phi')
      call check(failure, .not. any(abs(entries - entries_at_once) > 0.0_wp), 'entries')
   end subroutine long_chain

   subroutine faults(failure)
      character(:), allocatable, intent(inout) :: failure
      type(angles_t) :: model
      type(empty_t) :: empty
      type(state_t) :: at

      at%x = [1.2_wp, -0.4_wp]
      at%v = [0.9_wp, -1.7_wp]
      allocate (at%w(0))
      call model%define(n=2, c=0, constant_mass=.true.)
      call expect(model, 'its masses depend on coordinates or time')
      model%turned = .true.
      call model%define(n=2, c=0, constant_mass=.false.)
      call expect(model, 'its masses depend on coordinates whose rates are not the velocities')
      call empty%define(n=2, c=1)
      call expect(empty, 'it has constraints and no procedure phi')
      call empty%define(n=2, c=1, nonholonomic=1)
      call expect(empty, 'it has constraints and no procedure nonholonomic')

   contains

      subroutine expect(model, text)
         class(mechanical_system_t), intent(in) :: model
         character(*), intent(in) :: text
         type(state_t) :: there
         type(integration_result_t) :: result
         type(error_t), allocatable :: error

         there = at
         call simulate(model, there, 1.0_wp, result, error)
         call check(failure, allocated(error), text)
         if (allocated(error)) call check(failure, index(error%line(), text) > 0, error%line())
      end subroutine expect

   end subroutine faults

   subroutine rods_mass(self, at, m)
      class(rods_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m

      call self%hand%mass(at, m)
   end subroutine rods_mass

   subroutine rods_force(self, at, value)
      class(rods_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      call self%hand%force(at, value)
   end subroutine rods_force

   subroutine rods_phi(self, at, value)
      class(rods_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value(:)

      associate (joint => self%hand%joints)
         value(1:3) = at%x(1:3) + rotate(at%x(4:7), joint(1)%point) - joint(1)%other_point
         value(4:6) = at%x(8:10) + rotate(at%x(11:14), joint(2)%point) - at%x(1:3) - rotate(at%x(4:7), joint(2)%other_point)
      end associate
   end subroutine rods_phi

   subroutine edge_mass(self, at, m)
      class(edge_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m

      call self%hand%mass(at, m)
   end subroutine edge_mass

   subroutine edge_force(self, at, value)
      class(edge_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      call self%hand%force(at, value)
   end subroutine edge_force

   subroutine edge_row(self, at, value)
      class(edge_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value(:)

      value(1) = cos(at%x(3))*at%v(2) - sin(at%x(3))*at%v(1)
      if (.not. self%linear) value(1) = value(1)*at%v(3)
   end subroutine edge_row

   subroutine angles_masses(self, at, m)
      class(angles_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(inout) :: m(:, :)

      m(1, 1) = 2.0_wp
      m(2, 2) = 1.0_wp
      m(1, 2) = cos(at%x(1) - at%x(2))
      m(2, 1) = m(1, 2)
      associate (unused_system => self)
      end associate
   end subroutine angles_masses

   subroutine angles_potential(self, at, value)
      class(angles_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value

      value = -9.81_wp*(2.0_wp*cos(at%x(1)) + cos(at%x(2)))
      associate (unused_system => self)
      end associate
   end subroutine angles_potential

   subroutine angles_kinematics(self, at, rate)
      class(angles_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: rate(:)

      rate(:) = at%v
      if (self%turned) rate(1) = cos(at%x(2))*at%v(1)
   end subroutine angles_kinematics

   subroutine empty_masses(self, at, m)
      class(empty_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(inout) :: m(:, :)

      m(1, 1) = 1.0_wp
      m(2, 2) = 1.0_wp
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine empty_masses

end module test_automatic
