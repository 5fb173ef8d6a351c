!> No multipliers: M vdot = f - A^T lambda with stiffness and damping on the violation, lambda = k phi + d (A v - b').
module taut_constrained_method_penalty
   use taut_kinds, only: wp
   use taut_constrained_method, only: constrained_ode_t
   use taut_constrained_method_options, only: method_t
   use taut_error, only: error_t, raise, to_text
   use taut_ode_system, only: inside_step, rhs_ok
   implicit none (type, external)
   private
   public :: penalty_t

   !> The method `penalty`.
   type, extends(constrained_ode_t) :: penalty_t
   contains
      procedure :: check_options
      procedure :: rhs
      procedure :: cross => no_blow
   end type penalty_t

contains

   !> Whether the constraints are held.
   subroutine check_options(self, options, error)
      !> The formulation, not yet set up.
      class(penalty_t), intent(in) :: self
      !> The options.
      type(method_t), intent(in) :: options
      !> No stiffness, or a negative damping.
      type(error_t), allocatable, intent(inout) :: error

      if (.not. (options%stiffness > 0.0_wp .and. options%damping >= 0.0_wp)) &
         call raise(error, options%place(), 'stiffness = '//to_text(options%stiffness)//', damping = '// &
                    to_text(options%damping)//': the constraints are not held', &
                    'give a positive stiffness and a damping of 0 or more')
      associate (unused_formulation => self)
      end associate
   end subroutine check_options

   !> The derivative with the forces of springs and dampers in the place of the constraints.
   subroutine rhs(self, t, y, dydt, info)
      !> The formulation.
      class(penalty_t), intent(inout) :: self
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
      associate (model => self%model, at => self%at, projector => self%projector, lambda => self%lambda)
         call self%unpack(t, y, at)
         call model%normalize(at%x)
         call projector%linear%evaluate(model, at)
         call self%find_violations()
         lambda(:) = self%options%damping*self%phidot
         lambda(:model%n_phi) = lambda(:model%n_phi) + self%options%stiffness*self%phi
         call model%force(at, self%force)
         if (model%reactive) then
            call model%reaction_force(at, lambda, dydt(n_x + 1:last_v))
            self%force(:) = self%force + dydt(n_x + 1:last_v)
         end if
         call projector%linear%a%subtract_transposed(lambda, self%force)
         call self%mass%renew(model, at, info)
         if (info /= rhs_ok) return
         call self%mass%accelerate(projector, self%force, dydt(n_x + 1:last_v))
         call model%x_rate(at, at%v, dydt(:n_x))
         if (model%n_w > 0) call model%w_rate(at, dydt(last_v + 1:))
         ! The energy does not contain that of the springs: all that they do is work, A v = phidot + b'.
         if (self%has_integral) call self%find_power(self%phidot + projector%b_prime)
      end associate
   end subroutine rhs

   !> Springs and dampers take what begins to move at once.
   subroutine no_blow(self, t, before, y, info)
      !> The formulation.
      class(penalty_t), intent(inout) :: self
      !> Time of the breakpoint [s].
      real(wp), intent(in) :: t
      !> The last time before it [s].
      real(wp), intent(in) :: before
      !> State; coordinates are normalized: (size).
      real(wp), intent(inout), contiguous :: y(:)
      !> `rhs_ok`.
      integer, intent(out) :: info
      logical :: stale

      call self%project(t, y, inside_step, stale, info)
      associate (unused_time => before)
      end associate
   end subroutine no_blow

end module taut_constrained_method_penalty
