!> A large system: a chain of 1000 rods and balls that turns about its end like a spoke, weightless.
!!
!! With `pattern` and `jacobian_entries` in the place of `jacobian`, a step costs as much as there are rods. The first rod
!! carries m w^2 l n (n + 1)/2.
module spoke_system
   use taut
   implicit none (type, external)

   type, extends(mechanical_system_t) :: spoke_t
      integer :: rods = 1000
      real(wp) :: m = 0.1_wp, l = 0.01_wp               ! mass of a ball [kg], length of a rod [m]
   contains
      procedure :: mass, force, constraint, pattern, jacobian_entries, acceleration_rhs
   end type spoke_t

contains

   subroutine mass(self, at, m)
      class(spoke_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m
      call m%set_diagonal(spread(self%m, 1, size(at%v)))
   end subroutine mass

   subroutine force(self, at, value)
      class(spoke_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      value(:2*self%rods) = 0.0_wp*at%v
   end subroutine force

   subroutine constraint(self, at, value)               ! phi = (d.d/l - l)/2 of each rod [m]
      class(spoke_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      value = 0.5_wp*(sum(differences(at%x)**2, dim=1)/self%l - self%l)
   end subroutine constraint

   subroutine pattern(self, first, column)              ! row i: the balls i - 1 and i; the first rod has one
      class(spoke_t), intent(in) :: self
      integer, allocatable, intent(out) :: first(:), column(:)
      integer :: i, j
      first = [1, (4*i - 1, i=1, self%rods)]
      column = [1, 2, ((2*i - 4 + j, j=1, 4), i=2, self%rods)]
   end subroutine pattern

   subroutine jacobian_entries(self, at, values)        ! in the order of the pattern
      class(spoke_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: values(:)
      real(wp) :: d(2, self%rods)
      integer :: i
      d = differences(at%x)/self%l
      values(1:2) = d(:, 1)
      do i = 2, self%rods
         values(4*i - 5:4*i - 2) = [-d(:, i), d(:, i)]
      end do
   end subroutine jacobian_entries

   subroutine acceleration_rhs(self, at, value)
      class(spoke_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      value = -sum(differences(at%v)**2, dim=1)/self%l
   end subroutine acceleration_rhs

   pure function differences(x) result(d)               ! each ball's place less that of the one before: (2, rods)
      real(wp), intent(in) :: x(:)
      real(wp) :: d(2, size(x)/2)
      d = reshape(x, shape(d))
      d(:, 2:) = d(:, 2:) - reshape(x(:size(x) - 2), [2, size(d, 2) - 1])
   end function differences

end module spoke_system

program large
   use taut
   use spoke_system
   implicit none (type, external)
   type(spoke_t) :: spoke
   type(state_t) :: at
   type(integration_result_t) :: result
   class(constrained_ode_t), allocatable :: ode
   type(sample_t) :: seen
   type(error_t), allocatable :: error
   real(wp), allocatable :: y(:)
   real(wp), parameter :: w = 1.0_wp                    ! it turns [rad/s]
   integer :: i, info

   call spoke%define(n=2*spoke%rods, c=spoke%rods, mass_blocks=spread(1, 1, 2*spoke%rods), constant_mass=.true.)
   at%x = [(real([i, 0], wp)*spoke%l, i=1, spoke%rods)]
   at%v = [(real([0, i], wp)*spoke%l*w, i=1, spoke%rods)]
   call simulate(spoke, at, 0.5_wp, result, error, options=integration_options_t(rtol=1.0e-9_wp), ode=ode)
   if (allocated(error)) error stop 'it could not begin'
   allocate (y(ode%size()))
   call ode%pack(at, y)
   call ode%sample(at%t, y, seen, info)
   print '(2a, 2f13.6)', status_name(result%status), ', force of the first rod, and in closed form [N]:', seen%lambda(1), &
      spoke%m*w**2*spoke%l*spoke%rods*(spoke%rods + 1)/2
   print '(a, f11.8)', 'angle turned by [rad]:', atan2(at%x(2*spoke%rods), at%x(2*spoke%rods - 1))
end program large
