!> The simple pendulum of Sect. 4.1: reads case files, runs their methods, writes CSV files.
program pendulum
   use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
   use taut_error, only: error_t
   use taut_version, only: version
   use taut_case_command_line, only: command_line_t, read_command_line, usage
   use taut_case_namelist_file, only: check_names, namelist_file_t
   use taut_case_pendulum, only: read_pendulum
   use taut_case_run, only: check_start, run_case
   use taut_case_settings, only: settings_t
   use taut_constrained_system, only: state_t
   use taut_model_pendulum, only: pendulum_t
   implicit none (type, external)
   character(*), parameter :: app = 'pendulum', default_case = 'cases/pendulum/figure1.nml'
   type(command_line_t) :: line
   type(namelist_file_t), allocatable :: files(:)
   type(pendulum_t), allocatable :: models(:)
   type(state_t), allocatable :: starts(:)
   type(settings_t), allocatable :: settings(:)
   type(error_t), allocatable :: error
   logical :: all_ended
   integer :: i

   call read_command_line(app, default_case, line, error)
   if (allocated(error)) call give_up(2)
   if (line%help) write (output_unit, '(a)') usage(app, default_case, 'A point mass on a rigid rod, by several methods.')
   if (line%version) write (output_unit, '(2a)') 'taut ', version
   if (line%help .or. line%version) stop

   ! Everything is read and checked before anything is written.
   allocate (files(size(line%cases)), models(size(line%cases)), starts(size(line%cases)), settings(size(line%cases)))
   do i = 1, size(files)
      call files(i)%load(line%cases(i)%text, error)
      if (.not. allocated(error)) call read_pendulum(files(i), models(i), starts(i), settings(i), error)
      if (.not. allocated(error)) call check_start(files(i), models(i), starts(i), settings(i), error)
      if (allocated(error)) call give_up(1)
   end do
   call check_names(files, error)
   if (allocated(error)) call give_up(1)
   all_ended = .true.
   do i = 1, size(files)
      call run_case(files(i), models(i), starts(i), settings(i), line%out, line%quiet, all_ended, error)
      if (allocated(error)) call give_up(1)
   end do
   if (.not. all_ended) stop 1, quiet=.true.

contains

   !> Prints the error and stops.
   subroutine give_up(code)
      integer, intent(in) :: code

      write (error_unit, '(3a)') app, ': ', error%line()
      stop code, quiet=.true.
   end subroutine give_up

end program pendulum
