!> The summary of a case: a row for each method.
module taut_case_summary
   use taut_case_blas, only: blas_text
   use taut_case_csv, only: csv_field
   use taut_case_recorder, only: recorder_t
   use taut_case_row, only: row_t
   use taut_case_settings, only: method_entry_t, settings_t
   use taut_constrained_simulate, only: simulation_t
   use taut_constrained_system_tables, only: tabulated_system_t
   use taut_kinds, only: wp
   use taut_ode_options, only: integration_result_t
   use taut_ode_status, only: status_name
   implicit none (type, external)
   private
   public :: failed_row, summary_header, summary_row

   !> Its columns, before those of extremes.
   character(*), parameter :: summary_header = &
      'case,method,status,t_end,steps,rejected,rhs_evaluations,projection_iterations,jacobians,factorizations,'// &
      'newton_iterations,max_phi,max_phidot,max_phiddot,energy_drift,work,min_rank,note,wall_seconds,blas'
   character, parameter :: line_end = new_line('a')

contains

   !> The row of a method.
   subroutine summary_row(case_name, chosen, model, settings, simulation, recorder, seconds, row)
      !> Name of the case.
      character(*), intent(in) :: case_name
      !> The method.
      type(method_entry_t), intent(in) :: chosen
      !> The system.
      class(tabulated_system_t), intent(in) :: model
      !> Tolerances, and the start.
      type(settings_t), intent(in) :: settings
      !> How it went.
      type(simulation_t), intent(in) :: simulation
      !> What was seen.
      type(recorder_t), intent(in) :: recorder
      !> Wall time [s].
      real(wp), intent(in) :: seconds
      !> With its line end.
      character(:), allocatable, intent(out) :: row
      type(row_t) :: fields
      character(:), allocatable :: balance, blows, own, peaks

      associate (result => simulation%result)
         call fields%create()
         call fields%add(csv_field(case_name))
         call fields%add(chosen%label)
         call fields%add(status_name(result%status))
         call fields%add(result%t)
         call fields%add(result%steps)
         call fields%add(result%rejected)
         call fields%add(result%rhs_evaluations)
         call fields%add(simulation%ode%projector%newton%iterations)
         call fields%add(result%jacobians)
         call fields%add(result%factorizations)
         call fields%add(result%newton_iterations)
         call fields%add(recorder%max_phi)
         call fields%add(recorder%max_phidot)
         call fields%add(recorder%max_phiddot)
         call fields%add(recorder%balance%drift)
         call fields%add(recorder%balance%work)
         call fields%add(recorder%min_rank)
         call recorder%balance%remark(settings%options_of(chosen), result, settings%t_start, balance)
         call simulation%ode%remark(blows)
         call model%note(own)
         call recorder%extremes%remark(peaks)
         call fields%add(joined(joined(joined(joined(own, blows), peaks), balance), said(result)))
         call fields%add(seconds)
         call fields%add(blas_text())
         call recorder%extremes%fields(fields)
         row = fields%letters(:fields%used)//line_end
      end associate
   end subroutine summary_row

   !> What is to be said of an integration.
   function said(result) result(text)
      type(integration_result_t), intent(in) :: result
      character(:), allocatable :: text
      integer :: i

      text = ''
      do i = 1, size(result%notes)
         text = joined(text, result%notes(i)%text())
      end do
   end function said

   !> Two notes in one field.
   pure function joined(one, other) result(both)
      character(*), intent(in) :: one, other
      character(:), allocatable :: both

      both = one//other
      if (len(one) > 0 .and. len(other) > 0) both = one//'; '//other
   end function joined

   !> The row of a run that could not be made.
   function failed_row(name, case_name, message, extremes) result(row)
      !> Name of the run.
      character(*), intent(in) :: name
      !> Name of the case.
      character(*), intent(in) :: case_name
      !> Why not.
      character(*), intent(in) :: message
      !> Columns of extremes.
      integer, intent(in) :: extremes
      !> A row as those of `run_rows`: its status is `failed`, and other columns are empty.
      character(:), allocatable :: row
      integer :: i

      row = name//','//csv_field(case_name)//',,failed'// &
            repeat(',', count([(summary_header(i:i) == ',', i=1, len(summary_header))]) - 1 + extremes)// &
            csv_field(message)//line_end
   end function failed_row

end module taut_case_summary
