!> Functions of time with their first two derivatives: what drives a joint or scales a load.
module taut_model_mechanism_function
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_linalg_lapack, only: dgtsv
   implicit none (type, external)
   private
   public :: time_function_t, function_kinds
   public :: function_constant, function_ramp, function_sine, function_cosine, function_step, function_run_up, &
             function_polynomial, function_table

   integer, parameter :: function_constant = 1, function_ramp = 2, function_sine = 3, function_cosine = 4, function_step = 5, &
                         function_run_up = 6, function_polynomial = 7, function_table = 8
   !> Names of the kinds, in the order of their numbers.
   character(len=10), parameter :: function_kinds(8) = [character(len=10) :: 'constant', 'ramp', 'sine', 'cosine', 'step', &
                                                        'run-up', 'polynomial', 'table']

   !> A function g(t), without a unit of its own. Outside [start, finish] a ramp, a step and a table keep their end values.
   !!
   !! constant: g = offset. ramp: offset + rate (t - start). sine, cosine: offset + amplitude sin(omega t + phase).
   !! step: offset + amplitude (10 s^3 - 15 s^4 + 6 s^5), s = (t - start)/(finish - start), or a jump at `start` if finish is
   !! not later. run-up: gdot = rate (10 s^3 - 15 s^4 + 6 s^5), from rest at `start` to a constant rate from `finish` on.
   !! polynomial: offset + sum of coefficients(k) t^k. table: a cubic spline with two continuous derivatives (not-a-knot ends)
   !! through values at times.
   type :: time_function_t
      !> What it is called.
      character(:), allocatable :: name
      !> One of the `function_` constants.
      integer :: kind = function_constant
      !> The numbers of the formulas above; omega [rad/s], times [s].
      real(wp) :: offset = 0.0_wp, amplitude = 1.0_wp, rate = 0.0_wp, omega = 0.0_wp, phase = 0.0_wp
      real(wp) :: start = 0.0_wp, finish = huge(1.0_wp)
      !> Of t, t^2, ...
      real(wp), allocatable :: coefficients(:)
      !> Table: times [s], values, second derivatives.
      real(wp), allocatable :: times(:), values(:), second(:)
   contains
      procedure :: check
      procedure :: evaluate
      procedure :: jumps
      procedure :: breakpoints
   end type time_function_t

