!> Small free vibrations about a configuration at rest: M ddot d + K d = 0, A d = 0.
!!
!! K is the tangent of f - A^T lambda. Where the configuration carries no load, or loads and internal forces have a potential,
!! it is symmetric; otherwise it may not be, and eigenvalues may be complex. Forces that depend on velocities are left
!! out.
module taut_constrained_modes
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_constrained_tangent, only: free_velocities, ready, tangent
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_lapack, only: dgeev, dpotrf, dsygv, dtrtrs
   use taut_linalg_null_space, only: null_space
   implicit none (type, external)
   private
   public :: eigenmodes, modes_t, modes_options_t

   !> What is asked for.
   type :: modes_options_t
      !> Velocities that stay zero; none by default.
      integer, allocatable :: blocked(:)
      !> Whether the constraints hold; otherwise the system is taken without them.
      logical :: constrained = .true.
      !> Differences between K and its transpose, relative to sqrt(K_ii K_jj), up to which K counts as symmetric.
      real(wp) :: symmetry_tolerance = 1.0e-6_wp
      !> Relative step of the differences; 0 for the default.
      real(wp) :: difference = 0.0_wp
   end type modes_options_t

   !> Modes in order of increasing frequency. With the eigenvalue mu = (omega)^2, sqrt(mu) = omega + i growth.
   type :: modes_t
      !> Frequencies [Hz].
      real(wp), allocatable :: frequency(:)
      !> Rates of exponential growth [1/s]: zero for a vibration, not for an instability (buckling: at frequency zero).
      real(wp), allocatable :: growth(:)
      !> Shapes: displacements along the velocities, unit modal mass, the largest entry positive; the real part of complex
      !! ones. (n, modes).
      real(wp), allocatable :: shapes(:, :)
      !> Whether K was symmetric.
      logical :: symmetric = .true.
      !> The largest difference between K and its transpose, as `symmetry_tolerance`.
      real(wp) :: asymmetry = 0.0_wp
   end type modes_t

   character(*), parameter :: here = 'modes'
   real(wp), parameter :: pi = acos(-1.0_wp)

