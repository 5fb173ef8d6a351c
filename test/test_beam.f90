!> Beams: motion, damping, inertia, constraints and loads.
module test_beam
   use beams, only: coupled_section, deformed, slender_beam, swing_beam, turned
   use taut_kinds, only: wp
   use taut_error, only: error_t
   use taut_constrained_simulate, only: simulate
   use taut_constrained_system, only: state_t
   use taut_constrained_verify, only: finding_t, verify
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_model_beam, only: beam_t, new_beam
   use taut_model_beam_element, only: beam_element_t, element_strain, internal_loads, new_element
   use taut_model_beam_section, only: beam_section_t
   use taut_ode_options, only: integration_options_t, integration_result_t
   use taut_ode_status, only: status_reached_end
   use taut_rotation, only: cross, quaternion_normalized, quaternion_of_vector, quaternion_product, rotate, rotate_back
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_beam

   real(wp), parameter :: origin(3) = 0.0_wp, identity(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
   real(wp), parameter :: axes(3, 3) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [3, 3])

contains

   !> All tests of this module.
   function collect_beam() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('nothing leaves the plane', stays_in_plane), &
               new_test('damping: the rate of the strain, and a loss', damping), &
               new_test('inertia by slices', inertia), &
               new_test('all constraints, full inertia and loads pass the check', passes_check), &
               new_test('beams that make no sense', bad_beams), &
               new_test('a free flight keeps momenta and energy', free_flight)]
   end function collect_beam

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
