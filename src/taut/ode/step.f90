!> One step: stages, error, projection and acceptance, and the state between its ends.
module taut_ode_step
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   use taut_error, only: error_t
   use taut_ode_dormand_prince, only: stages, node, stage_state, error_estimate, dense_coefficients, dense_value
   use taut_ode_options, only: integration_options_t
   use taut_ode_step_control, only: step_control_t
   use taut_ode_system, only: ode_system_t, rhs_ok, rhs_retry
   implicit none (type, external)
   private
   public :: step_t

   !> Where an integration stands, and the workspace of its steps; nothing is allocated inside a step.
   type :: step_t
      !> Time [s], and the length of the next try [s].
      real(wp) :: t = 0.0_wp, h = 0.0_wp
      !> 1 forwards, -1 backwards.
      real(wp) :: direction = 1.0_wp
      !> Evaluations of the right-hand side.
      integer :: evaluations = 0
      !> State at `t`; state at the end of the last try; for other uses: (n).
      real(wp), allocatable :: y(:), y_new(:), y_work(:)
      !> The step-size controller.
      type(step_control_t) :: control
      !> Times between which the right-hand side is evaluated: inside two breakpoints.
      real(wp), private :: t_low = -huge(1.0_wp), t_high = huge(1.0_wp)
      real(wp), private :: projection_limit = 0.0_wp, first_step = 0.0_wp, min_step = 0.0_wp, max_step = 0.0_wp
      real(wp), allocatable, private :: error(:), k(:, :), dense(:, :)
   contains
      procedure :: init
      procedure :: set_bounds
      procedure :: apply_bounds
      procedure :: cross
      procedure :: begin
      procedure :: try
      procedure :: accept
      procedure :: prepare_interpolation
      procedure :: interpolate
      procedure :: serialize
   end type step_t

