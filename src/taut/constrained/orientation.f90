!> On which side of its singular positions a mechanism without freedom is: the sign of the determinant of A.
!!
!! Where constraints and drives leave no freedom, A is square, redundant rows apart, and its determinant vanishes at change
!! points, where branches of the motion meet or nearly meet, and nowhere else. A step too long to see the gap between two
!! branches may end on the other one, which meets the constraints as well; the determinant has the other sign there. Shorter
!! steps bring it back. Where branches do meet the sign changes along the motion itself, however short the steps are.
!!
!! The sign is that of det(A A_0^T), A_0 from the last accepted step: its pattern is that of A M^-1 A^T, which a band holds.
module taut_constrained_orientation
   use taut_archive, only: archive_t
   use taut_error, only: to_text
   use taut_kinds, only: wp
   use taut_linalg_lu_banded, only: banded_lu_t
   use taut_linalg_csr, only: csr_t
   implicit none (type, external)
   private
   public :: orientation_t

   !> Tries after which a change of the sign is the motion's own. Each is at most half as long as the one before; what is left
   !! of a step then is less than a ten thousandth, and gaps between branches as wide as the square of that were seen.
   integer, parameter :: most_tries = 16

   !> The side.
   type :: orientation_t
      private
      !> Velocities; 0: there may be freedom, and nothing is looked at.
      integer :: n = 0
      !> A at the last accepted step without freedom, its rows that count, and whether they are known.
      type(csr_t) :: before
      logical, allocatable :: kept(:)
      logical :: known = .false.
      !> Tries refused on the way from one time to where the first of them ended [s].
      integer :: refused = 0
      real(wp) :: refused_from = 0.0_wp, refused_to = 0.0_wp
      !> Time of the last accepted step [s].
      real(wp) :: t = 0.0_wp
      !> Times at which the sign changed for good [s].
      real(wp), allocatable :: crossings(:)
      type(banded_lu_t) :: lu
      real(wp), allocatable :: product(:)
   contains
      procedure :: init
      procedure :: turned
      procedure :: remember
      procedure :: remark
      procedure :: serialize
   end type orientation_t

