!> Tests of the decision on the rank: mechanisms of exactly known rank, every solver, dead points.
module test_rank
   use, intrinsic :: iso_fortran_env, only: int64, output_unit
   use testing, only: check, check_below, new_test, no_error, test_t
   use test_linalg, only: orthogonal, random_vector, restart_random
   use taut_kinds, only: wp
   use taut_error, only: error_t, to_text
   use taut_constrained_method, only: constrained_ode_t
   use taut_constrained_method_choose, only: new_constrained_ode
   use taut_constrained_method_options, only: method_t
   use taut_constrained_system, only: state_t
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_csr, only: csr_t
   use taut_linalg_normal_solver, only: normal_solver_t
   use taut_linalg_normal_solver_choose, only: choose_solver, solver_names
   use taut_linalg_rank, only: dead_pivot, exactly_dependent
   use taut_linalg_rank_keeper, only: rank_keeper_t
   use taut_linalg_row_selection, only: row_selection_t
   use taut_model_n_four_bar, only: n_four_bar_t, new_n_four_bar
   use taut_ode_integrate, only: integrator_t
   use taut_ode_options, only: integration_options_t, integration_result_t
   implicit none (type, external)
   private
   public :: collect_rank, collect_rank_study

   !> How a matrix is laid out.
   integer, parameter :: without_pattern = 0, of_entries = 1, of_bodies = 2

   !> Bodies and the rows of their joints, in whole numbers, so that the rank is exact.
   type :: mechanism_t
      integer :: bodies = 0
      !> How many times longer than wide they are, in the direction of x.
      integer :: slender = 1
      !> Where the bodies' velocities are taken: (3, bodies).
      integer, allocatable :: center(:, :)
      !> Entries row by row: (rows), (entries).
      integer, allocatable :: first(:), column(:), value(:)
   contains
      procedure :: joint
      procedure :: add_row
   end type mechanism_t

   !> What became of the checks by each solver, and of the decision itself, number 0.
   type :: tally_t
      !> How many, with how many wrong, told not to be decided, right but with a motion that is not exact.
      integer :: checks(0:size(solver_names)) = 0, wrong(0:size(solver_names)) = 0, undecided(0:size(solver_names)) = 0, &
                 inexact(0:size(solver_names)) = 0
      !> The first thing that was wrong.
      character(:), allocatable :: first
   contains
      procedure :: write => write_tally
   end type tally_t

