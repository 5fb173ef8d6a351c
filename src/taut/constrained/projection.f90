!> Projection of positions and velocities on the constraints.
module taut_constrained_projection
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use, intrinsic :: iso_fortran_env, only: int64
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   use taut_error, only: to_text
   use taut_constrained_completion, only: completion_t
   use taut_constrained_method_options, only: method_t
   use taut_constrained_orientation, only: orientation_t
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_constrained_yardstick, only: largest_entry, relative_violation, yardstick_t
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_csr, only: csr_t
   use taut_linalg_normal_solver, only: normal_solver_t
   use taut_linalg_normal_solver_choose, only: choose_solver
   use taut_linalg_rank, only: pivot_floor
   use taut_linalg_rank_keeper, only: rank_keeper_t
   use taut_ode_system, only: rhs_ok, rhs_retry, rhs_no_projection
   implicit none (type, external)
   private
   public :: projector_t, lay_out_jacobian, evaluate_jacobian

   !> Why a projection failed.
   integer, parameter :: no_reason = 0, not_converged = 1, inconsistent = 2, not_finite = 3, weight_not_positive = 4, &
                         wrong_branch = 5

   !> Rows of A with errors up to this, relative to their size, have no redundant rows that exact ones do not have: see the
   !! use of `noise` by the solvers.
   real(wp), parameter :: harmless_noise = 1.0e-5_wp

   ! The decisions of Newton's iteration (17), where violations are measured by the yardstick.
   !> A and S are kept while an iteration leaves less than this part of phi. The simplified iteration then goes on at this rate or
   !! better: a second evaluation of A and S would cost more than the iteration that it may save.
   real(wp), parameter :: fast = 1.0e-3_wp
   !> The part of phi that a displacement is to reach, A d against phi: less than half of it, and the rank is in doubt.
   real(wp), parameter :: most = 0.5_wp
   !> Where a displacement reaches no more than this part of phi, the rest is normal to the range of A: the constraints contradict
   !! each other. Larger than what the condition of S leaves of round-off (the root of it), smaller than any violation that
   !! moves are able to mend.
   real(wp), parameter :: contradiction = 1.0e-6_wp
   !> A displacement that does not reduce phi is halved up to so many times: a thousandth of it does not help either.
   integer, parameter :: halvings = 10
   !> A violation that is left by the first correction is what round-off and the condition of S leave of it, up to so many times
   !! that which counts as none: what takes it off then says nothing of how the way back bends.
   real(wp), parameter :: worth_telling = 100.0_wp
   !> A displacement of more round-offs of the largest coordinate than this moves something.
   real(wp), parameter :: never_round_off = 8.0_wp*epsilon(1.0_wp)
   !> Growth of the sum of squares of phi that is round-off: where constraints are inconsistent, what can be reduced may be
   !! less than round-off of what cannot.
   real(wp), parameter :: no_growth = 1.0_wp + 8.0_wp*epsilon(1.0_wp)

   !> Projection in the metric W, and its workspace.
   type :: projector_t
      !> Constraint matrix at the last `linearize`.
      type(csr_t) :: a
      !> b' at the last `velocity`: (c).
      real(wp), allocatable :: b_prime(:)
      !> Multipliers mu of Eq. (14a) at the last `velocity`: (c).
      real(wp), allocatable :: mu(:)
      !> Violation of the last position that was given to `position`, largest entry, before it was corrected.
      real(wp) :: phi_raw = 0.0_wp
      !> Violation of the last velocity that was given to `velocity`, largest entry, before it was corrected.
      real(wp) :: phidot_raw = 0.0_wp
      !> Violation that is left after `position`, largest entry.
      real(wp) :: residual = 0.0_wp
      !> Iterations of Eq. (17) in all.
      integer :: iterations = 0
      !> W, factorized; not used if W = I.
      type(block_diagonal_t) :: w
      !> What completes a singular M, where W = M.
      type(completion_t) :: completion
      !> W^-1 A^T S^+ with all rows of A, as of the last `linearize`.
      class(normal_solver_t), allocatable :: onto
      !> Which rows of A are independent.
      type(rank_keeper_t) :: keeper
      !> When constraints are met.
      type(yardstick_t) :: yardstick
      logical, private :: identity = .true., w_is_mass = .false., all_holonomic = .true., w_ready = .false.
      logical, private :: accept_inconsistent = .false.
      integer, private :: max_iterations = 25, reason = no_reason, worst = 0
      !> Corrections of the last `position`, and the coordinates after the first of several: (n_x).
      integer, private :: corrections = 0
      !> Whether the first of them has left a violation that is worth telling.
      logical, private :: left_some = .false.
      real(wp), allocatable, private :: x_first(:)
      !> The holonomic rows alone, where there are others.
      class(normal_solver_t), allocatable, private :: onto_holonomic
      type(rank_keeper_t) :: keeper_of_holonomic
      real(wp), allocatable, private :: phi(:), nu(:), d(:), x_before(:), r(:), normal(:)
      !> Largest entry of the last displacement d.
      real(wp), private :: largest_d = 0.0_wp
      !> Of all rows.
      real(wp), allocatable, private :: zero(:)
      !> On which side of its singular positions a mechanism without freedom is.
      type(orientation_t) :: orientation
      !> What is on another branch than is meant, after a step that was refused for it.
      character(:), allocatable, private :: strayed
      !> Entries of A that came with the last phi of a system that `linearizes`, and where that was.
      real(wp), allocatable, private :: entries(:), x_of_entries(:)
      real(wp), private :: t_of_entries = 0.0_wp
      !> Velocities along which nothing is moved, and what they give of A v: (n), (c); not allocated: none.
      logical, allocatable, private :: held(:)
      real(wp), allocatable, private :: from_held(:)
   contains
      procedure, non_overridable :: init
      procedure, non_overridable :: lay_yardstick
      procedure, non_overridable :: position
      procedure, non_overridable :: position_again
      procedure, non_overridable :: check_branch
      procedure, non_overridable :: correct
      procedure, non_overridable :: evaluate
      procedure, non_overridable :: factorize
      procedure, non_overridable :: linearize
      procedure, non_overridable :: violations
      procedure, non_overridable :: velocity
      procedure, non_overridable :: velocity_violation
      procedure, non_overridable :: filter_position
      procedure, non_overridable :: filter_velocity
      procedure, non_overridable :: later_corrections
      procedure, non_overridable :: look
      procedure, non_overridable :: serialize
      procedure, non_overridable :: explain
      procedure, non_overridable :: kept_rows
      procedure, non_overridable :: leave_out
      procedure, non_overridable :: divide_by_weight
      procedure, non_overridable :: meet_holonomic
      procedure, non_overridable :: meet
      procedure, non_overridable :: balance
   end type projector_t

