!> The simple pendulum of Sect. 4.1: a point mass on a rigid rod, in Cartesian coordinates.
module taut_model_pendulum
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_constrained_system, only: state_t
   use taut_constrained_system_tables, only: name_length
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_model_plane_rods, only: plane_rods_t
   implicit none (type, external)
   private
   public :: pendulum_t, new_pendulum

   !> Coordinates x (horizontal) and z (upward) from the pivot [m]; phi = sqrt(x^2 + z^2) - L [m], Eq. (27c); the
   !! multiplier is the tension of the rod [N].
   type, extends(plane_rods_t) :: pendulum_t
      !> Mass [kg].
      real(wp) :: m = 1.0_wp
   contains
      procedure :: mass
      procedure :: force
      procedure :: constraint
      procedure :: jacobian
      procedure :: acceleration_rhs
      procedure :: energy
      procedure :: power
      procedure :: x_name
   end type pendulum_t

contains

   !> A pendulum with its constraint stated once or several times.
   subroutine new_pendulum(self, m, l, g, copies, error)
      !> The pendulum.
      type(pendulum_t), intent(out) :: self
      !> Mass [kg].
      real(wp), intent(in) :: m
      !> Length [m].
      real(wp), intent(in) :: l
      !> Gravity [m/s^2].
      real(wp), intent(in) :: g
      !> How often the constraint is stated; more than once makes it redundant.
      integer, intent(in) :: copies
      !> A value that makes no sense.
      type(error_t), allocatable, intent(inout) :: error
      character(*), parameter :: here = 'pendulum'

      call self%set_rods(here, m, l, g, error)
      if (copies < 1 .or. copies > 100) &
         call raise(error, here, 'constraint_copies = '//to_text(copies)//' is not between 1 and 100', 'give a small number')
      if (allocated(error)) return
      self%m = m
      call self%define(n=2, c=copies, mass_blocks=[1, 1], constant_mass=.true.)
   end subroutine new_pendulum

   !> M = diag(m, m) [kg].
   subroutine mass(self, at, m)
      !> The pendulum.
      class(pendulum_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> The mass matrix.
      type(block_diagonal_t), intent(inout) :: m

      call m%set_diagonal([self%m, self%m])
      associate (unused_state => at)
      end associate
   end subroutine mass

   !> f = {0; -m g} [N], Eqs (27a), (27b).
   subroutine force(self, at, value)
      !> The pendulum.
      class(pendulum_t), intent(in) :: self
      !> The state; all of it may be used.
      type(state_t), intent(in) :: at
      !> The force: (2).
      real(wp), intent(out) :: value(:)

      value(1) = 0.0_wp
      value(2) = -self%m*self%g
      associate (unused_state => at)
      end associate
   end subroutine force

   !> phi = sqrt(x^2 + z^2) - L [m], Eq. (27c).
   subroutine constraint(self, at, value)
      !> The pendulum.
      class(pendulum_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> phi: (copies).
      real(wp), intent(out) :: value(:)

      value(:) = sqrt(at%x(1)**2 + at%x(2)**2) - self%l
   end subroutine constraint

   !> A = {x, z}/sqrt(x^2 + z^2); zero at the pivot, where the direction of the rod is not known.
   subroutine jacobian(self, at, a)
      !> The pendulum.
      class(pendulum_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> The constraint matrix: (copies, 2).
      real(wp), intent(out) :: a(:, :)
      real(wp) :: r
      integer :: i

      r = sqrt(at%x(1)**2 + at%x(2)**2)
      if (r > 0.0_wp) r = 1.0_wp/r
      !GCC$ unroll 1
      do i = 1, size(a, 1)
         a(i, 1) = at%x(1)*r
         a(i, 2) = at%x(2)*r
      end do
      associate (unused_pendulum => self)
      end associate
   end subroutine jacobian

   !> b'' = -(v^2 - (A v)^2)/sqrt(x^2 + z^2) [m/s^2], Eq. (6b).
   subroutine acceleration_rhs(self, at, value)
      !> The pendulum.
      class(pendulum_t), intent(in) :: self
      !> The state; its x, v and t are used.
      type(state_t), intent(in) :: at
      !> b'': (copies).
      real(wp), intent(out) :: value(:)
      real(wp) :: b, r2
      integer :: i

      ! v^2 - (A v)^2 is the square of the transverse velocity, (x vz - z vx)^2/r^2.
      r2 = at%x(1)**2 + at%x(2)**2
      b = 0.0_wp
      if (r2 > 0.0_wp) b = -(at%x(1)*at%v(2) - at%x(2)*at%v(1))**2/(r2*sqrt(r2))
      !GCC$ unroll 1
      do i = 1, size(value)
         value(i) = b
      end do
      associate (unused_pendulum => self)
      end associate
   end subroutine acceleration_rhs

   !> Kinetic and potential energy [J]; zero at rest in the horizontal.
   function energy(self, at)
      !> The pendulum.
      class(pendulum_t), intent(in) :: self
      !> The state; its x and v are used.
      type(state_t), intent(in) :: at
      !> The energy.
      real(wp) :: energy

      energy = self%m*(0.5_wp*(at%v(1)**2 + at%v(2)**2) + self%g*at%x(2))
   end function energy

   !> None: the energy contains all forces.
   function power(self, at)
      !> The pendulum.
      class(pendulum_t), intent(in) :: self
      !> The state at which it is evaluated.
      type(state_t), intent(in) :: at
      !> Zero [W].
      real(wp) :: power

      power = 0.0_wp
      associate (unused_system => self, unused_state => at)
      end associate
   end function power

   !> x or z.
   function x_name(self, i) result(name)
      !> The pendulum.
      class(pendulum_t), intent(in) :: self
      !> 1 or 2.
      integer, intent(in) :: i
      !> The name.
      character(len=name_length) :: name

      name = merge('x', 'z', i == 1)
      associate (unused_pendulum => self)
      end associate
   end function x_name

end module taut_model_pendulum
