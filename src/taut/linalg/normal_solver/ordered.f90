!> What solvers have in common that factorize S = L D L^T entry by entry, in an ordering of its rows that suits them.
!!
!! Multipliers of rows that are not kept are zero instead of all being of minimum norm, with the same reactions.
module taut_linalg_normal_solver_ordered
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_kinds, only: wp
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_csr, only: csr_t
   use taut_linalg_normal_matrix, only: normal_matrix_t
   use taut_linalg_normal_solver, only: normal_solver_t
   implicit none (type, external)
   private
   public :: ordered_solver_t

   !> A solver with S in an ordering.
   type, abstract, extends(normal_solver_t) :: ordered_solver_t
      !> S and A K^-1.
      type(normal_matrix_t) :: normal
      !> Pivots up to this part of their diagonal entry of S are passed over, those of rows that are not kept whatever their size:
      !! (c), by places of the ordering.
      real(wp), allocatable :: least(:)
      real(wp), allocatable, private :: z(:)
   contains
      procedure :: lay_out
      procedure(factorize_ordered), deferred :: factorize_ordered
      procedure(solve), deferred :: solve
      procedure :: factorize
      procedure :: pass_over
      procedure :: set_least
      procedure, nopass :: weakest_of
      procedure :: multipliers
      procedure :: minimum_norm
      procedure :: correction
   end type ordered_solver_t

   !> An entry of S between a row that is kept, by its place, and one that is not, by its number among those.
   type :: coupling_t
      integer :: kept, other
      real(wp) :: s
   end type coupling_t

   abstract interface

      !> Factorizes S as it is in `normal`, finite, with the pivots that `least` lets pass.
      pure subroutine factorize_ordered(self)
         import :: ordered_solver_t
         implicit none (type, external)
         !> The solver.
         class(ordered_solver_t), intent(inout) :: self
      end subroutine factorize_ordered

      !> x := S^-1 x in the ordering; zero where a row is left out.
      pure subroutine solve(self, x)
         import :: ordered_solver_t, wp
         implicit none (type, external)
         !> The solver, after `factorize`.
         class(ordered_solver_t), intent(in) :: self
         !> Right-hand side, replaced by the solution: (c).
         real(wp), intent(inout), contiguous :: x(:)
      end subroutine solve

   end interface

