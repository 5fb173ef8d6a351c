!> Tests of mechanisms of which only what moves is computed: the same derivatives, motions and reactions as of all coordinates.
module test_reduced
   use taut, only: constrained_ode_t, error_t, history_t, integration_options_t, integration_result_t, mechanism_builder_t, &
                   mechanism_t, method_t, simulate, state_t, wp
   use mechanism_runs, only: run_t, run_text
   use taut_constrained_method_choose, only: new_constrained_ode
   use taut_constrained_method_reduced, only: reduced_t
   use taut_constrained_system_reducible, only: reduction_t
   use taut_ode_stepper_dormand_prince, only: dormand_prince_t
   use taut_ode_stepper_radau, only: radau_t
   use taut_ode_system, only: inside_step
   use testing, only: check, check_below, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_reduced

   character, parameter :: nl = new_line('a')

   !> A four-bar linkage that carries a bit of everything.
   character(*), parameter :: everything = '&mechanism planar = .true. /'//nl// &
      '&gravity /'//nl// &
      '&function name = "blow", kind = "sine", omega = 3.0 /'//nl// &
      '&function name = "turn", kind = "sine", omega = 2.0, amplitude = 0.5 /'//nl// &
      '&body name = "crank", mass = 1.0, inertia = 0.3, position = 0.2, 0.1, angle = 0.4,'//nl// &
      '      velocity = -0.4, 0.8, angle_rate = 4.0 /'//nl// &
      '&body name = "coupler", mass = 2.0, inertia = 0.5, position = 1.0, 0.9, angle = -0.2 /'//nl// &
      '&body name = "rocker", mass = 1.5, inertia = 0.4, position = 2.1, 0.5, angle = 1.1 /'//nl// &
      '&body name = "arm", mass = 0.7, inertia = 0.1, position = 4.0, -0.6, angle = 0.3 /'//nl// &
      '&body name = "plate", mass = 3.0, inertia = 1.0, position = 5.0, 0.2, angle = 0.5 /'//nl// &
      '&body name = "disc", mass = 0.4, inertia = 0.2, position = -1.0, 0.3, angle = 0.1 /'//nl// &
      '&body name = "slider", mass = 0.6, inertia = 0.1, position = 3.0, 2.0 /'//nl// &
      '&point_mass name = "bob", mass = 0.3, position = 4.5, -1.2 /'//nl// &
      '&joint name = "A", type = "revolute", body_2 = "crank", point = 0.0, 0.0 /'//nl// &
      '&joint name = "B", type = "revolute", body_1 = "crank", body_2 = "coupler", point = 0.5, 0.8 /'//nl// &
      '&joint name = "C", type = "revolute", body_1 = "coupler", body_2 = "rocker", point = 1.8, 1.0 /'//nl// &
      '&joint name = "D", type = "revolute", body_1 = "rocker", body_2 = "ground", point = 2.0, 0.0 /'//nl// &
      '&joint name = "E", type = "spherical", body_2 = "arm", point = 4.0, 0.0 /'//nl// &
      '&joint name = "F", type = "fixed", body_2 = "plate", point = 4.8, 0.0 /'//nl// &
      '&joint name = "G", type = "revolute", body_2 = "disc", point = -1.1, 0.0, drive_angle = "turn", angle = 0.0 /'//nl// &
      '&joint name = "string", type = "distance", body_1 = "arm", body_2 = "bob" /'//nl// &
      '&joint name = "guide", type = "prismatic", body_2 = "slider", point = 3.0, 2.0, axis = 1.0, 0.5 /'//nl// &
      '&spring name = "s1", body_1 = "rocker", body_2 = "arm", stiffness = 20.0, damping = 0.3 /'//nl// &
      '&spring name = "s2", joint = "A", stiffness = 2.0, damping = 0.1, free_angle = 0.2 /'//nl// &
      '&spring name = "s3", body_1 = "slider", body_2 = "disc", point_2 = -0.8, 0.5, stiffness = 10.0 /'//nl// &
      '&spring name = "s4", body_1 = "plate", body_2 = "bob", stiffness = 5.0 /'//nl// &
      '&force name = "thrust", body = "crank", value = 1.0, 2.0, point = 0.4, 0.3, follow = .true. /'//nl// &
      '&moment name = "wind", body = "rocker", value = 0.0, 0.0, 0.5, function = "blow" /'//nl// &
      '&point name = "P", body = "rocker", position = 1.8, 1.2 /'//nl// &
      '&output springs = "all" /'//nl

