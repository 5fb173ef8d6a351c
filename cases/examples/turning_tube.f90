!> A rheonomic constraint: a ball on a spring in a tube that turns at a given rate, in a horizontal plane.
!!
!! phi = y cos(w t) - x sin(w t); along the tube r'' = (w^2 - k/m) r, and its side presses with 2 m w r'.
module tube_system
   use taut
   implicit none (type, external)

   type, extends(mechanical_system_t) :: tube_t
      real(wp) :: m = 1.0_wp, k = 13.0_wp, w = 2.0_wp   ! mass [kg], stiffness [N/m], rate of the tube [rad/s]
   contains
      procedure :: mass, force, constraint, jacobian, velocity_rhs, acceleration_rhs
   end type tube_t

contains

   subroutine mass(self, at, m)
      class(tube_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m
      call m%set_diagonal(spread(self%m, 1, size(at%v)))
   end subroutine mass

   subroutine force(self, at, value)
      class(tube_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      value = -self%k*at%x
   end subroutine force

   subroutine constraint(self, at, value)
      class(tube_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      value(1) = dot_product(axis(self, at, 2), at%x)
   end subroutine constraint

   subroutine jacobian(self, at, a)
      class(tube_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)
      a(1, :) = axis(self, at, 2)
   end subroutine jacobian

   subroutine velocity_rhs(self, at, value)             ! b' = -dphi/dt
      class(tube_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      value(1) = self%w*dot_product(axis(self, at, 1), at%x)
   end subroutine velocity_rhs

   subroutine acceleration_rhs(self, at, value)         ! b'' = A vdot - phiddot
      class(tube_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      value(1) = 2.0_wp*self%w*dot_product(axis(self, at, 1), at%v) + self%w**2*dot_product(axis(self, at, 2), at%x)
   end subroutine acceleration_rhs

   pure function axis(self, at, i) result(e)            ! 1 along the tube, 2 across
      class(tube_t), intent(in) :: self
      type(state_t), intent(in) :: at
      integer, intent(in) :: i
      real(wp) :: e(2)
      e = [cos(self%w*at%t), sin(self%w*at%t)]
      if (i == 2) e = [-e(2), e(1)]
   end function axis

end module tube_system

program turning_tube
   use taut
   use tube_system
   implicit none (type, external)
   type(tube_t) :: tube
   type(state_t) :: at
   type(integration_result_t) :: result
   type(finding_t), allocatable :: findings(:)
   type(error_t), allocatable :: error

   call tube%define(n=2, c=1)
   at%x = [0.5_wp, 0.0_wp]
   at%v = [0.0_wp, 1.0_wp]
   call verify(tube, at, findings, error)
   if (size(findings) > 0) print '(a)', findings(1)%message
   call simulate(tube, at, 5.0_wp, result, error, options=integration_options_t(rtol=1.0e-9_wp, atol=1.0e-10_wp))
   if (allocated(error)) error stop 'it could not begin'
   print '(2a, 2f13.8)', status_name(result%status), ', radius and 0.5 cos(3 t) [m]:', &
      dot_product([cos(10.0_wp), sin(10.0_wp)], at%x), 0.5_wp*cos(15.0_wp)
end program turning_tube
