!> Square sparse matrices, real or complex, with one pattern: their factors, and what is solved with them.
!!
!! The pattern is that of a symmetric matrix, the values need not be symmetric; pivots are chosen such that matrices stay stable
!! whose diagonal has zeros, such as those of saddle-point problems.
module taut_linalg_lu
   use taut_kinds, only: wp
   implicit none (type, external)
   private
   public :: lu_t, lu_not_finite, lu_too_large

   !> What `factorize` answers besides 0 and the place where a matrix is singular: an entry is not finite; the factors need more
   !! memory than is sensible, or than there is.
   integer, parameter :: lu_not_finite = -1, lu_too_large = -2

   !> A real and a complex matrix with one pattern.
   type, abstract :: lu_t
      !> Order of the matrix.
      integer :: n = 0
      !> Row and column of each entry: (entries).
      integer, allocatable :: row(:), column(:)
   contains
      procedure(lay_out_pattern), deferred :: init
      procedure(count_of_pattern), deferred :: work
      procedure(count_of_pattern), deferred :: numbers
      procedure(real_factorization), deferred :: factorize_real
      procedure(complex_factorization), deferred :: factorize_complex
      procedure(real_solution), deferred :: solve_real
      procedure(complex_solution), deferred :: solve_complex
      generic :: factorize => factorize_real, factorize_complex
      generic :: solve => solve_real, solve_complex
   end type lu_t

   abstract interface
      !> Takes a pattern and orders it.
      subroutine lay_out_pattern(self, n, row, column)
         import :: lu_t
         implicit none (type, external)
         !> The factors.
         class(lu_t), intent(inout) :: self
         !> Order of the matrix.
         integer, intent(in) :: n
         !> Row of each entry; an entry may be named more than once, its values then add up: (entries).
         integer, intent(in) :: row(:)
         !> Column of each entry: (entries).
         integer, intent(in) :: column(:)
      end subroutine lay_out_pattern

      !> Of the real factors: the multiplications that they take, in those of full matrices; the numbers that are stored.
      function count_of_pattern(self) result(number)
         import :: lu_t, wp
         implicit none (type, external)
         !> The factors, laid out.
         class(lu_t), intent(in) :: self
         !> How many.
         real(wp) :: number
      end function count_of_pattern

      !> Factorizes a real matrix.
      subroutine real_factorization(self, values, info)
         import :: lu_t, wp
         implicit none (type, external)
         !> The factors.
         class(lu_t), intent(inout) :: self
         !> The entries: (entries of the pattern).
         real(wp), intent(in) :: values(:)
         !> 0; or the row and column at which it was found to be singular; or one of the constants.
         integer, intent(out) :: info
      end subroutine real_factorization

      !> Factorizes a complex matrix.
      subroutine complex_factorization(self, values, info)
         import :: lu_t, wp
         implicit none (type, external)
         !> The factors.
         class(lu_t), intent(inout) :: self
         !> The entries: (entries of the pattern).
         complex(wp), intent(in) :: values(:)
         !> As for a real matrix.
         integer, intent(out) :: info
      end subroutine complex_factorization

      !> Solves with the factors of the real matrix.
      subroutine real_solution(self, x)
         import :: lu_t, wp
         implicit none (type, external)
         !> The factors.
         class(lu_t), intent(inout) :: self
         !> Right-hand side, replaced by the solution: (n).
         real(wp), intent(inout) :: x(:)
      end subroutine real_solution

      !> Solves with the factors of the complex matrix.
      subroutine complex_solution(self, x)
         import :: lu_t, wp
         implicit none (type, external)
         !> The factors.
         class(lu_t), intent(inout) :: self
         !> Right-hand side, replaced by the solution: (n).
         complex(wp), intent(inout) :: x(:)
      end subroutine complex_solution
   end interface

end module taut_linalg_lu
