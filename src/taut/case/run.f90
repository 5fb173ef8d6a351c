!> Runs the methods of a case side by side and writes its files.
module taut_case_run
   use, intrinsic :: iso_fortran_env, only: error_unit, int64, output_unit
   use taut_kinds, only: wp
   use taut_error, only: error_t, to_text
   use taut_case_csv, only: csv_t, number_text
   use taut_case_namelist_file, only: namelist_file_t
   use taut_case_posix, only: make_folder
   use taut_case_recorder, only: recorder_t
   use taut_case_settings, only: settings_t, method_entry_t
   use taut_constrained_formulation, only: constrained_ode_t
   use taut_constrained_model_events, only: model_events_t
   use taut_constrained_start, only: consistent_start, start_report_t
   use taut_constrained_simulate, only: simulate
   use taut_constrained_system, only: mechanical_system_t, quantity_t, state_t
   use taut_ode_options, only: integration_result_t
   use taut_ode_status, only: status_event, status_name, status_output_failed, status_reached_end
   implicit none (type, external)
   private
   public :: run_case, check_start

   character(*), parameter :: summary_header = &
      'case,method,status,t_end,steps,rejected,rhs_evaluations,projection_iterations,max_phi,max_phidot,max_phiddot,'// &
      'energy_drift,min_rank,wall_seconds'

