!> A, W and S = A W^-1 A^T at a state, Sect. 3.5 (b): what the projections of Eqs (11a) and (17) solve with.
module taut_constrained_linearization
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   use taut_constrained_completion, only: completion_t
   use taut_constrained_jacobian, only: evaluate_jacobian, kept_entries_t, lay_out_jacobian, take_out_columns
   use taut_constrained_method_options, only: method_t
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_csr, only: csr_t
   use taut_linalg_normal_solver, only: normal_solver_t
   use taut_linalg_normal_solver_choose, only: choose_solver
   use taut_linalg_rank_keeper, only: rank_keeper_t
   use taut_ode_system, only: rhs_ok, rhs_retry
   implicit none (type, external)
   private
   public :: linearization_t, solver_through
   public :: no_reason, not_converged, inconsistent, not_finite, weight_not_positive, wrong_branch

   !> Why a projection failed.
   integer, parameter :: no_reason = 0, not_converged = 1, inconsistent = 2, not_finite = 3, weight_not_positive = 4, &
                         wrong_branch = 5

   !> The matrices and their factors.
   type :: linearization_t
      !> A; phi of the last `evaluate_constraint`: (n_phi); the last displacement of Eq. (16): (n).
      type(csr_t) :: a
      real(wp), allocatable :: phi(:), d(:)
      !> W, factorized; not used if W = I.
      type(block_diagonal_t) :: w
      !> Whether W = I.
      logical :: identity = .true.
      !> What completes a singular M, where W = M.
      type(completion_t) :: completion
      !> W^-1 A^T S^+ with all rows of A, as of the last `factorize`; and which rows are independent.
      class(normal_solver_t), allocatable :: onto
      type(rank_keeper_t) :: keeper
      !> The same of the holonomic rows alone, where there are others.
      class(normal_solver_t), allocatable, private :: onto_holonomic
      type(rank_keeper_t) :: keeper_of_holonomic
      logical :: all_holonomic = .true.
      !> Why the last projection with it failed.
      integer :: reason = no_reason
      !> Velocities along which nothing is moved, and what they give of A v: (n), (c); not allocated: none.
      logical, allocatable :: held(:)
      real(wp), allocatable :: from_held(:)
      logical, private :: w_is_mass = .false., w_ready = .false.
      !> S^+ phi: (n_phi).
      real(wp), allocatable, private :: nu(:)
      type(kept_entries_t), private :: kept
   contains
      procedure, non_overridable :: init
      procedure, non_overridable :: evaluate_constraint
      procedure, non_overridable :: evaluate
      procedure, non_overridable :: renew_weight
      procedure, non_overridable :: factorize
      procedure, non_overridable :: linearize
      procedure, non_overridable :: find_displacement
      procedure, non_overridable :: rows_are_known
      procedure, non_overridable :: project_holonomic
      procedure, non_overridable :: weakest_holonomic
      procedure, non_overridable :: pass_over
      procedure, non_overridable :: release
      procedure, non_overridable :: look
      procedure, non_overridable :: kept_rows
      procedure, non_overridable :: leave_out
      procedure, non_overridable :: keep_rows
      procedure, non_overridable :: divide_by_weight
      procedure, non_overridable :: serialize
   end type linearization_t

