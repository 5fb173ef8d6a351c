!> Many runs of one case: a case file with blanks, and a list of what stands in them.
!!
!! A blank is a number between two @, as in `mass = @1@`. Each line of the list is one run: its name, and then the values of the
!! blanks as a case file has them, with a tab before each.
module taut_case_variants
   use taut_error, only: error_t, raise, to_text
   use taut_name_index, only: name_index_t
   use taut_case_csv, only: csv_field
   use taut_case_extremes, only: extreme_columns
   use taut_case_group, only: declared_t
   use taut_case_kind, only: case_kind_t
   use taut_case_namelist_file, only: namelist_file_t
   use taut_case_posix, only: read_whole
   use taut_case_process, only: caught_signal, output_is_lost, say
   use taut_case_run, only: check_start, run_rows
   use taut_case_settings, only: extreme_t, read_extremes, settings_t
   use taut_case_summary, only: failed_row, summary_header
   use taut_constrained_system, only: state_t
   use taut_constrained_system_tables, only: tabulated_system_t
   implicit none (type, external)
   private
   public :: run_variants, variants_t

   character, parameter :: tab = achar(9), line_end = new_line('a')

   !> What stands before a blank, and the blank's number; 0 at the end of the text.
   type :: part_t
      character(:), allocatable :: text
      integer :: blank = 0
   end type part_t

   !> A case file with blanks and its list.
   type :: variants_t
      private
      type(part_t), allocatable :: parts(:)
      character(:), allocatable :: list_path, list
      integer :: blanks = 0, next_letter = 1, line = 0
      !> The lines of the names so far.
      type(name_index_t) :: names
   contains
      procedure :: load
      procedure :: next
      procedure :: blanks_left
   end type variants_t

