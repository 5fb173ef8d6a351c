!> Newton's matrix of a constrained system in implicit form, and what is solved with it.
!!
!! Newton's equations, with d/dt replaced by a number s, are solved in two steps. With u = s dx - dv, the first is
!! W u + A^T dmu = -W rx, A u = rpsi - s rphi; the second
!! (M s^2 + D s + K) dx + (A^T - G) dlambda = -rv + (M s + D) u, A dx = -rphi, with dsigma = k B (dx + tau dv) + rsigma
!! eliminated into K, D and the right-hand side, and G what forces make of the multipliers that they depend on. Redundant rows are
!! left out of both, so that neither matrix is singular. In methods of second order, s of dv is another number than that of dx.
module taut_constrained_saddle_point
   use taut_kinds, only: wp
   use taut_constrained_coupling, only: coupling_t
   use taut_constrained_projection, only: projector_t
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_csr, only: csr_t
   use taut_linalg_lu, only: lu_t, lu_too_large
   use taut_linalg_lu_choose, only: choose_lu
   use taut_ode_system, only: ode_system_t, rhs_cannot, rhs_ok, rhs_retry, stage_equations_t
   implicit none (type, external)
   private
   public :: saddle_point_t, entries_of_row, column_of, place_of

   !> The matrix at a state, and factors for one real and one complex number s; what it is made of is filled in by an extension.
   type, abstract, extends(stage_equations_t) :: saddle_point_t
      !> Velocity, or constraint as a negative number, at which the last matrix was singular; 0 if none was.
      integer :: singular_at = 0
      !> Whether the last matrix was too large to be factorized.
      logical :: too_large = .false.
      !> Whether mu is an unknown, so that velocities are on their constraints; else those of holonomic ones are left to the
      !! coordinates (index 3), and the residual of mu is of no account.
      logical :: stabilized = .true.
      !> Where d/dt of velocities and of w is replaced by another number than that of coordinates: their ratio.
      real(wp) :: second = 1.0_wp
      class(mechanical_system_t), allocatable :: model
      integer :: n_v = 0, n_x = 0, n_w = 0, c = 0, n_phi = 0, n_e = 0
      type(coupling_t) :: coupling
      !> Where the system was linearized.
      type(state_t) :: at
      !> A, W and S there, and the rows of A that are kept; B and M.
      type(projector_t) :: projector
      logical, allocatable :: kept(:)
      type(csr_t) :: b_here
      type(block_diagonal_t) :: m_here, stiffness
      !> Time constants of the damping of the elastic rows.
      real(wp), allocatable :: tau(:)
      !> Entries of K, D and M in the pattern of the coupling; K and D without what the elastic rows contribute.
      real(wp), allocatable :: k(:), d(:), mass(:), soft_k(:), soft_d(:)
      !> df/dw, dg/dx, dg/dv, dg/dw.
      real(wp), allocatable :: f_w(:, :), g_x(:, :), g_v(:, :), g_w(:, :)
      !> df/dlambda, G, in the pattern of A^T: zero where no force depends on the multipliers.
      real(wp), allocatable :: f_lambda(:)
      !> Strains or forces of the elastic rows; workspace.
      real(wp), allocatable :: strain(:)
      !> The saddle-point matrix for a real and for a complex number s.
      class(lu_t), allocatable :: lu
      !> Right-hand side and solution of the real matrix.
      real(wp), allocatable :: real_x(:)
      !> Real and imaginary parts; workspace.
      real(wp), allocatable :: part_x(:), other_x(:), part_v(:), other_v(:), part_c(:), other_c(:), part_e(:), other_e(:)
      complex(wp), private :: shift(2) = (0.0_wp, 0.0_wp)
      real(wp), allocatable, private :: real_values(:), mu(:)
      complex(wp), allocatable, private :: complex_values(:), u(:), along(:), across(:), wanted(:), unknown(:)
      logical, private :: damped = .false.
   contains
      procedure :: lay_out
      procedure :: entries_of_mass
      procedure :: assemble
      procedure :: factorize
      procedure :: solve
      procedure :: multiply
      procedure :: displacement
      procedure :: round_off
   end type saddle_point_t

