!> The groups that every case file has: &integration, &output and one &method for each method that is run.
module taut_case_settings
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise
   use taut_case_namelist_file, only: namelist_file_t, group_t
   use taut_constrained_method_choose, only: check_method
   use taut_constrained_method_options, only: method_t
   use taut_ode_integrate, only: integrator_t
   use taut_ode_options, only: integration_options_t
   implicit none (type, external)
   private
   public :: settings_t, method_entry_t, read_settings, shared_groups

   !> Groups that every case file may have.
   character(len=11), parameter :: shared_groups(3) = [character(len=11) :: 'integration', 'output', 'method']

   !> A method with the name of its result file.
   type :: method_entry_t
      !> Name of the file and of the row in the summary.
      character(:), allocatable :: label
      !> The method.
      type(method_t) :: method
   end type method_entry_t

   !> What a case file says apart from the model.
   type :: settings_t
      !> Start and end [s].
      real(wp) :: t_start = 0.0_wp, t_end = 10.0_wp
      !> Tolerances, steps, output spacing.
      type(integration_options_t) :: options
      !> Columns of the CSV files, with * for any characters; blank ones do not count, and none means all.
      character(len=40) :: columns(100) = ''
      !> Methods to be run side by side.
      type(method_entry_t), allocatable :: methods(:)
   end type settings_t

