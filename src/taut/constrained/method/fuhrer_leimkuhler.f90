!> Fuhrer and Leimkuhler: the stabilized equations of Gear, Gupta and Leimkuhler with the second derivative of the constraints too,
!! phi = 0, A v = b' and A vdot = b'', each with a multiplier of its own.
!!
!! lambda is that of A vdot = b'', Eq. (14b). The multipliers of the other two levels vanish with the step: the one is a
!! displacement, x - W^-1 A^T mu, the other an impulse, v - M^-1 A^T eta. They are eliminated where the derivative is evaluated,
!! so that an explicit integrator keeps its order; left in the derivative of a stage, as half-explicit methods do, lambda + eta
!! would be the multiplier of `gear-gupta-leimkuhler`, and its order too. `present` enforces the same three levels, Eqs (10),
!! (16): it differs by what velocities are corrected with, W instead of M. An implicit integrator projects at the end of each
!! step besides.
!!
!! Source: C. Fuhrer, B.J. Leimkuhler, Numerical solution of differential-algebraic equations for constrained mechanical motion,
!! Numer. Math. 59 (1991) 55-69, reference [23] of the paper.
module taut_constrained_method_fuhrer_leimkuhler
   use taut_kinds, only: wp
   use taut_constrained_method_baseline, only: baseline_t
   use taut_error, only: error_t
   use taut_ode_system, only: evaluated_step_end, inside_step, rhs_no_projection, rhs_ok
   implicit none (type, external)
   private
   public :: fuhrer_leimkuhler_t

   !> The method `fuhrer-leimkuhler`.
   type, extends(baseline_t) :: fuhrer_leimkuhler_t
      !> Impulses of the velocities' multipliers; none; those of an error: (c).
      real(wp), allocatable :: eta(:)
      real(wp), allocatable, private :: none(:), spare(:)
   contains
      procedure :: set_up
      procedure :: rhs
      procedure, non_overridable :: meet_state
      procedure :: project
      procedure :: filter_error
   end type fuhrer_leimkuhler_t

contains

   !> Makes room.
   subroutine set_up(self, error)
      !> The formulation.
      class(fuhrer_leimkuhler_t), intent(inout) :: self
      !> Left alone.
      type(error_t), allocatable, intent(inout) :: error

      self%carries_reactions = .false.
      call self%baseline_t%set_up(error)
      self%replaces = .true.
      allocate (self%eta(self%model%c), self%none(self%model%c), self%spare(self%model%c), source=0.0_wp)
   end subroutine set_up

   !> Three levels, one after the other.
   subroutine rhs(self, t, y, dydt, info)
      !> The formulation.
      class(fuhrer_leimkuhler_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State {x; v; w}: (size).
      real(wp), intent(in), contiguous :: y(:)
      !> Its derivative: (size).
      real(wp), intent(out), contiguous :: dydt(:)
      !> One of the `rhs_` constants.
      integer, intent(out) :: info
      integer :: last_v, n_x

      n_x = self%model%n_x
      last_v = n_x + self%model%n
      associate (model => self%model, at => self%at, vdot => dydt(n_x + 1:last_v))
         call self%unpack(t, y, at)
         call self%meet_state(info)
         if (info /= rhs_ok) return
         call model%acceleration_rhs(at, self%b_second)
         call model%force(at, self%force)
         call self%mass%accelerate(self%projector, self%force, vdot)
         call self%mass%correct_acceleration(self%projector, self%b_second, vdot, self%lambda)
         if (self%has_integral) call self%find_power(self%projector%b_prime)
         call model%x_rate(at, at%v, dydt(:n_x))
         if (model%n_w > 0) call model%w_rate(at, dydt(last_v + 1:))
      end associate
   end subroutine rhs

   !> Positions by displacements, velocities by impulses: A, M and M~ are in place behind it, and eta.
   subroutine meet_state(self, info)
      !> The formulation, with the state in place.
      class(fuhrer_leimkuhler_t), intent(inout) :: self
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      associate (model => self%model, at => self%at, projector => self%projector)
         call projector%position(model, at, info)
         if (info == rhs_no_projection) call projector%position_again(model, at, info)
         if (info == rhs_ok) call projector%linear%linearize(model, at, info, 0.0_wp)
         if (info == rhs_ok) call self%mass%renew(model, at, info)
         if (info == rhs_ok) call self%mass%reduce(projector, info)
         if (info /= rhs_ok .or. model%c == 0) return
         call projector%velocity_violation(model, at)
         call self%mass%correct_acceleration(projector, projector%b_prime, at%v, self%eta)
      end associate
   end subroutine meet_state

   !> Replaces x and v by those that meet their constraints; the derivative is that of these already.
   subroutine project(self, t, y, place, stale, info)
      !> The formulation.
      class(fuhrer_leimkuhler_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State {x; v; w}, replaced: (size).
      real(wp), intent(inout), contiguous :: y(:)
      !> `inside_step`, `step_end` or `evaluated_step_end`.
      integer, intent(in) :: place
      !> False: the derivative stays.
      logical, intent(out) :: stale
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      stale = .false.
      info = rhs_ok
      if (place /= evaluated_step_end) then
         call self%unpack(t, y, self%at)
         call self%meet_state(info)
      end if
      if (info == rhs_ok .and. place /= inside_step) call self%projector%check_branch(self%model, self%at, info)
      if (info /= rhs_ok) return
      call self%pack(self%at, y)
      if (place == inside_step) return
      call self%remember()
      self%step_end%mu(:) = self%eta
   end subroutine project

   !> Takes off the local error what displacements and impulses take off the state.
   subroutine filter_error(self, error)
      !> The formulation.
      class(fuhrer_leimkuhler_t), intent(inout) :: self
      !> Estimate of the local error: (size).
      real(wp), intent(inout), contiguous :: error(:)
      integer :: last_v, n_x

      if (self%model%c == 0) return
      n_x = self%model%n_x
      last_v = n_x + self%model%n
      call self%projector%filter_position(self%model, self%at, error(:n_x))
      call self%mass%correct_acceleration(self%projector, self%none, error(n_x + 1:last_v), self%spare)
   end subroutine filter_error

end module taut_constrained_method_fuhrer_leimkuhler
