!> Mechanisms from case files: motions and reactions in closed form, or as published.
module test_mechanism_motion
   use taut, only: constrained_ode_t, error_t, integration_result_t, simulate, state_t, wp
   use taut_constrained_method_choose, only: new_constrained_ode
   use taut_constrained_model_events, only: model_events_t
   use taut_error, only: to_text
   use test_case, only: lf
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   use mechanism_runs, only: entry_of, output, run_file, run_t, run_text, violation
   implicit none (type, external)
   private
   public :: collect_mechanism_motion

contains

   !> All tests of this module.
   function collect_mechanism_motion() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('reactions of a pendulum in closed form', pendulum_reactions), &
               new_test('moment of a clamp in closed form', clamp_moment), &
               new_test('slider of a driven crank in closed form', slider_crank), &
               new_test('N-four-bar through its singular positions', n_four_bar), &
               new_test('Andrews: published accelerations, forces and motion', andrews), &
               new_test('a disc rolls round a circle', rolling_disc), &
               new_test('the governor keeps its angular momentum', governor), &
               new_test('spatial slider-crank in closed form', spatial_slider_crank), &
               new_test('a four-bar is assembled with its crank held', held_crank), &
               new_test('a heavy mass on a rod of almost none', mass_ratio), &
               new_test('a fast spin lasts', fast_spin), &
               new_test('an angle passes its value', event_times), &
               new_test('a knife edge goes where it points', knife_edge)]
   end function collect_mechanism_motion

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

      call follow_cranks('n_four_bar2', 2, 10.0_wp, 1.0e-8_wp, 'dopri5', failure)
      ! Once round, past both positions in which the degrees of freedom jump to 41.
      call follow_cranks('n_four_bar40', 40, 2.5_wp, 1.0e-8_wp, 'dopri5', failure)
      ! Where the positions are singular, round-off is more than the tolerance of an implicit iteration.
      call follow_cranks('n_four_bar2', 2, 5.0_wp, 1.0e-10_wp, 'radau', failure)
   end subroutine n_four_bar

   !> All cranks share one angle a from the vertical: (N + 1)/3 + N of inertia, V = ((N + 1)/2 + N) g cos a.
   subroutine follow_cranks(name, windows, t_end, tolerance, integrator, failure)
      character(*), intent(in) :: name
      integer, intent(in) :: windows
      real(wp), intent(in) :: t_end, tolerance
      character(*), intent(in) :: integrator
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: run
      real(wp) :: k(4), a, energy, rate, h
      integer :: i
      integer, parameter :: steps = 200000

      call run_file(name, t_end, tolerance, run, failure, integrator)
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

end module test_mechanism_motion
