!> Tests of the chain, whose constraint matrix has a pattern.
module test_chain
   use taut_constrained_method_choose, only: new_constrained_ode
   use testing, only: check, check_below, new_test, no_error, test_t
   use test_linalg, only: random_vector, restart_random
   use taut_kinds, only: wp
   use taut_error, only: error_t, to_text
   use taut_constrained_method, only: constrained_ode_t, sample_t
   use taut_constrained_method_options, only: method_t
   use taut_constrained_simulate, only: simulate
   use taut_constrained_system, only: state_t
   use taut_constrained_verify, only: finding_t, verify
   use taut_model_chain, only: chain_t, new_chain
   use taut_model_pendulum, only: new_pendulum, pendulum_t
   use taut_ode_options, only: integration_options_t, integration_result_t
   implicit none (type, external)
   private
   public :: collect_chain

   !> A chain whose pattern or entries are wrong.
   type, extends(chain_t) :: wrong_chain_t
      character(len=16) :: mistake = ''
   contains
      procedure :: pattern => wrong_pattern
      procedure :: jacobian => right_jacobian
      procedure :: jacobian_entries => wrong_entries
   end type wrong_chain_t

contains

   !> All tests of this module.
   function collect_chain() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('a straight chain of 10000 rods is not redundant', straight_chain), &
               new_test('a chain of one rod is a pendulum', one_rod), &
               new_test('a chain swings', chain_swings), &
               new_test('a chain is correct', chain_verified), &
               new_test('mistakes in patterns and entries are found', mistakes)]
   end function collect_chain

   !> Hanging straight at rest: the tension of rod i carries the masses below, (n + 1 - i) m g, and nothing moves.
   subroutine straight_chain(failure)
      character(:), allocatable, intent(inout) :: failure
      integer, parameter :: n = 10000
      type(chain_t) :: chain
      class(constrained_ode_t), allocatable :: ode
      type(method_t) :: method
      type(error_t), allocatable :: error
      type(state_t) :: at
      type(sample_t) :: s
      real(wp), allocatable :: y(:), dydt(:)
      integer :: i, info, k
      character(len=16), parameter :: names(3) = [character(len=16) :: 'auto', 'banded', 'sparse']

      call new_chain(chain, n, 2.0_wp, 0.5_wp, 10.0_wp, error)
      call chain%start(0.5_wp*acos(-1.0_wp), at)
      at%x(1::2) = 0.0_wp
      do k = 1, size(names)
         method%solver = names(k)
         call new_constrained_ode(ode, chain, method, error)
         call no_error(failure, error)
         if (.not. allocated(y)) allocate (y(ode%size()), dydt(ode%size()))
         call ode%pack(at, y)
         call ode%rhs(0.0_wp, y, dydt, info)
         call check(failure, info == 0, 'no right-hand side, '//names(k))
         call check_below(failure, maxval(abs(dydt)), 1.0e-7_wp, 'a hanging chain moves, '//names(k))
         call ode%sample(0.0_wp, y, s, info)
         call check(failure, s%rank == n, 'rank '//to_text(s%rank)//', '//names(k))
         call check_below(failure, maxval(abs(s%lambda/[(20.0_wp*(n + 1 - i), i=1, n)] - 1.0_wp)), 1.0e-9_wp, &
                          'tensions, '//names(k))
      end do
   end subroutine straight_chain

   subroutine one_rod(failure)
      character(:), allocatable, intent(inout) :: failure
      type(chain_t) :: chain
      type(pendulum_t) :: pendulum
      type(error_t), allocatable :: error
      type(integration_result_t) :: result
      type(state_t) :: at, other

      call new_chain(chain, 1, 2.0_wp, 0.7_wp, 9.81_wp, error)
      call new_pendulum(pendulum, 2.0_wp, 0.7_wp, 9.81_wp, 1, error)
      call chain%start(0.3_wp, at)
      other = at
      call simulate(chain, at, 1.0_wp, result, error)
      call simulate(pendulum, other, 1.0_wp, result, error)
      call no_error(failure, error)
      call check_below(failure, maxval(abs(at%x - other%x)), 1.0e-12_wp, 'end')
      call check(failure, chain%x_name(1) == 'x1' .and. chain%x_name(4) == 'z2' .and. chain%v_name(3) == 'vx2', 'names')
   end subroutine one_rod

   !> Energy is kept and every rod keeps its length; the chain's lowest mode, a small swing from the vertical, has the
   !! frequency j0^2/4 g/L of a heavy rope but for terms of 1/n: here the double pendulum's sqrt(2 -+ sqrt(2)) sqrt(g/l).
   subroutine chain_swings(failure)
      character(:), allocatable, intent(inout) :: failure
      type(chain_t) :: chain
      type(error_t), allocatable :: error
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(state_t) :: at
      real(wp) :: amplitude, before, omega, phi(30)
      character(len=8), parameter :: stages(2) = [character(len=8) :: 'newton', 'none']
      type(method_t) :: method
      integer :: i

      options%rtol = 1.0e-9_wp
      options%atol = 1.0e-11_wp
      do i = 1, 2
         method%stage_projection = stages(i)
         call new_chain(chain, 30, 1.0_wp, 0.1_wp, 9.81_wp, error)
         call chain%start(0.0_wp, at)
         before = chain%energy(at)
         call simulate(chain, at, 1.0_wp, result, error, method, options)
         call no_error(failure, error)
         call check_below(failure, chain%energy(at) - before, 1.0e-5_wp, 'energy, '//stages(i))
         call chain%constraint(at, phi)
         call check_below(failure, maxval(abs(phi)), 1.0e-12_wp, 'lengths, '//stages(i))
      end do
      ! Two masses on two rods, small angles in the ratio 1 : sqrt(2), released from rest.
      call new_chain(chain, 2, 1.0_wp, 1.0_wp, 9.81_wp, error)
      amplitude = 1.0e-4_wp
      omega = sqrt((2.0_wp - sqrt(2.0_wp))*9.81_wp)
      at%t = 0.0_wp
      at%x = [sin(amplitude), -cos(amplitude), sin(amplitude) + sin(sqrt(2.0_wp)*amplitude), &
              -cos(amplitude) - cos(sqrt(2.0_wp)*amplitude)]
      at%v = 0.0_wp*at%x
      call simulate(chain, at, 2.0_wp, result, error, options=options)
      call no_error(failure, error)
      call check_below(failure, at%x(1) - amplitude*cos(2.0_wp*omega), 1.0e-9_wp, 'lowest mode of two rods')
   end subroutine chain_swings

   subroutine chain_verified(failure)
      character(:), allocatable, intent(inout) :: failure
      type(chain_t) :: chain
      type(error_t), allocatable :: error
      type(finding_t), allocatable :: findings(:)
      type(state_t) :: at

      call restart_random()
      call new_chain(chain, 5, 1.3_wp, 0.7_wp, 9.81_wp, error)
      call chain%start(0.4_wp, at)
      at%x = at%x + 0.1_wp*random_vector(10)
      at%v = random_vector(10)
      call verify(chain, at, findings, error)
      call no_error(failure, error)
      call check(failure, size(findings) == 0, 'something is found in a chain')
      if (size(findings) > 0) call check(failure, .false., findings(1)%message)
      call new_chain(chain, 0, 1.0_wp, 1.0_wp, 9.81_wp, error)
      call check(failure, allocated(error), 'a chain without rods')
   end subroutine chain_verified

   subroutine mistakes(failure)
      character(:), allocatable, intent(inout) :: failure
      type(wrong_chain_t) :: chain
      type(error_t), allocatable :: error
      type(finding_t), allocatable :: findings(:)
      type(state_t) :: at
      character(len=16), parameter :: patterns(6) = [character(len=16) :: 'one array', 'too short', 'not from 1', 'backwards', &
                                                     'outside', 'twice']
      character(len=16), parameter :: entries(2) = [character(len=16) :: 'wrong entry', 'not set']
      integer :: i

      call new_chain(chain%chain_t, 3, 1.0_wp, 1.0_wp, 9.81_wp, error)
      call chain%start(0.2_wp, at)
      at%v(:) = [1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp, 5.0_wp, 6.0_wp]
      call verify(chain, at, findings, error)
      call check(failure, size(findings) == 0, 'something is found where nothing is wrong')
      do i = 1, size(patterns)
         chain%mistake = patterns(i)
         if (allocated(error)) deallocate (error)
         call chain%check_sizes(error)
         call check(failure, allocated(error), 'a pattern is let pass: '//patterns(i))
      end do
      if (allocated(error)) deallocate (error)
      do i = 1, size(entries)
         chain%mistake = entries(i)
         call verify(chain, at, findings, error)
         call no_error(failure, error)
         call check(failure, size(findings) > 0, 'entries are let pass: '//entries(i))
         if (allocated(failure)) return
         call check(failure, all(findings%what == 'A'), 'under another name: '//entries(i))
      end do
   end subroutine mistakes

   subroutine wrong_pattern(self, first, column)
      class(wrong_chain_t), intent(in) :: self
      integer, allocatable, intent(out) :: first(:), column(:)

      call self%chain_t%pattern(first, column)
      select case (self%mistake)
      case ('one array')
         deallocate (column)
      case ('too short')
         first = first(:3)
      case ('not from 1')
         first = first + 1
      case ('backwards')
         first(2:3) = first([3, 2])
      case ('outside')
         column(10) = 7
      case ('twice')
         column(4) = column(3)
      end select
   end subroutine wrong_pattern

   subroutine right_jacobian(self, at, a)
      class(wrong_chain_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)
      type(chain_t) :: right
      type(error_t), allocatable :: error

      call new_chain(right, self%rods, 1.0_wp, self%l, self%g, error)
      call right%jacobian(at, a)
   end subroutine right_jacobian

   subroutine wrong_entries(self, at, values)
      use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
      class(wrong_chain_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: values(:)

      call self%chain_t%jacobian_entries(at, values)
      if (self%mistake == 'wrong entry') values(5) = 1.1_wp*values(5) + 0.1_wp
      if (self%mistake == 'not set') values(5) = ieee_value(1.0_wp, ieee_quiet_nan)
   end subroutine wrong_entries

end module test_chain
