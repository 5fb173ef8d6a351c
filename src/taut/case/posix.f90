!> The few calls of the operating system and of C's library that Fortran does not have.
module taut_case_posix
   use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_int, c_null_char, c_null_ptr, c_ptr, c_size_t
   implicit none (type, external)
   private
   public :: make_folder, move_file, remove_file, is_terminal, process_id, output_file_t

   !> A file that is written with C's library: GNU's Fortran library does not report a disk that is full.
   type :: output_file_t
      type(c_ptr), private :: file = c_null_ptr
   contains
      procedure :: open => open_file
      procedure :: put => put_line
      procedure :: close => close_file
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
      !> Old name, new name; on one file system.
      character(*), intent(in) :: from, to
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

   !> Opens a file for writing; what it held is lost.
   subroutine open_file(self, path, done)
      !> The file.
      class(output_file_t), intent(inout) :: self
      !> Its path.
      character(*), intent(in) :: path
      !> Whether it is open.
      logical, intent(out) :: done

      self%file = c_fopen(path//c_null_char, 'wb'//c_null_char)
      done = c_associated(self%file)
   end subroutine open_file

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
      !> The answer.
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
