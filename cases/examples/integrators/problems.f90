!> Three systems to try integrators on, and the table that they fill: steps, evaluations, Jacobians, time, violations, error.
module problems
   use taut
   implicit none (type, external)
   integer, parameter :: pendulum = 1, loop = 2, stiff = 3
   character(*), parameter :: names(3) = [character(8) :: 'pendulum', 'loop', 'stiff']
   real(wp), parameter :: t_end = 2.0_wp                             ! [s]

   !> A ball on a rod; a bar on three cranks of one length, of which one is redundant; two balls, the first on a rod, the second
   !! on a spring and damper below it whose own motion dies within a millisecond.
   type, extends(automatic_system_t) :: problem_t
      integer :: kind = pendulum
      real(wp) :: g = 9.81_wp, k = 1.0e6_wp, d = 2.0e3_wp            ! [m/s^2], [N/m], [N s/m]
   contains
      procedure :: potential, phi, force
   end type problem_t

   !> What an integrator is told besides, what an integration has cost, and what was seen of it.
   type :: log_t
      real(wp), allocatable :: mass(:)                               ! the diagonal of M
      integer :: steps = 0, jacobians = 0
      real(wp) :: phi = 0.0_wp, phidot = 0.0_wp, phiddot = 0.0_wp    ! largest violations at the ends of steps
      real(wp) :: looked = 0.0_wp                                    ! time that looking took [s]
   contains
      procedure :: see
   end type log_t

   interface
      !> LAPACK: solves A x = b, for implicit codes.
      subroutine dgesv(n, nrhs, a, lda, ipiv, b, ldb, info)
         import :: wp
         implicit none (type, external)
         integer, intent(in) :: n, nrhs, lda, ldb
         integer, intent(out) :: ipiv(*), info
         real(wp), intent(inout) :: a(lda, *), b(ldb, *)
      end subroutine dgesv
   end interface

   abstract interface
      !> Carries y from problem%y at problem%t to t_end; tells the log of each step's end, and of Jacobians.
      subroutine integrate(problem, y, log)
         import
         implicit none (type, external)
         type(constrained_problem_t), intent(inout), target :: problem
         real(wp), intent(inout), contiguous, target :: y(:)
         type(log_t), intent(inout) :: log
      end subroutine integrate
   end interface

