!> Bodies of a mechanism: rigid bodies and point masses, in space or in the plane x-y.
!!
!! Coordinates and velocities of a body in space are {center of mass (3), unit quaternion (4)} and {velocity in global axes (3),
!! angular velocity in BODY axes (3)}; in the plane {x, y, angle} and {vx, vy, w}; of a point mass its position and velocity;
!! of a body that turns about a point of the ground in the plane its angle and w, with that point in the place of its
!! center of mass.
!! Joints and loads see all of them through `pose_t` and through the six entries of a force in {global, body} axes, of which
!! each kind of body has some.
module taut_model_mechanism_body
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_model_pose, only: move_pose, normalize_pose, pose_rate, pose_velocity, turned, turned_back
   use taut_rotation, only: cross, matrix_of_quaternion
   implicit none (type, external)
   private
   public :: body_t, pose_t, ground_pose, point_motion
   public :: turned, turned_back
   public :: body_spatial, body_planar, body_point, body_planar_point, body_pinned
   public :: coordinates_of_kind, velocities_of_kind, entry_of_velocity

   integer, parameter :: body_spatial = 1, body_planar = 2, body_point = 3, body_planar_point = 4, body_pinned = 5
   !> Numbers of coordinates and velocities of each kind.
   integer, parameter :: coordinates_of_kind(5) = [7, 3, 3, 2, 1], velocities_of_kind(5) = [6, 3, 3, 2, 1]
   !> Which of the six entries belongs to a velocity, by kind: (6, kind).
   integer, parameter :: entry_of_velocity(6, 5) = reshape([1, 2, 3, 4, 5, 6, 1, 2, 6, 0, 0, 0, 1, 2, 3, 0, 0, 0, &
                                                            1, 2, 0, 0, 0, 0, 6, 0, 0, 0, 0, 0], [6, 5])

   !> A body.
   type :: body_t
      !> What it is called.
      character(:), allocatable :: name
      !> One of the `body_` constants.
      integer :: kind = body_spatial
      !> Mass [kg].
      real(wp) :: m = 0.0_wp
      !> Moments of inertia about the center of mass, in body axes: (3, 3) [kg m^2].
      real(wp) :: j(3, 3) = 0.0_wp
      !> `body_pinned`: the center of mass in body axes, from the point about which it turns [m]; `j` is about that point, and it
      !! is `position`.
      real(wp) :: center(3) = 0.0_wp
      !> Where its coordinates and velocities are: index before the first.
      integer :: before_x = 0, before_v = 0
      !> At the start: center of mass [m], unit quaternion, velocity [m/s], angular velocity in body axes [rad/s].
      real(wp) :: position(3) = 0.0_wp, orientation(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      real(wp) :: velocity(3) = 0.0_wp, spin(3) = 0.0_wp
      !> What it looks like, for pictures: `rod`, `box`, `sphere`, `cylinder`, or nothing; its sides along body axes, of a cylinder
      !! two diameters and its length [m]; the body axis along which a rod or a cylinder lies.
      character(len=8) :: shape = ''
      real(wp) :: size(3) = 0.0_wp
      integer :: axis = 1
   contains
      procedure :: check
      procedure :: pin
      procedure :: start
      procedure :: pose
      procedure :: diagonal
      procedure :: inertial_force
      procedure :: add_force
      procedure :: add_moment
      procedure :: kinetic_energy
      procedure :: rate
      procedure :: velocity_of_rate
      procedure :: move
      procedure :: normalize
   end type body_t

   !> Where a body is and how it moves.
   type :: pose_t
      !> Center of mass (of a pinned body the point about which it turns) [m], and rotation from body to global axes.
      real(wp) :: p(3), r(3, 3)
      !> Its velocity [m/s], and angular velocity in body axes [rad/s].
      real(wp) :: v(3), w(3)
   end type pose_t

contains

   !> The ground: at rest at the origin, its axes are the global ones.
   pure subroutine ground_pose(it)
      !> Its pose.
      type(pose_t), intent(out) :: it
      integer :: i

      it%p = 0.0_wp
      it%v = 0.0_wp
      it%w = 0.0_wp
      it%r = 0.0_wp
      do i = 1, 3
         it%r(i, i) = 1.0_wp
      end do
   end subroutine ground_pose

   !> A point of a body: where it is and how fast.
   pure subroutine point_motion(it, p, x, v)
      !> Pose of the body; the point in its axes [m].
      type(pose_t), intent(in) :: it
      !> The point, in body axes [m].
      real(wp), intent(in) :: p(3)
      !> Position in global axes [m].
      real(wp), intent(out) :: x(3)
      !> Velocity in global axes [m/s].
      real(wp), intent(out) :: v(3)
      real(wp) :: arm(3)
      integer :: i

      x = turned(it%r, p)
      arm = cross(it%w, p)
      v = turned(it%r, arm)
      do i = 1, 3
         x(i) = x(i) + it%p(i)
         v(i) = v(i) + it%v(i)
      end do
   end subroutine point_motion

   !> Whether mass and inertia can be those of a body.
   subroutine check(self, error)
      !> The body.
      class(body_t), intent(in) :: self
      !> What they break.
      type(error_t), allocatable, intent(inout) :: error
      character(:), allocatable :: here
      real(wp) :: minor(3), slack, trace
      integer :: i

      here = 'body "'//self%name//'"'
      if (.not. (self%m > 0.0_wp .and. self%m <= huge(1.0_wp))) &
         call raise(error, here, 'its mass is '//to_text(self%m)//' kg', 'give a positive mass in kg')
      if (.not. (all(abs(self%position) <= huge(1.0_wp)) .and. all(abs(self%velocity) <= huge(1.0_wp)) .and. &
                 all(abs(self%spin) <= huge(1.0_wp)) .and. all(abs(self%orientation) <= huge(1.0_wp)))) &
         call raise(error, here, 'its position or its velocity is not a number', 'correct it')
      if (allocated(error)) return
      select case (self%kind)
      case (body_planar)
         if (.not. (self%j(3, 3) > 0.0_wp .and. self%j(3, 3) <= huge(1.0_wp))) &
            call raise(error, here, 'its moment of inertia is '//to_text(self%j(3, 3))//' kg m^2', &
                       'give a positive one about z, or use &point_mass')
      case (body_spatial)
         if (.not. all(abs(self%j) <= huge(1.0_wp))) then
            call raise(error, here, 'its inertia is not a number', 'correct it')
            return
         end if
         associate (j => self%j)
            minor = [j(2, 2)*j(3, 3) - j(2, 3)**2, j(1, 1)*j(3, 3) - j(1, 3)**2, j(1, 1)*j(2, 2) - j(1, 2)**2]
            trace = j(1, 1) + j(2, 2) + j(3, 3)
            if (any([(j(i, i) <= 0.0_wp, i=1, 3)]) .or. any(minor <= 0.0_wp) .or. determinant(j) <= 0.0_wp) then
               call raise(error, here, 'its inertia is not positive definite', &
                          'give three positive moments about the center of mass in kg m^2 (or use &point_mass)')
               return
            end if
            ! No principal moment exceeds the sum of the other two: tr(J)/2 I - J, the second moments of mass, has no negative
            ! eigenvalue.
            slack = 1.0e-9_wp*trace
            if (.not. positive_semidefinite(0.5_wp*trace, j, slack)) &
               call raise(error, here, 'its inertia breaks the triangle inequality: one principal moment exceeds the sum of '// &
                          'the other two', 'no body has such moments; correct them')
         end associate
      end select
   end subroutine check

   !> |J|.
   pure function determinant(j) result(value)
      real(wp), intent(in) :: j(3, 3)
      real(wp) :: value

      value = dot_product(j(:, 1), cross(j(:, 2), j(:, 3)))
   end function determinant

   !> Whether half I - J + slack I has no negative eigenvalue: all principal minors.
   pure function positive_semidefinite(half, j, slack) result(answer)
      real(wp), intent(in) :: half, j(3, 3), slack
      logical :: answer
      real(wp) :: p(3, 3)
      integer :: i, k

      p = -j
      do i = 1, 3
         p(i, i) = p(i, i) + half + slack
      end do
      answer = determinant(p) >= 0.0_wp
      do i = 1, 3
         k = 1 + mod(i, 3)
         answer = answer .and. p(i, i) >= 0.0_wp .and. p(i, i)*p(k, k) - p(i, k)**2 >= 0.0_wp
      end do
   end function positive_semidefinite

   !> Lets a body in the plane turn about a point.
   pure subroutine pin(self, point, place)
      !> The body; points in its axes are counted from that point on.
      class(body_t), intent(inout) :: self
      !> The point, in body axes [m].
      real(wp), intent(in) :: point(3)
      !> Where it is [m].
      real(wp), intent(in) :: place(3)

      self%kind = body_pinned
      self%center = -point
      self%position = place
      self%velocity = 0.0_wp
      self%j(3, 3) = self%j(3, 3) + self%m*(point(1)**2 + point(2)**2)
   end subroutine pin

   !> Puts its start into a state.
   pure subroutine start(self, x, v)
      !> The body.
      class(body_t), intent(in) :: self
      !> All coordinates.
      real(wp), intent(inout) :: x(:)
      !> All velocities.
      real(wp), intent(inout) :: v(:)
      integer :: i

      associate (i_x => self%before_x, i_v => self%before_v)
         select case (self%kind)
         case (body_spatial)
            x(i_x + 1:i_x + 7) = [self%position, self%orientation]
         case (body_planar)
            x(i_x + 1:i_x + 3) = [self%position(1:2), 2.0_wp*atan2(self%orientation(4), self%orientation(1))]
         case (body_pinned)
            x(i_x + 1) = 2.0_wp*atan2(self%orientation(4), self%orientation(1))
         case (body_point)
            x(i_x + 1:i_x + 3) = self%position
         case default
            x(i_x + 1:i_x + 2) = self%position(1:2)
         end select
         do i = 1, velocities_of_kind(self%kind)
            if (entry_of_velocity(i, self%kind) <= 3) then
               v(i_v + i) = self%velocity(entry_of_velocity(i, self%kind))
            else
               v(i_v + i) = self%spin(entry_of_velocity(i, self%kind) - 3)
            end if
         end do
      end associate
   end subroutine start

   !> Where it is and how it moves.
   pure subroutine pose(self, x, v, it)
      !> The body.
      class(body_t), intent(in) :: self
      !> All coordinates.
      real(wp), intent(in) :: x(:)
      !> All velocities.
      real(wp), intent(in) :: v(:)
      !> The pose.
      type(pose_t), intent(out) :: it
      integer :: i

      associate (i_x => self%before_x, i_v => self%before_v)
         select case (self%kind)
         case (body_spatial)
            do i = 1, 3
               it%p(i) = x(i_x + i)
               it%v(i) = v(i_v + i)
               it%w(i) = v(i_v + 3 + i)
            end do
            it%r = matrix_of_quaternion(x(i_x + 4:i_x + 7))
         case (body_planar)
            call planar_pose(x(i_x + 1), x(i_x + 2), x(i_x + 3), v(i_v + 1), v(i_v + 2), v(i_v + 3), it)
         case (body_pinned)
            call planar_pose(self%position(1), self%position(2), x(i_x + 1), 0.0_wp, 0.0_wp, v(i_v + 1), it)
         case default
            call ground_pose(it)
            do i = 1, velocities_of_kind(self%kind)
               it%p(i) = x(i_x + i)
               it%v(i) = v(i_v + i)
            end do
         end select
      end associate
   end subroutine pose

   !> The same for a body in the plane.
   pure subroutine planar_pose(x, y, angle, vx, vy, w, it)
      real(wp), intent(in) :: x, y, angle, vx, vy, w
      type(pose_t), intent(out) :: it
      real(wp) :: c, s

      c = cos(angle)
      s = sin(angle)
      it%p(1) = x
      it%p(2) = y
      it%p(3) = 0.0_wp
      it%v(1) = vx
      it%v(2) = vy
      it%v(3) = 0.0_wp
      it%w(1) = 0.0_wp
      it%w(2) = 0.0_wp
      it%w(3) = w
      it%r(1, 1) = c
      it%r(2, 1) = s
      it%r(3, 1) = 0.0_wp
      it%r(1, 2) = -s
      it%r(2, 2) = c
      it%r(3, 2) = 0.0_wp
      it%r(1, 3) = 0.0_wp
      it%r(2, 3) = 0.0_wp
      it%r(3, 3) = 1.0_wp
   end subroutine planar_pose

   !> Whether its inertia has no products.
   pure function diagonal(self) result(answer)
      !> The body.
      class(body_t), intent(in) :: self
      !> True also where it has no inertia.
      logical :: answer

      answer = self%kind /= body_spatial .or. all(abs([self%j(1, 2), self%j(1, 3), self%j(2, 3)]) <= 0.0_wp)
   end function diagonal

   !> Gravity and the gyroscopic moments: sets its part of f.
   pure subroutine inertial_force(self, gravity, x, v, f)
      !> The body.
      class(body_t), intent(in) :: self
      !> Gravity [m/s^2].
      real(wp), intent(in) :: gravity(3)
      !> All coordinates.
      real(wp), intent(in) :: x(:)
      !> All velocities.
      real(wp), intent(in) :: v(:)
      !> All generalized forces.
      real(wp), intent(inout) :: f(:)
      real(wp) :: h(3), w(3)
      integer :: i

      associate (i_v => self%before_v)
         do i = 1, velocities_of_kind(self%kind)
            f(i_v + i) = 0.0_wp
            if (entry_of_velocity(i, self%kind) <= 3) f(i_v + i) = self%m*gravity(entry_of_velocity(i, self%kind))
         end do
         if (self%kind == body_pinned .and. any(abs(gravity) > 0.0_wp)) &
            f(i_v + 1) = self%m*moment_of_weight(self%center, gravity, x(self%before_x + 1))
         if (self%kind /= body_spatial) return
         do i = 1, 3
            w(i) = v(i_v + 3 + i)
         end do
         h = turned(self%j, w)
         f(i_v + 4) = w(3)*h(2) - w(2)*h(3)
         f(i_v + 5) = w(1)*h(3) - w(3)*h(1)
         f(i_v + 6) = w(2)*h(1) - w(1)*h(2)
      end associate
   end subroutine inertial_force

   !> Moment of gravity on a mass of 1 about a point, in the plane.
   pure real(wp) function moment_of_weight(center, gravity, angle) result(moment)
      real(wp), intent(in) :: center(3), gravity(3), angle
      real(wp) :: c, s

      c = cos(angle)
      s = sin(angle)
      moment = (c*center(1) - s*center(2))*gravity(2) - (s*center(1) + c*center(2))*gravity(1)
   end function moment_of_weight

   !> Adds a force in global axes that acts at a point given in body axes.
   pure subroutine add_force(self, it, point, force, f)
      !> The body.
      class(body_t), intent(in) :: self
      !> Its pose.
      type(pose_t), intent(in) :: it
      !> Where it acts, in body axes [m].
      real(wp), intent(in) :: point(3)
      !> The force, in global axes [N].
      real(wp), intent(in) :: force(3)
      !> All generalized forces.
      real(wp), intent(inout) :: f(:)
      real(wp) :: entries(6)

      entries(1:3) = force
      entries(4:6) = cross(point, turned_back(it%r, force))
      call add_entries(self, entries, f)
   end subroutine add_force

   !> Adds a moment in global axes.
   pure subroutine add_moment(self, it, moment, f)
      !> The body.
      class(body_t), intent(in) :: self
      !> Its pose.
      type(pose_t), intent(in) :: it
      !> What [N m].
      real(wp), intent(in) :: moment(3)
      !> All generalized forces.
      real(wp), intent(inout) :: f(:)
      real(wp) :: entries(6)

      entries(1:3) = 0.0_wp
      entries(4:6) = turned_back(it%r, moment)
      call add_entries(self, entries, f)
   end subroutine add_moment

   !> Adds those of six entries that the body has.
   pure subroutine add_entries(self, entries, f)
      class(body_t), intent(in) :: self
      real(wp), intent(in) :: entries(6)
      real(wp), intent(inout) :: f(:)
      integer :: i

      do i = 1, velocities_of_kind(self%kind)
         f(self%before_v + i) = f(self%before_v + i) + entries(entry_of_velocity(i, self%kind))
      end do
   end subroutine add_entries

   !> Kinetic energy [J].
   pure function kinetic_energy(self, v) result(energy)
      !> The body.
      class(body_t), intent(in) :: self
      !> All velocities.
      real(wp), intent(in) :: v(:)
      !> The energy.
      real(wp) :: energy
      real(wp) :: u(6)
      integer :: i

      u = 0.0_wp
      do i = 1, velocities_of_kind(self%kind)
         u(entry_of_velocity(i, self%kind)) = v(self%before_v + i)
      end do
      energy = 0.5_wp*self%m*dot_product(u(1:3), u(1:3)) + 0.5_wp*dot_product(u(4:6), turned(self%j, u(4:6)))
   end function kinetic_energy

   !> xdot of velocities u.
   pure subroutine rate(self, x, u, x_rate)
      !> The body.
      class(body_t), intent(in) :: self
      !> All coordinates.
      real(wp), intent(in) :: x(:)
      !> All velocities.
      real(wp), intent(in) :: u(:)
      !> Rate of all coordinates.
      real(wp), intent(inout) :: x_rate(:)
      integer :: i

      associate (i_x => self%before_x, i_v => self%before_v)
         if (self%kind == body_spatial) then
            call pose_rate(x(i_x + 1:i_x + 7), u(i_v + 1:i_v + 6), x_rate(i_x + 1:i_x + 7))
         else
            do i = 1, velocities_of_kind(self%kind)
               x_rate(i_x + i) = u(i_v + i)
            end do
         end if
      end associate
   end subroutine rate

   !> Velocities of a rate of the coordinates.
   pure subroutine velocity_of_rate(self, x, x_rate, u)
      !> The body.
      class(body_t), intent(in) :: self
      !> All coordinates.
      real(wp), intent(in) :: x(:)
      !> All their rates.
      real(wp), intent(in) :: x_rate(:)
      !> All velocities.
      real(wp), intent(inout) :: u(:)
      integer :: i

      associate (i_x => self%before_x, i_v => self%before_v)
         if (self%kind == body_spatial) then
            call pose_velocity(x(i_x + 1:i_x + 7), x_rate(i_x + 1:i_x + 7), u(i_v + 1:i_v + 6))
         else
            do i = 1, velocities_of_kind(self%kind)
               u(i_v + i) = x_rate(i_x + i)
            end do
         end if
      end associate
   end subroutine velocity_of_rate

   !> x := x (+) d.
   pure subroutine move(self, d, x)
      !> The body.
      class(body_t), intent(in) :: self
      !> Displacement along all velocities.
      real(wp), intent(in) :: d(:)
      !> All coordinates.
      real(wp), intent(inout) :: x(:)
      integer :: i

      associate (i_x => self%before_x, i_v => self%before_v)
         if (self%kind == body_spatial) then
            call move_pose(d(i_v + 1:i_v + 6), x(i_x + 1:i_x + 7))
         else
            do i = 1, velocities_of_kind(self%kind)
               x(i_x + i) = x(i_x + i) + d(i_v + i)
            end do
         end if
      end associate
   end subroutine move

   !> Brings a quaternion back to length one.
   pure subroutine normalize(self, x)
      !> The body.
      class(body_t), intent(in) :: self
      !> All coordinates.
      real(wp), intent(inout) :: x(:)

      if (self%kind == body_spatial) call normalize_pose(x(self%before_x + 1:self%before_x + 7))
   end subroutine normalize

end module taut_model_mechanism_body
