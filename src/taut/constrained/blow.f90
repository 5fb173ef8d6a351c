!> A blow: velocities that do not fit become those that do, as in a plastic impact.
!!
!! Of all v+ with A v+ = b' those for which (v+ - v)^T M (v+ - v) is least: M (v+ - v) = -A^T mu with impulses mu of least norm.
!! Momentum is kept where constraints do not move; where they move, the impulse comes from outside.
module taut_constrained_blow
   use taut_kinds, only: wp
   use taut_constrained_method_options, only: method_t
   use taut_constrained_projection, only: projector_t
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_ode_system, only: rhs_ok
   implicit none (type, external)
   private
   public :: blow_t

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
      call projector%linearize(model, at, info, 0.0_wp)
      if (info /= rhs_ok) then
         call projector%explain(self%why)
         return
      end if
      kept(:) = 0.0_wp
      if (present(rates_before)) call projector%a%multiply(at%v, kept, rates_before)
      before(:) = at%v
      call projector%velocity(model, at, -kept)
      call m%init(model%mass_blocks)
      call model%mass(at, m)
      call m%multiply(0.5_wp*(before + at%v), momentum)
      self%energy = dot_product(at%v - before, momentum)
      allocate (self%impulse, source=projector%mu)
      call projector%a%multiply(at%v, kept)
      call projector%a%multiply(before, change, kept)
      call projector%completion%add_rates(-change, self%impulse)
      call projector%onto%minimum_norm(self%impulse)
   end subroutine strike

end module taut_constrained_blow
