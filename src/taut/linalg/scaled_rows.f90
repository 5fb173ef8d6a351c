!> Rows of a constraint matrix in units of their own: B = D_r A D_c, by rows and by columns.
!!
!! Rows have the length one, and groups of columns (the coordinates of a point, a body's translation, its rotation) one size, in
!! all directions nearly alike, so that neither units nor the slenderness of a part say what is small.
module taut_linalg_scaled_rows
   use taut_kinds, only: wp
   use taut_linalg_csr, only: csr_t
   use taut_linalg_stretch, only: find_stretch, needs_stretch, unstretched
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
      !> What D_c does besides to groups that are vectors: for each column its coefficients in those of its group, (3, n).
      real(wp), allocatable :: stretch(:, :)
      !> By how much the weakest direction is stretched; 1 if none is.
      real(wp) :: stretched = 1.0_wp
      !> Whether a row is empty, all its entries zero: (c).
      logical, allocatable :: empty(:)
      !> Where in B the entries of A are.
      integer, allocatable, private :: place(:)
      !> The group of each column, or none.
      integer, allocatable, private :: group(:)
      !> Columns of each group that is a vector, and their number: (3, groups), (groups); other groups have none.
      integer, allocatable, private :: member(:, :), members(:)
      !> Which column of its vector each is, 1 for those of no vector: (n).
      integer, allocatable, private :: position(:)
      !> What a row has in one group: first part of each row, (c + 1); group and size of each part; part of each entry of B.
      integer, allocatable, private :: first_part(:), group_of(:), part_of(:)
      real(wp), allocatable, private :: size_of(:)
      !> The parts of each group: first of each, the rows that they are in, and their numbers.
      integer, allocatable, private :: by_group(:), row_with(:), part_with(:)
      !> The entries of B of each part of a vector: (3, parts).
      integer, allocatable, private :: entry_in(:, :)
   contains
      procedure :: init
      procedure :: scale
      procedure :: length_of_change
      procedure :: to_motion
      procedure :: from_motion
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
      call list_members(self)
      if (a%full) then
         allocate (self%first, source=[(i*a%n + 1, i=0, c)])
         allocate (self%column, source=[((j, j=1, a%n), i=1, c)])
         allocate (self%place, source=[(i, i=1, size(self%column))])
      else
         call complete_vectors(self, a)
      end if
      call list_by_columns(self)
      allocate (self%empty(c), source=.false.)
      allocate (self%b(size(self%column)), source=0.0_wp)
      allocate (self%row_scale(c), self%column_scale(a%n), source=1.0_wp)
      if (size(group) > 0) call list_parts(self)
   end subroutine init

   !> Which groups are vectors: those of two or three columns.
   subroutine list_members(self)
      type(scaled_rows_t), intent(inout) :: self
      integer :: g, groups, j

      groups = 0
      if (size(self%group) > 0) groups = maxval(self%group)
      allocate (self%member(3, groups), self%members(groups), source=0)
      allocate (self%position(self%n), source=1)
      do j = 1, size(self%group)
         g = self%group(j)
         self%members(g) = self%members(g) + 1
         self%position(j) = self%members(g)
         if (self%members(g) <= 3) self%member(self%members(g), g) = j
      end do
      where (self%members == 1 .or. self%members > 3) self%members = 0
      do j = 1, size(self%group)
         if (self%members(self%group(j)) == 0) self%position(j) = 1
      end do
      allocate (self%stretch(3, merge(self%n, 0, any(self%members > 0))), source=0.0_wp)
   end subroutine list_members

   !> The pattern of B: that of A, and of a vector all columns where there is one.
   subroutine complete_vectors(self, a)
      type(scaled_rows_t), intent(inout) :: self
      type(csr_t), intent(in) :: a
      integer :: g, i, k, l, m, met(self%n), met_group(size(self%members)), missing, round

      allocate (self%first, source=a%first(:self%c + 1))
      allocate (self%place, source=[(k, k=1, a%first(self%c + 1) - 1)])
      do round = 1, 2
         met = 0
         met_group = 0
         missing = 0
         do i = 1, self%c
            if (size(self%group) == 0) exit
            do k = a%first(i), a%first(i + 1) - 1
               met(a%column(k)) = i
               if (round == 1) cycle
               self%place(k) = k + missing
               self%column(k + missing) = a%column(k)
            end do
            do k = a%first(i), a%first(i + 1) - 1
               g = self%group(a%column(k))
               if (met_group(g) == i) cycle
               met_group(g) = i
               do l = 1, self%members(g)
                  m = self%member(l, g)
                  if (met(m) == i) cycle
                  missing = missing + 1
                  if (round == 2) self%column(a%first(i + 1) - 1 + missing) = m
               end do
            end do
            if (round == 2) self%first(i + 1) = a%first(i + 1) + missing
         end do
         if (round == 2) return
         if (missing == 0) then
            allocate (self%column, source=a%column(:a%first(self%c + 1) - 1))
            return
         end if
         allocate (self%column(size(self%place) + missing), source=0)
      end do
   end subroutine complete_vectors

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
      allocate (self%row_with(parts), self%part_with(parts), self%entry_in(3, parts), source=0)
      self%by_group(1) = 1
      do g = 1, size(at)
         self%by_group(g + 1) = self%by_group(g + 1) + self%by_group(g)
      end do
      at = self%by_group(:size(at))
      do i = 1, self%c
         do k = self%first_part(i), self%first_part(i + 1) - 1
            g = self%group_of(k)
            self%row_with(at(g)) = i
            self%part_with(at(g)) = k
            at(g) = at(g) + 1
         end do
         do k = self%first(i), self%first(i + 1) - 1
            g = self%group(self%column(k))
            if (self%members(g) > 0) self%entry_in(self%position(self%column(k)), self%part_of(k)) = k
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
               ! Rows with one column of a vector have all of them.
               if (self%position(self%column(k)) > 1) cycle
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
   subroutine scale(self, a, stretch)
      !> The rows, laid out.
      class(scaled_rows_t), intent(inout) :: self
      !> The matrix, finite, laid out like that given to `init`.
      type(csr_t), intent(in) :: a
      !> Whether weak directions are stretched, default true: how weak they are is then not seen.
      logical, intent(in), optional :: stretch
      integer :: i, k, round

      self%stretched = 1.0_wp
      self%column_scale(:) = 1.0_wp
      call take_columns(self, a)
      call scale_rows(self)
      if (size(self%group) > 0) then
         do round = 1, 2
            if (round == 1) then
               call strengthen_groups(self)
            else
               call scale_groups(self)
            end if
            call take_columns(self, a)
            call scale_rows(self)
         end do
         if (present(stretch)) then
            if (stretch) call stretch_vectors(self)
         else
            call stretch_vectors(self)
         end if
         if (self%stretched > 1.0_wp) call scale_rows(self)
      end if
      do i = 1, self%c
         do k = self%first(i), self%first(i + 1) - 1
            self%b(k) = self%row_scale(i)*self%b(k)
         end do
      end do
   end subroutine scale

   !> B := A D_c, without what is done to directions.
   subroutine take_columns(self, a)
      type(scaled_rows_t), intent(inout) :: self
      type(csr_t), intent(in) :: a
      integer :: k

      if (size(self%b) > size(self%place)) self%b(:) = 0.0_wp
      do k = 1, size(self%place)
         self%b(self%place(k)) = a%values(k)*self%column_scale(self%column(self%place(k)))
      end do
   end subroutine take_columns

   !> Directions of vectors that are weak are stretched.
   subroutine stretch_vectors(self)
      type(scaled_rows_t), intent(inout) :: self
      real(wp) :: gram(3, 3), most, scale, w(3)
      integer :: g, j, k, m

      if (size(self%stretch) == 0) return
      self%stretch(:, :) = 0.0_wp
      do j = 1, self%n
         if (self%members(self%group(j)) > 0) self%stretch(self%position(j), j) = 1.0_wp
      end do
      do g = 1, size(self%members)
         m = self%members(g)
         if (m == 0) cycle
         gram = 0.0_wp
         w = 0.0_wp
         do k = self%by_group(g), self%by_group(g + 1) - 1
            scale = self%row_scale(self%row_with(k))
            do j = 1, m
               w(j) = scale*self%b(self%entry_in(j, self%part_with(k)))
            end do
            gram(:, 1) = gram(:, 1) + w*w(1)
            gram(2:, 2) = gram(2:, 2) + w(2:)*w(2)
            gram(3, 3) = gram(3, 3) + w(3)*w(3)
         end do
         if (needs_stretch(gram(:m, :m))) call stretch_group(g, m, self%by_group(g + 1) - self%by_group(g))
      end do

   contains

      subroutine stretch_group(g, m, number)
         integer, intent(in) :: g, m, number
         real(wp) :: part(number, m), t(m, m)
         integer :: j, k

         do k = 1, number
            associate (l => self%by_group(g) + k - 1)
               part(k, :) = self%row_scale(self%row_with(l))*self%b(self%entry_in(:m, self%part_with(l)))
            end associate
         end do
         call find_stretch(part, t, most)
         if (.not. most > 1.0_wp) return
         self%stretched = max(self%stretched, most)
         do j = 1, m
            self%stretch(:m, self%member(j, g)) = t(:, j)
         end do
         do k = self%by_group(g), self%by_group(g + 1) - 1
            associate (entry => self%entry_in(:m, self%part_with(k)))
               self%b(entry) = matmul(t, self%b(entry))
            end associate
         end do
      end subroutine stretch_group

   end subroutine stretch_vectors

   !> How far a row moves from one matrix to another, in the units of the first.
   pure function length_of_change(self, i, a, there) result(length)
      !> The rows, scaled.
      class(scaled_rows_t), intent(in) :: self
      !> The row.
      integer, intent(in) :: i
      !> The matrix of which they are.
      type(csr_t), intent(in) :: a
      !> The other one.
      type(csr_t), intent(in) :: there
      !> The length.
      real(wp) :: length
      real(wp) :: change(self%first(i):self%first(i + 1) - 1)
      integer :: k, first, last, p

      first = (i - 1)*a%n + 1
      last = i*a%n
      if (.not. a%full) then
         first = a%first(i)
         last = a%first(i + 1) - 1
      end if
      change(:) = 0.0_wp
      do k = first, last
         p = self%place(k)
         change(p) = (there%values(k) - a%values(k))*self%column_scale(self%column(p))
      end do
      if (self%stretched > 1.0_wp) then
         do p = self%first_part(i), self%first_part(i + 1) - 1
            associate (g => self%group_of(p))
               associate (columns => self%member(:self%members(g), g), entry => self%entry_in(:self%members(g), p))
                  change(entry) = matmul(self%stretch(:size(columns), columns), change(entry))
               end associate
            end associate
         end do
      end if
      length = 0.0_wp
      do k = self%first(i), self%first(i + 1) - 1
         length = length + change(k)**2
      end do
      length = self%row_scale(i)*sqrt(length)
   end function length_of_change

   !> z := D_c z: a motion from the units of B to those of A.
   pure subroutine to_motion(self, z)
      !> The rows, scaled.
      class(scaled_rows_t), intent(in) :: self
      !> The motion: (n).
      real(wp), intent(inout) :: z(:)
      integer :: g

      if (self%stretched > 1.0_wp) then
         do g = 1, size(self%members)
            associate (columns => self%member(:self%members(g), g))
               z(columns) = matmul(self%stretch(:size(columns), columns), z(columns))
            end associate
         end do
      end if
      z(:) = self%column_scale*z
   end subroutine to_motion

   !> z := D_c^-1 z: a motion from the units of A to those of B.
   pure subroutine from_motion(self, z)
      !> The rows, scaled.
      class(scaled_rows_t), intent(in) :: self
      !> The motion: (n).
      real(wp), intent(inout) :: z(:)
      integer :: g

      z(:) = z/self%column_scale
      if (.not. self%stretched > 1.0_wp) return
      do g = 1, size(self%members)
         associate (columns => self%member(:self%members(g), g))
            if (size(columns) > 0) z(columns) = unstretched(self%stretch(:size(columns), columns), z(columns))
         end associate
      end do
   end subroutine from_motion

   !> Groups that are weak beside another one, even where they are strongest, become as strong: rotations where lengths are small.
   !! Rows of rotations alone would hide it.
   subroutine strengthen_groups(self)
      type(scaled_rows_t), intent(inout) :: self
      !> Beside others, this is nothing but round-off.
      real(wp), parameter :: nothing = 1.0e-14_wp
      !> Less than this part of what is usual is far weaker.
      real(wp), parameter :: rare = 1.0e-3_wp
      real(wp), dimension(size(self%by_group) - 1) :: beside, scale, usual
      integer, allocatable :: others(:)
      integer :: met(size(self%by_group) - 1), g, i, k, number

      self%size_of(:) = 0.0_wp
      do i = 1, self%c
         do k = self%first(i), self%first(i + 1) - 1
            self%size_of(self%part_of(k)) = self%size_of(self%part_of(k)) + (self%row_scale(i)*self%b(k))**2
         end do
      end do
      self%size_of(:) = sqrt(self%size_of)
      beside = 0.0_wp
      usual = 0.0_wp
      do g = 1, size(scale)
         call compare_with_others()
         scale(g) = weakest()
         if (scale(g) < rare) then
            usual(met(:number)) = beside(met(:number))
            others = met(:number)
            beside(others) = 0.0_wp
            call compare_with_others()
            if (number > 0) scale(g) = weakest()
            usual(others) = 0.0_wp
         end if
         beside(met(:number)) = 0.0_wp
         scale(g) = 1.0_wp/scale(g)
      end do
      self%column_scale(:) = scale(self%group)

   contains

      !> How strong the group is beside each other one, where it is strongest. Rows say nothing of its unit in which it is far
      !! weaker than usual, such as that of a force along a rod, whose moment is next to nothing.
      subroutine compare_with_others()
         integer :: h, i, k, l, l_own

         number = 0
         do k = self%by_group(g), self%by_group(g + 1) - 1
            i = self%row_with(k)
            l_own = self%part_with(k)
            if (.not. self%size_of(l_own) > nothing) cycle
            do l = self%first_part(i), self%first_part(i + 1) - 1
               if (self%size_of(l_own) < rare*usual(self%group_of(l))*self%size_of(l)) exit
            end do
            if (l < self%first_part(i + 1)) cycle
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
      end subroutine compare_with_others

      !> How strong it is beside the one beside which it is weakest; 1 at most.
      pure real(wp) function weakest()
         weakest = 1.0_wp
         if (number > 0) weakest = min(1.0_wp, minval(beside(met(:number))))
      end function weakest

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
      integer :: i, k
      real(wp) :: largest

      do i = 1, self%c
         associate (row => self%b(self%first(i):self%first(i + 1) - 1))
            largest = 0.0_wp
            do k = 1, size(row)
               largest = max(largest, abs(row(k)))
            end do
            self%empty(i) = .not. largest > tiny(1.0_wp)
            self%row_scale(i) = 0.0_wp
            ! Entries may be of any size, so that their squares would overflow.
            if (.not. self%empty(i)) self%row_scale(i) = 1.0_wp/(largest*sqrt(sum((row/largest)**2)))
         end associate
      end do
   end subroutine scale_rows

end module taut_linalg_scaled_rows
