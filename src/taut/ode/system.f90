!> Systems of ordinary differential equations y' = f(t, y), and nothing about where they come from.
module taut_ode_system
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   use taut_error, only: to_text
   implicit none (type, external)
   private
   public :: ode_system_t, stage_equations_t
   public :: rhs_ok, rhs_retry, rhs_failed, rhs_no_projection, rhs_cannot, rhs_not_solved, rhs_not_finite
   public :: inside_step, step_end, evaluated_step_end
   public :: no_trouble, not_linearized, not_factorized, not_converged

   !> What a right-hand side or a projection answers.
   !!
   !! `rhs_retry`: not defined here, try a smaller step; `rhs_failed`: stop; `rhs_no_projection`: the projection on the
   !! constraints did not converge, try a smaller step; `rhs_cannot`: the system does not offer this at all;
   !! `rhs_not_solved`: the equations of an implicit step were not solved, try a smaller step; `rhs_not_finite`: an entry of the
   !! derivative is not a number, try a smaller step (integrators find that by themselves).
   integer, parameter :: rhs_ok = 0, rhs_retry = 1, rhs_failed = 2, rhs_no_projection = 3, rhs_cannot = 4, &
                         rhs_not_solved = 5, rhs_not_finite = 6

   !> Where a state lies that is projected: inside a step or at none; at the end of a step; there, and the last call of the
   !! right-hand side was for this very state, so that what it found may be used again.
   integer, parameter :: inside_step = 1, step_end = 2, evaluated_step_end = 3

   !> What of an implicit step went wrong: nothing; the derivatives could not be taken; the matrix is singular; Newton's iteration
   !! did not converge.
   integer, parameter :: no_trouble = 0, not_linearized = 1, not_factorized = 2, not_converged = 3

   !> y' = f(t, y). A system owns the workspace of its right-hand side: one object per thread.
   !!
   !! Any integrator may call it, in this order. Every one: `rhs` at the states of its stages; `filter_error` on each vector
   !! that estimates the local error, before its norm is taken; explicit ones `meet` on each stage behind the first if the
   !! system is `half_explicit`; `project` on a new state, before or
   !! behind the evaluation there (see `rhs_projects`), and on states interpolated inside a step, and `rhs` once more where the
   !! answer is `stale`; `accepted` when a step
   !! holds and its output is done; `cross` behind a breakpoint. An implicit one besides: `linearize` at a state, `factorize`
   !! for each shift that it needs and `solve` as often as it likes, until the next of them; `weigh_error` on an estimate from
   !! such solutions; or, of a system that has them, `stage_equations`, which hold the algebraic unknowns of a constrained
   !! system as well. Times given to `rhs` are kept within `t_low` and `t_high`, which the integrator sets at a breakpoint and
   !! `huge` where there is none.
   type, abstract :: ode_system_t
      !> Whether a step is judged by its projection, see `projection_holds`: it makes no sense where violations gather over many
      !! steps before they are corrected.
      logical :: limits_projection = .true.
      !> Which entry of the last derivative was not finite, if one was; set by the integrator.
      integer :: not_finite = 0
      !> The first so many entries of y are coordinates, and the next so many their velocities, by which projections are judged;
      !! no coordinates: all entries are taken for such.
      integer :: coordinates = 0, velocities = 0
      !> Whether the right-hand side F satisfies F(P(y)) = F(y), with P what `project` does: then an evaluation at a new state holds
      !! for the projected one too, and `project` may follow it at no cost. Else a new state is projected first.
      logical :: rhs_projects = .true.
      !> A quantity whose integral over time goes along, such as a power: whether there is one; its value, which `rhs` finds; and
      !! its integral since the start, which the integrator keeps, with the stepper's weights, and tells before a state is shown.
      logical :: has_integral = .false.
      real(wp) :: integrand = 0.0_wp, integral = 0.0_wp
      !> How far the integral may be off: the sum of the steps' estimates.
      real(wp) :: integral_error = 0.0_wp
      !> Whether a step is judged by the integral as well, for a motion whose state is given and has no error of its own; what of
      !! the integral's kind there is from the start, which its errors are compared with beside itself, times the relative
      !! tolerance; and what the absolute tolerance is multiplied with.
      logical :: integral_counts = .false.
      real(wp) :: integral_scale = 0.0_wp, integral_unit = 0.0_wp
      !> Whether the derivative of a stage is completed by where it leads: `meet`.
      logical :: half_explicit = .false.
      !> Times between which the system is looked at [s], set by the integrator: inside two breakpoints, where a load or a drive
      !! may jump. A state at a breakpoint belongs to the stretch before it, until the next one begins.
      real(wp) :: t_low = -huge(1.0_wp), t_high = huge(1.0_wp)
   contains
      procedure(right_hand_side), deferred :: rhs
      procedure :: project => project_nothing
      procedure :: meet => nothing_to_meet
      procedure :: later_corrections => straight_back
      procedure :: filter_error => filter_nothing
      procedure :: accepted => nothing_to_switch
      procedure :: cross => project_behind
      procedure :: linearize => no_linearization
      procedure :: factorize => no_factorization
      procedure :: solve => no_solution
      procedure :: weigh_error => weigh_alike
      procedure :: stage_equations => no_stage_equations
      procedure :: breakpoints => no_breakpoints
      procedure :: failure => no_failure
      procedure :: find_fault => cannot_look
      procedure :: entry_name => numbered_entry
      procedure :: recount => nothing_counted
      procedure :: serialize => nothing_to_serialize
   end type ode_system_t

   !> A system in fully implicit form, g(y, ydot, z, t) = 0, with algebraic unknowns z beside the state, and Newton's matrices for
   !! it: what an implicit Runge-Kutta method asks for where y' = f(t, y) would hide too much, as with constraints. Procedures
   !! are given the system that has made them.
   type, abstract :: stage_equations_t
      !> Numbers of entries of y and z.
      integer :: n = 0, n_z = 0
      !> Evaluations of the residual, or of the right-hand side.
      integer :: evaluations = 0
      !> Whether the last linearization was at a dead point.
      logical :: at_dead_point = .false.
   contains
      procedure(start_equations), deferred :: start
      procedure(residual_of_stage), deferred :: residual
      procedure(integrand_of_stage), deferred :: find_integrand
      procedure(linearize_equations), deferred :: linearize
      procedure :: refresh => nothing_to_refresh
      procedure(factorize_equations), deferred :: factorize
      procedure(solve_equations), deferred :: solve
      procedure(multiply_derivative), deferred :: multiply
      procedure(find_round_off), deferred :: round_off
      procedure :: settle => nothing_to_settle
      procedure :: yield => nothing_to_yield
      procedure :: let_go => nothing_to_let_go
      procedure :: take_back => nothing_to_take_back
      procedure :: explain => nothing_to_explain
      procedure :: serialize => equations_without_memory
   end type stage_equations_t

   abstract interface
      !> ydot and z of a state that an integration starts from, or goes on from behind a breakpoint.
      subroutine start_equations(self, ode, t, y, first, ydot, z, info)
         import :: ode_system_t, stage_equations_t, wp
         implicit none (type, external)
         !> The equations.
         class(stage_equations_t), intent(inout) :: self
         !> The system.
         class(ode_system_t), intent(inout) :: ode
         !> Time [s].
         real(wp), intent(in) :: t
         !> State: (n).
         real(wp), intent(in), contiguous :: y(:)
         !> Whether z is not known yet; else what of it a jump leaves as it is, such as internal forces, is kept.
         logical, intent(in) :: first
         !> Its derivative: (n).
         real(wp), intent(out), contiguous :: ydot(:)
         !> Algebraic unknowns: (n_z).
         real(wp), intent(inout), contiguous :: z(:)
         !> One of the `rhs_` constants.
         integer, intent(out) :: info
      end subroutine start_equations

      !> g(y, ydot, z, t).
      subroutine residual_of_stage(self, ode, t, y, ydot, z, r, info)
         import :: ode_system_t, stage_equations_t, wp
         implicit none (type, external)
         !> The equations.
         class(stage_equations_t), intent(inout) :: self
         !> The system.
         class(ode_system_t), intent(inout) :: ode
         !> Time [s].
         real(wp), intent(in) :: t
         !> State: (n).
         real(wp), intent(in), contiguous :: y(:)
         !> Its derivative: (n).
         real(wp), intent(in), contiguous :: ydot(:)
         !> Algebraic unknowns: (n_z).
         real(wp), intent(in), contiguous :: z(:)
         !> What is to vanish: (n + n_z).
         real(wp), intent(out), contiguous :: r(:)
         !> One of the `rhs_` constants.
         integer, intent(out) :: info
      end subroutine residual_of_stage

      !> The integrand where a state solves the equations, for systems that have an integral.
      subroutine integrand_of_stage(self, ode, t, y, z)
         import :: ode_system_t, stage_equations_t, wp
         implicit none (type, external)
         !> The equations.
         class(stage_equations_t), intent(inout) :: self
         !> The system; its integrand stays what it was where there is none.
         class(ode_system_t), intent(inout) :: ode
         !> Time [s].
         real(wp), intent(in) :: t
         !> State: (n).
         real(wp), intent(in), contiguous :: y(:)
         !> Algebraic unknowns: (n_z).
         real(wp), intent(in), contiguous :: z(:)
      end subroutine integrand_of_stage

      !> The derivatives of g at a state.
      subroutine linearize_equations(self, ode, t, h, y, ydot, z, info)
         import :: ode_system_t, stage_equations_t, wp
         implicit none (type, external)
         !> The equations.
         class(stage_equations_t), intent(inout) :: self
         !> The system.
         class(ode_system_t), intent(inout) :: ode
         !> Time [s].
         real(wp), intent(in) :: t
         !> Step, which tells how far the state is going to move [s].
         real(wp), intent(in) :: h
         !> State: (n).
         real(wp), intent(in), contiguous :: y(:)
         !> Its derivative: (n).
         real(wp), intent(in), contiguous :: ydot(:)
         !> Algebraic unknowns: (n_z).
         real(wp), intent(in), contiguous :: z(:)
         !> One of the `rhs_` constants.
         integer, intent(out) :: info
      end subroutine linearize_equations

      !> Factorizes shift*dg/dydot + {dg/dy, dg/dz}.
      subroutine factorize_equations(self, ode, slot, shift, info)
         import :: ode_system_t, stage_equations_t, wp
         implicit none (type, external)
         !> The equations, linearized.
         class(stage_equations_t), intent(inout) :: self
         !> The system.
         class(ode_system_t), intent(inout) :: ode
         !> Where the factors are kept: 1 for a shift without an imaginary part, 2 for one with.
         integer, intent(in) :: slot
         !> What d/dt is replaced by [1/s].
         complex(wp), intent(in) :: shift
         !> One of the `rhs_` constants; `rhs_retry` for a singular matrix.
         integer, intent(out) :: info
      end subroutine factorize_equations

      !> Newton's correction of y and z: minus the residual, divided by the matrix.
      subroutine solve_equations(self, ode, slot, r)
         import :: ode_system_t, stage_equations_t, wp
         implicit none (type, external)
         !> The equations, factorized.
         class(stage_equations_t), intent(inout) :: self
         !> The system.
         class(ode_system_t), intent(inout) :: ode
         !> Which factors.
         integer, intent(in) :: slot
         !> Residual, replaced by the correction: (n + n_z).
         complex(wp), intent(inout), contiguous :: r(:)
      end subroutine solve_equations

      !> dg/dydot q.
      subroutine multiply_derivative(self, q, r)
         import :: stage_equations_t, wp
         implicit none (type, external)
         !> The equations, linearized.
         class(stage_equations_t), intent(in) :: self
         !> A derivative of the state: (n).
         real(wp), intent(in), contiguous :: q(:)
         !> The product, zero beyond n: (n + n_z).
         real(wp), intent(out), contiguous :: r(:)
      end subroutine multiply_derivative

      !> What round-off may leave of g(y, ydot, z, t), however good y, ydot and z are.
      subroutine find_round_off(self, y, ydot, z, r)
         import :: stage_equations_t, wp
         implicit none (type, external)
         !> The equations, linearized.
         class(stage_equations_t), intent(inout) :: self
         !> State: (n).
         real(wp), intent(in), contiguous :: y(:)
         !> Its derivative: (n).
         real(wp), intent(in), contiguous :: ydot(:)
         !> Algebraic unknowns: (n_z).
         real(wp), intent(in), contiguous :: z(:)
         !> Its size, without a sign: (n + n_z).
         real(wp), intent(out), contiguous :: r(:)
      end subroutine find_round_off
   end interface

   abstract interface
      !> The derivative of the state.
      subroutine right_hand_side(self, t, y, dydt, info)
         import :: ode_system_t, wp
         implicit none (type, external)
         !> The system.
         class(ode_system_t), intent(inout) :: self
         !> Time [s].
         real(wp), intent(in) :: t
         !> State: (n).
         real(wp), intent(in), contiguous :: y(:)
         !> Its derivative: (n).
         real(wp), intent(out), contiguous :: dydt(:)
         !> One of the `rhs_` constants. Entries that are not finite also mean 'try a smaller step'.
         integer, intent(out) :: info
      end subroutine right_hand_side
   end interface

