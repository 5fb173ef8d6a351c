!> Tests of the explicit pairs by their tableaus: order conditions, and the orders that a step has.
module test_explicit_pair
   use taut_kinds, only: wp
   use taut_error, only: error_t
   use taut_ode_stepper, only: stepper_t
   use taut_ode_stepper_choose, only: choose_stepper, integrator_names
   use taut_ode_stepper_explicit_pair, only: explicit_pair_t
   use taut_ode_system, only: ode_system_t, rhs_ok
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_explicit_pair, smooth_solution, smooth_t

   !> y1 = exp(sin t), y2 = 1/(1 + t^2): not autonomous and not linear.
   type, extends(ode_system_t) :: smooth_t
   contains
      procedure :: rhs => smooth_rhs
   end type smooth_t

   !> All rooted trees up to order 8: their orders, their densities gamma, and what the stages make of them.
   type :: trees_t
      integer :: count = 0, order(200) = 0
      real(wp) :: gamma(200) = 0.0_wp
      real(wp), allocatable :: weight(:, :)
   end type trees_t

   !> The derivative is the unit vector of its own number.
   type, extends(ode_system_t) :: numbered_t
      integer :: next = 0
   contains
      procedure :: rhs => numbered_rhs
   end type numbered_t

contains

   !> All tests of this module.
   function collect_explicit_pair() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('the nodes are the row sums', nodes_are_row_sums), &
               new_test('the order conditions of every pair', order_conditions), &
               new_test('the orders of a step, its estimates and its dense output', orders_of_a_step)]
   end function collect_explicit_pair

   subroutine smooth_rhs(self, t, y, dydt, info)
      class(smooth_t), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(out), contiguous :: dydt(:)
      integer, intent(out) :: info

      info = rhs_ok
      dydt = [y(1)*cos(t), -2.0_wp*t*y(2)**2]
      associate (unused => self)
      end associate
   end subroutine smooth_rhs

   pure function smooth_solution(t) result(y)
      real(wp), intent(in) :: t
      real(wp) :: y(2)

      y = [exp(sin(t)), 1.0_wp/(1.0_wp + t*t)]
   end function smooth_solution

   !> A pair by its name.
   subroutine new_pair(name, n, pair, failure)
      character(*), intent(in) :: name
      integer, intent(in) :: n
      class(explicit_pair_t), allocatable, intent(out) :: pair
      character(:), allocatable, intent(inout) :: failure
      class(stepper_t), allocatable :: stepper
      type(error_t), allocatable :: error

      call choose_stepper(name, stepper, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      select type (stepper)
      class is (explicit_pair_t)
         allocate (pair, source=stepper)
         call pair%init(n)
      end select
   end subroutine new_pair

   subroutine nodes_are_row_sums(failure)
      character(:), allocatable, intent(inout) :: failure
      class(explicit_pair_t), allocatable :: pair
      real(wp) :: y(1)
      integer :: i, j

      do j = 1, size(integrator_names)
         if (integrator_names(j) == 'radau') cycle
         call new_pair(integrator_names(j), 1, pair, failure)
         if (allocated(failure)) return
         pair%k(:, :) = 1.0_wp
         do i = 2, size(pair%node)
            call pair%stage_state(i, 1.0_wp, [0.0_wp], y)
            call check_close(failure, y(1), pair%node(i), 2.0e-14_wp, 'row sum')
         end do
         call pair%estimate(1.0_wp, pair%k, pair%error)
         call check_below(failure, maxval(abs(pair%error)), 2.0e-15_wp, 'sum of the error weights')
      end do
   end subroutine nodes_are_row_sums

   subroutine numbered_rhs(self, t, y, dydt, info)
      class(numbered_t), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(out), contiguous :: dydt(:)
      integer, intent(out) :: info

      info = rhs_ok
      dydt = 0.0_wp
      self%next = self%next + 1
      dydt(self%next) = 1.0_wp
      associate (unused_time => t, unused_state => y)
      end associate
   end subroutine numbered_rhs

   !> Adds the trees of an order whose branches, from a given one on, take `left` vertices more.
   recursive subroutine grow(trees, a, order, left, first, weight, gamma)
      type(trees_t), intent(inout) :: trees
      real(wp), intent(in) :: a(:, :)
      integer, intent(in) :: order, left, first
      real(wp), intent(in) :: weight(:), gamma
      integer :: i, known

      if (left == 0) then
         trees%count = trees%count + 1
         trees%order(trees%count) = order
         trees%gamma(trees%count) = order*gamma
         trees%weight(:, trees%count) = weight
         return
      end if
      known = trees%count
      do i = first, known
         if (trees%order(i) <= left .and. trees%order(i) < order) &
            call grow(trees, a, order, left - trees%order(i), i, weight*matmul(a, trees%weight(:, i)), gamma*trees%gamma(i))
      end do
   end subroutine grow

   !> Largest violation of sum_j b_j u_j = theta^order/gamma over the trees of orders between two bounds.
   pure real(wp) function violation(trees, b, theta, lowest, highest)
      type(trees_t), intent(in) :: trees
      real(wp), intent(in) :: b(:), theta
      integer, intent(in) :: lowest, highest
      integer :: i

      violation = 0.0_wp
      do i = 1, trees%count
         if (trees%order(i) < lowest .or. trees%order(i) > highest) cycle
         violation = max(violation, abs(dot_product(b, trees%weight(:, i)) - theta**trees%order(i)/trees%gamma(i)))
      end do
   end function violation

   !> Of the solution, the error estimates and the continuous extension. The coefficients are read off what the pair makes of
   !! derivatives that are unit vectors.
   subroutine order_conditions(failure)
      character(:), allocatable, intent(inout) :: failure
      integer, parameter :: solution(2) = [5, 8], dense(2) = [4, 7], lower(2, 2) = reshape([4, 0, 5, 3], [2, 2])
      class(explicit_pair_t), allocatable :: pair
      type(trees_t) :: trees
      type(numbered_t) :: problem
      real(wp), allocatable :: a(:, :), b(:), rest(:)
      integer :: i, info, j, s
      real(wp) :: theta

      do j = 1, 2
         call new_pair(integrator_names(j), 1, pair, failure)
         if (allocated(failure)) return
         s = size(pair%node)
         call new_pair(integrator_names(j), s, pair, failure)
         if (allocated(trees%weight)) deallocate (trees%weight)
         allocate (trees%weight(s, 200))
         a = reshape([(0.0_wp, i=1, s*s)], [s, s])
         rest = a(:, 1)
         b = rest
         pair%k(:, :) = a
         do i = 1, s
            pair%k(i, i) = 1.0_wp
         end do
         do i = 2, s
            call pair%stage_state(i, 1.0_wp, rest, b)
            a(i, :) = b
         end do
         trees%count = 0
         do i = 1, 8
            call grow(trees, a, i, i - 1, 1, [(1.0_wp, info=1, s)], 1.0_wp)
         end do
         call check(failure, trees%count == 200, 'number of trees')

         b = a(pair%stages, :)
         call check_below(failure, violation(trees, b, 1.0_wp, 1, solution(j)), 1.0e-13_wp, 'solution')
         if (solution(j) < 8) call check(failure, violation(trees, b, 1.0_wp, solution(j) + 1, 8) > 1.0e-4_wp, 'order too low')
         call pair%estimate(1.0_wp, pair%k, pair%error)
         do i = 1, size(pair%error, 2)
            call check_below(failure, violation(trees, b - pair%error(:, i), 1.0_wp, 1, lower(i, j)), 1.0e-13_wp, 'estimate')
            call check(failure, violation(trees, b - pair%error(:, i), 1.0_wp, lower(i, j) + 1, lower(i, j) + 1) > 1.0e-4_wp, &
                       'the estimate sees nothing')
         end do
         problem%next = pair%stages
         call pair%prepare_dense(problem, 0.0_wp, rest, 1.0_wp, 1.0_wp, b, info)
         call check(failure, problem%next == s, 'evaluations of dense output')
         do i = 0, 10
            theta = 0.1_wp*i
            call pair%interpolate(theta, b)
            call check_below(failure, violation(trees, b, theta, 1, dense(j)), 1.0e-12_wp, 'dense output')
         end do
         call pair%interpolate(0.3_wp, b)
         call check(failure, violation(trees, b, 0.3_wp, dense(j) + 1, dense(j) + 1) > 1.0e-9_wp, 'dense output of higher order')
      end do
   end subroutine order_conditions

   !> One step from t = 0.3: error at its end, size of the estimates, error inside.
   subroutine step_of(name, h, e, failure)
      character(*), intent(in) :: name
      real(wp), intent(in) :: h
      real(wp), intent(out) :: e(4)
      character(:), allocatable, intent(inout) :: failure
      class(explicit_pair_t), allocatable :: pair
      type(smooth_t) :: problem
      real(wp) :: y(2), y0(2), y1(2)
      integer :: i, info

      call new_pair(name, 2, pair, failure)
      e = 0.0_wp
      if (allocated(failure)) return
      y0 = smooth_solution(0.3_wp)
      call problem%rhs(0.3_wp, y0, pair%k(:, 1), info)
      do i = 2, pair%stages
         call pair%stage_state(i, h, y0, y1)
         call problem%rhs(0.3_wp + pair%node(i)*h, y1, pair%k(:, i), info)
      end do
      e(1) = maxval(abs(y1 - smooth_solution(0.3_wp + h)))
      call pair%estimate(h, pair%k, pair%error)
      do i = 1, size(pair%error, 2)
         e(1 + i) = maxval(abs(pair%error(:, i)))
      end do
      call pair%prepare_dense(problem, 0.3_wp, y0, 0.3_wp + h, h, y1, info)
      call pair%interpolate(0.0_wp, y)
      call check_below(failure, maxval(abs(y - y0)), 0.0_wp, 'start of the step')
      call pair%interpolate(1.0_wp, y)
      call check_below(failure, maxval(abs(y - y1)), 1.0e-15_wp, 'end of the step')
      do i = 1, 9
         call pair%interpolate(0.1_wp*i, y)
         e(4) = max(e(4), maxval(abs(y - smooth_solution(0.3_wp + 0.1_wp*i*h))))
      end do
   end subroutine step_of

   !> On a problem that is not autonomous, by halving a step.
   subroutine orders_of_a_step(failure)
      character(:), allocatable, intent(inout) :: failure
      real(wp), parameter :: h(2) = [0.1_wp, 0.6_wp]
      integer, parameter :: order(4, 2) = reshape([6, 5, 0, 5, 9, 6, 4, 8], [4, 2])
      real(wp) :: e(4), half(4)
      integer :: i, j

      do j = 1, 2
         call step_of(integrator_names(j), h(j), e, failure)
         call step_of(integrator_names(j), 0.5_wp*h(j), half, failure)
         if (allocated(failure)) return
         do i = 1, 4
            if (order(i, j) > 0) &
               call check_close(failure, log(e(i)/half(i))/log(2.0_wp), real(order(i, j), wp), 0.6_wp, 'local order')
         end do
      end do
   end subroutine orders_of_a_step

end module test_explicit_pair
