!> What the way of a projection says of a step: singular positions are passed, driven linkages stay on their branch.
module test_projection_check
   use taut, only: block_diagonal_t, error_t, integration_options_t, integration_result_t, mechanical_system_t, method_t, &
                   simulate, simulation_t, state_t, status_reached_end, wp
   use taut_error, only: to_text
   use taut_model_n_four_bar, only: n_four_bar_t, new_n_four_bar
   use taut_ode_integrate, only: integrator_t
   use taut_ode_system, only: ode_system_t, rhs_ok
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_projection_check

   !> A crank of length 1, a coupler and a rocker that are 2.5 and 1.5 plus a gap, on pivots that are 3 apart: but for the gap
   !! all are in line once a turn. x = {tip of the crank; joint of coupler and rocker}. Lengths in any unit.
   type, extends(mechanical_system_t) :: crank_rocker_t
      real(wp) :: gap = 0.0_wp, unit = 1.0_wp
      !> Whether the crank is driven at 1 rad/s; else it begins with that speed.
      logical :: driven = .true.
   contains
      procedure :: mass
      procedure :: force
      procedure :: constraint
      procedure :: jacobian
      procedure :: velocity_rhs
      procedure :: acceleration_rhs
   end type crank_rocker_t

   !> The angle of the N-four-bar, whose cranks stay parallel: y = {angle from the upward vertical, rate}.
   type, extends(ode_system_t) :: one_angle_t
      real(wp) :: factor = 0.0_wp
   contains
      procedure :: rhs
   end type one_angle_t

