!> The observer that keeps what there is to know of a motion: arrays over its output points, and if asked for the motion between
!! them as a function of time.
module taut_constrained_history
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_constrained_method, only: constrained_ode_t, sample_t
   use taut_constrained_system, only: state_t
   use taut_constrained_system_tables, only: tabulated_system_t
   use taut_ode_observer, only: observer_t
   use taut_ode_step, only: step_t
   use taut_ode_system, only: inside_step, ode_system_t, rhs_ok
   implicit none (type, external)
   private
   public :: history_t

   !> Places in each step at which its continuous extension is kept: enough for polynomials of degree 7, which no stepper exceeds.
   integer, parameter :: places = 8

   !> What was seen at the output points, in order of time; while the integration goes on the first `points` entries count,
   !! afterwards there are no others.
   type, extends(observer_t) :: history_t
      !> Whether the motion between output points is kept too, for `state_at`.
      logical :: dense = .false.
      !> Number of points.
      integer :: points = 0
      !> Times [s]: (points).
      real(wp), allocatable :: t(:)
      !> Coordinates, velocities and other states: (n_x, points), (n, points), (n_w, points).
      real(wp), allocatable :: x(:, :), v(:, :), w(:, :)
      !> Multipliers of Eqs (14): (c, points).
      real(wp), allocatable :: lambda(:, :), mu(:, :)
      !> Energy [J], or not a number: (points).
      real(wp), allocatable :: energy(:)
      !> Work since the start [J], not a number where it is not known: (points).
      real(wp), allocatable :: work(:)
      !> Violations of the constraints at position, velocity and acceleration level, largest entries: (points).
      real(wp), allocatable :: phi(:), phidot(:), phiddot(:)
      !> What the system computes besides: (n_outputs, points).
      real(wp), allocatable :: outputs(:, :)
      !> The formulation, for names and for the projection of what lies between points.
      class(constrained_ode_t), allocatable, private :: ode
      type(sample_t), private :: seen = sample_t()
      type(state_t), private :: at = state_t()
      !> Steps: where each begins and ends [s], and its values: (2, steps), (size of y, places, steps).
      integer, private :: steps = 0
      real(wp), allocatable, private :: ends(:, :), values(:, :, :)
   contains
      procedure :: begin
      procedure :: observe
      procedure :: follow
      procedure :: finish
      procedure :: series
      procedure :: state_at
   end type history_t

