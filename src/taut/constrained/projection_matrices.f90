!> The projectors of Eqs (12) as full matrices: a diagnostic, not a part of the method.
module taut_constrained_projection_matrices
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise
   use taut_constrained_method_options, only: method_t
   use taut_constrained_projection, only: projector_t
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_constrained_system_tables, only: velocity_name
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_csr, only: csr_t
   use taut_linalg_normal_solver, only: normal_solver_t
   use taut_linalg_normal_solver_choose, only: choose_solver
   implicit none (type, external)
   private
   public :: projection_matrices

contains

   !> P_v = W^-1 A^T S_W^+ A, p_v = W^-1 A^T S_W^+ b', P_a = M^-1 A^T S_M^+ A and p_a = M^-1 A^T S_M^+ b'' at a state, so that
   !! xdot = (I - P_v) v + p_v and vdot = (I - P_a) a + p_a, Eqs (12), (13).
   subroutine projection_matrices(model, method, at, p_v_matrix, p_v, p_a_matrix, p_a, error)
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Weight and solver.
      type(method_t), intent(in) :: method
      !> The state at which it is evaluated.
      type(state_t), intent(in) :: at
      !> P_v: (n, n).
      real(wp), allocatable, intent(out) :: p_v_matrix(:, :)
      !> p_v: (n).
      real(wp), allocatable, intent(out) :: p_v(:)
      !> P_a: (n, n).
      real(wp), allocatable, intent(out) :: p_a_matrix(:, :)
      !> p_a: (n).
      real(wp), allocatable, intent(out) :: p_a(:)
      !> A matrix that is not finite or not positive definite.
      type(error_t), allocatable, intent(inout) :: error
      type(projector_t) :: projector
      type(block_diagonal_t) :: m
      class(normal_solver_t), allocatable :: reduced
      real(wp), allocatable :: b(:)
      integer :: info
      character(:), allocatable :: why
      character(*), parameter :: here = 'projection matrices'

      call model%check_sizes(error)
      call method%check(error)
      if (allocated(error)) return
      call projector%init(model, method)
      call projector%linear%linearize(model, at, info, 0.0_wp)
      if (info /= 0) then
         call projector%explain(model, why)
         call raise(error, here, why, 'see what the model says of this state')
         return
      end if
      call m%init(model%mass_blocks)
      call model%mass(at, m)
      call m%factorize(info)
      if (info /= 0) then
         call raise(error, here, 'the mass matrix is not positive definite at '//trim(velocity_name(model, info)), &
                    'correct the masses')
         return
      end if
      call choose_solver(method%solver, projector%linear%a, model%c, model%mass_blocks, method%rcond, reduced)
      call projector%linear%keeper%hand_over(reduced)
      call reduced%factorize(projector%linear%a, m, .false., info)
      allocate (b(model%c))
      call model%velocity_rhs(at, b)
      call apply(projector%linear%onto, projector%linear%a, b, p_v_matrix, p_v)
      call model%acceleration_rhs(at, b)
      call apply(reduced, projector%linear%a, b, p_a_matrix, p_a)
   end subroutine projection_matrices

   !> K^-1 A^T S^+ applied to the columns of A and to b.
   subroutine apply(onto, a, b, p_matrix, p)
      class(normal_solver_t), intent(inout) :: onto
      type(csr_t), intent(in) :: a
      real(wp), intent(in), contiguous :: b(:)
      real(wp), allocatable, intent(out) :: p_matrix(:, :), p(:)
      real(wp) :: all_entries(a%c, a%n), multipliers(size(b))
      integer :: j

      all_entries = a%dense()
      allocate (p_matrix(a%n, a%n), p(a%n), source=0.0_wp)
      do j = 1, a%n
         call onto%multipliers(all_entries(:, j), multipliers)
         call onto%correction(a, -multipliers, p_matrix(:, j))
      end do
      call onto%multipliers(b, multipliers)
      call onto%correction(a, -multipliers, p)
   end subroutine apply

end module taut_constrained_projection_matrices
