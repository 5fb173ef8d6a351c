!> Rigid bodies in space (Sect. 3.4.1), free or on spherical joints.
!!
!! A body has the coordinates {position of its reference point (3), unit quaternion, its scalar part first (4)} and the
!! velocities {velocity of the reference point in global axes, angular velocity in BODY axes}; the multipliers of a joint are
!! in global axes. With R from body to global axes its block of Eq. (22) is
!!
!!     M_i = [ m I      -R s x ]
!!           [ s x R^T   J     ]
!!
!! where s is the first and J the second moment of inertia about the reference point, in body axes; s is not zero where the
!! reference point is off the center of mass.
module taut_model_rigid_bodies
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_constrained_system, only: state_t
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_model_pose, only: turned, turned_back
   use taut_model_posed_system, only: posed_system_t
   use taut_rotation, only: cross, matrix_of_quaternion
   implicit none (type, external)
   private
   public :: rigid_body_t, rigid_bodies_t, spherical_joint_t, new_rigid_bodies

   !> Inertia of a body.
   type :: rigid_body_t
      !> Mass [kg].
      real(wp) :: m = 0.0_wp
      !> First moment about the reference point, in body axes [kg m].
      real(wp) :: s(3) = 0.0_wp
      !> Second moment about the reference point, in body axes: (3, 3) [kg m^2].
      real(wp) :: j(3, 3) = 0.0_wp
   end type rigid_body_t

   !> A point of a body is held at a point of another body or of the ground.
   type :: spherical_joint_t
      !> The body, and the other one; 0 is the ground.
      integer :: body = 0, other = 0
      !> The point in the body's axes, from its reference point [m].
      real(wp) :: point(3) = 0.0_wp
      !> The point in the other body's axes, or in global axes [m].
      real(wp) :: other_point(3) = 0.0_wp
   end type spherical_joint_t

   !> A set of bodies.
   type, extends(posed_system_t) :: rigid_bodies_t
      !> The bodies.
      type(rigid_body_t), allocatable :: bodies(:)
      !> The joints; each has three rows.
      type(spherical_joint_t), allocatable :: joints(:)
      !> Gravity [m/s^2].
      real(wp) :: gravity(3) = 0.0_wp
   contains
      procedure :: mass
      procedure :: force
      procedure :: constraint
      procedure :: jacobian
      procedure :: acceleration_rhs
      procedure :: energy
      procedure :: power
   end type rigid_bodies_t

