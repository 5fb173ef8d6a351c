!> The same motion in any unit of length: when a constraint is met, and what a checker finds, must not depend on it.
module test_units
   use taut, only: block_diagonal_t, error_t, finding_t, integration_options_t, integration_result_t, mechanical_system_t, &
                   method_t, simulate, state_t, status_reached_end, verify, wp
   use taut_constrained_projection, only: projector_t
   use taut_error, only: to_text
   use taut_ode_system, only: rhs_no_projection, rhs_ok
   use testing, only: check, check_below, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_units

   !> A pendulum of length l [any unit], with phi = |x| - l or phi = (x^2 - l^2)/2.
   type, extends(mechanical_system_t) :: bob_t
      real(wp) :: l = 1.0_wp
      logical :: root = .false.
      !> What b'' is multiplied with; 1 is right.
      real(wp) :: factor = 1.0_wp
   contains
      procedure :: mass => bob_mass
      procedure :: force => bob_force
      procedure :: constraint => bob_constraint
      procedure :: jacobian => bob_jacobian
      procedure :: acceleration_rhs => bob_acceleration_rhs
   end type bob_t

   !> The same pendulum by its displacement from (1, 0), which is as small as one likes while its length is 1.
   type, extends(bob_t) :: displaced_t
   contains
      procedure :: constraint => displaced_constraint
      procedure :: jacobian => displaced_jacobian
      procedure :: acceleration_rhs => displaced_acceleration_rhs
   end type displaced_t

   !> Two curves that touch: x = 0 and x + y^2/2 = 0.
   type, extends(mechanical_system_t) :: tangent_t
   contains
      procedure :: mass => tangent_mass
      procedure :: force => tangent_force
      procedure :: constraint => tangent_constraint
      procedure :: jacobian => tangent_jacobian
      procedure :: acceleration_rhs => tangent_acceleration_rhs
   end type tangent_t

   !> From an atom's size in meters to an orbit's.
   real(wp), parameter :: lengths(4) = [1.0_wp, 1.0e-10_wp, 1.0e-6_wp, 4.2164e7_wp]

