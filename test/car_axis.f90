!> The car axis: two wheels on stiff springs, joined by an axle, the right one on a bumpy road; a constraint that depends on time.
!!
!! Source: F. Mazzia, C. Magherini, Test set for initial value problem solvers, release 2.4, Bari 2008; equations and reference
!! values from there. Lengths in m, x = {xl, yl, xr, yr}.
module car_axis
   use taut, only: block_diagonal_t, mechanical_system_t, state_t, wp
   use taut_jet
   implicit none (type, external)
   private
   public :: car_axis_t, new_car_axis, car_axis_start, axle_length, ground, end_of_axle

   real(wp), parameter :: axle_length = 1.0_wp, l0 = 0.5_wp, half_mass = 0.5_wp*1.0e-4_wp*10.0_wp, bump = 0.1_wp, omega = 10.0_wp
   !> Published positions and velocities at 3 s.
   real(wp), parameter :: end_of_axle(8) = [0.493455784275402809e-1_wp, 0.496989460230171153_wp, 0.104174252488542151e1_wp, &
                                            0.373911027265361256_wp, -0.770583684040972357e-1_wp, 0.744686658723778553e-2_wp, &
                                            0.175568157537232222e-1_wp, 0.770341043779251976_wp]

   !> The axis.
   type, extends(mechanical_system_t) :: car_axis_t
   contains
      procedure :: mass
      procedure :: force
      procedure :: constraint
      procedure :: jacobian
      procedure :: velocity_rhs
      procedure :: acceleration_rhs
   end type car_axis_t

contains

   !> The axis with its sizes.
   function new_car_axis() result(self)
      type(car_axis_t) :: self

      call self%define(n=4, c=2, mass_blocks=[1, 1, 1, 1])
   end function new_car_axis

   !> The published start.
   function car_axis_start() result(at)
      type(state_t) :: at

      at%x = [0.0_wp, 0.5_wp, 1.0_wp, 0.5_wp]
      at%v = [-0.5_wp, 0.0_wp, -0.5_wp, 0.0_wp]
      allocate (at%w(0))
   end function car_axis_start

   !> The road under the right wheel, with its rates.
   pure subroutine road(t, b, rate, second)
      real(wp), intent(in) :: t
      real(wp), intent(out) :: b(2), rate(2), second(2)

      b(2) = bump*sin(omega*t)
      rate(2) = bump*omega*cos(omega*t)
      second(2) = -omega**2*b(2)
      b(1) = sqrt(axle_length**2 - b(2)**2)
      rate(1) = -b(2)*rate(2)/b(1)
      second(1) = -(rate(2)**2 + b(2)*second(2) + rate(1)**2)/b(1)
   end subroutine road

   !> The road, without.
   pure function ground(t) result(b)
      type(jet_t), intent(in) :: t
      type(jet_t) :: b(2)

      b(2) = bump*sin(omega*t)
      b(1) = sqrt(axle_length**2 - b(2)**2)
   end function ground

   !> M.
   subroutine mass(self, at, m)
      class(car_axis_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m

      m%values(:) = half_mass
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine mass

   !> f: the springs and the weight.
   subroutine force(self, at, value)
      class(car_axis_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      real(wp) :: b(2), left, rate(2), right, second(2)

      call road(at%t, b, rate, second)
      associate (x => at%x)
         left = sqrt(x(1)**2 + x(2)**2)
         right = sqrt((x(3) - b(1))**2 + (x(4) - b(2))**2)
         value(1) = (l0 - left)*x(1)/left
         value(2) = (l0 - left)*x(2)/left - half_mass
         value(3) = (l0 - right)*(x(3) - b(1))/right
         value(4) = (l0 - right)*(x(4) - b(2))/right - half_mass
      end associate
      associate (unused_system => self)
      end associate
   end subroutine force

   !> phi: the left wheel is across the road's direction, and the axle keeps its length [m^2].
   subroutine constraint(self, at, value)
      class(car_axis_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      real(wp) :: b(2), rate(2), second(2)

      call road(at%t, b, rate, second)
      associate (x => at%x)
         value(1) = x(1)*b(1) + x(2)*b(2)
         value(2) = (x(1) - x(3))**2 + (x(2) - x(4))**2 - axle_length**2
      end associate
      associate (unused_system => self)
      end associate
   end subroutine constraint

   !> A.
   subroutine jacobian(self, at, a)
      class(car_axis_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)
      real(wp) :: b(2), rate(2), second(2)

      call road(at%t, b, rate, second)
      a(1, 1:2) = b
      a(1, 3:4) = 0.0_wp
      a(2, 1) = 2.0_wp*(at%x(1) - at%x(3))
      a(2, 2) = 2.0_wp*(at%x(2) - at%x(4))
      a(2, 3:4) = -a(2, 1:2)
      associate (unused_system => self)
      end associate
   end subroutine jacobian

   !> b'.
   subroutine velocity_rhs(self, at, value)
      class(car_axis_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      real(wp) :: b(2), rate(2), second(2)

      call road(at%t, b, rate, second)
      value(1) = -at%x(1)*rate(1) - at%x(2)*rate(2)
      value(2) = 0.0_wp
      associate (unused_system => self)
      end associate
   end subroutine velocity_rhs

   !> b''.
   subroutine acceleration_rhs(self, at, value)
      class(car_axis_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      real(wp) :: b(2), rate(2), second(2)

      call road(at%t, b, rate, second)
      associate (x => at%x, v => at%v)
         value(1) = -2.0_wp*(v(1)*rate(1) + v(2)*rate(2)) - x(1)*second(1) - x(2)*second(2)
         value(2) = -2.0_wp*((v(1) - v(3))**2 + (v(2) - v(4))**2)
      end associate
      associate (unused_system => self)
      end associate
   end subroutine acceleration_rhs

end module car_axis
