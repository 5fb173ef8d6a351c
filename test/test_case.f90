!> Tests of case files, how they are cut and what is complained about; and of the files of results.
module test_case
   use testing, only: check, check_below, new_test, no_error, test_t
   use taut_kinds, only: wp
   use taut_error, only: error_t, to_text
   use taut_case_csv, only: csv_t
   use taut_case_namelist_file, only: namelist_file_t
   use taut_case_posix, only: make_folder, move_file, remove_file
   use taut_case_process, only: process_id
   implicit none (type, external)
   private
   public :: collect_case, load, check_error, lf

   character, parameter :: lf = achar(10), cr = achar(13), tab = achar(9)

contains

   !> All tests of this module.
   function collect_case() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [ &
              new_test('groups, entries and their lines', groups_and_entries), &
              new_test('signs inside quotation marks', quotation), &
              new_test('arrays and subscripts', arrays), &
              new_test('line ends and blanks of other systems', line_ends), &
              new_test('the name of a case', case_names), &
              new_test('text that is no case file', faulty_text), &
              new_test('a file that cannot be read', faulty_file), &
              new_test('groups that are not known', unknown_groups), &
              new_test('a file of results appears when it is finished', csv_finish), &
              new_test('a file of results is discarded', csv_discard), &
              new_test('a file of results that cannot be written', csv_fails)]
   end function collect_case

   !> Path of a scratch file that no other run uses.
   function scratch(name) result(path)
      character(*), intent(in) :: name
      character(:), allocatable :: path

      path = 'build/scratch'
      call make_folder(path)
      path = path//'/'//to_text(process_id())//'_'//name
   end function scratch

   !> Writes a text as it is, without a line end of its own.
   subroutine write_text(path, text)
      character(*), intent(in) :: path, text
      integer :: unit

      open (newunit=unit, file=path, access='stream', form='unformatted', action='write', status='replace')
      write (unit) text
      close (unit)
   end subroutine write_text

   !> All of a file; 'no such file' if there is none.
   function read_text(path) result(text)
      character(*), intent(in) :: path
      character(:), allocatable :: text
      logical :: exists
      integer :: length, unit

      text = 'no such file'
      inquire (file=path, exist=exists)
      if (.not. exists) return
      open (newunit=unit, file=path, access='stream', form='unformatted', action='read', status='old')
      inquire (unit=unit, size=length)
      deallocate (text)
      allocate (character(len=length) :: text)
      read (unit) text
      close (unit)
   end function read_text

   !> Loads a text through a file.
   subroutine load(text, file, error)
      character(*), intent(in) :: text
      type(namelist_file_t), intent(out) :: file
      type(error_t), allocatable, intent(inout) :: error
      character(:), allocatable :: path

      path = scratch('case.nml')
      call write_text(path, text)
      call file%load(path, error)
      call remove_file(path)
   end subroutine load

   !> Fails unless group g has the entry e with a name, a value and a line.
   subroutine check_entry(failure, file, g, e, name, value, line)
      character(:), allocatable, intent(inout) :: failure
      type(namelist_file_t), intent(in) :: file
      integer, intent(in) :: g, e, line
      character(*), intent(in) :: name, value

      if (allocated(failure)) return
      call check(failure, size(file%groups) >= g, 'there are '//to_text(size(file%groups))//' groups, wanted '//to_text(g))
      if (allocated(failure)) return
      associate (group => file%groups(g))
         call check(failure, size(group%entries) >= e, '&'//group%name//' has '//to_text(size(group%entries))//' entries')
         if (allocated(failure)) return
         associate (item => group%entries(e))
            call check(failure, item%name == name, 'entry '//item%name//' is not '//name)
            call check(failure, item%text == '&'//group%name//' '//name//' = '//value//' /', 'unexpected text '//item%text)
            call check(failure, item%line == line, name//' is in line '//to_text(item%line)//', not '//to_text(line))
         end associate
      end associate
   end subroutine check_entry

   subroutine groups_and_entries(failure)
      character(:), allocatable, intent(inout) :: failure
      type(namelist_file_t) :: file
      type(error_t), allocatable :: error

      call load('! A comment with / and & and "'//lf//lf//'&Pendulum'//lf//'  MASS = 2.5   ! [kg], don''t'//lf// &
                '  length=1.0, gravity = 9.81 velocity = 1, 2'//lf//'/'//lf//'&empty /'//lf// &
                '&method name = "present" / &method name = "baseline" / ! two in a line'//lf, file, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      call check(failure, size(file%groups) == 4, 'there are '//to_text(size(file%groups))//' groups')
      if (allocated(failure)) return
      call check(failure, file%groups(1)%name == 'pendulum' .and. file%groups(2)%name == 'empty' .and. &
                 file%groups(3)%name == 'method' .and. file%groups(4)%name == 'method', 'names of the groups')
      call check(failure, all(file%groups%line == [3, 7, 8, 8]), 'lines of the groups')
      call check(failure, size(file%groups(1)%entries) == 4 .and. size(file%groups(2)%entries) == 0 .and. &
                 size(file%groups(4)%entries) == 1, 'numbers of entries')
      call check_entry(failure, file, 1, 1, 'mass', '2.5', 4)
      call check_entry(failure, file, 1, 4, 'velocity', '1, 2', 5)
      call check_entry(failure, file, 3, 1, 'name', '"present"', 8)
      call check_entry(failure, file, 4, 1, 'name', '"baseline"', 8)
      call load('', file, error)
      call no_error(failure, error)
      call check(failure, size(file%groups) == 0, 'an empty file has groups')
      call load('! nothing but a comment', file, error)
      call no_error(failure, error)
      call check(failure, size(file%groups) == 0, 'a comment has groups')
   end subroutine groups_and_entries

   subroutine quotation(failure)
      character(:), allocatable, intent(inout) :: failure
      type(namelist_file_t) :: file
      type(error_t), allocatable :: error
      character(len=32) :: label
      integer :: status
      namelist /method/ label

      call load('&method label = "a/b = !&c", name = ''it"s'' /', file, error)
      call no_error(failure, error)
      call check_entry(failure, file, 1, 1, 'label', '"a/b = !&c",', 1)
      call check_entry(failure, file, 1, 2, 'name', '''it"s''', 1)
      if (allocated(failure)) return
      read (file%groups(1)%entries(1)%text, nml=method, iostat=status)
      call check(failure, status == 0 .and. label == 'a/b = !&c', 'the value is read as '//trim(label))
      call load('&method label = ''don''''t / stop'' /', file, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      read (file%groups(1)%entries(1)%text, nml=method, iostat=status)
      call check(failure, status == 0 .and. label == 'don''t / stop', 'a doubled apostrophe is read as '//trim(label))
   end subroutine quotation

   subroutine arrays(failure)
      character(:), allocatable, intent(inout) :: failure
      type(namelist_file_t) :: file
      type(error_t), allocatable :: error
      real(wp) :: x(4), m(2, 2)
      integer :: i, status
      namelist /g/ x, m

      call load('&g'//lf//' x ='//lf//'  1.0, ! first'//lf//'  2.0,'//lf//'  2*3.0'//lf//' m(1, 2) = 5.0 M( 2 ,1)=6.0'//lf// &
                ' m(2, 2)'//lf//'   = 7.0 /', file, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      call check(failure, size(file%groups(1)%entries) == 4, 'there are '//to_text(size(file%groups(1)%entries))//' entries')
      call check(failure, all(file%groups(1)%entries%line == [2, 6, 6, 7]), 'lines of the entries')
      x(:) = 0.0_wp
      m(:, :) = 1.0_wp
      do i = 1, size(file%groups(1)%entries)
         read (file%groups(1)%entries(i)%text, nml=g, iostat=status)
         call check(failure, status == 0, 'not read: '//file%groups(1)%entries(i)%text)
      end do
      call check_below(failure, maxval(abs(x - [1.0_wp, 2.0_wp, 3.0_wp, 3.0_wp])), 0.0_wp, 'an array over lines')
      call check_below(failure, maxval(abs(m - reshape([1.0_wp, 6.0_wp, 5.0_wp, 7.0_wp], [2, 2]))), 0.0_wp, 'single entries')
   end subroutine arrays

   subroutine line_ends(failure)
      character(:), allocatable, intent(inout) :: failure
      type(namelist_file_t) :: file
      type(error_t), allocatable :: error

      call load('! comment'//cr//lf//'&a'//cr//lf//tab//'x'//tab//'='//tab//'1.0'//cr//lf//'y = "text"'//cr//lf//'/'//cr//lf, &
                file, error)
      call no_error(failure, error)
      call check_entry(failure, file, 1, 1, 'x', '1.0', 3)
      call check_entry(failure, file, 1, 2, 'y', '"text"', 4)
      call load('&a x = 1.0 /', file, error)
      call no_error(failure, error)
      call check_entry(failure, file, 1, 1, 'x', '1.0', 1)
      ! The mark with which some programs begin a file.
      call load(char(239)//char(187)//char(191)//'&a x = 1.0 /', file, error)
      call no_error(failure, error)
      call check_entry(failure, file, 1, 1, 'x', '1.0', 1)
      call load('&a x = 1.0'//lf//'/ ! no line end after the last line', file, error)
      call no_error(failure, error)
      call check_entry(failure, file, 1, 1, 'x', '1.0', 1)
   end subroutine line_ends

   subroutine case_names(failure)
      character(:), allocatable, intent(inout) :: failure
      type(namelist_file_t) :: file
      type(error_t), allocatable :: error
      character(:), allocatable :: path

      path = scratch('a.b.nml')
      call write_text(path, '')
      call file%load(path, error)
      call check(failure, file%path == path, 'the path is not as given')
      call check(failure, file%name == to_text(process_id())//'_a.b', 'the name of the case is '//file%name)
      call remove_file(path)
      path = scratch('plain')
      call write_text(path, '')
      call file%load(path, error)
      call check(failure, file%name == to_text(process_id())//'_plain', 'the name without ending is '//file%name)
      call remove_file(path)
      call no_error(failure, error)
   end subroutine case_names

   !> Fails unless there is an error with a remedy and with all of some parts, given with bars between them.
   subroutine check_error(failure, error, parts, label)
      character(:), allocatable, intent(inout) :: failure
      type(error_t), allocatable, intent(in) :: error
      character(*), intent(in) :: parts, label
      integer :: first, last

      call check(failure, allocated(error), label//' gives no error')
      if (.not. allocated(error)) return
      call check(failure, len(error%remedy) > 0, label//' gives no remedy: '//error%line())
      call check(failure, index(error%line(), lf) == 0, label//' gives more than a line')
      first = 1
      do while (first <= len(parts))
         last = index(parts(first:), '|') + first - 2
         if (last < first) last = len(parts)
         call check(failure, index(error%line(), parts(first:last)) > 0, label//' does not name '//parts(first:last)//': '// &
                    error%line())
         first = last + 2
      end do
   end subroutine check_error

   subroutine faulty_text(failure)
      character(:), allocatable, intent(inout) :: failure

      call fault(lf//'&a x = 1', 'case.nml:2:|&a|no end', 'a missing /')
      call fault('&a x = 1'//lf//'&b y = 2 /', 'case.nml:1:|&a|no end', 'a missing / before the next group')
      call fault('&a x = "1 /', 'case.nml:1:|&a|quotation', 'an open quotation mark')
      call fault('&a x = 1 /'//lf//lf//'stray', 'case.nml:3:|"stray"', 'text after a group')
      call fault('stray'//lf//'&a x = 1 /', 'case.nml:1:|"stray"', 'text before a group')
      call fault('&a x = 1 / /', 'case.nml:1:|"/"', 'one / too many')
      call fault('&a'//lf//'x = 1'//lf//'X = 2 /', 'case.nml:3:|&a|x is given twice|line 2', 'a duplicate entry')
      call fault('&a'//lf//'x(1) = 1, x(1) = 2 /', 'case.nml:2:|&a|x(1) is given twice', 'a duplicate subscript')
      call fault('&a'//lf//'x = , y = 1 /', 'case.nml:2:|&a|x has no value', 'a comma for a value')
      call fault('&a'//lf//'x = y = 1 /', 'case.nml:2:|&a|x has no value', 'an entry without value')
      call fault('&a'//lf//'x = /', 'case.nml:2:|&a|x has no value', 'a last entry without value')
      call fault('&a'//lf//' = 1 /', 'case.nml:2:|&a|without a name', 'a value without name')
      call fault('&a'//lf//'x 1 /', 'case.nml:2:|&a|"x"', 'an entry without =')
      call fault('&a'//lf//'1.5, x = 1 /', 'case.nml:2:|&a|"1.5,"', 'a value before the first name')

   contains

      subroutine fault(text, parts, label)
         character(*), intent(in) :: text, parts, label
         type(namelist_file_t) :: file
         type(error_t), allocatable :: error

         call load(text, file, error)
         call check_error(failure, error, parts, label)
      end subroutine fault

   end subroutine faulty_text

   subroutine faulty_file(failure)
      character(:), allocatable, intent(inout) :: failure
      type(namelist_file_t) :: file
      type(error_t), allocatable :: error

      call file%load('build/scratch/there_is_no_such.nml', error)
      call check_error(failure, error, 'build/scratch/there_is_no_such.nml:|no such case file', 'a missing file')
      if (allocated(error)) deallocate (error)
      call make_folder('build/scratch')
      call file%load('build/scratch', error)
      call check_error(failure, error, 'build/scratch:|folder', 'a folder')
      if (allocated(error)) deallocate (error)
      call file%load('/dev/zero', error)
      call check_error(failure, error, '/dev/zero:|cannot be read', 'a device without an end')
   end subroutine faulty_file

   subroutine unknown_groups(failure)
      character(:), allocatable, intent(inout) :: failure
      type(namelist_file_t) :: file
      type(error_t), allocatable :: error

      call load('&b /'//lf//'&c x = 1 /', file, error)
      call file%only_groups(['a ', 'b ', 'cd'], error)
      call check_error(failure, error, 'case.nml:2:|&c|&a, &b, &cd', 'an unknown group')
      if (allocated(error)) deallocate (error)
      call file%only_groups(['a', 'b', 'c'], error)
      call no_error(failure, error)
   end subroutine unknown_groups

   !> The name under which a file is written first.
   function temporary(path) result(part)
      character(*), intent(in) :: path
      character(:), allocatable :: part

      part = path//'.'//to_text(process_id())//'.part'
   end function temporary

   subroutine csv_finish(failure)
      character(:), allocatable, intent(inout) :: failure
      type(csv_t) :: csv
      type(error_t), allocatable :: error
      character(:), allocatable :: path

      path = scratch('finish.csv')
      call write_text(path, 'older')
      call csv%create(path, error)
      call csv%put('t,x', error)
      call csv%put('1,2', error)
      call check(failure, read_text(path) == 'older', 'the older file is touched before the new one is complete')
      call csv%finish(error)
      call no_error(failure, error)
      call check(failure, read_text(path) == 't,x'//lf//'1,2'//lf, 'the finished file holds '//read_text(path))
      call check(failure, read_text(temporary(path)) == 'no such file', 'the temporary file is left')
      ! Finished is finished: neither of these may harm the file.
      call csv%finish(error)
      call csv%discard()
      call no_error(failure, error)
      call check(failure, read_text(path) == 't,x'//lf//'1,2'//lf, 'a finished file was changed')
      call csv%create(path, error)
      call csv%put('shorter', error)
      call csv%finish(error)
      call check(failure, read_text(path) == 'shorter'//lf, 'the second file holds '//read_text(path))
      call remove_file(path)
   end subroutine csv_finish

   subroutine csv_discard(failure)
      character(:), allocatable, intent(inout) :: failure
      type(csv_t) :: csv
      type(error_t), allocatable :: error
      character(:), allocatable :: path

      path = scratch('discard.csv')
      call csv%create(path, error)
      call csv%put('t,x', error)
      call csv%discard()
      call no_error(failure, error)
      call check(failure, read_text(path) == 'no such file', 'a discarded file appears')
      call check(failure, read_text(temporary(path)) == 'no such file', 'the temporary file is left')
      call write_text(path, 'older')
      call csv%create(path, error)
      call csv%discard()
      call check(failure, read_text(path) == 'older', 'an older file went with the discarded one')
      call remove_file(path)
   end subroutine csv_discard

   subroutine csv_fails(failure)
      character(:), allocatable, intent(inout) :: failure
      type(csv_t) :: csv
      type(error_t), allocatable :: error
      character(:), allocatable :: path
      logical :: done

      path = scratch('no_such_folder')//'/x.csv'
      call csv%create(path, error)
      call check_error(failure, error, path//'|--out', 'a missing folder')
      if (allocated(error)) deallocate (error)
      call csv%discard()
      ! Something else has the final name: a folder.
      path = 'build/scratch/taken.csv'
      call make_folder(path)
      call csv%create(path, error)
      call csv%put('t,x', error)
      call csv%finish(error)
      call check_error(failure, error, path//'|place', 'a folder in the place of the file')
      call check(failure, read_text(temporary(path)) == 'no such file', 'the temporary file is left')
      call move_file(scratch('nothing'), path, done)
      call check(failure, .not. done, 'what is not there was moved')
   end subroutine csv_fails

end module test_case
