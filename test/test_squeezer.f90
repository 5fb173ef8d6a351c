!> Andrews' squeezing mechanism as a user's system: its derivatives, its start and its motion against published values.
module test_squeezer
   use squeezer, only: end_angles, end_velocities, new_squeezer, squeezer_start, squeezer_t
   use taut, only: constrained_ode_t, error_t, finding_t, integration_options_t, integration_result_t, method_t, simulate, &
                   state_t, verify, wp
   use taut_constrained_method_choose, only: new_constrained_ode
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_squeezer

contains

   !> All tests of this module.
   function collect_squeezer() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('the system passes the checker', is_consistent), &
               new_test('published accelerations and forces at the start', start_accelerations), &
               new_test('published motion', motion)]
   end function collect_squeezer

   subroutine is_consistent(failure)
      character(:), allocatable, intent(inout) :: failure
      type(squeezer_t) :: system
      type(state_t) :: at
      type(finding_t), allocatable :: findings(:)
      type(error_t), allocatable :: error
      integer :: i

      system = new_squeezer()
      at = squeezer_start()
      at%x = at%x + [0.3_wp, -0.2_wp, 0.1_wp, 0.4_wp, -0.3_wp, 0.2_wp, 0.1_wp]
      at%v = [30.0_wp, -40.0_wp, 3.0_wp, 5.0_wp, 2.0_wp, -4.0_wp, 1.0_wp]
      call verify(system, at, findings, error)
      call no_error(failure, error)
      do i = 1, size(findings)
         call check(failure, .false., findings(i)%message)
      end do
   end subroutine is_consistent

   subroutine start_accelerations(failure)
      character(:), allocatable, intent(inout) :: failure
      type(squeezer_t) :: system
      class(constrained_ode_t), allocatable :: ode
      type(method_t) :: method
      type(error_t), allocatable :: error
      real(wp) :: rate(14), y(14)
      integer :: info

      system = new_squeezer()
      call new_constrained_ode(ode, system, method, error)
      call no_error(failure, error)
      call ode%pack(squeezer_start(), y)
      call ode%rhs(0.0_wp, y, rate, info)
      call check_close(failure, rate(8), 14222.4439199541138_wp, 1.0e-6_wp, 'acceleration of beta')
      call check_close(failure, rate(9), -10666.8329399655854_wp, 1.0e-6_wp, 'acceleration of Theta')
      call check_below(failure, maxval(abs(rate(10:14))), 1.0e-6_wp, 'the other accelerations')
   end subroutine start_accelerations

   subroutine motion(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=8), parameter :: weights(2) = [character(len=8) :: 'identity', 'mass']
      type(squeezer_t) :: system
      type(state_t) :: at
      type(method_t) :: method
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      real(wp) :: phi(6)
      integer :: i

      system = new_squeezer()
      options%rtol = 1.0e-9_wp
      options%atol = 1.0e-9_wp
      do i = 1, 2
         method%weight = weights(i)
         at = squeezer_start()
         call simulate(system, at, 0.03_wp, result, error, method, options)
         call no_error(failure, error)
         call check_below(failure, maxval(abs(at%x - end_angles)), 1.0e-7_wp, 'angles, weight '//weights(i))
         call check_below(failure, maxval(abs(at%v - end_velocities)), 1.0e-4_wp, 'velocities, weight '//weights(i))
         call system%constraint(at, phi)
         call check_below(failure, maxval(abs(phi)), 1.0e-12_wp, 'the loops are closed')
      end do
   end subroutine motion

end module test_squeezer