contains

   !> Makes room, if there are rows enough.
   subroutine init(self, a, c)
      !> The side, not known yet.
      class(orientation_t), intent(out) :: self
      !> A matrix with the pattern of A.
      type(csr_t), intent(in) :: a
      !> How many of its rows are used, from the first one on.
      integer, intent(in) :: c
      integer, allocatable :: row(:), column(:), first(:), rows(:)
      integer :: entries, i, j, k, l, pass, seen_by(c)

      allocate (self%crossings(0))
      if (c < a%n .or. a%n < 2) return
      self%n = a%n
      self%before = a
      allocate (self%kept(c), source=.true.)
      call rows_of_columns(a, c, first, rows)
      ! Pairs of rows with a column in common: first how many, then which.
      do pass = 1, 2
         entries = 0
         seen_by = 0
         do i = 1, c
            call enter(i)
            do k = begin_of(a, i), begin_of(a, i + 1) - 1
               j = column_of(a, k)
               do l = first(j), first(j + 1) - 1
                  if (seen_by(rows(l)) < i) call enter(rows(l))
               end do
            end do
         end do
         if (pass == 1) allocate (row(entries), column(entries))
      end do
      call self%lu%init(c, row, column)
      allocate (self%product(entries))

   contains

      subroutine enter(other)
         integer, intent(in) :: other

         seen_by(other) = i
         entries = entries + 1
         if (pass == 1) return
         row(entries) = i
         column(entries) = other
      end subroutine enter

   end subroutine init

   !> The rows of each column.
   pure subroutine rows_of_columns(a, c, first, rows)
      type(csr_t), intent(in) :: a
      integer, intent(in) :: c
      integer, allocatable, intent(out) :: first(:), rows(:)
      integer :: filled(a%n), i, j, k

      allocate (first(a%n + 1), rows(begin_of(a, c + 1) - 1))
      filled = 0
      do k = 1, size(rows)
         filled(column_of(a, k)) = filled(column_of(a, k)) + 1
      end do
      first(1) = 1
      do j = 1, a%n
         first(j + 1) = first(j) + filled(j)
      end do
      filled = 0
      do i = 1, c
         do k = begin_of(a, i), begin_of(a, i + 1) - 1
            j = column_of(a, k)
            rows(first(j) + filled(j)) = i
            filled(j) = filled(j) + 1
         end do
      end do
   end subroutine rows_of_columns

   !> Where the entries of a row begin.
   pure integer function begin_of(a, i)
      type(csr_t), intent(in) :: a
      integer, intent(in) :: i

      if (a%full) then
         begin_of = (i - 1)*a%n + 1
      else
         begin_of = a%first(i)
      end if
   end function begin_of

   !> The column of an entry.
   pure integer function column_of(a, k)
      type(csr_t), intent(in) :: a
      integer, intent(in) :: k

      if (a%full) then
         column_of = modulo(k - 1, a%n) + 1
      else
         column_of = a%column(k)
      end if
   end function column_of

   !> Whether a state is on the other side than the last accepted step's, and a shorter step ought to be tried.
   logical function turned(self, a, t)
      !> The side.
      class(orientation_t), intent(inout) :: self
      !> A there.
      type(csr_t), intent(in) :: a
      !> Time there [s].
      real(wp), intent(in) :: t
      integer :: info, k

      turned = .false.
      if (.not. self%known) return
      do k = 1, size(self%product)
         self%product(k) = dot_of_rows(a, self%before, self%lu%row(k), self%lu%column(k), self%kept)
      end do
      call self%lu%factorize(self%product, info)
      if (info /= 0) return
      if (.not. self%lu%has_negative_determinant()) return
      if (self%refused == 0) then
         self%refused_from = self%t
         self%refused_to = t
      end if
      self%refused = self%refused + 1
      turned = self%refused <= most_tries
      if (.not. turned) self%crossings = [self%crossings, t]
   end function turned

   !> Row i of A times row j of A_0, as if the rows that do not count were those of the identity.
   pure function dot_of_rows(a, b, i, j, kept) result(value)
      type(csr_t), intent(in) :: a, b
      integer, intent(in) :: i, j
      logical, intent(in) :: kept(:)
      real(wp) :: value
      integer :: k, l, end_of_i, end_of_j

      value = merge(1.0_wp, 0.0_wp, i == j)
      if (.not. (kept(i) .and. kept(j))) return
      value = 0.0_wp
      k = begin_of(a, i)
      l = begin_of(b, j)
      end_of_i = begin_of(a, i + 1)
      end_of_j = begin_of(b, j + 1)
      do while (k < end_of_i .and. l < end_of_j)
         if (column_of(a, k) == column_of(b, l)) then
            value = value + a%values(k)*b%values(l)
            k = k + 1
            l = l + 1
         else if (column_of(a, k) < column_of(b, l)) then
            k = k + 1
         else
            l = l + 1
         end if
      end do
   end function dot_of_rows

   !> Notes the side where a step was accepted, unless freedom is there.
   subroutine remember(self, a, kept, t)
      !> The side.
      class(orientation_t), intent(inout) :: self
      !> A there.
      type(csr_t), intent(in) :: a
      !> The rows that count: (c).
      logical, intent(in) :: kept(:)
      !> Time there [s].
      real(wp), intent(in) :: t

      if (self%n == 0) return
      ! Steps that creep up to a singular position have not passed it.
      if (abs(t - self%refused_from) >= abs(self%refused_to - self%refused_from)) self%refused = 0
      self%t = t
      ! At a singular position itself there is no sign: the one before counts.
      if (count(kept) /= self%n) return
      self%before%values(:) = a%values
      self%kept(:) = kept
      self%known = .true.
   end subroutine remember

   !> What is to be said of the motion so far.
   subroutine remark(self, text)
      !> The side.
      class(orientation_t), intent(in) :: self
      !> One line without commas; empty if there is nothing.
      character(:), allocatable, intent(out) :: text

      text = ''
      if (.not. allocated(self%crossings)) return
      if (size(self%crossings) == 0) return
      text = 'singular positions were passed where branches of the motion meet: '//to_text(size(self%crossings))// &
             ' (the first at t = '//to_text(self%crossings(1))//' s); reactions are not determined there'
   end subroutine remark

   !> Passes through an archive what is remembered from one step to the next.
   subroutine serialize(self, archive)
      !> The side.
      class(orientation_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive
      real(wp), allocatable :: kept(:)

      if (self%n == 0) return
      call archive%item('side is known', self%known)
      call archive%item('tries refused for the side', self%refused)
      call archive%item('refused from', self%refused_from)
      call archive%item('refused to', self%refused_to)
      call archive%item('time of the side', self%t)
      call archive%item('A of the side', self%before%values)
      kept = merge(1.0_wp, 0.0_wp, self%kept)
      call archive%item('rows of the side', kept)
      self%kept(:) = kept > 0.0_wp
      call archive%list('changes of the side', self%crossings)
   end subroutine serialize

end module taut_constrained_orientation
