!> Builds a mechanism part by part: what a case file does, and any program may.
!!
!!     call builder%add_body('rod', mass=1.0_wp, shape='rod', from=[0, 0, 0]*1.0_wp, to=[1, 0, 0]*1.0_wp)
!!     call builder%add_joint('hinge', 'revolute', 'ground', 'rod', point=[0, 0, 0]*1.0_wp, axis=[0, 1, 0]*1.0_wp)
!!     call builder%complete(mechanism, start, error)
!!
!! Parts are named, and named again where others refer to them, after they were added; `ground` is there from the start. Vectors
!! are in global axes and the bodies where they are drawn, unless an argument says otherwise. The first thing that is wrong
!! is kept in `error`; what is added behind it is not looked at, and `complete` hands it on. The time is linear in the number
!! of parts.
module taut_model_mechanism_builder
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_name_index, only: name_index_t
   use taut_constrained_system, only: state_t
   use taut_model_beam, only: beam_t, new_beam, straight_nodes
   use taut_model_beam_section, only: beam_section_t, rectangular_section
   use taut_model_mechanism, only: element_t, event_t, mechanism_t, point_t
   use taut_model_mechanism_body, only: body_planar, body_planar_point, body_point, body_spatial, body_t, ground_pose, pose_t
   use taut_model_mechanism_bushing, only: bushing_t
   use taut_model_mechanism_function, only: time_function_t
   use taut_model_mechanism_joint, only: joint_t
   use taut_model_mechanism_load, only: load_t, spring_t
   use taut_rotation, only: matrix_of_quaternion
   use taut_spelling, only: nearest_name
   implicit none (type, external)
   private
   public :: mechanism_builder_t, builder_words_t, anchor_t

   !> What a joint or a load may be fixed to: the ground, a body, or a point of either.
   type :: anchor_t
      !> What it is called.
      character(:), allocatable :: name
      !> The body; 0 is the ground.
      integer :: body = 0
      !> Whether it is a point, and where in the body's axes [m].
      logical :: is_point = .false.
      real(wp) :: at(3) = 0.0_wp
   end type anchor_t

   !> What the parts are called in remedies: a program that reads files may have other words for them.
   type :: builder_words_t
      !> What a joint or a load may be fixed to.
      character(len=64) :: anchors = 'a body, a point or "ground" that was added before'
      !> What to do about a name that nothing has.
      character(len=64) :: add = 'add it first, or correct the name'
      !> A point of the ground, a point mass, and a bushing.
      character(len=32) :: ground_point = 'a point of the ground', point_mass = 'a point mass', bushing = 'a bushing'
   end type builder_words_t

   !> A mechanism that is being built.
   type :: mechanism_builder_t
      !> What was wrong first.
      type(error_t), allocatable :: error
      !> Words of remedies.
      type(builder_words_t) :: words
      !> Whether it is in the plane x-y, and its gravity [m/s^2]; to be set before anything is added.
      logical :: planar = .false.
      real(wp) :: gravity(3) = 0.0_wp
      !> The parts so far: so many of each list count.
      integer :: body_count = 0, joint_count = 0, function_count = 0, load_count = 0, spring_count = 0, element_count = 0
      integer :: bushing_count = 0, point_count = 0, event_count = 0, anchor_count = 0
      type(body_t), allocatable :: bodies(:)
      type(joint_t), allocatable :: joints(:)
      type(time_function_t), allocatable :: functions(:)
      type(load_t), allocatable :: loads(:)
      type(spring_t), allocatable :: springs(:)
      type(bushing_t), allocatable :: bushings(:)
      type(element_t), allocatable :: elements(:)
      type(point_t), allocatable :: points(:)
      type(event_t), allocatable :: events(:)
      type(anchor_t), allocatable :: anchors(:)
      !> Joints whose reactions are written out; not allocated for all.
      integer, allocatable :: shown(:)
      !> Springs whose force and length, and bushings whose force and moment are written out; not allocated for none.
      integer, allocatable :: shown_springs(:), shown_bushings(:)
      !> What is taken, and may not be what was meant; not allocated for nothing.
      type(error_t), allocatable :: notes(:)
      type(name_index_t), private :: anchor_names, joint_names, function_names, event_names
   contains
      procedure :: add_body
      procedure :: add_point_mass
      procedure :: add_ground_point
      procedure :: add_point
      procedure :: add_function
      procedure :: add_joint
      procedure :: add_rolling
      procedure :: add_knife_edge
      procedure :: add_load
      procedure :: add_spring
      procedure :: add_bushing
      procedure :: add_beam
      procedure :: add_event
      procedure :: show_joints
      procedure :: show_springs
      procedure :: complete
      procedure :: find_anchor
      procedure :: find_function
      procedure :: find_joint
      procedure :: start_pose
   end type mechanism_builder_t

   interface
      !> A rigid body. Its inertia is given, or follows from its shape; where it is by position and one of angle, orientation,
      !! quaternion, or by its ends.
      module subroutine add_body(self, name, mass, inertia, shape, length, thickness, size, radius, position, from, to, angle, &
                                 orientation, quaternion, velocity, angular_velocity, angle_rate)
         !> The builder.
         class(mechanism_builder_t), intent(inout) :: self
         !> Its name: letters, digits, - and _; bodies, points and joints share their names.
         character(*), intent(in) :: name
         !> Mass [kg].
         real(wp), intent(in) :: mass
         !> Moments of inertia about the center of mass, Jxx, Jyy, Jzz, Jxy, Jxz, Jyz in body axes; in the plane Jzz alone [kg m^2].
         real(wp), intent(in), optional :: inertia(:)
         !> `rod`, `box`, `sphere` or `cylinder`, of uniform density.
         character(*), intent(in), optional :: shape
         !> Length of a rod or of a cylinder; default from end to end [m].
         real(wp), intent(in), optional :: length
         !> Thickness of a rod; default 1/1000 of its length, in the plane 0 [m].
         real(wp), intent(in), optional :: thickness
         !> Sides of a box along its axes [m].
         real(wp), intent(in), optional :: size(3)
         !> Radius of a sphere (default: half from end to end) or a cylinder [m].
         real(wp), intent(in), optional :: radius
         !> Center of mass; default the origin [m].
         real(wp), intent(in), optional :: position(3)
         !> One end: its axis 1 goes from here, its center of mass is half-way, and its shape lies along it; without ends, a
         !! cylinder lies along axis 3 [m].
         real(wp), intent(in), optional :: from(3)
         !> The other end [m].
         real(wp), intent(in), optional :: to(3)
         !> Angle about z [rad].
         real(wp), intent(in), optional :: angle
         !> Rotation vector [rad].
         real(wp), intent(in), optional :: orientation(3)
         !> Quaternion, its scalar part first, of any length.
         real(wp), intent(in), optional :: quaternion(4)
         !> Velocity of the center of mass [m/s].
         real(wp), intent(in), optional :: velocity(3)
         !> Angular velocity, in global axes [rad/s].
         real(wp), intent(in), optional :: angular_velocity(3)
         !> Angular velocity about z [rad/s].
         real(wp), intent(in), optional :: angle_rate
      end subroutine add_body

      !> A body without size.
      module subroutine add_point_mass(self, name, mass, position, velocity)
         !> The builder.
         class(mechanism_builder_t), intent(inout) :: self
         !> Its name: letters, digits, - and _; bodies, points and joints share their names.
         character(*), intent(in) :: name
         !> Mass [kg].
         real(wp), intent(in) :: mass
         !> Where it is; default the origin [m].
         real(wp), intent(in), optional :: position(3)
         !> Its velocity [m/s].
         real(wp), intent(in), optional :: velocity(3)
      end subroutine add_point_mass

      !> A point of the ground.
      module subroutine add_ground_point(self, name, position)
         !> The builder.
         class(mechanism_builder_t), intent(inout) :: self
         !> Its name: letters, digits, - and _; bodies, points and joints share their names.
         character(*), intent(in) :: name
         !> Where it is [m].
         real(wp), intent(in) :: position(3)
      end subroutine add_ground_point

      !> A point of a body; its position is written out.
      module subroutine add_point(self, name, body, position, in_body_axes)
         !> The builder.
         class(mechanism_builder_t), intent(inout) :: self
         !> Its name: letters, digits, - and _; bodies, points and joints share their names.
         character(*), intent(in) :: name
         !> Its body.
         character(*), intent(in) :: body
         !> Where it is at the start [m].
         real(wp), intent(in) :: position(3)
         !> Whether that is in body axes; default false.
         logical, intent(in), optional :: in_body_axes
      end subroutine add_point

      !> A function of time.
      module subroutine add_function(self, function)
         !> The builder.
         class(mechanism_builder_t), intent(inout) :: self
         !> The function, with its name; see `time_function_t`.
         type(time_function_t), intent(in) :: function
      end subroutine add_function

      !> A joint. Its point is one that both bodies share at the start, or one of each; its axis likewise.
      module subroutine add_joint(self, name, type, body_1, body_2, point, point_1, point_2, axis, axis_1, axis_2, in_body_axes, &
                                  angle, length, value, drive, drive_angle)
         !> The builder.
         class(mechanism_builder_t), intent(inout) :: self
         !> Its name: letters, digits, - and _; bodies, points and joints share their names.
         character(*), intent(in) :: name
         !> One of `general_types`.
         character(*), intent(in) :: type
         !> A body, a point or `ground`.
         character(*), intent(in) :: body_1
         !> A body or a point; reactions are those on it.
         character(*), intent(in) :: body_2
         !> The point that both share [m].
         real(wp), intent(in), optional :: point(3)
         !> The point of body 1 [m].
         real(wp), intent(in), optional :: point_1(3)
         !> The point of body 2 [m].
         real(wp), intent(in), optional :: point_2(3)
         !> The axis that both share, of any length.
         real(wp), intent(in), optional :: axis(3)
         !> The axis of body 1.
         real(wp), intent(in), optional :: axis_1(3)
         !> The axis of body 2.
         real(wp), intent(in), optional :: axis_2(3)
         !> Whether points and axes of one body are in its axes; default false.
         logical, intent(in), optional :: in_body_axes
         !> The angle at the start; default 0 [rad].
         real(wp), intent(in), optional :: angle
         !> Of a distance; default as drawn [m].
         real(wp), intent(in), optional :: length
         !> Of a coordinate; default as drawn [m].
         real(wp), intent(in), optional :: value
         !> Function that drives its displacement.
         character(*), intent(in), optional :: drive
         !> Function that drives its angle.
         character(*), intent(in), optional :: drive_angle
      end subroutine add_joint

      !> A disc that rolls on a plane of the ground without slipping.
      module subroutine add_rolling(self, name, body, radius, axis, center, normal, plane_point)
         !> The builder.
         class(mechanism_builder_t), intent(inout) :: self
         !> Its name: letters, digits, - and _; bodies, points and joints share their names.
         character(*), intent(in) :: name
         !> The disc.
         character(*), intent(in) :: body
         !> Its radius [m].
         real(wp), intent(in) :: radius
         !> Its axis.
         real(wp), intent(in) :: axis(3)
         !> Its center; default the center of mass [m].
         real(wp), intent(in), optional :: center(3)
         !> Normal of the plane; default z.
         real(wp), intent(in), optional :: normal(3)
         !> A point of the plane; default the origin [m].
         real(wp), intent(in), optional :: plane_point(3)
      end subroutine add_rolling

      !> A point of a body that does not move across an edge that is fixed in the body.
      module subroutine add_knife_edge(self, name, body, across, point)
         !> The builder.
         class(mechanism_builder_t), intent(inout) :: self
         !> Its name: letters, digits, - and _; bodies, points and joints share their names.
         character(*), intent(in) :: name
         !> The body.
         character(*), intent(in) :: body
         !> Direction across the edge, at the start.
         real(wp), intent(in) :: across(3)
         !> The point; default the center of mass [m].
         real(wp), intent(in), optional :: point(3)
      end subroutine add_knife_edge

      !> A force, or a moment, on a body.
      module subroutine add_load(self, body, value, name, moment, point, follow, function)
         !> The builder.
         class(mechanism_builder_t), intent(inout) :: self
         !> The body, or a point of one.
         character(*), intent(in) :: body
         !> The force [N] or the moment [N m].
         real(wp), intent(in) :: value(3)
         !> Its name; default none.
         character(*), intent(in), optional :: name
         !> Whether it is a moment; default false.
         logical, intent(in), optional :: moment
         !> Where a force acts; default the point, or the center of mass [m].
         real(wp), intent(in), optional :: point(3)
         !> Whether it turns with the body; default false.
         logical, intent(in), optional :: follow
         !> Function that it is multiplied with; default 1.
         character(*), intent(in), optional :: function
      end subroutine add_load

      !> A spring with a damper, between two points or about the axis of a joint: F = preload + stiffness (length - free length) +
      !! damping rate, tension is positive; about a joint with angles in the place of lengths.
      module subroutine add_spring(self, body_1, body_2, point_1, point_2, in_body_axes, joint, stiffness, damping, free_length, &
                                   free_angle, preload, name)
         !> The builder.
         class(mechanism_builder_t), intent(inout) :: self
         !> A body, a point or `ground`.
         character(*), intent(in), optional :: body_1
         !> A body or a point.
         character(*), intent(in), optional :: body_2
         !> The point of body 1; default the center of mass [m].
         real(wp), intent(in), optional :: point_1(3)
         !> The point of body 2; default the center of mass [m].
         real(wp), intent(in), optional :: point_2(3)
         !> Whether points are in the axes of their bodies; default false.
         logical, intent(in), optional :: in_body_axes
         !> The joint about whose axis it acts, in the place of bodies.
         character(*), intent(in), optional :: joint
         !> Stiffness [N/m] or [N m/rad].
         real(wp), intent(in), optional :: stiffness
         !> Damping [N s/m] or [N m s/rad].
         real(wp), intent(in), optional :: damping
         !> Length without force; default as drawn [m].
         real(wp), intent(in), optional :: free_length
         !> Angle without moment; default as drawn [rad].
         real(wp), intent(in), optional :: free_angle
         !> Force [N] or moment [N m] at the free length.
         real(wp), intent(in), optional :: preload
         !> Its name; default none.
         character(*), intent(in), optional :: name
      end subroutine add_spring

      !> An elastic connection in all directions, with dampers, which is relaxed where its points and axes are drawn together.
      module subroutine add_bushing(self, body_1, body_2, point, point_1, point_2, axis, side, in_body_axes, stiffness, &
                                    rotational_stiffness, damping, rotational_damping, name)
         !> The builder.
         class(mechanism_builder_t), intent(inout) :: self
         !> A body, a point or `ground`.
         character(*), intent(in) :: body_1
         !> A body or a point; forces and moments are those on it.
         character(*), intent(in) :: body_2
         !> The point that both share; default that of the other, or the center of mass of body 2 [m].
         real(wp), intent(in), optional :: point(3)
         !> The point of body 1 [m].
         real(wp), intent(in), optional :: point_1(3)
         !> The point of body 2 [m].
         real(wp), intent(in), optional :: point_2(3)
         !> Direction of its axis 3, of any length; default z.
         real(wp), intent(in), optional :: axis(3)
         !> Direction of its axis 1, of which the part across axis 3 counts; default x, or z along x.
         real(wp), intent(in), optional :: side(3)
         !> Whether points are in the axes of their bodies, and directions in those of body 1; default false.
         logical, intent(in), optional :: in_body_axes
         !> Stiffness along its axes; default 0 [N/m].
         real(wp), intent(in), optional :: stiffness(3)
         !> Stiffness about its axes; default 0 [N m/rad].
         real(wp), intent(in), optional :: rotational_stiffness(3)
         !> Damping along its axes; default 0 [N s/m].
         real(wp), intent(in), optional :: damping(3)
         !> Damping about its axes; default 0 [N m s/rad].
         real(wp), intent(in), optional :: rotational_damping(3)
         !> Its name; default none.
         character(*), intent(in), optional :: name
      end subroutine add_bushing

      !> Chooses the springs and dampers whose force and length, or moment and angle, and the bushings whose force and moment are
      !! written out; without a call, none.
      module subroutine show_springs(self, names)
         !> The builder; its error is set for a name that is not one spring's, or that has other columns.
         class(mechanism_builder_t), intent(inout) :: self
         !> Their names: (springs); without it, all.
         character(*), intent(in), optional :: names(:)
      end subroutine show_springs

      !> A straight beam of finite-volume elements; its nodes are the bodies name1, name2, ...
      module subroutine add_beam(self, name, from, to, elements, young, density, thickness, width, poisson, axis_2, damping)
         !> The builder.
         class(mechanism_builder_t), intent(inout) :: self
         !> Its name: letters, digits, - and _; bodies, points and joints share their names.
         character(*), intent(in) :: name
         !> One end [m].
         real(wp), intent(in) :: from(3)
         !> The other [m].
         real(wp), intent(in) :: to(3)
         !> Number of elements.
         integer, intent(in) :: elements
         !> Young's modulus [Pa].
         real(wp), intent(in) :: young
         !> Density [kg/m^3].
         real(wp), intent(in) :: density
         !> Thickness along axis 2 [m].
         real(wp), intent(in) :: thickness
         !> Width along axis 3 [m].
         real(wp), intent(in) :: width
         !> Poisson's ratio; default 0.3.
         real(wp), intent(in), optional :: poisson
         !> Direction of the thickness; default y.
         real(wp), intent(in), optional :: axis_2(3)
         !> Time constant of viscous damping; default 0 [s].
         real(wp), intent(in), optional :: damping
      end subroutine add_beam

      !> Something that passes a value and is recorded.
      module subroutine add_event(self, name, quantity, value, joint, point)
         !> The builder.
         class(mechanism_builder_t), intent(inout) :: self
         !> Its name, without blanks and commas.
         character(*), intent(in) :: name
         !> `angle` or `displacement` of a joint, `x`, `y` or `z` of a point.
         character(*), intent(in) :: quantity
         !> The value [rad] or [m].
         real(wp), intent(in) :: value
         !> The joint that is watched.
         character(*), intent(in), optional :: joint
         !> The point, or body, that is watched.
         character(*), intent(in), optional :: point
      end subroutine add_event
   end interface

   ! What all of them need.
   interface
      !> A name must be fit for the header of a table, and no other's.
      module subroutine check_name(self, name, of_joint)
         type(mechanism_builder_t), intent(inout) :: self
         character(*), intent(in) :: name
         logical, intent(in) :: of_joint
      end subroutine check_name

      !> Names the part in the error, if something is wrong.
      module subroutine locate(self, kind, name)
         type(mechanism_builder_t), intent(inout) :: self
         character(*), intent(in) :: kind, name
      end subroutine locate

      !> Notes something that is taken.
      module subroutine note(self, kind, name, what, remedy)
         type(mechanism_builder_t), intent(inout) :: self
         character(*), intent(in) :: kind, name, what, remedy
      end subroutine note

      !> Notes an angle of more than a turn: it may be in degrees.
      module subroutine note_angle(self, kind, name, what, angle)
         type(mechanism_builder_t), intent(inout) :: self
         character(*), intent(in) :: kind, name, what
         real(wp), intent(in), optional :: angle
      end subroutine note_angle

      !> Notes a point that is far off the body that it belongs to: its unit may be another one.
      module subroutine note_far(self, kind, name, what, number, p)
         type(mechanism_builder_t), intent(inout) :: self
         character(*), intent(in) :: kind, name, what
         !> The body, 0 for the ground; the point from its center of mass [m].
         integer, intent(in) :: number
         real(wp), intent(in) :: p(3)
      end subroutine note_far

      !> What may have been meant, before what else to do.
      module function meant_of(name, known) result(text)
         character(*), intent(in) :: name, known(:)
         character(:), allocatable :: text
      end function meant_of

      !> Adds an anchor.
      module subroutine keep_anchor(self, anchor)
         type(mechanism_builder_t), intent(inout) :: self
         type(anchor_t), intent(in) :: anchor
      end subroutine keep_anchor
   end interface

