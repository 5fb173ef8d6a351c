!> The events that a mechanical system announces, for the integrator.
module taut_constrained_model_events
   use taut_kinds, only: wp
   use taut_constrained_system, only: state_t
   use taut_constrained_system_tables, only: tabulated_system_t
   use taut_ode_event, only: events_t
   implicit none (type, external)
   private
   public :: model_events_t

   !> Sign changes of the system's `event_values`, in its `event_direction`; those of `event_terminal` stop the integration.
   type, extends(events_t) :: model_events_t
      class(tabulated_system_t), allocatable, private :: model
      type(state_t), private :: at
   contains
      procedure :: init
      procedure :: evaluate
   end type model_events_t

contains

   !> Takes the events of a system.
   subroutine init(self, model)
      !> The events.
      class(model_events_t), intent(out) :: self
      !> The system; copied.
      class(tabulated_system_t), intent(in) :: model
      integer :: i

      allocate (self%model, source=model)
      self%direction = [(0, i=1, model%n_events)]
      self%terminal = [(.false., i=1, model%n_events)]
      if (allocated(model%event_direction)) self%direction = model%event_direction
      if (allocated(model%event_terminal)) self%terminal = model%event_terminal
      allocate (self%at%x(model%n_x), self%at%v(model%n), self%at%w(model%n_w), source=0.0_wp)
   end subroutine init

   !> The functions at a state {x; v; w}.
   subroutine evaluate(self, t, y, g)
      !> The events.
      class(model_events_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Values: (events).
      real(wp), intent(out) :: g(:)

      self%at%t = t
      self%at%x(:) = y(:self%model%n_x)
      self%at%v(:) = y(self%model%n_x + 1:self%model%n_x + self%model%n)
      self%at%w(:) = y(self%model%n_x + self%model%n + 1:)
      call self%model%event_values(self%at, g)
   end subroutine evaluate

end module taut_constrained_model_events
