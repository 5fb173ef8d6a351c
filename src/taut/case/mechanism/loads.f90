!> Groups of a mechanism's case file that make forces: &gravity, &force, &moment, &spring, &damper.
module taut_case_mechanism_loads
   use taut_kinds, only: wp
   use taut_error, only: raise
   use taut_case_entries, only: entries_t
   use taut_case_mechanism_bodies, only: frames
   use taut_case_mechanism_part, only: declare_vector, part_t
   use taut_model_mechanism_builder, only: mechanism_builder_t
   implicit none (type, external)
   private
   public :: gravity_group_t, load_group_t, spring_group_t

   !> &gravity.
   type, extends(part_t) :: gravity_group_t
      real(wp), allocatable :: acceleration(:)
   contains
      procedure :: declare => declare_gravity
      procedure :: add => add_gravity
   end type gravity_group_t

   !> &force, and &moment.
   type, extends(part_t) :: load_group_t
      logical :: moment = .false., follow = .false.
      character(:), allocatable :: body, function
      real(wp), allocatable :: value(:), point(:)
   contains
      procedure :: declare => declare_load
      procedure :: numbered => body_of_load
      procedure :: add => add_load
   end type load_group_t

   !> &spring, and &damper.
   type, extends(part_t) :: spring_group_t
      logical :: damper = .false.
      character(:), allocatable :: body_1, body_2, joint
      character(len=6) :: frame = 'global'
      real(wp), allocatable :: point_1(:), point_2(:), stiffness, damping, free_length, free_angle, preload
   contains
      procedure :: declare => declare_spring
      procedure :: numbered => ends_of_spring
      procedure :: add => add_spring
   end type spring_group_t

