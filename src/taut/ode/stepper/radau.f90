!> Radau IIA of order 5: three implicit stages, L-stable, with Newton's iteration simplified and split into a real and a complex
!! part.
!!
!! Source: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., Springer 1996, Sect. IV.8. Deviations, for
!! mechanics with constraints and stiff parts: the error estimate takes the derivative at the step's start from the step
!! before instead of evaluating a stiff force again, errors of velocities count with the step's length, and algebraic unknowns stay
!! out of all norms.
module taut_ode_stepper_radau
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   use taut_ode_newton, only: most_iterations
   use taut_ode_projection_check, only: projection_holds
   use taut_ode_step_control, only: step_control_t
   use taut_ode_stepper_implicit, only: implicit_stepper_t
   use taut_ode_stepper_radau_tableau, only: b, b_low, c, d, e, from_modes, increments, nu, through_stages, to_modes
   use taut_ode_system, only: ode_system_t, rhs_cannot, rhs_failed, rhs_ok, step_end
   implicit none (type, external)
   private
   public :: radau_t

   !> The least error that the predictive controller remembers.
   real(wp), parameter :: least_error = 1.0e-2_wp
   !> Limits of the change of a step, and safety.
   real(wp), parameter :: largest_growth = 8.0_wp, largest_reduction = 0.2_wp, safety = 0.9_wp

   !> The stepper and what it remembers.
   type, extends(implicit_stepper_t) :: radau_t
      !> Error of the last accepted step.
      real(wp), private :: error_old = 0.0_wp
      !> Derivative at the step's end: (n).
      real(wp), allocatable, private :: ydot_new(:)
      !> Increments of the stages and their algebraic unknowns, of this try and of the step before.
      real(wp), allocatable, private :: y_stage(:, :), z_stage(:, :), y_last(:, :), z_last(:, :)
      !> Whether a try of this step was rejected for its end, where motions that branch cannot be told apart.
      logical, private :: evades = .false.
      !> The system's integrand at the stages.
      real(wp), private :: integrand(3) = 0.0_wp
      !> The state at the step's start, and what the projection has added at its end.
      real(wp), allocatable, private :: y_start(:), shift(:)
      real(wp), allocatable, private :: r(:, :), rate(:), state(:), work_y(:), work_r(:)
      complex(wp), allocatable, private :: r_real(:), r_complex(:)
   contains
      procedure :: init
      procedure :: start
      procedure :: try
      procedure :: accept
      procedure :: prepare_dense
      procedure :: interpolate
      procedure :: integral_inside
      procedure :: serialize
   end type radau_t

