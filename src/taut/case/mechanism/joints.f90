!> Groups of a mechanism's case file that make joints: &joint, &rolling, &knife_edge.
module taut_case_mechanism_joints
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise
   use taut_case_mechanism_names, only: anchor_t, check_name, check_repeat, expand, find_anchor, find_function, locate_named, &
                                        name_length, parts_t, start_pose
   use taut_case_namelist_file, only: given, group_t, namelist_file_t
   use taut_model_mechanism_body, only: pose_t
   use taut_model_mechanism_joint, only: joint_frames, joint_rows, joint_t
   use taut_model_mechanism_joint_table, only: joint_types, type_coordinate, type_distance, type_fixed, type_knife_edge, &
                                               type_revolute, type_rolling, type_spherical, type_universal
   use taut_model_mechanism_row, only: row_t
   implicit none (type, external)
   private
   public :: read_joint, read_rolling, read_knife_edge, place_points

contains

   !> Places the points of what joins two anchors: a point that both share, or one for each; a side that has none takes the
   !! point of the other, or the center of mass.
   subroutine place_points(parts, one, two, shared, has, points, in_body_axes, p_1, p_2, error)
      !> What was read so far.
      type(parts_t), intent(in) :: parts
      !> The first anchor.
      type(anchor_t), intent(in) :: one
      !> The second.
      type(anchor_t), intent(in) :: two
      !> The point that both share, in global axes at the start.
      real(wp), intent(in) :: shared(3)
      !> Whether it is given, and whether those of the first and the second are.
      logical, intent(in) :: has(3)
      !> The point of each: (3, 2).
      real(wp), intent(in) :: points(3, 2)
      !> Whether these are in body axes; else in global ones at the start.
      logical, intent(in) :: in_body_axes
      !> Point of the first, in body axes [m].
      real(wp), intent(out) :: p_1(3)
      !> Point of the second, in body axes [m].
      real(wp), intent(out) :: p_2(3)
      !> A point that is given twice, or is not a number.
      type(error_t), allocatable, intent(inout) :: error
      type(pose_t) :: it(2)
      type(anchor_t) :: anchors(2)
      real(wp) :: p(3, 2)
      logical :: known(2)
      integer :: i

      anchors = [one, two]
      p = 0.0_wp
      known = .false.
      do i = 1, 2
         it(i) = start_pose(parts, anchors(i)%body)
         if (anchors(i)%is_point) then
            p(:, i) = anchors(i)%at
            known(i) = .true.
            if (has(1 + i)) call raise(error, '', 'a point is given on "'//anchors(i)%name//'", which is a point itself', &
                                       'leave it out')
         else if (has(1 + i)) then
            p(:, i) = points(:, i)
            if (.not. in_body_axes) p(:, i) = matmul(points(:, i) - it(i)%p, it(i)%r)
            known(i) = .true.
         else if (has(1)) then
            p(:, i) = matmul(shared - it(i)%p, it(i)%r)
            known(i) = .true.
         end if
      end do
      if (.not. any(known)) then
         ! The center of mass of the second, or of the first if that is the ground.
         i = merge(1, 2, anchors(2)%body == 0)
         known(i) = .true.
      end if
      do i = 1, 2
         if (.not. known(i)) p(:, i) = matmul(it(3 - i)%p + matmul(it(3 - i)%r, p(:, 3 - i)) - it(i)%p, it(i)%r)
      end do
      if (.not. all(abs(p) <= huge(1.0_wp))) call raise(error, '', 'one of its points is not a number', 'correct it')
      p_1 = p(:, 1)
      p_2 = p(:, 2)
   end subroutine place_points

   !> &joint.
   subroutine read_joint(file, group, parts, error)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> The group.
      type(group_t), intent(in) :: group
      !> What was read so far; added to.
      type(parts_t), intent(inout) :: parts
      !> What is wrong.
      type(error_t), allocatable, intent(inout) :: error
      character(*), parameter :: names = 'name, type, body_1, body_2, point, point_1, point_2, axis, axis_1, axis_2, frame, '// &
                                 'angle, length, value, drive, drive_angle, point_step, repeat, first'
      character(len=name_length) :: name, type, body_1, body_2, frame, drive, drive_angle
      character(len=200) :: message
      real(wp) :: angle, axis(3), axis_1(3), axis_2(3), length, point(3), point_1(3), point_2(3), point_step(3), value
      integer :: first, i, kind, repeat, status
      type(joint_t) :: made
      namelist /joint/ name, type, body_1, body_2, point, point_1, point_2, axis, axis_1, axis_2, frame, angle, length, value, &
         drive, drive_angle, point_step, repeat, first

      name = ''
      type = ''
      body_1 = 'ground'
      body_2 = ''
      frame = 'global'
      drive = ''
      drive_angle = ''
      angle = 0.0_wp
      axis = 0.0_wp
      axis_1 = 0.0_wp
      axis_2 = 0.0_wp
      length = 0.0_wp
      value = 0.0_wp
      point = 0.0_wp
      point_1 = 0.0_wp
      point_2 = 0.0_wp
      point_step = 0.0_wp
      repeat = 1
      first = 1
      do i = 1, size(group%entries)
         read (group%entries(i)%text, nml=joint, iostat=status, iomsg=message)
         if (status /= 0) call file%complain(group, i, message, names, error)
      end do
      call check_repeat(repeat, name, error)
      kind = findloc(joint_types(:type_coordinate), type(:len(joint_types)), 1)
      if (kind == 0 .or. len_trim(type) > len(joint_types)) &
         call raise(error, '', 'there is no joint type "'//trim(type)//'"', 'use '//list(joint_types(:type_coordinate)))
      if (.not. any(frame == [character(len=6) :: 'global', 'body'])) &
         call raise(error, '', 'there is no frame "'//trim(frame)//'"', 'use "global" (at the start) or "body"')
      if (given(group, 'axis') .and. (given(group, 'axis_1') .or. given(group, 'axis_2'))) &
         call raise(error, '', 'its axis is given in two ways', 'give axis, or axis_1 and axis_2')
      if (given(group, 'axis_1') .neqv. given(group, 'axis_2')) &
         call raise(error, '', 'axis_1 and axis_2 are not both given', 'give both, or axis alone')
      if (given(group, 'length') .and. kind /= type_distance) &
         call raise(error, '', 'length is not for a '//trim(type)//' joint', 'remove it')
      if (given(group, 'value') .and. kind /= type_coordinate) &
         call raise(error, '', 'value is not for a '//trim(type)//' joint', 'remove it')
      call locate_named(file, group, name, error)
      if (allocated(error)) return
      do i = 1, repeat
         made = joint_t()
         made%type = kind
         made%line = group%line
         made%name = expand(name, first + i - 1)
         call make(first + i - 1, (i - 1)*point_step)
         if (.not. allocated(error)) call add_joint(made, parts, error)
         call locate_named(file, group, made%name, error)
         if (allocated(error)) return
      end do

   contains

      !> One copy.
      subroutine make(number, step)
         integer, intent(in) :: number
         real(wp), intent(in) :: step(3)
         type(anchor_t) :: one, two
         type(pose_t) :: pose_1, pose_2
         real(wp) :: d(3), direction_1(3), direction_2(3)

         call find_anchor(parts, expand(body_1, number), 'body_1', one, error)
         call find_anchor(parts, expand(body_2, number), 'body_2', two, error)
         call find_function(parts, expand(drive, number), 'drive', made%drive, error)
         call find_function(parts, expand(drive_angle, number), 'drive_angle', made%angle_drive, error)
         if (allocated(error)) return
         if (one%body == two%body) then
            call raise(error, '', 'it joins "'//one%name//'" to itself', 'name two different bodies')
            return
         end if
         if (made%type == type_coordinate .and. one%body /= 0) &
            call raise(error, '', 'a coordinate is measured from the ground, not from "'//one%name//'"', &
                       'leave body_1 out, or use a prismatic joint')
         made%body_1 = one%body
         made%body_2 = two%body
         if (.not. (any(made%type == [type_distance, type_coordinate]) .or. one%is_point .or. two%is_point .or. &
                    given(group, 'point') .or. given(group, 'point_1') .or. given(group, 'point_2'))) then
            call raise(error, '', 'it has no point', 'give point = x, y, z, or point_1 and point_2')
            return
         end if
         call place_points(parts, one, two, point + step, &
                           [given(group, 'point'), given(group, 'point_1'), given(group, 'point_2')], &
                           reshape([point_1, point_2], [3, 2]), frame == 'body', made%p_1, made%p_2, error)
         if (allocated(error)) return
         if (made%type == type_distance .and. .not. given(group, 'point')) then
            if (.not. given(group, 'point_1') .and. .not. one%is_point) then
               if (one%body == 0) call raise(error, '', 'its point on the ground is not given', &
                                             'give point_1, or name a &ground_point as body_1')
               made%p_1 = 0.0_wp
            end if
            if (.not. given(group, 'point_2') .and. .not. two%is_point) made%p_2 = 0.0_wp
         end if
         pose_1 = start_pose(parts, made%body_1)
         pose_2 = start_pose(parts, made%body_2)
         d = pose_2%p + matmul(pose_2%r, made%p_2)
         if (made%type == type_coordinate) made%p_1 = 0.0_wp
         d = d - pose_1%p - matmul(pose_1%r, made%p_1)
         direction_1 = axis
         if (given(group, 'axis_1')) direction_1 = axis_1
         direction_2 = axis
         if (given(group, 'axis_2')) direction_2 = axis_2
         if (frame == 'body') direction_1 = matmul(pose_1%r, direction_1)
         if (frame == 'body' .and. given(group, 'axis_2')) direction_2 = matmul(pose_2%r, direction_2)
         if (frame == 'body' .and. given(group, 'axis')) direction_2 = direction_1
         if (.not. (given(group, 'axis') .or. given(group, 'axis_1'))) then
            if (any(made%type == [type_spherical, type_fixed, type_distance]) .or. &
                (parts%model%planar .and. made%type == type_revolute)) then
               direction_1 = [0.0_wp, 0.0_wp, 1.0_wp]
               direction_2 = direction_1
            else
               call raise(error, '', 'it has no axis', 'give axis = x, y, z')
            end if
         end if
         if (made%type == type_universal) then
            if (.not. given(group, 'axis_1')) &
               call raise(error, '', 'a universal joint has two axes', 'give axis_1 and axis_2, at right angles')
            ! Axes in body axes may be brought to right angles by the assembly, but not from parallel ones.
            if (abs(dot_product(direction_1, direction_2)) > merge(0.999_wp, 1.0e-3_wp, frame == 'body')* &
                norm2(direction_1)*norm2(direction_2)) &
               call raise(error, '', 'axis_1 and axis_2 must be at right angles', &
                          'axis_1 turns with body_1, axis_2 with body_2: those of its cross')
         end if
         if (parts%model%planar .and. made%type == type_revolute) then
            if (norm2(direction_1(1:2)) + norm2(direction_2(1:2)) > 0.0_wp) &
               call raise(error, '', 'its axis is not normal to the plane x-y', 'leave the axis out')
         else if (parts%model%planar .and. any(made%type == [type_spherical, type_fixed])) then
            direction_1 = [0.0_wp, 0.0_wp, 1.0_wp]
            direction_2 = direction_1
         else if (parts%model%planar .and. made%type /= type_distance) then
            if (abs(direction_1(3)) + abs(direction_2(3)) > 0.0_wp) &
               call raise(error, '', 'its axis leaves the plane x-y', 'give a direction with z = 0')
         end if
         if (allocated(error)) return
         call joint_frames(made, pose_1, pose_2, direction_1, direction_2, angle, error)
         if (made%type == type_distance .and. made%drive == 0) then
            made%length = norm2(d)
            if (given(group, 'length')) made%length = length
            if (.not. (made%length > 0.0_wp .and. made%length <= huge(1.0_wp))) &
               call raise(error, '', 'its length is not positive', 'give length in m, or set its points apart')
         else if (made%type == type_coordinate .and. made%drive == 0) then
            made%length = dot_product(direction_1/max(norm2(direction_1), tiny(1.0_wp)), d)
            if (given(group, 'value')) made%length = value
         end if
         if (made%type == type_distance .and. .not. norm2(d) > 0.0_wp) &
            call raise(error, '', 'its points are at one place: the distance has no direction', &
                       'set them apart, or use "spherical"')
      end subroutine make

   end subroutine read_joint

   !> Names, separated by commas.
   pure function list(names) result(text)
      character(*), intent(in) :: names(:)
      character(:), allocatable :: text
      integer :: i

      text = '"'//trim(names(1))//'"'
      do i = 2, size(names)
         text = text//', "'//trim(names(i))//'"'
      end do
   end function list

   !> Adds a joint after a last check.
   subroutine add_joint(joint, parts, error)
      type(joint_t), intent(in) :: joint
      type(parts_t), intent(inout) :: parts
      type(error_t), allocatable, intent(inout) :: error
      type(anchor_t), allocatable :: others(:)
      type(row_t), allocatable :: holonomic(:), rates(:)
      integer :: i

      ! All that has columns.
      associate (model => parts%model)
         allocate (others(size(model%joints) + size(model%bodies) + size(model%points)))
         do i = 1, size(model%joints)
            others(i)%name = model%joints(i)%name
         end do
         do i = 1, size(model%bodies)
            others(size(model%joints) + i)%name = model%bodies(i)%name
         end do
         do i = 1, size(model%points)
            others(size(others) - size(model%points) + i)%name = model%points(i)%name
         end do
      end associate
      call check_name(joint%name, others, error)
      call joint_rows(joint, parts%model%planar, holonomic, rates, error)
      if (.not. allocated(error)) parts%model%joints = [parts%model%joints, joint]
   end subroutine add_joint

   !> &rolling: a disc that rolls on a plane without slipping.
   subroutine read_rolling(file, group, parts, error)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> The group.
      type(group_t), intent(in) :: group
      !> What was read so far; added to.
      type(parts_t), intent(inout) :: parts
      !> What is wrong.
      type(error_t), allocatable, intent(inout) :: error
      character(*), parameter :: names = 'name, body, radius, axis, center, normal, plane_point'
      character(len=name_length) :: name, body
      character(len=200) :: message
      real(wp) :: axis(3), center(3), normal(3), plane_point(3), radius
      integer :: i, status
      type(anchor_t) :: ground, owner
      type(joint_t) :: joint
      type(pose_t) :: it
      namelist /rolling/ name, body, radius, axis, center, normal, plane_point

      name = ''
      body = ''
      radius = 0.0_wp
      axis = 0.0_wp
      center = 0.0_wp
      normal = [0.0_wp, 0.0_wp, 1.0_wp]
      plane_point = 0.0_wp
      do i = 1, size(group%entries)
         read (group%entries(i)%text, nml=rolling, iostat=status, iomsg=message)
         if (status /= 0) call file%complain(group, i, message, names, error)
      end do
      call find_anchor(parts, body, 'body', owner, error)
      if (.not. (radius > 0.0_wp .and. radius <= huge(radius))) &
         call raise(error, '', 'its radius is not positive', 'give radius in m')
      if (.not. allocated(error) .and. owner%body == 0) call raise(error, '', 'the ground cannot roll', 'name a body')
      if (.not. allocated(error)) then
         joint%name = trim(name)
         joint%type = type_rolling
         joint%line = group%line
         joint%body_2 = owner%body
         joint%length = radius
         call place_points(parts, ground, owner, plane_point, [.false., .true., given(group, 'center')], &
                           reshape([plane_point, center], [3, 2]), .false., joint%p_1, joint%p_2, error)
         ! Without a center: the center of mass.
         if (.not. given(group, 'center') .and. .not. owner%is_point) joint%p_2 = 0.0_wp
         it = start_pose(parts, owner%body)
         call joint_frames(joint, start_pose(parts, 0), it, normal, axis, 0.0_wp, error)
      end if
      if (.not. allocated(error)) then
         if (abs(dot_product(matmul(it%r, joint%frame_2(:, 3)), joint%frame_1(:, 3))) > 1.0_wp - 1.0e-9_wp) &
            call raise(error, '', 'the disc lies flat on its plane', 'tilt it')
      end if
      if (.not. allocated(error)) call add_joint(joint, parts, error)
      call locate_named(file, group, name, error)
   end subroutine read_rolling

   !> &knife_edge: a point of a body does not move across an edge that is fixed in the body.
   subroutine read_knife_edge(file, group, parts, error)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> The group.
      type(group_t), intent(in) :: group
      !> What was read so far; added to.
      type(parts_t), intent(inout) :: parts
      !> What is wrong.
      type(error_t), allocatable, intent(inout) :: error
      character(*), parameter :: names = 'name, body, point, across'
      character(len=name_length) :: name, body
      character(len=200) :: message
      real(wp) :: across(3), point(3)
      integer :: i, status
      type(anchor_t) :: ground, owner
      type(joint_t) :: joint
      namelist /knife_edge/ name, body, point, across

      name = ''
      body = ''
      point = 0.0_wp
      across = 0.0_wp
      do i = 1, size(group%entries)
         read (group%entries(i)%text, nml=knife_edge, iostat=status, iomsg=message)
         if (status /= 0) call file%complain(group, i, message, names, error)
      end do
      call find_anchor(parts, body, 'body', owner, error)
      if (.not. allocated(error) .and. owner%body == 0) call raise(error, '', 'the ground has no edge that moves', 'name a body')
      if (.not. allocated(error)) then
         joint%name = trim(name)
         joint%type = type_knife_edge
         joint%line = group%line
         joint%body_2 = owner%body
         call place_points(parts, ground, owner, point, [.false., .false., given(group, 'point')], &
                           reshape([point, point], [3, 2]), .false., joint%p_1, joint%p_2, error)
         call joint_frames(joint, start_pose(parts, 0), start_pose(parts, owner%body), across, across, 0.0_wp, error)
      end if
      if (.not. allocated(error)) call add_joint(joint, parts, error)
      call locate_named(file, group, name, error)
   end subroutine read_knife_edge

end module taut_case_mechanism_joints