contains

   !> Brings to another state what of the derivatives costs little, and leaves the rest as `linearize` has found it. The default
   !! leaves all.
   subroutine nothing_to_refresh(self, ode, t, y, ydot, z, info)
      !> The equations, linearized.
      class(stage_equations_t), intent(inout) :: self
      !> The system.
      class(ode_system_t), intent(inout) :: ode
      !> Time [s].
      real(wp), intent(in) :: t
      !> State: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Its derivative: (n).
      real(wp), intent(in), contiguous :: ydot(:)
      !> Algebraic unknowns: (n_z).
      real(wp), intent(in), contiguous :: z(:)
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      info = rhs_ok
      associate (unused_equations => self, unused_system => ode, unused_time => t, unused_state => y, unused_rate => ydot, &
                 unused_others => z)
      end associate
   end subroutine nothing_to_refresh

   !> What a step has left that held something, at its end, which is projected: as far as round-off lets it be taken off. The
   !! default takes off nothing.
   subroutine nothing_to_take_back(self, ode, t, y, other)
      !> The equations.
      class(stage_equations_t), intent(inout) :: self
      !> The system.
      class(ode_system_t), intent(in) :: ode
      !> Time [s].
      real(wp), intent(in) :: t
      !> State, replaced: (n).
      real(wp), intent(inout), contiguous :: y(:)
      !> A state that differs from it by round-off, and by what the equations make of that: (n).
      real(wp), intent(out), contiguous :: other(:)

      other(:) = y
      associate (unused_equations => self, unused_system => ode, unused_time => t)
      end associate
   end subroutine nothing_to_take_back

   !> What went wrong in an implicit step, in words. The default names the entry of the state.
   subroutine nothing_to_explain(self, trouble, entry, text)
      !> The equations.
      class(stage_equations_t), intent(in) :: self
      !> One of the constants, not `no_trouble`.
      integer, intent(in) :: trouble
      !> Entry of y with the largest correction of an iteration that did not converge.
      integer, intent(in) :: entry
      !> One line, may be empty.
      character(:), allocatable, intent(out) :: text

      text = ''
      if (trouble == not_converged) text = 'the largest correction is that of y('//to_text(entry)//')'
      if (trouble == not_factorized) text = 'its matrix is singular'
      associate (unused_equations => self)
      end associate
   end subroutine nothing_to_explain

   !> Passes through an archive what is remembered from one step to the next, the matrices apart. The default remembers nothing.
   subroutine equations_without_memory(self, archive)
      !> The equations.
      class(stage_equations_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      associate (unused_equations => self, unused_archive => archive)
      end associate
   end subroutine equations_without_memory

   !> Replaces a state by the one on the system's invariants. The default leaves it as it is.
   subroutine project_nothing(self, t, y, place, stale, info)
      !> The system.
      class(ode_system_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State, replaced: (n).
      real(wp), intent(inout), contiguous :: y(:)
      !> `inside_step`, `step_end` or `evaluated_step_end`.
      integer, intent(in) :: place
      !> Whether a derivative evaluated at the old state differs from that at the new one, and has to be evaluated again.
      logical, intent(out) :: stale
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      stale = .false.
      info = rhs_ok
      associate (unused_system => self, unused_time => t, unused_state => y, unused_place => place)
      end associate
   end subroutine project_nothing

   !> Completes the derivative of the stage that was evaluated last, or of the step's start, so that the stage behind it is on the
   !! system's invariants: what a half-explicit Runge-Kutta method does. The default has nothing to complete.
   subroutine nothing_to_meet(self, t_start, y_start, first, t, weight, y, slope, info)
      !> The system.
      class(ode_system_t), intent(inout) :: self
      !> Time of the step's start [s].
      real(wp), intent(in) :: t_start
      !> State there: (n).
      real(wp), intent(in), contiguous :: y_start(:)
      !> Whether the stage before is the step's start.
      logical, intent(in) :: first
      !> Time of the stage [s].
      real(wp), intent(in) :: t
      !> What the derivative of the stage before counts in its state [s].
      real(wp), intent(in) :: weight
      !> State of the stage, completed: (n).
      real(wp), intent(inout), contiguous :: y(:)
      !> Derivative of the stage before, completed: (n).
      real(wp), intent(inout), contiguous :: slope(:)
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      info = rhs_ok
      associate (unused_system => self, unused_start => t_start, unused_state => y_start, unused_place => first, unused_time => t, &
                 unused_weight => weight, unused_stage => y, unused_slope => slope)
      end associate
   end subroutine nothing_to_meet

   !> By how much the last `project` at a step's end has moved the coordinates after its first correction: how much the way back
   !! bends. The default comes back straight.
   subroutine straight_back(self, d, bends)
      !> The system.
      class(ode_system_t), intent(in) :: self
      !> Displacement, if there is any: (coordinates).
      real(wp), intent(inout), contiguous :: d(:)
      !> Whether there is.
      logical, intent(out) :: bends

      bends = .false.
      associate (unused_system => self, unused_displacement => d)
      end associate
   end subroutine straight_back

   !> Takes off a local error what `project` will take off the state, at the state of the last call of `rhs`. The
   !! default takes off nothing.
   subroutine filter_nothing(self, error)
      !> The system.
      class(ode_system_t), intent(inout) :: self
      !> Estimate of the local error: (n).
      real(wp), intent(inout), contiguous :: error(:)

      associate (unused_system => self, unused_error => error)
      end associate
   end subroutine filter_nothing

   !> A step holds, and its output is done: the system may continue from another state that means the same, for instance in
   !! other coordinates. The default does nothing.
   subroutine nothing_to_switch(self, t, y, replaced)
      !> The system.
      class(ode_system_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State, on the system's invariants; may be replaced: (n).
      real(wp), intent(inout), contiguous :: y(:)
      !> Whether it was, so that derivatives and history are stale.
      logical, intent(out) :: replaced

      replaced = .false.
      associate (unused_system => self, unused_time => t, unused_state => y)
      end associate
   end subroutine nothing_to_switch

   !> A breakpoint lies behind: what has begun there may ask for another state, as a blow does. The default projects.
   subroutine project_behind(self, t, before, y, info)
      !> The system, told of the times behind the breakpoint.
      class(ode_system_t), intent(inout) :: self
      !> Time of the breakpoint [s].
      real(wp), intent(in) :: t
      !> The last time at which the system was looked at on the other side [s].
      real(wp), intent(in) :: before
      !> State, replaced: (n).
      real(wp), intent(inout), contiguous :: y(:)
      !> One of the `rhs_` constants.
      integer, intent(out) :: info
      logical :: stale

      call self%project(t, y, inside_step, stale, info)
      associate (unused_time => before)
      end associate
   end subroutine project_behind

   !> Sets the algebraic unknowns that the equations, as they were linearized, do not determine. By default there are none.
   pure subroutine nothing_to_settle(self, z_start, z)
      !> The equations, linearized.
      class(stage_equations_t), intent(in) :: self
      !> z at the step's start: (n_z).
      real(wp), intent(in), contiguous :: z_start(:)
      !> z as it is predicted: (n_z).
      real(wp), intent(inout), contiguous :: z(:)

      associate (unused_equations => self, unused_start => z_start, unused_unknowns => z)
      end associate
   end subroutine nothing_to_settle

   !> Holds what cannot be solved for with one Jacobian all over a step, where Newton's iteration does not converge. By default
   !! there is nothing.
   subroutine nothing_to_yield(self, h, yields, info)
      !> The equations, linearized.
      class(stage_equations_t), intent(inout) :: self
      !> The step [s].
      real(wp), intent(in) :: h
      !> Whether something is held now, until it is released; it is to be linearized again.
      logical, intent(out) :: yields
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      yields = .false.
      info = rhs_ok
      associate (unused_equations => self, unused_step => h)
      end associate
   end subroutine nothing_to_yield

   !> What is held is so no more, from the next linearization on. By default nothing is.
   pure subroutine nothing_to_let_go(self)
      !> The equations.
      class(stage_equations_t), intent(inout) :: self

      associate (unused_equations => self)
      end associate
   end subroutine nothing_to_let_go

   !> Evaluates J = df/dy, or what stands for it in `factorize`. The default cannot.
   subroutine no_linearization(self, t, y, info)
      !> The system.
      class(ode_system_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      info = rhs_cannot
      associate (unused_system => self, unused_time => t, unused_state => y)
      end associate
   end subroutine no_linearization

   !> Gets ready to solve with shift*1 - J, J as it was linearized last. The default cannot.
   subroutine no_factorization(self, slot, shift, info)
      !> The system.
      class(ode_system_t), intent(inout) :: self
      !> Where the factors are kept: 1, 2, ...; one for each shift that is used at a time.
      integer, intent(in) :: slot
      !> An eigenvalue of the method's matrix over the step's length [1/s].
      complex(wp), intent(in) :: shift
      !> One of the `rhs_` constants; `rhs_retry` for a singular matrix.
      integer, intent(out) :: info

      info = rhs_cannot
      associate (unused_system => self, unused_slot => slot, unused_shift => shift)
      end associate
   end subroutine no_factorization

   !> Solves (shift*1 - J) d = r. The default leaves r as it is, and is not reached: nothing was factorized.
   subroutine no_solution(self, slot, r)
      !> The system.
      class(ode_system_t), intent(inout) :: self
      !> Which factors.
      integer, intent(in) :: slot
      !> r, replaced by d; without an imaginary part where the shift has none: (n).
      complex(wp), intent(inout), contiguous :: r(:)

      associate (unused_system => self, unused_slot => slot, unused_sides => r)
      end associate
   end subroutine no_solution

   !> Scales an estimate of the local error of an implicit method before its norm is taken: components that follow from others
   !! by a derivative (velocities) count with h, or a step that does not resolve a stiff motion would never hold. The default
   !! leaves it as it is.
   subroutine weigh_alike(self, h, error)
      !> The system.
      class(ode_system_t), intent(in) :: self
      !> The step's length [s].
      real(wp), intent(in) :: h
      !> Estimate of the local error: (n).
      real(wp), intent(inout), contiguous :: error(:)

      associate (unused_system => self, unused_step => h, unused_error => error)
      end associate
   end subroutine weigh_alike

   !> The system in implicit form. The default has none: who asks makes do with y' = f(t, y).
   subroutine no_stage_equations(self, equations)
      !> The system.
      class(ode_system_t), intent(inout) :: self
      !> Its equations, with their workspace; not allocated if it has none.
      class(stage_equations_t), allocatable, intent(out) :: equations

      associate (unused_system => self, unused_equations => equations)
      end associate
   end subroutine no_stage_equations

   !> Times at which the right-hand side has a kink or a jump. The default has none.
   function no_breakpoints(self) result(times)
      !> The system.
      class(ode_system_t), intent(in) :: self
      !> Times in any order [s].
      real(wp), allocatable :: times(:)

      allocate (times(0))
      associate (unused_system => self)
      end associate
   end function no_breakpoints

   !> What an entry of the last derivative is, for the words that it is not a number.
   subroutine numbered_entry(self, entry, text)
      !> The system, as the last call of `rhs` left it.
      class(ode_system_t), intent(in) :: self
      !> Which entry of ydot.
      integer, intent(in) :: entry
      !> What it is called.
      character(:), allocatable, intent(out) :: text

      text = 'the derivative of y('//to_text(entry)//')'
      associate (unused_system => self)
      end associate
   end subroutine numbered_entry

   !> Tells what a system has counted of its own work, or takes that count back: what an integrator does again behind a restart
   !! was counted before. The default counts nothing.
   subroutine nothing_counted(self, count, back)
      !> The system.
      class(ode_system_t), intent(inout) :: self
      !> The count.
      integer, intent(inout) :: count
      !> Whether it is taken back; otherwise it is told.
      logical, intent(in) :: back

      associate (unused_system => self, unused_count => count, unused_direction => back)
      end associate
   end subroutine nothing_counted

   !> What the last answer other than `rhs_ok` was about, in words.
   subroutine no_failure(self, text)
      !> The system.
      class(ode_system_t), intent(in) :: self
      !> One line, may be empty.
      character(:), allocatable, intent(out) :: text

      text = ''
      associate (unused_system => self)
      end associate
   end subroutine no_failure

   !> Steps do not get on: looks for a fault of the system itself at a state. The default cannot.
   subroutine cannot_look(self, t, y, looked, fault)
      !> The system.
      class(ode_system_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Whether it was looked for, so that none means that the system is right.
      logical, intent(out) :: looked
      !> What is wrong, in words; empty if nothing was found.
      character(:), allocatable, intent(out) :: fault

      looked = .false.
      fault = ''
      associate (unused_system => self, unused_time => t, unused_state => y)
      end associate
   end subroutine cannot_look

   !> Passes through an archive what the system remembers from one step to the next. The default remembers nothing.
   subroutine nothing_to_serialize(self, archive)
      !> The system.
      class(ode_system_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      associate (unused_system => self, unused_archive => archive)
      end associate
   end subroutine nothing_to_serialize

end module taut_ode_system
