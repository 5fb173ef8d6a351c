!> What simulate sees at a start where rows of A depend on each other: the smallest systems of each kind.
module test_first_look
   use taut, only: block_diagonal_t, error_t, integration_result_t, mechanical_system_t, method_t, simulate, state_t, wp
   use testing, only: check, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_first_look

   !> Masses of one, and no force.
   type, abstract, extends(mechanical_system_t) :: forceless_t
   contains
      procedure :: mass => unit_masses
      procedure :: force => no_force
      procedure :: acceleration_rhs => no_force
   end type forceless_t

   !> y = 0 and y = x^2, which touch at the origin.
   type, extends(forceless_t) :: touching_t
   contains
      procedure :: constraint => touching_phi
      procedure :: jacobian => touching_a
      procedure :: acceleration_rhs => touching_b
   end type touching_t

   !> A disc whose attitude is (cos, sin), with the length of that as a constraint: no angular velocity changes it.
   type, extends(forceless_t) :: disc_t
   contains
      procedure :: constraint => disc_phi
      procedure :: jacobian => disc_a
      procedure :: x_rate => disc_rate
      procedure :: v_of_x_rate => disc_velocity
      procedure :: displace => disc_displace
   end type disc_t

contains

   !> All tests of this module.
   function collect_first_look() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('velocities that are allowed to first order only', first_order), &
               new_test('a row that no velocity changes', row_of_zeros)]
   end function collect_first_look

   subroutine first_order(failure)
      character(:), allocatable, intent(inout) :: failure
      type(touching_t) :: system
      type(state_t) :: at
      type(integration_result_t) :: result
      type(error_t), allocatable :: error

      call system%define(n=2, c=2)
      at = state_t(x=[0.0_wp, 0.0_wp], v=[1.0_wp, 0.0_wp])
      call simulate(system, at, 1.0_wp, result, error)
      call check(failure, allocated(error), 'it is seen')
      if (allocated(failure)) return
      call check(failure, index(error%line(), 'first order only: constraint') > 0, error%line())
      ! The remedy: at rest it stays where it is.
      deallocate (error)
      at%v = 0.0_wp
      call simulate(system, at, 1.0_wp, result, error)
      call no_error(failure, error)
   end subroutine first_order

   subroutine row_of_zeros(failure)
      character(:), allocatable, intent(inout) :: failure
      type(disc_t) :: system
      type(state_t) :: at
      type(integration_result_t) :: result
      type(error_t), allocatable :: error

      call system%define(n=1, c=1, n_x=2)
      at = state_t(x=[1.0_wp, 0.0_wp], v=[1.0_wp])
      call simulate(system, at, 1.0_wp, result, error)
      call check(failure, allocated(error), 'it is seen')
      if (allocated(failure)) return
      call check(failure, index(error%line(), 'no velocity changes constraint 1') > 0, error%line())
      ! The remedy: without it.
      deallocate (error)
      call system%define(n=1, c=0, n_x=2)
      call simulate(system, at, 1.0_wp, result, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      call check_close(failure, at%x(2), sin(1.0_wp), 1.0e-3_wp, 'it turns')
   end subroutine row_of_zeros

   subroutine unit_masses(self, at, m)
      class(forceless_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m

      associate (unused => at)
      end associate
      call m%set_diagonal(spread(1.0_wp, 1, self%n))
   end subroutine unit_masses

   subroutine no_force(self, at, value)
      class(forceless_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      associate (unused_system => self, unused => at)
      end associate
      value = 0.0_wp
   end subroutine no_force

   subroutine touching_phi(self, at, value)
      class(touching_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      associate (unused_system => self)
      end associate
      value = [at%x(2), at%x(2) - at%x(1)**2]
   end subroutine touching_phi

   subroutine touching_a(self, at, a)
      class(touching_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)

      associate (unused_system => self)
      end associate
      a(1, :) = [0.0_wp, 1.0_wp]
      a(2, :) = [-2.0_wp*at%x(1), 1.0_wp]
   end subroutine touching_a

   subroutine touching_b(self, at, value)
      class(touching_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      associate (unused_system => self)
      end associate
      value = [0.0_wp, 2.0_wp*at%v(1)**2]
   end subroutine touching_b

   subroutine disc_phi(self, at, value)
      class(disc_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      associate (unused_system => self)
      end associate
      value = sum(at%x**2) - 1.0_wp
   end subroutine disc_phi

   subroutine disc_a(self, at, a)
      class(disc_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)

      associate (unused_system => self, unused => at)
      end associate
      a = 0.0_wp
   end subroutine disc_a

   subroutine disc_rate(self, at, u, value)
      class(disc_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: u(:)
      real(wp), intent(out) :: value(:)

      associate (unused_system => self)
      end associate
      value = u(1)*[-at%x(2), at%x(1)]
   end subroutine disc_rate

   subroutine disc_velocity(self, at, rate, u)
      class(disc_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: rate(:)
      real(wp), intent(out) :: u(:)

      associate (unused_system => self)
      end associate
      u = at%x(1)*rate(2) - at%x(2)*rate(1)
   end subroutine disc_velocity

   subroutine disc_displace(self, d, x)
      class(disc_t), intent(in) :: self
      real(wp), intent(in) :: d(:)
      real(wp), intent(inout) :: x(:)

      associate (unused_system => self)
      end associate
      x = x + d(1)*[-x(2), x(1)]
   end subroutine disc_displace

end module test_first_look
