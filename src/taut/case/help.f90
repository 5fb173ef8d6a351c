!> What a case file may say, for people: made from what is declared.
module taut_case_help
   use taut_case_entry, only: entry_t
   use taut_case_group, only: declared_t
   implicit none (type, external)
   private
   public :: case_help, case_reference

   character, parameter :: nl = new_line('a')
   !> Width of a line of the help.
   integer, parameter :: width = 110

contains

   !> The text of `--help-case`.
   function case_help(app, groups) result(text)
      !> Name of the app.
      character(*), intent(in) :: app
      !> The groups of its case files.
      type(declared_t), intent(in) :: groups(:)
      !> Many lines, each with its line end.
      character(:), allocatable :: text
      character(:), allocatable :: heading
      type(entry_t), allocatable :: list(:)
      integer :: column, i, j

      text = 'Case files of '//app//' are Fortran namelists: &group name = value, ... /. Comments begin with !, texts stand'//nl// &
             'in quotation marks. What has a default, in brackets here, may be left out.'//nl
      do i = 1, size(groups)
         associate (it => groups(i))
            heading = '&'//it%name//'  '//it%about
            if (it%many) heading = heading//'; any number of them'
            text = text//nl//wrapped(heading, 4)
            call it%collect(list)
            column = 0
            do j = 1, size(list)
               column = max(column, len(list(j)%name))
            end do
            do j = 1, size(list)
               text = text//wrapped('  '//list(j)%name//repeat(' ', column + 2 - len(list(j)%name))//sentence(list(j)), &
                                    column + 4)
            end do
         end associate
      end do
   end function case_help

   !> What is said of an entry.
   function sentence(it) result(text)
      type(entry_t), intent(in) :: it
      character(:), allocatable :: text

      text = it%help
      if (len(it%unit) > 0) text = text//' ['//it%unit//']'
      if (len(it%number) > 0) text = text//', '//it%number//' values'
      if (index(it%kind, '"') == 1) then
         text = text//': '//it%kind
      else if (it%kind == 'integer') then
         text = text//', integer'
      end if
      if (len(it%range) > 0) text = text//', '//it%range
      if (len(it%default) > 0) text = text//' ('//it%default//')'
   end function sentence

   !> A line that is cut between words where it is too long.
   function wrapped(line, indent) result(text)
      character(*), intent(in) :: line
      !> Blanks before what is continued.
      integer, intent(in) :: indent
      character(:), allocatable :: text
      character(:), allocatable :: rest
      integer :: last

      text = ''
      rest = line
      do while (len(rest) > width)
         last = index(rest(:width + 1), ' ', back=.true.)
         if (last <= indent + 1) exit
         text = text//trim(rest(:last))//nl
         rest = repeat(' ', indent)//rest(last + 1:)
      end do
      text = text//rest//nl
   end function wrapped

   !> The same as a page in Markdown: a heading and a table for each group.
   function case_reference(groups) result(text)
      !> The groups of a case file.
      type(declared_t), intent(in) :: groups(:)
      !> Many lines, each with its line end.
      character(:), allocatable :: text
      type(entry_t), allocatable :: list(:)
      integer :: i, j

      text = ''
      do i = 1, size(groups)
         associate (it => groups(i))
            call it%collect(list)
            if (i > 1) text = text//nl
            text = text//'### `&'//it%name//'`'//nl//nl//capital(it%about)
            if (it%many) text = text//'; any number of them'
            text = text//'.'//nl//nl//'| Entry | Values | Unit | Default | |'//nl//'| --- | --- | --- | --- | --- |'//nl
            do j = 1, size(list)
               associate (one => list(j))
                  text = text//'| `'//one%name//'` | '//cell(values_of(one))//' | '//cell(one%unit)//' | '//cell(one%default)// &
                         ' | '//cell(one%help)//' |'//nl
               end associate
            end do
         end associate
      end do
   end function case_reference

   !> What the values of an entry are.
   function values_of(it) result(text)
      type(entry_t), intent(in) :: it
      character(:), allocatable :: text

      text = it%kind
      if (len(it%number) > 0) text = it%number//' '//it%kind//'s'
      if (len(it%range) > 0) text = text//', '//it%range
   end function values_of

   !> A text that does not break a table.
   pure function cell(text) result(safe)
      character(*), intent(in) :: text
      character(:), allocatable :: safe
      integer :: i

      safe = ''
      do i = 1, len(text)
         if (text(i:i) == '|' .or. text(i:i) == '*') safe = safe//'\'
         safe = safe//text(i:i)
      end do
   end function cell

   !> A text with a capital in front.
   pure function capital(text) result(large)
      character(*), intent(in) :: text
      character(len=len(text)) :: large

      large = text
      if (len(text) == 0) return
      if (text(1:1) >= 'a' .and. text(1:1) <= 'z') large(1:1) = achar(iachar(text(1:1)) - 32)
   end function capital

end module taut_case_help
