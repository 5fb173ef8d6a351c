!> The paper's method: the velocities and accelerations of Eqs (11), at positions on the constraints, Eq. (17).
module taut_constrained_method_present
   use taut_kinds, only: wp
   use taut_error, only: error_t
   use taut_constrained_implicit, only: implicit_form_t
   use taut_constrained_method, only: constrained_ode_t
   use taut_ode_system, only: evaluated_step_end, inside_step, rhs_no_projection, rhs_ok, stage_equations_t
   implicit none (type, external)
   private
   public :: present_t

   !> The method `present`.
   type, extends(constrained_ode_t) :: present_t
      private
      !> Whether x is projected before each evaluation; whether v is replaced at the end of a step as x is; whether forces are
      !! corrected, (g), or accelerations, (h).
      logical :: projects_stages = .true., replaces_v = .true., corrects_force = .false.
      !> Whether `at` was projected by `project` and nothing was evaluated since, so that (a) to (d) are done there.
      logical :: projected = .false.
   contains
      procedure :: set_up
      procedure :: rhs
      procedure :: project
      procedure :: filter_error
      procedure :: accepted
      procedure :: multipliers
      procedure :: stage_equations
   end type present_t

contains

   !> Reads the options of the method.
   subroutine set_up(self, error)
      !> The formulation.
      class(present_t), intent(inout) :: self
      !> Left alone.
      type(error_t), allocatable, intent(inout) :: error

      self%projects_stages = self%options%stage_projection == 'newton'
      self%replaces = self%options%state_projection /= 'none'
      self%replaces_v = self%options%state_projection == 'position-velocity'
      self%corrects_force = self%options%form == 'force'
      self%rhs_projects = self%projects_stages .or. .not. self%replaces
      self%finds_mu = .true.
      call self%mass%init_reduced(self%model, self%options, self%projector, same_place=.true.)
      associate (unused_error => error)
      end associate
   end subroutine set_up

   !> The paper's procedure, Sect. 3.5, step by step.
   subroutine rhs(self, t, y, dydt, info)
      !> The formulation.
      class(present_t), intent(inout) :: self
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
      info = rhs_ok
      self%evaluated = .false.
      associate (model => self%model, at => self%at, projector => self%projector, mass => self%mass, vdot => dydt(n_x + 1:last_v))
         if (.not. already_projected(self, t, y)) then
            call self%unpack(t, y, at)
            ! (a) project x on the invariant manifold, Eq. (17)
            call project_x(self, info)
            if (info /= rhs_ok) return
            ! (b) A, with the corrected x
            call projector%linear%evaluate(model, at)
            call projector%linear%factorize(model, at, info, 0.0_wp)
            if (info /= rhs_ok) return
            ! (c) b', with the corrected x, and (d) project v, Eq. (11a)
            call projector%velocity(model, at)
         end if
         ! (e) b'', with the corrected x and v
         call model%acceleration_rhs(at, self%b_second)
         ! (f) reduced mass matrix, Eq. (20), and unconstrained acceleration M^-1 f, Eq. (21)
         if (.not. mass%stays) then
            call mass%renew(model, at, info, projector)
            if (info == rhs_ok) call mass%reduce(projector, info)
            if (info /= rhs_ok) return
         end if
         call model%force(at, self%force)
         if (model%reactive) then
            call self%reactions%add(model, at, mass, projector, self%b_second, self%force, info)
            if (info /= rhs_ok) return
         end if
         call mass%accelerate(projector, self%force, vdot)
         if (self%corrects_force) then
            ! (g) correct the force, Eq. (19b)
            call mass%correct_force(projector, self%b_second, self%force, vdot, self%lambda)
         else
            ! (h) correct the acceleration, Eq. (11b)
            call mass%correct_acceleration(projector, self%b_second, vdot, self%lambda)
         end if
         ! (i) the original system, with corrected velocity and acceleration
         call model%x_rate(at, at%v, dydt(:n_x))
         if (model%n_w > 0) call model%w_rate(at, dydt(last_v + 1:))
         if (self%has_integral) call self%find_power(projector%b_prime)
      end associate
      self%evaluated = .true.
   end subroutine rhs

   !> Whether `at` is the state that `project` has left there.
   logical function already_projected(self, t, y) result(answer)
      type(present_t), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)

      answer = self%projected
      if (answer) answer = self%is_at(t, y)
      self%projected = .false.
   end function already_projected

   !> (a), or without projection of stages only what belongs to the coordinates by themselves.
   subroutine project_x(self, info)
      type(present_t), intent(inout) :: self
      integer, intent(out) :: info

      if (self%projects_stages) then
         call self%projector%newton%position(self%projector%linear, self%model, self%at, info)
         if (info == rhs_no_projection) call self%projector%position_again(self%model, self%at, info)
      else
         info = rhs_ok
         call self%model%normalize(self%at%x)
      end if
   end subroutine project_x

   !> Replaces x by Eq. (17) and v by Eq. (11a).
   !!
   !! With Eqs (11) on the projected state the right-hand side F satisfies F(P(y)) = F(y): the last stage holds P(y) already, and
   !! its derivative stays valid. Without projection of stages P comes first, and `rhs` goes on from what it leaves.
   subroutine project(self, t, y, place, stale, info)
      !> The formulation.
      class(present_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State {x; v; w}, replaced: (size).
      real(wp), intent(inout), contiguous :: y(:)
      !> `inside_step`, `step_end` or `evaluated_step_end`.
      integer, intent(in) :: place
      !> Whether the derivative has to be evaluated again.
      logical, intent(out) :: stale
      !> One of the `rhs_` constants.
      integer, intent(out) :: info
      integer :: n_x

      info = rhs_ok
      stale = .false.
      n_x = self%model%n_x
      if (.not. self%replaces) then
         call self%model%normalize(y(:n_x))
         return
      end if
      if (.not. (place == evaluated_step_end .and. self%projects_stages)) then
         self%evaluated = .false.
         call self%unpack(t, y, self%at)
         call self%projector%correct(self%model, self%at, info, linearized=place == evaluated_step_end)
         if (info /= rhs_ok) return
         self%projected = .not. self%projects_stages
         stale = place == evaluated_step_end
      end if
      if (place /= inside_step) call self%projector%check_branch(self%model, self%at, info)
      if (info /= rhs_ok) return
      y(:n_x) = self%at%x
      if (self%replaces_v) y(n_x + 1:n_x + self%model%n) = self%at%v
      if (place /= inside_step) call self%remember()
   end subroutine project

   !> Takes off the local error what `project` will take off the state.
   subroutine filter_error(self, error)
      !> The formulation.
      class(present_t), intent(inout) :: self
      !> Estimate of the local error: (size).
      real(wp), intent(inout), contiguous :: error(:)
      integer :: n_x

      if (.not. self%replaces) return
      n_x = self%model%n_x
      call self%projector%filter_position(self%model, self%at, error(:n_x))
      if (self%replaces_v) call self%projector%filter_velocity(self%model, error(n_x + 1:n_x + self%model%n))
   end subroutine filter_error

   !> Looks at the rank, there and not where something was looked up since.
   subroutine accepted(self, t, y, replaced)
      !> The formulation.
      class(present_t), intent(inout) :: self
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
         self%projected = .false.
         self%evaluated = .false.
         call self%unpack(t, y, self%at)
         info = rhs_ok
         if (self%projects_stages) call self%projector%position(self%model, self%at, info)
         if (info == rhs_ok) call self%projector%linear%linearize(self%model, self%at, info, 0.0_wp)
         if (info /= rhs_ok) return
      end if
      call self%projector%look(self%model, self%at)
   end subroutine accepted

   !> lambda of the last evaluation.
   subroutine multipliers(self, lambda)
      !> The formulation, as `rhs` left it.
      class(present_t), intent(inout) :: self
      !> Of least norm: (c).
      real(wp), intent(inout), contiguous :: lambda(:)

      lambda(:) = self%lambda
      call self%mass%least_norm(self%projector, lambda)
   end subroutine multipliers

   !> The same constraints in fully implicit form, Sect. 3.4.
   subroutine stage_equations(self, equations)
      !> The formulation.
      class(present_t), intent(inout) :: self
      !> Its equations.
      class(stage_equations_t), allocatable, intent(out) :: equations
      type(implicit_form_t), allocatable :: form

      allocate (form)
      call form%init(self%model, self%options)
      form%projector%newton%yardstick = self%projector%newton%yardstick
      call move_alloc(form, equations)
   end subroutine stage_equations

end module taut_constrained_method_present
