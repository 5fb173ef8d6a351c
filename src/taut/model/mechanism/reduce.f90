!> A mechanism in the plane with only what moves: a body that turns about a point of the ground has its angle alone, with its moment
!! of inertia about that point, and the rows that would keep it there fall away.
submodule(taut_model_mechanism) taut_model_mechanism_reduce
   use taut_model_mechanism_body, only: body_pinned, body_planar
   use taut_model_mechanism_joint, only: keeps_points_together
   use taut_model_mechanism_pins, only: pin_t, pins_t
   use taut_model_mechanism_row, only: row_point
   implicit none (type, external)

contains

   !> The joint by which each body turns about a point of the ground; the first one, if there are several.
   module procedure pins_of
      integer :: body, i

      joint(:) = 0
      if (.not. self%planar) return
      do i = 1, size(self%joints)
         associate (it => self%joints(i))
            body = max(it%body_1, it%body_2)
            if (min(it%body_1, it%body_2) /= 0 .or. body == 0) cycle
            if (joint(body) > 0 .or. self%bodies(body)%kind /= body_planar .or. .not. keeps_points_together(it)) cycle
            joint(body) = i
         end associate
      end do
   end procedure pins_of

   !> The same mechanism with bodies that turn about a point of the ground.
   module procedure reduce
      type(pins_t), allocatable :: pins
      type(mechanism_t), allocatable :: small
      type(error_t), allocatable :: error
      integer :: pin(size(self%bodies))

      select type (self)
      type is (mechanism_t)
         pin = self%pins_of()
         if (all(pin == 0)) return
         allocate (small, pins)
         call take_parts(self, pin, small)
         call small%complete(error)
         if (allocated(error)) return
         call find_places(self, small, pin, pins)
         call move_alloc(small, pins%system)
         call move_alloc(pins, reduction)
      end select
   end procedure reduce

   !> All parts that make forces and constraints; points are counted from where their bodies turn.
   subroutine take_parts(self, pin, small)
      type(mechanism_t), intent(in) :: self
      integer, intent(in) :: pin(:)
      type(mechanism_t), intent(inout) :: small
      real(wp) :: shift(3, 0:size(pin))
      integer :: b, i

      small%planar = self%planar
      small%gravity = self%gravity
      small%bodies = self%bodies
      small%joints = self%joints
      small%functions = self%functions
      small%loads = self%loads
      small%springs = self%springs
      small%bushings = self%bushings
      allocate (small%shown(0))
      shift = 0.0_wp
      do b = 1, size(pin)
         if (pin(b) == 0) cycle
         associate (joint => self%joints(pin(b)))
            if (joint%body_1 == b) then
               shift(:, b) = joint%p_1
               call small%bodies(b)%pin(joint%p_1, joint%p_2)
            else
               shift(:, b) = joint%p_2
               call small%bodies(b)%pin(joint%p_2, joint%p_1)
            end if
         end associate
         small%joints(pin(b))%pins = .true.
      end do
      do i = 1, size(small%joints)
         associate (joint => small%joints(i))
            joint%p_1 = joint%p_1 - shift(:, joint%body_1)
            joint%p_2 = joint%p_2 - shift(:, joint%body_2)
         end associate
      end do
      do i = 1, size(small%loads)
         small%loads(i)%point = small%loads(i)%point - shift(:, small%loads(i)%body)
      end do
      do i = 1, size(small%springs)
         associate (spring => small%springs(i))
            spring%p_1 = spring%p_1 - shift(:, spring%body_1)
            spring%p_2 = spring%p_2 - shift(:, spring%body_2)
         end associate
      end do
      do i = 1, size(small%bushings)
         associate (bushing => small%bushings(i))
            bushing%p_1 = bushing%p_1 - shift(:, bushing%body_1)
            bushing%p_2 = bushing%p_2 - shift(:, bushing%body_2)
         end associate
      end do
   end subroutine take_parts

   !> Which coordinates, velocities and rows are those of the smaller mechanism, and what follows from them.
   subroutine find_places(self, small, pin, pins)
      type(mechanism_t), intent(in) :: self, small
      integer, intent(in) :: pin(:)
      type(pins_t), intent(inout) :: pins
      logical :: there(self%n), row_there(self%c)
      integer :: b, i, k

      there = .true.
      allocate (pins%pins(count(pin > 0)))
      k = 0
      do b = 1, size(pin)
         if (pin(b) == 0) cycle
         k = k + 1
         associate (whole => self%bodies(b), part => small%bodies(b))
            there(whole%before_v + 1:whole%before_v + 2) = .false.
            pins%pins(k) = pin_t(whole%before_x + 1, whole%before_v + 1, part%before_x + 1, part%before_v + 1, &
                                 part%position(1:2), part%center(1:2))
         end associate
      end do
      do i = 1, self%c
         row_there(i) = .not. (small%joints(self%joint_of_row(i))%pins .and. self%rows(i)%kind == row_point)
      end do
      ! In the plane coordinates and velocities are the same.
      pins%x = pack([(i, i=1, self%n)], there)
      pins%v = pins%x
      pins%row = pack([(i, i=1, self%c)], row_there)
   end subroutine find_places

end submodule taut_model_mechanism_reduce
