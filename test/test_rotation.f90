!> Rotations: identities, limits of small and of half turns, tangents against finite differences.
module test_rotation
   use taut_kinds, only: wp
   use taut_rotation, only: cross, exp_rotation, log_rotation, matrix_of_quaternion, quaternion_body_rate, &
                            quaternion_conjugate, quaternion_normalized, quaternion_of_axes, quaternion_of_matrix, &
                            quaternion_of_vector, quaternion_product, quaternion_rate, right_tangent, &
                            right_tangent_inverse, rotate, rotate_back, skew, vector_of_quaternion
   use testing, only: check_below, check_close, new_test, test_t
   implicit none (type, external)
   private
   public :: collect_rotation

   real(wp), parameter :: pi = acos(-1.0_wp)
   real(wp), parameter :: axis(3) = [2.0_wp, -3.0_wp, 6.0_wp]/7.0_wp
   real(wp), parameter :: angles(*) = [1.0e-300_wp, 1.0e-160_wp, 1.0e-20_wp, 1.0e-9_wp, 1.0e-8_wp, 1.0e-5_wp, 1.0e-3_wp, &
                                       0.1_wp, 0.299999_wp, 0.300001_wp, 1.0_wp, 2.0_wp, 3.0_wp, pi - 1.0e-3_wp, &
                                       pi - 1.0e-8_wp, pi - 1.0e-13_wp]
   real(wp), parameter :: identity(3, 3) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, &
                                                    0.0_wp, 0.0_wp, 1.0_wp], [3, 3])

