!> Symmetric positive definite matrices made of blocks on the diagonal: mass matrices and weights.
!!
!! A diagonal matrix is one whose blocks have size one, a dense matrix is one block; so one type serves all. Entries that do
!! not fit the blocks make all of them NaN, so that `verify` and the integrator see it.
module taut_linalg_block_diagonal
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_quiet_nan, ieee_value
   use taut_kinds, only: wp
   use taut_linalg_lapack, only: dpotrf, dpotrs, dtrtrs
   implicit none (type, external)
   private
   public :: block_diagonal_t

   !> Up to this size of a block, loops are faster than calls of LAPACK.
   integer, parameter :: small = 4

   !> A block-diagonal matrix and its Cholesky factor, block by block: K = L L^T.
   type :: block_diagonal_t
      !> Order of the matrix.
      integer :: n = 0
      !> Whether every block has size one.
      logical :: diagonal = .true.
      !> First row of each block, and n + 1 at the end: (blocks + 1).
      integer, allocatable :: first(:)
      !> Blocks one after the other, each in column order.
      real(wp), allocatable :: values(:)
      !> Row and column of an entry outside the blocks that `set_dense` was given; 0 if there was none.
      integer :: stray(2) = 0
      !> Cholesky factors, laid out like `values`; where all blocks have size one, the reciprocals 1/K_ii.
      real(wp), allocatable, private :: factor(:)
      !> The blocks that the factors are of, where there are blocks larger than one: the same ones are not factorized again.
      real(wp), allocatable, private :: factorized(:)
      logical, private :: is_factorized = .false.
      !> Offset of each block in `values`: (blocks + 1).
      integer, allocatable, private :: offset(:)
   contains
      procedure :: init
      procedure :: set_identity
      procedure :: set_diagonal
      procedure :: set_block
      procedure :: set_dense
      procedure :: decouple
      procedure :: dense
      procedure :: trace
      procedure :: factorize
      procedure :: smallest_pivot
      procedure :: least_certain_pivot
      procedure :: solve
      procedure :: solve_lower
      procedure :: solve_lower_transposed
      procedure :: solve_vector
      procedure :: solve_block
      procedure :: divide
      procedure :: multiply
   end type block_diagonal_t

