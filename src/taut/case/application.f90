!> What the apps have in common: case files in, CSV files out.
module taut_case_application
   use, intrinsic :: iso_fortran_env, only: error_unit
   use taut_archive, only: archive_t
   use taut_error, only: error_t, raise
   use taut_case_blas, only: use_one_thread
   use taut_case_checkpoint, only: program_text, read_checkpoint, store_origin
   use taut_case_command_line, only: command_line_t, path_t, read_command_line, usage
   use taut_case_group, only: declared_t
   use taut_case_help, only: case_help, case_reference
   use taut_case_identity, only: identity
   use taut_case_kind, only: case_kind_t
   use taut_case_namelist_file, only: check_names, namelist_file_t
   use taut_case_posix, only: make_folder
   use taut_case_process, only: catch_signals, output_is_lost, say, start_process
   use taut_case_run, only: check_start, run_case, run_options_t
   use taut_case_settings, only: settings_t
   use taut_case_variants, only: run_variants
   use taut_constrained_system, only: state_t
   use taut_constrained_system_tables, only: tabulated_system_t
   implicit none (type, external)
   private
   public :: run_application, begin_app, end_app, told

   !> Exit code of a run that a signal interrupted: 'try again later', as in BSD's sysexits.h.
   integer, parameter :: code_interrupted = 75

   !> A case, read and checked.
   type :: job_t
      class(tabulated_system_t), allocatable :: model
      type(state_t) :: start
      type(settings_t) :: settings
   end type job_t

