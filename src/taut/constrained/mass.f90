!> M where a system is, and the reduced mass matrix M~ = (A M^-1 A^T)^+ of Eq. (20), with what they give: accelerations,
!! multipliers, corrections.
module taut_constrained_mass
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   use taut_constrained_completion, only: completion_t
   use taut_constrained_linearization, only: solver_through
   use taut_constrained_method_options, only: method_t
   use taut_constrained_projection, only: projector_t
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_constrained_system_tables, only: velocity_name
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_normal_solver, only: normal_solver_t
   use taut_linalg_normal_solver_choose, only: choose_solver
   use taut_ode_system, only: rhs_ok, rhs_retry
   implicit none (type, external)
   private
   public :: mass_t

   !> M, factorized, and M~. Where the projector of the velocities has the same matrices, they are not made again: with W = M, and
   !! with W = I of M = m I, where M~ = m (A W^-1 A^T)^+.
   type :: mass_t
      !> Whether both are known for good: nothing is left to `renew` and `reduce`.
      logical :: stays = .false.
      !> Velocities and constraints.
      integer, private :: n = 0, c = 0
      type(block_diagonal_t), private :: m
      type(completion_t), private :: completion
      class(normal_solver_t), allocatable, private :: reduced
      !> Whether M was found and is positive definite; whether it never changes.
      logical, private :: known = .false., constant = .true.
      !> Whether M~ was ever made.
      logical, private :: is_reduced = .false.
      !> Row where M is not positive definite.
      integer, private :: bad_row = 0
      !> Whether the projector's W is M; whether it is I, so that one number may do.
      logical, private :: is_weight = .false., weight_is_identity = .false.
      !> The m of M = m I if the projector serves; otherwise 0.
      real(wp), private :: uniform = 0.0_wp
      !> Violation A a - b'': (c).
      real(wp), allocatable, private :: r(:)
   contains
      procedure, non_overridable :: init
      procedure, non_overridable :: init_reduced
      procedure, non_overridable :: renew
      procedure, non_overridable :: reduce
      procedure, non_overridable :: look
      procedure, non_overridable :: accelerate
      procedure, non_overridable :: multiply
      procedure, non_overridable :: correct_acceleration
      procedure, non_overridable :: correct_force
      procedure, non_overridable :: complete
      procedure, non_overridable :: least_norm
      procedure, non_overridable :: weakest
      procedure, non_overridable :: explain
      procedure, non_overridable :: serialize
   end type mass_t

