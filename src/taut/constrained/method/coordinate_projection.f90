!> Eq. (8), with positions and velocities projected on the constraints after each step (Eich).
module taut_constrained_method_coordinate_projection
   use taut_kinds, only: wp
   use taut_constrained_method_baseline, only: baseline_t
   use taut_error, only: error_t
   use taut_ode_system, only: evaluated_step_end, inside_step, rhs_ok
   implicit none (type, external)
   private
   public :: coordinate_projection_t

   !> The method `coordinate-projection`.
   type, extends(baseline_t) :: coordinate_projection_t
      !> Violation above which there is a correction; negative: always.
      real(wp) :: threshold = -1.0_wp
   contains
      procedure :: set_up
      procedure :: project
      procedure :: filter_error
   end type coordinate_projection_t

contains

   !> As `baseline`.
   subroutine set_up(self, error)
      !> The formulation.
      class(coordinate_projection_t), intent(inout) :: self
      !> Left alone.
      type(error_t), allocatable, intent(inout) :: error

      call self%baseline_t%set_up(error)
      self%replaces = .true.
      self%rhs_projects = .false.
   end subroutine set_up

   !> Replaces x by Eq. (17) and v by Eq. (11a) where the violation exceeds the threshold.
   subroutine project(self, t, y, place, stale, info)
      !> The formulation.
      class(coordinate_projection_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State {x; v; w}, replaced: (size).
      real(wp), intent(inout), contiguous :: y(:)
      !> `inside_step`, `step_end` or `evaluated_step_end`.
      integer, intent(in) :: place
      !> Whether the derivative has to be evaluated again: if anything was replaced.
      logical, intent(out) :: stale
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      stale = .false.
      call self%unpack(t, y, self%at)
      call self%projector%correct(self%model, self%at, info, threshold=self%threshold)
      if (info == rhs_ok .and. place /= inside_step) call self%projector%check_branch(self%model, self%at, info)
      if (info /= rhs_ok) return
      call self%pack(self%at, y)
      if (place == inside_step) return
      stale = place == evaluated_step_end .and. max(self%projector%newton%phi_raw, self%projector%phidot_raw()) > self%threshold
      call self%remember()
   end subroutine project

   !> Takes off the local error what `project` will take off the state, unless violations gather over many steps first.
   subroutine filter_error(self, error)
      !> The formulation.
      class(coordinate_projection_t), intent(inout) :: self
      !> Estimate of the local error: (size).
      real(wp), intent(inout), contiguous :: error(:)
      integer :: info, n_x

      if (self%threshold >= 0.0_wp) return
      call self%projector%linear%linearize(self%model, self%at, info, 0.0_wp)
      if (info /= rhs_ok) return
      n_x = self%model%n_x
      call self%projector%filter_position(self%model, self%at, error(:n_x))
      call self%projector%filter_velocity(self%model, error(n_x + 1:n_x + self%model%n))
   end subroutine filter_error

end module taut_constrained_method_coordinate_projection
