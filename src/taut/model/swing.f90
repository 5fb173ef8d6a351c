!> The swing of Sect. 4.2 (Figure 3): a flexible beam A-E with a mass at its middle C, hung from the ground by a rigid massless
!! link at each end; either of finite-volume beam elements or of a few of their modes in a floating frame.
!!
!! Axes: origin at A and x from A to E at the start, y up. Link 1 goes up from A; link 2 goes from E up and to the right
!! under 45 degrees. The multipliers are the tensions of the links [N].
module taut_model_swing
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_constrained_modes, only: eigenmodes, modes_options_t, modes_t
   use taut_constrained_system, only: state_t
   use taut_model_beam, only: beam_t, new_beam, straight_nodes
   use taut_model_beam_section, only: beam_section_t, rectangular_section
   use taut_model_dead_load, only: dead_load_t
   use taut_model_modal_body, only: modal_body_t, new_modal_body
   use taut_model_posed_system, only: posed_system_t
   implicit none (type, external)
   private
   public :: swing_beam_t, swing_data_t, swing_modal_t, new_swing_beam, new_swing_modal

   !> What the swing is made of; the defaults are the paper's.
   type :: swing_data_t
      !> Number of elements, a multiple of four: the markers B and D are at the quarter points.
      integer :: elements = 4
      !> Length of the beam, thickness in the plane, width [m].
      real(wp) :: length = 0.72_wp, thickness = 1.0e-3_wp, width = 5.0e-3_wp
      !> Young's modulus [Pa], Poisson's ratio, density [kg/m^3]. (The paper's '73 MPa' is a slip for GPa.)
      real(wp) :: young = 73.0e9_wp, poisson = 0.3_wp, density = 2700.0_wp
      !> Mass at mid-span [kg].
      real(wp) :: mid_mass = 0.5_wp
      !> Lengths of the links [m].
      real(wp) :: link_1 = 0.36_wp, link_2 = 0.36_wp*sqrt(2.0_wp)
      !> Force on C at its peak [N], in global axes.
      real(wp) :: force(3) = [2.0_wp, 0.0_wp, 0.0_wp]
      !> Times at which the triangular force starts, peaks and ends [s].
      real(wp) :: times(3) = [0.0_wp, 0.128_wp, 0.256_wp]
      !> Gravity [m/s^2].
      real(wp) :: gravity(3) = 0.0_wp
      !> Time constant of the beam's viscous damping [s].
      real(wp) :: damping = 0.0_wp
   end type swing_data_t

   !> The swing of beam elements.
   type, extends(beam_t) :: swing_beam_t
   end type swing_beam_t

   !> The swing of modes.
   type, extends(modal_body_t) :: swing_modal_t
      !> Frequencies of its modes [Hz].
      real(wp), allocatable :: frequency(:)
   end type swing_modal_t

   character(*), parameter :: here = 'swing'
   !> Matrices are dense: more elements than this take minutes.
   integer, parameter :: most_elements = 400

contains

   !> The swing of beam elements.
   subroutine new_swing_beam(self, data, error)
      !> The swing.
      type(swing_beam_t), intent(out) :: self
      !> What it is made of.
      type(swing_data_t), intent(in) :: data
      !> Values that make no sense.
      type(error_t), allocatable, intent(inout) :: error
      real(wp) :: supports(3, 2)

      call bare_beam(self%beam_t, data, error)
      if (allocated(error)) return
      call find_supports(data, supports)
      call mark(self, data%elements, supports(:, 1))
      call self%link(1, supports(:, 1), data%link_1, error)
      call self%link(self%nodes, supports(:, 2), data%link_2, error)
      call self%add_load(middle(data%elements), data%force, [0.0_wp, 0.0_wp, 0.0_wp], error, data%times, [0.0_wp, 1.0_wp, 0.0_wp])
      self%gravity = data%gravity
   end subroutine new_swing_beam

   !> The swing of modes of the beam with the displacements of its ends blocked, in its plane.
   subroutine new_swing_modal(self, data, modes, error)
      !> The swing.
      type(swing_modal_t), intent(out) :: self
      !> What it is made of; `elements` of the beam whose modes are taken.
      type(swing_data_t), intent(in) :: data
      !> Which modes, in order of frequency.
      integer, intent(in) :: modes(:)
      !> Values that make no sense, modes that do not exist.
      type(error_t), allocatable, intent(inout) :: error
      type(beam_t) :: beam
      type(dead_load_t) :: load
      type(modes_options_t) :: options
      type(modes_t) :: found
      type(state_t) :: at
      real(wp), allocatable :: position(:, :), rotation(:, :, :), shape(:, :, :), stiffness(:, :)
      real(wp) :: supports(3, 2)
      real(wp), parameter :: pi = acos(-1.0_wp)
      integer :: i, k, n

      call bare_beam(beam, data, error)
      if (allocated(error)) return
      n = beam%nodes
      options%constrained = .false.
      options%damped = .false.
      options%blocked = [1, 2, 6*n - 5, 6*n - 4, ([6*i - 3, 6*i - 2, 6*i - 1], i=1, n)]
      at = beam%reference_state()
      call eigenmodes(beam, at, found, error, options)
      if (allocated(error)) return
      if (size(modes) < 1) call raise(error, here, 'no modes are named', 'give modes, such as 1, 2, 3')
      do i = 1, size(modes)
         if (modes(i) < 1 .or. modes(i) > size(found%frequency)) &
            call raise(error, here, 'modes: there is no mode '//to_text(modes(i)), &
                       'name modes from 1 to '//to_text(size(found%frequency)))
      end do
      if (allocated(error)) return
      do i = 2, size(modes)
         if (any(modes(:i - 1) == modes(i))) &
            call raise(error, here, 'mode '//to_text(modes(i))//' is named twice', 'name each once')
      end do
      if (allocated(error)) return
      allocate (position(3, n), shape(3, size(modes), n), rotation(3, size(modes), n))
      allocate (stiffness(size(modes), size(modes)), source=0.0_wp)
      do i = 1, n
         position(:, i) = at%x(7*i - 6:7*i - 4)
         do k = 1, size(modes)
            shape(:, k, i) = found%shapes(6*i - 5:6*i - 3, modes(k))
            rotation(:, k, i) = found%shapes(6*i - 2:6*i, modes(k))
         end do
      end do
      do k = 1, size(modes)
         stiffness(k, k) = (2.0_wp*pi*found%frequency(modes(k)))**2
      end do
      call new_modal_body(self%modal_body_t, position, beam%m, beam%inertia, shape, rotation, stiffness, error)
      if (allocated(error)) return
      allocate (self%frequency(size(modes)))
      self%frequency(:) = found%frequency(modes)
      call find_supports(data, supports)
      call mark(self, data%elements, supports(:, 1))
      call self%link(1, supports(:, 1), data%link_1, error)
      call self%link(n, supports(:, 2), data%link_2, error)
      call load%set(middle(data%elements), data%force, [0.0_wp, 0.0_wp, 0.0_wp], error, data%times, [0.0_wp, 1.0_wp, 0.0_wp])
      self%loads = [load]
      self%gravity = data%gravity
      ! A beam whose internal forces are stiffness (strain + tau strain rate) has modes damped in the same proportion.
      self%damping = data%damping
   end subroutine new_swing_modal

   !> The beam with its mass, free.
   subroutine bare_beam(beam, data, error)
      type(beam_t), intent(out) :: beam
      type(swing_data_t), intent(in) :: data
      type(error_t), allocatable, intent(inout) :: error
      type(beam_section_t) :: section
      real(wp), allocatable :: orientations(:, :), positions(:, :)

      if (data%elements < 4 .or. modulo(data%elements, 4) /= 0) &
         call raise(error, here, 'elements = '//to_text(data%elements)//' is not a multiple of four', &
                    'give 4, 8, 12, ...: the markers B and D are at the quarter points')
      if (data%elements > most_elements) &
         call raise(error, here, 'elements = '//to_text(data%elements)//' is too many', 'give '//to_text(most_elements)//' or less')
      if (.not. all(abs(data%gravity) <= huge(1.0_wp))) &
         call raise(error, here, 'gravity is not a number', 'give m/s^2')
      if (.not. (data%length > 0.0_wp .and. data%length <= huge(1.0_wp))) &
         call raise(error, here, 'length = '//to_text(data%length)//' is not positive', 'give the length of the beam in m')
      if (.not. data%mid_mass >= 0.0_wp) &
         call raise(error, here, 'mid_mass = '//to_text(data%mid_mass)//' is negative', 'give a mass in kg')
      if (.not. (data%link_1 > 0.0_wp .and. data%link_2 > 0.0_wp)) &
         call raise(error, here, 'the length of a link is not positive', 'give link_1 and link_2 in m')
      call rectangular_section(section, data%young, data%poisson, data%density, data%thickness, data%width, error)
      if (allocated(error)) return
      call straight_nodes([0.0_wp, 0.0_wp, 0.0_wp], [data%length, 0.0_wp, 0.0_wp], data%elements, [0.0_wp, 1.0_wp, 0.0_wp], &
                          positions, orientations)
      call new_beam(beam, positions, orientations, section, error, damping=data%damping)
      if (allocated(error)) return
      if (data%mid_mass > 0.0_wp) call beam%add_mass(middle(data%elements), data%mid_mass, error)
   end subroutine bare_beam

   !> Node of the mass, C.
   pure integer function middle(elements)
      integer, intent(in) :: elements

      middle = 1 + elements/2
   end function middle

   !> Markers A to E at the ends and the quarter points; events where link 1 is in line with A-C, or with the chord A-E.
   subroutine mark(swing, elements, support)
      class(posed_system_t), intent(inout) :: swing
      integer, intent(in) :: elements
      real(wp), intent(in) :: support(3)
      character(*), parameter :: letters = 'ABCDE'
      integer :: i

      do i = 1, 5
         call swing%add_marker(letters(i:i), 1 + ((i - 1)*elements)/4)
      end do
      call swing%add_alignment('link-AC', support, 1, middle(elements))
      call swing%add_alignment('link-AE', support, 1, 1 + elements)
   end subroutine mark

   !> Where the links are pinned to the ground.
   pure subroutine find_supports(data, supports)
      type(swing_data_t), intent(in) :: data
      real(wp), intent(out) :: supports(3, 2)

      supports(:, 1) = [0.0_wp, data%link_1, 0.0_wp]
      supports(:, 2) = [data%length, 0.0_wp, 0.0_wp] + data%link_2*sqrt(0.5_wp)*[1.0_wp, 1.0_wp, 0.0_wp]
   end subroutine find_supports

end module taut_model_swing
