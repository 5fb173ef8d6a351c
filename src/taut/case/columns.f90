!> The columns of a table of results: their names, and their values at a point.
module taut_case_columns
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_constrained_method, only: sample_t
   use taut_constrained_system_tables, only: name_length, tabulated_system_t
   use taut_spelling, only: nearest_name
   implicit none (type, external)
   private
   public :: column_count, column_name, column_value, choose_columns, of_whole_sample, rank_column

   !> What stands between the state and the multipliers.
   character(len=10), parameter :: violations(7) = [character(len=10) :: 'phi', 'phidot', 'phiddot', 'phi_raw', 'phidot_raw', &
                                                    'energy', 'work']

contains

   !> How many columns there are.
   pure integer function column_count(model) result(count)
      !> The system.
      class(tabulated_system_t), intent(in) :: model

      count = rank_column(model) + model%n_outputs
   end function column_count

   !> Which of them is the rank, the only integer.
   pure integer function rank_column(model) result(column)
      !> The system.
      class(tabulated_system_t), intent(in) :: model

      column = 2 + model%n_x + model%n + model%n_w + size(violations) + 2*model%c + 1
   end function rank_column

   !> Whether a column is known only of a state that is evaluated afresh, by `sample`; otherwise `sample_reactions` does.
   pure logical function of_whole_sample(model, i) result(whole)
      !> The system.
      class(tabulated_system_t), intent(in) :: model
      !> The column.
      integer, intent(in) :: i
      integer :: behind_state

      behind_state = i - 2 - model%n_x - model%n - model%n_w
      whole = (behind_state > 0 .and. behind_state <= size(violations) + model%c) .or. i == rank_column(model)
   end function of_whole_sample

   !> Name of a column.
   function column_name(model, i) result(name)
      !> The system.
      class(tabulated_system_t), intent(in) :: model
      !> The column.
      integer, intent(in) :: i
      !> Padded with blanks.
      character(len=name_length) :: name
      integer :: j

      j = i - 2
      if (j < 1) then
         name = merge('t', 'h', i == 1)
         return
      end if
      if (j <= model%n_x) then
         name = model%x_name(j)
         return
      end if
      j = j - model%n_x
      if (j <= model%n) then
         name = model%v_name(j)
         return
      end if
      j = j - model%n
      if (j <= model%n_w) then
         name = 'w'//to_text(j)
         return
      end if
      j = j - model%n_w
      if (j <= size(violations)) then
         name = violations(j)
         return
      end if
      j = j - size(violations)
      if (j <= model%c) then
         name = numbered('mu', j, model%c)
         return
      end if
      j = j - model%c
      if (j <= model%c) then
         name = numbered('lambda', j, model%c)
         return
      end if
      j = j - model%c
      name = 'rank'
      if (j > 1) name = model%output_name(j - 1)
   end function column_name

   !> A name with its number, which is left out if there is only one.
   function numbered(name, i, count) result(text)
      character(*), intent(in) :: name
      integer, intent(in) :: i, count
      character(len=name_length) :: text

      text = name
      if (count > 1) text = name//to_text(i)
   end function numbered

   !> Value of a column.
   pure real(wp) function column_value(i, states, t, h, y, s) result(value)
      !> The column.
      integer, intent(in) :: i
      !> Entries of {x; v; w}.
      integer, intent(in) :: states
      !> Time [s].
      real(wp), intent(in) :: t
      !> The step that ends there or holds it [s].
      real(wp), intent(in) :: h
      !> State {x; v; w}, and behind it what a method adds: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> What there is to know of it besides.
      type(sample_t), intent(in) :: s
      integer :: j

      j = i - 2
      if (j < 1) then
         value = merge(t, h, i == 1)
         return
      end if
      if (j <= states) then
         value = y(j)
         return
      end if
      j = j - states
      select case (j)
      case (1)
         value = s%phi
      case (2)
         value = s%phidot
      case (3)
         value = s%phiddot
      case (4)
         value = s%phi_raw
      case (5)
         value = s%phidot_raw
      case (6)
         value = s%energy
      case (7)
         value = s%work
      case default
         j = j - size(violations)
         associate (c => size(s%lambda))
            if (j <= c) then
               value = s%mu(j)
            else if (j <= 2*c) then
               value = s%lambda(j - c)
            else if (j == 2*c + 1) then
               value = real(s%rank, wp)
            else
               value = s%outputs(j - 2*c - 1)
            end if
         end associate
      end select
   end function column_value

   !> The columns that patterns name, and the time.
   subroutine choose_columns(model, patterns, place, wanted, error)
      !> The system.
      class(tabulated_system_t), intent(in) :: model
      !> Names, with * for any characters; blank ones do not count, and none means all.
      character(*), intent(in) :: patterns(:)
      !> Where they are asked for, as a message begins.
      character(*), intent(in) :: place
      !> Whether a column is one of them: (columns).
      logical, allocatable, intent(out) :: wanted(:)
      !> A column that does not exist.
      type(error_t), allocatable, intent(inout) :: error
      logical :: met(size(patterns))
      character(:), allocatable :: meant
      character(len=name_length), allocatable :: names(:)
      character(len=name_length) :: name
      integer :: i, j

      allocate (wanted(column_count(model)), source=all(patterns == ''))
      wanted(1) = .true.
      ! The angle that a counter belongs to is among the outputs.
      call leave_out_counters(model, wanted)
      if (all(patterns == '')) return
      met = patterns == ''
      do i = 1, size(wanted)
         name = column_name(model, i)
         do j = 1, size(patterns)
            if (patterns(j) == '') cycle
            if (.not. matches(trim(name), trim(patterns(j)))) cycle
            met(j) = .true.
            wanted(i) = .true.
         end do
      end do
      call leave_out_counters(model, wanted)
      do j = 1, size(patterns)
         if (met(j)) cycle
         if (.not. allocated(names)) allocate (names(size(wanted)))
         ! One by one: gfortran 12 does not survive texts of several lengths in a constructor.
         do i = 1, size(wanted)
            names(i) = column_name(model, i)
         end do
         meant = trim(nearest_name(patterns(j), names))
         if (len(meant) > 0) meant = 'did you mean "'//meant//'"? Or '
         call raise(error, place, 'there is no column "'//trim(patterns(j))//'"', &
                    meant//'take names from the first line of a result with all columns; * stands for any characters')
      end do
   end subroutine choose_columns

   !> Coordinates that only count turns are no columns.
   pure subroutine leave_out_counters(model, wanted)
      class(tabulated_system_t), intent(in) :: model
      logical, intent(inout) :: wanted(:)

      wanted(2 + model%n_x - model%n_counters + 1:2 + model%n_x) = .false.
   end subroutine leave_out_counters

   !> Whether a name is what a pattern says, where * stands for any characters, or none. A star that was met takes one character
   !! more where what follows it does not fit; only the last star is tried anew, which is enough.
   pure function matches(name, pattern) result(answer)
      character(*), intent(in) :: name, pattern
      logical :: answer
      integer :: i, j, star, taken

      i = 1
      j = 1
      star = 0
      taken = 0
      do while (i <= len(name))
         if (j <= len(pattern)) then
            if (pattern(j:j) == '*') then
               star = j
               taken = i
               j = j + 1
               cycle
            else if (pattern(j:j) == name(i:i)) then
               i = i + 1
               j = j + 1
               cycle
            end if
         end if
         answer = star > 0
         if (.not. answer) return
         taken = taken + 1
         i = taken
         j = star + 1
      end do
      answer = verify(pattern(j:), '*') == 0
   end function matches

end module taut_case_columns
