!> The integration loop: Dormand-Prince steps, their control, projection, output and events.
module taut_ode_integrate
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_ode_dormand_prince, only: stages, node, stage_state, error_estimate, dense_coefficients, dense_value
   use taut_ode_event, only: crosses, event_record_t, events_t
   use taut_ode_observer, only: observer_t
   use taut_ode_options, only: integration_options_t, integration_result_t
   use taut_ode_status, only: status_reached_end, status_event, status_step_too_small, status_too_many_steps, &
                              status_not_finite, status_rhs_failed, status_projection_failed, status_output_failed, &
                              status_not_started
   use taut_ode_step_control, only: step_control_t
   use taut_ode_system, only: ode_system_t, rhs_ok, rhs_retry, rhs_failed, rhs_no_projection
   implicit none (type, external)
   private
   public :: integrator_t

   !> The state of an integration and its workspace; nothing is allocated inside a step.
   type :: integrator_t
      !> How to integrate.
      type(integration_options_t) :: options
      type(step_control_t), private :: control
      integer, private :: n = 0
      real(wp), private :: direction = 1.0_wp, t = 0.0_wp, h = 0.0_wp, t_start = 0.0_wp
      !> Times between which the right-hand side is evaluated: inside two breakpoints.
      real(wp), private :: t_low = -huge(1.0_wp), t_high = huge(1.0_wp)
      integer, private :: outputs = 0
      real(wp), allocatable, private :: y(:), y_new(:), y_work(:), error(:), k(:, :), dense(:, :)
      real(wp), allocatable, private :: g_old(:), g_new(:), g_work(:)
   contains
      procedure :: init
      procedure :: run
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
      call self%control%init(n, trim(options%step_control), trim(options%norm), options%rtol, options%atol, &
                             options%atol_of, error)
      call options%check(error)
      self%n = n
      if (allocated(self%y)) deallocate (self%y, self%y_new, self%y_work, self%error, self%k, self%dense)
      allocate (self%y(n), self%y_new(n), self%y_work(n), self%error(n), self%k(n, stages), self%dense(n, 5), source=0.0_wp)
   end subroutine init

   !> Integrates from `t` to `t_end`, forwards or backwards.
   subroutine run(self, ode, t, y, t_end, result, observer, events)
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
      real(wp), allocatable :: stops(:)
      integer :: i

      allocate (result%events(0))
      result%t = t
      if (.not. (ieee_is_finite(t) .and. ieee_is_finite(t_end))) then
         call raise(result%error, 'integration', 'the start or the end is not a number', &
                    'give times in seconds; to run until an event give a large one')
         return
      end if
      if (present(events)) then
         if (.not. (allocated(events%direction) .and. allocated(events%terminal))) then
            call raise(result%error, 'integration', 'direction or terminal of the events is not allocated', &
                       'give both one entry for each function')
         else if (size(events%direction) /= size(events%terminal)) then
            call raise(result%error, 'integration', 'direction and terminal of the events have different sizes', &
                       'give both one entry for each function')
         end if
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
      self%direction = sign(1.0_wp, t_end - t)
      self%t = t
      self%t_start = t
      self%y(:) = y
      self%outputs = 0
      if (present(events)) then
         if (allocated(self%g_old)) deallocate (self%g_old, self%g_new, self%g_work)
         allocate (self%g_old(size(events%terminal)), self%g_new(size(events%terminal)), &
                   self%g_work(size(events%terminal)), source=0.0_wp)
         call events%evaluate(self%t, self%y, self%g_old)
      end if
      if (abs(t_end - t) <= 0.0_wp) then
         if (present(observer)) call show(ode, t, 0.0_wp, self%y, result, observer)
         if (result%status == status_not_started) result%status = status_reached_end
         result%t = t
         return
      end if
      call find_stops(ode%breakpoints(), t, t_end, stops)

      do i = 1, size(stops)
         call set_bounds(self, stops(i))
         call start(self, ode, stops(i), result)
         if (i == 1 .and. present(observer) .and. result%status == status_not_started) &
            call show(ode, self%t, 0.0_wp, self%y, result, observer)
         if (result%status == status_not_started) &
            call advance(self, ode, stops(i), i == size(stops), result, observer, events)
         if (result%status /= status_not_started) exit
      end do
      if (result%status == status_not_started) result%status = status_reached_end
      t = self%t
      y(:) = self%y
      result%t = t
   end subroutine run

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

   !> Times for the right-hand side between here and the next stop: a load may jump at either end, and the first stage has
   !! to see it after the jump behind, the last one before the jump ahead.
   pure subroutine set_bounds(self, stop_time)
      type(integrator_t), intent(inout) :: self
      real(wp), intent(in) :: stop_time

      self%t_low = min(nearest(self%t, self%direction), nearest(stop_time, -self%direction))
      self%t_high = max(nearest(self%t, self%direction), nearest(stop_time, -self%direction))
   end subroutine set_bounds

   !> One evaluation of the right-hand side.
   subroutine evaluate(self, ode, t, y, dydt, info, result)
      type(integrator_t), intent(in) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(out), contiguous :: dydt(:)
      integer, intent(out) :: info
      type(integration_result_t), intent(inout) :: result

      call ode%rhs(min(max(t, self%t_low), self%t_high), y, dydt, info)
      result%rhs_evaluations = result%rhs_evaluations + 1
   end subroutine evaluate

   !> First stage and first step of a stretch without breakpoints.
   subroutine start(self, ode, stop_time, result)
      type(integrator_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: stop_time
      type(integration_result_t), intent(inout) :: result
      real(wp) :: h, h1, slope, curvature, scale
      integer :: info

      call self%control%renew()
      call evaluate(self, ode, self%t, self%y, self%k(:, 1), info, result)
      if (info == rhs_ok .and. .not. all(ieee_is_finite(self%k(:, 1)))) info = rhs_retry
      if (info /= rhs_ok) then
         call fail(ode, info, self%t, result)
         return
      end if
      if (self%options%first_step > 0.0_wp) then
         self%h = self%direction*self%options%first_step
         return
      end if
      ! Hairer, Norsett, Wanner, Sect. II.4: an Euler step tells the second derivative.
      slope = self%control%norm(self%k(:, 1), self%y, self%y)
      scale = self%control%norm(self%y, self%y, self%y)
      h = 1.0e-6_wp
      if (slope > 1.0e-5_wp .and. scale > 1.0e-5_wp) h = 0.01_wp*scale/slope
      h = self%direction*min(h, self%options%max_step, abs(stop_time - self%t))
      self%y_new(:) = self%y + h*self%k(:, 1)
      call evaluate(self, ode, self%t + h, self%y_new, self%k(:, 2), info, result)
      self%h = h
      if (info /= rhs_ok) return
      if (.not. all(ieee_is_finite(self%k(:, 2)))) return
      self%error(:) = (self%k(:, 2) - self%k(:, 1))/h
      curvature = self%control%norm(self%error, self%y, self%y)
      if (max(slope, curvature) > 1.0e-15_wp) then
         h1 = (0.01_wp/max(slope, curvature))**0.2_wp
      else
         h1 = max(1.0e-6_wp, 1.0e-3_wp*abs(h))
      end if
      self%h = self%direction*max(min(100.0_wp*abs(h), h1), self%options%min_step)
   end subroutine start

   !> Steps to the next stop.
   subroutine advance(self, ode, stop_time, last, result, observer, events)
      type(integrator_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: stop_time
      logical, intent(in) :: last
      type(integration_result_t), intent(inout) :: result
      class(observer_t), intent(inout), optional :: observer
      class(events_t), intent(inout), optional :: events
      real(wp) :: h, h_next, least, t_new
      logical :: accepted, lands
      integer :: info

      info = rhs_ok
      do
         if (result%steps + result%rejected >= self%options%max_steps) then
            result%status = status_too_many_steps
            call raise(result%error, 'integration', 'max_steps = '//to_text(self%options%max_steps)//' steps were taken at t = '// &
                       to_text(self%t)//' s', 'allow more steps or loosen the tolerances')
            return
         end if
         h = self%direction*min(abs(self%h), self%options%max_step)
         ! Near t = 0 round-off is that of the first steps.
         least = max(self%options%min_step, 10.0_wp*spacing(max(abs(self%t), min(abs(stop_time), 1.0e-3_wp))))
         lands = abs(h)*1.01_wp >= abs(stop_time - self%t)
         if (.not. self%control%aware_of_projection .and. .not. self%control%fixed) lands = abs(h) >= abs(stop_time - self%t)
         if (lands) h = stop_time - self%t
         if (abs(h) < least .and. .not. lands) then
            call give_up(ode, info, h, self%t, result)
            return
         end if
         t_new = self%t + h
         if (lands) t_new = stop_time
         call try_step(self, ode, t_new, h, h_next, accepted, info, result)
         if (info == rhs_failed .or. (info /= rhs_ok .and. self%control%fixed)) then
            call fail(ode, info, self%t, result)
            return
         end if
         if (.not. accepted) then
            result%rejected = result%rejected + 1
            if (lands .and. abs(h_next) < least) then
               call give_up(ode, info, h_next, self%t, result)
               return
            end if
            self%h = h_next
            cycle
         end if
         result%steps = result%steps + 1
         call look(self, ode, t_new, h, lands .and. last, result, observer, events)
         if (result%status /= status_not_started) return
         self%h = h_next
         self%t = t_new
         self%y(:) = self%y_new
         self%k(:, 1) = self%k(:, stages)
         if (lands) return
      end do
   end subroutine advance

   !> One try: stages, error, projection and acceptance are one decision. On acceptance `y_new` and the last stage hold the
   !! state that is continued and its derivative.
   subroutine try_step(self, ode, t_new, h, h_next, accepted, info, result)
      type(integrator_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t_new, h
      real(wp), intent(out) :: h_next
      logical, intent(out) :: accepted
      integer, intent(out) :: info
      type(integration_result_t), intent(inout) :: result
      logical :: stale
      integer :: i
      real(wp) :: t_stage

      accepted = .false.
      h_next = h
      do i = 2, stages
         call stage_state(i, h, self%y, self%k, self%y_new)
         if (i == stages) then
            if (.not. all(ieee_is_finite(self%y_new))) then
               info = rhs_retry
               exit
            end if
         end if
         t_stage = self%t + node(i)*h
         if (i >= stages - 1) t_stage = t_new
         call evaluate(self, ode, t_stage, self%y_new, self%k(:, i), info, result)
         if (info /= rhs_ok) exit
         ! Checked at each stage, so that no right-hand side is given a state that is not a number.
         if (.not. all(ieee_is_finite(self%k(:, i)))) then
            info = rhs_retry
            exit
         end if
      end do
      if (info /= rhs_ok) then
         call self%control%reduce(h_next)
         return
      end if
      call error_estimate(h, self%k, self%error)
      if (self%control%aware_of_projection) call ode%filter_error(self%error)
      call self%control%decide(h, self%error, self%y, self%y_new, h_next, accepted)
      if (.not. accepted) return

      self%y_work(:) = self%y_new
      call ode%project(t_new, self%y_new, .true., stale, info)
      if (info /= rhs_ok) then
         accepted = .false.
         h_next = h
         call self%control%reduce(h_next)
         return
      end if
      if (self%control%aware_of_projection .and. ode%limits_projection) then
         self%y_work(:) = self%y_work - self%y_new
         if (self%control%norm(self%y_work, self%y, self%y_new) > self%options%projection_limit) then
            accepted = .false.
            h_next = h
            call self%control%reduce(h_next)
            return
         end if
      end if
      if (stale) then
         call evaluate(self, ode, t_new, self%y_new, self%k(:, stages), info, result)
         if (info == rhs_ok .and. .not. all(ieee_is_finite(self%k(:, stages)))) info = rhs_retry
         if (info /= rhs_ok) then
            accepted = .false.
            h_next = h
            call self%control%reduce(h_next)
         end if
      end if
   end subroutine try_step

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
      if (self%options%output_dt > 0.0_wp .or. present(events)) &
         call dense_coefficients(h, self%y, self%y_new, self%k, self%dense)
      if (present(events)) call find_events(self, ode, t_new, h, t_last, first_terminal, result, events)

      if (present(observer) .and. self%options%output_dt > 0.0_wp) then
         do
            t_shown = self%t_start + self%direction*(self%outputs + 1)*self%options%output_dt
            ! A point that falls on the step's end but for round-off is the step's end.
            if ((t_shown - t_last)*self%direction > -1.0e-9_wp*abs(h)) exit
            self%outputs = self%outputs + 1
            call interpolate(self, ode, t_shown, h, self%y_work, result)
            if (result%status /= status_not_started) return
            call show(ode, t_shown, h, self%y_work, result, observer)
            if (result%status /= status_not_started) return
         end do
      end if

      if (first_terminal > 0) then
         self%t = t_last
         self%y(:) = result%events(first_terminal)%y
         result%status = status_event
         if (present(observer)) call show(ode, self%t, h, self%y, result, observer)
         return
      end if
      if (.not. present(observer)) return
      if (self%options%output_dt > 0.0_wp) then
         t_shown = self%t_start + self%direction*(self%outputs + 1)*self%options%output_dt
         if (abs(t_shown - t_new) <= 1.0e-9_wp*abs(h)) then
            self%outputs = self%outputs + 1
         else if (.not. at_end) then
            return
         end if
      end if
      call show(ode, t_new, h, self%y_new, result, observer)
      if (result%status /= status_not_started) then
         self%t = t_new
         self%y(:) = self%y_new
      end if
   end subroutine look

   !> The state inside the current step, on the system's invariants.
   subroutine interpolate(self, ode, t, h, y, result)
      type(integrator_t), intent(in) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t, h
      real(wp), intent(out), contiguous :: y(:)
      type(integration_result_t), intent(inout) :: result
      logical :: stale
      integer :: info

      call dense_value((t - self%t)/h, self%dense, y)
      call ode%project(t, y, .false., stale, info)
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
      call events%evaluate(t_new, self%y_new, self%g_new)
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
            if ((met(j)%t - found%t)*self%direction <= 0.0_wp) exit
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
      b = self%t
      gb = self%g_old(index)
      c = b
      gc = gb
      fraction = 0.5_wp
      self%y_work(:) = self%y_new
      if (abs(ga) > 0.0_wp) then
         do i = 1, 100
            t = a + fraction*(b - a)
            call interpolate(self, ode, t, h, self%y_work, result)
            if (result%status /= status_not_started) return
            call events%evaluate(t, self%y_work, self%g_work)
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
            width = 2.0_wp*spacing(max(abs(self%t), abs(t_new)))/max(abs(b - a), tiny(1.0_wp))
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
            self%y_work(:) = self%y_new
         else
            call interpolate(self, ode, a, h, self%y_work, result)
            if (result%status /= status_not_started) return
         end if
      end if
      found%t = a
      found%index = index
      found%y = self%y_work
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

end module taut_ode_integrate
