!> Braun and Goldfarb's stabilization, A xdot = b' - phi/dt and A vdot = b'' - (A v - b')/dt, each met by a projection of its
!! own.
!!
!! Source: reference [30] of the paper.
module taut_constrained_method_braun_goldfarb
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_constrained_method_baseline, only: baseline_t
   use taut_constrained_method_options, only: method_t
   use taut_ode_system, only: rhs_ok
   implicit none (type, external)
   private
   public :: braun_goldfarb_t

   !> The method `braun-goldfarb`.
   type, extends(baseline_t) :: braun_goldfarb_t
   contains
      procedure :: check_options
      procedure :: stabilize
      procedure :: coordinate_rate
   end type braun_goldfarb_t

contains

   !> Whether the time constant makes sense.
   subroutine check_options(self, options, error)
      !> The formulation, not yet set up.
      class(braun_goldfarb_t), intent(in) :: self
      !> The options.
      type(method_t), intent(in) :: options
      !> A time constant that is not positive.
      type(error_t), allocatable, intent(inout) :: error

      if (.not. options%dt > 0.0_wp) &
         call raise(error, options%place(), 'dt = '//to_text(options%dt)//' is not positive', 'give a time near the expected step')
      associate (unused_formulation => self)
      end associate
   end subroutine check_options

   !> b'' - (A v - b')/dt.
   subroutine stabilize(self, b_second)
      !> The formulation, with A and the state in place.
      class(braun_goldfarb_t), intent(inout) :: self
      !> b'': (c).
      real(wp), intent(inout), contiguous :: b_second(:)

      call self%find_violations()
      b_second(:) = b_second - self%phidot/self%options%dt
   end subroutine stabilize

   !> xdot of the velocities that are nearest to v among those with A v = b' - phi/dt.
   subroutine coordinate_rate(self, xdot, info)
      !> The formulation, with A, violations and the state in place.
      class(braun_goldfarb_t), intent(inout) :: self
      !> The rate: (n_x).
      real(wp), intent(inout), contiguous :: xdot(:)
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      call self%projector%linear%factorize(self%model, self%at, info, 0.0_wp)
      if (info /= rhs_ok) return
      self%phidot(:) = 0.0_wp
      self%phidot(:self%model%n_phi) = self%phi/self%options%dt
      call self%projector%shifted_velocity(self%model, self%at, self%phidot)
      call self%model%x_rate(self%at, self%at%v, xdot)
   end subroutine coordinate_rate

end module taut_constrained_method_braun_goldfarb
