!> Constraints enforced within the discretization, so that their reactions do exactly no work over a step and energy is kept:
!> the midpoint rule with multipliers along a discrete derivative of phi.
!!
!!     x_new = x (+) h v_m,   v_m = (v + v_new)/2,   M (v_new - v) = h (f_m - A_m^T lambda),   phi(x_new) = 0
!!
!! f_m and M are those of the middle, x (+) h v_m/2. A_m is A there, corrected along each row's own coordinates so that
!! A_m h v_m = phi(x_new) - phi(x): then phi(x_new) = 0 and A_m v_m = 0 are the same statement, the constraint holds through its
!! derivative and cannot drift, and lambda^T A_m h v_m, the reactions' work, vanishes. Energy is kept to round-off, at any length of
!! the step, where M is constant and forces are linear in x; otherwise to the method's order, 2, without a trend. Velocities meet
!! their constraints on the average of a step, and at its ends to first order of its length. Non-holonomic ones hold at the middle.
!!
!! The equations are solved by iteration on f and A_m: for motions that are not stiff. Nothing dissipates.
!!
!! Source: derived from what the paper says of a technique by O.A. Bauchau, reference [28]: bundled in the discretization of the
!! constraint equation and of its derivative, and exploiting energy preservation of the integration; its dissipative
!! variant is not here. Whether the equations of [28] are the same is not known here.
module taut_constrained_stepper_energy_preserving
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   use taut_constrained_discrete_derivative, only: meet_difference
   use taut_constrained_method, only: constrained_ode_t
   use taut_constrained_method_options, only: method_t
   use taut_constrained_projection, only: projector_t
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_ode_step_control, only: controller_constants_t, step_control_t
   use taut_ode_stepper, only: stepper_t
   use taut_ode_system, only: ode_system_t, rhs_cannot, rhs_not_solved, rhs_ok, step_end
   implicit none (type, external)
   private
   public :: energy_preserving_t, new_energy_preserving

   !> Changes of displacements and velocities that are round-off, relative to coordinates and to velocities, and those that may be
   !! where they no longer shrink.
   real(wp), parameter :: round_off = 2.0_wp*epsilon(1.0_wp), noise = 1.0e3_wp*epsilon(1.0_wp)
   !> An iteration that shrinks by less is at rest, or leads nowhere.
   real(wp), parameter :: still_shrinks = 0.5_wp
   integer, parameter :: most_iterations = 50

   !> The stepper and what it remembers.
   type, extends(stepper_t) :: energy_preserving_t
      private
      !> S and M at the middle, with W = M; there once the system is met.
      type(projector_t), allocatable :: projector
      type(state_t) :: middle, behind
      logical :: is_ready = .false., has_history = .false.
      !> Whether there are forces that depend on multipliers, of which it has none.
      logical :: refuses = .false.
      !> The step before, and the step at hand.
      real(wp) :: h_old = 0.0_wp, h_try = 0.0_wp
      !> Mean accelerations of the step before, and of that at hand; velocities at the middle; displacement: (n of the system).
      real(wp), allocatable :: a_old(:), a(:), v_next(:), d(:)
      !> phi of both ends at the time of the middle and its difference, and of the new one at its own; what A_m v_m shall be.
      real(wp), allocatable :: phi_old(:), phi_new(:), difference(:), phi_end(:), wanted(:)
      real(wp), allocatable :: w_next(:)
      real(wp), allocatable :: ydot(:), error(:, :), y_start(:), y_end(:), slope_start(:), slope_end(:)
   contains
      procedure :: init
      procedure :: start
      procedure :: first_step
      procedure :: try
      procedure :: accept
      procedure :: prepare_dense
      procedure :: interpolate
      procedure :: serialize
      procedure :: failure
   end type energy_preserving_t