contains

   !> A set of bodies with its joints.
   subroutine new_rigid_bodies(self, bodies, joints, gravity, error)
      !> The set.
      type(rigid_bodies_t), intent(out) :: self
      !> Inertia of each body.
      type(rigid_body_t), intent(in) :: bodies(:)
      !> Joints; may be none.
      type(spherical_joint_t), intent(in) :: joints(:)
      !> Gravity [m/s^2].
      real(wp), intent(in) :: gravity(3)
      !> A body without mass, or a joint that names a body that does not exist.
      type(error_t), allocatable, intent(inout) :: error
      character(*), parameter :: here = 'rigid bodies'
      integer :: i

      do i = 1, size(bodies)
         if (.not. bodies(i)%m > 0.0_wp) &
            call raise(error, here, 'the mass of body '//to_text(i)//' is not positive', 'give a mass in kg')
         if (.not. all(abs(bodies(i)%j - transpose(bodies(i)%j)) <= 1.0e-9_wp*maxval(abs(bodies(i)%j)))) then
            call raise(error, here, 'the inertia J of body '//to_text(i)//' is not symmetric, or not a number', &
                       'give a symmetric matrix in kg m^2')
         else if (.not. allocated(error)) then
            if (.not. has_inertia(bodies(i))) &
               call raise(error, here, 'the inertia of body '//to_text(i)//' is not positive definite', &
                          'give J about the reference point, not about the center of mass, if s is not zero')
         end if
      end do
      do i = 1, size(joints)
         if (joints(i)%body < 1 .or. joints(i)%body > size(bodies) .or. joints(i)%other < 0 .or. &
             joints(i)%other > size(bodies) .or. joints(i)%body == joints(i)%other) &
            call raise(error, here, 'joint '//to_text(i)//' joins body '//to_text(joints(i)%body)//' and '// &
                       to_text(joints(i)%other), 'name two different bodies of the set, or 0 for the ground as the second')
      end do
      if (allocated(error)) return
      allocate (self%bodies, source=bodies)
      allocate (self%joints, source=joints)
      self%gravity = gravity
      self%poses = size(bodies)
      call self%define(n=6*size(bodies), c=3*size(joints), n_x=7*size(bodies), mass_blocks=[(6, i=1, size(bodies))], &
                       constant_mass=all([(all(abs(bodies(i)%s) <= 0.0_wp), i=1, size(bodies))]))
   end subroutine new_rigid_bodies

   !> Whether the block of Eq. (22) is positive definite.
   function has_inertia(body) result(answer)
      type(rigid_body_t), intent(in) :: body
      logical :: answer
      type(block_diagonal_t) :: m
      real(wp) :: block(6, 6)
      integer :: info, k

      call m%init([6])
      block = 0.0_wp
      do k = 1, 3
         block(k, k) = body%m
         block(4:6, k) = cross(body%s, [(merge(1.0_wp, 0.0_wp, info == k), info=1, 3)])
      end do
      block(1:3, 4:6) = transpose(block(4:6, 1:3))
      block(4:6, 4:6) = body%j
      call m%set_dense(block)
      call m%factorize(info)
      answer = info == 0
   end function has_inertia

   !> M, block by block, Eq. (22).
   subroutine mass(self, at, m)
      !> The bodies.
      class(rigid_bodies_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> The mass matrix.
      type(block_diagonal_t), intent(inout) :: m
      real(wp) :: axis(3), block(6, 6), column(3), r(3, 3)
      integer :: b, i, k

      do b = 1, size(self%bodies)
         associate (body => self%bodies(b))
            r = matrix_of_quaternion(at%x(7*b - 3:7*b))
            block = 0.0_wp
            do k = 1, 3
               block(k, k) = body%m
               ! Column k of s x R^T: s x (the global axis k in body axes).
               do i = 1, 3
                  axis(i) = r(k, i)
               end do
               column = cross(body%s, axis)
               do i = 1, 3
                  block(3 + i, k) = column(i)
                  block(k, 3 + i) = column(i)
                  block(3 + i, 3 + k) = body%j(i, k)
               end do
            end do
         end associate
         call m%set_block(b, block)
      end do
   end subroutine mass

   !> f: gravity, and the centrifugal and gyroscopic terms.
   subroutine force(self, at, value)
      !> The bodies.
      class(rigid_bodies_t), intent(in) :: self
      !> The state; all of it may be used.
      type(state_t), intent(in) :: at
      !> f: (n).
      real(wp), intent(out) :: value(:)
      real(wp) :: f(3), m(3), omega(3), r(3, 3)
      integer :: b, i

      do b = 1, size(self%bodies)
         associate (body => self%bodies(b))
            r = matrix_of_quaternion(at%x(7*b - 3:7*b))
            do i = 1, 3
               omega(i) = at%v(6*b - 3 + i)
            end do
            f = body%m*self%gravity - turned(r, cross(omega, cross(omega, body%s)))
            m = cross(body%s, turned_back(r, self%gravity)) - cross(omega, turned(body%j, omega))
         end associate
         do i = 1, 3
            value(6*b - 6 + i) = f(i)
            value(6*b - 3 + i) = m(i)
         end do
      end do
   end subroutine force

   !> A point of a body, or of the ground: its position; and how it accelerates when the velocities do not change.
   pure subroutine follow(at, body, point, r, arm, position, centrifugal)
      type(state_t), intent(in) :: at
      integer, intent(in) :: body
      real(wp), intent(in) :: point(3)
      real(wp), intent(out) :: r(3, 3), arm(3), position(3), centrifugal(3)
      real(wp) :: omega(3)
      integer :: i

      if (body == 0) then
         r = 0.0_wp
         arm = 0.0_wp
         position = point
         centrifugal = 0.0_wp
         return
      end if
      r = matrix_of_quaternion(at%x(7*body - 3:7*body))
      arm = point
      position = turned(r, point)
      do i = 1, 3
         position(i) = position(i) + at%x(7*body - 7 + i)
         omega(i) = at%v(6*body - 3 + i)
      end do
      centrifugal = turned(r, cross(omega, cross(omega, point)))
   end subroutine follow

   !> phi: the distance between the points of each joint, in global axes [m].
   subroutine constraint(self, at, value)
      !> The bodies.
      class(rigid_bodies_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> phi: (3 joints).
      real(wp), intent(out) :: value(:)
      real(wp) :: arm(3), centrifugal(3), here(3), r(3, 3), there(3)
      integer :: k

      do k = 1, size(self%joints)
         call follow(at, self%joints(k)%body, self%joints(k)%point, r, arm, here, centrifugal)
         call follow(at, self%joints(k)%other, self%joints(k)%other_point, r, arm, there, centrifugal)
         value(3*k - 2:3*k) = here - there
      end do
   end subroutine constraint

   !> A: [I, -R p x] for the body and its opposite for the other.
   subroutine jacobian(self, at, a)
      !> The bodies.
      class(rigid_bodies_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> The constraint matrix: (3 joints, n).
      real(wp), intent(out) :: a(:, :)
      integer :: k

      a(:, :) = 0.0_wp
      do k = 1, size(self%joints)
         call add(self%joints(k)%body, self%joints(k)%point, 1.0_wp)
         call add(self%joints(k)%other, self%joints(k)%other_point, -1.0_wp)
      end do

   contains

      subroutine add(body, point, sign_of)
         integer, intent(in) :: body
         real(wp), intent(in) :: point(3), sign_of
         real(wp) :: arm(3), axis(3), centrifugal(3), position(3), r(3, 3), row(3)
         integer :: i, j

         if (body == 0) return
         call follow(at, body, point, r, arm, position, centrifugal)
         do i = 1, 3
            a(3*k - 3 + i, 6*body - 6 + i) = sign_of
            ! Row i of -R p x: p x (the global axis i in body axes).
            do j = 1, 3
               axis(j) = r(i, j)
            end do
            row = cross(arm, axis)
            do j = 1, 3
               a(3*k - 3 + i, 6*body - 3 + j) = sign_of*row(j)
            end do
         end do
      end subroutine add

   end subroutine jacobian

   !> b'' = -R omega x (omega x p) of the body, less that of the other.
   subroutine acceleration_rhs(self, at, value)
      !> The bodies.
      class(rigid_bodies_t), intent(in) :: self
      !> The state; its x, v and t are used.
      type(state_t), intent(in) :: at
      !> b'': (3 joints).
      real(wp), intent(out) :: value(:)
      real(wp) :: arm(3), here(3), position(3), r(3, 3), there(3)
      integer :: k

      do k = 1, size(self%joints)
         call follow(at, self%joints(k)%body, self%joints(k)%point, r, arm, position, here)
         call follow(at, self%joints(k)%other, self%joints(k)%other_point, r, arm, position, there)
         value(3*k - 2:3*k) = there - here
      end do
   end subroutine acceleration_rhs

   !> Kinetic energy and potential of gravity [J].
   function energy(self, at)
      !> The bodies.
      class(rigid_bodies_t), intent(in) :: self
      !> The state; its x and v are used.
      type(state_t), intent(in) :: at
      !> The energy.
      real(wp) :: energy
      real(wp) :: r(3, 3)
      integer :: b

      energy = 0.0_wp
      do b = 1, size(self%bodies)
         associate (body => self%bodies(b), v => at%v(6*b - 5:6*b - 3), omega => at%v(6*b - 2:6*b))
            r = matrix_of_quaternion(at%x(7*b - 3:7*b))
            energy = energy + 0.5_wp*body%m*dot_product(v, v) + 0.5_wp*dot_product(omega, matmul(body%j, omega)) + &
                     dot_product(v, matmul(r, cross(omega, body%s))) - &
                     dot_product(self%gravity, body%m*at%x(7*b - 6:7*b - 4) + matmul(r, body%s))
         end associate
      end do
   end function energy

   !> None: the energy contains all forces.
   function power(self, at)
      !> The bodies.
      class(rigid_bodies_t), intent(in) :: self
      !> The state at which it is evaluated.
      type(state_t), intent(in) :: at
      !> Zero [W].
      real(wp) :: power

      power = 0.0_wp
      associate (unused_system => self, unused_state => at)
      end associate
   end function power

end module taut_model_rigid_bodies
