!> When a constraint is met: how large an entry of phi may be that counts as none, in any unit of length.
!!
!! The tolerance of the projection is stated for systems of about the size 1, down to a hundredth. A row whose phi is smaller all
!! over the system, for it is a length of 1e-6 m or the square of one, is met to the same part of its size; and where round-off of
!! the coordinates is more than all this, to round-off:
!!
!!     |phi_i| <= max(min(tau, tau s_i), 4 eps max_j |A_ij| m_j)
!!
!! with s_i = max_j |A_ij| l_j, l_j what a displacement along velocity j is in a system of its size, and m_j the coordinate that
!! goes with it. Both are found where a motion starts and hold for all of it; the round-off grows with the largest coordinate.
module taut_constrained_yardstick
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use, intrinsic :: iso_fortran_env, only: int64
   use taut_archive, only: archive_t
   use taut_kinds, only: last_place, wp
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_linalg_csr, only: csr_t
   implicit none (type, external)
   private
   public :: yardstick_t, largest_entry, relative_violation

   !> Violations up to so many round-offs of the coordinates count as none, whatever the tolerance: a distance is a difference of
   !! two coordinates that are exact to half of one, and its components add up.
   real(wp), parameter :: exact = 4.0_wp
   !> Rows of this size and more are of the size 1: lengths of a hundredth, but for half a decade.
   real(wp), parameter :: about_one = 3.0e-3_wp
   !> A displacement up to so many round-offs of its coordinate moves nothing any more.
   real(wp), parameter :: at_rest = 2.0_wp

   !> What is allowed of each row.
   type :: yardstick_t
      !> tau, in the unit of phi, of a system of the size 1.
      real(wp) :: tolerance = 1.0e-12_wp
      !> A violation whose largest entry is no more than this is met, whatever round-off is.
      real(wp) :: sure = 1.0e-12_wp
      !> Coordinates up to this leave violations to be measured by their largest entry.
      real(wp) :: plain_up_to = 0.0_wp
      !> Whether tau is that of all rows, so that violations are measured by their largest entry.
      logical, private :: plain = .true.
      !> min(1, s_i), and how steep phi_i is: what round-off of the largest coordinate is multiplied with in it. (n_phi).
      real(wp), allocatable, private :: part(:), steep(:)
      !> m_j: (n).
      real(wp), allocatable, private :: coordinate(:)
      !> Largest of the coordinates, least of the parts, most of the slopes.
      real(wp), private :: largest = 1.0_wp, least_part = 1.0_wp, steepest = 1.0_wp
   contains
      procedure :: init
      procedure :: lay
      procedure :: allow
      procedure :: measure
      procedure :: nothing_moves
      procedure :: round_off
      procedure :: serialize
      procedure, private :: conclude
   end type yardstick_t

