!> A non-holonomic constraint: a sleigh on a knife edge, on a slope of 30 degrees. It cannot slide across its edge.
!!
!! x down the slope, y across it, angle; A v = vy cos(angle) - vx sin(angle) = 0. Set turning, it does not go down for good:
!! x = g sin(slope)/(2 w^2) sin^2(w t).
module sleigh_system
   use taut
   implicit none (type, external)

   type, extends(mechanical_system_t) :: sleigh_t
      real(wp) :: m = 2.0_wp, j = 0.1_wp                ! mass [kg], inertia [kg m^2]
      real(wp) :: pull = 0.5_wp*9.81_wp                 ! g sin(slope) [m/s^2]
   contains
      procedure :: mass, force, jacobian, acceleration_rhs
   end type sleigh_t

contains

   subroutine mass(self, at, m)
      class(sleigh_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m
      call m%set_diagonal([spread(self%m, 1, size(at%v) - 1), self%j])
   end subroutine mass

   subroutine force(self, at, value)
      class(sleigh_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      value(:) = 0.0_wp*at%v
      value(1) = self%m*self%pull
   end subroutine force

   subroutine jacobian(self, at, a)                     ! no position level: A v = 0 is all there is
      class(sleigh_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)
      a(:self%c, :) = reshape([-sin(at%x(3)), cos(at%x(3)), 0.0_wp], [1, 3])
   end subroutine jacobian

   subroutine acceleration_rhs(self, at, value)         ! b'' = -Adot v
      class(sleigh_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      value(self%c) = at%v(3)*(cos(at%x(3))*at%v(1) + sin(at%x(3))*at%v(2))
   end subroutine acceleration_rhs

end module sleigh_system

program sleigh
   use taut
   use sleigh_system
   implicit none (type, external)
   type(sleigh_t) :: system
   type(state_t) :: at
   type(integration_result_t) :: result
   type(finding_t), allocatable :: findings(:)
   type(error_t), allocatable :: error
   real(wp), parameter :: w = 1.5_wp                    ! it turns [rad/s]

   call system%define(n=3, c=1, nonholonomic=1)
   at%x = [0.0_wp, 0.0_wp, 0.0_wp]
   at%v = [0.0_wp, 0.0_wp, w]
   call verify(system, at, findings, error)
   if (size(findings) > 0) print '(a)', findings(1)%message
   call simulate(system, at, 5.0_wp, result, error, options=integration_options_t(rtol=1.0e-9_wp, atol=1.0e-10_wp))
   if (allocated(error)) error stop 'it could not begin'
   print '(2a, 2f13.8)', status_name(result%status), ', how far down, and in closed form [m]:', at%x(1), &
      system%pull/(2.0_wp*w**2)*sin(5.0_wp*w)**2
end program sleigh
