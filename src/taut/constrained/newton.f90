!> Newton's iteration on the invariant manifold, Eqs (16) and (17): where it goes on, and where it is at its end.
module taut_constrained_newton
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_kinds, only: wp
   use taut_constrained_linearization, only: inconsistent, linearization_t, not_converged, not_finite
   use taut_constrained_method_options, only: method_t
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_constrained_yardstick, only: largest_entry, relative_violation, yardstick_t
   use taut_linalg_rank, only: pivot_floor
   use taut_ode_system, only: rhs_no_projection, rhs_ok, rhs_retry
   implicit none (type, external)
   private
   public :: newton_t

   !> Rows of A with errors up to this, relative to their size, have no redundant rows that exact ones do not have: see the
   !! use of `noise` by the solvers.
   real(wp), parameter :: harmless_noise = 1.0e-5_wp

   ! The decisions of Newton's iteration (17), where violations are measured by the yardstick.
   !> A and S are kept while an iteration leaves less than this part of phi. The simplified iteration then goes on at this rate or
   !! better: a second evaluation of A and S would cost more than the iteration that it may save.
   real(wp), parameter :: fast = 1.0e-3_wp
   !> The part of phi that a displacement is to reach, A d against phi: less than half of it, and the rank is in doubt.
   real(wp), parameter :: most = 0.5_wp
   !> Where a displacement reaches no more than this part of phi, the rest is normal to the range of A: the constraints contradict
   !! each other. Larger than what the condition of S leaves of round-off (the root of it), smaller than any violation that
   !! moves are able to mend.
   real(wp), parameter :: contradiction = 1.0e-6_wp
   !> A displacement that does not reduce phi is halved up to so many times: a thousandth of it does not help either.
   integer, parameter :: halvings = 10
   !> A violation that is left by the first correction is what round-off and the condition of S leave of it, up to so many times
   !! that which counts as none: what takes it off then says nothing of how the way back bends.
   real(wp), parameter :: worth_telling = 100.0_wp
   !> A displacement of more round-offs of the largest coordinate than this moves something.
   real(wp), parameter :: never_round_off = 8.0_wp*epsilon(1.0_wp)
   !> Growth of the sum of squares of phi that is round-off: where constraints are inconsistent, what can be reduced may be
   !! less than round-off of what cannot.
   real(wp), parameter :: no_growth = 1.0_wp + 8.0_wp*epsilon(1.0_wp)

   !> The iteration and its workspace.
   type :: newton_t
      !> When constraints are met.
      type(yardstick_t) :: yardstick
      !> Violation of the last position that was given to `position`, largest entry, before it was corrected.
      real(wp) :: phi_raw = 0.0_wp
      !> Violation that is left after `position`, largest entry; where it has failed, of the row that is violated most.
      real(wp) :: residual = 0.0_wp
      integer :: worst = 0
      !> Iterations of Eq. (17) in all, and how many there may be each time.
      integer :: iterations = 0, max_iterations = 25
      logical, private :: accept_inconsistent = .false.
      !> Corrections of the last `position`, and the coordinates after the first of several: (n_x).
      integer, private :: corrections = 0
      !> Whether the first of them has left a violation that is worth telling.
      logical, private :: left_some = .false.
      real(wp), allocatable, private :: x_first(:)
      !> A d: (n_phi); the coordinates before the displacement d: (n_x).
      real(wp), allocatable, private :: of_d(:), x_before(:)
   contains
      procedure, non_overridable :: init
      procedure, non_overridable :: position
      procedure, non_overridable :: position_again
      procedure, non_overridable :: later_corrections
   end type newton_t

