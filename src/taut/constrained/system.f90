!> What a user writes: a mechanical system and its constraints.
!!
!!     M(x,t) vdot = f(x,v,w,t),   xdot = H(x) v,   wdot = g(x,v,w,t)                      (4), (18)
!!     phi(x,t) = 0,   A(x,t) v = b'(x,t),   A(x,t) vdot = b''(x,v,t)                      (5), (6)
!!
!! with phidot = A v - b'. Equation numbers are those of P. Masarati, Adding kinematic constraints to purely differential
!! dynamics, Comput. Mech. 47 (2011) 187-203.
module taut_constrained_system
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_linalg_block_diagonal, only: block_diagonal_t
   implicit none (type, external)
   private
   public :: state_t, mechanical_system_t, quantity_t

   !> Where the system is: time, coordinates, velocities and what else it has.
   type :: state_t
      !> Time [s].
      real(wp) :: t = 0.0_wp
      !> Coordinates: (n_x).
      real(wp), allocatable :: x(:)
      !> Velocities or quasi-velocities: (n).
      real(wp), allocatable :: v(:)
      !> States that are not mechanics: (n_w).
      real(wp), allocatable :: w(:)
   end type state_t

   !> A number that a system knows about itself, for tables and drawings.
   type :: quantity_t
      !> Without commas and blanks.
      character(:), allocatable :: name
      !> Its value.
      real(wp) :: value = 0.0_wp
      !> Its unit, without commas; `1` if it has none.
      character(:), allocatable :: unit
   end type quantity_t

   !> A constrained mechanical system. An extension states its sizes with `define` and supplies five procedures: `mass`,
   !! `force`, `constraint`, `jacobian` and `acceleration_rhs`; all others have defaults.
   !!
   !! A large system also says where the entries of A are that can differ from zero, with `pattern`, and computes only those,
   !! with `jacobian_entries`; its `jacobian` is then one call of `scatter_entries`.
   !!
   !! An entry that is not finite, in any of the answers, means 'not defined here': the integrator tries a smaller step.
   type, abstract :: mechanical_system_t
      !> Velocities, and rows of M.
      integer :: n = 0
      !> Coordinates.
      integer :: n_x = 0
      !> Constraints, and rows of A.
      integer :: c = 0
      !> Holonomic constraints: those that have a position level. They come first; rows of A beyond them are non-holonomic.
      integer :: n_phi = 0
      !> States that are not mechanics.
      integer :: n_w = 0
      !> Numbers that the system computes at a state besides the standard ones, for tables.
      integer :: n_outputs = 0
      !> Functions of the state whose sign changes are events, for tables.
      integer :: n_events = 0
      !> Sizes of the diagonal blocks of M.
      integer, allocatable :: mass_blocks(:)
      !> Whether M never changes.
      logical :: constant_mass = .true.
      !> Whether the method enforces the constraints. A system with something of its own in their place, such as a spring,
      !! uses that when they are not; set by the formulation for the method at hand.
      logical :: enforced = .true.
   contains
      procedure :: define
      procedure :: check_sizes
      procedure(matrix_of_masses), deferred :: mass
      procedure(vector_at_state), deferred :: force
      procedure(vector_at_state), deferred :: constraint
      procedure(matrix_at_state), deferred :: jacobian
      procedure(vector_at_state), deferred :: acceleration_rhs
      procedure :: pattern => dense_pattern
      procedure :: jacobian_entries => no_entries
      procedure :: scatter_entries
      procedure :: velocity_rhs => no_velocity_rhs
      procedure :: weight => unit_weight
      procedure :: w_rate => no_w_rate
      procedure :: x_rate => x_rate_is_v
      procedure :: v_of_x_rate => v_is_x_rate
      procedure :: displace => add_displacement
      procedure :: normalize => leave_coordinates
      procedure :: energy => no_energy
      procedure :: breakpoints => no_breakpoints
      procedure :: x_name => numbered_x
      procedure :: v_name => numbered_v
      procedure :: output_name => numbered_output
      procedure :: outputs => no_outputs
      procedure :: quantities => no_quantities
      procedure :: describe => no_text
      procedure :: note => no_text
      procedure :: event_name => numbered_event
      procedure :: event_values => no_event_values
   end type mechanical_system_t

   abstract interface
      !> M: the mass matrix.
      subroutine matrix_of_masses(self, at, m)
         import :: mechanical_system_t, state_t, block_diagonal_t
         implicit none (type, external)
         !> The system.
         class(mechanical_system_t), intent(in) :: self
         !> Where; x and t may be used.
         type(state_t), intent(in) :: at
         !> To be filled with `set_diagonal`, `set_block` or `set_dense`; symmetric positive definite.
         type(block_diagonal_t), intent(inout) :: m
      end subroutine matrix_of_masses

      !> A vector that depends on the state: f (n) [force]; phi (n_phi) (x and t only); b' (c) (x and t only); b'' (c)
      !! (x, v and t); g (n_w).
      subroutine vector_at_state(self, at, value)
         import :: mechanical_system_t, state_t, wp
         implicit none (type, external)
         !> The system.
         class(mechanical_system_t), intent(in) :: self
         !> Where.
         type(state_t), intent(in) :: at
         !> The result.
         real(wp), intent(out) :: value(:)
      end subroutine vector_at_state

      !> A: one row per constraint, one column per velocity; every entry is to be set.
      subroutine matrix_at_state(self, at, a)
         import :: mechanical_system_t, state_t, wp
         implicit none (type, external)
         !> The system.
         class(mechanical_system_t), intent(in) :: self
         !> Where; x and t may be used.
         type(state_t), intent(in) :: at
         !> The constraint matrix: (c, n).
         real(wp), intent(out) :: a(:, :)
      end subroutine matrix_at_state
   end interface

