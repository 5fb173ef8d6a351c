!> What the apps have in common: case files in, CSV files out.
module taut_case_application
   use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
   use taut_error, only: error_t
   use taut_version, only: version
   use taut_case_command_line, only: command_line_t, read_command_line, usage
   use taut_case_namelist_file, only: check_names, namelist_file_t
   use taut_case_run, only: check_start, run_case
   use taut_case_settings, only: settings_t
   use taut_constrained_system, only: mechanical_system_t, state_t
   implicit none (type, external)
   private
   public :: run_application

   !> A case, read and checked.
   type :: job_t
      class(mechanical_system_t), allocatable :: model
      type(state_t) :: start
      type(settings_t) :: settings
   end type job_t

   abstract interface
      !> Makes a system of a case file.
      subroutine case_reader(file, model, start, settings, error)
         import :: namelist_file_t, mechanical_system_t, state_t, settings_t, error_t
         implicit none (type, external)
         !> The case file.
         type(namelist_file_t), intent(in) :: file
         !> The system.
         class(mechanical_system_t), allocatable, intent(out) :: model
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
      !> Exit code: 0 if all went well, 2 for a wrong command line, 1 for everything else.
      integer, intent(out) :: code
      type(command_line_t) :: line
      type(namelist_file_t), allocatable :: files(:)
      type(job_t), allocatable :: jobs(:)
      type(error_t), allocatable :: error
      logical :: all_ended
      integer :: i

      code = 2
      call read_command_line(app, default_case, line, error)
      if (failed()) return
      code = 0
      if (line%help) write (output_unit, '(a)') usage(app, default_case, purpose)
      if (line%version) write (output_unit, '(2a)') 'taut ', version
      if (line%help .or. line%version) return

      ! Everything is read and checked before anything is written.
      code = 1
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
      all_ended = .true.
      do i = 1, size(jobs)
         associate (job => jobs(i))
            call run_case(files(i), job%model, job%start, job%settings, line%out, line%quiet, all_ended, error)
         end associate
         if (failed()) return
      end do
      if (all_ended) code = 0

   contains

      !> Whether there is an error, which is printed.
      logical function failed()
         failed = allocated(error)
         if (failed) write (error_unit, '(3a)') app, ': ', error%line()
      end function failed

   end subroutine run_application

end module taut_case_application
