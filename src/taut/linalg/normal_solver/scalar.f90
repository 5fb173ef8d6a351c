!> One constraint: S is a number.
module taut_linalg_normal_solver_scalar
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_kinds, only: wp
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_csr, only: csr_t
   use taut_linalg_normal_solver, only: normal_solver_t
   implicit none (type, external)
   private
   public :: scalar_solver_t

   !> A single row with all its entries.
   type, extends(normal_solver_t) :: scalar_solver_t
      !> 1/S, or 0 for a row of zeros.
      real(wp), private :: reciprocal = 0.0_wp
      !> What S must exceed: nothing does if the row is not kept.
      real(wp), private :: least = tiny(1.0_wp)
      !> K^-1 A^T: (n); not set if K = I.
      real(wp), allocatable, private :: kinv_at(:)
   contains
      procedure :: init
      procedure :: keep
      procedure :: factorize
      procedure :: multipliers
      procedure :: correction
      procedure :: weakest
      procedure :: project
   end type scalar_solver_t

contains

   !> Allocates the workspace.
   subroutine init(self, a, c, sizes)
      !> The solver.
      class(scalar_solver_t), intent(inout) :: self
      !> A matrix like A, all its entries stored.
      type(csr_t), intent(in) :: a
      !> One row is used.
      integer, intent(in) :: c
      !> Sizes of the blocks of K.
      integer, intent(in) :: sizes(:)

      call self%set_sizes(c, a%n)
      allocate (self%kinv_at(a%n), source=0.0_wp)
      associate (unused_sizes => sizes)
      end associate
   end subroutine init

   !> Whether the row is kept.
   subroutine keep(self, kept)
      !> The solver, after `init`.
      class(scalar_solver_t), intent(inout) :: self
      !> The answer: (1).
      logical, intent(in) :: kept(:)

      call self%set_kept(kept)
      self%least = merge(tiny(1.0_wp), huge(1.0_wp), kept(1))
   end subroutine keep

   !> Takes a new A, and K factorized.
   subroutine factorize(self, a, k, identity, info)
      !> The solver.
      class(scalar_solver_t), intent(inout) :: self
      !> The constraint matrix.
      type(csr_t), intent(in) :: a
      !> The metric, factorized; not used if it is the identity.
      type(block_diagonal_t), intent(in) :: k
      !> Whether K = I.
      logical, intent(in) :: identity
      !> 0, or 1 if there are entries that are not finite.
      integer, intent(out) :: info

      self%identity = identity
      if (identity) then
         call invert(self%n, a%values, a%values, self%least, self%reciprocal, self%rank, info)
      else
         call k%solve_vector(a%values, self%kinv_at)
         call invert(self%n, a%values, self%kinv_at, self%least, self%reciprocal, self%rank, info)
      end if
   end subroutine factorize

   !> 1/S.
   pure subroutine invert(n, a, kinv_at, least, reciprocal, rank, info)
      integer, intent(in) :: n
      real(wp), intent(in) :: a(n), kinv_at(n), least
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
      else if (s > least) then
         rank = 1
         reciprocal = 1.0_wp/s
      end if
   end subroutine invert

   !> lambda = r/S.
   subroutine multipliers(self, r, lambda)
      !> The solver, after `factorize`.
      class(scalar_solver_t), intent(inout) :: self
      !> Violation at the level concerned: (1).
      real(wp), intent(in) :: r(self%c)
      !> The multiplier: (1).
      real(wp), intent(out) :: lambda(self%c)

      lambda(1) = self%reciprocal*r(1)
   end subroutine multipliers

   !> d := d - K^-1 A^T lambda.
   pure subroutine correction(self, a, lambda, d)
      !> The solver, after `factorize`.
      class(scalar_solver_t), intent(in) :: self
      !> The constraint matrix of `factorize`.
      type(csr_t), intent(in) :: a
      !> The multiplier: (1).
      real(wp), intent(in) :: lambda(self%c)
      !> What is corrected: (n).
      real(wp), intent(inout) :: d(self%n)

      if (self%identity) then
         call subtract(self%n, a%values, lambda(1), d)
      else
         call subtract(self%n, self%kinv_at, lambda(1), d)
      end if
   end subroutine correction

   !> d := d - lambda a
   pure subroutine subtract(n, a, lambda, d)
      integer, intent(in) :: n
      real(wp), intent(in) :: a(n), lambda
      real(wp), intent(inout) :: d(n)
      integer :: l

      !GCC$ unroll 1
      !GCC$ novector
      do l = 1, n
         d(l) = d(l) - a(l)*lambda
      end do
   end subroutine subtract

   !> 1, or 0 for a row of zeros.
   pure function weakest(self) result(pivot)
      !> The solver, after `factorize`.
      class(scalar_solver_t), intent(in) :: self
      !> S relative to itself.
      real(wp) :: pivot

      pivot = real(self%rank, wp)
   end function weakest

   !> d := d - K^-1 A^T lambda with lambda = r/S, r = A d - b.
   subroutine project(self, a, b, d, r, lambda)
      !> The solver, after `factorize`.
      class(scalar_solver_t), intent(inout) :: self
      !> The constraint matrix of `factorize`.
      type(csr_t), intent(in) :: a
      !> What A d shall be: (1).
      real(wp), intent(in) :: b(self%c)
      !> What is projected: (n).
      real(wp), intent(inout) :: d(self%n)
      !> The violation: (1).
      real(wp), intent(inout) :: r(self%c)
      !> The multiplier: (1).
      real(wp), intent(inout) :: lambda(self%c)

      if (self%identity) then
         call project_on_row(self%n, a%values, a%values, self%reciprocal, b, d, r, lambda)
      else
         call project_on_row(self%n, a%values, self%kinv_at, self%reciprocal, b, d, r, lambda)
      end if
   end subroutine project

   !> The same with its arrays.
   pure subroutine project_on_row(n, a, kinv_at, reciprocal, b, d, r, lambda)
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
      call subtract(n, kinv_at, t, d)
   end subroutine project_on_row

end module taut_linalg_normal_solver_scalar
