!> Tests of case files.
module test_case
   use testing, only: test_t
   implicit none (type, external)
   private
   public :: collect_case

contains

   !> All tests of this module.
   function collect_case() result(tests)
      type(test_t), allocatable :: tests(:)

      allocate (tests(0))
   end function collect_case

end module test_case
