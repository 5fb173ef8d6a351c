!> The swing of Sect. 4.2, of elements and of modes.
module test_swing
   use taut, only: constrained_ode_t, error_t, finding_t, integration_options_t, integration_result_t, method_t, sample_t, &
                   simulate, state_t, verify, wp
   use taut_model_swing, only: new_swing_beam, new_swing_modal, swing_beam_t, swing_data_t, swing_modal_t
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_swing

contains

   !> All tests of this module.
   function collect_swing() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('both models pass the checker', models_are_consistent), &
               new_test('the four modes of Table 1', modes_of_table), &
               new_test('it stays in its plane, the links hold', in_its_plane), &
               new_test('modes follow elements', modes_follow_elements), &
               new_test('energy is constant after the force', energy_after_force), &
               new_test('bad input', bad_input)]
   end function collect_swing

   function tight(rtol) result(options)
      real(wp), intent(in) :: rtol
      type(integration_options_t) :: options

      options%rtol = rtol
      options%atol = rtol
   end function tight

   !> Modal swing and its state at rest.
   subroutine modal_swing(swing, at, modes, failure)
      type(swing_modal_t), intent(out) :: swing
      type(state_t), intent(out) :: at
      integer, intent(in) :: modes(:)
      character(:), allocatable, intent(inout) :: failure
      type(swing_data_t) :: data
      type(error_t), allocatable :: error

      data%elements = 40
      call new_swing_modal(swing, data, modes, error)
      call no_error(failure, error)
      allocate (at%x(swing%n_x), at%v(swing%n), at%w(0), source=0.0_wp)
      at%x(4) = 1.0_wp
   end subroutine modal_swing

   subroutine models_are_consistent(failure)
      character(:), allocatable, intent(inout) :: failure
      type(swing_beam_t) :: beam
      type(swing_modal_t) :: modal
      type(swing_data_t) :: data
      type(finding_t), allocatable :: findings(:)
      type(state_t) :: at
      type(error_t), allocatable :: error
      integer :: i

      call new_swing_beam(beam, data, error)
      call no_error(failure, error)
      at = beam%reference_state()
      at%v = [(sin(1.0_wp*i), i=1, beam%n)]
      call beam%displace(0.05_wp*[(cos(2.0_wp*i), i=1, beam%n)], at%x)
      call verify(beam, at, findings, error)
      if (size(findings) > 0) call check(failure, .false., 'beam: '//findings(1)%message)
      call modal_swing(modal, at, [1, 2, 3, 9], failure)
      at%v = [(sin(1.0_wp*i), i=1, modal%n)]
      call modal%displace(0.01_wp*[(cos(2.0_wp*i), i=1, modal%n)], at%x)
      call verify(modal, at, findings, error)
      if (size(findings) > 0) call check(failure, .false., 'modes: '//findings(1)%message)
   end subroutine models_are_consistent

   subroutine modes_of_table(failure)
      character(:), allocatable, intent(inout) :: failure
      type(swing_modal_t) :: swing
      type(state_t) :: at
      real(wp), parameter :: table(4) = [0.443_wp, 18.17_wp, 28.46_wp, 319.5_wp], half_digit(4) = &
         [0.0005_wp, 0.005_wp, 0.005_wp, 0.05_wp]
      integer :: i

      call modal_swing(swing, at, [1, 2, 3, 9], failure)
      do i = 1, 4
         call check_close(failure, swing%frequency(i), table(i), half_digit(i), 'frequency')
      end do
   end subroutine modes_of_table

   subroutine in_its_plane(failure)
      character(:), allocatable, intent(inout) :: failure
      type(swing_beam_t) :: swing
      type(swing_data_t) :: data
      type(integration_result_t) :: result
      class(constrained_ode_t), allocatable :: ode
      type(sample_t) :: s
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp), allocatable :: y(:)
      integer :: i, info

      call new_swing_beam(swing, data, error)
      at = swing%reference_state()
      call simulate(swing, at, 0.02_wp, result, error, options=tight(1.0e-6_wp), ode=ode)
      call no_error(failure, error)
      call check_below(failure, maxval(abs([(at%x(7*i - 4), i=1, 5)])), 0.0_wp, 'out of the plane')
      allocate (y(ode%size()))
      call ode%pack(at, y)
      call ode%sample(at%t, y, s, info)
      call check_below(failure, max(s%phi, s%phidot), 1.0e-12_wp, 'compliance')
      call check_close(failure, s%outputs(7), at%x(15), 0.0_wp, 'marker C')
   end subroutine in_its_plane

   !> While the force grows, before high modes count.
   subroutine modes_follow_elements(failure)
      character(:), allocatable, intent(inout) :: failure
      type(swing_beam_t) :: beam
      type(swing_modal_t) :: modal
      type(swing_data_t) :: data
      type(integration_result_t) :: result
      type(state_t) :: at, other
      type(error_t), allocatable :: error
      real(wp) :: c(3)

      call new_swing_beam(beam, data, error)
      at = beam%reference_state()
      call simulate(beam, at, 0.05_wp, result, error, options=tight(1.0e-6_wp))
      call modal_swing(modal, other, [1, 2, 3, 9], failure)
      call simulate(modal, other, 0.05_wp, result, error, options=tight(1.0e-6_wp))
      call no_error(failure, error)
      c = modal%node_position(other, 21)
      call check_below(failure, norm2(c - at%x(15:17)), 1.0e-4_wp, 'position of C')
      call check(failure, c(1) - 0.36_wp > 1.0e-4_wp, 'C moves')
   end subroutine modes_follow_elements

   subroutine energy_after_force(failure)
      character(:), allocatable, intent(inout) :: failure
      type(swing_modal_t) :: swing
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp) :: energy

      call modal_swing(swing, at, [1, 2, 3], failure)
      call simulate(swing, at, 0.256_wp, result, error, options=tight(1.0e-9_wp))
      energy = swing%energy(at)
      call simulate(swing, at, 0.5_wp, result, error, options=tight(1.0e-9_wp))
      call no_error(failure, error)
      call check(failure, energy > 0.05_wp, 'the force has worked')
      call check_close(failure, swing%energy(at), energy, 1.0e-7_wp, 'energy')
   end subroutine energy_after_force

   subroutine bad_input(failure)
      character(:), allocatable, intent(inout) :: failure
      type(swing_beam_t) :: beam
      type(swing_modal_t) :: modal
      type(swing_data_t) :: data(6)
      type(error_t), allocatable :: error
      integer :: i

      data(1)%elements = 0
      data(2)%elements = 5
      data(3)%young = -1.0_wp
      data(4)%link_1 = 0.0_wp
      data(5)%mid_mass = -1.0_wp
      data(6)%times = [0.0_wp, 0.0_wp, 1.0_wp]
      do i = 1, size(data)
         call new_swing_beam(beam, data(i), error)
         call check(failure, allocated(error), 'a value that makes no sense was taken')
         if (allocated(error)) deallocate (error)
      end do
      data(1)%elements = 8
      call new_swing_modal(modal, data(1), [1, 99], error)
      call check(failure, allocated(error), 'a mode that does not exist')
      if (allocated(error)) deallocate (error)
      call new_swing_modal(modal, data(1), [1, 1], error)
      call check(failure, allocated(error), 'a mode named twice')
   end subroutine bad_input

end module test_swing
