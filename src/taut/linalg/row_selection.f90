!> Which rows of a constraint matrix are kept and which depend on them: one selection for all solvers.
!!
!! Whether rows depend on each other is a matter of geometry, and not of masses: it is decided on the scaled rows B, by
!! `taut_linalg_row_elimination`. A row that is left out in the order in which it came may be a bad choice: where an entry of its
!! null vector is much larger than 1, the row of that entry is left out instead.
module taut_linalg_row_selection
   use taut_kinds, only: wp
   use taut_linalg_arbitrary, only: arbitrary
   use taut_linalg_csr, only: csr_t
   use taut_linalg_rank, only: doubtful_pivot, exactly_dependent, independent, passed_pivot, weaker, with_noise
   use taut_linalg_row_elimination, only: row_elimination_t
   use taut_linalg_sparse_factor, only: sort
   implicit none (type, external)
   private
   public :: row_selection_t

   !> Rounds of exchanges: each null vector asks for less than one.
   integer, parameter :: most_rounds = 20

   !> The rows that are kept, and why the others are not.
   type, extends(row_elimination_t) :: row_selection_t
      !> How many are kept.
      integer :: rank = 0
      !> The smallest pivot of the rows that are kept.
      real(wp) :: smallest_kept = 0.0_wp
      !> What |B^T v|/|v| must exceed for a row to be kept.
      real(wp), private :: threshold = independent
      !> A motion: (n).
      real(wp), allocatable, private :: motion(:)
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

      call self%lay_out(a, c, group)
      if (rcond > 0.0_wp) self%threshold = rcond
      allocate (self%motion(a%n), source=0.0_wp)
      self%rank = c
   end subroutine init

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
      least = with_noise(self%threshold, noise*self%rows%stretched)
      self%kept(:) = .not. self%rows%empty
      self%distance(:) = 0.0_wp
      self%settled(:) = .false.
      call self%eliminate(least, decide=.true.)
      exchanged = .false.
      do round = 1, most_rounds
         call exchange_rows(self, exchanged)
         if (.not. exchanged) exit
         call self%eliminate(least, decide=.false.)
      end do
      ! An exchange may stop at the last round.
      if (exchanged) then
         do p = 1, self%c
            k = self%order(p)
            if (.not. (self%kept(k) .or. self%rows%empty(k) .or. self%settled(k))) &
               call self%find_null_vector(k, self%c + 1, self%distance(k))
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
      least = with_noise(self%threshold, noise*self%rows%stretched)
      self%kept(:) = kept
      confirmed = .not. any(kept .and. self%rows%empty)
      if (.not. confirmed) return
      self%distance(:) = 0.0_wp
      call self%eliminate(least, decide=.true.)
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
         self%motion(j) = arbitrary(j)
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
      integer :: i
      real(wp) :: largest

      call self%rows%scale(a)
      largest = 0.0_wp
      do i = 1, self%c
         largest = max(largest, self%rows%length_of_change(i, a, there))
      end do
      self%kept(:) = kept .and. .not. self%rows%empty
      call self%eliminate(max(largest, sqrt(passed_pivot)), decide=.true.)
      kept(:) = self%kept
   end subroutine leave_out

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
         call self%find_null_vector(k, self%c + 1, self%distance(k))
         call self%settle(k)
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
      call self%find_null_vector(k, self%c + 1, distance)
      row = self%order(self%v%place(:self%v%number))
      call sort(row)
      value = [(self%v%value(self%place(row(i)))*self%rows%row_scale(row(i)), i=1, size(row))]
   end subroutine null_vector

end module taut_linalg_row_selection
