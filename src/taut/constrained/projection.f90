!> Projection of positions and velocities on the constraints, Eqs (17) and (11a), at one state after the other.
module taut_constrained_projection
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   use taut_error, only: to_text
   use taut_constrained_linearization, only: inconsistent, linearization_t, not_converged, not_finite, weight_not_positive, &
                                             wrong_branch
   use taut_constrained_method_options, only: method_t
   use taut_constrained_newton, only: newton_t
   use taut_constrained_orientation, only: orientation_t
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_constrained_yardstick, only: largest_entry, relative_violation
   use taut_linalg_normal_solver, only: normal_solver_t
   use taut_ode_system, only: rhs_no_projection, rhs_ok, rhs_retry
   implicit none (type, external)
   private
   public :: projector_t

   !> Projection in the metric W, and its workspace.
   type :: projector_t
      !> A, W and S where something was projected last.
      type(linearization_t) :: linear
      !> The iteration for positions.
      type(newton_t) :: newton
      !> On which side of its singular positions a mechanism without freedom is.
      type(orientation_t) :: orientation
      !> b' at the last `velocity`: (c).
      real(wp), allocatable :: b_prime(:)
      !> Multipliers mu of Eq. (14a) at the last `velocity`: (c).
      real(wp), allocatable :: mu(:)
      !> Violation of the last velocity that was given to `velocity`, before it was corrected: (c).
      real(wp), allocatable, private :: phidot(:)
      !> Violations, multipliers that nobody asks for, and what shall be met without motion: (c); a velocity: (n).
      real(wp), allocatable, private :: r(:), normal(:), zero(:), d(:)
      !> What is on another branch than is meant, after a step that was refused for it.
      character(:), allocatable, private :: strayed
   contains
      procedure, non_overridable :: init
      procedure, non_overridable :: lay_yardstick
      procedure, non_overridable :: position
      procedure, non_overridable :: position_again
      procedure, non_overridable :: check_branch
      procedure, non_overridable :: correct
      procedure, non_overridable :: violations
      procedure, non_overridable :: velocity
      procedure, non_overridable :: shifted_velocity
      procedure, non_overridable :: velocity_violation
      procedure, non_overridable :: phidot_raw
      procedure, non_overridable :: filter_position
      procedure, non_overridable :: filter_velocity
      procedure, non_overridable :: look
      procedure, non_overridable :: serialize
      procedure, non_overridable :: explain
      procedure, non_overridable :: meet_holonomic
      procedure, non_overridable :: meet
      procedure, non_overridable :: balance
   end type projector_t

