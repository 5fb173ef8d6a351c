!> A group of a mechanism's case file that adds parts to it, and how it is copied: `repeat`, `first`, # in names, and steps.
module taut_case_mechanism_part
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_case_entries, only: entries_t
   use taut_case_group, only: group_data_t
   use taut_model_mechanism_builder, only: mechanism_builder_t
   implicit none (type, external)
   private
   public :: part_t, moving_t, declare_vector, expand

   !> Copies beyond this are mistakes.
   integer, parameter :: most_copies = 100000

   !> What such a group says.
   type, abstract, extends(group_data_t) :: part_t
      !> Name as written; of a copied part with #.
      character(:), allocatable :: name
      !> The case file, from whose folder paths start.
      character(:), allocatable :: case_path
      !> Whether the mechanism is in the plane x-y; set before the group is read.
      logical :: planar = .false.
      !> Number of copies, and the number of the first.
      integer :: repeat = 1, first = 1
   contains
      procedure :: declare_name
      procedure :: declare_copies
      procedure :: numbered
      procedure :: check_copies
      procedure :: copied
      procedure :: copy_text
      procedure(add_part), deferred :: add
   end type part_t

   abstract interface
      !> Adds a copy to the mechanism.
      subroutine add_part(self, builder, copy)
         import :: mechanism_builder_t, part_t
         implicit none (type, external)
         !> What the group says.
         class(part_t), intent(in) :: self
         !> Takes it; its error is set if something is wrong.
         type(mechanism_builder_t), intent(inout) :: builder
         !> Which copy, from 0 on.
         integer, intent(in) :: copy
      end subroutine add_part
   end interface

   !> A point that moves on from copy to copy.
   type :: moving_t
      !> That of the first copy, and what is added for each further one [m]; not allocated if not given.
      real(wp), allocatable :: at(:), step(:)
   contains
      procedure :: declare
      procedure :: declare_step
      procedure :: of_copy
   end type moving_t

