!> Runs the methods of a case one after the other and writes its files.
module taut_case_run
   use, intrinsic :: iso_fortran_env, only: error_unit, int64
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_case_checkpoint, only: checkpoint_file, store_origin, watch_t, write_checkpoint
   use taut_case_csv, only: csv_field, csv_t
   use taut_case_extremes, only: extremes_t
   use taut_case_identity, only: identity
   use taut_case_number, only: number_text
   use taut_case_namelist_file, only: namelist_file_t
   use taut_case_posix, only: remove_file, remove_remainders
   use taut_case_process, only: caught_signal, say
   use taut_case_recorder, only: recorder_t
   use taut_case_settings, only: settings_t, method_entry_t
   use taut_case_summary, only: summary_header, summary_row
   use taut_constrained_model_events, only: model_events_t
   use taut_constrained_start, only: consistent_start, start_report_t
   use taut_constrained_simulate, only: simulation_t
   use taut_constrained_system, only: state_t
   use taut_constrained_system_tables, only: quantity_t, tabulated_system_t
   use taut_ode_status, only: status_event, status_interrupted, status_name, status_output_failed, status_reached_end
   implicit none (type, external)
   private
   public :: run_case, run_rows, run_options_t, check_start

   character, parameter :: line_end = new_line('a')

   !> Where and how to run a case.
   type :: run_options_t
      !> Name of the app.
      character(:), allocatable :: app
      !> Folder of the case's results; not allocated if nothing is written but rows.
      character(:), allocatable :: folder
      !> Whether nothing is printed but errors.
      logical :: quiet = .false.
      !> Wall time between checkpoints [s]; 0 for none but those that signals ask for.
      real(wp) :: checkpoint = 0.0_wp
   end type run_options_t

   !> How far a case is; checkpoints hold it.
   type :: progress_of_case_t
      !> What the results depend on besides the program, as it was when the case was begun; not passed through an archive.
      character(:), allocatable :: identity
      !> The method at work.
      integer :: method = 1
      !> Lines of the summary and of the table of events so far, each with its line end.
      character(:), allocatable :: rows, events
      !> Wall time of the method at work before this process [s].
      real(wp) :: seconds = 0.0_wp
      !> Whether the head of the table on the screen was written.
      logical :: listed = .false.
   contains
      procedure :: serialize
      procedure :: list
   end type progress_of_case_t

