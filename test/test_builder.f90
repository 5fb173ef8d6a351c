!> Tests of building a mechanism part by part.
module test_builder
   use taut, only: error_t, integration_options_t, integration_result_t, mechanism_builder_t, mechanism_t, simulate, state_t, &
                   status_reached_end, wp
   use taut_name_index, only: name_index_t
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_builder

   real(wp), parameter :: o(3) = 0.0_wp

contains

   !> All tests of this module.
   function collect_builder() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('names are found again', names_found), &
               new_test('a double pendulum keeps its energy and its joints', double_pendulum), &
               new_test('a spring, a load and an event', spring_and_load), &
               new_test('what is wrong first is told', faults)]
   end function collect_builder

   subroutine names_found(failure)
      character(:), allocatable, intent(inout) :: failure
      type(name_index_t) :: index
      character(len=8) :: name
      integer :: i

      call check(failure, index%find('a') == 0, 'an empty index')
      do i = 1, 1000
         write (name, '(a, i0)') 'rod', i
         call index%add(name, i)
      end do
      do i = 1, 1000
         write (name, '(a, i0)') 'rod', i
         call check(failure, index%find(name) == i, 'its number')
      end do
      call check(failure, index%find('rod0') == 0 .and. index%count == 1000, 'no other')
      call index%add('rod7', 5)
      call check(failure, index%find('rod7') == 5 .and. index%count == 1000, 'a number is replaced')
   end subroutine names_found

   !> Two rods in space, hinged about y.
   subroutine build(builder)
      type(mechanism_builder_t), intent(inout) :: builder

      builder%gravity = [0.0_wp, 0.0_wp, -9.81_wp]
      call builder%add_body('upper', mass=1.0_wp, shape='rod', from=o, to=[1.0_wp, 0.0_wp, 0.0_wp])
      call builder%add_body('lower', mass=1.0_wp, shape='rod', from=[1.0_wp, 0.0_wp, 0.0_wp], to=[2.0_wp, 0.0_wp, 0.0_wp])
      call builder%add_joint('A', 'revolute', 'ground', 'upper', point=o, axis=[0.0_wp, 1.0_wp, 0.0_wp])
      call builder%add_joint('B', 'revolute', 'upper', 'lower', point=[1.0_wp, 0.0_wp, 0.0_wp], axis=[0.0_wp, 1.0_wp, 0.0_wp])
   end subroutine build

   subroutine double_pendulum(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      real(wp) :: energy
      real(wp), allocatable :: phi(:)

      call build(builder)
      call builder%complete(mechanism, at, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      call check(failure, mechanism%n == 12 .and. mechanism%c == 10, 'sizes')
      energy = mechanism%energy(at)
      call simulate(mechanism, at, 1.0_wp, result, error, options=integration_options_t(rtol=1.0e-9_wp, atol=1.0e-12_wp))
      call no_error(failure, error)
      call check(failure, result%status == status_reached_end, 'the end is reached')
      call check_close(failure, mechanism%energy(at), energy, 1.0e-6_wp, 'energy')
      allocate (phi(mechanism%n_phi))
      call mechanism%constraint(at, phi)
      call check_below(failure, maxval(abs(phi)), 1.0e-12_wp, 'joints')
   end subroutine double_pendulum

   subroutine spring_and_load(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp) :: f(3), g(1)

      call builder%add_point_mass('m', mass=2.0_wp, position=[2.0_wp, 0.0_wp, 0.0_wp])
      call builder%add_ground_point('P', o)
      call builder%add_spring('P', 'm', stiffness=10.0_wp, free_length=1.5_wp)
      call builder%add_load('m', [0.0_wp, 3.0_wp, 0.0_wp])
      call builder%add_event('passes', 'x', 1.25_wp, point='m')
      call builder%complete(mechanism, at, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      call mechanism%force(at, f)
      ! Tension 10 (2 - 1.5) towards P.
      call check_below(failure, maxval(abs(f - [-5.0_wp, 3.0_wp, 0.0_wp])), 1.0e-14_wp, 'force')
      call mechanism%event_values(at, g)
      call check_close(failure, g(1), 0.75_wp, 1.0e-15_wp, 'event')
   end subroutine spring_and_load

   subroutine faults(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(error_t), allocatable :: error

      call build(builder)
      call builder%add_joint('C', 'revolute', 'upper', 'louver', point=o, axis=[0.0_wp, 1.0_wp, 0.0_wp])
      call builder%add_joint('A', 'welded', 'upper', 'lower')
      call builder%complete(mechanism, at, error)
      call check(failure, allocated(error), 'it is told')
      if (allocated(failure)) return
      call check(failure, index(error%line(), 'joint "C": body_2 = "louver"') == 1, 'the first one: '//error%line())
      deallocate (error, builder%error)
      call builder%add_joint('A', 'spherical', 'upper', 'lower', point=o)
      call builder%complete(mechanism, at, error)
      call check(failure, index(error%line(), 'joint "A": the name is taken') == 1, error%line())
      deallocate (error, builder%error)
      call builder%add_body('x', mass=1.0_wp)
      call builder%complete(mechanism, at, error)
      call check(failure, index(error%line(), 'body "x": it has neither inertia nor shape') == 1, error%line())
   end subroutine faults

end module test_builder
