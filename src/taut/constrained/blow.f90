!> A blow: velocities that do not fit become those that do, as in a plastic impact.
!!
!! Of all v+ with A v+ = b' those for which (v+ - v)^T M (v+ - v) is least: M (v+ - v) = -A^T mu with impulses mu of least norm.
!! Momentum is kept where constraints do not move; where they move, the impulse comes from outside.
module taut_constrained_blow
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   use taut_error, only: to_text
   use taut_constrained_method_options, only: method_t
   use taut_constrained_projection, only: projector_t
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_ode_system, only: rhs_ok
   implicit none (type, external)
   private
   public :: blow_t, blows_t

   !> Differences of b' before and behind a breakpoint up to this part of it are those of the two times.
   real(wp), parameter :: no_jump = 1.0e-10_wp

   !> A blow, and what it did.
   type :: blow_t
      !> Impulses of the constraints, of least norm: (c) [force s/unit of A v].
      real(wp), allocatable :: impulse(:)
      !> Kinetic energy gained [J]; negative: lost.
      real(wp) :: energy = 0.0_wp
      !> Why there was none, in words; empty if there was.
      character(:), allocatable :: why
   contains
      procedure :: strike
   end type blow_t

   !> The blows of a motion: where a drive begins or stops to move at once.
   type :: blows_t
      !> How many.
      integer :: count = 0
      !> Kinetic energy that they gave [J].
      real(wp) :: energy = 0.0_wp
      type(blow_t), private :: last
   contains
      procedure :: forget
      procedure :: strike_at_jump
      procedure :: explain
      procedure :: remark
      procedure :: serialize
   end type blows_t

contains

   !> Changes velocities by a blow.
   subroutine strike(self, model, method, at, info, held, rates_before)
      !> The blow.
      class(blow_t), intent(out) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Solver, and its cut-off.
      type(method_t), intent(in) :: method
      !> The state; v is replaced.
      type(state_t), intent(inout) :: at
      !> `rhs_ok` or `rhs_retry`.
      integer, intent(out) :: info
      !> Velocities that stay as they are: (n). Default: none.
      logical, intent(in), optional :: held(:)
      !> b' that held before: A v changes by what b' changes; default: A v becomes b'. (c).
      real(wp), intent(in), optional :: rates_before(:)
      type(projector_t) :: projector
      type(method_t) :: in_mass
      type(block_diagonal_t) :: m
      real(wp) :: before(model%n), change(model%c), kept(model%c), momentum(model%n)

      self%why = ''
      in_mass = method
      in_mass%weight = 'mass'
      call projector%init(model, in_mass, held)
      call projector%linear%linearize(model, at, info, 0.0_wp)
      if (info /= rhs_ok) then
         call projector%explain(model, self%why)
         return
      end if
      kept(:) = 0.0_wp
      if (present(rates_before)) call projector%linear%a%multiply(at%v, kept, rates_before)
      before(:) = at%v
      call projector%shifted_velocity(model, at, -kept)
      call m%init(model%mass_blocks)
      call model%mass(at, m)
      call m%multiply(0.5_wp*(before + at%v), momentum)
      self%energy = dot_product(at%v - before, momentum)
      allocate (self%impulse, source=projector%mu)
      call projector%linear%a%multiply(at%v, kept)
      call projector%linear%a%multiply(before, change, kept)
      call projector%linear%completion%add_rates(-change, self%impulse)
      call projector%linear%onto%minimum_norm(self%impulse)
   end subroutine strike

   !> Before another motion.
   pure subroutine forget(self)
      !> The blows.
      class(blows_t), intent(inout) :: self

      self%count = 0
      self%energy = 0.0_wp
   end subroutine forget

   !> Behind a breakpoint: where b' jumps there, velocities change by what it changes, by a blow.
   subroutine strike_at_jump(self, model, method, before, at, struck, info)
      !> The blows.
      class(blows_t), intent(inout) :: self
      !> The system, with constraints.
      class(mechanical_system_t), intent(in) :: model
      !> Solver, and its cut-off.
      type(method_t), intent(in) :: method
      !> The last time before the breakpoint [s].
      real(wp), intent(in) :: before
      !> The state behind it; v is replaced by a blow.
      type(state_t), intent(inout) :: at
      !> Whether there was one.
      logical, intent(out) :: struck
      !> `rhs_ok` or `rhs_retry`.
      integer, intent(out) :: info
      real(wp) :: behind, rates(model%c), rates_before(model%c)

      info = rhs_ok
      behind = at%t
      call model%velocity_rhs(at, rates)
      at%t = before
      call model%velocity_rhs(at, rates_before)
      at%t = behind
      struck = any(abs(rates - rates_before) > no_jump*max(maxval(abs(rates)), maxval(abs(rates_before))))
      if (.not. struck) return
      call self%last%strike(model, method, at, info, rates_before=rates_before)
      if (info /= rhs_ok) return
      self%count = self%count + 1
      self%energy = self%energy + self%last%energy
   end subroutine strike_at_jump

   !> Why the last one was impossible.
   subroutine explain(self, text)
      !> The blows.
      class(blows_t), intent(in) :: self
      !> One line; empty if it was not.
      character(:), allocatable, intent(out) :: text

      text = ''
      if (allocated(self%last%why)) text = self%last%why
   end subroutine explain

   !> How many there were, and what they did.
   subroutine remark(self, text)
      !> The blows.
      class(blows_t), intent(in) :: self
      !> One line without commas; empty if there were none.
      character(:), allocatable, intent(out) :: text

      text = ''
      if (self%count > 0) &
         text = to_text(self%count)//' '//trim(merge('blow ', 'blows', self%count == 1))// &
                ' of drives that begin or stop at once: '//trim(merge('gained', 'lost  ', self%energy > 0.0_wp))//' '// &
                to_text(abs(self%energy))//' J'
   end subroutine remark

   !> Passes what is remembered of them through an archive.
   subroutine serialize(self, archive)
      !> The blows.
      class(blows_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      call archive%item('blows', self%count)
      call archive%item('energy of blows', self%energy)
   end subroutine serialize

end module taut_constrained_blow
