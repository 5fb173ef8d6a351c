!> What CVODE and ARKODE share: the right-hand side as they call it, and their vector, matrix and linear solver for it.
module sundials_functions
   use, intrinsic :: iso_c_binding
   use fnvector_serial_mod
   use fsundials_context_mod
   use fsundials_linearsolver_mod
   use fsundials_matrix_mod
   use fsundials_nvector_mod
   use fsunlinsol_dense_mod
   use fsunmatrix_dense_mod
   use taut
   implicit none (type, external)

   type :: tools_t
      type(c_ptr) :: context = c_null_ptr
      type(N_Vector), pointer :: y => null()
      type(SUNMatrix), pointer :: matrix => null()
      type(SUNLinearSolver), pointer :: solver => null()
   contains
      procedure :: make, free
   end type tools_t

contains

   !> ydot = F(t, y); a positive answer asks for a smaller step.
   integer(c_int) function rates(t, y, dydt, data) bind(c)
      real(c_double), value :: t
      type(N_Vector) :: y, dydt
      type(c_ptr), value :: data
      type(constrained_problem_t), pointer :: problem
      integer :: info
      call c_f_pointer(data, problem)
      call problem%rhs(t, FN_VGetArrayPointer(y), FN_VGetArrayPointer(dydt), info)
      rates = int(info, c_int)
   end function rates

   subroutine make(tools, y)
      class(tools_t), intent(inout) :: tools
      real(wp), intent(inout), contiguous, target :: y(:)
      integer(c_int64_t) :: n
      integer(c_int) :: answer
      n = size(y)
      answer = FSUNContext_Create(c_null_ptr, tools%context)
      tools%y => FN_VMake_Serial(n, y, tools%context)
      tools%matrix => FSUNDenseMatrix(n, n, tools%context)
      tools%solver => FSUNLinSol_Dense(tools%y, tools%matrix, tools%context)
      if (answer /= 0 .or. .not. associated(tools%solver)) error stop 'SUNDIALS is not ready'
   end subroutine make

   subroutine free(tools)
      class(tools_t), intent(inout) :: tools
      integer(c_int) :: answer
      answer = FSUNLinSolFree(tools%solver)
      call FSUNMatDestroy(tools%matrix)
      call FN_VDestroy(tools%y)
      answer = FSUNContext_Free(tools%context)
   end subroutine free

end module sundials_functions
