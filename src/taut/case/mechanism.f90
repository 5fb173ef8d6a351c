!> Case files of mechanisms.
module taut_case_mechanism
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_case_mechanism_beam, only: read_beam
   use taut_case_mechanism_bodies, only: read_body, read_ground_point, read_point, read_point_mass
   use taut_case_mechanism_joints, only: read_joint, read_knife_edge, read_rolling
   use taut_case_group, only: first_group
   use taut_case_mechanism_loads, only: read_function, read_gravity, read_load, read_spring
   use taut_case_mechanism_names, only: anchor_t, find_anchor, find_joint, locate_named, name_length, parts_t
   use taut_case_namelist_file, only: given, group_t, namelist_file_t
   use taut_case_mechanism_output, only: mechanism_output_t
   use taut_case_settings, only: read_settings, settings_t
   use taut_constrained_start, only: consistent_start, start_report_t
   use taut_constrained_system, only: state_t
   use taut_model_mechanism, only: event_t, mechanism_t
   use taut_model_mechanism_assembly, only: assemble_holding, contradicting_velocities, hold_coordinate, worst_joint
   use taut_model_mechanism_function, only: function_table
   use taut_model_mechanism_joint, only: has_angle, has_displacement
   use taut_model_mechanism_report, only: mechanism_report_t, report_start
   implicit none (type, external)
   private
   public :: read_mechanism, read_analysis, analysis_t

   !> What is asked for.
   type :: analysis_t
      !> `dynamics`, `equilibrium`, or `modes` about the equilibrium.
      character(len=16) :: kind = 'dynamics'
      !> Load steps of the equilibrium; modes that are written.
      integer :: steps = 1, number = 10
   end type analysis_t

   !> Groups of a mechanism.
   character(len=12), parameter :: mechanism_groups(20) = [character(len=12) :: 'mechanism', 'analysis', 'gravity', 'body', &
            'point_mass', &
                                                           'ground_point', 'point', 'function', 'joint', 'rolling', 'knife_edge', &
                                                           'force', 'moment', 'spring', 'damper', 'event', 'beam', &
                                                           'method', 'integration', 'output']
   integer, parameter :: most_held = 100

