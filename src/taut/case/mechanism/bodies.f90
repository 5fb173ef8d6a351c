!> Groups of a mechanism's case file that make bodies and points: &body, &point_mass, &ground_point, &point.
module taut_case_mechanism_bodies
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_case_mechanism_names, only: anchor_t, check_name, check_repeat, expand, find_anchor, locate_named, name_length, &
                                        parts_t, start_pose
   use taut_case_namelist_file, only: given, group_t, namelist_file_t
   use taut_model_mechanism, only: point_t
   use taut_model_mechanism_body, only: body_planar, body_planar_point, body_point, body_spatial, body_t, pose_t
   use taut_rotation, only: quaternion_normalized, quaternion_of_axes, quaternion_of_vector, rotate_back
   implicit none (type, external)
   private
   public :: read_body, read_point_mass, read_ground_point, read_point, add_body

   character(*), parameter :: repetition = 'repeat, first'

contains

   !> &body.
   subroutine read_body(file, group, parts, error)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> The group.
      type(group_t), intent(in) :: group
      !> What was read so far; added to.
      type(parts_t), intent(inout) :: parts
      !> What is wrong.
      type(error_t), allocatable, intent(inout) :: error
      character(*), parameter :: names = 'name, mass, inertia, shape, length, thickness, size, radius, position, from, to, '// &
                                 'angle, orientation, quaternion, velocity, angular_velocity, angle_rate, position_step, '// &
                                 'from_step, to_step, angle_step, '//repetition
      character(len=name_length) :: name, shape
      character(len=200) :: message
      real(wp) :: angle, angle_rate, angle_step, angular_velocity(3), from(3), from_step(3), inertia(6), length, mass, &
                  orientation(3), position(3), position_step(3), quaternion(4), radius, size(3), thickness, to(3), to_step(3), &
                  velocity(3)
      integer :: first, i, repeat, status
      type(body_t) :: made
      namelist /body/ name, mass, inertia, shape, length, thickness, size, radius, position, from, to, angle, orientation, &
         quaternion, velocity, angular_velocity, angle_rate, position_step, from_step, to_step, angle_step, repeat, first

      name = ''
      shape = ''
      mass = 0.0_wp
      inertia = 0.0_wp
      length = 0.0_wp
      thickness = 0.0_wp
      size = 0.0_wp
      radius = 0.0_wp
      position = 0.0_wp
      from = 0.0_wp
      to = 0.0_wp
      angle = 0.0_wp
      orientation = 0.0_wp
      quaternion = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      velocity = 0.0_wp
      angular_velocity = 0.0_wp
      angle_rate = 0.0_wp
      position_step = 0.0_wp
      from_step = 0.0_wp
      to_step = 0.0_wp
      angle_step = 0.0_wp
      repeat = 1
      first = 1
      do i = 1, ubound(group%entries, 1)
         read (group%entries(i)%text, nml=body, iostat=status, iomsg=message)
         if (status /= 0) call file%complain(group, i, message, names, error)
      end do
      call check_repeat(repeat, name, error)
      if (.not. given(group, 'mass')) call raise(error, '', 'it has no mass', 'give mass in kg')
      if (count([given(group, 'orientation'), given(group, 'quaternion'), given(group, 'angle'), given(group, 'from')]) > 1) &
         call raise(error, '', 'its orientation is given in more than one way', &
                    'give one of angle, orientation, quaternion or from, to')
      if (given(group, 'from') .neqv. given(group, 'to')) call raise(error, '', 'from and to are not both given', 'give both')
      if (given(group, 'from') .and. given(group, 'position')) &
         call raise(error, '', 'its position is given in two ways', 'give position, or from and to')
      if (given(group, 'inertia') .and. given(group, 'shape')) &
         call raise(error, '', 'its inertia is given in two ways', 'give inertia, or shape')
      call locate_named(file, group, name, error)
      if (allocated(error)) return
      do i = 1, repeat
         made = body_t()
         made%name = expand(name, first + i - 1)
         made%m = mass
         call place(i - 1)
         if (.not. allocated(error)) call set_inertia()
         if (.not. allocated(error)) call add_body(made, parts, error)
         call locate_named(file, group, made%name, error)
         if (allocated(error)) return
      end do

   contains

      !> Position, orientation and velocities of a copy.
      subroutine place(k)
         integer, intent(in) :: k
         real(wp), parameter :: z(3) = [0.0_wp, 0.0_wp, 1.0_wp]
         real(wp) :: d(3), side(3)

         made%kind = merge(body_planar, body_spatial, parts%model%planar)
         made%position = position + k*position_step
         if (given(group, 'from')) then
            made%position = 0.5_wp*(from + to) + 0.5_wp*k*(from_step + to_step)
            d = to - from + k*(to_step - from_step)
            if (.not. norm2(d) > 0.0_wp) then
               call raise(error, '', 'from and to are the same point', 'set them apart')
               return
            end if
            if (.not. given(group, 'length')) length = norm2(d)
            ! Axis 1 along it, axis 2 level if it can be.
            side = [-d(2), d(1), 0.0_wp]
            if (norm2(side) < 1.0e-6_wp*norm2(d)) side = [0.0_wp, 1.0_wp, 0.0_wp]
            made%orientation = quaternion_of_axes(d, side)
         else if (given(group, 'quaternion')) then
            if (.not. norm2(quaternion) > 0.0_wp) call raise(error, '', 'its quaternion is zero', 'give one of length 1')
            made%orientation = quaternion_normalized(quaternion)
         else
            made%orientation = quaternion_of_vector(orientation + (angle + k*angle_step)*z)
         end if
         made%velocity = velocity
         made%spin = rotate_back(made%orientation, angular_velocity + angle_rate*z)
         if (.not. parts%model%planar) return
         if (abs(made%position(3)) + abs(made%velocity(3)) > 0.0_wp .or. norm2(made%orientation(2:3)) > 1.0e-12_wp .or. &
             norm2(made%spin(1:2)) > 0.0_wp) &
            call raise(error, '', 'it leaves the plane x-y', 'give positions and velocities with z = 0, and turn it about z only')
         made%spin(1:2) = 0.0_wp
      end subroutine place

      !> Moments of inertia, given or of a shape.
      subroutine set_inertia()
         integer :: k

         if (.not. given(group, 'shape')) then
            if (.not. given(group, 'inertia')) call raise(error, '', 'it has neither inertia nor shape', &
                                                          'give one of them, or use &point_mass')
            made%j = reshape([inertia(1), inertia(4), inertia(5), inertia(4), inertia(2), inertia(6), inertia(5), inertia(6), &
                              inertia(3)], [3, 3])
            if (parts%model%planar) made%j = 0.0_wp
            if (parts%model%planar) made%j(3, 3) = inertia(1)
            return
         end if
         select case (shape)
         case ('rod')
            call positive('length', length)
            if (.not. given(group, 'thickness')) thickness = 1.0e-3_wp*length
            if (parts%model%planar .and. .not. given(group, 'thickness')) thickness = 0.0_wp
            size = [length, thickness, thickness]
         case ('box')
            do k = 1, 3
               call positive('size', size(k))
            end do
         case ('sphere')
            call positive('radius', radius)
            size = sqrt(2.4_wp)*radius
         case ('cylinder')
            call positive('radius', radius)
            size = [sqrt(3.0_wp)*radius, sqrt(3.0_wp)*radius, length]
         case default
            call raise(error, '', 'there is no shape "'//trim(shape)//'"', 'use "rod", "box", "sphere" or "cylinder"')
         end select
         made%shape = shape(:len(made%shape))
         made%size = size
         if (shape == 'sphere') made%size = 2.0_wp*radius
         if (shape == 'cylinder') made%size = [2.0_wp*radius, 2.0_wp*radius, length]
         ! Each is as a box of some size: m (b^2 + c^2)/12.
         do k = 1, 3
            made%j(k, k) = mass*(size(1 + mod(k, 3))**2 + size(1 + mod(k + 1, 3))**2)/12.0_wp
         end do
         if (parts%model%planar) made%j(1, 1) = 0.0_wp
         if (parts%model%planar) made%j(2, 2) = 0.0_wp
      end subroutine set_inertia

      !> A side of a shape.
      subroutine positive(entry, value)
         character(*), intent(in) :: entry
         real(wp), intent(in) :: value

         if (.not. (value > 0.0_wp .and. value <= huge(value))) &
            call raise(error, '', entry//' = '//to_text(value)//' is not positive', 'give it in m')
      end subroutine positive

   end subroutine read_body

   !> Adds a body that was checked, and its name.
   subroutine add_body(body, parts, error)
      !> The body.
      type(body_t), intent(in) :: body
      !> What was read so far; added to.
      type(parts_t), intent(inout) :: parts
      !> What is wrong with it.
      type(error_t), allocatable, intent(inout) :: error
      type(anchor_t) :: anchor

      call check_name(body%name, parts%anchors, error)
      call body%check(error)
      if (allocated(error)) return
      parts%model%bodies = [parts%model%bodies, body]
      anchor%name = body%name
      anchor%body = size(parts%model%bodies)
      ! A point mass is a point.
      anchor%is_point = any(body%kind == [body_point, body_planar_point])
      parts%anchors = [parts%anchors, anchor]
   end subroutine add_body

   !> &point_mass.
   subroutine read_point_mass(file, group, parts, error)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> The group.
      type(group_t), intent(in) :: group
      !> What was read so far; added to.
      type(parts_t), intent(inout) :: parts
      !> What is wrong.
      type(error_t), allocatable, intent(inout) :: error
      character(*), parameter :: names = 'name, mass, position, velocity, position_step, '//repetition
      character(len=name_length) :: name
      character(len=200) :: message
      real(wp) :: mass, position(3), position_step(3), velocity(3)
      integer :: first, i, repeat, status
      type(body_t) :: body
      namelist /point_mass/ name, mass, position, velocity, position_step, repeat, first

      name = ''
      mass = 0.0_wp
      position = 0.0_wp
      velocity = 0.0_wp
      position_step = 0.0_wp
      repeat = 1
      first = 1
      do i = 1, size(group%entries)
         read (group%entries(i)%text, nml=point_mass, iostat=status, iomsg=message)
         if (status /= 0) call file%complain(group, i, message, names, error)
      end do
      call check_repeat(repeat, name, error)
      if (.not. given(group, 'mass')) call raise(error, '', 'it has no mass', 'give mass in kg')
      do i = 1, repeat
         body = body_t()
         body%name = expand(name, first + i - 1)
         body%kind = merge(body_planar_point, body_point, parts%model%planar)
         body%m = mass
         body%position = position + (i - 1)*position_step
         body%velocity = velocity
         if (parts%model%planar .and. abs(body%position(3)) + abs(body%velocity(3)) > 0.0_wp) &
            call raise(error, '', 'it leaves the plane x-y', 'give z = 0')
         if (.not. allocated(error)) call add_body(body, parts, error)
         call locate_named(file, group, body%name, error)
         if (allocated(error)) return
      end do
   end subroutine read_point_mass

   !> &ground_point.
   subroutine read_ground_point(file, group, parts, error)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> The group.
      type(group_t), intent(in) :: group
      !> What was read so far; added to.
      type(parts_t), intent(inout) :: parts
      !> What is wrong.
      type(error_t), allocatable, intent(inout) :: error
      character(*), parameter :: names = 'name, position, position_step, '//repetition
      character(len=name_length) :: name
      character(len=200) :: message
      real(wp) :: position(3), position_step(3)
      integer :: first, i, repeat, status
      type(anchor_t) :: anchor
      namelist /ground_point/ name, position, position_step, repeat, first

      name = ''
      position = 0.0_wp
      position_step = 0.0_wp
      repeat = 1
      first = 1
      do i = 1, size(group%entries)
         read (group%entries(i)%text, nml=ground_point, iostat=status, iomsg=message)
         if (status /= 0) call file%complain(group, i, message, names, error)
      end do
      call check_repeat(repeat, name, error)
      do i = 1, repeat
         anchor%name = expand(name, first + i - 1)
         anchor%is_point = .true.
         anchor%at = position + (i - 1)*position_step
         call check_name(anchor%name, parts%anchors, error)
         if (.not. all(abs(anchor%at) <= huge(1.0_wp))) call raise(error, '', 'its position is not a number', 'correct it')
         call locate_named(file, group, anchor%name, error)
         if (allocated(error)) return
         parts%anchors = [parts%anchors, anchor]
      end do
   end subroutine read_ground_point

   !> &point: a point of a body, whose position is written out.
   subroutine read_point(file, group, parts, error)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> The group.
      type(group_t), intent(in) :: group
      !> What was read so far; added to.
      type(parts_t), intent(inout) :: parts
      !> What is wrong.
      type(error_t), allocatable, intent(inout) :: error
      character(*), parameter :: names = 'name, body, position, frame, position_step, '//repetition
      character(len=name_length) :: name, body, frame
      character(len=200) :: message
      real(wp) :: position(3), position_step(3)
      integer :: first, i, repeat, status
      type(anchor_t) :: anchor, owner
      type(pose_t) :: it
      type(point_t) :: shown
      namelist /point/ name, body, position, frame, position_step, repeat, first

      name = ''
      body = ''
      frame = 'global'
      position = 0.0_wp
      position_step = 0.0_wp
      repeat = 1
      first = 1
      do i = 1, size(group%entries)
         read (group%entries(i)%text, nml=point, iostat=status, iomsg=message)
         if (status /= 0) call file%complain(group, i, message, names, error)
      end do
      call check_repeat(repeat, name, error)
      if (.not. any(frame == [character(len=6) :: 'global', 'body'])) &
         call raise(error, '', 'there is no frame "'//trim(frame)//'"', 'use "global" (at the start) or "body"')
      do i = 1, repeat
         anchor%name = expand(name, first + i - 1)
         call check_name(anchor%name, parts%anchors, error)
         call find_anchor(parts, expand(body, first + i - 1), 'body', owner, error)
         if (.not. all(abs(position) <= huge(1.0_wp))) call raise(error, '', 'its position is not a number', 'correct it')
         call locate_named(file, group, anchor%name, error)
         if (allocated(error)) return
         it = start_pose(parts, owner%body)
         anchor%body = owner%body
         anchor%is_point = .true.
         anchor%at = position + (i - 1)*position_step
         if (frame == 'global') anchor%at = matmul(anchor%at - it%p, it%r)
         parts%anchors = [parts%anchors, anchor]
         shown%name = anchor%name
         shown%body = anchor%body
         shown%at = anchor%at
         parts%model%points = [parts%model%points, shown]
      end do
   end subroutine read_point

end module taut_case_mechanism_bodies
