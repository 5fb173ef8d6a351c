!> An implicit code that balances forces: Newmark's method of constant average acceleration, with Newton's iteration. Constraints
!! are a loop around what it had: velocities and forces of its balance are what Eqs (19) make of them, and the state at the end of
!! a step is projected.
module newmark_method
   use taut
   use problems
   implicit none (type, external)
   real(wp), parameter :: h = 1.0e-3_wp                              ! [s]

contains

   subroutine newmark(problem, y, log)
      type(constrained_problem_t), intent(inout), target :: problem
      real(wp), intent(inout), contiguous, target :: y(:)
      type(log_t), intent(inout) :: log
      real(wp), dimension(size(y)) :: old, old_rate, d, scale
      real(wp), dimension(size(y), size(y)) :: jacobian, matrix
      real(wp) :: t
      integer :: i, info, iteration, pivots(size(y))
      scale = [0.0_wp*log%mass + 1.0_wp, log%mass]                   ! of x and of M v
      iteration = huge(iteration)
      do i = 1, nint((t_end - problem%t)/h)
         t = problem%t + i*h
         old = y
         old_rate = rates(t - h, y)
         y = old + h*old_rate/scale
         if (iteration > 4) call linearize()
         do iteration = 1, 25
            d = balance_of(t, y)
            matrix = jacobian
            call dgesv(size(y), 1, matrix, size(y), pivots, d, size(y), info)
            y = y - d
            if (maxval(abs(d)) <= 1.0e-12_wp) exit
            if (iteration == 8) call linearize()
         end do
         call problem%project(t, y)
         call log%see(problem, t, y)
      end do

   contains

      !> {xdot; f} with the constraints in them.
      function rates(t, y) result(rate)
         real(wp), intent(in) :: t, y(:)
         real(wp) :: rate(size(y))
         integer :: n
         n = size(y)/2
         call problem%balance(t, y, rate(:n), rate(n + 1:))
      end function rates

      !> What is to vanish: x - x0 - h/2 (xdot0 + xdot) and M (v - v0) - h/2 (f0 + f).
      function balance_of(t, y) result(g)
         real(wp), intent(in) :: t, y(:)
         real(wp) :: g(size(y))
         g = scale*(y - old) - h/2*(old_rate + rates(t, y))
      end function balance_of

      !> Its derivatives, by differences.
      subroutine linearize()
         real(wp) :: here(size(y)), there(size(y)), step
         integer :: j
         here = balance_of(t, y)
         do j = 1, size(y)
            step = 1.0e-7_wp*max(1.0_wp, abs(y(j)))
            there = y
            there(j) = y(j) + step
            jacobian(:, j) = (balance_of(t, there) - here)/step
         end do
         log%jacobians = log%jacobians + 1
      end subroutine linearize

   end subroutine newmark

end module newmark_method

program implicit_code
   use problems
   use newmark_method
   implicit none (type, external)
   call compare('Newmark', newmark, [pendulum, loop, stiff], [character(6) :: 'dopri5', 'dopri5', 'radau'])
end program implicit_code
