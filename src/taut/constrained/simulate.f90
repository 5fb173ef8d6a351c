!> From a system and its initial state to its motion, in one call.
module taut_constrained_simulate
   use taut_kinds, only: wp
   use taut_error, only: error_t
   use taut_constrained_formulation, only: constrained_ode_t
   use taut_constrained_method, only: method_t
   use taut_constrained_start, only: consistent_start, start_report_t
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_ode_event, only: events_t
   use taut_ode_integrate, only: integrator_t
   use taut_ode_options, only: integration_options_t, integration_result_t
   use taut_ode_observer, only: observer_t
   use taut_ode_status, only: status_not_started
   implicit none (type, external)
   private
   public :: simulate

contains

   !> Brings the initial state to the constraints and integrates.
   !!
   !! An integration that ends early is no error here: see `result%status` and `result%error`; everything up to then
   !! has been seen by the observer.
   subroutine simulate(model, at, t_end, result, error, method, options, observer, events, start, ode)
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Initial state, its time included; on return, the state at the time reached.
      type(state_t), intent(inout) :: at
      !> End [s]; may lie before the start.
      real(wp), intent(in) :: t_end
      !> How it went.
      type(integration_result_t), intent(out) :: result
      !> What is not valid: sizes, options, or an initial state that no projection mends.
      type(error_t), allocatable, intent(inout) :: error
      !> The method; default: `present`.
      type(method_t), intent(in), optional :: method
      !> Tolerances and steps.
      type(integration_options_t), intent(in), optional :: options
      !> Sees the output points.
      class(observer_t), intent(inout), optional :: observer
      !> Sign changes to look for.
      class(events_t), intent(inout), optional :: events
      !> How far the initial state was moved.
      type(start_report_t), intent(out), optional :: start
      !> The formulation, for its counters.
      type(constrained_ode_t), intent(out), optional, target :: ode
      type(constrained_ode_t), target :: own_ode
      type(constrained_ode_t), pointer :: used
      type(method_t) :: chosen
      type(integration_options_t) :: settings
      type(integrator_t) :: integrator
      type(start_report_t) :: report
      real(wp), allocatable :: y(:)

      if (present(method)) chosen = method
      if (present(options)) settings = options
      used => own_ode
      if (present(ode)) used => ode
      call used%init(model, chosen, error)
      if (allocated(error)) return
      call integrator%init(used%size(), settings, error)
      if (allocated(error)) return
      call consistent_start(model, chosen, at, report, error)
      if (present(start)) start = report
      if (allocated(error)) return
      allocate (y(used%size()))
      call used%pack(at, y)
      call integrator%run(used, at%t, y, t_end, result, observer, events)
      if (result%status == status_not_started .and. allocated(result%error)) then
         call move_alloc(result%error, error)
         return
      end if
      call used%unpack(at%t, y, at)
   end subroutine simulate

end module taut_constrained_simulate
