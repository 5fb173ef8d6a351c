!> The tangents of a constrained system's forces, by differences, and which velocities are free.
!!
!! Displacements that no force sees together are tried together, so that of a system that tells its coupling, such as a beam or a
!! mechanism, as many evaluations of the forces are enough for any size.
module taut_constrained_tangent
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_constrained_coupling, only: coupling_t
   use taut_constrained_jacobian, only: evaluate_jacobian, lay_out_jacobian
   use taut_constrained_system, only: check_supplied, mechanical_system_t, state_t
   use taut_constrained_system_stiff, only: stiff_system_t
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_csr, only: csr_t
   implicit none (type, external)
   private
   public :: tangent_t, free_velocities, ready, default_difference

   !> K in the pattern of what is coupled, and samples of its error.
   type :: tangent_t
      !> The pattern.
      type(coupling_t) :: coupling
      !> K, and samples of the errors of its entries: (entries, samples).
      type(csr_t) :: k
      real(wp), allocatable :: errors(:, :)
      !> What of K is not that of elastic rows, which is not negative: (entries).
      real(wp), allocatable :: soft(:)
      !> A, B, G, k and sigma.
      type(csr_t), private :: a, b, g
      type(block_diagonal_t), private :: stiffness
      real(wp), allocatable, private :: sigma(:)
      !> Whether sigma was carried from the state before.
      logical, private :: carried = .false.
   contains
      procedure :: init
      procedure :: carry
      procedure :: forget
      procedure :: find
      procedure :: find_errors
      procedure :: full
      procedure :: asymmetry
      procedure :: damping
   end type tangent_t

   !> Step of the differences, relative to the size of the coordinates (at least 1). The formula is of fourth order, so that
   !! the stretching of a slender beam that is bent by the step does not count against its bending.
   real(wp), parameter :: default_difference = 3.0e-6_wp
   !> Differences of this part of a row are noise.
   real(wp), parameter :: same = 1.0e-8_wp
   !> Other steps, as multiples of this one, that tell what the tangent is worth.
   real(wp), parameter :: other_steps(2) = [0.71_wp, 1.37_wp]
   !> Step of the differences for velocities [m/s, rad/s].
   real(wp), parameter :: velocity_difference = 1.0e-5_wp

