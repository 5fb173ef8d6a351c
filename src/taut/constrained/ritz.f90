!> A mechanical system described by Ritz shapes over its coordinates (Sect. 3.4.2): x = x_0 + X q, v = X r.
!!
!! M, W, f and A are reduced as in Eqs (23)-(26): X^T M X, X^T W X, X^T f, A X; phi, b' and b'' are those of the full system.
!! Where the shapes cannot meet the constraints, A X is not of full row rank: the constraints become mildly inconsistent. That
!! is refused, with the residual named, unless the method has `accept_inconsistent`, and then it is reported as violation.
!!
!! Shapes over coordinates that are not the integrals of the velocities, such as quaternions, have no meaning; flexible bodies
!! that turn are modal bodies in a floating frame. Each evaluation makes the full state anew, for the systems are not to be
!! written to.
module taut_constrained_ritz
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_constrained_system, only: is_not_supplied, mechanical_system_t, not_supplied, state_t
   use taut_constrained_system_tables, only: name_length, quantity_t, tabulated_system_t
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_pseudo_inverse, only: pseudo_inverse_t
   implicit none (type, external)
   private
   public :: new_ritz, ritz_t

   !> The reduced system; its coordinates are the amplitudes q.
   type, extends(tabulated_system_t) :: ritz_t
      !> The full system.
      class(mechanical_system_t), allocatable :: full
      !> X: (n of the full system, shapes).
      real(wp), allocatable :: shapes(:, :)
      !> Coordinates of the full system where q = 0.
      real(wp), allocatable :: x_0(:)
   contains
      procedure :: full_state
      procedure :: mass
      procedure :: weight
      procedure :: force
      procedure :: reaction_force
      procedure :: constraint
      procedure :: jacobian
      procedure :: velocity_rhs
      procedure :: acceleration_rhs
      procedure :: w_rate
      procedure :: energy
      procedure :: power
      procedure :: breakpoints
      procedure :: enforce
      procedure :: output_name
      procedure :: outputs
      procedure :: quantities
      procedure :: describe
      procedure :: note
      procedure :: event_name
      procedure :: event_values
   end type ritz_t