contains

   !> Reads a case file, assembles the mechanism and describes it.
   subroutine read_mechanism(file, model, start, settings, report, error)
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
      type(mechanism_output_t) :: output
      type(parts_t) :: parts
      character(len=2*name_length) :: hold(most_held)

      call file%only_groups(mechanism_groups, error, many=mechanism_groups(4:18))
      if (allocated(error)) return
      call start_parts(parts)
      call read_all(file, parts, hold, error)
      if (.not. allocated(error)) call read_settings(file, settings, error, weight='mass', output=output)
      if (.not. allocated(error)) call choose_shown(file, output, parts, error)
      if (.not. allocated(error)) call check_tables(file, parts%model, settings, error)
      if (allocated(error)) return
      call parts%model%complete(error)
      if (allocated(error)) then
         error%where = file%path//': '//error%where
         return
      end if
      model = parts%model
      call assemble(file, hold, model, start, settings, report, error)
   end subroutine read_mechanism

   !> A table that drives a joint or scales a load must reach over the whole run.
   subroutine check_tables(file, model, settings, error)
      type(namelist_file_t), intent(in) :: file
      type(mechanism_t), intent(in) :: model
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
         integer :: k, met

         if (number == 0 .or. allocated(error)) return
         associate (it => model%functions(number))
            if (it%kind /= function_table) return
            associate (first => it%times(1), last => it%times(size(it%times)))
               if (first > settings%t_start .or. last < settings%t_end) &
                  call raise(error, '', 'its table goes from t = '//to_text(first)// &
                             ' s to '//to_text(last)//' s, the run from '//to_text(settings%t_start)//' s to '// &
                             to_text(settings%t_end)//' s', 'add rows to the table, or change t_start and t_end of &integration')
            end associate
            ! Every &function group made one function.
            met = 0
            do k = 1, size(file%groups)
               if (file%groups(k)%name == 'function') met = met + 1
               if (met < number) cycle
               call locate_named(file, file%groups(k), it%name, error)
               return
            end do
         end associate
      end subroutine check_range

   end subroutine check_tables

   !> &analysis.
   subroutine read_analysis(file, chosen, error)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> What is asked for.
      type(analysis_t), intent(out) :: chosen
      !> What is wrong with it.
      type(error_t), allocatable, intent(inout) :: error
      character(len=16) :: kind
      character(len=200) :: message
      integer :: i, j, number, status, steps
      namelist /analysis/ kind, steps, number

      do j = 1, size(file%groups)
         associate (group => file%groups(j))
            if (group%name /= 'analysis') cycle
            kind = chosen%kind
            steps = chosen%steps
            number = chosen%number
            do i = 1, size(group%entries)
               read (group%entries(i)%text, nml=analysis, iostat=status, iomsg=message)
               if (status /= 0) call file%complain(group, i, message, 'kind, steps, number', error)
            end do
            chosen = analysis_t(kind, steps, number)
            if (.not. any(chosen%kind == [character(len=11) :: 'dynamics', 'equilibrium', 'modes'])) &
               call raise(error, '', 'there is no analysis "'//trim(chosen%kind)//'"', 'use "dynamics", "equilibrium" or "modes"')
            if (steps < 1 .or. number < 1) call raise(error, '', 'steps or number is not positive', 'give 1 or more')
            call locate_named(file, group, '', error)
            if (allocated(error)) return
         end associate
      end do
   end subroutine read_analysis

   !> Nothing but the ground.
   subroutine start_parts(parts)
      type(parts_t), intent(out) :: parts
      type(anchor_t) :: ground

      ground%name = 'ground'
      parts%anchors = [ground]
      allocate (parts%model%bodies(0), parts%model%joints(0), parts%model%functions(0), parts%model%loads(0), &
                parts%model%springs(0), parts%model%elements(0), parts%model%points(0), parts%model%events(0))
   end subroutine start_parts

   !> All groups of the mechanism, in an order in which names are known before they are used.
   subroutine read_all(file, parts, hold, error)
      type(namelist_file_t), intent(in) :: file
      type(parts_t), intent(inout) :: parts
      character(*), intent(out) :: hold(:)
      type(error_t), allocatable, intent(inout) :: error
      integer :: i, pass

      hold = ''
      do pass = 1, 6
         do i = 1, size(file%groups)
            if (allocated(error)) return
            associate (group => file%groups(i))
               select case (group%name)
               case ('mechanism')
                  if (pass == 1) call read_flags(file, group, parts, hold, error)
               case ('gravity')
                  if (pass == 2) call read_gravity(file, group, parts, error)
               case ('body')
                  if (pass == 2) call read_body(file, group, parts, error)
               case ('beam')
                  if (pass == 2) call read_beam(file, group, parts, error)
               case ('point_mass')
                  if (pass == 2) call read_point_mass(file, group, parts, error)
               case ('ground_point')
                  if (pass == 2) call read_ground_point(file, group, parts, error)
               case ('function')
                  if (pass == 2) call read_function(file, group, parts, error)
               case ('point')
                  if (pass == 3) call read_point(file, group, parts, error)
               case ('joint')
                  if (pass == 4) call read_joint(file, group, parts, error)
               case ('rolling')
                  if (pass == 4) call read_rolling(file, group, parts, error)
               case ('knife_edge')
                  if (pass == 4) call read_knife_edge(file, group, parts, error)
               case ('force', 'moment')
                  if (pass == 5) call read_load(file, group, parts, error)
               case ('spring', 'damper')
                  if (pass == 5) call read_spring(file, group, parts, error)
               case ('event')
                  if (pass == 6) call read_event(file, group, parts, error)
               end select
            end associate
         end do
      end do
   end subroutine read_all

   !> &mechanism.
   subroutine read_flags(file, group, parts, hold, error)
      type(namelist_file_t), intent(in) :: file
      type(group_t), intent(in) :: group
      type(parts_t), intent(inout) :: parts
      character(*), intent(inout) :: hold(:)
      type(error_t), allocatable, intent(inout) :: error
      character(len=200) :: message
      integer :: i, status
      logical :: planar
      namelist /mechanism/ planar, hold

      planar = .false.
      do i = 1, size(group%entries)
         read (group%entries(i)%text, nml=mechanism, iostat=status, iomsg=message)
         if (status /= 0) call file%complain(group, i, message, 'planar, hold', error)
      end do
      parts%model%planar = planar
   end subroutine read_flags

   !> &event.
   subroutine read_event(file, group, parts, error)
      type(namelist_file_t), intent(in) :: file
      type(group_t), intent(in) :: group
      type(parts_t), intent(inout) :: parts
      type(error_t), allocatable, intent(inout) :: error
      character(*), parameter :: names = 'name, joint, quantity, point, value'
      character(len=name_length) :: joint, name, point, quantity
      character(len=200) :: message
      real(wp) :: value
      integer :: i, status
      type(anchor_t) :: anchor
      type(event_t) :: made
      namelist /event/ name, joint, quantity, point, value

      name = ''
      joint = ''
      point = ''
      quantity = ''
      value = 0.0_wp
      do i = 1, size(group%entries)
         read (group%entries(i)%text, nml=event, iostat=status, iomsg=message)
         if (status /= 0) call file%complain(group, i, message, names, error)
      end do
      made%name = trim(name)
      made%value = value
      if (len(made%name) == 0 .or. scan(made%name, ', ') > 0) &
         call raise(error, '', 'it has no name, or one with a blank or a comma', 'give name = "..."')
      if (given(group, 'joint') .eqv. given(group, 'point')) then
         call raise(error, '', 'it watches neither a joint nor a point, or both', 'give joint or point')
      else if (given(group, 'joint')) then
         call find_joint(parts, joint, 'joint', made%joint, error)
         if (len_trim(quantity) == 0) quantity = 'angle'
         made%angle = quantity == 'angle'
         if (.not. any(quantity == [character(len=12) :: 'angle', 'displacement'])) &
            call raise(error, '', 'a joint has no quantity "'//trim(quantity)//'"', 'use "angle" or "displacement"')
         if (.not. allocated(error)) then
            associate (watched => parts%model%joints(made%joint))
               if (made%angle .and. .not. has_angle(watched)) &
                  call raise(error, '', 'joint "'//trim(joint)//'" has no angle', 'watch a revolute or a cylindrical joint')
               if (.not. made%angle .and. .not. has_displacement(watched)) &
                  call raise(error, '', 'joint "'//trim(joint)//'" has no displacement', 'watch another joint')
            end associate
         end if
      else
         call find_anchor(parts, point, 'point', anchor, error)
         made%body = anchor%body
         made%at = anchor%at
         made%axis = index('xyz', trim(quantity))
         if (len_trim(quantity) /= 1 .or. made%axis == 0) &
            call raise(error, '', 'a point has no quantity "'//trim(quantity)//'"', 'use "x", "y" or "z"')
      end if
      call locate_named(file, group, name, error)
      if (.not. allocated(error)) parts%model%events = [parts%model%events, made]
   end subroutine read_event

   !> The joints that &output names.
   subroutine choose_shown(file, output, parts, error)
      type(namelist_file_t), intent(in) :: file
      type(mechanism_output_t), intent(in) :: output
      type(parts_t), intent(inout) :: parts
      type(error_t), allocatable, intent(inout) :: error
      integer :: i, j

      if (.not. allocated(output%joints)) return
      if (output%joints(1) == 'all') return
      allocate (parts%model%shown(0))
      if (output%joints(1) == 'none') return
      do i = 1, size(output%joints)
         call find_joint(parts, output%joints(i), 'joints', j, error)
         if (allocated(error)) then
            call file%locate(file%groups(first_group(file, 'output')), error)
            return
         end if
         parts%model%shown = [parts%model%shown, j]
      end do
   end subroutine choose_shown

   !> Brings the start to the constraints, and says what was found.
   subroutine assemble(file, hold, model, start, settings, report, error)
      type(namelist_file_t), intent(in) :: file
      character(*), intent(in) :: hold(:)
      type(mechanism_t), intent(inout) :: model
      type(state_t), intent(out) :: start
      type(settings_t), intent(in) :: settings
      type(mechanism_report_t), intent(out) :: report
      type(error_t), allocatable, intent(inout) :: error
      type(start_report_t) :: consistent
      type(state_t) :: given_start
      logical :: held(model%n)
      integer :: i

      start = model%start_state()
      start%t = settings%t_start
      given_start = start
      held = .false.
      do i = 1, size(hold)
         if (len_trim(hold(i)) > 0) call hold_coordinate(model, trim(hold(i)), held, error)
      end do
      if (any(held) .and. .not. allocated(error)) call assemble_holding(model, held, start, error)
      if (.not. allocated(error)) then
         call consistent_start(model, settings%methods(1)%method, start, consistent, error)
         if (allocated(error)) error%what = 'the mechanism cannot be assembled ('//error%what//')'
      end if
      if (allocated(error)) then
         call blame(file, model, given_start, start, error)
      else
         call report_start(model, given_start, start, consistent%rank, report)
      end if
   end subroutine assemble

   !> Names the joint that was open at the start and stays so, or those whose velocities contradict each other.
   subroutine blame(file, model, given_start, reached, error)
      type(namelist_file_t), intent(in) :: file
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
      if (left > 1.0e-9_wp) then
         call worst_joint(model, given_start, i, open_by)
         error%what = 'it is open by '//to_text(open_by)//' at the start, and the worst joint stays open by '//to_text(left)// &
                      ': '//error%what
      else
         call contradicting_velocities(model, reached, names, i, left)
         if (i == 0) return
         error%what = 'the velocities of '//names//' contradict each other or what is held, '//to_text(left)// &
                      ' is left: '//error%what
      end if
      associate (joint => model%joints(i))
         error%where = file%path//':'//to_text(joint%line)//': &joint "'//joint%name//'"'
      end associate
   end subroutine blame

end module taut_case_mechanism