contains

   !> Lays out K.
   subroutine init(self, model)
      !> The tangent.
      class(tangent_t), intent(out) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      integer, allocatable :: first(:), column(:)

      call self%coupling%init(model)
      call self%k%set_pattern(model%n, self%coupling%first, self%coupling%column)
      call lay_out_jacobian(model, self%a)
      allocate (self%errors(size(self%k%values), size(other_steps)), source=0.0_wp)
      allocate (self%sigma(0))
      select type (model)
      class is (stiff_system_t)
         if (model%n_elastic == 0) return
         call model%elastic_pattern(first, column)
         call self%b%set_pattern(model%n, first, column)
         self%g = self%b
         call model%elastic_stiffness(self%stiffness)
         deallocate (self%sigma)
         allocate (self%sigma(model%n_elastic), source=0.0_wp)
      end select
   end subroutine init

   !> K = -d(f - A^T lambda)/dx at v = 0: by central differences of fourth order of what is soft, and B^T k G of elastic rows with
   !! G, the derivative of their strains, by the same. So the large forces of a stretched beam leave no noise in its bending.
   subroutine find(self, model, at, lambda, step)
      !> The tangent, laid out.
      class(tangent_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Where, at rest.
      type(state_t), intent(in) :: at
      !> Multipliers: (c).
      real(wp), intent(in) :: lambda(:)
      !> Relative step; 0 for the default.
      real(wp), intent(in) :: step

      call differentiate(self, model, at, lambda, step_of(step), self%k%values)
      self%soft = self%k%values
      if (size(self%sigma) > 0) call self%coupling%add_elastic(self%b, self%stiffness, self%g, self%k%values)
   end subroutine find

   !> What other steps of the differences make of K, less K: samples of its error.
   subroutine find_errors(self, model, at, lambda, step)
      !> The tangent, found.
      class(tangent_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Where, at rest.
      type(state_t), intent(in) :: at
      !> Multipliers: (c).
      real(wp), intent(in) :: lambda(:)
      !> Relative step of K; 0 for the default.
      real(wp), intent(in) :: step
      integer :: i

      do i = 1, size(other_steps)
         call differentiate(self, model, at, lambda, other_steps(i)*step_of(step), self%errors(:, i), i)
         if (size(self%sigma) > 0) call self%coupling%add_elastic(self%b, self%stiffness, self%g, self%errors(:, i))
         self%errors(:, i) = self%errors(:, i) - self%k%values
      end do
   end subroutine find_errors

   !> Internal forces for the tangent at the next state: those that a displacement is to lead to. What a stiff part has of them
   !! besides, until the next step takes it away, is large, and would make the tangent another one.
   subroutine carry(self, model, at, d)
      !> The tangent, found.
      class(tangent_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Where it was found.
      type(state_t), intent(in) :: at
      !> The displacement: (n).
      real(wp), intent(in) :: d(:)
      real(wp) :: more(size(self%sigma)), strain(size(self%sigma))

      if (size(self%sigma) == 0) return
      select type (model)
      class is (stiff_system_t)
         call model%elastic_rows(at, strain, self%b%values)
      end select
      call self%g%multiply(d, more)
      call self%stiffness%multiply(strain + more, self%sigma)
      self%carried = .true.
   end subroutine carry

   !> Internal forces are those of the strains, from now on.
   pure subroutine forget(self)
      !> The tangent.
      class(tangent_t), intent(inout) :: self

      self%carried = .false.
   end subroutine forget

   !> The relative step.
   pure real(wp) function step_of(step)
      real(wp), intent(in) :: step

      step_of = merge(step, default_difference, step > 0.0_wp)
   end function step_of

   !> The entries of K by differences of one relative step, without those of elastic rows, for which it leaves B and G.
   !! Of a sample of the error, the internal forces are as far off as round-off of the coordinates leaves them.
   subroutine differentiate(self, model, at, lambda, step, values, sample)
      class(tangent_t), intent(inout) :: self
      class(mechanical_system_t), intent(in) :: model
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: lambda(:), step
      real(wp), intent(out) :: values(:)
      integer, intent(in), optional :: sample
      type(state_t) :: near
      logical :: moved(model%n)
      real(wp) :: h, sigma(size(self%sigma)), strains(size(self%sigma), 4), total(model%n, 4)
      real(wp), parameter :: reach(4) = [1.0_wp, -1.0_wp, 2.0_wp, -2.0_wp]
      integer :: color, i, l

      h = step*max(1.0_wp, maxval(abs(at%x)))
      near = at
      if (.not. self%carried) then
         call strains_at(near, strains(:, 1))
         call self%stiffness%multiply(strains(:, 1), self%sigma)
      end if
      sigma = self%sigma
      if (present(sample) .and. size(sigma) > 0) then
         strains(:, 1) = [(sign(epsilon(h)*maxval(abs(at%x)), sin(real(37*i*i + sample*i, wp))), i=1, size(sigma))]
         call self%stiffness%multiply(strains(:, 1), strains(:, 2))
         sigma = sigma + strains(:, 2)
      end if
      values = 0.0_wp
      do color = 1, self%coupling%colors
         moved = self%coupling%color == color
         do i = 1, 4
            call force_near(reach(i)*h, total(:, i), strains(:, i))
         end do
         total(:, 1) = -(8.0_wp*(total(:, 1) - total(:, 2)) - (total(:, 3) - total(:, 4)))/(12.0_wp*h)
         call scatter(self%coupling, moved, total(:, 1), values)
         if (size(self%sigma) == 0) cycle
         strains(:, 1) = (8.0_wp*(strains(:, 1) - strains(:, 2)) - (strains(:, 3) - strains(:, 4)))/(12.0_wp*h)
         do i = 1, size(self%sigma)
            do l = self%g%first(i), self%g%first(i + 1) - 1
               if (moved(self%g%column(l))) self%g%values(l) = strains(i, 1)
            end do
         end do
      end do
      if (size(self%sigma) == 0) return
      call strains_at(at, strains(:, 1))
      ! Where the two are the same, B has no noise.
      do i = 1, size(self%sigma)
         associate (b => self%b%values(self%b%first(i):self%b%first(i + 1) - 1), &
                    g => self%g%values(self%b%first(i):self%b%first(i + 1) - 1))
            where (abs(g - b) <= same*maxval(abs(b))) g = b
         end associate
      end do

   contains

      !> The strains, and B.
      subroutine strains_at(there, strain)
         type(state_t), intent(in) :: there
         real(wp), intent(out) :: strain(:)

         if (size(self%sigma) == 0) return
         select type (model)
         class is (stiff_system_t)
            call model%elastic_rows(there, strain, self%b%values)
         end select
      end subroutine strains_at

      !> f_s - B^T sigma - A^T lambda with the displacements of a color, and the strains there.
      subroutine force_near(distance, force, strain)
         real(wp), intent(in) :: distance
         real(wp), intent(out) :: force(:), strain(:)

         near%x = at%x
         call model%displace(merge(distance, 0.0_wp, moved), near%x)
         call model%normalize(near%x)
         if (size(self%sigma) > 0) then
            select type (model)
            class is (stiff_system_t)
               call model%soft_force(near, force)
            end select
            call strains_at(near, strain)
            call self%b%subtract_transposed(sigma, force)
         else
            call model%force(near, force)
         end if
         if (model%c == 0) return
         call evaluate_jacobian(model, near, self%a)
         call self%a%subtract_transposed(lambda, force)
      end subroutine force_near

   end subroutine differentiate

   !> Entries of the columns that were tried together, where they belong.
   pure subroutine scatter(coupling, moved, column, values)
      type(coupling_t), intent(in) :: coupling
      logical, intent(in) :: moved(:)
      real(wp), intent(in) :: column(:)
      real(wp), intent(inout) :: values(:)
      integer :: i, l

      do i = 1, size(moved)
         do l = coupling%first(i), coupling%first(i + 1) - 1
            if (moved(coupling%column(l))) values(l) = column(i)
         end do
      end do
   end subroutine scatter

   !> Entries of K's pattern as a full matrix along the velocities that are free.
   pure function full(self, values, free) result(k)
      !> The tangent.
      class(tangent_t), intent(in) :: self
      !> The entries.
      real(wp), intent(in) :: values(:)
      !> Indices of the free velocities.
      integer, intent(in) :: free(:)
      !> (free, free).
      real(wp) :: k(size(free), size(free))
      integer :: i, l, place(self%k%n)

      place = 0
      place(free) = [(i, i=1, size(free))]
      k = 0.0_wp
      do i = 1, size(free)
         do l = self%coupling%first(free(i)), self%coupling%first(free(i) + 1) - 1
            if (place(self%coupling%column(l)) > 0) k(i, place(self%coupling%column(l))) = values(l)
         end do
      end do
   end function full

   !> The largest |K_ij - K_ji|/sqrt(|K_ii K_jj|) along the velocities that are free.
   pure function asymmetry(self, is_free) result(value)
      !> The tangent, found.
      class(tangent_t), intent(in) :: self
      !> Which velocities are free: (n).
      logical, intent(in) :: is_free(:)
      !> It.
      real(wp) :: value
      real(wp) :: largest, scale(self%k%n)
      integer :: i, j, l

      associate (k => self%k)
         largest = maxval(abs(k%values))
         do i = 1, k%n
            scale(i) = sqrt(max(abs(k%values(self%coupling%place(i, i))), 1.0e-10_wp*largest, tiny(1.0_wp)))
         end do
         value = 0.0_wp
         do i = 1, k%n
            do l = k%first(i), k%first(i + 1) - 1
               j = k%column(l)
               if (j >= i .or. .not. (is_free(i) .and. is_free(j))) cycle
               value = max(value, abs(k%values(l) - k%values(self%coupling%place(j, i)))/(scale(i)*scale(j)))
            end do
         end do
      end associate
   end function asymmetry

   !> C = -df/dv by central differences, in the pattern of K; what is nothing but round-off is zero.
   subroutine damping(self, model, at, c)
      !> The tangent, laid out.
      class(tangent_t), intent(in) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Where; its velocities are used.
      type(state_t), intent(in) :: at
      !> The damping: (entries of the pattern).
      real(wp), intent(out) :: c(:)
      type(state_t) :: near
      logical :: moved(model%n)
      real(wp) :: bound, h, total(model%n, 2)
      integer :: color, i

      h = velocity_difference*max(1.0_wp, maxval(abs(at%v)))
      near = at
      c = 0.0_wp
      do color = 1, self%coupling%colors
         moved = self%coupling%color == color
         do i = 1, 2
            near%v = at%v + merge(merge(h, -h, i == 1), 0.0_wp, moved)
            call model%force(near, total(:, i))
         end do
         bound = 10.0_wp*epsilon(h)*maxval(abs(total))/h
         total(:, 1) = -(total(:, 1) - total(:, 2))/(2.0_wp*h)
         where (abs(total(:, 1)) <= bound) total(:, 1) = 0.0_wp
         call scatter(self%coupling, moved, total(:, 1), c)
      end do
   end subroutine damping

   !> The velocities that are not blocked.
   subroutine free_velocities(n, blocked, free, error)
      !> Number of velocities.
      integer, intent(in) :: n
      !> Indices of the blocked ones; not allocated for none.
      integer, allocatable, intent(in) :: blocked(:)
      !> Indices of the others, in order.
      integer, allocatable, intent(out) :: free(:)
      !> An index that does not exist, or nothing left.
      type(error_t), allocatable, intent(inout) :: error
      logical :: is_free(n)
      integer :: i

      is_free = .true.
      if (allocated(blocked)) then
         do i = 1, size(blocked)
            if (blocked(i) < 1 .or. blocked(i) > n) then
               call raise(error, 'blocked velocities', 'there is no velocity '//to_text(blocked(i)), &
                          'give indices from 1 to '//to_text(n))
               return
            end if
            is_free(blocked(i)) = .false.
         end do
      end if
      free = pack([(i, i=1, n)], is_free)
      if (size(free) == 0) call raise(error, 'blocked velocities', 'all velocities are blocked', 'leave some free')
   end subroutine free_velocities

   !> Whether system and state fit; completes the state.
   subroutine ready(model, at, where, error)
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Its state; velocities are set to zero, other states if they are missing.
      type(state_t), intent(inout) :: at
      !> Who asks.
      character(*), intent(in) :: where
      !> What does not fit.
      type(error_t), allocatable, intent(inout) :: error

      call model%check_sizes(error)
      if (allocated(error)) return
      if (.not. allocated(at%x)) then
         call raise(error, where, 'the coordinates are not set', 'set x')
      else if (size(at%x) /= model%n_x) then
         call raise(error, where, 'there are '//to_text(size(at%x))//' coordinates for '//to_text(model%n_x), &
                    'give as many as the system has')
      end if
      if (allocated(error)) return
      if (allocated(at%v)) deallocate (at%v)
      allocate (at%v(model%n), source=0.0_wp)
      if (.not. allocated(at%w)) allocate (at%w(model%n_w), source=0.0_wp)
      call check_supplied(model, at, error)
   end subroutine ready

end module taut_constrained_tangent
