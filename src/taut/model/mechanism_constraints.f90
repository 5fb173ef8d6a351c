!> What the joints of a mechanism demand, row by row: phi, A, b' and b''; and what they carry.
module taut_model_mechanism_constraints
   use taut_kinds, only: wp
   use taut_constrained_system, only: state_t
   use taut_model_mechanism_body, only: pose_t
   use taut_model_mechanism_parts, only: mechanism_parts_t, poses_t
   use taut_model_mechanism_row, only: row_b_prime, row_b_second, row_entries, row_t, row_value
   use taut_rotation, only: cross
   implicit none (type, external)
   private
   public :: mechanism_constraints_t

   !> The parts with their joints' equations.
   type, extends(mechanism_parts_t), abstract :: mechanism_constraints_t
   contains
      procedure :: pattern
      procedure :: constraint
      procedure :: jacobian
      procedure :: jacobian_entries
      procedure :: velocity_rhs
      procedure :: acceleration_rhs
      procedure :: reaction
   end type mechanism_constraints_t

contains

   !> g of a row.
   pure subroutine drive_of(self, row, t, g)
      class(mechanism_constraints_t), intent(in) :: self
      type(row_t), intent(in) :: row
      real(wp), intent(in) :: t
      real(wp), intent(out) :: g(3)

      g(:) = 0.0_wp
      if (row%drive > 0) call self%functions(row%drive)%evaluate(t, g)
   end subroutine drive_of

   !> The poses of the bodies of a row's joint, found anew where the joint is another one.
   pure subroutine poses_of_row(self, at, i, joint, poses, one, two)
      class(mechanism_constraints_t), intent(in) :: self
      type(state_t), intent(in) :: at
      integer, intent(in) :: i
      integer, intent(inout) :: joint
      type(poses_t), intent(inout) :: poses
      integer, intent(inout) :: one, two

      if (joint == self%joint_of_row(i)) return
      joint = self%joint_of_row(i)
      call poses%find(self, at, self%joints(joint)%body_1, self%joints(joint)%body_2, one, two)
   end subroutine poses_of_row

   !> phi, row by row.
   subroutine constraint(self, at, value)
      !> The mechanism.
      class(mechanism_constraints_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> phi: (n_phi) [m] or [-].
      real(wp), intent(out) :: value(:)
      type(poses_t) :: poses
      real(wp) :: g(3)
      integer :: i, joint, one, two

      joint = 0
      call poses%clear()
      do i = 1, self%n_phi
         call poses_of_row(self, at, i, joint, poses, one, two)
         call drive_of(self, self%rows(i), at%t, g)
         value(i) = row_value(self%rows(i), poses%it(one), poses%it(two), g)
      end do
   end subroutine constraint

   !> Where the entries of A are: compressed rows.
   subroutine pattern(self, first, column)
      !> The mechanism.
      class(mechanism_constraints_t), intent(in) :: self
      !> First entry of each row, and one past the last: (c + 1).
      integer, allocatable, intent(out) :: first(:)
      !> Column of each entry, ascending in each row.
      integer, allocatable, intent(out) :: column(:)

      first = self%first
      column = self%column
   end subroutine pattern

   !> The entries of A: each row has those of its bodies.
   subroutine jacobian_entries(self, at, values)
      !> The mechanism.
      class(mechanism_constraints_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> In the order of `pattern`.
      real(wp), intent(out) :: values(:)
      type(poses_t) :: poses
      real(wp) :: e(12), g(3)
      integer :: i, joint, k, one, two

      joint = 0
      call poses%clear()
      do i = 1, self%c
         call poses_of_row(self, at, i, joint, poses, one, two)
         call drive_of(self, self%rows(i), at%t, g)
         call row_entries(self%rows(i), poses%it(one), poses%it(two), g, e(1:6), e(7:12))
         do k = self%first(i), self%first(i + 1) - 1
            values(k) = e(self%source(k))
         end do
      end do
   end subroutine jacobian_entries

   !> A, dense; `scatter_entries` would do, with an allocation.
   subroutine jacobian(self, at, a)
      !> The mechanism.
      class(mechanism_constraints_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> The constraint matrix: (c, n).
      real(wp), intent(out) :: a(:, :)
      type(poses_t) :: poses
      real(wp) :: e(12), g(3)
      integer :: i, joint, k, one, two

      a(:, :) = 0.0_wp
      joint = 0
      call poses%clear()
      do i = 1, self%c
         call poses_of_row(self, at, i, joint, poses, one, two)
         call drive_of(self, self%rows(i), at%t, g)
         call row_entries(self%rows(i), poses%it(one), poses%it(two), g, e(1:6), e(7:12))
         do k = self%first(i), self%first(i + 1) - 1
            a(i, self%column(k)) = e(self%source(k))
         end do
      end do
   end subroutine jacobian

   !> b', row by row.
   subroutine velocity_rhs(self, at, value)
      !> The mechanism.
      class(mechanism_constraints_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> b': (c) [m/s] or [1/s].
      real(wp), intent(out) :: value(:)
      type(poses_t) :: poses
      real(wp) :: g(3)
      integer :: i, joint, one, two

      joint = 0
      call poses%clear()
      do i = 1, self%c
         value(i) = 0.0_wp
         if (self%rows(i)%drive == 0) cycle
         call poses_of_row(self, at, i, joint, poses, one, two)
         call drive_of(self, self%rows(i), at%t, g)
         value(i) = row_b_prime(self%rows(i), poses%it(one), poses%it(two), g)
      end do
   end subroutine velocity_rhs

   !> b'', row by row.
   subroutine acceleration_rhs(self, at, value)
      !> The mechanism.
      class(mechanism_constraints_t), intent(in) :: self
      !> The state; its x, v and t are used.
      type(state_t), intent(in) :: at
      !> b'': (c) [m/s^2] or [1/s^2].
      real(wp), intent(out) :: value(:)
      type(poses_t) :: poses
      real(wp) :: g(3)
      integer :: i, joint, one, two

      joint = 0
      call poses%clear()
      do i = 1, self%c
         call poses_of_row(self, at, i, joint, poses, one, two)
         call drive_of(self, self%rows(i), at%t, g)
         value(i) = row_b_second(self%rows(i), poses%it(one), poses%it(two), g)
      end do
   end subroutine acceleration_rhs

   !> Force and moment of a joint on its second body, the moment about the joint's point of that body.
   subroutine reaction(self, at, lambda, j, f, m)
      !> The mechanism.
      class(mechanism_constraints_t), intent(in) :: self
      !> The state at which it is evaluated.
      type(state_t), intent(in) :: at
      !> Multipliers: (c).
      real(wp), intent(in) :: lambda(:)
      !> Index of the joint.
      integer, intent(in) :: j
      !> Force in global axes [N].
      real(wp), intent(out) :: f(3)
      !> Moment in global axes [N m].
      real(wp), intent(out) :: m(3)
      type(pose_t) :: one, two
      real(wp) :: e_1(6), e_2(6), g(3)
      integer :: i, k

      associate (joint => self%joints(j))
         call self%pose_of(at, joint%body_1, one)
         call self%pose_of(at, joint%body_2, two)
         f = 0.0_wp
         m = 0.0_wp
         do k = 1, joint%last - joint%first + 1 + joint%last_rate - joint%first_rate + 1
            i = joint%first - 1 + k
            if (i > joint%last) i = joint%first_rate + i - joint%last - 1
            call drive_of(self, self%rows(i), at%t, g)
            call row_entries(self%rows(i), one, two, g, e_1, e_2)
            f = f - lambda(i)*e_2(1:3)
            m = m - lambda(i)*e_2(4:6)
         end do
         m = matmul(two%r, m - cross(joint%p_2, matmul(f, two%r)))
      end associate
   end subroutine reaction

end module taut_model_mechanism_constraints
