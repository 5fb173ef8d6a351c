!> Rigid bodies: free rotation, the heavy symmetric top, chains on spherical joints.
module test_rigid_bodies
   use taut, only: constrained_ode_t, error_t, finding_t, integration_options_t, integration_result_t, integrator_t, method_t, &
                   ode_system_t, rhs_ok, sample_t, simulate, state_t, verify, wp
   use taut_model_rigid_bodies, only: new_rigid_bodies, rigid_bodies_t, rigid_body_t, spherical_joint_t
   use taut_rotation, only: cross, matrix_of_quaternion, quaternion_of_vector
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_rigid_bodies

   !> The heavy symmetric top in its nutation angle: y = {angle, rate, precession}.
   type, extends(ode_system_t) :: minimal_top_t
      real(wp) :: transverse = 0.0_wp, weight_arm = 0.0_wp, about_vertical = 0.0_wp, about_axis = 0.0_wp
   contains
      procedure :: rhs => top_rhs
   end type minimal_top_t

contains

   !> All tests of this module.
   function collect_rigid_bodies() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('bodies on joints pass the checker', bodies_are_consistent), &
               new_test('free rotation keeps energy and angular momentum', free_rotation), &
               new_test('the reference point does not matter', reference_point), &
               new_test('heavy symmetric top in minimal coordinates', heavy_top), &
               new_test('a fast spin keeps the quaternion', fast_spin), &
               new_test('bad input', bad_input)]
   end function collect_rigid_bodies

   !> A slender body whose reference point is the end of its axis 3; J about that point.
   function top() result(body)
      type(rigid_body_t) :: body

      body%m = 1.5_wp
      body%s = [0.0_wp, 0.0_wp, 1.5_wp*0.4_wp]
      body%j(1, 1) = 0.35_wp
      body%j(2, 2) = 0.35_wp
      body%j(3, 3) = 0.05_wp
   end function top

   function tight() result(options)
      type(integration_options_t) :: options

      options%rtol = 1.0e-11_wp
      options%atol = 1.0e-11_wp
   end function tight

   subroutine bodies_are_consistent(failure)
      character(:), allocatable, intent(inout) :: failure
      type(rigid_bodies_t) :: system
      type(finding_t), allocatable :: findings(:)
      type(state_t) :: at
      type(error_t), allocatable :: error

      call new_rigid_bodies(system, [top(), top()], &
                            [spherical_joint_t(1, 0, [0.1_wp, 0.2_wp, 0.3_wp], [0.0_wp, 0.1_wp, 0.0_wp]), &
                             spherical_joint_t(2, 1, [0.1_wp, -0.2_wp, 0.3_wp], [0.4_wp, 0.1_wp, 0.0_wp])], &
                            [0.1_wp, 0.2_wp, -9.81_wp], error)
      call no_error(failure, error)
      allocate (at%x(14), at%v(12))
      at%x(1:3) = [0.3_wp, 0.2_wp, -0.4_wp]
      at%x(4:7) = quaternion_of_vector([0.5_wp, -0.7_wp, 0.3_wp])
      at%x(8:10) = [0.1_wp, 0.6_wp, -0.9_wp]
      at%x(11:14) = quaternion_of_vector([-0.2_wp, 1.7_wp, 0.9_wp])
      at%v = [0.3_wp, -0.2_wp, 0.5_wp, 1.1_wp, 0.7_wp, -0.6_wp, 0.2_wp, 0.9_wp, -0.3_wp, 0.4_wp, -1.3_wp, 0.8_wp]
      call verify(system, at, findings, error)
      call no_error(failure, error)
      if (size(findings) > 0) call check(failure, .false., findings(1)%message)
   end subroutine bodies_are_consistent

   subroutine free_rotation(failure)
      character(:), allocatable, intent(inout) :: failure
      type(rigid_bodies_t) :: system
      type(rigid_body_t) :: body
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp) :: before(3), energy
      integer :: i

      body%m = 2.0_wp
      do i = 1, 3
         body%j(i, i) = 0.1_wp*i
      end do
      call new_rigid_bodies(system, [body], [spherical_joint_t ::], [0.0_wp, 0.0_wp, 0.0_wp], error)
      at%x = [0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      ! About the middle axis, which is unstable.
      at%v = [1.0_wp, 2.0_wp, 3.0_wp, 0.01_wp, 5.0_wp, 0.02_wp]
      before = matmul(body%j, at%v(4:6))
      energy = system%energy(at)
      call simulate(system, at, 20.0_wp, result, error, options=tight())
      call no_error(failure, error)
      call check_close(failure, system%energy(at), energy, 1.0e-8_wp, 'energy')
      call check_below(failure, maxval(abs(matmul(matrix_of_quaternion(at%x(4:7)), matmul(body%j, at%v(4:6))) - before)), &
                       1.0e-8_wp, 'angular momentum')
      call check_below(failure, maxval(abs(at%x(1:3) - 20.0_wp*[1.0_wp, 2.0_wp, 3.0_wp])), 1.0e-10_wp, 'straight on')
   end subroutine free_rotation

   !> The same body described from two points moves in the same way.
   subroutine reference_point(failure)
      character(:), allocatable, intent(inout) :: failure
      type(rigid_bodies_t) :: here, there
      type(rigid_body_t) :: body
      type(integration_result_t) :: result
      type(state_t) :: at, other
      type(error_t), allocatable :: error
      real(wp), parameter :: arm(3) = [0.3_wp, -0.2_wp, 0.5_wp], omega(3) = [1.0_wp, -2.0_wp, 1.5_wp]
      integer :: i, j

      body%m = 2.0_wp
      do i = 1, 3
         body%j(i, i) = 0.1_wp*i
      end do
      call new_rigid_bodies(here, [body], [spherical_joint_t ::], [0.0_wp, 0.0_wp, -9.81_wp], error)
      ! The center of mass is at `arm` from the new reference point.
      body%s = body%m*arm
      do i = 1, 3
         do j = 1, 3
            body%j(i, j) = body%j(i, j) - body%m*arm(i)*arm(j)
         end do
         body%j(i, i) = body%j(i, i) + body%m*dot_product(arm, arm)
      end do
      call new_rigid_bodies(there, [body], [spherical_joint_t ::], [0.0_wp, 0.0_wp, -9.81_wp], error)
      at%x = [arm, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      at%v = [1.0_wp, 2.0_wp, 3.0_wp, omega]
      other%x = [0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      other%v = [at%v(1:3) - cross(omega, arm), omega]
      call check_close(failure, there%energy(other), here%energy(at), 1.0e-12_wp, 'energy')
      call simulate(here, at, 3.0_wp, result, error, options=tight())
      call simulate(there, other, 3.0_wp, result, error, options=tight())
      call no_error(failure, error)
      call check_below(failure, maxval(abs(at%x(1:3) - other%x(1:3) - matmul(matrix_of_quaternion(other%x(4:7)), arm))), &
                       1.0e-8_wp, 'center of mass')
      call check_below(failure, maxval(abs(at%v(4:6) - other%v(4:6))), 1.0e-8_wp, 'angular velocity')
   end subroutine reference_point

   !> thetadotdot = ((I1 phidot^2 cos - p3 phidot) sin + m g l sin)/I1, phidot = (p_vertical - p3 cos)/(I1 sin^2).
   subroutine top_rhs(self, t, y, dydt, info)
      class(minimal_top_t), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(out), contiguous :: dydt(:)
      integer, intent(out) :: info
      real(wp) :: precession

      info = rhs_ok
      precession = (self%about_vertical - self%about_axis*cos(y(1)))/(self%transverse*sin(y(1))**2)
      dydt(1) = y(2)
      dydt(2) = ((self%transverse*precession*cos(y(1)) - self%about_axis)*precession + self%weight_arm)*sin(y(1))/self%transverse
      dydt(3) = precession
      associate (unused_time => t)
      end associate
   end subroutine top_rhs

   !> Spherical joint at the tip, the reference point there: s /= 0. Start tilted by 0.5 rad with spin and precession.
   subroutine heavy_top(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=16), parameter :: weight(2) = [character(len=16) :: 'identity', 'mass']
      type(rigid_bodies_t) :: system
      type(minimal_top_t) :: minimal
      type(integrator_t) :: integrator
      type(integration_result_t) :: result
      class(constrained_ode_t), allocatable :: ode
      type(sample_t) :: s
      type(method_t) :: method
      type(state_t) :: at
      type(rigid_body_t) :: body
      type(error_t), allocatable :: error
      real(wp), parameter :: tilt = 0.5_wp, spin = 30.0_wp, precession = 1.0_wp, g = 9.81_wp
      real(wp) :: axis(3), t, y(3)
      real(wp), allocatable :: all_of_it(:)
      integer :: i, info

      body = top()
      minimal%transverse = body%j(1, 1)
      minimal%weight_arm = body%s(3)*g
      minimal%about_axis = body%j(3, 3)*spin
      minimal%about_vertical = body%j(1, 1)*precession*sin(tilt)**2 + minimal%about_axis*cos(tilt)
      y = [tilt, 0.0_wp, 0.0_wp]
      t = 0.0_wp
      call integrator%init(3, tight(), error)
      call integrator%run(minimal, t, y, 2.0_wp, result)

      call new_rigid_bodies(system, [body], [spherical_joint_t(1, 0)], [0.0_wp, 0.0_wp, -g], error)
      do i = 1, 2
         method%weight = weight(i)
         at%t = 0.0_wp
         ! Tilted about y: the axis is {sin, 0, cos}; precession about z is {-sin, 0, cos} in body axes.
         at%x = [0.0_wp, 0.0_wp, 0.0_wp, quaternion_of_vector([0.0_wp, tilt, 0.0_wp])]
         at%v = [0.0_wp, 0.0_wp, 0.0_wp, -precession*sin(tilt), 0.0_wp, spin]
         call simulate(system, at, 2.0_wp, result, error, method, tight(), ode=ode)
         call no_error(failure, error)
         axis = matmul(matrix_of_quaternion(at%x(4:7)), [0.0_wp, 0.0_wp, 1.0_wp])
         call check_below(failure, maxval(abs(axis - [sin(y(1))*cos(y(3)), sin(y(1))*sin(y(3)), cos(y(1))])), 1.0e-8_wp, &
                          'axis with W = '//trim(weight(i)))
         call check_close(failure, at%v(6), spin, 1.0e-9_wp, 'spin')
         allocate (all_of_it(ode%size()))
         call ode%pack(at, all_of_it)
         call ode%sample(at%t, all_of_it, s, info)
         deallocate (all_of_it)
         call check_below(failure, max(s%phi, s%phidot), 1.0e-12_wp, 'compliance')
         call check(failure, s%rank == 3, 'rank')
      end do
   end subroutine heavy_top

   subroutine fast_spin(failure)
      character(:), allocatable, intent(inout) :: failure
      type(rigid_bodies_t) :: system
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(rigid_body_t) :: body
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp) :: energy

      body = top()
      body%s = 0.0_wp
      call new_rigid_bodies(system, [body], [spherical_joint_t ::], [0.0_wp, 0.0_wp, 0.0_wp], error)
      at%x = [0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      at%v = [0.0_wp, 0.0_wp, 0.0_wp, 10.0_wp, 0.0_wp, 1000.0_wp]
      energy = system%energy(at)
      options%rtol = 1.0e-8_wp
      options%atol = 1.0e-8_wp
      call simulate(system, at, 2.0_wp, result, error, options=options)
      call no_error(failure, error)
      call check_close(failure, norm2(at%x(4:7)), 1.0_wp, 4.0e-16_wp, 'quaternion')
      call check_below(failure, system%energy(at)/energy - 1.0_wp, 1.0e-5_wp, 'energy')
   end subroutine fast_spin

   subroutine bad_input(failure)
      character(:), allocatable, intent(inout) :: failure
      type(rigid_bodies_t) :: system
      type(rigid_body_t) :: body
      type(error_t), allocatable :: error

      call new_rigid_bodies(system, [body], [spherical_joint_t ::], [0.0_wp, 0.0_wp, 0.0_wp], error)
      call check(failure, allocated(error), 'a body without mass')
      if (allocated(error)) deallocate (error)
      call new_rigid_bodies(system, [top()], [spherical_joint_t(1, 2)], [0.0_wp, 0.0_wp, 0.0_wp], error)
      call check(failure, allocated(error), 'a joint to a body that does not exist')
   end subroutine bad_input

end module test_rigid_bodies
