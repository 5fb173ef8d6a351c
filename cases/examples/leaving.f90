!> A body slides down a sphere with friction, leaves it where nothing presses any more, and flies: forces that depend on reactions,
!! an event that sees them, and two systems one after the other.
module ball_system
   use taut
   implicit none (type, external)

   type, extends(automatic_system_t) :: ball_t
      real(wp) :: g = 9.81_wp, r = 1.0_wp           ! [m/s^2], radius of the sphere [m]
      real(wp) :: mu = 0.0_wp, slow = 1.0e-3_wp     ! friction; velocity up to which it is not yet all there [m/s]
   contains
      procedure :: potential, phi, reaction_force, reaction_event_values
   end type ball_t

contains

   subroutine potential(self, at, value)
      class(ball_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value
      value = self%diagonal_mass(2)*self%g*at%x(2)
   end subroutine potential

   subroutine phi(self, at, value)
      class(ball_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value(:)
      if (self%c > 0) value = norm2(at%x) - self%r  ! in flight there is none
   end subroutine phi

   subroutine reaction_force(self, at, lambda, value) ! Coulomb's law; the sphere presses with -lambda
      class(ball_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: lambda(:)
      real(wp), intent(out) :: value(:)
      value = -self%mu*sum(abs(lambda))*at%v/hypot(norm2(at%v), self%slow)
   end subroutine reaction_force

   subroutine reaction_event_values(self, at, lambda, values)
      class(ball_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: lambda(:)
      real(wp), intent(out) :: values(:)
      values = at%x(2)                              ! in flight: the ground
      if (self%c > 0) values = -lambda(1)           ! on the sphere: its pressure [N]
   end subroutine reaction_event_values

   subroutine set_up(ball, on_sphere)
      type(ball_t), intent(inout) :: ball
      logical, intent(in) :: on_sphere
      call ball%define(n=2, c=merge(1, 0, on_sphere), mass_blocks=[1, 1], reactive=.true.)
      ball%diagonal_mass = [2.0_wp, 2.0_wp]         ! [kg]
      ball%n_events = 1
      ball%events_see_reactions = .true.
      ball%event_direction = [-1]                   ! from positive to negative
      ball%event_terminal = [.true.]
      ball%event_from_start = [.true.]              ! nothing that pulls from the start
   end subroutine set_up

end module ball_system

program leaving
   use taut
   use ball_system
   implicit none (type, external)
   type(ball_t) :: ball
   type(state_t) :: at
   integer :: i
   real(wp), parameter :: v = 1.0_wp                ! push at the top [m/s]

   do i = 0, 1
      ball%mu = 0.1_wp*i
      at = state_t(x=[0.0_wp, ball%r], v=[v, 0.0_wp])
      call set_up(ball, on_sphere=.true.)
      call go()
      print '(a, f4.1, a, f9.6, a, f9.6)', 'friction', ball%mu, ': leaves at the height', at%x(2), ', in closed form without', &
         2.0_wp/3.0_wp + v**2/(3.0_wp*ball%g*ball%r)
      call set_up(ball, on_sphere=.false.)
      call go()
      print '(2(a, f9.6), a)', '   reaches the ground at', at%x(1), ' m after', at%t, ' s'
   end do

contains

   subroutine go()
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      call simulate(ball, at, 10.0_wp, result, error, options=integration_options_t(rtol=1.0e-9_wp))
      if (allocated(error)) then
         print '(a)', error%line()
         error stop 1
      end if
   end subroutine go

end program leaving
