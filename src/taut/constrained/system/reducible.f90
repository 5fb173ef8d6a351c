!> Systems that have a smaller one with the same motion, such as one where what turns about a fixed point moves by its angle alone.
module taut_constrained_system_reducible
   use taut_kinds, only: wp
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_constrained_system_stiff, only: stiff_system_t
   implicit none (type, external)
   private
   public :: reducible_system_t, reduction_t

   !> The smaller system, and how the state of the whole one follows from its state. Its coordinates, velocities and constraints are
   !! some of those of the whole system, the constraints with the same multipliers; the other coordinates and velocities follow,
   !! and the other constraints are met by that. Where one of its coordinates is not that of the whole system by itself, such as the
   !! center of bodies that are welded together, `narrow` finds it and `widen` replaces it too. It has no states that are not
   !! mechanics.
   type, abstract :: reduction_t
      !> The smaller system.
      class(mechanical_system_t), allocatable :: system
      !> Which coordinates, velocities and constraints of the whole system those of the smaller one are.
      integer, allocatable :: x(:), v(:), row(:)
      !> Whether one of its coordinates or velocities is not that of the whole system by itself, so that `narrow` is to be asked.
      logical :: narrows = .false.
   contains
      procedure :: narrow => keep_state
      procedure :: narrow_change => keep_change
      procedure(follow_state), deferred :: widen
      procedure(follow_rate), deferred :: widen_rate
      procedure(follow_change), deferred :: widen_change
   end type reduction_t

   !> A system that may have a smaller one with the same motion; by default it has none.
   type, abstract, extends(stiff_system_t) :: reducible_system_t
   contains
      procedure :: reduce => nothing_to_reduce
   end type reducible_system_t

   abstract interface
      !> The coordinates and velocities that follow.
      pure subroutine follow_state(self, small, x, v)
         import :: reduction_t, state_t, wp
         implicit none (type, external)
         !> The reduction.
         class(reduction_t), intent(in) :: self
         !> State of the smaller system.
         type(state_t), intent(in) :: small
         !> Coordinates of the whole system; those that follow are set: (n_x).
         real(wp), intent(inout) :: x(:)
         !> Velocities, likewise: (n).
         real(wp), intent(inout) :: v(:)
      end subroutine follow_state

      !> Their rates.
      pure subroutine follow_rate(self, small, xdot, vdot)
         import :: reduction_t, state_t, wp
         implicit none (type, external)
         !> The reduction.
         class(reduction_t), intent(in) :: self
         !> State of the smaller system.
         type(state_t), intent(in) :: small
         !> Rates of the coordinates of the whole system, those of the smaller one in place; those that follow are set: (n_x).
         real(wp), intent(inout) :: xdot(:)
         !> Accelerations, likewise: (n).
         real(wp), intent(inout) :: vdot(:)
      end subroutine follow_rate

      !> Their change with a small change of the state.
      pure subroutine follow_change(self, small, dx, dv)
         import :: reduction_t, state_t, wp
         implicit none (type, external)
         !> The reduction.
         class(reduction_t), intent(in) :: self
         !> State of the smaller system.
         type(state_t), intent(in) :: small
         !> Changes of the coordinates of the whole system, those of the smaller one in place; those that follow are set: (n_x).
         real(wp), intent(inout) :: dx(:)
         !> Changes of the velocities, likewise: (n).
         real(wp), intent(inout) :: dv(:)
      end subroutine follow_change
   end interface

contains

   !> The default: coordinates and velocities are those of the whole system.
   pure subroutine keep_state(self, x, v)
      !> The reduction.
      class(reduction_t), intent(in) :: self
      !> Coordinates of the smaller system, as they were taken from the whole one: (its n_x).
      real(wp), intent(inout) :: x(:)
      !> Velocities, likewise: (its n).
      real(wp), intent(inout) :: v(:)

      associate (unused_reduction => self, unused_x => x, unused_v => v)
      end associate
   end subroutine keep_state

   !> The default: so are their small changes.
   pure subroutine keep_change(self, small, dx, dv)
      !> The reduction.
      class(reduction_t), intent(in) :: self
      !> State of the smaller system.
      type(state_t), intent(in) :: small
      !> Changes of its coordinates, as they were taken from the whole system: (its n_x).
      real(wp), intent(inout) :: dx(:)
      !> Changes of its velocities, likewise: (its n).
      real(wp), intent(inout) :: dv(:)

      associate (unused_reduction => self, unused_state => small, unused_dx => dx, unused_dv => dv)
      end associate
   end subroutine keep_change

   !> The default: there is no smaller system.
   subroutine nothing_to_reduce(self, reduction)
      !> The system.
      class(reducible_system_t), intent(in) :: self
      !> The smaller system; not allocated if there is none.
      class(reduction_t), allocatable, intent(out) :: reduction

      associate (unused_system => self, unused_reduction => reduction)
      end associate
   end subroutine nothing_to_reduce

end module taut_constrained_system_reducible
