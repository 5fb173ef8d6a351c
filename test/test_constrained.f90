!> The methods on small systems with known motions: driven, non-holonomic, redundant, inconsistent, with quasi-velocities.
module test_constrained
   use closed_forms, only: jacobi, pendulum_motion
   use systems, only: actuator, bead, compound_t, coupler_t, driven_pivot, jumping_load, new_compound, new_coupler, &
                      new_particle, particle_t, sleigh, sleigh_in_space, two_rods
   use taut, only: consistent_start, constrained_ode_t, error_t, finding_t, integration_options_t, integration_result_t, &
                   mechanical_system_t, method_t, sample_t, simulate, start_report_t, state_t, status_projection_failed, &
                   status_reached_end, trajectory_t, verify, wp
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_constrained

   real(wp), parameter :: g = 9.81_wp

contains

   !> All tests of this module.
   function collect_constrained() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('every test system passes the checker', systems_are_consistent), &
               new_test('rheonomic: a bead on a turning wire', bead_on_wire), &
               new_test('rheonomic: a driven pivot', pivot_is_driven), &
               new_test('non-holonomic: a knife edge on an incline', knife_edge), &
               new_test('holonomic and non-holonomic together', knife_edge_in_space), &
               new_test('quasi-velocities: a compound pendulum', compound_pendulum), &
               new_test('states that are not mechanics', other_states), &
               new_test('redundant on the manifold only: parallel cranks', parallel_cranks), &
               new_test('weights: identity, mass and given', weights), &
               new_test('inconsistent rods are refused and named', inconsistent_refused), &
               new_test('inconsistent rods accepted on request', inconsistent_accepted), &
               new_test('order 5 across a jump of the load', jump_of_load), &
               new_test('a start with the wrong sizes', wrong_sizes), &
               new_test('method options that are not valid', bad_methods)]
   end function collect_constrained

   !> Tight options.
   function tight(rtol) result(options)
      real(wp), intent(in) :: rtol
      type(integration_options_t) :: options

      options%rtol = rtol
      options%atol = rtol
   end function tight

   !> A state.
   function state(t, x, v) result(at)
      real(wp), intent(in) :: t, x(:), v(:)
      type(state_t) :: at

      at%t = t
      allocate (at%x, source=x)
      allocate (at%v, source=v)
      allocate (at%w(0))
   end function state

   !> Violations, multipliers and rank at a state.
   subroutine inspect(ode, at, s)
      class(constrained_ode_t), intent(inout) :: ode
      type(state_t), intent(in) :: at
      type(sample_t), intent(inout) :: s
      real(wp) :: y(ode%size())
      integer :: info

      call ode%pack(at, y)
      call ode%sample(at%t, y, s, info)
   end subroutine inspect

   subroutine systems_are_consistent(failure)
      character(:), allocatable, intent(inout) :: failure

      call look(new_particle(bead, rate=1.3_wp), state(0.4_wp, [0.9_wp, 0.6_wp], [0.4_wp, 2.1_wp]), failure)
      call look(new_particle(sleigh), state(0.4_wp, [0.9_wp, 0.6_wp, 0.7_wp], [0.4_wp, 2.1_wp, 1.7_wp]), failure)
      call look(new_particle(sleigh_in_space), &
                state(0.4_wp, [0.9_wp, 0.6_wp, 0.7_wp, 0.1_wp], [0.4_wp, 2.1_wp, 1.7_wp, 0.3_wp]), failure)
      call look(new_particle(driven_pivot, rate=2.0_wp, amplitude=0.3_wp), &
                state(0.4_wp, [0.9_wp, 0.6_wp], [0.4_wp, 2.1_wp]), failure)
      call look(new_coupler(3), state(0.0_wp, [0.6_wp, -0.8_wp, 0.1_wp], [0.4_wp, 2.1_wp, 0.9_wp]), failure)
      call look(new_compound(), state(0.0_wp, [0.6_wp, -0.8_wp, 0.6_wp, 0.8_wp], [0.4_wp, 2.1_wp, 0.9_wp]), failure)
   end subroutine systems_are_consistent

   subroutine look(system, at, failure)
      class(mechanical_system_t), intent(in) :: system
      type(state_t), intent(in) :: at
      character(:), allocatable, intent(inout) :: failure
      type(finding_t), allocatable :: findings(:)
      type(error_t), allocatable :: error

      call verify(system, at, findings, error)
      call no_error(failure, error)
      if (size(findings) > 0) call check(failure, .false., findings(1)%message)
   end subroutine look

   !> r = cosh(rate t); the wire pushes with 2 m rate rdot.
   subroutine bead_on_wire(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=24), parameter :: names(13) = [character(len=24) :: 'present', 'baseline', 'baumgarte', 'braun-goldfarb', &
                                                  'yu-chen', 'coordinate-projection', 'minimal-coordinates', &
                                                  'augmented-lagrangian', 'udwadia-kalaba', 'dummy-derivatives', &
                                                  'gear-gupta-leimkuhler', 'fuhrer-leimkuhler', 'embedded-projection']
      type(particle_t) :: system
      type(method_t) :: method
      type(integration_result_t) :: result
      class(constrained_ode_t), allocatable :: ode
      type(sample_t) :: s
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp), parameter :: rate = 1.3_wp, t = 2.0_wp
      real(wp) :: allowed
      integer :: i

      system = new_particle(bead, rate=rate)
      do i = 1, size(names)
         method%name = names(i)
         at = state(0.0_wp, [1.0_wp, 0.0_wp], [0.0_wp, rate])
         call simulate(system, at, t, result, error, method, tight(1.0e-11_wp), ode=ode)
         call no_error(failure, error)
         call check_below(failure, maxval(abs(at%x - cosh(rate*t)*[cos(rate*t), sin(rate*t)])), 1.0e-8_wp, &
                          trim(names(i))//': motion')
         call inspect(ode, at, s)
         ! Half-explicit multipliers of stabilized index 2 are those of the stage before, others the mean of the step before.
         allowed = 1.0e-7_wp
         if (names(i) == 'gear-gupta-leimkuhler') allowed = 1.0e-2_wp
         if (names(i) == 'embedded-projection') allowed = 2.0e-1_wp
         call check_close(failure, s%lambda(1), -2.0_wp*rate**2*sinh(rate*t), allowed, trim(names(i))//': reaction')
         if (i == 1) call check_below(failure, max(s%phi, s%phidot), 1.0e-12_wp, 'compliance')
      end do
      ! A start with the velocity forgotten is given it by the constraint: b' is not zero.
      method%name = 'present'
      at = state(0.0_wp, [1.0_wp, 0.0_wp], [0.0_wp, 0.0_wp])
      call simulate(system, at, t, result, error, method, tight(1.0e-11_wp))
      call check_below(failure, norm2(at%x) - cosh(rate*t), 1.0e-8_wp, 'motion from a corrected start')
   end subroutine bead_on_wire

   !> A pivot that oscillates vertically under a hanging mass: the tension is m (g + pivot's acceleration).
   subroutine pivot_is_driven(failure)
      character(:), allocatable, intent(inout) :: failure
      type(particle_t) :: system
      type(integration_result_t) :: result
      class(constrained_ode_t), allocatable :: ode
      type(sample_t) :: s
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp), parameter :: rate = 2.0_wp, amplitude = 0.3_wp, t = 2.7_wp

      system = new_particle(driven_pivot, rate=rate, amplitude=amplitude)
      at = state(0.0_wp, [0.0_wp, -1.0_wp], [0.0_wp, amplitude*rate])
      call simulate(system, at, t, result, error, options=tight(1.0e-10_wp), ode=ode)
      call no_error(failure, error)
      call check_below(failure, maxval(abs(at%x - [0.0_wp, -1.0_wp + amplitude*sin(rate*t)])), 1.0e-9_wp, 'motion')
      call inspect(ode, at, s)
      call check_close(failure, s%lambda(1), g - amplitude*rate**2*sin(rate*t), 1.0e-8_wp, 'tension')
   end subroutine pivot_is_driven

   !> x = a sin^2, y = a (rate t - sin cos) with a = g/(2 rate^2): a cycloid, though gravity points along x.
   subroutine knife_edge(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=24), parameter :: names(12) = [character(len=24) :: 'present', 'baseline', 'baumgarte', 'braun-goldfarb', &
                                                  'coordinate-projection', 'minimal-coordinates', 'augmented-lagrangian', &
                                                  'udwadia-kalaba', 'dummy-derivatives', 'gear-gupta-leimkuhler', &
                                                  'fuhrer-leimkuhler', 'embedded-projection']
      type(method_t) :: method
      type(integration_result_t) :: result
      class(constrained_ode_t), allocatable :: ode
      type(sample_t) :: s
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp), parameter :: rate = 2.0_wp, t = 3.0_wp, a = g/(2.0_wp*rate**2)
      integer :: i

      do i = 1, size(names)
         method%name = names(i)
         at = state(0.0_wp, [0.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, rate])
         call simulate(new_particle(sleigh), at, t, result, error, method, tight(1.0e-11_wp), ode=ode)
         call no_error(failure, error)
         call check_below(failure, maxval(abs(at%x - [a*sin(rate*t)**2, a*(rate*t - sin(rate*t)*cos(rate*t)), rate*t])), &
                          1.0e-8_wp, trim(names(i))//': motion')
         call inspect(ode, at, s)
         if (i == 1) call check_below(failure, s%phidot, 1.0e-14_wp, 'compliance')
         call check_below(failure, s%phi, 0.0_wp, 'there is no position level')
      end do
   end subroutine knife_edge

   subroutine knife_edge_in_space(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=16), parameter :: weight(3) = [character(len=16) :: 'identity', 'mass', 'given']
      type(method_t) :: method
      type(integration_result_t) :: result
      class(constrained_ode_t), allocatable :: ode
      type(sample_t) :: s
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp), parameter :: rate = 2.0_wp, t = 3.0_wp, a = g/(2.0_wp*rate**2)
      integer :: i

      do i = 1, 2
         method%weight = weight(i)
         at = state(0.0_wp, [0.0_wp, 0.0_wp, 0.0_wp, 0.1_wp], [0.0_wp, 0.0_wp, rate, 0.2_wp])
         call simulate(new_particle(sleigh_in_space), at, t, result, error, method, tight(1.0e-11_wp), ode=ode)
         call no_error(failure, error)
         call check_below(failure, maxval(abs(at%x(1:3) - [a*sin(rate*t)**2, a*(rate*t - sin(rate*t)*cos(rate*t)), rate*t])), &
                          1.0e-8_wp, 'motion')
         call inspect(ode, at, s)
         call check_below(failure, max(s%phi, s%phidot), 1.0e-14_wp, 'compliance')
         call check_close(failure, s%lambda(1), -3.0_wp, 1.0e-10_wp, 'the floor pushes back')
         call check(failure, s%rank == 2, 'rank')
      end do
   end subroutine knife_edge_in_space

   !> A compound pendulum swings like a simple one of length (I + m arm^2)/(m arm).
   subroutine compound_pendulum(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=24), parameter :: names(11) = [character(len=24) :: 'present', 'baseline', 'braun-goldfarb', &
                                                  'coordinate-projection', 'minimal-coordinates', 'augmented-lagrangian', &
                                                  'udwadia-kalaba', 'dummy-derivatives', 'gear-gupta-leimkuhler', &
                                                  'fuhrer-leimkuhler', 'embedded-projection']
      type(compound_t) :: system
      type(method_t) :: method
      type(integration_result_t) :: result
      class(constrained_ode_t), allocatable :: ode
      type(sample_t) :: s
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp), parameter :: angle_0 = 2.0_wp
      real(wp) :: angle, energy, length, period, rate
      integer :: i

      system = new_compound()
      length = (system%inertia + system%m*system%arm**2)/(system%m*system%arm)
      do i = 1, size(names)
         method%name = names(i)
         at = state(0.0_wp, [system%arm*sin(angle_0), -system%arm*cos(angle_0), cos(angle_0), sin(angle_0)], &
                    [0.0_wp, 0.0_wp, 0.0_wp])
         energy = system%energy(at)
         call simulate(system, at, 5.0_wp, result, error, method, tight(1.0e-11_wp), ode=ode)
         call no_error(failure, error)
         call pendulum_motion(5.0_wp, length, g, angle_0, angle, rate, period)
         call check_below(failure, maxval(abs(at%x(3:4) - [cos(angle), sin(angle)])), 1.0e-8_wp, trim(names(i))//': angle')
         call check_close(failure, at%v(3), rate, 1.0e-8_wp, trim(names(i))//': rate')
         call check_close(failure, norm2(at%x(3:4)), 1.0_wp, 4.0e-16_wp, trim(names(i))//': coordinates of unit length')
         call inspect(ode, at, s)
         call check_close(failure, s%energy, energy, 1.0e-8_wp, trim(names(i))//': energy')
         if (i == 1) call check_below(failure, max(s%phi, s%phidot), 1.0e-12_wp, 'compliance')
      end do
   end subroutine compound_pendulum

   !> A mass pushed by w, w' = -w; no constraint at all.
   subroutine other_states(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error

      at = state(0.0_wp, [0.0_wp], [0.0_wp])
      at%w = [1.0_wp]
      call simulate(new_particle(actuator), at, 2.0_wp, result, error, options=tight(1.0e-10_wp))
      call no_error(failure, error)
      call check_close(failure, at%w(1), exp(-2.0_wp), 1.0e-9_wp, 'w')
      call check_close(failure, at%v(1), 1.0_wp - exp(-2.0_wp), 1.0e-9_wp, 'v')
      call check_close(failure, at%x(1), 1.0_wp + exp(-2.0_wp), 1.0e-9_wp, 'x')
   end subroutine other_states

   !> A level coupler on parallel cranks swings like a simple pendulum. Three cranks: rank 2 on the manifold, 3 beside it.
   subroutine parallel_cranks(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=16), parameter :: solvers(3) = [character(len=16) :: 'auto', 'dgelsd', 'factor']
      character(len=16), parameter :: weight(2) = [character(len=16) :: 'identity', 'mass']
      character(len=24), parameter :: names(3) = [character(len=24) :: 'present', 'baseline', 'coordinate-projection']
      real(wp), parameter :: angle_0 = 1.0_wp
      integer :: i, j

      do j = 1, 2
         do i = 1, 3
            call swing_coupler(method_t(weight=weight(j), solver=solvers(i)), 1.0e-9_wp)
         end do
      end do
      do i = 1, 3
         call swing_coupler(method_t(name=names(i)), 1.0e-9_wp)
         call swing_coupler(method_t(name=names(i)), 1.0e-4_wp)
      end do
      call swing_coupler(method_t(stage_projection='none'), 1.0e-9_wp)

   contains

      subroutine swing_coupler(method, rtol)
         type(method_t), intent(in) :: method
         real(wp), intent(in) :: rtol
         type(integration_result_t) :: result
         class(constrained_ode_t), allocatable :: ode
         type(sample_t) :: s
         type(state_t) :: at
         type(error_t), allocatable :: error
         real(wp) :: angle, period, rate

         at = state(0.0_wp, [sin(angle_0), -cos(angle_0), 0.0_wp], [0.0_wp, 0.0_wp, 0.0_wp])
         call simulate(new_coupler(3), at, 5.0_wp, result, error, method, tight(rtol), ode=ode)
         call no_error(failure, error)
         call check(failure, result%status == status_reached_end, 'the end is reached')
         call pendulum_motion(5.0_wp, 1.0_wp, g, angle_0, angle, rate, period)
         call check_below(failure, maxval(abs(at%x - [sin(angle), -cos(angle), 0.0_wp])), 1.0e3_wp*rtol, &
                          trim(method%name)//': motion')
         call inspect(ode, at, s)
         if (method%name == 'baseline') return
         call check(failure, s%rank == 2, 'rank')
         call check_below(failure, max(s%phi, s%phidot), 1.0e-12_wp, 'compliance')
         ! Minimum norm: each crank carries a third.
         call check_below(failure, maxval(abs(s%lambda - sum(s%lambda)/3.0_wp)), 1.0e-8_wp*100.0_wp, 'shares of the load')
      end subroutine swing_coupler

   end subroutine parallel_cranks

   !> The weight bends the way to the manifold, not the motion.
   subroutine weights(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=16), parameter :: weight(3) = [character(len=16) :: 'identity', 'mass', 'given']
      type(method_t) :: method
      type(integration_result_t) :: result
      type(start_report_t) :: report
      type(particle_t) :: system
      type(state_t) :: at, moved(3), started(3)
      type(error_t), allocatable :: error
      integer :: i

      system = new_particle(driven_pivot, rate=1.0_wp, amplitude=0.2_wp)
      do i = 1, 3
         method%weight = weight(i)
         at = state(0.0_wp, [0.6_wp, -0.8_wp], [0.0_wp, 0.2_wp])
         call simulate(system, at, 3.0_wp, result, error, method, tight(1.0e-11_wp))
         call no_error(failure, error)
         moved(i) = at
         call check_below(failure, maxval(abs(at%x - moved(1)%x)), 1.0e-9_wp, 'motion')
         at = state(0.0_wp, [0.9_wp, -0.8_wp], [0.0_wp, 0.0_wp])
         call consistent_start(system, method, at, report, error)
         started(i) = at
      end do
      ! Equal masses: W = M corrects like W = I; the given weight goes another way.
      call check_below(failure, maxval(abs(started(2)%x - started(1)%x)), 1.0e-12_wp, 'W = M')
      call check(failure, maxval(abs(started(3)%x - started(1)%x)) > 1.0e-3_wp, 'W given')
   end subroutine weights

   subroutine inconsistent_refused(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error

      at = state(0.0_wp, [1.0_wp, 0.0_wp], [0.0_wp, 0.0_wp])
      call simulate(new_particle(two_rods, ratio=1.2_wp), at, 1.0_wp, result, error)
      call check(failure, allocated(error), 'two rods that cannot both hold are refused')
      if (.not. allocated(error)) return
      call check(failure, index(error%line(), 'inconsistent') > 0 .and. index(error%line(), '0.1') > 0, &
                 'the residual is named: '//error%line())
      deallocate (error)
      at = state(0.0_wp, [1.0_wp, 0.0_wp], [0.0_wp, 0.0_wp])
      call simulate(new_particle(two_rods, ratio=1.0_wp), at, 1.0_wp, result, error)
      call no_error(failure, error)
   end subroutine inconsistent_refused

   !> Rods of 1.0 and 1.2 at the same pivot: the point moves on the circle between them.
   subroutine inconsistent_accepted(failure)
      character(:), allocatable, intent(inout) :: failure
      type(method_t) :: method
      type(integration_result_t) :: result
      class(constrained_ode_t), allocatable :: ode
      type(start_report_t) :: report
      type(sample_t) :: s
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp) :: angle, period, rate

      method%accept_inconsistent = .true.
      at = state(0.0_wp, [1.0_wp, 0.0_wp], [0.0_wp, 0.0_wp])
      call simulate(new_particle(two_rods, ratio=1.2_wp), at, 2.0_wp, result, error, method, &
                    tight(1.0e-10_wp), start=report, ode=ode)
      call no_error(failure, error)
      call check_close(failure, report%phi_left, 0.1_wp, 1.0e-10_wp, 'the report says what is left')
      call pendulum_motion(2.0_wp, 1.1_wp, g, 0.5_wp*acos(-1.0_wp), angle, rate, period)
      call check_below(failure, maxval(abs(at%x - 1.1_wp*[sin(angle), -cos(angle)])), 1.0e-7_wp, 'motion')
      call inspect(ode, at, s)
      call check_close(failure, s%phi, 0.1_wp, 1.0e-10_wp, 'the violation is reported all along')
   end subroutine inconsistent_accepted

   !> A horizontal force that appears at t = 1/3: order 5 if the breakpoint is declared, lost if it is not.
   subroutine jump_of_load(failure)
      character(:), allocatable, intent(inout) :: failure
      type(particle_t) :: system
      real(wp) :: order

      system = new_particle(jumping_load, ratio=1.0_wp/3.0_wp)
      order = measured_order()
      call check_close(failure, order, 5.0_wp, 0.4_wp, 'order')
      system%declares_breakpoint = .false.
      order = measured_order()
      call check(failure, order < 3.0_wp, 'without the breakpoint the order is lost')

   contains

      function measured_order() result(value)
         real(wp) :: value
         type(state_t) :: at(4)
         type(error_t), allocatable :: error
         type(integration_result_t) :: result
         type(integration_options_t) :: options
         integer :: i

         do i = 1, 4
            options%step_control = 'fixed'
            options%first_step = 0.05_wp/2**i
            at(i) = state(0.0_wp, [1.0_wp, 0.0_wp], [0.0_wp, 0.0_wp])
            call simulate(system, at(i), 1.0_wp, result, error, options=options)
            call no_error(failure, error)
         end do
         value = log(norm2(at(1)%x - at(4)%x)/norm2(at(2)%x - at(4)%x))/log(2.0_wp)
      end function measured_order

   end subroutine jump_of_load

   subroutine wrong_sizes(failure)
      character(:), allocatable, intent(inout) :: failure
      type(particle_t) :: undefined
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error

      at = state(0.0_wp, [1.0_wp], [0.0_wp, 0.0_wp])
      call simulate(new_particle(bead), at, 1.0_wp, result, error)
      call check(failure, allocated(error), 'one coordinate for two')
      if (allocated(error)) deallocate (error)
      at = state(0.0_wp, [1.0_wp, 0.0_wp], [0.0_wp, 0.0_wp])
      call simulate(undefined, at, 1.0_wp, result, error)
      call check(failure, allocated(error), 'define was not called')
   end subroutine wrong_sizes

   subroutine bad_methods(failure)
      character(:), allocatable, intent(inout) :: failure
      type(method_t) :: methods(9)
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error
      integer :: i

      methods(1)%name = 'unheard'
      methods(2)%weight = 'unheard'
      methods(3)%stage_projection = 'unheard'
      methods(4)%state_projection = 'unheard'
      methods(5)%form = 'unheard'
      methods(6)%solver = 'unheard'
      methods(7)%projection_tolerance = 0.0_wp
      methods(8)%name = 'penalty'
      methods(9)%name = 'braun-goldfarb'
      methods(9)%dt = 0.0_wp
      do i = 1, size(methods)
         at = state(0.0_wp, [1.0_wp, 0.0_wp], [0.0_wp, 1.0_wp])
         call simulate(new_particle(bead), at, 1.0_wp, result, error, methods(i))
         call check(failure, allocated(error), 'a method that is not valid was taken')
         if (allocated(error)) deallocate (error)
      end do
   end subroutine bad_methods

end module test_constrained
