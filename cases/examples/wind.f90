!> A mechanism from a case file with a force of one's own: a wind that pushes the rod of cases/mechanism/simple_pendulum.nml.
!!
!! In closed form J w^2/2 = m g L/2 sin(angle below the horizontal) + work of the wind, J = m L^2/3.
module windy_mechanism
   use taut
   implicit none (type, external)

   type, extends(mechanism_t) :: windy_t
      real(wp) :: wind = -9.81_wp                       ! along x, on the center of a body [N]
      integer :: pushed = 0                             ! which
   contains
      procedure :: force
   end type windy_t

contains

   subroutine force(self, at, value)                    ! in the order of the velocities: vx, vy, wz of each body in the plane
      class(windy_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      call self%mechanism_t%force(at, value)            ! gravity, springs, loads of the case file
      associate (before => self%bodies(self%pushed)%before_v)
         value(before + 1) = value(before + 1) + self%wind
      end associate
   end subroutine force

end module windy_mechanism

program wind
   use taut
   use windy_mechanism
   implicit none (type, external)
   type(windy_t) :: pendulum
   type(state_t) :: at
   type(method_t) :: method
   type(integration_options_t) :: options
   type(integration_result_t) :: result
   type(error_t), allocatable :: error
   real(wp), parameter :: m = 1.0_wp, l = 1.0_wp, g = 9.81_wp

   call read_mechanism('cases/mechanism/simple_pendulum.nml', pendulum%mechanism_t, at, error, method, options)
   if (.not. allocated(error)) then
      pendulum%pushed = pendulum%body_index('rod')
      call simulate(pendulum, at, 1.0_wp, result, error, method, options)
   end if
   if (allocated(error)) error stop error%line()
   associate (angle => at%x(3), w => at%v(3))
      print '(2a, 2f13.8)', status_name(result%status), ', rate and in closed form [rad/s]:', abs(w), &
         sqrt(6.0_wp/(m*l**2)*(m*g*l/2*sin(-angle) + pendulum%wind*l/2*(cos(angle) - 1.0_wp)))
   end associate
end program wind
