!> Scalar holonomic constraints on one node that has a position, a unit quaternion and body angular velocities.
!!
!! Each is a row: phi, its part of A (6 entries: linear velocity in global, angular in body axes) and of b''.
module taut_model_node_constraint
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_rotation, only: cross, quaternion_conjugate, quaternion_product
   implicit none (type, external)
   private
   public :: node_constraint_t, kind_position, kind_rotation, kind_distance

   !> phi = n . (x - p) [m]; phi = 2 n . vec(p* q) [-], which is n . (rotation vector) for small angles;
   !! phi = |x - p| - L [m].
   integer, parameter :: kind_position = 1, kind_rotation = 2, kind_distance = 3

   !> A constraint.
   type :: node_constraint_t
      !> One of the `kind_` constants.
      integer :: kind = kind_position
      !> Index of the node.
      integer :: node = 0
      !> n: a unit vector, in global axes for a position and in the axes of the reference orientation for a rotation.
      real(wp) :: direction(3) = 0.0_wp
      !> p: the point [m].
      real(wp) :: point(3) = 0.0_wp
      !> p: the orientation, a unit quaternion.
      real(wp) :: orientation(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      !> L [m].
      real(wp) :: length = 0.0_wp
   contains
      procedure :: check
      procedure :: violation
      procedure :: row
      procedure :: acceleration
   end type node_constraint_t

contains

   !> Whether its numbers make sense.
   subroutine check(self, error)
      !> The constraint.
      class(node_constraint_t), intent(in) :: self
      !> A direction or a length that is zero.
      type(error_t), allocatable, intent(inout) :: error
      character(*), parameter :: here = 'constraint'

      if (self%kind == kind_distance) then
         if (.not. (self%length > 0.0_wp .and. self%length <= huge(1.0_wp))) &
            call raise(error, here, 'a link of length '//to_text(self%length)//' m is not positive', 'give its length in m')
         if (.not. all(abs(self%point) <= huge(1.0_wp))) &
            call raise(error, here, 'the fixed end of a link is not a number', 'give three numbers in m')
      else if (.not. (any(abs(self%direction) > 0.0_wp) .and. all(abs(self%direction) <= huge(1.0_wp)))) then
         call raise(error, here, 'its direction is zero or not a number', 'give a vector of any length')
      end if
   end subroutine check

   !> phi.
   pure function violation(self, x) result(phi)
      !> The constraint.
      class(node_constraint_t), intent(in) :: self
      !> Coordinates of the node: (7).
      real(wp), intent(in) :: x(7)
      !> Its violation [m] or [-].
      real(wp) :: phi
      real(wp) :: r(4)

      select case (self%kind)
      case (kind_position)
         phi = dot_product(self%direction, x(1:3) - self%point)
      case (kind_rotation)
         r = quaternion_product(quaternion_conjugate(self%orientation), x(4:7))
         phi = sign(2.0_wp, r(1))*dot_product(self%direction, r(2:4))
      case default
         phi = norm2(x(1:3) - self%point) - self%length
      end select
   end function violation

   !> The node's part of A.
   !!
   !! A rotation: rdot = r {0, W}/2 has the vector part (r0 W + r x W)/2, so that phidot = (r0 n + n x r) . W. A distance at
   !! the point itself has no direction: zero.
   pure function row(self, x) result(a)
      !> The constraint.
      class(node_constraint_t), intent(in) :: self
      !> Coordinates of the node: (7).
      real(wp), intent(in) :: x(7)
      !> Row of A: (6).
      real(wp) :: a(6)
      real(wp) :: d(3), distance, r(4)

      a(:) = 0.0_wp
      select case (self%kind)
      case (kind_position)
         a(1:3) = self%direction
      case (kind_rotation)
         r = quaternion_product(quaternion_conjugate(self%orientation), x(4:7))
         a(4:6) = sign(1.0_wp, r(1))*(r(1)*self%direction + cross(self%direction, r(2:4)))
      case default
         d = x(1:3) - self%point
         distance = norm2(d)
         if (distance > 0.0_wp) a(1:3) = d/distance
      end select
   end function row

   !> The node's part of b'': minus the rate of A at constant v, times v.
   !!
   !! A rotation: r0dot = -r.W/2 and 2 rdot = r0 W + r x W. A distance: -(v^2 - (A v)^2)/|x - p|.
   pure function acceleration(self, x, v) result(b)
      !> The constraint.
      class(node_constraint_t), intent(in) :: self
      !> Coordinates of the node: (7).
      real(wp), intent(in) :: x(7)
      !> Its velocities: (6).
      real(wp), intent(in) :: v(6)
      !> b'' [m/s^2] or [1/s^2].
      real(wp) :: b
      real(wp) :: d(3), distance, r(4), turned(3)

      b = 0.0_wp
      select case (self%kind)
      case (kind_position)
      case (kind_rotation)
         r = quaternion_product(quaternion_conjugate(self%orientation), x(4:7))
         turned = cross(r(2:4), v(4:6))
         b = sign(0.5_wp, r(1))*(dot_product(r(2:4), v(4:6))*dot_product(self%direction, v(4:6)) &
                                 - dot_product(self%direction, cross(turned, v(4:6))))
      case default
         d = x(1:3) - self%point
         distance = norm2(d)
         if (distance > 0.0_wp) then
            turned = cross(d/distance, v(1:3))
            b = -dot_product(turned, turned)/distance
         end if
      end select
   end function acceleration

end module taut_model_node_constraint
