!> Eq. (8): the constraints are enforced at acceleration level, positions and velocities drift; and what the methods that
!! work against the drift have in common with it.
module taut_constrained_method_baseline
   use taut_kinds, only: wp
   use taut_error, only: error_t
   use taut_constrained_method, only: constrained_ode_t
   use taut_constrained_yardstick, only: relative_violation
   use taut_ode_system, only: rhs_ok
   implicit none (type, external)
   private
   public :: baseline_t

   !> The method `baseline`: A vdot = b'', or what an extension's `stabilize` makes of b''.
   type, extends(constrained_ode_t) :: baseline_t
   contains
      procedure :: set_up
      procedure :: rhs
      procedure :: stabilize => nothing_to_stabilize
      procedure :: coordinate_rate
      procedure :: linearize_here
      procedure :: accepted
      procedure :: multipliers
   end type baseline_t

contains

   !> Makes room for the reduced mass matrix.
   subroutine set_up(self, error)
      !> The formulation.
      class(baseline_t), intent(inout) :: self
      !> Left alone.
      type(error_t), allocatable, intent(inout) :: error

      call self%mass%init_reduced(self%model, self%options, self%projector, same_place=.false.)
      associate (unused_error => error)
      end associate
   end subroutine set_up

   !> Eq. (8), as a system of first order.
   subroutine rhs(self, t, y, dydt, info)
      !> The formulation.
      class(baseline_t), intent(inout) :: self
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
      associate (model => self%model, at => self%at, projector => self%projector, mass => self%mass, &
                 xdot => dydt(:n_x), vdot => dydt(n_x + 1:last_v), wdot => dydt(last_v + 1:))
         call self%unpack(t, y, at)
         call self%linearize_here(info)
         if (info /= rhs_ok) return
         call model%acceleration_rhs(at, self%b_second)
         call self%stabilize(self%b_second)
         call model%force(at, self%force)
         if (model%reactive) call self%reactions%add(model, at, mass, projector, self%b_second, self%force, info)
         if (info /= rhs_ok) return
         call mass%accelerate(projector, self%force, vdot)
         if (self%options%form == 'force') then
            call mass%correct_force(projector, self%b_second, self%force, vdot, self%lambda)
         else
            call mass%correct_acceleration(projector, self%b_second, vdot, self%lambda)
         end if
         call self%coordinate_rate(xdot, info)
         if (info == rhs_ok .and. model%n_w > 0) call model%w_rate(at, wdot)
         if (self%has_integral) then
            call model%velocity_rhs(at, self%phidot)
            call self%find_power(self%phidot)
         end if
      end associate
   end subroutine rhs

   !> A, M and M~ at the state as it is.
   subroutine linearize_here(self, info)
      !> The formulation, with the state in place.
      class(baseline_t), intent(inout) :: self
      !> One of the `rhs_` constants.
      integer, intent(out) :: info
      real(wp) :: noise

      associate (model => self%model, at => self%at, projector => self%projector)
         call model%normalize(at%x)
         call projector%linear%evaluate(model, at)
         call self%mass%renew(model, at, info, projector)
         if (info /= rhs_ok) return
         ! The rows of A are those of a state that may violate the constraints.
         noise = 0.0_wp
         if (model%n_phi > 1) then
            call model%constraint(at, self%phi)
            noise = relative_violation(self%phi, projector%linear%a, at%x)
         end if
         if (.not. projector%linear%keeper%holds) call projector%linear%keeper%decide(projector%linear%a, noise)
         call self%mass%reduce(projector, info)
      end associate
   end subroutine linearize_here

   !> What is added to b'' against the drift; the default adds nothing.
   subroutine nothing_to_stabilize(self, b_second)
      !> The formulation, with A and the state in place.
      class(baseline_t), intent(inout) :: self
      !> b'': (c).
      real(wp), intent(inout), contiguous :: b_second(:)

      associate (unused_formulation => self, unused_vector => b_second)
      end associate
   end subroutine nothing_to_stabilize

   !> xdot, the rate of the coordinates: that of the velocities as they are.
   subroutine coordinate_rate(self, xdot, info)
      !> The formulation, with A and the state in place.
      class(baseline_t), intent(inout) :: self
      !> The rate: (n_x).
      real(wp), intent(inout), contiguous :: xdot(:)
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      info = rhs_ok
      call self%model%x_rate(self%at, self%at%v, xdot)
   end subroutine coordinate_rate

   !> Looks at the rank, there and not where something was looked up since.
   subroutine accepted(self, t, y, replaced)
      !> The formulation.
      class(baseline_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State {x; v; w}: (size).
      real(wp), intent(inout), contiguous :: y(:)
      !> False: it stays.
      logical, intent(out) :: replaced
      integer :: info

      replaced = .false.
      if (self%model%c < 2) return
      if (.not. self%is_at(t, y)) then
         call self%unpack(t, y, self%at)
         call self%linearize_here(info)
         if (info /= rhs_ok) return
      end if
      call self%mass%look(self%model, self%at, self%projector)
   end subroutine accepted

   !> lambda of the last evaluation.
   subroutine multipliers(self, lambda)
      !> The formulation, as `rhs` left it.
      class(baseline_t), intent(inout) :: self
      !> Of least norm: (c).
      real(wp), intent(inout), contiguous :: lambda(:)

      lambda(:) = self%lambda
      call self%mass%least_norm(self%projector, lambda)
   end subroutine multipliers

end module taut_constrained_method_baseline
