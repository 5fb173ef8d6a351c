!> The motions that a constraint matrix leaves free: an orthonormal basis of its null space, and its pseudo-inverse.
module taut_linalg_null_space
   use taut_kinds, only: wp
   use taut_linalg_lapack, only: dgeqp3, dorgqr
   use taut_linalg_pseudo_inverse, only: singular_value_inverse_t
   use taut_linalg_rank, only: rcond_of_root
   implicit none (type, external)
   private
   public :: null_space

contains

   !> Z with A Z = 0 and Z^T Z = I, and A^+.
   subroutine null_space(a, z, a_plus, rank, info)
      !> The constraint matrix: (c, n).
      real(wp), intent(in) :: a(:, :)
      !> The basis: (n, n - rank).
      real(wp), allocatable, intent(out) :: z(:, :)
      !> The pseudo-inverse: (n, c).
      real(wp), allocatable, intent(out) :: a_plus(:, :)
      !> Rank of A.
      integer, intent(out) :: rank
      !> 0, or LAPACK's code.
      integer, intent(out) :: info
      type(singular_value_inverse_t) :: inverse
      real(wp) :: left(size(a, 1)), right(size(a, 2)), row, query(1)
      real(wp), allocatable :: p(:, :), tau(:), work(:)
      integer, allocatable :: pivot(:)
      integer :: c, i, n

      c = size(a, 1)
      n = size(a, 2)
      do i = 1, c
         row = norm2(a(i, :))
         left(i) = 1.0_wp
         if (row > tiny(row)) left(i) = 1.0_wp/row
      end do
      right = 1.0_wp
      call inverse%init(c, n)
      call inverse%compute(a, left, right, rcond_of_root, rcond_of_root, info)
      if (info /= 0) return
      rank = inverse%rank
      allocate (a_plus, source=inverse%inverse)

      ! The projector I - A^+ A has rank n - r; the first n - r columns of its Q span its image.
      allocate (p(n, n), source=-matmul(a_plus, a))
      do i = 1, n
         p(i, i) = p(i, i) + 1.0_wp
      end do
      allocate (tau(n), source=0.0_wp)
      allocate (pivot(n), source=0)
      query = 0.0_wp
      call dgeqp3(n, n, p, n, pivot, tau, query, -1, info)
      allocate (work(max(n*n, int(query(1)))), source=0.0_wp)
      call dgeqp3(n, n, p, n, pivot, tau, work, size(work), info)
      if (info == 0 .and. rank < n) call dorgqr(n, n - rank, n - rank, p, n, tau, work, size(work), info)
      if (info /= 0) return
      allocate (z, source=p(:, 1:n - rank))
   end subroutine null_space

end module taut_linalg_null_space
