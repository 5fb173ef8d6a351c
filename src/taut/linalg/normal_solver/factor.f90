!> The pseudo-inverse of A L^-T with K = L L^T, by DGELSD: the condition number is not squared.
module taut_linalg_normal_solver_factor
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_kinds, only: wp
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_csr, only: csr_t
   use taut_linalg_normal_solver, only: normal_solver_t
   use taut_linalg_pseudo_inverse, only: singular_value_inverse_t
   use taut_linalg_rank, only: doubtful_in_root, rcond_of_root
   implicit none (type, external)
   private
   public :: factor_solver_t

   !> A root of S.
   type, extends(normal_solver_t) :: factor_solver_t
      real(wp), private :: rcond = rcond_of_root
      !> (A L^-T)^+.
      type(singular_value_inverse_t), private :: root
      !> A L^-T: (c, n); first L^-1 A^T, then K^-1 A^T: (n, c); scales of rows (c) and columns (n); workspace: (n).
      real(wp), allocatable, private :: a_linvt(:, :), kinv_at(:, :), row(:), ones(:), z(:)
   contains
      procedure :: init
      procedure :: factorize
      procedure :: multipliers
      procedure :: correction
   end type factor_solver_t

contains

   !> Allocates the workspace.
   subroutine init(self, a, c, sizes, rcond)
      !> The solver.
      class(factor_solver_t), intent(inout) :: self
      !> A matrix with the pattern of A.
      type(csr_t), intent(in) :: a
      !> How many of its rows are used, from the first one on.
      integer, intent(in) :: c
      !> Sizes of the blocks of K.
      integer, intent(in) :: sizes(:)
      !> Relative size below which singular values of A L^-T count as zero; 0 for the default.
      real(wp), intent(in) :: rcond

      self%c = c
      self%n = a%n
      if (rcond > 0.0_wp) self%rcond = rcond
      allocate (self%a_linvt(c, a%n), self%kinv_at(a%n, c), self%row(c), self%z(a%n), source=0.0_wp)
      allocate (self%ones(a%n), source=1.0_wp)
      call self%root%init(c, a%n)
      associate (unused_sizes => sizes)
      end associate
   end subroutine init

   !> Takes a new A, and K factorized.
   subroutine factorize(self, a, k, identity, info, noise)
      !> The solver.
      class(factor_solver_t), intent(inout) :: self
      !> The constraint matrix.
      type(csr_t), intent(in) :: a
      !> The metric, factorized; not used if it is the identity.
      type(block_diagonal_t), intent(in) :: k
      !> Whether K = I.
      logical, intent(in) :: identity
      !> 0, or not 0 if there are entries that are not finite or the singular values were not found.
      integer, intent(out) :: info
      !> Relative error of the rows of A.
      real(wp), intent(in) :: noise
      integer :: i, j, l, last

      self%identity = identity
      info = 1
      last = self%c*self%n
      if (.not. a%full) last = a%first(self%c + 1) - 1
      do l = 1, last
         if (.not. ieee_is_finite(a%values(l))) return
      end do
      self%kinv_at(:, :) = 0.0_wp
      do i = 1, self%c
         if (a%full) then
            do j = 1, self%n
               self%kinv_at(j, i) = a%values((i - 1)*self%n + j)
            end do
         else
            do l = a%first(i), a%first(i + 1) - 1
               self%kinv_at(a%column(l), i) = a%values(l)
            end do
         end if
      end do
      if (.not. identity) call k%solve_lower(self%c, self%kinv_at)
      do i = 1, self%c
         do j = 1, self%n
            if (.not. ieee_is_finite(self%kinv_at(j, i))) return
            self%a_linvt(i, j) = self%kinv_at(j, i)
         end do
         self%row(i) = 1.0_wp
         if (maxval(abs(self%kinv_at(:, i))) > tiny(1.0_wp)) self%row(i) = 1.0_wp/norm2(self%kinv_at(:, i))
      end do
      call self%root%compute(self%a_linvt, self%row, self%ones, self%rcond, doubtful_in_root(noise), info)
      if (.not. identity) call k%solve_lower_transposed(self%c, self%kinv_at)
      self%rank = self%root%rank
   end subroutine factorize

   !> Multipliers S^+ r, of minimum norm.
   subroutine multipliers(self, r, lambda)
      !> The solver, after `factorize`.
      class(factor_solver_t), intent(inout) :: self
      !> Violation at the level concerned: (c).
      real(wp), intent(in) :: r(self%c)
      !> The multipliers: (c).
      real(wp), intent(out) :: lambda(self%c)
      integer :: i, j

      ! (B^T B)^+ = B^+ (B^+)^T with B = L^-1 A^T.
      self%z(:) = 0.0_wp
      do j = 1, self%c
         do i = 1, self%n
            self%z(i) = self%z(i) + self%root%inverse(i, j)*r(j)
         end do
      end do
      do j = 1, self%c
         lambda(j) = 0.0_wp
         do i = 1, self%n
            lambda(j) = lambda(j) + self%root%inverse(i, j)*self%z(i)
         end do
      end do
   end subroutine multipliers

   !> d := d - K^-1 A^T lambda.
   pure subroutine correction(self, a, lambda, d)
      !> The solver, after `factorize`.
      class(factor_solver_t), intent(in) :: self
      !> The constraint matrix of `factorize`.
      type(csr_t), intent(in) :: a
      !> Multipliers: (c).
      real(wp), intent(in) :: lambda(self%c)
      !> What is corrected: (n).
      real(wp), intent(inout) :: d(self%n)
      integer :: i, j

      do j = 1, self%c
         do i = 1, self%n
            d(i) = d(i) - self%kinv_at(i, j)*lambda(j)
         end do
      end do
      associate (unused_matrix => a)
      end associate
   end subroutine correction

end module taut_linalg_normal_solver_factor
