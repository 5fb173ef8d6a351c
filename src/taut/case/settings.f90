!> The groups that every case file may have: &integration, &output and one &method for each method that is run.
module taut_case_settings
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_case_entries, only: entries_t
   use taut_case_entry, only: choice_list
   use taut_case_group, only: declare_group, declared_t, first_group, group_data_t, read_group
   use taut_case_namelist_file, only: namelist_file_t
   use taut_case_value, only: lower_case
   use taut_constrained_method_choose, only: check_method
   use taut_constrained_method_options, only: method_names, method_t
   use taut_constrained_stepper_choose, only: choose_constrained_stepper, integrator_names
   use taut_linalg_normal_solver_choose, only: solver_names
   use taut_ode_integrate, only: integrator_t
   use taut_ode_options, only: integration_options_t
   use taut_ode_stepper, only: stepper_t
   implicit none (type, external)
   private
   public :: extreme_t, settings_t, method_entry_t, output_group_t, read_extremes, read_settings, declare_shared, longest_name

   !> Characters that the name of a column may have.
   integer, parameter :: longest_name = 128

   !> A method with the name of its result file.
   type, extends(group_data_t) :: method_entry_t
      !> Name of the file and of the row in the summary.
      character(:), allocatable :: label
      !> The method.
      type(method_t) :: method
      !> Its integrator; not allocated, or blank, for that of &integration.
      character(:), allocatable :: integrator
   contains
      procedure :: declare => declare_method
   end type method_entry_t

   !> &integration.
   type, extends(group_data_t) :: integration_group_t
      !> Start and end [s].
      real(wp) :: t_start = 0.0_wp, t_end = 10.0_wp
      !> Tolerances and steps.
      type(integration_options_t) :: options
   contains
      procedure :: declare => declare_integration
   end type integration_group_t

   !> &output; a model that has more to say there extends it.
   type, extends(group_data_t) :: output_group_t
      !> Output spacing [s].
      real(wp) :: dt = 0.0_wp
      !> Columns of the CSV files, with * for any characters; not allocated for all.
      character(len=longest_name), allocatable :: columns(:)
   contains
      procedure :: declare => declare_output
   end type output_group_t

   !> &extreme: a column whose largest and smallest value the summary tells.
   type, extends(group_data_t) :: extreme_t
      !> What it is called there; without: as the column.
      character(:), allocatable :: name
      !> The column, by its name.
      character(:), allocatable :: column
      !> Where it is asked for, as a message begins.
      character(:), allocatable :: place
      !> Times between which it is looked for [s].
      real(wp) :: from = -huge(1.0_wp), to = huge(1.0_wp)
   contains
      procedure :: declare => declare_extreme
   end type extreme_t

   !> What a case file says apart from the model.
   type :: settings_t
      !> Start and end [s].
      real(wp) :: t_start = 0.0_wp, t_end = 10.0_wp
      !> Tolerances, steps, output spacing.
      type(integration_options_t) :: options
      !> Columns of the CSV files, with * for any characters; blank ones do not count, and none means all.
      character(len=longest_name), allocatable :: columns(:)
      !> Where they are asked for, as a message begins.
      character(:), allocatable :: place_of_columns
      !> Extremes for the summary.
      type(extreme_t), allocatable :: extremes(:)
      !> Methods to be run side by side.
      type(method_entry_t), allocatable :: methods(:)
   contains
      procedure :: options_of
   end type settings_t

   !> Files of results that are not a method's.
   character(len=8), parameter :: reserved_labels(4) = [character(len=8) :: 'summary', 'model', 'events', 'geometry']

   !> Characters of a label: file names have 255 at most, and a file that is being written has more than the label.
   integer, parameter :: longest_label = 200

   !> Columns, iterations and tolerances beyond these are mistakes.
   integer, parameter :: most_columns = 10000
   real(wp), parameter :: largest_tolerance = 1.0e3_wp

