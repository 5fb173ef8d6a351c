!> The Runge-Kutta pair of order 5(4) of Dormand and Prince with its continuous extension of order 4.
!!
!! Source of the coefficients: J.R. Dormand, P.J. Prince, A family of embedded Runge-Kutta formulae, J. Comput. Appl. Math. 6
!! (1980) 19-26, RK5(4)7M; continuous extension: E. Hairer, S.P. Norsett, G. Wanner, Solving Ordinary Differential Equations I,
!! 2nd ed., Springer 1993, Sect. II.6.
module taut_ode_stepper_dormand_prince
   use taut_kinds, only: wp
   use taut_ode_step_control, only: controller_constants_t
   use taut_ode_stepper_explicit_pair, only: explicit_pair_t
   use taut_ode_system, only: ode_system_t, rhs_ok
   implicit none (type, external)
   private
   public :: dormand_prince_t

   !> Number of stages; the last one is evaluated at the new state ('first same as last').
   integer, parameter :: stages = 7
   !> Order of the solution that is continued.
   integer, parameter :: order = 5

   !> Nodes c_i.
   real(wp), parameter :: node(stages) = &
      [0.0_wp, 1.0_wp/5.0_wp, 3.0_wp/10.0_wp, 4.0_wp/5.0_wp, 8.0_wp/9.0_wp, 1.0_wp, 1.0_wp]

   !> Coefficients a_ij, one column per stage i; the last column holds the weights of order 5.
   real(wp), parameter :: a(6, stages) = reshape([ &
      0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      1.0_wp/5.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      3.0_wp/40.0_wp, 9.0_wp/40.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      44.0_wp/45.0_wp, -56.0_wp/15.0_wp, 32.0_wp/9.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
      19372.0_wp/6561.0_wp, -25360.0_wp/2187.0_wp, 64448.0_wp/6561.0_wp, -212.0_wp/729.0_wp, 0.0_wp, 0.0_wp, &
      9017.0_wp/3168.0_wp, -355.0_wp/33.0_wp, 46732.0_wp/5247.0_wp, 49.0_wp/176.0_wp, -5103.0_wp/18656.0_wp, 0.0_wp, &
      35.0_wp/384.0_wp, 0.0_wp, 500.0_wp/1113.0_wp, 125.0_wp/192.0_wp, -2187.0_wp/6784.0_wp, 11.0_wp/84.0_wp], [6, stages])

   !> Weights of order 5 less those of order 4.
   real(wp), parameter :: e(stages) = &
      [71.0_wp/57600.0_wp, 0.0_wp, -71.0_wp/16695.0_wp, 71.0_wp/1920.0_wp, -17253.0_wp/339200.0_wp, &
       22.0_wp/525.0_wp, -1.0_wp/40.0_wp]

   !> Weights of the highest term of the continuous extension.
   real(wp), parameter :: d(stages) = &
      [-12715105075.0_wp/11282082432.0_wp, 0.0_wp, 87487479700.0_wp/32700410799.0_wp, &
       -10690763975.0_wp/1880347072.0_wp, 701980252875.0_wp/199316789632.0_wp, &
       -1453857185.0_wp/822651844.0_wp, 69997945.0_wp/29380423.0_wp]

   !> The pair; the parts of its continuous extension: (n, 5).
   type, extends(explicit_pair_t) :: dormand_prince_t
      real(wp), allocatable, private :: dense(:, :)
      !> Those of the integral that goes along.
      real(wp), private :: dense_integral(5) = 0.0_wp
   contains
      procedure :: init
      procedure :: prepare_dense
      procedure :: interpolate
      procedure :: integral_inside
      procedure, nopass :: estimate
   end type dormand_prince_t

