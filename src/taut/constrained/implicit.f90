!> A constrained system in fully implicit form, g(y, ydot, z, t) = 0 (Sect. 3.4), as a stiff integrator asks for it.
!!
!!     xdot = H(x) (v - W^-1 A^T mu),   M(x) vdot = f_s(x, v, w, t) - B(x)^T sigma - A^T lambda,   wdot = g(x, v, w, t)
!!     phi(x, t) = 0,   A(x, t) v = b'(x, t),   sigma = k (g(x) + tau gdot)
!!
!! with y = {x; v; w} and z = {lambda; mu; sigma}. mu keeps the velocities and the coordinates on their constraints at once: C.W.
!! Gear, G.K. Gupta, B. Leimkuhler, Automatic integration of Euler-Lagrange equations with constraints, J. Comput. Appl. Math.
!! 12&13 (1985) 77-90. sigma, the internal force of the elastic rows, keeps Newton's matrix valid while a stiff part turns; in the
!! limit of a large k it is the multiplier of a constraint.
module taut_constrained_implicit
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   use taut_constrained_method_options, only: method_t
   use taut_constrained_jacobian, only: evaluate_jacobian, lay_out_jacobian
   use taut_constrained_reactions, only: inconsistent_reactions, power_of_reactions
   use taut_constrained_saddle_point, only: column_of, entries_of_row, place_of, saddle_point_t
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_constrained_system_stiff, only: stiff_system_t
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_csr, only: csr_t
   use taut_constrained_system_tables, only: coordinate_name, velocity_name
   use taut_error, only: to_text
   use taut_linalg_rank, only: pivot_floor
   use taut_ode_newton, only: spread_evenly
   use taut_ode_system, only: not_converged, ode_system_t, rhs_cannot, rhs_no_projection, rhs_not_solved, rhs_ok, rhs_retry
   implicit none (type, external)
   private
   public :: implicit_form_t

   !> Step of the differences relative to the size of what is varied.
   real(wp), parameter :: difference = sqrt(epsilon(1.0_wp))

   !> The form, with what it is looked at by.
   type, extends(saddle_point_t) :: implicit_form_t
      !> Where the system is looked at.
      type(state_t), private :: stage
      type(csr_t), private :: a, b
      type(block_diagonal_t), private :: m
      !> Rows of A that are not redundant; those that are solved for are `kept`.
      logical, allocatable, private :: independent(:)
      !> Rows that a step leaves out, whether it does, and what they push with that the others cannot, at its start: (n).
      logical, allocatable, private :: held(:)
      logical, private :: holding = .false.
      real(wp), allocatable, private :: held_force(:)
      !> Rows whose push was found last, since the equations came to this dead point: (c).
      logical, allocatable, private :: held_before(:)
      real(wp), allocatable, private :: phi(:), b_prime(:), psi(:), force(:)
      real(wp), allocatable, private :: real_b(:), base(:), base_w(:), balance(:), of_reactions(:), varied_w(:), step(:), unit(:)
      logical, private :: mass_known = .false.
      !> Forces that depend on the multipliers, where these are varied; whether none were consistent with them at the last start.
      real(wp), allocatable, private :: reactions_here(:), lambda(:)
      logical, private :: jammed = .false.
   contains
      procedure :: init
      procedure :: residual
      procedure :: find_integrand
      procedure :: linearize
      procedure :: refresh
      procedure :: settle
      procedure :: yield
      procedure :: let_go
      procedure :: take_back
      procedure :: start
      procedure :: explain
      procedure :: serialize
   end type implicit_form_t

