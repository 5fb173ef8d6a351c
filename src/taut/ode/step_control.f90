!> Error norms and step-size controllers.
module taut_ode_step_control
   use taut_kinds, only: wp
   use taut_archive, only: archive_t
   use taut_error, only: error_t, raise, to_text
   use taut_ode_options, only: integration_options_t
   implicit none (type, external)
   private
   public :: controller_constants_t, step_control_t

   integer, parameter :: standard = 1, fixed = 2, odepkg_2009 = 3

   real(wp), parameter :: safety = 0.9_wp
   !> A relative tolerance below so much asks for more digits than there are.
   real(wp), parameter :: least_rtol = 10.0_wp*epsilon(1.0_wp)

   !> Constants of the standard controller (PI), h_new/h = safety last_error^memory/error^exponent within bounds: E. Hairer,
   !! S.P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed., Springer 1993, Sect. II.4, and vol. II,
   !! Sect. IV.2. A stepper states those that suit its error estimate.
   type :: controller_constants_t
      !> Powers of the error and of the one before.
      real(wp) :: exponent = 0.0_wp, memory = 0.0_wp
      !> Bounds of h_new/h.
      real(wp) :: largest_decrease = 0.2_wp, largest_increase = 5.0_wp
   end type controller_constants_t

   !> Decides whether a step is accepted and how long the next one is.
   type :: step_control_t
      !> Whether the steps are all of one length.
      logical :: fixed = .false.
      !> Whether what the projection takes off is left out of the error, and gross violations are rejected.
      logical :: aware_of_projection = .true.
      !> Relative tolerance.
      real(wp) :: rtol = 0.0_wp
      !> See `projection_holds`.
      real(wp) :: projection_limit = 0.0_wp
      type(controller_constants_t), private :: constants
      !> Power of an error where the stepper states none, as of an integral or in the step control of 2009: one over the order.
      real(wp), private :: power = 0.0_wp
      integer, private :: kind = standard
      logical, private :: rms = .true.
      real(wp), private :: previous_error = 1.0e-4_wp
      logical, private :: last_rejected = .false.
      !> Error of the integral for which the last try from here was refused, 0 if none was; length of the first of these [s].
      real(wp), private :: error_refused = 0.0_wp, h_refused = 0.0_wp
      real(wp), allocatable, private :: atol(:)
      !> Entries that have a part in the norm: those of a tolerance that is not endless.
      integer, private :: counted = 0
   contains
      procedure, non_overridable :: init
      procedure, non_overridable :: renew
      procedure, non_overridable :: norm
      procedure, non_overridable :: last_places
      procedure, non_overridable :: cautious_start
      procedure, non_overridable :: largest
      procedure, non_overridable :: decide
      procedure, non_overridable :: decide_by_integral
      procedure, non_overridable :: step_on
      procedure, non_overridable :: reduce
      procedure, non_overridable :: serialize
   end type step_control_t

