!> The swing of Sect. 4.2: reads case files, runs their methods, writes CSV files.
program swing
   use taut_case_application, only: run_application
   use taut_case_swing, only: read_swing
   implicit none (type, external)
   integer :: code

   call run_application('swing', 'cases/swing/1b.nml', 'A beam with a mass on two links, of elements or of modes.', &
                        read_swing, code)
   if (code /= 0) stop code, quiet=.true.
end program swing
