!> Small free vibrations about a configuration at rest: M ddot d + C dot d + K d = 0, A d = 0.
!!
!! K is the tangent of f - A^T lambda. Where the configuration carries no load, or loads and internal forces have a potential,
!! it is symmetric; otherwise it may not be, and eigenvalues may be complex. Motions that nothing resists, such as that of a
!! trolley on its rail, are vibrations of 0 Hz. C is what forces that depend on velocities make at rest, such as dampers.
module taut_constrained_modes
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_constrained_modes_lowest, only: descend, krylov_space
   use taut_constrained_resistance, only: stiffness_t
   use taut_constrained_rest_choose, only: is_large
   use taut_constrained_rest_sparse, only: along, sparse_rest_t
   use taut_constrained_tangent, only: free_velocities, ready, tangent_t
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_csr, only: csr_t
   use taut_linalg_lapack, only: dgeev, dgeqp3, dgesvd, dorgqr, dpotrf, dsygv, dtrtrs
   use taut_linalg_null_space, only: null_space
   implicit none (type, external)
   private
   public :: eigenmodes, modes_t, modes_options_t

   !> What is asked for.
   type :: modes_options_t
      !> Velocities that stay zero; none by default.
      integer, allocatable :: blocked(:)
      !> Whether forces that depend on velocities count.
      logical :: damped = .true.
      !> Whether the constraints hold; otherwise the system is taken without them.
      logical :: constrained = .true.
      !> Differences between K and its transpose, relative to sqrt(K_ii K_jj), up to which K counts as symmetric.
      real(wp) :: symmetry_tolerance = 1.0e-6_wp
      !> Relative step of the differences; 0 for the default.
      real(wp) :: difference = 0.0_wp
      !> How many of the lowest modes are needed, those that nothing resists and those that grow always among them; 0 for all. Of a
      !! large system a few are had at a cost in proportion to its size; with damping, those of the smallest eigenvalues.
      integer :: number = 0
   end type modes_options_t

   !> Modes in order of increasing frequency: exp((growth + 2 pi i frequency) t).
   type :: modes_t
      !> Frequencies [Hz].
      real(wp), allocatable :: frequency(:)
      !> Rates of exponential growth [1/s]: zero for a vibration without damping, negative for one that dies away, positive for an
      !! instability (buckling: at frequency zero). Without damping, what is unstable is listed once, as it grows; with it, what
      !! does not vibrate has two rates.
      real(wp), allocatable :: growth(:)
      !> Shapes: displacements along the velocities, unit modal mass, the largest entry positive; the real part of complex
      !! ones. (n, modes).
      real(wp), allocatable :: shapes(:, :)
      !> Motions that nothing resists: so many modes have frequency and growth zero.
      integer :: free_motions = 0
      !> Whether forces that depend on velocities have a part in them.
      logical :: damped = .false.
      !> Whether K was symmetric.
      logical :: symmetric = .true.
      !> The largest difference between K and its transpose, as `symmetry_tolerance`.
      real(wp) :: asymmetry = 0.0_wp
      !> Whether all that may grow is among them. Of more than a thousand motions, damped or without symmetry, only the lowest are
      !! looked at, and all that grows without vibrating.
      logical :: complete = .true.
   end type modes_t

   !> So many motions take a few seconds with full matrices.
   integer, parameter :: still_dense = 1000

   character(*), parameter :: here = 'modes'
   real(wp), parameter :: pi = acos(-1.0_wp)

