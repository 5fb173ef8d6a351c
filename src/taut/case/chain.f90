!> Case files of the chain.
module taut_case_chain
   use taut_kinds, only: wp
   use taut_error, only: error_t
   use taut_case_entries, only: entries_t
   use taut_case_model_group, only: model_group_t
   use taut_constrained_system, only: state_t
   use taut_constrained_system_tables, only: tabulated_system_t
   use taut_model_chain, only: chain_t, new_chain
   implicit none (type, external)
   private
   public :: chain_group_t

   real(wp), parameter :: degree = acos(-1.0_wp)/180.0_wp

   !> &chain.
   type, extends(model_group_t) :: chain_group_t
      !> Number of rods.
      integer :: rods = 10
      !> Mass of each point [kg], length of each rod [m], gravity [m/s^2].
      real(wp) :: mass = 1.0_wp, length = 1.0_wp, gravity = 9.81_wp
      !> Angle below the horizontal at the start [degrees].
      real(wp) :: angle = 0.0_wp
   contains
      procedure :: declare
      procedure :: build
   end type chain_group_t

contains

   !> Its entries.
   subroutine declare(self, entries)
      !> What the group says.
      class(chain_group_t), intent(inout) :: self
      !> What passes over them.
      type(entries_t), intent(inout) :: entries

      call entries%group('chain', 'rods and point masses in a row, hung at one end; straight and at rest at the start')
      call entries%item('rods', self%rods, 'number of rods', least=1)
      call entries%item('mass', self%mass, 'kg', 'mass of each point', above=0.0_wp)
      call entries%item('length', self%length, 'm', 'length of each rod', above=0.0_wp)
      call entries%item('gravity', self%gravity, 'm/s^2', 'acceleration downwards')
      call entries%item('angle', self%angle, 'degrees', 'angle below the horizontal at the start', least=-360.0_wp, most=360.0_wp)
   end subroutine declare

   !> The chain and its start.
   subroutine build(self, model, start, error)
      !> What the group says.
      class(chain_group_t), intent(in) :: self
      !> The chain.
      class(tabulated_system_t), allocatable, intent(out) :: model
      !> Initial state: straight, at rest.
      type(state_t), intent(out) :: start
      !> What is wrong with it.
      type(error_t), allocatable, intent(inout) :: error
      type(chain_t), allocatable :: own

      allocate (own)
      call new_chain(own, self%rods, self%mass, self%length, self%gravity, error)
      if (allocated(error)) return
      call own%start(self%angle*degree, start)
      call move_alloc(own, model)
   end subroutine build

end module taut_case_chain
