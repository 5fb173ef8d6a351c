!> Parts of a mechanism: bodies that move together, with few coordinates of their own, from which those of the bodies follow.
!!
!! A part has the axes of one of its bodies and a point of reference: the mass center of all of it, or the point of the ground about
!! which it turns. With the place p of that point, the rotation R and the angular velocity W in its axes, and a body whose center is
!! at d and whose axes are turned by D, both in those of the part,
!!
!!     x_b = p + R d                      R_b = R D
!!     v_b = pdot + R (W x d)             W_b = D^T W
!!     vdot_b = pddot + R (Wdot x d + W x (W x d))
!!
!! A part moves by Newton's and Euler's equations of one body, for what its bodies do to each other cancels: its mass is the sum m of
!! theirs, its center is where the sum of m_b d_b is zero, and its inertia J the sum of D J_b D^T + m_b (d^2 I - d d^T) (Steiner).
!! The reaction of a weld follows from the equations of the bodies, each by itself, where it is asked for: it is a multiplier of the
!! whole system.
module taut_model_mechanism_parts
   use taut_kinds, only: wp
   use taut_constrained_system, only: state_t
   use taut_constrained_system_reducible, only: reduction_t
   use taut_model_mechanism_body, only: body_pinned, body_planar, body_point, body_spatial, coordinates_of_kind, turned, &
                                        turned_back, velocities_of_kind
   use taut_rotation, only: cross, matrix_of_quaternion, quaternion_body_rate, quaternion_product
   implicit none (type, external)
   private
   public :: member_t, part_t, parts_t

   !> A body of a part.
   type :: member_t
      !> Its kind, and the indices in the whole system before those of its coordinates and velocities.
      integer :: kind = body_spatial, x = 0, v = 0
      !> Its center from the point of reference, in axes of the part [m]; of what stands still its position [m].
      real(wp) :: d(3) = 0.0_wp
      !> By what its axes are turned against those of the part: as a quaternion, a matrix and, in the plane, an angle [rad].
      real(wp) :: q(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], turn(3, 3) = 0.0_wp, angle = 0.0_wp
   end type member_t

   !> A part of which something follows.
   type :: part_t
      !> What it is in the smaller system; 0: it stands still. Indices there, before those of its coordinates and velocities.
      integer :: kind = body_spatial, x = 0, v = 0
      !> Of what turns about a point of the ground: where that is [m].
      real(wp) :: place(3) = 0.0_wp
      !> Its bodies; the first one is that whose axes it has.
      type(member_t), allocatable :: members(:)
   end type part_t

   !> All of them.
   type, extends(reduction_t) :: parts_t
      type(part_t), allocatable :: parts(:)
      !> Coordinates of the whole system that do not change: turns of joints within a part.
      integer, allocatable :: idle(:)
   contains
      procedure :: narrow
      procedure :: narrow_change
      procedure :: widen
      procedure :: widen_rate
      procedure :: widen_change
   end type parts_t

