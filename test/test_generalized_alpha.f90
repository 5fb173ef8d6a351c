!> Tests of the generalized-alpha method: order, damping, both indices, what it is refused with.
module test_generalized_alpha
   use springs, only: new_spring, spring_t
   use systems, only: actuator, driven_pivot, new_compound, new_coupler, new_particle, sleigh_in_space
   use taut, only: constrained_ode_t, error_t, integration_options_t, integration_result_t, mechanical_system_t, method_t, &
                   sample_t, simulate, state_t, status_reached_end, wp
   use taut_model_pendulum, only: new_pendulum, pendulum_t
   use taut_model_rigid_bodies, only: new_rigid_bodies, rigid_bodies_t, rigid_body_t, spherical_joint_t
   use taut_rotation, only: cross, matrix_of_quaternion, quaternion_of_vector
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_generalized_alpha

   real(wp), parameter :: g = 9.81_wp
   !> Index 3, and the stabilized index 2.
   character(len=17), parameter :: levels(2) = [character(len=17) :: 'position', 'position-velocity']

contains

   !> All tests of this module.
   function collect_generalized_alpha() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('order 2 of positions, velocities and multipliers', orders), &
               new_test('order 2 on the rotation group', heavy_top), &
               new_test('constraints of all kinds', all_constraints), &
               new_test('index 3 complies at position level alone', compliance), &
               new_test('what a step leaves of short oscillations', spectral_radius), &
               new_test('its own steps', controlled), &
               new_test('a stiff spring costs the same at any stiffness', stiff_spring), &
               new_test('multipliers do not feel a short step', short_steps), &
               new_test('fixed steps are the same at any tolerance', any_tolerance), &
               new_test('refused where it does not belong', refused)]
   end function collect_generalized_alpha

   !> Fixed steps.
   function steps_of(h, rho) result(options)
      real(wp), intent(in) :: h
      real(wp), intent(in), optional :: rho
      type(integration_options_t) :: options

      options = integration_options_t(integrator='generalized-alpha', step_control='fixed', first_step=h, rtol=1.0e-10_wp, &
                                      atol=1.0e-10_wp)
      if (present(rho)) options%spectral_radius = rho
   end function steps_of

   !> The end state of a run, and what there is to know of it.
   subroutine run(model, x, v, w, t_end, options, level, at, s, failure, result)
      class(mechanical_system_t), intent(in) :: model
      real(wp), intent(in) :: x(:), v(:), w(:), t_end
      type(integration_options_t), intent(in) :: options
      character(*), intent(in) :: level
      type(state_t), intent(out) :: at
      type(sample_t), intent(out) :: s
      character(:), allocatable, intent(inout) :: failure
      type(integration_result_t), intent(out), optional :: result
      type(integration_result_t) :: how
      type(error_t), allocatable :: error
      class(constrained_ode_t), allocatable :: ode
      real(wp), allocatable :: y(:)
      integer :: info

      at%x = x
      at%v = v
      at%w = w
      call simulate(model, at, t_end, how, error, method_t(state_projection=level), options, ode=ode)
      call no_error(failure, error)
      if (allocated(how%error)) call check(failure, .false., how%error%line())
      call check(failure, how%status == status_reached_end, 'the end is reached')
      if (allocated(failure)) return
      allocate (y(ode%size()))
      call ode%pack(at, y)
      call ode%sample(at%t, y, s, info)
      if (present(result)) result = how
   end subroutine run

   !> Errors fall with the square of the step.
   subroutine check_orders(name, model, x, v, w, t_end, h, failure)
      character(*), intent(in) :: name
      class(mechanical_system_t), intent(in) :: model
      real(wp), intent(in) :: x(:), v(:), w(:), t_end, h
      character(:), allocatable, intent(inout) :: failure
      type(state_t) :: exact, at
      type(sample_t) :: exact_sample, s
      real(wp) :: e(3, 2)
      integer :: i, level

      call run(model, x, v, w, t_end, integration_options_t(rtol=1.0e-12_wp, atol=1.0e-13_wp), levels(2), exact, exact_sample, &
               failure)
      do level = 1, 2
         do i = 1, 2
            call run(model, x, v, w, t_end, steps_of(h/2**i), levels(level), at, s, failure)
            if (allocated(failure)) then
               failure = name//': '//failure
               return
            end if
            e(:, i) = [norm2(at%x - exact%x), norm2([at%v - exact%v, at%w - exact%w]), norm2(s%lambda - exact_sample%lambda)]
         end do
         do i = 1, merge(3, 2, model%c > 0)
            call check_close(failure, log(e(i, 1)/e(i, 2))/log(2.0_wp), 2.0_wp, 0.15_wp, name//', '//trim(levels(level)))
         end do
         call check_below(failure, s%phi, 1.0e-11_wp, name//': positions')
      end do
   end subroutine check_orders

   subroutine orders(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: pendulum
      type(error_t), allocatable :: error

      call new_pendulum(pendulum, 1.0_wp, 1.0_wp, g, 1, error)
      call check_orders('pendulum', pendulum, [1.0_wp, 0.0_wp], [0.0_wp, 0.0_wp], [real(wp) ::], 1.0_wp, 0.02_wp, failure)
      call new_pendulum(pendulum, 1.0_wp, 1.0_wp, g, 3, error)
      call check_orders('redundant', pendulum, [1.0_wp, 0.0_wp], [0.0_wp, 0.0_wp], [real(wp) ::], 1.0_wp, 0.02_wp, failure)
      call check_orders('rheonomic', new_particle(driven_pivot, rate=5.0_wp, amplitude=0.2_wp), [1.0_wp, 0.0_wp], &
                        [0.0_wp, 0.0_wp], [real(wp) ::], 1.0_wp, 0.01_wp, failure)
   end subroutine orders

   subroutine heavy_top(failure)
      character(:), allocatable, intent(inout) :: failure
      type(rigid_bodies_t) :: system
      type(rigid_body_t) :: body
      type(error_t), allocatable :: error
      real(wp) :: x(7)

      body%m = 1.5_wp
      body%s = [0.0_wp, 0.0_wp, 0.0_wp]
      body%j(1, 1) = 0.11_wp
      body%j(2, 2) = 0.11_wp
      body%j(3, 3) = 0.05_wp
      call new_rigid_bodies(system, [body], [spherical_joint_t(1, 0, [0.0_wp, 0.0_wp, -0.4_wp], [0.0_wp, 0.0_wp, 0.0_wp])], &
                            [0.0_wp, 0.0_wp, -g], error)
      call no_error(failure, error)
      x(4:7) = quaternion_of_vector([0.5_wp, 0.0_wp, 0.0_wp])
      x(1:3) = matmul(matrix_of_quaternion(x(4:7)), [0.0_wp, 0.0_wp, 0.4_wp])
      associate (omega => [0.0_wp, 0.5_wp, 30.0_wp])
         call check_orders('top', system, x, [matmul(matrix_of_quaternion(x(4:7)), cross(omega, [0.0_wp, 0.0_wp, 0.4_wp])), &
                                              omega], [real(wp) ::], 0.5_wp, 0.004_wp, failure)
      end associate
   end subroutine heavy_top

   subroutine all_constraints(failure)
      character(:), allocatable, intent(inout) :: failure

      call check_orders('mixed', new_particle(sleigh_in_space), [0.0_wp, 0.0_wp, 0.3_wp, 0.0_wp], &
                        [1.0_wp, 0.3_wp, 0.4_wp, 0.0_wp], [real(wp) ::], 1.0_wp, 0.04_wp, failure)
      call check_orders('coordinates of their own', new_compound(), [0.3_wp, -0.4_wp, 0.8_wp, 0.6_wp], &
                        [0.0_wp, 0.0_wp, 0.0_wp], [real(wp) ::], 1.0_wp, 0.02_wp, failure)
      call check_orders('redundant at times', new_coupler(3), [0.6_wp, -0.8_wp, 0.0_wp], [0.0_wp, 0.0_wp, 0.0_wp], &
                        [real(wp) ::], 1.0_wp, 0.02_wp, failure)
      call check_orders('other states', new_particle(actuator), [0.0_wp], [0.0_wp], [3.0_wp], 1.0_wp, 0.04_wp, failure)
   end subroutine all_constraints

   subroutine compliance(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: pendulum
      type(error_t), allocatable :: error
      type(state_t) :: at
      type(sample_t) :: s
      real(wp) :: violation(2)
      integer :: i

      call new_pendulum(pendulum, 1.0_wp, 1.0_wp, g, 1, error)
      do i = 1, 2
         call run(pendulum, [1.0_wp, 0.0_wp], [0.0_wp, 0.0_wp], [real(wp) ::], 1.0_wp, steps_of(0.02_wp/2**i), levels(1), at, s, &
                  failure)
         call check_below(failure, s%phi, 1.0e-12_wp, 'index 3: positions')
         violation(i) = s%phidot
      end do
      call check(failure, violation(2) > 1.0e-6_wp, 'index 3: velocities are off')
      call check_close(failure, log(violation(1)/violation(2))/log(2.0_wp), 2.0_wp, 0.2_wp, 'index 3: as the square of the step')
      call run(pendulum, [1.0_wp, 0.0_wp], [0.0_wp, 0.0_wp], [real(wp) ::], 1.0_wp, steps_of(0.01_wp), levels(2), at, s, failure)
      call check_below(failure, max(s%phi, s%phidot, s%phiddot), 1.0e-12_wp, 'stabilized index 2: all levels')
   end subroutine compliance

   !> A mass on a spring whose period is a hundredth of the step, off its length by little.
   subroutine spectral_radius(failure)
      character(:), allocatable, intent(inout) :: failure
      real(wp), parameter :: off = 1.0e-8_wp, rho = 0.8_wp
      real(wp) :: x(3)
      integer :: i

      call check_below(failure, left(0.0_wp, 10)/off, 1.0e-4_wp, 'nothing')
      x = [(left(rho, 29 + i), i=1, 3)]
      call check(failure, x(1) > 1.0e-3_wp*off .and. x(3) < x(1), 'some')
      ! A double root: (a + b k) rho^k.
      call check_below(failure, abs(x(3) - 2.0_wp*rho*x(2) + rho**2*x(1))/x(2), 1.0e-2_wp, 'as much as the radius says')
      ! But for the phase, 4/(h omega) a step.
      call check_close(failure, left(1.0_wp, 40)/off, cos(160.0_wp/sqrt(4.0e5_wp)), 1.0e-3_wp, 'all')

   contains

      !> What is left after so many steps.
      real(wp) function left(radius, steps)
         real(wp), intent(in) :: radius
         integer, intent(in) :: steps
         type(spring_t) :: spring
         type(state_t) :: at
         type(sample_t) :: s

         spring = new_spring(4.0e7_wp)
         spring%gravity = 0.0_wp
         call run(spring, [1.0_wp + off, 0.0_wp], [0.0_wp, 0.0_wp], [real(wp) ::], 0.1_wp*steps, steps_of(0.1_wp, radius), &
                  levels(2), at, s, failure)
         left = abs(at%x(1) - 1.0_wp)
      end function left

   end subroutine spectral_radius

   subroutine controlled(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: pendulum
      type(error_t), allocatable :: error
      type(integration_result_t) :: result
      type(integration_options_t) :: options
      type(state_t) :: at, exact
      type(sample_t) :: s
      real(wp) :: e(2)
      integer :: i, level, steps(2)

      call new_pendulum(pendulum, 1.0_wp, 1.0_wp, g, 1, error)
      call run(pendulum, [1.0_wp, 0.0_wp], [0.0_wp, 0.0_wp], [real(wp) ::], 2.0_wp, &
               integration_options_t(rtol=1.0e-12_wp, atol=1.0e-13_wp), levels(2), exact, s, failure)
      do level = 1, 2
         do i = 1, 2
            options = integration_options_t(integrator='generalized-alpha', rtol=1.0e-3_wp*0.01_wp**i, atol=1.0e-6_wp*0.01_wp**i)
            call run(pendulum, [1.0_wp, 0.0_wp], [0.0_wp, 0.0_wp], [real(wp) ::], 2.0_wp, options, levels(level), at, s, &
                     failure, result)
            if (allocated(failure)) return
            e(i) = norm2(at%x - exact%x)
            steps(i) = result%steps
            call check(failure, result%rejected < 0.1_wp*result%steps, 'few rejected')
            call check(failure, result%jacobians < 0.2_wp*result%steps, 'few Jacobians')
         end do
         ! A hundredth of the tolerance of an error of order 3: 4.6 times the steps, a twentieth of the error.
         call check_close(failure, real(steps(2), wp)/steps(1), 4.6_wp, 0.7_wp, 'steps')
         call check_close(failure, e(1)/e(2), 21.5_wp, 8.0_wp, 'errors')
      end do
   end subroutine controlled

   subroutine stiff_spring(failure)
      character(:), allocatable, intent(inout) :: failure
      type(state_t) :: at, rigid
      type(sample_t) :: s
      type(integration_result_t) :: result
      type(pendulum_t) :: pendulum
      type(error_t), allocatable :: error
      type(integration_options_t) :: options
      integer :: i, steps(2)

      call new_pendulum(pendulum, 1.0_wp, 1.0_wp, g, 1, error)
      call run(pendulum, [1.0_wp, 0.0_wp], [0.0_wp, 0.0_wp], [real(wp) ::], 1.0_wp, &
               integration_options_t(rtol=1.0e-12_wp, atol=1.0e-13_wp), levels(2), rigid, s, failure)
      options = integration_options_t(integrator='generalized-alpha', rtol=1.0e-6_wp, atol=1.0e-9_wp)
      do i = 1, 2
         call run(new_spring(1.0e6_wp*100.0_wp**i), [1.0_wp, 0.0_wp], [0.0_wp, 0.0_wp], [real(wp) ::], 1.0_wp, options, &
                  levels(2), at, s, failure, result)
         if (allocated(failure)) return
         steps(i) = result%steps
         call check_below(failure, norm2(at%x - rigid%x), 3.0e-4_wp, 'distance from the rod''s motion')
      end do
      call check(failure, abs(steps(1) - steps(2)) <= 0.1_wp*steps(1), 'as many for both')
   end subroutine stiff_spring

   !> Steps of a microsecond: the multipliers' part of the matrix is 1e13 times smaller than that of the masses.
   subroutine short_steps(failure)
      character(:), allocatable, intent(inout) :: failure
      type(state_t) :: at
      type(sample_t) :: s
      type(pendulum_t) :: pendulum
      type(error_t), allocatable :: error
      integer :: level

      call new_pendulum(pendulum, 1.0e3_wp, 1.0_wp, g, 3, error)
      do level = 1, 2
         call run(pendulum, [1.0_wp, 0.0_wp], [0.0_wp, -1.0_wp], [real(wp) ::], 2.0e-5_wp, steps_of(1.0e-6_wp), levels(level), &
                  at, s, failure)
         call check_below(failure, s%phi, 1.0e-14_wp, 'positions')
         call check_below(failure, s%phidot, 1.0e-9_wp, 'velocities')
      end do
   end subroutine short_steps

   !> What is left by the iteration adds up over the steps: it has to be far below their own error, of 3e-5 m here, and is not the
   !! tolerance's.
   subroutine any_tolerance(failure)
      character(:), allocatable, intent(inout) :: failure
      real(wp), parameter :: tolerances(*) = [1.0e-3_wp, 1.0e-6_wp, 1.0e-12_wp]
      type(state_t) :: at, fine
      type(sample_t) :: s
      type(pendulum_t) :: pendulum
      type(integration_options_t) :: options
      type(error_t), allocatable :: error
      integer :: i

      call new_pendulum(pendulum, 1.0_wp, 1.0_wp, g, 1, error)
      call run(pendulum, [1.0_wp, 0.0_wp], [0.0_wp, 0.0_wp], [real(wp) ::], 5.0_wp, steps_of(1.0e-3_wp), levels(2), fine, s, &
               failure)
      options = steps_of(1.0e-3_wp)
      do i = 1, size(tolerances)
         options%rtol = tolerances(i)
         options%atol = 1.0e-3_wp*sqrt(tolerances(i))
         call run(pendulum, [1.0_wp, 0.0_wp], [0.0_wp, 0.0_wp], [real(wp) ::], 5.0_wp, options, levels(2), at, s, failure)
         call check_below(failure, maxval(abs(at%x - fine%x)), 1.0e-6_wp, 'what the tolerance changes')
      end do
   end subroutine any_tolerance

   subroutine refused(failure)
      character(:), allocatable, intent(inout) :: failure

      call refuse(method_t(name='baseline'), steps_of(0.1_wp), 'does not take its right-hand side')
      call refuse(method_t(state_projection='none'), steps_of(0.1_wp), 'state_projection = "none"')
      call refuse(method_t(), steps_of(0.1_wp, rho=1.5_wp), 'spectral_radius')

   contains

      subroutine refuse(method, options, words)
         type(method_t), intent(in) :: method
         type(integration_options_t), intent(in) :: options
         character(*), intent(in) :: words
         type(pendulum_t) :: pendulum
         type(state_t) :: at
         type(integration_result_t) :: result
         type(error_t), allocatable :: error

         call new_pendulum(pendulum, 1.0_wp, 1.0_wp, g, 1, error)
         at%x = [1.0_wp, 0.0_wp]
         at%v = [0.0_wp, 0.0_wp]
         call simulate(pendulum, at, 1.0_wp, result, error, method, options)
         call check(failure, allocated(error), words)
         if (allocated(error)) call check(failure, index(error%line(), words) > 0, error%line())
      end subroutine refuse

   end subroutine refused

end module test_generalized_alpha
