!> Mechanisms from case files: closed forms, published values, equivalent descriptions, and what is complained about.
module test_mechanism_case
   use taut, only: constrained_ode_t, error_t, integration_options_t, integration_result_t, sample_t, simulate, state_t, &
                   status_reached_end, wp
   use taut_constrained_method_choose, only: new_constrained_ode
   use taut_case_mechanism, only: read_mechanism
   use taut_case_mechanism_part, only: expand
   use taut_case_mechanism_static, only: solve_static, static_t
   use taut_case_namelist_file, only: namelist_file_t
   use taut_case_posix, only: make_folder, remove_file
   use taut_case_process, only: process_id
   use taut_case_settings, only: settings_t
   use taut_constrained_model_events, only: model_events_t
   use taut_error, only: to_text
   use taut_model_mechanism, only: mechanism_t
   use taut_model_mechanism_report, only: mechanism_report_t
   use taut_model_rigid_bodies, only: new_rigid_bodies, rigid_bodies_t, rigid_body_t, spherical_joint_t
   use taut_model_swing, only: new_swing_beam, swing_beam_t, swing_data_t
   use test_case, only: lf, load
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_mechanism_case

   !> A case, read, and what became of it.
   type :: run_t
      type(mechanism_t) :: model
      type(settings_t) :: settings
      type(mechanism_report_t) :: report
      !> Start, and state at the end.
      type(state_t) :: start, at
      type(integration_result_t) :: result
   end type run_t

   character(*), parameter :: folder = 'cases/mechanism/'

