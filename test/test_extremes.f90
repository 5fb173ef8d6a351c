!> Tests of extremes: largest and smallest values over a motion, whatever is written of it.
module test_extremes
   use taut_archive, only: archive_t
   use taut_case_extremes, only: extremes_t
   use taut_case_mechanism, only: read_mechanism
   use taut_case_namelist_file, only: namelist_file_t
   use taut_case_recorder, only: recorder_t
   use taut_case_row, only: row_t
   use taut_case_settings, only: settings_t
   use taut_constrained_simulate, only: simulation_t
   use taut_constrained_system, only: state_t
   use taut_constrained_system_tables, only: magnitude_t
   use taut_error, only: error_t
   use taut_kinds, only: wp
   use taut_model_mechanism, only: mechanism_t
   use taut_model_mechanism_report, only: mechanism_report_t
   use taut_ode_pause, only: pause_t
   use taut_ode_status, only: status_interrupted, status_reached_end
   use test_case, only: check_error, lf, load
   use testing, only: check, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_extremes

   !> Pauses once, before a step.
   type, extends(pause_t) :: once_t
      integer :: steps = 0, at = huge(1)
   contains
      procedure :: wanted
   end type once_t

   !> A uniform rod of 1 m and 1 kg that falls from the horizontal; a mass that swings on a spring, x = 0.3 cos(10 t) + 0.4 sin(10 t).
   character(*), parameter :: pendulum = '&mechanism planar=.true. /'//lf//'&gravity /'//lf// &
                              '&body name="rod" shape="rod" mass=1 from=0,0 to=1,0 /'//lf// &
                              '&joint name="hinge" type="revolute" body_2="rod" point=0,0 /'//lf, &
                              oscillator = '&mechanism planar=.true. /'//lf// &
                              '&body name="m" mass=2 inertia=1 position=0.3,0 velocity=4,0 /'//lf// &
                              '&joint name="rail" type="prismatic" body_2="m" point=0,0 axis=1,0,0 /'//lf// &
                              '&spring name="s" body_2="m" point_1=-1,0 point_2=0.3,0 stiffness=200 free_length=1 /'//lf

