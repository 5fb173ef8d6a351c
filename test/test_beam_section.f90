!> Sections of beams: stiffness, inertia and the shear correction.
module test_beam_section
   use beams, only: coupled_section
   use taut_kinds, only: wp
   use taut_error, only: error_t
   use taut_linalg_lapack, only: dpotrf, dpotrs
   use taut_model_beam_section, only: beam_section_t, corrected_stiffness, new_section, rectangular_section
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_beam_section

contains

   !> All tests of this module.
   function collect_beam_section() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('a rectangular section', rectangle), &
               new_test('sections that make no sense', bad_sections), &
               new_test('the shear correction', shear_correction)]
   end function collect_beam_section

   subroutine rectangle(failure)
      character(:), allocatable, intent(inout) :: failure
      type(beam_section_t) :: section
      type(error_t), allocatable :: error

      call rectangular_section(section, 200.0_wp, 0.25_wp, 10.0_wp, 1.0_wp, 2.0_wp, error)
      call no_error(failure, error)
      call check_close(failure, section%stiffness(1, 1), 400.0_wp, 1.0e-10_wp, 'EA')
      call check_close(failure, section%stiffness(2, 2), 400.0_wp/3.0_wp, 1.0e-10_wp, 'shear 2')
      call check_close(failure, section%stiffness(3, 3), 400.0_wp/3.0_wp, 1.0e-10_wp, 'shear 3')
      ! Timoshenko and Goodier's table: 0.229 for a ratio of 2, 0.1406 for a square.
      call check_close(failure, section%stiffness(4, 4), 80.0_wp*0.229_wp*2.0_wp, 0.08_wp, 'GJ')
      call check_close(failure, section%stiffness(5, 5), 200.0_wp*8.0_wp/12.0_wp, 1.0e-10_wp, 'EI about 2')
      call check_close(failure, section%stiffness(6, 6), 200.0_wp*2.0_wp/12.0_wp, 1.0e-10_wp, 'EI about 3')
      call check_close(failure, section%mass, 20.0_wp, 1.0e-12_wp, 'mass')
      call check_below(failure, maxval(abs(section%inertia - 10.0_wp*[10.0_wp, 8.0_wp, 2.0_wp]/12.0_wp)), 1.0e-12_wp, 'inertia')
      call rectangular_section(section, 2.0_wp, 0.0_wp, 10.0_wp, 1.0_wp, 1.0_wp, error)
      call check_close(failure, section%stiffness(4, 4), 0.140577_wp, 1.0e-6_wp, 'GJ of a square')
   end subroutine rectangle

   subroutine bad_sections(failure)
      character(:), allocatable, intent(inout) :: failure
      type(beam_section_t) :: section
      real(wp) :: k(6, 6)
      real(wp), parameter :: one(3) = 1.0_wp
      type(error_t), allocatable :: error

      call rectangular_section(section, -1.0_wp, 0.3_wp, 1.0_wp, 1.0_wp, 1.0_wp, error)
      call expect('Young''s modulus')
      call rectangular_section(section, 1.0_wp, 0.6_wp, 1.0_wp, 1.0_wp, 1.0_wp, error)
      call expect('Poisson''s ratio')
      call rectangular_section(section, 1.0_wp, 0.3_wp, 1.0_wp, 0.0_wp, 1.0_wp, error)
      call expect('side along axis 2')
      section = coupled_section()
      k = section%stiffness
      k(6, 6) = 0.0_wp
      call new_section(section, k, 1.0_wp, one, error)
      call expect('not positive definite')
      section = coupled_section()
      k = section%stiffness
      k(1, 2) = k(1, 1) + k(2, 2)
      call new_section(section, k, 1.0_wp, one, error)
      call expect('not symmetric')
      k(2, 1) = k(1, 2)
      call new_section(section, k, 1.0_wp, one, error)
      call expect('not positive definite')
      section = coupled_section()
      k = section%stiffness
      call new_section(section, k, 0.0_wp, one, error)
      call expect('mass per unit length')

   contains

      subroutine expect(text)
         character(*), intent(in) :: text

         call check(failure, allocated(error), 'an error about '//text)
         if (.not. allocated(error)) return
         call check(failure, index(error%line(), text) > 0, 'instead of '//text//': '//error%line())
         deallocate (error)
      end subroutine expect

   end subroutine bad_sections

   !> Uncoupled: 1/GA* = 1/GA + l^2/(12 EI), each shear with the bending in its own plane. In general: the compliance changes
   !! in the shears only.
   subroutine shear_correction(failure)
      character(:), allocatable, intent(inout) :: failure
      type(beam_section_t) :: section
      type(error_t), allocatable :: error
      real(wp) :: after(6, 6), before(6, 6), change(6, 6), k(6, 6)
      real(wp), parameter :: l = 0.4_wp

      call rectangular_section(section, 200.0_wp, 0.25_wp, 10.0_wp, 0.1_wp, 0.2_wp, error)
      call corrected_stiffness(section, l, k)
      associate (s => section%stiffness)
         call check_close(failure, 1.0_wp/k(2, 2), 1.0_wp/s(2, 2) + l**2/(12.0_wp*s(6, 6)), 1.0e-12_wp/k(2, 2), 'in the plane 1-2')
         call check_close(failure, 1.0_wp/k(3, 3), 1.0_wp/s(3, 3) + l**2/(12.0_wp*s(5, 5)), 1.0e-12_wp/k(3, 3), 'in the plane 1-3')
         call check_below(failure, maxval(abs([k(1, 1) - s(1, 1), k(4, 4) - s(4, 4), k(5, 5) - s(5, 5), k(6, 6) - s(6, 6)])), &
                          1.0e-12_wp*s(1, 1), 'no other')
         call check_below(failure, sum(abs(k)) - k(1, 1) - k(2, 2) - k(3, 3) - k(4, 4) - k(5, 5) - k(6, 6), &
                          4.0_wp*spacing(sum(abs(k))), 'no coupling')
      end associate
      section = coupled_section()
      call corrected_stiffness(section, l, k)
      call check_below(failure, maxval(abs(k - transpose(k))), 0.0_wp, 'symmetric')
      after = inverse(k)
      before = inverse(section%stiffness)
      change = 0.0_wp
      change(2, 2) = before(6, 6)
      change(3, 3) = before(5, 5)
      change(2, 3) = -before(5, 6)
      change(3, 2) = -before(5, 6)
      call check_below(failure, maxval(abs(after - before - l**2/12.0_wp*change)), 1.0e-15_wp, 'what is added')

   contains

      function inverse(matrix)
         real(wp), intent(in) :: matrix(6, 6)
         real(wp) :: inverse(6, 6), factor(6, 6)
         integer :: i, info

         factor = matrix
         inverse = 0.0_wp
         do i = 1, 6
            inverse(i, i) = 1.0_wp
         end do
         call dpotrf('L', 6, factor, 6, info)
         call dpotrs('L', 6, 6, factor, 6, inverse, 6, info)
      end function inverse

   end subroutine shear_correction

end module test_beam_section
