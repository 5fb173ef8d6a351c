!> Explicit Runge-Kutta pairs whose last stage is evaluated at the new state ('first same as last').
!!
!! A pair states its tableau (`stage_state`, `estimate`, `node`) and its continuous extension; the step itself is the same.
module taut_ode_stepper_explicit_pair
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   use taut_ode_step_control, only: step_control_t
   use taut_ode_stepper, only: finite, stepper_t
   use taut_ode_system, only: ode_system_t, rhs_ok, rhs_retry
   implicit none (type, external)
   private
   public :: explicit_pair_t

   !> A pair.
   type, abstract, extends(stepper_t) :: explicit_pair_t
      !> Number of stages; the derivative of the last one is that of the new state.
      integer :: stages = 0
      !> Nodes c_i: (stages).
      real(wp), allocatable :: node(:)
      !> Derivatives of the stages: (n, at least stages).
      real(wp), allocatable :: k(:, :)
      !> Estimates of the local error, see `step_control_t%decide`: (n, estimates).
      real(wp), allocatable :: error(:, :)
      real(wp), allocatable, private :: y_work(:)
   contains
      procedure :: allocate_stages
      procedure :: start
      procedure :: first_step
      procedure :: try
      procedure :: accept
      procedure :: serialize
      procedure(state_of_stage), deferred, nopass :: stage_state
      procedure(error_estimates), deferred, nopass :: estimate
   end type explicit_pair_t

   abstract interface
      !> The state of a stage; for the last stage, the new state.
      pure subroutine state_of_stage(n, stage, h, y, k, y_stage)
         import :: wp
         implicit none (type, external)
         !> Size of the state.
         integer, intent(in) :: n
         !> 2 to `stages`.
         integer, intent(in) :: stage
         !> Step [s].
         real(wp), intent(in) :: h
         !> State at the step's start: (n).
         real(wp), intent(in) :: y(n)
         !> Derivatives of the stages before: (n, stages).
         real(wp), intent(in) :: k(n, *)
         !> State of the stage: (n).
         real(wp), intent(out) :: y_stage(n)
      end subroutine state_of_stage

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

   !> Allocates what all pairs have.
   subroutine allocate_stages(self, n, node, columns, estimates)
      !> The pair.
      class(explicit_pair_t), intent(inout) :: self
      !> Size of the state.
      integer, intent(in) :: n
      !> Nodes c_i: (stages).
      real(wp), intent(in) :: node(:)
      !> Number of derivatives kept, those of the continuous extension included.
      integer, intent(in) :: columns
      !> Number of error estimates.
      integer, intent(in) :: estimates

      self%n = n
      self%stages = size(node)
      self%node = node
      allocate (self%k(n, columns), self%error(n, estimates), self%y_work(n), source=0.0_wp)
   end subroutine allocate_stages

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

      call self%evaluate(ode, t, y, self%k(:, 1), info)
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
      logical :: limited, stale
      integer :: i
      real(wp) :: t_stage

      h_next = h
      info = rhs_ok
      do i = 2, self%stages
         call self%stage_state(self%n, i, h, y, self%k, y_new)
         if (i == self%stages) then
            if (.not. finite(self%n, y_new)) info = rhs_retry
         end if
         if (info /= rhs_ok) return
         t_stage = t + self%node(i)*h
         if (self%node(i) >= 1.0_wp) t_stage = t_new
         call self%evaluate(ode, t_stage, y_new, self%k(:, i), info)
         if (info /= rhs_ok) return
      end do
      call self%estimate(h, self%k, self%error)
      if (control%aware_of_projection) then
         do i = 1, size(self%error, 2)
            call ode%filter_error(self%error(:, i))
         end do
      end if
      call control%decide(h, self%error, y, y_new, h_next, accepted)
      if (.not. accepted) return

      limited = control%aware_of_projection .and. ode%limits_projection
      if (limited) self%y_work(:) = y_new
      call ode%project(t_new, y_new, .true., stale, info)
      if (info /= rhs_ok) return
      if (limited) then
         self%y_work(:) = self%y_work - y_new
         if (control%norm(self%y_work, y, y_new) > control%projection_limit) then
            accepted = .false.
            h_next = h
            call control%reduce(h_next)
            return
         end if
      end if
      if (stale) call self%evaluate(ode, t_new, y_new, self%k(:, self%stages), info)
   end subroutine take

   !> The last derivative is the first one of the next step.
   subroutine accept(self)
      !> The pair, behind a try that holds.
      class(explicit_pair_t), intent(inout) :: self
      integer :: i

      do i = 1, size(self%k, 1)
         self%k(i, 1) = self%k(i, self%stages)
      end do
   end subroutine accept

   !> Passes the derivative at the step's start through an archive.
   subroutine serialize(self, archive)
      !> The pair, initialized.
      class(explicit_pair_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      call archive%item('ydot', self%k(:, 1))
   end subroutine serialize

end module taut_ode_stepper_explicit_pair
