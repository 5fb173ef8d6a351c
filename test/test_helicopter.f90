!> The helicopter blade of Sect. 4.3 against an integration in minimal coordinates, closed forms and what the paper says.
module test_helicopter
   use, intrinsic :: ieee_arithmetic, only: ieee_negative_inf, ieee_positive_inf, ieee_value
   use taut, only: consistent_start, constrained_ode_t, error_t, finding_t, integration_options_t, integration_result_t, &
                   integrator_t, mechanical_system_t, method_t, observer_t, ode_system_t, quantity_t, rhs_ok, sample_t, simulate, &
                   start_report_t, state_t, status_reached_end, verify, wp
   use taut_case_helicopter, only: read_helicopter
   use taut_case_namelist_file, only: namelist_file_t
   use taut_case_settings, only: settings_t
   use taut_model_helicopter, only: helicopter_data_t, helicopter_t, new_helicopter
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_helicopter

   real(wp), parameter :: pi = acos(-1.0_wp)

   !> Samples every point.
   type, extends(observer_t) :: sampler_t
      integer :: points = 0
      real(wp) :: worst_phi = 0.0_wp, worst_phidot = 0.0_wp, worst_phiddot = 0.0_wp, worst_energy = 0.0_wp
      real(wp) :: worst_lambda = 0.0_wp, worst_motion = 0.0_wp, first_energy = 0.0_wp, force = 0.0_wp, mu = 0.0_wp
      !> What the motion is compared with, if it is allocated.
      class(known_motion_t), allocatable :: expected
   contains
      procedure :: observe
   end type sampler_t

   !> Motion in closed form: constant + Re(amplitude exp(i omega t)) + free decay of each coordinate by itself.
   type :: known_motion_t
      real(wp) :: omega = 0.0_wp, constant(2) = 0.0_wp
      complex(wp) :: amplitude(2) = (0.0_wp, 0.0_wp), free(2) = (0.0_wp, 0.0_wp), exponent(2) = (0.0_wp, 0.0_wp)
   end type known_motion_t

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
   function collect_helicopter() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('the numbers of Table 3', table_3), &
               new_test('the blade at rest hangs on the vertical link', at_rest), &
               new_test('the model passes its own check', model_is_consistent), &
               new_test('motion and link force of an integration with the pitch eliminated', minimal_coordinates), &
               new_test('the same with a swashplate that moves', minimal_coordinates_cyclic), &
               new_test('steps of the paper, constraint', steps_constraint), &
               new_test('steps of the paper, stiffness', steps_stiffness), &
               new_test('a stiffer control system does not converge', stiffer_control), &
               new_test('driven by its stiffness: closed form', closed_form_driven), &
               new_test('free of its link: closed form', closed_form_free), &
               new_test('energy without damping and load', energy_is_kept), &
               new_test('the stiffness acts where the constraint does not', stiffness_or_constraint), &
               new_test('swashplate: stiffness and constraint agree', cyclic_stiffness), &
               new_test('a start that is not enforced stays', start_stays), &
               new_test('data that make no sense', bad_data), &
               new_test('the shipped case is the paper''s', shipped_case)]
   end function collect_helicopter

   !> The state's sample, its extremes, and its distance from a known motion.
   subroutine observe(self, ode, t, h, y, error)
      class(sampler_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t, h
      real(wp), intent(in), contiguous :: y(:)
      type(error_t), allocatable, intent(inout) :: error
      type(sample_t) :: s
      integer :: info

      select type (ode)
      class is (constrained_ode_t)
         call ode%sample(t, y, s, info)
      end select
      if (self%points == 0) self%first_energy = s%energy
      self%points = self%points + 1
      self%worst_phi = max(self%worst_phi, s%phi)
      self%worst_phidot = max(self%worst_phidot, s%phidot)
      self%worst_phiddot = max(self%worst_phiddot, s%phiddot)
      self%worst_energy = max(self%worst_energy, abs(s%energy - self%first_energy))
      self%worst_lambda = max(self%worst_lambda, abs(s%lambda(1)))
      self%force = s%outputs(1)
      self%mu = max(self%mu, abs(s%mu(1)))
      if (allocated(self%expected)) self%worst_motion = max(self%worst_motion, maxval(abs(y - motion_at(self%expected, t))))
      associate (unused_step => h, unused_error => error)
      end associate
   end subroutine observe

   !> {beta, theta, their rates} of a known motion.
   pure function motion_at(expected, t) result(y)
      class(known_motion_t), intent(in) :: expected
      real(wp), intent(in) :: t
      real(wp) :: y(4)
      complex(wp) :: driven(2), free(2), i_omega

      i_omega = cmplx(0.0_wp, expected%omega, wp)
      driven = expected%amplitude*exp(i_omega*t)
      free = expected%free*exp(expected%exponent*t)
      y(1:2) = expected%constant + real(driven + free, wp)
      y(3:4) = real(i_omega*driven + expected%exponent*free, wp)
   end function motion_at

   !> Options at the paper's tolerances.
   function paper(control) result(options)
      character(*), intent(in) :: control
      type(integration_options_t) :: options

      options%rtol = 1.0e-2_wp
      options%atol = 1.0e-4_wp
      options%first_step = 0.01_wp
      options%max_step = 0.01_wp
      options%step_control = control
   end function paper

   !> Options at 1e-11.
   function strict() result(options)
      type(integration_options_t) :: options

      options%rtol = 1.0e-11_wp
      options%atol = 1.0e-11_wp
      options%max_step = 0.01_wp
   end function strict

   !> Integrates a blade by a method, from rest at the origin if no start is given.
   subroutine fly(data, name, options, t_end, result, sampler, failure, at)
      type(helicopter_data_t), intent(in) :: data
      character(*), intent(in) :: name
      type(integration_options_t), intent(in) :: options
      real(wp), intent(in) :: t_end
      type(integration_result_t), intent(out) :: result
      type(sampler_t), intent(inout) :: sampler
      character(:), allocatable, intent(inout) :: failure
      type(state_t), intent(inout) :: at
      type(helicopter_t) :: model
      type(method_t) :: method
      type(error_t), allocatable :: error

      call new_helicopter(model, data, error)
      call no_error(failure, error)
      if (allocated(error)) return
      if (.not. allocated(at%x)) at%x = [0.0_wp, 0.0_wp]
      if (.not. allocated(at%v)) at%v = [0.0_wp, 0.0_wp]
      method%name = name
      call simulate(model, at, t_end, result, error, method, options, sampler)
      call no_error(failure, error)
      call check(failure, result%status == status_reached_end, name//': the end is reached')
   end subroutine fly

   subroutine table_3(failure)
      character(:), allocatable, intent(inout) :: failure
      type(helicopter_data_t) :: data
      type(helicopter_t) :: model
      type(quantity_t), allocatable :: list(:)
      type(error_t), allocatable :: error
      integer :: i

      call new_helicopter(model, data, error)
      call no_error(failure, error)
      call check_close(failure, model%nu_beta**2, 1.0625_wp, 1.0e-14_wp, 'flap frequency ratio, squared')
      call check_close(failure, model%k_p, 0.25_wp, 1.0e-15_wp, 'pitch-flap coupling')
      call check_close(failure, model%k_c, 1.6538e4_wp, 0.5_wp, 'control stiffness')
      call check_close(failure, data%omega, 40.0_wp, 0.0_wp, 'rotor speed')
      call check_close(failure, data%i_b, 416.67_wp, 0.0_wp, 'flap inertia')
      call check_close(failure, data%i_f, 9.375e-2_wp, 0.0_wp, 'pitch inertia')
      call check_close(failure, data%i_x, 1.875e-2_wp, 0.0_wp, 'coupling inertia')
      call check_close(failure, data%gamma, 8.0_wp, 0.0_wp, 'Lock number')
      list = model%quantities()
      do i = 1, size(list)
         call check(failure, is_plain(list(i)%name) .and. is_plain(list(i)%unit), 'quantities have no commas')
         if (list(i)%name == 'nu_beta_squared') call check_close(failure, list(i)%value, 1.0625_wp, 1.0e-14_wp, 'in the list')
      end do
      call check(failure, size(list) >= 16, 'all of the table is told')
   end subroutine table_3

   pure logical function is_plain(text)
      character(*), intent(in) :: text

      is_plain = len(text) > 0 .and. index(text, ',') == 0
   end function is_plain

   !> A(0) = (0.25, 0.2, 0), B 0.15 m below it.
   subroutine at_rest(failure)
      character(:), allocatable, intent(inout) :: failure
      type(helicopter_data_t) :: data
      type(helicopter_t) :: model
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp) :: a(1, 2), phi(1)

      call new_helicopter(model, data, error)
      at%x = [0.0_wp, 0.0_wp]
      at%v = [0.0_wp, 0.0_wp]
      call model%constraint(at, phi)
      call check_below(failure, phi(1), 1.0e-16_wp, 'the link has its length')
      call model%jacobian(at, a)
      ! Vertical: flap raises A by x_theta, pitch by y_theta.
      call check_close(failure, a(1, 1), 0.05_wp, 1.0e-16_wp, 'arm of flap')
      call check_close(failure, a(1, 2), 0.2_wp, 1.0e-16_wp, 'arm of pitch')
      ! A quarter turn of flap brings A above the hinge: x_theta up, y_theta across.
      at%x = [0.5_wp*pi, 0.0_wp]
      call model%constraint(at, phi)
      call check_close(failure, phi(1), norm2([0.2_wp - 0.25_wp, 0.0_wp, 0.05_wp + 0.15_wp]) - 0.15_wp, 1.0e-15_wp, 'flap')
      ! A quarter turn of pitch brings it y_theta up.
      at%x = [0.0_wp, 0.5_wp*pi]
      call model%constraint(at, phi)
      call check_close(failure, phi(1), norm2([0.0_wp, -0.2_wp, 0.2_wp + 0.15_wp]) - 0.15_wp, 1.0e-15_wp, 'pitch')
   end subroutine at_rest

   !> All of B moves.
   function tilting() result(data)
      type(helicopter_data_t) :: data

      data%b_mean = [0.27_wp, 0.17_wp, -0.12_wp]
      data%b_cosine = [0.01_wp, -0.02_wp, 0.03_wp]
      data%b_sine = [-0.015_wp, 0.005_wp, 0.02_wp]
   end function tilting

   subroutine model_is_consistent(failure)
      character(:), allocatable, intent(inout) :: failure
      type(helicopter_data_t) :: data
      type(helicopter_t) :: model
      type(finding_t), allocatable :: findings(:)
      type(state_t) :: at
      type(error_t), allocatable :: error
      integer :: i, moving

      do moving = 0, 1
         data = helicopter_data_t()
         if (moving == 1) data = tilting()
         call new_helicopter(model, data, error)
         do i = 1, 3
            at%t = 0.013_wp*i
            at%x = [0.3_wp*i, -0.5_wp + 0.2_wp*i]
            at%v = [2.0_wp*i, 0.5_wp - 3.0_wp*i]
            call verify(model, at, findings, error)
            call no_error(failure, error)
            if (size(findings) > 0) call check(failure, .false., findings(1)%message)
         end do
      end do
   end subroutine model_is_consistent

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

   subroutine steps_constraint(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=8), parameter :: names(2) = [character(len=8) :: 'present', 'baseline']
      character(len=11), parameter :: controls(2) = [character(len=11) :: 'standard', 'odepkg-2009']
      type(helicopter_data_t) :: data
      type(integration_result_t) :: result
      type(sampler_t) :: sampler
      type(state_t) :: at
      integer :: i, j

      do j = 1, 2
         do i = 1, 2
            sampler = sampler_t()
            at = state_t()
            call fly(data, trim(names(i)), paper(controls(j)), 2.0_wp, result, sampler, failure, at)
            call check(failure, result%steps == 200, trim(names(i))//', '//trim(controls(j))//': 200 steps')
            call check(failure, result%rejected == 0, trim(names(i))//', '//trim(controls(j))//': none rejected')
            if (names(i) == 'present') then
               call check_below(failure, sampler%worst_phi, 1.0e-12_wp, 'compliance')
               call check_below(failure, sampler%worst_phidot, 1.0e-12_wp, 'compliance of the velocity')
               call check_below(failure, sampler%mu, 1.0e-6_wp, 'mu is essentially zero')
            end if
         end do
      end do
   end subroutine steps_constraint

   !> Tries, because the paper does not tell accepted and rejected steps apart; by the honest error test.
   subroutine steps_stiffness(failure)
      character(:), allocatable, intent(inout) :: failure
      type(helicopter_data_t) :: data
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(sampler_t) :: sampler
      type(state_t) :: at

      options = paper('standard')
      call fly(data, 'unconstrained', options, 2.0_wp, result, sampler, failure, at)
      call check_close(failure, real(result%steps + result%rejected, wp), 700.0_wp, 70.0_wp, 'steps and rejected tries')
      call check(failure, result%steps > 450 .and. result%rejected > 100, 'many are rejected')
      options%norm = 'max'
      at = state_t()
      call fly(data, 'unconstrained', options, 2.0_wp, result, sampler, failure, at)
      call check_close(failure, real(result%steps + result%rejected, wp), 700.0_wp, 70.0_wp, 'the same with the other norm')
   end subroutine steps_stiffness

   !> A hundred times the stiffness: the paper's tolerance lets the oscillation grow, a strict one does not.
   subroutine stiffer_control(failure)
      character(:), allocatable, intent(inout) :: failure
      type(helicopter_data_t) :: data
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(sampler_t) :: sampler
      type(state_t) :: at

      data%control_frequency = 105.0_wp
      call fly(data, 'unconstrained', paper('standard'), 2.0_wp, result, sampler, failure, at)
      call check(failure, sampler%worst_phi > 0.1_wp, 'the link is violated by its own length')
      call check(failure, result%steps > 20*200, 'and the steps are many')
      options = paper('standard')
      options%rtol = 1.0e-6_wp
      options%atol = 1.0e-8_wp
      at = state_t()
      sampler = sampler_t()
      call fly(data, 'unconstrained', options, 2.0_wp, result, sampler, failure, at)
      call check_below(failure, sampler%worst_phi, 1.0e-6_wp, 'a strict tolerance converges')
   end subroutine stiffer_control

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

   subroutine energy_is_kept(failure)
      character(:), allocatable, intent(inout) :: failure
      type(helicopter_data_t) :: data
      type(integration_result_t) :: result
      type(sampler_t) :: sampler
      type(state_t) :: at

      data%gamma = 0.0_wp
      data%m_beta1 = 0.0_wp
      at%x = [0.1_wp, 0.0_wp]
      at%v = [1.0_wp, 0.0_wp]
      call fly(data, 'present', strict(), 2.0_wp, result, sampler, failure, at)
      call check(failure, sampler%first_energy > 1.0e3_wp, 'there is energy')
      call check_below(failure, sampler%worst_energy/sampler%first_energy, 2.0e-9_wp, 'change of energy')
   end subroutine energy_is_kept

   !> Methods that enforce the constraint do without K_c; the system as given is not changed.
   subroutine stiffness_or_constraint(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=24), parameter :: names(4) = [character(len=24) :: 'present', 'baseline', 'baumgarte', 'unconstrained']
      type(helicopter_data_t) :: data
      type(helicopter_t) :: model
      type(constrained_ode_t) :: ode
      type(method_t) :: method
      type(sample_t) :: s
      type(error_t), allocatable :: error
      real(wp) :: dydt(4), y(4)
      integer :: i, info

      call new_helicopter(model, data, error)
      ! On the manifold to first order only, so that the stiffness has something to act on.
      y = [0.08_wp, -0.01_wp, 0.4_wp, -0.1_wp]
      do i = 1, size(names)
         method%name = names(i)
         ode = constrained_ode_t()
         call ode%init(model, method, error)
         call no_error(failure, error)
         call ode%rhs(0.3_wp, y, dydt, info)
         call ode%sample(0.3_wp, y, s, info)
         if (names(i) == 'unconstrained') then
            call check_close(failure, s%outputs(1), 16537.5_wp*(y(2) + 0.25_wp*y(1))/0.2_wp, 1.0e-8_wp, 'force of the stiffness')
            call check_close(failure, dot_product([-data%i_x, data%i_f], dydt(3:4)) + data%i_f*1600.0_wp*y(2) &
                             - data%i_x*1600.0_wp*y(1), -0.2_wp*s%outputs(1), 1.0e-8_wp, 'it acts on the pitch')
            call check(failure, s%phi > 1.0e-4_wp .and. s%rank == 1, 'the constraint is evaluated')
         else
            call check_close(failure, s%outputs(1), s%lambda(1), 0.0_wp, trim(names(i))//': force of the link')
         end if
      end do
      call check(failure, model%enforced, 'the system as given stays as it is')
   end subroutine stiffness_or_constraint

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

   subroutine start_stays(failure)
      character(:), allocatable, intent(inout) :: failure
      type(helicopter_data_t) :: data
      type(helicopter_t) :: model
      type(method_t) :: method
      type(start_report_t) :: report
      type(state_t) :: at
      type(error_t), allocatable :: error

      call new_helicopter(model, data, error)
      at%x = [0.1_wp, 0.2_wp]
      at%v = [0.3_wp, 0.4_wp]
      method%name = 'unconstrained'
      call consistent_start(model, method, at, report, error)
      call no_error(failure, error)
      call check_below(failure, maxval(abs([at%x, at%v] - [0.1_wp, 0.2_wp, 0.3_wp, 0.4_wp])), 0.0_wp, 'nothing is moved')
      call check(failure, report%freedoms == 2, 'both coordinates are free')
      method%name = 'present'
      call consistent_start(model, method, at, report, error)
      call check(failure, report%moved_x > 0.01_wp .and. report%freedoms == 1, 'what is enforced is mended')
   end subroutine start_stays

   subroutine bad_data(failure)
      character(:), allocatable, intent(inout) :: failure
      type(helicopter_data_t) :: good, data

      data = good
      data%omega = 0.0_wp
      call refused(data, 'omega = 0 is not positive', failure)
      data = good
      data%length = 0.0_wp
      call refused(data, 'length = 0 is not positive', failure)
      data = good
      data%i_b = -1.0_wp
      call refused(data, 'i_b = -1.0000 is not positive', failure)
      data = good
      data%i_f = 0.0_wp
      call refused(data, 'i_f = 0 is not positive', failure)
      data = good
      data%i_x = -7.0_wp
      call refused(data, 'the mass matrix is not positive definite', failure)
      data = good
      data%gamma = -8.0_wp
      call refused(data, 'gamma = -8.0000 is negative', failure)
      data = good
      data%radius = 0.1_wp
      call refused(data, 'is not larger than x_beta', failure)
      data = good
      data%y_theta = 0.0_wp
      call refused(data, 'no arm', failure)
      data = good
      data%control_frequency = -1.0_wp
      call refused(data, 'control_frequency = -1.0000 is negative', failure)
      data = good
      data%b_sine(2) = ieee_value(1.0_wp, ieee_positive_inf)
      call refused(data, 'a coordinate of point A or B', failure)
      data = good
      data%phi_beta1 = ieee_value(1.0_wp, ieee_negative_inf)
      call refused(data, 'a moment or its phase', failure)
   end subroutine bad_data

   !> What the case file says is what its absence means.
   subroutine shipped_case(failure)
      character(:), allocatable, intent(inout) :: failure
      type(helicopter_data_t) :: good
      type(namelist_file_t) :: file
      type(helicopter_t) :: model
      type(settings_t) :: settings
      type(state_t) :: start
      type(error_t), allocatable :: error

      call file%load('cases/helicopter/figure10.nml', error)
      if (.not. allocated(error)) call read_helicopter(file, model, start, settings, error)
      call no_error(failure, error)
      if (allocated(error)) return
      call check_close(failure, model%data%omega, good%omega, 0.0_wp, 'rotor speed')
      call check_below(failure, maxval(abs([model%data%i_b - good%i_b, model%data%i_f - good%i_f, model%data%i_x - good%i_x])), &
                       0.0_wp, 'inertias')
      call check_below(failure, maxval(abs([model%data%b_mean - good%b_mean, model%data%b_sine, model%data%b_cosine])), 0.0_wp, 'B')
      call check_close(failure, model%data%phi_beta1, good%phi_beta1, 1.0e-15_wp, 'phase of the load')
      call check_close(failure, model%k_c, 16537.5_wp, 1.0e-10_wp, 'control stiffness')
      call check(failure, size(settings%methods) == 3, 'three methods')
      call check(failure, settings%methods(3)%label == 'penalty', 'label')
      call check(failure, settings%methods(3)%method%name == 'unconstrained', 'the stiffness in place of the constraint')
      call check(failure, model%output_name(1) == 'link_force' .and. model%n_outputs == 1, 'the link force is told')
   end subroutine shipped_case

   subroutine refused(data, text, failure)
      type(helicopter_data_t), intent(in) :: data
      character(*), intent(in) :: text
      character(:), allocatable, intent(inout) :: failure
      type(helicopter_t) :: model
      type(error_t), allocatable :: error

      call new_helicopter(model, data, error)
      call check(failure, allocated(error), 'refused: '//text)
      if (.not. allocated(error)) return
      call check(failure, index(error%line(), 'helicopter: ') == 1 .and. index(error%line(), text) > 0, error%line())
      call check(failure, index(error%line(), new_line('a')) == 0 .and. len(error%remedy) > 0, 'one line with a remedy')
   end subroutine refused

end module test_helicopter
