!> Implicit steppers: what all have in common that solve equations for a step by Newton's method, whatever these are.
!!
!! An extension predicts, iterates and judges; where the iteration fails, `improve` and `give_up` say how to go on, and `limit`
!! how long the next step may be.
module taut_ode_stepper_implicit
   use taut_kinds, only: wp
   use taut_ode_newton, only: good_contraction, newton_t
   use taut_ode_step_control, only: step_control_t
   use taut_ode_stepper, only: stepper_t
   use taut_ode_system, only: ode_system_t, rhs_not_solved, rhs_ok
   implicit none (type, external)
   private
   public :: implicit_stepper_t

   !> The step and the factors are kept while the step could grow by no more than this.
   real(wp), parameter :: worth_growing = 1.2_wp
   !> After an iteration that failed: the share of the step that is allowed next, and its growth per step.
   real(wp), parameter :: cap_after_failure = 0.8_wp, growth_of_cap = 1.05_wp

   !> A stepper with equations to solve.
   type, abstract, extends(stepper_t) :: implicit_stepper_t
      !> The equations, and the iteration for them.
      type(newton_t) :: newton
      !> Number of algebraic unknowns.
      integer :: n_z = 0
      !> Length of the last accepted step, and of the last try that holds [s].
      real(wp) :: h_old = 0.0_wp, h_try = 0.0_wp
      !> The longest step allowed after a failure [s].
      real(wp) :: cap = huge(1.0_wp)
      !> Whether there is a step before; whether z is known; whether a try was rejected since the last step that holds.
      logical :: has_history = .false., knows_z = .false., rejected = .false.
      !> Derivative and algebraic unknowns at the step's start: (n), (n_z).
      real(wp), allocatable :: ydot(:), z(:)
   contains
      procedure :: first_step
      procedure :: failure
      procedure, non_overridable :: begin
      procedure, non_overridable :: improve
      procedure, non_overridable :: give_up
      procedure, non_overridable :: shorten
      procedure, non_overridable :: limit
      procedure, non_overridable :: advance
   end type implicit_stepper_t

contains

   !> Where a history begins: derivative and algebraic unknowns there.
   subroutine begin(self, ode, t, y, info)
      !> The stepper, its equations met.
      class(implicit_stepper_t), intent(inout) :: self
      !> What is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> Time [s].
      real(wp), intent(in) :: t
      !> State: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      call self%newton%start(ode, t, y, .not. self%knows_z, self%ydot, self%z, self%work, info)
      self%integrand_behind = ode%integrand
      self%knows_z = info == rhs_ok
      self%has_history = .false.
      self%rejected = .false.
      self%cap = huge(1.0_wp)
   end subroutine begin

   !> Length of the first step: by which the state moves by a thousandth of itself.
   subroutine first_step(self, ode, control, t, y, longest, h)
      !> The stepper, behind `start`.
      class(implicit_stepper_t), intent(inout) :: self
      !> What is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> Norm of errors.
      type(step_control_t), intent(in) :: control
      !> Time [s].
      real(wp), intent(in) :: t
      !> State: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Length of the longest first step, with the sign of the direction [s].
      real(wp), intent(in) :: longest
      !> Proposed length, with the sign of the direction [s].
      real(wp), intent(out) :: h

      h = control%cautious_start(self%ydot, y, longest)
      associate (unused_system => ode, unused_time => t)
      end associate
   end subroutine first_step

   !> After an iteration that did not converge: better matrices, or a shorter step if these do not help.
   subroutine improve(self, control, correction, y0, y1, h, h_next, again, info)
      !> The stepper.
      class(implicit_stepper_t), intent(inout) :: self
      !> Norm of errors.
      type(step_control_t), intent(in) :: control
      !> The last correction, weighed: (n).
      real(wp), intent(in), contiguous :: correction(:)
      !> One state that sets the scale: (n).
      real(wp), intent(in), contiguous :: y0(:)
      !> Another one: (n).
      real(wp), intent(in), contiguous :: y1(:)
      !> Length of the try [s].
      real(wp), intent(in) :: h
      !> Length of the next one, replaced where it is given up [s].
      real(wp), intent(inout) :: h_next
      !> Whether to iterate again.
      logical, intent(out) :: again
      !> Why the iteration ended; replaced by `rhs_not_solved` where it was not for the system.
      integer, intent(inout) :: info

      again = info == rhs_ok
      if (again) call self%newton%improve(again)
      if (again) return
      if (info == rhs_ok) then
         info = rhs_not_solved
         call self%newton%blame(control, correction, y0, y1)
      end if
      call self%give_up(h, h_next)
   end subroutine improve

   !> Prepares a shorter try after one without a result.
   pure subroutine give_up(self, h, h_next)
      !> The stepper.
      class(implicit_stepper_t), intent(inout) :: self
      !> Length of the try [s].
      real(wp), intent(in) :: h
      !> Length of the next one [s].
      real(wp), intent(out) :: h_next

      self%cap = cap_after_failure*abs(h)
      call self%shorten(h, h_next)
   end subroutine give_up

   !> Prepares a shorter try after one whose end the system refuses: that says nothing of how long steps may be behind it.
   pure subroutine shorten(self, h, h_next)
      !> The stepper.
      class(implicit_stepper_t), intent(inout) :: self
      !> Length of the try [s].
      real(wp), intent(in) :: h
      !> Length of the next one [s].
      real(wp), intent(out) :: h_next

      h_next = 0.5_wp*h
      call self%newton%drop()
      self%rejected = .true.
   end subroutine shorten

   !> The length of the next step: the same where more is not worth other factors, and no longer than a failure allows.
   pure subroutine limit(self, h, h_next)
      !> The stepper, behind a try that holds.
      class(implicit_stepper_t), intent(inout) :: self
      !> Length of the try [s].
      real(wp), intent(in) :: h
      !> Length of the next one: as its error allows, replaced [s].
      real(wp), intent(inout) :: h_next

      if (self%newton%contraction <= good_contraction .and. h_next/h >= 1.0_wp .and. h_next/h <= worth_growing) h_next = h
      if (abs(h_next) > self%cap) h_next = sign(self%cap, h)
      if (self%cap < huge(1.0_wp)) self%cap = growth_of_cap*self%cap
   end subroutine limit

   !> The end of the last try is where the next one starts.
   pure subroutine advance(self)
      !> The stepper, behind a try that holds.
      class(implicit_stepper_t), intent(inout) :: self

      self%h_old = self%h_try
      self%has_history = .true.
      self%rejected = .false.
      call self%newton%accept()
   end subroutine advance

   !> Why the last try has failed, in words.
   subroutine failure(self, ode, text)
      !> The stepper.
      class(implicit_stepper_t), intent(in) :: self
      !> What is integrated.
      class(ode_system_t), intent(in) :: ode
      !> One line, may be empty.
      character(:), allocatable, intent(out) :: text

      call self%newton%explain(ode, text)
   end subroutine failure

end module taut_ode_stepper_implicit
