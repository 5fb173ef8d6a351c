!> From a system and its initial state to its motion, in one call.
module taut_constrained_simulate
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   use taut_error, only: error_t
   use taut_constrained_method, only: constrained_ode_t
   use taut_constrained_method_choose, only: new_constrained_ode
   use taut_constrained_first_look, only: first_look, look_at_dependence
   use taut_constrained_method_options, only: method_t
   use taut_constrained_model_events, only: model_events_t
   use taut_constrained_stepper_choose, only: choose_constrained_stepper
   use taut_constrained_start, only: consistent_start, start_report_t
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_constrained_system_tables, only: tabulated_system_t
   use taut_ode_event, only: events_t
   use taut_ode_integrate, only: integrator_t
   use taut_ode_options, only: integration_options_t, integration_result_t
   use taut_ode_observer, only: observer_t
   use taut_ode_pause, only: pause_t
   use taut_ode_status, only: status_event, status_not_started, status_reached_end
   use taut_ode_stepper, only: stepper_t
   implicit none (type, external)
   private
   public :: simulate, simulation_t

   !> Methods that let constraints go, a little or altogether.
   character(*), parameter :: without_constraints(4) = [character(len=20) :: 'unconstrained', 'penalty', 'bayo-penalty', &
                                                        'augmented-lagrangian']
   !> Rows of A up to which their dependence is looked at.
   integer, parameter :: most_rows = 300

   !> A simulation that can pause, be stored and continue: `init`, `run`, and after a pause `resume`.
   !!
   !! One that was stored continues, in another program if need be, with `init` of the same arguments, `serialize` from the
   !! archive, and `resume`.
   type :: simulation_t
      !> The formulation, for its counters and `sample`.
      class(constrained_ode_t), allocatable :: ode
      !> How it went so far.
      type(integration_result_t) :: result
      !> State at the time reached, its time included.
      type(state_t) :: at
      type(integrator_t), private :: integrator
      real(wp), allocatable, private :: y(:)
   contains
      procedure :: init
      procedure :: run
      procedure :: resume
      procedure :: serialize
   end type simulation_t

