!> How an integration ended: a named status, apart from a programmer's error.
module taut_ode_status
   implicit none (type, external)
   private
   public :: status_name
   public :: status_reached_end, status_event, status_step_too_small, status_too_many_steps, status_not_finite, &
             status_rhs_failed, status_projection_failed, status_output_failed, status_not_started, status_interrupted, &
             status_no_progress

   integer, parameter :: status_reached_end = 0, status_event = 1, status_step_too_small = 2, &
                         status_too_many_steps = 3, status_not_finite = 4, status_rhs_failed = 5, &
                         status_projection_failed = 6, status_output_failed = 7, status_not_started = 8, &
                         status_interrupted = 9, status_no_progress = 10

   character(len=18), parameter :: names(0:10) = [character(len=18) :: &
                                                 'reached-end', 'stopped-by-event', 'step-too-small', &
                                                 'too-many-steps', 'not-finite', 'rhs-failed', &
                                                 'projection-failed', 'output-failed', 'not-started', 'interrupted', 'no-progress']

contains

   !> The name of a status, as summaries have it.
   pure function status_name(status) result(name)
      !> One of the `status_` constants.
      integer, intent(in) :: status
      !> One word.
      character(len=len_trim(names(status))) :: name

      name = names(status)
   end function status_name

end module taut_ode_status
