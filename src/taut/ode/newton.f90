!> Newton's method, simplified, for the equations of implicit steppers: matrices that are kept as long as they serve, and the
!! decision when an iteration has converged.
!!
!! Source: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., Springer 1996, Sect. IV.8.
module taut_ode_newton
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   use taut_ode_stage_equations, only: plain_equations_t
   use taut_ode_step_control, only: step_control_t
   use taut_ode_stepper, only: work_t
   use taut_ode_system, only: no_trouble, not_converged, not_factorized, not_linearized, ode_system_t, rhs_cannot, rhs_failed, &
                              rhs_not_solved, rhs_ok, rhs_retry, stage_equations_t
   implicit none (type, external)
   private
   public :: newton_t, most_iterations, good_contraction, spread_evenly

   !> Iterations at the most.
   integer, parameter :: most_iterations = 10
   !> The contraction of the step before is not trusted to be better than this where one iteration is to be enough.
   real(wp), parameter :: least_trust = 1.0e-2_wp
   !> Contraction up to which a Jacobian is kept for the next step.
   real(wp), parameter :: good_contraction = 0.3_wp
   !> An iteration whose corrections are this large, in units of the tolerance, has gone astray.
   real(wp), parameter :: hopeless = 1.0e30_wp

   !> A state with its derivative and algebraic unknowns.
   type :: place_t
      real(wp) :: t = 0.0_wp
      real(wp), allocatable :: y(:), ydot(:), z(:)
   contains
      procedure :: serialize => serialize_place
   end type place_t

   !> The equations, the matrices for them, and how the iteration goes.
   type :: newton_t
      !> What is solved; allocated by `meet`.
      class(stage_equations_t), allocatable :: equations
      !> How fast the iteration contracts.
      real(wp) :: contraction = 1.0_wp
      !> Iterations of the last step.
      integer :: used = 0
      !> Whether there is a Jacobian, and whether it was built for this very step.
      logical :: has_jacobian = .false., fresh = .false.
      !> Whether the equations hold something for the sake of the present step.
      logical :: yields = .false.
      !> Whether round-off has ended the iteration with corrections that the tolerance of errors would notice.
      logical :: doubtful = .false.
      !> What went wrong last, and the entry of y that was the worst then.
      integer, private :: trouble = no_trouble, worst = 0
      !> By how much the iteration is still off after its last correction, in units of that; the step of the factors.
      real(wp), private :: eta = 1.0_wp, h_factors = 0.0_wp
      real(wp), private :: change_before = 0.0_wp, tolerance = 0.0_wp
      !> The largest correction that round-off is taken for: where equations are singular it is the root of it.
      real(wp) :: most_round_off = 1.0_wp
      !> Contraction and eta before this iteration.
      real(wp), private :: contraction_before = 1.0_wp, eta_before = 1.0_wp
      !> Where the Jacobian was built, and where what of it costs little was brought since, if it was, and in this very step.
      real(wp), private :: h_jacobian = 0.0_wp
      type(place_t), private :: jacobian, refreshed
      logical, private :: has_refreshed = .false., current = .false.
      !> What the equations remembered where a restart has begun, for those that are met there.
      type(archive_t), private :: memory
   contains
      procedure :: meet
      procedure :: start
      procedure :: drop
      procedure :: restore
      procedure :: prepare
      procedure :: improve
      procedure :: yield
      procedure :: begin
      procedure :: judge
      procedure :: draw_round_off
      procedure :: judge_round_off
      procedure :: accept
      procedure :: count
      procedure :: blame
      procedure :: explain
      procedure :: serialize
   end type newton_t

