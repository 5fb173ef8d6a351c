!> Mechanisms that are read from case files and run: what their tests share.
module mechanism_runs
   use taut, only: constrained_ode_t, error_t, integration_result_t, sample_t, simulate, state_t, wp
   use taut_constrained_method_choose, only: new_constrained_ode
   use taut_case_mechanism, only: read_mechanism
   use taut_case_namelist_file, only: namelist_file_t
   use taut_case_settings, only: settings_t
   use taut_model_mechanism, only: mechanism_t
   use taut_model_mechanism_report, only: mechanism_report_t
   use test_case, only: load
   use testing, only: check, no_error
   implicit none (type, external)
   private
   public :: entry_of, output, run_file, run_t, run_text, violation

   !> A case, read, and what became of it.
   type :: run_t
      type(mechanism_t) :: model
      type(settings_t) :: settings
      type(mechanism_report_t) :: report
      !> Start, and state at the end.
      type(state_t) :: start, at
      type(integration_result_t) :: result
   end type run_t

   character(*), parameter :: folder = 'cases/mechanism/'

contains

   !> Reads a case file of the project and runs it to a time.
   subroutine run_file(name, t_end, tolerance, run, failure, integrator)
      character(*), intent(in) :: name
      real(wp), intent(in) :: t_end, tolerance
      type(run_t), intent(out) :: run
      character(:), allocatable, intent(inout) :: failure
      character(*), intent(in), optional :: integrator
      type(namelist_file_t) :: file
      type(error_t), allocatable :: error

      call file%load(folder//name//'.nml', error)
      call no_error(failure, error)
      if (.not. allocated(failure)) call run_loaded(file, t_end, tolerance, run, failure, integrator)
   end subroutine run_file

   !> The same for a text.
   subroutine run_text(text, t_end, tolerance, run, failure)
      character(*), intent(in) :: text
      real(wp), intent(in) :: t_end, tolerance
      type(run_t), intent(out) :: run
      character(:), allocatable, intent(inout) :: failure
      type(namelist_file_t) :: file
      type(error_t), allocatable :: error

      call load(text, file, error)
      call no_error(failure, error)
      if (.not. allocated(failure)) call run_loaded(file, t_end, tolerance, run, failure)
   end subroutine run_text

   subroutine run_loaded(file, t_end, tolerance, run, failure, integrator)
      type(namelist_file_t), intent(in) :: file
      real(wp), intent(in) :: t_end, tolerance
      type(run_t), intent(inout) :: run
      character(:), allocatable, intent(inout) :: failure
      character(*), intent(in), optional :: integrator
      type(error_t), allocatable :: error

      call read_mechanism(file, run%model, run%start, run%settings, run%report, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      run%settings%options%rtol = tolerance
      run%settings%options%atol = tolerance
      if (present(integrator)) run%settings%options%integrator = integrator
      run%at = run%start
      call simulate(run%model, run%at, t_end, run%result, error, run%settings%methods(1)%method, run%settings%options)
      call no_error(failure, error)
      if (allocated(run%result%error)) call check(failure, .false., run%result%error%line())
      call check(failure, all(abs(run%at%x) < huge(1.0_wp)), 'a coordinate is not a number')
   end subroutine run_loaded

   !> An output at a state.
   function output(run, at, name) result(value)
      type(run_t), intent(in) :: run
      type(state_t), intent(in) :: at
      character(*), intent(in) :: name
      real(wp) :: value
      class(constrained_ode_t), allocatable :: ode
      type(error_t), allocatable :: error
      type(sample_t) :: sample
      real(wp), allocatable :: y(:)
      integer :: i, info

      value = huge(value)
      call new_constrained_ode(ode, run%model, run%settings%methods(1)%method, error)
      allocate (y(ode%size()))
      call ode%pack(at, y)
      call ode%sample(at%t, y, sample, info)
      do i = 1, run%model%n_outputs
         if (run%model%output_name(i) == name) value = sample%outputs(i)
      end do
   end function output

   !> A coordinate or a velocity at a state.
   function entry_of(run, at, name) result(value)
      type(run_t), intent(in) :: run
      type(state_t), intent(in) :: at
      character(*), intent(in) :: name
      real(wp) :: value
      integer :: i

      value = huge(value)
      do i = 1, run%model%n_x
         if (run%model%x_name(i) == name) value = at%x(i)
      end do
      do i = 1, run%model%n
         if (run%model%v_name(i) == name) value = at%v(i)
      end do
   end function entry_of

   !> Largest entry of phi at the end.
   function violation(run) result(value)
      type(run_t), intent(in) :: run
      real(wp) :: value
      real(wp), allocatable :: phi(:)

      allocate (phi(run%model%n_phi))
      call run%model%constraint(run%at, phi)
      value = maxval(abs(phi))
   end function violation

end module mechanism_runs