contains

   !> Forgets an integration before.
   subroutine begin(self)
      !> The history.
      class(history_t), intent(inout) :: self

      self%points = 0
      self%steps = 0
      self%follows = self%dense
      if (allocated(self%ode)) deallocate (self%ode)
      if (allocated(self%t)) deallocate (self%t, self%x, self%v, self%w, self%lambda, self%mu, self%energy, self%work, self%phi, &
                                         self%phidot, self%phiddot, self%outputs)
      if (allocated(self%ends)) deallocate (self%ends, self%values)
   end subroutine begin

   !> Keeps a point.
   subroutine observe(self, ode, t, h, y, error)
      !> The history.
      class(history_t), intent(inout) :: self
      !> The system that is integrated, with a method for constraints.
      class(ode_system_t), intent(inout) :: ode
      !> Time [s].
      real(wp), intent(in) :: t
      !> The step [s].
      real(wp), intent(in) :: h
      !> State: (size of y).
      real(wp), intent(in), contiguous :: y(:)
      !> A system that is no constrained one, or a state where nothing is defined.
      type(error_t), allocatable, intent(inout) :: error
      integer :: info

      select type (ode)
      class is (constrained_ode_t)
         if (self%points == 0) call make_room(self, ode)
         call ode%sample(t, y, self%seen, info)
         if (info /= rhs_ok) then
            call raise(error, 'history', 'multipliers are not defined at t = '//to_text(t)//' s', 'end the motion before')
            return
         end if
         call ode%unpack(t, y, self%at)
         self%at%t = t
         call keep(self)
      class default
         call raise(error, 'history', 'the system has no constraints'' method', 'use trajectory_t')
      end select
      associate (unused_step => h)
      end associate
   end subroutine observe

   !> The first point: as many entries as the system has.
   subroutine make_room(self, ode)
      type(history_t), intent(inout) :: self
      class(constrained_ode_t), intent(in) :: ode
      integer :: n_outputs
      integer, parameter :: room = 256

      allocate (self%ode, source=ode)
      n_outputs = 0
      select type (model => ode%model)
      class is (tabulated_system_t)
         n_outputs = model%n_outputs
      end select
      associate (model => ode%model)
         allocate (self%t(room), self%energy(room), self%work(room), self%phi(room), self%phidot(room), self%phiddot(room))
         allocate (self%x(model%n_x, room), self%v(model%n, room), self%w(model%n_w, room), self%lambda(model%c, room), &
                   self%mu(model%c, room), self%outputs(n_outputs, room))
         if (allocated(self%at%x)) deallocate (self%at%x, self%at%v, self%at%w)
         allocate (self%at%x(model%n_x), self%at%v(model%n), self%at%w(model%n_w))
      end associate
      self%seen = sample_t()
   end subroutine make_room

   !> Adds the point that was seen last.
   subroutine keep(self)
      type(history_t), intent(inout) :: self

      if (self%points == size(self%t)) call resize(self, 2*self%points)
      self%points = self%points + 1
      associate (i => self%points, seen => self%seen)
         self%t(i) = self%at%t
         self%x(:, i) = self%at%x
         self%v(:, i) = self%at%v
         self%w(:, i) = self%at%w
         self%lambda(:, i) = seen%lambda
         self%mu(:, i) = seen%mu
         self%energy(i) = seen%energy
         self%work(i) = seen%work
         self%phi(i) = seen%phi
         self%phidot(i) = seen%phidot
         self%phiddot(i) = seen%phiddot
         if (size(self%outputs, 1) > 0) self%outputs(:, i) = seen%outputs
      end associate
   end subroutine keep

   !> Gives the arrays another number of points.
   pure subroutine resize(self, room)
      type(history_t), intent(inout) :: self
      integer, intent(in) :: room

      call resize_list(self%t, room)
      call resize_list(self%energy, room)
      call resize_list(self%work, room)
      call resize_list(self%phi, room)
      call resize_list(self%phidot, room)
      call resize_list(self%phiddot, room)
      call resize_table(self%x, room)
      call resize_table(self%v, room)
      call resize_table(self%w, room)
      call resize_table(self%lambda, room)
      call resize_table(self%mu, room)
      call resize_table(self%outputs, room)
   end subroutine resize

   pure subroutine resize_list(list, room)
      real(wp), allocatable, intent(inout) :: list(:)
      integer, intent(in) :: room
      real(wp), allocatable :: other(:)
      integer :: kept

      kept = min(room, size(list))
      allocate (other(room))
      other(:kept) = list(:kept)
      call move_alloc(other, list)
   end subroutine resize_list

   pure subroutine resize_table(table, room)
      real(wp), allocatable, intent(inout) :: table(:, :)
      integer, intent(in) :: room
      real(wp), allocatable :: other(:, :)
      integer :: kept

      kept = min(room, size(table, 2))
      allocate (other(size(table, 1), room))
      other(:, :kept) = table(:, :kept)
      call move_alloc(other, table)
   end subroutine resize_table

   !> Keeps the continuous extension of a step.
   subroutine follow(self, ode, step, t_last, error)
      !> The history.
      class(history_t), intent(inout) :: self
      !> The system that is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> The step.
      class(step_t), intent(inout) :: step
      !> Its end, or where an event ends it [s].
      real(wp), intent(in) :: t_last
      !> An interpolation that failed.
      type(error_t), allocatable, intent(inout) :: error
      real(wp), allocatable :: more(:, :, :)
      real(wp) :: t
      integer :: info, k, room

      if (.not. allocated(self%ends)) allocate (self%ends(2, 256), self%values(size(step%y), places, 256))
      room = size(self%ends, 2)
      if (self%steps == room) then
         call resize_table(self%ends, 2*room)
         allocate (more(size(step%y), places, 2*room))
         more(:, :, :room) = self%values
         call move_alloc(more, self%values)
      end if
      self%steps = self%steps + 1
      self%ends(:, self%steps) = [step%t, t_last]
      associate (values => self%values(:, :, self%steps))
         values(:, 1) = step%y
         values(:, places) = step%y_new
         do k = 2, places
            t = step%t + (t_last - step%t)*(k - 1)/(places - 1)
            if (k == places .and. abs(t_last - step%t_new) <= 0.0_wp) exit
            call step%interpolate(ode, t, info)
            if (info /= rhs_ok) then
               call raise(error, 'history', 'the motion inside the step that ends at t = '//to_text(t_last)// &
                          ' s is not to be had', 'tighten the tolerances')
               return
            end if
            values(:, k) = step%y_inside
         end do
      end associate
   end subroutine follow

   !> Gives the arrays the size of what they hold.
   subroutine finish(self)
      !> The history.
      class(history_t), intent(inout) :: self

      if (allocated(self%t)) call resize(self, self%points)
   end subroutine finish

   !> A column by its name: of a coordinate, a velocity or an output of the system, as tables have it.
   subroutine series(self, name, values, error)
      !> The history.
      class(history_t), intent(in) :: self
      !> The name, such as `x1`, or that of an output.
      character(*), intent(in) :: name
      !> Its values: (points).
      real(wp), allocatable, intent(out) :: values(:)
      !> A name that there is not.
      type(error_t), allocatable, intent(inout) :: error
      integer :: i

      if (allocated(self%ode)) then
         select type (model => self%ode%model)
         class is (tabulated_system_t)
            do i = 1, model%n_x
               if (model%x_name(i) == name) values = self%x(i, :self%points)
            end do
            do i = 1, model%n
               if (model%v_name(i) == name) values = self%v(i, :self%points)
            end do
            do i = 1, model%n_outputs
               if (model%output_name(i) == name) values = self%outputs(i, :self%points)
            end do
         end select
      end if
      if (.not. allocated(values)) call raise(error, 'history', 'there is no "'//name//'"', &
                                              'take a name that the system''s x_name, v_name or output_name gives')
   end subroutine series

   !> The state at any time that was passed, on the constraints: the stepper's own continuous extension, projected.
   subroutine state_at(self, t, at, error)
      !> The history, `dense`.
      class(history_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> The state.
      type(state_t), intent(out) :: at
      !> A time that was not passed, or a history that is not dense.
      type(error_t), allocatable, intent(inout) :: error
      real(wp), allocatable :: y(:)
      integer :: info, k
      logical :: stale

      k = step_of(self, t)
      if (k == 0) then
         call raise(error, 'history', 'nothing is known of t = '//to_text(t)//' s', &
                    'set dense = .true. before the integration, and ask for times that it has passed')
         return
      end if
      associate (begin => self%ends(1, k), end => self%ends(2, k))
         y = interpolated(self%values(:, :, k), (t - begin)/(end - begin))
      end associate
      call self%ode%project(t, y, inside_step, stale, info)
      if (info /= rhs_ok) then
         call raise(error, 'history', 'the projection failed at t = '//to_text(t)//' s', 'tighten the tolerances')
         return
      end if
      allocate (at%x(self%ode%model%n_x), at%v(self%ode%model%n), at%w(self%ode%model%n_w))
      call self%ode%unpack(t, y, at)
      at%t = t
   end subroutine state_at

   !> The step in which a time lies, by bisection; 0 if none.
   pure integer function step_of(self, t) result(k)
      type(history_t), intent(in) :: self
      real(wp), intent(in) :: t
      real(wp) :: direction
      integer :: high, middle

      k = 0
      if (self%steps == 0) return
      direction = sign(1.0_wp, self%ends(2, 1) - self%ends(1, 1))
      if ((t - self%ends(1, 1))*direction < 0.0_wp .or. (t - self%ends(2, self%steps))*direction > 0.0_wp) return
      k = 1
      high = self%steps
      do while (k < high)
         middle = (k + high)/2
         if ((t - self%ends(2, middle))*direction <= 0.0_wp) then
            high = middle
         else
            k = middle + 1
         end if
      end do
   end function step_of

   !> The polynomial through values at evenly spaced places, by Lagrange's formula in its second barycentric form.
   !!
   !! Source: J.-P. Berrut, L.N. Trefethen, Barycentric Lagrange interpolation, SIAM Rev. 46 (2004) 501-517, Eq. (4.2).
   pure function interpolated(values, theta) result(y)
      real(wp), intent(in) :: values(:, :), theta
      real(wp) :: y(size(values, 1))
      real(wp) :: distance, share, total
      integer :: j
      real(wp), parameter :: binomial(places) = [1.0_wp, -7.0_wp, 21.0_wp, -35.0_wp, 35.0_wp, -21.0_wp, 7.0_wp, -1.0_wp]

      y = 0.0_wp
      total = 0.0_wp
      do j = 1, places
         distance = theta - real(j - 1, wp)/(places - 1)
         if (abs(distance) <= tiny(1.0_wp)) then
            y = values(:, j)
            return
         end if
         share = binomial(j)/distance
         total = total + share
         y = y + share*values(:, j)
      end do
      y = y/total
   end function interpolated

end module taut_constrained_history
