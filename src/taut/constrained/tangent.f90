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
   use taut_linalg_csr, only: csr_t
   implicit none (type, external)
   private
   public :: tangent, tangent_errors, damping, free_velocities, ready, default_difference

   !> Step of the differences, relative to the size of the coordinates (at least 1). The formula is of fourth order, so that
   !! the stretching of a slender beam that is bent by the step does not count against its bending.
   real(wp), parameter :: default_difference = 3.0e-6_wp
   !> Other steps, as multiples of this one, that tell what the tangent is worth.
   real(wp), parameter :: other_steps(2) = [0.71_wp, 1.37_wp]
   !> Step of the differences for velocities [m/s, rad/s].
   real(wp), parameter :: velocity_difference = 1.0e-5_wp

contains

   !> K = -d(f - A^T lambda)/dx at v = 0, along the velocities that are free: by central differences of fourth order.
   subroutine tangent(model, at, lambda, free, step, k)
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Where, at rest.
      type(state_t), intent(in) :: at
      !> Multipliers: (c).
      real(wp), intent(in) :: lambda(:)
      !> Indices of the free velocities.
      integer, intent(in) :: free(:)
      !> Relative step; 0 for the default.
      real(wp), intent(in) :: step
      !> The tangent: (free, free), one column for each displacement.
      real(wp), intent(out) :: k(:, :)
      type(coupling_t) :: coupling
      type(csr_t) :: a
      type(state_t) :: near
      logical :: moved(model%n)
      real(wp) :: h, total(model%n, 4)
      real(wp), parameter :: reach(4) = [1.0_wp, -1.0_wp, 2.0_wp, -2.0_wp]
      integer :: color, i

      h = default_difference
      if (step > 0.0_wp) h = step
      h = h*max(1.0_wp, maxval(abs(at%x)))
      near = at
      call coupling%init(model)
      call lay_out_jacobian(model, a)
      k = 0.0_wp
      do color = 1, coupling%colors
         moved = .false.
         moved(free) = coupling%color(free) == color
         do i = 1, 4
            call force_near(reach(i)*h, total(:, i))
         end do
         total(:, 1) = -(8.0_wp*(total(:, 1) - total(:, 2)) - (total(:, 3) - total(:, 4)))/(12.0_wp*h)
         call scatter(coupling, free, moved, total(:, 1), k)
      end do

   contains

      !> f - A^T lambda with the displacements of a color.
      subroutine force_near(distance, force)
         real(wp), intent(in) :: distance
         real(wp), intent(out) :: force(:)
         real(wp) :: of_constraints(model%n)

         near%x = at%x
         call model%displace(merge(distance, 0.0_wp, moved), near%x)
         call model%normalize(near%x)
         call model%force(near, force)
         if (model%c == 0) return
         call evaluate_jacobian(model, near, a)
         of_constraints = 0.0_wp
         call a%subtract_transposed(lambda, of_constraints)
         force = force + of_constraints
      end subroutine force_near

   end subroutine tangent

   !> Entries of the columns that were tried together, where they belong.
   pure subroutine scatter(coupling, free, moved, column, k)
      type(coupling_t), intent(in) :: coupling
      integer, intent(in) :: free(:)
      logical, intent(in) :: moved(:)
      real(wp), intent(in) :: column(:)
      real(wp), intent(inout) :: k(:, :)
      integer :: i, l, place(size(moved))

      place = 0
      place(free) = [(i, i=1, size(free))]
      do i = 1, size(free)
         do l = coupling%first(free(i)), coupling%first(free(i) + 1) - 1
            if (moved(coupling%column(l))) k(i, place(coupling%column(l))) = column(free(i))
         end do
      end do
   end subroutine scatter

   !> What other steps of the differences make of K, less K: samples of its error.
   subroutine tangent_errors(model, at, lambda, free, step, k, errors)
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Where, at rest.
      type(state_t), intent(in) :: at
      !> Multipliers: (c).
      real(wp), intent(in) :: lambda(:)
      !> Indices of the free velocities.
      integer, intent(in) :: free(:)
      !> Relative step of K; 0 for the default.
      real(wp), intent(in) :: step
      !> K: (free, free).
      real(wp), intent(in) :: k(:, :)
      !> The samples: (free, free, samples).
      real(wp), allocatable, intent(out) :: errors(:, :, :)
      real(wp) :: h
      integer :: i

      h = default_difference
      if (step > 0.0_wp) h = step
      allocate (errors(size(free), size(free), size(other_steps)), source=0.0_wp)
      do i = 1, size(other_steps)
         call tangent(model, at, lambda, free, other_steps(i)*h, errors(:, :, i))
         errors(:, :, i) = errors(:, :, i) - k
      end do
   end subroutine tangent_errors

   !> C = -df/dv, along the velocities that are free: by central differences; what is nothing but round-off is zero.
   subroutine damping(model, at, free, c)
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Where; its velocities are used.
      type(state_t), intent(in) :: at
      !> Indices of the free velocities.
      integer, intent(in) :: free(:)
      !> The damping: (free, free), one column for each velocity.
      real(wp), intent(out) :: c(:, :)
      type(coupling_t) :: coupling
      type(state_t) :: near
      logical :: moved(model%n)
      real(wp) :: bound, h, total(model%n, 2)
      integer :: color, i

      h = velocity_difference*max(1.0_wp, maxval(abs(at%v)))
      near = at
      call coupling%init(model)
      c = 0.0_wp
      do color = 1, coupling%colors
         moved = .false.
         moved(free) = coupling%color(free) == color
         do i = 1, 2
            near%v = at%v + merge(merge(h, -h, i == 1), 0.0_wp, moved)
            call model%force(near, total(:, i))
         end do
         bound = 10.0_wp*epsilon(h)*maxval(abs(total))/h
         total(:, 1) = -(total(:, 1) - total(:, 2))/(2.0_wp*h)
         where (abs(total(:, 1)) <= bound) total(:, 1) = 0.0_wp
         call scatter(coupling, free, moved, total(:, 1), c)
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
