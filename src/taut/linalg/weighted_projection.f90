!> The operator that the paper applies at every level: K^-1 A^T (A K^-1 A^T)^+ r, with K a mass or a weight matrix.
!!
!! With K = W it corrects positions and velocities, Eqs (17) and (11a); with K = M it gives the reaction forces, Eq. (11b).
module taut_linalg_weighted_projection
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_kinds, only: wp
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_lapack, only: dgemm
   use taut_linalg_pseudo_inverse, only: pseudo_inverse_t, singular_value_inverse_t, path_singular_values
   implicit none (type, external)
   private
   public :: weighted_projection_t, solver_auto, solver_dgelsd, solver_factor

   !> How the pseudo-inverse is had: `auto` and `dgelsd` form S = A K^-1 A^T and use Cholesky where it is safe, or never;
   !! `factor` applies DGELSD to A L^-T, K = L L^T, which does not square the condition number.
   integer, parameter :: solver_auto = 1, solver_dgelsd = 2, solver_factor = 3

   !> Below this product of sizes, loops are faster than a call of DGEMM.
   integer, parameter :: small = 2000
   !> The doubtful zone of singular values of A L^-T: the root of that of S.
   real(wp), parameter :: doubtful_factor = 1.0e-4_wp

   !> Constraint matrix A with a metric K, ready to be applied.
   type :: weighted_projection_t
      !> Rows of A, constraints.
      integer :: c = 0
      !> Columns of A, velocities.
      integer :: n = 0
      !> Rank of A.
      integer :: rank = 0
      !> S = A K^-1 A^T: (c, c), the inverse of the paper's reduced mass matrix, Eq. (20); not formed by `factor`.
      real(wp), allocatable :: s(:, :)
      !> K^-1 A^T: (n, c).
      real(wp), allocatable :: kinv_at(:, :)
      type(pseudo_inverse_t) :: s_plus
      integer, private :: solver = solver_auto
      real(wp), private :: rcond_factor = 1.0e-9_wp
      real(wp), allocatable, private :: a_linvt(:, :), row(:), ones(:), z(:)
      integer, private :: columns = 0
      integer, allocatable, private :: column(:)
      type(singular_value_inverse_t), private :: root
   contains
      procedure :: init
      procedure :: update
      procedure :: multipliers
      procedure :: correction
   end type weighted_projection_t

