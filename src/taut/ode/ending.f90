!> Why an integration ended before its time, in words.
module taut_ode_ending
   use taut_kinds, only: wp
   use taut_error, only: raise, to_text
   use taut_ode_options, only: integration_result_t
   use taut_ode_status, only: status_no_progress, status_step_too_small, status_not_finite, status_rhs_failed, &
                              status_projection_failed
   use taut_ode_stepper, only: stepper_t
   use taut_ode_system, only: ode_system_t, rhs_ok, rhs_cannot, rhs_failed, rhs_no_projection, rhs_not_finite, rhs_not_solved
   implicit none (type, external)
   private
   public :: fail, give_up, no_progress

contains

   !> The steps have become too small: the last reason for it names the status.
   subroutine give_up(ode, info, h, t, result, stepper)
      !> What is integrated.
      class(ode_system_t), intent(in) :: ode
      !> Answer of the last try: one of the `rhs_` constants.
      integer, intent(in) :: info
      !> Length of the step that would be needed [s].
      real(wp), intent(in) :: h
      !> Time [s].
      real(wp), intent(in) :: t
      !> Gets its status and its error.
      type(integration_result_t), intent(inout) :: result
      !> Its last try is the reason.
      class(stepper_t), intent(in) :: stepper

      if (info == rhs_ok) then
         result%status = status_step_too_small
         call raise(result%error, 'integration', 'a step of '//to_text(abs(h))//' s would be needed at t = '// &
                    to_text(t)//' s, below the smallest one', &
                    'loosen the tolerances, or look for a jump in the forces (a breakpoint) '// &
                    'or constraints that cannot be met any more')
      else
         call fail(ode, info, t, result, stepper)
      end if
   end subroutine give_up

   !> The right-hand side or the projection failed for good.
   subroutine fail(ode, info, t, result, stepper)
      !> What is integrated.
      class(ode_system_t), intent(in) :: ode
      !> Its answer: one of the `rhs_` constants.
      integer, intent(in) :: info
      !> Time [s].
      real(wp), intent(in) :: t
      !> Gets its status and its error.
      type(integration_result_t), intent(inout) :: result
      !> Asked for the reason if it was its try that has failed.
      class(stepper_t), intent(in), optional :: stepper
      character(:), allocatable :: why

      if (present(stepper)) then
         call stepper%failure(ode, why)
      else
         call ode%failure(why)
      end if
      select case (info)
      case (rhs_no_projection)
         result%status = status_projection_failed
         call raise(result%error, 'integration', 'the projection on the constraints failed near t = '//to_text(t)//' s: '//why, &
                    'tighten the tolerances or bound the step')
      case (rhs_failed)
         result%status = status_rhs_failed
         call raise(result%error, 'integration', 'the right-hand side failed near t = '//to_text(t)//' s: '//why, &
                    'see what the model says of this state')
      case (rhs_cannot)
         result%status = status_rhs_failed
         if (len(why) > 0) then
            call raise(result%error, 'integration', why, 'install it, or choose an explicit integrator')
         else
            call raise(result%error, 'integration', 'the system gives no linearization, which this integrator asks for', &
                       'choose an explicit integrator, or give the system `linearize`, `factorize` and `solve`')
         end if
      case (rhs_not_solved)
         result%status = status_step_too_small
         if (len(why) > 0) why = ': '//why
         call raise(result%error, 'integration', 'the equations of an implicit step were not solved near t = '//to_text(t)// &
                    ' s'//why, 'look for a jump in the forces (a breakpoint) or constraints that cannot be met any more')
      case (rhs_not_finite)
         result%status = status_not_finite
         call ode%entry_name(ode%not_finite, why)
         call raise(result%error, 'integration', why//' is not a number near t = '//to_text(t)//' s', &
                    'look for a division by zero or a root of something negative there, or for a singularity of the model')
      case default
         result%status = status_not_finite
         if (len(why) > 0) why = ': '//why
         call raise(result%error, 'integration', 'the solution is not finite near t = '//to_text(t)//' s'//why, &
                    'bound the step, or look for a singularity of the model')
      end select
   end subroutine fail

   !> Steps do not get on.
   subroutine no_progress(steps, h, needed, t, fault, result)
      !> How many there were in a row.
      integer, intent(in) :: steps
      !> How long they are [s].
      real(wp), intent(in) :: h
      !> How many more the end would take at this rate; 0: they are rejected.
      real(wp), intent(in) :: needed
      !> Time [s].
      real(wp), intent(in) :: t
      !> What was found to be wrong with the system; empty if nothing was.
      character(*), intent(in) :: fault
      !> Gets its status and its error.
      type(integration_result_t), intent(inout) :: result
      character(:), allocatable :: what

      result%status = status_no_progress
      what = to_text(steps)//' tries in a row were rejected at t = '//to_text(t)//' s'
      if (needed > 0.0_wp) what = to_text(steps)//' steps in a row of '//to_text(abs(h))//' s or less do not get on at t = '// &
                                  to_text(t)//' s: the end would take '//to_text(needed)//' of them'
      if (len(fault) > 0) then
         call raise(result%error, 'integration', what//'; '//fault, 'mend it: `verify` lists all that is wrong')
         return
      end if
      call raise(result%error, 'integration', what, 'check the derivatives of the model there (`verify`), look for constraints '// &
                 'that contradict each other, or take an implicit integrator if the forces are stiff')
   end subroutine no_progress

end module taut_ode_ending