contains

   !> The method.
   pure subroutine new_energy_preserving(self)
      !> The stepper.
      type(energy_preserving_t), intent(out) :: self

      self%order = 2
      self%constants = controller_constants_t(exponent=0.7_wp/3.0_wp, memory=0.3_wp/3.0_wp)
   end subroutine new_energy_preserving

   !> Allocates the workspace of the state.
   subroutine init(self, n)
      !> The stepper.
      class(energy_preserving_t), intent(inout) :: self
      !> Number of entries of the state.
      integer, intent(in) :: n

      self%n = n
      allocate (self%ydot(n), self%error(n, 1), self%y_start(n), self%y_end(n), source=0.0_wp)
   end subroutine init

   !> Takes the sizes of a system; nothing is allocated afterwards.
   subroutine meet_system(self, ode)
      type(energy_preserving_t), intent(inout) :: self
      class(constrained_ode_t), intent(in) :: ode
      type(method_t) :: method

      if (self%is_ready) return
      method = ode%options
      method%weight = 'mass'
      allocate (self%projector)
      associate (model => ode%model)
         call self%projector%init(model, method)
         self%middle = ode%at
         self%behind = ode%at
         allocate (self%a(model%n), self%v_next(model%n), self%d(model%n), self%phi_old(model%n_phi), &
                   self%phi_new(model%n_phi), self%difference(model%n_phi), self%phi_end(model%n_phi), &
                   self%wanted(model%c), self%w_next(model%n_w), self%slope_start(model%n_x), self%slope_end(model%n_x), &
                   source=0.0_wp)
         if (.not. allocated(self%a_old)) allocate (self%a_old(model%n), source=0.0_wp)
      end associate
      self%is_ready = .true.
   end subroutine meet_system

   !> The accelerations at a start.
   subroutine start(self, ode, t, y, info)
      !> The stepper.
      class(energy_preserving_t), intent(inout) :: self
      !> What is integrated: a constrained system.
      class(ode_system_t), intent(inout) :: ode
      !> Time [s].
      real(wp), intent(in) :: t
      !> State: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      info = rhs_cannot
      select type (ode)
      class is (constrained_ode_t)
         self%refuses = ode%model%reactive
         if (self%refuses) return
         call meet_system(self, ode)
         call self%evaluate(ode, t, y, self%ydot, info)
         self%a_old(:) = self%ydot(ode%model%n_x + 1:ode%model%n_x + ode%model%n)
      end select
      self%has_history = .false.
   end subroutine start

   !> Length of the first step.
   subroutine first_step(self, ode, control, t, y, longest, h)
      !> The stepper, behind `start`.
      class(energy_preserving_t), intent(inout) :: self
      !> What is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> Norm of errors.
      type(step_control_t), intent(in) :: control
      !> Time [s].
      real(wp), intent(in) :: t
      !> State: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Length of the longest first step, with the sign of the direction [s].
      real(wp), intent(in) :: longest
      !> Proposed length, with the sign of the direction [s].
      real(wp), intent(out) :: h

      h = control%cautious_start(self%ydot, y, longest)
      associate (unused_system => ode, unused_time => t)
      end associate
   end subroutine first_step

   !> One try.
   subroutine try(self, ode, control, t, y, t_new, h, y_new, h_next, accepted, info)
      !> The stepper.
      class(energy_preserving_t), intent(inout) :: self
      !> What is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> Its norm and its controller are used.
      type(step_control_t), intent(inout) :: control
      !> Time at its start [s].
      real(wp), intent(in) :: t
      !> State at its start: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Time at its end [s].
      real(wp), intent(in) :: t_new
      !> Its length [s].
      real(wp), intent(in) :: h
      !> State at its end: (n).
      real(wp), intent(out), contiguous :: y_new(:)
      !> Length of the next try [s].
      real(wp), intent(out) :: h_next
      !> Whether the step holds.
      logical, intent(out) :: accepted
      !> `rhs_ok`, or why there is no new state.
      integer, intent(out) :: info
      logical :: stale

      accepted = .false.
      h_next = 0.5_wp*h
      y_new(:) = y
      info = rhs_cannot
      select type (ode)
      class is (constrained_ode_t)
         ! Behind a restart it is not ready yet.
         call meet_system(self, ode)
         self%behind%t = min(max(t, ode%t_low), ode%t_high)
         call decide_rank(self, ode%model, y, info)
         self%middle%t = min(max(0.5_wp*(t + t_new), ode%t_low), ode%t_high)
         self%behind%t = min(max(t_new, ode%t_low), ode%t_high)
         if (info == rhs_ok) call solve(self, ode%model, y, h, info)
         if (info /= rhs_ok) return
         call arrive(self, ode%model, y, h, y_new)
         if (control%fixed) then
            accepted = .true.
            h_next = h
         else
            call estimate(self, ode%model, h)
            call ode%weigh_error(h, self%error(:, 1))
            call control%decide(h, self%error, y, y_new, h_next, accepted)
            if (.not. accepted) return
         end if
      end select
      call ode%project(t_new, y_new, step_end, stale, info)
      if (info /= rhs_ok) accepted = .false.
      self%h_try = h
   end subroutine try

   !> Which rows are independent is decided where the step begins, on the constraints, and holds for what lies beside them.
   subroutine decide_rank(self, model, y, info)
      type(energy_preserving_t), intent(inout) :: self
      class(mechanical_system_t), intent(in) :: model
      real(wp), intent(in), contiguous :: y(:)
      integer, intent(out) :: info

      info = rhs_ok
      if (model%c < 2) return
      associate (behind => self%behind, projector => self%projector)
         behind%x(:) = y(:model%n_x)
         behind%v(:) = y(model%n_x + 1:model%n_x + model%n)
         call projector%linear%keeper%release()
         call projector%linear%keeper_of_holonomic%release()
         call projector%linear%linearize(model, behind, info, 0.0_wp)
         if (info == rhs_ok) call projector%look(model, behind)
      end associate
   end subroutine decide_rank

   !> The velocities at the middle.
   subroutine solve(self, model, y, h, info)
      type(energy_preserving_t), intent(inout) :: self
      class(mechanical_system_t), intent(in) :: model
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(in) :: h
      integer, intent(out) :: info
      integer :: first_v, first_w, i, iteration
      real(wp) :: before, change, largest, of_x

      first_v = model%n_x
      first_w = first_v + model%n
      associate (middle => self%middle)
         do i = 1, model%n
            middle%v(i) = y(first_v + i) + 0.5_wp*h*self%a_old(i)
         end do
         middle%w(:) = y(first_w + 1:)
         ! Round-off of phi, as a velocity.
         of_x = maxval(abs(y(:model%n_x)))/abs(h)
         before = huge(1.0_wp)
         do iteration = 1, most_iterations
            self%work%rhs = self%work%rhs + 1
            self%work%iterations = self%work%iterations + 1
            call look_ahead(self, model, y, h, info)
            if (info /= rhs_ok) return
            call model%force(middle, self%v_next)
            call self%projector%linear%divide_by_weight(self%v_next)
            largest = 0.0_wp
            do i = 1, model%n
               self%a(i) = self%v_next(i)
               self%v_next(i) = y(first_v + i) + 0.5_wp*h*self%v_next(i)
               largest = max(largest, abs(self%v_next(i)), abs(y(first_v + i)))
            end do
            call self%projector%meet(self%wanted, self%v_next)
            if (model%n_w > 0) then
               call model%w_rate(middle, self%w_next)
               self%w_next(:) = y(first_w + 1:) + 0.5_wp*h*self%w_next
               largest = max(largest, maxval(abs(self%w_next)))
            end if
            change = maxval(abs(self%v_next - middle%v))
            if (model%n_w > 0) change = max(change, maxval(abs(self%w_next - middle%w)))
            if (.not. change <= huge(1.0_wp)) exit
            middle%v(:) = self%v_next
            middle%w(:) = self%w_next
            if (change <= round_off*max(largest, of_x)) return
            if (change > still_shrinks*before) then
               if (change <= noise*max(largest, of_x)) return
               if (iteration > 3) exit
            end if
            before = change
         end do
      end associate
      info = rhs_not_solved
   end subroutine solve

   !> Where the velocities at the middle lead: A_m, S and what A_m v_m shall be.
   subroutine look_ahead(self, model, y, h, info)
      type(energy_preserving_t), intent(inout) :: self
      class(mechanical_system_t), intent(in) :: model
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(in) :: h
      integer, intent(out) :: info
      real(wp) :: t_end

      associate (middle => self%middle, behind => self%behind, projector => self%projector)
         t_end = behind%t
         self%d(:) = 0.5_wp*h*middle%v
         call go(middle)
         self%d(:) = h*middle%v
         call projector%linear%evaluate(model, middle)
         if (model%n_phi > 0) then
            behind%t = middle%t
            behind%x(:) = y(:model%n_x)
            call model%constraint(behind, self%phi_old)
            call go(behind)
            call model%constraint(behind, self%phi_new)
            behind%t = t_end
            call model%constraint(behind, self%phi_end)
            self%difference(:) = self%phi_new - self%phi_old
            call meet_difference(projector%linear%a, self%d, self%difference)
         end if
         call model%velocity_rhs(middle, self%wanted)
         call aim(self, model%n_phi, h)
         call projector%linear%factorize(model, middle, info, 0.0_wp)
      end associate

   contains

      subroutine go(at)
         type(state_t), intent(inout) :: at

         at%x(:) = y(:model%n_x)
         call model%displace(self%d, at%x)
         call model%normalize(at%x)
      end subroutine go

   end subroutine look_ahead

   !> What A_m v_m shall be for the holonomic rows: what it is, less what phi is off at the end.
   subroutine aim(self, n_phi, h)
      type(energy_preserving_t), intent(inout) :: self
      integer, intent(in) :: n_phi
      real(wp), intent(in) :: h
      integer :: i

      do i = 1, n_phi
         self%wanted(i) = (self%difference(i) - self%phi_end(i))/h
      end do
   end subroutine aim

   !> The state behind the step.
   subroutine arrive(self, model, y, h, y_new)
      type(energy_preserving_t), intent(inout) :: self
      class(mechanical_system_t), intent(in) :: model
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(in) :: h
      real(wp), intent(inout), contiguous :: y_new(:)
      integer :: first_v, first_w, i

      first_v = model%n_x
      first_w = first_v + model%n
      self%d(:) = h*self%middle%v
      self%behind%x(:) = y(:first_v)
      call model%displace(self%d, self%behind%x)
      call model%normalize(self%behind%x)
      y_new(:first_v) = self%behind%x
      do i = 1, model%n
         y_new(first_v + i) = 2.0_wp*self%middle%v(i) - y(first_v + i)
         self%a(i) = (y_new(first_v + i) - y(first_v + i))/h
      end do
      do i = 1, model%n_w
         y_new(first_w + i) = 2.0_wp*self%middle%w(i) - y(first_w + i)
      end do
   end subroutine arrive

   !> h^3/12 times the third derivative of x, by the accelerations of two steps; h^2/12 for velocities, which count with h.
   subroutine estimate(self, model, h)
      type(energy_preserving_t), intent(inout) :: self
      class(mechanical_system_t), intent(in) :: model
      real(wp), intent(in) :: h
      real(wp) :: apart

      apart = 0.5_wp*h
      if (self%has_history) apart = 0.5_wp*(h + self%h_old)
      self%error(:, 1) = 0.0_wp
      self%d(:) = h**2/12.0_wp*(self%a - self%a_old)/apart
      self%error(model%n_x + 1:model%n_x + model%n, 1) = self%d
      self%d(:) = h*self%d
      call model%x_rate(self%behind, self%d, self%error(:model%n_x, 1))
   end subroutine estimate

   !> The end of the last try is where the next one starts.
   subroutine accept(self)
      !> The stepper, behind a try that holds.
      class(energy_preserving_t), intent(inout) :: self

      self%a_old(:) = self%a
      self%h_old = self%h_try
      self%has_history = .true.
   end subroutine accept

   !> States at both ends, and the rates of the coordinates.
   subroutine prepare_dense(self, ode, t, y, t_new, h, y_new, info)
      !> The stepper, behind a try that holds.
      class(energy_preserving_t), intent(inout) :: self
      !> What is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> Time at the step's start [s].
      real(wp), intent(in) :: t
      !> State at the step's start: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Time at the step's end [s].
      real(wp), intent(in) :: t_new
      !> The step's length [s].
      real(wp), intent(in) :: h
      !> State at the step's end: (n).
      real(wp), intent(in), contiguous :: y_new(:)
      !> Always `rhs_ok`.
      integer, intent(out) :: info

      info = rhs_ok
      self%y_start(:) = y
      self%y_end(:) = y_new
      select type (ode)
      class is (constrained_ode_t)
         call ode%unpack(t, y, self%behind)
         call ode%model%x_rate(self%behind, self%behind%v, self%slope_start)
         call ode%unpack(t_new, y_new, self%behind)
         call ode%model%x_rate(self%behind, self%behind%v, self%slope_end)
      end select
      self%slope_start(:) = h*self%slope_start
      self%slope_end(:) = h*self%slope_end
   end subroutine prepare_dense

   !> Coordinates by the cubic through both ends with their rates, all else by the straight line.
   subroutine interpolate(self, theta, y)
      !> The stepper.
      class(energy_preserving_t), intent(in) :: self
      !> Fraction of the step, 0 at its start and 1 at its end.
      real(wp), intent(in) :: theta
      !> State: (n).
      real(wp), intent(out), contiguous :: y(:)
      real(wp) :: back
      integer :: n_x

      back = 1.0_wp - theta
      n_x = size(self%slope_start)
      y(:) = back*self%y_start + theta*self%y_end
      y(:n_x) = (1.0_wp + 2.0_wp*theta)*back**2*self%y_start(:n_x) + theta**2*(1.0_wp + 2.0_wp*back)*self%y_end(:n_x) + &
                theta*back*(back*self%slope_start - theta*self%slope_end)
   end subroutine interpolate

   !> Why the last try has failed, in words.
   subroutine failure(self, ode, text)
      !> The stepper.
      class(energy_preserving_t), intent(in) :: self
      !> What is integrated.
      class(ode_system_t), intent(in) :: ode
      !> One line, may be empty.
      character(:), allocatable, intent(out) :: text

      text = 'it has no multipliers for forces that depend on them'
      if (.not. self%refuses) call ode%failure(text)
   end subroutine failure

   !> Passes what is remembered between two steps through an archive.
   subroutine serialize(self, archive)
      !> The stepper, initialized.
      class(energy_preserving_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      call archive%item('last step', self%h_old)
      call archive%item('has history', self%has_history)
      call archive%list('accelerations', self%a_old)
   end subroutine serialize

end module taut_constrained_stepper_energy_preserving
