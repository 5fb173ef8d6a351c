!> Groups of a mechanism's case file that make bodies and points: &body, &point_mass, &ground_point, &point.
module taut_case_mechanism_bodies
   use taut_kinds, only: wp
   use taut_error, only: raise
   use taut_case_entries, only: entries_t
   use taut_case_mechanism_part, only: declare_vector, moving_t, part_t
   use taut_model_mechanism_builder, only: mechanism_builder_t
   implicit none (type, external)
   private
   public :: body_group_t, point_mass_group_t, ground_point_group_t, point_group_t, frames

   !> In which axes points and directions are given: global ones at the start, or those of the body.
   character(len=6), parameter :: frames(2) = [character(len=6) :: 'global', 'body']

   !> &body.
   type, extends(part_t) :: body_group_t
      real(wp), allocatable :: mass, inertia(:), length, thickness, size(:), radius, angle, orientation(:), quaternion(:), &
                               velocity(:), angular_velocity(:), angle_rate, angle_step
      character(:), allocatable :: shape
      type(moving_t) :: position, from, to
   contains
      procedure :: declare => declare_body
      procedure :: add => add_body
   end type body_group_t

   !> &point_mass.
   type, extends(part_t) :: point_mass_group_t
      real(wp), allocatable :: mass, velocity(:)
      type(moving_t) :: position
   contains
      procedure :: declare => declare_point_mass
      procedure :: add => add_point_mass
   end type point_mass_group_t

   !> &ground_point.
   type, extends(part_t) :: ground_point_group_t
      type(moving_t) :: position
   contains
      procedure :: declare => declare_ground_point
      procedure :: add => add_ground_point
   end type ground_point_group_t

   !> &point.
   type, extends(part_t) :: point_group_t
      character(:), allocatable :: body
      character(len=6) :: frame = 'global'
      type(moving_t) :: position
   contains
      procedure :: declare => declare_point
      procedure :: add => add_point
   end type point_group_t

