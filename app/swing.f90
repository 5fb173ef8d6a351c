!> The swing of Sect. 4.2: reads case files, runs their methods, writes CSV files.
program swing
   use taut_case_application, only: run_application
   use taut_case_swing, only: swing_group_t
   use taut_case_model_group, only: model_case_t
   implicit none (type, external)
   type(model_case_t) :: kind
   integer :: code

   allocate (swing_group_t :: kind%group)
   call run_application('swing', 'cases/swing/1b.nml', &
                        'A beam with a mass on two links, of elements or of modes.', kind, code)
   if (code /= 0) stop code, quiet=.true.
end program swing
