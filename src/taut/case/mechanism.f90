!> Case files of mechanisms.
module taut_case_mechanism
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_case_group, only: check_groups, declare_group, declared_t, first_group
   use taut_case_mechanism_analysis, only: analysis_t, flags_t, read_analysis, read_flags
   use taut_case_mechanism_output, only: mechanism_output_t
   use taut_case_mechanism_parts, only: declare_parts, locate_named, origins_t, read_parts
   use taut_case_namelist_file, only: namelist_file_t
   use taut_case_settings, only: declare_shared, read_settings, settings_t
   use taut_constrained_method_options, only: method_t
   use taut_constrained_start, only: start_report_t
   use taut_constrained_system, only: state_t
   use taut_model_mechanism, only: mechanism_t
   use taut_model_mechanism_assembly, only: assemble, contradicting_velocities, hold_coordinate, worst_joint
   use taut_model_mechanism_builder, only: mechanism_builder_t
   use taut_model_mechanism_report, only: mechanism_report_t, report_start
   use taut_ode_options, only: integration_options_t
   implicit none (type, external)
   private
   public :: read_mechanism, declare_mechanism

   !> Makes a mechanism of a case file: of one that was loaded for the apps, of a path for any program.
   interface read_mechanism
      module procedure read_loaded, read_path
   end interface read_mechanism

