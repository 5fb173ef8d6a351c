!> What solvers have in common that take S as a full matrix: its part S_KK of the kept rows, and the null vectors of the others.
module taut_linalg_normal_solver_dense
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_kinds, only: wp
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_csr, only: csr_t
   use taut_linalg_lapack, only: dgemm
   use taut_linalg_normal_matrix, only: normal_matrix_t
   use taut_linalg_normal_solver, only: normal_solver_t
   use taut_linalg_pivoted_cholesky, only: orthonormalize, remove_components
   implicit none (type, external)
   private
   public :: dense_solver_t, basic_solver_t

   !> Below this product of sizes, loops are faster than a call of DGEMM.
   integer, parameter :: small = 20000

   !> A solver with all of S.
   type, abstract, extends(normal_solver_t) :: dense_solver_t
      !> S: (c, c), the inverse of the paper's reduced mass matrix, Eq. (20).
      real(wp), allocatable :: s(:, :)
      !> K^-1 A^T: (n, c), of an A with all its entries; or the entries of A K^-1 and of S, of an A with a pattern.
      real(wp), allocatable, private :: kinv_at(:, :)
      type(normal_matrix_t), allocatable, private :: normal
   contains
      procedure :: init
      procedure :: form
      procedure :: correction
   end type dense_solver_t

   !> One that solves with S_KK and makes S^+ r of it: of r what the constraints cannot have is taken off, of x what makes no
   !! reaction.
   type, abstract, extends(dense_solver_t) :: basic_solver_t
      !> The kept rows, then the others.
      integer, allocatable, private :: row(:)
      !> S_KK; orthonormal null vectors: (c, c - rank); workspace.
      real(wp), allocatable, private :: basis(:, :), null(:, :), r(:), x(:)
   contains
      procedure(invert), deferred :: invert
      procedure(solve), deferred :: solve
      procedure, non_overridable :: keep_basis
      procedure :: keep => keep_basis
      procedure :: factorize
      procedure :: multipliers
   end type basic_solver_t

   abstract interface

      !> Prepares solutions with S_KK.
      subroutine invert(self, s, info)
         import :: basic_solver_t, wp
         implicit none (type, external)
         !> The solver.
         class(basic_solver_t), intent(inout) :: self
         !> S_KK, finite: (rank, rank).
         real(wp), intent(in) :: s(:, :)
         !> 0, or not 0 if that is not possible.
         integer, intent(out) :: info
      end subroutine invert

      !> x = S_KK^-1 r.
      subroutine solve(self, r, x)
         import :: basic_solver_t, wp
         implicit none (type, external)
         !> The solver, after `invert`.
         class(basic_solver_t), intent(inout) :: self
         !> Right-hand side: (rank).
         real(wp), intent(in), contiguous :: r(:)
         !> Solution: (rank).
         real(wp), intent(out), contiguous :: x(:)
      end subroutine solve

   end interface

