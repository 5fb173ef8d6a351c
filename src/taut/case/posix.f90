!> The few calls of the operating system and of C's library that Fortran does not have.
module taut_case_posix
   use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_funloc, c_funptr, c_int, c_int8_t, c_long, c_null_char, &
                                          c_null_funptr, c_null_ptr, c_ptr, c_size_t
   use, intrinsic :: iso_fortran_env, only: int8, int64
   implicit none (type, external)
   private
   public :: make_folder, move_file, remove_file, is_terminal, process_id, output_file_t, read_bytes
   public :: catch_signals, caught_signal

   !> Signals by their numbers on Linux: Ctrl-C, a request to end, and what batch systems send before the time limit.
   integer(c_int), parameter :: signal_interrupt = 2, signal_user_1 = 10, signal_terminate = 15
   !> `LOCK_EX | LOCK_NB` of flock, `SEEK_SET` and `SEEK_END` of fseek.
   integer(c_int), parameter :: lock_exclusive = 6, from_start = 0, from_end = 2

   !> The signal that came, or 0. A signal concerns the whole process, and its handler has no arguments of ours: this is the one
   !! variable of the project that is not passed around.
   integer(c_int), volatile, save :: caught = 0

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

   interface
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

      function c_signal(number, handler) bind(c, name='signal') result(before)
         import :: c_funptr, c_int
         implicit none (type, external)
         integer(c_int), value :: number
         type(c_funptr), value :: handler
         type(c_funptr) :: before
      end function c_signal

      function c_isatty(descriptor) bind(c, name='isatty') result(answer)
         import :: c_int
         implicit none (type, external)
         integer(c_int), value :: descriptor
         integer(c_int) :: answer
      end function c_isatty

      function c_getpid() bind(c, name='getpid') result(id)
         import :: c_int
         implicit none (type, external)
         integer(c_int) :: id
      end function c_getpid
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

      self%file = c_fopen(path//c_null_char, 'wbx'//c_null_char)
      done = c_associated(self%file)
      if (done) call self%lock(done)
   end subroutine open_file

   !> Opens a file that was left unfinished, cuts off what follows its first bytes, and writes on from there.
   subroutine reopen(self, path, length, done, busy)
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

      self%file = c_fopen(path//c_null_char, 'r+b'//c_null_char)
      done = c_associated(self%file)
      busy = .false.
      if (.not. done) return
      call self%lock(done)
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

   !> Keeps other processes from taking the file too; the system lifts this when the process ends, however it ends.
   subroutine lock(self, done)
      !> The file, open.
      class(output_file_t), intent(in) :: self
      !> False if another process has it.
      logical, intent(out) :: done

      done = c_flock(c_fileno(self%file), lock_exclusive) == 0
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

   !> From now on SIGINT, SIGTERM and SIGUSR1 are noted instead of ending the program; a second SIGINT ends it. The others may
   !! come twice, from a batch system and from its script.
   subroutine catch_signals()
      type(c_funptr) :: ignored

      ignored = c_signal(signal_interrupt, c_funloc(note_signal))
      ignored = c_signal(signal_terminate, c_funloc(note_signal))
      ignored = c_signal(signal_user_1, c_funloc(note_signal))
   end subroutine catch_signals

   !> The handler: nothing but what a handler may do.
   subroutine note_signal(number) bind(c)
      !> The signal.
      integer(c_int), value :: number
      type(c_funptr) :: ignored

      caught = number
      if (number == signal_interrupt) ignored = c_signal(number, c_null_funptr)
   end subroutine note_signal

   !> The signal that came last, 0 if none did.
   function caught_signal() result(number)
      !> Its number.
      integer :: number

      number = int(caught)
   end function caught_signal

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

   !> Whether standard error is a terminal.
   function is_terminal() result(answer)
      !> Whether it is.
      logical :: answer

      answer = c_isatty(2_c_int) == 1
   end function is_terminal

   !> A number that no other running process has.
   function process_id() result(id)
      !> The number.
      integer :: id

      id = int(c_getpid())
   end function process_id

end module taut_case_posix
