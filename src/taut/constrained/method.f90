!> What a method is: a way to make of a constrained mechanical system one of ordinary differential equations.
!!
!! A method is an extension of `constrained_ode_t` in a file of its own, `method/`, and a line in `method/choose.f90`; its name
!! and its options are in `method_options.f90`. It owns
!!
!! - its right-hand side, `rhs`, and what it needs for that, `set_up`; `check_options` refuses options that make no sense;
!! - its correction at the end of a step, `project`, with what that will take off a local error, `filter_error`. By default
!!   coordinates are normalized and nothing else;
!! - the layout of its state, `size`, `pack` and `unpack`, with `accelerations` to read a derivative, and what of it is left out
!!   where errors are measured, `unmeasured`. By default y = {x; v; w};
!! - what velocities do where a drive begins to move at once, `cross`. By default there is a blow;
!! - what happens when a step is accepted, `accepted`: it may go on in other coordinates, and say so, `own_remark`. By default
!! nothing;
!! - what it remembers from one step to the next, `serialize_own`;
!! - the multipliers of its last evaluation, `multipliers`, and where it finds them with it those of velocities,
!!   `velocity_multipliers`;
!! - which steppers can carry it: explicit ones, if it has a right-hand side; implicit ones, if it answers `linearize`,
!!   `factorize` and `solve`. What it does not offer it answers with `rhs_cannot`.
!!
!! Everything else that is known of a state, `sample` finds for all methods alike.
!!
!! Equation numbers are those of P. Masarati, Adding kinematic constraints to purely differential dynamics, Comput. Mech. 47
!! (2011) 187-203. Eq. (8) is implemented with the sign of Eq. (11b): the printed bracket has the opposite one.
module taut_constrained_method
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_constrained_blow, only: blows_t
   use taut_constrained_mass, only: mass_t
   use taut_constrained_method_options, only: method_t
   use taut_constrained_projection, only: projector_t
   use taut_constrained_reactions, only: power_of_reactions, reactions_t
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_ode_system, only: inside_step, ode_system_t, rhs_ok
   implicit none (type, external)
   private
   public :: constrained_ode_t, sample_t

   !> Rows of full matrices, beyond which nobody waits for them.
   integer, parameter :: most_rows = 2000

   !> What there is to know about a state.
   type :: sample_t
      !> Violation of the constraints at position, velocity and acceleration level, largest entries.
      real(wp) :: phi = 0.0_wp, phidot = 0.0_wp, phiddot = 0.0_wp
      !> The same at the end of the last step before the state was replaced.
      real(wp) :: phi_raw = 0.0_wp, phidot_raw = 0.0_wp
      !> Energy [J], or not a number.
      real(wp) :: energy = 0.0_wp
      !> Kinetic energy, v^T M v/2 [J].
      real(wp) :: kinetic = 0.0_wp
      !> Work since the start [J] of what changes the energy: loads, dampers, drives, blows; or not a number.
      real(wp) :: work = 0.0_wp
      !> Multipliers of Eqs (14): mu at the end of the last step before the state was replaced, lambda at the state: (c).
      real(wp), allocatable :: mu(:), lambda(:)
      !> The smallest pivot, relative to its diagonal entry, of the matrix that gives lambda: near 0 at a singular position.
      real(wp) :: weakest = 1.0_wp
      !> Rank of A.
      integer :: rank = 0
      !> What the system computes besides: (n_outputs).
      real(wp), allocatable :: outputs(:)
   end type sample_t

   !> What was found at the end of the last step before its state was replaced.
   type :: step_end_t
      !> Violations of positions and velocities, largest entries.
      real(wp) :: phi = 0.0_wp, phidot = 0.0_wp
      !> Multipliers of Eq. (14a): (c).
      real(wp), allocatable :: mu(:)
   end type step_end_t

   !> A constrained mechanical system with a method.
   type, abstract, extends(ode_system_t) :: constrained_ode_t
      !> The system; a copy of what `init` was given.
      class(mechanical_system_t), allocatable :: model
      !> The options of the method.
      type(method_t) :: options
      !> Projection in the metric W, and its iteration count.
      type(projector_t) :: projector
      !> M, and the reduced mass matrix.
      type(mass_t) :: mass
      !> Forces that depend on multipliers.
      type(reactions_t) :: reactions
      !> Where the last evaluation was.
      type(state_t) :: at
      !> Multipliers of Eq. (14b) of the last evaluation: (c).
      real(wp), allocatable :: lambda(:)
      !> Forces, and b'', of the last evaluation: (n), (c).
      real(wp), allocatable :: force(:), b_second(:)
      !> phi and phidot = A v - b' of the last `find_violations`: (n_phi), (c).
      real(wp), allocatable :: phi(:), phidot(:)
      !> Whether positions are replaced at the end of a step, and what was found there.
      logical :: replaces = .false.
      type(step_end_t) :: step_end
      !> Whether `rhs` projects velocities, so that mu is that of the evaluation.
      logical :: finds_mu = .false.
      !> Whether the last evaluation was at `at`, as `at` is now; of methods that keep account of it.
      logical :: evaluated = .false.
      !> Whether forces may depend on its multipliers.
      logical :: carries_reactions = .true.
      !> Blows at breakpoints.
      type(blows_t) :: blows
      !> Kinetic energy of velocities that are all 1, masses alone, where `sample` was [J].
      real(wp) :: kinetic_of_unit = 0.0_wp
      real(wp), allocatable, private :: dydt(:), vdot(:)
      !> M where `sample` was.
      type(block_diagonal_t), private :: m
   contains
      procedure, non_overridable :: init
      procedure :: check_options => any_options
      procedure :: set_up => nothing_to_set_up
      procedure :: size => state_size
      procedure :: pack
      procedure :: unpack
      procedure :: accelerations
      procedure :: unmeasured
      procedure :: multipliers
      procedure :: velocity_multipliers
      procedure :: project => normalize
      procedure :: cross => strike
      procedure :: weigh_error
      procedure :: later_corrections
      procedure :: breakpoints
      procedure :: failure
      procedure :: find_fault
      procedure :: remark
      procedure :: own_remark => nothing_to_say
      procedure :: own_failure => nothing_to_say
      procedure :: entry_name
      procedure :: recount
      procedure :: sample
      procedure :: sample_reactions
      procedure :: serialize
      procedure :: serialize_own => nothing_to_serialize
      procedure :: begin
      procedure, non_overridable :: find_power
      procedure, non_overridable :: is_at
      procedure, non_overridable :: find_violations
      procedure, non_overridable :: remember
      procedure, non_overridable :: refuse_large
   end type constrained_ode_t

   interface

      !> Why the last evaluation or projection failed.
      recursive module subroutine failure(self, text)
         !> The formulation.
         class(constrained_ode_t), intent(in) :: self
         !> One line.
         character(:), allocatable, intent(out) :: text
      end subroutine failure

      !> Compares derivatives with differences at a state where steps do not get on.
      module subroutine find_fault(self, t, y, looked, fault)
         !> The formulation.
         class(constrained_ode_t), intent(inout) :: self
         !> Time [s].
         real(wp), intent(in) :: t
         !> State: (size).
         real(wp), intent(in), contiguous :: y(:)
         !> Whether there are constraints to look at.
         logical, intent(out) :: looked
         !> What is wrong, in words; empty if nothing was found.
         character(:), allocatable, intent(out) :: fault
      end subroutine find_fault

      !> What is to be said of the motion so far that is no error: drives that begin or stop at once strike blows.
      recursive module subroutine remark(self, text)
         !> The formulation.
         class(constrained_ode_t), intent(in) :: self
         !> One line without commas; empty if there is nothing.
         character(:), allocatable, intent(out) :: text
      end subroutine remark

      !> What an entry of the last derivative is: of an acceleration, the force if that is not a number already.
      module subroutine entry_name(self, entry, text)
         !> The formulation, as the last `rhs` left it.
         class(constrained_ode_t), intent(in) :: self
         !> Which entry of ydot.
         integer, intent(in) :: entry
         !> What it is called.
         character(:), allocatable, intent(out) :: text
      end subroutine entry_name

      !> Violations, multipliers, energy, rank and what the system computes besides at a state, evaluated afresh.
      module subroutine sample(self, t, y, s, info)
         !> The formulation.
         class(constrained_ode_t), intent(inout) :: self
         !> Time [s].
         real(wp), intent(in) :: t
         !> State: (size).
         real(wp), intent(in), contiguous :: y(:)
         !> What there is to know; its arrays are allocated if they are not.
         type(sample_t), intent(inout) :: s
         !> One of the `rhs_` constants.
         integer, intent(out) :: info
      end subroutine sample

      !> The multipliers lambda at a state, at no further cost where the last evaluation was, and what the system computes besides.
      module subroutine sample_reactions(self, t, y, outputs, s, info)
         !> The formulation.
         class(constrained_ode_t), intent(inout) :: self
         !> Time [s].
         real(wp), intent(in) :: t
         !> State: (size).
         real(wp), intent(in), contiguous :: y(:)
         !> Whether what the system computes besides is wanted.
         logical, intent(in) :: outputs
         !> `lambda` is set, and `outputs`; its arrays are allocated if they are not.
         type(sample_t), intent(inout) :: s
         !> One of the `rhs_` constants.
         integer, intent(out) :: info
      end subroutine sample_reactions

   end interface

