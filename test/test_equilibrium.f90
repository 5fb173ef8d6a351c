!> Static equilibrium: beams against closed forms and published values, and any other system.
module test_equilibrium
   use beams, only: slender_beam, swing_beam
   use mechanism_runs, only: run_t, run_text
   use systems, only: new_coupler, new_particle, two_rods
   use taut_kinds, only: wp
   use taut_error, only: error_t
   use taut_constrained_equilibrium, only: equilibrium, equilibrium_options_t, equilibrium_result_t
   use taut_constrained_system, only: state_t
   use taut_constrained_system_tables, only: velocity_name
   use taut_constrained_tangent, only: tangent_t
   use taut_model_beam, only: beam_t, new_beam
   use taut_model_beam_section, only: beam_section_t, new_section
   use taut_model_pendulum, only: new_pendulum, pendulum_t
   use taut_rotation, only: quaternion_of_axes
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_equilibrium

   real(wp), parameter :: pi = acos(-1.0_wp), zero(3) = 0.0_wp
   real(wp), parameter :: x(3) = [1.0_wp, 0.0_wp, 0.0_wp], y(3) = [0.0_wp, 1.0_wp, 0.0_wp], z(3) = [0.0_wp, 0.0_wp, 1.0_wp]

contains

   !> All tests of this module.
   function collect_equilibrium() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('a cantilever rolls up into a circle', roll_up), &
               new_test('small loads: beam theory, exact at the nodes', small_loads), &
               new_test('the elastica under a tip load', elastica), &
               new_test('the bend of 45 degrees', bend), &
               new_test('load factor and time lead to the same place', factor_and_time), &
               new_test('redundant supports share the reaction', redundant_supports), &
               new_test('a beam hung from two links', hung_beam), &
               new_test('a pendulum finds its lowest point', pendulum), &
               new_test('what is moved together and alone gives the same stiffness and damping', together), &
               new_test('what cannot be in equilibrium', impossible), &
               new_test('options that make no sense', bad_options)]
   end function collect_equilibrium

   !> A beam that hangs on two links and carries a mass on a joint, with springs and dampers between bodies; bent, and with reactions:
   !! columns by differences of one velocity each are those that are found together, and no entry is missed.
   subroutine together(failure)
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: run
      type(tangent_t) :: tangent
      type(state_t) :: at, near
      real(wp), allocatable :: a(:, :), c(:, :), d(:), f(:, :), k(:, :), lambda(:), rates(:)
      integer, allocatable :: free(:)
      integer :: i, j
      real(wp), parameter :: h = 1.0e-5_wp, signs(2) = [1.0_wp, -1.0_wp]
      character, parameter :: nl = new_line('a')

      call run_text('&mechanism / &gravity acceleration=0.0, 0.0, -9.81 /'//nl// &
                    '&beam name="n" from=0.0, 0.0, 0.0 to=0.72, 0.0, 0.0 elements=8 young=73e9 density=2700.0 thickness=1e-2 '// &
                    'width=5e-2 axis_2=0.0, 1.0, 0.0 damping=1e-3 /'//nl// &
                    '&point_mass name="middle" mass=0.5 position=0.36, 0.0, 0.0 /'//nl// &
                    '&body name="far" shape="rod" mass=1.0 from=0.36, 0.0, 0.5 to=0.5, 0.0, 0.5 /'//nl// &
                    '&joint name="pivot" type="spherical" body_1="n5" body_2="middle" /'//nl// &
                    '&joint name="link1" type="distance" point_1=0.0, 0.36, 0.0 body_2="n1" /'//nl// &
                    '&joint name="link2" type="distance" point_1=1.08, 0.36, 0.0 body_2="n9" /'//nl// &
                    '&spring name="s" body_1="far" body_2="middle" stiffness=1e4 damping=10.0 /'//nl// &
                    '&spring name="d" body_1="far" body_2="n2" preload=3.0 damping=20.0 /'//nl// &
                    '&integration t_end=1e-3 /'//nl, 1.0e-3_wp, 1.0e-6_wp, run, failure)
      if (allocated(failure)) return
      associate (model => run%model)
         call tangent%init(model)
         call check(failure, tangent%coupling%colors < model%n/2, 'some are moved together')
         at = run%at
         allocate (a(model%c, model%n), d(model%n), f(model%n, 2))
         d = 1.0e-2_wp*[(sin(real(i, wp)), i=1, model%n)]
         call model%displace(d, at%x)
         at%v = 0.0_wp
         lambda = [(100.0_wp*cos(real(i, wp)), i=1, model%c)]
         free = [(i, i=1, model%n)]
         call tangent%find(model, at, lambda, 0.0_wp)
         k = tangent%full(tangent%k%values, free)
         allocate (rates(size(tangent%k%values)))
         call tangent%damping(model, at, rates)
         c = tangent%full(rates, free)
         near = at
         do j = 1, model%n
            do i = 1, 2
               near%x = at%x
               d = 0.0_wp
               d(j) = signs(i)*h
               call model%displace(d, near%x)
               call model%normalize(near%x)
               call model%force(near, f(:, i))
               call model%jacobian(near, a)
               f(:, i) = f(:, i) - matmul(lambda, a)
            end do
            call check_below(failure, maxval(abs(k(:, j) + (f(:, 1) - f(:, 2))/(2.0_wp*h))), 1.0e-5_wp*maxval(abs(k(:, j))), &
                             'stiffness of '//trim(velocity_name(model, j)))
            near%x = at%x
            do i = 1, 2
               near%v(j) = signs(i)*h
               call model%force(near, f(:, i))
            end do
            near%v(j) = 0.0_wp
            call check_below(failure, maxval(abs(c(:, j) + (f(:, 1) - f(:, 2))/(2.0_wp*h))), &
                             1.0e-5_wp*maxval(abs(c(:, j))) + 1.0e-5_wp, 'damping of '//trim(velocity_name(model, j)))
         end do
      end associate
   end subroutine together

   !> A clamped slender beam with a load at its tip, EI = L = 1.
   subroutine cantilever(elements, force, moment, steps, at, failure, result)
      integer, intent(in) :: elements, steps
      real(wp), intent(in) :: force(3), moment(3)
      type(state_t), intent(out) :: at
      character(:), allocatable, intent(inout) :: failure
      type(equilibrium_result_t), intent(out), optional :: result
      type(beam_t) :: beam
      type(equilibrium_result_t) :: found
      type(equilibrium_options_t) :: options
      type(error_t), allocatable :: error

      beam = slender_beam(elements)
      call beam%clamp(1, error)
      call beam%add_load(elements + 1, force, moment, error)
      at = beam%reference_state()
      options%steps = steps
      call equilibrium(beam, at, found, error, options)
      call no_error(failure, error)
      if (present(result)) result = found
   end subroutine cantilever

   !> M = 2 pi EI/L. Elements have constant curvature and the length of their chord, so that the nodes are the corners of a
   !! regular polygon.
   subroutine roll_up(failure)
      character(:), allocatable, intent(inout) :: failure
      type(state_t) :: at
      type(equilibrium_result_t) :: result
      real(wp) :: center(2), radius
      integer :: i

      call cantilever(10, zero, 2.0_wp*pi*z, 8, at, failure, result)
      if (allocated(failure)) return
      call check_below(failure, maxval(abs(at%x(71:73))), 1.0e-9_wp, 'the tip is back at the clamp')
      call check_below(failure, maxval(abs(abs(at%x(74:77)) - [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp])), 1.0e-9_wp, 'turned once')
      radius = 0.1_wp/(2.0_wp*sin(pi/10.0_wp))
      ! The chord leaves the clamp at half of an element's angle.
      center = [0.0_wp, radius]
      do i = 1, 11
         call check_close(failure, norm2(at%x(7*i - 6:7*i - 5) - center), radius, 1.0e-9_wp, 'nodes are on a circle')
      end do
      call check_close(failure, result%lambda(6), 2.0_wp*pi, 1.0e-8_wp, 'the clamp holds the moment')
      call check_below(failure, maxval(abs(result%lambda(1:5))), 1.0e-8_wp, 'and nothing else')
   end subroutine roll_up

   !> w = P L^3/(3 EI) + P L/GA, for any number of elements, thanks to the shear correction.
   subroutine small_loads(failure)
      character(:), allocatable, intent(inout) :: failure
      type(state_t) :: at
      real(wp), parameter :: p = 1.0e-6_wp
      integer :: elements

      do elements = 1, 3
         call cantilever(elements, p*y, zero, 1, at, failure)
         if (allocated(failure)) return
         call check_close(failure, at%x(7*elements + 2)/p, 1.0_wp/3.0_wp + 1.0e-6_wp, 1.0e-8_wp, 'deflection in the plane')
         call check_close(failure, 2.0_wp*at%x(7*elements + 7)/p, 0.5_wp, 1.0e-8_wp, 'slope in the plane')
         call cantilever(elements, p*z, p*x, 1, at, failure)
         call check_close(failure, at%x(7*elements + 3)/p, 1.0_wp/3.0_wp + 1.0e-6_wp, 1.0e-8_wp, 'deflection out of the plane')
         call check_close(failure, 2.0_wp*at%x(7*elements + 6)/p, -0.5_wp, 1.0e-8_wp, 'slope out of the plane')
         call check_close(failure, 2.0_wp*at%x(7*elements + 5)/p, 1.0_wp, 1.0e-8_wp, 'twist')
      end do
   end subroutine small_loads

   !> P L^2/EI = 10. Source: K. Mattiasson, Numerical results from large deflection beam and frame problems analysed by means
   !! of elliptic integrals, Int. J. Numer. Methods Eng. 17 (1981) 145-153: w/L = 0.81061, u/L = 0.55500. The slender beam is
   !! not quite inextensible: 1e-5.
   subroutine elastica(failure)
      character(:), allocatable, intent(inout) :: failure
      type(state_t) :: at
      real(wp) :: tip(2, 3)
      integer :: i, n

      do i = 1, 3
         n = 3*2**i
         call cantilever(n, 10.0_wp*y, zero, 4, at, failure)
         if (allocated(failure)) return
         tip(:, i) = at%x(7*n + 1:7*n + 2)
      end do
      call check_close(failure, tip(2, 3), 0.81061_wp, 5.0e-4_wp, 'deflection')
      call check_close(failure, 1.0_wp - tip(1, 3), 0.55500_wp, 5.0e-4_wp, 'shortening')
      call check_close(failure, (4.0_wp*tip(2, 3) - tip(2, 2))/3.0_wp, 0.81061_wp, 5.0e-5_wp, 'deflection in the limit')
      call check_close(failure, 1.0_wp - (4.0_wp*tip(1, 3) - tip(1, 2))/3.0_wp, 0.55500_wp, 5.0e-5_wp, 'shortening in the limit')
      call check_close(failure, order(tip), 2.0_wp, 0.15_wp, 'order')
   end subroutine elastica

   !> Order of convergence from three meshes, each of twice the elements.
   function order(tip)
      real(wp), intent(in) :: tip(:, :)
      real(wp) :: order

      order = log(norm2(tip(:, 1) - tip(:, 2))/norm2(tip(:, 2) - tip(:, 3)))/log(2.0_wp)
   end function order

   !> An eighth of a circle of radius 100, of unit square section, loaded by 600 at its tip out of its plane.
   !!
   !! Source of the problem: K.J. Bathe, S. Bolourchi, Int. J. Numer. Methods Eng. 14 (1979) 961-986; of the values, with 8
   !! linear elements: J.C. Simo, L. Vu-Quoc, Comput. Methods Appl. Mech. Eng. 58 (1986) 79-116.
   subroutine bend(failure)
      character(:), allocatable, intent(inout) :: failure
      real(wp) :: tip(3, 4)
      integer :: i

      do i = 1, 4
         call bent_tip(2**(i + 1), tip(:, i))
         if (allocated(failure)) return
      end do
      call check_below(failure, maxval(abs(tip(:, 2) - [15.79_wp, 47.23_wp, 53.37_wp])), 0.2_wp, 'eight elements')
      call check_close(failure, order(tip(:, 1:3)), 2.0_wp, 0.2_wp, 'order')
      call check_close(failure, order(tip(:, 2:4)), 2.0_wp, 0.1_wp, 'order')

   contains

      subroutine bent_tip(elements, position)
         integer, intent(in) :: elements
         real(wp), intent(out) :: position(3)
         type(beam_t) :: beam
         type(beam_section_t) :: section
         type(state_t) :: at
         type(equilibrium_result_t) :: result
         type(equilibrium_options_t) :: options
         type(error_t), allocatable :: error
         real(wp) :: angle, k(6, 6), positions(3, elements + 1), orientations(4, elements + 1)
         real(wp), parameter :: diagonal(6) = 1.0e7_wp*[1.0_wp, 0.5_wp, 0.5_wp, 1.0_wp/12.0_wp, 1.0_wp/12.0_wp, 1.0_wp/12.0_wp]
         integer :: j

         do j = 0, elements
            angle = 0.25_wp*pi*j/elements
            positions(:, j + 1) = 100.0_wp*[1.0_wp - cos(angle), sin(angle), 0.0_wp]
            orientations(:, j + 1) = quaternion_of_axes([sin(angle), cos(angle), 0.0_wp], z)
         end do
         k = 0.0_wp
         do j = 1, 6
            k(j, j) = diagonal(j)
         end do
         call new_section(section, k, 1.0_wp, [1.0_wp, 1.0_wp, 1.0_wp], error)
         call new_beam(beam, positions, orientations, section, error)
         call beam%clamp(1, error)
         call beam%add_load(elements + 1, 600.0_wp*z, zero, error)
         at = beam%reference_state()
         options%steps = 6
         call equilibrium(beam, at, result, error, options)
         call no_error(failure, error)
         position = at%x(7*elements + 1:7*elements + 3)
      end subroutine bent_tip

   end subroutine bend

   subroutine factor_and_time(failure)
      character(:), allocatable, intent(inout) :: failure
      type(beam_t) :: beam
      type(state_t) :: by_factor, by_time
      type(equilibrium_result_t) :: result
      type(equilibrium_options_t) :: options
      type(error_t), allocatable :: error
      integer :: i

      beam = slender_beam(4)
      call beam%add_load(5, 2.0_wp*y + z, 0.5_wp*x, error, [0.0_wp, 2.0_wp], [0.0_wp, 1.0_wp])
      ! Clamped by blocking velocities instead of constraints.
      options%blocked = [(i, i=1, 6)]
      options%steps = 3
      by_factor = beam%reference_state()
      by_factor%t = 2.0_wp
      call equilibrium(beam, by_factor, result, error, options)
      call no_error(failure, error)
      call check(failure, result%steps >= 3 .and. result%iterations > 3 .and. size(result%lambda) == 0, 'steps')
      options%parameter = 'time'
      options%t_end = 2.0_wp
      by_time = beam%reference_state()
      call equilibrium(beam, by_time, result, error, options)
      call no_error(failure, error)
      call check_close(failure, by_time%t, 2.0_wp, 0.0_wp, 'the time is reached')
      call check(failure, by_time%x(30) > 0.3_wp, 'it bends')
      call check_below(failure, maxval(abs(by_time%x - by_factor%x)), 1.0e-8_wp, 'the same place')
   end subroutine factor_and_time

   !> A clamp and a pin on one node: the pin's rows are there twice and take half each.
   subroutine redundant_supports(failure)
      character(:), allocatable, intent(inout) :: failure
      type(beam_t) :: beam
      type(state_t) :: at
      type(equilibrium_result_t) :: result
      type(error_t), allocatable :: error

      beam = slender_beam(4)
      call beam%clamp(1, error)
      call beam%pin(1, error)
      call beam%add_load(5, 0.3_wp*y - 0.2_wp*z, zero, error)
      at = beam%reference_state()
      call equilibrium(beam, at, result, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      call check(failure, result%rank == 6, 'six rows of nine count')
      call check_close(failure, result%lambda(2), 0.15_wp, 1.0e-9_wp, 'half the force')
      call check_close(failure, result%lambda(8), 0.15_wp, 1.0e-9_wp, 'the other half')
      call check_close(failure, result%lambda(3), -0.1_wp, 1.0e-9_wp, 'half the other force')
      call check_below(failure, result%force_left, 1.0e-8_wp, 'forces balance')
   end subroutine redundant_supports

   !> The beam of the swing under gravity, on two links at 45 degrees, which carry the weight.
   subroutine hung_beam(failure)
      character(:), allocatable, intent(inout) :: failure
      type(beam_t) :: beam
      type(state_t) :: at
      type(equilibrium_result_t) :: result
      type(equilibrium_options_t) :: options
      type(error_t), allocatable :: error
      real(wp) :: n(2, 2)
      integer :: i

      beam = swing_beam(4)
      beam%gravity = [0.0_wp, -0.5_wp, 0.0_wp]
      call beam%link(1, [-0.36_wp, 0.36_wp, 0.0_wp], 0.36_wp*sqrt(2.0_wp), error)
      call beam%link(5, [1.08_wp, 0.36_wp, 0.0_wp], 0.36_wp*sqrt(2.0_wp), error)
      ! In the plane only.
      options%blocked = [([6*i - 3, 6*i - 2, 6*i - 1], i=1, 5)]
      options%steps = 5
      at = beam%reference_state()
      call equilibrium(beam, at, result, error, options)
      call no_error(failure, error)
      if (allocated(failure)) return
      n(:, 1) = [at%x(1) + 0.36_wp, at%x(2) - 0.36_wp]/(0.36_wp*sqrt(2.0_wp))
      n(:, 2) = [at%x(29) - 1.08_wp, at%x(30) - 0.36_wp]/(0.36_wp*sqrt(2.0_wp))
      call check(failure, all(result%lambda > 0.0_wp), 'both links are under tension')
      call check_below(failure, maxval(abs(matmul(n, result%lambda) + [0.0_wp, 0.5_wp*sum(beam%m)])), 1.0e-9_wp, 'the weight')
      call check_below(failure, result%phi_left, 1.0e-10_wp, 'the links keep their lengths')
   end subroutine hung_beam

   subroutine pendulum(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(state_t) :: at
      type(equilibrium_result_t) :: result
      type(error_t), allocatable :: error
      type(equilibrium_options_t) :: options

      call new_pendulum(model, 2.0_wp, 0.7_wp, 9.81_wp, 3, error)
      allocate (at%x, source=[0.2_wp, -0.6_wp])
      call equilibrium(model, at, result, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      call check_below(failure, maxval(abs(at%x - [0.0_wp, -0.7_wp])), 1.0e-10_wp, 'the lowest point')
      call check_close(failure, sum(result%lambda), 2.0_wp*9.81_wp, 1.0e-9_wp, 'the weight')
      call check(failure, result%rank == 1, 'one row of three counts')
      ! With the horizontal blocked it goes straight down, or up.
      at%x = [0.2_wp, -0.6_wp]
      options%blocked = [1]
      call equilibrium(model, at, result, error, options)
      call no_error(failure, error)
      call check_close(failure, at%x(2), -sqrt(0.45_wp), 1.0e-10_wp, 'straight down')
   end subroutine pendulum

   subroutine impossible(failure)
      character(:), allocatable, intent(inout) :: failure
      type(beam_t) :: beam
      type(state_t) :: at
      type(equilibrium_result_t) :: result
      type(error_t), allocatable :: error

      beam = slender_beam(2)
      call beam%add_load(3, y, zero, error)
      at = beam%reference_state()
      call equilibrium(beam, at, result, error)
      call expect('nothing resists')
      at%x = [1.0_wp, 0.1_wp]
      call equilibrium(new_particle(two_rods, ratio=2.0_wp), at, result, error)
      call expect('inconsistent')
      at%x = [1.0_wp, 0.1_wp, 0.0_wp]
      call equilibrium(new_particle(two_rods), at, result, error)
      call expect('coordinates')
      at%x = [0.1_wp, -0.9_wp, 0.2_wp]
      call equilibrium(new_coupler(3), at, result, error)
      call no_error(failure, error)
      call check_below(failure, maxval(abs(at%x - [0.0_wp, -1.0_wp, 0.0_wp])), 1.0e-6_wp, 'a coupler, redundant where it is level')

   contains

      subroutine expect(text)
         character(*), intent(in) :: text

         call check(failure, allocated(error), 'an error about '//text)
         if (.not. allocated(error)) return
         call check(failure, index(error%line(), text) > 0, 'instead of '//text//': '//error%line())
         deallocate (error)
      end subroutine expect

   end subroutine impossible

   subroutine bad_options(failure)
      character(:), allocatable, intent(inout) :: failure
      type(equilibrium_options_t) :: options

      options%steps = 0
      call expect('steps')
      options = equilibrium_options_t(tolerance=-1.0_wp)
      call expect('tolerance')
      options = equilibrium_options_t(parameter='load')
      call expect('"load"')
      options = equilibrium_options_t(blocked=[3])
      call expect('no velocity 3')
      options = equilibrium_options_t(blocked=[1, 2])
      call expect('all velocities are blocked')

   contains

      subroutine expect(text)
         character(*), intent(in) :: text
         type(state_t) :: at
         type(equilibrium_result_t) :: result
         type(error_t), allocatable :: error

         allocate (at%x, source=[0.0_wp, -1.0_wp])
         call equilibrium(new_particle(two_rods), at, result, error, options)
         call check(failure, allocated(error), 'an error about '//text)
         if (.not. allocated(error)) return
         call check(failure, index(error%line(), text) > 0, 'instead of '//text//': '//error%line())
      end subroutine expect

   end subroutine bad_options

end module test_equilibrium
