!> Tests of block-diagonal matrices and of the operator K^-1 A^T S^+.
module test_normal_solver
   use testing, only: check, check_below, check_close, new_test, test_t
   use test_linalg, only: identity, largest, orthogonal, random_vector, restart_random, with_spectrum
   use taut_kinds, only: wp
   use taut_error, only: to_text
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_csr, only: csr_t
   use taut_linalg_normal_solver, only: normal_solver_t
   use taut_linalg_normal_solver_choose, only: choose_solver, solver_names
   use taut_linalg_rank_keeper, only: rank_keeper_t
   implicit none (type, external)
   private
   public :: collect_normal_solver, factorize, of_rank, rows_of

   !> Solvers that leave dependent rows out.
   character(len=16), parameter :: unpivoted(2) = [character(len=16) :: 'banded', 'sparse']

contains

   !> All tests of this module.
   function collect_normal_solver() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [ &
              new_test('blocks against their dense matrix', blocks_against_dense), &
              new_test('a factorization by hand', blocks_by_hand), &
              new_test('setting blocks', blocks_set), &
              new_test('a row that is not positive definite', not_positive), &
              new_test('the operator by all solvers', all_solvers), &
              new_test('the operator of one row', one_row), &
              new_test('the operator without rows, and with a row of zeros', no_rows), &
              new_test('the operator of a row that is not finite', bad_row), &
              new_test('redundant rows in very different units', different_units)]
   end function collect_normal_solver

   subroutine blocks_against_dense(failure)
      character(:), allocatable, intent(inout) :: failure

      call restart_random()
      call one([1, 1, 1, 1])
      call one([1, 3, 2])
      call one([4])
      call one([1])
      call one([2, 1, 1, 5])

   contains

      subroutine one(sizes)
         integer, intent(in) :: sizes(:)
         type(block_diagonal_t) :: k
         real(wp), allocatable :: d(:, :), b(:, :), x(:, :), y(:)
         integer :: f, i, info, n
         character(:), allocatable :: label

         n = sum(sizes)
         label = 'blocks from '//to_text(sizes(1))//' to '//to_text(sizes(size(sizes)))//' of order '//to_text(n)
         call k%init(sizes)
         allocate (d(n, n), source=0.0_wp)
         allocate (y(n))
         f = 0
         do i = 1, size(sizes)
            d(f + 1:f + sizes(i), f + 1:f + sizes(i)) = with_spectrum(2.0_wp + random_vector(sizes(i)))
            call k%set_block(i, d(f + 1:f + sizes(i), f + 1:f + sizes(i)))
            f = f + sizes(i)
         end do
         call check(failure, k%n == n .and. (k%diagonal .eqv. all(sizes == 1)), 'order and kind, '//label)
         call check_below(failure, largest(k%dense() - d), 0.0_wp, 'dense, '//label)
         call k%factorize(info)
         call check(failure, info == 0, 'not factorized: '//label)
         x = reshape(random_vector(2*n), [n, 2])
         b = matmul(d, x)
         call k%multiply(x(:, 1), y)
         call check_below(failure, maxval(abs(y - b(:, 1))), 1.0e-14_wp, 'product, '//label)
         call k%solve(2, b)
         call check_below(failure, largest(b - x), 1.0e-13_wp, 'solution, '//label)
         b = matmul(d, x)
         call k%solve_lower(2, b)
         call k%solve_lower_transposed(2, b)
         call check_below(failure, largest(b - x), 1.0e-13_wp, 'solution in two halves, '//label)
         ! L^-1 K L^-T = I: the halves are those of K, and the first of them is the lower one.
         b = d
         call k%solve_lower(n, b)
         call check_below(failure, largest(b - upper(b)), 1.0e-13_wp, 'L^-1 K = L^T is not upper triangular, '//label)
         b = transpose(b)
         call k%solve_lower(n, b)
         call check_below(failure, largest(b - identity(n)), 1.0e-13_wp, 'L^-1 K L^-T, '//label)
      end subroutine one

   end subroutine blocks_against_dense

   pure function upper(a) result(u)
      real(wp), intent(in) :: a(:, :)
      real(wp) :: u(size(a, 1), size(a, 2))
      integer :: j

      u(:, :) = 0.0_wp
      do j = 1, size(a, 2)
         u(:j, j) = a(:j, j)
      end do
   end function upper

   subroutine blocks_by_hand(failure)
      character(:), allocatable, intent(inout) :: failure
      type(block_diagonal_t) :: k
      real(wp) :: b(2, 1)
      integer :: info

      ! [4 2; 2 5] = L L^T with L = [2 0; 1 2].
      call k%init([2])
      call k%set_dense(reshape([4.0_wp, 2.0_wp, 2.0_wp, 5.0_wp], [2, 2]))
      call k%factorize(info)
      b(:, 1) = [2.0_wp, 5.0_wp]
      call k%solve_lower(1, b)
      call check_below(failure, maxval(abs(b(:, 1) - [1.0_wp, 2.0_wp])), 1.0e-15_wp, 'L^-1 b')
      b(:, 1) = [4.0_wp, 4.0_wp]
      call k%solve_lower_transposed(1, b)
      call check_below(failure, maxval(abs(b(:, 1) - [1.0_wp, 2.0_wp])), 1.0e-15_wp, 'L^-T b')
      b(:, 1) = [8.0_wp, 12.0_wp]
      call k%solve(1, b)
      call check_below(failure, maxval(abs(b(:, 1) - [1.0_wp, 2.0_wp])), 1.0e-15_wp, 'K^-1 b')
      call k%init([1, 1])
      call k%set_diagonal([4.0_wp, 25.0_wp])
      call k%factorize(info)
      b(:, 1) = [4.0_wp, 25.0_wp]
      call k%solve_lower(1, b)
      call check_below(failure, maxval(abs(b(:, 1) - [2.0_wp, 5.0_wp])), 1.0e-15_wp, 'the root of a diagonal matrix')
   end subroutine blocks_by_hand

   subroutine blocks_set(failure)
      character(:), allocatable, intent(inout) :: failure
      type(block_diagonal_t) :: k
      real(wp) :: expected(4, 4)

      call k%init([1, 3])
      call check_below(failure, largest(k%dense()), 0.0_wp, 'a new matrix is not zero')
      call k%set_block(2, reshape(spread(7.0_wp, 1, 9), [3, 3]))
      call k%set_identity()
      call check_below(failure, largest(k%dense() - identity(4)), 0.0_wp, 'the identity leaves old entries')
      call k%set_block(2, reshape(spread(7.0_wp, 1, 9), [3, 3]))
      call k%set_diagonal([1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp])
      expected(:, :) = 0.0_wp
      expected(1, 1) = 1.0_wp
      expected(2, 2) = 2.0_wp
      expected(3, 3) = 3.0_wp
      expected(4, 4) = 4.0_wp
      call check_below(failure, largest(k%dense() - expected), 0.0_wp, 'a diagonal among blocks')
      call k%init([1, 1, 1, 1])
      call k%set_diagonal([1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp])
      call check_below(failure, largest(k%dense() - expected), 0.0_wp, 'a diagonal matrix')
      call k%set_block(3, reshape([9.0_wp], [1, 1]))
      expected(3, 3) = 9.0_wp
      call check_below(failure, largest(k%dense() - expected), 0.0_wp, 'one entry of a diagonal matrix')
      call k%set_identity()
      call check_below(failure, largest(k%dense() - identity(4)), 0.0_wp, 'a diagonal identity')
   end subroutine blocks_set

   subroutine not_positive(failure)
      character(:), allocatable, intent(inout) :: failure
      type(block_diagonal_t) :: k
      integer :: info

      call k%init([1, 1, 1])
      call k%set_diagonal([1.0_wp, 0.0_wp, -1.0_wp])
      call k%factorize(info)
      call check(failure, info == 2, 'the zero of a diagonal matrix: row '//to_text(info))
      call k%init([1, 3])
      call k%set_diagonal([1.0_wp, 2.0_wp, -3.0_wp, 4.0_wp])
      call k%factorize(info)
      call check(failure, info == 3, 'a negative entry of the second block: row '//to_text(info))
      call k%init([2])
      call k%set_dense(reshape([1.0_wp, 2.0_wp, 2.0_wp, 3.0_wp], [2, 2]))
      call k%factorize(info)
      call check(failure, info == 2, 'an indefinite matrix with a positive diagonal: row '//to_text(info))
      call k%set_dense(reshape([1.0_wp, 2.0_wp, 2.0_wp, 5.0_wp], [2, 2]))
      call k%factorize(info)
      call check(failure, info == 0, 'a good matrix after a bad one')
   end subroutine not_positive

   !> A random A of given rank, with singular values between 1 and 3.
   function of_rank(c, n, rank) result(a)
      integer, intent(in) :: c, n, rank
      real(wp) :: a(c, n), left(c, c), right(n, n), d(rank)

      left(:, :) = orthogonal(c)
      right(:, :) = orthogonal(n)
      d(:) = 2.0_wp + random_vector(rank)
      a(:, :) = matmul(left(:, :rank)*spread(d, 1, c), transpose(right(:, :rank)))
   end function of_rank

   !> A matrix with all its entries.
   function rows_of(a) result(rows)
      real(wp), intent(in) :: a(:, :)
      type(csr_t) :: rows

      call rows%init(size(a, 1), size(a, 2))
      call rows%set_dense(a)
   end function rows_of

   !> Selects the rows of A and factorizes S with them.
   subroutine factorize(onto, a, k, identity, info)
      class(normal_solver_t), intent(inout) :: onto
      type(csr_t), intent(in) :: a
      type(block_diagonal_t), intent(in) :: k
      logical, intent(in) :: identity
      integer, intent(out) :: info
      type(rank_keeper_t) :: keeper

      call keeper%init(a, onto%c, [integer ::], 0.0_wp)
      call keeper%decide(a, 0.0_wp)
      call onto%keep(keeper%kept)
      call onto%factorize(a, k, identity, info)
   end subroutine factorize

   !> K^-1 A^T S^+ applied to the columns of r.
   subroutine apply(onto, a, r, x)
      class(normal_solver_t), intent(inout) :: onto
      real(wp), intent(in) :: a(:, :)
      real(wp), intent(in), contiguous :: r(:, :)
      real(wp), intent(out), contiguous :: x(:, :)
      real(wp) :: lambda(size(r, 1))
      integer :: j

      x(:, :) = 0.0_wp
      do j = 1, size(r, 2)
         call onto%multipliers(r(:, j), lambda)
         call onto%correction(rows_of(a), -lambda, x(:, j))
      end do
   end subroutine apply

   subroutine all_solvers(failure)
      character(:), allocatable, intent(inout) :: failure
      integer, parameter :: n = 6
      type(block_diagonal_t) :: k
      integer :: c, rank

      call restart_random()
      do c = 1, 9
         do rank = 0, min(c, n)
            call k%init([1, 1, 1, 1, 1, 1])
            call k%set_identity()
            call one('K = I')
            call k%set_diagonal(2.0_wp + random_vector(n))
            call one('K diagonal')
            call k%init([n])
            call k%set_dense(with_spectrum(2.0_wp + random_vector(n)))
            call one('K dense')
            call k%init([1, 3, 2])
            call k%set_diagonal(2.0_wp + random_vector(n))
            call k%set_block(2, with_spectrum([1.0_wp, 2.0_wp, 3.0_wp]))
            call one('K of blocks')
         end do
      end do

   contains

      subroutine one(metric)
         character(*), intent(in) :: metric
         class(normal_solver_t), allocatable :: onto
         real(wp) :: a(c, n), dense(n, n), p(n, n), x(n, c, size(solver_names)), lambda(c), first(c), allowed
         character(:), allocatable :: label
         integer :: i, info

         a(:, :) = of_rank(c, n, rank)
         dense(:, :) = k%dense()
         call k%factorize(info)
         first(:) = 0.0_wp
         do i = 1, size(solver_names)
            label = trim(solver_names(i))//', '//metric//', c = '//to_text(c)//', rank '//to_text(rank)
            call choose_solver(solver_names(i), rows_of(a), c, k%first(2:) - k%first(:size(k%first) - 1), 0.0_wp, onto)
            call factorize(onto, rows_of(a), k, metric == 'K = I', info)
            call check(failure, info == 0 .and. onto%rank == rank, 'rank, '//label)
            ! Rows in the given order, dependent ones among them, are no good basis: a few digits less.
            allowed = merge(1.0e-9_wp, 1.0e-12_wp, any(solver_names(i) == unpivoted))
            call apply(onto, a, a, p)
            call check_below(failure, largest(matmul(a, p) - a), allowed, 'A P - A, '//label)
            call check_below(failure, largest(matmul(p, p) - p), allowed, 'P P - P, '//label)
            call check_below(failure, largest(matmul(dense, p) - transpose(matmul(dense, p))), allowed, 'K P - P^T K, '//label)
            ! What the constraints cannot have, these do not distribute among redundant ones.
            if (.not. any(solver_names(i) == unpivoted)) then
               call apply(onto, a, identity(c), x(:, :, i))
               call check_below(failure, largest(x(:, :, i) - x(:, :, 1)), 1.0e-12_wp, 'not as with auto, '//label)
            end if
            ! The multipliers are of minimum norm with each solver, not only their reactions equal.
            call onto%multipliers(matmul(a, [(real(info, wp), info=1, n)]), lambda)
            call onto%minimum_norm(lambda)
            if (i == 1) first(:) = lambda
            call check_below(failure, maxval(abs(lambda - first)), 10*allowed, 'multipliers not as with auto, '//label)
         end do
      end subroutine one

   end subroutine all_solvers

   !> K^-1 a a^T/(a^T K^-1 a) in closed form.
   subroutine one_row(failure)
      character(:), allocatable, intent(inout) :: failure
      real(wp), parameter :: a(1, 2) = reshape([3.0_wp, 4.0_wp], [1, 2])
      class(normal_solver_t), allocatable :: onto
      type(block_diagonal_t) :: k
      real(wp) :: x(2, 1), lambda(1)
      integer :: i, info

      call k%init([1, 1])
      call k%set_diagonal([1.0_wp, 2.0_wp])
      call k%factorize(info)
      do i = 1, size(solver_names)
         call choose_solver(solver_names(i), rows_of(a), 1, [1, 1], 0.0_wp, onto)
         call factorize(onto, rows_of(a), k, .false., info)
         ! a^T K^-1 a = 9 + 8 = 17, K^-1 a = {3, 2}.
         call onto%multipliers([34.0_wp], lambda)
         call check_close(failure, lambda(1), 2.0_wp, 1.0e-14_wp, 'multiplier, '//trim(solver_names(i)))
         x(:, 1) = [10.0_wp, 10.0_wp]
         call onto%correction(rows_of(a), lambda, x(:, 1))
         call check_below(failure, maxval(abs(x(:, 1) - [4.0_wp, 6.0_wp])), 1.0e-13_wp, 'correction, '//trim(solver_names(i)))
         ! With K = I the matrix k is not to be looked at: a^T a = 25.
         call factorize(onto, rows_of(a), k, .true., info)
         call onto%multipliers([50.0_wp], lambda)
         call check_close(failure, lambda(1), 2.0_wp, 1.0e-14_wp, 'multiplier with K = I, '//trim(solver_names(i)))
      end do
   end subroutine one_row

   subroutine no_rows(failure)
      character(:), allocatable, intent(inout) :: failure
      class(normal_solver_t), allocatable :: onto
      type(block_diagonal_t) :: block, k
      real(wp) :: a(2, 3), empty(0, 3), lambda(2), none(0), x(3)
      integer :: i, info

      call k%init([1, 1, 1])
      call k%set_identity()
      call k%factorize(info)
      call block%init([3])
      call block%set_identity()
      call block%factorize(info)
      do i = 1, size(solver_names)
         call choose_solver(solver_names(i), rows_of(empty), 0, [1, 1, 1], 0.0_wp, onto)
         call factorize(onto, rows_of(empty), k, .true., info)
         call factorize(onto, rows_of(empty), block, .false., info)
         x(:) = 1.0_wp
         call onto%multipliers([real(wp) ::], none)
         call onto%correction(rows_of(empty), none, x)
         call check(failure, info == 0 .and. onto%rank == 0, 'no rows, '//trim(solver_names(i)))
         call check_below(failure, maxval(abs(x - 1.0_wp)), 0.0_wp, 'no rows correct something, '//trim(solver_names(i)))
         a(:, :) = 0.0_wp
         call choose_solver(solver_names(i), rows_of(a), 2, [1, 1, 1], 0.0_wp, onto)
         a(1, :) = [0.0_wp, 2.0_wp, 0.0_wp]
         a(2, :) = 0.0_wp
         call factorize(onto, rows_of(a), k, .false., info)
         call onto%multipliers([4.0_wp, 5.0_wp], lambda)
         call check(failure, info == 0 .and. onto%rank == 1, 'a row of zeros, '//trim(solver_names(i)))
         call check_below(failure, maxval(abs(lambda - [1.0_wp, 0.0_wp])), 1.0e-14_wp, &
                          'multiplier of zeros, '//trim(solver_names(i)))
      end do
   end subroutine no_rows

   subroutine bad_row(failure)
      use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
      character(:), allocatable, intent(inout) :: failure
      class(normal_solver_t), allocatable :: onto
      type(block_diagonal_t) :: k
      real(wp) :: a(2, 3)
      integer :: i, info

      call k%init([3])
      call k%set_identity()
      call k%factorize(info)
      do i = 1, size(solver_names)
         a(:, :) = 0.0_wp
         call choose_solver(solver_names(i), rows_of(a), 2, [3], 0.0_wp, onto)
         a(:, :) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp], [2, 3])
         a(2, 3) = ieee_value(a(2, 3), ieee_quiet_nan)
         call factorize(onto, rows_of(a), k, .false., info)
         call check(failure, info /= 0, 'an entry that is not finite is not reported, '//trim(solver_names(i)))
         call factorize(onto, rows_of(a), k, .true., info)
         call check(failure, info /= 0, 'nor with K = I, '//trim(solver_names(i)))
      end do
   end subroutine bad_row

   !> One constraint stated twice, and another one in a unit that makes it as small as you like: both are met exactly.
   subroutine different_units(failure)
      character(:), allocatable, intent(inout) :: failure
      class(normal_solver_t), allocatable :: onto
      type(block_diagonal_t) :: none
      real(wp) :: a(3, 2), d(2), lambda(3), u
      integer :: info, j, k

      do k = 1, 2
         do j = 0, 12
            u = 10.0_wp**(-j)
            a = reshape([1.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, u], [3, 2])
            call choose_solver(solver_names(k), rows_of(a), 3, [1, 1], 0.0_wp, onto)
            call factorize(onto, rows_of(a), none, .true., info)
            call check(failure, info == 0 .and. onto%rank == 2, 'rank at 1e-'//to_text(j))
            d = [3.0_wp, 5.0_wp]
            call onto%multipliers(matmul(a, d), lambda)
            call onto%correction(rows_of(a), lambda, d)
            call check_below(failure, maxval(abs(d)), 1.0e-9_wp, 'what is left at 1e-'//to_text(j))
         end do
      end do
   end subroutine different_units

end module test_normal_solver
