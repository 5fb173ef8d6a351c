!> Forces and moments on a node that keep their directions and follow a history in time.
module taut_model_dead_load
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   implicit none (type, external)
   private
   public :: dead_load_t

   !> A load.
   type :: dead_load_t
      !> Index of the node.
      integer :: node = 0
      !> In global axes [N], [N m].
      real(wp) :: force(3) = 0.0_wp, moment(3) = 0.0_wp
      !> Times in increasing order [s], and the factors at these; empty for a constant load.
      real(wp), allocatable :: times(:), factors(:)
   contains
      procedure :: set
      procedure :: factor
      procedure :: add_to
   end type dead_load_t

   character(*), parameter :: here = 'load'

contains

   !> Sets a load.
   subroutine set(self, node, force, moment, error, times, factors)
      !> The load.
      class(dead_load_t), intent(inout) :: self
      !> Index of the node.
      integer, intent(in) :: node
      !> Force in global axes [N].
      real(wp), intent(in) :: force(3)
      !> Moment in global axes [N m].
      real(wp), intent(in) :: moment(3)
      !> A value that makes no sense.
      type(error_t), allocatable, intent(inout) :: error
      !> Times [s], increasing. Default: none.
      real(wp), intent(in), optional :: times(:)
      !> What the load is multiplied with at these times: linear between them, constant outside. Default: 1.
      real(wp), intent(in), optional :: factors(:)
      integer :: n

      self%node = node
      self%force = force
      self%moment = moment
      self%times = [real(wp) ::]
      self%factors = [real(wp) ::]
      if (present(times)) self%times = times
      if (present(factors)) self%factors = factors
      n = size(self%times)
      if (.not. all(abs([force, moment]) <= huge(1.0_wp))) then
         call raise(error, here, 'a force or a moment is not a number', 'give newtons and newton metres')
      else if (size(self%factors) /= n) then
         call raise(error, here, 'it has '//to_text(n)//' times and '//to_text(size(self%factors))//' factors', &
                    'give as many of both')
      else if (.not. (all(abs(self%times) <= huge(1.0_wp)) .and. all(abs(self%factors) <= huge(1.0_wp)))) then
         call raise(error, here, 'a time or a factor is not a number', 'give seconds and factors')
      else if (any(self%times(2:n) <= self%times(1:n - 1))) then
         call raise(error, here, 'its times do not increase', 'give them in increasing order')
      end if
   end subroutine set

   !> What the load is multiplied with at a time.
   pure function factor(self, t)
      !> The load.
      class(dead_load_t), intent(in) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> The factor.
      real(wp) :: factor
      integer :: i, n

      factor = 1.0_wp
      n = size(self%times)
      if (n == 0) return
      factor = self%factors(n)
      if (t >= self%times(n)) return
      factor = self%factors(1)
      do i = 1, n - 1
         if (t < self%times(i + 1)) exit
      end do
      if (t <= self%times(1)) return
      factor = self%factors(i) + (self%factors(i + 1) - self%factors(i))*(t - self%times(i))/(self%times(i + 1) - self%times(i))
   end function factor

   !> Adds the load at a time to the force and the moment on its node.
   pure subroutine add_to(self, t, total)
      !> The load.
      class(dead_load_t), intent(in) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> Force and moment [N], [N m].
      real(wp), intent(inout) :: total(6)
      real(wp) :: now

      now = self%factor(t)
      total(1:3) = total(1:3) + now*self%force
      total(4:6) = total(4:6) + now*self%moment
   end subroutine add_to

end module taut_model_dead_load
