!> The generalized-alpha method, of order 2 with damping of high frequencies, for constrained systems in implicit form.
!!
!!     x_new = x (+) d,   d = h v + h^2 ((1/2 - beta) a + beta a_new) - h W^-1 A^T eta
!!     v_new = v + h ((1 - gamma) a + gamma a_new)
!!     (1 - alpha_m) a_new + alpha_m a = (1 - alpha_f) vdot_new + alpha_f vdot
!!
!! with the equations of motion and phi = 0 at the step's end, and with eta also A v = b' there (stabilized index 2); without
!! it, index 3. (+) moves along the velocities, on the rotation group where the coordinates are quaternions. States w that are not
!! mechanics are integrated as v is.
!!
!! Sources: J. Chung, G.M. Hulbert, J. Appl. Mech. 60 (1993) 371-375, for the constants; M. Arnold, O. Bruls, Convergence of the
!! generalized-alpha scheme for constrained mechanical systems, Multibody Syst. Dyn. 18 (2007) 185-202; O. Bruls, A. Cardona,
!! M. Arnold, Lie group generalized-alpha time integration of constrained flexible multibody systems, Mech. Mach. Theory 48
!! (2012) 121-137. a is of the time t + (alpha_m - alpha_f) h, so that it is moved where h changes.
!!
!! Nothing is scaled: factors with row interchanges find a matrix with masses over h^2 beside constraints the same at any h.
module taut_constrained_stepper_generalized_alpha
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   use taut_constrained_implicit, only: implicit_form_t
   use taut_constrained_method, only: constrained_ode_t
   use taut_constrained_system, only: state_t
   use taut_ode_step_control, only: controller_constants_t, step_control_t
   use taut_ode_stepper_implicit, only: implicit_stepper_t
   use taut_ode_system, only: ode_system_t, rhs_cannot, rhs_failed, rhs_ok, step_end
   implicit none (type, external)
   private
   public :: generalized_alpha_t, new_generalized_alpha

   !> The stepper and what it remembers.
   type, extends(implicit_stepper_t) :: generalized_alpha_t
      private
      !> Whether velocities are on their constraints too.
      logical :: stabilized = .true.
      !> Constants of the method; lead is the time of a, alpha_m - alpha_f.
      real(wp) :: alpha_m = 0.0_wp, alpha_f = 0.0_wp, beta = 0.0_wp, gamma = 0.0_wp, lead = 0.0_wp
      !> h times what d/dt of coordinates is replaced by.
      complex(wp) :: nu(1) = (0.0_wp, 0.0_wp)
      integer :: n_x = 0, n_v = 0
      !> {vdot; wdot} at the step's start and end; a there, for the step that `h_old` says; algebraic unknowns at the end.
      real(wp), allocatable :: rate(:), rate_new(:), a(:), a_new(:), a_now(:), z_new(:)
      !> d, and its formal derivative.
      real(wp), allocatable :: d(:), d_rate(:), correction(:), last_correction(:)
      !> Where the system is looked at.
      type(state_t) :: at
      real(wp), allocatable :: y(:), r(:), error(:, :)
      complex(wp), allocatable :: r_complex(:)
      !> States and derivatives at both ends, for output inside.
      real(wp), allocatable :: y_start(:), y_end(:), ydot_start(:), ydot_end(:)
   contains
      procedure :: init
      procedure :: start
      procedure :: try
      procedure :: accept
      procedure :: prepare_dense
      procedure :: interpolate
      procedure :: serialize
   end type generalized_alpha_t

