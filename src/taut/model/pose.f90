!> What has a position and an orientation: coordinates {position (3), unit quaternion, its scalar part first (4)}, velocities
!! {linear velocity in global axes (3), angular velocity in BODY axes (3)}.
module taut_model_pose
   use taut_kinds, only: wp
   use taut_rotation, only: quaternion_body_rate, quaternion_normalized, quaternion_of_vector, quaternion_product, quaternion_rate
   implicit none (type, external)
   private
   public :: pose_rate, pose_velocity, move_pose, normalize_pose, turned, turned_back

contains

   !> R u.
   pure function turned(r, u) result(v)
      !> Rotation.
      real(wp), intent(in) :: r(3, 3)
      !> Vector.
      real(wp), intent(in) :: u(3)
      !> In global axes.
      real(wp) :: v(3)

      v(1) = r(1, 1)*u(1) + r(1, 2)*u(2) + r(1, 3)*u(3)
      v(2) = r(2, 1)*u(1) + r(2, 2)*u(2) + r(2, 3)*u(3)
      v(3) = r(3, 1)*u(1) + r(3, 2)*u(2) + r(3, 3)*u(3)
   end function turned

   !> R^T u.
   pure function turned_back(r, u) result(v)
      !> Rotation.
      real(wp), intent(in) :: r(3, 3)
      !> Vector.
      real(wp), intent(in) :: u(3)
      !> In body axes.
      real(wp) :: v(3)

      v(1) = r(1, 1)*u(1) + r(2, 1)*u(2) + r(3, 1)*u(3)
      v(2) = r(1, 2)*u(1) + r(2, 2)*u(2) + r(3, 2)*u(3)
      v(3) = r(1, 3)*u(1) + r(2, 3)*u(2) + r(3, 3)*u(3)
   end function turned_back

   !> xdot = {v; q {0, W}/2}.
   pure subroutine pose_rate(x, u, rate)
      !> Coordinates: position and unit quaternion.
      real(wp), intent(in) :: x(7)
      !> Velocities: linear in global axes, angular in body axes.
      real(wp), intent(in) :: u(6)
      !> Rate of the coordinates.
      real(wp), intent(out) :: rate(7)

      rate(1:3) = u(1:3)
      rate(4:7) = quaternion_rate(x(4:7), u(4:6))
   end subroutine pose_rate

   !> The velocities that belong to a rate of the coordinates.
   pure subroutine pose_velocity(x, rate, u)
      !> Coordinates: position and unit quaternion.
      real(wp), intent(in) :: x(7)
      !> Their rate.
      real(wp), intent(in) :: rate(7)
      !> Velocities.
      real(wp), intent(out) :: u(6)

      u(1:3) = rate(1:3)
      u(4:6) = quaternion_body_rate(x(4:7), rate(4:7))
   end subroutine pose_velocity

   !> Moves, and turns by a rotation vector in body axes: q := q exp(d).
   pure subroutine move_pose(d, x)
      !> Displacement along the velocities.
      real(wp), intent(in) :: d(6)
      !> Coordinates.
      real(wp), intent(inout) :: x(7)
      real(wp) :: q(4)

      x(1:3) = x(1:3) + d(1:3)
      q = quaternion_product(x(4:7), quaternion_of_vector(d(4:6)))
      x(4:7) = q
   end subroutine move_pose

   !> Brings the quaternion back to length one.
   pure subroutine normalize_pose(x)
      !> Coordinates.
      real(wp), intent(inout) :: x(7)
      real(wp) :: q(4)

      q = quaternion_normalized(x(4:7))
      x(4:7) = q
   end subroutine normalize_pose

end module taut_model_pose
