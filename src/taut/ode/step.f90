!> Where an integration stands, and the step at hand: a stepper and a step control between two stops.
module taut_ode_step
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   use taut_error, only: error_t
   use taut_ode_options, only: integration_options_t
   use taut_ode_step_control, only: step_control_t
   use taut_ode_stepper, only: stepper_t
   use taut_ode_stepper_choose, only: choose_stepper
   use taut_ode_system, only: inside_step, ode_system_t, rhs_ok
   implicit none (type, external)
   private
   public :: step_t

   !> State and step; nothing is allocated inside a step.
   type :: step_t
      !> Time [s], and the length of the next try [s].
      real(wp) :: t = 0.0_wp, h = 0.0_wp
      !> End and length of the last try [s].
      real(wp) :: t_new = 0.0_wp, h_tried = 0.0_wp
      !> The integral that goes along with the system, at `t`.
      real(wp) :: integral = 0.0_wp
      !> How far it may be off, and the sum of its parts without their signs.
      real(wp) :: integral_error = 0.0_wp, moved = 0.0_wp
      !> 1 forwards, -1 backwards.
      real(wp) :: direction = 1.0_wp
      !> State at `t`; state at the end of the last try; state inside it, by `interpolate`: (n).
      real(wp), allocatable :: y(:), y_new(:), y_inside(:)
      !> Error norm and step-size controller.
      type(step_control_t) :: control
      !> The method.
      class(stepper_t), allocatable :: stepper
      !> Whether the step at hand begins where the one before has not ended: at the start, behind a breakpoint, where a state was
      !! replaced.
      logical :: anew = .true.
      !> Times between which the right-hand side is evaluated: inside two breakpoints.
      real(wp), private :: t_low = -huge(1.0_wp), t_high = huge(1.0_wp)
      real(wp), private :: first_step = 0.0_wp, min_step = 0.0_wp, max_step = 0.0_wp
      !> Whether the continuous extension of the last try is there.
      logical, private :: dense = .false.
   contains
      procedure :: init
      procedure :: set_bounds
      procedure :: apply_bounds
      procedure :: cross
      procedure :: begin
      procedure :: try
      procedure :: accept
      procedure :: interpolate
      procedure :: forget_inside
      procedure :: integral_at
      procedure :: tell_integral
      procedure :: serialize
   end type step_t

