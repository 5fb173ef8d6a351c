!> Closed forms that the tests compare with.
module closed_forms
   use taut_kinds, only: wp
   implicit none (type, external)
   private
   public :: jacobi, pendulum_motion

contains

   !> Jacobi's elliptic functions by descending Landen transformations.
   !!
   !! Source: M. Abramowitz, I.A. Stegun, Handbook of Mathematical Functions, 1964, 16.4, and 17.6 for K.
   pure subroutine jacobi(u, k, sn, cn, dn, quarter_period)
      !> Argument and modulus, 0 < k < 1.
      real(wp), intent(in) :: u, k
      real(wp), intent(out) :: sn, cn, dn
      !> K(k).
      real(wp), intent(out) :: quarter_period
      real(wp), parameter :: pi = acos(-1.0_wp)
      real(wp) :: a(0:12), c(0:12), b, phi, phi_before
      integer :: i, n

      a(0) = 1.0_wp
      b = sqrt(1.0_wp - k*k)
      c(0) = k
      n = 0
      do while (abs(c(n)) > 1.0e-17_wp .and. n < 12)
         a(n + 1) = 0.5_wp*(a(n) + b)
         c(n + 1) = 0.5_wp*(a(n) - b)
         b = sqrt(a(n)*b)
         n = n + 1
      end do
      quarter_period = pi/(2.0_wp*a(n))
      phi = 2.0_wp**n*a(n)*u
      phi_before = phi
      do i = n, 1, -1
         phi_before = phi
         phi = 0.5_wp*(phi + asin(c(i)*sin(phi)/a(i)))
      end do
      sn = sin(phi)
      cn = cos(phi)
      dn = cos(phi)/cos(phi_before - phi)
      if (abs(cos(phi_before - phi)) < 0.1_wp) dn = sqrt(1.0_wp - (k*sn)**2)
   end subroutine jacobi

   !> A pendulum released at rest at an angle from the downward vertical.
   !!
   !! sin(angle/2) = k sn(K - sqrt(g/l) t), k = sin(angle_0/2).
   pure subroutine pendulum_motion(t, l, g, angle_0, angle, rate, period)
      !> Time [s], length [m], gravity [m/s^2], initial angle [rad].
      real(wp), intent(in) :: t, l, g, angle_0
      !> Angle [rad], its rate [rad/s], period [s].
      real(wp), intent(out) :: angle, rate, period
      real(wp) :: cn, dn, k, omega, quarter_period, sn

      omega = sqrt(g/l)
      k = sin(0.5_wp*angle_0)
      call jacobi(0.0_wp, k, sn, cn, dn, quarter_period)
      period = 4.0_wp*quarter_period/omega
      call jacobi(quarter_period - omega*t, k, sn, cn, dn, quarter_period)
      angle = 2.0_wp*asin(k*sn)
      rate = -2.0_wp*k*omega*cn
   end subroutine pendulum_motion

end module closed_forms