contains

   !> All tests of this module.
   function collect_projection_check() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('singular positions at every tolerance', singular_positions), &
               new_test('starts in and near a singular position', singular_starts), &
               new_test('a long row of loops', long_row), &
               new_test('singular positions by the implicit integrator', implicit_passes), &
               new_test('a driven linkage keeps its branch', driven_keeps), &
               new_test('a driven linkage keeps its branch through narrow gaps', driven_through_narrow_gaps), &
               new_test('where branches meet', branches_that_meet), &
               new_test('a free linkage keeps its branch', free_keeps), &
               new_test('in any unit of length', any_unit), &
               new_test('a step of more than a turn', long_step)]
   end function collect_projection_check

   subroutine mass(self, at, m)
      class(crank_rocker_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m

      m%values(:) = 1.0_wp
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine mass

   subroutine force(self, at, value)
      class(crank_rocker_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = 0.0_wp
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine force

   !> Vectors along coupler and rocker.
   subroutine bars(self, at, d, r)
      class(crank_rocker_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: d(2), r(2)

      d = at%x(3:4) - at%x(1:2)
      r = at%x(3:4) - [3.0_wp*self%unit, 0.0_wp]
   end subroutine bars

   subroutine constraint(self, at, value)
      class(crank_rocker_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      real(wp) :: d(2), r(2)

      call bars(self, at, d, r)
      value(1) = norm2(d) - 2.5_wp*self%unit
      value(2) = norm2(r) - (1.5_wp + self%gap)*self%unit
      if (self%driven) then
         value(3:4) = at%x(1:2) - self%unit*[cos(at%t), sin(at%t)]
      else
         value(3) = norm2(at%x(1:2)) - self%unit
      end if
   end subroutine constraint

   subroutine jacobian(self, at, a)
      class(crank_rocker_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)
      real(wp) :: d(2), r(2)

      call bars(self, at, d, r)
      a = 0.0_wp
      a(1, :) = [-d, d]/norm2(d)
      a(2, 3:4) = r/norm2(r)
      if (self%driven) then
         a(3, 1) = 1.0_wp
         a(4, 2) = 1.0_wp
      else
         a(3, 1:2) = at%x(1:2)/norm2(at%x(1:2))
      end if
   end subroutine jacobian

   subroutine velocity_rhs(self, at, value)
      class(crank_rocker_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value = 0.0_wp
      if (self%driven) value(3:4) = self%unit*[-sin(at%t), cos(at%t)]
   end subroutine velocity_rhs

   subroutine acceleration_rhs(self, at, value)
      class(crank_rocker_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      real(wp) :: d(2), r(2)

      call bars(self, at, d, r)
      value(1) = turning(d, at%v(3:4) - at%v(1:2))
      value(2) = turning(r, at%v(3:4))
      if (self%driven) then
         value(3:4) = -self%unit*[cos(at%t), sin(at%t)]
      else
         value(3) = turning(at%x(1:2), at%v(1:2))
      end if
   end subroutine acceleration_rhs

   !> -|d x v|^2/|d|^3.
   pure real(wp) function turning(d, v)
      real(wp), intent(in) :: d(2), v(2)

      turning = -(d(1)*v(2) - d(2)*v(1))**2/norm2(d)**3
   end function turning

   !> The linkage at an angle of its crank, its joint above.
   subroutine new_crank_rocker(model, at, gap, angle, unit, driven)
      type(crank_rocker_t), intent(out) :: model
      type(state_t), intent(out) :: at
      real(wp), intent(in) :: gap, angle, unit
      logical, intent(in) :: driven

      model%gap = gap
      model%unit = unit
      model%driven = driven
      call model%define(n=4, c=merge(4, 3, driven), mass_blocks=[1, 1, 1, 1])
      at%t = angle
      allocate (at%x(4))
      at%x(1:2) = unit*[cos(angle), sin(angle)]
      at%x(3:4) = unit*upper_joint(gap, angle)
      at%v = unit*[-sin(angle), cos(angle), 0.0_wp, 0.0_wp]
   end subroutine new_crank_rocker

   !> The joint by the law of cosines, on the side on which it starts.
   pure function upper_joint(gap, angle) result(joint)
      real(wp), intent(in) :: gap, angle
      real(wp) :: joint(2), tip(2), across(2), distance, along

      tip = [cos(angle), sin(angle)]
      across = [3.0_wp, 0.0_wp] - tip
      distance = norm2(across)
      along = (2.5_wp**2 + distance**2 - (1.5_wp + gap)**2)/(2.0_wp*distance)
      joint = tip + (along*across + sqrt(max(0.0_wp, 2.5_wp**2 - along**2))*[-across(2), across(1)])/distance
   end function upper_joint

   subroutine rhs(self, t, y, dydt, info)
      class(one_angle_t), intent(inout) :: self
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(out), contiguous :: dydt(:)
      integer, intent(out) :: info

      info = rhs_ok
      dydt = [y(2), self%factor*sin(y(1))]
      associate (unused => t)
      end associate
   end subroutine rhs

   !> One row of loops against one angle: status, cranks that stay parallel, and where they are.
   subroutine run_row(windows, angle, speed, t_end, rtol, failure, integrator_name)
      integer, intent(in) :: windows
      real(wp), intent(in) :: angle, speed, t_end, rtol
      character(:), allocatable, intent(inout) :: failure
      character(*), intent(in), optional :: integrator_name
      type(n_four_bar_t) :: model
      type(one_angle_t) :: reference
      type(integrator_t) :: integrator
      type(state_t) :: at
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      real(wp) :: bound, t, y(2)
      character(:), allocatable :: name
      integer :: i

      name = to_text(windows)//' loops, '//to_text(speed)//' m/s, rtol '//to_text(rtol)//': '
      call new_n_four_bar(model, windows, 1.0_wp, 1.0_wp, 9.81_wp, error)
      call no_error(failure, error)
      call model%start(angle, speed, at)
      options%rtol = rtol
      options%atol = 1.0e-3_wp*rtol
      if (present(integrator_name)) then
         options%integrator = integrator_name
         ! Its iteration does not get below what the projection's tolerance leaves.
         options%atol = rtol
      end if
      call simulate(model, at, t_end, result, error, options=options)
      call no_error(failure, error)
      call check(failure, result%status == status_reached_end, name//'it does not pass')
      if (allocated(failure)) return
      ! N + 1 cranks with an inertia of 1/3 and half their weight, N couplers that move as their ends do.
      reference%factor = 9.81_wp*(0.5_wp*(windows + 1) + windows)/((windows + 1)/3.0_wp + windows)
      options = integration_options_t(integrator='dop853', rtol=1.0e-13_wp, atol=1.0e-13_wp)
      call integrator%init(2, options, error)
      call no_error(failure, error)
      t = 0.0_wp
      y = [angle, speed]
      call integrator%run(reference, t, y, t_end, result)
      ! What the projection's tolerance of 1e-12 leaves of x is enlarged near a singular position; the other branch is off by one.
      bound = max(1.0e-5_wp, 3.0e3_wp*rtol)
      do i = 0, windows
         call check_below(failure, at%x(4*i + 1) - i - sin(y(1)), bound, name//'x of a crank')
         call check_below(failure, at%x(4*i + 2) - cos(y(1)), bound, name//'z of a crank')
      end do
   end subroutine run_row

   subroutine singular_positions(failure)
      character(:), allocatable, intent(inout) :: failure
      integer :: i, j

      do i = 1, 10, 3
         do j = 3, 12, 3
            call run_row(2, 0.0_wp, real(i, wp), 1.5_wp, 10.0_wp**(-j), failure)
         end do
      end do
   end subroutine singular_positions

   subroutine singular_starts(failure)
      character(:), allocatable, intent(inout) :: failure
      real(wp), parameter :: level = acos(0.0_wp), off(5) = [0.0_wp, 1.0e-12_wp, 1.0e-8_wp, 1.0e-6_wp, 1.0e-4_wp]
      integer :: i, j

      do i = 1, size(off)
         do j = 6, 12, 3
            call run_row(2, level - off(i), 1.0_wp, 1.0_wp, 10.0_wp**(-j), failure)
         end do
      end do
   end subroutine singular_starts

   subroutine long_row(failure)
      character(:), allocatable, intent(inout) :: failure

      call run_row(40, 0.0_wp, 3.0_wp, 0.7_wp, 1.0e-8_wp, failure)
   end subroutine long_row

   subroutine implicit_passes(failure)
      character(:), allocatable, intent(inout) :: failure

      call run_row(2, 0.0_wp, 3.0_wp, 1.5_wp, 1.0e-8_wp, failure, 'radau')
      call run_row(20, 0.0_wp, 3.0_wp, 0.8_wp, 1.0e-6_wp, failure, 'radau')
   end subroutine implicit_passes

   !> Turns the crank twice from some angles, and compares with the law of cosines.
   subroutine turn(driven, integrator, gap, rtol, failure)
      logical, intent(in) :: driven
      character(*), intent(in) :: integrator
      real(wp), intent(in) :: gap, rtol
      character(:), allocatable, intent(inout) :: failure
      type(crank_rocker_t) :: model
      type(state_t) :: at
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      real(wp) :: angle, joint(2)
      character(:), allocatable :: name
      integer :: i

      options%integrator = integrator
      options%rtol = rtol
      options%atol = 1.0e-3_wp*rtol
      do i = 0, 4
         name = integrator//', gap '//to_text(gap)//', rtol '//to_text(rtol)//', start '//to_text(i)//': '
         call new_crank_rocker(model, at, gap, 1.3_wp*i, 1.0_wp, driven)
         call simulate(model, at, at%t + 12.0_wp, result, error, options=options)
         call no_error(failure, error)
         call check(failure, result%status == status_reached_end, name//'it stops')
         if (allocated(failure)) return
         angle = atan2(at%x(2), at%x(1))
         joint = upper_joint(gap, angle)
         call check_below(failure, maxval(abs(at%x(3:4) - joint)), 1.0e-4_wp, name//'the other branch')
      end do
   end subroutine turn

   subroutine driven_keeps(failure)
      character(:), allocatable, intent(inout) :: failure
      integer :: j

      do j = 2, 9
         call turn(.true., 'dopri5', 1.0e-2_wp, 10.0_wp**(-j), failure)
         if (j >= 3) call turn(.true., 'dopri5', 1.0e-3_wp, 10.0_wp**(-j), failure)
         if (j >= 4) call turn(.true., 'dopri5', 1.0e-4_wp, 10.0_wp**(-j), failure)
      end do
      call turn(.true., 'dop853', 1.0e-3_wp, 1.0e-6_wp, failure)
   end subroutine driven_keeps

   !> Gaps that no step sees: what is left is the sign of the determinant.
   subroutine driven_through_narrow_gaps(failure)
      character(:), allocatable, intent(inout) :: failure
      integer :: j, k

      do j = 2, 9
         do k = 4, 6
            call turn(.true., 'dopri5', 10.0_wp**(-k), 10.0_wp**(-j), failure)
         end do
      end do
      call turn(.true., 'dop853', 1.0e-6_wp, 1.0e-3_wp, failure)
      call turn(.true., 'radau', 1.0e-6_wp, 1.0e-3_wp, failure)
   end subroutine driven_through_narrow_gaps

   !> Without a gap branches meet: the motion goes on straight, and that is told.
   subroutine branches_that_meet(failure)
      character(:), allocatable, intent(inout) :: failure
      type(crank_rocker_t) :: model
      type(state_t) :: at
      type(simulation_t) :: simulation
      type(error_t), allocatable :: error
      character(:), allocatable :: remark

      call new_crank_rocker(model, at, 0.0_wp, 1.3_wp, 1.0_wp, .true.)
      call simulation%init(model, error, options=integration_options_t(rtol=1.0e-6_wp))
      call no_error(failure, error)
      call simulation%run(at, at%t + 12.0_wp, error)
      call no_error(failure, error)
      call check(failure, simulation%result%status == status_reached_end, 'it stops')
      call simulation%ode%remark(remark)
      call check(failure, index(remark, 'where branches of the motion meet: 2') > 0, remark)
   end subroutine branches_that_meet

   subroutine free_keeps(failure)
      character(:), allocatable, intent(inout) :: failure
      integer :: j

      do j = 3, 9, 2
         call turn(.false., 'dopri5', 1.0e-3_wp, 10.0_wp**(-j), failure)
      end do
   end subroutine free_keeps

   !> The same steps in any unit, for what is asked is in tolerances.
   subroutine any_unit(failure)
      character(:), allocatable, intent(inout) :: failure
      real(wp), parameter :: units(3) = [1.0_wp, 1.0e-6_wp, 4.0e7_wp]
      type(crank_rocker_t) :: model
      type(state_t) :: at
      type(method_t) :: method
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      integer :: i, j, steps(3)

      do j = 5, 9, 4
         do i = 1, 3
            options%rtol = 10.0_wp**(-j)
            options%atol = 1.0e-3_wp*options%rtol*units(i)
            ! Of a large system less may be asked for than the default, which is near round-off there.
            method%projection_tolerance = 1.0e-12_wp*max(1.0_wp, units(i))
            call new_crank_rocker(model, at, 1.0e-2_wp, 0.0_wp, units(i), .true.)
            call simulate(model, at, 12.0_wp, result, error, method, options)
            call no_error(failure, error)
            call check(failure, result%status == status_reached_end, 'the end')
            steps(i) = result%steps + result%rejected
            call check_below(failure, maxval(abs(at%x(3:4)/units(i) - upper_joint(1.0e-2_wp, at%t))), 1.0e-9_wp, 'the branch')
         end do
         call check(failure, maxval(steps) - minval(steps) <= maxval(steps)/10, 'as many steps')
      end do
   end subroutine any_unit

   !> All is driven, so that there is no error but that which the projection takes off; steps must not grow past what it sees.
   subroutine long_step(failure)
      character(:), allocatable, intent(inout) :: failure
      type(crank_rocker_t) :: model
      type(state_t) :: at
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(error_t), allocatable :: error

      call new_crank_rocker(model, at, 1.0_wp, 0.0_wp, 1.0_wp, .true.)
      call simulate(model, at, 200.0_wp, result, error, options=options)
      call no_error(failure, error)
      call check(failure, result%status == status_reached_end, 'the end')
      call check(failure, result%steps > 200, 'steps of a turn and more')
      call check_below(failure, maxval(abs(at%x(3:4) - upper_joint(1.0_wp, at%t))), 1.0e-9_wp, 'the branch')
   end subroutine long_step

end module test_projection_check
