!> What a user writes: a mechanical system and its constraints.
!!
!!     M(x,t) vdot = f(x,v,w,t),   xdot = H(x) v,   wdot = g(x,v,w,t)                      (4), (18)
!!     phi(x,t) = 0,   A(x,t) v = b'(x,t),   A(x,t) vdot = b''(x,v,t)                      (5), (6)
!!
!! with phidot = A v - b'. Equation numbers are those of P. Masarati, Adding kinematic constraints to purely differential
!! dynamics, Comput. Mech. 47 (2011) 187-203. The paper's b' and b'' are called by what Sect. 3.5 (c) and (e) calls them, the
!! right-hand sides of the constraints at velocity and at acceleration level.
module taut_constrained_system
   use taut_kinds, only: wp
   use taut_error, only: error_t
   use taut_linalg_block_diagonal, only: block_diagonal_t
   implicit none (type, external)
   private
   public :: state_t, mechanical_system_t, check_supplied, not_supplied, is_not_supplied, scatter_entries

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

   !> A constrained mechanical system. An extension states its sizes with `define` and supplies `mass` and `force`; with
   !! constraints also `constraint` (unless all are non-holonomic), `acceleration_rhs`, and `jacobian` or, of a large system,
   !! `pattern` and `jacobian_entries`. All others have defaults.
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
      !> The last so many coordinates tell nothing that the others do not, but for whole turns: they have no part in the measure of
      !! errors.
      integer :: n_counters = 0
      !> States that are not mechanics.
      integer :: n_w = 0
      !> Sizes of the diagonal blocks of M.
      integer, allocatable :: mass_blocks(:)
      !> Whether M never changes; then it is evaluated once.
      logical :: constant_mass = .false.
      !> Whether phi and the entries of a `pattern` come out of one evaluation: then `linearization` is asked for them.
      logical :: linearizes = .false.
      !> Whether some of the forces depend on the multipliers: see `reaction_force`.
      logical :: reactive = .false.
      !> Whether the method enforces the constraints: what `enforce` was told last. A system with something of its own in their
      !! place, such as a spring, uses that when they are not.
      logical :: enforced = .true.
   contains
      procedure :: define
      procedure :: check_sizes
      !> M and f, Eq. (4).
      procedure(matrix_of_masses), deferred :: mass
      procedure(vector_at_state), deferred :: force
      !> What of the forces depends on the multipliers, of a system that is `reactive`; `power` leaves it out.
      procedure :: reaction_force => reaction_force_not_supplied
      !> phi, Eq. (5): of the holonomic constraints.
      procedure :: constraint => vector_not_supplied
      !> A, Eq. (6a): all of it, or by default what `pattern` and `jacobian_entries` say of it.
      procedure :: jacobian => scatter_entries
      procedure :: pattern => dense_pattern
      procedure :: jacobian_entries => entries_not_supplied
      !> phi and these entries at once, of a system that `linearizes`; by default one after the other.
      procedure :: linearization => constraint_and_entries
      !> Which velocities are measured in one unit, so that rows of A can be compared; by default all of them.
      procedure :: column_groups => one_group
      !> How large the system is, so that its constraints are met in any unit of length; by default as large as its coordinates.
      procedure :: sizes => sizes_of_coordinates
      !> What a constraint is called where something is said of it; by default it is numbered.
      procedure :: row_name => numbered_row
      !> b', Eq. (6a); by default zero: constraints that do not depend on time.
      procedure :: velocity_rhs => zero_vector
      !> b'', Eq. (6b).
      procedure :: acceleration_rhs => vector_not_supplied
      !> W of `weight = "given"`, Eq. (11a); by default the identity.
      procedure :: weight => unit_weight
      !> g, Eq. (18); by default zero.
      procedure :: w_rate => zero_vector
      !> Coordinates that are not the integrals of the velocities, such as unit quaternions: xdot = H v, v = H^+ xdot, a small
      !! displacement along the velocities, and what brings the coordinates back to their own manifold. By default H = I.
      procedure :: x_rate => x_rate_is_v
      procedure :: v_of_x_rate => v_is_x_rate
      procedure :: displace => add_displacement
      procedure :: normalize => leave_coordinates
      !> Told by the method at hand whether it enforces the constraints; a system that is made of others passes it on.
      procedure :: enforce => remember_enforced
      !> Total energy [J]; by default not known.
      procedure :: energy => no_energy
      !> Power of the forces that `energy` does not contain: loads, dampers, motors [W]; by default not known.
      procedure :: power => no_power
      !> Times at which a load or a drive has a kink or a jump; by default none.
      procedure :: breakpoints => no_breakpoints
      !> What only the system itself can say is wrong with it; by default nothing.
      procedure :: check_at => nothing_wrong
      !> Whether a state that meets the constraints is one that is meant, where others meet them too; by default always.
      procedure :: check_branch => no_branches
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
         !> To be filled with `set_diagonal`, `set_block` or `set_dense`; symmetric positive definite, or in one dense block
         !! semidefinite and definite along the constraints, if A has no pattern.
         type(block_diagonal_t), intent(inout) :: m
      end subroutine matrix_of_masses

      !> A vector that depends on the state: f (n) [force]; phi (n_phi) (x and t only); b' (c) (x and t only); b'' (c)
      !! (x, v and t); g (n_w).
      subroutine vector_at_state(self, at, value)
         import :: mechanical_system_t, state_t, wp
         implicit none (type, external)
         !> The system.
         class(mechanical_system_t), intent(in) :: self
         !> The state; what of it may be used is said above.
         type(state_t), intent(in) :: at
         !> The vector, all of it to be set.
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

   ! What the defaults do.
   interface
      !> All velocities are measured in one unit.
      !!
      !! A system with others, such as bodies that move and turn, gives each set of columns of A that has a unit and a part of its
      !! own a number: those of a body's translation, those of its rotation. Where constraints depend on each other is then decided
      !! with each set of columns of one size.
      module subroutine one_group(self, group)
         !> The system.
         class(mechanical_system_t), intent(in) :: self
         !> The number of the set for each velocity, from 1 on: (n); empty if there is one.
         integer, allocatable, intent(out) :: group(:)
      end subroutine one_group

      !> Sizes as large as the coordinates where a motion starts; 1 where all of them are zero.
      !!
      !! A system whose coordinates start far from what they will be, or that is small and far from its origin, knows better: so
      !! does one that has angles beside small lengths.
      module subroutine sizes_of_coordinates(self, at, length, coordinate)
         !> The system.
         class(mechanical_system_t), intent(in) :: self
         !> Where its motion starts.
         type(state_t), intent(in) :: at
         !> What a displacement along each velocity is in a system of this size: a length that is typical of its parts, 1 for an
         !! angle: (n). What is more than 1 makes no difference.
         real(wp), intent(out) :: length(:)
         !> Size of the coordinate that goes with each velocity, measured from the origin, as round-off counts: (n).
         real(wp), intent(out) :: coordinate(:)
      end subroutine sizes_of_coordinates

      !> A row by its number.
      module subroutine numbered_row(self, row, name)
         !> The system.
         class(mechanical_system_t), intent(in) :: self
         !> Which row of A.
         integer, intent(in) :: row
         !> A few words without commas.
         character(:), allocatable, intent(out) :: name
      end subroutine numbered_row

      !> A vector of zeros.
      module subroutine zero_vector(self, at, value)
         !> The system.
         class(mechanical_system_t), intent(in) :: self
         !> The state at which it is evaluated.
         type(state_t), intent(in) :: at
         !> The vector.
         real(wp), intent(out) :: value(:)
      end subroutine zero_vector

      !> A vector that tells `check_supplied` that the system has no such procedure; to everything else it is not finite.
      module subroutine vector_not_supplied(self, at, value)
         !> The system.
         class(mechanical_system_t), intent(in) :: self
         !> The state at which it is evaluated.
         type(state_t), intent(in) :: at
         !> The vector.
         real(wp), intent(out) :: value(:)
      end subroutine vector_not_supplied

      !> Forces that depend on the multipliers of the constraints, such as friction, beside those of `force`; smooth in the
      !! velocities. They are iterated until the multipliers are those of all forces.
      module subroutine reaction_force_not_supplied(self, at, lambda, value)
         !> The system.
         class(mechanical_system_t), intent(in) :: self
         !> The state; x, v, w and t may be used.
         type(state_t), intent(in) :: at
         !> Multipliers of Eq. (14b); the forces of the constraints are -A^T lambda: (c).
         real(wp), intent(in) :: lambda(:)
         !> The forces: (n).
         real(wp), intent(out) :: value(:)
      end subroutine reaction_force_not_supplied

      !> The same of the entries of A, in the order of `pattern`.
      module subroutine entries_not_supplied(self, at, values)
         !> The system.
         class(mechanical_system_t), intent(in) :: self
         !> Where; x and t may be used.
         type(state_t), intent(in) :: at
         !> The entries: (size of the pattern).
         real(wp), intent(out) :: values(:)
      end subroutine entries_not_supplied

      !> phi and the entries of A; by default one after the other.
      module subroutine constraint_and_entries(self, at, value, entries)
         !> The system.
         class(mechanical_system_t), intent(in) :: self
         !> Where; x and t may be used.
         type(state_t), intent(in) :: at
         !> phi: (n_phi).
         real(wp), intent(out) :: value(:)
         !> The entries, in the order of `pattern`.
         real(wp), intent(out) :: entries(:)
      end subroutine constraint_and_entries

      !> Where the entries of A are that can differ from zero, row by row; the default says nothing: A is dense.
      module subroutine dense_pattern(self, first, column)
         !> The system.
         class(mechanical_system_t), intent(in) :: self
         !> First entry of each row in `column`, and the number of entries plus one at the end: (c + 1).
         integer, allocatable, intent(out) :: first(:)
         !> Column of each entry, ascending within a row.
         integer, allocatable, intent(out) :: column(:)
      end subroutine dense_pattern

      !> All of A from its entries; without a `pattern`, what `vector_not_supplied` gives.
      module subroutine scatter_entries(self, at, a)
         !> The system.
         class(mechanical_system_t), intent(in) :: self
         !> Where; x and t may be used.
         type(state_t), intent(in) :: at
         !> The constraint matrix: (c, n).
         real(wp), intent(out) :: a(:, :)
      end subroutine scatter_entries

      !> A weight matrix W of the user's own, for `weight = "given"`; the default is the identity.
      module subroutine unit_weight(self, at, w)
         !> The system.
         class(mechanical_system_t), intent(in) :: self
         !> Where; x and t may be used.
         type(state_t), intent(in) :: at
         !> To be filled; symmetric positive definite, with the blocks of M.
         type(block_diagonal_t), intent(inout) :: w
      end subroutine unit_weight

      !> xdot = H(x) u; the default is H = I.
      module subroutine x_rate_is_v(self, at, u, value)
         !> The system.
         class(mechanical_system_t), intent(in) :: self
         !> Where; x and t may be used.
         type(state_t), intent(in) :: at
         !> Velocities: (n).
         real(wp), intent(in) :: u(:)
         !> xdot: (n_x).
         real(wp), intent(out) :: value(:)
      end subroutine x_rate_is_v

      !> The velocities that belong to a rate of the coordinates: H(x)^+ xdot; the default is H = I.
      module subroutine v_is_x_rate(self, at, rate, u)
         !> The system.
         class(mechanical_system_t), intent(in) :: self
         !> Where; x and t may be used.
         type(state_t), intent(in) :: at
         !> Rate of the coordinates: (n_x).
         real(wp), intent(in) :: rate(:)
         !> Velocities: (n).
         real(wp), intent(out) :: u(:)
      end subroutine v_is_x_rate

      !> x := x (+) d, a small displacement along the velocities; the default is x + d.
      module subroutine add_displacement(self, d, x)
         !> The system.
         class(mechanical_system_t), intent(in) :: self
         !> Displacement: (n).
         real(wp), intent(in) :: d(:)
         !> Coordinates: (n_x).
         real(wp), intent(inout) :: x(:)
      end subroutine add_displacement

      !> Brings coordinates that are redundant by themselves, such as unit quaternions, back to their own manifold; the
      !! default has none.
      module subroutine leave_coordinates(self, x)
         !> The system.
         class(mechanical_system_t), intent(in) :: self
         !> Coordinates: (n_x).
         real(wp), intent(inout) :: x(:)
      end subroutine leave_coordinates

      !> Sets `enforced`.
      module subroutine remember_enforced(self, yes)
         !> The system.
         class(mechanical_system_t), intent(inout) :: self
         !> Whether the constraints are enforced.
         logical, intent(in) :: yes
      end subroutine remember_enforced

      !> Total energy; the default, 'unknown', is not a number.
      module function no_energy(self, at) result(energy)
         !> The system.
         class(mechanical_system_t), intent(in) :: self
         !> The state; its x and v are used.
         type(state_t), intent(in) :: at
         !> Energy [J].
         real(wp) :: energy
      end function no_energy

      !> Power of the forces that `energy` does not contain; the default, 'unknown', is not a number.
      module function no_power(self, at) result(power)
         !> The system.
         class(mechanical_system_t), intent(in) :: self
         !> The state; all of it may be used.
         type(state_t), intent(in) :: at
         !> Power [W].
         real(wp) :: power
      end function no_power

      !> Times at which a load or a drive has a kink or a jump; the default has none.
      module function no_breakpoints(self) result(times)
         !> The system.
         class(mechanical_system_t), intent(in) :: self
         !> Times in any order [s].
         real(wp), allocatable :: times(:)
      end function no_breakpoints
   end interface

   ! Sizes and what is missing.
   interface
      !> What only the system itself can say is wrong with it, its sizes and what it supplies apart; the default knows of nothing.
      module subroutine nothing_wrong(self, at, error)
         !> The system, its sizes checked.
         class(mechanical_system_t), intent(in) :: self
         !> A state where it may be evaluated.
         type(state_t), intent(in) :: at
         !> What is wrong.
         type(error_t), allocatable, intent(inout) :: error
      end subroutine nothing_wrong

      !> Every state is meant.
      module subroutine no_branches(self, at, what)
         !> The system.
         class(mechanical_system_t), intent(in) :: self
         !> A state that meets the constraints; x and t may be used.
         type(state_t), intent(in) :: at
         !> What is on another branch, in words; not allocated if nothing is.
         character(:), allocatable, intent(out) :: what
      end subroutine no_branches

      !> Not a number, with bits of its own, that no calculation leaves behind: the answer of a procedure that is not supplied.
      pure module function not_supplied() result(value)
         !> A quiet NaN.
         real(wp) :: value
      end function not_supplied

      !> Whether a number is `not_supplied`.
      elemental module function is_not_supplied(value) result(answer)
         !> The number.
         real(wp), intent(in) :: value
         !> Whether it is.
         logical :: answer
      end function is_not_supplied

      !> States the sizes of a system; to be called once, where the system is set up.
      pure module subroutine define(self, n, c, nonholonomic, n_x, n_w, mass_blocks, constant_mass, reactive)
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
         !> Whether M never changes, so that it need be evaluated but once. Default false.
         logical, intent(in), optional :: constant_mass
         !> Whether `reaction_force` says what of the forces depends on the multipliers. Default false.
         logical, intent(in), optional :: reactive
      end subroutine define

      !> Whether the sizes make sense together.
      module subroutine check_sizes(self, error)
         !> The system.
         class(mechanical_system_t), intent(in) :: self
         !> What does not.
         type(error_t), allocatable, intent(inout) :: error
      end subroutine check_sizes

      !> Whether the system supplies what its numbers of constraints ask for.
      module subroutine check_supplied(model, at, error)
         !> The system, its sizes checked.
         class(mechanical_system_t), intent(in) :: model
         !> A state where it may be evaluated.
         type(state_t), intent(in) :: at
         !> Names the procedure that is missing.
         type(error_t), allocatable, intent(inout) :: error
      end subroutine check_supplied
   end interface

end module taut_constrained_system
