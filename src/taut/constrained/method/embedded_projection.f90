!> The impulse of the reactions as an unknown, which the constraints on velocities determine where the derivative is evaluated.
!!
!! With p = A^T mu, mu the integral of lambda, M vdot + A^T lambda = f is the derivative of v = v* - M^-1 p, where
!!
!!     M v*dot = f + (A^T)' mu - M' M^-1 A^T mu,   A v = b',   phi(x) = 0,
!!
!! an ordinary differential equation in {x; v*} and an algebraic one in mu, of index 1: no multiplier is a force, and no b'' is
!! asked for. The derivatives along the motion of A and M at fixed mu are differences, backwards so that they stay on this side
!! of what has been passed, a small part of the time since mu was zero. mu grows with time, and its part in v* with it: it is zero
!! where a step begins, v* = v, which changes the variables and not the motion. The order is that of the pair. Positions are
!! projected in the metric W, for what lets phi drift where A v = b' is met is an error alone.
!!
!! The state is {x; v; w; M^-1 p; time since it was zero}, so that v is what it is everywhere. Positions and velocities are
!! kept. Accelerations meet nothing: lambda is what the reactions were on the average since the step began, exact to first order
!! of its length, and to second at its middle.
!!
!! Source: derived from what the paper says of the embedded projection of Borri, Trainelli and Croce, reference [29]: a
!! reduction to index 1, structural, in momenta (Sect. 3.1), of subproblems that are differential and algebraic in turn
!! (Sect. 1). Whether theirs has the same equations is not known here.
module taut_constrained_method_embedded_projection
   use taut_kinds, only: wp
   use taut_archive, only: archive_t
   use taut_error, only: error_t
   use taut_constrained_method_fuhrer_leimkuhler, only: fuhrer_leimkuhler_t
   use taut_constrained_jacobian, only: evaluate_jacobian, lay_out_jacobian
   use taut_constrained_system, only: state_t
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_csr, only: csr_t
   use taut_ode_system, only: inside_step, rhs_ok
   implicit none (type, external)
   private
   public :: embedded_projection_t

   !> Differences reach so far back, of the time since mu was zero: what is cut off is 1e-8 of what the step's length makes of it,
   !! and round-off 1e-12 of lambda.
   real(wp), parameter :: reach = 1.0e-4_wp

   !> The method `embedded-projection`.
   type, extends(fuhrer_leimkuhler_t) :: embedded_projection_t
      private
      !> A state a little earlier, with A and M there.
      type(state_t) :: earlier
      type(csr_t) :: a_earlier
      type(block_diagonal_t) :: m_earlier
      !> Velocities of the impulse, M^-1 A^T mu; A^T mu and its derivative; a displacement: (n).
      real(wp), allocatable :: held(:), impulse(:), derivative(:), d(:)
   contains
      procedure :: set_up
      procedure :: size => state_size
      procedure :: pack
      procedure :: rhs
      procedure :: project
      procedure :: accepted
      procedure :: accelerations
      procedure :: serialize_own
   end type embedded_projection_t

