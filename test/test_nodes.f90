!> Systems of nodes: loads, and the rotation of a body.
module test_nodes
   use beams, only: swing_beam
   use taut_kinds, only: wp
   use taut_error, only: error_t
   use taut_constrained_simulate, only: simulate
   use taut_constrained_system, only: state_t
   use taut_model_beam, only: beam_t
   use taut_model_dead_load, only: dead_load_t
   use taut_model_nodes, only: nodal_system_t
   use taut_ode_options, only: integration_options_t, integration_result_t
   use taut_rotation, only: quaternion_of_vector, rotate
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_nodes

   !> A rigid body: one node.
   type, extends(nodal_system_t) :: body_t
   contains
      procedure :: force => body_force
   end type body_t

   real(wp), parameter :: origin(3) = 0.0_wp

contains

   !> All tests of this module.
   function collect_nodes() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('histories of loads', histories), &
               new_test('a rigid body turns as Euler says', euler_top)]
   end function collect_nodes

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

end module test_nodes
