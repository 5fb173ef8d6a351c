!> Which rows of a constraint matrix are kept and which depend on them: one selection for all solvers.
!!
!! Whether rows depend on each other is a matter of geometry, and not of masses: it is decided on the scaled rows B. S = B B^T =
!! L D L^T row by row; a small pivot is only a reason for doubt, as its error grows with the square of the null vector. A doubtful
!! row k is looked at in the space of B: with v its null vector, v_k = 1 and the others from L^T v = e_k, made exact through B,
!! r = B^T v is what the row has that the others do not, and |r|/|v| bounds the smallest singular value from above, not squared.
!!
!! A row that is left out in the order in which it came may be a bad choice: where an entry of v is much larger than 1, the row
!! of that entry is left out instead.
!!
!! Null vectors reach as far as the loop of joints that they belong to, and what is done with them costs no more: the work is
!! linear in the number of loops.
module taut_linalg_row_selection
   use taut_kinds, only: wp
   use taut_linalg_csr, only: csr_t
   use taut_linalg_ordering, only: minimum_degree
   use taut_linalg_rank, only: doubtful_pivot, exactly_dependent, independent, largest_share, negligible, passed_pivot, weaker, &
                               with_noise
   use taut_linalg_scaled_rows, only: scaled_rows_t
   use taut_linalg_sparse_factor, only: sort, sparse_factor_t
   use taut_linalg_sparse_vector, only: sparse_vector_t
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
      !> Rows, and how many are kept.
      integer :: c = 0, rank = 0
      !> The rows, scaled.
      type(scaled_rows_t) :: rows
      !> Whether a row is kept: (c).
      logical, allocatable :: kept(:)
      !> Of rows that are left out, how far they are from depending on the others exactly: |B^T v|/|v|, (c). Zero for the others.
      real(wp), allocatable :: distance(:)
      !> The smallest pivot in the order of selection, of all rows; 0 if one was left out.
      real(wp) :: smallest_pivot = 0.0_wp
      !> The smallest pivot of the rows that are kept.
      real(wp) :: smallest_kept = 0.0_wp
      !> What |B^T v|/|v| must exceed for a row to be kept.
      real(wp), private :: threshold = independent
      integer, allocatable, private :: order(:), place(:)
      !> A row of B, what is left of a row of S, a motion: (n), (c), (n).
      real(wp), allocatable, private :: dense_row(:), y(:), motion(:)
      !> B^T v by columns, v and B r by places.
      type(sparse_vector_t), private :: r, v, g
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
      procedure :: confirm
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
      integer, allocatable :: below(:), neighbor(:), neighbor_first(:), row(:)
      integer :: i, j

      self%c = c
      if (rcond > 0.0_wp) self%threshold = rcond
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
      if (.not. a%full) call list_below(self, neighbor_first, neighbor, row, below)
      call self%factor%init(c, row, below)
      allocate (self%kept(c), source=.true.)
      allocate (self%settled(c), source=.false.)
      allocate (self%support(c))
      allocate (self%dense_row(a%n), self%motion(a%n), self%y(c), self%distance(c), source=0.0_wp)
      call self%r%init(a%n)
      call self%v%init(c)
      call self%g%init(c)
      self%rank = c
      call self%rest%clear()
   end subroutine init

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

   !> The entries of S below the diagonal, as places of the ordering, row by row.
   subroutine list_below(self, neighbor_first, neighbor, row, below)
      type(row_selection_t), intent(in) :: self
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

      call self%rows%scale(a)
      least = with_noise(self%threshold, noise)
      self%kept(:) = .not. self%rows%empty
      self%distance(:) = 0.0_wp
      self%settled(:) = .false.
      call factorize(self, least, decide=.true.)
      exchanged = .false.
      do round = 1, most_rounds
         call exchange_rows(self, exchanged)
         if (.not. exchanged) exit
         call factorize(self, least, decide=.false.)
      end do
      ! An exchange may stop at the last round.
      if (exchanged) then
         do p = 1, self%c
            k = self%order(p)
            if (.not. (self%kept(k) .or. self%rows%empty(k) .or. self%settled(k))) &
               call find_null_vector(self, k, self%c + 1, self%distance(k))
         end do
      end if
      self%rank = count(self%kept)
      self%smallest_kept = self%smallest_pivot
      if (self%rank < self%c) self%smallest_pivot = 0.0_wp
   end subroutine select_rows

   !> Whether rows that were selected elsewhere are as good a choice for a matrix; if so, they are the selection.
   !!
   !! They are if all of them are still independent, none much weaker than where they were selected, and if a motion that they
   !! allow does not violate the others.
   subroutine confirm(self, a, noise, kept, weakest, confirmed)
      !> The selection.
      class(row_selection_t), intent(inout) :: self
      !> The matrix, finite, laid out like that given to `init`.
      type(csr_t), intent(in) :: a
      !> Relative error of its rows, for want of a state that meets the constraints.
      real(wp), intent(in) :: noise
      !> The rows: (c).
      logical, intent(in) :: kept(:)
      !> `smallest_kept` where they were selected.
      real(wp), intent(in) :: weakest
      !> Whether they are.
      logical, intent(out) :: confirmed
      real(wp) :: least

      call self%rows%scale(a)
      least = with_noise(self%threshold, noise)
      self%kept(:) = kept
      confirmed = .not. any(kept .and. self%rows%empty)
      if (.not. confirmed) return
      self%distance(:) = 0.0_wp
      call factorize(self, least, decide=.true.)
      confirmed = all(self%kept .eqv. kept) .and. self%smallest_pivot > min(doubtful_pivot, weaker*weakest)
      if (.not. confirmed) return
      self%rank = count(kept)
      self%smallest_kept = self%smallest_pivot
      if (self%rank == self%c) return
      self%smallest_pivot = 0.0_wp
      confirmed = largest_slip(self) <= least
   end subroutine confirm

   !> By how much a motion that the kept rows allow violates the others: the largest |b_i z|/|z|.
   function largest_slip(self) result(largest)
      type(row_selection_t), intent(inout) :: self
      real(wp) :: largest
      integer, parameter :: passes = 2
      real(wp) :: before, slip
      integer :: i, j, k, p, pass

      ! Any motion will do that has a part in all directions.
      do j = 1, self%rows%n
         self%motion(j) = sin(real(j, wp)**2)
      end do
      before = norm2(self%motion)
      do pass = 1, passes
         do p = 1, self%c
            i = self%order(p)
            self%y(p) = 0.0_wp
            if (self%kept(i)) self%y(p) = product_of_row(i)
         end do
         call self%factor%solve(self%y)
         do p = 1, self%c
            i = self%order(p)
            if (.not. self%kept(i)) cycle
            do k = self%rows%first(i), self%rows%first(i + 1) - 1
               j = self%rows%column(k)
               self%motion(j) = self%motion(j) - self%rows%b(k)*self%y(p)
            end do
         end do
      end do
      self%y(:) = 0.0_wp
      largest = 0.0_wp
      do i = 1, self%c
         if (self%kept(i) .or. self%rows%empty(i)) cycle
         slip = abs(product_of_row(i))
         largest = max(largest, slip)
      end do
      ! Where no motion is left, there is nothing but round-off.
      largest = largest/max(norm2(self%motion), exactly_dependent*before)

   contains

      pure real(wp) function product_of_row(i)
         integer, intent(in) :: i
         integer :: k

         product_of_row = 0.0_wp
         do k = self%rows%first(i), self%rows%first(i + 1) - 1
            product_of_row = product_of_row + self%rows%b(k)*self%motion(self%rows%column(k))
         end do
      end function product_of_row

   end function largest_slip

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

      call self%rows%scale(a)
      largest = 0.0_wp
      do i = 1, self%c
         change = 0.0_wp
         do k = self%rows%first(i), self%rows%first(i + 1) - 1
            change = change + ((there%values(k) - a%values(k))*self%rows%column_scale(self%rows%column(k)))**2
         end do
         largest = max(largest, self%rows%row_scale(i)*sqrt(change))
      end do
      self%kept(:) = kept .and. .not. self%rows%empty
      call factorize(self, max(largest, sqrt(passed_pivot)), decide=.true.)
      kept(:) = self%kept
   end subroutine leave_out

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
      self%y(:) = 0.0_wp
      associate (f => self%factor, rows => self%rows)
         do p = 1, self%c
            row = self%order(p)
            f%reciprocal(p) = 0.0_wp
            ! Row p of S: what row p has in common with those before it.
            do k = rows%first(row), rows%first(row + 1) - 1
               do l = rows%by_column(rows%column(k)), rows%by_column(rows%column(k) + 1) - 1
                  i = self%place(rows%row_of(l))
                  if (i < p) self%y(i) = self%y(i) + rows%b(k)*rows%b(rows%entry_of(l))
               end do
            end do
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
               call find_null_vector(self, row, p, distance)
               if (decide .and. distance <= least) then
                  self%kept(row) = .false.
                  self%distance(row) = distance
                  ! The vector is the same for all rows that are kept, but where nothing is exact.
                  if (distance <= exactly_dependent) call settle(self, row)
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
      integer :: i, round
      real(wp) :: last, length, left

      call self%v%clear()
      call self%v%add(self%place(k), 1.0_wp)
      call combine_rows(self)
      distance = 1.0_wp
      length = 1.0_wp
      do round = 0, refinements
         ! What the kept rows have of r is taken off: v := v - S_KK^-1 B r.
         left = negligible*distance*length
         call share_rows(self, before, self%place(k), left)
         call solve_before(self, before, left, negligible*length)
         do i = 1, self%g%number
            associate (p => self%g%place(i))
               if (abs(self%g%value(p)) > negligible*length) call self%v%add(p, -self%g%value(p))
            end associate
         end do
         call combine_rows(self)
         last = distance
         length = self%v%norm()
         distance = self%r%norm()/length
         if (distance <= negligible .or. (round > 0 .and. distance > 0.5_wp*last)) exit
      end do
   end subroutine find_null_vector

   !> r = B^T v.
   pure subroutine combine_rows(self)
      type(row_selection_t), intent(inout) :: self
      integer :: i, k, p, row

      call self%r%clear()
      do i = 1, self%v%number
         p = self%v%place(i)
         row = self%order(p)
         do k = self%rows%first(row), self%rows%first(row + 1) - 1
            call self%r%add(self%rows%column(k), self%v%value(p)*self%rows%b(k))
         end do
      end do
   end subroutine combine_rows

   !> g = B r for the kept rows before a place, but for one; entries of r up to a size count as zero.
   pure subroutine share_rows(self, before, but, least)
      type(row_selection_t), intent(inout) :: self
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
   pure subroutine solve_before(self, before, least_given, least_found)
      type(row_selection_t), intent(inout) :: self
      integer, intent(in) :: before
      real(wp), intent(in) :: least_given, least_found
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
         do i = 1, g%number
            g%value(g%place(i)) = g%value(g%place(i))*f%reciprocal(g%place(i))
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
      type(row_selection_t), intent(inout) :: self
      integer, intent(in) :: k

      self%support(k)%places = self%v%place(:self%v%number)
      self%settled(k) = abs(self%v%value(self%v%largest())) <= largest_share
   end subroutine settle

   !> Where the null vector of a row that is left out has an entry that is much larger than its own, those rows change places; at
   !! most one exchange for rows that hang together. A null vector is found anew only where a row that it needs has gone.
   subroutine exchange_rows(self, exchanged)
      type(row_selection_t), intent(inout) :: self
      logical, intent(out) :: exchanged
      logical, allocatable :: gone(:), left_out(:), touched(:)
      integer :: k, other, p

      exchanged = .false.
      if (all(self%kept .or. self%rows%empty .or. self%settled)) return
      allocate (left_out, source=.not. (self%kept .or. self%rows%empty .or. self%settled))
      allocate (gone(self%c), touched(self%c), source=.false.)
      do p = 1, self%c
         k = self%order(p)
         if (.not. left_out(k)) cycle
         call find_null_vector(self, k, self%c + 1, self%distance(k))
         call settle(self, k)
         if (self%settled(k)) cycle
         if (any(touched(self%support(k)%places))) cycle
         other = self%v%largest()
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
   subroutine null_vector(self, k, row, value)
      !> The selection, after `select`.
      class(row_selection_t), intent(inout) :: self
      !> The row.
      integer, intent(in) :: k
      !> Rows of its entries that are not zero, ascending.
      integer, allocatable, intent(out) :: row(:)
      !> The entries.
      real(wp), allocatable, intent(out) :: value(:)
      integer :: i
      real(wp) :: distance

      if (self%rows%empty(k)) then
         row = [k]
         value = [1.0_wp]
         return
      end if
      call find_null_vector(self, k, self%c + 1, distance)
      row = self%order(self%v%place(:self%v%number))
      call sort(row)
      value = [(self%v%value(self%place(row(i)))*self%rows%row_scale(row(i)), i=1, size(row))]
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

end module taut_linalg_row_selection