contains

   !> All tests of this module.
   function collect_mechanism_case() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('numbered names', numbered_names), &
               new_test('reactions of a pendulum in closed form', pendulum_reactions), &
               new_test('moment of a clamp in closed form', clamp_moment), &
               new_test('slider of a driven crank in closed form', slider_crank), &
               new_test('N-four-bar through its singular positions', n_four_bar), &
               new_test('Bricard names its redundancy', bricard), &
               new_test('Bricard by the implicit integrator', implicit_bricard), &
               new_test('what is prevented twice, and which reactions are unique', words_of_redundancy), &
               new_test('Andrews: published accelerations, forces and motion', andrews), &
               new_test('a disc rolls round a circle', rolling_disc), &
               new_test('the governor keeps its angular momentum', governor), &
               new_test('spatial slider-crank in closed form', spatial_slider_crank), &
               new_test('heavy top against another model', heavy_top), &
               new_test('a four-bar is assembled with its crank held', held_crank), &
               new_test('plane and space give one motion', planar_and_spatial), &
               new_test('a distance is a massless rod', distance_and_rod), &
               new_test('equal orientations give one motion', equal_orientations), &
               new_test('driven joints of every kind', driven_joints), &
               new_test('ten mechanisms with redundant joints', random_mechanisms), &
               new_test('a fast spin lasts', fast_spin), &
               new_test('a heavy mass on a rod of almost none', mass_ratio), &
               new_test('modes of a double pendulum in closed form', pendulum_modes), &
               new_test('a spring and its load in equilibrium', spring_equilibrium), &
               new_test('a swing of beam elements against the swing', swing), &
               new_test('a drive from a table', table_drive), &
               new_test('an angle passes its value', event_times), &
               new_test('a knife edge goes where it points', knife_edge), &
               new_test('faulty mechanisms', faulty)]
   end function collect_mechanism_case

   !> Reads a case file of the project and runs it to a time.
   subroutine run_file(name, t_end, tolerance, run, failure)
      character(*), intent(in) :: name
      real(wp), intent(in) :: t_end, tolerance
      type(run_t), intent(out) :: run
      character(:), allocatable, intent(inout) :: failure
      type(namelist_file_t) :: file
      type(error_t), allocatable :: error

      call file%load(folder//name//'.nml', error)
      call no_error(failure, error)
      if (.not. allocated(failure)) call run_loaded(file, t_end, tolerance, run, failure)
   end subroutine run_file

   !> The same for a text.
   subroutine run_text(text, t_end, tolerance, run, failure)
      character(*), intent(in) :: text
      real(wp), intent(in) :: t_end, tolerance
      type(run_t), intent(out) :: run
      character(:), allocatable, intent(inout) :: failure
      type(namelist_file_t) :: file
      type(error_t), allocatable :: error

      call load(text, file, error)
      call no_error(failure, error)
      if (.not. allocated(failure)) call run_loaded(file, t_end, tolerance, run, failure)
   end subroutine run_text

   subroutine run_loaded(file, t_end, tolerance, run, failure)
      type(namelist_file_t), intent(in) :: file
      real(wp), intent(in) :: t_end, tolerance
      type(run_t), intent(inout) :: run
      character(:), allocatable, intent(inout) :: failure
      type(error_t), allocatable :: error

      call read_mechanism(file, run%model, run%start, run%settings, run%report, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      run%settings%options%rtol = tolerance
      run%settings%options%atol = tolerance
      run%at = run%start
      call simulate(run%model, run%at, t_end, run%result, error, run%settings%methods(1)%method, run%settings%options)
      call no_error(failure, error)
      if (allocated(run%result%error)) call check(failure, .false., run%result%error%line())
      call check(failure, all(abs(run%at%x) < huge(1.0_wp)), 'a coordinate is not a number')
   end subroutine run_loaded

   !> An output at a state.
   function output(run, at, name) result(value)
      type(run_t), intent(in) :: run
      type(state_t), intent(in) :: at
      character(*), intent(in) :: name
      real(wp) :: value
      class(constrained_ode_t), allocatable :: ode
      type(error_t), allocatable :: error
      type(sample_t) :: sample
      real(wp), allocatable :: y(:)
      integer :: i, info

      value = huge(value)
      call new_constrained_ode(ode, run%model, run%settings%methods(1)%method, error)
      allocate (y(ode%size()))
      call ode%pack(at, y)
      call ode%sample(at%t, y, sample, info)
      do i = 1, run%model%n_outputs
         if (run%model%output_name(i) == name) value = sample%outputs(i)
      end do
   end function output

   !> A coordinate or a velocity at a state.
   function entry_of(run, at, name) result(value)
      type(run_t), intent(in) :: run
      type(state_t), intent(in) :: at
      character(*), intent(in) :: name
      real(wp) :: value
      integer :: i

      value = huge(value)
      do i = 1, run%model%n_x
         if (run%model%x_name(i) == name) value = at%x(i)
      end do
      do i = 1, run%model%n
         if (run%model%v_name(i) == name) value = at%v(i)
      end do
   end function entry_of

   !> Largest entry of phi at the end.
   function violation(run) result(value)
      type(run_t), intent(in) :: run
      real(wp) :: value
      real(wp), allocatable :: phi(:)

      allocate (phi(run%model%n_phi))
      call run%model%constraint(run%at, phi)
      value = maxval(abs(phi))
   end function violation

   subroutine numbered_names(failure)
      character(:), allocatable, intent(inout) :: failure

      call check(failure, expand('rod#', 7) == 'rod7', 'rod#')
      call check(failure, expand('rod#-1', 10) == 'rod9', 'rod#-1')
      call check(failure, expand('r#+12x', 1) == 'r13x', 'r#+12x')
      call check(failure, expand('rod#-', 3) == 'rod3-', 'a sign without a number')
      call check(failure, expand('rod', 3) == 'rod', 'no number')
   end subroutine numbered_names

   !> A uniform rod at angle a from the horizontal at rest: the hinge's forces along and across it are m g sin a and m g cos a/4.
   subroutine pendulum_reactions(failure)
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: run
      real(wp) :: a, w
      real(wp), parameter :: weight = 9.81_wp

      call run_file('simple_pendulum', 0.8_wp, 1.0e-11_wp, run, failure)
      if (allocated(failure)) return
      call check_close(failure, output(run, run%start, 'hinge.fy'), 0.25_wp*weight, 1.0e-10_wp, 'at the start')
      call check_below(failure, output(run, run%start, 'hinge.fx'), 1.0e-10_wp, 'at the start, along')
      a = entry_of(run, run%at, 'rod.angle')
      w = entry_of(run, run%at, 'rod.wz')
      call check_close(failure, w**2, -3.0_wp*weight*sin(a), 1.0e-8_wp, 'energy')
      ! Toward the hinge: m w^2 L/2 - m g sin a; across: m g cos a/4.
      call check_close(failure, output(run, run%at, 'hinge.fx')*cos(a) + output(run, run%at, 'hinge.fy')*sin(a), &
                       -0.5_wp*w**2 + weight*sin(a), 1.0e-10_wp, 'along the rod')
      call check_close(failure, output(run, run%at, 'hinge.fy')*cos(a) - output(run, run%at, 'hinge.fx')*sin(a), &
                       0.25_wp*weight*cos(a), 1.0e-10_wp, 'across the rod')
      call check_below(failure, output(run, run%at, 'hinge.mz'), 1.0e-12_wp, 'a hinge has no moment')
      call check_close(failure, output(run, run%at, 'hinge.angle'), a, 1.0e-12_wp, 'angle of the hinge')
   end subroutine pendulum_reactions

   !> A beam clamped askew: force m g, moment m g L/2 about the clamp, in global and in the clamp's axes.
   subroutine clamp_moment(failure)
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: run
      character(*), parameter :: body = '&gravity /'//lf//'&body name = "rod", shape = "rod", mass = 2.0, thickness = 0.1, '// &
                                 'from = 0.3, 0.0, 0.0, to = 0.3, 3.0, 4.0 /'//lf

      call run_text(body//'&joint name = "clamp", type = "fixed", body_2 = "rod", point = 0.3, 0.0, 0.0, '// &
                    'axis = 0.0, 3.0, 4.0 /', 0.1_wp, 1.0e-8_wp, run, failure)
      if (allocated(failure)) return
      call check_close(failure, output(run, run%start, 'clamp.fz'), 19.62_wp, 1.0e-10_wp, 'force')
      call check_close(failure, output(run, run%start, 'clamp.mx'), 19.62_wp*1.5_wp, 1.0e-10_wp, 'moment')
      call check_close(failure, output(run, run%start, 'clamp.f3'), 0.8_wp*19.62_wp, 1.0e-10_wp, 'force along the axis')
      call check_below(failure, output(run, run%start, 'clamp.m3'), 1.0e-10_wp, 'moment about the axis')
      ! The ground as the second body: the opposite.
      call run_text(body//'&joint name = "clamp", type = "fixed", body_1 = "rod", body_2 = "ground", '// &
                    'point = 0.3, 0.0, 0.0, axis = 0.0, 3.0, 4.0 /', 0.1_wp, 1.0e-8_wp, run, failure)
      if (allocated(failure)) return
      call check_close(failure, output(run, run%start, 'clamp.fz'), -19.62_wp, 1.0e-10_wp, 'force on the ground')
      call check_close(failure, output(run, run%start, 'clamp.mx'), -19.62_wp*1.5_wp, 1.0e-10_wp, 'moment on the ground')
   end subroutine clamp_moment

   subroutine slider_crank(failure)
      character(:), allocatable, intent(inout) :: failure
      character(:), allocatable :: text
      type(run_t) :: run
      real(wp), parameter :: t = 0.73_wp

      call run_file('slider_crank', t, 1.0e-9_wp, run, failure)
      if (allocated(failure)) return
      call check_close(failure, entry_of(run, run%at, 'slider.x'), &
                       0.1_wp*cos(10.0_wp*t) + sqrt(0.09_wp - 0.01_wp*sin(10.0_wp*t)**2), 1.0e-11_wp, 'slider')
      call check(failure, run%report%freedoms == 0, 'a driven crank leaves no freedom')
      call run%model%note(text)
      call check(failure, text == '', 'nothing to warn of')
   end subroutine slider_crank

   subroutine n_four_bar(failure)
      character(:), allocatable, intent(inout) :: failure

      call follow_cranks('n_four_bar2', 2, 10.0_wp, failure)
      ! Once round, past both positions in which the degrees of freedom jump to 41.
      call follow_cranks('n_four_bar40', 40, 2.5_wp, failure)
   end subroutine n_four_bar

   !> All cranks share one angle a from the vertical: (N + 1)/3 + N of inertia, V = ((N + 1)/2 + N) g cos a.
   subroutine follow_cranks(name, windows, t_end, failure)
      character(*), intent(in) :: name
      integer, intent(in) :: windows
      real(wp), intent(in) :: t_end
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: run
      real(wp) :: k(4), a, energy, rate, h
      integer :: i
      integer, parameter :: steps = 200000

      call run_file(name, t_end, 1.0e-8_wp, run, failure)
      if (allocated(failure)) return
      h = t_end/steps
      a = 0.0_wp
      rate = 1.0_wp
      ! Stoermer and Verlet would do; Runge and Kutta of order four for a'' = c sin a.
      do i = 1, steps
         k(1) = second(a)
         k(2) = second(a + 0.5_wp*h*rate)
         k(3) = second(a + 0.5_wp*h*rate + 0.25_wp*h**2*k(1))
         k(4) = second(a + h*rate + 0.5_wp*h**2*k(2))
         a = a + h*rate + h**2*(k(1) + k(2) + k(3))/6.0_wp
         rate = rate + h*(k(1) + 2.0_wp*k(2) + 2.0_wp*k(3) + k(4))/6.0_wp
      end do
      call check_close(failure, output(run, run%at, 'B0.x'), sin(a), 1.0e-5_wp, 'x of B0')
      call check_close(failure, output(run, run%at, 'B0.y'), cos(a), 1.0e-5_wp, 'y of B0')
      call check_below(failure, violation(run), 1.0e-12_wp, 'violation')
      energy = run%model%energy(run%at) - run%model%energy(run%start)
      call check_below(failure, energy, 1.0e-3_wp, 'energy')

   contains

      pure real(wp) function second(angle)
         real(wp), intent(in) :: angle

         second = (0.5_wp*(windows + 1) + windows)/((windows + 1)/3.0_wp + windows)*9.81_wp*sin(angle)
      end function second

   end subroutine follow_cranks

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
      call expect('&gravity /'//lf//'&body name = "rod'//rod//'0,0,0, to = 1,0,0 /'//lf//pin('hinge', 'ground', 'rod', '0,0,0')// &
                  '&point_mass name = "road", mass = 1, position = 0,2,0 /'//lf// &
                  '&joint name = "slide", type = "prismatic", body_2 = "road", point = 0,2,0, axis = 1,0,0 /'//lf, 7, &
                  '3 of slide'//lf// &
                  'slide: three rotations are asked of road, which is a point mass and has none: they are ignored', &
                  'of freedom')

   contains

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
      end subroutine expect

   end subroutine words_of_redundancy

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

   subroutine andrews(failure)
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: run
      class(constrained_ode_t), allocatable :: ode
      type(error_t), allocatable :: error
      real(wp), allocatable :: rate(:), y(:)
      integer :: info

      call run_file('andrews', 0.03_wp, 1.0e-10_wp, run, failure)
      if (allocated(failure)) return
      call check_close(failure, entry_of(run, run%at, 'K1.angle'), 15.81077119629904_wp, 1.0e-7_wp, 'beta')
      call check_close(failure, entry_of(run, run%at, 'K2.angle') - entry_of(run, run%at, 'K1.angle'), -15.75637105984298_wp, &
                       1.0e-7_wp, 'Theta')
      call check_close(failure, entry_of(run, run%at, 'K7.angle'), 1.048080741042263_wp, 1.0e-7_wp, 'epsilon')
      call check_close(failure, output(run, run%start, 'E3.fx'), 98.5668703962410896_wp, 1.0e-7_wp, 'first multiplier')
      call check_close(failure, output(run, run%start, 'E3.fy'), -6.12268834425566265_wp, 1.0e-7_wp, 'second multiplier')
      call new_constrained_ode(ode, run%model, run%settings%methods(1)%method, error)
      allocate (rate(ode%size()), y(ode%size()))
      call ode%pack(run%start, y)
      call ode%rhs(0.0_wp, y, rate, info)
      call check_close(failure, rate(run%model%n_x + 3), 14222.4439199541138_wp, 1.0e-5_wp, 'acceleration of beta')
      call check_close(failure, rate(run%model%n_x + 6) - rate(run%model%n_x + 3), -10666.8329399655854_wp, 1.0e-5_wp, &
                       'acceleration of Theta')
   end subroutine andrews

   subroutine rolling_disc(failure)
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: run
      real(wp) :: w, radius
      real(wp), parameter :: angle = acos(-1.0_wp)/3.0_wp

      call run_file('rolling_disc', 3.0_wp, 1.0e-9_wp, run, failure)
      if (allocated(failure)) return
      call check(failure, run%model%n_phi == 1 .and. run%model%c == 3, 'one constraint is holonomic, two are not')
      call check_close(failure, entry_of(run, run%at, 'disc.z'), 0.5_wp*sin(angle), 1.0e-8_wp, 'the tilt stays')
      ! The center goes round a circle at 2 rad/s.
      w = entry_of(run, run%start, 'disc.wz')
      radius = 0.25_wp*abs(w)
      call check_close(failure, entry_of(run, run%at, 'disc.vx'), -0.5_wp*abs(w)*sin(6.0_wp), 1.0e-7_wp, 'vx')
      call check_close(failure, entry_of(run, run%at, 'disc.vy'), 0.5_wp*abs(w)*cos(6.0_wp), 1.0e-7_wp, 'vy')
      call check_close(failure, entry_of(run, run%at, 'disc.y'), radius*sin(6.0_wp), 1.0e-7_wp, 'y')
      ! What carries it: the weight.
      call check_close(failure, output(run, run%at, 'contact.fz'), 9.81_wp, 1.0e-6_wp, 'weight')
   end subroutine rolling_disc

   subroutine governor(failure)
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: run

      call run_file('governor', 1.0_wp, 1.0e-9_wp, run, failure)
      if (allocated(failure)) return
      call check_close(failure, momentum(run%at), momentum(run%start), 1.0e-7_wp, 'angular momentum about the shaft')
      call check(failure, run%model%energy(run%at) < run%model%energy(run%start), 'the damper takes energy')
      call check_close(failure, entry_of(run, run%at, 'arm1.z'), entry_of(run, run%at, 'arm2.z'), 1.0e-10_wp, 'symmetry')

   contains

      !> Of bodies of revolution and points; the arms are turned by their quaternions.
      real(wp) function momentum(at)
         use taut_rotation, only: matrix_of_quaternion
         type(state_t), intent(in) :: at
         real(wp) :: h(3), r(3, 3)
         integer :: i

         momentum = 0.0_wp
         do i = 1, size(run%model%bodies)
            associate (b => run%model%bodies(i))
               momentum = momentum + b%m*(at%x(b%before_x + 1)*at%v(b%before_v + 2) - at%x(b%before_x + 2)*at%v(b%before_v + 1))
               if (index(b%name, 'ball') == 1) cycle
               r = matrix_of_quaternion(at%x(b%before_x + 4:b%before_x + 7))
               h = matmul(r, matmul(b%j, at%v(b%before_v + 4:b%before_v + 6)))
               momentum = momentum + h(3)
            end associate
         end do
      end function momentum

   end subroutine governor

   subroutine spatial_slider_crank(failure)
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: run
      real(wp) :: a, y, z

      call run_file('spatial_slider_crank', 1.0_wp, 1.0e-8_wp, run, failure)
      if (allocated(failure)) return
      call check(failure, run%report%freedoms == 1, 'one degree of freedom')
      a = output(run, run%at, 'bearing.angle')
      y = 0.1_wp - 0.08_wp*sin(a)
      z = 0.12_wp + 0.08_wp*cos(a)
      call check_close(failure, entry_of(run, run%at, 'slider.x'), sqrt(0.09_wp - y**2 - z**2), 1.0e-10_wp, 'slider')
      call check_close(failure, output(run, run%at, 'guide.displacement'), entry_of(run, run%at, 'slider.x') - 0.2_wp, 1.0e-12_wp, &
                       'displacement of the guide')
      call check_below(failure, run%model%energy(run%at) - run%model%energy(run%start), 1.0e-5_wp, 'energy')
      call check_close(failure, entry_of(run, run%start, 'crank.wx'), 6.0_wp, 1.0e-12_wp, 'the crank is held')
   end subroutine spatial_slider_crank

   !> The same top as a rigid body of Sect. 3.4.1.
   subroutine heavy_top(failure)
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: run
      type(rigid_bodies_t) :: other
      type(rigid_body_t) :: body
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error

      call run_file('heavy_top', 0.5_wp, 1.0e-10_wp, run, failure)
      if (allocated(failure)) return
      ! About its tip, which stays at the origin.
      body%m = 15.0_wp
      body%s = [0.0_wp, 15.0_wp, 0.0_wp]
      body%j(1, 1) = 15.234375_wp
      body%j(2, 2) = 0.46875_wp
      body%j(3, 3) = 15.234375_wp
      call new_rigid_bodies(other, [body], [spherical_joint_t(1, 0)], [0.0_wp, 0.0_wp, -9.81_wp], error)
      at%x = [0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      at%v = [0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 150.0_wp, -4.61538_wp]
      options%rtol = 1.0e-10_wp
      options%atol = 1.0e-10_wp
      call simulate(other, at, 0.5_wp, result, error, options=options)
      call no_error(failure, error)
      call check_below(failure, maxval(abs(run%at%x(4:7) - at%x(4:7))), 1.0e-6_wp, 'orientation')
      call check_below(failure, maxval(abs(run%at%v(4:6) - at%v(4:6))), 1.0e-5_wp, 'angular velocity')
   end subroutine heavy_top

   subroutine held_crank(failure)
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: run
      type(state_t) :: given

      call run_file('four_bar', 0.1_wp, 1.0e-8_wp, run, failure)
      if (allocated(failure)) return
      given = run%model%start_state()
      call check_below(failure, maxval(abs(run%start%x(1:3) - given%x(1:3))), 0.0_wp, 'the crank was moved')
      call check_below(failure, maxval(abs(run%start%v(1:3) - given%v(1:3))), 1.0e-13_wp, 'the crank was sped up')
      call check(failure, index(run%report%text, 'rocker moved by') > 0, 'what was moved is told: '//run%report%text)
      run%at = run%start
      call check_below(failure, violation(run), 1.0e-12_wp, 'assembled')
   end subroutine held_crank

   !> The chain of a case, in the plane and in space.
   subroutine planar_and_spatial(failure)
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: plane, space
      character(*), parameter :: bodies = '&body name = "a", shape = "box", size = 1.0, 0.1, 0.2, mass = 2.0, angle = 0.3, '// &
                                 'position = 0.5, 0.1, 0.0, angle_rate = 1.0 /'//lf// &
                                 '&body name = "b", shape = "box", size = 0.7, 0.1, 0.2, mass = 1.0, angle = -0.4, '// &
                                 'position = 1.2, 0.3, 0.0 /'//lf//'&gravity acceleration = 0.0, -9.81, 0.0 /'//lf// &
                                 '&joint name = "j1", type = "revolute", body_2 = "a", point = 3*0.0, axis = 0.0, 0.0, '// &
                                          '1.0 /'//lf// &
                                 '&joint name = "j2", type = "prismatic", body_1 = "a", body_2 = "b", '// &
                                 'point = 1.0, 0.2, 0.0, axis = 1.0, 0.5, 0.0 /'//lf// &
                                 '&spring name = "s", body_1 = "a", body_2 = "b", stiffness = 50.0 /'//lf// &
                                 '&spring name = "t", joint = "j1", stiffness = 3.0, damping = 0.1, free_angle = 0.5 /'//lf// &
                                 '&force name = "f", body = "b", value = 1.0, 0.5, 0.0, point = 1.3, 0.1, 0.0, '// &
                                 'follow = .true. /'//lf

      call run_text(bodies//'&mechanism planar = .true. /', 1.0_wp, 1.0e-10_wp, plane, failure)
      if (allocated(failure)) return
      call run_text(bodies, 1.0_wp, 1.0e-10_wp, space, failure)
      if (allocated(failure)) return
      call check(failure, plane%model%n == 6 .and. space%model%n == 12, 'three and six velocities each')
      call check_close(failure, entry_of(plane, plane%at, 'b.x'), entry_of(space, space%at, 'b.x'), 1.0e-7_wp, 'x')
      call check_close(failure, entry_of(plane, plane%at, 'b.y'), entry_of(space, space%at, 'b.y'), 1.0e-7_wp, 'y')
      call check_close(failure, entry_of(plane, plane%at, 'b.wz'), entry_of(space, space%at, 'b.wz'), 1.0e-7_wp, 'w')
      call check_close(failure, output(plane, plane%at, 'j2.fx'), output(space, space%at, 'j2.fx'), 1.0e-6_wp, 'reaction')
      call check_close(failure, output(plane, plane%at, 'j2.mz'), output(space, space%at, 'j2.mz'), 1.0e-6_wp, 'moment')
   end subroutine planar_and_spatial

   subroutine distance_and_rod(failure)
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: distance, rod
      character(*), parameter :: mass = '&gravity /'//lf//'&point_mass name = "m", mass = 1.5, position = 0.6, 0.0, -0.8, '// &
                                 'velocity = 0.0, 2.0, 0.0 /'//lf

      call run_text(mass//'&joint name = "d", type = "distance", body_2 = "m", point_1 = 0.0, 0.0, 0.0 /', 2.0_wp, 1.0e-10_wp, &
                    distance, failure)
      if (allocated(failure)) return
      call run_text(mass//'&body name = "rod", shape = "rod", thickness = 0.5, mass = 1e-5, from = 0.0, 0.0, 0.0, to = '// &
               '0.6, 0.0, -0.8, '// &
                    'velocity = 0.0, 1.0, 0.0, angular_velocity = 1.6, 0.0, 1.2 /'//lf// &
                    '&joint name = "s1", type = "spherical", body_2 = "rod", point = 0.0, 0.0, 0.0 /'//lf// &
                    '&joint name = "s2", type = "spherical", body_1 = "rod", body_2 = "m" /', 2.0_wp, 1.0e-10_wp, rod, failure)
      if (allocated(failure)) return
      call check_below(failure, maxval(abs(distance%at%x(1:3) - rod%at%x(1:3))), 2.0e-5_wp, 'position')
      call check_below(failure, maxval(abs(distance%at%v(1:3) - rod%at%v(1:3))), 2.0e-5_wp, 'velocity')
   end subroutine distance_and_rod

   subroutine equal_orientations(failure)
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: one, other
      character(*), parameter :: before = '&gravity /'//lf//'&body name = "b", mass = 1.0, inertia = 0.3, 0.4, 0.5, 0.05, '// &
               '0.02, 0.01, '// &
                                 'position = 0.5, 0.2, 0.1, angular_velocity = 1.0, 2.0, 3.0, ', after = ' /'//lf// &
                                 '&joint name = "j", type = "universal", body_2 = "b", point = 0.0, 0.0, 0.0, '// &
                                 'axis_1 = 1.0, 0.0, 0.0, axis_2 = 0.0, 1.0, 0.0 /'

      call run_text(before//'quaternion = 0.5, 0.5, 0.5, 0.5'//after, 1.0_wp, 1.0e-10_wp, one, failure)
      if (allocated(failure)) return
      call run_text(before//'quaternion = -1.0, -1.0, -1.0, -1.0'//after, 1.0_wp, 1.0e-10_wp, other, failure)
      if (allocated(failure)) return
      call check_below(failure, maxval(abs(one%at%x(1:3) - other%at%x(1:3))), 1.0e-8_wp, 'position')
      call check_below(failure, maxval(abs(one%at%v - other%at%v)), 1.0e-7_wp, 'velocity')
      ! A third of a turn about (1, 1, 1).
      call run_text(before//'orientation = 1.2091995761561452, 1.2091995761561452, 1.2091995761561452'//after, 1.0_wp, 1.0e-10_wp, &
                    other, failure)
      if (allocated(failure)) return
      call check_below(failure, maxval(abs(one%at%v - other%at%v)), 1.0e-7_wp, 'velocity from a rotation vector')
   end subroutine equal_orientations

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

   !> A mass on a rod of 1e-8 kg that starts level is a pendulum of 1 m, whose quarter period is K(1/sqrt 2) sqrt(l/g); without
   !! redundant rows every pivot above round-off counts.
   subroutine mass_ratio(failure)
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: run
      character, parameter :: nl = new_line('a')

      call run_text('&gravity /'//nl//'&body name = "rod", shape = "rod", mass = 1e-8, thickness = 0.01, from = 0.0, 0.0, 0.0, '// &
                    'to = 1.0, 0.0, 0.0 /'//nl//'&point_mass name = "bob", mass = 1.0, position = 1.0, 0.0, 0.0 /'//nl// &
                    '&joint name = "hinge", type = "revolute", body_2 = "rod", point = 0.0, 0.0, 0.0, axis = 0.0, 1.0, 0.0 /'// &
                    nl//'&joint name = "end", type = "spherical", body_1 = "rod", body_2 = "bob", point = 1.0, 0.0, 0.0 /'//nl// &
                    '&method name = "present", solver = "banded", rcond = 1e-14 /', 1.85407467730137_wp/sqrt(9.81_wp), &
                    1.0e-8_wp, run, failure)
      if (allocated(failure)) return
      call check(failure, run%report%rank == 8, 'rank '//to_text(run%report%rank))
      call check_close(failure, entry_of(run, run%at, 'bob.x'), 0.0_wp, 1.0e-6_wp, 'at the bottom after a quarter period')
      call check_close(failure, entry_of(run, run%at, 'bob.z'), -1.0_wp, 1.0e-6_wp, 'at the bottom')
      call check_below(failure, violation(run), 1.0e-12_wp, 'violation')
   end subroutine mass_ratio

   !> A body that turns a thousand times and tumbles: what the tolerance lets go of per radian is all that is lost.
   subroutine fast_spin(failure)
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: run
      real(wp), parameter :: tolerances(2) = [1.0e-7_wp, 1.0e-9_wp], moments(3) = [0.1_wp, 0.2_wp, 0.25_wp]
      real(wp) :: angle
      integer :: i

      angle = 300.0_wp*20.0_wp
      do i = 1, 2
         call run_text('&body name = "b", mass = 1.0, inertia = 0.1, 0.2, 0.25, angular_velocity = 3.0, 300.0, 0.01 /', &
                       20.0_wp, tolerances(i), run, failure)
         if (allocated(failure)) return
         call check_close(failure, norm2(run%at%x(4:7)), 1.0_wp, 1.0e-15_wp, 'length of the quaternion')
         call check_below(failure, run%model%energy(run%at)/run%model%energy(run%start) - 1.0_wp, angle*tolerances(i), 'energy')
         call check_below(failure, norm2(moments*run%at%v(4:6))/norm2(moments*run%start%v(4:6)) - 1.0_wp, angle*tolerances(i), &
                          'angular momentum')
      end do
   end subroutine fast_spin

   subroutine pendulum_modes(failure)
      character(:), allocatable, intent(inout) :: failure
      type(namelist_file_t) :: file
      type(static_t) :: case
      type(error_t), allocatable :: error
      real(wp), parameter :: pi = acos(-1.0_wp)

      call file%load(folder//'pendulum_modes.nml', error)
      call solve_static(file, case, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      call check_close(failure, case%at%x(5), -1.5_wp, 1.0e-9_wp, 'the lower rod hangs')
      call check(failure, size(case%modes%frequency) == 2, 'two modes')
      call check_close(failure, (2.0_wp*pi*case%modes%frequency(1))**2, 9.81_wp*(3.0_wp - 6.0_wp/sqrt(7.0_wp)), 1.0e-5_wp, 'first')
      call check_close(failure, (2.0_wp*pi*case%modes%frequency(2))**2, 9.81_wp*(3.0_wp + 6.0_wp/sqrt(7.0_wp)), 1.0e-5_wp, 'second')
   end subroutine pendulum_modes

   subroutine spring_equilibrium(failure)
      character(:), allocatable, intent(inout) :: failure
      type(namelist_file_t) :: file
      type(static_t) :: case
      type(error_t), allocatable :: error

      call load('&gravity /'//lf//'&analysis kind = "equilibrium" /'//lf//'&point_mass name = "m", mass = 2.0, '// &
                'position = 0.0, 0.0, -1.0 /'//lf//'&joint name = "guide", type = "in-line", body_2 = "m", axis = 0.0, '// &
                         '0.0, 1.0 /'// &
                lf//'&spring name = "s", point_1 = 0.0, 0.0, 0.0, body_2 = "m", stiffness = 100.0, free_length = 0.7, '// &
                'preload = 1.0 /', file, error)
      call solve_static(file, case, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      ! 1 + 100 (l - 0.7) = 19.62.
      call check_close(failure, case%at%x(3), -0.8862_wp, 1.0e-9_wp, 'where it hangs')
   end subroutine spring_equilibrium

   !> The paper's swing, its mass on the node and not beside it, its load by functions.
   subroutine swing(failure)
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: run
      type(swing_beam_t) :: other
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp), parameter :: t_end = 0.01_wp

      call run_file('swing', t_end, 1.0e-6_wp, run, failure)
      if (allocated(failure)) return
      call new_swing_beam(other, swing_data_t(), error)
      call no_error(failure, error)
      at = other%reference_state()
      options%rtol = 1.0e-6_wp
      options%atol = 1.0e-6_wp
      call simulate(other, at, t_end, result, error, options=options)
      call no_error(failure, error)
      if (allocated(failure)) return
      call check(failure, maxval(abs(at%v)) > 1.0e-3_wp, 'it moves')
      call check_below(failure, maxval(abs(run%at%x(:35) - at%x)), 1.0e-6_wp, 'positions of the nodes')
      call check_below(failure, maxval(abs([entry_of(run, run%at, 'middle.vx') - at%v(13)])), 1.0e-4_wp, 'velocity of the middle')
   end subroutine swing

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

   !> The pendulum passes the bottom at a quarter of its period; a rod's period has the closed form 4 K(1/sqrt 2) sqrt(2 L/(3 g)).
   subroutine event_times(failure)
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: run
      type(model_events_t) :: events
      type(integration_result_t) :: result
      type(error_t), allocatable :: error

      call run_file('simple_pendulum', 0.0_wp, 1.0e-11_wp, run, failure)
      if (allocated(failure)) return
      call events%init(run%model)
      run%at = run%start
      call simulate(run%model, run%at, 1.0_wp, result, error, run%settings%methods(1)%method, run%settings%options, events=events)
      call no_error(failure, error)
      if (.not. allocated(failure)) call check(failure, size(result%events) == 1, to_text(size(result%events))//' events')
      if (allocated(failure)) return
      ! K(1/sqrt 2) = 1.85407467730137.
      call check_close(failure, result%events(1)%t, 1.85407467730137_wp*sqrt(2.0_wp/(3.0_wp*9.81_wp)), 1.0e-8_wp, 'time')
      call check(failure, run%model%event_name(1) == 'bottom', 'name')
   end subroutine event_times

   !> A sleigh that turns at 2 rad/s: its edge point runs round a circle of radius v/w.
   subroutine knife_edge(failure)
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: run

      call run_text('&mechanism planar = .true. /'//lf//'&body name = "s", mass = 1.0, inertia = 0.5, velocity = 3.0, 0.0, '// &
                    'angle_rate = 2.0 /'//lf//'&knife_edge name = "edge", body = "s", across = 0.0, 1.0 /', 1.0_wp, &
                             1.0e-10_wp, run, &
                    failure)
      if (allocated(failure)) return
      call check_close(failure, run%at%x(1), 1.5_wp*sin(2.0_wp), 1.0e-8_wp, 'x')
      call check_close(failure, run%at%x(2), 1.5_wp*(1.0_wp - cos(2.0_wp)), 1.0e-8_wp, 'y')
      ! The edge carries m v w.
      call check_close(failure, output(run, run%start, 'edge.fy'), 6.0_wp, 1.0e-10_wp, 'its force')
   end subroutine knife_edge

   subroutine faulty(failure)
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
         type(run_t) :: run

         if (allocated(failure)) return
         call load(text, file, error)
         if (.not. allocated(error)) call read_mechanism(file, run%model, run%start, run%settings, run%report, error)
         if (.not. allocated(error)) then
            call check(failure, .false., 'no complaint: '//complaint)
            return
         end if
         call check(failure, index(error%line(), complaint) > 0, 'wanted "'//complaint//'", got: '//error%line())
      end subroutine expect

   end subroutine faulty

end module test_mechanism_case
