!> Tests of the pseudo-inverses and of the decision on their rank.
module test_linalg
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan, ieee_positive_inf
   use testing, only: check, check_below, check_close, new_test, test_t
   use taut_kinds, only: wp
   use taut_error, only: to_text
   use taut_linalg_pseudo_inverse, only: by_either, by_singular_values, path_cholesky, path_name, path_none, path_pivots, &
                                         path_singular_values, pseudo_inverse_t, singular_value_inverse_t
   use taut_linalg_rank, only: effective_rank
   implicit none (type, external)
   private
   public :: collect_linalg, orthogonal, random_vector, restart_random, with_spectrum, identity, largest

   !> With pivots, and without.
   integer, parameter :: ways(0:1) = [by_either, by_singular_values]

contains

   !> All tests of this module.
   function collect_linalg() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [ &
              new_test('Moore-Penrose identities of every size and rank', moore_penrose), &
              new_test('Moore-Penrose identities with rows three times', repeated_rows), &
              new_test('Cholesky and singular values agree', both_paths), &
              new_test('rank, condition and path are reported', reported), &
              new_test('rcond decides with every path', rcond_option), &
              new_test('the rank does not depend on units', units), &
              new_test('gaps of a spectrum', gaps), &
              new_test('a long chain is kept whole', long_chain), &
              new_test('a row that is redundant but for noise', noisy_redundancy), &
              new_test('entries that are not finite', not_finite), &
              new_test('the workspace serves many matrices', reuse), &
              new_test('pseudo-inverse of wide and tall matrices', wide_and_tall)]
   end function collect_linalg

   !> Makes the random numbers of a test the same in every run.
   subroutine restart_random()
      integer :: n
      integer, allocatable :: seed(:)

      call random_seed(size=n)
      allocate (seed(n), source=20110519)
      call random_seed(put=seed)
   end subroutine restart_random

   !> Random numbers between -1 and 1.
   function random_vector(n) result(x)
      integer, intent(in) :: n
      real(wp) :: x(n)

      call random_number(x)
      x(:) = 2.0_wp*x - 1.0_wp
   end function random_vector

   !> A random orthogonal matrix: a product of reflections.
   function orthogonal(n) result(q)
      integer, intent(in) :: n
      real(wp) :: q(n, n), u(n)
      integer :: i

      q(:, :) = identity(n)
      do i = 1, n
         u(:) = random_vector(n)
         u(:) = u/norm2(u)
         q(:, :) = q - 2.0_wp*outer(matmul(q, u), u)
      end do
   end function orthogonal

   pure function outer(a, b) result(c)
      real(wp), intent(in) :: a(:), b(:)
      real(wp) :: c(size(a), size(b))

      c(:, :) = spread(a, 2, size(b))*spread(b, 1, size(a))
   end function outer

   pure function identity(n) result(e)
      integer, intent(in) :: n
      real(wp) :: e(n, n)
      integer :: i

      e(:, :) = 0.0_wp
      do i = 1, n
         e(i, i) = 1.0_wp
      end do
   end function identity

   !> A random symmetric matrix with given eigenvalues.
   function with_spectrum(d) result(s)
      real(wp), intent(in) :: d(:)
      real(wp) :: s(size(d), size(d)), q(size(d), size(d))

      q(:, :) = orthogonal(size(d))
      s(:, :) = matmul(q, spread(d, 2, size(d))*transpose(q))
      s(:, :) = 0.5_wp*(s + transpose(s))
   end function with_spectrum

   !> S^+ column by column.
   function inverse_of(solver, n) result(x)
      type(pseudo_inverse_t), intent(inout) :: solver
      integer, intent(in) :: n
      real(wp) :: x(n, n), e(n, n)
      integer :: j

      e(:, :) = identity(n)
      do j = 1, n
         call solver%solve(e(:, j), x(:, j))
      end do
   end function inverse_of

   !> The four identities, each relative to its own size.
   subroutine check_identities(failure, a, x, tolerance, message)
      character(:), allocatable, intent(inout) :: failure
      real(wp), intent(in) :: a(:, :), x(:, :), tolerance
      character(*), intent(in) :: message
      real(wp) :: ax(size(a, 1), size(a, 1)), xa(size(a, 2), size(a, 2))

      ax(:, :) = matmul(a, x)
      xa(:, :) = matmul(x, a)
      call check_below(failure, largest(matmul(ax, a) - a), tolerance*largest(a), 'A X A - A, '//message)
      call check_below(failure, largest(matmul(xa, x) - x), tolerance*largest(x), 'X A X - X, '//message)
      call check_below(failure, largest(ax - transpose(ax)), tolerance, 'A X is not symmetric, '//message)
      call check_below(failure, largest(xa - transpose(xa)), tolerance, 'X A is not symmetric, '//message)
   end subroutine check_identities

   pure function largest(a) result(value)
      real(wp), intent(in) :: a(:, :)
      real(wp) :: value

      value = 0.0_wp
      if (size(a) > 0) value = maxval(abs(a))
   end function largest

   subroutine moore_penrose(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pseudo_inverse_t) :: solver
      real(wp), allocatable :: s(:, :), d(:)
      integer :: always, info, n, rank
      character(:), allocatable :: label

      call restart_random()
      do always = 0, 1
         do n = 1, 12
            call solver%init(n, ways(always))
            do rank = 0, n
               d = 2.0_wp + random_vector(n)
               d(rank + 1:) = 0.0_wp
               s = with_spectrum(d)
               label = 'order '//to_text(n)//', rank '//to_text(rank)//', '//path_name(solver%path)
               call solver%compute(s, info)
               call check(failure, info == 0, 'failed: '//label)
               call check(failure, solver%rank == rank, 'rank '//to_text(solver%rank)//' found: '//label)
               call check_identities(failure, s, inverse_of(solver, n), 1.0e-12_wp, label)
            end do
         end do
      end do
   end subroutine moore_penrose

   subroutine repeated_rows(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pseudo_inverse_t) :: solver
      real(wp), allocatable :: s(:, :), x(:, :), plus(:, :)
      integer :: info, n

      call restart_random()
      do n = 1, 4
         s = with_spectrum(2.0_wp + random_vector(n))
         call solver%init(n)
         call solver%compute(s, info)
         plus = inverse_of(solver, n)
         s = repeated(s)
         call solver%init(3*n)
         call solver%compute(s, info)
         x = inverse_of(solver, 3*n)
         call check(failure, info == 0 .and. solver%rank == n, 'rank of repeated rows')
         call check(failure, solver%path == path_pivots, 'a singular matrix was not settled by its pivots')
         call check_identities(failure, s, x, 1.0e-12_wp, 'order '//to_text(n)//' three times')
         ! The minimum norm shares each multiplier equally between the copies: S^+ is repeated too, at a ninth.
         call check_below(failure, largest(x - repeated(plus)/9.0_wp), 1.0e-12_wp*largest(plus), 'copies do not share equally')
      end do
   end subroutine repeated_rows

   !> Every row and column three times.
   pure function repeated(s) result(t)
      real(wp), intent(in) :: s(:, :)
      real(wp) :: t(3*size(s, 1), 3*size(s, 1))
      integer :: i, j, n

      n = size(s, 1)
      do j = 0, 2
         do i = 0, 2
            t(i*n + 1:(i + 1)*n, j*n + 1:(j + 1)*n) = s
         end do
      end do
   end function repeated

   subroutine both_paths(failure)
      character(:), allocatable, intent(inout) :: failure
      integer, parameter :: n = 8
      type(pseudo_inverse_t) :: auto, singular
      real(wp) :: s(n, n), x0(n), x(n), y(n), bound
      integer :: i, info, k

      call restart_random()
      call auto%init(n)
      call singular%init(n, by_singular_values)
      do k = 0, 6
         s(:, :) = with_spectrum([(10.0_wp**(-real(k*(i - 1), wp)/(n - 1)), i=1, n)])
         x0(:) = random_vector(n)
         call auto%compute(s, info)
         call auto%solve(matmul(s, x0), x)
         call singular%compute(s, info)
         call singular%solve(matmul(s, x0), y)
         bound = 100.0_wp*epsilon(1.0_wp)*10.0_wp**k*norm2(x0)
         call check(failure, auto%path == path_cholesky .and. singular%path == path_singular_values, 'paths')
         call check(failure, auto%rank == n .and. singular%rank == n, 'full rank at condition 1e'//to_text(k))
         call check_below(failure, norm2(x - x0), bound, 'Cholesky at condition 1e'//to_text(k))
         call check_below(failure, norm2(y - x0), bound, 'singular values at condition 1e'//to_text(k))
      end do
   end subroutine both_paths

   subroutine reported(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pseudo_inverse_t) :: solver
      real(wp), parameter :: c = 0.9_wp
      integer :: info

      call check(failure, solver%path == path_none, 'a path before the first matrix')
      call check(failure, path_name(path_none) == 'none' .and. path_name(path_cholesky) == 'cholesky' .and. &
                 path_name(path_singular_values) == 'singular values', 'names of the paths')
      call solver%init(2)
      ! [1 c; c 1] has the eigenvalues 1 + c and 1 - c; here its rows have other units.
      call solver%compute(reshape([1.0_wp, 100.0_wp*c, 100.0_wp*c, 1.0e4_wp], [2, 2]), info)
      call check(failure, info == 0 .and. solver%path == path_cholesky .and. solver%rank == 2, 'regular matrix')
      call check_close(failure, solver%condition, 1.0_wp/(1.0_wp - c**2), 1.0e-9_wp, 'ratio of pivots')
      call solver%init(2, by_singular_values)
      call solver%compute(reshape([1.0_wp, 100.0_wp*c, 100.0_wp*c, 1.0e4_wp], [2, 2]), info)
      call check(failure, info == 0 .and. solver%path == path_singular_values .and. solver%rank == 2, 'by singular values')
      call check_close(failure, solver%condition, (1.0_wp + c)/(1.0_wp - c), 1.0e-9_wp, 'condition by singular values')
      call solver%init(2, by_either)
      call solver%compute(reshape([4.0_wp, 4.0_wp, 4.0_wp, 4.0_wp], [2, 2]), info)
      call check(failure, solver%path == path_pivots .and. solver%rank == 1, 'singular matrix')
      call check_close(failure, solver%condition, 1.0_wp, 1.0e-12_wp, 'condition with the zeros left out')
      call solver%compute(reshape([0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [2, 2]), info)
      call check(failure, info == 0 .and. solver%rank == 0, 'zero matrix')
      call solver%init(0)
      call solver%compute(reshape([real(wp) ::], [0, 0]), info)
      call check(failure, info == 0 .and. solver%rank == 0, 'no constraints')
   end subroutine reported

   subroutine rcond_option(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pseudo_inverse_t) :: solver
      real(wp), parameter :: c = 1.0_wp - 1.0e-5_wp
      real(wp), parameter :: s(2, 2) = reshape([1.0_wp, c, c, 1.0_wp], [2, 2])
      real(wp) :: x(2)
      integer :: always, info

      do always = 0, 1
         call solver%init(2, ways(always))
         solver%rcond = 1.0e-12_wp
         call solver%compute(s, info)
         call check(failure, solver%rank == 2, 'small singular value dropped, '//path_name(solver%path))
         ! The smaller singular value is 5e-6 of the larger.
         solver%rcond = 1.0e-3_wp
         call solver%compute(s, info)
         call check(failure, solver%rank == 1, 'rcond without effect, '//path_name(solver%path))
         call solver%solve([1.0_wp, -1.0_wp], x)
         call check_below(failure, maxval(abs(x)), 1.0e-9_wp, 'a dropped direction has a solution')
         call solver%solve([1.0_wp, 1.0_wp], x)
         call check_below(failure, maxval(abs(x - 1.0_wp/(1.0_wp + c))), 1.0e-9_wp, 'the direction that is kept')
      end do
   end subroutine rcond_option

   subroutine units(failure)
      character(:), allocatable, intent(inout) :: failure
      integer, parameter :: n = 6
      type(pseudo_inverse_t) :: solver
      real(wp) :: a(n, 9), q(9, 9), mix(n, n), s(n, n), p(9, 9), d(n), x(n)
      integer :: decades, i, info, j, rank

      call restart_random()
      call solver%init(n)
      do rank = 1, n
         do decades = 0, 5
            q(:, :) = orthogonal(9)
            mix(:, :) = orthogonal(n)
            d(:) = [(10.0_wp**(decades*(i - 0.5_wp*(n + 1))/(n - 1)), i=1, n)]
            a(:, :) = spread(d, 2, 9)*matmul(mix(:, :rank), transpose(q(:, :rank)))
            s(:, :) = matmul(a, transpose(a))
            call solver%compute(s, info)
            call check(failure, info == 0 .and. solver%rank == rank, 'rank '//to_text(rank)//' became '// &
                       to_text(solver%rank)//' with units over '//to_text(decades)//' decades')
            do j = 1, 9
               call solver%solve(a(:, j), x)
               p(:, j) = matmul(x, a)
            end do
            ! A^T S^+ A is the projector on the rows, whatever their units; S squares the range of these.
            call check_below(failure, largest(p - matmul(q(:, :rank), transpose(q(:, :rank)))), &
                             1.0e-12_wp*100.0_wp**decades, 'projector with units over '//to_text(decades)//' decades')
         end do
      end do
   end subroutine units

   subroutine gaps(failure)
      character(:), allocatable, intent(inout) :: failure
      integer :: i

      associate (smooth => [(10.0_wp**(-i), i=0, 11)])
         call check(failure, effective_rank(smooth, 1.0e-12_wp, 1.0e-8_wp) == 12, 'a smooth spectrum was cut')
         call check(failure, effective_rank(smooth, 1.0e-12_wp, 1.0_wp) == 12, 'a smooth spectrum was cut for noise')
         call check(failure, effective_rank(smooth, 3.0e-6_wp, 1.0_wp) == 6, 'rcond has no effect on a smooth spectrum')
      end associate
      call check(failure, effective_rank([2.0_wp, 1.0_wp, 1.0e-9_wp], 1.0e-12_wp, 1.0e-8_wp) == 2, 'a gap in the doubtful zone')
      call check(failure, effective_rank([2.0_wp, 1.0_wp, 1.0e-7_wp], 1.0e-12_wp, 1.0e-8_wp) == 3, 'a gap above that zone')
      call check(failure, effective_rank([2.0_wp, 1.0_wp, 1.0e-7_wp], 1.0e-12_wp, 1.0e-6_wp) == 2, 'noise widens that zone')
      call check(failure, effective_rank([1.0_wp, 1.0e-6_wp, 2.0e-9_wp], 1.0e-12_wp, 1.0e-8_wp) == 3, 'less than three decades')
      call check(failure, effective_rank([1.0_wp, 1.0e-6_wp, 0.9e-9_wp, 1.0e-11_wp], 1.0e-12_wp, 1.0e-8_wp) == 2, &
                 'more than three decades')
      call check(failure, effective_rank([1.0_wp, 1.0e-13_wp], 1.0e-12_wp, 1.0e-8_wp) == 1, 'below rcond')
      call check(failure, effective_rank([0.0_wp, 0.0_wp], 1.0e-12_wp, 1.0e-8_wp) == 0, 'zeros')
      call check(failure, effective_rank([real(wp) ::], 1.0e-12_wp, 1.0e-8_wp) == 0, 'no singular values')
      call check(failure, effective_rank([1.0e-200_wp, 1.0e-201_wp], 1.0e-12_wp, 1.0e-8_wp) == 2, 'small as a whole')
   end subroutine gaps

   !> A straight chain of unit rods and masses: S is tridiagonal, S^-1 in closed form min(i,j) (n + 1 - max(i,j))/(n + 1).
   subroutine long_chain(failure)
      character(:), allocatable, intent(inout) :: failure
      integer, parameter :: n = 50
      type(pseudo_inverse_t) :: solver
      real(wp) :: s(n, n), exact(n, n)
      integer :: always, i, info, j

      s(:, :) = 2.0_wp*identity(n)
      do i = 1, n - 1
         s(i, i + 1) = -1.0_wp
         s(i + 1, i) = -1.0_wp
      end do
      do j = 1, n
         exact(:, j) = [(min(i, j)*real(n + 1 - max(i, j), wp)/(n + 1), i=1, n)]
      end do
      do always = 0, 1
         call solver%init(n, ways(always))
         ! A noise that puts the whole spectrum in doubt: only gaps may cut.
         call solver%compute(s, info, noise=merge(0.1_wp, 0.0_wp, always == 1))
         call check(failure, info == 0 .and. solver%rank == n, 'rank '//to_text(solver%rank)//' of a chain of 50')
         call check_below(failure, largest(inverse_of(solver, n) - exact), 1.0e-11_wp, 'inverse of the chain')
      end do
      ! Its smallest and largest eigenvalues are 2 -+ 2 cos(pi/(n + 1)).
      call check_close(failure, solver%condition, 1.0_wp/tan(0.5_wp*acos(-1.0_wp)/(n + 1))**2, 1.0e-8_wp, 'condition of the chain')
   end subroutine long_chain

   !> A third row that is the sum of two others on the manifold, and leaves them by delta beside it.
   subroutine noisy_redundancy(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pseudo_inverse_t) :: solver
      real(wp) :: a(3, 3), x(3), delta
      integer :: info

      call solver%init(3)
      delta = 1.0e-3_wp
      call set()
      call solver%compute(matmul(a, transpose(a)), info)
      call check(failure, solver%rank == 3, 'a row of its own was taken for noise')
      call solver%compute(matmul(a, transpose(a)), info, noise=delta)
      call check(failure, solver%rank == 2, 'a violation of that size was taken for a row of its own')
      delta = 1.0e-5_wp
      call set()
      call solver%compute(matmul(a, transpose(a)), info)
      call check(failure, solver%rank == 2, 'rank '//to_text(solver%rank)//' with a gap in the doubtful zone')
      ! The exact multipliers of the redundant system; inverting the noise would give 1e10.
      call solver%solve([1.0_wp, 1.0_wp, 2.0_wp], x)
      call check_below(failure, maxval(abs(x - [1.0_wp, 1.0_wp, 2.0_wp]/3.0_wp)), 1.0e-8_wp, 'multipliers')
      call solver%solve([1.0_wp, 1.0_wp, 2.0_wp + delta], x)
      call check_below(failure, maxval(abs(x - [1.0_wp, 1.0_wp, 2.0_wp]/3.0_wp)), delta, 'multipliers with noise')

   contains

      subroutine set()
         a(:, :) = 0.0_wp
         a(1, 1) = 1.0_wp
         a(2, 2) = 1.0_wp
         a(3, :) = [1.0_wp, 1.0_wp, delta]
      end subroutine set

   end subroutine noisy_redundancy

   subroutine not_finite(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pseudo_inverse_t) :: solver
      real(wp) :: bad, s(3, 3)
      integer :: always, i, info, j, kind

      do always = 0, 1
         do kind = 1, 2
            bad = merge(ieee_value(bad, ieee_quiet_nan), ieee_value(bad, ieee_positive_inf), kind == 1)
            call solver%init(1, ways(always))
            call solver%compute(reshape([bad], [1, 1]), info)
            call check(failure, info == 1, 'one entry that is not finite')
            call solver%init(3, ways(always))
            do j = 1, 3
               do i = j, 3
                  s(:, :) = 2.0_wp*identity(3)
                  s(i, j) = bad
                  s(j, i) = bad
                  call solver%compute(s, info)
                  call check(failure, info == 1, 'an entry that is not finite at '//to_text(i)//', '//to_text(j))
               end do
            end do
            if (always == 1) then
               s(:, :) = 2.0_wp*identity(3)
               s(1, 3) = bad
               call solver%compute(s, info)
               call check(failure, info == 1, 'an entry above the diagonal that is not finite')
            end if
            s(:, :) = 2.0_wp*identity(3)
            call solver%compute(s, info)
            call check(failure, info == 0 .and. solver%rank == 3, 'a good matrix after a bad one')
         end do
      end do
   end subroutine not_finite

   !> The answer depends on the matrix alone, not on those before it, and no array changes its size.
   subroutine reuse(failure)
      character(:), allocatable, intent(inout) :: failure
      integer, parameter :: n = 5
      type(pseudo_inverse_t) :: solver
      type(singular_value_inverse_t) :: general
      real(wp) :: d(n), s(n, n, 0:n), first(n, n, 0:n), wide(3, n), ones(n)
      integer :: info, k, round

      call restart_random()
      ones(:) = 1.0_wp
      call solver%init(n)
      call general%init(3, n)
      do k = 0, n
         d(:) = 2.0_wp + random_vector(n)
         d(k + 1:) = 0.0_wp
         s(:, :, k) = with_spectrum(d)
         call solver%compute(s(:, :, k), info)
         first(:, :, k) = inverse_of(solver, n)
      end do
      do round = 1, 20
         k = mod(7*round, n + 1)
         call solver%compute(s(:, :, k), info)
         call check(failure, solver%rank == k, 'rank after other matrices')
         call check(failure, all(abs(inverse_of(solver, n) - first(:, :, k)) <= 0.0_wp), 'the answer depends on earlier matrices')
         wide(:, :) = s(1:3, :, k)
         call general%compute(wide, ones, ones, 1.0e-12_wp, 1.0e-8_wp, info)
         call check(failure, general%rank == min(3, k), 'rank of a wide matrix after others')
         call check(failure, all(shape(general%inverse) == [n, 3]), 'a workspace changed its size')
      end do
   end subroutine reuse

   subroutine wide_and_tall(failure)
      character(:), allocatable, intent(inout) :: failure
      type(singular_value_inverse_t) :: general
      real(wp), allocatable :: a(:, :), d(:), left(:, :), ones(:), right(:, :)
      integer :: info, m, n, rank
      character(:), allocatable :: label

      call restart_random()
      allocate (ones(7), source=1.0_wp)
      do m = 1, 7
         do n = 1, 7
            call general%init(m, n)
            do rank = 0, min(m, n)
               d = [3.0_wp, 2.0_wp + 0.5_wp*random_vector(min(m, n)), 1.0_wp]
               left = orthogonal(m)
               right = orthogonal(n)
               if (rank > 0) d(rank) = merge(3.0_wp, 1.0_wp, rank == 1)
               a = matmul(left(:, :rank)*spread(d(:rank), 1, m), transpose(right(:, :rank)))
               label = to_text(m)//' x '//to_text(n)//', rank '//to_text(rank)
               call general%compute(a, ones(:m), ones(:n), 1.0e-12_wp, 1.0e-8_wp, info)
               call check(failure, info == 0 .and. general%rank == rank, 'rank '//to_text(general%rank)//' found: '//label)
               call check_identities(failure, a, general%inverse, 1.0e-12_wp, label)
               if (rank > 0) call check_close(failure, general%condition, 3.0_wp/d(rank), 1.0e-12_wp, 'condition, '//label)
            end do
         end do
      end do
      call general%init(0, 3)
      call general%compute(reshape([real(wp) ::], [0, 3]), ones(:0), ones(:3), 1.0e-12_wp, 1.0e-8_wp, info)
      call check(failure, info == 0 .and. general%rank == 0, 'a matrix without rows')
   end subroutine wide_and_tall

end module test_linalg
