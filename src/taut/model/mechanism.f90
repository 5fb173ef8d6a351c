!> A mechanism: bodies, joints, functions of time, loads, springs and beams as one constrained system.
!!
!! Bodies and joints have numbers; 0 is the ground. What is there is added with the `add_` procedures, then `complete` counts and
!! checks. The multipliers of a joint's rows are its reactions; `outputs` gives them as forces and moments on its second body.
module taut_model_mechanism
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_constrained_system, only: mechanical_system_t, quantity_t, state_t
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_model_beam_element, only: beam_element_t, element_energy, internal_loads
   use taut_model_mechanism_body, only: body_planar, body_planar_point, body_point, body_spatial, body_t, coordinates_of_kind, &
                                        entry_of_velocity, ground_pose, point_motion, pose_t, turned, velocities_of_kind
   use taut_model_mechanism_function, only: time_function_t
   use taut_model_mechanism_joint, only: joint_angle, joint_angle_rate, joint_displacement, joint_rows, joint_t, &
                                         type_coordinate, type_cylindrical, type_distance, type_knife_edge, type_prismatic, &
                                         type_revolute, type_rolling
   use taut_model_mechanism_load, only: load_t, spring_t
   use taut_model_mechanism_row, only: row_b_prime, row_b_second, row_entries, row_t, row_value
   use taut_rotation, only: cross
   implicit none (type, external)
   private
   public :: mechanism_t, point_t, event_t, element_t

   !> A point of a body whose position is written out.
   type :: point_t
      !> What it is called.
      character(:), allocatable :: name
      !> The body (0: the ground), and where the point is in its axes [m].
      integer :: body = 0
      real(wp) :: at(3) = 0.0_wp
   end type point_t

   !> Something that passes a value.
   type :: event_t
      !> What it is called.
      character(:), allocatable :: name
      !> The joint whose angle (or, if not, displacement) is watched; 0: a coordinate of a point of a body.
      integer :: joint = 0
      logical :: angle = .true.
      integer :: body = 0, axis = 1
      real(wp) :: at(3) = 0.0_wp
      !> The value [rad] or [m].
      real(wp) :: value = 0.0_wp
   end type event_t

   !> A beam element between two bodies that are its nodes.
   type :: element_t
      integer :: body_1 = 0, body_2 = 0
      type(beam_element_t) :: element
   end type element_t

   !> The mechanism.
   type, extends(mechanical_system_t) :: mechanism_t
      !> Whether it is in the plane x-y.
      logical :: planar = .false.
      !> Gravity [m/s^2].
      real(wp) :: gravity(3) = 0.0_wp
      type(body_t), allocatable :: bodies(:)
      type(joint_t), allocatable :: joints(:)
      type(time_function_t), allocatable :: functions(:)
      type(load_t), allocatable :: loads(:)
      type(spring_t), allocatable :: springs(:)
      type(element_t), allocatable :: elements(:)
      type(point_t), allocatable :: points(:)
      type(event_t), allocatable :: events(:)
      !> Joints whose reactions are written out.
      integer, allocatable :: shown(:)
      !> What was found out at the start, for the table of the model.
      type(quantity_t), allocatable :: findings(:)
      !> Rows of all joints, those with a position level first; the joint of each; and where its entries of A are in
      !! compressed rows: the first of each row, of its body 1 and of its body 2.
      type(row_t), allocatable :: rows(:)
      integer, allocatable :: joint_of_row(:), first(:), first_1(:), first_2(:), column(:)
   contains
      procedure :: complete
      procedure :: start_state
      procedure :: pose_of
      procedure :: pattern
      procedure :: jacobian_entries
      procedure :: reaction
      procedure :: mass
      procedure :: force
      procedure :: constraint
      procedure :: jacobian
      procedure :: b_prime
      procedure :: b_second
      procedure :: x_rate
      procedure :: v_of_x_rate
      procedure :: displace
      procedure :: normalize
      procedure :: energy
      procedure :: breakpoints
      procedure :: x_name
      procedure :: v_name
      procedure :: output_name
      procedure :: outputs
      procedure :: quantities
      procedure :: event_name
      procedure :: event_values
   end type mechanism_t

   character(*), parameter :: here = 'mechanism'

