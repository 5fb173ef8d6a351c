!> Tests of the N-four-bar, where positions are singular.
module test_n_four_bar
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
   use taut_linalg_normal_solver_choose, only: solver_names
   use taut_model_n_four_bar, only: n_four_bar_t, new_n_four_bar
   use taut_ode_options, only: integration_options_t, integration_result_t
   implicit none (type, external)
   private
   public :: collect_n_four_bar

contains

   !> All tests of this module.
   function collect_n_four_bar() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('an N-four-bar is correct', four_bar_verified), &
               new_test('an N-four-bar through its singular positions', four_bar_motion), &
               new_test('an N-four-bar in a singular position', four_bar_rank)]
   end function collect_n_four_bar

   subroutine four_bar_verified(failure)
      character(:), allocatable, intent(inout) :: failure
      type(n_four_bar_t) :: bars
      type(error_t), allocatable :: error
      type(finding_t), allocatable :: findings(:)
      type(state_t) :: at

      call restart_random()
      call new_n_four_bar(bars, 3, 1.3_wp, 0.7_wp, 9.81_wp, error)
      call bars%start(0.4_wp, 2.0_wp, at)
      at%x = at%x + 0.1_wp*random_vector(bars%n)
      at%v = random_vector(bars%n)
      call verify(bars, at, findings, error)
      call no_error(failure, error)
      if (size(findings) > 0) call check(failure, .false., findings(1)%message)
      call check(failure, bars%x_name(1) == 'Bx0' .and. bars%x_name(4) == 'Cz1' .and. bars%v_name(6) == 'vBz1', 'names')
      ! The mass matrix of a rod is m/6 [2 1; 1 2]: with all points at one velocity u the rods' energy is (N + 1)/3 + N halves
      ! of m u^2.
      call bars%start(0.5_wp*acos(-1.0_wp), 2.0_wp, at)
      call check_below(failure, bars%energy(at) - 0.5_wp*1.3_wp*4.0_wp*(4.0_wp/3.0_wp + 3.0_wp), 1.0e-12_wp, 'kinetic energy')
      call new_n_four_bar(bars, 0, 1.0_wp, 1.0_wp, 9.81_wp, error)
      call check(failure, allocated(error), 'a mechanism without windows')
   end subroutine four_bar_verified

   !> All cranks share one angle: theta'' = g/l sin(theta) (3N + 1)/2/((4N + 1)/3), here by small classical steps. From the
   !! vertical they pass the line of the pivots twice in each turn, where other motions branch off.
   subroutine four_bar_motion(failure)
      character(:), allocatable, intent(inout) :: failure
      type(n_four_bar_t) :: bars
      type(error_t), allocatable :: error
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(method_t) :: method
      type(state_t) :: at
      real(wp) :: angle, factor, h, k1(2), k2(2), k3(2), k4(2), q(2), reached
      integer :: i, n
      character(len=8), parameter :: stages(2) = [character(len=8) :: 'newton', 'none']

      options%rtol = 1.0e-9_wp
      options%atol = 1.0e-9_wp
      h = 1.0e-4_wp
      do n = 1, 6, 5
         factor = 9.81_wp*0.5_wp*(3*n + 1)/((4*n + 1)/3.0_wp)
         q = [0.0_wp, 1.0_wp]
         angle = 0.0_wp
         do i = 1, 20000
            k1 = rate(q)
            k2 = rate(q + 0.5_wp*h*k1)
            k3 = rate(q + 0.5_wp*h*k2)
            k4 = rate(q + h*k3)
            q = q + h/6.0_wp*(k1 + 2.0_wp*k2 + 2.0_wp*k3 + k4)
            angle = max(angle, q(1))
         end do
         reached = angle
         call check(failure, reached > 1.5_wp*acos(-1.0_wp), 'the mechanism does not pass both singular positions')
         do i = 1, 2
            method%stage_projection = stages(i)
            call new_n_four_bar(bars, n, 1.0_wp, 1.0_wp, 9.81_wp, error)
            call bars%start(0.0_wp, 1.0_wp, at)
            call simulate(bars, at, 2.0_wp, result, error, method, options)
            call no_error(failure, error)
            call check_below(failure, norm2(at%x(1:2) - [sin(q(1)), cos(q(1))]), 2.0e-6_wp, &
                             'the first tip, N = '//to_text(n)//', '//stages(i))
         end do
      end do

   contains

      pure function rate(state) result(r)
         real(wp), intent(in) :: state(2)
         real(wp) :: r(2)

         r = [state(2), factor*sin(state(1))]
      end function rate

   end subroutine four_bar_motion

   !> With all rods in one line the rank drops by N, and the multipliers are those of minimum norm with every solver.
   subroutine four_bar_rank(failure)
      character(:), allocatable, intent(inout) :: failure
      integer, parameter :: n = 4
      type(n_four_bar_t) :: bars
      class(constrained_ode_t), allocatable :: ode
      type(method_t) :: method
      type(error_t), allocatable :: error
      type(state_t) :: at
      type(sample_t) :: s
      real(wp) :: expected(4*n + 1), y(4*(2*n + 1)), z(size(y)), mu(4*n + 1)
      integer :: i, info

      call new_n_four_bar(bars, n, 1.0_wp, 1.0_wp, 9.81_wp, error)
      call bars%start(0.5_wp*acos(-1.0_wp), 3.0_wp, at)
      at%x(2::2) = 0.0_wp
      ! Along the rods, against the constraints, so that there are multipliers of both levels.
      at%v(1::2) = 0.1_wp*[(sin(real(i, wp)), i=1, 2*n + 1)]
      do i = 1, size(solver_names)
         method%solver = solver_names(i)
         call new_constrained_ode(ode, bars, method, error)
         call no_error(failure, error)
         call ode%pack(at, y)
         call ode%rhs(0.0_wp, y, z, info)
         call ode%sample(0.0_wp, y, s, info)
         call check(failure, info == 0 .and. s%rank == 3*n + 1, 'rank '//to_text(s%rank)//' with '//trim(method%solver))
         if (i == 1) then
            expected = s%lambda
            mu = s%mu
         end if
         call check_below(failure, maxval(abs(s%lambda - expected)), 1.0e-9_wp, 'lambda with '//trim(method%solver))
         call check_below(failure, maxval(abs(s%mu - mu)), 1.0e-9_wp, 'mu with '//trim(method%solver))
      end do
   end subroutine four_bar_rank

end module test_n_four_bar
