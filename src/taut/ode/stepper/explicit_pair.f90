!> Explicit Runge-Kutta pairs whose last stage is evaluated at the new state ('first same as last').
!!
!! A pair states its tableau as data, its error estimates and its continuous extension; the step itself is the same.
module taut_ode_stepper_explicit_pair
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   use taut_ode_projection_check, only: projection_holds
   use taut_ode_step_control, only: step_control_t
   use taut_ode_stepper, only: stepper_t
   use taut_ode_system, only: evaluated_step_end, ode_system_t, rhs_ok, rhs_retry, step_end
   implicit none (type, external)
   private
   public :: explicit_pair_t

   !> Room for tableaus, in which the hot loops find their coefficients faster than in allocatable arrays; and the terms that
   !! are summed in one loop.
   integer, parameter :: most_stages = 16, most_terms = 14, at_once = 6, most_estimates = 2

   !> A step is looked at so often for its stability, and each one where one was found bound by it; so many of them make a
   !! verdict, unless so many others come between.
   integer, parameter :: look_every = 100, verdict = 15, acquittal = 6

   !> A pair.
   type, abstract, extends(stepper_t) :: explicit_pair_t
      !> Number of stages; the derivative of the last one is that of the new state.
      integer :: stages = 0
      !> Nodes c_i: (at least stages).
      real(wp), allocatable :: node(:)
      !> Largest h lambda that is stable, along the negative axis, as far as the two last stages tell.
      real(wp) :: stability_bound = huge(1.0_wp)
      !> Derivatives of the stages, and of those of the continuous extension behind them: (n, at least stages).
      real(wp), allocatable :: k(:, :)
      !> Estimates of the local error, see `step_control_t%decide`: (n, estimates).
      real(wp), allocatable :: error(:, :)
      real(wp), allocatable, private :: y_work(:), y_later(:), y_last_stage(:)
      !> The system's integrand at the stages, and at those of the continuous extension behind them.
      real(wp) :: integrand(1, most_stages) = 0.0_wp
      !> Steps since the last look; steps found bound by stability, and others since.
      integer, private :: unseen = 0, bound = 0, free = 0
      !> Coefficients a_ij that are not zero, how many there are for stage i, and their j.
      real(wp), private :: a(most_terms, most_stages) = 0.0_wp
      integer, private :: terms(most_stages) = 0, column(most_terms, most_stages) = 1
      !> Where the derivative of that stage begins in `k`.
      integer, private :: begin(most_terms, most_stages) = 0
   contains
      procedure, non_overridable :: set_tableau
      procedure, non_overridable :: stage_state
      procedure :: start
      procedure :: first_step
      procedure :: try
      procedure :: accept
      procedure :: serialize
      procedure(error_estimates), deferred, nopass :: estimate
   end type explicit_pair_t

   abstract interface
      !> Estimates of the local error.
      pure subroutine error_estimates(h, k, error)
         import :: wp
         implicit none (type, external)
         !> Step [s].
         real(wp), intent(in) :: h
         !> Derivatives of all stages: (n, stages).
         real(wp), intent(in), contiguous :: k(:, :)
         !> Estimates, one a column: (n, estimates).
         real(wp), intent(out), contiguous :: error(:, :)
      end subroutine error_estimates
   end interface

