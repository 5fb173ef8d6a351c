!> The helicopter blade of Sect. 4.3: reads case files, runs their methods, writes CSV files.
program helicopter
   use taut_error, only: error_t
   use taut_case_application, only: run_application
   use taut_case_namelist_file, only: namelist_file_t
   use taut_case_helicopter, only: read_helicopter
   use taut_case_settings, only: settings_t
   use taut_constrained_system, only: state_t
   use taut_constrained_system_tables, only: tabulated_system_t
   use taut_model_helicopter, only: helicopter_t
   implicit none (type, external)
   integer :: code

   call run_application('helicopter', 'cases/helicopter/figure10.nml', &
                        'A helicopter blade and its pitch link, by several methods.', read_case, code)
   if (code /= 0) stop code, quiet=.true.

contains

   !> A case file's blade, as a system.
   subroutine read_case(file, model, start, settings, error)
      type(namelist_file_t), intent(in) :: file
      class(tabulated_system_t), allocatable, intent(out) :: model
      type(state_t), intent(out) :: start
      type(settings_t), intent(out) :: settings
      type(error_t), allocatable, intent(inout) :: error
      type(helicopter_t), allocatable :: blade

      allocate (blade)
      call read_helicopter(file, blade, start, settings, error)
      call move_alloc(blade, model)
   end subroutine read_case

end program helicopter
