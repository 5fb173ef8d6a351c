!> Tests of the projectors of Eqs (12) and of the functional that Eqs (11) minimize.
module test_projection_matrices
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   use test_linalg, only: identity, largest, orthogonal, random_vector, restart_random, with_spectrum
   use test_normal_solver, only: of_rank
   use taut_kinds, only: wp
   use taut_error, only: error_t, to_text
   use taut_constrained_method_options, only: method_t
   use taut_constrained_projection_matrices, only: projection_matrices
   use taut_constrained_start, only: consistent_start, start_report_t
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_null_space, only: null_space
   implicit none (type, external)
   private
   public :: collect_projection_matrices

   character(len=6), parameter :: solver_names(3) = ['auto  ', 'dgelsd', 'factor']

   !> A linear system with all its matrices given.
   type, extends(mechanical_system_t) :: given_t
      real(wp), allocatable :: m(:, :), w(:, :), a(:, :), f(:), b1(:), b2(:)
   contains
      procedure :: mass => given_mass
      procedure :: weight => given_weight
      procedure :: force => given_force
      procedure :: constraint => given_constraint
      procedure :: jacobian => given_jacobian
      procedure :: velocity_rhs => given_velocity_rhs
      procedure :: acceleration_rhs => given_acceleration_rhs
   end type given_t