contains

   !> Adds these groups to those that a case file may have.
   subroutine declare_shared(groups, weight, output)
      !> The groups so far.
      type(declared_t), allocatable, intent(inout) :: groups(:)
      !> The weight of methods that name none. Default: that of `method_t`.
      character(*), intent(in), optional :: weight
      !> &output of a model that has more to say there.
      class(output_group_t), intent(in), optional :: output
      type(integration_group_t) :: integration
      type(method_entry_t) :: method
      type(output_group_t) :: plain_output

      if (present(weight)) method%method%weight = weight
      call declare_group(groups, integration)
      if (present(output)) then
         call declare_group(groups, output)
      else
         call declare_group(groups, plain_output)
      end if
      call declare_group(groups, extreme_t(), many=.true.)
      call declare_group(groups, method, many=.true.)
   end subroutine declare_shared

   !> Entries of &integration.
   subroutine declare_integration(self, entries)
      !> What it says.
      class(integration_group_t), intent(inout) :: self
      !> What passes over them.
      type(entries_t), intent(inout) :: entries

      call entries%group('integration', 'times, tolerances and steps')
      associate (o => self%options)
         call entries%item('t_start', self%t_start, 's', 'where the integration begins')
         call entries%item('t_end', self%t_end, 's', 'where it ends')
         call entries%item('rtol', o%rtol, '', 'relative tolerance of a step', above=0.0_wp, most=largest_tolerance)
         call entries%item('atol', o%atol, '', 'absolute tolerance of a step, in the unit of each component', least=0.0_wp, &
                           most=largest_tolerance)
         call entries%item('first_step', o%first_step, 's', 'first step; 0: chosen', least=0.0_wp)
         call entries%item('min_step', o%min_step, 's', 'a run that needs shorter steps ends', least=0.0_wp)
         call entries%item('max_step', o%max_step, 's', 'longest step', above=0.0_wp)
         call entries%item('max_steps', o%max_steps, 'a run that needs more steps, rejected ones included, ends', least=1)
         call entries%item('integrator', o%integrator, 'formulas of a step: "dopri5", the paper''s, of order 5; '// &
                           '"dop853", of order 8, for errors of 1e-7 and below; "radau", implicit, for stiff systems; '// &
                           '"generalized-alpha", implicit, and "energy-preserving", of order 2, with method "present"', &
                           integrator_names)
         call entries%item('spectral_radius', o%spectral_radius, '', 'generalized-alpha: what a step leaves of oscillations '// &
                           'that are short against it', least=0.0_wp, most=1.0_wp)
         call entries%item('step_control', o%step_control, 'how steps are chosen; "fixed": all of first_step; '// &
                           '"odepkg-2009": the test behind the paper''s numbers, not for use', &
                           [character(len=16) :: 'standard', 'fixed', 'odepkg-2009'])
         call entries%item('norm', o%norm, 'norm of the error of a step', [character(len=3) :: 'rms', 'max'])
         call entries%item('projection_limit', o%projection_limit, '', &
                           'a step is rejected whose projection, after its first correction, moves by more, in tolerances', &
                           above=0.0_wp)
      end associate
   end subroutine declare_integration

   !> Entries of &output.
   subroutine declare_output(self, entries)
      !> What it says.
      class(output_group_t), intent(inout) :: self
      !> What passes over them.
      type(entries_t), intent(inout) :: entries

      call entries%group('output', 'what is written of a run')
      call entries%item('dt', self%dt, 's', 'time between two rows; 0: every step', least=0.0_wp)
      call entries%option('columns', self%columns, 'columns besides t, such as "x", "phi*"; * stands for any characters; '// &
                          'without: all', most_columns)
   end subroutine declare_output

   !> Entries of &extreme.
   subroutine declare_extreme(self, entries)
      !> What it says.
      class(extreme_t), intent(inout) :: self
      !> What passes over them.
      type(entries_t), intent(inout) :: entries
      real(wp), allocatable :: from, to

      call entries%group('extreme', 'a column whose smallest and largest value, by the step and not by the row, the summary tells')
      call entries%option('column', self%column, 'such as "hinge.fx"; of a joint also the size of its reaction, "hinge.force" '// &
                          'or "hinge.moment"')
      call entries%option('name', self%name, 'by which the summary tells it; without: that of the column')
      call entries%option('from', from, 's', 'not before; without: from the start')
      call entries%option('to', to, 's', 'not after; without: to the end')
      if (allocated(from)) self%from = from
      if (allocated(to)) self%to = to
   end subroutine declare_extreme

   !> Reads all &extreme.
   subroutine read_extremes(file, extremes, error)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> What it asks for.
      type(extreme_t), allocatable, intent(out) :: extremes(:)
      !> An entry that is not known, not readable or not valid.
      type(error_t), allocatable, intent(inout) :: error
      type(extreme_t) :: one
      integer :: i

      allocate (extremes(0))
      do i = 1, size(file%groups)
         if (file%groups(i)%name /= 'extreme') cycle
         one = extreme_t()
         one%place = file%groups(i)%place(file%path, file%groups(i)%line)
         call read_group(file, file%groups(i), one, error)
         if (allocated(error)) return
         call check_extreme(one, extremes, error)
         call file%locate(file%groups(i), error)
         extremes = [extremes, one]
      end do
   end subroutine read_extremes

   !> Checks an extreme against those before it.
   subroutine check_extreme(one, others, error)
      type(extreme_t), intent(inout) :: one
      type(extreme_t), intent(in) :: others(:)
      type(error_t), allocatable, intent(inout) :: error
      integer :: i

      if (.not. allocated(one%column)) one%column = ''
      one%column = trim(one%column)
      if (len(one%column) == 0) call raise(error, 'extreme', 'column is not given', 'name a column of the results')
      if (.not. allocated(one%name)) one%name = ''
      one%name = trim(one%name)
      if (len(one%name) == 0) one%name = one%column
      if (.not. one%from <= one%to) &
         call raise(error, 'extreme', 'from = '//to_text(one%from)//' s is after to = '//to_text(one%to)//' s', &
                    'give a later end')
      do i = 1, size(others)
         if (others(i)%name == one%name) &
            call raise(error, 'extreme', 'two extremes are called "'//one%name//'"', 'give one of them another name')
      end do
   end subroutine check_extreme

   !> Entries of &method.
   subroutine declare_method(self, entries)
      !> What it says.
      class(method_entry_t), intent(inout) :: self
      !> What passes over them.
      type(entries_t), intent(inout) :: entries

      call entries%group('method', 'a method that enforces the constraints; each is run')
      associate (m => self%method)
         call entries%item('name', m%name, '"baseline": Eq. (8); "present": Sect. 3.5; "coordinate-projection": Eich''s; '// &
                           '"unconstrained": evaluated, not enforced', method_names)
         call entries%option('label', self%label, 'name of its file of results; without: that of the method')
         call entries%option('integrator', self%integrator, 'formulas of its steps; without: those of &integration', &
                             integrator_names)
         call entries%item('weight', m%weight, 'W of Eqs (11a), (17); "given": the system''s own', &
                           [character(len=8) :: 'identity', 'mass', 'given'])
         call entries%item('stage_projection', m%stage_projection, &
                           'present, minimal-coordinates: whether x is projected before every right-hand side', &
                           [character(len=6) :: 'newton', 'none'])
         call entries%item('state_projection', m%state_projection, 'present: what is projected after each step; '// &
                           'minimal-coordinates: whether x is; generalized-alpha: "position" is index 3', &
                           [character(len=17) :: 'none', 'position', 'position-velocity'])
         call entries%item('form', m%form, 'present: what is corrected, Sect. 3.5 (h) or (g)', &
                           [character(len=12) :: 'acceleration', 'force'])
         call entries%item('reduce', m%reduce, 'present with an explicit integrator: compute bodies that are welded together '// &
                           'as one, and what turns about a fixed point by its angle alone; motion, columns and reactions are '// &
                           'the same; mu of the rows that fall away is 0')
         call entries%item('independent', m%independent, 'minimal-coordinates: independent velocities along a basis of the '// &
                           'null space of A or single ones, chosen anew where they no longer fit; "constant": never', &
                           [character(len=12) :: 'null-space', 'partitioning', 'constant'])
         call entries%item('solver', m%solver, 'how the system of the multipliers is solved', solver_names)
         call entries%item('rcond', m%rcond, '', 'relative size of a singular value that counts as zero; 0: the solver''s own', &
                           least=0.0_wp, most=1.0_wp)
         call entries%item('alpha', m%alpha, '1/s', 'baumgarte: gain of phidot')
         call entries%item('beta', m%beta, '1/s', 'baumgarte: gain of phi')
         call entries%item('dt', m%dt, 's', 'braun-goldfarb: time in which a violation decays')
         call entries%item('correction_tolerance', m%correction_tolerance, '', 'yu-chen: a violation beyond it is corrected')
         call entries%item('stiffness', m%stiffness, '', 'penalty: force for each unit of phi')
         call entries%item('damping', m%damping, '', 'penalty: force for each unit of phidot')
         call entries%item('penalty_factor', m%penalty_factor, '', 'bayo-penalty, augmented-lagrangian: alpha, a mass for each phi')
         call entries%item('omega', m%omega, '1/s', 'bayo-penalty, augmented-lagrangian: frequency of a violation')
         call entries%item('mu', m%mu, '', 'bayo-penalty, augmented-lagrangian: its damping ratio')
         call entries%item('projection_tolerance', m%projection_tolerance, '', &
                           'largest entry of phi that counts as none where lengths are about 1 or more; smaller ones are met '// &
                           'to the same part of them, or to round-off', &
                           above=0.0_wp, most=largest_tolerance)
         call entries%item('max_iterations', m%max_iterations, 'of Eq. (17), or of augmented-lagrangian', least=1)
         call entries%item('accept_inconsistent', m%accept_inconsistent, &
                           'go on where the constraints cannot all be met, with the least violation')
      end associate
   end subroutine declare_method

   !> Tolerances, steps and output spacing of a method.
   function options_of(self, method) result(options)
      !> What a case file says.
      class(settings_t), intent(in) :: self
      !> One of its methods.
      type(method_entry_t), intent(in) :: method
      !> Those of all, with its integrator.
      type(integration_options_t) :: options

      options = self%options
      if (.not. allocated(method%integrator)) return
      if (len_trim(method%integrator) > 0) options%integrator = method%integrator
   end function options_of

   !> Reads and checks these groups.
   subroutine read_settings(file, settings, error, weight, output)
      !> The case file, whose groups were checked.
      type(namelist_file_t), intent(in) :: file
      !> What it says.
      type(settings_t), intent(inout) :: settings
      !> An entry that is not known, not readable or not valid.
      type(error_t), allocatable, intent(inout) :: error
      !> The weight of methods that name none. Default: that of `method_t`.
      character(*), intent(in), optional :: weight
      !> &output of a model that has more to say there. Default: nothing more.
      class(output_group_t), intent(inout), optional :: output
      type(integration_group_t) :: integration
      type(output_group_t) :: plain_output
      type(integrator_t) :: checked
      type(method_entry_t) :: one, unread
      class(stepper_t), allocatable :: stepper
      integer :: i, methods

      if (present(weight)) unread%method%weight = weight
      allocate (settings%methods(max(1, count([(file%groups(i)%name == 'method', i=1, size(file%groups))]))))
      methods = 0
      do i = 1, size(file%groups)
         if (allocated(error)) return
         select case (file%groups(i)%name)
         case ('integration')
            call read_group(file, file%groups(i), integration, error)
            if (.not. allocated(error)) then
               ! Positions alone are what every integrator can do; whether it takes a method is asked of each one.
               call choose_constrained_stepper(integration%options, method_t(state_projection='position'), stepper, error)
               if (.not. allocated(error)) call checked%init(1, integration%options, error, stepper)
               if (integration%t_end < integration%t_start) &
                  call raise(error, 'integration', 't_end = '//to_text(integration%t_end)//' is before t_start = '// &
                             to_text(integration%t_start), 'give a later end')
               call file%locate(file%groups(i), error)
            end if
         case ('output')
            if (present(output)) then
               call read_group(file, file%groups(i), output, error)
            else
               call read_group(file, file%groups(i), plain_output, error)
            end if
         case ('method')
            one = unread
            call read_group(file, file%groups(i), one, error)
            if (allocated(error)) return
            if (.not. allocated(one%label)) one%label = ''
            if (len_trim(one%label) == 0) one%label = trim(one%method%name)
            call check_method(one%method, error)
            call check_label(one%label, settings%methods(:methods), error)
            call file%locate(file%groups(i), error)
            methods = methods + 1
            settings%methods(methods) = one
         end select
      end do
      if (.not. allocated(error)) call read_extremes(file, settings%extremes, error)
      if (allocated(error)) return
      settings%options = integration%options
      methods = 0
      do i = 1, size(file%groups)
         if (file%groups(i)%name /= 'method') cycle
         methods = methods + 1
         associate (chosen => settings%methods(methods))
            call choose_constrained_stepper(settings%options_of(chosen), chosen%method, stepper, error)
         end associate
         call file%locate(file%groups(i), error)
      end do
      if (methods == 0) then
         settings%methods(1) = unread
         settings%methods(1)%label = trim(unread%method%name)
      end if
      settings%t_start = integration%t_start
      settings%t_end = integration%t_end
      settings%options%output_dt = plain_output%dt
      if (present(output)) then
         settings%options%output_dt = output%dt
         if (allocated(output%columns)) call move_alloc(output%columns, plain_output%columns)
      end if
      settings%place_of_columns = '&output'
      i = first_group(file, 'output')
      if (i > 0) settings%place_of_columns = file%groups(i)%place(file%path, file%groups(i)%line)
      if (allocated(plain_output%columns)) then
         call move_alloc(plain_output%columns, settings%columns)
      else
         allocate (settings%columns(0))
      end if
      if ((settings%t_end - settings%t_start) < settings%options%output_dt*real(huge(1), wp) .or. &
          .not. settings%options%output_dt > 0.0_wp) return
      call raise(error, '', 'dt = '//to_text(settings%options%output_dt)//' s asks for too many rows', &
                 'give a longer time, or 0 for every step')
      error%where = settings%place_of_columns
   end subroutine read_settings

   !> A label must be a file name, and no other method's; some file systems do not tell small letters from large ones.
   subroutine check_label(label, methods, error)
      character(*), intent(in) :: label
      type(method_entry_t), intent(in) :: methods(:)
      type(error_t), allocatable, intent(inout) :: error
      integer :: i

      if (verify(label, 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-') > 0 .or. len(label) == 0 &
          .or. index(label, '.') == 1 .or. any(reserved_labels == lower_case(label))) &
         call raise(error, 'method', 'label = "'//label//'" cannot name a file of results', &
                    'use letters, digits, - and _, and none of '//choice_list(reserved_labels))
      if (len(label) > longest_label) &
         call raise(error, 'method', 'label = "'//label(:40)//'..." is longer than '//to_text(longest_label)//' characters', &
                    'shorten it')
      do i = 1, size(methods)
         if (lower_case(methods(i)%label) == lower_case(label)) &
            call raise(error, 'method', 'two methods have the label "'//label//'"', 'give one of them another label')
      end do
   end subroutine check_label

end module taut_case_settings
