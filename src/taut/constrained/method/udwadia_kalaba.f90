!> The elimination of the multipliers as Udwadia and Kalaba wrote it, vdot = a + M^-1/2 (A M^-1/2)^+ (b'' - A a).
!!
!! The accelerations are those of Eq. (8), by another way: the symmetric root of M, and a pseudo-inverse by singular values that
!! takes redundant rows as they come. What is integrated drifts as with `baseline`. The form has no multipliers; those of least norm
!! that give its accelerations are lambda = -(B^+)^T B^+ (b'' - A a) with B = A M^-1/2.
!!
!! Source: F.E. Udwadia, R.E. Kalaba, A new perspective on constrained motion, Proc. R. Soc. Lond. A 439 (1992) 407-410, reference
!! [18] of the paper; that both forms are one is shown in [20].
module taut_constrained_method_udwadia_kalaba
   use taut_kinds, only: wp
   use taut_constrained_method, only: constrained_ode_t
   use taut_constrained_yardstick, only: relative_violation
   use taut_error, only: error_t
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_inverse_root, only: inverse_root_t
   use taut_linalg_pseudo_inverse, only: singular_value_inverse_t
   use taut_linalg_rank, only: rcond_of_root, with_noise
   use taut_ode_system, only: rhs_ok, rhs_retry
   implicit none (type, external)
   private
   public :: udwadia_kalaba_t

   !> The method `udwadia-kalaba`.
   type, extends(constrained_ode_t) :: udwadia_kalaba_t
      private
      type(block_diagonal_t) :: matrix
      type(inverse_root_t) :: root
      type(singular_value_inverse_t) :: inverse
      logical :: root_known = .false.
      !> B: (c, n); factors of its rows and columns; b'' - A a, B^+ times that, and a row: (c), (n).
      real(wp), allocatable :: b(:, :), left(:), right(:), r(:), u(:), pick(:)
   contains
      procedure :: set_up
      procedure :: rhs
   end type udwadia_kalaba_t

contains

   !> Makes room.
   subroutine set_up(self, error)
      !> The formulation.
      class(udwadia_kalaba_t), intent(inout) :: self
      !> More rows or columns than full matrices are good for.
      type(error_t), allocatable, intent(inout) :: error

      self%carries_reactions = .false.
      call self%refuse_large(error)
      if (allocated(error)) return
      associate (model => self%model)
         call self%matrix%init(model%mass_blocks)
         call self%root%init(model%mass_blocks)
         call self%inverse%init(model%c, model%n)
         allocate (self%b(model%c, model%n), self%left(model%c), self%right(model%n), self%r(model%c), self%u(model%n), &
                   self%pick(model%c), source=0.0_wp)
      end associate
      self%right(:) = 1.0_wp
   end subroutine set_up

   !> The derivative by a pseudo-inverse.
   subroutine rhs(self, t, y, dydt, info)
      !> The formulation.
      class(udwadia_kalaba_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State {x; v; w}: (size).
      real(wp), intent(in), contiguous :: y(:)
      !> Its derivative: (size).
      real(wp), intent(out), contiguous :: dydt(:)
      !> One of the `rhs_` constants.
      integer, intent(out) :: info
      integer :: i, last_v, n_x
      real(wp) :: noise

      n_x = self%model%n_x
      last_v = n_x + self%model%n
      associate (model => self%model, at => self%at, projector => self%projector, inverse => self%inverse%inverse, &
                 xdot => dydt(:n_x), vdot => dydt(n_x + 1:last_v), wdot => dydt(last_v + 1:))
         call self%unpack(t, y, at)
         call model%normalize(at%x)
         call projector%linear%evaluate(model, at)
         call model%acceleration_rhs(at, self%b_second)
         call self%mass%renew(model, at, info)
         if (info == rhs_ok) call renew_root(self, info)
         if (info /= rhs_ok) return
         call model%force(at, self%force)
         call self%mass%accelerate(projector, self%force, vdot)
         if (model%c > 0) then
            do i = 1, model%c
               self%pick(:) = 0.0_wp
               self%pick(i) = -1.0_wp
               self%u(:) = 0.0_wp
               call projector%linear%a%subtract_transposed(self%pick, self%u)
               call self%root%apply(self%u)
               self%b(i, :) = self%u
               self%left(i) = 1.0_wp/max(norm2(self%u), tiny(1.0_wp))
            end do
            if (.not. all(abs(self%b) <= huge(1.0_wp))) then
               info = rhs_retry
               return
            end if
            noise = 0.0_wp
            if (model%n_phi > 1) then
               call model%constraint(at, self%phi)
               noise = relative_violation(self%phi, projector%linear%a, at%x)
            end if
            noise = with_noise(rcond_of_root, noise)
            call self%inverse%compute(self%b, self%left, self%right, noise, noise, info)
            if (info /= 0) then
               info = rhs_retry
               return
            end if
            call projector%linear%a%multiply(vdot, self%r, self%b_second)
            do i = 1, model%n
               self%u(i) = -dot_product(inverse(i, :), self%r)
            end do
            do i = 1, model%c
               self%lambda(i) = -dot_product(inverse(:, i), self%u)
            end do
            call self%root%apply(self%u)
            vdot(:) = vdot + self%u
         end if
         info = rhs_ok
         if (self%has_integral) then
            call model%velocity_rhs(at, self%phidot)
            call self%find_power(self%phidot)
         end if
         call model%x_rate(at, at%v, xdot)
         if (model%n_w > 0) call model%w_rate(at, wdot)
      end associate
   end subroutine rhs

   !> M^-1/2 at the state.
   subroutine renew_root(self, info)
      type(udwadia_kalaba_t), intent(inout) :: self
      integer, intent(out) :: info

      info = rhs_ok
      if (self%root_known .and. self%model%constant_mass) return
      call self%model%mass(self%at, self%matrix)
      call self%root%compute(self%matrix, info)
      self%root_known = info == 0
      info = merge(rhs_ok, rhs_retry, info == 0)
   end subroutine renew_root

end module taut_constrained_method_udwadia_kalaba