contains

   !> States the sizes of a system; to be called once, where the system is set up.
   pure subroutine define(self, n, c, nonholonomic, n_x, n_w, mass_blocks, constant_mass, n_outputs, n_events)
      !> The system.
      class(mechanical_system_t), intent(inout) :: self
      !> Number of velocities.
      integer, intent(in) :: n
      !> Number of constraints.
      integer, intent(in) :: c
      !> How many of the constraints, the last ones, have no position level. Default 0.
      integer, intent(in), optional :: nonholonomic
      !> Number of coordinates. Default n.
      integer, intent(in), optional :: n_x
      !> Number of states that are not mechanics. Default 0.
      integer, intent(in), optional :: n_w
      !> Sizes of the diagonal blocks of M: all 1 for a diagonal M. Default: one dense block of size n.
      integer, intent(in), optional :: mass_blocks(:)
      !> Whether M never changes. Default true.
      logical, intent(in), optional :: constant_mass
      !> Number of further columns in tables. Default 0.
      integer, intent(in), optional :: n_outputs
      !> Number of events. Default 0.
      integer, intent(in), optional :: n_events

      self%n = n
      self%c = c
      self%n_phi = c
      if (present(nonholonomic)) self%n_phi = c - nonholonomic
      self%n_x = n
      if (present(n_x)) self%n_x = n_x
      self%n_w = 0
      if (present(n_w)) self%n_w = n_w
      self%mass_blocks = [n]
      if (present(mass_blocks)) self%mass_blocks = mass_blocks
      self%constant_mass = .true.
      if (present(constant_mass)) self%constant_mass = constant_mass
      self%n_outputs = 0
      if (present(n_outputs)) self%n_outputs = n_outputs
      self%n_events = 0
      if (present(n_events)) self%n_events = n_events
   end subroutine define

   !> Whether the sizes make sense together.
   subroutine check_sizes(self, error)
      !> The system.
      class(mechanical_system_t), intent(in) :: self
      !> What does not.
      type(error_t), allocatable, intent(inout) :: error
      character(*), parameter :: here = 'mechanical system'

      if (self%n < 1) then
         call raise(error, here, 'it has no velocities', 'call its procedure define with its sizes first')
      else if (self%c < 0 .or. self%n_phi < 0 .or. self%n_phi > self%c) then
         call raise(error, here, 'it has '//to_text(self%n_phi)//' holonomic constraints of '//to_text(self%c), &
                    'give define the number of all constraints and how many of them are nonholonomic')
      else if (self%n_x < 1 .or. self%n_w < 0 .or. self%n_outputs < 0) then
         call raise(error, here, 'a number of coordinates, of other states or of outputs is negative', &
                    'correct the call of define')
      else if (.not. allocated(self%mass_blocks)) then
         call raise(error, here, 'the blocks of its mass matrix are not stated', 'call its procedure define')
      else if (any(self%mass_blocks < 1) .or. sum(self%mass_blocks) /= self%n) then
         call raise(error, here, 'the blocks of its mass matrix do not add up to '//to_text(self%n)//' rows', &
                    'correct mass_blocks in the call of define')
      end if
      if (allocated(error)) return
      call check_pattern(self, error)
   end subroutine check_sizes

   !> Whether the pattern of A, where there is one, is in order.
   subroutine check_pattern(self, error)
      class(mechanical_system_t), intent(in) :: self
      type(error_t), allocatable, intent(inout) :: error
      integer, allocatable :: first(:), column(:)
      integer :: i, k
      character(*), parameter :: here = 'mechanical system', remedy = 'correct its procedure pattern'

      call self%pattern(first, column)
      if (.not. (allocated(first) .or. allocated(column))) return
      if (.not. (allocated(first) .and. allocated(column))) then
         call raise(error, here, 'only one of the two arrays of the pattern of A is set', remedy)
         return
      end if
      if (size(first) /= self%c + 1) then
         call raise(error, here, 'the pattern of A has not the beginnings of '//to_text(self%c)//' rows and one more', remedy)
         return
      end if
      if (first(1) /= 1 .or. first(self%c + 1) /= size(column) + 1 .or. any(first(2:) < first(:self%c))) then
         call raise(error, here, 'the rows of the pattern of A do not follow each other from 1 to '//to_text(size(column)), &
                    remedy)
         return
      end if
      do i = 1, self%c
         do k = first(i), first(i + 1) - 1
            if (column(k) < 1 .or. column(k) > self%n) then
               call raise(error, here, 'the pattern of A names column '//to_text(column(k))//' of '//to_text(self%n)// &
                          ' in row '//to_text(i), remedy)
               return
            end if
            if (k == first(i)) cycle
            if (column(k) <= column(k - 1)) then
               call raise(error, here, 'the columns of row '//to_text(i)//' of the pattern of A do not ascend', remedy)
               return
            end if
         end do
      end do
   end subroutine check_pattern

   !> Where the entries of A are that can differ from zero, row by row; the default says nothing: A is dense.
   subroutine dense_pattern(self, first, column)
      !> The system.
      class(mechanical_system_t), intent(in) :: self
      !> First entry of each row in `column`, and the number of entries plus one at the end: (c + 1).
      integer, allocatable, intent(out) :: first(:)
      !> Column of each entry, ascending within a row.
      integer, allocatable, intent(out) :: column(:)

      associate (unused_system => self, unused_first => first, unused_column => column)
      end associate
   end subroutine dense_pattern

   !> The entries of A in the order of `pattern`; the default, for systems that state a pattern and compute nothing, is not a
   !! number.
   subroutine no_entries(self, at, values)
      !> The system.
      class(mechanical_system_t), intent(in) :: self
      !> Where; x and t may be used.
      type(state_t), intent(in) :: at
      !> The entries: (size of the pattern).
      real(wp), intent(out) :: values(:)

      values(:) = ieee_value(1.0_wp, ieee_quiet_nan)
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine no_entries

   !> All of A from its entries: what a system with a `pattern` calls in its `jacobian`.
   subroutine scatter_entries(self, at, a)
      !> The system.
      class(mechanical_system_t), intent(in) :: self
      !> Where; x and t may be used.
      type(state_t), intent(in) :: at
      !> The constraint matrix: (c, n).
      real(wp), intent(out) :: a(:, :)
      integer, allocatable :: first(:), column(:)
      real(wp), allocatable :: values(:)
      integer :: i, k

      a(:, :) = 0.0_wp
      call self%pattern(first, column)
      if (.not. (allocated(first) .and. allocated(column))) then
         a(:, :) = ieee_value(1.0_wp, ieee_quiet_nan)
         return
      end if
      allocate (values(size(column)))
      call self%jacobian_entries(at, values)
      do i = 1, self%c
         do k = first(i), first(i + 1) - 1
            a(i, column(k)) = values(k)
         end do
      end do
   end subroutine scatter_entries

   !> b' of constraints that do not depend on time: zero.
   subroutine no_velocity_rhs(self, at, value)
      !> The system.
      class(mechanical_system_t), intent(in) :: self
      !> Where.
      type(state_t), intent(in) :: at
      !> b': (c).
      real(wp), intent(out) :: value(:)

      value(:) = 0.0_wp
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine no_velocity_rhs

   !> A weight matrix W of the user's own, for `weight = "given"`; the default is the identity.
   subroutine unit_weight(self, at, w)
      !> The system.
      class(mechanical_system_t), intent(in) :: self
      !> Where; x and t may be used.
      type(state_t), intent(in) :: at
      !> To be filled; symmetric positive definite, with the blocks of M.
      type(block_diagonal_t), intent(inout) :: w

      call w%set_identity()
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine unit_weight

   !> g, the rate of the states that are not mechanics; the default is zero.
   subroutine no_w_rate(self, at, value)
      !> The system.
      class(mechanical_system_t), intent(in) :: self
      !> Where.
      type(state_t), intent(in) :: at
      !> g: (n_w).
      real(wp), intent(out) :: value(:)

      value(:) = 0.0_wp
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine no_w_rate

   !> xdot = H(x) u; the default is H = I.
   subroutine x_rate_is_v(self, at, u, value)
      !> The system.
      class(mechanical_system_t), intent(in) :: self
      !> Where; x and t may be used.
      type(state_t), intent(in) :: at
      !> Velocities: (n).
      real(wp), intent(in) :: u(:)
      !> xdot: (n_x).
      real(wp), intent(out) :: value(:)

      integer :: i

      if (size(u) == size(value)) then
         !GCC$ unroll 1
         do i = 1, size(u)
            value(i) = u(i)
         end do
      else
         value(:) = ieee_value(1.0_wp, ieee_quiet_nan)
      end if
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine x_rate_is_v

   !> The velocities that belong to a rate of the coordinates: H(x)^+ xdot; the default is H = I.
   subroutine v_is_x_rate(self, at, rate, u)
      !> The system.
      class(mechanical_system_t), intent(in) :: self
      !> Where; x and t may be used.
      type(state_t), intent(in) :: at
      !> Rate of the coordinates: (n_x).
      real(wp), intent(in) :: rate(:)
      !> Velocities: (n).
      real(wp), intent(out) :: u(:)

      integer :: i

      if (size(u) == size(rate)) then
         !GCC$ unroll 1
         do i = 1, size(u)
            u(i) = rate(i)
         end do
      else
         u(:) = ieee_value(1.0_wp, ieee_quiet_nan)
      end if
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine v_is_x_rate

   !> x := x (+) d, a small displacement along the velocities; the default is x + d.
   subroutine add_displacement(self, d, x)
      !> The system.
      class(mechanical_system_t), intent(in) :: self
      !> Displacement: (n).
      real(wp), intent(in) :: d(:)
      !> Coordinates: (n_x).
      real(wp), intent(inout) :: x(:)
      integer :: i

      do i = 1, size(d)
         x(i) = x(i) + d(i)
      end do
      associate (unused_system => self)
      end associate
   end subroutine add_displacement

   !> Brings coordinates that are redundant by themselves, such as unit quaternions, back to their own manifold; the
   !! default has none.
   subroutine leave_coordinates(self, x)
      !> The system.
      class(mechanical_system_t), intent(in) :: self
      !> Coordinates: (n_x).
      real(wp), intent(inout) :: x(:)

      associate (unused_system => self, unused_coordinates => x)
      end associate
   end subroutine leave_coordinates

   !> Total energy; the default, 'unknown', is not a number.
   function no_energy(self, at) result(energy)
      !> The system.
      class(mechanical_system_t), intent(in) :: self
      !> Where.
      type(state_t), intent(in) :: at
      !> Energy [J].
      real(wp) :: energy

      energy = ieee_value(energy, ieee_quiet_nan)
      associate (unused_system => self, unused_state => at)
      end associate
   end function no_energy

   !> Times at which a load or a drive has a kink or a jump; the default has none.
   function no_breakpoints(self) result(times)
      !> The system.
      class(mechanical_system_t), intent(in) :: self
      !> Times in any order [s].
      real(wp), allocatable :: times(:)

      allocate (times(0))
      associate (unused_system => self)
      end associate
   end function no_breakpoints

   !> Name of a coordinate in tables; the default is x1, x2, ...
   function numbered_x(self, i) result(name)
      !> The system.
      class(mechanical_system_t), intent(in) :: self
      !> Index of the coordinate.
      integer, intent(in) :: i
      !> Without commas and blanks.
      character(:), allocatable :: name

      name = 'x'//to_text(i)
      associate (unused_system => self)
      end associate
   end function numbered_x

   !> Name of a velocity in tables; the default is v1, v2, ...
   function numbered_v(self, i) result(name)
      !> The system.
      class(mechanical_system_t), intent(in) :: self
      !> Index of the velocity.
      integer, intent(in) :: i
      !> Without commas and blanks.
      character(:), allocatable :: name

      name = 'v'//to_text(i)
      associate (unused_system => self)
      end associate
   end function numbered_v

   !> Name of a further column in tables; the default is output1, output2, ...
   function numbered_output(self, i) result(name)
      !> The system.
      class(mechanical_system_t), intent(in) :: self
      !> Index of the output.
      integer, intent(in) :: i
      !> Without commas and blanks.
      character(:), allocatable :: name

      name = 'output'//to_text(i)
      associate (unused_system => self)
      end associate
   end function numbered_output

   !> What the system computes at a state for tables: forces of its parts, positions of its points; the default, for
   !! systems that announce outputs and do not compute them, is not a number.
   subroutine no_outputs(self, at, lambda, values)
      !> The system.
      class(mechanical_system_t), intent(in) :: self
      !> Where.
      type(state_t), intent(in) :: at
      !> Multipliers of Eq. (14b): (c).
      real(wp), intent(in) :: lambda(:)
      !> The numbers: (n_outputs).
      real(wp), intent(out) :: values(:)

      values(:) = ieee_value(values, ieee_quiet_nan)
      associate (unused_system => self, unused_state => at, unused_multipliers => lambda)
      end associate
   end subroutine no_outputs

   !> What the system knows about itself, such as numbers that follow from its data; the default is nothing.
   function no_quantities(self) result(list)
      !> The system.
      class(mechanical_system_t), intent(in) :: self
      !> In the order of a table.
      type(quantity_t), allocatable :: list(:)

      allocate (list(0))
      associate (unused_system => self)
      end associate
   end function no_quantities

   !> `describe`: what people are told before a run, lines with their ends; `note`: what a reader of the results has to know, one
   !! line without commas for their summary. The default is nothing.
   function no_text(self) result(text)
      !> The system.
      class(mechanical_system_t), intent(in) :: self
      !> The text.
      character(:), allocatable :: text

      text = ''
      associate (unused_system => self)
      end associate
   end function no_text

   !> Name of an event in tables; the default is event1, event2, ...
   function numbered_event(self, i) result(name)
      !> The system.
      class(mechanical_system_t), intent(in) :: self
      !> Index of the event.
      integer, intent(in) :: i
      !> Without commas and blanks.
      character(:), allocatable :: name

      name = 'event'//to_text(i)
      associate (unused_system => self)
      end associate
   end function numbered_event

   !> Functions whose sign changes are recorded; the default, for systems that announce none, never changes sign.
   subroutine no_event_values(self, at, values)
      !> The system.
      class(mechanical_system_t), intent(in) :: self
      !> Where.
      type(state_t), intent(in) :: at
      !> The functions: (n_events).
      real(wp), intent(out) :: values(:)

      values(:) = 1.0_wp
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine no_event_values

end module taut_constrained_system
