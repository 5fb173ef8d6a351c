!> Which rows of a constraint matrix are kept and which depend on them: one selection for all solvers.
!!
!! Whether rows depend on each other is a matter of geometry, and not of masses: it is decided on B = D_r A D_c, rows of length
!! one and groups of columns (the coordinates of a point, a body's translation, its rotation) of one size, so that neither
!! units nor masses nor the slenderness of a part hide a row. S = B B^T = L D L^T row by row; a small pivot is only a reason for
!! doubt, as its error grows with the square of the null vector. A doubtful row k is looked at in the space of B: with v its
!! null vector, v_k = 1 and the others from L^T v = e_k, made exact through B, r = B^T v is what the row has that the others do
!! not, and |r|/|v| bounds the smallest singular value from above, not squared.
!!
!! A row that is left out in the order in which it came may be a bad choice: where an entry of v is much larger than 1, the row
!! of that entry is left out instead.
module taut_linalg_row_selection
   use taut_kinds, only: wp
   use taut_linalg_csr, only: csr_t
   use taut_linalg_ordering, only: minimum_degree
   use taut_linalg_rank, only: doubtful_pivot, independent, largest_share, passed_pivot, with_noise
   use taut_linalg_sparse_factor, only: sparse_factor_t
   implicit none (type, external)
   private
   public :: row_selection_t

   !> Rounds of exchanges: each null vector asks for less than one.
   integer, parameter :: most_rounds = 20

   !> What some kept rows have that those before them do not: sparse vectors, one after the other.
   type :: remainders_t
      integer :: number = 0
      integer, allocatable :: first(:), column(:)
      real(wp), allocatable :: value(:)
   contains
      procedure :: clear => remainders_clear
      procedure :: append => remainders_append
   end type remainders_t

   !> Places where a null vector is not zero.
   type :: support_t
      integer, allocatable :: places(:)
   end type support_t

   !> The rows that are kept, and why the others are not.
   type :: row_selection_t
      !> Rows and columns.
      integer :: c = 0, n = 0
      !> Rows that are kept.
      integer :: rank = 0
      !> Whether a row is kept: (c).
      logical, allocatable :: kept(:)
      !> Whether a row is empty, all its entries zero: (c). It is not kept.
      logical, allocatable :: empty(:)
      !> Of rows that are left out, how far they are from depending on the others exactly: |B^T v|/|v|, (c). Zero for the others.
      real(wp), allocatable :: distance(:)
      !> The smallest pivot in the order of selection, of all rows; 0 if one was left out.
      real(wp) :: smallest_pivot = 0.0_wp
      !> Of D_r and D_c: (c), (n).
      real(wp), allocatable :: row_scale(:), column_scale(:)
      !> What |B^T v|/|v| must exceed for a row to be kept.
      real(wp), private :: threshold = independent
      integer, allocatable, private :: group(:), first(:), column(:), by_column(:), row_of(:), entry_of(:), order(:), place(:)
      !> Entries of B by rows; of a row of B, of B^T v and of v.
      real(wp), allocatable, private :: b(:), dense_row(:), r(:), v(:), g(:)
      !> For each place the number of what the row there has that others do not, where that replaces its column of L D.
      integer, allocatable, private :: replaced(:)
      !> Of rows that are left out: whether the null vector asks for no exchange, and where it is not zero: (c).
      logical, allocatable, private :: settled(:)
      type(support_t), allocatable, private :: support(:)
      type(remainders_t), private :: rest
      type(sparse_factor_t), private :: factor
   contains
      procedure :: init
      procedure :: select => select_rows
      procedure :: null_vector
      procedure :: leave_out
   end type row_selection_t

contains

   !> Finds an ordering of the rows of a pattern; nothing of its sizes is allocated afterwards.
   subroutine init(self, a, c, group, rcond)
      !> The selection.
      class(row_selection_t), intent(out) :: self
      !> A matrix with the pattern of A.
      type(csr_t), intent(in) :: a
      !> How many of its rows are used, from the first one on.
      integer, intent(in) :: c
      !> Which columns are measured in the same unit: the number of its group for each, from 1 on, (n); or none, if all are.
      integer, intent(in) :: group(:)
      !> Relative size of what a row must have that others do not; 0 for the default.
      real(wp), intent(in) :: rcond
      integer, allocatable :: neighbor_first(:), neighbor(:), row(:), below(:)
      integer :: i, j

      self%c = c
      self%n = a%n
      if (rcond > 0.0_wp) self%threshold = rcond
      allocate (self%group, source=group)
      if (a%full) then
         allocate (self%first, source=[(i*a%n + 1, i=0, c)])
         allocate (self%column, source=[((j, j=1, a%n), i=1, c)])
      else
         allocate (self%first, source=a%first(:c + 1))
         allocate (self%column, source=a%column(:a%first(c + 1) - 1))
      end if
      call list_by_columns(self)
      allocate (self%order(c), self%place(c), self%replaced(c), source=0)
      if (a%full) then
         self%order = [(i, i=1, c)]
      else
         call graph(self, neighbor_first, neighbor)
         call minimum_degree(neighbor_first, neighbor, self%order)
      end if
      do i = 1, c
         self%place(self%order(i)) = i
      end do
      call list_below(self, a%full, row, below)
      call self%factor%init(c, row, below)
      allocate (self%kept(c), source=.true.)
      allocate (self%empty(c), self%settled(c), source=.false.)
      allocate (self%support(c))
      allocate (self%b(size(self%column)), self%dense_row(a%n), self%r(a%n), self%v(c), self%g(c), self%distance(c), source=0.0_wp)
      allocate (self%row_scale(c), self%column_scale(a%n), source=1.0_wp)
      self%rank = c
      call self%rest%clear()
   end subroutine init

   !> The entries of the pattern column by column.
   subroutine list_by_columns(self)
      type(row_selection_t), intent(inout) :: self
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
      type(row_selection_t), intent(in) :: self
      integer, allocatable, intent(out) :: neighbor_first(:), neighbor(:)
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

   !> The entries of S below the diagonal, as places of the ordering, row by row.
   subroutine list_below(self, full, row, below)
      type(row_selection_t), intent(in) :: self
      logical, intent(in) :: full
      integer, allocatable, intent(out) :: row(:), below(:)
      integer, allocatable :: neighbor_first(:), neighbor(:)
      integer :: j, l, m, p

      if (full) then
         allocate (row, source=[((p, j=1, p - 1), p=1, self%c)])
         allocate (below, source=[((j, j=1, p - 1), p=1, self%c)])
         return
      end if
      call graph(self, neighbor_first, neighbor)
      allocate (row(size(neighbor)/2), below(size(neighbor)/2))
      m = 0
      do p = 1, self%c
         j = self%order(p)
         do l = neighbor_first(j), neighbor_first(j + 1) - 1
            if (self%place(neighbor(l)) >= p) cycle
            m = m + 1
            row(m) = p
            below(m) = self%place(neighbor(l))
         end do
      end do
   end subroutine list_below

   !> Selects the rows of a matrix.
   subroutine select_rows(self, a, noise)
      !> The selection.
      class(row_selection_t), intent(inout) :: self
      !> The matrix, finite, laid out like that given to `init`.
      type(csr_t), intent(in) :: a
      !> Relative error of its rows, for want of a state that meets the constraints.
      real(wp), intent(in) :: noise
      integer :: k, p, round
      real(wp) :: least
      logical :: exchanged

      call scale_entries(self, a)
      least = with_noise(self%threshold, noise)
      self%kept(:) = .not. self%empty
      self%distance(:) = 0.0_wp
      call factorize(self, least, decide=.true.)
      self%settled(:) = .false.
      do round = 1, most_rounds
         exchanged = .false.
         if (all(self%kept .or. self%empty)) exit
         self%g(:) = 0.0_wp
         call exchange_rows(self, exchanged)
         if (.not. exchanged) exit
         call factorize(self, least, decide=.false.)
      end do
      ! An exchange may stop at the last round.
      if (exchanged) then
         do p = 1, self%c
            k = self%order(p)
            if (.not. (self%kept(k) .or. self%empty(k) .or. self%settled(k))) &
               call find_null_vector(self, k, self%c + 1, self%distance(k))
         end do
      end if
      self%rank = count(self%kept)
      if (self%rank < self%c) self%smallest_pivot = 0.0_wp
   end subroutine select_rows

   !> Of rows that are kept, leaves those out that may come to depend on the others on the way to another state: they have no more
   !! that others do not have than rows change on that way. What was selected before is forgotten.
   subroutine leave_out(self, a, there, kept)
      !> The selection.
      class(row_selection_t), intent(inout) :: self
      !> The matrix, finite.
      type(csr_t), intent(in) :: a
      !> The matrix at the other state.
      type(csr_t), intent(in) :: there
      !> The rows: (c).
      logical, intent(inout) :: kept(:)
      integer :: i, k
      real(wp) :: change, largest

      call scale_entries(self, a)
      largest = 0.0_wp
      do i = 1, self%c
         change = 0.0_wp
         do k = self%first(i), self%first(i + 1) - 1
            change = change + ((there%values(k) - a%values(k))*self%column_scale(self%column(k)))**2
         end do
         largest = max(largest, self%row_scale(i)*sqrt(change))
      end do
      self%kept(:) = kept .and. .not. self%empty
      call factorize(self, max(largest, sqrt(passed_pivot)), decide=.true.)
      kept(:) = self%kept
   end subroutine leave_out

   !> B = D_r A D_c.
   subroutine scale_entries(self, a)
      type(row_selection_t), intent(inout) :: self
      type(csr_t), intent(in) :: a
      !> A group that is this much smaller than the largest one holds nothing but round-off.
      real(wp), parameter :: nothing = 1.0e-12_wp
      real(wp), allocatable :: size_of(:)
      integer :: i, j, k
      real(wp) :: smallest

      self%column_scale(:) = 1.0_wp
      do k = 1, size(self%b)
         self%b(k) = a%values(k)
      end do
      call scale_rows(self)
      if (size(self%group) > 0) then
         allocate (size_of(maxval(self%group)), source=0.0_wp)
         do i = 1, self%c
            do k = self%first(i), self%first(i + 1) - 1
               j = self%group(self%column(k))
               size_of(j) = size_of(j) + (self%row_scale(i)*self%b(k))**2
            end do
         end do
         size_of(:) = sqrt(size_of)
         smallest = nothing*maxval(size_of)
         do j = 1, self%n
            if (size_of(self%group(j)) > 0.0_wp) self%column_scale(j) = 1.0_wp/max(size_of(self%group(j)), smallest)
         end do
         do k = 1, size(self%b)
            self%b(k) = self%b(k)*self%column_scale(self%column(k))
         end do
         call scale_rows(self)
      end if
      do i = 1, self%c
         do k = self%first(i), self%first(i + 1) - 1
            self%b(k) = self%row_scale(i)*self%b(k)
         end do
      end do
   end subroutine scale_entries

   !> 1 over the length of each row; rows of zeros are set aside.
   pure subroutine scale_rows(self)
      type(row_selection_t), intent(inout) :: self
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

   !> S = L D L^T of the rows that are kept; rows found to depend on those before them are left out if that is to be decided.
   subroutine factorize(self, least, decide)
      type(row_selection_t), intent(inout) :: self
      real(wp), intent(in) :: least
      logical, intent(in) :: decide
      integer :: e, i, k, l, p, row
      real(wp) :: d, distance, t

      call self%rest%clear()
      self%smallest_pivot = 1.0_wp
      self%replaced(:) = 0
      self%g(:) = 0.0_wp
      self%v(:) = 0.0_wp
      self%r(:) = 0.0_wp
      associate (f => self%factor)
         do p = 1, self%c
            row = self%order(p)
            f%reciprocal(p) = 0.0_wp
            ! Row p of S: what row p has in common with those before it.
            do k = self%first(row), self%first(row + 1) - 1
               do l = self%by_column(self%column(k)), self%by_column(self%column(k) + 1) - 1
                  i = self%place(self%row_of(l))
                  if (i < p) self%g(i) = self%g(i) + self%b(k)*self%b(self%entry_of(l))
               end do
            end do
            if (self%rest%number > 0) self%dense_row(self%column(self%first(row):self%first(row + 1) - 1)) = &
               self%b(self%first(row):self%first(row + 1) - 1)
            d = 1.0_wp
            do e = f%row_first(p), f%row_first(p + 1) - 1
               i = f%column(e)
               t = self%g(i)
               self%g(i) = 0.0_wp
               if (self%replaced(i) > 0) t = product_with(self, self%replaced(i))
               do k = f%first(i), f%place(e) - 1
                  self%g(f%row(k)) = self%g(f%row(k)) - f%l(k)*t
               end do
               f%l(f%place(e)) = t*f%reciprocal(i)
               d = d - t*f%l(f%place(e))
            end do
            if (self%rest%number > 0) self%dense_row(self%column(self%first(row):self%first(row + 1) - 1)) = 0.0_wp
            if (.not. self%kept(row)) cycle
            self%smallest_pivot = min(self%smallest_pivot, d)
            if (d <= doubtful_pivot) then
               call find_null_vector(self, row, p, distance)
               if (decide .and. distance <= least) then
                  self%kept(row) = .false.
                  self%distance(row) = distance
                  cycle
               end if
               ! What cancelled in the pivot and its column is replaced by what is left of the row itself.
               d = dot_product(self%r, self%r)
               call self%rest%append(self%r)
               self%replaced(p) = self%rest%number
            end if
            if (d > 0.0_wp) f%reciprocal(p) = 1.0_wp/d
         end do
      end associate
   end subroutine factorize

   !> The present row times one of the remainders.
   pure function product_with(self, number) result(t)
      type(row_selection_t), intent(in) :: self
      integer, intent(in) :: number
      real(wp) :: t
      integer :: k

      t = 0.0_wp
      do k = self%rest%first(number), self%rest%first(number + 1) - 1
         t = t + self%rest%value(k)*self%dense_row(self%rest%column(k))
      end do
   end function product_with

   !> v with v_k = 1 whose other entries, of kept rows before a place, make r = B^T v as small as can be; by places, in `v`.
   subroutine find_null_vector(self, k, before, distance)
      type(row_selection_t), intent(inout) :: self
      integer, intent(in) :: k, before
      real(wp), intent(out) :: distance
      integer, parameter :: refinements = 2
      integer :: round
      real(wp) :: last

      self%v(:) = 0.0_wp
      self%v(self%place(k)) = 1.0_wp
      call combine_rows(self)
      distance = 1.0_wp
      do round = 0, refinements
         ! What the kept rows have of r is taken off: v := v - S_KK^-1 B r.
         call share_rows(self, before, self%place(k))
         call solve_before(self, before)
         self%v(:) = self%v - self%g
         self%g(:) = 0.0_wp
         call combine_rows(self)
         last = distance
         distance = norm2(self%r)/norm2(self%v)
         if (round > 0 .and. distance > 0.5_wp*last) exit
      end do
   end subroutine find_null_vector

   !> r = B^T v.
   pure subroutine combine_rows(self)
      type(row_selection_t), intent(inout) :: self
      integer :: k, p, row

      self%r(:) = 0.0_wp
      do p = 1, self%c
         if (.not. abs(self%v(p)) > 0.0_wp) cycle
         row = self%order(p)
         do k = self%first(row), self%first(row + 1) - 1
            self%r(self%column(k)) = self%r(self%column(k)) + self%v(p)*self%b(k)
         end do
      end do
   end subroutine combine_rows

   !> g = B r for the kept rows before a place, but for one.
   pure subroutine share_rows(self, before, but)
      type(row_selection_t), intent(inout) :: self
      integer, intent(in) :: before, but
      integer :: j, l, p

      self%g(:) = 0.0_wp
      do j = 1, self%n
         if (.not. abs(self%r(j)) > 0.0_wp) cycle
         do l = self%by_column(j), self%by_column(j + 1) - 1
            p = self%place(self%row_of(l))
            if (p >= before .or. p == but) cycle
            if (self%factor%reciprocal(p) > 0.0_wp) self%g(p) = self%g(p) + self%b(self%entry_of(l))*self%r(j)
         end do
      end do
   end subroutine share_rows

   !> g := S^-1 g with the kept rows before a place; entries that are zero cost nothing.
   pure subroutine solve_before(self, before)
      type(row_selection_t), intent(inout) :: self
      integer, intent(in) :: before
      integer :: e, j, k, last

      last = min(before - 1, self%c)
      associate (f => self%factor)
         do j = 1, last
            if (.not. abs(self%g(j)) > 0.0_wp) cycle
            do k = f%first(j), f%first(j + 1) - 1
               if (f%row(k) > last) exit
               if (f%reciprocal(f%row(k)) > 0.0_wp) self%g(f%row(k)) = self%g(f%row(k)) - f%l(k)*self%g(j)
            end do
         end do
         do j = 1, last
            self%g(j) = self%g(j)*f%reciprocal(j)
         end do
         do j = last, 1, -1
            if (.not. abs(self%g(j)) > 0.0_wp) cycle
            do e = f%row_first(j), f%row_first(j + 1) - 1
               self%g(f%column(e)) = self%g(f%column(e)) - f%l(f%place(e))*self%g(j)
            end do
         end do
      end associate
   end subroutine solve_before

   !> Where the null vector of a row that is left out has an entry that is much larger than its own, those rows change places; at
   !! most one exchange for rows that hang together. A null vector is found anew only where a row that it needs has gone.
   subroutine exchange_rows(self, exchanged)
      type(row_selection_t), intent(inout) :: self
      logical, intent(out) :: exchanged
      logical, allocatable :: gone(:), left_out(:), touched(:)
      integer :: k, other, p

      exchanged = .false.
      allocate (gone(self%c), touched(self%c), source=.false.)
      allocate (left_out, source=.not. (self%kept .or. self%empty))
      do p = 1, self%c
         k = self%order(p)
         if (.not. left_out(k) .or. self%settled(k)) cycle
         call find_null_vector(self, k, self%c + 1, self%distance(k))
         self%support(k)%places = pack([(other, other=1, self%c)], abs(self%v) > 0.0_wp)
         if (any(touched(self%support(k)%places))) cycle
         other = maxloc(abs(self%v), 1)
         self%settled(k) = abs(self%v(other)) <= largest_share
         if (self%settled(k)) cycle
         touched(self%support(k)%places) = .true.
         gone(other) = .true.
         exchanged = .true.
         self%kept(k) = .true.
         self%distance(k) = 0.0_wp
         self%kept(self%order(other)) = .false.
      end do
      if (.not. exchanged) return
      do k = 1, self%c
         if (self%settled(k)) self%settled(k) = .not. any(gone(self%support(k)%places))
      end do
   end subroutine exchange_rows

   !> The null vector of a row that was left out: which multipliers of the kept rows make up for one of its own, in the rows'
   !! own units, so that A^T v is zero but for `distance`.
   subroutine null_vector(self, k, v)
      !> The selection, after `select`.
      class(row_selection_t), intent(inout) :: self
      !> The row.
      integer, intent(in) :: k
      !> The vector: (c).
      real(wp), intent(out), contiguous :: v(:)
      integer :: i
      real(wp) :: distance

      v(:) = 0.0_wp
      if (self%empty(k)) then
         v(k) = 1.0_wp
         return
      end if
      call find_null_vector(self, k, self%c + 1, distance)
      do i = 1, self%c
         v(i) = self%v(self%place(i))*self%row_scale(i)
      end do
   end subroutine null_vector

   !> Forgets all of them.
   subroutine remainders_clear(self)
      !> The list.
      class(remainders_t), intent(inout) :: self

      self%number = 0
      if (allocated(self%first)) return
      allocate (self%first, source=[1])
      allocate (self%column(0), self%value(0))
   end subroutine remainders_clear

   !> Appends the entries of a vector that are not zero.
   subroutine remainders_append(self, r)
      !> The list.
      class(remainders_t), intent(inout) :: self
      !> The vector.
      real(wp), intent(in), contiguous :: r(:)
      integer :: j, m

      m = 0
      if (self%number > 0) m = self%first(self%number + 1) - 1
      self%number = self%number + 1
      if (self%number + 1 > size(self%first)) self%first = [self%first, spread(0, 1, self%number + 8)]
      self%first(1) = 1
      if (m + count(abs(r) > 0.0_wp) > size(self%column)) then
         self%column = [self%column, spread(0, 1, m + count(abs(r) > 0.0_wp))]
         self%value = [self%value, spread(0.0_wp, 1, m + count(abs(r) > 0.0_wp))]
      end if
      do j = 1, size(r)
         if (.not. abs(r(j)) > 0.0_wp) cycle
         m = m + 1
         self%column(m) = j
         self%value(m) = r(j)
      end do
      self%first(self%number + 1) = m + 1
   end subroutine remainders_append

end module taut_linalg_row_selection
