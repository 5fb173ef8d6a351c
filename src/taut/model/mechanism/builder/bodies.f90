!> Bodies and points of a mechanism that is being built.
submodule(taut_model_mechanism_builder) taut_model_mechanism_builder_bodies
   use taut_rotation, only: quaternion_normalized, quaternion_of_axes, quaternion_of_vector, rotate_back
   implicit none (type, external)

   !> Elements of a beam beyond this take minutes.
   integer, parameter :: most_elements = 1000
   real(wp), parameter :: z(3) = [0.0_wp, 0.0_wp, 1.0_wp]

contains

   !> A rigid body.
   module procedure add_body
      type(body_t) :: made
      real(wp) :: d(3), side(3), between

      if (allocated(self%error)) return
      made%name = trim(name)
      made%kind = merge(body_planar, body_spatial, self%planar)
      made%m = mass
      if (count([present(orientation), present(quaternion), present(angle), present(from)]) > 1) &
         call raise(self%error, '', 'its orientation is given in more than one way', &
                    'give one of angle, orientation, quaternion or from, to')
      if (present(from) .neqv. present(to)) call raise(self%error, '', 'from and to are not both given', 'give both')
      if (present(from) .and. present(position)) &
         call raise(self%error, '', 'its position is given in two ways', 'give position, or from and to')
      if (present(inertia) .and. present(shape)) &
         call raise(self%error, '', 'its inertia is given in two ways', 'give inertia, or shape')
      between = 0.0_wp
      if (present(position)) made%position = position
      if (present(from) .and. present(to)) then
         d = to - from
         between = norm2(d)
         made%position = 0.5_wp*(from + to)
         if (.not. between > 0.0_wp) call raise(self%error, '', 'from and to are the same point', 'set them apart')
         ! Axis 1 along it, axis 2 level if it can be.
         side = [-d(2), d(1), 0.0_wp]
         if (norm2(side) < 1.0e-6_wp*between) side = [0.0_wp, 1.0_wp, 0.0_wp]
         if (.not. allocated(self%error)) made%orientation = quaternion_of_axes(d, side)
      else if (present(quaternion)) then
         if (.not. norm2(quaternion) > 0.0_wp) call raise(self%error, '', 'its quaternion is zero', 'give one of length 1')
         if (.not. allocated(self%error)) made%orientation = quaternion_normalized(quaternion)
      else if (present(orientation)) then
         made%orientation = quaternion_of_vector(orientation)
      else if (present(angle)) then
         made%orientation = quaternion_of_vector(angle*z)
      end if
      if (present(velocity)) made%velocity = velocity
      d = 0.0_wp
      if (present(angular_velocity)) d = angular_velocity
      if (present(angle_rate)) d = d + angle_rate*z
      made%spin = rotate_back(made%orientation, d)
      if (self%planar) then
         if (abs(made%position(3)) + abs(made%velocity(3)) > 0.0_wp .or. norm2(made%orientation(2:3)) > 1.0e-12_wp .or. &
             norm2(made%spin(1:2)) > 0.0_wp) &
            call raise(self%error, '', 'it leaves the plane x-y', &
                       'give positions and velocities with z = 0, and turn it about z only')
         made%spin(1:2) = 0.0_wp
      end if
      if (.not. allocated(self%error)) call set_inertia()
      if (.not. allocated(self%error)) call keep_body(self, made)
      call locate(self, 'body', name)
      call note_angle(self, 'body', name, 'angle', angle)
      if (present(orientation)) call note_angle(self, 'body', name, '|orientation|', norm2(orientation))

   contains

      !> Moments of inertia, given or of a shape.
      subroutine set_inertia()
         real(wp) :: as_box(3), along, l, r
         integer :: k

         if (.not. present(shape)) then
            if (.not. present(inertia)) then
               call raise(self%error, '', 'it has neither inertia nor shape', &
                          'give one of them, or use '//trim(self%words%point_mass))
            else if (self%planar .and. ubound(inertia, 1) > 1) then
               call raise(self%error, '', 'its inertia has '//to_text(ubound(inertia, 1))//' numbers', &
                          'in the plane give one, that about z')
            else if (self%planar) then
               made%j(3, 3) = inertia(1)
            else if (ubound(inertia, 1) == 6) then
               made%j = reshape([inertia(1), inertia(4), inertia(5), inertia(4), inertia(2), inertia(6), inertia(5), inertia(6), &
                                 inertia(3)], [3, 3])
            else if (ubound(inertia, 1) == 3) then
               do k = 1, 3
                  made%j(k, k) = inertia(k)
               end do
            else
               call raise(self%error, '', 'its inertia has '//to_text(ubound(inertia, 1))//' numbers', 'give 3 or 6')
            end if
            return
         end if
         made%shape = shape
         l = between
         r = 0.5_wp*between
         made%axis = 1
         as_box = 0.0_wp
         if (present(length)) l = length
         if (present(radius)) r = radius
         select case (shape)
         case ('rod')
            call positive('length', l)
            as_box = merge(0.0_wp, 1.0e-3_wp*l, self%planar)
            if (present(thickness)) as_box = thickness
            as_box(1) = l
            made%size = as_box
            along = l
         case ('box')
            if (present(size)) as_box = size
            do k = 1, 3
               call positive('size', as_box(k))
            end do
            made%size = as_box
            along = as_box(1)
         case ('sphere')
            call positive('radius', r)
            as_box = sqrt(2.4_wp)*r
            made%size = 2.0_wp*r
            along = 2.0_wp*r
         case ('cylinder')
            if (.not. present(radius)) r = 0.0_wp
            call positive('radius', r)
            if (.not. between > 0.0_wp) made%axis = 3
            as_box = sqrt(3.0_wp)*r
            as_box(made%axis) = l
            made%size = [2.0_wp*r, 2.0_wp*r, l]
            along = l
         case default
            call raise(self%error, '', 'there is no shape "'//trim(shape)//'"', &
                       meant_of(shape, [character(len=8) :: 'rod', 'box', 'sphere', 'cylinder'])// &
                       'se "rod", "box", "sphere" or "cylinder"')
            return
         end select
         ! Ends may be rounded, or be those of what carries joints; a size that is far from them is that of another axis.
         if (between > 0.0_wp .and. (along < 0.5_wp*between .or. along > 2.0_wp*between)) &
            call raise(self%error, '', 'its size along from, to is '//to_text(along)//' m, but they are '//to_text(between)// &
                       ' m apart', 'give the size along them first, or position and orientation in their place')
         ! Each is as a box of some size: m (b^2 + c^2)/12.
         do k = 1, 3
            made%j(k, k) = mass*(as_box(1 + mod(k, 3))**2 + as_box(1 + mod(k + 1, 3))**2)/12.0_wp
         end do
         if (self%planar) made%j(1, 1) = 0.0_wp
         if (self%planar) made%j(2, 2) = 0.0_wp
      end subroutine set_inertia

      !> A side of a shape.
      subroutine positive(what, value)
         character(*), intent(in) :: what
         real(wp), intent(in) :: value

         if (.not. (value > 0.0_wp .and. value <= huge(value))) &
            call raise(self%error, '', what//' = '//to_text(value)//' is not positive', 'give it in m')
      end subroutine positive

   end procedure add_body

   !> Adds a body after a last check, and its name.
   subroutine keep_body(self, body)
      type(mechanism_builder_t), intent(inout) :: self
      type(body_t), intent(in) :: body
      type(anchor_t) :: anchor

      call check_name(self, body%name, .false.)
      call body%check(self%error)
      if (allocated(self%error)) return
      call make_room_bodies(self)
      self%body_count = self%body_count + 1
      self%bodies(self%body_count) = body
      anchor%name = body%name
      anchor%body = self%body_count
      ! A point mass is a point.
      anchor%is_point = any(body%kind == [body_point, body_planar_point])
      call keep_anchor(self, anchor)
   end subroutine keep_body

   !> A body without size.
   module procedure add_point_mass
      type(body_t) :: made

      if (allocated(self%error)) return
      made%name = trim(name)
      made%kind = merge(body_planar_point, body_point, self%planar)
      made%m = mass
      if (present(position)) made%position = position
      if (present(velocity)) made%velocity = velocity
      if (self%planar .and. abs(made%position(3)) + abs(made%velocity(3)) > 0.0_wp) &
         call raise(self%error, '', 'it leaves the plane x-y', 'give z = 0')
      if (.not. allocated(self%error)) call keep_body(self, made)
      call locate(self, 'point mass', name)
   end procedure add_point_mass

   !> A point of the ground.
   module procedure add_ground_point
      type(anchor_t) :: made

      if (allocated(self%error)) return
      made%name = trim(name)
      made%is_point = .true.
      made%at = position
      call check_name(self, made%name, .false.)
      if (.not. all(abs(position) <= huge(1.0_wp))) call raise(self%error, '', 'its position is not a number', 'correct it')
      if (.not. allocated(self%error)) call keep_anchor(self, made)
      call locate(self, 'ground point', name)
   end procedure add_ground_point

   !> A point of a body.
   module procedure add_point
      type(anchor_t) :: made, owner
      type(pose_t) :: it
      logical :: local

      if (allocated(self%error)) return
      call check_name(self, name, .false.)
      call self%find_anchor(body, 'body', owner)
      if (.not. all(abs(position) <= huge(1.0_wp))) call raise(self%error, '', 'its position is not a number', 'correct it')
      call locate(self, 'point', name)
      if (allocated(self%error)) return
      local = .false.
      if (present(in_body_axes)) local = in_body_axes
      it = self%start_pose(owner%body)
      made%name = trim(name)
      made%body = owner%body
      made%is_point = .true.
      made%at = position
      if (.not. local) made%at = matmul(position - it%p, it%r)
      call keep_anchor(self, made)
      call make_room_points(self)
      self%point_count = self%point_count + 1
      ! One by one: gfortran 12 loses the name in a constructor.
      self%points(self%point_count)%name = made%name
      self%points(self%point_count)%body = made%body
      self%points(self%point_count)%at = made%at
      call note_far(self, 'point', made%name, 'it', made%body, made%at)
   end procedure add_point

   !> A straight beam.
   module procedure add_beam
      type(beam_section_t) :: section
      type(beam_t) :: beam
      type(body_t) :: node
      real(wp), allocatable :: orientations(:, :), positions(:, :)
      real(wp) :: across(3), ratio, tau
      integer :: i

      if (allocated(self%error)) return
      across = [0.0_wp, 1.0_wp, 0.0_wp]
      if (present(axis_2)) across = axis_2
      ratio = 0.3_wp
      if (present(poisson)) ratio = poisson
      tau = 0.0_wp
      if (present(damping)) tau = damping
      if (self%planar) call raise(self%error, '', 'a beam is in space', 'leave out planar = .true.')
      if (elements < 1 .or. elements > most_elements) &
         call raise(self%error, '', 'elements = '//to_text(elements)//' is not between 1 and '//to_text(most_elements), &
                    'give a small number')
      if (.not. (norm2(to - from) > 0.0_wp .and. norm2(to - from) <= huge(1.0_wp))) &
         call raise(self%error, '', 'from and to are the same point or not numbers', 'set its ends apart')
      if (.not. allocated(self%error)) then
         if (.not. norm2(across) > 0.0_wp .or. abs(dot_product(across, to - from)) > 0.999_wp*norm2(across)*norm2(to - from)) &
            call raise(self%error, '', 'axis_2 is along the beam', 'give the direction of its thickness, across the beam')
      end if
      if (.not. allocated(self%error)) call rectangular_section(section, young, ratio, density, thickness, width, self%error)
      if (.not. allocated(self%error)) then
         call straight_nodes(from, to, elements, across, positions, orientations)
         call new_beam(beam, positions, orientations, section, self%error, damping=tau)
      end if
      do i = 1, elements + 1
         if (allocated(self%error)) exit
         node%name = trim(name)//to_text(i)
         node%kind = body_spatial
         node%m = beam%m(i)
         node%j = beam%inertia(:, :, i)
         node%position = positions(:, i)
         node%orientation = orientations(:, i)
         call keep_body(self, node)
         if (i == 1 .or. allocated(self%error)) cycle
         call make_room_elements(self)
         self%element_count = self%element_count + 1
         self%elements(self%element_count) = element_t(self%body_count - 1, self%body_count, beam%elements(i - 1))
      end do
      call locate(self, 'beam', name)
   end procedure add_beam

   !> Room for one more in the list, which doubles when it is full.
   subroutine make_room_bodies(self)
      type(mechanism_builder_t), intent(inout) :: self
      type(body_t), allocatable :: more(:)

      if (.not. allocated(self%bodies)) allocate (self%bodies(16))
      if (self%body_count < ubound(self%bodies, 1)) return
      allocate (more(2*self%body_count))
      more(:self%body_count) = self%bodies
      call move_alloc(more, self%bodies)
   end subroutine make_room_bodies

   !> Room for one more in the list, which doubles when it is full.
   subroutine make_room_points(self)
      type(mechanism_builder_t), intent(inout) :: self
      type(point_t), allocatable :: more(:)

      if (.not. allocated(self%points)) allocate (self%points(16))
      if (self%point_count < ubound(self%points, 1)) return
      allocate (more(2*self%point_count))
      more(:self%point_count) = self%points
      call move_alloc(more, self%points)
   end subroutine make_room_points

   !> Room for one more in the list, which doubles when it is full.
   subroutine make_room_elements(self)
      type(mechanism_builder_t), intent(inout) :: self
      type(element_t), allocatable :: more(:)

      if (.not. allocated(self%elements)) allocate (self%elements(16))
      if (self%element_count < ubound(self%elements, 1)) return
      allocate (more(2*self%element_count))
      more(:self%element_count) = self%elements
      call move_alloc(more, self%elements)
   end subroutine make_room_elements

end submodule taut_model_mechanism_builder_bodies