contains

   !> The groups of a mechanism's case file.
   subroutine declare_mechanism(groups)
      !> The groups.
      type(declared_t), allocatable, intent(out) :: groups(:)
      type(mechanism_output_t) :: output

      call declare_group(groups, flags_t())
      call declare_group(groups, analysis_t())
      call declare_parts(groups)
      call declare_shared(groups, weight='mass', output=output)
   end subroutine declare_mechanism

   !> Reads a case file, assembles the mechanism and describes it.
   subroutine read_loaded(file, model, start, settings, report, error)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> The mechanism.
      type(mechanism_t), intent(out) :: model
      !> Initial state, assembled.
      type(state_t), intent(out) :: start
      !> Tolerances and methods.
      type(settings_t), intent(out) :: settings
      !> What is told of it before it runs.
      type(mechanism_report_t), intent(out) :: report
      !> What is wrong with the file.
      type(error_t), allocatable, intent(inout) :: error
      type(declared_t), allocatable :: known(:)
      type(flags_t) :: flags
      type(mechanism_builder_t) :: builder
      type(mechanism_output_t) :: output
      type(origins_t) :: origins

      call declare_mechanism(known)
      call check_groups(file, known, error)
      if (.not. allocated(error)) call read_flags(file, flags, error)
      if (allocated(error)) return
      builder%planar = flags%planar
      call read_parts(file, builder, origins, error)
      if (.not. allocated(error)) call read_settings(file, settings, error, weight='mass', output=output)
      if (.not. allocated(error)) call choose_shown(file, output, builder, error)
      if (allocated(error)) return
      call builder%complete(model, start, error)
      if (allocated(error)) then
         error%where = file%path//': '//error%where
         return
      end if
      call check_tables(file, model, origins, settings, error)
      if (allocated(error)) return
      call assemble_start(file, flags, origins, model, start, settings, report, error)
      if (.not. allocated(error) .and. allocated(builder%notes)) call tell_notes(builder%notes, model, report)
   end subroutine read_loaded

   !> Says what was taken and may not be meant: in words to people, and in the summary that there is something to be read.
   subroutine tell_notes(notes, model, report)
      type(error_t), intent(in) :: notes(:)
      type(mechanism_t), intent(inout) :: model
      type(mechanism_report_t), intent(inout) :: report
      integer :: i

      do i = 1, size(notes)
         report%text = report%text//'note: '//notes(i)%line()//new_line('a')
      end do
      model%description = report%text
      if (len(model%remark) > 0) model%remark = model%remark//'; '
      model%remark = model%remark//'notes on the case file: '//to_text(size(notes))//' (run it without --quiet)'
   end subroutine tell_notes

   !> Reads a case file: the mechanism, where it starts, and how the file has it run.
   subroutine read_path(path, mechanism, start, error, method, options, t_end, report)
      !> Path of the case file; the tables that it names are looked for from its folder.
      character(*), intent(in) :: path
      !> The mechanism; of an extension of `mechanism_t` its part of that name.
      type(mechanism_t), intent(out) :: mechanism
      !> Where it starts, assembled, at the file's t_start.
      type(state_t), intent(out) :: start
      !> A file that cannot be read, or what is wrong with it.
      type(error_t), allocatable, intent(inout) :: error
      !> Its first method.
      type(method_t), intent(out), optional :: method
      !> Tolerances, steps and output spacing.
      type(integration_options_t), intent(out), optional :: options
      !> Its end [s].
      real(wp), intent(out), optional :: t_end
      !> How far bodies were moved to assemble it, its degrees of freedom, and what is redundant.
      type(mechanism_report_t), intent(out), optional :: report
      type(namelist_file_t) :: file
      type(settings_t) :: settings
      type(mechanism_report_t) :: found

      call file%load(path, error)
      if (.not. allocated(error)) call read_loaded(file, mechanism, start, settings, found, error)
      if (present(t_end)) t_end = settings%t_end
      if (allocated(error)) return
      if (present(options)) options = settings%options_of(settings%methods(1))
      if (present(method)) method = settings%methods(1)%method
      if (present(report)) report = found
   end subroutine read_path

   !> A table that drives a joint or scales a load must reach over the whole run.
   subroutine check_tables(file, model, origins, settings, error)
      type(namelist_file_t), intent(in) :: file
      type(mechanism_t), intent(in) :: model
      type(origins_t), intent(in) :: origins
      type(settings_t), intent(in) :: settings
      type(error_t), allocatable, intent(inout) :: error
      type(analysis_t) :: analysis
      integer :: i

      call read_analysis(file, analysis, error)
      if (allocated(error) .or. analysis%kind /= 'dynamics') return
      do i = 1, size(model%joints)
         call check_range(model%joints(i)%drive)
         call check_range(model%joints(i)%angle_drive)
      end do
      do i = 1, size(model%loads)
         call check_range(model%loads(i)%factor)
      end do

   contains

      !> One function; 0 is none.
      subroutine check_range(number)
         integer, intent(in) :: number

         if (number == 0 .or. allocated(error)) return
         associate (ends => model%functions(number)%reach())
            if (ends(1) <= settings%t_start .and. ends(2) >= settings%t_end) return
            call raise(error, '', 'its table goes from t = '//to_text(ends(1))//' s to '//to_text(ends(2))//' s, the run from '// &
                       to_text(settings%t_start)//' s to '//to_text(settings%t_end)//' s', &
                       'add rows to the table, or change t_start and t_end of &integration')
         end associate
         call locate_named(file, file%groups(origins%of_function(number)), model%functions(number)%name, error)
      end subroutine check_range

   end subroutine check_tables

   !> The joints and springs that &output names.
   subroutine choose_shown(file, output, builder, error)
      type(namelist_file_t), intent(in) :: file
      type(mechanism_output_t), intent(in) :: output
      type(mechanism_builder_t), intent(inout) :: builder
      type(error_t), allocatable, intent(inout) :: error

      if (allocated(output%joints)) then
         if (output%joints(1) == 'none') then
            call builder%show_joints(output%joints(:0))
         else if (output%joints(1) /= 'all') then
            call builder%show_joints(output%joints)
         end if
      end if
      if (allocated(output%springs)) then
         if (output%springs(1) == 'all') then
            call builder%show_springs()
         else
            call builder%show_springs(output%springs)
         end if
      end if
      if (.not. allocated(builder%error)) return
      call move_alloc(builder%error, error)
      if (len(error%where) > 0) error%what = error%where//': '//error%what
      call file%locate(file%groups(first_group(file, 'output')), error)
   end subroutine choose_shown

   !> Brings the start to the constraints, and says what was found.
   subroutine assemble_start(file, flags, origins, model, start, settings, report, error)
      type(namelist_file_t), intent(in) :: file
      type(flags_t), intent(in) :: flags
      type(origins_t), intent(in) :: origins
      type(mechanism_t), intent(inout) :: model
      type(state_t), intent(inout) :: start
      type(settings_t), intent(in) :: settings
      type(mechanism_report_t), intent(out) :: report
      type(error_t), allocatable, intent(inout) :: error
      type(start_report_t) :: consistent
      type(state_t) :: given_start
      logical :: held(model%n)
      integer :: i

      start%t = settings%t_start
      given_start = start
      held = .false.
      if (allocated(flags%hold)) then
         do i = 1, size(flags%hold)
            if (len_trim(flags%hold(i)) > 0) call hold_coordinate(model, trim(flags%hold(i)), held, error)
         end do
      end if
      if (.not. allocated(error)) call assemble(model, settings%methods(1)%method, start, consistent, error, held)
      if (allocated(error)) then
         call blame(file, origins, model, given_start, start, error)
      else
         call report_start(model, given_start, start, consistent, report)
      end if
   end subroutine assemble_start

   !> Names the joint that was open at the start and stays so, or those whose velocities contradict each other.
   subroutine blame(file, origins, model, given_start, reached, error)
      type(namelist_file_t), intent(in) :: file
      type(origins_t), intent(in) :: origins
      type(mechanism_t), intent(in) :: model
      type(state_t), intent(in) :: given_start, reached
      type(error_t), allocatable, intent(inout) :: error
      character(:), allocatable :: names
      real(wp) :: left, open_by
      integer :: i

      error%where = file%path//': mechanism'
      if (index(error%what, 'coordinate "') > 0) return
      ! What names a row by its number is said better here.
      i = index(error%what, ' (the constraints are inconsistent') + index(error%what, ' (the velocity constraints are inconsistent')
      if (i > 0) error%what = error%what(:i - 1)
      call worst_joint(model, reached, i, left)
      if (left <= 1.0e-9_wp .and. model%strayed_joint(reached) > 0) then
         i = model%strayed_joint(reached)
      else if (left > 1.0e-9_wp) then
         call worst_joint(model, given_start, i, open_by)
         error%what = 'it is open by '//to_text(open_by)//' at the start, and the worst joint stays open by '//to_text(left)// &
                      ': '//error%what
      else
         call contradicting_velocities(model, reached, names, i, left)
         if (i == 0) return
         error%what = 'the velocities of '//names//' contradict each other or what is held, '//to_text(left)// &
                      ' is left: '//error%what
         call model%diagnose(reached, names)
         if (allocated(names)) error%remedy = names
      end if
      call locate_named(file, file%groups(origins%of_joint(i)), model%joints(i)%name, error)
   end subroutine blame

end module taut_case_mechanism
