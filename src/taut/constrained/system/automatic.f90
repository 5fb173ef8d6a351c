!> Systems that need no derivatives: from phi(x, t) alone follow A, b' and b'', from a potential the force, from M(x, t) the forces
!! of its changes. Functions are written with jets in the place of real numbers (see `taut_jet`), so what follows is exact.
!!
!! With xdot = H v, column j of A is the derivative of phi along xdot = H e_j, b' is -dphi/dt at constant x, and b'' is minus the
!! second derivative of phi along the motion with vdot = 0, Eqs (6). Four columns are had at a time, and of a large system, once
!! `find_structure` was called, as many as share no row.
!!
!! Whatever follows may still be written by hand, by overriding it: `jacobian`, `velocity_rhs`, `acceleration_rhs`, `force`, ...
module taut_constrained_system_automatic
   use taut_kinds, only: wp
   use taut_error, only: error_t
   use taut_constrained_system, only: not_supplied, scatter_entries, state_t
   use taut_constrained_system_tables, only: tabulated_system_t
   use taut_jet_number, only: directions, jet, jet_t, point
   use taut_linalg_block_diagonal, only: block_diagonal_t
   implicit none (type, external)
   private
   public :: automatic_system_t, jet_state_t

   !> What is asked for of the constraints: their values, what belongs to time alone, what belongs to the motion at constant
   !! velocities, the columns of A.
   integer, parameter :: of_values = 1, of_time = 2, of_motion = 3, of_columns = 4
   !> Jets up to this many are on the stack, more are allocated; the compiler keeps what is larger than 64 kB in static memory.
   integer, parameter :: most_on_stack = 1000

   !> Where a system is, in jets: what `state_t` is in real numbers.
   type :: jet_state_t
      !> Time [s].
      type(jet_t) :: t
      !> Coordinates: (n_x).
      type(jet_t), pointer, contiguous :: x(:) => null()
      !> Velocities: (n); for `nonholonomic` and `kinematics` alone.
      type(jet_t), pointer, contiguous :: v(:) => null()
   end type jet_state_t

   !> A system that says what its constraints are, and not their derivatives. An extension states its sizes with `define` and
   !! supplies `phi` and, or, `nonholonomic`; M by `diagonal_mass`, `mass` or `masses`; f by `force`, by `potential`, or by a
   !! `force` that adds to `lagrange_force`.
   type, abstract, extends(tabulated_system_t) :: automatic_system_t
      !> M, where it is diagonal and never changes: (n). Then neither `mass` nor `masses` is needed.
      real(wp), allocatable :: diagonal_mass(:)
      !> Pattern of A, where `find_structure` found it, and whether it is worth it.
      integer, allocatable, private :: first(:), column(:)
      logical, private :: sparse = .false.
      !> Number of the direction that a column of A is had from, four to a pass; where the structure is not known, that of the
      !! column. How many there are.
      integer, allocatable, private :: direction(:)
      integer, private :: colors = 0
      !> Where each entry of the pattern is among the slopes of all constraints in all passes: (directions, c, passes).
      integer, allocatable, private :: place_of_entry(:)
      !> Coordinates of each pass, whose values are filled in: (n_x, passes); where xdot = v.
      type(jet_t), allocatable, private :: seeds(:, :)
      !> Whether phi may depend on time, and whether xdot = v is known.
      logical, private :: rheonomic = .true., plain_rates = .false.
   contains
      !> phi(x, t) of the holonomic constraints, Eq. (5).
      procedure :: phi => phi_not_supplied
      !> A v - b' of the others, a function of x, v and t that is affine in v.
      procedure :: nonholonomic => nonholonomic_not_supplied
      !> xdot = H(x) v; by default v.
      procedure :: kinematics => rates_are_velocities
      !> Potential energy V(x, t), and M(x, t).
      procedure :: potential => potential_not_supplied
      procedure :: masses => masses_not_supplied
      !> What follows from these.
      procedure :: mass => mass_of_masses
      procedure :: force => lagrange_force
      procedure :: lagrange_force
      procedure :: constraint
      procedure :: jacobian
      procedure :: pattern
      procedure :: jacobian_entries
      procedure :: linearization
      procedure :: velocity_rhs
      procedure :: acceleration_rhs
      procedure :: x_rate
      procedure :: energy
      procedure :: find_structure
      procedure :: check_at
      procedure, private :: carry
      procedure, private :: passes
      procedure, private :: place_of_slope
   end type automatic_system_t

   interface
      !> Finds out, once and for all states, which coordinates each constraint depends on, whether time, and whether xdot = v: so
      !! that columns of A which share no row are had together, and A is sparse if it is worth it. A constraint that takes another
      !! branch elsewhere must not depend on more there.
      module subroutine find_structure(self, at)
         !> The system, its sizes stated.
         class(automatic_system_t), intent(inout) :: self
         !> A state where phi is defined.
         type(state_t), intent(in) :: at
      end subroutine find_structure

      !> What only the system itself can say is wrong with it.
      module subroutine check_at(self, at, error)
         !> The system.
         class(automatic_system_t), intent(in) :: self
         !> A state where it may be evaluated.
         type(state_t), intent(in) :: at
         !> What is missing, or not what it has to be.
         type(error_t), allocatable, intent(inout) :: error
      end subroutine check_at

      !> M as `diagonal_mass` or `masses` gives it.
      module subroutine mass_of_masses(self, at, m)
         !> The system.
         class(automatic_system_t), intent(in) :: self
         !> The state; its x and t are used.
         type(state_t), intent(in) :: at
         !> The mass matrix.
         type(block_diagonal_t), intent(inout) :: m
      end subroutine mass_of_masses

      !> The forces that follow from the potential, -H^T dV/dx, and, where xdot = v, those of the changes of `masses`,
      !! d(v^T M v/2)/dx - Mdot v; zero from what is not supplied. To be called from a `force` of one's own that adds to them.
      module subroutine lagrange_force(self, at, value)
         !> The system.
         class(automatic_system_t), intent(in) :: self
         !> The state.
         type(state_t), intent(in) :: at
         !> f: (n).
         real(wp), intent(out) :: value(:)
      end subroutine lagrange_force

      !> Kinetic and potential energy; not known without a `potential`.
      module function energy(self, at)
         !> The system.
         class(automatic_system_t), intent(in) :: self
         !> The state.
         type(state_t), intent(in) :: at
         !> The energy [J].
         real(wp) :: energy
      end function energy
   end interface

