!> An archive: named numbers and texts, one after the other, in memory. What a computation has to remember passes through it,
!! out when it is stored and in when it is restored, by the same procedure:
!!
!!     subroutine serialize(self, archive)
!!        class(my_type), intent(inout) :: self
!!        type(archive_t), intent(inout) :: archive
!!        call archive%item('step', self%h)
!!        call archive%item('state', self%y)
!!     end subroutine serialize
!!
!! so that the two directions cannot disagree. Each entry is its kind (one character: `r` real, `i` integer, `l` long integer,
!! `b` logical, `t` text, `a` archive), the length of its name (32-bit integer), the name, the number of values (64-bit integer) and the
!! values as the machine has them. An entry that is not the one expected makes `error`, and all that follows is left alone.
module taut_archive
   use, intrinsic :: iso_fortran_env, only: int8, int32, int64
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise
   implicit none (type, external)
   private
   public :: archive_t

   !> Entries in order, written or read.
   type :: archive_t
      !> Whether values come from the archive; otherwise they go into it.
      logical :: reading = .false.
      !> What was stored; the first `length` bytes count.
      integer(int8), allocatable :: bytes(:)
      !> Number of bytes that count.
      integer(int64) :: length = 0
      !> An entry that was not the one expected.
      type(error_t), allocatable :: error
      integer(int64), private :: position = 0
   contains
      generic :: item => pass_real, pass_reals, pass_integer, pass_long, pass_logical, pass_archive
      !> As `item`, for what is allocated, or not, with the length it had.
      generic :: list => pass_text, pass_real_list, pass_matrix, pass_integer_list
      procedure :: number
      procedure :: clear
      procedure :: rewind => rewind_archive
      procedure :: at_end
      procedure, private :: pass_real, pass_reals, pass_integer, pass_long, pass_logical, pass_text, pass_real_list, &
         pass_matrix, pass_integer_list, pass_archive
   end type archive_t

