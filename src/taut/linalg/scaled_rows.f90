!> Rows of a constraint matrix in units of their own: B = D_r A D_c, by rows and by columns.
!!
!! Rows have the length one, and groups of columns (the coordinates of a point, a body's translation, its rotation) one size, so
!! that neither units nor the slenderness of a part say what is small.
module taut_linalg_scaled_rows
   use taut_kinds, only: wp
   use taut_linalg_csr, only: csr_t
   implicit none (type, external)
   private
   public :: scaled_rows_t

   !> The rows.
   type :: scaled_rows_t
      !> Rows and columns.
      integer :: c = 0, n = 0
      !> Entries of B row by row: first of each row, (c + 1); column and value of each.
      integer, allocatable :: first(:), column(:)
      real(wp), allocatable :: b(:)
      !> The same column by column: first of each column, (n + 1); row of each, and its place among those row by row.
      integer, allocatable :: by_column(:), row_of(:), entry_of(:)
      !> Of D_r and D_c: (c), (n).
      real(wp), allocatable :: row_scale(:), column_scale(:)
      !> Whether a row is empty, all its entries zero: (c).
      logical, allocatable :: empty(:)
      !> The group of each column, or none.
      integer, allocatable, private :: group(:)
      !> What a row has in one group: first part of each row, (c + 1); group and size of each part; part of each entry of B.
      integer, allocatable, private :: first_part(:), group_of(:), part_of(:)
      real(wp), allocatable, private :: size_of(:)
      !> The parts of each group: first of each, and the rows that they are in.
      integer, allocatable, private :: by_group(:), row_with(:)
   contains
      procedure :: init
      procedure :: scale
      procedure :: graph
   end type scaled_rows_t

contains

   !> Lays out the pattern; nothing is allocated afterwards.
   subroutine init(self, a, c, group)
      !> The rows.
      class(scaled_rows_t), intent(out) :: self
      !> A matrix with the pattern of A.
      type(csr_t), intent(in) :: a
      !> How many of its rows are used, from the first one on.
      integer, intent(in) :: c
      !> Which columns are measured in the same unit: the number of its group for each, from 1 on, (n); or none, if all are.
      integer, intent(in) :: group(:)
      integer :: i, j

      self%c = c
      self%n = a%n
      allocate (self%group, source=group)
      if (a%full) then
         allocate (self%first, source=[(i*a%n + 1, i=0, c)])
         allocate (self%column, source=[((j, j=1, a%n), i=1, c)])
      else
         allocate (self%first, source=a%first(:c + 1))
         allocate (self%column, source=a%column(:a%first(c + 1) - 1))
      end if
      call list_by_columns(self)
      allocate (self%empty(c), source=.false.)
      allocate (self%b(size(self%column)), source=0.0_wp)
      allocate (self%row_scale(c), self%column_scale(a%n), source=1.0_wp)
      if (size(group) > 0) call list_parts(self)
   end subroutine init

   !> The parts of rows, row by row and group by group.
   subroutine list_parts(self)
      type(scaled_rows_t), intent(inout) :: self
      integer :: at(maxval(self%group)), g, i, k, parts

      allocate (self%first_part(self%c + 1), self%part_of(size(self%column)), self%group_of(size(self%column)), source=0)
      allocate (self%by_group(size(at) + 1), source=0)
      parts = 0
      at = 0
      do i = 1, self%c
         self%first_part(i) = parts + 1
         do k = self%first(i), self%first(i + 1) - 1
            g = self%group(self%column(k))
            if (at(g) < self%first_part(i)) then
               parts = parts + 1
               at(g) = parts
               self%group_of(parts) = g
               self%by_group(g + 1) = self%by_group(g + 1) + 1
            end if
            self%part_of(k) = at(g)
         end do
      end do
      self%first_part(self%c + 1) = parts + 1
      self%group_of = self%group_of(:parts)
      allocate (self%size_of(parts), source=0.0_wp)
      allocate (self%row_with(parts), source=0)
      self%by_group(1) = 1
      do g = 1, size(at)
         self%by_group(g + 1) = self%by_group(g + 1) + self%by_group(g)
      end do
      at = self%by_group(:size(at))
      do i = 1, self%c
         do k = self%first_part(i), self%first_part(i + 1) - 1
            g = self%group_of(k)
            self%row_with(at(g)) = i
            at(g) = at(g) + 1
         end do
      end do
   end subroutine list_parts

   !> The entries of the pattern column by column.
   subroutine list_by_columns(self)
      type(scaled_rows_t), intent(inout) :: self
      integer, allocatable :: next(:)
      integer :: i, j, k

      allocate (self%by_column(self%n + 1), source=0)
      allocate (self%row_of(size(self%column)), self%entry_of(size(self%column)), source=0)
      do k = 1, size(self%column)
         self%by_column(self%column(k) + 1) = self%by_column(self%column(k) + 1) + 1
      end do
      self%by_column(1) = 1
      do j = 1, self%n
         self%by_column(j + 1) = self%by_column(j + 1) + self%by_column(j)
      end do
      allocate (next, source=self%by_column)
      do i = 1, self%c
         do k = self%first(i), self%first(i + 1) - 1
            j = self%column(k)
            self%row_of(next(j)) = i
            self%entry_of(next(j)) = k
            next(j) = next(j) + 1
         end do
      end do
   end subroutine list_by_columns

   !> Which rows share columns.
   subroutine graph(self, neighbor_first, neighbor)
      !> The rows, laid out.
      class(scaled_rows_t), intent(in) :: self
      !> First neighbor of each row, (c + 1).
      integer, allocatable, intent(out) :: neighbor_first(:)
      !> The neighbors.
      integer, allocatable, intent(out) :: neighbor(:)
      integer, allocatable :: met(:)
      integer :: i, k, l, m, round

      allocate (neighbor_first(self%c + 1), met(self%c), neighbor(0))
      do round = 1, 2
         met(:) = 0
         m = 0
         do i = 1, self%c
            neighbor_first(i) = m + 1
            met(i) = i
            do k = self%first(i), self%first(i + 1) - 1
               do l = self%by_column(self%column(k)), self%by_column(self%column(k) + 1) - 1
                  if (met(self%row_of(l)) == i) cycle
                  met(self%row_of(l)) = i
                  m = m + 1
                  if (round == 2) neighbor(m) = self%row_of(l)
               end do
            end do
         end do
         neighbor_first(self%c + 1) = m + 1
         if (round == 1) then
            deallocate (neighbor)
            allocate (neighbor(m))
         end if
      end do
   end subroutine graph

   !> B = D_r A D_c.
   subroutine scale(self, a)
      !> The rows, laid out.
      class(scaled_rows_t), intent(inout) :: self
      !> The matrix, finite, laid out like that given to `init`.
      type(csr_t), intent(in) :: a
      integer :: i, k, round

      self%column_scale(:) = 1.0_wp
      do k = 1, size(self%b)
         self%b(k) = a%values(k)
      end do
      call scale_rows(self)
      if (size(self%group) > 0) then
         do round = 1, 2
            if (round == 1) then
               call strengthen_groups(self)
            else
               call scale_groups(self)
            end if
            do k = 1, size(self%b)
               self%b(k) = a%values(k)*self%column_scale(self%column(k))
            end do
            call scale_rows(self)
         end do
      end if
      do i = 1, self%c
         do k = self%first(i), self%first(i + 1) - 1
            self%b(k) = self%row_scale(i)*self%b(k)
         end do
      end do
   end subroutine scale

   !> Groups that are weak beside another one, even where they are strongest, become as strong: rotations where lengths are small.
   !! Rows of rotations alone would hide it.
   subroutine strengthen_groups(self)
      type(scaled_rows_t), intent(inout) :: self
      !> Beside others, this is nothing but round-off.
      real(wp), parameter :: nothing = 1.0e-14_wp
      real(wp) :: beside(size(self%by_group) - 1), scale(size(self%by_group) - 1)
      integer :: met(size(self%by_group) - 1), g, h, i, k, l, l_own, number

      self%size_of(:) = 0.0_wp
      do i = 1, self%c
         do k = self%first(i), self%first(i + 1) - 1
            self%size_of(self%part_of(k)) = self%size_of(self%part_of(k)) + (self%row_scale(i)*self%b(k))**2
         end do
      end do
      self%size_of(:) = sqrt(self%size_of)
      beside = 0.0_wp
      do g = 1, size(scale)
         number = 0
         do k = self%by_group(g), self%by_group(g + 1) - 1
            i = self%row_with(k)
            l_own = self%first_part(i) - 1 + findloc(self%group_of(self%first_part(i):self%first_part(i + 1) - 1), g, 1)
            if (.not. self%size_of(l_own) > nothing) cycle
            do l = self%first_part(i), self%first_part(i + 1) - 1
               if (l == l_own .or. .not. self%size_of(l) > nothing) cycle
               h = self%group_of(l)
               if (.not. beside(h) > 0.0_wp) then
                  number = number + 1
                  met(number) = h
               end if
               beside(h) = max(beside(h), self%size_of(l_own)/self%size_of(l))
            end do
         end do
         scale(g) = 1.0_wp
         if (number > 0) scale(g) = 1.0_wp/min(1.0_wp, minval(beside(met(:number))))
         beside(met(:number)) = 0.0_wp
      end do
      self%column_scale(:) = scale(self%group)
   end subroutine strengthen_groups

   !> Groups of one size, in all rows together.
   subroutine scale_groups(self)
      type(scaled_rows_t), intent(inout) :: self
      !> A group that is this much smaller than the largest one holds nothing but round-off.
      real(wp), parameter :: nothing = 1.0e-12_wp
      real(wp) :: size_of(size(self%by_group) - 1), smallest
      integer :: i, j, k

      size_of = 0.0_wp
      do i = 1, self%c
         do k = self%first(i), self%first(i + 1) - 1
            j = self%group(self%column(k))
            size_of(j) = size_of(j) + (self%row_scale(i)*self%b(k))**2
         end do
      end do
      size_of = sqrt(size_of)
      smallest = nothing*maxval(size_of)
      do j = 1, self%n
         if (size_of(self%group(j)) > 0.0_wp) &
            self%column_scale(j) = self%column_scale(j)/max(size_of(self%group(j)), smallest)
      end do
   end subroutine scale_groups

   !> 1 over the length of each row; rows of zeros are set aside.
   pure subroutine scale_rows(self)
      type(scaled_rows_t), intent(inout) :: self
      integer :: i
      real(wp) :: largest

      do i = 1, self%c
         associate (row => self%b(self%first(i):self%first(i + 1) - 1))
            largest = 0.0_wp
            if (size(row) > 0) largest = maxval(abs(row))
            self%empty(i) = .not. largest > tiny(1.0_wp)
            self%row_scale(i) = 0.0_wp
            ! Entries may be of any size, so that their squares would overflow.
            if (.not. self%empty(i)) self%row_scale(i) = 1.0_wp/(largest*norm2(row/largest))
         end associate
      end do
   end subroutine scale_rows

end module taut_linalg_scaled_rows
