!> Pauses: an integration that is asked to stop between two steps, and can go on from there later.
module taut_ode_pause
   implicit none (type, external)
   private
   public :: pause_t

   !> Is asked before every step whether the integration is to pause.
   type, abstract :: pause_t
   contains
      procedure(question), deferred :: wanted
   end type pause_t

   abstract interface
      !> Whether to pause now.
      logical function question(self)
         import :: pause_t
         implicit none (type, external)
         !> The pause; what it remembers may change.
         class(pause_t), intent(inout) :: self
      end function question
   end interface

end module taut_ode_pause
