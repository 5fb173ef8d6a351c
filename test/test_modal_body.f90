!> Modal bodies in their floating frame.
module test_modal_body
   use taut, only: constrained_ode_t, error_t, finding_t, integration_options_t, integration_result_t, method_t, sample_t, &
                   simulate, state_t, verify, wp
   use taut_model_modal_body, only: modal_body_t, new_modal_body
   use taut_model_rigid_bodies, only: new_rigid_bodies, rigid_bodies_t, rigid_body_t, spherical_joint_t
   use taut_rotation, only: quaternion_of_vector
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_modal_body

contains

   !> All tests of this module.
   function collect_modal_body() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('a linked body passes the checker', body_is_consistent), &
               new_test('without shapes it is a rigid body', rigid_limit), &
               new_test('a shape swings at its frequency', frequency), &
               new_test('a tumbling body keeps energy and momentum', conservation), &
               new_test('links hold', links_hold), &
               new_test('bad input', bad_input)]
   end function collect_modal_body

   function tight() result(options)
      type(integration_options_t) :: options

      options%rtol = 1.0e-11_wp
      options%atol = 1.0e-11_wp
   end function tight

   !> Five nodes on a line with arbitrary shapes.
   subroutine arbitrary_body(body, modes, failure)
      type(modal_body_t), intent(out) :: body
      integer, intent(in) :: modes
      character(:), allocatable, intent(inout) :: failure
      real(wp) :: position(3, 5), inertia(3, 3, 5), shape(3, modes, 5), rotation(3, modes, 5), stiffness(modes, modes)
      type(error_t), allocatable :: error
      integer :: i, j, k

      inertia = 0.0_wp
      stiffness = 0.0_wp
      do i = 1, 5
         position(:, i) = [0.25_wp*(i - 1), 0.02_wp*(i - 3)**2, 0.01_wp*i]
         do j = 1, 3
            inertia(j, j, i) = 0.01_wp*(i + j)
            do k = 1, modes
               shape(j, k, i) = 0.1_wp*sin(1.7_wp*i*k + 0.9_wp*j)
               rotation(j, k, i) = 0.2_wp*cos(0.6_wp*i*k + 1.1_wp*j)
            end do
         end do
      end do
      do k = 1, modes
         stiffness(k, k) = 3.0_wp*k
      end do
      call new_modal_body(body, position, [0.3_wp, 0.4_wp, 0.5_wp, 0.4_wp, 0.3_wp], inertia, shape, rotation, stiffness, error)
      call no_error(failure, error)
   end subroutine arbitrary_body

   !> A state with everything in it.
   function arbitrary_state(modes) result(at)
      integer, intent(in) :: modes
      type(state_t) :: at
      real(wp), parameter :: q(3) = [0.2_wp, -0.1_wp, 0.3_wp], q_rate(3) = [-0.4_wp, 0.7_wp, 0.2_wp]

      at%x = [0.2_wp, 0.3_wp, -0.5_wp, quaternion_of_vector([0.3_wp, -0.8_wp, 1.1_wp]), q(1:modes)]
      at%v = [0.5_wp, -0.2_wp, 0.3_wp, 1.2_wp, -0.7_wp, 0.9_wp, q_rate(1:modes)]
      allocate (at%w(0))
   end function arbitrary_state

   subroutine body_is_consistent(failure)
      character(:), allocatable, intent(inout) :: failure
      type(modal_body_t) :: body
      type(finding_t), allocatable :: findings(:)
      type(error_t), allocatable :: error

      call arbitrary_body(body, 3, failure)
      call body%link(1, [0.0_wp, 1.0_wp, 0.0_wp], 1.0_wp, error)
      call body%link(5, [2.0_wp, 1.0_wp, 0.5_wp], 1.4_wp, error)
      call verify(body, arbitrary_state(3), findings, error)
      call no_error(failure, error)
      if (size(findings) > 0) call check(failure, .false., findings(1)%message)
   end subroutine body_is_consistent

   !> The same motion as the model of rigid bodies gives, whose reference point is off the center of mass.
   subroutine rigid_limit(failure)
      character(:), allocatable, intent(inout) :: failure
      type(modal_body_t) :: body
      type(rigid_bodies_t) :: rigid
      type(rigid_body_t) :: inertia
      type(integration_result_t) :: result
      type(state_t) :: at, other
      type(error_t), allocatable :: error
      integer :: i, j, k

      call arbitrary_body(body, 0, failure)
      body%gravity = [0.0_wp, 0.5_wp, -9.81_wp]
      do i = 1, 5
         associate (m => body%node_mass(i), x => body%position(:, i))
            inertia%m = inertia%m + m
            inertia%s = inertia%s + m*x
            inertia%j = inertia%j + body%inertia(:, :, i)
            do j = 1, 3
               inertia%j(j, j) = inertia%j(j, j) + m*dot_product(x, x)
               do k = 1, 3
                  inertia%j(j, k) = inertia%j(j, k) - m*x(j)*x(k)
               end do
            end do
         end associate
      end do
      call new_rigid_bodies(rigid, [inertia], [spherical_joint_t ::], body%gravity, error)
      at = arbitrary_state(0)
      other = at
      call check_close(failure, body%energy(at), rigid%energy(other), 1.0e-12_wp, 'energy')
      call simulate(body, at, 2.0_wp, result, error, options=tight())
      call simulate(rigid, other, 2.0_wp, result, error, options=tight())
      call no_error(failure, error)
      call check_below(failure, maxval(abs([at%x - other%x, at%v - other%v])), 1.0e-8_wp, 'motion')
   end subroutine rigid_limit

   !> Two masses m and one M between them on a spring k across: q = cos(omega t), omega^2 = k (M + 2 m)/(2 m M).
   subroutine frequency(failure)
      character(:), allocatable, intent(inout) :: failure
      type(modal_body_t) :: body
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp), parameter :: light = 0.7_wp, heavy = 1.9_wp, k = 50.0_wp
      real(wp) :: position(3, 3), inertia(3, 3, 3), shape(3, 1, 3), rotation(3, 1, 3), stiffness(1, 1), omega

      position = 0.0_wp
      position(1, :) = [-1.0_wp, 0.0_wp, 1.0_wp]
      inertia = 0.0_wp
      inertia(1, 1, :) = 0.1_wp
      shape = 0.0_wp
      shape(2, 1, 2) = 1.0_wp
      rotation = 0.0_wp
      stiffness = k
      call new_modal_body(body, position, [light, heavy, light], inertia, shape, rotation, stiffness, error)
      call no_error(failure, error)
      at%x = [0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.1_wp]
      at%v = [0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      call simulate(body, at, 3.0_wp, result, error, options=tight())
      call no_error(failure, error)
      omega = sqrt(k*(heavy + 2.0_wp*light)/(2.0_wp*light*heavy))
      call check_close(failure, at%x(8), 0.1_wp*cos(3.0_wp*omega), 1.0e-8_wp, 'amplitude')
   end subroutine frequency

   subroutine conservation(failure)
      character(:), allocatable, intent(inout) :: failure
      type(modal_body_t) :: body
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp) :: energy, momentum(3)

      call arbitrary_body(body, 3, failure)
      at = arbitrary_state(3)
      energy = body%energy(at)
      momentum = linear_momentum(body, at)
      call simulate(body, at, 5.0_wp, result, error, options=tight())
      call no_error(failure, error)
      call check_close(failure, body%energy(at), energy, 1.0e-8_wp, 'energy')
      call check_below(failure, maxval(abs(linear_momentum(body, at) - momentum)), 1.0e-8_wp, 'momentum')
   end subroutine conservation

   !> Momentum by differences of the nodes' positions.
   function linear_momentum(body, at) result(momentum)
      type(modal_body_t), intent(in) :: body
      type(state_t), intent(in) :: at
      real(wp) :: momentum(3)
      real(wp), parameter :: dt = 1.0e-4_wp
      type(state_t) :: after, before
      integer :: i

      after = at
      before = at
      call body%displace(dt*at%v, after%x)
      call body%displace(-dt*at%v, before%x)
      momentum = 0.0_wp
      do i = 1, body%nodes
         momentum = momentum + body%node_mass(i)*(body%node_position(after, i) - body%node_position(before, i))/(2.0_wp*dt)
      end do
   end function linear_momentum

   subroutine links_hold(failure)
      character(:), allocatable, intent(inout) :: failure
      type(modal_body_t) :: body
      type(integration_result_t) :: result
      class(constrained_ode_t), allocatable :: ode
      type(sample_t) :: s
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp), allocatable :: y(:)
      real(wp) :: energy
      integer :: info

      call arbitrary_body(body, 2, failure)
      body%gravity = [0.0_wp, -9.81_wp, 0.0_wp]
      at = arbitrary_state(2)
      at%v = 0.0_wp
      call body%link(1, body%node_position(at, 1) + [0.0_wp, 1.0_wp, 0.0_wp], 1.0_wp, error)
      call body%link(5, body%node_position(at, 5) + [0.3_wp, 1.0_wp, 0.2_wp], norm2([0.3_wp, 1.0_wp, 0.2_wp]), error)
      energy = body%energy(at)
      call simulate(body, at, 2.0_wp, result, error, options=tight(), ode=ode)
      call no_error(failure, error)
      allocate (y(ode%size()))
      call ode%pack(at, y)
      call ode%sample(at%t, y, s, info)
      call check_below(failure, max(s%phi, s%phidot), 1.0e-12_wp, 'compliance')
      call check_close(failure, s%energy, energy, 1.0e-8_wp, 'energy')
      call check(failure, s%rank == 2, 'rank')
   end subroutine links_hold

   subroutine bad_input(failure)
      character(:), allocatable, intent(inout) :: failure
      type(modal_body_t) :: body
      type(error_t), allocatable :: error

      call arbitrary_body(body, 2, failure)
      call body%link(6, [0.0_wp, 0.0_wp, 0.0_wp], 1.0_wp, error)
      call check(failure, allocated(error), 'a node that does not exist')
      if (allocated(error)) deallocate (error)
      call body%link(1, [0.0_wp, 0.0_wp, 0.0_wp], 0.0_wp, error)
      call check(failure, allocated(error), 'a link of zero length')
   end subroutine bad_input

end module test_modal_body
