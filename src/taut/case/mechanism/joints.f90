!> Groups of a mechanism's case file that make joints: &joint, &rolling, &knife_edge.
module taut_case_mechanism_joints
   use taut_kinds, only: wp
   use taut_error, only: raise, to_text
   use taut_case_entries, only: entries_t
   use taut_case_mechanism_bodies, only: frames
   use taut_case_mechanism_part, only: declare_vector, moving_t, part_t
   use taut_model_mechanism_builder, only: mechanism_builder_t
   use taut_model_mechanism_joint_table, only: in_plane, in_space, joint_kind_t, joint_kinds
   implicit none (type, external)
   private
   public :: joint_group_t, rolling_group_t, knife_edge_group_t

   !> &joint.
   type, extends(part_t) :: joint_group_t
      character(:), allocatable :: type, body_1, body_2, drive, drive_angle
      character(len=6) :: frame = 'global'
      real(wp), allocatable :: point_1(:), point_2(:), axis(:), axis_1(:), axis_2(:), length, value
      real(wp) :: angle = 0.0_wp
      type(moving_t) :: point
   contains
      procedure :: declare => declare_joint
      procedure :: add => add_joint
   end type joint_group_t

   !> &rolling.
   type, extends(part_t) :: rolling_group_t
      character(:), allocatable :: body
      real(wp), allocatable :: radius, axis(:), center(:), normal(:), plane_point(:)
   contains
      procedure :: declare => declare_rolling
      procedure :: add => add_rolling
   end type rolling_group_t

   !> &knife_edge.
   type, extends(part_t) :: knife_edge_group_t
      character(:), allocatable :: body
      real(wp), allocatable :: point(:), across(:)
   contains
      procedure :: declare => declare_knife_edge
      procedure :: add => add_knife_edge
   end type knife_edge_group_t

