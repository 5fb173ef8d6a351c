!> Tests of the implicit integrator: order, stiffness, constraints of all kinds.
module test_radau
   use springs, only: new_spring, spring_t
   use systems, only: actuator, bead, driven_pivot, new_compound, new_coupler, new_particle, sleigh, sleigh_in_space
   use taut, only: block_diagonal_t, constrained_ode_t, error_t, integration_options_t, integration_result_t, &
                   mechanical_system_t, method_names, method_t, ode_system_t, integrator_t, rhs_cannot, rhs_ok, rhs_retry, &
                   sample_t, simulate, state_t, &
                   status_not_finite, status_reached_end, trajectory_t, wp
   use mechanism_runs, only: run_t, run_text
   use taut_constrained_implicit, only: implicit_form_t
   use taut_error, only: to_text
   use taut_linalg_lu_banded, only: banded_lu_t
   use taut_linalg_lu_choose, only: choose_lu
   use taut_ode_newton, only: newton_t
   use taut_ode_step_control, only: step_control_t
   use taut_ode_system, only: not_factorized
   use taut_model_pendulum, only: new_pendulum, pendulum_t
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_radau

   !> y' = -k (y - cos t) - sin t; y = cos t where it starts there.
   type, extends(ode_system_t) :: relaxation_t
      real(wp) :: k = 1.0_wp
      !> Not defined beyond this time.
      real(wp) :: last = huge(1.0_wp)
   contains
      procedure :: rhs => relaxation_rhs
   end type relaxation_t

   !> Two masses; the second one, if it has none, is not determined, and else is pulled by a cube root.
   type, extends(mechanical_system_t) :: loose_t
      real(wp) :: m = 1.0_wp
   contains
      procedure :: mass => loose_mass
      procedure :: force => loose_force
   end type loose_t

   real(wp), parameter :: g = 9.81_wp