contains

   !> All tests of this module.
   function collect_projection_matrices() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [ &
              new_test('projectors of Eqs (12)', projector_identities), &
              new_test('W = I and W = M differ', weights_differ), &
              new_test('W = I and W = m I are the same', weights_agree), &
              new_test('Eqs (11) minimize the functional of Eq. (15)', least_functional), &
              new_test('a start where some velocities are held', held_start), &
              new_test('projectors where there are none', no_projectors)]
   end function collect_projection_matrices

   !> A random system with A of given rank and rates that its constraints can have.
   function random_system(c, n, rank) result(system)
      integer, intent(in) :: c, n, rank
      type(given_t) :: system

      system%m = with_spectrum(2.0_wp + random_vector(n))
      system%w = with_spectrum(2.0_wp + random_vector(n))
      system%a = of_rank(c, n, rank)
      system%f = random_vector(n)
      system%b1 = matmul(system%a, random_vector(n))
      system%b2 = matmul(system%a, random_vector(n))
      call system%define(n=n, c=c)
   end function random_system

   subroutine compute(system, weight, solver, pv, p1, pa, p2, failure)
      type(given_t), intent(in) :: system
      character(*), intent(in) :: weight, solver
      real(wp), allocatable, intent(out) :: pv(:, :), p1(:), pa(:, :), p2(:)
      character(:), allocatable, intent(inout) :: failure
      type(method_t) :: method
      type(state_t) :: at
      type(error_t), allocatable :: error

      method%weight = weight
      method%solver = solver
      at%x = spread(0.0_wp, 1, system%n)
      at%v = at%x
      allocate (at%w(0))
      call projection_matrices(system, method, at, pv, p1, pa, p2, error)
      call no_error(failure, error)
   end subroutine compute

   subroutine projector_identities(failure)
      character(:), allocatable, intent(inout) :: failure
      integer, parameter :: n = 5
      type(given_t) :: s
      real(wp), allocatable :: pv(:, :), p1(:), pa(:, :), p2(:), w(:, :)
      character(len=8), parameter :: weights(3) = ['identity', 'mass    ', 'given   ']
      character(:), allocatable :: label
      integer :: c, i, j, rank

      call restart_random()
      do c = 1, 7
         do rank = 1, min(c, n)
            s = random_system(c, n, rank)
            do i = 1, 3
               do j = 1, 3
                  label = 'W '//trim(weights(i))//', '//trim(solver_names(j))//', c = '//to_text(c)//', rank '//to_text(rank)
                  call compute(s, weights(i), solver_names(j), pv, p1, pa, p2, failure)
                  if (allocated(failure)) return
                  w = identity(n)
                  if (i == 2) w = s%m
                  if (i == 3) w = s%w
                  call check_below(failure, largest(matmul(pv, pv) - pv), 1.0e-12_wp, 'P_v P_v - P_v, '//label)
                  call check_below(failure, largest(matmul(pa, pa) - pa), 1.0e-12_wp, 'P_a P_a - P_a, '//label)
                  call check_below(failure, largest(matmul(s%a, pv) - s%a), 1.0e-12_wp, 'A P_v - A, '//label)
                  call check_below(failure, largest(matmul(s%a, pa) - s%a), 1.0e-12_wp, 'A P_a - A, '//label)
                  ! W P_v and M P_a are symmetric: this tells each metric from any other.
                  call check_below(failure, largest(matmul(w, pv) - transpose(matmul(w, pv))), 1.0e-12_wp, 'W P_v, '//label)
                  call check_below(failure, largest(matmul(s%m, pa) - transpose(matmul(s%m, pa))), 1.0e-12_wp, 'M P_a, '//label)
                  call check_below(failure, maxval(abs(matmul(s%a, p1) - s%b1)), 1.0e-12_wp, "A p_v - b', "//label)
                  call check_below(failure, maxval(abs(matmul(s%a, p2) - s%b2)), 1.0e-12_wp, "A p_a - b'', "//label)
                  call check_close(failure, trace(pv), real(rank, wp), 1.0e-12_wp, 'trace of P_v, '//label)
               end do
            end do
         end do
      end do
   end subroutine projector_identities

   pure function trace(a) result(value)
      real(wp), intent(in) :: a(:, :)
      real(wp) :: value
      integer :: i

      value = sum([(a(i, i), i=1, size(a, 1))])
   end function trace

   subroutine weights_differ(failure)
      character(:), allocatable, intent(inout) :: failure
      type(given_t) :: s
      real(wp), allocatable :: by_i(:, :), by_m(:, :), p1(:), pa(:, :), p2(:)

      ! M = diag(1, 3), A = {1 1}: P_v is half of all ones with W = I, {3/4 3/4; 1/4 1/4} with W = M, by hand.
      s%m = reshape([1.0_wp, 0.0_wp, 0.0_wp, 3.0_wp], [2, 2])
      s%w = identity(2)
      s%a = reshape([1.0_wp, 1.0_wp], [1, 2])
      s%f = [0.0_wp, 0.0_wp]
      s%b1 = [2.0_wp]
      s%b2 = [4.0_wp]
      call s%define(n=2, c=1)
      call compute(s, 'identity', 'auto', by_i, p1, pa, p2, failure)
      if (allocated(failure)) return
      call check_below(failure, largest(by_i - 0.5_wp), 1.0e-15_wp, 'P_v with W = I')
      call check_below(failure, maxval(abs(p1 - 1.0_wp)), 1.0e-15_wp, 'p_v with W = I')
      call check_below(failure, maxval(abs(p2 - [3.0_wp, 1.0_wp])), 1.0e-14_wp, 'p_a')
      call compute(s, 'mass', 'auto', by_m, p1, pa, p2, failure)
      if (allocated(failure)) return
      call check_below(failure, largest(by_m - reshape([0.75_wp, 0.25_wp, 0.75_wp, 0.25_wp], [2, 2])), 1.0e-15_wp, &
                       'P_v with W = M')
      call check_below(failure, maxval(abs(p1 - [1.5_wp, 0.5_wp])), 1.0e-15_wp, 'p_v with W = M')
      call check_below(failure, largest(by_m - pa), 1.0e-15_wp, 'P_v and P_a are the same with W = M')
      call check(failure, largest(by_m - by_i) > 0.2_wp, 'W = I and W = M do not differ')
   end subroutine weights_differ

   subroutine weights_agree(failure)
      character(:), allocatable, intent(inout) :: failure
      type(given_t) :: s
      real(wp), allocatable :: by_i(:, :), by_m(:, :), p1(:), p1_by_m(:), pa(:, :), p2(:)
      integer :: rank

      call restart_random()
      do rank = 1, 3
         s = random_system(4, 5, rank)
         s%m = 7.0_wp*identity(5)
         call compute(s, 'identity', 'auto', by_i, p1, pa, p2, failure)
         call compute(s, 'mass', 'auto', by_m, p1_by_m, pa, p2, failure)
         if (allocated(failure)) return
         call check_below(failure, largest(by_m - by_i), 1.0e-13_wp, 'P_v depends on the unit of mass')
         call check_below(failure, largest(pa - by_i), 1.0e-13_wp, 'P_a depends on the unit of mass')
         call check_below(failure, maxval(abs(p1_by_m - p1)), 1.0e-13_wp, 'p_v depends on the unit of mass')
      end do
   end subroutine weights_agree

   !> No feasible neighbor has a smaller G; A dx = 0 leaves the constraints as they are.
   subroutine least_functional(failure)
      character(:), allocatable, intent(inout) :: failure
      integer, parameter :: n = 6
      type(given_t) :: s
      real(wp), allocatable :: pv(:, :), p1(:), pa(:, :), p2(:), w(:, :)
      character(len=8), parameter :: weights(3) = ['identity', 'mass    ', 'given   ']
      real(wp) :: a(n), dv(n), dx(n), g0, null(n, n), v(n), vdot(n), xdot(n), f(n, 1)
      type(block_diagonal_t) :: m
      integer :: c, i, info, rank, trial
      character(:), allocatable :: label

      call restart_random()
      call m%init([n])
      do c = 1, 7, 2
         do rank = 1, min(c, n - 1)
            s = random_system(c, n, rank)
            null(:, :) = null_projector(s%a, rank)
            call check_below(failure, largest(matmul(s%a, null)), 1.0e-13_wp, 'a neighbor is not feasible')
            call m%set_dense(s%m)
            call m%factorize(info)
            f(:, 1) = s%f
            call m%solve(1, f)
            a(:) = f(:, 1)
            v(:) = random_vector(n)
            do i = 1, 3
               label = 'W '//trim(weights(i))//', c = '//to_text(c)//', rank '//to_text(rank)
               call compute(s, weights(i), 'auto', pv, p1, pa, p2, failure)
               if (allocated(failure)) return
               w = identity(n)
               if (i == 2) w = s%m
               if (i == 3) w = s%w
               xdot(:) = v - matmul(pv, v) + p1
               vdot(:) = a - matmul(pa, a) + p2
               call check_below(failure, maxval(abs(matmul(s%a, xdot) - s%b1)), 1.0e-12_wp, "A xdot - b', "//label)
               call check_below(failure, maxval(abs(matmul(s%a, vdot) - s%b2)), 1.0e-12_wp, "A vdot - b'', "//label)
               g0 = functional(vdot, xdot)
               do trial = 1, 20
                  dv(:) = matmul(null, random_vector(n))
                  dx(:) = matmul(null, random_vector(n))
                  ! Each level by itself, and a step that is not small: G is quadratic, so that its growth is exact.
                  call check_close(failure, functional(vdot + dv, xdot) - g0, 0.5_wp*dot_product(dv, matmul(s%m, dv)), 1.0e-12_wp, &
                                   'growth of G with vdot, '//label)
                  call check_close(failure, functional(vdot, xdot + dx) - g0, 0.5_wp*dot_product(dx, matmul(w, dx)), 1.0e-12_wp, &
                                   'growth of G with xdot, '//label)
                  call check(failure, functional(vdot + 0.01_wp*dv, xdot - 0.01_wp*dx) > g0, 'a smaller G nearby, '//label)
               end do
            end do
         end do
      end do

   contains

      !> G(vdot, xdot) with w = 1, Eq. (15).
      function functional(vdot, xdot) result(g)
         real(wp), intent(in) :: vdot(:), xdot(:)
         real(wp) :: g

         g = 0.5_wp*dot_product(vdot - a, matmul(s%m, vdot - a)) + 0.5_wp*dot_product(xdot - v, matmul(w, xdot - v))
      end function functional

   end subroutine least_functional

   !> The orthogonal projector on the null space of A, by Gram and Schmidt on its rows with pivots; none of taut is used.
   function null_projector(a, rank) result(p)
      real(wp), intent(in) :: a(:, :)
      integer, intent(in) :: rank
      real(wp) :: p(size(a, 2), size(a, 2)), rows(size(a, 1), size(a, 2)), q(size(a, 2))
      integer :: i, k

      rows(:, :) = a
      p(:, :) = identity(size(a, 2))
      do k = 1, rank
         i = maxloc(sum(rows**2, 2), 1)
         q(:) = matmul(p, rows(i, :))
         q(:) = q/norm2(q)
         p(:, :) = p - spread(q, 2, size(q))*spread(q, 1, size(q))
         rows(:, :) = rows - spread(matmul(rows, q), 2, size(q))*spread(q, 1, size(rows, 1))
      end do
   end function null_projector

   !> What is held stays bit for bit; of the others, coordinates move least in the metric W and velocities in the metric M,
   !! those of the free velocities.
   subroutine held_start(failure)
      character(:), allocatable, intent(inout) :: failure
      integer, parameter :: c = 2, n = 6
      logical, parameter :: held(n) = [.true., .false., .false., .true., .false., .false.]
      type(given_t) :: system
      type(method_t) :: method
      type(start_report_t) :: report
      type(state_t) :: at, given
      type(error_t), allocatable :: error
      real(wp), allocatable :: a_plus(:, :), m_free(:, :), w_free(:, :), z(:, :)
      integer, allocatable :: free(:)
      integer :: i, info, rank

      system = random_system(c, n, c)
      free = pack([(i, i=1, n)], .not. held)
      call null_space(system%a(:, free), z, a_plus, rank, info)
      w_free = matmul(transpose(z), system%w(free, free))
      m_free = matmul(transpose(z), system%m(free, free))
      method%weight = 'given'
      given%x = random_vector(n)
      given%v = random_vector(n)
      at = given
      call consistent_start(system, method, at, report, error, held)
      call no_error(failure, error)
      call check(failure, all(abs(at%x - given%x) <= 0.0_wp .eqv. held), 'coordinates')
      call check(failure, all(abs(at%v - given%v) <= 0.0_wp .eqv. held), 'velocities')
      call check_below(failure, maxval(abs(matmul(system%a, at%x))), 1.0e-12_wp, 'phi')
      call check_below(failure, maxval(abs(matmul(system%a, at%v) - system%b1)), 1.0e-12_wp, 'phidot')
      call check_below(failure, maxval(abs(matmul(w_free, at%x(free) - given%x(free)))), 1.0e-11_wp, 'least displacement')
      call check_below(failure, maxval(abs(matmul(m_free, at%v(free) - given%v(free)))), 1.0e-11_wp, 'least change')
      call consistent_start(system, method, given, report, error, [(.true., i=1, n)])
      call check(failure, allocated(error), 'what is held cannot be mended')
   end subroutine held_start

   subroutine no_projectors(failure)
      character(:), allocatable, intent(inout) :: failure
      type(given_t) :: s
      type(method_t) :: method
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp), allocatable :: pv(:, :), p1(:), pa(:, :), p2(:)

      call restart_random()
      s = random_system(2, 3, 2)
      at%x = [0.0_wp, 0.0_wp, 0.0_wp]
      at%v = at%x
      s%m(3, 3) = -1.0_wp
      call projection_matrices(s, method, at, pv, p1, pa, p2, error)
      call check(failure, allocated(error), 'an indefinite mass matrix is not reported')
      if (allocated(failure)) return
      call check(failure, index(error%what, 'mass matrix is not positive definite at velocity 3') > 0, error%line())
      deallocate (error)
      s = random_system(2, 3, 2)
      method%weight = 'nonsense'
      call projection_matrices(s, method, at, pv, p1, pa, p2, error)
      call check(failure, allocated(error), 'an unknown weight is not reported')
   end subroutine no_projectors

   subroutine given_mass(self, at, m)
      class(given_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m

      call m%set_dense(self%m)
      associate (unused_state => at)
      end associate
   end subroutine given_mass

   subroutine given_weight(self, at, w)
      class(given_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: w

      call w%set_dense(self%w)
      associate (unused_state => at)
      end associate
   end subroutine given_weight

   subroutine given_force(self, at, value)
      class(given_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(:) = self%f
      associate (unused_state => at)
      end associate
   end subroutine given_force

   subroutine given_constraint(self, at, value)
      class(given_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(:) = matmul(self%a, at%x) - at%t*self%b1
   end subroutine given_constraint

   subroutine given_jacobian(self, at, a)
      class(given_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)

      a(:, :) = self%a
      associate (unused_state => at)
      end associate
   end subroutine given_jacobian

   subroutine given_velocity_rhs(self, at, value)
      class(given_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(:) = self%b1
      associate (unused_state => at)
      end associate
   end subroutine given_velocity_rhs

   subroutine given_acceleration_rhs(self, at, value)
      class(given_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(:) = self%b2
      associate (unused_state => at)
      end associate
   end subroutine given_acceleration_rhs

end module test_projection_matrices
