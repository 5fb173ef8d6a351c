!> Faults planted in systems, each found and rightly named; and systems that are right.
module test_faults
   use automatic_systems, only: without_derivatives
   use beams, only: hung_beam
   use car_axis, only: car_axis_start, new_car_axis
   use edge_systems, only: servo_t, sized_t, turntable_t
   use faulty_system, only: faulty_t, planted
   use squeezer, only: new_squeezer, squeezer_start
   use systems, only: bead, driven_pivot, jumping_load, new_compound, new_coupler, new_particle, sleigh, sleigh_in_space, two_rods
   use taut, only: error_t, finding_t, integration_result_t, mechanical_system_t, new_rigid_bodies, quaternion_of_vector, &
                   rigid_bodies_t, rigid_body_t, simulate, spherical_joint_t, state_t, verify, wp
   use taut_error, only: to_text
   use taut_model_beam, only: beam_t
   use taut_model_chain, only: chain_t, new_chain
   use taut_model_helicopter, only: helicopter_data_t, helicopter_t, new_helicopter
   use taut_model_n_four_bar, only: n_four_bar_t, new_n_four_bar
   use taut_model_pendulum, only: new_pendulum, pendulum_t
   use testing, only: check, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_faults

   !> Whose faults have a row of their own.
   character(len=3), parameter :: names_of_rows(6) = [character(len=3) :: 'A', 'b''', 'b''''', 'H', 'phi', 'g']

contains

   !> All tests of this module.
   function collect_faults() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('faults of 25 kinds in as many systems', planted_faults), &
               new_test('the same systems without', none), &
               new_test('simulate sees faults of the constraints and of a constant mass at its first look', first), &
               new_test('right systems of rare kinds', rare)]
   end function collect_faults

   !> A state, without others.
   function state(x, v) result(at)
      real(wp), intent(in) :: x(:), v(:)
      type(state_t) :: at

      at%x = x
      at%v = v
      allocate (at%w(0))
   end function state

   !> Does something with each system, its state, and the fault that suits it: its procedure, row, column and factor, and the name
   !! that it is to be found under. No two faults are of one kind.
   subroutine with_each(failure, act)
      character(:), allocatable, intent(inout) :: failure
      interface
         subroutine act(failure, right, at, fault, row, column, factor, what)
            import :: mechanical_system_t, state_t, wp
            implicit none (type, external)
            character(:), allocatable, intent(inout) :: failure
            class(mechanical_system_t), intent(in) :: right
            type(state_t), intent(in) :: at
            character(*), intent(in) :: fault, what
            integer, intent(in) :: row, column
            real(wp), intent(in) :: factor
         end subroutine act
      end interface
      type(pendulum_t) :: pendulum
      type(chain_t) :: chain
      type(n_four_bar_t) :: four_bar
      type(helicopter_t) :: blade
      type(helicopter_data_t) :: data
      type(rigid_bodies_t) :: bodies
      type(rigid_body_t) :: body
      type(beam_t) :: beam
      type(sized_t) :: small
      type(servo_t) :: servo
      type(turntable_t) :: table
      type(state_t) :: at
      type(error_t), allocatable :: error
      integer :: i, k

      ! b'': of the wrong sign, at rest, where it is zero and shows nothing; a little too large; forgotten; of a row that is not
      ! holonomic; not supplied.
      call new_pendulum(pendulum, 1.0_wp, 1.0_wp, 9.81_wp, 1, error)
      call act(failure, pendulum, state([1.0_wp, 0.0_wp], [0.0_wp, 0.0_wp]), 'b''''', 1, 1, -1.0_wp, 'b''''')
      call act(failure, without_derivatives(new_car_axis()), car_axis_start(), 'b''''', 1, 1, 1.01_wp, 'b''''')
      call act(failure, new_particle(bead), state([1.0_wp, 0.0_wp], [0.5_wp, 0.1_wp]), 'no b''''', 1, 1, 0.0_wp, 'b''''')
      call act(failure, new_particle(sleigh), state([0.0_wp, 0.0_wp, 0.3_wp], [0.0_wp, 0.0_wp, 0.0_wp]), 'b''''', 1, 1, -1.0_wp, &
               'b''''')
      call act(failure, new_coupler(4), state([0.6_wp, -0.8_wp, 0.1_wp], [0.1_wp, 0.2_wp, 0.3_wp]), 'missing', 1, 1, 0.0_wp, &
               'acceleration_rhs')
      ! b': of the wrong sign; forgotten.
      call act(failure, new_car_axis(), car_axis_start(), 'b''', 1, 1, -1.0_wp, 'b''')
      call act(failure, new_particle(driven_pivot, rate=3.0_wp, amplitude=0.1_wp), state([0.6_wp, -0.8_wp], [0.8_wp, 0.6_wp]), &
               'no b''', 1, 1, 0.0_wp, 'b''')
      ! A: a sign; a factor; two entries the wrong way round; one that the pattern lacks; one whose value is another than that of the
      ! dense A; a phi that is not its own.
      call act(failure, new_coupler(3), state([0.6_wp, -0.8_wp, 0.1_wp], [0.1_wp, 0.2_wp, 0.3_wp]), 'A', 2, 1, -1.0_wp, 'A')
      call act(failure, new_particle(two_rods), state([0.6_wp, 0.8_wp], [0.8_wp, -0.6_wp]), 'A', 2, 2, 1.001_wp, 'A')
      call small%define(n=2, c=1, mass_blocks=[1, 1])
      small%l = 1.0e-3_wp
      call act(failure, small, state(small%l*[0.6_wp, -0.8_wp], small%l*[0.8_wp, 0.6_wp]), 'swapped', 1, 1, 1.0_wp, 'A')
      call new_chain(chain, 5, 1.0_wp, 1.0_wp, 9.81_wp, error)
      call chain%start(0.3_wp, at)
      call act(failure, chain, at, 'lacking', 7, 1, 1.0_wp, 'A')
      call new_n_four_bar(four_bar, 2, 1.0_wp, 1.0_wp, 9.81_wp, error)
      call four_bar%start(0.3_wp, 1.0_wp, at)
      call act(failure, four_bar, at, 'entries', 3, 1, 0.5_wp, 'A')
      beam = hung_beam()
      call act(failure, beam, beam%reference_state(), 'phi', 1, 1, 2.0_wp, 'A')
      ! phi that depends on a velocity.
      call chain%start(0.3_wp, at)
      call act(failure, without_derivatives(chain), at, 'of v', 3, 5, 0.1_wp, 'phi')
      ! M: not symmetric; not definite; outside its blocks; constant, as is said, and it is not.
      data%b_cosine = [0.0_wp, 0.0_wp, 0.01_wp]
      call new_helicopter(blade, data, error)
      call act(failure, blade, state([0.1_wp, 0.05_wp], [0.3_wp, 0.2_wp]), 'M', 2, 1, -1.0_wp, 'M')
      call new_pendulum(pendulum, 1.0_wp, 1.0_wp, 9.81_wp, 3, error)
      call act(failure, pendulum, state([0.6_wp, -0.8_wp], [0.8_wp, 0.6_wp]), 'M', 2, 2, -1.0_wp, 'M')
      call act(failure, without_derivatives(new_squeezer()), squeezer_start(), 'blocks', 1, 1, 1.0_wp, 'M')
      call act(failure, new_squeezer(), squeezer_start(), 'constant', 1, 1, 1.0_wp, 'M')
      ! f and g: not set.
      call act(failure, new_particle(sleigh_in_space), state([0.0_wp, 0.0_wp, 0.3_wp, 0.0_wp], [1.0_wp, 0.3_wp, 1.0_wp, 0.0_wp]), &
               'f', 2, 1, 0.0_wp, 'f')
      call servo%define(n=2, c=1, n_w=1)
      at = state([0.3_wp, 0.5_wp], [0.1_wp, 0.2_wp])
      at%w = [0.25_wp]
      call act(failure, servo, at, 'g', 1, 1, 0.0_wp, 'g')
      ! Coordinates: H; its inverse; displacements; what brings them back and does not end what it begins.
      call act(failure, new_compound(), state([0.3_wp, -0.4_wp, 0.8_wp, 0.6_wp], [0.4_wp, 0.3_wp, 1.0_wp]), 'H', 4, 1, -1.0_wp, 'H')
      call table%define(n=5, c=2, nonholonomic=2, n_x=2, mass_blocks=[1, 1, 1, 1, 1])
      call act(failure, table, state([0.3_wp, 0.0_wp], [0.1_wp, 0.2_wp, 4.0_wp, 1.0_wp, 1.0_wp]), 'H^+', 1, 1, 2.0_wp, 'H^+')
      body%m = 1.5_wp
      body%s = [0.0_wp, 0.1_wp, 0.6_wp]
      do i = 1, 3
         body%j(i, i) = 0.5_wp + 0.1_wp*i
      end do
      do k = 0, 1
         call new_rigid_bodies(bodies, [body], [spherical_joint_t(1, 0, [0.1_wp, 0.2_wp, 0.3_wp], [0.0_wp, 0.1_wp, 0.0_wp])], &
                               [0.0_wp, 0.0_wp, -9.81_wp*k], error)
         at = state([0.3_wp, 0.2_wp, -0.4_wp, quaternion_of_vector([0.5_wp, -0.7_wp, 0.3_wp])], [(cos(1.7_wp*i), i=1, 6)])
         if (k == 0) call act(failure, bodies, at, 'displace', 5, 1, -1.0_wp, 'H')
         if (k == 1) call act(failure, bodies, at, 'normalize', 4, 1, 1.01_wp, 'x')
      end do
      ! Forces that depend on the multipliers are promised, and not supplied.
      call act(failure, new_particle(jumping_load), state([0.6_wp, -0.8_wp], [0.8_wp, 0.6_wp]), 'reactive', 1, 1, 1.0_wp, &
               'reaction_force')
      call no_error(failure, error)
   end subroutine with_each

   subroutine planted_faults(failure)
      character(:), allocatable, intent(inout) :: failure

      call with_each(failure, is_found)
   end subroutine planted_faults

   !> What is found first of all that does not follow from something else has the name and the row of the fault.
   subroutine is_found(failure, right, at, fault, row, column, factor, what)
      character(:), allocatable, intent(inout) :: failure
      class(mechanical_system_t), intent(in) :: right
      type(state_t), intent(in) :: at
      character(*), intent(in) :: fault, what
      integer, intent(in) :: row, column
      real(wp), intent(in) :: factor
      type(faulty_t) :: model
      type(finding_t), allocatable :: findings(:)
      type(error_t), allocatable :: error
      integer :: i

      model = planted(right, fault, row, column, factor)
      call verify(model, at, findings, error)
      if (allocated(error)) then
         call check(failure, index(error%line(), ' '//what) > 0, fault//' gives '//error%line())
         return
      end if
      call check(failure, size(findings) > 0, fault//' is not found')
      do i = 1, size(findings)
         if (findings(i)%follows) cycle
         call check(failure, findings(i)%what == what, fault//' gives '//findings(i)%message)
         ! Of the structured A, the fault is told by the number of an entry.
         if (any(what == names_of_rows) .and. .not. any(fault == [character(len=8) :: 'entries', 'lacking', 'displace'])) &
            call check(failure, findings(i)%row == row, fault//' is taken for '//findings(i)%message)
      end do
   end subroutine is_found

   subroutine first(failure)
      character(:), allocatable, intent(inout) :: failure

      call with_each(failure, is_seen)
   end subroutine first

   !> A run does not begin; and does, where it is told not to look.
   subroutine is_seen(failure, right, at, fault, row, column, factor, what)
      character(:), allocatable, intent(inout) :: failure
      class(mechanical_system_t), intent(in) :: right
      type(state_t), intent(in) :: at
      character(*), intent(in) :: fault, what
      integer, intent(in) :: row, column
      real(wp), intent(in) :: factor
      type(state_t) :: there
      type(integration_result_t) :: result
      type(error_t), allocatable :: error

      if (.not. any(what == names_of_rows(:3)) .and. fault /= 'constant') return
      ! A start that no projection mends is an error of its own.
      there = at
      call simulate(planted(right, fault, row, column, factor), there, at%t, result, error)
      call check(failure, allocated(error), fault//' is not seen in row '//to_text(row)//' of '//to_text(right%c))
      if (.not. allocated(error)) return
      call check(failure, error%where == 'first look' .or. error%where == 'initial state', error%line())
      deallocate (error)
      if (fault /= 'b''''') return
      there = at
      call simulate(planted(right, fault, row, column, factor), there, at%t, result, error, look=.false.)
      call no_error(failure, error)
   end subroutine is_seen

   subroutine none(failure)
      character(:), allocatable, intent(inout) :: failure

      call with_each(failure, is_right)
   end subroutine none

   subroutine rare(failure)
      character(:), allocatable, intent(inout) :: failure
      type(servo_t) :: servo
      type(turntable_t) :: table
      type(sized_t) :: pendulum
      type(state_t) :: at
      integer :: i

      call servo%define(n=2, c=1, n_w=1)
      at = state([0.3_wp, 0.5_wp], [0.1_wp, 0.2_wp])
      at%w = [0.25_wp]
      call is_right(failure, servo, at, 'phi of w', 0, 0, 0.0_wp, 'servo')
      call table%define(n=5, c=2, nonholonomic=2, n_x=2, mass_blocks=[1, 1, 1, 1, 1])
      at = state([0.3_wp, 0.0_wp], [0.1_wp, 0.2_wp, 4.0_wp, 1.0_wp, 1.0_wp])
      call is_right(failure, table, at, 'fewer coordinates', 0, 0, 0.0_wp, 'turntable')
      call pendulum%define(n=2, c=1, mass_blocks=[1, 1])
      do i = -10, 8
         pendulum%l = 10.0_wp**i
         at = state(pendulum%l*[0.6_wp, -0.8_wp], pendulum%l*[0.8_wp, 0.6_wp])
         call is_right(failure, pendulum, at, 'size', 0, 0, 0.0_wp, 'pendulum')
      end do
   end subroutine rare

   subroutine is_right(failure, right, at, fault, row, column, factor, what)
      character(:), allocatable, intent(inout) :: failure
      class(mechanical_system_t), intent(in) :: right
      type(state_t), intent(in) :: at
      character(*), intent(in) :: fault, what
      integer, intent(in) :: row, column
      real(wp), intent(in) :: factor
      type(finding_t), allocatable :: findings(:)
      type(error_t), allocatable :: error

      call verify(right, at, findings, error)
      call no_error(failure, error)
      if (size(findings) > 0) call check(failure, .false., fault//' '//what//': '//findings(1)%message)
      associate (unused => [row, column], unused_factor => factor)
      end associate
   end subroutine is_right

end module test_faults
