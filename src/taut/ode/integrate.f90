!> The integration loop: steps to the next stop, output, events, pauses.
module taut_ode_integrate
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_ode_event, only: crosses, event_record_t, events_t
   use taut_ode_observer, only: observer_t
   use taut_ode_options, only: integration_options_t, integration_result_t
   use taut_ode_pause, only: pause_t
   use taut_ode_status, only: status_reached_end, status_event, status_step_too_small, status_too_many_steps, &
                              status_not_finite, status_rhs_failed, status_projection_failed, status_output_failed, &
                              status_not_started, status_interrupted
   use taut_ode_step, only: step_t
   use taut_ode_system, only: ode_system_t, rhs_ok, rhs_failed, rhs_no_projection
   implicit none (type, external)
   private
   public :: integrator_t

   !> The state of an integration; nothing is allocated inside a step.
   type :: integrator_t
      !> How to integrate.
      type(integration_options_t) :: options
      type(step_t), private :: step
      real(wp), private :: t_start = 0.0_wp
      !> Breakpoints ahead and the end, and which of them is headed for.
      real(wp), allocatable, private :: stops(:)
      integer, private :: stop = 0
      !> Whether the first step towards that stop was begun.
      logical, private :: under_way = .false.
      !> Output points so far, and the reason of the last try that failed.
      integer, private :: outputs = 0, info = rhs_ok
      real(wp), allocatable, private :: g_old(:), g_new(:), g_work(:)
   contains
      procedure :: init
      procedure :: run
      procedure :: resume
      procedure :: serialize
   end type integrator_t

