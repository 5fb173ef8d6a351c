!> Problems of textbooks, written from phi, or A v - b', alone, against their closed forms.
module test_textbook
   use taut, only: automatic_system_t, block_diagonal_t, error_t, integration_options_t, integration_result_t, jet_state_t, jet_t, &
                   operator(*), operator(+), operator(-), cos, hypot, sin, simulate, state_t, status_event, wp
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_textbook

   real(wp), parameter :: g = 9.81_wp

   !> A sleigh on a plane: {x, y, angle} of the blade, center of mass ahead of it.
   type, extends(automatic_system_t) :: sleigh_t
      real(wp) :: m = 2.0_wp, inertia = 0.5_wp, ahead = 0.3_wp
   contains
      procedure :: masses => sleigh_masses
      procedure :: nonholonomic => sleigh_blade
   end type sleigh_t

   !> A rope over two small pulleys at {0, 0} and {0.5, 0}, a mass at each end: {x1, z1, x2, z2}.
   type, extends(automatic_system_t) :: rope_t
      real(wp) :: length = 3.0_wp
   contains
      procedure :: potential => rope_potential
      procedure :: phi => rope_phi
      procedure :: reaction_event_values => rope_pull
   end type rope_t

   !> An ellipse that rolls on a line, upright: {x, y, angle} of its center.
   type, extends(automatic_system_t) :: ellipse_t
      real(wp) :: a = 0.4_wp, b = 0.25_wp
   contains
      procedure :: potential => ellipse_potential
      procedure :: phi => ellipse_phi
      procedure :: nonholonomic => ellipse_rolls
   end type ellipse_t

   !> A mass on a parabola by the place on it, a parameter without mass: {x, s}, s = x^2; M + A^T A and f + A^T b'' in the place of
   !! M, which is singular, and f.
   type, extends(automatic_system_t) :: parameter_t
      real(wp) :: m = 2.0_wp, push = 3.0_wp
   contains
      procedure :: phi => parameter_phi
      procedure :: mass => parameter_mass
      procedure :: force => parameter_force
   end type parameter_t

