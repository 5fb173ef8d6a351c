!> Checks a user's own system: A against phi, b' and b'' against both, M, H, and that everything is set.
module taut_constrained_verify
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_constrained_method_options, only: method_t
   use taut_constrained_start, only: consistent_start, start_report_t
   use taut_constrained_system_tables, only: coordinate_name, name_length, velocity_name
   use taut_constrained_system, only: check_supplied, mechanical_system_t, state_t
   use taut_constrained_completion, only: completion_t
   use taut_constrained_jacobian, only: evaluate_jacobian, lay_out_jacobian
   use taut_constrained_verify_claims, only: check_arguments, check_normalize
   use taut_constrained_verify_finding, only: check_set, compare, compare_column, elsewhere, entry_name, finding_t, largest, &
                                              mark_followers, note, scale_of, size_of, take_nearer, unset
   use taut_linalg_arbitrary, only: arbitrary
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_csr, only: csr_t
   implicit none (type, external)
   private
   public :: verify, finding_t, shaken

   !> Steps of the central differences: the cube root of round-off, times sizes that a system may be of. What a system gives
   !! is right if it agrees with one of the differences; so small mechanisms and fast motions need no option.
   real(wp), parameter :: steps(4) = 6.0e-6_wp*[1.0_wp, 1.0e-2_wp, 1.0e-4_wp, 1.0e2_wp]

