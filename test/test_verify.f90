!> Tests of the checker of user systems: correct systems pass, and each kind of mistake is found under its name.
module test_verify
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
   use testing, only: check, new_test, no_error, test_t
   use taut_kinds, only: wp
   use taut_error, only: error_t, to_text
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_constrained_verify, only: finding_t, verify
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_model_mechanism, only: mechanism_t
   use taut_model_mechanism_builder, only: mechanism_builder_t
   use taut_model_pendulum, only: new_pendulum, pendulum_t
   implicit none (type, external)
   private
   public :: collect_verify

   real(wp), parameter :: body_mass = 2.0_wp, offset = 0.3_wp, inertia = 1.0_wp, reach = 0.7_wp

   !> A plane body whose angle is stored as its cosine and sine; one of its points is driven along a line, and a knife
   !! edge keeps its center from moving sideways. `mistake` names what is wrong with it.
   type, extends(mechanical_system_t) :: sled_t
      character(len=16) :: mistake = ''
      !> What a wrong entry is multiplied with.
      real(wp) :: factor = -1.0_wp
   contains
      procedure :: mass => sled_mass
      procedure :: force => sled_force
      procedure :: constraint => sled_constraint
      procedure :: jacobian => sled_jacobian
      procedure :: velocity_rhs => sled_velocity_rhs
      procedure :: acceleration_rhs => sled_acceleration_rhs
      procedure :: w_rate => sled_w_rate
      procedure :: x_rate => sled_x_rate
      procedure :: v_of_x_rate => sled_v_of_x_rate
      procedure :: displace => sled_displace
      procedure :: entry
   end type sled_t

   !> A body on a unit quaternion, one of its axes kept normal to an axis in space; velocities are those about its own axes.
   type, extends(mechanical_system_t) :: gimbal_t
      real(wp) :: in_body(3) = [1.0_wp, 0.2_wp, -0.4_wp], in_space(3) = [0.3_wp, -1.0_wp, 0.5_wp]
   contains
      procedure :: mass => gimbal_mass
      procedure :: force => gimbal_force
      procedure :: constraint => gimbal_constraint
      procedure :: jacobian => gimbal_jacobian
      procedure :: acceleration_rhs => gimbal_acceleration_rhs
      procedure :: x_rate => gimbal_x_rate
      procedure :: v_of_x_rate => gimbal_v_of_x_rate
      procedure :: displace => gimbal_displace
   end type gimbal_t

   !> A pendulum as a mechanism, with a wrong entry of A.
   type, extends(mechanism_t) :: misled_t
   contains
      procedure :: jacobian => misled_jacobian
   end type misled_t