contains

   !> Allocates the workspace.
   subroutine init(self, n)
      !> The pair.
      class(dormand_prince_t), intent(inout) :: self
      !> Size of the state.
      integer, intent(in) :: n

      self%order = order
      ! Those of the code DOPRI5 of the book.
      self%constants = controller_constants_t(exponent=1.0_wp/order - 0.75_wp*0.04_wp, memory=0.04_wp, &
                                              largest_decrease=0.2_wp, largest_increase=10.0_wp)
      self%stability_bound = 3.25_wp
      call self%set_tableau(n, stages, node, a, 1)
      allocate (self%dense(n, 5), source=0.0_wp)
   end subroutine init

   !> The solution of order 5 less that of order 4.
   pure subroutine estimate(h, k, error)
      !> Step [s].
      real(wp), intent(in) :: h
      !> Derivatives of all stages: (n, stages).
      real(wp), intent(in), contiguous :: k(:, :)
      !> Estimate of the local error: (n, 1).
      real(wp), intent(out), contiguous :: error(:, :)
      integer :: i

      do i = 1, size(error, 1)
         error(i, 1) = h*(e(1)*k(i, 1) + e(3)*k(i, 3) + e(4)*k(i, 4) + e(5)*k(i, 5) + e(6)*k(i, 6) + e(7)*k(i, 7))
      end do
   end subroutine estimate

   !> The continuous extension of order 4, from the end state that is really continued (projected or not).
   subroutine prepare_dense(self, ode, t, y, t_new, h, y_new, info)
      !> The pair.
      class(dormand_prince_t), intent(inout) :: self
      !> What is integrated: not asked.
      class(ode_system_t), intent(inout) :: ode
      !> Time at the step's start [s].
      real(wp), intent(in) :: t
      !> State at the step's start: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Time at the step's end [s].
      real(wp), intent(in) :: t_new
      !> The step's length [s].
      real(wp), intent(in) :: h
      !> State at the step's end: (n).
      real(wp), intent(in), contiguous :: y_new(:)
      !> Always `rhs_ok`.
      integer, intent(out) :: info
      integer :: i
      real(wp) :: difference, slope

      info = rhs_ok
      associate (k => self%k, dense => self%dense)
         do i = 1, size(y)
            difference = y_new(i) - y(i)
            slope = h*k(i, 1) - difference
            dense(i, 1) = y(i)
            dense(i, 2) = difference
            dense(i, 3) = slope
            dense(i, 4) = difference - h*k(i, 7) - slope
            dense(i, 5) = h*(d(1)*k(i, 1) + d(3)*k(i, 3) + d(4)*k(i, 4) + d(5)*k(i, 5) + d(6)*k(i, 6) + d(7)*k(i, 7))
         end do
      end associate
      associate (q => self%integrand(1, :), parts => self%dense_integral)
         parts(2) = self%gain
         parts(3) = h*q(1) - self%gain
         parts(4) = self%gain - h*q(stages) - parts(3)
         parts(5) = h*dot_product(d, q(:stages))
      end associate
      associate (unused_system => ode, unused_start => t, unused_end => t_new)
      end associate
   end subroutine prepare_dense

   !> The continuous extension at a fraction of the step.
   subroutine interpolate(self, theta, y)
      !> The pair.
      class(dormand_prince_t), intent(in) :: self
      !> Fraction of the step, 0 at its start and 1 at its end.
      real(wp), intent(in) :: theta
      !> State: (n).
      real(wp), intent(out), contiguous :: y(:)
      real(wp) :: rest
      integer :: i

      rest = 1.0_wp - theta
      associate (dense => self%dense)
         do i = 1, size(y)
            y(i) = dense(i, 1) + theta*(dense(i, 2) + rest*(dense(i, 3) + theta*(dense(i, 4) + rest*dense(i, 5))))
         end do
      end associate
   end subroutine interpolate

   !> The continuous extension of the integral that goes along.
   pure function integral_inside(self, h, theta) result(value)
      !> The pair, behind `prepare_dense`.
      class(dormand_prince_t), intent(in) :: self
      !> The step's length: not asked.
      real(wp), intent(in) :: h
      !> Fraction of the step.
      real(wp), intent(in) :: theta
      !> The integral, zero at the step's start.
      real(wp) :: value
      real(wp) :: rest

      rest = 1.0_wp - theta
      associate (parts => self%dense_integral)
         value = theta*(parts(2) + rest*(parts(3) + theta*(parts(4) + rest*parts(5))))
      end associate
      associate (unused_step => h)
      end associate
   end function integral_inside

end module taut_ode_stepper_dormand_prince
