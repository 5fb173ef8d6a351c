!> Rotations in space: rotation vectors, matrices, unit quaternions, and the maps between their rates.
!!
!! A rotation R takes components in body axes to components in global axes. A rotation vector theta turns by |theta| about
!! its own direction: R = exp(theta x). A quaternion is {q0, q}, q0 the cosine of half the angle; q and -q are the same
!! rotation. W is the angular velocity in body axes, w = R W in global axes.
module taut_rotation
   use taut_kinds, only: wp
   implicit none (type, external)
   private
   public :: cross, skew
   public :: exp_rotation, log_rotation, right_tangent, right_tangent_inverse
   public :: quaternion_product, quaternion_conjugate, quaternion_rate, quaternion_body_rate, quaternion_normalized
   public :: quaternion_of_vector, vector_of_quaternion, matrix_of_quaternion, quaternion_of_matrix, quaternion_of_axes
   public :: rotate, rotate_back

   ! Generic: jets have the same (`taut_jet`).
   interface cross
      module procedure :: real_cross
   end interface cross

   interface quaternion_product
      module procedure :: real_quaternion_product
   end interface quaternion_product

   interface quaternion_conjugate
      module procedure :: real_quaternion_conjugate
   end interface quaternion_conjugate

   interface quaternion_rate
      module procedure :: real_quaternion_rate
   end interface quaternion_rate

   interface rotate
      module procedure :: real_rotate
   end interface rotate

   interface rotate_back
      module procedure :: real_rotate_back
   end interface rotate_back

   !> Angle [rad] below which coefficients that suffer from cancellation are had from their series.
   real(wp), parameter :: small_angle = 0.3_wp

