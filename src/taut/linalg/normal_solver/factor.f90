!> The pseudo-inverse of the kept rows of A L^-T with K = L L^T, by DGELSD: the condition number is not squared.
module taut_linalg_normal_solver_factor
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_kinds, only: wp
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_csr, only: csr_t
   use taut_linalg_normal_solver, only: normal_solver_t
   use taut_linalg_pivoted_cholesky, only: orthonormalize, remove_components
   use taut_linalg_pseudo_inverse, only: singular_value_inverse_t
   use taut_linalg_rank, only: pivot_floor
   implicit none (type, external)
   private
   public :: factor_solver_t

   !> A root B = L^-1 A^T of S = B^T B.
   type, extends(normal_solver_t) :: factor_solver_t
      !> The pseudo-inverse of the kept columns of B, transposed.
      type(singular_value_inverse_t), private :: root
      !> The kept rows, then the others.
      integer, allocatable, private :: row(:)
      !> B: (n, c), and the kept rows of B^T: (rank, n); K^-1 A^T: (n, c); orthonormal null vectors: (c, c - rank).
      real(wp), allocatable, private :: b(:, :), basis(:, :), kinv_at(:, :), null(:, :)
      !> Scales of rows (rank) and columns (n); workspace: (n).
      real(wp), allocatable, private :: scale(:), ones(:), z(:)
   contains
      procedure :: init
      procedure :: keep
      procedure :: factorize
      procedure :: multipliers
      procedure :: correction
      procedure :: weakest
   end type factor_solver_t

contains

   !> Allocates the workspace.
   subroutine init(self, a, c, sizes)
      !> The solver.
      class(factor_solver_t), intent(inout) :: self
      !> A matrix with the pattern of A.
      type(csr_t), intent(in) :: a
      !> How many of its rows are used, from the first one on.
      integer, intent(in) :: c
      !> Sizes of the blocks of K.
      integer, intent(in) :: sizes(:)

      call self%set_sizes(c, a%n)
      allocate (self%b(a%n, c), self%kinv_at(a%n, c), self%z(a%n), source=0.0_wp)
      allocate (self%ones(a%n), source=1.0_wp)
      call self%keep(spread(.true., 1, c))
      associate (unused_sizes => sizes)
      end associate
   end subroutine init

   !> Takes the rows that are independent.
   subroutine keep(self, kept)
      !> The solver, after `init`.
      class(factor_solver_t), intent(inout) :: self
      !> Which they are: (c).
      logical, intent(in) :: kept(:)
      integer :: c, i, rank

      call self%set_kept(kept)
      c = self%c
      rank = self%rank
      self%row = [pack([(i, i=1, c)], kept), pack([(i, i=1, c)], .not. kept)]
      if (allocated(self%basis)) deallocate (self%basis, self%null, self%scale)
      allocate (self%basis(rank, self%n), self%null(c, c - rank), self%scale(rank), source=0.0_wp)
      call self%root%init(rank, self%n)
   end subroutine keep

   !> Takes a new A, and K factorized.
   subroutine factorize(self, a, k, identity, info)
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
      integer :: i, j, l, last
      real(wp) :: least

      self%identity = identity
      info = 1
      last = self%c*self%n
      if (.not. a%full) last = a%first(self%c + 1) - 1
      do l = 1, last
         if (.not. ieee_is_finite(a%values(l))) return
      end do
      self%b(:, :) = 0.0_wp
      do i = 1, self%c
         if (a%full) then
            do j = 1, self%n
               self%b(j, i) = a%values((i - 1)*self%n + j)
            end do
         else
            do l = a%first(i), a%first(i + 1) - 1
               self%b(a%column(l), i) = a%values(l)
            end do
         end if
      end do
      if (.not. identity) call k%solve_lower(self%c, self%b)
      if (.not. all(ieee_is_finite(self%b))) return
      do i = 1, self%rank
         self%basis(i, :) = self%b(:, self%row(i))
         self%scale(i) = 1.0_wp
         if (maxval(abs(self%basis(i, :))) > tiny(1.0_wp)) self%scale(i) = 1.0_wp/norm2(self%basis(i, :))
      end do
      ! Singular values are the roots of those of S, and round-off is not.
      least = self%cut
      if (least > pivot_floor) least = sqrt(least)
      call self%root%compute(self%basis, self%scale, self%ones, least, least, info)
      if (info /= 0) return
      self%kinv_at(:, :) = self%b
      if (.not. identity) call k%solve_lower_transposed(self%c, self%kinv_at)
      call find_null_vectors(self)
      if (self%is_new) call self%judge(self%weakest())
   end subroutine factorize

   !> For each row that is not kept the multipliers of the others that make up for its own, made orthonormal.
   subroutine find_null_vectors(self)
      class(factor_solver_t), intent(inout) :: self
      integer :: i, j

      do j = 1, self%c - self%rank
         self%null(:, j) = 0.0_wp
         do i = 1, self%rank
            self%null(self%row(i), j) = -dot_product(self%root%inverse(:, i), self%b(:, self%row(self%rank + j)))
         end do
         self%null(self%row(self%rank + j), j) = 1.0_wp
         ! Once more: what they leave of the rows.
         self%z(:) = 0.0_wp
         do i = 1, self%c
            self%z(:) = self%z + self%null(i, j)*self%b(:, i)
         end do
         do i = 1, self%rank
            self%null(self%row(i), j) = self%null(self%row(i), j) - dot_product(self%root%inverse(:, i), self%z)
         end do
      end do
      call orthonormalize(self%null, self%c - self%rank)
   end subroutine find_null_vectors

   !> Multipliers S^+ r, of minimum norm.
   subroutine multipliers(self, r, lambda)
      !> The solver, after `factorize`.
      class(factor_solver_t), intent(inout) :: self
      !> Violation at the level concerned: (c).
      real(wp), intent(in) :: r(self%c)
      !> The multipliers: (c).
      real(wp), intent(out) :: lambda(self%c)
      integer :: i, j

      lambda(:) = r
      call remove_components(self%null, self%c - self%rank, lambda)
      ! (B^T B)^-1 = B^+ (B^+)^T with the kept columns of B.
      self%z(:) = 0.0_wp
      do j = 1, self%rank
         do i = 1, self%n
            self%z(i) = self%z(i) + self%root%inverse(i, j)*lambda(self%row(j))
         end do
      end do
      lambda(:) = 0.0_wp
      do j = 1, self%rank
         do i = 1, self%n
            lambda(self%row(j)) = lambda(self%row(j)) + self%root%inverse(i, j)*self%z(i)
         end do
      end do
      call remove_components(self%null, self%c - self%rank, lambda)
   end subroutine multipliers

   !> The square of the smallest singular value of the scaled basis, relative to the largest.
   pure function weakest(self) result(pivot)
      !> The solver, after `factorize`.
      class(factor_solver_t), intent(in) :: self
      !> 0 if some were taken for zero.
      real(wp) :: pivot

      pivot = 0.0_wp
      if (self%root%rank == self%rank) pivot = 1.0_wp/self%root%condition**2
   end function weakest

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
