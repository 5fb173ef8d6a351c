!> K^-1/2, the symmetric root of the inverse of a block-diagonal matrix.
module taut_linalg_inverse_root
   use taut_kinds, only: wp
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_lapack, only: dsygv
   implicit none (type, external)
   private
   public :: inverse_root_t

   !> The root, block by block.
   type :: inverse_root_t
      !> Blocks one after the other, each in column order; where all have size one, the roots.
      real(wp), allocatable, private :: values(:)
      !> First row of each block, and n + 1 at the end.
      integer, allocatable, private :: first(:)
      real(wp), allocatable, private :: vectors(:), unit(:), eigenvalue(:), work(:), x(:)
   contains
      procedure :: init
      procedure :: compute
      procedure :: apply
   end type inverse_root_t

contains

   !> Makes room; nothing is allocated afterwards.
   subroutine init(self, sizes)
      !> The root.
      class(inverse_root_t), intent(out) :: self
      !> Sizes of the blocks.
      integer, intent(in) :: sizes(:)
      integer :: i, s

      s = max(1, maxval(sizes))
      allocate (self%first(size(sizes) + 1))
      self%first(1) = 1
      do i = 1, size(sizes)
         self%first(i + 1) = self%first(i) + sizes(i)
      end do
      allocate (self%values(sum(sizes**2)), self%vectors(s*s), self%unit(s*s), self%eigenvalue(s), self%work(max(1, s*s, 34*s)), &
                self%x(s), source=0.0_wp)
   end subroutine init

   !> Finds the root of a matrix: the eigenvectors of each block, with the roots of the inverse eigenvalues.
   subroutine compute(self, k, info)
      !> The root.
      class(inverse_root_t), intent(inout) :: self
      !> The matrix, symmetric; its `values` are read.
      type(block_diagonal_t), intent(in) :: k
      !> 0, or the first row of a block that is not positive definite.
      integer, intent(out) :: info
      integer :: b, i, j, l, o, s

      o = 0
      do b = 1, size(self%first) - 1
         s = self%first(b + 1) - self%first(b)
         self%vectors(:s*s) = k%values(o + 1:o + s*s)
         self%unit(:s*s) = 0.0_wp
         do i = 1, s
            self%unit((i - 1)*s + i) = 1.0_wp
         end do
         call dsygv(1, 'V', 'L', s, self%vectors, s, self%unit, s, self%eigenvalue, self%work, size(self%work), info)
         if (info == 0 .and. .not. self%eigenvalue(1) > 0.0_wp) info = 1
         if (info /= 0) then
            info = self%first(b)
            return
         end if
         do j = 1, s
            do i = 1, s
               self%values(o + (j - 1)*s + i) = 0.0_wp
               do l = 1, s
                  self%values(o + (j - 1)*s + i) = self%values(o + (j - 1)*s + i) + self%vectors((l - 1)*s + i)* &
                                                   self%vectors((l - 1)*s + j)/sqrt(self%eigenvalue(l))
               end do
            end do
         end do
         o = o + s*s
      end do
      info = 0
   end subroutine compute

   !> x := K^-1/2 x, after `compute`.
   subroutine apply(self, x)
      !> The root.
      class(inverse_root_t), intent(inout) :: self
      !> A vector: (n).
      real(wp), intent(inout), contiguous :: x(:)
      integer :: b, f, i, j, o, s

      o = 0
      do b = 1, size(self%first) - 1
         f = self%first(b) - 1
         s = self%first(b + 1) - self%first(b)
         self%x(:s) = 0.0_wp
         do j = 1, s
            do i = 1, s
               self%x(i) = self%x(i) + self%values(o + (j - 1)*s + i)*x(f + j)
            end do
         end do
         x(f + 1:f + s) = self%x(:s)
         o = o + s*s
      end do
   end subroutine apply

end module taut_linalg_inverse_root