contains

   !> All tests of this module.
   function collect_units() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('a pendulum of any length', any_length), &
               new_test('small displacements of what is large', small_displacements), &
               new_test('what is wrong is so in any unit', verified), &
               new_test('rows that are passed over are asked where the others do not help', passed_over)]
   end function collect_units

   subroutine bob_mass(self, at, m)
      class(bob_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m

      m%values(:) = 1.0_wp
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine bob_mass

   subroutine bob_force(self, at, value)
      class(bob_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = [0.0_wp, -9.81_wp*self%l]
      associate (unused_state => at)
      end associate
   end subroutine bob_force

   subroutine bob_constraint(self, at, value)
      class(bob_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(1) = 0.5_wp*(dot_product(at%x, at%x) - self%l**2)
      if (self%root) value(1) = norm2(at%x) - self%l
   end subroutine bob_constraint

   subroutine bob_jacobian(self, at, a)
      class(bob_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)

      a(1, :) = at%x
      if (self%root) a(1, :) = at%x/norm2(at%x)
   end subroutine bob_jacobian

   subroutine bob_acceleration_rhs(self, at, value)
      class(bob_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(1) = -self%factor*dot_product(at%v, at%v)
      if (self%root) value(1) = -self%factor*(at%x(1)*at%v(2) - at%x(2)*at%v(1))**2/norm2(at%x)**3
   end subroutine bob_acceleration_rhs

   subroutine displaced_constraint(self, at, value)
      class(displaced_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(1) = hypot(at%x(1) + 1.0_wp, at%x(2)) - 1.0_wp
      associate (unused_system => self)
      end associate
   end subroutine displaced_constraint

   subroutine displaced_jacobian(self, at, a)
      class(displaced_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)

      a(1, :) = [at%x(1) + 1.0_wp, at%x(2)]/hypot(at%x(1) + 1.0_wp, at%x(2))
      associate (unused_system => self)
      end associate
   end subroutine displaced_jacobian

   subroutine displaced_acceleration_rhs(self, at, value)
      class(displaced_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(1) = -((at%x(1) + 1.0_wp)*at%v(2) - at%x(2)*at%v(1))**2/hypot(at%x(1) + 1.0_wp, at%x(2))**3
      associate (unused_system => self)
      end associate
   end subroutine displaced_acceleration_rhs

   subroutine tangent_mass(self, at, m)
      class(tangent_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m

      m%values(:) = 1.0_wp
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine tangent_mass

   subroutine tangent_force(self, at, value)
      class(tangent_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = 0.0_wp
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine tangent_force

   subroutine tangent_constraint(self, at, value)
      class(tangent_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = [at%x(1), at%x(1) + 0.5_wp*at%x(2)**2]
      associate (unused_system => self)
      end associate
   end subroutine tangent_constraint

   subroutine tangent_jacobian(self, at, a)
      class(tangent_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)

      a(1, :) = [1.0_wp, 0.0_wp]
      a(2, :) = [1.0_wp, at%x(2)]
      associate (unused_system => self)
      end associate
   end subroutine tangent_jacobian

   subroutine tangent_acceleration_rhs(self, at, value)
      class(tangent_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = [0.0_wp, -at%v(2)**2]
      associate (unused_system => self)
      end associate
   end subroutine tangent_acceleration_rhs

   !> The length is kept to the tolerance of a pendulum of length 1, and with it the motion and its steps.
   subroutine any_length(failure)
      character(:), allocatable, intent(inout) :: failure
      type(bob_t) :: model
      type(state_t) :: at
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      real(wp) :: x(2)
      integer :: form, i, steps

      call model%define(n=2, c=1, mass_blocks=[1, 1])
      do form = 1, 2
         model%root = form == 2
         do i = 1, size(lengths)
            model%l = lengths(i)
            options%rtol = 1.0e-6_wp
            options%atol = 1.0e-9_wp*model%l
            at = state_t(x=[model%l, 0.0_wp], v=[0.0_wp, 0.0_wp])
            call simulate(model, at, 100.0_wp, result, error, options=options)
            call no_error(failure, error)
            if (allocated(failure)) return
            at%x = at%x/model%l
            if (i == 1) then
               x = at%x
               steps = result%steps
            end if
            call check_below(failure, abs(norm2(at%x) - 1.0_wp), 2.0e-12_wp, 'the length of '//to_text(model%l))
            call check_below(failure, maxval(abs(at%x - x)), 1.0e-8_wp, 'the motion of '//to_text(model%l))
            call check(failure, abs(result%steps - steps) <= 2, 'its steps: '//to_text(result%steps)//', '//to_text(steps))
         end do
      end do
   end subroutine any_length

   !> Coordinates that are far smaller than what is behind them ask for no more than round-off gives.
   subroutine small_displacements(failure)
      character(:), allocatable, intent(inout) :: failure
      type(displaced_t) :: model
      type(state_t) :: at
      type(integration_result_t) :: result
      type(error_t), allocatable :: error

      call model%define(n=2, c=1, mass_blocks=[1, 1])
      at = state_t(x=[0.0_wp, 1.0e-12_wp], v=[0.0_wp, 1.0e-12_wp])
      model%l = 1.0e-12_wp
      call simulate(model, at, 0.3_wp, result, error, options=integration_options_t(atol=1.0e-18_wp))
      call no_error(failure, error)
      call check(failure, result%status == status_reached_end, 'it stops')
      call check_below(failure, abs(hypot(at%x(1) + 1.0_wp, at%x(2)) - 1.0_wp), 1.0e-15_wp, 'the length')
   end subroutine small_displacements

   !> No faults where there are none, and those that are.
   subroutine verified(failure)
      character(:), allocatable, intent(inout) :: failure
      type(bob_t) :: model
      type(state_t) :: at
      type(finding_t), allocatable :: findings(:)
      type(error_t), allocatable :: error
      integer :: form, i

      call model%define(n=2, c=1, mass_blocks=[1, 1])
      do form = 1, 2
         model%root = form == 2
         do i = 1, size(lengths)
            model%l = lengths(i)
            at = state_t(x=[0.6_wp, -0.8_wp]*model%l, v=[0.4_wp, 0.3_wp]*model%l)
            model%factor = 1.0_wp
            call verify(model, at, findings, error)
            call no_error(failure, error)
            if (allocated(failure)) return
            if (size(findings) > 0) call check(failure, .false., findings(1)%message)
            model%factor = 0.99_wp
            call verify(model, at, findings, error)
            call check(failure, any(findings%what == "b''"), 'a wrong b'''' passes at the length '//to_text(model%l))
         end do
      end do
   end subroutine verified

   !> Beside the point where the curves touch, one row is passed over, and only it can tell where the way back is.
   subroutine passed_over(failure)
      character(:), allocatable, intent(inout) :: failure
      type(tangent_t) :: model
      type(projector_t) :: projector
      type(state_t) :: at
      type(method_t) :: method
      character(len=16), parameter :: solvers(3) = [character(len=16) :: 'pivoted-cholesky', 'banded', 'factor']
      integer :: i, info

      call model%define(n=2, c=2, mass_blocks=[1, 1])
      do i = 1, size(solvers)
         method%solver = solvers(i)
         call projector%init(model, method)
         at = state_t(x=[0.0_wp, 1.0_wp], v=[0.0_wp, 0.0_wp])
         call projector%linear%linearize(model, at, info, 0.0_wp)
         call projector%look(model, at)
         at%x(2) = 1.0e-5_wp
         call projector%position(model, at, info)
         call check(failure, info == rhs_no_projection, 'it is met at once by '//trim(solvers(i)))
         call projector%position_again(model, at, info)
         call check(failure, info == rhs_ok, 'it is not met by '//trim(solvers(i)))
         call check_below(failure, abs(at%x(2)), 1.5e-6_wp, 'the way back by '//trim(solvers(i)))
         deallocate (projector%linear%onto)
      end do
   end subroutine passed_over

end module test_units
