!> Equilibrium of large systems: factors of the saddle-point matrix [K, A^T; A, 0], and of what gives way most by inverse iteration
!! with them.
!!
!! What resists is decided as with full matrices, of the motions that resist least alone: as many are looked at as it takes to find
!! some among them that do resist. Velocities along which there is no stiffness whatever and which no constraint sees, such as those
!! across a slack cable, are told beforehand.
module taut_constrained_rest_sparse
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_kinds, only: wp
   use taut_constrained_linearization, only: linearization_t
   use taut_constrained_method_options, only: method_t
   use taut_constrained_resistance, only: beyond_doubt, is_loaded, part_weak, round_off, stiffness_t
   use taut_constrained_rest, only: rest_failed, rest_loaded, rest_not_finite, rest_ok, rest_solver_t
   use taut_constrained_rest_bordered, only: bordered_t
   use taut_constrained_saddle_point, only: column_of, entries_of_row, place_of
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_linalg_csr, only: csr_t
   use taut_linalg_lapack, only: dgeqp3, dorgqr
   use taut_ode_system, only: rhs_ok
   implicit none (type, external)
   private
   public :: sparse_rest_t, along

   !> What is added to a diagonal of ones, so that no motion without stiffness makes the matrix singular; a cantilever of 512
   !! elements has a least stiffness a hundred times as large. Solutions are refined.
   real(wp), parameter :: shift = 1.0e-13_wp
   !> Steps of the inverse iteration, and motions that it begins with.
   integer, parameter :: inverse_steps = 4, first_motions = 8
   !> Refinements of a solution: as many at most, and where they end.
   integer, parameter :: most_refinements = 20
   real(wp), parameter :: refined = 1.0e-8_wp
   !> Above this part of the entries that are largest, K is not symmetric.
   real(wp), parameter :: asymmetric = 1.0e-6_wp

   !> Factors of the saddle-point matrix.
   type, extends(rest_solver_t) :: sparse_rest_t
      !> A, and A A^T.
      type(linearization_t) :: linear
      logical, allocatable :: kept(:)
      !> The saddle-point matrix: of velocities that are free and resisted, or seen by a constraint.
      type(bordered_t) :: bordered
      !> K with rows and columns scaled alike.
      type(csr_t), private :: k
   contains
      procedure :: init
      procedure :: look
      procedure :: reactions
      procedure :: sizes_of_reactions
      procedure :: balanced
      procedure :: meet
      procedure :: step
   end type sparse_rest_t

