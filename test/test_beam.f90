!> The finite-volume beam: strains, gradients, momentum, inertia, constraints and loads.
module test_beam
   use beams, only: coupled_section, deformed, slender_beam, swing_beam, turned
   use taut_kinds, only: wp
   use taut_error, only: error_t
   use taut_constrained_simulate, only: simulate
   use taut_constrained_system, only: state_t
   use taut_constrained_verify, only: finding_t, verify
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_lapack, only: dpotrf, dpotrs
   use taut_model_beam, only: beam_t, new_beam, straight_nodes
   use taut_model_beam_element, only: beam_element_t, element_energy, element_strain, internal_loads, new_element
   use taut_model_beam_section, only: beam_section_t, corrected_stiffness, new_section, rectangular_section
   use taut_model_dead_load, only: dead_load_t
   use taut_model_nodes, only: nodal_system_t
   use taut_ode_options, only: integration_options_t, integration_result_t
   use taut_ode_status, only: status_reached_end
   use taut_rotation, only: cross, quaternion_normalized, quaternion_of_vector, quaternion_product, rotate, rotate_back
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_beam

   !> A rigid body: one node.
   type, extends(nodal_system_t) :: body_t
   contains
      procedure :: force => body_force
   end type body_t

   real(wp), parameter :: origin(3) = 0.0_wp, at_rest(6) = 0.0_wp, identity(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
   real(wp), parameter :: axes(3, 3) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [3, 3])