contains

   !> Makes room for M.
   subroutine init(self, model)
      !> The mass matrix.
      class(mass_t), intent(out) :: self
      !> Whose mass it is.
      class(mechanical_system_t), intent(in) :: model

      self%n = model%n
      self%c = model%c
      call self%m%init(model%mass_blocks)
      self%constant = model%constant_mass
      allocate (self%r(model%c), source=0.0_wp)
   end subroutine init

   !> Makes room for M~.
   subroutine init_reduced(self, model, method, projector, same_place)
      !> The mass matrix, with room for M.
      class(mass_t), intent(inout) :: self
      !> Whose mass it is.
      class(mechanical_system_t), intent(in) :: model
      !> Weight and solver.
      type(method_t), intent(in) :: method
      !> The projector of the velocities.
      type(projector_t), intent(in) :: projector
      !> Whether accelerations are corrected at the state where velocities are, so that the projector's matrices serve.
      logical, intent(in) :: same_place

      self%is_weight = same_place .and. method%weight == 'mass'
      self%stays = self%is_weight
      self%weight_is_identity = same_place .and. method%weight == 'identity'
      if (.not. self%is_weight) &
         call choose_solver(method%solver, projector%linear%a, model%c, model%mass_blocks, method%rcond, self%reduced)
   end subroutine init_reduced

   !> M at a state, factorized.
   subroutine renew(self, model, at, info, projector)
      !> The mass matrix.
      class(mass_t), intent(inout) :: self
      !> Whose mass it is.
      class(mechanical_system_t), intent(in) :: model
      !> The state at which it is evaluated.
      type(state_t), intent(in) :: at
      !> `rhs_ok`, or `rhs_retry` where M is not positive definite.
      integer, intent(out) :: info
      !> The projector, with A there, where it may complete a singular M. Default: M has to be definite by itself.
      type(projector_t), intent(in), optional :: projector

      info = rhs_ok
      if (self%is_weight .or. (self%known .and. self%constant .and. .not. self%completion%is_on)) return
      call model%mass(at, self%m)
      if (present(projector)) then
         call self%completion%factorize(self%m, projector%linear%a, self%bad_row)
      else
         call self%m%factorize(self%bad_row)
      end if
      self%known = self%bad_row == 0
      self%uniform = 0.0_wp
      if (.not. self%known) then
         info = rhs_retry
      else if (self%m%diagonal .and. self%weight_is_identity) then
         if (all(abs(self%m%values - self%m%values(1)) <= 0.0_wp)) self%uniform = self%m%values(1)
         self%stays = self%uniform > 0.0_wp .and. self%constant .and. .not. self%completion%is_on
      end if
   end subroutine renew

   !> M~ for the A of the projector, after `renew`.
   subroutine reduce(self, projector, info)
      !> The mass matrix.
      class(mass_t), intent(inout) :: self
      !> The projector, with A where M is and its independent rows.
      type(projector_t), intent(in) :: projector
      !> `rhs_ok`, or `rhs_retry` where there are entries that are not finite.
      integer, intent(out) :: info

      info = rhs_ok
      if (self%is_weight .or. self%uniform > 0.0_wp) return
      if (self%reduced%revision /= projector%linear%keeper%revision) call projector%linear%keeper%hand_over(self%reduced)
      call self%reduced%factorize(projector%linear%a, self%m, .false., info)
      self%is_reduced = info == 0
      if (info /= 0) info = rhs_retry
   end subroutine reduce

   !> Looks at the rank where a step was accepted, for methods that have no other use of the projector.
   subroutine look(self, model, at, projector)
      !> The mass matrix, after `reduce`.
      class(mass_t), intent(inout) :: self
      !> Whose mass it is.
      class(mechanical_system_t), intent(in) :: model
      !> The state that was accepted.
      type(state_t), intent(in) :: at
      !> The projector, with A.
      type(projector_t), intent(inout) :: projector

      call projector%look(model, at, self%reduced)
   end subroutine look

   !> a = M^-1 f: the accelerations that forces give.
   subroutine accelerate(self, projector, f, a)
      !> The mass matrix.
      class(mass_t), intent(in) :: self
      !> The projector, for W = M.
      type(projector_t), intent(in) :: projector
      !> Forces: (n).
      real(wp), intent(in) :: f(self%n)
      !> Accelerations: (n).
      real(wp), intent(inout) :: a(self%n)

      if (self%is_weight) then
         call projector%linear%w%solve_vector(f, a)
      else
         call self%m%solve_vector(f, a)
      end if
   end subroutine accelerate

   !> f = M a: the forces that accelerations take.
   subroutine multiply(self, projector, a, f)
      !> The mass matrix.
      class(mass_t), intent(in) :: self
      !> The projector, for W = M.
      type(projector_t), intent(in) :: projector
      !> Accelerations: (n).
      real(wp), intent(in) :: a(self%n)
      !> Forces: (n).
      real(wp), intent(out) :: f(self%n)

      if (self%is_weight) then
         call projector%linear%w%multiply(a, f)
      else
         call self%m%multiply(a, f)
      end if
   end subroutine multiply

   !> lambda = M~ (A a - b''), Eq. (14b), and a := a - M^-1 A^T lambda, Eq. (11b) and Sect. 3.5 (h).
   subroutine correct_acceleration(self, projector, b_second, a, lambda)
      !> The mass matrix.
      class(mass_t), intent(inout) :: self
      !> The projector, with A, for W = M or M = m I.
      type(projector_t), intent(inout) :: projector
      !> b'': (c).
      real(wp), intent(in) :: b_second(self%c)
      !> Accelerations M^-1 f, corrected: (n).
      real(wp), intent(inout) :: a(self%n)
      !> Multipliers: (c).
      real(wp), intent(inout) :: lambda(self%c)

      call find_multipliers(self, projector, b_second, a, lambda)
      if (self%completion%is_on .or. projector%linear%completion%is_on) call self%complete(projector, b_second, lambda)
   end subroutine correct_acceleration

   !> The same of what may be a completed M.
   subroutine find_multipliers(self, projector, b_second, a, lambda)
      class(mass_t), intent(inout) :: self
      type(projector_t), intent(inout) :: projector
      real(wp), intent(in) :: b_second(self%c)
      real(wp), intent(inout) :: a(self%n), lambda(self%c)
      integer :: i

      if (self%uniform > 0.0_wp) then
         call projector%linear%onto%project(projector%linear%a, b_second, a, self%r, lambda)
         !GCC$ unroll 1
         do i = 1, self%c
            lambda(i) = self%uniform*lambda(i)
         end do
      else if (self%is_weight) then
         call projector%linear%onto%project(projector%linear%a, b_second, a, self%r, lambda)
      else
         call self%reduced%project(projector%linear%a, b_second, a, self%r, lambda)
      end if
   end subroutine find_multipliers

   !> lambda = M~ (A M^-1 f - b''), Eq. (14b), and f := f - A^T lambda, Eq. (19b) and Sect. 3.5 (g), with the accelerations that
   !! this force gives.
   subroutine correct_force(self, projector, b_second, f, a, lambda)
      !> The mass matrix.
      class(mass_t), intent(inout) :: self
      !> The projector, with A, for W = M or M = m I.
      type(projector_t), intent(inout) :: projector
      !> b'': (c).
      real(wp), intent(in) :: b_second(self%c)
      !> Forces, corrected: (n).
      real(wp), intent(inout) :: f(self%n)
      !> Accelerations M^-1 f, those of the corrected forces on return: (n).
      real(wp), intent(inout) :: a(self%n)
      !> Multipliers: (c).
      real(wp), intent(inout) :: lambda(self%c)

      call find_multipliers(self, projector, b_second, a, lambda)
      call projector%linear%a%subtract_transposed(lambda, f)
      call self%accelerate(projector, f, a)
      if (self%completion%is_on .or. projector%linear%completion%is_on) call self%complete(projector, b_second, lambda)
   end subroutine correct_force

   !> Multipliers of the equations as they are given, where a singular M was completed.
   pure subroutine complete(self, projector, b_second, lambda)
      !> The mass matrix.
      class(mass_t), intent(in) :: self
      !> The projector, for W = M.
      type(projector_t), intent(in) :: projector
      !> b'': (c).
      real(wp), intent(in), contiguous :: b_second(:)
      !> Multipliers, replaced: (c).
      real(wp), intent(inout), contiguous :: lambda(:)

      if (self%is_weight) then
         call projector%linear%completion%add_rates(b_second, lambda)
      else
         call self%completion%add_rates(b_second, lambda)
      end if
   end subroutine complete

   !> The multipliers of least norm among those with the same A^T lambda.
   subroutine least_norm(self, projector, lambda)
      !> The mass matrix.
      class(mass_t), intent(inout) :: self
      !> The projector, for W = M or M = m I.
      type(projector_t), intent(inout) :: projector
      !> Multipliers: (c).
      real(wp), intent(inout), contiguous :: lambda(:)

      if (self%is_weight .or. self%uniform > 0.0_wp) then
         call projector%linear%onto%minimum_norm(lambda)
      else
         call self%reduced%minimum_norm(lambda)
      end if
   end subroutine least_norm

   !> The smallest pivot of A M^-1 A^T, by which errors of multipliers grow.
   pure real(wp) function weakest(self, projector) result(pivot)
      !> The mass matrix, after `reduce`; without it nothing is known of a pivot.
      class(mass_t), intent(in) :: self
      !> The projector, for W = M or M = m I.
      type(projector_t), intent(in) :: projector

      pivot = 1.0_wp
      if (self%c < 2) return
      if (self%is_weight .or. self%uniform > 0.0_wp) then
         pivot = projector%linear%onto%weakest()
      else if (self%is_reduced) then
         pivot = self%reduced%weakest()
      end if
   end function weakest

   !> Why the last `renew` failed, in words; empty if it did not.
   subroutine explain(self, model, text)
      !> The mass matrix.
      class(mass_t), intent(in) :: self
      !> The system, asked for the name of a velocity.
      class(mechanical_system_t), intent(in) :: model
      !> One line.
      character(:), allocatable, intent(out) :: text

      text = ''
      if (self%bad_row > 0) text = 'the mass matrix is not positive definite at '// &
                                     trim(velocity_name(model, self%bad_row))//': one that is singular '// &
                                     'needs one dense block, A without a pattern and a method with multipliers'
   end subroutine explain

   !> Passes through an archive what is remembered of the rank from one step to the next.
   subroutine serialize(self, archive)
      !> The mass matrix.
      class(mass_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      if (allocated(self%reduced)) call solver_through(archive, 'reduced mass', self%reduced)
   end subroutine serialize

end module taut_constrained_mass