contains

   !> Counts and checks; to be called when all is there.
   subroutine complete(self, error)
      !> The mechanism.
      class(mechanism_t), intent(inout) :: self
      !> Bodies or joints that make no sense.
      type(error_t), allocatable, intent(inout) :: error
      type(row_t), allocatable :: holonomic(:), rates(:), all_rates(:)
      integer, allocatable :: blocks(:), joint_of_rate(:)
      integer :: i, n, n_x

      if (.not. allocated(self%bodies)) allocate (self%bodies(0))
      if (.not. allocated(self%joints)) allocate (self%joints(0))
      if (.not. allocated(self%functions)) allocate (self%functions(0))
      if (.not. allocated(self%loads)) allocate (self%loads(0))
      if (.not. allocated(self%springs)) allocate (self%springs(0))
      if (.not. allocated(self%elements)) allocate (self%elements(0))
      if (.not. allocated(self%points)) allocate (self%points(0))
      if (.not. allocated(self%events)) allocate (self%events(0))
      if (.not. allocated(self%findings)) allocate (self%findings(0))
      if (.not. allocated(self%shown)) self%shown = [(i, i=1, size(self%joints))]
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

      allocate (self%rows(0), all_rates(0), self%joint_of_row(0), joint_of_rate(0))
      do i = 1, size(self%joints)
         associate (joint => self%joints(i))
            call joint_rows(joint, self%planar, holonomic, rates, error)
            if (allocated(error)) return
            call check_drive(self, joint, error)
            joint%first = size(self%rows) + 1
            joint%last = size(self%rows) + size(holonomic)
            joint%first_rate = size(all_rates) + 1
            joint%last_rate = size(all_rates) + size(rates)
            self%rows = [self%rows, holonomic]
            self%joint_of_row = [self%joint_of_row, spread(i, 1, size(holonomic))]
            all_rates = [all_rates, rates]
            joint_of_rate = [joint_of_rate, spread(i, 1, size(rates))]
         end associate
      end do
      do i = 1, size(self%joints)
         self%joints(i)%first_rate = self%joints(i)%first_rate + size(self%rows)
         self%joints(i)%last_rate = self%joints(i)%last_rate + size(self%rows)
      end do
      self%rows = [self%rows, all_rates]
      self%joint_of_row = [self%joint_of_row, joint_of_rate]
      call find_pattern(self)
      call self%define(n=sum(blocks), c=size(self%rows), nonholonomic=size(all_rates), n_x=n_x, &
                       mass_blocks=blocks, n_outputs=number_of_outputs(self), n_events=size(self%events))
   end subroutine complete

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

   !> Where the entries of A are.
   subroutine find_pattern(self)
      class(mechanism_t), intent(inout) :: self
      integer :: b(2), i, k, n(2), total

      associate (rows => self%rows)
         allocate (self%first(size(rows) + 1), self%first_1(size(rows)), self%first_2(size(rows)))
         total = 0
         do i = 1, size(rows)
            b = [self%joints(self%joint_of_row(i))%body_1, self%joints(self%joint_of_row(i))%body_2]
            total = total + sum([(velocities_of_body(self, b(k)), k=1, 2)])
         end do
         allocate (self%column(total))
         total = 0
         do i = 1, size(rows)
            b = [self%joints(self%joint_of_row(i))%body_1, self%joints(self%joint_of_row(i))%body_2]
            n = [(velocities_of_body(self, b(k)), k=1, 2)]
            self%first(i) = total + 1
            ! The columns of the body with the lower number come first.
            self%first_1(i) = total + 1 + merge(n(2), 0, b(2) < b(1))
            self%first_2(i) = total + 1 + merge(n(1), 0, b(1) < b(2))
            if (b(1) > 0) self%column(self%first_1(i):self%first_1(i) + n(1) - 1) = &
               [(self%bodies(b(1))%before_v + k, k=1, n(1))]
            if (b(2) > 0) self%column(self%first_2(i):self%first_2(i) + n(2) - 1) = &
               [(self%bodies(b(2))%before_v + k, k=1, n(2))]
            total = total + sum(n)
         end do
         self%first(size(rows) + 1) = total + 1
      end associate
   end subroutine find_pattern

   !> Number of velocities of a body; the ground has none.
   pure integer function velocities_of_body(self, body) result(n)
      class(mechanism_t), intent(in) :: self
      integer, intent(in) :: body

      n = 0
      if (body > 0) n = velocities_of_kind(self%bodies(body)%kind)
   end function velocities_of_body

   !> The state at the start as given, t = 0.
   function start_state(self) result(at)
      !> The mechanism and its state.
      class(mechanism_t), intent(in) :: self
      type(state_t) :: at
      integer :: i

      allocate (at%x(self%n_x), at%v(self%n), at%w(0), source=0.0_wp)
      do i = 1, size(self%bodies)
         call self%bodies(i)%start(at%x, at%v)
      end do
   end function start_state

   !> Where a body is and how it moves.
   pure subroutine pose_of(self, at, body, it)
      !> The mechanism and its state.
      class(mechanism_t), intent(in) :: self
      type(state_t), intent(in) :: at
      !> The body; 0 is the ground.
      integer, intent(in) :: body
      !> Its pose.
      type(pose_t), intent(out) :: it

      if (body == 0) then
         call ground_pose(it)
      else
         call self%bodies(body)%pose(at%x, at%v, it)
      end if
   end subroutine pose_of

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
   pure subroutine poses_of_row(self, at, i, joint, one, two)
      class(mechanism_t), intent(in) :: self
      type(state_t), intent(in) :: at
      integer, intent(in) :: i
      integer, intent(inout) :: joint
      type(pose_t), intent(inout) :: one, two

      if (joint == self%joint_of_row(i)) return
      joint = self%joint_of_row(i)
      call self%pose_of(at, self%joints(joint)%body_1, one)
      call self%pose_of(at, self%joints(joint)%body_2, two)
   end subroutine poses_of_row

   !> M: mass and inertia of each body.
   subroutine mass(self, at, m)
      !> The mechanism and its state.
      class(mechanism_t), intent(in) :: self
      type(state_t), intent(in) :: at
      !> The mass matrix.
      type(block_diagonal_t), intent(inout) :: m
      real(wp) :: d(self%n)
      integer :: b, i, k

      do i = 1, size(self%bodies)
         associate (body => self%bodies(i))
            do k = 1, velocities_of_kind(body%kind)
               associate (entry => entry_of_velocity(k, body%kind))
                  d(body%before_v + k) = body%m
                  if (entry > 3) d(body%before_v + k) = body%j(entry - 3, entry - 3)
               end associate
            end do
         end associate
      end do
      call m%set_diagonal(d)
      b = 0
      do i = 1, size(self%bodies)
         b = b + merge(velocities_of_kind(self%bodies(i)%kind), 4, self%bodies(i)%diagonal())
         if (.not. self%bodies(i)%diagonal()) call m%set_block(b, self%bodies(i)%j)
      end do
      associate (unused_state => at)
      end associate
   end subroutine mass

   !> f: gravity, gyroscopic moments, loads, springs and dampers, beams.
   subroutine force(self, at, value)
      !> The mechanism and its state.
      class(mechanism_t), intent(in) :: self
      type(state_t), intent(in) :: at
      !> f: (n).
      real(wp), intent(out) :: value(:)
      integer :: i

      do i = 1, size(self%bodies)
         call self%bodies(i)%inertial_force(self%gravity, at%v, value)
      end do
      do i = 1, size(self%loads)
         call add_load(self, self%loads(i), at, value)
      end do
      do i = 1, size(self%springs)
         call add_spring(self, self%springs(i), at, value)
      end do
      do i = 1, size(self%elements)
         call add_element(self, self%elements(i), at, value)
      end do
   end subroutine force

   !> Adds a force or a moment.
   subroutine add_load(self, load, at, f)
      class(mechanism_t), intent(in) :: self
      type(load_t), intent(in) :: load
      type(state_t), intent(in) :: at
      real(wp), intent(inout) :: f(:)
      type(pose_t) :: it
      real(wp) :: g(3), value(3)
      integer :: i

      call self%pose_of(at, load%body, it)
      g(1) = 1.0_wp
      if (load%factor > 0) call self%functions(load%factor)%evaluate(at%t, g)
      value = load%value
      if (load%following) value = turned(it%r, load%value)
      do i = 1, 3
         value(i) = g(1)*value(i)
      end do
      if (load%moment) then
         call self%bodies(load%body)%add_moment(it, value, f)
      else
         call self%bodies(load%body)%add_force(it, load%point, value, f)
      end if
   end subroutine add_load

   !> Length or angle of a spring, its rate, and the direction from point 1 to point 2 or of the axis.
   pure subroutine spring_motion(self, spring, one, two, length, rate, direction)
      class(mechanism_t), intent(in) :: self
      type(spring_t), intent(in) :: spring
      type(pose_t), intent(in) :: one, two
      real(wp), intent(out) :: length, rate, direction(3)
      real(wp), parameter :: turn = 2.0_wp*acos(-1.0_wp)
      real(wp) :: v_1(3), v_2(3), x_1(3), x_2(3)
      integer :: i

      if (spring%joint > 0) then
         associate (joint => self%joints(spring%joint))
            ! Within half a turn of the free angle.
            length = joint_angle(joint, one, two)
            length = length - turn*anint((length - spring%free)/turn)
            rate = joint_angle_rate(joint, one, two)
            direction = turned(one%r, joint%frame_1(:, 3))
         end associate
         return
      end if
      call point_motion(one, spring%p_1, x_1, v_1)
      call point_motion(two, spring%p_2, x_2, v_2)
      length = sqrt((x_2(1) - x_1(1))**2 + (x_2(2) - x_1(2))**2 + (x_2(3) - x_1(3))**2)
      rate = 0.0_wp
      do i = 1, 3
         direction(i) = x_2(i) - x_1(i)
         if (length > 0.0_wp) direction(i) = direction(i)/length
         rate = rate + direction(i)*(v_2(i) - v_1(i))
      end do
   end subroutine spring_motion

   !> The bodies of a spring.
   pure subroutine spring_bodies(self, spring, body_1, body_2)
      class(mechanism_t), intent(in) :: self
      type(spring_t), intent(in) :: spring
      integer, intent(out) :: body_1, body_2

      body_1 = spring%body_1
      body_2 = spring%body_2
      if (spring%joint == 0) return
      body_1 = self%joints(spring%joint)%body_1
      body_2 = self%joints(spring%joint)%body_2
   end subroutine spring_bodies

   !> Adds a spring's forces or moments.
   subroutine add_spring(self, spring, at, f)
      class(mechanism_t), intent(in) :: self
      type(spring_t), intent(in) :: spring
      type(state_t), intent(in) :: at
      real(wp), intent(inout) :: f(:)
      type(pose_t) :: one, two
      real(wp) :: back(3), direction(3), length, pull(3), rate, tension
      integer :: i
      integer :: body_1, body_2

      call spring_bodies(self, spring, body_1, body_2)
      call self%pose_of(at, body_1, one)
      call self%pose_of(at, body_2, two)
      call spring_motion(self, spring, one, two, length, rate, direction)
      tension = spring%preload + spring%stiffness*(length - spring%free) + spring%damping*rate
      do i = 1, 3
         pull(i) = tension*direction(i)
         back(i) = -pull(i)
      end do
      if (spring%joint > 0) then
         if (body_1 > 0) call self%bodies(body_1)%add_moment(one, pull, f)
         if (body_2 > 0) call self%bodies(body_2)%add_moment(two, back, f)
      else
         if (body_1 > 0) call self%bodies(body_1)%add_force(one, spring%p_1, pull, f)
         if (body_2 > 0) call self%bodies(body_2)%add_force(two, spring%p_2, back, f)
      end if
   end subroutine add_spring

   !> Adds a beam element's forces and moments.
   subroutine add_element(self, one, at, f)
      class(mechanism_t), intent(in) :: self
      type(element_t), intent(in) :: one
      type(state_t), intent(in) :: at
      real(wp), intent(inout) :: f(:)
      real(wp), parameter :: center(3) = 0.0_wp
      type(pose_t) :: first, second
      real(wp) :: f_1(3), m_1(3), m_2(3)
      integer :: i

      associate (body_1 => self%bodies(one%body_1), body_2 => self%bodies(one%body_2))
         associate (x_1 => body_1%before_x, x_2 => body_2%before_x, v_1 => body_1%before_v, v_2 => body_2%before_v)
            call internal_loads(one%element, at%x(x_1 + 1:x_1 + 3), at%x(x_1 + 4:x_1 + 7), at%v(v_1 + 1:v_1 + 6), &
                                at%x(x_2 + 1:x_2 + 3), at%x(x_2 + 4:x_2 + 7), at%v(v_2 + 1:v_2 + 6), f_1, m_1, m_2)
         end associate
         call body_1%pose(at%x, at%v, first)
         call body_2%pose(at%x, at%v, second)
         call body_1%add_force(first, center, f_1, f)
         call body_1%add_moment(first, m_1, f)
         do i = 1, 3
            f_1(i) = -f_1(i)
         end do
         call body_2%add_force(second, center, f_1, f)
         call body_2%add_moment(second, m_2, f)
      end associate
   end subroutine add_element

   !> phi, row by row.
   subroutine constraint(self, at, value)
      !> The mechanism and its state.
      class(mechanism_t), intent(in) :: self
      type(state_t), intent(in) :: at
      !> phi: (n_phi) [m] or [-].
      real(wp), intent(out) :: value(:)
      type(pose_t) :: one, two
      real(wp) :: g(3)
      integer :: i, joint

      joint = 0
      do i = 1, self%n_phi
         call poses_of_row(self, at, i, joint, one, two)
         call drive_of(self, self%rows(i), at%t, g)
         value(i) = row_value(self%rows(i), one, two, g)
      end do
   end subroutine constraint

   !> Where the entries of A are: compressed rows.
   subroutine pattern(self, first, column)
      !> The mechanism.
      class(mechanism_t), intent(in) :: self
      !> First entry of each row, and one past the last: (c + 1).
      integer, allocatable, intent(out) :: first(:)
      !> Column of each entry, ascending in each row.
      integer, allocatable, intent(out) :: column(:)

      first = self%first
      column = self%column
   end subroutine pattern

   !> The entries of one row of A, in the order of its columns.
   pure subroutine row_of_matrix(self, at, i, joint, one, two, entries)
      class(mechanism_t), intent(in) :: self
      type(state_t), intent(in) :: at
      integer, intent(in) :: i
      integer, intent(inout) :: joint
      type(pose_t), intent(inout) :: one, two
      real(wp), intent(inout) :: entries(12)
      real(wp) :: e_1(6), e_2(6), g(3)
      integer :: before, k, kind

      call poses_of_row(self, at, i, joint, one, two)
      call drive_of(self, self%rows(i), at%t, g)
      call row_entries(self%rows(i), one, two, g, e_1, e_2)
      associate (body_1 => self%joints(joint)%body_1, body_2 => self%joints(joint)%body_2)
         if (body_1 > 0) then
            kind = self%bodies(body_1)%kind
            before = self%first_1(i) - self%first(i)
            do k = 1, velocities_of_kind(kind)
               entries(before + k) = e_1(entry_of_velocity(k, kind))
            end do
         end if
         if (body_2 > 0) then
            kind = self%bodies(body_2)%kind
            before = self%first_2(i) - self%first(i)
            do k = 1, velocities_of_kind(kind)
               entries(before + k) = e_2(entry_of_velocity(k, kind))
            end do
         end if
      end associate
   end subroutine row_of_matrix

   !> The entries of A: each row has those of its bodies.
   subroutine jacobian_entries(self, at, values)
      !> The mechanism and its state.
      class(mechanism_t), intent(in) :: self
      type(state_t), intent(in) :: at
      !> In the order of `pattern`.
      real(wp), intent(out) :: values(:)
      type(pose_t) :: one, two
      real(wp) :: entries(12)
      integer :: i, joint, k

      joint = 0
      do i = 1, self%c
         call row_of_matrix(self, at, i, joint, one, two, entries)
         do k = self%first(i), self%first(i + 1) - 1
            values(k) = entries(k - self%first(i) + 1)
         end do
      end do
   end subroutine jacobian_entries

   !> A, dense; `scatter_entries` would do, with an allocation.
   subroutine jacobian(self, at, a)
      !> The mechanism and its state.
      class(mechanism_t), intent(in) :: self
      type(state_t), intent(in) :: at
      !> The constraint matrix: (c, n).
      real(wp), intent(out) :: a(:, :)
      type(pose_t) :: one, two
      real(wp) :: entries(12)
      integer :: i, joint, k

      a(:, :) = 0.0_wp
      joint = 0
      do i = 1, self%c
         call row_of_matrix(self, at, i, joint, one, two, entries)
         do k = self%first(i), self%first(i + 1) - 1
            a(i, self%column(k)) = entries(k - self%first(i) + 1)
         end do
      end do
   end subroutine jacobian

   !> b', row by row.
   subroutine b_prime(self, at, value)
      !> The mechanism and its state.
      class(mechanism_t), intent(in) :: self
      type(state_t), intent(in) :: at
      !> b': (c) [m/s] or [1/s].
      real(wp), intent(out) :: value(:)
      type(pose_t) :: one, two
      real(wp) :: g(3)
      integer :: i, joint

      joint = 0
      do i = 1, self%c
         value(i) = 0.0_wp
         if (self%rows(i)%drive == 0) cycle
         call poses_of_row(self, at, i, joint, one, two)
         call drive_of(self, self%rows(i), at%t, g)
         value(i) = row_b_prime(self%rows(i), one, two, g)
      end do
   end subroutine b_prime

   !> b'', row by row.
   subroutine b_second(self, at, value)
      !> The mechanism and its state.
      class(mechanism_t), intent(in) :: self
      type(state_t), intent(in) :: at
      !> b'': (c) [m/s^2] or [1/s^2].
      real(wp), intent(out) :: value(:)
      type(pose_t) :: one, two
      real(wp) :: g(3)
      integer :: i, joint

      joint = 0
      do i = 1, self%c
         call poses_of_row(self, at, i, joint, one, two)
         call drive_of(self, self%rows(i), at%t, g)
         value(i) = row_b_second(self%rows(i), one, two, g)
      end do
   end subroutine b_second

   !> xdot, body by body.
   subroutine x_rate(self, at, u, value)
      !> The mechanism and its state; velocities (n); xdot (n_x).
      class(mechanism_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: u(:)
      real(wp), intent(out) :: value(:)
      integer :: i

      do i = 1, size(self%bodies)
         call self%bodies(i)%rate(at%x, u, value)
      end do
   end subroutine x_rate

   !> The inverse of `x_rate`.
   subroutine v_of_x_rate(self, at, rate, u)
      !> The mechanism and its state; xdot (n_x); velocities (n).
      class(mechanism_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: rate(:)
      real(wp), intent(out) :: u(:)
      integer :: i

      do i = 1, size(self%bodies)
         call self%bodies(i)%velocity_of_rate(at%x, rate, u)
      end do
   end subroutine v_of_x_rate

   !> x := x (+) d, body by body.
   subroutine displace(self, d, x)
      !> The mechanism; displacement (n); coordinates (n_x).
      class(mechanism_t), intent(in) :: self
      real(wp), intent(in) :: d(:)
      real(wp), intent(inout) :: x(:)
      integer :: i

      do i = 1, size(self%bodies)
         call self%bodies(i)%move(d, x)
      end do
   end subroutine displace

   !> Quaternions of length one.
   subroutine normalize(self, x)
      !> The mechanism, and its coordinates (n_x).
      class(mechanism_t), intent(in) :: self
      real(wp), intent(inout) :: x(:)
      integer :: i

      do i = 1, size(self%bodies)
         call self%bodies(i)%normalize(x)
      end do
   end subroutine normalize

   !> Kinetic energy, and the potential of gravity (zero at the origin), springs and beams; loads have no part in it.
   function energy(self, at)
      !> The mechanism and its state.
      class(mechanism_t), intent(in) :: self
      type(state_t), intent(in) :: at
      !> The energy [J].
      real(wp) :: energy
      type(pose_t) :: one, two
      real(wp) :: direction(3), length, rate
      integer :: body_1, body_2, i

      energy = 0.0_wp
      do i = 1, size(self%bodies)
         call self%bodies(i)%pose(at%x, at%v, one)
         energy = energy + self%bodies(i)%kinetic_energy(at%v) - self%bodies(i)%m*dot_product(self%gravity, one%p)
      end do
      do i = 1, size(self%springs)
         associate (spring => self%springs(i))
            call spring_bodies(self, spring, body_1, body_2)
            call self%pose_of(at, body_1, one)
            call self%pose_of(at, body_2, two)
            call spring_motion(self, spring, one, two, length, rate, direction)
            energy = energy + spring%preload*(length - spring%free) + 0.5_wp*spring%stiffness*(length - spring%free)**2
         end associate
      end do
      do i = 1, size(self%elements)
         associate (x_1 => self%bodies(self%elements(i)%body_1)%before_x, x_2 => self%bodies(self%elements(i)%body_2)%before_x)
            energy = energy + element_energy(self%elements(i)%element, at%x(x_1 + 1:x_1 + 3), at%x(x_1 + 4:x_1 + 7), &
                                             at%x(x_2 + 1:x_2 + 3), at%x(x_2 + 4:x_2 + 7))
         end associate
      end do
   end function energy

   !> Times at which a function is not smooth.
   function breakpoints(self) result(times)
      !> The mechanism; times in any order [s].
      class(mechanism_t), intent(in) :: self
      real(wp), allocatable :: times(:)
      integer :: i

      allocate (times(0))
      do i = 1, size(self%functions)
         times = [times, self%functions(i)%breakpoints()]
      end do
   end function breakpoints

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

   !> Such as rod1.x, rod1.qa or, in the plane, rod1.angle.
   function x_name(self, i) result(name)
      !> The mechanism, and the index of the coordinate.
      class(mechanism_t), intent(in) :: self
      integer, intent(in) :: i
      !> The name.
      character(:), allocatable :: name
      character(len=5), parameter :: in_space(7) = ['x    ', 'y    ', 'z    ', 'qa   ', 'qb   ', 'qc   ', 'qd   '], &
                                     in_plane(3) = ['x    ', 'y    ', 'angle']
      integer :: body, k

      call find_body(self, i, .true., body, k)
      name = self%bodies(body)%name//'.'//trim(in_space(k))
      if (self%bodies(body)%kind == body_planar) name = self%bodies(body)%name//'.'//trim(in_plane(k))
   end function x_name

   !> Such as rod1.vx or rod1.wx (body axes).
   function v_name(self, i) result(name)
      !> The mechanism, and the index of the velocity.
      class(mechanism_t), intent(in) :: self
      integer, intent(in) :: i
      !> The name.
      character(:), allocatable :: name
      character(len=2), parameter :: entries(6) = ['vx', 'vy', 'vz', 'wx', 'wy', 'wz']
      integer :: body, k

      call find_body(self, i, .false., body, k)
      name = self%bodies(body)%name//'.'//entries(entry_of_velocity(k, self%bodies(body)%kind))
   end function v_name

   !> Whether a joint has an angle or a displacement to be shown.
   pure logical function has_angle(joint)
      type(joint_t), intent(in) :: joint

      has_angle = any(joint%type == [type_revolute, type_cylindrical])
   end function has_angle

   pure logical function has_displacement(joint)
      type(joint_t), intent(in) :: joint

      has_displacement = any(joint%type == [type_prismatic, type_cylindrical, type_distance, type_coordinate])
   end function has_displacement

   !> Numbers of a joint: force and moment in global axes, in its own, then angle and displacement.
   pure integer function outputs_of_joint(self, joint) result(n)
      class(mechanism_t), intent(in) :: self
      type(joint_t), intent(in) :: joint

      n = merge(6, 12, self%planar)
      if (has_angle(joint)) n = n + 1
      if (has_displacement(joint)) n = n + 1
   end function outputs_of_joint

   !> Numbers of all points and joints that are shown.
   pure integer function number_of_outputs(self) result(n)
      class(mechanism_t), intent(in) :: self
      integer :: i

      n = size(self%points)*merge(2, 3, self%planar)
      do i = 1, size(self%shown)
         n = n + outputs_of_joint(self, self%joints(self%shown(i)))
      end do
   end function number_of_outputs

   !> Such as tip.x, hinge.fx, hinge.m3 or hinge.angle.
   function output_name(self, i) result(name)
      !> The mechanism, and the index of the output.
      class(mechanism_t), intent(in) :: self
      integer, intent(in) :: i
      !> The name.
      character(:), allocatable :: name
      character(len=2), parameter :: in_space(12) = ['fx', 'fy', 'fz', 'mx', 'my', 'mz', 'f1', 'f2', 'f3', 'm1', 'm2', 'm3'], &
                                     in_plane(6) = ['fx', 'fy', 'mz', 'f1', 'f2', 'f3']
      integer :: j, k, n

      n = merge(2, 3, self%planar)
      k = i
      name = ''
      if (k <= n*size(self%points)) then
         name = self%points(1 + (k - 1)/n)%name//'.'//achar(iachar('x') + modulo(k - 1, n))
         return
      end if
      k = k - n*size(self%points)
      do j = 1, size(self%shown)
         associate (joint => self%joints(self%shown(j)))
            n = outputs_of_joint(self, joint)
            if (k > n) then
               k = k - n
               cycle
            end if
            n = merge(6, 12, self%planar)
            if (k > n) then
               name = joint%name//'.'//trim(merge('angle       ', 'displacement', has_angle(joint) .and. k == n + 1))
            else if (self%planar) then
               name = joint%name//'.'//in_plane(k)
            else
               name = joint%name//'.'//in_space(k)
            end if
            return
         end associate
      end do
   end function output_name

   !> Force and moment of a joint on its second body, the moment about the joint's point of that body.
   subroutine reaction(self, at, lambda, j, f, m)
      !> The mechanism and its state.
      class(mechanism_t), intent(in) :: self
      type(state_t), intent(in) :: at
      !> Multipliers: (c).
      real(wp), intent(in) :: lambda(:)
      !> Index of the joint.
      integer, intent(in) :: j
      !> In global axes [N], [N m].
      real(wp), intent(out) :: f(3), m(3)
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

   !> Positions of points; reactions, angles and displacements of joints.
   subroutine outputs(self, at, lambda, values)
      !> The mechanism and its state.
      class(mechanism_t), intent(in) :: self
      type(state_t), intent(in) :: at
      !> Multipliers: (c).
      real(wp), intent(in) :: lambda(:)
      !> In the order of their names: (n_outputs).
      real(wp), intent(out) :: values(:)
      type(pose_t) :: one, two
      real(wp) :: e(3, 3), f(3), m(3), p(3)
      integer :: i, k, n

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
               values(k) = joint_angle(joint, one, two)
            end if
            if (has_displacement(joint)) then
               k = k + 1
               values(k) = joint_displacement(joint, one, two)
            end if
         end associate
      end do
   end subroutine outputs

   !> What was found out at the start.
   function quantities(self) result(list)
      !> The mechanism.
      class(mechanism_t), intent(in) :: self
      !> The table.
      type(quantity_t), allocatable :: list(:)

      allocate (list(0))
      if (allocated(self%findings)) list = self%findings
   end function quantities

   !> Name of an event.
   function event_name(self, i) result(name)
      !> The mechanism, and the index of the event.
      class(mechanism_t), intent(in) :: self
      integer, intent(in) :: i
      !> The name.
      character(:), allocatable :: name

      name = self%events(i)%name
   end function event_name

   !> What is watched less its value.
   subroutine event_values(self, at, values)
      !> The mechanism and its state.
      class(mechanism_t), intent(in) :: self
      type(state_t), intent(in) :: at
      !> Differences: (n_events).
      real(wp), intent(out) :: values(:)
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
                  ! Zero also half a turn away: a turn has no beginning.
                  values(i) = sin(joint_angle(joint, one, two) - event%value)
               else
                  values(i) = joint_displacement(joint, one, two) - event%value
               end if
            end associate
         end associate
      end do
   end subroutine event_values

end module taut_model_mechanism
