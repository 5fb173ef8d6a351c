!> The integrator where it is easily wrong: ends that are no numbers, events at their own sign change, odd options.
module test_ode_edges
   use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_quiet_nan, ieee_value
   use systems, only: driven_pivot, new_particle
   use taut, only: block_diagonal_t, controller_constants_t, error_t, events_t, integration_options_t, integration_result_t, &
                   integrator_t, method_t, note_bound_by_stability, ode_system_t, rhs_ok, simulate, state_t, status_event, &
                   status_no_progress, status_not_finite, status_reached_end, status_too_many_steps, step_control_t, &
                   trajectory_t, wp
   use taut_model_pendulum, only: new_pendulum, pendulum_t
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_ode_edges

   real(wp), parameter :: g = 9.81_wp

   !> The pendulum at its lowest point: x changes its sign; in any unit.
   type, extends(events_t) :: lowest_t
      real(wp) :: unit = 1.0_wp
   contains
      procedure :: evaluate
   end type lowest_t

   !> y = 10: never.
   type, extends(events_t) :: crossing_t
   contains
      procedure :: evaluate => far_value
   end type crossing_t

   !> y' = -k (y - cos t).
   type, extends(ode_system_t) :: stiff_t
      real(wp) :: k = 1.0_wp
   contains
      procedure :: rhs
   end type stiff_t

   !> A pendulum whose weight is the root of what is left of a second.
   type, extends(pendulum_t) :: fading_t
   contains
      procedure :: force => fading_force
   end type fading_t

