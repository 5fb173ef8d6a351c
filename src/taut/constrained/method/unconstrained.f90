!> M vdot = f: the constraints are evaluated and have no part in the motion; the system is told so (`enforce`).
module taut_constrained_method_unconstrained
   use taut_kinds, only: wp
   use taut_constrained_method, only: constrained_ode_t
   use taut_error, only: error_t
   use taut_ode_system, only: rhs_ok
   implicit none (type, external)
   private
   public :: unconstrained_t

   !> The method `unconstrained`.
   type, extends(constrained_ode_t) :: unconstrained_t
   contains
      procedure :: set_up
      procedure :: rhs
   end type unconstrained_t

contains

   !> Tells the system.
   subroutine set_up(self, error)
      !> The formulation.
      class(unconstrained_t), intent(inout) :: self
      !> Left alone.
      type(error_t), allocatable, intent(inout) :: error

      call self%model%enforce(.false.)
      associate (unused_error => error)
      end associate
   end subroutine set_up

   !> The derivative without the constraints.
   subroutine rhs(self, t, y, dydt, info)
      !> The formulation.
      class(unconstrained_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State {x; v; w}: (size).
      real(wp), intent(in), contiguous :: y(:)
      !> Its derivative: (size).
      real(wp), intent(out), contiguous :: dydt(:)
      !> One of the `rhs_` constants.
      integer, intent(out) :: info
      integer :: last_v, n_x

      n_x = self%model%n_x
      last_v = n_x + self%model%n
      associate (model => self%model, at => self%at)
         call self%unpack(t, y, at)
         call model%normalize(at%x)
         call self%mass%renew(model, at, info)
         if (info /= rhs_ok) return
         call model%force(at, self%force)
         call self%mass%accelerate(self%projector, self%force, dydt(n_x + 1:last_v))
         call model%x_rate(at, at%v, dydt(:n_x))
         if (model%n_w > 0) call model%w_rate(at, dydt(last_v + 1:))
         if (self%has_integral) self%integrand = model%power(at)
      end associate
   end subroutine rhs

end module taut_constrained_method_unconstrained