contains

   !> All modes about a configuration.
   subroutine eigenmodes(model, at, modes, error, options)
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Where: an equilibrium, or what counts as one; velocities are not used.
      type(state_t), intent(in) :: at
      !> The modes.
      type(modes_t), intent(out) :: modes
      !> What went wrong.
      type(error_t), allocatable, intent(inout) :: error
      !> Options.
      type(modes_options_t), intent(in), optional :: options
      type(modes_options_t) :: chosen
      type(state_t) :: rest
      type(block_diagonal_t) :: m
      integer, allocatable :: free(:)
      real(wp), allocatable :: a_plus(:, :), k(:, :), k_free(:, :), m_free(:, :), m_full(:, :), z(:, :)
      real(wp) :: a(model%c, model%n), f(model%n), lambda(model%c)
      integer :: i, info, rank

      if (present(options)) chosen = options
      rest = at
      call ready(model, rest, here, error)
      if (.not. allocated(error)) call free_velocities(model%n, chosen%blocked, free, error)
      if (allocated(error)) return
      call model%normalize(rest%x)

      lambda = 0.0_wp
      call model%force(rest, f)
      call model%jacobian(rest, a)
      if (.not. (all(ieee_is_finite(f)) .and. all(ieee_is_finite(a)))) then
         call raise(error, here, 'a force or a constraint is not finite', 'correct the system or its configuration')
         return
      end if
      if (chosen%constrained .and. model%c > 0) then
         call null_space(a(:, free), z, a_plus, rank, info)
         if (info /= 0) then
            call raise(error, here, 'the constraints could not be analyzed', 'correct the constraint matrix')
            return
         end if
         lambda = matmul(f(free), a_plus)
         if (rank == size(free)) call raise(error, here, 'the constraints leave nothing free', 'remove some')
         if (allocated(error)) return
      else
         allocate (z(size(free), size(free)), source=0.0_wp)
         do i = 1, size(free)
            z(i, i) = 1.0_wp
         end do
      end if

      allocate (k(size(free), size(free)), source=0.0_wp)
      call tangent(model, rest, lambda, free, chosen%difference, k)
      if (.not. all(ieee_is_finite(k))) then
         call raise(error, here, 'the tangent stiffness is not finite', 'correct the system or its configuration')
         return
      end if
      call m%init(model%mass_blocks)
      call model%mass(rest, m)
      m_full = m%dense()
      k_free = matmul(transpose(z), matmul(k, z))
      m_free = matmul(transpose(z), matmul(m_full(free, free), z))
      modes%asymmetry = asymmetry(k_free)
      modes%symmetric = modes%asymmetry <= chosen%symmetry_tolerance
      if (modes%symmetric) then
         call solve_symmetric(k_free, m_free, modes, info)
      else
         call solve_general(k_free, m_free, modes, info)
      end if
      if (info > 0) then
         call raise(error, here, 'the mass matrix is not positive definite', 'give every free velocity a mass')
      else if (info < 0) then
         call raise(error, here, 'the eigenvalues were not found', 'correct the system')
      end if
      if (allocated(error)) return
      call complete(free, z, model%n, modes)
   end subroutine eigenmodes

   !> The largest |K_ij - K_ji|/sqrt(|K_ii K_jj|).
   pure function asymmetry(k) result(value)
      real(wp), intent(in) :: k(:, :)
      real(wp) :: value
      real(wp) :: scale(size(k, 1))
      integer :: i, j

      do i = 1, size(k, 1)
         scale(i) = sqrt(max(abs(k(i, i)), 1.0e-10_wp*maxval(abs(k)), tiny(1.0_wp)))
      end do
      value = 0.0_wp
      do j = 1, size(k, 1)
         do i = j + 1, size(k, 1)
            value = max(value, abs(k(i, j) - k(j, i))/(scale(i)*scale(j)))
         end do
      end do
   end function asymmetry

   !> K and M symmetric: DSYGV. info > 0: M is not positive definite; < 0: no convergence.
   subroutine solve_symmetric(k, m, modes, info)
      real(wp), intent(inout) :: k(:, :), m(:, :)
      type(modes_t), intent(inout) :: modes
      integer, intent(out) :: info
      real(wp), allocatable :: mu(:), work(:)
      integer :: n

      n = size(k, 1)
      k = 0.5_wp*(k + transpose(k))
      allocate (mu(n), work(max(1, 34*n)), source=0.0_wp)
      call dsygv(1, 'V', 'L', n, k, n, m, n, mu, work, size(work), info)
      if (info /= 0) then
         info = merge(1, -1, info > n)
         return
      end if
      allocate (modes%frequency, source=sqrt(max(mu, 0.0_wp))/(2.0_wp*pi))
      allocate (modes%growth, source=sqrt(max(-mu, 0.0_wp)))
      allocate (modes%shapes, source=k)
   end subroutine solve_symmetric

   !> K not symmetric: DGEEV of L^-1 K L^-T, M = L L^T, which keeps the eigenvalues of M^-1 K.
   subroutine solve_general(k, m, modes, info)
      real(wp), intent(inout) :: k(:, :), m(:, :)
      type(modes_t), intent(inout) :: modes
      integer, intent(out) :: info
      real(wp), allocatable :: im(:), left(:, :), re(:), right(:, :), transposed(:, :), work(:)
      complex(wp), allocatable :: omega(:)
      integer, allocatable :: order(:)
      integer :: i, n

      n = size(k, 1)
      call dpotrf('L', n, m, n, info)
      if (info /= 0) then
         info = 1
         return
      end if
      call dtrtrs('L', 'N', 'N', n, n, m, n, k, n, info)
      transposed = transpose(k)
      call dtrtrs('L', 'N', 'N', n, n, m, n, transposed, n, info)
      k = transpose(transposed)
      allocate (re(n), im(n), left(1, 1), right(n, n), work(max(1, 8*n)), source=0.0_wp)
      call dgeev('N', 'V', n, k, n, re, im, left, 1, right, n, work, size(work), info)
      if (info /= 0) then
         info = -1
         return
      end if
      ! LAPACK stores a pair as the real and the imaginary part of one vector; both members have that real part.
      do i = 2, n
         if (im(i) < 0.0_wp) right(:, i) = right(:, i - 1)
      end do
      call dtrtrs('L', 'T', 'N', n, n, m, n, right, n, info)
      omega = sqrt(cmplx(re, im, wp))
      order = increasing(real(omega, wp), abs(aimag(omega)))
      allocate (modes%frequency, source=real(omega(order), wp)/(2.0_wp*pi))
      allocate (modes%growth, source=abs(aimag(omega(order))))
      allocate (modes%shapes, source=right(:, order))
   end subroutine solve_general

   !> The order of increasing frequencies, the fastest growth first among equals.
   pure function increasing(frequency, growth) result(order)
      real(wp), intent(in) :: frequency(:), growth(:)
      integer, allocatable :: order(:)
      integer :: i, j, one

      order = [(i, i=1, size(frequency))]
      do i = 2, size(order)
         one = order(i)
         do j = i - 1, 1, -1
            if (frequency(order(j)) < frequency(one)) exit
            if (.not. frequency(order(j)) > frequency(one) .and. growth(order(j)) >= growth(one)) exit
            order(j + 1) = order(j)
         end do
         order(j + 1) = one
      end do
   end function increasing

   !> Shapes in all velocities, with signs and sizes settled.
   subroutine complete(free, z, n, modes)
      integer, intent(in) :: free(:), n
      real(wp), intent(in) :: z(:, :)
      type(modes_t), intent(inout) :: modes
      real(wp), allocatable :: reduced(:, :)
      integer :: i, j

      call move_alloc(modes%shapes, reduced)
      allocate (modes%shapes(n, size(reduced, 2)), source=0.0_wp)
      do j = 1, size(reduced, 2)
         modes%shapes(free, j) = matmul(z, reduced(:, j))
         i = maxloc(abs(modes%shapes(:, j)), 1)
         if (modes%shapes(i, j) < 0.0_wp) modes%shapes(:, j) = -modes%shapes(:, j)
      end do
   end subroutine complete

end module taut_constrained_modes
