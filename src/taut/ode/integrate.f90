!> The integration loop: steps to the next stop, with events, output and pauses in between.
module taut_ode_integrate
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_archive, only: archive_t
   use taut_kinds, only: last_place, wp
   use taut_error, only: error_t, raise, to_text
   use taut_ode_ending, only: fail, give_up, no_progress
   use taut_ode_event, only: events_t
   use taut_ode_event_search, only: check_events, event_search_t
   use taut_ode_note, only: note_bound_by_stability, note_no_progress, note_no_time, note_t
   use taut_ode_observer, only: observer_t
   use taut_ode_options, only: integration_options_t, integration_result_t
   use taut_ode_output, only: output_points_t
   use taut_ode_pause, only: pause_t
   use taut_ode_status, only: status_reached_end, status_event, status_too_many_steps, status_not_started, &
                              status_interrupted
   use taut_ode_step, only: step_t
   use taut_ode_stepper, only: stepper_t, work_t
   use taut_ode_system, only: ode_system_t, rhs_cannot, rhs_failed, rhs_ok
   implicit none (type, external)
   private
   public :: integrator_t

   !> A run that does not get on is told by its steps: so many tries rejected in a row; or so many steps in which their length
   !! does not double, at a rate at which the end would take twice as many as may be taken, and no fewer than 2e8.
   integer, parameter :: most_rejected = 300, window = 1000
   real(wp), parameter :: hopeless = 2.0e8_wp

   !> The state of an integration; nothing is allocated inside a step.
   type :: integrator_t
      !> How to integrate.
      type(integration_options_t) :: options
      type(step_t), private :: step
      !> Breakpoints ahead and the end, and which of them is headed for.
      real(wp), allocatable, private :: stops(:)
      integer, private :: stop = 0
      !> Whether the first step towards that stop was begun.
      logical, private :: under_way = .false.
      !> The reason of the last try that failed.
      integer, private :: info = rhs_ok
      type(event_search_t), private :: search
      type(output_points_t), private :: output
      !> Tries rejected in a row; steps since the rate was looked at last, and their length then.
      integer, private :: rejected_in_a_row = 0, in_window = 0
      !> Whether steps that do not get on were found to be no fault of the system.
      logical, private :: patient = .false.
      real(wp), private :: h_before = 0.0_wp
   contains
      procedure :: init
      procedure :: run
      procedure :: resume
      procedure :: serialize
   end type integrator_t

