!> Files: the few calls of the operating system and of C's library that Fortran does not have.
module taut_case_posix
   use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_f_pointer, c_int, c_int8_t, c_long, c_null_char, c_null_ptr, &
                                          c_ptr, c_size_t
   use, intrinsic :: iso_fortran_env, only: int8, int64
   implicit none (type, external)
   private
   public :: make_folder, move_file, remove_file, output_file_t, read_bytes, read_whole, remove_remainders

   !> What `errno` says where another process has the lock, on Linux.
   integer(c_int), parameter :: would_block = 11
   !> `O_RDONLY | O_NONBLOCK` of open, on Linux: what is no file must not be waited for.
   integer(c_int), parameter :: read_only = 2048
   !> `LOCK_EX | LOCK_NB` of flock, `SEEK_SET` and `SEEK_END` of fseek.
   integer(c_int), parameter :: lock_exclusive = 6, from_start = 0, from_end = 2

   !> A file that is written with C's library: GNU's Fortran library does not report a disk that is full.
   type :: output_file_t
      type(c_ptr), private :: file = c_null_ptr
   contains
      procedure :: open => open_file
      procedure :: put => put_line
      procedure :: put_bytes
      procedure :: close => close_file
      procedure :: reopen
      procedure :: sync
      procedure :: position
      procedure :: lock
   end type output_file_t

   !> What glob finds.
   type, bind(c) :: glob_t
      integer(c_size_t) :: count = 0
      type(c_ptr) :: paths = c_null_ptr
      integer(c_size_t) :: offset = 0
      !> Room for what else the system keeps there.
      type(c_ptr) :: more(16) = c_null_ptr
   end type glob_t

   interface
      function c_open(path, flags) bind(c, name='open') result(descriptor)
         import :: c_char, c_int
         implicit none (type, external)
         character(kind=c_char), intent(in) :: path(*)
         integer(c_int), value :: flags
         integer(c_int) :: descriptor
      end function c_open

      function c_close(descriptor) bind(c, name='close') result(status)
         import :: c_int
         implicit none (type, external)
         integer(c_int), value :: descriptor
         integer(c_int) :: status
      end function c_close

      function c_lseek(descriptor, offset, whence) bind(c, name='lseek') result(position)
         import :: c_int, c_long
         implicit none (type, external)
         integer(c_int), value :: descriptor, whence
         integer(c_long), value :: offset
         integer(c_long) :: position
      end function c_lseek

      function c_read(descriptor, buffer, count) bind(c, name='read') result(number)
         import :: c_char, c_int, c_long, c_size_t
         implicit none (type, external)
         integer(c_int), value :: descriptor
         character(kind=c_char), intent(inout) :: buffer(*)
         integer(c_size_t), value :: count
         integer(c_long) :: number
      end function c_read

      function c_errno() bind(c, name='__errno_location') result(place)
         import :: c_ptr
         implicit none (type, external)
         type(c_ptr) :: place
      end function c_errno

      function c_glob(pattern, flags, on_error, found) bind(c, name='glob') result(status)
         import :: c_char, c_int, c_ptr, glob_t
         implicit none (type, external)
         character(kind=c_char), intent(in) :: pattern(*)
         integer(c_int), value :: flags
         type(c_ptr), value :: on_error
         type(glob_t), intent(inout) :: found
         integer(c_int) :: status
      end function c_glob

      subroutine c_globfree(found) bind(c, name='globfree')
         import :: glob_t
         implicit none (type, external)
         type(glob_t), intent(inout) :: found
      end subroutine c_globfree

      function c_strlen(text) bind(c, name='strlen') result(length)
         import :: c_ptr, c_size_t
         implicit none (type, external)
         type(c_ptr), value :: text
         integer(c_size_t) :: length
      end function c_strlen

      function c_mkdir(path, mode) bind(c, name='mkdir') result(status)
         import :: c_char, c_int
         implicit none (type, external)
         character(kind=c_char), intent(in) :: path(*)
         integer(c_int), value :: mode
         integer(c_int) :: status
      end function c_mkdir

      function c_rename(from, to) bind(c, name='rename') result(status)
         import :: c_char, c_int
         implicit none (type, external)
         character(kind=c_char), intent(in) :: from(*), to(*)
         integer(c_int) :: status
      end function c_rename

      function c_unlink(path) bind(c, name='unlink') result(status)
         import :: c_char, c_int
         implicit none (type, external)
         character(kind=c_char), intent(in) :: path(*)
         integer(c_int) :: status
      end function c_unlink

      function c_fopen(path, mode) bind(c, name='fopen') result(file)
         import :: c_char, c_ptr
         implicit none (type, external)
         character(kind=c_char), intent(in) :: path(*), mode(*)
         type(c_ptr) :: file
      end function c_fopen

      function c_fwrite(buffer, size, count, file) bind(c, name='fwrite') result(written)
         import :: c_char, c_ptr, c_size_t
         implicit none (type, external)
         character(kind=c_char), intent(in) :: buffer(*)
         integer(c_size_t), value :: size, count
         type(c_ptr), value :: file
         integer(c_size_t) :: written
      end function c_fwrite

      function c_fclose(file) bind(c, name='fclose') result(status)
         import :: c_int, c_ptr
         implicit none (type, external)
         type(c_ptr), value :: file
         integer(c_int) :: status
      end function c_fclose

      function c_fflush(file) bind(c, name='fflush') result(status)
         import :: c_int, c_ptr
         implicit none (type, external)
         type(c_ptr), value :: file
         integer(c_int) :: status
      end function c_fflush

      function c_fileno(file) bind(c, name='fileno') result(descriptor)
         import :: c_int, c_ptr
         implicit none (type, external)
         type(c_ptr), value :: file
         integer(c_int) :: descriptor
      end function c_fileno

      function c_fsync(descriptor) bind(c, name='fsync') result(status)
         import :: c_int
         implicit none (type, external)
         integer(c_int), value :: descriptor
         integer(c_int) :: status
      end function c_fsync

      function c_flock(descriptor, operation) bind(c, name='flock') result(status)
         import :: c_int
         implicit none (type, external)
         integer(c_int), value :: descriptor, operation
         integer(c_int) :: status
      end function c_flock

      function c_ftruncate(descriptor, length) bind(c, name='ftruncate') result(status)
         import :: c_int, c_long
         implicit none (type, external)
         integer(c_int), value :: descriptor
         integer(c_long), value :: length
         integer(c_int) :: status
      end function c_ftruncate

      function c_fseek(file, offset, whence) bind(c, name='fseek') result(status)
         import :: c_int, c_long, c_ptr
         implicit none (type, external)
         type(c_ptr), value :: file
         integer(c_long), value :: offset
         integer(c_int), value :: whence
         integer(c_int) :: status
      end function c_fseek

      function c_ftell(file) bind(c, name='ftell') result(offset)
         import :: c_long, c_ptr
         implicit none (type, external)
         type(c_ptr), value :: file
         integer(c_long) :: offset
      end function c_ftell

      function c_fread(buffer, size, count, file) bind(c, name='fread') result(number)
         import :: c_int8_t, c_ptr, c_size_t
         implicit none (type, external)
         integer(c_int8_t), intent(inout) :: buffer(*)
         integer(c_size_t), value :: size, count
         type(c_ptr), value :: file
         integer(c_size_t) :: number
      end function c_fread

      function c_fwrite_bytes(buffer, size, count, file) bind(c, name='fwrite') result(written)
         import :: c_int8_t, c_ptr, c_size_t
         implicit none (type, external)
         integer(c_int8_t), intent(in) :: buffer(*)
         integer(c_size_t), value :: size, count
         type(c_ptr), value :: file
         integer(c_size_t) :: written
      end function c_fwrite_bytes

   end interface

