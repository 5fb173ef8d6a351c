!> Steps that do not get on: a fault of the system is found and named, a system that is right goes on.
module test_doubt
   use taut, only: block_diagonal_t, error_t, integration_options_t, integration_result_t, mechanical_system_t, simulate, state_t, &
                   status_no_progress, status_too_many_steps, wp
   use testing, only: check, new_test, test_t
   implicit none (type, external)
   private
   public :: collect_doubt

   !> A damper so strong that steps do not get on, and beside it a bead on the parabola x_3 = x_2^2.
   type, extends(mechanical_system_t) :: bead_t
      !> Factor of the entry of A that may be wrong.
      real(wp) :: factor = 1.0_wp
   contains
      procedure :: mass
      procedure :: force
      procedure :: constraint
      procedure :: jacobian
      procedure :: acceleration_rhs
   end type bead_t

contains

   !> All tests of this module.
   function collect_doubt() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('a fault ends the run and is named', fault), &
               new_test('without a fault it goes on, with a note', no_fault)]
   end function collect_doubt

   subroutine mass(self, at, m)
      class(bead_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m

      call m%set_diagonal([1.0_wp, 1.0_wp, 1.0_wp])
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine mass

   subroutine force(self, at, value)
      class(bead_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = [-1.0e10_wp*(at%v(1) - cos(at%t)), 0.0_wp, -1.0_wp]
      associate (unused_system => self)
      end associate
   end subroutine force

   subroutine constraint(self, at, value)
      class(bead_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(1) = at%x(3) - at%x(2)**2
      associate (unused_system => self)
      end associate
   end subroutine constraint

   subroutine jacobian(self, at, a)
      class(bead_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)

      a(1, :) = [0.0_wp, -2.0_wp*self%factor*at%x(2), 1.0_wp]
   end subroutine jacobian

   subroutine acceleration_rhs(self, at, value)
      class(bead_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(1) = 2.0_wp*at%v(2)**2
      associate (unused_system => self)
      end associate
   end subroutine acceleration_rhs

   !> A bead for a hundred seconds, of which none will pass.
   subroutine slide(factor, result, error)
      real(wp), intent(in) :: factor
      type(integration_result_t), intent(out) :: result
      type(error_t), allocatable, intent(inout) :: error
      type(bead_t) :: bead
      type(state_t) :: at

      bead%factor = factor
      call bead%define(n=3, c=1, mass_blocks=[1, 1, 1], constant_mass=.true.)
      at%x = [0.0_wp, 0.5_wp, 0.25_wp]
      at%v = [1.0_wp, 0.2_wp, 0.2_wp*factor]
      call simulate(bead, at, 100.0_wp, result, error, options=integration_options_t(max_steps=6000), look=.false.)
   end subroutine slide

   subroutine fault(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_result_t) :: result
      type(error_t), allocatable :: error

      call slide(1.001_wp, result, error)
      call check(failure, result%status == status_no_progress, 'it ends')
      call check(failure, allocated(error), 'with a reason')
      if (allocated(failure)) return
      call check(failure, index(error%what, 'A(1, 2)') > 0, error%line())
   end subroutine fault

   subroutine no_fault(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      character(:), allocatable :: text

      call slide(1.0_wp, result, error)
      call check(failure, result%status == status_too_many_steps, 'it goes on')
      call check(failure, size(result%notes) > 0, 'with a note')
      if (allocated(failure)) return
      text = result%notes(size(result%notes))%text()
      call check(failure, index(text, 'hardly get on') > 0, text)
   end subroutine no_fault

end module test_doubt
