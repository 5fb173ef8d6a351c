!> Mass matrices that are singular, but definite along the constraints.
module test_completion
   use taut, only: block_diagonal_t, consistent_start, constrained_ode_t, error_t, finding_t, integration_options_t, &
                   integration_result_t, mechanical_system_t, method_t, observer_t, ode_system_t, rotate, sample_t, simulate, &
                   start_report_t, state_t, verify, wp
   use testing, only: check, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_completion

   real(wp), parameter :: mass_of_bob = 2.0_wp, length = 0.7_wp, gravity = 9.81_wp
   real(wp), parameter :: inertia(3) = [1.0_wp, 2.0_wp, 3.0_wp]

   !> A pendulum in x, y and its angle, which has no mass of its own: x = L sin q, y = -L cos q, rows multiplied with `scale`.
   type, extends(mechanical_system_t) :: bob_t
      real(wp) :: scale(2) = 1.0_wp, mass_of_angle = 0.0_wp
   contains
      procedure :: mass
      procedure :: force
      procedure :: constraint
      procedure :: jacobian
      procedure :: acceleration_rhs
   end type bob_t

   !> A body that no moment acts on, in the rates of its quaternion: M = 4 G^T J G is singular along the quaternion; from there it may
   !! be filled up.
   type, extends(mechanical_system_t) :: spinning_t
      real(wp) :: filling = 0.0_wp
   contains
      procedure :: mass => spinning_mass
      procedure :: force => spinning_force
      procedure :: constraint => unit_length
      procedure :: jacobian => unit_length_row
      procedure :: acceleration_rhs => unit_length_rhs
   end type spinning_t

   !> Keeps the multipliers of the last point.
   type, extends(observer_t) :: keeper_t
      type(sample_t) :: sample = sample_t()
   contains
      procedure :: observe
   end type keeper_t

