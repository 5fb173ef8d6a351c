!> Andrews' squeezing mechanism in its seven angles, written as a user of taut would write it: three loops that close, and a mass
!! matrix that depends on the configuration.
!!
!! Source: W. Schiehlen (ed.), Multibody Systems Handbook, Springer 1990; equations and reference values as in Hairer and Wanner,
!! Solving Ordinary Differential Equations II, Sect. VII.7, and the test set for IVP solvers. Angles in the order beta, Theta,
!! gamma, Phi, delta, Omega, epsilon; lengths in m, masses in kg, moments of inertia in kg m^2.
module squeezer
   use taut, only: block_diagonal_t, mechanical_system_t, state_t, wp
   use taut_jet
   implicit none (type, external)
   private
   public :: squeezer_t, new_squeezer, squeezer_start, loops, end_angles, end_velocities

   real(wp), parameter :: m1 = 0.04325_wp, m2 = 0.00365_wp, m3 = 0.02373_wp, m4 = 0.00706_wp, m5 = 0.07050_wp, m6 = 0.00706_wp, &
                          m7 = 0.05498_wp
   real(wp), parameter :: i1 = 2.194e-6_wp, i2 = 4.410e-7_wp, i3 = 5.255e-6_wp, i4 = 5.667e-7_wp, i5 = 1.169e-5_wp, &
                          i6 = 5.667e-7_wp, i7 = 1.912e-5_wp
   real(wp), parameter :: xa = -0.06934_wp, ya = -0.00227_wp, xb = -0.03635_wp, yb = 0.03273_wp, xc = 0.014_wp, yc = 0.072_wp
   real(wp), parameter :: d = 0.028_wp, da = 0.0115_wp, e = 0.02_wp, ea = 0.01421_wp, rr = 0.007_wp, ra = 0.00092_wp, &
                          ss = 0.035_wp, sa = 0.01874_wp, sb = 0.01043_wp, sc = 0.018_wp, sd = 0.02_wp, ta = 0.02308_wp, &
                          tb = 0.00916_wp, u = 0.04_wp, ua = 0.01228_wp, ub = 0.00449_wp, zf = 0.02_wp, zt = 0.04_wp, &
                          fa = 0.01421_wp
   !> Stiffness [N/m] and free length [m] of the spring, moment of the motor [N m].
   real(wp), parameter :: c0 = 4530.0_wp, l0 = 0.07785_wp, motor = 0.033_wp

   !> Published angles [rad] and velocities [rad/s] at 0.03 s.
   real(wp), parameter :: end_angles(7) = [15.81077119629904_wp, -15.75637105984298_wp, 0.04082224013073101_wp, &
                                           -0.5347301163226948_wp, 0.5244099658805304_wp, 0.5347301163226948_wp, &
                                           1.048080741042263_wp]
   real(wp), parameter :: end_velocities(7) = [1139.920302151208_wp, -1424.379294994111_wp, 11.03291221937134_wp, &
                                               19.29337464421385_wp, 0.5735699284790808_wp, -19.29337464421385_wp, &
                                               0.3231791658026955_wp]

   !> The mechanism.
   type, extends(mechanical_system_t) :: squeezer_t
   contains
      procedure :: mass
      procedure :: force
      procedure :: constraint
      procedure :: jacobian
      procedure :: acceleration_rhs
   end type squeezer_t

