!> Mechanisms whose joints follow functions of time, and tables that are functions.
module test_mechanism_drives
   use taut, only: error_t, wp
   use taut_case_mechanism, only: read_mechanism
   use taut_case_namelist_file, only: namelist_file_t
   use taut_case_posix, only: make_folder, remove_file
   use taut_case_process, only: process_id
   use taut_error, only: to_text
   use test_case, only: lf, load
   use testing, only: check, check_close, new_test, test_t
   use mechanism_runs, only: entry_of, output, run_t, run_text
   implicit none (type, external)
   private
   public :: collect_mechanism_drives

contains

   !> All tests of this module.
   function collect_mechanism_drives() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('driven joints of every kind', driven_joints), &
               new_test('a drive from a table', table_drive)]
   end function collect_mechanism_drives

   !> Drives are followed: angle over several turns, displacement, distance, coordinate, by functions of all kinds.
   subroutine driven_joints(failure)
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: run
      real(wp), parameter :: pi = acos(-1.0_wp)
      character(*), parameter :: body = '&body name = "b", shape = "box", size = 1.0, 0.5, 0.2, mass = 1.0, position = '// &
               '1.0, 0.0, 0.0 /'//lf

      call run_text(body//'&function name = "g", kind = "polynomial", coefficients = 0.0, 10.0 /'//lf// &
                    '&joint name = "j", type = "revolute", body_2 = "b", point = 0.0, 0.0, 0.0, axis = 0.0, 0.0, 1.0, '// &
                    'drive_angle = "g" /', 1.3_wp, 1.0e-9_wp, run, failure)
      if (allocated(failure)) return
      call check_close(failure, output(run, run%at, 'j.angle'), 16.9_wp, 1.0e-10_wp, 'angle')
      call check_close(failure, entry_of(run, run%at, 'b.wz'), 26.0_wp, 1.0e-9_wp, 'its rate')
      ! Torque about the axis: (J + m) 20.
      call check_close(failure, output(run, run%at, 'j.mz'), 20.0_wp*(1.25_wp/12.0_wp + 1.0_wp), 1.0e-8_wp, 'torque of the drive')
      call run_text(body//'&function name = "g", kind = "step", amplitude = 0.3, start = 0.2, finish = 0.7 /'//lf// &
                    '&joint name = "j", type = "prismatic", body_2 = "b", point = 0.0, 0.0, 0.0, axis = 0.0, 1.0, 1.0, '// &
                    'drive = "g" /', 0.6_wp, 1.0e-9_wp, run, failure)
      if (allocated(failure)) return
      call check_close(failure, output(run, run%at, 'j.displacement'), &
               0.3_wp*0.8_wp**3*(10.0_wp - 15.0_wp*0.8_wp + 6.0_wp*0.64_wp), &
                       1.0e-10_wp, 'displacement')
      call run_text(body//'&function name = "g", kind = "cosine", offset = 0.5, amplitude = 0.5, frequency = 2.0 /'//lf// &
                    '&joint name = "j", type = "distance", body_2 = "b", point_1 = 0.0, 0.0, 0.0, drive = "g" /', 0.3_wp, &
                             1.0e-9_wp, &
                    run, failure)
      if (allocated(failure)) return
      call check_close(failure, norm2(run%at%x(1:3)), 0.5_wp + 0.5_wp*cos(1.2_wp*pi), 1.0e-10_wp, 'distance')
      call run_text(body//'&function name = "g", kind = "sine", offset = 1.0, amplitude = 0.5, omega = 3.0 /'//lf// &
                    '&joint name = "j", type = "coordinate", body_2 = "b", axis = 1.0, 0.0, 0.0, drive = "g" /', 0.3_wp, &
                             1.0e-9_wp, &
                    run, failure)
      if (allocated(failure)) return
      call check_close(failure, run%at%x(1), 1.0_wp + 0.5_wp*sin(0.9_wp), 1.0e-10_wp, 'coordinate')
   end subroutine driven_joints

   !> A table of a parabola, read from a file beside the case file; and one that goes back in time.
   subroutine table_drive(failure)
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: run
      type(namelist_file_t) :: file
      type(error_t), allocatable :: error
      character(:), allocatable :: name, text
      integer :: i, unit

      name = to_text(process_id())//'_table.csv'
      call make_folder('build/scratch')
      text = '&point_mass name = "m", mass = 1.0 /'//lf//'&function name = "g", kind = "table", table = "'//name//'" /'//lf// &
             '&joint name = "j", type = "coordinate", body_2 = "m", axis = 1.0, 0.0, 0.0, drive = "g" /'//lf// &
             '&integration t_end = 0.75 /'
      open (newunit=unit, file='build/scratch/'//name, action='write', status='replace')
      write (unit, '(a)') 'time,value'
      do i = 0, 10
         write (unit, '(f4.1, a, f8.4)') 0.1*i, ',', 0.01*i*i
      end do
      close (unit)
      call run_text(text, 0.75_wp, 1.0e-9_wp, run, failure)
      if (.not. allocated(failure)) then
         call check_close(failure, run%at%x(1), 0.5625_wp, 1.0e-7_wp, 'the parabola')
         call check_close(failure, run%at%v(1), 1.5_wp, 1.0e-6_wp, 'its slope')
      end if
      open (newunit=unit, file='build/scratch/'//name, action='write', status='replace')
      write (unit, '(a)') '0.0, 1.0', '0.2, 2.0', '0.1, 3.0'
      close (unit)
      call load(text, file, error)
      call read_mechanism(file, run%model, run%start, run%settings, run%report, error)
      call remove_file('build/scratch/'//name)
      call check(failure, allocated(error), 'a table that goes back is taken')
      if (allocated(error)) call check(failure, index(error%line(), &
               ':2: &function "g": its table is not increasing in time: row 3') &
                                       > 0, error%line())
      call refuse('0;0'//lf//'1;0,1', 'line 1 of the table')
      call refuse('t,g'//lf//'0,0'//lf//'1;0,1', 'line 3 of the table')
      call refuse('t;g'//lf//'0.0,0.0,0.0'//lf//'1.0,0.0,0.0', 'line 2 of the table')
      call refuse('a,b'//lf//'c,d', 'line 2 of the table')
      call refuse('nan,1'//lf//'0,0'//lf//'1,1', 'line 1 of the table')
      call refuse('0.0 0.0'//lf//'1.0 0.0', 'line 1 of the table')
      call refuse('0,0'//lf//'1/,2', 'line 2 of the table')
      call refuse('t,g'//lf//'0,0', 'fewer than two rows')
      ! The run is from 0 to 0.75 s.
      call refuse('0,0'//lf//'0.5,1', 'its table goes from t = 0 s to 0.5000 s, the run from 0 s to 0.7500 s')
      call refuse('0.1,0'//lf//'1.0,1', 'its table goes from t = 0.1000 s to 1.0000 s')

   contains

      subroutine refuse(rows, complaint)
         character(*), intent(in) :: rows, complaint

         if (allocated(failure)) return
         open (newunit=unit, file='build/scratch/'//name, action='write', status='replace')
         write (unit, '(a)') rows
         close (unit)
         if (allocated(error)) deallocate (error)
         call load(text, file, error)
         if (.not. allocated(error)) call read_mechanism(file, run%model, run%start, run%settings, run%report, error)
         call remove_file('build/scratch/'//name)
         call check(failure, allocated(error), 'it is taken: '//rows)
         if (.not. allocated(error)) return
         call check(failure, index(error%line(), ':2: &function "g": ') > 0 .and. index(error%line(), complaint) > 0, &
                    'wanted "'//complaint//'", got: '//error%line())
      end subroutine refuse

   end subroutine table_drive

end module test_mechanism_drives
