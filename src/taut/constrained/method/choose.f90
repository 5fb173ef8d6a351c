!> From the name of a method to the method.
module taut_constrained_method_choose
   use taut_error, only: error_t, raise
   use taut_constrained_method, only: constrained_ode_t
   use taut_constrained_method_augmented_lagrangian, only: augmented_lagrangian_t
   use taut_constrained_method_baseline, only: baseline_t
   use taut_constrained_method_baumgarte, only: baumgarte_t
   use taut_constrained_method_bayo_penalty, only: bayo_penalty_t
   use taut_constrained_method_braun_goldfarb, only: braun_goldfarb_t
   use taut_constrained_method_coordinate_projection, only: coordinate_projection_t
   use taut_constrained_method_dummy_derivatives, only: dummy_derivatives_t
   use taut_constrained_method_embedded_projection, only: embedded_projection_t
   use taut_constrained_method_fuhrer_leimkuhler, only: fuhrer_leimkuhler_t
   use taut_constrained_method_gear_gupta_leimkuhler, only: gear_gupta_leimkuhler_t
   use taut_constrained_method_minimal_coordinates, only: minimal_coordinates_t
   use taut_constrained_method_options, only: method_t
   use taut_constrained_method_penalty, only: penalty_t
   use taut_constrained_method_present, only: present_t
   use taut_constrained_method_reduced, only: find_reduction, reduced_t
   use taut_constrained_method_udwadia_kalaba, only: udwadia_kalaba_t
   use taut_constrained_method_unconstrained, only: unconstrained_t
   use taut_constrained_method_yu_chen, only: yu_chen_t
   use taut_constrained_system, only: mechanical_system_t
   use taut_constrained_system_reducible, only: reduction_t
   use taut_ode_stepper, only: stepper_t
   use taut_ode_stepper_explicit_pair, only: explicit_pair_t
   implicit none (type, external)
   private
   public :: new_constrained_ode, check_method

contains

   !> A constrained system with a method, ready to be integrated.
   subroutine new_constrained_ode(ode, model, method, error, stepper)
      !> The formulation.
      class(constrained_ode_t), allocatable, intent(out) :: ode
      !> The system; copied.
      class(mechanical_system_t), intent(in) :: model
      !> The method.
      type(method_t), intent(in) :: method
      !> Sizes or options that are not valid.
      type(error_t), allocatable, intent(inout) :: error
      !> What integrates it, if that is known: explicit formulas ask for derivatives alone, which may be those of a smaller system
      !! with the same motion.
      class(stepper_t), intent(in), optional :: stepper
      class(reduction_t), allocatable :: reduction
      type(reduced_t), allocatable :: reduced

      call model%check_sizes(error)
      call make(ode, method, error)
      if (present(stepper) .and. .not. allocated(error)) then
         select type (stepper)
         class is (explicit_pair_t)
            call find_reduction(model, method, reduction)
         end select
      end if
      if (allocated(reduction)) then
         allocate (reduced)
         call move_alloc(reduction, reduced%reduction)
         call move_alloc(reduced, ode)
      end if
      if (.not. allocated(error)) call ode%init(model, method, error)
   end subroutine new_constrained_ode

   !> Whether names and numbers of a method's options are valid.
   subroutine check_method(method, error)
      !> The method.
      type(method_t), intent(in) :: method
      !> What is not.
      type(error_t), allocatable, intent(inout) :: error
      class(constrained_ode_t), allocatable :: ode

      call make(ode, method, error)
   end subroutine check_method

   !> The method of a name, with options that are valid.
   subroutine make(ode, method, error)
      class(constrained_ode_t), allocatable, intent(out) :: ode
      type(method_t), intent(in) :: method
      type(error_t), allocatable, intent(inout) :: error

      call method%check(error)
      if (allocated(error)) return
      select case (method%name)
      case ('present'); allocate (present_t :: ode)
      case ('baseline'); allocate (baseline_t :: ode)
      case ('baumgarte'); allocate (baumgarte_t :: ode)
      case ('braun-goldfarb'); allocate (braun_goldfarb_t :: ode)
      case ('yu-chen'); allocate (yu_chen_t :: ode)
      case ('coordinate-projection'); allocate (coordinate_projection_t :: ode)
      case ('penalty'); allocate (penalty_t :: ode)
      case ('unconstrained'); allocate (unconstrained_t :: ode)
      case ('minimal-coordinates'); allocate (minimal_coordinates_t :: ode)
      case ('bayo-penalty'); allocate (bayo_penalty_t :: ode)
      case ('augmented-lagrangian'); allocate (augmented_lagrangian_t :: ode)
      case ('udwadia-kalaba'); allocate (udwadia_kalaba_t :: ode)
      case ('dummy-derivatives'); allocate (dummy_derivatives_t :: ode)
      case ('gear-gupta-leimkuhler'); allocate (gear_gupta_leimkuhler_t :: ode)
      case ('fuhrer-leimkuhler'); allocate (fuhrer_leimkuhler_t :: ode)
      case ('embedded-projection'); allocate (embedded_projection_t :: ode)
      case default
         call raise(error, method%place(), 'no method stands behind this name', 'use another one')
         return
      end select
      call ode%check_options(method, error)
   end subroutine make

end module taut_constrained_method_choose
