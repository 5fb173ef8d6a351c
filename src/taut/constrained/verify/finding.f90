!> What a check of a system finds, and when two numbers are the same: one that a system gives, and one that is expected of it.
module taut_constrained_verify_finding
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_value, ieee_quiet_nan
   use taut_kinds, only: wp
   use taut_error, only: to_text
   implicit none (type, external)
   private
   public :: finding_t, check_set, compare, compare_column, elsewhere, entry_name, largest, mark_followers, note, scale_of, &
             size_of, take_nearer, unset

   !> One entry that is wrong.
   type :: finding_t
      !> `A`, `b'`, `b''`, `M`, `phi`, `f`, `g`, `H`, `H^+` (its inverse), or `x`, which `normalize` changes.
      character(len=8) :: what = ''
      !> Row and column, 0 where there is none.
      integer :: row = 0, column = 0
      !> What the system gives, what was expected.
      real(wp) :: given = 0.0_wp, expected = 0.0_wp
      !> Whether it may be no fault of its own, but follow from one that is found before it.
      logical :: follows = .false.
      !> In words.
      character(:), allocatable :: message
   end type finding_t

   !> Length of a name.
   integer, parameter :: name_length = 32

contains

   !> A value that no procedure leaves behind by intention.
   function unset()
      !> Not a number.
      real(wp) :: unset

      unset = ieee_value(unset, ieee_quiet_nan)
   end function unset

   !> Size of the largest entry that is finite.
   pure function largest(values) result(size_of_it)
      !> The numbers, of one unit.
      real(wp), intent(in) :: values(:)
      !> In their unit; 0 if there is none.
      real(wp) :: size_of_it
      integer :: i

      size_of_it = 0.0_wp
      do i = 1, size(values)
         if (ieee_is_finite(values(i))) size_of_it = max(size_of_it, abs(values(i)))
      end do
   end function largest

   !> The size of what is there, or one.
   pure function size_of(values) result(it)
      !> The numbers, of one unit.
      real(wp), intent(in) :: values(:)
      !> In their unit.
      real(wp) :: it

      it = largest(values)
      if (.not. it > 0.0_wp) it = 1.0_wp
   end function size_of

   !> Size of the violation's terms.
   pure function scale_of(b, a, v) result(scale)
      !> A right-hand side: (rows).
      real(wp), intent(in) :: b(:)
      !> Constraint matrix: (rows, n).
      real(wp), intent(in) :: a(:, :)
      !> Velocities: (n).
      real(wp), intent(in) :: v(:)
      !> The largest of b and of the terms of A v.
      real(wp) :: scale
      integer :: i, j

      scale = tiny(1.0_wp)
      do i = 1, size(b)
         if (ieee_is_finite(b(i))) scale = max(scale, abs(b(i)))
         do j = 1, size(v)
            if (ieee_is_finite(a(i, j))) scale = max(scale, abs(a(i, j)*v(j)))
         end do
      end do
   end function scale_of

   !> Takes a difference as what is expected if it is nearer to what is given than those before it.
   elemental subroutine take_nearer(given, trial, expected)
      !> What the system gives.
      real(wp), intent(in) :: given
      !> A difference.
      real(wp), intent(in) :: trial
      !> The nearest so far; replaced by a nearer one.
      real(wp), intent(inout) :: expected

      if (.not. ieee_is_finite(trial)) return
      if (.not. (ieee_is_finite(expected) .and. ieee_is_finite(given))) then
         expected = trial
      else if (abs(trial - given) < abs(expected - given)) then
         expected = trial
      end if
   end subroutine take_nearer

   !> Adds a finding.
   subroutine note(what, row, column, given, expected, message, findings)
      !> As `what` of a finding.
      character(*), intent(in) :: what
      !> Row.
      integer, intent(in) :: row
      !> Column; 0: there is none.
      integer, intent(in) :: column
      !> What the system gives.
      real(wp), intent(in) :: given
      !> What was expected.
      real(wp), intent(in) :: expected
      !> In words.
      character(*), intent(in) :: message
      !> Gets one more.
      type(finding_t), allocatable, intent(inout) :: findings(:)
      type(finding_t) :: finding

      finding%what = what
      finding%row = row
      finding%column = column
      finding%given = given
      finding%expected = expected
      finding%message = message
      findings = [findings, finding]
   end subroutine note

   !> Name of an entry, such as A(2, 3). Its length is fixed: the compiler keeps results of deferred length in static memory, which
   !! threads share.
   pure function entry_name(what, row, column) result(text)
      !> As `what` of a finding.
      character(*), intent(in) :: what
      !> Row.
      integer, intent(in) :: row
      !> Column; 0: there is none.
      integer, intent(in) :: column
      !> With blanks at its end.
      character(len=name_length) :: text

      if (column > 0) then
         write (text, '(2a, i0, a, i0, a)') what, '(', row, ', ', column, ')'
      else
         write (text, '(2a, i0, a)') what, '(', row, ')'
      end if
   end function entry_name

   !> Entries that were never set, or are not finite.
   subroutine check_set(what, values, findings, column)
      !> As `what` of a finding.
      character(*), intent(in) :: what
      !> The entries, by row.
      real(wp), intent(in) :: values(:)
      !> Gets what is found.
      type(finding_t), allocatable, intent(inout) :: findings(:)
      !> Column that they are of. Default: none.
      integer, intent(in), optional :: column
      integer :: i, j

      j = 0
      if (present(column)) j = column
      do i = 1, size(values)
         if (.not. ieee_is_finite(values(i))) &
            call note(what, i, j, values(i), 0.0_wp, trim(entry_name(what, i, j))//' is not set or not finite', findings)
      end do
   end subroutine check_set

   !> One entry against its expected value.
   subroutine compare(what, row, column, given, expected, scale, allowed, findings)
      !> As `what` of a finding.
      character(*), intent(in) :: what
      !> Row.
      integer, intent(in) :: row
      !> Column; 0: there is none.
      integer, intent(in) :: column
      !> What the system gives.
      real(wp), intent(in) :: given
      !> What was expected.
      real(wp), intent(in) :: expected
      !> Size of what is compared.
      real(wp), intent(in) :: scale
      !> Difference that is let pass, relative to it.
      real(wp), intent(in) :: allowed
      !> Gets what is found.
      type(finding_t), allocatable, intent(inout) :: findings(:)

      if (.not. (ieee_is_finite(given) .and. ieee_is_finite(expected))) return
      if (abs(given - expected) <= allowed*max(scale, tiny(scale))) return
      call note(what, row, column, given, expected, trim(entry_name(what, row, column))//' is '//to_text(given)// &
                ' and should be '//to_text(expected)//': off by '//to_text(given - expected), findings)
   end subroutine compare

   !> A column of A; an entry is small or not by its row.
   subroutine compare_column(column, given, expected, rows, allowed, findings)
      !> Its number.
      integer, intent(in) :: column
      !> What the system gives: (rows).
      real(wp), intent(in) :: given(:)
      !> What was expected: (rows).
      real(wp), intent(in) :: expected(:)
      !> All of A: (rows, n).
      real(wp), intent(in) :: rows(:, :)
      !> Difference that is let pass, relative to the largest entry of the row.
      real(wp), intent(in) :: allowed
      !> Gets what is found.
      type(finding_t), allocatable, intent(inout) :: findings(:)
      integer :: i

      do i = 1, size(given)
         call compare('A', i, column, given(i), expected(i), largest(rows(i, :)), allowed, findings)
      end do
   end subroutine compare_column

   !> What may follow from another finding: all but H itself where H is wrong, b'' of rows whose A or b' is wrong.
   subroutine mark_followers(findings)
      !> All of a check.
      type(finding_t), intent(inout) :: findings(:)
      integer :: i

      do i = 1, size(findings)
         select case (findings(i)%what)
         case ('H^+', 'A', "b'")
            findings(i)%follows = any(findings%what == 'H')
         case ("b''")
            findings(i)%follows = any(findings%what == 'H') .or. &
                                  any((findings%what == 'A' .or. findings%what == "b'") .and. findings%row == findings(i)%row)
         end select
      end do
   end subroutine mark_followers

   !> Says of findings that they are of another state.
   subroutine elsewhere(findings)
      !> Those of it.
      type(finding_t), intent(inout) :: findings(:)
      integer :: i

      do i = 1, size(findings)
         findings(i)%message = findings(i)%message//' (at a state near the given one)'
      end do
   end subroutine elsewhere

end module taut_constrained_verify_finding
