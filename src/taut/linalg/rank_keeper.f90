!> Carries the decision on the rank along a motion: it is taken where a step is accepted, and holds in between.
!!
!! At a dead point, where a mechanism is stretched, rows depend on each other for a moment: the rank falls in the formula and
!! not in the mechanism. The rows that were independent before stay in charge; another selection is made where they stay
!! dependent, where they have become a poor choice, and where rows that were left out turn out to be violated by motions that
!! those in charge allow.
module taut_linalg_rank_keeper
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_kinds, only: wp
   use taut_linalg_arbitrary, only: arbitrary
   use taut_linalg_csr, only: csr_t
   use taut_linalg_normal_solver, only: normal_solver_t
   use taut_linalg_rank, only: above_violation, dead_pivot, dead_steps, doubtful_pivot, exactly_dependent, rising_steps, &
                               seen_rising, weak_pivot, weaker
   use taut_linalg_row_selection, only: row_selection_t
   implicit none (type, external)
   private
   public :: rank_keeper_t

   !> Which rows are in charge.
   type :: rank_keeper_t
      !> The last selection.
      type(row_selection_t) :: selection
      !> Whether it holds, or is asked for anew wherever it is needed; counts selections that differ from the one before.
      logical :: holds = .false.
      integer :: revision = 0
      !> Whether rows that were in charge are to be tried before others are looked for.
      logical :: trusted = .false.
      !> The rows: (c).
      logical, allocatable :: kept(:)
      !> Accepted steps at a dead point, and with rows left out that are violated.
      integer :: dead = 0, rising = 0
      !> The smallest pivot after the last selection; negative: not known yet.
      real(wp) :: first_pivot = -1.0_wp
      !> Changes of the rank so far: time [s], rank before and after, a row that has come or gone, one column each (4, changes).
      real(wp), allocatable :: changes(:, :)
      !> Rank of what held before it was let go; negative: nothing did.
      integer :: rank_before = -1
      !> The rows in charge at the last look, before one those that were selected first: (c); their smallest pivot.
      logical, allocatable :: kept_before(:)
      real(wp) :: pivot_before = 1.0_wp
      !> A motion, projected on what the rows in charge allow: (n); workspace: (c).
      real(wp), allocatable, private :: probe(:), r(:), lambda(:), zero(:)
   contains
      procedure :: init
      procedure :: decide
      procedure :: hand_over
      procedure :: prepare
      procedure :: look
      procedure :: release
      procedure :: restore
   end type rank_keeper_t

