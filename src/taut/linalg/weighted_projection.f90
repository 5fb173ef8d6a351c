!> The operator that the paper applies at every level: K^-1 A^T (A K^-1 A^T)^+ r, with K a mass or a weight matrix.
!!
!! With K = W it corrects positions and velocities, Eqs (17) and (11a); with K = M it gives the reaction forces, Eq. (11b).
module taut_linalg_weighted_projection
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_kinds, only: wp
   use taut_linalg_banded_factor, only: banded_factor_t
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_chained_rows, only: are_chained, factorize_chained, project_chained
   use taut_linalg_lapack, only: dgemm
   use taut_linalg_normal_matrix, only: normal_matrix_t
   use taut_linalg_pivoted_cholesky, only: orthonormalize, remove_components
   use taut_linalg_ordering, only: bandwidth, minimum_degree, reverse_cuthill_mckee
   use taut_linalg_pseudo_inverse, only: pseudo_inverse_t, singular_value_inverse_t, path_singular_values
   use taut_linalg_sparse_factor, only: sparse_factor_t
   use taut_linalg_sparse_rows, only: sparse_rows_t
   implicit none (type, external)
   private
   public :: weighted_projection_t, solver_code, solver_names
   public :: solver_auto, solver_dgelsd, solver_factor, solver_pivoted, solver_banded, solver_sparse

   !> How S^+ is had, S = A K^-1 A^T.
   !!
   !! `auto`: of an A with a pattern, banded or sparse where that pays; otherwise Cholesky with pivoting where its pivots
   !! leave no doubt about the rank, and DGELSD where they do. `dgelsd`: always that. `factor`: DGELSD on A L^-T, K = L L^T,
   !! which does not square the condition number. `pivoted-cholesky`: always that. `banded`, `sparse`: L D L^T in an ordering
   !! with a small bandwidth or with little fill.
   integer, parameter :: solver_auto = 1, solver_dgelsd = 2, solver_factor = 3, solver_pivoted = 4, solver_banded = 5, &
                         solver_sparse = 6
   character(len=16), parameter :: solver_names(6) = [character(len=16) :: 'auto', 'dgelsd', 'factor', 'pivoted-cholesky', &
                                                      'banded', 'sparse']

   !> Below this product of sizes, loops are faster than a call of DGEMM.
   integer, parameter :: small = 20000
   !> The doubtful zone of singular values of A L^-T: the root of that of S.
   real(wp), parameter :: doubtful_factor = 1.0e-4_wp
   !> Relative size below which a pivot counts as zero, unless the user says otherwise; and that of the largest noise.
   real(wp), parameter :: pivot_rcond = 1.0e-8_wp, largest_cut = 1.0e-6_wp
   !> How much a multiplication of the sparse factorization costs, in those of the banded and of the dense one.
   real(wp), parameter :: cost_over_banded = 4.0_wp, cost_over_dense = 4.0_wp
   !> Up to so many constraints a dense factorization is faster than any other, unless S is tridiagonal.
   integer, parameter :: few = 6

   !> Constraint matrix A with a metric K, ready to be applied.
   type :: weighted_projection_t
      !> Rows of A, constraints.
      integer :: c = 0
      !> Columns of A, velocities.
      integer :: n = 0
      !> Rank of A.
      integer :: rank = 0
      !> S = A K^-1 A^T: (c, c), the inverse of the paper's reduced mass matrix, Eq. (20); not formed by `factor` and `banded`.
      real(wp), allocatable :: s(:, :)
      !> K^-1 A^T: (n, c); not formed if A has a pattern, or a single row and K = I.
      real(wp), allocatable :: kinv_at(:, :)
      type(pseudo_inverse_t) :: s_plus
      integer, private :: solver = solver_auto
      logical, private :: identity = .false., structured = .false., banded = .false., sparse = .false., single = .false.
      !> Whether the rows are those of a chain, and how many entries the first one misses.
      logical, private :: chained = .false.
      integer, private :: missing = 0
      real(wp), private :: rcond_factor = 1.0e-9_wp, rcond_pivot = pivot_rcond, reciprocal = 0.0_wp
      real(wp), allocatable, private :: a_linvt(:, :), row(:), ones(:), z(:)
      type(singular_value_inverse_t), private :: root
      type(normal_matrix_t), private :: normal
      type(banded_factor_t), private :: band
      type(sparse_factor_t), private :: fill
   contains
      procedure :: init
      procedure :: update
      procedure :: project
      procedure :: multipliers
      procedure :: minimum_norm
      procedure :: correction
   end type weighted_projection_t

