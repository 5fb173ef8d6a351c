!> Mechanisms of bodies, joints and loads from case files: runs their methods, writes CSV files.
program mechanism
   use, intrinsic :: iso_fortran_env, only: output_unit
   use taut_error, only: error_t
   use taut_case_application, only: run_application
   use taut_case_mechanism, only: read_mechanism
   use taut_case_mechanism_help, only: case_help
   use taut_case_mechanism_static, only: run_static_cases
   use taut_case_namelist_file, only: namelist_file_t
   use taut_case_settings, only: settings_t
   use taut_constrained_system, only: state_t
   use taut_constrained_system_tables, only: tabulated_system_t
   use taut_model_mechanism, only: mechanism_t
   use taut_model_mechanism_report, only: mechanism_report_t
   implicit none (type, external)
   character(*), parameter :: app = 'mechanism', default_case = 'cases/mechanism/four_bar.nml'
   character(len=20) :: argument
   integer :: code
   logical :: done

   call get_command_argument(1, argument)
   if (argument == '--help-case') then
      write (output_unit, '(a)') case_help()
      stop
   end if
   call run_static_cases(app, default_case, done, code)
   if (.not. done) call run_application(app, default_case, 'A mechanism of bodies, joints and loads; --help-case prints the '// &
                                        'groups of a case file.', read_case, code)
   if (code /= 0) stop code, quiet=.true.

contains

   !> A case file's mechanism, as a system.
   subroutine read_case(file, model, start, settings, error)
      type(namelist_file_t), intent(in) :: file
      class(tabulated_system_t), allocatable, intent(out) :: model
      type(state_t), intent(out) :: start
      type(settings_t), intent(out) :: settings
      type(error_t), allocatable, intent(inout) :: error
      type(mechanism_report_t) :: report
      type(mechanism_t), allocatable :: own

      allocate (own)
      call read_mechanism(file, own, start, settings, report, error)
      if (.not. allocated(error)) call move_alloc(own, model)
   end subroutine read_case

end program mechanism
