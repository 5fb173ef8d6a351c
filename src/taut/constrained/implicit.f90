!> A constrained system in fully implicit form, g(y, ydot, z, t) = 0 (Sect. 3.4), as a stiff integrator asks for it.
!!
!!     xdot = H(x) (v - W^-1 A^T mu),   M(x) vdot = f_s(x, v, w, t) - B(x)^T sigma - A^T lambda,   wdot = g(x, v, w, t)
!!     phi(x, t) = 0,   A(x, t) v = b'(x, t),   sigma = k (g(x) + tau gdot)
!!
!! with y = {x; v; w} and z = {lambda; mu; sigma}. mu keeps the velocities and the coordinates on their constraints at once: C.W.
!! Gear, G.K. Gupta, B. Leimkuhler, Automatic integration of Euler-Lagrange equations with constraints, J. Comput. Appl. Math.
!! 12&13 (1985) 77-90. sigma, the internal force of the elastic rows, keeps Newton's matrix valid while a stiff part turns; in the
!! limit of a large k it is the multiplier of a constraint.
!!
!! Newton's equations, with d/dt replaced by a number s, are solved in two steps. With u = s dx - dv, the first is
!! W u + A^T dmu = -W rx, A u = rpsi - s rphi; the second
!! (M s^2 + D s + K) dx + A^T dlambda = -rv + (M s + D) u, A dx = -rphi, with dsigma = k B (dx + tau dv) + rsigma eliminated into
!! K, D and the right-hand side. Redundant rows are left out of both, so that neither
!! matrix is singular. In methods of second order, s of dv is another number than that of dx.
module taut_constrained_implicit
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_kinds, only: wp
   use taut_constrained_coupling, only: coupling_t
   use taut_constrained_method_options, only: method_t
   use taut_constrained_projection, only: evaluate_jacobian, lay_out_jacobian, projector_t
   use taut_constrained_reactions, only: power_of_reactions
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_constrained_system_stiff, only: stiff_system_t
   use taut_linalg_band_lu, only: band_pattern_t, complex_band_lu_t, real_band_lu_t
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_csr, only: csr_t
   use taut_ode_system, only: ode_system_t, rhs_ok, rhs_retry, stage_equations_t
   implicit none (type, external)
   private
   public :: implicit_form_t

   !> Step of the differences relative to the size of what is varied.
   real(wp), parameter :: difference = sqrt(epsilon(1.0_wp))

   !> The form, its linearization at a state, and factors for one real and one complex number s.
   type, extends(stage_equations_t) :: implicit_form_t
      !> Velocity, or constraint as a negative number, at which the last matrix was singular; 0 if none was.
      integer :: singular_at = 0
      !> Whether mu is an unknown, so that velocities are on their constraints; else those of holonomic ones are left to the
      !! coordinates (index 3), and the residual of mu is of no account.
      logical :: stabilized = .true.
      !> Where d/dt of velocities and of w is replaced by another number than that of coordinates: their ratio.
      real(wp) :: second = 1.0_wp
      class(mechanical_system_t), allocatable, private :: model
      integer, private :: n_v = 0, n_x = 0, n_w = 0, c = 0, n_phi = 0, n_e = 0
      type(coupling_t), private :: coupling
      !> Where the system was linearized, and where it is looked at.
      type(state_t), private :: at, stage
      !> A, W and S where the system was linearized.
      type(projector_t), private :: projector
      type(csr_t), private :: a, b, b_here
      type(block_diagonal_t), private :: m, m_here, stiffness
      !> Entries of K, D and M in the pattern of the coupling.
      real(wp), allocatable, private :: k(:), d(:), mass(:)
      !> df/dw, dg/dx, dg/dv, dg/dw.
      real(wp), allocatable, private :: f_w(:, :), g_x(:, :), g_v(:, :), g_w(:, :)
      !> Rows of A that are solved for, and those that are not redundant.
      logical, allocatable, private :: kept(:), independent(:)
      !> Time constants of the damping of the elastic rows.
      real(wp), allocatable, private :: tau(:)
      type(band_pattern_t), private :: saddle
      type(real_band_lu_t), private :: real_factor
      type(complex_band_lu_t), private :: complex_factor
      complex(wp), private :: shift(2) = (0.0_wp, 0.0_wp)
      real(wp), allocatable, private :: real_values(:), real_x(:), real_b(:)
      complex(wp), allocatable, private :: complex_values(:)
      real(wp), allocatable, private :: phi(:), b_prime(:), psi(:), force(:), strain(:), mu(:)
      real(wp), allocatable, private :: base(:), base_w(:), balance(:), of_reactions(:), varied_w(:), step(:), unit(:)
      complex(wp), allocatable, private :: u(:), along(:), across(:), wanted(:), unknown(:)
      !> Real and imaginary parts.
      real(wp), allocatable, private :: part_x(:), other_x(:), part_v(:), other_v(:), part_c(:), other_c(:), part_e(:), other_e(:)
      logical, private :: damped = .false., mass_known = .false.
   contains
      procedure :: init
      procedure :: residual
      procedure :: linearize
      procedure :: factorize
      procedure :: solve
      procedure :: multiply
      procedure :: settle
      procedure :: yield
      procedure :: start
      procedure :: displacement
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
      integer, allocatable :: first(:), column(:), row(:), col(:)
      integer :: i, j, l, nnz, p

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
      nnz = size(self%coupling%column)
      allocate (self%k(nnz), self%d(nnz), self%mass(nnz), source=0.0_wp)
      allocate (self%f_w(self%n_v, self%n_w), self%g_x(self%n_w, self%n_v), self%g_v(self%n_w, self%n_v), &
                self%g_w(self%n_w, self%n_w), source=0.0_wp)
      allocate (self%kept(self%c), self%independent(self%c), source=.true.)
      allocate (self%phi(self%n_phi), self%b_prime(self%c), self%psi(self%c), self%force(self%n_v), self%strain(self%n_e), &
                self%part_x(self%n_x), self%part_v(self%n_v), self%part_c(self%c), self%part_e(self%n_e), self%other_x(self%n_x), &
                self%other_v(self%n_v), self%other_c(self%c), self%other_e(self%n_e), self%mu(self%c), &
                self%base(self%n_v), &
                self%base_w(self%n_w), self%balance(self%n_v), self%of_reactions(self%n_v), self%varied_w(self%n_w), &
                self%step(self%n_v), self%unit(self%n_v), &
                source=0.0_wp)
      allocate (self%u(self%n_v), self%along(self%n_v), self%across(self%n_x), self%wanted(self%c), source=(0.0_wp, 0.0_wp))
      self%damped = any(self%tau > 0.0_wp)

      ! The saddle-point matrix, unknowns dx, dw, dlambda: the order of the entries is that of `fill`.
      p = nnz + (2*self%n_v + self%n_w)*self%n_w
      do i = 1, self%c
         p = p + 2*entries_of_row(self%a, i) + 1
      end do
      allocate (row(p), col(p))
      do i = 1, self%n_v
         row(self%coupling%first(i):self%coupling%first(i + 1) - 1) = i
      end do
      col(:nnz) = self%coupling%column
      p = nnz
      do j = 1, self%n_w
         do i = 1, self%n_v
            row(p + 1:p + 2) = [i, self%n_v + j]
            col(p + 1:p + 2) = [self%n_v + j, i]
            p = p + 2
         end do
         do i = 1, self%n_w
            p = p + 1
            row(p) = self%n_v + i
            col(p) = self%n_v + j
         end do
      end do
      l = self%n_v + self%n_w
      do i = 1, self%c
         do j = 1, entries_of_row(self%a, i)
            row(p + 1:p + 2) = [l + i, column_of(self%a, i, j)]
            col(p + 1:p + 2) = [column_of(self%a, i, j), l + i]
            p = p + 2
         end do
         p = p + 1
         row(p) = l + i
         col(p) = l + i
      end do
      call self%saddle%init(l + self%c, row, col)
      allocate (self%real_values(size(row)), self%real_x(l + self%c), self%real_b(l + self%c), source=0.0_wp)
      allocate (self%complex_values(size(row)), self%unknown(l + self%c), source=(0.0_wp, 0.0_wp))
   end subroutine init

   !> Number of entries of a row.
   pure integer function entries_of_row(a, i)
      type(csr_t), intent(in) :: a
      integer, intent(in) :: i

      if (a%full) then
         entries_of_row = a%n
      else
         entries_of_row = a%first(i + 1) - a%first(i)
      end if
   end function entries_of_row

   !> Column of the j-th entry of a row.
   pure integer function column_of(a, i, j)
      type(csr_t), intent(in) :: a
      integer, intent(in) :: i, j

      if (a%full) then
         column_of = j
      else
         column_of = a%column(a%first(i) + j - 1)
      end if
   end function column_of

   !> Value of the j-th entry of a row.
   pure real(wp) function value_of(a, i, j)
      type(csr_t), intent(in) :: a
      integer, intent(in) :: i, j

      if (a%full) then
         value_of = a%values((i - 1)*a%n + j)
      else
         value_of = a%values(a%first(i) + j - 1)
      end if
   end function value_of

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
         at%t = min(max(t, ode%t_low), ode%t_high)
         at%x(:) = y(:n_x)
         at%v(:) = y(n_x + 1:n_x + n)
         at%w(:) = y(n_x + n + 1:n_y)
         call self%model%normalize(at%x)
         call momentum(self, at, ydot(n_x + 1:n_x + n), z)
         r(n_x + 1:n_x + n) = self%balance
         ! W is that of the linearization: mu vanishes in the limit, whatever its metric.
         self%part_v(:) = 0.0_wp
         call self%a%subtract_transposed(z(c + 1:2*c), self%part_v)
         call self%projector%divide_by_weight(self%part_v)
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
      if (info == rhs_ok .and. ode%has_integral) call find_power(self, ode, self%stage, z)
   end subroutine residual

   !> Power of what changes the energy, with b' in place.
   subroutine find_power(self, ode, at, z)
      type(implicit_form_t), intent(in) :: self
      class(ode_system_t), intent(inout) :: ode
      type(state_t), intent(in) :: at
      real(wp), intent(in), contiguous :: z(:)

      ode%integrand = self%model%power(at) - dot_product(z(:self%c), self%b_prime)
      if (self%model%reactive) ode%integrand = ode%integrand + power_of_reactions(self%model, at, z(:self%c))
   end subroutine find_power

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
         call self%a%subtract_transposed(z(:self%c), self%force)
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
      self%at%t = min(max(t, ode%t_low), ode%t_high)
      self%at%x(:) = y(:n_x)
      self%at%v(:) = y(n_x + 1:n_x + n)
      self%at%w(:) = y(n_x + n + 1:)
      call self%model%normalize(self%at%x)
      ! On the constraints, where redundant rows are seen to be.
      call self%projector%position(self%model, self%at, info)
      if (info /= rhs_ok) return
      call self%projector%linearize(self%model, self%at, info, 0.0_wp)
      if (info /= rhs_ok) return
      call self%projector%kept_rows(self%independent)
      self%kept(:) = self%independent
      associate (at => self%at, vdot => ydot(n_x + 1:n_x + n))
         call momentum(self, at, vdot, z)
         self%base(:) = self%balance
         if (self%n_e > 0) self%b_here%values(:) = self%b%values
         self%m_here%values(:) = self%m%values
         call entries_of_mass(self)
         if (self%n_w > 0) call self%model%w_rate(at, self%base_w)
         reach = maxval(abs(at%x))
         do i = 1, n
            self%step(i) = abs(h*at%v(i))
            if (n_x == n) then
               self%step(i) = max(self%step(i), abs(at%x(i)), 1.0e-3_wp*reach)
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
      if (self%n_e > 0) call add_elastic(self)
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
                  self%d(l) = self%balance(i)/self%step(j)
               else
                  self%k(l) = self%balance(i)/self%step(j)
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

   !> M in the pattern of the coupling.
   subroutine entries_of_mass(self)
      type(implicit_form_t), intent(inout) :: self
      integer :: b, i, j, k, l, size_of_block

      self%mass(:) = 0.0_wp
      k = 0
      do b = 1, size(self%m_here%first) - 1
         size_of_block = self%m_here%first(b + 1) - self%m_here%first(b)
         do j = self%m_here%first(b), self%m_here%first(b + 1) - 1
            do i = self%m_here%first(b), self%m_here%first(b + 1) - 1
               k = k + 1
               l = self%coupling%place(i, j)
               self%mass(l) = self%m_here%values(k)
            end do
         end do
      end do
   end subroutine entries_of_mass

   !> Adds B^T k B to K, and with the time constants of the damping to D.
   subroutine add_elastic(self)
      type(implicit_form_t), intent(inout) :: self
      integer :: block, i, j, k, l, p, place
      real(wp) :: stiffness

      place = 0
      do block = 1, size(self%stiffness%first) - 1
         do j = self%stiffness%first(block), self%stiffness%first(block + 1) - 1
            do i = self%stiffness%first(block), self%stiffness%first(block + 1) - 1
               place = place + 1
               if (.not. abs(self%stiffness%values(place)) > 0.0_wp) cycle
               do k = self%b_here%first(i), self%b_here%first(i + 1) - 1
                  do l = self%b_here%first(j), self%b_here%first(j + 1) - 1
                     p = self%coupling%place(self%b_here%column(k), self%b_here%column(l))
                     stiffness = self%b_here%values(k)*self%stiffness%values(place)*self%b_here%values(l)
                     self%k(p) = self%k(p) + stiffness
                     self%d(p) = self%d(p) + stiffness*self%tau(j)
                  end do
               end do
            end do
         end do
      end do
   end subroutine add_elastic

   !> The saddle-point matrix of the second step, factorized.
   subroutine factorize(self, ode, slot, shift, info)
      !> The form, linearized.
      class(implicit_form_t), intent(inout) :: self
      !> Not asked.
      class(ode_system_t), intent(inout) :: ode
      !> 1 for a shift without an imaginary part, 2 for one with.
      integer, intent(in) :: slot
      !> What d/dt is replaced by, s [1/s].
      complex(wp), intent(in) :: shift
      !> `rhs_ok`, or `rhs_retry` for a singular matrix: see `singular_at`.
      integer, intent(out) :: info

      self%shift(slot) = shift
      call fill(self, shift)
      if (slot == 1) then
         self%real_values(:) = real(self%complex_values, wp)
         call self%real_factor%factorize(self%saddle, self%real_values, info)
      else
         call self%complex_factor%factorize(self%saddle, self%complex_values, info)
      end if
      call judge(self, info)
      associate (unused_system => ode)
      end associate
   end subroutine factorize

   !> Where a matrix was singular.
   pure subroutine judge(self, info)
      type(implicit_form_t), intent(inout) :: self
      integer, intent(inout) :: info

      self%singular_at = max(info, 0)
      if (info > self%n_v) self%singular_at = min(0, self%n_v + self%n_w - info)
      info = merge(rhs_ok, rhs_retry, info == 0)
   end subroutine judge

   !> The entries of the saddle-point matrix, in the order of `init`.
   pure subroutine fill(self, s)
      type(implicit_form_t), intent(inout) :: self
      complex(wp), intent(in) :: s
      integer :: i, j, p
      real(wp) :: value

      p = size(self%k)
      self%complex_values(:p) = (self%mass*(self%second*s) + self%d)*s + self%k
      do j = 1, self%n_w
         do i = 1, self%n_v
            self%complex_values(p + 1) = -self%f_w(i, j)
            self%complex_values(p + 2) = -(self%g_x(j, i) + s*self%g_v(j, i))
            p = p + 2
         end do
         do i = 1, self%n_w
            p = p + 1
            self%complex_values(p) = -self%g_w(i, j)
            if (i == j) self%complex_values(p) = self%second*s + self%complex_values(p)
         end do
      end do
      associate (a => self%projector%a)
         do i = 1, self%c
            do j = 1, entries_of_row(a, i)
               value = 0.0_wp
               if (self%kept(i)) value = value_of(a, i, j)
               self%complex_values(p + 1) = value
               self%complex_values(p + 2) = value
               p = p + 2
            end do
            p = p + 1
            self%complex_values(p) = merge(0.0_wp, 1.0_wp, self%kept(i))
         end do
      end associate
   end subroutine fill

   !> Newton's correction, in both steps.
   subroutine solve(self, ode, slot, r)
      !> The form, factorized.
      class(implicit_form_t), intent(inout) :: self
      !> Not asked.
      class(ode_system_t), intent(inout) :: ode
      !> Which factors.
      integer, intent(in) :: slot
      !> Residual, replaced by the correction: (n + n_z).
      complex(wp), intent(inout), contiguous :: r(:)
      complex(wp) :: s
      logical :: is_complex
      integer :: c, i, j, n, n_w, n_x, n_y

      s = self%shift(slot)
      is_complex = slot == 2
      n = self%n_v
      n_x = self%n_x
      n_w = self%n_w
      n_y = self%n
      c = self%c
      ! First: W u + A^T dmu = -W rx, A u = rpsi - s rphi; what of rx lies across the directions of the velocities is divided by s.
      call split(self, is_complex, r(:n_x))
      self%u(:) = -self%along
      self%wanted(:) = r(n_y + c + 1:n_y + 2*c)
      self%wanted(:self%n_phi) = self%wanted(:self%n_phi) - s*r(n_y + 1:n_y + self%n_phi)
      call meet(self, is_complex, r(n_y + c + 1:n_y + 2*c))
      ! Second: (M s^2 + D s + K) dx - f_w dw + A^T dlambda = -rv + (M s + D) u - B^T C^-1 rsigma, A dx = -rphi.
      associate (x => self%unknown, a => self%projector%a)
         x(:) = (0.0_wp, 0.0_wp)
         x(:n) = -r(n_x + 1:n_x + n)
         call add_product(self%coupling, self%second*s, self%mass, self%d, self%u, x(:n))
         if (self%n_e > 0) call add_elastic_force(self, r(n_y + 2*c + 1:))
         do i = 1, n_w
            x(n + i) = -r(n_x + n + i)
            do j = 1, n
               x(n + i) = x(n + i) - self%g_v(i, j)*self%u(j)
            end do
         end do
         do i = 1, c
            if (.not. self%kept(i)) cycle
            if (i <= self%n_phi) then
               x(n + n_w + i) = -r(n_y + i)
            else
               x(n + n_w + i) = (row_times(a, i, self%u) - self%wanted(i))/s
            end if
         end do
         if (is_complex) then
            call self%complex_factor%solve(self%saddle, x)
         else
            self%real_x(:) = real(x, wp)
            call self%real_factor%solve(self%saddle, self%real_x)
            x(:) = self%real_x
         end if
         call join(self, s, r(:n_x))
         r(n_x + 1:n_x + n) = s*x(:n) - self%u
         r(n_x + n + 1:n_y) = x(n + 1:n + n_w)
         r(n_y + 1:n_y + c) = x(n + n_w + 1:)
         if (self%n_e > 0) call internal_forces(self, r(n_x + 1:n_x + n), r(n_y + 2*c + 1:))
      end associate
      associate (unused_system => ode)
      end associate
   end subroutine solve

   !> The residual of xdot along the velocities, H^+ rx, and what is left of it.
   subroutine split(self, is_complex, r)
      type(implicit_form_t), intent(inout) :: self
      logical, intent(in) :: is_complex
      complex(wp), intent(in), contiguous :: r(:)
      integer :: i

      call to_parts(r, self%part_x, self%other_x)
      call self%model%v_of_x_rate(self%at, self%part_x, self%part_v)
      call self%model%v_of_x_rate(self%at, self%other_x, self%other_v)
      call of_parts(self%part_v, self%other_v, self%along)
      self%across(:) = (0.0_wp, 0.0_wp)
      if (self%n_x == self%n_v) return
      call self%model%x_rate(self%at, self%part_v, self%part_x)
      if (is_complex) then
         call self%model%x_rate(self%at, self%other_v, self%other_x)
      else
         self%other_x(:) = 0.0_wp
      end if
      do i = 1, self%n_x
         self%across(i) = r(i) - cmplx(self%part_x(i), self%other_x(i), wp)
      end do
   end subroutine split

   !> H dx, less what of the residual lies across divided by s.
   subroutine join(self, s, d)
      type(implicit_form_t), intent(inout) :: self
      complex(wp), intent(in) :: s
      complex(wp), intent(inout), contiguous :: d(:)
      integer :: i

      call to_parts(self%unknown(:self%n_v), self%part_v, self%other_v)
      call self%model%x_rate(self%at, self%part_v, self%part_x)
      call self%model%x_rate(self%at, self%other_v, self%other_x)
      do i = 1, self%n_x
         d(i) = cmplx(self%part_x(i), self%other_x(i), wp) - self%across(i)/s
      end do
   end subroutine join

   !> Real and imaginary parts.
   pure subroutine to_parts(z, re, im)
      complex(wp), intent(in), contiguous :: z(:)
      real(wp), intent(out), contiguous :: re(:), im(:)
      integer :: i

      do i = 1, size(z)
         re(i) = real(z(i), wp)
         im(i) = aimag(z(i))
      end do
   end subroutine to_parts

   !> A vector of its real and imaginary parts.
   pure subroutine of_parts(re, im, z)
      real(wp), intent(in), contiguous :: re(:), im(:)
      complex(wp), intent(out), contiguous :: z(:)
      integer :: i

      do i = 1, size(z)
         z(i) = cmplx(re(i), im(i), wp)
      end do
   end subroutine of_parts

   !> u := u - W^-1 A^T mu with A u = `wanted` in the holonomic rows.
   subroutine meet(self, is_complex, mu)
      type(implicit_form_t), intent(inout) :: self
      logical, intent(in) :: is_complex
      complex(wp), intent(inout), contiguous :: mu(:)

      mu(:) = (0.0_wp, 0.0_wp)
      if (self%n_phi == 0 .or. .not. self%stabilized) return
      call to_parts(self%u, self%part_v, self%other_v)
      call to_parts(self%wanted, self%part_c, self%other_c)
      call self%projector%meet_holonomic(self%part_c, self%part_v, self%mu)
      self%part_c(:) = self%mu
      self%mu(:) = 0.0_wp
      if (is_complex) call self%projector%meet_holonomic(self%other_c, self%other_v, self%mu)
      call of_parts(self%part_c, self%mu, mu)
      call of_parts(self%part_v, self%other_v, self%u)
   end subroutine meet

   !> y := y + (s M + D) x.
   pure subroutine add_product(coupling, s, m, d, x, y)
      type(coupling_t), intent(in) :: coupling
      complex(wp), intent(in) :: s
      real(wp), intent(in) :: m(:), d(:)
      complex(wp), intent(in) :: x(:)
      complex(wp), intent(inout) :: y(:)
      integer :: i, l

      do i = 1, size(y)
         do l = coupling%first(i), coupling%first(i + 1) - 1
            y(i) = y(i) + (s*m(l) + d(l))*x(coupling%column(l))
         end do
      end do
   end subroutine add_product

   !> A row of a matrix times a vector.
   pure function row_times(a, i, x) result(product)
      type(csr_t), intent(in) :: a
      integer, intent(in) :: i
      complex(wp), intent(in) :: x(:)
      complex(wp) :: product
      integer :: j

      product = (0.0_wp, 0.0_wp)
      do j = 1, entries_of_row(a, i)
         product = product + value_of(a, i, j)*x(column_of(a, i, j))
      end do
   end function row_times

   !> The elastic forces of a misfit of sigma, -B^T r, on the right-hand side.
   subroutine add_elastic_force(self, r)
      type(implicit_form_t), intent(inout) :: self
      complex(wp), intent(in), contiguous :: r(:)
      integer :: i

      call to_parts(r, self%part_e, self%other_e)
      self%part_v(:) = 0.0_wp
      self%other_v(:) = 0.0_wp
      call self%b_here%subtract_transposed(self%part_e, self%part_v)
      call self%b_here%subtract_transposed(self%other_e, self%other_v)
      do i = 1, self%n_v
         self%unknown(i) = self%unknown(i) + cmplx(self%part_v(i), self%other_v(i), wp)
      end do
   end subroutine add_elastic_force

   !> dsigma = k B (dx + tau dv) + rsigma, in the place of rsigma; dx is in `unknown`.
   subroutine internal_forces(self, dv, r)
      type(implicit_form_t), intent(inout) :: self
      complex(wp), intent(in), contiguous :: dv(:)
      complex(wp), intent(inout), contiguous :: r(:)
      integer :: i

      call to_parts(self%unknown(:self%n_v), self%part_v, self%other_v)
      call self%b_here%multiply(self%part_v, self%part_e)
      call self%b_here%multiply(self%other_v, self%other_e)
      if (self%damped) then
         call to_parts(dv, self%part_v, self%other_v)
         call self%b_here%multiply(self%part_v, self%strain)
         self%part_e(:) = self%part_e + self%tau*self%strain
         call self%b_here%multiply(self%other_v, self%strain)
         self%other_e(:) = self%other_e + self%tau*self%strain
      end if
      call self%stiffness%multiply(self%part_e, self%strain)
      do i = 1, self%n_e
         r(i) = r(i) + self%strain(i)
      end do
      call self%stiffness%multiply(self%other_e, self%strain)
      do i = 1, self%n_e
         r(i) = r(i) + cmplx(0.0_wp, self%strain(i), wp)
      end do
   end subroutine internal_forces

   !> dx of the last correction with a real number s, along the velocities.
   pure subroutine displacement(self, d)
      !> The form, as `solve` left it.
      class(implicit_form_t), intent(in) :: self
      !> Displacement: (velocities).
      real(wp), intent(out), contiguous :: d(:)

      d(:) = self%real_x(:self%n_v)
   end subroutine displacement

   !> What d/dt stands before: {xdot; M vdot; wdot} at the linearization.
   pure subroutine multiply(self, q, r)
      !> The form, linearized.
      class(implicit_form_t), intent(in) :: self
      !> A derivative of y: (n).
      real(wp), intent(in), contiguous :: q(:)
      !> Its product; zeros beyond n: (n + n_z).
      real(wp), intent(out), contiguous :: r(:)

      r(:self%n) = q
      call self%m_here%multiply(q(self%n_x + 1:self%n_x + self%n_v), r(self%n_x + 1:self%n_x + self%n_v))
      r(self%n + 1:) = 0.0_wp
   end subroutine multiply

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
   !! Such rows are left out, with their lambda as at the step's start: it is smooth, and moves the state by nearly nothing there.
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
      call self%projector%leave_out(self%a, self%kept, info)
      yields = any(self%kept .neqv. self%independent)
   end subroutine yield

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

      n = self%n_v
      n_x = self%n_x
      c = self%c
      self%at%t = min(max(t, ode%t_low), ode%t_high)
      self%at%x(:) = y(:n_x)
      self%at%v(:) = y(n_x + 1:n_x + n)
      self%at%w(:) = y(n_x + n + 1:)
      call self%model%normalize(self%at%x)
      call self%projector%linearize(self%model, self%at, info, 0.0_wp)
      if (info /= rhs_ok) return
      call self%projector%kept_rows(self%independent)
      self%kept(:) = self%independent
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
      call entries_of_mass(self)
      self%k(:) = self%mass
      self%mass(:) = 0.0_wp
      self%d(:) = 0.0_wp
      self%f_w(:, :) = 0.0_wp
      self%g_x(:, :) = 0.0_wp
      self%g_v(:, :) = 0.0_wp
      self%g_w(:, :) = 0.0_wp
      call self%factorize(ode, 1, (1.0_wp, 0.0_wp), info)
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
      call self%real_factor%solve(self%saddle, self%real_x)
      z(:c) = self%real_x(n + self%n_w + 1:)
      if (self%model%reactive) call start_reactions(self, z(:c))
      call self%model%x_rate(self%at, self%at%v, ydot(:n_x))
      ydot(n_x + 1:n_x + n) = self%real_x(:n)
      if (self%n_w > 0) call self%model%w_rate(self%at, ydot(n_x + n + 1:))
      if (ode%has_integral) then
         call self%model%velocity_rhs(self%at, self%b_prime)
         call find_power(self, ode, self%at, z)
      end if
      info = merge(rhs_ok, rhs_retry, all(ieee_is_finite(ydot)) .and. all(ieee_is_finite(z)))
   end subroutine start

   !> Forces that depend on the multipliers are those of the multipliers that they lead to; begun at those of g(0).
   subroutine start_reactions(self, lambda)
      type(implicit_form_t), intent(inout) :: self
      real(wp), intent(inout), contiguous :: lambda(:)
      real(wp) :: change, none(self%c), without(self%n_v)
      integer :: i, iteration
      integer, parameter :: most = 50

      none(:) = 0.0_wp
      call self%model%reaction_force(self%at, none, without)
      do iteration = 1, most
         call self%model%reaction_force(self%at, lambda, self%of_reactions)
         self%real_x(:) = self%real_b
         do i = 1, self%n_v
            self%real_x(i) = self%real_x(i) + self%of_reactions(i) - without(i)
         end do
         call self%real_factor%solve(self%saddle, self%real_x)
         associate (found => self%real_x(self%n_v + self%n_w + 1:))
            change = maxval(abs(found - lambda))
            lambda(:) = found
            if (change <= 1.0e-12_wp*maxval(abs(found))) return
         end associate
      end do
   end subroutine start_reactions

end module taut_constrained_implicit
