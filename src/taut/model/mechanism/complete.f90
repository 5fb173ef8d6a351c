!> Counting and checking a mechanism whose parts are all there.
submodule(taut_model_mechanism) taut_model_mechanism_complete
   use taut_error, only: raise
   use taut_model_mechanism_body, only: coordinates_of_kind
   use taut_model_mechanism_function, only: resolve_sums
   use taut_model_mechanism_joint, only: drawn_angle, has_angle, joint_rows
   implicit none (type, external)

contains

   !> Counts and checks; to be called when all is there.
   module procedure complete
      type(row_t), allocatable :: holonomic(:), rates(:)
      integer, allocatable :: blocks(:)
      integer :: i, n, n_x, nonholonomic

      if (.not. allocated(self%bodies)) allocate (self%bodies(0))
      if (.not. allocated(self%joints)) allocate (self%joints(0))
      if (.not. allocated(self%functions)) allocate (self%functions(0))
      if (.not. allocated(self%loads)) allocate (self%loads(0))
      if (.not. allocated(self%springs)) allocate (self%springs(0))
      if (.not. allocated(self%bushings)) allocate (self%bushings(0))
      if (.not. allocated(self%elements)) allocate (self%elements(0))
      if (.not. allocated(self%points)) allocate (self%points(0))
      if (.not. allocated(self%events)) allocate (self%events(0))
      if (.not. allocated(self%findings)) allocate (self%findings(0))
      if (.not. allocated(self%shown)) self%shown = [(i, i=1, size(self%joints))]
      if (.not. allocated(self%shown_springs)) allocate (self%shown_springs(0))
      if (.not. allocated(self%shown_bushings)) allocate (self%shown_bushings(0))
      if (size(self%bodies) == 0) call raise(error, here, 'it has no body', 'add a &body or a &point_mass')
      n = 0
      n_x = 0
      do i = 1, size(self%bodies)
         call self%bodies(i)%check(error)
         self%bodies(i)%before_x = n_x
         self%bodies(i)%before_v = n
         n_x = n_x + coordinates_of_kind(self%bodies(i)%kind)
         n = n + velocities_of_kind(self%bodies(i)%kind)
      end do
      do i = 1, size(self%functions)
         call self%functions(i)%check(error)
      end do
      if (.not. allocated(error)) call resolve_sums(self%functions, error)
      if (allocated(error)) return
      allocate (blocks(n), source=1)
      n = 0
      do i = 1, size(self%bodies)
         if (self%bodies(i)%diagonal()) then
            n = n + velocities_of_kind(self%bodies(i)%kind)
         else
            n = n + 4
            blocks(n) = 3
         end if
      end do
      blocks = blocks(:n)

      ! Counted first: lists that grow one by one take the square of the time.
      n = 0
      nonholonomic = 0
      do i = 1, size(self%joints)
         associate (joint => self%joints(i))
            call joint_rows(joint, self%planar, holonomic, rates, error)
            if (allocated(error)) return
            call check_drive(self, joint, error)
            joint%first = n + 1
            n = n + size(holonomic)
            joint%last = n
            joint%first_rate = nonholonomic + 1
            nonholonomic = nonholonomic + size(rates)
            joint%last_rate = nonholonomic
         end associate
      end do
      if (allocated(error)) return
      allocate (self%rows(n + nonholonomic), self%joint_of_row(n + nonholonomic))
      do i = 1, size(self%joints)
         associate (joint => self%joints(i))
            joint%first_rate = joint%first_rate + n
            joint%last_rate = joint%last_rate + n
            call joint_rows(joint, self%planar, holonomic, rates, error)
            self%rows(joint%first:joint%last) = holonomic
            self%rows(joint%first_rate:joint%last_rate) = rates
            self%joint_of_row(joint%first:joint%last) = i
            self%joint_of_row(joint%first_rate:joint%last_rate) = i
         end associate
      end do
      self%rows_with_branches = pack([(i, i=1, size(self%rows))], self%rows%has_branches)
      call find_pattern(self)
      call choose_counting(self, n_x)
      self%n_counters = size(self%counting)
      call self%define(n=sum(blocks), c=size(self%rows), nonholonomic=nonholonomic, n_x=n_x + self%n_counters, &
                       mass_blocks=blocks, constant_mass=.true.)
      call count_elastic_rows(self)
      call count_outputs(self)
      self%n_events = size(self%events)
      if (self%planar) call set_offsets(self)
   end procedure complete

   !> The joints whose turns somebody asks for, each a coordinate behind those of the bodies: in the plane those of the bodies tell
   !! them, and where an angle is driven the drive does.
   subroutine choose_counting(self, n_x)
      class(mechanism_t), intent(inout) :: self
      integer, intent(in) :: n_x
      logical :: asked(size(self%joints))
      integer :: i

      asked = .false.
      asked(self%shown) = .true.
      do i = 1, size(self%springs)
         if (self%springs(i)%joint > 0) asked(self%springs(i)%joint) = .true.
      end do
      do i = 1, size(self%events)
         if (self%events(i)%joint > 0) asked(self%events(i)%joint) = .true.
      end do
      self%counting = [integer ::]
      if (self%planar) return
      self%counting = pack([(i, i=1, size(asked))], [(asked(i) .and. has_angle(self%joints(i)) .and. &
                                                      self%joints(i)%angle_drive == 0, i=1, size(asked))])
      do i = 1, size(self%counting)
         self%joints(self%counting(i))%counter = n_x + i
      end do
   end subroutine choose_counting

   !> In the plane: what the angle of a joint is more than the difference of its bodies' angles.
   subroutine set_offsets(self)
      class(mechanism_t), intent(inout) :: self
      type(pose_t) :: one, two
      type(state_t) :: at
      integer :: i

      at = self%start_state()
      do i = 1, size(self%joints)
         associate (joint => self%joints(i))
            if (.not. has_angle(joint)) cycle
            call self%pose_of(at, joint%body_1, one)
            call self%pose_of(at, joint%body_2, two)
            joint%offset = drawn_angle(joint, one, two) - turned_by(self, joint, at%x)
         end associate
      end do
   end subroutine set_offsets

   !> A drive is not to jump.
   subroutine check_drive(self, joint, error)
      class(mechanism_t), intent(in) :: self
      type(joint_t), intent(in) :: joint
      type(error_t), allocatable, intent(inout) :: error
      integer :: drives(2), i

      drives = [joint%drive, joint%angle_drive]
      do i = 1, 2
         if (drives(i) == 0) cycle
         if (self%functions(drives(i))%jumps()) &
            call raise(error, 'joint "'//joint%name//'"', 'its drive "'//self%functions(drives(i))%name//'" jumps', &
                       'no body can follow; give the step a finish later than its start')
      end do
   end subroutine check_drive

   !> Where the entries of A are: those of the body with the lower number come first.
   subroutine find_pattern(self)
      class(mechanism_t), intent(inout) :: self
      integer :: b(2), i, k, l, side, total

      allocate (self%first(size(self%rows) + 1), self%column(12*size(self%rows)), self%source(12*size(self%rows)))
      total = 0
      do i = 1, size(self%rows)
         self%first(i) = total + 1
         b = [self%joints(self%joint_of_row(i))%body_1, self%joints(self%joint_of_row(i))%body_2]
         do k = 1, 2
            side = merge(k, 3 - k, b(1) < b(2))
            if (b(side) == 0) cycle
            associate (body => self%bodies(b(side)))
               do l = 1, velocities_of_kind(body%kind)
                  total = total + 1
                  self%column(total) = body%before_v + l
                  self%source(total) = 6*(side - 1) + entry_of_velocity(l, body%kind)
               end do
            end associate
         end do
      end do
      self%first(size(self%rows) + 1) = total + 1
      self%column = self%column(:total)
      self%source = self%source(:total)
   end subroutine find_pattern

   !> Numbers of all points, and then of the joints that are shown.
   subroutine count_outputs(self)
      class(mechanism_t), intent(inout) :: self
      integer :: i

      allocate (self%before_output(size(self%shown)))
      self%n_outputs = size(self%points)*merge(2, 3, self%planar)
      do i = 1, size(self%shown)
         self%before_output(i) = self%n_outputs
         self%n_outputs = self%n_outputs + outputs_of_joint(self, self%joints(self%shown(i)))
      end do
      self%n_outputs = self%n_outputs + 2*size(self%shown_springs) + merge(3, 6, self%planar)*size(self%shown_bushings)
   end subroutine count_outputs

end submodule taut_model_mechanism_complete
