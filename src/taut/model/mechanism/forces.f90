!> Forces of a mechanism and their energy: gravity, loads, springs and dampers, bushings, beams.
submodule(taut_model_mechanism) taut_model_mechanism_forces
   use taut_model_beam_element, only: dissipated_power, element_energy, internal_loads
   use taut_model_mechanism_body, only: point_motion, turned
   use taut_model_mechanism_joint, only: joint_angle_rate
   implicit none (type, external)

contains

   !> f: gravity, gyroscopic moments, loads, springs and dampers, bushings, beams.
   module procedure force
      integer :: i

      do i = 1, size(self%bodies)
         call self%bodies(i)%inertial_force(self%gravity, at%x, at%v, value)
      end do
      do i = 1, size(self%loads)
         call add_load(self, self%loads(i), at, value)
      end do
      do i = 1, size(self%springs)
         call add_spring(self, self%springs(i), at, value, .false.)
      end do
      do i = 1, size(self%bushings)
         call add_bushing(self, self%bushings(i), at, value, .false.)
      end do
      do i = 1, size(self%elements)
         call add_element(self, self%elements(i), at, value)
      end do
   end procedure force

   !> f without what the elastic rows contribute.
   module procedure soft_force
      integer :: i

      do i = 1, size(self%bodies)
         call self%bodies(i)%inertial_force(self%gravity, at%x, at%v, value)
      end do
      do i = 1, size(self%loads)
         call add_load(self, self%loads(i), at, value)
      end do
      do i = 1, size(self%springs)
         call add_spring(self, self%springs(i), at, value, .true.)
      end do
      do i = 1, size(self%bushings)
         call add_bushing(self, self%bushings(i), at, value, .true.)
      end do
   end procedure soft_force

   !> Kinetic energy, and the potential of gravity (zero at the origin), springs, bushings and beams; loads have no part in it.
   module procedure energy
      type(deformation_t) :: deformation
      type(pose_t) :: one, two
      real(wp) :: direction(3), length, rate
      integer :: body_1, body_2, i

      energy = 0.0_wp
      do i = 1, size(self%bodies)
         call self%bodies(i)%pose(at%x, at%v, one)
         energy = energy + self%bodies(i)%kinetic_energy(at%v) - &
                  self%bodies(i)%m*dot_product(self%gravity, one%p + turned(one%r, self%bodies(i)%center))
      end do
      do i = 1, size(self%springs)
         associate (spring => self%springs(i))
            call spring_bodies(self, spring, body_1, body_2)
            call self%pose_of(at, body_1, one)
            call self%pose_of(at, body_2, two)
            call spring_motion(self, at, spring, one, two, length, rate, direction)
            energy = energy + spring%preload*(length - spring%free) + 0.5_wp*spring%stiffness*(length - spring%free)**2
         end associate
      end do
      do i = 1, size(self%bushings)
         call deform_bushing(self, at, self%bushings(i), one, two, deformation)
         energy = energy + 0.5_wp*dot_product(self%bushings(i)%stiffness, deformation%strain**2)
      end do
      do i = 1, size(self%elements)
         associate (x_1 => self%bodies(self%elements(i)%body_1)%before_x, x_2 => self%bodies(self%elements(i)%body_2)%before_x)
            energy = energy + element_energy(self%elements(i)%element, at%x(x_1 + 1:x_1 + 3), at%x(x_1 + 4:x_1 + 7), &
                                             at%x(x_2 + 1:x_2 + 3), at%x(x_2 + 4:x_2 + 7))
         end associate
      end do
   end procedure energy

   !> Power of loads and dampers.
   module procedure power
      type(deformation_t) :: deformation
      type(pose_t) :: one, two
      real(wp) :: direction(3), f(self%n), length, rate
      integer :: body_1, body_2, i

      power = 0.0_wp
      if (size(self%loads) > 0) then
         f(:) = 0.0_wp
         do i = 1, size(self%loads)
            call add_load(self, self%loads(i), at, f)
         end do
         power = dot_product(f, at%v)
      end if
      do i = 1, size(self%springs)
         associate (spring => self%springs(i))
            if (.not. spring%damping > 0.0_wp) cycle
            call spring_bodies(self, spring, body_1, body_2)
            call self%pose_of(at, body_1, one)
            call self%pose_of(at, body_2, two)
            call spring_motion(self, at, spring, one, two, length, rate, direction)
            power = power - spring%damping*rate**2
         end associate
      end do
      do i = 1, size(self%bushings)
         call deform_bushing(self, at, self%bushings(i), one, two, deformation)
         power = power - dot_product(self%bushings(i)%damping, deformation%rate**2)
      end do
      do i = 1, size(self%elements)
         associate (element => self%elements(i)%element, body_1 => self%bodies(self%elements(i)%body_1), &
                    body_2 => self%bodies(self%elements(i)%body_2))
            associate (x_1 => body_1%before_x, x_2 => body_2%before_x, v_1 => body_1%before_v, v_2 => body_2%before_v)
               power = power - dissipated_power(element, at%x(x_1 + 1:x_1 + 3), at%x(x_1 + 4:x_1 + 7), at%v(v_1 + 1:v_1 + 6), &
                                                at%x(x_2 + 1:x_2 + 3), at%x(x_2 + 4:x_2 + 7), at%v(v_2 + 1:v_2 + 6))
            end associate
         end associate
      end do
   end procedure power

   !> Adds a force or a moment.
   subroutine add_load(self, load, at, f)
      class(mechanism_t), intent(in) :: self
      type(load_t), intent(in) :: load
      type(state_t), intent(in) :: at
      real(wp), intent(inout) :: f(:)
      type(pose_t) :: it
      real(wp) :: g(3), value(3)
      integer :: i

      call self%pose_of(at, load%body, it)
      g(1) = 1.0_wp
      if (load%factor > 0) call self%functions(load%factor)%evaluate(at%t, g)
      value = load%value
      if (load%following) value = turned(it%r, load%value)
      do i = 1, 3
         value(i) = g(1)*value(i)
      end do
      if (load%moment) then
         call self%bodies(load%body)%add_moment(it, value, f)
      else
         call self%bodies(load%body)%add_force(it, load%point, value, f)
      end if
   end subroutine add_load

   !> Length or angle of a spring, its rate, and the direction from point 1 to point 2 or of the axis.
   module procedure spring_motion
      real(wp) :: v_1(3), v_2(3), x_1(3), x_2(3)
      integer :: i

      if (spring%joint > 0) then
         associate (joint => self%joints(spring%joint))
            length = self%angle_of(at, joint, one, two)
            rate = joint_angle_rate(joint, one, two)
            direction = turned(one%r, joint%frame_1(:, 3))
         end associate
         return
      end if
      call point_motion(one, spring%p_1, x_1, v_1)
      call point_motion(two, spring%p_2, x_2, v_2)
      length = sqrt((x_2(1) - x_1(1))**2 + (x_2(2) - x_1(2))**2 + (x_2(3) - x_1(3))**2)
      rate = 0.0_wp
      do i = 1, 3
         direction(i) = x_2(i) - x_1(i)
         if (length > 0.0_wp) direction(i) = direction(i)/length
         rate = rate + direction(i)*(v_2(i) - v_1(i))
      end do
   end procedure spring_motion

   !> Force or moment of a spring with its damper.
   module procedure spring_force
      force = spring%preload + spring%stiffness*(length - spring%free) + spring%damping*rate
   end procedure spring_force

   !> The bodies of a spring.
   module procedure spring_bodies
      body_1 = spring%body_1
      body_2 = spring%body_2
      if (spring%joint == 0) return
      body_1 = self%joints(spring%joint)%body_1
      body_2 = self%joints(spring%joint)%body_2
   end procedure spring_bodies

   !> Adds a spring's forces or moments; if soft, without what is an elastic row.
   subroutine add_spring(self, spring, at, f, soft)
      class(mechanism_t), intent(in) :: self
      type(spring_t), intent(in) :: spring
      type(state_t), intent(in) :: at
      real(wp), intent(inout) :: f(:)
      logical, intent(in) :: soft
      type(pose_t) :: one, two
      real(wp) :: back(3), direction(3), length, pull(3), rate, tension
      integer :: i
      integer :: body_1, body_2

      call spring_bodies(self, spring, body_1, body_2)
      call self%pose_of(at, body_1, one)
      call self%pose_of(at, body_2, two)
      call spring_motion(self, at, spring, one, two, length, rate, direction)
      tension = spring%preload
      if (.not. (soft .and. spring%stiffness > 0.0_wp)) tension = spring_force(spring, length, rate)
      do i = 1, 3
         pull(i) = tension*direction(i)
         back(i) = -pull(i)
      end do
      if (spring%joint > 0) then
         if (body_1 > 0) call self%bodies(body_1)%add_moment(one, pull, f)
         if (body_2 > 0) call self%bodies(body_2)%add_moment(two, back, f)
      else
         if (body_1 > 0) call self%bodies(body_1)%add_force(one, spring%p_1, pull, f)
         if (body_2 > 0) call self%bodies(body_2)%add_force(two, spring%p_2, back, f)
      end if
   end subroutine add_spring

   !> The deformation of a bushing.
   module procedure deform_bushing
      call self%pose_of(at, bushing%body_1, one)
      call self%pose_of(at, bushing%body_2, two)
      call bushing%deform(one, two, it)
   end procedure deform_bushing

   !> Adds a bushing's forces and moments; if soft, without what is elastic rows.
   subroutine add_bushing(self, bushing, at, f, soft)
      class(mechanism_t), intent(in) :: self
      type(bushing_t), intent(in) :: bushing
      type(state_t), intent(in) :: at
      real(wp), intent(inout) :: f(:)
      logical, intent(in) :: soft
      type(deformation_t) :: deformation
      type(pose_t) :: one, two
      real(wp) :: force(3), moment_1(3), moment_2(3), stress(6)

      call deform_bushing(self, at, bushing, one, two, deformation)
      stress = bushing%stress(deformation)
      if (soft) then
         where (bushing%elastic()) stress = 0.0_wp
      end if
      call deformation%loads(stress, force, moment_1, moment_2)
      if (bushing%body_1 > 0) then
         call self%bodies(bushing%body_1)%add_force(one, bushing%p_1, force, f)
         call self%bodies(bushing%body_1)%add_moment(one, moment_1, f)
      end if
      if (bushing%body_2 > 0) then
         call self%bodies(bushing%body_2)%add_force(two, bushing%p_2, -force, f)
         call self%bodies(bushing%body_2)%add_moment(two, moment_2, f)
      end if
   end subroutine add_bushing

   !> Adds a beam element's forces and moments.
   subroutine add_element(self, one, at, f)
      class(mechanism_t), intent(in) :: self
      type(element_t), intent(in) :: one
      type(state_t), intent(in) :: at
      real(wp), intent(inout) :: f(:)
      real(wp), parameter :: center(3) = 0.0_wp
      type(pose_t) :: first, second
      real(wp) :: f_1(3), m_1(3), m_2(3)
      integer :: i

      associate (body_1 => self%bodies(one%body_1), body_2 => self%bodies(one%body_2))
         associate (x_1 => body_1%before_x, x_2 => body_2%before_x, v_1 => body_1%before_v, v_2 => body_2%before_v)
            call internal_loads(one%element, at%x(x_1 + 1:x_1 + 3), at%x(x_1 + 4:x_1 + 7), at%v(v_1 + 1:v_1 + 6), &
                                at%x(x_2 + 1:x_2 + 3), at%x(x_2 + 4:x_2 + 7), at%v(v_2 + 1:v_2 + 6), f_1, m_1, m_2)
         end associate
         call body_1%pose(at%x, at%v, first)
         call body_2%pose(at%x, at%v, second)
         call body_1%add_force(first, center, f_1, f)
         call body_1%add_moment(first, m_1, f)
         do i = 1, 3
            f_1(i) = -f_1(i)
         end do
         call body_2%add_force(second, center, f_1, f)
         call body_2%add_moment(second, m_2, f)
      end associate
   end subroutine add_element

end submodule taut_model_mechanism_forces
