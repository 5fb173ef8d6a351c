!> Eigenanalysis: Table 1 of the paper, closed forms of beam theory, loaded configurations, other systems.
module test_modes
   use beams, only: slender_beam, swing_beam
   use taut_kinds, only: wp
   use taut_error, only: error_t
   use taut_constrained_equilibrium, only: equilibrium, equilibrium_options_t, equilibrium_result_t
   use taut_constrained_modes, only: eigenmodes, modes_options_t, modes_t
   use taut_constrained_system, only: state_t
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_model_beam, only: beam_t
   use taut_model_pendulum, only: new_pendulum, pendulum_t
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_modes

   real(wp), parameter :: pi = acos(-1.0_wp), zero(3) = 0.0_wp
   real(wp), parameter :: x(3) = [1.0_wp, 0.0_wp, 0.0_wp], y(3) = [0.0_wp, 1.0_wp, 0.0_wp], z(3) = [0.0_wp, 0.0_wp, 1.0_wp]

contains

   !> All tests of this module.
   function collect_modes() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('Table 1 of the paper', table_1), &
               new_test('highest frequency of the swing''s beam, free', highest_free), &
               new_test('a simply supported beam', simply_supported), &
               new_test('a cantilever, clamped or blocked', clamped), &
               new_test('shapes are orthonormal in the mass', orthonormal), &
               new_test('a compressed beam slows down and buckles', buckling), &
               new_test('a bent and twisted beam in space', bent_in_space), &
               new_test('a pendulum, hanging and upright', pendulum), &
               new_test('what has no modes', impossible)]
   end function collect_modes

   !> Velocities that leave the plane x-y, and those listed.
   function out_of_plane(nodes, others) result(blocked)
      integer, intent(in) :: nodes, others(:)
      integer, allocatable :: blocked(:)
      integer :: i

      blocked = [([6*i - 3, 6*i - 2, 6*i - 1], i=1, nodes), others]
   end function out_of_plane

   !> Hz: 0.443, 18.17, 28.46, 319.5, the last one the first in which the mass moves along the beam.
   subroutine table_1(failure)
      character(:), allocatable, intent(inout) :: failure
      type(beam_t) :: beam
      type(modes_t) :: modes
      type(modes_options_t) :: options
      type(error_t), allocatable :: error
      real(wp) :: axial, frequency(4)
      integer :: i

      beam = swing_beam(40)
      options%blocked = out_of_plane(41, [1, 2, 241, 242])
      call eigenmodes(beam, beam%reference_state(), modes, error, options)
      call no_error(failure, error)
      if (allocated(failure)) return
      call check(failure, modes%symmetric, 'symmetric')
      axial = 0.0_wp
      do i = size(modes%frequency), 1, -1
         if (abs(modes%shapes(121, i)) > 0.5_wp) axial = modes%frequency(i)
      end do
      frequency = [modes%frequency(1:3), axial]
      call check_close(failure, frequency(1), 0.443_wp, 0.0005_wp, 'first symmetric bending')
      call check_close(failure, frequency(2), 18.17_wp, 0.005_wp, 'first antisymmetric bending')
      call check_close(failure, frequency(3), 28.46_wp, 0.005_wp, 'second symmetric bending')
      call check_close(failure, frequency(4), 319.5_wp, 0.05_wp, 'first antisymmetric axial')
      ! A prototype in another language.
      call check_below(failure, maxval(abs(frequency/[0.4431_wp, 18.174_wp, 28.457_wp, 319.48_wp] - 1.0_wp)), 2.0e-4_wp, &
                       'prototype')
   end subroutine table_1

   subroutine highest_free(failure)
      character(:), allocatable, intent(inout) :: failure
      type(beam_t) :: beam
      type(modes_t) :: modes
      type(error_t), allocatable :: error

      beam = swing_beam(4)
      call eigenmodes(beam, beam%reference_state(), modes, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      call check(failure, size(modes%frequency) == 30, 'all modes')
      call check_close(failure, modes%frequency(30), 8.5e3_wp, 50.0_wp, 'the highest')
      call check_below(failure, modes%frequency(6), 1.0e-2_wp, 'six rigid motions')
      call check(failure, modes%frequency(7) > 1.0_wp, 'and no more')
   end subroutine highest_free

   !> f = (n pi)^2/(2 pi) sqrt(EI/(m L^4)), in both planes, with constraints; the error falls with the square of the length.
   subroutine simply_supported(failure)
      character(:), allocatable, intent(inout) :: failure
      type(beam_t) :: beam
      type(modes_t) :: modes
      type(modes_options_t) :: options
      type(error_t), allocatable :: error
      real(wp) :: e(2, 3)
      integer :: i, j, n

      do i = 1, 3
         n = 4*2**(i - 1)
         beam = slender_beam(n)
         call beam%pin(1, error)
         call beam%fix_rotation(1, x, error)
         call beam%fix_position(n + 1, y, error)
         call beam%fix_position(n + 1, z, error)
         ! Twisting is left out: it would be between the others.
         options%blocked = [(6*j - 2, j=2, n + 1)]
         call eigenmodes(beam, beam%reference_state(), modes, error, options)
         call no_error(failure, error)
         if (allocated(failure)) return
         call check_close(failure, modes%frequency(2), modes%frequency(1), 1.0e-6_wp, 'both planes')
         do j = 1, 2
            e(j, i) = modes%frequency(2*j)/(0.5_wp*pi*j**2) - 1.0_wp
         end do
      end do
      call check_below(failure, e(1, 3), 2.0e-3_wp, 'first')
      call check_below(failure, e(2, 3), 8.0e-3_wp, 'second')
      call check_close(failure, log(e(1, 2)/e(1, 3))/log(2.0_wp), 2.0_wp, 0.1_wp, 'order of the first')
      call check_close(failure, log(e(2, 2)/e(2, 3))/log(2.0_wp), 2.0_wp, 0.2_wp, 'order of the second')
   end subroutine simply_supported

   !> f = b^2/(2 pi), b = 1.87510407, 4.69409113; torsion 1/4 sqrt(GJ/I), axial 1/4 sqrt(EA/m).
   subroutine clamped(failure)
      character(:), allocatable, intent(inout) :: failure
      type(beam_t) :: beam
      type(modes_t) :: blocked, modes
      type(modes_options_t) :: options
      type(error_t), allocatable :: error
      integer :: i

      beam = slender_beam(16)
      options%blocked = [(i, i=1, 6)]
      call eigenmodes(beam, beam%reference_state(), blocked, error, options)
      call beam%clamp(1, error)
      call eigenmodes(beam, beam%reference_state(), modes, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      call check(failure, size(modes%frequency) == 96, 'six are clamped')
      call check_below(failure, maxval(abs(blocked%frequency(1:20) - modes%frequency(1:20))), 1.0e-5_wp, 'blocked or clamped')
      call check_close(failure, modes%frequency(1), 1.87510407_wp**2/(2.0_wp*pi), 2.0e-3_wp, 'first')
      call check_close(failure, modes%frequency(2), modes%frequency(1), 1.0e-5_wp, 'the other plane')
      call check_close(failure, modes%frequency(3), 4.69409113_wp**2/(2.0_wp*pi), 5.0e-2_wp, 'second')
      call check(failure, any(abs(modes%frequency - 0.25_wp*sqrt(1.0e6_wp)) < 0.2_wp), 'axial')
      call check(failure, any(abs(modes%frequency - 0.25_wp*sqrt(1.0_wp/2.0e-7_wp)) < 0.5_wp), 'torsion')
   end subroutine clamped

   subroutine orthonormal(failure)
      character(:), allocatable, intent(inout) :: failure
      type(beam_t) :: beam
      type(block_diagonal_t) :: m
      type(modes_t) :: modes
      type(error_t), allocatable :: error
      real(wp), allocatable :: product(:, :)
      integer :: i

      beam = swing_beam(4)
      call beam%pin(1, error)
      call eigenmodes(beam, beam%reference_state(), modes, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      call m%init(beam%mass_blocks)
      call beam%mass(beam%reference_state(), m)
      product = matmul(transpose(modes%shapes), matmul(m%dense(), modes%shapes))
      do i = 1, size(product, 1)
         product(i, i) = product(i, i) - 1.0_wp
      end do
      call check_below(failure, maxval(abs(product)), 1.0e-10_wp, 'unit modal mass')
      call check_below(failure, maxval(abs(modes%shapes(1:3, :))), 1.0e-12_wp, 'the pin holds')
   end subroutine orthonormal

   !> A simply supported beam under the axial load P: f^2 = f_0^2 (1 - P/P_cr), P_cr = pi^2 EI/L^2 but for the mesh.
   subroutine buckling(failure)
      character(:), allocatable, intent(inout) :: failure
      integer, parameter :: n = 8
      real(wp), parameter :: part(3) = [0.0_wp, 0.5_wp, 1.2_wp]
      type(beam_t) :: beam
      type(state_t) :: at
      type(equilibrium_result_t) :: found
      type(equilibrium_options_t) :: statics
      type(modes_t) :: modes
      type(modes_options_t) :: options
      type(error_t), allocatable :: error
      real(wp) :: square(3)
      integer :: i

      do i = 1, 3
         beam = slender_beam(n)
         call beam%add_load(n + 1, -part(i)*pi**2*x, zero, error)
         options%blocked = out_of_plane(n + 1, [1, 2, 6*n + 2])
         statics%blocked = options%blocked
         at = beam%reference_state()
         call equilibrium(beam, at, found, error, statics)
         call eigenmodes(beam, at, modes, error, options)
         call no_error(failure, error)
         if (allocated(failure)) return
         square(i) = (2.0_wp*pi*modes%frequency(1))**2 - modes%growth(1)**2
      end do
      call check_close(failure, square(2)/square(1), 0.5_wp, 0.01_wp, 'half the load')
      call check_close(failure, square(3)/square(1), -0.2_wp, 0.02_wp, 'beyond buckling')
      call check(failure, modes%growth(1) > 0.0_wp .and. modes%growth(2) <= 0.0_wp, 'one motion grows')
   end subroutine buckling

   !> Forces and moments of bent elements in space have no exact potential: K is slightly unsymmetric. The general solver
   !! gives nearly what the symmetric one gives of its symmetric part, the closer the finer the mesh.
   subroutine bent_in_space(failure)
      character(:), allocatable, intent(inout) :: failure
      type(beam_t) :: beam
      type(state_t) :: at
      type(equilibrium_result_t) :: found
      type(equilibrium_options_t) :: statics
      type(modes_t) :: general, symmetric
      type(modes_options_t) :: options
      type(error_t), allocatable :: error
      real(wp) :: mismatch(2)
      integer :: i, n

      statics%steps = 4
      do i = 1, 2
         n = 4*i
         beam = slender_beam(n)
         call beam%clamp(1, error)
         call beam%add_load(n + 1, 2.0_wp*y, zero, error)
         call beam%add_load(n/2 + 1, 4.0_wp*z, zero, error)
         at = beam%reference_state()
         call equilibrium(beam, at, found, error, statics)
         options%symmetry_tolerance = 1.0e-6_wp
         call eigenmodes(beam, at, general, error, options)
         options%symmetry_tolerance = 1.0_wp
         call eigenmodes(beam, at, symmetric, error, options)
         call no_error(failure, error)
         if (allocated(failure)) return
         call check(failure, .not. general%symmetric .and. symmetric%symmetric, 'not symmetric')
         call check_below(failure, maxval(general%growth(1:4)), 0.0_wp, 'stable')
         call check_below(failure, maxval(abs(general%shapes(1:6, :))), 1.0e-9_wp, 'the clamp holds')
         mismatch(i) = maxval(abs(general%frequency(1:2)/symmetric%frequency(1:2) - 1.0_wp))
      end do
      call check_below(failure, mismatch(1), 1.0e-3_wp, 'four elements')
      call check_below(failure, mismatch(2), 0.4_wp*mismatch(1), 'eight elements')
   end subroutine bent_in_space

   subroutine pendulum(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(state_t) :: at
      type(modes_t) :: modes
      type(modes_options_t) :: options
      type(error_t), allocatable :: error

      call new_pendulum(model, 2.0_wp, 0.7_wp, 9.81_wp, 2, error)
      allocate (at%x, source=[0.0_wp, -0.7_wp])
      call eigenmodes(model, at, modes, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      call check(failure, size(modes%frequency) == 1, 'one freedom')
      call check_close(failure, modes%frequency(1), sqrt(9.81_wp/0.7_wp)/(2.0_wp*pi), 1.0e-8_wp, 'hanging')
      call check_below(failure, maxval(abs(modes%shapes(:, 1) - [sqrt(0.5_wp), 0.0_wp])), 1.0e-8_wp, 'sideways')
      at%x = [0.0_wp, 0.7_wp]
      call eigenmodes(model, at, modes, error)
      call check_close(failure, modes%growth(1), sqrt(9.81_wp/0.7_wp), 1.0e-7_wp, 'upright')
      call check_below(failure, modes%frequency(1), 0.0_wp, 'no vibration')
      options%constrained = .false.
      call eigenmodes(model, at, modes, error, options)
      call no_error(failure, error)
      call check(failure, size(modes%frequency) == 2, 'without its rod')
      call check_below(failure, maxval(modes%frequency), 1.0e-6_wp, 'a free mass')
   end subroutine pendulum

   subroutine impossible(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(state_t) :: at
      type(modes_t) :: modes
      type(modes_options_t) :: options
      type(error_t), allocatable :: error

      call new_pendulum(model, 2.0_wp, 0.7_wp, 9.81_wp, 1, error)
      allocate (at%x, source=[0.0_wp, -0.7_wp, 0.0_wp])
      call eigenmodes(model, at, modes, error)
      call expect('coordinates')
      at%x = [0.0_wp, -0.7_wp]
      options%blocked = [1]
      call eigenmodes(model, at, modes, error, options)
      call expect('leave nothing free')
      options%blocked = [0]
      call eigenmodes(model, at, modes, error, options)
      call expect('no velocity 0')
      model%m = -1.0_wp
      options%blocked = [integer ::]
      call eigenmodes(model, at, modes, error, options)
      call expect('not positive definite')

   contains

      subroutine expect(text)
         character(*), intent(in) :: text

         call check(failure, allocated(error), 'an error about '//text)
         if (.not. allocated(error)) return
         call check(failure, index(error%line(), text) > 0, 'instead of '//text//': '//error%line())
         deallocate (error)
      end subroutine expect

   end subroutine impossible

end module test_modes
