!> Singular values of S by DGELSD: of S_KK, or of all of S.
module taut_linalg_normal_solver_dgelsd
   use taut_kinds, only: wp
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_csr, only: csr_t
   use taut_linalg_normal_solver_dense, only: basic_solver_t, dense_solver_t
   use taut_linalg_pseudo_inverse, only: by_singular_values, pseudo_inverse_t, singular_value_inverse_t
   use taut_linalg_rank, only: rcond_of_s, unit_diagonal
   implicit none (type, external)
   private
   public :: dgelsd_solver_t, moore_penrose_solver_t

   !> The inverse of S_KK.
   type, extends(basic_solver_t) :: dgelsd_solver_t
      !> Of S_KK scaled to a unit diagonal, (rank, rank), by these factors of rows and columns: (rank).
      type(singular_value_inverse_t), private :: of_basis
      real(wp), allocatable, private :: scaled(:, :), scale(:), ones(:)
   contains
      procedure :: keep => dgelsd_keep
      procedure :: invert
      procedure :: solve
      procedure :: weakest => dgelsd_weakest
   end type dgelsd_solver_t

   !> The Moore-Penrose inverse of S as the paper has it, with a bound below which singular values are zero: the rank is what
   !! they say, whichever rows are kept.
   type, extends(dense_solver_t) :: moore_penrose_solver_t
      !> S^+, with its bound.
      type(pseudo_inverse_t) :: s_plus
   contains
      procedure :: keep => moore_penrose_keep
      procedure :: factorize
      procedure :: multipliers
      procedure :: weakest => moore_penrose_weakest
   end type moore_penrose_solver_t

contains

   !> Takes the rows that are independent.
   subroutine dgelsd_keep(self, kept)
      !> The solver, after `init`.
      class(dgelsd_solver_t), intent(inout) :: self
      !> Which they are: (c).
      logical, intent(in) :: kept(:)

      call self%keep_basis(kept)
      call self%of_basis%init(self%rank, self%rank)
      if (allocated(self%scale)) deallocate (self%scaled, self%scale, self%ones)
      allocate (self%scaled(self%rank, self%rank), self%scale(self%rank), self%ones(self%rank), source=1.0_wp)
   end subroutine dgelsd_keep

   !> Inverts S_KK.
   subroutine invert(self, s, info)
      !> The solver.
      class(dgelsd_solver_t), intent(inout) :: self
      !> S_KK, finite: (rank, rank).
      real(wp), intent(in) :: s(:, :)
      !> 0, or LAPACK's code.
      integer, intent(out) :: info
      integer :: i, j
      real(wp) :: least

      do i = 1, self%rank
         self%scale(i) = unit_diagonal(s(i, i))
      end do
      do j = 1, self%rank
         do i = 1, self%rank
            self%scaled(i, j) = self%scale(i)*s(i, j)*self%scale(j)
         end do
      end do
      ! Singular values are not as exact as pivots: those that are small have the round-off of the large ones.
      least = max(self%cut, rcond_of_s)
      call self%of_basis%compute(self%scaled, self%ones, self%ones, least, least, info)
   end subroutine invert

   !> x = S_KK^-1 r.
   subroutine solve(self, r, x)
      !> The solver, after `invert`.
      class(dgelsd_solver_t), intent(inout) :: self
      !> Right-hand side: (rank).
      real(wp), intent(in), contiguous :: r(:)
      !> Solution: (rank).
      real(wp), intent(out), contiguous :: x(:)
      integer :: i, j

      do i = 1, self%rank
         x(i) = 0.0_wp
      end do
      do j = 1, self%rank
         do i = 1, self%rank
            x(i) = x(i) + self%of_basis%inverse(i, j)*(self%scale(j)*r(j))
         end do
      end do
      do i = 1, self%rank
         x(i) = self%scale(i)*x(i)
      end do
   end subroutine solve

   !> The smallest singular value of the scaled S_KK, relative to the largest.
   pure function dgelsd_weakest(self) result(pivot)
      !> The solver, after `factorize`.
      class(dgelsd_solver_t), intent(in) :: self
      !> 0 if some were taken for zero.
      real(wp) :: pivot

      pivot = 0.0_wp
      if (self%of_basis%rank == self%rank) pivot = 1.0_wp/self%of_basis%condition
   end function dgelsd_weakest

   !> Makes room for S^+.
   subroutine moore_penrose_keep(self, kept)
      !> The solver, after `init`.
      class(moore_penrose_solver_t), intent(inout) :: self
      !> Without effect.
      logical, intent(in) :: kept(:)

      call self%s_plus%init(self%c, by_singular_values)
      associate (unused_rows => kept)
      end associate
   end subroutine moore_penrose_keep

   !> Takes a new A, and K factorized.
   subroutine factorize(self, a, k, identity, info)
      !> The solver.
      class(moore_penrose_solver_t), intent(inout) :: self
      !> The constraint matrix.
      type(csr_t), intent(in) :: a
      !> The metric, factorized; not used if it is the identity.
      type(block_diagonal_t), intent(in) :: k
      !> Whether K = I.
      logical, intent(in) :: identity
      !> 0, or not 0 if there are entries that are not finite or the singular values were not found.
      integer, intent(out) :: info

      call self%form(a, k, identity, info)
      if (info /= 0) return
      call self%s_plus%compute(self%s, info)
      self%rank = self%s_plus%rank
   end subroutine factorize

   !> Multipliers S^+ r, of minimum norm.
   subroutine multipliers(self, r, lambda)
      !> The solver, after `factorize`.
      class(moore_penrose_solver_t), intent(inout) :: self
      !> Violation at the level concerned: (c).
      real(wp), intent(in) :: r(self%c)
      !> The multipliers: (c).
      real(wp), intent(out) :: lambda(self%c)

      call self%s_plus%solve(r, lambda)
   end subroutine multipliers

   !> The smallest singular value that counts, relative to the largest.
   pure function moore_penrose_weakest(self) result(pivot)
      !> The solver, after `factorize`.
      class(moore_penrose_solver_t), intent(in) :: self
      !> Between 0 and 1.
      real(wp) :: pivot

      pivot = 1.0_wp/self%s_plus%condition
   end function moore_penrose_weakest

end module taut_linalg_normal_solver_dgelsd
