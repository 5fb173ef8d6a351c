!> Bodies in the plane that turn about points of the ground: how their centers of mass follow from their angles.
module taut_model_mechanism_pins
   use taut_kinds, only: wp
   use taut_constrained_system, only: state_t
   use taut_constrained_system_reducible, only: reduction_t
   implicit none (type, external)
   private
   public :: pin_t, pins_t

   !> A body that turns about a point.
   type :: pin_t
      !> Index of its x, and of its vx, in the whole system; of its angle, and of its rate, in the smaller one.
      integer :: x = 0, v = 0, angle = 0, rate = 0
      !> Where the point is [m], and the center of mass from there in body axes [m].
      real(wp) :: place(2) = 0.0_wp, center(2) = 0.0_wp
   end type pin_t

   !> All of them.
   type, extends(reduction_t) :: pins_t
      type(pin_t), allocatable :: pins(:)
   contains
      procedure :: widen
      procedure :: widen_rate
      procedure :: widen_change
   end type pins_t

contains

   !> From the point to the center of mass.
   pure function arm_of(pin, small) result(r)
      type(pin_t), intent(in) :: pin
      type(state_t), intent(in) :: small
      real(wp) :: r(2)
      real(wp) :: c, s

      c = cos(small%x(pin%angle))
      s = sin(small%x(pin%angle))
      r(1) = c*pin%center(1) - s*pin%center(2)
      r(2) = s*pin%center(1) + c*pin%center(2)
   end function arm_of

   !> Centers of mass, and their velocities.
   pure subroutine widen(self, small, x, v)
      !> The bodies.
      class(pins_t), intent(in) :: self
      !> State of the smaller system.
      type(state_t), intent(in) :: small
      !> Coordinates: (n_x).
      real(wp), intent(inout) :: x(:)
      !> Velocities: (n).
      real(wp), intent(inout) :: v(:)
      real(wp) :: r(2), w
      integer :: i

      do i = 1, size(self%pins)
         associate (pin => self%pins(i))
            r = arm_of(pin, small)
            w = small%v(pin%rate)
            x(pin%x) = pin%place(1) + r(1)
            x(pin%x + 1) = pin%place(2) + r(2)
            v(pin%v) = -w*r(2)
            v(pin%v + 1) = w*r(1)
         end associate
      end do
   end subroutine widen

   !> Their velocities and accelerations.
   pure subroutine widen_rate(self, small, xdot, vdot)
      !> The bodies.
      class(pins_t), intent(in) :: self
      !> State of the smaller system.
      type(state_t), intent(in) :: small
      !> Rates of the coordinates: (n_x).
      real(wp), intent(inout) :: xdot(:)
      !> Accelerations, those of angles in place: (n).
      real(wp), intent(inout) :: vdot(:)
      real(wp) :: r(2), w, wdot
      integer :: i

      do i = 1, size(self%pins)
         associate (pin => self%pins(i))
            r = arm_of(pin, small)
            w = small%v(pin%rate)
            wdot = vdot(pin%v + 2)
            xdot(pin%x) = -w*r(2)
            xdot(pin%x + 1) = w*r(1)
            vdot(pin%v) = -wdot*r(2) - w*w*r(1)
            vdot(pin%v + 1) = wdot*r(1) - w*w*r(2)
         end associate
      end do
   end subroutine widen_rate

   !> Changes of both.
   pure subroutine widen_change(self, small, dx, dv)
      !> The bodies.
      class(pins_t), intent(in) :: self
      !> State of the smaller system.
      type(state_t), intent(in) :: small
      !> Changes of the coordinates, those of angles in place: (n_x).
      real(wp), intent(inout) :: dx(:)
      !> Changes of the velocities, likewise: (n).
      real(wp), intent(inout) :: dv(:)
      real(wp) :: change, r(2), w
      integer :: i

      do i = 1, size(self%pins)
         associate (pin => self%pins(i))
            r = arm_of(pin, small)
            w = small%v(pin%rate)
            change = dx(pin%x + 2)
            dx(pin%x) = -change*r(2)
            dx(pin%x + 1) = change*r(1)
            dv(pin%v) = -dv(pin%v + 2)*r(2) - w*change*r(1)
            dv(pin%v + 1) = dv(pin%v + 2)*r(1) - w*change*r(2)
         end associate
      end do
   end subroutine widen_change

end module taut_model_mechanism_pins