contains

   !> Checks the options and allocates the workspace.
   subroutine init(self, n, options, error)
      !> The integrator.
      class(integrator_t), intent(inout) :: self
      !> Size of the state.
      integer, intent(in) :: n
      !> How to integrate.
      type(integration_options_t), intent(in) :: options
      !> An option that is not valid.
      type(error_t), allocatable, intent(inout) :: error

      self%options = options
      call self%step%init(n, options, error)
      call options%check(error)
   end subroutine init

   !> Integrates from `t` to `t_end`, forwards or backwards.
   subroutine run(self, ode, t, y, t_end, result, observer, events, pause)
      !> The integrator, initialized.
      class(integrator_t), intent(inout) :: self
      !> What is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> Start; on return, the time reached [s].
      real(wp), intent(inout) :: t
      !> State at the start; on return, the state at the time reached: (n).
      real(wp), intent(inout) :: y(:)
      !> End [s].
      real(wp), intent(in) :: t_end
      !> How it went.
      type(integration_result_t), intent(out) :: result
      !> Sees the output points.
      class(observer_t), intent(inout), optional :: observer
      !> Sign changes to look for.
      class(events_t), intent(inout), optional :: events
      !> Asked before every step; the status of an integration that pauses is `status_interrupted`, and `resume` continues.
      class(pause_t), intent(inout), optional :: pause

      allocate (result%events(0))
      result%t = t
      if (.not. (ieee_is_finite(t) .and. ieee_is_finite(t_end))) then
         call raise(result%error, 'integration', 'the start or the end is not a number', &
                    'give times in seconds; to run until an event give a large one')
         return
      end if
      if (present(events)) then
         call check_events(events, result%error)
         if (allocated(result%error)) return
      end if
      if (self%options%output_dt > 0.0_wp) then
         if (abs(t_end - t)/self%options%output_dt >= real(huge(1), wp)) then
            call raise(result%error, 'integration', 'output_dt = '//to_text(self%options%output_dt)// &
                       ' s asks for too many points', &
                       'give a longer time, or 0 for every step')
            return
         end if
      end if
      self%step%direction = sign(1.0_wp, t_end - t)
      self%step%t = t
      self%step%evaluations = 0
      self%t_start = t
      self%step%y(:) = y
      self%outputs = 0
      self%info = rhs_ok
      if (present(events)) then
         call size_events(self, events)
         call events%evaluate(t, self%step%y, self%g_old)
      end if
      if (abs(t_end - t) <= 0.0_wp) then
         if (present(observer)) call show(ode, t, 0.0_wp, self%step%y, result, observer)
         if (result%status == status_not_started) result%status = status_reached_end
         return
      end if
      call find_stops(ode%breakpoints(), t, t_end, self%stops)
      self%stop = 1
      self%under_way = .false.
      call proceed(self, ode, t, y, result, observer, events, pause)
   end subroutine run

   !> Continues after a pause, bit for bit as if there had been none.
   subroutine resume(self, ode, t, y, result, observer, events, pause)
      !> The integrator as the pause left it, or restored by `serialize`.
      class(integrator_t), intent(inout) :: self
      !> What is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> On return, the time reached [s].
      real(wp), intent(inout) :: t
      !> On return, the state at the time reached: (n).
      real(wp), intent(inout) :: y(:)
      !> The result that the pause left.
      type(integration_result_t), intent(inout) :: result
      !> Sees the output points.
      class(observer_t), intent(inout), optional :: observer
      !> Sign changes to look for.
      class(events_t), intent(inout), optional :: events
      !> Asked before every step.
      class(pause_t), intent(inout), optional :: pause

      if (result%status /= status_interrupted) return
      result%status = status_not_started
      if (present(events)) then
         if (.not. allocated(self%g_new)) call size_events(self, events)
      end if
      call proceed(self, ode, t, y, result, observer, events, pause)
   end subroutine resume

   !> Whether the events are set up.
   subroutine check_events(events, error)
      class(events_t), intent(in) :: events
      type(error_t), allocatable, intent(inout) :: error

      if (.not. (allocated(events%direction) .and. allocated(events%terminal))) then
         call raise(error, 'integration', 'direction or terminal of the events is not allocated', &
                    'give both one entry for each function')
      else if (size(events%direction) /= size(events%terminal)) then
         call raise(error, 'integration', 'direction and terminal of the events have different sizes', &
                    'give both one entry for each function')
      end if
   end subroutine check_events

   !> Room for the values of the events.
   subroutine size_events(self, events)
      type(integrator_t), intent(inout) :: self
      class(events_t), intent(in) :: events
      integer :: n

      n = size(events%terminal)
      if (allocated(self%g_new)) deallocate (self%g_new, self%g_work)
      allocate (self%g_new(n), self%g_work(n), source=0.0_wp)
      if (allocated(self%g_old)) then
         if (size(self%g_old) /= n) deallocate (self%g_old)
      end if
      if (.not. allocated(self%g_old)) allocate (self%g_old(n), source=0.0_wp)
   end subroutine size_events

   !> From stop to stop.
   subroutine proceed(self, ode, t, y, result, observer, events, pause)
      type(integrator_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(inout) :: t
      real(wp), intent(inout) :: y(:)
      type(integration_result_t), intent(inout) :: result
      class(observer_t), intent(inout), optional :: observer
      class(events_t), intent(inout), optional :: events
      class(pause_t), intent(inout), optional :: pause
      logical :: last

      do
         last = self%stop == size(self%stops)
         if (self%under_way) then
            call self%step%apply_bounds(ode)
         else
            self%info = rhs_ok
            if (self%stop > 1) call self%step%cross(ode, self%stops(self%stop), self%info)
            if (self%info == rhs_ok) call self%step%begin(ode, self%stops(self%stop), self%info)
            if (self%info /= rhs_ok) call fail(ode, self%info, self%step%t, result)
            if (self%stop == 1 .and. present(observer) .and. result%status == status_not_started) &
               call show(ode, self%step%t, 0.0_wp, self%step%y, result, observer)
            if (result%status /= status_not_started) exit
            self%under_way = .true.
         end if
         call advance(self, ode, self%stops(self%stop), last, result, observer, events, pause)
         if (result%status /= status_not_started) exit
         if (last) then
            result%status = status_reached_end
            exit
         end if
         self%stop = self%stop + 1
         self%under_way = .false.
      end do
      ode%t_low = -huge(1.0_wp)
      ode%t_high = huge(1.0_wp)
      t = self%step%t
      y(:) = self%step%y
      result%t = t
      result%rhs_evaluations = self%step%evaluations
   end subroutine proceed

   !> The breakpoints between start and end in the order in which they are met, and the end.
   pure subroutine find_stops(breakpoints, t, t_end, stops)
      real(wp), intent(in) :: breakpoints(:), t, t_end
      real(wp), allocatable, intent(out) :: stops(:)
      real(wp) :: candidate, last
      integer :: i

      allocate (stops(0))
      last = t
      do
         ! The next one: the smallest distance from the last.
         candidate = t_end
         do i = 1, size(breakpoints)
            if ((breakpoints(i) - last)*(t_end - t) > 0.0_wp .and. (candidate - breakpoints(i))*(t_end - t) > 0.0_wp) &
               candidate = breakpoints(i)
         end do
         stops = [stops, candidate]
         last = candidate
         if (abs(candidate - t_end) <= 0.0_wp) exit
      end do
   end subroutine find_stops

   !> Steps to the next stop.
   subroutine advance(self, ode, stop_time, last, result, observer, events, pause)
      type(integrator_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: stop_time
      logical, intent(in) :: last
      type(integration_result_t), intent(inout) :: result
      class(observer_t), intent(inout), optional :: observer
      class(events_t), intent(inout), optional :: events
      class(pause_t), intent(inout), optional :: pause
      real(wp) :: h, h_next, least, t_new
      logical :: accepted, lands

      associate (step => self%step)
         do
            if (present(pause)) then
               if (pause%wanted()) then
                  result%status = status_interrupted
                  return
               end if
            end if
            if (result%steps + result%rejected >= self%options%max_steps) then
               result%status = status_too_many_steps
               call raise(result%error, 'integration', 'max_steps = '//to_text(self%options%max_steps)// &
                          ' steps were taken at t = '//to_text(step%t)//' s', 'allow more steps or loosen the tolerances')
               return
            end if
            h = step%direction*min(abs(step%h), self%options%max_step)
            ! Near t = 0 round-off is that of the first steps.
            least = max(self%options%min_step, 10.0_wp*spacing(max(abs(step%t), min(abs(stop_time), 1.0e-3_wp))))
            lands = abs(h)*1.01_wp >= abs(stop_time - step%t)
            if (.not. step%control%aware_of_projection .and. .not. step%control%fixed) &
               lands = abs(h) >= abs(stop_time - step%t)
            if (lands) h = stop_time - step%t
            if (abs(h) < least .and. .not. lands) then
               call give_up(ode, self%info, h, step%t, result)
               return
            end if
            t_new = step%t + h
            if (lands) t_new = stop_time
            call step%try(ode, t_new, h, h_next, accepted, self%info)
            if (self%info == rhs_failed .or. (self%info /= rhs_ok .and. step%control%fixed)) then
               call fail(ode, self%info, step%t, result)
               return
            end if
            if (.not. accepted) then
               result%rejected = result%rejected + 1
               if (lands .and. abs(h_next) < least) then
                  call give_up(ode, self%info, h_next, step%t, result)
                  return
               end if
               step%h = h_next
               cycle
            end if
            result%steps = result%steps + 1
            call look(self, ode, t_new, h, lands .and. last, result, observer, events)
            if (result%status /= status_not_started) return
            call step%accept(t_new, h_next)
            if (lands) return
         end do
      end associate
   end subroutine advance

   !> Events and output of an accepted step, before it replaces the one before.
   subroutine look(self, ode, t_new, h, at_end, result, observer, events)
      type(integrator_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t_new, h
      logical, intent(in) :: at_end
      type(integration_result_t), intent(inout) :: result
      class(observer_t), intent(inout), optional :: observer
      class(events_t), intent(inout), optional :: events
      real(wp) :: t_shown, t_last
      integer :: first_terminal

      t_last = t_new
      first_terminal = 0
      if (self%options%output_dt > 0.0_wp .or. present(events)) call self%step%prepare_interpolation(h)
      if (present(events)) call find_events(self, ode, t_new, h, t_last, first_terminal, result, events)

      if (present(observer) .and. self%options%output_dt > 0.0_wp) then
         do
            t_shown = self%t_start + self%step%direction*(self%outputs + 1)*self%options%output_dt
            ! A point that falls on the step's end but for round-off is the step's end.
            if ((t_shown - t_last)*self%step%direction > -1.0e-9_wp*abs(h)) exit
            self%outputs = self%outputs + 1
            call interpolate(self, ode, t_shown, h, result)
            if (result%status /= status_not_started) return
            call show(ode, t_shown, h, self%step%y_work, result, observer)
            if (result%status /= status_not_started) return
         end do
      end if

      if (first_terminal > 0) then
         self%step%t = t_last
         self%step%y(:) = result%events(first_terminal)%y
         result%status = status_event
         if (present(observer)) call show(ode, self%step%t, h, self%step%y, result, observer)
         return
      end if
      if (.not. present(observer)) return
      if (self%options%output_dt > 0.0_wp) then
         t_shown = self%t_start + self%step%direction*(self%outputs + 1)*self%options%output_dt
         if (abs(t_shown - t_new) <= 1.0e-9_wp*abs(h)) then
            self%outputs = self%outputs + 1
         else if (.not. at_end) then
            return
         end if
      end if
      call show(ode, t_new, h, self%step%y_new, result, observer)
      if (result%status /= status_not_started) then
         self%step%t = t_new
         self%step%y(:) = self%step%y_new
      end if
   end subroutine look

   !> The state inside the current step, in the step's `y_work`.
   subroutine interpolate(self, ode, t, h, result)
      type(integrator_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t, h
      type(integration_result_t), intent(inout) :: result
      integer :: info

      call self%step%interpolate(ode, t, h, info)
      if (info /= rhs_ok) call fail(ode, info, t, result)
   end subroutine interpolate

   !> Locates the sign changes within an accepted step and records them up to the first terminal one.
   subroutine find_events(self, ode, t_new, h, t_last, first_terminal, result, events)
      type(integrator_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t_new, h
      real(wp), intent(inout) :: t_last
      integer, intent(out) :: first_terminal
      type(integration_result_t), intent(inout) :: result
      class(events_t), intent(inout) :: events
      type(event_record_t) :: found
      type(event_record_t), allocatable :: met(:)
      integer :: i, j

      first_terminal = 0
      call events%evaluate(t_new, self%step%y_new, self%g_new)
      if (.not. any(crosses(self%g_old, self%g_new, events%direction))) then
         self%g_old(:) = self%g_new
         return
      end if
      allocate (met(0))
      do i = 1, size(self%g_new)
         if (.not. crosses(self%g_old(i), self%g_new(i), events%direction(i))) cycle
         call locate(self, ode, t_new, h, i, found, result, events)
         if (result%status /= status_not_started) return
         ! Kept in the order in which they are met.
         j = size(met)
         do while (j > 0)
            if ((met(j)%t - found%t)*self%step%direction <= 0.0_wp) exit
            j = j - 1
         end do
         met = [met(:j), found, met(j + 1:)]
      end do
      do i = 1, size(met)
         result%events = [result%events, met(i)]
         if (events%terminal(met(i)%index)) then
            t_last = met(i)%t
            first_terminal = size(result%events)
            exit
         end if
      end do
      self%g_old(:) = self%g_new
   end subroutine find_events

   !> One sign change to round-off of the time, by inverse quadratic interpolation and bisection on the continuous extension.
   !!
   !! Source: T.R. Chandrupatla, A new hybrid quadratic/bisection algorithm for finding the zero of a nonlinear function
   !! without using derivatives, Adv. Eng. Softw. 28 (1997) 145-149.
   subroutine locate(self, ode, t_new, h, index, found, result, events)
      type(integrator_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t_new, h
      integer, intent(in) :: index
      type(event_record_t), intent(inout) :: found
      type(integration_result_t), intent(inout) :: result
      class(events_t), intent(inout) :: events
      real(wp) :: a, b, c, ga, gb, gc, g, t, fraction, width, xi, phi
      integer :: i

      a = t_new
      ga = self%g_new(index)
      b = self%step%t
      gb = self%g_old(index)
      c = b
      gc = gb
      fraction = 0.5_wp
      self%step%y_work(:) = self%step%y_new
      if (abs(ga) > 0.0_wp) then
         do i = 1, 100
            t = a + fraction*(b - a)
            call interpolate(self, ode, t, h, result)
            if (result%status /= status_not_started) return
            call events%evaluate(t, self%step%y_work, self%g_work)
            g = self%g_work(index)
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
            width = 2.0_wp*spacing(max(abs(self%step%t), abs(t_new)))/max(abs(b - a), tiny(1.0_wp))
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
         if (abs(a - t_new) <= 0.0_wp) then
            self%step%y_work(:) = self%step%y_new
         else
            call interpolate(self, ode, a, h, result)
            if (result%status /= status_not_started) return
         end if
      end if
      found%t = a
      found%index = index
      found%y = self%step%y_work
   end subroutine locate

   !> Hands a point to the observer.
   subroutine show(ode, t, h, y, result, observer)
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t, h
      real(wp), intent(in), contiguous :: y(:)
      type(integration_result_t), intent(inout) :: result
      class(observer_t), intent(inout) :: observer
      type(error_t), allocatable :: error

      call observer%observe(ode, t, h, y, error)
      if (.not. allocated(error)) return
      result%status = status_output_failed
      call move_alloc(error, result%error)
   end subroutine show

   !> The steps have become too small: the last reason for it names the status.
   subroutine give_up(ode, info, h, t, result)
      class(ode_system_t), intent(in) :: ode
      integer, intent(in) :: info
      real(wp), intent(in) :: h, t
      type(integration_result_t), intent(inout) :: result

      if (info == rhs_ok) then
         result%status = status_step_too_small
         call raise(result%error, 'integration', 'a step of '//to_text(abs(h))//' s would be needed at t = '// &
                    to_text(t)//' s, below the smallest one', &
                    'loosen the tolerances, or look for a jump in the forces (a breakpoint) '// &
                    'or constraints that cannot be met any more')
      else
         call fail(ode, info, t, result)
      end if
   end subroutine give_up

   !> The right-hand side or the projection failed for good.
   subroutine fail(ode, info, t, result)
      class(ode_system_t), intent(in) :: ode
      integer, intent(in) :: info
      real(wp), intent(in) :: t
      type(integration_result_t), intent(inout) :: result
      character(:), allocatable :: why

      call ode%failure(why)
      select case (info)
      case (rhs_no_projection)
         result%status = status_projection_failed
         call raise(result%error, 'integration', 'the projection on the constraints failed near t = '//to_text(t)//' s: '//why, &
                    'tighten the tolerances or bound the step')
      case (rhs_failed)
         result%status = status_rhs_failed
         call raise(result%error, 'integration', 'the right-hand side failed near t = '//to_text(t)//' s: '//why, &
                    'see what the model says of this state')
      case default
         result%status = status_not_finite
         if (len(why) > 0) why = ': '//why
         call raise(result%error, 'integration', 'the solution is not finite near t = '//to_text(t)//' s'//why, &
                    'bound the step, or look for a singularity of the model')
      end select
   end subroutine fail

   !> Passes an integration that pauses through an archive: what `resume` needs, in an integrator initialized with the same
   !! options.
   subroutine serialize(self, archive)
      !> The integrator.
      class(integrator_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      call self%step%serialize(archive)
      call archive%item('start', self%t_start)
      call archive%list('stops', self%stops)
      call archive%item('stop', self%stop)
      call archive%item('under way', self%under_way)
      call archive%item('outputs', self%outputs)
      call archive%item('last answer', self%info)
      call archive%list('events before', self%g_old)
   end subroutine serialize

end module taut_ode_integrate
