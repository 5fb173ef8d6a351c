!> Tests of a mechanism that a program takes from a case file.
module test_read_mechanism
   use taut, only: error_t, integration_options_t, integration_result_t, mechanism_report_t, mechanism_t, method_t, &
                   read_mechanism, simulate, state_t, wp
   use testing, only: check, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_read_mechanism

   character(*), parameter :: path = 'cases/mechanism/slider_crank.nml'

contains

   !> All tests of this module.
   function collect_read_mechanism() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('a case file as the app runs it', whole), &
               new_test('what is wrong with a file is told', faulty)]
   end function collect_read_mechanism

   !> The slider's position follows from the crank's angle.
   subroutine whole(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(method_t) :: method
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(mechanism_report_t) :: report
      type(error_t), allocatable :: error
      real(wp) :: t_end

      call read_mechanism(path, mechanism, at, error, method, options, t_end, report)
      call no_error(failure, error)
      if (allocated(failure)) return
      call check(failure, method%weight == 'mass', 'the weight of mechanisms')
      call check_close(failure, options%rtol, 1.0e-9_wp, 0.0_wp, 'its tolerance')
      call check_close(failure, t_end, 2.0_wp, 0.0_wp, 'its end')
      call check(failure, report%freedoms == 0 .and. report%rank == mechanism%c, 'its crank is driven')
      call simulate(mechanism, at, t_end, result, error, method, options)
      call no_error(failure, error)
      call check_close(failure, at%x(7), 0.1_wp*cos(20.0_wp) + sqrt(0.09_wp - (0.1_wp*sin(20.0_wp))**2), 1.0e-8_wp, 'its slider')
   end subroutine whole

   subroutine faulty(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(method_t) :: method
      type(error_t), allocatable :: error

      call read_mechanism('cases/mechanism/none.nml', mechanism, at, error, method)
      call check(failure, allocated(error), 'a file that is not there')
      if (allocated(failure)) return
      call check(failure, index(error%line(), 'cases/mechanism/none.nml') == 1, error%line())
      deallocate (error)
      call read_mechanism('cases/pendulum/figure1.nml', mechanism, at, error)
      call check(failure, allocated(error), 'a case of another app')
      if (allocated(failure)) return
      call check(failure, index(error%line(), 'cases/pendulum/figure1.nml:') == 1, error%line())
   end subroutine faulty

end module test_read_mechanism
