!> The consistent start: an initial state is brought to the constraints, and told how far it was moved.
module taut_constrained_start
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_constrained_blow, only: blow_t
   use taut_constrained_method_options, only: method_t
   use taut_constrained_projection, only: projector_t
   use taut_constrained_system, only: check_supplied, mechanical_system_t, state_t
   use taut_constrained_system_tables, only: coordinate_name, velocity_name
   use taut_ode_system, only: rhs_ok
   implicit none (type, external)
   private
   public :: consistent_start, start_report_t

   !> What the consistent start did.
   type :: start_report_t
      !> Largest change of a coordinate, in its unit.
      real(wp) :: moved_x = 0.0_wp
      !> Largest change of a velocity, in its unit.
      real(wp) :: moved_v = 0.0_wp
      !> Violation of positions and velocities as given, largest entries.
      real(wp) :: phi_given = 0.0_wp, phidot_given = 0.0_wp
      !> Violation of positions that is left, largest entry: not round-off only if inconsistent constraints are accepted.
      real(wp) :: phi_left = 0.0_wp
      !> Iterations of Eq. (17).
      integer :: iterations = 0
      !> Rank of A.
      integer :: rank = 0
      !> Degrees of freedom: velocities less the rank.
      integer :: freedoms = 0
      !> Kinetic energy that the velocities have gained by being corrected [J]; negative: lost.
      real(wp) :: energy_gained = 0.0_wp
      !> The impulses that did it, of least norm: (c) [force s/unit of A v].
      real(wp), allocatable :: impulse(:)
   end type start_report_t

contains

   !> Brings an initial state to the constraints: x by Eq. (17) in the metric W, v by a blow, so in the metric M; where they are not
   !! enforced it stays.
   subroutine consistent_start(model, method, at, report, error, held)
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Weight, tolerances, solver.
      type(method_t), intent(in) :: method
      !> Initial state; x and v are replaced.
      type(state_t), intent(inout) :: at
      !> How far it was moved.
      type(start_report_t), intent(out) :: report
      !> Sizes that do not fit, or a state that no projection mends.
      type(error_t), allocatable, intent(inout) :: error
      !> Velocities that keep what they were given, and with them coordinates: (n). Default: none.
      logical, intent(in), optional :: held(:)
      type(blow_t) :: blow
      type(projector_t) :: projector, released
      type(method_t) :: patient
      real(wp), allocatable :: x(:), v(:)
      character(:), allocatable :: why
      integer :: i, info
      character(*), parameter :: here = 'initial state'

      call model%check_sizes(error)
      call method%check(error)
      if (allocated(error)) return
      if (.not. allocated(at%w)) allocate (at%w(0))
      if (.not. (allocated(at%x) .and. allocated(at%v))) then
         call raise(error, here, 'coordinates or velocities are not set', 'set both')
         return
      end if
      if (size(at%x) /= model%n_x .or. size(at%v) /= model%n .or. size(at%w) /= model%n_w) then
         call raise(error, here, 'it has '//to_text(size(at%x))//' coordinates, '//to_text(size(at%v))//' velocities and '// &
                    to_text(size(at%w))//' other states for '//to_text(model%n_x)//', '//to_text(model%n)//' and '// &
                    to_text(model%n_w), 'give as many as the system has')
         return
      end if
      do i = 1, model%n_x
         if (.not. ieee_is_finite(at%x(i))) &
            call raise(error, here, trim(coordinate_name(model, i))//' is not a number', 'set it')
      end do
      do i = 1, model%n
         if (.not. ieee_is_finite(at%v(i))) &
            call raise(error, here, trim(velocity_name(model, i))//' is not a number', 'set it')
      end do
      if (.not. (all(ieee_is_finite(at%w)) .and. ieee_is_finite(at%t))) &
         call raise(error, here, 'the time or another state is not a number', 'set it')
      if (allocated(error)) return
      call check_supplied(model, at, error)
      if (allocated(error)) return
      report%freedoms = model%n
      allocate (report%impulse(model%c), source=0.0_wp)
      if (method%name == 'unconstrained') return
      allocate (x, source=at%x)
      allocate (v, source=at%v)
      ! Far from the constraints the iteration may need more patience than inside a step.
      patient = method
      patient%max_iterations = max(100, method%max_iterations)
      call projector%init(model, patient, held)
      call projector%lay_yardstick(model, at)
      call projector%position(model, at, info)
      report%phi_given = projector%newton%phi_raw
      report%phi_left = projector%newton%residual
      report%iterations = projector%newton%iterations
      if (info == rhs_ok) call projector%check_branch(model, at, info)
      if (info == rhs_ok) call projector%linear%linearize(model, at, info, 0.0_wp)
      if (info /= rhs_ok) then
         call projector%explain(model, why)
         call raise(error, here, why, 'start closer to the constraints, or correct them')
         return
      end if
      report%rank = projector%linear%onto%rank
      if (present(held)) then
         ! What is held is free again when the motion begins.
         call released%init(model, patient)
         call released%linear%linearize(model, at, info, 0.0_wp)
         report%rank = released%linear%onto%rank
      end if
      report%freedoms = model%n - report%rank
      call projector%velocity_violation(model, at)
      report%phidot_given = projector%phidot_raw()
      if (report%phidot_given > 0.0_wp) then
         call blow%strike(model, patient, at, info, held)
         if (info /= rhs_ok) then
            call raise(error, here, blow%why, 'correct the masses')
            return
         end if
         report%energy_gained = blow%energy
         report%impulse(:) = blow%impulse
         call projector%velocity_violation(model, at)
      end if
      if (projector%phidot_raw() > 1.0e-8_wp*max(1.0_wp, report%phidot_given) .and. .not. method%accept_inconsistent) then
         call raise(error, here, 'the velocity constraints are inconsistent: a violation of '//to_text(projector%phidot_raw())// &
                    ' is left', 'correct the constraints or their rates')
         return
      end if
      report%moved_x = maxval(abs(at%x - x))
      report%moved_v = maxval(abs(at%v - v))
   end subroutine consistent_start

end module taut_constrained_start