contains

   !> Whether every method of a case can start, so that nothing is written if one cannot.
   subroutine check_start(file, model, start, settings, error)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Initial state.
      type(state_t), intent(in) :: start
      !> Methods.
      type(settings_t), intent(in) :: settings
      !> Why not.
      type(error_t), allocatable, intent(inout) :: error
      type(state_t) :: at
      type(start_report_t) :: report
      integer :: i

      do i = 1, size(settings%methods)
         at = start
         at%t = settings%t_start
         call consistent_start(model, settings%methods(i)%method, at, report, error)
         if (allocated(error)) then
            error%where = file%path//': '//error%where
            return
         end if
      end do
   end subroutine check_start

   !> Runs all methods of a case: `out/<case>/<method>.csv`, `out/<case>/summary.csv`, and `out/<case>/model.csv` if the
   !! system has quantities to tell.
   subroutine run_case(file, model, start, settings, out, quiet, all_ended, error)
      !> The case file, for its name.
      type(namelist_file_t), intent(in) :: file
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Initial state.
      type(state_t), intent(in) :: start
      !> Tolerances and methods.
      type(settings_t), intent(in) :: settings
      !> Folder for the results.
      character(*), intent(in) :: out
      !> Whether nothing is printed but errors.
      logical, intent(in) :: quiet
      !> Whether every integration reached its end or a terminal event; left alone if so.
      logical, intent(inout) :: all_ended
      !> A file that cannot be written.
      type(error_t), allocatable, intent(inout) :: error
      type(csv_t) :: events, summary
      character(:), allocatable :: folder, row
      integer :: i

      folder = out//'/'//file%name
      call make_folder(folder)
      call write_quantities(folder//'/model.csv', model%quantities(), error)
      if (allocated(error)) return
      call summary%create(folder//'/summary.csv', error)
      if (.not. allocated(error)) call summary%put(summary_header, error)
      if (model%n_events > 0) then
         if (.not. allocated(error)) call events%create(folder//'/events.csv', error)
         if (.not. allocated(error)) call events%put('method,event,t', error)
      end if
      if (.not. quiet .and. .not. allocated(error)) &
         write (output_unit, '(a, t28, a)') file%name, 'status              steps  rejected   max phi   max phidot  '// &
         'energy drift [J]  seconds'
      do i = 1, size(settings%methods)
         if (allocated(error)) exit
         call run_method(file%name, model, start, settings, settings%methods(i), folder, quiet, all_ended, events, row, error)
         if (.not. allocated(error)) call summary%put(row, error)
      end do
      if (.not. allocated(error)) call events%finish(error)
      if (.not. allocated(error)) call summary%finish(error)
      call events%discard()
      call summary%discard()
   end subroutine run_case

   !> What the system knows about itself.
   subroutine write_quantities(path, list, error)
      character(*), intent(in) :: path
      type(quantity_t), intent(in) :: list(:)
      type(error_t), allocatable, intent(inout) :: error
      type(csv_t) :: table
      integer :: i

      if (size(list) == 0) return
      call table%create(path, error)
      if (.not. allocated(error)) call table%put('name,value,unit', error)
      do i = 1, size(list)
         if (.not. allocated(error)) &
            call table%put(list(i)%name//','//number(list(i)%value)//','//list(i)%unit, error)
      end do
      if (allocated(error)) then
         call table%discard()
      else
         call table%finish(error)
      end if
   end subroutine write_quantities

   !> One method.
   subroutine run_method(case_name, model, start, settings, chosen, folder, quiet, all_ended, events, row, error)
      character(*), intent(in) :: case_name, folder
      class(mechanical_system_t), intent(in) :: model
      type(state_t), intent(in) :: start
      type(settings_t), intent(in) :: settings
      type(method_entry_t), intent(in) :: chosen
      logical, intent(in) :: quiet
      logical, intent(inout) :: all_ended
      type(csv_t), intent(inout) :: events
      character(:), allocatable, intent(out) :: row
      type(error_t), allocatable, intent(inout) :: error
      type(recorder_t) :: recorder
      type(model_events_t), allocatable :: watched
      type(integration_result_t) :: result
      type(constrained_ode_t) :: ode
      type(state_t) :: at
      integer(int64) :: before, after, rate
      real(wp) :: seconds
      integer :: i

      at = start
      at%t = settings%t_start
      call recorder%create(folder//'/'//chosen%label//'.csv', model, settings%t_start, settings%t_end, error)
      if (allocated(error)) return
      call recorder%progress%start(case_name//' '//chosen%label, quiet)
      ! An argument that is not allocated counts as not present.
      if (model%n_events > 0) then
         allocate (watched)
         call watched%init(model)
      end if
      call system_clock(before, rate)
      call simulate(model, at, settings%t_end, result, error, chosen%method, settings%options, recorder, &
                    watched, ode=ode)
      call system_clock(after)
      seconds = real(after - before, wp)/real(rate, wp)
      call recorder%progress%finish()
      ! What could not be written ends the run; what ended early is kept and told.
      if (result%status == status_output_failed .and. .not. allocated(error)) call move_alloc(result%error, error)
      if (allocated(error)) then
         call recorder%csv%discard()
         return
      end if
      call recorder%csv%finish(error)
      if (allocated(error)) return
      if (result%status /= status_reached_end .and. result%status /= status_event) then
         all_ended = .false.
         if (allocated(result%error)) write (error_unit, '(5a)') case_name, ' ', chosen%label, ': ', result%error%line()
      end if
      if (allocated(result%events)) then
         do i = 1, size(result%events)
            call events%put(chosen%label//','//model%event_name(result%events(i)%index)//','// &
                            number(result%events(i)%t), error)
            if (allocated(error)) return
         end do
      end if
      if (recorder%points == 0) recorder%min_rank = 0
      row = case_name//','//chosen%label//','//status_name(result%status)//','//number(result%t)//','// &
            to_text(result%steps)//','//to_text(result%rejected)//','//to_text(result%rhs_evaluations)//','// &
            to_text(ode%projector%iterations)//','//number(recorder%max_phi)//','//number(recorder%max_phidot)//','// &
            number(recorder%max_phiddot)//','//number(recorder%energy_drift)//','//to_text(recorder%min_rank)//','// &
            number(seconds)
      if (.not. quiet) write (output_unit, '(2x, a, t28, a, t46, i7, i10, 2es12.2, es18.3, f9.3)') chosen%label, &
         status_name(result%status), result%steps, result%rejected, recorder%max_phi, recorder%max_phidot, &
         recorder%energy_drift, seconds
   end subroutine run_method

   !> A number without blanks.
   function number(value) result(text)
      real(wp), intent(in) :: value
      character(:), allocatable :: text

      text = trim(adjustl(number_text(value)))
   end function number

end module taut_case_run
