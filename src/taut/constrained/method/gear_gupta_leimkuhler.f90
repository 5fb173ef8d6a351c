!> Gear, Gupta and Leimkuhler: stabilized index 2, xdot = v - W^-1 A^T mu and M vdot = f - A^T lambda with phi = 0 and A v = b'.
!!
!! Half-explicit: multipliers belong to a stage, and are found so that the stage behind it meets the constraints. After the
!! state of a stage i is formed, y_i = y_n + h sum_j a_ij k_j, k_(i-1) is completed by -{H W^-1 A^T mu; M^-1 A^T lambda} of
!! stage i-1 with phi = 0 and A v = b' at y_i, by a Newton iteration with A of stage i-1. The new state is the last stage's, so
!! that it meets both without a projection. No b'' is asked for, and accelerations meet nothing. A pair that is not made for
!! index 2 keeps a lower order: that of Dormand and Prince 3 for x and v, and 1 for lambda. Multipliers that a stage begins
!! with, and that tables show, are those of the last one that was completed.
!!
!! With an implicit integrator the equations are those of `taut_constrained_implicit`.
!!
!! Source: C.W. Gear, G.K. Gupta, B. Leimkuhler, Automatic integration of Euler-Lagrange equations with constraints, J. Comput.
!! Appl. Math. 12&13 (1985) 77-90, reference [22] of the paper; half-explicit methods: E. Hairer, C. Lubich, M. Roche, The
!! numerical solution of differential-algebraic systems by Runge-Kutta methods, Springer 1989.
module taut_constrained_method_gear_gupta_leimkuhler
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   use taut_error, only: error_t, to_text
   use taut_constrained_implicit, only: implicit_form_t
   use taut_constrained_method_baseline, only: baseline_t
   use taut_constrained_jacobian, only: evaluate_jacobian, lay_out_jacobian
   use taut_constrained_system, only: state_t
   use taut_linalg_csr, only: csr_t
   use taut_ode_system, only: evaluated_step_end, inside_step, rhs_ok, rhs_no_projection, stage_equations_t
   implicit none (type, external)
   private
   public :: gear_gupta_leimkuhler_t

   !> Round-offs that are no violation.
   real(wp), parameter :: round_off = 8.0_wp*epsilon(1.0_wp)

   !> The method `gear-gupta-leimkuhler`.
   type, extends(baseline_t) :: gear_gupta_leimkuhler_t
      !> The stage that is to meet the constraints, and A there.
      type(state_t), private :: next
      type(csr_t), private :: a_next
      !> Violation of it before, largest entries.
      real(wp), private :: phi_before = 0.0_wp, phidot_before = 0.0_wp
      !> A displacement, its rate, and multipliers: (n), (n_x), (c).
      real(wp), allocatable, private :: d(:), rate(:), wanted(:), nu(:), none(:)
      logical, private :: lost = .false.
   contains
      procedure :: set_up
      procedure :: rhs
      procedure :: meet
      procedure :: project
      procedure :: later_corrections
      procedure :: filter_error
      procedure :: stage_equations
      procedure :: own_failure
      procedure :: serialize_own
   end type gear_gupta_leimkuhler_t

