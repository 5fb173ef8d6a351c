!> The two-node finite-volume beam element of the paper's Appendix, Eqs (31)-(37): in space, geometrically exact.
!!
!! The beam is cut half-way between the nodes; the internal force f_I and moment m_I at the cut act on both halves with
!! opposite signs. The position is interpolated linearly, the orientation along a helix: half-way, R_I is R_1 turned by
!! half of theta = log(R_1^T R_2), and the curvature is theta over the reference length.
!!
!! Eq. (31) is printed as the gradient of the strain energy; what acts on the nodes, here, is its negative. In the plane the
!! nodal forces and moments are that gradient; in space the forces are, and the moments differ from it by the square
!! of the element's relative rotation.
module taut_model_beam_element
   use taut_kinds, only: wp
   use taut_rotation, only: cross, quaternion_of_vector, right_tangent, right_tangent_inverse, rotate, rotate_back
   implicit none (type, external)
   private
   public :: beam_element_t, new_element, internal_loads, element_strain, element_energy, element_rows, dissipated_power

   !> An element.
   type :: beam_element_t
      !> Length in the reference configuration [m]: d eta/d xi of Eq. (35) is half of it.
      real(wp) :: l = 1.0_wp
      !> Forces per strain, with the shear correction.
      real(wp) :: stiffness(6, 6) = 0.0_wp
      !> What Eqs (33) subtract: {R_0^T x_0/eta; R_0^T rho_0eta}.
      real(wp) :: reference(6) = 0.0_wp
      !> Time constant of viscous damping [s]: forces are stiffness (strain + damping * strain rate).
      real(wp) :: damping = 0.0_wp
      !> Whether the stiffness is diagonal.
      logical, private :: uncoupled = .false.
   end type beam_element_t

