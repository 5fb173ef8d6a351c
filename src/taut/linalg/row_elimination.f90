!> Rows of a constraint matrix that depend on those before them, and their null vectors.
!!
!! Of the scaled rows B, S = B B^T = L D L^T row by row; a small pivot is only a reason for doubt, as its error grows with the
!! square of the null vector. A doubtful row k is looked at in the space of B: with v its null vector, v_k = 1 and the others from
!! L^T v = e_k, made exact through B, r = B^T v is what the row has that the others do not, and |r|/|v| bounds the smallest
!! singular value from above, not squared.
!!
!! Null vectors reach as far as the loop of joints that they belong to, and what is done with them costs no more: the work is
!! linear in the number of loops.
module taut_linalg_row_elimination
   use taut_kinds, only: wp
   use taut_linalg_csr, only: csr_t
   use taut_linalg_ordering, only: minimum_degree
   use taut_linalg_rank, only: doubtful_pivot, exactly_dependent, largest_share, most_refinements, negligible
   use taut_linalg_scaled_rows, only: scaled_rows_t
   use taut_linalg_sparse_factor, only: sparse_factor_t
   use taut_linalg_sparse_vector, only: sparse_vector_t
   implicit none (type, external)
   private
   public :: row_elimination_t

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

   !> The rows that are kept, and what those left out depend on.
   type :: row_elimination_t
      !> Rows.
      integer :: c = 0
      !> The rows, scaled.
      type(scaled_rows_t) :: rows
      !> Whether a row is kept: (c).
      logical, allocatable :: kept(:)
      !> Of rows that are left out, how far they are from depending on the others exactly: |B^T v|/|v|, (c). Zero for the others.
      real(wp), allocatable :: distance(:)
      !> The smallest pivot of the rows that are kept.
      real(wp) :: smallest_pivot = 0.0_wp
      !> The order in which rows come, and the place of each: (c).
      integer, allocatable :: order(:), place(:)
      !> The entries of B column by column, as `rows` lists them, but in that order: the place of the row of each, and where it is.
      integer, allocatable, private :: place_of(:), entry_of(:)
      !> The null vector that was found last, by places.
      type(sparse_vector_t) :: v
      !> Of rows that are left out: whether the null vector asks for no exchange, and where it is not zero: (c).
      logical, allocatable :: settled(:)
      type(support_t), allocatable :: support(:)
      !> L and D.
      type(sparse_factor_t) :: factor
      !> A row of B, what is left of a row of S: (n), (c).
      real(wp), allocatable, private :: dense_row(:)
      real(wp), allocatable :: y(:)
      !> B^T v by columns; B r and the way to a better v by places.
      type(sparse_vector_t), private :: r, g, along
      !> For each place the number of what the row there has that others do not, where that replaces its column of L D.
      integer, allocatable, private :: replaced(:)
      type(remainders_t), private :: rest
   contains
      procedure :: lay_out
      procedure :: eliminate
      procedure :: find_null_vector
      procedure :: settle
   end type row_elimination_t

