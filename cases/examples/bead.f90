!> A bead slides on the parabolic wire z = a x^2, with viscous drag: a system of one's own, and one constraint on it.
module bead_system
   use taut
   implicit none (type, external)

   type, extends(automatic_system_t) :: bead_t
      real(wp) :: m = 2.0_wp, g = 9.81_wp           ! mass [kg], gravity against z [m/s^2]
      real(wp) :: a = 1.0_wp, d = 0.0_wp            ! of the wire [1/m], of the drag [N s/m]
   contains
      procedure :: force, phi
   end type bead_t

contains

   subroutine force(self, at, value)                ! M vdot = f
      class(bead_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      value = [0.0_wp, -self%m*self%g] - self%d*at%v
   end subroutine force

   subroutine phi(self, at, value)                  ! phi(x, t) = 0; its derivatives follow
      class(bead_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value(:)
      value(1) = at%x(2) - self%a*at%x(1)**2
   end subroutine phi

end module bead_system

program bead
   use taut
   use bead_system
   implicit none (type, external)
   type(bead_t) :: system
   type(state_t) :: at
   type(integration_result_t) :: result
   type(error_t), allocatable :: error

   call system%define(n=2, c=1, mass_blocks=[1, 1]) ! two velocities, one constraint, a diagonal M
   system%diagonal_mass = [system%m, system%m]
   at%x = [1.0_wp, 1.0_wp]                          ! on the wire
   at%v = [0.1_wp, 0.2_wp]
   call simulate(system, at, 10.0_wp, result, error)
   if (allocated(error)) then
      print '(a)', error%line()
      error stop 1
   end if
   print '(a, 2f12.6, a, es9.1)', status_name(result%status), at%x, '  phi =', at%x(2) - system%a*at%x(1)**2
   print '(a, f12.6)', 'height of its energy [m]:', at%x(2) + 0.5_wp*sum(at%v**2)/system%g
end program bead
