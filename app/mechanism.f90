!> Mechanisms of bodies, joints and loads from case files: runs their methods, writes CSV files.
program mechanism
   use, intrinsic :: iso_fortran_env, only: output_unit
   use taut_case_application, only: run_application
   use taut_case_mechanism_case, only: mechanism_case_t
   use taut_case_mechanism_help, only: case_help
   use taut_case_mechanism_static, only: run_static_cases
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
                                        'groups of a case file.', mechanism_case_t(), code)
   if (code /= 0) stop code, quiet=.true.
end program mechanism