contains

   !> Reads the command line and the case files, runs their methods and writes their results.
   subroutine run_application(app, default_case, purpose, kind, code)
      !> Name of the app.
      character(*), intent(in) :: app
      !> Case file to run if none is given.
      character(*), intent(in) :: default_case
      !> One line for the help.
      character(*), intent(in) :: purpose
      !> Its case files.
      class(case_kind_t), intent(in) :: kind
      !> Exit code: 0 if all went well, 2 for a wrong command line, 75 after a signal, 1 for everything else.
      integer, intent(out) :: code

      call begin_app()
      call run_all(app, default_case, purpose, kind, code)
      call end_app(app, code)
   end subroutine run_application

   !> What every app does first: one thread for BLAS, and safe outputs.
   subroutine begin_app()
      call start_process()
      call use_one_thread()
   end subroutine begin_app

   !> What every app does last: a success of which nobody can read is none.
   subroutine end_app(app, code)
      !> Name of the app.
      character(*), intent(in) :: app
      !> Exit code.
      integer, intent(inout) :: code
      type(error_t), allocatable :: error

      if (.not. output_is_lost()) return
      call raise(error, 'standard output', 'what was printed did not arrive', &
                 'see whether it is closed or the disk is full, or give --quiet')
      write (error_unit, '(3a)') app, ': ', error%line()
      if (code == 0) code = 1
   end subroutine end_app

   !> All between.
   subroutine run_all(app, default_case, purpose, kind, code)
      character(*), intent(in) :: app, default_case, purpose
      class(case_kind_t), intent(in) :: kind
      integer, intent(out) :: code
      type(command_line_t) :: line
      type(namelist_file_t), allocatable :: files(:)
      type(job_t), allocatable :: jobs(:)
      type(error_t), allocatable :: error
      type(declared_t), allocatable :: groups(:)
      type(archive_t) :: checkpoint
      type(run_options_t) :: options
      character(:), allocatable :: case_text, text
      logical :: all_ended, interrupted
      integer :: i

      code = 2
      call read_command_line(app, default_case, line, error)
      if (failed()) return
      code = 0
      allocate (groups(0))
      if (line%help_case .or. line%reference) call kind%declare(groups)
      if (told(line, app, default_case, purpose, groups)) return

      code = 1
      if (allocated(line%runs)) then
         call catch_signals()
         call run_variants(kind, line%cases(1)%text, line%runs, all_ended, interrupted, error)
         if (failed()) return
         if (interrupted) then
            code = code_interrupted
         else if (all_ended) then
            code = 0
         else
            write (error_unit, '(2a)') app, ': there are runs that did not reach their end; the last column says why'
         end if
         return
      end if

      ! Everything is read and checked before anything is written.
      if (allocated(line%restart)) then
         call read_origin(app, line, checkpoint, case_text, error)
         if (failed()) return
      end if
      allocate (files(size(line%cases)), jobs(size(line%cases)))
      do i = 1, size(jobs)
         associate (job => jobs(i))
            call files(i)%load(line%cases(i)%text, error)
            if (.not. allocated(error)) call kind%read(files(i), job%model, job%start, job%settings, error)
            if (.not. allocated(error)) call check_start(files(i), job%model, job%start, job%settings, error)
         end associate
         if (failed()) return
      end do
      call check_names(files, error)
      if (failed()) return
      if (allocated(line%restart)) then
         call check_restart(line, files(1), case_text, error)
         if (failed()) return
      end if
      call catch_signals()
      all_ended = .true.
      do i = 1, size(jobs)
         options = run_options_t(app, line%out//'/'//files(i)%name, line%quiet, line%checkpoint)
         if (allocated(line%restart)) options%folder = folder_of(line%restart)
         associate (job => jobs(i))
            if (.not. line%quiet) then
               call job%model%describe(text)
               call tell(files(i)%name, text)
            end if
            call make_folder(options%folder)
            call kind%write_beside(files(i), job%model, options%folder, error)
            if (failed()) return
            call run_case(files(i), job%model, job%start, job%settings, options, checkpoint, all_ended, interrupted, error)
         end associate
         if (failed()) return
         if (.not. line%quiet) call say('results in '//options%folder)
         if (interrupted) then
            code = code_interrupted
            return
         end if
      end do
      if (all_ended) code = 0

   contains

      !> Whether there is an error, which is printed.
      logical function failed()
         failed = allocated(error)
         if (failed) write (error_unit, '(3a)') app, ': ', error%line()
      end function failed

   end subroutine run_all

   !> Prints what the command line asks for in place of a run, if it does.
   logical function told(line, app, default_case, purpose, groups, ending)
      !> The command line.
      type(command_line_t), intent(in) :: line
      !> Name of the app.
      character(*), intent(in) :: app
      !> Its default case.
      character(*), intent(in) :: default_case
      !> One line for the help.
      character(*), intent(in) :: purpose
      !> The groups of a case file.
      type(declared_t), intent(in) :: groups(:)
      !> Its files and exit codes. Default: those of an app that integrates.
      character(*), intent(in), optional :: ending

      told = line%help .or. line%version .or. line%help_case .or. line%reference
      if (line%help) call say(usage(app, default_case, purpose, ending))
      if (line%help_case) call say(case_help(app, groups))
      if (line%reference) call say(case_reference(groups))
      if (line%version) call say(program_text())
   end function told

   !> Prints what a system has to say.
   subroutine tell(name, text)
      character(*), intent(in) :: name, text

      if (len(text) > 0) call say(name//': '//text)
   end subroutine tell

   !> Reads a checkpoint as far as the case it belongs to.
   subroutine read_origin(app, line, checkpoint, case_text, error)
      character(*), intent(in) :: app
      type(command_line_t), intent(inout) :: line
      type(archive_t), intent(inout) :: checkpoint
      character(:), allocatable, intent(out) :: case_text
      type(error_t), allocatable, intent(inout) :: error
      character(:), allocatable :: case_path

      call read_checkpoint(line%restart, checkpoint, error)
      if (allocated(error)) return
      call store_origin(checkpoint, line%restart, app, line%any_blas, case_path, case_text, error)
      if (allocated(error)) return
      if (allocated(checkpoint%error)) then
         call move_alloc(checkpoint%error, error)
         return
      end if
      if (.not. (allocated(case_path) .and. allocated(case_text))) then
         call raise(error, line%restart, 'the checkpoint names no case', 'run the case anew')
         return
      end if
      if (size(line%cases) == 0) line%cases = [path_t(case_path)]
   end subroutine read_origin

   !> Whether a checkpoint belongs to a case, and its folder is the one asked for.
   subroutine check_restart(line, file, case_text, error)
      type(command_line_t), intent(in) :: line
      type(namelist_file_t), intent(in) :: file
      character(*), intent(in) :: case_text
      type(error_t), allocatable, intent(inout) :: error
      character(:), allocatable :: text

      call identity(file, text)
      if (text /= case_text .or. len(text) /= len(case_text)) then
         call raise(error, line%restart, 'the checkpoint belongs to another case, or '//file%path// &
                    ' or a table of it was changed since', 'restart with the case as it was, or run it anew')
      else if (line%out_given .and. plain(line%out//'/'//file%name) /= plain(folder_of(line%restart))) then
         call raise(error, line%restart, 'the checkpoint is not in the folder '//line%out//'/'//file%name, &
                    'leave --out out: the results go where the checkpoint is, beside their unfinished files')
      end if
   end subroutine check_restart

   !> A path without the points and slashes that name nothing.
   pure function plain(path) result(short)
      character(*), intent(in) :: path
      character(:), allocatable :: short
      integer :: first, last

      short = ''
      if (index(path, '/') == 1) short = '/'
      first = 1
      do while (first <= len(path))
         last = first + index(path(first:)//'/', '/') - 2
         if (path(first:last) /= '' .and. path(first:last) /= '.') short = short//path(first:last)//'/'
         first = last + 2
      end do
   end function plain

   !> The folder of a file.
   function folder_of(path) result(folder)
      character(*), intent(in) :: path
      character(:), allocatable :: folder
      integer :: last

      last = index(path, '/', back=.true.)
      folder = '.'
      if (last == 1) folder = '/'
      if (last > 1) folder = path(:last - 1)
   end function folder_of

end module taut_case_application
