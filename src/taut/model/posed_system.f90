!> Systems that begin with poses: x = {7 coordinates of each pose; others}, v = {6 velocities of each pose; others}, where the
!! rates of the others are velocities themselves. Points of theirs can be followed in tables, and be looked at for being in line.
module taut_model_posed_system
   use taut_kinds, only: wp
   use taut_error, only: to_text
   use taut_constrained_system, only: state_t
   use taut_constrained_system_automatic, only: automatic_system_t, jet_state_t
   use taut_constrained_system_tables, only: name_length
   use taut_jet, only: jet_t, quaternion_rate
   use taut_model_pose, only: move_pose, normalize_pose, pose_rate, pose_velocity
   implicit none (type, external)
   private
   public :: posed_system_t

   !> Coordinates and velocities of a pose in tables.
   character(len=2), parameter :: x_letters(7) = [character(len=2) :: 'x', 'y', 'z', 'qa', 'qb', 'qc', 'qd']
   character(len=2), parameter :: v_letters(6) = [character(len=2) :: 'vx', 'vy', 'vz', 'wx', 'wy', 'wz']

   !> A point whose position is in tables.
   type :: marker_t
      character(:), allocatable :: name
      integer :: node = 0
   end type marker_t

   !> An event: seen along z, a point is in line with a fixed point and another point.
   type :: alignment_t
      character(:), allocatable :: name
      real(wp) :: fixed(3) = 0.0_wp
      integer :: node = 0, other = 0
   end type alignment_t

   !> A system that begins with poses. An extension states its sizes with `define` and `poses`.
   type, abstract, extends(automatic_system_t) :: posed_system_t
      !> Number of poses.
      integer :: poses = 0
      !> Whether names in tables have the number of the pose.
      logical :: numbered = .true.
      type(marker_t), allocatable, private :: markers(:)
      type(alignment_t), allocatable, private :: alignments(:)
   contains
      procedure :: kinematics
      procedure :: velocity_rhs => nothing_moves
      procedure :: x_rate
      procedure :: v_of_x_rate
      procedure :: displace
      procedure :: normalize
      procedure :: x_name
      procedure :: v_name
      !> Where a point is; by default, where a pose is.
      procedure :: node_position => pose_position
      procedure :: add_marker
      procedure :: add_alignment
      procedure :: output_name
      procedure :: outputs
      procedure :: event_name
      procedure :: event_values
   end type posed_system_t

