!> A flexible body described by Ritz shapes (Sect. 3.4.2) in a floating frame that takes the large rigid motion.
!!
!! Node i is at r_i = r_0 + R rho_i, rho_i = X_i + Phi_i q, where r_0 and R are the frame's position and orientation and q
!! the modal amplitudes. Velocities are {r_0 rate in global axes, omega in the frame's axes, q rate}. With the Jacobian
!! J_i = [I, -R rho_i x, R Phi_i] of a node's velocity and [I, Psi_i] of its rotation in the frame, Eqs (23), (24) give
!!
!!     M = sum_i m_i J_i^T J_i + rotary terms,     f = sum_i J_i^T F_i - K q - centrifugal, Coriolis and gyroscopic terms.
module taut_model_modal_body
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_constrained_system, only: state_t
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_model_dead_load, only: dead_load_t
   use taut_model_pose, only: turned, turned_back
   use taut_model_posed_system, only: posed_system_t
   use taut_rotation, only: cross, matrix_of_quaternion
   implicit none (type, external)
   private
   public :: modal_body_t, modal_link_t, new_modal_body

   !> A rigid massless link from a node to a fixed point: phi = |r_node - ground| - length.
   type :: modal_link_t
      !> The node.
      integer :: node = 0
      !> The fixed point [m].
      real(wp) :: ground(3) = 0.0_wp
      !> Length of the link [m].
      real(wp) :: length = 0.0_wp
   end type modal_link_t

   !> The body. Coordinates: {r_0 (3), unit quaternion (4), q (modes)}.
   type, extends(posed_system_t) :: modal_body_t
      !> Number of shapes and of nodes.
      integer :: modes = 0, nodes = 0
      !> Nodes in the frame, undeformed: (3, nodes) [m].
      real(wp), allocatable :: position(:, :)
      !> Their masses: (nodes) [kg].
      real(wp), allocatable :: node_mass(:)
      !> Their inertia in the frame's axes: (3, 3, nodes) [kg m^2].
      real(wp), allocatable :: inertia(:, :, :)
      !> Displacement of each node by each shape: (3, modes, nodes).
      real(wp), allocatable :: shape(:, :, :)
      !> Rotation of each node by each shape: (3, modes, nodes).
      real(wp), allocatable :: rotation(:, :, :)
      !> Modal stiffness X^T K X: (modes, modes).
      real(wp), allocatable :: stiffness(:, :)
      !> Time constant of damping proportional to it [s].
      real(wp) :: damping = 0.0_wp
      !> Links to the ground.
      type(modal_link_t), allocatable :: links(:)
      !> Forces and moments on nodes.
      type(dead_load_t), allocatable :: loads(:)
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
      procedure :: breakpoints
      procedure :: node_position
      procedure :: link
   end type modal_body_t

contains

   !> A modal body; it starts with its frame on the global axes.
   subroutine new_modal_body(self, position, node_mass, inertia, shape, rotation, stiffness, error)
      !> The body.
      type(modal_body_t), intent(out) :: self
      !> Nodes in the frame: (3, nodes) [m].
      real(wp), intent(in) :: position(:, :)
      !> Masses: (nodes) [kg].
      real(wp), intent(in) :: node_mass(:)
      !> Inertia in the frame's axes: (3, 3, nodes) [kg m^2].
      real(wp), intent(in) :: inertia(:, :, :)
      !> Displacements of the shapes: (3, modes, nodes).
      real(wp), intent(in) :: shape(:, :, :)
      !> Rotations of the shapes: (3, modes, nodes).
      real(wp), intent(in) :: rotation(:, :, :)
      !> Modal stiffness: (modes, modes).
      real(wp), intent(in) :: stiffness(:, :)
      !> Sizes that do not fit.
      type(error_t), allocatable, intent(inout) :: error
      integer :: m, n

      n = size(position, 2)
      m = size(shape, 2)
      if (size(node_mass) /= n .or. size(inertia, 3) /= n .or. size(shape, 3) /= n .or. size(rotation, 3) /= n .or. &
          size(rotation, 2) /= m .or. size(stiffness, 1) /= m .or. size(stiffness, 2) /= m) then
         call raise(error, 'modal body', 'its nodes and shapes do not fit together: '//to_text(n)//' nodes, '//to_text(m)// &
                    ' shapes', 'give masses, inertias, displacements and rotations for each node, a stiffness for each shape')
         return
      end if
      if (any(node_mass < 0.0_wp) .or. .not. sum(node_mass) > 0.0_wp) then
         call raise(error, 'modal body', 'a mass is negative, or all are zero', 'give masses in kg')
         return
      end if
      self%nodes = n
      self%poses = 1
      self%numbered = .false.
      self%modes = m
      allocate (self%position, source=position)
      allocate (self%node_mass, source=node_mass)
      allocate (self%inertia, source=inertia)
      allocate (self%shape, source=shape)
      allocate (self%rotation, source=rotation)
      allocate (self%stiffness, source=stiffness)
      allocate (self%links(0), self%loads(0))
      call self%define(n=6 + m, c=0, n_x=7 + m, constant_mass=.false.)
   end subroutine new_modal_body

   !> Adds a link to the ground: one row, whose multiplier is the tension of the link.
   subroutine link(self, node, ground, length, error)
      !> The body.
      class(modal_body_t), intent(inout) :: self
      !> The node.
      integer, intent(in) :: node
      !> The fixed point [m].
      real(wp), intent(in) :: ground(3)
      !> Length [m].
      real(wp), intent(in) :: length
      !> A node that does not exist, or a length that is not positive.
      type(error_t), allocatable, intent(inout) :: error

      if (node < 1 .or. node > self%nodes) &
         call raise(error, 'modal body', 'a link names node '//to_text(node), 'name one from 1 to '//to_text(self%nodes))
      if (.not. length > 0.0_wp) &
         call raise(error, 'modal body', 'the length of a link is '//to_text(length), 'give a positive length in m')
      if (allocated(error)) return
      self%links = [self%links, modal_link_t(node, ground, length)]
      call self%define(n=6 + self%modes, c=size(self%links), n_x=7 + self%modes, constant_mass=.false.)
   end subroutine link

   !> Position of a node in the frame, rho_i = X_i + Phi_i q [m].
   pure function in_frame(self, at, i) result(rho)
      class(modal_body_t), intent(in) :: self
      type(state_t), intent(in) :: at
      integer, intent(in) :: i
      real(wp) :: rho(3)
      integer :: j

      rho = self%position(:, i)
      do j = 1, self%modes
         rho = rho + self%shape(:, j, i)*at%x(7 + j)
      end do
   end function in_frame

   !> Velocity of a node relative to the frame, Phi_i qdot [m/s].
   pure function relative_velocity(self, at, i) result(rate)
      class(modal_body_t), intent(in) :: self
      type(state_t), intent(in) :: at
      integer, intent(in) :: i
      real(wp) :: rate(3)
      integer :: j

      rate = 0.0_wp
      do j = 1, self%modes
         rate = rate + self%shape(:, j, i)*at%v(6 + j)
      end do
   end function relative_velocity

   !> Angular velocity of a node in the frame's axes, omega + Psi_i qdot [rad/s].
   pure function angular_velocity(self, at, i) result(rate)
      class(modal_body_t), intent(in) :: self
      type(state_t), intent(in) :: at
      integer, intent(in) :: i
      real(wp) :: rate(3)
      integer :: j

      rate = at%v(4:6)
      do j = 1, self%modes
         rate = rate + self%rotation(:, j, i)*at%v(6 + j)
      end do
   end function angular_velocity

   !> Position of a node [m].
   pure function node_position(self, at, i) result(r)
      !> The body.
      class(modal_body_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> The node.
      integer, intent(in) :: i
      !> In global axes.
      real(wp) :: r(3)

      r = at%x(1:3) + turned(matrix_of_quaternion(at%x(4:7)), in_frame(self, at, i))
   end function node_position

   !> Velocity of a node in global axes [m/s].
   pure function node_velocity(self, at, i) result(rate)
      class(modal_body_t), intent(in) :: self
      type(state_t), intent(in) :: at
      integer, intent(in) :: i
      real(wp) :: rate(3)

      rate = at%v(1:3) + turned(matrix_of_quaternion(at%x(4:7)), &
                                cross(at%v(4:6), in_frame(self, at, i)) + relative_velocity(self, at, i))
   end function node_velocity

   !> What is left of a node's acceleration when all rates of the velocities are zero, in the frame's axes [m/s^2].
   pure function centrifugal(self, at, i) result(h)
      class(modal_body_t), intent(in) :: self
      type(state_t), intent(in) :: at
      integer, intent(in) :: i
      real(wp) :: h(3)

      associate (omega => at%v(4:6))
         h = cross(omega, cross(omega, in_frame(self, at, i)) + 2.0_wp*relative_velocity(self, at, i))
      end associate
   end function centrifugal

   !> M = sum m_i J_i^T J_i and the rotary terms.
   subroutine mass(self, at, m)
      !> The body.
      class(modal_body_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> The mass matrix, one dense block.
      type(block_diagonal_t), intent(inout) :: m

      call assemble_mass(self, at, self%n, m%values)
   end subroutine mass

   !> The entries of M.
   pure subroutine assemble_mass(self, at, n, m)
      class(modal_body_t), intent(in) :: self
      type(state_t), intent(in) :: at
      integer, intent(in) :: n
      real(wp), intent(inout) :: m(n, n)
      real(wp) :: r(3, 3), rho(3), first_moment(3), moved(3), rotary(3), w
      integer :: i, j, k

      m = 0.0_wp
      r = matrix_of_quaternion(at%x(4:7))
      first_moment = 0.0_wp
      do i = 1, self%nodes
         w = self%node_mass(i)
         rho = in_frame(self, at, i)
         first_moment = first_moment + w*rho
         do j = 1, 3
            m(j, j) = m(j, j) + w
            m(3 + j, 3 + j) = m(3 + j, 3 + j) + w*dot_product(rho, rho)
            m(4:6, 3 + j) = m(4:6, 3 + j) + self%inertia(:, j, i) - w*rho*rho(j)
         end do
         do k = 1, self%modes
            moved = w*self%shape(:, k, i)
            rotary = turned(self%inertia(:, :, i), self%rotation(:, k, i))
            ! In the frame's axes; turned to global ones below.
            m(1:3, 6 + k) = m(1:3, 6 + k) + moved
            m(4:6, 6 + k) = m(4:6, 6 + k) + cross(rho, moved) + rotary
            do j = 1, k
               m(6 + j, 6 + k) = m(6 + j, 6 + k) + dot_product(self%shape(:, j, i), moved) + &
                                 dot_product(self%rotation(:, j, i), rotary)
            end do
         end do
      end do
      do k = 1, self%modes
         moved = m(1:3, 6 + k)
         m(1:3, 6 + k) = turned(r, moved)
      end do
      do j = 1, 3
         ! -R s x, column by column.
         m(1:3, 3 + j) = -turned(r, cross(first_moment, unit(j)))
      end do
      do j = 1, n
         do i = j + 1, n
            m(i, j) = m(j, i)
         end do
      end do
   end subroutine assemble_mass

   !> A unit vector.
   pure function unit(j) result(e)
      integer, intent(in) :: j
      real(wp) :: e(3)

      e = 0.0_wp
      e(j) = 1.0_wp
   end function unit

   !> f: loads, gravity, modal stiffness, and what the inertia forces have beside M vdot.
   subroutine force(self, at, value)
      !> The body.
      class(modal_body_t), intent(in) :: self
      !> The state; all of it may be used.
      type(state_t), intent(in) :: at
      !> f: (n).
      real(wp), intent(out) :: value(:)
      real(wp) :: factor, moment(3), omega_i(3), pushed(3), r(3, 3), rho(3)
      integer :: i, j, k

      value(:) = 0.0_wp
      r = matrix_of_quaternion(at%x(4:7))
      do i = 1, self%nodes
         rho = in_frame(self, at, i)
         pushed = self%node_mass(i)*(turned_back(r, self%gravity) - centrifugal(self, at, i))
         omega_i = angular_velocity(self, at, i)
         moment = cross(at%v(4:6), turned(self%inertia(:, :, i), omega_i))
         call add(pushed, -moment)
      end do
      do k = 1, size(self%loads)
         i = self%loads(k)%node
         rho = in_frame(self, at, i)
         factor = self%loads(k)%factor(at%t)
         moment = factor*turned_back(r, self%loads(k)%moment)
         call add(factor*turned_back(r, self%loads(k)%force), moment)
         do j = 1, self%modes
            value(6 + j) = value(6 + j) + dot_product(self%rotation(:, j, i), moment)
         end do
      end do
      pushed = value(1:3)
      pushed = turned(r, pushed)
      value(1:3) = pushed
      do j = 1, self%modes
         do k = 1, self%modes
            value(6 + k) = value(6 + k) - self%stiffness(k, j)*(at%x(7 + j) + self%damping*at%v(6 + j))
         end do
      end do

   contains

      !> A force on the node in the frame's axes, and a moment that turns the frame alone.
      subroutine add(p, turning)
         real(wp), intent(in) :: p(3), turning(3)
         integer :: l

         value(1:3) = value(1:3) + p
         value(4:6) = value(4:6) + cross(rho, p) + turning
         do l = 1, self%modes
            value(6 + l) = value(6 + l) + dot_product(self%shape(:, l, i), p)
         end do
      end subroutine add

   end subroutine force

   !> phi = |r_node - ground| - length [m].
   subroutine constraint(self, at, value)
      !> The body.
      class(modal_body_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> phi: (links).
      real(wp), intent(out) :: value(:)
      integer :: k

      do k = 1, size(self%links)
         value(k) = norm2(self%node_position(at, self%links(k)%node) - self%links(k)%ground) - self%links(k)%length
      end do
   end subroutine constraint

   !> A = n^T J_node, n along the link.
   subroutine jacobian(self, at, a)
      !> The body.
      class(modal_body_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> The constraint matrix: (links, n).
      real(wp), intent(out) :: a(:, :)
      real(wp) :: across(3), direction(3), in_axes(3)
      integer :: i, j, k

      do k = 1, size(self%links)
         i = self%links(k)%node
         direction = self%node_position(at, i) - self%links(k)%ground
         direction = direction/norm2(direction)
         in_axes = turned_back(matrix_of_quaternion(at%x(4:7)), direction)
         a(k, 1:3) = direction
         across = cross(in_frame(self, at, i), in_axes)
         do j = 1, 3
            a(k, 3 + j) = across(j)
         end do
         do j = 1, self%modes
            a(k, 6 + j) = dot_product(in_axes, self%shape(:, j, i))
         end do
      end do
   end subroutine jacobian

   !> b'' = -n . h - (|rdot|^2 - (n . rdot)^2)/|r - ground|.
   subroutine acceleration_rhs(self, at, value)
      !> The body.
      class(modal_body_t), intent(in) :: self
      !> The state; its x, v and t are used.
      type(state_t), intent(in) :: at
      !> b'': (links).
      real(wp), intent(out) :: value(:)
      real(wp) :: across(3), direction(3), length, rate(3)
      integer :: i, k

      do k = 1, size(self%links)
         i = self%links(k)%node
         direction = self%node_position(at, i) - self%links(k)%ground
         length = norm2(direction)
         direction = direction/length
         rate = node_velocity(self, at, i)
         across = cross(direction, rate)
         value(k) = -dot_product(direction, turned(matrix_of_quaternion(at%x(4:7)), centrifugal(self, at, i))) &
                    - dot_product(across, across)/length
      end do
   end subroutine acceleration_rhs

   !> Kinetic energy, strain energy of the shapes and potential of gravity [J].
   function energy(self, at)
      !> The body.
      class(modal_body_t), intent(in) :: self
      !> The state; its x and v are used.
      type(state_t), intent(in) :: at
      !> The energy.
      real(wp) :: energy
      real(wp) :: rate(3)
      integer :: i

      energy = 0.5_wp*dot_product(at%x(8:), matmul(self%stiffness, at%x(8:)))
      do i = 1, self%nodes
         rate = node_velocity(self, at, i)
         energy = energy + self%node_mass(i)*(0.5_wp*dot_product(rate, rate) - dot_product(self%gravity, self%node_position(at, i)))
         rate = angular_velocity(self, at, i)
         energy = energy + 0.5_wp*dot_product(rate, matmul(self%inertia(:, :, i), rate))
      end do
   end function energy

   !> Power of the loads, less what the damping of the shapes takes [W].
   function power(self, at)
      !> The body.
      class(modal_body_t), intent(in) :: self
      !> The state; all of it may be used.
      type(state_t), intent(in) :: at
      !> The power.
      real(wp) :: power
      real(wp) :: total(6)
      integer :: i, k

      power = -self%damping*dot_product(at%v(7:), matmul(self%stiffness, at%v(7:)))
      do k = 1, size(self%loads)
         i = self%loads(k)%node
         total = 0.0_wp
         call self%loads(k)%add_to(at%t, total)
         power = power + dot_product(total(1:3), node_velocity(self, at, i)) + &
                 dot_product(turned_back(matrix_of_quaternion(at%x(4:7)), total(4:6)), angular_velocity(self, at, i))
      end do
   end function power

   !> Kinks and jumps of the loads.
   function breakpoints(self) result(times)
      !> The body.
      class(modal_body_t), intent(in) :: self
      !> Times [s].
      real(wp), allocatable :: times(:)
      integer :: k

      allocate (times(0))
      do k = 1, size(self%loads)
         times = [times, self%loads(k)%times]
      end do
   end function breakpoints

end module taut_model_modal_body
