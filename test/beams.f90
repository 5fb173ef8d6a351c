!> Beams that several suites use.
module beams
   use taut_kinds, only: wp
   use taut_error, only: error_t
   use taut_model_beam, only: beam_t, new_beam, straight_nodes
   use taut_model_beam_section, only: beam_section_t, new_section, rectangular_section
   use taut_rotation, only: quaternion_product, rotate
   implicit none (type, external)
   private
   public :: coupled_section, deformed, hung_beam, slender_beam, swing_beam, turned

   real(wp), parameter :: axes(3, 3) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [3, 3])

contains

   !> The beam of Sect. 4.2, along x with its thin side in the plane x-y, and 0.5 kg at mid-span.
   function swing_beam(elements) result(beam)
      integer, intent(in) :: elements
      type(beam_t) :: beam
      type(beam_section_t) :: section
      type(error_t), allocatable :: error
      real(wp), allocatable :: positions(:, :), orientations(:, :)

      call rectangular_section(section, 73.0e9_wp, 0.3_wp, 2700.0_wp, 1.0e-3_wp, 5.0e-3_wp, error)
      call straight_nodes([0.0_wp, 0.0_wp, 0.0_wp], 0.72_wp*axes(:, 1), elements, axes(:, 2), positions, orientations)
      call new_beam(beam, positions, orientations, section, error)
      call beam%add_mass(1 + elements/2, 0.5_wp, error)
      if (allocated(error)) error stop 'the beam of the swing'
   end function swing_beam

   !> A beam along x of EI and length 1 and large other stiffnesses, mass 1.
   function slender_beam(elements) result(beam)
      integer, intent(in) :: elements
      type(beam_t) :: beam
      type(beam_section_t) :: section
      type(error_t), allocatable :: error
      real(wp), allocatable :: positions(:, :), orientations(:, :)
      real(wp) :: stiffness(6, 6)
      real(wp), parameter :: diagonal(6) = [1.0e6_wp, 1.0e6_wp, 1.0e6_wp, 1.0_wp, 1.0_wp, 1.0_wp]
      integer :: i

      stiffness = 0.0_wp
      do i = 1, 6
         stiffness(i, i) = diagonal(i)
      end do
      call new_section(section, stiffness, 1.0_wp, [2.0e-7_wp, 1.0e-7_wp, 1.0e-7_wp], error)
      call straight_nodes([0.0_wp, 0.0_wp, 0.0_wp], axes(:, 1), elements, axes(:, 2), positions, orientations)
      call new_beam(beam, positions, orientations, section, error)
      if (allocated(error)) error stop 'the slender beam'
   end function slender_beam

   !> A section of which every force depends on every strain.
   function coupled_section() result(section)
      type(beam_section_t) :: section
      type(error_t), allocatable :: error
      real(wp) :: root(6, 6)
      integer :: i, j

      do j = 1, 6
         do i = 1, 6
            root(i, j) = 0.3_wp*sin(real(3*i + 5*j, wp))
         end do
         root(j, j) = root(j, j) + 3.0_wp
      end do
      call new_section(section, matmul(transpose(root), root), 1.3_wp, [0.5_wp, 0.3_wp, 0.2_wp], error)
      if (allocated(error)) error stop 'the coupled section'
   end function coupled_section

   !> A soft damped beam of two elements with every kind of constraint and load.
   function hung_beam() result(beam)
      type(beam_t) :: beam
      type(error_t), allocatable :: error
      real(wp), allocatable :: positions(:, :), orientations(:, :)

      call straight_nodes([0.0_wp, 0.0_wp, 0.0_wp], 2.0_wp*axes(:, 1), 2, axes(:, 2), positions, orientations)
      call new_beam(beam, positions, orientations, coupled_section(), error, damping=0.01_wp)
      beam%gravity = [0.0_wp, -1.0_wp, 0.0_wp]
      call beam%add_mass(2, 1.0_wp, error, &
                         reshape([2.0_wp, 0.1_wp, 0.0_wp, 0.1_wp, 1.5_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [3, 3]))
      call beam%fix_position(1, axes(:, 3), error)
      call beam%fix_rotation(1, axes(:, 1), error)
      call beam%link(3, [2.0_wp, 1.0_wp, 0.0_wp], 1.0_wp, error)
      call beam%add_load(2, axes(:, 1), axes(:, 2), error, [0.0_wp, 0.05_wp], [0.0_wp, 1.0_wp])
      if (allocated(error)) error stop 'the hung beam'
   end function hung_beam

   !> Coordinates that have been displaced irregularly by about `size` (length and angle), in the plane x-y or in space.
   function deformed(beam, size, planar) result(x)
      type(beam_t), intent(in) :: beam
      real(wp), intent(in) :: size
      logical, intent(in) :: planar
      real(wp), allocatable :: x(:)
      real(wp) :: d(6*beam%nodes)
      integer :: i

      do i = 1, 6*beam%nodes
         d(i) = size*sin(7.0_wp*i + 0.3_wp*i**2)
         if (planar .and. any(mod(i - 1, 6) == [2, 3, 4])) d(i) = 0.0_wp
      end do
      x = beam%x_reference
      call beam%displace(d, x)
   end function deformed

   !> Coordinates after a rigid motion.
   function turned(beam, x, q, shift) result(moved)
      type(beam_t), intent(in) :: beam
      real(wp), intent(in) :: x(:), q(4), shift(3)
      real(wp) :: moved(7*beam%nodes)
      integer :: i

      do i = 1, beam%nodes
         moved(7*i - 6:7*i - 4) = shift + rotate(q, x(7*i - 6:7*i - 4))
         moved(7*i - 3:7*i) = quaternion_product(q, x(7*i - 3:7*i))
      end do
   end function turned

end module beams
