!> The classical Runge-Kutta method with steps of one length, as everyone has written it once: with constraints it is the same,
!> but for one line behind each step.
module classical
   use taut
   use problems
   implicit none (type, external)
   real(wp), parameter :: h = 2.5e-4_wp                              ! [s]; the stiff problem's damper allows no more

contains

   subroutine rk4(problem, y, log)
      type(constrained_problem_t), intent(inout), target :: problem
      real(wp), intent(inout), contiguous, target :: y(:)
      type(log_t), intent(inout) :: log
      real(wp), dimension(size(y)) :: k1, k2, k3, k4
      real(wp) :: t
      integer :: i
      do i = 1, nint((t_end - problem%t)/h)
         t = problem%t + (i - 1)*h
         call problem%rhs(t, y, k1)
         call problem%rhs(t + h/2, y + h/2*k1, k2)
         call problem%rhs(t + h/2, y + h/2*k2, k3)
         call problem%rhs(t + h, y + h*k3, k4)
         y = y + h/6*(k1 + 2*k2 + 2*k3 + k4)
         call problem%project(t + h, y)                              ! the one line
         call log%see(problem, t + h, y)
      end do
   end subroutine rk4

end module classical

program runge_kutta
   use problems
   use classical
   implicit none (type, external)
   call compare('RK4', rk4, [pendulum, loop, stiff], [character(6) :: 'dopri5', 'dopri5', 'radau'])
end program runge_kutta