contains

   subroutine new_problem(kind, system, at)
      integer, intent(in) :: kind
      type(problem_t), intent(out) :: system
      type(state_t), intent(out) :: at
      system%kind = kind
      select case (kind)
      case (pendulum)
         call system%define(n=2, c=1, mass_blocks=[1, 1])
         system%diagonal_mass = [1.0_wp, 1.0_wp]
         at%x = [1.0_wp, 0.0_wp]
      case (loop)
         call system%define(n=3, c=3, mass_blocks=[1, 1, 1])
         system%diagonal_mass = [2.0_wp, 2.0_wp, 0.7_wp]
         at%x = [0.8_wp, -0.6_wp, 0.0_wp]
      case default
         call system%define(n=4, c=1, mass_blocks=[1, 1, 1, 1])
         system%diagonal_mass = [1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp]
         at%x = [1.0_wp, 0.0_wp, 1.5_wp, 0.0_wp]
      end select
      at%v = 0.0_wp*at%x
   end subroutine new_problem

   subroutine potential(self, at, value)
      class(problem_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value
      value = self%g*self%diagonal_mass(2)*at%x(2)
      if (self%kind == stiff) value = value + self%g*at%x(4) + 0.5_wp*self%k*(distance(at%x(1:2), at%x(3:4)) - 0.5_wp)**2
   end subroutine potential

   subroutine force(self, at, value)
      class(problem_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      real(wp) :: along(2)
      call self%lagrange_force(at, value)
      if (self%kind /= stiff) return
      along = (at%x(3:4) - at%x(1:2))/norm2(at%x(3:4) - at%x(1:2))
      along = self%d*dot_product(along, at%v(3:4) - at%v(1:2))*along
      value = value + [along, -along]
   end subroutine force

   subroutine phi(self, at, value)
      class(problem_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value(:)
      integer :: i
      select case (self%kind)
      case (loop)                                                    ! cranks from (i, 0) to what is i off the bar's center
         do i = -1, 1
            value(i + 2) = hypot(at%x(1) + i*(cos(at%x(3)) - 1.0_wp), at%x(2) + i*sin(at%x(3))) - 1.0_wp
         end do
      case default
         value(1) = hypot(at%x(1), at%x(2)) - 1.0_wp
      end select
   end subroutine phi

   !> A step has ended.
   subroutine see(log, problem, t, y)
      class(log_t), intent(inout) :: log
      type(constrained_problem_t), intent(inout) :: problem
      real(wp), intent(in) :: t
      real(wp), intent(in), contiguous :: y(:)
      type(sample_t) :: seen
      real(wp) :: begun, ended
      integer :: info
      call cpu_time(begun)
      log%steps = log%steps + 1
      call problem%sample(t, y, seen, info)
      if (info /= rhs_ok) error stop 'a step has ended where nothing is defined'
      log%phi = max(log%phi, seen%phi)
      log%phidot = max(log%phidot, seen%phidot)
      log%phiddot = max(log%phiddot, seen%phiddot)
      call cpu_time(ended)
      log%looked = log%looked + ended - begun
   end subroutine see

   !> Integrates the problems that are asked for, and with taut's own integrator beside them, and prints a line for each.
   subroutine compare(name, by, kinds, own)
      character(*), intent(in) :: name                               ! of the integrator
      procedure(integrate) :: by
      integer, intent(in) :: kinds(:)
      character(*), intent(in) :: own(:)                             ! taut's integrator for each of them
      type(constrained_problem_t), target :: problem
      type(problem_t) :: system
      type(state_t) :: at, reference
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      type(log_t) :: log
      real(wp), allocatable, target :: y(:)
      real(wp) :: begun, ended
      integer :: i
      print '(a8, a20, 3a9, a10, 4a9)', 'problem', 'integrator', 'steps', 'rhs', 'jacobian', 'time [ms]', 'phi', 'phidot', &
         'phiddot', 'error'
      do i = 1, size(kinds)
         call new_problem(kinds(i), system, reference)
         at = reference
         call simulate(system, reference, t_end, result, error, options=integration_options_t('radau', 1.0e-11_wp, 1.0e-11_wp))
         call problem%init(system, at, error)
         if (allocated(error)) error stop 'the problem could not be begun'
         y = problem%y
         log = log_t(mass=system%diagonal_mass)
         call cpu_time(begun)
         call by(problem, y, log)
         call cpu_time(ended)
         call row(name, problem%evaluations, ended - begun - log%looked)
         call taut_row()
      end do

   contains

      subroutine row(integrator, evaluations, seconds)
         character(*), intent(in) :: integrator
         integer, intent(in) :: evaluations
         real(wp), intent(in) :: seconds
         print '(a8, a20, 3i9, f10.2, 4es9.1)', names(kinds(i)), integrator, log%steps, evaluations, log%jacobians, &
            1.0e3_wp*seconds, log%phi, log%phidot, log%phiddot, maxval(abs(y(:size(reference%x)) - reference%x))
      end subroutine row

      subroutine taut_row()
         type(trajectory_t) :: path
         type(integration_options_t) :: options
         integer :: k
         options = integration_options_t(own(i), 1.0e-6_wp, 1.0e-8_wp)
         call new_problem(kinds(i), system, at)
         call cpu_time(begun)
         call simulate(system, at, t_end, result, error, options=options, observer=path)
         call cpu_time(ended)
         log = log_t()
         do k = 2, path%points
            call log%see(problem, path%t(k), path%y(:, k))
         end do
         log%jacobians = result%jacobians
         call problem%pack(at, y)
         call row('taut '//own(i), result%rhs_evaluations, ended - begun)
      end subroutine taut_row

   end subroutine compare

end module problems