contains

   !> Checks the numbers, and prepares the spline of a table.
   subroutine check(self, error)
      !> The function.
      class(time_function_t), intent(inout) :: self
      !> Numbers that make no sense.
      type(error_t), allocatable, intent(inout) :: error
      character(:), allocatable :: here
      integer :: i

      here = 'function "'//self%name//'"'
      if (.not. all(abs([self%offset, self%amplitude, self%rate, self%omega, self%phase, self%start, self%finish]) <= &
                    huge(1.0_wp))) &
         call raise(error, here, 'one of its numbers is not finite', 'correct it')
      select case (self%kind)
      case (function_run_up)
         if (.not. (self%finish > self%start .and. self%finish < huge(1.0_wp))) &
            call raise(error, here, 'a run-up takes time', 'give a finish that is later than its start')
      case (function_polynomial)
         if (.not. allocated(self%coefficients)) call raise(error, here, 'it has no coefficients', 'give those of t, t^2, ...')
         if (allocated(error)) return
         if (.not. all(abs(self%coefficients) <= huge(1.0_wp))) call raise(error, here, 'a coefficient is not finite', 'correct it')
      case (function_table)
         if (.not. allocated(self%times)) then
            call raise(error, here, 'it has no table', 'name a CSV file of times and values')
         else if (size(self%times) < 2 .or. size(self%values) /= size(self%times)) then
            call raise(error, here, 'its table has '//to_text(size(self%times))//' rows', 'give two or more')
         else if (.not. (all(abs(self%times) <= huge(1.0_wp)) .and. all(abs(self%values) <= huge(1.0_wp)))) then
            call raise(error, here, 'its table has entries that are not finite', 'correct them')
         else
            do i = 2, size(self%times)
               if (.not. self%times(i) > self%times(i - 1)) then
                  call raise(error, here, 'its table is not increasing in time: row '//to_text(i)//' has t = '// &
                             to_text(self%times(i))//' after '//to_text(self%times(i - 1)), 'sort it, and remove double times')
                  return
               end if
            end do
         end if
         if (.not. allocated(error)) call prepare_spline(self)
      end select
   end subroutine check

   !> Second derivatives at the knots. Not-a-knot: the third derivative is continuous across the second and the last but one.
   subroutine prepare_spline(self)
      class(time_function_t), intent(inout) :: self
      real(wp), allocatable :: below(:), diagonal(:), above(:), right(:, :), h(:), slope(:)
      integer :: info, m, n

      n = size(self%times)
      m = n - 2
      if (allocated(self%second)) deallocate (self%second)
      allocate (self%second(n), source=0.0_wp)
      if (m == 0) return
      h = self%times(2:) - self%times(:n - 1)
      slope = (self%values(2:) - self%values(:n - 1))/h
      allocate (right(m, 1))
      right(:, 1) = 6.0_wp*(slope(2:) - slope(:n - 2))
      if (m == 1) then
         ! Three points: a parabola.
         self%second = right(1, 1)/(3.0_wp*(h(1) + h(2)))
         return
      end if
      diagonal = 2.0_wp*(h(:m) + h(2:))
      below = h(2:m)
      above = h(2:m)
      diagonal(1) = diagonal(1) + h(1)*(1.0_wp + h(1)/h(2))
      above(1) = above(1) - h(1)**2/h(2)
      diagonal(m) = diagonal(m) + h(m + 1)*(1.0_wp + h(m + 1)/h(m))
      below(m - 1) = below(m - 1) - h(m + 1)**2/h(m)
      call dgtsv(m, 1, below, diagonal, above, right, m, info)
      if (info /= 0) return
      self%second(2:n - 1) = right(:, 1)
      self%second(1) = self%second(2) + (self%second(2) - self%second(3))*h(1)/h(2)
      self%second(n) = self%second(n - 1) + (self%second(n - 1) - self%second(n - 2))*h(m + 1)/h(m)
   end subroutine prepare_spline

   !> g, its rate and its second derivative.
   pure subroutine evaluate(self, t, g)
      !> The function.
      class(time_function_t), intent(in) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> {g, gdot, gddot}.
      real(wp), intent(out) :: g(3)
      real(wp) :: l, s
      integer :: k

      g(1) = self%offset
      g(2) = 0.0_wp
      g(3) = 0.0_wp
      select case (self%kind)
      case (function_ramp)
         g(1) = self%offset + self%rate*(min(max(t, self%start), self%finish) - self%start)
         if (t >= self%start .and. t < self%finish) g(2) = self%rate
      case (function_sine)
         g(1) = self%offset + self%amplitude*sin(self%omega*t + self%phase)
         g(2) = self%amplitude*self%omega*cos(self%omega*t + self%phase)
         g(3) = -self%omega**2*(g(1) - self%offset)
      case (function_cosine)
         g(1) = self%offset + self%amplitude*cos(self%omega*t + self%phase)
         g(2) = -self%amplitude*self%omega*sin(self%omega*t + self%phase)
         g(3) = -self%omega**2*(g(1) - self%offset)
      case (function_step)
         l = self%finish - self%start
         if (t >= max(self%start, self%finish)) then
            g(1) = self%offset + self%amplitude
         else if (t > self%start) then
            s = (t - self%start)/l
            g(1) = self%offset + self%amplitude*s**3*(10.0_wp - s*(15.0_wp - 6.0_wp*s))
            g(2) = self%amplitude*30.0_wp*s**2*(1.0_wp - s)**2/l
            g(3) = self%amplitude*60.0_wp*s*(1.0_wp - s)*(1.0_wp - 2.0_wp*s)/l**2
         end if
      case (function_run_up)
         l = self%finish - self%start
         if (t >= self%finish) then
            g(1) = self%offset + self%rate*(t - self%start - 0.5_wp*l)
            g(2) = self%rate
         else if (t > self%start) then
            s = (t - self%start)/l
            g(1) = self%offset + self%rate*l*s**4*(2.5_wp - s*(3.0_wp - s))
            g(2) = self%rate*s**3*(10.0_wp - s*(15.0_wp - 6.0_wp*s))
            g(3) = self%rate*30.0_wp*s**2*(1.0_wp - s)**2/l
         end if
      case (function_polynomial)
         ! Horner's scheme for p(t) = sum of c(k) t^k and its derivatives; the constant coefficient is the offset.
         g(1) = 0.0_wp
         do k = size(self%coefficients), 0, -1
            g(3) = g(3)*t + 2.0_wp*g(2)
            g(2) = g(2)*t + g(1)
            g(1) = g(1)*t
            if (k > 0) g(1) = g(1) + self%coefficients(k)
         end do
         g(1) = g(1) + self%offset
      case (function_table)
         call interpolate(self, t, g)
      end select

   end subroutine evaluate

   !> The spline; constant outside the table.
   pure subroutine interpolate(self, t, g)
      class(time_function_t), intent(in) :: self
      real(wp), intent(in) :: t
      real(wp), intent(inout) :: g(3)
      real(wp) :: a, b, h
      integer :: high, low, middle, n

      n = size(self%times)
      if (t < self%times(1)) then
         g(1) = g(1) + self%values(1)
      else if (t >= self%times(n)) then
         g(1) = g(1) + self%values(n)
      else
         low = 1
         high = n
         do while (high - low > 1)
            middle = (low + high)/2
            if (self%times(middle) <= t) then
               low = middle
            else
               high = middle
            end if
         end do
         h = self%times(high) - self%times(low)
         a = (self%times(high) - t)/h
         b = 1.0_wp - a
         associate (y_1 => self%values(low), y_2 => self%values(high), m_1 => self%second(low), m_2 => self%second(high))
            g(1) = g(1) + a*y_1 + b*y_2 + ((a**3 - a)*m_1 + (b**3 - b)*m_2)*h**2/6.0_wp
            g(2) = (y_2 - y_1)/h + ((3.0_wp*b**2 - 1.0_wp)*m_2 - (3.0_wp*a**2 - 1.0_wp)*m_1)*h/6.0_wp
            g(3) = a*m_1 + b*m_2
         end associate
      end if
   end subroutine interpolate

   !> Whether the function has a jump: no joint can follow it.
   pure function jumps(self) result(answer)
      !> The function.
      class(time_function_t), intent(in) :: self
      !> True for a step that takes no time.
      logical :: answer

      answer = self%kind == function_step .and. self%finish <= self%start
   end function jumps

   !> Times at which the function or one of its first two derivatives is not smooth.
   pure function breakpoints(self) result(times)
      !> The function.
      class(time_function_t), intent(in) :: self
      !> Times [s].
      real(wp), allocatable :: times(:)

      times = [real(wp) ::]
      select case (self%kind)
      case (function_ramp, function_step, function_run_up)
         times = [self%start, self%finish]
         if (self%jumps()) times = [self%start]
         times = pack(times, abs(times) < huge(1.0_wp))
      case (function_table)
         times = [self%times(1), self%times(size(self%times))]
      end select
   end function breakpoints

end module taut_model_mechanism_function
