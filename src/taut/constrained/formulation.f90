!> The constrained system as a system of ordinary differential equations, y = {x; v; w}, by the method of one's choice.
!!
!! Equation numbers are those of P. Masarati, Adding kinematic constraints to purely differential dynamics, Comput. Mech. 47
!! (2011) 187-203. Eq. (8) is implemented with the sign of Eq. (11b): the printed bracket has the opposite one.
module taut_constrained_formulation
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   use taut_error, only: error_t, to_text
   use taut_constrained_method_options, only: method_t
   use taut_constrained_projection, only: evaluate_jacobian, lay_out_jacobian, projector_t, relative_violation
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_constrained_system_tables, only: tabulated_system_t
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_sparse_rows, only: sparse_rows_t
   use taut_linalg_weighted_projection, only: solver_code, weighted_projection_t
   use taut_ode_system, only: ode_system_t, rhs_ok, rhs_retry
   implicit none (type, external)
   private
   public :: constrained_ode_t, sample_t

   !> Kinds of right-hand side.
   integer, parameter :: acceleration_level = 1, present_method = 2, braun_goldfarb = 3, penalty = 4, unconstrained = 5

   !> What there is to know about a state.
   type :: sample_t
      !> Violation of the constraints at position, velocity and acceleration level, largest entries.
      real(wp) :: phi = 0.0_wp, phidot = 0.0_wp, phiddot = 0.0_wp
      !> The same at the end of the last step before the state was replaced.
      real(wp) :: phi_raw = 0.0_wp, phidot_raw = 0.0_wp
      !> Energy [J], or not a number.
      real(wp) :: energy = 0.0_wp
      !> Multipliers of Eqs (14): mu at the end of the last step before the state was replaced, lambda at the state: (c).
      real(wp), allocatable :: mu(:), lambda(:)
      !> Rank of A.
      integer :: rank = 0
      !> What the system computes besides: (n_outputs).
      real(wp), allocatable :: outputs(:)
   end type sample_t

   !> A constrained mechanical system with a method.
   type, extends(ode_system_t) :: constrained_ode_t
      !> The system; a copy of what `init` was given.
      class(mechanical_system_t), allocatable :: model
      !> The method.
      type(method_t) :: method
      !> Projection in the metric W, and its iteration count.
      type(projector_t) :: projector
      integer, private :: kind = present_method
      logical, private :: stage_newton = .true., shares_mass = .false., force_form = .false., mass_ready = .false.
      !> What is replaced at the end of a step, and only above which violation (negative: always).
      logical, private :: replaces_x = .false., replaces_v = .false.
      !> Whether `at` is a state that was projected, with A and S there, and nothing was evaluated since.
      logical, private :: projected = .false.
      real(wp), private :: threshold = -1.0_wp
      !> Gains of the acceleration-level constraint, 2 alpha and beta^2.
      real(wp), private :: gain_v = 0.0_wp, gain_x = 0.0_wp
      type(state_t), private :: at
      !> M, and M^-1 A^T S^+.
      type(block_diagonal_t), private :: m
      type(weighted_projection_t), private :: reduced
      type(sparse_rows_t), private :: a
      real(wp), allocatable, private :: phi(:), b_prime(:), b_second(:), r(:), lambda(:), force(:)
      real(wp), allocatable, private :: dydt(:), mu_raw(:)
      real(wp), private :: phi_raw = 0.0_wp, phidot_raw = 0.0_wp
      !> With W = I and the same mass everywhere, M = m I: m, so that S_M = S_W/m; otherwise 0.
      real(wp), private :: uniform_mass = 0.0_wp
      !> 1/m.
      real(wp), private :: uniform_mobility = 0.0_wp
      !> Whether that is so and there is one constraint.
      logical, private :: single = .false.
      !> A of one constraint: (1, n).
      real(wp), allocatable, private :: row(:, :)
      integer, private :: bad_row_of_mass = 0
   contains
      procedure :: init
      procedure :: size => state_size
      procedure :: pack
      procedure :: unpack
      procedure :: rhs
      procedure :: project
      procedure :: filter_error
      procedure :: breakpoints
      procedure :: failure
      procedure :: sample
      procedure :: serialize
   end type constrained_ode_t