contains

   !> Lays out S in the given order and finds which rows share coordinates.
   subroutine lay_out(self, a, c, sizes, pattern, first, neighbor)
      !> The solver.
      class(ordered_solver_t), intent(inout) :: self
      !> A matrix with the pattern of A.
      type(csr_t), intent(in) :: a
      !> How many of its rows are used.
      integer, intent(in) :: c
      !> Sizes of the blocks of K.
      integer, intent(in) :: sizes(:)
      !> The pattern of A; where all entries are stored, that which says so.
      type(csr_t), intent(out) :: pattern
      !> First neighbor of each row, as of `graph` of `normal_matrix_t`.
      integer, allocatable, intent(out) :: first(:)
      !> The neighbors.
      integer, allocatable, intent(out) :: neighbor(:)
      integer :: i, j

      call self%set_sizes(c, a%n)
      if (a%full) then
         call pattern%set_pattern(a%n, [(i*a%n + 1, i=0, c)], [((j, j=1, a%n), i=1, c)])
      else
         pattern = a
      end if
      call self%normal%init(pattern, c, sizes)
      call self%normal%graph(first, neighbor)
      allocate (self%z(c), self%least(c), source=0.0_wp)
   end subroutine lay_out

   !> Takes a new A, and K factorized.
   subroutine factorize(self, a, k, identity, info)
      !> The solver.
      class(ordered_solver_t), intent(inout) :: self
      !> The constraint matrix.
      type(csr_t), intent(in) :: a
      !> The metric, factorized; not used if it is the identity.
      type(block_diagonal_t), intent(in) :: k
      !> Whether K = I.
      logical, intent(in) :: identity
      !> 0, or 1 if there are entries that are not finite.
      integer, intent(out) :: info
      integer :: i
      logical :: finite

      self%identity = identity
      call self%normal%assemble(a, k, identity)
      ! What is not finite in a row of A is not finite on the diagonal.
      finite = .true.
      do i = 1, self%c
         finite = finite .and. ieee_is_finite(self%normal%s(i))
      end do
      info = 1
      if (.not. finite) return
      info = 0
      if (self%is_new) call self%set_least()
      call self%factorize_ordered()
      if (.not. self%is_new) return
      call self%judge(self%weakest())
      call self%set_least()
   end subroutine factorize

   !> As of every solver.
   subroutine pass_over(self, cut)
      !> The solver.
      class(ordered_solver_t), intent(inout) :: self
      !> Up to this.
      real(wp), intent(in) :: cut

      self%cut = cut
      call self%set_least()
   end subroutine pass_over

   !> Which pivots are passed over.
   pure subroutine set_least(self)
      !> The solver, after `reorder` of S.
      class(ordered_solver_t), intent(inout) :: self
      !> No pivot is larger than its diagonal entry.
      real(wp), parameter :: all_of_them = 2.0_wp
      integer :: i

      do i = 1, self%c
         self%least(i) = merge(self%cut, all_of_them, self%kept(self%normal%order(i)))
      end do
   end subroutine set_least

   !> The smallest pivot of the kept rows relative to its diagonal entry.
   pure function weakest_of(c, least, reciprocal, s) result(pivot)
      !> Number of rows.
      integer, intent(in) :: c
      !> As of `set_least`, by places: (c).
      real(wp), intent(in) :: least(c)
      !> Reciprocals of the pivots, 0 if they were passed over, by places: (c).
      real(wp), intent(in) :: reciprocal(c)
      !> Diagonal of S, by places: (c).
      real(wp), intent(in) :: s(c)
      !> 0 if a kept row was passed over.
      real(wp) :: pivot
      real(wp) :: largest, one, smallest
      integer :: i

      largest = 1.0_wp
      smallest = 1.0_wp
      do i = 1, c
         ! Rows that are not kept are taken for the best ones.
         one = merge(1.0_wp, reciprocal(i)*s(i), least(i) > 1.0_wp)
         largest = max(largest, one)
         smallest = min(smallest, one)
      end do
      pivot = 0.0_wp
      if (smallest > 0.0_wp) pivot = 1.0_wp/largest
   end function weakest_of

   !> Multipliers S^+ r, those of rows that are not kept zero.
   subroutine multipliers(self, r, lambda)
      !> The solver, after `factorize`.
      class(ordered_solver_t), intent(inout) :: self
      !> Violation at the level concerned: (c).
      real(wp), intent(in) :: r(self%c)
      !> The multipliers: (c).
      real(wp), intent(out) :: lambda(self%c)
      integer :: i

      if (self%normal%natural) then
         do i = 1, self%c
            lambda(i) = r(i)
         end do
         call self%solve(lambda)
      else
         do i = 1, self%c
            self%z(i) = r(self%normal%order(i))
         end do
         call self%solve(self%z)
         do i = 1, self%c
            lambda(self%normal%order(i)) = self%z(i)
         end do
      end if
   end subroutine multipliers

   !> Takes off multipliers what makes no reaction: lambda - N (N^T N)^-1 N^T lambda, where the columns of N are the null vectors of
   !! A^T, one for each row that is not kept, made up for by the others: N = (-S_KK^-1 S_KL; I).
   !!
   !! N is not formed: N^T N = I + S_LK S_KK^-1 S_KK^-1 S_KL is at least I, and its entries are of size one, so that conjugate
   !! gradients are at the end after as many passes as null vectors hang together.
   subroutine minimum_norm(self, lambda)
      !> The solver, after `factorize`.
      class(ordered_solver_t), intent(inout) :: self
      !> Multipliers, replaced: (c).
      real(wp), intent(inout), contiguous :: lambda(:)
      !> What is left of a component counts as none up to this part of the multipliers.
      real(wp), parameter :: enough = 16.0_wp*epsilon(1.0_wp)
      !> In the places of all rows, those that are not kept zero, and of these alone.
      real(wp) :: x(self%c)
      real(wp), dimension(self%c - self%rank) :: along, left, result, step
      type(coupling_t), allocatable :: couplings(:)
      integer :: others(self%c - self%rank)
      real(wp) :: far, left_before, length, size_of
      integer :: i, pass

      if (self%rank == self%c) return
      size_of = norm2(lambda)
      if (.not. size_of > 0.0_wp) return
      call find_couplings(self, others, couplings)
      do i = 1, self%c
         x(i) = lambda(self%normal%order(i))
      end do
      left(:) = x(others)
      call self%solve(x)
      call take_from_kept(-1.0_wp, left)
      step(:) = left
      along(:) = 0.0_wp
      length = dot_product(left, left)
      do pass = 1, size(left) + 10
         if (sqrt(length) <= enough*size_of) exit
         call give_to_kept(step)
         call self%solve(x)
         result(:) = step
         call take_from_kept(1.0_wp, result)
         far = length/dot_product(step, result)
         along(:) = along + far*step
         left(:) = left - far*result
         left_before = length
         length = dot_product(left, left)
         step(:) = left + (length/left_before)*step
      end do
      call give_to_kept(along)
      x(others) = -along
      do i = 1, self%c
         lambda(self%normal%order(i)) = lambda(self%normal%order(i)) + x(i)
      end do

   contains

      !> x = S_KK^-1 S_KL z.
      subroutine give_to_kept(z)
         real(wp), intent(in) :: z(:)
         integer :: l

         x(:) = 0.0_wp
         do l = 1, size(couplings)
            x(couplings(l)%kept) = x(couplings(l)%kept) + couplings(l)%s*z(couplings(l)%other)
         end do
         call self%solve(x)
      end subroutine give_to_kept

      !> z := z + S_LK x, or less it.
      subroutine take_from_kept(sign, z)
         real(wp), intent(in) :: sign
         real(wp), intent(inout) :: z(:)
         integer :: l

         do l = 1, size(couplings)
            z(couplings(l)%other) = z(couplings(l)%other) + (sign*couplings(l)%s)*x(couplings(l)%kept)
         end do
      end subroutine take_from_kept

   end subroutine minimum_norm

   !> What S has of rows that are kept and of others: S_KL.
   subroutine find_couplings(self, others, couplings)
      class(ordered_solver_t), intent(in) :: self
      !> Places of the rows that are not kept.
      integer, intent(out) :: others(:)
      type(coupling_t), allocatable, intent(out) :: couplings(:)
      !> At each place the number of a row that is not kept, or 0.
      integer :: number(self%c)
      integer :: i, l, m

      number(:) = 0
      m = 0
      do i = 1, self%c
         if (self%kept(self%normal%order(i))) cycle
         m = m + 1
         others(m) = i
         number(i) = m
      end do
      allocate (couplings(count((number(self%normal%row) > 0) .neqv. (number(self%normal%column) > 0))))
      m = 0
      do l = 1, size(self%normal%row)
         associate (i => self%normal%row(l), j => self%normal%column(l), s => self%normal%s(self%c + l))
            if ((number(i) > 0) .eqv. (number(j) > 0)) cycle
            m = m + 1
            couplings(m) = merge(coupling_t(j, number(i), s), coupling_t(i, number(j), s), number(i) > 0)
         end associate
      end do
   end subroutine find_couplings

   !> d := d - K^-1 A^T lambda.
   pure subroutine correction(self, a, lambda, d)
      !> The solver, after `factorize`.
      class(ordered_solver_t), intent(in) :: self
      !> The constraint matrix of `factorize`.
      type(csr_t), intent(in) :: a
      !> Multipliers: (c).
      real(wp), intent(in) :: lambda(self%c)
      !> What is corrected: (n).
      real(wp), intent(inout) :: d(self%n)

      if (self%identity .and. self%normal%diagonal) then
         call a%subtract_transposed(lambda, d)
      else
         call self%normal%a_kinv%subtract_transposed(lambda, d)
      end if
   end subroutine correction

end module taut_linalg_normal_solver_ordered
