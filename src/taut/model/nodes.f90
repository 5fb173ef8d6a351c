!> Systems of rigid nodes in space: everything that a beam, or a set of rigid bodies, has but its internal forces.
!!
!! Node i has 7 coordinates, x(7 i - 6:7 i) = {position; unit quaternion, its scalar part first}, and 6 velocities,
!! v(6 i - 5:6 i) = {linear velocity in GLOBAL axes; angular velocity in BODY axes}. So M is constant.
module taut_model_nodes
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_constrained_system, only: state_t
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_model_dead_load, only: dead_load_t
   use taut_model_node_constraint, only: kind_distance, kind_position, kind_rotation, node_constraint_t
   use taut_model_posed_system, only: posed_system_t
   use taut_rotation, only: cross, quaternion_normalized, rotate_back
   implicit none (type, external)
   private
   public :: nodal_system_t

   !> Nodes with masses, loads and constraints. An extension supplies `force`, with the help of `loads_and_inertia`.
   type, abstract, extends(posed_system_t) :: nodal_system_t
      !> Number of nodes.
      integer :: nodes = 0
      !> Reference configuration: (7 nodes).
      real(wp), allocatable :: x_reference(:)
      !> Mass of each node [kg], and moments of inertia in body axes [kg m^2]: (nodes), (3, 3, nodes).
      real(wp), allocatable :: m(:), inertia(:, :, :)
      !> Acceleration of gravity [m/s^2].
      real(wp) :: gravity(3) = 0.0_wp
      !> Forces and moments on nodes.
      type(dead_load_t), allocatable :: loads(:)
      !> Constraints in the order of their rows.
      type(node_constraint_t), allocatable :: constraints(:)
   contains
      procedure :: set_nodes
      procedure :: add_mass
      procedure :: add_load
      procedure :: fix_position
      procedure :: fix_rotation
      procedure :: pin
      procedure :: clamp
      procedure :: link
      procedure :: external_loads
      procedure :: loads_and_inertia
      procedure :: reference_state
      procedure :: mass
      procedure :: constraint
      procedure :: pattern
      procedure :: jacobian_entries
      procedure :: acceleration_rhs
      procedure :: energy => energy_without_strain
      procedure :: energy_without_strain
      procedure :: power => power_of_loads
      procedure :: power_of_loads
      procedure :: breakpoints
      procedure :: resize
      procedure, private :: add_constraint
   end type nodal_system_t

   character(*), parameter :: here = 'nodes'
   real(wp), parameter :: axes(3, 3) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [3, 3])

