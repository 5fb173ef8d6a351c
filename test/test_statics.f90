!> Equilibrium and modes of mechanisms some of whose motions nothing resists, or dampers do: closed forms.
module test_statics
   use taut, only: eigenmodes, equilibrium, equilibrium_options_t, equilibrium_result_t, error_t, mechanism_builder_t, &
                   mechanism_t, modes_t, state_t, wp
   use taut_case_mechanism_static, only: solve_static, static_t
   use taut_case_namelist_file, only: namelist_file_t
   use test_case, only: lf, load
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_statics

   real(wp), parameter :: o(3) = 0.0_wp, g = 9.81_wp, pi = acos(-1.0_wp), x(3) = [1.0_wp, 0.0_wp, 0.0_wp], &
                          z(3) = [0.0_wp, 0.0_wp, 1.0_wp]

contains

   !> All tests of this module.
   function collect_statics() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('a pendulum on a trolley', trolley), &
               new_test('a pendulum on a turntable', turntable), &
               new_test('a vehicle stands on its springs', vehicle), &
               new_test('a level rod is told to start elsewhere', level), &
               new_test('a closed loop is moved off by one of its bodies', level_loop), &
               new_test('an equilibrium belongs to its start', branch), &
               new_test('a load beyond its limit is told', snap_through), &
               new_test('a damped oscillator', oscillator), &
               new_test('a free motion that is damped', damped_trolley), &
               new_test('modes of a double pendulum in closed form', pendulum_modes), &
               new_test('a spring and its load in equilibrium', spring_equilibrium)]
   end function collect_statics

   !> Finds the equilibrium and the modes about it.
   subroutine solve(builder, mechanism, at, found, modes, failure)
      type(mechanism_builder_t), intent(inout) :: builder
      type(mechanism_t), intent(out) :: mechanism
      type(state_t), intent(out) :: at
      type(equilibrium_result_t), intent(out) :: found
      type(modes_t), intent(out) :: modes
      character(:), allocatable, intent(inout) :: failure
      type(error_t), allocatable :: error

      call builder%complete(mechanism, at, error)
      if (.not. allocated(error)) call equilibrium(mechanism, at, found, error)
      if (.not. allocated(error)) call eigenmodes(mechanism, at, modes, error)
      call no_error(failure, error)
   end subroutine solve

   !> A cart of 2 kg on a rail and a rod that hangs from it.
   subroutine on_rail(builder)
      type(mechanism_builder_t), intent(inout) :: builder

      builder%planar = .true.
      builder%gravity = [0.0_wp, -g, 0.0_wp]
      call builder%add_body('cart', mass=2.0_wp, inertia=[1.0_wp])
      call builder%add_body('load', mass=1.0_wp, shape='rod', from=o, to=[0.2_wp, -1.0_wp, 0.0_wp])
      call builder%add_joint('rail', 'prismatic', 'ground', 'cart', point=o, axis=x)
      call builder%add_joint('pin', 'revolute', 'cart', 'load', point=o)
   end subroutine on_rail

   !> omega^2 = m g a/(J - m^2 a^2/(m + M)) with J about the pin; where the trolley is does not matter, so it stays.
   subroutine trolley(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(equilibrium_result_t) :: found
      type(modes_t) :: modes
      real(wp), parameter :: l = sqrt(1.04_wp)

      call on_rail(builder)
      call solve(builder, mechanism, at, found, modes, failure)
      if (allocated(failure)) return
      call check(failure, found%free_motions == 1 .and. modes%free_motions == 1, 'one free motion')
      call check_below(failure, maxval(abs(modes%frequency(1:1)) + abs(modes%growth(1:1))), 0.0_wp, 'of 0 Hz')
      call check_close(failure, modes%frequency(2), sqrt(0.5_wp*g*l/(0.25_wp*l*l))/(2.0_wp*pi), 1.0e-8_wp, 'the other')
      call check_close(failure, at%x(4), at%x(1), 1.0e-9_wp, 'beneath the cart')
      call check_close(failure, at%x(6), -0.5_wp*pi, 1.0e-9_wp, 'and hangs')
      call check_below(failure, at%x(1), 0.2_wp, 'which stays')
   end subroutine trolley

   !> A rod on a fork that turns about the vertical, which stays.
   subroutine turntable(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(equilibrium_result_t) :: found
      type(modes_t) :: modes
      real(wp), parameter :: l = sqrt(1.01_wp), t = 0.02_wp

      builder%gravity = -g*z
      call builder%add_body('fork', mass=1.0_wp, inertia=[0.1_wp, 0.1_wp, 0.1_wp])
      call builder%add_body('rod', mass=1.0_wp, shape='rod', thickness=t, from=o, to=[0.1_wp, 0.0_wp, -1.0_wp])
      call builder%add_joint('mast', 'revolute', 'ground', 'fork', point=o, axis=z)
      call builder%add_joint('pin', 'revolute', 'fork', 'rod', point=o, axis=[0.0_wp, 1.0_wp, 0.0_wp])
      call solve(builder, mechanism, at, found, modes, failure)
      if (allocated(failure)) return
      call check(failure, found%free_motions == 1 .and. modes%free_motions == 1 .and. size(modes%frequency) == 2, 'one is free')
      call check_close(failure, modes%frequency(2), sqrt(0.5_wp*g*l/(l*l/3.0_wp + t*t/12.0_wp))/(2.0_wp*pi), 1.0e-8_wp, 'the other')
      call check_below(failure, norm2(at%x(5:7)), 1.0e-3_wp, 'the fork stays')
   end subroutine turntable

   !> A box on four springs with dampers: it may go along x and y and turn about z; of heave omega^2 = 4 k/m, and the damping ratio
   !! is 4 c/(2 m omega).
   subroutine vehicle(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(equilibrium_result_t) :: found
      type(modes_t) :: modes
      real(wp), parameter :: k = 30.0e3_wp, c = 2.0e3_wp, m = 1.0e3_wp
      character(len=2) :: wheel
      real(wp) :: omega, p(3)
      integer :: i

      builder%gravity = -g*z
      call builder%add_body('car', mass=m, shape='box', size=[4.0_wp, 1.6_wp, 0.8_wp], position=0.7_wp*z)
      do i = 1, 4
         write (wheel, '(a, i0)') 'w', i
         p = [merge(1.4_wp, -1.4_wp, i <= 2), merge(0.8_wp, -0.8_wp, modulo(i, 2) == 0), 0.3_wp]
         call builder%add_point_mass(wheel, mass=40.0_wp, position=p)
         call builder%add_joint('guide'//wheel, 'in-line', 'car', wheel, axis=z)
         call builder%add_joint('road'//wheel, 'coordinate', 'ground', wheel, axis=z)
         call builder%add_spring('car', wheel, point_1=p + 0.4_wp*z, stiffness=k, damping=c, free_length=0.5_wp)
      end do
      call solve(builder, mechanism, at, found, modes, failure)
      if (allocated(failure)) return
      call check(failure, found%free_motions == 3 .and. modes%free_motions == 3, 'three free motions')
      call check_close(failure, at%x(3), 0.8_wp - 0.25_wp*m*g/k, 1.0e-9_wp, 'height')
      call check_below(failure, maxval(abs(at%x(1:2))) + norm2(at%x(5:7)), 1.0e-9_wp, 'it stays where it is')
      call check(failure, modes%damped .and. size(modes%frequency) == 6, 'six modes')
      if (allocated(failure)) return
      omega = sqrt(4.0_wp*k/m)
      call check_below(failure, minval(abs(modes%frequency - sqrt(omega**2 - (2.0_wp*c/m)**2)/(2.0_wp*pi))), 1.0e-7_wp, 'heave')
      call check_below(failure, minval(abs(modes%growth + 2.0_wp*c/m)), 1.0e-7_wp, 'its damping')
   end subroutine vehicle

   !> A uniform rod of 1 m in the plane, at an angle from the horizontal.
   subroutine rod_at(angle, builder)
      real(wp), intent(in) :: angle
      type(mechanism_builder_t), intent(inout) :: builder

      builder%planar = .true.
      builder%gravity = [0.0_wp, -g, 0.0_wp]
      call builder%add_body('rod', mass=1.0_wp, shape='rod', from=o, to=[cos(angle), sin(angle), 0.0_wp])
      call builder%add_joint('pin', 'revolute', 'ground', 'rod', point=o)
   end subroutine rod_at

   subroutine level(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(equilibrium_result_t) :: found
      type(error_t), allocatable :: error

      call rod_at(0.0_wp, builder)
      call builder%complete(mechanism, at, error)
      call no_error(failure, error)
      call equilibrium(mechanism, at, found, error)
      call check(failure, allocated(error), 'it cannot carry its weight')
      if (allocated(failure)) return
      call check(failure, index(error%line(), 'rod.wz') > 0 .and. index(error%line(), 'off the horizontal') > 0, error%line())
   end subroutine level

   !> A parallelogram of level rods: refused as it is, and with one crank turned and held, as advised, it hangs: no moment is left
   !! about the hinges of its cranks.
   subroutine level_loop(failure)
      character(:), allocatable, intent(inout) :: failure
      character(*), parameter :: rod = '", shape = "rod", mass = 1.0, '
      character(*), parameter :: joint = '", type = "revolute", frame = "body", '
      character(*), parameter :: of_cases(2) = [character(len=4) :: '0.0', '-0.3']
      type(namelist_file_t) :: file
      type(static_t) :: case
      type(error_t), allocatable :: error
      integer :: i

      do i = 1, 2
         call load('&mechanism planar = .true., hold = "crank.angle" /'//lf//'&gravity /'//lf// &
                   '&analysis kind = "equilibrium" /'//lf// &
                   '&body name = "crank'//rod//'length = 0.4, position = 0.2, 0.0, angle = '//trim(of_cases(i))//' /'//lf// &
                   '&body name = "coupler'//rod//'length = 1.0, position = 0.9, 0.0 /'//lf// &
                   '&body name = "rocker'//rod//'length = 0.4, position = 1.2, 0.0 /'//lf// &
                   '&joint name = "A'//joint//'body_2 = "crank", point_1 = 0.0, 0.0, point_2 = -0.2, 0.0 /'//lf// &
                   '&joint name = "B'//joint//'body_1 = "crank", body_2 = "coupler", point_1 = 0.2, 0.0, '// &
                   'point_2 = -0.5, 0.0 /'//lf// &
                   '&joint name = "C'//joint//'body_1 = "coupler", body_2 = "rocker", point_1 = 0.5, 0.0, '// &
                   'point_2 = 0.2, 0.0 /'//lf// &
                   '&joint name = "D'//joint//'body_2 = "rocker", point_1 = 1.0, 0.0, point_2 = -0.2, 0.0 /'//lf, file, error)
         call no_error(failure, error)
         if (allocated(failure)) return
         call solve_static(file, case, error)
         if (i == 1) then
            call check(failure, allocated(error), 'it cannot carry its weight')
            if (allocated(failure)) return
            call check(failure, index(error%line(), 'turned and held') > 0, error%line())
            deallocate (error)
         end if
      end do
      call no_error(failure, error)
      if (allocated(failure)) return
      call check_close(failure, sin(case%at%x(3)), -1.0_wp, 1.0e-12_wp, 'the crank hangs')
      call check_close(failure, sin(case%at%x(9)), -1.0_wp, 1.0e-12_wp, 'and the rocker')
   end subroutine level_loop

   !> Somewhat below the horizontal a rod hangs in the end, and not some turns away; above it stands, which is not stable.
   subroutine branch(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: below, above
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(equilibrium_result_t) :: found
      type(modes_t) :: modes

      call rod_at(-1.0e-3_wp, below)
      call solve(below, mechanism, at, found, modes, failure)
      if (allocated(failure)) return
      call check_close(failure, at%x(3), -0.5_wp*pi, 1.0e-9_wp, 'it hangs')
      call check_close(failure, modes%frequency(1), sqrt(1.5_wp*g)/(2.0_wp*pi), 1.0e-8_wp, 'it swings')
      call rod_at(0.02_wp, above)
      call solve(above, mechanism, at, found, modes, failure)
      if (allocated(failure)) return
      call check_close(failure, at%x(3), 0.5_wp*pi, 1.0e-9_wp, 'it stands')
      call check_close(failure, modes%growth(1), sqrt(1.5_wp*g), 1.0e-7_wp, 'it falls')
   end subroutine branch

   !> Two springs nearly in a line, pressed down: 2 k y (l/sqrt(y^2 + b^2) - 1) = F has a solution up to where y^2 + b^2 =
   !! (l b^2)^(2/3), and the load goes beyond.
   subroutine snap_through(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(equilibrium_result_t) :: found
      type(equilibrium_options_t) :: options
      type(error_t), allocatable :: error
      real(wp), parameter :: b = 2.0_wp, f = 500.0_wp, k = 1.0e3_wp, y = 0.8_wp
      real(wp) :: l, limit

      builder%planar = .true.
      call builder%add_point_mass('m', mass=1.0_wp, position=[0.0_wp, y, 0.0_wp])
      call builder%add_joint('guide', 'coordinate', 'ground', 'm', axis=x)
      call builder%add_spring('ground', 'm', point_1=b*x, stiffness=k)
      call builder%add_spring('ground', 'm', point_1=-b*x, stiffness=k)
      call builder%add_load('m', [0.0_wp, -f, 0.0_wp], 'down', .false.)
      call builder%complete(mechanism, at, error)
      options%reach = [0.5_wp, 0.5_wp]
      call no_error(failure, error)
      call equilibrium(mechanism, at, found, error, options)
      call check(failure, allocated(error), 'it is told')
      if (allocated(failure)) return
      call check(failure, index(error%line(), 'no equilibrium near') > 0, error%line())
      ! The load of the state that is left.
      l = hypot(y, b)
      limit = (l*b*b)**(1.0_wp/3.0_wp)
      limit = 2.0_wp*k*sqrt(limit**2 - b*b)*(l/limit - 1.0_wp)
      call check_close(failure, 2.0_wp*k*at%x(2)*(l/hypot(at%x(2), b) - 1.0_wp), limit, 2.0e-4_wp*f, 'the limit load')
   end subroutine snap_through

   !> A mass on a rail with a spring and a damper: lambda^2 + 2 delta lambda + omega^2 = 0, below and above critical damping.
   subroutine oscillator(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(equilibrium_result_t) :: found
      type(modes_t) :: modes
      real(wp), parameter :: k = 50.0_wp, m = 2.0_wp, delta(2) = [1.5_wp, 7.0_wp]
      integer :: i

      do i = 1, 2
         block
            type(mechanism_builder_t) :: builder

            builder%planar = .true.
            call builder%add_body('cart', mass=m, inertia=[1.0_wp])
            call builder%add_joint('rail', 'prismatic', 'ground', 'cart', point=o, axis=x)
            call builder%add_spring('ground', 'cart', point_1=-x, stiffness=k, damping=2.0_wp*m*delta(i))
            call solve(builder, mechanism, at, found, modes, failure)
         end block
         if (allocated(failure)) return
         call check(failure, modes%damped .and. modes%free_motions == 0 .and. size(modes%frequency) == i, 'modes')
         if (allocated(failure)) return
         if (i == 1) then
            call check_close(failure, modes%frequency(1), sqrt(k/m - delta(1)**2)/(2.0_wp*pi), 1.0e-8_wp, 'frequency')
            call check_close(failure, modes%growth(1), -delta(1), 1.0e-8_wp, 'decay')
         else
            call check_below(failure, maxval(modes%frequency), 0.0_wp, 'no vibration')
            call check_close(failure, modes%growth(1), -delta(2) + sqrt(delta(2)**2 - k/m), 1.0e-8_wp, 'slow')
            call check_close(failure, modes%growth(2), -delta(2) - sqrt(delta(2)**2 - k/m), 1.0e-7_wp, 'fast')
         end if
         call check_close(failure, modes%shapes(1, 1), sqrt(1.0_wp/m), 1.0e-12_wp, 'unit modal mass')
      end do
   end subroutine oscillator

   !> The trolley with a damper on its rail: a free motion still, and three roots of
   !! ((m + M) s + c) (J s^2 + m g a) = (m a)^2 s^3.
   subroutine damped_trolley(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(equilibrium_result_t) :: found
      type(modes_t) :: modes
      complex(wp) :: s
      real(wp), parameter :: c = 3.0_wp, l = sqrt(1.04_wp)
      integer :: i

      call on_rail(builder)
      call builder%add_spring('ground', 'cart', point_1=-10.0_wp*x, damping=c)
      call solve(builder, mechanism, at, found, modes, failure)
      if (allocated(failure)) return
      call check(failure, modes%free_motions == 1 .and. modes%damped .and. size(modes%frequency) == 3, 'modes')
      if (allocated(failure)) return
      call check_below(failure, abs(modes%frequency(1)) + abs(modes%growth(1)), 0.0_wp, 'free')
      do i = 2, 3
         s = cmplx(modes%growth(i), 2.0_wp*pi*modes%frequency(i), wp)
         call check_below(failure, abs((3.0_wp*s + c)*(l*l/3.0_wp*s**2 + 0.5_wp*g*l) - 0.25_wp*l*l*s**3), 1.0e-6_wp, 'a root')
      end do
      call check(failure, all(modes%growth(2:) < -0.1_wp), 'they die away')
   end subroutine damped_trolley

   subroutine pendulum_modes(failure)
      character(:), allocatable, intent(inout) :: failure
      type(namelist_file_t) :: file
      type(static_t) :: case
      type(error_t), allocatable :: error

      call file%load('cases/mechanism/pendulum_modes.nml', error)
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

end module test_statics
