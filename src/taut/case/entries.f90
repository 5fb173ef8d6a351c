!> The entries of a group, declared once each. What a group may say passes through one procedure,
!!
!!     subroutine declare(self, entries)
!!        class(rod_t), intent(inout) :: self
!!        type(entries_t), intent(inout) :: entries
!!        call entries%group('rod', 'a rigid rod')
!!        call entries%item('mass', self%mass, 'kg', 'its mass', above=0.0_wp)
!!        call entries%item('ends', self%ends, 'm', 'x of both ends')
!!     end subroutine declare
!!
!! which reads a case file, or tells the help what there is: a variable that is passed holds the default and takes what the file
!! says. `item` takes what has a default and a number of values; `option` what may be missing, which stays unallocated then.
module taut_case_entries
   use taut_kinds, only: wp
   use taut_error, only: to_text
   use taut_case_assignments, only: assignments_t
   use taut_case_entry, only: choice_list, entry_t, joined, range_t, real_range
   use taut_case_namelist_file, only: group_t
   use taut_case_value, only: read_integer, read_logical, read_real, short_text, word_t
   implicit none (type, external)
   private
   public :: entries_t

   !> What passes over the entries of a group.
   type :: entries_t
      !> Whether what is declared is collected, and whether values come from a group of a case file; if neither, it is the group's
      !! name alone that is asked for.
      logical :: collecting = .false., reading = .false.
      !> The group's name and what it is.
      character(:), allocatable :: name, about
      !> What was declared.
      type(entry_t), allocatable :: list(:)
      !> What the file says.
      type(assignments_t) :: said
   contains
      procedure :: collect
      procedure :: read_from
      procedure :: group
      generic :: item => real_item, reals_item, matrix_item, integer_item, logical_item, text_item
      generic :: option => real_option, reals_option, integers_option, text_option, texts_option
      procedure, private :: real_item, reals_item, matrix_item, integer_item, logical_item, text_item
      procedure, private :: real_option, reals_option, integers_option, text_option, texts_option
      procedure, private :: add, pass_numbers
   end type entries_t

