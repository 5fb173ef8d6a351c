!> Output points of an integration: where they lie, and how an observer is shown them.
module taut_ode_output
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_ode_ending, only: fail
   use taut_ode_observer, only: observer_t
   use taut_ode_options, only: integration_options_t, integration_result_t
   use taut_ode_status, only: status_not_started, status_output_failed
   use taut_ode_step, only: step_t
   use taut_ode_stepper, only: work_t
   use taut_ode_system, only: ode_system_t, rhs_ok
   implicit none (type, external)
   private
   public :: output_points_t

   !> A point that falls on a step's end but for this part of the step is the step's end.
   real(wp), parameter :: round_off = 1.0e-9_wp

   !> Where they lie, and how many were met.
   type :: output_points_t
      !> Start of the integration [s].
      real(wp) :: t_start = 0.0_wp
      !> Points so far that were known beforehand.
      integer :: count = 0
      !> Time between two points, or their times [s]; neither: each step is a point.
      real(wp), private :: dt = 0.0_wp
      real(wp), allocatable, private :: times(:)
   contains
      procedure :: init
      procedure :: begin
      procedure :: show_start
      procedure :: show_inside
      procedure :: show_end
      procedure :: show_terminal
   end type output_points_t

contains

   !> Takes what is asked for.
   subroutine init(self, options)
      !> The points.
      class(output_points_t), intent(inout) :: self
      !> What is asked for: `output_dt` or `output_times`.
      type(integration_options_t), intent(in) :: options

      self%dt = options%output_dt
      if (allocated(self%times)) deallocate (self%times)
      if (allocated(options%output_times)) self%times = options%output_times
   end subroutine init

   !> At the start of an integration: whether the points can be given.
   subroutine begin(self, t, t_end, error)
      !> The points.
      class(output_points_t), intent(inout) :: self
      !> Start [s].
      real(wp), intent(in) :: t
      !> End [s].
      real(wp), intent(in) :: t_end
      !> Times that do not lie in between in order, or too many of them.
      type(error_t), allocatable, intent(inout) :: error
      real(wp) :: before
      integer :: i

      self%t_start = t
      self%count = 0
      if (allocated(self%times)) then
         before = t
         do i = 1, size(self%times)
            associate (wanted => self%times(i))
               if (.not. ((wanted - before)*(t_end - t) >= 0.0_wp .and. (t_end - wanted)*(t_end - t) >= 0.0_wp)) then
                  call raise(error, 'integration', 'output_times('//to_text(i)//') = '//to_text(wanted)// &
                             ' s does not lie between the one before, or the start, and the end', &
                             'give times from start to end in the order in which they are met')
                  return
               end if
               before = wanted
            end associate
         end do
      else if (self%dt > 0.0_wp) then
         if (abs(t_end - t)/self%dt >= real(huge(1), wp)) &
            call raise(error, 'integration', 'output_dt = '//to_text(self%dt)//' s asks for too many points', &
                       'give a longer time, or 0 for every step')
      end if
   end subroutine begin

   !> The start is an output point, unless others are asked for.
   subroutine show_start(self, step, ode, result, observer)
      !> The points.
      class(output_points_t), intent(inout) :: self
      !> The step, at the start.
      type(step_t), intent(in) :: step
      !> What is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> Gets the status of an observer that cannot go on.
      type(integration_result_t), intent(inout) :: result
      !> Sees it.
      class(observer_t), intent(inout) :: observer

      if (allocated(self%times)) then
         if (abs(next(self, step) - step%t) > 0.0_wp) return
         self%count = 1
      end if
      call show(step, ode, step%t, 0.0_wp, step%y, result, observer)
   end subroutine show_start

   !> A step that holds, if the observer follows the steps, and points inside it that are known beforehand.
   subroutine show_inside(self, step, ode, t_last, result, observer)
      !> The points.
      class(output_points_t), intent(inout) :: self
      !> The step, before it replaces the one before.
      type(step_t), intent(inout) :: step
      !> What is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> The step's end, or where a terminal event ends it [s].
      real(wp), intent(in) :: t_last
      !> Gets the status where it cannot go on.
      type(integration_result_t), intent(inout) :: result
      !> Sees them.
      class(observer_t), intent(inout) :: observer
      real(wp) :: t
      integer :: info

      if (observer%follows) then
         call show_step(step, ode, t_last, result, observer)
         if (result%status /= status_not_started) return
      end if
      if (.not. known_beforehand(self)) return
      do
         t = next(self, step)
         if ((t - t_last)*step%direction > -round_off*abs(step%h_tried)) exit
         self%count = self%count + 1
         call step%interpolate(ode, t, info)
         if (info /= rhs_ok) call fail(ode, info, t, result)
         if (result%status /= status_not_started) return
         call show(step, ode, t, step%h_tried, step%y_inside, result, observer)
         if (result%status /= status_not_started) return
      end do
   end subroutine show_inside

   !> The step's end, if it is a point.
   subroutine show_end(self, step, ode, at_end, result, observer)
      !> The points.
      class(output_points_t), intent(inout) :: self
      !> The step, before it replaces the one before.
      type(step_t), intent(in) :: step
      !> What is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> Whether it is the end of the integration as well.
      logical, intent(in) :: at_end
      !> Gets the status of an observer that cannot go on.
      type(integration_result_t), intent(inout) :: result
      !> Sees it.
      class(observer_t), intent(inout) :: observer

      if (known_beforehand(self)) then
         if (abs(next(self, step) - step%t_new) <= round_off*abs(step%h_tried)) then
            self%count = self%count + 1
         else if (.not. (at_end .and. is_point_as_end(self, step, step%t_new))) then
            return
         end if
      end if
      call show(step, ode, step%t_new, step%h_tried, step%y_new, result, observer)
   end subroutine show_end

   !> Where a terminal event has ended the integration.
   subroutine show_terminal(self, step, ode, result, observer)
      !> The points.
      class(output_points_t), intent(in) :: self
      !> The step, brought to the event.
      type(step_t), intent(in) :: step
      !> What is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> Gets the status of an observer that cannot go on.
      type(integration_result_t), intent(inout) :: result
      !> Sees it.
      class(observer_t), intent(inout) :: observer

      if (is_point_as_end(self, step, step%t)) call show(step, ode, step%t, step%h_tried, step%y, result, observer)
   end subroutine show_terminal

   !> Whether points are at times that are known beforehand.
   pure logical function known_beforehand(self)
      type(output_points_t), intent(in) :: self

      known_beforehand = self%dt > 0.0_wp .or. allocated(self%times)
   end function known_beforehand

   !> Whether the end of the integration is a point by itself.
   pure logical function is_point_as_end(self, step, t)
      type(output_points_t), intent(in) :: self
      type(step_t), intent(in) :: step
      real(wp), intent(in) :: t

      is_point_as_end = .not. allocated(self%times)
      if (.not. is_point_as_end) is_point_as_end = abs(next(self, step) - t) <= round_off*abs(step%h_tried)
   end function is_point_as_end

   !> Time of the next point [s]; none any more: never.
   pure real(wp) function next(self, step)
      type(output_points_t), intent(in) :: self
      type(step_t), intent(in) :: step

      if (allocated(self%times)) then
         next = step%direction*huge(1.0_wp)
         if (self%count < size(self%times)) next = self%times(self%count + 1)
      else
         next = self%t_start + step%direction*(self%count + 1)*self%dt
      end if
   end function next

   !> Hands a step that holds to the observer.
   subroutine show_step(step, ode, t_last, result, observer)
      type(step_t), intent(inout) :: step
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t_last
      type(integration_result_t), intent(inout) :: result
      class(observer_t), intent(inout) :: observer
      type(error_t), allocatable :: error
      type(work_t) :: work
      integer :: counted

      ! Looking does not count as work of the method.
      work = step%stepper%work
      call ode%recount(counted, back=.false.)
      call observer%follow(ode, step, t_last, error)
      call ode%recount(counted, back=.true.)
      call step%forget_inside()
      step%stepper%work = work
      if (.not. allocated(error)) return
      result%status = status_output_failed
      call move_alloc(error, result%error)
   end subroutine show_step

   !> Hands a point to the observer.
   subroutine show(step, ode, t, h, y, result, observer)
      type(step_t), intent(in) :: step
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t, h
      real(wp), intent(in), contiguous :: y(:)
      type(integration_result_t), intent(inout) :: result
      class(observer_t), intent(inout) :: observer
      type(error_t), allocatable :: error

      call step%tell_integral(ode, t)
      call observer%observe(ode, t, h, y, error)
      if (.not. allocated(error)) return
      result%status = status_output_failed
      call move_alloc(error, result%error)
   end subroutine show

end module taut_ode_output
