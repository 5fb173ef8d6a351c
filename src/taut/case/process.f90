!> The process as the system sees it: its number, the signals that it gets, and what it prints.
module taut_case_process
   use, intrinsic :: iso_c_binding, only: c_char, c_funloc, c_funptr, c_int, c_intptr_t, c_long, c_null_char, c_null_funptr, &
                                          c_null_ptr, c_ptr, c_size_t
   implicit none (type, external)
   private
   public :: start_process, catch_signals, caught_signal, is_terminal, process_id, say, output_is_lost

   !> Signals by their numbers on Linux: Ctrl-C, a request to end, and what batch systems send before the time limit.
   integer(c_int), parameter :: signal_interrupt = 2, signal_user_1 = 10, signal_terminate = 15
   !> The one that ends a process whose file grows beyond a limit, and the handler that ignores a signal.
   integer(c_int), parameter :: signal_file_size = 25
   integer(c_intptr_t), parameter :: ignore = 1
   !> `O_RDONLY`; standard output, standard error.
   integer(c_int), parameter :: read_only = 0, standard_output = 1, standard_error = 2

   !> The signal that came, or 0; and whether something that was printed did not arrive. Both concern the whole process, and a
   !! handler has no arguments of ours: these are the variables of the project that are not passed around.
   integer(c_int), volatile, save :: caught = 0
   logical, save :: lost = .false.

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

      function c_write(descriptor, text, count) bind(c, name='write') result(number)
         import :: c_char, c_int, c_long, c_size_t
         implicit none (type, external)
         integer(c_int), value :: descriptor
         character(kind=c_char), intent(in) :: text(*)
         integer(c_size_t), value :: count
         integer(c_long) :: number
      end function c_write

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

   !> Makes the process safe: files that are opened cannot take the place of an output that was closed, and a limit on the size
   !! of files shows as a failed output instead of an end by a signal.
   subroutine start_process()
      integer(c_int) :: descriptor, status
      type(c_funptr) :: before

      do
         ! What is only read cannot be written: what is printed there is known to be lost.
         descriptor = c_open('/dev/null'//c_null_char, read_only)
         if (descriptor < 0 .or. descriptor > standard_error) exit
      end do
      if (descriptor > standard_error) status = c_close(descriptor)
      before = c_signal(signal_file_size, transfer(ignore, c_null_funptr))
   end subroutine start_process

   !> Prints lines on standard output.
   subroutine say(text)
      !> One or more; the last one may be without its line end.
      character(*), intent(in) :: text
      character(:), allocatable :: lines
      integer(c_long) :: number, total

      lines = text
      if (index(text, new_line('a'), back=.true.) /= len(text) .or. len(text) == 0) lines = text//new_line('a')
      total = 0
      do while (total < len(lines))
         number = c_write(standard_output, lines(total + 1:), int(len(lines) - total, c_size_t))
         if (number <= 0) lost = .true.
         if (number <= 0) exit
         total = total + number
      end do
   end subroutine say

   !> Whether something that was printed did not arrive.
   function output_is_lost() result(answer)
      !> Whether it is lost.
      logical :: answer

      answer = lost
   end function output_is_lost

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

   !> Whether standard error is a terminal.
   function is_terminal() result(answer)
      !> Whether it is one.
      logical :: answer

      answer = c_isatty(2_c_int) == 1
   end function is_terminal

   !> A number that no other running process has.
   function process_id() result(id)
      !> The number.
      integer :: id

      id = int(c_getpid())
   end function process_id

end module taut_case_process