contains

   !> All tests of this module.
   function collect_extremes() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('the pull at the bottom of a swing', at_the_bottom), &
               new_test('sizes of reactions are those of their multipliers', sizes), &
               new_test('between the ends of long steps', inside_steps), &
               new_test('inside a long first step', inside_first_step), &
               new_test('no row is above the largest', rows_count), &
               new_test('not round-off at dead points', at_dead_points), &
               new_test('in a window', in_window), &
               new_test('behind a jump of a load', behind_jump), &
               new_test('at both ends of the motion', at_the_ends), &
               new_test('the work is that of the method', work_is_the_same), &
               new_test('a pause makes no difference', paused), &
               new_test('extremes that cannot be', faulty)]
   end function collect_extremes

   !> Whether to pause.
   logical function wanted(self)
      class(once_t), intent(inout) :: self

      self%steps = self%steps + 1
      wanted = self%steps == self%at
   end function wanted

   !> Runs a case, and if wished pauses in it and goes on from an archive.
   subroutine run_case(text, failure, recorder, simulation, pause_at)
      character(*), intent(in) :: text
      character(:), allocatable, intent(inout) :: failure
      type(recorder_t), intent(out) :: recorder
      type(simulation_t), intent(out) :: simulation
      integer, intent(in), optional :: pause_at
      type(namelist_file_t) :: file
      type(mechanism_t) :: model
      type(mechanism_report_t) :: report
      type(settings_t) :: settings
      type(state_t) :: start
      type(error_t), allocatable :: error
      type(archive_t) :: archive
      type(once_t) :: pause
      type(extremes_t) :: kept

      call load(text, file, error)
      if (.not. allocated(error)) call read_mechanism(file, model, start, settings, report, error)
      if (.not. allocated(error)) call recorder%prepare(model, settings, error)
      if (.not. allocated(error)) call simulation%init(model, error, settings%methods(1)%method, settings%options)
      call no_error(failure, error)
      if (allocated(failure)) return
      if (present(pause_at)) pause%at = pause_at
      call simulation%run(start, settings%t_end, error, recorder, pause=pause)
      if (simulation%result%status == status_interrupted) then
         call archive%clear()
         call simulation%serialize(archive)
         call recorder%extremes%serialize(archive)
         call kept%init(model, settings%extremes, .true., error)
         recorder%extremes = kept
         simulation = simulation_t()
         call simulation%init(model, error, settings%methods(1)%method, settings%options)
         call archive%rewind()
         call simulation%serialize(archive)
         call recorder%extremes%serialize(archive)
         if (allocated(archive%error)) call move_alloc(archive%error, error)
         call no_error(failure, error)
         if (.not. allocated(failure)) call simulation%resume(recorder)
      end if
      call no_error(failure, error)
      call check(failure, simulation%result%status == status_reached_end, 'the run has ended early')
   end subroutine run_case

   !> A column of the summary.
   real(wp) function extreme(recorder, name) result(value)
      type(recorder_t), intent(in) :: recorder
      character(*), intent(in) :: name
      type(row_t) :: row
      character(:), allocatable :: names
      integer :: first, i, length

      value = -huge(1.0_wp)
      call row%create()
      call recorder%extremes%fields(row)
      names = recorder%extremes%names()//','
      first = 0
      i = 1
      do while (i < len(names))
         first = first + 1
         length = index(row%letters(first:row%used)//',', ',') - 1
         if (names(i + 1:i + index(names(i + 1:), ',') - 1) == name) then
            if (length > 0) read (row%letters(first:first + length - 1), *) value
            return
         end if
         i = i + index(names(i + 1:), ',')
         first = first + length
      end do
   end function extreme

   !> (5/2) m g, at the bottom, whatever is written; and the time at which the rod gets there.
   subroutine at_the_bottom(failure)
      character(:), allocatable, intent(inout) :: failure
      type(recorder_t) :: recorder
      type(simulation_t) :: simulation

      call run_case(pendulum//'&integration t_end=2 rtol=1e-9 atol=1e-9 /'//lf//'&output dt=0.7 /', failure, recorder, simulation)
      if (allocated(failure)) return
      call check_close(failure, extreme(recorder, 'hinge.force_max'), 24.525_wp, 1.0e-6_wp, 'force of the hinge')
      call check(failure, index(recorder%extremes%names(), 'moment') == 0, 'a hinge in the plane has no moment')
   end subroutine at_the_bottom

   !> Of every type of joint in space: the norm of its multipliers is that of its force, and of its moment.
   subroutine sizes(failure)
      character(:), allocatable, intent(inout) :: failure
      character(*), parameter :: types(10) = [character(len=11) :: 'distance', 'spherical', 'revolute', 'prismatic', &
                                              'cylindrical', 'universal', 'planar', 'fixed', 'in-line', 'coordinate']
      type(namelist_file_t) :: file
      type(mechanism_t) :: model
      type(mechanism_report_t) :: report
      type(settings_t) :: settings
      type(state_t) :: start
      type(error_t), allocatable :: error
      type(magnitude_t), allocatable :: list(:)
      real(wp), allocatable :: lambda(:), values(:)
      character(:), allocatable :: text, what
      integer :: i, j

      text = '&mechanism / &function name="g" kind="ramp" rate=0.1 /'//lf
      do i = 1, size(types)
         text = text//'&body name="b'//achar(96 + i)//'" mass=1 inertia=1,1,1 position=1,2,3 /'//lf// &
                '&joint name="'//achar(96 + i)//'" type="'//trim(types(i))//'" body_2="b'//achar(96 + i)//'"'
         select case (types(i))
         case ('distance')
            text = text//' point_1=0.3,0.1,0.2 point_2=1.1,2.1,3.4'
         case ('spherical', 'fixed')
            text = text//' point=0.4,0.5,0.6'
         case ('revolute', 'cylindrical')
            text = text//' point=0.4,0.5,0.6 axis=1,2,2 drive_angle="g"'
         case ('prismatic')
            text = text//' point=0.4,0.5,0.6 axis=1,2,2 drive="g"'
         case ('universal')
            text = text//' point=0.4,0.5,0.6 axis_1=1,2,2 axis_2=2,-1,0'
         case default
            text = text//' point=0.4,0.5,0.6 axis=1,2,2'
         end select
         text = text//' /'//lf
      end do
      call load(text, file, error)
      if (.not. allocated(error)) call read_mechanism(file, model, start, settings, report, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      allocate (values(model%n_outputs))
      lambda = [(sin(1.7_wp*i), i=1, model%c)]
      start%t = 0.0_wp
      call model%outputs(start, lambda, values)
      list = model%magnitudes()
      call check(failure, size(list) >= 16, 'forces and moments are missing')
      do i = 1, size(list)
         what = list(i)%name(3:3)
         do j = 1, model%n_outputs
            if (model%output_name(j) == list(i)%name(:2)//what//'x') exit
         end do
         call check_close(failure, norm2(lambda(list(i)%rows)), norm2(values(j:j + 2)), 1.0e-12_wp, trim(list(i)%name))
      end do
   end subroutine sizes

   !> Amplitude 0.5 of an oscillation of which a step is a good part.
   subroutine inside_steps(failure)
      character(:), allocatable, intent(inout) :: failure
      type(recorder_t) :: recorder
      type(simulation_t) :: simulation

      call run_case(oscillator//'&integration t_end=0.5 rtol=1e-7 atol=1e-8 integrator="dop853" /'//lf//'&output dt=2 /'//lf// &
                    '&extreme column="m.x" / &extreme column="energy" name="E" /', failure, recorder, simulation)
      if (allocated(failure)) return
      call check(failure, simulation%result%steps < 12, 'the steps are long')
      call check_close(failure, extreme(recorder, 'm.x_max'), 0.5_wp, 1.0e-5_wp, 'largest')
      call check_close(failure, extreme(recorder, 'm.x_min'), -0.5_wp, 1.0e-5_wp, 'smallest')
      call check_close(failure, sin(10.0_wp*extreme(recorder, 'm.x_max_t')), 0.8_wp, 5.0e-3_wp, 'time of the largest')
      call check_close(failure, extreme(recorder, 'E_max'), 25.0_wp, 1.0e-5_wp, 'energy')
   end subroutine inside_steps

   !> The same amplitude inside the very first step, which need not be short behind a start or a breakpoint.
   subroutine inside_first_step(failure)
      character(:), allocatable, intent(inout) :: failure
      type(recorder_t) :: recorder
      type(simulation_t) :: simulation

      call run_case(oscillator//'&integration t_end=0.12 first_step=0.12 rtol=1e-4 atol=1e-4 integrator="dop853" /'//lf// &
                    '&output dt=1 / &extreme column="m.x" /', failure, recorder, simulation)
      if (allocated(failure)) return
      call check(failure, simulation%result%steps == 1, 'there is but one step')
      call check_close(failure, extreme(recorder, 'm.x_max'), 0.5_wp, 1.0e-4_wp, 'largest')
   end subroutine inside_first_step

   !> A load across the rail, of which steps along it know nothing, has its peaks where rows are.
   subroutine rows_count(failure)
      character(:), allocatable, intent(inout) :: failure
      type(recorder_t) :: recorder
      type(simulation_t) :: simulation

      call run_case('&mechanism planar=.true. /'//lf//'&body name="m" mass=2 inertia=1 position=0,0 /'//lf// &
                    '&joint name="rail" type="prismatic" body_2="m" point=0,0 axis=1,0,0 /'//lf// &
                    '&function name="hum" kind="sine" amplitude=1 frequency=100 /'//lf// &
                    '&force body="m" value=0,30 function="hum" /'//lf// &
                    '&integration t_end=1 integrator="dop853" / &output dt=0.0025 /', failure, recorder, simulation)
      if (allocated(failure)) return
      call check(failure, simulation%result%steps < 50, 'the steps are long')
      call check_close(failure, extreme(recorder, 'rail.force_max'), 30.0_wp, 1.0e-6_wp, 'force of the rail')
   end subroutine rows_count

   !> A rod as long as its crank, which turns with w: the slider's place is 2 cos(w t), on and on through dead points. With a crank
   !! along (cos, sin), a rod along (cos, -sin) and all masses 1 the forces of the joints have closed forms without a pole: 4 w^2, at
   !! the crank's, 7/2 w^2 and 3 w^2.
   subroutine at_dead_points(failure)
      character(:), allocatable, intent(inout) :: failure
      character(*), parameter :: integrators(2) = [character(len=6) :: 'dopri5', 'dop853'], &
                                 reduce(2) = [character(len=7) :: '.true.', '.false.']
      type(recorder_t) :: recorder
      type(simulation_t) :: simulation
      character(:), allocatable :: note
      integer :: i, j

      do i = 1, size(integrators)
         do j = 1, size(reduce)
            call run_case('&mechanism planar=.true. /'//lf//'&body name="crank" shape="rod" mass=1 from=0,0 to=0.8,0.6 /'//lf// &
                          '&body name="rod" shape="rod" mass=1 from=0.8,0.6 to=1.6,0 /'//lf// &
                          '&body name="slider" mass=1 inertia=0.01 position=1.6,0 /'//lf// &
                          '&function name="g" kind="ramp" rate=6 /'//lf// &
                          '&joint name="A" type="revolute" body_2="crank" point=0,0 drive_angle="g" /'//lf// &
                          '&joint name="B" type="revolute" body_1="crank" body_2="rod" point=0.8,0.6 /'//lf// &
                          '&joint name="C" type="revolute" body_1="rod" body_2="slider" point=1.6,0 /'//lf// &
                          '&joint name="G" type="prismatic" body_2="slider" point=1.6,0 axis=1,0 /'//lf// &
                          '&integration t_end=5 / &output dt=0.01 /'//lf// &
                          '&method name="present" integrator="'//trim(integrators(i))//'" reduce='//trim(reduce(j))//' /', &
                          failure, recorder, simulation)
            if (allocated(failure)) return
            call check_close(failure, extreme(recorder, 'A.force_max'), 144.0_wp, 0.1_wp, 'force of A')
            call check_close(failure, extreme(recorder, 'B.force_max'), 126.0_wp, 0.1_wp, 'force of B')
            call check_close(failure, extreme(recorder, 'C.force_max'), 108.0_wp, 0.1_wp, 'force of C')
            call check_close(failure, extreme(recorder, 'G.force_max'), 108.0_wp, 0.1_wp, 'force of G')
            call recorder%extremes%remark(note)
            call check(failure, index(note, 'left out of the peaks') > 0, 'nothing is said of what is left out')
         end do
      end do
   end subroutine at_dead_points

   !> Between two times the motion is monotone: extremes are at the ends.
   subroutine in_window(failure)
      character(:), allocatable, intent(inout) :: failure
      type(recorder_t) :: recorder
      type(simulation_t) :: simulation

      call run_case(oscillator//'&integration t_end=1 rtol=1e-9 atol=1e-10 /'//lf// &
                    '&extreme column="m.x" from=0.15 to=0.35 / &extreme column="m.x" name="late" from=2 /', &
                    failure, recorder, simulation)
      if (allocated(failure)) return
      call check_close(failure, extreme(recorder, 'm.x_max'), 0.3_wp*cos(1.5_wp) + 0.4_wp*sin(1.5_wp), 1.0e-7_wp, 'where it begins')
      call check_close(failure, extreme(recorder, 'm.x_min'), 0.3_wp*cos(3.5_wp) + 0.4_wp*sin(3.5_wp), 1.0e-7_wp, 'where it ends')
      call check_close(failure, extreme(recorder, 'm.x_max_t'), 0.15_wp, 1.0e-15_wp, 'time of the begin')
      call check_close(failure, extreme(recorder, 'm.x_min_t'), 0.35_wp, 1.0e-15_wp, 'time of the end')
      call check(failure, extreme(recorder, 'late_max') < -1.0_wp, 'what the run does not reach stays empty')
   end subroutine in_window

   !> A load jumps up and fades away: its largest value is that behind the jump.
   subroutine behind_jump(failure)
      character(:), allocatable, intent(inout) :: failure
      type(recorder_t) :: recorder
      type(simulation_t) :: simulation

      call run_case('&mechanism planar=.true. /'//lf//'&body name="m" mass=2 inertia=1 position=0,0 /'//lf// &
                    '&joint name="rail" type="prismatic" body_2="m" point=0,0 axis=1,0,0 /'//lf// &
                    '&function name="up" kind="step" start=0.5 /'//lf// &
                    '&function name="down" kind="ramp" start=0.5 finish=0.75 rate=-4 /'//lf// &
                    '&force body="m" value=0,30 function="up" / &force body="m" value=0,30 function="down" /'//lf// &
                    '&integration t_end=1 max_step=0.1 / &output dt=1 /', failure, recorder, simulation)
      if (allocated(failure)) return
      call check_close(failure, extreme(recorder, 'rail.force_max'), 30.0_wp, 1.0e-6_wp, 'force of the rail')
      call check_close(failure, extreme(recorder, 'rail.force_max_t'), 0.5_wp, 1.0e-6_wp, 'its time')
   end subroutine behind_jump

   !> A rod that falls gets ever faster: start and end count.
   subroutine at_the_ends(failure)
      character(:), allocatable, intent(inout) :: failure
      type(recorder_t) :: recorder
      type(simulation_t) :: simulation

      call run_case(pendulum//'&integration t_end=0.3 rtol=1e-9 atol=1e-9 / &output dt=1 / &extreme column="rod.wz" /', &
                    failure, recorder, simulation)
      if (allocated(failure)) return
      call check_close(failure, extreme(recorder, 'rod.wz_min_t'), 0.3_wp, 1.0e-15_wp, 'the end is where it is fastest')
      call check_close(failure, extreme(recorder, 'rod.wz_max'), 0.0_wp, 1.0e-12_wp, 'it starts at rest')
   end subroutine at_the_ends

   !> Evaluations and steps are those of a run that nobody looks at.
   subroutine work_is_the_same(failure)
      character(:), allocatable, intent(inout) :: failure
      character(*), parameter :: integration = '&integration t_end=3 rtol=1e-7 atol=1e-8 integrator="dop853" /'//lf
      type(recorder_t) :: recorder
      type(simulation_t) :: one, other

      call run_case(oscillator//integration//'&output dt=0.5 joints="none" /', failure, recorder, one)
      call run_case(oscillator//integration//'&output dt=0.5 / &extreme column="m.x" /', failure, recorder, other)
      if (allocated(failure)) return
      call check(failure, one%result%rhs_evaluations == other%result%rhs_evaluations, 'evaluations are others')
      call check(failure, one%result%steps == other%result%steps, 'steps are others')
      call check_close(failure, one%at%x(1), other%at%x(1), 0.0_wp, 'the end')
   end subroutine work_is_the_same

   !> Extremes belong to what a checkpoint holds.
   subroutine paused(failure)
      character(:), allocatable, intent(inout) :: failure
      character(*), parameter :: text = oscillator//'&integration t_end=3 rtol=1e-7 atol=1e-8 /'//lf// &
                                 '&output dt=2 / &extreme column="m.x" / &extreme column="energy" /'
      type(recorder_t) :: one, other
      type(simulation_t) :: simulation
      type(row_t) :: row_of_one, row_of_other
      integer :: i

      call run_case(text, failure, one, simulation)
      do i = 1, 30, 4
         call run_case(text, failure, other, simulation, pause_at=i)
         if (allocated(failure)) return
         call row_of_one%create()
         call row_of_other%create()
         call one%extremes%fields(row_of_one)
         call other%extremes%fields(row_of_other)
         call check(failure, row_of_one%letters(:row_of_one%used) == row_of_other%letters(:row_of_other%used), &
                    'a pause has changed the extremes')
      end do
   end subroutine paused

   !> Names, times and columns.
   subroutine faulty(failure)
      character(:), allocatable, intent(inout) :: failure
      type(namelist_file_t) :: file
      type(mechanism_t) :: model
      type(mechanism_report_t) :: report
      type(settings_t) :: settings
      type(state_t) :: start
      type(recorder_t) :: recorder
      type(error_t), allocatable :: error

      call read_text('&extreme /', 'column')
      call read_text('&extreme column="hinge.fx" / &extreme column="hinge.fx" /', 'two extremes are called "hinge.fx"')
      call read_text('&extreme column="hinge.fx" from=2 to=1 /', 'from = 2')
      call load(pendulum//'&extreme column="hinge.farce" /', file, error)
      call read_mechanism(file, model, start, settings, report, error)
      call no_error(failure, error)
      call recorder%prepare(model, settings, error)
      call check_error(failure, error, 'hinge.force', 'a misspelt column')
      call prepare_text('&extreme column="rod.wz" name="hinge.force" /', .true.)
      call prepare_text('&extreme column="hinge.force" from=0.1 /', .true.)
      call prepare_text('&extreme column="hinge.force" to=0.1 /', .true.)
      call prepare_text('&extreme column="hinge.force" name="late" from=0.1 / &extreme column="hinge.force" /', .false.)

   contains

      subroutine read_text(text, part)
         character(*), intent(in) :: text, part

         call load(pendulum//text, file, error)
         call read_mechanism(file, model, start, settings, report, error)
         call check_error(failure, error, part, text)
         if (allocated(error)) deallocate (error)
      end subroutine read_text

      !> What the summary tells of a joint, over the whole motion, has its name to itself.
      subroutine prepare_text(text, taken)
         character(*), intent(in) :: text
         logical, intent(in) :: taken
         type(recorder_t) :: one

         if (allocated(error)) deallocate (error)
         call load(pendulum//text, file, error)
         call read_mechanism(file, model, start, settings, report, error)
         call no_error(failure, error)
         call one%prepare(model, settings, error)
         if (taken) then
            call check_error(failure, error, '&extreme|"hinge.force"|another name', text)
         else
            call no_error(failure, error)
         end if
      end subroutine prepare_text

   end subroutine faulty

end module test_extremes