contains

   !> Sets a system and a method together; nothing is allocated afterwards.
   subroutine init(self, model, method, error)
      !> The formulation.
      class(constrained_ode_t), intent(out) :: self
      !> The system; copied.
      class(mechanical_system_t), intent(in) :: model
      !> The method.
      type(method_t), intent(in) :: method
      !> Sizes or options that are not valid.
      type(error_t), allocatable, intent(inout) :: error
      integer :: c, n

      call model%check_sizes(error)
      call method%check(error)
      if (allocated(error)) return
      self%model = model
      self%model%enforced = method%name /= 'unconstrained'
      self%method = method
      n = model%n
      c = model%c
      select case (method%name)
      case ('present')
         self%kind = present_method
         self%stage_newton = method%stage_projection == 'newton'
         self%replaces_x = method%state_projection /= 'none'
         self%replaces_v = method%state_projection == 'position-velocity'
      case ('baumgarte')
         self%kind = acceleration_level
         self%gain_v = 2.0_wp*method%alpha
         self%gain_x = method%beta**2
      case ('braun-goldfarb')
         self%kind = braun_goldfarb
      case ('penalty')
         self%kind = penalty
      case ('unconstrained')
         self%kind = unconstrained
      case default
         self%kind = acceleration_level
         self%replaces_x = method%name /= 'baseline'
         self%replaces_v = self%replaces_x
         if (method%name == 'yu-chen') self%threshold = method%correction_tolerance
         self%limits_projection = self%threshold < 0.0_wp
      end select
      self%shares_mass = method%weight == 'mass'
      self%force_form = method%form == 'force'
      allocate (self%at%x(model%n_x), self%at%v(n), self%at%w(model%n_w), source=0.0_wp)
      allocate (self%phi(model%n_phi), self%b_prime(c), self%b_second(c), self%r(c), self%lambda(c), &
                self%force(n), self%mu_raw(c), self%dydt(self%size()), self%row(1, n), source=0.0_wp)
      call self%m%init(model%mass_blocks)
      call lay_out_jacobian(model, self%a)
      if (.not. self%shares_mass .or. self%kind /= present_method) &
         call self%reduced%init(self%a, c, model%mass_blocks, solver_code(method%solver), method%rcond)
      call self%projector%init(model, method)
   end subroutine init

   !> Number of entries of y.
   pure function state_size(self) result(n)
      !> The formulation.
      class(constrained_ode_t), intent(in) :: self
      !> n_x + n + n_w.
      integer :: n

      n = self%model%n_x + self%model%n + self%model%n_w
   end function state_size

   !> y = {x; v; w}.
   pure subroutine pack(self, at, y)
      !> The formulation.
      class(constrained_ode_t), intent(in) :: self
      !> The state.
      type(state_t), intent(in) :: at
      !> All of it: (size).
      real(wp), intent(out), contiguous :: y(:)
      integer :: i

      do i = 1, self%model%n_x
         y(i) = at%x(i)
      end do
      do i = 1, self%model%n
         y(self%model%n_x + i) = at%v(i)
      end do
      do i = 1, self%model%n_w
         y(self%model%n_x + self%model%n + i) = at%w(i)
      end do
   end subroutine pack

   !> {x; v; w} = y.
   pure subroutine unpack(self, t, y, at)
      !> The formulation.
      class(constrained_ode_t), intent(in) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> All of the state: (size).
      real(wp), intent(in), contiguous :: y(:)
      !> The state, its parts allocated.
      type(state_t), intent(inout) :: at
      integer :: i

      at%t = min(max(t, self%t_low), self%t_high)
      do i = 1, self%model%n_x
         at%x(i) = y(i)
      end do
      do i = 1, self%model%n
         at%v(i) = y(self%model%n_x + i)
      end do
      do i = 1, self%model%n_w
         at%w(i) = y(self%model%n_x + self%model%n + i)
      end do
   end subroutine unpack

   !> ydot = {xdot; vdot; wdot}.
   subroutine rhs(self, t, y, dydt, info)
      !> The formulation.
      class(constrained_ode_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State {x; v; w}: (size).
      real(wp), intent(in), contiguous :: y(:)
      !> Its derivative: (size).
      real(wp), intent(out), contiguous :: dydt(:)
      !> One of the `rhs_` constants.
      integer, intent(out) :: info
      logical :: known

      known = .false.
      if (self%projected) known = is_packed(self, t, y)
      self%projected = .false.
      if (.not. known) call unpack(self, t, y, self%at)
      select case (self%kind)
      case (present_method)
         call rhs_present(self, known, dydt, info)
      case (acceleration_level)
         call rhs_acceleration_level(self, dydt, info)
      case (braun_goldfarb)
         call rhs_braun_goldfarb(self, dydt, info)
      case (unconstrained)
         call rhs_unconstrained(self, dydt, info)
      case default
         call rhs_penalty(self, dydt, info)
      end select
      if (info == rhs_ok .and. self%model%n_w > 0) &
         call self%model%w_rate(self%at, dydt(self%model%n_x + self%model%n + 1:))
   end subroutine rhs

   !> Whether t and y are those of `at`.
   pure logical function is_packed(self, t, y)
      type(constrained_ode_t), intent(in) :: self
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      integer :: i, n, n_x

      n = self%model%n
      n_x = self%model%n_x
      is_packed = .false.
      if (abs(min(max(t, self%t_low), self%t_high) - self%at%t) > 0.0_wp) return
      do i = 1, n_x
         if (abs(y(i) - self%at%x(i)) > 0.0_wp) return
      end do
      do i = 1, n
         if (abs(y(n_x + i) - self%at%v(i)) > 0.0_wp) return
      end do
      do i = 1, self%model%n_w
         if (abs(y(n_x + n + i) - self%at%w(i)) > 0.0_wp) return
      end do
      is_packed = .true.
   end function is_packed

   !> The paper's procedure, Sect. 3.5, step by step. With a state that was projected just now, (a) to (d) are done.
   subroutine rhs_present(self, known, dydt, info)
      type(constrained_ode_t), intent(inout) :: self
      logical, intent(in) :: known
      real(wp), intent(inout), contiguous :: dydt(:)
      integer, intent(out) :: info
      integer :: n, n_x

      n = self%model%n
      n_x = self%model%n_x
      info = rhs_ok
      if (.not. self%mass_ready) call renew_mass(self, info)
      if (info /= rhs_ok) return
      if (.not. known) then
         ! (a) project x on the invariant manifold, Eq. (17)
         if (self%stage_newton) then
            call self%projector%position(self%model, self%at, info)
            if (info /= rhs_ok) return
         else
            call self%model%normalize(self%at%x)
         end if
         if (self%single) then
            call rhs_single(self, dydt, info)
            if (info == rhs_ok) return
         end if
         ! (b) A, with the corrected x
         call self%projector%linearize(self%model, self%at, info, 0.0_wp)
         if (info /= rhs_ok) return
         ! (c) b', and (d) project v, Eq. (11a)
         call self%projector%velocity(self%model, self%at)
      end if
      call self%model%x_rate(self%at, self%at%v, dydt(1:n_x))
      ! (e) b'', with the corrected x and v
      call self%model%acceleration_rhs(self%at, self%b_second)
      ! (f) reduced mass matrix and unconstrained acceleration, (g) or (h) correction of the forces or of the accelerations
      call self%model%force(self%at, self%force)
      if (self%shares_mass) then
         call constrained_acceleration(self%projector%a, self%b_second, self%force_form, self%projector%w, 1.0_wp, &
                                       self%projector%onto, self%force, self%r, self%lambda, dydt(n_x + 1:n_x + n))
         return
      end if
      call renew_mass(self, info)
      if (info /= rhs_ok) return
      if (self%uniform_mass > 0.0_wp) then
         call constrained_acceleration(self%projector%a, self%b_second, self%force_form, self%m, self%uniform_mass, &
                                       self%projector%onto, self%force, self%r, self%lambda, dydt(n_x + 1:n_x + n))
         return
      end if
      call self%reduced%update(self%projector%a, self%m, .false., info, 0.0_wp)
      if (info /= 0) then
         info = rhs_retry
         return
      end if
      call constrained_acceleration(self%projector%a, self%b_second, self%force_form, self%m, 1.0_wp, self%reduced, &
                                    self%force, self%r, self%lambda, dydt(n_x + 1:n_x + n))
   end subroutine rhs_present

   !> Steps (b) to (h) for one constraint with W = I and M = m I: one number S serves both levels, and nothing is called but
   !! the system. `info` is not `rhs_ok` where the general way has to decide.
   subroutine rhs_single(self, dydt, info)
      type(constrained_ode_t), intent(inout) :: self
      real(wp), intent(inout), contiguous :: dydt(:)
      integer, intent(out) :: info
      real(wp) :: reciprocal, s
      integer :: i, n, n_x

      n = self%model%n
      n_x = self%model%n_x
      ! (b) A and S, with the corrected x
      call self%model%jacobian(self%at, self%row)
      s = square(n, self%row)
      info = rhs_retry
      if (.not. (ieee_is_finite(s) .and. s > tiny(1.0_wp))) return
      info = rhs_ok
      reciprocal = 1.0_wp/s
      ! (c) b', (d) v := v - A^T S^-1 (A v - b')
      call self%model%velocity_rhs(self%at, self%projector%b_prime)
      call project_on_row(n, self%row, self%projector%b_prime, reciprocal, self%at%v, self%projector%phidot_raw, &
                          self%projector%mu)
      self%projector%phidot_raw = abs(self%projector%phidot_raw)
      call self%model%x_rate(self%at, self%at%v, dydt(:n_x))
      ! (e) b'', (f) S m and f/m, (h) vdot = f/m - A^T lambda/m
      call self%model%acceleration_rhs(self%at, self%b_second)
      call self%model%force(self%at, self%force)
      !GCC$ unroll 1
      do i = 1, n
         dydt(n_x + i) = self%uniform_mobility*self%force(i)
      end do
      call project_on_row(n, self%row, self%b_second, reciprocal, dydt(n_x + 1:n_x + n), s, self%lambda)
      self%lambda(1) = self%uniform_mass*self%lambda(1)
   end subroutine rhs_single

   !> a . a
   pure function square(n, a) result(s)
      integer, intent(in) :: n
      real(wp), intent(in) :: a(n)
      real(wp) :: s
      integer :: i

      s = 0.0_wp
      !GCC$ unroll 1
      do i = 1, n
         s = s + a(i)*a(i)
      end do
   end function square

   !> d := d - a lambda with r = a . d - b, lambda = r/S.
   pure subroutine project_on_row(n, a, b, reciprocal, d, r, lambda)
      integer, intent(in) :: n
      real(wp), intent(in) :: a(n), b(1), reciprocal
      real(wp), intent(inout) :: d(n)
      real(wp), intent(out) :: r, lambda(1)
      integer :: i

      r = -b(1)
      !GCC$ unroll 1
      do i = 1, n
         r = r + a(i)*d(i)
      end do
      lambda(1) = reciprocal*r
      !GCC$ unroll 1
      do i = 1, n
         d(i) = d(i) - a(i)*lambda(1)
      end do
   end subroutine project_on_row

   !> Eq. (8), with the acceleration-level constraint as it is or with Baumgarte's terms.
   subroutine rhs_acceleration_level(self, dydt, info)
      type(constrained_ode_t), intent(inout) :: self
      real(wp), intent(inout), contiguous :: dydt(:)
      integer, intent(out) :: info
      integer :: i, n, n_x

      n = self%model%n
      n_x = self%model%n_x
      call self%model%normalize(self%at%x)
      call self%model%x_rate(self%at, self%at%v, dydt(1:n_x))
      call evaluate_jacobian(self%model, self%at, self%a)
      call self%model%acceleration_rhs(self%at, self%b_second)
      if (self%gain_v > 0.0_wp .or. self%gain_x > 0.0_wp) then
         call violations(self)
         do i = 1, self%model%c
            self%b_second(i) = self%b_second(i) - self%gain_v*self%r(i)
         end do
         do i = 1, self%model%n_phi
            self%b_second(i) = self%b_second(i) - self%gain_x*self%phi(i)
         end do
      end if
      call solve_accelerations(self, dydt(n_x + 1:n_x + n), info)
   end subroutine rhs_acceleration_level

   !> Braun and Goldfarb [30]: A xdot = b' - phi/dt and A vdot = b'' - (A v - b')/dt, each met by its own projection.
   subroutine rhs_braun_goldfarb(self, dydt, info)
      type(constrained_ode_t), intent(inout) :: self
      real(wp), intent(inout), contiguous :: dydt(:)
      integer, intent(out) :: info
      integer :: i, n, n_x

      n = self%model%n
      n_x = self%model%n_x
      call self%model%normalize(self%at%x)
      call self%projector%linearize(self%model, self%at, info, 0.0_wp)
      if (info /= rhs_ok) return
      self%a%values(:) = self%projector%a%values
      call violations(self)
      call self%model%acceleration_rhs(self%at, self%b_second)
      do i = 1, self%model%c
         self%b_second(i) = self%b_second(i) - self%r(i)/self%method%dt
      end do
      call solve_accelerations(self, dydt(n_x + 1:n_x + n), info)
      if (info /= rhs_ok) return
      self%r(:) = 0.0_wp
      self%r(1:self%model%n_phi) = self%phi/self%method%dt
      call self%projector%velocity(self%model, self%at, self%r)
      call self%model%x_rate(self%at, self%at%v, dydt(1:n_x))
   end subroutine rhs_braun_goldfarb

   !> No multipliers: stiffness and damping on the violation, lambda = k phi + d (A v - b').
   subroutine rhs_penalty(self, dydt, info)
      type(constrained_ode_t), intent(inout) :: self
      real(wp), intent(inout), contiguous :: dydt(:)
      integer, intent(out) :: info
      integer :: n, n_x

      n = self%model%n
      n_x = self%model%n_x
      call self%model%normalize(self%at%x)
      call self%model%x_rate(self%at, self%at%v, dydt(1:n_x))
      call evaluate_jacobian(self%model, self%at, self%a)
      call violations(self)
      self%lambda(:) = self%method%damping*self%r
      self%lambda(1:self%model%n_phi) = self%lambda(1:self%model%n_phi) + self%method%stiffness*self%phi
      call self%model%force(self%at, self%force)
      call self%a%subtract_transposed(self%lambda, self%force)
      call renew_mass(self, info)
      if (info /= rhs_ok) return
      call self%m%solve(1, self%force)
      dydt(n_x + 1:n_x + n) = self%force
   end subroutine rhs_penalty

   !> M vdot = f: the constraints have no part in it.
   subroutine rhs_unconstrained(self, dydt, info)
      type(constrained_ode_t), intent(inout) :: self
      real(wp), intent(inout), contiguous :: dydt(:)
      integer, intent(out) :: info
      integer :: n, n_x

      n = self%model%n
      n_x = self%model%n_x
      call self%model%normalize(self%at%x)
      call self%model%x_rate(self%at, self%at%v, dydt(1:n_x))
      call self%model%force(self%at, self%force)
      call renew_mass(self, info)
      if (info /= rhs_ok) return
      call self%m%solve(1, self%force)
      dydt(n_x + 1:n_x + n) = self%force
   end subroutine rhs_unconstrained

   !> phi and r = A v - b' at the state as it is, with A in `a`.
   subroutine violations(self)
      type(constrained_ode_t), intent(inout) :: self

      call self%model%constraint(self%at, self%phi)
      call self%model%velocity_rhs(self%at, self%b_prime)
      call self%a%multiply(self%at%v, self%r, self%b_prime)
   end subroutine violations

   !> M at the state, factorized.
   subroutine renew_mass(self, info)
      type(constrained_ode_t), intent(inout) :: self
      integer, intent(out) :: info

      info = rhs_ok
      if (self%mass_ready .and. self%model%constant_mass) return
      call self%model%mass(self%at, self%m)
      call self%m%factorize(self%bad_row_of_mass)
      self%mass_ready = self%bad_row_of_mass == 0
      self%uniform_mass = 0.0_wp
      if (.not. self%mass_ready) then
         info = rhs_retry
      else if (self%m%diagonal .and. self%kind == present_method .and. self%method%weight == 'identity') then
         if (all(abs(self%m%values - self%m%values(1)) <= 0.0_wp)) self%uniform_mass = self%m%values(1)
         if (self%uniform_mass > 0.0_wp) self%uniform_mobility = 1.0_wp/self%uniform_mass
      end if
      self%single = self%uniform_mass > 0.0_wp .and. self%model%constant_mass .and. self%model%c == 1 .and. self%a%full .and. &
                    .not. self%force_form .and. self%method%solver == 'auto'
   end subroutine renew_mass

   !> vdot from A vdot = b'' with A in `a`, b'' in `acceleration_rhs`, at a state that may violate the constraints.
   subroutine solve_accelerations(self, vdot, info)
      type(constrained_ode_t), intent(inout) :: self
      real(wp), intent(inout), contiguous :: vdot(:)
      integer, intent(out) :: info
      real(wp) :: noise

      call renew_mass(self, info)
      if (info /= rhs_ok) return
      noise = 0.0_wp
      if (self%model%n_phi > 1) then
         call self%model%constraint(self%at, self%phi)
         noise = relative_violation(self%phi, self%a, self%at%x)
      end if
      call self%reduced%update(self%a, self%m, .false., info, noise)
      if (info /= 0) then
         info = rhs_retry
         return
      end if
      call self%model%force(self%at, self%force)
      call constrained_acceleration(self%a, self%b_second, self%force_form, self%m, 1.0_wp, self%reduced, self%force, self%r, &
                                    self%lambda, vdot)
   end subroutine solve_accelerations

   !> Eq. (11b) or (19b): accelerations from the forces and A vdot = b''; the operator may be that of M/mass.
   subroutine constrained_acceleration(a, b_second, force_form, m, mass, reduced, f, r, lambda, vdot)
      type(sparse_rows_t), intent(in) :: a
      real(wp), intent(in) :: b_second(a%c)
      logical, intent(in) :: force_form
      type(block_diagonal_t), intent(in) :: m
      real(wp), intent(in) :: mass
      type(weighted_projection_t), intent(inout) :: reduced
      real(wp), intent(inout) :: f(a%n), r(a%c), lambda(a%c), vdot(a%n)
      integer :: i

      ! Unconstrained acceleration a = M^-1 f, and the reduced one A a, Eq. (21).
      call m%solve_vector(f, vdot)
      ! lambda = S^+ (A a - b''), Eq. (14b); (h), Eq. (11b): vdot = a - M^-1 A^T lambda.
      call reduced%project(a, b_second, vdot, r, lambda)
      if (abs(mass - 1.0_wp) > 0.0_wp) then
         do i = 1, a%c
            lambda(i) = mass*lambda(i)
         end do
      end if
      if (.not. force_form) return
      ! (g), Eq. (19b): M vdot = f - A^T lambda.
      call a%subtract_transposed(lambda, f)
      call m%solve_vector(f, vdot)
   end subroutine constrained_acceleration

   !> Replaces what the method replaces at the end of a step: coordinates by Eq. (17), velocities by Eq. (11a).
   subroutine project(self, t, y, fresh, stale, info)
      !> The formulation.
      class(constrained_ode_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State {x; v; w}, replaced: (size).
      real(wp), intent(inout), contiguous :: y(:)
      !> Whether the last call of `rhs` was for this very t and y.
      logical, intent(in) :: fresh
      !> Whether the derivative has to be evaluated again.
      logical, intent(out) :: stale
      !> One of the `rhs_` constants.
      integer, intent(out) :: info
      integer :: n_x

      stale = .false.
      info = rhs_ok
      n_x = self%model%n_x
      if (.not. self%replaces_x) then
         ! Every right-hand side normalizes first, so that its value stays.
         call self%model%normalize(y(1:n_x))
         return
      end if
      if (.not. (self%kind == present_method .and. self%stage_newton .and. fresh)) then
         call self%unpack(t, y, self%at)
         call correct(self, fresh .and. self%kind == present_method .and. .not. self%single, info)
         if (info /= rhs_ok) return
         self%projected = self%kind == present_method .and. .not. self%stage_newton
         stale = fresh .and. (self%threshold < 0.0_wp .or. self%projector%phi_raw > self%threshold .or. &
                              self%projector%phidot_raw > self%threshold)
      end if
      ! With Eqs (11) on the projected state the right-hand side F satisfies F(P(y)) = F(y): the last stage holds P(y)
      ! already, and its derivative stays valid.
      y(1:n_x) = self%at%x
      if (self%replaces_v) y(n_x + 1:n_x + self%model%n) = self%at%v
      if (.not. fresh) return
      self%phi_raw = self%projector%phi_raw
      self%phidot_raw = self%projector%phidot_raw
      self%mu_raw(:) = self%projector%mu
   end subroutine project

   !> Position and velocity corrected, always or above the method's threshold.
   subroutine correct(self, linearized, info)
      type(constrained_ode_t), intent(inout) :: self
      logical, intent(in) :: linearized
      integer, intent(out) :: info

      call self%projector%position(self%model, self%at, info, self%threshold, linearized)
      if (info /= rhs_ok) return
      call self%projector%linearize(self%model, self%at, info, 0.0_wp)
      if (info /= rhs_ok) return
      if (self%threshold < 0.0_wp) then
         call self%projector%velocity(self%model, self%at)
         return
      end if
      call self%projector%velocity_violation(self%model, self%at)
      self%projector%mu(:) = 0.0_wp
      if (self%projector%phidot_raw > self%threshold) call self%projector%velocity(self%model, self%at)
   end subroutine correct

   !> Takes off the local error what `project` will take off the state.
   subroutine filter_error(self, error)
      !> The formulation.
      class(constrained_ode_t), intent(inout) :: self
      !> Estimate of the local error: (size).
      real(wp), intent(inout), contiguous :: error(:)
      integer :: info, n_x

      if (.not. self%replaces_x .or. self%threshold >= 0.0_wp) return
      n_x = self%model%n_x
      if (self%kind == acceleration_level .or. self%single) then
         call self%projector%linearize(self%model, self%at, info, 0.0_wp)
         if (info /= rhs_ok) return
      end if
      call self%projector%filter_position(self%model, self%at, error(1:n_x))
      if (self%replaces_v) call self%projector%filter_velocity(self%model, error(n_x + 1:n_x + self%model%n))
   end subroutine filter_error

   !> The breakpoints of the system.
   function breakpoints(self) result(times)
      !> The formulation.
      class(constrained_ode_t), intent(in) :: self
      !> Times in any order [s].
      real(wp), allocatable :: times(:)

      times = self%model%breakpoints()
   end function breakpoints

   !> Why the last evaluation or projection failed.
   subroutine failure(self, text)
      !> The formulation.
      class(constrained_ode_t), intent(in) :: self
      !> One line.
      character(:), allocatable, intent(out) :: text

      if (self%bad_row_of_mass > 0) then
         text = 'the mass matrix is not positive definite at row '//to_text(self%bad_row_of_mass)
      else
         call self%projector%explain(text)
      end if
   end subroutine failure

   !> Violations, multipliers, energy, rank and what the system computes besides at a state, evaluated afresh.
   subroutine sample(self, t, y, s, info)
      !> The formulation.
      class(constrained_ode_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State {x; v; w}: (size).
      real(wp), intent(in), contiguous :: y(:)
      !> What there is to know; its arrays are allocated if they are not.
      type(sample_t), intent(inout) :: s
      !> One of the `rhs_` constants.
      integer, intent(out) :: info
      integer :: iterations, n, n_x

      if (.not. allocated(s%mu)) &
         allocate (s%mu(self%model%c), s%lambda(self%model%c), source=0.0_wp)
      n = self%model%n
      n_x = self%model%n_x
      ! Output does not count as work of the method.
      iterations = self%projector%iterations
      call self%rhs(t, y, self%dydt, info)
      self%projector%iterations = iterations
      if (info /= rhs_ok) return
      s%lambda(:) = self%lambda
      select case (self%kind)
      case (present_method)
         s%mu(:) = self%projector%mu
         call self%projector%onto%minimum_norm(s%mu)
         if (self%shares_mass .or. self%uniform_mass > 0.0_wp) then
            call self%projector%onto%minimum_norm(s%lambda)
         else
            call self%reduced%minimum_norm(s%lambda)
         end if
      case (acceleration_level, braun_goldfarb)
         call self%reduced%minimum_norm(s%lambda)
      end select

      call self%unpack(t, y, self%at)
      call self%projector%linearize(self%model, self%at, info, 0.0_wp)
      if (info /= rhs_ok) return
      s%rank = self%projector%onto%rank
      self%a%values(:) = self%projector%a%values
      call violations(self)
      s%phi = largest(self%phi)
      s%phidot = largest(self%r)
      call self%model%acceleration_rhs(self%at, self%b_second)
      call self%a%multiply(self%dydt(n_x + 1:n_x + n), self%r, self%b_second)
      s%phiddot = largest(self%r)
      s%energy = self%model%energy(self%at)
      select type (model => self%model)
      class is (tabulated_system_t)
         if (.not. allocated(s%outputs)) allocate (s%outputs(model%n_outputs), source=0.0_wp)
         if (model%n_outputs > 0) call model%outputs(self%at, s%lambda, s%outputs)
      end select
      if (self%replaces_x) then
         s%phi_raw = self%phi_raw
         s%phidot_raw = self%phidot_raw
         s%mu(:) = self%mu_raw
         call self%projector%onto%minimum_norm(s%mu)
      else
         s%phi_raw = s%phi
         s%phidot_raw = s%phidot
         if (self%kind /= present_method) then
            call self%projector%velocity(self%model, self%at)
            s%mu(:) = self%projector%mu
            call self%projector%onto%minimum_norm(s%mu)
         end if
      end if
   end subroutine sample

   !> Largest absolute entry, 0 if there is none.
   pure function largest(values) result(value)
      real(wp), intent(in) :: values(:)
      real(wp) :: value
      integer :: i

      value = 0.0_wp
      do i = 1, size(values)
         value = max(value, abs(values(i)))
      end do
   end function largest

   !> Passes through an archive what is remembered from one step to the next; everything else follows from t and y.
   subroutine serialize(self, archive)
      !> The formulation.
      class(constrained_ode_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      call archive%item('phi before projection', self%phi_raw)
      call archive%item('phidot before projection', self%phidot_raw)
      call archive%item('mu before projection', self%mu_raw)
      call archive%item('projection iterations', self%projector%iterations)
   end subroutine serialize

end module taut_constrained_formulation
