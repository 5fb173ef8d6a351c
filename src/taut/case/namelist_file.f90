!> Case files: Fortran namelists, taken apart so that every complaint can name the line, the group and the entry.
!!
!! The file is cut into groups and assignments here; `taut_case_entries` reads the values.
module taut_case_namelist_file
   use taut_error, only: error_t, raise, to_text
   use taut_case_posix, only: read_whole
   use taut_spelling, only: nearest_name
   use taut_case_value, only: lower_case
   implicit none (type, external)
   private
   public :: namelist_file_t, group_t, assignment_t, check_names

   !> One assignment.
   type :: assignment_t
      !> What is assigned to, with its subscript, in lower case.
      character(:), allocatable :: name
      !> The same without the subscript, and the subscript without its parentheses and blanks; empty for none.
      character(:), allocatable :: base, subscript
      !> The value as it is written, comments and line ends blanked.
      character(:), allocatable :: value
      !> A namelist of its own: `&group name = value /`.
      character(:), allocatable :: text
      !> Line of the file.
      integer :: line = 0
   contains
      procedure :: shown
   end type assignment_t

   !> One group.
   type :: group_t
      !> Name in lower case, without the ampersand.
      character(:), allocatable :: name
      !> Line of the file at which it begins.
      integer :: line = 0
      !> Its assignments in order.
      type(assignment_t), allocatable :: entries(:)
   contains
      procedure :: place
   end type group_t

   !> A case file.
   type :: namelist_file_t
      !> Path as given.
      character(:), allocatable :: path
      !> Name of the case: the file's name without folder and ending.
      character(:), allocatable :: name
      !> The file as it is.
      character(:), allocatable :: content
      !> Groups in order.
      type(group_t), allocatable :: groups(:)
   contains
      procedure :: load
      procedure :: take
      procedure :: only_groups
      procedure :: locate
   end type namelist_file_t

   !> The mark with which some programs begin a file in UTF-8.
   character(*), parameter :: byte_order_mark = char(239)//char(187)//char(191)

