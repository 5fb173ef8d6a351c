!> Tests of the methods.
module test_constrained
   use testing, only: test_t
   implicit none (type, external)
   private
   public :: collect_constrained

contains

   !> All tests of this module.
   function collect_constrained() result(tests)
      type(test_t), allocatable :: tests(:)

      allocate (tests(0))
   end function collect_constrained

end module test_constrained