contains

   !> Lays out the matrix and the workspace, where the sizes, the coupling and the projector are there; nothing is allocated
   !! afterwards.
   subroutine lay_out(self)
      !> The matrix.
      class(saddle_point_t), intent(inout) :: self
      integer, allocatable :: col(:), row(:)
      integer :: i, j, l, nnz, p

      nnz = size(self%coupling%column)
      allocate (self%k(nnz), self%d(nnz), self%mass(nnz), self%soft_k(nnz), self%soft_d(nnz), source=0.0_wp)
      allocate (self%f_w(self%n_v, self%n_w), self%g_x(self%n_w, self%n_v), self%g_v(self%n_w, self%n_v), &
                self%g_w(self%n_w, self%n_w), source=0.0_wp)
      allocate (self%f_lambda(size(self%projector%linear%a%values)), source=0.0_wp)
      allocate (self%kept(self%c), source=.true.)
      allocate (self%strain(self%n_e), self%part_x(self%n_x), self%part_v(self%n_v), self%part_c(self%c), self%part_e(self%n_e), &
                self%other_x(self%n_x), self%other_v(self%n_v), self%other_c(self%c), self%other_e(self%n_e), self%mu(self%c), &
                source=0.0_wp)
      allocate (self%u(self%n_v), self%along(self%n_v), self%across(self%n_x), self%wanted(self%c), source=(0.0_wp, 0.0_wp))
      self%damped = any(self%tau > 0.0_wp)

      ! The saddle-point matrix, unknowns dx, dw, dlambda: the order of the entries is that of `fill`.
      p = nnz + (2*self%n_v + self%n_w)*self%n_w
      do i = 1, self%c
         p = p + 2*entries_of_row(self%projector%linear%a, i) + 1
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
         do j = 1, entries_of_row(self%projector%linear%a, i)
            row(p + 1:p + 2) = [l + i, column_of(self%projector%linear%a, i, j)]
            col(p + 1:p + 2) = [column_of(self%projector%linear%a, i, j), l + i]
            p = p + 2
         end do
         p = p + 1
         row(p) = l + i
         col(p) = l + i
      end do
      call choose_lu(l + self%c, row, col, self%lu)
      allocate (self%real_values(size(row)), self%real_x(l + self%c), source=0.0_wp)
      allocate (self%complex_values(size(row)), self%unknown(l + self%c), source=(0.0_wp, 0.0_wp))
   end subroutine lay_out

   !> Number of entries of a row.
   pure integer function entries_of_row(a, i)
      !> The matrix.
      type(csr_t), intent(in) :: a
      !> The row.
      integer, intent(in) :: i

      if (a%full) then
         entries_of_row = a%n
      else
         entries_of_row = a%first(i + 1) - a%first(i)
      end if
   end function entries_of_row

   !> Column of the j-th entry of a row.
   pure integer function column_of(a, i, j)
      !> The matrix.
      type(csr_t), intent(in) :: a
      !> The row.
      integer, intent(in) :: i
      !> Which of its entries.
      integer, intent(in) :: j

      if (a%full) then
         column_of = j
      else
         column_of = a%column(a%first(i) + j - 1)
      end if
   end function column_of

   !> Where the j-th entry of a row is.
   pure integer function place_of(a, i, j)
      !> The matrix.
      type(csr_t), intent(in) :: a
      !> The row.
      integer, intent(in) :: i
      !> Which of its entries.
      integer, intent(in) :: j

      if (a%full) then
         place_of = (i - 1)*a%n + j
      else
         place_of = a%first(i) + j - 1
      end if
   end function place_of

   !> M in the pattern of the coupling.
   subroutine entries_of_mass(self)
      !> The matrix, with M in `m_here`.
      class(saddle_point_t), intent(inout) :: self
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

   !> K and D: B^T k B, and with the time constants of the damping, besides what was found by differences.
   subroutine assemble(self)
      !> The matrix, with B in `b_here`.
      class(saddle_point_t), intent(inout) :: self

      self%k(:) = self%soft_k
      self%d(:) = self%soft_d
      if (self%n_e > 0) &
         call self%coupling%add_elastic(self%b_here, self%stiffness, self%b_here, self%k, self%tau, self%d)
   end subroutine assemble

   !> The saddle-point matrix of the second step, factorized.
   subroutine factorize(self, ode, slot, shift, info)
      !> The form, linearized.
      class(saddle_point_t), intent(inout) :: self
      !> Not asked.
      class(ode_system_t), intent(inout) :: ode
      !> 1 for a shift without an imaginary part, 2 for one with.
      integer, intent(in) :: slot
      !> What d/dt is replaced by, s [1/s].
      complex(wp), intent(in) :: shift
      !> `rhs_ok`; `rhs_retry` for a singular matrix: see `singular_at`; `rhs_cannot` for one that is too large.
      integer, intent(out) :: info

      self%shift(slot) = shift
      call fill(self, shift)
      if (slot == 1) then
         self%real_values(:) = real(self%complex_values, wp)
         call self%lu%factorize(self%real_values, info)
      else
         call self%lu%factorize(self%complex_values, info)
      end if
      call judge(self, info)
      associate (unused_system => ode)
      end associate
   end subroutine factorize

   !> Where a matrix was singular.
   pure subroutine judge(self, info)
      class(saddle_point_t), intent(inout) :: self
      integer, intent(inout) :: info

      self%singular_at = max(info, 0)
      if (info > self%n_v) self%singular_at = min(0, self%n_v + self%n_w - info)
      self%too_large = info == lu_too_large
      info = merge(rhs_ok, merge(rhs_cannot, rhs_retry, self%too_large), info == 0)
   end subroutine judge

   !> The entries of the saddle-point matrix, in the order of `init`.
   pure subroutine fill(self, s)
      class(saddle_point_t), intent(inout) :: self
      complex(wp), intent(in) :: s
      integer :: i, j, k, p

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
      associate (a => self%projector%linear%a)
         do i = 1, self%c
            do j = 1, entries_of_row(a, i)
               k = place_of(a, i, j)
               self%complex_values(p + 1:p + 2) = (0.0_wp, 0.0_wp)
               if (self%kept(i)) self%complex_values(p + 1:p + 2) = [a%values(k), a%values(k) - self%f_lambda(k)]
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
      class(saddle_point_t), intent(inout) :: self
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
      associate (x => self%unknown, a => self%projector%linear%a)
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
            call self%lu%solve(x)
         else
            self%real_x(:) = real(x, wp)
            call self%lu%solve(self%real_x)
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
      class(saddle_point_t), intent(inout) :: self
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
      class(saddle_point_t), intent(inout) :: self
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
      class(saddle_point_t), intent(inout) :: self
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
         product = product + a%values(place_of(a, i, j))*x(column_of(a, i, j))
      end do
   end function row_times

   !> The elastic forces of a misfit of sigma, -B^T r, on the right-hand side.
   subroutine add_elastic_force(self, r)
      class(saddle_point_t), intent(inout) :: self
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
      class(saddle_point_t), intent(inout) :: self
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
      class(saddle_point_t), intent(in) :: self
      !> Displacement: (velocities).
      real(wp), intent(out), contiguous :: d(:)

      d(:) = self%real_x(:self%n_v)
   end subroutine displacement

   !> What d/dt stands before: {xdot; M vdot; wdot} at the linearization.
   pure subroutine multiply(self, q, r)
      !> The form, linearized.
      class(saddle_point_t), intent(in) :: self
      !> A derivative of y: (n).
      real(wp), intent(in), contiguous :: q(:)
      !> Its product; zeros beyond n: (n + n_z).
      real(wp), intent(out), contiguous :: r(:)

      r(:self%n) = q
      call self%m_here%multiply(q(self%n_x + 1:self%n_x + self%n_v), r(self%n_x + 1:self%n_x + self%n_v))
      r(self%n + 1:) = 0.0_wp
   end subroutine multiply

   !> What round-off may leave of the equations: of phi, what the coordinates are worth; of the others, that of the terms which make
   !! them up, in the matrices of the linearization. mu vanishes.
   subroutine round_off(self, y, ydot, z, r)
      !> The form, linearized.
      class(saddle_point_t), intent(inout) :: self
      !> State {x; v; w}: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Its derivative: (n).
      real(wp), intent(in), contiguous :: ydot(:)
      !> {lambda; mu; sigma}: (n_z).
      real(wp), intent(in), contiguous :: z(:)
      !> Its size: (n + n_z).
      real(wp), intent(out), contiguous :: r(:)
      real(wp), parameter :: last_place = epsilon(1.0_wp)
      integer :: i, j, l

      associate (n => self%n_v, n_x => self%n_x, n_y => self%n, c => self%c, x => y(:self%n_x), &
                 v => y(self%n_x + 1:self%n_x + self%n_v), a => self%projector%linear%a)
         r(:n_x) = last_place*abs(ydot(:n_x))
         associate (of_v => r(n_x + 1:n_x + n), vdot => ydot(n_x + 1:n_x + n), of_c => r(n_y + c + 1:n_y + 2*c), &
                    of_e => r(n_y + 2*c + 1:))
            do i = 1, n
               of_v(i) = 0.0_wp
               do l = self%coupling%first(i), self%coupling%first(i + 1) - 1
                  j = self%coupling%column(l)
                  of_v(i) = of_v(i) + last_place*(abs(self%mass(l)*vdot(j)) + abs(self%soft_d(l)*v(j)))
               end do
            end do
            do i = 1, self%n_w
               r(n_x + n + i) = last_place*abs(ydot(n_x + n + i))
               do j = 1, n
                  r(n_x + n + i) = r(n_x + n + i) + last_place*abs(self%g_v(i, j)*v(j))
               end do
            end do
            call self%projector%newton%yardstick%round_off(x, r(n_y + 1:n_y + self%n_phi))
            r(n_y + self%n_phi + 1:n_y + c) = 0.0_wp
            do i = 1, c
               of_c(i) = 0.0_wp
               do l = 1, entries_of_row(a, i)
                  j = column_of(a, i, l)
                  of_c(i) = of_c(i) + last_place*abs(a%values(place_of(a, i, l))*v(j))
                  of_v(j) = of_v(j) + last_place*abs(a%values(place_of(a, i, l))*z(i))
               end do
            end do
            do i = 1, self%n_e
               of_e(i) = last_place*abs(z(2*c + i))
               do l = self%b_here%first(i), self%b_here%first(i + 1) - 1
                  j = self%b_here%column(l)
                  of_v(j) = of_v(j) + last_place*abs(self%b_here%values(l)*z(2*c + i))
               end do
            end do
         end associate
      end associate
   end subroutine round_off

end module taut_constrained_saddle_point
