!> A chain of rods and point masses: reads case files, runs their methods, writes CSV files.
program chain
   use taut_case_application, only: run_application
   use taut_case_chain, only: chain_group_t
   use taut_case_model_group, only: model_case_t
   implicit none (type, external)
   type(model_case_t) :: kind
   integer :: code

   allocate (chain_group_t :: kind%group)
   call run_application('chain', 'cases/chain/ten.nml', &
                        'A hanging chain of any number of rods and point masses.', kind, code)
   if (code /= 0) stop code, quiet=.true.
end program chain
