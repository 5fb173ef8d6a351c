!> Minimal coordinates, Eq. (3): the motion in as many velocities as there are degrees of freedom, without multipliers.
!!
!! Velocities nu = B^T v are independent, with a B that stays while it fits (`taut_constrained_complement`). All others follow
!! from A v = b'; with vdot = A^+ b'' + Q c, A Q = 0, Eq. (3) reads Q^T M Q c = Q^T (f - M A^+ b''), whatever makes the columns
!! of Q. The state is {x; v; w} all the same: of v only B^T v counts, the rest is what follows from it, so that another B
!! changes nothing of the state. Velocities meet their constraints whatever is integrated; positions are the integrals of the
!! velocities and drift (Sect. 1), unless they are projected: what `stage_projection` and `state_projection` say.
!!
!! Reactions, which Eq. (3) does without, are those that balance it: A^T lambda = f - M vdot.
!!
!! Sources: Sect. 1 of the paper; for B = a basis of the null space where it was chosen, tangent coordinates, F.A. Potra, W.C.
!! Rheinboldt, On the numerical solution of Euler-Lagrange equations, Mech. Struct. Mach. 19 (1991) 1-18; for single velocities by
!! pivots, coordinate partitioning, R.A. Wehage, E.J. Haug, J. Mech. Des. 104 (1982) 247-255.
module taut_constrained_method_minimal_coordinates
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   use taut_error, only: error_t, to_text
   use taut_constrained_complement, only: complement_t
   use taut_constrained_method, only: constrained_ode_t
   use taut_linalg_lapack, only: dpotrf, dpotrs
   use taut_ode_system, only: evaluated_step_end, inside_step, rhs_no_projection, rhs_ok, rhs_retry
   implicit none (type, external)
   private
   public :: minimal_coordinates_t

   !> Independent velocities are chosen anew where their smallest pivot has fallen to this part of what it was: the others are
   !! then determined half as well as at best.
   real(wp), parameter :: worn = 0.25_wp

   !> The method `minimal-coordinates`.
   type, extends(constrained_ode_t) :: minimal_coordinates_t
      !> Which velocities are independent.
      type(complement_t) :: complement
      !> Whether they are chosen, whether they stay, and whether along a basis of the null space.
      logical :: chosen = .false., keeps = .false., basis = .true.
      !> Whether x is projected before each evaluation.
      logical :: projects_stages = .true.
      !> How well they fit at the end of the last step; how often they were replaced, and when first [s].
      real(wp) :: fit = 1.0_wp, first_switch = 0.0_wp
      integer :: switches = 0
      !> Q^T M Q, its right-hand side, A^+ b'', M times a vector, and a velocity: (n, n), (n).
      real(wp), allocatable, private :: reduced(:, :), c(:), particular(:), weighted(:), given(:)
   contains
      procedure :: set_up
      procedure :: rhs
      procedure :: find_positions
      procedure :: fit_complement
      procedure :: accelerate
      procedure :: project
      procedure :: filter_error
      procedure :: accepted
      procedure :: multipliers
      procedure :: own_failure
      procedure :: own_remark
      procedure :: serialize_own
   end type minimal_coordinates_t