contains

   !> An element with its reference configuration.
   pure function new_element(x_1, q_1, x_2, q_2, stiffness, damping) result(element)
      !> Position of the first node [m].
      real(wp), intent(in) :: x_1(3)
      !> Its orientation: unit quaternion.
      real(wp), intent(in) :: q_1(4)
      !> Position of the second node [m].
      real(wp), intent(in) :: x_2(3)
      !> Its orientation: unit quaternion.
      real(wp), intent(in) :: q_2(4)
      !> Forces per strain.
      real(wp), intent(in) :: stiffness(6, 6)
      !> Time constant of viscous damping [s].
      real(wp), intent(in) :: damping
      !> The element.
      type(beam_element_t) :: element
      real(wp) :: r(3, 3)
      integer :: i

      element%l = norm2(x_2 - x_1)
      element%stiffness = stiffness
      element%damping = damping
      element%uncoupled = .true.
      do i = 1, 6
         if (any(abs(stiffness(:i - 1, i)) > 0.0_wp) .or. any(abs(stiffness(i + 1:, i)) > 0.0_wp)) element%uncoupled = .false.
      end do
      call half_way(element%l, x_1, q_1, x_2, q_2, r, element%reference)
   end function new_element

   !> R_I and {R^T x_/eta; R^T rho_eta} half-way between the nodes, Eqs (33)-(37).
   !!
   !! The quaternion half-way is the normalized sum: R_1 exp(theta x/2) exactly. The lengths of q_1 and q_2 do not matter
   !! as long as they are equal.
   pure subroutine half_way(l, x_1, q_1, x_2, q_2, r, gradient)
      real(wp), intent(in) :: l, x_1(3), q_1(4), x_2(3), q_2(4)
      real(wp), intent(out) :: r(3, 3), gradient(6)
      real(wp) :: a, b, c, d, dx(3), factor, relative(4), s, square

      ! q_1* q_2; q and -q are the same, so that the scalar part may be taken as positive.
      relative(1) = q_1(1)*q_2(1) + q_1(2)*q_2(2) + q_1(3)*q_2(3) + q_1(4)*q_2(4)
      relative(2) = q_1(1)*q_2(2) - q_2(1)*q_1(2) - q_1(3)*q_2(4) + q_1(4)*q_2(3)
      relative(3) = q_1(1)*q_2(3) - q_2(1)*q_1(3) - q_1(4)*q_2(2) + q_1(2)*q_2(4)
      relative(4) = q_1(1)*q_2(4) - q_2(1)*q_1(4) - q_1(2)*q_2(3) + q_1(3)*q_2(2)
      s = sign(1.0_wp, relative(1))

      ! theta = 2 atan(|q|/q0)/|q| q, Eq. (37).
      square = relative(2)*relative(2) + relative(3)*relative(3) + relative(4)*relative(4)
      if (square > tiny(square)) then
         square = sqrt(square)
         factor = s*2.0_wp*atan2(square, abs(relative(1)))/square
      else
         factor = 2.0_wp/relative(1)
      end if
      factor = factor/l
      gradient(4) = factor*relative(2)
      gradient(5) = factor*relative(3)
      gradient(6) = factor*relative(4)

      a = q_1(1) + s*q_2(1)
      b = q_1(2) + s*q_2(2)
      c = q_1(3) + s*q_2(3)
      d = q_1(4) + s*q_2(4)
      s = 2.0_wp/(a*a + b*b + c*c + d*d)
      r(1, 1) = 1.0_wp - s*(c*c + d*d)
      r(2, 1) = s*(b*c + a*d)
      r(3, 1) = s*(b*d - a*c)
      r(1, 2) = s*(b*c - a*d)
      r(2, 2) = 1.0_wp - s*(b*b + d*d)
      r(3, 2) = s*(c*d + a*b)
      r(1, 3) = s*(b*d + a*c)
      r(2, 3) = s*(c*d - a*b)
      r(3, 3) = 1.0_wp - s*(b*b + c*c)

      dx(1) = (x_2(1) - x_1(1))/l
      dx(2) = (x_2(2) - x_1(2))/l
      dx(3) = (x_2(3) - x_1(3))/l
      gradient(1) = r(1, 1)*dx(1) + r(2, 1)*dx(2) + r(3, 1)*dx(3)
      gradient(2) = r(1, 2)*dx(1) + r(2, 2)*dx(2) + r(3, 2)*dx(3)
      gradient(3) = r(1, 3)*dx(1) + r(2, 3)*dx(2) + r(3, 3)*dx(3)
   end subroutine half_way

   !> Forces and moments on the nodes, in global axes; the force on node 2 is the opposite of that on node 1.
   pure subroutine internal_loads(self, x_1, q_1, v_1, x_2, q_2, v_2, f_1, m_1, m_2)
      !> The element.
      type(beam_element_t), intent(in) :: self
      !> Position of the first node [m].
      real(wp), intent(in) :: x_1(3)
      !> Its orientation: unit quaternion.
      real(wp), intent(in) :: q_1(4)
      !> Position of the second node [m].
      real(wp), intent(in) :: x_2(3)
      !> Its orientation: unit quaternion.
      real(wp), intent(in) :: q_2(4)
      !> Velocity of the first node, linear in global and angular in body axes; used by damping only.
      real(wp), intent(in) :: v_1(6)
      !> The same of the second node.
      real(wp), intent(in) :: v_2(6)
      !> Force on node 1 [N].
      real(wp), intent(out) :: f_1(3)
      !> Moment on the first node [N m].
      real(wp), intent(out) :: m_1(3)
      !> Moment on the second node [N m].
      real(wp), intent(out) :: m_2(3)
      real(wp) :: arm(3), half(3), load(6), m_i(3), r(3, 3), rate(6), strain(6)
      integer :: i, j

      call half_way(self%l, x_1, q_1, x_2, q_2, r, strain)
      if (self%damping > 0.0_wp) then
         call gradient_rate(self%l, x_2 - x_1, v_1, v_2, r, strain, rate)
         strain = strain - self%reference + self%damping*rate
      else
         do i = 1, 6
            strain(i) = strain(i) - self%reference(i)
         end do
      end if
      if (self%uncoupled) then
         do i = 1, 6
            load(i) = self%stiffness(i, i)*strain(i)
         end do
      else
         load(:) = 0.0_wp
         do j = 1, 6
            do i = 1, 6
               load(i) = load(i) + self%stiffness(i, j)*strain(j)
            end do
         end do
      end if
      ! Eqs (32), and (31) with the opposite sign: x_I - x_1 = (x_2 - x_1)/2 = x_2 - x_I.
      do i = 1, 3
         f_1(i) = r(i, 1)*load(1) + r(i, 2)*load(2) + r(i, 3)*load(3)
         m_i(i) = r(i, 1)*load(4) + r(i, 2)*load(5) + r(i, 3)*load(6)
         arm(i) = 0.5_wp*(x_2(i) - x_1(i))
      end do
      half(1) = arm(2)*f_1(3) - arm(3)*f_1(2)
      half(2) = arm(3)*f_1(1) - arm(1)*f_1(3)
      half(3) = arm(1)*f_1(2) - arm(2)*f_1(1)
      do i = 1, 3
         m_1(i) = half(i) + m_i(i)
         m_2(i) = half(i) - m_i(i)
      end do
   end subroutine internal_loads

   !> The element as elastic rows: g, the strains times the length (with damping, plus their rates times its time constant),
   !! and B, by which the loads at the cut, sigma = stiffness g/length, act on the nodes as -B^T sigma.
   pure subroutine element_rows(self, x_1, q_1, v_1, x_2, q_2, v_2, g, b)
      !> The element.
      type(beam_element_t), intent(in) :: self
      !> Position of the first node [m].
      real(wp), intent(in) :: x_1(3)
      !> Its orientation: unit quaternion.
      real(wp), intent(in) :: q_1(4)
      !> Position of the second node [m].
      real(wp), intent(in) :: x_2(3)
      !> Its orientation: unit quaternion.
      real(wp), intent(in) :: q_2(4)
      !> Velocity of the first node, linear in global and angular in body axes; used by damping only.
      real(wp), intent(in) :: v_1(6)
      !> The same of the second node.
      real(wp), intent(in) :: v_2(6)
      !> {stretch and slips [m], twist and bends [rad]}.
      real(wp), intent(out) :: g(6)
      !> Row after row, each with the velocities of node 1 and of node 2: (12, 6).
      real(wp), intent(out) :: b(12, 6)
      real(wp) :: arm(3), r(3, 3), rate(6), strain(6)
      integer :: i

      call half_way(self%l, x_1, q_1, x_2, q_2, r, strain)
      g = self%l*(strain - self%reference)
      if (self%damping > 0.0_wp) then
         call gradient_rate(self%l, x_2 - x_1, v_1, v_2, r, strain, rate)
         g = g + self%l*self%damping*rate
      end if
      arm = 0.5_wp*(x_2 - x_1)
      b(:, :) = 0.0_wp
      do i = 1, 3
         b(1:3, i) = -r(:, i)
         b(4:6, i) = -rotate_back(q_1, cross(arm, r(:, i)))
         b(7:9, i) = r(:, i)
         b(10:12, i) = -rotate_back(q_2, cross(arm, r(:, i)))
         b(4:6, i + 3) = -rotate_back(q_1, r(:, i))
         b(10:12, i + 3) = rotate_back(q_2, r(:, i))
      end do
   end subroutine element_rows

   !> Rate of the gradient of `half_way`.
   !!
   !! R_1^T R_2 turns at W_2 - R_2^T R_1 W_1 in the axes of node 2, so that thetadot = J(theta)^-1 of it; half-way the
   !! body axes turn at exp(-theta x/2) W_1 + J(theta/2) thetadot/2.
   pure subroutine gradient_rate(l, dx, v_1, v_2, r, gradient, rate)
      real(wp), intent(in) :: l, dx(3), v_1(6), v_2(6), r(3, 3), gradient(6)
      real(wp), intent(out) :: rate(6)
      real(wp) :: half(3), theta_rate(3), theta(3), w(3), difference(3), along(3), strained(3), tangent(3, 3)
      integer :: i

      theta = l*gradient(4:6)
      half = turned(-0.5_wp*theta, v_1(4:6))
      ! One product at a time: gfortran keeps what is inside of several on the heap where it optimizes.
      difference = v_2(4:6) - turned(-0.5_wp*theta, half)
      tangent = right_tangent_inverse(theta)
      theta_rate = matmul(tangent, difference)
      tangent = right_tangent(0.5_wp*theta)
      w = matmul(tangent, theta_rate)
      w = half + 0.5_wp*w
      difference = (v_2(1:3) - v_1(1:3))/l
      along = dx/l
      do i = 1, 3
         rate(i) = dot_product(r(:, i), difference)
         strained(i) = dot_product(r(:, i), along)
      end do
      rate(1:3) = rate(1:3) - cross(w, strained)
      rate(4:6) = theta_rate/l
   end subroutine gradient_rate

   !> exp(theta x) v.
   pure function turned(theta, v) result(u)
      real(wp), intent(in) :: theta(3), v(3)
      real(wp) :: u(3)

      u = rotate(quaternion_of_vector(theta), v)
   end function turned

   !> Strains half-way between the nodes, Eqs (33).
   pure function element_strain(self, x_1, q_1, x_2, q_2) result(strain)
      !> The element.
      type(beam_element_t), intent(in) :: self
      !> Position of the first node [m].
      real(wp), intent(in) :: x_1(3)
      !> Its orientation: unit quaternion.
      real(wp), intent(in) :: q_1(4)
      !> Position of the second node [m].
      real(wp), intent(in) :: x_2(3)
      !> Its orientation: unit quaternion.
      real(wp), intent(in) :: q_2(4)
      !> {axial, shear 2, shear 3, torsion, curvature about 2, about 3}: [-] and [1/m].
      real(wp) :: strain(6)
      real(wp) :: r(3, 3)

      call half_way(self%l, x_1, q_1, x_2, q_2, r, strain)
      strain = strain - self%reference
   end function element_strain

   !> Strain energy [J].
   pure function element_energy(self, x_1, q_1, x_2, q_2) result(energy)
      !> The element.
      type(beam_element_t), intent(in) :: self
      !> Position of the first node [m].
      real(wp), intent(in) :: x_1(3)
      !> Its orientation: unit quaternion.
      real(wp), intent(in) :: q_1(4)
      !> Position of the second node [m].
      real(wp), intent(in) :: x_2(3)
      !> Its orientation: unit quaternion.
      real(wp), intent(in) :: q_2(4)
      !> The energy.
      real(wp) :: energy
      real(wp) :: strain(6)

      strain = element_strain(self, x_1, q_1, x_2, q_2)
      energy = 0.5_wp*self%l*dot_product(strain, matmul(self%stiffness, strain))
   end function element_energy

   !> What viscous damping takes [W].
   pure function dissipated_power(self, x_1, q_1, v_1, x_2, q_2, v_2) result(power)
      !> The element.
      type(beam_element_t), intent(in) :: self
      !> Position of the first node [m].
      real(wp), intent(in) :: x_1(3)
      !> Its orientation: unit quaternion.
      real(wp), intent(in) :: q_1(4)
      !> Its velocity, linear in global and angular in body axes.
      real(wp), intent(in) :: v_1(6)
      !> Position of the second node [m].
      real(wp), intent(in) :: x_2(3)
      !> Its orientation: unit quaternion.
      real(wp), intent(in) :: q_2(4)
      !> Its velocity.
      real(wp), intent(in) :: v_2(6)
      !> The power.
      real(wp) :: power
      real(wp) :: r(3, 3), rate(6), strain(6)

      power = 0.0_wp
      if (.not. self%damping > 0.0_wp) return
      call half_way(self%l, x_1, q_1, x_2, q_2, r, strain)
      call gradient_rate(self%l, x_2 - x_1, v_1, v_2, r, strain, rate)
      power = self%l*self%damping*dot_product(rate, matmul(self%stiffness, rate))
   end function dissipated_power

end module taut_model_beam_element