contains

   !> Lays out the constraint matrix of a system, with all its entries or with those of the system's pattern.
   subroutine lay_out_jacobian(model, a)
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> The matrix.
      type(csr_t), intent(inout) :: a
      integer, allocatable :: first(:), column(:)

      call model%pattern(first, column)
      if (allocated(first)) then
         call a%set_pattern(model%n, first, column)
      else
         call a%init(model%c, model%n)
      end if
   end subroutine lay_out_jacobian

   !> Computes the entries of the constraint matrix at a state.
   subroutine evaluate_jacobian(model, at, a)
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Its state.
      type(state_t), intent(in) :: at
      !> The matrix, laid out.
      type(csr_t), intent(inout) :: a

      if (.not. a%full) then
         call model%jacobian_entries(at, a%values)
      else if (a%c == 1) then
         call evaluate_row(model, at, a%n, a%values)
      else if (a%c > 1) then
         call model%jacobian(at, a%all_entries)
         call a%set_dense(a%all_entries)
      end if
   end subroutine evaluate_jacobian

   !> One row is laid out like its matrix.
   subroutine evaluate_row(model, at, n, a)
      class(mechanical_system_t), intent(in) :: model
      type(state_t), intent(in) :: at
      integer, intent(in) :: n
      real(wp), intent(inout) :: a(1, n)

      call model%jacobian(at, a)
   end subroutine evaluate_row

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
      integer, allocatable :: blocks(:), group(:)
      real(wp) :: rcond

      self%identity = method%weight == 'identity'
      self%w_is_mass = method%weight == 'mass'
      self%w_ready = .false.
      self%accept_inconsistent = method%accept_inconsistent
      call self%yardstick%init(model%n_phi, model%n, method%projection_tolerance)
      self%max_iterations = method%max_iterations
      self%all_holonomic = model%n_phi == model%c
      if (allocated(self%held)) deallocate (self%held, self%from_held)
      if (present(held)) then
         allocate (self%held, source=held)
         allocate (self%from_held(model%c), source=0.0_wp)
      end if
      if (allocated(self%b_prime)) deallocate (self%b_prime, self%mu, self%r, self%normal, self%phi, self%nu, self%d, &
                                               self%x_before, self%x_first, self%zero)
      allocate (self%b_prime(model%c), self%mu(model%c), self%r(model%c), self%normal(model%c), self%zero(model%c), &
                self%phi(model%n_phi), self%nu(model%n_phi), self%d(model%n), self%x_before(model%n_x), self%x_first(model%n_x), &
                source=0.0_wp)
      call lay_out_jacobian(model, self%a)
      if (allocated(self%entries)) deallocate (self%entries, self%x_of_entries)
      if (model%linearizes) then
         allocate (self%entries(size(self%a%values)), self%x_of_entries(model%n_x), source=0.0_wp)
         self%t_of_entries = -huge(1.0_wp)
      end if
      call self%w%init(model%mass_blocks)
      if (self%identity) then
         blocks = spread(1, 1, model%n)
      else
         blocks = model%mass_blocks
      end if
      call model%column_groups(group)
      rcond = method%rcond
      if (method%solver == 'dgelsd') rcond = 0.0_wp
      call choose_solver(method%solver, self%a, model%c, blocks, method%rcond, self%onto)
      call self%keeper%init(self%a, model%c, group, rcond)
      call self%orientation%init(self%a, model%c)
      if (self%all_holonomic) return
      call choose_solver(method%solver, self%a, model%n_phi, blocks, method%rcond, self%onto_holonomic)
      call self%keeper_of_holonomic%init(self%a, model%n_phi, group, rcond)
   end subroutine init

   !> W at a state, factorized, where W is not the identity.
   subroutine renew_weight(self, model, at, info)
      type(projector_t), intent(inout) :: self
      class(mechanical_system_t), intent(in) :: model
      type(state_t), intent(in) :: at
      integer, intent(out) :: info

      info = 0
      if (self%w_is_mass) then
         if (self%w_ready .and. model%constant_mass .and. .not. self%completion%is_on) return
         call model%mass(at, self%w)
      else
         call model%weight(at, self%w)
      end if
      if (allocated(self%held)) call decouple(self%w, self%held)
      if (self%w_is_mass) then
         call self%completion%factorize(self%w, self%a, info)
      else
         call self%w%factorize(info)
      end if
      self%w_ready = info == 0
   end subroutine renew_weight

   !> Rows and columns of what is held become those of the identity, so that the others do not move it.
   pure subroutine decouple(w, held)
      type(block_diagonal_t), intent(inout) :: w
      logical, intent(in) :: held(:)
      integer :: b, i, j, k, s

      k = 0
      do b = 1, size(w%first) - 1
         s = w%first(b + 1) - w%first(b)
         do j = w%first(b), w%first(b) + s - 1
            do i = w%first(b), w%first(b) + s - 1
               k = k + 1
               if (held(i) .or. held(j)) w%values(k) = merge(1.0_wp, 0.0_wp, i == j)
            end do
         end do
      end do
   end subroutine decouple

   !> Finds out how large the system is where its motion starts, and so when its constraints are met.
   subroutine lay_yardstick(self, model, at)
      !> The projector.
      class(projector_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Where the motion starts.
      type(state_t), intent(in) :: at

      call self%evaluate(model, at)
      call self%yardstick%lay(model, at, self%a)
   end subroutine lay_yardstick

   !> Newton's iteration (17): x (+) (-W^-1 A^T S^+ phi) until all constraints are met.
   !!
   !! Source: Eqs (16), (17). A step that does not reduce phi is halved. A and S are kept while they reduce phi fast. Rows that
   !! were left out are to be met like the others: where they are not, `position_again` may help.
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
      real(wp) :: before, largest, left, left_before, noise, reach
      integer :: iteration
      logical :: known, plain, renew

      info = rhs_ok
      call model%normalize(at%x)
      self%residual = 0.0_wp
      self%phi_raw = 0.0_wp
      self%corrections = 0
      if (model%n_phi == 0) return
      call evaluate_constraint(self, model, at)
      self%residual = largest_entry(self%phi)
      if (.not. ieee_is_finite(self%residual)) then
         call give_up(self, not_finite, info)
         return
      end if
      self%phi_raw = self%residual
      if (present(threshold)) then
         if (self%residual <= threshold) return
      end if
      renew = .true.
      left_before = 0.0_wp
      known = .false.
      if (present(linearized)) known = linearized
      noise = 0.0_wp
      if (self%residual <= self%yardstick%sure) return
      largest = largest_entry(at%x)
      plain = 2.0_wp*largest <= self%yardstick%plain_up_to
      do iteration = 1, self%max_iterations + 1
         if (self%residual <= self%yardstick%sure) return
         left = self%residual
         if (.not. plain) left = self%yardstick%measure(self%phi, at%x)
         if (left <= self%yardstick%tolerance) return
         if (iteration > 1) then
            ! What a system of the size 1 may leave is all there is to be had where constants are that large.
            if (self%residual <= self%yardstick%tolerance .and. left > most*left_before) return
            renew = left > fast*left_before
         end if
         if (iteration > self%max_iterations) exit
         self%iterations = self%iterations + 1
         if (renew) then
            if (.not. known) then
               call self%evaluate(model, at)
               if (.not. self%identity) call renew_weight(self, model, at, info)
               if (info /= 0) then
                  call give_up(self, weight_not_positive, info)
                  return
               end if
            end if
            noise = 0.0_wp
            if (model%n_phi > 1) noise = relative_violation(self%phi, self%a, at%x)
            renew = .not. (known .and. noise <= harmless_noise)
            known = .false.
         end if
         call newton_step(self, renew, noise, at%x, left, reach, info)
         ! The noise may have taken rows that matter for redundant ones.
         if (info == rhs_ok .and. renew .and. noise > 0.0_wp .and. reach < most*left) &
            call newton_step(self, renew, 0.0_wp, at%x, left, reach, info)
         if (info /= rhs_ok) return
         if (reach <= self%yardstick%tolerance .or. (reach <= contradiction*left .and. .not. self%accept_inconsistent)) then
            if (.not. (self%accept_inconsistent .or. self%residual <= self%yardstick%tolerance)) &
               call give_up(self, inconsistent, info)
            return
         end if
         if (reach >= most*left .and. .not. (plain .and. self%largest_d > never_round_off*largest)) then
            if (self%yardstick%nothing_moves(self%d, at%x)) return
         end if
         before = dot_product(self%phi, self%phi)
         if (self%corrections == 1) then
            self%left_some = left > worth_telling*self%yardstick%tolerance
            self%x_first(:) = at%x
         end if
         self%corrections = self%corrections + 1
         left_before = left
         call move(self, model, at, before, info)
         if (info /= rhs_ok) return
      end do
      call give_up(self, not_converged, info)
   end subroutine position

   !> Goes on where `position` has failed without some rows.
   !!
   !! Where rows were left out, those in charge may no longer be the right ones. Near a singular position rows are passed over, of
   !! which the others leave little: what violates them there is of second order in a displacement that only they can tell, so
   !! that with them it is reached, if by half of what is left each time.
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

      if (self%onto%rank < self%onto%c .and. self%keeper%holds) then
         call self%keeper%release()
         call self%keeper_of_holonomic%release()
         call self%position(model, at, info, threshold)
      end if
      if (info /= rhs_no_projection) return
      if (self%all_holonomic) then
         call with_all(self%onto%weakest(), self%onto%cut)
      else
         call with_all(self%onto_holonomic%weakest(), self%onto_holonomic%cut)
      end if

   contains

      subroutine with_all(weakest, cut)
         real(wp), intent(in) :: weakest
         real(wp), value :: cut

         if (weakest > 0.0_wp) return
         call set_cut(pivot_floor)
         call self%position(model, at, info, threshold)
         call set_cut(cut)
      end subroutine with_all

      subroutine set_cut(cut)
         real(wp), intent(in) :: cut

         if (self%all_holonomic) then
            call self%onto%pass_over(cut)
         else
            call self%onto_holonomic%pass_over(cut)
         end if
      end subroutine set_cut

   end subroutine position_again

   !> d = -W^-1 A^T S^+ phi with the holonomic rows, and the size of A d: of what is left in phi, what d will change.
   subroutine newton_step(self, renew, noise, x, left, reach, info)
      type(projector_t), intent(inout) :: self
      logical, intent(in) :: renew
      real(wp), intent(in) :: noise, left
      real(wp), intent(in), contiguous :: x(:)
      real(wp), intent(out) :: reach
      integer, intent(out) :: info

      if (self%all_holonomic) then
         call step_with(self%onto, self%keeper)
      else
         call step_with(self%onto_holonomic, self%keeper_of_holonomic)
      end if

   contains

      subroutine step_with(onto, keeper)
         class(normal_solver_t), intent(inout) :: onto
         type(rank_keeper_t), intent(inout) :: keeper
         logical :: all_rows

         reach = 0.0_wp
         self%largest_d = 0.0_wp
         info = 0
         if (renew) call factorize_with(self, onto, keeper, noise, info)
         if (info == 0) then
            self%d(:) = 0.0_wp
            call onto%multipliers(self%phi, self%nu)
            call onto%correction(self%a, self%nu, self%d)
            self%largest_d = largest_entry(self%d)
         end if
         if (info /= 0 .or. .not. ieee_is_finite(self%largest_d)) then
            call give_up(self, not_finite, info)
            return
         end if
         info = rhs_ok
         all_rows = onto%rank == onto%c
         ! At a dead point some are passed over; a single one is never.
         if (all_rows .and. onto%c > 1 .and. self%corrections > 0) all_rows = onto%weakest() > 0.0_wp
         if (all_rows) then
            reach = left
         else
            call self%a%multiply(self%d, self%nu)
            reach = self%yardstick%measure(self%nu, x)
         end if
      end subroutine step_with

   end subroutine newton_step

   !> phi, and the entries of A if they come with it.
   subroutine evaluate_constraint(self, model, at)
      type(projector_t), intent(inout) :: self
      class(mechanical_system_t), intent(in) :: model
      type(state_t), intent(in) :: at

      if (.not. allocated(self%entries)) then
         call model%constraint(at, self%phi)
         return
      end if
      call model%linearization(at, self%phi, self%entries)
      self%t_of_entries = at%t
      self%x_of_entries(:) = at%x
   end subroutine evaluate_constraint

   !> Whether the entries that came with phi are those of a state: of the same numbers, bit for bit.
   pure logical function entries_are_of(self, at)
      type(projector_t), intent(in) :: self
      type(state_t), intent(in) :: at
      integer(int64) :: bits
      integer :: i

      entries_are_of = allocated(self%entries)
      if (.not. entries_are_of) return
      bits = ieor(transfer(at%t, bits), transfer(self%t_of_entries, bits))
      do i = 1, size(at%x)
         bits = ior(bits, ieor(transfer(at%x(i), bits), transfer(self%x_of_entries(i), bits)))
      end do
      entries_are_of = bits == 0_int64
   end function entries_are_of

   !> x := x (+) d, with d halved until phi has become smaller.
   subroutine move(self, model, at, before, info)
      type(projector_t), intent(inout) :: self
      class(mechanical_system_t), intent(in) :: model
      type(state_t), intent(inout) :: at
      real(wp), intent(in) :: before
      integer, intent(out) :: info
      integer :: halving
      real(wp) :: largest

      self%x_before(:) = at%x
      do halving = 0, halvings
         call model%displace(self%d, at%x)
         call model%normalize(at%x)
         call evaluate_constraint(self, model, at)
         largest = largest_entry(self%phi)
         if (ieee_is_finite(largest)) then
            if (dot_product(self%phi, self%phi) <= before*no_growth) then
               self%residual = largest
               info = rhs_ok
               return
            end if
         end if
         at%x(:) = self%x_before
         self%d(:) = 0.5_wp*self%d
      end do
      call evaluate_constraint(self, model, at)
      self%residual = largest_entry(self%phi)
      info = rhs_ok
      if (self%residual > self%yardstick%tolerance) call give_up(self, not_converged, info)
   end subroutine move

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
         if (self%orientation%turned(self%a, at%t)) self%strayed = 'the step ends beyond a singular '// &
            'position: on another branch of the motion'
      end if
      if (allocated(self%strayed)) call give_up(self, wrong_branch, info)
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
      call self%linearize(model, at, info, 0.0_wp)
      if (info /= rhs_ok) return
      if (limit >= 0.0_wp) then
         call self%velocity_violation(model, at)
         self%mu(:) = 0.0_wp
         if (self%phidot_raw <= limit) return
      end if
      call self%velocity(model, at)
   end subroutine correct

   !> A at a state; what is held has no part in it.
   subroutine evaluate(self, model, at)
      !> The projector.
      class(projector_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Its state.
      type(state_t), intent(in) :: at

      if (entries_are_of(self, at)) then
         self%a%values(:) = self%entries
      else
         call evaluate_jacobian(model, at, self%a)
      end if
      if (.not. allocated(self%held)) return
      self%d(:) = merge(at%v, 0.0_wp, self%held)
      call self%a%multiply(self%d, self%from_held)
      call clear_columns(self%a, self%held)
   end subroutine evaluate

   !> Sets columns to zero.
   pure subroutine clear_columns(a, chosen)
      type(csr_t), intent(inout) :: a
      logical, intent(in) :: chosen(:)
      integer :: i

      if (a%full) then
         do i = 1, a%c
            where (chosen) a%values((i - 1)*a%n + 1:i*a%n) = 0.0_wp
         end do
      else
         where (chosen(a%column)) a%values = 0.0_wp
      end if
   end subroutine clear_columns

   !> b', less what is held gives of A v already.
   subroutine evaluate_rates(self, model, at)
      type(projector_t), intent(inout) :: self
      class(mechanical_system_t), intent(in) :: model
      type(state_t), intent(in) :: at

      call model%velocity_rhs(at, self%b_prime)
      if (allocated(self%held)) self%b_prime(:) = self%b_prime - self%from_held
   end subroutine evaluate_rates

   !> W and S = A W^-1 A^T at a state, with A in place.
   subroutine factorize(self, model, at, info, noise)
      !> The projector.
      class(projector_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Its state.
      type(state_t), intent(in) :: at
      !> `rhs_ok` or `rhs_retry`.
      integer, intent(out) :: info
      !> Relative error of the rows of A for want of a state that meets the constraints.
      real(wp), intent(in) :: noise

      info = 0
      if (.not. self%identity) call renew_weight(self, model, at, info)
      if (info /= 0) then
         call give_up(self, weight_not_positive, info)
         return
      end if
      call factorize_with(self, self%onto, self%keeper, noise, info)
      if (info == 0 .and. .not. self%all_holonomic) &
         call factorize_with(self, self%onto_holonomic, self%keeper_of_holonomic, noise, info)
      if (info /= 0) then
         call give_up(self, not_finite, info)
         return
      end if
      info = rhs_ok
   end subroutine factorize

   !> S of the rows that are independent.
   subroutine factorize_with(self, onto, keeper, noise, info)
      type(projector_t), intent(in) :: self
      class(normal_solver_t), intent(inout) :: onto
      type(rank_keeper_t), intent(inout) :: keeper
      real(wp), intent(in) :: noise
      integer, intent(out) :: info

      if (.not. keeper%holds .or. onto%revision /= keeper%revision) call keeper%prepare(self%a, noise, onto)
      call onto%factorize(self%a, self%w, self%identity, info)
   end subroutine factorize_with

   !> A, W and S = A W^-1 A^T at a state, Sect. 3.5 (b).
   subroutine linearize(self, model, at, info, noise)
      !> The projector.
      class(projector_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Its state.
      type(state_t), intent(in) :: at
      !> `rhs_ok` or `rhs_retry`.
      integer, intent(out) :: info
      !> Relative error of the rows of A for want of a state that meets the constraints.
      real(wp), intent(in) :: noise

      call self%evaluate(model, at)
      call self%factorize(model, at, info, noise)
   end subroutine linearize

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
      call evaluate_rates(self, model, at)
      call self%a%multiply(at%v, phidot, self%b_prime)
   end subroutine violations

   !> v := v - W^-1 A^T S^+ (A v - b'), Eq. (11a) and Sect. 3.5 (c), (d), after `linearize`.
   subroutine velocity(self, model, at, shift)
      !> The projector; mu is in `mu`.
      class(projector_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Its state; v is replaced.
      type(state_t), intent(inout) :: at
      !> Added to the violation A v - b', for methods that ask for another rate: (c).
      real(wp), intent(in), optional :: shift(:)
      integer :: i

      self%phidot_raw = 0.0_wp
      if (model%c == 0) return
      call evaluate_rates(self, model, at)
      if (present(shift)) then
         do i = 1, model%c
            self%r(i) = self%b_prime(i) - shift(i)
         end do
         call self%onto%project(self%a, self%r, at%v, self%normal, self%mu)
      else
         call self%onto%project(self%a, self%b_prime, at%v, self%r, self%mu)
         self%phidot_raw = largest_entry(self%r)
      end if
   end subroutine velocity

   !> A v - b', after `linearize`: its largest entry is kept in `phidot_raw`.
   subroutine velocity_violation(self, model, at)
      !> The projector.
      class(projector_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Its state.
      type(state_t), intent(in) :: at

      self%phidot_raw = 0.0_wp
      if (model%c == 0) return
      call evaluate_rates(self, model, at)
      call self%a%multiply(at%v, self%r, self%b_prime)
      self%phidot_raw = largest_entry(self%r)
   end subroutine velocity_violation

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
      if (self%all_holonomic) then
         call self%onto%project(self%a, self%zero, self%d, self%phi, self%nu)
      else
         call self%onto_holonomic%project(self%a, self%zero, self%d, self%phi, self%nu)
      end if
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
      call self%onto%project(self%a, self%zero, e, self%r, self%normal)
   end subroutine filter_velocity

   !> Which rows of A are independent of each other, after `linearize`.
   subroutine kept_rows(self, kept)
      !> The projector.
      class(projector_t), intent(in) :: self
      !> Whether a row is one of them: (c).
      logical, intent(out) :: kept(:)

      kept(:) = self%keeper%kept
   end subroutine kept_rows

   !> Leaves rows out that come to depend on the others on the way to another state, until the next `linearize`.
   subroutine leave_out(self, there, kept, info)
      !> The projector, after `linearize`.
      class(projector_t), intent(inout) :: self
      !> A at the other state.
      type(csr_t), intent(in) :: there
      !> The rows that are kept so far, those that are left out taken off: (c).
      logical, intent(inout) :: kept(:)
      !> `rhs_ok` or `rhs_retry`.
      integer, intent(out) :: info

      call self%keeper%selection%leave_out(self%a, there, kept)
      call factorize_rows(self%onto, kept)
      if (info == 0 .and. .not. self%all_holonomic) call factorize_rows(self%onto_holonomic, kept(:self%onto_holonomic%c))
      info = merge(rhs_ok, rhs_retry, info == 0)

   contains

      subroutine factorize_rows(onto, rows)
         class(normal_solver_t), intent(inout) :: onto
         logical, intent(in) :: rows(:)

         call onto%keep(rows)
         onto%revision = -1
         call onto%factorize(self%a, self%w, self%identity, info)
      end subroutine factorize_rows

   end subroutine leave_out

   !> u := W^-1 u, after `linearize`.
   subroutine divide_by_weight(self, u)
      !> The projector.
      class(projector_t), intent(inout) :: self
      !> A vector: (n).
      real(wp), intent(inout), contiguous :: u(:)

      if (.not. self%identity) call self%w%solve(1, u)
   end subroutine divide_by_weight

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
      if (self%all_holonomic) then
         call self%onto%project(self%a, b, u, self%r, mu)
      else
         call self%onto_holonomic%project(self%a, b(:size(self%phi)), u, self%r(:size(self%phi)), mu(:size(self%phi)))
      end if
   end subroutine meet_holonomic

   !> u := u - W^-1 A^T S^+ (A u - b), after `linearize`: with u = 0, A^+ b.
   subroutine meet(self, b, u)
      !> The projector.
      class(projector_t), intent(inout) :: self
      !> What A u shall be: (c).
      real(wp), intent(in), contiguous :: b(:)
      !> A vector, replaced: (n).
      real(wp), intent(inout), contiguous :: u(:)

      if (size(b) > 0) call self%onto%project(self%a, b, u, self%r, self%normal)
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
      call self%divide_by_weight(f)
      call self%a%multiply(f, self%r)
      call self%onto%multipliers(self%r, lambda)
      call self%onto%minimum_norm(lambda)
   end subroutine balance

   !> By how much the last `position` has moved x after its first correction.
   pure subroutine later_corrections(self, at, d, bends)
      !> The projector.
      class(projector_t), intent(in) :: self
      !> The state that it left.
      type(state_t), intent(in) :: at
      !> Displacement, if there is any: (n_x).
      real(wp), intent(inout), contiguous :: d(:)
      !> Whether there is.
      logical, intent(out) :: bends

      bends = self%corrections > 1 .and. self%left_some
      if (bends) d(:) = at%x - self%x_first
   end subroutine later_corrections

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

      call self%orientation%remember(self%a, self%keeper%kept, at%t)
      violation = 0.0_wp
      if (model%n_phi > 1 .and. (self%onto%rank < self%onto%c .or. .not. self%keeper%holds)) then
         call model%constraint(at, self%phi)
         violation = relative_violation(self%phi, self%a, at%x)
      end if
      if (present(onto)) then
         call self%keeper%look(self%a, onto, at%t, violation)
         return
      end if
      call self%keeper%look(self%a, self%onto, at%t, violation)
      if (.not. self%all_holonomic) call self%keeper_of_holonomic%look(self%a, self%onto_holonomic, at%t, violation)
   end subroutine look

   !> Passes through an archive what is remembered of the rank from one step to the next.
   subroutine serialize(self, archive)
      !> The projector.
      class(projector_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      call keeper_through(archive, 'rank', self%keeper)
      if (.not. self%all_holonomic) call keeper_through(archive, 'rank of holonomic rows', self%keeper_of_holonomic)
      call self%orientation%serialize(archive)
      call self%yardstick%serialize(archive, 'projection')
   end subroutine serialize

   !> The same for one of the two.
   subroutine keeper_through(archive, name, keeper)
      type(archive_t), intent(inout) :: archive
      character(*), intent(in) :: name
      type(rank_keeper_t), intent(inout) :: keeper
      real(wp) :: kept(size(keeper%kept)), stretch(size(keeper%selection%rows%stretch))

      call archive%item(name//' is held', keeper%holds)
      call archive%item(name//' before', keeper%rank_before)
      call archive%item(name//' at a dead point', keeper%dead)
      call archive%item(name//' rising', keeper%rising)
      call archive%item(name//' smallest pivot', keeper%first_pivot)
      kept = merge(1.0_wp, 0.0_wp, keeper%kept)
      call archive%item(name//' is made of rows', kept)
      call keeper%restore(kept > 0.0_wp)
      kept = merge(1.0_wp, 0.0_wp, keeper%kept_before)
      call archive%item(name//' was made of rows', kept)
      keeper%kept_before(:) = kept > 0.0_wp
      call archive%item(name//' is trusted', keeper%trusted)
      call archive%item(name//' smallest pivot before', keeper%pivot_before)
      call archive%item(name//' scale of rows', keeper%selection%rows%row_scale)
      call archive%item(name//' scale of columns', keeper%selection%rows%column_scale)
      call archive%item(name//' largest stretch of columns', keeper%selection%rows%stretched)
      stretch = reshape(keeper%selection%rows%stretch, shape(stretch))
      call archive%item(name//' stretch of columns', stretch)
      keeper%selection%rows%stretch(:, :) = reshape(stretch, shape(keeper%selection%rows%stretch))
      call archive%list(name//' changes', keeper%changes)
   end subroutine keeper_through

   !> Notes why a projection failed.
   subroutine give_up(self, reason, info)
      type(projector_t), intent(inout) :: self
      integer, intent(in) :: reason
      integer, intent(out) :: info

      self%reason = reason
      self%worst = 0
      info = rhs_retry
      if (reason == not_converged .or. reason == inconsistent) then
         info = rhs_no_projection
         self%worst = maxloc(abs(self%phi), 1)
         self%residual = abs(self%phi(self%worst))
      end if
   end subroutine give_up

   !> Why the last projection failed, in words.
   subroutine explain(self, model, text)
      !> The projector.
      class(projector_t), intent(in) :: self
      !> The system, asked for the name of a row.
      class(mechanical_system_t), intent(in) :: model
      !> One line.
      character(:), allocatable, intent(out) :: text
      character(:), allocatable :: row

      if (self%worst > 0) call model%row_name(self%worst, row)
      select case (self%reason)
      case (not_converged)
         text = row//' is still violated by '//to_text(self%residual)//' after '// &
                to_text(self%max_iterations)//' iterations'
      case (inconsistent)
         text = 'the constraints are inconsistent: '//row//' stays violated by '// &
                to_text(self%residual)//' and no displacement reduces it (a larger projection_tolerance lets it pass)'
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
