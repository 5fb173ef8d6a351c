!> The group &event of a mechanism's case file.
module taut_case_mechanism_event
   use taut_kinds, only: wp
   use taut_case_entries, only: entries_t
   use taut_case_mechanism_part, only: part_t
   use taut_model_mechanism_builder, only: mechanism_builder_t
   implicit none (type, external)
   private
   public :: event_group_t

   !> &event.
   type, extends(part_t) :: event_group_t
      character(:), allocatable :: joint, quantity, point
      real(wp) :: value = 0.0_wp
   contains
      procedure :: declare
      procedure :: add
   end type event_group_t

contains

   !> Its entries.
   subroutine declare(self, entries)
      !> What the group says.
      class(event_group_t), intent(inout) :: self
      !> What passes over them.
      type(entries_t), intent(inout) :: entries

      call entries%group('event', 'a coordinate that passes a value, which is recorded')
      call self%declare_name(entries, 'by which it is written, without blanks and commas')
      call entries%option('joint', self%joint, 'joint that is watched')
      call entries%option('quantity', self%quantity, 'of a joint "angle" (without one) or "displacement"; of a point "x", "y" '// &
                          'or "z"')
      call entries%option('point', self%point, 'point, or body, that is watched in the place of a joint')
      call entries%item('value', self%value, 'rad or m', 'the value; whole turns count')
   end subroutine declare

   !> Adds an event.
   subroutine add(self, builder, copy)
      !> What the group says.
      class(event_group_t), intent(in) :: self
      !> Takes it.
      type(mechanism_builder_t), intent(inout) :: builder
      !> There is one.
      integer, intent(in) :: copy
      character(:), allocatable :: quantity

      quantity = ''
      if (allocated(self%joint)) quantity = 'angle'
      if (allocated(self%quantity)) quantity = self%quantity
      call builder%add_event(self%copied(copy), quantity, self%value, self%joint, self%point)
   end subroutine add

end module taut_case_mechanism_event
