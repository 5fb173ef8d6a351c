!> The simple pendulum of Sect. 4.1: reads case files, runs their methods, writes CSV files.
program pendulum
   use taut_case_application, only: run_application
   use taut_case_pendulum, only: pendulum_group_t
   use taut_case_model_group, only: model_case_t
   implicit none (type, external)
   type(model_case_t) :: kind
   integer :: code

   allocate (pendulum_group_t :: kind%group)
   call run_application('pendulum', 'cases/pendulum/figure1.nml', &
                        'A point mass on a rigid rod, by several methods.', kind, code)
   if (code /= 0) stop code, quiet=.true.
end program pendulum
