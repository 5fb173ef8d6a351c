!> The helicopter blade and its pitch link of Sect. 4.3: a rigid blade that flaps and pitches, held in pitch by the link
!! between the pitch horn (A) and the swashplate (B), in a frame that turns with the hub.
module taut_model_helicopter
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_constrained_system, only: state_t
   use taut_constrained_system_tables, only: name_length, quantity_t, tabulated_system_t
   use taut_linalg_block_diagonal, only: block_diagonal_t
   implicit none (type, external)
   private
   public :: helicopter_t, helicopter_data_t, new_helicopter

   !> The blade's data; the defaults are those of Table 3 and of the load of Sect. 4.3.
   type :: helicopter_data_t
      !> Rotor angular velocity Omega [rad/s].
      real(wp) :: omega = 40.0_wp
      !> Rotor radius R [m].
      real(wp) :: radius = 5.0_wp
      !> Inertias of flap, I_b, and of pitch, I_f, and the one that couples them, I_x [kg m^2].
      real(wp) :: i_b = 416.67_wp, i_f = 9.375e-2_wp, i_x = 1.875e-2_wp
      !> Lock number gamma [1].
      real(wp) :: gamma = 8.0_wp
      !> Distance of the flap hinge from the axis of rotation [m].
      real(wp) :: x_beta = 0.2_wp
      !> Point A from the flap hinge, along the blade and across it [m].
      real(wp) :: x_theta = 0.05_wp, y_theta = 0.2_wp
      !> Point B: its mean and its harmonics of one per revolution, x_B(t) = mean + cosine cos(Omega t) + sine sin(Omega t) [m].
      real(wp) :: b_mean(3) = [0.25_wp, 0.2_wp, -0.15_wp], b_cosine(3) = 0.0_wp, b_sine(3) = 0.0_wp
      !> Length of the pitch link L [m].
      real(wp) :: length = 0.15_wp
      !> Frequency of the pitch on the control system's stiffness, per revolution; 0 for none: K_c = I_f (frequency Omega)^2.
      real(wp) :: control_frequency = 10.5_wp
      !> Moments about flap: constant, amplitude [N m] and phase [rad] of one per revolution.
      real(wp) :: m_beta0 = 0.0_wp, m_beta1 = 1.0e4_wp, phi_beta1 = 0.5_wp*acos(-1.0_wp)
      !> Moments about pitch: constant, amplitude [N m] and phase [rad] of one per revolution.
      real(wp) :: m_theta0 = 0.0_wp, m_theta1 = 0.0_wp, phi_theta1 = 0.0_wp
   end type helicopter_data_t

   !> Coordinates beta (flap, up) and theta (pitch, nose up) [rad]; phi = |x_A - x_B| - L [m], Eq. (29); the multiplier is
   !! the tension of the link [N]. Where the constraint is not enforced, the control system's stiffness K_c acts in its
   !! place, Eq. (30b).
   type, extends(tabulated_system_t) :: helicopter_t
      !> What the blade was made of.
      type(helicopter_data_t) :: data
      !> Flap frequency nu_beta, per revolution: its square is what Table 3 prints as 'blade flap frequency ratio'.
      real(wp) :: nu_beta = 1.0_wp
      !> Pitch-flap coupling K_p [1].
      real(wp) :: k_p = 0.0_wp
      !> Stiffness of the control system K_c [N m/rad].
      real(wp) :: k_c = 0.0_wp
   contains
      procedure :: mass
      procedure :: force
      procedure :: constraint
      procedure :: jacobian
      procedure :: velocity_rhs
      procedure :: acceleration_rhs
      procedure :: energy
      procedure :: power
      procedure :: control_moment
      procedure :: x_name
      procedure :: v_name
      procedure :: output_name
      procedure :: outputs
      procedure :: quantities
   end type helicopter_t

