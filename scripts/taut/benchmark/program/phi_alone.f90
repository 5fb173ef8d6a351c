!> Chain and loops of which phi alone is written: what derivatives by hand are worth.
module phi_alone_systems
   use taut, only: automatic_system_t, block_diagonal_t, error_t, jet_state_t, mechanical_system_t, raise, state_t, wp
   use taut_jet
   use taut_model_chain, only: chain_t
   use taut_model_n_four_bar, only: n_four_bar_t
   implicit none (type, external)
   private
   public :: phi_alone

   !> M and f of a system by hand.
   type, abstract, extends(automatic_system_t) :: by_phi_t
      class(mechanical_system_t), allocatable :: hand
      real(wp) :: l = 0.0_wp
   contains
      procedure :: mass
      procedure :: force
   end type by_phi_t

   type, extends(by_phi_t) :: chain_by_phi_t
   contains
      procedure :: phi => chain_phi
   end type chain_by_phi_t

   type, extends(by_phi_t) :: loops_by_phi_t
   contains
      procedure :: phi => loops_phi
   end type loops_by_phi_t

contains

   !> Takes from a system all that follows from phi.
   subroutine phi_alone(at, model, error)
      !> A state of it.
      type(state_t), intent(in) :: at
      !> A chain or loops, replaced.
      class(mechanical_system_t), allocatable, intent(inout) :: model
      !> It is something else.
      type(error_t), allocatable, intent(inout) :: error
      class(by_phi_t), allocatable :: system

      select type (model)
      type is (chain_t)
         allocate (chain_by_phi_t :: system)
         system%l = model%l
      type is (n_four_bar_t)
         allocate (loops_by_phi_t :: system)
         system%l = model%l
      class default
         call raise(error, 'benchmark', 'phi alone is written for "chain" and "four-bar"', 'take one of these')
         return
      end select
      call system%define(n=model%n, c=model%c, mass_blocks=model%mass_blocks, constant_mass=.true.)
      call move_alloc(model, system%hand)
      call system%find_structure(at)
      call move_alloc(system, model)
   end subroutine phi_alone

   subroutine mass(self, at, m)
      class(by_phi_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m

      call self%hand%mass(at, m)
   end subroutine mass

   subroutine force(self, at, value)
      class(by_phi_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      call self%hand%force(at, value)
   end subroutine force

   subroutine chain_phi(self, at, value)
      class(chain_by_phi_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value(:)
      type(jet_t), pointer, contiguous :: mass(:, :)

      mass(1:2, 1:self%c) => at%x
      value(1) = norm2(mass(:, 1))
      value(2:) = distance(mass(:, 2:), mass(:, :self%c - 1))
      value(:) = value - self%l
   end subroutine chain_phi

   subroutine loops_phi(self, at, value)
      class(loops_by_phi_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value(:)
      integer :: i, k

      ! Tips of the cranks, and between two of them the center of a coupler.
      do i = 0, (self%c - 1)/4
         k = 4*i
         value(k + 1) = distance(at%x(k + 1:k + 2), [i*self%l, 0.0_wp]) - self%l
         if (k + 1 == self%c) exit
         value(k + 2) = distance(at%x(k + 5:k + 6), at%x(k + 1:k + 2)) - self%l
         value(k + 3:k + 4) = at%x(k + 3:k + 4) - 0.5_wp*(at%x(k + 1:k + 2) + at%x(k + 5:k + 6))
      end do
   end subroutine loops_phi

end module phi_alone_systems
