!> S x = r with S = A K^-1 A^T: the system that the paper solves at every level, and K^-1 A^T S^+ r that is made of its solution.
!!
!! With K = W it corrects positions and velocities, Eqs (17) and (11a); with K = M it gives the reaction forces, Eq. (11b).
!! S is symmetric and positive semi-definite, of the rank of A.
module taut_linalg_normal_solver
   use taut_kinds, only: wp
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_csr, only: csr_t
   implicit none (type, external)
   private
   public :: normal_solver_t

   !> One way to solve S x = r.
   !!
   !! What every solver promises, for any number of rows, none included, and any rank:
   !!
   !! - `init` is told the pattern once; nothing is allocated afterwards, but by `minimum_norm`.
   !! - `factorize` takes A and K, decides on the rank and reports an entry that is not finite. What it leaves depends on these
   !!   alone, not on matrices before them. The decision does not depend on the units of the rows.
   !! - `multipliers` then gives x with K^-1 A^T x = K^-1 A^T S^+ r for r in the range of A: the reactions are unique. x itself
   !!   is so where no row is redundant; `minimum_norm` makes it S^+ r where it is not.
   !! - `correction` and `project` apply the result; A is passed again and must be that of `factorize`.
   type, abstract :: normal_solver_t
      !> Rows of A that are used, constraints.
      integer :: c = 0
      !> Columns of A, velocities.
      integer :: n = 0
      !> Rank of the last A.
      integer :: rank = 0
      !> Whether K = I in the last `factorize`.
      logical :: identity = .false.
   contains
      procedure(init), deferred :: init
      procedure(factorize), deferred :: factorize
      procedure(multipliers), deferred :: multipliers
      procedure(correction), deferred :: correction
      procedure :: project
      procedure :: minimum_norm
   end type normal_solver_t

   abstract interface

      !> Sets up a solver for a pattern.
      subroutine init(self, a, c, sizes, rcond)
         import :: normal_solver_t, csr_t, wp
         implicit none (type, external)
         !> The solver.
         class(normal_solver_t), intent(inout) :: self
         !> A matrix with the pattern of A.
         type(csr_t), intent(in) :: a
         !> How many of its rows are used, from the first one on.
         integer, intent(in) :: c
         !> Sizes of the blocks of K.
         integer, intent(in) :: sizes(:)
         !> Relative size below which what tells the rank counts as zero; 0 for the default of the solver.
         real(wp), intent(in) :: rcond
      end subroutine init

      !> Takes a new A, and K factorized.
      subroutine factorize(self, a, k, identity, info, noise)
         import :: normal_solver_t, csr_t, block_diagonal_t, wp
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
         !> Relative error of the rows of A for want of a state that meets the constraints, see `taut_linalg_rank`.
         real(wp), intent(in) :: noise
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

   end interface

contains

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
   end subroutine project

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
