!> What a system has to supply, and what it has by default.
module test_system
   use taut, only: block_diagonal_t, equilibrium, equilibrium_result_t, error_t, finding_t, integration_result_t, &
                   mechanical_system_t, simulate, state_t, verify, wp
   use testing, only: check, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_system

   !> A free point mass in the plane: the least that a system can be.
   type, extends(mechanical_system_t) :: free_t
   contains
      procedure :: mass
      procedure :: force
   end type free_t

   !> On the line x2 = x1/2, its A stated by pattern and entries.
   type, extends(free_t) :: guided_t
   contains
      procedure :: constraint
      procedure :: pattern
      procedure :: jacobian_entries
      procedure :: acceleration_rhs
   end type guided_t

   !> Only a pattern, and the right-hand side of the accelerations.
   type, extends(free_t) :: no_entries_t
   contains
      procedure :: pattern => no_entries_pattern
      procedure :: acceleration_rhs => no_entries_rhs
   end type no_entries_t

   !> Neither a pattern nor a procedure `jacobian`.
   type, extends(guided_t) :: no_jacobian_t
   contains
      procedure :: pattern => nothing
   end type no_jacobian_t

contains

   !> All tests of this module.
   function collect_system() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('mass and force are enough without constraints', least), &
               new_test('the whole of A comes from its entries', scattered), &
               new_test('what is missing is named', missing)]
   end function collect_system

   subroutine least(failure)
      character(:), allocatable, intent(inout) :: failure
      type(free_t) :: system
      type(state_t) :: at
      type(integration_result_t) :: result
      type(error_t), allocatable :: error

      call system%define(n=2, c=0)
      at = start()
      call simulate(system, at, 1.0_wp, result, error)
      call no_error(failure, error)
      call check_close(failure, at%x(2), -0.5_wp*9.81_wp, 1.0e-9_wp, 'a free fall')
   end subroutine least

   subroutine scattered(failure)
      character(:), allocatable, intent(inout) :: failure
      type(guided_t) :: system
      type(finding_t), allocatable :: findings(:)
      type(state_t) :: at
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      real(wp) :: a(1, 2)

      call system%define(n=2, c=1)
      at = start()
      call system%jacobian(at, a)
      call check(failure, all(abs(a - reshape([-0.5_wp, 1.0_wp], [1, 2])) <= 0.0_wp), 'all of A')
      call verify(system, at, findings, error)
      call no_error(failure, error)
      call check(failure, size(findings) == 0, 'the checker agrees')
      call simulate(system, at, 1.0_wp, result, error)
      call no_error(failure, error)
      ! Along the slope of 1/2: xddot = -g s c with s = 1/sqrt(5), c = 2/sqrt(5).
      call check_close(failure, at%x(1), -0.5_wp*9.81_wp*0.4_wp, 1.0e-9_wp, 'a slide')
   end subroutine scattered

   subroutine missing(failure)
      character(:), allocatable, intent(inout) :: failure
      type(free_t) :: bare
      type(no_entries_t) :: nonholonomic
      type(no_jacobian_t) :: without_a
      type(equilibrium_result_t) :: rest
      type(finding_t), allocatable :: findings(:)
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error

      call bare%define(n=2, c=1)
      at = start()
      call simulate(bare, at, 1.0_wp, result, error)
      call named('no procedure constraint')
      call equilibrium(bare, at, rest, error)
      call named('no procedure constraint')
      at = start()
      call verify(bare, at, findings, error)
      call named('no procedure constraint')
      call bare%define(n=2, c=1, nonholonomic=1)
      call simulate(bare, at, 1.0_wp, result, error)
      call named('no procedure acceleration_rhs')
      call nonholonomic%define(n=2, c=1, nonholonomic=1)
      call simulate(nonholonomic, at, 1.0_wp, result, error)
      call named('no procedure jacobian_entries')
      call without_a%define(n=2, c=1)
      call simulate(without_a, at, 1.0_wp, result, error)
      call named('no procedure jacobian;')

   contains

      !> The error says so.
      subroutine named(text)
         character(*), intent(in) :: text

         call check(failure, allocated(error), text//': told')
         if (.not. allocated(error)) return
         call check(failure, index(error%line(), text) > 0, text//': '//error%line())
         deallocate (error)
      end subroutine named

   end subroutine missing

   function start() result(at)
      type(state_t) :: at

      at%x = [0.0_wp, 0.0_wp]
      at%v = [0.0_wp, 0.0_wp]
   end function start

   subroutine mass(self, at, m)
      class(free_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m

      call m%set_diagonal([2.0_wp, 2.0_wp])
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine mass

   subroutine force(self, at, value)
      class(free_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = [0.0_wp, -2.0_wp*9.81_wp]
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine force

   subroutine constraint(self, at, value)
      class(guided_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(1) = at%x(2) - 0.5_wp*at%x(1)
      associate (unused_system => self)
      end associate
   end subroutine constraint

   subroutine pattern(self, first, column)
      class(guided_t), intent(in) :: self
      integer, allocatable, intent(out) :: first(:)
      integer, allocatable, intent(out) :: column(:)

      first = [1, 3]
      column = [1, 2]
      associate (unused_system => self)
      end associate
   end subroutine pattern

   subroutine no_entries_pattern(self, first, column)
      class(no_entries_t), intent(in) :: self
      integer, allocatable, intent(out) :: first(:)
      integer, allocatable, intent(out) :: column(:)

      first = [1, 3]
      column = [1, 2]
      associate (unused_system => self)
      end associate
   end subroutine no_entries_pattern

   subroutine no_entries_rhs(self, at, value)
      class(no_entries_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(1) = 0.0_wp
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine no_entries_rhs

   !> States no pattern.
   subroutine nothing(self, first, column)
      class(no_jacobian_t), intent(in) :: self
      integer, allocatable, intent(out) :: first(:)
      integer, allocatable, intent(out) :: column(:)

      associate (unused_system => self, unused_first => first, unused_column => column)
      end associate
   end subroutine nothing

   subroutine jacobian_entries(self, at, values)
      class(guided_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: values(:)

      values = [-0.5_wp, 1.0_wp]
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine jacobian_entries

   subroutine acceleration_rhs(self, at, value)
      class(guided_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(1) = 0.0_wp
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine acceleration_rhs

end module test_system