contains

   !> Compares the procedures of a system with each other at a state, by central differences.
   !!
   !! A(i, j) is compared with the derivative of phi_i along velocity j, b' with -dphi/dt, and b'' with the rate of
   !! b' - A v at constant v along the motion. Where nothing is wrong with the given state, two states near it are looked at
   !! too, brought to the constraints and with other velocities: at rest most faults of b'' do not show.
   subroutine verify(model, at, findings, error, tolerance)
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> The state at which it is evaluated.
      type(state_t), intent(in) :: at
      !> What is wrong; empty if nothing is.
      type(finding_t), allocatable, intent(out) :: findings(:)
      !> Sizes that do not fit, so that nothing can be checked.
      type(error_t), allocatable, intent(inout) :: error
      !> Difference that is let pass, relative to the largest entry of what is compared. Default 1e-6.
      real(wp), intent(in), optional :: tolerance
      type(state_t) :: here, near
      type(finding_t), allocatable :: more(:)
      type(error_t), allocatable :: no_start
      type(start_report_t) :: report
      real(wp) :: allowed
      integer :: i

      allocate (findings(0))
      allowed = 1.0e-6_wp
      if (present(tolerance)) allowed = tolerance
      call model%check_sizes(error)
      if (allocated(error)) return
      here = at
      if (.not. allocated(here%w)) allocate (here%w(0))
      if (.not. (allocated(here%x) .and. allocated(here%v))) then
         call raise(error, 'verify', 'coordinates or velocities are not set', 'set both')
         return
      end if
      if (size(here%x) /= model%n_x .or. size(here%v) /= model%n .or. size(here%w) /= model%n_w) then
         call raise(error, 'verify', 'the state has not the sizes of the system', 'give '//to_text(model%n_x)//' coordinates, '// &
                    to_text(model%n)//' velocities and '//to_text(model%n_w)//' other states')
         return
      end if
      call check_supplied(model, here, error)
      if (allocated(error)) return

      call look(model, here, allowed, findings)
      do i = 1, 2
         if (size(findings) > 0) exit
         near = shaken(model, here, i)
         if (allocated(no_start)) deallocate (no_start)
         call consistent_start(model, method_t(), near, report, no_start)
         if (allocated(no_start)) cycle
         allocate (more(0))
         call look(model, near, allowed, more)
         call check_constancy(model, here, near, allowed, more)
         call elsewhere(more)
         call move_alloc(more, findings)
      end do
      call mark_followers(findings)
      call name_entries(model, findings)
   end subroutine verify

   !> Rows and columns by their names, where a system has names for them.
   subroutine name_entries(model, findings)
      class(mechanical_system_t), intent(in) :: model
      type(finding_t), intent(inout) :: findings(:)
      character(:), allocatable :: row
      integer :: i

      do i = 1, size(findings)
         associate (it => findings(i))
            row = ''
            select case (it%what)
            case ('A', 'phi', "b'", "b''")
               call model%row_name(it%row, row)
               if (row == 'constraint '//to_text(it%row)) row = ''
            case ('M', 'f', 'H^+')
               row = trim(own_name(velocity_name(model, it%row), 'v', it%row))
            case ('H', 'x')
               row = trim(own_name(coordinate_name(model, it%row), 'x', it%row))
            end select
            if (len(row) > 0) it%message = it%message//'; row '//to_text(it%row)//' is '//row
            if (it%column == 0) cycle
            row = trim(own_name(velocity_name(model, it%column), 'v', it%column))
            if (len(row) > 0) it%message = it%message//'; column '//to_text(it%column)//' is '//row
         end associate
      end do
   end subroutine name_entries

   !> A name, unless it is a number and nothing else.
   pure function own_name(name, letter, i) result(own)
      character(len=name_length), intent(in) :: name
      character, intent(in) :: letter
      integer, intent(in) :: i
      character(len=name_length) :: own

      own = name
      if (name == letter//to_text(i) .or. index(name, ' '//to_text(i)) > 0) own = ''
   end function own_name

   !> A state near another, with other velocities; differences are of the size of what there is.
   function shaken(model, at, k) result(near)
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> The state.
      type(state_t), intent(in) :: at
      !> Each number gives another one.
      integer, intent(in) :: k
      !> Not on the constraints.
      type(state_t) :: near
      real(wp) :: size_of_v, size_of_x
      real(wp) :: d(model%n)
      integer :: i

      near = at
      size_of_x = size_of(at%x)
      size_of_v = largest(at%v)
      if (.not. size_of_v > 0.0_wp) size_of_v = size_of_x
      d = [(0.02_wp*size_of_x*arbitrary(2*i + 1000*k), i=1, model%n)]
      call model%displace(d, near%x)
      call model%normalize(near%x)
      near%v = at%v + [(size_of_v*arbitrary(2*i + 1 + 1000*k), i=1, model%n)]
      near%t = at%t + 0.013_wp*k
   end function shaken

   !> M at two states, of a system that says that it never changes.
   subroutine check_constancy(model, here, near, allowed, findings)
      class(mechanical_system_t), intent(in) :: model
      type(state_t), intent(in) :: here, near
      real(wp), intent(in) :: allowed
      type(finding_t), allocatable, intent(inout) :: findings(:)
      type(block_diagonal_t) :: m
      real(wp), allocatable :: first(:, :), second(:, :)
      integer :: i, j

      if (.not. model%constant_mass) return
      call m%init(model%mass_blocks)
      call model%mass(here, m)
      first = m%dense()
      call model%mass(near, m)
      second = m%dense()
      if (.not. (all(ieee_is_finite(first)) .and. all(ieee_is_finite(second)))) return
      do j = 1, model%n
         do i = j, model%n
            if (abs(first(i, j) - second(i, j)) <= allowed*maxval(abs(first))) cycle
            call note('M', i, j, second(i, j), first(i, j), trim(entry_name('M', i, j))//' changes, and the system says that M '// &
                      'never does: give define constant_mass = .false.', findings)
            return
         end do
      end do
   end subroutine check_constancy

   !> All comparisons at a state.
   subroutine look(model, here, allowed, findings)
      class(mechanical_system_t), intent(in) :: model
      type(state_t), intent(in) :: here
      real(wp), intent(in) :: allowed
      type(finding_t), allocatable, intent(inout) :: findings(:)
      real(wp), allocatable :: a(:, :), a_expected(:, :), b(:), b_expected(:), phi(:), f(:), g(:)
      integer :: i

      allocate (a(model%c, model%n), a_expected(model%c, model%n), b(model%c), b_expected(model%c), &
                phi(model%n_phi), f(model%n), g(model%n_w), source=unset())
      call check_mass(model, here, allowed, findings)
      call model%force(here, f)
      call check_set('f', f, findings)
      call model%w_rate(here, g)
      call check_set('g', g, findings)
      call check_rates(model, here, allowed, findings)
      call check_normalize(model, here, allowed, findings)
      call check_arguments(model, here, allowed, findings)
      call model%constraint(here, phi)
      call check_set('phi', phi, findings)
      call model%jacobian(here, a)
      do i = 1, model%n
         call check_set('A', a(:, i), findings, i)
      end do
      call check_entries(model, here, a, allowed, findings)
      call model%velocity_rhs(here, b)
      call check_set("b'", b, findings)
      a_expected = unset()
      b_expected = unset()
      do i = 1, size(steps)
         call differentiate_phi(model, here, steps(i), a, b, g, a_expected, b_expected)
         call differentiate_phi(model, here, steps(i)*size_of(here%x), a, b, g, a_expected, b_expected)
      end do
      do i = 1, model%n_phi
         call compare("b'", i, 0, b(i), b_expected(i), scale_of(b_expected, a, here%v), allowed, findings)
      end do
      do i = 1, model%n
         call compare_column(i, a(1:model%n_phi, i), a_expected(1:model%n_phi, i), a_expected(1:model%n_phi, :), allowed, findings)
      end do
      call model%acceleration_rhs(here, b)
      call check_set("b''", b, findings)
      b_expected = unset()
      do i = 1, size(steps)
         call differentiate_rate(model, here, steps(i), g, b, b_expected)
      end do
      do i = 1, model%c
         ! The derivative is taken of A v - b', so that its error grows with these.
         call compare("b''", i, 0, b(i), b_expected(i), scale_of(b_expected, a, here%v), &
                      10.0_wp*allowed, findings)
      end do
   end subroutine look

   !> The entries of a structured A against the dense one, which has to be zero elsewhere.
   subroutine check_entries(model, at, a, allowed, findings)
      class(mechanical_system_t), intent(in) :: model
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: a(:, :), allowed
      type(finding_t), allocatable, intent(inout) :: findings(:)
      integer, allocatable :: first(:), column(:)
      real(wp), allocatable :: values(:), row(:)
      integer :: i, j, k

      call model%pattern(first, column)
      if (.not. allocated(first)) return
      allocate (values(size(column)), row(model%n), source=unset())
      call model%jacobian_entries(at, values)
      do i = 1, model%c
         row(:) = 0.0_wp
         do k = first(i), first(i + 1) - 1
            row(column(k)) = values(k)
            if (.not. ieee_is_finite(values(k))) &
               call note('A', i, column(k), values(k), a(i, column(k)), &
                         trim(entry_name('A', i, column(k)))//' of jacobian_entries is not set or not finite', findings)
         end do
         do j = 1, model%n
            call compare('A', i, j, row(j), a(i, j), largest(a(i, :)), allowed, findings)
         end do
      end do
   end subroutine check_entries

   !> M symmetric, positive definite and set.
   subroutine check_mass(model, at, allowed, findings)
      class(mechanical_system_t), intent(in) :: model
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: allowed
      type(finding_t), allocatable, intent(inout) :: findings(:)
      type(block_diagonal_t) :: m
      type(completion_t) :: completion
      type(csr_t) :: a
      real(wp) :: k(model%n, model%n)
      integer :: i, info, j

      call m%init(model%mass_blocks)
      m%values(:) = unset()
      call model%mass(at, m)
      if (m%stray(1) > 0) then
         call note('M', m%stray(1), m%stray(2), 0.0_wp, 0.0_wp, trim(entry_name('M', m%stray(1), m%stray(2)))// &
                   ' is outside the blocks that mass_blocks states', findings)
         return
      end if
      k = m%dense()
      do j = 1, model%n
         call check_set('M', k(:, j), findings, j)
      end do
      if (.not. all(ieee_is_finite(k))) return
      do j = 1, model%n
         do i = j + 1, model%n
            call compare('M', i, j, k(i, j), k(j, i), maxval(abs(k)), allowed, findings)
         end do
      end do
      call m%factorize(info)
      if (info == 0) return
      call lay_out_jacobian(model, a)
      call evaluate_jacobian(model, at, a)
      if (all(ieee_is_finite(a%values))) call completion%factorize(m, a, info)
      if (info /= 0) call note('M', info, info, k(info, info), 0.0_wp, &
                               trim(entry_name('M', info, info))//': M is not positive definite', findings)
   end subroutine check_mass

   !> H(x) v, its inverse, and x (+) d against each other.
   subroutine check_rates(model, at, allowed, findings)
      class(mechanical_system_t), intent(in) :: model
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: allowed
      type(finding_t), allocatable, intent(inout) :: findings(:)
      real(wp) :: rate(model%n_x), back(model%n), x_plus(model%n_x), x_minus(model%n_x), expected(model%n_x), &
                  again(model%n_x), d
      integer :: i

      rate = unset()
      back = unset()
      call model%x_rate(at, at%v, rate)
      call check_set('H', rate, findings)
      if (.not. all(ieee_is_finite(rate))) return
      call model%v_of_x_rate(at, rate, back)
      call check_set('H^+', back, findings)
      if (model%n_x >= model%n) then
         do i = 1, model%n
            call compare('H^+', i, 0, back(i), at%v(i), maxval(abs(at%v)), allowed, findings)
         end do
      else
         ! Not all velocities have a coordinate: those that come back give the same rates.
         call model%x_rate(at, back, again)
         do i = 1, model%n_x
            call compare('H^+', i, 0, again(i), rate(i), maxval(abs(rate)), allowed, findings)
         end do
      end if
      expected = unset()
      do i = 1, size(steps)
         d = steps(i)/max(1.0_wp, maxval(abs(at%v)))
         x_plus = at%x
         x_minus = at%x
         call model%displace(d*at%v, x_plus)
         call model%displace(-d*at%v, x_minus)
         call take_nearer(rate, (x_plus - x_minus)/(2.0_wp*d), expected)
      end do
      do i = 1, model%n_x
         call compare('H', i, 0, rate(i), expected(i), maxval(abs(rate)), 100.0_wp*allowed, findings)
      end do
   end subroutine check_rates

   !> dphi/dx H and -dphi/dt by central differences.
   subroutine differentiate_phi(model, at, step, a, b, g, a_expected, b_expected)
      class(mechanical_system_t), intent(in) :: model
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: step, a(:, :), b(:), g(:)
      real(wp), intent(inout) :: a_expected(:, :), b_expected(:)
      type(state_t) :: near
      real(wp) :: d(model%n), plus(model%n_phi), minus(model%n_phi), dt
      integer :: j

      do j = 1, model%n
         d = 0.0_wp
         d(j) = step
         near = at
         call model%displace(d, near%x)
         call model%constraint(near, plus)
         near%x = at%x
         call model%displace(-d, near%x)
         call model%constraint(near, minus)
         call take_nearer(a(1:model%n_phi, j), (plus - minus)/(2.0_wp*step), a_expected(1:model%n_phi, j))
      end do
      near = at
      dt = max(step, 1.0e3_wp*spacing(at%t))
      ! What is not mechanics goes on, where phi depends on it.
      near%t = at%t + dt
      near%w = at%w + dt*g
      call model%constraint(near, plus)
      near%t = at%t - dt
      near%w = at%w - dt*g
      call model%constraint(near, minus)
      call take_nearer(b(1:model%n_phi), -(plus - minus)/(2.0_wp*dt), b_expected(1:model%n_phi))
   end subroutine differentiate_phi

   !> The rate of b' - A v at constant v, along x (+) v dt and t + dt, by central differences.
   subroutine differentiate_rate(model, at, step, g, b, b_expected)
      class(mechanical_system_t), intent(in) :: model
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: step, g(:), b(:)
      real(wp), intent(inout) :: b_expected(:)
      real(wp) :: plus(model%c), minus(model%c), dt

      dt = max(step, 1.0e3_wp*spacing(at%t))
      call rate_of_violation(dt, plus)
      call rate_of_violation(-dt, minus)
      call take_nearer(b, -(plus - minus)/(2.0_wp*dt), b_expected)

   contains

      subroutine rate_of_violation(dt, rate)
         real(wp), intent(in) :: dt
         real(wp), intent(out) :: rate(:)
         type(state_t) :: near
         real(wp) :: a(model%c, model%n), b_prime(model%c)

         near = at
         near%t = at%t + dt
         near%w = at%w + dt*g
         call model%displace(dt*at%v, near%x)
         call model%jacobian(near, a)
         call model%velocity_rhs(near, b_prime)
         rate = matmul(a, at%v) - b_prime
      end subroutine rate_of_violation

   end subroutine differentiate_rate

end module taut_constrained_verify