contains

   !> Allocates the workspace; nothing is allocated afterwards.
   subroutine init(self, model, method, held)
      !> The linearization.
      class(linearization_t), intent(inout) :: self
      !> The system whose constraints are met.
      class(mechanical_system_t), intent(in) :: model
      !> Weight, solver.
      type(method_t), intent(in) :: method
      !> Velocities along which nothing is moved: (n). Default: none.
      logical, intent(in), optional :: held(:)
      integer, allocatable :: blocks(:), group(:)
      real(wp) :: rcond

      self%identity = method%weight == 'identity'
      self%w_is_mass = method%weight == 'mass'
      self%w_ready = .false.
      self%all_holonomic = model%n_phi == model%c
      if (allocated(self%held)) deallocate (self%held, self%from_held)
      if (present(held)) then
         allocate (self%held, source=held)
         allocate (self%from_held(model%c), source=0.0_wp)
      end if
      call lay_out_jacobian(model, self%a)
      if (allocated(self%phi)) deallocate (self%phi, self%nu, self%d)
      allocate (self%phi(model%n_phi), self%nu(model%n_phi), self%d(model%n), source=0.0_wp)
      if (model%linearizes) call self%kept%init(model, self%a)
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
      if (self%all_holonomic) return
      call choose_solver(method%solver, self%a, model%n_phi, blocks, method%rcond, self%onto_holonomic)
      call self%keeper_of_holonomic%init(self%a, model%n_phi, group, rcond)
   end subroutine init

   !> phi, and the entries of A if they come with it.
   subroutine evaluate_constraint(self, model, at)
      !> The linearization.
      class(linearization_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Its state; its x and t are used.
      type(state_t), intent(in) :: at

      if (model%linearizes) then
         call self%kept%evaluate_constraint(model, at, self%phi)
      else
         call model%constraint(at, self%phi)
      end if
   end subroutine evaluate_constraint

   !> A at a state; what is held has no part in it.
   subroutine evaluate(self, model, at)
      !> The linearization.
      class(linearization_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Its state.
      type(state_t), intent(in) :: at

      if (model%linearizes) then
         call self%kept%give(model, at, self%a)
      else
         call evaluate_jacobian(model, at, self%a)
      end if
      if (allocated(self%held)) call take_out_columns(self%a, self%held, at%v, self%from_held)
   end subroutine evaluate

   !> W at a state, factorized, where W is not the identity.
   subroutine renew_weight(self, model, at, info)
      !> The linearization, with A in place.
      class(linearization_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Its state.
      type(state_t), intent(in) :: at
      !> `rhs_ok`, or `rhs_retry` where W is not positive definite.
      integer, intent(out) :: info

      info = rhs_ok
      if (self%identity) return
      if (self%w_is_mass) then
         if (self%w_ready .and. model%constant_mass .and. .not. self%completion%is_on) return
         call model%mass(at, self%w)
      else
         call model%weight(at, self%w)
      end if
      if (allocated(self%held)) call self%w%decouple(self%held)
      if (self%w_is_mass) then
         call self%completion%factorize(self%w, self%a, info)
      else
         call self%w%factorize(info)
      end if
      self%w_ready = info == 0
      if (info == 0) return
      self%reason = weight_not_positive
      info = rhs_retry
   end subroutine renew_weight

   !> A, W and S = A W^-1 A^T at a state, Sect. 3.5 (b).
   subroutine linearize(self, model, at, info, noise)
      !> The linearization.
      class(linearization_t), intent(inout) :: self
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

   !> W and S = A W^-1 A^T at a state, with A in place.
   subroutine factorize(self, model, at, info, noise)
      !> The linearization.
      class(linearization_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Its state.
      type(state_t), intent(in) :: at
      !> `rhs_ok` or `rhs_retry`.
      integer, intent(out) :: info
      !> Relative error of the rows of A for want of a state that meets the constraints.
      real(wp), intent(in) :: noise

      info = rhs_ok
      if (.not. self%identity) call self%renew_weight(model, at, info)
      if (info /= rhs_ok) return
      call factorize_with(self, self%onto, self%keeper, noise, info)
      if (info == rhs_ok .and. .not. self%all_holonomic) &
         call factorize_with(self, self%onto_holonomic, self%keeper_of_holonomic, noise, info)
      if (info /= rhs_ok) self%reason = not_finite
   end subroutine factorize

   !> S of the rows that are independent.
   subroutine factorize_with(self, onto, keeper, noise, info)
      type(linearization_t), intent(in) :: self
      class(normal_solver_t), intent(inout) :: onto
      type(rank_keeper_t), intent(inout) :: keeper
      real(wp), intent(in) :: noise
      integer, intent(out) :: info

      if (.not. keeper%holds .or. onto%revision /= keeper%revision) call keeper%prepare(self%a, noise, onto)
      call onto%factorize(self%a, self%w, self%identity, info)
      if (info /= 0) info = rhs_retry
   end subroutine factorize_with

   !> d = -W^-1 A^T S^+ phi with the holonomic rows, Eq. (16), with A and W in place.
   subroutine find_displacement(self, renew, noise, first, takes_all, info)
      !> The linearization; the displacement is in `d`.
      class(linearization_t), intent(inout) :: self
      !> Whether S is factorized anew.
      logical, intent(in) :: renew
      !> The relative error of the rows of A then, as of `factorize`.
      real(wp), intent(in) :: noise
      !> Whether no displacement went before.
      logical, intent(in) :: first
      !> Whether it takes off all of phi: no row is left out. Of a second one, none is passed over at a dead point either, but where
      !> there is only one.
      logical, intent(out) :: takes_all
      !> `rhs_ok` or `rhs_retry`.
      integer, intent(out) :: info

      if (self%all_holonomic) then
         call displace_with(self, self%onto, self%keeper, renew, noise, first, takes_all, info)
      else
         call displace_with(self, self%onto_holonomic, self%keeper_of_holonomic, renew, noise, first, takes_all, info)
      end if
   end subroutine find_displacement

   !> The same with a solver.
   subroutine displace_with(self, onto, keeper, renew, noise, first, takes_all, info)
      type(linearization_t), intent(inout) :: self
      class(normal_solver_t), intent(inout) :: onto
      type(rank_keeper_t), intent(inout) :: keeper
      logical, intent(in) :: renew, first
      real(wp), intent(in) :: noise
      logical, intent(out) :: takes_all
      integer, intent(out) :: info

      info = rhs_ok
      takes_all = .false.
      if (renew) call factorize_with(self, onto, keeper, noise, info)
      if (info /= rhs_ok) return
      self%d(:) = 0.0_wp
      call onto%multipliers(self%phi, self%nu)
      call onto%correction(self%a, self%nu, self%d)
      takes_all = onto%rank == onto%c
      if (takes_all .and. onto%c > 1 .and. .not. first) takes_all = onto%weakest() > 0.0_wp
   end subroutine displace_with

   !> Whether it is decided which of the holonomic rows are independent, so that errors of A have no part in it.
   pure logical function rows_are_known(self)
      !> The linearization.
      class(linearization_t), intent(in) :: self

      if (self%all_holonomic) then
         rows_are_known = self%keeper%holds
      else
         rows_are_known = self%keeper_of_holonomic%holds
      end if
   end function rows_are_known

   !> u := u - W^-1 A^T mu with A u = b in the holonomic rows, after `factorize`.
   subroutine project_holonomic(self, b, u, r, mu)
      !> The linearization.
      class(linearization_t), intent(inout) :: self
      !> What A u shall be: (n_phi).
      real(wp), intent(in) :: b(size(self%phi))
      !> A vector, replaced: (n).
      real(wp), intent(inout) :: u(self%a%n)
      !> A u - b before: (n_phi).
      real(wp), intent(inout) :: r(size(self%phi))
      !> Multipliers: (n_phi).
      real(wp), intent(inout) :: mu(size(self%phi))

      if (self%all_holonomic) then
         call self%onto%project(self%a, b, u, r, mu)
      else
         call self%onto_holonomic%project(self%a, b, u, r, mu)
      end if
   end subroutine project_holonomic

   !> The smallest pivot of the holonomic rows: 0 if one was passed over.
   function weakest_holonomic(self) result(pivot)
      !> The linearization, after `find_displacement`.
      class(linearization_t), intent(in) :: self
      !> Between 0 and 1.
      real(wp) :: pivot

      if (self%all_holonomic) then
         pivot = self%onto%weakest()
      else
         pivot = self%onto_holonomic%weakest()
      end if
   end function weakest_holonomic

   !> States which pivots of holonomic rows are passed over.
   subroutine pass_over(self, cut, before)
      !> The linearization.
      class(linearization_t), intent(inout) :: self
      !> Up to this.
      real(wp), intent(in) :: cut
      !> Up to which so far.
      real(wp), intent(out), optional :: before

      if (self%all_holonomic) then
         if (present(before)) before = self%onto%cut
         call self%onto%pass_over(cut)
      else
         if (present(before)) before = self%onto_holonomic%cut
         call self%onto_holonomic%pass_over(cut)
      end if
   end subroutine pass_over

   !> Lets the decision go which rows are independent.
   subroutine release(self)
      !> The linearization.
      class(linearization_t), intent(inout) :: self

      call self%keeper%release()
      call self%keeper_of_holonomic%release()
   end subroutine release

   !> Looks at the rank where a step was accepted.
   subroutine look(self, t, violation)
      !> The linearization there, after `factorize`.
      class(linearization_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> By how much the constraints are violated, relative to the size of the coordinates.
      real(wp), intent(in) :: violation

      call self%keeper%look(self%a, self%onto, t, violation)
      if (.not. self%all_holonomic) call self%keeper_of_holonomic%look(self%a, self%onto_holonomic, t, violation)
   end subroutine look

   !> Which rows of A are independent of each other, after `linearize`.
   subroutine kept_rows(self, kept)
      !> The linearization.
      class(linearization_t), intent(in) :: self
      !> Whether a row is one of them: (c).
      logical, intent(out) :: kept(:)

      kept(:) = self%keeper%kept
   end subroutine kept_rows

   !> Which rows come to depend on the others on the way to another state.
   subroutine leave_out(self, there, kept)
      !> The linearization, after `linearize`.
      class(linearization_t), intent(inout) :: self
      !> A at the other state.
      type(csr_t), intent(in) :: there
      !> The rows that are kept so far, those that do taken off: (c).
      logical, intent(inout) :: kept(:)

      call self%keeper%selection%leave_out(self%a, there, kept)
   end subroutine leave_out

   !> S of fewer rows, until the next `linearize`.
   subroutine keep_rows(self, kept, info)
      !> The linearization, after `linearize`.
      class(linearization_t), intent(inout) :: self
      !> The rows: (c).
      logical, intent(in) :: kept(:)
      !> `rhs_ok` or `rhs_retry`.
      integer, intent(out) :: info

      call factorize_rows(self%onto, kept)
      if (info == 0 .and. .not. self%all_holonomic) call factorize_rows(self%onto_holonomic, kept(:self%onto_holonomic%c))
      info = merge(rhs_ok, rhs_retry, info == 0)

   contains

      subroutine factorize_rows(onto, rows)
         class(normal_solver_t), intent(inout) :: onto
         logical, intent(in) :: rows(:)

         call onto%keep_for_now(rows)
         call onto%factorize(self%a, self%w, self%identity, info)
      end subroutine factorize_rows

   end subroutine keep_rows

   !> u := W^-1 u, after `linearize`.
   subroutine divide_by_weight(self, u)
      !> The linearization.
      class(linearization_t), intent(inout) :: self
      !> A vector: (n).
      real(wp), intent(inout), contiguous :: u(:)

      if (.not. self%identity) call self%w%solve(1, u)
   end subroutine divide_by_weight

   !> Passes through an archive what is remembered of the rank from one step to the next.
   subroutine serialize(self, archive)
      !> The linearization.
      class(linearization_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      call keeper_through(archive, 'rank', self%keeper, self%onto)
      if (.not. self%all_holonomic) &
         call keeper_through(archive, 'rank of holonomic rows', self%keeper_of_holonomic, self%onto_holonomic)
   end subroutine serialize

   !> The same for one of the two, with what its solver has learned of the rows.
   subroutine keeper_through(archive, name, keeper, onto)
      type(archive_t), intent(inout) :: archive
      character(*), intent(in) :: name
      type(rank_keeper_t), intent(inout) :: keeper
      class(normal_solver_t), intent(inout) :: onto
      real(wp) :: kept(size(keeper%kept)), stretch(size(keeper%selection%rows%stretch))

      call archive%item(name//' is held', keeper%holds)
      call archive%item(name//' before', keeper%rank_before)
      call archive%item(name//' at a dead point', keeper%dead)
      call archive%item(name//' rising', keeper%rising)
      call archive%item(name//' smallest pivot', keeper%first_pivot)
      kept = merge(1.0_wp, 0.0_wp, keeper%kept)
      call archive%item(name//' is made of rows', kept)
      call keeper%restore(kept > 0.0_wp)
      call archive%item(name//' selection', keeper%revision)
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
      call solver_through(archive, name, onto)
   end subroutine keeper_through

   !> Passes through an archive which rows a solver keeps, and what it has learned of them; it factorizes anew.
   subroutine solver_through(archive, name, solver)
      !> The archive.
      type(archive_t), intent(inout) :: archive
      !> What of.
      character(*), intent(in) :: name
      !> The solver, initialized.
      class(normal_solver_t), intent(inout) :: solver
      integer :: revision
      logical :: is_new
      real(wp) :: cut, kept(solver%c)

      kept = merge(1.0_wp, 0.0_wp, solver%kept)
      revision = solver%revision
      is_new = solver%is_new
      cut = solver%cut
      call archive%item(name//' solver has rows', kept)
      call archive%item(name//' solver has selection', revision)
      call archive%item(name//' solver is new', is_new)
      call archive%item(name//' solver passes over', cut)
      call archive%item(name//' solver refines', solver%refinements)
      call archive%item(name//' solver had selection', solver%revision_before)
      call archive%item(name//' solver passed over', solver%cut_before)
      if (.not. archive%reading .or. allocated(archive%error)) return
      call solver%keep(kept > 0.0_wp)
      solver%revision = revision
      solver%is_new = is_new
      call solver%pass_over(cut)
   end subroutine solver_through

end module taut_constrained_linearization
