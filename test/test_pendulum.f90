!> The pendulum of Sect. 4.1 against its closed form and against what the paper says of it.
module test_pendulum
   use closed_forms, only: pendulum_motion
   use taut, only: consistent_start, constrained_ode_t, error_t, integration_options_t, integration_result_t, method_t, &
                   observer_t, ode_system_t, sample_t, simulate, start_report_t, state_t, status_projection_failed, &
                   status_reached_end, trajectory_t, verify, finding_t, wp
   use taut_model_pendulum, only: new_pendulum, pendulum_t
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_pendulum

   real(wp), parameter :: g = 9.81_wp, right_angle = 0.5_wp*acos(-1.0_wp)

   !> Samples every point.
   type, extends(observer_t) :: sampler_t
      integer :: points = 0
      real(wp) :: worst_phi = 0.0_wp, worst_phidot = 0.0_wp, worst_phiddot = 0.0_wp, worst_motion = 0.0_wp
      real(wp) :: worst_tension = 0.0_wp, worst_share = 0.0_wp, worst_raw = 0.0_wp
      real(wp) :: energy = 0.0_wp
      integer :: least_rank = 99, largest_rank = 0
   contains
      procedure :: observe
   end type sampler_t

contains

   !> All tests of this module.
   function collect_pendulum() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('motion and tension to 1e-8 of the closed form', closed_form), &
               new_test('order 5, whatever is replaced', order_five), &
               new_test('steps of the paper, loose tolerance', steps_loose), &
               new_test('steps of the paper, tight tolerance', steps_tight), &
               new_test('energy with honest steps of 0.05 s', honest_energy), &
               new_test('compliance at every point to 1e-12', compliance), &
               new_test('compliance of interpolated output', compliance_dense), &
               new_test('every method follows the closed form', all_methods), &
               new_test('the constraint stated three times', three_times), &
               new_test('acceleration and force form are equal', forms_are_equal), &
               new_test('solvers are equal', solvers_are_equal), &
               new_test('a start beside the constraint is mended', mended_start), &
               new_test('a start that cannot be mended', hopeless_start), &
               new_test('the model passes its own check', model_is_consistent), &
               new_test('backwards to the start', backwards)]
   end function collect_pendulum

   !> Samples the state and compares it with the closed form.
   subroutine observe(self, ode, t, h, y, error)
      class(sampler_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t, h
      real(wp), intent(in), contiguous :: y(:)
      type(error_t), allocatable, intent(inout) :: error
      type(sample_t) :: s
      real(wp) :: angle, period, rate
      integer :: info

      select type (ode)
      class is (constrained_ode_t)
         call ode%sample(t, y, s, info)
      end select
      call pendulum_motion(t, 1.0_wp, g, right_angle, angle, rate, period)
      self%points = self%points + 1
      self%worst_phi = max(self%worst_phi, s%phi)
      self%worst_phidot = max(self%worst_phidot, s%phidot)
      self%worst_phiddot = max(self%worst_phiddot, s%phiddot)
      self%worst_raw = max(self%worst_raw, s%phi_raw)
      self%worst_motion = max(self%worst_motion, &
                              maxval(abs(y - [sin(angle), -cos(angle), rate*cos(angle), rate*sin(angle)])))
      self%worst_tension = max(self%worst_tension, abs(sum(s%lambda) - 3.0_wp*g*cos(angle)))
      self%worst_share = max(self%worst_share, maxval(abs(s%lambda - sum(s%lambda)/size(s%lambda))))
      self%energy = s%energy
      self%least_rank = min(self%least_rank, s%rank)
      self%largest_rank = max(self%largest_rank, s%rank)
      associate (unused_step => h, unused_error => error)
      end associate
   end subroutine observe

   !> Ten seconds from the horizontal.
   subroutine swing(options, method, result, failure, sampler, copies, at_end)
      type(integration_options_t), intent(in) :: options
      type(method_t), intent(in) :: method
      type(integration_result_t), intent(out) :: result
      character(:), allocatable, intent(inout) :: failure
      type(sampler_t), intent(out) :: sampler
      integer, intent(in), optional :: copies
      type(state_t), intent(out), optional :: at_end
      type(pendulum_t) :: model
      type(state_t) :: at
      type(error_t), allocatable :: error
      integer :: stated

      stated = 1
      if (present(copies)) stated = copies
      call new_pendulum(model, 1.0_wp, 1.0_wp, g, stated, error)
      at%x = [1.0_wp, 0.0_wp]
      at%v = [0.0_wp, 0.0_wp]
      call simulate(model, at, 10.0_wp, result, error, method, options, sampler)
      call no_error(failure, error)
      call check(failure, result%status == status_reached_end, 'the end is reached')
      if (present(at_end)) at_end = at
   end subroutine swing

   function tolerance(rtol, atol, control, max_step) result(options)
      real(wp), intent(in) :: rtol, atol, max_step
      character(*), intent(in) :: control
      type(integration_options_t) :: options

      options%rtol = rtol
      options%atol = atol
      options%step_control = control
      options%first_step = 0.01_wp
      options%max_step = max_step
   end function tolerance

   function paper(rtol) result(options)
      real(wp), intent(in) :: rtol
      type(integration_options_t) :: options

      options = tolerance(rtol, min(rtol, 1.0e-6_wp), 'odepkg-2009', 0.1_wp)
   end function paper

   subroutine closed_form(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(method_t) :: method
      type(sampler_t) :: sampler
      real(wp) :: angle, period, rate

      call pendulum_motion(0.0_wp, 1.0_wp, g, right_angle, angle, rate, period)
      call check_close(failure, period, 2.3678_wp, 5.0e-5_wp, 'period')
      call check_close(failure, angle, right_angle, 1.0e-14_wp, 'start')
      options = tolerance(1.0e-11_wp, 1.0e-11_wp, 'standard', 1.0_wp)
      options%output_dt = 1.0_wp
      call swing(options, method, result, failure, sampler)
      call check(failure, sampler%points == 11, 'points')
      call check_below(failure, sampler%worst_motion, 1.0e-8_wp, 'motion')
      call check_below(failure, sampler%worst_tension, 1.0e-8_wp, 'tension')
   end subroutine closed_form

   subroutine order_five(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=24), parameter :: replaced(3) = [character(len=24) :: 'none', 'position', 'position-velocity']
      character(len=8), parameter :: stage(2) = [character(len=8) :: 'newton', 'none']
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(method_t) :: method
      type(sampler_t) :: sampler(2)
      integer :: i, j, k

      do k = 1, 2
         do j = 1, 3
            method%state_projection = replaced(j)
            method%stage_projection = stage(k)
            ! Without projection in the stages nothing holds a position that is not replaced.
            if (k == 2 .and. j == 1) cycle
            do i = 1, 2
               options = tolerance(1.0e-6_wp, 1.0e-6_wp, 'fixed', 1.0_wp)
               options%first_step = 0.02_wp/2**i
               call swing(options, method, result, failure, sampler(i))
            end do
            call check_close(failure, log(sampler(1)%worst_motion/sampler(2)%worst_motion)/log(2.0_wp), 5.0_wp, 0.3_wp, &
                             'order with stages '//trim(stage(k))//', state '//trim(replaced(j)))
         end do
      end do
   end subroutine order_five

   !> Steps and energies of a throwaway prototype of the same control, written in another language: 10 % and the order of
   !! magnitude, because the counts hang on round-off.
   subroutine steps_loose(failure)
      character(:), allocatable, intent(inout) :: failure

      call compare_steps(1.0e-3_wp, 'baseline', 'position-velocity', 206, -0.027_wp, failure)
      call compare_steps(1.0e-3_wp, 'baumgarte', 'position-velocity', 214, -1.1e-3_wp, failure)
      call compare_steps(1.0e-3_wp, 'present', 'none', 185, 0.012_wp, failure)
      call compare_steps(1.0e-3_wp, 'present', 'position', 185, -0.069_wp, failure)
      call compare_steps(1.0e-3_wp, 'present', 'position-velocity', 185, -1.6e-3_wp, failure)
   end subroutine steps_loose

   subroutine steps_tight(failure)
      character(:), allocatable, intent(inout) :: failure

      call compare_steps(1.0e-9_wp, 'baseline', 'position-velocity', 785, -0.044_wp, failure)
      call compare_steps(1.0e-9_wp, 'baumgarte', 'position-velocity', 808, -2.1e-3_wp, failure)
      call compare_steps(1.0e-9_wp, 'present', 'none', 790, -3.7e-6_wp, failure)
      call compare_steps(1.0e-9_wp, 'present', 'position', 790, -4.0e-7_wp, failure)
      call compare_steps(1.0e-9_wp, 'present', 'position-velocity', 790, -7.0e-8_wp, failure)
      call compare_steps(1.0e-9_wp, 'braun-goldfarb', 'position-velocity', 1184, 3.0e-8_wp, failure)
   end subroutine steps_tight

   subroutine compare_steps(rtol, name, replaced, steps, energy, failure)
      real(wp), intent(in) :: rtol, energy
      character(*), intent(in) :: name, replaced
      integer, intent(in) :: steps
      character(:), allocatable, intent(inout) :: failure
      type(integration_result_t) :: result
      type(method_t) :: method
      type(sampler_t) :: sampler

      method%name = name
      method%state_projection = replaced
      call swing(paper(rtol), method, result, failure, sampler)
      call check_close(failure, real(result%steps, wp), real(steps, wp), 0.1_wp*steps, name//' '//replaced//': steps')
      call check(failure, sampler%energy/energy > 0.3_wp .and. sampler%energy/energy < 3.0_wp, &
                 name//' '//replaced//': order of the energy error')
   end subroutine compare_steps

   subroutine honest_energy(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_result_t) :: result
      type(method_t) :: method
      type(sampler_t) :: both, position
      real(wp) :: angle, period, rate

      method%state_projection = 'position'
      call swing(tolerance(1.0e-3_wp, 1.0e-6_wp, 'standard', 0.05_wp), method, result, failure, position)
      call check(failure, result%steps >= 200 .and. result%steps <= 202, 'steps')
      method%state_projection = 'position-velocity'
      call swing(tolerance(1.0e-3_wp, 1.0e-6_wp, 'standard', 0.05_wp), method, result, failure, both)
      call check(failure, result%steps >= 200 .and. result%steps <= 202, 'steps with both')
      call pendulum_motion(0.0_wp, 1.0_wp, g, right_angle, angle, rate, period)
      call check_below(failure, position%energy*period/10.0_wp, 1.0e-4_wp*g, 'energy change per period')
      call check_below(failure, both%energy, abs(position%energy)/20.0_wp, 'energy change with both')
   end subroutine honest_energy

   subroutine compliance(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=16), parameter :: stage(2) = [character(len=16) :: 'newton', 'none']
      type(integration_result_t) :: result
      type(method_t) :: method
      type(sampler_t) :: sampler
      integer :: i, j

      do j = 1, 2
         do i = 3, 11, 2
            method%stage_projection = stage(j)
            call swing(tolerance(10.0_wp**(-i), 10.0_wp**(-i), 'standard', 0.1_wp), method, result, failure, sampler)
            call check_below(failure, sampler%worst_phi, 1.0e-12_wp, 'position')
            call check_below(failure, sampler%worst_phidot, 1.0e-12_wp, 'velocity')
            call check_below(failure, sampler%worst_phiddot, 1.0e-12_wp, 'acceleration')
            call check(failure, sampler%worst_raw > 1.0e-15_wp, 'what was projected is reported')
         end do
      end do
   end subroutine compliance

   subroutine compliance_dense(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(method_t) :: method
      type(sampler_t) :: sampler

      options = tolerance(1.0e-7_wp, 1.0e-7_wp, 'standard', 0.1_wp)
      options%output_dt = 0.013_wp
      call swing(options, method, result, failure, sampler)
      call check_below(failure, sampler%worst_phi, 1.0e-12_wp, 'position')
      call check_below(failure, sampler%worst_phidot, 1.0e-12_wp, 'velocity')
      call check_below(failure, sampler%worst_motion, 2.0e-5_wp, 'motion between the steps')
   end subroutine compliance_dense

   subroutine all_methods(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=24), parameter :: names(12) = [character(len=24) :: 'baseline', 'baumgarte', 'braun-goldfarb', 'yu-chen', &
                                                  'coordinate-projection', 'penalty', 'minimal-coordinates', &
                                                  'augmented-lagrangian', 'udwadia-kalaba', 'dummy-derivatives', &
                                                  'fuhrer-leimkuhler', 'embedded-projection']
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(method_t) :: method
      type(sampler_t) :: sampler
      real(wp) :: bound
      integer :: i

      method%correction_tolerance = 1.0e-9_wp
      method%stiffness = 1.0e7_wp
      do i = 1, size(names)
         method%name = names(i)
         options = tolerance(1.0e-11_wp, 1.0e-11_wp, 'standard', 0.1_wp)
         bound = 1.0e-8_wp
         if (names(i) == 'penalty') then
            ! The rod gives way by 3 m g/stiffness.
            options%rtol = 1.0e-7_wp
            options%atol = 1.0e-7_wp
            bound = 1.0e-2_wp
         end if
         call swing(options, method, result, failure, sampler)
         call check_below(failure, sampler%worst_motion, bound, trim(names(i))//': motion')
         ! What the rod gives way is no tension; what the reaction is on the average of a step lags behind it.
         if (.not. any(names(i) == [character(len=24) :: 'penalty', 'embedded-projection'])) &
            call check_below(failure, sampler%worst_tension, 1.0e-7_wp, trim(names(i))//': tension')
         if (names(i) == 'coordinate-projection') call check_below(failure, sampler%worst_phi, 1.0e-12_wp, 'compliance')
         if (names(i) == 'yu-chen') call check_below(failure, sampler%worst_phi, 1.0e-9_wp, 'compliance of yu-chen')
      end do
   end subroutine all_methods

   subroutine three_times(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=16), parameter :: solvers(3) = [character(len=16) :: 'auto', 'dgelsd', 'factor']
      character(len=16), parameter :: weights(2) = [character(len=16) :: 'identity', 'mass']
      type(integration_result_t) :: result
      type(method_t) :: method
      type(sampler_t) :: once, thrice
      type(state_t) :: at, reference
      integer :: i, j

      call swing(tolerance(1.0e-9_wp, 1.0e-9_wp, 'standard', 0.1_wp), method, result, failure, once, at_end=reference)
      do j = 1, 2
         method%weight = weights(j)
         do i = 1, 3
            method%solver = solvers(i)
            call swing(tolerance(1.0e-9_wp, 1.0e-9_wp, 'standard', 0.1_wp), method, result, failure, thrice, 3, at)
            call check_below(failure, maxval(abs([at%x - reference%x, at%v - reference%v])), 1.0e-10_wp, 'motion')
            call check(failure, thrice%least_rank == 1 .and. thrice%largest_rank == 1, 'rank 1 all along')
            call check_below(failure, thrice%worst_share, 1.0e-11_wp, 'a third of the tension each')
            call check_close(failure, thrice%worst_tension, once%worst_tension, 1.0e-8_wp, 'tension')
            call check_below(failure, thrice%worst_phi, 1.0e-12_wp, 'compliance')
         end do
      end do
   end subroutine three_times

   subroutine forms_are_equal(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_result_t) :: result
      type(method_t) :: method
      type(sampler_t) :: sampler
      type(state_t) :: acceleration, force

      call swing(tolerance(1.0e-6_wp, 1.0e-6_wp, 'fixed', 0.1_wp), method, result, failure, sampler, at_end=acceleration)
      method%form = 'force'
      call swing(tolerance(1.0e-6_wp, 1.0e-6_wp, 'fixed', 0.1_wp), method, result, failure, sampler, at_end=force)
      call check_below(failure, maxval(abs([acceleration%x - force%x, acceleration%v - force%v])), 1.0e-12_wp, 'difference')
   end subroutine forms_are_equal

   subroutine solvers_are_equal(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_result_t) :: result
      type(method_t) :: method
      type(sampler_t) :: sampler
      type(state_t) :: auto, other

      call swing(tolerance(1.0e-6_wp, 1.0e-6_wp, 'fixed', 0.1_wp), method, result, failure, sampler, at_end=auto)
      method%solver = 'dgelsd'
      call swing(tolerance(1.0e-6_wp, 1.0e-6_wp, 'fixed', 0.1_wp), method, result, failure, sampler, at_end=other)
      call check_below(failure, maxval(abs([auto%x - other%x, auto%v - other%v])), 1.0e-12_wp, 'dgelsd')
      method%solver = 'factor'
      call swing(tolerance(1.0e-6_wp, 1.0e-6_wp, 'fixed', 0.1_wp), method, result, failure, sampler, at_end=other)
      call check_below(failure, maxval(abs([auto%x - other%x, auto%v - other%v])), 1.0e-12_wp, 'factor')
   end subroutine solvers_are_equal

   subroutine mended_start(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(method_t) :: method
      type(start_report_t) :: report
      type(state_t) :: at
      type(error_t), allocatable :: error

      call new_pendulum(model, 2.0_wp, 5.0_wp, g, 1, error)
      at%x = [6.0_wp, 8.0_wp]
      at%v = [1.0_wp, 0.0_wp]
      call consistent_start(model, method, at, report, error)
      call no_error(failure, error)
      call check_below(failure, maxval(abs(at%x - [3.0_wp, 4.0_wp])), 1.0e-14_wp, 'position: straight to the circle')
      call check_below(failure, maxval(abs(at%v - [0.64_wp, -0.48_wp])), 1.0e-14_wp, 'velocity: its tangential part')
      call check_close(failure, report%moved_x, 4.0_wp, 1.0e-14_wp, 'how far')
      call check_close(failure, report%phi_given, 5.0_wp, 1.0e-14_wp, 'violation as given')
      call check(failure, report%rank == 1 .and. report%freedoms == 1, 'rank and freedoms')
   end subroutine mended_start

   subroutine hopeless_start(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error

      call new_pendulum(model, 1.0_wp, 1.0_wp, g, 1, error)
      at%x = [0.0_wp, 0.0_wp]
      at%v = [0.0_wp, 0.0_wp]
      call simulate(model, at, 1.0_wp, result, error)
      call check(failure, allocated(error), 'a start at the pivot is refused')
      if (allocated(error)) call check(failure, index(error%line(), 'constraint 1') > 0, 'the constraint is named')
   end subroutine hopeless_start

   subroutine model_is_consistent(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(finding_t), allocatable :: findings(:)
      type(state_t) :: at
      type(error_t), allocatable :: error

      call new_pendulum(model, 2.0_wp, 1.3_wp, g, 2, error)
      at%x = [0.7_wp, -1.1_wp]
      at%v = [2.0_wp, 0.5_wp]
      call verify(model, at, findings, error)
      call no_error(failure, error)
      if (size(findings) > 0) call check(failure, .false., findings(1)%message)
   end subroutine model_is_consistent

   subroutine backwards(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error

      call new_pendulum(model, 1.0_wp, 1.0_wp, g, 1, error)
      options%rtol = 1.0e-11_wp
      options%atol = 1.0e-11_wp
      at%x = [1.0_wp, 0.0_wp]
      at%v = [0.0_wp, 0.0_wp]
      call simulate(model, at, 3.0_wp, result, error, options=options)
      call simulate(model, at, 0.0_wp, result, error, options=options)
      call no_error(failure, error)
      call check_below(failure, maxval(abs([at%x - [1.0_wp, 0.0_wp], at%v])), 1.0e-8_wp, 'start')
   end subroutine backwards

end module test_pendulum
