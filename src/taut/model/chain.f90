!> A chain of rods without mass that carry point masses at their ends, hung at one end: planar, of any length.
!!
!! It shows how a large system is stated: M is diagonal, and of A only the entries that differ from zero are computed, four a
!! row, so that the cost of a step grows with the number of rods and not with its cube.
module taut_model_chain
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_constrained_system, only: state_t
   use taut_constrained_system_tables, only: name_length
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_model_plane_rods, only: plane_rods_t
   implicit none (type, external)
   private
   public :: chain_t, new_chain

   !> Coordinates {x1, z1, x2, z2, ...} of the masses, horizontal and upward from the support [m];
   !! phi_i = |r_i - r_(i-1)| - l [m]; the multipliers are the tensions of the rods [N].
   type, extends(plane_rods_t) :: chain_t
      !> Number of rods.
      integer :: rods = 0
      !> Mass at the end of each rod [kg].
      real(wp), allocatable :: m(:)
   contains
      procedure :: mass
      procedure :: force
      procedure :: constraint
      procedure :: pattern
      procedure :: jacobian_entries
      procedure :: acceleration_rhs
      procedure :: energy
      procedure :: power
      procedure :: x_name
      procedure :: start
   end type chain_t

contains

   !> A chain with equal masses.
   subroutine new_chain(self, rods, m, l, g, error)
      !> The chain.
      type(chain_t), intent(out) :: self
      !> Number of rods.
      integer, intent(in) :: rods
      !> Mass at the end of each rod [kg].
      real(wp), intent(in) :: m
      !> Length of a rod [m].
      real(wp), intent(in) :: l
      !> Gravity [m/s^2].
      real(wp), intent(in) :: g
      !> A value that makes no sense.
      type(error_t), allocatable, intent(inout) :: error
      character(*), parameter :: here = 'chain'

      if (rods < 1 .or. rods > 10000000) &
         call raise(error, here, 'rods = '//to_text(rods)//' is not between 1 and 10000000', 'give the number of rods')
      call self%set_rods(here, m, l, g, error)
      if (allocated(error)) return
      self%rods = rods
      allocate (self%m(rods), source=m)
      call self%define(n=2*rods, c=rods, mass_blocks=spread(1, 1, 2*rods), constant_mass=.true.)
   end subroutine new_chain

   !> A straight chain at rest.
   pure subroutine start(self, angle, at)
      !> The chain.
      class(chain_t), intent(in) :: self
      !> From the horizontal x, downwards [rad].
      real(wp), intent(in) :: angle
      !> The state, at t = 0.
      type(state_t), intent(out) :: at
      integer :: i

      allocate (at%x(2*self%rods), at%v(2*self%rods), at%w(0), source=0.0_wp)
      do i = 1, self%rods
         at%x(2*i - 1) = i*self%l*cos(angle)
         at%x(2*i) = -i*self%l*sin(angle)
      end do
   end subroutine start

   !> M: each mass twice on the diagonal [kg].
   subroutine mass(self, at, m)
      !> The chain.
      class(chain_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> The mass matrix.
      type(block_diagonal_t), intent(inout) :: m
      integer :: i

      do i = 1, self%rods
         m%values(2*i - 1) = self%m(i)
         m%values(2*i) = self%m(i)
      end do
      associate (unused_state => at)
      end associate
   end subroutine mass

   !> Weight [N].
   subroutine force(self, at, value)
      !> The chain.
      class(chain_t), intent(in) :: self
      !> The state; all of it may be used.
      type(state_t), intent(in) :: at
      !> The force: (2 rods).
      real(wp), intent(out) :: value(:)
      integer :: i

      do i = 1, self%rods
         value(2*i - 1) = 0.0_wp
         value(2*i) = -self%m(i)*self%g
      end do
      associate (unused_state => at)
      end associate
   end subroutine force

   !> phi: length of each rod less l [m].
   subroutine constraint(self, at, value)
      !> The chain.
      class(chain_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> phi: (rods).
      real(wp), intent(out) :: value(:)
      integer :: i

      value(1) = sqrt(at%x(1)**2 + at%x(2)**2) - self%l
      do i = 2, self%rods
         value(i) = sqrt((at%x(2*i - 1) - at%x(2*i - 3))**2 + (at%x(2*i) - at%x(2*i - 2))**2) - self%l
      end do
   end subroutine constraint

   !> Row i of A: the masses i - 1 and i; the first rod has one mass.
   subroutine pattern(self, first, column)
      !> The chain.
      class(chain_t), intent(in) :: self
      !> First entry of each row: (rods + 1).
      integer, allocatable, intent(out) :: first(:)
      !> Column of each entry: (4 rods - 2).
      integer, allocatable, intent(out) :: column(:)
      integer :: i, j

      first = [1, (4*i - 1, i=1, self%rods)]
      column = [1, 2, ((2*i - 4 + j, j=1, 4), i=2, self%rods)]
   end subroutine pattern

   !> The direction of each rod, with a minus sign for the mass before it.
   subroutine jacobian_entries(self, at, values)
      !> The chain.
      class(chain_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> The entries: (4 rods - 2).
      real(wp), intent(out) :: values(:)

      call directions(self%rods, at%x, values)
   end subroutine jacobian_entries

   !> The same with unit strides, which lets two rods be done at a time.
   pure subroutine directions(rods, x, values)
      integer, intent(in) :: rods
      real(wp), intent(in) :: x(2*rods)
      real(wp), intent(out) :: values(4*rods - 2)
      real(wp) :: dx, dz, r
      integer :: i

      r = 1.0_wp/sqrt(x(1)**2 + x(2)**2)
      values(1) = x(1)*r
      values(2) = x(2)*r
      do i = 2, rods
         dx = x(2*i - 1) - x(2*i - 3)
         dz = x(2*i) - x(2*i - 2)
         r = 1.0_wp/sqrt(dx*dx + dz*dz)
         values(4*i - 5) = -dx*r
         values(4*i - 4) = -dz*r
         values(4*i - 3) = dx*r
         values(4*i - 2) = dz*r
      end do
   end subroutine directions

   !> b'': the square of the velocity across each rod over its length, negative [m/s^2].
   subroutine acceleration_rhs(self, at, value)
      !> The chain.
      class(chain_t), intent(in) :: self
      !> The state; its x, v and t are used.
      type(state_t), intent(in) :: at
      !> b'': (rods).
      real(wp), intent(out) :: value(:)

      call centripetal(self%rods, at%x, at%v, value)
   end subroutine acceleration_rhs

   !> The same with unit strides.
   pure subroutine centripetal(rods, x, v, value)
      integer, intent(in) :: rods
      real(wp), intent(in) :: x(2*rods), v(2*rods)
      real(wp), intent(out) :: value(rods)
      real(wp) :: across, dx, dz, r2
      integer :: i

      r2 = x(1)**2 + x(2)**2
      value(1) = -(x(1)*v(2) - x(2)*v(1))**2/(r2*sqrt(r2))
      do i = 2, rods
         dx = x(2*i - 1) - x(2*i - 3)
         dz = x(2*i) - x(2*i - 2)
         across = dx*(v(2*i) - v(2*i - 2)) - dz*(v(2*i - 1) - v(2*i - 3))
         r2 = dx*dx + dz*dz
         value(i) = -across*across/(r2*sqrt(r2))
      end do
   end subroutine centripetal

   !> Kinetic and potential energy [J]; zero at rest in the horizontal.
   function energy(self, at)
      !> The chain.
      class(chain_t), intent(in) :: self
      !> The state; its x and v are used.
      type(state_t), intent(in) :: at
      !> The energy.
      real(wp) :: energy
      integer :: i

      energy = 0.0_wp
      do i = 1, self%rods
         energy = energy + self%m(i)*(0.5_wp*(at%v(2*i - 1)**2 + at%v(2*i)**2) + self%g*at%x(2*i))
      end do
   end function energy

   !> None: the energy contains all forces.
   function power(self, at)
      !> The chain.
      class(chain_t), intent(in) :: self
      !> The state at which it is evaluated.
      type(state_t), intent(in) :: at
      !> Zero [W].
      real(wp) :: power

      power = 0.0_wp
      associate (unused_system => self, unused_state => at)
      end associate
   end function power

   !> x1, z1, x2, ...
   function x_name(self, i) result(name)
      !> The chain.
      class(chain_t), intent(in) :: self
      !> Index of the coordinate.
      integer, intent(in) :: i
      !> The name.
      character(len=name_length) :: name

      name = merge('x', 'z', mod(i, 2) == 1)//to_text((i + 1)/2)
      associate (unused_chain => self)
      end associate
   end function x_name

end module taut_model_chain