contains

   !> a x b.
   pure function real_cross(a, b) result(c)
      !> The first vector.
      real(wp), intent(in) :: a(3)
      !> The second vector.
      real(wp), intent(in) :: b(3)
      !> Their product.
      real(wp) :: c(3)

      c(1) = a(2)*b(3) - a(3)*b(2)
      c(2) = a(3)*b(1) - a(1)*b(3)
      c(3) = a(1)*b(2) - a(2)*b(1)
   end function real_cross

   !> The matrix (a x), with (a x) b = a x b.
   pure function skew(a) result(s)
      !> A vector.
      real(wp), intent(in) :: a(3)
      !> Skew-symmetric.
      real(wp) :: s(3, 3)

      s(:, 1) = [0.0_wp, a(3), -a(2)]
      s(:, 2) = [-a(3), 0.0_wp, a(1)]
      s(:, 3) = [a(2), -a(1), 0.0_wp]
   end function skew

   !> I + c1 (theta x) + c2 (theta x)^2.
   pure function polynomial(theta, c1, c2) result(m)
      real(wp), intent(in) :: theta(3), c1, c2
      real(wp) :: m(3, 3)
      integer :: i, j

      m = c1*skew(theta)
      do j = 1, 3
         do i = 1, 3
            m(i, j) = m(i, j) + c2*theta(i)*theta(j)
         end do
         m(j, j) = m(j, j) + 1.0_wp - c2*dot_product(theta, theta)
      end do
   end function polynomial

   !> sin(t)/t.
   elemental function sinc(t) result(s)
      real(wp), intent(in) :: t
      real(wp) :: s

      s = 1.0_wp
      if (abs(t) > 1.0e-9_wp) s = sin(t)/t
   end function sinc

   !> R = exp(theta x), Rodrigues' formula.
   pure function exp_rotation(theta) result(r)
      !> Rotation vector [rad].
      real(wp), intent(in) :: theta(3)
      !> Rotation matrix.
      real(wp) :: r(3, 3)
      real(wp) :: t

      t = norm2(theta)
      r = polynomial(theta, sinc(t), 0.5_wp*sinc(0.5_wp*t)**2)
   end function exp_rotation

   !> theta = ax(log R), by way of the quaternion, so that it is accurate for every angle up to pi.
   pure function log_rotation(r) result(theta)
      !> Rotation matrix.
      real(wp), intent(in) :: r(3, 3)
      !> Rotation vector [rad], |theta| <= pi.
      real(wp) :: theta(3)

      theta = vector_of_quaternion(quaternion_of_matrix(r))
   end function log_rotation

   !> J of W = J thetadot, the body angular velocity of R = exp(theta x); its transpose gives the global one.
   !!
   !! J = I - (1 - cos t)/t^2 (theta x) + (t - sin t)/t^3 (theta x)^2.
   pure function right_tangent(theta) result(j)
      !> Rotation vector [rad].
      real(wp), intent(in) :: theta(3)
      !> The map.
      real(wp) :: j(3, 3)
      real(wp) :: t, c2, t2

      t = norm2(theta)
      t2 = t*t
      if (t < small_angle) then
         c2 = (1.0_wp - t2/20.0_wp*(1.0_wp - t2/42.0_wp*(1.0_wp - t2/72.0_wp*(1.0_wp - t2/110.0_wp))))/6.0_wp
      else
         c2 = (1.0_wp - sinc(t))/t2
      end if
      j = polynomial(theta, -0.5_wp*sinc(0.5_wp*t)**2, c2)
   end function right_tangent

   !> The inverse of `right_tangent`: thetadot = J^-1 W; singular at |theta| = 2 pi only.
   !!
   !! J^-1 = I + (theta x)/2 + (1 - t/2 cot(t/2))/t^2 (theta x)^2.
   pure function right_tangent_inverse(theta) result(j)
      !> Rotation vector [rad].
      real(wp), intent(in) :: theta(3)
      !> The map.
      real(wp) :: j(3, 3)
      real(wp) :: c2, t, t2

      t = norm2(theta)
      t2 = t*t
      if (t < small_angle) then
         c2 = 1.0_wp/12.0_wp + t2*(1.0_wp/720.0_wp + t2*(1.0_wp/30240.0_wp + t2*(1.0_wp/1209600.0_wp + t2/47900160.0_wp)))
      else
         c2 = (1.0_wp - 0.5_wp*t*cos(0.5_wp*t)/sin(0.5_wp*t))/t2
      end if
      j = polynomial(theta, 0.5_wp, c2)
   end function right_tangent_inverse

   !> p q: first q, then p.
   pure function real_quaternion_product(p, q) result(r)
      !> The first quaternion.
      real(wp), intent(in) :: p(4)
      !> The second quaternion.
      real(wp), intent(in) :: q(4)
      !> Their product.
      real(wp) :: r(4)

      r(1) = p(1)*q(1) - p(2)*q(2) - p(3)*q(3) - p(4)*q(4)
      r(2) = p(1)*q(2) + p(2)*q(1) + p(3)*q(4) - p(4)*q(3)
      r(3) = p(1)*q(3) + p(3)*q(1) + p(4)*q(2) - p(2)*q(4)
      r(4) = p(1)*q(4) + p(4)*q(1) + p(2)*q(3) - p(3)*q(2)
   end function real_quaternion_product

   !> The inverse rotation.
   pure function real_quaternion_conjugate(q) result(r)
      !> A quaternion.
      real(wp), intent(in) :: q(4)
      !> {q0, -q}.
      real(wp) :: r(4)

      r = [q(1), -q(2), -q(3), -q(4)]
   end function real_quaternion_conjugate

   !> qdot = q {0, W}/2.
   pure function real_quaternion_rate(q, w) result(rate)
      !> Unit quaternion.
      real(wp), intent(in) :: q(4)
      !> Angular velocity in body axes [rad/s].
      real(wp), intent(in) :: w(3)
      !> Its rate [1/s].
      real(wp) :: rate(4)

      rate = 0.5_wp*quaternion_product(q, [0.0_wp, w])
   end function real_quaternion_rate

   !> W of a rate of q: the vector part of 2 q* qdot.
   pure function quaternion_body_rate(q, rate) result(w)
      !> Unit quaternion.
      real(wp), intent(in) :: q(4)
      !> Its rate [1/s].
      real(wp), intent(in) :: rate(4)
      !> Angular velocity in body axes [rad/s].
      real(wp) :: w(3)
      real(wp) :: p(4)

      p = quaternion_product(quaternion_conjugate(q), rate)
      w = 2.0_wp*p(2:4)
   end function quaternion_body_rate

   !> q/|q|; the identity where q is zero.
   pure function quaternion_normalized(q) result(r)
      !> A quaternion.
      real(wp), intent(in) :: q(4)
      !> A unit quaternion.
      real(wp) :: r(4)
      real(wp) :: square

      square = q(1)*q(1) + q(2)*q(2) + q(3)*q(3) + q(4)*q(4)
      r = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      if (square > tiny(square)) r = q/sqrt(square)
   end function quaternion_normalized

   !> The quaternion of a rotation vector.
   pure function quaternion_of_vector(theta) result(q)
      !> Rotation vector [rad].
      real(wp), intent(in) :: theta(3)
      !> Unit quaternion.
      real(wp) :: q(4)
      real(wp) :: t

      t = 0.5_wp*norm2(theta)
      q(1) = cos(t)
      q(2:4) = 0.5_wp*sinc(t)*theta
   end function quaternion_of_vector

   !> The rotation vector of a quaternion, whose length does not matter.
   pure function vector_of_quaternion(q) result(theta)
      !> A quaternion other than zero.
      real(wp), intent(in) :: q(4)
      !> Rotation vector [rad], |theta| <= pi.
      real(wp) :: theta(3)
      real(wp) :: factor, s, square

      square = q(2)*q(2) + q(3)*q(3) + q(4)*q(4)
      if (square > tiny(square)) then
         s = sqrt(square)
         factor = sign(2.0_wp*atan2(s, abs(q(1)))/s, q(1))
      else
         factor = 2.0_wp/q(1)
      end if
      theta = factor*q(2:4)
   end function vector_of_quaternion

   !> The matrix of a quaternion, whose length does not matter.
   pure function matrix_of_quaternion(q) result(r)
      !> A quaternion other than zero.
      real(wp), intent(in) :: q(4)
      !> Rotation matrix.
      real(wp) :: r(3, 3)
      real(wp) :: a, b, c, d, s

      s = 2.0_wp/(q(1)*q(1) + q(2)*q(2) + q(3)*q(3) + q(4)*q(4))
      a = q(1)
      b = q(2)
      c = q(3)
      d = q(4)
      r(1, 1) = 1.0_wp - s*(c*c + d*d)
      r(2, 1) = s*(b*c + a*d)
      r(3, 1) = s*(b*d - a*c)
      r(1, 2) = s*(b*c - a*d)
      r(2, 2) = 1.0_wp - s*(b*b + d*d)
      r(3, 2) = s*(c*d + a*b)
      r(1, 3) = s*(b*d + a*c)
      r(2, 3) = s*(c*d - a*b)
      r(3, 3) = 1.0_wp - s*(b*b + c*c)
   end function matrix_of_quaternion

   !> The quaternion of a matrix, by the largest of its four entries.
   !!
   !! Source: S.W. Shepperd, Quaternion from rotation matrix, J. Guidance and Control 1 (1978) 223-224.
   pure function quaternion_of_matrix(r) result(q)
      !> Rotation matrix.
      real(wp), intent(in) :: r(3, 3)
      !> Unit quaternion, q0 >= 0 unless its sign is open.
      real(wp) :: q(4)
      real(wp) :: trace
      integer :: i, j, k

      trace = r(1, 1) + r(2, 2) + r(3, 3)
      i = maxloc([r(1, 1), r(2, 2), r(3, 3)], 1)
      if (trace >= r(i, i)) then
         q = [1.0_wp + trace, r(3, 2) - r(2, 3), r(1, 3) - r(3, 1), r(2, 1) - r(1, 2)]
      else
         j = 1 + mod(i, 3)
         k = 1 + mod(j, 3)
         q(1) = r(k, j) - r(j, k)
         q(1 + i) = 1.0_wp + 2.0_wp*r(i, i) - trace
         q(1 + j) = r(j, i) + r(i, j)
         q(1 + k) = r(k, i) + r(i, k)
      end if
      q = quaternion_normalized(q)
      if (q(1) < 0.0_wp) q = -q
   end function quaternion_of_matrix

   !> The orientation whose first axis is along one direction, with the second axis nearest to another.
   pure function quaternion_of_axes(axis_1, near_axis_2) result(q)
      !> Direction of axis 1, of any length.
      real(wp), intent(in) :: axis_1(3)
      !> Direction near axis 2, of any length; not parallel to it.
      real(wp), intent(in) :: near_axis_2(3)
      !> Unit quaternion.
      real(wp) :: q(4)
      real(wp) :: r(3, 3)

      r(:, 1) = axis_1/norm2(axis_1)
      r(:, 3) = cross(r(:, 1), near_axis_2)
      r(:, 3) = r(:, 3)/norm2(r(:, 3))
      r(:, 2) = cross(r(:, 3), r(:, 1))
      q = quaternion_of_matrix(r)
   end function quaternion_of_axes

   !> R v: from body to global axes.
   pure function real_rotate(q, v) result(u)
      !> Unit quaternion.
      real(wp), intent(in) :: q(4)
      !> Components in body axes.
      real(wp), intent(in) :: v(3)
      !> Components in global axes.
      real(wp) :: u(3)
      real(wp) :: c(3)

      c = 2.0_wp*cross(q(2:4), v)
      u = v + q(1)*c + cross(q(2:4), c)
   end function real_rotate

   !> R^T v: from global to body axes.
   pure function real_rotate_back(q, v) result(u)
      !> Unit quaternion.
      real(wp), intent(in) :: q(4)
      !> Components in global axes.
      real(wp), intent(in) :: v(3)
      !> Components in body axes.
      real(wp) :: u(3)
      real(wp) :: c(3)

      c = 2.0_wp*cross(q(2:4), v)
      u = v - q(1)*c + cross(q(2:4), c)
   end function real_rotate_back

end module taut_rotation