contains

   !> Allocates the workspace; nothing is allocated afterwards.
   subroutine init(self, c, n, solver, rcond)
      !> The operator.
      class(weighted_projection_t), intent(inout) :: self
      !> Number of rows of A.
      integer, intent(in) :: c
      !> Number of columns of A.
      integer, intent(in) :: n
      !> One of the `solver_` constants.
      integer, intent(in) :: solver
      !> Relative size below which singular values count as zero, of S or, for `factor`, of A L^-T; 0 takes the default,
      !! 1e-12 and 1e-9.
      real(wp), intent(in) :: rcond

      if (allocated(self%s)) deallocate (self%s, self%kinv_at, self%z, self%column)
      if (allocated(self%a_linvt)) deallocate (self%a_linvt, self%row, self%ones)
      self%c = c
      self%n = n
      self%solver = solver
      self%s_plus%always_singular_values = solver == solver_dgelsd
      if (rcond > 0.0_wp) then
         self%s_plus%rcond = rcond
         self%rcond_factor = rcond
      end if
      call self%s_plus%init(c)
      allocate (self%s(c, c), self%kinv_at(n, c), self%z(n), source=0.0_wp)
      allocate (self%column(n), source=0)
      if (solver == solver_factor) then
         allocate (self%a_linvt(c, n), self%row(c), source=0.0_wp)
         allocate (self%ones(n), source=1.0_wp)
         call self%root%init(c, n)
      end if
   end subroutine init

   !> Takes a new A, and K factorized.
   subroutine update(self, a, k, identity, info, noise)
      !> The operator.
      class(weighted_projection_t), intent(inout) :: self
      !> Constraint matrix: (at least c, n); its first c rows are used.
      real(wp), intent(in), contiguous :: a(:, :)
      !> The metric, factorized; not used if it is the identity.
      type(block_diagonal_t), intent(in) :: k
      !> Whether K = I.
      logical, intent(in) :: identity
      !> 0, or not 0 if there are entries that are not finite or the singular values were not found.
      integer, intent(out) :: info
      !> See `compute` of `pseudo_inverse_t`.
      real(wp), intent(in) :: noise
      integer :: c, i, j, l, n
      logical :: touched
      real(wp) :: t

      c = self%c
      n = self%n
      info = 0
      if (c == 0) return
      if (c == 1 .and. self%solver == solver_auto) then
         call update_single(self, a, k, identity, info)
         return
      end if
      ! Columns of zeros belong to coordinates that no constraint touches: they, and whole blocks of them, are left out.
      self%columns = 0
      do j = 1, n
         touched = .false.
         do i = 1, c
            if (.not. ieee_is_finite(a(i, j))) then
               info = 1
               return
            end if
            self%kinv_at(j, i) = a(i, j)
            touched = touched .or. abs(a(i, j)) > 0.0_wp
         end do
         if (touched) then
            self%columns = self%columns + 1
            self%column(self%columns) = j
         end if
      end do
      if (self%solver == solver_factor) then
         call update_factor(self, k, identity, info, noise)
         return
      end if
      if (.not. identity) call k%solve(c, self%kinv_at)
      if (c*c*self%columns > small) then
         call dgemm('N', 'N', c, c, n, 1.0_wp, a, size(a, 1), self%kinv_at, n, 0.0_wp, self%s, c)
      else
         do j = 1, c
            do i = 1, c
               t = 0.0_wp
               do l = 1, self%columns
                  t = t + a(i, self%column(l))*self%kinv_at(self%column(l), j)
               end do
               self%s(i, j) = t
            end do
         end do
      end if
      call self%s_plus%compute(self%s, info, noise)
      self%rank = self%s_plus%rank
   end subroutine update

   !> One constraint: S is a number.
   subroutine update_single(self, a, k, identity, info)
      type(weighted_projection_t), intent(inout) :: self
      real(wp), intent(in), contiguous :: a(:, :)
      type(block_diagonal_t), intent(in) :: k
      logical, intent(in) :: identity
      integer, intent(out) :: info
      real(wp) :: s
      integer :: l

      do l = 1, self%n
         self%kinv_at(l, 1) = a(1, l)
      end do
      if (.not. identity) call k%solve(1, self%kinv_at)
      s = 0.0_wp
      do l = 1, self%n
         s = s + a(1, l)*self%kinv_at(l, 1)
      end do
      self%s(1, 1) = s
      call self%s_plus%compute_single(s, info)
      self%rank = self%s_plus%rank
   end subroutine update_single

   !> The pseudo-inverse of A L^-T, without squaring the condition number.
   subroutine update_factor(self, k, identity, info, noise)
      type(weighted_projection_t), intent(inout) :: self
      type(block_diagonal_t), intent(in) :: k
      logical, intent(in) :: identity
      integer, intent(out) :: info
      real(wp), intent(in) :: noise
      integer :: i, j

      if (.not. identity) call k%solve_lower(self%c, self%kinv_at)
      do i = 1, self%c
         do j = 1, self%n
            if (.not. ieee_is_finite(self%kinv_at(j, i))) then
               info = 1
               return
            end if
            self%a_linvt(i, j) = self%kinv_at(j, i)
         end do
         self%row(i) = 1.0_wp
         if (maxval(abs(self%kinv_at(:, i))) > tiny(1.0_wp)) self%row(i) = 1.0_wp/norm2(self%kinv_at(:, i))
      end do
      call self%root%compute(self%a_linvt, self%row, self%ones, self%rcond_factor, &
                             max(doubtful_factor, min(1.0_wp, 10*noise)), info)
      if (.not. identity) call k%solve_lower_transposed(self%c, self%kinv_at)
      self%rank = self%root%rank
      self%s_plus%rank = self%root%rank
      self%s_plus%condition = self%root%condition**2
      self%s_plus%path = path_singular_values
   end subroutine update_factor

   !> Multipliers S^+ r, Eqs (7) and (14), of minimum norm.
   subroutine multipliers(self, r, lambda)
      !> The operator, updated.
      class(weighted_projection_t), intent(inout) :: self
      !> Violation at the level concerned: (c).
      real(wp), intent(in), contiguous :: r(:)
      !> The multipliers: (c).
      real(wp), intent(out), contiguous :: lambda(:)
      integer :: i, j

      if (self%c == 0) return
      if (self%solver == solver_factor) then
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
      else
         call self%s_plus%solve(r, lambda)
      end if
   end subroutine multipliers

   !> d := d - K^-1 A^T lambda: takes off what is normal to the constraints in the metric K.
   pure subroutine correction(self, lambda, d)
      !> The operator, updated.
      class(weighted_projection_t), intent(in) :: self
      !> Multipliers: (c).
      real(wp), intent(in), contiguous :: lambda(:)
      !> What is corrected: (n).
      real(wp), intent(inout), contiguous :: d(:)
      integer :: i, j

      do j = 1, self%c
         do i = 1, self%n
            d(i) = d(i) - self%kinv_at(i, j)*lambda(j)
         end do
      end do
   end subroutine correction

end module taut_linalg_weighted_projection