contains

   !> Allocates the workspace.
   subroutine init(self, n, options, error)
      !> The step.
      class(step_t), intent(out) :: self
      !> Size of the state.
      integer, intent(in) :: n
      !> How to integrate.
      type(integration_options_t), intent(in) :: options
      !> A tolerance or a name that is not valid.
      type(error_t), allocatable, intent(inout) :: error

      call self%control%init(n, trim(options%step_control), trim(options%norm), options%rtol, options%atol, &
                             options%atol_of, error)
      self%projection_limit = options%projection_limit
      self%first_step = options%first_step
      self%min_step = options%min_step
      self%max_step = options%max_step
      allocate (self%y(n), self%y_new(n), self%y_work(n), self%error(n), self%k(n, stages), self%dense(n, 5), source=0.0_wp)
   end subroutine init

   !> Times for the right-hand side between here and the next stop: a load may jump at either end, and the first stage has
   !! to see it after the jump behind, the last one before the jump ahead.
   pure subroutine set_bounds(self, stop_time)
      !> The step.
      class(step_t), intent(inout) :: self
      !> The next stop [s].
      real(wp), intent(in) :: stop_time

      self%t_low = min(nearest(self%t, self%direction), nearest(stop_time, -self%direction))
      self%t_high = max(nearest(self%t, self%direction), nearest(stop_time, -self%direction))
   end subroutine set_bounds

   !> Tells a system the times between which it is looked at.
   subroutine apply_bounds(self, ode)
      !> The step.
      class(step_t), intent(in) :: self
      !> The system.
      class(ode_system_t), intent(inout) :: ode

      ode%t_low = self%t_low
      ode%t_high = self%t_high
   end subroutine apply_bounds

   !> Behind a breakpoint: a drive that has begun to move there asks for other velocities, as a blow would.
   subroutine cross(self, ode, stop_time, info)
      !> The step, at the breakpoint; its state is replaced by the one on the system's invariants behind it.
      class(step_t), intent(inout) :: self
      !> What is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> The next stop [s].
      real(wp), intent(in) :: stop_time
      !> One of the `rhs_` constants.
      integer, intent(out) :: info
      logical :: stale

      call self%set_bounds(stop_time)
      call self%apply_bounds(ode)
      call ode%project(self%t, self%y, .false., stale, info)
   end subroutine cross

   !> One evaluation of the right-hand side, with entries that are not finite answered by `rhs_retry`.
   subroutine evaluate(self, ode, t, y, dydt, info)
      type(step_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(out), contiguous :: dydt(:)
      integer, intent(out) :: info

      call ode%rhs(min(max(t, ode%t_low), ode%t_high), y, dydt, info)
      self%evaluations = self%evaluations + 1
      ! Checked at each stage, so that no right-hand side is given a state that is not a number.
      if (info == rhs_ok .and. .not. finite(dydt)) info = rhs_retry
   end subroutine evaluate

   !> Whether all entries are finite.
   pure logical function finite(values)
      real(wp), intent(in), contiguous :: values(:)
      real(wp) :: t(8)
      integer :: i, j, n

      ! Small systems are slowed down by the preparations of an unrolled loop, and large ones do not need it.
      if (size(values) < 24) then
         finite = .true.
         !GCC$ unroll 1
         do i = 1, size(values)
            if (.not. ieee_is_finite(values(i))) finite = .false.
         end do
         return
      end if
      ! Sums of absolute values: nothing that is not finite gets lost in them. Eight at a time do not wait for each other.
      n = size(values)/8
      t(:) = 0.0_wp
      !GCC$ unroll 1
      do i = 1, n
         do j = 1, 8
            t(j) = t(j) + abs(values(8*(i - 1) + j))
         end do
      end do
      !GCC$ unroll 1
      do i = 8*n + 1, size(values)
         t(1) = t(1) + abs(values(i))
      end do
      finite = ieee_is_finite(sum(t))
   end function finite

   !> First stage and length of the first step of a stretch without breakpoints.
   subroutine begin(self, ode, stop_time, info)
      !> The step, its time and state set.
      class(step_t), intent(inout) :: self
      !> What is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> End of the stretch [s].
      real(wp), intent(in) :: stop_time
      !> One of the `rhs_` constants.
      integer, intent(out) :: info
      real(wp) :: h, h1, slope, curvature, scale
      integer :: retried

      call self%set_bounds(stop_time)
      call self%apply_bounds(ode)
      call self%control%renew()
      call evaluate(self, ode, self%t, self%y, self%k(:, 1), info)
      if (info /= rhs_ok) return
      if (self%first_step > 0.0_wp) then
         self%h = self%direction*self%first_step
         return
      end if
      ! Hairer, Norsett, Wanner, Sect. II.4: an Euler step tells the second derivative.
      slope = self%control%norm(self%k(:, 1), self%y, self%y)
      scale = self%control%norm(self%y, self%y, self%y)
      h = 1.0e-6_wp
      if (slope > 1.0e-5_wp .and. scale > 1.0e-5_wp) h = 0.01_wp*scale/slope
      h = self%direction*min(h, self%max_step, abs(stop_time - self%t))
      self%y_new(:) = self%y + h*self%k(:, 1)
      call evaluate(self, ode, self%t + h, self%y_new, self%k(:, 2), retried)
      self%h = h
      if (retried /= rhs_ok) return
      self%error(:) = (self%k(:, 2) - self%k(:, 1))/h
      curvature = self%control%norm(self%error, self%y, self%y)
      if (max(slope, curvature) > 1.0e-15_wp) then
         h1 = (0.01_wp/max(slope, curvature))**0.2_wp
      else
         h1 = max(1.0e-6_wp, 1.0e-3_wp*abs(h))
      end if
      self%h = self%direction*max(min(100.0_wp*abs(h), h1), self%min_step)
   end subroutine begin

   !> One try: stages, error, projection and acceptance are one decision. On acceptance `y_new` and the last stage hold the
   !! state that is continued and its derivative.
   subroutine try(self, ode, t_new, h, h_next, accepted, info)
      !> The step.
      class(step_t), intent(inout) :: self
      !> What is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> Time at its end [s].
      real(wp), intent(in) :: t_new
      !> Its length [s].
      real(wp), intent(in) :: h
      !> Length of the next try [s].
      real(wp), intent(out) :: h_next
      !> Whether the step holds.
      logical, intent(out) :: accepted
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      accepted = .false.
      call take(self, ode, t_new, h, h_next, accepted, info)
      if (info == rhs_ok) return
      accepted = .false.
      h_next = h
      call self%control%reduce(h_next)
   end subroutine try

   !> The try itself; `info` other than `rhs_ok` is a failure for another reason than the error.
   subroutine take(self, ode, t_new, h, h_next, accepted, info)
      type(step_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t_new, h
      real(wp), intent(out) :: h_next
      logical, intent(inout) :: accepted
      integer, intent(out) :: info
      logical :: limited, stale
      integer :: i
      real(wp) :: t_stage

      h_next = h
      info = rhs_ok
      do i = 2, stages
         call stage_state(i, h, self%y, self%k, self%y_new)
         if (i == stages) then
            if (.not. finite(self%y_new)) info = rhs_retry
         end if
         if (info /= rhs_ok) return
         t_stage = self%t + node(i)*h
         if (i >= stages - 1) t_stage = t_new
         call evaluate(self, ode, t_stage, self%y_new, self%k(:, i), info)
         if (info /= rhs_ok) return
      end do
      call error_estimate(h, self%k, self%error)
      if (self%control%aware_of_projection) call ode%filter_error(self%error)
      call self%control%decide(h, self%error, self%y, self%y_new, h_next, accepted)
      if (.not. accepted) return

      limited = self%control%aware_of_projection .and. ode%limits_projection
      if (limited) self%y_work(:) = self%y_new
      call ode%project(t_new, self%y_new, .true., stale, info)
      if (info /= rhs_ok) return
      if (limited) then
         self%y_work(:) = self%y_work - self%y_new
         if (self%control%norm(self%y_work, self%y, self%y_new) > self%projection_limit) then
            accepted = .false.
            h_next = h
            call self%control%reduce(h_next)
            return
         end if
      end if
      if (stale) call evaluate(self, ode, t_new, self%y_new, self%k(:, stages), info)
   end subroutine take

   !> Makes the end of the last try the state from which the next one starts.
   pure subroutine accept(self, t_new, h_next)
      !> The step.
      class(step_t), intent(inout) :: self
      !> Time at the end [s].
      real(wp), intent(in) :: t_new
      !> Length of the next try [s].
      real(wp), intent(in) :: h_next
      integer :: i

      self%t = t_new
      self%h = h_next
      do i = 1, size(self%y)
         self%y(i) = self%y_new(i)
         self%k(i, 1) = self%k(i, stages)
      end do
   end subroutine accept

   !> The continuous extension of a try that holds, for `interpolate`.
   subroutine prepare_interpolation(self, h)
      !> The step.
      class(step_t), intent(inout) :: self
      !> Its length [s].
      real(wp), intent(in) :: h

      call dense_coefficients(h, self%y, self%y_new, self%k, self%dense)
   end subroutine prepare_interpolation

   !> The state inside the try that holds, on the system's invariants, in `y_work`.
   subroutine interpolate(self, ode, t, h, info)
      !> The step.
      class(step_t), intent(inout) :: self
      !> What is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> Time [s].
      real(wp), intent(in) :: t
      !> Length of the step [s].
      real(wp), intent(in) :: h
      !> One of the `rhs_` constants.
      integer, intent(out) :: info
      logical :: stale

      call dense_value((t - self%t)/h, self%dense, self%y_work)
      call ode%project(t, self%y_work, .false., stale, info)
   end subroutine interpolate

   !> Passes through an archive what is remembered between two steps.
   subroutine serialize(self, archive)
      !> The step, initialized.
      class(step_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      call archive%item('t', self%t)
      call archive%item('h', self%h)
      call archive%item('direction', self%direction)
      call archive%item('evaluations', self%evaluations)
      call archive%item('lower bound of t', self%t_low)
      call archive%item('upper bound of t', self%t_high)
      call archive%item('y', self%y)
      call archive%item('ydot', self%k(:, 1))
      call self%control%serialize(archive)
   end subroutine serialize

end module taut_ode_step