contains

   !> Takes the equations of a system, or y' = f(t, y) of one that has none.
   subroutine meet(self, ode, n)
      !> The iteration.
      class(newton_t), intent(inout) :: self
      !> The system.
      class(ode_system_t), intent(inout) :: ode
      !> Number of entries of the state.
      integer, intent(in) :: n
      type(plain_equations_t), allocatable :: plain

      call ode%stage_equations(self%equations)
      if (.not. allocated(self%equations)) then
         allocate (plain)
         call plain%init(n)
         call move_alloc(plain, self%equations)
      end if
      call make_place(self%jacobian)
      call make_place(self%refreshed)
      call remind(self)

   contains

      subroutine make_place(place)
         type(place_t), intent(inout) :: place

         if (.not. allocated(place%y)) allocate (place%y(n), place%ydot(n), place%z(self%equations%n_z), source=0.0_wp)
      end subroutine make_place

   end subroutine meet

   !> At a start: derivatives and algebraic unknowns there; nothing is known of the steps before.
   subroutine start(self, ode, t, y, first, ydot, z, work, info)
      !> The iteration, its equations met.
      class(newton_t), intent(inout) :: self
      !> The system.
      class(ode_system_t), intent(inout) :: ode
      !> Time [s].
      real(wp), intent(in) :: t
      !> State: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Whether z is not known yet.
      logical, intent(in) :: first
      !> Its derivative: (n).
      real(wp), intent(out), contiguous :: ydot(:)
      !> Algebraic unknowns: (n_z).
      real(wp), intent(inout), contiguous :: z(:)
      !> Where it is counted.
      type(work_t), intent(inout) :: work
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      call self%equations%let_go()
      call self%equations%start(ode, t, y, first, ydot, z, info)
      self%trouble = merge(not_factorized, no_trouble, info == rhs_not_solved .or. info == rhs_cannot)
      call self%count(work)
      self%h_factors = 0.0_wp
      self%has_jacobian = .false.
      self%contraction = 1.0_wp
      self%eta = 1.0_wp
   end subroutine start

   !> The matrices do not serve any more.
   pure subroutine drop(self)
      !> The iteration.
      class(newton_t), intent(inout) :: self

      self%h_factors = 0.0_wp
      self%has_jacobian = .false.
      self%yields = .false.
   end subroutine drop

   !> Builds the matrices that a restart has lost; the work was counted before.
   subroutine restore(self, ode, nu, info)
      !> The iteration, its equations met.
      class(newton_t), intent(inout) :: self
      !> The system.
      class(ode_system_t), intent(inout) :: ode
      !> As for `prepare`.
      complex(wp), intent(in) :: nu(:)
      !> One of the `rhs_` constants.
      integer, intent(out) :: info
      integer :: counted

      info = rhs_ok
      counted = 0
      call ode%recount(counted, back=.false.)
      if (self%has_jacobian) then
         associate (of => self%jacobian)
            call self%equations%linearize(ode, of%t, self%h_jacobian, of%y, of%ydot, of%z, info)
         end associate
         associate (of => self%refreshed)
            if (info == rhs_ok .and. self%has_refreshed) &
               call self%equations%refresh(ode, of%t, of%y, of%ydot, of%z, info)
         end associate
         if (info == rhs_ok .and. abs(self%h_factors) > 0.0_wp) call factors(self, ode, self%h_factors, nu, info)
      end if
      if (allocated(self%memory%error)) info = rhs_failed
      self%equations%evaluations = 0
      call ode%recount(counted, back=.true.)
   end subroutine restore

   !> Behind a restart, the equations remember what they did.
   subroutine remind(self)
      type(newton_t), intent(inout) :: self

      if (self%memory%length == 0) return
      call self%memory%rewind()
      call self%equations%serialize(self%memory)
   end subroutine remind

   !> The matrices for a step, at a state that it passes through: a new Jacobian where there is none, else with another step what
   !! of it costs little.
   subroutine prepare(self, ode, t, h, y, ydot, z, nu, work, info)
      !> The iteration.
      class(newton_t), intent(inout) :: self
      !> The system.
      class(ode_system_t), intent(inout) :: ode
      !> Time [s].
      real(wp), intent(in) :: t
      !> Step [s].
      real(wp), intent(in) :: h
      !> State: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Its derivative: (n).
      real(wp), intent(in), contiguous :: ydot(:)
      !> Algebraic unknowns: (n_z).
      real(wp), intent(in), contiguous :: z(:)
      !> What d/dt is replaced by, times h: one without an imaginary part, and perhaps one with.
      complex(wp), intent(in) :: nu(:)
      !> Where it is counted.
      type(work_t), intent(inout) :: work
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      info = rhs_ok
      if (.not. self%has_jacobian) then
         call keep_place(self%jacobian)
         self%h_jacobian = h
         if (.not. self%yields) call self%equations%let_go()
         call self%equations%linearize(ode, t, h, y, ydot, z, info)
         work%jacobians = work%jacobians + 1
         self%has_jacobian = info == rhs_ok
         self%fresh = .true.
         self%has_refreshed = .false.
         self%h_factors = 0.0_wp
      else if (abs(h - self%h_factors) > 0.0_wp .and. .not. self%yields) then
         call keep_place(self%refreshed)
         call self%equations%refresh(ode, t, y, ydot, z, info)
         self%has_refreshed = .true.
         self%current = .true.
      end if
      self%trouble = merge(no_trouble, not_linearized, info == rhs_ok)
      if (info /= rhs_ok .or. abs(h - self%h_factors) <= 0.0_wp) return
      call factors(self, ode, h, nu, info)
      work%factorizations = work%factorizations + 1

   contains

      subroutine keep_place(place)
         type(place_t), intent(inout) :: place

         place%t = t
         place%y(:) = y
         place%ydot(:) = ydot
         place%z(:) = z
      end subroutine keep_place

   end subroutine prepare

   subroutine factors(self, ode, h, nu, info)
      type(newton_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: h
      complex(wp), intent(in) :: nu(:)
      integer, intent(out) :: info
      integer :: slot

      do slot = 1, size(nu)
         call self%equations%factorize(ode, slot, nu(slot)/h, info)
         if (info == rhs_retry) info = rhs_not_solved
         self%trouble = merge(no_trouble, not_factorized, info == rhs_ok)
         if (info /= rhs_ok) exit
      end do
      self%h_factors = h
   end subroutine factors

   !> After an iteration that did not converge: makes `prepare` take better matrices, first what costs little, if the step has not
   !! had them yet.
   subroutine improve(self, possible)
      !> The iteration.
      class(newton_t), intent(inout) :: self
      !> Whether there are better ones.
      logical, intent(out) :: possible

      possible = .not. self%fresh
      if (.not. possible) return
      if (self%current) self%has_jacobian = .false.
      self%h_factors = 0.0_wp
   end subroutine improve

   !> Where an iteration has failed, or has come as far as round-off lets it and that is not enough: whether the equations can hold
   !! what hampers it. What is held is what the equations themselves say at the step's start: round-off may have made anything of
   !! what the steps before have left of it.
   subroutine yield(self, ode, t, h, y, ydot, z, yields, info)
      !> The iteration.
      class(newton_t), intent(inout) :: self
      !> The system.
      class(ode_system_t), intent(inout) :: ode
      !> Time at the step's start [s].
      real(wp), intent(in) :: t
      !> The step [s].
      real(wp), intent(in) :: h
      !> State at the step's start: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Its derivative, replaced if the equations yield: (n).
      real(wp), intent(inout), contiguous :: ydot(:)
      !> Algebraic unknowns there, replaced likewise: (n_z).
      real(wp), intent(inout), contiguous :: z(:)
      !> Whether another try with this step is of use.
      logical, intent(out) :: yields
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      yields = .false.
      info = rhs_ok
      if (self%yields .or. .not. self%has_jacobian) return
      call self%equations%yield(h, yields, info)
      if (info /= rhs_ok .or. .not. yields) return
      call self%equations%start(ode, t, y, .false., ydot, z, info)
      call self%drop()
      self%yields = info == rhs_ok
   end subroutine yield

   !> Before the first iteration of a step.
   pure subroutine begin(self, control, y)
      !> The iteration.
      class(newton_t), intent(inout) :: self
      !> The tolerance of the errors, of which this is a part.
      type(step_control_t), intent(in) :: control
      !> The state, of which fixed steps keep all places: (n).
      real(wp), intent(in), contiguous :: y(:)

      self%used = 0
      self%doubtful = .false.
      self%trouble = no_trouble
      self%change_before = 0.0_wp
      self%contraction_before = self%contraction
      self%eta_before = self%eta
      if (control%fixed) then
         ! Errors of fixed steps are not known, and may be far below the tolerance: those of the iteration must not be seen.
         self%eta = 1.0_wp
         self%tolerance = control%last_places(y)
      else
         self%tolerance = max(10.0_wp*epsilon(1.0_wp)/control%rtol, min(3.0e-3_wp, sqrt(control%rtol)))
      end if
      self%most_round_off = max(1.0_wp, sqrt(epsilon(1.0_wp))/control%rtol)
   end subroutine begin

   !> After a correction: whether it was the last.
   pure subroutine judge(self, change, converged, hopes)
      !> The iteration.
      class(newton_t), intent(inout) :: self
      !> Size of the correction in units of the tolerance of errors.
      real(wp), intent(in) :: change
      !> Whether what is left is small enough.
      logical, intent(out) :: converged
      !> Whether another correction would help, if not.
      logical, intent(out) :: hopes
      real(wp) :: theta

      self%used = self%used + 1
      converged = .false.
      hopes = .false.
      if (.not. change <= hopeless) return
      if (self%used == 1) then
         ! What is left then, as the step before has it; that is trusted less with every step that shows nothing of it.
         self%eta = max(self%eta, least_trust)**0.8_wp
         converged = max(self%eta, least_trust)*change <= self%tolerance
      else
         theta = change/max(self%change_before, tiny(1.0_wp))
         if (self%used > 2) theta = sqrt(theta*self%contraction)
         self%contraction = theta
         if (theta >= 0.99_wp) return
         self%eta = theta/(1.0_wp - theta)
         converged = self%eta*change <= self%tolerance
         if (.not. converged .and. self%eta*change*theta**(most_iterations - 1 - self%used) > self%tolerance) return
      end if
      hopes = self%used < most_iterations
      self%change_before = change
   end subroutine judge

   !> A residual such as round-off may leave it, for an iteration without hopes: what a correction is then, nothing makes smaller.
   subroutine draw_round_off(self, stage, y, ydot, z, r)
      !> The iteration, with its matrices.
      class(newton_t), intent(inout) :: self
      !> Which of several residuals, each of which has signs of its own.
      integer, intent(in) :: stage
      !> State: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Its derivative: (n).
      real(wp), intent(in), contiguous :: ydot(:)
      !> Algebraic unknowns: (n_z).
      real(wp), intent(in), contiguous :: z(:)
      !> The residual: (n + n_z).
      real(wp), intent(out), contiguous :: r(:)
      integer :: j

      call self%equations%round_off(y, ydot, z, r)
      do j = 1, size(r)
         r(j) = sign(r(j), spread_evenly(j + stage*size(r)))
      end do
   end subroutine draw_round_off

   !> Numbers between -1/2 and 1/2 that stand for drawn ones.
   pure real(wp) function spread_evenly(i)
      !> Which of them.
      integer, intent(in) :: i
      !> The part of the golden ratio behind the point, whose multiples are spread evenly.
      real(wp), parameter :: golden = 0.5_wp*(sqrt(5.0_wp) - 1.0_wp)

      spread_evenly = modulo(golden*real(i, wp), 1.0_wp) - 0.5_wp
   end function spread_evenly

   !> Whether an iteration without hopes has come as far as round-off lets it.
   pure subroutine judge_round_off(self, change, of_round_off, converged)
      !> The iteration.
      class(newton_t), intent(inout) :: self
      !> Size of its last correction.
      real(wp), intent(in) :: change
      !> Size of that which belongs to a residual of round-off.
      real(wp), intent(in) :: of_round_off
      !> Whether what is left is of that size.
      logical, intent(out) :: converged
      !> Signs may fall worse than those that were drawn, by so much.
      real(wp), parameter :: luck = 2.0_wp

      converged = change <= min(luck*of_round_off, self%most_round_off)
      self%doubtful = converged .and. change > 1.0_wp
      if (.not. converged) return
      ! How fast it contracts was not to be seen.
      self%contraction = self%contraction_before
      self%eta = self%eta_before
   end subroutine judge_round_off

   !> A step holds: the matrices serve for the next one if the iteration went well.
   pure subroutine accept(self)
      !> The iteration.
      class(newton_t), intent(inout) :: self

      if (self%contraction > good_contraction) then
         if (self%fresh .or. self%current) self%has_jacobian = .false.
         self%h_factors = 0.0_wp
      end if
      if (self%yields) call self%drop()
      self%fresh = .false.
      self%current = .false.
   end subroutine accept

   !> Takes over what the equations have counted.
   subroutine count(self, work)
      !> The iteration.
      class(newton_t), intent(inout) :: self
      !> Where it is counted.
      type(work_t), intent(inout) :: work

      work%rhs = work%rhs + self%equations%evaluations
      self%equations%evaluations = 0
   end subroutine count

   !> After an iteration that did not converge: what is to be named is the largest correction.
   pure subroutine blame(self, control, correction, y0, y1)
      !> The iteration.
      class(newton_t), intent(inout) :: self
      !> Norm of errors.
      type(step_control_t), intent(in) :: control
      !> The last correction, weighed: (n).
      real(wp), intent(in), contiguous :: correction(:)
      !> One state that sets the scale: (n).
      real(wp), intent(in), contiguous :: y0(:)
      !> Another one: (n).
      real(wp), intent(in), contiguous :: y1(:)

      self%trouble = not_converged
      self%worst = control%largest(correction, y0, y1)
   end subroutine blame

   !> What went wrong, in words.
   subroutine explain(self, ode, text)
      !> The iteration.
      class(newton_t), intent(in) :: self
      !> The system, asked if it was not the iteration.
      class(ode_system_t), intent(in) :: ode
      !> One line, may be empty.
      character(:), allocatable, intent(out) :: text

      if (self%trouble == no_trouble .or. .not. allocated(self%equations)) then
         call ode%failure(text)
      else
         call self%equations%explain(self%trouble, self%worst, text)
      end if
   end subroutine explain

   !> Passes what is remembered between two steps through an archive; `restore` builds the matrices again.
   subroutine serialize(self, archive)
      !> The iteration.
      class(newton_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      call archive%item('step of the factors', self%h_factors)
      call archive%item('contraction', self%contraction)
      call archive%item('left by the iteration', self%eta)
      call archive%item('has Jacobian', self%has_jacobian)
      call archive%item('is fresh', self%fresh)
      call archive%item('is current', self%current)
      call archive%item('is refreshed', self%has_refreshed)
      call archive%item('yields', self%yields)
      call archive%item('step of the Jacobian', self%h_jacobian)
      call self%jacobian%serialize(archive)
      call self%refreshed%serialize(archive)
      if (allocated(self%equations) .and. .not. archive%reading) then
         call self%memory%clear()
         call self%equations%serialize(self%memory)
      end if
      call archive%item('equations', self%memory)
      if (archive%reading .and. allocated(self%equations)) deallocate (self%equations)
   end subroutine serialize

   !> Passes a state through an archive.
   subroutine serialize_place(self, archive)
      !> The state.
      class(place_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      call archive%item('time of a Jacobian', self%t)
      call archive%list('state of a Jacobian', self%y)
      call archive%list('derivative of a Jacobian', self%ydot)
      call archive%list('z of a Jacobian', self%z)
   end subroutine serialize_place

end module taut_ode_newton
