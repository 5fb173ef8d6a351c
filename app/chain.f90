!> A chain of rods and point masses: reads case files, runs their methods, writes CSV files.
program chain
   use taut_error, only: error_t
   use taut_case_application, only: run_application
   use taut_case_namelist_file, only: namelist_file_t
   use taut_case_chain, only: read_chain
   use taut_case_settings, only: settings_t
   use taut_constrained_system, only: state_t
   use taut_constrained_system_tables, only: tabulated_system_t
   use taut_model_chain, only: chain_t
   implicit none (type, external)
   integer :: code

   call run_application('chain', 'cases/chain/ten.nml', &
                        'A hanging chain of any number of rods and point masses.', read_case, code)
   if (code /= 0) stop code, quiet=.true.

contains

   !> A case file's chain, as a system.
   subroutine read_case(file, model, start, settings, error)
      type(namelist_file_t), intent(in) :: file
      class(tabulated_system_t), allocatable, intent(out) :: model
      type(state_t), intent(out) :: start
      type(settings_t), intent(out) :: settings
      type(error_t), allocatable, intent(inout) :: error
      type(chain_t), allocatable :: own

      allocate (own)
      call read_chain(file, own, start, settings, error)
      call move_alloc(own, model)
   end subroutine read_case

end program chain
