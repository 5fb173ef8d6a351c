!> The parts of a mechanism: bodies, joints, functions of time, loads, springs and beams, counted and named; and what each body
!! has alone: mass, coordinates, pose.
!!
!! Bodies and joints have numbers; 0 is the ground. All parts are set, then `complete` counts and checks.
module taut_model_mechanism_parts
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise
   use taut_constrained_system, only: state_t
   use taut_constrained_system_tables, only: quantity_t, tabulated_system_t
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_model_beam_element, only: beam_element_t
   use taut_model_mechanism_body, only: body_planar, body_t, coordinates_of_kind, entry_of_velocity, ground_pose, pose_t, &
                                        velocities_of_kind
   use taut_model_mechanism_function, only: time_function_t
   use taut_model_mechanism_joint, only: has_angle, has_displacement, joint_rows, joint_t
   use taut_model_mechanism_load, only: load_t, spring_t
   use taut_model_mechanism_row, only: row_t
   implicit none (type, external)
   private
   public :: mechanism_parts_t, point_t, event_t, element_t, poses_t, outputs_of_joint

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

   !> Places for poses of bodies at one state, and one more.
   integer, parameter :: places = 64

   !> Poses found so far at one state: bodies whose numbers differ by a multiple of `places` share a place. To be cleared first.
   type :: poses_t
      type(pose_t) :: it(0:places)
      integer, private :: body(0:places)
   contains
      procedure :: clear
      procedure :: find
   end type poses_t

   !> All parts, and the pattern of A that follows from them.
   type, extends(tabulated_system_t), abstract :: mechanism_parts_t
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
      !> The same for people, in lines, and what a reader of the results has to know.
      character(:), allocatable :: description, remark
      !> Rows of all joints, those with a position level first; the joint of each.
      type(row_t), allocatable :: rows(:)
      integer, allocatable :: joint_of_row(:)
      !> The entries of A in compressed rows: the first of each row (c + 1), their columns, and which of the twelve of body 1 and
      !! body 2 each is.
      integer, allocatable :: first(:), column(:), source(:)
   contains
      procedure :: complete
      procedure :: start_state
      procedure :: pose_of
      procedure :: mass
      procedure :: x_rate
      procedure :: v_of_x_rate
      procedure :: displace
      procedure :: normalize
      procedure :: breakpoints
      procedure :: x_name
      procedure :: v_name
   end type mechanism_parts_t

   character(*), parameter :: here = 'mechanism'