contains

   !> Reads and checks these groups.
   subroutine read_settings(file, settings, error, weight, more_output)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> What it says.
      type(settings_t), intent(inout) :: settings
      !> An entry that is not known, not readable or not valid.
      type(error_t), allocatable, intent(inout) :: error
      !> The weight of methods that name none. Default: that of `method_t`.
      character(*), intent(in), optional :: weight
      !> Entries of &output that the model's reader takes, separated by commas and blanks. Default: none.
      character(*), intent(in), optional :: more_output
      type(integrator_t) :: checked
      type(method_entry_t) :: one
      integer :: i

      allocate (settings%methods(0))
      do i = 1, size(file%groups)
         if (allocated(error)) return
         select case (file%groups(i)%name)
         case ('integration')
            call read_integration(file, file%groups(i), settings, error)
            if (allocated(error)) return
            call checked%init(1, settings%options, error)
            call file%locate(file%groups(i), error)
         case ('output')
            call read_output(file, file%groups(i), settings, more_output, error)
            if (allocated(error)) return
            call checked%init(1, settings%options, error)
            call file%locate(file%groups(i), error)
         case ('method')
            call read_method(file, file%groups(i), weight, one, error)
            if (allocated(error)) return
            call check_method(one%method, error)
            call check_label(one%label, settings%methods, error)
            call file%locate(file%groups(i), error)
            settings%methods = [settings%methods, one]
         end select
      end do
      if (size(settings%methods) == 0 .and. .not. allocated(error)) then
         one = method_entry_t()
         one%label = 'present'
         if (present(weight)) one%method%weight = weight
         settings%methods = [one]
      end if
   end subroutine read_settings

   !> A label must be a file name, and no other method's.
   subroutine check_label(label, methods, error)
      character(*), intent(in) :: label
      type(method_entry_t), intent(in) :: methods(:)
      type(error_t), allocatable, intent(inout) :: error
      integer :: i

      if (verify(label, 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-') > 0 .or. len(label) == 0 &
          .or. index(label, '.') == 1 .or. label == 'summary' .or. label == 'model') &
         call raise(error, 'method', 'label = "'//label//'" cannot name a file of results', &
                    'use letters, digits, - and _ (and neither "summary" nor "model")')
      do i = 1, size(methods)
         if (methods(i)%label == label) &
            call raise(error, 'method', 'two methods have the label "'//label//'"', 'give one of them another label')
      end do
   end subroutine check_label

   !> &integration.
   subroutine read_integration(file, group, settings, error)
      type(namelist_file_t), intent(in) :: file
      type(group_t), intent(in) :: group
      type(settings_t), intent(inout) :: settings
      type(error_t), allocatable, intent(inout) :: error
      character(*), parameter :: names = 't_start, t_end, rtol, atol, first_step, min_step, max_step, max_steps, '// &
                                 'integrator, step_control, norm, projection_limit'
      real(wp) :: t_start, t_end, rtol, atol, first_step, min_step, max_step, projection_limit
      integer :: i, max_steps, status
      character(len=len(settings%options%step_control)) :: step_control
      character(len=len(settings%options%integrator)) :: integrator
      character(len=len(settings%options%norm)) :: norm
      character(len=200) :: message
      namelist /integration/ t_start, t_end, rtol, atol, first_step, min_step, max_step, max_steps, integrator, step_control, &
         norm, projection_limit

      t_start = settings%t_start
      t_end = settings%t_end
      rtol = settings%options%rtol
      atol = settings%options%atol
      first_step = settings%options%first_step
      min_step = settings%options%min_step
      max_step = settings%options%max_step
      max_steps = settings%options%max_steps
      integrator = settings%options%integrator
      step_control = settings%options%step_control
      norm = settings%options%norm
      projection_limit = settings%options%projection_limit
      do i = 1, size(group%entries)
         read (group%entries(i)%text, nml=integration, iostat=status, iomsg=message)
         if (status /= 0) call file%complain(group, i, message, names, error)
      end do
      if (.not. (abs(t_start) <= huge(t_start) .and. abs(t_end) <= huge(t_end))) then
         call raise(error, 'integration', 't_start or t_end is not a number', 'give times in seconds')
         call file%locate(group, error)
      end if
      settings%t_start = t_start
      settings%t_end = t_end
      settings%options%rtol = rtol
      settings%options%atol = atol
      settings%options%first_step = first_step
      settings%options%min_step = min_step
      settings%options%max_step = max_step
      settings%options%max_steps = max_steps
      settings%options%integrator = integrator
      settings%options%step_control = step_control
      settings%options%norm = norm
      settings%options%projection_limit = projection_limit
   end subroutine read_integration

   !> &output.
   subroutine read_output(file, group, settings, more, error)
      type(namelist_file_t), intent(in) :: file
      type(group_t), intent(in) :: group
      type(settings_t), intent(inout) :: settings
      character(*), intent(in), optional :: more
      type(error_t), allocatable, intent(inout) :: error
      character(len=len(settings%columns)) :: columns(size(settings%columns))
      character(:), allocatable :: names
      real(wp) :: dt
      integer :: i, status
      character(len=200) :: message
      namelist /output/ dt, columns

      dt = settings%options%output_dt
      columns = settings%columns
      names = 'dt, columns'
      if (present(more)) names = names//', '//more
      do i = 1, size(group%entries)
         if (present(more)) then
            if (index(', '//more//',', ', '//group%entries(i)%name//',') > 0) cycle
         end if
         read (group%entries(i)%text, nml=output, iostat=status, iomsg=message)
         if (status /= 0) call file%complain(group, i, message, names, error)
      end do
      settings%options%output_dt = dt
      settings%columns = columns
   end subroutine read_output

   !> &method.
   subroutine read_method(file, group, default_weight, one, error)
      type(namelist_file_t), intent(in) :: file
      type(group_t), intent(in) :: group
      character(*), intent(in), optional :: default_weight
      type(method_entry_t), intent(out) :: one
      type(error_t), allocatable, intent(inout) :: error
      character(*), parameter :: names = 'name, label, weight, stage_projection, state_projection, form, solver, rcond, alpha, '// &
                                 'beta, dt, correction_tolerance, stiffness, damping, projection_tolerance, max_iterations, '// &
                                 'accept_inconsistent'
      character(len=len(one%method%name)) :: name
      character(len=64) :: label
      character(len=len(one%method%weight)) :: weight
      character(len=len(one%method%stage_projection)) :: stage_projection
      character(len=len(one%method%state_projection)) :: state_projection
      character(len=len(one%method%form)) :: form
      character(len=len(one%method%solver)) :: solver
      real(wp) :: rcond, alpha, beta, dt, correction_tolerance, stiffness, damping, projection_tolerance
      integer :: i, max_iterations, status
      logical :: accept_inconsistent
      character(len=200) :: message
      namelist /method/ name, label, weight, stage_projection, state_projection, form, solver, rcond, alpha, beta, dt, &
         correction_tolerance, stiffness, damping, projection_tolerance, max_iterations, accept_inconsistent

      name = one%method%name
      label = ''
      weight = one%method%weight
      if (present(default_weight)) weight = default_weight
      stage_projection = one%method%stage_projection
      state_projection = one%method%state_projection
      form = one%method%form
      solver = one%method%solver
      rcond = one%method%rcond
      alpha = one%method%alpha
      beta = one%method%beta
      dt = one%method%dt
      correction_tolerance = one%method%correction_tolerance
      stiffness = one%method%stiffness
      damping = one%method%damping
      projection_tolerance = one%method%projection_tolerance
      max_iterations = one%method%max_iterations
      accept_inconsistent = one%method%accept_inconsistent
      do i = 1, size(group%entries)
         read (group%entries(i)%text, nml=method, iostat=status, iomsg=message)
         if (status /= 0) call file%complain(group, i, message, names, error)
      end do
      if (len_trim(label) == 0) label = name
      one%label = trim(label)
      one%method = method_t(name, weight, stage_projection, state_projection, form, solver, rcond, alpha, beta, dt, &
                            correction_tolerance, stiffness, damping, projection_tolerance, max_iterations, &
                            accept_inconsistent)
   end subroutine read_method

end module taut_case_settings
