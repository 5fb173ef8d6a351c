!> A group of a case file as it is declared: what its entries are is said once, in `declare` of an extension.
module taut_case_group
   use taut_error, only: error_t, raise
   use taut_case_entries, only: entries_t
   use taut_case_namelist_file, only: group_t, namelist_file_t
   implicit none (type, external)
   private
   public :: group_data_t, declared_t, declaration_of, check_groups, read_group, first_group

   !> What a group says.
   type, abstract :: group_data_t
   contains
      procedure(declare_entries), deferred :: declare
   end type group_data_t

   abstract interface
      !> Names the group and passes each of its entries.
      subroutine declare_entries(self, entries)
         import :: group_data_t, entries_t
         implicit none (type, external)
         !> What the group says: the defaults, and what is read.
         class(group_data_t), intent(inout) :: self
         !> What passes over them.
         type(entries_t), intent(inout) :: entries
      end subroutine declare_entries
   end interface

   !> A group that a case file may have.
   type :: declared_t
      !> Its entries.
      type(entries_t) :: entries
      !> Whether it may be there more than once.
      logical :: many = .false.
   end type declared_t

contains

   !> What a group is, from its data with the defaults.
   function declaration_of(data, many) result(declared)
      !> The data.
      class(group_data_t), intent(in) :: data
      !> Whether the group may be there more than once; default: it may not.
      logical, intent(in), optional :: many
      type(declared_t) :: declared
      class(group_data_t), allocatable :: own

      allocate (own, source=data)
      call declared%entries%collect()
      call own%declare(declared%entries)
      if (present(many)) declared%many = many
   end function declaration_of

   !> Complains if the file has no group, one that is not declared, or one twice that may be there once only.
   subroutine check_groups(file, groups, error)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> The groups that it may have.
      type(declared_t), intent(in) :: groups(:)
      !> What is wrong.
      type(error_t), allocatable, intent(inout) :: error
      character(len=32) :: names(size(groups))
      integer :: i

      do i = 1, size(groups)
         names(i) = groups(i)%entries%name
      end do
      call file%only_groups(names, error, many=pack(names, groups%many))
   end subroutine check_groups

   !> Reads a group.
   subroutine read_group(file, group, data, error)
      !> The case file and the group.
      type(namelist_file_t), intent(in) :: file
      type(group_t), intent(in) :: group
      !> The defaults, and what is read.
      class(group_data_t), intent(inout) :: data
      !> An entry that is unknown or impossible.
      type(error_t), allocatable, intent(inout) :: error
      type(entries_t) :: entries
      type(declared_t) :: declared

      if (allocated(error)) return
      call entries%read_from(file%path, group)
      call data%declare(entries)
      if (entries%has_unknown()) then
         declared = declaration_of(data)
         call entries%unknown(declared%entries%list)
      end if
      if (allocated(entries%error)) call move_alloc(entries%error, error)
   end subroutine read_group

   !> Number of the first group of a name; 0 if there is none.
   pure integer function first_group(file, name) result(number)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> In lower case.
      character(*), intent(in) :: name

      do number = 1, size(file%groups)
         if (file%groups(number)%name == name) return
      end do
      number = 0
   end function first_group

end module taut_case_group