contains

   !> Ten units in the last place of a state, as the norm has them; where the absolute tolerance is above the relative one, entries
   !! below 1 count as 1.
   pure function last_places(self, y) result(size_of_them)
      !> The control, initialized.
      class(step_control_t), intent(in) :: self
      !> The state: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> The largest of any entry.
      real(wp) :: size_of_them
      integer :: i

      size_of_them = 0.0_wp
      do i = 1, size(y)
         size_of_them = max(size_of_them, 10.0_wp*epsilon(1.0_wp)*(abs(y(i)) + min(1.0_wp, self%atol(i)/self%rtol))/ &
                            (self%atol(i) + self%rtol*abs(y(i))))
      end do
   end function last_places

   !> Sets the controller up.
   subroutine init(self, n, options, order, constants, error)
      !> The controller.
      class(step_control_t), intent(out) :: self
      !> Size of the state.
      integer, intent(in) :: n
      !> Tolerances, the controller's name and that of the norm.
      type(integration_options_t), intent(in) :: options
      !> Order of the solution that is continued.
      integer, intent(in) :: order
      !> What suits the stepper's error estimate.
      type(controller_constants_t), intent(in) :: constants
      !> A name or a number that is not valid.
      type(error_t), allocatable, intent(inout) :: error

      select case (options%step_control)
      case ('standard')
         self%kind = standard
      case ('fixed')
         self%kind = fixed
      case ('odepkg-2009')
         self%kind = odepkg_2009
      case default
         call raise(error, 'integration options', 'step_control = "'//trim(options%step_control)//'" is unknown', &
                    'use "standard", "fixed" or "odepkg-2009"')
      end select
      if (options%norm /= 'rms' .and. options%norm /= 'max') &
         call raise(error, 'integration options', 'norm = "'//trim(options%norm)//'" is unknown', 'use "rms" or "max"')
      if (.not. (options%rtol > 0.0_wp .and. options%rtol < 1.0_wp)) &
         call raise(error, 'integration options', 'rtol = '//to_text(options%rtol)//' is not between 0 and 1', &
                    'give a relative tolerance such as 1e-6')
      if (options%rtol > 0.0_wp .and. options%rtol < least_rtol) &
         call raise(error, 'integration options', 'rtol = '//to_text(options%rtol)//' is below the round-off of double precision', &
                    'give '//to_text(least_rtol)//' or more')
      if (.not. options%atol > 0.0_wp) &
         call raise(error, 'integration options', 'atol = '//to_text(options%atol)//' is not positive', &
                    'give an absolute tolerance such as 1e-9')
      allocate (self%atol(n), source=options%atol)
      if (allocated(options%atol_of)) then
         if (size(options%atol_of) /= n) then
            call raise(error, 'integration options', 'atol_of has '//to_text(size(options%atol_of))//' entries for a state of '// &
                       to_text(n), 'give one absolute tolerance for each entry of the state')
         else if (.not. all(options%atol_of > 0.0_wp)) then
            call raise(error, 'integration options', 'an entry of atol_of is not positive', &
                       'give positive absolute tolerances')
         else
            self%atol(:) = options%atol_of
         end if
      end if
      self%counted = count(self%atol < huge(1.0_wp))
      self%rms = options%norm == 'rms'
      self%rtol = options%rtol
      self%projection_limit = options%projection_limit
      self%constants = constants
      self%power = 1.0_wp/order
      self%fixed = self%kind == fixed
      self%aware_of_projection = self%kind == standard
   end subroutine init

   !> Forgets the steps before: at the start, and where the right-hand side has a kink or a jump.
   pure subroutine renew(self)
      !> The controller.
      class(step_control_t), intent(inout) :: self

      self%previous_error = 1.0e-4_wp
      self%last_rejected = .false.
      self%error_refused = 0.0_wp
   end subroutine renew

   !> A vector in units of the tolerance: rms or largest of d_i/(atol_i + rtol max(|y0_i|, |y1_i|)).
   pure function norm(self, d, y0, y1, before) result(value)
      !> The controller.
      class(step_control_t), intent(in) :: self
      !> What is measured: (n).
      real(wp), intent(in), contiguous :: d(:)
      !> One state that sets the scale: (n).
      real(wp), intent(in), contiguous :: y0(:)
      !> Another one: (n).
      real(wp), intent(in), contiguous :: y1(:)
      !> How many entries of the state come before what is measured. Default: none.
      integer, intent(in), optional :: before
      !> Its norm; 1 is at the tolerance.
      real(wp) :: value
      real(wp) :: other, ratio, second
      integer :: first, i, n

      first = 0
      if (present(before)) first = before
      value = 0.0_wp
      associate (atol => self%atol, rtol => self%rtol)
         if (self%rms) then
            ! Two at a time, which the processor does at once. The bound keeps the squares from overflowing.
            n = size(d)/2
            other = 0.0_wp
            !GCC$ unroll 1
            do i = 1, n
               ratio = min(abs(d(2*i - 1))/(atol(first + 2*i - 1) + rtol*max(abs(y0(2*i - 1)), abs(y1(2*i - 1)))), 1.0e100_wp)
               second = min(abs(d(2*i))/(atol(first + 2*i) + rtol*max(abs(y0(2*i)), abs(y1(2*i)))), 1.0e100_wp)
               value = value + ratio*ratio
               other = other + second*second
            end do
            do i = 2*n + 1, size(d)
               ratio = min(abs(d(i))/(atol(first + i) + rtol*max(abs(y0(i)), abs(y1(i)))), 1.0e100_wp)
               value = value + ratio*ratio
            end do
            value = sqrt((value + other)/max(1, self%counted))
         else
            do i = 1, size(d)
               value = max(value, abs(d(i))/(atol(first + i) + rtol*max(abs(y0(i)), abs(y1(i)))))
            end do
         end if
      end associate
   end function norm

   !> Which entry of a vector is the largest in units of the tolerance.
   pure integer function largest(self, d, y0, y1)
      !> The controller.
      class(step_control_t), intent(in) :: self
      !> What is measured: (n).
      real(wp), intent(in), contiguous :: d(:)
      !> One state that sets the scale: (n).
      real(wp), intent(in), contiguous :: y0(:)
      !> Another one: (n).
      real(wp), intent(in), contiguous :: y1(:)
      real(wp) :: most, ratio
      integer :: i

      largest = 1
      most = 0.0_wp
      do i = 1, size(d)
         ratio = abs(d(i))/(self%atol(i) + self%rtol*max(abs(y0(i)), abs(y1(i))))
         ! Also if it is not a number.
         if (ratio <= most) cycle
         most = ratio
         largest = i
      end do
   end function largest

   !> Length of a first step where a state's derivative is all that is known: by which the state moves by a thousandth of itself.
   pure function cautious_start(self, ydot, y, longest) result(h)
      !> The controller.
      class(step_control_t), intent(in) :: self
      !> Derivative: (n).
      real(wp), intent(in), contiguous :: ydot(:)
      !> State: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Length of the longest first step, with the sign of the direction [s].
      real(wp), intent(in) :: longest
      !> Proposed length, with the sign of the direction [s].
      real(wp) :: h
      real(wp) :: scale, slope

      h = 1.0e-6_wp
      slope = self%norm(ydot, y, y)
      scale = self%norm(y, y, y)
      if (slope > 1.0e-5_wp .and. scale > 1.0e-5_wp) h = max(h, 1.0e-3_wp*scale/slope)
      h = sign(min(h, 1.0e-3_wp*abs(longest)), longest)
   end function cautious_start

   !> Judges a step and proposes the length of the next.
   pure subroutine decide(self, h, error, y0, y1, h_next, accepted)
      !> The controller, whose memory is brought up to date.
      class(step_control_t), intent(inout) :: self
      !> Step [s].
      real(wp), intent(in) :: h
      !> Estimates of its local error, the first of the higher order: (n, 1 or 2). Two are taken together as in Hairer's code
      !! DOP853, E1^2/sqrt(E1^2 + 0.01 E2^2), Sect. II.10 of the book.
      real(wp), intent(in), contiguous :: error(:, :)
      !> State at the step's start: (n).
      real(wp), intent(in), contiguous :: y0(:)
      !> State at the step's end: (n).
      real(wp), intent(in), contiguous :: y1(:)
      !> Length of the next try [s].
      real(wp), intent(out) :: h_next
      !> Whether the step holds.
      logical, intent(out) :: accepted
      real(wp) :: factor, lower, size_of_error, tau
      integer :: i

      select case (self%kind)
      case (fixed)
         accepted = .true.
         h_next = h
      case (odepkg_2009)
         ! The error test of ode45 in Octave's OdePkg as it was in 2009, signed: no absolute values on either side.
         accepted = .true.
         h_next = huge(1.0_wp)
         do i = 1, size(error, 1)
            tau = max(self%rtol*y0(i), self%atol(i))
            if (error(i, 1) > tau) accepted = .false.
            h_next = min(h_next, 0.8_wp*abs(h)*(tau/max(error(i, 1), epsilon(1.0_wp)))**self%power)
         end do
         h_next = sign(h_next, h)
      case default
         size_of_error = self%norm(error(:, 1), y0, y1)
         if (size(error, 2) > 1 .and. size_of_error > 0.0_wp) then
            lower = self%norm(error(:, 2), y0, y1)
            size_of_error = size_of_error*(size_of_error/sqrt(size_of_error**2 + 0.01_wp*lower**2))
         end if
         accepted = size_of_error <= 1.0_wp
         if (accepted) then
            factor = self%constants%largest_increase
            if (size_of_error > 0.0_wp) &
               factor = safety*self%previous_error**self%constants%memory/size_of_error**self%constants%exponent
            factor = min(self%constants%largest_increase, max(self%constants%largest_decrease, factor))
            if (self%last_rejected) factor = min(1.0_wp, factor)
            self%previous_error = max(size_of_error, 1.0e-4_wp)
         else
            factor = max(self%constants%largest_decrease, safety/size_of_error**self%constants%exponent)
         end if
         self%last_rejected = .not. accepted
         h_next = factor*h
      end select
   end subroutine decide

   !> Judges a step that holds by an integral that goes along; only the standard control does.
   pure subroutine decide_by_integral(self, h, error, amount, unit, h_next, accepted, vain)
      !> The controller, whose memory is brought up to date.
      class(step_control_t), intent(inout) :: self
      !> Step [s].
      real(wp), intent(in) :: h
      !> Estimate of the integral's local error.
      real(wp), intent(in) :: error
      !> What it is compared with, times the relative tolerance.
      real(wp), intent(in) :: amount
      !> What it is compared with, times the absolute tolerance.
      real(wp), intent(in) :: unit
      !> Length of the next try, which is made no longer than the integral allows [s].
      real(wp), intent(inout) :: h_next
      !> Whether the step holds.
      logical, intent(out) :: accepted
      !> Whether it does for shorter ones are of no use: what there is of an integrand at its end is round-off.
      logical, intent(out) :: vain
      real(wp) :: factor, ratio

      accepted = .true.
      vain = .false.
      if (self%kind /= standard .or. .not. error > 0.0_wp) return
      ratio = min(error/max(self%rtol*amount + minval(self%atol)*unit, tiny(1.0_wp)), 1.0e100_wp)
      accepted = ratio <= 1.0_wp
      if (.not. accepted) then
         ! An error that does not fall with the step is round-off of the integrand, which no shorter step makes smaller: the one that
         ! was refused first was no worse, and the next one may be longer.
         vain = self%error_refused > 0.0_wp .and. error >= self%error_refused
         accepted = vain
         if (vain) then
            h_next = sign(max(abs(h_next), 2.0_wp*abs(self%h_refused)), h)
            return
         end if
         if (.not. self%error_refused > 0.0_wp) self%h_refused = h
         self%error_refused = error
         self%last_rejected = .true.
      end if
      factor = max(self%constants%largest_decrease, safety/ratio**self%power)
      if (factor*abs(h) < abs(h_next)) h_next = factor*h
   end subroutine decide_by_integral

   !> A step holds: what was refused on the way there is forgotten.
   pure subroutine step_on(self)
      !> The controller.
      class(step_control_t), intent(inout) :: self

      self%error_refused = 0.0_wp
   end subroutine step_on

   !> The next try after a step that failed for another reason than its error.
   pure subroutine reduce(self, h)
      !> The controller, whose memory is brought up to date.
      class(step_control_t), intent(inout) :: self
      !> Step that failed, replaced by a quarter of it [s].
      real(wp), intent(inout) :: h

      self%last_rejected = .true.
      h = 0.25_wp*h
   end subroutine reduce

   !> Passes the controller's memory through an archive; what `init` was given is not part of it.
   subroutine serialize(self, archive)
      !> The controller.
      class(step_control_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      call archive%item('previous error', self%previous_error)
      call archive%item('last rejected', self%last_rejected)
      call archive%item('error of the integral refused', self%error_refused)
      call archive%item('step refused for the integral', self%h_refused)
   end subroutine serialize

end module taut_ode_step_control
