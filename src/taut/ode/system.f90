!> Systems of ordinary differential equations y' = f(t, y), and nothing about where they come from.
module taut_ode_system
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   implicit none (type, external)
   private
   public :: ode_system_t
   public :: rhs_ok, rhs_retry, rhs_failed, rhs_no_projection

   !> What a right-hand side or a projection answers.
   !!
   !! `rhs_retry`: not defined here, try a smaller step; `rhs_failed`: stop; `rhs_no_projection`: the projection on the
   !! constraints did not converge, try a smaller step.
   integer, parameter :: rhs_ok = 0, rhs_retry = 1, rhs_failed = 2, rhs_no_projection = 3

   !> y' = f(t, y). A system owns the workspace of its right-hand side: one object per thread.
   type, abstract :: ode_system_t
      !> Whether a step is rejected when its projection moves the state by more than the integrator's `projection_limit`: it
      !! makes no sense where violations gather over many steps before they are corrected.
      logical :: limits_projection = .true.
      !> Times between which the system is looked at [s], set by the integrator: inside two breakpoints, where a load or a drive
      !! may jump. A state at a breakpoint belongs to the stretch before it, until the next one begins.
      real(wp) :: t_low = -huge(1.0_wp), t_high = huge(1.0_wp)
   contains
      procedure(right_hand_side), deferred :: rhs
      procedure :: project => project_nothing
      procedure :: filter_error => filter_nothing
      procedure :: breakpoints => no_breakpoints
      procedure :: failure => no_failure
      procedure :: serialize => nothing_to_serialize
   end type ode_system_t

   abstract interface
      !> The derivative of the state.
      subroutine right_hand_side(self, t, y, dydt, info)
         import :: ode_system_t, wp
         implicit none (type, external)
         !> The system.
         class(ode_system_t), intent(inout) :: self
         !> Time [s].
         real(wp), intent(in) :: t
         !> State: (n).
         real(wp), intent(in), contiguous :: y(:)
         !> Its derivative: (n).
         real(wp), intent(out), contiguous :: dydt(:)
         !> One of the `rhs_` constants. Entries that are not finite also mean 'try a smaller step'.
         integer, intent(out) :: info
      end subroutine right_hand_side
   end interface

contains

   !> Replaces a state by the one on the system's invariants. The default leaves it as it is.
   subroutine project_nothing(self, t, y, fresh, stale, info)
      !> The system.
      class(ode_system_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State, replaced: (n).
      real(wp), intent(inout), contiguous :: y(:)
      !> Whether the last call of `rhs` was for this very t and y, so that what it found may be used again.
      logical, intent(in) :: fresh
      !> Whether the derivative at the new state differs from that at the old one and has to be evaluated again.
      logical, intent(out) :: stale
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      stale = .false.
      info = rhs_ok
      associate (unused_system => self, unused_time => t, unused_state => y, unused_flag => fresh)
      end associate
   end subroutine project_nothing

   !> Takes off a local error what `project` will take off the state, at the state of the last call of `rhs`. The
   !! default takes off nothing.
   subroutine filter_nothing(self, error)
      !> The system.
      class(ode_system_t), intent(inout) :: self
      !> Estimate of the local error: (n).
      real(wp), intent(inout), contiguous :: error(:)

      associate (unused_system => self, unused_error => error)
      end associate
   end subroutine filter_nothing

   !> Times at which the right-hand side has a kink or a jump. The default has none.
   function no_breakpoints(self) result(times)
      !> The system.
      class(ode_system_t), intent(in) :: self
      !> Times in any order [s].
      real(wp), allocatable :: times(:)

      allocate (times(0))
      associate (unused_system => self)
      end associate
   end function no_breakpoints

   !> What the last answer other than `rhs_ok` was about, in words.
   subroutine no_failure(self, text)
      !> The system.
      class(ode_system_t), intent(in) :: self
      !> One line, may be empty.
      character(:), allocatable, intent(out) :: text

      text = ''
      associate (unused_system => self)
      end associate
   end subroutine no_failure

   !> Passes through an archive what the system remembers from one step to the next. The default remembers nothing.
   subroutine nothing_to_serialize(self, archive)
      !> The system.
      class(ode_system_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      associate (unused_system => self, unused_archive => archive)
      end associate
   end subroutine nothing_to_serialize

end module taut_ode_system
