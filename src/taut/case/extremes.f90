!> Largest and smallest values of columns over a whole motion: at the end of every step, whatever is written, and where a value may
!! be larger inside a step than at its ends, at up to three places in it; and wherever a row is written.
!!
!! At a singular position reactions are the quotient of two round-offs; there they are left out.
!!
!! Nothing of it counts as work of the method, or has a part in the motion.
module taut_case_extremes
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_quiet_nan, ieee_value
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_case_columns, only: column_count, column_name, column_value, of_whole_sample, rank_column
   use taut_case_csv, only: csv_field
   use taut_case_row, only: row_t
   use taut_case_settings, only: extreme_t
   use taut_constrained_method, only: constrained_ode_t, sample_t
   use taut_constrained_system_tables, only: magnitude_t, name_length, tabulated_system_t
   use taut_linalg_rank, only: reaction_pivot, weaker
   use taut_ode_step, only: step_t
   use taut_ode_system, only: rhs_ok
   use taut_spelling, only: nearest_name
   implicit none (type, external)
   private
   public :: extremes_t, extreme_columns

   !> Evaluations inside a step for all together: one in its middle, and so many more; for what is asked for by name, each of its own.
   integer, parameter :: refinements = 2
   !> Slopes at the ends of a step are known but for this part of those over it and over the one before.
   real(wp), parameter :: margin = 0.1_wp
   !> What exceeds the extreme so far by less than this part of it is not looked for.
   real(wp), parameter :: worth = 1.0e-6_wp
   !> Reactions that are smaller than this part of the largest multiplier are round-off.
   real(wp), parameter :: round_off = 1.0e-9_wp
   !> Places of a step that are closer than this part of it are the same.
   real(wp), parameter :: near = 1.0e-3_wp
   !> Largest, and smallest as the largest of the opposite.
   real(wp), parameter :: signs(2) = [1.0_wp, -1.0_wp]

   !> Values that are followed.
   type :: extremes_t
      !> How many.
      integer :: n = 0
      type(extreme_t), allocatable, private :: asked(:)
      !> Columns; the size of a vector has none, but multipliers, from one place of a list to another: (n), (2, n); the list, which
      !! has room for more than are used.
      integer, allocatable, private :: column(:), vector(:, :), multipliers(:)
      integer, private :: used = 0
      !> Whether the smallest is asked for too: (n).
      logical, allocatable, private :: both(:)
      !> Whether it is a reaction: (n).
      logical, allocatable, private :: of_reaction(:)
      !> The largest of the smallest pivots so far; how often reactions were left out, and where first [s].
      real(wp), private :: strongest = 0.0_wp, left_out_t = 0.0_wp
      integer, private :: left_out = 0
      !> Entries of {x; v; w}; whether a column needs all of a sample, or what the system computes besides.
      integer, private :: states = 0
      logical, private :: whole = .false., outputs = .false.
      !> Extremes so far, of the value and of its opposite, and their times [s]: (2, n).
      real(wp), allocatable, private :: best(:, :), t_best(:, :)
      !> The last two places and the values there: (2, n); how many there are since the motion last jumped: (n).
      real(wp), allocatable, private :: t_past(:, :), past(:, :)
      integer, allocatable, private :: known(:)
      !> Values at the begin of a step that begins anew, at its end, and inside it: (n).
      real(wp), allocatable, private :: before(:), behind(:), inside(:)
      !> Where what is asked for ends in the step [s]: (n).
      real(wp), allocatable, private :: ends(:)
      !> What may be an extreme inside the step: how many places of it are known, 0 of all else, and the highest three with their
      !! values: (2, n), (3, 2, n).
      integer, allocatable, private :: places(:, :)
      real(wp), allocatable, private :: x(:, :, :), v(:, :, :)
      type(sample_t), private :: sample
   contains
      procedure :: init
      procedure :: follow
      procedure :: see
      procedure :: names
      procedure :: fields
      procedure :: remark
      procedure :: serialize
   end type extremes_t

