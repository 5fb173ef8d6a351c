!> The constraint matrix A of a system: where its entries are, and what they are at a state.
module taut_constrained_jacobian
   use taut_kinds, only: wp
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_linalg_csr, only: csr_t
   implicit none (type, external)
   private
   public :: lay_out_jacobian, evaluate_jacobian, clear_columns

contains

   !> Lays out the constraint matrix of a system, with all its entries or with those of the system's pattern.
   subroutine lay_out_jacobian(model, a)
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> The matrix.
      type(csr_t), intent(inout) :: a
      integer, allocatable :: first(:), column(:)

      call model%pattern(first, column)
      if (allocated(first)) then
         call a%set_pattern(model%n, first, column)
      else
         call a%init(model%c, model%n)
      end if
   end subroutine lay_out_jacobian

   !> Computes the entries of the constraint matrix at a state.
   subroutine evaluate_jacobian(model, at, a)
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Its state.
      type(state_t), intent(in) :: at
      !> The matrix, laid out.
      type(csr_t), intent(inout) :: a

      if (.not. a%full) then
         call model%jacobian_entries(at, a%values)
      else if (a%c == 1) then
         call evaluate_row(model, at, a%n, a%values)
      else if (a%c > 1) then
         call model%jacobian(at, a%all_entries)
         call a%set_dense(a%all_entries)
      end if
   end subroutine evaluate_jacobian

   !> One row is laid out like its matrix.
   subroutine evaluate_row(model, at, n, a)
      class(mechanical_system_t), intent(in) :: model
      type(state_t), intent(in) :: at
      integer, intent(in) :: n
      real(wp), intent(inout) :: a(1, n)

      call model%jacobian(at, a)
   end subroutine evaluate_row

   !> Sets columns to zero.
   pure subroutine clear_columns(a, chosen)
      !> The matrix.
      type(csr_t), intent(inout) :: a
      !> Which: (n).
      logical, intent(in) :: chosen(:)
      integer :: i

      if (a%full) then
         do i = 1, a%c
            where (chosen) a%values((i - 1)*a%n + 1:i*a%n) = 0.0_wp
         end do
      else
         where (chosen(a%column)) a%values = 0.0_wp
      end if
   end subroutine clear_columns

end module taut_constrained_jacobian
