!> Radau IIA of order 5 in numbers: its stages, the modes that its matrix falls apart into, its estimate of the error and its
!! continuous extension.
!!
!! Source: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., Springer 1996, Sect. IV.8.
module taut_ode_stepper_radau_tableau
   use taut_kinds, only: wp
   implicit none (type, external)
   private
   public :: b, b_low, c, d, e, from_modes, increments, nu, through_stages, to_modes

   real(wp), parameter :: s6 = sqrt(6.0_wp)
   !> Nodes.
   real(wp), parameter :: c(3) = [(4.0_wp - s6)/10.0_wp, (4.0_wp + s6)/10.0_wp, 1.0_wp]
   !> Weights of barycentric interpolation at the nodes, with the step's start.
   real(wp), parameter :: weight(3) = [1.0_wp/(c(1)*(c(1) - c(2))*(c(1) - 1.0_wp)), &
                                       1.0_wp/(c(2)*(c(2) - c(1))*(c(2) - 1.0_wp)), 1.0_wp/((1.0_wp - c(1))*(1.0_wp - c(2)))]
   !> h ydot at the nodes from the increments there: the inverse of the Runge-Kutta matrix, column by column.
   real(wp), parameter :: d(3, 3) = reshape([ &
      1.0_wp/c(1) + 1.0_wp/(c(1) - c(2)) + 1.0_wp/(c(1) - 1.0_wp), weight(1)/weight(2)/(c(2) - c(1)), &
      weight(1)/weight(3)/(1.0_wp - c(1)), &
      weight(2)/weight(1)/(c(1) - c(2)), 1.0_wp/c(2) + 1.0_wp/(c(2) - c(1)) + 1.0_wp/(c(2) - 1.0_wp), &
      weight(2)/weight(3)/(1.0_wp - c(2)), &
      weight(3)/weight(1)/(c(1) - 1.0_wp), weight(3)/weight(2)/(c(2) - 1.0_wp), &
      1.0_wp + 1.0_wp/(1.0_wp - c(1)) + 1.0_wp/(1.0_wp - c(2))], [3, 3])
   !> Eigenvalues of d: one real, a complex pair.
   real(wp), parameter :: root = 3.0_wp**(2.0_wp/3.0_wp), root_2 = 3.0_wp*3.0_wp**(1.0_wp/3.0_wp)
   real(wp), parameter :: nu_real = 30.0_wp/(6.0_wp + root_2 - root)
   real(wp), parameter :: inverse_real = (12.0_wp - root_2 + root)/60.0_wp, inverse_imaginary = (root_2 + root)*sqrt(3.0_wp)/60.0_wp
   real(wp), parameter :: square = inverse_real**2 + inverse_imaginary**2
   complex(wp), parameter :: nu(2) = [cmplx(nu_real, 0.0_wp, wp), cmplx(inverse_real/square, inverse_imaginary/square, wp)]
   !> Eigenvectors of d, and their inverse, rounded as in RADAU5 of E. Hairer and G. Wanner; column by column.
   real(wp), parameter :: from_modes(3, 3) = reshape([ &
      9.1232394870892942792e-02_wp, 0.24171793270710701896_wp, 0.96604818261509293619_wp, &
      -0.14125529502095420843_wp, 0.20412935229379993199_wp, 1.0_wp, &
      -3.0029194105147424492e-02_wp, 0.38294211275726193779_wp, 0.0_wp], [3, 3])
   real(wp), parameter :: to_modes(3, 3) = reshape([ &
      4.3255798900631553510_wp, -4.1787185915519047273_wp, -0.50287263494578687595_wp, &
      0.33919925181580986954_wp, -0.32768282076106238708_wp, 2.5719269498556054292_wp, &
      0.54177053993587487119_wp, 0.47662355450055045196_wp, -0.59603920482822492497_wp], [3, 3])
   !> The estimate of the error: ydot + e z/h.
   real(wp), parameter :: e(3) = [-(13.0_wp + 7.0_wp*s6)/3.0_wp, (-13.0_wp + 7.0_wp*s6)/3.0_wp, -1.0_wp/3.0_wp]

   !> Weights of the solution: those of the integral over the step.
   real(wp), parameter :: b(3) = [(16.0_wp - s6)/36.0_wp, (16.0_wp + s6)/36.0_wp, 1.0_wp/9.0_wp]
   real(wp), parameter :: b_second = (0.5_wp*c(2) - 1.0_wp/3.0_wp)/(c(1)*(c(2) - c(1))), &
                          b_third = (0.5_wp*c(1) - 1.0_wp/3.0_wp)/(c(2)*(c(1) - c(2)))
   !> Weights at the start and the first two stages, of order 3: for an estimate of its error.
   real(wp), parameter :: b_low(3) = [1.0_wp - b_second - b_third, b_second, b_third]

contains

   !> Weights of the stages' increments at a fraction of the step: the polynomial of degree 3 that starts from zero.
   pure function increments(theta) result(w)
      !> Fraction of the step.
      real(wp), intent(in) :: theta
      !> Weights.
      real(wp) :: w(3)

      w(1) = theta*(theta - c(2))*(theta - 1.0_wp)*weight(1)
      w(2) = theta*(theta - c(1))*(theta - 1.0_wp)*weight(2)
      w(3) = theta*(theta - c(1))*(theta - c(2))*weight(3)
   end function increments

   !> Weights of the stages' values at a fraction of the step: the polynomial of degree 2.
   pure function through_stages(theta) result(w)
      !> Fraction of the step.
      real(wp), intent(in) :: theta
      !> Weights.
      real(wp) :: w(3)

      w(1) = (theta - c(2))*(theta - 1.0_wp)/((c(1) - c(2))*(c(1) - 1.0_wp))
      w(2) = (theta - c(1))*(theta - 1.0_wp)/((c(2) - c(1))*(c(2) - 1.0_wp))
      w(3) = (theta - c(1))*(theta - c(2))/((1.0_wp - c(1))*(1.0_wp - c(2)))
   end function through_stages

end module taut_ode_stepper_radau_tableau