contains

   !> Entries of &joint.
   subroutine declare_joint(self, entries)
      !> What the group says.
      class(joint_group_t), intent(inout) :: self
      !> What passes over them.
      type(entries_t), intent(inout) :: entries

      if (.not. allocated(self%body_1)) self%body_1 = 'ground'
      call entries%group('joint', 'joins two bodies, or a body and the ground; its reactions are those on body_2')
      call self%declare_name(entries)
      call entries%option('type', self%type, 'what it is, with its number of rows in space and in the plane: '//types_in_words())
      call entries%option('body_1', self%body_1, 'a body, a point mass, a point or "ground"')
      call entries%option('body_2', self%body_2, 'the other; reactions are on it')
      call self%point%declare(entries, self%planar, 'point', 'point that both share at the start, in global axes')
      call declare_vector(entries, self%planar, 'point_1', self%point_1, 'm', &
                          'point of body_1; a side without one takes the other''s, of a distance or a coordinate its center of '// &
                          'mass')
      call declare_vector(entries, self%planar, 'point_2', self%point_2, 'm', 'point of body_2')
      call declare_vector(entries, self%planar, 'axis', self%axis, '', &
                          'axis that both share at the start, of any length; of a planar joint: its normal; in the plane a '// &
                          'revolute one needs none')
      call declare_vector(entries, self%planar, 'axis_1', self%axis_1, '', &
                          'axis of body_1; of a universal joint at right angles to axis_2')
      call declare_vector(entries, self%planar, 'axis_2', self%axis_2, '', 'axis of body_2')
      call entries%item('frame', self%frame, 'axes of point_1, point_2, axis_1, axis_2: global ones at the start, or those of '// &
                        'their bodies', frames)
      call entries%item('angle', self%angle, 'rad', 'angle about the axis at the start')
      call entries%option('length', self%length, 'm', 'of a distance; without: that at the start')
      call entries%option('value', self%value, 'm', 'of a coordinate; without: that at the start')
      call entries%option('drive', self%drive, &
                          'name of the function that drives its displacement; of a distance it is the length, of a coordinate '// &
                          'the value; of several functions, their &function of kind = "sum"')
      call entries%option('drive_angle', self%drive_angle, 'name of the function that drives its angle; of several functions, '// &
                          'their &function of kind = "sum"')
      call self%point%declare_step(entries, self%planar, 'point')
      call self%declare_copies(entries)
   end subroutine declare_joint

   !> The types of joints, from their table.
   function types_in_words() result(text)
      character(:), allocatable :: text
      integer :: i

      text = ''
      do i = 1, size(joint_kinds)
         associate (it => joint_kinds(i))
            if (.not. it%general) cycle
            if (i > 1) text = text//'; '
            text = text//'"'//trim(it%name)//'" '//trim(it%help)//' ('//to_text(rows_of(it, in_space))//', '
            if (it%planar) text = text//to_text(rows_of(it, in_plane))
            if (.not. it%planar) text = text//'-'
            if (it%has_angle) text = text//', drive_angle'
            if (it%has_displacement) text = text//', drive'
            text = text//')'
         end associate
      end do
   end function types_in_words

   !> Number of rows, in space or in the plane.
   pure integer function rows_of(kind, where) result(number)
      type(joint_kind_t), intent(in) :: kind
      integer, intent(in) :: where

      number = count(kind%rows%kind /= 0 .and. (kind%rows%where == where .or. &
                                                .not. (kind%rows%where == in_space .or. kind%rows%where == in_plane)))
   end function rows_of

   !> Adds a joint.
   subroutine add_joint(self, builder, copy)
      !> What the group says.
      class(joint_group_t), intent(in) :: self
      !> Takes it.
      type(mechanism_builder_t), intent(inout) :: builder
      !> Which copy, from 0 on.
      integer, intent(in) :: copy
      character(:), allocatable :: body_1, body_2, drive, drive_angle, type
      real(wp), allocatable :: point(:)

      type = ''
      if (allocated(self%type)) type = self%type
      call self%copy_text(self%body_1, copy, body_1)
      call self%copy_text(self%body_2, copy, body_2)
      if (.not. allocated(body_2)) body_2 = ''
      call self%copy_text(self%drive, copy, drive)
      call self%copy_text(self%drive_angle, copy, drive_angle)
      call self%point%of_copy(copy, point)
      call builder%add_joint(self%copied(copy), type, body_1, body_2, point, self%point_1, self%point_2, self%axis, self%axis_1, &
                             self%axis_2, self%frame == 'body', self%angle, self%length, self%value, drive, drive_angle)
   end subroutine add_joint

   !> Entries of &rolling.
   subroutine declare_rolling(self, entries)
      !> What the group says.
      class(rolling_group_t), intent(inout) :: self
      !> What passes over them.
      type(entries_t), intent(inout) :: entries

      if (.not. allocated(self%normal)) self%normal = [0.0_wp, 0.0_wp, 1.0_wp]
      if (.not. allocated(self%plane_point)) self%plane_point = [0.0_wp, 0.0_wp, 0.0_wp]
      call entries%group('rolling', 'a disc that rolls on a plane of the ground without slipping')
      call self%declare_name(entries)
      call entries%option('body', self%body, 'the disc')
      call entries%option('radius', self%radius, 'm', 'its radius')
      call declare_vector(entries, self%planar, 'axis', self%axis, '', 'its axis at the start')
      call declare_vector(entries, self%planar, 'center', self%center, 'm', 'its center at the start; without: the center of mass')
      call declare_vector(entries, self%planar, 'normal', self%normal, '', 'normal of the plane')
      call declare_vector(entries, self%planar, 'plane_point', self%plane_point, 'm', 'a point of the plane')
   end subroutine declare_rolling

   !> Adds a rolling disc.
   subroutine add_rolling(self, builder, copy)
      !> What the group says.
      class(rolling_group_t), intent(in) :: self
      !> Takes it.
      type(mechanism_builder_t), intent(inout) :: builder
      !> Which copy, from 0 on.
      integer, intent(in) :: copy
      character(:), allocatable :: body

      call self%copy_text(self%body, copy, body)
      if (.not. allocated(body)) body = ''
      if (.not. allocated(self%radius)) call raise(builder%error, '', 'its radius is not given', 'give radius in m')
      if (.not. allocated(self%axis)) call raise(builder%error, '', 'it has no axis', 'give axis = x, y, z')
      if (allocated(builder%error)) return
      call builder%add_rolling(self%copied(copy), body, self%radius, self%axis, self%center, self%normal, self%plane_point)
   end subroutine add_rolling

   !> Entries of &knife_edge.
   subroutine declare_knife_edge(self, entries)
      !> What the group says.
      class(knife_edge_group_t), intent(inout) :: self
      !> What passes over them.
      type(entries_t), intent(inout) :: entries

      call entries%group('knife_edge', 'a point of a body that does not move across an edge, which turns with the body')
      call self%declare_name(entries)
      call entries%option('body', self%body, 'the body')
      call declare_vector(entries, self%planar, 'point', self%point, 'm', 'the point at the start; without: the center of mass')
      call declare_vector(entries, self%planar, 'across', self%across, '', 'direction across the edge at the start')
   end subroutine declare_knife_edge

   !> Adds a knife edge.
   subroutine add_knife_edge(self, builder, copy)
      !> What the group says.
      class(knife_edge_group_t), intent(in) :: self
      !> Takes it.
      type(mechanism_builder_t), intent(inout) :: builder
      !> Which copy, from 0 on.
      integer, intent(in) :: copy
      character(:), allocatable :: body

      call self%copy_text(self%body, copy, body)
      if (.not. allocated(body)) body = ''
      if (.not. allocated(self%across)) call raise(builder%error, '', 'its direction is not given', 'give across = x, y, z')
      if (allocated(builder%error)) return
      call builder%add_knife_edge(self%copied(copy), body, self%across, self%point)
   end subroutine add_knife_edge

end module taut_case_mechanism_joints
