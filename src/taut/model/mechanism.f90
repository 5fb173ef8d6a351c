!> A mechanism: bodies, joints, functions of time, loads, springs and beams as one constrained system.
!!
!! Its parts are in `mechanism_parts.f90`, the equations of its joints in `mechanism_constraints.f90`; here are its forces and
!! what is written of it. The multipliers of a joint's rows are its reactions; `outputs` gives them as forces and moments on its
!! second body.
module taut_model_mechanism
   use taut_kinds, only: wp
   use taut_constrained_system, only: state_t
   use taut_constrained_system_tables, only: quantity_t
   use taut_model_beam_element, only: element_energy, internal_loads
   use taut_model_mechanism_body, only: point_motion, pose_t, turned
   use taut_model_mechanism_constraints, only: mechanism_constraints_t
   use taut_model_mechanism_joint, only: has_angle, has_displacement, joint_angle, joint_angle_rate, joint_displacement
   use taut_model_mechanism_load, only: load_t, spring_t
   use taut_model_mechanism_parts, only: element_t, event_t, outputs_of_joint, point_t
   implicit none (type, external)
   private
   public :: mechanism_t, point_t, event_t, element_t

   !> The mechanism.
   type, extends(mechanism_constraints_t) :: mechanism_t
   contains
      procedure :: force
      procedure :: energy
      procedure :: output_name
      procedure :: outputs
      procedure :: quantities
      procedure :: describe
      procedure :: note
      procedure :: event_name
      procedure :: event_values
   end type mechanism_t

