!> Events: sign changes of functions of time and state along a solution.
module taut_ode_event
   use taut_kinds, only: wp
   use taut_ode_system, only: ode_system_t
   implicit none (type, external)
   private
   public :: events_t, event_record_t, crosses, is_beyond

   !> Functions g_j(t, y) whose sign changes are looked for.
   !!
   !! An extension computes them; a step that jumps over two sign changes of the same function sees none, so the
   !! largest step should not exceed the time between them.
   type, abstract :: events_t
      !> For each function: 1 for sign changes upward, -1 downward, 0 both: (events).
      integer, allocatable :: direction(:)
      !> For each function: whether the integration stops there: (events).
      logical, allocatable :: terminal(:)
      !> For each function: whether it is an event at the start already that its sign there is the one behind an event in its
      !! direction, such as a force of a rope that is slack from the beginning; not allocated: of none. (events)
      logical, allocatable :: from_start(:)
   contains
      procedure(event_functions), deferred :: evaluate
   end type events_t

   !> One event that was met.
   type :: event_record_t
      !> Time [s].
      real(wp) :: t = 0.0_wp
      !> Which function changed its sign.
      integer :: index = 0
      !> State, projected: (n).
      real(wp), allocatable :: y(:)
   end type event_record_t

   abstract interface
      !> The functions.
      subroutine event_functions(self, ode, t, y, g)
         import :: events_t, ode_system_t, wp
         implicit none (type, external)
         !> The events; a workspace of theirs may change.
         class(events_t), intent(inout) :: self
         !> The system that is integrated, which knows what its state means; it may be called, the integration does not mind.
         class(ode_system_t), intent(inout) :: ode
         !> Time [s].
         real(wp), intent(in) :: t
         !> State: (n).
         real(wp), intent(in), contiguous :: y(:)
         !> Values, of any unit: (events).
         real(wp), intent(out) :: g(:)
      end subroutine event_functions
   end interface

contains

   !> Whether a function changes its sign in the wanted direction between two values.
   elemental function crosses(g0, g1, direction) result(answer)
      !> Value at the earlier end.
      real(wp), intent(in) :: g0
      !> Value at the later end.
      real(wp), intent(in) :: g1
      !> 1 upward, -1 downward, 0 both.
      integer, intent(in) :: direction
      !> True also where the later value is zero, false where the earlier one is.
      logical :: answer

      answer = (g0 < 0.0_wp .and. g1 >= 0.0_wp .and. direction >= 0) .or. &
               (g0 > 0.0_wp .and. g1 <= 0.0_wp .and. direction <= 0)
   end function crosses

   !> Whether a value lies behind an event in the wanted direction; with both directions, nothing does.
   elemental function is_beyond(g, direction) result(answer)
      !> Value of the function.
      real(wp), intent(in) :: g
      !> 1 upward, -1 downward, 0 both.
      integer, intent(in) :: direction
      !> Whether it does.
      logical :: answer

      answer = (g > 0.0_wp .and. direction > 0) .or. (g < 0.0_wp .and. direction < 0)
   end function is_beyond

end module taut_ode_event
