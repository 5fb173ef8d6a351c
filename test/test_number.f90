!> Tests of numbers as text: they read back exactly, and what C's library writes is what an edit descriptor writes.
module test_number
   use, intrinsic :: ieee_arithmetic, only: ieee_negative_inf, ieee_positive_inf, ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_fortran_env, only: int64
   use taut_case_number, only: number_length, number_printer_t, number_text
   use taut_case_row, only: row_t
   use taut_kinds, only: wp
   use testing, only: check, new_test, test_t
   implicit none (type, external)
   private
   public :: collect_number

contains

   !> All tests of this module.
   function collect_number() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [ &
              new_test('numbers of all sizes', sizes), &
              new_test('numbers of any bits', any_bits), &
              new_test('what is no number', no_numbers), &
              new_test('rows of fields', rows)]
   end function collect_number

   !> The letters of both ways, and the number that they are read as.
   subroutine check_number(failure, printer, value)
      character(:), allocatable, intent(inout) :: failure
      type(number_printer_t), intent(in) :: printer
      real(wp), intent(in) :: value
      type(number_printer_t) :: plain
      character(len=number_length) :: text
      real(wp) :: back
      integer :: length

      text = ''
      call printer%put(value, text, length)
      read (text(:length), *) back
      call check(failure, transfer(back, 0_int64) == transfer(value, 0_int64), 'read again as another number: '//text)
      call check(failure, text(:length) == number_text(value), 'C writes '//text//' and Fortran '//number_text(value))
      call plain%put(value, text, length)
      call check(failure, text(:length) == number_text(value), 'without C: '//text)
   end subroutine check_number

   subroutine sizes(failure)
      character(:), allocatable, intent(inout) :: failure
      type(number_printer_t) :: printer
      character(len=8) :: power
      real(wp) :: value
      integer :: i

      call printer%prepare()
      do i = -1074, 1023
         value = scale(1.0_wp, i)
         call check_number(failure, printer, value)
         call check_number(failure, printer, -value)
         if (i > -1022) call check_number(failure, printer, nearest(value, -1.0_wp))
         call check_number(failure, printer, nearest(value, 1.0_wp))
      end do
      do i = -323, 308
         write (power, '(a, i0)') '1e', i
         read (power, *) value
         call check_number(failure, printer, value)
         call check_number(failure, printer, nearest(value, 1.0_wp))
         call check_number(failure, printer, -nearest(value, -1.0_wp))
      end do
      do i = 0, 1000
         call check_number(failure, printer, real(i, wp))
         call check_number(failure, printer, -real(i, wp)/1000.0_wp)
      end do
      call check_number(failure, printer, -0.0_wp)
      call check_number(failure, printer, huge(1.0_wp))
   end subroutine sizes

   !> Bits of a linear congruence (Knuth's MMIX), mixed; exponents from the smallest to the largest.
   subroutine any_bits(failure)
      character(:), allocatable, intent(inout) :: failure
      type(number_printer_t) :: printer
      integer(int64) :: low, high, bits
      integer :: i

      call printer%prepare()
      low = 1_int64
      do i = 1, 50000
         low = modulo(low*1103515245_int64 + 12345_int64, 2147483648_int64)
         high = modulo(low*1103515245_int64 + 12345_int64, 2147483648_int64)
         bits = ior(ishft(high, 33), ieor(ishft(low, 3), ishft(high, -11)))
         low = ieor(high, int(i, int64))
         ! An exponent of ones is no number.
         if (ibits(bits, 52, 11) == 2047) cycle
         call check_number(failure, printer, transfer(bits, 1.0_wp))
      end do
   end subroutine any_bits

   subroutine no_numbers(failure)
      character(:), allocatable, intent(inout) :: failure
      type(number_printer_t) :: printer
      character(len=number_length) :: text
      real(wp) :: values(3)
      integer :: i, length

      values = ieee_value(1.0_wp, [ieee_quiet_nan, ieee_positive_inf, ieee_negative_inf])
      call printer%prepare()
      do i = 1, size(values)
         call printer%put(values(i), text, length)
         call check(failure, text(:length) == number_text(values(i)), 'C writes '//text(:length))
      end do
   end subroutine no_numbers

   subroutine rows(failure)
      character(:), allocatable, intent(inout) :: failure
      type(row_t) :: row
      integer :: i

      call row%create()
      call row%add('a')
      call row%add(-1.5_wp)
      call row%add(42)
      call row%add('')
      call row%add(1.0e-300_wp)
      call check(failure, row%letters(:row%used) == 'a,-1.5000000000000000E+000,42,,1.0000000000000000E-300', &
                 'the row is '//row%letters(:row%used))
      call row%clear()
      do i = 1, 1000
         call row%add(real(i, wp))
      end do
      call check(failure, row%used == 24*1000 - 1, 'a long row')
      call check(failure, row%letters(row%used - 23:row%used) == ',1.0000000000000000E+003', 'the end of a long row')
   end subroutine rows

end module test_number
