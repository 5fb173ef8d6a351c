!> A state that is no mechanics: a coil whose current w, of force and decay of its own, pulls a bead along a straight wire.
!>
!> The constraint is projected on x and v alone: w is left as it is, to the last bit.
module actuator_system
   use taut
   implicit none (type, external)

   type, extends(automatic_system_t) :: actuator_t
      real(wp) :: slope = 0.5_wp                       ! of the wire
      real(wp) :: decay = 0.5_wp                       ! time constant of the current [s]
   contains
      procedure :: phi, potential, force, w_rate
   end type actuator_t

contains

   subroutine phi(self, at, value)
      class(actuator_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value(:)
      value = [at%x(2) - self%slope*at%x(1)]
   end subroutine phi

   subroutine potential(self, at, value)               ! none
      class(actuator_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value
      value = 0.0_wp*self%slope*at%t
   end subroutine potential

   subroutine force(self, at, value)                   ! 1 N for each ampere, horizontally
      class(actuator_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      call self%lagrange_force(at, value)
      value(1) = value(1) + at%w(1)
   end subroutine force

   subroutine w_rate(self, at, value)
      class(actuator_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      value = -at%w/self%decay
   end subroutine w_rate

end module actuator_system

program actuator
   use taut
   use actuator_system
   implicit none (type, external)
   type(actuator_t) :: system
   type(constrained_problem_t) :: problem
   type(state_t) :: at
   type(integration_result_t) :: result
   type(error_t), allocatable :: error
   real(wp), parameter :: t = 2.0_wp
   real(wp) :: y(5), moved(5)
   integer :: info

   call system%define(n=2, c=1, n_w=1, mass_blocks=[1, 1])
   system%diagonal_mass = [1.0_wp, 1.0_wp]             ! [kg]
   at = state_t(x=[0.0_wp, 0.0_wp], v=[0.0_wp, 0.0_wp], w=[1.0_wp])
   call simulate(system, at, t, result, error, options=integration_options_t(rtol=1.0e-9_wp, atol=1.0e-10_wp))
   if (allocated(error)) error stop 'it could not begin'
   associate (T0 => system%decay)
      print '(2a, 2f13.8)', status_name(result%status), ', x, and in closed form [m]:', at%x(1), &
         (T0*t - T0**2*(1.0_wp - exp(-t/T0)))/(1.0_wp + system%slope**2)
      print '(2a, 2f13.8)', status_name(result%status), ', w, and in closed form [A]:', at%w(1), exp(-t/T0)
   end associate

   ! A state beside the wire.
   call problem%init(system, at, error)
   if (allocated(error)) error stop 'it could not begin'
   y = problem%y + [0.1_wp, -0.2_wp, 0.3_wp, 0.1_wp, 0.0_wp]
   moved = y
   call problem%project(problem%t, moved, info)
   print '(a, 3es10.2)', 'what a projection moves, x, v and w:', norm2(moved(1:2) - y(1:2)), norm2(moved(3:4) - y(3:4)), &
      abs(moved(5) - y(5))
end program actuator
