!> Static equilibrium of any constrained system: f(x, 0, t) - A^T lambda = 0 and phi = 0, by Newton's iteration.
!!
!! Each iteration solves the linearized problem in the null space of A, so that redundant constraints need no care: their
!! multipliers are those of minimum norm, as everywhere in taut. Motions that nothing resists and nothing loads, such as that of a
!! trolley on its rail, are left where they are.
!!
!! The equilibrium that is found belongs to the start: what is out of balance there is taken away step by step, and no step goes
!! far.
module taut_constrained_equilibrium
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_constrained_rest, only: rest_failed, rest_loaded, rest_not_finite, rest_ok, rest_solver_t
   use taut_constrained_rest_choose, only: choose_rest_solver
   use taut_constrained_system_tables, only: velocity_name
   use taut_constrained_tangent, only: free_velocities, ready
   implicit none (type, external)
   private
   public :: equilibrium, equilibrium_options_t, equilibrium_result_t

   !> Options of the iteration.
   type :: equilibrium_options_t
      !> Load steps; a step that does not converge is halved.
      integer :: steps = 1
      !> What is changed in steps. `factor`: what is out of balance at the start is taken away in equal parts, which for
      !! loads that keep their directions, on a system without internal forces at the start, is a load factor. `time`: the time
      !! goes from that of the state to `t_end`.
      character(len=8) :: parameter = 'factor'
      !> Where `time` ends [s].
      real(wp) :: t_end = 0.0_wp
      !> Converged when no displacement of an iteration and no entry of phi exceeds this, relative to the largest
      !! coordinate (at least 1), or when nothing but round-off is left of the forces.
      real(wp) :: tolerance = 1.0e-10_wp
      !> Iterations of a step.
      integer :: max_iterations = 25
      !> How often a step may be halved.
      integer :: max_halvings = 12
      !> How far a step may go along each velocity: (n) [m, rad]; what goes farther is halved. Default: the largest coordinate where
      !! the step begins, at least 1.
      real(wp), allocatable :: reach(:)
      !> Velocities along which nothing moves and whose equations are left out; none by default.
      integer, allocatable :: blocked(:)
      !> Relative step of the differences; 0 for the default.
      real(wp) :: difference = 0.0_wp
   end type equilibrium_options_t

   !> How it went.
   type :: equilibrium_result_t
      !> Multipliers: (c).
      real(wp), allocatable :: lambda(:)
      !> Load steps and iterations, those of halved steps included.
      integer :: steps = 0, iterations = 0
      !> Rank of the constraints at the end, and motions that nothing resists.
      integer :: rank = 0, free_motions = 0
      !> Largest entry of f - A^T lambda and of phi that is left.
      real(wp) :: force_left = 0.0_wp, phi_left = 0.0_wp
      !> The velocity with the largest part in a motion that is loaded, though nothing resists it.
      integer, private :: loaded = 0
   end type equilibrium_result_t

   !> Why a step failed.
   integer, parameter :: converged = 0, not_converged = 1, not_finite = 2, inconsistent = 3, mechanism = 4, failed = 5, far = 6, &
                         stuck = 7
   character(*), parameter :: here = 'equilibrium'
   !> Forces of this size in parts of what they are the sum of are round-off.
   real(wp), parameter :: round_off = 100.0_wp*epsilon(1.0_wp)

