!> Velocities that do not fit are corrected by a blow: momentum is kept, and the energy is told.
module test_blow
   use taut, only: block_diagonal_t, constrained_ode_t, error_t, integration_result_t, mechanical_system_t, method_t, simulate, &
                   start_report_t, state_t, wp
   use testing, only: check, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_blow

   !> Masses.
   real(wp), parameter :: light = 1.0_wp, heavy = 100.0_wp

   !> Two free bodies on a line, x = {x_1, x_2}, at a distance of 1 that a drive enlarges from t = 1 on, at a rate at once.
   type, extends(mechanical_system_t) :: pair_t
      real(wp) :: rate = 0.0_wp
   contains
      procedure :: mass
      procedure :: force
      procedure :: constraint
      procedure :: jacobian
      procedure :: velocity_rhs
      procedure :: acceleration_rhs
      procedure :: breakpoints
   end type pair_t

contains

   !> All tests of this module.
   function collect_blow() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('a rope that snaps taut keeps momentum', snap), &
               new_test('redundant rows share the impulse', shared_impulse), &
               new_test('what is held takes the impulse', held_body), &
               new_test('a drive that begins at once keeps momentum, with every method', drive_begins)]
   end function collect_blow

   subroutine mass(self, at, m)
      class(pair_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m

      call m%set_diagonal([light, heavy])
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine mass

   subroutine force(self, at, value)
      class(pair_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = 0.0_wp
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine force

   subroutine constraint(self, at, value)
      class(pair_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = at%x(2) - at%x(1) - 1.0_wp - self%rate*max(0.0_wp, at%t - 1.0_wp)
   end subroutine constraint

   subroutine jacobian(self, at, a)
      class(pair_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)

      a(:, 1) = -1.0_wp
      a(:, 2) = 1.0_wp
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine jacobian

   subroutine velocity_rhs(self, at, value)
      class(pair_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = merge(self%rate, 0.0_wp, at%t > 1.0_wp)
   end subroutine velocity_rhs

   subroutine acceleration_rhs(self, at, value)
      class(pair_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = 0.0_wp
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine acceleration_rhs

   function breakpoints(self) result(times)
      class(pair_t), intent(in) :: self
      real(wp), allocatable :: times(:)

      times = [1.0_wp]
      associate (unused_system => self)
      end associate
   end function breakpoints

   !> The pair, held together by so many rows that say the same.
   function pair(rows, rate) result(system)
      integer, intent(in) :: rows
      real(wp), intent(in) :: rate
      type(pair_t) :: system

      system%rate = rate
      call system%define(n=2, c=rows, mass_blocks=[1, 1], constant_mass=.true.)
   end function pair

   !> The heavy one runs away at 1 m/s when the rope becomes taut.
   subroutine snap(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_result_t) :: result
      type(start_report_t) :: report
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp), parameter :: common = heavy/(light + heavy)

      at%x = [0.0_wp, 1.0_wp]
      at%v = [0.0_wp, 1.0_wp]
      call simulate(pair(1, 0.0_wp), at, 0.5_wp, result, error, start=report)
      call no_error(failure, error)
      call check_close(failure, at%v(1), common, 1.0e-14_wp, 'the light one')
      call check_close(failure, at%v(2), common, 1.0e-14_wp, 'the heavy one')
      call check_close(failure, report%energy_gained, -0.5_wp*light*common, 1.0e-13_wp, 'energy')
      call check_close(failure, report%impulse(1), light*common, 1.0e-13_wp, 'impulse')
   end subroutine snap

   subroutine shared_impulse(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_result_t) :: result
      type(start_report_t) :: report
      type(state_t) :: at
      type(error_t), allocatable :: error

      at%x = [0.0_wp, 1.0_wp]
      at%v = [0.0_wp, 1.0_wp]
      call simulate(pair(2, 0.0_wp), at, 0.5_wp, result, error, start=report)
      call no_error(failure, error)
      call check_close(failure, report%impulse(1), 0.5_wp*light*heavy/(light + heavy), 1.0e-13_wp, 'half of it')
      call check_close(failure, report%impulse(2), report%impulse(1), 1.0e-13_wp, 'the other half')
   end subroutine shared_impulse

   subroutine held_body(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_result_t) :: result
      type(start_report_t) :: report
      type(state_t) :: at
      type(error_t), allocatable :: error

      at%x = [0.0_wp, 1.5_wp]
      at%v = [0.0_wp, 1.0_wp]
      call simulate(pair(1, 0.0_wp), at, 0.0_wp, result, error, start=report, held=[.false., .true.])
      call no_error(failure, error)
      call check_close(failure, at%x(1), 0.5_wp, 1.0e-12_wp, 'the free one moves')
      call check(failure, abs(at%x(2) - 1.5_wp) <= 0.0_wp .and. abs(at%v(2) - 1.0_wp) <= 0.0_wp, 'the held one stays')
      call check_close(failure, at%v(1), 1.0_wp, 1.0e-14_wp, 'the free one follows')
      call check_close(failure, report%energy_gained, 0.5_wp*light, 1.0e-13_wp, 'energy from outside')
   end subroutine held_body

   subroutine drive_begins(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=21), parameter :: names(6) = [character(len=21) :: 'present', 'baseline', 'baumgarte', 'yu-chen', &
                                                  'coordinate-projection', 'braun-goldfarb']
      type(integration_result_t) :: result
      class(constrained_ode_t), allocatable :: ode
      type(method_t) :: method
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp), parameter :: rate = 0.5_wp, reduced = light*heavy/(light + heavy)
      integer :: i

      do i = 1, size(names)
         method%name = names(i)
         at = state_t()
         at%x = [0.0_wp, 1.0_wp]
         at%v = [0.0_wp, 0.0_wp]
         call simulate(pair(1, rate), at, 1.5_wp, result, error, method=method, ode=ode)
         call no_error(failure, error)
         call check_close(failure, at%v(1), -rate*reduced/light, 1.0e-12_wp, trim(names(i))//': the light one')
         call check_close(failure, at%v(2), rate*reduced/heavy, 1.0e-12_wp, trim(names(i))//': the heavy one')
         call check(failure, ode%blows%count == 1, trim(names(i))//': one blow')
         call check_close(failure, ode%blows%energy, 0.5_wp*reduced*rate**2, 1.0e-12_wp, trim(names(i))//': energy')
      end do
   end subroutine drive_begins

end module test_blow
