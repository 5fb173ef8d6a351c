!> Where the bodies of a mechanism are, how they move, and their masses.
submodule(taut_model_mechanism) taut_model_mechanism_motion
   use taut_model_mechanism_body, only: body_pinned, body_planar, body_spatial, ground_pose
   use taut_model_mechanism_joint, only: drawn_angle, joint_angle, joint_angle_rate, nearest_turn
   use taut_rotation, only: matrix_of_quaternion
   implicit none (type, external)

contains

   !> The state at the start as given, t = 0.
   module procedure start_state
      type(pose_t) :: one, two
      integer :: i

      allocate (at%x(self%n_x), at%v(self%n), at%w(0), source=0.0_wp)
      do i = 1, size(self%bodies)
         call self%bodies(i)%start(at%x, at%v)
      end do
      do i = 1, size(self%counting)
         associate (joint => self%joints(self%counting(i)))
            call poses_of_joint(self, joint, at%x, at%v, one, two)
            at%x(joint%counter) = drawn_angle(joint, one, two)
         end associate
      end do
   end procedure start_state

   !> The angle of a joint with all its turns since the start.
   module procedure angle_of
      real(wp) :: g(3)

      angle = joint_angle(joint, one, two)
      if (joint%angle_drive > 0 .and. self%enforced) then
         call self%functions(joint%angle_drive)%evaluate(at%t, g)
         angle = nearest_turn(angle, g(1))
      else if (joint%counter > 0) then
         angle = nearest_turn(angle, at%x(joint%counter))
      else if (self%planar) then
         angle = nearest_turn(angle, joint%offset + turned_by(self, joint, at%x))
      end if
   end procedure angle_of

   !> Difference of the bodies' angles in the plane, about the joint's axis.
   module procedure turned_by
      angle = joint%frame_1(3, 3)*(planar_angle(self, joint%body_2, x) - planar_angle(self, joint%body_1, x))
   end procedure turned_by

   !> Angle of a body in the plane with its turns [rad]; a point mass does not turn.
   pure real(wp) function planar_angle(self, body, x) result(angle)
      class(mechanism_t), intent(in) :: self
      integer, intent(in) :: body
      real(wp), intent(in) :: x(:)

      angle = 0.0_wp
      if (body == 0) return
      if (self%bodies(body)%kind == body_planar) angle = x(self%bodies(body)%before_x + 3)
      if (self%bodies(body)%kind == body_pinned) angle = x(self%bodies(body)%before_x + 1)
   end function planar_angle

   !> Poses of the bodies of a joint at coordinates and velocities.
   pure subroutine poses_of_joint(self, joint, x, v, one, two)
      class(mechanism_t), intent(in) :: self
      type(joint_t), intent(in) :: joint
      real(wp), intent(in) :: x(:), v(:)
      type(pose_t), intent(out) :: one, two

      call ground_pose(one)
      if (joint%body_1 > 0) call self%bodies(joint%body_1)%pose(x, v, one)
      call ground_pose(two)
      if (joint%body_2 > 0) call self%bodies(joint%body_2)%pose(x, v, two)
   end subroutine poses_of_joint

   !> Where a body is and how it moves.
   module procedure pose_of
      if (body == 0) then
         call ground_pose(it)
      else
         call self%bodies(body)%pose(at%x, at%v, it)
      end if
   end procedure pose_of

   !> Forgets all poses.
   module procedure clear
      self%body = -1
   end procedure clear

   !> The places of the poses of two bodies, computed where they are not there.
   module procedure find
      one = iand(body_1, places - 1)
      two = iand(body_2, places - 1)
      if (one == two) two = places
      if (self%body(one) /= body_1) then
         self%body(one) = body_1
         call pose_of(model, at, body_1, self%it(one))
      end if
      if (self%body(two) /= body_2) then
         self%body(two) = body_2
         call pose_of(model, at, body_2, self%it(two))
      end if
   end procedure find

   !> M: mass and inertia of each body.
   module procedure mass
      real(wp) :: d(self%n)
      integer :: b, i, k

      do i = 1, size(self%bodies)
         associate (body => self%bodies(i))
            do k = 1, velocities_of_kind(body%kind)
               associate (entry => entry_of_velocity(k, body%kind))
                  d(body%before_v + k) = body%m
                  if (entry > 3) d(body%before_v + k) = body%j(entry - 3, entry - 3)
               end associate
            end do
         end associate
      end do
      call m%set_diagonal(d)
      b = 0
      do i = 1, size(self%bodies)
         b = b + merge(velocities_of_kind(self%bodies(i)%kind), 4, self%bodies(i)%diagonal())
         if (.not. self%bodies(i)%diagonal()) call m%set_block(b, self%bodies(i)%j)
      end do
      associate (unused_state => at)
      end associate
   end procedure mass

   !> xdot, body by body.
   module procedure x_rate
      type(pose_t) :: one, two
      integer :: i

      if (self%planar) then
         ! Coordinates and velocities are the same.
         value(:) = u
         return
      end if
      do i = 1, size(self%bodies)
         call self%bodies(i)%rate(at%x, u, value)
      end do
      do i = 1, size(self%counting)
         associate (joint => self%joints(self%counting(i)))
            call poses_of_joint(self, joint, at%x, u, one, two)
            value(joint%counter) = joint_angle_rate(joint, one, two)
         end associate
      end do
   end procedure x_rate

   !> The inverse of `x_rate`.
   module procedure v_of_x_rate
      integer :: i

      do i = 1, size(self%bodies)
         call self%bodies(i)%velocity_of_rate(at%x, rate, u)
      end do
   end procedure v_of_x_rate

   !> x := x (+) d, body by body.
   module procedure displace
      type(pose_t) :: one, two
      integer :: i

      if (self%planar) then
         x(:) = x + d
         return
      end if
      do i = 1, size(self%counting)
         associate (joint => self%joints(self%counting(i)))
            call poses_of_joint(self, joint, x, d, one, two)
            x(joint%counter) = x(joint%counter) + joint_angle_rate(joint, one, two)
         end associate
      end do
      do i = 1, size(self%bodies)
         call self%bodies(i)%move(d, x)
      end do
   end procedure displace

   !> Quaternions of length one; turns that are whole ones but for the angle between the bodies.
   module procedure normalize
      integer :: i

      if (self%planar) return
      do i = 1, size(self%bodies)
         call self%bodies(i)%normalize(x)
      end do
      if (size(self%counting) > 0) call count_turns(self, x)
   end procedure normalize

   !> The angle between two bodies and the nearest whole turns: the integral of a rate has lost nothing but these.
   subroutine count_turns(self, x)
      class(mechanism_t), intent(in) :: self
      real(wp), intent(inout) :: x(:)
      type(pose_t) :: one, two
      integer :: i

      do i = 1, size(self%counting)
         associate (joint => self%joints(self%counting(i)))
            call rotation_of(self, joint%body_1, x, one)
            call rotation_of(self, joint%body_2, x, two)
            x(joint%counter) = nearest_turn(joint_angle(joint, one, two), x(joint%counter))
         end associate
      end do
   end subroutine count_turns

   !> The rotation of a body in space, and nothing else of its pose.
   pure subroutine rotation_of(self, body, x, it)
      class(mechanism_t), intent(in) :: self
      integer, intent(in) :: body
      real(wp), intent(in) :: x(:)
      type(pose_t), intent(out) :: it

      call ground_pose(it)
      if (body == 0) return
      associate (i => self%bodies(body)%before_x)
         if (self%bodies(body)%kind == body_spatial) it%r = matrix_of_quaternion(x(i + 4:i + 7))
      end associate
   end subroutine rotation_of

   !> Times at which a function is not smooth.
   module procedure breakpoints
      integer :: i

      allocate (times(0))
      do i = 1, size(self%functions)
         times = [times, self%functions(i)%breakpoints()]
      end do
   end procedure breakpoints

end submodule taut_model_mechanism_motion