contains

   !> Declares its name.
   subroutine declare_name(self, entries, help)
      !> What the group says.
      class(part_t), intent(inout) :: self
      !> What passes over its entries.
      type(entries_t), intent(inout) :: entries
      !> What the name is for. Default: its letters.
      character(*), intent(in), optional :: help

      if (.not. allocated(self%name)) self%name = ''
      if (present(help)) then
         call entries%option('name', self%name, help)
      else
         call entries%option('name', self%name, 'letters, digits, - and _; no other body, point or joint has it')
      end if
   end subroutine declare_name

   !> Declares that it may be copied.
   subroutine declare_copies(self, entries)
      !> What the group says.
      class(part_t), intent(inout) :: self
      !> What passes over its entries.
      type(entries_t), intent(inout) :: entries

      call entries%item('repeat', self%repeat, 'number of copies; # in a name stands for the number of the copy, #-1 for the '// &
                        'one before, #+1 for the next; steps are added from copy to copy', least=1, most=most_copies)
      call entries%item('first', self%first, 'number of the first copy')
   end subroutine declare_copies

   !> The name that must be another for each copy.
   function numbered(self) result(text)
      !> What the group says.
      class(part_t), intent(in) :: self
      !> As written.
      character(:), allocatable :: text

      text = self%name
   end function numbered

   !> Copies must have names of their own.
   subroutine check_copies(self, error)
      !> What the group says.
      class(part_t), intent(in) :: self
      !> A name without #.
      type(error_t), allocatable, intent(inout) :: error

      if (self%repeat > 1 .and. index(self%numbered(), '#') == 0) &
         call raise(error, '', 'the name has no # for the number of the copy', 'write a name such as "rod#"')
   end subroutine check_copies

   !> The name of a copy.
   function copied(self, copy) result(name)
      !> What the group says.
      class(part_t), intent(in) :: self
      !> Which copy, from 0 on.
      integer, intent(in) :: copy
      !> With its number.
      character(:), allocatable :: name

      name = expand(self%name, self%first + copy)
   end function copied

   !> Another text for a copy.
   subroutine copy_text(self, text, copy, made)
      !> What the group says.
      class(part_t), intent(in) :: self
      !> As written; may be missing.
      character(:), intent(in), allocatable :: text
      !> Which copy, from 0 on.
      integer, intent(in) :: copy
      !> With its number; not allocated if the text is missing.
      character(:), intent(out), allocatable :: made

      if (allocated(text)) made = expand(text, self%first + copy)
   end subroutine copy_text

   !> Declares the point of the first copy.
   subroutine declare(self, entries, planar, name, help)
      !> The point.
      class(moving_t), intent(inout) :: self
      !> What passes over its entries.
      type(entries_t), intent(inout) :: entries
      !> Whether the mechanism is in the plane.
      logical, intent(in) :: planar
      !> Name of the entry.
      character(*), intent(in) :: name
      !> What it is.
      character(*), intent(in) :: help

      call declare_vector(entries, planar, name, self%at, 'm', help)
   end subroutine declare

   !> Declares the step to the next copy.
   subroutine declare_step(self, entries, planar, name)
      !> The point.
      class(moving_t), intent(inout) :: self
      !> What passes over its entries.
      type(entries_t), intent(inout) :: entries
      !> Whether the mechanism is in the plane.
      logical, intent(in) :: planar
      !> Name of the point's entry.
      character(*), intent(in) :: name

      call declare_vector(entries, planar, name//'_step', self%step, 'm', 'is added to '//name//' from copy to copy')
   end subroutine declare_step

   !> The point of a copy.
   subroutine of_copy(self, copy, at, from_origin)
      !> The point.
      class(moving_t), intent(in) :: self
      !> Which copy, from 0 on.
      integer, intent(in) :: copy
      !> Where it is; not allocated if it is not given: (3) [m].
      real(wp), allocatable, intent(out) :: at(:)
      !> Whether a step alone is one from the origin; default: it does nothing.
      logical, intent(in), optional :: from_origin

      if (allocated(self%at)) then
         at = self%at
      else if (present(from_origin) .and. allocated(self%step)) then
         if (from_origin) allocate (at(3), source=0.0_wp)
      end if
      if (allocated(at) .and. allocated(self%step)) at = at + copy*self%step
   end subroutine of_copy

   !> Declares a vector of three numbers, of which the last may be left out in the plane.
   subroutine declare_vector(entries, planar, name, values, unit, help)
      !> What passes over the entries.
      type(entries_t), intent(inout) :: entries
      !> Whether the mechanism is in the plane.
      logical, intent(in) :: planar
      !> Name of the entry.
      character(*), intent(in) :: name
      !> The vector, if there is one: (3).
      real(wp), allocatable, intent(inout) :: values(:)
      !> Its unit.
      character(*), intent(in) :: unit
      !> What it is.
      character(*), intent(in) :: help

      if (planar) then
         call entries%option(name, values, unit, help, [2, 3])
      else
         call entries%option(name, values, unit, help, [3])
      end if
      if (.not. allocated(values)) return
      if (size(values) == 2) values = [values, 0.0_wp]
   end subroutine declare_vector

   !> A name with # replaced by a number, #+2 and #-1 by others.
   function expand(text, number) result(name)
      !> Such as rod#, or rod#-1 for the one before.
      character(*), intent(in) :: text
      !> The number.
      integer, intent(in) :: number
      !> Such as rod7.
      character(:), allocatable :: name
      integer :: i, last, shift, status

      name = trim(text)
      i = index(name, '#')
      if (i == 0) return
      shift = 0
      last = i
      if (i + 2 <= len(name)) then
         if (scan(name(i + 1:i + 1), '+-') == 1) then
            last = i + 1
            do while (last < len(name))
               if (verify(name(last + 1:last + 1), '0123456789') > 0) exit
               last = last + 1
            end do
            if (last > i + 1) read (name(i + 1:last), *, iostat=status) shift
            if (last == i + 1) last = i
         end if
      end if
      name = name(:i - 1)//to_text(number + shift)//name(last + 1:)
   end function expand

end module taut_case_mechanism_part
