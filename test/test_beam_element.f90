!> The finite-volume element: strains, gradients of its energy, momenta.
module test_beam_element
   use beams, only: coupled_section, deformed, swing_beam, turned
   use taut_kinds, only: wp
   use taut_error, only: error_t
   use taut_constrained_system, only: state_t
   use taut_model_beam, only: beam_t, new_beam, straight_nodes
   use taut_model_beam_element, only: beam_element_t, element_energy, element_strain, internal_loads, new_element
   use taut_model_beam_section, only: beam_section_t, rectangular_section
   use taut_rotation, only: cross, quaternion_of_vector, quaternion_product, rotate, rotate_back
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_beam_element

   real(wp), parameter :: origin(3) = 0.0_wp, at_rest(6) = 0.0_wp, identity(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
   real(wp), parameter :: axes(3, 3) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [3, 3])

contains

   !> All tests of this module.
   function collect_beam_element() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('rigid motions do not strain', rigid_motion), &
               new_test('constant strains are exact', constant_strain), &
               new_test('in the plane forces and moments are the gradient of the energy', planar_gradient), &
               new_test('in space forces are, moments up to the square of the length', spatial_gradient), &
               new_test('internal forces leave both momenta alone', momentum)]
   end function collect_beam_element

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

end module test_beam_element