contains

   !> All tests of this module.
   function collect_rank() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [ &
              new_test('random mechanisms by every solver', random_mechanisms), &
              new_test('loops that share their cranks', coupled_loops), &
              new_test('units, masses and lengths do not matter', any_units), &
              new_test('nor does slenderness', slender_parts), &
              new_test('an axis that is nearly parallel', tilted_axis), &
              new_test('rows of zeros are set aside', empty_rows), &
              new_test('null vectors have no large entries', small_shares), &
              new_test('a dead point is passed with the same rank', dead_point_held), &
              new_test('a start in a singular position: the rank rises once', rank_rises), &
              new_test('a change of the rank is told with its time and row', told_change)]
   end function collect_rank

   !> Slow tests, run by name: `fpm test -- 'rank study'`.
   function collect_rank_study() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('a thousand mechanisms', thousand_mechanisms)]
   end function collect_rank_study

   !> A row with entries in a list of columns.
   subroutine add_row(self, column, value)
      class(mechanism_t), intent(inout) :: self
      integer, intent(in) :: column(:), value(:)
      integer :: i, j
      integer, allocatable :: c(:), v(:)

      if (.not. allocated(self%first)) then
         allocate (self%first, source=[1])
         allocate (self%column(0), self%value(0))
      end if
      allocate (c(0), v(0))
      do j = 1, 6*self%bodies
         do i = 1, size(column)
            if (column(i) == j) then
               c = [c, j]
               v = [v, value(i)]
            end if
         end do
      end do
      self%column = [self%column, c]
      self%value = [self%value, v]
      self%first = [self%first, size(self%column) + 1]
   end subroutine add_row

   !> A spherical joint, or a hinge about an axis, between two bodies, 0 for the ground.
   subroutine joint(self, one, two, point, axis)
      class(mechanism_t), intent(inout) :: self
      integer, intent(in) :: one, two, point(3)
      integer, intent(in), optional :: axis(3)
      integer :: across(3, 2), k, c1(6), c2(6), v1(6), v2(6)

      c1 = [(6*(one - 1) + k, k=1, 6)]
      c2 = [(6*(two - 1) + k, k=1, 6)]
      do k = 1, 3
         v1 = 0
         v2 = 0
         v1(k) = 1
         v2(k) = -1
         if (one > 0) v1(4:6) = cross(point - self%center(:, one), v1(1:3))
         if (two > 0) v2(4:6) = cross(point - self%center(:, two), v2(1:3))
         call write_row()
      end do
      if (.not. present(axis)) return
      ! Two directions across the axis, in whole numbers.
      across(:, 1) = cross(axis, merge([1, 0, 0], [0, 1, 0], axis(2) /= 0 .or. axis(3) /= 0))
      across(:, 2) = cross(axis, across(:, 1))
      do k = 1, 2
         v1 = [0, 0, 0, across(:, k)]
         v2 = -v1
         call write_row()
      end do

   contains

      subroutine write_row()
         if (one == 0) then
            call self%add_row(c2, v2)
         else if (two == 0) then
            call self%add_row(c1, v1)
         else
            call self%add_row([c1, c2], [v1, v2])
         end if
      end subroutine write_row

   end subroutine joint

   pure function cross(a, b) result(c)
      integer, intent(in) :: a(3), b(3)
      integer :: c(3)

      c = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
   end function cross

   !> The rank by elimination modulo a prime.
   function exact_rank(m) result(rank)
      type(mechanism_t), intent(in) :: m
      integer :: rank, c, i, j, k, n
      integer(int64), parameter :: p = 2147483647_int64
      integer(int64), allocatable :: a(:, :), row(:)
      integer(int64) :: inverse

      c = size(m%first) - 1
      n = 6*m%bodies
      allocate (a(n, c), source=0_int64)
      allocate (row(n))
      do i = 1, c
         do k = m%first(i), m%first(i + 1) - 1
            a(m%column(k), i) = modulo(int(m%value(k), int64), p)
         end do
      end do
      rank = 0
      do j = 1, n
         k = 0
         do i = rank + 1, c
            if (a(j, i) /= 0) then
               k = i
               exit
            end if
         end do
         if (k == 0) cycle
         rank = rank + 1
         row = a(:, k)
         a(:, k) = a(:, rank)
         inverse = power(row(j), p - 2, p)
         do k = 1, n
            row(k) = modulo(row(k)*inverse, p)
         end do
         a(:, rank) = row
         do i = rank + 1, c
            if (a(j, i) == 0) cycle
            inverse = a(j, i)
            do k = j, n
               a(k, i) = modulo(a(k, i) - inverse*row(k), p)
            end do
         end do
      end do
   end function exact_rank

   pure function power(base, exponent, p) result(value)
      integer(int64), intent(in) :: base, exponent, p
      integer(int64) :: value, b, e

      value = 1
      b = base
      e = exponent
      do while (e > 0)
         if (modulo(e, 2_int64) == 1) value = modulo(value*b, p)
         b = modulo(b*b, p)
         e = e/2
      end do
   end function power

   !> A whole number up to a bound, positive or negative.
   function whole(bound) result(k)
      integer, intent(in) :: bound
      integer :: k
      real(wp) :: u(1)

      u = random_vector(1)
      k = nint(bound*u(1))
   end function whole

   function point_near(bound) result(p)
      integer, intent(in) :: bound
      integer :: p(3)

      p = [whole(bound), whole(bound), whole(bound)]
   end function point_near

   !> Loops of hinges with parallel or other axes, bodies with parallel supports, doubled joints; so many times longer than wide.
   function random_mechanism(bodies, slender) result(m)
      integer, intent(in) :: bodies
      integer, intent(in), optional :: slender
      type(mechanism_t) :: m
      integer :: axis(3), from, i, k, point(3)

      m%bodies = bodies
      if (present(slender)) m%slender = slender
      allocate (m%center(3, bodies))
      axis = point_near(3)
      if (all(axis == 0)) axis = [0, 0, 1]
      do i = 1, bodies
         m%center(:, i) = stretched(point_near(20))
         from = modulo(whole(1000), i)
         if (modulo(whole(1000), 4) == 0) then
            call m%joint(from, i, stretched(point_near(20)))
         else
            call m%joint(from, i, stretched(point_near(20)), axis)
         end if
         if (modulo(whole(1000), 5) == 0) then
            axis = point_near(3)
            if (all(axis == 0)) axis = [0, 1, 0]
         end if
      end do
      ! Loops are closed.
      do k = 1, (bodies + 2)/3
         i = 1 + modulo(whole(1000), bodies)
         from = modulo(whole(1000), i)
         point = stretched(point_near(20))
         call m%joint(from, i, point, axis)
         if (modulo(whole(1000), 6) == 0) call m%joint(from, i, point)
      end do

   contains

      function stretched(point)
         integer, intent(in) :: point(3)
         integer :: stretched(3)

         stretched = [m%slender, 1, 1]*point
      end function stretched

   end function random_mechanism

   !> Its matrix with rows in units of their own and a unit of length; laid out without a pattern, with that of the entries, or with
   !! all columns of each body that a row speaks of.
   function matrix_of(m, decades, length, layout) result(a)
      type(mechanism_t), intent(in) :: m
      real(wp), intent(in) :: decades, length
      integer, intent(in) :: layout
      type(csr_t) :: a
      real(wp), allocatable :: dense(:, :), unit(:)
      integer, allocatable :: column(:), first(:)
      integer :: c, i, j, k, n

      c = size(m%first) - 1
      n = 6*m%bodies
      unit = 10.0_wp**(decades*random_vector(c))
      allocate (dense(c, n), source=0.0_wp)
      do i = 1, c
         do k = m%first(i), m%first(i + 1) - 1
            dense(i, m%column(k)) = unit(i)*m%value(k)*merge(length, 1.0_wp, modulo(m%column(k) - 1, 6) >= 3)
         end do
      end do
      if (layout == without_pattern) then
         call a%init(c, n)
         call a%set_dense(dense)
         return
      end if
      first = m%first
      column = m%column
      if (layout == of_bodies) then
         column = [integer ::]
         do i = 1, c
            first(i) = size(column) + 1
            do j = 1, n
               k = 6*((j - 1)/6)
               if (any(dense(i, k + 1:k + 6) < 0.0_wp .or. dense(i, k + 1:k + 6) > 0.0_wp)) column = [column, j]
            end do
         end do
         first(c + 1) = size(column) + 1
      end if
      call a%set_pattern(n, first, column)
      do i = 1, c
         a%values(first(i):first(i + 1) - 1) = dense(i, column(first(i):first(i + 1) - 1))
      end do
   end function matrix_of

   !> Translations and rotations of bodies.
   pure function groups_of(bodies) result(group)
      integer, intent(in) :: bodies
      integer :: group(6*bodies), i

      group = [((i + 2)/3, i=1, 6*bodies)]
   end function groups_of

   !> Rank, constraints that are met, and motions that are the same, by every solver. What cannot be decided is to be told: it is
   !! counted where that is allowed.
   subroutine by_every_solver(failure, m, decades, length, masses, tolerance, label, tally)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_t), intent(in) :: m
      real(wp), intent(in) :: decades, length, masses, tolerance
      character(*), intent(in) :: label
      type(tally_t), intent(inout), optional :: tally
      !> Singular values of more rows, and rows without a pattern, take minutes.
      integer, parameter :: many = 150
      type(csr_t) :: a
      type(rank_keeper_t) :: keeper
      type(block_diagonal_t) :: k
      character(:), allocatable :: fault
      real(wp), allocatable :: d(:), expected(:), lambda(:), r(:), root(:), x(:), zero(:)
      integer :: c, i, info, layout, n, rank, s
      logical :: by_singular_values, undecided, inexact

      if (allocated(failure)) return
      rank = exact_rank(m)
      c = size(m%first) - 1
      n = 6*m%bodies
      allocate (lambda(c), r(c), zero(c), source=0.0_wp)
      ! Moments of inertia have the square of the unit of length, and those across a slender body that of its length.
      root = 10.0_wp**(0.5_wp*masses*random_vector(n))
      do i = 4, n, 6
         root(i:i + 2) = length*[1, m%slender, m%slender]*root(i:i + 2)
      end do
      call k%init(spread(1, 1, n))
      call k%set_diagonal(root**2)
      call k%factorize(info)
      d = random_vector(n)/root
      do layout = merge(without_pattern, of_entries, c <= many), merge(of_bodies, of_entries, present(tally))
         ! The same units in each layout.
         call restart_random()
         a = matrix_of(m, decades, length, layout)
         call keeper%init(a, c, groups_of(m%bodies), 0.0_wp)
         call keeper%decide(a, 0.0_wp)
         undecided = .false.
         ! Of parts that are less slender than that, everything is decided.
         if (present(tally) .and. m%slender >= 100) &
            undecided = count(keeper%kept) < rank .and. maxval(keeper%selection%distance) > exactly_dependent
         if (.not. undecided) &
            call check(fault, count(keeper%kept) == rank, 'rank '//to_text(count(keeper%kept))//' for '//to_text(rank))
         call note(0, .false.)
         do s = 1, size(solver_names)
            by_singular_values = solver_names(s) == 'dgelsd' .or. solver_names(s) == 'factor'
            if (by_singular_values .and. c > many) cycle
            inexact = .false.
            if (.not. undecided) call by_one_solver()
            call note(s, inexact)
         end do
      end do

   contains

      subroutine by_one_solver()
         class(normal_solver_t), allocatable :: onto

         call choose_solver(solver_names(s), a, c, spread(1, 1, n), 0.0_wp, onto)
         call keeper%hand_over(onto)
         call onto%factorize(a, k, .false., info)
         call check(fault, info == 0 .and. onto%rank == rank, 'rank')
         ! An inverse by singular values has errors of eps times the condition of S, in all rows alike; factors do not.
         if (solver_names(s) == 'dgelsd' .and. (present(tally) .or. onto%weakest() < 1.0e-9_wp)) return
         x = d
         call onto%project(a, zero, x, r, lambda)
         call a%multiply(x, r)
         ! In units in which all that is added is of size one.
         do i = 1, c
            r(i) = r(i)*scale_of(i)
         end do
         ! In S, the square, next to nothing may be left of a row, as near a dead point, and of slender parts.
         if (present(tally) .and. (onto%weakest() <= 1.0e3_wp*dead_pivot .or. m%slender >= 100000)) then
            inexact = maxval(abs(r)) > tolerance
            return
         end if
         call check_below(fault, maxval(abs(r)), tolerance, 'what is left')
         if (.not. allocated(expected)) expected = x
         call check_below(fault, norm2(root*(x - expected)), tolerance*norm2(root*d), 'another projection')
      end subroutine by_one_solver

      !> Counts, or fails.
      subroutine note(solver, inexact)
         integer, intent(in) :: solver
         logical, intent(in) :: inexact

         if (allocated(fault)) then
            fault = fault//', '//label//', layout '//to_text(layout)
            if (solver > 0) fault = fault//', '//trim(solver_names(solver))
         end if
         if (present(tally)) then
            tally%checks(solver) = tally%checks(solver) + 1
            if (undecided) tally%undecided(solver) = tally%undecided(solver) + 1
            if (inexact) tally%inexact(solver) = tally%inexact(solver) + 1
            if (allocated(fault)) then
               tally%wrong(solver) = tally%wrong(solver) + 1
               if (.not. allocated(tally%first)) tally%first = fault
               deallocate (fault)
            end if
         else if (allocated(fault) .and. .not. allocated(failure)) then
            failure = fault
         end if
      end subroutine note

      !> 1 over the length of a row in the metric of the masses.
      pure real(wp) function scale_of(row) result(scale)
         integer, intent(in) :: row
         integer :: l

         scale = 0.0_wp
         if (a%full) then
            scale = norm2(a%values((row - 1)*n + 1:row*n)/root)
         else
            do l = a%first(row), a%first(row + 1) - 1
               scale = hypot(scale, a%values(l)/root(a%column(l)))
            end do
         end if
         scale = 1.0_wp/(scale*norm2(root*d))
      end function scale_of

   end subroutine by_every_solver

   !> A table.
   subroutine write_tally(self)
      class(tally_t), intent(in) :: self
      character(len=len(solver_names)) :: names(0:size(solver_names))
      integer :: s

      names = [character(len=len(solver_names)) :: 'rank alone', solver_names]
      write (output_unit, '(a, t20, a)') 'solver', 'checks  wrong  undecided  inexact'
      do s = 0, size(solver_names)
         write (output_unit, '(a, t20, i6, i7, i11, i9)') names(s), self%checks(s), self%wrong(s), self%undecided(s), &
            self%inexact(s)
      end do
   end subroutine write_tally

   subroutine random_mechanisms(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_t) :: m
      integer :: bodies, i

      call restart_random()
      do bodies = 1, 10, 3
         do i = 1, 5
            m = random_mechanism(bodies)
            call by_every_solver(failure, m, 0.0_wp, 1.0_wp, 0.0_wp, 1.0e-9_wp, to_text(bodies)//' bodies, number '//to_text(i))
            ! The tests of one mechanism begin with the same random numbers.
            call skip(10*bodies + i)
         end do
      end do
   end subroutine random_mechanisms

   subroutine skip(numbers)
      integer, intent(in) :: numbers
      real(wp) :: unused(7*numbers)

      unused(:) = random_vector(7*numbers)
   end subroutine skip

   !> Cranks on the ground, one more than couplers between them, all hinges parallel in space.
   function row_of_loops(loops) result(m)
      integer, intent(in) :: loops
      type(mechanism_t) :: m
      integer :: i
      integer, parameter :: axis(3) = [0, 1, 0]

      m%bodies = 2*loops + 1
      allocate (m%center(3, m%bodies), source=0)
      do i = 0, loops
         m%center(:, i + 1) = [2*i, 0, 1]
         call m%joint(0, i + 1, [2*i, 0, 0], axis)
      end do
      do i = 1, loops
         m%center(:, loops + 1 + i) = [2*i - 1, 0, 2]
         call m%joint(i, loops + 1 + i, [2*i - 2, 0, 2], axis)
         call m%joint(loops + 1 + i, i + 1, [2*i, 0, 2], axis)
      end do
   end function row_of_loops

   subroutine coupled_loops(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_t) :: m
      type(csr_t) :: a
      type(row_selection_t) :: selection
      integer, allocatable :: row(:)
      real(wp), allocatable :: value(:)
      integer :: k, loops

      call restart_random()
      do loops = 1, 31, 10
         m = row_of_loops(loops)
         a = matrix_of(m, 3.0_wp, 1.0_wp, of_entries)
         call selection%init(a, a%c, groups_of(m%bodies), 0.0_wp)
         call selection%select(a, 0.0_wp)
         ! One degree of freedom.
         call check(failure, selection%rank == 6*m%bodies - 1, to_text(loops)//' loops: rank '//to_text(selection%rank)//' of '// &
                    to_text(6*m%bodies - 1))
         call check_below(failure, maxval(selection%distance), 1.0e-13_wp, to_text(loops)//' loops: rows that are left out')
         ! The work is linear in the number of loops if a null vector is one of a loop: forces along and moments across.
         do k = 1, a%c
            if (selection%kept(k)) cycle
            call selection%null_vector(k, row, value)
            call check(failure, size(row) <= 12, to_text(loops)//' loops: a null vector of '//to_text(size(row))//' rows')
         end do
      end do
      call by_every_solver(failure, row_of_loops(6), 0.0_wp, 1.0_wp, 3.0_wp, 1.0e-8_wp, 'six loops')
   end subroutine coupled_loops

   subroutine any_units(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_t) :: m
      type(csr_t) :: a
      type(row_selection_t) :: selection
      real(wp) :: weakest(-2:2)
      integer :: i

      call restart_random()
      m = random_mechanism(5)
      do i = -6, 6, 3
         a = matrix_of(m, 0.0_wp, 10.0_wp**i, of_entries)
         call selection%init(a, a%c, groups_of(m%bodies), 0.0_wp)
         call selection%select(a, 0.0_wp)
         weakest(i/3) = selection%smallest_kept
      end do
      call check_below(failure, maxval(weakest)/minval(weakest), 1.0e2_wp, 'how weak rows seem in another unit of length')
      do i = -6, 6, 3
         call by_every_solver(failure, m, 3.0_wp, 10.0_wp**i, 0.0_wp, 1.0e-6_wp, 'lengths of 1e'//to_text(i))
      end do
      call by_every_solver(failure, m, 0.0_wp, 1.0_wp, 4.5_wp, 1.0e-6_wp, 'masses over nine decades')
      call by_every_solver(failure, row_of_loops(3), 3.0_wp, 1.0_wp, 4.5_wp, 1.0e-6_wp, 'loops, masses over nine decades')
      ! Light bodies behind heavy ones: the condition of S is beyond round-off.
      call restart_random()
      call skip(5)
      m = random_mechanism(15)
      call by_every_solver(failure, m, 0.0_wp, 1.0_wp, 4.5_wp, 1.0e-7_wp, 'fifteen bodies, masses over nine decades')
   end subroutine any_units

   !> Parts that are a million times longer than wide; velocities are taken along them and across, or in any other directions.
   subroutine slender_parts(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_t) :: m
      type(csr_t) :: a
      type(row_selection_t) :: selection
      integer :: i, layout, rank
      real(wp) :: weakest

      do i = 1, 3
         call restart_random()
         call skip(i)
         m = random_mechanism(15 + 3*i, 1000000)
         rank = exact_rank(m)
         do layout = without_pattern, of_bodies
            a = matrix_of(m, 3.0_wp, 1.0_wp, layout)
            call decide_rank()
            weakest = selection%smallest_kept
            if (layout == of_entries) cycle
            call turn_velocities(a, m%bodies)
            call decide_rank()
            call check_below(failure, abs(selection%smallest_kept/weakest - 1.0_wp), 1.0e-6_wp, 'how weak rows seem in other axes')
         end do
      end do

   contains

      subroutine decide_rank()
         call selection%init(a, a%c, groups_of(m%bodies), 0.0_wp)
         call selection%select(a, 0.0_wp)
         call check(failure, selection%rank == rank, 'rank '//to_text(selection%rank)//' for '//to_text(rank)//', number '// &
                    to_text(i)//', layout '//to_text(layout))
      end subroutine decide_rank

   end subroutine slender_parts

   !> Velocities and angular velocities of each body in axes of their own.
   subroutine turn_velocities(a, bodies)
      type(csr_t), intent(inout) :: a
      integer, intent(in) :: bodies
      real(wp) :: axes(3, 3, 2*bodies)
      integer :: first, g, i, l

      do g = 1, 2*bodies
         axes(:, :, g) = orthogonal(3)
      end do
      do i = 1, a%c
         if (a%full) then
            do g = 1, 2*bodies
               first = (i - 1)*a%n + 3*g - 2
               a%values(first:first + 2) = matmul(axes(:, :, g), a%values(first:first + 2))
            end do
         else
            do l = a%first(i), a%first(i + 1) - 1, 3
               a%values(l:l + 2) = matmul(axes(:, :, (a%column(l) + 2)/3), a%values(l:l + 2))
            end do
         end if
      end do
   end subroutine turn_velocities

   !> From one body to ninety, rows in units over six decades, lengths over twelve, masses over nine, parts up to a million times
   !! longer than wide.
   subroutine thousand_mechanisms(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_t) :: m
      type(tally_t) :: tally
      integer :: bodies, i
      real(wp) :: length

      do i = 1, 1000
         call restart_random()
         call skip(3*i)
         ! More small ones than large ones.
         bodies = 1 + (90*modulo(37*i, 1000)**2)/1000000
         m = random_mechanism(bodies, 10**modulo(i, 7))
         length = 10.0_wp**(modulo(i, 13) - 6)
         call by_every_solver(failure, m, 3.0_wp, length, 0.0_wp, 1.0e-4_wp, 'number '//to_text(i), tally)
         call skip(2*i)
         call by_every_solver(failure, m, 0.0_wp, 1.0_wp, 4.5_wp, 1.0e-4_wp, 'number '//to_text(i)//' with masses', tally)
      end do
      call tally%write()
      if (allocated(tally%first)) failure = tally%first
   end subroutine thousand_mechanisms

   subroutine told_change(failure)
      character(:), allocatable, intent(inout) :: failure
      type(csr_t) :: a
      type(rank_keeper_t) :: keeper
      type(block_diagonal_t) :: k
      class(normal_solver_t), allocatable :: onto
      real(wp) :: angle
      integer :: i, info

      call a%init(2, 2)
      call k%init([1, 1])
      call keeper%init(a, 2, [1, 1], 0.0_wp)
      call choose_solver('pivoted-cholesky', a, 2, [1, 1], 0.0_wp, onto)
      do i = 0, 3
         angle = merge(0.0_wp, 0.1_wp, i < 2)
         call a%set_dense(reshape([1.0_wp, cos(angle), 0.0_wp, sin(angle)], [2, 2]))
         call keeper%prepare(a, 0.0_wp, onto)
         call onto%factorize(a, k, .true., info)
         call keeper%look(a, onto, real(i, wp), 0.0_wp)
      end do
      call check(failure, count(keeper%kept) == 2 .and. size(keeper%changes, 2) == 1, 'the rank does not rise once')
      if (allocated(failure)) return
      call check_below(failure, maxval(abs(keeper%changes(:, 1) - [3.0_wp, 1.0_wp, 2.0_wp, 2.0_wp])), 0.0_wp, 'what is told of it')
   end subroutine told_change

   !> One axis of a loop out of parallel by an angle: independent above 1e-6, dependent below, and told in between.
   subroutine tilted_axis(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_t) :: m
      type(csr_t) :: a
      type(row_selection_t) :: selection
      real(wp) :: angle
      integer :: full, i, l

      m = row_of_loops(1)
      full = 6*m%bodies - 1
      do i = 2, 13
         angle = 10.0_wp**(-i)
         ! The last row but one is (0, 0, -1) times the difference of rotations: across an axis (0, 1, angle), (0, angle, -1).
         a = matrix_of(m, 0.0_wp, 1.0_wp, of_entries)
         do l = a%first(a%c - 1), a%first(a%c) - 1
            if (modulo(a%column(l) - 1, 6) == 4) a%values(l) = -angle*a%values(l + 1)
         end do
         call selection%init(a, a%c, groups_of(m%bodies), 0.0_wp)
         call selection%select(a, 0.0_wp)
         if (i <= 5) call check(failure, selection%rank > full, 'an axis off by 1e-'//to_text(i)//' is taken for parallel')
         if (i >= 8) call check(failure, selection%rank == full, 'an axis off by 1e-'//to_text(i)//' is not taken for parallel')
         if (i >= 8 .and. i <= 9) call check(failure, maxval(selection%distance) > 1.0e-10_wp, 'it is not told: 1e-'//to_text(i))
      end do
   end subroutine tilted_axis

   subroutine empty_rows(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_t) :: m
      type(csr_t) :: a
      type(row_selection_t) :: selection

      m = row_of_loops(1)
      a = matrix_of(m, 0.0_wp, 1.0_wp, of_entries)
      a%values(a%first(4):a%first(5) - 1) = 0.0_wp
      call selection%init(a, a%c, groups_of(m%bodies), 0.0_wp)
      call selection%select(a, 0.0_wp)
      call check(failure, count(selection%rows%empty) == 1 .and. selection%rows%empty(4) .and. .not. selection%kept(4), &
                 'a row of zeros')
      a%values(:) = 0.0_wp
      call selection%select(a, 0.0_wp)
      call check(failure, selection%rank == 0 .and. all(selection%rows%empty), 'nothing but zeros')
   end subroutine empty_rows

   !> Null vectors in rows of length one, whatever their order, are zero for A and have entries up to 2.
   subroutine small_shares(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_t) :: m
      type(csr_t) :: a
      type(row_selection_t) :: selection
      integer, allocatable :: row(:)
      real(wp), allocatable :: v(:), value(:), zero(:)
      integer :: i, k

      call restart_random()
      do i = 1, 5
         m = random_mechanism(4 + 3*i)
         a = matrix_of(m, 2.0_wp, 1.0_wp, of_entries)
         call selection%init(a, a%c, groups_of(m%bodies), 0.0_wp)
         call selection%select(a, 0.0_wp)
         do k = 1, a%c
            if (selection%kept(k)) cycle
            call selection%null_vector(k, row, value)
            v = spread(0.0_wp, 1, a%c)
            v(row) = value
            zero = spread(0.0_wp, 1, a%n)
            call a%subtract_transposed(v, zero)
            call check_below(failure, maxval(abs(zero)), 1.0e-9_wp, 'A^T v of a null vector')
            call check_below(failure, maxval(abs(v)/selection%rows%row_scale), 2.0001_wp, 'the largest entry of a null vector')
         end do
      end do
   end subroutine small_shares

   !> A row of loops of bars in a plane, integrated.
   subroutine swing(failure, angle, changes, rank)
      character(:), allocatable, intent(inout) :: failure
      real(wp), intent(in) :: angle
      real(wp), allocatable, intent(out) :: changes(:, :)
      integer, intent(out) :: rank
      type(n_four_bar_t) :: bars
      class(constrained_ode_t), allocatable :: ode
      type(integrator_t) :: integrator
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(method_t) :: method
      type(error_t), allocatable :: error
      type(state_t) :: at
      real(wp), allocatable :: y(:)
      real(wp) :: t

      call new_n_four_bar(bars, 3, 1.0_wp, 1.0_wp, 9.81_wp, error)
      call bars%start(angle, 2.0_wp, at)
      call new_constrained_ode(ode, bars, method, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      allocate (y(ode%size()), source=0.0_wp)
      call ode%pack(at, y)
      options%rtol = 1.0e-8_wp
      options%atol = 1.0e-10_wp
      call integrator%init(size(y), options, error)
      t = 0.0_wp
      call integrator%run(ode, t, y, 2.0_wp, result)
      call no_error(failure, result%error)
      rank = count(ode%projector%linear%keeper%kept)
      changes = ode%projector%linear%keeper%changes
   end subroutine swing

   subroutine dead_point_held(failure)
      character(:), allocatable, intent(inout) :: failure
      real(wp), allocatable :: changes(:, :)
      integer :: rank

      call swing(failure, 0.0_wp, changes, rank)
      call check(failure, size(changes, 2) == 0 .and. rank == 13, 'a dead point changes the rank: '//to_text(size(changes, 2)))
   end subroutine dead_point_held

   subroutine rank_rises(failure)
      character(:), allocatable, intent(inout) :: failure
      real(wp), allocatable :: changes(:, :)
      integer :: rank

      call swing(failure, 0.5_wp*acos(-1.0_wp), changes, rank)
      call check(failure, rank == 13, 'rank '//to_text(rank)//' after a start in a singular position')
      call check(failure, size(changes, 2) <= 1, to_text(size(changes, 2))//' changes of the rank')
   end subroutine rank_rises

end module test_rank
