!> Inverse kinematics: an arm of five links draws a circle with its tip. A first-order system, qdot = A^+ b', the smallest
!> rates that do it: an ordinary differential equation whose right-hand side and projection are those of the constraints
!> phi(q, t) = 0.
module arm_system
   use taut
   implicit none (type, external)

   type, extends(automatic_system_t) :: arm_t       ! only its constraints are asked for
      real(wp) :: link = 0.3_wp, r = 0.2_wp         ! length of a link, radius of the circle [m]
   contains
      procedure :: phi, potential
   end type arm_t

   type, extends(ode_system_t) :: kinematics_t
      type(arm_t) :: arm
      type(projector_t) :: projector                ! in the metric W: the unit matrix, or what weighs the joints
      type(state_t) :: at
   contains
      procedure :: rhs, project
   end type kinematics_t

contains

   subroutine phi(self, at, value)                  ! the tip less its place on the circle about {1, 0}
      class(arm_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value(:)
      value = [self%link*sum(cos(at%x)) - 1.0_wp - self%r*cos(at%t), self%link*sum(sin(at%x)) - self%r*sin(at%t)]
   end subroutine phi

   subroutine potential(self, at, value)            ! no forces
      class(arm_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value
      value = 0.0_wp*self%link*at%t
   end subroutine potential

   subroutine rhs(self, t, y, dydt, info)           ! qdot = 0 - W^-1 A^T S^+ (A 0 - b'), Eq. (11a) of no velocity
      class(kinematics_t), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(out), contiguous :: dydt(:)
      integer, intent(out) :: info
      self%at%t = t
      self%at%x(:) = y
      self%at%v(:) = 0.0_wp
      call self%projector%correct(self%arm, self%at, info)
      dydt = self%at%v
   end subroutine rhs

   subroutine project(self, t, y, place, stale, info)
      class(kinematics_t), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), intent(inout), contiguous :: y(:)
      integer, intent(in) :: place
      logical, intent(out) :: stale
      integer, intent(out) :: info
      self%at%t = t
      self%at%x(:) = y
      call self%projector%position(self%arm, self%at, info)
      if (info == rhs_ok) y = self%at%x
      stale = place /= place                        ! `rhs` has projected too
   end subroutine project

end module arm_system

program inverse_kinematics
   use taut
   use arm_system
   implicit none (type, external)
   type(kinematics_t) :: arm
   type(integrator_t) :: integrator
   type(integration_result_t) :: result
   type(start_report_t) :: start
   type(error_t), allocatable :: error
   real(wp) :: q(5), t
   integer :: i
   real(wp), parameter :: turn = 2.0_wp*acos(-1.0_wp)

   call arm%arm%define(n=5, c=2, mass_blocks=[(1, i=1, 5)])
   arm%arm%diagonal_mass = [(1.0_wp, i=1, 5)]
   arm%at = state_t(x=[0.9_wp, 0.3_wp, -0.2_wp, -0.5_wp, -0.8_wp], v=[(0.0_wp, i=1, 5)])
   call consistent_start(arm%arm, method_t(), arm%at, start, error)
   call arm%projector%init(arm%arm, method_t())
   call integrator%init(5, integration_options_t(rtol=1.0e-8_wp), error)
   if (allocated(error)) error stop 1
   q = arm%at%x
   do i = 1, 3
      t = 0.0_wp
      call integrator%run(arm, t, q, turn, result)
      print '(2a, i0, a, i0, a, 2es9.1, a, 5f8.4)', status_name(result%status), ', turn ', i, ': ', result%steps, &
         ' steps, tip off by', arm%arm%link*sum(cos(q)) - 1.0_wp - arm%arm%r, &
         arm%arm%link*sum(sin(q)), ', angles', q
   end do
end program inverse_kinematics
