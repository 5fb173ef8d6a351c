!> The few calls of the operating system that Fortran does not have.
module taut_case_posix
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char
   implicit none (type, external)
   private
   public :: make_folder, move_file, remove_file, is_terminal, process_id

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