contains

   !> Makes room.
   subroutine set_up(self, error)
      !> The formulation.
      class(gear_gupta_leimkuhler_t), intent(inout) :: self
      !> Left alone.
      type(error_t), allocatable, intent(inout) :: error

      self%carries_reactions = .false.
      call self%mass%init_reduced(self%model, self%options, self%projector, same_place=.false.)
      self%half_explicit = .true.
      self%replaces = .true.
      associate (model => self%model)
         allocate (self%next%x(model%n_x), self%next%v(model%n), self%next%w(model%n_w), self%d(model%n), self%rate(model%n_x), &
                   self%wanted(model%c), self%nu(model%c), self%none(model%c), source=0.0_wp)
         call lay_out_jacobian(model, self%a_next)
      end associate
      associate (unused_error => error)
      end associate
   end subroutine set_up

   !> The derivative with the multipliers at hand, which `meet` completes.
   subroutine rhs(self, t, y, dydt, info)
      !> The formulation.
      class(gear_gupta_leimkuhler_t), intent(inout) :: self
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
         call self%linearize_here(info)
         if (info /= rhs_ok) return
         call model%force(at, self%force)
         call self%projector%linear%a%subtract_transposed(self%lambda, self%force)
         call self%mass%accelerate(self%projector, self%force, dydt(n_x + 1:last_v))
         if (self%has_integral) then
            call model%velocity_rhs(at, self%phidot)
            call self%find_power(self%phidot)
         end if
         call model%x_rate(at, at%v, dydt(:n_x))
         if (model%n_w > 0) call model%w_rate(at, dydt(last_v + 1:))
      end associate
   end subroutine rhs

   !> Completes the derivative of a stage so that the stage behind it meets phi = 0 and A v = b'.
   subroutine meet(self, t_start, y_start, first, t, weight, y, slope, info)
      !> The formulation, as `rhs` left it at the stage before.
      class(gear_gupta_leimkuhler_t), intent(inout) :: self
      !> Time of the step's start [s].
      real(wp), intent(in) :: t_start
      !> State there: (size).
      real(wp), intent(in), contiguous :: y_start(:)
      !> Whether the stage before is the step's start.
      logical, intent(in) :: first
      !> Time of the stage [s].
      real(wp), intent(in) :: t
      !> What the derivative of the stage before counts in its state, h a_(i,i-1) [s].
      real(wp), intent(in) :: weight
      !> State of the stage, completed: (size).
      real(wp), intent(inout), contiguous :: y(:)
      !> Derivative of the stage before, completed: (size).
      real(wp), intent(inout), contiguous :: slope(:)
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      info = rhs_ok
      self%lost = .false.
      if (self%model%c == 0) return
      if (first .and. .not. self%is_at(t_start, y_start)) then
         call self%unpack(t_start, y_start, self%at)
         call self%linearize_here(info)
         if (info /= rhs_ok) return
      end if
      call self%projector%linear%factorize(self%model, self%at, info, 0.0_wp)
      if (info == rhs_ok) call meet_positions(self, t, weight, y, slope, info)
      if (info == rhs_ok) call meet_velocities(self, weight, y, slope, info)
   end subroutine meet

   !> mu of the stage before.
   subroutine meet_positions(self, t, weight, y, slope, info)
      class(gear_gupta_leimkuhler_t), intent(inout) :: self
      real(wp), intent(in) :: t, weight
      real(wp), intent(inout), contiguous :: y(:), slope(:)
      integer, intent(out) :: info
      integer :: iteration, n_x
      real(wp) :: largest

      n_x = self%model%n_x
      info = rhs_ok
      self%phi_before = 0.0_wp
      do iteration = 0, self%options%max_iterations
         call self%unpack(t, y, self%next)
         call self%model%normalize(self%next%x)
         if (self%model%n_phi == 0) return
         call self%model%constraint(self%next, self%phi)
         largest = maxval(abs(self%phi))
         if (.not. largest <= huge(1.0_wp)) exit
         if (iteration == 0) self%phi_before = largest
         if (self%projector%newton%yardstick%measure(self%phi, self%next%x) <= self%options%projection_tolerance) return
         if (iteration == self%options%max_iterations) exit
         self%projector%newton%iterations = self%projector%newton%iterations + 1
         self%wanted(:) = 0.0_wp
         self%wanted(:self%model%n_phi) = -self%phi
         self%d(:) = 0.0_wp
         call self%projector%meet_holonomic(self%wanted, self%d, self%nu)
         call self%model%x_rate(self%at, self%d, self%rate)
         y(:n_x) = y(:n_x) + self%rate
         slope(:n_x) = slope(:n_x) + self%rate/weight
      end do
      self%lost = .true.
      info = rhs_no_projection
   end subroutine meet_positions

   !> lambda of the stage before.
   subroutine meet_velocities(self, weight, y, slope, info)
      class(gear_gupta_leimkuhler_t), intent(inout) :: self
      real(wp), intent(in) :: weight
      real(wp), intent(inout), contiguous :: y(:), slope(:)
      integer, intent(out) :: info
      integer :: first_v, iteration, last_v
      real(wp) :: largest, least

      first_v = self%model%n_x + 1
      last_v = self%model%n_x + self%model%n
      info = rhs_ok
      call evaluate_jacobian(self%model, self%next, self%a_next)
      call self%model%velocity_rhs(self%next, self%wanted)
      self%none(:) = self%wanted
      least = max(self%options%projection_tolerance, round_off*maxval(abs(self%next%v))*maxval(abs(self%a_next%values)))
      do iteration = 0, self%options%max_iterations
         call self%a_next%multiply(self%next%v, self%phidot, self%none)
         largest = maxval(abs(self%phidot))
         if (.not. largest <= huge(1.0_wp)) exit
         if (iteration == 0) self%phidot_before = largest
         if (largest <= least) return
         if (iteration == self%options%max_iterations) exit
         self%wanted(:) = -self%phidot
         self%d(:) = 0.0_wp
         call self%mass%correct_acceleration(self%projector, self%wanted, self%d, self%nu)
         self%next%v(:) = self%next%v + self%d
         y(first_v:last_v) = self%next%v
         slope(first_v:last_v) = slope(first_v:last_v) + self%d/weight
         self%lambda(:) = self%lambda + self%nu/weight
      end do
      self%lost = .true.
      info = rhs_no_projection
   end subroutine meet_velocities

   !> Leaves a new state that `meet` has completed; others, such as those inside a step, are projected, Eqs (17) and (11a).
   subroutine project(self, t, y, place, stale, info)
      !> The formulation.
      class(gear_gupta_leimkuhler_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State {x; v; w}, replaced: (size).
      real(wp), intent(inout), contiguous :: y(:)
      !> `inside_step`, `step_end` or `evaluated_step_end`.
      integer, intent(in) :: place
      !> False: the derivative stays.
      logical, intent(out) :: stale
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      stale = .false.
      info = rhs_ok
      if (place == evaluated_step_end) then
         call self%model%normalize(y(:self%model%n_x))
         call self%projector%check_branch(self%model, self%at, info)
         if (info /= rhs_ok) return
         self%step_end%phi = self%phi_before
         self%step_end%phidot = self%phidot_before
         self%step_end%mu(:) = 0.0_wp
         return
      end if
      call self%unpack(t, y, self%at)
      call self%projector%correct(self%model, self%at, info)
      if (info == rhs_ok .and. place /= inside_step) call self%projector%check_branch(self%model, self%at, info)
      if (info /= rhs_ok) return
      call self%pack(self%at, y)
      if (place /= inside_step) call self%remember()
   end subroutine project

   !> A new state is not projected: what was inside a step says nothing of it.
   subroutine later_corrections(self, d, bends)
      !> The formulation.
      class(gear_gupta_leimkuhler_t), intent(in) :: self
      !> Left alone: (n_x).
      real(wp), intent(inout), contiguous :: d(:)
      !> False.
      logical, intent(out) :: bends

      bends = .false.
      associate (unused_formulation => self, unused_displacement => d)
      end associate
   end subroutine later_corrections

   !> Takes off the local error what the multipliers take off the state.
   subroutine filter_error(self, error)
      !> The formulation.
      class(gear_gupta_leimkuhler_t), intent(inout) :: self
      !> Estimate of the local error: (size).
      real(wp), intent(inout), contiguous :: error(:)
      integer :: info, last_v, n_x

      if (self%model%c == 0) return
      n_x = self%model%n_x
      last_v = n_x + self%model%n
      call self%projector%linear%factorize(self%model, self%at, info, 0.0_wp)
      if (info /= rhs_ok) return
      call self%projector%filter_position(self%model, self%at, error(:n_x))
      self%none(:) = 0.0_wp
      call self%mass%correct_acceleration(self%projector, self%none, error(n_x + 1:last_v), self%nu)
   end subroutine filter_error

   !> The same equations for an implicit integrator.
   subroutine stage_equations(self, equations)
      !> The formulation.
      class(gear_gupta_leimkuhler_t), intent(inout) :: self
      !> Its equations.
      class(stage_equations_t), allocatable, intent(out) :: equations
      type(implicit_form_t), allocatable :: form

      allocate (form)
      call form%init(self%model, self%options)
      form%projector%newton%yardstick = self%projector%newton%yardstick
      call move_alloc(form, equations)
   end subroutine stage_equations

   !> Whether the multipliers of a stage were not found.
   subroutine own_failure(self, text)
      !> The formulation.
      class(gear_gupta_leimkuhler_t), intent(in) :: self
      !> One line, may be empty.
      character(:), allocatable, intent(out) :: text

      text = ''
      if (self%lost) text = 'the multipliers of a stage were not found in '//to_text(self%options%max_iterations)//' iterations'
   end subroutine own_failure

   !> Passes through an archive what is remembered from one step to the next.
   subroutine serialize_own(self, archive)
      !> The formulation.
      class(gear_gupta_leimkuhler_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      call archive%item('multipliers', self%lambda)
   end subroutine serialize_own

end module taut_constrained_method_gear_gupta_leimkuhler