contains

   !> A blade with its link.
   subroutine new_helicopter(self, data, error)
      !> The blade.
      type(helicopter_t), intent(out) :: self
      !> Its data.
      type(helicopter_data_t), intent(in) :: data
      !> A value that makes no sense.
      type(error_t), allocatable, intent(inout) :: error
      character(*), parameter :: here = 'helicopter'

      call positive('omega', data%omega, 'give the rotor speed in rad/s')
      call positive('i_b', data%i_b, 'give an inertia in kg m^2')
      call positive('i_f', data%i_f, 'give an inertia in kg m^2')
      call positive('length', data%length, 'give the length of the pitch link in m')
      call not_negative('gamma', data%gamma, 'give a Lock number of 0 or more')
      call not_negative('x_beta', data%x_beta, 'give a distance from the axis of rotation in m')
      call not_negative('control_frequency', data%control_frequency, 'give a frequency per revolution, 0 for no stiffness')
      if (.not. (data%radius > data%x_beta .and. data%radius <= huge(data%radius))) &
         call raise(error, here, 'radius = '//to_text(data%radius)//' is not larger than x_beta = '//to_text(data%x_beta), &
                    'give a radius in m that reaches beyond the flap hinge')
      if (.not. data%i_b*data%i_f > data%i_x**2) &
         call raise(error, here, 'the mass matrix is not positive definite: i_x = '//to_text(data%i_x)//' is not smaller than '// &
                    'the square root of i_b i_f', 'give a smaller i_x')
      if (.not. (abs(data%y_theta) > 0.0_wp .and. abs(data%y_theta) <= huge(data%y_theta))) &
         call raise(error, here, 'y_theta = '//to_text(data%y_theta)//': the link has no arm to hold the pitch with', &
                    'give a distance in m that is not zero')
      if (.not. all(abs([data%x_theta, data%b_mean, data%b_cosine, data%b_sine]) <= huge(1.0_wp))) &
         call raise(error, here, 'a coordinate of point A or B is not a number', 'give lengths in m')
      if (.not. all(abs([data%m_beta0, data%m_beta1, data%phi_beta1, data%m_theta0, data%m_theta1, data%phi_theta1]) &
                    <= huge(1.0_wp))) &
         call raise(error, here, 'a moment or its phase is not a number', 'give moments in N m and phases in rad')
      if (allocated(error)) return
      self%data = data
      ! Footnotes of Table 3.
      self%nu_beta = sqrt(1.0_wp + 1.5_wp*data%x_beta/(data%radius - data%x_beta))
      self%k_p = data%x_theta/data%y_theta
      self%k_c = data%i_f*(data%control_frequency*data%omega)**2
      call self%define(n=2, c=1, constant_mass=.true.)
      self%n_outputs = 1

   contains

      subroutine positive(name, value, remedy)
         character(*), intent(in) :: name, remedy
         real(wp), intent(in) :: value

         if (.not. (value > 0.0_wp .and. value <= huge(value))) &
            call raise(error, here, name//' = '//to_text(value)//' is not positive', remedy)
      end subroutine positive

      subroutine not_negative(name, value, remedy)
         character(*), intent(in) :: name, remedy
         real(wp), intent(in) :: value

         if (.not. (value >= 0.0_wp .and. value <= huge(value))) &
            call raise(error, here, name//' = '//to_text(value)//' is negative', remedy)
      end subroutine not_negative

   end subroutine new_helicopter

   !> M = {I_b, -I_x; -I_x, I_f} [kg m^2], Eqs (30).
   subroutine mass(self, at, m)
      !> The blade.
      class(helicopter_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> The mass matrix.
      type(block_diagonal_t), intent(inout) :: m

      associate (d => self%data)
         call m%set_dense(reshape([d%i_b, -d%i_x, -d%i_x, d%i_f], [2, 2]))
      end associate
      associate (unused_state => at)
      end associate
   end subroutine mass

   !> f [N m], Eqs (30): stiffness of the rotation, damping, moments, and the control system where it is not the constraint.
   subroutine force(self, at, value)
      !> The blade.
      class(helicopter_t), intent(in) :: self
      !> The state; all of it may be used.
      type(state_t), intent(in) :: at
      !> The moments about flap and pitch: (2).
      real(wp), intent(out) :: value(:)
      real(wp) :: moment(2)

      moment = outer_moments(self, at)
      associate (d => self%data, beta => at%x(1), theta => at%x(2))
         value(1) = moment(1) - d%omega**2*(d%i_b*self%nu_beta**2*beta - d%i_x*theta)
         value(2) = moment(2) - d%omega**2*(d%i_f*theta - d%i_x*beta)
      end associate
   end subroutine force

   !> Damping, moments, and the control system where it is not the constraint: what has no potential.
   pure function outer_moments(self, at) result(moment)
      class(helicopter_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp) :: moment(2)

      associate (d => self%data, beta_rate => at%v(1))
         moment(1) = -d%gamma/16.0_wp*d%omega*d%i_b*beta_rate + d%m_beta0 + d%m_beta1*cos(d%omega*at%t + d%phi_beta1)
         moment(2) = d%m_theta0 + d%m_theta1*cos(d%omega*at%t + d%phi_theta1)
      end associate
      if (.not. self%enforced) moment(2) = moment(2) + self%control_moment(at)
   end function outer_moments

   !> K_c (theta_c - theta - K_p beta) [N m], Eq. (30b): the control system's stiffness instead of the constraint.
   !!
   !! theta_c is the pitch that the height of B asks for where the link is vertical: (z_B + L)/y_theta.
   pure function control_moment(self, at) result(moment)
      !> The blade.
      class(helicopter_t), intent(in) :: self
      !> Where; x and t are used.
      type(state_t), intent(in) :: at
      !> The moment about pitch.
      real(wp) :: moment
      real(wp) :: b(3), b_dot(3), b_ddot(3)

      call swashplate(self%data, at%t, b, b_dot, b_ddot)
      moment = self%k_c*((b(3) + self%data%length)/self%data%y_theta - at%x(2) - self%k_p*at%x(1))
   end function control_moment

   !> Point B with its rates [m, m/s, m/s^2].
   pure subroutine swashplate(data, t, b, b_dot, b_ddot)
      type(helicopter_data_t), intent(in) :: data
      real(wp), intent(in) :: t
      real(wp), intent(out) :: b(3), b_dot(3), b_ddot(3)
      real(wp) :: c, s

      c = cos(data%omega*t)
      s = sin(data%omega*t)
      b = data%b_mean + data%b_cosine*c + data%b_sine*s
      b_dot = data%omega*(data%b_sine*c - data%b_cosine*s)
      b_ddot = -data%omega**2*(data%b_cosine*c + data%b_sine*s)
   end subroutine swashplate

   !> x_A - x_B, and the derivatives of x_A by beta and theta, Eq. (28) [m].
   pure subroutine link(self, at, b, d, d_beta, d_theta)
      type(helicopter_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: b(3)
      real(wp), intent(out) :: d(3), d_beta(3), d_theta(3)
      real(wp) :: cb, ct, sb, st

      cb = cos(at%x(1))
      sb = sin(at%x(1))
      ct = cos(at%x(2))
      st = sin(at%x(2))
      associate (x => self%data%x_theta, y => self%data%y_theta)
         d = [self%data%x_beta + x*cb - y*sb*st, y*ct, x*sb + y*cb*st] - b
         d_beta = [-x*sb - y*cb*st, 0.0_wp, x*cb - y*sb*st]
         d_theta = [-y*sb*ct, -y*st, y*cb*ct]
      end associate
   end subroutine link

   !> phi = |x_A - x_B| - L [m], Eq. (29); the printed root reaches too far.
   subroutine constraint(self, at, value)
      !> The blade.
      class(helicopter_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> phi: (1).
      real(wp), intent(out) :: value(:)
      real(wp) :: b(3), b_dot(3), b_ddot(3), d(3), d_beta(3), d_theta(3)

      call swashplate(self%data, at%t, b, b_dot, b_ddot)
      call link(self, at, b, d, d_beta, d_theta)
      value(1) = norm2(d) - self%data%length
   end subroutine constraint

   !> A = u^T {dx_A/dbeta, dx_A/dtheta} [m], u = (x_A - x_B)/|x_A - x_B|; zero where A meets B.
   subroutine jacobian(self, at, a)
      !> The blade.
      class(helicopter_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> The constraint matrix: (1, 2).
      real(wp), intent(out) :: a(:, :)
      real(wp) :: b(3), b_dot(3), b_ddot(3), d(3), d_beta(3), d_theta(3), u(3)

      call swashplate(self%data, at%t, b, b_dot, b_ddot)
      call link(self, at, b, d, d_beta, d_theta)
      u = unit(d)
      a(1, 1) = dot_product(u, d_beta)
      a(1, 2) = dot_product(u, d_theta)
   end subroutine jacobian

   !> b' = u^T dx_B/dt [m/s].
   subroutine velocity_rhs(self, at, value)
      !> The blade.
      class(helicopter_t), intent(in) :: self
      !> The state; its x and t are used.
      type(state_t), intent(in) :: at
      !> b': (1).
      real(wp), intent(out) :: value(:)
      real(wp) :: b(3), b_dot(3), b_ddot(3), d(3), d_beta(3), d_theta(3)

      call swashplate(self%data, at%t, b, b_dot, b_ddot)
      call link(self, at, b, d, d_beta, d_theta)
      value(1) = dot_product(unit(d), b_dot)
   end subroutine velocity_rhs

   !> b'' = u^T (d2x_B/dt2 - J' v) - (w^2 - (u^T w)^2)/|x_A - x_B| [m/s^2], with J = dx_A/d{beta, theta}, J' its rate and
   !! w = J v - dx_B/dt the velocity of A as seen from B.
   subroutine acceleration_rhs(self, at, value)
      !> The blade.
      class(helicopter_t), intent(in) :: self
      !> The state; its x, v and t are used.
      type(state_t), intent(in) :: at
      !> b'': (1).
      real(wp), intent(out) :: value(:)
      real(wp) :: b(3), b_dot(3), b_ddot(3), d(3), d_beta(3), d_theta(3), u(3), w(3), j_dot_v(3)
      real(wp) :: cb, ct, sb, st

      call swashplate(self%data, at%t, b, b_dot, b_ddot)
      call link(self, at, b, d, d_beta, d_theta)
      u = unit(d)
      w = d_beta*at%v(1) + d_theta*at%v(2) - b_dot
      cb = cos(at%x(1))
      sb = sin(at%x(1))
      ct = cos(at%x(2))
      st = sin(at%x(2))
      associate (x => self%data%x_theta, y => self%data%y_theta, p => at%v(1), q => at%v(2))
         j_dot_v = [-x*cb + y*sb*st, 0.0_wp, -x*sb - y*cb*st]*p**2 &
                   + [-y*cb*ct, 0.0_wp, -y*sb*ct]*(2.0_wp*p*q) &
                   + [y*sb*st, -y*ct, -y*cb*st]*q**2
      end associate
      value(1) = dot_product(u, b_ddot - j_dot_v)
      ! w^2 - (u^T w)^2 is the square of the part of w across the link.
      w = w - dot_product(u, w)*u
      if (norm2(d) > 0.0_wp) value(1) = value(1) - dot_product(w, w)/norm2(d)
   end subroutine acceleration_rhs

   !> The direction of a vector; zero if it has none.
   pure function unit(d) result(u)
      real(wp), intent(in) :: d(3)
      real(wp) :: u(3)

      u = 0.0_wp
      if (norm2(d) > 0.0_wp) u = d/norm2(d)
   end function unit

   !> Kinetic energy and the potential of the stiffness of the rotation [J], without the control system's, which has no
   !! potential because K_p beta acts on the pitch alone; constant without damping, moments and motion of the swashplate.
   function energy(self, at)
      !> The blade.
      class(helicopter_t), intent(in) :: self
      !> The state; its x and v are used.
      type(state_t), intent(in) :: at
      !> The energy.
      real(wp) :: energy

      associate (d => self%data, beta => at%x(1), theta => at%x(2), p => at%v(1), q => at%v(2))
         energy = 0.5_wp*(d%i_b*p**2 + d%i_f*q**2) - d%i_x*p*q &
                  + d%omega**2*(0.5_wp*(d%i_b*self%nu_beta**2*beta**2 + d%i_f*theta**2) - d%i_x*beta*theta)
      end associate
   end function energy

   !> Power of the moments and, where it is not the constraint, of the control system [W]: of all that `energy` does not contain.
   function power(self, at)
      !> The blade.
      class(helicopter_t), intent(in) :: self
      !> The state; its x, v and t are used.
      type(state_t), intent(in) :: at
      !> The power.
      real(wp) :: power
      real(wp) :: moment(2)

      moment = outer_moments(self, at)
      power = dot_product(moment, at%v)
   end function power

   !> beta or theta.
   function x_name(self, i) result(name)
      !> The blade.
      class(helicopter_t), intent(in) :: self
      !> 1 or 2.
      integer, intent(in) :: i
      !> The name.
      character(len=name_length) :: name

      name = 'beta'
      if (i == 2) name = 'theta'
      associate (unused_blade => self)
      end associate
   end function x_name

   !> beta_rate or theta_rate.
   function v_name(self, i) result(name)
      !> The blade.
      class(helicopter_t), intent(in) :: self
      !> 1 or 2.
      integer, intent(in) :: i
      !> The name.
      character(len=name_length) :: name

      name = trim(self%x_name(i))//'_rate'
   end function v_name

   !> link_force.
   function output_name(self, i) result(name)
      !> The blade.
      class(helicopter_t), intent(in) :: self
      !> 1.
      integer, intent(in) :: i
      !> The name.
      character(len=name_length) :: name

      name = 'link_force'
      associate (unused_blade => self, unused_index => i)
      end associate
   end function output_name

   !> Tension of the link [N]: the multiplier, or the force that the control system's stiffness needs at the arm y_theta.
   subroutine outputs(self, at, lambda, values)
      !> The blade.
      class(helicopter_t), intent(in) :: self
      !> The state that the row of the table is about.
      type(state_t), intent(in) :: at
      !> The multiplier: (1).
      real(wp), intent(in) :: lambda(:)
      !> The tension: (1).
      real(wp), intent(out) :: values(:)

      if (self%enforced) then
         values(1) = lambda(1)
      else
         values(1) = -self%control_moment(at)/self%data%y_theta
      end if
   end subroutine outputs

   !> Table 3.
   function quantities(self) result(list)
      !> The blade.
      class(helicopter_t), intent(in) :: self
      !> In the table's order.
      type(quantity_t), allocatable :: list(:)

      associate (d => self%data)
         list = [quantity_t('omega', d%omega, 'rad/s'), &
                 quantity_t('radius', d%radius, 'm'), &
                 quantity_t('i_b', d%i_b, 'kg m^2'), &
                 quantity_t('i_f', d%i_f, 'kg m^2'), &
                 quantity_t('i_x', d%i_x, 'kg m^2'), &
                 quantity_t('gamma', d%gamma, '1'), &
                 quantity_t('x_beta', d%x_beta, 'm'), &
                 quantity_t('x_theta', d%x_theta, 'm'), &
                 quantity_t('y_theta', d%y_theta, 'm'), &
                 quantity_t('x_b', d%b_mean(1), 'm'), &
                 quantity_t('y_b', d%b_mean(2), 'm'), &
                 quantity_t('z_b', d%b_mean(3), 'm'), &
                 quantity_t('length', d%length, 'm'), &
                 quantity_t('nu_beta', self%nu_beta, '1'), &
                 quantity_t('nu_beta_squared', self%nu_beta**2, '1'), &
                 quantity_t('k_p', self%k_p, '1'), &
                 quantity_t('k_c', self%k_c, 'N m'), &
                 quantity_t('control_frequency', d%control_frequency, '1'), &
                 quantity_t('b_cosine_x', d%b_cosine(1), 'm'), &
                 quantity_t('b_cosine_y', d%b_cosine(2), 'm'), &
                 quantity_t('b_cosine_z', d%b_cosine(3), 'm'), &
                 quantity_t('b_sine_x', d%b_sine(1), 'm'), &
                 quantity_t('b_sine_y', d%b_sine(2), 'm'), &
                 quantity_t('b_sine_z', d%b_sine(3), 'm')]
      end associate
   end function quantities

end module taut_model_helicopter
