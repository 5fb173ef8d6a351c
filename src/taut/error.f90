!> Errors as values: an allocated `error_t` means that something failed. The library never stops a program.
!!
!! Texts that are made while something runs are results of explicit length or arguments: gfortran keeps the length of a
!! result of deferred length in static memory, which two threads would share.
module taut_error
   implicit none (type, external)
   private
   public :: error_t, raise, to_text

   !> What went wrong, where, and what to do about it.
   type :: error_t
      !> The file, group or procedure concerned.
      character(:), allocatable :: where
      !> What is wrong, with the names and numbers that show it.
      character(:), allocatable :: what
      !> What the user can do.
      character(:), allocatable :: remedy
   contains
      procedure :: line => error_line
   end type error_t

   !> A number as short text for messages.
   interface to_text
      module procedure integer_to_text, real_to_text
   end interface to_text

contains

   !> Length of the line.
   pure integer function length_of_line(error) result(length)
      class(error_t), intent(in) :: error

      length = len(error%where) + 2 + len(error%what)
      if (len(error%remedy) > 0) length = length + 2 + len(error%remedy)
   end function length_of_line

   pure function integer_buffer(value) result(buffer)
      integer, intent(in) :: value
      character(len=16) :: buffer

      write (buffer, '(i0)') value
   end function integer_buffer

   pure function real_buffer(value) result(buffer)
      use taut_kinds, only: wp
      real(wp), intent(in) :: value
      character(len=16) :: buffer

      if (abs(value) >= 1.0e-2_wp .and. abs(value) < 1.0e4_wp) then
         write (buffer, '(f11.4)') value
      else if (abs(value) <= 0.0_wp) then
         buffer = '0'
      else
         write (buffer, '(es11.3e3)') value
      end if
      buffer = adjustl(buffer)
   end function real_buffer

   !> Allocates `error` with its three parts. An earlier error is kept: the first cause is the one to report.
   subroutine raise(error, where, what, remedy)
      !> The error to set.
      type(error_t), allocatable, intent(inout) :: error
      !> The file, group or procedure concerned.
      character(*), intent(in) :: where
      !> What is wrong.
      character(*), intent(in) :: what
      !> What to do about it.
      character(*), intent(in), optional :: remedy

      if (allocated(error)) return
      allocate (error)
      error%where = where
      error%what = what
      error%remedy = ''
      if (present(remedy)) error%remedy = remedy
   end subroutine raise

   !> The error in one line: `where: what; remedy`.
   pure function error_line(self) result(line)
      !> The error.
      class(error_t), intent(in) :: self
      !> Text without a line break.
      character(len=length_of_line(self)) :: line

      if (len(self%remedy) > 0) then
         line = self%where//': '//self%what//'; '//self%remedy
      else
         line = self%where//': '//self%what
      end if
   end function error_line

   !> An integer without blanks.
   pure function integer_to_text(value) result(text)
      !> The number.
      integer, intent(in) :: value
      !> Its decimal digits.
      character(len=len_trim(integer_buffer(value))) :: text

      text = integer_buffer(value)
   end function integer_to_text

   !> A real number with four significant digits.
   pure function real_to_text(value) result(text)
      use taut_kinds, only: wp
      !> The number.
      real(wp), intent(in) :: value
      !> Its text, such as 0.0123 or 1.234E-012.
      character(len=len_trim(real_buffer(value))) :: text

      text = real_buffer(value)
   end function real_to_text

end module taut_error
