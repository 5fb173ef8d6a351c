!> The augmented Lagrangian of Bayo, Garcia de Jalon and Serna: the multipliers of `bayo-penalty`, corrected by
!! lambda := lambda + alpha (A vdot - b) until the accelerations meet A vdot = b = b'' - 2 omega mu phidot - omega^2 phi.
!!
!! Each iteration leaves a part 1/(1 + alpha s) of the violation along an eigenvector of S with the eigenvalue s, so that alpha says
!! how many are needed, not how exact the result is: that of Baumgarte's method with the gains omega mu and omega, with
!! multipliers of least norm where rows are redundant. It begins without multipliers at each evaluation, so that nothing has to be
!! remembered, and ends at `projection_tolerance`, relative to what the constraints take off, or after `max_iterations`.
!!
!! Source: as of `bayo-penalty`.
module taut_constrained_method_augmented_lagrangian
   use taut_constrained_method_bayo_penalty, only: bayo_penalty_t
   implicit none (type, external)
   private
   public :: augmented_lagrangian_t

   !> The method `augmented-lagrangian`.
   type, extends(bayo_penalty_t) :: augmented_lagrangian_t
   contains
      procedure :: most_iterations
   end type augmented_lagrangian_t

contains

   !> How often the multipliers are corrected at most.
   pure integer function most_iterations(self)
      !> The formulation.
      class(augmented_lagrangian_t), intent(in) :: self

      most_iterations = self%options%max_iterations
   end function most_iterations

end module taut_constrained_method_augmented_lagrangian
