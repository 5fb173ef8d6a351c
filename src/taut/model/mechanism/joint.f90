!> Joints of a mechanism: where they are, and the rows that they are made of.
!!
!! A joint has a frame in either body; axis 3 is its axis. The frames are parallel at the start or, for a revolute or
!! cylindrical joint with an initial angle, turned by it. In the plane x-y a joint has the rows of the plane only.
module taut_model_mechanism_joint
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise
   use taut_model_mechanism_body, only: pose_t, turned, turned_back
   use taut_model_mechanism_joint_table, only: in_plane, in_space, joint_kinds, type_coordinate, type_distance, type_spherical
   use taut_model_mechanism_row, only: row_angle, row_contact, row_distance, row_dot, row_knife, row_offset, row_point, &
                                        row_rolling, row_t
   use taut_rotation, only: cross
   implicit none (type, external)
   private
   public :: joint_t, joint_rows, joint_frames, joint_angle, joint_displacement, joint_angle_rate, drawn_angle, nearest_turn
   public :: has_angle, has_displacement, keeps_points_together

   !> A joint.
   type :: joint_t
      !> What it is called.
      character(:), allocatable :: name
      !> One of the `type_` constants.
      integer :: type = type_spherical
      !> Its bodies; 0 is the ground.
      integer :: body_1 = 0, body_2 = 0
      !> Its points in body axes [m].
      real(wp) :: p_1(3) = 0.0_wp, p_2(3) = 0.0_wp
      !> Its frames in body axes, one axis a column.
      real(wp) :: frame_1(3, 3) = 0.0_wp, frame_2(3, 3) = 0.0_wp
      !> Length of a distance, value of a coordinate, radius of a disc [m].
      real(wp) :: length = 0.0_wp
      !> Its angle where it is drawn, with its whole turns, as it was stated [rad].
      real(wp) :: start_angle = 0.0_wp
      !> The coordinate of the state that counts its turns; 0: none.
      integer :: counter = 0
      !> In the plane, where angles of bodies count turns: its angle less the difference of theirs, about its axis [rad].
      real(wp) :: offset = 0.0_wp
      !> Whether its points are together by themselves: one of its bodies turns about them.
      logical :: pins = .false.
      !> Functions that drive its angle and its displacement (also: distance, coordinate); 0: none.
      integer :: angle_drive = 0, drive = 0
      !> Its rows: those with a position level, and those without.
      integer :: first = 1, last = 0, first_rate = 1, last_rate = 0
   end type joint_t

