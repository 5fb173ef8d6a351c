!> Small constrained systems with known motions, written as a user would write them: with the façade alone.
module systems
   use taut, only: block_diagonal_t, mechanical_system_t, state_t, wp
   implicit none (type, external)
   private
   public :: particle_t, bead, sleigh, sleigh_in_space, two_rods, driven_pivot, actuator, jumping_load
   public :: coupler_t, new_coupler, compound_t, new_compound, new_particle

   !> Kinds of particle.
   integer, parameter :: bead = 1, sleigh = 2, sleigh_in_space = 3, two_rods = 4, driven_pivot = 5, actuator = 6, &
                         jumping_load = 7

   !> Point masses and the like, by kind.
   !!
   !! `bead`: on a straight wire that turns at `rate`; x = {x, y}. `sleigh`: a knife edge on an inclined plane;
   !! x = {x, y, angle}; `sleigh_in_space` has a height too, held by a holonomic constraint. `two_rods`: one point, two
   !! rods of lengths 1 and `ratio` from the same pivot. `driven_pivot`: a pendulum whose pivot moves as
   !! {0, amplitude sin(rate t)}. `actuator`: a free mass pushed by w, w' = -w. `jumping_load`: a pendulum with a
   !! horizontal force that jumps at t = `ratio`.
   type, extends(mechanical_system_t) :: particle_t
      integer :: kind = bead
      real(wp) :: rate = 1.0_wp, ratio = 1.0_wp, amplitude = 0.0_wp, g = 9.81_wp, m = 1.0_wp
      logical :: declares_breakpoint = .true.
   contains
      procedure :: mass => particle_mass
      procedure :: force => particle_force
      procedure :: constraint => particle_constraint
      procedure :: jacobian => particle_jacobian
      procedure :: velocity_rhs => particle_velocity_rhs
      procedure :: acceleration_rhs => particle_acceleration_rhs
      procedure :: w_rate => particle_w_rate
      procedure :: breakpoints => particle_breakpoints
      procedure :: weight => particle_weight
   end type particle_t

   !> A rigid coupler on parallel cranks of one length; x = {x, y, angle}. More than two cranks are redundant where the
   !! coupler is level, and only there.
   type, extends(mechanical_system_t) :: coupler_t
      integer :: cranks = 3
      real(wp) :: l = 1.0_wp, g = 9.81_wp, m = 2.0_wp, inertia = 0.7_wp
   contains
      procedure :: mass => coupler_mass
      procedure :: force => coupler_force
      procedure :: constraint => coupler_constraint
      procedure :: jacobian => coupler_jacobian
      procedure :: acceleration_rhs => coupler_acceleration_rhs
   end type coupler_t

   !> A compound pendulum whose angle is stored as cosine and sine: n_x = 4 coordinates {x, z, c, s}, n = 3 velocities.
   type, extends(mechanical_system_t) :: compound_t
      real(wp) :: m = 2.0_wp, inertia = 0.6_wp, arm = 0.5_wp, g = 9.81_wp
   contains
      procedure :: mass => compound_mass
      procedure :: force => compound_force
      procedure :: constraint => compound_constraint
      procedure :: jacobian => compound_jacobian
      procedure :: acceleration_rhs => compound_acceleration_rhs
      procedure :: x_rate => compound_x_rate
      procedure :: v_of_x_rate => compound_v_of_x_rate
      procedure :: displace => compound_displace
      procedure :: normalize => compound_normalize
      procedure :: energy => compound_energy
   end type compound_t

