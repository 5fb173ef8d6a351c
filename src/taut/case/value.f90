!> Values as they stand in a case file: cut into words by the rules of namelists, and made numbers, truth values or texts.
!!
!! Words are apart by blanks or one comma; `3*0.5` is a word three times; texts are in quotation marks of either kind, in which a
!! doubled one stands for itself. A value that is left out (`,1.0` or `2*`) has its own code, for it can only be a mistake.
module taut_case_value
   use, intrinsic :: iso_fortran_env, only: int64
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_positive_inf, ieee_quiet_nan
   use taut_kinds, only: wp
   implicit none (type, external)
   private
   public :: lower_case, word_t, split_words, read_real, read_integer, read_logical, short_text
   public :: words_ok, words_null, words_no_separator

   !> One word and how often it is meant.
   type :: word_t
      !> The word; of a text what is between its quotation marks.
      character(:), allocatable :: text
      !> Whether it stood in quotation marks.
      logical :: quoted = .false.
      !> Times that it is there.
      integer(int64) :: count = 1
   end type word_t

   !> All is well; a value is left out; two values have nothing between them.
   integer, parameter :: words_ok = 0, words_null = 1, words_no_separator = 2

   character(*), parameter :: digits = '0123456789'

contains

   !> Cuts a text into words.
   pure subroutine split_words(text, words, code)
      !> What stands behind the equals sign, comments and line ends blanked, quotation marks closed. One comma may end it.
      character(*), intent(in) :: text
      !> Its words.
      type(word_t), allocatable, intent(out) :: words(:)
      !> One of the `words_` constants.
      integer, intent(out) :: code
      type(word_t), allocatable :: found(:)
      integer :: i, n, status, stop_at
      logical :: comma

      ! No word is shorter than one character and the separator behind it.
      allocate (found((len(text) + 1)/2 + 1))
      n = 0
      code = words_ok
      comma = .true.
      i = 1
      do
         i = i + verify(text(i:)//'x', ' ') - 1
         if (i > len(text)) exit
         if (text(i:i) == ',') then
            if (comma) code = words_null
            comma = .true.
            i = i + 1
            cycle
         end if
         comma = .false.
         n = n + 1
         stop_at = i + verify(text(i:)//'x', digits) - 1
         if (stop_at > i .and. stop_at <= len(text)) then
            if (text(stop_at:stop_at) == '*') then
               read (text(i:stop_at - 1), *, iostat=status) found(n)%count
               if (status /= 0) found(n)%count = huge(found(n)%count)
               i = stop_at + 1
               if (scan(text(i:)//' ', ' ,') == 1) code = words_null
            end if
         end if
         if (code /= words_ok) exit
         if (text(i:i) == '"' .or. text(i:i) == "'") then
            call take_text(text, i, found(n)%text)
            found(n)%quoted = .true.
            if (scan(text(i:)//' ', ' ,') /= 1) code = words_no_separator
         else
            stop_at = i + scan(text(i:)//' ', ' ,') - 2
            found(n)%text = text(i:stop_at)
            i = stop_at + 1
         end if
      end do
      words = found(:n)
      if (n == 0) code = words_null
   end subroutine split_words

   !> A text in quotation marks.
   pure subroutine take_text(text, i, inside)
      character(*), intent(in) :: text
      !> Where its first quotation mark is; then behind its last.
      integer, intent(inout) :: i
      !> What is between them.
      character(:), allocatable, intent(out) :: inside
      character :: quote
      integer :: length

      quote = text(i:i)
      inside = ''
      do
         i = i + 1
         length = index(text(i:), quote) - 1
         if (length < 0) length = len(text) - i + 1
         inside = inside//text(i:i + length - 1)
         i = i + length + 1
         if (i > len(text)) exit
         if (text(i:i) /= quote) exit
         inside = inside//quote
      end do
   end subroutine take_text

   !> A number; `nan`, `inf` and what is too large are numbers here, to be refused by whoever knows its range.
   pure subroutine read_real(word, value, fits)
      !> The word.
      type(word_t), intent(in) :: word
      !> Its value.
      real(wp), intent(out) :: value
      !> Whether it is a number.
      logical, intent(out) :: fits
      integer :: status

      value = 0.0_wp
      fits = .false.
      if (word%quoted) return
      select case (lower_case(word%text))
      case ('nan', '+nan', '-nan')
         value = ieee_value(value, ieee_quiet_nan)
         fits = .true.
      case ('inf', '+inf', '-inf', 'infinity', '+infinity', '-infinity')
         value = ieee_value(value, ieee_positive_inf)
         if (word%text(1:1) == '-') value = -value
         fits = .true.
      case default
         fits = verify(word%text, digits//'+-.eEdDqQ') == 0 .and. scan(word%text, digits) > 0
         if (.not. fits) return
         read (word%text, *, iostat=status) value
         fits = status == 0
      end select
   end subroutine read_real

   !> An integer.
   pure subroutine read_integer(word, value, fits)
      !> The word.
      type(word_t), intent(in) :: word
      !> Its value.
      integer, intent(out) :: value
      !> Whether it is an integer.
      logical, intent(out) :: fits
      integer :: status

      value = 0
      fits = .not. word%quoted .and. verify(word%text, digits//'+-') == 0 .and. scan(word%text, digits) > 0
      if (.not. fits) return
      read (word%text, *, iostat=status) value
      fits = status == 0
   end subroutine read_integer

   !> A truth value: .true. or .false., with or without points, in full or by its first letter.
   pure subroutine read_logical(word, value, fits)
      !> The word.
      type(word_t), intent(in) :: word
      !> Its value.
      logical, intent(out) :: value
      !> Whether it is one.
      logical, intent(out) :: fits

      value = .false.
      fits = .not. word%quoted
      if (.not. fits) return
      select case (lower_case(word%text))
      case ('.true.', '.t.', 'true', 't', '.true', '.t')
         value = .true.
      case ('.false.', '.f.', 'false', 'f', '.false', '.f')
      case default
         fits = .false.
      end select
   end subroutine read_logical

   !> The shortest text that is read as the same number: 0.5, 9.81, 1e-6, 73e9.
   pure function short_text(value) result(text)
      !> A finite number.
      real(wp), intent(in) :: value
      !> Without blanks.
      character(:), allocatable :: text
      character(:), allocatable :: mantissa
      character(len=32) :: buffer
      real(wp) :: back
      integer :: digit_count, exponent, last, status

      text = '0'
      if (abs(value) <= 0.0_wp) return
      do digit_count = 1, 17
         write (buffer, '(es32.'//achar(iachar('0') + (digit_count - 1)/10)//achar(iachar('0') + mod(digit_count - 1, 10))// &
                'e3)') value
         read (buffer, *, iostat=status) back
         if (status == 0 .and. abs(back - value) <= 0.0_wp) exit
      end do
      buffer = adjustl(buffer)
      last = index(buffer, 'E')
      read (buffer(last + 1:), *) exponent
      text = ''
      if (value < 0.0_wp) text = '-'
      mantissa = significant(buffer(:last - 1))
      if (exponent >= 0 .and. exponent < 6) then
         if (len(mantissa) <= exponent + 1) then
            text = text//mantissa//repeat('0', exponent + 1 - len(mantissa))
         else
            text = text//mantissa(:exponent + 1)//'.'//mantissa(exponent + 2:)
         end if
      else if (exponent < 0 .and. exponent > -4) then
         text = text//'0.'//repeat('0', -exponent - 1)//mantissa
      else
         text = text//mantissa(1:1)
         if (len(mantissa) > 1) text = text//'.'//mantissa(2:)
         write (buffer, '(i0)') exponent
         text = text//'e'//trim(buffer)
      end if
   end function short_text

   !> The digits of a number of the form 1.234.
   pure function significant(text) result(mantissa)
      character(*), intent(in) :: text
      character(:), allocatable :: mantissa
      integer :: i

      mantissa = ''
      do i = 1, len_trim(text)
         if (index(digits, text(i:i)) > 0) mantissa = mantissa//text(i:i)
      end do
      i = len(mantissa)
      do while (i > 1 .and. mantissa(i:i) == '0')
         i = i - 1
      end do
      mantissa = mantissa(:i)
   end function significant

   !> A text in lower case.
   pure function lower_case(text) result(small)
      !> The text.
      character(*), intent(in) :: text
      !> Of the same length.
      character(len=len(text)) :: small
      integer :: i

      small = text
      do i = 1, len(text)
         if (text(i:i) >= 'A' .and. text(i:i) <= 'Z') small(i:i) = achar(iachar(text(i:i)) + 32)
      end do
   end function lower_case

end module taut_case_value