contains

   !> All tests of this module.
   function collect_radau() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('the order of the solution', order_of_solution), &
               new_test('the order of dense output', order_of_dense), &
               new_test('L-stable', l_stable), &
               new_test('the order under constraints', order_under_constraints), &
               new_test('constraints of all kinds', all_constraints), &
               new_test('every method has an implicit form', every_method), &
               new_test('a stiff spring costs the same at any stiffness', stiff_spring), &
               new_test('a spring without its row gives the same motion', spring_without_row), &
               new_test('ringing above the tolerance is resolved', ringing), &
               new_test('damping of an elastic row', damped_row), &
               new_test('a step of a chain of springs costs the same for each of them', spring_chain), &
               new_test('a lattice of springs, whose band is wide', lattice), &
               new_test('a matrix that is too large is told', too_large), &
               new_test('what round-off is taken for', round_off_alone), &
               new_test('backwards in time', backwards), &
               new_test('a drive through a dead point', driven_dead_point), &
               new_test('what stops a step is named', named), &
               new_test('options that contradict', contradictions), &
               new_test('a right-hand side that ends', ends)]
   end function collect_radau

   !> An iteration that stalls has converged if round-off explains it, and if what is left is no more than the root of round-off.
   subroutine round_off_alone(failure)
      character(:), allocatable, intent(inout) :: failure
      type(newton_t) :: newton
      type(step_control_t) :: control
      logical :: converged

      control%rtol = 1.0e-6_wp
      call newton%begin(control, [1.0_wp])
      call newton%judge_round_off(0.5_wp, 0.5_wp, converged)
      call check(failure, converged, 'what round-off makes of the matrix')
      call newton%judge_round_off(0.5_wp, 0.1_wp, converged)
      call check(failure, .not. converged, 'more than round-off')
      call newton%judge_round_off(1.0e5_wp, 1.0e5_wp, converged)
      call check(failure, .not. converged, 'a tenth of the state is no round-off')
      control%rtol = 1.0e-12_wp
      call newton%begin(control, [1.0_wp])
      call newton%judge_round_off(1.0e3_wp, 1.0e3_wp, converged)
      call check(failure, converged, 'a billionth of the state, where equations are singular')
   end subroutine round_off_alone

   !> Masses on a chain of stiff springs, whatever their number: the band of the matrix is as wide, and as few columns tell K and D.
   subroutine spring_chain(failure)
      character(:), allocatable, intent(inout) :: failure
      integer, parameter :: masses(2) = [10, 200]
      type(implicit_form_t) :: form
      type(method_t) :: method
      type(run_t) :: run
      character(:), allocatable :: n
      integer :: i, iterations(2), width(2)

      do i = 1, 2
         n = to_text(masses(i))
         call run_text('&mechanism planar = .true. / &gravity /'//new_line('a')// &
                       '&point_mass name="p#" mass=0.1 position=0.1, 0.0 position_step=0.1, 0.0 repeat='//n//' /'//new_line('a')// &
                       '&spring name="s0" point_1=0.0, 0.0 body_2="p1" stiffness=1e6 /'//new_line('a')// &
                       '&spring name="s#" body_1="p#" body_2="p#+1" stiffness=1e6 repeat='//to_text(masses(i) - 1)//' /'// &
                       new_line('a')//'&integration integrator="radau" t_end=0.1 /'//new_line('a'), 0.1_wp, 1.0e-4_wp, run, failure)
         if (allocated(failure)) return
         call form%init(run%model, method)
         select type (lu => form%lu)
         type is (banded_lu_t)
            width(i) = lu%width
         class default
            call check(failure, .false., 'a chain is a band')
            return
         end select
         iterations(i) = run%result%newton_iterations
         call check(failure, size(form%coupling%column) <= 6*form%n_v, 'a mass is coupled with its neighbors alone')
         call check(failure, form%coupling%colors <= 8, 'K and D are found by a few differences')
      end do
      call check(failure, width(2) <= width(1), 'the band is no wider')
      call check(failure, iterations(2) <= 2*iterations(1), 'nor is there more to iterate')
   end subroutine spring_chain

   !> A cube of masses on springs moves as explicit steps say: it is factorized by UMFPACK where that is at hand.
   subroutine lattice(failure)
      character(:), allocatable, intent(inout) :: failure
      integer, parameter :: m = 8
      type(run_t) :: run(2)
      character(:), allocatable :: text
      integer :: i, j, k

      text = '&mechanism / &gravity acceleration=1.0, 2.0, -9.81 /'//new_line('a')
      do k = 1, m
         do j = 1, m
            text = text//'&point_mass name="'//line(j, k)//'#" mass=0.1 position=0.1, '//to_text(0.1_wp*j)//', '// &
                   to_text(-0.1_wp*k)//' position_step=0.1, 0.0, 0.0 repeat='//to_text(m)//' /'//new_line('a')// &
                   '&spring name="x'//line(j, k)//'#" body_1="'//line(j, k)//'#" body_2="'//line(j, k)//'#+1" stiffness=2e3 '// &
                   'repeat='//to_text(m - 1)//' /'//new_line('a')
            if (k == 1) then
               do i = 1, m
                  text = text//'&spring name="o'//line(j, i)//'" point_1='//to_text(0.1_wp*i)//', '//to_text(0.1_wp*j)// &
                         ', 0.0 body_2="'//line(j, k)//to_text(i)//'" stiffness=2e3 /'//new_line('a')
               end do
            end if
            if (j < m) call tie('y', line(j, k), line(j + 1, k))
            if (k < m) call tie('z', line(j, k), line(j, k + 1))
         end do
      end do
      call run_text(text//'&integration integrator="radau" t_end=0.05 rtol=1e-7 /'//new_line('a'), 0.05_wp, 1.0e-7_wp, run(1), &
                    failure)
      call run_text(text//'&integration t_end=0.05 rtol=1e-7 /'//new_line('a'), 0.05_wp, 1.0e-7_wp, run(2), failure)
      if (allocated(failure)) return
      call check_below(failure, maxval(abs(run(1)%at%x - run(2)%at%x)), 1.0e-5_wp, 'both motions')

   contains

      function line(j, k) result(name)
         integer, intent(in) :: j, k
         character(:), allocatable :: name

         name = 'p'//to_text(j)//'x'//to_text(k)//'x'
      end function line

      subroutine tie(letter, one, other)
         character(*), intent(in) :: letter, one, other

         text = text//'&spring name="'//letter//one//'#" body_1="'//one//'#" body_2="'//other//'#" stiffness=2e3 repeat='// &
                to_text(m)//' /'//new_line('a')
      end subroutine tie

   end subroutine lattice

   !> Where a band has no room and UMFPACK is not there, that is the reason.
   subroutine too_large(failure)
      character(:), allocatable, intent(inout) :: failure
      type(implicit_form_t) :: form
      type(relaxation_t) :: ode
      type(method_t) :: method
      character(:), allocatable :: text
      integer :: i, info
      integer, parameter :: many = 40000

      call form%init(new_spring(1.0_wp), method)
      deallocate (form%lu)
      call choose_lu(many, [(i, i=1, many), (1, i=2, many), (i, i=2, many)], [(i, i=1, many), (i, i=2, many), (1, i=2, many)], &
                     form%lu, ['none.so'])
      call form%factorize(ode, 1, (1.0_wp, 0.0_wp), info)
      call check(failure, info == rhs_cannot, 'it is not possible')
      call form%explain(not_factorized, 1, text)
      call check(failure, index(text, '40000 equations') > 0 .and. index(text, 'libumfpack') > 0, 'what is missing: '//text)
   end subroutine too_large

   subroutine relaxation_rhs(self, t, y, dydt, info)
      class(relaxation_t), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(out), contiguous :: dydt(:)
      integer, intent(out) :: info

      info = merge(rhs_ok, rhs_retry, t <= self%last)
      dydt = [-self%k*(y(1) - cos(t)) - sin(t)]
   end subroutine relaxation_rhs

   function radau(rtol) result(options)
      real(wp), intent(in) :: rtol
      type(integration_options_t) :: options

      options = integration_options_t(integrator='radau', rtol=rtol, atol=1.0e-3_wp*rtol)
   end function radau

   !> An integration of the relaxation problem with fixed steps.
   subroutine relax(k, h, t_end, y, failure, trajectory, output_dt)
      real(wp), intent(in) :: k, h, t_end
      real(wp), intent(out) :: y(1)
      character(:), allocatable, intent(inout) :: failure
      type(trajectory_t), intent(inout), optional :: trajectory
      real(wp), intent(in), optional :: output_dt
      type(relaxation_t) :: problem
      type(integrator_t) :: integrator
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      real(wp) :: t

      problem%k = k
      options = integration_options_t(integrator='radau', step_control='fixed', first_step=h, rtol=1.0e-12_wp, atol=1.0e-12_wp)
      if (present(output_dt)) options%output_dt = output_dt
      call integrator%init(1, options, error)
      call no_error(failure, error)
      t = 0.0_wp
      y = [1.0_wp]
      call integrator%run(problem, t, y, t_end, result, trajectory)
      call check(failure, result%status == status_reached_end, 'the end is reached')
   end subroutine relax

   subroutine order_of_solution(failure)
      character(:), allocatable, intent(inout) :: failure
      real(wp) :: e(2), y(1)
      integer :: i

      do i = 1, 2
         call relax(1.0_wp, 0.5_wp/2**i, 2.0_wp, y, failure)
         e(i) = abs(y(1) - cos(2.0_wp))
      end do
      call check_close(failure, log(e(1)/e(2))/log(2.0_wp), 5.0_wp, 0.3_wp, 'order')
   end subroutine order_of_solution

   subroutine order_of_dense(failure)
      character(:), allocatable, intent(inout) :: failure
      type(trajectory_t) :: trajectory
      real(wp) :: e(2), y(1)
      integer :: i

      do i = 1, 2
         trajectory = trajectory_t()
         call relax(1.0_wp, 0.5_wp/2**i, 2.0_wp, y, failure, trajectory, 0.03_wp)
         associate (n => trajectory%points)
            e(i) = maxval(abs(trajectory%y(1, :n) - cos(trajectory%t(:n))))
         end associate
      end do
      call check_close(failure, log(e(1)/e(2))/log(2.0_wp), 4.0_wp, 0.4_wp, 'order')
   end subroutine order_of_dense

   subroutine l_stable(failure)
      character(:), allocatable, intent(inout) :: failure
      type(relaxation_t) :: problem
      type(integrator_t) :: integrator
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      real(wp) :: t, y(1)

      ! From beside the slow motion: a transient of 1e-8 s that has to be over at once.
      problem%k = 1.0e8_wp
      call integrator%init(1, radau(1.0e-7_wp), error)
      call no_error(failure, error)
      t = 0.0_wp
      y = [1.5_wp]
      call integrator%run(problem, t, y, 10.0_wp, result)
      call check(failure, result%status == status_reached_end, 'the end is reached')
      call check_close(failure, y(1), cos(10.0_wp), 1.0e-7_wp, 'the slow motion')
      call check(failure, result%steps < 150, 'few steps')
      call check(failure, result%jacobians < result%steps/2 .and. result%jacobians > 0, 'fewer Jacobians')
   end subroutine l_stable

   !> The pendulum with fixed steps: errors of position, velocity and multiplier against much shorter ones.
   subroutine order_under_constraints(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: pendulum
      type(error_t), allocatable :: error
      real(wp) :: e(3, 2), exact(5), now(5)
      integer :: i

      call new_pendulum(pendulum, 1.0_wp, 1.0_wp, g, 1, error)
      call no_error(failure, error)
      call swing(integration_options_t(rtol=1.0e-12_wp, atol=1.0e-13_wp), exact)
      do i = 1, 2
         call swing(integration_options_t(integrator='radau', step_control='fixed', first_step=0.04_wp/2**i, rtol=1.0e-10_wp, &
                                          atol=1.0e-10_wp), now)
         e(:, i) = [norm2(now(:2) - exact(:2)), norm2(now(3:4) - exact(3:4)), abs(now(5) - exact(5))]
         call check_below(failure, abs(norm2(now(:2)) - 1.0_wp), 1.0e-12_wp, 'length')
      end do
      do i = 1, 3
         call check_close(failure, log(e(i, 1)/e(i, 2))/log(2.0_wp), 5.0_wp, 0.4_wp, 'order')
      end do

   contains

      subroutine swing(options, found)
         type(integration_options_t), intent(in) :: options
         real(wp), intent(out) :: found(5)
         type(state_t) :: at
         type(integration_result_t) :: result
         class(constrained_ode_t), allocatable :: ode
         type(sample_t) :: s
         real(wp) :: y(4)
         integer :: info

         at%x = [1.0_wp, 0.0_wp]
         at%v = [0.0_wp, 0.0_wp]
         call simulate(pendulum, at, 1.0_wp, result, error, options=options, ode=ode)
         call no_error(failure, error)
         call ode%pack(at, y)
         call ode%sample(at%t, y, s, info)
         found = [y, s%lambda(1)]
      end subroutine swing

   end subroutine order_under_constraints

   !> Both integrators at tight tolerances, and compliance.
   subroutine compare(name, model, x, v, t_end, failure, w, method)
      character(*), intent(in) :: name
      class(mechanical_system_t), intent(in) :: model
      real(wp), intent(in) :: x(:), v(:), t_end
      character(:), allocatable, intent(inout) :: failure
      real(wp), intent(in), optional :: w(:)
      type(method_t), intent(in), optional :: method
      type(state_t) :: at, reference
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      class(constrained_ode_t), allocatable :: ode
      type(sample_t) :: s
      real(wp), allocatable :: y(:)
      integer :: info

      at%x = x
      at%v = v
      at%w = [real(wp) ::]
      if (present(w)) at%w = w
      reference = at
      call simulate(model, reference, t_end, result, error, method, integration_options_t(rtol=1.0e-10_wp, atol=1.0e-12_wp))
      call simulate(model, at, t_end, result, error, method, radau(1.0e-9_wp), ode=ode)
      call no_error(failure, error)
      call check(failure, result%status == status_reached_end, name//': the end is reached')
      if (allocated(failure)) return
      call check_below(failure, maxval(abs([at%x, at%v, at%w] - [reference%x, reference%v, reference%w])), 1.0e-6_wp, &
                       name//': the motion')
      if (present(method) .or. model%c == 0) return
      allocate (y(ode%size()))
      call ode%pack(at, y)
      call ode%sample(at%t, y, s, info)
      call check_below(failure, max(s%phi, s%phidot, s%phiddot), 1.0e-11_wp, name//': the constraints')
   end subroutine compare

   subroutine all_constraints(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: pendulum
      type(error_t), allocatable :: error

      call compare('rheonomic', new_particle(bead), [1.0_wp, 0.0_wp], [0.0_wp, 1.0_wp], 1.0_wp, failure)
      call compare('driven', new_particle(driven_pivot, rate=5.0_wp, amplitude=0.2_wp), [1.0_wp, 0.0_wp], [0.0_wp, 0.0_wp], &
                   2.0_wp, failure)
      call compare('non-holonomic', new_particle(sleigh), [0.0_wp, 0.0_wp, 0.3_wp], [1.0_wp, 0.3_wp, 0.4_wp], 2.0_wp, failure)
      call compare('mixed', new_particle(sleigh_in_space), [0.0_wp, 0.0_wp, 0.3_wp, 0.0_wp], [1.0_wp, 0.3_wp, 0.4_wp, 0.0_wp], &
                   2.0_wp, failure)
      call compare('coordinates of their own', new_compound(), [0.3_wp, -0.4_wp, 0.8_wp, 0.6_wp], [0.0_wp, 0.0_wp, 0.0_wp], &
                   2.0_wp, failure)
      call compare('redundant at times', new_coupler(3), [0.6_wp, -0.8_wp, 0.0_wp], [0.0_wp, 0.0_wp, 0.0_wp], 2.0_wp, failure)
      call compare('other states', new_particle(actuator), [0.0_wp], [0.0_wp], 2.0_wp, failure, w=[3.0_wp])
      call new_pendulum(pendulum, 1.0_wp, 1.0_wp, g, 3, error)
      call compare('redundant', pendulum, [1.0_wp, 0.0_wp], [0.0_wp, 0.0_wp], 2.0_wp, failure)
   end subroutine all_constraints

   subroutine every_method(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: pendulum
      type(error_t), allocatable :: error
      type(method_t) :: method
      integer :: i

      call new_pendulum(pendulum, 1.0_wp, 1.0_wp, g, 1, error)
      do i = 1, size(method_names)
         method = method_t(name=method_names(i), stiffness=1.0e4_wp, damping=10.0_wp)
         call compare(trim(method%name), pendulum, [1.0_wp, 0.0_wp], [0.0_wp, 0.0_wp], 1.0_wp, failure, method=method)
      end do
      call compare('W = M', pendulum, [1.0_wp, 0.0_wp], [0.0_wp, 0.0_wp], 1.0_wp, failure, method=method_t(weight='mass'))
   end subroutine every_method

   !> One second of the spring's swing from the horizontal, released with the spring at its length.
   subroutine swing_spring(spring, options, at, result, failure)
      class(spring_t), intent(in) :: spring
      type(integration_options_t), intent(in) :: options
      type(state_t), intent(out) :: at
      type(integration_result_t), intent(out) :: result
      character(:), allocatable, intent(inout) :: failure
      type(error_t), allocatable :: error

      at%x = [1.0_wp, 0.0_wp]
      at%v = [0.0_wp, 0.0_wp]
      at%w = [real(wp) ::]
      call simulate(spring, at, 1.0_wp, result, error, options=options)
      call no_error(failure, error)
      call check(failure, result%status == status_reached_end, 'the end is reached')
   end subroutine swing_spring

   subroutine stiff_spring(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: pendulum
      type(state_t) :: at, rigid
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      integer :: i, steps(2)
      real(wp) :: k

      call new_pendulum(pendulum, 1.0_wp, 1.0_wp, g, 1, error)
      rigid%x = [1.0_wp, 0.0_wp]
      rigid%v = [0.0_wp, 0.0_wp]
      call simulate(pendulum, rigid, 1.0_wp, result, error, options=integration_options_t(rtol=1.0e-12_wp, atol=1.0e-13_wp))
      do i = 1, 2
         k = 1.0e8_wp
         if (i == 2) k = 1.0e10_wp
         call swing_spring(new_spring(k), radau(1.0e-6_wp), at, result, failure)
         steps(i) = result%steps
         ! The rod's tension, 3 m g sin(angle below the horizontal), over k: the spring's stretch where it does not ring.
         call check_close(failure, norm2(at%x) - 1.0_wp, 3.0_wp*g*abs(at%x(2))/k, 0.05_wp*3.0_wp*g/k, 'stretch')
         call check_below(failure, norm2(at%x - rigid%x), 1.0e-6_wp, 'distance from the rod''s motion')
         call check(failure, result%jacobians <= 0.15_wp*result%steps, 'few Jacobians')
      end do
      call check(failure, steps(1) <= 100, 'few steps')
      call check(failure, abs(steps(1) - steps(2)) <= 0.1_wp*steps(1), 'as many for both')
   end subroutine stiff_spring

   subroutine spring_without_row(failure)
      character(:), allocatable, intent(inout) :: failure
      type(spring_t) :: spring
      type(state_t) :: at, with_row
      type(integration_result_t) :: result

      spring = new_spring(1.0e6_wp)
      call swing_spring(spring, radau(1.0e-7_wp), with_row, result, failure)
      spring%n_elastic = 0
      call swing_spring(spring, radau(1.0e-7_wp), at, result, failure)
      if (allocated(failure)) return
      call check_below(failure, norm2(at%x - with_row%x), 3.0e-6_wp, 'difference')
   end subroutine spring_without_row

   !> A slider-crank whose rod is as long as its crank, driven: the slider goes straight through the crank's pivot, where it could
   !! stay, three times. No freedom is left, so that steps are judged by their work.
   subroutine driven_dead_point(failure)
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: run
      character(*), parameter :: lf = new_line('a'), x = '0.8', y = '0.6'
      integer :: i

      do i = 4, 10, 3
         call run_text('&mechanism planar = .true. /'//lf//'&function name = "turning" kind = "ramp" rate = 1.7 /'//lf// &
                       '&body name = "crank" shape = "rod" mass = 1.0 from = 0.0, 0.0 to = '//x//', '//y//' /'//lf// &
                       '&body name = "bar" shape = "rod" mass = 1.0 from = '//x//', '//y//' to = 1.6, 0.0 /'//lf// &
                       '&joint name = "A" type = "revolute" body_2 = "crank" point = 0.0, 0.0 drive_angle = "turning" /'//lf// &
                       '&joint name = "B" type = "revolute" body_1 = "crank" body_2 = "bar" point = '//x//', '//y//' /'//lf// &
                       '&joint name = "C" type = "in-line" body_2 = "bar" point = 1.6, 0.0 axis = 1.0, 0.0 /'//lf// &
                       '&integration integrator = "radau" t_end = 5.0 /'//lf, 5.0_wp, 10.0_wp**(-i), run, failure)
         if (allocated(failure)) return
         call check(failure, run%result%status == status_reached_end, 'it goes on')
         ! The center of the rod is three halves of the crank's reach away.
         call check_close(failure, run%at%x(4), 1.5_wp*cos(atan2(0.6_wp, 0.8_wp) + 8.5_wp), 1.0e-8_wp, 'where the rod is')
      end do
   end subroutine driven_dead_point

   !> A soft spring rings with an amplitude above the tolerance: both integrators agree on it.
   subroutine ringing(failure)
      character(:), allocatable, intent(inout) :: failure
      type(state_t) :: at, reference
      type(integration_result_t) :: result

      call swing_spring(new_spring(1.0e4_wp), radau(1.0e-8_wp), at, result, failure)
      call swing_spring(new_spring(1.0e4_wp), integration_options_t(rtol=1.0e-11_wp, atol=1.0e-13_wp), reference, result, failure)
      if (allocated(failure)) return
      call check_below(failure, norm2(at%x - reference%x), 1.0e-6_wp, 'position')
      call check_below(failure, norm2(at%v - reference%v), 1.0e-4_wp, 'velocity')
   end subroutine ringing

   subroutine damped_row(failure)
      character(:), allocatable, intent(inout) :: failure
      type(spring_t) :: spring
      type(state_t) :: at, reference
      type(integration_result_t) :: result

      spring = new_spring(1.0e4_wp)
      spring%tau = 2.0e-3_wp
      spring%elastic_damping = [spring%tau]
      call swing_spring(spring, radau(1.0e-8_wp), at, result, failure)
      call check(failure, result%steps < 1500, 'damped ringing costs less')
      call swing_spring(spring, integration_options_t(rtol=1.0e-11_wp, atol=1.0e-13_wp), reference, result, failure)
      if (allocated(failure)) return
      call check_below(failure, norm2(at%x - reference%x), 1.0e-6_wp, 'position')
      call check_below(failure, norm2(at%v - reference%v), 1.0e-5_wp, 'velocity')
   end subroutine damped_row

   subroutine loose_mass(self, at, m)
      class(loose_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m

      call m%set_diagonal([1.0_wp, self%m])
      associate (unused_state => at)
      end associate
   end subroutine loose_mass

   subroutine loose_force(self, at, value)
      class(loose_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = [0.0_wp, -1.0e6_wp*sign(abs(at%x(2))**(1.0_wp/3.0_wp), at%x(2))]
      associate (unused_system => self)
      end associate
   end subroutine loose_force

   subroutine named(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=20), parameter :: integrators(2) = [character(len=20) :: 'radau', 'generalized-alpha']
      integer :: i

      do i = 1, 2
         call stops(0.0_wp, integrators(i), 'singular at velocity 2')
         call stops(1.0_wp, integrators(i), 'largest correction is that of coordinate 2')
      end do

   contains

      subroutine stops(m, integrator, words)
         real(wp), intent(in) :: m
         character(*), intent(in) :: integrator, words
         type(loose_t) :: model
         type(state_t) :: at
         type(integration_result_t) :: result
         type(error_t), allocatable :: error

         model%m = m
         call model%define(n=2, c=0, mass_blocks=[1, 1])
         at%x = [1.0_wp, 0.01_wp]
         at%v = [0.0_wp, 0.0_wp]
         call simulate(model, at, 1.0_wp, result, error, look=.false., options=integration_options_t( &
                       integrator=integrator, step_control='fixed', first_step=0.1_wp))
         if (.not. allocated(error) .and. allocated(result%error)) call move_alloc(result%error, error)
         call check(failure, allocated(error), words)
         if (allocated(error)) call check(failure, index(error%line(), words) > 0, error%line())
      end subroutine stops

   end subroutine named

   subroutine contradictions(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: pendulum
      type(state_t) :: at
      type(integration_result_t) :: result
      type(error_t), allocatable :: error

      call new_pendulum(pendulum, 1.0_wp, 1.0_wp, g, 1, error)
      at%x = [1.0_wp, 0.0_wp]
      at%v = [0.0_wp, 0.0_wp]
      call simulate(pendulum, at, 1.0_wp, result, error, &
                    options=integration_options_t(integrator='radau', step_control='odepkg-2009'))
      call check(failure, allocated(error), 'a test of errors that is another''s')
      if (allocated(error)) call check(failure, index(error%line(), 'odepkg-2009') > 0, error%line())
   end subroutine contradictions

   subroutine backwards(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: pendulum
      type(state_t) :: at
      type(integration_result_t) :: result
      type(error_t), allocatable :: error

      call new_pendulum(pendulum, 1.0_wp, 1.0_wp, g, 1, error)
      at%x = [1.0_wp, 0.0_wp]
      at%v = [0.0_wp, 0.0_wp]
      call simulate(pendulum, at, 1.0_wp, result, error, options=radau(1.0e-9_wp))
      call simulate(pendulum, at, 0.0_wp, result, error, options=radau(1.0e-9_wp))
      call no_error(failure, error)
      call check(failure, result%status == status_reached_end, 'the end is reached')
      call check_below(failure, norm2(at%x - [1.0_wp, 0.0_wp]), 1.0e-7_wp, 'back where it was')
   end subroutine backwards

   !> There is nothing beyond t = 1/2.
   subroutine ends(failure)
      character(:), allocatable, intent(inout) :: failure
      type(relaxation_t) :: problem
      type(integrator_t) :: integrator
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      real(wp) :: t, y(1)

      problem%last = 0.5_wp
      call integrator%init(1, radau(1.0e-6_wp), error)
      call no_error(failure, error)
      t = 0.0_wp
      y = [1.0_wp]
      call integrator%run(problem, t, y, 1.0_wp, result)
      call check(failure, result%status == status_not_finite .and. allocated(result%error), 'it says so')
      call check_close(failure, t, 0.5_wp, 1.0e-6_wp, 'up to there')
   end subroutine ends

end module test_radau