contains

   !> For a system of the size 1.
   subroutine init(self, n_phi, n, tolerance)
      !> The yardstick.
      class(yardstick_t), intent(out) :: self
      !> Holonomic constraints.
      integer, intent(in) :: n_phi
      !> Velocities.
      integer, intent(in) :: n
      !> tau, in the unit of phi.
      real(wp), intent(in) :: tolerance

      self%tolerance = tolerance
      allocate (self%part(n_phi), self%steep(n_phi), self%coordinate(n), source=1.0_wp)
      call self%conclude()
   end subroutine init

   !> For a system as it is where its motion starts.
   subroutine lay(self, model, at, a)
      !> The yardstick.
      class(yardstick_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Its state.
      type(state_t), intent(in) :: at
      !> A there, holonomic rows first.
      type(csr_t), intent(in) :: a
      real(wp) :: in_coordinates, largest, length(model%n), s, slope
      integer :: begin, i, j, k, last

      call model%sizes(at, length, self%coordinate)
      self%coordinate(:) = max(self%coordinate, length)
      largest = largest_coordinate(self)
      do i = 1, size(self%part)
         s = 0.0_wp
         slope = 0.0_wp
         in_coordinates = 0.0_wp
         call find_row(a, i, begin, last)
         do k = begin, last
            j = k - begin + 1
            if (.not. a%full) j = a%column(k)
            s = max(s, abs(a%values(k))*length(j))
            slope = max(slope, abs(a%values(k)))
            in_coordinates = max(in_coordinates, abs(a%values(k))*self%coordinate(j))
         end do
         ! A row of zeros has no size.
         if (s >= about_one .or. .not. s > tiny(1.0_wp)/epsilon(1.0_wp)) then
            self%part(i) = 1.0_wp
            self%steep(i) = max(1.0_wp, slope)
         else
            self%part(i) = s
            self%steep(i) = in_coordinates/largest
         end if
      end do
      call self%conclude()
   end subroutine lay

   !> Another tolerance.
   pure subroutine allow(self, tolerance)
      !> The yardstick.
      class(yardstick_t), intent(inout) :: self
      !> tau, in the unit of phi.
      real(wp), intent(in) :: tolerance

      self%tolerance = tolerance
      call self%conclude()
   end subroutine allow

   !> What follows from the parts.
   pure subroutine conclude(self)
      class(yardstick_t), intent(inout) :: self

      self%largest = largest_coordinate(self)
      self%least_part = minval([1.0_wp, self%part])
      self%steepest = maxval([0.0_wp, self%steep])
      self%plain = self%least_part >= 1.0_wp
      self%sure = self%tolerance*self%least_part
      self%plain_up_to = 0.0_wp
      if (self%plain) self%plain_up_to = self%tolerance/(exact*epsilon(1.0_wp)*max(1.0_wp, self%steepest))
   end subroutine conclude

   !> The largest of the coordinates.
   pure real(wp) function largest_coordinate(self) result(largest)
      class(yardstick_t), intent(in) :: self

      largest = max(maxval([0.0_wp, self%coordinate]), tiny(1.0_wp))
   end function largest_coordinate

   !> Size of a violation, or of a change of one: met is what is not more than the tolerance.
   pure function measure(self, phi, x) result(size_of_it)
      !> The yardstick.
      class(yardstick_t), intent(in) :: self
      !> Of the holonomic rows, finite: (n_phi).
      real(wp), intent(in), contiguous :: phi(:)
      !> Coordinates: (n_x).
      real(wp), intent(in), contiguous :: x(:)
      !> In the unit of the tolerance.
      real(wp) :: size_of_it
      real(wp) :: uncertain
      integer :: i

      uncertain = of_coordinates(self, x)/self%tolerance
      if (self%plain .and. uncertain*self%steepest <= 1.0_wp) then
         size_of_it = largest_entry(phi)
         return
      end if
      size_of_it = 0.0_wp
      do i = 1, size(self%part)
         size_of_it = max(size_of_it, abs(phi(i))/max(self%part(i), uncertain*self%steep(i)))
      end do
   end function measure

   !> What round-off of the coordinates may leave of phi.
   pure subroutine round_off(self, x, phi)
      !> The yardstick.
      class(yardstick_t), intent(in) :: self
      !> Coordinates: (n_x).
      real(wp), intent(in), contiguous :: x(:)
      !> Its size: (n_phi).
      real(wp), intent(out), contiguous :: phi(:)

      phi(:) = of_coordinates(self, x)/exact*self%steep
   end subroutine round_off

   !> Round-off of the coordinates that counts as none.
   pure real(wp) function of_coordinates(self, x) result(uncertain)
      class(yardstick_t), intent(in) :: self
      real(wp), intent(in), contiguous :: x(:)

      uncertain = largest_entry(x)
      if (.not. self%plain) uncertain = max(uncertain, self%largest)
      uncertain = exact*last_place(uncertain)
   end function of_coordinates

   !> Whether a displacement is round-off of the coordinates.
   pure logical function nothing_moves(self, d, x)
      !> The yardstick.
      class(yardstick_t), intent(in) :: self
      !> Along the velocities: (n).
      real(wp), intent(in), contiguous :: d(:)
      !> Coordinates: (n_x).
      real(wp), intent(in), contiguous :: x(:)
      real(wp) :: growth
      integer :: j

      growth = largest_entry(x)
      if (self%plain) then
         nothing_moves = largest_entry(d) <= at_rest*last_place(growth)
         return
      end if
      growth = max(1.0_wp, growth/self%largest)
      nothing_moves = .true.
      do j = 1, size(d)
         nothing_moves = nothing_moves .and. abs(d(j)) <= at_rest*epsilon(1.0_wp)*growth*self%coordinate(j)
      end do
   end function nothing_moves

   !> Passes through an archive what a start has laid down.
   subroutine serialize(self, archive, name)
      !> The yardstick.
      class(yardstick_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive
      !> What of.
      character(*), intent(in) :: name

      call archive%item(name//': parts of the tolerance', self%part)
      call archive%item(name//': slopes', self%steep)
      call archive%item(name//': coordinates', self%coordinate)
      call self%conclude()
   end subroutine serialize

   !> Largest absolute entry; not finite if one of them is not.
   pure function largest_entry(values) result(value)
      !> The numbers.
      real(wp), intent(in), contiguous :: values(:)
      !> Not negative.
      real(wp) :: value
      !> Small systems are slowed down by what a longer loop prepares.
      integer, parameter :: few = 8
      integer(int64) :: even, odd
      integer :: i, n

      ! The bits of numbers without their signs are in the order of their sizes, with infinity and NaN at the end.
      odd = 0_int64
      n = size(values)
      if (n < few) then
         !GCC$ unroll 1
         do i = 1, n
            odd = max(odd, ibclr(transfer(values(i), odd), 63))
         end do
      else
         ! Two at a time, which do not wait for each other.
         even = 0_int64
         do i = 1, n - 1, 2
            odd = max(odd, ibclr(transfer(values(i), odd), 63))
            even = max(even, ibclr(transfer(values(i + 1), even), 63))
         end do
         odd = max(odd, even, ibclr(transfer(values(n), odd), 63))
      end if
      value = transfer(odd, value)
   end function largest_entry

   !> How far the rows of A may be from those on the manifold: the distance to it, relative to the size of the coordinates.
   pure function relative_violation(phi, a, x) result(value)
      !> Violation of the holonomic constraints: (n_phi).
      real(wp), intent(in), contiguous :: phi(:)
      !> Constraint matrix, holonomic rows first.
      type(csr_t), intent(in) :: a
      !> Coordinates: (n_x).
      real(wp), intent(in), contiguous :: x(:)
      !> Between 0 and 1.
      real(wp) :: value
      real(wp) :: row, scale
      integer :: begin, i, k, last

      value = 0.0_wp
      scale = largest_entry(x)
      if (.not. (ieee_is_finite(scale) .and. scale > tiny(1.0_wp))) return
      do i = 1, size(phi)
         call find_row(a, i, begin, last)
         row = 0.0_wp
         !GCC$ unroll 1
         do k = begin, last
            row = max(row, abs(a%values(k)))
         end do
         if (row > tiny(1.0_wp) .and. abs(phi(i)) > value*(row*scale)) value = min(1.0_wp, abs(phi(i))/(row*scale))
      end do
   end function relative_violation

   !> Entries of a row.
   pure subroutine find_row(a, i, begin, last)
      type(csr_t), intent(in) :: a
      integer, intent(in) :: i
      integer, intent(out) :: begin, last

      if (a%full) then
         begin = (i - 1)*a%n + 1
         last = i*a%n
      else
         begin = a%first(i)
         last = a%first(i + 1) - 1
      end if
   end subroutine find_row

end module taut_constrained_yardstick
