!> Assembling a mechanism: from where it is drawn to its joints, while some coordinates may keep the values they were given.
module taut_model_mechanism_assembly
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise
   use taut_constrained_method_options, only: method_t
   use taut_constrained_start, only: consistent_start, start_report_t
   use taut_constrained_system, only: state_t
   use taut_linalg_null_space, only: null_space
   use taut_model_mechanism, only: mechanism_t
   use taut_model_mechanism_body, only: body_planar, body_spatial, entry_of_velocity, pose_t, turned, turned_back, &
                                        velocities_of_kind
   use taut_model_mechanism_row, only: meant_direction
   use taut_spelling, only: nearest_name
   use taut_rotation, only: cross, exp_rotation, log_rotation
   implicit none (type, external)
   private
   public :: assemble, hold_coordinate, contradicting_velocities, worst_joint

   character(*), parameter :: here = 'assembly'

contains

   !> Marks the velocities of a coordinate: `rod`, `rod.x`, `rod.angle` (plane), `rod.orientation` (space).
   subroutine hold_coordinate(model, name, held, error)
      !> The mechanism.
      type(mechanism_t), intent(in) :: model
      !> The coordinate.
      character(*), intent(in) :: name
      !> Velocities that are kept: (n).
      logical, intent(inout) :: held(:)
      !> There is no such coordinate.
      type(error_t), allocatable, intent(inout) :: error
      character(:), allocatable :: meant
      integer :: b, dot, entry, k
      logical :: found

      dot = index(name, '.')
      found = .false.
      do b = 1, size(model%bodies)
         associate (body => model%bodies(b))
            if (body%name /= trim(name(:merge(dot - 1, len(name), dot > 0)))) cycle
            do k = 1, velocities_of_kind(body%kind)
               entry = entry_of_velocity(k, body%kind)
               if (dot > 0) then
                  select case (name(dot + 1:))
                  case ('x', 'y', 'z')
                     if (entry /= iachar(name(dot + 1:dot + 1)) - iachar('x') + 1) cycle
                  case ('angle')
                     if (body%kind /= body_planar .or. entry /= 6) cycle
                  case ('orientation')
                     if (body%kind /= body_spatial .or. entry < 4) cycle
                  case default
                     cycle
                  end select
               end if
               held(body%before_v + k) = .true.
               found = .true.
            end do
         end associate
      end do
      if (found) return
      do b = 1, size(model%bodies)
         meant = trim(nearest_name(name(:merge(dot - 1, len(name), dot > 0)), [model%bodies(b)%name]))
         if (len(meant) > 0) exit
      end do
      if (len(meant) > 0) meant = 'did you mean "'//meant//'"? Else '
      call raise(error, here, 'hold: there is no coordinate "'//trim(name)//'"', &
                 meant//'name a body, or body.x, .y, .z, .angle (in the plane) or .orientation (in space)')
   end subroutine hold_coordinate

   !> Brings positions and velocities to the constraints, moving only what is not held.
   !!
   !! What is drawn far from where its drives and axes want it may end on the branch that is not meant, or nowhere. Then it goes the
   !! whole way in small steps: the directions that are demanded start where the bodies are drawn and turn to where they belong.
   subroutine assemble(model, method, at, report, error, held)
      !> The mechanism.
      type(mechanism_t), intent(in) :: model
      !> Weight, tolerances, solver.
      type(method_t), intent(in) :: method
      !> The start, as `start_state` gives it; replaced.
      type(state_t), intent(inout) :: at
      !> How far it was moved.
      type(start_report_t), intent(out) :: report
      !> It cannot be assembled so.
      type(error_t), allocatable, intent(inout) :: error
      !> Velocities that keep what they were given, and with them coordinates: (n). Default: none.
      logical, intent(in), optional :: held(:)
      !> Longest turn of a direction at once [rad].
      real(wp), parameter :: stride = 0.3_wp
      type(error_t), allocatable :: failed
      type(mechanism_t) :: path
      type(state_t) :: drawn, reached
      real(wp) :: turns(3, size(model%rows_with_branches))
      integer :: k, steps

      drawn = at
      call bring(model, method, at, report, error, held)
      if (.not. allocated(error)) return
      call find_turns(model, drawn, turns)
      steps = ceiling(maxval([0.0_wp, norm2(turns, 1)])/stride)
      if (steps < 2) return
      reached = drawn
      path = model
      do k = 0, steps
         call turn_rows(model, turns, real(steps - k, wp)/steps, path)
         reached%v = drawn%v
         call bring(path, method, reached, report, failed, held)
         if (allocated(failed)) return
      end do
      at = reached
      deallocate (error)
   end subroutine assemble

   !> The turn, in the axes of body 1, that takes each direction that is demanded to where it is drawn, the shorter way.
   subroutine find_turns(model, at, turns)
      type(mechanism_t), intent(in) :: model
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: turns(:, :)
      real(wp), parameter :: small = 1.0e-6_wp
      type(pose_t) :: one, two
      real(wp) :: axis(3), g(3), u(3), v(3)
      integer :: k

      do k = 1, size(turns, 2)
         associate (row => model%rows(model%rows_with_branches(k)), &
                    joint => model%joints(model%joint_of_row(model%rows_with_branches(k))))
            call model%pose_of(at, joint%body_1, one)
            call model%pose_of(at, joint%body_2, two)
            g = 0.0_wp
            if (row%drive > 0) call model%functions(row%drive)%evaluate(at%t, g)
            u = meant_direction(row, g)
            v = turned_back(one%r, turned(two%r, row%b))
            axis = cross(u, v)
            if (fixes_frame(model, k)) then
               turns(:, k) = log_rotation(matmul(matmul(transpose(one%r), two%r), &
                                                 matmul(joint%frame_2, transpose(joint%frame_1))))
            else if (norm2(axis) > small) then
               turns(:, k) = atan2(norm2(axis), dot_product(u, v))*axis/norm2(axis)
            else if (dot_product(u, v) > 0.0_wp) then
               turns(:, k) = 0.0_wp
            else if (same_direction(model, k)) then
               ! Half a turn has no shorter way; rows of one axis go the same.
               turns(:, k) = turns(:, k - 1)
            else
               turns(:, k) = acos(-1.0_wp)*cross(u, row%a)
            end if
         end associate
      end do
   end subroutine find_turns

   !> Whether a row demands the same direction of the same joint as the one before.
   pure logical function same_direction(model, k)
      type(mechanism_t), intent(in) :: model
      integer, intent(in) :: k

      same_direction = .false.
      if (k == 1) return
      associate (i => model%rows_with_branches(k - 1), j => model%rows_with_branches(k))
         same_direction = model%joint_of_row(i) == model%joint_of_row(j) .and. model%rows(i)%kind == model%rows(j)%kind .and. &
                          norm2(model%rows(i)%side - model%rows(j)%side) <= 0.0_wp
      end associate
   end function same_direction

   !> Whether the joint of a row demands more than one direction of a body, and with it all.
   pure logical function fixes_frame(model, k)
      type(mechanism_t), intent(in) :: model
      integer, intent(in) :: k
      integer :: i

      associate (row => model%rows(model%rows_with_branches(k)), &
                 joint => model%joints(model%joint_of_row(model%rows_with_branches(k))))
         fixes_frame = .false.
         do i = joint%first, joint%last
            if (model%rows(i)%has_branches .and. model%rows(i)%kind == row%kind .and. &
                norm2(model%rows(i)%side - row%side) > 0.0_wp) fixes_frame = .true.
         end do
      end associate
   end function fixes_frame

   !> Turns the directions that rows demand by a part of the way back to where they are drawn.
   subroutine turn_rows(model, turns, part, path)
      type(mechanism_t), intent(in) :: model
      real(wp), intent(in) :: turns(:, :), part
      type(mechanism_t), intent(inout) :: path
      real(wp) :: r(3, 3)
      integer :: k

      do k = 1, size(turns, 2)
         associate (i => model%rows_with_branches(k))
            r = exp_rotation(part*turns(:, k))
            path%rows(i)%a = matmul(r, model%rows(i)%a)
            path%rows(i)%side = matmul(r, model%rows(i)%side)
         end associate
      end do
   end subroutine turn_rows

   !> One go: to the joints, as at any start.
   subroutine bring(model, method, at, report, error, held)
      type(mechanism_t), intent(in) :: model
      type(method_t), intent(in) :: method
      type(state_t), intent(inout) :: at
      type(start_report_t), intent(out) :: report
      type(error_t), allocatable, intent(inout) :: error
      logical, intent(in), optional :: held(:)

      call consistent_start(model, method, at, report, error, held)
      if (.not. allocated(error)) return
      error%what = 'the mechanism cannot be assembled ('//error%what//')'
      if (.not. present(held)) return
      if (any(held)) error%remedy = 'hold less (what is held keeps its velocity too), or start closer'
   end subroutine bring

   !> The joints, with their drives, whose velocity constraints contradict one another or what is held.
   subroutine contradicting_velocities(model, at, names, first, violation)
      !> The mechanism, and a state whose velocities were brought as close to the constraints as they come.
      type(mechanism_t), intent(in) :: model
      !> The state at which it is evaluated.
      type(state_t), intent(in) :: at
      !> Such as "a" (drive "g"), "b"; empty if there is no contradiction.
      character(:), allocatable, intent(out) :: names
      !> The first of them.
      integer, intent(out) :: first
      !> The largest violation [m/s] or [1/s].
      real(wp), intent(out) :: violation
      real(wp) :: a(model%c, model%n), b(model%c), limit
      logical :: contradicts(size(model%joints))
      integer :: i, joint

      names = ''
      first = 0
      violation = 0.0_wp
      if (model%c == 0) return
      call model%jacobian(at, a)
      call model%velocity_rhs(at, b)
      b = b - matmul(a, at%v)
      call share_among_dependent(a, b)
      violation = maxval(abs(b))
      limit = max(1.0e-8_wp, 1.0e-6_wp*violation)
      contradicts = .false.
      do i = 1, model%c
         if (abs(b(i)) > limit) contradicts(model%joint_of_row(i)) = .true.
      end do
      first = findloc(contradicts, .true., 1)
      do joint = 1, size(contradicts)
         if (.not. contradicts(joint)) cycle
         if (len(names) > 200) then
            names = names//', ...'
            return
         end if
         associate (it => model%joints(joint))
            if (len(names) > 0) names = names//', '
            names = names//'"'//it%name//'"'
            if (it%drive > 0) names = names//' (drive "'//model%functions(it%drive)%name//'")'
            if (it%angle_drive > 0) names = names//' (drive_angle "'//model%functions(it%angle_drive)%name//'")'
         end associate
      end do
   end subroutine contradicting_velocities

   !> What no velocities can mend is all that is left, shared by the rows that contradict each other: a solver may have left it
   !! all to one of them. What is held leaves more, as it is.
   subroutine share_among_dependent(a, b)
      real(wp), intent(in) :: a(:, :)
      real(wp), intent(inout) :: b(:)
      !> Rows up to which a dense matrix is taken apart.
      integer, parameter :: most = 500
      real(wp), allocatable :: inverse(:, :), shared(:), z(:, :)
      integer :: info, rank

      if (size(b) > most) return
      call null_space(transpose(a), z, inverse, rank, info)
      if (info /= 0) return
      shared = matmul(z, matmul(b, z))
      if (maxval(abs(shared)) > 1.0e-6_wp*maxval(abs(b))) b(:) = shared
   end subroutine share_among_dependent

   !> The joint that is violated most.
   subroutine worst_joint(model, at, joint, violation)
      !> The mechanism and its state.
      type(mechanism_t), intent(in) :: model
      !> The state at which it is evaluated.
      type(state_t), intent(in) :: at
      !> Its index; 0 if there are no joints.
      integer, intent(out) :: joint
      !> Its largest entry of phi [m] or [-].
      real(wp), intent(out) :: violation
      real(wp) :: phi(model%n_phi)
      integer :: i

      joint = 0
      violation = 0.0_wp
      if (model%n_phi == 0) return
      call model%constraint(at, phi)
      i = maxloc(abs(phi), 1)
      joint = model%joint_of_row(i)
      violation = abs(phi(i))
   end subroutine worst_joint

end module taut_model_mechanism_assembly
