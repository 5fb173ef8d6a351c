!> The events that a mechanical system announces, for the integrator.
module taut_constrained_model_events
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use taut_kinds, only: wp
   use taut_constrained_method, only: constrained_ode_t
   use taut_constrained_system, only: state_t
   use taut_constrained_system_tables, only: tabulated_system_t
   use taut_ode_event, only: events_t
   use taut_ode_system, only: ode_system_t, rhs_ok
   implicit none (type, external)
   private
   public :: model_events_t

   !> Sign changes of the system's `event_values`, in its `event_direction`; those of `event_terminal` stop the integration.
   type, extends(events_t) :: model_events_t
      type(state_t), private :: at
      real(wp), allocatable, private :: dydt(:), lambda(:)
   contains
      procedure :: init
      procedure :: evaluate
   end type model_events_t

contains

   !> Takes the events of a system.
   subroutine init(self, model)
      !> The events.
      class(model_events_t), intent(out) :: self
      !> The system.
      class(tabulated_system_t), intent(in) :: model
      integer :: i

      self%direction = [(0, i=1, model%n_events)]
      self%terminal = [(.false., i=1, model%n_events)]
      if (allocated(model%event_direction)) self%direction = model%event_direction
      if (allocated(model%event_terminal)) self%terminal = model%event_terminal
      if (allocated(model%event_from_start)) self%from_start = model%event_from_start
      allocate (self%at%x(model%n_x), self%at%v(model%n), self%at%w(model%n_w), source=0.0_wp)
   end subroutine init

   !> The functions at a state, whose layout is the method's own.
   subroutine evaluate(self, ode, t, y, g)
      !> The events.
      class(model_events_t), intent(inout) :: self
      !> The formulation of the system; of anything else there are no events.
      class(ode_system_t), intent(inout) :: ode
      !> Time [s].
      real(wp), intent(in) :: t
      !> State: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Values: (events).
      real(wp), intent(out) :: g(:)

      g(:) = 0.0_wp
      select type (ode)
      class is (constrained_ode_t)
         call ode%unpack(t, y, self%at)
         select type (model => ode%model)
         class is (tabulated_system_t)
            if (model%events_see_reactions) then
               call values_of_reactions(self, ode, model, t, y, g)
            else
               call model%event_values(self%at, g)
            end if
         end select
      end select
   end subroutine evaluate

   !> The same of functions that depend on the multipliers.
   subroutine values_of_reactions(self, ode, model, t, y, g)
      type(model_events_t), intent(inout) :: self
      class(constrained_ode_t), intent(inout) :: ode
      class(tabulated_system_t), intent(in) :: model
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(out) :: g(:)
      integer :: info, iterations

      if (.not. allocated(self%dydt)) &
         allocate (self%dydt(ode%size()), self%lambda(model%c), source=0.0_wp)
      ! Looking does not count as work of the method.
      iterations = ode%projector%newton%iterations
      call ode%rhs(t, y, self%dydt, info)
      ode%projector%newton%iterations = iterations
      if (info == rhs_ok) then
         call ode%multipliers(self%lambda)
         call model%reaction_event_values(self%at, self%lambda, g)
      else
         g(:) = ieee_value(1.0_wp, ieee_quiet_nan)
      end if
   end subroutine values_of_reactions

end module taut_constrained_model_events
