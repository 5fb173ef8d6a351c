!> Modes of a straight beam, Table 1 and Fig. 5: reads case files, writes CSV files of frequencies and shapes.
program beam_modes
   use, intrinsic :: iso_fortran_env, only: error_unit
   use taut_error, only: error_t, raise
   use taut_case_application, only: begin_app, end_app, told
   use taut_case_beam_modes, only: beam_modes_t, declare_beam_modes, read_beam_modes, write_beam_modes
   use taut_case_command_line, only: command_line_t, read_command_line
   use taut_case_group, only: declared_t
   use taut_case_namelist_file, only: check_names, namelist_file_t
   implicit none (type, external)
   character(*), parameter :: app = 'beam_modes', default_case = 'cases/beam_modes/table1.nml'
   type(command_line_t) :: line
   type(namelist_file_t), allocatable :: files(:)
   type(beam_modes_t), allocatable :: problems(:)
   type(declared_t), allocatable :: groups(:)
   type(error_t), allocatable :: error
   integer :: i

   call begin_app()
   call read_command_line(app, default_case, line, error)
   if (allocated(error)) call give_up(2)
   call declare_beam_modes(groups)
   if (told(line, app, default_case, 'Frequencies and shapes of a straight beam.', groups, &
            'For each case: DIR/<case>/frequencies.csv and DIR/<case>/shapes.csv.'//new_line('a')// &
            'Exit code: 0, 1 for a bad case, 2 for a bad command line.')) call finish()

   ! There is no time to integrate over, so that there are no checkpoints.
   if (allocated(line%restart)) call raise(error, line%restart, 'modes have no checkpoints', 'run the case anew')
   if (allocated(error)) call give_up(1)

   ! Everything is read and solved before anything is written.
   allocate (files(size(line%cases)), problems(size(line%cases)))
   do i = 1, size(files)
      call files(i)%load(line%cases(i)%text, error)
      if (.not. allocated(error)) call read_beam_modes(files(i), problems(i), error)
      if (allocated(error)) call give_up(1)
   end do
   call check_names(files, error)
   if (allocated(error)) call give_up(1)
   do i = 1, size(files)
      call write_beam_modes(files(i), problems(i), line%out, line%quiet, error)
      if (allocated(error)) call give_up(1)
   end do
   call finish()

contains

   !> Stops where all went well.
   subroutine finish()
      integer :: code

      code = 0
      call end_app(app, code)
      stop code, quiet=.true.
   end subroutine finish

   !> Prints the error and stops.
   subroutine give_up(code)
      integer, intent(in) :: code

      write (error_unit, '(3a)') app, ': ', error%line()
      stop code, quiet=.true.
   end subroutine give_up

end program beam_modes
