!> Which matrices an equilibrium is solved with.
module taut_constrained_rest_choose
   use taut_constrained_coupling, only: coupling_t
   use taut_constrained_rest, only: rest_solver_t
   use taut_constrained_rest_dense, only: dense_rest_t
   use taut_constrained_rest_sparse, only: sparse_rest_t
   use taut_constrained_system, only: mechanical_system_t
   implicit none (type, external)
   private
   public :: choose_rest_solver, is_large

   !> Up to so many velocities full matrices are as fast: measured on beams and chains of springs.
   integer, parameter :: small = 60

contains

   !> Chooses and lays out.
   subroutine choose_rest_solver(model, free, solver)
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Velocities that are not blocked.
      integer, intent(in) :: free(:)
      !> What it is solved with.
      class(rest_solver_t), allocatable, intent(out) :: solver

      if (is_large(model, free)) then
         allocate (sparse_rest_t :: solver)
      else
         allocate (dense_rest_t :: solver)
      end if
      call solver%init(model, free)
   end subroutine choose_rest_solver

   !> Whether a system is so large, and so little coupled, that full matrices are not the way.
   logical function is_large(model, free)
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Velocities that are not blocked.
      integer, intent(in) :: free(:)
      type(coupling_t) :: coupling

      is_large = size(free) > small
      if (.not. is_large) return
      call coupling%init(model)
      is_large = size(coupling%column) < model%n**2/4
   end function is_large

end module taut_constrained_rest_choose