contains

   !> Whether it has an angle to be shown.
   pure logical function has_angle(joint)
      !> The joint.
      type(joint_t), intent(in) :: joint

      has_angle = joint_kinds(joint%type)%has_angle
   end function has_angle

   !> Whether its points are together.
   pure logical function keeps_points_together(joint) result(answer)
      !> The joint.
      type(joint_t), intent(in) :: joint

      answer = joint%type /= type_coordinate .and. any(joint_kinds(joint%type)%rows%kind == row_point)
   end function keeps_points_together

   !> Whether it has a displacement to be shown.
   pure logical function has_displacement(joint)
      !> The joint.
      type(joint_t), intent(in) :: joint

      has_displacement = joint_kinds(joint%type)%has_displacement
   end function has_displacement

   !> Frames from an axis given in global axes (or two, for bodies that are not assembled).
   subroutine joint_frames(joint, one, two, axis_1, axis_2, angle, error)
      !> The joint; its frames are set.
      type(joint_t), intent(inout) :: joint
      !> Pose of body 1 at the start.
      type(pose_t), intent(in) :: one
      !> Pose of body 2 at the start.
      type(pose_t), intent(in) :: two
      !> Axis of body 1, in global axes at the start, of any length.
      real(wp), intent(in) :: axis_1(3)
      !> Axis of body 2, likewise.
      real(wp), intent(in) :: axis_2(3)
      !> The angle at the start [rad].
      real(wp), intent(in) :: angle
      !> An axis of length zero.
      type(error_t), allocatable, intent(inout) :: error
      real(wp) :: e(3, 3), f(3, 3)

      if (.not. (norm2(axis_1) > 1.0e-12_wp .and. norm2(axis_2) > 1.0e-12_wp .and. norm2(axis_1) <= huge(1.0_wp) .and. &
                 norm2(axis_2) <= huge(1.0_wp))) then
         call raise(error, 'joint "'//joint%name//'"', 'its axis has the length zero or is not a number', &
                    'give a direction; its length does not matter')
         return
      end if
      call frame_of_axis(axis_1, e)
      f(:, 3) = axis_2/norm2(axis_2)
      ! The first axis of body 1's frame, normal to the axis of body 2.
      f(:, 1) = e(:, 1) - dot_product(e(:, 1), f(:, 3))*f(:, 3)
      if (norm2(f(:, 1)) > 1.0e-3_wp) then
         f(:, 1) = f(:, 1)/norm2(f(:, 1))
         f(:, 2) = cross(f(:, 3), f(:, 1))
      else
         call frame_of_axis(axis_2, f)
      end if
      joint%frame_1 = matmul(transpose(one%r), e)
      e(:, 1) = cos(angle)*f(:, 1) + sin(angle)*f(:, 2)
      e(:, 2) = cos(angle)*f(:, 2) - sin(angle)*f(:, 1)
      e(:, 3) = f(:, 3)
      joint%frame_2 = matmul(transpose(two%r), e)
      joint%start_angle = angle
   end subroutine joint_frames

   !> A frame with a given third axis. An axis in the plane x-y has its first axis in that plane.
   pure subroutine frame_of_axis(axis, e)
      real(wp), intent(in) :: axis(3)
      real(wp), intent(out) :: e(3, 3)
      real(wp), parameter :: x(3) = [1.0_wp, 0.0_wp, 0.0_wp], z(3) = [0.0_wp, 0.0_wp, 1.0_wp]

      e(:, 3) = axis/norm2(axis)
      if (abs(e(3, 3)) < 0.9_wp) then
         e(:, 1) = cross(z, e(:, 3))
         e(:, 1) = e(:, 1)/norm2(e(:, 1))
         e(:, 2) = cross(e(:, 3), e(:, 1))
      else
         e(:, 2) = cross(e(:, 3), x)
         e(:, 2) = e(:, 2)/norm2(e(:, 2))
         e(:, 1) = cross(e(:, 2), e(:, 3))
      end if
   end subroutine frame_of_axis

   !> The rows of a joint: those with a position level, and those without.
   subroutine joint_rows(joint, planar, holonomic, rates, error)
      !> The joint, its points and frames set.
      type(joint_t), intent(in) :: joint
      !> Whether the mechanism is in the plane x-y.
      logical, intent(in) :: planar
      !> Its rows that have a position level.
      type(row_t), allocatable, intent(out) :: holonomic(:)
      !> Its rows that have none.
      type(row_t), allocatable, intent(out) :: rates(:)
      !> A type that the plane does not have, a drive that the type does not have.
      type(error_t), allocatable, intent(inout) :: error
      character(:), allocatable :: here
      integer :: i

      here = 'joint "'//joint%name//'"'
      allocate (holonomic(0), rates(0))
      associate (kind => joint_kinds(joint%type))
         if (planar .and. .not. kind%planar) &
            call raise(error, here, 'a '//trim(kind%name)//' joint has no meaning in the plane', &
                       'use revolute, prismatic, fixed, in-line, distance or coordinate, or a spatial mechanism')
         if (joint%angle_drive > 0 .and. .not. kind%has_angle) &
            call raise(error, here, 'a '//trim(kind%name)//' joint has no angle to be driven', &
                       'drive that of a revolute or cylindrical one')
         if (joint%drive > 0 .and. .not. kind%has_displacement) &
            call raise(error, here, 'a '//trim(kind%name)//' joint has no displacement to be driven', &
                       'drive that of a prismatic or cylindrical one, a distance or a coordinate; `drive_angle` drives an angle')
         if (allocated(error)) return
         do i = 1, size(kind%rows)
            associate (plan => kind%rows(i))
               if (plan%kind == 0 .or. (planar .and. plan%where == in_space) .or. (.not. planar .and. plan%where == in_plane) .or. &
                   (joint%pins .and. plan%kind == row_point)) cycle
               call add(plan%kind, axis(joint%frame_1, plan%a), axis(joint%frame_2, plan%b), axis(joint%frame_1, plan%side), &
                        merge(joint%drive, 0, kind%drives_own_row))
            end associate
         end do
         if (joint%angle_drive > 0) call add(row_angle, joint%frame_1(:, 2), joint%frame_2(:, 1), joint%frame_1(:, 1), &
                                             joint%angle_drive)
         if (joint%drive > 0 .and. .not. kind%drives_own_row) &
            call add(row_offset, joint%frame_1(:, 3), [0.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, 0.0_wp], joint%drive)
      end associate

   contains

      !> An axis of a frame; below zero, a global one; 0, none.
      pure function axis(frame, i) result(e)
         real(wp), intent(in) :: frame(3, 3)
         integer, intent(in) :: i
         real(wp) :: e(3)

         e = 0.0_wp
         if (i > 0) e = frame(:, i)
         if (i < 0) e(-i) = 1.0_wp
      end function axis

      !> One row.
      subroutine add(kind, a, b, side, drive)
         integer, intent(in) :: kind
         real(wp), intent(in) :: a(3), b(3), side(3)
         integer, intent(in) :: drive
         type(row_t) :: row

         row%kind = kind
         row%a = a
         row%b = b
         row%side = side
         row%drive = drive
         row%planar = planar .and. any(kind == [row_point, row_distance])
         if (kind == row_point .and. size(holonomic) > 0) row%continues = holonomic(size(holonomic))%kind == row_point
         row%has_branches = any(kind == [row_dot, row_angle]) .and. norm2(side) > 0.0_wp
         row%p_1 = joint%p_1
         row%p_2 = joint%p_2
         if (any(kind == [row_distance, row_contact, row_rolling]) .or. joint%type == type_coordinate) row%length = joint%length
         if (kind == row_rolling .or. kind == row_knife) then
            rates = [rates, row]
         else
            holonomic = [holonomic, row]
         end if
      end subroutine add

   end subroutine joint_rows

   !> The angle by which body 2 is turned about the axis, from -pi to pi.
   pure function joint_angle(joint, one, two) result(angle)
      !> The joint.
      type(joint_t), intent(in) :: joint
      !> Pose of body 1.
      type(pose_t), intent(in) :: one
      !> Pose of body 2.
      type(pose_t), intent(in) :: two
      !> The angle [rad].
      real(wp) :: angle
      real(wp) :: f(3), g(3)

      g = turned(two%r, joint%frame_2(:, 1))
      f = turned_back(one%r, g)
      angle = atan2(dot_product(f, joint%frame_1(:, 2)), dot_product(f, joint%frame_1(:, 1)))
   end function joint_angle

   !> The angle where the joint is drawn, with the whole turns that were stated.
   pure function drawn_angle(joint, one, two) result(angle)
      !> The joint.
      type(joint_t), intent(in) :: joint
      !> Pose of body 1 at the start.
      type(pose_t), intent(in) :: one
      !> Pose of body 2 at the start.
      type(pose_t), intent(in) :: two
      !> The angle [rad].
      real(wp) :: angle

      angle = nearest_turn(joint_angle(joint, one, two), joint%start_angle)
   end function drawn_angle

   !> An angle, and as many whole turns as bring it nearest to another one.
   pure function nearest_turn(angle, other) result(nearest)
      !> The angle [rad].
      real(wp), intent(in) :: angle
      !> The other one [rad].
      real(wp), intent(in) :: other
      !> The angle with its turns [rad].
      real(wp) :: nearest
      real(wp), parameter :: turn = 2.0_wp*acos(-1.0_wp)

      nearest = angle + turn*anint((other - angle)/turn)
   end function nearest_turn

   !> Rate of this angle.
   pure function joint_angle_rate(joint, one, two) result(rate)
      !> The joint.
      type(joint_t), intent(in) :: joint
      !> Pose of body 1.
      type(pose_t), intent(in) :: one
      !> Pose of body 2.
      type(pose_t), intent(in) :: two
      !> The rate [rad/s].
      real(wp) :: rate
      real(wp) :: axis(3), relative(3)

      ! The angular velocity of body 2 in the axes of body 1.
      axis = turned(two%r, two%w)
      relative = turned_back(one%r, axis)
      rate = dot_product(joint%frame_1(:, 3), relative) - dot_product(joint%frame_1(:, 3), one%w)
   end function joint_angle_rate

   !> How far point 2 is from point 1: along the axis, or for a distance joint at all.
   pure function joint_displacement(joint, one, two) result(displacement)
      !> The joint.
      type(joint_t), intent(in) :: joint
      !> Pose of body 1.
      type(pose_t), intent(in) :: one
      !> Pose of body 2.
      type(pose_t), intent(in) :: two
      !> The displacement [m].
      real(wp) :: displacement
      real(wp) :: d(3)

      d = two%p + matmul(two%r, joint%p_2) - one%p - matmul(one%r, joint%p_1)
      if (joint%type == type_distance) then
         displacement = norm2(d)
      else
         displacement = dot_product(matmul(one%r, joint%frame_1(:, 3)), d)
      end if
   end function joint_displacement

end module taut_model_mechanism_joint
