!> Groups of a mechanism's case file that make loads and functions: &function, &gravity, &force, &moment, &spring, &damper.
module taut_case_mechanism_loads
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_case_mechanism_joints, only: place_points
   use taut_case_mechanism_names, only: anchor_t, check_name, check_repeat, expand, find_anchor, find_function, find_joint, &
                                        locate_named, name_length, parts_t, start_pose
   use taut_case_mechanism_table, only: read_table
   use taut_case_namelist_file, only: given, group_t, namelist_file_t
   use taut_model_mechanism_body, only: pose_t
   use taut_model_mechanism_function, only: function_kinds, function_ramp, function_step, function_table, time_function_t
   use taut_model_mechanism_joint, only: has_angle, joint_angle
   use taut_model_mechanism_load, only: load_t, spring_t
   implicit none (type, external)
   private
   public :: read_function, read_gravity, read_load, read_spring

   integer, parameter :: most_coefficients = 20

contains

   !> &function.
   subroutine read_function(file, group, parts, error)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> The group.
      type(group_t), intent(in) :: group
      !> What was read so far; added to.
      type(parts_t), intent(inout) :: parts
      !> What is wrong.
      type(error_t), allocatable, intent(inout) :: error
      character(*), parameter :: names = 'name, kind, offset, amplitude, rate, frequency, omega, phase, start, finish, '// &
                                 'coefficients, table, repeat, first'
      character(len=name_length) :: name, kind
      character(len=200) :: message, table
      real(wp) :: amplitude, coefficients(most_coefficients), finish, frequency, offset, omega, phase, rate, start
      integer :: first, i, repeat, status
      type(time_function_t) :: made
      namelist /function/ name, kind, offset, amplitude, rate, frequency, omega, phase, start, finish, coefficients, table, &
         repeat, first

      name = ''
      kind = 'constant'
      table = ''
      amplitude = 1.0_wp
      coefficients = 0.0_wp
      finish = huge(1.0_wp)
      frequency = 0.0_wp
      offset = 0.0_wp
      omega = 0.0_wp
      phase = 0.0_wp
      rate = 0.0_wp
      start = 0.0_wp
      repeat = 1
      first = 1
      do i = 1, size(group%entries)
         read (group%entries(i)%text, nml=function, iostat=status, iomsg=message)
         if (status /= 0) call file%complain(group, i, message, names, error)
      end do
      call check_repeat(repeat, name, error)
      if (repeat > 1) call raise(error, '', 'a function is not repeated', 'all copies of a joint may name the same one')
      made%name = trim(name)
      made%kind = findloc(function_kinds, kind(:len(function_kinds)), 1)
      if (made%kind == 0) call raise(error, '', 'there is no kind of function "'//trim(kind)//'"', &
                                     'use "constant", "ramp", "sine", "cosine", "step", "polynomial" or "table"')
      if (given(group, 'frequency') .and. given(group, 'omega')) &
         call raise(error, '', 'frequency and omega are both given', 'give one of them')
      if (made%kind == function_step .and. .not. given(group, 'finish')) finish = start
      if (any(made%kind == [function_step, function_ramp]) .and. finish < start) &
         call raise(error, '', 'finish = '//to_text(finish)//' is before start', 'give a later time')
      if ((made%kind == function_table) .neqv. given(group, 'table')) &
         call raise(error, '', 'table and kind do not go together', 'give kind = "table" and the path of a CSV file, or neither')
      do i = 1, size(parts%model%functions)
         if (parts%model%functions(i)%name == made%name) &
            call raise(error, '', 'the name is taken: there are two of it', 'rename one of them')
      end do
      if (len(made%name) == 0) call raise(error, '', 'it has no name', 'give name = "..."')
      made%offset = offset
      made%amplitude = amplitude
      made%rate = rate
      made%omega = omega
      if (given(group, 'frequency')) made%omega = 2.0_wp*acos(-1.0_wp)*frequency
      made%phase = phase
      made%start = start
      made%finish = finish
      made%coefficients = coefficients
      if (made%kind == function_table .and. .not. allocated(error)) &
         call read_table(file%path, trim(table), made%times, made%values, error)
      if (.not. allocated(error)) call made%check(error)
      call locate_named(file, group, name, error)
      if (.not. allocated(error)) parts%model%functions = [parts%model%functions, made]
   end subroutine read_function

   !> &gravity.
   subroutine read_gravity(file, group, parts, error)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> The group.
      type(group_t), intent(in) :: group
      !> What was read so far.
      type(parts_t), intent(inout) :: parts
      !> What is wrong.
      type(error_t), allocatable, intent(inout) :: error
      character(len=200) :: message
      real(wp) :: acceleration(3)
      integer :: i, status
      namelist /gravity/ acceleration

      acceleration = [0.0_wp, 0.0_wp, -9.81_wp]
      if (parts%model%planar) acceleration = [0.0_wp, -9.81_wp, 0.0_wp]
      if (given(group, 'acceleration')) acceleration = 0.0_wp
      do i = 1, size(group%entries)
         read (group%entries(i)%text, nml=gravity, iostat=status, iomsg=message)
         if (status /= 0) call file%complain(group, i, message, 'acceleration', error)
      end do
      if (.not. all(abs(acceleration) <= huge(1.0_wp))) &
         call raise(error, '', 'its acceleration is not a number', 'give three numbers in m/s^2')
      if (parts%model%planar .and. abs(acceleration(3)) > 0.0_wp) &
         call raise(error, '', 'it leaves the plane x-y', 'give z = 0; without an entry it is 9.81 m/s^2 against y')
      call locate_named(file, group, '', error)
      parts%model%gravity = acceleration
   end subroutine read_gravity

   !> &force and &moment.
   subroutine read_load(file, group, parts, error)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> The group.
      type(group_t), intent(in) :: group
      !> What was read so far; added to.
      type(parts_t), intent(inout) :: parts
      !> What is wrong.
      type(error_t), allocatable, intent(inout) :: error
      character(*), parameter :: names = 'name, body, value, point, follow, function, repeat, first'
      character(len=name_length) :: body, function, name
      character(len=200) :: message
      real(wp) :: point(3), value(3)
      integer :: first, i, repeat, status
      logical :: follow
      type(anchor_t) :: ground, owner
      type(load_t) :: made
      type(pose_t) :: it
      real(wp) :: unused(3)
      namelist /force/ name, body, value, point, follow, function, repeat, first
      namelist /moment/ name, body, value, point, follow, function, repeat, first

      name = ''
      body = ''
      function = ''
      point = 0.0_wp
      value = 0.0_wp
      follow = .false.
      repeat = 1
      first = 1
      do i = 1, size(group%entries)
         if (group%name == 'force') then
            read (group%entries(i)%text, nml=force, iostat=status, iomsg=message)
         else
            read (group%entries(i)%text, nml=moment, iostat=status, iomsg=message)
         end if
         if (status /= 0) call file%complain(group, i, message, names, error)
      end do
      call check_repeat(repeat, body, error)
      if (.not. given(group, 'value')) call raise(error, '', 'its value is not given', 'give value = x, y, z')
      do i = 1, repeat
         made = load_t()
         made%name = expand(name, first + i - 1)
         made%moment = group%name == 'moment'
         made%following = follow
         call find_anchor(parts, expand(body, first + i - 1), 'body', owner, error)
         call find_function(parts, expand(function, first + i - 1), 'function', made%factor, error)
         if (.not. allocated(error) .and. owner%body == 0) call raise(error, '', 'it acts on the ground', 'name a body')
         if (.not. all(abs(value) <= huge(1.0_wp))) call raise(error, '', 'its value is not a number', 'correct it')
         if (.not. allocated(error)) call place_points(parts, ground, owner, point, [.false., .false., given(group, 'point')], &
                                                       reshape([point, point], [3, 2]), .false., unused, made%point, error)
         call locate_named(file, group, made%name, error)
         if (allocated(error)) return
         made%body = owner%body
         made%value = value
         it = start_pose(parts, made%body)
         if (follow) made%value = matmul(value, it%r)
         parts%model%loads = [parts%model%loads, made]
      end do
   end subroutine read_load

   !> &spring and &damper.
   subroutine read_spring(file, group, parts, error)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> The group.
      type(group_t), intent(in) :: group
      !> What was read so far; added to.
      type(parts_t), intent(inout) :: parts
      !> What is wrong.
      type(error_t), allocatable, intent(inout) :: error
      character(*), parameter :: names = 'name, body_1, body_2, point_1, point_2, frame, joint, stiffness, damping, '// &
                                 'free_length, free_angle, preload, repeat, first'
      character(len=name_length) :: body_1, body_2, frame, joint, name
      character(len=200) :: message
      real(wp) :: damping, free_angle, free_length, point_1(3), point_2(3), preload, stiffness
      integer :: first, i, repeat, status
      type(spring_t) :: made
      namelist /spring/ name, body_1, body_2, point_1, point_2, frame, joint, stiffness, damping, free_length, &
         free_angle, preload, repeat, first
      namelist /damper/ name, body_1, body_2, point_1, point_2, frame, joint, stiffness, damping, free_length, &
         free_angle, preload, repeat, first

      name = ''
      body_1 = 'ground'
      body_2 = ''
      frame = 'global'
      joint = ''
      damping = 0.0_wp
      free_angle = 0.0_wp
      free_length = 0.0_wp
      point_1 = 0.0_wp
      point_2 = 0.0_wp
      preload = 0.0_wp
      stiffness = 0.0_wp
      repeat = 1
      first = 1
      do i = 1, size(group%entries)
         if (group%name == 'spring') then
            read (group%entries(i)%text, nml=spring, iostat=status, iomsg=message)
         else
            read (group%entries(i)%text, nml=damper, iostat=status, iomsg=message)
         end if
         if (status /= 0) call file%complain(group, i, message, names, error)
      end do
      call check_repeat(repeat, body_2//joint, error)
      if (.not. all(abs([damping, free_angle, free_length, preload, stiffness]) <= huge(1.0_wp))) &
         call raise(error, '', 'one of its numbers is not finite', 'correct it')
      if (damping < 0.0_wp) call raise(error, '', 'damping = '//to_text(damping)//' is negative: it would add energy', &
                                       'give it in N s/m or N m s/rad')
      if (free_length < 0.0_wp) call raise(error, '', 'free_length = '//to_text(free_length)//' is negative', 'give it in m')
      if (.not. any(frame == [character(len=6) :: 'global', 'body'])) &
         call raise(error, '', 'there is no frame "'//trim(frame)//'"', 'use "global" (at the start) or "body"')
      if (group%name == 'spring' .and. .not. given(group, 'stiffness') .and. .not. given(group, 'preload')) &
         call raise(error, '', 'it has neither stiffness nor preload', 'give stiffness in N/m or N m/rad')
      if (group%name == 'damper' .and. .not. given(group, 'damping')) &
         call raise(error, '', 'its damping is not given', 'give damping in N s/m or N m s/rad')
      do i = 1, repeat
         made = spring_t()
         made%name = expand(name, first + i - 1)
         call make(first + i - 1)
         call locate_named(file, group, made%name, error)
         if (allocated(error)) return
         parts%model%springs = [parts%model%springs, made]
      end do

   contains

      !> One copy.
      subroutine make(number)
         integer, intent(in) :: number
         type(anchor_t) :: one, two
         type(pose_t) :: it(2)
         real(wp) :: d(3)

         made%stiffness = stiffness
         made%damping = damping
         made%preload = preload
         if (given(group, 'joint')) then
            call find_joint(parts, expand(joint, number), 'joint', made%joint, error)
            if (allocated(error)) return
            associate (about => parts%model%joints(made%joint))
               if (.not. has_angle(about)) &
                  call raise(error, '', 'joint "'//about%name//'" has no angle', 'name a revolute or a cylindrical joint')
               made%free = joint_angle(about, start_pose(parts, about%body_1), start_pose(parts, about%body_2))
            end associate
            if (given(group, 'free_angle')) made%free = free_angle
            if (given(group, 'body_1') .or. given(group, 'body_2') .or. given(group, 'free_length')) &
               call raise(error, '', 'it is both about a joint and between bodies', 'give joint, or body_1 and body_2')
            return
         end if
         call find_anchor(parts, expand(body_1, number), 'body_1', one, error)
         call find_anchor(parts, expand(body_2, number), 'body_2', two, error)
         if (allocated(error)) return
         if (one%body == two%body) call raise(error, '', 'it joins "'//one%name//'" to itself', 'name two different bodies')
         if (.not. given(group, 'point_1') .and. .not. one%is_point .and. one%body == 0) &
            call raise(error, '', 'its point on the ground is not given', 'give point_1, or name a &ground_point')
         call place_points(parts, one, two, point_1, [.false., given(group, 'point_1') .or. .not. one%is_point, &
                                                      given(group, 'point_2') .or. .not. two%is_point], &
                           reshape([point_1, point_2], [3, 2]), frame == 'body', made%p_1, made%p_2, error)
         if (allocated(error)) return
         ! Without a point: the center of mass.
         if (.not. given(group, 'point_1') .and. .not. one%is_point) made%p_1 = 0.0_wp
         if (.not. given(group, 'point_2') .and. .not. two%is_point) made%p_2 = 0.0_wp
         made%body_1 = one%body
         made%body_2 = two%body
         it = [start_pose(parts, made%body_1), start_pose(parts, made%body_2)]
         d = it(2)%p + matmul(it(2)%r, made%p_2) - it(1)%p - matmul(it(1)%r, made%p_1)
         made%free = norm2(d)
         if (given(group, 'free_length')) made%free = free_length
         if (.not. norm2(d) > 0.0_wp) call raise(error, '', 'its points are at one place: its force has no direction', &
                                                 'set them apart')
      end subroutine make

   end subroutine read_spring

end module taut_case_mechanism_loads
