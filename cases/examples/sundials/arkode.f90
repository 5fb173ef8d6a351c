!> SUNDIALS' ARKODE with an explicit and with a diagonally implicit Runge-Kutta table: steps are processed by the projection.
module arkode_functions
   use farkode_mod
   use farkode_arkstep_mod
   use sundials_functions
   use problems
   implicit none (type, external)

contains

   integer(c_int) function onto_constraints(t, y, data) bind(c)
      real(c_double), value :: t
      type(N_Vector) :: y
      type(c_ptr), value :: data
      type(constrained_problem_t), pointer :: problem
      integer :: info
      call c_f_pointer(data, problem)
      call problem%project(t, FN_VGetArrayPointer(y), info)
      onto_constraints = int(info, c_int)
   end function onto_constraints

   subroutine erk(problem, y, log)
      type(constrained_problem_t), intent(inout), target :: problem
      real(wp), intent(inout), contiguous, target :: y(:)
      type(log_t), intent(inout) :: log
      call evolve(problem, y, log, c_funloc(rates), c_null_funptr, -1, ARKODE_DORMAND_PRINCE_7_4_5)
   end subroutine erk

   subroutine dirk(problem, y, log)
      type(constrained_problem_t), intent(inout), target :: problem
      real(wp), intent(inout), contiguous, target :: y(:)
      type(log_t), intent(inout) :: log
      call evolve(problem, y, log, c_null_funptr, c_funloc(rates), ARKODE_ESDIRK547L2SA2_7_4_5, -1)
   end subroutine dirk

   subroutine evolve(problem, y, log, explicit, implicit, implicit_table, explicit_table)
      type(constrained_problem_t), intent(inout), target :: problem
      real(wp), intent(inout), contiguous, target :: y(:)
      type(log_t), intent(inout) :: log
      type(c_funptr), intent(in) :: explicit, implicit
      integer(c_int), intent(in) :: implicit_table, explicit_table
      type(tools_t) :: tools
      type(c_ptr) :: memory
      real(c_double) :: t(1)
      integer(c_long) :: jacobians(1)
      integer(c_int) :: answer
      call tools%make(y)
      memory = FARKStepCreate(explicit, implicit, problem%t, tools%y, tools%context)
      answer = FARKStepSetTableNum(memory, implicit_table, explicit_table)
      answer = FARKStepSetUserData(memory, c_loc(problem))
      answer = FARKStepSStolerances(memory, 1.0e-6_wp, 1.0e-8_wp)
      if (c_associated(implicit)) answer = FARKStepSetLinearSolver(memory, tools%solver, tools%matrix)
      answer = FARKStepSetPostprocessStepFn(memory, c_funloc(onto_constraints))
      answer = FARKStepSetStopTime(memory, t_end)
      t = problem%t
      do while (t(1) < t_end)
         answer = FARKStepEvolve(memory, t_end, tools%y, t, ARK_ONE_STEP)
         if (answer < 0) error stop 'ARKODE gave up'
         call log%see(problem, t(1), y)
      end do
      if (c_associated(implicit)) then
         answer = FARKStepGetNumJacEvals(memory, jacobians)
         log%jacobians = int(jacobians(1))
      end if
      call FARKStepFree(memory)
      call tools%free()
   end subroutine evolve

end module arkode_functions

program arkode
   use problems
   use arkode_functions
   implicit none (type, external)
   character(6), parameter :: dopri5 = 'dopri5', radau = 'radau'
   call compare('ARKODE explicit', erk, [pendulum, loop], [dopri5, dopri5])
   call compare('ARKODE DIRK', dirk, [pendulum, loop, stiff], [dopri5, dopri5, radau])
end program arkode