contains

   !> Sets a system and a method together; nothing is allocated afterwards. A method that holds another one sets it up with it.
   recursive subroutine init(self, model, method, error)
      !> The formulation, new.
      class(constrained_ode_t), intent(inout) :: self
      !> The system, its sizes checked; copied.
      class(mechanical_system_t), intent(in) :: model
      !> The method's options, checked.
      type(method_t), intent(in) :: method
      !> What does not fit.
      type(error_t), allocatable, intent(inout) :: error

      allocate (self%model, source=model)
      call self%model%enforce(.true.)
      self%options = method
      allocate (self%at%x(model%n_x), self%at%v(model%n), self%at%w(model%n_w), source=0.0_wp)
      allocate (self%lambda(model%c), self%b_second(model%c), self%force(model%n), self%phi(model%n_phi), self%phidot(model%c), &
                self%vdot(model%n), self%step_end%mu(model%c), source=0.0_wp)
      call self%projector%init(self%model, method)
      call self%mass%init(self%model)
      call self%m%init(self%model%mass_blocks)
      call self%reactions%init(self%model)
      self%coordinates = model%n_x
      self%velocities = model%n
      call self%set_up(error)
      if (self%model%reactive .and. .not. self%carries_reactions .and. .not. allocated(error)) &
         call raise(error, method%place(), 'it has no multipliers for forces that depend on them', 'use "present"')
      allocate (self%dydt(self%size()), source=0.0_wp)
   end subroutine init

   !> Whether the options that are a method's own make sense; the default has none.
   subroutine any_options(self, options, error)
      !> The formulation, not yet set up.
      class(constrained_ode_t), intent(in) :: self
      !> The options.
      type(method_t), intent(in) :: options
      !> What does not make sense.
      type(error_t), allocatable, intent(inout) :: error

      associate (unused_formulation => self, unused_options => options, unused_error => error)
      end associate
   end subroutine any_options

   !> What a method needs besides; the default needs nothing.
   subroutine nothing_to_set_up(self, error)
      !> The formulation, everything else of it ready.
      class(constrained_ode_t), intent(inout) :: self
      !> What does not fit.
      type(error_t), allocatable, intent(inout) :: error

      associate (unused_formulation => self, unused_error => error)
      end associate
   end subroutine nothing_to_set_up

   !> Refuses a system that is too large for a method whose matrices are full.
   subroutine refuse_large(self, error)
      !> The formulation.
      class(constrained_ode_t), intent(in) :: self
      !> The system is too large.
      type(error_t), allocatable, intent(inout) :: error

      if (max(self%model%n, self%model%c) > most_rows) &
         call raise(error, self%options%place(), 'its matrices are full, and '//to_text(self%model%n)//' velocities with '// &
                    to_text(self%model%c)//' constraints are more than '//to_text(most_rows), &
                    'use "present" or "baseline", whose matrices are sparse')
   end subroutine refuse_large

   !> Number of entries of y.
   pure function state_size(self) result(n)
      !> The formulation.
      class(constrained_ode_t), intent(in) :: self
      !> n_x + n + n_w.
      integer :: n

      n = self%model%n_x + self%model%n + self%model%n_w
   end function state_size

   !> y = {x; v; w}.
   pure subroutine pack(self, at, y)
      !> The formulation.
      class(constrained_ode_t), intent(in) :: self
      !> The state.
      type(state_t), intent(in) :: at
      !> All of it: (size).
      real(wp), intent(out), contiguous :: y(:)
      integer :: i

      do i = 1, self%model%n_x
         y(i) = at%x(i)
      end do
      do i = 1, self%model%n
         y(self%model%n_x + i) = at%v(i)
      end do
      do i = 1, self%model%n_w
         y(self%model%n_x + self%model%n + i) = at%w(i)
      end do
   end subroutine pack

   !> {x; v; w} = y.
   pure subroutine unpack(self, t, y, at)
      !> The formulation.
      class(constrained_ode_t), intent(in) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> All of the state: (size).
      real(wp), intent(in), contiguous :: y(:)
      !> The state, its parts allocated.
      type(state_t), intent(inout) :: at
      integer :: i

      at%t = min(max(t, self%t_low), self%t_high)
      do i = 1, self%model%n_x
         at%x(i) = y(i)
      end do
      do i = 1, self%model%n
         at%v(i) = y(self%model%n_x + i)
      end do
      do i = 1, self%model%n_w
         at%w(i) = y(self%model%n_x + self%model%n + i)
      end do
   end subroutine unpack

   !> Whether {x; v; w} at a time are those of `at`.
   pure logical function is_at(self, t, y)
      !> The formulation.
      class(constrained_ode_t), intent(in) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State {x; v; w}: (size).
      real(wp), intent(in), contiguous :: y(:)
      integer :: i, n, n_x

      n = self%model%n
      n_x = self%model%n_x
      is_at = .false.
      if (abs(min(max(t, self%t_low), self%t_high) - self%at%t) > 0.0_wp) return
      do i = 1, n_x
         if (abs(y(i) - self%at%x(i)) > 0.0_wp) return
      end do
      do i = 1, n
         if (abs(y(n_x + i) - self%at%v(i)) > 0.0_wp) return
      end do
      do i = 1, self%model%n_w
         if (abs(y(n_x + n + i) - self%at%w(i)) > 0.0_wp) return
      end do
      is_at = .true.
   end function is_at

   !> vdot of a derivative that `rhs` has just found.
   subroutine accelerations(self, dydt, vdot)
      !> The formulation.
      class(constrained_ode_t), intent(inout) :: self
      !> The derivative: (size).
      real(wp), intent(in), contiguous :: dydt(:)
      !> Accelerations: (n).
      real(wp), intent(out), contiguous :: vdot(:)

      vdot(:) = dydt(self%model%n_x + 1:self%model%n_x + self%model%n)
   end subroutine accelerations

   !> What of y has no part in the measure of errors: coordinates that count turns, and what is added to {x; v; w}.
   subroutine unmeasured(self, out)
      !> The formulation.
      class(constrained_ode_t), intent(in) :: self
      !> Which entries: (size).
      logical, intent(out) :: out(:)

      out(:) = .false.
      associate (model => self%model)
         out(model%n_x - model%n_counters + 1:model%n_x) = .true.
         out(model%n_x + model%n + model%n_w + 1:) = .true.
      end associate
   end subroutine unmeasured

   !> The multipliers lambda of the last evaluation, of least norm where they are not unique.
   subroutine multipliers(self, lambda)
      !> The formulation, as `rhs` left it.
      class(constrained_ode_t), intent(inout) :: self
      !> Those of Eq. (14b): (c).
      real(wp), intent(inout), contiguous :: lambda(:)

      lambda(:) = self%lambda
   end subroutine multipliers

   !> The multipliers mu of the last evaluation, where that `finds_mu`, of least norm where they are not unique.
   subroutine velocity_multipliers(self, mu)
      !> The formulation, as `rhs` left it.
      class(constrained_ode_t), intent(inout) :: self
      !> Those of Eq. (14a): (c).
      real(wp), intent(inout), contiguous :: mu(:)

      mu(:) = self%projector%mu
      call self%projector%linear%onto%minimum_norm(mu)
   end subroutine velocity_multipliers

   !> Brings coordinates that are redundant by themselves back to their manifold: every right-hand side does so first, so
   !! that its value stays.
   subroutine normalize(self, t, y, place, stale, info)
      !> The formulation.
      class(constrained_ode_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State {x; v; w}, replaced: (size).
      real(wp), intent(inout), contiguous :: y(:)
      !> `inside_step`, `step_end` or `evaluated_step_end`.
      integer, intent(in) :: place
      !> False: the derivative stays.
      logical, intent(out) :: stale
      !> `rhs_ok`.
      integer, intent(out) :: info

      stale = .false.
      info = rhs_ok
      call self%model%normalize(y(1:self%model%n_x))
      associate (unused_time => t, unused_place => place)
      end associate
   end subroutine normalize

   !> A drive that begins to move at once, or stops: velocities change by what b' changes, by a blow.
   subroutine strike(self, t, before, y, info)
      !> The formulation.
      class(constrained_ode_t), intent(inout) :: self
      !> Time of the breakpoint [s].
      real(wp), intent(in) :: t
      !> The last time before it [s].
      real(wp), intent(in) :: before
      !> State, replaced: (size).
      real(wp), intent(inout), contiguous :: y(:)
      !> One of the `rhs_` constants.
      integer, intent(out) :: info
      logical :: stale, struck

      info = rhs_ok
      if (self%model%c > 0 .and. self%model%enforced) then
         call self%unpack(t, y, self%at)
         call self%blows%strike_at_jump(self%model, self%options, before, self%at, struck, info)
         if (info /= rhs_ok) return
         if (struck) call self%pack(self%at, y)
      end if
      call self%project(t, y, inside_step, stale, info)
   end subroutine strike

   !> Gets ready for a motion: finds out how large the system is, and whether its energy is balanced, as it is if the system states
   !! it and the power of what changes it.
   subroutine begin(self, at)
      !> The formulation.
      class(constrained_ode_t), intent(inout) :: self
      !> Initial state.
      type(state_t), intent(in) :: at

      call self%projector%lay_yardstick(self%model, at)
      call self%blows%forget()
      self%has_integral = ieee_is_finite(self%model%energy(at)) .and. ieee_is_finite(self%model%power(at))
      if (.not. self%has_integral) return
      call self%model%mass(at, self%m)
      call self%m%multiply(at%v, self%vdot)
      self%integral_scale = 0.5_wp*dot_product(at%v, self%vdot)
      self%integral_unit = 0.5_wp*self%m%trace()
   end subroutine begin

   !> Power of what changes the energy, at the state of an evaluation: that of the system's own, of forces that depend on reactions,
   !! and of its drives, -lambda^T b'. Where constraints leave no freedom, a motion has no error by which to judge a step: its work
   !! has.
   subroutine find_power(self, b_prime)
      !> The formulation, with lambda in place.
      class(constrained_ode_t), intent(inout) :: self
      !> b': (c).
      real(wp), intent(in), contiguous :: b_prime(:)

      self%integrand = self%model%power(self%at) - dot_product(self%lambda, b_prime)
      if (self%model%reactive) self%integrand = self%integrand + power_of_reactions(self%model, self%at, self%lambda)
      self%integral_counts = self%projector%linear%onto%rank >= self%model%n
   end subroutine find_power

   !> phi and phidot at the state as it is, with A in place.
   subroutine find_violations(self)
      !> The formulation.
      class(constrained_ode_t), intent(inout) :: self

      call self%projector%violations(self%model, self%at, self%phi, self%phidot)
   end subroutine find_violations

   !> Keeps what the projector has found at the end of a step.
   pure subroutine remember(self)
      !> The formulation.
      class(constrained_ode_t), intent(inout) :: self

      self%step_end%phi = self%projector%newton%phi_raw
      self%step_end%phidot = self%projector%phidot_raw()
      self%step_end%mu(:) = self%projector%mu
   end subroutine remember

   !> Errors of velocities count with the step's length: what a stiff motion that is not resolved makes of them is no error of
   !! the motion that is.
   subroutine weigh_error(self, h, error)
      !> The formulation.
      class(constrained_ode_t), intent(in) :: self
      !> The step's length [s].
      real(wp), intent(in) :: h
      !> Estimate of the local error: (size).
      real(wp), intent(inout), contiguous :: error(:)
      integer :: i

      do i = self%model%n_x + 1, self%model%n_x + self%model%n
         error(i) = abs(h)*error(i)
      end do
   end subroutine weigh_error

   !> The breakpoints of the system.
   function breakpoints(self) result(times)
      !> The formulation.
      class(constrained_ode_t), intent(in) :: self
      !> Times in any order [s].
      real(wp), allocatable :: times(:)

      times = self%model%breakpoints()
   end function breakpoints

   !> Tells the iterations of the projection, or takes their count back.
   subroutine recount(self, count, back)
      !> The formulation.
      class(constrained_ode_t), intent(inout) :: self
      !> Iterations of Eq. (17).
      integer, intent(inout) :: count
      !> Whether it is taken back; otherwise it is told.
      logical, intent(in) :: back

      if (back) then
         self%projector%newton%iterations = count
      else
         count = self%projector%newton%iterations
      end if
   end subroutine recount

   !> What only the method knows of a failure, or of a run: the default has nothing to say.
   subroutine nothing_to_say(self, text)
      !> The formulation.
      class(constrained_ode_t), intent(in) :: self
      !> One line without commas, may be empty.
      character(:), allocatable, intent(out) :: text

      text = ''
      associate (unused_formulation => self)
      end associate
   end subroutine nothing_to_say

   !> By how much the last projection of positions has moved them after its first correction.
   subroutine later_corrections(self, d, bends)
      !> The formulation.
      class(constrained_ode_t), intent(in) :: self
      !> Displacement, if there is any: (n_x).
      real(wp), intent(inout), contiguous :: d(:)
      !> Whether there is.
      logical, intent(out) :: bends

      call self%projector%newton%later_corrections(self%at, d, bends)
   end subroutine later_corrections

   !> Passes through an archive what is remembered from one step to the next; everything else follows from t and y.
   recursive subroutine serialize(self, archive)
      !> The formulation.
      class(constrained_ode_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      call archive%item('phi before projection', self%step_end%phi)
      call archive%item('phidot before projection', self%step_end%phidot)
      call archive%item('mu before projection', self%step_end%mu)
      call archive%item('projection iterations', self%projector%newton%iterations)
      call archive%item('balances energy', self%has_integral)
      call archive%item('energy at the start', self%integral_scale)
      call archive%item('energy of velocities of 1', self%integral_unit)
      call self%blows%serialize(archive)
      call self%projector%serialize(archive)
      call self%mass%serialize(archive)
      call self%serialize_own(archive)
   end subroutine serialize

   !> The same of what only the method knows of; the default has nothing.
   subroutine nothing_to_serialize(self, archive)
      !> The formulation.
      class(constrained_ode_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      associate (unused_formulation => self, unused_archive => archive)
      end associate
   end subroutine nothing_to_serialize

end module taut_constrained_method