contains

   !> Allocates what S needs.
   subroutine init(self, a, c, sizes)
      !> The solver.
      class(dense_solver_t), intent(inout) :: self
      !> A matrix with the pattern of A.
      type(csr_t), intent(in) :: a
      !> How many of its rows are used, from the first one on.
      integer, intent(in) :: c
      !> Sizes of the blocks of K.
      integer, intent(in) :: sizes(:)

      call self%set_sizes(c, a%n)
      allocate (self%s(c, c), source=0.0_wp)
      if (a%full) then
         allocate (self%kinv_at(a%n, c), source=0.0_wp)
      else
         allocate (self%normal)
         call self%normal%init(a, c, sizes)
      end if
      call self%keep(spread(.true., 1, c))
   end subroutine init

   !> S for a new A, and K factorized.
   subroutine form(self, a, k, identity, info)
      !> The solver.
      class(dense_solver_t), intent(inout) :: self
      !> The constraint matrix.
      type(csr_t), intent(in) :: a
      !> The metric, factorized; not used if it is the identity.
      type(block_diagonal_t), intent(in) :: k
      !> Whether K = I.
      logical, intent(in) :: identity
      !> 0, or 1 if there are entries that are not finite.
      integer, intent(out) :: info
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
         if (finite) call scatter(self%c, self%normal%row, self%normal%column, self%normal%s, self%s)
      else
         do l = 1, self%c*self%n
            finite = finite .and. ieee_is_finite(a%values(l))
         end do
         if (finite) call multiply(self, self%c, self%n, a%values, k)
         do l = 1, self%c
            finite = finite .and. ieee_is_finite(self%s(l, l))
         end do
      end if
      info = merge(0, 1, finite)
   end subroutine form

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

   !> Takes the rows that are independent.
   subroutine keep_basis(self, kept)
      !> The solver, after `init`.
      class(basic_solver_t), intent(inout) :: self
      !> Which they are: (c).
      logical, intent(in) :: kept(:)
      integer :: c, i, rank

      call self%set_kept(kept)
      c = self%c
      rank = self%rank
      self%row = [pack([(i, i=1, c)], kept), pack([(i, i=1, c)], .not. kept)]
      if (allocated(self%basis)) deallocate (self%basis, self%null, self%r, self%x)
      allocate (self%basis(rank, rank), self%null(c, c - rank), self%r(c), self%x(c), source=0.0_wp)
   end subroutine keep_basis

   !> Takes a new A, and K factorized.
   subroutine factorize(self, a, k, identity, info)
      !> The solver.
      class(basic_solver_t), intent(inout) :: self
      !> The constraint matrix.
      type(csr_t), intent(in) :: a
      !> The metric, factorized; not used if it is the identity.
      type(block_diagonal_t), intent(in) :: k
      !> Whether K = I.
      logical, intent(in) :: identity
      !> 0, or not 0 if there are entries that are not finite or the singular values were not found.
      integer, intent(out) :: info
      integer :: i, j

      call self%form(a, k, identity, info)
      if (info /= 0) return
      if (self%rank == self%c) then
         call self%invert(self%s, info)
      else
         do j = 1, self%rank
            do i = 1, self%rank
               self%basis(i, j) = self%s(self%row(i), self%row(j))
            end do
         end do
         call self%invert(self%basis, info)
         if (info == 0) call find_null_vectors(self)
      end if
      if (info == 0 .and. self%is_new) call self%judge(self%weakest())
   end subroutine factorize

   !> For each row that is not kept the multipliers of the others that make up for its own, made orthonormal.
   subroutine find_null_vectors(self)
      class(basic_solver_t), intent(inout) :: self
      integer :: i, j, rank

      rank = self%rank
      do j = 1, self%c - rank
         do i = 1, rank
            self%r(i) = -self%s(self%row(i), self%row(rank + j))
         end do
         call self%solve(self%r(:rank), self%x(:rank))
         self%null(:, j) = 0.0_wp
         do i = 1, rank
            self%null(self%row(i), j) = self%x(i)
         end do
         self%null(self%row(rank + j), j) = 1.0_wp
         if (self%refinements == 0) cycle
         ! Once more: what they leave of S.
         do i = 1, rank
            self%r(i) = dot_product(self%s(:, self%row(i)), self%null(:, j))
         end do
         call self%solve(self%r(:rank), self%x(:rank))
         do i = 1, rank
            self%null(self%row(i), j) = self%null(self%row(i), j) - self%x(i)
         end do
      end do
      call orthonormalize(self%null, self%c - rank)
   end subroutine find_null_vectors

   !> Multipliers S^+ r, of minimum norm.
   subroutine multipliers(self, r, lambda)
      !> The solver, after `factorize`.
      class(basic_solver_t), intent(inout) :: self
      !> Violation at the level concerned: (c).
      real(wp), intent(in) :: r(self%c)
      !> The multipliers: (c).
      real(wp), intent(out) :: lambda(self%c)
      integer :: i, rank

      rank = self%rank
      if (rank == self%c) then
         call self%solve(r, lambda)
         return
      end if
      do i = 1, self%c
         lambda(i) = r(i)
      end do
      call remove_components(self%null, self%c - rank, lambda)
      do i = 1, rank
         self%r(i) = lambda(self%row(i))
      end do
      call self%solve(self%r(:rank), self%x(:rank))
      lambda(:) = 0.0_wp
      do i = 1, rank
         lambda(self%row(i)) = self%x(i)
      end do
      call remove_components(self%null, self%c - rank, lambda)
   end subroutine multipliers

end module taut_linalg_normal_solver_dense