contains

   !> All tests of this module.
   function collect_completion() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('a coordinate without mass, rows of any scale, every method', massless), &
               new_test('the rates of a quaternion', quaternion_rates), &
               new_test('a blow in a singular metric', blow), &
               new_test('an indefinite M is refused by coordinate', indefinite), &
               new_test('methods without multipliers refuse a singular M', refused), &
               new_test('verify has nothing against it', verified)]
   end function collect_completion

   subroutine mass(self, at, m)
      class(bob_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m
      real(wp) :: k(3, 3)

      k = 0.0_wp
      k(1, 1) = mass_of_bob
      k(2, 2) = mass_of_bob
      k(3, 3) = self%mass_of_angle
      call m%set_dense(k)
      associate (unused_state => at)
      end associate
   end subroutine mass

   subroutine force(self, at, value)
      class(bob_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = [0.0_wp, -mass_of_bob*gravity, 0.0_wp]
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine force

   subroutine constraint(self, at, value)
      class(bob_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(1) = self%scale(1)*(at%x(1) - length*sin(at%x(3)))
      value(2) = self%scale(2)*(at%x(2) + length*cos(at%x(3)))
   end subroutine constraint

   subroutine jacobian(self, at, a)
      class(bob_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)

      a(1, :) = self%scale(1)*[1.0_wp, 0.0_wp, -length*cos(at%x(3))]
      a(2, :) = self%scale(2)*[0.0_wp, 1.0_wp, -length*sin(at%x(3))]
   end subroutine jacobian

   subroutine acceleration_rhs(self, at, value)
      class(bob_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(1) = -self%scale(1)*length*sin(at%x(3))*at%v(3)**2
      value(2) = self%scale(2)*length*cos(at%x(3))*at%v(3)**2
   end subroutine acceleration_rhs

   subroutine observe(self, ode, t, h, y, error)
      class(keeper_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t, h
      real(wp), intent(in), contiguous :: y(:)
      type(error_t), allocatable, intent(inout) :: error
      integer :: info

      select type (ode)
      class is (constrained_ode_t)
         call ode%sample(t, y, self%sample, info)
      end select
      associate (unused_step => h, unused_error => error)
      end associate
   end subroutine observe

   function bob(scale) result(system)
      real(wp), intent(in) :: scale(2)
      type(bob_t) :: system

      system%scale = scale
      call system%define(n=3, c=2, constant_mass=.true.)
   end function bob

   !> At an angle of 1, turning at a rate of 2.
   function start() result(at)
      type(state_t) :: at

      at%x = [length*sin(1.0_wp), -length*cos(1.0_wp), 1.0_wp]
      at%v = 2.0_wp*[length*cos(1.0_wp), length*sin(1.0_wp), 1.0_wp]
   end function start

   subroutine massless(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=19), parameter :: names(4) = [character(len=19) :: 'present', 'baseline', 'minimal-coordinates', 'present']
      real(wp), parameter :: scales(2, 3) = reshape([1.0_wp, 1.0_wp, 1.0e-6_wp, 1.0e6_wp, 1.0e6_wp, 1.0e-6_wp], [2, 3])
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(keeper_t) :: keeper
      type(method_t) :: method
      type(state_t) :: at, first
      type(error_t), allocatable :: error
      character(:), allocatable :: what
      real(wp) :: pull
      integer :: i, k

      options = integration_options_t(rtol=1.0e-10_wp, atol=1.0e-11_wp)
      do i = 1, size(names)
         do k = 1, size(scales, 2)
            method = method_t(name=names(i), form=merge('force       ', 'acceleration', i == 2))
            if (i == 4) method%weight = 'mass'
            at = start()
            keeper = keeper_t()
            what = trim(names(i))//': '
            call simulate(bob(scales(:, k)), at, 1.0_wp, result, error, method=method, options=options, observer=keeper)
            call no_error(failure, error)
            if (allocated(failure)) return
            associate (q => at%x(3), rate => at%v(3))
               call check_close(failure, rate**2, 4.0_wp + 2.0_wp*gravity/length*(cos(q) - cos(1.0_wp)), 1.0e-6_wp, what//'rate')
               pull = mass_of_bob*(length*rate**2 + gravity*cos(q))
               call check_close(failure, keeper%sample%lambda(1)*scales(1, k), pull*sin(q), 1.0e-6_wp, what//'lambda 1')
               call check_close(failure, keeper%sample%lambda(2)*scales(2, k), -pull*cos(q), 1.0e-6_wp, what//'lambda 2')
            end associate
            if (i == 1 .and. k == 1) first = at
            call check_close(failure, at%x(3), first%x(3), 2.0e-8_wp, what//'the same whatever the scale')
         end do
      end do
   end subroutine massless

   !> A bob that falls on its rod loses what it has along it.
   subroutine blow(failure)
      character(:), allocatable, intent(inout) :: failure
      type(start_report_t) :: report
      type(state_t) :: at
      type(error_t), allocatable :: error

      at = start()
      at%v = [0.0_wp, -1.0_wp, 0.0_wp]
      call consistent_start(bob([1.0_wp, 1.0e3_wp]), method_t(), at, report, error)
      call no_error(failure, error)
      call check_close(failure, at%v(3), -sin(1.0_wp)/length, 1.0e-12_wp, 'rate')
      call check_close(failure, report%energy_gained, -0.5_wp*mass_of_bob*cos(1.0_wp)**2, 1.0e-12_wp, 'energy')
      call check_close(failure, report%impulse(1), mass_of_bob*cos(1.0_wp)*sin(1.0_wp), 1.0e-11_wp, 'impulse 1')
      call check_close(failure, report%impulse(2)*1.0e3_wp, -mass_of_bob*cos(1.0_wp)**2, 1.0e-11_wp, 'impulse 2')
   end subroutine blow

   !> Angular velocity in body axes: 2 G qdot.
   pure function two_g(q) result(g)
      real(wp), intent(in) :: q(4)
      real(wp) :: g(3, 4)

      g(1, :) = 2.0_wp*[-q(2), q(1), q(4), -q(3)]
      g(2, :) = 2.0_wp*[-q(3), -q(4), q(1), q(2)]
      g(3, :) = 2.0_wp*[-q(4), q(3), -q(2), q(1)]
   end function two_g

   subroutine spinning_mass(self, at, m)
      class(spinning_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m
      real(wp) :: g(3, 4), k(4, 4)
      integer :: i, j

      g = two_g(at%x)
      do j = 1, 4
         do i = 1, 4
            k(i, j) = sum(g(:, i)*inertia*g(:, j)) + self%filling*at%x(i)*at%x(j)
         end do
      end do
      call m%set_dense(k)
   end subroutine spinning_mass

   subroutine spinning_force(self, at, value)
      class(spinning_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = -2.0_wp*matmul(transpose(two_g(at%v)), inertia*matmul(two_g(at%x), at%v))
      associate (unused_system => self)
      end associate
   end subroutine spinning_force

   subroutine unit_length(self, at, value)
      class(spinning_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = 0.5_wp*(sum(at%x**2) - 1.0_wp)
      associate (unused_system => self)
      end associate
   end subroutine unit_length

   subroutine unit_length_row(self, at, a)
      class(spinning_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)

      a(1, :) = at%x
      associate (unused_system => self)
      end associate
   end subroutine unit_length_row

   subroutine unit_length_rhs(self, at, value)
      class(spinning_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = -sum(at%v**2)
      associate (unused_system => self)
      end associate
   end subroutine unit_length_rhs

   !> Angular momentum in global axes stays, from a start where some pivots of M are small and one is nothing but round-off.
   subroutine quaternion_rates(failure)
      character(:), allocatable, intent(inout) :: failure
      type(spinning_t) :: system
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(state_t) :: at, filled
      type(error_t), allocatable :: error
      real(wp), parameter :: omega(3) = [0.01_wp, 5.0_wp, 0.02_wp]

      options = integration_options_t(rtol=1.0e-8_wp, atol=1.0e-10_wp)
      call system%define(n=4, c=1)
      at%x = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      at%v = 0.25_wp*matmul(transpose(two_g(at%x)), omega)
      allocate (at%w(0))
      filled = at
      call simulate(system, at, 2.0_wp, result, error, options=options)
      call no_error(failure, error)
      if (allocated(failure)) return
      call check(failure, result%steps < 300, 'steps')
      associate (momentum => inertia*matmul(two_g(at%x), at%v))
         call check_close(failure, norm2(rotate(at%x, momentum) - inertia*omega), 0.0_wp, 1.0e-6_wp, 'angular momentum')
      end associate
      system%filling = 1.0_wp
      call simulate(system, filled, 2.0_wp, result, error, options=options)
      call no_error(failure, error)
      call check_close(failure, maxval(abs([at%x - filled%x, at%v - filled%v])), 0.0_wp, 1.0e-6_wp, 'M that is filled up')
   end subroutine quaternion_rates

   subroutine indefinite(failure)
      character(:), allocatable, intent(inout) :: failure
      type(bob_t) :: system
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error

      system = bob([1.0_wp, 1.0_wp])
      system%mass_of_angle = -1.0e-3_wp
      at = start()
      call simulate(system, at, 1.0_wp, result, error, look=.false.)
      if (.not. allocated(error)) call move_alloc(result%error, error)
      call check(failure, allocated(error), 'it is not reported')
      if (allocated(failure)) return
      call check(failure, index(error%what, 'at velocity 3') > 0, error%line())
   end subroutine indefinite

   subroutine refused(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=13), parameter :: names(2) = ['penalty      ', 'unconstrained']
      type(integration_result_t) :: result
      type(method_t) :: method
      type(state_t) :: at
      type(error_t), allocatable :: error
      integer :: i

      do i = 1, size(names)
         method = method_t(name=names(i), stiffness=1.0e3_wp)
         at = start()
         call simulate(bob([1.0_wp, 1.0_wp]), at, 1.0_wp, result, error, method=method, look=.false.)
         if (.not. allocated(error)) call move_alloc(result%error, error)
         call check(failure, allocated(error), trim(names(i))//': it is not reported')
         if (allocated(failure)) return
         call check(failure, index(error%what, 'a method with multipliers') > 0, error%line())
         deallocate (error)
      end do
   end subroutine refused

   subroutine verified(failure)
      character(:), allocatable, intent(inout) :: failure
      type(finding_t), allocatable :: findings(:)
      type(error_t), allocatable :: error

      call verify(bob([1.0_wp, 1.0_wp]), start(), findings, error)
      call no_error(failure, error)
      call check(failure, size(findings) == 0, 'a finding')
   end subroutine verified

end module test_completion
