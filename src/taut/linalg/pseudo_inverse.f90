!> Moore-Penrose pseudo-inverses, and the minimum-norm solution of S x = r for S symmetric positive semi-definite.
!!
!! The decision on the rank is taken on matrices scaled to unit rows (unit diagonal for S), so that it does not depend on
!! the units of the constraints or of the masses; the solution is that of the matrix as given.
module taut_linalg_pseudo_inverse
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_kinds, only: wp
   use taut_linalg_lapack, only: dgelsd
   use taut_linalg_pivoted_cholesky, only: pivoted_cholesky_t
   use taut_linalg_rank, only: clear_rank_by_pivots, doubtful_in_s, effective_rank, least_pivot, rank_by_pivots, rcond_of_s, &
                               unit_diagonal, widest_range
   implicit none (type, external)
   private
   public :: pseudo_inverse_t, singular_value_inverse_t
   public :: by_pivots, by_singular_values, by_either
   public :: path_none, path_cholesky, path_singular_values, path_pivots, path_name

   !> How the last matrix was treated.
   integer, parameter :: path_none = 0, path_cholesky = 1, path_singular_values = 2, path_pivots = 3

   !> By which numbers the rank is decided: by pivots, by singular values, or by pivots where they leave no doubt and by singular
   !! values where they do.
   integer, parameter :: by_pivots = 1, by_singular_values = 2, by_either = 3

   !> Pseudo-inverse of any matrix by DGELSD, and its workspace.
   type :: singular_value_inverse_t
      !> The pseudo-inverse of the last matrix: (n, m).
      real(wp), allocatable :: inverse(:, :)
      !> Rank of the last matrix.
      integer :: rank = 0
      !> Ratio of the largest to the smallest singular value that counts.
      real(wp) :: condition = 1.0_wp
      integer, private :: m = 0, n = 0
      real(wp), allocatable, private :: a(:, :), b(:, :), s(:), work(:)
      integer, allocatable, private :: iwork(:)
   contains
      procedure :: init => singular_value_init
      procedure :: compute => singular_value_compute
   end type singular_value_inverse_t

   !> Minimum-norm solution of S x = r, S symmetric positive semi-definite of any rank.
   !!
   !! `compute` factorizes, `solve` applies: by Cholesky with pivoting, by DGELSD, or by the first and, in doubt about the rank,
   !! by the second.
   type :: pseudo_inverse_t
      !> What is smaller than this, relative to the largest singular value or pivot of S scaled to unit diagonal, counts as zero.
      real(wp) :: rcond = rcond_of_s
      !> Rank of the last matrix.
      integer :: rank = 0
      !> Condition number of the last matrix (scaled to unit diagonal), zeros left out; by Cholesky, the ratio of the
      !! pivots, which is a lower bound.
      real(wp) :: condition = 1.0_wp
      !> How the last matrix was treated: one of the `path_` constants.
      integer :: path = path_none
      integer, private :: n = 0
      real(wp), private :: reciprocal = 0.0_wp
      real(wp), allocatable, private :: scale(:)
      !> Either may be missing, not both.
      type(pivoted_cholesky_t), allocatable, private :: cholesky
      type(singular_value_inverse_t), allocatable, private :: general
   contains
      procedure :: init
      procedure :: compute
      procedure :: compute_single
      procedure :: solve
   end type pseudo_inverse_t

