!> The few kinds of constraint that all joints are made of, each one row: phi, its part of A, b' and b''.
!!
!! Body 1 comes first and may be the ground; u_1 = R_1 a and u_2 = R_2 b are directions fixed in the bodies, P_1 and P_2 points
!! fixed in them, D = P_2 - P_1, g(t) a given function (0 if there is none).
!!
!!     point       e.D - length - g                          a component of D in global axes                      [m]
!!     offset      u_1.D - length - g                        a component of D in the axes of body 1               [m]
!!     dot         u_1.u_2                                   two directions are normal to each other              [-]
!!     angle       sin(theta - g)                            theta turns `side` (body 1) towards a to reach u_2   [-]
!!     distance    |D| - length - g                                                                               [m]
!!     contact     n.(P_2 - P_1) - r sqrt(1 - (n.u_2)^2)     a disc of radius r, axis u_2, touches a plane        [m]
!!     rolling     e.(velocity of the disc's lowest point)   non-holonomic, e in the plane                        [m/s]
!!     knife       u_2.(velocity of P_2)                     non-holonomic                                        [m/s]
!!
!! `angle` has one more solution half a turn away, and nowhere a singularity: a turn has no beginning. `dot` likewise is met by
!! the opposite direction too. Which of the two is meant, `row_cosine` tells: it is 1 there and -1 on the other branch.
module taut_model_mechanism_row
   use taut_kinds, only: wp
   use taut_model_mechanism_body, only: pose_t
   implicit none (type, external)
   private
   public :: row_t, row_value, row_entries, row_b_prime, row_b_second, row_cosine, meant_direction
   public :: row_point, row_offset, row_dot, row_angle, row_distance, row_contact, row_rolling, row_knife

   integer, parameter :: row_point = 1, row_offset = 2, row_dot = 3, row_angle = 4, row_distance = 5, row_contact = 6, &
                         row_rolling = 7, row_knife = 8

   !> A row.
   type :: row_t
      !> One of the `row_` constants.
      integer :: kind = row_point
      !> Index of the function g; 0: none.
      integer :: drive = 0
      !> Direction in body 1 (`point`: in global axes; `contact`, `rolling`: the plane's normal), direction in body 2.
      real(wp) :: a(3) = 0.0_wp, b(3) = 0.0_wp
      !> `angle`: the direction in body 1 from which theta counts; `dot`: the one that u_2 is meant to have; `rolling`: e.
      real(wp) :: side(3) = 0.0_wp
      !> Whether the opposite direction of u_2 meets it too, and is not meant.
      logical :: has_branches = .false.
      !> Points in body axes [m].
      real(wp) :: p_1(3) = 0.0_wp, p_2(3) = 0.0_wp
      !> Length or radius [m].
      real(wp) :: length = 0.0_wp
      !> `point`, `distance`: whether all of it is in the plane x-y.
      logical :: planar = .false.
      !> `point`: whether the row before it is another component of the same D.
      logical :: continues = .false.
   end type row_t

contains

   ! Products of vectors are in this file, where the compiler unfolds them: else Andrews' mechanism takes 6 % more.

   !> R u.
   pure function turned(r, u) result(v)
      !> Rotation.
      real(wp), intent(in) :: r(3, 3)
      !> Vector.
      real(wp), intent(in) :: u(3)
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
      real(wp) :: v(3)

      v(1) = r(1, 1)*u(1) + r(2, 1)*u(2) + r(3, 1)*u(3)
      v(2) = r(1, 2)*u(1) + r(2, 2)*u(2) + r(3, 2)*u(3)
      v(3) = r(1, 3)*u(1) + r(2, 3)*u(2) + r(3, 3)*u(3)
   end function turned_back

   !> a x b.
   pure function cross(a, b) result(c)
      !> The first vector.
      real(wp), intent(in) :: a(3)
      !> The second vector.
      real(wp), intent(in) :: b(3)
      real(wp) :: c(3)

      c(1) = a(2)*b(3) - a(3)*b(2)
      c(2) = a(3)*b(1) - a(1)*b(3)
      c(3) = a(1)*b(2) - a(2)*b(1)
   end function cross

   !> a.b.
   pure function dot(a, b) result(c)
      real(wp), intent(in) :: a(3), b(3)
      real(wp) :: c

      c = a(1)*b(1) + a(2)*b(2) + a(3)*b(3)
   end function dot

   !> A point of a body.
   pure function place(it, p) result(x)
      type(pose_t), intent(in) :: it
      real(wp), intent(in) :: p(3)
      real(wp) :: x(3)

      x = it%p + turned(it%r, p)
   end function place

   !> Velocity of a point of a body.
   pure function speed(it, p) result(v)
      type(pose_t), intent(in) :: it
      real(wp), intent(in) :: p(3)
      real(wp) :: v(3)

      v = it%v + turned(it%r, cross(it%w, p))
   end function speed

   !> R W x (W x p): acceleration of a point, or second derivative of a direction, while the velocities stay as they are.
   pure function centripetal(it, p) result(c)
      type(pose_t), intent(in) :: it
      real(wp), intent(in) :: p(3)
      real(wp) :: c(3)

      c = turned(it%r, cross(it%w, cross(it%w, p)))
   end function centripetal

   !> In the plane: from the center of a body to a point of it.
   pure function arm(it, p) result(r)
      type(pose_t), intent(in) :: it
      real(wp), intent(in) :: p(3)
      real(wp) :: r(2)

      r(1) = it%r(1, 1)*p(1) + it%r(1, 2)*p(2)
      r(2) = it%r(2, 1)*p(1) + it%r(2, 2)*p(2)
   end function arm

   !> D.
   pure function point_shift(row, one, two) result(d)
      !> The row, one that has two points.
      type(row_t), intent(in) :: row
      !> Pose of body 1.
      type(pose_t), intent(in) :: one
      !> Pose of body 2.
      type(pose_t), intent(in) :: two
      !> From point 1 to point 2, in global axes [m].
      real(wp) :: d(3)

      if (row%planar) then
         d(1:2) = arm(two, row%p_2) - arm(one, row%p_1)
         d(1) = d(1) + (two%p(1) - one%p(1))
         d(2) = d(2) + (two%p(2) - one%p(2))
         d(3) = 0.0_wp
      else
         d = place(two, row%p_2) - place(one, row%p_1)
      end if
   end function point_shift

   !> The second derivative of D while the velocities stay as they are.
   pure function point_centripetal(row, one, two) result(c)
      !> The row, one that has two points.
      type(row_t), intent(in) :: row
      !> Pose of body 1.
      type(pose_t), intent(in) :: one
      !> Pose of body 2.
      type(pose_t), intent(in) :: two
      !> In global axes [m/s^2].
      real(wp) :: c(3)

      if (row%planar) then
         c(1:2) = one%w(3)**2*arm(one, row%p_1) - two%w(3)**2*arm(two, row%p_2)
         c(3) = 0.0_wp
      else
         c = centripetal(two, row%p_2) - centripetal(one, row%p_1)
      end if
   end function point_centripetal

   !> The row of A of a row in the plane.
   pure subroutine planar_entries(row, one, two, e_1, e_2)
      type(row_t), intent(in) :: row
      type(pose_t), intent(in) :: one, two
      real(wp), intent(out) :: e_1(6), e_2(6)
      real(wp) :: d(3), r_1(2), r_2(2), s, u(2)

      r_1 = arm(one, row%p_1)
      r_2 = arm(two, row%p_2)
      if (row%kind == row_point) then
         u(1) = row%a(1)
         u(2) = row%a(2)
      else
         d = point_shift(row, one, two)
         s = sqrt(dot(d, d))
         u = d(1:2)
         if (s > 0.0_wp) u = u/s
      end if
      e_1(1) = -u(1)
      e_1(2) = -u(2)
      e_1(3:5) = 0.0_wp
      e_1(6) = r_1(2)*u(1) - r_1(1)*u(2)
      e_2(1) = u(1)
      e_2(2) = u(2)
      e_2(3:5) = 0.0_wp
      e_2(6) = r_2(1)*u(2) - r_2(2)*u(1)
   end subroutine planar_entries

   !> phi of a holonomic row.
   pure subroutine row_value(row, one, two, g, d, phi)
      !> The row.
      type(row_t), intent(in) :: row
      !> Pose of body 1.
      type(pose_t), intent(in) :: one
      !> Pose of body 2.
      type(pose_t), intent(in) :: two
      !> {g, gdot, gddot}.
      real(wp), intent(in) :: g(3)
      !> D as the row before has left it [m].
      real(wp), intent(inout) :: d(3)
      !> phi [m] or [-].
      real(wp), intent(out) :: phi
      real(wp) :: s

      select case (row%kind)
      case (row_point)
         if (.not. row%continues) d = point_shift(row, one, two)
         phi = dot(row%a, d) - row%length - g(1)
      case (row_offset)
         d = place(two, row%p_2) - place(one, row%p_1)
         phi = dot(turned(one%r, row%a), d) - row%length - g(1)
      case (row_dot)
         phi = dot(turned(one%r, row%a), turned(two%r, row%b))
      case (row_angle)
         phi = dot(turned(one%r, cos(g(1))*row%a - sin(g(1))*row%side), turned(two%r, row%b))
      case (row_distance)
         d = point_shift(row, one, two)
         phi = sqrt(dot(d, d)) - row%length - g(1)
      case (row_contact)
         d = place(two, row%p_2)
         s = dot(row%a, turned(two%r, row%b))
         phi = dot(row%a, d - row%p_1) - row%length*sqrt(max(0.0_wp, 1.0_wp - s*s))
      case default
         phi = 0.0_wp
      end select
   end subroutine row_value

   !> The row of A: entries of the velocities in {global, body} axes.
   pure subroutine row_entries(row, one, two, g, e_1, e_2)
      !> The row.
      type(row_t), intent(in) :: row
      !> Pose of body 1.
      type(pose_t), intent(in) :: one
      !> Pose of body 2.
      type(pose_t), intent(in) :: two
      !> {g, gdot, gddot}.
      real(wp), intent(in) :: g(3)
      !> Entries of body 1.
      real(wp), intent(out) :: e_1(6)
      !> Entries of body 2.
      real(wp), intent(out) :: e_2(6)
      real(wp) :: a(3), d(3), s, u(3)

      if (row%planar) then
         call planar_entries(row, one, two, e_1, e_2)
         return
      end if
      select case (row%kind)
      case (row_point, row_distance)
         u = row%a
         if (row%kind == row_distance) then
            u = place(two, row%p_2) - place(one, row%p_1)
            s = sqrt(dot(u, u))
            if (s > 0.0_wp) u = u/s
         end if
         e_1(1:3) = -u
         e_1(4:6) = -cross(row%p_1, turned_back(one%r, u))
         e_2(1:3) = u
         e_2(4:6) = cross(row%p_2, turned_back(two%r, u))
      case (row_offset)
         u = turned(one%r, row%a)
         d = place(two, row%p_2) - one%p
         e_1(1:3) = -u
         e_1(4:6) = cross(row%a, turned_back(one%r, d))
         e_2(1:3) = u
         e_2(4:6) = cross(row%p_2, turned_back(two%r, u))
      case (row_dot, row_angle)
         a = row%a
         if (row%kind == row_angle) a = cos(g(1))*row%a - sin(g(1))*row%side
         e_1(1:3) = 0.0_wp
         e_1(4:6) = cross(a, turned_back(one%r, turned(two%r, row%b)))
         e_2(1:3) = 0.0_wp
         e_2(4:6) = cross(row%b, turned_back(two%r, turned(one%r, a)))
      case (row_contact)
         ! The velocity of n.u is w.(u x n).
         s = dot(row%a, turned(two%r, row%b))
         u = turned_back(two%r, row%a)
         e_1(:) = 0.0_wp
         e_2(1:3) = row%a
         e_2(4:6) = cross(row%p_2, u) + row%length*s/sqrt(max(tiny(1.0_wp), 1.0_wp - s*s))*cross(row%b, u)
      case (row_rolling)
         call lowest(row, two, d)
         e_1(:) = 0.0_wp
         e_2(1:3) = row%side
         e_2(4:6) = cross(row%p_2 - row%length*turned_back(two%r, d), turned_back(two%r, row%side))
      case default
         e_1(:) = 0.0_wp
         e_2(1:3) = turned(two%r, row%b)
         e_2(4:6) = cross(row%p_2, row%b)
      end select
   end subroutine row_entries

   !> The unit vector in a disc's plane that points up most, and its rate.
   pure subroutine lowest(row, two, up, up_rate)
      type(row_t), intent(in) :: row
      type(pose_t), intent(in) :: two
      real(wp), intent(out) :: up(3)
      real(wp), intent(out), optional :: up_rate(3)
      real(wp) :: k, s, s_rate, u(3), u_rate(3)

      u = turned(two%r, row%b)
      s = dot(row%a, u)
      k = sqrt(max(tiny(1.0_wp), 1.0_wp - s*s))
      up = (row%a - s*u)/k
      if (.not. present(up_rate)) return
      u_rate = turned(two%r, cross(two%w, row%b))
      s_rate = dot(row%a, u_rate)
      up_rate = (up*(s*s_rate/k) - s_rate*u - s*u_rate)/k
   end subroutine lowest

   !> The cosine between u_2 and the direction that it is meant to have where the row is met.
   pure function row_cosine(row, one, two, g) result(c)
      !> The row, one that has branches.
      type(row_t), intent(in) :: row
      !> Pose of body 1.
      type(pose_t), intent(in) :: one
      !> Pose of body 2.
      type(pose_t), intent(in) :: two
      !> {g, gdot, gddot}.
      real(wp), intent(in) :: g(3)
      !> Positive on the branch that is meant.
      real(wp) :: c

      c = dot(turned(one%r, meant_direction(row, g)), turned(two%r, row%b))
   end function row_cosine

   !> The direction in body 1 that u_2 is meant to have.
   pure function meant_direction(row, g) result(u)
      !> The row, one that has branches.
      type(row_t), intent(in) :: row
      !> {g, gdot, gddot}.
      real(wp), intent(in) :: g(3)
      !> A unit vector in the axes of body 1.
      real(wp) :: u(3)

      u = row%side
      if (row%kind == row_angle) u = cos(g(1))*row%side + sin(g(1))*row%a
   end function meant_direction

   !> b': minus the partial derivative of phi in time.
   pure function row_b_prime(row, one, two, g) result(b)
      !> The row.
      type(row_t), intent(in) :: row
      !> Pose of body 1.
      type(pose_t), intent(in) :: one
      !> Pose of body 2.
      type(pose_t), intent(in) :: two
      !> {g, gdot, gddot}.
      real(wp), intent(in) :: g(3)
      !> b' [m/s] or [1/s].
      real(wp) :: b

      b = g(2)
      if (row%kind == row_angle) &
         b = g(2)*dot(turned(one%r, sin(g(1))*row%a + cos(g(1))*row%side), turned(two%r, row%b))
   end function row_b_prime

   !> b'': minus the second derivative of phi while the velocities stay as they are.
   pure subroutine row_b_second(row, one, two, g, c, b)
      !> The row.
      type(row_t), intent(in) :: row
      !> Pose of body 1.
      type(pose_t), intent(in) :: one
      !> Pose of body 2.
      type(pose_t), intent(in) :: two
      !> {g, gdot, gddot}.
      real(wp), intent(in) :: g(3)
      !> The second derivative of D while the velocities stay as they are, as the row before has left it [m/s^2].
      real(wp), intent(inout) :: c(3)
      !> b'' [m/s^2] or [1/s^2].
      real(wp), intent(out) :: b
      real(wp) :: a(3), a_rate(3), a_second(3), along, d(3), distance, k, rate(3), s, u(3), w(3)

      select case (row%kind)
      case (row_point)
         if (.not. row%continues) c = point_centripetal(row, one, two)
         b = g(3) - dot(row%a, c)
      case (row_offset)
         d = place(two, row%p_2) - place(one, row%p_1)
         rate = speed(two, row%p_2) - speed(one, row%p_1)
         c = centripetal(two, row%p_2) - centripetal(one, row%p_1)
         b = g(3) - dot(centripetal(one, row%a), d) - 2.0_wp*dot(turned(one%r, cross(one%w, row%a)), rate) &
             - dot(turned(one%r, row%a), c)
      case (row_dot)
         b = -dot(centripetal(one, row%a), turned(two%r, row%b)) - dot(turned(one%r, row%a), centripetal(two, row%b)) &
             - 2.0_wp*dot(turned(one%r, cross(one%w, row%a)), turned(two%r, cross(two%w, row%b)))
      case (row_angle)
         ! As `dot`, with a direction a(t) that turns in body 1.
         a = cos(g(1))*row%a - sin(g(1))*row%side
         u = -sin(g(1))*row%a - cos(g(1))*row%side
         a_rate = g(2)*u + cross(one%w, a)
         a_second = g(3)*u - g(2)**2*a + 2.0_wp*g(2)*cross(one%w, u) + cross(one%w, cross(one%w, a))
         b = -dot(turned(one%r, a_second), turned(two%r, row%b)) - dot(turned(one%r, a), centripetal(two, row%b)) &
             - 2.0_wp*dot(turned(one%r, a_rate), turned(two%r, cross(two%w, row%b)))
      case (row_distance)
         d = point_shift(row, one, two)
         rate = speed(two, row%p_2) - speed(one, row%p_1)
         c = point_centripetal(row, one, two)
         distance = sqrt(dot(d, d))
         b = g(3)
         if (distance > 0.0_wp) then
            d = d/distance
            along = dot(d, rate)
            b = g(3) - dot(d, c) - (dot(rate, rate) - along**2)/distance
         end if
      case (row_contact)
         u = turned(two%r, row%b)
         s = dot(row%a, u)
         along = dot(row%a, turned(two%r, cross(two%w, row%b)))
         k = sqrt(max(tiny(1.0_wp), 1.0_wp - s*s))
         b = -dot(row%a, centripetal(two, row%p_2)) &
             - row%length*(along**2/k**3 + s*dot(row%a, centripetal(two, row%b))/k)
      case (row_rolling)
         call lowest(row, two, u, rate)
         w = turned(two%r, two%w)
         b = dot(row%side, row%length*cross(w, rate) - centripetal(two, row%p_2))
      case default
         b = -dot(turned(two%r, cross(two%w, row%b)), speed(two, row%p_2)) - &
             dot(turned(two%r, row%b), centripetal(two, row%p_2))
      end select
   end subroutine row_b_second

end module taut_model_mechanism_row
