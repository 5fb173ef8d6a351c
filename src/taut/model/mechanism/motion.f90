!> Where the bodies of a mechanism are, how they move, and their masses.
submodule(taut_model_mechanism) taut_model_mechanism_motion
   use taut_model_mechanism_body, only: ground_pose
   implicit none (type, external)

contains

   !> The state at the start as given, t = 0.
   module procedure start_state
      integer :: i

      allocate (at%x(self%n_x), at%v(self%n), at%w(0), source=0.0_wp)
      do i = 1, size(self%bodies)
         call self%bodies(i)%start(at%x, at%v)
      end do
   end procedure start_state

   !> Where a body is and how it moves.
   module procedure pose_of
      if (body == 0) then
         call ground_pose(it)
      else
         call self%bodies(body)%pose(at%x, at%v, it)
      end if
   end procedure pose_of

   !> Forgets all poses.
   module procedure clear
      self%body = -1
   end procedure clear

   !> The places of the poses of two bodies, computed where they are not there.
   module procedure find
      one = iand(body_1, places - 1)
      two = iand(body_2, places - 1)
      if (one == two) two = places
      if (self%body(one) /= body_1) then
         self%body(one) = body_1
         call model%pose_of(at, body_1, self%it(one))
      end if
      if (self%body(two) /= body_2) then
         self%body(two) = body_2
         call model%pose_of(at, body_2, self%it(two))
      end if
   end procedure find

   !> M: mass and inertia of each body.
   module procedure mass
      real(wp) :: d(self%n)
      integer :: b, i, k

      do i = 1, size(self%bodies)
         associate (body => self%bodies(i))
            do k = 1, velocities_of_kind(body%kind)
               associate (entry => entry_of_velocity(k, body%kind))
                  d(body%before_v + k) = body%m
                  if (entry > 3) d(body%before_v + k) = body%j(entry - 3, entry - 3)
               end associate
            end do
         end associate
      end do
      call m%set_diagonal(d)
      b = 0
      do i = 1, size(self%bodies)
         b = b + merge(velocities_of_kind(self%bodies(i)%kind), 4, self%bodies(i)%diagonal())
         if (.not. self%bodies(i)%diagonal()) call m%set_block(b, self%bodies(i)%j)
      end do
      associate (unused_state => at)
      end associate
   end procedure mass

   !> xdot, body by body.
   module procedure x_rate
      integer :: i

      do i = 1, size(self%bodies)
         call self%bodies(i)%rate(at%x, u, value)
      end do
   end procedure x_rate

   !> The inverse of `x_rate`.
   module procedure v_of_x_rate
      integer :: i

      do i = 1, size(self%bodies)
         call self%bodies(i)%velocity_of_rate(at%x, rate, u)
      end do
   end procedure v_of_x_rate

   !> x := x (+) d, body by body.
   module procedure displace
      integer :: i

      do i = 1, size(self%bodies)
         call self%bodies(i)%move(d, x)
      end do
   end procedure displace

   !> Quaternions of length one.
   module procedure normalize
      integer :: i

      do i = 1, size(self%bodies)
         call self%bodies(i)%normalize(x)
      end do
   end procedure normalize

   !> Times at which a function is not smooth.
   module procedure breakpoints
      integer :: i

      allocate (times(0))
      do i = 1, size(self%functions)
         times = [times, self%functions(i)%breakpoints()]
      end do
   end procedure breakpoints

end submodule taut_model_mechanism_motion
