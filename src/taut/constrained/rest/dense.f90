!> Equilibrium with full matrices: an orthonormal basis of the motions that the constraints leave, all singular values of K in it.
module taut_constrained_rest_dense
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_kinds, only: wp
   use taut_constrained_resistance, only: solve_doubtful, solve_regular, stiffness_t
   use taut_constrained_rest, only: rest_failed, rest_loaded, rest_not_finite, rest_ok, rest_solver_t
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_linalg_null_space, only: null_space
   implicit none (type, external)
   private
   public :: dense_rest_t

   !> Full matrices.
   type, extends(rest_solver_t) :: dense_rest_t
      !> A, the motions that it leaves along the free velocities, and A^+.
      real(wp), allocatable, private :: a(:, :), z(:, :), a_plus(:, :)
   contains
      procedure :: init
      procedure :: look
      procedure :: reactions
      procedure :: sizes_of_reactions
      procedure :: balanced
      procedure :: meet
      procedure :: step
   end type dense_rest_t

contains

   !> Lays everything out.
   subroutine init(self, model, free)
      !> The solver.
      class(dense_rest_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Velocities that are not blocked.
      integer, intent(in) :: free(:)

      self%free = free
      allocate (self%is_free(model%n), source=.false.)
      self%is_free(free) = .true.
      call self%tangent%init(model)
      allocate (self%a(model%c, model%n), source=0.0_wp)
   end subroutine init

   !> A at a state, and its rank.
   subroutine look(self, model, at, info)
      !> The solver, laid out.
      class(dense_rest_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Its state, at rest.
      type(state_t), intent(in) :: at
      !> `rest_ok`, `rest_not_finite` or `rest_failed`.
      integer, intent(out) :: info

      call model%jacobian(at, self%a)
      info = rest_not_finite
      if (.not. all(ieee_is_finite(self%a))) return
      call null_space(self%a(:, self%free), self%z, self%a_plus, self%rank, info)
      info = merge(rest_ok, rest_failed, info == 0)
   end subroutine look

   !> Multipliers of minimum norm that leave least of the forces, and what they leave.
   subroutine reactions(self, f, lambda, left)
      !> The solver, which has looked at the state.
      class(dense_rest_t), intent(inout) :: self
      !> Forces: (n).
      real(wp), intent(in), contiguous :: f(:)
      !> Multipliers: (c).
      real(wp), intent(out), contiguous :: lambda(:)
      !> f - A^T lambda: (n).
      real(wp), intent(out), contiguous :: left(:)

      lambda = matmul(f(self%free), self%a_plus)
      left = f - matmul(lambda, self%a)
   end subroutine reactions

   !> The sizes of the terms of A^T lambda, added up.
   subroutine sizes_of_reactions(self, lambda, sizes)
      !> The solver, which has looked at the state.
      class(dense_rest_t), intent(in) :: self
      !> Multipliers: (c).
      real(wp), intent(in) :: lambda(:)
      !> |A^T| |lambda|: (n).
      real(wp), intent(out) :: sizes(:)

      sizes = matmul(abs(lambda), abs(self%a))
   end subroutine sizes_of_reactions

   !> Whether forces along the motions that the constraints leave are no more than what they are worth.
   function balanced(self, left, uncertain)
      !> The solver, which has looked at the state.
      class(dense_rest_t), intent(in) :: self
      !> The forces: (n).
      real(wp), intent(in) :: left(:)
      !> What they are worth: (n).
      real(wp), intent(in) :: uncertain(:)
      !> The answer.
      logical :: balanced

      balanced = all(abs(matmul(left(self%free), self%z)) <= matmul(uncertain(self%free), abs(self%z)))
   end function balanced

   !> d = -A^+ phi, and what it leaves of phi.
   subroutine meet(self, phi, d, left)
      !> The solver, which has looked at the state.
      class(dense_rest_t), intent(inout) :: self
      !> Violation: (c).
      real(wp), intent(in), contiguous :: phi(:)
      !> Displacement: (n).
      real(wp), intent(out), contiguous :: d(:)
      !> A d + phi: (c).
      real(wp), intent(out), contiguous :: left(:)

      d = 0.0_wp
      d(self%free) = -matmul(self%a_plus, phi)
      left = matmul(self%a, d) + phi
   end subroutine meet

   !> Newton's step: K d = f along the motions that the constraints leave.
   subroutine step(self, model, at, lambda, difference, f, uncertain, d, info)
      !> The solver, which has looked at the state.
      class(dense_rest_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Its state, at rest.
      type(state_t), intent(in) :: at
      !> Multipliers: (c).
      real(wp), intent(in) :: lambda(:)
      !> Relative step of the differences; 0 for the default.
      real(wp), intent(in) :: difference
      !> Forces that are left: (n).
      real(wp), intent(in) :: f(:)
      !> How much of each is not to be relied on: (n).
      real(wp), intent(in) :: uncertain(:)
      !> The displacement that meets the constraints, to which the step is added: (n).
      real(wp), intent(inout) :: d(:)
      !> One of the constants.
      integer, intent(out) :: info
      type(stiffness_t) :: stiffness
      real(wp), allocatable :: errors(:, :, :), k(:, :), loaded(:), y(:)
      integer :: i
      logical :: solved

      self%free_motions = 0
      call self%tangent%find(model, at, lambda, difference)
      info = rest_not_finite
      if (.not. all(ieee_is_finite(self%tangent%k%values))) return
      info = rest_ok
      k = self%tangent%full(self%tangent%k%values, self%free)
      y = matmul(transpose(self%z), f(self%free) - matmul(k, d(self%free)))
      call stiffness%project(self%z, k)
      call solve_regular(stiffness, y, solved)
      if (.not. solved) then
         call self%tangent%find_errors(model, at, lambda, difference)
         allocate (errors(size(k, 1), size(k, 2), size(self%tangent%errors, 2)))
         do i = 1, size(errors, 3)
            errors(:, :, i) = self%tangent%full(self%tangent%errors(:, i), self%free)
         end do
         call stiffness%project_errors(self%z, errors)
         call solve_doubtful(stiffness, matmul(abs(transpose(self%z)), uncertain(self%free)), y, self%free_motions, loaded, info)
         info = merge(rest_ok, rest_failed, info == 0)
         if (allocated(loaded)) then
            info = rest_loaded
            self%loaded = self%free(maxloc(abs(matmul(self%z, loaded)), 1))
         end if
         if (info /= rest_ok) return
      end if
      d(self%free) = d(self%free) + matmul(self%z, y)
   end subroutine step

end module taut_constrained_rest_dense
