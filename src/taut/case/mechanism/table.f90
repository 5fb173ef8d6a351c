!> Tables of times and values from CSV files.
module taut_case_mechanism_table
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_case_identity, only: beside
   use taut_case_posix, only: read_whole
   implicit none (type, external)
   private
   public :: read_table

contains

   !> Reads times and values: two numbers a row, a comma between them. Rows that begin with # are remarks, the first of the
   !! others may be a heading.
   subroutine read_table(case_path, path, times, values, error)
      !> The case file, whose folder the path starts from.
      character(*), intent(in) :: case_path
      !> The CSV file.
      character(*), intent(in) :: path
      !> Times [s]: (rows).
      real(wp), allocatable, intent(out) :: times(:)
      !> Values: (rows).
      real(wp), allocatable, intent(out) :: values(:)
      !> A file or a line that cannot be read.
      type(error_t), allocatable, intent(inout) :: error
      character(:), allocatable :: text, whole
      character(len=1000) :: line
      integer :: i, number, rows, start, stop_at
      logical :: done, exists, first, fits
      real(wp) :: row(2)

      allocate (times(0), values(0))
      whole = beside(case_path, path)
      inquire (file=whole, exist=exists)
      if (.not. exists) then
         call raise(error, '', 'there is no table '//whole, 'give its path from the folder of the case file')
         return
      end if
      call read_whole(whole, text, done)
      if (.not. done) then
         call raise(error, '', 'the table '//whole//' cannot be read', &
                    'give a text file, no folder and no pipe; check its permissions')
         return
      end if
      ! Room for all rows that there can be: lists that grow one by one take the square of the time.
      deallocate (times, values)
      allocate (times(1 + count([(text(i:i) == new_line('a'), i=1, len(text))])))
      allocate (values(size(times)))
      number = 0
      rows = 0
      start = 1
      first = .true.
      do while (start <= len(text))
         stop_at = start + index(text(start:)//new_line('a'), new_line('a')) - 2
         line = text(start:stop_at)
         start = stop_at + 2
         number = number + 1
         call blank_out(line)
         if (len_trim(line) == 0 .or. line(1:1) == '#') cycle
         call read_row(line, row, fits)
         if (fits) then
            rows = rows + 1
            times(rows) = row(1)
            values(rows) = row(2)
         else if (.not. (first .and. is_heading(line))) then
            call raise(error, '', 'line '//to_text(number)//' of the table '//whole//' is not two numbers with a comma '// &
                       'between them: '//line(:min(40, len_trim(line))), 'write time,value in each line, with decimal points')
            exit
         end if
         first = .false.
      end do
      times = times(:rows)
      values = values(:rows)
      if (rows < 2) call raise(error, '', 'the table '//whole//' has fewer than two rows of numbers', &
                                      'write time,value in each line')
   end subroutine read_table

   !> Other white space than blanks becomes blanks, those in front go.
   pure subroutine blank_out(line)
      character(*), intent(inout) :: line
      !> The mark with which some programs begin a file in UTF-8.
      character(*), parameter :: mark = char(239)//char(187)//char(191)
      integer :: i

      if (index(line, mark) == 1) line = line(len(mark) + 1:)
      do i = 1, len(line)
         if (ichar(line(i:i)) < 32) line(i:i) = ' '
      end do
      line = adjustl(line)
   end subroutine blank_out

   !> Whether a line has names, and no number.
   pure logical function is_heading(line)
      character(*), intent(in) :: line
      real(wp) :: value
      integer :: comma

      comma = index(line, ',')
      is_heading = scan(line(1:1), '0123456789+-.,;') == 0
      if (comma == 0 .or. .not. is_heading) return
      call read_number(line(comma + 1:), value, is_heading)
      is_heading = .not. is_heading
   end function is_heading

   !> Two numbers and the comma between them.
   pure subroutine read_row(line, row, fits)
      character(*), intent(in) :: line
      real(wp), intent(out) :: row(2)
      logical, intent(out) :: fits
      integer :: comma

      row = 0.0_wp
      comma = index(line, ',')
      fits = comma > 0
      if (fits) call read_number(line(:comma - 1), row(1), fits)
      if (fits) call read_number(line(comma + 1:), row(2), fits)
   end subroutine read_row

   !> One number and nothing else.
   pure subroutine read_number(text, value, fits)
      character(*), intent(in) :: text
      real(wp), intent(out) :: value
      logical, intent(out) :: fits
      character(len=len(text)) :: word
      integer :: status

      value = 0.0_wp
      word = adjustl(text)
      fits = len_trim(word) > 0 .and. verify(trim(word), '0123456789+-.eEdD') == 0
      if (.not. fits) return
      read (word, *, iostat=status) value
      fits = status == 0
   end subroutine read_number

end module taut_case_mechanism_table