contains

   !> phi(x, t) of the holonomic constraints.
   subroutine phi_not_supplied(self, at, value)
      !> The system.
      class(automatic_system_t), intent(in) :: self
      !> Coordinates and time.
      type(jet_state_t), intent(in) :: at
      !> phi: (n_phi).
      type(jet_t), intent(out) :: value(:)

      value(:) = jet(not_supplied())
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine phi_not_supplied

   !> A v - b' of the constraints that are not holonomic; affine in v.
   subroutine nonholonomic_not_supplied(self, at, value)
      !> The system.
      class(automatic_system_t), intent(in) :: self
      !> Coordinates, velocities and time.
      type(jet_state_t), intent(in) :: at
      !> A v - b': (c - n_phi).
      type(jet_t), intent(out) :: value(:)

      value(:) = jet(not_supplied())
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine nonholonomic_not_supplied

   !> xdot = H(x) v; by default H = I. An extension with another H supplies `v_of_x_rate`, `displace` and `normalize` too.
   subroutine rates_are_velocities(self, at, rate)
      !> The system.
      class(automatic_system_t), intent(in) :: self
      !> Coordinates and velocities.
      type(jet_state_t), intent(in) :: at
      !> xdot: (n_x).
      type(jet_t), intent(out) :: rate(:)

      if (size(rate) == size(at%v)) then
         rate(:) = at%v
      else
         rate(:) = jet(not_supplied())
      end if
      associate (unused_system => self)
      end associate
   end subroutine rates_are_velocities

   !> Potential energy.
   subroutine potential_not_supplied(self, at, value)
      !> The system.
      class(automatic_system_t), intent(in) :: self
      !> Coordinates and time.
      type(jet_state_t), intent(in) :: at
      !> V [J].
      type(jet_t), intent(out) :: value

      value = jet(not_supplied())
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine potential_not_supplied

   !> The mass matrix.
   subroutine masses_not_supplied(self, at, m)
      !> The system.
      class(automatic_system_t), intent(in) :: self
      !> Coordinates and time.
      type(jet_state_t), intent(in) :: at
      !> M: (n, n), symmetric; zero on entry.
      type(jet_t), intent(inout) :: m(:, :)

      m(1, 1) = jet(not_supplied())
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine masses_not_supplied

   !> phi.
   subroutine constraint(self, at, value)
      !> The system.
      class(automatic_system_t), intent(in) :: self
      !> The state.
      type(state_t), intent(in) :: at
      !> phi: (n_phi).
      real(wp), intent(out) :: value(:)

      call differentiate(self, at, of_values, value)
   end subroutine constraint

   !> A.
   subroutine jacobian(self, at, a)
      !> The system.
      class(automatic_system_t), intent(in) :: self
      !> The state.
      type(state_t), intent(in) :: at
      !> The constraint matrix: (c, n).
      real(wp), intent(out) :: a(:, :)
      integer, allocatable :: column(:), first(:)
      real(wp) :: none(0)

      ! A pattern of somebody else's, with its entries.
      if (.not. self%sparse) call self%pattern(first, column)
      if (allocated(first)) then
         call scatter_entries(self, at, a)
         return
      end if
      a(:, :) = 0.0_wp
      call differentiate(self, at, of_columns, none, a)
   end subroutine jacobian

   !> Where entries of A can differ from zero, if `find_structure` found that it is worth it.
   subroutine pattern(self, first, column)
      !> The system.
      class(automatic_system_t), intent(in) :: self
      !> First entry of each row: (c + 1).
      integer, allocatable, intent(out) :: first(:)
      !> Column of each entry.
      integer, allocatable, intent(out) :: column(:)

      if (.not. self%sparse) return
      first = self%first
      column = self%column
   end subroutine pattern

   !> Those entries.
   subroutine jacobian_entries(self, at, values)
      !> The system.
      class(automatic_system_t), intent(in) :: self
      !> The state.
      type(state_t), intent(in) :: at
      !> In the order of `pattern`.
      real(wp), intent(out) :: values(:)

      call differentiate(self, at, of_columns, values)
   end subroutine jacobian_entries

   !> phi and those entries; one evaluation gives both where the structure lets four columns stand for all.
   subroutine linearization(self, at, value, entries)
      !> The system.
      class(automatic_system_t), intent(in) :: self
      !> The state.
      type(state_t), intent(in) :: at
      !> phi: (n_phi).
      real(wp), intent(out) :: value(:)
      !> In the order of `pattern`.
      real(wp), intent(out) :: entries(:)

      call differentiate(self, at, of_columns, entries, phi=value)
   end subroutine linearization

   !> b'.
   subroutine velocity_rhs(self, at, value)
      !> The system.
      class(automatic_system_t), intent(in) :: self
      !> The state.
      type(state_t), intent(in) :: at
      !> b': (c).
      real(wp), intent(out) :: value(:)

      if (self%rheonomic) then
         call differentiate(self, at, of_time, value)
      else
         value(:) = 0.0_wp
      end if
   end subroutine velocity_rhs

   !> b''.
   subroutine acceleration_rhs(self, at, value)
      !> The system.
      class(automatic_system_t), intent(in) :: self
      !> The state.
      type(state_t), intent(in) :: at
      !> b'': (c).
      real(wp), intent(out) :: value(:)

      call differentiate(self, at, of_motion, value)
   end subroutine acceleration_rhs

   !> What the constraints are asked for, with room for it.
   subroutine differentiate(self, at, what, value, a, phi)
      class(automatic_system_t), intent(in) :: self
      type(state_t), intent(in) :: at
      integer, intent(in) :: what
      real(wp), intent(inout) :: value(:)
      real(wp), intent(inout), optional :: a(:, :), phi(:)
      type(jet_t), target :: few(most_on_stack)
      type(jet_t), allocatable, target :: many(:)
      integer :: velocities

      ! Velocities, and room for rates, are asked for where they are used.
      velocities = 0
      if (.not. self%plain_rates .or. self%n_phi < self%c) velocities = self%n
      if (self%n_x + velocities + max(self%n_x, self%c) <= most_on_stack) then
         call differentiate_in(self, at, what, self%n_x, velocities, max(self%n_x, self%c), few, few(self%n_x + 1:), &
                               few(self%n_x + velocities + 1:), value, a, phi)
      else
         allocate (many(self%n_x + velocities + max(self%n_x, self%c)))
         call differentiate_in(self, at, what, self%n_x, velocities, max(self%n_x, self%c), many, many(self%n_x + 1:), &
                               many(self%n_x + velocities + 1:), value, a, phi)
      end if
   end subroutine differentiate

   !> The same in the room that is given for coordinates, velocities, and rates or results.
   subroutine differentiate_in(self, at, what, n_x, n_v, n_r, x, v, r, value, a, phi)
      class(automatic_system_t), intent(in) :: self
      type(state_t), intent(in) :: at
      integer, intent(in) :: what, n_x, n_v, n_r
      type(jet_t), intent(inout), target :: x(n_x), v(n_v), r(n_r)
      real(wp), intent(inout) :: value(:)
      real(wp), intent(inout), optional :: a(:, :), phi(:)
      type(jet_state_t) :: there
      integer :: i

      there%t = still(at%t)
      there%x => x
      there%v => v
      select case (what)
      case (of_values)
         do i = 1, n_x
            x(i) = still(at%x(i))
         end do
         call self%phi(there, r(1:self%n_phi))
         do i = 1, self%n_phi
            value(i) = r(i)%v
         end do
      case (of_time)
         do i = 1, n_x
            x(i) = still(at%x(i))
         end do
         do i = 1, n_v
            v(i) = still(0.0_wp)
         end do
         there%t%d(1) = 1.0_wp
         call evaluate(self, there, r)
         do i = 1, self%n_phi
            value(i) = -r(i)%d(1)
         end do
         do i = self%n_phi + 1, self%c
            value(i) = -r(i)%v
         end do
      case (of_motion)
         call set_moving(self, at, there, r)
         there%t%d(1) = 1.0_wp
         call evaluate(self, there, r)
         do i = 1, self%n_phi
            value(i) = -r(i)%dd
         end do
         do i = self%n_phi + 1, self%c
            value(i) = -r(i)%d(1)
         end do
      case default
         call differentiate_columns(self, at, there, r, value, a, phi)
      end select
   end subroutine differentiate_in

   !> Columns of A, as many to a pass as there are directions.
   subroutine differentiate_columns(self, at, there, r, entries, a, phi)
      class(automatic_system_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(jet_state_t), intent(in) :: there
      type(jet_t), intent(inout) :: r(:)
      real(wp), intent(inout) :: entries(:)
      real(wp), intent(inout), optional :: a(:, :), phi(:)
      real(wp) :: few(directions*most_on_stack)
      real(wp), allocatable :: many(:)

      if (self%c*self%passes() <= most_on_stack) then
         call differentiate_columns_in(self, at, there, r, self%c, self%passes(), few, entries, a, phi)
      else
         allocate (many(directions*self%c*self%passes()))
         call differentiate_columns_in(self, at, there, r, self%c, self%passes(), many, entries, a, phi)
      end if
   end subroutine differentiate_columns

   !> The same in the room that is given for the slopes of all constraints in all passes.
   subroutine differentiate_columns_in(self, at, there, r, c, passes, slopes, entries, a, phi)
      class(automatic_system_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(jet_state_t), intent(in) :: there
      integer, intent(in) :: c, passes
      type(jet_t), intent(inout) :: r(:)
      real(wp), intent(inout) :: slopes(directions, c, passes), entries(:)
      real(wp), intent(inout), optional :: a(:, :), phi(:)
      integer :: i, pass

      do pass = 1, passes
         call set_columns(self, at, pass, there, r)
         if (self%n_phi > 0) call self%phi(there, r(1:self%n_phi))
         if (self%n_phi < self%c) then
            ! These have the velocities' derivatives, and not the coordinates'.
            do i = 1, self%n_x
               there%x(i) = still(at%x(i))
            end do
            call self%nonholonomic(there, r(self%n_phi + 1:self%c))
         end if
         do i = 1, c
            slopes(:, i, pass) = r(i)%d
         end do
      end do
      call take_columns(self, slopes, entries, a)
      if (.not. present(phi)) return
      do i = 1, self%n_phi
         phi(i) = r(i)%v
      end do
   end subroutine differentiate_columns_in

   !> All constraints.
   subroutine evaluate(self, there, r)
      class(automatic_system_t), intent(in) :: self
      type(jet_state_t), intent(in) :: there
      type(jet_t), intent(inout) :: r(:)

      if (self%n_phi > 0) call self%phi(there, r(1:self%n_phi))
      if (self%n_phi < self%c) call self%nonholonomic(there, r(self%n_phi + 1:self%c))
   end subroutine evaluate

   !> Coordinates along the motion with vdot = 0: {x, H v, (H v)'}.
   subroutine set_moving(self, at, there, rate)
      class(automatic_system_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(jet_state_t), intent(in) :: there
      type(jet_t), intent(inout) :: rate(:)
      integer :: i

      associate (x => there%x, v => there%v)
         do i = 1, size(v)
            v(i) = still(at%v(i))
         end do
         if (self%plain_rates) then
            do i = 1, size(x)
               x(i) = moving(at%x(i), at%v(i))
            end do
         else
            do i = 1, size(x)
               x(i) = still(at%x(i))
            end do
            call self%kinematics(there, rate(1:size(x)))
            do i = 1, size(x)
               x(i) = moving(at%x(i), rate(i)%v)
            end do
            call self%kinematics(there, rate(1:size(x)))
            do i = 1, size(x)
               x(i)%dd = rate(i)%d(1)
            end do
         end if
      end associate
   end subroutine set_moving

   !> How often the constraints are evaluated for all columns of A.
   pure integer function passes(self)
      class(automatic_system_t), intent(in) :: self

      passes = self%n
      if (allocated(self%direction)) passes = self%colors
      passes = (passes + directions - 1)/directions
   end function passes

   !> Coordinates {x, H e_j} and velocities {v, e_j}, of the columns of a pass.
   subroutine set_columns(self, at, pass, there, rate)
      class(automatic_system_t), intent(in) :: self
      type(state_t), intent(in) :: at
      integer, intent(in) :: pass
      type(jet_state_t), intent(in) :: there
      type(jet_t), intent(inout) :: rate(:)
      integer :: i

      associate (x => there%x, v => there%v)
         if (allocated(self%seeds)) then
            do i = 1, size(x)
               x(i) = self%seeds(i, pass)
               x(i)%v = at%x(i)
            end do
            do i = 1, size(v)
               v(i) = self%seeds(i, pass)
               v(i)%v = at%v(i)
            end do
         else
            do i = 1, size(v)
               v(i) = still(at%v(i))
               if (allocated(self%direction)) then
                  call point(self%direction(i) - directions*(pass - 1), v(i))
               else
                  call point(i - directions*(pass - 1), v(i))
               end if
            end do
            call self%carry(at, there, rate)
         end if
      end associate
   end subroutine set_columns

   !> Gives coordinates the derivatives that belong to those of the velocities.
   subroutine carry(self, at, there, rate)
      class(automatic_system_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(jet_state_t), intent(in) :: there
      type(jet_t), intent(inout) :: rate(:)
      integer :: i

      associate (x => there%x)
         do i = 1, size(x)
            x(i) = still(at%x(i))
         end do
         call self%kinematics(there, rate(1:size(x)))
         do i = 1, size(x)
            x(i) = rate(i)
            x(i)%v = at%x(i)
            x(i)%dd = 0.0_wp
         end do
      end associate
   end subroutine carry

   !> A, of the slopes of all constraints in all passes: its entries, or all of it.
   pure subroutine take_columns(self, slopes, entries, a)
      class(automatic_system_t), intent(in) :: self
      real(wp), intent(in) :: slopes(*)
      real(wp), intent(inout) :: entries(:)
      real(wp), intent(inout), optional :: a(:, :)
      integer :: i, j, k

      if (.not. present(a)) then
         call pick(size(entries), self%place_of_entry, slopes, entries)
      else if (allocated(self%place_of_entry)) then
         do i = 1, self%c
            do k = self%first(i), self%first(i + 1) - 1
               a(i, self%column(k)) = slopes(self%place_of_entry(k))
            end do
         end do
      else
         do j = 1, self%n
            do i = 1, self%c
               a(i, j) = slopes(self%place_of_slope(i, j))
            end do
         end do
      end if
   end subroutine take_columns

   !> Numbers at places.
   pure subroutine pick(n, places, from, values)
      integer, intent(in) :: n, places(n)
      real(wp), intent(in) :: from(*)
      real(wp), intent(inout) :: values(n)
      integer :: k

      do k = 1, n
         values(k) = from(places(k))
      end do
   end subroutine pick

   !> Where the slope of a row is that belongs to a color: those of all rows of a pass stand together.
   pure integer function place_of_slope(self, row, color) result(place)
      class(automatic_system_t), intent(in) :: self
      integer, intent(in) :: row, color

      place = directions*((color - 1)/directions*self%c + row - 1) + modulo(color - 1, directions) + 1
   end function place_of_slope

   !> xdot = H v.
   subroutine x_rate(self, at, u, value)
      !> The system.
      class(automatic_system_t), intent(in) :: self
      !> The state.
      type(state_t), intent(in) :: at
      !> Velocities: (n).
      real(wp), intent(in) :: u(:)
      !> xdot: (n_x).
      real(wp), intent(out) :: value(:)
      type(jet_t), target :: few(most_on_stack)
      type(jet_t), allocatable, target :: many(:)

      if (self%plain_rates) then
         value(:) = u
      else if (2*self%n_x + self%n <= most_on_stack) then
         call x_rate_in(self%n_x, self%n, few, few(self%n_x + 1:), few(2*self%n_x + 1:))
      else
         allocate (many(2*self%n_x + self%n))
         call x_rate_in(self%n_x, self%n, many, many(self%n_x + 1:), many(2*self%n_x + 1:))
      end if

   contains

      !> The same in the room that is given.
      subroutine x_rate_in(n_x, n, x, rate, v)
         integer, intent(in) :: n_x, n
         type(jet_t), intent(inout), target :: x(n_x), rate(n_x), v(n)
         type(jet_state_t) :: there
         integer :: i

         there%t = still(at%t)
         there%x => x
         there%v => v
         do i = 1, n_x
            x(i) = still(at%x(i))
         end do
         do i = 1, n
            v(i) = still(u(i))
         end do
         call self%kinematics(there, rate)
         do i = 1, n_x
            value(i) = rate(i)%v
         end do
      end subroutine x_rate_in

   end subroutine x_rate

   !> A constant: what `jet` gives, compiled into what uses it.
   elemental function still(v) result(z)
      real(wp), intent(in) :: v
      type(jet_t) :: z

      z = jet_t(v, 0.0_wp, 0.0_wp)
   end function still

   !> A number that changes at a rate.
   elemental function moving(v, rate) result(z)
      real(wp), intent(in) :: v, rate
      type(jet_t) :: z

      z = jet_t(v, 0.0_wp, [rate, 0.0_wp, 0.0_wp, 0.0_wp])
   end function moving

end module taut_constrained_system_automatic
