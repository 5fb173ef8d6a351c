!> Tests of declared entries: how values are read, what is refused and how, and what the help says of them.
module test_entries
   use testing, only: check, check_below, new_test, no_error, test_t
   use taut_case_namelist_file, only: namelist_file_t
   use test_case, only: check_error, lf, load
   use taut_kinds, only: wp
   use taut_error, only: error_t
   use taut_case_entries, only: entries_t
   use taut_case_group, only: check_groups, declare_group, declared_t, group_data_t, read_group
   use taut_case_help, only: case_help, case_reference
   use taut_spelling, only: nearest_name
   use taut_case_value, only: short_text
   implicit none (type, external)
   private
   public :: collect_entries

   !> A group with an entry of every kind.
   type, extends(group_data_t) :: sample_t
      real(wp) :: mass = 1.5_wp, place(3) = [1.0_wp, 2.0_wp, 3.0_wp], matrix(2, 3) = 0.0_wp
      integer :: copies = 2
      logical :: planar = .false.
      character(len=8) :: shape = 'rod'
      character(:), allocatable :: name
      real(wp), allocatable :: angle, inertia(:)
      integer, allocatable :: modes(:)
      character(len=12), allocatable :: shown(:)
   contains
      procedure :: declare
   end type sample_t

contains

   !> All tests of this module.
   function collect_entries() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [ &
              new_test('defaults stay where the file says nothing', nothing_given), &
              new_test('values of every kind', every_kind), &
              new_test('what Fortran reads as a number or a truth value', forms), &
              new_test('subscripts', subscripts), &
              new_test('values that are refused', refused), &
              new_test('names that may have been meant', meant), &
              new_test('the shortest text of a number', short_numbers), &
              new_test('the help and the page of entries', pages)]
   end function collect_entries

   subroutine declare(self, entries)
      class(sample_t), intent(inout) :: self
      type(entries_t), intent(inout) :: entries

      call entries%group('sample', 'one of every kind')
      call entries%item('mass', self%mass, 'kg', 'its mass', above=0.0_wp)
      call entries%item('place', self%place, 'm', 'where it is', most=1.0e3_wp)
      call entries%item('matrix', self%matrix, '', 'two rows')
      call entries%item('copies', self%copies, 'how many', least=1, most=9)
      call entries%item('planar', self%planar, 'whether it is flat')
      call entries%item('shape', self%shape, 'what it is', [character(len=8) :: 'rod', 'cylinder'])
      call entries%option('name', self%name, 'what it is called')
      call entries%option('angle', self%angle, 'rad', 'how it is turned')
      call entries%option('inertia', self%inertia, 'kg m^2', 'about its axes', [3, 6])
      call entries%option('modes', self%modes, 'numbers of modes', 4, least=1)
      call entries%option('shown', self%shown, 'what is written', 5)
   end subroutine declare

   !> Reads a text that ought to be good.
   subroutine read(failure, text, sample)
      character(:), allocatable, intent(inout) :: failure
      character(*), intent(in) :: text
      type(sample_t), intent(out) :: sample
      type(namelist_file_t) :: file
      type(error_t), allocatable :: error

      call load('&sample '//text//' /', file, error)
      if (.not. allocated(error)) call read_group(file, file%groups(1), sample, error)
      call no_error(failure, error)
   end subroutine read

   !> Fails unless a text is refused with all of some parts, given with bars between them.
   subroutine refuse(failure, text, parts)
      character(:), allocatable, intent(inout) :: failure
      character(*), intent(in) :: text, parts
      type(sample_t) :: sample
      type(namelist_file_t) :: file
      type(error_t), allocatable :: error

      call load(lf//'&sample '//text//' /', file, error)
      call no_error(failure, error)
      if (.not. allocated(error)) call read_group(file, file%groups(1), sample, error)
      call check_error(failure, error, 'case.nml:2: &sample|'//parts, text)
   end subroutine refuse

   subroutine nothing_given(failure)
      character(:), allocatable, intent(inout) :: failure
      type(sample_t) :: sample

      call read(failure, '', sample)
      call check_below(failure, maxval(abs([sample%mass, sample%place] - [1.5_wp, 1.0_wp, 2.0_wp, 3.0_wp])), 0.0_wp, 'numbers')
      call check(failure, sample%copies == 2 .and. .not. sample%planar .and. sample%shape == 'rod', 'others')
      call check(failure, .not. (allocated(sample%name) .or. allocated(sample%angle) .or. allocated(sample%inertia) .or. &
                                 allocated(sample%modes) .or. allocated(sample%shown)), 'something is given')
   end subroutine nothing_given

   subroutine every_kind(failure)
      character(:), allocatable, intent(inout) :: failure
      type(sample_t) :: sample

      call read(failure, 'MASS = 2.5d-1, place = 1 2,'//lf//' 3 ! not 4'//lf//'matrix = 2*1.0, 4*2 copies=3 planar = T,'// &
                ' shape = "cylinder", name = ''it''''s "x"'', angle = -.5, inertia = 3*0.5, modes = 4, 2,'// &
                ' shown = "a b", '''',"c"', sample)
      if (allocated(failure)) return
      call check_below(failure, maxval(abs([sample%mass, sample%place, sample%angle, sample%inertia] - &
                                           [0.25_wp, 1.0_wp, 2.0_wp, 3.0_wp, -0.5_wp, 0.5_wp, 0.5_wp, 0.5_wp])), 0.0_wp, 'numbers')
      call check_below(failure, maxval(abs(reshape(sample%matrix, [6]) - [1, 1, 2, 2, 2, 2])), 0.0_wp, 'a matrix')
      call check(failure, sample%copies == 3 .and. sample%planar .and. sample%shape == 'cylinder', 'an integer, a truth, a text')
      call check(failure, sample%name == 'it''s "x"', 'quotation marks: '//sample%name)
      call check(failure, all(sample%modes == [4, 2]), 'a list of integers')
      call check(failure, size(sample%shown) == 3, 'a list of texts')
      if (allocated(failure)) return
      call check(failure, all(sample%shown == ['a b', '   ', 'c  ']), 'texts of the list')
   end subroutine every_kind

   subroutine forms(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=8), parameter :: numbers(9) = [character(len=8) :: '2', '2.', '+2.0', '.2e1', '20E-1', '2d0', '2.0D+00', &
                                                   '0.2+1', '2q0']
      character(len=8), parameter :: truths(7) = [character(len=8) :: '.true.', 'T', 't', '.T.', 'TRUE', '.True.', '.t']
      type(sample_t) :: sample
      integer :: i

      do i = 1, size(numbers)
         call read(failure, 'mass = '//numbers(i), sample)
         call check_below(failure, sample%mass - 2.0_wp, 0.0_wp, numbers(i))
      end do
      do i = 1, size(truths)
         call read(failure, 'planar = '//truths(i), sample)
         call check(failure, sample%planar, truths(i))
      end do
      call read(failure, 'planar = .FALSE.', sample)
      call check(failure, .not. sample%planar, '.FALSE.')
   end subroutine forms

   subroutine subscripts(failure)
      character(:), allocatable, intent(inout) :: failure
      type(sample_t) :: sample

      call read(failure, 'place(2) = 7, matrix(2, 1) = 8 matrix(:,3) = 4, 5, inertia(2) = 6,'// &
                ' shown(3) = "c" shown( 1:2 ) = "a" "b"', sample)
      if (allocated(failure)) return
      call check_below(failure, maxval(abs(sample%place - [1.0_wp, 7.0_wp, 3.0_wp])), 0.0_wp, 'one of three')
      call check_below(failure, maxval(abs(reshape(sample%matrix, [6]) - [0, 8, 0, 0, 4, 5])), 0.0_wp, 'of a matrix')
      call check_below(failure, maxval(abs(sample%inertia - [0, 6, 0, 0, 0, 0])), 0.0_wp, 'the others are zero')
      call check(failure, all(sample%shown == ['a', 'b', 'c']), 'of a list')
      call read(failure, 'place = 3*0, place(1) = 5', sample)
      call check_below(failure, maxval(abs(sample%place - [5, 0, 0])), 0.0_wp, 'all, then one')
   end subroutine subscripts

   subroutine refused(failure)
      character(:), allocatable, intent(inout) :: failure

      call refuse(failure, 'mas = 1', 'no entry mas;|did you mean mass?|mass, place')
      call refuse(failure, 'mass = "1"', 'mass = "1" cannot be read|right type')
      call refuse(failure, 'mass = 1 kg', 'mass = 1 kg cannot be read|more than one')
      call refuse(failure, 'mass = 1..2', 'mass = 1..2 cannot be read')
      call refuse(failure, 'mass = 0', 'mass = 0 is not positive|in kg|such as 1.5|its mass')
      call refuse(failure, 'mass(1) = 1', 'mass(1) = 1 cannot be read|subscript')
      call refuse(failure, 'mass = 2*', 'mass = 2* cannot be read|left out')
      call refuse(failure, 'mass = 0*1', 'mass = 0*1 cannot be read|no time')
      call refuse(failure, 'place = 1', 'place = 1 cannot be read|takes 3 numbers')
      call refuse(failure, 'place = 1, 2', 'takes 3 numbers')
      call refuse(failure, 'place = ,1.0, 2.0', 'place = ,1.0, 2.0 cannot be read|left out')
      call refuse(failure, 'place = 1.0,,2.0', 'left out')
      call refuse(failure, 'place = 99999999999999999999*1.0', 'takes 3 numbers')
      call refuse(failure, 'place = 2*1, 1e4', 'place = 2*1, 1e4 is more than 1000')
      call refuse(failure, 'place(4) = 1', 'place(4) = 1 cannot be read')
      call refuse(failure, 'place(1:2) = 1', 'as many values as places')
      call refuse(failure, 'matrix(1) = 1', 'matrix(1) = 1 cannot be read')
      call refuse(failure, 'matrix(1,2,1) = 1', 'matrix(1,2,1) = 1 cannot be read')
      call refuse(failure, 'copies = 0', 'copies = 0 is less than 1|1 to 9')
      call refuse(failure, 'copies = 10', 'copies = 10 is more than 9')
      call refuse(failure, 'copies = 1.0', 'copies = 1.0 cannot be read|integer')
      call refuse(failure, 'copies = 99999999999', 'copies = 99999999999 cannot be read')
      call refuse(failure, 'planar = 1', 'planar = 1 cannot be read|.true. or .false.')
      call refuse(failure, 'planar = tomorrow', 'tomorrow')
      call refuse(failure, 'shape = "rodd"', 'shape = "rodd" is unknown|did you mean "rod"?|"cylinder"')
      call refuse(failure, 'shape = "cylinderX"', 'shape = "cylinderX" is unknown')
      call refuse(failure, 'shape = rod', 'shape = rod cannot be read|quotation')
      call refuse(failure, 'shape = "rod" "rod"', 'more than one')
      call refuse(failure, 'shape = "rod"x', 'nothing between them')
      call refuse(failure, 'inertia = 1, 2, 3, 4', 'takes 3 or 6 numbers')
      call refuse(failure, 'modes = 1, 2, 3, 4, 5', 'more than 4 integers')
      call refuse(failure, 'shown = "a name that is too long"', 'longer than 12 characters')
      call refuse(failure, 'name = "joint", mass = -1', '&sample "joint": mass = -1')
   end subroutine refused

   subroutine meant(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=8), parameter :: names(4) = [character(len=8) :: 'mass', 'length', 'angle', '']

      call check(failure, nearest_name('masss', names) == 'mass', 'a letter too many')
      call check(failure, nearest_name('lenght', names) == 'length', 'two letters exchanged')
      call check(failure, nearest_name('ngle', names) == 'angle', 'a letter that is missing')
      call check(failure, nearest_name('x', names) == '', 'far from all')
      call check(failure, nearest_name('velocity', names) == '', 'another word')
   end subroutine meant

   subroutine short_numbers(failure)
      character(:), allocatable, intent(inout) :: failure
      real(wp), parameter :: values(11) = [0.0_wp, 1.0_wp, -9.81_wp, 1.0e-6_wp, 0.1_wp, 0.005_wp, 73.0e9_wp, 100000.0_wp, &
                                           1.0_wp/3.0_wp, -1.0e-300_wp, 1234.5_wp]
      character(len=18), parameter :: texts(11) = [character(len=18) :: '0', '1', '-9.81', '1e-6', '0.1', '0.005', '7.3e10', &
                                                   '100000', '0.3333333333333333', '-1e-300', '1234.5']
      integer :: i

      do i = 1, size(values)
         call check(failure, short_text(values(i)) == texts(i), short_text(values(i))//' is not '//texts(i))
      end do
   end subroutine short_numbers

   subroutine pages(failure)
      character(:), allocatable, intent(inout) :: failure
      type(declared_t), allocatable :: groups(:)
      type(namelist_file_t) :: file
      type(error_t), allocatable :: error
      type(sample_t) :: sample
      character(:), allocatable :: text

      call declare_group(groups, sample)
      text = case_help('app', groups)
      call check(failure, index(text, lf//'&sample  one of every kind'//lf//'  mass     its mass [kg], above 0 (1.5)'//lf) > 0, &
                 text)
      text = case_reference(groups)
      call check(failure, index(text, '| `place` | 3 numbers, 1000 or less | m | 1, 2, 3 | where it is |') > 0, text)
      call check(failure, index(text, '| `shape` | "rod", "cylinder" |  | "rod" | what it is |') > 0, text)
      call load('&sampel /', file, error)
      call check_groups(file, groups, error)
      call check_error(failure, error, '&sampel|did you mean &sample?', 'a misspelt group')
   end subroutine pages

end module test_entries