contains

   !> Whether every method of a case can start and the columns exist, so that nothing is written otherwise.
   subroutine check_start(file, model, start, settings, error)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> The system.
      class(tabulated_system_t), intent(in) :: model
      !> Initial state.
      type(state_t), intent(in) :: start
      !> Methods.
      type(settings_t), intent(in) :: settings
      !> Why not.
      type(error_t), allocatable, intent(inout) :: error
      type(state_t) :: at
      type(start_report_t) :: report
      type(recorder_t) :: recorder
      integer :: i

      call recorder%prepare(model, settings, error)
      if (allocated(error)) error%where = file%path//': '//error%where
      do i = 1, size(settings%methods)
         if (allocated(error)) return
         at = start
         at%t = settings%t_start
         call consistent_start(model, settings%methods(i)%method, at, report, error)
         if (allocated(error)) error%where = file%path//': '//error%where
      end do
   end subroutine check_start

   !> Passes it through an archive.
   subroutine serialize(self, archive)
      !> How far a case is.
      class(progress_of_case_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      call archive%item('method', self%method)
      call archive%list('finished rows', self%rows)
      call archive%list('events of finished methods', self%events)
      call archive%item('wall seconds', self%seconds)
   end subroutine serialize

   !> Writes a line of the table on the screen.
   subroutine list(self, case_name, line)
      !> How far a case is.
      class(progress_of_case_t), intent(inout) :: self
      !> Name of the case, for the head of the table.
      character(*), intent(in) :: case_name
      !> The line.
      character(*), intent(in) :: line

      if (.not. self%listed) &
         call say(case_name//repeat(' ', max(0, 27 - len(case_name)))// &
                  'status              steps  rejected   max phi   max phidot  energy drift [J]  seconds')
      self%listed = .true.
      call say('  '//trim(line))
   end subroutine list

   !> Runs all methods of a case: `<method>.csv`, `summary.csv`, `events.csv` if the system has events, and `model.csv` if it
   !! has quantities to tell, in the folder of the case.
   subroutine run_case(file, model, start, settings, options, checkpoint, all_ended, interrupted, error)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> The system.
      class(tabulated_system_t), intent(in) :: model
      !> Initial state.
      type(state_t), intent(in) :: start
      !> Tolerances and methods.
      type(settings_t), intent(in) :: settings
      !> Where and how to run.
      type(run_options_t), intent(in) :: options
      !> A checkpoint whose origin was read, to continue from; one that is not being read is only room for new ones.
      type(archive_t), intent(inout) :: checkpoint
      !> Whether every integration reached its end or a terminal event; left alone if so.
      logical, intent(inout) :: all_ended
      !> Whether a signal interrupted the case; its checkpoint is written.
      logical, intent(out) :: interrupted
      !> A file that cannot be written, or a checkpoint that does not fit.
      type(error_t), allocatable, intent(inout) :: error
      type(progress_of_case_t) :: progress
      character(:), allocatable :: row, events, message
      type(extremes_t) :: extremes
      integer :: i, first
      logical :: there

      interrupted = .false.
      inquire (file=options%folder//'/'//checkpoint_file, exist=there)
      if (.not. there) call remove_remainders(options%folder//'/', '.part')
      if (.not. checkpoint%reading) call write_quantities(options%folder//'/model.csv', model%quantities(), error)
      if (allocated(error)) return
      call extremes%init(model, settings%extremes, .true., error)
      if (allocated(error)) return
      call identity(file, progress%identity)
      progress%rows = ''
      progress%events = ''
      if (checkpoint%reading) then
         call progress%serialize(checkpoint)
         call check_progress(progress, size(settings%methods), options%folder//'/'//checkpoint_file, checkpoint, error)
         if (allocated(error)) return
         do i = 1, progress%method - 1
            inquire (file=options%folder//'/'//settings%methods(i)%label//'.csv', exist=there)
            if (.not. there) call raise(error, options%folder//'/'//settings%methods(i)%label//'.csv', &
                                        'the file of a finished method is missing', &
                                        'put it back beside the checkpoint, or run the case anew')
         end do
         if (allocated(error)) return
      end if
      row = ''
      events = ''
      first = progress%method
      do i = first, size(settings%methods)
         progress%method = i
         call run_method(file, model, start, settings, settings%methods(i), options, checkpoint, progress, all_ended, &
                         interrupted, row, events, message, error)
         if (allocated(error)) return
         if (len(message) > 0) write (error_unit, '(5a)') file%name, ' ', settings%methods(i)%label, ': ', message
         if (interrupted) exit
         progress%rows = progress%rows//row
         progress%events = progress%events//events
         progress%seconds = 0.0_wp
         row = ''
         events = ''
      end do
      if (model%n_events > 0) &
         call write_table(options%folder//'/events.csv', 'method,event,t', progress%events//events, error)
      call write_table(options%folder//'/summary.csv', summary_header//extremes%names(), progress%rows//row, error)
      if (allocated(error) .or. interrupted) return
      call remove_file(options%folder//'/'//checkpoint_file)
      call remove_remainders(options%folder//'/', '.part')
   end subroutine run_case

   !> Runs all methods of a case and writes no file. What a signal interrupts leaves nothing.
   subroutine run_rows(name, file, model, start, settings, rows, all_ended, error)
      !> What stands before each row.
      character(*), intent(in) :: name
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> The system.
      class(tabulated_system_t), intent(in) :: model
      !> Initial state.
      type(state_t), intent(in) :: start
      !> Tolerances and methods.
      type(settings_t), intent(in) :: settings
      !> The rows of its summary, without the extremes of the system's vectors and with why a method ended early behind each.
      character(:), allocatable, intent(out) :: rows
      !> Whether every integration reached its end or a terminal event; left alone if so.
      logical, intent(inout) :: all_ended
      !> A method that cannot begin.
      type(error_t), allocatable, intent(inout) :: error
      type(run_options_t) :: options
      type(archive_t) :: no_checkpoint
      type(progress_of_case_t) :: progress
      character(:), allocatable :: events, message, row
      logical :: interrupted
      integer :: i

      options%quiet = .true.
      rows = ''
      do i = 1, size(settings%methods)
         row = ''
         events = ''
         progress%seconds = 0.0_wp
         call run_method(file, model, start, settings, settings%methods(i), options, no_checkpoint, progress, all_ended, &
                         interrupted, row, events, message, error)
         if (allocated(error) .or. interrupted) return
         rows = rows//name//','//row(:len(row) - 1)//','//csv_field(message)//line_end
      end do
   end subroutine run_rows

   !> What the system knows about itself.
   subroutine write_quantities(path, list, error)
      character(*), intent(in) :: path
      type(quantity_t), intent(in) :: list(:)
      type(error_t), allocatable, intent(inout) :: error
      type(csv_t) :: table
      integer :: i

      if (allocated(error) .or. size(list) == 0) return
      call table%create(path, error)
      if (.not. allocated(error)) call table%put('name,value,unit', error)
      do i = 1, size(list)
         if (.not. allocated(error)) &
            call table%put(list(i)%name//','//trim(number_text(list(i)%value))//','//list(i)%unit, error)
      end do
      if (.not. allocated(error)) call table%finish(error)
      call table%discard()
   end subroutine write_quantities

   !> A small CSV file in one go.
   subroutine write_table(path, header, rows, error)
      character(*), intent(in) :: path, header, rows
      type(error_t), allocatable, intent(inout) :: error
      type(csv_t) :: table

      if (allocated(error)) return
      call table%create(path, error)
      if (allocated(error)) return
      if (len(rows) == 0) then
         call table%put(header, error)
      else
         call table%put(header//line_end//rows(:len(rows) - 1), error)
      end if
      if (.not. allocated(error)) call table%finish(error)
      call table%discard()
   end subroutine write_table

   !> One method, from its start or from where a checkpoint left it.
   subroutine run_method(file, model, start, settings, chosen, options, checkpoint, progress, all_ended, interrupted, row, &
                         event_rows, message, error)
      type(namelist_file_t), intent(in) :: file
      class(tabulated_system_t), intent(in) :: model
      type(state_t), intent(in) :: start
      type(settings_t), intent(in) :: settings
      type(method_entry_t), intent(in) :: chosen
      type(run_options_t), intent(in) :: options
      type(archive_t), intent(inout) :: checkpoint
      type(progress_of_case_t), intent(inout) :: progress
      logical, intent(inout) :: all_ended
      logical, intent(out) :: interrupted
      character(:), allocatable, intent(inout) :: row, event_rows
      character(:), allocatable, intent(out) :: message
      type(error_t), allocatable, intent(inout) :: error
      type(recorder_t) :: recorder
      type(model_events_t), allocatable :: watched
      type(simulation_t) :: simulation
      type(watch_t) :: watch
      type(state_t) :: at
      integer(int64) :: before, rate
      real(wp) :: seconds_before
      character(:), allocatable :: diagnosis, remark
      character(len=200) :: line
      integer :: i

      interrupted = .false.
      message = ''
      at = start
      at%t = settings%t_start
      ! An argument that is not allocated counts as not present.
      if (model%n_events > 0) then
         allocate (watched)
         call watched%init(model)
      end if
      call simulation%init(model, error, chosen%method, settings%options_of(chosen))
      if (allocated(error)) return
      seconds_before = progress%seconds
      call recorder%progress%start(file%name//' '//chosen%label, options%quiet)
      watch%interval = options%checkpoint
      call watch%start()
      call system_clock(before, rate)
      if (checkpoint%reading) then
         call restore(checkpoint, options%folder, recorder, model, settings, simulation, error)
         if (allocated(error)) return
         if (.not. options%quiet) &
            call progress%list(file%name, chosen%label//' continues at t = '//to_text(simulation%result%t)//' s')
         call simulation%resume(recorder, watched, watch)
      else
         if (allocated(options%folder)) then
            call recorder%create(options%folder//'/'//chosen%label//'.csv', model, settings, error)
         else
            recorder%of_vectors = .false.
            call recorder%prepare(model, settings, error)
         end if
         if (allocated(error)) return
         call simulation%run(at, settings%t_end, error, recorder, watched, pause=watch)
      end if
      do while (simulation%result%status == status_interrupted .and. .not. allocated(error))
         call set_seconds()
         if (allocated(options%folder)) call save(file, options, checkpoint, progress, recorder, simulation, error)
         interrupted = caught_signal() /= 0
         if (allocated(error) .or. interrupted) exit
         call watch%start()
         call simulation%resume(recorder, watched, watch)
      end do
      call set_seconds()
      call recorder%progress%finish()
      associate (result => simulation%result)
         ! What could not be written ends the run; what ended early is kept and told.
         if (result%status == status_output_failed .and. .not. allocated(error)) call move_alloc(result%error, error)
         if (allocated(error)) then
            call recorder%csv%discard()
            return
         end if
         if (interrupted) then
            if (.not. allocated(options%folder)) return
            call recorder%csv%keep()
            write (error_unit, '(a)') file%name//' '//chosen%label//': interrupted at t = '//to_text(result%t)// &
               ' s; continue with: '//options%app//' --restart '//options%folder//'/'//checkpoint_file
         else
            call recorder%csv%finish(error)
            if (allocated(error)) return
         end if
         if (result%status /= status_reached_end .and. result%status /= status_event) then
            all_ended = .false.
            if (allocated(result%error)) then
               call model%diagnose(simulation%at, diagnosis)
               ! What is wrong with the model comes before what may be done about the integration.
               if (allocated(diagnosis)) result%error%remedy = diagnosis
               message = result%error%line()
            end if
         end if
         if (allocated(result%events)) then
            do i = 1, size(result%events)
               event_rows = event_rows//chosen%label//','//trim(model%event_name(result%events(i)%index))//','// &
                            trim(number_text(result%events(i)%t))//line_end
            end do
         end if
         if (recorder%points == 0) recorder%min_rank = 0
         call summary_row(file%name, chosen, model, settings, simulation, recorder, progress%seconds, row)
         if (.not. options%quiet) then
            write (line, '(a, t26, a, t44, i7, i10, 2es12.2, es18.3, f9.3)') chosen%label, status_name(result%status), &
               result%steps, result%rejected, recorder%max_phi, recorder%max_phidot, recorder%balance%drift, progress%seconds
            call progress%list(file%name, line)
            call recorder%balance%remark(settings%options_of(chosen), result, settings%t_start, remark)
            if (len(remark) > 0) call progress%list(file%name, '  '//remark)
         end if
      end associate

   contains

      !> Wall time of the method, in this process and before.
      subroutine set_seconds()
         integer(int64) :: now

         call system_clock(now)
         progress%seconds = seconds_before + real(now - before, wp)/real(rate, wp)
      end subroutine set_seconds

   end subroutine run_method

   !> What is restored must be of this case: a file whose checksum fits may have been made by anyone.
   subroutine check_progress(progress, methods, path, checkpoint, error)
      type(progress_of_case_t), intent(in) :: progress
      integer, intent(in) :: methods
      character(*), intent(in) :: path
      type(archive_t), intent(inout) :: checkpoint
      type(error_t), allocatable, intent(inout) :: error

      if (allocated(checkpoint%error)) call move_alloc(checkpoint%error, error)
      if (allocated(error)) return
      if (progress%method < 1 .or. progress%method > methods .or. .not. allocated(progress%rows) .or. &
          .not. allocated(progress%events) .or. .not. abs(progress%seconds) <= huge(1.0_wp)) &
         call raise(error, path, 'the checkpoint tells of a case with other methods', 'run the case anew')
   end subroutine check_progress

   !> What a checkpoint says of the method at work.
   subroutine restore(checkpoint, folder, recorder, model, settings, simulation, error)
      type(archive_t), intent(inout) :: checkpoint
      character(*), intent(in) :: folder
      type(recorder_t), intent(inout) :: recorder
      class(tabulated_system_t), intent(in) :: model
      type(settings_t), intent(in) :: settings
      type(simulation_t), intent(inout) :: simulation
      type(error_t), allocatable, intent(inout) :: error

      call simulation%serialize(checkpoint)
      if (simulation%result%status /= status_interrupted .and. .not. allocated(checkpoint%error)) &
         call raise(checkpoint%error, folder//'/'//checkpoint_file, 'the checkpoint is not of a run under way', &
                    'run the case anew')
      call recorder%prepare(model, settings, error)
      if (allocated(error)) return
      call recorder%serialize(checkpoint, folder, error)
      if (allocated(checkpoint%error)) call move_alloc(checkpoint%error, error)
      if (.not. allocated(error) .and. .not. checkpoint%at_end()) &
         call raise(error, folder//'/'//checkpoint_file, 'the checkpoint says more than this program understands', &
                    'use the program that wrote it')
      checkpoint%reading = .false.
   end subroutine restore

   !> Writes a checkpoint.
   subroutine save(file, options, checkpoint, progress, recorder, simulation, error)
      type(namelist_file_t), intent(in) :: file
      type(run_options_t), intent(in) :: options
      type(archive_t), intent(inout) :: checkpoint
      type(progress_of_case_t), intent(inout) :: progress
      type(recorder_t), intent(inout) :: recorder
      type(simulation_t), intent(inout) :: simulation
      type(error_t), allocatable, intent(inout) :: error
      character(:), allocatable :: path, text

      call checkpoint%clear()
      path = file%path
      text = progress%identity
      call store_origin(checkpoint, options%folder//'/'//checkpoint_file, options%app, .true., path, text, error)
      call progress%serialize(checkpoint)
      call simulation%serialize(checkpoint)
      call recorder%serialize(checkpoint, options%folder, error)
      if (allocated(error)) return
      call write_checkpoint(options%folder//'/'//checkpoint_file, checkpoint, error)
      if (.not. allocated(error)) recorder%csv%in_checkpoint = .true.
   end subroutine save

end module taut_case_run
