!> Beams in space: a chain of nodes joined by finite-volume elements, as a constrained mechanical system.
!!
!! Coordinates and velocities are those of `nodal_system_t`: for each node a position, a unit quaternion, a linear velocity in
!! GLOBAL axes and an angular velocity in BODY axes.
module taut_model_beam
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_constrained_system, only: state_t
   use taut_model_beam_element, only: beam_element_t, dissipated_power, element_energy, element_rows, element_strain, &
                                      internal_loads, new_element
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_model_beam_section, only: beam_section_t, corrected_stiffness
   use taut_model_nodes, only: nodal_system_t
   use taut_rotation, only: quaternion_of_axes
   implicit none (type, external)
   private
   public :: beam_t, new_beam, straight_nodes

   !> A beam. Its inertia is lumped at the nodes, each with its slice of the beam.
   type, extends(nodal_system_t) :: beam_t
      !> Elements in order; element i joins nodes i and i + 1.
      type(beam_element_t), allocatable :: elements(:)
   contains
      procedure :: force
      procedure :: internal_forces
      procedure :: strain
      procedure :: strain_energy
      procedure :: energy => total_energy
      procedure :: power
      procedure :: coupling
      procedure :: elastic_pattern
      procedure :: elastic_rows
      procedure :: elastic_stiffness
      procedure :: soft_force
   end type beam_t

   character(*), parameter :: here = 'beam'