contains

   !> Checks the options and allocates the workspace.
   subroutine init(self, n, options, error, stepper)
      !> The integrator.
      class(integrator_t), intent(inout) :: self
      !> Size of the state.
      integer, intent(in) :: n
      !> How to integrate.
      type(integration_options_t), intent(in) :: options
      !> An option that is not valid.
      type(error_t), allocatable, intent(inout) :: error
      !> A stepper of one's own, in the place of the one that `options%integrator` names; copied.
      class(stepper_t), intent(in), optional :: stepper

      self%options = options
      call self%step%init(n, options, error, stepper)
      call self%output%init(options)
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
      logical :: met

      allocate (result%events(0), result%notes(0))
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
      call self%output%init(self%options)
      call self%output%begin(t, t_end, result%error)
      if (allocated(result%error)) return
      self%step%direction = sign(1.0_wp, t_end - t)
      self%step%t = t
      ode%has_integral = ode%has_integral .and. self%step%stepper%takes_integral
      self%step%integral = 0.0_wp
      self%step%integral_error = 0.0_wp
      self%step%moved = 0.0_wp
      self%step%stepper%work = work_t()
      self%step%y(:) = y
      self%info = rhs_ok
      self%rejected_in_a_row = 0
      self%in_window = 0
      self%patient = .false.
      self%h_before = 0.0_wp
      if (present(observer)) call observer%begin()
      met = .false.
      if (present(events)) then
         call self%search%init(events)
         call self%search%start(ode, events, t, self%step%y, met, result)
      end if
      if (abs(t_end - t) <= 0.0_wp .or. met) then
         if (present(observer)) call self%output%show_start(self%step, ode, result, observer)
         if (result%status == status_not_started) result%status = merge(status_event, status_reached_end, met)
         if (.not. met) result%notes = [note_t(note_no_time, t)]
         if (present(observer)) call observer%finish()
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
      if (present(events)) call self%search%init(events)
      call proceed(self, ode, t, y, result, observer, events, pause)
   end subroutine resume

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
            if (self%info /= rhs_ok) call fail(ode, self%info, self%step%t, result, self%step%stepper)
            if (self%stop == 1 .and. present(observer) .and. result%status == status_not_started) &
               call self%output%show_start(self%step, ode, result, observer)
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
      if (present(observer) .and. result%status /= status_interrupted) call observer%finish()
      t = self%step%t
      y(:) = self%step%y
      ode%integral = self%step%integral
      ode%integral_error = self%step%integral_error
      result%t = t
      associate (work => self%step%stepper%work)
         result%rhs_evaluations = work%rhs
         result%jacobians = work%jacobians
         result%factorizations = work%factorizations
         result%newton_iterations = work%iterations
      end associate
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
      logical :: accepted, lands, replaced

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
            least = max(self%options%min_step, 10.0_wp*last_place(max(abs(step%t), min(abs(stop_time), 1.0e-3_wp))))
            lands = abs(h)*1.01_wp >= abs(stop_time - step%t)
            if (.not. step%control%aware_of_projection .and. .not. step%control%fixed) &
               lands = abs(h) >= abs(stop_time - step%t)
            if (lands) h = stop_time - step%t
            if (abs(h) < least .and. .not. lands) then
               call give_up(ode, self%info, h, step%t, result, step%stepper)
               return
            end if
            t_new = step%t + h
            if (lands) t_new = stop_time
            call step%try(ode, t_new, h, h_next, accepted, self%info)
            if (self%info == rhs_failed .or. self%info == rhs_cannot .or. (self%info /= rhs_ok .and. step%control%fixed)) then
               call fail(ode, self%info, step%t, result, step%stepper)
               return
            end if
            if (.not. accepted) then
               result%rejected = result%rejected + 1
               self%rejected_in_a_row = self%rejected_in_a_row + 1
               if (self%rejected_in_a_row >= most_rejected .and. .not. self%patient) then
                  call doubt(self, ode, self%rejected_in_a_row, h, 0.0_wp, result)
                  if (result%status /= status_not_started) return
               end if
               if (lands .and. abs(h_next) < least) then
                  call give_up(ode, self%info, h_next, step%t, result, step%stepper)
                  return
               end if
               step%h = h_next
               cycle
            end if
            result%steps = result%steps + 1
            self%rejected_in_a_row = 0
            call look(self, ode, lands .and. last, result, observer, events)
            if (result%status /= status_not_started) return
            call step%accept(ode, h_next, replaced, self%info)
            if (replaced) then
               if (self%info /= rhs_ok) then
                  call fail(ode, self%info, step%t, result)
                  return
               end if
               if (present(events)) call self%search%look(ode, events, step%t, step%y)
            end if
            if (step%stepper%bound_by_stability) call note_once(note_bound_by_stability, step%t, result)
            call look_at_rate(self, ode, h, result, events)
            if (result%status /= status_not_started .or. lands) return
         end do
      end associate
   end subroutine advance

   !> Whether the steps get on. Where a terminal event may be the end, nobody knows how many it takes; and who asks for
   !> steps no longer than these has asked for their number.
   subroutine look_at_rate(self, ode, h, result, events)
      type(integrator_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: h
      type(integration_result_t), intent(inout) :: result
      class(events_t), intent(in), optional :: events
      real(wp) :: needed

      self%in_window = self%in_window + 1
      if (self%in_window < window) return
      self%in_window = 0
      needed = abs(self%stops(size(self%stops)) - self%step%t)/abs(h)
      if (needed > max(hopeless, 2.0_wp*self%options%max_steps) .and. abs(h) <= 2.0_wp*self%h_before .and. &
          abs(h) < self%options%max_step .and. .not. (self%step%control%fixed .or. self%patient)) then
         if (present(events)) then
            if (any(events%terminal)) return
         end if
         call doubt(self, ode, window, h, needed, result)
      end if
      self%h_before = abs(h)
   end subroutine look_at_rate

   !> Steps do not get on: a fault of the system ends the run; one that is right goes on, and that is noted.
   subroutine doubt(self, ode, steps, h, needed, result)
      type(integrator_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      integer, intent(in) :: steps
      real(wp), intent(in) :: h, needed
      type(integration_result_t), intent(inout) :: result
      character(:), allocatable :: fault

      call ode%find_fault(self%step%t, self%step%y, self%patient, fault)
      self%patient = self%patient .and. len(fault) == 0
      if (self%patient) then
         call note_once(note_no_progress, self%step%t, result)
      else
         call no_progress(steps, h, needed, self%step%t, fault, result)
      end if
   end subroutine doubt

   !> Adds a note, unless it is there.
   subroutine note_once(code, t, result)
      integer, intent(in) :: code
      real(wp), intent(in) :: t
      type(integration_result_t), intent(inout) :: result

      if (any(result%notes%code == code)) return
      result%notes = [result%notes, note_t(code, t)]
   end subroutine note_once

   !> Events and output of a step that holds, before it replaces the one before.
   subroutine look(self, ode, at_end, result, observer, events)
      type(integrator_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      logical, intent(in) :: at_end
      type(integration_result_t), intent(inout) :: result
      class(observer_t), intent(inout), optional :: observer
      class(events_t), intent(inout), optional :: events
      real(wp) :: t_last
      integer :: terminal

      associate (step => self%step)
         t_last = step%t_new
         terminal = 0
         if (present(events)) then
            call self%search%find(step, ode, events, terminal, result)
            if (terminal > 0) t_last = result%events(terminal)%t
         end if

         if (present(observer)) then
            call self%output%show_inside(step, ode, t_last, result, observer)
            if (result%status /= status_not_started) return
         end if

         if (terminal > 0) then
            step%integral = step%integral_at(t_last)
            step%t = t_last
            step%y(:) = result%events(terminal)%y
            result%status = status_event
            if (present(observer)) call self%output%show_terminal(step, ode, result, observer)
            return
         end if
         if (.not. present(observer)) return
         call self%output%show_end(step, ode, at_end, result, observer)
         if (result%status /= status_not_started) then
            step%integral = ode%integral
            step%t = step%t_new
            step%y(:) = step%y_new
         end if
      end associate
   end subroutine look

   !> Passes an integration that pauses through an archive: what `resume` needs, in an integrator initialized with the same
   !! options.
   subroutine serialize(self, archive)
      !> The integrator.
      class(integrator_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive
      logical :: sound

      call self%step%serialize(archive)
      call archive%item('start', self%output%t_start)
      call archive%list('stops', self%stops)
      call archive%item('stop', self%stop)
      call archive%item('under way', self%under_way)
      call archive%item('outputs', self%output%count)
      call archive%item('last answer', self%info)
      call archive%item('rejected in a row', self%rejected_in_a_row)
      call archive%item('steps in the window', self%in_window)
      call archive%item('patient', self%patient)
      call archive%item('step before the window', self%h_before)
      call self%search%serialize(archive)
      if (allocated(archive%error) .or. .not. archive%reading) return
      sound = allocated(self%stops)
      if (sound) sound = self%stop >= 1 .and. self%stop <= size(self%stops) .and. all(ieee_is_finite(self%stops)) .and. &
                         ieee_is_finite(self%step%direction)
      if (sound) sound = abs(abs(self%step%direction) - 1.0_wp) <= 0.0_wp
      if (.not. sound) &
         call raise(archive%error, 'archive', 'it is of no integration under way', 'use the program that wrote it')
   end subroutine serialize

end module taut_ode_integrate
