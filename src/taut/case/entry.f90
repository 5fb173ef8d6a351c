!> One entry of a case file's group as it is declared: what its values are and what is said of it.
module taut_case_entry
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_kinds, only: wp
   use taut_error, only: to_text
   use taut_case_value, only: short_text
   implicit none (type, external)
   private
   public :: entry_t, range_t, real_range, choice_list, joined

   !> What an entry is.
   type :: entry_t
      !> Name in lower case.
      character(:), allocatable :: name
      !> What a value is: `number`, `integer`, `.true. or .false.`, `text`, or the texts that may be chosen.
      character(:), allocatable :: kind
      !> Unit of a value; empty for none.
      character(:), allocatable :: unit
      !> How many values there are, such as `3` or `3 or 6`; empty for one.
      character(:), allocatable :: number
      !> Which numbers are valid; empty for all that are finite.
      character(:), allocatable :: range
      !> What holds if it is left out; empty if nothing does.
      character(:), allocatable :: default
      !> What it is, in a line.
      character(:), allocatable :: help
   end type entry_t

   !> Numbers that an entry may have.
   type :: range_t
      !> Bounds, which belong to it.
      real(wp) :: least = -huge(1.0_wp), most = huge(1.0_wp)
      !> Whether the lower bound does not.
      logical :: open = .false.
   contains
      procedure :: has
      procedure :: described
      procedure :: complaint
   end type range_t

contains

   !> A range from what is given of it.
   pure function real_range(above, least, most) result(range)
      !> Lower bound that does not belong to it.
      real(wp), intent(in), optional :: above
      !> Lower bound that belongs to it.
      real(wp), intent(in), optional :: least
      !> Upper bound that belongs to it.
      real(wp), intent(in), optional :: most
      !> The range.
      type(range_t) :: range

      if (present(least)) range%least = least
      if (present(most)) range%most = most
      if (.not. present(above)) return
      range%least = above
      range%open = .true.
   end function real_range

   !> Whether a number is valid.
   pure logical function has(self, value)
      !> The range.
      class(range_t), intent(in) :: self
      !> The number; those that are not finite are in no range.
      real(wp), intent(in) :: value

      has = ieee_is_finite(value)
      if (has) has = value >= self%least .and. value <= self%most
      if (has .and. self%open) has = value > self%least
   end function has

   !> The range in words, such as `above 0` or `0 to 1`; empty for all numbers.
   pure function described(self) result(text)
      !> The range.
      class(range_t), intent(in) :: self
      !> A few words; empty for all numbers.
      character(:), allocatable :: text
      logical :: bounded(2)

      bounded = [self%least > -huge(1.0_wp), self%most < huge(1.0_wp)]
      text = ''
      if (bounded(1) .and. self%open) then
         text = 'above '//short_text(self%least)
         if (bounded(2)) text = text//', '//short_text(self%most)//' or less'
      else if (all(bounded)) then
         text = short_text(self%least)//' to '//short_text(self%most)
      else if (bounded(1)) then
         text = short_text(self%least)//' or more'
      else if (bounded(2)) then
         text = short_text(self%most)//' or less'
      end if
   end function described

   !> What is wrong with a number that is not in the range.
   pure function complaint(self, value) result(text)
      !> The range.
      class(range_t), intent(in) :: self
      !> The number.
      real(wp), intent(in) :: value
      !> What follows the number in a sentence.
      character(:), allocatable :: text

      if (.not. ieee_is_finite(value)) then
         text = 'is not a finite number'
      else if (value > self%most) then
         text = 'is more than '//short_text(self%most)
      else if (self%open .and. abs(self%least) <= 0.0_wp) then
         text = 'is not positive'
      else if (abs(self%least) <= 0.0_wp) then
         text = 'is negative'
      else if (self%open) then
         text = 'is not above '//short_text(self%least)
      else
         text = 'is less than '//short_text(self%least)
      end if
   end function complaint

   !> Texts in quotation marks, with commas between them.
   pure function choice_list(choices) result(text)
      !> The texts; blank ones do not count.
      character(*), intent(in) :: choices(:)
      !> In quotation marks, with commas between.
      character(:), allocatable :: text
      integer :: i

      text = ''
      do i = 1, size(choices)
         if (len_trim(choices(i)) == 0) cycle
         if (len(text) > 0) text = text//', '
         text = text//'"'//trim(choices(i))//'"'
      end do
   end function choice_list

   !> Numbers as `3`, `1, 3 or 6` or `1 to 20`.
   pure function joined(numbers) result(text)
      !> At least one, in rising order.
      integer, intent(in) :: numbers(:)
      !> With commas between.
      character(:), allocatable :: text
      integer :: i

      text = to_text(numbers(1))
      if (size(numbers) > 3 .and. all(numbers == [(numbers(1) + i, i=0, size(numbers) - 1)])) then
         text = text//' to '//to_text(numbers(size(numbers)))
         return
      end if
      do i = 2, size(numbers)
         if (i == size(numbers)) then
            text = text//' or '//to_text(numbers(i))
         else
            text = text//', '//to_text(numbers(i))
         end if
      end do
   end function joined

end module taut_case_entry