contains

   !> Reads the options and makes room.
   subroutine set_up(self, error)
      !> The formulation.
      class(minimal_coordinates_t), intent(inout) :: self
      !> More velocities than full matrices are good for.
      type(error_t), allocatable, intent(inout) :: error
      integer :: n

      n = self%model%n
      call self%refuse_large(error)
      if (allocated(error)) return
      self%carries_reactions = .false.
      self%basis = self%options%independent /= 'partitioning'
      self%keeps = self%options%independent == 'constant'
      self%projects_stages = self%options%stage_projection == 'newton'
      self%replaces = self%options%state_projection /= 'none'
      self%rhs_projects = self%projects_stages .or. .not. self%replaces
      self%finds_mu = .true.
      call self%complement%init(n)
      allocate (self%reduced(n, n), self%c(n), self%particular(n), self%weighted(n), self%given(n), source=0.0_wp)
   end subroutine set_up

   !> Eq. (3).
   subroutine rhs(self, t, y, dydt, info)
      !> The formulation.
      class(minimal_coordinates_t), intent(inout) :: self
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
      associate (model => self%model, at => self%at, projector => self%projector, &
                 xdot => dydt(:n_x), vdot => dydt(n_x + 1:last_v), wdot => dydt(last_v + 1:))
         call self%unpack(t, y, at)
         call self%find_positions(self%projects_stages, info)
         if (info == rhs_ok) call meet_rates(self, info)
         if (info /= rhs_ok) return
         call model%acceleration_rhs(at, self%b_second)
         call self%mass%renew(model, at, info, projector)
         if (info /= rhs_ok) return
         call model%force(at, self%force)
         call self%accelerate(vdot, info)
         if (info /= rhs_ok) return
         if (self%has_integral) call find_own_power(self, vdot)
         call model%x_rate(at, at%v, xdot)
         if (model%n_w > 0) call model%w_rate(at, wdot)
      end associate
   end subroutine rhs

   !> Power of the system's own, and of its drives: v^T (M vdot - f), with no multipliers at hand.
   subroutine find_own_power(self, vdot)
      type(minimal_coordinates_t), intent(inout) :: self
      real(wp), intent(in), contiguous :: vdot(:)
      real(wp) :: completed(size(self%b_second))

      call self%mass%multiply(self%projector, vdot, self%weighted)
      completed(:) = 0.0_wp
      call self%mass%complete(self%projector, self%b_second, completed)
      self%integrand = self%model%power(self%at) + dot_product(self%at%v, self%weighted - self%force) - &
                       dot_product(self%projector%b_prime, completed)
   end subroutine find_own_power

   !> x by Eq. (17), or without projection only what belongs to the coordinates by themselves.
   subroutine find_positions(self, projects, info)
      !> The formulation, with the state in place.
      class(minimal_coordinates_t), intent(inout) :: self
      !> Whether it is projected.
      logical, intent(in) :: projects
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      info = rhs_ok
      if (projects) then
         call self%projector%position(self%model, self%at, info)
         if (info == rhs_no_projection) call self%projector%position_again(self%model, self%at, info)
      else
         call self%model%normalize(self%at%x)
      end if
   end subroutine find_positions

   !> Eq. (3) at the state, with A^+ b'' and what of the force it leaves.
   subroutine accelerate(self, vdot, info)
      !> The formulation, with the state, A, M, b'' and the force in place.
      class(minimal_coordinates_t), intent(inout) :: self
      !> The accelerations: (n).
      real(wp), intent(inout), contiguous :: vdot(:)
      !> One of the `rhs_` constants.
      integer, intent(out) :: info
      integer :: i, j, m

      associate (projector => self%projector, q => self%complement%q)
         self%particular(:) = 0.0_wp
         call projector%meet(self%b_second, self%particular)
         call self%mass%multiply(projector, self%particular, self%weighted)
         self%weighted(:) = self%force - self%weighted
         m = self%complement%m
         do j = 1, m
            self%c(j) = dot_product(q(:, j), self%weighted)
         end do
         do j = 1, m
            call self%mass%multiply(projector, q(:, j), self%weighted)
            do i = j, m
               self%reduced(i, j) = dot_product(q(:, i), self%weighted)
            end do
         end do
         call dpotrf('L', m, self%reduced, size(self%reduced, 1), info)
         if (info /= 0) then
            info = rhs_retry
            return
         end if
         call dpotrs('L', m, 1, self%reduced, size(self%reduced, 1), self%c, size(self%c), info)
         vdot(:) = self%particular
         do j = 1, m
            vdot(:) = vdot + q(:, j)*self%c(j)
         end do
         self%given(:) = vdot
      end associate
      info = rhs_ok
   end subroutine accelerate

   !> The velocities that the independent ones of `at` give at its x.
   subroutine meet_rates(self, info)
      class(minimal_coordinates_t), intent(inout) :: self
      integer, intent(out) :: info

      associate (model => self%model, at => self%at, projector => self%projector)
         call projector%linear%linearize(model, at, info, 0.0_wp)
         if (info /= rhs_ok) return
         call self%fit_complement(info)
         if (info /= rhs_ok) return
         self%given(:) = at%v
         call projector%velocity(model, at)
         call self%complement%restore(self%given, at%v)
      end associate
   end subroutine meet_rates

   !> What follows from the independent velocities where A is. A rank that was lower where they were chosen, as at a start in a
   !! singular position, asks for others at once.
   subroutine fit_complement(self, info)
      !> The formulation, linearized.
      class(minimal_coordinates_t), intent(inout) :: self
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      info = rhs_ok
      if (self%chosen) call self%complement%renew(self%model, self%projector, info)
      if (.not. self%chosen .or. (info /= rhs_ok .and. .not. self%keeps)) &
         call self%complement%choose(self%model, self%projector, self%basis, info)
      if (info == rhs_ok) self%chosen = .true.
   end subroutine fit_complement

   !> Replaces v by what the independent velocities give, and x by Eq. (17) unless it is to drift.
   subroutine project(self, t, y, place, stale, info)
      !> The formulation.
      class(minimal_coordinates_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State {x; v; w}, replaced: (size).
      real(wp), intent(inout), contiguous :: y(:)
      !> `inside_step`, `step_end` or `evaluated_step_end`.
      integer, intent(in) :: place
      !> False: the right-hand side holds for the new state too, or is evaluated there.
      logical, intent(out) :: stale
      !> One of the `rhs_` constants.
      integer, intent(out) :: info
      integer :: n_x

      stale = .false.
      info = rhs_ok
      n_x = self%model%n_x
      if (place /= evaluated_step_end) then
         call self%unpack(t, y, self%at)
         call self%find_positions(self%projects_stages .or. self%replaces, info)
         if (info == rhs_ok) call meet_rates(self, info)
      end if
      if (info == rhs_ok .and. place /= inside_step .and. self%replaces) &
         call self%projector%check_branch(self%model, self%at, info)
      if (info /= rhs_ok) return
      if (self%replaces) y(:n_x) = self%at%x
      call self%model%normalize(y(:n_x))
      y(n_x + 1:n_x + self%model%n) = self%at%v
      if (place == inside_step) return
      self%fit = self%complement%fit
      call self%remember()
   end subroutine project

   !> Leaves of the local error what it is in independent velocities, and of positions what no projection takes off.
   subroutine filter_error(self, error)
      !> The formulation.
      class(minimal_coordinates_t), intent(inout) :: self
      !> Estimate of the local error: (size).
      real(wp), intent(inout), contiguous :: error(:)
      integer :: n_x

      n_x = self%model%n_x
      if (self%replaces) call self%projector%filter_position(self%model, self%at, error(:n_x))
      call self%complement%tangential(error(n_x + 1:n_x + self%model%n))
   end subroutine filter_error

   !> Chooses other independent velocities where those at hand no longer fit: the state stays as it is, but what its
   !! derivative is beside the constraints does not.
   subroutine accepted(self, t, y, replaced)
      !> The formulation.
      class(minimal_coordinates_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State {x; v; w}: (size).
      real(wp), intent(inout), contiguous :: y(:)
      !> Whether others were chosen.
      logical, intent(out) :: replaced
      integer :: info, revision

      replaced = .false.
      if (self%model%c < 2 .and. self%fit > worn) return
      info = rhs_ok
      if (.not. self%is_at(t, y)) then
         call self%unpack(t, y, self%at)
         call self%projector%linear%linearize(self%model, self%at, info, 0.0_wp)
         if (info /= rhs_ok) return
      end if
      revision = self%projector%linear%keeper%revision
      if (self%model%c > 1) call self%projector%look(self%model, self%at)
      if (self%keeps .or. (self%fit > worn .and. self%projector%linear%keeper%revision == revision)) return
      call self%projector%linear%linearize(self%model, self%at, info, 0.0_wp)
      if (info == rhs_ok) call self%complement%choose(self%model, self%projector, self%basis, info)
      if (info /= rhs_ok) return
      replaced = .true.
      self%fit = 1.0_wp
      self%switches = self%switches + 1
      if (self%switches == 1) self%first_switch = t
   end subroutine accepted

   !> lambda with A^T lambda = f - M vdot, of least norm.
   subroutine multipliers(self, lambda)
      !> The formulation, as `rhs` left it.
      class(minimal_coordinates_t), intent(inout) :: self
      !> Those of the last evaluation: (c).
      real(wp), intent(inout), contiguous :: lambda(:)

      call self%mass%multiply(self%projector, self%given, self%weighted)
      self%weighted(:) = self%force - self%weighted
      call self%projector%balance(self%weighted, lambda)
      call self%mass%complete(self%projector, self%b_second, lambda)
   end subroutine multipliers

   !> Whether the independent velocities are what the last failure was about.
   subroutine own_failure(self, text)
      !> The formulation.
      class(minimal_coordinates_t), intent(in) :: self
      !> One line.
      character(:), allocatable, intent(out) :: text

      text = ''
      if (self%keeps .and. self%complement%fit <= 0.0_wp) &
         text = 'the independent velocities of the start do not determine the others here; independent = "null-space" '// &
                'chooses others'
   end subroutine own_failure

   !> How often other velocities were chosen.
   subroutine own_remark(self, text)
      !> The formulation, behind a run.
      class(minimal_coordinates_t), intent(in) :: self
      !> One line, may be empty.
      character(:), allocatable, intent(out) :: text

      text = ''
      if (self%switches > 0) text = 'independent velocities chosen anew '//to_text(self%switches)//' times from t = '// &
                                    to_text(self%first_switch)//' s on'
   end subroutine own_remark

   !> Passes through an archive what is remembered from one step to the next.
   subroutine serialize_own(self, archive)
      !> The formulation.
      class(minimal_coordinates_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      call archive%item('velocities chosen', self%chosen)
      call archive%item('fit at the last step', self%fit)
      call archive%item('switches', self%switches)
      call archive%item('first switch', self%first_switch)
      call self%complement%serialize(archive)
   end subroutine serialize_own

end module taut_constrained_method_minimal_coordinates
