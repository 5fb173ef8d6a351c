!> S = A K^-1 A^T and K^-1 A^T of a structured A, entry by entry: where they are is found out once.
module taut_linalg_normal_matrix
   use taut_kinds, only: wp
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_csr, only: csr_t
   implicit none (type, external)
   private
   public :: normal_matrix_t

   !> The lower triangle of S, its rows and columns in an ordering of one's choice.
   type :: normal_matrix_t
      !> Rows.
      integer :: c = 0
      !> Row of A at each place of the ordering; whether that is the given order.
      integer, allocatable :: order(:)
      logical :: natural = .true.
      !> Entries: the diagonal (c), then those below it.
      real(wp), allocatable :: s(:)
      !> Whether the blocks of K are of size one, so that A K^-1 is A if K = I.
      logical :: diagonal = .true.
      !> Row and column of those below the diagonal, as places of the ordering, row by row.
      integer, allocatable :: row(:), column(:)
      !> A K^-1: the rows of A, filled up to whole blocks of K; not set where it is A itself.
      type(csr_t) :: a_kinv
      !> The products of groups of entries of A and of A K^-1 that make the entries of S, by the first entries of the groups,
      !! and the size of the groups.
      integer, allocatable, private :: first(:), of_a(:), of_a_kinv(:)
      integer, private :: group = 1
      !> Where the entries of A are in A K^-1, if K has blocks, and the blocks of each row.
      integer, allocatable, private :: place(:), block_first(:), block(:), block_size(:)
   contains
      procedure :: init
      procedure :: graph
      procedure :: reorder
      procedure :: assemble
   end type normal_matrix_t