contains

   !> Empties the archive, ready to be written.
   subroutine clear(self)
      !> The archive.
      class(archive_t), intent(inout) :: self

      self%reading = .false.
      self%length = 0
      self%position = 0
      if (.not. allocated(self%bytes)) allocate (self%bytes(4096))
      if (allocated(self%error)) deallocate (self%error)
   end subroutine clear

   !> Makes the archive ready to be read from its first entry.
   subroutine rewind_archive(self)
      !> The archive.
      class(archive_t), intent(inout) :: self

      self%reading = .true.
      self%position = 0
      if (allocated(self%error)) deallocate (self%error)
   end subroutine rewind_archive

   !> Whether everything was read.
   pure logical function at_end(self)
      !> The archive, being read.
      class(archive_t), intent(in) :: self

      at_end = self%position == self%length
   end function at_end

   !> One real number.
   subroutine pass_real(self, name, value)
      !> The archive.
      class(archive_t), intent(inout) :: self
      !> Name of the entry.
      character(*), intent(in) :: name
      !> The number, stored or restored.
      real(wp), intent(inout) :: value
      integer(int64) :: count
      real(wp) :: one(1)

      one(1) = value
      count = 1
      call header(self, 'r', name, count, fixed=.true.)
      call pass_real_values(self, one)
      if (.not. allocated(self%error)) value = one(1)
   end subroutine pass_real

   !> Real numbers whose number is known.
   subroutine pass_reals(self, name, values)
      !> The archive.
      class(archive_t), intent(inout) :: self
      !> Name of the entry.
      character(*), intent(in) :: name
      !> The numbers, stored or restored.
      real(wp), intent(inout) :: values(:)
      integer(int64) :: count

      count = size(values, kind=int64)
      call header(self, 'r', name, count, fixed=.true.)
      call pass_real_values(self, values)
   end subroutine pass_reals

   !> Real numbers that are allocated or not.
   subroutine pass_real_list(self, name, values)
      !> The archive.
      class(archive_t), intent(inout) :: self
      !> Name of the entry.
      character(*), intent(in) :: name
      !> The numbers, stored or restored.
      real(wp), intent(inout), allocatable :: values(:)
      integer(int64) :: count

      count = -1
      if (allocated(values)) count = size(values, kind=int64)
      call header(self, 'r', name, count, fixed=.false.)
      if (allocated(self%error)) return
      if (self%reading) then
         if (allocated(values)) deallocate (values)
         if (count >= 0) allocate (values(count))
      end if
      if (count >= 0) call pass_real_values(self, values)
   end subroutine pass_real_list

   !> A matrix of real numbers that is allocated or not, by its number of columns and its entries.
   subroutine pass_matrix(self, name, values)
      !> The archive.
      class(archive_t), intent(inout) :: self
      !> Name of the entry.
      character(*), intent(in) :: name
      !> The numbers, stored or restored.
      real(wp), intent(inout), allocatable :: values(:, :)
      real(wp), allocatable :: flat(:)
      integer :: columns

      columns = 0
      if (allocated(values)) then
         columns = size(values, 2)
         flat = reshape(values, [size(values)])
      end if
      call self%item(name, columns)
      call self%list(name, flat)
      if (allocated(self%error) .or. .not. self%reading) return
      if (allocated(values)) deallocate (values)
      if (allocated(flat)) values = reshape(flat, [size(flat)/max(1, columns), columns])
   end subroutine pass_matrix

   !> One integer.
   subroutine pass_integer(self, name, value)
      !> The archive.
      class(archive_t), intent(inout) :: self
      !> Name of the entry.
      character(*), intent(in) :: name
      !> The number, stored or restored.
      integer, intent(inout) :: value
      integer(int64) :: count

      count = 1
      call header(self, 'i', name, count, fixed=.true.)
      call pass_integer_value(self, value)
   end subroutine pass_integer

   !> A number of things that follow. Restored, it is no more than what can follow, so that room may be made for it.
   subroutine number(self, name, value)
      !> The archive.
      class(archive_t), intent(inout) :: self
      !> Name of the entry.
      character(*), intent(in) :: name
      !> The number, stored or restored.
      integer, intent(inout) :: value

      call self%item(name, value)
      if (allocated(self%error) .or. .not. self%reading) return
      if (value < 0 .or. value > self%length - self%position) &
         call raise(self%error, 'archive', 'the number "'//name//'" cannot be meant', 'use the program that wrote it')
   end subroutine number

   !> Integers that are allocated or not.
   subroutine pass_integer_list(self, name, values)
      !> The archive.
      class(archive_t), intent(inout) :: self
      !> Name of the entry.
      character(*), intent(in) :: name
      !> The numbers, stored or restored.
      integer, intent(inout), allocatable :: values(:)
      integer(int64) :: count, i

      count = -1
      if (allocated(values)) count = size(values, kind=int64)
      call header(self, 'i', name, count, fixed=.false.)
      if (allocated(self%error)) return
      if (self%reading) then
         if (allocated(values)) deallocate (values)
         if (count >= 0) allocate (values(count))
      end if
      do i = 1, count
         call pass_integer_value(self, values(i))
      end do
   end subroutine pass_integer_list

   !> One long integer, such as a position in a file.
   subroutine pass_long(self, name, value)
      !> The archive.
      class(archive_t), intent(inout) :: self
      !> Name of the entry.
      character(*), intent(in) :: name
      !> The number, stored or restored.
      integer(int64), intent(inout) :: value
      integer(int64) :: count
      integer(int8) :: raw(8)

      count = 1
      call header(self, 'l', name, count, fixed=.true.)
      raw = transfer(value, raw)
      call pass_bytes(self, raw)
      if (.not. allocated(self%error)) value = transfer(raw, value)
   end subroutine pass_long

   !> One yes or no.
   subroutine pass_logical(self, name, value)
      !> The archive.
      class(archive_t), intent(inout) :: self
      !> Name of the entry.
      character(*), intent(in) :: name
      !> The answer, stored or restored.
      logical, intent(inout) :: value
      integer(int64) :: count
      integer(int8) :: raw(1)

      count = 1
      call header(self, 'b', name, count, fixed=.true.)
      raw = merge(1_int8, 0_int8, value)
      call pass_bytes(self, raw)
      if (.not. allocated(self%error)) value = raw(1) /= 0_int8
   end subroutine pass_logical

   !> A text that is allocated or not.
   subroutine pass_text(self, name, value)
      !> The archive.
      class(archive_t), intent(inout) :: self
      !> Name of the entry.
      character(*), intent(in) :: name
      !> The text, stored or restored.
      character(:), intent(inout), allocatable :: value
      integer(int64) :: count

      count = -1
      if (allocated(value)) count = len(value, kind=int64)
      call header(self, 't', name, count, fixed=.false.)
      if (allocated(self%error)) return
      if (self%reading) then
         if (allocated(value)) deallocate (value)
         if (count >= 0) allocate (character(len=count) :: value)
      end if
      if (count >= 0) call pass_characters(self, value)
   end subroutine pass_text

   !> An archive within the archive, for what is read where it is asked for: all of it, ready to be read when it is restored.
   subroutine pass_archive(self, name, inner)
      !> The archive.
      class(archive_t), intent(inout) :: self
      !> Name of the entry.
      character(*), intent(in) :: name
      !> What is stored or restored; may be empty.
      type(archive_t), intent(inout) :: inner
      integer(int64) :: count

      count = inner%length
      call header(self, 'a', name, count, fixed=.false.)
      if (allocated(self%error)) return
      if (self%reading) then
         call inner%clear()
         if (count < 0) count = 0
         inner%bytes = spread(0_int8, 1, int(count))
         inner%length = count
         call inner%rewind()
      end if
      if (count > 0) call pass_bytes(self, inner%bytes(:count))
   end subroutine pass_archive

   !> What stands before the values of an entry.
   subroutine header(self, kind, name, count, fixed)
      class(archive_t), intent(inout) :: self
      character, intent(in) :: kind
      character(*), intent(in) :: name
      integer(int64), intent(inout) :: count
      logical, intent(in) :: fixed
      character(len=1) :: found_kind
      character(len=len(name)) :: found_name
      integer :: length
      integer(int64) :: wanted

      if (allocated(self%error)) return
      found_kind = kind
      call pass_characters(self, found_kind)
      length = len(name)
      call pass_integer_value(self, length)
      found_name = name
      if (length == len(name)) call pass_characters(self, found_name)
      if (allocated(self%error)) return
      if (found_kind /= kind .or. length /= len(name) .or. found_name /= name) then
         call raise(self%error, 'archive', 'the entry "'//name//'" is not where it belongs', 'use the program that wrote it')
         return
      end if
      wanted = count
      call pass_count(self, count)
      if (allocated(self%error)) return
      if ((fixed .and. count /= wanted) .or. (self%reading .and. count > self%length)) &
         call raise(self%error, 'archive', 'the entry "'//name//'" has another size', 'use the program that wrote it')
   end subroutine header

   subroutine pass_count(self, count)
      type(archive_t), intent(inout) :: self
      integer(int64), intent(inout) :: count
      integer(int8) :: raw(8)

      raw = transfer(count, raw)
      call pass_bytes(self, raw)
      count = transfer(raw, count)
   end subroutine pass_count

   subroutine pass_integer_value(self, value)
      type(archive_t), intent(inout) :: self
      integer, intent(inout) :: value
      integer(int32) :: exact
      integer(int8) :: raw(4)

      exact = int(value, int32)
      raw = transfer(exact, raw)
      call pass_bytes(self, raw)
      if (.not. allocated(self%error)) value = int(transfer(raw, exact))
   end subroutine pass_integer_value

   subroutine pass_real_values(self, values)
      type(archive_t), intent(inout) :: self
      real(wp), intent(inout) :: values(:)
      integer(int8) :: raw(8)
      integer :: i

      do i = 1, size(values)
         raw = transfer(values(i), raw)
         call pass_bytes(self, raw)
         if (allocated(self%error)) return
         values(i) = transfer(raw, values(i))
      end do
   end subroutine pass_real_values

   subroutine pass_characters(self, text)
      type(archive_t), intent(inout) :: self
      character(*), intent(inout) :: text
      integer(int8) :: raw(1)
      integer :: i

      do i = 1, len(text)
         raw = transfer(text(i:i), raw)
         call pass_bytes(self, raw)
         if (allocated(self%error)) return
         text(i:i) = transfer(raw, 'a')
      end do
   end subroutine pass_characters

   !> Bytes into the archive or out of it.
   subroutine pass_bytes(self, raw)
      type(archive_t), intent(inout) :: self
      integer(int8), intent(inout) :: raw(:)
      integer(int8), allocatable :: more(:)
      integer(int64) :: count

      if (allocated(self%error)) return
      count = size(raw, kind=int64)
      if (self%reading) then
         if (self%position + count > self%length) then
            call raise(self%error, 'archive', 'it ends too early', 'use a complete one')
            return
         end if
         raw = self%bytes(self%position + 1:self%position + count)
         self%position = self%position + count
         return
      end if
      if (.not. allocated(self%bytes)) allocate (self%bytes(4096))
      if (self%length + count > size(self%bytes, kind=int64)) then
         allocate (more(2*(self%length + count)))
         more(:self%length) = self%bytes(:self%length)
         call move_alloc(more, self%bytes)
      end if
      self%bytes(self%length + 1:self%length + count) = raw
      self%length = self%length + count
   end subroutine pass_bytes

end module taut_archive
