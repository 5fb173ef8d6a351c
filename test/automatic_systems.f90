!> Systems that other suites have with all their derivatives, with phi alone: M and f are those of the systems written by hand.
module automatic_systems
   use car_axis, only: axle_length, car_axis_t, ground
   use squeezer, only: loops
   use taut, only: automatic_system_t, block_diagonal_t, jet_state_t, mechanical_system_t, state_t, wp
   use taut_jet
   use taut_model_chain, only: chain_t
   use taut_model_helicopter, only: helicopter_t
   use taut_model_n_four_bar, only: n_four_bar_t
   use taut_model_pendulum, only: pendulum_t
   implicit none (type, external)
   private
   public :: borrowed_t, without_derivatives

   !> M and f of another system.
   type, abstract, extends(automatic_system_t) :: borrowed_t
      class(mechanical_system_t), allocatable :: hand
   contains
      procedure :: mass
      procedure :: force
      procedure :: energy
   end type borrowed_t

   type, extends(borrowed_t) :: jet_pendulum_t
      real(wp) :: l
   contains
      procedure :: phi => pendulum_phi
   end type jet_pendulum_t

   type, extends(borrowed_t) :: jet_chain_t
      real(wp) :: l
   contains
      procedure :: phi => chain_phi
   end type jet_chain_t

   type, extends(borrowed_t) :: jet_four_bar_t
      real(wp) :: l
   contains
      procedure :: phi => four_bar_phi
   end type jet_four_bar_t

   type, extends(borrowed_t) :: jet_squeezer_t
   contains
      procedure :: phi => squeezer_phi
   end type jet_squeezer_t

   type, extends(borrowed_t) :: jet_car_axis_t
   contains
      procedure :: phi => car_axis_phi
   end type jet_car_axis_t

   type, extends(borrowed_t) :: jet_blade_t
      type(helicopter_t) :: blade
   contains
      procedure :: phi => blade_phi
   end type jet_blade_t

contains

   !> A system of which only M, f and phi are left.
   function without_derivatives(hand) result(model)
      class(mechanical_system_t), intent(in) :: hand
      class(borrowed_t), allocatable :: model

      select type (hand)
      type is (pendulum_t)
         model = jet_pendulum_t(l=hand%l)
      type is (chain_t)
         model = jet_chain_t(l=hand%l)
      type is (n_four_bar_t)
         model = jet_four_bar_t(l=hand%l)
      type is (helicopter_t)
         model = jet_blade_t(blade=hand)
      type is (car_axis_t)
         model = jet_car_axis_t()
      class default
         model = jet_squeezer_t()
      end select
      allocate (model%hand, source=hand)
      call model%define(n=hand%n, c=hand%c, n_x=hand%n_x, mass_blocks=hand%mass_blocks, constant_mass=hand%constant_mass)
   end function without_derivatives

   subroutine mass(self, at, m)
      class(borrowed_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m

      call self%hand%mass(at, m)
   end subroutine mass

   subroutine force(self, at, value)
      class(borrowed_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      call self%hand%force(at, value)
   end subroutine force

   function energy(self, at)
      class(borrowed_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp) :: energy

      energy = self%hand%energy(at)
   end function energy

   subroutine pendulum_phi(self, at, value)
      class(jet_pendulum_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value(:)

      value(:) = norm2(at%x) - self%l
   end subroutine pendulum_phi

   subroutine chain_phi(self, at, value)
      class(jet_chain_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value(:)
      type(jet_t), pointer, contiguous :: mass(:, :)

      mass(1:2, 1:self%c) => at%x
      value(1) = norm2(mass(:, 1))
      value(2:) = distance(mass(:, 2:), mass(:, :self%c - 1))
      value(:) = value - self%l
   end subroutine chain_phi

   subroutine four_bar_phi(self, at, value)
      class(jet_four_bar_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value(:)
      integer :: i, k

      do i = 0, (self%c - 1)/4
         k = 4*i
         value(k + 1) = distance(at%x(k + 1:k + 2), [i*self%l, 0.0_wp]) - self%l
         if (k + 1 == self%c) exit
         value(k + 2) = distance(at%x(k + 5:k + 6), at%x(k + 1:k + 2)) - self%l
         value(k + 3) = at%x(k + 3) - 0.5_wp*(at%x(k + 1) + at%x(k + 5))
         value(k + 4) = at%x(k + 4) - 0.5_wp*(at%x(k + 2) + at%x(k + 6))
      end do
   end subroutine four_bar_phi

   subroutine squeezer_phi(self, at, value)
      class(jet_squeezer_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value(:)

      call loops(at%x, value)
      associate (unused_system => self)
      end associate
   end subroutine squeezer_phi

   subroutine car_axis_phi(self, at, value)
      class(jet_car_axis_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value(:)
      type(jet_t) :: b(2)

      b = ground(at%t)
      value(1) = at%x(1)*b(1) + at%x(2)*b(2)
      value(2) = (at%x(1) - at%x(3))**2 + (at%x(2) - at%x(4))**2 - axle_length**2
      associate (unused_system => self)
      end associate
   end subroutine car_axis_phi

   subroutine blade_phi(self, at, value)
      class(jet_blade_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value(:)
      type(jet_t) :: a(3), b(3)

      associate (d => self%blade%data)
         a(1) = d%x_beta + d%x_theta*cos(at%x(1)) - d%y_theta*sin(at%x(1))*sin(at%x(2))
         a(2) = d%y_theta*cos(at%x(2))
         a(3) = d%x_theta*sin(at%x(1)) + d%y_theta*cos(at%x(1))*sin(at%x(2))
         b = d%b_mean + d%b_cosine*cos(d%omega*at%t) + d%b_sine*sin(d%omega*at%t)
         value(1) = distance(a, b) - d%length
      end associate
   end subroutine blade_phi

end module automatic_systems
