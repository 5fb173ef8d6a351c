!> A constrained system for an integrator that is not taut's: a right-hand side and a projection, Sects 3.4 and 3.5 of the paper.
!!
!!     call problem%init(system, at, error)            ! the system, and a start that is brought to the constraints
!!     t = problem%t; y = problem%y                    ! y = {x; v; w}
!!     call problem%rhs(t, y, dydt, info)              ! (a) to (h): ydot = F(t, y), as often as the integrator likes
!!     call problem%project(t, y, info)                ! at the end of a step: y on the constraints
!!     call problem%filter_error(e)                    ! where the step is judged by an error e: what `project` will not take off
!!
!! F projects what it is given before it evaluates anything, so that F(P(y)) = F(y) with P what `project` does: derivatives that an
!! integrator keeps from one step to the next stay valid, and stages may lie off the constraints. A projection right behind an
!! evaluation at the same state costs nothing, for it has found P(y) already.
!!
!! Of an implicit code, which balances forces, `balance` gives what Eqs (19) put in the place of v and f.
!!
!! `info` is 0, or positive where there is nothing to be had at this state and a smaller step may help, which is what codes such as
!! SUNDIALS' ask for. A caller that does not ask for it is given what is not a number.
module taut_constrained_problem
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_quiet_nan, ieee_value
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise
   use taut_constrained_method, only: constrained_ode_t, sample_t
   use taut_constrained_method_choose, only: new_constrained_ode
   use taut_constrained_method_options, only: method_t
   use taut_constrained_start, only: consistent_start, start_report_t
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_ode_system, only: evaluated_step_end, rhs_not_finite, rhs_ok, step_end
   implicit none (type, external)
   private
   public :: constrained_problem_t

   !> A constrained system, ready to be integrated by anyone. It owns the workspace of its right-hand side: one object per thread.
   type :: constrained_problem_t
      !> Start: time [s], and state {x; v; w} on the constraints: (n).
      real(wp) :: t = 0.0_wp
      real(wp), allocatable :: y(:)
      !> How far the start was moved, the rank of A and the degrees of freedom.
      type(start_report_t) :: start
      !> Entries of y.
      integer :: n = 0
      !> Calls of `rhs` and of `balance`.
      integer :: evaluations = 0
      class(constrained_ode_t), allocatable, private :: ode
      !> Where the last evaluation was, if nothing has touched the workspace since.
      real(wp), allocatable, private :: evaluated_y(:)
      real(wp), private :: evaluated_t = 0.0_wp
      logical, private :: evaluated = .false.
      real(wp), allocatable, private :: dydt(:)
   contains
      procedure :: init
      procedure :: rhs
      procedure :: balance
      procedure :: project
      procedure :: filter_error
      procedure :: sample
      procedure :: pack
      procedure :: unpack
      procedure :: between
      procedure :: failure
   end type constrained_problem_t

