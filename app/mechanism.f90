!> Mechanisms of bodies, joints and loads from case files: runs their methods, writes CSV files.
program mechanism
   use taut_case_application, only: begin_app, end_app, run_application
   use taut_case_mechanism_case, only: mechanism_case_t
   use taut_case_mechanism_static, only: run_static_cases
   implicit none (type, external)
   character(*), parameter :: app = 'mechanism', default_case = 'cases/mechanism/four_bar.nml'
   integer :: code
   logical :: done

   call begin_app()
   call run_static_cases(app, default_case, done, code)
   if (done) call end_app(app, code)
   if (.not. done) call run_application(app, default_case, 'A mechanism of bodies, joints and loads; --help-case prints the '// &
                                        'groups of a case file.', mechanism_case_t(), code)
   if (code /= 0) stop code, quiet=.true.
end program mechanism
