!> The words of one assignment, each for itself, and the places of a variable that they go to.
module taut_case_assignment
   use, intrinsic :: iso_fortran_env, only: int64
   use taut_case_value, only: read_integer, split_words, word_t, words_no_separator, words_null
   implicit none (type, external)
   private
   public :: take_words
   public :: taken, left_out, not_apart, no_repetition, no_such_subscript, too_many, wrong_number, not_one_each

   !> How it went: all is well; a value is left out; two values have nothing between them; a value is repeated no time; the
   !! variable has no such subscript; there are more values than fit; there are not as many as are wanted, or as a subscript
   !! names.
   integer, parameter :: taken = 0, left_out = 1, not_apart = 2, no_repetition = 3, no_such_subscript = 4, too_many = 5, &
                         wrong_number = 6, not_one_each = 7

contains

   !> Takes an assignment apart.
   pure subroutine take_words(value, subscript, dims, counts, words, places, code)
      !> What is assigned.
      character(*), intent(in) :: value
      !> The subscript of what it is assigned to; empty for none.
      character(*), intent(in) :: subscript
      !> Bounds of subscripts; none for a single value.
      integer, intent(in) :: dims(:)
      !> Numbers of values there may be without a subscript; none for all that fit.
      integer, intent(in) :: counts(:)
      !> The words, each as often as it is meant.
      type(word_t), allocatable, intent(out) :: words(:)
      !> Where each goes, in the order of columns.
      integer, allocatable, intent(out) :: places(:)
      !> One of the codes above; words and places are there if it is `taken`.
      integer, intent(out) :: code
      type(word_t), allocatable :: found(:)
      integer(int64) :: total
      integer :: i, j

      call split_words(value, found, code)
      select case (code)
      case (words_null)
         code = left_out
         return
      case (words_no_separator)
         code = not_apart
         return
      end select
      code = taken
      total = 0
      do i = 1, size(found)
         if (found(i)%count < 1) code = no_repetition
         ! A number of values that no memory holds must not overflow.
         total = total + min(found(i)%count, int(huge(i), int64))
      end do
      if (code /= taken) return
      if (len(subscript) > 0) then
         call take_subscript(subscript, dims, places)
         if (size(places) == 0) code = no_such_subscript
         if (code == taken .and. size(places) /= total) code = not_one_each
      else if (size(counts) > 0) then
         if (all(counts /= total)) code = wrong_number
      else if (total > dims(1)) then
         code = too_many
      end if
      if (code /= taken) return
      if (len(subscript) == 0) places = [(i, i=1, int(total))]
      allocate (words(size(places)))
      j = 0
      do i = 1, size(found)
         words(j + 1:j + int(found(i)%count)) = found(i)
         j = j + int(found(i)%count)
      end do
   end subroutine take_words

   !> Places in column order that a subscript such as `2`, `1:3` or `:,2` names; none if it is impossible.
   pure subroutine take_subscript(subscript, dims, places)
      character(*), intent(in) :: subscript
      integer, intent(in) :: dims(:)
      integer, allocatable, intent(out) :: places(:)
      integer :: colon, dimension, first, i, last, start, stop_at, stride
      logical :: fits

      places = [1]
      stride = 1
      start = 1
      fits = size(dims) > 0
      do dimension = 1, size(dims)
         stop_at = start + index(subscript(start:)//',', ',') - 2
         first = 1
         last = dims(dimension)
         colon = index(subscript(start:stop_at), ':')
         if (colon == 0) then
            call read_integer(word_t(subscript(start:stop_at)), first, fits)
            last = first
         else
            if (colon > 1) call read_integer(word_t(subscript(start:start + colon - 2)), first, fits)
            if (start + colon <= stop_at .and. fits) call read_integer(word_t(subscript(start + colon:stop_at)), last, fits)
         end if
         fits = fits .and. first >= 1 .and. first <= last .and. last <= dims(dimension)
         start = stop_at + 2
         fits = fits .and. (start <= len(subscript) .eqv. dimension < size(dims))
         if (.not. fits) exit
         places = [((places(i) + (colon - 1)*stride, i=1, size(places)), colon=first, last)]
         stride = stride*dims(dimension)
      end do
      if (.not. fits) places = [integer ::]
   end subroutine take_subscript

end module taut_case_assignment