contains

   !> Reads a file and cuts it into groups and assignments.
   subroutine load(self, path, error)
      !> The file.
      class(namelist_file_t), intent(out) :: self
      !> Its path.
      character(*), intent(in) :: path
      !> A file that is missing, or text that is no namelist.
      type(error_t), allocatable, intent(inout) :: error
      character(:), allocatable :: content
      logical :: done, exists

      inquire (file=path, exist=exists)
      if (.not. exists) then
         call raise(error, path, 'there is no such case file', 'check the path; the shipped cases are in the folder cases')
         return
      end if
      call read_whole(path, content, done)
      if (.not. done) then
         call raise(error, path, 'the case file cannot be read', 'give a text file, no folder and no pipe; check its permissions')
         return
      end if
      call self%take(path, content, error)
   end subroutine load

   !> Cuts a text into groups and assignments.
   subroutine take(self, path, content, error)
      !> The file.
      class(namelist_file_t), intent(out) :: self
      !> Its path: what complaints name.
      character(*), intent(in) :: path
      !> What it says.
      character(*), intent(in) :: content
      !> Text that is no namelist.
      type(error_t), allocatable, intent(inout) :: error
      character(len=len(content)) :: text
      integer :: line(len(content))
      type(group_t), allocatable :: groups(:)
      integer :: i, first, last, n, start

      self%path = path
      first = index(path, '/', back=.true.) + 1
      last = index(path, '.', back=.true.) - 1
      if (last < first) last = len(path)
      self%name = path(first:last)
      ! Results go to a folder of this name.
      if (self%name == '.' .or. self%name == '..') then
         call raise(error, path, 'a case of this name would write its results into another folder', 'rename the file')
         return
      end if
      allocate (self%groups(0))
      self%content = content
      call blank_comments(content, text, line)

      ! Room for all that there can be: lists that grow one by one take the square of the time.
      allocate (groups(count([(text(i:i) == '&', i=1, len(text))])))
      n = 0
      i = 1
      do
         i = i + verify_blank(text(i:)) - 1
         if (i > len(text)) exit
         if (text(i:i) /= '&') then
            call raise(error, path//':'//to_text(line(i)), 'there is text outside a group: "'//word(text(i:))//'"', &
                       'a group begins with & and its name and ends with /; comments begin with !')
            return
         end if
         start = i
         i = i + 1
         do while (i <= len(text))
            if (.not. is_name(text(i:i))) exit
            i = i + 1
         end do
         n = n + 1
         associate (group => groups(n))
            group%name = lower_case(text(start + 1:i - 1))
            group%line = line(start)
            first = i
            last = end_of_group(text, first)
            if (last == 0) then
               call raise(error, path//':'//to_text(group%line), 'the group &'//group%name//' has no end', &
                          'end it with / (and close its quotation marks)')
               return
            end if
            call take_entries(path, group, text(first:last - 1), line(first:last), error)
            if (allocated(error)) return
         end associate
         i = last + 1
      end do
      self%groups = groups(:n)
   end subroutine take

   !> The whole file in one text, comments blanked, line ends as blanks; and the line of each character.
   subroutine blank_comments(content, text, line)
      character(*), intent(in) :: content
      character(len=len(content)), intent(out) :: text
      integer, intent(out) :: line(len(content))
      character :: quote
      integer :: i, number
      logical :: comment

      text = content
      if (index(text, byte_order_mark) == 1) text(:len(byte_order_mark)) = ''
      number = 1
      quote = ' '
      comment = .false.
      do i = 1, len(text)
         line(i) = number
         if (text(i:i) == new_line('a')) then
            number = number + 1
            comment = .false.
            text(i:i) = ' '
         else if (comment .or. iachar(text(i:i)) < 32) then
            text(i:i) = ' '
         else if (quote /= ' ') then
            if (text(i:i) == quote) quote = ' '
         else if (text(i:i) == '"' .or. text(i:i) == "'") then
            quote = text(i:i)
         else if (text(i:i) == '!') then
            comment = .true.
            text(i:i) = ' '
         end if
      end do
   end subroutine blank_comments

   !> Position of the slash that ends a group, 0 if there is none.
   pure function end_of_group(text, first) result(position)
      character(*), intent(in) :: text
      integer, intent(in) :: first
      integer :: position
      character :: quote

      quote = ' '
      do position = first, len(text)
         if (quote /= ' ') then
            if (text(position:position) == quote) quote = ' '
         else if (text(position:position) == '"' .or. text(position:position) == "'") then
            quote = text(position:position)
         else if (text(position:position) == '/') then
            return
         else if (text(position:position) == '&') then
            exit
         end if
      end do
      position = 0
   end function end_of_group

   !> Cuts the inside of a group at its assignments.
   subroutine take_entries(path, group, text, line, error)
      character(*), intent(in) :: path
      type(group_t), intent(inout) :: group
      character(*), intent(in) :: text
      integer, intent(in) :: line(:)
      type(error_t), allocatable, intent(inout) :: error
      type(assignment_t) :: item
      type(assignment_t), allocatable :: entries(:)
      integer, allocatable :: equals(:), starts(:)
      character :: quote
      integer :: i, j, n, stop_at

      n = count([(text(i:i) == '=', i=1, len(text))])
      allocate (equals(n), starts(n), entries(n), group%entries(0))
      n = 0
      quote = ' '
      do i = 1, len(text)
         if (quote /= ' ') then
            if (text(i:i) == quote) quote = ' '
         else if (text(i:i) == '"' .or. text(i:i) == "'") then
            quote = text(i:i)
         else if (text(i:i) == '=') then
            n = n + 1
            equals(n) = i
            starts(n) = name_before(text, i)
         end if
      end do
      stop_at = len(text)
      if (n > 0) stop_at = starts(1) - 1
      if (len_trim(text(:stop_at)) > 0) then
         j = verify_blank(text)
         call raise(error, group%place(path, line(j)), 'a value has no name: "'//word(text(j:))//'"', 'write name = value')
         return
      end if
      do i = 1, n
         stop_at = len(text)
         if (i < n) stop_at = starts(i + 1) - 1
         item%name = lower_case(trim(text(starts(i):equals(i) - 1)))
         item%line = line(starts(i))
         if (len(item%name) == 0) then
            call raise(error, group%place(path, line(equals(i))), 'there is a = without a name before it', &
                       'write name = value')
            return
         end if
         ! A comma alone would be a null value, which leaves the default without a word.
         if (verify(text(equals(i) + 1:stop_at), ' ,') == 0) then
            call raise(error, group%place(path, item%line), item%name//' has no value', 'write name = value')
            return
         end if
         do j = 1, i - 1
            if (entries(j)%name == item%name) then
               call raise(error, group%place(path, item%line), item%name//' is given twice', &
                          'remove one; the other is in line '//to_text(entries(j)%line))
               return
            end if
         end do
         item%base = base_name(item%name)
         item%subscript = squeezed(item%name(len(item%base) + 1:))
         item%value = trim(adjustl(text(equals(i) + 1:stop_at)))
         item%text = '&'//group%name//' '//item%name//' = '//item%value//' /'
         entries(i) = item
      end do
      group%entries = entries(:n)
   end subroutine take_entries

   !> Where the name before an equals sign begins, subscripts included.
   pure function name_before(text, equals) result(first)
      character(*), intent(in) :: text
      integer, intent(in) :: equals
      integer :: first

      first = equals - 1
      do while (first >= 1)
         if (text(first:first) /= ' ') exit
         first = first - 1
      end do
      if (first >= 1) then
         if (text(first:first) == ')') first = max(1, index(text(:first), '(', back=.true.) - 1)
      end if
      do while (first >= 1)
         if (.not. is_name(text(first:first))) exit
         first = first - 1
      end do
      first = first + 1
   end function name_before

   !> Complains if the file has no group, a group that is not among those known, or one twice that may be there once only.
   subroutine only_groups(self, names, error, many)
      !> The file.
      class(namelist_file_t), intent(in) :: self
      !> Known names in lower case.
      character(*), intent(in) :: names(:)
      !> What is wrong.
      type(error_t), allocatable, intent(inout) :: error
      !> The groups that may be there more than once; default: none.
      character(*), intent(in), optional :: many(:)
      character(:), allocatable :: known, meant, remedy
      integer :: i, j

      known = '&'//trim(names(1))
      do i = 2, size(names)
         known = known//', &'//trim(names(i))
      end do
      ! A file that was lost while it was saved is empty: that must not pass for a case with nothing but defaults.
      if (size(self%groups) == 0) call raise(error, self%path, 'the case file has no group', 'the groups are '//known)
      do i = 1, size(self%groups)
         if (.not. any(names == self%groups(i)%name)) then
            meant = trim(nearest_name(self%groups(i)%name, names))
            remedy = 'the groups are '//known
            if (len(meant) > 0) remedy = 'did you mean &'//meant//'? T'//remedy(2:)
            call raise(error, self%path//':'//to_text(self%groups(i)%line), 'there is no group &'//self%groups(i)%name//' here', &
                       remedy)
            return
         end if
         if (present(many)) then
            if (any(many == self%groups(i)%name)) cycle
         end if
         do j = 1, i - 1
            if (self%groups(j)%name == self%groups(i)%name) &
               call raise(error, self%groups(i)%place(self%path, self%groups(i)%line), 'the group is there twice', &
                          'join it with that in line '//to_text(self%groups(j)%line))
         end do
      end do
   end subroutine only_groups

   !> Complains if two case files have one name: the results of one would take the place of those of the other.
   subroutine check_names(files, error)
      !> The files.
      type(namelist_file_t), intent(in) :: files(:)
      !> Two that have the same name.
      type(error_t), allocatable, intent(inout) :: error
      integer :: i, j

      do i = 2, size(files)
         do j = 1, i - 1
            if (files(i)%name == files(j)%name) &
               call raise(error, files(i)%path, 'its results would take the place of those of '//files(j)%path, &
                          'rename one of the files, or run them one by one with different --out')
         end do
      end do
   end subroutine check_names

   !> A name without its subscript.
   pure function base_name(name) result(base)
      character(*), intent(in) :: name
      character(:), allocatable :: base

      base = name
      if (index(name, '(') > 0) base = trim(name(:index(name, '(') - 1))
   end function base_name

   !> Puts a place in the file before an error that was found later, with the values.
   subroutine locate(self, group, error)
      !> The file.
      class(namelist_file_t), intent(in) :: self
      !> The group that the values came from.
      type(group_t), intent(in) :: group
      !> The error, if there is one.
      type(error_t), allocatable, intent(inout) :: error

      if (allocated(error)) error%where = self%path//':'//to_text(group%line)//': &'//group%name
   end subroutine locate

   !> Such as `cases/a.nml:12: &joint "hinge"`.
   pure function place(self, path, line) result(text)
      !> The group.
      class(group_t), intent(in) :: self
      !> Path of the case file.
      character(*), intent(in) :: path
      !> A line of it.
      integer, intent(in) :: line
      !> Both, as a message begins.
      character(:), allocatable :: text
      integer :: i

      text = path//':'//to_text(line)//': &'//self%name
      if (.not. allocated(self%entries)) return
      do i = 1, size(self%entries)
         associate (value => self%entries(i)%value)
            if (self%entries(i)%name == 'name' .and. index(value, '"') == 1) text = text//' '//value(:index(value(2:), '"') + 1)
         end associate
      end do
   end function place

   !> The value as a message shows it: not too long, without the comma that may end it.
   pure function shown(self) result(text)
      !> The assignment.
      class(assignment_t), intent(in) :: self
      !> On one line, shortened if it is long.
      character(:), allocatable :: text
      integer, parameter :: longest = 60

      text = self%value
      if (text(len(text):) == ',') text = trim(text(:len(text) - 1))
      if (len(text) > longest) text = text(:longest)//'...'
   end function shown

   !> What is between parentheses, without blanks.
   pure function squeezed(text) result(inside)
      character(*), intent(in) :: text
      character(:), allocatable :: inside
      integer :: i

      inside = ''
      do i = 1, len(text)
         if (verify(text(i:i), '() ') == 1) inside = inside//text(i:i)
      end do
   end function squeezed

   !> Position of the first character that is not blank; one past the end if there is none.
   pure function verify_blank(text) result(position)
      character(*), intent(in) :: text
      integer :: position

      position = verify(text, ' ')
      if (position == 0) position = len(text) + 1
   end function verify_blank

   !> The first word of a text, not too long.
   pure function word(text) result(first)
      character(*), intent(in) :: text
      character(:), allocatable :: first

      first = text(:min(len(text), 20))
      if (index(first, ' ') > 0) first = first(:index(first, ' ') - 1)
   end function word

   !> Whether a character can be part of a name.
   pure function is_name(c) result(answer)
      character, intent(in) :: c
      logical :: answer

      answer = (c >= 'a' .and. c <= 'z') .or. (c >= 'A' .and. c <= 'Z') .or. (c >= '0' .and. c <= '9') .or. c == '_'
   end function is_name

end module taut_case_namelist_file
