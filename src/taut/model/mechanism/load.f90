!> Loads of a mechanism: forces and moments from outside, springs and dampers between points or about a joint.
module taut_model_mechanism_load
   use taut_kinds, only: wp
   implicit none (type, external)
   private
   public :: load_t, spring_t

   !> A force or a moment on a body.
   type :: load_t
      !> What it is called.
      character(:), allocatable :: name
      !> The body, and the index of the function it is multiplied with (0: none).
      integer :: body = 0, factor = 0
      !> Whether it is a moment; whether it turns with the body.
      logical :: moment = .false., following = .false.
      !> Where it acts, in body axes [m]; what it is [N], [N m], in global axes or, if it follows, in those of the body.
      real(wp) :: point(3) = 0.0_wp, value(3) = 0.0_wp
   end type load_t

   !> A spring with a damper between two points, F = preload + stiffness (length - free length) + damping (rate), or about the
   !! axis of a joint, with angles in the place of lengths. Tension, or what turns back, is positive.
   type :: spring_t
      !> What it is called.
      character(:), allocatable :: name
      !> The joint about which it acts; 0: it acts between two points.
      integer :: joint = 0
      !> Bodies (0: the ground) and points in their axes [m].
      integer :: body_1 = 0, body_2 = 0
      real(wp) :: p_1(3) = 0.0_wp, p_2(3) = 0.0_wp
      !> Stiffness [N/m] or [N m/rad], damping [N s/m] or [N m s/rad].
      real(wp) :: stiffness = 0.0_wp, damping = 0.0_wp
      !> Length [m] or angle [rad] without force but the preload, and the preload [N] or [N m].
      real(wp) :: free = 0.0_wp, preload = 0.0_wp
   end type spring_t

end module taut_model_mechanism_load
