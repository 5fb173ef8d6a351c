!> Right systems of kinds that a checker may take for wrong.
module edge_systems
   use taut, only: block_diagonal_t, mechanical_system_t, state_t, wp
   implicit none (type, external)
   private
   public :: servo_t, turntable_t, sized_t

   !> A pendulum on a cart whose position is a state that is not mechanics: phi = x - w.
   type, extends(mechanical_system_t) :: servo_t
   contains
      procedure :: mass => servo_mass
      procedure :: force => servo_force
      procedure :: constraint => servo_constraint
      procedure :: jacobian => servo_jacobian
      procedure :: velocity_rhs => servo_rate
      procedure :: acceleration_rhs => servo_acceleration
      procedure :: w_rate => servo_rate
   end type servo_t

   !> A ball on a turntable: five velocities, two coordinates, and rows that are not holonomic.
   type, extends(mechanical_system_t) :: turntable_t
      real(wp) :: a = 0.1_wp, omega = 2.0_wp
   contains
      procedure :: mass => table_mass
      procedure :: force => table_force
      procedure :: jacobian => table_jacobian
      procedure :: velocity_rhs => table_velocity_rhs
      procedure :: acceleration_rhs => table_acceleration_rhs
      procedure :: x_rate => table_x_rate
      procedure :: v_of_x_rate => table_v_of_x_rate
      procedure :: displace => table_displace
   end type turntable_t

   !> A pendulum as large as an atom or an orbit, phi = (x^2 + y^2 - l^2)/2 [m^2].
   type, extends(mechanical_system_t) :: sized_t
      real(wp) :: l = 1.0_wp
   contains
      procedure :: mass => sized_mass
      procedure :: force => sized_force
      procedure :: constraint => sized_constraint
      procedure :: jacobian => sized_jacobian
      procedure :: acceleration_rhs => sized_acceleration
   end type sized_t

contains

   subroutine servo_mass(self, at, m)
      class(servo_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m

      call m%set_dense(reshape([2.0_wp, cos(at%x(2)), cos(at%x(2)), 1.0_wp], [2, 2]))
      associate (unused => self)
      end associate
   end subroutine servo_mass

   subroutine servo_force(self, at, value)
      class(servo_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = [sin(at%x(2))*at%v(2)**2, -9.81_wp*sin(at%x(2))]
      associate (unused => self)
      end associate
   end subroutine servo_force

   subroutine servo_constraint(self, at, value)
      class(servo_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(1) = at%x(1) - at%w(1)
      associate (unused => self)
      end associate
   end subroutine servo_constraint

   subroutine servo_jacobian(self, at, a)
      class(servo_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)

      a(1, :) = [1.0_wp, 0.0_wp]
      associate (unused => self, unused_state => at)
      end associate
   end subroutine servo_jacobian

   !> wdot: towards what is asked for, which sees the angle.
   subroutine servo_rate(self, at, value)
      class(servo_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(1) = 10.0_wp*(0.2_wp*sin(3.0_wp*at%t) + 0.5_wp*sin(at%x(2)) - at%w(1))
      associate (unused => self)
      end associate
   end subroutine servo_rate

   subroutine servo_acceleration(self, at, value)
      class(servo_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      real(wp) :: rate(1)

      call self%w_rate(at, rate)
      value(1) = 10.0_wp*(0.6_wp*cos(3.0_wp*at%t) + 0.5_wp*cos(at%x(2))*at%v(2) - rate(1))
   end subroutine servo_acceleration

   subroutine table_mass(self, at, m)
      class(turntable_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m

      call m%set_diagonal([1.0_wp, 1.0_wp, 0.4_wp*self%a**2, 0.4_wp*self%a**2, 0.4_wp*self%a**2])
      associate (unused => at)
      end associate
   end subroutine table_mass

   subroutine table_force(self, at, value)
      class(turntable_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = 0.0_wp
      associate (unused => self, unused_state => at)
      end associate
   end subroutine table_force

   subroutine table_jacobian(self, at, a)
      class(turntable_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)

      a(1, :) = [1.0_wp, 0.0_wp, 0.0_wp, -self%a, 0.0_wp]
      a(2, :) = [0.0_wp, 1.0_wp, self%a, 0.0_wp, 0.0_wp]
      associate (unused => at)
      end associate
   end subroutine table_jacobian

   subroutine table_velocity_rhs(self, at, value)
      class(turntable_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = self%omega*[-at%x(2), at%x(1)]
   end subroutine table_velocity_rhs

   subroutine table_acceleration_rhs(self, at, value)
      class(turntable_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = self%omega*[-at%v(2), at%v(1)]
   end subroutine table_acceleration_rhs

   subroutine table_x_rate(self, at, u, value)
      class(turntable_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: u(:)
      real(wp), intent(out) :: value(:)

      value = u(1:2)
      associate (unused => self, unused_state => at)
      end associate
   end subroutine table_x_rate

   subroutine table_v_of_x_rate(self, at, rate, u)
      class(turntable_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: rate(:)
      real(wp), intent(out) :: u(:)

      u = 0.0_wp
      u(1:2) = rate
      associate (unused => self, unused_state => at)
      end associate
   end subroutine table_v_of_x_rate

   subroutine table_displace(self, d, x)
      class(turntable_t), intent(in) :: self
      real(wp), intent(in) :: d(:)
      real(wp), intent(inout) :: x(:)

      x = x + d(1:2)
      associate (unused => self)
      end associate
   end subroutine table_displace

   subroutine sized_mass(self, at, m)
      class(sized_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m

      call m%set_diagonal([1.0_wp, 1.0_wp])
      associate (unused => self, unused_state => at)
      end associate
   end subroutine sized_mass

   subroutine sized_force(self, at, value)
      class(sized_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = [0.0_wp, -9.81_wp*self%l]
      associate (unused_state => at)
      end associate
   end subroutine sized_force

   subroutine sized_constraint(self, at, value)
      class(sized_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(1) = 0.5_wp*(sum(at%x**2) - self%l**2)
   end subroutine sized_constraint

   subroutine sized_jacobian(self, at, a)
      class(sized_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)

      a(1, :) = at%x
      associate (unused => self)
      end associate
   end subroutine sized_jacobian

   subroutine sized_acceleration(self, at, value)
      class(sized_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(1) = -sum(at%v**2)
      associate (unused => self)
      end associate
   end subroutine sized_acceleration

end module edge_systems