contains

   !> Allocates the workspace.
   subroutine init(self, n, options, error, stepper)
      !> The step.
      class(step_t), intent(out) :: self
      !> Size of the state.
      integer, intent(in) :: n
      !> How to integrate.
      type(integration_options_t), intent(in) :: options
      !> A tolerance or a name that is not valid.
      type(error_t), allocatable, intent(inout) :: error
      !> Takes the place of the one that `options%integrator` names; copied.
      class(stepper_t), intent(in), optional :: stepper

      if (present(stepper)) then
         allocate (self%stepper, source=stepper)
      else
         call choose_stepper(trim(options%integrator), self%stepper, error)
         if (.not. allocated(self%stepper)) return
      end if
      call self%stepper%init(n)
      call self%control%init(n, options, self%stepper%order, self%stepper%constants, error)
      self%first_step = options%first_step
      self%min_step = options%min_step
      self%max_step = options%max_step
      allocate (self%y(n), self%y_new(n), self%y_inside(n), source=0.0_wp)
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
      real(wp) :: before

      before = min(max(self%t, self%t_low), self%t_high)
      call self%set_bounds(stop_time)
      call self%apply_bounds(ode)
      call ode%cross(self%t, before, self%y, info)
   end subroutine cross

   !> History and length of the first step of a stretch without breakpoints.
   subroutine begin(self, ode, stop_time, info)
      !> The step, its time and state set.
      class(step_t), intent(inout) :: self
      !> What is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> End of the stretch [s].
      real(wp), intent(in) :: stop_time
      !> One of the `rhs_` constants.
      integer, intent(out) :: info
      real(wp) :: h

      call self%set_bounds(stop_time)
      call self%apply_bounds(ode)
      call self%control%renew()
      self%anew = .true.
      call self%stepper%start(ode, self%t, self%y, info)
      if (info /= rhs_ok) return
      if (self%first_step > 0.0_wp) then
         self%h = self%direction*self%first_step
         return
      end if
      call self%stepper%first_step(ode, self%control, self%t, self%y, &
                                   self%direction*min(self%max_step, abs(stop_time - self%t)), h)
      self%h = self%direction*max(abs(h), self%min_step)
   end subroutine begin

   !> One try.
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
      real(wp) :: integrand
      logical :: vain

      self%t_new = t_new
      self%h_tried = h
      self%dense = .false.
      integrand = self%stepper%integrand_behind
      call self%stepper%try(ode, self%control, self%t, self%y, t_new, h, self%y_new, h_next, accepted, info)
      if (.not. (accepted .and. ode%has_integral .and. ode%integral_counts .and. self%stepper%estimates_integral)) return
      associate (s => self%stepper)
         call self%control%decide_by_integral(h, s%gain_error, ode%integral_scale + self%moved + abs(s%gain) + &
                                              0.5_wp*abs(h)*(abs(s%integrand_before) + abs(s%integrand_behind)), &
                                              ode%integral_unit, h_next, accepted, vain)
         if (.not. accepted .or. vain) s%integrand_behind = integrand
         if (vain) s%gain = h*integrand
      end associate
   end subroutine try

   !> Makes the end of the last try the state from which the next one starts, and tells the system.
   subroutine accept(self, ode, h_next, replaced, info)
      !> The step.
      class(step_t), intent(inout) :: self
      !> What is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> Length of the next try [s].
      real(wp), intent(in) :: h_next
      !> Whether the system has replaced the state.
      logical, intent(out) :: replaced
      !> One of the `rhs_` constants: whether the derivative at a state that was replaced is there.
      integer, intent(out) :: info
      integer :: i

      self%t = self%t_new
      self%h = h_next
      call self%control%step_on()
      self%integral = self%integral + self%stepper%gain
      self%integral_error = self%integral_error + self%stepper%gain_error
      self%moved = self%moved + abs(self%stepper%gain)
      !GCC$ unroll 1
      do i = 1, size(self%y)
         self%y(i) = self%y_new(i)
      end do
      call self%stepper%accept()
      info = rhs_ok
      call ode%accepted(self%t, self%y, replaced)
      self%anew = replaced
      if (replaced) call self%stepper%start(ode, self%t, self%y, info)
   end subroutine accept

   !> The state inside the try that holds, on the system's invariants, in `y_inside`.
   subroutine interpolate(self, ode, t, info)
      !> The step.
      class(step_t), intent(inout) :: self
      !> What is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> Time [s].
      real(wp), intent(in) :: t
      !> One of the `rhs_` constants.
      integer, intent(out) :: info
      logical :: stale

      if (.not. self%dense) then
         call self%stepper%prepare_dense(ode, self%t, self%y, self%t_new, self%h_tried, self%y_new, info)
         if (info /= rhs_ok) return
         self%dense = .true.
      end if
      call self%stepper%interpolate((t - self%t)/self%h_tried, self%y_inside)
      call ode%project(t, self%y_inside, inside_step, stale, info)
   end subroutine interpolate

   !> Forgets the continuous extension of the last try: who asks for it next pays for it.
   subroutine forget_inside(self)
      !> The step.
      class(step_t), intent(inout) :: self

      self%dense = .false.
   end subroutine forget_inside

   !> The integral that goes along, at the start or the end of the try that holds, or, behind `interpolate`, inside it.
   pure real(wp) function integral_at(self, t)
      !> The step.
      class(step_t), intent(in) :: self
      !> Time [s].
      real(wp), intent(in) :: t

      if (.not. abs(t - self%t) > 0.0_wp) then
         integral_at = self%integral
      else if (.not. abs(t - self%t_new) > 0.0_wp) then
         integral_at = self%integral + self%stepper%gain
      else
         integral_at = self%integral + self%stepper%integral_inside(self%h_tried, (t - self%t)/self%h_tried)
      end if
   end function integral_at

   !> Tells a system the integral that goes along with it, at a time of the try that holds.
   subroutine tell_integral(self, ode, t)
      !> The step.
      class(step_t), intent(in) :: self
      !> The system.
      class(ode_system_t), intent(inout) :: ode
      !> Time, as in `integral_at` [s].
      real(wp), intent(in) :: t

      ode%integral = self%integral_at(t)
      ode%integral_error = self%integral_error + self%stepper%gain_error
   end subroutine tell_integral

   !> Passes through an archive what is remembered between two steps.
   subroutine serialize(self, archive)
      !> The step, initialized.
      class(step_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      call archive%item('t', self%t)
      call archive%item('h', self%h)
      call archive%item('direction', self%direction)
      call archive%item('lower bound of t', self%t_low)
      call archive%item('upper bound of t', self%t_high)
      call archive%item('y', self%y)
      call archive%item('integral', self%integral)
      call archive%item('error of the integral', self%integral_error)
      call archive%item('parts of the integral', self%moved)
      call archive%item('begins anew', self%anew)
      call self%control%serialize(archive)
      call self%stepper%work%serialize(archive)
      call self%stepper%serialize(archive)
   end subroutine serialize

end module taut_ode_step