contains

   !> All tests of this module.
   function collect_beam() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('a rectangular section', rectangle), &
               new_test('sections that make no sense', bad_sections), &
               new_test('the shear correction', shear_correction), &
               new_test('rigid motions do not strain', rigid_motion), &
               new_test('constant strains are exact', constant_strain), &
               new_test('in the plane forces and moments are the gradient of the energy', planar_gradient), &
               new_test('in space forces are, moments up to the square of the length', spatial_gradient), &
               new_test('internal forces leave both momenta alone', momentum), &
               new_test('nothing leaves the plane', stays_in_plane), &
               new_test('damping: the rate of the strain, and a loss', damping), &
               new_test('inertia by slices', inertia), &
               new_test('all constraints, full inertia and loads pass the check', passes_check), &
               new_test('histories of loads', histories), &
               new_test('beams that make no sense', bad_beams), &
               new_test('a rigid body turns as Euler says', euler_top), &
               new_test('a free flight keeps momenta and energy', free_flight)]
   end function collect_beam

   subroutine rectangle(failure)
      character(:), allocatable, intent(inout) :: failure
      type(beam_section_t) :: section
      type(error_t), allocatable :: error

      call rectangular_section(section, 200.0_wp, 0.25_wp, 10.0_wp, 1.0_wp, 2.0_wp, error)
      call no_error(failure, error)
      call check_close(failure, section%stiffness(1, 1), 400.0_wp, 1.0e-10_wp, 'EA')
      call check_close(failure, section%stiffness(2, 2), 400.0_wp/3.0_wp, 1.0e-10_wp, 'shear 2')
      call check_close(failure, section%stiffness(3, 3), 400.0_wp/3.0_wp, 1.0e-10_wp, 'shear 3')
      ! Timoshenko and Goodier's table: 0.229 for a ratio of 2, 0.1406 for a square.
      call check_close(failure, section%stiffness(4, 4), 80.0_wp*0.229_wp*2.0_wp, 0.08_wp, 'GJ')
      call check_close(failure, section%stiffness(5, 5), 200.0_wp*8.0_wp/12.0_wp, 1.0e-10_wp, 'EI about 2')
      call check_close(failure, section%stiffness(6, 6), 200.0_wp*2.0_wp/12.0_wp, 1.0e-10_wp, 'EI about 3')
      call check_close(failure, section%mass, 20.0_wp, 1.0e-12_wp, 'mass')
      call check_below(failure, maxval(abs(section%inertia - 10.0_wp*[10.0_wp, 8.0_wp, 2.0_wp]/12.0_wp)), 1.0e-12_wp, 'inertia')
      call rectangular_section(section, 2.0_wp, 0.0_wp, 10.0_wp, 1.0_wp, 1.0_wp, error)
      call check_close(failure, section%stiffness(4, 4), 0.140577_wp, 1.0e-6_wp, 'GJ of a square')
   end subroutine rectangle

   subroutine bad_sections(failure)
      character(:), allocatable, intent(inout) :: failure
      type(beam_section_t) :: section
      real(wp) :: k(6, 6)
      real(wp), parameter :: one(3) = 1.0_wp
      type(error_t), allocatable :: error

      call rectangular_section(section, -1.0_wp, 0.3_wp, 1.0_wp, 1.0_wp, 1.0_wp, error)
      call expect('Young''s modulus')
      call rectangular_section(section, 1.0_wp, 0.6_wp, 1.0_wp, 1.0_wp, 1.0_wp, error)
      call expect('Poisson''s ratio')
      call rectangular_section(section, 1.0_wp, 0.3_wp, 1.0_wp, 0.0_wp, 1.0_wp, error)
      call expect('side along axis 2')
      section = coupled_section()
      k = section%stiffness
      k(6, 6) = 0.0_wp
      call new_section(section, k, 1.0_wp, one, error)
      call expect('not positive definite')
      section = coupled_section()
      k = section%stiffness
      k(1, 2) = k(1, 1) + k(2, 2)
      call new_section(section, k, 1.0_wp, one, error)
      call expect('not symmetric')
      k(2, 1) = k(1, 2)
      call new_section(section, k, 1.0_wp, one, error)
      call expect('not positive definite')
      section = coupled_section()
      k = section%stiffness
      call new_section(section, k, 0.0_wp, one, error)
      call expect('mass per unit length')

   contains

      subroutine expect(text)
         character(*), intent(in) :: text

         call check(failure, allocated(error), 'an error about '//text)
         if (.not. allocated(error)) return
         call check(failure, index(error%line(), text) > 0, 'instead of '//text//': '//error%line())
         deallocate (error)
      end subroutine expect

   end subroutine bad_sections

   !> Uncoupled: 1/GA* = 1/GA + l^2/(12 EI), each shear with the bending in its own plane. In general: the compliance changes
   !! in the shears only.
   subroutine shear_correction(failure)
      character(:), allocatable, intent(inout) :: failure
      type(beam_section_t) :: section
      type(error_t), allocatable :: error
      real(wp) :: after(6, 6), before(6, 6), change(6, 6), k(6, 6)
      real(wp), parameter :: l = 0.4_wp

      call rectangular_section(section, 200.0_wp, 0.25_wp, 10.0_wp, 0.1_wp, 0.2_wp, error)
      call corrected_stiffness(section, l, k)
      associate (s => section%stiffness)
         call check_close(failure, 1.0_wp/k(2, 2), 1.0_wp/s(2, 2) + l**2/(12.0_wp*s(6, 6)), 1.0e-12_wp/k(2, 2), 'in the plane 1-2')
         call check_close(failure, 1.0_wp/k(3, 3), 1.0_wp/s(3, 3) + l**2/(12.0_wp*s(5, 5)), 1.0e-12_wp/k(3, 3), 'in the plane 1-3')
         call check_below(failure, maxval(abs([k(1, 1) - s(1, 1), k(4, 4) - s(4, 4), k(5, 5) - s(5, 5), k(6, 6) - s(6, 6)])), &
                          1.0e-12_wp*s(1, 1), 'no other')
         call check_below(failure, sum(abs(k)) - k(1, 1) - k(2, 2) - k(3, 3) - k(4, 4) - k(5, 5) - k(6, 6), &
                          4.0_wp*spacing(sum(abs(k))), 'no coupling')
      end associate
      section = coupled_section()
      call corrected_stiffness(section, l, k)
      call check_below(failure, maxval(abs(k - transpose(k))), 0.0_wp, 'symmetric')
      after = inverse(k)
      before = inverse(section%stiffness)
      change = 0.0_wp
      change(2, 2) = before(6, 6)
      change(3, 3) = before(5, 5)
      change(2, 3) = -before(5, 6)
      change(3, 2) = -before(5, 6)
      call check_below(failure, maxval(abs(after - before - l**2/12.0_wp*change)), 1.0e-15_wp, 'what is added')

   contains

      function inverse(matrix)
         real(wp), intent(in) :: matrix(6, 6)
         real(wp) :: inverse(6, 6), factor(6, 6)
         integer :: i, info

         factor = matrix
         inverse = 0.0_wp
         do i = 1, 6
            inverse(i, i) = 1.0_wp
         end do
         call dpotrf('L', 6, factor, 6, info)
         call dpotrs('L', 6, 6, factor, 6, inverse, 6, info)
      end function inverse

   end subroutine shear_correction

   subroutine rigid_motion(failure)
      character(:), allocatable, intent(inout) :: failure
      type(beam_t) :: beam
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp), allocatable :: positions(:, :), orientations(:, :)
      real(wp) :: f(6, 6), q(4), before(6), after(6)
      integer :: i

      ! An irregular chain: reference orientations that follow nothing in particular.
      call straight_nodes(origin, [1.0_wp, 2.0_wp, -0.5_wp], 5, axes(:, 3), positions, orientations)
      do i = 1, 6
         positions(:, i) = positions(:, i) + 0.1_wp*[sin(2.0_wp*i), cos(3.0_wp*i), sin(5.0_wp*i)]
         orientations(:, i) = quaternion_product(orientations(:, i), &
                                                  quaternion_of_vector(0.3_wp*[sin(7.0_wp*i), 0.5_wp, cos(real(i, wp))]))
      end do
      call new_beam(beam, positions, orientations, coupled_section(), error)
      call no_error(failure, error)
      at = beam%reference_state()
      call beam%internal_forces(at, f)
      call check_below(failure, maxval(abs(f)), 0.0_wp, 'the reference is free of force')
      q = quaternion_of_vector([2.0_wp, -1.0_wp, 0.7_wp])
      at%x = turned(beam, beam%x_reference, q, [3.0_wp, 4.0_wp, 5.0_wp])
      call beam%internal_forces(at, f)
      call check_below(failure, maxval(abs(f)), 1.0e-13_wp, 'a rigid motion is free of force')
      call check_below(failure, beam%strain_energy(at%x), 1.0e-26_wp, 'and of energy')
      at%x(4:7) = -at%x(4:7)
      call beam%internal_forces(at, f)
      call check_below(failure, maxval(abs(f)), 1.0e-13_wp, 'the sign of a quaternion does not matter')
      do i = 1, 5
         before = beam%strain(deformed(beam, 0.3_wp, .false.), i)
         after = beam%strain(turned(beam, deformed(beam, 0.3_wp, .false.), q, [3.0_wp, 4.0_wp, 5.0_wp]), i)
         call check_below(failure, maxval(abs(after - before)), 2.0e-14_wp, 'strains do not see a rigid motion')
      end do
   end subroutine rigid_motion

   !> A helix of constant strains: every element, however long, has these strains and the exact resultants.
   subroutine constant_strain(failure)
      character(:), allocatable, intent(inout) :: failure
      type(beam_element_t) :: element
      real(wp), parameter :: kappa(3) = [0.4_wp, -0.7_wp, 1.1_wp], l = 0.9_wp
      real(wp) :: f(3), m_1(3), m_2(3), q_1(4), q_2(4), half(4), x_1(3), x_2(3), strain(6), expected(6)
      type(beam_section_t) :: section

      section = coupled_section()
      element = new_element(origin, identity, l*axes(:, 1), identity, section%stiffness, 0.0_wp)
      expected = [0.02_wp, 0.01_wp, -0.03_wp, kappa]
      q_1 = quaternion_of_vector([0.3_wp, 1.0_wp, -2.0_wp])
      half = quaternion_product(q_1, quaternion_of_vector(0.5_wp*l*kappa))
      q_2 = quaternion_product(q_1, quaternion_of_vector(l*kappa))
      x_1 = [1.0_wp, 2.0_wp, 3.0_wp]
      x_2 = x_1 + l*rotate(half, axes(:, 1) + expected(1:3))
      strain = element_strain(element, x_1, q_1, x_2, q_2)
      call check_below(failure, maxval(abs(strain - expected)), 2.0e-15_wp, 'strains')
      call internal_loads(element, x_1, q_1, at_rest, x_2, q_2, at_rest, f, m_1, m_2)
      associate (load => matmul(section%stiffness, expected))
         call check_below(failure, maxval(abs(rotate_back(half, f) - load(1:3))), 1.0e-13_wp, 'force at the cut')
         call check_below(failure, maxval(abs(rotate_back(half, 0.5_wp*(m_1 - m_2)) - load(4:6))), 1.0e-13_wp, 'moment at the cut')
      end associate
      call check_below(failure, maxval(abs(m_1 + m_2 - cross(x_2 - x_1, f))), 1.0e-13_wp, 'moments balance the force')
   end subroutine constant_strain

   !> Minus the gradient of the energy along the displacements of both nodes, by differences of fourth order.
   subroutine gradient(element, x_1, q_1, x_2, q_2, g)
      type(beam_element_t), intent(in) :: element
      real(wp), intent(in) :: x_1(3), q_1(4), x_2(3), q_2(4)
      real(wp), intent(out) :: g(12)
      real(wp), parameter :: h = 1.0e-3_wp
      integer :: i

      do i = 1, 12
         g(i) = -(8.0_wp*(energy(h) - energy(-h)) - (energy(2.0_wp*h) - energy(-2.0_wp*h)))/(12.0_wp*h)
      end do

   contains

      !> With one displacement or global rotation.
      function energy(s)
         real(wp), intent(in) :: s
         real(wp) :: energy, d(12)

         d = 0.0_wp
         d(i) = s
         energy = element_energy(element, x_1 + d(1:3), quaternion_product(quaternion_of_vector(d(4:6)), q_1), &
                                 x_2 + d(7:9), quaternion_product(quaternion_of_vector(d(10:12)), q_2))
      end function energy

   end subroutine gradient

   !> Round-off of the forces is tested against forces in closed form: the differences carry 1e-11 or so themselves.
   subroutine planar_gradient(failure)
      character(:), allocatable, intent(inout) :: failure
      type(beam_element_t) :: element
      type(beam_section_t) :: section
      type(error_t), allocatable :: error
      real(wp) :: exact(12), f(3), g(12), l, m_1(3), m_2(3), q_1(4), q_2(4), x_1(3), x_2(3)
      real(wp) :: a, c, s, d(2), e(2), k(6, 6), normal, shear, bending
      real(wp), parameter :: phi_1 = 0.4_wp, phi_2 = 1.3_wp

      call rectangular_section(section, 20.0_wp, 0.3_wp, 1.0_wp, 1.0_wp, 1.5_wp, error)
      k = section%stiffness
      l = 0.8_wp
      element = new_element(origin, identity, l*axes(:, 1), identity, k, 0.0_wp)
      x_1 = [0.1_wp, -0.2_wp, 0.0_wp]
      x_2 = x_1 + [0.6_wp, 0.7_wp, 0.0_wp]
      q_1 = quaternion_of_vector(phi_1*axes(:, 3))
      q_2 = quaternion_of_vector(phi_2*axes(:, 3))
      call internal_loads(element, x_1, q_1, at_rest, x_2, q_2, at_rest, f, m_1, m_2)
      call gradient(element, x_1, q_1, x_2, q_2, g)
      call check_below(failure, maxval(abs(pick(g) - pick([f, m_1, -f, m_2]))), 1.0e-9_wp, 'against differences')
      ! U = l/2 (EA e1^2 + GA e2^2 + EI k^2), e = R(a)^T d/l - {1; 0}, a = (phi_1 + phi_2)/2, k = (phi_2 - phi_1)/l.
      a = 0.5_wp*(phi_1 + phi_2)
      c = cos(a)
      s = sin(a)
      d = [0.6_wp, 0.7_wp]
      e = [c*d(1) + s*d(2), -s*d(1) + c*d(2)]/l
      normal = k(1, 1)*(e(1) - 1.0_wp)
      shear = k(2, 2)*e(2)
      bending = k(6, 6)*(phi_2 - phi_1)/l
      exact = 0.0_wp
      exact(1:2) = [c*normal - s*shear, s*normal + c*shear]
      exact(7:8) = -exact(1:2)
      exact(6) = bending - 0.5_wp*l*(normal*e(2) - shear*e(1))
      exact(12) = -bending - 0.5_wp*l*(normal*e(2) - shear*e(1))
      call check_below(failure, maxval(abs(exact - [f, m_1, -f, m_2])), 4.0_wp*spacing(maxval(abs(exact))), 'to round-off')

   contains

      !> What is in the plane.
      pure function pick(all) result(some)
         real(wp), intent(in) :: all(12)
         real(wp) :: some(6)

         some = all([1, 2, 6, 7, 8, 12])
      end function pick

   end subroutine planar_gradient

   !> The same curvature on shorter and shorter elements.
   subroutine spatial_gradient(failure)
      character(:), allocatable, intent(inout) :: failure
      type(beam_element_t) :: element
      type(beam_section_t) :: section
      real(wp) :: f(3), g(12), l, m_1(3), m_2(3), mismatch(3), q_1(4), q_2(4), x_1(3), x_2(3)
      integer :: i

      section = coupled_section()
      do i = 1, 3
         l = 0.8_wp/2**(i - 1)
         element = new_element(origin, identity, l*axes(:, 1), identity, section%stiffness, 0.0_wp)
         q_1 = quaternion_of_vector([0.2_wp, 0.5_wp, -0.4_wp])
         q_2 = quaternion_product(q_1, quaternion_of_vector(l*[0.5_wp, 0.6_wp, -0.4_wp]))
         x_1 = [0.3_wp, 0.2_wp, 0.1_wp]
         x_2 = x_1 + l*rotate(q_1, [1.1_wp, 0.1_wp, -0.05_wp])
         call internal_loads(element, x_1, q_1, at_rest, x_2, q_2, at_rest, f, m_1, m_2)
         call gradient(element, x_1, q_1, x_2, q_2, g)
         call check_below(failure, maxval(abs(g(1:3) - f)), 1.0e-9_wp, 'force on node 1')
         call check_below(failure, maxval(abs(g(7:9) + f)), 1.0e-9_wp, 'force on node 2')
         mismatch(i) = maxval(abs([g(4:6) - m_1, g(10:12) - m_2]))/maxval(abs([m_1, m_2]))
      end do
      call check(failure, mismatch(1) > 1.0e-4_wp .and. mismatch(1) < 2.0e-2_wp, 'the mismatch is there and is small')
      call check_close(failure, log(mismatch(2)/mismatch(3))/log(2.0_wp), 2.0_wp, 0.15_wp, 'its order')
   end subroutine spatial_gradient

   subroutine momentum(failure)
      character(:), allocatable, intent(inout) :: failure
      type(beam_t) :: beam
      type(state_t) :: at
      real(wp) :: about(3), f(6, 9), force(3), moment(3)
      integer :: i

      beam = swing_beam(8)
      at = beam%reference_state()
      at%x = deformed(beam, 0.01_wp, .false.)
      call beam%internal_forces(at, f)
      force = 0.0_wp
      moment = 0.0_wp
      about = [0.3_wp, -0.1_wp, 0.2_wp]
      do i = 1, 9
         force = force + f(1:3, i)
         moment = moment + f(4:6, i) + cross(at%x(7*i - 6:7*i - 4) - about, f(1:3, i))
      end do
      call check(failure, maxval(abs(f)) > 1.0e3_wp, 'there are forces')
      call check_below(failure, maxval(abs(force)), 8.0_wp*spacing(maxval(abs(f))), 'forces sum to zero')
      call check_below(failure, maxval(abs(moment)), 8.0_wp*spacing(maxval(abs(f))), 'moments balance about any point')
   end subroutine momentum

   subroutine stays_in_plane(failure)
      character(:), allocatable, intent(inout) :: failure
      type(beam_t) :: beam
      type(state_t) :: at
      type(integration_result_t) :: result
      type(integration_options_t) :: options
      type(error_t), allocatable :: error
      real(wp) :: f(30)

      beam = swing_beam(4)
      at = beam%reference_state()
      at%x = deformed(beam, 0.05_wp, .true.)
      call beam%force(at, f)
      call check_below(failure, maxval(abs([f(3::6), f(4::6), f(5::6)])), 0.0_wp, 'no force out of the plane')
      call beam%link(1, [0.0_wp, 0.36_wp, 0.0_wp], 0.36_wp, error)
      call beam%link(5, [1.08_wp, 0.36_wp, 0.0_wp], 0.36_wp*sqrt(2.0_wp), error)
      call beam%add_load(3, axes(:, 1), origin, error, [0.0_wp, 0.128_wp, 0.256_wp], [0.0_wp, 2.0_wp, 0.0_wp])
      at = beam%reference_state()
      options%rtol = 1.0e-4_wp
      options%atol = 1.0e-6_wp
      call simulate(beam, at, 0.02_wp, result, error, options=options)
      call no_error(failure, error)
      call check(failure, result%status == status_reached_end, 'the end is reached')
      call check(failure, abs(at%x(15) - 0.36_wp) > 1.0e-6_wp, 'it moves')
      call check_below(failure, maxval(abs(at%v(3::6))) + maxval(abs(at%v(4::6))) + maxval(abs(at%v(5::6))), 0.0_wp, &
                       'only in the plane')
      call check_below(failure, maxval(abs(at%x(3::7))) + maxval(abs(at%x(5::7))) + maxval(abs(at%x(6::7))), 0.0_wp, &
                       'and stays in it')
   end subroutine stays_in_plane

   subroutine damping(failure)
      character(:), allocatable, intent(inout) :: failure
      type(beam_element_t) :: elastic, viscous
      type(beam_section_t) :: section
      real(wp) :: d, f(3), m_1(3), m_2(3), f_0(3), m_10(3), m_20(3), power, q_1(4), q_2(4), v_1(6), v_2(6), x_1(3), x_2(3)
      real(wp), parameter :: h = 1.0e-4_wp, tau = 0.3_wp, l = 0.4_wp
      real(wp) :: expected(6), load(6), half(4)

      section = coupled_section()
      elastic = new_element(origin, identity, l*axes(:, 1), identity, section%stiffness, 0.0_wp)
      viscous = new_element(origin, identity, l*axes(:, 1), identity, section%stiffness, tau)
      q_1 = quaternion_of_vector([0.2_wp, 0.5_wp, -0.4_wp])
      q_2 = quaternion_product(q_1, quaternion_of_vector([0.3_wp, 0.2_wp, -0.4_wp]))
      x_1 = [0.3_wp, 0.2_wp, 0.1_wp]
      x_2 = x_1 + l*rotate(q_1, [1.1_wp, 0.1_wp, -0.05_wp])
      v_1 = [0.4_wp, -0.2_wp, 0.7_wp, 0.3_wp, 0.9_wp, -0.5_wp]
      v_2 = [-0.3_wp, 0.6_wp, 0.1_wp, 1.2_wp, -0.4_wp, 0.8_wp]
      call internal_loads(elastic, x_1, q_1, v_1, x_2, q_2, v_2, f_0, m_10, m_20)
      call internal_loads(viscous, x_1, q_1, v_1, x_2, q_2, v_2, f, m_1, m_2)
      d = 1.0_wp/(12.0_wp*h)
      expected = d*(8.0_wp*(strain_at(h) - strain_at(-h)) - strain_at(2.0_wp*h) + strain_at(-2.0_wp*h))
      half = quaternion_normalized(q_1 + q_2)
      load(1:3) = rotate_back(half, f - f_0)
      load(4:6) = rotate_back(half, 0.5_wp*(m_1 - m_2 - m_10 + m_20))
      call check_below(failure, maxval(abs(load - tau*matmul(section%stiffness, expected))), 1.0e-9_wp, 'the rate of the strain')
      power = dot_product(f - f_0, v_1(1:3) - v_2(1:3)) + dot_product(m_1 - m_10, rotate(q_1, v_1(4:6))) + &
              dot_product(m_2 - m_20, rotate(q_2, v_2(4:6)))
      call check(failure, power < 0.0_wp, 'energy is lost')
      ! A rigid motion strains nothing.
      v_1(1:3) = cross([0.3_wp, 0.9_wp, -0.5_wp], x_1)
      v_2(1:3) = cross([0.3_wp, 0.9_wp, -0.5_wp], x_2)
      v_1(4:6) = rotate_back(q_1, [0.3_wp, 0.9_wp, -0.5_wp])
      v_2(4:6) = rotate_back(q_2, [0.3_wp, 0.9_wp, -0.5_wp])
      call internal_loads(viscous, x_1, q_1, v_1, x_2, q_2, v_2, f, m_1, m_2)
      call check_below(failure, maxval(abs([f - f_0, m_1 - m_10, m_2 - m_20])), 1.0e-13_wp, 'none in a rigid motion')

   contains

      function strain_at(s) result(strain)
         real(wp), intent(in) :: s
         real(wp) :: strain(6)

         strain = element_strain(elastic, x_1 + s*v_1(1:3), quaternion_product(q_1, quaternion_of_vector(s*v_1(4:6))), &
                                 x_2 + s*v_2(1:3), quaternion_product(q_2, quaternion_of_vector(s*v_2(4:6))))
      end function strain_at

   end subroutine damping

   !> The beam of the swing: what a slice has, and that the total is that of a rod of nodes.
   subroutine inertia(failure)
      character(:), allocatable, intent(inout) :: failure
      type(beam_t) :: beam
      type(block_diagonal_t) :: m
      real(wp), parameter :: l = 0.18_wp, line = 2700.0_wp*5.0e-6_wp, rho_i3 = 2700.0_wp*5.0e-3_wp*1.0e-9_wp/12.0_wp, &
                             rho_i2 = 2700.0_wp*1.0e-3_wp*125.0e-9_wp/12.0_wp
      real(wp) :: k(30, 30)
      integer :: i

      beam = swing_beam(4)
      call check(failure, all(beam%mass_blocks == 1), 'M is diagonal')
      call m%init(beam%mass_blocks)
      call beam%mass(beam%reference_state(), m)
      k = m%dense()
      call check_close(failure, k(1, 1), line*l/2.0_wp, 1.0e-15_wp, 'an end has half')
      call check_close(failure, k(8, 8), line*l, 1.0e-15_wp, 'a slice')
      call check_close(failure, k(15, 15), line*l + 0.5_wp, 1.0e-15_wp, 'mid-span')
      call check_close(failure, k(10, 10), (rho_i2 + rho_i3)*l, 1.0e-18_wp, 'about the axis')
      call check_close(failure, k(11, 11), rho_i2*l + line*l**3/12.0_wp, 1.0e-18_wp, 'about 2')
      call check_close(failure, k(12, 12), rho_i3*l + line*l**3/12.0_wp, 1.0e-18_wp, 'about 3')
      call check_close(failure, k(6, 6), 0.5_wp*k(12, 12), 1.0e-18_wp, 'an end about 3')
      call check_close(failure, sum([(k(6*i - 5, 6*i - 5), i=1, 5)]), line*0.72_wp + 0.5_wp, 1.0e-15_wp, 'total mass')
   end subroutine inertia

   !> One of each kind, at a place that meets none of them, in motion.
   subroutine passes_check(failure)
      character(:), allocatable, intent(inout) :: failure
      type(beam_t) :: beam
      type(state_t) :: at
      type(finding_t), allocatable :: findings(:)
      type(error_t), allocatable :: error
      integer :: i

      beam = slender_beam(3)
      beam%gravity = [0.1_wp, -9.0_wp, 0.3_wp]
      call beam%add_mass(2, 3.0_wp, error, &
                         reshape([2.0_wp, 0.1_wp, 0.2_wp, 0.1_wp, 1.5_wp, -0.3_wp, 0.2_wp, -0.3_wp, 1.0_wp], [3, 3]))
      call beam%clamp(1, error)
      call beam%pin(2, error)
      call beam%fix_position(3, [1.0_wp, 2.0_wp, -3.0_wp], error)
      call beam%fix_rotation(3, [1.0_wp, -2.0_wp, 0.5_wp], error)
      call beam%link(4, [0.5_wp, 1.0_wp, -0.3_wp], 0.8_wp, error)
      call beam%add_load(4, [1.0_wp, 2.0_wp, 3.0_wp], [0.1_wp, 0.2_wp, 0.3_wp], error, [0.0_wp, 1.0_wp], [0.0_wp, 2.0_wp])
      call no_error(failure, error)
      call check(failure, beam%c == 12 .and. beam%n == 24 .and. beam%n_x == 28, 'sizes')
      call check(failure, size(beam%mass_blocks) == 22 .and. beam%mass_blocks(10) == 3, 'one full block')
      at = beam%reference_state()
      at%x = deformed(beam, 0.4_wp, .false.)
      at%v = [(sin(3.0_wp*i), i=1, beam%n)]
      call verify(beam, at, findings, error)
      call no_error(failure, error)
      if (size(findings) > 0) call check(failure, .false., findings(1)%message)
      ! Turned by more than half a turn, q0 is negative.
      at%x(4:7) = quaternion_of_vector([3.5_wp, 0.5_wp, 0.3_wp])
      at%x(18:21) = quaternion_of_vector([0.5_wp, -4.0_wp, 0.3_wp])
      call verify(beam, at, findings, error)
      if (size(findings) > 0) call check(failure, .false., findings(1)%message)
      call check(failure, beam%x_name(8) == 'x2' .and. beam%x_name(14) == 'qd2' .and. beam%v_name(24) == 'wz4', 'names')
   end subroutine passes_check

   subroutine histories(failure)
      character(:), allocatable, intent(inout) :: failure
      type(dead_load_t) :: load
      type(beam_t) :: beam
      type(error_t), allocatable :: error
      real(wp), parameter :: zero(3) = 0.0_wp, times(3) = [0.0_wp, 0.128_wp, 0.256_wp], factors(3) = [0.0_wp, 2.0_wp, 0.5_wp]

      call load%set(1, zero, zero, error, times, factors)
      call check_below(failure, load%factor(-1.0_wp), 0.0_wp, 'before')
      call check_close(failure, load%factor(0.064_wp), 1.0_wp, 1.0e-15_wp, 'up')
      call check_close(failure, load%factor(0.128_wp), 2.0_wp, 0.0_wp, 'at the top')
      call check_close(failure, load%factor(0.192_wp), 1.25_wp, 1.0e-15_wp, 'down')
      call check_close(failure, load%factor(9.0_wp), 0.5_wp, 0.0_wp, 'after')
      beam = swing_beam(4)
      call beam%add_load(3, zero, zero, error, times, factors)
      call beam%add_load(2, zero, zero, error)
      call no_error(failure, error)
      call check_below(failure, maxval(abs(beam%breakpoints() - times)), 0.0_wp, 'breakpoints')
      call load%set(1, zero, zero, error)
      call check_close(failure, load%factor(3.0_wp), 1.0_wp, 0.0_wp, 'constant')
      call load%set(1, zero, zero, error, [1.0_wp, 1.0_wp], [1.0_wp, 2.0_wp])
      call check(failure, allocated(error), 'times that do not increase')
   end subroutine histories

   subroutine bad_beams(failure)
      character(:), allocatable, intent(inout) :: failure
      type(beam_t) :: beam
      type(beam_section_t) :: section
      type(error_t), allocatable :: error

      call new_beam(beam, reshape(origin, [3, 1]), reshape(identity, [4, 1]), coupled_section(), error)
      call expect('it has 1 nodes')
      call new_beam(beam, reshape([origin, origin], [3, 2]), reshape([identity, identity], [4, 2]), coupled_section(), error)
      call expect('at one point')
      call new_beam(beam, reshape([origin, axes(:, 1)], [3, 2]), reshape(identity, [4, 1]), coupled_section(), error)
      call expect('do not fit')
      call new_beam(beam, reshape([origin, axes(:, 1)], [3, 2]), reshape([identity, identity], [4, 2]), section, error)
      call expect('section is not set')
      call new_beam(beam, reshape([origin, axes(:, 1)], [3, 2]), reshape([identity, identity], [4, 2]), coupled_section(), error, &
                    damping=-1.0_wp)
      call expect('damping')
      beam = swing_beam(4)
      call beam%pin(6, error)
      call expect('no node 6')
      call beam%link(1, origin, 0.0_wp, error)
      call expect('length')
      call beam%fix_position(1, origin, error)
      call expect('direction')
      call beam%add_mass(1, -1.0_wp, error)
      call expect('negative')
      call check(failure, beam%c == 0, 'nothing was added')

   contains

      subroutine expect(text)
         character(*), intent(in) :: text

         call check(failure, allocated(error), 'an error about '//text)
         if (.not. allocated(error)) return
         call check(failure, index(error%line(), text) > 0, 'instead of '//text//': '//error%line())
         deallocate (error)
      end subroutine expect

   end subroutine bad_beams

   subroutine body_force(self, at, value)
      class(body_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = 0.0_wp
      call self%loads_and_inertia(at, value)
   end subroutine body_force

   !> A symmetric top free of moments: W3 stays, {W1, W2} turns at (J3 - J1)/J1 W3.
   subroutine euler_top(failure)
      character(:), allocatable, intent(inout) :: failure
      type(body_t) :: body
      type(state_t) :: at
      type(integration_result_t) :: result
      type(integration_options_t) :: options
      type(error_t), allocatable :: error
      real(wp), parameter :: j1 = 2.0_wp, j3 = 3.0_wp, w1 = 0.8_wp, w3 = 1.5_wp, t = 2.0_wp
      real(wp) :: angle, h(3)

      call body%set_nodes(reshape(origin, [3, 1]), reshape(quaternion_of_vector([0.5_wp, 0.2_wp, 0.9_wp]), [4, 1]), error)
      call body%add_mass(1, 2.0_wp, error, reshape([j1, 0.0_wp, 0.0_wp, 0.0_wp, j1, 0.0_wp, 0.0_wp, 0.0_wp, j3], [3, 3]))
      body%gravity = [0.0_wp, -9.81_wp, 0.0_wp]
      call no_error(failure, error)
      at = body%reference_state()
      at%v = [1.0_wp, 2.0_wp, 3.0_wp, w1, 0.0_wp, w3]
      h = rotate(at%x(4:7), [j1*w1, 0.0_wp, j3*w3])
      options%rtol = 1.0e-11_wp
      options%atol = 1.0e-11_wp
      call simulate(body, at, t, result, error, options=options)
      call no_error(failure, error)
      angle = (j3 - j1)/j1*w3*t
      call check_below(failure, maxval(abs(at%v(4:6) - [w1*cos(angle), w1*sin(angle), w3])), 1.0e-9_wp, 'angular velocity')
      call check_below(failure, maxval(abs(h - rotate(at%x(4:7), [j1, j1, j3]*at%v(4:6)))), 1.0e-9_wp, 'angular momentum')
      call check_below(failure, maxval(abs(at%x(1:3) - [2.0_wp, 4.0_wp - 0.5_wp*9.81_wp*t**2, 6.0_wp])), 1.0e-9_wp, 'free fall')
   end subroutine euler_top

   !> A bent beam of the swing thrown through space.
   subroutine free_flight(failure)
      character(:), allocatable, intent(inout) :: failure
      type(beam_t) :: beam
      type(state_t) :: at
      type(integration_result_t) :: result
      type(integration_options_t) :: options
      type(error_t), allocatable :: error
      real(wp) :: before(7), after(7)
      integer :: i

      beam = swing_beam(4)
      at = beam%reference_state()
      ! Bent and thrown in the plane, then turned in space: forces have a potential.
      do i = 1, 5
         at%x(7*i - 5) = 0.02_wp*sin(acos(-1.0_wp)*0.25_wp*(i - 1))
         at%v(6*i - 5:6*i) = [0.3_wp, 2.0_wp*at%x(7*i - 6), 0.0_wp, 0.0_wp, 0.0_wp, 2.0_wp]
      end do
      at%x = turned(beam, at%x, quaternion_of_vector([0.4_wp, -0.3_wp, 1.0_wp]), [1.0_wp, 0.0_wp, 0.0_wp])
      do i = 1, 5
         at%v(6*i - 5:6*i - 3) = rotate(quaternion_of_vector([0.4_wp, -0.3_wp, 1.0_wp]), at%v(6*i - 5:6*i - 3))
      end do
      before = momenta()
      options%rtol = 1.0e-10_wp
      options%atol = 1.0e-10_wp
      call simulate(beam, at, 0.01_wp, result, error, options=options)
      call no_error(failure, error)
      after = momenta()
      call check(failure, before(7) > 0.1_wp, 'there is energy')
      call check_below(failure, maxval(abs(after(1:3) - before(1:3))), 1.0e-12_wp, 'linear momentum')
      call check_below(failure, maxval(abs(after(4:6) - before(4:6))), 1.0e-10_wp, 'angular momentum')
      call check_below(failure, (after(7) - before(7))/before(7), 1.0e-8_wp, 'energy')

   contains

      !> Linear and angular momentum, and energy.
      function momenta() result(all)
         real(wp) :: all(7)
         integer :: j

         all = 0.0_wp
         do j = 1, 5
            associate (x => at%x(7*j - 6:7*j - 4), q => at%x(7*j - 3:7*j), v => at%v(6*j - 5:6*j - 3), w => at%v(6*j - 2:6*j))
               all(1:3) = all(1:3) + beam%m(j)*v
               all(4:6) = all(4:6) + beam%m(j)*cross(x, v) + rotate(q, matmul(beam%inertia(:, :, j), w))
            end associate
         end do
         all(7) = beam%energy(at)
      end function momenta

   end subroutine free_flight

end module test_beam
