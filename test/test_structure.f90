!> Tests of structured constraint matrices and their solvers.
module test_structure
   use testing, only: check, check_below, new_test, no_error, test_t
   use systems, only: new_compound, new_coupler, new_particle, sleigh_in_space, two_rods
   use test_normal_solver, only: factorize
   use test_linalg, only: largest, random_vector, restart_random, with_spectrum
   use taut_kinds, only: wp
   use taut_error, only: error_t, to_text
   use taut_constrained_method_options, only: method_t
   use taut_constrained_simulate, only: simulate
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_ordering, only: bandwidth, minimum_degree, reverse_cuthill_mckee
   use taut_linalg_sparse_factor, only: sparse_factor_t
   use taut_linalg_csr, only: csr_t
   use taut_linalg_normal_solver, only: normal_solver_t
   use taut_linalg_normal_solver_choose, only: choose_solver, solver_names
   use taut_model_chain, only: chain_t, new_chain
   use taut_model_pendulum, only: new_pendulum, pendulum_t
   use taut_ode_options, only: integration_options_t, integration_result_t
   use taut_ode_status, only: status_reached_end
   implicit none (type, external)
   private
   public :: collect_structure

contains

   !> All tests of this module.
   function collect_structure() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('products of sparse rows', products), &
               new_test('orderings of a shuffled chain, a tree and a net', orderings), &
               new_test('the operator on random patterns', random_patterns), &
               new_test('the operator on chains', chains), &
               new_test('a row without entries', empty_row), &
               new_test('each solver, each system: the same motion', solvers_agree)]
   end function collect_structure

   !> A random pattern of c rows of groups of columns, the i-th of them in row i.
   subroutine random_pattern(c, groups, g, density, first, column)
      integer, intent(in) :: c, groups, g
      real(wp), intent(in) :: density
      integer, allocatable, intent(out) :: first(:), column(:)
      real(wp) :: u(1)
      integer :: i, j, k

      first = [1]
      allocate (column(0))
      do i = 1, c
         do j = 1, groups
            u = random_vector(1)
            if (0.5_wp*(u(1) + 1.0_wp) < density .or. j == i) column = [column, ((j - 1)*g + k, k=1, g)]
         end do
         first = [first, size(column) + 1]
      end do
   end subroutine random_pattern

   subroutine products(failure)
      character(:), allocatable, intent(inout) :: failure
      type(csr_t) :: rows
      integer, allocatable :: first(:), column(:)
      real(wp), allocatable :: a(:, :), v(:), r(:), b(:), lambda(:), d(:)
      integer :: c, g, i, k, part
      character(:), allocatable :: label

      call restart_random()
      do g = 1, 4
         do c = 1, 6
            call random_pattern(c, 5, g, 0.1_wp*(c + g), first, column)
            call rows%set_pattern(5*g, first, column)
            label = 'groups of '//to_text(g)//', '//to_text(c)//' rows'
            if (g <= 3 .and. size(column) > 0) &
               call check(failure, rows%group >= g, 'groups of '//to_text(rows%group)//' found, '//label)
            if (size(column) > 0) rows%values(:) = random_vector(size(column))
            a = spread(spread(0.0_wp, 1, c), 2, 5*g)
            do i = 1, c
               do k = first(i), first(i + 1) - 1
                  a(i, column(k)) = rows%values(k)
               end do
            end do
            call check_below(failure, largest(rows%dense() - a), 0.0_wp, 'all entries, '//label)
            v = random_vector(5*g)
            do part = 0, c
               b = random_vector(max(part, 1))
               b = b(:part)
               r = b
               call rows%multiply(v, r)
               call check_below(failure, sum(abs(r - matmul(a(:part, :), v))), 1.0e-14_wp, 'product, '//label)
               call rows%multiply(v, r, b)
               call check_below(failure, sum(abs(r - (matmul(a(:part, :), v) - b))), 1.0e-14_wp, 'product less b, '//label)
               lambda = b
               d = v
               call rows%subtract_transposed(lambda, d)
               call check_below(failure, sum(abs(d - (v - matmul(lambda, a(:part, :))))), 1.0e-13_wp, 'transposed, '//label)
            end do
            call rows%set_dense(2.0_wp*a)
            call check_below(failure, largest(rows%dense() - 2.0_wp*a), 0.0_wp, 'taken from all entries, '//label)
         end do
      end do
   end subroutine products

   !> The graph of a list of pairs.
   subroutine graph_of(n, from, to, first, neighbor)
      integer, intent(in) :: n, from(:), to(:)
      integer, allocatable, intent(out) :: first(:), neighbor(:)
      integer :: k, v

      first = [1]
      allocate (neighbor(0))
      do v = 1, n
         do k = 1, size(from)
            if (from(k) == v) neighbor = [neighbor, to(k)]
            if (to(k) == v) neighbor = [neighbor, from(k)]
         end do
         first = [first, size(neighbor) + 1]
      end do
   end subroutine graph_of

   !> Entries of L in an ordering.
   function fill_of(n, from, to, order) result(entries)
      integer, intent(in) :: n, from(:), to(:), order(:)
      integer :: entries, i, k, p, place(n)
      integer, allocatable :: row(:), column(:)
      type(sparse_factor_t) :: factor

      do i = 1, n
         place(order(i)) = i
      end do
      allocate (row(0), column(0))
      do p = 1, n
         do k = 1, size(from)
            if (max(place(from(k)), place(to(k))) /= p) cycle
            row = [row, p]
            column = [column, min(place(from(k)), place(to(k)))]
         end do
      end do
      call factor%init(n, row, column)
      entries = size(factor%row)
   end function fill_of

   subroutine orderings(failure)
      character(:), allocatable, intent(inout) :: failure
      integer, parameter :: n = 63, side = 8
      integer, allocatable :: first(:), neighbor(:), from(:), to(:)
      integer :: i, j, order(n), net(side*side)

      ! A chain whose members are numbered in steps of 17 modulo 62, and a second one of a single member.
      call graph_of(n, [(1 + mod(17*i, 62), i=0, 60)], [(1 + mod(17*(i + 1), 62), i=0, 60)], first, neighbor)
      call check(failure, bandwidth(first, neighbor, [(i, i=1, n)]) > 10, 'the chain is not shuffled')
      call reverse_cuthill_mckee(first, neighbor, order)
      call check_permutation(order)
      call check(failure, bandwidth(first, neighbor, order) == 1, 'bandwidth of a chain')

      ! A binary tree: vertex i hangs on i/2.
      from = [(i, i=2, n)]
      to = from/2
      call graph_of(n, from, to, first, neighbor)
      call minimum_degree(first, neighbor, order)
      call check_permutation(order)
      call check(failure, fill_of(n, from, to, order) == n - 1, 'a tree is filled in')
      call check(failure, fill_of(n, from, to, [(i, i=1, n)]) > n - 1, 'from its root, it is not')

      ! A square net: no ordering is without fill, and the given one has about side^3.
      deallocate (from, to)
      allocate (from(0), to(0))
      do j = 1, side
         do i = 1, side
            if (i < side) then
               from = [from, (j - 1)*side + i]
               to = [to, (j - 1)*side + i + 1]
            end if
            if (j < side) then
               from = [from, (j - 1)*side + i]
               to = [to, j*side + i]
            end if
         end do
      end do
      call graph_of(side*side, from, to, first, neighbor)
      call minimum_degree(first, neighbor, net)
      call check(failure, fill_of(side*side, from, to, net) < 2*fill_of(side*side, from, to, [(i, i=1, side*side)])/3, &
                 'fill of a net')
      call reverse_cuthill_mckee(first, neighbor, net)
      call check(failure, bandwidth(first, neighbor, net) <= side, 'bandwidth of a net')

   contains

      subroutine check_permutation(list)
         integer, intent(in) :: list(:)
         integer :: k

         call check(failure, all([(count(list == k) == 1, k=1, size(list))]), 'not an ordering')
      end subroutine check_permutation

   end subroutine orderings

   !> A random A with dependent rows of its own pattern: P = K^-1 A^T S^+ A is the projector, multipliers are of minimum norm.
   subroutine random_patterns(failure)
      character(:), allocatable, intent(inout) :: failure
      integer, parameter :: groups = 16
      type(block_diagonal_t) :: k
      integer, allocatable :: first(:), column(:), f(:)
      type(csr_t) :: rows, full
      real(wp), allocatable :: a(:, :), values(:)
      integer :: c, copies, g, i, info, l

      call restart_random()
      do g = 1, 3
         do c = 4, 16, 4
            do copies = 0, 3
               call random_pattern(c, groups, g, 0.25_wp, first, column)
               allocate (values(size(column)))
               values = random_vector(size(column))
               ! Far from singular.
               do i = 1, c
                  do l = first(i), first(i + 1) - 1
                     if (column(l) == (i - 1)*g + 1) values(l) = 4.0_wp
                  end do
               end do
               ! Copies of the first rows, in other units and signs.
               do i = 1, copies
                  f = [(l, l=first(i), first(i + 1) - 1)]
                  column = [column, column(f)]
                  values = [values, -3.0_wp*i*values(f)]
                  first = [first, size(column) + 1]
               end do
               call rows%set_pattern(groups*g, first, column)
               rows%values(:) = values
               a = rows%dense()
               call full%init(size(a, 1), size(a, 2))
               call full%set_dense(a)
               call k%init(spread(1, 1, groups*g))
               call k%set_identity()
               call one('K = I')
               call k%set_diagonal(2.0_wp + random_vector(groups*g))
               call one('K diagonal')
               call k%init([1, 3, 2, 4, 2, spread(1, 1, groups*g - 12)])
               call k%set_diagonal(2.0_wp + random_vector(groups*g))
               call k%set_block(2, with_spectrum([1.0_wp, 2.0_wp, 3.0_wp]))
               call k%set_block(4, with_spectrum([1.0_wp, 2.0_wp, 3.0_wp, 1.5_wp]))
               call one('K of blocks')
               deallocate (values)
            end do
         end do
      end do

   contains

      subroutine one(metric)
         character(*), intent(in) :: metric
         class(normal_solver_t), allocatable :: onto, reference
         real(wp) :: d(groups*g), x(groups*g), dense(groups*g, groups*g), lambda(size(a, 1)), expected(size(a, 1)), r(size(a, 1))
         integer :: s
         character(:), allocatable :: label

         dense(:, :) = k%dense()
         call k%factorize(info)
         d = random_vector(groups*g)
         call choose_solver('dgelsd', full, size(a, 1), k%first(2:) - k%first(:size(k%first) - 1), 0.0_wp, reference)
         call factorize(reference, full, k, metric == 'K = I', info)
         call reference%multipliers(matmul(a, d), expected)
         do s = 1, size(solver_names)
            label = trim(solver_names(s))//', '//metric//', c = '//to_text(size(a, 1))//', groups of '//to_text(g)
            call choose_solver(solver_names(s), rows, size(a, 1), k%first(2:) - k%first(:size(k%first) - 1), 0.0_wp, onto)
            call factorize(onto, rows, k, metric == 'K = I', info)
            call check(failure, info == 0 .and. onto%rank == reference%rank, 'rank '//to_text(onto%rank)//', '//label)
            x = d
            call onto%project(rows, spread(0.0_wp, 1, size(a, 1)), x, r, lambda)
            call check_below(failure, sum(abs(matmul(a, x))), 1.0e-9_wp, 'what is left, '//label)
            call check_below(failure, sum(abs(r - matmul(a, d))), 1.0e-12_wp, 'the violation, '//label)
            ! What was taken off is K^-1 A^T lambda, and nothing else.
            call check_below(failure, sum(abs(matmul(dense, d - x) - matmul(lambda, a))), 1.0e-9_wp, 'reactions, '//label)
            call onto%minimum_norm(lambda)
            call check_below(failure, maxval(abs(lambda - expected)), 1.0e-8_wp*(1.0_wp + maxval(abs(expected))), &
                             'multipliers, '//label)
         end do
      end subroutine one

   end subroutine random_patterns

   !> Chains that hang at one end, at both or at none, of any length, against DGELSD on all entries; in a straight one that
   !! hangs at both ends a row is redundant.
   subroutine chains(failure)
      character(:), allocatable, intent(inout) :: failure
      type(csr_t) :: rows, full
      type(block_diagonal_t) :: k
      integer :: c, i, l, n, shorter_end, shorter_start
      integer, allocatable :: first(:), column(:)

      call restart_random()
      do c = 2, 9
         do shorter_start = 0, 2, 2
            do shorter_end = 0, 2, 2
               n = 2*(c + 1) - shorter_start - shorter_end
               first = [1, (4*i - shorter_start + 1, i=1, c - 1), 4*c - shorter_start - shorter_end + 1]
               column = [((2*(i - 1) + l - shorter_start, l=1, 4), i=1, c)]
               column = pack(column, column >= 1 .and. column <= n)
               call rows%set_pattern(n, first, column)
               call full%init(c, n)
               call k%init(spread(1, 1, n))
               call k%set_diagonal(2.0_wp + random_vector(n))
               rows%values(:) = random_vector(size(column))
               call one(.true., random_vector(c))
               call one(.false., random_vector(c))
               ! All along x.
               rows%values(:) = merge(1.0_wp, 0.0_wp, mod(column, 2) == 1)
               do i = 2 - shorter_start/2, c
                  rows%values(first(i):first(i) + 1) = -rows%values(first(i):first(i) + 1)
               end do
               call one(.true., spread(0.0_wp, 1, c))
               call one(.false., spread(0.0_wp, 1, c))
            end do
         end do
      end do

   contains

      subroutine one(identity, b)
         logical, intent(in) :: identity
         real(wp), intent(in) :: b(:)
         class(normal_solver_t), allocatable :: onto, reference
         real(wp) :: d(n), expected(n), lambda(c), r(c), x(n), expected_lambda(c), expected_r(c)
         integer :: info
         character(:), allocatable :: label

         label = 'c = '//to_text(c)//', n = '//to_text(n)
         call full%set_dense(rows%dense())
         call k%factorize(info)
         call choose_solver('dgelsd', full, c, spread(1, 1, n), 0.0_wp, reference)
         call factorize(reference, full, k, identity, info)
         call choose_solver('banded', rows, c, spread(1, 1, n), 0.0_wp, onto)
         call factorize(onto, rows, k, identity, info)
         call check(failure, info == 0 .and. onto%rank == reference%rank, 'rank '//to_text(onto%rank)//', '//label)
         d = random_vector(n)
         x = d
         expected = d
         call onto%project(rows, b, x, r, lambda)
         call reference%project(full, b, expected, expected_r, expected_lambda)
         call check_below(failure, maxval(abs(r - expected_r)), 1.0e-13_wp, 'the violation, '//label)
         call check_below(failure, maxval(abs(x - expected)), 1.0e-9_wp, 'what is left, '//label)
         call onto%minimum_norm(lambda)
         call check_below(failure, maxval(abs(lambda - expected_lambda)), 1.0e-8_wp*(1.0_wp + maxval(abs(expected_lambda))), &
                          'multipliers, '//label)
         ! Twice the same: what the first pass has found serves any number of vectors.
         call onto%multipliers(expected_r, lambda)
         call onto%minimum_norm(lambda)
         call check_below(failure, maxval(abs(lambda - expected_lambda)), 1.0e-8_wp*(1.0_wp + maxval(abs(expected_lambda))), &
                          'multipliers alone, '//label)
      end subroutine one

   end subroutine chains

   !> A row without entries has no part in anything, whatever the solver.
   subroutine empty_row(failure)
      character(:), allocatable, intent(inout) :: failure
      type(csr_t) :: rows
      class(normal_solver_t), allocatable :: onto
      type(block_diagonal_t) :: none
      real(wp) :: d(4), lambda(3), r(3)
      integer :: info, s

      ! {1, 1, 0, 0}, nothing, and {0, 0, 1, -1}; the last row is the second group.
      call rows%set_pattern(4, [1, 3, 3, 5], [1, 2, 3, 4])
      rows%values(:) = [1.0_wp, 1.0_wp, 1.0_wp, -1.0_wp]
      do s = 1, size(solver_names)
         call choose_solver(solver_names(s), rows, 3, [1, 1, 1, 1], 0.0_wp, onto)
         call factorize(onto, rows, none, .true., info)
         d = [3.0_wp, 1.0_wp, 2.0_wp, 4.0_wp]
         call onto%project(rows, [0.0_wp, 0.0_wp, 0.0_wp], d, r, lambda)
         call check(failure, info == 0 .and. onto%rank == 2, 'rank, '//trim(solver_names(s)))
         call check_below(failure, maxval(abs(d - [1.0_wp, -1.0_wp, 3.0_wp, 3.0_wp])), 1.0e-14_wp, 'result, '//solver_names(s))
         call check_below(failure, maxval(abs(lambda - [2.0_wp, 0.0_wp, -1.0_wp])), 1.0e-14_wp, 'lambda, '//solver_names(s))
      end do
   end subroutine empty_row

   !> Solvers do not decide where a system goes: redundant, nonholonomic and nearly singular ones included.
   subroutine solvers_agree(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: pendulum
      type(chain_t) :: chain
      type(error_t), allocatable :: error
      type(state_t) :: at

      call new_pendulum(pendulum, 1.0_wp, 1.0_wp, 9.81_wp, 1, error)
      call each('pendulum', pendulum, [1.0_wp, 0.0_wp], [0.0_wp, 0.0_wp])
      call new_pendulum(pendulum, 1.0_wp, 1.0_wp, 9.81_wp, 3, error)
      call each('pendulum with copies', pendulum, [1.0_wp, 0.0_wp], [0.0_wp, 0.0_wp])
      ! The cranks pass the level position, where one of them becomes redundant.
      call each('coupler', new_coupler(3), [0.6_wp, -0.8_wp, 0.0_wp], [0.0_wp, 0.0_wp, 0.0_wp])
      call each('compound pendulum', new_compound(), [0.3_wp, -0.4_wp, 0.8_wp, 0.6_wp], [0.0_wp, 0.0_wp, 0.0_wp])
      call each('sleigh', new_particle(sleigh_in_space), [0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp])
      call each('two rods', new_particle(two_rods), [1.0_wp, 0.0_wp], [0.0_wp, 0.0_wp])
      call new_chain(chain, 12, 1.0_wp, 1.0_wp, 9.81_wp, error)
      call chain%start(0.0_wp, at)
      call each('chain', chain, at%x, at%v)
      chain%m(3) = 2.0_wp
      call each('chain with another mass', chain, at%x, at%v)

   contains

      subroutine each(name, model, x, v)
         character(*), intent(in) :: name
         class(mechanical_system_t), intent(in) :: model
         real(wp), intent(in) :: x(:), v(:)
         type(method_t) :: method
         type(integration_options_t) :: options
         type(integration_result_t) :: result
         type(state_t) :: end_state
         real(wp) :: expected(size(x))
         integer :: i

         options%rtol = 1.0e-8_wp
         options%atol = 1.0e-9_wp
         do i = 0, 2*size(solver_names) - 1
            method%solver = solver_names(1 + modulo(i, size(solver_names)))
            method%stage_projection = 'newton'
            if (i >= size(solver_names)) method%stage_projection = 'none'
            if (allocated(end_state%x)) deallocate (end_state%x, end_state%v, end_state%w)
            end_state%t = 0.0_wp
            end_state%x = x
            end_state%v = v
            allocate (end_state%w(0))
            call simulate(model, end_state, 0.5_wp, result, error, method, options)
            call no_error(failure, error)
            call check(failure, result%status == status_reached_end, name//' stopped with '//trim(method%solver))
            if (allocated(failure)) return
            if (i == 0) expected = end_state%x
            call check_below(failure, maxval(abs(end_state%x - expected)), 1.0e-6_wp, name//' moves otherwise with '// &
                             trim(method%solver)//', '//trim(method%stage_projection))
         end do
      end subroutine each

   end subroutine solvers_agree

end module test_structure
