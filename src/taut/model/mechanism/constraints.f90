!> What the joints of a mechanism demand, row by row: phi, A, b' and b''; and what they carry.
submodule(taut_model_mechanism) taut_model_mechanism_constraints
   use taut_model_mechanism_row, only: row_angle, row_b_prime, row_b_second, row_cosine, row_distance, row_dot, row_entries, &
                                        row_offset, row_point, row_value
   use taut_rotation, only: cross
   implicit none (type, external)

contains

   !> Where the entries of A are: compressed rows.
   module procedure pattern
      first = self%first
      column = self%column
   end procedure pattern

   !> Translations have odd numbers, rotations even ones.
   module procedure column_groups
      integer :: b, i

      allocate (group(self%n), source=1)
      do b = 1, size(self%bodies)
         associate (body => self%bodies(b))
            do i = 1, velocities_of_kind(body%kind)
               group(body%before_v + i) = 2*b - merge(1, 0, entry_of_velocity(i, body%kind) <= 3)
            end do
         end associate
      end do
   end procedure column_groups

   !> Lengths of the parts.
   module procedure sizes
      real(wp) :: arm
      integer :: b, i

      arm = 0.0_wp
      do i = 1, size(self%joints)
         associate (joint => self%joints(i))
            if (joint%body_1 > 0) arm = max(arm, norm2(joint%p_1))
            if (joint%body_2 > 0) arm = max(arm, norm2(joint%p_2))
            arm = max(arm, joint%length)
         end associate
      end do
      do b = 1, size(self%bodies)
         arm = max(arm, norm2(self%bodies(b)%size))
      end do
      if (.not. arm > 0.0_wp) arm = 1.0_wp
      do b = 1, size(self%bodies)
         associate (body => self%bodies(b))
            do i = 1, velocities_of_kind(body%kind)
               length(body%before_v + i) = 1.0_wp
               coordinate(body%before_v + i) = 1.0_wp
               if (entry_of_velocity(i, body%kind) > 3) cycle
               length(body%before_v + i) = arm
               coordinate(body%before_v + i) = maxval(abs(at%x(body%before_x + 1:body%before_x + merge(2, 3, self%planar))))
            end do
         end associate
      end do
   end procedure sizes

   !> A row by its joint and by what it prevents.
   module procedure row_name
      associate (it => self%rows(row), joint => self%joints(self%joint_of_row(row)))
         select case (it%kind)
         case (row_point)
            name = 'shift along '//'xyz'(maxloc(abs(it%a), 1):maxloc(abs(it%a), 1))
         case (row_offset)
            name = 'shift across its axis'
            if (abs(dot_product(it%a, joint%frame_1(:, 3))) > 0.5_wp) name = 'shift along its axis'
         case (row_dot, row_angle)
            name = 'rotation about its axis'
            if (abs(dot_product(it%b, joint%frame_2(:, 3))) > 0.5_wp) name = 'rotation across its axis'
         case (row_distance)
            name = 'distance'
         case default
            name = 'contact'
         end select
         name = joint%name//' ('//name//')'
      end associate
   end procedure row_name

   !> phi, row by row.
   module procedure constraint
      type(poses_t) :: poses
      real(wp) :: d(3), g(3)
      integer :: i, joint, one, two

      joint = 0
      call poses%clear()
      do i = 1, self%n_phi
         call poses_of_row(self, at, i, joint, poses, one, two)
         call drive_of(self, self%rows(i), at%t, g)
         call row_value(self%rows(i), poses%it(one), poses%it(two), g, d, value(i))
      end do
   end procedure constraint

   !> A, dense; `scatter_entries` would do, with an allocation.
   module procedure jacobian
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
   end procedure jacobian

   !> The entries of A: each row has those of its bodies.
   module procedure jacobian_entries
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
   end procedure jacobian_entries

   !> b', row by row.
   module procedure velocity_rhs
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
   end procedure velocity_rhs

   !> b'', row by row.
   module procedure acceleration_rhs
      type(poses_t) :: poses
      real(wp) :: c(3), g(3)
      integer :: i, joint, one, two

      joint = 0
      call poses%clear()
      do i = 1, self%c
         call poses_of_row(self, at, i, joint, poses, one, two)
         call drive_of(self, self%rows(i), at%t, g)
         call row_b_second(self%rows(i), poses%it(one), poses%it(two), g, c, value(i))
      end do
   end procedure acceleration_rhs

   !> Names the joint that is met upside down, or half a turn from what drives it.
   module procedure check_branch
      integer :: i

      i = strayed_row(self, at)
      if (i == 0) return
      associate (row => self%rows(i), joint => self%joints(self%joint_of_row(i)))
         if (row%kind == row_angle) then
            what = 'joint "'//joint%name//'" is half a turn from where its drive "'//self%functions(row%drive)%name//'" wants it'
         else
            what = 'joint "'//joint%name//'" is upside down: an axis of one body is opposite to that of the other'
         end if
      end associate
   end procedure check_branch

   !> The first joint that is on the other branch.
   module procedure strayed_joint
      joint = strayed_row(self, at)
      if (joint > 0) joint = self%joint_of_row(joint)
   end procedure strayed_joint

   !> The first row whose direction is more than 90 degrees from what it demands; 0 if there is none.
   integer function strayed_row(self, at) result(i)
      class(mechanism_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(poses_t) :: poses
      real(wp) :: g(3)
      integer :: joint, k, one, two

      joint = 0
      call poses%clear()
      do k = 1, size(self%rows_with_branches)
         i = self%rows_with_branches(k)
         call poses_of_row(self, at, i, joint, poses, one, two)
         call drive_of(self, self%rows(i), at%t, g)
         if (row_cosine(self%rows(i), poses%it(one), poses%it(two), g) < 0.0_wp) return
      end do
      i = 0
   end function strayed_row

   !> The cosine between the direction that a row demands and the one that is there.
   module procedure cosine_of_row
      type(pose_t) :: one, two
      real(wp) :: g(3)

      call self%pose_of(at, self%joints(self%joint_of_row(i))%body_1, one)
      call self%pose_of(at, self%joints(self%joint_of_row(i))%body_2, two)
      call drive_of(self, self%rows(i), at%t, g)
      cosine = row_cosine(self%rows(i), one, two, g)
   end procedure cosine_of_row

   !> Force and moment of a joint on its second body, the moment about the joint's point of that body.
   module procedure reaction
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
   end procedure reaction

   !> g of a row.
   pure subroutine drive_of(self, row, t, g)
      class(mechanism_t), intent(in) :: self
      type(row_t), intent(in) :: row
      real(wp), intent(in) :: t
      real(wp), intent(out) :: g(3)

      g(:) = 0.0_wp
      if (row%drive > 0) call self%functions(row%drive)%evaluate(t, g)
   end subroutine drive_of

   !> The poses of the bodies of a row's joint, found anew where the joint is another one.
   pure subroutine poses_of_row(self, at, i, joint, poses, one, two)
      class(mechanism_t), intent(in) :: self
      type(state_t), intent(in) :: at
      integer, intent(in) :: i
      integer, intent(inout) :: joint
      type(poses_t), intent(inout) :: poses
      integer, intent(inout) :: one, two

      if (joint == self%joint_of_row(i)) return
      joint = self%joint_of_row(i)
      call poses%find(self, at, self%joints(joint)%body_1, self%joints(joint)%body_2, one, two)
   end subroutine poses_of_row

end submodule taut_model_mechanism_constraints