contains

   !> Sets a system and a start together.
   subroutine init(self, model, at, error, method)
      !> The problem.
      class(constrained_problem_t), intent(out) :: self
      !> The system; copied.
      class(mechanical_system_t), intent(in) :: model
      !> Initial state, its time included; brought to the constraints.
      type(state_t), intent(inout) :: at
      !> Sizes or options that are not valid, or a start that no projection mends.
      type(error_t), allocatable, intent(inout) :: error
      !> Weight, solver, tolerance of the projection, form; default: the default of `method_t`.
      type(method_t), intent(in), optional :: method
      type(method_t) :: chosen
      logical :: whole

      if (present(method)) chosen = method
      whole = chosen%name == 'present' .and. chosen%stage_projection == 'newton' .and. &
              chosen%state_projection == 'position-velocity'
      if (.not. whole) then
         call raise(error, chosen%place(), 'it does not project each evaluation and the end of a step alike', &
                    'use "present" with its own projections here, or call what `new_constrained_ode` makes')
         return
      end if
      call new_constrained_ode(self%ode, model, chosen, error)
      if (.not. allocated(error)) call consistent_start(self%ode%model, chosen, at, self%start, error)
      if (allocated(error)) return
      call self%ode%projector%lay_yardstick(self%ode%model, at)
      self%n = self%ode%size()
      allocate (self%y(self%n), self%evaluated_y(self%n), self%dydt(self%n), source=0.0_wp)
      self%t = at%t
      call self%ode%pack(at, self%y)
   end subroutine init

   !> ydot = F(t, y): steps (a) to (h) of Sect. 3.5.
   subroutine rhs(self, t, y, dydt, info)
      !> The problem.
      class(constrained_problem_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State {x; v; w}, on the constraints or near them: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Its derivative: (n).
      real(wp), intent(out), contiguous :: dydt(:)
      !> 0, or positive: not here, try a smaller step. Without it such a derivative is not a number.
      integer, intent(out), optional :: info
      integer :: answer

      self%evaluations = self%evaluations + 1
      call self%ode%rhs(t, y, dydt, answer)
      if (answer == rhs_ok) then
         if (.not. all(ieee_is_finite(dydt))) answer = rhs_not_finite
      end if
      self%evaluated = answer == rhs_ok
      self%evaluated_t = t
      self%evaluated_y(:) = y
      call tell(answer, dydt, info)
   end subroutine rhs

   !> What the original system of an implicit code is to be solved with, Eqs (19): xdot with the corrected velocity, M vdot = f
   !! with the corrected force, and wdot.
   subroutine balance(self, t, y, xdot, force, wdot, info)
      !> The problem.
      class(constrained_problem_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State {x; v; w}, on the constraints or near them: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> H v with v of Eq. (19a): (n_x).
      real(wp), intent(out), contiguous :: xdot(:)
      !> f - A^T lambda of Eq. (19b), what M vdot is to be equal to: (velocities).
      real(wp), intent(out), contiguous :: force(:)
      !> Rate of states that are not mechanics: (n_w).
      real(wp), intent(out), contiguous, optional :: wdot(:)
      !> 0, or positive: not here, try a smaller step. Without it what is answered is not a number.
      integer, intent(out), optional :: info
      integer :: n_x
      integer :: answer

      call self%rhs(t, y, self%dydt, answer)
      associate (ode => self%ode)
         n_x = ode%model%n_x
         xdot(:) = self%dydt(:n_x)
         if (present(wdot)) wdot(:) = self%dydt(n_x + ode%model%n + 1:)
         force(:) = ode%force
         if (ode%options%form /= 'force') call ode%projector%linear%a%subtract_transposed(ode%lambda, force)
      end associate
      call tell(answer, force, info)
   end subroutine balance

   !> Replaces a state by the one on the constraints: x by Eq. (17), v by Eq. (11a).
   subroutine project(self, t, y, info)
      !> The problem.
      class(constrained_problem_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State {x; v; w}, at the end of a step: (n).
      real(wp), intent(inout), contiguous :: y(:)
      !> 0, or positive: the state is left as it is, try a smaller step. Without it such a state is not a number.
      integer, intent(out), optional :: info
      logical :: here, replaced, stale
      integer :: answer, i

      here = self%evaluated .and. .not. abs(t - self%evaluated_t) > 0.0_wp
      do i = 1, self%n
         if (.not. here) exit
         here = .not. abs(y(i) - self%evaluated_y(i)) > 0.0_wp
      end do
      self%evaluated = .false.
      call self%ode%project(t, y, merge(evaluated_step_end, step_end, here), stale, answer)
      ! The rank is looked at where steps end.
      if (answer == rhs_ok) call self%ode%accepted(t, y, replaced)
      call tell(answer, y, info)
   end subroutine project

   !> An answer, to a caller who asks for it or not.
   subroutine tell(answer, values, info)
      integer, intent(in) :: answer
      real(wp), intent(inout), contiguous :: values(:)
      integer, intent(out), optional :: info

      if (present(info)) then
         info = answer
      else if (answer /= rhs_ok) then
         values(:) = ieee_value(1.0_wp, ieee_quiet_nan)
      end if
   end subroutine tell

   !> Takes off an estimate of the local error what `project` will take off the state: what is normal to the constraints at the
   !! last evaluation or projection.
   subroutine filter_error(self, error)
      !> The problem.
      class(constrained_problem_t), intent(inout) :: self
      !> Estimate of the local error of {x; v; w}: (n).
      real(wp), intent(inout), contiguous :: error(:)

      call self%ode%filter_error(error)
   end subroutine filter_error

   !> Multipliers, violations at three levels, energy and rank at a state.
   subroutine sample(self, t, y, s, info)
      !> The problem.
      class(constrained_problem_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State {x; v; w}: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> What there is to know.
      type(sample_t), intent(inout) :: s
      !> 0, or positive: nothing is to be had here.
      integer, intent(out) :: info

      self%evaluated = .false.
      call self%ode%sample(t, y, s, info)
   end subroutine sample

   !> y = {x; v; w}.
   pure subroutine pack(self, at, y)
      !> The problem.
      class(constrained_problem_t), intent(in) :: self
      !> The state.
      type(state_t), intent(in) :: at
      !> All of it: (n).
      real(wp), intent(out), contiguous :: y(:)

      call self%ode%pack(at, y)
   end subroutine pack

   !> {x; v; w} = y.
   pure subroutine unpack(self, t, y, at)
      !> The problem.
      class(constrained_problem_t), intent(in) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> All of the state: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> The state.
      type(state_t), intent(inout) :: at

      associate (model => self%ode%model)
         if (.not. allocated(at%x)) allocate (at%x(model%n_x))
         if (.not. allocated(at%v)) allocate (at%v(model%n))
         if (.not. allocated(at%w)) allocate (at%w(model%n_w))
      end associate
      call self%ode%unpack(t, y, at)
   end subroutine unpack

   !> Keeps what is evaluated between two times at which loads or drives jump: at either, the limit from inside is taken.
   subroutine between(self, t_low, t_high)
      !> The problem.
      class(constrained_problem_t), intent(inout) :: self
      !> Where this stretch begins [s].
      real(wp), intent(in) :: t_low
      !> Where it ends [s].
      real(wp), intent(in) :: t_high

      self%ode%t_low = t_low
      self%ode%t_high = t_high
      self%evaluated = .false.
   end subroutine between

   !> Why the last evaluation or projection had nothing to give.
   subroutine failure(self, text)
      !> The problem.
      class(constrained_problem_t), intent(in) :: self
      !> One line, may be empty.
      character(:), allocatable, intent(out) :: text

      call self%ode%failure(text)
   end subroutine failure

end module taut_constrained_problem
