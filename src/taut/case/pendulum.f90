!> Case files of the pendulum.
module taut_case_pendulum
   use taut_kinds, only: wp
   use taut_error, only: error_t
   use taut_case_entries, only: entries_t
   use taut_case_model_group, only: model_group_t
   use taut_constrained_system, only: state_t
   use taut_constrained_system_tables, only: tabulated_system_t
   use taut_model_pendulum, only: pendulum_t, new_pendulum
   implicit none (type, external)
   private
   public :: pendulum_group_t

   !> &pendulum; what it leaves out has the values of Sect. 4.1.
   type, extends(model_group_t) :: pendulum_group_t
      !> Mass [kg], length [m], gravity [m/s^2].
      real(wp) :: mass = 1.0_wp, length = 1.0_wp, gravity = 9.81_wp
      !> How often the constraint is stated.
      integer :: constraint_copies = 1
      !> Initial position [m] and velocity [m/s].
      real(wp) :: position(2) = [1.0_wp, 0.0_wp], velocity(2) = 0.0_wp
   contains
      procedure :: declare
      procedure :: build
   end type pendulum_group_t

contains

   !> Its entries.
   subroutine declare(self, entries)
      !> What the group says.
      class(pendulum_group_t), intent(inout) :: self
      !> What passes over them.
      type(entries_t), intent(inout) :: entries

      call entries%group('pendulum', 'a point mass on a rigid rod')
      call entries%item('mass', self%mass, 'kg', 'mass of the bob', above=0.0_wp)
      call entries%item('length', self%length, 'm', 'length of the rod', above=0.0_wp)
      call entries%item('gravity', self%gravity, 'm/s^2', 'acceleration against z')
      call entries%item('constraint_copies', self%constraint_copies, 'how often the constraint is stated', least=1)
      call entries%item('position', self%position, 'm', 'x and z of the bob at the start; the pivot is at 0, 0')
      call entries%item('velocity', self%velocity, 'm/s', 'its velocity at the start')
   end subroutine declare

   !> The pendulum and its start.
   subroutine build(self, model, start, error)
      !> What the group says.
      class(pendulum_group_t), intent(in) :: self
      !> The pendulum.
      class(tabulated_system_t), allocatable, intent(out) :: model
      !> Initial state as given.
      type(state_t), intent(out) :: start
      !> What is wrong with it.
      type(error_t), allocatable, intent(inout) :: error
      type(pendulum_t), allocatable :: own

      allocate (own)
      call new_pendulum(own, self%mass, self%length, self%gravity, self%constraint_copies, error)
      allocate (start%w(0))
      start%x = self%position
      start%v = self%velocity
      call move_alloc(own, model)
   end subroutine build

end module taut_case_pendulum
