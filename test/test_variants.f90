!> Tests of lists of runs: what stands in the blanks of a case file.
module test_variants
   use taut_case_posix, only: make_folder, remove_file
   use taut_case_variants, only: variants_t
   use taut_error, only: error_t
   use test_case, only: check_error, lf
   use testing, only: check, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_variants

   character(*), parameter :: folder = 'build/scratch', case_path = folder//'/variants.nml', list_path = folder//'/variants.tsv'
   character, parameter :: tab = achar(9)

contains

   !> All tests of this module.
   function collect_variants() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [ &
              new_test('a run for each line', lines), &
              new_test('a case without blanks', no_blanks), &
              new_test('lists that do not fit', faulty)]
   end function collect_variants

   !> Writes a case file and a list.
   subroutine write_both(case_text, list)
      character(*), intent(in) :: case_text, list
      integer :: unit

      call make_folder(folder)
      call remove_file(case_path)
      call remove_file(list_path)
      open (newunit=unit, file=case_path, access='stream', form='unformatted', action='write', status='new')
      write (unit) case_text
      close (unit)
      open (newunit=unit, file=list_path, access='stream', form='unformatted', action='write', status='new')
      write (unit) list
      close (unit)
   end subroutine write_both

   subroutine lines(failure)
      character(:), allocatable, intent(inout) :: failure
      type(variants_t) :: variants
      type(error_t), allocatable :: error
      character(:), allocatable :: name, text

      ! What is between two @ and is no number is text; a blank may stand twice; the last line may have no end.
      call write_both('a = @2@, who@here.org = @12@x@1@'//lf//'b="@1@"', &
                      'one'//tab//'1.5'//tab//repeat(tab, 9)//'''t w'''//tab//'9'//lf//lf// &
                      '2'//repeat(tab, 2)//'y'//repeat(tab, 10))
      call variants%load(case_path, list_path, error)
      call no_error(failure, error)
      call variants%next(name, text, error)
      call no_error(failure, error)
      call check(failure, name == 'one', 'the name is '//name)
      call check(failure, text == 'a = , who@here.org = 9x1.5'//lf//'b="1.5"', 'the text is '//text)
      call variants%next(name, text, error)
      call no_error(failure, error)
      call check(failure, name == '2' .and. text == 'a = y, who@here.org = x'//lf//'b=""', 'the text is '//text)
      call variants%next(name, text, error)
      call no_error(failure, error)
      call check(failure, .not. allocated(name), 'there is a run behind the end')
   end subroutine lines

   subroutine no_blanks(failure)
      character(:), allocatable, intent(inout) :: failure
      type(variants_t) :: variants
      type(error_t), allocatable :: error
      character(:), allocatable :: name, text

      call write_both('&a x = 1 / ! @ @0@ @-1@', 'one'//lf//'two'//lf)
      call variants%load(case_path, list_path, error)
      call no_error(failure, error)
      call variants%next(name, text, error)
      call variants%next(name, text, error)
      call no_error(failure, error)
      call check(failure, name == 'two' .and. text == '&a x = 1 / ! @ @0@ @-1@', 'the text is '//text)
      call variants%next(name, text, error)
      call check(failure, .not. allocated(name), 'there is a run behind the end')
   end subroutine no_blanks

   subroutine faulty(failure)
      character(:), allocatable, intent(inout) :: failure
      type(variants_t) :: variants
      type(error_t), allocatable :: error
      character(:), allocatable :: name, text
      character(len=5), parameter :: wrong(2) = ['a'//tab//'1  ', 'a'//tab//'1'//tab//tab]
      integer :: i

      do i = 1, size(wrong)
         call write_both('x = @1@, @2@', 'good'//tab//tab//lf//trim(wrong(i))//lf)
         call variants%load(case_path, list_path, error)
         call no_error(failure, error)
         call variants%next(name, text, error)
         call no_error(failure, error)
         call variants%next(name, text, error)
         call check_error(failure, error, list_path//':2|2 values', 'a line with too few or too many values')
         if (allocated(error)) deallocate (error)
      end do
      call write_both('x', lf//'a'//lf//'b'//lf//'a '//lf)
      call variants%load(case_path, list_path, error)
      do i = 1, 3
         call variants%next(name, text, error)
      end do
      call check_error(failure, error, list_path//':4|"a" is there already, in line 2|another name', 'a name that stands twice')
      if (allocated(error)) deallocate (error)
      call write_both('x', ' '//lf)
      call variants%load(case_path, list_path, error)
      call variants%next(name, text, error)
      call check_error(failure, error, list_path//':1|no name', 'a run without a name')
      if (allocated(error)) deallocate (error)
      call write_both('x', lf)
      call variants%load(case_path, list_path, error)
      call variants%next(name, text, error)
      call check_error(failure, error, list_path//'|no run', 'a list without a run')
      if (allocated(error)) deallocate (error)
      call variants%load(folder//'/none.nml', list_path, error)
      call check_error(failure, error, 'none.nml|read', 'no case file')
      if (allocated(error)) deallocate (error)
      call variants%load(case_path, folder//'/none.tsv', error)
      call check_error(failure, error, 'none.tsv|list of runs', 'no list')
   end subroutine faulty

end module test_variants
