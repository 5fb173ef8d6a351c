!> What solvers have in common that take S as a full matrix and leave it to `pseudo_inverse_t`.
module taut_linalg_normal_solver_dense
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_kinds, only: wp
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_csr, only: csr_t
   use taut_linalg_lapack, only: dgemm
   use taut_linalg_normal_matrix, only: normal_matrix_t
   use taut_linalg_normal_solver, only: normal_solver_t
   use taut_linalg_pseudo_inverse, only: pseudo_inverse_t
   implicit none (type, external)
   private
   public :: dense_solver_t

   !> Below this product of sizes, loops are faster than a call of DGEMM.
   integer, parameter :: small = 20000

   !> A solver with all of S.
   type, abstract, extends(normal_solver_t) :: dense_solver_t
      !> S^+.
      type(pseudo_inverse_t) :: s_plus
      !> S: (c, c), the inverse of the paper's reduced mass matrix, Eq. (20).
      real(wp), allocatable, private :: s(:, :)
      !> K^-1 A^T: (n, c), of an A with all its entries; or the entries of A K^-1 and of S, of an A with a pattern.
      real(wp), allocatable, private :: kinv_at(:, :)
      type(normal_matrix_t), allocatable, private :: normal
   contains
      procedure :: lay_out
      procedure :: factorize
      procedure :: multipliers
      procedure :: correction
   end type dense_solver_t

contains

   !> Allocates all but S^+.
   subroutine lay_out(self, a, c, sizes, rcond)
      !> The solver.
      class(dense_solver_t), intent(inout) :: self
      !> A matrix with the pattern of A.
      type(csr_t), intent(in) :: a
      !> How many of its rows are used, from the first one on.
      integer, intent(in) :: c
      !> Sizes of the blocks of K.
      integer, intent(in) :: sizes(:)
      !> Relative size of a singular value or pivot that counts as zero; 0 for the default.
      real(wp), intent(in) :: rcond

      self%c = c
      self%n = a%n
      if (rcond > 0.0_wp) self%s_plus%rcond = rcond
      allocate (self%s(c, c), source=0.0_wp)
      if (a%full) then
         allocate (self%kinv_at(a%n, c), source=0.0_wp)
      else
         allocate (self%normal)
         call self%normal%init(a, c, sizes)
      end if
   end subroutine lay_out

   !> Takes a new A, and K factorized.
   subroutine factorize(self, a, k, identity, info, noise)
      !> The solver.
      class(dense_solver_t), intent(inout) :: self
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
      logical :: finite
      integer :: l

      self%identity = identity
      finite = .true.
      if (allocated(self%normal)) then
         call self%normal%assemble(a, k, identity)
         ! What is not finite in a row of A is not finite on the diagonal.
         do l = 1, self%c
            finite = finite .and. ieee_is_finite(self%normal%s(l))
         end do
      else
         do l = 1, self%c*self%n
            finite = finite .and. ieee_is_finite(a%values(l))
         end do
      end if
      info = 1
      if (.not. finite) return
      if (allocated(self%normal)) then
         call scatter(self%c, self%normal%row, self%normal%column, self%normal%s, self%s)
      else
         call multiply(self, self%c, self%n, a%values, k)
      end if
      call self%s_plus%compute(self%s, info, noise)
      self%rank = self%s_plus%rank
   end subroutine factorize

   !> S from all entries of A.
   subroutine multiply(self, c, n, at, k)
      class(dense_solver_t), intent(inout) :: self
      integer, intent(in) :: c, n
      !> A^T.
      real(wp), intent(in) :: at(n, c)
      type(block_diagonal_t), intent(in) :: k
      integer :: i, j, l
      real(wp) :: t

      do i = 1, c
         do l = 1, n
            self%kinv_at(l, i) = at(l, i)
         end do
      end do
      if (.not. self%identity) call k%solve(c, self%kinv_at)
      if (c*c*n > small) then
         call dgemm('T', 'N', c, c, n, 1.0_wp, at, n, self%kinv_at, n, 0.0_wp, self%s, c)
      else
         do j = 1, c
            do i = j, c
               t = 0.0_wp
               do l = 1, n
                  t = t + at(l, i)*self%kinv_at(l, j)
               end do
               self%s(i, j) = t
               self%s(j, i) = t
            end do
         end do
      end if
   end subroutine multiply

   !> S from its entries.
   pure subroutine scatter(c, row, column, entries, s)
      integer, intent(in) :: c, row(:), column(:)
      !> The diagonal (c), then those below it.
      real(wp), intent(in) :: entries(:)
      real(wp), intent(out) :: s(c, c)
      integer :: i, l

      s(:, :) = 0.0_wp
      do i = 1, c
         s(i, i) = entries(i)
      end do
      do l = 1, size(row)
         s(row(l), column(l)) = entries(c + l)
         s(column(l), row(l)) = entries(c + l)
      end do
   end subroutine scatter

   !> Multipliers S^+ r, of minimum norm.
   subroutine multipliers(self, r, lambda)
      !> The solver, after `factorize`.
      class(dense_solver_t), intent(inout) :: self
      !> Violation at the level concerned: (c).
      real(wp), intent(in) :: r(self%c)
      !> The multipliers: (c).
      real(wp), intent(out) :: lambda(self%c)

      call self%s_plus%solve(r, lambda)
   end subroutine multipliers

   !> d := d - K^-1 A^T lambda.
   pure subroutine correction(self, a, lambda, d)
      !> The solver, after `factorize`.
      class(dense_solver_t), intent(in) :: self
      !> The constraint matrix of `factorize`.
      type(csr_t), intent(in) :: a
      !> Multipliers: (c).
      real(wp), intent(in) :: lambda(self%c)
      !> What is corrected: (n).
      real(wp), intent(inout) :: d(self%n)
      integer :: i, j

      if (.not. allocated(self%normal)) then
         do j = 1, self%c
            do i = 1, self%n
               d(i) = d(i) - self%kinv_at(i, j)*lambda(j)
            end do
         end do
      else if (self%identity .and. self%normal%diagonal) then
         call a%subtract_transposed(lambda, d)
      else
         call self%normal%a_kinv%subtract_transposed(lambda, d)
      end if
   end subroutine correction

end module taut_linalg_normal_solver_dense
