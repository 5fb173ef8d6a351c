!> The simple pendulum of Sect. 4.1: reads case files, runs their methods, writes CSV files.
program pendulum
   use taut_error, only: error_t
   use taut_case_application, only: run_application
   use taut_case_namelist_file, only: namelist_file_t
   use taut_case_pendulum, only: read_pendulum
   use taut_case_settings, only: settings_t
   use taut_constrained_system, only: state_t
   use taut_constrained_system_tables, only: tabulated_system_t
   use taut_model_pendulum, only: pendulum_t
   implicit none (type, external)
   integer :: code

   call run_application('pendulum', 'cases/pendulum/figure1.nml', &
                        'A point mass on a rigid rod, by several methods.', read_case, code)
   if (code /= 0) stop code, quiet=.true.

contains

   !> A case file's pendulum, as a system.
   subroutine read_case(file, model, start, settings, error)
      type(namelist_file_t), intent(in) :: file
      class(tabulated_system_t), allocatable, intent(out) :: model
      type(state_t), intent(out) :: start
      type(settings_t), intent(out) :: settings
      type(error_t), allocatable, intent(inout) :: error
      type(pendulum_t), allocatable :: own

      allocate (own)
      call read_pendulum(file, own, start, settings, error)
      call move_alloc(own, model)
   end subroutine read_case

end program pendulum
