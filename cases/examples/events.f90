!> An observer and events: a pendulum of 1 m is let go from the horizontal; its largest tension, and when it passes the bottom.
module watching
   use taut
   implicit none (type, external)

   !> Keeps the largest tension that it sees.
   type, extends(observer_t) :: peak_t
      real(wp) :: tension = 0.0_wp, time = 0.0_wp
      type(sample_t) :: seen
   contains
      procedure :: observe
   end type peak_t

   !> One function whose sign changes are looked for: x.
   type, extends(events_t) :: bottom_t
      type(state_t) :: at
   contains
      procedure :: evaluate
   end type bottom_t

contains

   subroutine observe(self, ode, t, h, y, error)        ! called at every output point
      class(peak_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t, h                      ! time, and the step that led here [s]
      real(wp), intent(in), contiguous :: y(:)          ! {x; v; w}
      type(error_t), allocatable, intent(inout) :: error
      integer :: info
      if (h < 0.0_wp) call raise(error, 'peak', 'time runs backwards')
      select type (ode)
      class is (constrained_ode_t)
         call ode%sample(t, y, self%seen, info)         ! lambda, mu, phi, energy, rank, ...
         if (info /= rhs_ok .or. self%seen%lambda(1) <= self%tension) return
         self%tension = self%seen%lambda(1)
         self%time = t
      end select
   end subroutine observe

   subroutine evaluate(self, ode, t, y, g)              ! called at every step, and inside one where a sign changes
      class(bottom_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(out) :: g(:)
      select type (ode)
      class is (constrained_ode_t)
         call ode%unpack(t, y, self%at)                 ! each method has its own layout of y
      end select
      g(1) = self%at%x(1)
   end subroutine evaluate

end module watching

program events
   use taut
   use watching
   implicit none (type, external)
   type(chain_model_t) :: pendulum
   type(state_t) :: at
   type(peak_t) :: peak
   type(bottom_t) :: bottom
   type(integration_result_t) :: result
   class(constrained_ode_t), allocatable :: ode
   type(sample_t) :: seen
   type(error_t), allocatable :: error
   integer :: info

   call new_chain_model(pendulum, 1, 1.0_wp, 1.0_wp, 9.81_wp, error)   ! one rod of 1 m, 1 kg at its end
   call pendulum%start(0.0_wp, at)                      ! horizontal, at rest
   bottom%direction = [-1]                              ! only where x goes from positive to negative
   bottom%terminal = [.false.]
   bottom%at = at                                       ! room for a state
   call simulate(pendulum, at, 2.0_wp, result, error, observer=peak, events=bottom, ode=ode, &
                 options=integration_options_t(rtol=1.0e-9_wp, output_dt=0.01_wp))
   if (allocated(error)) error stop 'it could not begin'
   call ode%sample(result%events(1)%t, result%events(1)%y, seen, info)
   print '(a, 2f12.6)', 'time at the bottom, and in closed form [s]:', result%events(1)%t, &
      gamma(0.25_wp)**2/(4.0_wp*sqrt(acos(-1.0_wp)))/sqrt(9.81_wp)
   print '(a, 2f12.6)', 'tension there, and in closed form [N]:', seen%lambda(1), 3.0_wp*9.81_wp
   print '(a, f12.6, a, f6.2, a)', 'largest at an output point [N]:', peak%tension, ' at', peak%time, ' s'
end program events
