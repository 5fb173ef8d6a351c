!> What follows from energies of an `automatic_system_t`: M, forces, the energy itself.
submodule(taut_constrained_system_automatic) taut_constrained_system_automatic_lagrange
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use taut_constrained_system, only: is_not_supplied
   implicit none (type, external)

contains

   !> M as `diagonal_mass` or `masses` gives it.
   module procedure mass_of_masses
      type(jet_t), target :: few(most_on_stack)
      type(jet_t), allocatable, target :: many(:)

      if (allocated(self%diagonal_mass)) then
         call m%set_diagonal(self%diagonal_mass)
      else if (self%n_x + self%n**2 <= most_on_stack) then
         call mass_in(self%n_x, self%n, few, few(self%n_x + 1:))
      else
         allocate (many(self%n_x + self%n**2))
         call mass_in(self%n_x, self%n, many, many(self%n_x + 1:))
      end if

   contains

      !> The same in the room that is given.
      subroutine mass_in(n_x, n, x, k)
         integer, intent(in) :: n_x, n
         type(jet_t), intent(inout), target :: x(n_x)
         type(jet_t), intent(inout) :: k(n, n)
         type(jet_state_t) :: there
         integer :: b, i

         there%t = jet(at%t)
         there%x => x
         do i = 1, n_x
            x(i) = jet(at%x(i))
         end do
         k = jet(0.0_wp)
         call self%masses(there, k)
         do b = 1, size(self%mass_blocks)
            associate (one => m%first(b), last => m%first(b + 1) - 1)
               call m%set_block(b, k(one:last, one:last)%v)
            end associate
         end do
      end subroutine mass_in

   end procedure mass_of_masses

   !> The forces that follow from the potential, -H^T dV/dx, and, where xdot = v, those of the changes of `masses`,
   !! d(v^T M v/2)/dx - Mdot v; zero from what is not supplied. To be called from a `force` of one's own that adds to them.
   module procedure lagrange_force
      type(jet_t), target :: few(most_on_stack)
      type(jet_t), allocatable, target :: many(:)

      if (2*self%n_x + self%n + self%n**2 <= most_on_stack) then
         call force_in(self%n_x, self%n, few, few(self%n_x + 1:), few(2*self%n_x + 1:), few(2*self%n_x + self%n + 1:))
      else
         allocate (many(2*self%n_x + self%n + self%n**2))
         call force_in(self%n_x, self%n, many, many(self%n_x + 1:), many(2*self%n_x + 1:), many(2*self%n_x + self%n + 1:))
      end if

   contains

      !> The same in the room that is given.
      subroutine force_in(n_x, n, x, rate, v, k)
         integer, intent(in) :: n_x, n
         type(jet_t), intent(inout), target :: x(n_x), v(n)
         type(jet_t), intent(inout) :: rate(n_x), k(n, n)
         type(jet_state_t) :: there
         type(jet_t) :: energy
         real(wp) :: changes, slope(directions)
         logical :: plain
         integer :: base, d, i, j

         there%x => x
         there%v => v
         value(:) = 0.0_wp
         changes = 0.0_wp
         plain = n == n_x
         ! The first direction is the motion's, direction j + 1 that of velocity j.
         do base = 0, n, directions
            do i = 1, n
               v(i) = jet(0.0_wp)
               call point(i + 1 - base, v(i))
               if (base == 0) v(i)%d(1) = at%v(i)
            end do
            call self%carry(at, there, rate)
            if (plain) plain = all(same_slopes(x, v))
            there%t = jet(at%t)
            if (base == 0) there%t%d(1) = 1.0_wp
            call self%potential(there, energy)
            if (.not. is_not_supplied(energy%v)) then
               do d = 1, directions
                  i = base + d - 1
                  if (i >= 1 .and. i <= n) value(i) = value(i) - energy%d(d)
               end do
            end if
            k = jet(0.0_wp)
            call self%masses(there, k)
            if (is_not_supplied(k(1, 1)%v)) cycle
            slope = 0.0_wp
            do j = 1, n
               do i = 1, n
                  if (base == 0) value(i) = value(i) - k(i, j)%d(1)*at%v(j)
                  changes = max(changes, maxval(abs(k(i, j)%d)))
                  slope = slope + 0.5_wp*at%v(i)*at%v(j)*k(i, j)%d
               end do
            end do
            do d = 1, directions
               i = base + d - 1
               if (i >= 1 .and. i <= n) value(i) = value(i) + slope(d)
            end do
         end do
         if (changes > 0.0_wp .and. .not. plain) value(:) = not_supplied()
      end subroutine force_in

   end procedure lagrange_force

   !> Whether two jets have the same derivatives.
   elemental logical function same_slopes(a, b)
      type(jet_t), intent(in) :: a, b

      same_slopes = .not. any(abs(a%d - b%d) > 0.0_wp)
   end function same_slopes

   !> Kinetic and potential energy; not known without a `potential`.
   module procedure energy
      type(block_diagonal_t) :: m
      type(jet_t) :: potential
      type(jet_t), target :: x(self%n_x)
      type(jet_state_t) :: there
      real(wp), allocatable :: momentum(:)

      x = jet(at%x)
      there%t = jet(at%t)
      there%x => x
      call self%potential(there, potential)
      energy = ieee_value(energy, ieee_quiet_nan)
      if (is_not_supplied(potential%v)) return
      call m%init(self%mass_blocks)
      call self%mass(at, m)
      allocate (momentum(self%n))
      call m%multiply(at%v, momentum)
      energy = 0.5_wp*dot_product(at%v, momentum) + potential%v
   end procedure energy

end submodule taut_constrained_system_automatic_lagrange