contains

   !> Sets a system, a method and options together.
   subroutine init(self, model, error, method, options)
      !> The simulation.
      class(simulation_t), intent(out) :: self
      !> The system; copied.
      class(mechanical_system_t), intent(in) :: model
      !> Sizes or options that are not valid.
      type(error_t), allocatable, intent(inout) :: error
      !> The method; default: `present`.
      type(method_t), intent(in), optional :: method
      !> Tolerances and steps.
      type(integration_options_t), intent(in), optional :: options
      type(method_t) :: chosen
      type(integration_options_t) :: settings
      class(stepper_t), allocatable :: stepper

      if (present(method)) chosen = method
      if (present(options)) settings = options
      call choose_constrained_stepper(settings, chosen, stepper, error)
      if (allocated(error)) return
      call new_constrained_ode(self%ode, model, chosen, error, stepper)
      if (allocated(error)) return
      call leave_out(self%ode, settings)
      call self%integrator%init(self%ode%size(), settings, error, stepper)
      if (allocated(error)) return
      allocate (self%y(self%ode%size()), source=0.0_wp)
      allocate (self%at%x(model%n_x), self%at%v(model%n), self%at%w(model%n_w), source=0.0_wp)
   end subroutine init

   !> What a method does not measure has no part in the norm of errors: its tolerance is endless.
   subroutine leave_out(ode, settings)
      class(constrained_ode_t), intent(in) :: ode
      type(integration_options_t), intent(inout) :: settings
      logical :: out(ode%size())
      integer :: i

      call ode%unmeasured(out)
      if (.not. any(out)) return
      if (.not. allocated(settings%atol_of)) settings%atol_of = [(settings%atol, i=1, ode%model%n_x + ode%model%n + ode%model%n_w)]
      if (size(settings%atol_of) == ode%model%n_x + ode%model%n + ode%model%n_w) &
         settings%atol_of = [settings%atol_of, (huge(1.0_wp), i=size(settings%atol_of) + 1, size(out))]
      if (size(settings%atol_of) /= size(out)) return
      where (out) settings%atol_of = huge(1.0_wp)
   end subroutine leave_out

   !> Brings the initial state to the constraints and integrates.
   subroutine run(self, at, t_end, error, observer, events, start, pause, held)
      !> The simulation, initialized.
      class(simulation_t), intent(inout) :: self
      !> Initial state, its time included.
      type(state_t), intent(in) :: at
      !> End [s]; may lie before the start.
      real(wp), intent(in) :: t_end
      !> What is not valid: an end that is no number, or an initial state that no projection mends.
      type(error_t), allocatable, intent(inout) :: error
      !> Sees the output points.
      class(observer_t), intent(inout), optional :: observer
      !> Sign changes to look for.
      class(events_t), intent(inout), optional :: events
      !> How far the initial state was moved.
      type(start_report_t), intent(out), optional :: start
      !> Asked before every step whether to pause.
      class(pause_t), intent(inout), optional :: pause
      !> Velocities that start as given, and with them coordinates; the others are moved to meet the constraints: (n). Default:
      !! none.
      logical, intent(in), optional :: held(:)
      type(start_report_t) :: report

      self%at = at
      call consistent_start(self%ode%model, self%ode%options, self%at, report, error, held)
      if (present(start)) start = report
      if (allocated(error)) return
      call self%ode%pack(self%at, self%y)
      call self%ode%begin(self%at)
      call self%integrator%run(self%ode, self%at%t, self%y, t_end, self%result, observer, events, pause)
      if (self%result%status == status_not_started .and. allocated(self%result%error)) then
         call move_alloc(self%result%error, error)
         return
      end if
      call self%ode%unpack(self%at%t, self%y, self%at)
   end subroutine run

   !> Continues after a pause, or after `serialize` has restored one.
   subroutine resume(self, observer, events, pause)
      !> The simulation.
      class(simulation_t), intent(inout) :: self
      !> Sees the output points.
      class(observer_t), intent(inout), optional :: observer
      !> Sign changes to look for.
      class(events_t), intent(inout), optional :: events
      !> Asked before every step whether to pause.
      class(pause_t), intent(inout), optional :: pause

      call self%integrator%resume(self%ode, self%at%t, self%y, self%result, observer, events, pause)
      call self%ode%unpack(self%at%t, self%y, self%at)
   end subroutine resume

   !> Passes a simulation that pauses through an archive.
   subroutine serialize(self, archive)
      !> The simulation; initialized with the same arguments if it is restored.
      class(simulation_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      call self%ode%serialize(archive)
      call self%result%serialize(archive)
      call self%integrator%serialize(archive)
   end subroutine serialize

   !> Brings the initial state to the constraints and integrates, in one call.
   !!
   !! `error` says whether the call went well: it is allocated unless the end was reached, or a terminal event. Everything up
   !! to then has been seen by the observer, and is in `result` and `at`; `result%status` says in one word how it ended.
   subroutine simulate(model, at, t_end, result, error, method, options, observer, events, start, ode, look, held)
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Initial state, its time included; on return, the state at the time reached.
      type(state_t), intent(inout) :: at
      !> End [s]; may lie before the start.
      real(wp), intent(in) :: t_end
      !> How it went.
      type(integration_result_t), intent(out) :: result
      !> What is not valid: sizes, options, or an initial state that no projection mends; or why the integration ended early.
      type(error_t), allocatable, intent(inout) :: error
      !> The method; default: `present`.
      type(method_t), intent(in), optional :: method
      !> Tolerances and steps.
      type(integration_options_t), intent(in), optional :: options
      !> Sees the output points.
      class(observer_t), intent(inout), optional :: observer
      !> Sign changes to look for; default: those that the system announces.
      class(events_t), intent(inout), optional :: events
      !> How far the initial state was moved.
      type(start_report_t), intent(out), optional :: start
      !> The formulation, for its counters.
      class(constrained_ode_t), allocatable, intent(out), optional :: ode
      !> Whether to look first, at little cost, if the system's derivatives are right; what is certainly wrong is an error. Default
      !! true.
      logical, intent(in), optional :: look
      !> Velocities that start as given, and with them coordinates; the others are moved to meet the constraints: (n). Default:
      !! none.
      logical, intent(in), optional :: held(:)
      type(simulation_t) :: simulation
      type(model_events_t), allocatable :: announced
      logical :: looks

      call simulation%init(model, error, method, options)
      looks = .true.
      if (present(look)) looks = look
      if (looks .and. .not. allocated(error)) call look_at_start(simulation, at, error, held)
      if (allocated(error)) return
      if (present(events)) then
         call simulation%run(at, t_end, error, observer, events, start, held=held)
      else
         call find_events(simulation%ode, announced)
         call simulation%run(at, t_end, error, observer, announced, start, held=held)
      end if
      at = simulation%at
      if (.not. allocated(error)) then
         result = simulation%result
         if (result%status /= status_reached_end .and. result%status /= status_event) error = result%error
      end if
      if (present(ode)) call move_alloc(simulation%ode, ode)
   end subroutine simulate

   !> The events that a system announces, if there are any.
   subroutine find_events(ode, events)
      class(constrained_ode_t), intent(in) :: ode
      type(model_events_t), allocatable, intent(out) :: events

      select type (model => ode%model)
      class is (tabulated_system_t)
         if (model%n_events == 0) return
         allocate (events)
         call events%init(model)
      end select
   end subroutine find_events

   !> Looks at a system where it starts; a start that cannot be is for `run` to tell.
   subroutine look_at_start(simulation, at, error, held)
      type(simulation_t), intent(in) :: simulation
      type(state_t), intent(in) :: at
      type(error_t), allocatable, intent(inout) :: error
      logical, intent(in), optional :: held(:)
      type(state_t) :: there
      type(start_report_t) :: report
      type(error_t), allocatable :: no_start

      there = at
      call consistent_start(simulation%ode%model, simulation%ode%options, there, report, no_start, held)
      if (allocated(no_start)) return
      associate (model => simulation%ode%model, method => simulation%ode%options)
         call first_look(model, there, error)
         ! What lets constraints go asks for no accelerations that keep them.
         if (allocated(error) .or. method%accept_inconsistent .or. any(method%name == without_constraints)) return
         if (report%rank < model%c .and. model%c <= most_rows) call look_at_dependence(model, there, error)
      end associate
   end subroutine look_at_start

end module taut_constrained_simulate