contains

   !> Lays out the matrix, with all entries zero.
   subroutine init(self, sizes)
      !> The matrix.
      class(block_diagonal_t), intent(out) :: self
      !> Size of each block; their sum is the order of the matrix.
      integer, intent(in) :: sizes(:)
      integer :: i

      self%n = sum(sizes)
      self%diagonal = all(sizes == 1)
      allocate (self%first(size(sizes) + 1), self%offset(size(sizes) + 1))
      self%first(1) = 1
      self%offset(1) = 0
      do i = 1, size(sizes)
         self%first(i + 1) = self%first(i) + sizes(i)
         self%offset(i + 1) = self%offset(i) + sizes(i)**2
      end do
      allocate (self%values(self%offset(size(sizes) + 1)), source=0.0_wp)
      allocate (self%factor(size(self%values)), source=0.0_wp)
      if (.not. self%diagonal) allocate (self%factorized(size(self%values)), source=0.0_wp)
   end subroutine init

   !> Makes the matrix the identity, whatever the sizes of its blocks.
   pure subroutine set_identity(self)
      !> The matrix.
      class(block_diagonal_t), intent(inout) :: self
      integer :: b, i, s

      self%values(:) = 0.0_wp
      do b = 1, size(self%first) - 1
         s = self%first(b + 1) - self%first(b)
         do i = 1, s
            self%values(self%offset(b) + (i - 1)*s + i) = 1.0_wp
         end do
      end do
   end subroutine set_identity

   !> Makes the matrix diagonal, whatever the sizes of its blocks.
   pure subroutine set_diagonal(self, d)
      !> The matrix.
      class(block_diagonal_t), intent(inout) :: self
      !> Its diagonal: (n).
      real(wp), intent(in) :: d(:)
      integer :: b, i, s

      if (size(d) /= self%n) then
         self%values(:) = ieee_value(1.0_wp, ieee_quiet_nan)
         return
      end if
      if (self%diagonal) then
         self%values(:) = d
         return
      end if
      self%values(:) = 0.0_wp
      do b = 1, size(self%first) - 1
         s = self%first(b + 1) - self%first(b)
         do i = 1, s
            self%values(self%offset(b) + (i - 1)*s + i) = d(self%first(b) + i - 1)
         end do
      end do
   end subroutine set_diagonal

   !> Sets one block.
   pure subroutine set_block(self, b, values)
      !> The matrix.
      class(block_diagonal_t), intent(inout) :: self
      !> Index of the block.
      integer, intent(in) :: b
      !> The block: (s, s), s the size of the block; symmetric.
      real(wp), intent(in) :: values(:, :)
      integer :: j, s

      s = self%first(b + 1) - self%first(b)
      do j = 1, s
         self%values(self%offset(b) + (j - 1)*s + 1:self%offset(b) + j*s) = values(1:s, j)
      end do
   end subroutine set_block

   !> Sets the matrix from all its entries; those outside the blocks have to be zero.
   pure subroutine set_dense(self, values)
      !> The matrix.
      class(block_diagonal_t), intent(inout) :: self
      !> All its entries: (n, n); symmetric.
      real(wp), intent(in) :: values(:, :)

      integer :: b, f, i, j, l

      if (size(values, 1) /= self%n .or. size(values, 2) /= self%n) then
         self%values(:) = ieee_value(1.0_wp, ieee_quiet_nan)
         return
      end if
      do b = 1, size(self%first) - 1
         f = self%first(b)
         l = self%first(b + 1) - 1
         call self%set_block(b, values(f:l, f:l))
         do j = f, l
            do i = 1, self%n
               if (i >= f .and. i <= l) cycle
               if (abs(values(i, j)) > 0.0_wp) then
                  self%values(:) = ieee_value(1.0_wp, ieee_quiet_nan)
                  self%stray = [i, j]
               end if
            end do
         end do
      end do
   end subroutine set_dense

   !> Rows and columns become those of the identity, so that the others have no part in them.
   pure subroutine decouple(self, chosen)
      !> The matrix.
      class(block_diagonal_t), intent(inout) :: self
      !> Which: (n).
      logical, intent(in) :: chosen(:)
      integer :: b, i, j, k

      k = 0
      do b = 1, size(self%first) - 1
         do j = self%first(b), self%first(b + 1) - 1
            do i = self%first(b), self%first(b + 1) - 1
               k = k + 1
               if (chosen(i) .or. chosen(j)) self%values(k) = merge(1.0_wp, 0.0_wp, i == j)
            end do
         end do
      end do
   end subroutine decouple

   !> The matrix with all its zeros.
   pure function dense(self) result(k)
      !> The matrix.
      class(block_diagonal_t), intent(in) :: self
      !> All entries: (n, n).
      real(wp) :: k(self%n, self%n)
      integer :: b, f, l, s

      k = 0.0_wp
      do b = 1, size(self%first) - 1
         f = self%first(b)
         l = self%first(b + 1) - 1
         s = l - f + 1
         k(f:l, f:l) = reshape(self%values(self%offset(b) + 1:self%offset(b + 1)), [s, s])
      end do
   end function dense

   !> The sum of the diagonal.
   pure real(wp) function trace(self)
      !> The matrix.
      class(block_diagonal_t), intent(in) :: self
      integer :: b, i, s

      trace = 0.0_wp
      do b = 1, size(self%first) - 1
         s = self%first(b + 1) - self%first(b)
         do i = 1, s
            trace = trace + self%values(self%offset(b) + (i - 1)*s + i)
         end do
      end do
   end function trace

   !> The smallest pivot of the factorization, relative to its diagonal entry: how far the matrix is from a singular one.
   pure real(wp) function smallest_pivot(self)
      !> The factorized matrix.
      class(block_diagonal_t), intent(in) :: self
      integer :: b, i, k, s

      smallest_pivot = 1.0_wp
      if (self%diagonal) return
      do b = 1, size(self%first) - 1
         s = self%first(b + 1) - self%first(b)
         do i = 1, s
            k = self%offset(b) + (i - 1)*s + i
            smallest_pivot = min(smallest_pivot, self%factor(k)**2/self%values(k))
         end do
      end do
   end function smallest_pivot

   !> The smallest pivot, relative to its diagonal entry and to the smallest one before it, which round-off in it is larger by: of a
   !! singular matrix no more than round-off, in whatever order its rows are.
   pure real(wp) function least_certain_pivot(self)
      !> The factorized matrix.
      class(block_diagonal_t), intent(in) :: self
      real(wp) :: before, pivot
      integer :: b, i, k, s

      least_certain_pivot = 1.0_wp
      if (self%diagonal) return
      do b = 1, size(self%first) - 1
         s = self%first(b + 1) - self%first(b)
         before = 1.0_wp
         do i = 1, s
            k = self%offset(b) + (i - 1)*s + i
            pivot = self%factor(k)**2/self%values(k)
            least_certain_pivot = min(least_certain_pivot, pivot*before)
            before = min(before, pivot)
         end do
      end do
   end function least_certain_pivot

   !> Factorizes every block.
   subroutine factorize(self, info)
      !> The matrix.
      class(block_diagonal_t), intent(inout) :: self
      !> 0, or the row at which the matrix was found not to be positive definite.
      integer, intent(out) :: info
      integer :: b, i, s

      do i = 1, size(self%values)
         if (.not. ieee_is_finite(self%values(i))) then
            info = 1
            return
         end if
      end do
      info = 0
      if (self%diagonal) then
         do i = 1, self%n
            if (.not. self%values(i) > 0.0_wp) then
               info = i
               return
            end if
            self%factor(i) = 1.0_wp/self%values(i)
         end do
         return
      end if
      if (self%is_factorized) then
         if (.not. any(abs(self%values - self%factorized) > 0.0_wp)) return
      end if
      self%is_factorized = .false.
      self%factor(:) = self%values
      do b = 1, size(self%first) - 1
         s = self%first(b + 1) - self%first(b)
         if (s <= small) then
            call factorize_small(s, self%factor(self%offset(b) + 1:self%offset(b + 1)), info)
         else
            call dpotrf('L', s, self%factor(self%offset(b) + 1), s, info)
         end if
         if (info /= 0) then
            info = self%first(b) + abs(info) - 1
            return
         end if
      end do
      self%factorized(:) = self%values
      self%is_factorized = .true.
   end subroutine factorize

   !> L of a block in the place of its lower triangle.
   pure subroutine factorize_small(s, l, info)
      integer, intent(in) :: s
      real(wp), intent(inout) :: l(s, s)
      integer, intent(out) :: info
      integer :: i, j, k

      info = 0
      do j = 1, s
         if (.not. l(j, j) > 0.0_wp) then
            info = j
            return
         end if
         l(j, j) = sqrt(l(j, j))
         do i = j + 1, s
            l(i, j) = l(i, j)/l(j, j)
         end do
         do k = j + 1, s
            do i = k, s
               l(i, k) = l(i, k) - l(i, j)*l(k, j)
            end do
         end do
      end do
   end subroutine factorize_small

   !> B := K^-1 B, after `factorize`.
   subroutine solve(self, m, b)
      !> The factorized matrix.
      class(block_diagonal_t), intent(in) :: self
      !> Number of columns.
      integer, intent(in) :: m
      !> Right-hand sides, replaced by the solutions: (n, m).
      real(wp), intent(inout) :: b(self%n, m)
      integer :: i, info, j, s

      if (self%diagonal) then
         do j = 1, m
            do i = 1, self%n
               b(i, j) = self%factor(i)*b(i, j)
            end do
         end do
         return
      end if
      if (m == 0) return
      do i = 1, size(self%first) - 1
         s = self%first(i + 1) - self%first(i)
         ! Blocks of zeros, those of bodies without a constraint, stay zero.
         if (m > 1) then
            if (.not. any(abs(b(self%first(i):self%first(i) + s - 1, :)) > 0.0_wp)) cycle
         end if
         if (s <= small) then
            do j = 1, m
               call self%solve_block(i, b(self%first(i):self%first(i) + s - 1, j))
            end do
         else
            call dpotrs('L', s, m, self%factor(self%offset(i) + 1), s, b(self%first(i), 1), self%n, info)
         end if
      end do
   end subroutine solve

   !> y = K^-1 x, after `factorize`.
   subroutine solve_vector(self, x, y)
      !> The factorized matrix.
      class(block_diagonal_t), intent(in) :: self
      !> Right-hand side: (n).
      real(wp), intent(in) :: x(self%n)
      !> Solution: (n).
      real(wp), intent(inout) :: y(self%n)
      integer :: i

      if (self%diagonal) then
         !GCC$ unroll 1
         do i = 1, self%n
            y(i) = self%factor(i)*x(i)
         end do
         return
      end if
      do i = 1, self%n
         y(i) = x(i)
      end do
      call self%solve(1, y)
   end subroutine solve_vector

   !> x := K_b^-1 x with one block, after `factorize`.
   pure subroutine solve_block(self, b, x)
      !> The factorized matrix.
      class(block_diagonal_t), intent(in) :: self
      !> Index of the block.
      integer, intent(in) :: b
      !> Right-hand side, replaced by the solution: (size of the block).
      real(wp), intent(inout), contiguous :: x(:)
      integer :: i, j, o, s

      if (self%diagonal) then
         x(1) = self%factor(b)*x(1)
         return
      end if
      o = self%offset(b)
      s = size(x)
      do j = 1, s
         x(j) = x(j)/self%factor(o + (j - 1)*s + j)
         do i = j + 1, s
            x(i) = x(i) - self%factor(o + (j - 1)*s + i)*x(j)
         end do
      end do
      do j = s, 1, -1
         do i = j + 1, s
            x(j) = x(j) - self%factor(o + (j - 1)*s + i)*x(i)
         end do
         x(j) = x(j)/self%factor(o + (j - 1)*s + j)
      end do
   end subroutine solve_block

   !> y_k = x_k/K_ll with l = column_k, for a matrix whose blocks have size one, after `factorize`.
   pure subroutine divide(self, column, x, y)
      !> The factorized matrix.
      class(block_diagonal_t), intent(in) :: self
      !> Row of the matrix that belongs to each entry.
      integer, intent(in), contiguous :: column(:)
      !> What is divided: (at least as many).
      real(wp), intent(in), contiguous :: x(:)
      !> The quotients: (as many).
      real(wp), intent(out), contiguous :: y(:)
      integer :: k

      do k = 1, size(column)
         y(k) = x(k)*self%factor(column(k))
      end do
   end subroutine divide

   !> B := L^-1 B, where K = L L^T, after `factorize`.
   subroutine solve_lower(self, m, b)
      !> The factorized matrix.
      class(block_diagonal_t), intent(in) :: self
      !> Number of columns.
      integer, intent(in) :: m
      !> Right-hand sides, replaced by the solutions: (n, m).
      real(wp), intent(inout) :: b(self%n, m)

      call solve_triangular(self, 'N', m, b)
   end subroutine solve_lower

   !> B := L^-T B, where K = L L^T, after `factorize`.
   subroutine solve_lower_transposed(self, m, b)
      !> The factorized matrix.
      class(block_diagonal_t), intent(in) :: self
      !> Number of columns.
      integer, intent(in) :: m
      !> Right-hand sides, replaced by the solutions: (n, m).
      real(wp), intent(inout) :: b(self%n, m)

      call solve_triangular(self, 'T', m, b)
   end subroutine solve_lower_transposed

   subroutine solve_triangular(self, trans, m, b)
      class(block_diagonal_t), intent(in) :: self
      character, intent(in) :: trans
      integer, intent(in) :: m
      real(wp), intent(inout) :: b(self%n, m)
      integer :: i, info, j, s

      if (self%diagonal) then
         do j = 1, m
            do i = 1, self%n
               b(i, j) = sqrt(self%factor(i))*b(i, j)
            end do
         end do
         return
      end if
      if (m == 0) return
      do i = 1, size(self%first) - 1
         s = self%first(i + 1) - self%first(i)
         call dtrtrs('L', trans, 'N', s, m, self%factor(self%offset(i) + 1), s, b(self%first(i), 1), self%n, info)
      end do
   end subroutine solve_triangular

   !> y := K x.
   pure subroutine multiply(self, x, y)
      !> The matrix.
      class(block_diagonal_t), intent(in) :: self
      !> A vector: (n).
      real(wp), intent(in) :: x(:)
      !> Its product with the matrix: (n).
      real(wp), intent(out) :: y(:)
      integer :: b, f, i, j, s

      if (self%diagonal) then
         do i = 1, self%n
            y(i) = self%values(i)*x(i)
         end do
         return
      end if
      do b = 1, size(self%first) - 1
         f = self%first(b) - 1
         s = self%first(b + 1) - self%first(b)
         y(f + 1:f + s) = 0.0_wp
         do j = 1, s
            do i = 1, s
               y(f + i) = y(f + i) + self%values(self%offset(b) + (j - 1)*s + i)*x(f + j)
            end do
         end do
      end do
   end subroutine multiply

end module taut_linalg_block_diagonal