contains

   !> Allocates the workspace of the state.
   subroutine init(self, n)
      !> The stepper.
      class(radau_t), intent(inout) :: self
      !> Number of entries of the state.
      integer, intent(in) :: n

      self%n = n
      self%order = 5
      self%takes_integral = .true.
      self%estimates_integral = .true.
      allocate (self%ydot(n), self%ydot_new(n), self%y_stage(n, 3), self%y_last(n, 3), self%rate(n), self%state(n), &
                self%work_y(n), self%y_start(n), self%shift(n), source=0.0_wp)
   end subroutine init

   !> Takes the equations of a system; nothing is allocated afterwards.
   subroutine meet_system(self, ode)
      type(radau_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      integer :: n

      if (allocated(self%newton%equations)) return
      call self%newton%meet(ode, self%n)
      n = self%newton%equations%n_z
      self%n_z = n
      if (.not. allocated(self%z)) then
         allocate (self%z(n), self%z_stage(n, 3), self%z_last(n, 3), source=0.0_wp)
      end if
      if (.not. allocated(self%z_stage)) allocate (self%z_stage(n, 3), source=0.0_wp)
      n = self%n + n
      allocate (self%r(n, 3), self%work_r(n), source=0.0_wp)
      allocate (self%r_real(n), self%r_complex(n), source=(0.0_wp, 0.0_wp))
   end subroutine meet_system

   !> At a start, or behind a breakpoint: forgets the steps before.
   subroutine start(self, ode, t, y, info)
      !> The stepper.
      class(radau_t), intent(inout) :: self
      !> What is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> Time [s].
      real(wp), intent(in) :: t
      !> State: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      call meet_system(self, ode)
      call self%begin(ode, t, y, info)
      self%evades = .false.
      self%error_old = least_error
   end subroutine start

   !> One try.
   subroutine try(self, ode, control, t, y, t_new, h, y_new, h_next, accepted, info)
      !> The stepper.
      class(radau_t), intent(inout) :: self
      !> What is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> Its norm is used.
      type(step_control_t), intent(inout) :: control
      !> Time at its start [s].
      real(wp), intent(in) :: t
      !> State at its start: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Time at its end [s].
      real(wp), intent(in) :: t_new
      !> Its length [s].
      real(wp), intent(in) :: h
      !> State at its end: (n).
      real(wp), intent(out), contiguous :: y_new(:)
      !> Length of the next try [s].
      real(wp), intent(out) :: h_next
      !> Whether the step holds.
      logical, intent(out) :: accepted
      !> `rhs_ok`, or why there is no new state.
      integer, intent(out) :: info
      integer :: i
      logical :: again, converged, stale, told, yields

      accepted = .false.
      h_next = h
      y_new(:) = y
      do
         call get_matrices(self, ode, t, y, h, info)
         if (info /= rhs_ok) then
            call self%give_up(h, h_next)
            return
         end if
         if (self%newton%equations%at_dead_point) then
            call hold(self, ode, t, y, h, yields, info)
            if (yields) cycle
            if (info /= rhs_ok) then
               call self%give_up(h, h_next)
               return
            end if
         end if
         call iterate(self, ode, control, t, y, t_new, h, converged, info)
         call self%newton%count(self%work)
         if (converged .and. .not. self%newton%doubtful) exit
         if (info == rhs_failed .or. info == rhs_cannot) return
         if (converged .or. (self%newton%fresh .and. info == rhs_ok)) then
            call hold(self, ode, t, y, h, yields, info)
            if (yields) cycle
            converged = converged .and. info == rhs_ok
         end if
         if (converged) exit
         call self%improve(control, self%work_y, y, self%state, h, h_next, again, info)
         if (.not. again) return
      end do
      do i = 1, self%n
         y_new(i) = y(i) + self%y_stage(i, 3)
      end do
      call combine(self%y_stage, d(3, :)/h, self%ydot_new)
      if (control%fixed) then
         accepted = .true.
      else
         call judge(self, ode, control, y, y_new, h, accepted, h_next)
         if (.not. accepted) return
      end if
      ! Behind the last correction: what the residual was computed with is off by that.
      if (ode%has_integral) then
         do i = 1, 3
            call at_stage(self, y, h, i)
            call self%newton%equations%find_integrand(ode, merge(t_new, t + c(i)*h, i == 3), self%state, self%z_stage(:, i))
            self%integrand(i) = ode%integrand
         end do
         call self%newton%count(self%work)
      end if
      self%y_start(:) = y
      self%state(:) = y_new
      call ode%project(t_new, y_new, step_end, stale, info)
      if (info /= rhs_ok) then
         accepted = .false.
         call self%shorten(h, h_next)
         return
      end if
      if (self%newton%yields) then
         ! What was held is seen in the way back only.
         self%rate(:) = self%state - y_new
         accepted = projection_holds(control, ode, self%rate, y, y_new, self%work_y)
         if (.not. accepted) then
            call self%give_up(h, h_next)
            return
         end if
         call take_back(self, ode, control, t_new, h, y, y_new, told)
         if (.not. (told .or. self%evades)) then
            ! Such a place at the end of this step is in the middle of the next one, if both are of this length.
            self%evades = .true.
            self%rejected = .true.
            call self%newton%drop()
            accepted = .false.
            h_next = 2.0_wp/3.0_wp*h
            return
         end if
         ! What was held has no history.
         call self%newton%start(ode, t_new, y_new, .false., self%ydot_new, self%z_stage(:, 3), self%work, info)
         ! In a step that holds something there is freedom.
         ode%integral_counts = .false.
         if (info /= rhs_ok) then
            accepted = .false.
            call self%give_up(h, h_next)
            return
         end if
      end if
      self%shift(:) = y_new - self%state
      self%h_try = h
      self%gain = h*dot_product(b, self%integrand)
      self%gain_error = abs(self%gain - h*(self%integrand_behind*b_low(1) + dot_product(b_low(2:), self%integrand(:2))))
      self%integrand_before = self%integrand_behind
      self%integrand_behind = self%integrand(3)
   end subroutine try

   !> Lets the equations hold what hampers the step, if there is anything; that has no history.
   subroutine hold(self, ode, t, y, h, yields, info)
      type(radau_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t, h
      real(wp), intent(in), contiguous :: y(:)
      logical, intent(out) :: yields
      integer, intent(out) :: info

      call self%newton%yield(ode, t, h, y, self%ydot, self%z, yields, info)
      yields = yields .and. info == rhs_ok
      if (yields .and. self%has_history) self%z_last(:, :) = spread(self%z, 2, 3)
   end subroutine hold

   !> What the projection has tolerated of what was held is taken back, if it is more than round-off would make anyway.
   subroutine take_back(self, ode, control, t_new, h, y, y_new, told)
      type(radau_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      type(step_control_t), intent(in) :: control
      real(wp), intent(in) :: t_new, h
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(inout), contiguous :: y_new(:)
      !> Whether it was taken back, or is no more than a singular position makes of round-off.
      logical, intent(out) :: told
      real(wp) :: of_round_off, way

      self%rate(:) = y_new
      call self%newton%equations%take_back(ode, t_new, self%rate, self%work_y)
      self%work_y(:) = self%work_y - self%rate
      call ode%weigh_error(h, self%work_y)
      of_round_off = control%norm(self%work_y, y, y_new)
      self%work_y(:) = self%rate - y_new
      call ode%weigh_error(h, self%work_y)
      way = control%norm(self%work_y, y, y_new)
      told = of_round_off < way .or. way <= self%newton%most_round_off
      if (of_round_off < way) y_new(:) = self%rate
   end subroutine take_back

   !> A Jacobian, and its factors for the step.
   subroutine get_matrices(self, ode, t, y, h, info)
      type(radau_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t, h
      real(wp), intent(in), contiguous :: y(:)
      integer, intent(out) :: info
      integer :: i

      info = rhs_ok
      if (.not. allocated(self%newton%equations)) then
         ! Behind a restart.
         call meet_system(self, ode)
         call self%newton%restore(ode, nu, info)
         if (info /= rhs_ok) return
      end if
      call predict(self, h)
      ! At the predicted second stage, in the middle of the step.
      self%state(:) = y + self%y_stage(:, 2)
      call combine(self%y_stage, d(2, :)/h, self%rate)
      call self%newton%prepare(ode, t + c(2)*h, h, self%state, self%rate, self%z_stage(:, 2), nu, self%work, info)
      if (info /= rhs_ok) return
      do i = 1, 3
         call self%newton%equations%settle(self%z, self%z_stage(:, i))
      end do
   end subroutine get_matrices

   !> The error of a step, and the length of the next.
   subroutine judge(self, ode, control, y, y_new, h, accepted, h_next)
      type(radau_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      type(step_control_t), intent(in) :: control
      real(wp), intent(in), contiguous :: y(:), y_new(:)
      real(wp), intent(in) :: h
      logical, intent(out) :: accepted
      real(wp), intent(out) :: h_next
      integer :: i
      real(wp) :: factor, growth, size_of_error

      call combine(self%y_stage, e/h, self%work_y)
      do i = 1, self%n
         self%work_y(i) = self%work_y(i) + self%ydot(i)
      end do
      call self%newton%equations%multiply(self%work_y, self%work_r)
      do i = 1, size(self%work_r)
         self%r_real(i) = -self%work_r(i)
      end do
      call self%newton%equations%solve(ode, 1, self%r_real)
      do i = 1, self%n
         self%work_y(i) = real(self%r_real(i), wp)
      end do
      ! Multipliers take the part normal to the constraints off by themselves.
      if (self%n_z == 0) call ode%filter_error(self%work_y)
      call ode%weigh_error(h, self%work_y)
      size_of_error = max(control%norm(self%work_y, y, y_new), 1.0e-10_wp)

      factor = safety*real(2*most_iterations + 1, wp)/real(2*most_iterations + self%newton%used, wp)
      growth = factor/size_of_error**0.25_wp
      accepted = size_of_error <= 1.0_wp
      if (.not. accepted) then
         h_next = h*max(largest_reduction, min(growth, safety))
         self%rejected = .true.
         return
      end if
      ! The predictive controller of Gustafsson: as the error grew, it will grow.
      if (self%has_history) growth = min(growth, factor*(h/self%h_old)*(self%error_old/size_of_error**2)**0.25_wp)
      growth = min(largest_growth, max(largest_reduction, growth))
      if (self%rejected) growth = min(1.0_wp, growth)
      self%error_old = max(least_error, size_of_error)
      h_next = growth*h
      call self%limit(h, h_next)
   end subroutine judge

   !> The stages as the polynomial of the step before has them.
   subroutine predict(self, h)
      type(radau_t), intent(inout) :: self
      real(wp), intent(in) :: h
      integer :: i, j
      real(wp) :: theta

      do i = 1, 3
         if (self%has_history) then
            theta = 1.0_wp + c(i)*h/self%h_old
            call combine(self%y_last, increments(theta) - [0.0_wp, 0.0_wp, 1.0_wp], self%y_stage(:, i))
            call combine(self%z_last, through_stages(theta), self%z_stage(:, i))
         else
            do j = 1, self%n
               self%y_stage(j, i) = c(i)*h*self%ydot(j)
            end do
            do j = 1, self%n_z
               self%z_stage(j, i) = self%z(j)
            end do
         end if
      end do
   end subroutine predict

   !> A sum of three columns.
   pure subroutine combine(columns, weights, sum)
      real(wp), intent(in), contiguous :: columns(:, :)
      real(wp), intent(in) :: weights(3)
      real(wp), intent(out), contiguous :: sum(:)
      integer :: i

      do i = 1, size(sum)
         sum(i) = weights(1)*columns(i, 1) + weights(2)*columns(i, 2) + weights(3)*columns(i, 3)
      end do
   end subroutine combine

   !> Newton's iteration on the three stages.
   subroutine iterate(self, ode, control, t, y, t_new, h, converged, info)
      type(radau_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      type(step_control_t), intent(in) :: control
      real(wp), intent(in) :: t, t_new, h
      real(wp), intent(in), contiguous :: y(:)
      integer, intent(out) :: info
      logical, intent(out) :: converged
      integer :: i
      real(wp) :: change, of_round_off
      logical :: hopes

      converged = .false.
      call self%newton%begin(control, y)
      do
         self%work%iterations = self%work%iterations + 1
         do i = 1, 3
            call at_stage(self, y, h, i)
            call self%newton%equations%residual(ode, merge(t_new, t + c(i)*h, i == 3), self%state, self%rate, self%z_stage(:, i), &
                                         self%r(:, i), info)
            if (info /= rhs_ok) return
         end do
         call correct(self, ode, control, y, h, 1.0_wp, change)
         call self%newton%judge(change, converged, hopes)
         if (converged) return
         if (.not. hopes) exit
      end do
      ! The last correction is kept to tell by: there is no derivative at the step's end yet.
      self%ydot_new(:) = self%work_y
      do i = 1, 3
         call at_stage(self, y, h, i)
         call self%newton%draw_round_off(i, self%state, self%rate, self%z_stage(:, i), self%r(:, i))
      end do
      call correct(self, ode, control, y, h, 0.0_wp, of_round_off)
      call self%newton%judge_round_off(change, of_round_off, converged)
      self%work_y(:) = self%ydot_new
   end subroutine iterate

   !> State and derivative at a stage.
   pure subroutine at_stage(self, y, h, i)
      type(radau_t), intent(inout) :: self
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(in) :: h
      integer, intent(in) :: i
      integer :: j

      call combine(self%y_stage, d(i, :)/h, self%rate)
      do j = 1, self%n
         self%state(j) = y(j) + self%y_stage(j, i)
      end do
   end subroutine at_stage

   !> Newton's corrections of the residuals in `r`, and their size in units of the tolerance.
   subroutine correct(self, ode, control, y, h, share, change)
      type(radau_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      type(step_control_t), intent(in) :: control
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(in) :: h
      !> What of them moves the stages: 1, or 0 to have their size only.
      real(wp), intent(in) :: share
      real(wp), intent(out) :: change
      integer :: i, j, n
      real(wp) :: mode(3)

      n = self%n
      ! Residuals in the modes of d, then the corrections back in the stages.
      do j = 1, size(self%work_r)
         mode = to_modes(:, 1)*self%r(j, 1) + to_modes(:, 2)*self%r(j, 2) + to_modes(:, 3)*self%r(j, 3)
         self%r_real(j) = mode(1)
         self%r_complex(j) = cmplx(mode(2), mode(3), wp)
      end do
      call self%newton%equations%solve(ode, 1, self%r_real)
      call self%newton%equations%solve(ode, 2, self%r_complex)
      change = 0.0_wp
      do i = 1, 3
         do j = 1, size(self%work_r)
            self%work_r(j) = from_modes(i, 1)*real(self%r_real(j), wp) + from_modes(i, 2)*real(self%r_complex(j), wp) + &
                             from_modes(i, 3)*aimag(self%r_complex(j))
         end do
         do j = 1, n
            self%y_stage(j, i) = self%y_stage(j, i) + share*self%work_r(j)
            self%work_y(j) = self%work_r(j)
            self%state(j) = y(j) + self%y_stage(j, i)
         end do
         do j = 1, self%n_z
            self%z_stage(j, i) = self%z_stage(j, i) + share*self%work_r(n + j)
         end do
         call ode%weigh_error(h, self%work_y)
         change = change + control%norm(self%work_y, y, self%state)**2
      end do
      change = sqrt(change/3.0_wp)
   end subroutine correct

   !> The end of the last try is where the next one starts.
   subroutine accept(self)
      !> The stepper, behind a try that holds.
      class(radau_t), intent(inout) :: self
      integer :: i, j

      do i = 1, 3
         do j = 1, self%n
            self%y_last(j, i) = self%y_stage(j, i) + self%shift(j)
         end do
         do j = 1, self%n_z
            self%z_last(j, i) = self%z_stage(j, merge(3, i, self%newton%yields))
         end do
      end do
      do j = 1, self%n
         self%ydot(j) = self%ydot_new(j)
      end do
      do j = 1, self%n_z
         self%z(j) = self%z_stage(j, 3)
      end do
      self%evades = .false.
      call self%advance()
   end subroutine accept

   !> The polynomial through the step's start and its stages is there already.
   subroutine prepare_dense(self, ode, t, y, t_new, h, y_new, info)
      !> The stepper, behind a try that holds.
      class(radau_t), intent(inout) :: self
      !> What is integrated: not asked.
      class(ode_system_t), intent(inout) :: ode
      !> Time at the step's start [s].
      real(wp), intent(in) :: t
      !> State at the step's start: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Time at the step's end [s].
      real(wp), intent(in) :: t_new
      !> The step's length [s].
      real(wp), intent(in) :: h
      !> State at the step's end: (n).
      real(wp), intent(in), contiguous :: y_new(:)
      !> Always `rhs_ok`.
      integer, intent(out) :: info

      info = rhs_ok
      self%y_start(:) = y
      self%shift(:) = y_new - y - self%y_stage(:, 3)
      associate (unused_system => ode, unused_start => t, unused_end => t_new, unused_step => h)
      end associate
   end subroutine prepare_dense

   !> The polynomial of degree 3, of order 3 where a stiff motion is not resolved and 4 else, with its end moved to where the
   !! projection has.
   subroutine interpolate(self, theta, y)
      !> The stepper.
      class(radau_t), intent(in) :: self
      !> Fraction of the step, 0 at its start and 1 at its end.
      real(wp), intent(in) :: theta
      !> State: (n).
      real(wp), intent(out), contiguous :: y(:)
      integer :: i

      call combine(self%y_stage, increments(theta), y)
      do i = 1, self%n
         y(i) = self%y_start(i) + (y(i) + theta*self%shift(i))
      end do
   end subroutine interpolate

   !> The integral of the polynomial through the integrands of the stages, by Simpson's rule, which is exact for it.
   pure function integral_inside(self, h, theta) result(value)
      !> The stepper, behind a try that holds.
      class(radau_t), intent(in) :: self
      !> The step's length [s].
      real(wp), intent(in) :: h
      !> Fraction of the step.
      real(wp), intent(in) :: theta
      !> The integral, zero at the step's start.
      real(wp) :: value

      value = h*theta/6.0_wp*dot_product(through_stages(0.0_wp) + 4.0_wp*through_stages(0.5_wp*theta) + through_stages(theta), &
                                         self%integrand)
   end function integral_inside

   !> Passes what is remembered between two steps through an archive; matrices are built again from where they were built.
   subroutine serialize(self, archive)
      !> The stepper, initialized.
      class(radau_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      call archive%item('last step', self%h_old)
      call archive%item('last error', self%error_old)
      call archive%item('longest step', self%cap)
      call archive%item('has history', self%has_history)
      call archive%item('was rejected', self%rejected)
      call archive%item('evades', self%evades)
      call archive%item('knows z', self%knows_z)
      call archive%item('ydot', self%ydot)
      call archive%item('integrand', self%integrand_behind)
      call archive%list('z', self%z)
      call pass_stages('increments', self%y_last)
      call pass_stages('z of the stages', self%z_last)
      call self%newton%serialize(archive)
      if (archive%reading .and. allocated(self%r)) deallocate (self%r, self%work_r, self%r_real, &
                                                                       self%r_complex, self%z_stage)

   contains

      subroutine pass_stages(name, stages)
         character(*), intent(in) :: name
         real(wp), allocatable, intent(inout) :: stages(:, :)
         real(wp), allocatable :: flat(:)

         if (allocated(stages)) then
            flat = reshape(stages, [size(stages)])
         else
            allocate (flat(0))
         end if
         call archive%list(name, flat)
         if (archive%reading .and. .not. allocated(archive%error)) stages = reshape(flat, [size(flat)/3, 3])
      end subroutine pass_stages

   end subroutine serialize

end module taut_ode_stepper_radau
