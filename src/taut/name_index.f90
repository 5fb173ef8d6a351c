!> Names and their numbers, found without searching through all of them.
module taut_name_index
   use, intrinsic :: iso_fortran_env, only: int64
   use taut_spelling, only: nearest_name
   implicit none (type, external)
   private
   public :: name_index_t

   !> A name in its place.
   type :: named_t
      character(:), allocatable :: name
      integer :: number = 0
   end type named_t

   !> A hash table with open addressing that doubles when it is half full.
   !!
   !! Source of the hash: G. Fowler, L.C. Noll, K.-P. Vo, FNV-1a, of 32 bits.
   type :: name_index_t
      !> How many names there are.
      integer :: count = 0
      type(named_t), allocatable, private :: table(:)
   contains
      procedure :: add
      procedure :: find
      procedure :: nearest_to
   end type name_index_t

contains

   !> Adds a name with its number; of a name that is there already the number is replaced.
   subroutine add(self, name, number)
      !> The index.
      class(name_index_t), intent(inout) :: self
      !> The name; trailing blanks do not count.
      character(*), intent(in) :: name
      !> Its number, not 0.
      integer, intent(in) :: number
      type(named_t), allocatable :: old(:)
      integer :: i, place

      if (.not. allocated(self%table)) allocate (self%table(64))
      if (2*self%count >= size(self%table)) then
         call move_alloc(self%table, old)
         allocate (self%table(2*size(old)))
         do i = 1, size(old)
            if (old(i)%number == 0) cycle
            place = place_of(self, old(i)%name)
            call move_alloc(old(i)%name, self%table(place)%name)
            self%table(place)%number = old(i)%number
         end do
      end if
      place = place_of(self, name)
      if (self%table(place)%number == 0) then
         self%count = self%count + 1
         self%table(place)%name = trim(name)
      end if
      self%table(place)%number = number
   end subroutine add

   !> The number of a name, 0 if it is not there.
   pure integer function find(self, name)
      !> The index.
      class(name_index_t), intent(in) :: self
      !> The name; trailing blanks do not count.
      character(*), intent(in) :: name

      find = 0
      if (allocated(self%table)) find = self%table(place_of(self, name))%number
   end function find

   !> The name that a misspelt one may have been meant to be; all of them are looked at.
   function nearest_to(self, name) result(meant)
      !> The index.
      class(name_index_t), intent(in) :: self
      !> The name as written.
      character(*), intent(in) :: name
      !> One of those that there are, or nothing; no longer than a name may be to have been meant.
      character(len=len(name) + len(name)/3 + 1) :: meant
      character(:), allocatable :: known(:)
      integer :: i, longest

      meant = ''
      if (.not. allocated(self%table)) return
      longest = 1
      do i = 1, size(self%table)
         if (self%table(i)%number /= 0) longest = max(longest, len(self%table(i)%name))
      end do
      allocate (character(len=longest) :: known(size(self%table)))
      do i = 1, size(self%table)
         known(i) = ''
         if (self%table(i)%number /= 0) known(i) = self%table(i)%name
      end do
      meant = nearest_name(name, known)
   end function nearest_to

   !> Where a name is, or where it would go.
   pure integer function place_of(self, name) result(place)
      type(name_index_t), intent(in) :: self
      character(*), intent(in) :: name
      integer(int64), parameter :: basis = 2166136261_int64, prime = 16777619_int64, words = 4294967296_int64
      integer(int64) :: hash
      integer :: i

      hash = basis
      do i = 1, len_trim(name)
         hash = modulo(ieor(hash, int(iachar(name(i:i)), int64))*prime, words)
      end do
      place = 1 + int(modulo(hash, int(size(self%table), int64)))
      do while (self%table(place)%number /= 0)
         if (self%table(place)%name == name) return
         place = 1 + modulo(place, size(self%table))
      end do
   end function place_of

end module taut_name_index
