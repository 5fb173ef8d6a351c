!> What the apps have in common: case files in, CSV files out.
module taut_case_application
   use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
   use taut_archive, only: archive_t
   use taut_error, only: error_t, raise
   use taut_case_checkpoint, only: program_text, read_checkpoint, store_origin
   use taut_case_command_line, only: command_line_t, path_t, read_command_line, usage
   use taut_case_namelist_file, only: check_names, namelist_file_t
   use taut_case_posix, only: catch_signals
   use taut_case_run, only: check_start, run_case, run_options_t
   use taut_case_settings, only: settings_t
   use taut_constrained_system, only: state_t
   use taut_constrained_system_tables, only: tabulated_system_t
   implicit none (type, external)
   private
   public :: run_application

   !> Exit code of a run that a signal interrupted: 'try again later', as in BSD's sysexits.h.
   integer, parameter :: code_interrupted = 75

   !> A case, read and checked.
   type :: job_t
      class(tabulated_system_t), allocatable :: model
      type(state_t) :: start
      type(settings_t) :: settings
   end type job_t

   abstract interface
      !> Makes a system of a case file.
      subroutine case_reader(file, model, start, settings, error)
         import :: namelist_file_t, tabulated_system_t, state_t, settings_t, error_t
         implicit none (type, external)
         !> The case file.
         type(namelist_file_t), intent(in) :: file
         !> The system.
         class(tabulated_system_t), allocatable, intent(out) :: model
         !> Initial state as given.
         type(state_t), intent(out) :: start
         !> Tolerances and methods.
         type(settings_t), intent(out) :: settings
         !> What is wrong with the file.
         type(error_t), allocatable, intent(inout) :: error
      end subroutine case_reader
   end interface

contains

   !> Reads the command line and the case files, runs their methods and writes their results.
   subroutine run_application(app, default_case, purpose, read_case, code)
      !> Name of the app.
      character(*), intent(in) :: app
      !> Case file to run if none is given.
      character(*), intent(in) :: default_case
      !> One line for the help.
      character(*), intent(in) :: purpose
      !> Makes a system of a case file.
      procedure(case_reader) :: read_case
      !> Exit code: 0 if all went well, 2 for a wrong command line, 75 after a signal, 1 for everything else.
      integer, intent(out) :: code
      type(command_line_t) :: line
      type(namelist_file_t), allocatable :: files(:)
      type(job_t), allocatable :: jobs(:)
      type(error_t), allocatable :: error
      type(archive_t) :: checkpoint
      type(run_options_t) :: options
      character(:), allocatable :: case_text
      logical :: all_ended, interrupted
      integer :: i

      code = 2
      call read_command_line(app, default_case, line, error)
      if (failed()) return
      code = 0
      if (line%help) write (output_unit, '(a)') usage(app, default_case, purpose)
      if (line%version) write (output_unit, '(a)') program_text()
      if (line%help .or. line%version) return

      ! Everything is read and checked before anything is written.
      code = 1
      if (allocated(line%restart)) then
         call read_origin(app, line, checkpoint, case_text, error)
         if (failed()) return
      end if
      allocate (files(size(line%cases)), jobs(size(line%cases)))
      do i = 1, size(jobs)
         associate (job => jobs(i))
            call files(i)%load(line%cases(i)%text, error)
            if (.not. allocated(error)) call read_case(files(i), job%model, job%start, job%settings, error)
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
            if (.not. line%quiet) call tell(files(i)%name, job%model%describe())
            call run_case(files(i), job%model, job%start, job%settings, options, checkpoint, all_ended, interrupted, error)
         end associate
         if (failed()) return
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

   end subroutine run_application

   !> Prints what a system has to say.
   subroutine tell(name, text)
      character(*), intent(in) :: name, text

      if (len(text) > 0) write (output_unit, '(3a)', advance='no') name, ': ', text
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
      call store_origin(checkpoint, line%restart, app, case_path, case_text, error)
      if (allocated(error)) return
      if (allocated(checkpoint%error)) then
         call move_alloc(checkpoint%error, error)
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

      if (file%content /= case_text .or. len(file%content) /= len(case_text)) then
         call raise(error, line%restart, 'the checkpoint belongs to another case, or '//file%path//' was changed since', &
                    'restart with the case as it was, or run it anew')
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
