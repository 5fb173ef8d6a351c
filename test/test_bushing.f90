!> Bushings in closed form: oscillations, deflections, momentum and energy, the limit of a fixed joint, elastic rows.
module test_bushing
   use taut, only: block_diagonal_t, eigenmodes, equilibrium, equilibrium_result_t, error_t, integration_options_t, &
                   integration_result_t, mechanism_builder_t, mechanism_t, method_t, modes_t, pose_t, simulate, state_t, wp
   use taut_rotation, only: cross
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_bushing

   real(wp), parameter :: o(3) = 0.0_wp, x(3) = [1.0_wp, 0.0_wp, 0.0_wp], y(3) = [0.0_wp, 1.0_wp, 0.0_wp], &
                          z(3) = [0.0_wp, 0.0_wp, 1.0_wp], pi = acos(-1.0_wp)

contains

   !> All tests of this module.
   function collect_bushing() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('a body on a bushing oscillates in each direction', oscillations), &
               new_test('modes of a body on a bushing', six_modes), &
               new_test('its deflection', deflection), &
               new_test('two free bodies keep energy and momentum', free_pair), &
               new_test('a stiff bushing is a fixed joint', fixed_joint), &
               new_test('elastic rows of bushings', rows), &
               new_test('in the plane, and on a body of which only the angle is computed', in_plane), &
               new_test('columns are force and moment on the second body', columns), &
               new_test('bushings that cannot be', faults)]
   end function collect_bushing

   !> Along and about one axis at once: damped oscillations that do not know of each other.
   subroutine oscillations(failure)
      character(:), allocatable, intent(inout) :: failure
      real(wp), parameter :: k(3) = [200.0_wp, 300.0_wp, 500.0_wp], k_r(3) = [30.0_wp, 40.0_wp, 60.0_wp], &
                             c(3) = [2.0_wp, 0.0_wp, 3.0_wp], c_r(3) = [0.2_wp, 0.5_wp, 0.0_wp], m = 2.0_wp, &
                             j(3) = [0.3_wp, 0.4_wp, 0.5_wp], v = 0.7_wp, w = 5.0_wp, t = 0.9_wp
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(pose_t) :: pose
      type(error_t), allocatable :: error
      type(integration_result_t) :: result
      real(wp) :: e(3), energy
      integer :: i

      do i = 1, 3
         e = 0.0_wp
         e(i) = 1.0_wp
         block
            type(mechanism_builder_t) :: builder

            call builder%add_body('b', m, inertia=j, position=y, velocity=v*e, angular_velocity=w*e)
            call builder%add_bushing('ground', 'b', stiffness=k, rotational_stiffness=k_r, damping=c, rotational_damping=c_r)
            call builder%complete(mechanism, at, error)
         end block
         energy = mechanism%energy(at)
         call check_close(failure, mechanism%power(at), -c(i)*v**2 - c_r(i)*w**2, 1.0e-13_wp*w**2, 'power of its dampers')
         call simulate(mechanism, at, t, result, error, options=integration_options_t(rtol=1.0e-11_wp, atol=1.0e-13_wp))
         call no_error(failure, error)
         if (allocated(failure)) return
         call mechanism%pose_of(at, 1, pose)
         call check_close(failure, pose%p(i) - y(i), motion(k(i), c(i), m, v), 1.0e-9_wp, 'displacement')
         ! The largest angle is more than a quarter of a turn.
         call check_close(failure, pose%r(1 + mod(i, 3), 1 + mod(i, 3)), cos(motion(k_r(i), c_r(i), j(i), w)), 1.0e-8_wp, 'angle')
         if (c(i) + c_r(i) > 0.0_wp) call check(failure, mechanism%energy(at) < energy, 'energy is taken')
      end do

   contains

      !> From rest at zero: m s'' + c s' + k s = 0.
      real(wp) function motion(k, c, m, v) result(s)
         real(wp), intent(in) :: k, c, m, v
         real(wp) :: omega

         omega = sqrt(k/m - (0.5_wp*c/m)**2)
         s = v/omega*exp(-0.5_wp*c/m*t)*sin(omega*t)
      end function motion

   end subroutine oscillations

   !> Six frequencies sqrt(k/m), sqrt(k_r/J), in axes of its own.
   subroutine six_modes(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(equilibrium_result_t) :: found
      type(modes_t) :: modes
      type(error_t), allocatable :: error

      call builder%add_body('b', 2.0_wp, inertia=[0.5_wp, 0.4_wp, 0.3_wp])
      ! Its axes 1, 2, 3 are y, z, x.
      call builder%add_bushing('ground', 'b', o, axis=x, side=y, stiffness=[200.0_wp, 800.0_wp, 50.0_wp], &
                               rotational_stiffness=[0.4_wp*9.0_wp, 0.3_wp*16.0_wp, 0.5_wp*900.0_wp])
      call builder%complete(mechanism, at, error)
      if (.not. allocated(error)) call equilibrium(mechanism, at, found, error)
      if (.not. allocated(error)) call eigenmodes(mechanism, at, modes, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      call check(failure, size(modes%frequency) == 6, 'six modes')
      if (allocated(failure)) return
      call check_below(failure, maxval(abs(2.0_wp*pi*modes%frequency - [3.0_wp, 4.0_wp, 5.0_wp, 10.0_wp, 20.0_wp, 30.0_wp])), &
                       1.0e-7_wp, 'frequencies')
   end subroutine six_modes

   !> A weight along each axis of a bushing that is turned: u = m g/k, without a rotation, for force and deflection are in one line.
   subroutine deflection(failure)
      character(:), allocatable, intent(inout) :: failure
      real(wp), parameter :: k(3) = [100.0_wp, 200.0_wp, 400.0_wp], weight = 5.0_wp, m = 2.0_wp
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(equilibrium_result_t) :: found
      type(error_t), allocatable :: error
      type(pose_t) :: pose
      real(wp) :: f(3, 3)
      integer :: i

      f(:, 3) = [1.0_wp, 1.0_wp, 0.0_wp]/sqrt(2.0_wp)
      f(:, 1) = [1.0_wp, -1.0_wp, 2.0_wp]/sqrt(6.0_wp)
      f(:, 2) = cross(f(:, 3), f(:, 1))
      do i = 1, 3
         block
            type(mechanism_builder_t) :: builder

            builder%gravity = weight/m*f(:, i)
            call builder%add_body('b', m, inertia=[0.5_wp, 0.4_wp, 0.3_wp], orientation=[0.4_wp, -0.3_wp, 0.2_wp])
            call builder%add_bushing('ground', 'b', axis=[1.0_wp, 1.0_wp, 0.0_wp], side=[1.0_wp, 0.0_wp, 1.0_wp], stiffness=k, &
                                     rotational_stiffness=[10.0_wp, 20.0_wp, 30.0_wp])
            call builder%complete(mechanism, at, error)
         end block
         if (.not. allocated(error)) call equilibrium(mechanism, at, found, error)
         call no_error(failure, error)
         if (allocated(failure)) return
         call mechanism%pose_of(at, 1, pose)
         call check_below(failure, norm2(pose%p - weight/k(i)*f(:, i)), 1.0e-9_wp, 'deflection')
      end do
   end subroutine deflection

   !> Off both centers, turned by more than a radian.
   subroutine free_pair(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(error_t), allocatable :: error
      type(integration_result_t) :: result
      real(wp) :: after(6), before(6), energy, largest, turned
      integer :: i

      call builder%add_body('one', 2.0_wp, inertia=[0.3_wp, 0.4_wp, 0.5_wp], angular_velocity=[1.0_wp, -4.0_wp, 2.0_wp])
      call builder%add_body('two', 1.0_wp, inertia=[0.2_wp, 0.15_wp, 0.1_wp], position=[1.0_wp, 0.2_wp, 0.0_wp], &
                            orientation=[0.3_wp, 0.9_wp, -0.4_wp], velocity=[0.0_wp, 1.0_wp, -2.0_wp], &
                            angular_velocity=[5.0_wp, 1.0_wp, -3.0_wp])
      call builder%add_bushing('one', 'two', point_1=[0.4_wp, 0.1_wp, -0.1_wp], point_2=[0.5_wp, 0.0_wp, 0.2_wp], &
                               axis=[1.0_wp, 2.0_wp, 3.0_wp], stiffness=[20.0_wp, 70.0_wp, 150.0_wp], &
                               rotational_stiffness=[1.0_wp, 3.0_wp, 7.0_wp])
      call builder%complete(mechanism, at, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      energy = mechanism%energy(at)
      before = momentum()
      largest = 0.0_wp
      do i = 1, 20
         call simulate(mechanism, at, 0.1_wp*i, result, error, options=integration_options_t(rtol=1.0e-11_wp, atol=1.0e-13_wp))
         call no_error(failure, error)
         if (allocated(failure)) return
         call check_close(failure, mechanism%energy(at), energy, 1.0e-8_wp*energy, 'energy')
         after = momentum()
         call check_below(failure, norm2(after - before), 1.0e-8_wp*norm2(before), 'momentum')
         turned = relative_angle()
         largest = max(largest, turned)
      end do
      call check(failure, largest > 1.0_wp .and. largest < 3.0_wp, 'large rotations')

   contains

      !> Momentum and moment of momentum about the origin.
      function momentum() result(both)
         real(wp) :: both(6)
         type(pose_t) :: pose
         integer :: b

         both = 0.0_wp
         do b = 1, 2
            associate (body => mechanism%bodies(b))
               call mechanism%pose_of(at, b, pose)
               both(1:3) = both(1:3) + body%m*pose%v
               both(4:6) = both(4:6) + body%m*cross(pose%p, pose%v) + matmul(pose%r, matmul(body%j, pose%w))
            end associate
         end do
      end function momentum

      real(wp) function relative_angle() result(angle)
         type(pose_t) :: one, two
         real(wp) :: r(3, 3)

         call mechanism%pose_of(at, 1, one)
         call mechanism%pose_of(at, 2, two)
         associate (it => mechanism%bushings(1))
            r = matmul(matmul(transpose(it%frame_1), transpose(one%r)), matmul(two%r, it%frame_2))
         end associate
         angle = acos(0.5_wp*(r(1, 1) + r(2, 2) + r(3, 3) - 1.0_wp))
      end function relative_angle

   end subroutine free_pair

   !> Two halves of a pendulum that a bushing of 1e8 N/m and N m/rad makes one: few steps, and the motion of a fixed joint.
   subroutine fixed_joint(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_t) :: mechanism
      type(state_t) :: at(2)
      type(error_t), allocatable :: error
      type(integration_result_t) :: result
      type(integration_options_t) :: options
      real(wp), parameter :: stiff(3) = 1.0e8_wp, soft(3) = 1.0e3_wp
      integer :: i, steps(2)

      do i = 1, 2
         block
            type(mechanism_builder_t) :: builder

            builder%gravity = [0.0_wp, 0.0_wp, -9.81_wp]
            call builder%add_body('upper', 1.0_wp, shape='rod', from=o, to=0.5_wp*x, thickness=0.1_wp)
            call builder%add_body('lower', 1.0_wp, shape='rod', from=0.5_wp*x, to=x, thickness=0.1_wp)
            call builder%add_joint('hinge', 'spherical', 'ground', 'upper', point=o)
            if (i == 1) call builder%add_joint('weld', 'fixed', 'upper', 'lower', point=0.5_wp*x)
            if (i == 2) call builder%add_bushing('upper', 'lower', 0.5_wp*x, stiffness=stiff, rotational_stiffness=stiff, &
                                                 damping=soft, rotational_damping=soft)
            call builder%complete(mechanism, at(i), error)
         end block
         options = integration_options_t(integrator='radau', rtol=1.0e-6_wp, atol=1.0e-9_wp)
         if (.not. allocated(error)) call simulate(mechanism, at(i), 1.0_wp, result, error, options=options)
         call no_error(failure, error)
         if (allocated(failure)) return
         steps(i) = result%steps
      end do
      call check_below(failure, maxval(abs(at(1)%x - at(2)%x)), 2.0e-5_wp, 'the same motion')
      call check(failure, steps(2) <= 2*steps(1) .and. steps(2) <= 100, 'few steps')
   end subroutine fixed_joint

   !> f = f_s - B^T k g in a state that moves, B is the derivative of the deformation, and the rate that of its dampers.
   subroutine rows(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: mechanism
      type(state_t) :: at, near, still
      type(error_t), allocatable :: error
      type(block_diagonal_t) :: stiffness
      integer, allocatable :: column(:), first(:)
      real(wp), allocatable :: b(:), b_near(:), d(:), dense(:, :), f(:), g(:), g_before(:), g_near(:), sigma(:), soft(:), tau(:)
      real(wp), parameter :: step = 1.0e-5_wp
      integer :: i, j, k

      call builder%add_body('one', 1.0_wp, inertia=[0.3_wp, 0.4_wp, 0.5_wp], orientation=[0.2_wp, 0.5_wp, -0.1_wp])
      call builder%add_body('two', 2.0_wp, inertia=[0.3_wp, 0.4_wp, 0.5_wp], position=x)
      ! The first body has the higher number; the direction 2 has a damper alone, and there is nothing about 3.
      call builder%add_bushing('two', 'one', point_1=[0.4_wp, 0.1_wp, 0.0_wp], point_2=[0.3_wp, 0.3_wp, 0.1_wp], &
                               axis=[1.0_wp, 1.0_wp, 0.0_wp], stiffness=[200.0_wp, 0.0_wp, 100.0_wp], &
                               rotational_stiffness=[20.0_wp, 30.0_wp, 0.0_wp], damping=[1.0_wp, 2.0_wp, 0.0_wp], &
                               rotational_damping=[0.5_wp, 0.0_wp, 0.0_wp])
      call builder%add_bushing('ground', 'two', 2.0_wp*x, stiffness=[10.0_wp, 20.0_wp, 30.0_wp])
      call builder%complete(mechanism, at, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      do i = 1, mechanism%n
         at%v(i) = sin(3.0_wp*i)
      end do
      call mechanism%displace(0.5_wp*at%v, at%x)
      call mechanism%normalize(at%x)
      call mechanism%elastic_pattern(first, column)
      call check(failure, mechanism%n_elastic == 7 .and. size(first) == 8, 'four rows and three')
      if (allocated(failure)) return
      tau = mechanism%elastic_damping
      call check_below(failure, maxval(abs(tau - [0.005_wp, 0.0_wp, 0.025_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp])), 1.0e-16_wp, &
                       'damping')
      allocate (b(size(column)), b_near(size(column)), g(7), g_before(7), g_near(7), sigma(7), f(mechanism%n), &
                soft(mechanism%n), d(mechanism%n), dense(7, mechanism%n))
      call mechanism%elastic_stiffness(stiffness)
      call mechanism%elastic_rows(at, g, b)
      call stiffness%multiply(g, sigma)
      call mechanism%force(at, f)
      call mechanism%soft_force(at, soft)
      dense = 0.0_wp
      do i = 1, 7
         do k = first(i), first(i + 1) - 1
            dense(i, column(k)) = b(k)
         end do
      end do
      call check_below(failure, maxval(abs(f - soft + matmul(sigma, dense))), 1.0e-12_wp*maxval(abs(f)), 'force')
      still = at
      still%v = 0.0_wp
      call mechanism%elastic_rows(still, g_near, b_near)
      call check_below(failure, maxval(abs(g - g_near - tau*matmul(dense, at%v))), 1.0e-14_wp, 'dampers go by the same rates')
      near = still
      do j = 1, mechanism%n
         d = 0.0_wp
         d(j) = step
         near%x = at%x
         call mechanism%displace(d, near%x)
         call mechanism%elastic_rows(near, g_near, b_near)
         near%x = at%x
         call mechanism%displace(-d, near%x)
         call mechanism%elastic_rows(near, g_before, b_near)
         call check_below(failure, maxval(abs((g_near - g_before)/(2.0_wp*step) - dense(:, j))), 1.0e-8_wp, 'B')
      end do
      ! Forces at rest are those of the potential, gyroscopic moments do no work.
      call mechanism%force(still, soft)
      call check_close(failure, mechanism%power(at), dot_product(f - soft, at%v), 1.0e-12_wp*abs(mechanism%power(at)), 'power')
   end subroutine rows

   !> A crank on a pin that a bushing turns back: the same motion with its angle alone.
   subroutine in_plane(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: mechanism
      type(state_t) :: at(2), start
      type(error_t), allocatable :: error
      type(integration_result_t) :: result
      type(integration_options_t) :: options
      type(method_t) :: method
      integer :: i

      builder%planar = .true.
      builder%gravity = -9.81_wp*y
      call builder%add_body('crank', 1.0_wp, inertia=[0.1_wp], position=0.5_wp*x)
      call builder%add_body('rod', 1.0_wp, inertia=[0.2_wp], position=1.5_wp*x)
      call builder%add_joint('pin', 'revolute', 'ground', 'crank', point=o)
      call builder%add_bushing('crank', 'rod', x, side=x + y, stiffness=[100.0_wp, 300.0_wp, 0.0_wp], &
                               rotational_stiffness=20.0_wp*z, damping=[1.0_wp, 1.0_wp, 0.0_wp], rotational_damping=0.3_wp*z)
      call builder%add_bushing('ground', 'crank', 0.2_wp*x, rotational_stiffness=30.0_wp*z)
      call builder%complete(mechanism, start, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      options = integration_options_t(rtol=1.0e-10_wp, atol=1.0e-12_wp)
      do i = 1, 2
         at(i) = start
         method%reduce = i == 1
         call simulate(mechanism, at(i), 1.0_wp, result, error, method, options)
         call no_error(failure, error)
         if (allocated(failure)) return
      end do
      call check_below(failure, maxval(abs(at(1)%x - at(2)%x)), 1.0e-7_wp, 'the same motion')
      call check(failure, abs(at(1)%x(3) - start%x(3)) > 0.1_wp, 'it moves')
   end subroutine in_plane

   !> A body that is held apart: what the bushing does to it, in axes half-way.
   subroutine columns(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=7), parameter :: names(6) = ['bush.f1', 'bush.f2', 'bush.f3', 'bush.m1', 'bush.m2', 'bush.m3']
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp), allocatable :: lambda(:), values(:)
      integer :: i

      call builder%add_body('b', 1.0_wp, inertia=[0.3_wp, 0.4_wp, 0.5_wp], velocity=x)
      call builder%add_spring('ground', 'b', point_1=5.0_wp*z, stiffness=1.0_wp, name='wire')
      call builder%add_bushing('ground', 'b', point_1=-0.1_wp*x, point_2=o, stiffness=[100.0_wp, 200.0_wp, 300.0_wp], &
                               rotational_stiffness=[10.0_wp, 20.0_wp, 30.0_wp], damping=[2.0_wp, 0.0_wp, 0.0_wp], name='bush')
      call builder%show_springs()
      call builder%complete(mechanism, at, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      call mechanism%displace([0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.6_wp], at%x)
      at%v = 0.0_wp
      at%v(1) = 1.0_wp
      call check(failure, mechanism%n_outputs == 8, 'two of the spring, six of the bushing')
      if (allocated(failure)) return
      do i = 1, 6
         call check(failure, mechanism%output_name(2 + i) == names(i), 'a name: '//trim(mechanism%output_name(2 + i)))
      end do
      call check(failure, mechanism%output_name(1) == 'wire.force', 'springs come first')
      allocate (lambda(mechanism%c), values(8))
      call mechanism%outputs(at, lambda, values)
      ! In axes that are turned by 0.3 about z: u = 0.1 {cos, -sin}, and its rate 1 {cos, -sin}. Of the moment of the pair of
      ! forces, u_1 s_2 - u_2 s_1, the body has one half.
      associate (u => 0.1_wp*[cos(0.3_wp), -sin(0.3_wp)], s => [12.0_wp*cos(0.3_wp), -20.0_wp*sin(0.3_wp)])
         call check_below(failure, norm2(values(3:5) + [s, 0.0_wp]), 1.0e-12_wp, 'force')
         call check_below(failure, norm2(values(6:8) - [0.0_wp, 0.0_wp, 0.5_wp*(u(1)*s(2) - u(2)*s(1)) - 18.0_wp]), 1.0e-12_wp, &
                          'moment')
      end associate
   end subroutine columns

   !> What is refused, and what is to be done.
   subroutine faults(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder, flat

      call builder%add_body('b', 1.0_wp, inertia=[0.3_wp, 0.4_wp, 0.5_wp])
      call builder%add_body('c', 1.0_wp, inertia=[0.3_wp, 0.4_wp, 0.5_wp])
      call builder%add_point_mass('m', 1.0_wp)
      flat%planar = .true.
      call flat%add_body('b', 1.0_wp, inertia=[0.3_wp])
      call refused('bushing "s": it has neither stiffness nor damping')
      call refused('bushing "s": a stiffness or a damping of -1.0000 is negative', stiffness=-z)
      call refused('bushing "s": "m" is a point mass, which has no axes', stiffness=z, body_1='m')
      call refused('bushing "s": "m" is a point mass, which does not turn', turning=z, body_2='m')
      call refused('bushing "s": it joins "b" to itself', stiffness=z, body_1='b')
      call refused('bushing "s": its side is along its axis', stiffness=z, axis=x, side=x)
      call refused('bushing "s": its axis or its side is zero', stiffness=z, axis=o)
      call refused('bushing "s": body_2 = "d": there is no body or point of this name', stiffness=z, body_2='d')
      call refused('bushing "s": it leaves the plane x-y', stiffness=z, planar=.true.)
      call refused('bushing "s": its axes leave the plane x-y', stiffness=x, side=z, planar=.true.)
      call builder%add_bushing('ground', 'm', o, stiffness=x)
      call check(failure, .not. allocated(builder%error), 'a point mass on the ground is taken')
      call builder%add_spring('b', 'c', o, o, stiffness=1.0_wp)
      if (.not. allocated(failure)) call check(failure, allocated(builder%error), 'a spring without a direction')
      if (allocated(failure)) return
      call check(failure, index(builder%error%line(), 'a bushing') > 0, 'what to use: '//builder%error%line())

   contains

      subroutine refused(line, stiffness, turning, body_1, body_2, axis, side, planar)
         character(*), intent(in) :: line
         real(wp), intent(in), optional :: stiffness(3), turning(3), axis(3), side(3)
         character(*), intent(in), optional :: body_1, body_2
         logical, intent(in), optional :: planar
         type(mechanism_builder_t) :: faulty
         character(len=6) :: one, two

         one = 'ground'
         two = 'b'
         if (present(body_1)) one = body_1
         if (present(body_2)) two = body_2
         faulty = builder
         if (present(planar)) faulty = flat
         call faulty%add_bushing(trim(one), trim(two), o, axis=axis, side=side, stiffness=stiffness, &
                                 rotational_stiffness=turning, name='s')
         call check(failure, allocated(faulty%error), line)
         if (allocated(faulty%error)) call check(failure, index(faulty%error%line(), line) == 1, faulty%error%line())
      end subroutine refused

   end subroutine faults

end module test_bushing
