!> Tests of the checker of user systems.
module test_verify
   use testing, only: test_t
   implicit none (type, external)
   private
   public :: collect_verify

contains

   !> All tests of this module.
   function collect_verify() result(tests)
      type(test_t), allocatable :: tests(:)

      allocate (tests(0))
   end function collect_verify

end module test_verify
