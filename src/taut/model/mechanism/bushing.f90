!> A bushing: an elastic connection of two bodies in all six directions, with dampers.
!!
!! Each body has a point and axes, F_1 and F_2, which coincide where the bushing is relaxed. Half-way between them are the axes
!! F = F_1 exp(theta x/2), theta = log(F_1^T F_2), in which u = F^T (x_2 - x_1): the bushing is the same seen from either
!! body. Its potential is V = 1/2 u^T K u + 1/2 theta^T K_r theta, with stiffnesses along and about its axes.
!!
!! With the angular velocities a = F^T Omega_1 and b = F^T Omega_2, phi = |theta| and n = theta/phi, the rates are exactly
!!
!!     thetadot = S (b - a),                           S = n n^T + phi/2/sin(phi/2) (I - n n^T)
!!     udot     = F^T (xdot_2 - xdot_1) - w x u,       w = (a + b)/2 - tan(phi/4)/2 n x (b - a)
!!
!! for the eigenvalues of the tangent of the rotation group, half-way, are real. Forces follow from them by their power, so that
!! energy and both momenta are kept. Half a turn is as far as theta can tell.
module taut_model_mechanism_bushing
   use taut_kinds, only: wp
   use taut_model_mechanism_body, only: point_motion, pose_t, turned, turned_back
   use taut_rotation, only: cross, matrix_of_quaternion, quaternion_of_matrix
   implicit none (type, external)
   private
   public :: bushing_t, deformation_t

   !> A bushing.
   type :: bushing_t
      !> What it is called.
      character(:), allocatable :: name
      !> Bodies (0: the ground), points [m] and axes, in those of the bodies.
      integer :: body_1 = 0, body_2 = 0
      real(wp) :: p_1(3) = 0.0_wp, p_2(3) = 0.0_wp
      real(wp) :: frame_1(3, 3) = 0.0_wp, frame_2(3, 3) = 0.0_wp
      !> Along its axes [N/m], [N s/m], then about them [N m/rad], [N m s/rad].
      real(wp) :: stiffness(6) = 0.0_wp, damping(6) = 0.0_wp
   contains
      procedure :: deform
      procedure :: elastic
      procedure :: stress
      procedure :: rows
   end type bushing_t

   !> How far it is deformed, and how fast.
   type :: deformation_t
      !> {u, theta} [m], [rad], and their rates.
      real(wp) :: strain(6), rate(6)
      !> F: its axes in global ones.
      real(wp) :: axes(3, 3)
      !> S, and tan(phi/4) n.
      real(wp), private :: s(3, 3), t(3)
   contains
      procedure :: loads
   end type deformation_t

contains

   !> Its deformation.
   pure subroutine deform(self, one, two, it)
      !> The bushing.
      class(bushing_t), intent(in) :: self
      !> Pose of its first body.
      type(pose_t), intent(in) :: one
      !> Pose of its second body.
      type(pose_t), intent(in) :: two
      !> The deformation.
      type(deformation_t), intent(out) :: it
      real(wp) :: a(3), b(3), f_1(3, 3), growth, n(3), q(4), sine, v_1(3), v_2(3), w(3), x_1(3), x_2(3)
      integer :: i

      f_1 = matmul(one%r, self%frame_1)
      q = quaternion_of_matrix(matmul(transpose(f_1), matmul(two%r, self%frame_2)))
      sine = norm2(q(2:4))
      growth = 1.0_wp
      n = 0.0_wp
      if (sine > 0.0_wp) then
         growth = atan2(sine, q(1))/sine
         n = q(2:4)/sine
      end if
      it%strain(4:6) = 2.0_wp*growth*q(2:4)
      it%t = q(2:4)/(1.0_wp + q(1))
      do i = 1, 3
         it%s(:, i) = (1.0_wp - growth)*n(i)*n
         it%s(i, i) = it%s(i, i) + growth
      end do
      it%axes = matmul(f_1, matrix_of_quaternion([1.0_wp + q(1), q(2:4)]))

      call point_motion(one, self%p_1, x_1, v_1)
      call point_motion(two, self%p_2, x_2, v_2)
      it%strain(1:3) = turned_back(it%axes, x_2 - x_1)
      a = turned_back(it%axes, turned(one%r, one%w))
      b = turned_back(it%axes, turned(two%r, two%w))
      w = 0.5_wp*(a + b) - 0.5_wp*cross(it%t, b - a)
      it%rate(1:3) = turned_back(it%axes, v_2 - v_1) - cross(w, it%strain(1:3))
      it%rate(4:6) = turned(it%s, b - a)
   end subroutine deform

   !> Which of the six directions have a stiffness: they are elastic rows.
   pure function elastic(self)
      !> The bushing.
      class(bushing_t), intent(in) :: self
      !> Along and about the axes.
      logical :: elastic(6)

      elastic = self%stiffness > 0.0_wp
   end function elastic

   !> Forces and moments along and about its axes, of springs and dampers; what pulls the bodies together is positive.
   pure function stress(self, it)
      !> The bushing.
      class(bushing_t), intent(in) :: self
      !> Its deformation.
      type(deformation_t), intent(in) :: it
      !> [N], [N m].
      real(wp) :: stress(6)

      stress = self%stiffness*it%strain + self%damping*it%rate
   end function stress

   !> What a stress does to the bodies: its power is that of the rates of the strain, with the opposite sign.
   pure subroutine loads(self, stress, force_1, moment_1, moment_2)
      !> The deformation.
      class(deformation_t), intent(in) :: self
      !> Along and about the axes: [N], [N m].
      real(wp), intent(in) :: stress(6)
      !> Force on the first body at its point, that on the second is the opposite, in global axes [N].
      real(wp), intent(out) :: force_1(3)
      !> Moment on the first body about its point, in global axes [N m].
      real(wp), intent(out) :: moment_1(3)
      !> The same of the second body.
      real(wp), intent(out) :: moment_2(3)
      real(wp) :: arm(3), part(3)

      ! The pair of forces, set apart by u, has a moment that the bodies share.
      arm = 0.5_wp*cross(self%strain(1:3), stress(1:3))
      part = cross(arm, self%t) + turned(self%s, stress(4:6))
      force_1 = turned(self%axes, stress(1:3))
      moment_1 = turned(self%axes, arm + part)
      moment_2 = turned(self%axes, arm - part)
   end subroutine loads

   !> B: rates of the strain by the velocities {global, body axes} of both bodies.
   pure subroutine rows(self, one, two, it, b)
      !> The bushing.
      class(bushing_t), intent(in) :: self
      !> Pose of its first body.
      type(pose_t), intent(in) :: one
      !> Pose of its second body.
      type(pose_t), intent(in) :: two
      !> Its deformation.
      type(deformation_t), intent(in) :: it
      !> Row after row, each with the velocities of body 1 and of body 2: (12, 6).
      real(wp), intent(out) :: b(12, 6)
      real(wp) :: force_1(3), moment_1(3), moment_2(3), unit(6)
      integer :: i

      do i = 1, 6
         unit = 0.0_wp
         unit(i) = 1.0_wp
         ! The loads are -B^T sigma.
         call it%loads(unit, force_1, moment_1, moment_2)
         b(1:3, i) = -force_1
         b(4:6, i) = -cross(self%p_1, turned_back(one%r, force_1)) - turned_back(one%r, moment_1)
         b(7:9, i) = force_1
         b(10:12, i) = cross(self%p_2, turned_back(two%r, force_1)) - turned_back(two%r, moment_2)
      end do
   end subroutine rows

end module taut_model_mechanism_bushing
