!> The search for events: sign changes within a step, located on its continuous extension.
module taut_ode_event_search
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise
   use taut_ode_ending, only: fail
   use taut_ode_event, only: crosses, event_record_t, events_t, is_beyond
   use taut_ode_options, only: integration_result_t
   use taut_ode_status, only: status_not_started
   use taut_ode_step, only: step_t
   use taut_ode_system, only: ode_system_t, rhs_ok
   implicit none (type, external)
   private
   public :: check_events, event_search_t

   !> Values of the functions at both ends of the step at hand, and inside it: (events).
   type :: event_search_t
      real(wp), allocatable, private :: g_old(:), g_new(:), g_inside(:)
   contains
      procedure :: init
      procedure :: look
      procedure :: start
      procedure :: find
      procedure :: serialize
   end type event_search_t

contains

   !> Whether the events are set up.
   subroutine check_events(events, error)
      !> The functions.
      class(events_t), intent(in) :: events
      !> What is not.
      type(error_t), allocatable, intent(inout) :: error

      if (.not. (allocated(events%direction) .and. allocated(events%terminal))) then
         call raise(error, 'integration', 'direction or terminal of the events is not allocated', &
                    'give both one entry for each function')
      else if (size(events%direction) /= size(events%terminal)) then
         call raise(error, 'integration', 'direction and terminal of the events have different sizes', &
                    'give both one entry for each function')
      else if (allocated(events%from_start)) then
         if (size(events%from_start) /= size(events%terminal)) &
            call raise(error, 'integration', 'from_start and terminal of the events have different sizes', &
                       'give both one entry for each function')
      end if
   end subroutine check_events

   !> Room for the values; what was restored from an archive stays.
   subroutine init(self, events)
      !> The search.
      class(event_search_t), intent(inout) :: self
      !> The functions.
      class(events_t), intent(in) :: events
      integer :: n

      n = size(events%terminal)
      if (allocated(self%g_new)) deallocate (self%g_new, self%g_inside)
      allocate (self%g_new(n), self%g_inside(n), source=0.0_wp)
      if (allocated(self%g_old)) then
         if (size(self%g_old) /= n) deallocate (self%g_old)
      end if
      if (.not. allocated(self%g_old)) allocate (self%g_old(n), source=0.0_wp)
   end subroutine init

   !> The values from which sign changes are looked for.
   subroutine look(self, ode, events, t, y)
      !> The search.
      class(event_search_t), intent(inout) :: self
      !> What is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> The functions.
      class(events_t), intent(inout) :: events
      !> Time [s].
      real(wp), intent(in) :: t
      !> State: (n).
      real(wp), intent(in), contiguous :: y(:)

      call events%evaluate(ode, t, y, self%g_old)
   end subroutine look

   !> The values at the start of a motion, and the events that are met there.
   subroutine start(self, ode, events, t, y, terminal, result)
      !> The search.
      class(event_search_t), intent(inout) :: self
      !> What is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> The functions.
      class(events_t), intent(inout) :: events
      !> Time [s].
      real(wp), intent(in) :: t
      !> State: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Whether one of them ends the integration.
      logical, intent(out) :: terminal
      !> Gets the events.
      type(integration_result_t), intent(inout) :: result
      type(event_record_t) :: found
      integer :: i

      terminal = .false.
      call self%look(ode, events, t, y)
      if (.not. allocated(events%from_start)) return
      do i = 1, size(self%g_old)
         if (.not. events%from_start(i)) cycle
         if (is_beyond(self%g_old(i), events%direction(i))) then
            found%t = t
            found%index = i
            found%y = y
            result%events = [result%events, found]
            terminal = events%terminal(i)
            if (terminal) return
         else if (abs(self%g_old(i)) <= 0.0_wp .and. events%direction(i) /= 0) then
            ! What begins at zero is an event as soon as it goes beyond.
            self%g_old(i) = -sign(tiny(1.0_wp), real(events%direction(i), wp))
         end if
      end do
   end subroutine start

   !> Locates the sign changes within an accepted step and records them up to the first terminal one.
   subroutine find(self, step, ode, events, terminal, result)
      !> The search.
      class(event_search_t), intent(inout) :: self
      !> The step, which holds and is not yet accepted.
      class(step_t), intent(inout) :: step
      !> What is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> The functions.
      class(events_t), intent(inout) :: events
      !> Which of the events of the result ends the integration; 0 if none does.
      integer, intent(out) :: terminal
      !> Gets the events; an interpolation that failed is its status.
      type(integration_result_t), intent(inout) :: result
      type(event_record_t) :: found
      type(event_record_t), allocatable :: met(:)
      integer :: i, j

      terminal = 0
      call events%evaluate(ode, step%t_new, step%y_new, self%g_new)
      if (.not. any(crosses(self%g_old, self%g_new, events%direction))) then
         self%g_old(:) = self%g_new
         return
      end if
      allocate (met(0))
      do i = 1, size(self%g_new)
         if (.not. crosses(self%g_old(i), self%g_new(i), events%direction(i))) cycle
         call locate(self, step, ode, events, i, found, result)
         if (result%status /= status_not_started) return
         ! Kept in the order in which they are met.
         j = size(met)
         do while (j > 0)
            if ((met(j)%t - found%t)*step%direction <= 0.0_wp) exit
            j = j - 1
         end do
         met = [met(:j), found, met(j + 1:)]
      end do
      do i = 1, size(met)
         result%events = [result%events, met(i)]
         if (events%terminal(met(i)%index)) then
            terminal = size(result%events)
            exit
         end if
      end do
      self%g_old(:) = self%g_new
   end subroutine find

   !> One sign change to round-off of the time, by inverse quadratic interpolation and bisection on the continuous extension.
   !!
   !! Source: T.R. Chandrupatla, A new hybrid quadratic/bisection algorithm for finding the zero of a nonlinear function
   !! without using derivatives, Adv. Eng. Softw. 28 (1997) 145-149.
   subroutine locate(self, step, ode, events, index, found, result)
      type(event_search_t), intent(inout) :: self
      class(step_t), intent(inout) :: step
      class(ode_system_t), intent(inout) :: ode
      class(events_t), intent(inout) :: events
      integer, intent(in) :: index
      type(event_record_t), intent(inout) :: found
      type(integration_result_t), intent(inout) :: result
      real(wp) :: a, b, c, ga, gb, gc, g, t, fraction, width, xi, phi
      integer :: i, info

      a = step%t_new
      ga = self%g_new(index)
      b = step%t
      gb = self%g_old(index)
      c = b
      gc = gb
      fraction = 0.5_wp
      step%y_inside(:) = step%y_new
      if (abs(ga) > 0.0_wp) then
         do i = 1, 100
            t = a + fraction*(b - a)
            call step%interpolate(ode, t, info)
            if (info /= rhs_ok) then
               call fail(ode, info, t, result)
               return
            end if
            call events%evaluate(ode, t, step%y_inside, self%g_inside)
            g = self%g_inside(index)
            if ((g > 0.0_wp .and. ga > 0.0_wp) .or. (g < 0.0_wp .and. ga < 0.0_wp)) then
               c = a
               gc = ga
            else
               c = b
               gc = gb
               b = a
               gb = ga
            end if
            a = t
            ga = g
            width = 2.0_wp*spacing(max(abs(step%t), abs(step%t_new)))/max(abs(b - a), tiny(1.0_wp))
            if (abs(ga) <= 0.0_wp .or. width >= 0.5_wp) exit
            fraction = 0.5_wp
            if (abs(b - c) > 0.0_wp .and. abs(gb - gc) > 0.0_wp) then
               xi = (a - b)/(c - b)
               phi = (ga - gb)/(gc - gb)
               if (phi*phi < xi .and. (1.0_wp - phi)**2 < 1.0_wp - xi) &
                  fraction = ga/(gb - ga)*gc/(gb - gc) + (c - a)/(b - a)*ga/(gc - ga)*gb/(gc - gb)
            end if
            fraction = min(1.0_wp - width, max(width, fraction))
         end do
      end if
      ! The side beyond the sign change, so that a new start from here does not meet the same event again.
      if ((ga > 0.0_wp .and. self%g_new(index) < 0.0_wp) .or. (ga < 0.0_wp .and. self%g_new(index) > 0.0_wp)) then
         a = b
         if (abs(a - step%t_new) <= 0.0_wp) then
            step%y_inside(:) = step%y_new
         else
            call step%interpolate(ode, a, info)
            if (info /= rhs_ok) then
               call fail(ode, info, a, result)
               return
            end if
         end if
      end if
      found%t = a
      found%index = index
      found%y = step%y_inside
   end subroutine locate

   !> Passes the values at the step's start through an archive.
   subroutine serialize(self, archive)
      !> The search.
      class(event_search_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      call archive%list('events before', self%g_old)
   end subroutine serialize

end module taut_ode_event_search
