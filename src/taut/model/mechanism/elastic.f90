!> What of a mechanism is stiff: springs that have a stiffness, one row each, the directions of bushings that have one, a row each,
!! then the elements of beams, six rows each.
submodule(taut_model_mechanism) taut_model_mechanism_elastic
   use taut_model_beam_element, only: element_rows
   use taut_model_mechanism_body, only: turned_back
   use taut_rotation, only: cross
   implicit none (type, external)

contains

   !> Counts the elastic rows and takes their damping.
   module procedure count_elastic_rows
      integer :: i, row
      real(wp), allocatable :: tau(:)

      self%n_elastic = count(self%springs%stiffness > 0.0_wp) + 6*size(self%elements)
      do i = 1, size(self%bushings)
         self%n_elastic = self%n_elastic + count(self%bushings(i)%elastic())
      end do
      allocate (tau(self%n_elastic), source=0.0_wp)
      row = 0
      do i = 1, size(self%springs)
         if (.not. self%springs(i)%stiffness > 0.0_wp) cycle
         row = row + 1
         tau(row) = self%springs(i)%damping/self%springs(i)%stiffness
      end do
      do i = 1, size(self%bushings)
         associate (bushing => self%bushings(i), n => count(self%bushings(i)%elastic()))
            tau(row + 1:row + n) = pack(bushing%damping, bushing%elastic())/pack(bushing%stiffness, bushing%elastic())
            row = row + n
         end associate
      end do
      do i = 1, size(self%elements)
         tau(row + 1:row + 6) = self%elements(i)%element%damping
         row = row + 6
      end do
      if (any(tau > 0.0_wp)) call move_alloc(tau, self%elastic_damping)
   end procedure count_elastic_rows

   !> What soft forces couple.
   module procedure coupling
      integer :: b, body_1, body_2, i, j, k, last
      integer, allocatable :: others(:), pairs(:, :)

      ! Each body with itself, and with one other for every damper that has no stiffness.
      allocate (pairs(2, size(self%springs) + size(self%bushings)))
      last = 0
      do i = 1, size(self%springs)
         call spring_bodies(self, self%springs(i), body_1, body_2)
         if (self%springs(i)%stiffness > 0.0_wp .or. min(body_1, body_2) == 0) cycle
         last = last + 1
         pairs(:, last) = [body_1, body_2]
      end do
      do i = 1, size(self%bushings)
         associate (bushing => self%bushings(i))
            if (all(bushing%elastic() .or. .not. bushing%damping > 0.0_wp)) cycle
            if (min(bushing%body_1, bushing%body_2) == 0) cycle
            last = last + 1
            pairs(:, last) = [bushing%body_1, bushing%body_2]
         end associate
      end do
      allocate (first(self%n + 1), column(0))
      first(1) = 1
      do b = 1, size(self%bodies)
         associate (body => self%bodies(b))
            others = columns_of(self, b)
            do i = 1, last
               if (pairs(1, i) == b) others = [others, columns_of(self, pairs(2, i))]
            end do
            do k = 1, velocities_of_kind(body%kind)
               first(body%before_v + k + 1) = first(body%before_v + k) + size(others)
            end do
         end associate
      end do
      deallocate (column)
      allocate (column(first(self%n + 1) - 1))
      do b = 1, size(self%bodies)
         associate (body => self%bodies(b))
            others = columns_of(self, b)
            do i = 1, last
               if (pairs(1, i) == b) others = [others, columns_of(self, pairs(2, i))]
            end do
            do k = 1, velocities_of_kind(body%kind)
               j = body%before_v + k
               column(first(j):first(j + 1) - 1) = others
            end do
         end associate
      end do
   end procedure coupling

   !> The velocities of a body.
   pure function columns_of(self, body) result(columns)
      class(mechanism_t), intent(in) :: self
      integer, intent(in) :: body
      integer, allocatable :: columns(:)
      integer :: k

      columns = [integer ::]
      if (body > 0) columns = [(self%bodies(body)%before_v + k, k=1, velocities_of_kind(self%bodies(body)%kind))]
   end function columns_of

   !> Where the entries of B are.
   module procedure elastic_pattern
      integer, allocatable :: of_row(:)
      integer :: body_1, body_2, i, k, row

      allocate (first(self%n_elastic + 1), column(12*self%n_elastic))
      first(1) = 1
      row = 0
      do i = 1, size(self%springs)
         if (.not. self%springs(i)%stiffness > 0.0_wp) cycle
         call spring_bodies(self, self%springs(i), body_1, body_2)
         call add_row()
      end do
      do i = 1, size(self%bushings)
         body_1 = self%bushings(i)%body_1
         body_2 = self%bushings(i)%body_2
         do k = 1, count(self%bushings(i)%elastic())
            call add_row()
         end do
      end do
      do i = 1, size(self%elements)
         body_1 = self%elements(i)%body_1
         body_2 = self%elements(i)%body_2
         do k = 1, 6
            call add_row()
         end do
      end do
      column = column(:first(self%n_elastic + 1) - 1)

   contains

      !> The body with the lower number comes first.
      subroutine add_row()
         row = row + 1
         of_row = [columns_of(self, min(body_1, body_2)), columns_of(self, max(body_1, body_2))]
         first(row + 1) = first(row) + size(of_row)
         column(first(row):first(row + 1) - 1) = of_row
      end subroutine add_row

   end procedure elastic_pattern

   !> Strains and B.
   module procedure elastic_rows
      type(deformation_t) :: deformation
      type(pose_t) :: one, two
      real(wp) :: arm(3), b(12, 6), direction(3), e_1(6), e_2(6), length, rate
      integer :: body_1, body_2, i, k, last, row

      row = 0
      last = 0
      do i = 1, size(self%springs)
         associate (spring => self%springs(i))
            if (.not. spring%stiffness > 0.0_wp) cycle
            row = row + 1
            call spring_bodies(self, spring, body_1, body_2)
            call self%pose_of(at, body_1, one)
            call self%pose_of(at, body_2, two)
            call spring_motion(self, at, spring, one, two, length, rate, direction)
            strain(row) = length - spring%free + spring%damping/spring%stiffness*rate
            ! A tension pulls the first body along the direction, the second against it: the force is -B^T sigma.
            e_1 = 0.0_wp
            e_2 = 0.0_wp
            if (spring%joint > 0) then
               e_1(4:6) = -turned_back(one%r, direction)
               e_2(4:6) = turned_back(two%r, direction)
            else
               e_1(1:3) = -direction
               e_2(1:3) = direction
               arm = turned_back(one%r, direction)
               e_1(4:6) = -cross(spring%p_1, arm)
               arm = turned_back(two%r, direction)
               e_2(4:6) = cross(spring%p_2, arm)
            end if
            call put()
         end associate
      end do
      do i = 1, size(self%bushings)
         associate (bushing => self%bushings(i))
            body_1 = bushing%body_1
            body_2 = bushing%body_2
            call deform_bushing(self, at, bushing, one, two, deformation)
            call bushing%rows(one, two, deformation, b)
            do k = 1, 6
               if (.not. bushing%stiffness(k) > 0.0_wp) cycle
               row = row + 1
               strain(row) = deformation%strain(k) + bushing%damping(k)/bushing%stiffness(k)*deformation%rate(k)
               e_1 = b(1:6, k)
               e_2 = b(7:12, k)
               call put()
            end do
         end associate
      end do
      do i = 1, size(self%elements)
         body_1 = self%elements(i)%body_1
         body_2 = self%elements(i)%body_2
         associate (x_1 => self%bodies(body_1)%before_x, x_2 => self%bodies(body_2)%before_x, &
                    v_1 => self%bodies(body_1)%before_v, v_2 => self%bodies(body_2)%before_v)
            call element_rows(self%elements(i)%element, at%x(x_1 + 1:x_1 + 3), at%x(x_1 + 4:x_1 + 7), at%v(v_1 + 1:v_1 + 6), &
                              at%x(x_2 + 1:x_2 + 3), at%x(x_2 + 4:x_2 + 7), at%v(v_2 + 1:v_2 + 6), strain(row + 1:row + 6), b)
         end associate
         do k = 1, 6
            row = row + 1
            e_1 = b(1:6, k)
            e_2 = b(7:12, k)
            call put()
         end do
      end do

   contains

      !> The entries of a row, in the order of the pattern.
      subroutine put()
         if (body_1 < body_2) then
            call put_body(body_1, e_1)
            call put_body(body_2, e_2)
         else
            call put_body(body_2, e_2)
            call put_body(body_1, e_1)
         end if
      end subroutine put

      subroutine put_body(body, e)
         integer, intent(in) :: body
         real(wp), intent(in) :: e(6)
         integer :: l

         if (body == 0) return
         do l = 1, velocities_of_kind(self%bodies(body)%kind)
            last = last + 1
            values(last) = e(entry_of_velocity(l, self%bodies(body)%kind))
         end do
      end subroutine put_body

   end procedure elastic_rows

   !> Stiffness of the rows.
   module procedure elastic_stiffness
      integer :: i, n
      integer, allocatable :: sizes(:)
      real(wp), allocatable :: single(:)

      single = pack(self%springs%stiffness, self%springs%stiffness > 0.0_wp)
      do i = 1, size(self%bushings)
         single = [single, pack(self%bushings(i)%stiffness, self%bushings(i)%elastic())]
      end do
      n = size(single)
      sizes = [(1, i=1, n), (6, i=1, size(self%elements))]
      call stiffness%init(sizes)
      do i = 1, n
         call stiffness%set_block(i, reshape(single(i:i), [1, 1]))
      end do
      do i = 1, size(self%elements)
         call stiffness%set_block(n + i, self%elements(i)%element%stiffness/self%elements(i)%element%l)
      end do
   end procedure elastic_stiffness

end submodule taut_model_mechanism_elastic
