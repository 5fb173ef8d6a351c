!> What the way of a projection says of a step.
!!
!! The part of a step's error that is normal to the system's invariants is left out of its norm, for the projection takes it
!! off. Two things are not seen by that norm. Where the way back bends, what the normal part does to the tangential one; and
!! where nothing is tangential (all motion is driven), any error at all, so that a linkage near a position in which it could
!! go on in two ways lands on the wrong one. How far a state is moved tells neither: at positions that are singular an honest
!! step is moved by thousands of tolerances, straight back.
module taut_ode_projection_check
   use taut_kinds, only: wp
   use taut_ode_step_control, only: step_control_t
   use taut_ode_system, only: ode_system_t
   implicit none (type, external)
   private
   public :: projection_holds

   !> The way back is no longer than this part of the step's own, or a tolerance: a step of more than a turn may come back
   !! straight by luck.
   real(wp), parameter :: longest_way = 0.1_wp
   !> Velocities are changed by no more than this part of them: those of two branches differ by far more.
   real(wp), parameter :: largest_turn = 1.0e-2_wp
   !> Displacements of so many last places of the largest coordinate are round-off.
   real(wp), parameter :: round_off = 10.0_wp*epsilon(1.0_wp)

contains

   !> Whether a step holds by what its projection had to do.
   function projection_holds(control, ode, moved, y0, y1, later) result(holds)
      !> Norm, and `projection_limit` for what follows the first correction.
      type(step_control_t), intent(in) :: control
      !> What is integrated, its new state just projected.
      class(ode_system_t), intent(in) :: ode
      !> New state before the projection less that behind it: (n).
      real(wp), intent(in), contiguous :: moved(:)
      !> State at the step's start: (n).
      real(wp), intent(in), contiguous :: y0(:)
      !> State at its end, on the invariants: (n).
      real(wp), intent(in), contiguous :: y1(:)
      !> Workspace: (n).
      real(wp), intent(inout), contiguous :: later(:)
      !> Whether it does.
      logical :: holds
      logical :: bends
      real(wp) :: way
      integer :: m, n

      m = ode%coordinates
      if (m == 0) m = size(y1)
      n = m + ode%velocities
      call ode%later_corrections(later(:m), bends)
      holds = .true.
      if (bends) then
         if (maxval(abs(later(:m))) > round_off*maxval(abs(y1(:m)))) &
            holds = control%norm(later(:m), y0(:m), y1(:m)) <= control%projection_limit
      end if
      if (.not. (holds .and. control%norm(moved(:n), y0(:n), y1(:n)) > 1.0_wp)) return
      way = control%norm(moved(:m), y0(:m), y1(:m))
      if (way > 1.0_wp) then
         later(:m) = y1(:m) - y0(:m)
         holds = way <= 1.0_wp + longest_way*control%norm(later(:m), y0(:m), y1(:m))
      end if
      if (holds .and. n > m) then
         way = control%norm(moved(m + 1:n), y0(m + 1:n), y1(m + 1:n), before=m)
         if (way > 1.0_wp) holds = norm2(moved(m + 1:n)) <= largest_turn*max(norm2(y0(m + 1:n)), norm2(y1(m + 1:n)))
      end if
   end function projection_holds

end module taut_ode_projection_check
