!> Numbers as text, in full precision: seventeen significant digits, which read back exactly.
module taut_case_number
   use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_double, c_f_procpointer, c_funptr, c_int, c_null_char, c_size_t
   use taut_kinds, only: wp
   use taut_shared_library, only: procedure_named
   implicit none (type, external)
   private
   public :: number_length, number_printer_t, number_text

   !> The most letters that a number takes.
   integer, parameter :: number_length = 24

   !> Digits after the point.
   integer, parameter :: digits_behind = 16

   abstract interface
      !> What C calls strfromd.
      function text_of_double(text, room, format, value) bind(c) result(length)
         import :: c_char, c_double, c_int, c_size_t
         implicit none (type, external)
         !> The text, with a zero behind it.
         character(kind=c_char), intent(inout) :: text(*)
         !> Letters that there is room for.
         integer(c_size_t), value :: room
         !> How to write it.
         character(kind=c_char), intent(in) :: format(*)
         !> The number.
         real(c_double), value :: value
         !> Letters of the text.
         integer(c_int) :: length
      end function text_of_double
   end interface

   !> Writes many numbers: the letters of `number_text`, made by C's library if it has what makes them, which is six times faster
   !! than an edit descriptor.
   type :: number_printer_t
      private
      procedure(text_of_double), pointer, nopass :: print => null()
   contains
      procedure :: prepare
      procedure :: put
   end type number_printer_t

contains

   !> Sees what C's library has; without, edit descriptors serve.
   subroutine prepare(self)
      !> The printer.
      class(number_printer_t), intent(inout) :: self
      type(c_funptr) :: found

      found = procedure_named('strfromd')
      if (c_associated(found)) call c_f_procpointer(found, self%print)
   end subroutine prepare

   !> Writes a number.
   subroutine put(self, value, text, length)
      !> The printer.
      class(number_printer_t), intent(in) :: self
      !> The number.
      real(wp), intent(in) :: value
      !> Its text: at least `number_length` letters, of which the first `length` are set.
      character(*), intent(inout) :: text
      !> Letters of it.
      integer, intent(out) :: length
      character(len=number_length + 8) :: buffer
      integer :: e

      if (associated(self%print)) then
         length = self%print(buffer, len(buffer, c_size_t), '%.16E'//c_null_char, value)
         e = digits_behind + 3
         if (buffer(1:1) == '-') e = e + 1
         ! Neither infinite, nor with another country's decimal point.
         if (buffer(e:e) == 'E' .and. buffer(e - digits_behind - 1:e - digits_behind - 1) == '.') then
            text(1:e + 1) = buffer(1:e + 1)
            ! C leaves out the first digit of three in an exponent if it is zero.
            if (length == e + 3) then
               text(e + 2:e + 4) = '0'//buffer(e + 2:e + 3)
            else
               text(e + 2:e + 4) = buffer(e + 2:e + 4)
            end if
            length = e + 4
            return
         end if
      end if
      text(1:number_length) = number_text(value)
      length = len_trim(text(1:number_length))
   end subroutine put

   !> A number in full precision.
   function number_text(value) result(text)
      !> The number.
      real(wp), intent(in) :: value
      !> Seventeen significant digits and an exponent of three, left-adjusted.
      character(len=number_length) :: text

      write (text, '(es24.16e3)') value
      text = adjustl(text)
   end function number_text

end module taut_case_number
