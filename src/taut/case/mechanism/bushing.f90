!> The group &bushing of a mechanism's case file.
module taut_case_mechanism_bushing
   use taut_kinds, only: wp
   use taut_case_entries, only: entries_t
   use taut_case_mechanism_bodies, only: frames
   use taut_case_mechanism_part, only: declare_vector, part_t
   use taut_model_mechanism_builder, only: mechanism_builder_t
   implicit none (type, external)
   private
   public :: bushing_group_t

   !> &bushing.
   type, extends(part_t) :: bushing_group_t
      character(:), allocatable :: body_1, body_2
      character(len=6) :: frame = 'global'
      real(wp), allocatable :: point(:), point_1(:), point_2(:), axis(:), side(:)
      real(wp), allocatable :: stiffness(:), rotational_stiffness(:), damping(:), rotational_damping(:)
   contains
      procedure :: declare
      procedure :: numbered
      procedure :: add
   end type bushing_group_t

contains

   !> Its entries.
   subroutine declare(self, entries)
      !> What the group says.
      class(bushing_group_t), intent(inout) :: self
      !> What passes over them.
      type(entries_t), intent(inout) :: entries

      if (.not. allocated(self%body_1)) self%body_1 = 'ground'
      call entries%group('bushing', 'an elastic connection of two bodies, or of a body and the ground, along and about three '// &
                         'axes; relaxed where its points are at one place and the bodies turned as drawn')
      call self%declare_name(entries, 'for people, and for springs of &output')
      call entries%option('body_1', self%body_1, 'a body, a point or "ground"; a point mass only with the ground')
      call entries%option('body_2', self%body_2, 'the other; force and moment are those on it')
      call declare_vector(entries, self%planar, 'point', self%point, 'm', &
                          'point that both share at the start, in global axes; without: the center of mass of body_2')
      call declare_vector(entries, self%planar, 'point_1', self%point_1, 'm', 'point of body_1, where it is loaded at the start')
      call declare_vector(entries, self%planar, 'point_2', self%point_2, 'm', 'point of body_2')
      call declare_vector(entries, self%planar, 'axis', self%axis, '', 'its axis 3 at the start, of any length; without: z')
      call declare_vector(entries, self%planar, 'side', self%side, '', &
                          'direction of its axis 1 at the start, as far as it is across axis; without: x, or z if '// &
                          'axis is along x')
      call entries%item('frame', self%frame, 'axes of point_1, point_2: global ones at the start, or those of their bodies; of '// &
                        'axis and side those of body_1', frames)
      call declare_vector(entries, self%planar, 'stiffness', self%stiffness, 'N/m', 'along its axes 1, 2, 3; without: 0')
      call declare_turning('rotational_stiffness', self%rotational_stiffness, 'N m/rad', 'about its axes 1, 2, 3')
      call declare_vector(entries, self%planar, 'damping', self%damping, 'N s/m', 'along its axes; without: 0')
      call declare_turning('rotational_damping', self%rotational_damping, 'N m s/rad', 'about its axes')
      call self%declare_copies(entries)

   contains

      !> What is about z alone in the plane.
      subroutine declare_turning(name, values, unit, help)
         character(*), intent(in) :: name, unit, help
         real(wp), allocatable, intent(inout) :: values(:)

         if (self%planar) then
            call entries%option(name, values, unit, help//'; in the plane one number', [1, 3])
         else
            call entries%option(name, values, unit, help//'; in the plane one number', [3])
         end if
         if (.not. allocated(values)) return
         if (size(values) == 1) values = [0.0_wp, 0.0_wp, values]
      end subroutine declare_turning

   end subroutine declare

   !> Of copies, an end must have a number.
   function numbered(self) result(text)
      !> What the group says.
      class(bushing_group_t), intent(in) :: self
      !> As written.
      character(:), allocatable :: text

      text = self%body_1
      if (allocated(self%body_2)) text = text//self%body_2
   end function numbered

   !> Adds a bushing.
   subroutine add(self, builder, copy)
      !> What the group says.
      class(bushing_group_t), intent(in) :: self
      !> Takes it.
      type(mechanism_builder_t), intent(inout) :: builder
      !> Which copy, from 0 on.
      integer, intent(in) :: copy
      character(:), allocatable :: body_1, body_2

      call self%copy_text(self%body_1, copy, body_1)
      call self%copy_text(self%body_2, copy, body_2)
      if (.not. allocated(body_2)) body_2 = ''
      call builder%add_bushing(body_1, body_2, self%point, self%point_1, self%point_2, self%axis, self%side, self%frame == 'body', &
                               self%stiffness, self%rotational_stiffness, self%damping, self%rotational_damping, &
                               self%copied(copy))
   end subroutine add

end module taut_case_mechanism_bushing
