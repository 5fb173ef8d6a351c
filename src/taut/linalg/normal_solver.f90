!> S x = r with S = A K^-1 A^T: the system that the paper solves at every level, and K^-1 A^T S^+ r that is made of its solution.
!!
!! With K = W it corrects positions and velocities, Eqs (17) and (11a); with K = M it gives the reaction forces, Eq. (11b).
!! S is symmetric and positive semi-definite, of the rank of A.
module taut_linalg_normal_solver
   use taut_kinds, only: wp
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_csr, only: csr_t
   use taut_linalg_rank, only: ill_conditioned, least_of_independent, passed_pivot, refinements, weaker
   implicit none (type, external)
   private
   public :: normal_solver_t

   !> The revision of rows that are kept for now.
   integer, parameter :: for_now = -1

   !> One way to solve S x = r.
   !!
   !! What every solver promises, for any number of rows, none included, and any rank:
   !!
   !! - `init` is told the pattern once; `keep` is told which rows are independent, which no solver decides, `taut_linalg_rank`.
   !!   Nothing is allocated afterwards, but by `minimum_norm` and another `keep`.
   !! - `factorize` takes A and K and reports an entry that is not finite. It factorizes S of the kept rows; rows of which the
   !!   others leave nothing at this A, at a dead point, are passed over for the moment. What it leaves depends on A, K and the
   !!   kept rows alone.
   !! - `multipliers` then gives x with K^-1 A^T x = K^-1 A^T S^+ r for r in the range of A: the reactions are unique. x itself
   !!   is so where no row is redundant; `minimum_norm` makes it S^+ r where it is not.
   !! - `correction` and `project` apply the result; A is passed again and must be that of `factorize`. `project` refines
   !!   its result through A where S is ill-conditioned.
   !! - `weakest` is how near the kept rows are to a dead point.
   type, abstract :: normal_solver_t
      !> Rows of A that are used, constraints.
      integer :: c = 0
      !> Columns of A, velocities.
      integer :: n = 0
      !> Rank of A: rows that are kept.
      integer :: rank = 0
      !> Which: (c).
      logical, allocatable :: kept(:)
      !> Which of the selections of a `rank_keeper_t` that is.
      integer :: revision = 0
      !> Whether K = I in the last `factorize`.
      logical :: identity = .false.
      !> How often `project` refines its result.
      integer :: refinements = 0
      !> Whether nothing was factorized with the kept rows so far; a pivot that is zero to them, relative to its diagonal entry.
      logical :: is_new = .true.
      real(wp) :: cut = least_of_independent
      !> Selection and cut from before `keep_for_now`.
      integer :: revision_before = -1
      real(wp) :: cut_before = least_of_independent
      !> Workspace of a refinement: multipliers, violations, (c); displacements, (n).
      real(wp), allocatable, private :: along(:), left(:), more(:), moved(:), of_moved(:)
   contains
      procedure(init), deferred :: init
      procedure, non_overridable :: set_sizes
      procedure, non_overridable :: set_kept
      procedure :: keep
      procedure, non_overridable :: keep_for_now
      procedure, non_overridable :: keep_selected
      procedure :: pass_over
      procedure(factorize), deferred :: factorize
      procedure(multipliers), deferred :: multipliers
      procedure(correction), deferred :: correction
      procedure(weakest), deferred :: weakest
      procedure :: judge
      procedure :: project
      procedure :: minimum_norm
   end type normal_solver_t

   abstract interface

      !> Sets up a solver for a pattern; all rows are kept.
      subroutine init(self, a, c, sizes)
         import :: normal_solver_t, csr_t
         implicit none (type, external)
         !> The solver.
         class(normal_solver_t), intent(inout) :: self
         !> A matrix with the pattern of A.
         type(csr_t), intent(in) :: a
         !> How many of its rows are used, from the first one on.
         integer, intent(in) :: c
         !> Sizes of the blocks of K.
         integer, intent(in) :: sizes(:)
      end subroutine init

      !> Takes a new A, and K factorized.
      subroutine factorize(self, a, k, identity, info)
         import :: normal_solver_t, csr_t, block_diagonal_t
         implicit none (type, external)
         !> The solver.
         class(normal_solver_t), intent(inout) :: self
         !> Constraint matrix, laid out like that given to `init`.
         type(csr_t), intent(in) :: a
         !> The metric, factorized; not used if it is the identity.
         type(block_diagonal_t), intent(in) :: k
         !> Whether K = I.
         logical, intent(in) :: identity
         !> 0, or not 0 if there are entries that are not finite or the singular values were not found.
         integer, intent(out) :: info
      end subroutine factorize

      !> Multipliers of S x = r, Eqs (7) and (14).
      subroutine multipliers(self, r, lambda)
         import :: normal_solver_t, wp
         implicit none (type, external)
         !> The solver, after `factorize`.
         class(normal_solver_t), intent(inout) :: self
         !> Violation at the level concerned: (c).
         real(wp), intent(in) :: r(self%c)
         !> The multipliers: (c).
         real(wp), intent(out) :: lambda(self%c)
      end subroutine multipliers

      !> d := d - K^-1 A^T lambda: takes off what is normal to the constraints in the metric K.
      pure subroutine correction(self, a, lambda, d)
         import :: normal_solver_t, csr_t, wp
         implicit none (type, external)
         !> The solver, after `factorize`.
         class(normal_solver_t), intent(in) :: self
         !> The constraint matrix of `factorize`.
         type(csr_t), intent(in) :: a
         !> Multipliers: (c).
         real(wp), intent(in) :: lambda(self%c)
         !> What is corrected: (n).
         real(wp), intent(inout) :: d(self%n)
      end subroutine correction

      !> The smallest pivot of the kept rows, relative to its diagonal entry of S, or what stands for it.
      pure function weakest(self) result(pivot)
         import :: normal_solver_t, wp
         implicit none (type, external)
         !> The solver, after `factorize`.
         class(normal_solver_t), intent(in) :: self
         !> Between 0 and 1; 0 if a row was passed over, 1 without rows.
         real(wp) :: pivot
      end function weakest

   end interface

