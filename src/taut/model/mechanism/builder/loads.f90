!> Functions, loads, springs and events of a mechanism that is being built.
submodule(taut_model_mechanism_builder) taut_model_mechanism_builder_loads
   use taut_constrained_system_tables, only: name_length
   use taut_model_mechanism_joint, only: drawn_angle, has_angle, has_displacement
   implicit none (type, external)

contains

   !> A function of time.
   module procedure add_function
      type(time_function_t) :: made

      if (allocated(self%error)) return
      made = function
      if (.not. allocated(made%name)) made%name = ''
      if (len_trim(made%name) == 0) then
         call raise(self%error, '', 'it has no name', 'give name = "..."')
      else if (self%function_names%find(made%name) > 0) then
         call raise(self%error, '', 'the name is taken: there are two of it', 'rename one of them')
      end if
      if (.not. allocated(self%error)) call made%check(self%error)
      if (.not. allocated(self%error)) then
         call make_room_functions(self)
         self%function_count = self%function_count + 1
         self%functions(self%function_count) = made
         call self%function_names%add(made%name, self%function_count)
      end if
      call locate(self, 'function', made%name)
   end procedure add_function

   !> A force or a moment.
   module procedure add_load
      type(load_t) :: made
      type(anchor_t) :: owner
      type(pose_t) :: it

      if (allocated(self%error)) return
      made%name = ''
      if (present(name)) made%name = trim(name)
      if (present(moment)) made%moment = moment
      if (present(follow)) made%following = follow
      call self%find_anchor(body, 'body', owner)
      made%factor = self%find_function(function, 'function')
      if (.not. allocated(self%error) .and. owner%body == 0) call raise(self%error, '', 'it acts on the ground', 'name a body')
      if (.not. all(abs(value) <= huge(1.0_wp))) call raise(self%error, '', 'its value is not a number', 'correct it')
      if (self%planar) then
         if (made%moment .and. norm2(value(1:2)) > 0.0_wp) &
            call raise(self%error, '', 'it leaves the plane x-y', 'in the plane a moment is about z: give one number')
         if (.not. made%moment .and. abs(value(3)) > 0.0_wp) &
            call raise(self%error, '', 'it leaves the plane x-y', 'give a force with z = 0')
      end if
      if (.not. allocated(self%error)) then
         it = self%start_pose(owner%body)
         made%body = owner%body
         made%point = owner%at
         if (present(point)) then
            if (owner%is_point) call raise(self%error, '', 'a point is given on "'//owner%name//'", which is a point itself', &
                                           'leave it out')
            made%point = matmul(point - it%p, it%r)
            if (.not. all(abs(point) <= huge(1.0_wp))) call raise(self%error, '', 'one of its points is not a number', 'correct it')
         end if
         made%value = value
         if (made%following) made%value = matmul(value, it%r)
      end if
      if (.not. allocated(self%error)) then
         call make_room_loads(self)
         self%load_count = self%load_count + 1
         self%loads(self%load_count) = made
      end if
      call locate(self, trim(merge('moment', 'force ', made%moment)), made%name)
      if (present(point) .and. .not. made%moment) call note_far(self, 'force', made%name, 'its point', made%body, made%point)
   end procedure add_load

   !> A spring with a damper.
   module procedure add_spring
      type(spring_t) :: made

      if (allocated(self%error)) return
      made%name = ''
      if (present(name)) made%name = trim(name)
      if (present(stiffness)) made%stiffness = stiffness
      if (present(damping)) made%damping = damping
      if (present(preload)) made%preload = preload
      if (.not. (present(stiffness) .or. present(damping) .or. present(preload))) &
         call raise(self%error, '', 'it has neither stiffness nor damping nor preload', 'give one of them')
      if (present(free_length)) then
         if (.not. abs(free_length) <= huge(1.0_wp)) call raise(self%error, '', 'one of its numbers is not finite', 'correct it')
         if (free_length < 0.0_wp) &
            call raise(self%error, '', 'free_length = '//to_text(free_length)//' is negative', 'give it in m')
      end if
      if (present(free_angle)) made%free = free_angle
      if (.not. all(abs([made%stiffness, made%damping, made%preload, made%free]) <= huge(1.0_wp))) &
         call raise(self%error, '', 'one of its numbers is not finite', 'correct it')
      if (made%damping < 0.0_wp) &
         call raise(self%error, '', 'damping = '//to_text(made%damping)//' is negative: it would add energy', &
                    'give it in N s/m or N m s/rad')
      if (.not. allocated(self%error)) then
         if (present(joint)) then
            call about_joint()
         else
            call between_points()
         end if
      end if
      if (.not. allocated(self%error)) then
         call make_room_springs(self)
         self%spring_count = self%spring_count + 1
         self%springs(self%spring_count) = made
      end if
      call locate(self, 'spring', made%name)
      call note_angle(self, 'spring', made%name, 'free_angle', free_angle)
      if (present(point_1)) call note_far(self, 'spring', made%name, 'its first point', made%body_1, made%p_1)
      if (present(point_2)) call note_far(self, 'spring', made%name, 'its second point', made%body_2, made%p_2)

   contains

      !> About the axis of a joint.
      subroutine about_joint()
         made%joint = self%find_joint(joint, 'joint')
         if (made%joint == 0) return
         associate (about => self%joints(made%joint))
            if (.not. has_angle(about)) then
               call raise(self%error, '', 'joint "'//about%name//'" has no angle', 'name a revolute or a cylindrical joint')
               return
            end if
            if (.not. present(free_angle)) &
               made%free = drawn_angle(about, self%start_pose(about%body_1), self%start_pose(about%body_2))
         end associate
         if (present(body_1) .or. present(body_2) .or. present(free_length)) &
            call raise(self%error, '', 'it is both about a joint and between bodies', 'give joint, or body_1 and body_2')
      end subroutine about_joint

      !> Between two points.
      subroutine between_points()
         type(anchor_t) :: one, two
         type(pose_t) :: it_1, it_2
         real(wp) :: d(3)

         one%name = 'ground'
         if (present(body_1)) call self%find_anchor(body_1, 'body_1', one)
         if (present(body_2)) then
            call self%find_anchor(body_2, 'body_2', two)
         else
            call self%find_anchor('', 'body_2', two)
         end if
         if (allocated(self%error)) return
         if (one%body == two%body) call raise(self%error, '', 'it joins "'//one%name//'" to itself', 'name two different bodies')
         if (.not. present(point_1) .and. .not. one%is_point .and. one%body == 0) &
            call raise(self%error, '', 'its point on the ground is not given', &
                       'give point_1, or name '//trim(self%words%ground_point))
         it_1 = self%start_pose(one%body)
         it_2 = self%start_pose(two%body)
         call place(one, it_1, point_1, made%p_1)
         call place(two, it_2, point_2, made%p_2)
         if (allocated(self%error)) return
         made%body_1 = one%body
         made%body_2 = two%body
         d = it_2%p + matmul(it_2%r, made%p_2) - it_1%p - matmul(it_1%r, made%p_1)
         made%free = norm2(d)
         if (present(free_length)) made%free = free_length
         if (.not. norm2(d) > 0.0_wp) &
            call raise(self%error, '', 'its points are at one place: its force has no direction', &
                       'set them apart, or use '//trim(self%words%bushing))
      end subroutine between_points

      !> The point of one side; without one, the center of mass.
      subroutine place(anchor, it, point, p)
         type(anchor_t), intent(in) :: anchor
         type(pose_t), intent(in) :: it
         real(wp), intent(in), optional :: point(3)
         real(wp), intent(out) :: p(3)
         logical :: local

         local = .false.
         if (present(in_body_axes)) local = in_body_axes
         p = anchor%at
         if (.not. present(point)) return
         if (anchor%is_point) call raise(self%error, '', 'a point is given on "'//anchor%name//'", which is a point itself', &
                                         'leave it out')
         p = point
         if (.not. local) p = matmul(point - it%p, it%r)
         if (.not. all(abs(p) <= huge(1.0_wp))) call raise(self%error, '', 'one of its points is not a number', 'correct it')
      end subroutine place

   end procedure add_spring

   !> Springs whose force and length, and bushings whose force and moment are written out.
   module procedure show_springs
      character(len=name_length) :: known(self%spring_count + self%bushing_count)
      integer, allocatable :: numbers(:)
      integer :: i

      if (allocated(self%error)) return
      ! Springs and dampers, then bushings.
      do i = 1, self%spring_count
         known(i) = self%springs(i)%name
      end do
      do i = 1, self%bushing_count
         known(self%spring_count + i) = self%bushings(i)%name
      end do
      if (present(names)) then
         numbers = [(number_of(trim(names(i))), i=1, size(names))]
      else
         numbers = [(number_of(trim(known(i))), i=1, size(known))]
      end if
      do i = 1, size(numbers)
         if (allocated(self%error)) return
         if (len_trim(known(numbers(i))) == 0) then
            call raise(self%error, '', 'a spring, damper or bushing has no name', 'give it name = "..."')
            return
         end if
         call check_name(self, known(numbers(i)), .true.)
         call locate(self, trim(merge('spring ', 'bushing', numbers(i) <= self%spring_count)), known(numbers(i)))
      end do
      if (allocated(self%error)) return
      self%shown_springs = pack(numbers, numbers <= self%spring_count)
      self%shown_bushings = pack(numbers, numbers > self%spring_count) - self%spring_count

   contains

      !> The one of a name.
      integer function number_of(name) result(number)
         character(*), intent(in) :: name
         integer :: j

         number = 0
         do j = 1, size(known)
            if (known(j) /= name) cycle
            if (number > 0 .and. len(name) > 0) &
               call raise(self%error, '', 'springs = "'//name//'": there are two of this name', 'rename one of them')
            number = j
         end do
         if (number == 0) call raise(self%error, '', 'springs = "'//name//'": there is no spring, damper or bushing of this name', &
                                     meant_of(name, known)//'se the name of a &spring, a &damper or a &bushing')
      end function number_of

   end procedure show_springs

   !> Something that passes a value.
   module procedure add_event
      character(len=12), parameter :: quantities(2) = [character(len=12) :: 'angle', 'displacement']
      type(event_t) :: made
      type(anchor_t) :: anchor

      if (allocated(self%error)) return
      made%name = trim(name)
      made%value = value
      if (len(made%name) == 0 .or. scan(made%name, ', ') > 0) &
         call raise(self%error, '', 'it has no name, or one with a blank or a comma', 'give name = "..."')
      if (self%event_names%find(made%name) > 0) &
         call raise(self%error, '', 'the name is taken: there are two of it', 'rename one of them')
      if (.not. abs(value) <= huge(value)) call raise(self%error, '', 'its value is not a number', 'correct it')
      if (present(joint) .eqv. present(point)) then
         call raise(self%error, '', 'it watches neither a joint nor a point, or both', 'give joint or point')
      else if (present(joint)) then
         made%joint = self%find_joint(joint, 'joint')
         made%angle = quantity == 'angle'
         if (.not. any(quantity == quantities)) &
            call raise(self%error, '', 'a joint has no quantity "'//trim(quantity)//'"', &
                       meant_of(quantity, quantities)//'se "angle" or "displacement"')
         if (.not. allocated(self%error)) then
            if (made%angle .and. .not. has_angle(self%joints(made%joint))) &
               call raise(self%error, '', 'joint "'//trim(joint)//'" has no angle', 'watch a revolute or a cylindrical joint')
            if (.not. made%angle .and. .not. has_displacement(self%joints(made%joint))) &
               call raise(self%error, '', 'joint "'//trim(joint)//'" has no displacement', 'watch another joint')
         end if
      else
         call self%find_anchor(point, 'point', anchor)
         made%body = anchor%body
         made%at = anchor%at
         made%axis = index('xyz', trim(quantity))
         if (len_trim(quantity) /= 1 .or. made%axis == 0) &
            call raise(self%error, '', 'a point has no quantity "'//trim(quantity)//'"', 'use "x", "y" or "z"')
      end if
      if (.not. allocated(self%error)) then
         call make_room_events(self)
         self%event_count = self%event_count + 1
         self%events(self%event_count) = made
         call self%event_names%add(made%name, self%event_count)
      end if
      call locate(self, 'event', name)
      if (made%angle) call note_angle(self, 'event', name, 'value', value)
   end procedure add_event

   !> Room for one more in the list, which doubles when it is full.
   subroutine make_room_functions(self)
      type(mechanism_builder_t), intent(inout) :: self
      type(time_function_t), allocatable :: more(:)

      if (.not. allocated(self%functions)) allocate (self%functions(16))
      if (self%function_count < ubound(self%functions, 1)) return
      allocate (more(2*self%function_count))
      more(:self%function_count) = self%functions
      call move_alloc(more, self%functions)
   end subroutine make_room_functions

   !> Room for one more in the list, which doubles when it is full.
   subroutine make_room_loads(self)
      type(mechanism_builder_t), intent(inout) :: self
      type(load_t), allocatable :: more(:)

      if (.not. allocated(self%loads)) allocate (self%loads(16))
      if (self%load_count < ubound(self%loads, 1)) return
      allocate (more(2*self%load_count))
      more(:self%load_count) = self%loads
      call move_alloc(more, self%loads)
   end subroutine make_room_loads

   !> Room for one more in the list, which doubles when it is full.
   subroutine make_room_springs(self)
      type(mechanism_builder_t), intent(inout) :: self
      type(spring_t), allocatable :: more(:)

      if (.not. allocated(self%springs)) allocate (self%springs(16))
      if (self%spring_count < ubound(self%springs, 1)) return
      allocate (more(2*self%spring_count))
      more(:self%spring_count) = self%springs
      call move_alloc(more, self%springs)
   end subroutine make_room_springs

   !> Room for one more in the list, which doubles when it is full.
   subroutine make_room_events(self)
      type(mechanism_builder_t), intent(inout) :: self
      type(event_t), allocatable :: more(:)

      if (.not. allocated(self%events)) allocate (self%events(16))
      if (self%event_count < ubound(self%events, 1)) return
      allocate (more(2*self%event_count))
      more(:self%event_count) = self%events
      call move_alloc(more, self%events)
   end subroutine make_room_events

end submodule taut_model_mechanism_builder_loads