contains

   !> Makes a folder and those above it that do not exist yet. Whether it can be written shows when a file is opened in it.
   subroutine make_folder(path)
      !> Its path.
      character(*), intent(in) :: path
      integer(c_int) :: ignored
      integer :: i

      do i = 2, len(path)
         if (path(i:i) == '/') ignored = c_mkdir(path(:i - 1)//c_null_char, int(o'777', c_int))
      end do
      ignored = c_mkdir(path//c_null_char, int(o'777', c_int))
   end subroutine make_folder

   !> Gives a file its final name in one step, in the place of an older file of that name.
   subroutine move_file(from, to, done)
      !> Old name.
      character(*), intent(in) :: from
      !> New name, on the same file system.
      character(*), intent(in) :: to
      !> Whether it was done.
      logical, intent(out) :: done

      done = c_rename(from//c_null_char, to//c_null_char) == 0
   end subroutine move_file

   !> Removes a file if it is there.
   subroutine remove_file(path)
      !> Its path.
      character(*), intent(in) :: path
      integer(c_int) :: ignored

      ignored = c_unlink(path//c_null_char)
   end subroutine remove_file

   !> Makes a file for writing.
   subroutine open_file(self, path, done)
      !> The file.
      class(output_file_t), intent(inout) :: self
      !> Its path.
      character(*), intent(in) :: path
      !> Whether it is open; not if there is something of this name.
      logical, intent(out) :: done
      logical :: ignored

      self%file = c_fopen(path//c_null_char, 'wbx'//c_null_char)
      done = c_associated(self%file)
      ! Nobody else has a file that was not there before; where there are no locks there is none.
      if (done) call self%lock(ignored)
   end subroutine open_file

   !> Opens a file that was left unfinished, cuts off what follows its first bytes, and writes on from there.
   subroutine reopen(self, path, length, done, busy, known)
      !> The file.
      class(output_file_t), intent(inout) :: self
      !> Its path.
      character(*), intent(in) :: path
      !> Number of bytes that stay.
      integer(int64), intent(in) :: length
      !> Whether it is open.
      logical, intent(out) :: done
      !> Whether it is not because another process writes it.
      logical, intent(out) :: busy
      !> Whether that would be known.
      logical, intent(out) :: known

      self%file = c_fopen(path//c_null_char, 'r+b'//c_null_char)
      done = c_associated(self%file)
      busy = .false.
      known = .true.
      if (.not. done) return
      call self%lock(done, known)
      busy = .not. done
      if (done) done = c_ftruncate(c_fileno(self%file), int(length, c_long)) == 0
      if (done) done = c_fseek(self%file, 0_c_long, from_end) == 0
      if (.not. done) call drop()

   contains

      subroutine drop()
         logical :: ignored

         call self%close(ignored)
      end subroutine drop

   end subroutine reopen

   !> Keeps other processes from taking the file too; the system lifts this when the process ends, however it ends. Some file
   !! systems have no locks: there nobody is kept from anything.
   subroutine lock(self, done, known)
      !> The file, open.
      class(output_file_t), intent(in) :: self
      !> False if another process has it.
      logical, intent(out) :: done
      !> Whether the file system has locks, so that it would be known if another process had the file.
      logical, intent(out), optional :: known
      integer(c_int), pointer :: why
      logical :: locked

      locked = c_flock(c_fileno(self%file), lock_exclusive) == 0
      call c_f_pointer(c_errno(), why)
      done = locked
      if (.not. locked) done = why /= would_block
      if (present(known)) known = locked .or. .not. done
   end subroutine lock

   !> Brings everything that was written to the disk.
   subroutine sync(self, done)
      !> The file, open.
      class(output_file_t), intent(in) :: self
      !> Whether it arrived.
      logical, intent(out) :: done

      done = c_fflush(self%file) == 0
      if (done) done = c_fsync(c_fileno(self%file)) == 0
   end subroutine sync

   !> How many bytes the file has so far, those in the buffer included.
   function position(self) result(length)
      !> The file, open.
      class(output_file_t), intent(in) :: self
      !> Their number.
      integer(int64) :: length

      length = int(c_ftell(self%file), int64)
   end function position

   !> Writes bytes.
   subroutine put_bytes(self, bytes, done)
      !> The file, open.
      class(output_file_t), intent(in) :: self
      !> What to write.
      integer(int8), intent(in), contiguous :: bytes(:)
      !> False if it does not arrive.
      logical, intent(out) :: done

      done = c_fwrite_bytes(bytes, 1_c_size_t, size(bytes, kind=c_size_t), self%file) == size(bytes, kind=c_size_t)
   end subroutine put_bytes

   !> Reads bytes of a file.
   subroutine read_bytes(path, offset, bytes, count)
      !> Its path.
      character(*), intent(in) :: path
      !> How many bytes to leave out first.
      integer(int64), intent(in) :: offset
      !> What was read: its first `count` entries.
      integer(int8), intent(inout), contiguous :: bytes(:)
      !> How many there were; -1 if the file cannot be read.
      integer(int64), intent(out) :: count
      type(c_ptr) :: file
      integer(c_int) :: ignored

      count = -1
      file = c_fopen(path//c_null_char, 'rb'//c_null_char)
      if (.not. c_associated(file)) return
      if (c_fseek(file, int(offset, c_long), from_start) == 0) &
         count = int(c_fread(bytes, 1_c_size_t, size(bytes, kind=c_size_t), file), int64)
      ignored = c_fclose(file)
   end subroutine read_bytes

   !> Removes files that killed processes left half-written: those of a pattern that no process writes.
   subroutine remove_remainders(before, behind)
      !> The paths begin so.
      character(*), intent(in) :: before
      !> They end so.
      character(*), intent(in) :: behind
      type(glob_t) :: found
      type(c_ptr), pointer :: paths(:)
      character(kind=c_char), pointer :: text(:)
      character(:), allocatable :: path
      type(output_file_t) :: file
      logical :: free, ignored, known
      integer :: i, j, length

      if (c_glob(escaped(before)//'*'//escaped(behind)//c_null_char, 0_c_int, c_null_ptr, found) == 0) then
         call c_f_pointer(found%paths, paths, [int(found%count)])
         do i = 1, size(paths)
            length = int(c_strlen(paths(i)))
            call c_f_pointer(paths(i), text, [length])
            allocate (character(len=length) :: path)
            do j = 1, length
               path(j:j) = text(j)
            end do
            file%file = c_fopen(path//c_null_char, 'r+b'//c_null_char)
            if (c_associated(file%file)) then
               call file%lock(free, known)
               if (free .and. known) call remove_file(path)
               call file%close(ignored)
            end if
            deallocate (path)
         end do
      end if
      call c_globfree(found)
   end subroutine remove_remainders

   !> A text that stands for itself in a pattern.
   pure function escaped(text) result(pattern)
      character(*), intent(in) :: text
      character(:), allocatable :: pattern
      integer :: i

      pattern = ''
      do i = 1, len(text)
         if (index('*?[]\', text(i:i)) > 0) pattern = pattern//'\'
         pattern = pattern//text(i:i)
      end do
   end function escaped

   !> Reads a regular file at once. Pipes, terminals and devices have no end to wait for: they are not read.
   subroutine read_whole(path, text, done)
      !> Its path.
      character(*), intent(in) :: path
      !> All of it.
      character(:), allocatable, intent(out) :: text
      !> Whether it is such a file and was read.
      logical, intent(out) :: done
      integer(c_int) :: descriptor, ignored
      integer(c_long) :: length, number, total
      integer :: status
      character :: one

      text = ''
      descriptor = c_open(path//c_null_char, read_only)
      done = descriptor >= 0
      if (.not. done) return
      length = c_lseek(descriptor, 0_c_long, from_end)
      ! A folder may say that it is as long as numbers get.
      done = length >= 0 .and. length < ishft(huge(length), -1)
      if (done) done = c_lseek(descriptor, 0_c_long, from_start) == 0
      if (done) then
         deallocate (text)
         allocate (character(len=length) :: text, stat=status)
         done = status == 0
      end if
      total = 0
      do while (done .and. total < length)
         number = c_read(descriptor, text(total + 1:), int(length - total, c_size_t))
         done = number > 0
         total = total + number
      end do
      ! A device has no length and yet something to read.
      if (done) done = c_read(descriptor, one, 1_c_size_t) == 0
      ignored = c_close(descriptor)
      if (.not. allocated(text)) text = ''
   end subroutine read_whole

   !> Writes a line.
   subroutine put_line(self, line, done)
      !> The file, open.
      class(output_file_t), intent(in) :: self
      !> Text without a line end.
      character(*), intent(in) :: line
      !> False if it does not arrive; what a buffer holds is known when the file is closed.
      logical, intent(out) :: done

      done = c_fwrite(line, 1_c_size_t, len(line, c_size_t), self%file) == len(line, c_size_t)
      if (done) done = c_fwrite(new_line('a'), 1_c_size_t, 1_c_size_t, self%file) == 1_c_size_t
   end subroutine put_line

   !> Closes a file.
   subroutine close_file(self, done)
      !> The file, open.
      class(output_file_t), intent(inout) :: self
      !> Whether all that was written has arrived.
      logical, intent(out) :: done

      done = c_fclose(self%file) == 0
      self%file = c_null_ptr
   end subroutine close_file

end module taut_case_posix