contains

   !> Nodes at equal distances on a straight line.
   subroutine straight_nodes(start, finish, elements, near_axis_2, positions, orientations)
      !> One end [m].
      real(wp), intent(in) :: start(3)
      !> The other end [m].
      real(wp), intent(in) :: finish(3)
      !> Number of elements.
      integer, intent(in) :: elements
      !> Direction of local axis 2, made normal to the line; not along it.
      real(wp), intent(in) :: near_axis_2(3)
      !> Positions of the nodes [m]: (3, nodes).
      real(wp), allocatable, intent(out) :: positions(:, :)
      !> Orientations of the nodes, unit quaternions: (4, nodes).
      real(wp), allocatable, intent(out) :: orientations(:, :)
      real(wp) :: part
      integer :: i

      allocate (positions(3, elements + 1), orientations(4, elements + 1))
      do i = 1, elements + 1
         part = real(i - 1, wp)/real(elements, wp)
         positions(:, i) = (1.0_wp - part)*start + part*finish
         orientations(:, i) = quaternion_of_axes(finish - start, near_axis_2)
      end do
   end subroutine straight_nodes

   !> A beam of one section through given nodes, free of loads and constraints.
   !!
   !! Half of each element's mass goes to either node, with the moments of inertia of its slice: rho (I_2 + I_3) s about the
   !! axis, rho I s + m l^2/12 across, s half of the length l and m its mass.
   subroutine new_beam(self, positions, orientations, section, error, damping, correct_shear)
      !> The beam.
      class(beam_t), intent(out) :: self
      !> Reference positions of the nodes [m]: (3, nodes).
      real(wp), intent(in) :: positions(:, :)
      !> Their orientations, unit quaternions, local axis 1 along the beam: (4, nodes).
      real(wp), intent(in) :: orientations(:, :)
      !> The section.
      type(beam_section_t), intent(in) :: section
      !> Nodes or a section that make no sense.
      type(error_t), allocatable, intent(inout) :: error
      !> Time constant of viscous damping [s]: internal forces are stiffness (strain + damping * strain rate). Default 0.
      real(wp), intent(in), optional :: damping
      !> Whether the shear stiffness is corrected for the length of the elements. Default true.
      logical, intent(in), optional :: correct_shear
      real(wp) :: l, half_mass, stiffness(6, 6), tau
      logical :: correct
      integer :: i, j, k, n

      n = size(positions, 2)
      tau = 0.0_wp
      if (present(damping)) tau = damping
      correct = .true.
      if (present(correct_shear)) correct = correct_shear
      if (n < 2) call raise(error, here, 'it has '//to_text(n)//' nodes', 'give two or more')
      if (.not. (tau >= 0.0_wp .and. tau <= huge(tau))) &
         call raise(error, here, 'damping = '//to_text(tau)//' is negative', 'give a time in s')
      if (.not. section%mass > 0.0_wp) &
         call raise(error, here, 'the section is not set', 'set it up with rectangular_section or new_section')
      if (allocated(error)) return
      call self%set_nodes(positions, orientations, error)
      if (allocated(error)) return
      allocate (self%elements(n - 1))
      do i = 1, n - 1
         l = norm2(positions(:, i + 1) - positions(:, i))
         if (.not. l > 0.0_wp) then
            call raise(error, here, 'nodes '//to_text(i)//' and '//to_text(i + 1)//' are at one point', 'set them apart')
            return
         end if
         stiffness = section%stiffness
         if (correct) call corrected_stiffness(section, l, stiffness)
         associate (x => self%x_reference)
            self%elements(i) = new_element(x(7*i - 6:7*i - 4), x(7*i - 3:7*i), x(7*i + 1:7*i + 3), x(7*i + 4:7*i + 7), &
                                           stiffness, tau)
         end associate
         half_mass = 0.5_wp*section%mass*l
         do j = i, i + 1
            self%m(j) = self%m(j) + half_mass
            self%inertia(1, 1, j) = self%inertia(1, 1, j) + 0.5_wp*section%inertia(1)*l
            do k = 2, 3
               self%inertia(k, k, j) = self%inertia(k, k, j) + 0.5_wp*section%inertia(k)*l + half_mass*l**2/12.0_wp
            end do
         end do
      end do
      call self%resize()
      self%n_elastic = 6*(n - 1)
      if (tau > 0.0_wp) self%elastic_damping = spread(tau, 1, self%n_elastic)
   end subroutine new_beam

   !> f: internal forces, gravity, loads, and the gyroscopic moments.
   subroutine force(self, at, value)
      !> The beam.
      class(beam_t), intent(in) :: self
      !> The state; all of it may be used.
      type(state_t), intent(in) :: at
      !> f: (6 nodes), forces in global axes [N], moments in body axes [N m].
      real(wp), intent(out) :: value(:)

      call self%internal_forces(at, value)
      call self%loads_and_inertia(at, value)
   end subroutine force

   !> Forces and moments of the elements on the nodes, both in global axes.
   subroutine internal_forces(self, at, f)
      !> The beam.
      class(beam_t), intent(in) :: self
      !> The state; all of it may be used.
      type(state_t), intent(in) :: at
      !> Force [N] and moment [N m] on each node: (6, nodes).
      real(wp), intent(out) :: f(6, self%nodes)
      real(wp) :: f_1(3), m_1(3), m_2(3)
      integer :: i, j, k

      f(:, 1) = 0.0_wp
      do i = 1, size(self%elements)
         j = 7*i
         k = 6*i
         call internal_loads(self%elements(i), at%x(j - 6:j - 4), at%x(j - 3:j), at%v(k - 5:k), &
                             at%x(j + 1:j + 3), at%x(j + 4:j + 7), at%v(k + 1:k + 6), f_1, m_1, m_2)
         do k = 1, 3
            f(k, i) = f(k, i) + f_1(k)
            f(k + 3, i) = f(k + 3, i) + m_1(k)
            f(k, i + 1) = -f_1(k)
            f(k + 3, i + 1) = m_2(k)
         end do
      end do
   end subroutine internal_forces

   !> Gravity, loads and gyroscopic moments: each node's own.
   subroutine soft_force(self, at, value)
      !> The beam.
      class(beam_t), intent(in) :: self
      !> The state at which it is evaluated.
      type(state_t), intent(in) :: at
      !> f without the internal forces: (6 nodes).
      real(wp), intent(out) :: value(:)

      value(:) = 0.0_wp
      call self%loads_and_inertia(at, value)
   end subroutine soft_force

   !> The moments of a node depend on its own velocities alone.
   subroutine coupling(self, first, column)
      !> The beam.
      class(beam_t), intent(in) :: self
      !> First entry of each velocity in `column`, and the number of entries plus one at the end: (n + 1).
      integer, allocatable, intent(out) :: first(:)
      !> The others.
      integer, allocatable, intent(out) :: column(:)
      integer :: i, j

      first = [(6*i + 1, i=0, self%n)]
      column = [((6*((i - 1)/6) + j, j=1, 6), i=1, self%n)]
   end subroutine coupling

   !> Six rows for each element, with the velocities of its two nodes.
   subroutine elastic_pattern(self, first, column)
      !> The beam.
      class(beam_t), intent(in) :: self
      !> First entry of each row in `column`, and the number of entries plus one at the end: (n_elastic + 1).
      integer, allocatable, intent(out) :: first(:)
      !> Column of each entry, ascending within a row.
      integer, allocatable, intent(out) :: column(:)
      integer :: i, j

      first = [(12*i + 1, i=0, self%n_elastic)]
      column = [((6*((i - 1)/6) + j, j=1, 12), i=1, self%n_elastic)]
   end subroutine elastic_pattern

   !> Stretches, slips, twists and bends of the elements, and B.
   subroutine elastic_rows(self, at, strain, values)
      !> The beam.
      class(beam_t), intent(in) :: self
      !> Where; v is used by damping only.
      type(state_t), intent(in) :: at
      !> Strains times lengths [m], [rad]: (n_elastic).
      real(wp), intent(out) :: strain(:)
      !> Entries of B in the order of the pattern.
      real(wp), intent(out) :: values(:)
      real(wp) :: b(12, 6)
      integer :: i, j, k

      do i = 1, size(self%elements)
         j = 7*i
         k = 6*i
         call element_rows(self%elements(i), at%x(j - 6:j - 4), at%x(j - 3:j), at%v(k - 5:k), &
                           at%x(j + 1:j + 3), at%x(j + 4:j + 7), at%v(k + 1:k + 6), strain(k - 5:k), b)
         values(72*(i - 1) + 1:72*i) = reshape(b, [72])
      end do
   end subroutine elastic_rows

   !> Loads at the cut per stretch: the section's stiffness over the length.
   subroutine elastic_stiffness(self, stiffness)
      !> The beam.
      class(beam_t), intent(in) :: self
      !> One block for each element.
      type(block_diagonal_t), intent(inout) :: stiffness
      integer :: i

      call stiffness%init([(6, i=1, size(self%elements))])
      do i = 1, size(self%elements)
         call stiffness%set_block(i, self%elements(i)%stiffness/self%elements(i)%l)
      end do
   end subroutine elastic_stiffness

   !> Strains of an element, Eqs (33).
   function strain(self, x, i)
      !> The beam.
      class(beam_t), intent(in) :: self
      !> Coordinates: (7 nodes).
      real(wp), intent(in) :: x(:)
      !> Index of the element.
      integer, intent(in) :: i
      !> {axial, shear 2, shear 3, torsion, curvature about 2, about 3}: [-] and [1/m].
      real(wp) :: strain(6)

      strain = element_strain(self%elements(i), x(7*i - 6:7*i - 4), x(7*i - 3:7*i), x(7*i + 1:7*i + 3), x(7*i + 4:7*i + 7))
   end function strain

   !> Strain energy of all elements.
   function strain_energy(self, x) result(energy)
      !> The beam.
      class(beam_t), intent(in) :: self
      !> Coordinates: (7 nodes).
      real(wp), intent(in) :: x(:)
      !> The energy [J].
      real(wp) :: energy
      integer :: i

      energy = 0.0_wp
      do i = 1, size(self%elements)
         energy = energy + element_energy(self%elements(i), x(7*i - 6:7*i - 4), x(7*i - 3:7*i), &
                                          x(7*i + 1:7*i + 3), x(7*i + 4:7*i + 7))
      end do
   end function strain_energy

   !> Kinetic energy, strain energy and that of gravity; loads from outside have no part in it.
   function total_energy(self, at) result(energy)
      !> The beam.
      class(beam_t), intent(in) :: self
      !> The state; its x and v are used.
      type(state_t), intent(in) :: at
      !> The energy [J].
      real(wp) :: energy

      energy = self%energy_without_strain(at) + self%strain_energy(at%x)
   end function total_energy

   !> Power of the loads, less what the elements' damping takes [W].
   function power(self, at)
      !> The beam.
      class(beam_t), intent(in) :: self
      !> The state; all of it may be used.
      type(state_t), intent(in) :: at
      !> The power.
      real(wp) :: power
      integer :: i

      power = self%power_of_loads(at)
      do i = 1, size(self%elements)
         power = power - dissipated_power(self%elements(i), at%x(7*i - 6:7*i - 4), at%x(7*i - 3:7*i), at%v(6*i - 5:6*i), &
                                          at%x(7*i + 1:7*i + 3), at%x(7*i + 4:7*i + 7), at%v(6*i + 1:6*i + 6))
      end do
   end function power

end module taut_model_beam