contains

   !> All tests of this module.
   function collect_textbook() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('Chaplygin''s sleigh', chaplygin), &
               new_test('a rope over two pulleys', two_pulleys), &
               new_test('a rope over two pulleys goes slack', slack_rope), &
               new_test('an ellipse rolls to and fro', rolls), &
               new_test('a parameter without mass', massless)]
   end function collect_textbook

   !> T = m (vc . vc)/2 + inertia omega^2/2 with vc that of the center of mass.
   subroutine sleigh_masses(self, at, m)
      class(sleigh_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(inout) :: m(:, :)

      m(1, 1) = self%m + 0.0_wp*at%x(1)
      m(2, 2) = self%m + 0.0_wp*at%x(1)
      m(1, 2) = 0.0_wp*at%x(1)
      m(2, 1) = m(1, 2)
      m(1, 3) = -self%m*self%ahead*sin(at%x(3))
      m(3, 1) = m(1, 3)
      m(2, 3) = self%m*self%ahead*cos(at%x(3))
      m(3, 2) = m(2, 3)
      m(3, 3) = self%inertia + self%m*self%ahead**2 + 0.0_wp*at%x(1)
   end subroutine sleigh_masses

   subroutine sleigh_blade(self, at, value)
      class(sleigh_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value(:)

      value(1) = -1.0_wp*sin(at%x(3))*at%v(1) + cos(at%x(3))*at%v(2)
      associate (unused_system => self)
      end associate
   end subroutine sleigh_blade

   !> vdot = ahead omega^2, omegadot = -q v omega with q = m ahead/(inertia + m ahead^2): from v = 0 on, v = c tanh(q c t) and
   !! omega = omega0/cosh(q c t), c = omega0 sqrt(ahead/q).
   subroutine chaplygin(failure)
      character(:), allocatable, intent(inout) :: failure
      type(sleigh_t) :: system
      type(state_t) :: at
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      real(wp) :: c, q
      real(wp), parameter :: omega = 3.0_wp, t_end = 1.5_wp

      call system%define(n=3, c=1, nonholonomic=1)
      at = state_t(x=[0.0_wp, 0.0_wp, 0.4_wp], v=[0.0_wp, 0.0_wp, omega])
      call simulate(system, at, t_end, result, error, options=integration_options_t(rtol=1.0e-10_wp))
      call no_error(failure, error)
      if (allocated(failure)) return
      q = system%m*system%ahead/(system%inertia + system%m*system%ahead**2)
      c = omega*sqrt(system%ahead/q)
      call check_close(failure, at%v(3), omega/cosh(q*c*t_end), 1.0e-8_wp, 'rate')
      call check_close(failure, at%v(1)*cos(at%x(3)) + at%v(2)*sin(at%x(3)), c*tanh(q*c*t_end), 1.0e-8_wp, 'speed')
      call check_below(failure, at%v(2)*cos(at%x(3)) - at%v(1)*sin(at%x(3)), 1.0e-12_wp, 'across the blade')
   end subroutine chaplygin

   subroutine rope_potential(self, at, value)
      class(rope_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value

      value = g*(self%diagonal_mass(2)*at%x(2) + self%diagonal_mass(4)*at%x(4))
   end subroutine rope_potential

   subroutine rope_phi(self, at, value)
      class(rope_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value(:)

      value(1) = hypot(at%x(1), at%x(2)) + 0.5_wp + hypot(at%x(3) - 0.5_wp, at%x(4)) - self%length
   end subroutine rope_phi

   subroutine rope_pull(self, at, lambda, values)
      class(rope_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: lambda(:)
      real(wp), intent(out) :: values(:)

      values = lambda(1) + 0.0_wp*at%t*self%n
   end subroutine rope_pull

   subroutine hang(system, at)
      type(rope_t), intent(out) :: system
      type(state_t), intent(out) :: at

      call system%define(n=4, c=1, mass_blocks=[1, 1, 1, 1])
      system%diagonal_mass = [1.0_wp, 1.0_wp, 1.5_wp, 1.5_wp]
      at%x = [0.0_wp, -1.5_wp, 0.5_wp, -1.0_wp]
      at%v = [0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
   end subroutine hang

   !> Atwood's machine: the heavier goes down with g/5.
   subroutine two_pulleys(failure)
      character(:), allocatable, intent(inout) :: failure
      type(rope_t) :: system
      type(state_t) :: at
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      real(wp), parameter :: t_end = 0.8_wp

      call hang(system, at)
      call simulate(system, at, t_end, result, error)
      call no_error(failure, error)
      call check_close(failure, at%x(4), -1.0_wp - 0.1_wp*g*t_end**2, 1.0e-9_wp, 'the heavier')
      call check_close(failure, at%x(2), -1.5_wp + 0.1_wp*g*t_end**2, 1.0e-9_wp, 'the lighter')
   end subroutine two_pulleys

   !> Both masses swing up beside their pulleys.
   subroutine slack_rope(failure)
      character(:), allocatable, intent(inout) :: failure
      type(rope_t) :: system
      type(state_t) :: at
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      real(wp) :: along(2), r, pull

      call hang(system, at)
      system%n_events = 1
      system%events_see_reactions = .true.
      system%event_direction = [-1]
      system%event_terminal = [.true.]
      at%x = [-1.5_wp, 0.0_wp, 1.5_wp, 0.0_wp]
      at%v = [0.0_wp, 3.0_wp, 0.0_wp, 3.0_wp]
      call simulate(system, at, 5.0_wp, result, error, options=integration_options_t(rtol=1.0e-10_wp))
      call no_error(failure, error)
      call check(failure, result%status == status_event, 'it does not go slack')
      if (allocated(failure)) return
      ! Nothing but weights then: the rope shortens on one side as fast as it lengthens on the other, rdd1 + rdd2 = 0.
      r = norm2(at%x(1:2))
      along = at%x(1:2)/r
      pull = (dot_product(at%v(1:2), at%v(1:2)) - dot_product(along, at%v(1:2))**2)/r - g*along(2)
      r = norm2(at%x(3:4) - [0.5_wp, 0.0_wp])
      along = (at%x(3:4) - [0.5_wp, 0.0_wp])/r
      pull = pull + (dot_product(at%v(3:4), at%v(3:4)) - dot_product(along, at%v(3:4))**2)/r - g*along(2)
      call check_below(failure, pull, 1.0e-6_wp, 'what the rope would have to do')
   end subroutine slack_rope

   subroutine ellipse_potential(self, at, value)
      class(ellipse_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value

      value = g*self%diagonal_mass(2)*at%x(2)
   end subroutine ellipse_potential

   !> The height of the center above its tangent.
   subroutine ellipse_phi(self, at, value)
      class(ellipse_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value(:)

      value(1) = at%x(2) - hypot(self%a*sin(at%x(3)), self%b*cos(at%x(3)))
   end subroutine ellipse_phi

   !> The point that touches rests: it lies d/dangle of the height ahead, and the height below.
   subroutine ellipse_rolls(self, at, value)
      class(ellipse_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value(:)

      value(1) = at%v(1) + hypot(self%a*sin(at%x(3)), self%b*cos(at%x(3)))*at%v(3)
   end subroutine ellipse_rolls

   !> Its energy stays, and its way is the arc: x + integral of the height over the angle = 0.
   subroutine rolls(failure)
      character(:), allocatable, intent(inout) :: failure
      type(ellipse_t) :: system
      type(state_t) :: at
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      real(wp) :: angle, energy, way
      integer :: i
      integer, parameter :: parts = 2000

      call system%define(n=3, c=2, nonholonomic=1, mass_blocks=[1, 1, 1])
      system%diagonal_mass = [3.0_wp, 3.0_wp, 0.1_wp]
      at = state_t(x=[0.0_wp, 0.0_wp, 0.3_wp], v=[0.0_wp, 0.0_wp, 0.0_wp])
      at%x(2) = hypot(system%a*sin(0.3_wp), system%b*cos(0.3_wp))
      energy = system%energy(at)
      call simulate(system, at, 3.0_wp, result, error, options=integration_options_t(rtol=1.0e-10_wp))
      call no_error(failure, error)
      if (allocated(failure)) return
      call check_close(failure, system%energy(at), energy, 1.0e-7_wp, 'energy')
      way = 0.0_wp
      do i = 1, parts
         angle = 0.3_wp + (at%x(3) - 0.3_wp)*(i - 0.5_wp)/parts
         way = way + hypot(system%a*sin(angle), system%b*cos(angle))*(at%x(3) - 0.3_wp)/parts
      end do
      call check_below(failure, at%x(1) + way, 1.0e-6_wp, 'way')
      call check(failure, abs(at%x(3)) <= 0.3_wp + 1.0e-6_wp, 'it rocks farther than where it was let go')
   end subroutine rolls

   subroutine parameter_phi(self, at, value)
      class(parameter_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value(:)

      value(1) = at%x(2) - at%x(1)*at%x(1)
      associate (unused_system => self)
      end associate
   end subroutine parameter_phi

   subroutine parameter_mass(self, at, m)
      class(parameter_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m
      real(wp) :: a(1, 2), whole(2, 2)

      call self%jacobian(at, a)
      whole = matmul(transpose(a), a)
      whole(1, 1) = whole(1, 1) + self%m
      call m%set_dense(whole)
   end subroutine parameter_mass

   subroutine parameter_force(self, at, value)
      class(parameter_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      real(wp) :: a(1, 2), b_second(1)

      call self%jacobian(at, a)
      call self%acceleration_rhs(at, b_second)
      value = matmul(b_second, a)
      value(1) = value(1) + self%push
   end subroutine parameter_force

   !> The mass moves as if there were no parameter.
   subroutine massless(failure)
      character(:), allocatable, intent(inout) :: failure
      type(parameter_t) :: system
      type(state_t) :: at
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      real(wp), parameter :: x = 0.5_wp, v = -1.0_wp, t_end = 2.0_wp

      call system%define(n=2, c=1)
      at = state_t(x=[x, x**2], v=[v, 2.0_wp*x*v])
      call simulate(system, at, t_end, result, error, options=integration_options_t(rtol=1.0e-10_wp))
      call no_error(failure, error)
      call check_close(failure, at%x(1), x + v*t_end + 0.5_wp*system%push/system%m*t_end**2, 1.0e-8_wp, 'the mass')
      call check_below(failure, at%x(2) - at%x(1)**2, 1.0e-12_wp, 'the parameter')
   end subroutine massless

end module test_textbook
