!> A chain of n links hangs between two pins, in the angles of its links: M(x), V(x) and phi(x), and not one derivative.
module hanging_chain_system
   use taut
   implicit none (type, external)
   type, extends(automatic_system_t) :: hanging_chain_t
      real(wp) :: m = 0.1_wp, l = 0.2_wp, g = 9.81_wp, span = 0.0_wp   ! of a link [kg], [m]; [m/s^2]; pin to pin [m]
   contains
      procedure :: masses, potential, phi
   end type hanging_chain_t
contains
   subroutine masses(self, at, m)                  ! a mass at the end of each link: T = v^T M v/2
      class(hanging_chain_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(inout) :: m(:, :)
      integer :: i, j
      do concurrent(i=1:self%n, j=1:self%n)
         m(i, j) = self%m*self%l**2*(self%n + 1 - max(i, j))*cos(at%x(i) - at%x(j))
      end do
   end subroutine masses
   subroutine potential(self, at, value)           ! V
      class(hanging_chain_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value
      integer :: i
      value = self%m*self%g*self%l*dot_product([(real(self%n + 1 - i, wp), i=1, self%n)], sin(at%x))
   end subroutine potential
   subroutine phi(self, at, value)                 ! the end of the last link is at its pin
      class(hanging_chain_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value(:)
      value = [self%l*sum(cos(at%x)) - self%span, self%l*sum(sin(at%x))]
   end subroutine phi
end module hanging_chain_system

program hanging_chain
   use taut
   use hanging_chain_system
   implicit none (type, external)
   type(hanging_chain_t) :: chain
   type(state_t) :: at
   type(start_report_t) :: start
   type(integration_result_t) :: result
   type(error_t), allocatable :: error
   real(wp) :: energy, violation(2)
   integer :: i, n
   do n = 5, 20, 15
      call chain%define(n=n, c=2)
      chain%span = 0.6_wp*n*chain%l
      at%t = 0.0_wp
      at%x = [(-1.2_wp + 2.5_wp*(i - 1)/(n - 1), i=1, n)]             ! nearly between the pins
      at%v = 0.0_wp*at%x
      call consistent_start(chain, method_t(), at, start, error)      ! now it is
      energy = chain%energy(at)
      call simulate(chain, at, 30.0_wp, result, error)
      if (allocated(error)) error stop 1
      call chain%constraint(at, violation)
      print '(i3, 3a, i0, 2(a, es8.1))', n, ' links, ', status_name(result%status), ': ', result%steps, ' steps, phi ', &
         maxval(abs(violation)), ', energy off by ', chain%energy(at)/energy - 1.0_wp
   end do
end program hanging_chain
