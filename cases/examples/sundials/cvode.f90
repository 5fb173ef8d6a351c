!> SUNDIALS' CVODE with formulas of BDF: its user function and its projection are the two calls.
module cvode_functions
   use fcvode_mod
   use sundials_functions
   use problems
   implicit none (type, external)

contains

   !> y + correction is on the constraints; of the error, what the correction takes off does not count.
   integer(c_int) function onto_constraints(t, y, correction, tolerance, error, data) bind(c)
      real(c_double), value :: t, tolerance
      type(N_Vector) :: y, correction, error
      type(c_ptr), value :: data
      type(constrained_problem_t), pointer :: problem
      real(wp), pointer :: here(:), there(:)
      integer :: info
      call c_f_pointer(data, problem)
      here => FN_VGetArrayPointer(y)
      there => FN_VGetArrayPointer(correction)
      there = here
      call problem%project(t, there, info)
      there = there - here
      if (info == 0) call problem%filter_error(FN_VGetArrayPointer(error))
      onto_constraints = int(info, c_int)
      associate (unused => tolerance)                                ! taut's own is stricter
      end associate
   end function onto_constraints

   subroutine bdf(problem, y, log)
      type(constrained_problem_t), intent(inout), target :: problem
      real(wp), intent(inout), contiguous, target :: y(:)
      type(log_t), intent(inout) :: log
      type(tools_t) :: tools
      type(c_ptr) :: memory
      real(c_double) :: t(1)
      integer(c_long) :: jacobians(1)
      integer(c_int) :: answer
      call tools%make(y)
      memory = FCVodeCreate(CV_BDF, tools%context)
      answer = FCVodeInit(memory, c_funloc(rates), problem%t, tools%y)
      answer = FCVodeSetUserData(memory, c_loc(problem))
      answer = FCVodeSStolerances(memory, 1.0e-6_wp, 1.0e-8_wp)
      answer = FCVodeSetLinearSolver(memory, tools%solver, tools%matrix)
      answer = FCVodeSetProjFn(memory, c_funloc(onto_constraints))
      answer = FCVodeSetStopTime(memory, t_end)
      t = problem%t
      do while (t(1) < t_end)
         answer = FCVode(memory, t_end, tools%y, t, CV_ONE_STEP)
         if (answer < 0) error stop 'CVODE gave up'
         call log%see(problem, t(1), y)
      end do
      answer = FCVodeGetNumJacEvals(memory, jacobians)
      log%jacobians = int(jacobians(1))
      call FCVodeFree(memory)
      call tools%free()
   end subroutine bdf

end module cvode_functions

program cvode
   use problems
   use cvode_functions
   implicit none (type, external)
   call compare('CVODE BDF', bdf, [pendulum, loop, stiff], [character(6) :: 'dopri5', 'dopri5', 'radau'])
end program cvode