contains

   !> All tests of this module.
   function collect_reduced() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('derivatives are those of all coordinates', same_derivatives), &
               new_test('motion, reactions and energy are those of all coordinates', same_motion), &
               new_test('projections and errors stay on the constraints', projected), &
               new_test('redundant pins', redundant), &
               new_test('the smaller mechanism has the energy of the whole one', same_energy), &
               new_test('what follows changes with what it follows from', small_changes), &
               new_test('who asks for more than derivatives gets all coordinates', whole)]
   end function collect_reduced

   !> Largest difference relative to the size of the second, 1 at least.
   pure real(wp) function apart(a, b)
      real(wp), intent(in) :: a(:), b(:)

      apart = maxval(abs(a - b)/(1.0_wp + abs(b)))
   end function apart

   !> The method on all coordinates, and on what moves.
   subroutine both(run, stage_projection, all_of_it, reduced, failure)
      type(run_t), intent(in) :: run
      character(*), intent(in) :: stage_projection
      class(constrained_ode_t), allocatable, intent(out) :: all_of_it, reduced
      character(:), allocatable, intent(inout) :: failure
      type(error_t), allocatable :: error
      type(method_t) :: method

      method%weight = 'mass'
      method%stage_projection = stage_projection
      call new_constrained_ode(all_of_it, run%model, method, error)
      if (.not. allocated(error)) call new_constrained_ode(reduced, run%model, method, error, dormand_prince_t())
      call no_error(failure, error)
      if (allocated(failure)) return
      select type (reduced)
      type is (reduced_t)
         ! Of four bodies that turn about the ground, two coordinates each; of the plate that is welded to it, three.
         call check(failure, size(reduced%reduction%x) == run%model%n_x - 11, 'coordinates that fall away')
         call check(failure, size(reduced%reduction%row) == run%model%c - 11, 'rows that fall away')
      class default
         call check(failure, .false., 'nothing is reduced')
      end select
   end subroutine both

   !> With either projection of stages, on the constraints and a little off them.
   subroutine same_derivatives(failure)
      character(:), allocatable, intent(inout) :: failure
      character(*), parameter :: projections(2) = ['newton', 'none  ']
      type(run_t) :: run
      class(constrained_ode_t), allocatable :: all_of_it, reduced
      real(wp), allocatable :: expected(:), found(:), y(:)
      integer :: i, info, j, k

      call run_text(everything, 0.1_wp, 1.0e-8_wp, run, failure)
      do k = 1, 2
         call both(run, projections(k), all_of_it, reduced, failure)
         if (allocated(failure)) return
         allocate (y(all_of_it%size()), found(all_of_it%size()), expected(all_of_it%size()))
         call all_of_it%pack(run%at, y)
         do i = 1, 2
            call all_of_it%rhs(run%at%t, y, expected, info)
            call check(failure, info == 0, 'no derivative')
            call reduced%rhs(run%at%t, y, found, info)
            call check(failure, info == 0, 'no reduced derivative')
            if (i == 1) call check_below(failure, apart(found, expected), 1.0e-10_wp, 'derivative')
            ! Metrics differ where something is projected: by the square of what is.
            if (i == 2) call check_below(failure, apart(found, expected), 1.0e-4_wp, 'derivative off the constraints')
            y = y + 1.0e-7_wp*[(sin(real(j*j, wp)), j=1, size(y))]
         end do
         deallocate (y, found, expected)
      end do
   end subroutine same_derivatives

   !> Runs of a second, one with fewer coordinates and one with all.
   subroutine reduced_and_whole(run, method, options, history, failure)
      type(run_t), intent(inout) :: run
      type(method_t), intent(in) :: method
      type(integration_options_t), intent(in) :: options
      type(history_t), intent(inout) :: history(2)
      character(:), allocatable, intent(inout) :: failure
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      type(method_t) :: made
      type(state_t) :: at
      integer :: i

      made = method
      do i = 1, 2
         at = run%start
         made%reduce = i == 1
         call simulate(run%model, at, 1.0_wp, result, error, made, options, history(i))
         call no_error(failure, error)
      end do
   end subroutine reduced_and_whole

   !> Everything that a history keeps.
   subroutine same_motion(failure)
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: run
      type(history_t) :: history(2)
      type(integration_options_t) :: options
      type(method_t) :: method

      call run_text(everything, 1.0e-3_wp, 1.0e-8_wp, run, failure)
      if (allocated(failure)) return
      options%rtol = 1.0e-11_wp
      options%atol = 1.0e-11_wp
      options%integrator = 'dop853'
      options%output_dt = 0.1_wp
      method%weight = 'mass'
      call reduced_and_whole(run, method, options, history, failure)
      if (allocated(failure)) return
      associate (a => history(1), b => history(2))
         call check(failure, a%points == b%points .and. a%points > 10, 'points')
         if (allocated(failure)) return
         call check_below(failure, apart(reshape(a%x, [size(a%x)]), reshape(b%x, [size(b%x)])), 1.0e-8_wp, 'coordinates')
         call check_below(failure, apart(reshape(a%v, [size(a%v)]), reshape(b%v, [size(b%v)])), 1.0e-7_wp, 'velocities')
         call check_below(failure, apart(reshape(a%lambda, [size(a%lambda)]), reshape(b%lambda, [size(b%lambda)])), 1.0e-6_wp, &
                          'multipliers')
         call check_below(failure, apart(reshape(a%outputs, [size(a%outputs)]), reshape(b%outputs, [size(b%outputs)])), 1.0e-6_wp, &
                          'reactions and other outputs')
         call check_below(failure, apart(a%energy, b%energy), 1.0e-8_wp, 'energy')
         call check_below(failure, apart(a%work, b%work), 1.0e-8_wp, 'work')
         call check_below(failure, apart(a%energy - a%energy(1), a%work), 1.0e-7_wp, 'balance of energy')
         call check_below(failure, max(maxval(a%phi), maxval(a%phidot)), 1.0e-11_wp, 'constraints of all coordinates')
      end associate
   end subroutine same_motion

   !> What is off the constraints comes back, and what is left of an error lies along them.
   subroutine projected(failure)
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: run
      class(constrained_ode_t), allocatable :: all_of_it, reduced
      real(wp), allocatable :: dydt(:), e(:), y(:)
      type(state_t) :: at
      real(wp) :: phi(100)
      integer :: i, info
      logical :: stale

      call run_text(everything, 0.1_wp, 1.0e-8_wp, run, failure)
      if (.not. allocated(failure)) call both(run, 'newton', all_of_it, reduced, failure)
      if (allocated(failure)) return
      at = run%at
      allocate (y(reduced%size()), dydt(reduced%size()), e(reduced%size()))
      call reduced%pack(at, y)
      y = y + 1.0e-3_wp*[(sin(real(i*i, wp)), i=1, size(y))]
      call reduced%project(at%t, y, inside_step, stale, info)
      call check(failure, info == 0, 'no projection')
      call reduced%unpack(at%t, y, at)
      call all_of_it%projector%linear%linearize(run%model, at, info, 0.0_wp)
      call run%model%constraint(at, phi(:run%model%n_phi))
      call check_below(failure, maxval(abs(phi(:run%model%n_phi))), 1.0e-12_wp, 'positions')
      call all_of_it%projector%velocity(run%model, at)
      call check_below(failure, all_of_it%projector%phidot_raw(), 1.0e-12_wp, 'velocities')
      e = [(cos(real(i*i, wp)), i=1, size(e))]
      call reduced%rhs(at%t, y, dydt, info)
      call reduced%filter_error(e)
      associate (n => run%model%n, c => run%model%c)
         call all_of_it%projector%linear%a%multiply(e(:n), phi(:c))
         call check_below(failure, maxval(abs(phi(:c))), 1.0e-12_wp, 'errors of positions')
      end associate
   end subroutine projected

   !> A body with two pins in one place, and one that two hold fast.
   subroutine redundant(failure)
      character(:), allocatable, intent(inout) :: failure
      character(*), parameter :: text = '&mechanism planar = .true. /'//nl//'&gravity /'//nl// &
         '&body name = "rod", mass = 1.0, inertia = 0.1, position = 0.5, 0.0 /'//nl// &
         '&body name = "bar", mass = 2.0, inertia = 0.2, position = 1.5, 0.3 /'//nl// &
         '&joint name = "A", type = "revolute", body_2 = "rod", point = 0.0, 0.0 /'//nl// &
         '&joint name = "B", type = "revolute", body_2 = "rod", point = 0.0, 0.0 /'//nl// &
         '&joint name = "C", type = "revolute", body_2 = "bar", point = 1.0, 0.0 /'//nl// &
         '&joint name = "D", type = "revolute", body_2 = "bar", point = 2.0, 0.0 /'//nl
      type(run_t) :: run
      type(history_t) :: history(2)
      type(integration_options_t) :: options

      call run_text(text, 1.0e-3_wp, 1.0e-8_wp, run, failure)
      if (allocated(failure)) return
      options%rtol = 1.0e-10_wp
      options%atol = 1.0e-10_wp
      options%output_dt = 0.1_wp
      call reduced_and_whole(run, method_t(), options, history, failure)
      if (allocated(failure)) return
      call check_below(failure, maxval(abs(history(1)%x - history(2)%x)), 1.0e-7_wp, 'coordinates')
      call check_below(failure, maxval(abs(history(1)%lambda - history(2)%lambda)), 1.0e-6_wp, 'multipliers of least norm')
   end subroutine redundant

   !> Kinetic and potential energy but for that of what stands still, and power.
   subroutine same_energy(failure)
      character(:), allocatable, intent(inout) :: failure
      class(reduction_t), allocatable :: reduction
      type(run_t) :: run
      type(state_t) :: at, small
      real(wp) :: apart(2)
      integer :: i

      call run_text(everything, 0.1_wp, 1.0e-8_wp, run, failure)
      if (allocated(failure)) return
      call run%model%reduce(reduction)
      allocate (small%w(0))
      do i = 1, 2
         at = run%at
         if (i == 2) at = run%start
         small%t = at%t
         small%x = at%x(reduction%x)
         small%v = at%v(reduction%v)
         apart(i) = reduction%system%energy(small) - run%model%energy(at)
         call check_below(failure, abs(reduction%system%power(small) - run%model%power(at)), 1.0e-11_wp, 'power')
      end do
      call check_below(failure, abs(apart(2) - apart(1)), 1.0e-11_wp, 'energy')
   end subroutine same_energy

   !> Against differences.
   subroutine small_changes(failure)
      character(:), allocatable, intent(inout) :: failure
      real(wp), parameter :: step = 1.0e-6_wp
      class(reduction_t), allocatable :: reduction
      type(run_t) :: run
      type(state_t) :: small
      real(wp), allocatable :: dv(:), dx(:), v(:, :), x(:, :)
      integer :: i, k

      call run_text(everything, 0.1_wp, 1.0e-8_wp, run, failure)
      if (allocated(failure)) return
      call run%model%reduce(reduction)
      allocate (x(run%model%n_x, 2), v(run%model%n, 2), dx(run%model%n_x), dv(run%model%n))
      allocate (small%w(0))
      dx = [(sin(real(i*i, wp)), i=1, size(dx))]
      dv = [(cos(real(i*i, wp)), i=1, size(dv))]
      do k = 1, 2
         x(:, k) = run%at%x + (2*k - 3)*step*dx
         v(:, k) = run%at%v + (2*k - 3)*step*dv
         small%x = x(reduction%x, k)
         small%v = v(reduction%v, k)
         call reduction%widen(small, x(:, k), v(:, k))
      end do
      small%x = run%at%x(reduction%x)
      small%v = run%at%v(reduction%v)
      call reduction%widen_change(small, dx, dv)
      call check_below(failure, apart(dx, (x(:, 2) - x(:, 1))/(2.0_wp*step)), 1.0e-8_wp, 'coordinates')
      call check_below(failure, apart(dv, (v(:, 2) - v(:, 1))/(2.0_wp*step)), 1.0e-8_wp, 'velocities')
   end subroutine small_changes

   !> Implicit integrators, a method that lets constraints drift, and who says so; and what turns about nothing.
   subroutine whole(failure)
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: run
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: free
      type(state_t) :: at
      type(error_t), allocatable :: error
      class(constrained_ode_t), allocatable :: ode
      class(reduction_t), allocatable :: reduction
      type(method_t) :: methods(0:3)
      integer :: i

      call run_text(everything, 1.0e-3_wp, 1.0e-8_wp, run, failure)
      if (allocated(failure)) return
      methods(1)%reduce = .false.
      methods(2)%name = 'baseline'
      methods(3)%state_projection = 'none'
      do i = 0, 3
         if (i == 0) call new_constrained_ode(ode, run%model, method_t(), error, radau_t())
         if (i > 0) call new_constrained_ode(ode, run%model, methods(i), error, dormand_prince_t())
         call no_error(failure, error)
         if (allocated(failure)) return
         select type (ode)
         type is (reduced_t)
            call check(failure, .false., 'something is reduced')
         end select
      end do
      builder%planar = .true.
      call builder%add_body('rod', mass=1.0_wp, inertia=[1.0_wp])
      call builder%add_body('bar', mass=1.0_wp, inertia=[1.0_wp])
      call builder%add_joint('pin', 'revolute', 'rod', 'bar', point=[0.0_wp, 0.0_wp, 0.0_wp])
      call builder%complete(free, at, error)
      call no_error(failure, error)
      if (.not. allocated(failure)) call free%reduce(reduction)
      call check(failure, .not. allocated(reduction), 'what turns about nothing is reduced')
   end subroutine whole

end module test_reduced