contains

   !> Sets the nodes, without mass, loads or constraints.
   subroutine set_nodes(self, positions, orientations, error)
      !> The system.
      class(nodal_system_t), intent(inout) :: self
      !> Reference positions of the nodes [m]: (3, nodes).
      real(wp), intent(in) :: positions(:, :)
      !> Their orientations, unit quaternions: (4, nodes).
      real(wp), intent(in) :: orientations(:, :)
      !> Numbers that make no sense.
      type(error_t), allocatable, intent(inout) :: error
      integer :: i, n

      n = size(positions, 2)
      if (size(orientations, 2) /= n .or. size(positions, 1) /= 3 .or. size(orientations, 1) /= 4) then
         call raise(error, here, 'positions and orientations do not fit', 'give 3 and 4 numbers for each node')
      else if (.not. (all(abs(positions) <= huge(1.0_wp)) .and. all(abs(orientations) <= 1.01_wp))) then
         call raise(error, here, 'a position or an orientation is not a number', 'give metres and unit quaternions')
      end if
      if (allocated(error)) return
      self%nodes = n
      self%poses = n
      allocate (self%x_reference(7*n), self%loads(0), self%constraints(0))
      allocate (self%m(n), self%inertia(3, 3, n), source=0.0_wp)
      do i = 1, n
         self%x_reference(7*i - 6:7*i) = [positions(:, i), quaternion_normalized(orientations(:, i))]
      end do
      call self%resize()
   end subroutine set_nodes

   !> States the sizes again after a change. M has a full block only where a lumped inertia asks for one.
   subroutine resize(self)
      !> The system.
      class(nodal_system_t), intent(inout) :: self
      integer, allocatable :: blocks(:)
      integer :: i

      allocate (blocks(0))
      do i = 1, self%nodes
         if (is_diagonal(self%inertia(:, :, i))) then
            blocks = [blocks, 1, 1, 1, 1, 1, 1]
         else
            blocks = [blocks, 1, 1, 1, 3]
         end if
      end do
      call self%define(n=6*self%nodes, c=size(self%constraints), n_x=7*self%nodes, mass_blocks=blocks, &
                       constant_mass=.true.)
   end subroutine resize

   !> Whether all entries off the diagonal are zero.
   pure function is_diagonal(j) result(answer)
      real(wp), intent(in) :: j(3, 3)
      logical :: answer

      answer = all(abs([j(1, 2), j(1, 3), j(2, 3), j(2, 1), j(3, 1), j(3, 2)]) <= 0.0_wp)
   end function is_diagonal

   !> Whether a node exists.
   subroutine check_node(self, node, error)
      class(nodal_system_t), intent(in) :: self
      integer, intent(in) :: node
      type(error_t), allocatable, intent(inout) :: error

      if (node < 1 .or. node > self%nodes) &
         call raise(error, here, 'there is no node '//to_text(node), 'the nodes are 1 to '//to_text(self%nodes))
   end subroutine check_node

   !> A rigid mass on a node, its center at the node.
   subroutine add_mass(self, node, m, error, inertia)
      !> The system.
      class(nodal_system_t), intent(inout) :: self
      !> Index of the node.
      integer, intent(in) :: node
      !> Mass [kg].
      real(wp), intent(in) :: m
      !> A value that makes no sense.
      type(error_t), allocatable, intent(inout) :: error
      !> Moments of inertia about the node, in the node's axes [kg m^2]: symmetric. Default zero.
      real(wp), intent(in), optional :: inertia(3, 3)

      call check_node(self, node, error)
      if (.not. (m >= 0.0_wp .and. m <= huge(m))) &
         call raise(error, here, 'a mass of '//to_text(m)//' kg is negative', 'give zero or more')
      if (allocated(error)) return
      self%m(node) = self%m(node) + m
      if (present(inertia)) self%inertia(:, :, node) = self%inertia(:, :, node) + inertia
      call self%resize()
   end subroutine add_mass

   !> A force and a moment on a node that keep their directions.
   subroutine add_load(self, node, force, moment, error, times, factors)
      !> The system.
      class(nodal_system_t), intent(inout) :: self
      !> Index of the node.
      integer, intent(in) :: node
      !> Force in global axes [N].
      real(wp), intent(in) :: force(3)
      !> Moment in global axes [N m].
      real(wp), intent(in) :: moment(3)
      !> A value that makes no sense.
      type(error_t), allocatable, intent(inout) :: error
      !> Times [s], increasing. Default: none.
      real(wp), intent(in), optional :: times(:)
      !> What the load is multiplied with at these times: linear between them, constant outside. Default: 1.
      real(wp), intent(in), optional :: factors(:)
      type(dead_load_t) :: load

      call check_node(self, node, error)
      call load%set(node, force, moment, error, times, factors)
      if (.not. allocated(error)) self%loads = [self%loads, load]
   end subroutine add_load

   !> Adds a row.
   subroutine add_constraint(self, one, error)
      !> The system.
      class(nodal_system_t), intent(inout) :: self
      !> What it asks for; its point and its orientation are replaced by the reference ones unless it is a distance.
      type(node_constraint_t), intent(in) :: one
      !> A node that does not exist, a direction of length zero.
      type(error_t), allocatable, intent(inout) :: error
      type(node_constraint_t) :: row

      call check_node(self, one%node, error)
      call one%check(error)
      if (allocated(error)) return
      row = one
      if (row%kind /= kind_distance) then
         row%direction = row%direction/norm2(row%direction)
         row%point = self%x_reference(7*row%node - 6:7*row%node - 4)
         row%orientation = self%x_reference(7*row%node - 3:7*row%node)
      end if
      self%constraints = [self%constraints, row]
      call self%resize()
   end subroutine add_constraint

   !> A node's position keeps its component along a direction.
   subroutine fix_position(self, node, direction, error)
      !> The system.
      class(nodal_system_t), intent(inout) :: self
      !> Index of the node.
      integer, intent(in) :: node
      !> Direction in global axes, of any length.
      real(wp), intent(in) :: direction(3)
      !> A node or a direction that makes no sense.
      type(error_t), allocatable, intent(inout) :: error

      call self%add_constraint(node_constraint_t(kind=kind_position, node=node, direction=direction), error)
   end subroutine fix_position

   !> A node does not turn about an axis.
   subroutine fix_rotation(self, node, axis, error)
      !> The system.
      class(nodal_system_t), intent(inout) :: self
      !> Index of the node.
      integer, intent(in) :: node
      !> Axis in the node's own axes, of any length.
      real(wp), intent(in) :: axis(3)
      !> A node or an axis that makes no sense.
      type(error_t), allocatable, intent(inout) :: error

      call self%add_constraint(node_constraint_t(kind=kind_rotation, node=node, direction=axis), error)
   end subroutine fix_rotation

   !> A node stays where it is: three rows.
   subroutine pin(self, node, error)
      !> The system.
      class(nodal_system_t), intent(inout) :: self
      !> Index of the node.
      integer, intent(in) :: node
      !> A node that does not exist.
      type(error_t), allocatable, intent(inout) :: error
      integer :: i

      do i = 1, 3
         call self%fix_position(node, axes(:, i), error)
      end do
   end subroutine pin

   !> A node neither moves nor turns: six rows.
   subroutine clamp(self, node, error)
      !> The system.
      class(nodal_system_t), intent(inout) :: self
      !> Index of the node.
      integer, intent(in) :: node
      !> A node that does not exist.
      type(error_t), allocatable, intent(inout) :: error
      integer :: i

      call self%pin(node, error)
      do i = 1, 3
         call self%fix_rotation(node, axes(:, i), error)
      end do
   end subroutine clamp

   !> A rigid massless link, pinned to the ground and to a node: |x - ground| = length. Its multiplier is its tension [N].
   subroutine link(self, node, ground, length, error)
      !> The system.
      class(nodal_system_t), intent(inout) :: self
      !> Index of the node.
      integer, intent(in) :: node
      !> The link's fixed end [m].
      real(wp), intent(in) :: ground(3)
      !> Its length [m].
      real(wp), intent(in) :: length
      !> A node that does not exist, a length that is not positive.
      type(error_t), allocatable, intent(inout) :: error

      call self%add_constraint(node_constraint_t(kind=kind_distance, node=node, point=ground, length=length), error)
   end subroutine link

   !> Forces and moments from outside, in global axes; the default adds the loads of `add_load`. To be overridden, and called
   !! from the override, for loads of another kind.
   subroutine external_loads(self, at, loads)
      !> The system.
      class(nodal_system_t), intent(in) :: self
      !> The state; all of it may be used.
      type(state_t), intent(in) :: at
      !> Force and moment on each node, to be added to: (6, nodes) [N], [N m].
      real(wp), intent(inout) :: loads(6, self%nodes)
      integer :: i

      do i = 1, size(self%loads)
         call self%loads(i)%add_to(at%t, loads(:, self%loads(i)%node))
      end do
   end subroutine external_loads

   !> Completes f, given the internal forces and moments in global axes: adds gravity and external loads, takes the moments
   !! to body axes, and subtracts W x (J W).
   subroutine loads_and_inertia(self, at, f)
      !> The system.
      class(nodal_system_t), intent(in) :: self
      !> The state; all of it may be used.
      type(state_t), intent(in) :: at
      !> f: (6, nodes); on entry with moments in global axes, on exit in body axes.
      real(wp), intent(inout) :: f(6, self%nodes)
      real(wp) :: h(3), w(3)
      integer :: i, k

      call self%external_loads(at, f)
      do i = 1, self%nodes
         do k = 1, 3
            f(k, i) = f(k, i) + self%m(i)*self%gravity(k)
            w(k) = at%v(6*i - 3 + k)
         end do
         h = rotate_back(at%x(7*i - 3:7*i), f(4:6, i))
         f(4:6, i) = h
         do k = 1, 3
            h(k) = self%inertia(k, 1, i)*w(1) + self%inertia(k, 2, i)*w(2) + self%inertia(k, 3, i)*w(3)
         end do
         f(4:6, i) = f(4:6, i) - cross(w, h)
      end do
   end subroutine loads_and_inertia

   !> The reference configuration at rest, t = 0.
   function reference_state(self) result(at)
      !> The system.
      class(nodal_system_t), intent(in) :: self
      !> The state.
      type(state_t) :: at

      allocate (at%x, source=self%x_reference)
      allocate (at%v(self%n), source=0.0_wp)
      allocate (at%w(0))
   end function reference_state

   !> M: m in the three linear velocities, the moments of inertia in the angular ones.
   subroutine mass(self, at, m)
      !> The system.
      class(nodal_system_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> The mass matrix.
      type(block_diagonal_t), intent(inout) :: m
      real(wp) :: d(self%n)
      integer :: b, i, k

      do i = 1, self%nodes
         d(6*i - 5:6*i - 3) = self%m(i)
         d(6*i - 2:6*i) = [(self%inertia(k, k, i), k=1, 3)]
      end do
      call m%set_diagonal(d)
      b = 0
      do i = 1, self%nodes
         b = b + merge(6, 4, is_diagonal(self%inertia(:, :, i)))
         if (.not. is_diagonal(self%inertia(:, :, i))) call m%set_block(b, self%inertia(:, :, i))
      end do
      associate (unused_state => at)
      end associate
   end subroutine mass

   !> phi, row by row.
   subroutine constraint(self, at, value)
      !> The system.
      class(nodal_system_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> phi: (c) [m] or [-].
      real(wp), intent(out) :: value(:)
      integer :: i, j

      do i = 1, self%c
         j = 7*self%constraints(i)%node
         value(i) = self%constraints(i)%violation(at%x(j - 6:j))
      end do
   end subroutine constraint

   !> Each row has three entries: those of a node's displacements, or of its rotations.
   pure subroutine pattern(self, first, column)
      !> The system.
      class(nodal_system_t), intent(in) :: self
      !> First entry of each row, and one past the last: (c + 1).
      integer, allocatable, intent(out) :: first(:)
      !> Column of each entry, ascending within a row.
      integer, allocatable, intent(out) :: column(:)
      integer :: i, j

      allocate (first(size(self%constraints) + 1), column(3*size(self%constraints)))
      first(1) = 1
      do i = 1, size(self%constraints)
         first(i + 1) = first(i) + 3
         j = 6*self%constraints(i)%node - 6
         if (self%constraints(i)%kind == kind_rotation) j = j + 3
         column(3*i - 2:3*i) = [j + 1, j + 2, j + 3]
      end do
   end subroutine pattern

   !> A, row by row.
   subroutine jacobian_entries(self, at, values)
      !> The system.
      class(nodal_system_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> Entries of the pattern: (3 c).
      real(wp), intent(out) :: values(:)
      real(wp) :: row(6)
      integer :: i, j

      do i = 1, size(self%constraints)
         j = self%constraints(i)%node
         row = self%constraints(i)%row(at%x(7*j - 6:7*j))
         if (self%constraints(i)%kind == kind_rotation) then
            values(3*i - 2:3*i) = row(4:6)
         else
            values(3*i - 2:3*i) = row(1:3)
         end if
      end do
   end subroutine jacobian_entries

   !> b'', row by row.
   subroutine acceleration_rhs(self, at, value)
      !> The system.
      class(nodal_system_t), intent(in) :: self
      !> The state; its x, v and t are used.
      type(state_t), intent(in) :: at
      !> b'': (c) [m/s^2] or [1/s^2].
      real(wp), intent(out) :: value(:)
      integer :: i, j

      do i = 1, self%c
         j = self%constraints(i)%node
         value(i) = self%constraints(i)%acceleration(at%x(7*j - 6:7*j), at%v(6*j - 5:6*j))
      end do
   end subroutine acceleration_rhs

   !> Kinetic energy and that of gravity, zero at the origin; loads from outside have no part in it.
   function energy_without_strain(self, at) result(energy)
      !> The system.
      class(nodal_system_t), intent(in) :: self
      !> The state; its x and v are used.
      type(state_t), intent(in) :: at
      !> The energy [J].
      real(wp) :: energy
      integer :: i

      energy = 0.0_wp
      do i = 1, self%nodes
         associate (v => at%v(6*i - 5:6*i - 3), w => at%v(6*i - 2:6*i))
            energy = energy + 0.5_wp*self%m(i)*dot_product(v, v) + 0.5_wp*dot_product(w, matmul(self%inertia(:, :, i), w)) &
                     - self%m(i)*dot_product(self%gravity, at%x(7*i - 6:7*i - 4))
         end associate
      end do
   end function energy_without_strain

   !> Power of the loads [W].
   function power_of_loads(self, at) result(power)
      !> The system.
      class(nodal_system_t), intent(in) :: self
      !> The state; all of it may be used.
      type(state_t), intent(in) :: at
      !> The power.
      real(wp) :: power
      real(wp) :: total(6)
      integer :: i, k

      power = 0.0_wp
      do k = 1, size(self%loads)
         i = self%loads(k)%node
         total = 0.0_wp
         call self%loads(k)%add_to(at%t, total)
         total(4:6) = rotate_back(at%x(7*i - 3:7*i), total(4:6))
         power = power + dot_product(total, at%v(6*i - 5:6*i))
      end do
   end function power_of_loads

   !> The times at which a load has a kink.
   function breakpoints(self) result(times)
      !> The system.
      class(nodal_system_t), intent(in) :: self
      !> Times in any order [s].
      real(wp), allocatable :: times(:)
      integer :: i

      allocate (times(0))
      do i = 1, size(self%loads)
         times = [times, self%loads(i)%times]
      end do
   end function breakpoints

end module taut_model_nodes