contains

   !> All tests of this module.
   function collect_ode_edges() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('an end that is no number is refused', no_number), &
               new_test('a start that is no number is refused', no_number_at_start), &
               new_test('a new start from an event does not meet it again', restart_from_event), &
               new_test('an event in a unit that underflows', tiny_event), &
               new_test('events that are not set up are refused', events_not_set), &
               new_test('a far end with a terminal event', far_end), &
               new_test('yu-chen with a tolerance of its own', rare_corrections), &
               new_test('a projection before the last stage costs no evaluation', projected_first), &
               new_test('steps that contradict each other are refused', contradictions), &
               new_test('a trajectory is of one run and no longer than it', trajectory_anew), &
               new_test('the end already', no_time), &
               new_test('a force that is not a number is called that', force_not_a_number), &
               new_test('velocities are measured by tolerances of their own', part_of_norm), &
               new_test('steps that do not get on end a run', no_progress), &
               new_test('steps bound by stability are told once', bound_by_stability), &
               new_test('an integral with round-off is taken as it is', noisy_integral), &
               new_test('a mass matrix that does not fit its blocks', mass_does_not_fit)]
   end function collect_ode_edges

   subroutine evaluate(self, ode, t, y, g)
      class(lowest_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(out) :: g(:)

      g(1) = self%unit*y(1)
      associate (unused_time => t, unused_ode => ode)
      end associate
   end subroutine evaluate

   !> A pendulum at rest in the horizontal.
   subroutine horizontal(model, at)
      type(pendulum_t), intent(out) :: model
      type(state_t), intent(out) :: at
      type(error_t), allocatable :: error

      call new_pendulum(model, 1.0_wp, 1.0_wp, g, 1, error)
      at%x = [1.0_wp, 0.0_wp]
      at%v = [0.0_wp, 0.0_wp]
   end subroutine horizontal

   subroutine far_value(self, ode, t, y, g)
      class(crossing_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(out) :: g(:)

      g(1) = y(1) - 10.0_wp
      associate (unused_events => self, unused_time => t, unused_ode => ode)
      end associate
   end subroutine far_value

   !> Where a shorter step has no smaller error, it holds, and the next one may be longer than the one that was refused first.
   subroutine noisy_integral(failure)
      character(:), allocatable, intent(inout) :: failure
      type(step_control_t) :: control
      type(error_t), allocatable :: error
      real(wp) :: h_next
      logical :: accepted, vain

      call control%init(1, integration_options_t(rtol=1.0e-8_wp), 5, controller_constants_t(), error)
      call no_error(failure, error)
      if (allocated(failure)) return
      call refused(0.1_wp, 1.0e-3_wp, 'far too large')
      call refused(0.02_wp, 1.0e-4_wp, 'smaller')
      call decide(0.01_wp, 1.0e-4_wp)
      call check(failure, accepted .and. vain, 'no smaller: round-off')
      call check_below(failure, 0.1_wp, h_next, 'on with longer steps')
      call control%step_on()
      call refused(0.1_wp, 1.0e-3_wp, 'behind it, errors count again')

   contains

      subroutine decide(h, off)
         real(wp), intent(in) :: h, off

         h_next = h
         call control%decide_by_integral(h, off, 1.0_wp, 1.0_wp, h_next, accepted, vain)
      end subroutine decide

      subroutine refused(h, off, what)
         real(wp), intent(in) :: h, off
         character(*), intent(in) :: what

         call decide(h, off)
         call check(failure, .not. (accepted .or. vain), what)
         call check_below(failure, h_next, h, what//': a shorter one')
      end subroutine refused

   end subroutine noisy_integral

   subroutine rhs(self, t, y, dydt, info)
      class(stiff_t), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(out), contiguous :: dydt(:)
      integer, intent(out) :: info

      info = rhs_ok
      dydt = -self%k*(y - cos(t))
   end subroutine rhs

   subroutine fading_force(self, at, value)
      class(fading_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = 0.0_wp
      value(2) = -g*ieee_value(g, ieee_quiet_nan)
      if (at%t < 1.0_wp) value(2) = -g*sqrt(1.0_wp - at%t)
      associate (unused => self)
      end associate
   end subroutine fading_force

   subroutine trajectory_anew(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(integration_result_t) :: result
      type(trajectory_t) :: path
      type(state_t) :: at
      type(error_t), allocatable :: error
      integer :: i

      do i = 1, 2
         call horizontal(model, at)
         call simulate(model, at, real(3 - i, wp), result, error, observer=path)
         call no_error(failure, error)
         call check(failure, path%points == result%steps + 1, 'the points of this run')
         call check(failure, size(path%t) == path%points .and. size(path%y, 2) == path%points, 'and no more')
         call check_close(failure, path%t(1), 0.0_wp, 0.0_wp, 'from its start')
         call check_close(failure, path%t(path%points), real(3 - i, wp), 0.0_wp, 'to its end')
      end do
   end subroutine trajectory_anew

   subroutine no_time(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error

      call horizontal(model, at)
      call simulate(model, at, 1.0_wp, result, error)
      call no_error(failure, error)
      call check(failure, size(result%notes) == 0, 'nothing to say')
      call simulate(model, at, 1.0_wp, result, error)
      call no_error(failure, error)
      call check(failure, result%status == status_reached_end .and. result%steps == 0, 'it is there')
      call check(failure, size(result%notes) == 1, 'and says so')
      if (allocated(failure)) return
      call check(failure, index(result%notes(1)%text(), 'already') > 0, result%notes(1)%text())
   end subroutine no_time

   subroutine force_not_a_number(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(fading_t) :: fading
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error

      call horizontal(model, at)
      fading%pendulum_t = model
      call simulate(fading, at, 2.0_wp, result, error)
      call check(failure, allocated(error), 'the call says that it did not go well')
      call check(failure, result%status == status_not_finite, 'status')
      call check_close(failure, result%t, 1.0_wp, 1.0e-9_wp, 'where')
      call check(failure, allocated(result%error), 'why')
      if (allocated(failure)) return
      call check(failure, index(result%error%line(), 'the force on') > 0 .and. index(result%error%line(), 'not a number') > 0, &
                 result%error%line())
   end subroutine force_not_a_number

   subroutine part_of_norm(failure)
      character(:), allocatable, intent(inout) :: failure
      type(step_control_t) :: control
      type(error_t), allocatable :: error
      real(wp), parameter :: still(1) = 0.0_wp

      call control%init(2, integration_options_t(atol_of=[1.0e-3_wp, 1.0e-6_wp], norm='max'), 5, controller_constants_t(), error)
      call no_error(failure, error)
      call check_close(failure, control%norm([2.0e-6_wp], still, still, before=1), 2.0_wp, 1.0e-12_wp, 'the second entry')
      call check_close(failure, control%norm([2.0e-6_wp], still, still), 2.0e-3_wp, 1.0e-12_wp, 'the first')
   end subroutine part_of_norm

   subroutine no_progress(failure)
      character(:), allocatable, intent(inout) :: failure
      type(stiff_t) :: ode
      type(integrator_t) :: integrator
      type(integration_result_t) :: result
      type(crossing_t) :: crossing
      type(error_t), allocatable :: error
      real(wp) :: t, y(1)
      integer :: i

      call integrator%init(1, integration_options_t(max_steps=5000), error)
      call no_error(failure, error)
      ode%k = 1.0e10_wp
      do i = 1, 2
         t = 0.5_wp
         y = 1.0_wp
         if (i == 1) call integrator%run(ode, t, y, 100.0_wp, result)
         crossing%direction = [0]
         crossing%terminal = [.true.]
         if (i == 2) call integrator%run(ode, t, y, 100.0_wp, result, events=crossing)
         if (i == 1) then
            call check(failure, result%status == status_no_progress .and. result%steps <= 3000, 'it ends')
            call check(failure, allocated(result%error), 'with a reason')
         else
            call check(failure, result%status == status_too_many_steps, 'an event may come any time')
         end if
      end do

      call integrator%init(1, integration_options_t(max_steps=5000, max_step=1.0e-7_wp), error)
      call no_error(failure, error)
      ode%k = 1.0_wp
      t = 0.5_wp
      y = 1.0_wp
      call integrator%run(ode, t, y, 100.0_wp, result)
      call check(failure, result%status == status_too_many_steps, 'short steps that are asked for are taken')
   end subroutine no_progress

   subroutine bound_by_stability(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=6), parameter :: names(2) = ['dopri5', 'dop853']
      type(stiff_t) :: ode
      type(integrator_t) :: integrator
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      real(wp) :: t, y(1)
      integer :: i

      do i = 1, 2
         call integrator%init(1, integration_options_t(integrator=names(i)), error)
         call no_error(failure, error)
         t = 0.5_wp
         y = cos(t)
         ode%k = 1.0e4_wp
         call integrator%run(ode, t, y, 4.0_wp, result)
         call check(failure, result%status == status_reached_end .and. size(result%notes) == 1, names(i)//': one note')
         if (allocated(failure)) return
         call check(failure, result%notes(1)%code == note_bound_by_stability .and. result%notes(1)%t < 1.0_wp, names(i)//': which')
         ! As many steps, for accuracy.
         ode%k = 1.0_wp
         call integrator%init(1, integration_options_t(integrator=names(i), rtol=1.0e-13_wp, atol=1.0e-13_wp), error)
         t = 0.5_wp
         y = 2.0_wp
         call integrator%run(ode, t, y, 100.0_wp, result)
         call check(failure, size(result%notes) == 0 .and. result%steps > 250, names(i)//': no note')
      end do
   end subroutine bound_by_stability

   !> Where F(P(y)) differs from F(y), the new state is projected first: six evaluations a step, and nothing else changes.
   subroutine projected_first(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(method_t) :: methods(3)
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp) :: phi(1)
      integer :: i

      methods(1)%stage_projection = 'none'
      methods(2)%name = 'coordinate-projection'
      methods(3)%name = 'yu-chen'
      methods(3)%correction_tolerance = 1.0e-9_wp
      options%rtol = 1.0e-8_wp
      do i = 1, 3
         call horizontal(model, at)
         call simulate(model, at, 2.0_wp, result, error, method=methods(i), options=options)
         call no_error(failure, error)
         call check(failure, result%rhs_evaluations == 6*(result%steps + result%rejected) + 2, &
                    trim(methods(i)%name)//': evaluations')
         call model%constraint(at, phi)
         call check_below(failure, phi(1), merge(1.0e-9_wp, 1.0e-12_wp, i == 3), trim(methods(i)%name)//': position')
         call check_below(failure, dot_product(at%x, at%v), merge(1.0e-9_wp, 1.0e-12_wp, i == 3), &
                          trim(methods(i)%name)//': velocity')
         call check_close(failure, 0.5_wp*dot_product(at%v, at%v) + g*at%x(2), 0.0_wp, 1.0e-6_wp, &
                          trim(methods(i)%name)//': energy')
      end do
   end subroutine projected_first

   subroutine no_number(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp) :: t_end(2)
      integer :: i

      t_end = [ieee_value(1.0_wp, ieee_quiet_nan), ieee_value(1.0_wp, ieee_positive_inf)]
      do i = 1, 2
         call horizontal(model, at)
         call simulate(model, at, t_end(i), result, error)
         call check(failure, allocated(error), 'it went on')
         if (allocated(error)) deallocate (error)
      end do
   end subroutine no_number

   subroutine no_number_at_start(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error

      call horizontal(model, at)
      at%v(2) = ieee_value(1.0_wp, ieee_quiet_nan)
      call simulate(model, at, 1.0_wp, result, error)
      call check(failure, allocated(error), 'it went on')
      if (allocated(error)) call check(failure, index(error%line(), 'vz is not a number') > 0, error%line())
   end subroutine no_number_at_start

   subroutine restart_from_event(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(integration_result_t) :: result
      type(state_t) :: at
      type(lowest_t) :: events
      type(error_t), allocatable :: error
      real(wp) :: before
      integer :: i

      call horizontal(model, at)
      events%direction = [0]
      events%terminal = [.true.]
      do i = 1, 40
         before = at%t
         call simulate(model, at, 1000.0_wp, result, error, events=events)
         call no_error(failure, error)
         call check(failure, result%status == status_event, 'it stops')
         ! A quarter period to the first, half a period between the others.
         call check(failure, at%t - before > 0.5_wp, 'the same event again')
      end do
   end subroutine restart_from_event

   subroutine tiny_event(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(integration_result_t) :: result
      type(state_t) :: at
      type(lowest_t) :: events
      type(error_t), allocatable :: error

      call horizontal(model, at)
      events%direction = [0]
      events%terminal = [.true.]
      events%unit = 1.0e-200_wp
      call simulate(model, at, 10.0_wp, result, error, events=events)
      call no_error(failure, error)
      call check_below(failure, at%x(1), 1.0e-12_wp, 'x at the event')
   end subroutine tiny_event

   subroutine events_not_set(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(integration_result_t) :: result
      type(state_t) :: at
      type(lowest_t) :: events
      type(error_t), allocatable :: error

      call horizontal(model, at)
      call simulate(model, at, 1.0_wp, result, error, events=events)
      call check(failure, allocated(error), 'without direction and terminal')
      if (allocated(error)) deallocate (error)
      events%direction = [0, 0]
      events%terminal = [.true.]
      call horizontal(model, at)
      call simulate(model, at, 1.0_wp, result, error, events=events)
      call check(failure, allocated(error), 'of different sizes')
   end subroutine events_not_set

   subroutine far_end(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(integration_result_t) :: result
      type(state_t) :: at
      type(lowest_t) :: events
      type(error_t), allocatable :: error

      call horizontal(model, at)
      events%direction = [-1]
      events%terminal = [.true.]
      call simulate(model, at, 1.0e30_wp, result, error, events=events)
      call no_error(failure, error)
      call check(failure, result%status == status_event, 'it stops at the event')
      call check_close(failure, at%t, 2.3678_wp/4.0_wp, 1.0e-4_wp, 'after a quarter period')
   end subroutine far_end

   !> Violations gather over many steps: the correction moves the state by more than a step's tolerance.
   subroutine rare_corrections(failure)
      character(:), allocatable, intent(inout) :: failure
      type(method_t) :: method
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error

      method%name = 'yu-chen'
      method%correction_tolerance = 1.0e-7_wp
      options%rtol = 1.0e-8_wp
      options%atol = 1.0e-10_wp
      at%x = [0.6_wp, -0.8_wp]
      at%v = [0.0_wp, 0.2_wp]
      call simulate(new_particle(driven_pivot, rate=1.0_wp, amplitude=0.2_wp), at, 30.0_wp, result, error, method, options)
      call no_error(failure, error)
      call check(failure, result%status == status_reached_end, 'the end is reached')
   end subroutine rare_corrections

   subroutine contradictions(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_options_t) :: options(5)
      type(error_t), allocatable :: error
      integer :: i

      options(1)%first_step = 1.0e-5_wp
      options(1)%min_step = 1.0e-4_wp
      options(2)%step_control = 'fixed'
      options(2)%first_step = 1.0_wp
      options(2)%max_step = 0.1_wp
      options(3)%projection_limit = -1.0_wp
      options(4)%min_step = 2.0_wp
      options(4)%max_step = 1.0_wp
      options(5)%first_step = -1.0_wp
      do i = 1, size(options)
         call options(i)%check(error)
         call check(failure, allocated(error), 'taken')
         if (allocated(error)) deallocate (error)
      end do
   end subroutine contradictions

   subroutine mass_does_not_fit(failure)
      character(:), allocatable, intent(inout) :: failure
      type(block_diagonal_t) :: m
      integer :: info

      call m%init([1, 1])
      call m%set_dense(reshape([2.0_wp, 0.0_wp, 0.0_wp, 3.0_wp], [2, 2]))
      call m%factorize(info)
      call check(failure, info == 0 .and. abs(m%values(2) - 3.0_wp) <= 0.0_wp, 'a matrix that does fit')
      call m%set_dense(reshape([2.0_wp, 1.0_wp, 1.0_wp, 3.0_wp], [2, 2]))
      call m%factorize(info)
      call check(failure, info /= 0, 'entries outside the blocks')
      call m%set_diagonal([1.0_wp])
      call m%factorize(info)
      call check(failure, info /= 0, 'a diagonal that is too short')
   end subroutine mass_does_not_fit

end module test_ode_edges
