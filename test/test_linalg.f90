!> Tests of the matrices.
module test_linalg
   use testing, only: test_t
   implicit none (type, external)
   private
   public :: collect_linalg

contains

   !> All tests of this module.
   function collect_linalg() result(tests)
      type(test_t), allocatable :: tests(:)

      allocate (tests(0))
   end function collect_linalg

end module test_linalg