contains

   !> Makes it ready to collect what is declared.
   subroutine collect(self)
      !> The entries.
      class(entries_t), intent(out) :: self

      self%collecting = .true.
      allocate (self%list(0))
   end subroutine collect

   !> Makes it ready to read a group.
   subroutine read_from(self, path, from)
      !> The entries.
      class(entries_t), intent(out) :: self
      !> The case file.
      character(*), intent(in) :: path
      !> The group.
      type(group_t), intent(in) :: from

      self%reading = .true.
      call self%said%init(path, from)
      allocate (self%list(0))
   end subroutine read_from

   !> Names the group.
   subroutine group(self, name, about)
      !> The entries.
      class(entries_t), intent(inout) :: self
      !> Name in lower case, without the ampersand.
      character(*), intent(in) :: name
      !> What it is, in a line.
      character(*), intent(in) :: about

      if (self%reading) return
      self%name = name
      self%about = about
   end subroutine group

   !> A number.
   subroutine real_item(self, name, value, unit, help, above, least, most)
      !> The entries.
      class(entries_t), intent(inout) :: self
      !> Name in lower case.
      character(*), intent(in) :: name
      !> The default, and what is read.
      real(wp), intent(inout) :: value
      !> Its unit.
      character(*), intent(in) :: unit
      !> What it is, in one line.
      character(*), intent(in) :: help
      !> A lower bound that is not valid itself.
      real(wp), intent(in), optional :: above
      !> A lower bound that is.
      real(wp), intent(in), optional :: least
      !> An upper bound that is.
      real(wp), intent(in), optional :: most
      real(wp), allocatable :: list(:)

      allocate (list, source=[value])
      call self%pass_numbers(name, list, [integer ::], [1], 'number', unit, help, real_range(above, least, most))
      value = list(1)
   end subroutine real_item

   !> Numbers, all of which must be given.
   subroutine reals_item(self, name, values, unit, help, above, least, most)
      !> The entries.
      class(entries_t), intent(inout) :: self
      !> Name in lower case.
      character(*), intent(in) :: name
      !> The defaults, and what is read.
      real(wp), intent(inout) :: values(:)
      !> Its unit.
      character(*), intent(in) :: unit
      !> What it is, in one line.
      character(*), intent(in) :: help
      !> A lower bound that is not valid itself.
      real(wp), intent(in), optional :: above
      !> A lower bound that is.
      real(wp), intent(in), optional :: least
      !> An upper bound that is.
      real(wp), intent(in), optional :: most
      real(wp), allocatable :: list(:)

      allocate (list, source=values)
      call self%pass_numbers(name, list, shape(values), shape(values), 'number', unit, help, real_range(above, least, most))
      values = list
   end subroutine reals_item

   !> Numbers of a matrix, column by column.
   subroutine matrix_item(self, name, values, unit, help)
      !> The entries.
      class(entries_t), intent(inout) :: self
      !> Name in lower case.
      character(*), intent(in) :: name
      !> The defaults, and what is read.
      real(wp), intent(inout) :: values(:, :)
      !> Its unit.
      character(*), intent(in) :: unit
      !> What it is, in one line.
      character(*), intent(in) :: help
      real(wp), allocatable :: list(:)

      allocate (list, source=reshape(values, [size(values)]))
      call self%pass_numbers(name, list, shape(values), [size(values)], 'number', unit, help, range_t())
      values = reshape(list, shape(values))
   end subroutine matrix_item

   !> An integer.
   subroutine integer_item(self, name, value, help, least, most)
      !> The entries.
      class(entries_t), intent(inout) :: self
      !> Name in lower case.
      character(*), intent(in) :: name
      !> The default, and what is read.
      integer, intent(inout) :: value
      !> What it is.
      character(*), intent(in) :: help
      !> Lower bound.
      integer, intent(in), optional :: least
      !> Upper bound.
      integer, intent(in), optional :: most
      real(wp), allocatable :: list(:)

      allocate (list, source=[real(value, wp)])
      call self%pass_numbers(name, list, [integer ::], [1], 'integer', '', help, integer_range(least, most))
      value = nint(list(1))
   end subroutine integer_item

   !> A truth value.
   subroutine logical_item(self, name, value, help)
      !> The entries.
      class(entries_t), intent(inout) :: self
      !> Name in lower case.
      character(*), intent(in) :: name
      !> The default, and what is read.
      logical, intent(inout) :: value
      !> What it means.
      character(*), intent(in) :: help
      type(word_t), allocatable :: words(:)
      integer, allocatable :: places(:)
      integer :: k
      logical :: fits

      if (self%collecting) call self%add(name, '.true. or .false.', '', '', '', trim(merge('.true. ', '.false.', value)), help)
      k = 0
      do
         call self%said%next(name, k, [integer ::], [1], 'truth value', help, words, places)
         if (k == 0) exit
         call read_logical(words(1), value, fits)
         if (.not. fits) call self%said%refuse(k, 'cannot be read: "'//words(1)%text//'" is no truth value', &
                                          'give a value of the right type: .true. or .false.')
      end do
   end subroutine logical_item

   !> A text that is no longer than its variable, or one of several.
   subroutine text_item(self, name, value, help, choices)
      !> The entries.
      class(entries_t), intent(inout) :: self
      !> Name in lower case.
      character(*), intent(in) :: name
      !> The default, and what is read.
      character(*), intent(inout) :: value
      !> What it is.
      character(*), intent(in) :: help
      !> The texts that are known; default: all texts are.
      character(*), intent(in), optional :: choices(:)
      character(:), allocatable :: text

      text = trim(value)
      call self%text_option(name, text, help, choices, most=len(value))
      value = text
   end subroutine text_item

   !> A number that may be missing.
   subroutine real_option(self, name, value, unit, help, above, least, most)
      !> The entries.
      class(entries_t), intent(inout) :: self
      !> Name in lower case.
      character(*), intent(in) :: name
      !> What is read.
      real(wp), intent(inout), allocatable :: value
      !> Its unit.
      character(*), intent(in) :: unit
      !> What it is, in one line.
      character(*), intent(in) :: help
      !> A lower bound that is not valid itself.
      real(wp), intent(in), optional :: above
      !> A lower bound that is.
      real(wp), intent(in), optional :: least
      !> An upper bound that is.
      real(wp), intent(in), optional :: most
      real(wp), allocatable :: list(:)

      if (allocated(value)) allocate (list, source=[value])
      call self%pass_numbers(name, list, [integer ::], [1], 'number', unit, help, real_range(above, least, most))
      if (allocated(list)) value = list(1)
   end subroutine real_option

   !> Numbers that may be missing.
   subroutine reals_option(self, name, values, unit, help, counts, above, least, most)
      !> The entries.
      class(entries_t), intent(inout) :: self
      !> Name in lower case.
      character(*), intent(in) :: name
      !> What is read.
      real(wp), intent(inout), allocatable :: values(:)
      !> Its unit.
      character(*), intent(in) :: unit
      !> What it is, in one line.
      character(*), intent(in) :: help
      !> How many there may be, in rising order; one that is not there with a subscript is 0.
      integer, intent(in) :: counts(:)
      !> A lower bound that is not valid itself.
      real(wp), intent(in), optional :: above
      !> A lower bound that is.
      real(wp), intent(in), optional :: least
      !> An upper bound that is.
      real(wp), intent(in), optional :: most

      call self%pass_numbers(name, values, counts(size(counts):), counts, 'number', unit, help, real_range(above, least, most))
   end subroutine reals_option

   !> Integers that may be missing, up to a number of them.
   subroutine integers_option(self, name, values, help, longest, least, most)
      !> The entries.
      class(entries_t), intent(inout) :: self
      !> Name in lower case.
      character(*), intent(in) :: name
      !> What is read.
      integer, intent(inout), allocatable :: values(:)
      !> What they are.
      character(*), intent(in) :: help
      !> How many there may be.
      integer, intent(in) :: longest
      !> Lower bound.
      integer, intent(in), optional :: least
      !> Upper bound.
      integer, intent(in), optional :: most
      real(wp), allocatable :: list(:)

      if (allocated(values)) allocate (list, source=real(values, wp))
      call self%pass_numbers(name, list, [longest], [integer ::], 'integer', '', help, integer_range(least, most))
      if (allocated(list)) values = nint(list)
   end subroutine integers_option

   !> Integers between two bounds.
   pure function integer_range(least, most) result(range)
      integer, intent(in), optional :: least, most
      type(range_t) :: range

      if (present(least)) range%least = least
      if (present(most)) range%most = most
   end function integer_range

   !> A text that may be missing.
   subroutine text_option(self, name, value, help, choices, most)
      !> The entries.
      class(entries_t), intent(inout) :: self
      !> Name in lower case.
      character(*), intent(in) :: name
      !> What is read.
      character(:), intent(inout), allocatable :: value
      !> What it is.
      character(*), intent(in) :: help
      !> The texts that are known; default: all texts are.
      character(*), intent(in), optional :: choices(:)
      !> Number of characters that it may have; default: any.
      integer, intent(in), optional :: most
      type(word_t), allocatable :: words(:)
      integer, allocatable :: places(:)
      character(:), allocatable :: default, kind
      integer :: k

      if (self%collecting) then
         kind = 'text'
         if (present(choices)) kind = choice_list(choices)
         default = ''
         if (allocated(value)) then
            if (len(value) > 0) default = '"'//value//'"'
         end if
         call self%add(name, kind, '', '', '', default, help)
         return
      end if
      k = 0
      do
         call self%said%next(name, k, [integer ::], [1], 'text', help, words, places)
         if (k == 0) exit
         call self%said%check_text(k, words(1), choices, most)
         value = words(1)%text
      end do
   end subroutine text_option

   !> Texts that may be missing, any number of them.
   subroutine texts_option(self, name, values, help, longest)
      !> The entries.
      class(entries_t), intent(inout) :: self
      !> Name in lower case.
      character(*), intent(in) :: name
      !> What is read; blank ones stand for those that a subscript leaves out.
      character(*), intent(inout), allocatable :: values(:)
      !> What they are.
      character(*), intent(in) :: help
      !> How many there may be.
      integer, intent(in) :: longest
      type(word_t), allocatable :: words(:)
      integer, allocatable :: places(:)
      character(:), allocatable :: before(:)
      integer :: i, k, n

      if (self%collecting) call self%add(name, 'text', '', 'any number of', '', '', help)
      k = 0
      do
         call self%said%next(name, k, [longest], [integer ::], 'text', help, words, places)
         if (k == 0) exit
         n = maxval(places)
         if (.not. allocated(values) .or. self%said%is_whole(k)) then
            if (allocated(values)) deallocate (values)
            allocate (values(n))
            values(:) = ''
         else if (n > size(values)) then
            allocate (before, source=values)
            deallocate (values)
            allocate (values(n))
            values(:) = ''
            values(:size(before)) = before
            deallocate (before)
         end if
         do i = 1, size(words)
            call self%said%check_text(k, words(i), most=len(values))
            values(places(i)) = words(i)%text
         end do
      end do
   end subroutine texts_option

   !> Numbers of any kind: collects what is declared, or reads them.
   subroutine pass_numbers(self, name, values, dims, counts, kind, unit, help, range)
      class(entries_t), intent(inout) :: self
      character(*), intent(in) :: name
      !> The defaults, if there are, and what is read.
      real(wp), intent(inout), allocatable :: values(:)
      !> Bounds of subscripts, and numbers of values there may be without one; none: as many as fit.
      integer, intent(in) :: dims(:), counts(:)
      !> `number` or `integer`.
      character(*), intent(in) :: kind, unit, help
      type(range_t), intent(in) :: range
      type(word_t), allocatable :: words(:)
      integer, allocatable :: places(:)
      character(:), allocatable :: default
      real(wp), allocatable :: before(:)
      real(wp) :: value
      integer :: i, k, n, whole
      logical :: fits

      if (self%collecting) then
         call self%add(name, kind, unit, number_text(dims, counts), range%described(), default_text(values), help)
         return
      end if
      k = 0
      do
         call self%said%next(name, k, dims, counts, kind, help, words, places)
         if (k == 0) exit
         default = default_text(values)
         n = maxval(places)
         if (size(counts) > 0) n = maxval(counts)
         if (self%said%is_whole(k)) n = size(words)
         if (.not. allocated(values) .or. self%said%is_whole(k)) then
            if (allocated(values)) deallocate (values)
            allocate (values(n), source=0.0_wp)
         else if (n > size(values)) then
            call move_alloc(values, before)
            allocate (values(n), source=0.0_wp)
            values(:size(before)) = before
         end if
         do i = 1, size(words)
            if (kind == 'integer') then
               call read_integer(words(i), whole, fits)
               value = whole
            else
               call read_real(words(i), value, fits)
            end if
            if (.not. fits) then
               call self%said%refuse(k, 'cannot be read: "'//words(i)%text//'" is no '//kind, &
                                'give a value of the right type, without unit or quotation marks: '//help)
            else if (.not. range%has(value)) then
               call self%said%refuse(k, range%complaint(value), remedy_of(range, kind, unit, help, default))
            else
               values(places(i)) = value
            end if
         end do
      end do
   end subroutine pass_numbers

   !> What to do about a number that is not valid.
   function remedy_of(range, kind, unit, help, default) result(text)
      type(range_t), intent(in) :: range
      character(*), intent(in) :: kind, unit, help, default
      character(:), allocatable :: text

      text = 'give a'
      if (kind == 'integer') text = text//'n'
      text = text//' '//kind
      if (len(range%described()) > 0) text = text//' ('//range%described()//')'
      if (len(unit) > 0) text = text//' in '//unit
      if (len(default) > 0) text = text//', such as '//default
      text = text//': '//help
   end function remedy_of

   !> How many values there may be, for the help.
   function number_text(dims, counts) result(text)
      integer, intent(in) :: dims(:), counts(:)
      character(:), allocatable :: text

      text = ''
      if (size(dims) == 0) return
      if (size(counts) == 0) text = 'up to '//to_text(dims(1))
      if (size(counts) > 0) text = joined(counts)
   end function number_text

   !> Defaults, for the help: one number where all are the same.
   function default_text(values) result(text)
      real(wp), intent(in), allocatable :: values(:)
      character(:), allocatable :: text
      integer :: i

      text = ''
      if (.not. allocated(values)) return
      ! What is as large as numbers get is no limit.
      if (any(abs(values) >= huge(1.0_wp))) return
      do i = 1, size(values)
         if (i > 1) text = text//', '
         text = text//short_text(values(i))
         if (all(abs(values - values(1)) <= 0.0_wp) .and. size(values) > 4) return
      end do
   end function default_text

   !> Adds what was declared.
   subroutine add(self, name, kind, unit, number, range, default, help)
      class(entries_t), intent(inout) :: self
      character(*), intent(in) :: name, kind, unit, number, range, default, help
      type(entry_t) :: declared

      declared%name = name
      declared%kind = kind
      declared%unit = unit
      declared%number = number
      declared%range = range
      declared%default = default
      declared%help = help
      self%list = [self%list, declared]
   end subroutine add

end module taut_case_entries
