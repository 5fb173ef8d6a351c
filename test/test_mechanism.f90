!> Mechanisms as models: every joint and drive against finite differences, functions of time, reactions in closed form.
module test_mechanism
   use taut, only: error_t, finding_t, state_t, verify, wp
   use taut_error, only: to_text
   use taut_model_mechanism, only: mechanism_t
   use taut_model_mechanism_body, only: body_planar, body_planar_point, body_point, body_spatial, body_t, pose_t
   use taut_model_mechanism_function
   use taut_model_mechanism_joint
   use taut_model_mechanism_joint_table
   use taut_model_mechanism_load, only: load_t, spring_t
   use taut_rotation, only: quaternion_of_vector
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_mechanism

contains

   !> All tests of this module.
   function collect_mechanism() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('every joint passes the checker', joints_are_consistent), &
               new_test('every joint of the plane passes the checker', planar_joints_are_consistent), &
               new_test('every function has its derivatives', function_derivatives), &
               new_test('a spline goes through a cubic', spline_is_exact), &
               new_test('a sum of functions', sum_of_functions), &
               new_test('forces are the derivatives of the energy', forces_have_a_potential), &
               new_test('bodies that cannot be', bad_bodies)]
   end function collect_mechanism

   !> A body with all products of inertia.
   function some_body(name, kind, shift) result(body)
      character(*), intent(in) :: name
      integer, intent(in) :: kind
      real(wp), intent(in) :: shift
      type(body_t) :: body

      body%name = name
      body%kind = kind
      body%m = 1.3_wp + shift
      if (kind == body_spatial) &
         body%j = reshape([0.5_wp, 0.1_wp, -0.05_wp, 0.1_wp, 0.6_wp, 0.07_wp, -0.05_wp, 0.07_wp, 0.4_wp], [3, 3])
      if (kind == body_planar) body%j(3, 3) = 0.3_wp
      body%position = [0.3_wp + shift, 0.2_wp - 2.0_wp*shift, -0.4_wp + shift]
      body%velocity = [0.3_wp, -0.2_wp + shift, 0.5_wp]
      body%spin = [1.1_wp, 0.7_wp - shift, -0.6_wp]
      body%orientation = quaternion_of_vector([0.5_wp - shift, -0.7_wp, 0.3_wp + shift])
      if (kind == body_planar) body%orientation = quaternion_of_vector([0.0_wp, 0.0_wp, 0.3_wp + shift])
   end function some_body

   !> A function that is not constant.
   function some_function(name, scale) result(g)
      character(*), intent(in) :: name
      real(wp), intent(in) :: scale
      type(time_function_t) :: g

      g%name = name
      g%kind = function_sine
      g%offset = 0.4_wp*scale
      g%amplitude = 0.3_wp*scale
      g%omega = 1.7_wp
      g%phase = 0.2_wp
   end function some_function

   !> A joint between body 1 (or the ground) and body 2 with points and axes askew, far from its constraints.
   subroutine add_joint(system, type, ground, angle_drive, drive, failure)
      type(mechanism_t), intent(inout) :: system
      integer, intent(in) :: type, angle_drive, drive
      logical, intent(in) :: ground
      character(:), allocatable, intent(inout) :: failure
      type(joint_t) :: joint
      type(pose_t) :: one, two
      type(error_t), allocatable :: error
      real(wp) :: axis(3)

      joint%name = trim(joint_types(type))
      joint%type = type
      joint%body_1 = merge(0, 1, ground)
      joint%body_2 = 2
      joint%angle_drive = angle_drive
      joint%drive = drive
      joint%length = 0.7_wp
      joint%p_1 = [0.1_wp, 0.2_wp, 0.3_wp]
      joint%p_2 = [-0.2_wp, 0.15_wp, 0.1_wp]
      axis = [0.3_wp, -0.5_wp, 0.8_wp]
      if (system%planar) axis = [0.0_wp, 0.0_wp, 1.0_wp]
      if (system%planar .and. any(type == [type_prismatic, type_in_line, type_coordinate, type_knife_edge])) &
         axis = [0.4_wp, -0.3_wp, 0.0_wp]
      call one_pose(0, one)
      if (.not. ground) call one_pose(1, one)
      call one_pose(2, two)
      call joint_frames(joint, one, two, axis, axis, 0.3_wp, error)
      call no_error(failure, error)
      system%joints = [system%joints, joint]

   contains

      subroutine one_pose(body, it)
         use taut_model_mechanism_body, only: ground_pose
         use taut_rotation, only: matrix_of_quaternion
         integer, intent(in) :: body
         type(pose_t), intent(out) :: it

         call ground_pose(it)
         if (body == 0) return
         it%p = system%bodies(body)%position
         it%r = matrix_of_quaternion(system%bodies(body)%orientation)
      end subroutine one_pose

   end subroutine add_joint

   !> Checks a system away from where its joints were placed.
   subroutine check_system(system, failure)
      type(mechanism_t), intent(inout) :: system
      character(:), allocatable, intent(inout) :: failure
      type(finding_t), allocatable :: findings(:)
      type(error_t), allocatable :: error
      type(state_t) :: at
      real(wp) :: d(12), scattered
      real(wp), allocatable :: a(:, :), values(:)
      integer, allocatable :: first(:), column(:)
      integer :: i, k

      call system%complete(error)
      call no_error(failure, error)
      if (allocated(failure)) return
      at = system%start_state()
      at%t = 0.37_wp
      d = 0.15_wp*[1.0_wp, -0.6_wp, 0.4_wp, 0.7_wp, 1.1_wp, -0.9_wp, 0.3_wp, -1.2_wp, 0.5_wp, -0.8_wp, 0.6_wp, 1.3_wp]
      call system%displace(d(:system%n), at%x)
      call verify(system, at, findings, error)
      call no_error(failure, error)
      if (size(findings) > 0) then
         i = max(1, findings(1)%row)
         call check(failure, .false., system%joints(system%joint_of_row(i))%name//', kind '// &
                    to_text(system%rows(i)%kind)//': '//findings(1)%message)
      end if
      ! The compressed rows are those of the dense matrix.
      allocate (a(system%c, system%n))
      call system%jacobian(at, a)
      call system%pattern(first, column)
      allocate (values(size(column)))
      call system%jacobian_entries(at, values)
      do i = 1, system%c
         scattered = sum(abs(a(i, :)))
         do k = first(i), first(i + 1) - 1
            call check_close(failure, values(k), a(i, column(k)), 1.0e-15_wp, 'compressed entry of row '//to_text(i))
            if (k > first(i)) call check(failure, column(k) > column(k - 1), 'columns do not ascend')
            scattered = scattered - abs(values(k))
         end do
         call check_below(failure, scattered, 1.0e-13_wp, 'entries that the pattern does not have')
      end do
   end subroutine check_system

   subroutine joints_are_consistent(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_t) :: system
      integer :: turn, type

      do type = 1, size(joint_types)
         do turn = 1, 3
            if (allocated(failure)) return
            if (any(type == [type_rolling, type_knife_edge, type_coordinate]) .and. turn < 3) cycle
            system = mechanism_t()
            allocate (system%joints(0))
            ! Bodies of both orders: the entries of the lower number come first.
            system%bodies = [some_body('a', merge(body_point, body_spatial, turn == 2 .and. type == type_distance), 0.0_wp), &
                             some_body('b', body_spatial, 0.2_wp)]
            system%functions = [some_function('angle', 1.0_wp), some_function('length', 0.1_wp)]
            system%gravity = [0.1_wp, -0.3_wp, -9.81_wp]
            call add_joint(system, type, turn == 3, merge(1, 0, any(type == [type_revolute, type_cylindrical])), &
                           merge(2, 0, any(type == [type_distance, type_prismatic, type_cylindrical, type_coordinate])), failure)
            if (turn == 2) then
               system%joints(1)%body_1 = 2
               system%joints(1)%body_2 = 1
            end if
            call check_system(system, failure)
         end do
      end do
   end subroutine joints_are_consistent

   subroutine planar_joints_are_consistent(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_t) :: system
      integer, parameter :: types(8) = [type_distance, type_spherical, type_revolute, type_prismatic, type_fixed, type_in_line, &
                                        type_coordinate, type_knife_edge]
      integer :: i, turn

      do i = 1, size(types)
         do turn = 1, 2
            if (allocated(failure)) return
            if (any(types(i) == [type_knife_edge, type_coordinate]) .and. turn == 1) cycle
            system = mechanism_t()
            allocate (system%joints(0))
            system%planar = .true.
            system%bodies = [some_body('a', merge(body_planar_point, body_planar, types(i) == type_distance), 0.0_wp), &
                             some_body('b', body_planar, 0.2_wp)]
            system%functions = [some_function('angle', 1.0_wp), some_function('length', 0.1_wp)]
            call add_joint(system, types(i), turn == 2, merge(1, 0, types(i) == type_revolute), &
                           merge(2, 0, any(types(i) == [type_distance, type_prismatic, type_coordinate])), failure)
            call check_system(system, failure)
         end do
      end do
   end subroutine planar_joints_are_consistent

   subroutine function_derivatives(failure)
      character(:), allocatable, intent(inout) :: failure
      type(time_function_t) :: g
      type(error_t), allocatable :: error
      real(wp), parameter :: h = 1.0e-4_wp
      real(wp) :: here(3), after(3), before(3), t
      integer :: i, kind

      ! A sum has none of its own.
      do kind = function_constant, function_table
         g = time_function_t()
         g%name = function_kinds(kind)
         g%kind = kind
         g%offset = 0.3_wp
         g%amplitude = 0.7_wp
         g%rate = 1.2_wp
         g%omega = 2.3_wp
         g%phase = 0.4_wp
         g%start = 0.25_wp
         g%finish = 1.5_wp
         g%coefficients = [0.2_wp, -0.5_wp, 0.9_wp, 0.1_wp]
         g%times = [0.0_wp, 0.3_wp, 0.5_wp, 1.1_wp, 2.0_wp]
         g%values = [0.1_wp, 0.4_wp, -0.2_wp, 0.3_wp, 0.0_wp]
         call g%check(error)
         call no_error(failure, error)
         do i = 1, 19
            t = 0.1_wp*i + 0.013_wp
            call g%evaluate(t, here)
            call g%evaluate(t - h, before)
            call g%evaluate(t + h, after)
            call check_close(failure, here(2), (after(1) - before(1))/(2.0_wp*h), 1.0e-5_wp, trim(function_kinds(kind))//' rate')
            call check_close(failure, here(3), (after(2) - before(2))/(2.0_wp*h), 1.0e-4_wp, trim(function_kinds(kind))//' second')
         end do
      end do
      ! The polynomial's value: 0.3 + 0.2 t - 0.5 t^2 + 0.9 t^3 + 0.1 t^4.
      g%kind = function_polynomial
      call g%evaluate(2.0_wp, here)
      call check_close(failure, here(1), 0.3_wp + 0.4_wp - 2.0_wp + 7.2_wp + 1.6_wp, 1.0e-14_wp, 'polynomial')
      g%kind = function_step
      call g%evaluate(5.0_wp, here)
      call check_close(failure, here(1), 1.0_wp, 1.0e-15_wp, 'a step ends at offset + amplitude')
      ! From rest at 0.25 to 1.2/s at 1.5: half of what the rate would have gone, without a jump of the acceleration.
      g%kind = function_run_up
      call g%evaluate(0.25_wp, here)
      call check_close(failure, norm2(here - [0.3_wp, 0.0_wp, 0.0_wp]), 0.0_wp, 1.0e-15_wp, 'a run-up begins at rest')
      call g%evaluate(1.5_wp - 1.0e-9_wp, before)
      call g%evaluate(1.5_wp, here)
      call check_close(failure, norm2(here - [0.3_wp + 0.5_wp*1.2_wp*1.25_wp, 1.2_wp, 0.0_wp]), 0.0_wp, 1.0e-15_wp, 'its end')
      call check_close(failure, norm2(here - before), 0.0_wp, 1.0e-8_wp, 'nothing jumps')
      call g%evaluate(3.5_wp, here)
      call check_close(failure, here(1), 0.3_wp + 0.75_wp + 2.4_wp, 1.0e-15_wp, 'then it goes on')
      g%finish = g%start
      call g%check(error)
      call check(failure, allocated(error), 'a run-up takes time')
   end subroutine function_derivatives

   !> 10 t + 0.1 sin 20 t, doubled within another sum that is given before it; a loop and a name that is nobody's.
   subroutine sum_of_functions(failure)
      character(:), allocatable, intent(inout) :: failure
      type(time_function_t) :: g(5)
      type(error_t), allocatable :: error
      real(wp), parameter :: t = 0.37_wp
      real(wp) :: value(3)

      g(1) = time_function_t(name='twice', kind=function_sum, offset=0.5_wp)
      g(1)%of = [character(len=len(g(1)%of)) :: 'turning', 'ripple', 'late']
      g(1)%factors = [2.0_wp, 1.0_wp, 3.0_wp]
      g(2) = time_function_t(name='steady', kind=function_ramp, rate=10.0_wp)
      g(3) = time_function_t(name='ripple', kind=function_sine, amplitude=0.1_wp, omega=20.0_wp)
      g(4) = time_function_t(name='turning', kind=function_sum)
      g(4)%of = [character(len=len(g(4)%of)) :: 'steady', 'ripple']
      g(5) = time_function_t(name='late', kind=function_step, start=4.0_wp, finish=5.0_wp)
      call g(1)%check(error)
      call resolve_sums(g, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      call g(4)%evaluate(t, value)
      call check_close(failure, value(1), 10.0_wp*t + 0.1_wp*sin(20.0_wp*t), 1.0e-15_wp, 'value')
      call check_close(failure, value(2), 10.0_wp + 2.0_wp*cos(20.0_wp*t), 1.0e-14_wp, 'rate')
      call check_close(failure, value(3), -40.0_wp*sin(20.0_wp*t), 1.0e-13_wp, 'second rate')
      call g(1)%evaluate(t, value)
      call check_close(failure, value(1), 0.5_wp + 20.0_wp*t + 0.3_wp*sin(20.0_wp*t), 1.0e-14_wp, 'value of a sum of a sum')
      call check_close(failure, value(2), 20.0_wp + 6.0_wp*cos(20.0_wp*t), 1.0e-14_wp, 'its rate')
      call g(1)%evaluate(6.0_wp, value)
      call check_close(failure, value(1), 123.5_wp + 0.3_wp*sin(120.0_wp), 1.0e-13_wp, 'with the step')
      call check(failure, any(abs(g(1)%breakpoints() - 4.0_wp) < 1.0e-15_wp), 'where a term is not smooth, the sum is not')
      call check(failure, .not. g(1)%jumps(), 'no jump')
      g(5)%finish = g(5)%start
      call refused('', 'a jump is a term like others')
      call check(failure, g(1)%jumps(), 'a sum with a jump jumps')
      g(4)%of(2) = 'twice'
      call refused('function "twice": it is a sum that contains itself; remove it from one of the sums: "twice" "turning"', 'loop')
      g(4)%of(2) = 'riple'
      call refused('function "turning": of = "riple": there is no function of this name; did you mean "ripple"?', 'unknown name')
      g(1)%factors = [1.0_wp]
      call g(1)%check(error)
      call check(failure, allocated(error), 'one factor for three')

   contains

      !> What is told of them.
      subroutine refused(line, what)
         character(*), intent(in) :: line, what

         call resolve_sums(g, error)
         if (len(line) == 0) then
            call no_error(failure, error)
         else
            call check(failure, allocated(error), what)
            if (allocated(error)) call check(failure, index(error%line(), line) == 1, what//': '//error%line())
         end if
         if (allocated(error)) deallocate (error)
      end subroutine refused

   end subroutine sum_of_functions

   !> Not-a-knot splines reproduce cubics, and three points give a parabola.
   subroutine spline_is_exact(failure)
      character(:), allocatable, intent(inout) :: failure
      type(time_function_t) :: g
      type(error_t), allocatable :: error
      real(wp) :: t, value(3)
      integer :: i

      g%name = 'cubic'
      g%kind = function_table
      g%times = [-1.0_wp, -0.2_wp, 0.1_wp, 0.9_wp, 1.0_wp, 2.5_wp]
      g%values = 1.0_wp + g%times - 2.0_wp*g%times**2 + 0.7_wp*g%times**3
      call g%check(error)
      call no_error(failure, error)
      do i = 0, 34
         t = -1.0_wp + 0.1_wp*i
         call g%evaluate(t, value)
         call check_close(failure, value(1), 1.0_wp + t - 2.0_wp*t**2 + 0.7_wp*t**3, 1.0e-13_wp, 'cubic')
         call check_close(failure, value(3), -4.0_wp + 4.2_wp*t, 1.0e-12_wp, 'its second derivative')
      end do
      g%times = [0.0_wp, 1.0_wp, 3.0_wp]
      g%values = g%times**2
      call g%check(error)
      call g%evaluate(2.0_wp, value)
      call check_close(failure, value(1), 4.0_wp, 1.0e-14_wp, 'parabola')
   end subroutine spline_is_exact

   !> f at rest is minus the derivative of the energy, with springs of both kinds and gravity.
   subroutine forces_have_a_potential(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_t) :: system
      type(spring_t) :: between, about
      type(error_t), allocatable :: error
      type(state_t) :: at, moved
      real(wp), allocatable :: f(:), d(:)
      real(wp), parameter :: h = 1.0e-5_wp
      real(wp) :: slope
      integer :: i

      allocate (system%joints(0))
      system%bodies = [some_body('a', body_spatial, 0.0_wp), some_body('b', body_spatial, 0.2_wp)]
      system%gravity = [0.1_wp, -0.3_wp, -9.81_wp]
      call add_joint(system, type_revolute, .false., 0, 0, failure)
      between%name = 'spring'
      between%body_1 = 1
      between%body_2 = 2
      between%p_1 = [0.1_wp, 0.2_wp, -0.1_wp]
      between%p_2 = [0.4_wp, -0.3_wp, 0.2_wp]
      between%stiffness = 30.0_wp
      between%free = 0.4_wp
      between%preload = 2.0_wp
      about%name = 'torsion'
      about%joint = 1
      about%stiffness = 5.0_wp
      about%free = 0.1_wp
      about%preload = -1.0_wp
      system%springs = [between, about]
      call system%complete(error)
      call no_error(failure, error)
      if (allocated(failure)) return
      ! The angle is that of a revolute joint where its axes are parallel: bodies as they were placed, turned about the axis.
      at = system%start_state()
      at%v = 0.0_wp
      allocate (f(system%n), d(system%n))
      call system%force(at, f)
      do i = 1, system%n
         if (i == 4 .or. i == 10) exit
         d = 0.0_wp
         d(i) = h
         moved = at
         call system%displace(d, moved%x)
         slope = system%energy(moved)
         moved = at
         call system%displace(-d, moved%x)
         slope = (slope - system%energy(moved))/(2.0_wp*h)
         call check_close(failure, f(i), -slope, 1.0e-6_wp, 'force '//to_text(i))
      end do
   end subroutine forces_have_a_potential

   subroutine bad_bodies(failure)
      character(:), allocatable, intent(inout) :: failure
      type(body_t) :: body
      type(error_t), allocatable :: error

      body = some_body('b', body_spatial, 0.0_wp)
      call body%check(error)
      call no_error(failure, error)
      body%m = 0.0_wp
      call body%check(error)
      call expect('its mass is 0')
      body%m = 1.0_wp
      body%j = 0.0_wp
      body%j(1, 1) = 1.0_wp
      body%j(2, 2) = 1.0_wp
      body%j(3, 3) = 2.5_wp
      call body%check(error)
      call expect('triangle inequality')
      ! A plate without thickness is the limit.
      body%j(3, 3) = 2.0_wp
      call body%check(error)
      call no_error(failure, error)
      body%j(1, 1) = -1.0_wp
      call body%check(error)
      call expect('not positive definite')

   contains

      subroutine expect(text)
         character(*), intent(in) :: text

         if (.not. allocated(error)) then
            call check(failure, .false., 'no complaint: '//text)
            return
         end if
         call check(failure, index(error%line(), text) > 0, 'another complaint: '//error%line())
         deallocate (error)
      end subroutine expect

   end subroutine bad_bodies

end module test_mechanism
