!> A mechanism with only what moves: bodies that are welded together are one, what is welded to the ground stands still, and in the
!! plane what turns about a point of the ground has its angle alone, with its moment of inertia about that point. The rows that
!! would keep them so fall away.
submodule(taut_model_mechanism) taut_model_mechanism_reduce
   use taut_model_mechanism_body, only: body_pinned, body_planar, coordinates_of_kind
   use taut_model_mechanism_joint, only: nearest_turn
   use taut_model_mechanism_parts, only: member_t, parts_t
   use taut_model_mechanism_row, only: row_point
   use taut_rotation, only: cross, matrix_of_quaternion, quaternion_conjugate, quaternion_of_matrix, quaternion_product
   implicit none (type, external)

   !> Which bodies move together, and where each is in its part.
   type :: plan_t
      !> As `find_parts` says.
      integer, allocatable :: root(:), weld(:), pin(:), followers(:)
      !> The body of the smaller mechanism that is the part of each; 0: the ground, which is there too: (0:bodies).
      integer, allocatable :: part(:)
      !> Where the center of each is, from the point of reference of its part, and by what its axes are turned, in axes of the part:
      !! (3, 0:bodies), (3, 3, 0:bodies).
      real(wp), allocatable :: d(:, :), turn(:, :, :)
      !> The joint of the smaller mechanism that each is; 0: it is within a part: (joints).
      integer, allocatable :: joint(:)
   end type plan_t

