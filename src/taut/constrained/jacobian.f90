!> The constraint matrix A of a system: where its entries are, and what they are at a state.
module taut_constrained_jacobian
   use, intrinsic :: iso_fortran_env, only: int64
   use taut_kinds, only: wp
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_linalg_csr, only: csr_t
   implicit none (type, external)
   private
   public :: lay_out_jacobian, evaluate_jacobian, take_out_columns, kept_entries_t

   !> Entries of A that came with the last phi of a system that `linearizes`, and where that was.
   type :: kept_entries_t
      real(wp), allocatable, private :: values(:), x(:)
      real(wp), private :: t = -huge(1.0_wp)
   contains
      procedure, non_overridable :: init
      procedure, non_overridable :: evaluate_constraint
      procedure, non_overridable :: give
   end type kept_entries_t

contains

   !> Allocates the workspace; nothing is allocated afterwards.
   subroutine init(self, model, a)
      !> The entries: none so far.
      class(kept_entries_t), intent(out) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> The matrix, laid out.
      type(csr_t), intent(in) :: a

      allocate (self%values(size(a%values)), self%x(model%n_x), source=0.0_wp)
   end subroutine init

   !> phi, and the entries of A that come with it.
   subroutine evaluate_constraint(self, model, at, phi)
      !> The entries.
      class(kept_entries_t), intent(inout) :: self
      !> The system; it `linearizes`.
      class(mechanical_system_t), intent(in) :: model
      !> Its state; its x and t are used.
      type(state_t), intent(in) :: at
      !> phi: (n_phi).
      real(wp), intent(inout), contiguous :: phi(:)

      call model%linearization(at, phi, self%values)
      self%t = at%t
      self%x(:) = at%x
   end subroutine evaluate_constraint

   !> A at a state: the entries that are kept if they are of this very state, bit for bit.
   subroutine give(self, model, at, a)
      !> The entries.
      class(kept_entries_t), intent(in) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Its state.
      type(state_t), intent(in) :: at
      !> The matrix, laid out.
      type(csr_t), intent(inout) :: a
      integer(int64) :: bits
      integer :: i

      bits = ieor(transfer(at%t, bits), transfer(self%t, bits))
      do i = 1, size(at%x)
         bits = ior(bits, ieor(transfer(at%x(i), bits), transfer(self%x(i), bits)))
      end do
      if (bits == 0_int64) then
         a%values(:) = self%values
      else
         call evaluate_jacobian(model, at, a)
      end if
   end subroutine give

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

   !> Sets columns of A to zero, and tells what they gave of A v.
   subroutine take_out_columns(a, chosen, v, product)
      !> The matrix.
      type(csr_t), intent(inout) :: a
      !> Which: (n).
      logical, intent(in) :: chosen(:)
      !> Velocities: (n).
      real(wp), intent(in) :: v(:)
      !> A v of the chosen ones alone: (c).
      real(wp), intent(inout), contiguous :: product(:)
      integer :: i

      call a%multiply(merge(v, 0.0_wp, chosen), product)
      if (a%full) then
         do i = 1, a%c
            where (chosen) a%values((i - 1)*a%n + 1:i*a%n) = 0.0_wp
         end do
      else
         where (chosen(a%column)) a%values = 0.0_wp
      end if
   end subroutine take_out_columns

end module taut_constrained_jacobian
