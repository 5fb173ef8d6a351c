!> A mechanism: bodies, joints, functions of time, loads, springs and beams as one constrained system.
!!
!! Bodies and joints have numbers; 0 is the ground. All parts are set, then `complete` counts and checks. The multipliers of a
!! joint's rows are its reactions; `outputs` gives them as forces and moments on its second body.
module taut_model_mechanism
   use taut_kinds, only: wp
   use taut_error, only: error_t
   use taut_constrained_system, only: state_t
   use taut_constrained_system_reducible, only: reduction_t
   use taut_constrained_system_tables, only: magnitude_t, name_length, quantity_t, tabulated_system_t
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_model_beam_element, only: beam_element_t
   use taut_model_mechanism_body, only: body_t, entry_of_velocity, pose_t, velocities_of_kind
   use taut_model_mechanism_bushing, only: bushing_t, deformation_t
   use taut_model_mechanism_function, only: time_function_t
   use taut_model_mechanism_joint, only: joint_t
   use taut_model_mechanism_load, only: load_t, spring_t
   use taut_model_mechanism_row, only: row_t
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
   type, extends(tabulated_system_t) :: mechanism_t
      !> Whether it is in the plane x-y.
      logical :: planar = .false.
      !> Gravity [m/s^2].
      real(wp) :: gravity(3) = 0.0_wp
      type(body_t), allocatable :: bodies(:)
      type(joint_t), allocatable :: joints(:)
      type(time_function_t), allocatable :: functions(:)
      type(load_t), allocatable :: loads(:)
      type(spring_t), allocatable :: springs(:)
      type(bushing_t), allocatable :: bushings(:)
      type(element_t), allocatable :: elements(:)
      type(point_t), allocatable :: points(:)
      type(event_t), allocatable :: events(:)
      !> Joints whose reactions are written out.
      integer, allocatable :: shown(:)
      !> How many outputs come before those of each joint that is shown: (shown).
      integer, allocatable :: before_output(:)
      !> Springs whose force and length are written out, behind those of joints.
      integer, allocatable :: shown_springs(:)
      !> Bushings whose force and moment are written out, behind those.
      integer, allocatable :: shown_bushings(:)
      !> What was found out at the start, for the table of the model.
      type(quantity_t), allocatable :: findings(:)
      !> The same for people, in lines, and what a reader of the results has to know.
      character(:), allocatable :: description, remark
      !> Rows of all joints, those with a position level first; the joint of each.
      type(row_t), allocatable :: rows(:)
      integer, allocatable :: joint_of_row(:)
      !> Those rows that the opposite direction meets too.
      integer, allocatable :: rows_with_branches(:)
      !> Joints whose turns are coordinates of the state, which follow those of the bodies.
      integer, allocatable :: counting(:)
      !> The entries of A in compressed rows: the first of each row (c + 1), their columns, and which of the twelve of body 1 and
      !! body 2 each is.
      integer, allocatable :: first(:), column(:), source(:)
   contains
      procedure :: complete
      procedure :: reduce
      procedure :: find_parts
      procedure :: start_state
      procedure :: pose_of
      procedure :: angle_of
      procedure :: mass
      procedure :: x_rate
      procedure :: v_of_x_rate
      procedure :: displace
      procedure :: normalize
      procedure :: breakpoints
      procedure :: body_index
      procedure :: x_name
      procedure :: v_name
      procedure :: pattern
      procedure :: column_groups
      procedure :: sizes
      procedure :: row_name
      procedure :: constraint
      procedure :: jacobian
      procedure :: jacobian_entries
      procedure :: velocity_rhs
      procedure :: acceleration_rhs
      procedure :: check_branch
      procedure :: strayed_joint
      procedure :: cosine_of_row
      procedure :: diagnose
      procedure :: reaction
      procedure :: force
      procedure :: soft_force
      procedure :: coupling
      procedure :: elastic_pattern
      procedure :: elastic_rows
      procedure :: elastic_stiffness
      procedure :: energy
      procedure :: power
      procedure :: output_name
      procedure :: outputs
      procedure :: magnitudes
      procedure :: quantities
      procedure :: describe
      procedure :: note
      procedure :: event_name
      procedure :: event_values
   end type mechanism_t

   character(*), parameter :: here = 'mechanism'

   ! When all parts are there.
   interface
      !> Counts and checks; to be called when all is there.
      module subroutine complete(self, error)
         !> The mechanism.
         class(mechanism_t), intent(inout) :: self
         !> Bodies or joints that make no sense.
         type(error_t), allocatable, intent(inout) :: error
      end subroutine complete
   end interface

   ! What moves of it.
   interface
      !> The same mechanism with bodies that are welded together as one, and in the plane with what turns about a point of the
      !! ground by its angle alone; of an extension nothing is known.
      module subroutine reduce(self, reduction)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> The smaller one; not allocated if nothing falls away.
         class(reduction_t), allocatable, intent(out) :: reduction
      end subroutine reduce

      !> Which bodies move together, and what turns about a point of the ground.
      module subroutine find_parts(self, root, weld, pin, followers)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> The body with which each moves: itself, or one to which it is welded; 0: it is welded to the ground: (bodies).
         integer, intent(out) :: root(:)
         !> The joint that welds each to the one before it; 0: its coordinates are those of what moves with it: (bodies).
         integer, intent(out) :: weld(:)
         !> The joint by which it turns about a point of the ground, with all that moves with it; 0: it does not: (bodies).
         integer, intent(out) :: pin(:)
         !> Those that are welded, each behind the one to which it is.
         integer, allocatable, intent(out) :: followers(:)
      end subroutine find_parts
   end interface

   ! Where its bodies are.
   interface
      !> The state at the start as given, t = 0.
      module function start_state(self) result(at)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> The state at which it is evaluated.
         type(state_t) :: at
      end function start_state

      !> Where a body is and how it moves.
      pure module subroutine pose_of(self, at, body, it)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> The state at which it is evaluated.
         type(state_t), intent(in) :: at
         !> The body; 0 is the ground.
         integer, intent(in) :: body
         !> Its pose.
         type(pose_t), intent(out) :: it
      end subroutine pose_of

      !> The angle of a joint with all its turns since the start: those of its drive, of the bodies in the plane, or of its own
      !! coordinate. Of a joint in space that nobody asks, from -pi to pi.
      pure module function angle_of(self, at, joint, one, two) result(angle)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> The state; its x and t are used.
         type(state_t), intent(in) :: at
         !> The joint, one that has an angle.
         type(joint_t), intent(in) :: joint
         !> Pose of its body 1.
         type(pose_t), intent(in) :: one
         !> Pose of its body 2.
         type(pose_t), intent(in) :: two
         !> The angle [rad].
         real(wp) :: angle
      end function angle_of

      !> Difference of the angles of a joint's bodies in the plane, about its axis.
      pure module function turned_by(self, joint, x) result(angle)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> The joint.
         type(joint_t), intent(in) :: joint
         !> Coordinates: (n_x).
         real(wp), intent(in) :: x(:)
         !> The difference [rad].
         real(wp) :: angle
      end function turned_by

      !> Forgets all poses.
      pure module subroutine clear(self)
         !> Poses.
         class(poses_t), intent(inout) :: self
      end subroutine clear

      !> The places of the poses of two bodies, computed where they are not there.
      pure module subroutine find(self, model, at, body_1, body_2, one, two)
         !> Poses at this state.
         class(poses_t), intent(inout) :: self
         !> The mechanism and its state.
         class(mechanism_t), intent(in) :: model
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
      end subroutine find

      !> M: mass and inertia of each body.
      module subroutine mass(self, at, m)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> The state; its x and t are used.
         type(state_t), intent(in) :: at
         !> The mass matrix.
         type(block_diagonal_t), intent(inout) :: m
      end subroutine mass

      !> xdot, body by body.
      module subroutine x_rate(self, at, u, value)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> The state; its x and t are used.
         type(state_t), intent(in) :: at
         !> Velocities: (n).
         real(wp), intent(in) :: u(:)
         !> xdot: (n_x).
         real(wp), intent(out) :: value(:)
      end subroutine x_rate

      !> The inverse of `x_rate`.
      module subroutine v_of_x_rate(self, at, rate, u)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> The state; its x and t are used.
         type(state_t), intent(in) :: at
         !> xdot: (n_x).
         real(wp), intent(in) :: rate(:)
         !> Velocities: (n).
         real(wp), intent(out) :: u(:)
      end subroutine v_of_x_rate

      !> x := x (+) d, body by body.
      module subroutine displace(self, d, x)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> Displacement: (n).
         real(wp), intent(in) :: d(:)
         !> Coordinates: (n_x).
         real(wp), intent(inout) :: x(:)
      end subroutine displace

      !> Quaternions of length one; turns that are whole ones but for the angle between the bodies.
      module subroutine normalize(self, x)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> Coordinates: (n_x).
         real(wp), intent(inout) :: x(:)
      end subroutine normalize

      !> Times at which a function is not smooth.
      module function breakpoints(self) result(times)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> Times in any order [s].
         real(wp), allocatable :: times(:)
      end function breakpoints
   end interface

   ! What its joints demand.
   interface
      !> Where the entries of A are: compressed rows.
      module subroutine pattern(self, first, column)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> First entry of each row, and one past the last: (c + 1).
         integer, allocatable, intent(out) :: first(:)
         !> Column of each entry, ascending in each row.
         integer, allocatable, intent(out) :: column(:)
      end subroutine pattern

      !> The translation of each body has a unit and a size of its own, and so has its rotation.
      module subroutine column_groups(self, group)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> The number of the set for each velocity: (n).
         integer, allocatable, intent(out) :: group(:)
      end subroutine column_groups

      !> Lengths are those of the longest arm from a center of mass to a joint, or of the largest body.
      module subroutine sizes(self, at, length, coordinate)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> Where its motion starts.
         type(state_t), intent(in) :: at
         !> The length for what is moved, 1 for what is turned: (n).
         real(wp), intent(out) :: length(:)
         !> The largest coordinate of a body's center, 1 for what is turned: (n).
         real(wp), intent(out) :: coordinate(:)
      end subroutine sizes

      !> A row by its joint and by what it prevents.
      module subroutine row_name(self, row, name)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> Which row of A.
         integer, intent(in) :: row
         !> A few words without commas.
         character(:), allocatable, intent(out) :: name
      end subroutine row_name

      !> phi, row by row.
      module subroutine constraint(self, at, value)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> The state; its x and t are used.
         type(state_t), intent(in) :: at
         !> phi: (n_phi) [m] or [-].
         real(wp), intent(out) :: value(:)
      end subroutine constraint

      !> A, dense; `scatter_entries` would do, with an allocation.
      module subroutine jacobian(self, at, a)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> The state; its x and t are used.
         type(state_t), intent(in) :: at
         !> The constraint matrix: (c, n).
         real(wp), intent(out) :: a(:, :)
      end subroutine jacobian

      !> The entries of A: each row has those of its bodies.
      module subroutine jacobian_entries(self, at, values)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> The state; its x and t are used.
         type(state_t), intent(in) :: at
         !> In the order of `pattern`.
         real(wp), intent(out) :: values(:)
      end subroutine jacobian_entries

      !> b', row by row.
      module subroutine velocity_rhs(self, at, value)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> The state; its x and t are used.
         type(state_t), intent(in) :: at
         !> b': (c) [m/s] or [1/s].
         real(wp), intent(out) :: value(:)
      end subroutine velocity_rhs

      !> b'', row by row.
      module subroutine acceleration_rhs(self, at, value)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> The state; its x, v and t are used.
         type(state_t), intent(in) :: at
         !> b'': (c) [m/s^2] or [1/s^2].
         real(wp), intent(out) :: value(:)
      end subroutine acceleration_rhs

      !> Joints that all but repeat each other, or are all but at a dead point.
      module subroutine diagnose(self, at, text)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> The state at which it is evaluated.
         type(state_t), intent(in) :: at
         !> Which, by how much, and what to do; not allocated if there are none.
         character(:), allocatable, intent(out) :: text
      end subroutine diagnose

      !> Names the joint that is met upside down, or half a turn from what drives it.
      module subroutine check_branch(self, at, what)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> The state; its x and t are used.
         type(state_t), intent(in) :: at
         !> Such as: joint "hinge" is half a turn from its drive "g"; not allocated if there is none.
         character(:), allocatable, intent(out) :: what
      end subroutine check_branch

      !> The first joint that is on the other branch.
      module function strayed_joint(self, at) result(joint)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> The state; its x and t are used.
         type(state_t), intent(in) :: at
         !> Its index; 0 if there is none.
         integer :: joint
      end function strayed_joint

      !> The cosine between the direction that a row demands and the one that is there.
      module function cosine_of_row(self, at, i) result(cosine)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> The state; its x and t are used.
         type(state_t), intent(in) :: at
         !> The row, one that has branches.
         integer, intent(in) :: i
         !> 1 on the branch that is meant, -1 on the other.
         real(wp) :: cosine
      end function cosine_of_row

      !> Force and moment of a joint on its second body, the moment about the joint's point of that body.
      module subroutine reaction(self, at, lambda, j, f, m)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
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
      end subroutine reaction
   end interface

   ! What drives it.
   interface
      !> f: gravity, gyroscopic moments, loads, springs and dampers, bushings, beams.
      module subroutine force(self, at, value)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> The state; all of it may be used.
         type(state_t), intent(in) :: at
         !> f: (n).
         real(wp), intent(out) :: value(:)
      end subroutine force

      !> Kinetic energy, and the potential of gravity (zero at the origin), springs, bushings and beams; loads have no part in it.
      module function energy(self, at)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> The state; its x and v are used.
         type(state_t), intent(in) :: at
         !> The energy [J].
         real(wp) :: energy
      end function energy
   end interface

   interface
      !> Power of loads and dampers; where the energy contains everything, zero.
      module function power(self, at)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> The state; its t, x and v are used.
         type(state_t), intent(in) :: at
         !> The power [W].
         real(wp) :: power
      end function power
   end interface

   ! What of it is stiff, for implicit integrators: springs and bushings with a stiffness and beams are elastic rows.
   interface
      !> Counts the elastic rows and takes their damping; called by `complete`.
      module subroutine count_elastic_rows(self)
         class(mechanism_t), intent(inout) :: self
      end subroutine count_elastic_rows

      !> f without springs that have a stiffness, but with their preload, without what of bushings has one, and without beams.
      module subroutine soft_force(self, at, value)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> The state; all of it may be used.
         type(state_t), intent(in) :: at
         !> The force: (n).
         real(wp), intent(out) :: value(:)
      end subroutine soft_force

      !> What soft forces couple: each body by itself, and the bodies of dampers.
      module subroutine coupling(self, first, column)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> First entry of each velocity in `column`, and the number of entries plus one at the end: (n + 1).
         integer, allocatable, intent(out) :: first(:)
         !> The others.
         integer, allocatable, intent(out) :: column(:)
      end subroutine coupling

      !> Where the entries of B are, row by row: a row for each spring, up to six for each bushing, six for each
      !! element of a beam.
      module subroutine elastic_pattern(self, first, column)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> First entry of each row in `column`, and the number of entries plus one at the end: (n_elastic + 1).
         integer, allocatable, intent(out) :: first(:)
         !> Column of each entry, ascending within a row.
         integer, allocatable, intent(out) :: column(:)
      end subroutine elastic_pattern

      !> Lengths and angles of springs less their free ones, deformations of bushings, stretches and bends of beams, and B.
      module subroutine elastic_rows(self, at, strain, values)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> The state; v is used by damping only.
         type(state_t), intent(in) :: at
         !> Strains [m], [rad]: (n_elastic).
         real(wp), intent(out) :: strain(:)
         !> Entries of B in the order of the pattern.
         real(wp), intent(out) :: values(:)
      end subroutine elastic_rows

      !> Stiffness of the rows.
      module subroutine elastic_stiffness(self, stiffness)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> One block for each row of a spring or a bushing and for each element.
         type(block_diagonal_t), intent(inout) :: stiffness
      end subroutine elastic_stiffness

      !> Length or angle of a spring, its rate, and the direction from point 1 to point 2 or of the axis.
      pure module subroutine spring_motion(self, at, spring, one, two, length, rate, direction)
         class(mechanism_t), intent(in) :: self
         type(state_t), intent(in) :: at
         type(spring_t), intent(in) :: spring
         type(pose_t), intent(in) :: one, two
         real(wp), intent(out) :: length, rate, direction(3)
      end subroutine spring_motion

      !> Force or moment of a spring with its damper; tension, or what turns back, is positive.
      pure module function spring_force(spring, length, rate) result(force)
         type(spring_t), intent(in) :: spring
         real(wp), intent(in) :: length, rate
         real(wp) :: force
      end function spring_force

      !> The bodies of a spring.
      pure module subroutine spring_bodies(self, spring, body_1, body_2)
         class(mechanism_t), intent(in) :: self
         type(spring_t), intent(in) :: spring
         integer, intent(out) :: body_1, body_2
      end subroutine spring_bodies
   end interface

   interface
      !> The deformation of a bushing, and the poses of its bodies.
      pure module subroutine deform_bushing(self, at, bushing, one, two, it)
         class(mechanism_t), intent(in) :: self
         type(state_t), intent(in) :: at
         type(bushing_t), intent(in) :: bushing
         type(pose_t), intent(out) :: one, two
         type(deformation_t), intent(out) :: it
      end subroutine deform_bushing
   end interface

   ! What is written of it.
   interface
      !> The number of a body by its name: its coordinates begin behind `bodies(i)%before_x`, its velocities behind `before_v`.
      pure module function body_index(self, name) result(i)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> The name; trailing blanks do not count.
         character(*), intent(in) :: name
         !> The number; 0 if there is no body of this name.
         integer :: i
      end function body_index

      !> Such as rod1.x, rod1.qa or, in the plane, rod1.angle; hinge.angle of a joint that counts its turns.
      module function x_name(self, i) result(name)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> Index of the coordinate.
         integer, intent(in) :: i
         !> The name.
         character(len=name_length) :: name
      end function x_name

      !> Such as rod1.vx or rod1.wx (body axes).
      module function v_name(self, i) result(name)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> Index of the velocity.
         integer, intent(in) :: i
         !> The name.
         character(len=name_length) :: name
      end function v_name

      !> Such as tip.x, hinge.fx, hinge.m3 or hinge.angle.
      module function output_name(self, i) result(name)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> Index of the output.
         integer, intent(in) :: i
         !> The name.
         character(len=name_length) :: name
      end function output_name

      !> Positions of points; reactions, angles and displacements of joints.
      module subroutine outputs(self, at, lambda, values)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> The state that the row of the table is about.
         type(state_t), intent(in) :: at
         !> Multipliers: (c).
         real(wp), intent(in) :: lambda(:)
         !> In the order of their names: (n_outputs).
         real(wp), intent(out) :: values(:)
      end subroutine outputs

      !> Force and moment of each joint that is shown, as far as its rows give either; the moment about its point.
      module function magnitudes(self) result(list)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> Such as hinge.force and hinge.moment.
         type(magnitude_t), allocatable :: list(:)
      end function magnitudes

      !> Numbers of a joint: force and moment in global axes, in its own, then angle and displacement.
      pure module function outputs_of_joint(self, joint) result(n)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> The joint.
         type(joint_t), intent(in) :: joint
         !> How many.
         integer :: n
      end function outputs_of_joint

      !> What was found out at the start.
      module function quantities(self) result(list)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> The table.
         type(quantity_t), allocatable :: list(:)
      end function quantities

      !> What was found out at the start, for people.
      module subroutine describe(self, text)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> Lines with their ends.
         character(:), allocatable, intent(out) :: text
      end subroutine describe

      !> Whether there are reactions that are not unique.
      module subroutine note(self, text)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> One line without commas.
         character(:), allocatable, intent(out) :: text
      end subroutine note

      !> Name of an event.
      module function event_name(self, i) result(name)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> Index of the event.
         integer, intent(in) :: i
         !> The name.
         character(len=name_length) :: name
      end function event_name

      !> What is watched less its value.
      module subroutine event_values(self, at, values)
         !> The mechanism.
         class(mechanism_t), intent(in) :: self
         !> The state at which they are evaluated.
         type(state_t), intent(in) :: at
         !> Differences: (n_events).
         real(wp), intent(out) :: values(:)
      end subroutine event_values
   end interface

end module taut_model_mechanism