contains

   !> Lays everything out; nothing is allocated afterwards.
   subroutine init(self, model, method)
      !> The form.
      class(implicit_form_t), intent(out) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> W and solver.
      type(method_t), intent(in) :: method
      integer, allocatable :: first(:), column(:)

      allocate (self%model, source=model)
      self%n_v = model%n
      self%n_x = model%n_x
      self%n_w = model%n_w
      self%c = model%c
      self%n_phi = model%n_phi
      select type (model)
      class is (stiff_system_t)
         self%n_e = model%n_elastic
      end select
      self%n = self%n_x + self%n_v + self%n_w
      self%n_z = 2*self%c + self%n_e
      allocate (self%at%x(self%n_x), self%at%v(self%n_v), self%at%w(self%n_w), source=0.0_wp)
      self%stage = self%at
      call self%coupling%init(model)
      call self%projector%init(model, method)
      call lay_out_jacobian(model, self%a)
      call self%m%init(model%mass_blocks)
      call self%m_here%init(model%mass_blocks)
      select type (model)
      class is (stiff_system_t)
         call model%elastic_pattern(first, column)
         call self%b%set_pattern(self%n_v, first, column)
         call self%b_here%set_pattern(self%n_v, first, column)
         if (self%n_e > 0) call model%elastic_stiffness(self%stiffness)
         if (allocated(model%elastic_damping)) self%tau = model%elastic_damping
      end select
      if (.not. allocated(self%tau)) allocate (self%tau(self%n_e), source=0.0_wp)
      call self%lay_out()
      allocate (self%independent(self%c), source=.true.)
      allocate (self%held(self%c), self%held_before(self%c), source=.false.)
      allocate (self%held_force(self%n_v), source=0.0_wp)
      allocate (self%phi(self%n_phi), self%b_prime(self%c), self%psi(self%c), self%force(self%n_v), self%base(self%n_v), &
                self%base_w(self%n_w), self%balance(self%n_v), self%of_reactions(self%n_v), self%varied_w(self%n_w), &
                self%step(self%n_v), self%unit(self%n_v), self%reactions_here(self%n_v), self%lambda(self%c), &
                self%real_b(self%n_v + self%n_w + self%c), &
                source=0.0_wp)
   end subroutine init

   !> g(y, ydot, z, t): what is to vanish.
   subroutine residual(self, ode, t, y, ydot, z, r, info)
      !> The form.
      class(implicit_form_t), intent(inout) :: self
      !> The system, asked for the times between which it is looked at.
      class(ode_system_t), intent(inout) :: ode
      !> Time [s].
      real(wp), intent(in) :: t
      !> State {x; v; w}: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Its derivative: (n).
      real(wp), intent(in), contiguous :: ydot(:)
      !> {lambda; mu; sigma}: (n_z).
      real(wp), intent(in), contiguous :: z(:)
      !> Residuals of xdot, vdot, wdot, phi, A v - b' and of the strains: (n + n_z).
      real(wp), intent(out), contiguous :: r(:)
      !> `rhs_ok` or `rhs_retry`.
      integer, intent(out) :: info
      integer :: n, n_x, n_y, c

      self%evaluations = self%evaluations + 1
      n = self%n_v
      n_x = self%n_x
      n_y = self%n
      c = self%c
      associate (at => self%stage)
         call take(self, ode, t, y)
         call momentum(self, at, ydot(n_x + 1:n_x + n), z)
         r(n_x + 1:n_x + n) = self%balance
         ! W is that of the linearization: mu vanishes in the limit, whatever its metric.
         self%part_v(:) = 0.0_wp
         call self%a%subtract_transposed(z(c + 1:2*c), self%part_v)
         call self%projector%linear%divide_by_weight(self%part_v)
         self%part_v(:) = at%v + self%part_v
         call self%model%x_rate(at, self%part_v, self%part_x)
         r(:n_x) = ydot(:n_x) - self%part_x
         if (self%n_w > 0) then
            call self%model%w_rate(at, r(n_x + n + 1:n_y))
            r(n_x + n + 1:n_y) = ydot(n_x + n + 1:n_y) - r(n_x + n + 1:n_y)
         end if
         r(n_y + 1:) = 0.0_wp
         if (c > 0) then
            if (self%n_phi > 0) call self%model%constraint(at, r(n_y + 1:n_y + self%n_phi))
            call self%model%velocity_rhs(at, self%b_prime)
            call self%a%multiply(at%v, self%psi, self%b_prime)
            r(n_y + c + 1:n_y + 2*c) = self%psi
         end if
         if (self%n_e > 0) then
            call self%stiffness%multiply(self%strain, r(n_y + 2*c + 1:))
            r(n_y + 2*c + 1:) = r(n_y + 2*c + 1:) - z(2*c + 1:)
         end if
      end associate
      info = merge(rhs_ok, rhs_retry, all(ieee_is_finite(r)))
   end subroutine residual

   !> The state of a stage.
   subroutine take(self, ode, t, y)
      type(implicit_form_t), intent(inout) :: self
      class(ode_system_t), intent(in) :: ode
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)

      self%stage%t = min(max(t, ode%t_low), ode%t_high)
      self%stage%x(:) = y(:self%n_x)
      self%stage%v(:) = y(self%n_x + 1:self%n_x + self%n_v)
      self%stage%w(:) = y(self%n_x + self%n_v + 1:self%n)
      call self%model%normalize(self%stage%x)
   end subroutine take

   !> The power of what changes the energy.
   subroutine find_integrand(self, ode, t, y, z)
      !> The form.
      class(implicit_form_t), intent(inout) :: self
      !> The system in ODE form.
      class(ode_system_t), intent(inout) :: ode
      !> Time [s].
      real(wp), intent(in) :: t
      !> State {x; v; w}: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> {lambda; mu; sigma}: (n_z).
      real(wp), intent(in), contiguous :: z(:)

      call take(self, ode, t, y)
      associate (at => self%stage, lambda => z(:self%c))
         ! At a dead point the multipliers are what round-off makes of them; what holds rows there has freedom.
         ode%integral_counts = count(self%kept) >= self%n_v .and. .not. self%at_dead_point
         if (self%c > 0) call self%model%velocity_rhs(at, self%b_prime)
         ode%integrand = self%model%power(at) - dot_product(lambda, self%b_prime)
         if (self%holding) ode%integrand = ode%integrand + dot_product(self%held_force, at%v)
         if (self%model%reactive) ode%integrand = ode%integrand + power_of_reactions(self%model, at, lambda)
      end associate
   end subroutine find_integrand

   !> The balance M vdot - f_s + B^T sigma + A^T lambda at a state, with A in `a`, B in `b` and the strains in `strain`.
   subroutine momentum(self, at, vdot, z)
      type(implicit_form_t), intent(inout) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(in), contiguous :: vdot(:), z(:)

      if (.not. (self%mass_known .and. self%model%constant_mass)) call self%model%mass(at, self%m)
      self%mass_known = .true.
      call self%m%multiply(vdot, self%balance)
      select type (model => self%model)
      class is (stiff_system_t)
         call model%soft_force(at, self%force)
         if (self%n_e > 0) then
            call model%elastic_rows(at, self%strain, self%b%values)
            call self%b%subtract_transposed(z(2*self%c + 1:), self%force)
         end if
      class default
         call model%force(at, self%force)
      end select
      if (self%model%reactive) then
         call self%model%reaction_force(at, z(:self%c), self%of_reactions)
         self%force(:) = self%force + self%of_reactions
      end if
      if (self%c > 0) then
         call evaluate_jacobian(self%model, at, self%a)
         if (self%holding) then
            self%part_c(:) = merge(0.0_wp, z(:self%c), self%held)
            call self%a%subtract_transposed(self%part_c, self%force)
            self%force(:) = self%force + self%held_force
         else
            call self%a%subtract_transposed(z(:self%c), self%force)
         end if
      end if
      self%balance(:) = self%balance - self%force
   end subroutine momentum

   !> Linearizes at a state: M, A, B, and K and D by differences, of as many velocities at once as no equation sees together.
   subroutine linearize(self, ode, t, h, y, ydot, z, info)
      !> The form.
      class(implicit_form_t), intent(inout) :: self
      !> The system, asked for the times between which it is looked at.
      class(ode_system_t), intent(inout) :: ode
      !> Time [s].
      real(wp), intent(in) :: t
      !> Step, for the size of the differences [s].
      real(wp), intent(in) :: h
      !> State: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Its derivative: (n).
      real(wp), intent(in), contiguous :: ydot(:)
      !> Multipliers and internal forces: (n_z).
      real(wp), intent(in), contiguous :: z(:)
      !> `rhs_ok` or `rhs_retry`.
      integer, intent(out) :: info
      integer :: color, i, j, l, n, n_x
      real(wp) :: reach

      n = self%n_v
      n_x = self%n_x
      call look_at(self, ode, t, y, ydot, z, info)
      if (info /= rhs_ok) return
      associate (at => self%at, vdot => ydot(n_x + 1:n_x + n))
         self%base(:) = self%balance
         if (self%n_w > 0) call self%model%w_rate(at, self%base_w)
         reach = maxval(abs(at%x))
         ! Where all coordinates are zero, what they would be.
         self%unit(:) = 0.0_wp
         if (reach <= epsilon(reach)) call self%model%sizes(at, self%unit, self%step)
         do i = 1, n
            self%step(i) = abs(h*at%v(i))
            if (n_x == n) then
               self%step(i) = max(self%step(i), abs(at%x(i)), 1.0e-3_wp*max(reach, 1.0e-2_wp*self%unit(i)))
            else
               self%step(i) = max(self%step(i), min(1.0_wp, reach))
            end if
            self%step(i) = difference*max(self%step(i), tiny(1.0_wp)/difference)
         end do
         self%stage%t = min(max(t, ode%t_low), ode%t_high)
         self%stage%w(:) = at%w
         do color = 1, self%coupling%colors
            self%unit(:) = merge(self%step, 0.0_wp, self%coupling%color == color)
            self%stage%x(:) = at%x
            self%stage%v(:) = at%v
            call self%model%displace(self%unit, self%stage%x)
            call self%model%normalize(self%stage%x)
            call difference_of(.false.)
         end do
         self%stage%x(:) = at%x
         do i = 1, n
            self%step(i) = difference*max(abs(at%v(i)), self%step(i)/(difference*abs(h)))
         end do
         do color = 1, self%coupling%colors
            self%unit(:) = merge(self%step, 0.0_wp, self%coupling%color == color)
            self%stage%v(:) = at%v + self%unit
            call difference_of(.true.)
         end do
         self%stage%v(:) = at%v
         do j = 1, self%n_w
            reach = difference*max(abs(at%w(j)), 1.0e-3_wp*maxval(abs(at%w)), epsilon(1.0_wp))
            self%stage%w(:) = at%w
            self%stage%w(j) = at%w(j) + reach
            call momentum(self, self%stage, vdot, z)
            self%f_w(:, j) = -(self%balance - self%base)/reach
            call self%model%w_rate(self%stage, self%varied_w)
            self%g_w(:, j) = (self%varied_w - self%base_w)/reach
         end do
      end associate
      call self%assemble()
      if (.not. (all(ieee_is_finite(self%k)) .and. all(ieee_is_finite(self%d)))) info = rhs_retry

   contains

      !> One color's columns of K and dg/dx, or of D and dg/dv.
      subroutine difference_of(velocity)
         logical, intent(in) :: velocity

         call momentum(self, self%stage, ydot(n_x + 1:n_x + n), z)
         self%balance(:) = self%balance - self%base
         do i = 1, n
            do l = self%coupling%first(i), self%coupling%first(i + 1) - 1
               j = self%coupling%column(l)
               if (self%coupling%color(j) /= color) cycle
               if (velocity) then
                  self%soft_d(l) = self%balance(i)/self%step(j)
               else
                  self%soft_k(l) = self%balance(i)/self%step(j)
               end if
            end do
         end do
         if (self%n_w == 0) return
         call self%model%w_rate(self%stage, self%varied_w)
         j = findloc(self%coupling%color, color, 1)
         if (velocity) then
            self%g_v(:, j) = (self%varied_w - self%base_w)/self%step(j)
         else
            self%g_x(:, j) = (self%varied_w - self%base_w)/self%step(j)
         end if
      end subroutine difference_of

   end subroutine linearize

   !> df/dlambda at `at`, one multiplier after the other, of the velocities that its constraint moves.
   subroutine differentiate_reactions(self, lambda)
      type(implicit_form_t), intent(inout) :: self
      real(wp), intent(in), contiguous :: lambda(:)
      integer :: i, j, k, l
      real(wp) :: reach, step

      call self%model%reaction_force(self%at, lambda, self%reactions_here)
      reach = maxval(abs(lambda))
      ! Where all multipliers are zero, they are going to be of the size of the forces.
      if (reach <= tiny(reach)) reach = max(maxval(abs(self%force)), epsilon(reach))
      self%lambda(:) = lambda
      do i = 1, self%c
         step = difference*max(abs(lambda(i)), 1.0e-3_wp*reach)
         self%lambda(i) = lambda(i) + step
         call self%model%reaction_force(self%at, self%lambda, self%of_reactions)
         self%lambda(i) = lambda(i)
         associate (a => self%projector%linear%a)
            do j = 1, entries_of_row(a, i)
               k = place_of(a, i, j)
               l = column_of(a, i, j)
               self%f_lambda(k) = (self%of_reactions(l) - self%reactions_here(l))/step
            end do
         end associate
      end do
   end subroutine differentiate_reactions

   !> M, A, B and df/dlambda at a state, the kept rows of A and the balance there.
   subroutine look_at(self, ode, t, y, ydot, z, info)
      type(implicit_form_t), intent(inout) :: self
      class(ode_system_t), intent(in) :: ode
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:), ydot(:), z(:)
      integer, intent(out) :: info
      integer :: n, n_x

      n = self%n_v
      n_x = self%n_x
      self%at%t = min(max(t, ode%t_low), ode%t_high)
      self%at%x(:) = y(:n_x)
      self%at%v(:) = y(n_x + 1:n_x + n)
      self%at%w(:) = y(n_x + n + 1:)
      self%singular_at = 0
      call self%model%normalize(self%at%x)
      ! On the constraints, where redundant rows are seen to be.
      call self%projector%position(self%model, self%at, info)
      if (info == rhs_no_projection) call self%projector%position_again(self%model, self%at, info)
      if (info /= rhs_ok) return
      call self%projector%linear%linearize(self%model, self%at, info, 0.0_wp)
      if (info /= rhs_ok) return
      self%at_dead_point = self%c > 1 .and. .not. self%projector%linear%onto%weakest() > 0.0_wp
      if (.not. (self%holding .or. self%at_dead_point)) self%held_before(:) = .false.
      call self%projector%linear%kept_rows(self%independent)
      self%kept(:) = self%independent .and. .not. self%held
      if (self%holding) call self%projector%linear%keep_rows(self%kept, info)
      if (info /= rhs_ok) return
      call momentum(self, self%at, ydot(n_x + 1:n_x + n), z)
      if (self%n_e > 0) self%b_here%values(:) = self%b%values
      self%m_here%values(:) = self%m%values
      call self%entries_of_mass()
      if (self%model%reactive) call differentiate_reactions(self, z(:self%c))
   end subroutine look_at

   !> What turns with the motion, M, A, B and df/dlambda, at another state: one evaluation. K and D keep what was found by
   !! differences.
   subroutine refresh(self, ode, t, y, ydot, z, info)
      !> The form, linearized.
      class(implicit_form_t), intent(inout) :: self
      !> The system, asked for the times between which it is looked at.
      class(ode_system_t), intent(inout) :: ode
      !> Time [s].
      real(wp), intent(in) :: t
      !> State: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Its derivative: (n).
      real(wp), intent(in), contiguous :: ydot(:)
      !> Multipliers and internal forces: (n_z).
      real(wp), intent(in), contiguous :: z(:)
      !> `rhs_ok` or `rhs_retry`.
      integer, intent(out) :: info

      call look_at(self, ode, t, y, ydot, z, info)
      if (info /= rhs_ok) return
      call self%assemble()
      if (.not. (all(ieee_is_finite(self%k)) .and. all(ieee_is_finite(self%d)))) info = rhs_retry
   end subroutine refresh

   !> What went wrong in a step, with the coordinate or the constraint that it was found at.
   subroutine explain(self, trouble, entry, text)
      !> The form.
      class(implicit_form_t), intent(in) :: self
      !> One of the constants of the equations.
      integer, intent(in) :: trouble
      !> Entry of y with the largest correction.
      integer, intent(in) :: entry
      !> One line.
      character(:), allocatable, intent(out) :: text
      integer :: i

      if (trouble /= not_converged) then
         call self%projector%explain(self%model, text)
         if (self%too_large) then
            text = 'the factors of '//to_text(self%lu%n)//' equations as bands need '// &
                   to_text(nint(24.0e-9_wp*self%lu%numbers()))//' GB, and UMFPACK, which may need less, is not to be had here '// &
                   '(Debian has it as libumfpack5 or libumfpack6)'
         else if (self%jammed) then
            text = inconsistent_reactions
         else if (self%singular_at > 0) then
            text = 'the matrix is singular at '//trim(velocity_name(self%model, self%singular_at))// &
                   ', which has neither mass nor stiffness nor a constraint that determines it'
         else if (self%singular_at < 0) then
            call self%model%row_name(-self%singular_at, text)
            text = 'the matrix is singular at '//text//', which depends on others'
         else if (len(text) == 0) then
            text = 'a force or one of its derivatives is not a number'
         end if
      else
         i = entry - self%n_x
         if (i > self%n_v) then
            text = 'w('//to_text(i - self%n_v)//')'
         else if (i > 0) then
            text = trim(velocity_name(self%model, i))
         else
            text = trim(coordinate_name(self%model, entry))
         end if
         text = 'the largest correction is that of '//text
      end if
   end subroutine explain

   !> lambda of redundant rows is zero: that of the others makes up for it. mu is to vanish; what predictions make of it would not
   !! be noticed, for it does not move the state.
   pure subroutine settle(self, z_start, z)
      !> The form, linearized.
      class(implicit_form_t), intent(in) :: self
      !> z at the step's start: (n_z).
      real(wp), intent(in), contiguous :: z_start(:)
      !> {lambda; mu; sigma}: (n_z).
      real(wp), intent(inout), contiguous :: z(:)
      integer :: i

      do i = 1, self%c
         if (.not. self%independent(i)) then
            z(i) = 0.0_wp
         else if (.not. self%kept(i)) then
            z(i) = z_start(i)
         end if
         z(self%c + i) = 0.0_wp
      end do
   end subroutine settle

   !> Near a dead point what a row has that the others do not changes its sign within a step, and no Jacobian does for all stages.
   !! Such rows are left out, and what they push with that the others cannot is held: it is smooth, though lambda has a pole there.
   subroutine yield(self, h, yields, info)
      !> The form, linearized.
      class(implicit_form_t), intent(inout) :: self
      !> The step [s].
      real(wp), intent(in) :: h
      !> Whether there are such rows.
      logical, intent(out) :: yields
      !> `rhs_ok` or `rhs_retry`.
      integer, intent(out) :: info

      info = rhs_ok
      yields = .false.
      if (self%c < 2) return
      self%stage%t = self%at%t
      self%stage%x(:) = self%at%x
      self%unit(:) = -h*self%at%v
      call self%model%displace(self%unit, self%stage%x)
      call self%model%normalize(self%stage%x)
      call evaluate_jacobian(self%model, self%stage, self%a)
      self%kept(:) = self%independent
      call self%projector%linear%leave_out(self%a, self%kept)
      self%held(:) = self%independent .and. .not. self%kept
      yields = any(self%held)
      self%holding = yields
   end subroutine yield

   !> All rows are met again, from the next linearization on.
   pure subroutine let_go(self)
      !> The form.
      class(implicit_form_t), intent(inout) :: self

      self%held(:) = .false.
      self%holding = .false.
   end subroutine let_go

   !> A violation that the projection tolerates is turned into a motion by rows that are near to others: what is no more than
   !! round-off of phi counts as none here. What that much of phi is in the motion, the other state shows.
   subroutine take_back(self, ode, t, y, other)
      !> The form.
      class(implicit_form_t), intent(inout) :: self
      !> The system, asked for the times between which it is looked at.
      class(ode_system_t), intent(in) :: ode
      !> Time [s].
      real(wp), intent(in) :: t
      !> State {x; v; w}, projected: (n).
      real(wp), intent(inout), contiguous :: y(:)
      !> A state that meets the constraints no worse: (n).
      real(wp), intent(out), contiguous :: other(:)
      integer :: i, info, n, n_x
      logical :: takes_all
      real(wp) :: cut, tolerance

      n = self%n_v
      n_x = self%n_x
      other(:) = y
      self%stage%t = min(max(t, ode%t_low), ode%t_high)
      self%stage%x(:) = y(:n_x)
      self%stage%v(:) = y(n_x + 1:n_x + n)
      self%stage%w(:) = y(n_x + n + 1:)
      associate (yardstick => self%projector%newton%yardstick, linear => self%projector%linear)
         tolerance = yardstick%tolerance
         call yardstick%allow(tiny(1.0_wp))
         call linear%pass_over(pivot_floor, cut)
         call self%projector%correct(self%model, self%stage, info)
         if (info == rhs_ok) then
            y(:n_x) = self%stage%x
            y(n_x + 1:n_x + n) = self%stage%v
            call yardstick%round_off(self%stage%x, linear%phi)
            do i = 1, self%n_phi
               linear%phi(i) = sign(linear%phi(i), spread_evenly(i))
            end do
            call linear%find_displacement(.false., 0.0_wp, .false., takes_all, info)
            call self%model%displace(linear%d, self%stage%x)
            call self%model%normalize(self%stage%x)
            if (info == rhs_ok) call linear%linearize(self%model, self%stage, info, 0.0_wp)
            if (info == rhs_ok) call self%projector%velocity(self%model, self%stage)
         end if
         call linear%pass_over(cut)
         call yardstick%allow(tolerance)
      end associate
      if (info /= rhs_ok) return
      other(:n_x) = self%stage%x
      other(n_x + 1:n_x + n) = self%stage%v
   end subroutine take_back

   !> Accelerations and multipliers of a state, with its internal forces as they are: M vdot + A^T lambda = f_s - B^T sigma,
   !! A vdot = b''. At a breakpoint a stiff part is not asked for its force afresh, for that would make it ring.
   subroutine start(self, ode, t, y, first, ydot, z, info)
      !> The form.
      class(implicit_form_t), intent(inout) :: self
      !> The system, asked for the times between which it is looked at.
      class(ode_system_t), intent(inout) :: ode
      !> Time [s].
      real(wp), intent(in) :: t
      !> State: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Whether the internal forces are to be found from the strains first.
      logical, intent(in) :: first
      !> Its derivative: (n).
      real(wp), intent(out), contiguous :: ydot(:)
      !> {lambda; mu; sigma}, lambda replaced, mu zero, sigma replaced at the first start: (n_z).
      real(wp), intent(inout), contiguous :: z(:)
      !> `rhs_ok` or `rhs_retry`.
      integer, intent(out) :: info
      integer :: c, i, n, n_x
      logical :: goes_on

      n = self%n_v
      n_x = self%n_x
      c = self%c
      self%at%t = min(max(t, ode%t_low), ode%t_high)
      self%at%x(:) = y(:n_x)
      self%at%v(:) = y(n_x + 1:n_x + n)
      self%at%w(:) = y(n_x + n + 1:)
      self%singular_at = 0
      self%jammed = .false.
      call self%model%normalize(self%at%x)
      call self%projector%linear%linearize(self%model, self%at, info, 0.0_wp)
      if (info /= rhs_ok) return
      call self%projector%linear%kept_rows(self%independent)
      ! At a dead point itself accelerations are what round-off makes of them: what was held on the way there is held on.
      goes_on = self%holding .and. .not. self%projector%linear%onto%weakest() > 0.0_wp .and. &
                all(self%held .eqv. self%held_before)
      self%kept(:) = self%independent
      if (goes_on) then
         self%kept(:) = self%independent .and. .not. self%held
      else if (self%holding) then
         self%held_force(:) = 0.0_wp
      end if
      z(:2*c) = 0.0_wp
      ydot(:) = 0.0_wp
      if (self%n_e > 0 .and. first) then
         select type (model => self%model)
         class is (stiff_system_t)
            call model%elastic_rows(self%at, self%strain, self%b%values)
         end select
         call self%stiffness%multiply(self%strain, z(2*c + 1:))
      end if
      call momentum(self, self%at, ydot(n_x + 1:n_x + n), z)
      self%m_here%values(:) = self%m%values
      call self%entries_of_mass()
      self%k(:) = self%mass
      self%mass(:) = 0.0_wp
      self%d(:) = 0.0_wp
      self%f_w(:, :) = 0.0_wp
      self%f_lambda(:) = 0.0_wp
      self%g_x(:, :) = 0.0_wp
      self%g_v(:, :) = 0.0_wp
      self%g_w(:, :) = 0.0_wp
      call self%factorize(ode, 1, (1.0_wp, 0.0_wp), info)
      if (info == rhs_retry) info = rhs_not_solved
      if (info /= rhs_ok) return
      self%real_x(:) = 0.0_wp
      self%real_x(:n) = -self%balance
      if (c > 0) then
         call self%model%acceleration_rhs(self%at, self%b_prime)
         do i = 1, c
            if (self%kept(i)) self%real_x(n + self%n_w + i) = self%b_prime(i)
         end do
      end if
      self%real_b(:) = self%real_x
      call self%lu%solve(self%real_x)
      z(:c) = self%real_x(n + self%n_w + 1:)
      if (self%model%reactive) call start_reactions(self, ode, z(:c), info)
      if (info /= rhs_ok) return
      call self%model%x_rate(self%at, self%at%v, ydot(:n_x))
      ydot(n_x + 1:n_x + n) = self%real_x(:n)
      if (self%holding .and. .not. goes_on) then
         call find_held_force(self, ode, z(:c), info)
         if (info /= rhs_ok) return
         self%held_before(:) = self%held
      end if
      if (self%n_w > 0) call self%model%w_rate(self%at, ydot(n_x + n + 1:))
      if (ode%has_integral) call self%find_integrand(ode, t, y, z)
      info = merge(rhs_ok, rhs_retry, all(ieee_is_finite(ydot)) .and. all(ieee_is_finite(z)))
   end subroutine start

   !> What the held rows push with that the others cannot: their force less M a, where a is what of the accelerations it gives is
   !! left by the others. It is normal to the constraints, and stays so; the rest of their force would turn away. The others take
   !! over what they can: only then are their multipliers as smooth as the force.
   subroutine find_held_force(self, ode, lambda, info)
      type(implicit_form_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(inout) :: lambda(:)
      integer, intent(out) :: info
      integer :: n

      n = self%n_v
      self%part_c(:) = merge(lambda, 0.0_wp, self%held)
      self%held_force(:) = 0.0_wp
      call self%projector%linear%a%subtract_transposed(self%part_c, self%held_force)
      self%kept(:) = self%independent .and. .not. self%held
      call self%factorize(ode, 1, (1.0_wp, 0.0_wp), info)
      if (info == rhs_retry) info = rhs_not_solved
      if (info /= rhs_ok) return
      self%real_x(:n) = self%held_force
      self%real_x(n + 1:) = 0.0_wp
      call self%lu%solve(self%real_x)
      call self%m_here%multiply(self%real_x(:n), self%held_force)
      lambda(:) = merge(0.0_wp, lambda - self%real_x(n + self%n_w + 1:), self%held)
   end subroutine find_held_force

   !> Forces that depend on the multipliers are those of the multipliers that they lead to, by Newton's iteration; begun at those
   !! of g(0).
   subroutine start_reactions(self, ode, lambda, info)
      type(implicit_form_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(inout), contiguous :: lambda(:)
      integer, intent(out) :: info
      real(wp) :: change, none(self%c), without(self%n_v)
      integer :: i, iteration, j, k, l
      integer, parameter :: most = 50

      none(:) = 0.0_wp
      call self%model%reaction_force(self%at, none, without)
      self%jammed = .true.
      do iteration = 1, most
         call differentiate_reactions(self, lambda)
         call self%factorize(ode, 1, (1.0_wp, 0.0_wp), info)
         if (info /= rhs_ok) exit
         self%real_x(:) = self%real_b
         self%real_x(:self%n_v) = self%real_x(:self%n_v) + self%reactions_here - without
         associate (a => self%projector%linear%a)
            do i = 1, self%c
               do j = 1, entries_of_row(a, i)
                  k = place_of(a, i, j)
                  l = column_of(a, i, j)
                  self%real_x(l) = self%real_x(l) - self%f_lambda(k)*lambda(i)
               end do
            end do
         end associate
         call self%lu%solve(self%real_x)
         associate (found => self%real_x(self%n_v + self%n_w + 1:))
            change = maxval(abs(found - lambda))
            lambda(:) = found
            self%jammed = .not. change <= 1.0e-12_wp*maxval(abs(found))
            if (.not. (self%jammed .and. change <= huge(change))) exit
         end associate
      end do
      self%f_lambda(:) = 0.0_wp
      if (self%jammed .and. info /= rhs_cannot) info = rhs_not_solved
   end subroutine start_reactions

   !> Passes through an archive what is remembered from one step to the next: of the rank, and of what is held.
   subroutine serialize(self, archive)
      !> The form, initialized.
      class(implicit_form_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      call self%projector%serialize(archive)
      call archive%item('is at a dead point', self%at_dead_point)
      call archive%item('holds rows', self%holding)
      call archive%item('force of held rows', self%held_force)
      call pass_rows('rows held', self%held)
      call pass_rows('rows held before', self%held_before)

   contains

      subroutine pass_rows(name, rows)
         character(*), intent(in) :: name
         logical, intent(inout) :: rows(:)
         real(wp) :: chosen(size(rows))

         chosen = merge(1.0_wp, 0.0_wp, rows)
         call archive%item(name, chosen)
         rows(:) = chosen > 0.0_wp
      end subroutine pass_rows

   end subroutine serialize

end module taut_constrained_implicit