contains

   !> The same mechanism with what moves together as one.
   module procedure reduce
      type(parts_t), allocatable :: parts
      type(mechanism_t), allocatable :: small
      type(error_t), allocatable :: error
      type(plan_t) :: plan
      integer :: i

      select type (self)
      type is (mechanism_t)
         allocate (plan%root(size(self%bodies)), plan%weld(size(self%bodies)), plan%pin(size(self%bodies)))
         call self%find_parts(plan%root, plan%weld, plan%pin, plan%followers)
         if (size(plan%followers) == 0 .and. all(plan%pin == 0)) return
         if (all(plan%root == 0)) return
         allocate (small, parts)
         call place_bodies(self, plan)
         call take_bodies(self, plan, small)
         call take_forces(self, plan, small)
         call small%complete(error)
         if (allocated(error)) return
         if (self%planar) then
            do i = 1, size(self%joints)
               if (plan%joint(i) > 0) call take_offset(self, plan, i, small%joints(plan%joint(i)))
            end do
         end if
         call find_places(self, small, plan, parts)
         call list_parts(self, small, plan, parts)
         call move_alloc(small, parts%system)
         call move_alloc(parts, reduction)
      end select
   end procedure reduce

   !> Where each body is, from the center of the first of its part, in the axes of that: welds keep frames and points together.
   subroutine place_bodies(self, plan)
      type(mechanism_t), intent(in) :: self
      type(plan_t), intent(inout) :: plan
      integer :: above, b, i, k

      associate (n => size(self%bodies))
         allocate (plan%d(3, 0:n), plan%turn(3, 3, 0:n), source=0.0_wp)
         do k = 1, 3
            plan%turn(k, k, :) = 1.0_wp
         end do
         allocate (plan%part(0:n), source=0)
         i = 0
         do b = 1, n
            if (plan%root(b) /= b) cycle
            i = i + 1
            plan%part(b) = i
         end do
      end associate
      do k = 1, size(plan%followers)
         b = plan%followers(k)
         if (plan%root(b) > 0) plan%part(b) = plan%part(plan%root(b))
         associate (it => self%joints(plan%weld(b)))
            if (it%body_2 == b) then
               above = it%body_1
               plan%turn(:, :, b) = matmul(plan%turn(:, :, above), matmul(it%frame_1, transpose(it%frame_2)))
               plan%d(:, b) = point_of(plan, above, it%p_1) - matmul(plan%turn(:, :, b), it%p_2)
            else
               above = it%body_2
               plan%turn(:, :, b) = matmul(plan%turn(:, :, above), matmul(it%frame_2, transpose(it%frame_1)))
               plan%d(:, b) = point_of(plan, above, it%p_2) - matmul(plan%turn(:, :, b), it%p_1)
            end if
         end associate
      end do
   end subroutine place_bodies

   !> A point of a body, from the point of reference of its part.
   pure function point_of(plan, body, p) result(point)
      type(plan_t), intent(in) :: plan
      integer, intent(in) :: body
      real(wp), intent(in) :: p(3)
      real(wp) :: point(3)

      point = plan%d(:, body) + matmul(plan%turn(:, :, body), p)
   end function point_of

   !> The bodies of the smaller mechanism; places are counted from their centers or from where they turn from here on.
   subroutine take_bodies(self, plan, small)
      type(mechanism_t), intent(in) :: self
      type(plan_t), intent(inout) :: plan
      type(mechanism_t), intent(inout) :: small
      real(wp) :: m(size(self%bodies)), origin(3, 0:size(self%bodies)), r(3)
      integer :: b, i, other, root

      small%planar = self%planar
      small%gravity = self%gravity
      small%bodies = pack(self%bodies, plan%root == [(b, b=1, size(plan%root))])
      m = self%bodies%m
      origin = 0.0_wp
      do i = 1, size(plan%followers)
         b = plan%followers(i)
         root = plan%root(b)
         if (root == 0) cycle
         m(root) = m(root) + self%bodies(b)%m
         origin(:, root) = origin(:, root) + self%bodies(b)%m*plan%d(:, b)
      end do
      do b = 1, size(m)
         if (plan%root(b) == b) origin(:, b) = origin(:, b)/m(b)
      end do
      do b = 1, size(m)
         root = plan%root(b)
         if (root == 0) cycle
         plan%d(:, b) = plan%d(:, b) - origin(:, root)
      end do
      do i = 1, size(plan%followers)
         b = plan%followers(i)
         root = plan%root(b)
         if (root == 0) cycle
         if (small%bodies(plan%part(root))%m < m(root)) call become_part(root)
         associate (part => small%bodies(plan%part(root)))
            part%j = part%j + matmul(plan%turn(:, :, b), matmul(self%bodies(b)%j, transpose(plan%turn(:, :, b)))) + &
                     steiner(self%bodies(b)%m, plan%d(:, b))
         end associate
      end do
      do b = 1, size(m)
         if (plan%root(b) /= b) cycle
         associate (part => small%bodies(plan%part(b)))
            if (part%m > self%bodies(b)%m) call clean(part%j)
            if (plan%pin(b) == 0) cycle
            associate (pin => self%joints(plan%pin(b)))
               if (plan%part(pin%body_1) == plan%part(b)) then
                  r = point_of(plan, pin%body_1, pin%p_1)
                  other = pin%body_2
                  call part%pin(r, point_of(plan, other, pin%p_2))
               else
                  r = point_of(plan, pin%body_2, pin%p_2)
                  other = pin%body_1
                  call part%pin(r, point_of(plan, other, pin%p_1))
               end if
            end associate
            origin(:, b) = r
         end associate
      end do
      do b = 1, size(m)
         root = plan%root(b)
         if (root == 0) cycle
         if (plan%pin(root) > 0) plan%d(:, b) = plan%d(:, b) - origin(:, root)
      end do

   contains

      !> The first body of a part, with the mass of all of it and its center.
      subroutine become_part(root)
         integer, intent(in) :: root

         associate (part => small%bodies(plan%part(root)))
            part%m = m(root)
            r = matmul(matrix_of_quaternion(part%orientation), origin(:, root))
            part%position = part%position + r
            part%velocity = part%velocity + matmul(matrix_of_quaternion(part%orientation), cross(part%spin, origin(:, root)))
            part%j = part%j + steiner(self%bodies(root)%m, plan%d(:, root))
         end associate
      end subroutine become_part

   end subroutine take_bodies

   !> The inertia of a mass beside the center.
   pure function steiner(m, d) result(j)
      real(wp), intent(in) :: m, d(3)
      real(wp) :: j(3, 3)
      integer :: i

      do i = 1, 3
         j(:, i) = -m*d(i)*d
         j(i, i) = j(i, i) + m*dot_product(d, d)
      end do
   end function steiner

   !> Products of inertia that are round-off of the moments are none.
   pure subroutine clean(j)
      real(wp), intent(inout) :: j(3, 3)
      real(wp) :: limit
      integer :: i, k

      limit = 8.0_wp*epsilon(1.0_wp)*(j(1, 1) + j(2, 2) + j(3, 3))
      do i = 1, 3
         do k = 1, i - 1
            j(i, k) = 0.5_wp*(j(i, k) + j(k, i))
            if (abs(j(i, k)) <= limit) j(i, k) = 0.0_wp
            j(k, i) = j(i, k)
         end do
      end do
   end subroutine clean

   !> What acts between parts, and on them.
   subroutine take_forces(self, plan, small)
      type(mechanism_t), intent(in) :: self
      type(plan_t), intent(inout) :: plan
      type(mechanism_t), intent(inout) :: small
      logical :: there(size(self%joints))
      integer :: i

      allocate (plan%joint(size(self%joints)), source=0)
      there = plan%part(self%joints%body_1) /= plan%part(self%joints%body_2)
      plan%joint = unpack([(i, i=1, count(there))], there, plan%joint)
      small%joints = pack(self%joints, there)
      do i = 1, size(small%joints)
         associate (it => small%joints(i))
            it%frame_1 = matmul(plan%turn(:, :, it%body_1), it%frame_1)
            it%frame_2 = matmul(plan%turn(:, :, it%body_2), it%frame_2)
            call move(it%body_1, it%p_1)
            call move(it%body_2, it%p_2)
            it%counter = 0
         end associate
      end do
      do i = 1, size(plan%pin)
         if (plan%pin(i) > 0) small%joints(plan%joint(plan%pin(i)))%pins = .true.
      end do
      small%functions = self%functions
      small%loads = pack(self%loads, plan%part(self%loads%body) > 0)
      do i = 1, size(small%loads)
         associate (it => small%loads(i))
            if (it%following) it%value = matmul(plan%turn(:, :, it%body), it%value)
            call move(it%body, it%point)
         end associate
      end do
      small%springs = pack(self%springs, [(acts(self%springs(i)), i=1, size(self%springs))])
      do i = 1, size(small%springs)
         associate (it => small%springs(i))
            if (it%joint > 0) then
               it%joint = plan%joint(it%joint)
            else
               call move(it%body_1, it%p_1)
               call move(it%body_2, it%p_2)
            end if
         end associate
      end do
      small%bushings = pack(self%bushings, plan%part(self%bushings%body_1) /= plan%part(self%bushings%body_2))
      do i = 1, size(small%bushings)
         associate (it => small%bushings(i))
            it%frame_1 = matmul(plan%turn(:, :, it%body_1), it%frame_1)
            it%frame_2 = matmul(plan%turn(:, :, it%body_2), it%frame_2)
            call move(it%body_1, it%p_1)
            call move(it%body_2, it%p_2)
         end associate
      end do
      small%elements = self%elements
      do i = 1, size(small%elements)
         small%elements(i)%body_1 = plan%part(small%elements(i)%body_1)
         small%elements(i)%body_2 = plan%part(small%elements(i)%body_2)
      end do
      ! Turns that are coordinates of the whole mechanism are so of the smaller one.
      small%shown = pack(plan%joint(self%counting), plan%joint(self%counting) > 0)

   contains

      !> A point of a body is one of its part.
      subroutine move(body, p)
         integer, intent(inout) :: body
         real(wp), intent(inout) :: p(3)

         p = point_of(plan, body, p)
         body = plan%part(body)
      end subroutine move

      !> Whether a spring acts between two parts.
      logical function acts(spring)
         type(spring_t), intent(in) :: spring

         if (spring%joint > 0) then
            acts = plan%joint(spring%joint) > 0
         else
            acts = plan%part(spring%body_1) /= plan%part(spring%body_2)
         end if
      end function acts

   end subroutine take_forces

   !> In the plane the turns of bodies are those of parts and what lies between them: a joint's angle stays what it is.
   subroutine take_offset(self, plan, i, joint)
      type(mechanism_t), intent(in) :: self
      type(plan_t), intent(in) :: plan
      integer, intent(in) :: i
      type(joint_t), intent(inout) :: joint

      associate (it => self%joints(i))
         joint%offset = it%offset + it%frame_1(3, 3)*(angle_in_part(self, plan, it%body_2) - angle_in_part(self, plan, it%body_1))
      end associate
   end subroutine take_offset

   !> By what a body in the plane is turned in its part, with its turns.
   pure real(wp) function angle_in_part(self, plan, body) result(angle)
      type(mechanism_t), intent(in) :: self
      type(plan_t), intent(in) :: plan
      integer, intent(in) :: body
      real(wp) :: drawn

      angle = 0.0_wp
      if (body == 0) return
      if (plan%weld(body) == 0 .or. self%bodies(body)%kind /= body_planar) return
      drawn = drawn_angle_of(self, body)
      if (plan%root(body) > 0) drawn = drawn - drawn_angle_of(self, plan%root(body))
      angle = nearest_turn(atan2(plan%turn(2, 1, body), plan%turn(1, 1, body)), drawn)
   end function angle_in_part

   !> The angle of a body in the plane where it is drawn.
   pure real(wp) function drawn_angle_of(self, body) result(angle)
      type(mechanism_t), intent(in) :: self
      integer, intent(in) :: body

      angle = 2.0_wp*atan2(self%bodies(body)%orientation(4), self%bodies(body)%orientation(1))
   end function drawn_angle_of

   !> Which coordinates, velocities and rows are those of the smaller mechanism.
   subroutine find_places(self, small, plan, parts)
      type(mechanism_t), intent(in) :: self, small
      type(plan_t), intent(in) :: plan
      type(parts_t), intent(inout) :: parts
      logical :: there(self%n_x), there_v(self%n), row_there(self%c)
      integer :: b, i

      there = .false.
      there_v = .false.
      do b = 1, size(plan%root)
         if (plan%root(b) /= b) cycle
         associate (it => self%bodies(b))
            there(it%before_x + 1:it%before_x + coordinates_of_kind(it%kind)) = .true.
            there_v(it%before_v + 1:it%before_v + velocities_of_kind(it%kind)) = .true.
            if (small%bodies(plan%part(b))%kind /= body_pinned) cycle
            there(it%before_x + 1:it%before_x + 2) = .false.
            there_v(it%before_v + 1:it%before_v + 2) = .false.
         end associate
      end do
      there(self%joints(self%counting)%counter) = plan%joint(self%counting) > 0
      row_there = .false.
      do i = 1, self%c
         associate (joint => plan%joint(self%joint_of_row(i)))
            if (joint > 0) row_there(i) = .not. (small%joints(joint)%pins .and. self%rows(i)%kind == row_point)
         end associate
      end do
      parts%x = pack([(i, i=1, self%n_x)], there)
      parts%v = pack([(i, i=1, self%n)], there_v)
      parts%row = pack([(i, i=1, self%c)], row_there)
      parts%idle = pack(self%joints(self%counting)%counter, plan%joint(self%counting) == 0)
   end subroutine find_places

   !> The parts of which something follows, each with its bodies, that whose axes it has first.
   subroutine list_parts(self, small, plan, parts)
      type(mechanism_t), intent(in) :: self, small
      type(plan_t), intent(in) :: plan
      type(parts_t), intent(inout) :: parts
      integer :: b, i, k, n, number(0:size(plan%root)), members(0:size(plan%root))

      members = 0
      do b = 1, size(plan%root)
         members(plan%root(b)) = members(plan%root(b)) + 1
      end do
      number = 0
      n = 0
      if (members(0) > 0) n = 1
      number(0) = n
      do b = 1, size(plan%root)
         if (members(b) == 0 .or. (members(b) == 1 .and. plan%pin(b) == 0)) cycle
         n = n + 1
         number(b) = n
      end do
      allocate (parts%parts(n))
      do b = 0, size(plan%root)
         if (number(b) == 0) cycle
         associate (part => parts%parts(number(b)))
            allocate (part%members(members(b)))
            part%kind = 0
            members(b) = 0
            if (b == 0) cycle
            associate (body => small%bodies(plan%part(b)))
               part%kind = body%kind
               part%x = body%before_x
               part%v = body%before_v
               if (body%kind == body_pinned) part%place = body%position
            end associate
            members(b) = 1
            part%members(1) = member_of(self, plan, b)
         end associate
      end do
      parts%narrows = any([(all(parts%parts(i)%kind /= [0, body_pinned]), i=1, n)])
      do i = 1, size(plan%followers)
         b = plan%followers(i)
         k = plan%root(b)
         members(k) = members(k) + 1
         parts%parts(number(k))%members(members(k)) = member_of(self, plan, b)
      end do
   end subroutine list_parts

   !> A body in its part.
   type(member_t) function member_of(self, plan, body) result(it)
      type(mechanism_t), intent(in) :: self
      type(plan_t), intent(in) :: plan
      integer, intent(in) :: body
      real(wp) :: drawn(4)

      it%kind = self%bodies(body)%kind
      it%x = self%bodies(body)%before_x
      it%v = self%bodies(body)%before_v
      it%d = plan%d(:, body)
      it%turn = plan%turn(:, :, body)
      it%angle = angle_in_part(self, plan, body)
      it%q = quaternion_of_matrix(it%turn)
      ! Of the two quaternions the one of the start.
      drawn = self%bodies(body)%orientation
      if (plan%root(body) > 0) drawn = quaternion_product(quaternion_conjugate(self%bodies(plan%root(body))%orientation), drawn)
      if (dot_product(drawn, it%q) < 0.0_wp) it%q = -it%q
   end function member_of

end submodule taut_model_mechanism_reduce