contains

   !> Finds an ordering of the rows of a pattern; nothing of its sizes is allocated afterwards.
   subroutine lay_out(self, a, c, group)
      !> The rows.
      class(row_elimination_t), intent(inout) :: self
      !> A matrix with the pattern of A.
      type(csr_t), intent(in) :: a
      !> How many of its rows are used, from the first one on.
      integer, intent(in) :: c
      !> Which columns are measured in the same unit: the number of its group for each, from 1 on, (n); or none, if all are.
      integer, intent(in) :: group(:)
      integer, allocatable :: below(:), neighbor(:), neighbor_first(:), row(:)
      integer :: i, j

      self%c = c
      call self%rows%init(a, c, group)
      allocate (self%order(c), self%place(c), self%replaced(c), source=0)
      if (a%full) then
         self%order = [(i, i=1, c)]
         allocate (row, source=[((i, j=1, i - 1), i=1, c)])
         allocate (below, source=[((j, j=1, i - 1), i=1, c)])
      else
         call self%rows%graph(neighbor_first, neighbor)
         call find_order(self%rows, neighbor_first, neighbor, self%order)
      end if
      do i = 1, c
         self%place(self%order(i)) = i
      end do
      call list_in_order(self)
      if (.not. a%full) call list_below(self, neighbor_first, neighbor, row, below)
      call self%factor%init(c, row, below)
      allocate (self%kept(c), source=.true.)
      allocate (self%settled(c), source=.false.)
      allocate (self%support(c))
      allocate (self%dense_row(a%n), self%y(c), self%distance(c), source=0.0_wp)
      call self%r%init(a%n)
      call self%v%init(c)
      call self%g%init(c)
      call self%along%init(c)
      call self%rest%clear()
   end subroutine lay_out

   !> Rows whose neighbors are neighbors of each other already come first, the others by minimum degree.
   !!
   !! The first fill nothing in, whatever the others are. Joints to the ground are among them and kept thereby, so that loops close
   !! where they are short.
   subroutine find_order(rows, neighbor_first, neighbor, order)
      type(scaled_rows_t), intent(in) :: rows
      integer, intent(in) :: neighbor_first(:), neighbor(:)
      integer, intent(out) :: order(:)
      integer, allocatable :: first(:), number(:), of(:), other(:), sub_order(:)
      integer :: i, k, m, placed

      allocate (number(rows%c), source=0)
      placed = 0
      do i = 1, rows%c
         m = neighbor_first(i + 1) - neighbor_first(i) + 1
         do k = rows%first(i), rows%first(i + 1) - 1
            ! All of them meet in one column.
            if (rows%by_column(rows%column(k) + 1) - rows%by_column(rows%column(k)) == m) then
               placed = placed + 1
               order(placed) = i
               number(i) = -1
               exit
            end if
         end do
      end do
      other = pack([(i, i=1, rows%c)], number == 0)
      number(other) = [(i, i=1, size(other))]
      allocate (first(size(other) + 1), of(size(neighbor)), sub_order(size(other)), source=0)
      m = 0
      do i = 1, size(other)
         first(i) = m + 1
         do k = neighbor_first(other(i)), neighbor_first(other(i) + 1) - 1
            if (number(neighbor(k)) < 0) cycle
            m = m + 1
            of(m) = number(neighbor(k))
         end do
      end do
      first(size(other) + 1) = m + 1
      call minimum_degree(first, of(:m), sub_order)
      order(placed + 1:) = other(sub_order)
   end subroutine find_order

   !> The entries of B column by column in the order in which their rows come.
   subroutine list_in_order(self)
      class(row_elimination_t), intent(inout) :: self
      integer, allocatable :: next(:)
      integer :: j, k, p

      associate (rows => self%rows)
         allocate (self%place_of(size(rows%column)), self%entry_of(size(rows%column)), source=0)
         allocate (next, source=rows%by_column)
         do p = 1, self%c
            do k = rows%first(self%order(p)), rows%first(self%order(p) + 1) - 1
               j = rows%column(k)
               self%place_of(next(j)) = p
               self%entry_of(next(j)) = k
               next(j) = next(j) + 1
            end do
         end do
      end associate
   end subroutine list_in_order

   !> The entries of S below the diagonal, as places of the ordering, row by row.
   subroutine list_below(self, neighbor_first, neighbor, row, below)
      type(row_elimination_t), intent(in) :: self
      integer, intent(in) :: neighbor_first(:), neighbor(:)
      integer, allocatable, intent(out) :: row(:), below(:)
      integer :: j, l, m, p

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

   !> S = L D L^T of the rows that are kept; rows found to depend on those before them are left out if that is to be decided.
   subroutine eliminate(self, least, decide)
      !> The rows, scaled, those that are kept as they are to be tried.
      class(row_elimination_t), intent(inout) :: self
      !> What |B^T v|/|v| must exceed for a row to be kept.
      real(wp), intent(in) :: least
      !> Whether rows are left out.
      logical, intent(in) :: decide
      integer :: e, i, k, p, row
      real(wp) :: d, distance, t

      call self%rest%clear()
      self%smallest_pivot = 1.0_wp
      self%replaced(:) = 0
      self%y(:) = 0.0_wp
      associate (f => self%factor, rows => self%rows)
         do p = 1, self%c
            row = self%order(p)
            f%reciprocal(p) = 0.0_wp
            ! Row p of S: what row p has in common with those before it.
            call multiply_before(p, rows%first(row), rows%first(row + 1) - 1, rows%column, rows%by_column, self%place_of, &
                                 self%entry_of, rows%b, self%y)
            if (self%rest%number > 0) self%dense_row(rows%column(rows%first(row):rows%first(row + 1) - 1)) = &
               rows%b(rows%first(row):rows%first(row + 1) - 1)
            d = 1.0_wp
            do e = f%row_first(p), f%row_first(p + 1) - 1
               i = f%column(e)
               t = self%y(i)
               self%y(i) = 0.0_wp
               if (self%replaced(i) > 0) t = product_with(self, self%replaced(i))
               do k = f%first(i), f%place(e) - 1
                  self%y(f%row(k)) = self%y(f%row(k)) - f%l(k)*t
               end do
               f%l(f%place(e)) = t*f%reciprocal(i)
               d = d - t*f%l(f%place(e))
            end do
            if (self%rest%number > 0) self%dense_row(rows%column(rows%first(row):rows%first(row + 1) - 1)) = 0.0_wp
            if (.not. self%kept(row)) cycle
            if (d <= doubtful_pivot) then
               call self%find_null_vector(row, p, distance)
               if (decide .and. distance <= least) then
                  self%kept(row) = .false.
                  self%distance(row) = distance
                  ! The vector is the same for all rows that are kept, but where nothing is exact.
                  if (distance <= exactly_dependent) call self%settle(row)
                  cycle
               end if
               ! What cancelled in the pivot and its column is replaced by what is left of the row itself.
               d = self%r%norm()**2
               call self%rest%append(self%r)
               self%replaced(p) = self%rest%number
            end if
            self%smallest_pivot = min(self%smallest_pivot, d)
            if (d > 0.0_wp) f%reciprocal(p) = 1.0_wp/d
         end do
      end associate
   end subroutine eliminate

   !> y := B b for the rows before a place, with b the row whose entries are from `begin` to `last`.
   pure subroutine multiply_before(p, begin, last, column, by_column, place_of, entry_of, b, y)
      integer, intent(in) :: p, begin, last, column(*), by_column(*), place_of(*), entry_of(*)
      real(wp), intent(in) :: b(*)
      real(wp), intent(inout) :: y(*)
      integer :: k, l

      do k = begin, last
         do l = by_column(column(k)), by_column(column(k) + 1) - 1
            if (place_of(l) >= p) exit
            y(place_of(l)) = y(place_of(l)) + b(k)*b(entry_of(l))
         end do
      end do
   end subroutine multiply_before

   !> The present row times one of the remainders.
   pure function product_with(self, number) result(t)
      type(row_elimination_t), intent(in) :: self
      integer, intent(in) :: number
      real(wp) :: t
      integer :: k

      t = 0.0_wp
      do k = self%rest%first(number), self%rest%first(number + 1) - 1
         t = t + self%rest%value(k)*self%dense_row(self%rest%column(k))
      end do
   end function product_with

   !> v with v_k = 1 whose other entries, of kept rows before a place, make r = B^T v as small as can be; by places, in `v`.
   !!
   !! By conjugate gradients, with S as it is factorized to precondition S as it is: the two differ in the few directions that
   !! round-off has hidden in S, and not in B. Each step finds one of them; where there is none, the first does it all.
   subroutine find_null_vector(self, k, before, distance)
      !> The rows, eliminated.
      class(row_elimination_t), intent(inout) :: self
      !> The row.
      integer, intent(in) :: k
      !> Places from this one on are zero, but that of the row.
      integer, intent(in) :: before
      !> |B^T v|/|v|.
      real(wp), intent(out) :: distance
      integer :: i, round
      real(wp) :: far, last, left, length, rest, rest_before

      call self%v%clear()
      call self%v%add(self%place(k), 1.0_wp)
      call combine_rows(self%rows, self%order, self%v, self%r)
      distance = 1.0_wp
      length = 1.0_wp
      rest = 1.0_wp
      do round = 0, most_refinements
         ! What the kept rows have of r is taken off: v := v - S_KK^-1 B r.
         left = negligible*distance*length
         rest_before = rest
         call share_rows(self, before, self%place(k), left)
         call solve_before(self, before, left, negligible*length, rest)
         if (round == 0) then
            call subtract(self%g, 1.0_wp)
         else
            call self%along%scale(rest/rest_before)
            do i = 1, self%g%number
               call self%along%add(self%g%place(i), self%g%value(self%g%place(i)))
            end do
            call combine_rows(self%rows, self%order, self%along, self%r)
            far = self%r%norm()**2
            if (.not. far > 0.0_wp) exit
            call subtract(self%along, rest/far)
         end if
         call combine_rows(self%rows, self%order, self%v, self%r)
         last = distance
         length = self%v%norm()
         distance = self%r%norm()/length
         if (distance <= negligible .or. (round > 0 .and. distance > 0.5_wp*last)) exit
         if (round == 0) call self%along%take(self%g)
      end do

   contains

      !> v := v - far way, but for what is round-off.
      subroutine subtract(way, far)
         type(sparse_vector_t), intent(in) :: way
         real(wp), intent(in) :: far
         integer :: j

         do j = 1, way%number
            associate (p => way%place(j))
               if (abs(far*way%value(p)) > negligible*length) call self%v%add(p, -far*way%value(p))
            end associate
         end do
      end subroutine subtract

   end subroutine find_null_vector

   !> r = B^T v.
   pure subroutine combine_rows(rows, order, v, r)
      type(scaled_rows_t), intent(in) :: rows
      integer, intent(in) :: order(:)
      type(sparse_vector_t), intent(in) :: v
      type(sparse_vector_t), intent(inout) :: r
      integer :: i, k, p, row

      call r%clear()
      do i = 1, v%number
         p = v%place(i)
         row = order(p)
         do k = rows%first(row), rows%first(row + 1) - 1
            call r%add(rows%column(k), v%value(p)*rows%b(k))
         end do
      end do
   end subroutine combine_rows

   !> g = B r for the kept rows before a place, but for one; entries of r up to a size count as zero.
   pure subroutine share_rows(self, before, but, least)
      type(row_elimination_t), intent(inout) :: self
      integer, intent(in) :: before, but
      real(wp), intent(in) :: least
      integer :: i, j, l, p

      call self%g%clear()
      do i = 1, self%r%number
         j = self%r%place(i)
         if (abs(self%r%value(j)) <= least) cycle
         do l = self%rows%by_column(j), self%rows%by_column(j + 1) - 1
            p = self%place(self%rows%row_of(l))
            if (p >= before .or. p == but) cycle
            if (self%factor%reciprocal(p) > 0.0_wp) call self%g%add(p, self%rows%b(self%rows%entry_of(l))*self%r%value(j))
         end do
      end do
   end subroutine share_rows

   !> g := S^-1 g with the kept rows before a place. Entries up to a size, of g and of what becomes of it, count as zero: they add
   !! no more to what is left of a row than round-off does, and without them the work ends where the null vector ends.
   pure subroutine solve_before(self, before, least_given, least_found, rest)
      type(row_elimination_t), intent(inout) :: self
      integer, intent(in) :: before
      real(wp), intent(in) :: least_given, least_found
      !> g S^-1 g.
      real(wp), intent(out) :: rest
      integer :: e, i, j, k, last
      real(wp) :: t

      last = min(before - 1, self%c)
      associate (f => self%factor, g => self%g)
         call g%queue_up(1)
         do
            call g%take_next(j)
            if (j == 0) exit
            t = g%value(j)
            if (abs(t) <= least_given) cycle
            do k = f%first(j), f%first(j + 1) - 1
               if (f%row(k) > last) exit
               if (f%reciprocal(f%row(k)) > 0.0_wp) call g%reach(f%row(k), -f%l(k)*t, 1)
            end do
         end do
         rest = 0.0_wp
         do i = 1, g%number
            t = g%value(g%place(i))
            g%value(g%place(i)) = t*f%reciprocal(g%place(i))
            rest = rest + t*g%value(g%place(i))
         end do
         call g%queue_up(-1)
         do
            call g%take_next(j)
            if (j == 0) exit
            t = g%value(j)
            if (abs(t) <= least_found) cycle
            do e = f%row_first(j), f%row_first(j + 1) - 1
               if (f%reciprocal(f%column(e)) > 0.0_wp) call g%reach(f%column(e), -f%l(f%place(e))*t, -1)
            end do
         end do
      end associate
   end subroutine solve_before

   !> Notes of the null vector of a row that is left out where it is not zero, and whether it asks for an exchange.
   subroutine settle(self, k)
      !> The rows.
      class(row_elimination_t), intent(inout) :: self
      !> The row, of which the null vector was found last.
      integer, intent(in) :: k

      self%support(k)%places = self%v%place(:self%v%number)
      self%settled(k) = abs(self%v%value(self%v%largest())) <= largest_share
   end subroutine settle

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
      type(sparse_vector_t), intent(in) :: r
      integer :: i, m

      m = 0
      if (self%number > 0) m = self%first(self%number + 1) - 1
      self%number = self%number + 1
      if (self%number + 1 > size(self%first)) self%first = [self%first, spread(0, 1, self%number + 8)]
      self%first(1) = 1
      if (m + r%number > size(self%column)) then
         self%column = [self%column, spread(0, 1, m + r%number)]
         self%value = [self%value, spread(0.0_wp, 1, m + r%number)]
      end if
      do i = 1, r%number
         self%column(m + i) = r%place(i)
         self%value(m + i) = r%value(r%place(i))
      end do
      self%first(self%number + 1) = m + r%number + 1
   end subroutine remainders_append

end module taut_linalg_row_elimination