contains

   !> f: gravity, gyroscopic moments, loads, springs and dampers, beams.
   subroutine force(self, at, value)
      !> The mechanism.
      class(mechanism_t), intent(in) :: self
      !> The state; all of it may be used.
      type(state_t), intent(in) :: at
      !> f: (n).
      real(wp), intent(out) :: value(:)
      integer :: i

      do i = 1, size(self%bodies)
         call self%bodies(i)%inertial_force(self%gravity, at%v, value)
      end do
      do i = 1, size(self%loads)
         call add_load(self, self%loads(i), at, value)
      end do
      do i = 1, size(self%springs)
         call add_spring(self, self%springs(i), at, value)
      end do
      do i = 1, size(self%elements)
         call add_element(self, self%elements(i), at, value)
      end do
   end subroutine force

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
   pure subroutine spring_motion(self, spring, one, two, length, rate, direction)
      class(mechanism_t), intent(in) :: self
      type(spring_t), intent(in) :: spring
      type(pose_t), intent(in) :: one, two
      real(wp), intent(out) :: length, rate, direction(3)
      real(wp), parameter :: turn = 2.0_wp*acos(-1.0_wp)
      real(wp) :: v_1(3), v_2(3), x_1(3), x_2(3)
      integer :: i

      if (spring%joint > 0) then
         associate (joint => self%joints(spring%joint))
            ! Within half a turn of the free angle.
            length = joint_angle(joint, one, two)
            length = length - turn*anint((length - spring%free)/turn)
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
   end subroutine spring_motion

   !> The bodies of a spring.
   pure subroutine spring_bodies(self, spring, body_1, body_2)
      class(mechanism_t), intent(in) :: self
      type(spring_t), intent(in) :: spring
      integer, intent(out) :: body_1, body_2

      body_1 = spring%body_1
      body_2 = spring%body_2
      if (spring%joint == 0) return
      body_1 = self%joints(spring%joint)%body_1
      body_2 = self%joints(spring%joint)%body_2
   end subroutine spring_bodies

   !> Adds a spring's forces or moments.
   subroutine add_spring(self, spring, at, f)
      class(mechanism_t), intent(in) :: self
      type(spring_t), intent(in) :: spring
      type(state_t), intent(in) :: at
      real(wp), intent(inout) :: f(:)
      type(pose_t) :: one, two
      real(wp) :: back(3), direction(3), length, pull(3), rate, tension
      integer :: i
      integer :: body_1, body_2

      call spring_bodies(self, spring, body_1, body_2)
      call self%pose_of(at, body_1, one)
      call self%pose_of(at, body_2, two)
      call spring_motion(self, spring, one, two, length, rate, direction)
      tension = spring%preload + spring%stiffness*(length - spring%free) + spring%damping*rate
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

   !> Kinetic energy, and the potential of gravity (zero at the origin), springs and beams; loads have no part in it.
   function energy(self, at)
      !> The mechanism.
      class(mechanism_t), intent(in) :: self
      !> The state; its x and v are used.
      type(state_t), intent(in) :: at
      !> The energy [J].
      real(wp) :: energy
      type(pose_t) :: one, two
      real(wp) :: direction(3), length, rate
      integer :: body_1, body_2, i

      energy = 0.0_wp
      do i = 1, size(self%bodies)
         call self%bodies(i)%pose(at%x, at%v, one)
         energy = energy + self%bodies(i)%kinetic_energy(at%v) - self%bodies(i)%m*dot_product(self%gravity, one%p)
      end do
      do i = 1, size(self%springs)
         associate (spring => self%springs(i))
            call spring_bodies(self, spring, body_1, body_2)
            call self%pose_of(at, body_1, one)
            call self%pose_of(at, body_2, two)
            call spring_motion(self, spring, one, two, length, rate, direction)
            energy = energy + spring%preload*(length - spring%free) + 0.5_wp*spring%stiffness*(length - spring%free)**2
         end associate
      end do
      do i = 1, size(self%elements)
         associate (x_1 => self%bodies(self%elements(i)%body_1)%before_x, x_2 => self%bodies(self%elements(i)%body_2)%before_x)
            energy = energy + element_energy(self%elements(i)%element, at%x(x_1 + 1:x_1 + 3), at%x(x_1 + 4:x_1 + 7), &
                                             at%x(x_2 + 1:x_2 + 3), at%x(x_2 + 4:x_2 + 7))
         end associate
      end do
   end function energy

   !> Such as tip.x, hinge.fx, hinge.m3 or hinge.angle.
   function output_name(self, i) result(name)
      !> The mechanism.
      class(mechanism_t), intent(in) :: self
      !> Index of the output.
      integer, intent(in) :: i
      !> The name.
      character(:), allocatable :: name
      character(len=2), parameter :: in_space(12) = ['fx', 'fy', 'fz', 'mx', 'my', 'mz', 'f1', 'f2', 'f3', 'm1', 'm2', 'm3'], &
                                     in_plane(6) = ['fx', 'fy', 'mz', 'f1', 'f2', 'f3']
      integer :: j, k, n

      n = merge(2, 3, self%planar)
      k = i
      name = ''
      if (k <= n*size(self%points)) then
         name = self%points(1 + (k - 1)/n)%name//'.'//achar(iachar('x') + modulo(k - 1, n))
         return
      end if
      k = k - n*size(self%points)
      do j = 1, size(self%shown)
         associate (joint => self%joints(self%shown(j)))
            n = outputs_of_joint(self, joint)
            if (k > n) then
               k = k - n
               cycle
            end if
            n = merge(6, 12, self%planar)
            if (k > n) then
               name = joint%name//'.'//trim(merge('angle       ', 'displacement', has_angle(joint) .and. k == n + 1))
            else if (self%planar) then
               name = joint%name//'.'//in_plane(k)
            else
               name = joint%name//'.'//in_space(k)
            end if
            return
         end associate
      end do
   end function output_name

   !> Positions of points; reactions, angles and displacements of joints.
   subroutine outputs(self, at, lambda, values)
      !> The mechanism.
      class(mechanism_t), intent(in) :: self
      !> The state that the row of the table is about.
      type(state_t), intent(in) :: at
      !> Multipliers: (c).
      real(wp), intent(in) :: lambda(:)
      !> In the order of their names: (n_outputs).
      real(wp), intent(out) :: values(:)
      type(pose_t) :: one, two
      real(wp) :: e(3, 3), f(3), m(3), p(3)
      integer :: i, k, n

      k = 0
      n = merge(2, 3, self%planar)
      do i = 1, size(self%points)
         call self%pose_of(at, self%points(i)%body, one)
         p = one%p + matmul(one%r, self%points(i)%at)
         values(k + 1:k + n) = p(1:n)
         k = k + n
      end do
      do i = 1, size(self%shown)
         associate (joint => self%joints(self%shown(i)))
            call self%reaction(at, lambda, self%shown(i), f, m)
            call self%pose_of(at, joint%body_1, one)
            call self%pose_of(at, joint%body_2, two)
            e = matmul(one%r, joint%frame_1)
            if (self%planar) then
               values(k + 1:k + 3) = [f(1), f(2), m(3)]
               values(k + 4:k + 6) = matmul(f, e)
               k = k + 6
            else
               values(k + 1:k + 3) = f
               values(k + 4:k + 6) = m
               values(k + 7:k + 9) = matmul(f, e)
               values(k + 10:k + 12) = matmul(m, e)
               k = k + 12
            end if
            if (has_angle(joint)) then
               k = k + 1
               values(k) = joint_angle(joint, one, two)
            end if
            if (has_displacement(joint)) then
               k = k + 1
               values(k) = joint_displacement(joint, one, two)
            end if
         end associate
      end do
   end subroutine outputs

   !> What was found out at the start.
   function quantities(self) result(list)
      !> The mechanism.
      class(mechanism_t), intent(in) :: self
      !> The table.
      type(quantity_t), allocatable :: list(:)

      allocate (list(0))
      if (allocated(self%findings)) list = self%findings
   end function quantities

   !> What was found out at the start, for people.
   function describe(self) result(text)
      !> The mechanism.
      class(mechanism_t), intent(in) :: self
      !> Lines with their ends.
      character(:), allocatable :: text

      text = ''
      if (allocated(self%description)) text = self%description
   end function describe

   !> Whether there are reactions that are not unique.
   function note(self) result(text)
      !> The mechanism.
      class(mechanism_t), intent(in) :: self
      !> One line without commas.
      character(:), allocatable :: text

      text = ''
      if (allocated(self%remark)) text = self%remark
   end function note

   !> Name of an event.
   function event_name(self, i) result(name)
      !> The mechanism.
      class(mechanism_t), intent(in) :: self
      !> Index of the event.
      integer, intent(in) :: i
      !> The name.
      character(:), allocatable :: name

      name = self%events(i)%name
   end function event_name

   !> What is watched less its value.
   subroutine event_values(self, at, values)
      !> The mechanism.
      class(mechanism_t), intent(in) :: self
      !> The state at which they are evaluated.
      type(state_t), intent(in) :: at
      !> Differences: (n_events).
      real(wp), intent(out) :: values(:)
      type(pose_t) :: one, two
      real(wp) :: p(3)
      integer :: i

      do i = 1, size(self%events)
         associate (event => self%events(i))
            if (event%joint == 0) then
               call self%pose_of(at, event%body, one)
               p = one%p + matmul(one%r, event%at)
               values(i) = p(event%axis) - event%value
               cycle
            end if
            associate (joint => self%joints(event%joint))
               call self%pose_of(at, joint%body_1, one)
               call self%pose_of(at, joint%body_2, two)
               if (event%angle) then
                  ! Zero also half a turn away: a turn has no beginning.
                  values(i) = sin(joint_angle(joint, one, two) - event%value)
               else
                  values(i) = joint_displacement(joint, one, two) - event%value
               end if
            end associate
         end associate
      end do
   end subroutine event_values

end module taut_model_mechanism