contains

   !> Counts and checks; to be called when all is there.
   subroutine complete(self, error)
      !> The mechanism.
      class(mechanism_parts_t), intent(inout) :: self
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
                       mass_blocks=blocks)
      self%n_outputs = number_of_outputs(self)
      self%n_events = size(self%events)
   end subroutine complete

   !> A drive is not to jump.
   subroutine check_drive(self, joint, error)
      class(mechanism_parts_t), intent(in) :: self
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
      class(mechanism_parts_t), intent(inout) :: self
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

   !> Forgets all poses.
   pure subroutine clear(self)
      !> Poses.
      class(poses_t), intent(inout) :: self

      self%body = -1
   end subroutine clear

   !> The places of the poses of two bodies, computed where they are not there.
   pure subroutine find(self, model, at, body_1, body_2, one, two)
      !> Poses at this state.
      class(poses_t), intent(inout) :: self
      !> The mechanism and its state.
      class(mechanism_parts_t), intent(in) :: model
      !> The state at which it is evaluated.
      type(state_t), intent(in) :: at
      !> One body; 0 is the ground.
      integer, intent(in) :: body_1
      !> The other body.
      integer, intent(in) :: body_2
      !> Place of the pose of the one.
      integer, intent(out) :: one
      !> Place of the pose of the other.
      integer, intent(out) :: two

      one = iand(body_1, places - 1)
      two = iand(body_2, places - 1)
      if (one == two) two = places
      if (self%body(one) /= body_1) then
         self%body(one) = body_1
         call model%pose_of(at, body_1, self%it(one))
      end if
      if (self%body(two) /= body_2) then
         self%body(two) = body_2
         call model%pose_of(at, body_2, self%it(two))
      end if
   end subroutine find

   !> The state at the start as given, t = 0.
   function start_state(self) result(at)
      !> The mechanism.
      class(mechanism_parts_t), intent(in) :: self
      !> The state at which it is evaluated.
      type(state_t) :: at
      integer :: i

      allocate (at%x(self%n_x), at%v(self%n), at%w(0), source=0.0_wp)
      do i = 1, size(self%bodies)
         call self%bodies(i)%start(at%x, at%v)
      end do
   end function start_state

   !> Where a body is and how it moves.
   pure subroutine pose_of(self, at, body, it)
      !> The mechanism.
      class(mechanism_parts_t), intent(in) :: self
      !> The state at which it is evaluated.
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

   !> M: mass and inertia of each body.
   subroutine mass(self, at, m)
      !> The mechanism.
      class(mechanism_parts_t), intent(in) :: self
      !> The state; its x and t are used.
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

   !> xdot, body by body.
   subroutine x_rate(self, at, u, value)
      !> The mechanism.
      class(mechanism_parts_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> Velocities: (n).
      real(wp), intent(in) :: u(:)
      !> xdot: (n_x).
      real(wp), intent(out) :: value(:)
      integer :: i

      do i = 1, size(self%bodies)
         call self%bodies(i)%rate(at%x, u, value)
      end do
   end subroutine x_rate

   !> The inverse of `x_rate`.
   subroutine v_of_x_rate(self, at, rate, u)
      !> The mechanism.
      class(mechanism_parts_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> xdot: (n_x).
      real(wp), intent(in) :: rate(:)
      !> Velocities: (n).
      real(wp), intent(out) :: u(:)
      integer :: i

      do i = 1, size(self%bodies)
         call self%bodies(i)%velocity_of_rate(at%x, rate, u)
      end do
   end subroutine v_of_x_rate

   !> x := x (+) d, body by body.
   subroutine displace(self, d, x)
      !> The mechanism.
      class(mechanism_parts_t), intent(in) :: self
      !> Displacement: (n).
      real(wp), intent(in) :: d(:)
      !> Coordinates: (n_x).
      real(wp), intent(inout) :: x(:)
      integer :: i

      do i = 1, size(self%bodies)
         call self%bodies(i)%move(d, x)
      end do
   end subroutine displace

   !> Quaternions of length one.
   subroutine normalize(self, x)
      !> The mechanism.
      class(mechanism_parts_t), intent(in) :: self
      !> Coordinates: (n_x).
      real(wp), intent(inout) :: x(:)
      integer :: i

      do i = 1, size(self%bodies)
         call self%bodies(i)%normalize(x)
      end do
   end subroutine normalize

   !> Times at which a function is not smooth.
   function breakpoints(self) result(times)
      !> The mechanism.
      class(mechanism_parts_t), intent(in) :: self
      !> Times in any order [s].
      real(wp), allocatable :: times(:)
      integer :: i

      allocate (times(0))
      do i = 1, size(self%functions)
         times = [times, self%functions(i)%breakpoints()]
      end do
   end function breakpoints

   !> Name of the body and of its i-th coordinate or velocity.
   subroutine find_body(self, i, coordinate, body, k)
      class(mechanism_parts_t), intent(in) :: self
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
      !> The mechanism.
      class(mechanism_parts_t), intent(in) :: self
      !> Index of the coordinate.
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
      !> The mechanism.
      class(mechanism_parts_t), intent(in) :: self
      !> Index of the velocity.
      integer, intent(in) :: i
      !> The name.
      character(:), allocatable :: name
      character(len=2), parameter :: entries(6) = ['vx', 'vy', 'vz', 'wx', 'wy', 'wz']
      integer :: body, k

      call find_body(self, i, .false., body, k)
      name = self%bodies(body)%name//'.'//entries(entry_of_velocity(k, self%bodies(body)%kind))
   end function v_name

   !> Numbers of a joint: force and moment in global axes, in its own, then angle and displacement.
   pure function outputs_of_joint(self, joint) result(n)
      !> The mechanism.
      class(mechanism_parts_t), intent(in) :: self
      !> The joint.
      type(joint_t), intent(in) :: joint
      !> How many.
      integer :: n

      n = merge(6, 12, self%planar)
      if (has_angle(joint)) n = n + 1
      if (has_displacement(joint)) n = n + 1
   end function outputs_of_joint

   !> Numbers of all points and joints that are shown.
   pure integer function number_of_outputs(self) result(n)
      class(mechanism_parts_t), intent(in) :: self
      integer :: i

      n = size(self%points)*merge(2, 3, self%planar)
      do i = 1, size(self%shown)
         n = n + outputs_of_joint(self, self%joints(self%shown(i)))
      end do
   end function number_of_outputs

end module taut_model_mechanism_parts