contains

   !> Finds the columns.
   subroutine init(self, model, asked, magnitudes, error)
      !> The extremes.
      class(extremes_t), intent(out) :: self
      !> The system.
      class(tabulated_system_t), intent(in) :: model
      !> What a case file asks for.
      type(extreme_t), intent(in) :: asked(:)
      !> Whether the largest size of each vector that the system tells of is wanted too.
      logical, intent(in) :: magnitudes
      !> A column that does not exist.
      type(error_t), allocatable, intent(inout) :: error
      type(magnitude_t), allocatable :: vectors(:)
      integer :: i, j, k, n

      vectors = model%magnitudes()
      n = size(asked)
      if (magnitudes) n = n + size(vectors)
      allocate (self%asked(n), self%column(n), self%vector(2, n), self%both(n), self%multipliers(0))
      self%column(:) = 0
      self%vector(:, :) = 0
      k = 0
      do i = 1, size(asked)
         k = k + 1
         self%asked(k) = asked(i)
         self%both(k) = .true.
         do j = 1, size(vectors)
            if (vectors(j)%name == asked(i)%column) call take_vector(self, k, vectors(j)%rows)
            if (vectors(j)%name == asked(i)%name .and. .not. is_whole(asked(i))) &
               call raise(error, asked(i)%place, '"'//asked(i)%name//'" is what the largest over the whole motion is called', &
                          'give it another name')
         end do
         if (self%vector(1, k) == 0) call find_column(model, vectors, asked(i), self%column(k), error)
         if (allocated(error)) return
      end do
      if (magnitudes) then
         do i = 1, size(vectors)
            if (any([(asked(j)%name == vectors(i)%name, j=1, size(asked))])) cycle
            k = k + 1
            self%asked(k)%name = trim(vectors(i)%name)
            self%both(k) = .false.
            call take_vector(self, k, vectors(i)%rows)
         end do
      end if
      self%n = k
      self%states = model%n_x + model%n + model%n_w
      self%of_reaction = self%column == 0
      do i = 1, k
         if (self%column(i) == 0) cycle
         self%of_reaction(i) = is_reaction(column_name(model, self%column(i)), vectors)
         self%whole = self%whole .or. of_whole_sample(model, self%column(i))
         self%outputs = self%outputs .or. self%column(i) > rank_column(model)
      end do
      allocate (self%best(2, k), source=-huge(1.0_wp))
      allocate (self%t_best(2, k), self%t_past(2, k), self%past(2, k), self%before(k), self%behind(k), self%inside(k), &
                self%ends(k), self%x(3, 2, k), self%v(3, 2, k), source=0.0_wp)
      allocate (self%known(k), self%places(2, k), source=0)
   end subroutine init

   !> Whether it is of the column that it is called by, over the whole motion.
   pure logical function is_whole(asked)
      type(extreme_t), intent(in) :: asked

      is_whole = asked%name == asked%column .and. asked%from <= -huge(1.0_wp) .and. asked%to >= huge(1.0_wp)
   end function is_whole

   !> Whether a column is a multiplier or a component of a vector of them, which begins as it does: hinge.fx of hinge.force.
   pure logical function is_reaction(name, vectors) result(answer)
      character(*), intent(in) :: name
      type(magnitude_t), intent(in) :: vectors(:)
      integer :: i, n

      answer = index(name, 'lambda') == 1
      do i = 1, size(vectors)
         n = index(vectors(i)%name, '.', back=.true.) + 1
         answer = answer .or. name(:n) == vectors(i)%name(:n)
      end do
   end function is_reaction

   !> Takes the multipliers of a vector.
   pure subroutine take_vector(self, k, rows)
      type(extremes_t), intent(inout) :: self
      integer, intent(in) :: k, rows(:)
      integer :: last

      last = self%used + size(rows)
      if (last > size(self%multipliers)) self%multipliers = [self%multipliers, spread(0, 1, last)]
      self%multipliers(self%used + 1:last) = rows
      self%vector(:, k) = [self%used + 1, last]
      self%used = last
   end subroutine take_vector

   !> The column that is asked for.
   subroutine find_column(model, vectors, asked, column, error)
      class(tabulated_system_t), intent(in) :: model
      type(magnitude_t), intent(in) :: vectors(:)
      type(extreme_t), intent(in) :: asked
      integer, intent(out) :: column
      type(error_t), allocatable, intent(inout) :: error
      character(len=name_length), allocatable :: names(:)
      character(:), allocatable :: meant
      integer :: i, n

      n = column_count(model)
      do column = 2, n
         if (column_name(model, column) == asked%column) return
      end do
      allocate (names(n - 1 + size(vectors)))
      do i = 2, n
         names(i - 1) = column_name(model, i)
      end do
      do i = 1, size(vectors)
         names(n - 1 + i) = vectors(i)%name
      end do
      meant = trim(nearest_name(asked%column, names))
      if (len(meant) > 0) meant = 'did you mean "'//meant//'"? Or '
      call raise(error, asked%place, 'there is no column "'//asked%column//'"', &
                 meant//'take a name, but t, from the first line of a result with all columns')
   end subroutine find_column

   !> Looks at a step that holds.
   subroutine follow(self, ode, step, t_last, error)
      !> The extremes.
      class(extremes_t), intent(inout) :: self
      !> The formulation that is integrated.
      class(constrained_ode_t), intent(inout) :: ode
      !> The step.
      class(step_t), intent(inout) :: step
      !> Its end, or where an event ends it [s].
      real(wp), intent(in) :: t_last
      !> A state that cannot be evaluated.
      type(error_t), allocatable, intent(inout) :: error
      real(wp) :: begin
      integer :: i, k
      logical :: there

      call evaluate(self, ode, step, t_last, self%behind, error)
      if (step%anew .and. .not. allocated(error)) then
         call evaluate(self, ode, step, step%t, self%before, error)
         self%known(:) = 0
      end if
      if (allocated(error)) return
      do i = 1, self%n
         call find_overlap(step, t_last, self%asked(i), begin, self%ends(i), there)
         self%places(:, i) = 0
         if (.not. there) then
            self%known(i) = 0
            cycle
         end if
         if (self%known(i) == 0) then
            if (step%anew .and. .not. abs(begin - step%t) > 0.0_wp) then
               call keep(self, i, begin, self%before(i))
            else
               call evaluate(self, ode, step, begin, self%inside, error)
               call keep(self, i, begin, self%inside(i))
            end if
         end if
         if (abs(self%ends(i) - t_last) > 0.0_wp .and. .not. allocated(error)) then
            call evaluate(self, ode, step, self%ends(i), self%inside, error)
            self%behind(i) = self%inside(i)
         end if
         if (allocated(error)) return
         do k = 1, merge(2, 1, self%both(i))
            if (may_be_inside(self, i, k)) self%places(k, i) = 2
         end do
      end do
      if (any(self%places > 0)) call look_inside(self, ode, step, error)
      do i = 1, self%n
         if (self%known(i) > 0 .and. abs(self%ends(i) - self%t_past(2, i)) > 0.0_wp) &
            call keep(self, i, self%ends(i), self%behind(i))
      end do
   end subroutine follow

   !> What of a step lies in the time that is asked for.
   pure subroutine find_overlap(step, t_last, asked, begin, end, there)
      class(step_t), intent(in) :: step
      real(wp), intent(in) :: t_last
      type(extreme_t), intent(in) :: asked
      !> Its first and its last time in the direction of the step [s].
      real(wp), intent(out) :: begin, end
      !> Whether there is anything.
      logical, intent(out) :: there

      begin = min(max(step%t, asked%from), asked%to)
      end = min(max(t_last, asked%from), asked%to)
      there = abs(end - begin) > 0.0_wp .or. (begin >= min(step%t, t_last) .and. begin <= max(step%t, t_last))
   end subroutine find_overlap

   !> Values at a time of the step.
   subroutine evaluate(self, ode, step, t, values, error)
      type(extremes_t), intent(inout) :: self
      class(constrained_ode_t), intent(inout) :: ode
      class(step_t), intent(inout) :: step
      real(wp), intent(in) :: t
      real(wp), intent(inout) :: values(:)
      type(error_t), allocatable, intent(inout) :: error
      integer :: info

      if (.not. abs(t - step%t_new) > 0.0_wp) then
         call at_state(step%y_new)
      else if (.not. abs(t - step%t) > 0.0_wp) then
         call at_state(step%y)
      else
         call step%interpolate(ode, t, info)
         if (info == rhs_ok) then
            call at_state(step%y_inside)
         else
            call refuse()
         end if
      end if

   contains

      subroutine at_state(y)
         real(wp), intent(in), contiguous :: y(:)
         integer :: i

         if (self%whole) then
            call step%tell_integral(ode, t)
            call ode%sample(t, y, self%sample, info)
         else
            call ode%sample_reactions(t, y, self%outputs, self%sample, info)
         end if
         if (info /= rhs_ok) then
            call refuse()
            return
         end if
         call look_at_pivot(self, t, self%sample%weakest)
         do i = 1, self%n
            values(i) = value_of(self, i, t, step%h_tried, y, self%sample)
         end do
      end subroutine at_state

      subroutine refuse()
         character(:), allocatable :: why

         call ode%failure(why)
         call raise(error, 'extremes', 'the multipliers at t = '//to_text(t)//' s cannot be computed: '//why, &
                    'tighten the tolerances')
      end subroutine refuse

   end subroutine evaluate

   !> Looks at a point that is written.
   subroutine see(self, t, h, y, sample)
      !> The extremes.
      class(extremes_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> The step [s].
      real(wp), intent(in) :: h
      !> State: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> All of its sample.
      type(sample_t), intent(in) :: sample
      real(wp) :: value
      integer :: i

      call look_at_pivot(self, t, sample%weakest)
      do i = 1, self%n
         if (t < self%asked(i)%from .or. t > self%asked(i)%to) cycle
         value = value_of(self, i, t, h, y, sample)
         if (ieee_is_finite(value)) call try(self, i, t, value)
      end do
   end subroutine see

   !> Notes how far reactions can be told from round-off.
   pure subroutine look_at_pivot(self, t, weakest)
      type(extremes_t), intent(inout) :: self
      real(wp), intent(in) :: t, weakest

      self%strongest = max(self%strongest, weakest)
      if (.not. (any(self%of_reaction) .and. is_singular(self, weakest))) return
      if (self%left_out == 0) self%left_out_t = t
      self%left_out = self%left_out + 1
   end subroutine look_at_pivot

   !> Whether reactions are not told from round-off, unless that is how the motion has them everywhere.
   pure logical function is_singular(self, weakest)
      type(extremes_t), intent(in) :: self
      real(wp), intent(in) :: weakest

      is_singular = weakest <= min(reaction_pivot, weaker*self%strongest)
   end function is_singular

   !> The value of a column, or the size of a vector; not a number where it is not told from round-off.
   pure real(wp) function value_of(self, i, t, h, y, sample) result(value)
      type(extremes_t), intent(in) :: self
      integer, intent(in) :: i
      real(wp), intent(in) :: t, h
      real(wp), intent(in), contiguous :: y(:)
      type(sample_t), intent(in) :: sample
      integer :: j

      if (self%of_reaction(i) .and. is_singular(self, sample%weakest)) then
         value = ieee_value(value, ieee_quiet_nan)
         return
      end if
      if (self%column(i) > 0) then
         value = column_value(self%column(i), self%states, t, h, y, sample)
         return
      end if
      value = 0.0_wp
      do j = self%vector(1, i), self%vector(2, i)
         value = value + sample%lambda(self%multipliers(j))**2
      end do
      value = sqrt(value)
   end function value_of

   !> Takes a value for what is followed, and for an extreme if it is one.
   pure subroutine keep(self, i, t, value)
      type(extremes_t), intent(inout) :: self
      integer, intent(in) :: i
      real(wp), intent(in) :: t, value

      if (.not. ieee_is_finite(value)) then
         self%known(i) = 0
         return
      end if
      self%t_past(:, i) = [self%t_past(2, i), t]
      self%past(:, i) = [self%past(2, i), value]
      self%known(i) = min(2, self%known(i) + 1)
      call try(self, i, t, value)
   end subroutine keep

   !> Takes a value for an extreme if it is one.
   pure subroutine try(self, i, t, value)
      type(extremes_t), intent(inout) :: self
      integer, intent(in) :: i
      real(wp), intent(in) :: t, value
      integer :: k

      do k = 1, 2
         if (.not. signs(k)*value > self%best(k, i)) cycle
         self%best(k, i) = signs(k)*value
         self%t_best(k, i) = t
      end do
   end subroutine try

   !> Whether a value may be more of an extreme inside the step than at its ends: by the tangents at both ends of the parabola
   !! through them and the place before, made steeper by what neighboring slopes differ. Where there is no place before, behind a
   !! start or a jump, it always may: such a step need not be short.
   pure logical function may_be_inside(self, i, k) result(answer)
      type(extremes_t), intent(in) :: self
      integer, intent(in) :: i, k
      real(wp) :: before, bend, first, h, last, slope, top, va, vb

      answer = .false.
      h = self%ends(i) - self%t_past(2, i)
      if (self%known(i) == 0 .or. .not. abs(h) > 0.0_wp .or. .not. ieee_is_finite(self%behind(i))) return
      answer = self%known(i) == 1
      if (answer) return
      va = signs(k)*self%past(2, i)
      vb = signs(k)*self%behind(i)
      ! Rises over a step: before it, and over it.
      slope = vb - va
      before = (va - signs(k)*self%past(1, i))*h/(self%t_past(2, i) - self%t_past(1, i))
      bend = (slope - before)*h/(self%ends(i) - self%t_past(1, i))
      first = slope - bend + margin*(abs(slope) + abs(before))
      last = slope + bend - margin*(abs(slope) + abs(before))
      if (first <= 0.0_wp .or. last >= 0.0_wp) return
      ! Where both tangents meet.
      top = va + first*min(1.0_wp, (slope - last)/(first - last))
      if (top > self%best(k, i)) answer = top > worthwhile(self, i, k)
   end function may_be_inside

   !> What is more of an extreme than what there is, by more than round-off.
   pure real(wp) function worthwhile(self, i, k) result(value)
      type(extremes_t), intent(in) :: self
      integer, intent(in) :: i, k
      integer :: j

      value = self%best(k, i) + worth*abs(self%best(k, i))
      if (self%column(i) > 0) return
      do j = 1, size(self%sample%lambda)
         value = max(value, self%best(k, i) + round_off*abs(self%sample%lambda(j)))
      end do
   end function worthwhile

   !> Looks for extremes inside a step: in its middle, and then where the parabola has its vertex that promises most.
   subroutine look_inside(self, ode, step, error)
      type(extremes_t), intent(inout) :: self
      class(constrained_ode_t), intent(inout) :: ode
      class(step_t), intent(inout) :: step
      type(error_t), allocatable, intent(inout) :: error
      real(wp) :: gain, largest, t, t_next
      integer :: i, k, left

      left = 1 + refinements*max(1, count(self%places > 0 .and. spread(self%column > 0, 1, 2)))
      do while (left > 0)
         largest = 0.0_wp
         do i = 1, self%n
            do k = 1, 2
               if (self%places(k, i) == 0) cycle
               call promise(self, i, k, t, gain)
               if (gain > largest) then
                  largest = gain
                  t_next = t
               end if
            end do
         end do
         if (.not. largest > 0.0_wp) return
         call evaluate(self, ode, step, t_next, self%inside, error)
         if (allocated(error)) return
         do i = 1, self%n
            do k = 1, 2
               if (self%places(k, i) > 0) call take_in(self, i, k, t_next, self%inside(i))
            end do
         end do
         left = left - 1
      end do
   end subroutine look_inside

   !> Where a value is to be looked at next, and how much of an extreme it promises, as a part of what there is; 0: nothing.
   pure subroutine promise(self, i, k, t, gain)
      type(extremes_t), intent(in) :: self
      integer, intent(in) :: i, k
      real(wp), intent(out) :: t, gain
      real(wp) :: bend, left, right, top, x(3)

      gain = huge(1.0_wp)
      t = 0.5_wp*(self%t_past(2, i) + self%ends(i))
      if (self%places(k, i) == 2) return
      gain = 0.0_wp
      x = (self%x(:, k, i) - self%t_past(2, i))/(self%ends(i) - self%t_past(2, i))
      associate (v => self%v(:, k, i))
         left = (v(2) - v(1))/(x(2) - x(1))
         right = (v(3) - v(2))/(x(3) - x(2))
         bend = (right - left)/(x(3) - x(1))
         if (bend >= 0.0_wp) return
         t = 0.5_wp*(x(1) + x(2) - left/bend)
         if (t <= 0.0_wp .or. t >= 1.0_wp .or. any(abs(t - x) < near)) return
         top = v(1) + (t - x(1))*(left + (t - x(2))*bend)
      end associate
      t = self%t_past(2, i) + t*(self%ends(i) - self%t_past(2, i))
      if (top > worthwhile(self, i, k)) gain = (top - self%best(k, i))/max(abs(top), tiny(1.0_wp))
   end subroutine promise

   !> Takes a place in among those that are known, of which the highest stays with its neighbors.
   pure subroutine take_in(self, i, k, t, value)
      type(extremes_t), intent(inout) :: self
      integer, intent(in) :: i, k
      real(wp), intent(in) :: t, value
      real(wp) :: all_v(4), all_x(4), begin, end
      integer :: first, n

      begin = self%t_past(2, i)
      end = self%ends(i)
      if ((t - begin)*(end - begin) <= 0.0_wp .or. (end - t)*(end - begin) <= 0.0_wp) return
      if (.not. ieee_is_finite(value)) then
         self%places(k, i) = 0
         return
      end if
      call try(self, i, t, value)
      if (self%places(k, i) == 2) then
         self%x(:, k, i) = [begin, t, end]
         self%v(:, k, i) = signs(k)*[self%past(2, i), value, self%behind(i)]
         self%places(k, i) = 3
         return
      end if
      if (any(abs(self%x(:, k, i) - t) <= near*abs(end - begin))) return
      n = count((self%x(:, k, i) - t)*(end - begin) < 0.0_wp)
      all_x = [self%x(:n, k, i), t, self%x(n + 1:, k, i)]
      all_v = [self%v(:n, k, i), signs(k)*value, self%v(n + 1:, k, i)]
      first = max(1, min(2, maxloc(all_v, 1) - 1))
      self%x(:, k, i) = all_x(first:first + 2)
      self%v(:, k, i) = all_v(first:first + 2)
   end subroutine take_in

   !> Names of the columns of a summary that tell of extremes, a comma before each.
   function extreme_columns(name, both) result(text)
      !> What is followed.
      character(*), intent(in) :: name
      !> Whether the smallest is told too.
      logical, intent(in) :: both
      !> Two columns of each.
      character(:), allocatable :: text

      text = ''
      if (both) text = ','//csv_field(name//'_min')//','//csv_field(name//'_min_t')
      text = text//','//csv_field(name//'_max')//','//csv_field(name//'_max_t')
   end function extreme_columns

   !> Names of all of them.
   function names(self) result(text)
      !> The extremes.
      class(extremes_t), intent(in) :: self
      !> A comma before each.
      character(:), allocatable :: text
      type(row_t) :: row
      integer :: i

      call row%create()
      do i = 1, self%n
         text = extreme_columns(self%asked(i)%name, self%both(i))
         call row%add(text(2:))
      end do
      text = row%letters(:row%used)
      if (self%n > 0) text = ','//text
   end function names

   !> Appends them to a row; what was never met stays empty.
   subroutine fields(self, row)
      !> The extremes.
      class(extremes_t), intent(in) :: self
      !> The row.
      type(row_t), intent(inout) :: row
      integer :: i, k

      do i = 1, self%n
         do k = merge(2, 1, self%both(i)), 1, -1
            if (self%best(k, i) > -huge(1.0_wp)) then
               call row%add(signs(k)*self%best(k, i))
               call row%add(self%t_best(k, i))
            else
               call row%add('')
               call row%add('')
            end if
         end do
      end do
   end subroutine fields

   !> What is to be said of them.
   subroutine remark(self, text)
      !> The extremes.
      class(extremes_t), intent(in) :: self
      !> One line without commas; empty if there is nothing.
      character(:), allocatable, intent(out) :: text

      text = ''
      if (self%left_out > 0) text = 'reactions near t = '//to_text(self%left_out_t)//' s are left out of the peaks: '// &
                                    'a singular position; where they are written there they are no more than round-off'
   end subroutine remark

   !> Passes them through an archive.
   subroutine serialize(self, archive)
      !> The extremes; initialized with the same arguments if they are restored.
      class(extremes_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      if (self%n == 0) return
      call archive%list('extremes', self%best)
      call archive%list('times of extremes', self%t_best)
      call archive%list('times followed', self%t_past)
      call archive%list('values followed', self%past)
      call archive%list('places followed', self%known)
      call archive%item('largest of the smallest pivots', self%strongest)
      call archive%item('reactions left out', self%left_out)
      call archive%item('first time of them', self%left_out_t)
      if (allocated(archive%error) .or. .not. archive%reading) return
      if (any([size(self%best), size(self%t_best), size(self%t_past), size(self%past)] /= 2*self%n) .or. &
          any([size(self%best, 1), size(self%t_best, 1), size(self%t_past, 1), size(self%past, 1)] /= 2) .or. &
          size(self%known) /= self%n) &
         call raise(archive%error, 'archive', 'it is of other extremes', 'use the program that wrote it')
   end subroutine serialize

end module taut_case_extremes