contains

   !> Allocates the workspace; nothing is allocated afterwards.
   subroutine init(self, model, method, held)
      !> The projector.
      class(projector_t), intent(inout) :: self
      !> The system whose constraints are met.
      class(mechanical_system_t), intent(in) :: model
      !> Weight, tolerances, solver.
      type(method_t), intent(in) :: method
      !> Velocities along which nothing is moved, neither coordinates nor the velocities themselves: (n). Default: none.
      logical, intent(in), optional :: held(:)

      call self%linear%init(model, method, held)
      call self%newton%init(model, method)
      call self%orientation%init(self%linear%a, model%c)
      if (allocated(self%b_prime)) deallocate (self%b_prime, self%mu, self%phidot, self%r, self%normal, self%zero, &
                                              self%d)
      allocate (self%b_prime(model%c), self%mu(model%c), self%phidot(model%c), self%r(model%c), self%normal(model%c), &
                self%zero(model%c), self%d(model%n), source=0.0_wp)
   end subroutine init

   !> Finds out how large the system is where its motion starts, and so when its constraints are met.
   subroutine lay_yardstick(self, model, at)
      !> The projector.
      class(projector_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Where the motion starts.
      type(state_t), intent(in) :: at

      call self%linear%evaluate(model, at)
      call self%newton%yardstick%lay(model, at, self%linear%a)
   end subroutine lay_yardstick

   !> Newton's iteration (17): x (+) (-W^-1 A^T S^+ phi) until all constraints are met.
   subroutine position(self, model, at, info, threshold, linearized)
      !> The projector.
      class(projector_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Its state; x is replaced.
      type(state_t), intent(inout) :: at
      !> `rhs_ok`, `rhs_retry` (entries that are not finite) or `rhs_no_projection`.
      integer, intent(out) :: info
      !> Violation up to which nothing is done; default: the tolerance of the method.
      real(wp), intent(in), optional :: threshold
      !> Whether the last `linearize` was for this very x; default: no.
      logical, intent(in), optional :: linearized

      call self%newton%position(self%linear, model, at, info, threshold, linearized)
   end subroutine position

   !> Goes on where `position` has failed without some rows.
   subroutine position_again(self, model, at, info, threshold)
      !> The projector, after a `position` that has failed.
      class(projector_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Its state; x is replaced.
      type(state_t), intent(inout) :: at
      !> What `position` said, and says now.
      integer, intent(inout) :: info
      !> As of `position`.
      real(wp), intent(in), optional :: threshold

      call self%newton%position_again(self%linear, model, at, info, threshold)
   end subroutine position_again

   !> Whether a state that meets the constraints is one that is meant: a step too long may end on another branch.
   subroutine check_branch(self, model, at, info)
      !> The projector.
      class(projector_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Its state, after `position` and with A.
      type(state_t), intent(in) :: at
      !> `rhs_ok` or `rhs_retry`.
      integer, intent(out) :: info

      info = rhs_ok
      call model%check_branch(at, self%strayed)
      if (.not. allocated(self%strayed)) then
         if (self%orientation%turned(self%linear%a, at%t)) self%strayed = 'the step ends beyond a singular '// &
            'position: on another branch of the motion'
      end if
      if (.not. allocated(self%strayed)) return
      self%linear%reason = wrong_branch
      info = rhs_retry
   end subroutine check_branch

   !> Positions and then velocities on the constraints, Eqs (17) and (11a), or only what exceeds a threshold.
   subroutine correct(self, model, at, info, threshold, linearized)
      !> The projector; what was found before the correction is in `phi_raw`, `phidot_raw`, and mu in `mu`.
      class(projector_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Its state; x and v are replaced.
      type(state_t), intent(inout) :: at
      !> `rhs_ok`, `rhs_retry` (entries that are not finite) or `rhs_no_projection`.
      integer, intent(out) :: info
      !> Violation up to which nothing is done, at either level; negative: always. Default: always.
      real(wp), intent(in), optional :: threshold
      !> Whether the last `linearize` was for this very x; default: no.
      logical, intent(in), optional :: linearized
      real(wp) :: limit

      limit = -1.0_wp
      if (present(threshold)) limit = threshold
      call self%position(model, at, info, limit, linearized)
      if (info == rhs_no_projection) call self%position_again(model, at, info, limit)
      if (info /= rhs_ok) return
      call self%linear%linearize(model, at, info, 0.0_wp)
      if (info /= rhs_ok) return
      if (limit >= 0.0_wp) then
         call self%velocity_violation(model, at)
         self%mu(:) = 0.0_wp
         if (self%phidot_raw() <= limit) return
      end if
      call self%velocity(model, at)
   end subroutine correct

   !> phi and phidot = A v - b' at the state as it is, with A in place.
   subroutine violations(self, model, at, phi, phidot)
      !> The projector.
      class(projector_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Its state.
      type(state_t), intent(in) :: at
      !> phi: (n_phi).
      real(wp), intent(inout), contiguous :: phi(:)
      !> phidot: (c).
      real(wp), intent(inout), contiguous :: phidot(:)

      call model%constraint(at, phi)
      call find_rates(self, model, at)
      call self%linear%a%multiply(at%v, phidot, self%b_prime)
   end subroutine violations

   !> v := v - W^-1 A^T S^+ (A v - b'), Eq. (11a) and Sect. 3.5 (c), (d), after `linearize`.
   subroutine velocity(self, model, at)
      !> The projector; mu is in `mu`.
      class(projector_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Its state; v is replaced.
      type(state_t), intent(inout) :: at

      if (model%c == 0) return
      call find_rates(self, model, at)
      call self%linear%onto%project(self%linear%a, self%b_prime, at%v, self%phidot, self%mu)
   end subroutine velocity

   !> The same towards another rate than that of the constraints.
   subroutine shifted_velocity(self, model, at, shift)
      !> The projector; mu is in `mu`.
      class(projector_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Its state; v is replaced.
      type(state_t), intent(inout) :: at
      !> Added to the violation A v - b': (c).
      real(wp), intent(in), contiguous :: shift(:)

      if (model%c == 0) return
      call find_rates(self, model, at)
      self%r(:) = self%b_prime - shift
      call self%linear%onto%project(self%linear%a, self%r, at%v, self%phidot, self%mu)
      self%phidot(:) = 0.0_wp
   end subroutine shifted_velocity

   !> A v - b', after `linearize`, as if v was to be corrected.
   subroutine velocity_violation(self, model, at)
      !> The projector.
      class(projector_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Its state.
      type(state_t), intent(in) :: at

      if (model%c == 0) return
      call find_rates(self, model, at)
      call self%linear%a%multiply(at%v, self%phidot, self%b_prime)
   end subroutine velocity_violation

   !> Violation of the last velocity that was given to `velocity`, before it was corrected.
   pure function phidot_raw(self) result(violation)
      !> The projector.
      class(projector_t), intent(in) :: self
      !> Its largest entry; none where another rate was asked for than that of the constraints.
      real(wp) :: violation

      violation = largest_entry(self%phidot)
   end function phidot_raw

   !> Takes the part normal to the constraints off a small change of x, after `linearize`.
   subroutine filter_position(self, model, at, e)
      !> The projector.
      class(projector_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> The state of the last `linearize`.
      type(state_t), intent(in) :: at
      !> Change of the coordinates: (n_x).
      real(wp), intent(inout), contiguous :: e(:)

      if (model%n_phi == 0) return
      call model%v_of_x_rate(at, e, self%d)
      call self%linear%project_holonomic(self%zero, self%d, self%r, self%normal)
      call model%x_rate(at, self%d, e)
   end subroutine filter_position

   !> Takes the part normal to the constraints off a small change of v, after `linearize`.
   subroutine filter_velocity(self, model, e)
      !> The projector.
      class(projector_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Change of the velocities: (n).
      real(wp), intent(inout), contiguous :: e(:)

      if (model%c == 0) return
      call self%linear%onto%project(self%linear%a, self%zero, e, self%r, self%normal)
   end subroutine filter_velocity

   !> b', less what is held gives of A v already.
   subroutine find_rates(self, model, at)
      type(projector_t), intent(inout) :: self
      class(mechanical_system_t), intent(in) :: model
      type(state_t), intent(in) :: at

      call model%velocity_rhs(at, self%b_prime)
      if (allocated(self%linear%held)) self%b_prime(:) = self%b_prime - self%linear%from_held
   end subroutine find_rates

   !> u := u - W^-1 A^T mu with A u = b in the holonomic rows, after `linearize`.
   subroutine meet_holonomic(self, b, u, mu)
      !> The projector.
      class(projector_t), intent(inout) :: self
      !> What A u shall be: (c); the holonomic entries count.
      real(wp), intent(in), contiguous :: b(:)
      !> A vector, replaced: (n).
      real(wp), intent(inout), contiguous :: u(:)
      !> Multipliers: (c).
      real(wp), intent(out), contiguous :: mu(:)

      mu(:) = 0.0_wp
      call self%linear%project_holonomic(b, u, self%r, mu)
   end subroutine meet_holonomic

   !> u := u - W^-1 A^T S^+ (A u - b), after `linearize`: with u = 0, A^+ b.
   subroutine meet(self, b, u)
      !> The projector.
      class(projector_t), intent(inout) :: self
      !> What A u shall be: (c).
      real(wp), intent(in), contiguous :: b(:)
      !> A vector, replaced: (n).
      real(wp), intent(inout), contiguous :: u(:)

      if (size(b) > 0) call self%linear%onto%project(self%linear%a, b, u, self%r, self%normal)
   end subroutine meet

   !> Multipliers with A^T lambda = f for a force in the range of A^T, of least norm, after `linearize`.
   subroutine balance(self, f, lambda)
      !> The projector.
      class(projector_t), intent(inout) :: self
      !> The force, lost: (n).
      real(wp), intent(inout), contiguous :: f(:)
      !> Multipliers: (c).
      real(wp), intent(inout), contiguous :: lambda(:)

      if (size(lambda) == 0) return
      call self%linear%divide_by_weight(f)
      call self%linear%a%multiply(f, self%r)
      call self%linear%onto%multipliers(self%r, lambda)
      call self%linear%onto%minimum_norm(lambda)
   end subroutine balance

   !> Looks at the rank where a step was accepted.
   subroutine look(self, model, at, onto)
      !> The projector, with A.
      class(projector_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Where A is.
      type(state_t), intent(in) :: at
      !> A solver with S of all rows of A, if it is not the projector's own.
      class(normal_solver_t), intent(inout), optional :: onto
      real(wp) :: violation

      associate (linear => self%linear)
         call self%orientation%remember(linear%a, linear%keeper%kept, at%t)
         violation = 0.0_wp
         if (model%n_phi > 1 .and. (linear%onto%rank < linear%onto%c .or. .not. linear%keeper%holds)) then
            call model%constraint(at, linear%phi)
            violation = relative_violation(linear%phi, linear%a, at%x)
         end if
         if (present(onto)) then
            call linear%keeper%look(linear%a, onto, at%t, violation)
         else
            call linear%look(at%t, violation)
         end if
      end associate
   end subroutine look

   !> Passes through an archive what is remembered of the rank from one step to the next.
   subroutine serialize(self, archive)
      !> The projector.
      class(projector_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      call self%linear%serialize(archive)
      call self%orientation%serialize(archive)
      call self%newton%yardstick%serialize(archive, 'projection')
   end subroutine serialize

   !> Why the last projection failed, in words.
   subroutine explain(self, model, text)
      !> The projector.
      class(projector_t), intent(in) :: self
      !> The system, asked for the name of a row.
      class(mechanical_system_t), intent(in) :: model
      !> One line.
      character(:), allocatable, intent(out) :: text
      character(:), allocatable :: row

      if (self%newton%worst > 0) call model%row_name(self%newton%worst, row)
      select case (self%linear%reason)
      case (not_converged)
         text = row//' is still violated by '//to_text(self%newton%residual)//' after '// &
                to_text(self%newton%max_iterations)//' iterations'
      case (inconsistent)
         text = 'the constraints are inconsistent: '//row//' stays violated by '// &
                to_text(self%newton%residual)//' and no displacement reduces it (a larger projection_tolerance lets it pass)'
      case (weight_not_positive)
         text = 'the weight matrix W is not positive definite'
      case (wrong_branch)
         text = self%strayed
      case (not_finite)
         text = 'a constraint or its matrix is not finite'
      case default
         text = ''
      end select
   end subroutine explain

end module taut_constrained_projection
