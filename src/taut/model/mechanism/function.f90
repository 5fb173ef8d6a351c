!> Functions of time with their first two derivatives: what drives a joint or scales a load.
module taut_model_mechanism_function
   use taut_kinds, only: wp
   use taut_constrained_system_tables, only: name_length
   use taut_error, only: error_t, raise, to_text
   use taut_linalg_lapack, only: dgtsv
   use taut_name_index, only: name_index_t
   implicit none (type, external)
   private
   public :: time_function_t, function_kinds, resolve_sums
   public :: function_constant, function_ramp, function_sine, function_cosine, function_step, function_run_up, &
             function_polynomial, function_table, function_sum

   integer, parameter :: function_constant = 1, function_ramp = 2, function_sine = 3, function_cosine = 4, function_step = 5, &
                         function_run_up = 6, function_polynomial = 7, function_table = 8, function_sum = 9
   !> Names of the kinds, in the order of their numbers.
   character(len=10), parameter :: function_kinds(9) = [character(len=10) :: 'constant', 'ramp', 'sine', 'cosine', 'step', &
                                                        'run-up', 'polynomial', 'table', 'sum']

   !> A function g(t) by one formula. Outside [start, finish] a ramp, a step and a table keep their end values.
   !!
   !! constant: g = offset. ramp: offset + rate (t - start). sine, cosine: offset + amplitude sin(omega t + phase).
   !! step: offset + amplitude (10 s^3 - 15 s^4 + 6 s^5), s = (t - start)/(finish - start), or a jump at `start` if finish is
   !! not later. run-up: gdot = rate (10 s^3 - 15 s^4 + 6 s^5), from rest at `start` to a constant rate from `finish` on.
   !! polynomial: offset + sum of coefficients(k) t^k. table: a cubic spline with two continuous derivatives (not-a-knot ends)
   !! through values at times.
   type :: simple_function_t
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
   end type simple_function_t

   !> A function g(t), without a unit of its own: a formula, or the sum of others.
   !!
   !! sum: offset + sum of factors(k) times the function that is called of(k), which may be a sum itself.
   type, extends(simple_function_t) :: time_function_t
      !> Sum: names of its functions, and what each is multiplied with (not allocated: 1).
      character(len=name_length), allocatable :: of(:)
      real(wp), allocatable :: factors(:)
      !> What `resolve_sums` makes of them: formulas, and the factor of each.
      type(simple_function_t), allocatable, private :: terms(:)
      real(wp), allocatable, private :: weights(:)
   contains
      procedure :: check
      procedure :: evaluate
      procedure :: jumps
      procedure :: breakpoints
      procedure :: reach
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
      case (function_sum)
         if (.not. allocated(self%of)) call raise(error, here, 'it is a sum of nothing', 'give of = the names of functions')
         if (allocated(error) .or. .not. allocated(self%factors)) return
         if (size(self%factors) /= size(self%of)) &
            call raise(error, here, 'it has '//to_text(size(self%factors))//' factors for '//to_text(size(self%of))// &
                       ' functions', 'give one for each of them')
         if (.not. all(abs(self%factors) <= huge(1.0_wp))) call raise(error, here, 'a factor is not finite', 'correct it')
      end select
   end subroutine check

   !> Finds the functions that sums are made of, by their names.
   subroutine resolve_sums(functions, error)
      !> All functions, which were checked.
      type(time_function_t), intent(inout) :: functions(:)
      !> A name that there is not, or a sum that contains itself.
      type(error_t), allocatable, intent(inout) :: error
      type(name_index_t) :: names
      logical :: begun(size(functions)), resolved(size(functions))
      integer :: i

      do i = 1, size(functions)
         call names%add(functions(i)%name, i)
      end do
      begun = .false.
      resolved = functions%kind /= function_sum
      do i = 1, size(functions)
         call resolve(i)
      end do

   contains

      !> Sums within the sum come first.
      recursive subroutine resolve(i)
         integer, intent(in) :: i
         character(:), allocatable :: here, meant
         integer :: k, number

         if (resolved(i) .or. allocated(error)) return
         here = 'function "'//functions(i)%name//'"'
         if (begun(i)) then
            call raise(error, here, 'it is a sum that contains itself', 'remove it from one of the sums: '//open_names())
            return
         end if
         begun(i) = .true.
         associate (sum => functions(i))
            sum%terms = [simple_function_t ::]
            sum%weights = [real(wp) ::]
            do k = 1, size(sum%of)
               number = names%find(sum%of(k))
               if (number == 0) then
                  meant = names%nearest_to(sum%of(k))
                  if (len_trim(meant) > 0) meant = 'did you mean "'//trim(meant)//'"? Or '
                  call raise(error, here, 'of = "'//trim(sum%of(k))//'": there is no function of this name', &
                             meant//'add it, or correct the name')
               else
                  call resolve(number)
               end if
               if (allocated(error)) return
               call add_terms(sum, functions(number), k)
            end do
         end associate
         begun(i) = .false.
         resolved(i) = .true.
      end subroutine resolve

      !> The sums that are being resolved, as words.
      function open_names() result(text)
         character(:), allocatable :: text
         integer :: k

         text = ''
         do k = 1, size(functions)
            if (begun(k)) text = text//' "'//functions(k)%name//'"'
         end do
         text = text(2:)
      end function open_names

   end subroutine resolve_sums

   !> Adds the terms of the kth function of a sum, with its factor.
   subroutine add_terms(sum, function, k)
      type(time_function_t), intent(inout) :: sum
      type(time_function_t), intent(in) :: function
      integer, intent(in) :: k
      real(wp) :: factor

      factor = 1.0_wp
      if (allocated(sum%factors)) factor = sum%factors(k)
      ! Of a sum the formula is its offset alone.
      sum%terms = [sum%terms, function%simple_function_t]
      sum%weights = [sum%weights, factor]
      if (function%kind /= function_sum) return
      sum%terms = [sum%terms, function%terms]
      sum%weights = [sum%weights, factor*function%weights]
   end subroutine add_terms

   !> Second derivatives at the knots. Not-a-knot: the third derivative is continuous across the second and the last but one.
   subroutine prepare_spline(self)
      class(simple_function_t), intent(inout) :: self
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
      real(wp) :: term(3)
      integer :: i, k

      call evaluate_formula(self%simple_function_t, t, g)
      if (self%kind /= function_sum) return
      do k = 1, size(self%terms)
         call evaluate_formula(self%terms(k), t, term)
         do i = 1, 3
            g(i) = g(i) + self%weights(k)*term(i)
         end do
      end do
   end subroutine evaluate

   !> The same of a formula; of a sum its offset.
   pure subroutine evaluate_formula(self, t, g)
      type(simple_function_t), intent(in) :: self
      real(wp), intent(in) :: t
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
   end subroutine evaluate_formula

   !> The spline; constant outside the table.
   pure subroutine interpolate(self, t, g)
      type(simple_function_t), intent(in) :: self
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
      !> True for a step that takes no time, and for a sum with one.
      logical :: answer
      integer :: k

      answer = formula_jumps(self%simple_function_t)
      if (self%kind /= function_sum) return
      do k = 1, size(self%terms)
         answer = answer .or. formula_jumps(self%terms(k))
      end do
   end function jumps

   !> The same of a formula.
   pure logical function formula_jumps(self) result(answer)
      type(simple_function_t), intent(in) :: self

      answer = self%kind == function_step .and. self%finish <= self%start
   end function formula_jumps

   !> Times at which the function or one of its first two derivatives is not smooth.
   pure function breakpoints(self) result(times)
      !> The function.
      class(time_function_t), intent(in) :: self
      !> Times [s].
      real(wp), allocatable :: times(:)
      integer :: k

      times = breakpoints_of_formula(self%simple_function_t)
      if (self%kind /= function_sum) return
      do k = 1, size(self%terms)
         times = [times, breakpoints_of_formula(self%terms(k))]
      end do
   end function breakpoints

   !> The same of a formula.
   pure function breakpoints_of_formula(self) result(times)
      type(simple_function_t), intent(in) :: self
      real(wp), allocatable :: times(:)

      times = [real(wp) ::]
      select case (self%kind)
      case (function_ramp, function_step, function_run_up)
         times = [self%start, self%finish]
         if (formula_jumps(self)) times = [self%start]
         times = pack(times, abs(times) < huge(1.0_wp))
      case (function_table)
         times = [self%times(1), self%times(size(self%times))]
      end select
   end function breakpoints_of_formula

   !> From where to where the function is known: the part of the time that all its tables have.
   pure function reach(self) result(ends)
      !> The function.
      class(time_function_t), intent(in) :: self
      !> First and last time [s]; without a table all times.
      real(wp) :: ends(2)
      integer :: k

      ends = reach_of_formula(self%simple_function_t)
      if (self%kind /= function_sum) return
      do k = 1, size(self%terms)
         associate (of_term => reach_of_formula(self%terms(k)))
            ends = [max(ends(1), of_term(1)), min(ends(2), of_term(2))]
         end associate
      end do
   end function reach

   !> The same of a formula.
   pure function reach_of_formula(self) result(ends)
      type(simple_function_t), intent(in) :: self
      real(wp) :: ends(2)

      ends = [-huge(1.0_wp), huge(1.0_wp)]
      if (self%kind == function_table) ends = [self%times(1), self%times(size(self%times))]
   end function reach_of_formula

end module taut_model_mechanism_function