contains

   !> Allocates the workspace; nothing is allocated afterwards.
   subroutine init(self, model, method)
      !> The iteration.
      class(newton_t), intent(inout) :: self
      !> The system whose constraints are met.
      class(mechanical_system_t), intent(in) :: model
      !> Tolerance, iterations.
      type(method_t), intent(in) :: method

      self%accept_inconsistent = method%accept_inconsistent
      self%max_iterations = method%max_iterations
      call self%yardstick%init(model%n_phi, model%n, method%projection_tolerance)
      if (allocated(self%of_d)) deallocate (self%of_d, self%x_before, self%x_first)
      allocate (self%of_d(model%n_phi), self%x_before(model%n_x), self%x_first(model%n_x), source=0.0_wp)
   end subroutine init

   !> Newton's iteration (17): x (+) (-W^-1 A^T S^+ phi) until all constraints are met.
   !!
   !! Source: Eqs (16), (17). A step that does not reduce phi is halved. A and S are kept while they reduce phi fast. Rows that
   !! were left out are to be met like the others: where they are not, `position_again` may help.
   subroutine position(self, linear, model, at, info, threshold, linearized)
      !> The iteration.
      class(newton_t), intent(inout) :: self
      !> A, W and S, renewed where they are asked for.
      class(linearization_t), intent(inout) :: linear
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Its state; x is replaced.
      type(state_t), intent(inout) :: at
      !> `rhs_ok`, `rhs_retry` (entries that are not finite) or `rhs_no_projection`.
      integer, intent(out) :: info
      !> Violation up to which nothing is done; default: the tolerance of the method.
      real(wp), intent(in), optional :: threshold
      !> Whether the last `linearize` was for this very x; default: no.
      logical, intent(in), optional :: linearized
      real(wp) :: left, left_before, length, most_plain, noise, reach
      integer :: iteration
      logical :: known, plain, renew, takes_all

      info = rhs_ok
      call model%normalize(at%x)
      self%residual = 0.0_wp
      self%phi_raw = 0.0_wp
      self%corrections = 0
      if (model%n_phi == 0) return
      call linear%evaluate_constraint(model, at)
      self%residual = largest_entry(linear%phi)
      if (.not. ieee_is_finite(self%residual)) then
         call give_up(self, linear, not_finite, info)
         return
      end if
      self%phi_raw = self%residual
      if (present(threshold)) then
         if (self%residual <= threshold) return
      end if
      if (self%residual <= self%yardstick%sure) return
      renew = .true.
      left_before = 0.0_wp
      known = .false.
      if (present(linearized)) known = linearized
      noise = 0.0_wp
      ! Coordinates may grow on the way.
      most_plain = 0.5_wp*self%yardstick%plain_up_to
      plain = largest_entry(at%x) <= most_plain
      do iteration = 1, self%max_iterations + 1
         left = self%residual
         if (.not. plain) left = self%yardstick%measure(linear%phi, at%x)
         if (left <= self%yardstick%tolerance) return
         if (iteration > 1) then
            ! What a system of the size 1 may leave is all there is to be had where constants are that large.
            if (self%residual <= self%yardstick%tolerance .and. left > most*left_before) return
            renew = left > fast*left_before
         end if
         if (iteration > self%max_iterations) exit
         self%iterations = self%iterations + 1
         if (renew) then
            if (.not. known) then
               call linear%evaluate(model, at)
               if (.not. linear%identity) call linear%renew_weight(model, at, info)
               if (info /= rhs_ok) return
            end if
            noise = 0.0_wp
            if (model%n_phi > 1 .and. (known .or. .not. linear%rows_are_known())) &
               noise = relative_violation(linear%phi, linear%a, at%x)
            renew = .not. (known .and. noise <= harmless_noise)
            known = .false.
         end if
         do
            call linear%find_displacement(renew, noise, self%corrections == 0, takes_all, info)
            length = largest_entry(linear%d)
            if (info /= rhs_ok .or. .not. ieee_is_finite(length)) then
               call give_up(self, linear, not_finite, info)
               return
            end if
            ! The size of A d: of what is left in phi, what d will change.
            reach = left
            if (takes_all) exit
            call linear%a%multiply(linear%d, self%of_d)
            reach = self%yardstick%measure(self%of_d, at%x)
            if (.not. (renew .and. noise > 0.0_wp .and. reach < most*left)) exit
            ! The noise may have taken rows that matter for redundant ones.
            noise = 0.0_wp
         end do
         if (reach <= self%yardstick%tolerance .or. (reach <= contradiction*left .and. .not. self%accept_inconsistent)) then
            if (.not. (self%accept_inconsistent .or. self%residual <= self%yardstick%tolerance)) &
               call give_up(self, linear, inconsistent, info)
            return
         end if
         if (reach >= most*left .and. .not. (plain .and. length > never_round_off*most_plain)) then
            if (self%yardstick%nothing_moves(linear%d, at%x)) return
         end if
         if (self%corrections == 1) then
            self%left_some = left > worth_telling*self%yardstick%tolerance
            self%x_first(:) = at%x
         end if
         self%corrections = self%corrections + 1
         left_before = left
         call move(self, linear, model, at, info)
         if (info /= rhs_ok) return
         if (self%residual <= self%yardstick%sure) return
      end do
      call give_up(self, linear, not_converged, info)
   end subroutine position

   !> Goes on where `position` has failed without some rows.
   !!
   !! Where rows were left out, those in charge may no longer be the right ones. Near a singular position rows are passed over, of
   !! which the others leave little: what violates them there is of second order in a displacement that only they can tell, so
   !! that with them it is reached, if by half of what is left each time.
   subroutine position_again(self, linear, model, at, info, threshold)
      !> The iteration, after a `position` that has failed.
      class(newton_t), intent(inout) :: self
      !> A, W and S, renewed where they are asked for.
      class(linearization_t), intent(inout) :: linear
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Its state; x is replaced.
      type(state_t), intent(inout) :: at
      !> What `position` said, and says now.
      integer, intent(inout) :: info
      !> As of `position`.
      real(wp), intent(in), optional :: threshold
      real(wp) :: cut

      if (linear%onto%rank < linear%onto%c .and. linear%keeper%holds) then
         call linear%release()
         call self%position(linear, model, at, info, threshold)
      end if
      if (info /= rhs_no_projection) return
      if (linear%weakest_holonomic() > 0.0_wp) return
      call linear%pass_over(pivot_floor, cut)
      call self%position(linear, model, at, info, threshold)
      call linear%pass_over(cut)
   end subroutine position_again

   !> x := x (+) d, with d halved until phi has become smaller.
   subroutine move(self, linear, model, at, info)
      type(newton_t), intent(inout) :: self
      class(linearization_t), intent(inout) :: linear
      class(mechanical_system_t), intent(in) :: model
      type(state_t), intent(inout) :: at
      integer, intent(out) :: info
      integer :: halving, i
      real(wp) :: largest_before, squares_before

      info = rhs_ok
      largest_before = self%residual
      squares_before = dot_product(linear%phi, linear%phi)
      !GCC$ unroll 1
      do i = 1, size(at%x)
         self%x_before(i) = at%x(i)
      end do
      do halving = 0, halvings
         call model%displace(linear%d, at%x)
         call model%normalize(at%x)
         call linear%evaluate_constraint(model, at)
         self%residual = largest_entry(linear%phi)
         if (ieee_is_finite(self%residual)) then
            if (self%residual <= self%yardstick%sure) return
            if (dot_product(linear%phi, linear%phi) <= squares_before*no_growth) return
         end if
         at%x(:) = self%x_before
         linear%d(:) = 0.5_wp*linear%d
      end do
      call linear%evaluate_constraint(model, at)
      self%residual = largest_before
      if (self%residual > self%yardstick%tolerance) call give_up(self, linear, not_converged, info)
   end subroutine move

   !> By how much the last `position` has moved x after its first correction.
   pure subroutine later_corrections(self, at, d, bends)
      !> The iteration.
      class(newton_t), intent(in) :: self
      !> The state that it left.
      type(state_t), intent(in) :: at
      !> Displacement, if there is any: (n_x).
      real(wp), intent(inout), contiguous :: d(:)
      !> Whether there is.
      logical, intent(out) :: bends

      bends = self%corrections > 1 .and. self%left_some
      if (bends) d(:) = at%x - self%x_first
   end subroutine later_corrections

   !> Notes why a projection failed.
   subroutine give_up(self, linear, reason, info)
      type(newton_t), intent(inout) :: self
      class(linearization_t), intent(inout) :: linear
      integer, intent(in) :: reason
      integer, intent(out) :: info

      linear%reason = reason
      self%worst = 0
      info = rhs_retry
      if (reason == not_converged .or. reason == inconsistent) then
         info = rhs_no_projection
         self%worst = maxloc(abs(linear%phi), 1)
         self%residual = abs(linear%phi(self%worst))
      end if
   end subroutine give_up

end module taut_constrained_newton
