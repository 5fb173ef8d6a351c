!> What a group of a case file says, assignment by assignment, as the entries of the group ask for it; and what is complained of.
module taut_case_assignments
   use taut_error, only: error_t, raise, to_text
   use taut_case_assignment, only: left_out, no_repetition, no_such_subscript, not_apart, not_one_each, take_words, taken, &
                                   too_many, wrong_number
   use taut_case_entry, only: choice_list, entry_t, joined
   use taut_case_namelist_file, only: group_t
   use taut_case_value, only: word_t
   use taut_spelling, only: nearest_name
   implicit none (type, external)
   private
   public :: assignments_t

   !> The assignments of a group.
   type :: assignments_t
      !> The first that is wrong with them.
      type(error_t), allocatable :: error
      type(group_t), private :: from
      character(:), allocatable, private :: path
      !> Those that an entry was met for.
      logical, allocatable, private :: met(:)
   contains
      procedure :: init
      procedure :: next
      procedure :: is_whole
      procedure :: check_text
      procedure :: refuse
      procedure :: has_unknown
      procedure :: unknown
   end type assignments_t

contains

   !> Takes what the file says.
   subroutine init(self, path, from)
      !> The assignments.
      class(assignments_t), intent(out) :: self
      !> The case file.
      character(*), intent(in) :: path
      !> The group.
      type(group_t), intent(in) :: from

      self%path = path
      self%from = from
      allocate (self%met(size(from%entries)), source=.false.)
   end subroutine init

   !> The next assignment to an entry: its words, each once, and the places of the values that they go to.
   subroutine next(self, name, k, dims, counts, kind, help, words, places)
      !> The assignments; none where declarations are collected.
      class(assignments_t), intent(inout) :: self
      !> Name of the entry, in lower case.
      character(*), intent(in) :: name
      !> Number of the last assignment, 0 at first; 0 if there is none any more, or something is wrong.
      integer, intent(inout) :: k
      !> Bounds of subscripts.
      integer, intent(in) :: dims(:)
      !> Numbers of values there may be without a subscript; none: as many as fit.
      integer, intent(in) :: counts(:)
      !> What a value is called.
      character(*), intent(in) :: kind
      !> What it is.
      character(*), intent(in) :: help
      !> The words.
      type(word_t), allocatable, intent(out) :: words(:)
      !> Where each goes, in the order of columns.
      integer, allocatable, intent(out) :: places(:)
      integer :: code, n

      n = k
      k = 0
      if (.not. allocated(self%met) .or. allocated(self%error)) return
      do n = n + 1, size(self%from%entries)
         if (self%from%entries(n)%base == name) exit
      end do
      if (n > size(self%from%entries)) return
      self%met(n) = .true.
      call take_words(self%from%entries(n)%value, self%from%entries(n)%subscript, dims, counts, words, places, code)
      select case (code)
      case (taken)
         k = n
      case (left_out)
         call self%refuse(n, 'cannot be read: a value is left out', 'write each value, with one comma between two')
      case (not_apart)
         call self%refuse(n, 'cannot be read: two values have nothing between them', 'put a comma between them')
      case (no_repetition)
         call self%refuse(n, 'cannot be read: it repeats a value no time', 'write 3*0.5 for three of it')
      case (no_such_subscript)
         call self%refuse(n, 'cannot be read: '//name//' has no such subscript', &
                          'leave the subscript out, or give one of the right type')
      case (too_many)
         call self%refuse(n, 'cannot be read: there are more than '//to_text(dims(1))//' '//kind//'s', 'give fewer')
      case (not_one_each)
         call self%refuse(n, 'cannot be read: there are not as many values as places', 'give one value for each subscript')
      case (wrong_number)
         if (size(dims) == 0) then
            call self%refuse(n, 'cannot be read: there is more than one '//kind, 'give one value of the right type: '//help)
         else
            call self%refuse(n, 'cannot be read: it takes '//joined(counts)//' '//kind//'s', &
                             'give all, or one by its subscript ('//help//')')
         end if
      end select
   end subroutine next

   !> Whether an assignment is to all of its entry, without a subscript.
   pure logical function is_whole(self, k)
      !> The assignments.
      class(assignments_t), intent(in) :: self
      !> Number of the assignment.
      integer, intent(in) :: k

      is_whole = self%from%entries(k)%subscript == ''
   end function is_whole

   !> A text must be in quotation marks, not too long, and known.
   subroutine check_text(self, k, word, choices, most)
      !> The assignments.
      class(assignments_t), intent(inout) :: self
      !> Number of the assignment.
      integer, intent(in) :: k
      !> Its word.
      type(word_t), intent(in) :: word
      !> The texts that are known; default: all texts are.
      character(*), intent(in), optional :: choices(:)
      !> Number of characters that it may have; default: any.
      integer, intent(in), optional :: most
      character(:), allocatable :: meant, remedy

      if (.not. word%quoted) call self%refuse(k, 'cannot be read: "'//word%text//'" has no quotation marks', &
                                              'put a text between quotation marks')
      if (present(choices)) then
         if (.not. any(choices == word%text)) then
            meant = trim(nearest_name(word%text, choices))
            remedy = 'use one of '//choice_list(choices)
            if (len(meant) > 0) remedy = 'did you mean "'//meant//'"? U'//remedy(2:)
            call self%refuse(k, 'is unknown', remedy)
         end if
      end if
      if (present(most)) then
         if (len(word%text) > most) call self%refuse(k, 'is longer than '//to_text(most)//' characters', 'shorten it')
      end if
   end subroutine check_text

   !> Complains of an assignment.
   subroutine refuse(self, k, what, remedy)
      !> The assignments; the first complaint counts.
      class(assignments_t), intent(inout) :: self
      !> Number of the assignment.
      integer, intent(in) :: k
      !> What is wrong with it, to be read behind what it says.
      character(*), intent(in) :: what
      !> What to do.
      character(*), intent(in) :: remedy

      associate (it => self%from%entries(k))
         call raise(self%error, self%from%place(self%path, it%line), it%name//' = '//it%shown()//' '//what, remedy)
      end associate
   end subroutine refuse

   !> Whether the file says something that nobody declared, and nothing else is wrong.
   pure logical function has_unknown(self)
      !> The assignments, all entries passed.
      class(assignments_t), intent(in) :: self

      has_unknown = .not. (all(self%met) .or. allocated(self%error))
   end function has_unknown

   !> Complains of what the file says and nobody declared.
   subroutine unknown(self, declared)
      !> The assignments, of which one is unknown.
      class(assignments_t), intent(inout) :: self
      !> All that are declared.
      type(entry_t), intent(in) :: declared(:)
      character(len=64) :: names(size(declared))
      character(:), allocatable :: meant, remedy
      integer :: i, k

      k = findloc(self%met, .false., 1)
      remedy = 'the entries are '
      do i = 1, size(declared)
         names(i) = declared(i)%name
         if (i > 1) remedy = remedy//', '
         remedy = remedy//declared(i)%name
      end do
      meant = trim(nearest_name(self%from%entries(k)%base, names))
      if (len(meant) > 0) remedy = 'did you mean '//meant//'? The'//remedy(4:)
      call raise(self%error, self%from%place(self%path, self%from%entries(k)%line), &
                 'there is no entry '//self%from%entries(k)%name, remedy)
   end subroutine unknown

end module taut_case_assignments
