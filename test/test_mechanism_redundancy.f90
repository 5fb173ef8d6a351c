!> Mechanisms whose joints prevent the same motion more than once: what is told of them, and how they move.
module test_mechanism_redundancy
   use taut, only: error_t, mechanism_t, simulate, state_t, status_reached_end, wp
   use taut_case_mechanism, only: read_mechanism
   use taut_case_namelist_file, only: namelist_file_t
   use taut_constrained_system_tables, only: quantity_t
   use taut_error, only: to_text
   use test_case, only: lf, load
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   use mechanism_runs, only: run_file, run_t, run_text, violation
   implicit none (type, external)
   private
   public :: collect_mechanism_redundancy

contains

   !> All tests of this module.
   function collect_mechanism_redundancy() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('Bricard names its redundancy', bricard), &
               new_test('Bricard by the implicit integrator', implicit_bricard), &
               new_test('what is prevented twice, and which reactions are unique', words_of_redundancy), &
               new_test('ten mechanisms with redundant joints', random_mechanisms)]
   end function collect_mechanism_redundancy

   subroutine bricard(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=11), parameter :: names(2) = [character(len=11) :: 'bricard', 'bricard_box']
      type(run_t) :: run
      integer :: i

      do i = 1, 2
         call run_file(trim(names(i)), 1.0_wp, 1.0e-7_wp, run, failure)
         if (allocated(failure)) return
         call check_bricard(run, failure)
      end do
      ! m (0.1^2 + 0.1^2)/12 about the axis, m (1 + 0.1^2)/12 across.
      call check_close(failure, run%model%bodies(3)%j(1, 1), 0.02_wp/12.0_wp, 1.0e-15_wp, 'inertia about the axis of a rod')
      call check_close(failure, run%model%bodies(3)%j(2, 2), 1.01_wp/12.0_wp, 1.0e-15_wp, 'inertia across')
   end subroutine bricard

   subroutine check_bricard(run, failure)
      type(run_t), intent(in) :: run
      character(:), allocatable, intent(inout) :: failure
      character(:), allocatable :: text

      call check(failure, run%model%c == 30 .and. run%report%rank == 29 .and. run%report%freedoms == 1, &
                 'rank '//to_text(run%report%rank)//' of '//to_text(run%model%c))
      call check(failure, sum(run%report%redundant) == 1 .and. all(run%report%involved), &
               'the loop has one redundancy, of all joints')
      call check(failure, index(run%report%text, '1 redundant') > 0, run%report%text)
      call check(failure, index(run%report%text, &
                                'J1, J2, J3, J4, J5, J6: one shift along (0.577, 0.577, 0.577) is prevented twice') > 0, &
                 run%report%text)
      call check_below(failure, run%model%energy(run%at) - run%model%energy(run%start), 1.0e-4_wp, 'energy')
      call check_below(failure, violation(run), 1.0e-10_wp, 'violation')
      call run%model%note(text)
      call check(failure, index(text, '6 joints are not unique') > 0, 'the summary warns: '//text)
      call check(failure, index(text, ',') == 0, 'no comma in a table')
      call run%model%describe(text)
      call check(failure, text == run%report%text, 'people are told the same')
   end subroutine check_bricard

   !> Multipliers of the redundant row, and those that stabilize, must not go astray: steps would be ten times as short.
   subroutine implicit_bricard(failure)
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: run
      type(state_t) :: expected
      type(error_t), allocatable :: error

      call run_file('bricard', 1.0_wp, 1.0e-9_wp, run, failure)
      if (allocated(failure)) return
      expected = run%at
      run%at = run%start
      run%settings%options%integrator = 'radau'
      run%settings%options%rtol = 1.0e-7_wp
      run%settings%options%atol = 1.0e-7_wp
      call simulate(run%model, run%at, 1.0_wp, run%result, error, run%settings%methods(1)%method, run%settings%options)
      call no_error(failure, error)
      call check(failure, run%result%status == status_reached_end, 'it does not get to the end')
      call check_below(failure, maxval(abs(run%at%x - expected%x)), 1.0e-5_wp, 'coordinates')
      call check(failure, run%result%steps + run%result%rejected < 400, to_text(run%result%steps)//' steps')
   end subroutine implicit_bricard

   !> Closed forms: what circulates in a loop of joints is what all of them can transmit.
   subroutine words_of_redundancy(failure)
      character(:), allocatable, intent(inout) :: failure
      character(*), parameter :: gravity = '&gravity acceleration = 0, 0, -9.81 /'//lf
      character(*), parameter :: rod = '", shape = "rod", thickness = 0.1, mass = 1, from = '
      character(*), parameter :: door = gravity//'&body name = "door'//rod//'0,0,0, to = 1,0,1 /'//lf
      character(*), parameter :: hinge = '", type = "revolute", body_2 = "door", axis = 0,0,1, point = '
      character(*), parameter :: low_high = '&joint name = "low'//hinge//'0,0,0 /'//lf// &
                                            '&joint name = "high'//hinge//'0,0,1 /'//lf

      call expect(door//low_high, 5, &
                  'low, high: two rotations across the parallel axes (0, 0, 1) and three shifts are prevented twice', &
                  'force along, force across, moment across of low, high')
      call expect(door//low_high//'&joint name = "mid'//hinge//'0,0,0.4 /'//lf, 5, &
                  'low, high, mid: four rotations across the parallel axes (0, 0, 1) and six shifts are prevented more than once', &
                  'force along, force across, moment across of low, high, mid')
      call expect(door//'&joint name = "one", type = "fixed", body_2 = "door", point = 0,0,0 /'//lf// &
                  '&joint name = "two", type = "fixed", body_2 = "door", point = 1,0,1 /'//lf, 6, &
                  'one, two: three rotations and three shifts are prevented twice', 'of one, two')
      call expect(gravity//'&body name = "crank'//rod//'0,0,0, to = 0.3,0,1 /'//lf// &
                  '&body name = "coupler'//rod//'0.3,0,1, to = 2.2,0,1.2 /'//lf// &
                  '&body name = "rocker'//rod//'2,0,0, to = 2.2,0,1.2 /'//lf// &
                  pin('A', 'ground', 'crank', '0,0,0')//pin('B', 'crank', 'coupler', '0.3,0,1')// &
                  pin('C', 'coupler', 'rocker', '2.2,0,1.2')//pin('D', 'ground', 'rocker', '2,0,0'), 17, &
                  'A, B, C, D: two rotations across the parallel axes (0, 1, 0) and one shift along them are prevented twice', &
                  'force along, moment across of A, B, C, D; unique: force across')
      call expect('&gravity /'//lf//'&body name = "set", shape = "cylinder", radius = 0.05, mass = 2, from = 0,-0.7,0.5, '// &
                  'to = 0,0.7,0.5, velocity = 1,0,0, angular_velocity = 0,2,0 /'//lf//disc('left', '0,0.7,0.5')// &
                  disc('right', '0,-0.7,0.5'), 5, &
                  'left, right: one shift along the parallel axes (0, 1, 0) is prevented twice', &
                  'force along, moment across of left, right; unique: force across, moment along')
      ! What passes through the universal joint's point makes no moment there; what its cross carries turns the second shaft.
      call expect(shaft('in', '-0.5,0,0', '0,0,0')//shaft('out', '0,0,0', '0.4330127018922193,0.25,0')// &
                  '&joint name = "hooke", type = "universal", body_1 = "in", body_2 = "out", point = 0,0,0, axis_1 = 0,0,1, '// &
                  'axis_2 = -0.5,0.8660254037844386,0 /'//lf// &
                  '&joint name = "first", type = "revolute", body_2 = "in", point = -0.5,0,0, axis = 1,0,0 /'//lf// &
                  '&joint name = "second", type = "revolute", body_2 = "out", point = 0.4330127018922193,0.25,0, '// &
                  'axis = 0.8660254037844386,0.5,0 /'//lf, 11, &
                  'hooke, first, second: three shifts are prevented twice', &
                  'force along, force across of hooke; unique: moment across')
      call expect('&gravity /'//lf//'&body name = "rod'//rod//'0,0,0, to = 1,0,0 /'//lf//pin('hinge', 'ground', 'rod', '0,0,0')// &
                  '&point_mass name = "road", mass = 1, position = 0,2,0 /'//lf// &
                  '&joint name = "slide", type = "prismatic", body_2 = "road", point = 0,2,0, axis = 1,0,0 /'//lf, 7, &
                  '3 of slide'//lf// &
                  'slide: three rotations are asked of road, which is a point mass and has none: they are ignored', &
                  'of freedom')

   contains

      function shaft(name, from, to) result(text)
         character(*), intent(in) :: name, from, to
         character(:), allocatable :: text

         text = '&body name = "'//name//'", shape = "cylinder", radius = 0.05, mass = 1, from = '//from//', to = '//to//' /'//lf
      end function shaft

      function disc(name, center) result(text)
         character(*), intent(in) :: name, center
         character(:), allocatable :: text

         text = '&rolling name = "'//name//'", body = "set", radius = 0.5, axis = 0,1,0, center = '//center//' /'//lf
      end function disc

      function pin(name, one, two, point) result(text)
         character(*), intent(in) :: name, one, two, point
         character(:), allocatable :: text

         text = '&joint name = "'//name//'", type = "revolute", body_1 = "'//one//'", body_2 = "'//two// &
                '", axis = 0,1,0, point = '//point//' /'//lf
      end function pin

      subroutine expect(text, rank, redundancy, reactions)
         character(*), intent(in) :: text, redundancy, reactions
         integer, intent(in) :: rank
         type(namelist_file_t) :: file
         type(run_t) :: run
         type(error_t), allocatable :: error

         if (allocated(failure)) return
         call load(text//'&integration t_end = 0.1 /'//lf//'&output dt = 0.1 /'//lf, file, error)
         call no_error(failure, error)
         if (allocated(failure)) return
         call read_mechanism(file, run%model, run%start, run%settings, run%report, error)
         call no_error(failure, error)
         if (allocated(failure)) return
         call check(failure, run%report%rank == rank, 'rank '//to_text(run%report%rank))
         call check(failure, index(run%report%text, redundancy) > 0, run%report%text)
         call check(failure, index(run%report%text, reactions) > 0, run%report%text)
         call compare_table(run%model, reactions)
      end subroutine expect

      !> The table of the model says the same of the first joint as the words.
      subroutine compare_table(model, reactions)
         type(mechanism_t), intent(in) :: model
         character(*), intent(in) :: reactions
         type(quantity_t), allocatable :: list(:)
         character(len=6), parameter :: what(2) = ['force ', 'moment']
         character(len=6), parameter :: where(2) = ['along ', 'across']
         integer :: i, j, k
         logical :: unique

         list = model%quantities()
         if (index(reactions, '; unique: ') == 0) return
         do i = 1, 2
            do j = 1, 2
               unique = index(reactions(index(reactions, '; unique: '):), trim(what(i))//' '//trim(where(j))) > 0
               do k = 1, size(list)
                  if (list(k)%name == 'unique:'//trim(model%joints(1)%name)//'.'//trim(what(i))//'_'//trim(where(j))) exit
               end do
               if (k > size(list)) then
                  call check(failure, .not. unique, 'not in the table: '//what(i)//' '//where(j))
               else
                  call check(failure, (list(k)%value > 0.5_wp) .eqv. unique, 'the table of '//list(k)%name)
               end if
            end do
         end do
      end subroutine compare_table

   end subroutine words_of_redundancy

   !> Trees of bodies with each joint stated twice, and once more as another type: they run, hold and stay numbers.
   subroutine random_mechanisms(failure)
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: run
      character(:), allocatable :: text
      character(len=11), parameter :: types(6) = [character(len=11) :: 'spherical', 'revolute', 'universal', 'cylindrical', &
                                                  'prismatic', 'in-line']
      real(wp) :: place(3)
      integer :: b, case, seed

      seed = 4711
      do case = 1, 10
         text = '&gravity /'//lf
         place = 0.0_wp
         do b = 1, 3
            text = text//'&body name = "b'//to_text(b)//'", mass = '//next()//', inertia = 0.5, 0.6, 0.7, 0.05, 0.02, -0.03, '// &
                   'position = '//next()//','//next()//','//next()//', orientation = '//next()//','//next()//','//next()//' /'//lf
            call add_joint('a', types(1 + mod(case + b, 6)))
            text = text(:len(text))
            call add_joint('c', 'in-line')
         end do
         call run_text(text, 0.2_wp, 1.0e-6_wp, run, failure)
         if (allocated(failure)) then
            failure = 'mechanism '//to_text(case)//': '//failure
            return
         end if
         call check_below(failure, violation(run), 1.0e-10_wp, 'violation of mechanism '//to_text(case))
      end do

   contains

      !> A number between 0.1 and 1.1, as text.
      function next() result(number)
         character(len=8) :: number

         seed = modulo(seed*75 + 74, 65537)
         write (number, '(f8.6)') 0.1_wp + real(seed, wp)/65537.0_wp
      end function next

      !> The same joint twice.
      subroutine add_joint(label, type)
         character(*), intent(in) :: label, type
         character(:), allocatable :: rest
         character(len=8) :: p(6)
         integer :: i

         do i = 1, 6
            p(i) = next()
         end do
         rest = '", type = "'//trim(type)//'", body_1 = "'//trim(merge('ground', 'b'//to_text(max(1, b - 1))//'    ', b == 1))// &
                '", body_2 = "b'//to_text(b)//'", point = '//p(1)//','//p(2)//','//p(3)
         if (type == 'universal') then
            rest = rest//', axis_1 = '//p(4)//','//p(5)//', 0.0, axis_2 = -'//p(5)//','//p(4)//', 0.0 /'//lf
         else if (type == 'spherical') then
            rest = rest//' /'//lf
         else
            rest = rest//', axis = '//p(4)//','//p(5)//','//p(6)//' /'//lf
         end if
         if (label == 'c') then
            ! A line of the second body through the same point, along the axis of a joint that keeps it or is locked by it.
            text = text//'&joint name = "'//label//to_text(b)//rest
            return
         end if
         text = text//'&joint name = "'//label//to_text(b)//rest//'&joint name = "again'//to_text(b)//rest
      end subroutine add_joint

   end subroutine random_mechanisms

end module test_mechanism_redundancy
