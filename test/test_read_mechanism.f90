!> Tests of a mechanism that a program takes from a case file.
module test_read_mechanism
   use taut, only: error_t, integration_options_t, integration_result_t, mechanism_report_t, mechanism_t, method_t, &
                   read_mechanism, simulate, state_t, wp
   use taut_case_mechanism_part, only: expand
   use taut_case_namelist_file, only: namelist_file_t
   use taut_case_settings, only: settings_t
   use test_case, only: lf, load
   use testing, only: check, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_read_mechanism

   character(*), parameter :: path = 'cases/mechanism/slider_crank.nml'

contains

   !> All tests of this module.
   function collect_read_mechanism() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('a case file as the app runs it', whole), &
               new_test('what is wrong with a file is told', faulty), &
               new_test('numbered names', numbered_names), &
               new_test('faulty mechanisms', complaints)]
   end function collect_read_mechanism

   !> The slider's position follows from the crank's angle.
   subroutine whole(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(method_t) :: method
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(mechanism_report_t) :: report
      type(error_t), allocatable :: error
      real(wp) :: t_end

      call read_mechanism(path, mechanism, at, error, method, options, t_end, report)
      call no_error(failure, error)
      if (allocated(failure)) return
      call check(failure, method%weight == 'mass', 'the weight of mechanisms')
      call check_close(failure, options%rtol, 1.0e-9_wp, 0.0_wp, 'its tolerance')
      call check_close(failure, t_end, 2.0_wp, 0.0_wp, 'its end')
      call check(failure, report%freedoms == 0 .and. report%rank == mechanism%c, 'its crank is driven')
      call simulate(mechanism, at, t_end, result, error, method, options)
      call no_error(failure, error)
      call check_close(failure, at%x(7), 0.1_wp*cos(20.0_wp) + sqrt(0.09_wp - (0.1_wp*sin(20.0_wp))**2), 1.0e-8_wp, 'its slider')
   end subroutine whole

   subroutine faulty(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(method_t) :: method
      type(error_t), allocatable :: error

      call read_mechanism('cases/mechanism/none.nml', mechanism, at, error, method)
      call check(failure, allocated(error), 'a file that is not there')
      if (allocated(failure)) return
      call check(failure, index(error%line(), 'cases/mechanism/none.nml') == 1, error%line())
      deallocate (error)
      call read_mechanism('cases/pendulum/figure1.nml', mechanism, at, error)
      call check(failure, allocated(error), 'a case of another app')
      if (allocated(failure)) return
      call check(failure, index(error%line(), 'cases/pendulum/figure1.nml:') == 1, error%line())
   end subroutine faulty

   subroutine numbered_names(failure)
      character(:), allocatable, intent(inout) :: failure

      call check(failure, expand('rod#', 7) == 'rod7', 'rod#')
      call check(failure, expand('rod#-1', 10) == 'rod9', 'rod#-1')
      call check(failure, expand('r#+12x', 1) == 'r13x', 'r#+12x')
      call check(failure, expand('rod#-', 3) == 'rod3-', 'a sign without a number')
      call check(failure, expand('rod', 3) == 'rod', 'no number')
   end subroutine numbered_names

   subroutine complaints(failure)
      character(:), allocatable, intent(inout) :: failure
      character(*), parameter :: ball = '&body name = "ball", mass = 1.0, shape = "sphere", radius = 0.1, position = 1.0, '// &
               '0.0, 0.0 /'
      character(*), parameter :: rod = '&body name = "rod", mass = 1.0, shape = "rod", thickness = 0.1, from = 0.0, 0.0, 0.0, '// &
                                 'to = 1.0, 0.0, 0.0 /'
      character(*), parameter :: hinge = '&joint name = "hinge", type = "revolute", body_2 = "rod", point = 0.0, 0.0, 0.0, '// &
                                 'axis = 0.0, 1.0, 0.0'

      call expect(ball//lf//'&joint name = "j", type = "spherical", body_2 = "bal" /', &
               ':2: &joint "j": body_2 = "bal": there is no')
      call expect(ball//lf//lf//ball, ':3: &body "ball": the name is taken')
      call expect(ball//lf//'&joint name = "d", type = "distance", body_2 = "ball", point_1 = 0.0, 0.0, 0.0 /'//lf// &
                  '&joint name = "e", type = "distance", body_2 = "ball", point_1 = 5.0, 0.0, 0.0, length = 0.5 /', &
                  ':3: &joint "e": it is open by 3.5000 at the start')
      ! A rod on a hinge whose end is to be where it cannot: the hinge was closed at the start.
      call expect(rod//lf//hinge//' /'//lf//'&joint name = "far", type = "spherical", body_2 = "rod", point_1 = 3.0, 0.0, 0.0, '// &
                  'point_2 = 1.0, 0.0, 0.0 /', ':3: &joint "far": it is open by 2.0000 at the start')
      call expect(rod//lf//hinge//', drive_angle = "g" /'//lf//'&joint name = "j", type = "revolute", body_2 = "rod", '// &
                  'point = 0.0, 0.0, 0.0, axis = 0.0, 1.0, 0.0, drive_angle = "h" /'//lf// &
                  '&function name = "g", kind = "ramp", rate = 1.0 /'//lf//'&function name = "h", kind = "ramp", rate = 2.0 /', &
                  ':2: &joint "hinge": the velocities of "hinge" (drive_angle "g"), "j" (drive_angle "h") contradict')
      call expect('&mechanism hold = "rod" /'//lf//rod//lf//hinge//', drive_angle = "g" /'//lf// &
                  '&function name = "g", kind = "ramp", rate = 1.0 /', ':3: &joint "hinge": the velocities of "hinge" (drive_angle')
      call expect('&mechanism hold = "rod" /'//lf//rod//lf//hinge//', drive_angle = "g" /'//lf// &
                  '&function name = "g", offset = 3.14159265358979 /', &
                  ':3: &joint "hinge": the mechanism cannot be assembled (joint "hinge" is half a turn from where its drive "g"')
      call expect(rod//lf//'&joint name = "rod", type = "spherical", body_2 = "rod", point = 0.0, 0.0, 0.0 /', &
                  ':2: &joint "rod": the name is taken')
      call expect(rod//lf//'&point name = "tip", body = "rod", position = 1.0, 0.0, 0.0 /'//lf// &
                  '&joint name = "tip", type = "spherical", body_2 = "rod", point = 1.0, 0.0, 0.0 /', &
                  ':3: &joint "tip": the name is taken')
      call expect(rod//lf//'&joint name = "j", type = "spherical", body_2 = "rod" /', ':2: &joint "j": it has no point')
      call expect(rod//lf//'&joint name = "j", type = "universal", body_2 = "rod", point = 0.0, 0.0, 0.0, axis_1 = 1.0, 0.0, '// &
                  '0.0, axis_2 = 1.0, 1.0, 0.0 /', 'axis_1 and axis_2 must be at right angles')
      call expect(rod//lf//'&joint name = "j", type = "universal", body_2 = "rod", point = 0.0, 0.0, 0.0, axis_1 = 1.0, 0.0, '// &
                  '0.0, axis_2 = 2.0, 0.0, 0.0, frame = "body" /', 'axis_1 and axis_2 must be at right angles')
      call expect(rod//lf//hinge//' /'//lf//'&damper name = "d", joint = "hinge", damping = -1.0 /', &
                  'damping = -1.0000 is negative')
      call expect('&body name = "b", inertia = 1, 1, 1 /', ':1: &body "b": it has no mass')
      call expect('&point_mass name = "b" /', ':1: &point_mass "b": it has no mass')
      call expect('&body name = "b", mass = 0.0, inertia = 1, 1, 1 /', ':1: &body "b": its mass is 0 kg')
      call expect('&body name = "b", mass = 1.0, inertia = 1, 1, 3 /', ':1: &body "b": its inertia breaks the triangle inequality')
      call expect('&body name = "b", mass = 1.0 /', 'it has neither inertia nor shape')
      call expect(ball//lf//'&joint name = "j", type = "revolute", body_2 = "ball", point = 0.0, 0.0, 0.0, '// &
                  'axis = 0.0, 0.0, 0.0 /', &
                  ':2: &joint "j": its axis has the length zero')
      call expect(ball//lf//'&joint name = "j", type = "spherical", body_1 = "ball", body_2 = "ball" /', &
                  ':2: &joint "j": it joins "ball" to itself')
      call expect(ball//lf//'&joint name = "j", type = "hinge", body_2 = "ball" /', 'there is no joint type "hinge"')
      call expect(ball//lf//'&function name = "g", kind = "table", table = "nowhere.csv" /', ':2: &function "g": there is no table')
      call expect(ball//lf//'&function name = "g", kind = "step", amplitude = 1.0 /'//lf// &
                  '&joint name = "j", type = "revolute", body_2 = "ball", point = 0.0, 0.0, 0.0, axis = 0.0, 0.0, 1.0, '// &
                  'drive_angle = "g" /', 'jumps')
      call expect(ball//lf//'&joint name = "j", type = "spherical", body_2 = "ball", typo = 1 /', 'there is no entry typo')
      call expect(ball//lf//'&spring name = "s", body_1 = "ball", body_2 = "ball", stiffness = 1.0 /', 'to itself')
      call expect('&mechanism planar = .true. /'//lf//'&body name = "b", mass = 1.0, inertia = 1.0, position = 0.0, 0.0, 1.0 /', &
                  ':2: &body "b": it leaves the plane')
      call expect('&mechanism planar = .true. /'//lf//'&body name = "b", mass = 1.0, inertia = 1.0 /'//lf// &
                  '&joint name = "j", type = "universal", body_2 = "b", point = 0.0, 0.0, axis_1 = 1.0, 0.0, axis_2 = 0.0, 1.0 /', &
                  'no meaning in the plane')
      call expect('&body name = "b", mass = 1.0, shape = "sphere", radius = 1.0, repeat = 3 /', 'has no #')
      call expect('&mechanism hold = "nothing" /'//lf//ball, 'there is no coordinate "nothing"')
      call expect('&gravity /', 'it has no body')
      call expect('&bodies /', 'there is no group &bodies')

   contains

      subroutine expect(text, complaint)
         character(*), intent(in) :: text, complaint
         type(namelist_file_t) :: file
         type(error_t), allocatable :: error
         type(mechanism_t) :: model
         type(settings_t) :: settings
         type(mechanism_report_t) :: report
         type(state_t) :: start

         if (allocated(failure)) return
         call load(text, file, error)
         if (.not. allocated(error)) call read_mechanism(file, model, start, settings, report, error)
         if (.not. allocated(error)) then
            call check(failure, .false., 'no complaint: '//complaint)
            return
         end if
         call check(failure, index(error%line(), complaint) > 0, 'wanted "'//complaint//'", got: '//error%line())
      end subroutine expect

   end subroutine complaints

end module test_read_mechanism