contains

   !> Finds the equilibrium nearest to a state.
   subroutine equilibrium(model, at, result, error, options)
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Where to start; x, and t with `time`, are replaced, v is set to zero, w is kept.
      type(state_t), intent(inout) :: at
      !> How it went.
      type(equilibrium_result_t), intent(out) :: result
      !> Why there is none.
      type(error_t), allocatable, intent(inout) :: error
      !> Options.
      type(equilibrium_options_t), intent(in), optional :: options
      type(equilibrium_options_t) :: chosen
      type(state_t) :: last
      class(rest_solver_t), allocatable :: solver
      integer, allocatable :: free(:)
      real(wp) :: f_start(model%n), phi_start(model%n_phi), part, reached, t_start
      integer :: halvings, outcome

      if (present(options)) chosen = options
      call check_options(chosen, error)
      call ready(model, at, here, error)
      if (.not. allocated(error)) call free_velocities(model%n, chosen%blocked, free, error)
      if (allocated(error)) return
      allocate (result%lambda(model%c), source=0.0_wp)
      call model%normalize(at%x)
      t_start = at%t
      call choose_rest_solver(model, free, solver)
      call start_of_path()
      if (allocated(error)) return

      reached = 0.0_wp
      part = 1.0_wp/real(chosen%steps, wp)
      halvings = 0
      do while (reached < 1.0_wp)
         last = at
         call converge(model, chosen, solver, min(1.0_wp, reached + part), t_start, f_start, phi_start, at, result, outcome)
         if (outcome == converged) then
            result%steps = result%steps + 1
            reached = min(1.0_wp, reached + part)
            if (1.0_wp - reached < 1.0e-9_wp) reached = 1.0_wp
            if (halvings > 0) then
               halvings = halvings - 1
               part = 2.0_wp*part
            end if
         else
            at = last
            halvings = halvings + 1
            part = 0.5_wp*part
            if (halvings > chosen%max_halvings .or. any(outcome == [inconsistent, stuck])) then
               call explain(model, outcome, reached, result, error)
               return
            end if
         end if
      end do

   contains

      !> What is out of balance at the start, for `factor`.
      subroutine start_of_path()
         real(wp) :: left(model%n)
         integer :: info

         f_start = 0.0_wp
         phi_start = 0.0_wp
         if (chosen%parameter == 'time') return
         call model%force(at, f_start)
         call model%constraint(at, phi_start)
         call solver%look(model, at, info)
         if (.not. (all(ieee_is_finite(f_start)) .and. all(ieee_is_finite(phi_start))) .or. info == rest_not_finite) then
            call explain(model, not_finite, 0.0_wp, result, error)
            return
         end if
         if (info /= rest_ok) return
         call solver%reactions(f_start, result%lambda, left)
         f_start = left
      end subroutine start_of_path

   end subroutine equilibrium

   !> Newton's iteration at one value of the parameter.
   subroutine converge(model, options, solver, parameter, t_start, f_start, phi_start, at, result, outcome)
      class(mechanical_system_t), intent(in) :: model
      type(equilibrium_options_t), intent(in) :: options
      class(rest_solver_t), intent(inout) :: solver
      real(wp), intent(in) :: parameter, t_start, f_start(:), phi_start(:)
      type(state_t), intent(inout) :: at
      type(equilibrium_result_t), intent(inout) :: result
      integer, intent(out) :: outcome
      real(wp) :: d(model%n), f(model%n), left(model%n), moved(model%n), uncertain(model%n)
      real(wp), dimension(model%c) :: carried, more, phi, phi_left
      real(wp) :: allowed, extent
      integer :: info, iteration
      logical :: balanced

      outcome = failed
      if (options%parameter == 'time') at%t = t_start + parameter*(options%t_end - t_start)
      d = 0.0_wp
      moved = 0.0_wp
      call solver%tangent%forget()
      extent = max(1.0_wp, maxval(abs(at%x)))
      do iteration = 0, options%max_iterations
         call model%force(at, f)
         call solver%look(model, at, info)
         ! Rows without a position level ask for nothing at rest.
         phi = 0.0_wp
         call model%constraint(at, phi(1:model%n_phi))
         f = f - (1.0_wp - parameter)*f_start
         phi(1:model%n_phi) = phi(1:model%n_phi) - (1.0_wp - parameter)*phi_start
         if (.not. (all(ieee_is_finite(f)) .and. all(ieee_is_finite(phi))) .or. info == rest_not_finite) then
            outcome = not_finite
            return
         end if
         if (info /= rest_ok) return
         result%rank = solver%rank
         call solver%reactions(f, result%lambda, left)
         ! Where a sum cancels, round-off; and of what was taken away at the start, directions turn.
         call solver%sizes_of_reactions(result%lambda, uncertain)
         uncertain = round_off*(abs(f) + uncertain)
         balanced = solver%balanced(left, uncertain)
         uncertain = uncertain + (1.0_wp - parameter)*abs(f_start)
         result%force_left = maxval(abs(left(solver%free)))
         result%phi_left = 0.0_wp
         if (model%c > 0) result%phi_left = maxval(abs(phi))
         allowed = options%tolerance*max(1.0_wp, maxval(abs(at%x)))
         if (iteration > 0 .and. (balanced .or. maxval(abs(d)) <= allowed) .and. result%phi_left <= allowed) then
            outcome = merge(converged, far, within_reach())
            return
         end if
         if (iteration == options%max_iterations) exit

         result%iterations = result%iterations + 1
         call solver%meet(phi, d, phi_left)
         if (any(abs(phi_left) > 1.0e-6_wp*result%phi_left + allowed)) then
            outcome = inconsistent
            return
         end if
         if (iteration == 0) carried = result%lambda
         call solver%step(model, at, carried, options%difference, left, uncertain, d, info)
         result%free_motions = solver%free_motions
         result%loaded = solver%loaded
         if (info /= rest_ok) then
            ! With a smaller step the first iteration finds the same.
            if (info == rest_loaded) outcome = merge(stuck, mechanism, iteration == 0)
            if (info == rest_not_finite) outcome = not_finite
            if (info == rest_failed) outcome = failed
            return
         end if
         if (.not. all(ieee_is_finite(d)) .or. maxval(abs(d)) > 1.0e3_wp*max(1.0_wp, maxval(abs(at%x)))) then
            outcome = not_converged
            return
         end if
         call solver%tangent%carry(model, at, d)
         call solver%tangent%k%multiply(d, f)
         call solver%reactions(left - f, more, f)
         carried = result%lambda + more
         call model%displace(d, at%x)
         call model%normalize(at%x)
         moved = moved + d
      end do
      outcome = not_converged

   contains

      !> Whether this step has stayed near where it began.
      logical function within_reach()
         if (allocated(options%reach)) then
            within_reach = all(abs(moved) <= options%reach)
         else
            within_reach = maxval(abs(moved)) <= extent
         end if
      end function within_reach

   end subroutine converge

   !> Whether the options are valid.
   subroutine check_options(options, error)
      type(equilibrium_options_t), intent(in) :: options
      type(error_t), allocatable, intent(inout) :: error

      if (options%steps < 1) &
         call raise(error, here, 'steps = '//to_text(options%steps)//' is not positive', 'give 1 or more')
      if (options%max_iterations < 1) &
         call raise(error, here, 'max_iterations = '//to_text(options%max_iterations)//' is not positive', 'give 1 or more')
      if (options%max_halvings < 0) &
         call raise(error, here, 'max_halvings = '//to_text(options%max_halvings)//' is negative', 'give 0 or more')
      if (.not. options%tolerance > 0.0_wp) &
         call raise(error, here, 'tolerance = '//to_text(options%tolerance)//' is not positive', 'give one such as 1e-10')
      if (.not. any(options%parameter == [character(len=8) :: 'factor', 'time'])) &
         call raise(error, here, 'there is no parameter "'//trim(options%parameter)//'"', 'use "factor" or "time"')
   end subroutine check_options

   !> The error of a step that failed.
   subroutine explain(model, outcome, reached, result, error)
      class(mechanical_system_t), intent(in) :: model
      integer, intent(in) :: outcome
      real(wp), intent(in) :: reached
      type(equilibrium_result_t), intent(in) :: result
      type(error_t), allocatable, intent(inout) :: error
      character(:), allocatable :: place

      place = ' ('//to_text(100.0_wp*reached)//' % of the path is done)'
      select case (outcome)
      case (not_finite)
         call raise(error, here, 'a force or a constraint is not finite'//place, 'correct the system or its start')
      case (inconsistent)
         call raise(error, here, 'the constraints are inconsistent: no displacement reduces their violation'//place, &
                    'correct the constraints, or start closer to them')
      case (mechanism, stuck)
         call raise(error, here, 'a motion that nothing resists is loaded, most of all '// &
                    trim(velocity_name(model, result%loaded))//place, &
                    'block it or constrain it; if it only has no stiffness where it starts, as a level rod under its weight, '// &
                    'start it off there (off the horizontal; a closed loop by one body that is turned and held)')
      case (failed)
         call raise(error, here, 'a linear problem could not be solved'//place, 'correct the system')
      case default
         call raise(error, here, 'there is no equilibrium near the last one'//place, &
                    'start closer to the equilibrium; where a load is at its limit, as before a snap-through, start beyond '// &
                    'it, or let a motion with damping find it')
      end select
   end subroutine explain

end module taut_constrained_equilibrium