contains

   !> Entries of &gravity.
   subroutine declare_gravity(self, entries)
      !> What the group says.
      class(gravity_group_t), intent(inout) :: self
      !> What passes over them.
      type(entries_t), intent(inout) :: entries

      call entries%group('gravity', 'acceleration of gravity; without the group there is none')
      call declare_vector(entries, self%planar, 'acceleration', self%acceleration, 'm/s^2', &
                          'without: 0, 0, -9.81; in the plane 0, -9.81')
   end subroutine declare_gravity

   !> Sets gravity.
   subroutine add_gravity(self, builder, copy)
      !> What the group says.
      class(gravity_group_t), intent(in) :: self
      !> Takes it.
      type(mechanism_builder_t), intent(inout) :: builder
      !> There is one.
      integer, intent(in) :: copy

      associate (unused => copy)
      end associate
      builder%gravity = [0.0_wp, 0.0_wp, -9.81_wp]
      if (builder%planar) builder%gravity = [0.0_wp, -9.81_wp, 0.0_wp]
      if (allocated(self%acceleration)) builder%gravity = self%acceleration
      if (builder%planar .and. abs(builder%gravity(3)) > 0.0_wp) &
         call raise(builder%error, '', 'it leaves the plane x-y', 'give z = 0; without an entry it is 9.81 m/s^2 against y')
   end subroutine add_gravity

   !> Entries of &force and &moment.
   subroutine declare_load(self, entries)
      !> What the group says.
      class(load_group_t), intent(inout) :: self
      !> What passes over them.
      type(entries_t), intent(inout) :: entries

      if (self%moment) then
         call entries%group('moment', 'a moment on a body')
      else
         call entries%group('force', 'a force on a body')
      end if
      call self%declare_name(entries, 'for people')
      call entries%option('body', self%body, 'a body, a point mass or a point')
      if (self%moment .and. self%planar) then
         call entries%option('value', self%value, 'N m', 'about z', [1, 3])
      else if (self%moment) then
         call entries%option('value', self%value, 'N m', 'in global axes; with follow: at the start; in the plane one number, '// &
                             'about z', [3])
      else
         call declare_vector(entries, self%planar, 'value', self%value, 'N', 'in global axes; with follow: at the start')
      end if
      if (allocated(self%value)) then
         if (size(self%value) == 1) self%value = [0.0_wp, 0.0_wp, self%value]
      end if
      call declare_vector(entries, self%planar, 'point', self%point, 'm', &
                          'where a force acts, in global axes at the start; without: the center of mass')
      call entries%item('follow', self%follow, 'whether it turns with the body; else it keeps its direction')
      call entries%option('function', self%function, 'name of a function that it is multiplied with; of several, their '// &
                          '&function of kind = "sum"')
      call self%declare_copies(entries)
   end subroutine declare_load

   !> Of copies, the body must have a number.
   function body_of_load(self) result(text)
      !> What the group says.
      class(load_group_t), intent(in) :: self
      !> As written.
      character(:), allocatable :: text

      text = ''
      if (allocated(self%body)) text = self%body
   end function body_of_load

   !> Adds a force or a moment.
   subroutine add_load(self, builder, copy)
      !> What the group says.
      class(load_group_t), intent(in) :: self
      !> Takes it.
      type(mechanism_builder_t), intent(inout) :: builder
      !> Which copy, from 0 on.
      integer, intent(in) :: copy
      character(:), allocatable :: body, function

      call self%copy_text(self%body, copy, body)
      if (.not. allocated(body)) body = ''
      call self%copy_text(self%function, copy, function)
      if (.not. allocated(self%value)) then
         call raise(builder%error, '', 'its value is not given', 'give value = x, y, z')
         return
      end if
      call builder%add_load(body, self%value, self%copied(copy), self%moment, self%point, self%follow, function)
   end subroutine add_load

   !> Entries of &spring and &damper.
   subroutine declare_spring(self, entries)
      !> What the group says.
      class(spring_group_t), intent(inout) :: self
      !> What passes over them.
      type(entries_t), intent(inout) :: entries

      if (self%damper) then
         call entries%group('damper', 'the same as a spring')
      else
         call entries%group('spring', 'a spring with a damper, between two points or about the axis of a joint: preload + '// &
                            'stiffness (length - free_length) + damping rate, tension is positive; about a joint with angles')
      end if
      call self%declare_name(entries, 'for people')
      call entries%option('body_1', self%body_1, 'a body, a point mass or a point; without: "ground"')
      call entries%option('body_2', self%body_2, 'the other')
      call declare_vector(entries, self%planar, 'point_1', self%point_1, 'm', 'point of body_1; without: its center of mass')
      call declare_vector(entries, self%planar, 'point_2', self%point_2, 'm', 'point of body_2; without: its center of mass')
      call entries%item('frame', self%frame, 'axes of the points: global ones at the start, or those of their bodies', frames)
      call entries%option('joint', self%joint, 'in the place of bodies: a revolute or cylindrical joint about whose axis it acts')
      call entries%option('stiffness', self%stiffness, 'N/m or N m/rad', 'a negative one drives away from the free length')
      call entries%option('damping', self%damping, 'N s/m or N m s/rad', 'not negative')
      call entries%option('free_length', self%free_length, 'm', 'without: that at the start')
      call entries%option('free_angle', self%free_angle, 'rad', 'without: that at the start')
      call entries%option('preload', self%preload, 'N or N m', 'force or moment at the free length; tension is positive')
      call self%declare_copies(entries)
   end subroutine declare_spring

   !> Of copies, an end must have a number.
   function ends_of_spring(self) result(text)
      !> What the group says.
      class(spring_group_t), intent(in) :: self
      !> As written.
      character(:), allocatable :: text

      text = ''
      if (allocated(self%body_2)) text = self%body_2
      if (allocated(self%joint)) text = text//self%joint
   end function ends_of_spring

   !> Adds a spring or a damper.
   subroutine add_spring(self, builder, copy)
      !> What the group says.
      class(spring_group_t), intent(in) :: self
      !> Takes it.
      type(mechanism_builder_t), intent(inout) :: builder
      !> Which copy, from 0 on.
      integer, intent(in) :: copy
      character(:), allocatable :: body_1, body_2, joint

      if (.not. self%damper .and. .not. allocated(self%stiffness) .and. .not. allocated(self%preload)) &
         call raise(builder%error, '', 'it has neither stiffness nor preload', 'give stiffness in N/m or N m/rad')
      if (self%damper .and. .not. allocated(self%damping)) &
         call raise(builder%error, '', 'its damping is not given', 'give damping in N s/m or N m s/rad')
      call self%copy_text(self%body_1, copy, body_1)
      call self%copy_text(self%body_2, copy, body_2)
      call self%copy_text(self%joint, copy, joint)
      call builder%add_spring(body_1, body_2, self%point_1, self%point_2, self%frame == 'body', joint, self%stiffness, &
                              self%damping, self%free_length, self%free_angle, self%preload, self%copied(copy))
   end subroutine add_spring

end module taut_case_mechanism_loads