contains

   !> Lays everything out.
   subroutine init(self, model, free)
      !> The solver.
      class(sparse_rest_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Velocities that are not blocked.
      integer, intent(in) :: free(:)

      self%free = free
      allocate (self%is_free(model%n), source=.false.)
      self%is_free(free) = .true.
      call self%tangent%init(model)
      if (model%c > 0) call self%linear%init(model, method_t(weight='identity'), held=.not. self%is_free)
      self%k = self%tangent%k
      call self%bordered%init(self%k, model%c, self%linear%a)
      allocate (self%kept(model%c), source=.true.)
   end subroutine init

   !> A at a state, and its rank.
   subroutine look(self, model, at, info)
      !> The solver, laid out.
      class(sparse_rest_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Its state, at rest.
      type(state_t), intent(in) :: at
      !> `rest_ok`, `rest_not_finite` or `rest_failed`.
      integer, intent(out) :: info

      info = rest_ok
      if (model%c == 0) return
      call self%linear%release()
      call self%linear%linearize(model, at, info, 0.0_wp)
      info = merge(rest_ok, rest_not_finite, info == rhs_ok)
      if (info /= rest_ok) return
      call self%linear%kept_rows(self%kept)
      self%rank = count(self%kept)
   end subroutine look

   !> Multipliers of minimum norm that leave least of the forces, and what they leave.
   subroutine reactions(self, f, lambda, left)
      !> The solver, which has looked at the state.
      class(sparse_rest_t), intent(inout) :: self
      !> Forces: (n).
      real(wp), intent(in), contiguous :: f(:)
      !> Multipliers: (c).
      real(wp), intent(out), contiguous :: lambda(:)
      !> f - A^T lambda; zero along blocked velocities: (n).
      real(wp), intent(out), contiguous :: left(:)
      real(wp) :: nothing(size(lambda)), r(size(lambda))

      left = merge(f, 0.0_wp, self%is_free)
      if (size(lambda) == 0) return
      nothing = 0.0_wp
      call self%linear%onto%project(self%linear%a, nothing, left, r, lambda)
      call self%linear%onto%minimum_norm(lambda)
   end subroutine reactions

   !> The sizes of the terms of A^T lambda, added up.
   subroutine sizes_of_reactions(self, lambda, sizes)
      !> The solver, which has looked at the state.
      class(sparse_rest_t), intent(in) :: self
      !> Multipliers: (c).
      real(wp), intent(in) :: lambda(:)
      !> |A^T| |lambda|: (n).
      real(wp), intent(out) :: sizes(:)
      integer :: i, j, k

      sizes = 0.0_wp
      do i = 1, size(lambda)
         do j = 1, entries_of_row(self%linear%a, i)
            k = column_of(self%linear%a, i, j)
            sizes(k) = sizes(k) + abs(lambda(i)*self%linear%a%values(place_of(self%linear%a, i, j)))
         end do
      end do
   end subroutine sizes_of_reactions

   !> Whether forces along the motions that the constraints leave are no more than what they are worth.
   function balanced(self, left, uncertain)
      !> The solver, which has looked at the state.
      class(sparse_rest_t), intent(in) :: self
      !> The forces: (n).
      real(wp), intent(in) :: left(:)
      !> What they are worth: (n).
      real(wp), intent(in) :: uncertain(:)
      !> The answer.
      logical :: balanced

      balanced = all(abs(left(self%free)) <= uncertain(self%free))
   end function balanced

   !> d = -A^+ phi, and what it leaves of phi.
   subroutine meet(self, phi, d, left)
      !> The solver, which has looked at the state.
      class(sparse_rest_t), intent(inout) :: self
      !> Violation: (c).
      real(wp), intent(in), contiguous :: phi(:)
      !> Displacement: (n).
      real(wp), intent(out), contiguous :: d(:)
      !> A d + phi: (c).
      real(wp), intent(out), contiguous :: left(:)
      real(wp) :: lambda(size(phi))

      d = 0.0_wp
      if (size(phi) == 0) return
      left = -phi
      call self%linear%onto%project(self%linear%a, -phi, d, left, lambda)
      call self%linear%a%multiply(d, left, -phi)
   end subroutine meet

   !> Newton's step: K d = f along the motions that the constraints leave.
   subroutine step(self, model, at, lambda, difference, f, uncertain, d, info)
      !> The solver, which has looked at the state.
      class(sparse_rest_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Its state, at rest.
      type(state_t), intent(in) :: at
      !> Multipliers: (c).
      real(wp), intent(in) :: lambda(:)
      !> Relative step of the differences; 0 for the default.
      real(wp), intent(in) :: difference
      !> Forces that are left: (n).
      real(wp), intent(in) :: f(:)
      !> How much of each is not to be relied on: (n).
      real(wp), intent(in) :: uncertain(:)
      !> The displacement that meets the constraints, to which the step is added: (n).
      real(wp), intent(inout) :: d(:)
      !> One of the constants.
      integer, intent(out) :: info
      real(wp) :: load(model%n), y(model%n)
      real(wp), allocatable :: p(:, :), q(:, :)
      integer :: i, j

      self%free_motions = 0
      call self%tangent%find(model, at, lambda, difference)
      call self%tangent%find_errors(model, at, lambda, difference)
      info = rest_not_finite
      if (.not. (all(ieee_is_finite(self%tangent%k%values)) .and. all(ieee_is_finite(self%tangent%errors)))) return
      call self%tangent%k%multiply(d, load)
      load = f - load
      call scale_alike(self)
      if (count(self%bordered%moves) == self%rank) then
         call unresisted_alone()
         return
      end if
      call weak_motions(self, p, q, info)
      if (info /= rest_ok) return
      call unresisted_alone()
      if (info /= rest_ok) return
      load = merge(self%bordered%scale*load, 0.0_wp, self%bordered%moves)
      self%free_motions = self%free_motions + size(q, 2)
      do i = 1, size(q, 2)
         if (is_loaded(p(:, i), load, merge(self%bordered%scale*uncertain, 0.0_wp, self%bordered%moves))) then
            info = rest_loaded
            self%loaded = maxloc(abs(self%bordered%scale*q(:, i)), 1)
            return
         end if
      end do
      call solve_refined(self, p, q, load, y)
      y = self%bordered%scale*y
      ! What is least in scaled columns is not without such motions.
      do i = 1, size(q, 2)
         q(:, i) = self%bordered%scale*q(:, i)
         do j = 1, i - 1
            q(:, i) = q(:, i) - dot_product(q(:, j), q(:, i))*q(:, j)
         end do
         q(:, i) = q(:, i)/norm2(q(:, i))
         y = y - dot_product(q(:, i), y)*q(:, i)
      end do
      d = d + y

   contains

      !> Velocities that nothing resists, each by itself.
      subroutine unresisted_alone()
         real(wp) :: largest

         info = rest_ok
         self%free_motions = count(self%is_free .and. .not. self%bordered%moves)
         if (self%free_motions == 0) return
         largest = maxval(abs(load), self%is_free)
         do i = 1, model%n
            if (self%bordered%moves(i) .or. .not. self%is_free(i)) cycle
            if (abs(load(i)) <= 1.0e-3_wp*largest + uncertain(i)) cycle
            info = rest_loaded
            self%loaded = i
         end do
      end subroutine unresisted_alone

   end subroutine step

   !> Scales K with one factor for each row and its column, such that their largest entries are about one; what is nothing but noise
   !! is not made as large as the rest.
   subroutine scale_alike(self)
      type(sparse_rest_t), intent(inout) :: self
      real(wp) :: floor(self%k%n), largest, noise
      integer :: i, l, sweep
      logical :: seen(self%k%n)

      ! Which velocities are resisted, or seen by a constraint.
      seen = .false.
      do i = 1, size(self%kept)
         do l = 1, entries_of_row(self%linear%a, i)
            if (abs(self%linear%a%values(place_of(self%linear%a, i, l))) > 0.0_wp) seen(column_of(self%linear%a, i, l)) = .true.
         end do
      end do
      floor = 0.0_wp
      associate (k => self%tangent%k, errors => self%tangent%errors, moves => self%bordered%moves, scale => self%bordered%scale)
         do i = 1, k%n
            do l = k%first(i), k%first(i + 1) - 1
               noise = maxval(abs(errors(l, :)))
               floor(i) = max(floor(i), 1.0e4_wp*noise)
               if (abs(k%values(l)) > beyond_doubt*noise) then
                  seen(i) = .true.
                  seen(k%column(l)) = .true.
               end if
            end do
         end do
         moves = self%is_free .and. seen
         scale = 1.0_wp
         do sweep = 1, 4
            do i = 1, k%n
               largest = floor(i)*scale(i)**2
               do l = k%first(i), k%first(i + 1) - 1
                  if (moves(k%column(l))) largest = max(largest, abs(k%values(l))*scale(i)*scale(k%column(l)))
               end do
               if (moves(i) .and. largest > 1.0e-100_wp) scale(i) = scale(i)/sqrt(largest)
            end do
         end do
         do i = 1, k%n
            do l = k%first(i), k%first(i + 1) - 1
               self%k%values(l) = 0.0_wp
               if (moves(i) .and. moves(k%column(l))) &
                  self%k%values(l) = scale(i)*k%values(l)*scale(k%column(l))
            end do
         end do
      end associate
   end subroutine scale_alike

   !> The scaled saddle-point matrix, or its transpose, factorized.
   subroutine factorize(self, transposed, info)
      type(sparse_rest_t), intent(inout) :: self
      logical, intent(in) :: transposed
      integer, intent(out) :: info
      real(wp) :: values(size(self%k%values))
      integer :: i, l

      values = self%k%values
      if (transposed) then
         do i = 1, self%k%n
            do l = self%k%first(i), self%k%first(i + 1) - 1
               values(self%tangent%coupling%place(self%k%column(l), i)) = self%k%values(l)
            end do
         end do
      end if
      call self%bordered%factorize(values, shift, self%linear%a, self%kept, info)
      info = merge(rest_ok, rest_failed, info == 0)
   end subroutine factorize

   !> The motions q that nothing resists, and the forces p that none of the others makes: orthonormal, scaled. The factors are those
   !! of K on return.
   subroutine weak_motions(self, p, q, info)
      type(sparse_rest_t), intent(inout) :: self
      real(wp), allocatable, intent(out) :: p(:, :), q(:, :)
      integer, intent(out) :: info
      type(csr_t) :: other
      type(stiffness_t) :: small
      real(wp), allocatable :: u(:, :), v(:, :), x(:, :), y(:, :)
      integer, allocatable :: weak(:)
      integer :: all_motions, i, l, m, sample
      logical :: symmetric

      all_motions = count(self%bordered%moves) - self%rank
      symmetric = .true.
      do i = 1, self%k%n
         do l = self%k%first(i), self%k%first(i + 1) - 1
            symmetric = symmetric .and. abs(self%k%values(l) - &
                                            self%k%values(self%tangent%coupling%place(self%k%column(l), i))) <= asymmetric
         end do
      end do
      m = min(first_motions, all_motions)
      other = self%k
      do
         if (.not. symmetric) then
            call factorize(self, .true., info)
            if (info /= rest_ok) return
            call inverse_iteration(self, m, y, info)
            if (info /= rest_ok) return
         end if
         call factorize(self, .false., info)
         if (info /= rest_ok) return
         call inverse_iteration(self, m, x, info)
         if (info /= rest_ok) return
         if (symmetric) y = x
         small%k = along(self%k, y, x)
         other%values = abs(self%k%values)
         small%sizes = along(other, abs(y), abs(x))
         if (allocated(small%errors)) deallocate (small%errors)
         allocate (small%errors(m, m, size(self%tangent%errors, 2)))
         do sample = 1, size(self%tangent%errors, 2)
            do i = 1, self%k%n
               do l = self%k%first(i), self%k%first(i + 1) - 1
                  other%values(l) = 0.0_wp
                  if (self%bordered%moves(i) .and. self%bordered%moves(self%k%column(l))) &
                     other%values(l) = self%bordered%scale(i)*self%tangent%errors(l, sample)*self%bordered%scale(self%k%column(l))
               end do
            end do
            small%errors(:, :, sample) = along(other, y, x)
         end do
         call part_weak(small, u, v, weak, info)
         if (info /= 0) then
            info = rest_failed
            return
         end if
         if (m == all_motions .or. size(weak) <= m - 2) exit
         m = min(2*m, all_motions)
      end do
      p = matmul(y, u(:, weak))
      q = matmul(x, v(:, weak))
      info = rest_ok
   end subroutine weak_motions

   !> Y^T K X.
   function along(k, y, x) result(small)
      !> The matrix: (n, n).
      type(csr_t), intent(in) :: k
      !> Forces are weighed with these: (n, m).
      real(wp), intent(in) :: y(:, :)
      !> Motions: (n, m).
      real(wp), intent(in) :: x(:, :)
      !> The product: (m, m).
      real(wp) :: small(size(y, 2), size(x, 2))
      real(wp) :: image(size(x, 1))
      integer :: j

      do j = 1, size(x, 2)
         call k%multiply(x(:, j), image)
         small(:, j) = matmul(image, y)
      end do
   end function along

   !> Motions that resist least, orthonormal.
   subroutine inverse_iteration(self, m, x, info)
      type(sparse_rest_t), intent(inout) :: self
      integer, intent(in) :: m
      real(wp), allocatable, intent(out) :: x(:, :)
      integer, intent(out) :: info
      integer :: i, iteration, j, n, pivot(m)
      real(wp) :: tau(m)
      real(wp), allocatable :: work(:)

      n = self%k%n
      allocate (x(n, m), work(64*(m + 1)), source=0.0_wp)
      do j = 1, m
         ! Numbers without a pattern.
         x(:, j) = [(modulo(12345.6789_wp*sin(12.9898_wp*i + 78.233_wp*j), 1.0_wp) - 0.5_wp, i=1, n)]
      end do
      do iteration = 1, inverse_steps
         do j = 1, m
            call self%bordered%divide(x(:, j))
         end do
         if (.not. all(ieee_is_finite(x))) then
            info = rest_failed
            return
         end if
         pivot = 0
         call dgeqp3(n, m, x, n, pivot, tau, work, size(work), info)
         if (info == 0) call dorgqr(n, m, m, x, n, tau, work, size(work), info)
         if (info /= 0) then
            info = rest_failed
            return
         end if
      end do
      info = rest_ok
   end subroutine inverse_iteration

   !> y = K^-1 f in the motions that are resisted, all scaled.
   subroutine solve_refined(self, p, q, f, y)
      type(sparse_rest_t), intent(inout) :: self
      real(wp), intent(in) :: p(:, :), q(:, :), f(:)
      real(wp), intent(out) :: y(:)
      real(wp) :: image(size(y)), more(size(y))
      integer :: i

      y = 0.0_wp
      more = f
      do i = 1, most_refinements
         more = more - matmul(p, matmul(more, p))
         call self%bordered%divide(more)
         more = more - matmul(q, matmul(more, q))
         y = y + more
         if (norm2(more) <= refined*norm2(y)) exit
         call self%k%multiply(y, image)
         more = f - image
      end do
   end subroutine solve_refined

end module taut_constrained_rest_sparse
