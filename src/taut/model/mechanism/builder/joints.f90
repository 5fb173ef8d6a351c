!> Joints of a mechanism that is being built.
submodule(taut_model_mechanism_builder) taut_model_mechanism_builder_joints
   use taut_model_mechanism_joint, only: joint_frames, joint_rows
   use taut_model_mechanism_joint_table, only: general_types, joint_kinds, number_of_type, type_coordinate, type_distance, &
                                               type_fixed, type_knife_edge, type_planar, type_prismatic, type_rolling, &
                                               type_universal
   use taut_model_mechanism_row, only: row_t
   use taut_rotation, only: cross
   implicit none (type, external)

   real(wp), parameter :: normal_of_plane(3) = [0.0_wp, 0.0_wp, 1.0_wp], origin(3) = 0.0_wp

contains

   !> A joint.
   module procedure add_joint
      type(joint_t) :: made
      type(anchor_t) :: one, two

      if (allocated(self%error)) return
      made%name = trim(name)
      made%type = number_of_type(type)
      if (.not. any(general_types == type)) then
         call raise(self%error, '', 'there is no joint type "'//trim(type)//'"', &
                    meant_of(type, general_types)//'se '//list(general_types))
      else
         call check_arguments()
      end if
      call self%find_anchor(body_1, 'body_1', one)
      call self%find_anchor(body_2, 'body_2', two)
      made%drive = self%find_function(drive, 'drive')
      made%angle_drive = self%find_function(drive_angle, 'drive_angle')
      if (.not. allocated(self%error)) call place()
      if (.not. allocated(self%error)) call keep_joint(self, made)
      call locate(self, 'joint', name)
      call note_angle(self, 'joint', name, 'angle', angle)
      if (.not. allocated(self%error)) then
         call note_far_joint(self, made, made%body_1, made%p_1, made%frame_1)
         call note_far_joint(self, made, made%body_2, made%p_2, made%frame_2)
      end if

   contains

      !> What does not go together.
      subroutine check_arguments()
         if (present(axis) .and. (present(axis_1) .or. present(axis_2))) &
            call raise(self%error, '', 'its axis is given in two ways', 'give axis, or axis_1 and axis_2')
         if (present(axis_1) .neqv. present(axis_2)) &
            call raise(self%error, '', 'axis_1 and axis_2 are not both given', 'give both, or axis alone')
         if (present(length) .and. made%type /= type_distance) &
            call raise(self%error, '', 'length is not for a '//trim(type)//' joint', 'remove it')
         if (present(value) .and. made%type /= type_coordinate) &
            call raise(self%error, '', 'value is not for a '//trim(type)//' joint', 'remove it')
      end subroutine check_arguments

      !> Points, frames and length.
      subroutine place()
         type(pose_t) :: pose_1, pose_2
         real(wp) :: d(3), direction_1(3), direction_2(3), turn
         logical :: local

         local = .false.
         if (present(in_body_axes)) local = in_body_axes
         turn = 0.0_wp
         if (present(angle)) turn = angle
         if (one%body == two%body) then
            call raise(self%error, '', 'it joins "'//one%name//'" to itself', 'name two different bodies')
            return
         end if
         if (made%type == type_coordinate .and. one%body /= 0) &
            call raise(self%error, '', 'a coordinate is measured from the ground, not from "'//one%name//'"', &
                       'leave body_1 out, or use a prismatic joint')
         made%body_1 = one%body
         made%body_2 = two%body
         if (.not. (any(made%type == [type_distance, type_coordinate]) .or. one%is_point .or. two%is_point .or. &
                    present(point) .or. present(point_1) .or. present(point_2))) &
            call raise(self%error, '', 'it has no point', 'give point = x, y, z, or point_1 and point_2')
         call place_points(self, one, two, point, point_1, point_2, local, made%p_1, made%p_2)
         if (allocated(self%error)) return
         if (made%type == type_distance .and. .not. present(point)) then
            if (.not. present(point_1) .and. .not. one%is_point) then
               if (one%body == 0) call raise(self%error, '', 'its point on the ground is not given', &
                                             'give point_1, or name '//trim(self%words%ground_point)//' as body_1')
               made%p_1 = 0.0_wp
            end if
            if (.not. present(point_2) .and. .not. two%is_point) made%p_2 = 0.0_wp
         end if
         pose_1 = self%start_pose(made%body_1)
         pose_2 = self%start_pose(made%body_2)
         if (made%type == type_coordinate) made%p_1 = 0.0_wp
         d = pose_2%p + matmul(pose_2%r, made%p_2) - pose_1%p - matmul(pose_1%r, made%p_1)
         call directions(local, pose_1, pose_2, direction_1, direction_2)
         if (allocated(self%error)) return
         call joint_frames(made, pose_1, pose_2, direction_1, direction_2, turn, self%error)
         if (made%type == type_distance .and. made%drive == 0) then
            made%length = norm2(d)
            if (present(length)) made%length = length
            if (.not. (made%length > 0.0_wp .and. made%length <= huge(1.0_wp))) &
               call raise(self%error, '', 'its length is not positive', 'give length in m, or set its points apart')
         else if (made%type == type_coordinate .and. made%drive == 0) then
            made%length = dot_product(direction_1/max(norm2(direction_1), tiny(1.0_wp)), d)
            if (present(value)) made%length = value
         end if
         if (made%type == type_distance .and. .not. norm2(d) > 0.0_wp) &
            call raise(self%error, '', 'its points are at one place: the distance has no direction', &
                       'set them apart, or use "spherical"')
      end subroutine place

      !> The axis of either body, in global axes at the start.
      subroutine directions(local, pose_1, pose_2, direction_1, direction_2)
         logical, intent(in) :: local
         type(pose_t), intent(in) :: pose_1, pose_2
         real(wp), intent(out) :: direction_1(3), direction_2(3)
         logical :: about_normal

         direction_1 = 0.0_wp
         direction_2 = 0.0_wp
         if (present(axis)) then
            direction_1 = axis
            if (local) direction_1 = matmul(pose_1%r, axis)
            direction_2 = direction_1
         else if (present(axis_1) .and. present(axis_2)) then
            direction_1 = axis_1
            direction_2 = axis_2
            if (local) direction_1 = matmul(pose_1%r, axis_1)
            if (local) direction_2 = matmul(pose_2%r, axis_2)
         else if (merge(joint_kinds(made%type)%needs_axis_in_plane, joint_kinds(made%type)%needs_axis, self%planar)) then
            call raise(self%error, '', 'it has no axis', 'give axis = x, y, z')
         else
            direction_1 = normal_of_plane
            direction_2 = normal_of_plane
         end if
         if (made%type == type_universal) then
            if (.not. present(axis_1)) call raise(self%error, '', 'a universal joint has two axes', &
                                                  'give axis_1 and axis_2, at right angles')
            ! Axes in body axes may be brought to right angles by the assembly, but not from parallel ones.
            if (abs(dot_product(direction_1, direction_2)) > merge(0.999_wp, 1.0e-3_wp, local)* &
                norm2(direction_1)*norm2(direction_2)) &
               call raise(self%error, '', 'axis_1 and axis_2 must be at right angles', &
                          'axis_1 turns with body_1, axis_2 with body_2: those of its cross')
         end if
         if (.not. self%planar) return
         about_normal = joint_kinds(made%type)%has_angle
         if (about_normal .and. norm2(direction_1(1:2)) + norm2(direction_2(1:2)) > 0.0_wp) then
            call raise(self%error, '', 'its axis is not normal to the plane x-y', 'leave the axis out')
         else if (joint_kinds(made%type)%turns_about_normal) then
            direction_1 = normal_of_plane
            direction_2 = normal_of_plane
         else if (.not. about_normal .and. made%type /= type_distance) then
            if (abs(direction_1(3)) + abs(direction_2(3)) > 0.0_wp) &
               call raise(self%error, '', 'its axis leaves the plane x-y', 'give a direction with z = 0')
         end if
      end subroutine directions

   end procedure add_joint

   !> A bushing.
   module procedure add_bushing
      type(anchor_t) :: one, two
      type(bushing_t) :: made
      logical :: local

      if (allocated(self%error)) return
      made%name = ''
      if (present(name)) made%name = trim(name)
      local = .false.
      if (present(in_body_axes)) local = in_body_axes
      if (present(stiffness)) made%stiffness(1:3) = stiffness
      if (present(rotational_stiffness)) made%stiffness(4:6) = rotational_stiffness
      if (present(damping)) made%damping(1:3) = damping
      if (present(rotational_damping)) made%damping(4:6) = rotational_damping
      call check_numbers()
      call self%find_anchor(body_1, 'body_1', one)
      call self%find_anchor(body_2, 'body_2', two)
      if (.not. allocated(self%error)) call place()
      if (.not. allocated(self%error)) then
         call make_room_bushings(self)
         self%bushing_count = self%bushing_count + 1
         self%bushings(self%bushing_count) = made
      end if
      call locate(self, 'bushing', made%name)
      call note_far(self, 'bushing', made%name, 'its point', made%body_1, made%p_1)
      call note_far(self, 'bushing', made%name, 'its point', made%body_2, made%p_2)

   contains

      !> None is negative, and there is one; in the plane there is nothing across it.
      subroutine check_numbers()
         associate (all_of_them => [made%stiffness, made%damping])
            if (.not. all(abs(all_of_them) <= huge(1.0_wp))) then
               call raise(self%error, '', 'one of its numbers is not finite', 'correct it')
            else if (any(all_of_them < 0.0_wp)) then
               call raise(self%error, '', 'a stiffness or a damping of '//to_text(minval(all_of_them))//' is negative', &
                          'give zero or more; what drives apart is a &spring with a negative stiffness')
            else if (.not. any(all_of_them > 0.0_wp)) then
               call raise(self%error, '', 'it has neither stiffness nor damping', 'give one of them')
            end if
         end associate
         if (self%planar .and. any([made%stiffness(3:5), made%damping(3:5)] > 0.0_wp)) &
            call raise(self%error, '', 'it leaves the plane x-y', 'in the plane give two numbers along it, and one about z')
      end subroutine check_numbers

      !> Points and axes.
      subroutine place()
         type(pose_t) :: pose_1, pose_2
         real(wp) :: frame(3, 3)

         if (one%body == two%body) then
            call raise(self%error, '', 'it joins "'//one%name//'" to itself', 'name two different bodies')
            return
         end if
         made%body_1 = one%body
         made%body_2 = two%body
         call check_masses(one, two)
         call check_masses(two, one)
         call place_points(self, one, two, point, point_1, point_2, local, made%p_1, made%p_2)
         pose_1 = self%start_pose(one%body)
         pose_2 = self%start_pose(two%body)
         call find_axes(pose_1, frame)
         if (allocated(self%error)) return
         made%frame_1 = matmul(transpose(pose_1%r), frame)
         made%frame_2 = matmul(transpose(pose_2%r), frame)
      end subroutine place

      !> A point mass does not turn: it has no axes for another body.
      subroutine check_masses(it, other)
         type(anchor_t), intent(in) :: it, other

         if (it%body == 0) return
         if (.not. any(self%bodies(it%body)%kind == [body_point, body_planar_point])) return
         if (other%body /= 0) &
            call raise(self%error, '', '"'//it%name//'" is '//trim(self%words%point_mass)//', which has no axes', &
                       'join it to the ground, or join two bodies, or use a spring')
         if (any([made%stiffness(4:6), made%damping(4:6)] > 0.0_wp)) &
            call raise(self%error, '', '"'//it%name//'" is '//trim(self%words%point_mass)//', which does not turn', &
                       'leave rotational_stiffness and rotational_damping out')
      end subroutine check_masses

      !> Its axes at the start, in global ones.
      subroutine find_axes(pose_1, frame)
         type(pose_t), intent(in) :: pose_1
         real(wp), intent(out) :: frame(3, 3)
         real(wp), parameter :: x(3) = [1.0_wp, 0.0_wp, 0.0_wp]
         real(wp) :: near(3)

         frame(:, 3) = normal_of_plane
         if (present(axis)) frame(:, 3) = axis
         near = x
         if (present(side)) near = side
         if (local) then
            if (present(axis)) frame(:, 3) = matmul(pose_1%r, axis)
            if (present(side)) near = matmul(pose_1%r, side)
         end if
         if (self%planar .and. norm2(frame(1:2, 3)) + abs(near(3)) > 0.0_wp) then
            call raise(self%error, '', 'its axes leave the plane x-y', 'leave the axis out, and give a side with z = 0')
         else if (.not. (norm2(frame(:, 3)) > 0.0_wp .and. norm2(frame(:, 3)) <= huge(1.0_wp) .and. norm2(near) > 0.0_wp .and. &
                         norm2(near) <= huge(1.0_wp))) then
            call raise(self%error, '', 'its axis or its side is zero, or not a number', 'give a direction of any length')
         end if
         if (allocated(self%error)) return
         frame(:, 3) = frame(:, 3)/norm2(frame(:, 3))
         near = near/norm2(near)
         if (.not. present(side) .and. abs(dot_product(near, frame(:, 3))) > 0.999_wp) near = normal_of_plane
         frame(:, 2) = cross(frame(:, 3), near)
         if (norm2(frame(:, 2)) < 1.0e-6_wp) then
            call raise(self%error, '', 'its side is along its axis', 'give a direction across it')
            return
         end if
         frame(:, 2) = frame(:, 2)/norm2(frame(:, 2))
         frame(:, 1) = cross(frame(:, 2), frame(:, 3))
      end subroutine find_axes

   end procedure add_bushing

   !> Places the points of what joins two anchors: a point that both share, or one for each; a side that has none takes the
   !! point of the other, or the center of mass.
   subroutine place_points(self, one, two, shared, point_1, point_2, local, p_1, p_2)
      type(mechanism_builder_t), intent(inout) :: self
      type(anchor_t), intent(in) :: one, two
      real(wp), intent(in), optional :: shared(3), point_1(3), point_2(3)
      logical, intent(in) :: local
      real(wp), intent(out) :: p_1(3), p_2(3)
      type(pose_t) :: it(2)
      logical :: known(2)
      integer :: i

      it = [self%start_pose(one%body), self%start_pose(two%body)]
      call place(one, it(1), point_1, p_1, known(1))
      call place(two, it(2), point_2, p_2, known(2))
      if (.not. any(known)) then
         ! The center of mass of the second, or of the first if that is the ground.
         i = merge(1, 2, two%body == 0)
         known(i) = .true.
      end if
      if (.not. known(1)) p_1 = matmul(it(2)%p + matmul(it(2)%r, p_2) - it(1)%p, it(1)%r)
      if (.not. known(2)) p_2 = matmul(it(1)%p + matmul(it(1)%r, p_1) - it(2)%p, it(2)%r)
      if (.not. (all(abs(p_1) <= huge(1.0_wp)) .and. all(abs(p_2) <= huge(1.0_wp)))) &
         call raise(self%error, '', 'one of its points is not a number', 'correct it')

   contains

      !> The point of one side, if it is known.
      subroutine place(anchor, it, point, p, is_known)
         type(anchor_t), intent(in) :: anchor
         type(pose_t), intent(in) :: it
         real(wp), intent(in), optional :: point(3)
         real(wp), intent(out) :: p(3)
         logical, intent(out) :: is_known

         p = 0.0_wp
         is_known = .true.
         if (anchor%is_point) then
            p = anchor%at
            if (present(point)) call raise(self%error, '', 'a point is given on "'//anchor%name//'", which is a point itself', &
                                           'leave it out')
         else if (present(point)) then
            p = point
            if (.not. local) p = matmul(point - it%p, it%r)
         else if (present(shared)) then
            p = matmul(shared - it%p, it%r)
         else
            is_known = .false.
         end if
      end subroutine place

   end subroutine place_points

   !> Adds a joint after a last check, and its name.
   subroutine keep_joint(self, joint)
      type(mechanism_builder_t), intent(inout) :: self
      type(joint_t), intent(in) :: joint
      type(row_t), allocatable :: holonomic(:), rates(:)

      call check_name(self, joint%name, .true.)
      call joint_rows(joint, self%planar, holonomic, rates, self%error)
      if (allocated(self%error)) return
      call make_room_joints(self)
      self%joint_count = self%joint_count + 1
      self%joints(self%joint_count) = joint
      call self%joint_names%add(joint%name, self%joint_count)
   end subroutine keep_joint

   !> Notes a point that is far off one of the bodies that it joins, beside the axis along which it may lie anywhere.
   subroutine note_far_joint(self, joint, number, p, frame)
      type(mechanism_builder_t), intent(inout) :: self
      type(joint_t), intent(in) :: joint
      !> The body, 0 for the ground; the point [m] and the frame in its axes.
      integer, intent(in) :: number
      real(wp), intent(in) :: p(3), frame(3, 3)
      real(wp) :: off(3)

      if (any(joint%type == [type_prismatic, type_planar, type_fixed, type_coordinate])) return
      off = p
      if (joint_kinds(joint%type)%needs_axis) off = [matmul(p, frame(:, 1:2)), 0.0_wp]
      call note_far(self, 'joint', joint%name, 'its point', number, off)
   end subroutine note_far_joint

   !> A disc that rolls on a plane.
   module procedure add_rolling
      type(anchor_t) :: ground, owner
      type(joint_t) :: made
      real(wp) :: up(3), on_plane(3)

      if (allocated(self%error)) return
      ground%name = 'ground'
      up = normal_of_plane
      if (present(normal)) up = normal
      on_plane = origin
      if (present(plane_point)) on_plane = plane_point
      call self%find_anchor(body, 'body', owner)
      if (.not. (radius > 0.0_wp .and. radius <= huge(radius))) &
         call raise(self%error, '', 'its radius is not positive', 'give radius in m')
      if (.not. allocated(self%error) .and. owner%body == 0) call raise(self%error, '', 'the ground cannot roll', 'name a body')
      if (.not. allocated(self%error)) then
         made%name = trim(name)
         made%type = type_rolling
         made%body_2 = owner%body
         made%length = radius
         call place_points(self, ground, owner, point_1=on_plane, point_2=center, local=.false., p_1=made%p_1, p_2=made%p_2)
         ! Without a center: the center of mass.
         if (.not. present(center) .and. .not. owner%is_point) made%p_2 = 0.0_wp
      end if
      if (.not. allocated(self%error)) &
         call joint_frames(made, self%start_pose(0), self%start_pose(owner%body), up, axis, 0.0_wp, self%error)
      if (.not. allocated(self%error)) then
         associate (it => self%start_pose(owner%body))
            if (abs(dot_product(matmul(it%r, made%frame_2(:, 3)), made%frame_1(:, 3))) > 1.0_wp - 1.0e-9_wp) &
               call raise(self%error, '', 'the disc lies flat on its plane', 'tilt it')
         end associate
      end if
      if (.not. allocated(self%error)) call keep_joint(self, made)
      call locate(self, 'rolling', name)
   end procedure add_rolling

   !> A knife edge.
   module procedure add_knife_edge
      type(anchor_t) :: ground, owner
      type(joint_t) :: made

      if (allocated(self%error)) return
      ground%name = 'ground'
      call self%find_anchor(body, 'body', owner)
      if (.not. allocated(self%error) .and. owner%body == 0) &
         call raise(self%error, '', 'the ground has no edge that moves', 'name a body')
      if (.not. allocated(self%error)) then
         made%name = trim(name)
         made%type = type_knife_edge
         made%body_2 = owner%body
         call place_points(self, ground, owner, point_2=point, local=.false., p_1=made%p_1, p_2=made%p_2)
      end if
      if (.not. allocated(self%error)) then
         if (self%planar .and. abs(across(3)) > 0.0_wp) &
            call raise(self%error, '', 'its direction leaves the plane x-y', 'give a direction with z = 0')
      end if
      if (.not. allocated(self%error)) &
         call joint_frames(made, self%start_pose(0), self%start_pose(owner%body), across, across, 0.0_wp, self%error)
      if (.not. allocated(self%error)) call keep_joint(self, made)
      call locate(self, 'knife edge', name)
   end procedure add_knife_edge

   !> Names, separated by commas.
   pure function list(names) result(text)
      character(*), intent(in) :: names(:)
      character(len=sum(len_trim(names)) + 4*size(names) - 2) :: text
      integer :: i, last

      text = '"'//trim(names(1))//'"'
      last = len_trim(names(1)) + 2
      do i = 2, size(names)
         text(last + 1:) = ', "'//trim(names(i))//'"'
         last = last + len_trim(names(i)) + 4
      end do
   end function list

   !> Room for one more in the list, which doubles when it is full.
   subroutine make_room_bushings(self)
      type(mechanism_builder_t), intent(inout) :: self
      type(bushing_t), allocatable :: more(:)

      if (.not. allocated(self%bushings)) allocate (self%bushings(16))
      if (self%bushing_count < ubound(self%bushings, 1)) return
      allocate (more(2*self%bushing_count))
      more(:self%bushing_count) = self%bushings
      call move_alloc(more, self%bushings)
   end subroutine make_room_bushings

   !> Room for one more in the list, which doubles when it is full.
   subroutine make_room_joints(self)
      type(mechanism_builder_t), intent(inout) :: self
      type(joint_t), allocatable :: more(:)

      if (.not. allocated(self%joints)) allocate (self%joints(16))
      if (self%joint_count < ubound(self%joints, 1)) return
      allocate (more(2*self%joint_count))
      more(:self%joint_count) = self%joints
      call move_alloc(more, self%joints)
   end subroutine make_room_joints

end submodule taut_model_mechanism_builder_joints
