!> What an equilibrium is solved with: the constraints of a system at rest, the reactions to given forces, and Newton's step along
!! the motions that are free.
!!
!! Whatever the size, the same is decided: which rows are independent, which motions nothing resists and whether one of them is
!! loaded.
module taut_constrained_rest
   use taut_kinds, only: wp
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_constrained_tangent, only: tangent_t
   implicit none (type, external)
   private
   public :: rest_solver_t, rest_ok, rest_not_finite, rest_failed, rest_loaded

   !> What comes of it: solved; an entry is not finite; a linear problem could not be solved; a motion that nothing resists is
   !! loaded.
   integer, parameter :: rest_ok = 0, rest_not_finite = 1, rest_failed = 2, rest_loaded = 3

   !> A system at rest.
   type, abstract :: rest_solver_t
      !> Velocities that are not blocked, and which they are: (n).
      integer, allocatable :: free(:)
      logical, allocatable :: is_free(:)
      !> Rank of the constraints, and motions that nothing resists.
      integer :: rank = 0, free_motions = 0
      !> The velocity with the largest part in a motion that is loaded, though nothing resists it.
      integer :: loaded = 0
      !> K.
      type(tangent_t) :: tangent
   contains
      procedure(lay_out_system), deferred :: init
      procedure(look_at_state), deferred :: look
      procedure(find_reactions), deferred :: reactions
      procedure(find_sizes), deferred :: sizes_of_reactions
      procedure(compare_forces), deferred :: balanced
      procedure(meet_constraints), deferred :: meet
      procedure(take_step), deferred :: step
   end type rest_solver_t

   abstract interface
      !> Lays everything out.
      subroutine lay_out_system(self, model, free)
         import :: mechanical_system_t, rest_solver_t
         implicit none (type, external)
         !> The solver.
         class(rest_solver_t), intent(inout) :: self
         !> The system.
         class(mechanical_system_t), intent(in) :: model
         !> Velocities that are not blocked.
         integer, intent(in) :: free(:)
      end subroutine lay_out_system

      !> A at a state, and its rank.
      subroutine look_at_state(self, model, at, info)
         import :: mechanical_system_t, rest_solver_t, state_t
         implicit none (type, external)
         !> The solver, laid out.
         class(rest_solver_t), intent(inout) :: self
         !> The system.
         class(mechanical_system_t), intent(in) :: model
         !> Its state, at rest.
         type(state_t), intent(in) :: at
         !> `rest_ok`, `rest_not_finite` or `rest_failed`.
         integer, intent(out) :: info
      end subroutine look_at_state

      !> Multipliers of minimum norm that leave least of the forces, and what they leave.
      subroutine find_reactions(self, f, lambda, left)
         import :: rest_solver_t, wp
         implicit none (type, external)
         !> The solver, which has looked at the state.
         class(rest_solver_t), intent(inout) :: self
         !> Forces: (n).
         real(wp), intent(in), contiguous :: f(:)
         !> Multipliers: (c).
         real(wp), intent(out), contiguous :: lambda(:)
         !> f - A^T lambda; along blocked velocities not of account: (n).
         real(wp), intent(out), contiguous :: left(:)
      end subroutine find_reactions

      !> The sizes of the terms of A^T lambda, added up.
      subroutine find_sizes(self, lambda, sizes)
         import :: rest_solver_t, wp
         implicit none (type, external)
         !> The solver, which has looked at the state.
         class(rest_solver_t), intent(in) :: self
         !> Multipliers: (c).
         real(wp), intent(in) :: lambda(:)
         !> |A^T| |lambda|: (n).
         real(wp), intent(out) :: sizes(:)
      end subroutine find_sizes

      !> Whether forces along the motions that the constraints leave are no more than what they are worth.
      function compare_forces(self, left, uncertain) result(balanced)
         import :: rest_solver_t, wp
         implicit none (type, external)
         !> The solver, which has looked at the state.
         class(rest_solver_t), intent(in) :: self
         !> The forces: (n).
         real(wp), intent(in) :: left(:)
         !> What they are worth: (n).
         real(wp), intent(in) :: uncertain(:)
         !> Whether they are.
         logical :: balanced
      end function compare_forces

      !> d = -A^+ phi, and what it leaves of phi.
      subroutine meet_constraints(self, phi, d, left)
         import :: rest_solver_t, wp
         implicit none (type, external)
         !> The solver, which has looked at the state.
         class(rest_solver_t), intent(inout) :: self
         !> Violation: (c).
         real(wp), intent(in), contiguous :: phi(:)
         !> Displacement: (n).
         real(wp), intent(out), contiguous :: d(:)
         !> A d + phi: (c).
         real(wp), intent(out), contiguous :: left(:)
      end subroutine meet_constraints

      !> Newton's step: K d = f along the motions that the constraints leave.
      subroutine take_step(self, model, at, lambda, difference, f, uncertain, d, info)
         import :: mechanical_system_t, rest_solver_t, state_t, wp
         implicit none (type, external)
         !> The solver, which has looked at the state.
         class(rest_solver_t), intent(inout) :: self
         !> The system.
         class(mechanical_system_t), intent(in) :: model
         !> Its state, at rest.
         type(state_t), intent(in) :: at
         !> Multipliers: (c).
         real(wp), intent(in) :: lambda(:)
         !> Relative step of the differences; 0 for the default.
         real(wp), intent(in) :: difference
         !> Forces that are left: (n).
         real(wp), intent(in) :: f(:)
         !> How much of each is not to be relied on: (n).
         real(wp), intent(in) :: uncertain(:)
         !> The displacement that meets the constraints, to which the step is added: (n).
         real(wp), intent(inout) :: d(:)
         !> One of the constants.
         integer, intent(out) :: info
      end subroutine take_step
   end interface

end module taut_constrained_rest