contains

   !> Sets the sizes, with all rows kept.
   subroutine set_sizes(self, c, n)
      !> The solver.
      class(normal_solver_t), intent(inout) :: self
      !> Rows of A.
      integer, intent(in) :: c
      !> Columns of A.
      integer, intent(in) :: n

      self%c = c
      self%n = n
      self%rank = c
      allocate (self%kept(c), source=.true.)
      allocate (self%along(c), self%left(c), self%more(c), self%moved(n), self%of_moved(c), source=0.0_wp)
   end subroutine set_sizes

   !> Takes the rows that are independent.
   subroutine keep(self, kept)
      !> The solver, after `init`.
      class(normal_solver_t), intent(inout) :: self
      !> Which they are: (c).
      logical, intent(in) :: kept(:)

      call self%set_kept(kept)
   end subroutine keep

   !> Takes fewer rows than are independent, until `keep_selected` or another `keep`.
   subroutine keep_for_now(self, kept)
      !> The solver.
      class(normal_solver_t), intent(inout) :: self
      !> Which they are: (c).
      logical, intent(in) :: kept(:)

      if (self%revision /= for_now) then
         self%revision_before = self%revision
         self%cut_before = self%cut
      end if
      call self%keep(kept)
      self%revision = for_now
   end subroutine keep_for_now

   !> Takes the rows of a selection; if they are those from before `keep_for_now`, with what was learned of them.
   subroutine keep_selected(self, kept, revision)
      !> The solver, after `init`.
      class(normal_solver_t), intent(inout) :: self
      !> Which they are: (c).
      logical, intent(in) :: kept(:)
      !> Which of the selections of a `rank_keeper_t` that is.
      integer, intent(in) :: revision
      logical :: known

      known = self%revision == for_now .and. self%revision_before == revision
      call self%keep(kept)
      self%revision = revision
      if (.not. known) return
      self%is_new = .false.
      call self%pass_over(self%cut_before)
   end subroutine keep_selected

   !> States which pivots, relative to their diagonal entries of S, are passed over from the next `factorize` on.
   subroutine pass_over(self, cut)
      !> The solver.
      class(normal_solver_t), intent(inout) :: self
      !> Up to this: between 0 and 1.
      real(wp), intent(in) :: cut

      self%cut = cut
   end subroutine pass_over

   !> What `keep` does for every solver.
   subroutine set_kept(self, kept)
      !> The solver.
      class(normal_solver_t), intent(inout) :: self
      !> The independent rows: (c).
      logical, intent(in) :: kept(:)

      self%kept(:) = kept
      self%rank = count(kept)
      self%is_new = .true.
      self%cut = least_of_independent
   end subroutine set_kept

   !> Learns from the smallest pivot of the first factorization with the kept rows what will count as a dead point, and from any
   !! whether solutions have to be refined.
   pure subroutine judge(self, pivot)
      !> The solver, after `factorize`.
      class(normal_solver_t), intent(inout) :: self
      !> What `weakest` says.
      real(wp), intent(in) :: pivot

      if (self%is_new) self%cut = max(least_of_independent, min(passed_pivot, weaker*pivot))
      self%is_new = .false.
      self%refinements = refinements(count(pivot < ill_conditioned))
   end subroutine judge

   !> d := d - K^-1 A^T lambda with lambda = S^+ r, r = A d - b: what Eqs (11) do with velocities and accelerations.
   !!
   !! A solver that can do this in fewer passes overrides it.
   subroutine project(self, a, b, d, r, lambda)
      !> The solver, after `factorize`.
      class(normal_solver_t), intent(inout) :: self
      !> The constraint matrix of `factorize`.
      type(csr_t), intent(in) :: a
      !> What A d shall be: (c).
      real(wp), intent(in) :: b(self%c)
      !> What is projected: (n).
      real(wp), intent(inout) :: d(self%n)
      !> The violation: (c).
      real(wp), intent(inout) :: r(self%c)
      !> The multipliers, see `multipliers`: (c).
      real(wp), intent(inout) :: lambda(self%c)

      call a%multiply(d, r, b)
      call self%multipliers(r, lambda)
      call self%correction(a, lambda, d)
      if (self%refinements > 0) call refine(self, a, b, d, lambda)
   end subroutine project

   !> Further passes: what the last one has left.
   !!
   !! They are steps of conjugate gradients, with S as it is factorized to precondition S as it is: the two differ in the few
   !! directions that round-off has hidden in S, light bodies behind heavy ones, and not in A. Each step finds one of them.
   subroutine refine(self, a, b, d, lambda)
      class(normal_solver_t), intent(inout) :: self
      type(csr_t), intent(in) :: a
      real(wp), intent(in) :: b(self%c)
      real(wp), intent(inout) :: d(self%n), lambda(self%c)
      real(wp) :: far, rest, rest_before
      integer :: i

      self%along(:) = 0.0_wp
      rest_before = huge(1.0_wp)
      do i = 1, self%refinements
         call a%multiply(d, self%left, b)
         call self%multipliers(self%left, self%more)
         ! What is left is measured by what it would move; if that is no less than before, it is round-off.
         rest = dot_product(self%left, self%more)
         if (.not. (rest > 0.0_wp .and. rest < rest_before)) return
         self%along(:) = self%more + rest/rest_before*self%along
         rest_before = rest
         self%moved(:) = 0.0_wp
         call self%correction(a, self%along, self%moved)
         call a%multiply(self%moved, self%of_moved)
         far = -dot_product(self%along, self%of_moved)
         if (.not. far > 0.0_wp) return
         far = rest/far
         d(:) = d + far*self%moved
         lambda(:) = lambda + far*self%along
      end do
   end subroutine refine

   !> Makes multipliers those of minimum norm, S^+ r: takes off them what makes no reaction. For reports: it may allocate.
   !!
   !! Here for solvers whose multipliers are of minimum norm as they are.
   subroutine minimum_norm(self, lambda)
      !> The solver, after `factorize`.
      class(normal_solver_t), intent(inout) :: self
      !> Multipliers, replaced: (c).
      real(wp), intent(inout), contiguous :: lambda(:)

      associate (unused_solver => self, unused_multipliers => lambda)
      end associate
   end subroutine minimum_norm

end module taut_linalg_normal_solver
