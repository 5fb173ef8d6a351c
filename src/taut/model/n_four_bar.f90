!> The N-four-bar mechanism: N windows of rods in a row, N + 1 cranks on the ground that N couplers join; planar.
!!
!! With the length of the rods equal to the distance of the pivots all cranks share one angle. Wherever they lie in the line
!! of the pivots, other motions branch off: the number of degrees of freedom jumps from 1 to N + 1.
module taut_model_n_four_bar
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_constrained_system, only: state_t
   use taut_constrained_system_tables, only: name_length
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_model_plane_rods, only: plane_rods_t
   implicit none (type, external)
   private
   public :: n_four_bar_t, new_n_four_bar

   !> Coordinates: x and z of the tip of the first crank, then of the center of the first coupler, the tip of the second crank
   !! and so on: 2 (2N + 1) [m]. The pivot of crank i is at {(i - 1) l, 0}.
   !!
   !! A uniform rod has the mass matrix m/6 [2 1; 1 2] of its two ends, per direction. That is the one of masses m/6 at its
   !! ends and 2m/3 at its center: with the centers of the couplers as points, M is diagonal and S is banded, at the
   !! price of two linear constraints a coupler. The constraints, window by window: the length of the crank, that of the
   !! coupler, its center in x and in z: 4N + 1.
   type, extends(plane_rods_t) :: n_four_bar_t
      !> Number of windows.
      integer :: windows = 0
      !> Mass of a rod [kg]; the pivots are as far apart as the rods are long.
      real(wp) :: m = 1.0_wp
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
   end type n_four_bar_t

