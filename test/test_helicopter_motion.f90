!> The motion of the helicopter blade of Sect. 4.3 against an integration in minimal coordinates and closed forms.
module test_helicopter_motion
   use taut, only: consistent_start, error_t, integration_options_t, integration_result_t, integrator_t, method_t, &
                  ode_system_t, rhs_ok, start_report_t, state_t, status_reached_end, wp
   use taut_model_helicopter, only: helicopter_data_t, helicopter_t, new_helicopter
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   use blades, only: fly, known_motion_t, motion_at, sampler_t, strict
   implicit none (type, external)
   private
   public :: collect_helicopter_motion

   real(wp), parameter :: pi = acos(-1.0_wp)

   !> The blade with the pitch eliminated: y = {beta, beta rate}. The link is written as the square of its length,
   !! g(beta, theta, t) = |x_A - x_B|^2 - L^2, multiplied out; only z_B moves.
   type, extends(ode_system_t) :: eliminated_t
      type(helicopter_data_t) :: data
      real(wp) :: theta = 0.0_wp, theta_rate = 0.0_wp, force = 0.0_wp
   contains
      procedure :: rhs => eliminated_rhs
   end type eliminated_t

contains

   !> All tests of this module.
   function collect_helicopter_motion() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('motion and link force of an integration with the pitch eliminated', minimal_coordinates), &
               new_test('the same with a swashplate that moves', minimal_coordinates_cyclic), &
               new_test('driven by its stiffness: closed form', closed_form_driven), &
               new_test('free of its link: closed form', closed_form_free), &
               new_test('swashplate: stiffness and constraint agree', cyclic_stiffness)]
   end function collect_helicopter_motion

   !> z_B and its rates.
   pure subroutine height(data, t, z)
      type(helicopter_data_t), intent(in) :: data
      real(wp), intent(in) :: t
      real(wp), intent(out) :: z(0:2)

      z(0) = data%b_mean(3) + data%b_cosine(3)*cos(data%omega*t) + data%b_sine(3)*sin(data%omega*t)
      z(1) = data%omega*(data%b_sine(3)*cos(data%omega*t) - data%b_cosine(3)*sin(data%omega*t))
      z(2) = -data%omega**2*(z(0) - data%b_mean(3))
   end subroutine height

   !> The right-hand side that knows no multiplier: theta by Newton from g = 0, its rates from dg/dt = d2g/dt2 = 0.
   subroutine eliminated_rhs(self, t, y, dydt, info)
      class(eliminated_t), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(out), contiguous :: dydt(:)
      integer, intent(out) :: info
      real(wp) :: z(0:2), g, g_b, g_t, g_z, g_bb, g_bt, g_tt, g_bz, g_tz, slope, theta_0, p, q, f(2), m(2, 2), beta_2, theta_2
      integer :: iteration

      call height(self%data, t, z)
      do iteration = 1, 50
         call square(self%data, y(1), self%theta, z(0), g, g_b, g_t, g_z, g_bb, g_bt, g_tt, g_bz, g_tz)
         self%theta = self%theta - g/g_t
         if (abs(g) < 1.0e-17_wp) exit
      end do
      call square(self%data, y(1), self%theta, z(0), g, g_b, g_t, g_z, g_bb, g_bt, g_tt, g_bz, g_tz)
      associate (d => self%data)
         p = y(2)
         q = -(g_b*p + g_z*z(1))/g_t
         ! theta'' = slope beta'' + theta_0.
         slope = -g_b/g_t
         theta_0 = -(g_bb*p**2 + 2.0_wp*g_bt*p*q + g_tt*q**2 + 2.0_wp*(g_bz*p + g_tz*q)*z(1) + 2.0_wp*z(1)**2 + g_z*z(2))/g_t
         f(1) = d%m_beta1*cos(d%omega*t + d%phi_beta1) + d%m_beta0 - 0.0625_wp*d%gamma*d%omega*d%i_b*p &
                - d%i_b*d%omega**2*(1.0_wp + 1.5_wp*d%x_beta/(d%radius - d%x_beta))*y(1) + d%i_x*d%omega**2*self%theta
         f(2) = d%m_theta1*cos(d%omega*t + d%phi_theta1) + d%m_theta0 - d%i_f*d%omega**2*self%theta + d%i_x*d%omega**2*y(1)
         m(1, :) = [d%i_b, -d%i_x]
         m(2, :) = [-d%i_x, d%i_f]
      end associate
      ! Eq. (3): the equations of motion along the motion that the link leaves, {1, slope}.
      beta_2 = (f(1) + slope*f(2) - theta_0*(m(1, 2) + slope*m(2, 2))) &
               /(m(1, 1) + 2.0_wp*slope*m(1, 2) + slope**2*m(2, 2))
      theta_2 = slope*beta_2 + theta_0
      self%theta_rate = q
      ! Pitch: I_f theta'' - I_x beta'' = f_theta - T dl/dtheta, with dl/dtheta = (dg/dtheta)/(2 l).
      self%force = (f(2) - m(2, 1)*beta_2 - m(2, 2)*theta_2)*2.0_wp*self%data%length/g_t
      dydt = [y(2), beta_2]
      info = rhs_ok
   end subroutine eliminated_rhs

   !> g = |x_A - x_B|^2 - L^2 and its derivatives, multiplied out; (b, t, z) stand for beta, theta, z_B; d2g/dz2 = 2.
   pure subroutine square(d, beta, theta, z, g, g_b, g_t, g_z, g_bb, g_bt, g_tt, g_bz, g_tz)
      type(helicopter_data_t), intent(in) :: d
      real(wp), intent(in) :: beta, theta, z
      real(wp), intent(out) :: g, g_b, g_t, g_z, g_bb, g_bt, g_tt, g_bz, g_tz
      real(wp) :: cb, ct, gap, sb, st, x, y

      cb = cos(beta)
      sb = sin(beta)
      ct = cos(theta)
      st = sin(theta)
      x = d%x_theta
      y = d%y_theta
      gap = d%x_beta - d%b_mean(1)
      g = gap**2 + x**2 + y**2 + d%b_mean(2)**2 + z**2 - d%length**2 + 2.0_wp*gap*(x*cb - y*sb*st) - 2.0_wp*d%b_mean(2)*y*ct &
          - 2.0_wp*z*(x*sb + y*cb*st)
      g_b = -2.0_wp*gap*(x*sb + y*cb*st) - 2.0_wp*z*(x*cb - y*sb*st)
      g_t = -2.0_wp*gap*y*sb*ct + 2.0_wp*d%b_mean(2)*y*st - 2.0_wp*z*y*cb*ct
      g_z = 2.0_wp*z - 2.0_wp*(x*sb + y*cb*st)
      g_bb = -2.0_wp*gap*(x*cb - y*sb*st) + 2.0_wp*z*(x*sb + y*cb*st)
      g_bt = -2.0_wp*gap*y*cb*ct + 2.0_wp*z*y*sb*ct
      g_tt = 2.0_wp*gap*y*sb*st + 2.0_wp*d%b_mean(2)*y*ct + 2.0_wp*z*y*cb*st
      g_bz = -2.0_wp*(x*cb - y*sb*st)
      g_tz = -2.0_wp*y*cb*ct
   end subroutine square

   subroutine minimal_coordinates(failure)
      character(:), allocatable, intent(inout) :: failure
      type(helicopter_data_t) :: data

      call compare_with_eliminated(data, failure)
      data%m_beta0 = 2.0e4_wp
      data%m_theta0 = 30.0_wp
      data%m_theta1 = -20.0_wp
      data%phi_theta1 = 0.7_wp
      call compare_with_eliminated(data, failure)
   end subroutine minimal_coordinates

   subroutine minimal_coordinates_cyclic(failure)
      character(:), allocatable, intent(inout) :: failure
      type(helicopter_data_t) :: data

      data%b_mean = [0.26_wp, 0.18_wp, -0.13_wp]
      data%b_cosine(3) = 0.02_wp
      data%b_sine(3) = -0.015_wp
      call compare_with_eliminated(data, failure)
   end subroutine minimal_coordinates_cyclic

   subroutine compare_with_eliminated(data, failure)
      type(helicopter_data_t), intent(in) :: data
      character(:), allocatable, intent(inout) :: failure
      character(len=8), parameter :: names(2) = [character(len=8) :: 'present', 'baseline']
      type(eliminated_t) :: reference
      type(helicopter_t) :: model
      type(integrator_t) :: integrator
      type(integration_result_t) :: result
      type(sampler_t) :: sampler
      type(start_report_t) :: report
      type(state_t) :: start, at
      type(method_t) :: method
      type(error_t), allocatable :: error
      real(wp) :: t, y(2), dydt(2), scale
      integer :: i, info

      call new_helicopter(model, data, error)
      start%x = [0.0_wp, 0.0_wp]
      start%v = [0.0_wp, 0.0_wp]
      call consistent_start(model, method, start, report, error)
      call no_error(failure, error)
      reference%data = data
      reference%theta = start%x(2)
      t = 0.0_wp
      y = [start%x(1), start%v(1)]
      call integrator%init(2, strict(), error)
      call integrator%run(reference, t, y, 2.0_wp, result)
      call check(failure, result%status == status_reached_end, 'the reference reaches the end')
      call reference%rhs(t, y, dydt, info)
      scale = max(1.0_wp, abs(reference%force))
      do i = 1, 2
         at = start
         call fly(data, trim(names(i)), strict(), 2.0_wp, result, sampler, failure, at)
         call check_below(failure, maxval(abs([at%x, at%v] - [y(1), reference%theta, y(2), reference%theta_rate])), 1.0e-8_wp, &
                          trim(names(i))//': motion')
         call check_below(failure, (sampler%force - reference%force)/scale, 1.0e-8_wp, trim(names(i))//': link force')
      end do
   end subroutine compare_with_eliminated

   !> The linear equations (30) with K_c, on their steady motion: constant and one per revolution.
   subroutine closed_form_driven(failure)
      character(:), allocatable, intent(inout) :: failure
      type(helicopter_data_t) :: data
      type(integration_result_t) :: result
      type(sampler_t) :: sampler
      type(known_motion_t) :: motion
      type(state_t) :: at
      real(wp) :: k(2, 2), m(2, 2), c, y(4)
      complex(wp) :: z(2, 2), f(2)

      data%i_f = 0.5_wp
      data%i_x = 3.0_wp
      data%gamma = 5.0_wp
      data%m_beta0 = 4.0e3_wp
      data%m_theta0 = 300.0_wp
      data%m_theta1 = 700.0_wp
      data%phi_theta1 = 0.4_wp
      data%b_mean(3) = -0.14_wp
      data%b_sine(3) = 0.01_wp
      data%control_frequency = 9.0_wp
      m = reshape([data%i_b, -data%i_x, -data%i_x, data%i_f], [2, 2])
      c = 5.0_wp/16.0_wp*40.0_wp*data%i_b
      k(1, :) = 1600.0_wp*[1.0625_wp*data%i_b, -data%i_x]
      k(2, :) = 1600.0_wp*[-data%i_x, data%i_f] + data%i_f*(9.0_wp*40.0_wp)**2*[0.25_wp, 1.0_wp]
      z = cmplx(k - 1600.0_wp*m, 0.0_wp, wp)
      z(1, 1) = z(1, 1) + cmplx(0.0_wp, 40.0_wp*c, wp)
      f(1) = data%m_beta1*exp(cmplx(0.0_wp, data%phi_beta1, wp))
      f(2) = data%m_theta1*exp(cmplx(0.0_wp, data%phi_theta1, wp))
      ! B's sine asks for a pitch of 0.01/0.2 sin(Omega t), its mean for 0.01/0.2.
      f(2) = f(2) + data%i_f*360.0_wp**2*cmplx(0.0_wp, -0.05_wp, wp)
      motion%omega = 40.0_wp
      motion%amplitude(1) = (z(2, 2)*f(1) - z(1, 2)*f(2))/(z(1, 1)*z(2, 2) - z(1, 2)*z(2, 1))
      motion%amplitude(2) = (z(1, 1)*f(2) - z(2, 1)*f(1))/(z(1, 1)*z(2, 2) - z(1, 2)*z(2, 1))
      associate (f1 => data%m_beta0, f2 => data%m_theta0 + data%i_f*360.0_wp**2*0.05_wp)
         motion%constant = [k(2, 2)*f1 - k(1, 2)*f2, k(1, 1)*f2 - k(2, 1)*f1]/(k(1, 1)*k(2, 2) - k(1, 2)*k(2, 1))
      end associate
      allocate (sampler%expected, source=motion)
      y = motion_at(motion, 0.0_wp)
      at%x = y(1:2)
      at%v = y(3:4)
      call fly(data, 'unconstrained', strict(), 2.0_wp, result, sampler, failure, at)
      call check_below(failure, sampler%worst_motion, 1.0e-8_wp, 'motion')
      call check_below(failure, sampler%worst_lambda, 0.0_wp, 'there is no multiplier')
      associate (theta_c => 0.05_wp + 0.05_wp*sin(80.0_wp), y_end => motion_at(motion, 2.0_wp))
         call check_close(failure, sampler%force, -data%i_f*360.0_wp**2*(theta_c - y_end(2) - 0.25_wp*y_end(1))/0.2_wp, 1.0e-5_wp, &
                          'link force')
      end associate
   end subroutine closed_form_driven

   !> Neither link nor coupling: a damped flap, and a pitch that turns once per revolution.
   subroutine closed_form_free(failure)
      character(:), allocatable, intent(inout) :: failure
      type(helicopter_data_t) :: data
      type(integration_result_t) :: result
      type(sampler_t) :: sampler
      type(known_motion_t) :: motion
      type(state_t) :: at
      real(wp) :: y(4)

      data%control_frequency = 0.0_wp
      data%i_x = 0.0_wp
      data%m_beta1 = 0.0_wp
      motion%free = [cmplx(0.1_wp, 0.02_wp, wp), cmplx(0.05_wp, -0.04_wp, wp)]
      ! beta'' + gamma/16 Omega beta' + Omega^2 nu^2 beta = 0.
      motion%exponent = [cmplx(-10.0_wp, sqrt(1700.0_wp - 100.0_wp), wp), cmplx(0.0_wp, 40.0_wp, wp)]
      allocate (sampler%expected, source=motion)
      y = motion_at(motion, 0.0_wp)
      at%x = y(1:2)
      at%v = y(3:4)
      call fly(data, 'unconstrained', strict(), 2.0_wp, result, sampler, failure, at)
      call check_below(failure, sampler%worst_motion, 1.0e-8_wp, 'motion')
   end subroutine closed_form_free

   !> With a moving swashplate and a strict tolerance, the stiffness follows the constraint as far as it is linear.
   subroutine cyclic_stiffness(failure)
      character(:), allocatable, intent(inout) :: failure
      type(helicopter_data_t) :: data
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(sampler_t) :: sampler
      type(state_t) :: constrained, sprung

      data%b_sine(3) = 1.0e-3_wp
      data%m_beta1 = 100.0_wp
      data%control_frequency = 42.0_wp
      options = strict()
      constrained%x = [0.0_wp, 0.0_wp]
      constrained%v = [0.0_wp, 0.2_wp]
      sprung = constrained
      call fly(data, 'present', options, 0.5_wp, result, sampler, failure, constrained)
      call fly(data, 'unconstrained', options, 0.5_wp, result, sampler, failure, sprung)
      call check(failure, abs(constrained%x(2)) > 1.0e-3_wp, 'the blade is pitched')
      call check_below(failure, maxval(abs(constrained%x - sprung%x)), 5.0e-5_wp, 'angles')
   end subroutine cyclic_stiffness

end module test_helicopter_motion