contains

   !> Makes room; nothing holds.
   subroutine init(self, a, c, group, rcond)
      !> The keeper.
      class(rank_keeper_t), intent(out) :: self
      !> A matrix with the pattern of A.
      type(csr_t), intent(in) :: a
      !> How many of its rows are used, from the first one on.
      integer, intent(in) :: c
      !> Groups of columns, see `init` of `row_selection_t`.
      integer, intent(in) :: group(:)
      !> Relative size of what a row must have that others do not; 0 for the default.
      real(wp), intent(in) :: rcond

      allocate (self%kept(c), self%kept_before(c), source=.true.)
      allocate (self%changes(4, 0))
      call self%selection%init(a, c, group, rcond)
      allocate (self%probe(a%n), self%r(c), self%lambda(c), self%zero(c), source=0.0_wp)
   end subroutine init

   !> Decides on the rows of a matrix, where no selection holds: those in charge at the last look if they still are a good choice,
   !! so that little is done where rows are redundant, else a new selection.
   !!
   !! Where all rows are clearly independent, at a state that meets the constraints, that holds: it is so everywhere but at dead
   !! points.
   subroutine decide(self, a, noise)
      !> The keeper.
      class(rank_keeper_t), intent(inout) :: self
      !> The matrix, finite.
      type(csr_t), intent(in) :: a
      !> Relative error of its rows, for want of a state that meets the constraints.
      real(wp), intent(in) :: noise
      logical :: confirmed

      ! Of what is not finite, its solver complains.
      if (.not. is_finite(self, a)) return
      confirmed = .false.
      if (self%trusted) call self%selection%confirm(a, noise, self%kept_before, self%pivot_before, confirmed)
      if (.not. confirmed) call self%selection%select(a, noise)
      call put_in_charge(self)
      self%holds = self%selection%smallest_pivot > doubtful_pivot .and. .not. noise > 0.0_wp
      ! What is decided in between depends on the last look alone, which a checkpoint knows.
      if (self%holds .or. .not. (self%trusted .or. self%rank_before >= 0)) call remember(self)
   end subroutine decide

   !> The rows that are selected take over.
   subroutine put_in_charge(self)
      type(rank_keeper_t), intent(inout) :: self

      self%dead = 0
      self%rising = 0
      self%first_pivot = -1.0_wp
      if (all(self%kept .eqv. self%selection%kept)) return
      self%kept(:) = self%selection%kept
      self%revision = self%revision + 1
   end subroutine put_in_charge

   !> The rows in charge are those to be tried first.
   subroutine remember(self)
      type(rank_keeper_t), intent(inout) :: self

      self%kept_before(:) = self%kept
      self%pivot_before = self%selection%smallest_kept
      self%trusted = .true.
   end subroutine remember

   !> Whether all entries of the rows are finite.
   pure logical function is_finite(self, a)
      type(rank_keeper_t), intent(in) :: self
      type(csr_t), intent(in) :: a
      integer :: entries

      entries = size(self%kept)*a%n
      if (.not. a%full) entries = a%first(size(self%kept) + 1) - 1
      is_finite = all(ieee_is_finite(a%values(:entries)))
   end function is_finite

   !> Tells a solver the rows.
   subroutine hand_over(self, solver)
      !> The keeper.
      class(rank_keeper_t), intent(in) :: self
      !> The solver.
      class(normal_solver_t), intent(inout) :: solver

      call solver%keep_selected(self%kept, self%revision)
   end subroutine hand_over

   !> Decides where no selection holds, and tells a solver the rows.
   subroutine prepare(self, a, noise, solver)
      !> The keeper.
      class(rank_keeper_t), intent(inout) :: self
      !> The matrix, finite.
      type(csr_t), intent(in) :: a
      !> Relative error of its rows, for want of a state that meets the constraints.
      real(wp), intent(in) :: noise
      !> The solver.
      class(normal_solver_t), intent(inout) :: solver

      if (.not. self%holds) call self%decide(a, noise)
      if (solver%revision /= self%revision) call self%hand_over(solver)
   end subroutine prepare

   !> Looks at a state where a step was accepted: what is decided here holds until the next look.
   subroutine look(self, a, solver, t, violation)
      !> The keeper.
      class(rank_keeper_t), intent(inout) :: self
      !> The constraint matrix.
      type(csr_t), intent(in) :: a
      !> A solver that has it factorized.
      class(normal_solver_t), intent(inout) :: solver
      !> The time, to be noted with a change of the rank [s].
      real(wp), intent(in) :: t
      !> By how much the constraints are violated, relative to the size of the coordinates.
      real(wp), intent(in) :: violation
      integer :: before
      real(wp) :: pivot
      logical :: again, dead

      before = self%rank_before
      if (.not. self%holds) then
         if (.not. is_finite(self, a)) return
         call self%selection%select(a, violation)
         call put_in_charge(self)
      else if (before < 0) then
         self%kept_before(:) = self%kept
         pivot = solver%weakest()
         call solver%judge(pivot)
         if (self%first_pivot < 0.0_wp) self%first_pivot = pivot
         ! Masses alone may make the pivots of independent rows that small.
         dead = pivot <= min(dead_pivot, weaker*self%first_pivot)
         self%dead = merge(self%dead + 1, 0, dead)
         again = self%dead >= dead_steps
         if (.not. dead) again = pivot < weak_pivot .and. pivot < weaker*self%first_pivot
         if (.not. again .and. solver%rank < solver%c) then
            self%rising = merge(self%rising + 1, 0, slip(self, a, solver) > max(seen_rising, above_violation*violation))
            again = self%rising >= rising_steps
         end if
         if (.not. (again .and. is_finite(self, a))) return
         before = count(self%kept)
         call self%selection%select(a, violation)
         call put_in_charge(self)
      end if
      if (before >= 0) call compare(before)
      self%holds = .true.
      self%rank_before = -1
      call remember(self)

   contains

      subroutine compare(rank)
         integer, intent(in) :: rank
         integer :: row

         if (count(self%kept) == rank) return
         row = findloc((self%kept .neqv. self%kept_before) .and. (self%kept .eqv. (count(self%kept) > rank)), .true., 1)
         self%changes = reshape([self%changes, t, real(rank, wp), real(count(self%kept), wp), real(row, wp)], &
                                [4, size(self%changes, 2) + 1])
      end subroutine compare

   end subroutine look

   !> By how much motions that the rows in charge allow violate the others: the largest |b_i z|/|z|.
   function slip(self, a, solver) result(largest)
      type(rank_keeper_t), intent(inout) :: self
      type(csr_t), intent(in) :: a
      class(normal_solver_t), intent(inout) :: solver
      real(wp) :: largest, length
      integer :: i, j

      ! Any motion will do that has a part in all directions.
      do j = 1, a%n
         self%probe(j) = arbitrary(j)
      end do
      length = norm2(self%probe)
      call self%selection%rows%to_motion(self%probe)
      call solver%project(a, self%zero, self%probe, self%r, self%lambda)
      call a%multiply(self%probe, self%r)
      largest = 0.0_wp
      do i = 1, size(self%kept)
         if (.not. self%kept(i)) largest = max(largest, abs(self%r(i))*merge(1.0_wp, self%selection%rows%row_scale(i), &
                                                                             self%selection%rows%empty(i)))
      end do
      ! Where no motion is left, there is nothing but round-off.
      call self%selection%rows%from_motion(self%probe)
      largest = largest/max(norm2(self%probe), exactly_dependent*length)
   end function slip

   !> Lets the decision go, for it has proved wrong: rows are selected anew wherever they are asked for, until the next look.
   subroutine release(self)
      !> The keeper.
      class(rank_keeper_t), intent(inout) :: self

      if (.not. self%holds) return
      self%holds = .false.
      self%trusted = .false.
      self%rank_before = count(self%kept)
      self%kept_before(:) = self%kept
   end subroutine release

   !> Takes rows that were in charge before.
   subroutine restore(self, kept)
      !> The keeper.
      class(rank_keeper_t), intent(inout) :: self
      !> The rows: (c).
      logical, intent(in) :: kept(:)

      if (all(self%kept .eqv. kept)) return
      self%kept(:) = kept
      self%revision = self%revision + 1
   end subroutine restore

end module taut_linalg_rank_keeper