contains

   !> The mechanism with its sizes.
   function new_squeezer() result(self)
      type(squeezer_t) :: self

      call self%define(n=7, c=6, constant_mass=.false.)
   end function new_squeezer

   !> The published start, at rest.
   function squeezer_start() result(at)
      type(state_t) :: at

      at%x = [-0.0617138900142764496_wp, 0.0_wp, 0.455279819163070380_wp, 0.222668390165885885_wp, 0.487364979543842550_wp, &
              -0.222668390165885885_wp, 1.23054744454982119_wp]
      at%v = [0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      allocate (at%w(0))
   end function squeezer_start

   !> M.
   subroutine mass(self, at, m)
      class(squeezer_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m
      real(wp) :: k(7, 7)

      k = 0.0_wp
      associate (co_theta => cos(at%x(2)), si_phi => sin(at%x(4)), si_omega => sin(at%x(6)))
         k(1, 1) = m1*ra**2 + m2*(rr**2 - 2.0_wp*da*rr*co_theta + da**2) + i1 + i2
         k(2, 1) = m2*(da**2 - da*rr*co_theta) + i2
         k(2, 2) = m2*da**2 + i2
         k(3, 3) = m3*(sa**2 + sb**2) + i3
         k(4, 4) = m4*(e - ea)**2 + i4
         k(5, 4) = m4*((e - ea)**2 + zt*(e - ea)*si_phi) + i4
         k(5, 5) = m4*(zt**2 + 2.0_wp*zt*(e - ea)*si_phi + (e - ea)**2) + m5*(ta**2 + tb**2) + i4 + i5
         k(6, 6) = m6*(zf - fa)**2 + i6
         k(7, 6) = m6*((zf - fa)**2 - u*(zf - fa)*si_omega) + i6
         k(7, 7) = m6*((zf - fa)**2 - 2.0_wp*u*(zf - fa)*si_omega + u**2) + m7*(ua**2 + ub**2) + i6 + i7
      end associate
      k(1, 2) = k(2, 1)
      k(4, 5) = k(5, 4)
      k(6, 7) = k(7, 6)
      call m%set_dense(k)
      associate (unused_system => self)
      end associate
   end subroutine mass

   !> f.
   subroutine force(self, at, value)
      class(squeezer_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      real(wp) :: co, dx, dy, length, pull, si

      si = sin(at%x(3))
      co = cos(at%x(3))
      dx = sd*co + sc*si + xb - xc
      dy = sd*si - sc*co + yb - yc
      length = sqrt(dx**2 + dy**2)
      pull = -c0*(length - l0)/length
      associate (v => at%v, x => at%x)
         value(1) = motor - m2*da*rr*v(2)*(v(2) + 2.0_wp*v(1))*sin(x(2))
         value(2) = m2*da*rr*v(1)**2*sin(x(2))
         value(3) = pull*(dx*(sc*co - sd*si) + dy*(sd*co + sc*si))
         value(4) = m4*zt*(e - ea)*v(5)**2*cos(x(4))
         value(5) = -m4*zt*(e - ea)*v(4)*(v(4) + 2.0_wp*v(5))*cos(x(4))
         value(6) = -m6*u*(zf - fa)*v(7)**2*cos(x(6))
         value(7) = m6*u*(zf - fa)*v(6)*(v(6) + 2.0_wp*v(7))*cos(x(6))
      end associate
      associate (unused_system => self)
      end associate
   end subroutine force

   !> phi: where the three loops meet [m].
   subroutine constraint(self, at, value)
      class(squeezer_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      real(wp) :: x_e, y_e

      associate (x => at%x)
         x_e = rr*cos(x(1)) - d*cos(x(1) + x(2))
         y_e = rr*sin(x(1)) - d*sin(x(1) + x(2))
         value(1) = x_e - ss*sin(x(3)) - xb
         value(2) = y_e + ss*cos(x(3)) - yb
         value(3) = x_e - e*sin(x(4) + x(5)) - zt*cos(x(5)) - xa
         value(4) = y_e + e*cos(x(4) + x(5)) - zt*sin(x(5)) - ya
         value(5) = x_e - zf*cos(x(6) + x(7)) - u*sin(x(7)) - xa
         value(6) = y_e - zf*sin(x(6) + x(7)) + u*cos(x(7)) - ya
      end associate
      associate (unused_system => self)
      end associate
   end subroutine constraint

   !> The same with jets.
   pure subroutine loops(x, value)
      type(jet_t), intent(in) :: x(:)
      type(jet_t), intent(out) :: value(:)
      type(jet_t) :: x_e, y_e

      x_e = rr*cos(x(1)) - d*cos(x(1) + x(2))
      y_e = rr*sin(x(1)) - d*sin(x(1) + x(2))
      value(1) = x_e - ss*sin(x(3)) - xb
      value(2) = y_e + ss*cos(x(3)) - yb
      value(3) = x_e - e*sin(x(4) + x(5)) - zt*cos(x(5)) - xa
      value(4) = y_e + e*cos(x(4) + x(5)) - zt*sin(x(5)) - ya
      value(5) = x_e - zf*cos(x(6) + x(7)) - u*sin(x(7)) - xa
      value(6) = y_e - zf*sin(x(6) + x(7)) + u*cos(x(7)) - ya
   end subroutine loops

   !> A.
   subroutine jacobian(self, at, a)
      class(squeezer_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)
      integer :: i

      a(:, :) = 0.0_wp
      associate (x => at%x)
         a(1, 2) = d*sin(x(1) + x(2))
         a(2, 2) = -d*cos(x(1) + x(2))
         a(1, 1) = a(1, 2) - rr*sin(x(1))
         a(2, 1) = a(2, 2) + rr*cos(x(1))
         do i = 3, 5, 2
            a(i, 1:2) = a(1, 1:2)
            a(i + 1, 1:2) = a(2, 1:2)
         end do
         a(1, 3) = -ss*cos(x(3))
         a(2, 3) = -ss*sin(x(3))
         a(3, 4) = -e*cos(x(4) + x(5))
         a(4, 4) = -e*sin(x(4) + x(5))
         a(3, 5) = a(3, 4) + zt*sin(x(5))
         a(4, 5) = a(4, 4) - zt*cos(x(5))
         a(5, 6) = zf*sin(x(6) + x(7))
         a(6, 6) = -zf*cos(x(6) + x(7))
         a(5, 7) = a(5, 6) - u*cos(x(7))
         a(6, 7) = a(6, 6) - u*sin(x(7))
      end associate
      associate (unused_system => self)
      end associate
   end subroutine jacobian

   !> b'': minus the accelerations that the loops' ends have while the angles' rates stay as they are [m/s^2].
   subroutine acceleration_rhs(self, at, value)
      class(squeezer_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      real(wp) :: x_e, y_e

      associate (v => at%v, x => at%x)
         x_e = rr*cos(x(1))*v(1)**2 - d*cos(x(1) + x(2))*(v(1) + v(2))**2
         y_e = rr*sin(x(1))*v(1)**2 - d*sin(x(1) + x(2))*(v(1) + v(2))**2
         value(1) = x_e - ss*sin(x(3))*v(3)**2
         value(2) = y_e + ss*cos(x(3))*v(3)**2
         value(3) = x_e - e*sin(x(4) + x(5))*(v(4) + v(5))**2 - zt*cos(x(5))*v(5)**2
         value(4) = y_e + e*cos(x(4) + x(5))*(v(4) + v(5))**2 - zt*sin(x(5))*v(5)**2
         value(5) = x_e - zf*cos(x(6) + x(7))*(v(6) + v(7))**2 - u*sin(x(7))*v(7)**2
         value(6) = y_e - zf*sin(x(6) + x(7))*(v(6) + v(7))**2 + u*cos(x(7))*v(7)**2
      end associate
      associate (unused_system => self)
      end associate
   end subroutine acceleration_rhs

end module squeezer