contains

   !> A particle of one kind.
   function new_particle(kind, rate, ratio, amplitude) result(system)
      integer, intent(in) :: kind
      real(wp), intent(in), optional :: rate, ratio, amplitude
      type(particle_t) :: system

      system%kind = kind
      if (present(rate)) system%rate = rate
      if (present(ratio)) system%ratio = ratio
      if (present(amplitude)) system%amplitude = amplitude
      select case (kind)
      case (sleigh)
         call system%define(n=3, c=1, nonholonomic=1, mass_blocks=[1, 1, 1], constant_mass=.true.)
      case (sleigh_in_space)
         call system%define(n=4, c=2, nonholonomic=1, mass_blocks=[2, 2], constant_mass=.true.)
      case (two_rods)
         call system%define(n=2, c=2, constant_mass=.true.)
      case (actuator)
         call system%define(n=1, c=0, n_w=1)
      case default
         call system%define(n=2, c=1, constant_mass=.false.)
      end select
   end function new_particle

   subroutine particle_mass(self, at, m)
      class(particle_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m
      real(wp) :: d(self%n)

      d = self%m
      call m%set_diagonal(d)
      associate (unused_state => at)
      end associate
   end subroutine particle_mass

   subroutine particle_weight(self, at, w)
      class(particle_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: w
      real(wp) :: d(self%n, self%n)
      integer :: i

      d = 0.3_wp
      do i = 1, self%n
         d(i, i) = real(i, wp) + 0.1_wp*at%x(1)**2
      end do
      call w%set_dense(d)
   end subroutine particle_weight

   subroutine particle_force(self, at, value)
      class(particle_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = 0.0_wp
      select case (self%kind)
      case (sleigh, sleigh_in_space)
         value(1) = self%m*self%g
         if (self%kind == sleigh_in_space) value(4) = -3.0_wp
      case (two_rods, driven_pivot)
         value(2) = -self%m*self%g
      case (actuator)
         value(1) = at%w(1)
      case (jumping_load)
         value(2) = -self%m*self%g
         if (at%t >= self%ratio) value(1) = 5.0_wp
      end select
   end subroutine particle_force

   subroutine particle_constraint(self, at, value)
      class(particle_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      associate (x => at%x)
         select case (self%kind)
         case (bead)
            value(1) = -x(1)*sin(self%rate*at%t) + x(2)*cos(self%rate*at%t)
         case (sleigh_in_space)
            value(1) = x(4)
         case (two_rods)
            value = norm2(x) - [1.0_wp, self%ratio]
         case (driven_pivot)
            value(1) = norm2([x(1), x(2) - pivot(self, at%t, 0)]) - 1.0_wp
         case (jumping_load)
            value(1) = norm2(x) - 1.0_wp
         end select
      end associate
   end subroutine particle_constraint

   !> Height of the driven pivot, its rate and its acceleration.
   function pivot(self, t, derivative) result(value)
      type(particle_t), intent(in) :: self
      real(wp), intent(in) :: t
      integer, intent(in) :: derivative
      real(wp) :: value

      select case (derivative)
      case (0)
         value = self%amplitude*sin(self%rate*t)
      case (1)
         value = self%amplitude*self%rate*cos(self%rate*t)
      case default
         value = -self%amplitude*self%rate**2*sin(self%rate*t)
      end select
   end function pivot

   subroutine particle_jacobian(self, at, a)
      class(particle_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)
      real(wp) :: d(2)

      a = 0.0_wp
      associate (x => at%x)
         select case (self%kind)
         case (bead)
            a(1, :) = [-sin(self%rate*at%t), cos(self%rate*at%t)]
         case (sleigh)
            a(1, :) = [-sin(x(3)), cos(x(3)), 0.0_wp]
         case (sleigh_in_space)
            a(1, 4) = 1.0_wp
            a(2, 1:2) = [-sin(x(3)), cos(x(3))]
         case (two_rods, jumping_load)
            a(1, :) = x/norm2(x)
            if (self%kind == two_rods) a(2, :) = a(1, :)
         case (driven_pivot)
            d = [x(1), x(2) - pivot(self, at%t, 0)]
            a(1, :) = d/norm2(d)
         end select
      end associate
   end subroutine particle_jacobian

   subroutine particle_velocity_rhs(self, at, value)
      class(particle_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      real(wp) :: d(2)

      value = 0.0_wp
      associate (x => at%x)
         select case (self%kind)
         case (bead)
            value(1) = self%rate*(x(1)*cos(self%rate*at%t) + x(2)*sin(self%rate*at%t))
         case (driven_pivot)
            d = [x(1), x(2) - pivot(self, at%t, 0)]
            value(1) = d(2)/norm2(d)*pivot(self, at%t, 1)
         end select
      end associate
   end subroutine particle_velocity_rhs

   subroutine particle_acceleration_rhs(self, at, value)
      class(particle_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      real(wp) :: d(2), d_rate(2)

      value = 0.0_wp
      associate (x => at%x, v => at%v, c => cos(self%rate*at%t), s => sin(self%rate*at%t))
         select case (self%kind)
         case (bead)
            value(1) = 2.0_wp*self%rate*(v(1)*c + v(2)*s) - self%rate**2*(x(1)*s - x(2)*c)
         case (sleigh)
            value(1) = v(3)*(v(1)*cos(x(3)) + v(2)*sin(x(3)))
         case (sleigh_in_space)
            value(2) = v(3)*(v(1)*cos(x(3)) + v(2)*sin(x(3)))
         case (two_rods, jumping_load)
            value = -(x(1)*v(2) - x(2)*v(1))**2/norm2(x)**3
         case (driven_pivot)
            d = [x(1), x(2) - pivot(self, at%t, 0)]
            d_rate = [v(1), v(2) - pivot(self, at%t, 1)]
            value(1) = -(d(1)*d_rate(2) - d(2)*d_rate(1))**2/norm2(d)**3 + d(2)/norm2(d)*pivot(self, at%t, 2)
         end select
      end associate
   end subroutine particle_acceleration_rhs

   subroutine particle_w_rate(self, at, value)
      class(particle_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      if (self%kind == actuator) value = -at%w
   end subroutine particle_w_rate

   function particle_breakpoints(self) result(times)
      class(particle_t), intent(in) :: self
      real(wp), allocatable :: times(:)

      allocate (times(0))
      if (self%kind == jumping_load .and. self%declares_breakpoint) times = [self%ratio]
   end function particle_breakpoints

   !> A coupler on so many cranks.
   function new_coupler(cranks) result(system)
      integer, intent(in) :: cranks
      type(coupler_t) :: system

      system%cranks = cranks
      call system%define(n=3, c=cranks, mass_blocks=[1, 1, 1], constant_mass=.true.)
   end function new_coupler

   subroutine coupler_mass(self, at, m)
      class(coupler_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m

      call m%set_diagonal([self%m, self%m, self%inertia])
      associate (unused_state => at)
      end associate
   end subroutine coupler_mass

   subroutine coupler_force(self, at, value)
      class(coupler_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = [0.0_wp, -self%m*self%g, 0.0_wp]
      associate (unused_state => at)
      end associate
   end subroutine coupler_force

   !> From the ground to the coupler: pin i sits at {i - (cranks + 1)/2, 0} on both.
   function crank(self, at, i) result(d)
      type(coupler_t), intent(in) :: self
      type(state_t), intent(in) :: at
      integer, intent(in) :: i
      real(wp) :: d(2)
      real(wp) :: arm

      arm = i - 0.5_wp*(self%cranks + 1)
      d = [at%x(1) + arm*cos(at%x(3)) - arm, at%x(2) + arm*sin(at%x(3))]
   end function crank

   subroutine coupler_constraint(self, at, value)
      class(coupler_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      integer :: i

      do i = 1, self%cranks
         value(i) = norm2(crank(self, at, i)) - self%l
      end do
   end subroutine coupler_constraint

   subroutine coupler_jacobian(self, at, a)
      class(coupler_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)
      real(wp) :: arm, d(2)
      integer :: i

      do i = 1, self%cranks
         arm = i - 0.5_wp*(self%cranks + 1)
         d = crank(self, at, i)
         a(i, :) = [d, arm*(-d(1)*sin(at%x(3)) + d(2)*cos(at%x(3)))]/norm2(d)
      end do
   end subroutine coupler_jacobian

   subroutine coupler_acceleration_rhs(self, at, value)
      class(coupler_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      real(wp) :: arm, centripetal(2), d(2), rate(2)
      integer :: i

      do i = 1, self%cranks
         arm = i - 0.5_wp*(self%cranks + 1)
         d = crank(self, at, i)
         rate = at%v(1:2) + arm*at%v(3)*[-sin(at%x(3)), cos(at%x(3))]
         centripetal = -arm*at%v(3)**2*[cos(at%x(3)), sin(at%x(3))]
         value(i) = -(d(1)*rate(2) - d(2)*rate(1))**2/norm2(d)**3 - dot_product(d, centripetal)/norm2(d)
      end do
   end subroutine coupler_acceleration_rhs

   !> A compound pendulum, hinged at the origin.
   function new_compound() result(system)
      type(compound_t) :: system

      call system%define(n=3, c=2, n_x=4, mass_blocks=[1, 1, 1], constant_mass=.true.)
   end function new_compound

   subroutine compound_mass(self, at, m)
      class(compound_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m

      call m%set_diagonal([self%m, self%m, self%inertia])
      associate (unused_state => at)
      end associate
   end subroutine compound_mass

   subroutine compound_force(self, at, value)
      class(compound_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = [0.0_wp, -self%m*self%g, 0.0_wp]
      associate (unused_state => at)
      end associate
   end subroutine compound_force

   !> The center of mass is at arm {s, -c}.
   subroutine compound_constraint(self, at, value)
      class(compound_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = [at%x(1) - self%arm*at%x(4), at%x(2) + self%arm*at%x(3)]
   end subroutine compound_constraint

   subroutine compound_jacobian(self, at, a)
      class(compound_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)

      a(1, :) = [1.0_wp, 0.0_wp, -self%arm*at%x(3)]
      a(2, :) = [0.0_wp, 1.0_wp, -self%arm*at%x(4)]
   end subroutine compound_jacobian

   subroutine compound_acceleration_rhs(self, at, value)
      class(compound_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = self%arm*at%v(3)**2*[-at%x(4), at%x(3)]
   end subroutine compound_acceleration_rhs

   subroutine compound_x_rate(self, at, u, value)
      class(compound_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: u(:)
      real(wp), intent(out) :: value(:)

      value = [u(1), u(2), -u(3)*at%x(4), u(3)*at%x(3)]
      associate (unused_system => self)
      end associate
   end subroutine compound_x_rate

   subroutine compound_v_of_x_rate(self, at, rate, u)
      class(compound_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: rate(:)
      real(wp), intent(out) :: u(:)

      u = [rate(1), rate(2), at%x(3)*rate(4) - at%x(4)*rate(3)]
      associate (unused_system => self)
      end associate
   end subroutine compound_v_of_x_rate

   subroutine compound_displace(self, d, x)
      class(compound_t), intent(in) :: self
      real(wp), intent(in) :: d(:)
      real(wp), intent(inout) :: x(:)

      x = [x(1:2) + d(1:2), x(3)*cos(d(3)) - x(4)*sin(d(3)), x(4)*cos(d(3)) + x(3)*sin(d(3))]
      associate (unused_system => self)
      end associate
   end subroutine compound_displace

   subroutine compound_normalize(self, x)
      class(compound_t), intent(in) :: self
      real(wp), intent(inout) :: x(:)

      x(3:4) = x(3:4)/norm2(x(3:4))
      associate (unused_system => self)
      end associate
   end subroutine compound_normalize

   function compound_energy(self, at) result(energy)
      class(compound_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp) :: energy

      energy = 0.5_wp*self%m*sum(at%v(1:2)**2) + 0.5_wp*self%inertia*at%v(3)**2 + self%m*self%g*at%x(2)
   end function compound_energy

end module systems
