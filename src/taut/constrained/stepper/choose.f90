!> Which stepper carries a constrained system, by name: those of any system, and those that know mechanics.
module taut_constrained_stepper_choose
   use taut_error, only: error_t, raise, to_text
   use taut_constrained_method_options, only: method_t
   use taut_constrained_stepper_generalized_alpha, only: generalized_alpha_t, new_generalized_alpha
   use taut_kinds, only: wp
   use taut_ode_options, only: integration_options_t
   use taut_ode_stepper, only: stepper_t
   use taut_ode_stepper_choose, only: choose_stepper, of_any_system => integrator_names, refuse_name
   implicit none (type, external)
   private
   public :: choose_constrained_stepper, integrator_names

   character(*), parameter :: generalized_alpha = 'generalized-alpha'

   !> All of them.
   character(len=len(generalized_alpha)), parameter :: integrator_names(size(of_any_system) + 1) = &
      [character(len=len(generalized_alpha)) :: of_any_system, generalized_alpha]

contains

   !> The stepper that the options name.
   subroutine choose_constrained_stepper(options, method, stepper, error)
      !> The name, and what belongs to it.
      type(integration_options_t), intent(in) :: options
      !> The method that it is to carry.
      type(method_t), intent(in) :: method
      !> The stepper, to be initialized; not allocated if there is an error.
      class(stepper_t), allocatable, intent(out) :: stepper
      !> A name that is unknown, or what does not go together.
      type(error_t), allocatable, intent(inout) :: error
      type(generalized_alpha_t), allocatable :: made

      if (.not. any(integrator_names == options%integrator)) then
         call refuse_name(trim(options%integrator), integrator_names, error)
      else if (options%integrator /= generalized_alpha) then
         call choose_stepper(trim(options%integrator), stepper, error)
      else
         call check(options, method, error)
         if (allocated(error)) return
         allocate (made)
         call new_generalized_alpha(made, options%spectral_radius, method%state_projection == 'position-velocity')
         made%name = generalized_alpha
         call move_alloc(made, stepper)
      end if
   end subroutine choose_constrained_stepper

   !> Generalized-alpha takes accelerations and multipliers from equations of its own.
   subroutine check(options, method, error)
      type(integration_options_t), intent(in) :: options
      type(method_t), intent(in) :: method
      type(error_t), allocatable, intent(inout) :: error

      if (method%name /= 'present') &
         call raise(error, method%place(), 'integrator = "generalized-alpha" does not take its right-hand side', &
                    'use method "present", or integrator = "radau"')
      if (method%state_projection == 'none') &
         call raise(error, method%place(), 'integrator = "generalized-alpha" with state_projection = "none"', &
                    'use "position-velocity" (stabilized index 2) or "position" (index 3)')
      if (.not. (options%spectral_radius >= 0.0_wp .and. options%spectral_radius <= 1.0_wp)) &
         call raise(error, 'integration options', &
                    'spectral_radius = '//to_text(options%spectral_radius)//' is not between 0 and 1', &
                    'give 0 for the most damping, 1 for none')
   end subroutine check

end module taut_constrained_stepper_choose