contains

   !> Finds out what there is to compute; nothing is allocated afterwards.
   subroutine init(self, a, c, sizes)
      !> The matrix.
      class(normal_matrix_t), intent(out) :: self
      !> A matrix with the pattern of A.
      type(csr_t), intent(in) :: a
      !> How many of its rows are used.
      integer, intent(in) :: c
      !> Sizes of the blocks of K.
      integer, intent(in) :: sizes(:)
      integer :: i

      self%c = c
      self%diagonal = all(sizes == 1)
      call fill_blocks(self, a, sizes)
      if (a%group == self%a_kinv%group) self%group = a%group
      allocate (self%order(c))
      self%order = [(i, i=1, c)]
      call find_products(self, a)
   end subroutine init

   !> Takes another ordering.
   subroutine reorder(self, a, order)
      !> The matrix.
      class(normal_matrix_t), intent(inout) :: self
      !> A matrix with the pattern of A.
      type(csr_t), intent(in) :: a
      !> Row of A at each place: (c).
      integer, intent(in) :: order(:)
      integer :: i

      self%order(:) = order
      self%natural = all(order == [(i, i=1, self%c)])
      deallocate (self%first, self%of_a, self%of_a_kinv, self%row, self%column, self%s)
      call find_products(self, a)
   end subroutine reorder

   !> The pattern of A K^-1.
   subroutine fill_blocks(self, a, sizes)
      type(normal_matrix_t), intent(inout) :: self
      type(csr_t), intent(in) :: a
      integer, intent(in) :: sizes(:)
      integer, allocatable :: begin(:), block_of(:), column(:), first(:)
      integer :: b, blocks, i, k, l, last, round, entries

      if (self%diagonal) then
         call self%a_kinv%set_pattern(a%n, a%first(:self%c + 1), a%column(:a%first(self%c + 1) - 1))
         allocate (self%place(0), self%block_first(0), self%block(0), self%block_size(0))
         return
      end if
      allocate (begin(size(sizes) + 1), block_of(a%n), first(self%c + 1), self%block_first(self%c + 1))
      allocate (self%block_size, source=sizes)
      begin(1) = 1
      do b = 1, size(sizes)
         begin(b + 1) = begin(b) + sizes(b)
         block_of(begin(b):begin(b + 1) - 1) = b
      end do
      allocate (self%place(a%first(self%c + 1) - 1), self%block(0), column(0))
      do round = 1, 2
         blocks = 0
         entries = 0
         do i = 1, self%c
            first(i) = entries + 1
            self%block_first(i) = blocks + 1
            last = 0
            do k = a%first(i), a%first(i + 1) - 1
               b = block_of(a%column(k))
               if (b /= last) then
                  blocks = blocks + 1
                  if (round == 2) then
                     self%block(blocks) = b
                     column(entries + 1:entries + sizes(b)) = [(l, l=begin(b), begin(b + 1) - 1)]
                  end if
                  entries = entries + sizes(b)
                  last = b
               end if
               self%place(k) = entries - sizes(b) + 1 + a%column(k) - begin(b)
            end do
         end do
         first(self%c + 1) = entries + 1
         self%block_first(self%c + 1) = blocks + 1
         if (round == 1) then
            deallocate (self%block, column)
            allocate (self%block(blocks), column(entries))
         end if
      end do
      call self%a_kinv%set_pattern(a%n, first, column)
   end subroutine fill_blocks

   !> The entries of S in the present ordering and the products that make them.
   subroutine find_products(self, a)
      type(normal_matrix_t), intent(inout) :: self
      type(csr_t), intent(in) :: a
      integer, allocatable :: begin(:), of_row(:), of_entry(:), number(:), place(:), met(:), products(:)
      integer :: c, entries, g, i, j, k, l, m, p, round, total

      c = self%c
      g = self%group
      ! The groups of A K^-1 column by column.
      allocate (begin(a%n/g + 1), source=0)
      do k = 1, size(self%a_kinv%column), g
         l = (self%a_kinv%column(k) - 1)/g + 1
         begin(l + 1) = begin(l + 1) + 1
      end do
      begin(1) = 1
      do l = 1, a%n/g
         begin(l + 1) = begin(l + 1) + begin(l)
      end do
      allocate (of_row(size(self%a_kinv%column)/g), of_entry(size(self%a_kinv%column)/g))
      do i = 1, c
         do k = self%a_kinv%first(i), self%a_kinv%first(i + 1) - 1, g
            l = (self%a_kinv%column(k) - 1)/g + 1
            of_row(begin(l)) = i
            of_entry(begin(l)) = k
            begin(l) = begin(l) + 1
         end do
      end do
      do l = a%n/g, 1, -1
         begin(l + 1) = begin(l)
      end do
      begin(1) = 1

      allocate (place(c), number(c), met(c), products(c))
      do p = 1, c
         place(self%order(p)) = p
      end do
      number(:) = 0
      allocate (self%row(0), self%column(0), self%first(0), self%of_a(0), self%of_a_kinv(0))
      do round = 1, 2
         entries = 0
         total = 0
         ! The diagonal comes first, so that the products are counted twice: entry by entry, then one after the other.
         do p = 1, c
            i = self%order(p)
            m = 1
            met(1) = i
            number(i) = 1
            products(1) = 0
            do k = a%first(i), a%first(i + 1) - 1, g
               do l = begin((a%column(k) - 1)/g + 1), begin((a%column(k) - 1)/g + 2) - 1
                  j = of_row(l)
                  if (place(j) > p) cycle
                  if (number(j) == 0) then
                     m = m + 1
                     met(m) = j
                     number(j) = m
                     products(m) = 0
                  end if
                  products(number(j)) = products(number(j)) + 1
               end do
            end do
            if (round == 2) then
               self%first(p + 1) = products(1)
               do j = 2, m
                  self%row(entries + j - 1) = p
                  self%column(entries + j - 1) = place(met(j))
                  self%first(c + entries + j) = products(j)
               end do
            end if
            entries = entries + m - 1
            total = total + sum(products(:m))
            number(met(:m)) = 0
         end do
         if (round == 1) then
            deallocate (self%row, self%column, self%first, self%of_a, self%of_a_kinv)
            allocate (self%row(entries), self%column(entries), self%first(c + entries + 1), self%of_a(total), self%of_a_kinv(total))
            self%first(1) = 1
         end if
      end do
      do k = 1, c + entries
         self%first(k + 1) = self%first(k + 1) + self%first(k)
      end do
      entries = 0
      do p = 1, c
         i = self%order(p)
         m = 1
         met(1) = i
         number(i) = 1
         products(1) = self%first(p)
         do k = a%first(i), a%first(i + 1) - 1, g
            do l = begin((a%column(k) - 1)/g + 1), begin((a%column(k) - 1)/g + 2) - 1
               j = of_row(l)
               if (place(j) > p) cycle
               if (number(j) == 0) then
                  m = m + 1
                  met(m) = j
                  number(j) = m
                  products(m) = self%first(c + entries + m - 1)
               end if
               self%of_a(products(number(j))) = k
               self%of_a_kinv(products(number(j))) = of_entry(l)
               products(number(j)) = products(number(j)) + 1
            end do
         end do
         entries = entries + m - 1
         number(met(:m)) = 0
      end do
      allocate (self%s(c + entries), source=0.0_wp)
   end subroutine find_products

   !> Which rows share coordinates, as places of the present ordering.
   subroutine graph(self, first, neighbor)
      !> The matrix.
      class(normal_matrix_t), intent(in) :: self
      !> First neighbor of each row, and the number of neighbors in all plus one at the end: (c + 1).
      integer, allocatable, intent(out) :: first(:)
      !> The neighbors of each row.
      integer, allocatable, intent(out) :: neighbor(:)
      integer :: k

      allocate (first(self%c + 1), source=0)
      allocate (neighbor(2*size(self%row)))
      do k = 1, size(self%row)
         first(self%row(k) + 1) = first(self%row(k) + 1) + 1
         first(self%column(k) + 1) = first(self%column(k) + 1) + 1
      end do
      first(1) = 1
      do k = 1, self%c
         first(k + 1) = first(k + 1) + first(k)
      end do
      do k = 1, size(self%row)
         neighbor(first(self%row(k))) = self%column(k)
         first(self%row(k)) = first(self%row(k)) + 1
         neighbor(first(self%column(k))) = self%row(k)
         first(self%column(k)) = first(self%column(k)) + 1
      end do
      do k = self%c, 1, -1
         first(k + 1) = first(k)
      end do
      first(1) = 1
   end subroutine graph

   !> Computes the entries.
   subroutine assemble(self, a, k, identity)
      !> The matrix.
      class(normal_matrix_t), intent(inout) :: self
      !> The constraint matrix, with the pattern that was analyzed; finite.
      type(csr_t), intent(in) :: a
      !> The metric, factorized; not used if it is the identity.
      type(block_diagonal_t), intent(in) :: k
      !> Whether K = I.
      logical, intent(in) :: identity
      integer :: b, e, i, l

      if (.not. self%diagonal) then
         do l = 1, size(self%a_kinv%values)
            self%a_kinv%values(l) = 0.0_wp
         end do
         do l = 1, size(self%place)
            self%a_kinv%values(self%place(l)) = a%values(l)
         end do
         if (.not. identity) then
            do i = 1, self%c
               e = self%a_kinv%first(i)
               do l = self%block_first(i), self%block_first(i + 1) - 1
                  b = self%block_size(self%block(l))
                  call k%solve_block(self%block(l), self%a_kinv%values(e:e + b - 1))
                  e = e + b
               end do
            end do
         end if
      else if (identity) then
         ! A K^-1 = A.
         call sum_groups(a%values, a%values)
         return
      else
         call k%divide(self%a_kinv%column, a%values, self%a_kinv%values)
      end if
      call sum_groups(a%values, self%a_kinv%values)

   contains

      subroutine sum_groups(a_values, kinv_values)
         real(wp), intent(in), contiguous :: a_values(:), kinv_values(:)

         if (self%group == 2) then
            call sum_products_of_pairs(size(self%s), self%first, self%of_a, self%of_a_kinv, a_values, kinv_values, self%s)
         else
            call sum_products(self%group, size(self%s), self%first, self%of_a, self%of_a_kinv, a_values, kinv_values, self%s)
         end if
      end subroutine sum_groups

   end subroutine assemble

   !> The entries of S one after the other, with groups of one or three.
   pure subroutine sum_products(g, entries, first, of_a, of_a_kinv, a, a_kinv, s)
      integer, intent(in) :: g, entries
      integer, intent(in) :: first(*), of_a(*), of_a_kinv(*)
      real(wp), intent(in) :: a(*), a_kinv(*)
      real(wp), intent(inout) :: s(*)
      integer :: e, j, k, p
      real(wp) :: t

      if (g == 1) then
         do e = 1, entries
            t = 0.0_wp
            !GCC$ unroll 1
            do p = first(e), first(e + 1) - 1
               t = t + a(of_a(p))*a_kinv(of_a_kinv(p))
            end do
            s(e) = t
         end do
         return
      end if
      do e = 1, entries
         t = 0.0_wp
         !GCC$ unroll 1
         do p = first(e), first(e + 1) - 1
            j = of_a(p)
            k = of_a_kinv(p)
            t = t + a(j)*a_kinv(k)
            t = t + a(j + 1)*a_kinv(k + 1)
            t = t + a(j + 2)*a_kinv(k + 2)
         end do
         s(e) = t
      end do
   end subroutine sum_products

   !> The same with groups of two.
   pure subroutine sum_products_of_pairs(entries, first, of_a, of_a_kinv, a, a_kinv, s)
      integer, intent(in) :: entries
      integer, intent(in) :: first(*), of_a(*), of_a_kinv(*)
      real(wp), intent(in) :: a(*), a_kinv(*)
      real(wp), intent(inout) :: s(*)
      integer :: e, j, k, p
      real(wp) :: t1, t2

      do e = 1, entries
         p = first(e)
         if (first(e + 1) == p) then
            ! A row without entries.
            s(e) = 0.0_wp
            cycle
         end if
         j = of_a(p)
         k = of_a_kinv(p)
         t1 = a(j)*a_kinv(k)
         t2 = a(j + 1)*a_kinv(k + 1)
         !GCC$ unroll 1
         do p = p + 1, first(e + 1) - 1
            j = of_a(p)
            k = of_a_kinv(p)
            t1 = t1 + a(j)*a_kinv(k)
            t2 = t2 + a(j + 1)*a_kinv(k + 1)
         end do
         s(e) = t1 + t2
      end do
   end subroutine sum_products_of_pairs

end module taut_linalg_normal_matrix
