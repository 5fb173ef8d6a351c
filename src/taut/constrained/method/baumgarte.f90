!> Baumgarte's stabilization of Eq. (8), A vdot = b'' - 2 alpha (A v - b') - beta^2 phi.
!!
!! Source: J. Baumgarte, Stabilization of constraints and integrals of motion in dynamical systems, Comput. Methods Appl. Mech.
!! Eng. 1 (1972) 1-16, reference [21] of the paper.
module taut_constrained_method_baumgarte
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_constrained_method_baseline, only: baseline_t
   use taut_constrained_method_options, only: method_t
   implicit none (type, external)
   private
   public :: baumgarte_t

   !> The method `baumgarte`.
   type, extends(baseline_t) :: baumgarte_t
   contains
      procedure :: check_options
      procedure :: stabilize
   end type baumgarte_t

contains

   !> Whether the gains make sense.
   subroutine check_options(self, options, error)
      !> The formulation, not yet set up.
      class(baumgarte_t), intent(in) :: self
      !> The options.
      type(method_t), intent(in) :: options
      !> A gain that is negative.
      type(error_t), allocatable, intent(inout) :: error

      if (.not. (options%alpha >= 0.0_wp .and. options%beta >= 0.0_wp)) &
         call raise(error, options%place(), 'alpha = '//to_text(options%alpha)//', beta = '//to_text(options%beta)// &
                    ': a gain is negative', 'give gains such as 2')
      associate (unused_formulation => self)
      end associate
   end subroutine check_options

   !> b'' - 2 alpha (A v - b') - beta^2 phi.
   subroutine stabilize(self, b_second)
      !> The formulation, with A and the state in place.
      class(baumgarte_t), intent(inout) :: self
      !> b'': (c).
      real(wp), intent(inout), contiguous :: b_second(:)
      real(wp) :: gain_v, gain_x
      integer :: i

      gain_v = 2.0_wp*self%options%alpha
      gain_x = self%options%beta**2
      if (gain_v <= 0.0_wp .and. gain_x <= 0.0_wp) return
      call self%find_violations()
      do i = 1, self%model%c
         b_second(i) = b_second(i) - gain_v*self%phidot(i)
      end do
      do i = 1, self%model%n_phi
         b_second(i) = b_second(i) - gain_x*self%phi(i)
      end do
   end subroutine stabilize

end module taut_constrained_method_baumgarte