contains

   !> All modes about a configuration at rest, or at least those that are asked for.
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
      type(stiffness_t) :: stiffness
      type(tangent_t) :: tangent
      integer, allocatable :: free(:)
      real(wp), allocatable :: rates(:), a_plus(:, :), c(:, :), errors(:, :, :), k(:, :), m_free(:, :), m_full(:, :), z(:, :)
      real(wp) :: a(model%c, model%n), f(model%n), lambda(model%c)
      integer :: i, info, rank

      if (present(options)) chosen = options
      rest = at
      call ready(model, rest, here, error)
      if (.not. allocated(error)) call free_velocities(model%n, chosen%blocked, free, error)
      if (allocated(error)) return
      call model%normalize(rest%x)
      if (chosen%number > 0 .and. 4*chosen%number < size(free)) then
         if (is_large(model, free)) call solve_at_size(model, rest, free, chosen, modes, error)
         if (allocated(modes%frequency) .or. allocated(error)) return
      end if

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

      call tangent%init(model)
      call tangent%find(model, rest, lambda, chosen%difference)
      k = tangent%full(tangent%k%values, free)
      if (.not. all(ieee_is_finite(k))) then
         call raise(error, here, 'the tangent stiffness is not finite', 'correct the system or its configuration')
         return
      end if
      call tangent%find_errors(model, rest, lambda, chosen%difference)
      allocate (errors(size(free), size(free), size(tangent%errors, 2)))
      do i = 1, size(errors, 3)
         errors(:, :, i) = tangent%full(tangent%errors(:, i), free)
      end do
      call m%init(model%mass_blocks)
      call model%mass(rest, m)
      m_full = m%dense()
      call stiffness%project(z, k)
      call stiffness%project_errors(z, errors)
      m_free = matmul(transpose(z), matmul(m_full(free, free), z))
      modes%asymmetry = asymmetry(stiffness%k)
      modes%symmetric = modes%asymmetry <= chosen%symmetry_tolerance
      call solve(stiffness, m_free, modes, info)
      if (chosen%damped .and. info == 0) then
         allocate (rates(size(tangent%k%values)))
         call tangent%damping(model, rest, rates)
         c = tangent%full(rates, free)
         if (.not. all(ieee_is_finite(c))) then
            call raise(error, here, 'a force is not finite with velocities', 'correct the system or its configuration')
            return
         end if
         modes%damped = any(abs(c) > 0.0_wp)
         if (modes%damped) call solve_damped(stiffness%k, matmul(transpose(z), matmul(c, z)), m_free, modes, info)
      end if
      if (info > 0) then
         call raise(error, here, 'the mass matrix is not positive definite', 'give every free velocity a mass')
      else if (info < 0) then
         call raise(error, here, 'the eigenvalues were not found', 'correct the system')
      end if
      if (allocated(error)) return
      call complete(free, z, model%n, modes)
   end subroutine eigenmodes

   !> A few modes of a large system, in a space that grows until they do not change; none where its mass is singular, or where not
   !! all that may be unstable is among them and all of them can be had.
   subroutine solve_at_size(model, at, free, options, modes, error)
      class(mechanical_system_t), intent(in) :: model
      type(state_t), intent(in) :: at
      integer, intent(in) :: free(:)
      type(modes_options_t), intent(in) :: options
      type(modes_t), intent(inout) :: modes
      type(error_t), allocatable, intent(inout) :: error
      type(sparse_rest_t) :: rest
      type(block_diagonal_t) :: m
      type(modes_t) :: before, found
      real(wp) :: f(model%n), lambda(model%c), left(model%n), s
      real(wp), allocatable :: basis(:, :), c(:)
      integer :: all_motions, block, dimensions, info, wanted
      logical :: damped, symmetric

      if (model%c > 0 .and. .not. options%constrained) return
      call rest%init(model, free)
      call model%force(at, f)
      call rest%look(model, at, info)
      if (info /= 0 .or. .not. all(ieee_is_finite(f))) return
      all_motions = size(free) - rest%rank
      if (4*options%number >= all_motions) return
      call m%init(model%mass_blocks)
      call model%mass(at, m)
      call m%factorize(info)
      if (info /= 0) return
      allocate (c(size(rest%tangent%k%values)), source=0.0_wp)
      if (options%damped) call rest%tangent%damping(model, at, c)
      call rest%reactions(f, lambda, left)
      call rest%tangent%find(model, at, lambda, options%difference)
      call rest%tangent%find_errors(model, at, lambda, options%difference)
      if (.not. (all(ieee_is_finite(rest%tangent%k%values)) .and. all(ieee_is_finite(c)))) return
      damped = any(abs(c) > 0.0_wp)
      symmetric = rest%tangent%asymmetry(rest%is_free) <= options%symmetry_tolerance
      if ((damped .or. .not. symmetric) .and. all_motions <= still_dense) return

      call descend(rest, m, s, info)
      block = 8
      dimensions = 2*(options%number + block)
      allocate (before%frequency(0), before%growth(0))
      do while (info == 0)
         dimensions = min(dimensions, all_motions)
         call krylov_space(rest, m, c, s, dimensions, block, basis, info)
         if (info /= 0) exit
         call solve_in(basis, found, info)
         if (info /= 0) exit
         wanted = max(options%number, found%free_motions + count(found%growth > 0.0_wp) + 1)
         if (size(basis, 2) >= all_motions .or. settled(before, found, min(wanted, size(found%frequency)))) then
            if (size(basis, 2) >= all_motions .or. largest_group(found, wanted) < block) exit
            block = 2*block
         end if
         before = found
         dimensions = max(dimensions + 2*block, (3*dimensions)/2)
      end do
      if (info /= 0) then
         call raise(error, here, 'the eigenvalues were not found', 'correct the system')
         return
      end if
      wanted = min(wanted, size(found%frequency))
      call take(found, [(info, info=1, wanted)])
      call take(found, increasing(found%frequency, found%growth))
      modes = found
      modes%complete = symmetric .and. .not. damped
      call complete([(info, info=1, model%n)], basis, model%n, modes)

   contains

      !> The modes in a space.
      subroutine solve_in(basis, found, info)
         real(wp), intent(in) :: basis(:, :)
         type(modes_t), intent(out) :: found
         integer, intent(out) :: info
         type(stiffness_t) :: small
         type(csr_t) :: other
         real(wp), allocatable :: masses(:, :)
         real(wp) :: image(model%n)
         integer :: i

         other = rest%tangent%k
         small%k = along(other, basis, basis)
         other%values = abs(other%values)
         small%sizes = along(other, abs(basis), abs(basis))
         allocate (small%errors(size(basis, 2), size(basis, 2), size(rest%tangent%errors, 2)))
         do i = 1, size(rest%tangent%errors, 2)
            other%values = rest%tangent%errors(:, i)
            small%errors(:, :, i) = along(other, basis, basis)
         end do
         allocate (masses(size(basis, 2), size(basis, 2)), source=0.0_wp)
         do i = 1, size(basis, 2)
            call m%multiply(basis(:, i), image)
            masses(:, i) = matmul(image, basis)
         end do
         found%asymmetry = rest%tangent%asymmetry(rest%is_free)
         found%symmetric = symmetric
         found%damped = damped
         call solve(small, masses, found, info)
         if (info == 0 .and. damped) then
            other%values = c
            call solve_damped(small%k, along(other, basis, basis), masses, found, info)
         end if
         if (info /= 0) return
         ! The smallest eigenvalues first, after what grows; not those without frequency, of which damping makes many.
         call take(found, increasing(merge(0.0_wp, hypot(2.0_wp*pi*found%frequency, found%growth), found%growth > 0.0_wp), &
                                     found%growth))
      end subroutine solve_in

   end subroutine solve_at_size

   !> Takes some modes, in an order.
   subroutine take(modes, which)
      type(modes_t), intent(inout) :: modes
      integer, intent(in) :: which(:)
      real(wp), allocatable :: shapes(:, :)

      modes%frequency = modes%frequency(which)
      modes%growth = modes%growth(which)
      shapes = modes%shapes(:, which)
      call move_alloc(shapes, modes%shapes)
   end subroutine take

   !> Whether modes are those of a smaller space.
   pure logical function settled(before, found, wanted)
      type(modes_t), intent(in) :: before, found
      integer, intent(in) :: wanted

      settled = .false.
      if (min(size(before%frequency), size(found%frequency)) < wanted) return
      associate (f => found%frequency(:wanted), g => found%growth(:wanted))
         settled = all(hypot(2.0_wp*pi*(before%frequency(:wanted) - f), before%growth(:wanted) - g) <= &
                       1.0e-8_wp*hypot(2.0_wp*pi*f, g))
      end associate
   end function settled

   !> The largest number of modes that are equal.
   pure integer function largest_group(found, wanted) result(largest)
      type(modes_t), intent(in) :: found
      integer, intent(in) :: wanted
      integer :: i

      largest = 0
      associate (f => found%frequency, g => found%growth)
         do i = 1, wanted
            largest = max(largest, count(2.0_wp*pi*abs(f - f(i)) + abs(g - g(i)) <= 1.0e-6_wp*(2.0_wp*pi*f(i) + abs(g(i)))))
         end do
      end associate
   end function largest_group

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

   !> Without damping. info > 0: M is not positive definite; < 0: no convergence.
   subroutine solve(stiffness, m, modes, info)
      type(stiffness_t), intent(in) :: stiffness
      real(wp), intent(in) :: m(:, :)
      type(modes_t), intent(inout) :: modes
      integer, intent(out) :: info
      complex(wp), allocatable :: mu(:), omega(:)
      integer, allocatable :: order(:)
      real(wp), allocatable :: shapes(:, :)
      real(wp) :: left
      integer :: i

      if (modes%symmetric) then
         call solve_symmetric(stiffness%k, m, mu, shapes, info)
      else
         call solve_general(stiffness%k, m, mu, shapes, info)
      end if
      if (info /= 0) return
      do i = 1, size(mu)
         ! By Rayleigh's quotient, which the error of the shape does not touch; without symmetry it is no eigenvalue.
         associate (shape => shapes(:, i))
            left = abs(dot_product(shape, matmul(stiffness%k, shape)))
            if (.not. modes%symmetric) left = abs(mu(i)) - 10.0_wp*epsilon(left)*maxval(abs(mu))
            if (left > stiffness%worth(shape, shape)) cycle
         end associate
         mu(i) = (0.0_wp, 0.0_wp)
         modes%free_motions = modes%free_motions + 1
      end do
      omega = sqrt(mu)
      order = increasing(real(omega, wp), abs(aimag(omega)))
      modes%frequency = real(omega(order), wp)/(2.0_wp*pi)
      modes%growth = abs(aimag(omega(order)))
      modes%shapes = shapes(:, order)
   end subroutine solve

   !> K and M symmetric: DSYGV.
   subroutine solve_symmetric(k, m, mu, shapes, info)
      real(wp), intent(in) :: k(:, :), m(:, :)
      complex(wp), allocatable, intent(out) :: mu(:)
      real(wp), allocatable, intent(out) :: shapes(:, :)
      integer, intent(out) :: info
      real(wp), allocatable :: masses(:, :), values(:), work(:)
      integer :: n

      n = size(k, 1)
      allocate (shapes, source=0.5_wp*(k + transpose(k)))
      allocate (masses, source=m)
      allocate (values(n), work(max(1, 34*n)), source=0.0_wp)
      call dsygv(1, 'V', 'L', n, shapes, n, masses, n, values, work, size(work), info)
      if (info /= 0) info = merge(1, -1, info > n)
      mu = cmplx(values, 0.0_wp, wp)
   end subroutine solve_symmetric

   !> K not symmetric: DGEEV of L^-1 K L^-T, M = L L^T, which keeps the eigenvalues of M^-1 K. Shapes of unit modal mass.
   subroutine solve_general(k, m, mu, shapes, info)
      real(wp), intent(in) :: k(:, :), m(:, :)
      complex(wp), allocatable, intent(out) :: mu(:)
      real(wp), allocatable, intent(out) :: shapes(:, :)
      integer, intent(out) :: info
      real(wp), allocatable :: factor(:, :), im(:), left(:, :), re(:), scaled(:, :), work(:)
      integer :: i, n

      n = size(k, 1)
      call weigh(m, factor, info)
      if (info /= 0) return
      scaled = weighed(k, factor)
      allocate (re(n), im(n), left(1, 1), shapes(n, n), work(max(1, 8*n)), source=0.0_wp)
      call dgeev('N', 'V', n, scaled, n, re, im, left, 1, shapes, n, work, size(work), info)
      if (info /= 0) then
         info = -1
         return
      end if
      ! LAPACK stores a pair as the real and the imaginary part of one vector; both members have that real part.
      do i = 2, n
         if (im(i) < 0.0_wp) shapes(:, i) = shapes(:, i - 1)
      end do
      call dtrtrs('L', 'T', 'N', n, n, factor, n, shapes, n, info)
      mu = cmplx(re, im, wp)
   end subroutine solve_general

   !> M = L L^T. info = 1: M is not positive definite.
   subroutine weigh(m, factor, info)
      real(wp), intent(in) :: m(:, :)
      real(wp), allocatable, intent(out) :: factor(:, :)
      integer, intent(out) :: info

      allocate (factor, source=m)
      call dpotrf('L', size(m, 1), factor, size(m, 1), info)
      if (info /= 0) info = 1
   end subroutine weigh

   !> L^-1 K L^-T.
   function weighed(k, factor) result(scaled)
      real(wp), intent(in) :: k(:, :), factor(:, :)
      real(wp), allocatable :: scaled(:, :)
      integer :: info, n

      n = size(k, 1)
      scaled = k
      call dtrtrs('L', 'N', 'N', n, n, factor, n, scaled, n, info)
      scaled = transpose(scaled)
      call dtrtrs('L', 'N', 'N', n, n, factor, n, scaled, n, info)
      scaled = transpose(scaled)
   end function weighed

   !> With damping: eigenvalues of qdot = p, pdot = -K q - C p in coordinates of unit mass.
   !!
   !! The coordinates of motions that nothing resists have no part in it, only their rates, and of those that nothing damps not even
   !! these: each such motion would have one eigenvalue more that is zero, or two, which no solver finds as zeros.
   subroutine solve_damped(k, c, m, modes, info)
      real(wp), intent(in) :: k(:, :), c(:, :), m(:, :)
      type(modes_t), intent(inout) :: modes
      integer, intent(out) :: info
      complex(wp), allocatable :: lambda(:)
      complex(wp) :: q(size(k, 1)), p(size(k, 1))
      integer, allocatable :: order(:)
      real(wp), allocatable :: basis(:, :), damper(:, :), factor(:, :), im(:), left(:, :), matrix(:, :), re(:), right(:, :), &
                               shapes(:, :), spring(:, :), work(:)
      integer :: found, free, i, n, rest, states, undamped

      n = size(k, 1)
      free = modes%free_motions
      call weigh(m, factor, info)
      if (info /= 0) return
      damper = weighed(c, factor)
      call free_motions_first(modes, factor, damper, basis, undamped, info)
      if (info /= 0) return
      damper = matmul(transpose(basis), matmul(damper, basis))
      spring = matmul(transpose(basis), matmul(weighed(k, factor), basis))

      rest = n - free
      states = rest + n - undamped
      allocate (matrix(states, states), right(states, states), re(states), im(states), left(1, 1), work(max(1, 8*states)), &
                source=0.0_wp)
      do i = 1, rest
         matrix(i, states - rest + i) = 1.0_wp
      end do
      matrix(rest + 1:, 1:rest) = -spring(undamped + 1:, free + 1:)
      matrix(rest + 1:, rest + 1:) = -damper(undamped + 1:, undamped + 1:)
      call dgeev('N', 'V', states, matrix, states, re, im, left, 1, right, states, work, size(work), info)
      if (info /= 0) then
         info = -1
         return
      end if

      ! Of a pair one is listed: the real and the imaginary part of its vector are two columns.
      allocate (lambda(states + free), shapes(n, states + free))
      lambda(1:free) = (0.0_wp, 0.0_wp)
      shapes(:, 1:free) = basis(:, 1:free)
      found = free
      do i = 1, states
         if (im(i) < 0.0_wp) cycle
         found = found + 1
         lambda(found) = cmplx(re(i), im(i), wp)
         q = (0.0_wp, 0.0_wp)
         p = (0.0_wp, 0.0_wp)
         if (im(i) > 0.0_wp) then
            q(free + 1:) = cmplx(right(1:rest, i), right(1:rest, i + 1), wp)
            p(undamped + 1:) = cmplx(right(rest + 1:, i), right(rest + 1:, i + 1), wp)
         else
            q(free + 1:) = right(1:rest, i)
            p(undamped + 1:) = right(rest + 1:, i)
         end if
         p(1:undamped) = -(matmul(spring(1:undamped, :), q) + matmul(damper(1:undamped, :), p))/lambda(found)
         ! In the phase in which the real part is largest.
         p = p*exp(cmplx(0.0_wp, -0.5_wp*atan2(aimag(sum(p*p)), real(sum(p*p), wp)), wp))
         shapes(:, found) = matmul(basis, real(p, wp)/norm2(real(p, wp)))
      end do
      call dtrtrs('L', 'T', 'N', n, found, factor, n, shapes, n, info)
      order = increasing(aimag(lambda(1:found)), real(lambda(1:found), wp))
      modes%frequency = aimag(lambda(order))/(2.0_wp*pi)
      modes%growth = real(lambda(order), wp)
      modes%shapes = shapes(:, order)
   end subroutine solve_damped

   !> An orthonormal basis in coordinates of unit mass: motions that nothing resists first, of these first what nothing damps.
   subroutine free_motions_first(modes, factor, damper, basis, undamped, info)
      type(modes_t), intent(in) :: modes
      real(wp), intent(in) :: factor(:, :), damper(:, :)
      real(wp), allocatable, intent(out) :: basis(:, :)
      integer, intent(out) :: undamped, info
      real(wp), allocatable :: damped_by(:, :), s(:), tau(:), u(:, :), vt(:, :), work(:)
      integer, allocatable :: given(:), order(:)
      real(wp), parameter :: round_off = 1.0e-10_wp
      integer :: f, i, n

      n = size(factor, 1)
      undamped = 0
      order = pack([(i, i=1, n)], modes%frequency + modes%growth <= 0.0_wp)
      f = size(order)
      allocate (basis(n, n), s(f), u(1, 1), vt(f, f), work(64*n), source=0.0_wp)
      do i = 1, n
         basis(i, i) = 1.0_wp
      end do
      info = 0
      if (f == 0) return
      ! L^T times a motion is what it is in coordinates of unit mass.
      do i = 1, n
         basis(i, 1:f) = matmul(factor(i:, i), modes%shapes(i:, order))
      end do
      allocate (tau(f), source=0.0_wp)
      allocate (given(f), source=1)
      call dgeqp3(n, f, basis, n, given, tau, work, size(work), info)
      if (info == 0) call dorgqr(n, n, f, basis, n, tau, work, size(work), info)
      damped_by = matmul(damper, basis(:, 1:f))
      if (info == 0) call dgesvd('N', 'A', n, f, damped_by, n, s, u, 1, vt, f, work, size(work), info)
      if (info /= 0) then
         info = -1
         return
      end if
      undamped = count(s <= round_off*maxval(abs(damper)))
      basis(:, 1:f) = matmul(basis(:, 1:f), transpose(vt(f:1:-1, :)))
   end subroutine free_motions_first

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