contains

   !> The solver's number for its name; 0 if there is none of that name.
   pure function solver_code(name) result(code)
      !> One of `solver_names`.
      character(*), intent(in) :: name
      !> Its constant.
      integer :: code

      do code = size(solver_names), 1, -1
         if (solver_names(code) == name) return
      end do
   end function solver_code

   !> Allocates the workspace; nothing is allocated afterwards.
   subroutine init(self, a, c, sizes, solver, rcond)
      !> The operator.
      class(weighted_projection_t), intent(out) :: self
      !> A matrix with the pattern of A.
      type(sparse_rows_t), intent(in) :: a
      !> How many of its rows are used, from the first one on.
      integer, intent(in) :: c
      !> Sizes of the blocks of K.
      integer, intent(in) :: sizes(:)
      !> One of the `solver_` constants.
      integer, intent(in) :: solver
      !> Relative size below which singular values count as zero, of S or, for `factor`, of A L^-T, and below which pivots do;
      !! 0 takes the default, 1e-12, 1e-9 and 1e-8.
      real(wp), intent(in) :: rcond
      type(sparse_rows_t) :: filled
      integer :: i, j, n

      n = a%n
      self%c = c
      self%n = n
      self%solver = solver
      if (rcond > 0.0_wp) then
         self%s_plus%rcond = rcond
         self%rcond_factor = rcond
         self%rcond_pivot = rcond
      else if (solver == solver_pivoted) then
         self%s_plus%rcond = pivot_rcond
      end if
      self%structured = solver == solver_banded .or. solver == solver_sparse .or. .not. a%full
      if (solver == solver_factor) then
         self%structured = .false.
         allocate (self%a_linvt(c, n), self%row(c), self%z(n), source=0.0_wp)
         allocate (self%ones(n), source=1.0_wp)
         call self%root%init(c, n)
      end if
      self%single = c == 1 .and. solver /= solver_dgelsd .and. solver /= solver_factor .and. .not. self%structured
      if (self%structured) then
         if (a%full) then
            call filled%set_pattern(n, [(i*n + 1, i=0, c)], [((j, j=1, n), i=1, c)])
            call self%normal%init(filled, c, sizes)
            call choose_ordering(self, filled)
         else
            call self%normal%init(a, c, sizes)
            call choose_ordering(self, a)
         end if
      else
         allocate (self%kinv_at(n, c), source=0.0_wp)
      end if
      if (self%banded .or. self%sparse) then
         allocate (self%z(c), source=0.0_wp)
      else if (solver /= solver_factor) then
         self%s_plus%always_singular_values = solver == solver_dgelsd
         self%s_plus%never_singular_values = solver == solver_pivoted
         call self%s_plus%init(c)
         allocate (self%s(c, c), source=0.0_wp)
      end if
   end subroutine init

   !> Chooses between banded, sparse and dense by what their factorizations cost, unless the user has.
   subroutine choose_ordering(self, a)
      type(weighted_projection_t), intent(inout) :: self
      type(sparse_rows_t), intent(in) :: a
      integer, allocatable :: first(:), neighbor(:)
      integer :: narrow(self%c), thin(self%c), c, i, width
      real(wp) :: work

      c = self%c
      if (.not. any(self%solver == [solver_auto, solver_banded, solver_sparse])) return
      call self%normal%graph(first, neighbor)
      narrow = [(i, i=1, c)]
      width = bandwidth(first, neighbor, narrow)
      if (width > 1) then
         call reverse_cuthill_mckee(first, neighbor, thin)
         if (bandwidth(first, neighbor, thin) < width) narrow = thin
         width = bandwidth(first, neighbor, narrow)
      end if
      self%banded = self%solver == solver_banded .or. (self%solver == solver_auto .and. width <= 1)
      self%sparse = self%solver == solver_sparse
      if (self%solver == solver_auto .and. .not. self%banded .and. c <= few) return
      if (.not. self%banded) then
         call minimum_degree(first, neighbor, thin)
         call self%normal%reorder(a, thin)
         call self%fill%init(c, self%normal%row, self%normal%column)
         if (self%solver == solver_auto) then
            work = self%fill%work()
            self%banded = real(c, wp)*width**2 < cost_over_banded*work
            work = cost_over_dense*min(work, real(c, wp)*width**2/cost_over_banded)
            if (work > real(c, wp)**3/3) then
               self%banded = .false.
               return
            end if
            self%sparse = .not. self%banded
         end if
      end if
      if (self%banded) then
         call self%normal%reorder(a, narrow)
         call self%band%init(c, width)
         self%chained = self%normal%diagonal .and. a%c == c .and. are_chained(a)
         if (self%chained) self%missing = 4 - (a%first(2) - a%first(1))
      end if
   end subroutine choose_ordering

   !> Takes a new A, and K factorized.
   subroutine update(self, a, k, identity, info, noise)
      !> The operator.
      class(weighted_projection_t), intent(inout) :: self
      !> Constraint matrix, laid out like that given to `init`.
      type(sparse_rows_t), intent(in) :: a
      !> The metric, factorized; not used if it is the identity.
      type(block_diagonal_t), intent(in) :: k
      !> Whether K = I.
      logical, intent(in) :: identity
      !> 0, or not 0 if there are entries that are not finite or the singular values were not found.
      integer, intent(out) :: info
      !> See `compute` of `pseudo_inverse_t`.
      real(wp), intent(in) :: noise
      integer :: l, last
      logical :: finite

      info = 0
      if (self%c == 0) return
      self%identity = identity
      if (self%single) then
         if (identity) then
            call update_single(self%n, a%values, a%values, self%reciprocal, self%rank, info)
         else
            call k%solve_vector(a%values, self%kinv_at)
            call update_single(self%n, a%values, self%kinv_at, self%reciprocal, self%rank, info)
         end if
         return
      end if
      last = self%c*self%n
      if (.not. a%full) last = a%first(self%c + 1) - 1
      finite = .true.
      if (self%structured) last = 0
      do l = 1, last
         finite = finite .and. ieee_is_finite(a%values(l))
      end do
      if (.not. finite) then
         info = 1
         return
      end if
      if (self%structured) then
         call update_structured(self, a, k, identity, info, noise)
      else if (self%solver == solver_factor) then
         call update_factor(self, a, k, identity, info, noise)
      else if (a%full) then
         call update_dense(self, self%c, self%n, a%values, k, identity, info, noise)
      else
         info = 1
      end if
   end subroutine update

   !> One constraint: S is a number.
   pure subroutine update_single(n, a, kinv_at, reciprocal, rank, info)
      integer, intent(in) :: n
      real(wp), intent(in) :: a(n), kinv_at(n)
      real(wp), intent(out) :: reciprocal
      integer, intent(out) :: rank, info
      real(wp) :: s
      integer :: l

      s = 0.0_wp
      !GCC$ unroll 1
      !GCC$ novector
      do l = 1, n
         s = s + a(l)*kinv_at(l)
      end do
      info = 0
      rank = 0
      reciprocal = 0.0_wp
      if (.not. ieee_is_finite(s)) then
         info = 1
      else if (s > tiny(1.0_wp)) then
         rank = 1
         reciprocal = 1.0_wp/s
      end if
   end subroutine update_single

   !> S from all entries of A.
   subroutine update_dense(self, c, n, at, k, identity, info, noise)
      type(weighted_projection_t), intent(inout) :: self
      integer, intent(in) :: c, n
      !> A^T.
      real(wp), intent(in) :: at(n, c)
      type(block_diagonal_t), intent(in) :: k
      logical, intent(in) :: identity
      integer, intent(out) :: info
      real(wp), intent(in) :: noise
      integer :: i, j, l
      real(wp) :: t

      do i = 1, c
         do l = 1, n
            self%kinv_at(l, i) = at(l, i)
         end do
      end do
      if (.not. identity) call k%solve(c, self%kinv_at)
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
      call self%s_plus%compute(self%s, info, noise)
      self%rank = self%s_plus%rank
   end subroutine update_dense

   !> S from the entries of A that there are.
   subroutine update_structured(self, a, k, identity, info, noise)
      type(weighted_projection_t), intent(inout) :: self
      type(sparse_rows_t), intent(in) :: a
      type(block_diagonal_t), intent(in) :: k
      logical, intent(in) :: identity
      integer, intent(out) :: info
      real(wp), intent(in) :: noise
      integer :: c, i, j, l
      real(wp) :: cut
      logical :: finite

      info = 0
      ! What a slightly violated constraint makes out of a zero is of the order of the square of the violation.
      cut = max(self%rcond_pivot, min(largest_cut, (10.0_wp*noise)**2))
      if (self%chained) then
         if (identity) then
            call factor_chain(a%values)
         else
            call k%divide(self%normal%a_kinv%column, a%values, self%normal%a_kinv%values)
            call factor_chain(self%normal%a_kinv%values)
         end if
         return
      end if
      call self%normal%assemble(a, k, identity)
      ! What is not finite in a row of A is not finite on the diagonal.
      finite = .true.
      do l = 1, self%c
         finite = finite .and. ieee_is_finite(self%normal%s(l))
      end do
      if (.not. finite) then
         info = 1
         return
      end if
      if (self%banded) then
         call self%band%factorize(self%normal%s, self%normal%row, self%normal%column, cut)
         self%rank = self%band%rank
         return
      else if (self%sparse) then
         call self%fill%factorize(self%normal%s, self%normal%column, cut)
         self%rank = self%fill%rank
         return
      end if
      c = self%c
      self%s(:, :) = 0.0_wp
      do i = 1, c
         self%s(self%normal%order(i), self%normal%order(i)) = self%normal%s(i)
      end do
      do l = 1, size(self%normal%row)
         i = self%normal%order(self%normal%row(l))
         j = self%normal%order(self%normal%column(l))
         self%s(i, j) = self%normal%s(c + l)
         self%s(j, i) = self%normal%s(c + l)
      end do
      call self%s_plus%compute(self%s, info, noise)
      self%rank = self%s_plus%rank

   contains

      subroutine factor_chain(a_kinv)
         real(wp), intent(in), contiguous :: a_kinv(:)

         call factorize_chained(self%c, self%missing, self%n, a%values, a_kinv, cut, self%normal%s, self%band%l, &
                                self%band%reciprocal, self%rank, info)
         self%band%rank = self%rank
      end subroutine factor_chain

   end subroutine update_structured

   !> The pseudo-inverse of A L^-T, without squaring the condition number.
   subroutine update_factor(self, a, k, identity, info, noise)
      type(weighted_projection_t), intent(inout) :: self
      type(sparse_rows_t), intent(in) :: a
      type(block_diagonal_t), intent(in) :: k
      logical, intent(in) :: identity
      integer, intent(out) :: info
      real(wp), intent(in) :: noise
      integer :: i, j, l

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

   !> d := d - K^-1 A^T lambda with lambda = S^+ r, r = A d - b: what Eqs (11) do with velocities and accelerations.
   subroutine project(self, a, b, d, r, lambda)
      !> The operator, updated.
      class(weighted_projection_t), intent(inout) :: self
      !> The constraint matrix of the update.
      type(sparse_rows_t), intent(in) :: a
      !> What A d shall be: (c).
      real(wp), intent(in) :: b(self%c)
      !> What is projected: (n).
      real(wp), intent(inout) :: d(self%n)
      !> The violation: (c).
      real(wp), intent(inout) :: r(self%c)
      !> The multipliers, see `multipliers`: (c).
      real(wp), intent(inout) :: lambda(self%c)

      if (self%c == 0) return
      if (self%single) then
         if (self%identity) then
            call project_single(self%n, a%values, a%values, self%reciprocal, b, d, r, lambda)
         else
            call project_single(self%n, a%values, self%kinv_at, self%reciprocal, b, d, r, lambda)
         end if
         return
      end if
      if (self%chained) then
         if (self%identity) then
            call project_chained(self%c, self%missing, self%n, a%values, a%values, self%band%l, self%band%reciprocal, &
                                 b, d, r, lambda)
         else
            call project_chained(self%c, self%missing, self%n, a%values, self%normal%a_kinv%values, self%band%l, &
                                 self%band%reciprocal, b, d, r, lambda)
         end if
         return
      end if
      call a%multiply(d, r, b)
      call self%multipliers(r, lambda)
      call self%correction(a, lambda, d)
   end subroutine project

   !> The same with one constraint.
   pure subroutine project_single(n, a, kinv_at, reciprocal, b, d, r, lambda)
      integer, intent(in) :: n
      real(wp), intent(in) :: a(n), kinv_at(n), reciprocal, b(1)
      real(wp), intent(inout) :: d(n), r(1), lambda(1)
      real(wp) :: t
      integer :: l

      t = -b(1)
      !GCC$ unroll 1
      !GCC$ novector
      do l = 1, n
         t = t + a(l)*d(l)
      end do
      r(1) = t
      t = reciprocal*t
      lambda(1) = t
      !GCC$ unroll 1
      !GCC$ novector
      do l = 1, n
         d(l) = d(l) - kinv_at(l)*t
      end do
   end subroutine project_single

   !> Multipliers S^+ r, Eqs (7) and (14); by `banded` and `sparse`, those of redundant rows are zero instead of all being of
   !! minimum norm, with the same reactions A^T lambda: see `minimum_norm`.
   subroutine multipliers(self, r, lambda)
      !> The operator, updated.
      class(weighted_projection_t), intent(inout) :: self
      !> Violation at the level concerned: (c).
      real(wp), intent(in) :: r(self%c)
      !> The multipliers: (c).
      real(wp), intent(out) :: lambda(self%c)
      integer :: i, j

      if (self%c == 0) return
      if (self%single) then
         lambda(1) = self%reciprocal*r(1)
      else if (self%banded .or. self%sparse) then
         if (self%normal%natural) then
            do i = 1, self%c
               lambda(i) = r(i)
            end do
            call solve_ordered(self, lambda)
         else
            do i = 1, self%c
               self%z(i) = r(self%normal%order(i))
            end do
            call solve_ordered(self, self%z)
            do i = 1, self%c
               lambda(self%normal%order(i)) = self%z(i)
            end do
         end if
      else if (self%solver == solver_factor) then
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

   !> x := S^-1 x in the ordering of S.
   pure subroutine solve_ordered(self, x)
      type(weighted_projection_t), intent(in) :: self
      real(wp), intent(inout), contiguous :: x(:)

      if (self%banded) then
         call self%band%solve(x)
      else
         call self%fill%solve(x)
      end if
   end subroutine solve_ordered

   !> Makes multipliers those of minimum norm, S^+ r: takes off them what makes no reaction. For reports: it may allocate.
   subroutine minimum_norm(self, lambda)
      !> The operator, updated.
      class(weighted_projection_t), intent(inout) :: self
      !> Multipliers, replaced: (c).
      real(wp), intent(inout), contiguous :: lambda(:)
      real(wp), allocatable :: null(:, :), x(:)
      integer :: i, j, l

      if (.not. (self%banded .or. self%sparse) .or. self%rank == self%c) return
      ! Null vectors of S: one for each row that was left out, made up for by the others.
      allocate (null(self%c, self%c - self%rank), x(self%c), source=0.0_wp)
      j = 0
      do i = 1, self%c
         if (self%banded) then
            if (self%band%reciprocal(i) > 0.0_wp) cycle
         else
            if (self%fill%reciprocal(i) > 0.0_wp) cycle
         end if
         j = j + 1
         x(:) = 0.0_wp
         do l = 1, size(self%normal%row)
            if (self%normal%column(l) == i) x(self%normal%row(l)) = -self%normal%s(self%c + l)
            if (self%normal%row(l) == i) x(self%normal%column(l)) = -self%normal%s(self%c + l)
         end do
         call solve_ordered(self, x)
         x(i) = 1.0_wp
         do l = 1, self%c
            null(self%normal%order(l), j) = x(l)
         end do
      end do
      call orthonormalize(null, j)
      call remove_components(null, j, lambda)
   end subroutine minimum_norm

   !> d := d - K^-1 A^T lambda: takes off what is normal to the constraints in the metric K.
   pure subroutine correction(self, a, lambda, d)
      !> The operator, updated.
      class(weighted_projection_t), intent(in) :: self
      !> The constraint matrix of the update.
      type(sparse_rows_t), intent(in) :: a
      !> Multipliers: (c).
      real(wp), intent(in) :: lambda(self%c)
      !> What is corrected: (n).
      real(wp), intent(inout) :: d(self%n)
      integer :: i, j

      if (self%structured) then
         if (self%identity .and. self%normal%diagonal) then
            call a%subtract_transposed(lambda, d)
         else
            call self%normal%a_kinv%subtract_transposed(lambda, d)
         end if
         return
      end if
      if (self%single .and. self%identity) then
         !GCC$ unroll 1
         !GCC$ novector
         do i = 1, self%n
            d(i) = d(i) - a%values(i)*lambda(1)
         end do
         return
      end if
      do j = 1, self%c
         do i = 1, self%n
            d(i) = d(i) - self%kinv_at(i, j)*lambda(j)
         end do
      end do
   end subroutine correction

end module taut_linalg_weighted_projection
