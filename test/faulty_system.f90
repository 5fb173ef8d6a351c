!> A system with one fault planted in it.
module faulty_system
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use taut, only: block_diagonal_t, mechanical_system_t, state_t, wp
   use taut_constrained_system, only: not_supplied
   implicit none (type, external)
   private
   public :: faulty_t, planted

   !> Another system, but for its fault: the procedure, row and column, and what an entry is multiplied with. Where that is not all
   !! of it, the fault has a name: `no b'`, `no b''` (zero), `swapped` (two entries of A), `lacking` (an entry of the pattern),
   !! `of v` (phi depends on a velocity), `missing` (no procedure for b''), `reactive`, `constant`, `blocks` (claims).
   type, extends(mechanical_system_t) :: faulty_t
      class(mechanical_system_t), allocatable :: right
      character(len=16) :: fault = ''
      integer :: row = 0, column = 0
      real(wp) :: factor = -1.0_wp
   contains
      procedure :: mass
      procedure :: force
      procedure :: constraint
      procedure :: jacobian
      procedure :: pattern
      procedure :: jacobian_entries
      procedure :: velocity_rhs
      procedure :: acceleration_rhs
      procedure :: w_rate
      procedure :: x_rate
      procedure :: v_of_x_rate
      procedure :: displace
      procedure :: normalize
   end type faulty_t

contains

   !> A system with a fault.
   function planted(right, fault, row, column, factor) result(self)
      class(mechanical_system_t), intent(in) :: right
      character(*), intent(in) :: fault
      integer, intent(in) :: row, column
      real(wp), intent(in) :: factor
      type(faulty_t) :: self

      allocate (self%right, source=right)
      call self%define(n=right%n, c=right%c, nonholonomic=right%c - right%n_phi, n_x=right%n_x, n_w=right%n_w, &
                       mass_blocks=right%mass_blocks, constant_mass=right%constant_mass)
      self%fault = fault
      self%row = row
      self%column = column
      self%factor = factor
      if (fault == 'constant') self%constant_mass = .true.
      if (fault == 'reactive') self%reactive = .true.
      if (fault == 'blocks') self%mass_blocks = spread(1, 1, right%n)
   end function planted

   !> Plants the fault in a vector of its name; a factor of zero unsets the entry.
   subroutine plant(self, fault, value)
      class(faulty_t), intent(in) :: self
      character(*), intent(in) :: fault
      real(wp), intent(inout) :: value(:)

      if (self%fault /= fault) return
      value(self%row) = self%factor*value(self%row)
      if (.not. abs(self%factor) > 0.0_wp) value(self%row) = ieee_value(1.0_wp, ieee_quiet_nan)
   end subroutine plant

   subroutine mass(self, at, m)
      class(faulty_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m
      type(block_diagonal_t) :: full
      real(wp) :: k(self%n, self%n)

      select case (self%fault)
      case ('M', 'blocks')
         call full%init(self%right%mass_blocks)
         call self%right%mass(at, full)
         k = full%dense()
         if (self%fault == 'M') k(self%row, self%column) = self%factor*k(self%row, self%column)
         call m%set_dense(k)
      case default
         call self%right%mass(at, m)
      end select
   end subroutine mass

   subroutine force(self, at, value)
      class(faulty_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      call self%right%force(at, value)
      call plant(self, 'f', value)
   end subroutine force

   subroutine constraint(self, at, value)
      class(faulty_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      call self%right%constraint(at, value)
      call plant(self, 'phi', value)
      if (self%fault == 'of v') value(self%row) = value(self%row) + self%factor*at%v(self%column)
   end subroutine constraint

   subroutine jacobian(self, at, a)
      class(faulty_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)

      call self%right%jacobian(at, a)
      call plant(self, 'A', a(:, self%column))
      if (self%fault == 'swapped') a(self%row, self%column:self%column + 1) = a(self%row, self%column + 1:self%column:-1)
   end subroutine jacobian

   subroutine pattern(self, first, column)
      class(faulty_t), intent(in) :: self
      integer, allocatable, intent(out) :: first(:), column(:)

      if (.not. any(self%fault == [character(len=7) :: 'entries', 'lacking'])) return
      call self%right%pattern(first, column)
      if (self%fault == 'entries') return
      column = [column(:self%row - 1), column(self%row + 1:)]
      where (first > self%row) first = first - 1
   end subroutine pattern

   subroutine jacobian_entries(self, at, values)
      class(faulty_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: values(:)
      real(wp), allocatable :: all_values(:)
      integer, allocatable :: column(:), first(:)

      if (self%fault == 'lacking') then
         call self%right%pattern(first, column)
         allocate (all_values(size(column)))
         call self%right%jacobian_entries(at, all_values)
         values(:) = [all_values(:self%row - 1), all_values(self%row + 1:)]
         return
      end if
      call self%right%jacobian_entries(at, values)
      call plant(self, 'entries', values)
   end subroutine jacobian_entries

   subroutine velocity_rhs(self, at, value)
      class(faulty_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      call self%right%velocity_rhs(at, value)
      call plant(self, 'b''', value)
      if (self%fault == 'no b''') value(self%row) = 0.0_wp
   end subroutine velocity_rhs

   subroutine acceleration_rhs(self, at, value)
      class(faulty_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      call self%right%acceleration_rhs(at, value)
      call plant(self, 'b''''', value)
      if (self%fault == 'no b''''') value(self%row) = 0.0_wp
      if (self%fault == 'missing') value(:) = not_supplied()
   end subroutine acceleration_rhs

   subroutine w_rate(self, at, value)
      class(faulty_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      call self%right%w_rate(at, value)
      call plant(self, 'g', value)
   end subroutine w_rate

   subroutine x_rate(self, at, u, value)
      class(faulty_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: u(:)
      real(wp), intent(out) :: value(:)

      call self%right%x_rate(at, u, value)
      call plant(self, 'H', value)
   end subroutine x_rate

   subroutine v_of_x_rate(self, at, rate, u)
      class(faulty_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: rate(:)
      real(wp), intent(out) :: u(:)

      call self%right%v_of_x_rate(at, rate, u)
      call plant(self, 'H^+', u)
   end subroutine v_of_x_rate

   subroutine displace(self, d, x)
      class(faulty_t), intent(in) :: self
      real(wp), intent(in) :: d(:)
      real(wp), intent(inout) :: x(:)
      real(wp) :: moved(size(d))

      moved = d
      call plant(self, 'displace', moved)
      call self%right%displace(moved, x)
   end subroutine displace

   subroutine normalize(self, x)
      class(faulty_t), intent(in) :: self
      real(wp), intent(inout) :: x(:)

      call self%right%normalize(x)
      call plant(self, 'normalize', x)
   end subroutine normalize

end module faulty_system