contains

   !> Takes a tableau and allocates what all pairs have.
   subroutine set_tableau(self, n, stages, node, a, estimates)
      !> The pair.
      class(explicit_pair_t), intent(inout) :: self
      !> Size of the state.
      integer, intent(in) :: n
      !> Number of stages; further ones are those of the continuous extension.
      integer, intent(in) :: stages
      !> Nodes c_i: (all stages).
      real(wp), intent(in) :: node(:)
      !> Coefficients a_ij, one column for each stage i; column `stages` holds the weights of the solution: (j, all stages).
      real(wp), intent(in) :: a(:, :)
      !> Number of error estimates.
      integer, intent(in) :: estimates
      integer :: i, j

      self%n = n
      self%takes_integral = .true.
      self%estimates_integral = .true.
      self%stages = stages
      self%node = node
      do i = 1, size(node)
         do j = 1, size(a, 1)
            if (abs(a(j, i)) <= 0.0_wp) cycle
            self%terms(i) = self%terms(i) + 1
            self%a(self%terms(i), i) = a(j, i)
            self%column(self%terms(i), i) = j
            self%begin(self%terms(i), i) = (j - 1)*n
         end do
      end do
      allocate (self%k(n, size(node)), self%error(n, estimates), self%y_work(n), self%y_later(n), self%y_last_stage(n), &
                source=0.0_wp)
   end subroutine set_tableau

   !> The state of a stage, y + h sum_j a_ij k_j; for the last stage, the new state.
   pure subroutine stage_state(self, stage, h, y, y_stage)
      !> The pair, with the derivatives of the stages before in `k`.
      class(explicit_pair_t), intent(in) :: self
      !> From 2 on.
      integer, intent(in) :: stage
      !> Step [s].
      real(wp), intent(in) :: h
      !> State at the step's start: (n).
      real(wp), intent(in) :: y(self%n)
      !> State of the stage: (n).
      real(wp), intent(out) :: y_stage(self%n)
      integer :: i, m

      call add_terms(self%n, self%terms(stage), h*self%a(:at_once, stage), self%begin(:at_once, stage), self%k, y, y_stage)
      do m = at_once + 1, self%terms(stage)
         do i = 1, self%n
            y_stage(i) = y_stage(i) + (h*self%a(m, stage))*self%k(i, self%column(m, stage))
         end do
      end do
   end subroutine stage_state

   !> y_stage = y + sum_m c_m k_j, where k_j begins at b_m, of the first terms; coefficients beyond the last one are zero.
   pure subroutine add_terms(n, terms, c, b, k, y, y_stage)
      integer, intent(in) :: n, terms, b(at_once)
      real(wp), intent(in) :: c(at_once), k(*), y(n)
      real(wp), intent(out) :: y_stage(n)
      integer :: i

      select case (terms)
      case (1)
         do i = 1, n
            y_stage(i) = y(i) + c(1)*k(b(1) + i)
         end do
      case (2)
         do i = 1, n
            y_stage(i) = y(i) + (c(1)*k(b(1) + i) + c(2)*k(b(2) + i))
         end do
      case (3)
         do i = 1, n
            y_stage(i) = y(i) + (c(1)*k(b(1) + i) + c(2)*k(b(2) + i) + c(3)*k(b(3) + i))
         end do
      case (4)
         do i = 1, n
            y_stage(i) = y(i) + (c(1)*k(b(1) + i) + c(2)*k(b(2) + i) + c(3)*k(b(3) + i) + c(4)*k(b(4) + i))
         end do
      case (5)
         do i = 1, n
            y_stage(i) = y(i) + (c(1)*k(b(1) + i) + c(2)*k(b(2) + i) + c(3)*k(b(3) + i) + c(4)*k(b(4) + i) + c(5)*k(b(5) + i))
         end do
      case default
         do i = 1, n
            y_stage(i) = y(i) + (c(1)*k(b(1) + i) + c(2)*k(b(2) + i) + c(3)*k(b(3) + i) + c(4)*k(b(4) + i) + &
                                 c(5)*k(b(5) + i) + c(6)*k(b(6) + i))
         end do
      end select
   end subroutine add_terms

   !> The derivative at a start.
   subroutine start(self, ode, t, y, info)
      !> The pair.
      class(explicit_pair_t), intent(inout) :: self
      !> What is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> Time [s].
      real(wp), intent(in) :: t
      !> State: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      self%unseen = 0
      self%bound = 0
      self%free = 0
      self%bound_by_stability = .false.
      call self%evaluate(ode, t, y, self%k(:, 1), info)
      self%integrand(1, 1) = ode%integrand
   end subroutine start

   !> Length of the first step by an Euler step, which tells the second derivative.
   !!
   !! Source: E. Hairer, S.P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed., Springer 1993, Sect. II.4.
   subroutine first_step(self, ode, control, t, y, longest, h)
      !> The pair, behind `start`.
      class(explicit_pair_t), intent(inout) :: self
      !> What is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> Norm of errors.
      type(step_control_t), intent(in) :: control
      !> Time [s].
      real(wp), intent(in) :: t
      !> State: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Length of the longest Euler step, with the sign of the direction [s].
      real(wp), intent(in) :: longest
      !> Proposed length, with the sign of the direction [s].
      real(wp), intent(out) :: h
      real(wp) :: curvature, h1, scale, slope
      integer :: info

      slope = control%norm(self%k(:, 1), y, y)
      scale = control%norm(y, y, y)
      h = 1.0e-6_wp
      if (slope > 1.0e-5_wp .and. scale > 1.0e-5_wp) h = 0.01_wp*scale/slope
      h = sign(min(h, abs(longest)), longest)
      self%y_work(:) = y + h*self%k(:, 1)
      call self%evaluate(ode, t + h, self%y_work, self%k(:, 2), info)
      if (info /= rhs_ok) return
      self%error(:, 1) = (self%k(:, 2) - self%k(:, 1))/h
      curvature = control%norm(self%error(:, 1), y, y)
      if (max(slope, curvature) > 1.0e-15_wp) then
         h1 = (0.01_wp/max(slope, curvature))**(1.0_wp/self%order)
      else
         h1 = max(1.0e-6_wp, 1.0e-3_wp*abs(h))
      end if
      h = sign(min(100.0_wp*abs(h), h1), longest)
   end subroutine first_step

   !> One try. If it holds, the last stage's derivative is that of the new state.
   subroutine try(self, ode, control, t, y, t_new, h, y_new, h_next, accepted, info)
      !> The pair.
      class(explicit_pair_t), intent(inout) :: self
      !> What is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> Decides.
      type(step_control_t), intent(inout) :: control
      !> Time at its start [s].
      real(wp), intent(in) :: t
      !> State at its start: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Time at its end [s].
      real(wp), intent(in) :: t_new
      !> Its length [s].
      real(wp), intent(in) :: h
      !> State at its end: (n).
      real(wp), intent(out), contiguous :: y_new(:)
      !> Length of the next try [s].
      real(wp), intent(out) :: h_next
      !> Whether the step holds.
      logical, intent(out) :: accepted
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      accepted = .false.
      call take(self, ode, control, t, y, t_new, h, y_new, h_next, accepted, info)
      if (info == rhs_ok) return
      accepted = .false.
      h_next = h
      call control%reduce(h_next)
   end subroutine try

   !> The try itself; `info` other than `rhs_ok` is a failure for another reason than the error.
   subroutine take(self, ode, control, t, y, t_new, h, y_new, h_next, accepted, info)
      class(explicit_pair_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      type(step_control_t), intent(inout) :: control
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(in) :: t_new, h
      real(wp), intent(out), contiguous :: y_new(:)
      real(wp), intent(out) :: h_next
      logical, intent(inout) :: accepted
      integer, intent(out) :: info
      logical :: holds, looks, stale
      integer :: i
      real(wp) :: t_stage

      h_next = h
      holds = .true.
      info = rhs_ok
      looks = self%unseen >= look_every .or. self%bound > 0
      do i = 2, self%stages
         if (looks .and. i == self%stages) self%y_last_stage(:) = y_new
         call self%stage_state(i, h, y, y_new)
         t_stage = t + self%node(i)*h
         if (self%node(i) >= 1.0_wp) t_stage = t_new
         if (i == self%stages) then
            ! The derivatives are finite, their sum need not be.
            if (.not. all(abs(y_new) <= huge(1.0_wp))) info = rhs_retry
            if (info == rhs_ok .and. .not. ode%rhs_projects) &
               call project(self, ode, control, t_new, y, y_new, step_end, holds, stale, info)
            if (info /= rhs_ok) return
         end if
         if (ode%half_explicit) then
            ! The last coefficient of a stage is that of the stage before.
            call ode%meet(t, y, i == 2, t_stage, h*self%a(self%terms(i), i), y_new, self%k(:, i - 1), info)
            if (info /= rhs_ok) return
         end if
         call self%evaluate(ode, t_stage, y_new, self%k(:, i), info)
         if (info /= rhs_ok) return
         self%integrand(1, i) = ode%integrand
      end do
      call self%estimate(h, self%k, self%error)
      if (control%aware_of_projection) then
         do i = 1, size(self%error, 2)
            call ode%filter_error(self%error(:, i))
         end do
      end if
      call control%decide(h, self%error, y, y_new, h_next, accepted)
      if (.not. accepted) return

      self%unseen = self%unseen + 1
      if (looks) call look_at_stability(self, h, y_new)
      stale = .false.
      if (ode%rhs_projects) then
         call project(self, ode, control, t_new, y, y_new, evaluated_step_end, holds, stale, info)
         if (info /= rhs_ok) return
      end if
      if (.not. holds) then
         accepted = .false.
         h_next = h
         call control%reduce(h_next)
         return
      end if
      if (stale) then
         call self%evaluate(ode, t_new, y_new, self%k(:, self%stages), info)
         self%integrand(1, self%stages) = ode%integrand
      end if
      if (ode%has_integral) call integrate_along(self, h)
   end subroutine take

   !> The integral over the step, with the weights of the solution.
   pure subroutine integrate_along(self, h)
      class(explicit_pair_t), intent(inout) :: self
      real(wp), intent(in) :: h
      real(wp) :: error(1, most_estimates)
      integer :: m

      self%integrand_before = self%integrand(1, 1)
      self%integrand_behind = self%integrand(1, self%stages)
      self%gain = 0.0_wp
      do m = 1, self%terms(self%stages)
         self%gain = self%gain + self%a(m, self%stages)*self%integrand(1, self%column(m, self%stages))
      end do
      self%gain = h*self%gain
      call self%estimate(h, self%integrand, error)
      self%gain_error = abs(error(1, 1))
   end subroutine integrate_along

   !> Whether a step is as long as stability allows: its two last stages, which are evaluated at one time, tell h lambda.
   !!
   !! Source: Hairer's codes DOPRI5 and DOP853; E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., Springer
   !! 1996, Sect. IV.2.
   subroutine look_at_stability(self, h, y_new)
      class(explicit_pair_t), intent(inout) :: self
      real(wp), intent(in) :: h
      real(wp), intent(in), contiguous :: y_new(:)
      real(wp) :: slopes, states

      self%unseen = 0
      slopes = norm2(self%k(:, self%stages) - self%k(:, self%stages - 1))
      states = norm2(y_new - self%y_last_stage)
      if (abs(h)*slopes > self%stability_bound*states .and. states > 0.0_wp) then
         self%free = 0
         self%bound = self%bound + 1
         self%bound_by_stability = self%bound >= verdict
      else
         self%free = self%free + 1
         if (self%free >= acquittal) self%bound = 0
      end if
   end subroutine look_at_stability

   !> The new state on the system's invariants, and whether the way back there says nothing against the step.
   subroutine project(self, ode, control, t_new, y, y_new, place, holds, stale, info)
      class(explicit_pair_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      type(step_control_t), intent(in) :: control
      real(wp), intent(in) :: t_new
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(inout), contiguous :: y_new(:)
      integer, intent(in) :: place
      logical, intent(out) :: holds, stale
      integer, intent(out) :: info
      logical :: judged
      integer :: i

      judged = control%aware_of_projection .and. ode%limits_projection
      holds = .true.
      if (judged) self%y_work(:self%n) = y_new(:self%n)
      call ode%project(t_new, y_new, place, stale, info)
      if (info /= rhs_ok .or. .not. judged) return
      !GCC$ unroll 1
      do i = 1, self%n
         self%y_work(i) = self%y_work(i) - y_new(i)
      end do
      holds = projection_holds(control, ode, self%y_work, y, y_new, self%y_later)
   end subroutine project

   !> The last derivative is the first one of the next step.
   subroutine accept(self)
      !> The pair, behind a try that holds.
      class(explicit_pair_t), intent(inout) :: self
      integer :: i

      !GCC$ unroll 1
      do i = 1, self%n
         self%k(i, 1) = self%k(i, self%stages)
      end do
      self%integrand(1, 1) = self%integrand(1, self%stages)
   end subroutine accept

   !> Passes the derivative at the step's start through an archive.
   subroutine serialize(self, archive)
      !> The pair, initialized.
      class(explicit_pair_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      call archive%item('ydot', self%k(:, 1))
      call archive%item('integrand', self%integrand(1, 1))
      call archive%item('integrand behind', self%integrand_behind)
      call archive%item('steps since a look', self%unseen)
      call archive%item('steps bound by stability', self%bound)
      call archive%item('steps that are not', self%free)
   end subroutine serialize

end module taut_ode_stepper_explicit_pair
