!> Eq. (8), with positions or velocities corrected at the end of a step whose violation exceeds a tolerance (Yu and Chen).
module taut_constrained_method_yu_chen
   use taut_kinds, only: wp
   use taut_constrained_method_coordinate_projection, only: coordinate_projection_t
   use taut_constrained_method_options, only: method_t
   use taut_error, only: error_t, raise, to_text
   implicit none (type, external)
   private
   public :: yu_chen_t

   !> The method `yu-chen`.
   type, extends(coordinate_projection_t) :: yu_chen_t
   contains
      procedure :: check_options
      procedure :: set_up
   end type yu_chen_t

contains

   !> Whether the tolerance makes sense.
   subroutine check_options(self, options, error)
      !> The formulation, not yet set up.
      class(yu_chen_t), intent(in) :: self
      !> The options.
      type(method_t), intent(in) :: options
      !> A tolerance that is negative.
      type(error_t), allocatable, intent(inout) :: error

      if (.not. options%correction_tolerance >= 0.0_wp) &
         call raise(error, options%place(), 'correction_tolerance = '//to_text(options%correction_tolerance)//' is negative', &
                    'give 0 or more')
      associate (unused_formulation => self)
      end associate
   end subroutine check_options

   !> Takes the tolerance as the threshold.
   subroutine set_up(self, error)
      !> The formulation.
      class(yu_chen_t), intent(inout) :: self
      !> Left alone.
      type(error_t), allocatable, intent(inout) :: error

      call self%coordinate_projection_t%set_up(error)
      self%threshold = self%options%correction_tolerance
      self%limits_projection = .false.
   end subroutine set_up

end module taut_constrained_method_yu_chen