contains

   !> xdot as jets, for constraints that are given by `phi`.
   subroutine kinematics(self, at, rate)
      !> The system.
      class(posed_system_t), intent(in) :: self
      !> Coordinates and velocities.
      type(jet_state_t), intent(in) :: at
      !> xdot: (n_x).
      type(jet_t), intent(out) :: rate(:)
      integer :: i

      do i = 1, self%poses
         rate(7*i - 6:7*i - 4) = at%v(6*i - 5:6*i - 3)
         rate(7*i - 3:7*i) = quaternion_rate(at%x(7*i - 3:7*i), at%v(6*i - 2:6*i))
      end do
      rate(7*self%poses + 1:) = at%v(6*self%poses + 1:)
   end subroutine kinematics

   !> xdot: {v; q {0, W}/2} of each pose, and the velocities of the others.
   subroutine x_rate(self, at, u, value)
      !> The system.
      class(posed_system_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> Velocities: (n).
      real(wp), intent(in) :: u(:)
      !> xdot: (n_x).
      real(wp), intent(out) :: value(:)
      integer :: i

      do i = 1, self%poses
         call pose_rate(at%x(7*i - 6:7*i), u(6*i - 5:6*i), value(7*i - 6:7*i))
      end do
      do i = 6*self%poses + 1, size(u)
         value(self%poses + i) = u(i)
      end do
   end subroutine x_rate

   !> The velocities that belong to a rate of the coordinates.
   subroutine v_of_x_rate(self, at, rate, u)
      !> The system.
      class(posed_system_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> Rate of the coordinates: (n_x).
      real(wp), intent(in) :: rate(:)
      !> Velocities: (n).
      real(wp), intent(out) :: u(:)
      integer :: i

      do i = 1, self%poses
         call pose_velocity(at%x(7*i - 6:7*i), rate(7*i - 6:7*i), u(6*i - 5:6*i))
      end do
      do i = 6*self%poses + 1, size(u)
         u(i) = rate(self%poses + i)
      end do
   end subroutine v_of_x_rate

   !> x := x (+) d: each pose is moved, and turned by a rotation vector in its own axes, q := q exp(d).
   subroutine displace(self, d, x)
      !> The system.
      class(posed_system_t), intent(in) :: self
      !> Displacement: (n).
      real(wp), intent(in) :: d(:)
      !> Coordinates: (n_x).
      real(wp), intent(inout) :: x(:)
      integer :: i

      do i = 1, self%poses
         call move_pose(d(6*i - 5:6*i), x(7*i - 6:7*i))
      end do
      do i = 6*self%poses + 1, size(d)
         x(self%poses + i) = x(self%poses + i) + d(i)
      end do
   end subroutine displace

   !> Quaternions of unit length.
   subroutine normalize(self, x)
      !> The system.
      class(posed_system_t), intent(in) :: self
      !> Coordinates: (n_x).
      real(wp), intent(inout) :: x(:)
      integer :: i

      do i = 1, self%poses
         call normalize_pose(x(7*i - 6:7*i))
      end do
   end subroutine normalize

   !> x, y, z, qa, qb, qc, qd with the number of the pose.
   function x_name(self, i) result(name)
      !> The system.
      class(posed_system_t), intent(in) :: self
      !> Index of the coordinate.
      integer, intent(in) :: i
      !> Such as x1 or qa1; q1, q2, ... for coordinates beyond the poses.
      character(len=name_length) :: name

      if (i > 7*self%poses) then
         name = 'q'//to_text(i - 7*self%poses)
      else
         name = trim(x_letters(1 + mod(i - 1, 7)))
         if (self%numbered) name = trim(name)//to_text(1 + (i - 1)/7)
      end if
   end function x_name

   !> vx, vy, vz (global axes), wx, wy, wz (body axes) with the number of the pose.
   function v_name(self, i) result(name)
      !> The system.
      class(posed_system_t), intent(in) :: self
      !> Index of the velocity.
      integer, intent(in) :: i
      !> Such as vx1 or wx1; vq1, vq2, ... for velocities beyond the poses.
      character(len=name_length) :: name

      if (i > 6*self%poses) then
         name = 'vq'//to_text(i - 6*self%poses)
      else
         name = v_letters(1 + mod(i - 1, 6))
         if (self%numbered) name = trim(name)//to_text(1 + (i - 1)/6)
      end if
   end function v_name

   !> Where a pose is.
   pure function pose_position(self, at, i) result(r)
      !> The system.
      class(posed_system_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> Index of the pose.
      integer, intent(in) :: i
      !> In global axes [m].
      real(wp) :: r(3)

      r = at%x(7*i - 6:7*i - 4)
      associate (unused_system => self)
      end associate
   end function pose_position

   !> Has the position of a point in tables.
   subroutine add_marker(self, name, node)
      !> The system.
      class(posed_system_t), intent(inout) :: self
      !> Its columns are called by this name and x, y, z.
      character(*), intent(in) :: name
      !> Index of the point.
      integer, intent(in) :: node

      if (.not. allocated(self%markers)) allocate (self%markers(0))
      self%markers = [self%markers, marker_t(name, node)]
      self%n_outputs = 3*size(self%markers)
   end subroutine add_marker

   !> Has it recorded when a point, seen along z, is in line with a fixed point and with another point.
   subroutine add_alignment(self, name, fixed, node, other)
      !> The system.
      class(posed_system_t), intent(inout) :: self
      !> Name of the event.
      character(*), intent(in) :: name
      !> The fixed point [m].
      real(wp), intent(in) :: fixed(3)
      !> Index of the point.
      integer, intent(in) :: node
      !> Index of the other point.
      integer, intent(in) :: other

      if (.not. allocated(self%alignments)) allocate (self%alignments(0))
      self%alignments = [self%alignments, alignment_t(name, fixed, node, other)]
      self%n_events = size(self%alignments)
   end subroutine add_alignment

   !> Name of a coordinate of a marker.
   function output_name(self, i) result(name)
      !> The system.
      class(posed_system_t), intent(in) :: self
      !> Index of the output.
      integer, intent(in) :: i
      !> Such as Ax.
      character(len=name_length) :: name

      name = self%markers((i + 2)/3)%name//trim(x_letters(1 + mod(i - 1, 3)))
   end function output_name

   !> Positions of the markers.
   subroutine outputs(self, at, lambda, values)
      !> The system.
      class(posed_system_t), intent(in) :: self
      !> The state that the row of the table is about.
      type(state_t), intent(in) :: at
      !> Multipliers: (c).
      real(wp), intent(in) :: lambda(:)
      !> x, y, z of each in turn: (3 markers) [m].
      real(wp), intent(out) :: values(:)
      integer :: i

      do i = 1, size(values)/3
         values(3*i - 2:3*i) = self%node_position(at, self%markers(i)%node)
      end do
      associate (unused_multipliers => lambda)
      end associate
   end subroutine outputs

   !> Name of an event.
   function event_name(self, i) result(name)
      !> The system.
      class(posed_system_t), intent(in) :: self
      !> Index of the event.
      integer, intent(in) :: i
      !> The name.
      character(len=name_length) :: name

      name = self%alignments(i)%name
   end function event_name

   !> Products across, in the plane of x and y, of the line from the fixed point to a point with the line on to the other.
   subroutine event_values(self, at, values)
      !> The system.
      class(posed_system_t), intent(in) :: self
      !> The state at which they are evaluated.
      type(state_t), intent(in) :: at
      !> Zero where they are in line: (alignments) [m^2].
      real(wp), intent(out) :: values(:)
      real(wp) :: r(3), first(3), second(3)
      integer :: i

      do i = 1, size(values)
         associate (line => self%alignments(i))
            r = self%node_position(at, line%node)
            first = r - line%fixed
            second = self%node_position(at, line%other)
            second = second - r
            values(i) = first(1)*second(2) - first(2)*second(1)
         end associate
      end do
   end subroutine event_values

   !> b' = 0: constraints between bodies and the ground do not move by themselves.
   subroutine nothing_moves(self, at, value)
      !> The system.
      class(posed_system_t), intent(in) :: self
      !> Where: of no account.
      type(state_t), intent(in) :: at
      !> b': (c).
      real(wp), intent(out) :: value(:)

      value(:) = 0.0_wp
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine nothing_moves

end module taut_model_posed_system
