!> A small test framework: suites of named tests, each of which may set an error; the tester counts and exits non-zero.
module testing
   use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
   use taut_kinds, only: wp
   use taut_error, only: error_t, to_text
   implicit none (type, external)
   private
   public :: check, check_close, check_below, no_error, test_t, new_test, run_suite, outcome_t

   !> Number of tests that passed and that failed.
   type :: outcome_t
      integer :: passed = 0, failed = 0
   end type outcome_t

   abstract interface
      !> A test; an allocated message means that it failed.
      subroutine test_procedure(failure)
         implicit none (type, external)
         character(:), allocatable, intent(inout) :: failure
      end subroutine test_procedure
   end interface

   !> A test with its name.
   type :: test_t
      character(:), allocatable :: name
      procedure(test_procedure), pointer, nopass :: run => null()
   end type test_t

contains

   !> A named test.
   function new_test(name, run) result(test)
      character(*), intent(in) :: name
      procedure(test_procedure) :: run
      type(test_t) :: test

      test%name = name
      test%run => run
   end function new_test

   !> Runs all tests of a suite, or those whose name contains a text.
   subroutine run_suite(suite, tests, only, outcome)
      character(*), intent(in) :: suite
      type(test_t), intent(in) :: tests(:)
      character(*), intent(in) :: only
      type(outcome_t), intent(inout) :: outcome
      character(:), allocatable :: failure
      integer :: i

      do i = 1, size(tests)
         if (index(suite//': '//tests(i)%name, only) == 0) cycle
         if (allocated(failure)) deallocate (failure)
         call tests(i)%run(failure)
         if (allocated(failure)) then
            outcome%failed = outcome%failed + 1
            write (error_unit, '(5a)') 'FAILED ', suite, ': ', tests(i)%name, new_line('a')//'       '//failure
         else
            outcome%passed = outcome%passed + 1
            write (output_unit, '(4a)') 'passed ', suite, ': ', tests(i)%name
         end if
      end do
   end subroutine run_suite

   !> Fails unless a condition holds.
   subroutine check(failure, condition, message)
      character(:), allocatable, intent(inout) :: failure
      logical, intent(in) :: condition
      character(*), intent(in) :: message

      if (.not. condition .and. .not. allocated(failure)) failure = message
   end subroutine check

   !> Fails unless two numbers differ by no more than a tolerance.
   subroutine check_close(failure, value, expected, tolerance, message)
      character(:), allocatable, intent(inout) :: failure
      real(wp), intent(in) :: value, expected, tolerance
      character(*), intent(in) :: message

      if (abs(value - expected) <= tolerance) return
      call check(failure, .false., message//': '//to_text(value)//' is off '//to_text(expected)//' by '// &
                 to_text(value - expected)//', allowed '//to_text(tolerance))
   end subroutine check_close

   !> Fails unless a number's size stays below a bound.
   subroutine check_below(failure, value, bound, message)
      character(:), allocatable, intent(inout) :: failure
      real(wp), intent(in) :: value, bound
      character(*), intent(in) :: message

      if (abs(value) <= bound) return
      call check(failure, .false., message//': '//to_text(value)//' is not below '//to_text(bound))
   end subroutine check_below

   !> Fails if there is an error.
   subroutine no_error(failure, error)
      character(:), allocatable, intent(inout) :: failure
      type(error_t), allocatable, intent(in) :: error

      if (allocated(error)) call check(failure, .false., 'unexpected error: '//error%line())
   end subroutine no_error

end module testing
