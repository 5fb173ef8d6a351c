!> Steppers: what the integration loop knows of a method of integration.
!!
!! The loop (options, observers, events, breakpoints, pauses, statistics) calls a stepper in this order: `init` once; `start`
!! where a history begins (a start, an event, a breakpoint, a state that was replaced) and `first_step` where no step is
!! known; then `try` until a step holds, `interpolate` inside it after `prepare_dense`, and `accept`. Which step holds is
!! decided with the loop's step control, whatever the stepper.
module taut_ode_stepper
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   use taut_ode_step_control, only: controller_constants_t, step_control_t
   use taut_ode_system, only: ode_system_t, rhs_not_finite, rhs_ok
   implicit none (type, external)
   private
   public :: stepper_t, work_t

   !> What an integration has cost.
   type :: work_t
      !> Evaluations of the right-hand side.
      integer :: rhs = 0
      !> Linearizations, factorizations, and iterations of Newton's method: none in explicit methods.
      integer :: jacobians = 0, factorizations = 0, iterations = 0
   contains
      procedure :: serialize => serialize_work
   end type work_t

   !> A method of integration with its history and workspace; nothing is allocated after `init`.
   type, abstract :: stepper_t
      !> By which it is chosen.
      character(len=24) :: name = ''
      !> Size of the state, from `init` on.
      integer :: n = 0
      !> Order of the solution that is continued.
      integer :: order = 0
      !> Constants of the standard controller that suit its error estimate.
      type(controller_constants_t) :: constants
      !> Whether the last steps were as long as stability allows and not accuracy, as far as the stepper looks for that.
      logical :: bound_by_stability = .false.
      !> Whether an integral that goes along with the system is taken along.
      logical :: takes_integral = .false.
      !> Whether its error is estimated well enough to judge a step by.
      logical :: estimates_integral = .false.
      !> The system's integrand at the start and at the end of the last try that holds, and its integral in between.
      real(wp) :: integrand_before = 0.0_wp, integrand_behind = 0.0_wp, gain = 0.0_wp
      !> How far that may be off, by an estimate of lower order.
      real(wp) :: gain_error = 0.0_wp
      !> Its work so far.
      type(work_t) :: work
   contains
      procedure(get_ready), deferred :: init
      procedure(new_history), deferred :: start
      procedure(first_length), deferred :: first_step
      procedure(one_try), deferred :: try
      procedure(shift_history), deferred :: accept
      procedure(get_dense), deferred :: prepare_dense
      procedure(dense_output), deferred :: interpolate
      procedure(pass), deferred :: serialize
      procedure :: integral_inside => cubic_integral
      procedure :: failure => failure_of_system
      procedure, non_overridable :: evaluate
   end type stepper_t

   abstract interface
      !> Allocates the workspace.
      subroutine get_ready(self, n)
         import :: stepper_t
         implicit none (type, external)
         !> The stepper.
         class(stepper_t), intent(inout) :: self
         !> Size of the state.
         integer, intent(in) :: n
      end subroutine get_ready

      !> Forgets the steps before and evaluates what the next one starts from.
      subroutine new_history(self, ode, t, y, info)
         import :: ode_system_t, stepper_t, wp
         implicit none (type, external)
         !> The stepper.
         class(stepper_t), intent(inout) :: self
         !> What is integrated.
         class(ode_system_t), intent(inout) :: ode
         !> Time [s].
         real(wp), intent(in) :: t
         !> State: (n).
         real(wp), intent(in), contiguous :: y(:)
         !> One of the `rhs_` constants.
         integer, intent(out) :: info
      end subroutine new_history

      !> Length of the first step behind `start`.
      subroutine first_length(self, ode, control, t, y, longest, h)
         import :: ode_system_t, step_control_t, stepper_t, wp
         implicit none (type, external)
         !> The stepper, behind `start`.
         class(stepper_t), intent(inout) :: self
         !> What is integrated.
         class(ode_system_t), intent(inout) :: ode
         !> Norm of errors.
         type(step_control_t), intent(in) :: control
         !> Time [s].
         real(wp), intent(in) :: t
         !> State: (n).
         real(wp), intent(in), contiguous :: y(:)
         !> Length of a step that may be tried in order to find out, with the sign of the direction [s].
         real(wp), intent(in) :: longest
         !> Proposed length, with the sign of the direction [s].
         real(wp), intent(out) :: h
      end subroutine first_length

      !> One try: stages, error, projection and acceptance are one decision.
      subroutine one_try(self, ode, control, t, y, t_new, h, y_new, h_next, accepted, info)
         import :: ode_system_t, step_control_t, stepper_t, wp
         implicit none (type, external)
         !> The stepper.
         class(stepper_t), intent(inout) :: self
         !> What is integrated.
         class(ode_system_t), intent(inout) :: ode
         !> Decides, by the norm of errors and its memory.
         type(step_control_t), intent(inout) :: control
         !> Time at its start [s].
         real(wp), intent(in) :: t
         !> State at its start: (n).
         real(wp), intent(in), contiguous :: y(:)
         !> Time at its end [s].
         real(wp), intent(in) :: t_new
         !> Its length [s].
         real(wp), intent(in) :: h
         !> State at its end, on the system's invariants if it holds: (n).
         real(wp), intent(out), contiguous :: y_new(:)
         !> Length of the next try [s].
         real(wp), intent(out) :: h_next
         !> Whether the step holds.
         logical, intent(out) :: accepted
         !> `rhs_ok`, or why there is no new state; a step that is rejected with `rhs_ok` was not accurate enough.
         integer, intent(out) :: info
      end subroutine one_try

      !> Makes the end of the last try the start of the next.
      subroutine shift_history(self)
         import :: stepper_t
         implicit none (type, external)
         !> The stepper, behind a try that holds.
         class(stepper_t), intent(inout) :: self
      end subroutine shift_history

      !> The continuous extension of a try that holds, before `accept`.
      subroutine get_dense(self, ode, t, y, t_new, h, y_new, info)
         import :: ode_system_t, stepper_t, wp
         implicit none (type, external)
         !> The stepper.
         class(stepper_t), intent(inout) :: self
         !> What is integrated.
         class(ode_system_t), intent(inout) :: ode
         !> Time at the step's start [s].
         real(wp), intent(in) :: t
         !> State at the step's start: (n).
         real(wp), intent(in), contiguous :: y(:)
         !> Time at the step's end [s].
         real(wp), intent(in) :: t_new
         !> The step's length [s].
         real(wp), intent(in) :: h
         !> State at the step's end: (n).
         real(wp), intent(in), contiguous :: y_new(:)
         !> One of the `rhs_` constants.
         integer, intent(out) :: info
      end subroutine get_dense

      !> The continuous extension at a fraction of the step; the loop projects it.
      subroutine dense_output(self, theta, y)
         import :: stepper_t, wp
         implicit none (type, external)
         !> The stepper, behind `prepare_dense`.
         class(stepper_t), intent(in) :: self
         !> Fraction of the step, 0 at its start and 1 at its end.
         real(wp), intent(in) :: theta
         !> State: (n).
         real(wp), intent(out), contiguous :: y(:)
      end subroutine dense_output

      !> Passes through an archive what is remembered between two steps, the work apart.
      subroutine pass(self, archive)
         import :: archive_t, stepper_t
         implicit none (type, external)
         !> The stepper, initialized.
         class(stepper_t), intent(inout) :: self
         !> The archive.
         type(archive_t), intent(inout) :: archive
      end subroutine pass
   end interface

