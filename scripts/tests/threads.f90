!> Everything that is public and may run side by side, in as many threads as there are: what each says is what it says alone.
module work_of_threads
   use taut
   implicit none (type, external)
   private
   public :: variants, said_by, text_length

   integer, parameter :: variants = 8, text_length = 6000

   !> A pendulum whose b'' and whose A may be wrong by a factor.
   type, extends(tabulated_system_t) :: swing_t
      real(wp) :: of_a = 1.0_wp, of_b = 1.0_wp, length = 1.0_wp, lost_at = huge(1.0_wp)
   contains
      procedure :: mass, force, constraint, jacobian, acceleration_rhs, output_name, outputs
   end type swing_t

   !> From phi and V alone.
   type, extends(automatic_system_t) :: easy_t
   contains
      procedure :: phi, potential
   end type easy_t

contains

   subroutine mass(self, at, m)
      class(swing_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m
      call m%set_diagonal(spread(1.0_wp, 1, self%n) + 0.0_wp*at%t)
   end subroutine mass

   subroutine force(self, at, value)
      class(swing_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      value = [0.0_wp, -9.81_wp]
      if (at%t > self%lost_at) value(1) = sqrt(self%lost_at - at%t)
   end subroutine force

   subroutine constraint(self, at, value)
      class(swing_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      value(1) = norm2(at%x) - self%length
   end subroutine constraint

   subroutine jacobian(self, at, a)
      class(swing_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)
      a(1, :) = self%of_a*at%x/norm2(at%x)
   end subroutine jacobian

   subroutine acceleration_rhs(self, at, value)
      class(swing_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)
      real(wp) :: r
      r = norm2(at%x)
      value(1) = self%of_b*((dot_product(at%x, at%v)/r)**2 - dot_product(at%v, at%v))/r
   end subroutine acceleration_rhs

   function output_name(self, i) result(name)
      class(swing_t), intent(in) :: self
      integer, intent(in) :: i
      character(len=name_length) :: name
      name = repeat('tension', i*self%n/2)
   end function output_name

   subroutine outputs(self, at, lambda, values)
      class(swing_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: lambda(:)
      real(wp), intent(out) :: values(:)
      values = lambda(1) + 0.0_wp*at%t*self%n
   end subroutine outputs

   subroutine phi(self, at, value)
      class(easy_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value(:)
      value(1) = hypot(at%x(1), at%x(2)) - 1.0_wp + 0.0_wp*self%n
   end subroutine phi

   subroutine potential(self, at, value)
      class(easy_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value
      value = 9.81_wp*at%x(2)*self%diagonal_mass(2)
   end subroutine potential

   !> All that is said of one variant.
   subroutine said_by(k, text)
      integer, intent(in) :: k
      character(len=text_length), intent(out) :: text
      type(swing_t) :: system
      type(easy_t) :: easy
      type(state_t) :: at, inside
      type(finding_t), allocatable :: findings(:)
      type(error_t), allocatable :: error
      type(integration_result_t) :: result
      type(history_t) :: path
      type(constrained_problem_t) :: problem
      type(start_report_t) :: start
      type(method_t) :: method
      class(constrained_ode_t), allocatable :: ode
      real(wp), allocatable :: tension(:)
      character(:), allocatable :: why
      integer :: i, used

      used = 0
      text = ''
      call system%define(n=2, c=1, mass_blocks=[1, 1])
      system%n_outputs = 1
      ! What is wrong with derivatives.
      system%of_a = 1.0_wp + 0.1_wp*k
      system%of_b = 1.0_wp + 0.01_wp*k**3
      at = state_t(x=[0.6_wp, -0.8_wp], v=[0.8_wp*k, 0.6_wp*k])
      call verify(system, at, findings, error)
      call complain(error)
      do i = 1, size(findings)
         call say(findings(i)%message)
      end do
      call simulate(system, at, 1.0_wp, result, error)
      call complain(error)
      system%of_a = 1.0_wp
      system%of_b = 1.0_wp
      ! What is wrong with options and starts.
      call simulate(system, at, 1.0_wp, result, error, options=integration_options_t(rtol=-1.0_wp*10**k))
      call complain(error)
      call simulate(system, at, 1.0_wp, result, error, options=integration_options_t(integrator=repeat('x', k)))
      call complain(error)
      method = method_t(name=repeat('m', k))
      call check_method(method, error)
      call complain(error)
      at = state_t(x=[1.0_wp, 2.0_wp, real(k, wp)], v=[0.0_wp, 0.0_wp])
      call consistent_start(system, method_t(), at, start, error)
      call complain(error)
      ! What is seen of a motion, and how it ends.
      at = state_t(x=[1.0_wp, 0.0_wp], v=[0.0_wp, 0.0_wp])
      path%dense = .true.
      call simulate(system, at, 0.1_wp*k, result, error, observer=path)
      call complain(error)
      call say(status_name(result%status))
      call path%series('tension', tension, error)
      call complain(error)
      call numbers(tension)
      call path%series(repeat('y', k), tension, error)
      call complain(error)
      call path%state_at(0.05_wp*k, inside, error)
      call complain(error)
      call numbers([inside%x, inside%v])
      at = state_t(x=[1.0_wp, 0.0_wp], v=[0.0_wp, 0.0_wp])
      call simulate(system, at, 0.0_wp, result, error)
      if (size(result%notes) > 0) call say(result%notes(1)%text())
      system%lost_at = 0.01_wp*k
      call simulate(system, at, 1.0_wp, result, error)
      call complain(error)
      ! Without derivatives, implicitly, and with an integrator of one's own.
      call easy%define(n=2, c=1, mass_blocks=[1, 1])
      easy%diagonal_mass = [1.0_wp, 1.0_wp]
      at = state_t(x=[1.0_wp, 0.0_wp], v=[0.0_wp, 0.1_wp*k])
      call simulate(easy, at, 0.1_wp*k, result, error, options=integration_options_t(integrator='radau'), ode=ode)
      call complain(error)
      call numbers(at%x)
      call ode%failure(why)
      call say(why)
      call problem%init(easy, at, error)
      call complain(error)
      call problem%project(at%t, problem%y)
      call numbers(problem%y)

   contains

      subroutine say(line)
         character(*), intent(in) :: line
         text(used + 1:) = line//';'
         used = used + len(line) + 1
      end subroutine say

      subroutine complain(error)
         type(error_t), allocatable, intent(inout) :: error
         if (allocated(error)) call say(error%line())
         if (allocated(error)) deallocate (error)
      end subroutine complain

      subroutine numbers(values)
         real(wp), intent(in) :: values(:)
         character(len=26) :: number
         integer :: j
         do j = 1, size(values), max(1, size(values)/6)
            write (number, '(es26.17)') values(j)
            call say(number)
         end do
      end subroutine numbers

   end subroutine said_by

end module work_of_threads

program threads
   use work_of_threads
   implicit none (type, external)
   character(len=text_length) :: alone(variants), beside
   integer :: different, i, k

   do k = 1, variants
      call said_by(k, alone(k))
   end do
   different = 0
   !$omp parallel do private(k, beside) reduction(+:different) num_threads(4) schedule(dynamic, 1)
   do i = 1, 400
      k = 1 + mod(i, variants)
      call said_by(k, beside)
      if (beside /= alone(k)) different = different + 1
   end do
   print '(i0, a)', different, ' of 400 differ'
   print '(a)', trim(alone(1))
end program threads
