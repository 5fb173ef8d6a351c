!> Jets: every operator and function against closed forms of its derivatives, and against what it is made of.
module test_jet
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use taut_kinds, only: wp
   use taut_jet
   use taut_rotation, only: matrix_of_quaternion
   use testing, only: check, check_below, new_test, test_t
   implicit none (type, external)
   private
   public :: collect_jet

contains

   !> All tests of this module.
   function collect_jet() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('functions have their closed forms', closed_forms), &
               new_test('functions of functions, and inverses', inverses), &
               new_test('operators mix with reals and integers', operators), &
               new_test('powers', powers), &
               new_test('branches', branches), &
               new_test('comparisons are those of values', comparisons), &
               new_test('lengths', lengths), &
               new_test('vectors and matrices', vectors), &
               new_test('rotations', rotations), &
               new_test('along a path, differences', differences), &
               new_test('where there is no derivative', no_derivative)]
   end function collect_jet

   !> A jet with a derivative in every direction.
   elemental function sample(v, k) result(z)
      real(wp), intent(in) :: v
      integer, intent(in) :: k
      type(jet_t) :: z

      z = jet_t(v, 0.3_wp + 0.1_wp*k, [0.7_wp - 0.2_wp*k, -1.1_wp + 0.3_wp*k, 0.4_wp*k, 2.0_wp - k])
   end function sample

   !> Largest difference of two jets.
   elemental function gap(a, b) result(g)
      type(jet_t), intent(in) :: a, b
      real(wp) :: g

      g = max(abs(a%v - b%v), abs(a%dd - b%dd), maxval(abs(a%d - b%d)))
   end function gap

   subroutine same(failure, a, b, name)
      character(:), allocatable, intent(inout) :: failure
      type(jet_t), intent(in) :: a, b
      character(*), intent(in) :: name

      call check_below(failure, gap(a, b), 1.0e-13_wp*(1.0_wp + abs(b%v) + abs(b%dd) + abs(b%d(1))), name)
   end subroutine same

   subroutine closed_forms(failure)
      character(:), allocatable, intent(inout) :: failure
      type(jet_t) :: z
      real(wp), parameter :: v = 0.6_wp

      z = sample(v, 1)
      call closed('sin', sin(z), sin(v), cos(v), -sin(v))
      call closed('cos', cos(z), cos(v), -sin(v), -cos(v))
      call closed('tan', tan(z), tan(v), 1.0_wp/cos(v)**2, 2.0_wp*sin(v)/cos(v)**3)
      call closed('asin', asin(z), asin(v), 1.25_wp, 0.6_wp*1.25_wp**3)
      call closed('acos', acos(z), acos(v), -1.25_wp, -0.6_wp*1.25_wp**3)
      call closed('atan', atan(z), atan(v), 1.0_wp/1.36_wp, -1.2_wp/1.36_wp**2)
      call closed('exp', exp(z), exp(v), exp(v), exp(v))
      call closed('log', log(z), log(v), 1.0_wp/v, -1.0_wp/v**2)
      call closed('sqrt', sqrt(z), sqrt(v), 0.5_wp/sqrt(v), -0.25_wp/sqrt(v)**3)
      call closed('sinh', sinh(z), sinh(v), cosh(v), sinh(v))
      call closed('cosh', cosh(z), cosh(v), sinh(v), cosh(v))
      call closed('tanh', tanh(z), tanh(v), 1.0_wp/cosh(v)**2, -2.0_wp*tanh(v)/cosh(v)**2)
      call closed('abs', abs(-z), v, 1.0_wp, 0.0_wp)

   contains

      subroutine closed(name, f, value, first, second)
         character(*), intent(in) :: name
         type(jet_t), intent(in) :: f
         real(wp), intent(in) :: value, first, second

         call same(failure, f, jet_t(value, first*z%dd + second*z%d(1)**2, first*z%d), name)
      end subroutine closed

   end subroutine closed_forms

   subroutine inverses(failure)
      character(:), allocatable, intent(inout) :: failure
      type(jet_t) :: x, y

      x = sample(0.6_wp, 1)
      y = sample(-0.8_wp, 2)
      call same(failure, asin(sin(x)), x, 'asin')
      call same(failure, acos(cos(x)), x, 'acos')
      call same(failure, atan(tan(x)), x, 'atan')
      call same(failure, atan2(sin(y), cos(y)), y, 'atan2')
      call same(failure, atan(sin(y), cos(y)), y, 'atan of two')
      call same(failure, atan2(y, 2.0_wp), atan(y/2.0_wp), 'atan2 with a real')
      call same(failure, atan2(2.0_wp, x), acos(0.0_wp) - atan(x/2.0_wp), 'atan2 of a real')
      call same(failure, atan(2.0_wp, x), atan2(2.0_wp, x), 'atan of a real and a jet')
      call same(failure, atan(y, 2.0_wp), atan2(y, 2.0_wp), 'atan of a jet and a real')
      call same(failure, log(exp(y)), y, 'log')
      call same(failure, sqrt(x)*sqrt(x), x, 'sqrt')
      call same(failure, sinh(y)/cosh(y), tanh(y), 'tanh')
      call same(failure, sin(x + y), sin(x)*cos(y) + cos(x)*sin(y), 'sum of angles')
      call same(failure, hypot(x, y), sqrt(x*x + y*y), 'hypot')
      call same(failure, hypot(x, 0.8_wp), sqrt(x*x + 0.64_wp), 'hypot with a real')
      call same(failure, hypot(0.8_wp, x), hypot(x, 0.8_wp), 'hypot of a real')
   end subroutine inverses

   subroutine operators(failure)
      character(:), allocatable, intent(inout) :: failure
      type(jet_t) :: a, b, c

      a = sample(1.7_wp, 1)
      b = sample(-0.4_wp, 2)
      call same(failure, +a, a, '+')
      call same(failure, -(-a), a, '-')
      call same(failure, a + b - b, a, 'sum')
      call same(failure, a*b/b, a, 'quotient')
      call same(failure, a*b, jet_t(a%v*b%v, a%v*b%dd + 2.0_wp*a%d(1)*b%d(1) + a%dd*b%v, a%d*b%v + a%v*b%d), 'product')
      c = 2.5_wp
      call same(failure, c, jet(2.5_wp), 'a real')
      call same(failure, a + c, a + 2.5_wp, 'jet + real')
      call same(failure, c + a, 2.5_wp + a, 'real + jet')
      call same(failure, a - c, a - 2.5_wp, 'jet - real')
      call same(failure, c - a, 2.5_wp - a, 'real - jet')
      call same(failure, a*c, a*2.5_wp, 'jet real')
      call same(failure, c*a, 2.5_wp*a, 'real jet')
      call same(failure, a/c, a/2.5_wp, 'jet/real')
      call same(failure, c/a, 2.5_wp/a, 'real/jet')
      c = 3
      call same(failure, c, jet(3.0_wp), 'an integer')
      call same(failure, a + c, a + 3, 'jet + integer')
      call same(failure, c + a, 3 + a, 'integer + jet')
      call same(failure, a - c, a - 3, 'jet - integer')
      call same(failure, c - a, 3 - a, 'integer - jet')
      call same(failure, a*c, a*3, 'jet integer')
      call same(failure, c*a, 3*a, 'integer jet')
      call same(failure, a/c, a/3, 'jet/integer')
      call same(failure, c/a, 3/a, 'integer/jet')
      call same(failure, jet(1.0_wp, 2.0_wp, 3.0_wp), jet_t(1.0_wp, 3.0_wp, [2.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]), 'on a path')
   end subroutine operators

   subroutine powers(failure)
      character(:), allocatable, intent(inout) :: failure
      type(jet_t) :: a, b, zero

      a = sample(1.3_wp, 1)
      b = sample(-0.4_wp, 2)
      zero = sample(0.0_wp, 1)
      call same(failure, b**0, jet(1.0_wp), '0')
      call same(failure, b**1, b, '1')
      call same(failure, b**2, b*b, '2')
      call same(failure, b**5, b*b*b*b*b, '5')
      call same(failure, b**(-2), 1.0_wp/(b*b), '-2')
      call same(failure, zero**2, zero*zero, 'the square of zero')
      call same(failure, zero**3, jet(0.0_wp), 'the cube of zero')
      call same(failure, b**3.0_wp, b**3, 'a whole number')
      call same(failure, a**2.5_wp, sqrt(a)**5, 'a real number')
      call same(failure, zero**2.5_wp, jet(0.0_wp), 'of zero')
      call same(failure, a**b, exp(b*log(a)), 'a jet')
      call same(failure, 2.0_wp**b, exp(b*log(2.0_wp)), 'of a real')
   end subroutine powers

   subroutine branches(failure)
      character(:), allocatable, intent(inout) :: failure
      type(jet_t) :: a, b

      a = sample(1.3_wp, 1)
      b = sample(-0.4_wp, 2)
      call same(failure, max(a, b), a, 'max')
      call same(failure, min(a, b), b, 'min')
      call same(failure, max(b, 0.0_wp), jet(0.0_wp), 'max with a real')
      call same(failure, max(0.0_wp, a), a, 'max of a real')
      call same(failure, min(a, 2.0_wp), a, 'min with a real')
      call same(failure, min(-1.0_wp, b), jet(-1.0_wp), 'min of a real')
      call same(failure, sign(a, b), -a, 'sign')
      call same(failure, sign(b, -1.0_wp), b, 'sign of a real')
      call same(failure, sign(2.0_wp, b), jet(-2.0_wp), 'a real with a sign')
      call same(failure, abs(b), -b, 'abs')
   end subroutine branches

   subroutine comparisons(failure)
      character(:), allocatable, intent(inout) :: failure
      type(jet_t) :: a, b

      a = sample(2.0_wp, 1)
      b = sample(3.0_wp, 2)
      call check(failure, a < b .and. .not. b < a .and. a < 2.5_wp .and. 1.5_wp < a .and. a < 3 .and. 1 < a, '<')
      call check(failure, a <= b .and. a <= a .and. a <= 2.0_wp .and. 2.0_wp <= a .and. a <= 2 .and. 2 <= a, '<=')
      call check(failure, b > a .and. .not. a > b .and. b > 2.5_wp .and. 3.5_wp > b .and. b > 2 .and. 4 > b, '>')
      call check(failure, b >= a .and. b >= b .and. b >= 3.0_wp .and. 3.0_wp >= b .and. b >= 3 .and. 3 >= b, '>=')
      call check(failure, a == sample(2.0_wp, 3) .and. a == 2.0_wp .and. 2.0_wp == a .and. a == 2 .and. 2 == a, '==')
      call check(failure, a /= b .and. .not. a /= a .and. a /= 3.0_wp .and. 3.0_wp /= a .and. a /= 3 .and. 3 /= a, '/=')
   end subroutine comparisons

   subroutine lengths(failure)
      character(:), allocatable, intent(inout) :: failure
      type(jet_t) :: a(3), b(3), columns(3, 3)
      real(wp), parameter :: c(3) = [0.3_wp, -0.2_wp, 0.9_wp]
      integer :: i, n

      a = sample([0.5_wp, -1.2_wp, 2.0_wp], [1, 2, 3])
      b = sample([1.5_wp, 0.2_wp, -0.7_wp], [3, 4, 5])
      call same(failure, norm2(a), sqrt(a(1)**2 + a(2)**2 + a(3)**2), 'norm2')
      call same(failure, distance(a, b), norm2(a - b), 'distance')
      call same(failure, distance(a, c), norm2(a - c), 'to a fixed point')
      call same(failure, distance(c, a), norm2(a - c), 'from a fixed point')
      call same(failure, distance(a(:2), b(:2)), hypot(a(1) - b(1), a(2) - b(2)), 'in the plane')
      call same(failure, distance(a(::2), b(::2)), hypot(a(1) - b(1), a(3) - b(3)), 'of every second')
      columns = reshape([a, b, a], [3, 3])
      do n = 2, 3
         associate (apart => distance(columns(:n, 2:), columns(:n, :2)))
            call check(failure, size(apart) == 2, 'a distance for each pair')
            do i = 1, 2
               call same(failure, apart(i), norm2(a(:n) - b(:n)), 'of columns')
            end do
         end associate
      end do
   end subroutine lengths

   subroutine vectors(failure)
      character(:), allocatable, intent(inout) :: failure
      type(jet_t) :: a(3), b(3), m(3, 3), s
      real(wp), parameter :: c(3) = [0.3_wp, -0.2_wp, 0.9_wp], &
                             k(3, 3) = reshape([1.0_wp, 2.0_wp, 3.0_wp, -4.0_wp, 5.0_wp, 0.5_wp, 7.0_wp, -8.0_wp, 9.0_wp], [3, 3])
      integer :: i

      a = sample([0.5_wp, -1.2_wp, 2.0_wp], [1, 2, 3])
      b = sample([1.5_wp, 0.2_wp, -0.7_wp], [3, 4, 5])
      do i = 1, 3
         m(:, i) = a*b(i) + k(:, i)
      end do
      call same(failure, sum(a), a(1) + a(2) + a(3), 'sum')
      call same(failure, sum(a(:0)), jet(0.0_wp), 'sum of nothing')
      s = a(1)*b(1) + a(2)*b(2) + a(3)*b(3)
      call same(failure, dot_product(a, b), s, 'dot_product')
      call same(failure, dot_product(a, c), a(1)*c(1) + a(2)*c(2) + a(3)*c(3), 'dot_product with reals')
      call same(failure, dot_product(c, a), dot_product(a, c), 'dot_product of reals')
      call same(failure, sum(cross(a, b)*cross(a, b)), dot_product(a, a)*dot_product(b, b) - s*s, 'cross')
      call check_below(failure, maxval(gap(cross(a, c), -cross(c, a))), 1.0e-14_wp, 'cross with reals')
      call same(failure, dot_product(cross(a, c), a), jet(0.0_wp), 'across')
      call all_same('jets and a vector', matmul(m, a), [(dot_product(m(i, :), a), i=1, 3)])
      call all_same('jets and reals', matmul(m, c), [(dot_product(m(i, :), c), i=1, 3)])
      call all_same('reals and jets', matmul(k, a), [(dot_product(k(i, :), a), i=1, 3)])
      call all_same('a row', matmul(a, m), [(dot_product(a, m(:, i)), i=1, 3)])
      call all_same('a row of jets', matmul(a, k), [(dot_product(a, k(:, i)), i=1, 3)])
      call all_same('a row of reals', matmul(c, m), [(dot_product(c, m(:, i)), i=1, 3)])
      call all_same('matrices', matmul(matmul(m, m), a), matmul(m, matmul(m, a)))
      call all_same('matrices with reals', matmul(matmul(m, k), a), matmul(m, matmul(k, a)))
      call all_same('matrices of reals', matmul(matmul(k, m), a), matmul(k, matmul(m, a)))

   contains

      subroutine all_same(name, x, y)
         character(*), intent(in) :: name
         type(jet_t), intent(in) :: x(:), y(:)

         call check_below(failure, maxval(gap(x, y)), 1.0e-11_wp, name)
      end subroutine all_same

   end subroutine vectors

   subroutine rotations(failure)
      character(:), allocatable, intent(inout) :: failure
      type(jet_t) :: p(4), q(4), u(3)
      real(wp), parameter :: c(3) = [0.3_wp, -0.2_wp, 0.9_wp]

      q = sample([0.5_wp, -0.1_wp, 0.7_wp, 0.2_wp], [1, 2, 3, 4])
      q = q/norm2(q)
      p = sample([0.9_wp, 0.4_wp, -0.3_wp, 0.2_wp], [2, 1, 4, 3])
      p = p/norm2(p)
      u = sample([0.5_wp, -1.2_wp, 2.0_wp], [1, 2, 3])
      call check_below(failure, maxval(abs(matmul(matrix_of_quaternion(q%v), c) - values(rotate(q, c)))), 1.0e-15_wp, 'as a matrix')
      call check_below(failure, maxval(gap(rotate_back(q, rotate(q, u)), u)), 1.0e-13_wp, 'there and back')
      call check_below(failure, maxval(gap(rotate_back(q, c), rotate(quaternion_conjugate(q), c))), 1.0e-13_wp, 'back')
      call check_below(failure, maxval(gap(rotate(quaternion_product(p, q), c), rotate(p, rotate(q, c)))), 1.0e-13_wp, 'one by one')
      call check_below(failure, maxval(gap(quaternion_rate(q, u), 0.5_wp*quaternion_product(q, [jet(0.0_wp), u]))), &
                       1.0e-14_wp, 'rate')
   end subroutine rotations

   !> Values of jets.
   pure function values(a) result(v)
      type(jet_t), intent(in) :: a(:)
      real(wp) :: v(size(a))

      v = a%v
   end function values

   !> A function along a path and its central differences.
   subroutine differences(failure)
      character(:), allocatable, intent(inout) :: failure
      type(jet_t) :: ahead, behind, f, s
      real(wp), parameter :: h = 1.0e-3_wp

      s = jet(0.4_wp, 1.0_wp, 0.0_wp)
      f = along(s)
      ahead = along(jet(0.4_wp + h))
      behind = along(jet(0.4_wp - h))
      call check_below(failure, abs(f%d(1) - (ahead%v - behind%v)/(2.0_wp*h)), 1.0e-5_wp, 'first')
      call check_below(failure, abs(f%dd - (ahead%v - 2.0_wp*f%v + behind%v)/h**2), 1.0e-5_wp, 'second')
   end subroutine differences

   pure function along(s) result(f)
      type(jet_t), intent(in) :: s
      type(jet_t) :: f

      f = atan2(sin(2*s), 1.0_wp + s**2)*exp(-s)/sqrt(1.0_wp + log(2.0_wp + s)) + s**1.5_wp*tanh(s)
   end function along

   subroutine no_derivative(failure)
      character(:), allocatable, intent(inout) :: failure
      type(jet_t) :: z

      z = norm2(sample([0.0_wp, 0.0_wp], [1, 2]))
      call check(failure, abs(z%v) <= 0.0_wp .and. ieee_is_nan(z%d(1)) .and. ieee_is_nan(z%dd), 'length zero')
      z = norm2([jet(0.0_wp), jet(0.0_wp)])
      call check_below(failure, gap(z, jet(0.0_wp)), 0.0_wp, 'a length that stays zero')
      z = asin(sample(1.0_wp, 1))
      call check(failure, ieee_is_nan(z%d(1)), 'the end of asin')
      z = sample(0.0_wp, 1)**0.5_wp
      call check(failure, ieee_is_nan(z%d(1)), 'a root of zero')
   end subroutine no_derivative

end module test_jet