contains

   !> All tests of this module.
   function collect_rotation() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('the exponential is a rotation', exponential), &
               new_test('logarithm and exponential are inverse for every angle', logarithm), &
               new_test('half turns about the axes', half_turns), &
               new_test('tangents against finite differences', tangents), &
               new_test('tangents and their inverses at every angle', tangent_inverses), &
               new_test('quaternions follow matrices', quaternions), &
               new_test('rates of quaternions', quaternion_rates), &
               new_test('an orientation from two directions', two_directions)]
   end function collect_rotation

   subroutine exponential(failure)
      character(:), allocatable, intent(inout) :: failure
      real(wp) :: r(3, 3), s(3, 3)
      integer :: i

      do i = 1, size(angles)
         r = exp_rotation(angles(i)*axis)
         call check_below(failure, maxval(abs(matmul(transpose(r), r) - identity)), 2.0e-15_wp, 'R^T R = I')
         call check_below(failure, maxval(abs(cross(r(:, 1), r(:, 2)) - r(:, 3))), 2.0e-15_wp, 'right-handed')
         call check_below(failure, maxval(abs(matmul(r, axis) - axis)), 1.0e-15_wp, 'the axis stays')
         call check_close(failure, r(1, 1) + r(2, 2) + r(3, 3), 1.0_wp + 2.0_wp*cos(angles(i)), 2.0e-15_wp, 'trace')
      end do
      s = skew(axis)
      call check_below(failure, maxval(abs(matmul(s, [1.0_wp, 2.0_wp, 3.0_wp]) - cross(axis, [1.0_wp, 2.0_wp, 3.0_wp]))), &
                       1.0e-15_wp, '(a x) b = a x b')
      ! A quarter turn about z takes x to y.
      call check_below(failure, maxval(abs(matmul(exp_rotation([0.0_wp, 0.0_wp, 0.5_wp*pi]), [1.0_wp, 0.0_wp, 0.0_wp]) &
                                           - [0.0_wp, 1.0_wp, 0.0_wp])), 1.0e-15_wp, 'a quarter turn')
   end subroutine exponential

   subroutine logarithm(failure)
      character(:), allocatable, intent(inout) :: failure
      real(wp) :: theta(3)
      integer :: i

      do i = 1, size(angles)
         theta = log_rotation(exp_rotation(angles(i)*axis))
         ! Below 1e-16 the matrix still carries the vector, off its diagonal.
         call check_below(failure, maxval(abs(theta - angles(i)*axis)), 4.0e-15_wp*angles(i), 'log exp')
         theta = vector_of_quaternion(quaternion_of_vector(angles(i)*axis))
         call check_below(failure, maxval(abs(theta - angles(i)*axis)), 2.0e-15_wp*angles(i), 'vector of quaternion')
         theta = vector_of_quaternion(-3.0_wp*quaternion_of_vector(angles(i)*axis))
         call check_below(failure, maxval(abs(theta - angles(i)*axis)), 2.0e-15_wp*angles(i), 'neither sign nor length matter')
      end do
      call check_below(failure, maxval(abs(log_rotation(identity))), 0.0_wp, 'log of the identity')
      ! Beyond half a turn the shorter way is found.
      theta = log_rotation(exp_rotation(4.0_wp*axis))
      call check_below(failure, maxval(abs(theta - (4.0_wp - 2.0_wp*pi)*axis)), 1.0e-14_wp, 'the shorter way')
   end subroutine logarithm

   subroutine half_turns(failure)
      character(:), allocatable, intent(inout) :: failure
      real(wp) :: r(3, 3)
      integer :: i

      do i = 1, 3
         r = -identity
         r(i, i) = 1.0_wp
         call check_close(failure, norm2(log_rotation(r)), pi, 1.0e-15_wp, 'half a turn')
         call check_below(failure, maxval(abs(abs(log_rotation(r)) - pi*identity(:, i))), 1.0e-15_wp, 'about an axis')
      end do
      r = 2.0_wp*spread(axis, 2, 3)*spread(axis, 1, 3) - identity
      call check_close(failure, abs(dot_product(log_rotation(r), axis)), pi, 1.0e-14_wp, 'half a turn about a skew axis')
   end subroutine half_turns

   !> R(theta + d)^T against R(theta): exp of J d, to second order, by central differences.
   subroutine tangents(failure)
      character(:), allocatable, intent(inout) :: failure
      real(wp), parameter :: d(3) = [0.3_wp, 0.5_wp, -0.2_wp], h = 1.0e-5_wp
      real(wp) :: theta(3), w(3), inverse_w(3)
      integer :: i

      do i = 1, size(angles)
         theta = angles(i)*axis
         w = log_rotation(matmul(transpose(exp_rotation(theta - h*d)), exp_rotation(theta + h*d)))/(2.0_wp*h)
         call check_below(failure, maxval(abs(w - matmul(right_tangent(theta), d))), 1.0e-9_wp, 'W = J d')
         w = log_rotation(matmul(exp_rotation(theta + h*d), transpose(exp_rotation(theta - h*d))))/(2.0_wp*h)
         call check_below(failure, maxval(abs(w - matmul(transpose(right_tangent(theta)), d))), 1.0e-9_wp, 'w = J^T d')
         if (angles(i) > 3.1_wp) cycle
         inverse_w = (log_rotation(matmul(exp_rotation(theta), exp_rotation(h*d))) &
                      - log_rotation(matmul(exp_rotation(theta), exp_rotation(-h*d))))/(2.0_wp*h)
         call check_below(failure, maxval(abs(inverse_w - matmul(right_tangent_inverse(theta), d))), 1.0e-9_wp, 'd = J^-1 W')
      end do
   end subroutine tangents

   subroutine tangent_inverses(failure)
      character(:), allocatable, intent(inout) :: failure
      integer :: i

      do i = 1, size(angles)
         call check_below(failure, maxval(abs(matmul(right_tangent(angles(i)*axis), right_tangent_inverse(angles(i)*axis)) &
                                              - identity)), 2.0e-14_wp, 'J J^-1 = I')
         ! J^T and J differ by the rotation.
         call check_below(failure, maxval(abs(matmul(exp_rotation(angles(i)*axis), right_tangent(angles(i)*axis)) &
                                              - transpose(right_tangent(angles(i)*axis)))), 2.0e-14_wp, 'R J = J^T')
      end do
   end subroutine tangent_inverses

   subroutine quaternions(failure)
      character(:), allocatable, intent(inout) :: failure
      real(wp), parameter :: v(3) = [0.7_wp, -1.1_wp, 0.4_wp]
      real(wp) :: p(4), q(4), r(3, 3)
      integer :: i

      p = quaternion_of_vector([0.4_wp, 0.1_wp, -0.9_wp])
      do i = 1, size(angles)
         q = quaternion_of_vector(angles(i)*axis)
         r = exp_rotation(angles(i)*axis)
         call check_below(failure, maxval(abs(matrix_of_quaternion(q) - r)), 2.0e-15_wp, 'matrix')
         call check_below(failure, maxval(abs(matrix_of_quaternion(-5.0_wp*q) - r)), 2.0e-15_wp, 'matrix of any length')
         call check_below(failure, maxval(abs(quaternion_of_matrix(r) - q)), 2.0e-15_wp, 'quaternion of a matrix')
         call check_below(failure, maxval(abs(rotate(q, v) - matmul(r, v))), 2.0e-15_wp, 'rotate')
         call check_below(failure, maxval(abs(rotate_back(q, v) - matmul(transpose(r), v))), 2.0e-15_wp, 'rotate back')
         call check_below(failure, maxval(abs(matrix_of_quaternion(quaternion_product(p, q)) &
                                              - matmul(matrix_of_quaternion(p), r))), 2.0e-15_wp, 'product')
         call check_below(failure, maxval(abs(quaternion_product(q, quaternion_conjugate(q)) &
                                              - [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp])), 1.0e-15_wp, 'q q* = 1')
      end do
      call check_close(failure, norm2(quaternion_normalized([3.0_wp, -4.0_wp, 1.0_wp, 2.0_wp])), 1.0_wp, 1.0e-15_wp, 'unit')
      call check_close(failure, norm2(quaternion_normalized([0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp])), 1.0_wp, 0.0_wp, 'unit for zero')
   end subroutine quaternions

   subroutine quaternion_rates(failure)
      character(:), allocatable, intent(inout) :: failure
      real(wp), parameter :: w(3) = [0.3_wp, -0.8_wp, 1.7_wp], h = 1.0e-5_wp
      real(wp) :: expected(4), q(4)

      q = quaternion_of_vector([1.0_wp, 0.5_wp, -0.7_wp])
      expected = (quaternion_product(q, quaternion_of_vector(h*w)) - quaternion_product(q, quaternion_of_vector(-h*w)))/(2.0_wp*h)
      call check_below(failure, maxval(abs(quaternion_rate(q, w) - expected)), 1.0e-9_wp, 'rate of a body rotation')
      call check_below(failure, maxval(abs(quaternion_body_rate(q, quaternion_rate(q, w)) - w)), 1.0e-15_wp, 'and back')
   end subroutine quaternion_rates

   subroutine two_directions(failure)
      character(:), allocatable, intent(inout) :: failure
      real(wp) :: q(4), r(3, 3)

      q = quaternion_of_axes([0.0_wp, 0.0_wp, -2.0_wp], [1.0_wp, 0.0_wp, 5.0_wp])
      r = matrix_of_quaternion(q)
      call check_below(failure, maxval(abs(r(:, 1) - [0.0_wp, 0.0_wp, -1.0_wp])), 1.0e-15_wp, 'first axis')
      call check_below(failure, maxval(abs(r(:, 2) - [1.0_wp, 0.0_wp, 0.0_wp])), 1.0e-15_wp, 'second axis')
      q = quaternion_of_axes([1.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 1.0_wp, 0.0_wp])
      call check_below(failure, maxval(abs(q - [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp])), 0.0_wp, 'the identity is exact')
   end subroutine two_directions

end module test_rotation