contains

   !> The method for a spectral radius.
   subroutine new_generalized_alpha(self, spectral_radius, stabilized)
      !> The stepper.
      type(generalized_alpha_t), intent(out) :: self
      !> What is left per step of an oscillation whose period is short against the step: 0 (nothing) to 1 (all).
      real(wp), intent(in) :: spectral_radius
      !> Stabilized index 2 instead of index 3.
      logical, intent(in) :: stabilized

      associate (rho => spectral_radius)
         self%alpha_m = (2.0_wp*rho - 1.0_wp)/(rho + 1.0_wp)
         self%alpha_f = rho/(rho + 1.0_wp)
      end associate
      self%lead = self%alpha_m - self%alpha_f
      self%gamma = 0.5_wp - self%lead
      self%beta = 0.25_wp*(1.0_wp - self%lead)**2
      self%nu = cmplx(self%gamma/self%beta, 0.0_wp, wp)
      self%stabilized = stabilized
      self%order = 2
      self%takes_integral = .true.
      self%constants = controller_constants_t(exponent=0.7_wp/3.0_wp, memory=0.3_wp/3.0_wp)
   end subroutine new_generalized_alpha

   !> Allocates the workspace of the state.
   subroutine init(self, n)
      !> The stepper.
      class(generalized_alpha_t), intent(inout) :: self
      !> Number of entries of the state.
      integer, intent(in) :: n

      self%n = n
      allocate (self%y(n), self%ydot(n), self%error(n, 1), self%last_correction(n), self%y_start(n), self%y_end(n), &
                self%ydot_start(n), self%ydot_end(n), source=0.0_wp)
   end subroutine init

   !> Takes the equations of a system; nothing is allocated afterwards.
   subroutine meet_system(self, ode)
      type(generalized_alpha_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      integer :: m

      if (allocated(self%newton%equations)) return
      call self%newton%meet(ode, self%n)
      select type (form => self%newton%equations)
      type is (implicit_form_t)
         form%stabilized = self%stabilized
         form%second = (1.0_wp - self%alpha_m)/(1.0_wp - self%alpha_f)*self%beta/self%gamma**2
      end select
      select type (ode)
      class is (constrained_ode_t)
         self%n_x = ode%model%n_x
         self%n_v = ode%model%n
         self%at = ode%at
      end select
      self%n_z = self%newton%equations%n_z
      m = self%n - self%n_x
      if (.not. allocated(self%rate)) allocate (self%rate(m), self%a(m), self%z(self%n_z), source=0.0_wp)
      if (allocated(self%r)) return
      allocate (self%rate_new(m), self%a_new(m), self%a_now(m), self%z_new(self%n_z), self%d(self%n_v), self%d_rate(self%n_v), &
                self%correction(self%n_v), self%r(self%n + self%n_z), source=0.0_wp)
      allocate (self%r_complex(self%n + self%n_z), source=(0.0_wp, 0.0_wp))
   end subroutine meet_system

   !> At a start, or behind a breakpoint: a is vdot.
   subroutine start(self, ode, t, y, info)
      !> The stepper.
      class(generalized_alpha_t), intent(inout) :: self
      !> What is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> Time [s].
      real(wp), intent(in) :: t
      !> State: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      call meet_system(self, ode)
      call self%begin(ode, t, y, info)
      self%rate(:) = self%ydot(self%n_x + 1:)
      self%a(:) = self%rate
   end subroutine start

   !> One try.
   subroutine try(self, ode, control, t, y, t_new, h, y_new, h_next, accepted, info)
      !> The stepper.
      class(generalized_alpha_t), intent(inout) :: self
      !> What is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> Its norm and its controller are used.
      type(step_control_t), intent(inout) :: control
      !> Time at its start [s].
      real(wp), intent(in) :: t
      !> State at its start: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Time at its end [s].
      real(wp), intent(in) :: t_new
      !> Its length [s].
      real(wp), intent(in) :: h
      !> State at its end: (n).
      real(wp), intent(out), contiguous :: y_new(:)
      !> Length of the next try [s].
      real(wp), intent(out) :: h_next
      !> Whether the step holds.
      logical, intent(out) :: accepted
      !> `rhs_ok`, or why there is no new state.
      integer, intent(out) :: info
      logical :: again, converged, stale

      accepted = .false.
      h_next = h
      y_new(:) = y
      info = rhs_ok
      if (.not. allocated(self%newton%equations)) then
         ! Behind a restart.
         call meet_system(self, ode)
         call self%newton%restore(ode, self%nu, info)
         if (info /= rhs_ok) return
      end if
      do
         call predict(self, ode, t_new, y, h)
         call self%newton%prepare(ode, t_new, h, self%y, self%ydot, self%z_new, self%nu, self%work, info)
         if (info /= rhs_ok) then
            call self%give_up(h, h_next)
            return
         end if
         call iterate(self, ode, control, t_new, y, h, converged, info)
         call self%newton%count(self%work)
         if (converged) exit
         if (info == rhs_failed .or. info == rhs_cannot) return
         call self%improve(control, self%error(:, 1), y, self%y, h, h_next, again, info)
         if (.not. again) return
      end do
      y_new(:) = self%y
      if (control%fixed) then
         accepted = .true.
      else
         call judge(self, ode, control, y, y_new, h, accepted, h_next)
         if (.not. accepted) return
      end if
      call ode%project(t_new, y_new, step_end, stale, info)
      if (info /= rhs_ok) then
         accepted = .false.
         call self%give_up(h, h_next)
         return
      end if
      self%h_try = h
      ! The trapezoidal rule is of the method's order.
      self%integrand_before = self%integrand_behind
      if (ode%has_integral) then
         ! Behind the last correction: what the residual was computed with is off by that.
         call self%newton%equations%find_integrand(ode, t_new, self%y, self%z_new)
         self%integrand_behind = ode%integrand
         call self%newton%count(self%work)
      end if
      self%gain = 0.5_wp*h*(self%integrand_before + self%integrand_behind)
      self%gain_error = abs(h*(self%integrand_behind - self%integrand_before))/6.0_wp
      associate (unused_start => t)
      end associate
   end subroutine try

   !> The state at the step's end with the rates of its start, and a for the step's length.
   subroutine predict(self, ode, t_new, y, h)
      type(generalized_alpha_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t_new, h
      real(wp), intent(in), contiguous :: y(:)
      integer :: i, n_x

      n_x = self%n_x
      self%a_now(:) = self%a
      if (self%has_history) self%a_now(:) = self%rate + h/self%h_old*(self%a - self%rate)
      self%rate_new(:) = self%rate
      self%z_new(:) = self%z
      call advance_a(self)
      self%y(n_x + 1:) = y(n_x + 1:) + h*((1.0_wp - self%gamma)*self%a_now + self%gamma*self%a_new)
      do i = 1, self%n_v
         self%d(i) = h*(y(n_x + i) + h*((0.5_wp - self%beta)*self%a_now(i) + self%beta*self%a_new(i)))
         self%d_rate(i) = self%y(n_x + i)
      end do
      call move(self, ode, t_new, y)
   end subroutine predict

   !> a at the step's end.
   pure subroutine advance_a(self)
      type(generalized_alpha_t), intent(inout) :: self

      self%a_new(:) = ((1.0_wp - self%alpha_f)*self%rate_new + self%alpha_f*self%rate - self%alpha_m*self%a_now)/ &
                      (1.0_wp - self%alpha_m)
   end subroutine advance_a

   !> x (+) d at the step's end, and all that the equations are asked for there.
   subroutine move(self, ode, t_new, y)
      type(generalized_alpha_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t_new
      real(wp), intent(in), contiguous :: y(:)
      integer :: n_x

      n_x = self%n_x
      select type (ode)
      class is (constrained_ode_t)
         self%at%t = min(max(t_new, ode%t_low), ode%t_high)
         self%at%x(:) = y(:n_x)
         call ode%model%displace(self%d, self%at%x)
         call ode%model%normalize(self%at%x)
         self%y(:n_x) = self%at%x
         call ode%model%x_rate(self%at, self%d_rate, self%ydot(:n_x))
      end select
      self%ydot(n_x + 1:) = self%rate_new
   end subroutine move

   !> Newton's iteration on the state at the step's end.
   subroutine iterate(self, ode, control, t_new, y, h, converged, info)
      type(generalized_alpha_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      type(step_control_t), intent(in) :: control
      real(wp), intent(in) :: t_new, h
      real(wp), intent(in), contiguous :: y(:)
      logical, intent(out) :: converged
      integer, intent(out) :: info
      logical :: hopes
      real(wp) :: change, of_velocities

      ! vdot_new and v_new move together: (1 - alpha_m)/((1 - alpha_f) gamma h).
      of_velocities = (1.0_wp - self%alpha_m)/((1.0_wp - self%alpha_f)*self%gamma*h)
      converged = .false.
      call self%newton%begin(control, self%y)
      do
         self%work%iterations = self%work%iterations + 1
         call self%newton%equations%residual(ode, t_new, self%y, self%ydot, self%z_new, self%r, info)
         if (info /= rhs_ok) return
         self%r_complex(:) = self%r
         call self%newton%equations%solve(ode, 1, self%r_complex)
         self%error(:, 1) = real(self%r_complex(:self%n), wp)
         select type (form => self%newton%equations)
         type is (implicit_form_t)
            call form%displacement(self%correction)
         end select
         self%d(:) = self%d + self%correction
         self%d_rate(:) = self%d_rate + real(self%nu(1), wp)/h*self%correction
         self%y(self%n_x + 1:) = self%y(self%n_x + 1:) + self%error(self%n_x + 1:, 1)
         self%rate_new(:) = self%rate_new + of_velocities*self%error(self%n_x + 1:, 1)
         self%z_new(:) = self%z_new + real(self%r_complex(self%n + 1:), wp)
         call move(self, ode, t_new, y)
         call ode%weigh_error(h, self%error(:, 1))
         change = control%norm(self%error(:, 1), y, self%y)
         call self%newton%judge(change, converged, hopes)
         if (converged .or. .not. hopes) exit
      end do
      if (.not. converged) call compare_with_round_off
      if (converged) call advance_a(self)

   contains

      !> Whether round-off lets the iteration come no further; the last correction is kept to tell by.
      subroutine compare_with_round_off
         self%last_correction(:) = self%error(:, 1)
         call self%newton%draw_round_off(1, self%y, self%ydot, self%z_new, self%r)
         self%r_complex(:) = self%r
         call self%newton%equations%solve(ode, 1, self%r_complex)
         self%error(:, 1) = real(self%r_complex(:self%n), wp)
         call ode%weigh_error(h, self%error(:, 1))
         call self%newton%judge_round_off(change, control%norm(self%error(:, 1), y, self%y), converged)
         self%error(:, 1) = self%last_correction
      end subroutine compare_with_round_off

   end subroutine iterate

   !> The error of a step, and the length of the next.
   !!
   !! Of d, h^3 (beta + lead/2 - 1/6) times the rate of vdot, with what the constraints and stiff parts take off taken off; of w,
   !! what the trapezoidal rule gives besides. O.C. Zienkiewicz, Y.M. Xie, A simple error estimator and adaptive time
   !! stepping procedure for dynamic analysis, Earthquake Eng. Struct. Dyn. 20 (1991) 871-887.
   subroutine judge(self, ode, control, y, y_new, h, accepted, h_next)
      type(generalized_alpha_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      type(step_control_t), intent(inout) :: control
      real(wp), intent(in), contiguous :: y(:), y_new(:)
      real(wp), intent(in) :: h
      logical, intent(out) :: accepted
      real(wp), intent(out) :: h_next
      real(wp) :: share
      integer :: i

      ! In the place of a rate of velocities: the equations then give the displacement.
      share = (1.0_wp - self%alpha_m)/((1.0_wp - self%alpha_f)*self%beta)*(self%beta + 0.5_wp*self%lead - 1.0_wp/6.0_wp)
      self%error(:self%n_x, 1) = 0.0_wp
      do i = 1, self%n_v
         self%error(self%n_x + i, 1) = share*(self%rate_new(i) - self%rate(i))
      end do
      do i = self%n_v + 1, size(self%rate)
         self%error(self%n_x + i, 1) = (1.0_wp - self%alpha_m)/((1.0_wp - self%alpha_f)*self%gamma)* &
                                       ((1.0_wp - self%gamma)*self%a_now(i) + self%gamma*self%a_new(i) - &
                                        0.5_wp*(self%rate(i) + self%rate_new(i)))
      end do
      call self%newton%equations%multiply(self%error(:, 1), self%r)
      self%r_complex(:) = -self%r
      call self%newton%equations%solve(ode, 1, self%r_complex)
      self%error(:, 1) = real(self%r_complex(:self%n), wp)
      call ode%weigh_error(h, self%error(:, 1))
      call control%decide(h, self%error, y, y_new, h_next, accepted)
      if (.not. accepted) return
      call self%limit(h, h_next)
   end subroutine judge

   !> The end of the last try is where the next one starts.
   subroutine accept(self)
      !> The stepper, behind a try that holds.
      class(generalized_alpha_t), intent(inout) :: self

      self%rate(:) = self%rate_new
      self%a(:) = self%a_new
      self%z(:) = self%z_new
      call self%advance()
   end subroutine accept

   !> States and derivatives at both ends.
   subroutine prepare_dense(self, ode, t, y, t_new, h, y_new, info)
      !> The stepper, behind a try that holds.
      class(generalized_alpha_t), intent(inout) :: self
      !> What is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> Time at the step's start [s].
      real(wp), intent(in) :: t
      !> State at the step's start: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Time at the step's end [s].
      real(wp), intent(in) :: t_new
      !> The step's length [s].
      real(wp), intent(in) :: h
      !> State at the step's end: (n).
      real(wp), intent(in), contiguous :: y_new(:)
      !> Always `rhs_ok`.
      integer, intent(out) :: info

      info = rhs_ok
      self%y_start(:) = y
      self%y_end(:) = y_new
      call derivative(t, y, self%rate, self%ydot_start)
      call derivative(t_new, y_new, self%rate_new, self%ydot_end)
      self%ydot_start(:) = h*self%ydot_start
      self%ydot_end(:) = h*self%ydot_end

   contains

      subroutine derivative(at_time, state, rate, ydot)
         real(wp), intent(in) :: at_time, state(:), rate(:)
         real(wp), intent(out) :: ydot(:)

         select type (ode)
         class is (constrained_ode_t)
            self%at%t = min(max(at_time, ode%t_low), ode%t_high)
            self%at%x(:) = state(:self%n_x)
            call ode%model%x_rate(self%at, state(self%n_x + 1:self%n_x + self%n_v), ydot(:self%n_x))
         end select
         ydot(self%n_x + 1:) = rate
      end subroutine derivative

   end subroutine prepare_dense

   !> The cubic through both ends with their derivatives.
   subroutine interpolate(self, theta, y)
      !> The stepper.
      class(generalized_alpha_t), intent(in) :: self
      !> Fraction of the step, 0 at its start and 1 at its end.
      real(wp), intent(in) :: theta
      !> State: (n).
      real(wp), intent(out), contiguous :: y(:)
      real(wp) :: back

      back = 1.0_wp - theta
      y(:) = (1.0_wp + 2.0_wp*theta)*back**2*self%y_start + theta**2*(1.0_wp + 2.0_wp*back)*self%y_end + &
             theta*back*(back*self%ydot_start - theta*self%ydot_end)
   end subroutine interpolate

   !> Passes what is remembered between two steps through an archive; matrices are built again from where they were built.
   subroutine serialize(self, archive)
      !> The stepper, initialized.
      class(generalized_alpha_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      call archive%item('last step', self%h_old)
      call archive%item('longest step', self%cap)
      call archive%item('has history', self%has_history)
      call archive%item('knows z', self%knows_z)
      call archive%item('integrand', self%integrand_behind)
      call archive%list('rates', self%rate)
      call archive%list('a', self%a)
      call archive%list('z', self%z)
      call self%newton%serialize(archive)
   end subroutine serialize

end module taut_constrained_stepper_generalized_alpha