contains

   !> Entries of &body.
   subroutine declare_body(self, entries)
      !> What the group says.
      class(body_group_t), intent(inout) :: self
      !> What passes over them.
      type(entries_t), intent(inout) :: entries

      call entries%group('body', 'a rigid body, by its mass, its inertia or shape, and where it is at the start')
      call self%declare_name(entries)
      call entries%option('mass', self%mass, 'kg', 'mass')
      call entries%option('inertia', self%inertia, 'kg m^2', 'moments of inertia about the center of mass in body axes: xx, '// &
                          'yy, zz, xy, xz, yz, entries of the tensor: xy is minus the integral of x y dm; in the plane that '// &
                          'about z alone', [1, 3, 6])
      call entries%option('shape', self%shape, 'in the place of inertia, of uniform density: "rod" (length or from, to; '// &
                          'thickness), "box" (size), "sphere" (radius), "cylinder" (radius; length)')
      call entries%option('length', self%length, 'm', 'of a rod along body axis 1; of a cylinder along body axis 3, or 1 if it '// &
                          'is given by its ends; without: from end to end')
      call entries%option('thickness', self%thickness, 'm', 'of a rod''s square section; without: length/1000, in the plane 0')
      call entries%option('size', self%size, 'm', 'three sides of a box along its axes', [3])
      call entries%option('radius', self%radius, 'm', 'of a sphere, without: half from end to end; of a cylinder')
      call self%position%declare(entries, self%planar, 'position', 'center of mass; without: the origin')
      call self%from%declare(entries, self%planar, 'from', 'one end: body axis 1 goes from here, the shape lies along it, the '// &
                             'center of mass is half-way')
      call self%to%declare(entries, self%planar, 'to', 'the other end; from and to are in the place of position and orientation')
      call entries%option('angle', self%angle, 'rad', 'orientation: angle about z')
      call declare_vector(entries, self%planar, 'orientation', self%orientation, 'rad', 'orientation: rotation vector')
      call entries%option('quaternion', self%quaternion, '', 'orientation: quaternion, its scalar part first, of any length', [4])
      call declare_vector(entries, self%planar, 'velocity', self%velocity, 'm/s', &
                          'of the center of mass, in global axes; without: at rest')
      call declare_vector(entries, self%planar, 'angular_velocity', self%angular_velocity, 'rad/s', &
                          'in global axes (wx, wy, wz of results are in body axes); without: none')
      call entries%option('angle_rate', self%angle_rate, 'rad/s', 'angular velocity about z')
      call self%position%declare_step(entries, self%planar, 'position')
      call self%from%declare_step(entries, self%planar, 'from')
      call self%to%declare_step(entries, self%planar, 'to')
      call entries%option('angle_step', self%angle_step, 'rad', 'is added to angle from copy to copy')
      call self%declare_copies(entries)
   end subroutine declare_body

   !> Adds a body.
   subroutine add_body(self, builder, copy)
      !> What the group says.
      class(body_group_t), intent(in) :: self
      !> Takes it.
      type(mechanism_builder_t), intent(inout) :: builder
      !> Which copy, from 0 on.
      integer, intent(in) :: copy
      real(wp), allocatable :: angle, from(:), position(:), to(:)

      if (.not. has_mass(builder, self%mass)) return
      call self%position%of_copy(copy, position, from_origin=.true.)
      call self%from%of_copy(copy, from)
      call self%to%of_copy(copy, to)
      if (allocated(self%angle)) angle = self%angle
      if (allocated(self%angle_step)) then
         if (.not. allocated(angle)) angle = 0.0_wp
         angle = angle + copy*self%angle_step
      end if
      call builder%add_body(self%copied(copy), self%mass, self%inertia, self%shape, self%length, self%thickness, self%size, &
                            self%radius, position, from, to, angle, self%orientation, self%quaternion, self%velocity, &
                            self%angular_velocity, self%angle_rate)
   end subroutine add_body

   !> Whether a mass is given; else that is wrong.
   logical function has_mass(builder, mass)
      type(mechanism_builder_t), intent(inout) :: builder
      real(wp), allocatable, intent(in) :: mass

      has_mass = allocated(mass)
      if (.not. has_mass) call raise(builder%error, '', 'it has no mass', 'give mass in kg')
   end function has_mass

   !> Entries of &point_mass.
   subroutine declare_point_mass(self, entries)
      !> What the group says.
      class(point_mass_group_t), intent(inout) :: self
      !> What passes over them.
      type(entries_t), intent(inout) :: entries

      call entries%group('point_mass', 'a body without size')
      call self%declare_name(entries)
      call entries%option('mass', self%mass, 'kg', 'mass')
      call self%position%declare(entries, self%planar, 'position', 'where it is at the start; without: the origin')
      call declare_vector(entries, self%planar, 'velocity', self%velocity, 'm/s', 'at the start; without: at rest')
      call self%position%declare_step(entries, self%planar, 'position')
      call self%declare_copies(entries)
   end subroutine declare_point_mass

   !> Adds a point mass.
   subroutine add_point_mass(self, builder, copy)
      !> What the group says.
      class(point_mass_group_t), intent(in) :: self
      !> Takes it.
      type(mechanism_builder_t), intent(inout) :: builder
      !> Which copy, from 0 on.
      integer, intent(in) :: copy
      real(wp), allocatable :: position(:)

      if (.not. has_mass(builder, self%mass)) return
      call self%position%of_copy(copy, position, from_origin=.true.)
      call builder%add_point_mass(self%copied(copy), self%mass, position, self%velocity)
   end subroutine add_point_mass

   !> Entries of &ground_point.
   subroutine declare_ground_point(self, entries)
      !> What the group says.
      class(ground_point_group_t), intent(inout) :: self
      !> What passes over them.
      type(entries_t), intent(inout) :: entries

      call entries%group('ground_point', 'a point of the ground; the ground itself is called "ground"')
      call self%declare_name(entries)
      call self%position%declare(entries, self%planar, 'position', 'where it is; without: the origin')
      call self%position%declare_step(entries, self%planar, 'position')
      call self%declare_copies(entries)
   end subroutine declare_ground_point

   !> Adds a point of the ground.
   subroutine add_ground_point(self, builder, copy)
      !> What the group says.
      class(ground_point_group_t), intent(in) :: self
      !> Takes it.
      type(mechanism_builder_t), intent(inout) :: builder
      !> Which copy, from 0 on.
      integer, intent(in) :: copy
      real(wp), allocatable :: position(:)

      call self%position%of_copy(copy, position, from_origin=.true.)
      if (.not. allocated(position)) allocate (position(3), source=0.0_wp)
      call builder%add_ground_point(self%copied(copy), position)
   end subroutine add_ground_point

   !> Entries of &point.
   subroutine declare_point(self, entries)
      !> What the group says.
      class(point_group_t), intent(inout) :: self
      !> What passes over them.
      type(entries_t), intent(inout) :: entries

      call entries%group('point', 'a point of a body; its position is written out')
      call self%declare_name(entries)
      call entries%option('body', self%body, 'its body')
      call self%position%declare(entries, self%planar, 'position', 'where it is; without: the origin of frame')
      call entries%item('frame', self%frame, 'axes of position: global ones at the start, or those of the body', frames)
      call self%position%declare_step(entries, self%planar, 'position')
      call self%declare_copies(entries)
   end subroutine declare_point

   !> Adds a point of a body.
   subroutine add_point(self, builder, copy)
      !> What the group says.
      class(point_group_t), intent(in) :: self
      !> Takes it.
      type(mechanism_builder_t), intent(inout) :: builder
      !> Which copy, from 0 on.
      integer, intent(in) :: copy
      character(:), allocatable :: body
      real(wp), allocatable :: position(:)

      call self%position%of_copy(copy, position, from_origin=.true.)
      if (.not. allocated(position)) allocate (position(3), source=0.0_wp)
      call self%copy_text(self%body, copy, body)
      if (.not. allocated(body)) body = ''
      call builder%add_point(self%copied(copy), body, position, self%frame == 'body')
   end subroutine add_point

end module taut_case_mechanism_bodies
