!> What can be found out about an `automatic_system_t` by looking at it once.
submodule(taut_constrained_system_automatic) taut_constrained_system_automatic_structure
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use taut_constrained_system, only: is_not_supplied
   use taut_error, only: raise, to_text
   use taut_jet_number, only: doubt
   use taut_linalg_coloring, only: color_columns
   implicit none (type, external)

   character(*), parameter :: here = 'mechanical system'

contains

   !> Finds out what each constraint depends on.
   !!
   !! A derivative that is not a number makes every result so that depends on it, whatever the values are. Of the columns, half are
   !! asked for at first, then halves of those that a row depends on, and so on: of a matrix with k entries a row it takes about
   !! k log2(n) evaluations.
   module procedure find_structure
      integer, allocatable :: begin(:), column(:), color(:), first(:)
      integer :: colors, i, k

      if (allocated(self%first)) deallocate (self%first, self%column)
      if (allocated(self%direction)) deallocate (self%direction, self%place_of_entry)
      if (allocated(self%seeds)) deallocate (self%seeds)
      self%sparse = .false.
      self%linearizes = .false.
      self%plain_rates = .false.
      self%plain_rates = rates_are_plain(self, at)
      self%rheonomic = self%n_phi < self%c .or. depends_on_time(self, at)
      if (self%c == 0) return

      ! One part with all columns, that every row depends on.
      begin = [1, self%n + 1]
      first = [(i, i=1, self%c + 1)]
      column = spread(1, 1, self%c)
      do while (size(begin) <= self%n)
         call split(begin, first, column)
         allocate (color(size(begin) - 1))
         call color_columns(first, column, color, colors)
         call keep_what_depends(self, at, begin, color, colors, first, column)
         deallocate (color)
      end do

      allocate (self%direction(self%n))
      call color_columns(first, column, self%direction, self%colors)
      allocate (self%place_of_entry(size(column)))
      do i = 1, self%c
         do k = first(i), first(i + 1) - 1
            self%place_of_entry(k) = self%place_of_slope(i, self%direction(column(k)))
         end do
      end do
      self%sparse = 2*size(column) <= self%c*self%n
      call move_alloc(first, self%first)
      call move_alloc(column, self%column)
      self%linearizes = self%sparse .and. self%n_phi == self%c .and. self%passes() == 1
      if (.not. self%plain_rates) return
      allocate (self%seeds(self%n_x, self%passes()))
      self%seeds = jet(0.0_wp)
      do i = 1, size(self%seeds, 2)
         call point(self%direction - directions*(i - 1), self%seeds(:, i))
      end do
   end procedure find_structure

   !> Halves parts that have more than one column.
   subroutine split(begin, first, column)
      integer, allocatable, intent(inout) :: begin(:), first(:), column(:)
      integer, allocatable :: child(:), halves(:), new_begin(:), new_column(:), new_first(:)
      integer :: i, k, p, parts

      parts = size(begin) - 1
      allocate (child(parts), halves(parts), new_begin(0))
      do p = 1, parts
         halves(p) = min(2, begin(p + 1) - begin(p))
      end do
      allocate (new_column(2*size(column)), new_first(size(first)))
      deallocate (new_begin)
      allocate (new_begin(sum(halves) + 1))
      k = 0
      do p = 1, parts
         child(p) = k + 1
         new_begin(k + 1) = begin(p)
         if (halves(p) == 2) new_begin(k + 2) = (begin(p) + begin(p + 1))/2
         k = k + halves(p)
      end do
      new_begin(k + 1) = begin(parts + 1)
      k = 0
      do i = 1, size(first) - 1
         new_first(i) = k + 1
         do p = first(i), first(i + 1) - 1
            new_column(k + 1) = child(column(p))
            if (halves(column(p)) == 2) new_column(k + 2) = child(column(p)) + 1
            k = k + halves(column(p))
         end do
      end do
      new_first(size(first)) = k + 1
      call move_alloc(new_begin, begin)
      call move_alloc(new_first, first)
      column = new_column(1:k)
   end subroutine split

   !> Keeps of each row the parts that it depends on.
   subroutine keep_what_depends(self, at, begin, color, colors, first, column)
      class(automatic_system_t), intent(in) :: self
      type(state_t), intent(in) :: at
      integer, intent(in) :: begin(:), color(:), colors
      integer, intent(inout) :: first(:)
      integer, allocatable, intent(inout) :: column(:)
      type(jet_t), allocatable :: r(:), rate(:)
      type(jet_t), allocatable, target :: v(:), x(:)
      type(jet_state_t) :: there
      logical, allocatable :: depends(:)
      integer :: base, d, i, k, kept, next, p

      allocate (x(self%n_x), rate(self%n_x), v(self%n), r(self%c), depends(size(column)))
      there%t = jet(at%t)
      there%x => x
      there%v => v
      depends = .false.
      do base = 0, colors - 1, directions
         v(:) = jet(at%v)
         do p = 1, size(color)
            call doubt(color(p) - base, v(begin(p):begin(p + 1) - 1))
         end do
         call self%carry(at, there, rate)
         if (self%n_phi > 0) call self%phi(there, r(1:self%n_phi))
         if (self%n_phi < self%c) then
            x(:) = jet(at%x)
            call self%nonholonomic(there, r(self%n_phi + 1:self%c))
         end if
         do i = 1, self%c
            do k = first(i), first(i + 1) - 1
               d = color(column(k)) - base
               if (d >= 1 .and. d <= directions) depends(k) = ieee_is_nan(r(i)%d(d))
            end do
         end do
      end do
      kept = 0
      next = 1
      do i = 1, self%c
         do k = next, first(i + 1) - 1
            if (.not. depends(k)) cycle
            kept = kept + 1
            column(kept) = column(k)
         end do
         next = first(i + 1)
         first(i + 1) = kept + 1
      end do
      column = column(1:kept)
   end subroutine keep_what_depends

   !> Whether xdot = v: it is so at a state, with any velocities, and does not depend on the coordinates.
   logical function rates_are_plain(self, at)
      class(automatic_system_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(jet_t), allocatable :: rate(:)
      type(jet_t), allocatable, target :: v(:), x(:)
      type(jet_state_t) :: there
      integer :: i

      rates_are_plain = self%n_x == self%n
      if (.not. rates_are_plain) return
      allocate (x(self%n_x), rate(self%n_x), v(self%n))
      there%t = jet(at%t)
      there%x => x
      there%v => v
      do i = 1, self%n
         x(i) = jet(at%x(i))
         call doubt(1, x(i))
         v(i) = jet(real(i, wp) + 0.5_wp)
      end do
      call self%kinematics(there, rate)
      rates_are_plain = .not. any(ieee_is_nan(rate%d(1)) .or. abs(rate%v - v%v) > 0.0_wp)
   end function rates_are_plain

   !> Whether phi depends on time.
   logical function depends_on_time(self, at)
      class(automatic_system_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(jet_t) :: r(self%n_phi)
      type(jet_t), target :: x(self%n_x)
      type(jet_state_t) :: there

      x = jet(at%x)
      there%x => x
      there%t = jet(at%t)
      call doubt(1, there%t)
      call self%phi(there, r)
      depends_on_time = any(ieee_is_nan(r%d(1)))
   end function depends_on_time

   !> What is missing; constraints that are not linear in the velocities; a mass matrix that changes and must not.
   module procedure check_at
      type(jet_t), allocatable :: r(:)
      type(jet_t), allocatable, target :: v(:), x(:)
      type(jet_state_t) :: there
      integer :: i

      allocate (x(self%n_x), v(self%n), r(self%c))
      x(:) = jet(at%x)
      there%t = jet(at%t)
      there%x => x
      there%v => v
      call self%phi(there, r(1:self%n_phi))
      if (any(is_not_supplied(r(1:self%n_phi)%v))) then
         call self%constraint(at, r(1:self%n_phi)%v)
         if (any(is_not_supplied(r(1:self%n_phi)%v))) &
            call raise(error, here, 'it has constraints and no procedure phi', 'supply it: phi(x, t), zero where they are met')
      end if
      ! The second derivative along any velocity is that of what is not linear.
      do i = 1, self%n
         v(i) = jet(at%v(i), 1.0_wp/(1.0_wp + 0.37_wp*i), 0.0_wp)
      end do
      associate (rows => r(self%n_phi + 1:self%c))
         call self%nonholonomic(there, rows)
         do i = 1, size(rows)
            if (is_not_supplied(rows(i)%v)) then
               call need_rows(self, at, error)
               exit
            end if
            if (abs(rows(i)%dd) > 1.0e-10_wp*max(abs(rows(i)%v), abs(rows(i)%d(1)))) &
               call raise(error, here, 'constraint '//to_text(self%n_phi + i)//' is not linear in the velocities', &
                          'give A v - b'' in nonholonomic')
         end do
      end associate
      call check_masses(self, at, error)
   end procedure check_at

   !> Rows that are not holonomic may be written by hand.
   subroutine need_rows(self, at, error)
      class(automatic_system_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(error_t), allocatable, intent(inout) :: error
      real(wp) :: b(self%c)

      call self%velocity_rhs(at, b)
      if (any(is_not_supplied(-b))) &
         call raise(error, here, 'it has constraints and no procedure nonholonomic', 'supply it: A v - b'', affine in v')
   end subroutine need_rows

   !> What `masses` gives against what the system says of M and of f.
   subroutine check_masses(self, at, error)
      class(automatic_system_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(error_t), allocatable, intent(inout) :: error
      type(block_diagonal_t) :: m
      type(jet_t), allocatable :: k(:, :)
      type(jet_t), allocatable, target :: x(:)
      type(jet_state_t) :: there
      integer :: i

      if (allocated(self%diagonal_mass)) then
         if (size(self%diagonal_mass) /= self%n) &
            call raise(error, here, 'its diagonal_mass has '//to_text(size(self%diagonal_mass))//' entries', &
                       'give one for each of its '//to_text(self%n)//' velocities')
         return
      end if
      allocate (k(self%n, self%n))
      k = jet(0.0_wp)
      x = jet(at%x)
      there%t = jet(at%t)
      there%x => x
      do i = 1, self%n_x
         call doubt(1, x(i))
      end do
      call doubt(1, there%t)
      call self%masses(there, k)
      if (is_not_supplied(k(1, 1)%v)) then
         call m%init(self%mass_blocks)
         m%values(:) = 0.0_wp
         call self%mass(at, m)
         if (any(is_not_supplied(m%values))) &
            call raise(error, here, 'it has no mass matrix', 'supply diagonal_mass, mass, or masses with jets')
      else if (any(ieee_is_nan(k%d(1)))) then
         if (self%constant_mass) &
            call raise(error, here, 'its masses depend on coordinates or time, and it says that M never changes', &
                       'give define constant_mass = .false.')
         if (.not. rates_are_plain(self, at)) call check_own_force(self, at, error)
      end if
   end subroutine check_masses

   !> The forces of changes of M are known where xdot = v; else a system has to have its own.
   subroutine check_own_force(self, at, error)
      class(automatic_system_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(error_t), allocatable, intent(inout) :: error
      real(wp) :: f(self%n)

      call self%force(at, f)
      if (any(is_not_supplied(f))) &
         call raise(error, here, 'its masses depend on coordinates whose rates are not the velocities', &
                    'supply force, with the terms that the velocities'' definition adds')
   end subroutine check_own_force

end submodule taut_constrained_system_automatic_structure
