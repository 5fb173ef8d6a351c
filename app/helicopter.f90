!> The helicopter blade of Sect. 4.3: reads case files, runs their methods, writes CSV files.
program helicopter
   use taut_case_application, only: run_application
   use taut_case_helicopter, only: helicopter_group_t
   use taut_case_model_group, only: model_case_t
   implicit none (type, external)
   type(model_case_t) :: kind
   integer :: code

   allocate (helicopter_group_t :: kind%group)
   call run_application('helicopter', 'cases/helicopter/figure10.nml', &
                        'A helicopter blade and its pitch link, by several methods.', kind, code)
   if (code /= 0) stop code, quiet=.true.
end program helicopter