contains

   !> A mechanism of equal rods.
   subroutine new_n_four_bar(self, windows, m, l, g, error)
      !> The mechanism.
      type(n_four_bar_t), intent(out) :: self
      !> Number of windows.
      integer, intent(in) :: windows
      !> Mass of a rod [kg].
      real(wp), intent(in) :: m
      !> Length of a rod [m].
      real(wp), intent(in) :: l
      !> Gravity [m/s^2].
      real(wp), intent(in) :: g
      !> A value that makes no sense.
      type(error_t), allocatable, intent(inout) :: error
      character(*), parameter :: here = 'n_four_bar'

      if (windows < 1 .or. windows > 1000000) &
         call raise(error, here, 'windows = '//to_text(windows)//' is not between 1 and 1000000', 'give the number of windows')
      call self%set_rods(here, m, l, g, error)
      if (allocated(error)) return
      self%windows = windows
      self%m = m
      call self%define(n=2*(2*windows + 1), c=4*windows + 1, mass_blocks=spread(1, 1, 2*(2*windows + 1)), constant_mass=.true.)
   end subroutine new_n_four_bar

   !> All cranks at one angle, turning at one speed.
   pure subroutine start(self, angle, speed, at)
      !> The mechanism.
      class(n_four_bar_t), intent(in) :: self
      !> Of the cranks from the upward vertical towards x [rad].
      real(wp), intent(in) :: angle
      !> Speed of their tips [m/s].
      real(wp), intent(in) :: speed
      !> The state, at t = 0.
      type(state_t), intent(out) :: at
      integer :: p

      allocate (at%x(self%n), at%v(self%n), at%w(0), source=0.0_wp)
      do p = 0, 2*self%windows
         at%x(2*p + 1) = 0.5_wp*p*self%l + self%l*sin(angle)
         at%x(2*p + 2) = self%l*cos(angle)
         at%v(2*p + 1) = speed*cos(angle)
         at%v(2*p + 2) = -speed*sin(angle)
      end do
   end subroutine start

   !> M: a third of each crank and a sixth of each coupler at the tips, two thirds of each coupler at its center [kg].
   subroutine mass(self, at, m)
      !> The mechanism.
      class(n_four_bar_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> The mass matrix.
      type(block_diagonal_t), intent(inout) :: m
      integer :: p

      do p = 0, 2*self%windows
         m%values(2*p + 1:2*p + 2) = self%m*merge(2.0_wp/3.0_wp, 1.0_wp/3.0_wp, mod(p, 2) == 1)
         if (mod(p, 2) == 0 .and. p > 0) m%values(2*p + 1:2*p + 2) = m%values(2*p + 1:2*p + 2) + self%m/6.0_wp
         if (mod(p, 2) == 0 .and. p < 2*self%windows) m%values(2*p + 1:2*p + 2) = m%values(2*p + 1:2*p + 2) + self%m/6.0_wp
      end do
      associate (unused_state => at)
      end associate
   end subroutine mass

   !> Weight of the rods [N]: half of it at either end; that of a coupler may as well act at its center.
   subroutine force(self, at, value)
      !> The mechanism.
      class(n_four_bar_t), intent(in) :: self
      !> The state; all of it may be used.
      type(state_t), intent(in) :: at
      !> The force: (n).
      real(wp), intent(out) :: value(:)
      integer :: p

      do p = 0, 2*self%windows
         value(2*p + 1) = 0.0_wp
         value(2*p + 2) = -self%m*self%g*merge(1.0_wp, 0.5_wp, mod(p, 2) == 1)
      end do
      associate (unused_state => at)
      end associate
   end subroutine force

   !> phi: lengths less l, and the distance of each center from the middle of the tips [m].
   subroutine constraint(self, at, value)
      !> The mechanism.
      class(n_four_bar_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> phi: (4N + 1).
      real(wp), intent(out) :: value(:)
      integer :: i, k

      do i = 0, self%windows
         k = 4*i
         associate (b => at%x(k + 1:k + 2))
            value(k + 1) = sqrt((b(1) - i*self%l)**2 + b(2)**2) - self%l
         end associate
         if (i == self%windows) exit
         associate (b => at%x(k + 1:k + 2), center => at%x(k + 3:k + 4), next => at%x(k + 5:k + 6))
            value(k + 2) = sqrt((next(1) - b(1))**2 + (next(2) - b(2))**2) - self%l
            value(k + 3) = center(1) - 0.5_wp*(b(1) + next(1))
            value(k + 4) = center(2) - 0.5_wp*(b(2) + next(2))
         end associate
      end do
   end subroutine constraint

   !> Rows of A: the crank's tip; both tips; a tip, the center and the other tip, in x and in z: 12 entries a window.
   subroutine pattern(self, first, column)
      !> The mechanism.
      class(n_four_bar_t), intent(in) :: self
      !> First entry of each row: (4N + 2).
      integer, allocatable, intent(out) :: first(:)
      !> Column of each entry: (12N + 2).
      integer, allocatable, intent(out) :: column(:)
      integer :: e, i, k

      allocate (first(4*self%windows + 2), column(12*self%windows + 2))
      do i = 0, self%windows
         k = 4*i
         e = 12*i
         first(k + 1) = e + 1
         first(k + 2) = e + 3
         column(e + 1:e + 2) = [k + 1, k + 2]
         if (i == self%windows) exit
         first(k + 3) = e + 7
         first(k + 4) = e + 10
         column(e + 3:e + 12) = [k + 1, k + 2, k + 5, k + 6, k + 1, k + 3, k + 5, k + 2, k + 4, k + 6]
      end do
   end subroutine pattern

   !> The directions of the rods, and the weights of the centers.
   subroutine jacobian_entries(self, at, values)
      !> The mechanism.
      class(n_four_bar_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> The entries: (12N + 2).
      real(wp), intent(out) :: values(:)
      real(wp) :: dx, dz, r
      integer :: e, i, k

      do i = 0, self%windows
         k = 4*i
         e = 12*i
         dx = at%x(k + 1) - i*self%l
         dz = at%x(k + 2)
         r = 1.0_wp/sqrt(dx*dx + dz*dz)
         values(e + 1) = dx*r
         values(e + 2) = dz*r
         if (i == self%windows) exit
         dx = at%x(k + 5) - at%x(k + 1)
         dz = at%x(k + 6) - at%x(k + 2)
         r = 1.0_wp/sqrt(dx*dx + dz*dz)
         values(e + 3) = -dx*r
         values(e + 4) = -dz*r
         values(e + 5) = dx*r
         values(e + 6) = dz*r
         values(e + 7) = -0.5_wp
         values(e + 8) = 1.0_wp
         values(e + 9) = -0.5_wp
         values(e + 10) = -0.5_wp
         values(e + 11) = 1.0_wp
         values(e + 12) = -0.5_wp
      end do
   end subroutine jacobian_entries

   !> b'': the square of the velocity across each rod over its length, negative; zero for the centers [m/s^2].
   subroutine acceleration_rhs(self, at, value)
      !> The mechanism.
      class(n_four_bar_t), intent(in) :: self
      !> The state; its x, v and t are used.
      type(state_t), intent(in) :: at
      !> b'': (4N + 1).
      real(wp), intent(out) :: value(:)
      integer :: i, k

      do i = 0, self%windows
         k = 4*i
         value(k + 1) = across(at%x(k + 1) - i*self%l, at%x(k + 2), at%v(k + 1), at%v(k + 2))
         if (i == self%windows) exit
         value(k + 2) = across(at%x(k + 5) - at%x(k + 1), at%x(k + 6) - at%x(k + 2), &
                               at%v(k + 5) - at%v(k + 1), at%v(k + 6) - at%v(k + 2))
         value(k + 3) = 0.0_wp
         value(k + 4) = 0.0_wp
      end do

   contains

      pure real(wp) function across(dx, dz, vx, vz)
         real(wp), intent(in) :: dx, dz, vx, vz
         real(wp) :: r2

         r2 = dx*dx + dz*dz
         across = -(dx*vz - dz*vx)**2/(r2*sqrt(r2))
      end function across

   end subroutine acceleration_rhs

   !> Kinetic and potential energy [J]; potential energy is zero with the rods at the height of the pivots.
   function energy(self, at)
      !> The mechanism.
      class(n_four_bar_t), intent(in) :: self
      !> The state; its x and v are used.
      type(state_t), intent(in) :: at
      !> The energy.
      real(wp) :: energy
      type(block_diagonal_t) :: m
      real(wp) :: f(self%n)

      call m%init(self%mass_blocks)
      call self%mass(at, m)
      call self%force(at, f)
      energy = 0.5_wp*sum(m%values*at%v**2) - dot_product(f, at%x)
   end function energy

   !> None: the energy contains all forces.
   function power(self, at)
      !> The mechanism.
      class(n_four_bar_t), intent(in) :: self
      !> The state at which it is evaluated.
      type(state_t), intent(in) :: at
      !> Zero [W].
      real(wp) :: power

      power = 0.0_wp
      associate (unused_system => self, unused_state => at)
      end associate
   end function power

   !> Bx0, Bz0, Cx1, Cz1, Bx1, ... (tips and centers).
   function x_name(self, i) result(name)
      !> The mechanism.
      class(n_four_bar_t), intent(in) :: self
      !> Index of the coordinate.
      integer, intent(in) :: i
      !> The name.
      character(len=name_length) :: name
      integer :: p

      p = (i - 1)/2
      name = merge('C', 'B', mod(p, 2) == 1)//merge('x', 'z', mod(i, 2) == 1)//to_text((p + 1)/2)
      associate (unused_mechanism => self)
      end associate
   end function x_name

end module taut_model_n_four_bar