contains

   !> From the center of the first body of each part to its point of reference, and back to the velocity of that.
   pure subroutine narrow(self, x, v)
      !> The parts.
      class(parts_t), intent(in) :: self
      !> Coordinates of the smaller system, with those of bodies in the place of those of parts: (its n_x).
      real(wp), intent(inout) :: x(:)
      !> Velocities, likewise: (its n).
      real(wp), intent(inout) :: v(:)
      real(wp) :: arm(2), r(3, 3)
      integer :: i

      do i = 1, size(self%parts)
         associate (part => self%parts(i))
            associate (i_x => part%x, i_v => part%v, d => part%members(1)%d)
               select case (part%kind)
               case (body_spatial)
                  r = matrix_of_quaternion(x(i_x + 4:i_x + 7))
                  x(i_x + 1:i_x + 3) = x(i_x + 1:i_x + 3) - turned(r, d)
                  v(i_v + 1:i_v + 3) = v(i_v + 1:i_v + 3) - turned(r, cross(v(i_v + 4:i_v + 6), d))
               case (body_planar)
                  arm = turned_by_angle(x(i_x + 3), d)
                  x(i_x + 1:i_x + 2) = x(i_x + 1:i_x + 2) - arm
                  v(i_v + 1:i_v + 2) = v(i_v + 1:i_v + 2) - v(i_v + 3)*[-arm(2), arm(1)]
               end select
            end associate
         end associate
      end do
   end subroutine narrow

   !> The same of a small change of the state.
   pure subroutine narrow_change(self, small, dx, dv)
      !> The parts.
      class(parts_t), intent(in) :: self
      !> State of the smaller system.
      type(state_t), intent(in) :: small
      !> Changes of its coordinates, with those of bodies in the place of those of parts: (its n_x).
      real(wp), intent(inout) :: dx(:)
      !> Changes of its velocities, likewise: (its n).
      real(wp), intent(inout) :: dv(:)
      real(wp) :: arm(2), change, r(3, 3), theta(3), w(3)
      integer :: i

      do i = 1, size(self%parts)
         associate (part => self%parts(i))
            associate (i_x => part%x, i_v => part%v, d => part%members(1)%d)
               select case (part%kind)
               case (body_spatial)
                  r = matrix_of_quaternion(small%x(i_x + 4:i_x + 7))
                  theta = quaternion_body_rate(small%x(i_x + 4:i_x + 7), dx(i_x + 4:i_x + 7))
                  w = small%v(i_v + 4:i_v + 6)
                  dx(i_x + 1:i_x + 3) = dx(i_x + 1:i_x + 3) - turned(r, cross(theta, d))
                  dv(i_v + 1:i_v + 3) = dv(i_v + 1:i_v + 3) - &
                                        turned(r, cross(theta, cross(w, d)) + cross(dv(i_v + 4:i_v + 6), d))
               case (body_planar)
                  arm = turned_by_angle(small%x(i_x + 3), d)
                  change = dx(i_x + 3)
                  dx(i_x + 1:i_x + 2) = dx(i_x + 1:i_x + 2) - change*[-arm(2), arm(1)]
                  dv(i_v + 1:i_v + 2) = dv(i_v + 1:i_v + 2) - dv(i_v + 3)*[-arm(2), arm(1)] + small%v(i_v + 3)*change*arm
               end select
            end associate
         end associate
      end do
   end subroutine narrow_change

   !> A vector in axes that are turned by an angle.
   pure function turned_by_angle(angle, d) result(r)
      real(wp), intent(in) :: angle, d(3)
      real(wp) :: r(2)
      real(wp) :: c, s

      c = cos(angle)
      s = sin(angle)
      r(1) = c*d(1) - s*d(2)
      r(2) = s*d(1) + c*d(2)
   end function turned_by_angle

   !> Where the bodies are and how they move.
   pure subroutine widen(self, small, x, v)
      !> The parts.
      class(parts_t), intent(in) :: self
      !> State of the smaller system.
      type(state_t), intent(in) :: small
      !> Coordinates: (n_x).
      real(wp), intent(inout) :: x(:)
      !> Velocities: (n).
      real(wp), intent(inout) :: v(:)
      integer :: i

      do i = 1, size(self%parts)
         select case (self%parts(i)%kind)
         case (0)
            call stand_still(self%parts(i), x, v)
         case (body_spatial)
            call widen_spatial(self%parts(i), small, x, v)
         case (body_planar, body_pinned)
            call widen_planar(self%parts(i), small, x, v)
         case default
            call copy_point(self%parts(i), x, v)
         end select
      end do
   end subroutine widen

   !> Bodies that are welded to the ground.
   pure subroutine stand_still(part, x, v)
      type(part_t), intent(in) :: part
      real(wp), intent(inout) :: x(:), v(:)
      integer :: k

      do k = 1, size(part%members)
         associate (it => part%members(k))
            select case (it%kind)
            case (body_spatial)
               x(it%x + 1:it%x + 7) = [it%d, it%q]
               v(it%v + 1:it%v + 6) = 0.0_wp
            case (body_planar)
               x(it%x + 1:it%x + 3) = [it%d(1:2), it%angle]
               v(it%v + 1:it%v + 3) = 0.0_wp
            case (body_point)
               x(it%x + 1:it%x + 3) = it%d
               v(it%v + 1:it%v + 3) = 0.0_wp
            case default
               x(it%x + 1:it%x + 2) = it%d(1:2)
               v(it%v + 1:it%v + 2) = 0.0_wp
            end select
         end associate
      end do
   end subroutine stand_still

   !> What has no rotation: its masses are in one place.
   pure subroutine copy_point(part, x, v)
      type(part_t), intent(in) :: part
      real(wp), intent(inout) :: x(:), v(:)
      integer :: k, n

      n = merge(3, 2, part%kind == body_point)
      associate (first => part%members(1))
         do k = 2, size(part%members)
            associate (it => part%members(k))
               x(it%x + 1:it%x + n) = x(first%x + 1:first%x + n)
               v(it%v + 1:it%v + n) = v(first%v + 1:first%v + n)
            end associate
         end do
      end associate
   end subroutine copy_point

   !> In space.
   pure subroutine widen_spatial(part, small, x, v)
      type(part_t), intent(in) :: part
      type(state_t), intent(in) :: small
      real(wp), intent(inout) :: x(:), v(:)
      real(wp) :: p(3), p_rate(3), q(4), r(3, 3), w(3)
      integer :: k

      p = small%x(part%x + 1:part%x + 3)
      q = small%x(part%x + 4:part%x + 7)
      p_rate = small%v(part%v + 1:part%v + 3)
      w = small%v(part%v + 4:part%v + 6)
      r = matrix_of_quaternion(q)
      do k = 1, size(part%members)
         associate (it => part%members(k))
            x(it%x + 1:it%x + 3) = p + turned(r, it%d)
            v(it%v + 1:it%v + 3) = p_rate + turned(r, cross(w, it%d))
            if (k == 1 .or. it%kind /= body_spatial) cycle
            x(it%x + 4:it%x + 7) = quaternion_product(q, it%q)
            v(it%v + 4:it%v + 6) = turned_back(it%turn, w)
         end associate
      end do
   end subroutine widen_spatial

   !> In the plane.
   pure subroutine widen_planar(part, small, x, v)
      type(part_t), intent(in) :: part
      type(state_t), intent(in) :: small
      real(wp), intent(inout) :: x(:), v(:)
      real(wp) :: angle, c, p(2), p_rate(2), r(2), s, w
      integer :: k

      p = part%place(1:2)
      p_rate = 0.0_wp
      if (part%kind == body_planar) then
         p = small%x(part%x + 1:part%x + 2)
         p_rate = small%v(part%v + 1:part%v + 2)
      end if
      angle = small%x(part%x + merge(3, 1, part%kind == body_planar))
      w = small%v(part%v + merge(3, 1, part%kind == body_planar))
      c = cos(angle)
      s = sin(angle)
      do k = 1, size(part%members)
         associate (it => part%members(k))
            r(1) = c*it%d(1) - s*it%d(2)
            r(2) = s*it%d(1) + c*it%d(2)
            x(it%x + 1) = p(1) + r(1)
            x(it%x + 2) = p(2) + r(2)
            v(it%v + 1) = p_rate(1) - w*r(2)
            v(it%v + 2) = p_rate(2) + w*r(1)
            if (k == 1 .or. it%kind /= body_planar) cycle
            x(it%x + 3) = angle + it%angle
            v(it%v + 3) = w
         end associate
      end do
   end subroutine widen_planar

   !> Their velocities and accelerations.
   pure subroutine widen_rate(self, small, xdot, vdot)
      !> The parts.
      class(parts_t), intent(in) :: self
      !> State of the smaller system.
      type(state_t), intent(in) :: small
      !> Rates of the coordinates, those of parts in place: (n_x).
      real(wp), intent(inout) :: xdot(:)
      !> Accelerations, likewise: (n).
      real(wp), intent(inout) :: vdot(:)
      integer :: i, k

      do i = 1, size(self%parts)
         select case (self%parts(i)%kind)
         case (0)
            call let_rest(self%parts(i), xdot, vdot)
         case (body_spatial)
            call widen_spatial_rate(self%parts(i), small, xdot, vdot)
         case (body_planar, body_pinned)
            call widen_planar_rate(self%parts(i), small, xdot, vdot)
         case default
            call copy_point(self%parts(i), xdot, vdot)
         end select
      end do
      do k = 1, size(self%idle)
         xdot(self%idle(k)) = 0.0_wp
      end do
   end subroutine widen_rate

   !> Nothing of bodies that are welded to the ground changes.
   pure subroutine let_rest(part, dx, dv)
      type(part_t), intent(in) :: part
      real(wp), intent(inout) :: dx(:), dv(:)
      integer :: k

      do k = 1, size(part%members)
         associate (it => part%members(k))
            dx(it%x + 1:it%x + coordinates_of_kind(it%kind)) = 0.0_wp
            dv(it%v + 1:it%v + velocities_of_kind(it%kind)) = 0.0_wp
         end associate
      end do
   end subroutine let_rest

   !> In space.
   pure subroutine widen_spatial_rate(part, small, xdot, vdot)
      type(part_t), intent(in) :: part
      type(state_t), intent(in) :: small
      real(wp), intent(inout) :: xdot(:), vdot(:)
      real(wp) :: acceleration(3), arm(3), q_rate(4), r(3, 3), velocity(3), w(3), w_rate(3)
      integer :: k

      associate (first => part%members(1))
         velocity = xdot(first%x + 1:first%x + 3)
         q_rate = xdot(first%x + 4:first%x + 7)
         acceleration = vdot(first%v + 1:first%v + 3)
         w_rate = vdot(first%v + 4:first%v + 6)
      end associate
      w = small%v(part%v + 4:part%v + 6)
      r = matrix_of_quaternion(small%x(part%x + 4:part%x + 7))
      do k = 1, size(part%members)
         associate (it => part%members(k))
            arm = cross(w, it%d)
            xdot(it%x + 1:it%x + 3) = velocity + turned(r, arm)
            vdot(it%v + 1:it%v + 3) = acceleration + turned(r, cross(w_rate, it%d) + cross(w, arm))
            if (k == 1 .or. it%kind /= body_spatial) cycle
            xdot(it%x + 4:it%x + 7) = quaternion_product(q_rate, it%q)
            vdot(it%v + 4:it%v + 6) = turned_back(it%turn, w_rate)
         end associate
      end do
   end subroutine widen_spatial_rate

   !> In the plane.
   pure subroutine widen_planar_rate(part, small, xdot, vdot)
      type(part_t), intent(in) :: part
      type(state_t), intent(in) :: small
      real(wp), intent(inout) :: xdot(:), vdot(:)
      real(wp) :: acceleration(2), angle, c, r(2), s, velocity(2), w, w_rate
      integer :: k

      associate (first => part%members(1))
         velocity = 0.0_wp
         acceleration = 0.0_wp
         if (part%kind == body_planar) then
            velocity = xdot(first%x + 1:first%x + 2)
            acceleration = vdot(first%v + 1:first%v + 2)
         end if
         w_rate = vdot(first%v + 3)
      end associate
      angle = small%x(part%x + merge(3, 1, part%kind == body_planar))
      w = small%v(part%v + merge(3, 1, part%kind == body_planar))
      c = cos(angle)
      s = sin(angle)
      do k = 1, size(part%members)
         associate (it => part%members(k))
            r(1) = c*it%d(1) - s*it%d(2)
            r(2) = s*it%d(1) + c*it%d(2)
            xdot(it%x + 1) = velocity(1) - w*r(2)
            xdot(it%x + 2) = velocity(2) + w*r(1)
            vdot(it%v + 1) = acceleration(1) - w_rate*r(2) - w*w*r(1)
            vdot(it%v + 2) = acceleration(2) + w_rate*r(1) - w*w*r(2)
            if (k == 1 .or. it%kind /= body_planar) cycle
            xdot(it%x + 3) = w
            vdot(it%v + 3) = w_rate
         end associate
      end do
   end subroutine widen_planar_rate

   !> Changes of both.
   pure subroutine widen_change(self, small, dx, dv)
      !> The parts.
      class(parts_t), intent(in) :: self
      !> State of the smaller system.
      type(state_t), intent(in) :: small
      !> Changes of the coordinates, those of parts in place: (n_x).
      real(wp), intent(inout) :: dx(:)
      !> Changes of the velocities, likewise: (n).
      real(wp), intent(inout) :: dv(:)
      integer :: i, k

      do i = 1, size(self%parts)
         select case (self%parts(i)%kind)
         case (0)
            call let_rest(self%parts(i), dx, dv)
         case (body_spatial)
            call widen_spatial_change(self%parts(i), small, dx, dv)
         case (body_planar, body_pinned)
            call widen_planar_change(self%parts(i), small, dx, dv)
         case default
            call copy_point(self%parts(i), dx, dv)
         end select
      end do
      do k = 1, size(self%idle)
         dx(self%idle(k)) = 0.0_wp
      end do
   end subroutine widen_change

   !> In space.
   pure subroutine widen_spatial_change(part, small, dx, dv)
      type(part_t), intent(in) :: part
      type(state_t), intent(in) :: small
      real(wp), intent(inout) :: dx(:), dv(:)
      real(wp) :: dp(3), dp_rate(3), dq(4), dw(3), r(3, 3), theta(3), w(3)
      integer :: k

      associate (first => part%members(1))
         dp = dx(first%x + 1:first%x + 3)
         dq = dx(first%x + 4:first%x + 7)
         dp_rate = dv(first%v + 1:first%v + 3)
         dw = dv(first%v + 4:first%v + 6)
      end associate
      w = small%v(part%v + 4:part%v + 6)
      r = matrix_of_quaternion(small%x(part%x + 4:part%x + 7))
      theta = quaternion_body_rate(small%x(part%x + 4:part%x + 7), dq)
      do k = 1, size(part%members)
         associate (it => part%members(k))
            dx(it%x + 1:it%x + 3) = dp + turned(r, cross(theta, it%d))
            dv(it%v + 1:it%v + 3) = dp_rate + turned(r, cross(theta, cross(w, it%d)) + cross(dw, it%d))
            if (k == 1 .or. it%kind /= body_spatial) cycle
            dx(it%x + 4:it%x + 7) = quaternion_product(dq, it%q)
            dv(it%v + 4:it%v + 6) = turned_back(it%turn, dw)
         end associate
      end do
   end subroutine widen_spatial_change

   !> In the plane.
   pure subroutine widen_planar_change(part, small, dx, dv)
      type(part_t), intent(in) :: part
      type(state_t), intent(in) :: small
      real(wp), intent(inout) :: dx(:), dv(:)
      real(wp) :: angle, c, change, dp(2), dp_rate(2), dw, r(2), s, w
      integer :: k

      associate (first => part%members(1))
         dp = 0.0_wp
         dp_rate = 0.0_wp
         if (part%kind == body_planar) then
            dp = dx(first%x + 1:first%x + 2)
            dp_rate = dv(first%v + 1:first%v + 2)
         end if
         change = dx(first%x + 3)
         dw = dv(first%v + 3)
      end associate
      angle = small%x(part%x + merge(3, 1, part%kind == body_planar))
      w = small%v(part%v + merge(3, 1, part%kind == body_planar))
      c = cos(angle)
      s = sin(angle)
      do k = 1, size(part%members)
         associate (it => part%members(k))
            r(1) = c*it%d(1) - s*it%d(2)
            r(2) = s*it%d(1) + c*it%d(2)
            dx(it%x + 1) = dp(1) - change*r(2)
            dx(it%x + 2) = dp(2) + change*r(1)
            dv(it%v + 1) = dp_rate(1) - dw*r(2) - w*change*r(1)
            dv(it%v + 2) = dp_rate(2) + dw*r(1) - w*change*r(2)
            if (k == 1 .or. it%kind /= body_planar) cycle
            dx(it%x + 3) = change
            dv(it%v + 3) = dw
         end associate
      end do
   end subroutine widen_planar_change

end module taut_model_mechanism_parts
