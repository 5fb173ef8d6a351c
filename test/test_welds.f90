!> Tests of bodies that are welded together and computed as one: motions, reactions and energy are those of each body by itself.
module test_welds
   use taut, only: constrained_ode_t, error_t, history_t, integration_options_t, integration_result_t, mechanism_builder_t, &
                   mechanism_t, method_t, simulate, state_t, time_function_t, wp
   use mechanism_runs, only: run_t, run_text
   use taut_constrained_method_choose, only: new_constrained_ode
   use taut_constrained_start, only: start_report_t
   use taut_constrained_system_reducible, only: reduction_t
   use taut_model_mechanism_assembly, only: assemble
   use taut_model_mechanism_function, only: function_sine
   use taut_ode_stepper_dormand_prince, only: dormand_prince_t
   use test_linalg, only: random_vector, restart_random
   use testing, only: check, check_below, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_welds

   character, parameter :: nl = new_line('a')

contains

   !> All tests of this module.
   function collect_welds() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('random mechanisms with welds, in space', in_space), &
               new_test('random mechanisms with welds, in the plane', in_plane), &
               new_test('what follows changes with what it follows from', small_changes), &
               new_test('the smaller mechanism has the energy of the whole one', same_energy), &
               new_test('welded halves are the rod that they make', halves), &
               new_test('a body that is welded to a point mass cannot turn', point_mass), &
               new_test('what is welded and driven is left as it is', driven_weld), &
               new_test('it is told what moves with what', told)]
   end function collect_welds

   !> A whole number from 1 to n.
   integer function any_of(n)
      integer, intent(in) :: n
      real(wp) :: u(1)

      u = random_vector(1)
      any_of = 1 + modulo(int(1.0e6_wp*abs(u(1))), n)
   end function any_of

   !> A mechanism of some groups of bodies, each group welded together; the first one also to the ground, if it says so. Groups hang
   !! in a tree, with a bar or a bushing between two of them, and forces, springs and drives on bodies of all groups.
   subroutine make(planar, groups, grounded, model, at, failure)
      logical, intent(in) :: planar, grounded
      integer, intent(in) :: groups
      type(mechanism_t), intent(out) :: model
      type(state_t), intent(out) :: at
      character(:), allocatable, intent(inout) :: failure
      character(len=11), parameter :: spatial(5) = [character(len=11) :: 'revolute', 'spherical', 'universal', 'prismatic', &
                                                    'cylindrical']
      real(wp), parameter :: normal(3) = [0.0_wp, 0.0_wp, 1.0_wp]
      type(mechanism_builder_t) :: builder
      type(time_function_t) :: swing
      type(start_report_t) :: report
      type(method_t) :: method
      type(error_t), allocatable :: error
      character(len=8) :: names(5, groups)
      character(:), allocatable :: it, name
      real(wp) :: axis(3), center(3), keep(3), p(3), places(3, 5, groups)
      integer :: g, k, sizes(groups), to

      keep = 1.0_wp
      if (planar) keep(3) = 0.0_wp
      builder%planar = planar
      builder%gravity = [0.5_wp, -9.0_wp, 2.0_wp]*keep
      swing%name = 'swing'
      swing%kind = function_sine
      swing%omega = 3.0_wp
      swing%amplitude = 0.4_wp
      call builder%add_function(swing)
      do g = 1, groups
         sizes(g) = 1 + any_of(4)
         center = [1.5_wp*g, 0.0_wp, 0.0_wp] + 0.4_wp*random_vector(3)*keep
         do k = 1, sizes(g)
            names(k, g) = 'b'//achar(iachar('a') + g)//achar(iachar('0') + k)
            places(:, k, g) = center + 0.5_wp*random_vector(3)*keep
            if (planar) then
               call builder%add_body(trim(names(k, g)), mass=1.0_wp + 0.2_wp*k, inertia=[0.1_wp*k], position=places(:, k, g), &
                                     angle=3.0_wp*sin(real(k*g, wp)), velocity=random_vector(3)*keep, angle_rate=1.0_wp)
            else
               call builder%add_body(trim(names(k, g)), mass=1.0_wp + 0.2_wp*k, position=places(:, k, g), &
                                     inertia=[0.3_wp, 0.4_wp, 0.5_wp, 0.05_wp, 0.02_wp, 0.01_wp], &
                                     orientation=3.0_wp*random_vector(3), velocity=random_vector(3), &
                                     angular_velocity=2.0_wp*random_vector(3))
            end if
            if (k == 1) cycle
            to = any_of(k - 1)
            p = center + 0.3_wp*random_vector(3)*keep
            if (any_of(2) == 1) then
               call builder%add_joint('w'//trim(names(k, g)), 'fixed', trim(names(to, g)), trim(names(k, g)), point=p)
            else
               call builder%add_joint('w'//trim(names(k, g)), 'fixed', trim(names(k, g)), trim(names(to, g)), point=p)
            end if
         end do
         ! A loop of welds, and a hinge that cannot turn.
         if (sizes(g) > 3) call builder%add_joint('l'//trim(names(1, g)), 'fixed', trim(names(sizes(g), g)), trim(names(1, g)), &
                                                  point=center)
         if (sizes(g) == 3) then
            call builder%add_joint('h'//trim(names(1, g)), 'revolute', trim(names(2, g)), trim(names(3, g)), point=center, &
                                   axis=normal, angle=0.3_wp)
            call builder%add_spring(joint='h'//trim(names(1, g)), stiffness=3.0_wp)
         end if
         call builder%add_spring(trim(names(1, g)), trim(names(2, g)), stiffness=2.0_wp, damping=1.0_wp)
         ! The joint by which it hangs.
         p = center - [0.8_wp, 0.0_wp, 0.0_wp]
         axis = random_vector(3)
         if (planar) axis = merge([cos(real(g, wp)), sin(real(g, wp)), 0.0_wp], normal, g == 4)
         it = trim(names(any_of(sizes(g)), g))
         name = 'j'//achar(iachar('a') + g)
         if (g == 1) then
            if (grounded) then
               call builder%add_joint(name, 'fixed', 'ground', it, point=p)
            else
               call builder%add_joint(name, 'revolute', 'ground', it, point=p, axis=axis, angle=0.2_wp)
            end if
         else
            to = any_of(g - 1)
            k = any_of(sizes(to))
            if (g == 3) then
               call builder%add_joint(name, 'revolute', trim(names(k, to)), it, point=p, axis=axis, drive_angle='swing')
            else if (planar .and. g /= 4) then
               call builder%add_joint(name, 'revolute', it, trim(names(k, to)), point=p)
               call builder%add_spring(joint=name, stiffness=4.0_wp, damping=0.2_wp, free_angle=7.0_wp)
            else if (planar) then
               call builder%add_joint(name, 'prismatic', it, trim(names(k, to)), point=p, axis=axis)
            else
               call builder%add_joint(name, trim(spatial(1 + modulo(g, 5))), trim(names(k, to)), it, point=p, &
                                      axis_1=axis, axis_2=merge([-axis(2), axis(1), 0.0_wp], axis, 1 + modulo(g, 5) == 3))
               if (1 + modulo(g, 5) == 5) call builder%add_spring(joint=name, stiffness=4.0_wp, damping=0.2_wp)
            end if
         end if
         call builder%add_load(it, [1.0_wp, 2.0_wp, 3.0_wp]*keep, point=p, follow=.true., function='swing')
         call builder%add_load(it, [0.0_wp, 0.0_wp, 1.0_wp], moment=.true., follow=.not. planar)
         call builder%add_load(it, [1.0_wp, -2.0_wp, 1.0_wp]*keep, point=center)
      end do
      if (groups > 3) then
         call builder%add_joint('bar', 'distance', trim(names(2, groups)), trim(names(2, 1)), point_1=places(:, 2, groups), &
                                point_2=places(:, 1, 1))
         if (planar) then
            call builder%add_bushing(trim(names(1, 2)), trim(names(1, groups)), point=places(:, 1, 2), &
                                     stiffness=[20.0_wp, 10.0_wp, 0.0_wp], damping=[1.0_wp, 0.5_wp, 0.0_wp], name='bush')
         else
            call builder%add_bushing(trim(names(1, 2)), trim(names(1, groups)), point=places(:, 1, 2), &
                                     axis=[1.0_wp, 1.0_wp, 0.3_wp], &
                                     stiffness=[20.0_wp, 10.0_wp, 5.0_wp], damping=[1.0_wp, 0.5_wp, 0.2_wp], &
                                     rotational_stiffness=[1.0_wp, 2.0_wp, 3.0_wp], name='bush')
         end if
      end if
      call builder%add_spring('ground', trim(names(1, groups)), point_1=[0.0_wp, 1.0_wp, 0.0_wp], stiffness=30.0_wp, name='s')
      call builder%add_point('tip', trim(names(2, groups)), places(:, 1, groups))
      if (groups > 3) call builder%show_springs([character(len=4) :: 's', 'bush'])
      call builder%complete(model, at, error)
      method%weight = 'mass'
      if (.not. allocated(error)) call assemble(model, method, at, report, error)
      call no_error(failure, error)
   end subroutine make

   !> Largest difference relative to the size of the second, 1 at least.
   pure real(wp) function apart(a, b)
      real(wp), intent(in) :: a(:), b(:)

      apart = maxval(abs(a - b)/(1.0_wp + abs(b)))
   end function apart

   !> Runs of half a second, one of parts and one of all bodies: everything that a history keeps.
   subroutine compare(model, start, failure)
      type(mechanism_t), intent(in) :: model
      type(state_t), intent(in) :: start
      character(:), allocatable, intent(inout) :: failure
      type(history_t) :: history(2)
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(method_t) :: method
      type(error_t), allocatable :: error
      type(state_t) :: at
      integer :: i

      options%rtol = 1.0e-11_wp
      options%atol = 1.0e-11_wp
      options%output_dt = 0.1_wp
      method%weight = 'mass'
      do i = 1, 2
         at = start
         method%reduce = i == 1
         call simulate(model, at, 0.5_wp, result, error, method, options, history(i))
         call no_error(failure, error)
         if (allocated(result%error)) call check(failure, .false., result%error%line())
      end do
      if (allocated(failure)) return
      associate (a => history(1), b => history(2))
         call check(failure, a%points == b%points .and. a%points > 5, 'points')
         if (allocated(failure)) return
         call check_below(failure, apart(reshape(a%x, [size(a%x)]), reshape(b%x, [size(b%x)])), 1.0e-8_wp, 'coordinates')
         call check_below(failure, apart(reshape(a%v, [size(a%v)]), reshape(b%v, [size(b%v)])), 1.0e-8_wp, 'velocities')
         call check_below(failure, apart(reshape(a%lambda, [size(a%lambda)]), reshape(b%lambda, [size(b%lambda)])), 1.0e-7_wp, &
                          'multipliers')
         call check_below(failure, apart(reshape(a%outputs, [size(a%outputs)]), reshape(b%outputs, [size(b%outputs)])), 1.0e-7_wp, &
                          'reactions and other outputs')
         call check_below(failure, apart(a%energy, b%energy), 1.0e-8_wp, 'energy')
         call check_below(failure, apart(a%work, b%work), 1.0e-8_wp, 'work')
         call check_below(failure, apart(a%energy - a%energy(1), a%work), 1.0e-7_wp, 'balance of energy')
         call check_below(failure, max(maxval(a%phi), maxval(a%phidot)), 1.0e-12_wp, 'constraints of all bodies')
      end associate
   end subroutine compare

   subroutine in_space(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_t) :: model
      type(state_t) :: at
      integer :: i

      call restart_random()
      do i = 2, 7
         call make(.false., i, i == 3 .or. i == 6, model, at, failure)
         if (.not. allocated(failure)) call compare(model, at, failure)
         if (allocated(failure)) return
      end do
   end subroutine in_space

   subroutine in_plane(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_t) :: model
      type(state_t) :: at
      integer :: i

      call restart_random()
      do i = 2, 7
         call make(.true., i, i == 3 .or. i == 6, model, at, failure)
         if (.not. allocated(failure)) call compare(model, at, failure)
         if (allocated(failure)) return
      end do
   end subroutine in_plane

   !> Against differences; and back.
   subroutine small_changes(failure)
      character(:), allocatable, intent(inout) :: failure
      real(wp), parameter :: step = 1.0e-6_wp
      class(reduction_t), allocatable :: reduction
      type(mechanism_t) :: model
      type(state_t) :: at, small
      real(wp), allocatable :: back_v(:), back_x(:), dv(:), dx(:), small_v(:, :), small_x(:, :), v(:, :), x(:, :)
      integer :: i, k

      call restart_random()
      do i = 1, 2
         call make(i == 2, 5, i == 2, model, at, failure)
         if (allocated(failure)) return
         if (allocated(reduction)) deallocate (reduction)
         call model%reduce(reduction)
         call check(failure, allocated(reduction), 'welds are merged')
         if (allocated(failure)) return
         dx = [(sin(real(k*k, wp)), k=1, size(at%x))]
         dv = [(cos(real(k*k, wp)), k=1, size(at%v))]
         allocate (small_x(size(reduction%x), 0:2), small_v(size(reduction%v), 0:2), x(size(at%x), 0:2), v(size(at%v), 0:2))
         do k = 0, 2
            small_x(:, k) = at%x(reduction%x) + merge(0.0_wp, (2*k - 3)*step, k == 0)*dx(reduction%x)
            small_v(:, k) = at%v(reduction%v) + merge(0.0_wp, (2*k - 3)*step, k == 0)*dv(reduction%v)
            small%x = small_x(:, k)
            small%v = small_v(:, k)
            x(:, k) = at%x
            v(:, k) = at%v
            x(reduction%x, k) = small%x
            v(reduction%v, k) = small%v
            call reduction%widen(small, x(:, k), v(:, k))
            back_x = x(reduction%x, k)
            back_v = v(reduction%v, k)
            call reduction%narrow(back_x, back_v)
            call check_below(failure, apart(back_x, small%x) + apart(back_v, small%v), 1.0e-14_wp, 'back')
         end do
         small%x = small_x(:, 0)
         small%v = small_v(:, 0)
         call reduction%widen_change(small, dx, dv)
         call check_below(failure, apart(dx, (x(:, 2) - x(:, 1))/(2.0_wp*step)), 1.0e-8_wp, 'coordinates')
         call check_below(failure, apart(dv, (v(:, 2) - v(:, 1))/(2.0_wp*step)), 1.0e-8_wp, 'velocities')
         back_x = dx(reduction%x)
         back_v = dv(reduction%v)
         call reduction%narrow_change(small, back_x, back_v)
         call check_below(failure, apart(back_x, (small_x(:, 2) - small_x(:, 1))/(2.0_wp*step)), 1.0e-8_wp, 'coordinates back')
         call check_below(failure, apart(back_v, (small_v(:, 2) - small_v(:, 1))/(2.0_wp*step)), 1.0e-8_wp, 'velocities back')
         deallocate (small_x, small_v, x, v)
      end do
   end subroutine small_changes

   !> Kinetic and potential energy but for what springs within parts keep, and power.
   subroutine same_energy(failure)
      character(:), allocatable, intent(inout) :: failure
      class(reduction_t), allocatable :: reduction
      type(mechanism_t) :: model
      type(state_t) :: at, later, small
      type(integration_result_t) :: result
      type(method_t) :: method
      type(error_t), allocatable :: error
      real(wp) :: within(2)
      integer :: i, k

      call restart_random()
      allocate (small%w(0))
      method%weight = 'mass'
      do i = 1, 2
         call make(i == 2, 4, i == 1, model, at, failure)
         if (allocated(failure)) return
         if (allocated(reduction)) deallocate (reduction)
         call model%reduce(reduction)
         later = at
         call simulate(model, later, 0.1_wp, result, error, method)
         call no_error(failure, error)
         do k = 1, 2
            if (k == 2) at = later
            small%t = at%t
            small%x = at%x(reduction%x)
            small%v = at%v(reduction%v)
            call reduction%narrow(small%x, small%v)
            within(k) = model%energy(at) - reduction%system%energy(small)
            call check_below(failure, abs(reduction%system%power(small) - model%power(at)), 1.0e-9_wp, 'power')
         end do
         call check_below(failure, abs(within(2) - within(1)), 1.0e-9_wp, 'energy')
      end do
   end subroutine same_energy

   !> A rod of two halves.
   subroutine halves(failure)
      character(:), allocatable, intent(inout) :: failure
      character(*), parameter :: before = '&gravity acceleration = 0.0, -9.81, 0.0 /'//nl, &
         hinge = '&joint name = "A", type = "revolute", body_2 = "a", point = 0.0, 0.0, 0.0, axis = 0.2, 1.0, 1.0 /'//nl
      type(run_t) :: one, two
      character(:), allocatable :: same

      call run_text(before//'&body name = "a", shape = "rod", thickness = 0.1, mass = 2.0, from = 0.0, 0.0, 0.0, '// &
                    'to = 1.0, 0.0, 0.0 /'//nl//hinge, 0.7_wp, 1.0e-10_wp, one, failure)
      if (allocated(failure)) return
      same = '&body name = "a", shape = "rod", thickness = 0.1, mass = 1.0, from = 0.0, 0.0, 0.0, to = 0.5, 0.0, 0.0 /'//nl// &
             '&body name = "b", shape = "rod", thickness = 0.1, mass = 1.0, from = 1.0, 0.0, 0.0, to = 0.5, 0.0, 0.0 /'//nl// &
             '&joint name = "weld", type = "fixed", body_1 = "a", body_2 = "b", point = 0.5, 0.0, 0.0 /'//nl
      call run_text(before//same//hinge, 0.7_wp, 1.0e-10_wp, two, failure)
      if (allocated(failure)) return
      call check_below(failure, maxval(abs(one%at%v(4:6) - two%at%v(4:6))), 1.0e-7_wp, 'angular velocity')
      call check_below(failure, maxval(abs(one%at%x(1:3) - 2.0_wp*two%at%x(1:3))), 1.0e-8_wp, 'center')
   end subroutine halves

   !> Welded to a point mass, which has no rotations, a body cannot turn.
   subroutine point_mass(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: model
      type(state_t) :: at
      type(error_t), allocatable :: error

      builder%gravity = [0.0_wp, 0.0_wp, -9.81_wp]
      call builder%add_body('a', mass=1.0_wp, inertia=[1.0_wp, 1.0_wp, 1.0_wp])
      call builder%add_body('b', mass=1.0_wp, inertia=[1.0_wp, 2.0_wp, 2.0_wp], position=[1.0_wp, 0.0_wp, 0.0_wp], &
                            velocity=[0.0_wp, 0.0_wp, 1.0_wp])
      call builder%add_point_mass('m', 0.5_wp, position=[2.0_wp, 0.0_wp, 0.0_wp], velocity=[0.0_wp, 0.0_wp, 1.0_wp])
      call builder%add_joint('pin', 'distance', 'a', 'm', point_1=[0.0_wp, 0.0_wp, 0.0_wp])
      call builder%add_joint('weld', 'fixed', 'b', 'm', point=[2.0_wp, 0.0_wp, 0.0_wp])
      call builder%add_spring('ground', 'b', point_1=[0.0_wp, 3.0_wp, 0.0_wp], point_2=[1.0_wp, 0.4_wp, 0.0_wp], stiffness=20.0_wp)
      call builder%complete(model, at, error)
      call no_error(failure, error)
      if (.not. allocated(failure)) call compare(model, at, failure)
   end subroutine point_mass

   !> A hinge between two bodies that are welded is driven: the whole mechanism is computed, and says that they contradict.
   subroutine driven_weld(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: model
      type(state_t) :: at
      type(error_t), allocatable :: error
      type(time_function_t) :: swing
      class(reduction_t), allocatable :: reduction
      real(wp), parameter :: p(3) = [0.5_wp, 0.0_wp, 0.0_wp]

      swing%name = 'swing'
      swing%kind = function_sine
      swing%omega = 3.0_wp
      call builder%add_function(swing)
      call builder%add_body('a', mass=1.0_wp, inertia=[1.0_wp, 1.0_wp, 1.0_wp])
      call builder%add_body('b', mass=1.0_wp, inertia=[1.0_wp, 1.0_wp, 1.0_wp], position=2.0_wp*p)
      call builder%add_joint('weld', 'fixed', 'a', 'b', point=p)
      call builder%add_joint('hinge', 'revolute', 'a', 'b', point=p, axis=p, drive_angle='swing')
      call builder%complete(model, at, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      call model%reduce(reduction)
      call check(failure, .not. allocated(reduction), 'it is left as it is')
   end subroutine driven_weld

   !> In words, and how many are computed.
   subroutine told(failure)
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: run
      class(constrained_ode_t), allocatable :: ode
      type(error_t), allocatable :: error
      real(wp) :: velocities
      integer :: i

      velocities = 0.0_wp
      call run_text('&body name = "base", mass = 1.0, inertia = 3*1.0 /'//nl// &
                    '&body name = "a", mass = 1.0, inertia = 3*1.0, position = 1.0, 0.0, 0.0 /'//nl// &
                    '&body name = "b", mass = 1.0, inertia = 3*1.0, position = 2.0, 0.0, 0.0 /'//nl// &
                    '&joint name = "foot", type = "fixed", body_2 = "base", point = 0.0, 0.0, 0.0 /'//nl// &
                    '&joint name = "hinge", type = "revolute", body_1 = "base", body_2 = "b", point = 0.5, 0.0, 0.0, '// &
                    'axis = 0.0, 1.0, 0.0 /'//nl// &
                    '&joint name = "weld", type = "fixed", body_1 = "a", body_2 = "b", point = 1.5, 0.0, 0.0 /', 0.1_wp, &
                    1.0e-6_wp, run, failure)
      if (allocated(failure)) return
      call check(failure, index(run%report%text, '6 velocities and 5 constraints are computed, the rest follows: base stands '// &
                                'still, b moves with a'//nl) > 0, run%report%text)
      do i = 1, size(run%model%findings)
         if (run%model%findings(i)%name == 'computed_velocities') velocities = run%model%findings(i)%value
      end do
      call check(failure, nint(velocities) == 6, 'velocities in the table')
      call new_constrained_ode(ode, run%model, method_t(), error, dormand_prince_t())
      call no_error(failure, error)
      if (.not. allocated(failure)) call check(failure, ode%size() == 3*13 + 1, 'all columns stay')
   end subroutine told

end module test_welds