contains

   !> Runs all lines of a list one after the other. Each leaves rows on standard output, those of the case's summary with the
   !! run's name before them and, behind them, why it ended if that was early; all rows of a run are written at once, so
   !! that what is there is whole however the program ends. A run that cannot be made leaves a row that says so.
   subroutine run_variants(kind, path, list_path, all_ended, interrupted, error)
      !> The kind of case file.
      class(case_kind_t), intent(in) :: kind
      !> The case file.
      character(*), intent(in) :: path
      !> The list.
      character(*), intent(in) :: list_path
      !> Whether every run was made and reached its end or a terminal event.
      logical, intent(out) :: all_ended
      !> Whether a signal ended it; the run that it met leaves nothing.
      logical, intent(out) :: interrupted
      !> A file that cannot be read, or a list that does not fit it.
      type(error_t), allocatable, intent(inout) :: error
      type(variants_t) :: variants
      class(case_kind_t), allocatable :: own
      type(declared_t), allocatable :: known(:)
      type(namelist_file_t) :: file
      class(tabulated_system_t), allocatable :: model
      type(state_t) :: start
      type(settings_t) :: settings
      type(extreme_t), allocatable :: extremes(:)
      type(error_t), allocatable :: refusal
      character(:), allocatable :: name, names, rows, text
      integer :: i

      all_ended = .true.
      interrupted = .false.
      call variants%load(path, list_path, error)
      if (allocated(error)) return
      call kind%declare(known)
      allocate (own, source=kind)
      call move_alloc(known, own%known)
      ! What all runs have in common tells which columns there are.
      call variants%blanks_left(text)
      call file%take(path, text, refusal)
      allocate (extremes(0))
      if (.not. allocated(refusal)) call read_extremes(file, extremes, refusal)
      if (allocated(refusal)) deallocate (refusal)
      names = ''
      do i = 1, size(extremes)
         names = names//extreme_columns(extremes(i)%name, .true.)
      end do
      call say('run,'//summary_header//names//',message')
      do
         call variants%next(name, text, error)
         if (allocated(error) .or. .not. allocated(name)) return
         call file%take(path, text, refusal)
         if (.not. allocated(refusal)) call own%read(file, model, start, settings, refusal)
         if (.not. allocated(refusal)) call check_extremes(file, extremes, settings%extremes, refusal)
         if (.not. allocated(refusal)) call check_start(file, model, start, settings, refusal)
         if (.not. allocated(refusal)) &
            call run_rows(csv_field(name), file, model, start, settings, rows, all_ended, refusal)
         if (allocated(refusal)) then
            all_ended = .false.
            rows = failed_row(csv_field(name), file%name, refusal%line(), 4*size(extremes))
            deallocate (refusal)
         end if
         interrupted = caught_signal() /= 0
         if (interrupted) return
         call say(rows)
         if (output_is_lost()) return
      end do
   end subroutine run_variants

   !> Whether a run has the extremes that all runs have: they are columns of one table.
   subroutine check_extremes(file, common, own, error)
      type(namelist_file_t), intent(in) :: file
      type(extreme_t), intent(in) :: common(:), own(:)
      type(error_t), allocatable, intent(inout) :: error
      logical :: same
      integer :: i

      same = size(common) == size(own)
      do i = 1, size(own)
         if (same) same = common(i)%name == own(i)%name
      end do
      if (.not. same) call raise(error, file%path, '&extreme differs from run to run', 'leave blanks out of it')
   end subroutine check_extremes

   !> Reads a case file and its list.
   subroutine load(self, path, list_path, error)
      !> Both.
      class(variants_t), intent(out) :: self
      !> The case file.
      character(*), intent(in) :: path
      !> The list.
      character(*), intent(in) :: list_path
      !> One that cannot be read.
      type(error_t), allocatable, intent(inout) :: error
      character(:), allocatable :: text
      integer :: first, last, length, number, status
      logical :: done

      allocate (self%parts(0))
      self%list_path = list_path
      call read_whole(path, text, done)
      if (.not. done) then
         call raise(error, path, 'the case file cannot be read', 'give the path of a file with blanks such as @1@')
         return
      end if
      first = 1
      do
         ! The next blank, if what is between two @ is a number.
         last = first
         number = 0
         do
            length = index(text(last:), '@')
            if (length == 0) exit
            last = last + length
            length = index(text(last:), '@') - 1
            if (length < 1 .or. length > 6) cycle
            if (verify(text(last:last + length - 1), '0123456789') > 0) cycle
            read (text(last:last + length - 1), *, iostat=status) number
            if (status == 0 .and. number > 0) exit
         end do
         if (number == 0) exit
         self%parts = [self%parts, part_t(text(first:last - 2), number)]
         self%blanks = max(self%blanks, number)
         first = last + length + 1
      end do
      self%parts = [self%parts, part_t(text(first:), 0)]
      call read_whole(list_path, self%list, done)
      if (.not. done) call raise(error, list_path, 'the list of runs cannot be read', 'give the path of a text file, no pipe')
   end subroutine load

   !> The case file with its blanks.
   subroutine blanks_left(self, text)
      !> The case file and its list.
      class(variants_t), intent(in) :: self
      !> The case file.
      character(:), allocatable, intent(out) :: text
      integer :: i

      text = ''
      do i = 1, size(self%parts)
         text = text//self%parts(i)%text
         if (self%parts(i)%blank > 0) text = text//'@'//to_text(self%parts(i)%blank)//'@'
      end do
   end subroutine blanks_left

   !> The next run.
   subroutine next(self, name, text, error)
      !> The case file and its list.
      class(variants_t), intent(inout) :: self
      !> The run's name; not allocated at the end of the list.
      character(:), allocatable, intent(out) :: name
      !> Its case file.
      character(:), allocatable, intent(out) :: text
      !> A line that has not as many values as there are blanks.
      type(error_t), allocatable, intent(inout) :: error
      integer :: firsts(0:self%blanks + 1)
      integer :: i, last, length, used

      do
         if (self%next_letter > len(self%list)) then
            if (self%names%count == 0) call raise(error, self%list_path, 'the list has no run', &
                                                  'write a line for each, with its name and the values of the blanks')
            return
         end if
         length = index(self%list(self%next_letter:), line_end)
         last = self%next_letter + length - 2
         if (length == 0) last = len(self%list)
         self%line = self%line + 1
         if (last >= self%next_letter) exit
         self%next_letter = last + 2
      end do
      associate (line => self%list(self%next_letter:last))
         firsts(0) = 1
         do i = 1, self%blanks
            length = index(line(firsts(i - 1):), tab)
            if (length == 0) exit
            firsts(i) = firsts(i - 1) + length
         end do
         if (i <= self%blanks .or. index(line(firsts(min(i, self%blanks + 1) - 1):), tab) > 0) then
            call raise(error, self%list_path//':'//to_text(self%line), 'the line has not '//to_text(self%blanks)// &
                       ' values after the name of the run', 'write a value for each blank of the case file, a tab before each')
            return
         end if
         firsts(self%blanks + 1) = len(line) + 2
         length = 0
         do i = 1, size(self%parts)
            associate (part => self%parts(i))
               length = length + len(part%text)
               if (part%blank > 0) length = length + firsts(part%blank + 1) - firsts(part%blank) - 1
            end associate
         end do
         allocate (character(len=length) :: text)
         used = 0
         do i = 1, size(self%parts)
            associate (part => self%parts(i))
               text(used + 1:used + len(part%text)) = part%text
               used = used + len(part%text)
               if (part%blank > 0) then
                  length = firsts(part%blank + 1) - firsts(part%blank) - 1
                  text(used + 1:used + length) = line(firsts(part%blank):firsts(part%blank + 1) - 2)
                  used = used + length
               end if
            end associate
         end do
         name = line(:firsts(1) - 2)
      end associate
      self%next_letter = last + 2
      call check_name(self, name, error)
   end subroutine next

   !> The name of a run tells its rows from those of others.
   subroutine check_name(self, name, error)
      class(variants_t), intent(inout) :: self
      character(*), intent(in) :: name
      type(error_t), allocatable, intent(inout) :: error
      integer :: before

      before = self%names%find(name)
      if (len_trim(name) == 0) then
         call raise(error, self%list_path//':'//to_text(self%line), 'the run has no name', 'begin the line with one')
      else if (before > 0) then
         call raise(error, self%list_path//':'//to_text(self%line), 'run "'//trim(name)//'" is there already, in line '// &
                    to_text(before), 'give it another name')
      end if
      call self%names%add(name, self%line)
   end subroutine check_name

end module taut_case_variants
