!> Observers see the solution while it is computed.
module taut_ode_observer
   use taut_kinds, only: wp
   use taut_error, only: error_t
   use taut_ode_step, only: step_t
   use taut_ode_system, only: ode_system_t
   implicit none (type, external)
   private
   public :: observer_t, trajectory_t

   !> Receives the output points in order of time.
   type, abstract :: observer_t
      !> Whether it follows the steps too, and not only the output points; to be set before the steps begin, in `begin` at the latest.
      logical :: follows = .false.
   contains
      procedure(observe_point), deferred :: observe
      procedure :: follow => no_interest
      procedure :: begin => nothing_to_do
      procedure :: finish => nothing_to_do
   end type observer_t

   !> An observer that keeps every point of one integration; the next one begins anew.
   type, extends(observer_t) :: trajectory_t
      !> Number of points.
      integer :: points = 0
      !> Times [s]; while the integration goes on, the first `points` entries count, afterwards there are no others.
      real(wp), allocatable :: t(:)
      !> States, as many: (n, points).
      real(wp), allocatable :: y(:, :)
   contains
      procedure :: observe => keep
      procedure :: begin => forget
      procedure :: finish => trim_arrays
   end type trajectory_t

   abstract interface
      !> One output point.
      subroutine observe_point(self, ode, t, h, y, error)
         import :: observer_t, ode_system_t, error_t, wp
         implicit none (type, external)
         !> The observer.
         class(observer_t), intent(inout) :: self
         !> The system that is integrated; its right-hand side may be called, the integration does not mind.
         class(ode_system_t), intent(inout) :: ode
         !> Time [s].
         real(wp), intent(in) :: t
         !> The step that ends at, or holds, this point; 0 at the start [s].
         real(wp), intent(in) :: h
         !> State: (n).
         real(wp), intent(in), contiguous :: y(:)
         !> Set by an observer that cannot go on; the integration ends.
         type(error_t), allocatable, intent(inout) :: error
      end subroutine observe_point
   end interface

contains

   !> Told before the first point, and behind the last; a pause is neither. The default does nothing.
   subroutine nothing_to_do(self)
      !> The observer.
      class(observer_t), intent(inout) :: self

      associate (unused_observer => self)
      end associate
   end subroutine nothing_to_do

   !> A step that holds, if the observer `follows`; before its output points. The default does nothing.
   subroutine no_interest(self, ode, step, t_last, error)
      !> The observer.
      class(observer_t), intent(inout) :: self
      !> The system that is integrated; its right-hand side may be called, the integration does not mind.
      class(ode_system_t), intent(inout) :: ode
      !> From `t`, `y` to `t_new`, `y_new`, not yet accepted; `interpolate` gives what is between.
      class(step_t), intent(inout) :: step
      !> Its end, or where a terminal event ends it [s].
      real(wp), intent(in) :: t_last
      !> Set by an observer that cannot go on; the integration ends.
      type(error_t), allocatable, intent(inout) :: error

      associate (unused_observer => self, unused_system => ode, unused_step => step, unused_end => t_last, unused_error => error)
      end associate
   end subroutine no_interest

   !> Forgets the points of an integration before.
   subroutine forget(self)
      !> The trajectory.
      class(trajectory_t), intent(inout) :: self

      self%points = 0
      if (allocated(self%t)) deallocate (self%t, self%y)
   end subroutine forget

   !> Gives the arrays the size of what they hold.
   subroutine trim_arrays(self)
      !> The trajectory.
      class(trajectory_t), intent(inout) :: self

      if (.not. allocated(self%t)) return
      self%t = self%t(:self%points)
      self%y = self%y(:, :self%points)
   end subroutine trim_arrays

   !> Keeps a point.
   subroutine keep(self, ode, t, h, y, error)
      !> The trajectory.
      class(trajectory_t), intent(inout) :: self
      !> The system that is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> Time [s].
      real(wp), intent(in) :: t
      !> The step [s].
      real(wp), intent(in) :: h
      !> State: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Never set.
      type(error_t), allocatable, intent(inout) :: error
      real(wp), allocatable :: more_t(:), more_y(:, :)
      integer :: room

      if (.not. allocated(self%t)) allocate (self%t(256), self%y(size(y), 256))
      room = size(self%t)
      if (self%points == room) then
         allocate (more_t(2*room), more_y(size(y), 2*room))
         more_t(1:room) = self%t
         more_y(:, 1:room) = self%y
         call move_alloc(more_t, self%t)
         call move_alloc(more_y, self%y)
      end if
      self%points = self%points + 1
      self%t(self%points) = t
      self%y(:, self%points) = y
      associate (unused_system => ode, unused_step => h, unused_error => error)
      end associate
   end subroutine keep

end module taut_ode_observer
