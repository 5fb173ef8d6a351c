!> Equilibrium and modes of large systems, where matrices are sparse: closed forms, and the same findings as of small ones.
module test_large_statics
   use beams, only: slender_beam
   use taut, only: eigenmodes, equilibrium, equilibrium_options_t, equilibrium_result_t, error_t, mechanism_builder_t, &
                   mechanism_t, modes_options_t, modes_t, state_t, wp
   use taut_model_beam, only: beam_t, new_beam, straight_nodes
   use taut_model_beam_section, only: beam_section_t, new_section
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_large_statics

   real(wp), parameter :: pi = acos(-1.0_wp), zero(3) = 0.0_wp, x(3) = [1.0_wp, 0.0_wp, 0.0_wp], y(3) = [0.0_wp, 1.0_wp, 0.0_wp], &
                          z(3) = [0.0_wp, 0.0_wp, 1.0_wp]

contains

   !> All tests of this module.
   function collect_large_statics() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('a small load on many elements: beam theory', small_load), &
               new_test('the elastica takes as many iterations on any mesh', elastica), &
               new_test('many elements: redundant supports share the reaction', shared), &
               new_test('many elements: a free beam has six motions, which may not be loaded', free_beam), &
               new_test('a long chain of springs hangs', hanging_chain), &
               new_test('a slack chain across its load is told, short or long', slack_chain), &
               new_test('a few modes are the lowest of all', lowest), &
               new_test('equal modes and free motions are all counted', equal_modes), &
               new_test('buckling is seen among the lowest modes', buckling), &
               new_test('modes with damping of many elements', damped)]
   end function collect_large_statics

   !> A cantilever with a load at its tip.
   subroutine cantilever(elements, force, steps, at, found, failure)
      integer, intent(in) :: elements, steps
      real(wp), intent(in) :: force(3)
      type(state_t), intent(out) :: at
      type(equilibrium_result_t), intent(out) :: found
      character(:), allocatable, intent(inout) :: failure
      type(beam_t) :: beam
      type(equilibrium_options_t) :: options
      type(error_t), allocatable :: error

      beam = slender_beam(elements)
      call beam%clamp(1, error)
      call beam%add_load(elements + 1, force, zero, error)
      at = beam%reference_state()
      options%steps = steps
      call equilibrium(beam, at, found, error, options)
      call no_error(failure, error)
   end subroutine cantilever

   !> w = P L^3/(3 EI) + P L/GA.
   subroutine small_load(failure)
      character(:), allocatable, intent(inout) :: failure
      type(state_t) :: at
      type(equilibrium_result_t) :: found
      real(wp), parameter :: p = 1.0e-6_wp
      integer, parameter :: n = 96

      call cantilever(n, p*y, 1, at, found, failure)
      if (allocated(failure)) return
      call check_close(failure, at%x(7*n + 2)/p, 1.0_wp/3.0_wp + 1.0e-6_wp, 1.0e-8_wp, 'deflection')
      call check_close(failure, 2.0_wp*at%x(7*n + 7)/p, 0.5_wp, 1.0e-8_wp, 'slope')
      call check(failure, found%free_motions == 0 .and. found%rank == 6 .and. found%iterations <= 3, 'nothing is free')
   end subroutine small_load

   !> P L^2/EI = 10, K. Mattiasson (1981): w/L = 0.81061, u/L = 0.55500.
   subroutine elastica(failure)
      character(:), allocatable, intent(inout) :: failure
      type(state_t) :: at
      type(equilibrium_result_t) :: coarse, fine
      integer, parameter :: n = 48

      call cantilever(8, 10.0_wp*y, 4, at, coarse, failure)
      call cantilever(n, 10.0_wp*y, 4, at, fine, failure)
      if (allocated(failure)) return
      call check_close(failure, at%x(7*n + 2), 0.81061_wp, 1.0e-4_wp, 'deflection')
      call check_close(failure, 1.0_wp - at%x(7*n + 1), 0.55500_wp, 1.0e-4_wp, 'shortening')
      call check(failure, abs(fine%iterations - coarse%iterations) <= 2, 'iterations')
   end subroutine elastica

   !> A clamp and a pin on one node.
   subroutine shared(failure)
      character(:), allocatable, intent(inout) :: failure
      type(beam_t) :: beam
      type(state_t) :: at
      type(equilibrium_result_t) :: found
      type(error_t), allocatable :: error

      beam = slender_beam(16)
      call beam%clamp(1, error)
      call beam%pin(1, error)
      call beam%add_load(17, 0.3_wp*y - 0.2_wp*z, zero, error)
      at = beam%reference_state()
      call equilibrium(beam, at, found, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      call check(failure, found%rank == 6, 'six rows of nine count')
      call check_close(failure, found%lambda(2), 0.15_wp, 1.0e-8_wp, 'half the force')
      call check_close(failure, found%lambda(8), 0.15_wp, 1.0e-8_wp, 'the other half')
      call check_close(failure, found%lambda(3), -0.1_wp, 1.0e-8_wp, 'half the other force')
   end subroutine shared

   subroutine free_beam(failure)
      character(:), allocatable, intent(inout) :: failure
      type(beam_t) :: beam
      type(modes_t) :: modes
      type(modes_options_t) :: options
      type(state_t) :: at
      type(equilibrium_result_t) :: found
      type(error_t), allocatable :: error

      beam = slender_beam(32)
      ! Forces that balance each other.
      call beam%add_load(1, -0.1_wp*x, zero, error)
      call beam%add_load(33, 0.1_wp*x, zero, error)
      at = beam%reference_state()
      call equilibrium(beam, at, found, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      call check(failure, found%free_motions == 4, 'it goes anywhere and turns about itself')
      call check_close(failure, at%x(7*32 + 1) - at%x(1), 1.0_wp + 1.0e-7_wp, 1.0e-10_wp, 'it is stretched')
      options%number = 8
      beam = slender_beam(32)
      call eigenmodes(beam, beam%reference_state(), modes, error, options)
      call no_error(failure, error)
      if (allocated(failure)) return
      call check(failure, modes%free_motions == 6, 'six motions of 0 Hz')
      call check_close(failure, 2.0_wp*pi*modes%frequency(7), 4.7300407_wp**2, 0.2_wp, 'the first of the others')
      call beam%add_load(33, y, zero, error)
      at = beam%reference_state()
      call equilibrium(beam, at, found, error)
      call check(failure, allocated(error), 'it may not be loaded')
      if (.not. allocated(error)) return
      call check(failure, index(error%line(), 'nothing resists') > 0, error%line())
   end subroutine free_beam

   !> Equal masses on equal springs along a line, fixed at one end.
   subroutine chain_of(masses, direction, mechanism, at, failure)
      integer, intent(in) :: masses
      real(wp), intent(in) :: direction(3)
      type(mechanism_t), intent(out) :: mechanism
      type(state_t), intent(out) :: at
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(error_t), allocatable :: error
      character(len=8) :: last, name
      integer :: i

      builder%gravity = -10.0_wp*z
      last = 'ground'
      do i = 1, masses
         write (name, '(a, i0)') 'm', i
         call builder%add_point_mass(trim(name), mass=0.01_wp, position=0.01_wp*i*direction)
         if (i == 1) then
            call builder%add_spring('ground', trim(name), point_1=zero, stiffness=1.0e6_wp)
         else
            call builder%add_spring(trim(last), trim(name), stiffness=1.0e6_wp)
         end if
         last = name
      end do
      call builder%complete(mechanism, at, error)
      call no_error(failure, error)
   end subroutine chain_of

   !> Spring i carries the masses below it: the last mass goes down by m g N (N + 1)/(2 k).
   subroutine hanging_chain(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(equilibrium_result_t) :: found
      type(modes_t) :: modes
      type(modes_options_t) :: options
      type(error_t), allocatable :: error
      integer, parameter :: n = 200

      call chain_of(n, -z, mechanism, at, failure)
      if (allocated(failure)) return
      call equilibrium(mechanism, at, found, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      call check_close(failure, at%x(3*n), -0.01_wp*n - 0.1_wp*n*(n + 1)/2.0e6_wp, 1.0e-9_wp, 'the lowest mass')
      call check(failure, found%free_motions == 0 .and. found%iterations <= 3, 'slack across itself at first, and then no more')
      options%number = 2
      call eigenmodes(mechanism, at, modes, error, options)
      call no_error(failure, error)
      if (allocated(failure)) return
      call check(failure, modes%free_motions == 0 .and. modes%complete .and. modes%growth(1) <= 0.0_wp, 'stable when it hangs')
      ! A chain of many links swings with the first zero of J0, 2.404826/2 sqrt(g/L), of N + 1/2 links; these are stretched a little.
      call check_close(failure, 2.0_wp*pi*modes%frequency(1), 1.202413_wp*sqrt(1000.0_wp/(n + 0.5_wp)), 3.0e-3_wp, 'it swings')
      call check_close(failure, modes%frequency(2), modes%frequency(1), 1.0e-8_wp, 'both ways')
   end subroutine hanging_chain

   subroutine slack_chain(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(equilibrium_result_t) :: found
      type(error_t), allocatable :: error
      integer :: i

      do i = 1, 2
         call chain_of(merge(8, 30, i == 1), [0.8_wp, 0.0_wp, -0.6_wp], mechanism, at, failure)
         if (allocated(failure)) return
         call equilibrium(mechanism, at, found, error)
         call check(failure, allocated(error), 'nothing resists across the chain')
         if (.not. allocated(error)) return
         call check(failure, index(error%line(), 'a motion that nothing resists is loaded') > 0, error%line())
         deallocate (error)
      end do
   end subroutine slack_chain

   subroutine lowest(failure)
      character(:), allocatable, intent(inout) :: failure
      type(beam_t) :: beam
      type(modes_t) :: all_modes, few
      type(modes_options_t) :: options
      type(error_t), allocatable :: error
      integer :: i

      beam = slender_beam(20)
      call beam%clamp(1, error)
      options%number = 7
      call eigenmodes(beam, beam%reference_state(), all_modes, error)
      call eigenmodes(beam, beam%reference_state(), few, error, options)
      call no_error(failure, error)
      if (allocated(failure)) return
      call check(failure, size(few%frequency) == 7 .and. size(all_modes%frequency) == 120, 'as many as were asked for')
      if (allocated(failure)) return
      call check_below(failure, maxval(abs(few%frequency/all_modes%frequency(:7) - 1.0_wp)), 1.0e-7_wp, 'the same frequencies')
      do i = 1, 7
         call check_close(failure, modal_mass(few%shapes(:, i)), 1.0_wp, 1.0e-9_wp, 'unit modal mass')
         call check_below(failure, norm2(few%shapes(1:6, i)), 1.0e-9_wp, 'the clamp holds')
      end do

   contains

      real(wp) function modal_mass(shape)
         real(wp), intent(in) :: shape(:)
         integer :: node

         modal_mass = 0.0_wp
         do node = 1, beam%nodes
            associate (u => shape(6*node - 5:6*node - 3), r => shape(6*node - 2:6*node))
               modal_mass = modal_mass + beam%m(node)*sum(u**2) + dot_product(r, matmul(beam%inertia(:, :, node), r))
            end associate
         end do
      end function modal_mass

   end subroutine lowest

   !> Equal masses, each on a spring of its own: f = sqrt(k/m)/(2 pi), and two motions of each that nothing resists.
   subroutine equal_modes(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(modes_t) :: modes
      type(modes_options_t) :: options
      type(error_t), allocatable :: error
      character(len=8) :: name
      integer :: i
      integer, parameter :: n = 30

      do i = 1, n
         write (name, '(a, i0)') 'm', i
         call builder%add_point_mass(trim(name), mass=2.0_wp, position=[1.0_wp, real(i, wp), 0.0_wp])
         call builder%add_spring('ground', trim(name), point_1=[0.0_wp, real(i, wp), 0.0_wp], stiffness=800.0_wp)
      end do
      call builder%complete(mechanism, at, error)
      options%number = 12
      if (.not. allocated(error)) call eigenmodes(mechanism, at, modes, error, options)
      call no_error(failure, error)
      if (allocated(failure)) return
      call check(failure, modes%free_motions == 2*n .and. size(modes%frequency) >= 2*n + 1, 'free motions')
      call check_close(failure, modes%frequency(2*n + 1), 10.0_wp/pi, 1.0e-7_wp, 'the others')
   end subroutine equal_modes

   !> Euler's load of a cantilever, pi^2/4 EI/L^2.
   subroutine buckling(failure)
      character(:), allocatable, intent(inout) :: failure
      type(beam_t) :: beam
      type(modes_t) :: all_modes, few
      type(modes_options_t) :: options
      type(state_t) :: at
      type(equilibrium_result_t) :: found
      type(error_t), allocatable :: error
      real(wp), parameter :: parts(3) = [0.95_wp, 1.05_wp, 10.0_wp]
      integer :: i

      options%number = 1
      do i = 1, 3
         beam = slender_beam(20)
         call beam%clamp(1, error)
         call beam%add_load(21, -parts(i)*0.25_wp*pi**2*x, zero, error)
         at = beam%reference_state()
         call equilibrium(beam, at, found, error)
         if (.not. allocated(error)) call eigenmodes(beam, at, few, error, options)
         if (.not. allocated(error)) call eigenmodes(beam, at, all_modes, error)
         call no_error(failure, error)
         if (allocated(failure)) return
         call check(failure, few%complete .and. (any(few%growth > 0.0_wp) .eqv. i > 1), 'stable up to its load')
         call check_close(failure, maxval(few%growth), maxval(all_modes%growth), 1.0e-6_wp*maxval(all_modes%growth), 'the growth')
         call check(failure, count(few%growth > 0.0_wp) == count(all_modes%growth > 0.0_wp), 'in as many ways')
      end do
   end subroutine buckling

   !> With moments stiffness (strain + tau strain rate), each mode of its own: growth = -tau omega^2/2.
   subroutine damped(failure)
      character(:), allocatable, intent(inout) :: failure
      type(beam_t) :: beam
      type(beam_section_t) :: section
      type(modes_t) :: modes
      type(modes_options_t) :: options
      type(error_t), allocatable :: error
      real(wp), allocatable :: positions(:, :), orientations(:, :), omega(:)
      real(wp) :: stiffness(6, 6)
      real(wp), parameter :: tau = 1.0e-3_wp
      integer :: i

      stiffness = 0.0_wp
      do i = 1, 6
         stiffness(i, i) = merge(1.0e4_wp, real(i, wp), i <= 3)
      end do
      call new_section(section, stiffness, 1.0_wp, [1.0e-2_wp, 0.5e-2_wp, 0.5e-2_wp], error)
      call straight_nodes(zero, x, 170, y, positions, orientations)
      call new_beam(beam, positions, orientations, section, error, damping=tau)
      call beam%clamp(1, error)
      options%number = 4
      call eigenmodes(beam, beam%reference_state(), modes, error, options)
      call no_error(failure, error)
      if (allocated(failure)) return
      call check(failure, modes%damped .and. .not. modes%complete, 'not all is looked at')
      omega = hypot(2.0_wp*pi*modes%frequency, modes%growth)
      call check_below(failure, maxval(abs(modes%growth/(0.5_wp*tau*omega**2) + 1.0_wp)), 1.0e-5_wp, 'damping')
      ! What shear, rotary inertia and a finer mesh make of 1.875104^2 sqrt(5).
      call check_close(failure, omega(1), 7.7635_wp, 1.0e-3_wp, 'frequency')
   end subroutine damped

end module test_large_statics
