!> Tests of sparse factors: as bands and by UMFPACK, where the machine has it.
module test_lu
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use taut, only: wp
   use taut_error, only: to_text
   use taut_linalg_lu, only: lu_not_finite, lu_t, lu_too_large
   use taut_linalg_lu_banded, only: banded_lu_t
   use taut_linalg_lu_choose, only: choose_lu
   use taut_linalg_lu_umfpack, only: umfpack_lu_t
   use taut_linalg_umfpack, only: umfpack_files
   use testing, only: check, check_below, new_test, test_t
   implicit none (type, external)
   private
   public :: collect_lu

   character(len=8), parameter :: no_library(1) = ['none.so ']

contains

   !> All tests of this module.
   function collect_lu() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('bands solve a saddle-point problem', bands_solve), &
               new_test('UMFPACK gives what bands give', umfpack_as_bands), &
               new_test('a singular matrix is named by its column', singular), &
               new_test('without UMFPACK there are bands, and a refusal where they are too wide', without_library), &
               new_test('a copy of factors is its own', copied), &
               new_test('a copy of a copy that comes back has its own factors', copied_back)]
   end function collect_lu

   !> The pattern of a square net of m x m points, each with its neighbors, and of constraints that tie each second point of the
   !! first row to its right neighbor; entries of the diagonal are named twice.
   subroutine net(m, n, row, column)
      integer, intent(in) :: m
      integer, intent(out) :: n
      integer, allocatable, intent(out) :: row(:), column(:)
      integer :: c, i, j

      allocate (row(0), column(0))
      n = m*m
      do j = 1, m
         do i = 1, m
            call enter(at(i, j), at(i, j))
            call enter(at(i, j), at(i, j))
            if (i < m) call both(at(i, j), at(i + 1, j))
            if (j < m) call both(at(i, j), at(i, j + 1))
         end do
      end do
      do c = 1, m/2
         n = n + 1
         call enter(n, n)
         call both(n, at(2*c - 1, 1))
         call both(n, at(2*c, 1))
      end do

   contains

      pure integer function at(i, j)
         integer, intent(in) :: i, j

         at = (j - 1)*m + i
      end function at

      subroutine enter(i, j)
         integer, intent(in) :: i, j

         row = [row, i]
         column = [column, j]
      end subroutine enter

      subroutine both(i, j)
         integer, intent(in) :: i, j

         call enter(i, j)
         call enter(j, i)
      end subroutine both

   end subroutine net

   !> All are neighbors of the first: whatever the order, the band is wide.
   subroutine star(n, row, column)
      integer, intent(in) :: n
      integer, allocatable, intent(out) :: row(:), column(:)
      integer :: i

      row = [(i, i=1, n), (1, i=2, n), (i, i=2, n)]
      column = [(i, i=1, n), (i, i=2, n), (1, i=2, n)]
   end subroutine star

   !> Values for the net, of no symmetry, with zeros on the diagonal of the constraints.
   function values_of(m, row, column) result(values)
      integer, intent(in) :: m, row(:), column(:)
      real(wp) :: values(size(row))
      integer :: k

      do k = 1, size(row)
         values(k) = -1.0_wp + 0.3_wp*sin(real(k, wp))
         if (row(k) == column(k)) values(k) = merge(3.0_wp, 0.0_wp, row(k) <= m*m)
      end do
   end function values_of

   !> A x - b, of a real part and an imaginary one.
   function left(row, column, values, x, b) result(r)
      integer, intent(in) :: row(:), column(:)
      complex(wp), intent(in) :: values(:), x(:), b(:)
      complex(wp) :: r(size(b))
      integer :: k

      r = -b
      do k = 1, size(row)
         r(row(k)) = r(row(k)) + values(k)*x(column(k))
      end do
   end function left

   !> Solves with a real and with a complex matrix: the solutions, and the largest residual.
   subroutine solve_both(lu, m, real_x, complex_x, residual, failure)
      class(lu_t), intent(inout) :: lu
      integer, intent(in) :: m
      real(wp), intent(out) :: real_x(:), residual
      complex(wp), intent(out) :: complex_x(:)
      character(:), allocatable, intent(inout) :: failure
      real(wp), allocatable :: a(:)
      complex(wp), allocatable :: b(:), z(:)
      integer :: info, k

      a = values_of(m, lu%row, lu%column)
      z = cmplx(a, 0.5_wp*cos(a)*abs(a), wp)
      b = [(cmplx(cos(real(k, wp)), sin(2.0_wp*k), wp), k=1, lu%n)]
      call lu%factorize(a, info)
      call check(failure, info == 0, 'the real matrix is regular')
      call lu%factorize(z, info)
      call check(failure, info == 0, 'the complex matrix is regular')
      if (allocated(failure)) return
      real_x(:) = real(b, wp)
      complex_x(:) = b
      call lu%solve(real_x)
      call lu%solve(complex_x)
      residual = max(maxval(abs(left(lu%row, lu%column, cmplx(a, 0.0_wp, wp), cmplx(real_x, 0.0_wp, wp), &
                                     cmplx(real(b), 0.0_wp, wp)))), maxval(abs(left(lu%row, lu%column, z, complex_x, b))))
   end subroutine solve_both

   subroutine bands_solve(failure)
      character(:), allocatable, intent(inout) :: failure
      integer, parameter :: m = 6
      type(banded_lu_t) :: lu
      real(wp), allocatable :: x(:)
      complex(wp), allocatable :: z(:)
      integer, allocatable :: row(:), column(:)
      integer :: n
      real(wp) :: residual

      call net(m, n, row, column)
      call lu%init(n, row, column)
      allocate (x(n), z(n))
      call solve_both(lu, m, x, z, residual, failure)
      call check_below(failure, residual, 1.0e-12_wp, 'what is left')
      call check(failure, lu%width <= 2*m, 'the band is as wide as the net')
   end subroutine bands_solve

   !> UMFPACK laid out for the net, if the machine has it.
   subroutine try_umfpack(m, lu, found)
      integer, intent(in) :: m
      type(umfpack_lu_t), intent(inout) :: lu
      logical, intent(out) :: found
      integer, allocatable :: row(:), column(:)
      integer :: n

      call lu%library%find(umfpack_files, found)
      if (.not. found) return
      call net(m, n, row, column)
      call lu%init(n, row, column)
   end subroutine try_umfpack

   subroutine umfpack_as_bands(failure)
      character(:), allocatable, intent(inout) :: failure
      integer, parameter :: m = 30
      type(umfpack_lu_t) :: lu
      type(banded_lu_t) :: bands
      class(lu_t), allocatable :: chosen
      real(wp), allocatable :: x(:, :)
      complex(wp), allocatable :: z(:, :)
      integer, allocatable :: row(:), column(:)
      logical :: found
      real(wp) :: residual
      integer :: i

      call try_umfpack(m, lu, found)
      if (.not. found) return
      call bands%init(lu%n, lu%row, lu%column)
      allocate (x(lu%n, 2), z(lu%n, 2))
      call solve_both(bands, m, x(:, 1), z(:, 1), residual, failure)
      ! Twice: factors replace those before.
      do i = 1, 2
         call solve_both(lu, m, x(:, 2), z(:, 2), residual, failure)
         call check_below(failure, residual, 1.0e-12_wp, 'what is left')
         call check_below(failure, maxval(abs(x(:, 2) - x(:, 1))), 1.0e-11_wp*maxval(abs(x)), 'the real solution')
         call check_below(failure, maxval(abs(z(:, 2) - z(:, 1))), 1.0e-11_wp*maxval(abs(z)), 'the complex solution')
      end do
      call check(failure, lu%numbers() < bands%numbers(), 'its factors are smaller')
      call choose_lu(lu%n, lu%row, lu%column, chosen)
      call check(failure, is_band(chosen), 'a narrow band is a band')
      call star(1000, row, column)
      call choose_lu(1000, row, column, chosen)
      call check(failure, .not. is_band(chosen), 'a wide one is none')

   contains

      logical function is_band(any_lu)
         class(lu_t), intent(in) :: any_lu

         select type (any_lu)
         type is (banded_lu_t)
            is_band = .true.
         class default
            is_band = .false.
         end select
      end function is_band

   end subroutine umfpack_as_bands

   subroutine singular(failure)
      character(:), allocatable, intent(inout) :: failure
      integer, parameter :: m = 8, gone = 13
      type(umfpack_lu_t) :: lu
      type(banded_lu_t) :: bands
      integer, allocatable :: row(:), column(:)
      logical :: found
      integer :: n

      call net(m, n, row, column)
      call bands%init(n, row, column)
      call look(bands)
      call try_umfpack(m, lu, found)
      if (found) call look(lu)

   contains

      subroutine look(any_lu)
         class(lu_t), intent(inout) :: any_lu
         real(wp), allocatable :: a(:)
         integer :: info

         a = values_of(m, row, column)
         where (row == gone .or. column == gone) a = 0.0_wp
         call any_lu%factorize(a, info)
         call check(failure, info == gone, 'a real matrix is singular at '//to_text(info))
         call any_lu%factorize(cmplx(a, 2.0_wp*a, wp), info)
         call check(failure, info == gone, 'a complex matrix is singular at '//to_text(info))
         a(5) = ieee_value(a(5), ieee_quiet_nan)
         call any_lu%factorize(a, info)
         call check(failure, info == lu_not_finite, 'not a number')
      end subroutine look

   end subroutine singular

   subroutine without_library(failure)
      character(:), allocatable, intent(inout) :: failure
      class(lu_t), allocatable :: lu
      integer, parameter :: m = 60, many = 40000
      integer, allocatable :: row(:), column(:)
      integer :: info, n

      call net(m, n, row, column)
      call choose_lu(n, row, column, lu, no_library)
      select type (lu)
      type is (banded_lu_t)
         call lu%factorize(values_of(m, row, column), info)
         call check(failure, info == 0, 'bands serve')
      class default
         call check(failure, .false., 'bands alone are left')
      end select
      call star(many, row, column)
      call choose_lu(many, row, column, lu, no_library)
      call lu%factorize(real(row, wp), info)
      call check(failure, info == lu_too_large, 'a band too wide is refused')
      call lu%factorize(cmplx(row, column, wp), info)
      call check(failure, info == lu_too_large, 'a complex one too')
   end subroutine without_library

   subroutine copied(failure)
      character(:), allocatable, intent(inout) :: failure
      integer, parameter :: m = 10
      type(umfpack_lu_t), allocatable :: lu, copy
      real(wp), allocatable :: x(:)
      complex(wp), allocatable :: z(:)
      real(wp) :: residual
      logical :: found

      allocate (lu)
      call try_umfpack(m, lu, found)
      if (.not. found) return
      allocate (x(lu%n), z(lu%n))
      call solve_both(lu, m, x, z, residual, failure)
      copy = lu
      deallocate (lu)
      x(:) = 1.0_wp
      call copy%solve(x)
      call check_below(failure, left_of_ones(copy, x), 1.0e-12_wp, 'what is left by the copy')
      call solve_both(copy, m, x, z, residual, failure)
      call check_below(failure, residual, 1.0e-12_wp, 'what is left by its own factors')
   end subroutine copied

   !> A copy of a copy may come to lie where the first owner was, whose factors are freed.
   subroutine copied_back(failure)
      character(:), allocatable, intent(inout) :: failure
      integer, parameter :: m = 10
      type(umfpack_lu_t), allocatable :: lu, copy
      real(wp), allocatable :: x(:)
      complex(wp), allocatable :: z(:)
      real(wp) :: residual
      logical :: found

      allocate (lu)
      call try_umfpack(m, lu, found)
      if (.not. found) return
      allocate (x(lu%n), z(lu%n))
      call solve_both(lu, m, x, z, residual, failure)
      copy = lu
      deallocate (lu)
      allocate (lu, source=copy)
      x(:) = 1.0_wp
      call lu%solve(x)
      call check_below(failure, left_of_ones(lu, x), 1.0e-12_wp, 'what is left')
   end subroutine copied_back

   !> What a solution of the net's real matrix and a right-hand side of ones leaves.
   real(wp) function left_of_ones(lu, x)
      class(lu_t), intent(in) :: lu
      real(wp), intent(in) :: x(:)
      integer, parameter :: m = 10

      left_of_ones = maxval(abs(left(lu%row, lu%column, cmplx(values_of(m, lu%row, lu%column), 0.0_wp, wp), &
                                     cmplx(x, 0.0_wp, wp), cmplx(0.0_wp*x + 1.0_wp, 0.0_wp, wp))))
   end function left_of_ones

end module test_lu
