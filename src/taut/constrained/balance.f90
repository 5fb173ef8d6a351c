!> The balance of energy along a motion: what is stored, what was worked, and how far they may differ.
!!
!! Energy at a point less that at the start is the work of loads, dampers, drives and blows, and what integration and projections
!! have made of it. The latter is to be no more than the tolerances explain; more is no error of the program, but results that
!! nobody should trust without a look.
module taut_constrained_balance
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   use taut_error, only: to_text
   use taut_constrained_method, only: constrained_ode_t, sample_t
   use taut_ode_options, only: integration_options_t, integration_result_t
   implicit none (type, external)
   private
   public :: energy_balance_t

   !> Errors of steps add up like a random walk, and come out larger than the tolerance by a factor up to this; those of a hundred
   !! runs that keep their constraints stay below a third of it.
   real(wp), parameter :: walk = 30.0_wp
   !> No tolerance explains that more than this part of the energy that moves comes or goes.
   real(wp), parameter :: gross = 0.05_wp
   !> Round-offs of the largest energy that are nothing.
   real(wp), parameter :: round_offs = 1.0e3_wp

   !> A balance, point by point.
   type :: energy_balance_t
      !> Energy at the last point less that at the first, and work between them [J]; not numbers where they are not known.
      real(wp) :: drift = 0.0_wp, work = 0.0_wp
      !> Largest kinetic energy, and largest energy without its sign [J].
      real(wp) :: kinetic = 0.0_wp, largest = 0.0_wp
      !> Kinetic energy of velocities of the size of the absolute tolerance [J].
      real(wp) :: noise = 0.0_wp
      !> How far the quadrature of the work may be off [J].
      real(wp) :: uncertainty = 0.0_wp
      real(wp), private :: first = 0.0_wp
      logical, private :: begun = .false.
   contains
      procedure :: see
      procedure :: off
      procedure :: explained
      procedure :: remark
      procedure :: serialize
   end type energy_balance_t

contains

   !> Takes a point.
   subroutine see(self, ode, s)
      !> The balance.
      class(energy_balance_t), intent(inout) :: self
      !> The formulation that was sampled.
      class(constrained_ode_t), intent(in) :: ode
      !> What was found.
      type(sample_t), intent(in) :: s

      if (.not. self%begun) self%first = s%energy
      self%begun = .true.
      self%drift = s%energy - self%first
      self%work = s%work
      if (.not. ode%has_integral) return
      self%kinetic = max(self%kinetic, s%kinetic)
      self%largest = max(self%largest, abs(s%energy))
      self%noise = max(self%noise, ode%kinetic_of_unit)
      self%uncertainty = ode%integral_error
   end subroutine see

   !> What is gained that nothing has worked [J]; negative: lost. Not a number where the energy is not balanced.
   pure real(wp) function off(self)
      !> The balance.
      class(energy_balance_t), intent(in) :: self

      off = self%drift - self%work
   end function off

   !> How much of that the tolerances explain [J].
   pure real(wp) function explained(self, options, steps, span)
      !> The balance.
      class(energy_balance_t), intent(in) :: self
      !> Tolerances.
      type(integration_options_t), intent(in) :: options
      !> Accepted steps.
      integer, intent(in) :: steps
      !> Time that was integrated over [s].
      real(wp), intent(in) :: span
      real(wp) :: atol, moved, noise, root

      atol = options%atol
      if (allocated(options%atol_of)) atol = maxval(options%atol_of, options%atol_of < huge(1.0_wp))
      root = sqrt(real(max(1, steps), wp))
      moved = self%kinetic + abs(self%work)
      ! Coordinates that are off by the absolute tolerance from step to step make velocities of it.
      noise = self%noise*(atol*max(1.0_wp, steps/max(abs(span), tiny(1.0_wp))))**2
      explained = min(gross*moved, walk*root*(options%rtol*moved + 2.0_wp*sqrt(self%kinetic*noise))) + root*noise + &
                  round_offs*epsilon(1.0_wp)*(self%largest + moved)
   end function explained

   !> What is to be said of it.
   subroutine remark(self, options, result, t_start, text)
      !> The balance.
      class(energy_balance_t), intent(in) :: self
      !> Tolerances.
      type(integration_options_t), intent(in) :: options
      !> How the integration went.
      type(integration_result_t), intent(in) :: result
      !> Its start [s].
      real(wp), intent(in) :: t_start
      !> One line without commas; empty if the balance holds, or if the system has no energy.
      character(:), allocatable, intent(out) :: text
      real(wp) :: limit

      text = ''
      if (.not. ieee_is_finite(self%drift)) return
      if (.not. ieee_is_finite(self%work)) then
         text = 'the energy is not balanced: the system does not state the power of what is not in it; or the integrator '// &
                'counts no work'
         return
      end if
      limit = self%explained(options, result%steps, result%t - t_start)
      if (abs(self%off()) <= limit) return
      if (abs(self%off()) <= limit + self%uncertainty) then
         text = 'the work is known to '//to_text(self%uncertainty)//' J alone: bound the step by max_step if it is needed'
      else
         text = 'the balance of energy is off by '//to_text(self%off())//' J where the tolerances explain '//to_text(limit)// &
                ' J: tighten them or bound the step; or constraints drift; or forces have a power that the system does not state'
      end if
   end subroutine remark

   !> Passes it through an archive.
   subroutine serialize(self, archive)
      !> The balance.
      class(energy_balance_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      call archive%item('energy drift', self%drift)
      call archive%item('work', self%work)
      call archive%item('largest kinetic energy', self%kinetic)
      call archive%item('largest energy', self%largest)
      call archive%item('noise of energy', self%noise)
      call archive%item('uncertainty of work', self%uncertainty)
      call archive%item('first energy', self%first)
      call archive%item('balance begun', self%begun)
   end subroutine serialize

end module taut_constrained_balance
