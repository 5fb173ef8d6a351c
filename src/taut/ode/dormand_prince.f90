!> The Runge-Kutta pair of order 5(4) of Dormand and Prince with its continuous extension of order 4.
!!
!! Source of the coefficients: J.R. Dormand, P.J. Prince, A family of embedded Runge-Kutta formulae, J. Comput. Appl. Math. 6
!! (1980) 19-26, RK5(4)7M; continuous extension: E. Hairer, S.P. Norsett, G. Wanner, Solving Ordinary Differential Equations I,
!! 2nd ed., Springer 1993, Sect. II.6.
module taut_ode_dormand_prince
   use taut_kinds, only: wp
   implicit none (type, external)
   private
   public :: stages, order, node, stage_state, error_estimate, dense_coefficients, dense_value

   !> Number of stages; the last one is evaluated at the new state ('first same as last').
   integer, parameter :: stages = 7
   !> Order of the solution that is continued.
   integer, parameter :: order = 5

   !> Nodes c_i.
   real(wp), parameter :: node(stages) = &
      [0.0_wp, 1.0_wp/5.0_wp, 3.0_wp/10.0_wp, 4.0_wp/5.0_wp, 8.0_wp/9.0_wp, 1.0_wp, 1.0_wp]

   !> Coefficients a_ij, one column per stage i; the last column holds the weights of order 5.
   real(wp), parameter :: a(6, 2:stages) = reshape([ &
      1.0_wp/5.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      3.0_wp/40.0_wp, 9.0_wp/40.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      44.0_wp/45.0_wp, -56.0_wp/15.0_wp, 32.0_wp/9.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      19372.0_wp/6561.0_wp, -25360.0_wp/2187.0_wp, 64448.0_wp/6561.0_wp, -212.0_wp/729.0_wp, 0.0_wp, 0.0_wp, &
      9017.0_wp/3168.0_wp, -355.0_wp/33.0_wp, 46732.0_wp/5247.0_wp, 49.0_wp/176.0_wp, -5103.0_wp/18656.0_wp, 0.0_wp, &
      35.0_wp/384.0_wp, 0.0_wp, 500.0_wp/1113.0_wp, 125.0_wp/192.0_wp, -2187.0_wp/6784.0_wp, 11.0_wp/84.0_wp], [6, 6])

   !> Weights of order 5 less those of order 4.
   real(wp), parameter :: e(stages) = &
      [71.0_wp/57600.0_wp, 0.0_wp, -71.0_wp/16695.0_wp, 71.0_wp/1920.0_wp, -17253.0_wp/339200.0_wp, &
       22.0_wp/525.0_wp, -1.0_wp/40.0_wp]

   !> Weights of the highest term of the continuous extension.
   real(wp), parameter :: d(stages) = &
      [-12715105075.0_wp/11282082432.0_wp, 0.0_wp, 87487479700.0_wp/32700410799.0_wp, &
       -10690763975.0_wp/1880347072.0_wp, 701980252875.0_wp/199316789632.0_wp, &
       -1453857185.0_wp/822651844.0_wp, 69997945.0_wp/29380423.0_wp]

contains

   !> The state of a stage; for the last stage, the new state.
   pure subroutine stage_state(stage, h, y, k, y_stage)
      !> 2 to `stages`.
      integer, intent(in) :: stage
      !> Step [s].
      real(wp), intent(in) :: h
      !> State at the step's start: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Derivatives of the stages before: (n, stages).
      real(wp), intent(in), contiguous :: k(:, :)
      !> State of the stage: (n).
      real(wp), intent(out), contiguous :: y_stage(:)
      real(wp) :: c(6)
      integer :: i

      c = h*a(:, stage)
      select case (stage)
      case (2)
         do i = 1, size(y)
            y_stage(i) = y(i) + c(1)*k(i, 1)
         end do
      case (3)
         do i = 1, size(y)
            y_stage(i) = y(i) + (c(1)*k(i, 1) + c(2)*k(i, 2))
         end do
      case (4)
         do i = 1, size(y)
            y_stage(i) = y(i) + (c(1)*k(i, 1) + c(2)*k(i, 2) + c(3)*k(i, 3))
         end do
      case (5)
         do i = 1, size(y)
            y_stage(i) = y(i) + (c(1)*k(i, 1) + c(2)*k(i, 2) + c(3)*k(i, 3) + c(4)*k(i, 4))
         end do
      case (6)
         do i = 1, size(y)
            y_stage(i) = y(i) + (c(1)*k(i, 1) + c(2)*k(i, 2) + c(3)*k(i, 3) + c(4)*k(i, 4) + c(5)*k(i, 5))
         end do
      case default
         do i = 1, size(y)
            y_stage(i) = y(i) + (c(1)*k(i, 1) + c(3)*k(i, 3) + c(4)*k(i, 4) + c(5)*k(i, 5) + c(6)*k(i, 6))
         end do
      end select
   end subroutine stage_state

   !> The solution of order 5 less that of order 4.
   pure subroutine error_estimate(h, k, error)
      !> Step [s].
      real(wp), intent(in) :: h
      !> Derivatives of all stages: (n, stages).
      real(wp), intent(in), contiguous :: k(:, :)
      !> Estimate of the local error: (n).
      real(wp), intent(out), contiguous :: error(:)
      integer :: i

      do i = 1, size(error)
         error(i) = h*(e(1)*k(i, 1) + e(3)*k(i, 3) + e(4)*k(i, 4) + e(5)*k(i, 5) + e(6)*k(i, 6) + e(7)*k(i, 7))
      end do
   end subroutine error_estimate

   !> Coefficients of the continuous extension, from the end state that is really continued (projected or not).
   pure subroutine dense_coefficients(h, y0, y1, k, coefficients)
      !> Step [s].
      real(wp), intent(in) :: h
      !> States at the step's start and end: (n).
      real(wp), intent(in), contiguous :: y0(:), y1(:)
      !> Derivatives of all stages, the last one at y1: (n, stages).
      real(wp), intent(in), contiguous :: k(:, :)
      !> Coefficients: (n, 5).
      real(wp), intent(out), contiguous :: coefficients(:, :)
      integer :: i
      real(wp) :: difference, slope

      do i = 1, size(y0)
         difference = y1(i) - y0(i)
         slope = h*k(i, 1) - difference
         coefficients(i, 1) = y0(i)
         coefficients(i, 2) = difference
         coefficients(i, 3) = slope
         coefficients(i, 4) = difference - h*k(i, 7) - slope
         coefficients(i, 5) = h*(d(1)*k(i, 1) + d(3)*k(i, 3) + d(4)*k(i, 4) + d(5)*k(i, 5) + d(6)*k(i, 6) + d(7)*k(i, 7))
      end do
   end subroutine dense_coefficients

   !> The continuous extension at a fraction of the step.
   pure subroutine dense_value(theta, coefficients, y)
      !> Fraction of the step, 0 at its start and 1 at its end.
      real(wp), intent(in) :: theta
      !> Coefficients: (n, 5).
      real(wp), intent(in), contiguous :: coefficients(:, :)
      !> State: (n).
      real(wp), intent(out), contiguous :: y(:)
      real(wp) :: rest
      integer :: i

      rest = 1.0_wp - theta
      do i = 1, size(y)
         y(i) = coefficients(i, 1) + theta*(coefficients(i, 2) + rest*(coefficients(i, 3) + &
                                                                       theta*(coefficients(i, 4) + rest*coefficients(i, 5))))
      end do
   end subroutine dense_value

end module taut_ode_dormand_prince
