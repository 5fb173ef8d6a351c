!> Tables of times and values from CSV files.
module taut_case_mechanism_table
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   implicit none (type, external)
   private
   public :: read_table

contains

   !> Reads the first two columns: times and values. Lines that begin with # or a letter are headings.
   subroutine read_table(case_path, path, times, values, error)
      !> The case file, whose folder the path starts from; the CSV file.
      character(*), intent(in) :: case_path, path
      !> Columns: (rows).
      real(wp), allocatable, intent(out) :: times(:), values(:)
      !> A file or a line that cannot be read.
      type(error_t), allocatable, intent(inout) :: error
      character(:), allocatable :: whole
      character(len=200) :: message
      character(len=1000) :: line
      integer :: number, status, unit
      logical :: exists
      real(wp) :: row(2)

      allocate (times(0), values(0))
      whole = path
      if (index(path, '/') /= 1) whole = case_path(:index(case_path, '/', back=.true.))//path
      inquire (file=whole, exist=exists)
      if (.not. exists) then
         call raise(error, '', 'there is no table '//whole, 'give its path from the folder of the case file')
         return
      end if
      open (newunit=unit, file=whole, action='read', status='old', iostat=status, iomsg=message)
      if (status /= 0) then
         call raise(error, '', 'the table '//whole//' cannot be opened: '//trim(message), 'check its permissions')
         return
      end if
      number = 0
      do
         read (unit, '(a)', iostat=status) line
         if (status /= 0) exit
         number = number + 1
         line = adjustl(line)
         if (len_trim(line) == 0 .or. scan(line(1:1), '0123456789+-.') == 0) cycle
         read (line, *, iostat=status) row
         if (status /= 0) then
            call raise(error, '', 'line '//to_text(number)//' of the table '//whole//' has no two numbers', &
                       'write time,value in each line')
            exit
         end if
         times = [times, row(1)]
         values = [values, row(2)]
      end do
      close (unit)
   end subroutine read_table

end module taut_case_mechanism_table
