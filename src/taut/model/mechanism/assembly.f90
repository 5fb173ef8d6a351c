!> Assembling a mechanism while some of its coordinates keep the values they were given.
module taut_model_mechanism_assembly
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise
   use taut_constrained_system, only: state_t
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_null_space, only: null_space
   use taut_model_mechanism, only: mechanism_t
   use taut_model_mechanism_body, only: body_planar, body_spatial, entry_of_velocity, velocities_of_kind
   implicit none (type, external)
   private
   public :: assemble_holding, hold_coordinate, contradicting_velocities, worst_joint

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
      if (.not. found) call raise(error, here, 'hold: there is no coordinate "'//trim(name)//'"', &
                                  'name a body, or body.x, .y, .z, .angle (in the plane) or .orientation (in space)')
   end subroutine hold_coordinate

   !> Brings positions and velocities to the constraints, moving only what is not held, mass-weighted.
   subroutine assemble_holding(model, held, at, error)
      !> The mechanism.
      type(mechanism_t), intent(in) :: model
      !> Velocities that are kept: (n).
      logical, intent(in) :: held(:)
      !> The start; replaced.
      type(state_t), intent(inout) :: at
      !> It cannot be assembled so.
      type(error_t), allocatable, intent(inout) :: error
      integer, parameter :: most_iterations = 100
      type(block_diagonal_t) :: m
      real(wp), allocatable :: a(:, :), a_plus(:, :), b(:), d(:), full(:, :), phi(:), root(:), z(:, :)
      integer, allocatable :: free(:)
      integer :: i, info, iteration, rank

      if (model%c == 0) return
      free = pack([(i, i=1, model%n)], .not. held)
      call m%init(model%mass_blocks)
      call model%mass(at, m)
      full = m%dense()
      root = [(1.0_wp/sqrt(full(free(i), free(i))), i=1, size(free))]
      allocate (a(model%c, model%n), b(model%c), d(model%n), phi(model%n_phi), source=0.0_wp)
      do iteration = 1, most_iterations
         call model%constraint(at, phi)
         call model%jacobian(at, a)
         if (size(free) > 0) call null_space(a(:, free)*spread(root, 1, model%c), z, a_plus, rank, info)
         if (maxval(abs([0.0_wp, phi])) <= 1.0e-13_wp .or. size(free) == 0 .or. model%n_phi == 0) exit
         d(free) = -root*matmul(a_plus(:, :model%n_phi), phi)
         ! No more than half a radian, or half a metre, at once.
         d = d/max(1.0_wp, 2.0_wp*maxval(abs(d)))
         call model%displace(d, at%x)
         call model%normalize(at%x)
         if (maxval(abs(d)) <= 1.0e-15_wp*max(1.0_wp, maxval(abs(at%x)))) exit
      end do
      if (maxval(abs([0.0_wp, phi])) > 1.0e-9_wp) then
         call raise(error, here, 'it cannot be assembled with what is held', 'hold less, or start closer')
         return
      end if
      call model%velocity_rhs(at, b)
      if (size(free) > 0) at%v(free) = at%v(free) + root*matmul(a_plus, b - matmul(a, at%v))
      if (maxval(abs(b - matmul(a, at%v))) > 1.0e-8_wp*max(1.0_wp, maxval(abs(at%v)))) &
         call raise(error, here, 'the velocities that are held do not fit the joints', &
                    'hold less (what is held keeps its velocity too), or start with velocities that fit')
   end subroutine assemble_holding

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
