!> A mechanism from a case file with a force of one's own: a wind that pushes the rod of cases/mechanism/simple_pendulum.nml.
!!
!! In closed form J w^2/2 = m g L/2 sin(angle below the horizontal) + work of the wind, J = m L^2/3.
module windy_mechanism
   use taut
   use taut_model_mechanism, only: mechanism_t
   implicit none (type, external)

   type, extends(mechanism_t) :: windy_t
      real(wp) :: wind = -9.81_wp                       ! along x, on the center of the first body [N]
   contains
      procedure :: force
   end type windy_t

contains

   subroutine force(self, at, value)                    ! in the order of the velocities: vx, vy, wz of the rod
      class(windy_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      call self%mechanism_t%force(at, value)            ! gravity, springs, loads of the case file
      value(1) = value(1) + self%wind
   end subroutine force

end module windy_mechanism

program wind
   use taut
   use taut_case_mechanism, only: read_mechanism
   use taut_case_namelist_file, only: namelist_file_t
   use taut_case_settings, only: settings_t
   use taut_model_mechanism_report, only: mechanism_report_t
   use windy_mechanism
   implicit none (type, external)
   type(namelist_file_t) :: file
   type(windy_t) :: pendulum
   type(state_t) :: at
   type(settings_t) :: settings
   type(mechanism_report_t) :: report
   type(method_t) :: method
   type(integration_result_t) :: result
   type(error_t), allocatable :: error
   real(wp), parameter :: m = 1.0_wp, l = 1.0_wp, g = 9.81_wp

   call file%load('cases/mechanism/simple_pendulum.nml', error)
   if (.not. allocated(error)) call read_mechanism(file, pendulum%mechanism_t, at, settings, report, error)
   method%weight = 'mass'                               ! as the app has it
   if (.not. allocated(error)) call simulate(pendulum, at, 1.0_wp, result, error, method, settings%options)
   if (allocated(error)) then
      print '(a)', error%line()
      error stop 1
   end if
   associate (angle => at%x(3), w => at%v(3))
      print '(2a, 2f13.8)', status_name(result%status), ', rate and in closed form [rad/s]:', abs(w), &
         sqrt(6.0_wp/(m*l**2)*(m*g*l/2*sin(-angle) + pendulum%wind*l/2*(cos(angle) - 1.0_wp)))
   end associate
end program wind
