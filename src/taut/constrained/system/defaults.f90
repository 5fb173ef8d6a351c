!> The defaults of `mechanical_system_t`, most of which do nothing, and whether one stands where it must not.
submodule(taut_constrained_system) taut_constrained_system_defaults
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
   use, intrinsic :: iso_fortran_env, only: int64
   use taut_error, only: raise, to_text
   implicit none (type, external)

   !> The bits of a quiet NaN, and in its payload the word taut.
   integer(int64), parameter :: mark = int(z'7FF8000074617574', int64)

contains

   module procedure numbered_row
      name = 'constraint '//to_text(row)
      associate (unused_system => self)
      end associate
   end procedure numbered_row

   module procedure one_group
      allocate (group(0))
      associate (unused_system => self)
      end associate
   end procedure one_group

   module procedure sizes_of_coordinates
      real(wp) :: largest

      largest = maxval([0.0_wp, abs(at%x)])
      coordinate(:) = largest
      if (self%n == self%n_x) coordinate(:) = abs(at%x)
      length(:) = merge(largest, 1.0_wp, largest > 0.0_wp)
   end procedure sizes_of_coordinates

   !> A vector of zeros.
   module procedure zero_vector
      value(:) = 0.0_wp
      associate (unused_system => self, unused_state => at)
      end associate
   end procedure zero_vector

   !> A vector that tells that the system has no such procedure.
   module procedure vector_not_supplied
      value(:) = not_supplied()
      associate (unused_system => self, unused_state => at)
      end associate
   end procedure vector_not_supplied

   !> Entries of A that tell the same.
   module procedure reaction_force_not_supplied
      value(:) = not_supplied()
      associate (unused_system => self, unused_state => at, unused_multipliers => lambda)
      end associate
   end procedure reaction_force_not_supplied

   !> The same.
   module procedure entries_not_supplied
      values(:) = not_supplied()
      associate (unused_system => self, unused_state => at)
      end associate
   end procedure entries_not_supplied

   !> Where the entries of A are that can differ from zero, row by row; the default says nothing: A is dense.
   module procedure dense_pattern
      associate (unused_system => self, unused_first => first, unused_column => column)
      end associate
   end procedure dense_pattern

   !> phi, and then the entries of A.
   module procedure constraint_and_entries
      call self%constraint(at, value)
      call self%jacobian_entries(at, entries)
   end procedure constraint_and_entries

   !> All of A from its entries.
   module procedure scatter_entries
      integer, allocatable :: first(:), column(:)
      real(wp), allocatable :: values(:)
      integer :: i, k

      a(:, :) = 0.0_wp
      call self%pattern(first, column)
      if (.not. (allocated(first) .and. allocated(column))) then
         a(:, :) = not_supplied()
         return
      end if
      allocate (values(size(column)))
      call self%jacobian_entries(at, values)
      do i = 1, self%c
         do k = first(i), first(i + 1) - 1
            a(i, column(k)) = values(k)
         end do
      end do
   end procedure scatter_entries

   !> A weight matrix W of the user's own, for `weight = "given"`; the default is the identity.
   module procedure unit_weight
      call w%set_identity()
      associate (unused_system => self, unused_state => at)
      end associate
   end procedure unit_weight

   !> xdot = H(x) u; the default is H = I.
   module procedure x_rate_is_v
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
   end procedure x_rate_is_v

   !> The velocities that belong to a rate of the coordinates: H(x)^+ xdot; the default is H = I.
   module procedure v_is_x_rate
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
   end procedure v_is_x_rate

   !> x := x (+) d, a small displacement along the velocities; the default is x + d.
   module procedure add_displacement
      integer :: i

      !GCC$ unroll 1
      do i = 1, size(d)
         x(i) = x(i) + d(i)
      end do
      associate (unused_system => self)
      end associate
   end procedure add_displacement

   !> Brings coordinates that are redundant by themselves, such as unit quaternions, back to their own manifold.
   module procedure leave_coordinates
      associate (unused_system => self, unused_coordinates => x)
      end associate
   end procedure leave_coordinates

   !> Sets `enforced`.
   module procedure remember_enforced
      self%enforced = yes
   end procedure remember_enforced

   !> Total energy; the default, 'unknown', is not a number.
   module procedure no_energy
      energy = ieee_value(energy, ieee_quiet_nan)
      associate (unused_system => self, unused_state => at)
      end associate
   end procedure no_energy

   !> Power of the forces that energy does not contain; the default, 'unknown', is not a number.
   module procedure no_power
      power = ieee_value(power, ieee_quiet_nan)
      associate (unused_system => self, unused_state => at)
      end associate
   end procedure no_power

   !> Times at which a load or a drive has a kink or a jump; the default has none.
   module procedure no_breakpoints
      allocate (times(0))
      associate (unused_system => self)
      end associate
   end procedure no_breakpoints

   !> Not a number, with bits of its own: no calculation leaves it behind.
   module procedure not_supplied
      integer(int64) :: bits

      ! Not a named constant, of which the compiler would keep only that it is not a number.
      bits = mark
      value = transfer(bits, value)
   end procedure not_supplied

   !> Whether a number is `not_supplied`.
   module procedure is_not_supplied
      answer = transfer(value, mark) == mark
   end procedure is_not_supplied

   !> What only the system itself can say is wrong with it; the default knows of nothing.
   module procedure nothing_wrong
      associate (unused_system => self, unused_state => at, unused_error => error)
      end associate
   end procedure nothing_wrong

   !> Every state is meant.
   module procedure no_branches
      associate (unused_system => self, unused_state => at, unused_text => what)
      end associate
   end procedure no_branches

   !> Whether the system supplies what its numbers of constraints ask for.
   module subroutine check_supplied(model, at, error)
      class(mechanical_system_t), intent(in) :: model
      type(state_t), intent(in) :: at
      type(error_t), allocatable, intent(inout) :: error
      integer, allocatable :: column(:), first(:)
      real(wp), allocatable :: a(:, :), b(:), entries(:), phi(:)

      call model%check_at(at, error)
      if (allocated(error)) return
      allocate (b(model%c), phi(model%n_phi), source=0.0_wp)
      call check_reactive(model, at, b, error)
      call model%constraint(at, phi)
      call need('constraint', phi, error)
      if (model%c == 0) return
      call model%acceleration_rhs(at, b)
      call need('acceleration_rhs', b, error)
      call model%pattern(first, column)
      if (allocated(first)) then
         allocate (entries(size(column)), source=0.0_wp)
         call model%jacobian_entries(at, entries)
         call need('jacobian_entries', entries, error)
      else
         allocate (a(model%c, model%n), source=0.0_wp)
         call model%jacobian(at, a)
         call need('jacobian', a(1, :), error)
      end if
   end subroutine check_supplied

   !> Whether forces that depend on multipliers are there where they are announced, and announced where they are there.
   subroutine check_reactive(model, at, lambda, error)
      class(mechanical_system_t), intent(in) :: model
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: lambda(:)
      type(error_t), allocatable, intent(inout) :: error
      real(wp) :: value(model%n)
      logical :: supplied

      value(:) = 0.0_wp
      call model%reaction_force(at, lambda, value)
      supplied = .not. any(is_not_supplied(value))
      if (model%reactive .and. .not. supplied) then
         call raise(error, 'mechanical system', 'it is reactive and has no procedure reaction_force', &
                    'supply it, or leave reactive out of the call of define')
      else if (supplied .and. .not. model%reactive) then
         call raise(error, 'mechanical system', 'it has a procedure reaction_force that would not be asked', &
                    'say reactive=.true. in the call of define')
      end if
   end subroutine check_reactive

   !> Complains about the answer of a default.
   subroutine need(name, answer, error)
      character(*), intent(in) :: name
      real(wp), intent(in) :: answer(:)
      type(error_t), allocatable, intent(inout) :: error

      if (any(is_not_supplied(answer))) &
         call raise(error, 'mechanical system', 'it has constraints and no procedure '//name, &
                    'supply it: taut_constrained_system says what it has to answer')
   end subroutine need

end submodule taut_constrained_system_defaults
