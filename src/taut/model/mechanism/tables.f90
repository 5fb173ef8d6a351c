!> What is written of a mechanism: names, reactions, points, events.
submodule(taut_model_mechanism) taut_model_mechanism_tables
   use taut_model_mechanism_body, only: body_planar
   use taut_model_mechanism_joint, only: has_angle, has_displacement, joint_displacement
   use taut_model_mechanism_row, only: row_angle, row_dot
   implicit none (type, external)

contains

   !> The number of a body by its name.
   module procedure body_index
      do i = size(self%bodies), 1, -1
         if (self%bodies(i)%name == name) return
      end do
   end procedure body_index

   !> Such as rod1.x, rod1.qa or, in the plane, rod1.angle; hinge.angle of a joint that counts its turns.
   module procedure x_name
      character(len=5), parameter :: in_space(7) = ['x    ', 'y    ', 'z    ', 'qa   ', 'qb   ', 'qc   ', 'qd   '], &
                                     in_plane(3) = ['x    ', 'y    ', 'angle']
      integer :: body, k

      k = i - (self%n_x - size(self%counting))
      if (k > 0) then
         name = self%joints(self%counting(k))%name//'.angle'
         return
      end if
      call find_body(self, i, .true., body, k)
      name = self%bodies(body)%name//'.'//trim(in_space(k))
      if (self%bodies(body)%kind == body_planar) name = self%bodies(body)%name//'.'//trim(in_plane(k))
   end procedure x_name

   !> Such as rod1.vx or rod1.wx (body axes).
   module procedure v_name
      character(len=2), parameter :: entries(6) = ['vx', 'vy', 'vz', 'wx', 'wy', 'wz']
      integer :: body, k

      call find_body(self, i, .false., body, k)
      name = self%bodies(body)%name//'.'//entries(entry_of_velocity(k, self%bodies(body)%kind))
   end procedure v_name

   !> Such as tip.x, hinge.fx, hinge.m3, hinge.angle or bumper.force.
   module procedure output_name
      character(len=2), parameter :: in_space(12) = ['fx', 'fy', 'fz', 'mx', 'my', 'mz', 'f1', 'f2', 'f3', 'm1', 'm2', 'm3'], &
                                     in_plane(6) = ['fx', 'fy', 'mz', 'f1', 'f2', 'f3']
      ! Between points, and about a joint.
      character(len=6), parameter :: of_spring(2, 2) = reshape(['force ', 'length', 'moment', 'angle '], [2, 2])
      ! Of a bushing the last six, in the plane these.
      character(len=2), parameter :: of_planar_bushing(3) = ['f1', 'f2', 'm3']
      integer :: k, n

      n = merge(2, 3, self%planar)
      if (i <= n*size(self%points)) then
         name = self%points(1 + (i - 1)/n)%name//'.'//achar(iachar('x') + modulo(i - 1, n))
         return
      end if
      n = merge(3, 6, self%planar)
      k = i - (self%n_outputs - n*size(self%shown_bushings))
      if (k > 0) then
         name = self%bushings(self%shown_bushings(1 + (k - 1)/n))%name//'.'
         k = 1 + modulo(k - 1, n)
         name = trim(name)//merge(of_planar_bushing(min(k, 3)), in_space(6 + k), self%planar)
         return
      end if
      k = k + 2*size(self%shown_springs)
      if (k > 0) then
         associate (spring => self%springs(self%shown_springs((k + 1)/2)))
            name = spring%name//'.'//trim(of_spring(2 - modulo(k, 2), merge(2, 1, spring%joint > 0)))
         end associate
         return
      end if
      n = last_before(self%before_output, i)
      k = i - self%before_output(n)
      associate (joint => self%joints(self%shown(n)))
         n = merge(6, 12, self%planar)
         if (k > n) then
            name = joint%name//'.'//trim(merge('angle       ', 'displacement', has_angle(joint) .and. k == n + 1))
         else if (self%planar) then
            name = joint%name//'.'//in_plane(k)
         else
            name = joint%name//'.'//in_space(k)
         end if
      end associate
   end procedure output_name

   !> Positions of points; reactions, angles and displacements of joints; forces and lengths of springs; forces and moments of
   !! bushings.
   module procedure outputs
      type(deformation_t) :: deformation
      type(pose_t) :: one, two
      real(wp) :: direction(3), e(3, 3), f(3), length, m(3), p(3), rate
      integer :: body_1, body_2, i, k, n

      k = 0
      n = merge(2, 3, self%planar)
      do i = 1, size(self%points)
         call self%pose_of(at, self%points(i)%body, one)
         p = one%p + matmul(one%r, self%points(i)%at)
         values(k + 1:k + n) = p(1:n)
         k = k + n
      end do
      do i = 1, size(self%shown)
         associate (joint => self%joints(self%shown(i)))
            call self%reaction(at, lambda, self%shown(i), f, m)
            call self%pose_of(at, joint%body_1, one)
            call self%pose_of(at, joint%body_2, two)
            e = matmul(one%r, joint%frame_1)
            if (self%planar) then
               values(k + 1:k + 3) = [f(1), f(2), m(3)]
               values(k + 4:k + 6) = matmul(f, e)
               k = k + 6
            else
               values(k + 1:k + 3) = f
               values(k + 4:k + 6) = m
               values(k + 7:k + 9) = matmul(f, e)
               values(k + 10:k + 12) = matmul(m, e)
               k = k + 12
            end if
            if (has_angle(joint)) then
               k = k + 1
               values(k) = self%angle_of(at, joint, one, two)
            end if
            if (has_displacement(joint)) then
               k = k + 1
               values(k) = joint_displacement(joint, one, two)
            end if
         end associate
      end do
      do i = 1, size(self%shown_springs)
         associate (spring => self%springs(self%shown_springs(i)))
            call spring_bodies(self, spring, body_1, body_2)
            call self%pose_of(at, body_1, one)
            call self%pose_of(at, body_2, two)
            call spring_motion(self, at, spring, one, two, length, rate, direction)
            values(k + 1:k + 2) = [spring_force(spring, length, rate), length]
            k = k + 2
         end associate
      end do
      do i = 1, size(self%shown_bushings)
         associate (bushing => self%bushings(self%shown_bushings(i)))
            call deform_bushing(self, at, bushing, one, two, deformation)
            ! On body 2, as a joint's: the force is against that on body 1, the moment is about its point.
            call deformation%loads(bushing%stress(deformation), f, p, m)
            f = -matmul(f, deformation%axes)
            m = matmul(m, deformation%axes)
            if (self%planar) then
               values(k + 1:k + 3) = [f(1), f(2), m(3)]
               k = k + 3
            else
               values(k + 1:k + 6) = [f, m]
               k = k + 6
            end if
         end associate
      end do
   end procedure outputs

   !> Force and moment of each joint that is shown. Its rows push along unit vectors at right angles, those of directions turn about
   !! such; where a disc rolls the force turns it too, so that its moment is not among them.
   module procedure magnitudes
      type(magnitude_t), allocatable :: all_of_them(:)
      integer, allocatable :: rows(:)
      logical, allocatable :: turns(:)
      integer :: i, j, n

      allocate (all_of_them(2*size(self%shown)))
      n = 0
      do i = 1, size(self%shown)
         associate (joint => self%joints(self%shown(i)))
            rows = [(j, j=joint%first, joint%last), (j, j=joint%first_rate, joint%last_rate)]
            turns = [(any(self%rows(rows(j))%kind == [row_dot, row_angle]), j=1, size(rows))]
            if (.not. all(turns)) call add('.force', pack(rows, .not. turns))
            if (any(turns)) call add('.moment', pack(rows, turns))
         end associate
      end do
      list = all_of_them(:n)

   contains

      subroutine add(what, its_rows)
         character(*), intent(in) :: what
         integer, intent(in) :: its_rows(:)

         n = n + 1
         all_of_them(n)%name = self%joints(self%shown(i))%name//what
         all_of_them(n)%rows = its_rows
      end subroutine add

   end procedure magnitudes

   !> Numbers of a joint: force and moment in global axes, in its own, then angle and displacement.
   module procedure outputs_of_joint
      n = merge(6, 12, self%planar)
      if (has_angle(joint)) n = n + 1
      if (has_displacement(joint)) n = n + 1
   end procedure outputs_of_joint

   !> What was found out at the start.
   module procedure quantities
      allocate (list(0))
      if (allocated(self%findings)) list = self%findings
   end procedure quantities

   !> What was found out at the start, for people.
   module procedure describe
      text = ''
      if (allocated(self%description)) text = self%description
   end procedure describe

   !> Whether there are reactions that are not unique.
   module procedure note
      text = ''
      if (allocated(self%remark)) text = self%remark
   end procedure note

   !> Name of an event.
   module procedure event_name
      name = self%events(i)%name
   end procedure event_name

   !> What is watched less its value.
   module procedure event_values
      type(pose_t) :: one, two
      real(wp) :: p(3)
      integer :: i

      do i = 1, size(self%events)
         associate (event => self%events(i))
            if (event%joint == 0) then
               call self%pose_of(at, event%body, one)
               p = one%p + matmul(one%r, event%at)
               values(i) = p(event%axis) - event%value
               cycle
            end if
            associate (joint => self%joints(event%joint))
               call self%pose_of(at, joint%body_1, one)
               call self%pose_of(at, joint%body_2, two)
               if (event%angle) then
                  values(i) = self%angle_of(at, joint, one, two) - event%value
               else
                  values(i) = joint_displacement(joint, one, two) - event%value
               end if
            end associate
         end associate
      end do
   end procedure event_values

   !> Name of the body and of its i-th coordinate or velocity.
   subroutine find_body(self, i, coordinate, body, k)
      class(mechanism_t), intent(in) :: self
      integer, intent(in) :: i
      logical, intent(in) :: coordinate
      integer, intent(out) :: body, k
      integer :: high, low

      ! The last body that begins before i.
      low = 1
      high = size(self%bodies) + 1
      do while (high - low > 1)
         body = (low + high)/2
         if (merge(self%bodies(body)%before_x, self%bodies(body)%before_v, coordinate) < i) then
            low = body
         else
            high = body
         end if
      end do
      body = low
      k = i - merge(self%bodies(body)%before_x, self%bodies(body)%before_v, coordinate)
   end subroutine find_body

   !> The last of those that begin before i.
   pure integer function last_before(before, i) result(low)
      integer, intent(in) :: before(:), i
      integer :: high, middle

      low = 1
      high = size(before) + 1
      do while (high - low > 1)
         middle = (low + high)/2
         if (before(middle) < i) then
            low = middle
         else
            high = middle
         end if
      end do
   end function last_before

end submodule taut_model_mechanism_tables
