!> A group of a case file as it is declared: what its entries are is said once, in `declare` of an extension.
module taut_case_group
   use taut_error, only: error_t
   use taut_case_entries, only: entries_t
   use taut_case_entry, only: entry_t
   use taut_case_namelist_file, only: group_t, namelist_file_t
   implicit none (type, external)
   private
   public :: group_data_t, declared_t, declare_group, check_groups, read_group, first_group

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
      !> Its name and what it is.
      character(:), allocatable :: name, about
      !> What it says, with the defaults.
      class(group_data_t), allocatable :: data
      !> Whether it may be there more than once.
      logical :: many = .false.
   contains
      procedure :: collect
   end type declared_t

contains

   !> Adds a group to those that a case file may have.
   subroutine declare_group(groups, data, many)
      !> The groups so far; none if not allocated.
      type(declared_t), allocatable, intent(inout) :: groups(:)
      !> What the group says, with the defaults.
      class(group_data_t), intent(in) :: data
      !> Whether it may be there more than once; default: it may not.
      logical, intent(in), optional :: many
      type(declared_t), allocatable :: before(:)
      type(entries_t) :: entries
      integer :: i, n

      n = 0
      if (allocated(groups)) n = size(groups)
      if (n > 0) call move_alloc(groups, before)
      if (allocated(groups)) deallocate (groups)
      allocate (groups(n + 1))
      do i = 1, n
         call move_alloc(before(i)%name, groups(i)%name)
         call move_alloc(before(i)%about, groups(i)%about)
         call move_alloc(before(i)%data, groups(i)%data)
         groups(i)%many = before(i)%many
      end do
      allocate (groups(n + 1)%data, source=data)
      call groups(n + 1)%data%declare(entries)
      groups(n + 1)%name = entries%name
      groups(n + 1)%about = entries%about
      if (present(many)) groups(n + 1)%many = many
   end subroutine declare_group

   !> The entries of a group.
   subroutine collect(self, list)
      !> The group.
      class(declared_t), intent(in) :: self
      !> What it may say.
      type(entry_t), allocatable, intent(out) :: list(:)
      class(group_data_t), allocatable :: data
      type(entries_t) :: entries

      allocate (data, source=self%data)
      call entries%collect()
      call data%declare(entries)
      call move_alloc(entries%list, list)
   end subroutine collect

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
         names(i) = groups(i)%name
      end do
      call file%only_groups(names, error, many=pack(names, groups%many))
   end subroutine check_groups

   !> Reads a group.
   subroutine read_group(file, group, data, error)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> The group.
      type(group_t), intent(in) :: group
      !> The defaults, and what is read.
      class(group_data_t), intent(inout) :: data
      !> An entry that is unknown or impossible.
      type(error_t), allocatable, intent(inout) :: error
      type(entries_t) :: entries
      type(declared_t), allocatable :: declared(:)
      type(entry_t), allocatable :: known(:)

      if (allocated(error)) return
      call entries%read_from(file%path, group)
      call data%declare(entries)
      if (entries%said%has_unknown()) then
         call declare_group(declared, data)
         call declared(1)%collect(known)
         call entries%said%unknown(known)
      end if
      if (allocated(entries%said%error)) call move_alloc(entries%said%error, error)
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