contains

   !> Allocates the workspace; nothing is allocated afterwards.
   subroutine init(self, n, way)
      !> The solver.
      class(pseudo_inverse_t), intent(inout) :: self
      !> Order of S.
      integer, intent(in) :: n
      !> One of the `by_` constants, default `by_either`.
      integer, intent(in), optional :: way
      integer :: chosen

      chosen = by_either
      if (present(way)) chosen = way
      self%n = n
      if (allocated(self%scale)) deallocate (self%scale)
      if (allocated(self%cholesky)) deallocate (self%cholesky)
      if (allocated(self%general)) deallocate (self%general)
      allocate (self%scale(n), source=0.0_wp)
      if (chosen /= by_singular_values) then
         allocate (self%cholesky)
         call self%cholesky%init(n)
      end if
      if (chosen /= by_pivots) then
         allocate (self%general)
         call self%general%init(n, n)
      end if
   end subroutine init

   !> Prepares the solution with one matrix.
   subroutine compute(self, s, info, noise)
      !> The solver.
      class(pseudo_inverse_t), intent(inout) :: self
      !> Symmetric positive semi-definite: (n, n), the lower triangle is read and, if the singular values are needed, all
      !! of it.
      real(wp), intent(in) :: s(:, :)
      !> 0; 1 if S has entries that are not finite; 2 if the singular values were not found.
      integer, intent(out) :: info
      !> Relative error of the rows of A, where S = A M^-1 A^T, for want of a state that meets the constraints:
      !! singular values of S up to its square can be made of nothing else. Default 0.
      real(wp), intent(in), optional :: noise
      integer :: i, j, n, stat
      real(wp) :: doubtful
      logical :: finite, settled

      n = self%n
      info = 0
      if (n == 0) then
         self%rank = 0
         return
      end if
      if (n == 1 .and. allocated(self%cholesky)) then
         call self%compute_single(s(1, 1), info)
         return
      end if

      doubtful = doubtful_in_s(0.0_wp)
      if (present(noise)) doubtful = doubtful_in_s(noise)
      finite = .true.
      do j = 1, n
         do i = j, n
            finite = finite .and. ieee_is_finite(s(i, j))
         end do
      end do
      if (.not. finite) then
         info = 1
         return
      end if
      do i = 1, n
         self%scale(i) = unit_diagonal(s(i, i))
      end do
      if (allocated(self%cholesky)) then
         call self%cholesky%factorize(s, self%scale, least_pivot(n))
         call judge_pivots(self, doubtful, settled)
         if (settled) return
      end if
      self%path = path_singular_values
      ! Above the diagonal nothing was looked at so far, and LAPACK's iteration for singular values may never end there.
      if (.not. all(ieee_is_finite(s(1:n, 1:n)))) then
         info = 1
         return
      end if
      call self%general%compute(s, self%scale, self%scale, self%rcond, doubtful, stat)
      if (stat /= 0) info = 2
      self%rank = self%general%rank
      self%condition = self%general%condition
   end subroutine compute

   !> The rank from the pivots: where they leave no doubt if there are singular values to be asked.
   subroutine judge_pivots(self, doubtful, settled)
      type(pseudo_inverse_t), intent(inout) :: self
      real(wp), intent(in) :: doubtful
      logical, intent(out) :: settled
      integer :: rank

      associate (p => self%cholesky%pivot)
         if (allocated(self%general)) then
            rank = clear_rank_by_pivots(p, self%rcond, doubtful)
         else
            rank = rank_by_pivots(p, self%rcond, doubtful)
         end if
         settled = rank >= 0
         if (.not. settled) return
         self%path = path_pivots
         if (rank == self%n) self%path = path_cholesky
         self%rank = rank
         self%condition = 1.0_wp
         if (rank > 0) self%condition = p(1)/p(rank)
      end associate
      call self%cholesky%set_rank(rank, self%scale)
   end subroutine judge_pivots

   !> The same for a single constraint, S = s: Cholesky's factorization of one number.
   pure subroutine compute_single(self, s, info)
      !> The solver.
      class(pseudo_inverse_t), intent(inout) :: self
      !> Not negative.
      real(wp), intent(in) :: s
      !> 0; 1 if S is not finite.
      integer, intent(out) :: info

      info = 1
      if (.not. ieee_is_finite(s)) return
      info = 0
      self%path = path_cholesky
      self%condition = 1.0_wp
      self%rank = 0
      self%reciprocal = 0.0_wp
      if (.not. s > tiny(1.0_wp)) return
      self%rank = 1
      self%reciprocal = 1.0_wp/s
   end subroutine compute_single

   !> x = S^+ r, after `compute`.
   subroutine solve(self, r, x)
      !> The prepared solver.
      class(pseudo_inverse_t), intent(inout) :: self
      !> Right-hand side: (n).
      real(wp), intent(in), contiguous :: r(:)
      !> Minimum-norm (least-squares) solution: (n).
      real(wp), intent(out), contiguous :: x(:)
      integer :: i, j

      if (self%n == 1 .and. self%path == path_cholesky) then
         x(1) = self%reciprocal*r(1)
      else if (self%path == path_cholesky .or. self%path == path_pivots) then
         call self%cholesky%solve(self%scale, r, x)
      else
         x(1:self%n) = 0.0_wp
         do j = 1, self%n
            do i = 1, self%n
               x(i) = x(i) + self%general%inverse(i, j)*r(j)
            end do
         end do
      end if
   end subroutine solve

   !> Allocates the workspace for matrices of m rows and n columns.
   subroutine singular_value_init(self, m, n)
      !> The solver.
      class(singular_value_inverse_t), intent(inout) :: self
      !> Number of rows.
      integer, intent(in) :: m
      !> Number of columns.
      integer, intent(in) :: n
      integer :: info, rank, query_iwork(1)
      real(wp) :: query_work(1)

      self%m = m
      self%n = n
      if (allocated(self%a)) deallocate (self%a, self%b, self%s, self%work, self%iwork, self%inverse)
      ! DGELSD wants as many rows of B as the larger side, also for wide matrices.
      allocate (self%a(m, n), self%b(max(m, n), m), self%s(min(m, n)), self%inverse(n, m), source=0.0_wp)
      query_work = 0.0_wp
      query_iwork = 0
      if (min(m, n) > 0) call dgelsd(m, n, m, self%a, m, self%b, max(m, n), self%s, 0.0_wp, rank, &
                                     query_work, -1, query_iwork, info)
      allocate (self%work(max(1, int(query_work(1)))), source=0.0_wp)
      allocate (self%iwork(max(1, query_iwork(1))), source=0)
   end subroutine singular_value_init

   !> The pseudo-inverse of one matrix, its rank judged on diag(left) A diag(right).
   subroutine singular_value_compute(self, a, left, right, rcond, doubtful, info)
      !> The solver; the result is in `inverse`, `rank` and `condition`.
      class(singular_value_inverse_t), intent(inout) :: self
      !> The matrix: (m, n).
      real(wp), intent(in) :: a(:, :)
      !> Factors of the rows, for the decision on the rank: (m).
      real(wp), intent(in) :: left(:)
      !> Factors of the columns: (n).
      real(wp), intent(in) :: right(:)
      !> Singular values below this, relative to the largest, are zero.
      real(wp), intent(in) :: rcond
      !> Below this, relative to the largest, a gap tells which are zero.
      real(wp), intent(in) :: doubtful
      !> 0, or LAPACK's code.
      integer, intent(out) :: info
      integer :: j, rank
      real(wp) :: cut, scaled_cut

      self%rank = 0
      self%condition = 1.0_wp
      self%inverse(:, :) = 0.0_wp
      info = 0
      if (min(self%m, self%n) == 0) return
      call scale_matrix()
      call decompose(self, rcond, rank, info)
      if (info /= 0) return
      self%rank = effective_rank(self%s, rcond, doubtful)
      if (self%rank == 0) return
      self%condition = self%s(1)/self%s(self%rank)
      scaled_cut = cut_below(self%s, self%rank)

      ! The same number of singular values of the matrix as it is.
      cut = rcond
      do j = 1, 2
         self%a(:, :) = a(1:self%m, 1:self%n)
         call decompose(self, cut, rank, info)
         if (info /= 0) return
         if (rank == self%rank) exit
         cut = cut_below(self%s, self%rank)
      end do
      if (self%s(self%rank) >= widest_range*self%s(1)) then
         self%inverse(:, :) = self%b(1:self%n, :)
         return
      end if
      ! Rows in units so different that round-off of the large ones hides the small ones: the scaled matrix still has them.
      ! The solution is as exact, and of minimum norm in the scaled unknowns.
      call scale_matrix()
      call decompose(self, scaled_cut, rank, info)
      do j = 1, self%m
         self%inverse(:, j) = right(1:self%n)*self%b(1:self%n, j)*left(j)
      end do

   contains

      subroutine scale_matrix()
         integer :: k

         do k = 1, self%n
            self%a(:, k) = left(1:self%m)*a(1:self%m, k)*right(k)
         end do
      end subroutine scale_matrix

   end subroutine singular_value_compute

   !> A relative cut that leaves so many singular values: between the last of them and the next.
   pure function cut_below(s, rank) result(cut)
      real(wp), intent(in) :: s(:)
      integer, intent(in) :: rank
      real(wp) :: cut

      cut = 0.5_wp*s(rank)/s(1)
      if (rank < size(s)) cut = sqrt(s(rank)*max(s(rank + 1), epsilon(1.0_wp)**2*s(1)))/s(1)
   end function cut_below

   !> One call of DGELSD with the identity on the right-hand side.
   subroutine decompose(self, rcond, rank, info)
      type(singular_value_inverse_t), intent(inout) :: self
      real(wp), intent(in) :: rcond
      integer, intent(out) :: rank, info
      integer :: i

      self%b(:, :) = 0.0_wp
      do i = 1, self%m
         self%b(i, i) = 1.0_wp
      end do
      call dgelsd(self%m, self%n, self%m, self%a, self%m, self%b, size(self%b, 1), self%s, rcond, rank, &
                  self%work, size(self%work), self%iwork, info)
   end subroutine decompose

   !> The name of a path, for reports.
   pure function path_name(path) result(name)
      !> One of the `path_` constants.
      integer, intent(in) :: path
      !> A word or two.
      character(len=merge(8, merge(15, merge(6, 4, path == path_pivots), path == path_singular_values), &
                          path == path_cholesky)) :: name

      select case (path)
      case (path_cholesky)
         name = 'cholesky'
      case (path_singular_values)
         name = 'singular values'
      case (path_pivots)
         name = 'pivots'
      case default
         name = 'none'
      end select
   end function path_name

end module taut_linalg_pseudo_inverse