contains

   !> Makes room.
   subroutine set_up(self, error)
      !> The formulation.
      class(embedded_projection_t), intent(inout) :: self
      !> Left alone.
      type(error_t), allocatable, intent(inout) :: error

      call self%fuhrer_leimkuhler_t%set_up(error)
      ! What a projection takes off the velocities is the impulse of a step, no error.
      self%velocities = 0
      associate (model => self%model)
         allocate (self%earlier%x(model%n_x), self%earlier%v(model%n), self%earlier%w(model%n_w), self%held(model%n), &
                   self%impulse(model%n), self%derivative(model%n), self%d(model%n), source=0.0_wp)
         call lay_out_jacobian(model, self%a_earlier)
         call self%m_earlier%init(model%mass_blocks)
      end associate
   end subroutine set_up

   !> Number of entries of y.
   pure function state_size(self) result(n)
      !> The formulation.
      class(embedded_projection_t), intent(in) :: self
      !> n_x + 2 n + n_w + 1.
      integer :: n

      n = last(self) + self%model%n + 1
   end function state_size

   !> y = {x; v; w; 0; 0}.
   pure subroutine pack(self, at, y)
      !> The formulation.
      class(embedded_projection_t), intent(in) :: self
      !> The state.
      type(state_t), intent(in) :: at
      !> All of it: (size).
      real(wp), intent(out), contiguous :: y(:)

      y(:) = 0.0_wp
      call self%fuhrer_leimkuhler_t%pack(at, y(:last(self)))
   end subroutine pack

   !> The last entry of w in y.
   pure integer function last(self)
      class(embedded_projection_t), intent(in) :: self

      last = self%model%n_x + self%model%n + self%model%n_w
   end function last

   !> The derivative of x and v*, with mu from A v = b'.
   subroutine rhs(self, t, y, dydt, info)
      !> The formulation.
      class(embedded_projection_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State {x; v; w; M^-1 p; time since it was zero}, of which the sum v* of the second and the fourth counts: (size).
      real(wp), intent(in), contiguous :: y(:)
      !> Its derivative, that of v* in the place of v: (size).
      real(wp), intent(out), contiguous :: dydt(:)
      !> One of the `rhs_` constants.
      integer, intent(out) :: info
      integer :: last_v, n_x
      real(wp) :: since

      n_x = self%model%n_x
      last_v = n_x + self%model%n
      since = y(self%size())
      associate (model => self%model, at => self%at, vdot => dydt(n_x + 1:last_v))
         call meet_sum(self, t, y, info)
         if (info /= rhs_ok) return
         call model%force(at, self%force)
         if (abs(since) > 0.0_wp) then
            self%lambda(:) = self%eta/since
            call turn_impulse(self, reach*since)
            self%derivative(:) = self%force + self%derivative
            call self%mass%accelerate(self%projector, self%derivative, vdot)
         else
            call self%mass%accelerate(self%projector, self%force, vdot)
         end if
         if (self%has_integral) call self%find_power(self%projector%b_prime)
         call model%x_rate(at, at%v, dydt(:n_x))
         if (model%n_w > 0) call model%w_rate(at, dydt(last_v + 1:last(self)))
      end associate
      dydt(last(self) + 1:) = 0.0_wp
      dydt(self%size()) = 1.0_wp
   end subroutine rhs

   !> The state, its velocities v* less the impulse that they need to meet A v = b'.
   subroutine meet_sum(self, t, y, info)
      class(embedded_projection_t), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      integer, intent(out) :: info
      integer :: n

      n = self%model%n
      call self%unpack(t, y, self%at)
      self%at%v(:) = self%at%v + y(last(self) + 1:last(self) + n)
      self%held(:) = self%at%v
      call self%meet_state(info)
      self%held(:) = self%held - self%at%v
   end subroutine meet_sum

   !> What the impulse A^T mu takes to turn with the constraints, (A^T)' mu - M' M^-1 A^T mu: a parabola through the state and two
   !! that are a little earlier.
   subroutine turn_impulse(self, dt)
      class(embedded_projection_t), intent(inout) :: self
      real(wp), intent(in) :: dt

      self%impulse(:) = 0.0_wp
      call self%projector%linear%a%subtract_transposed(self%eta, self%impulse)
      self%derivative(:) = 0.0_wp
      call add_earlier(self, dt, -2.0_wp/dt)
      call add_earlier(self, 2.0_wp*dt, 0.5_wp/dt)
   end subroutine turn_impulse

   !> Adds A^T mu - M M^-1 p of an earlier state, the second M being that of now.
   subroutine add_earlier(self, before, weight)
      class(embedded_projection_t), intent(inout) :: self
      real(wp), intent(in) :: before, weight

      associate (model => self%model, earlier => self%earlier)
         earlier%t = self%at%t - before
         earlier%x(:) = self%at%x
         earlier%v(:) = self%at%v
         self%d(:) = -before*self%at%v
         call model%displace(self%d, earlier%x)
         call evaluate_jacobian(model, earlier, self%a_earlier)
         if (model%constant_mass) then
            self%d(:) = -self%impulse
         else
            call model%mass(earlier, self%m_earlier)
            call self%m_earlier%multiply(self%held, self%d)
         end if
         call self%a_earlier%subtract_transposed(self%eta, self%d)
         self%derivative(:) = self%derivative - weight*self%d
      end associate
   end subroutine add_earlier

   !> Replaces x and v by those that meet their constraints, and the impulse by what that takes: v* stays, and with it the
   !! derivative.
   subroutine project(self, t, y, place, stale, info)
      !> The formulation.
      class(embedded_projection_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State, replaced: (size).
      real(wp), intent(inout), contiguous :: y(:)
      !> `inside_step`, `step_end` or `evaluated_step_end`.
      integer, intent(in) :: place
      !> False: the derivative stays.
      logical, intent(out) :: stale
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      stale = .false.
      call meet_sum(self, t, y, info)
      if (info == rhs_ok .and. place /= inside_step) call self%projector%check_branch(self%model, self%at, info)
      if (info /= rhs_ok) return
      call self%fuhrer_leimkuhler_t%pack(self%at, y(:last(self)))
      y(last(self) + 1:last(self) + self%model%n) = self%held
      if (place == inside_step) return
      call self%remember()
      self%step_end%phidot = 0.0_wp
      self%step_end%mu(:) = self%eta
   end subroutine project

   !> The next step begins without an impulse.
   subroutine accepted(self, t, y, replaced)
      !> The formulation.
      class(embedded_projection_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State: (size).
      real(wp), intent(inout), contiguous :: y(:)
      !> True.
      logical, intent(out) :: replaced

      call self%fuhrer_leimkuhler_t%accepted(t, y, replaced)
      y(last(self) + 1:) = 0.0_wp
      replaced = .true.
   end subroutine accepted

   !> vdot with the reactions as they are on the average: the derivative of v* knows nothing of them.
   subroutine accelerations(self, dydt, vdot)
      !> The formulation.
      class(embedded_projection_t), intent(inout) :: self
      !> The derivative: not asked.
      real(wp), intent(in), contiguous :: dydt(:)
      !> Accelerations: (n).
      real(wp), intent(out), contiguous :: vdot(:)

      self%derivative(:) = self%force
      call self%projector%linear%a%subtract_transposed(self%lambda, self%derivative)
      call self%mass%accelerate(self%projector, self%derivative, vdot)
      associate (unused => dydt)
      end associate
   end subroutine accelerations

   !> The multipliers that a step begins with.
   subroutine serialize_own(self, archive)
      !> The formulation.
      class(embedded_projection_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      call archive%item('multipliers', self%lambda)
   end subroutine serialize_own

end module taut_constrained_method_embedded_projection