contains

   !> Reduces a system to shapes.
   subroutine new_ritz(self, full, shapes, x_0, error)
      !> The reduced system.
      type(ritz_t), intent(out) :: self
      !> The full system; copied.
      class(mechanical_system_t), intent(in) :: full
      !> X, one column per shape, linearly independent: (n, shapes).
      real(wp), intent(in) :: shapes(:, :)
      !> Coordinates where q = 0: (n).
      real(wp), intent(in) :: x_0(:)
      !> Shapes that do not fit or are not independent.
      type(error_t), allocatable, intent(inout) :: error
      character(*), parameter :: here = 'Ritz shapes'
      type(pseudo_inverse_t) :: gram
      type(state_t) :: at
      real(wp) :: a(full%c, full%n)
      real(wp), allocatable :: reduced(:, :)
      integer :: info

      call full%check_sizes(error)
      if (allocated(error)) return
      if (full%n_x /= full%n) then
         call raise(error, here, 'the coordinates of the system are not the integrals of its velocities', &
                    'use a modal body in a floating frame')
      else if (size(shapes, 1) /= full%n .or. size(x_0) /= full%n) then
         call raise(error, here, 'they have '//to_text(size(shapes, 1))//' rows for '//to_text(full%n)//' coordinates', &
                    'give one row for each coordinate, and as many coordinates for q = 0')
      else
         call gram%init(size(shapes, 2))
         call gram%compute(matmul(transpose(shapes), shapes), info)
         if (info /= 0 .or. gram%rank < size(shapes, 2)) &
            call raise(error, here, 'of '//to_text(size(shapes, 2))//' shapes '//to_text(gram%rank)//' are independent', &
                       'leave the others out')
      end if
      if (allocated(error)) return
      allocate (self%full, source=full)
      allocate (self%shapes, source=shapes)
      allocate (self%x_0, source=x_0)
      call self%define(n=size(shapes, 2), c=full%c, nonholonomic=full%c - full%n_phi, n_w=full%n_w, &
                       constant_mass=full%constant_mass, reactive=full%reactive)
      select type (full)
      class is (tabulated_system_t)
         self%n_outputs = full%n_outputs
         self%n_events = full%n_events
      end select
      if (full%c == 0) return
      at%x = x_0
      allocate (at%v(full%n), at%w(full%n_w), source=0.0_wp)
      call full%jacobian(at, a)
      reduced = matmul(a, shapes)
      call gram%init(full%c)
      call gram%compute(matmul(reduced, transpose(reduced)), info)
      ! Shapes along the constraints, such as modes of the constrained system, leave them nothing to work with: their
      ! multipliers, and the stiffness that these give, would be lost.
      if (gram%rank == 0) &
         call raise(error, here, 'they do not move any constraint: the constraints would be lost', &
                    'use shapes of the system without its constraints')
   end subroutine new_ritz

   !> The state of the full system.
   function full_state(self, at) result(there)
      !> The reduced system.
      class(ritz_t), intent(in) :: self
      !> Its state.
      type(state_t), intent(in) :: at
      !> x = x_0 + X q, v = X r.
      type(state_t) :: there
      integer :: i, j

      there%t = at%t
      allocate (there%x(self%full%n), there%v(self%full%n), source=0.0_wp)
      ! Small systems are slowed down by what MATMUL prepares.
      do j = 1, self%n
         !GCC$ unroll 1
         do i = 1, self%full%n
            there%x(i) = there%x(i) + self%shapes(i, j)*at%x(j)
            there%v(i) = there%v(i) + self%shapes(i, j)*at%v(j)
         end do
      end do
      there%x(:) = self%x_0 + there%x
      if (self%n_w > 0) allocate (there%w, source=at%w)
   end function full_state

   !> X^T K X.
   subroutine reduce(self, k, reduced)
      class(ritz_t), intent(in) :: self
      type(block_diagonal_t), intent(in) :: k
      type(block_diagonal_t), intent(inout) :: reduced
      real(wp) :: kx(self%full%n, self%n)
      integer :: j

      do j = 1, self%n
         call k%multiply(self%shapes(:, j), kx(:, j))
      end do
      call reduced%set_dense(matmul(transpose(self%shapes), kx))
   end subroutine reduce

   !> X^T M X.
   subroutine mass(self, at, m)
      !> The reduced system.
      class(ritz_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> The reduced mass matrix, one dense block.
      type(block_diagonal_t), intent(inout) :: m
      type(block_diagonal_t) :: k

      call k%init(self%full%mass_blocks)
      call self%full%mass(self%full_state(at), k)
      call reduce(self, k, m)
   end subroutine mass

   !> X^T W X, for `weight = "given"`.
   subroutine weight(self, at, w)
      !> The reduced system.
      class(ritz_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> The reduced weight, one dense block.
      type(block_diagonal_t), intent(inout) :: w
      type(block_diagonal_t) :: k

      call k%init(self%full%mass_blocks)
      call self%full%weight(self%full_state(at), k)
      call reduce(self, k, w)
   end subroutine weight

   !> X^T f.
   subroutine force(self, at, value)
      !> The reduced system.
      class(ritz_t), intent(in) :: self
      !> The state; all of it may be used.
      type(state_t), intent(in) :: at
      !> The reduced force: (n).
      real(wp), intent(out) :: value(:)
      real(wp) :: f(self%full%n)

      call self%full%force(self%full_state(at), f)
      value(:) = matmul(f, self%shapes)
   end subroutine force

   !> X^T g.
   subroutine reaction_force(self, at, lambda, value)
      !> The reduced system.
      class(ritz_t), intent(in) :: self
      !> The state; all of it may be used.
      type(state_t), intent(in) :: at
      !> Multipliers: (c).
      real(wp), intent(in) :: lambda(:)
      !> The reduced force: (n).
      real(wp), intent(out) :: value(:)
      real(wp) :: g(self%full%n)

      call self%full%reaction_force(self%full_state(at), lambda, g)
      value(:) = 0.0_wp
      if (self%reactive) then
         value(:) = matmul(g, self%shapes)
      else if (any(is_not_supplied(g))) then
         value(:) = not_supplied()
      end if
   end subroutine reaction_force

   !> phi of the full system.
   subroutine constraint(self, at, value)
      !> The reduced system.
      class(ritz_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> phi: (n_phi).
      real(wp), intent(out) :: value(:)

      call self%full%constraint(self%full_state(at), value)
   end subroutine constraint

   !> A X.
   subroutine jacobian(self, at, a)
      !> The reduced system.
      class(ritz_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> The reduced constraint matrix: (c, n).
      real(wp), intent(out) :: a(:, :)
      real(wp) :: a_full(self%c, self%full%n)

      call self%full%jacobian(self%full_state(at), a_full)
      a(:, :) = matmul(a_full, self%shapes)
   end subroutine jacobian

   !> b' of the full system.
   subroutine velocity_rhs(self, at, value)
      !> The reduced system.
      class(ritz_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> b': (c).
      real(wp), intent(out) :: value(:)

      call self%full%velocity_rhs(self%full_state(at), value)
   end subroutine velocity_rhs

   !> b'' of the full system.
   subroutine acceleration_rhs(self, at, value)
      !> The reduced system.
      class(ritz_t), intent(in) :: self
      !> The state; its x, v and t are used.
      type(state_t), intent(in) :: at
      !> b'': (c).
      real(wp), intent(out) :: value(:)

      call self%full%acceleration_rhs(self%full_state(at), value)
   end subroutine acceleration_rhs

   !> g of the full system.
   subroutine w_rate(self, at, value)
      !> The reduced system.
      class(ritz_t), intent(in) :: self
      !> The state; all of it may be used.
      type(state_t), intent(in) :: at
      !> g: (n_w).
      real(wp), intent(out) :: value(:)

      call self%full%w_rate(self%full_state(at), value)
   end subroutine w_rate

   !> Energy of the full system.
   function energy(self, at)
      !> The reduced system.
      class(ritz_t), intent(in) :: self
      !> The state; its x and v are used.
      type(state_t), intent(in) :: at
      !> The energy [J].
      real(wp) :: energy

      energy = self%full%energy(self%full_state(at))
   end function energy

   !> Breakpoints of the full system.
   function breakpoints(self) result(times)
      !> The reduced system.
      class(ritz_t), intent(in) :: self
      !> Times [s].
      real(wp), allocatable :: times(:)

      times = self%full%breakpoints()
   end function breakpoints

   !> Power of the full system.
   function power(self, at)
      !> The reduced system.
      class(ritz_t), intent(in) :: self
      !> The state; all of it may be used.
      type(state_t), intent(in) :: at
      !> The power [W].
      real(wp) :: power

      power = self%full%power(self%full_state(at))
   end function power

   !> Tells the full system whether the constraints are enforced.
   subroutine enforce(self, yes)
      !> The reduced system.
      class(ritz_t), intent(inout) :: self
      !> Whether they are.
      logical, intent(in) :: yes

      self%enforced = yes
      call self%full%enforce(yes)
   end subroutine enforce

   !> Name of a further column of the full system.
   function output_name(self, i) result(name)
      !> The reduced system.
      class(ritz_t), intent(in) :: self
      !> Index of the output.
      integer, intent(in) :: i
      !> Without commas and blanks.
      character(len=name_length) :: name

      name = ''
      select type (full => self%full)
      class is (tabulated_system_t)
         name = full%output_name(i)
      end select
   end function output_name

   !> Outputs of the full system.
   subroutine outputs(self, at, lambda, values)
      !> The reduced system.
      class(ritz_t), intent(in) :: self
      !> The state that the row of the table is about.
      type(state_t), intent(in) :: at
      !> Multipliers: (c).
      real(wp), intent(in) :: lambda(:)
      !> The numbers: (n_outputs).
      real(wp), intent(out) :: values(:)

      values(:) = 0.0_wp
      select type (full => self%full)
      class is (tabulated_system_t)
         call full%outputs(self%full_state(at), lambda, values)
      end select
   end subroutine outputs

   !> What the full system knows about itself.
   function quantities(self) result(list)
      !> The reduced system.
      class(ritz_t), intent(in) :: self
      !> In the order of a table.
      type(quantity_t), allocatable :: list(:)

      allocate (list(0))
      select type (full => self%full)
      class is (tabulated_system_t)
         list = full%quantities()
      end select
   end function quantities

   !> What people are told of the full system before a run.
   subroutine describe(self, text)
      !> The reduced system.
      class(ritz_t), intent(in) :: self
      !> Lines with their ends.
      character(:), allocatable, intent(out) :: text

      text = ''
      select type (full => self%full)
      class is (tabulated_system_t)
         call full%describe(text)
      end select
   end subroutine describe

   !> What a reader of results has to know of the full system.
   subroutine note(self, text)
      !> The reduced system.
      class(ritz_t), intent(in) :: self
      !> One line without commas.
      character(:), allocatable, intent(out) :: text

      text = ''
      select type (full => self%full)
      class is (tabulated_system_t)
         call full%note(text)
      end select
   end subroutine note

   !> Name of an event of the full system.
   function event_name(self, i) result(name)
      !> The reduced system.
      class(ritz_t), intent(in) :: self
      !> Index of the event.
      integer, intent(in) :: i
      !> Without commas and blanks.
      character(len=name_length) :: name

      name = ''
      select type (full => self%full)
      class is (tabulated_system_t)
         name = full%event_name(i)
      end select
   end function event_name

   !> Events of the full system.
   subroutine event_values(self, at, values)
      !> The reduced system.
      class(ritz_t), intent(in) :: self
      !> The state at which they are evaluated.
      type(state_t), intent(in) :: at
      !> The functions: (n_events).
      real(wp), intent(out) :: values(:)

      values(:) = 1.0_wp
      select type (full => self%full)
      class is (tabulated_system_t)
         call full%event_values(self%full_state(at), values)
      end select
   end subroutine event_values

end module taut_constrained_ritz