contains

   !> All tests of this module.
   function collect_verify() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [ &
              new_test('a pendulum is correct', pendulum_passes), &
              new_test('a mechanism tells rows and columns by their names', names_told), &
              new_test('a driven sled with cosine and sine is correct', sled_passes), &
              new_test('a body on a quaternion is correct', gimbal_passes), &
              new_test('each mistake is found', mistakes), &
              new_test('what is not set is found', unset_entries), &
              new_test('the tolerance decides', tolerances), &
              new_test('sizes that do not fit', sizes)]
   end function collect_verify

   !> Fails if there is a finding.
   subroutine check_none(failure, model, at, label)
      character(:), allocatable, intent(inout) :: failure
      class(mechanical_system_t), intent(in) :: model
      type(state_t), intent(in) :: at
      character(*), intent(in) :: label
      type(finding_t), allocatable :: findings(:)
      type(error_t), allocatable :: error

      call verify(model, at, findings, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      if (size(findings) > 0) call check(failure, .false., label//': '//to_text(size(findings))//' findings, first '// &
                                         findings(1)%message)
   end subroutine check_none

   subroutine misled_jacobian(self, at, a)
      class(misled_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)

      call self%mechanism_t%jacobian(at, a)
      a(1, 3) = a(1, 3) + 0.5_wp
   end subroutine misled_jacobian

   subroutine names_told(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(misled_t) :: pendulum
      type(state_t) :: at
      type(finding_t), allocatable :: findings(:)
      type(error_t), allocatable :: error

      builder%planar = .true.
      call builder%add_body('rod', mass=1.0_wp, shape='rod', from=[0.0_wp, 0.0_wp, 0.0_wp], to=[1.0_wp, 0.0_wp, 0.0_wp])
      call builder%add_joint('hinge', 'revolute', 'ground', 'rod', point=[0.0_wp, 0.0_wp, 0.0_wp])
      call builder%complete(pendulum%mechanism_t, at, error)
      if (.not. allocated(error)) call verify(pendulum, at, findings, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      call check(failure, size(findings) > 0, 'it is found')
      if (allocated(failure)) return
      call check(failure, index(findings(1)%message, 'A(1, 3)') == 1 .and. &
                 index(findings(1)%message, '; row 1 is hinge (shift along x); column 3 is rod.wz') > 0, findings(1)%message)
   end subroutine names_told

   subroutine pendulum_passes(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp), parameter :: lengths(4) = [1.0_wp, 1.0e-3_wp, 0.05_wp, 1.0e3_wp], speeds(4) = [1.0_wp, 0.0_wp, 1.0e-3_wp, 300.0_wp]
      integer :: copies, i, j

      do copies = 1, 3, 2
         do i = 1, size(lengths)
            do j = 1, size(speeds)
               call new_pendulum(model, 2.0_wp, lengths(i), 9.81_wp, copies, error)
               call no_error(failure, error)
               ! Off the constraint and not along it: the derivatives hold everywhere.
               at%x = lengths(i)*[0.9_wp, -0.7_wp]
               at%v = speeds(j)*[0.3_wp, 1.1_wp]
               call check_none(failure, model, at, 'length '//to_text(lengths(i))//' m at '//to_text(speeds(j))//' m/s')
            end do
         end do
      end do
   end subroutine pendulum_passes

   !> A state of the sled that meets none of its constraints.
   function sled_state() result(at)
      type(state_t) :: at

      at%t = 0.4_wp
      at%x = [0.5_wp, -0.2_wp, cos(0.6_wp), sin(0.6_wp)]
      at%v = [0.8_wp, 1.5_wp, -2.0_wp]
      at%w = [1.0_wp]
   end function sled_state

   function new_sled(mistake) result(model)
      character(*), intent(in) :: mistake
      type(sled_t) :: model

      model%mistake = mistake
      call model%define(n=3, c=3, nonholonomic=1, n_x=4, n_w=1, constant_mass=.false.)
   end function new_sled

   subroutine sled_passes(failure)
      character(:), allocatable, intent(inout) :: failure
      type(state_t) :: at

      call check_none(failure, new_sled(''), sled_state(), 'moving')
      at = sled_state()
      at%v(:) = 0.0_wp
      call check_none(failure, new_sled(''), at, 'at rest')
      at = sled_state()
      at%t = 100.0_wp
      call check_none(failure, new_sled(''), at, 'late')
   end subroutine sled_passes

   subroutine gimbal_passes(failure)
      character(:), allocatable, intent(inout) :: failure
      type(gimbal_t) :: model
      type(state_t) :: at

      call model%define(n=3, c=1, n_x=4, mass_blocks=[1, 1, 1])
      at%x = [0.5_wp, -0.5_wp, 0.1_wp, 0.7_wp]
      at%x = at%x/norm2(at%x)
      at%v = [1.0_wp, -2.0_wp, 0.5_wp]
      call check_none(failure, model, at, 'quaternion')
   end subroutine gimbal_passes

   !> Each mistake gives the finding expected, and no other than those that follow from it.
   subroutine mistakes(failure)
      character(:), allocatable, intent(inout) :: failure

      call expect(failure, 'A(2,3)', 'A', 2, 3, followers='b''''')
      call expect(failure, 'A(1,1)', 'A', 1, 1, followers='b''''')
      call expect(failure, 'b''(1)', 'b''', 1, 0, followers='b''''')
      call expect(failure, 'b''''(1)', 'b''''', 1, 0)
      call expect(failure, 'b''''(2)', 'b''''', 2, 0)
      call expect(failure, 'b''''(3)', 'b''''', 3, 0)
      call expect(failure, 'M(3,1)', 'M', 3, 1)
      call expect(failure, 'M(3,3)', 'M', 3, 3)
      call expect(failure, 'H(3)', 'H', 3, 0, followers='H^+')
      call expect(failure, 'H^+(3)', 'H^+', 3, 0)
      ! A displacement the wrong way round makes everything else look wrong in that direction, but its own row is named.
      call expect(failure, 'displace', 'H', 4, 0, followers='H,A,b''''')
   end subroutine mistakes

   subroutine unset_entries(failure)
      character(:), allocatable, intent(inout) :: failure

      call expect(failure, 'unset A(1,2)', 'A', 1, 2, followers='b''''')
      call expect(failure, 'unset A(3,3)', 'A', 3, 3, followers='b''''')
      call expect(failure, 'unset b''(3)', 'b''', 3, 0, followers='b''''')
      call expect(failure, 'unset b''''(2)', 'b''''', 2, 0)
      call expect(failure, 'unset M(3,2)', 'M', 3, 2, followers='M')
      call expect(failure, 'unset f(2)', 'f', 2, 0)
      call expect(failure, 'unset g(1)', 'g', 1, 0)
      call expect(failure, 'unset phi(2)', 'phi', 2, 0)
      call expect(failure, 'unset H(4)', 'H', 4, 0)
      call expect(failure, 'unset H^+(1)', 'H^+', 1, 0)
   end subroutine unset_entries

   subroutine expect(failure, mistake, what, row, column, followers)
      character(:), allocatable, intent(inout) :: failure
      character(*), intent(in) :: mistake, what
      integer, intent(in) :: row, column
      character(*), intent(in), optional :: followers
      type(finding_t), allocatable :: findings(:)
      type(error_t), allocatable :: error
      character(:), allocatable :: list, allowed
      integer :: found, i

      call verify(new_sled(mistake), sled_state(), findings, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      allowed = ','//what//','
      if (present(followers)) allowed = allowed//followers//','
      list = ''
      found = 0
      do i = 1, size(findings)
         list = list//'; '//findings(i)%message
         if (findings(i)%what == what .and. findings(i)%row == row .and. findings(i)%column == column) found = i
         call check(failure, index(allowed, ','//trim(findings(i)%what)//',') > 0, mistake//' gives '//findings(i)%message)
      end do
      call check(failure, found > 0, mistake//' is not found: '//to_text(size(findings))//' findings'//list)
      if (found == 0) return
      call check(failure, index(findings(found)%message, what) == 1, 'the message does not begin with the name: '// &
                 findings(found)%message)
      call check(failure, index(findings(found)%message, to_text(row)) > 0, 'the message has no row: '//findings(found)%message)
      if (.not. present(followers)) call check(failure, size(findings) == 1, mistake//' gives more than one finding'//list)
   end subroutine expect

   subroutine tolerances(failure)
      character(:), allocatable, intent(inout) :: failure
      type(sled_t) :: model
      type(finding_t), allocatable :: findings(:)
      type(error_t), allocatable :: error

      model = new_sled('A(2,3)')
      model%factor = 1.0_wp + 1.0e-4_wp
      call verify(model, sled_state(), findings, error)
      call no_error(failure, error)
      call check(failure, any(findings%what == 'A'), 'an error of 1e-4 is not found')
      call verify(model, sled_state(), findings, error, tolerance=1.0e-3_wp)
      call check(failure, size(findings) == 0, 'an error of 1e-4 is found with a tolerance of 1e-3')
      if (size(findings) > 0 .or. allocated(failure)) return
      model%factor = -1.0_wp
      call verify(model, sled_state(), findings, error)
      if (size(findings) == 0) return
      call check(failure, abs(findings(1)%given + findings(1)%expected) < 1.0e-6_wp, 'given and expected differ by their sign')
   end subroutine tolerances

   subroutine sizes(failure)
      character(:), allocatable, intent(inout) :: failure
      type(sled_t) :: model
      type(state_t) :: at

      call refuse('velocities', 'a system without sizes')
      model = new_sled('')
      at = sled_state()
      at%x = [1.0_wp, 2.0_wp]
      call refuse('4 coordinates', 'too few coordinates')
      at = sled_state()
      at%v = [1.0_wp]
      call refuse('3 velocities', 'too few velocities')
      at = sled_state()
      at%w = [1.0_wp, 2.0_wp]
      call refuse('1 other', 'too many other states')
      at = sled_state()
      deallocate (at%w)
      call refuse('1 other', 'no other states')
      at = sled_state()
      deallocate (at%v)
      call refuse('not set', 'no velocities')
      at = sled_state()
      model%mass_blocks = [1, 1]
      call refuse('blocks', 'blocks that do not add up')
      call model%define(n=3, c=2, nonholonomic=3, n_x=4, n_w=1)
      call refuse('holonomic', 'more nonholonomic constraints than constraints')

   contains

      subroutine refuse(part, label)
         character(*), intent(in) :: part, label
         type(finding_t), allocatable :: findings(:)
         type(error_t), allocatable :: error

         call verify(model, at, findings, error)
         call check(failure, allocated(error), label//' gives no error')
         if (.not. allocated(error)) return
         call check(failure, index(error%line(), part) > 0 .and. len(error%remedy) > 0, label//': '//error%line())
      end subroutine refuse

   end subroutine sizes

   !> What an entry becomes: itself, wrong, or never set.
   function entry(self, name, value) result(given)
      class(sled_t), intent(in) :: self
      character(*), intent(in) :: name
      real(wp), intent(in) :: value
      real(wp) :: given

      given = value
      if (self%mistake == name) given = self%factor*value
      if (self%mistake == 'unset '//name) given = ieee_value(given, ieee_quiet_nan)
   end function entry

   subroutine sled_mass(self, at, m)
      class(sled_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m
      real(wp) :: coupling(2), k(3, 3)

      coupling(:) = body_mass*offset*[-at%x(4), at%x(3)]
      k(:, 1) = [body_mass, 0.0_wp, self%entry('M(3,1)', coupling(1))]
      k(:, 2) = [0.0_wp, body_mass, self%entry('M(3,2)', coupling(2))]
      k(:, 3) = [coupling, self%entry('M(3,3)', inertia)]
      call m%set_dense(k)
   end subroutine sled_mass

   subroutine sled_force(self, at, value)
      class(sled_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(:) = [0.0_wp, self%entry('f(2)', -9.81_wp*body_mass), -0.1_wp*at%v(3)]
   end subroutine sled_force

   !> The driven point follows 0.3 sin(2 t) along x and stays on z = 0.
   subroutine sled_constraint(self, at, value)
      class(sled_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(1) = at%x(1) + reach*at%x(3) - 0.3_wp*sin(2.0_wp*at%t)
      value(2) = self%entry('phi(2)', at%x(2) + reach*at%x(4))
   end subroutine sled_constraint

   subroutine sled_jacobian(self, at, a)
      class(sled_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)

      a(1, :) = [self%entry('A(1,1)', 1.0_wp), self%entry('A(1,2)', 0.0_wp), -reach*at%x(4)]
      a(2, :) = [0.0_wp, 1.0_wp, self%entry('A(2,3)', reach*at%x(3))]
      a(3, :) = [-at%x(4), at%x(3), self%entry('A(3,3)', 0.0_wp)]
   end subroutine sled_jacobian

   subroutine sled_velocity_rhs(self, at, value)
      class(sled_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(:) = [self%entry('b''(1)', 0.6_wp*cos(2.0_wp*at%t)), 0.0_wp, self%entry('b''(3)', 0.0_wp)]
   end subroutine sled_velocity_rhs

   subroutine sled_acceleration_rhs(self, at, value)
      class(sled_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      associate (c => at%x(3), s => at%x(4), v => at%v)
         value(1) = self%entry('b''''(1)', -1.2_wp*sin(2.0_wp*at%t) + reach*c*v(3)**2)
         value(2) = self%entry('b''''(2)', reach*s*v(3)**2)
         value(3) = self%entry('b''''(3)', v(3)*(c*v(1) + s*v(2)))
      end associate
   end subroutine sled_acceleration_rhs

   subroutine sled_w_rate(self, at, value)
      class(sled_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(:) = self%entry('g(1)', -at%w(1))
   end subroutine sled_w_rate

   subroutine sled_x_rate(self, at, u, value)
      class(sled_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: u(:)
      real(wp), intent(out) :: value(:)

      value(:) = [u(1), u(2), self%entry('H(3)', -at%x(4)*u(3)), self%entry('H(4)', at%x(3)*u(3))]
   end subroutine sled_x_rate

   subroutine sled_v_of_x_rate(self, at, rate, u)
      class(sled_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: rate(:)
      real(wp), intent(out) :: u(:)

      u(:) = [self%entry('H^+(1)', rate(1)), rate(2), self%entry('H^+(3)', at%x(3)*rate(4) - at%x(4)*rate(3))]
   end subroutine sled_v_of_x_rate

   subroutine sled_displace(self, d, x)
      class(sled_t), intent(in) :: self
      real(wp), intent(in) :: d(:)
      real(wp), intent(inout) :: x(:)
      real(wp) :: turn

      turn = self%entry('displace', d(3))
      x(1:2) = x(1:2) + d(1:2)
      x(3:4) = [cos(turn)*x(3) - sin(turn)*x(4), sin(turn)*x(3) + cos(turn)*x(4)]
   end subroutine sled_displace

   subroutine gimbal_mass(self, at, m)
      class(gimbal_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(block_diagonal_t), intent(inout) :: m

      call m%set_diagonal([1.0_wp, 2.0_wp, 3.0_wp])
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine gimbal_mass

   subroutine gimbal_force(self, at, value)
      class(gimbal_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(:) = -cross(at%v, [1.0_wp, 2.0_wp, 3.0_wp]*at%v)
      associate (unused_system => self)
      end associate
   end subroutine gimbal_force

   subroutine gimbal_constraint(self, at, value)
      class(gimbal_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(1) = dot_product(self%in_space, turned(at%x, self%in_body))
   end subroutine gimbal_constraint

   subroutine gimbal_jacobian(self, at, a)
      class(gimbal_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: a(:, :)

      a(1, :) = cross(self%in_body, turned(at%x*[1.0_wp, -1.0_wp, -1.0_wp, -1.0_wp], self%in_space))
   end subroutine gimbal_jacobian

   subroutine gimbal_acceleration_rhs(self, at, value)
      class(gimbal_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(out) :: value(:)

      value(1) = -dot_product(self%in_space, turned(at%x, cross(at%v, cross(at%v, self%in_body))))
   end subroutine gimbal_acceleration_rhs

   subroutine gimbal_x_rate(self, at, u, value)
      class(gimbal_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: u(:)
      real(wp), intent(out) :: value(:)

      value(:) = 0.5_wp*product_of(at%x, [0.0_wp, u])
      associate (unused_system => self)
      end associate
   end subroutine gimbal_x_rate

   subroutine gimbal_v_of_x_rate(self, at, rate, u)
      class(gimbal_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: rate(:)
      real(wp), intent(out) :: u(:)
      real(wp) :: p(4)

      p(:) = product_of(at%x*[1.0_wp, -1.0_wp, -1.0_wp, -1.0_wp], rate)
      u(:) = 2.0_wp*p(2:4)
      associate (unused_system => self)
      end associate
   end subroutine gimbal_v_of_x_rate

   subroutine gimbal_displace(self, d, x)
      class(gimbal_t), intent(in) :: self
      real(wp), intent(in) :: d(:)
      real(wp), intent(inout) :: x(:)
      real(wp) :: half

      half = 0.5_wp*norm2(d)
      if (half > 0.0_wp) x(:) = product_of(x, [cos(half), sin(half)*d/(2.0_wp*half)])
      associate (unused_system => self)
      end associate
   end subroutine gimbal_displace

   pure function cross(a, b) result(c)
      real(wp), intent(in) :: a(3), b(3)
      real(wp) :: c(3)

      c(:) = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
   end function cross

   !> Hamilton's product, the scalar first.
   pure function product_of(p, q) result(r)
      real(wp), intent(in) :: p(4), q(4)
      real(wp) :: r(4)

      r(1) = p(1)*q(1) - dot_product(p(2:4), q(2:4))
      r(2:4) = p(1)*q(2:4) + q(1)*p(2:4) + cross(p(2:4), q(2:4))
   end function product_of

   !> A vector turned by a unit quaternion.
   pure function turned(p, a) result(b)
      real(wp), intent(in) :: p(4), a(3)
      real(wp) :: b(3)

      b(:) = a + 2.0_wp*p(1)*cross(p(2:4), a) + 2.0_wp*cross(p(2:4), cross(p(2:4), a))
   end function turned

end module test_verify
