!> Which stepper carries a constrained system, by name: those of any system, and those that know mechanics.
module taut_constrained_stepper_choose
   use taut_error, only: error_t, raise, to_text
   use taut_constrained_method_options, only: method_t
   use taut_constrained_stepper_energy_preserving, only: energy_preserving_t, new_energy_preserving
   use taut_constrained_stepper_generalized_alpha, only: generalized_alpha_t, new_generalized_alpha
   use taut_kinds, only: wp
   use taut_ode_options, only: integration_options_t
   use taut_ode_stepper, only: stepper_t
   use taut_ode_stepper_choose, only: choose_stepper, of_any_system => integrator_names, refuse_name
   implicit none (type, external)
   private
   public :: choose_constrained_stepper, integrator_names

   character(*), parameter :: energy_preserving = 'energy-preserving', generalized_alpha = 'generalized-alpha'

   !> All of them.
   character(len=len(generalized_alpha)), parameter :: integrator_names(size(of_any_system) + 2) = &
      [character(len=len(generalized_alpha)) :: of_any_system, generalized_alpha, energy_preserving]

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
      type(energy_preserving_t), allocatable :: preserving
      type(generalized_alpha_t), allocatable :: alpha

      if (.not. any(integrator_names == options%integrator)) then
         call refuse_name(trim(options%integrator), integrator_names, error)
         return
      end if
      select case (options%integrator)
      case (generalized_alpha)
         call check(generalized_alpha, method, [character(len=17) :: 'position', 'position-velocity'], &
                    'use "position-velocity" (stabilized index 2) or "position" (index 3)', error)
         call check_spectral_radius(options%spectral_radius, error)
         if (allocated(error)) return
         allocate (alpha)
         call new_generalized_alpha(alpha, options%spectral_radius, method%state_projection == 'position-velocity')
         call move_alloc(alpha, stepper)
      case (energy_preserving)
         call check(energy_preserving, method, [character(len=17) :: 'position'], &
                    'use "position": it meets velocities on the average of a step', error)
         if (allocated(error)) return
         allocate (preserving)
         call new_energy_preserving(preserving)
         call move_alloc(preserving, stepper)
      case default
         call choose_stepper(trim(options%integrator), stepper, error)
         return
      end select
      stepper%name = options%integrator
   end subroutine choose_constrained_stepper

   !> Steppers that know mechanics take accelerations and multipliers from equations of their own.
   subroutine check(integrator, method, levels, remedy, error)
      character(*), intent(in) :: integrator
      type(method_t), intent(in) :: method
      character(*), intent(in) :: levels(:), remedy
      type(error_t), allocatable, intent(inout) :: error

      if (method%name /= 'present') &
         call raise(error, method%place(), 'integrator = "'//integrator//'" does not take its right-hand side', &
                    'use method "present", or integrator = "radau"')
      if (.not. any(levels == method%state_projection)) &
         call raise(error, method%place(), 'integrator = "'//integrator//'" with state_projection = "'// &
                    trim(method%state_projection)//'"', remedy)
   end subroutine check

   !> Whether it is between none and all.
   subroutine check_spectral_radius(radius, error)
      real(wp), intent(in) :: radius
      type(error_t), allocatable, intent(inout) :: error

      if (.not. (radius >= 0.0_wp .and. radius <= 1.0_wp)) &
         call raise(error, 'integration options', 'spectral_radius = '//to_text(radius)//' is not between 0 and 1', &
                    'give 0 for the most damping, 1 for none')
   end subroutine check_spectral_radius

end module taut_constrained_stepper_choose