contains

   !> The integral that goes along, from the step's start to a fraction of it: here the cubic that fits the values and the
   !! integrands at both ends.
   pure function cubic_integral(self, h, theta) result(value)
      !> The stepper, behind `prepare_dense`.
      class(stepper_t), intent(in) :: self
      !> The step's length [s].
      real(wp), intent(in) :: h
      !> Fraction of the step, 0 at its start and 1 at its end.
      real(wp), intent(in) :: theta
      !> The integral, zero at the step's start.
      real(wp) :: value

      value = theta**2*(3.0_wp - 2.0_wp*theta)*self%gain + &
              h*theta*(1.0_wp - theta)*((1.0_wp - theta)*self%integrand_before - theta*self%integrand_behind)
   end function cubic_integral

   !> One evaluation of the right-hand side, inside two breakpoints, with entries that are not finite answered by `rhs_not_finite`.
   subroutine evaluate(self, ode, t, y, dydt, info)
      !> The stepper, whose work is counted.
      class(stepper_t), intent(inout) :: self
      !> What is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> Time [s].
      real(wp), intent(in) :: t
      !> State: (n).
      real(wp), intent(in) :: y(self%n)
      !> Its derivative: (n).
      real(wp), intent(out) :: dydt(self%n)
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      call ode%rhs(min(max(t, ode%t_low), ode%t_high), y, dydt, info)
      self%work%rhs = self%work%rhs + 1
      ! Checked at each evaluation, so that no right-hand side is given a state that is not a number.
      if (info == rhs_ok .and. .not. finite(self%n, dydt)) then
         info = rhs_not_finite
         ode%not_finite = findloc(ieee_is_finite(dydt), .false., 1)
      end if
   end subroutine evaluate

   !> Why the last try has failed, in words: what the system says.
   subroutine failure_of_system(self, ode, text)
      !> The stepper.
      class(stepper_t), intent(in) :: self
      !> What is integrated.
      class(ode_system_t), intent(in) :: ode
      !> One line, may be empty.
      character(:), allocatable, intent(out) :: text

      call ode%failure(text)
      associate (unused_stepper => self)
      end associate
   end subroutine failure_of_system

   !> Whether all entries are finite: whether the sum of their absolute values is, in which nothing that is not gets lost.
   pure logical function finite(n, values)
      integer, intent(in) :: n
      real(wp), intent(in) :: values(n)
      real(wp) :: total
      integer :: i

      ! Small systems are slowed down by the preparations of an unrolled loop, and large ones do not need it.
      if (n < 24) then
         total = 0.0_wp
         !GCC$ unroll 1
         do i = 1, n
            total = total + abs(values(i))
         end do
      else
         total = sum_of_many(n, values)
      end if
      finite = ieee_is_finite(total)
   end function finite

   !> Sum of absolute values, eight at a time, which do not wait for each other.
   pure real(wp) function sum_of_many(n, values)
      integer, intent(in) :: n
      real(wp), intent(in) :: values(n)
      real(wp) :: t(8)
      integer :: i, j

      t(:) = 0.0_wp
      !GCC$ unroll 1
      do i = 1, n/8
         do j = 1, 8
            t(j) = t(j) + abs(values(8*(i - 1) + j))
         end do
      end do
      !GCC$ unroll 1
      do i = 8*(n/8) + 1, n
         t(1) = t(1) + abs(values(i))
      end do
      sum_of_many = sum(t)
   end function sum_of_many

   !> Passes the counts through an archive.
   subroutine serialize_work(self, archive)
      !> The counts.
      class(work_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      call archive%item('evaluations', self%rhs)
      call archive%item('linearizations', self%jacobians)
      call archive%item('factorizations', self%factorizations)
      call archive%item('iterations', self%iterations)
   end subroutine serialize_work

end module taut_ode_stepper
