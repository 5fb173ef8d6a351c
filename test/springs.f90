!> A spring pendulum, whose spring may be stiff.
module springs
   use taut, only: block_diagonal_t, state_t, wp
   use taut_constrained_system_stiff, only: stiff_system_t
   implicit none (type, external)
   private
   public :: new_spring, spring_t

   !> A unit mass on a spring from the origin, of length 1, under gravity along -y; as elastic row or as a force
   !> alone; damped or not.
   type, extends(stiff_system_t) :: spring_t
      real(wp) :: k = 1.0e8_wp, tau = 0.0_wp, gravity = 9.81_wp
   contains
      procedure :: mass => spring_mass
      procedure :: force => spring_force
      procedure :: soft_force => spring_soft_force
      procedure :: elastic_pattern => spring_pattern
      procedure :: elastic_rows => spring_rows
      procedure :: elastic_stiffness => spring_stiffness
   end type spring_t

contains

   subroutine spring_mass(self, at, m)
      class(spring_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m

      call m%set_identity()
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine spring_mass

   subroutine spring_force(self, at, value)
      class(spring_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      real(wp) :: strain(1), e(2)

      call self%elastic_rows(at, strain, e)
      value = [0.0_wp, -self%gravity] - self%k*strain(1)*e
   end subroutine spring_force

   subroutine spring_soft_force(self, at, value)
      class(spring_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      if (self%n_elastic == 0) then
         call self%force(at, value)
      else
         value = [0.0_wp, -self%gravity]
      end if
   end subroutine spring_soft_force

   subroutine spring_pattern(self, first, column)
      class(spring_t), intent(in) :: self
      integer, allocatable, intent(out) :: first(:), column(:)

      first = [1]
      column = [integer ::]
      if (self%n_elastic == 0) return
      first = [1, 3]
      column = [1, 2]
   end subroutine spring_pattern

   subroutine spring_rows(self, at, strain, values)
      class(spring_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: strain(:), values(:)

      values = at%x/norm2(at%x)
      strain = norm2(at%x) - 1.0_wp + self%tau*dot_product(values, at%v)
   end subroutine spring_rows

   subroutine spring_stiffness(self, stiffness)
      class(spring_t), intent(in) :: self
      type(block_diagonal_t), intent(inout) :: stiffness

      call stiffness%init([1])
      call stiffness%set_diagonal([self%k])
   end subroutine spring_stiffness

   !> A spring as an elastic row.
   function new_spring(k) result(spring)
      real(wp), intent(in) :: k
      type(spring_t) :: spring

      spring%k = k
      call spring%define(n=2, c=0, mass_blocks=[1, 1])
      spring%n_elastic = 1
   end function new_spring

end module springs