contains

   !> Chooses the joints whose reactions are written out; without a call, all.
   subroutine show_joints(self, names)
      !> The builder.
      class(mechanism_builder_t), intent(inout) :: self
      !> Their names; may be none: (joints).
      character(*), intent(in) :: names(:)
      integer :: i

      if (allocated(self%error)) return
      self%shown = [(self%find_joint(names(i), 'joints'), i=1, size(names))]
   end subroutine show_joints

   !> The mechanism, its start brought to the joints.
   subroutine complete(self, mechanism, start, error)
      !> The builder; may be added to afterwards.
      class(mechanism_builder_t), intent(in) :: self
      !> The mechanism.
      type(mechanism_t), intent(out) :: mechanism
      !> Where it starts, as drawn: `simulate` brings it to the constraints.
      type(state_t), intent(out) :: start
      !> What was wrong first, while parts were added or now.
      type(error_t), allocatable, intent(inout) :: error
      type(error_t), allocatable :: first

      if (allocated(self%error)) then
         allocate (first, source=self%error)
         if (.not. allocated(error)) call move_alloc(first, error)
         return
      end if
      if (self%body_count == 0) then
         call raise(error, 'mechanism', 'it has no body', 'add one')
         return
      end if
      mechanism%planar = self%planar
      mechanism%gravity = self%gravity
      mechanism%bodies = self%bodies(:self%body_count)
      if (allocated(self%joints)) mechanism%joints = self%joints(:self%joint_count)
      if (allocated(self%functions)) mechanism%functions = self%functions(:self%function_count)
      if (allocated(self%loads)) mechanism%loads = self%loads(:self%load_count)
      if (allocated(self%springs)) mechanism%springs = self%springs(:self%spring_count)
      if (allocated(self%bushings)) mechanism%bushings = self%bushings(:self%bushing_count)
      if (allocated(self%elements)) mechanism%elements = self%elements(:self%element_count)
      if (allocated(self%points)) mechanism%points = self%points(:self%point_count)
      if (allocated(self%events)) mechanism%events = self%events(:self%event_count)
      if (allocated(self%shown)) mechanism%shown = self%shown
      if (allocated(self%shown_springs)) mechanism%shown_springs = self%shown_springs
      if (allocated(self%shown_bushings)) mechanism%shown_bushings = self%shown_bushings
      call mechanism%complete(error)
      if (.not. allocated(error)) start = mechanism%start_state()
   end subroutine complete

   !> The ground, a body or a point of a name.
   subroutine find_anchor(self, name, what, anchor)
      !> The builder; its error is set if there is none.
      class(mechanism_builder_t), intent(inout) :: self
      !> The name.
      character(*), intent(in) :: name
      !> The argument that it stands in.
      character(*), intent(in) :: what
      !> What it names.
      type(anchor_t), intent(out) :: anchor
      integer :: number

      number = self%anchor_names%find(name)
      if (number > 0) then
         anchor = self%anchors(number)
      else if (name == 'ground') then
         anchor%name = 'ground'
      else if (len_trim(name) == 0) then
         call raise(self%error, '', what//' is not given', 'name a body, a point or "ground"')
      else
         call raise(self%error, '', what//' = "'//trim(name)//'": there is no body or point of this name', &
                    trim(suggestion(self%anchor_names, name, 'name '//trim(self%words%anchors), 'ground')))
      end if
   end subroutine find_anchor

   !> Number of a function; 0 for no name.
   integer function find_function(self, name, what) result(number)
      !> The builder; its error is set if there is none.
      class(mechanism_builder_t), intent(inout) :: self
      !> The name.
      character(*), intent(in), optional :: name
      !> The argument that it stands in.
      character(*), intent(in) :: what

      number = 0
      if (.not. present(name)) return
      if (len_trim(name) == 0) return
      number = self%function_names%find(name)
      if (number == 0) call raise(self%error, '', what//' = "'//trim(name)//'": there is no function of this name', &
                                  trim(suggestion(self%function_names, name, self%words%add)))
   end function find_function

   !> Number of a joint; 0 if there is none.
   integer function find_joint(self, name, what) result(number)
      !> The builder; its error is set if there is none.
      class(mechanism_builder_t), intent(inout) :: self
      !> The name.
      character(*), intent(in) :: name
      !> The argument that it stands in.
      character(*), intent(in) :: what

      number = self%joint_names%find(name)
      if (number == 0) call raise(self%error, '', what//' = "'//trim(name)//'": there is no joint of this name', &
                                  trim(suggestion(self%joint_names, name, self%words%add)))
   end function find_joint

   !> What may have been meant, before what else to do.
   function suggestion(names, name, rest, further) result(text)
      type(name_index_t), intent(in) :: names
      character(*), intent(in) :: name, rest
      !> One more name that there is.
      character(*), intent(in), optional :: further
      character(len=len(name) + len(name)/3 + len(rest) + 24) :: text
      character(len=len(name) + len(name)/3 + 1) :: meant

      meant = names%nearest_to(name)
      if (meant == '' .and. present(further)) meant = nearest_name(name, [further])
      text = rest
      if (meant /= '') text = 'did you mean "'//trim(meant)//'"? Or '//rest
   end function suggestion

   !> Where a body is at the start.
   function start_pose(self, body) result(it)
      !> The builder.
      class(mechanism_builder_t), intent(in) :: self
      !> The body; 0 is the ground.
      integer, intent(in) :: body
      !> Its pose, without velocities.
      type(pose_t) :: it

      call ground_pose(it)
      if (body == 0) return
      it%p = self%bodies(body)%position
      it%r = matrix_of_quaternion(self%bodies(body)%orientation)
   end function start_pose

end module taut_model_mechanism_builder
