!> Sums and products of vectors and matrices of jets.
module taut_jet_vectors
   use taut_kinds, only: wp
   use taut_jet_number, only: jet_t, jet, operator(*), operator(-)
   implicit none (type, external)
   private
   public :: sum, dot_product, cross, matmul

   interface sum
      module procedure :: sum_jet
   end interface sum

   interface dot_product
      module procedure :: dot_jet_jet, dot_jet_real, dot_real_jet
   end interface dot_product

   interface cross
      module procedure :: cross_jet_jet, cross_jet_real, cross_real_jet
   end interface cross

   interface matmul
      module procedure :: matmul_jet2_jet1, matmul_jet1_jet2, matmul_jet2_jet2, matmul_jet2_real1, matmul_jet1_real2, &
                matmul_jet2_real2, matmul_real2_jet1, matmul_real1_jet2, matmul_real2_jet2
   end interface matmul

contains

   !> Sum of an array.
   pure function sum_jet(a) result(c)
      !> The array.
      type(jet_t), intent(in) :: a(:)
      !> Its sum; zero if it is empty.
      type(jet_t) :: c

      integer :: i

      c = jet(0.0_wp)
      do i = 1, size(a)
         c = jet_t(c%v + a(i)%v, c%dd + a(i)%dd, c%d + a(i)%d)
      end do
   end function sum_jet

   !> a . b.
   pure function dot_jet_jet(a, b) result(c)
      !> A vector.
      type(jet_t), intent(in) :: a(:)
      !> A vector of the same length.
      type(jet_t), intent(in) :: b(:)
      !> Their product.
      type(jet_t) :: c
      integer :: i

      c = jet(0.0_wp)
      do i = 1, size(a)
         c = jet_t(c%v + a(i)%v*b(i)%v, c%dd + a(i)%v*b(i)%dd + 2.0_wp*a(i)%d(1)*b(i)%d(1) + a(i)%dd*b(i)%v, &
                   c%d + a(i)%v*b(i)%d + a(i)%d*b(i)%v)
      end do
   end function dot_jet_jet

   !> a . b.
   pure function dot_jet_real(a, b) result(c)
      !> A vector.
      type(jet_t), intent(in) :: a(:)
      !> A vector of the same length.
      real(wp), intent(in) :: b(:)
      !> Their product.
      type(jet_t) :: c
      integer :: i

      c = jet(0.0_wp)
      do i = 1, size(a)
         c = jet_t(c%v + a(i)%v*b(i), c%dd + a(i)%dd*b(i), c%d + a(i)%d*b(i))
      end do
   end function dot_jet_real

   !> a . b.
   pure function dot_real_jet(a, b) result(c)
      !> A vector.
      real(wp), intent(in) :: a(:)
      !> A vector of the same length.
      type(jet_t), intent(in) :: b(:)
      !> Their product.
      type(jet_t) :: c
      integer :: i

      c = jet(0.0_wp)
      do i = 1, size(a)
         c = jet_t(c%v + a(i)*b(i)%v, c%dd + a(i)*b(i)%dd, c%d + a(i)*b(i)%d)
      end do
   end function dot_real_jet

   !> a x b.
   pure function cross_jet_jet(a, b) result(c)
      !> The first vector.
      type(jet_t), intent(in) :: a(3)
      !> The second vector.
      type(jet_t), intent(in) :: b(3)
      !> Their product.
      type(jet_t) :: c(3)

      c(1) = a(2)*b(3) - a(3)*b(2)
      c(2) = a(3)*b(1) - a(1)*b(3)
      c(3) = a(1)*b(2) - a(2)*b(1)
   end function cross_jet_jet

   !> a x b.
   pure function cross_jet_real(a, b) result(c)
      !> The first vector.
      type(jet_t), intent(in) :: a(3)
      !> The second vector.
      real(wp), intent(in) :: b(3)
      !> Their product.
      type(jet_t) :: c(3)

      c(1) = a(2)*b(3) - a(3)*b(2)
      c(2) = a(3)*b(1) - a(1)*b(3)
      c(3) = a(1)*b(2) - a(2)*b(1)
   end function cross_jet_real

   !> a x b.
   pure function cross_real_jet(a, b) result(c)
      !> The first vector.
      real(wp), intent(in) :: a(3)
      !> The second vector.
      type(jet_t), intent(in) :: b(3)
      !> Their product.
      type(jet_t) :: c(3)

      c(1) = a(2)*b(3) - a(3)*b(2)
      c(2) = a(3)*b(1) - a(1)*b(3)
      c(3) = a(1)*b(2) - a(2)*b(1)
   end function cross_real_jet

   !> a b.
   pure function matmul_jet2_jet1(a, b) result(c)
      !> A matrix or a vector.
      type(jet_t), intent(in) :: a(:, :)
      !> A vector or a matrix.
      type(jet_t), intent(in) :: b(:)
      !> Their product.
      type(jet_t) :: c(size(a, 1))
      integer :: i

      do i = 1, size(a, 1)
         c(i) = dot_jet_jet(a(i, :), b)
      end do
   end function matmul_jet2_jet1

   !> a b.
   pure function matmul_jet1_jet2(a, b) result(c)
      !> A matrix or a vector.
      type(jet_t), intent(in) :: a(:)
      !> A vector or a matrix.
      type(jet_t), intent(in) :: b(:, :)
      !> Their product.
      type(jet_t) :: c(size(b, 2))
      integer :: i

      do i = 1, size(b, 2)
         c(i) = dot_jet_jet(a, b(:, i))
      end do
   end function matmul_jet1_jet2

   !> a b.
   pure function matmul_jet2_jet2(a, b) result(c)
      !> A matrix or a vector.
      type(jet_t), intent(in) :: a(:, :)
      !> A vector or a matrix.
      type(jet_t), intent(in) :: b(:, :)
      !> Their product.
      type(jet_t) :: c(size(a, 1), size(b, 2))
      integer :: i, j

      do j = 1, size(b, 2)
         do i = 1, size(a, 1)
            c(i, j) = dot_jet_jet(a(i, :), b(:, j))
         end do
      end do
   end function matmul_jet2_jet2

   !> a b.
   pure function matmul_jet2_real1(a, b) result(c)
      !> A matrix or a vector.
      type(jet_t), intent(in) :: a(:, :)
      !> A vector or a matrix.
      real(wp), intent(in) :: b(:)
      !> Their product.
      type(jet_t) :: c(size(a, 1))
      integer :: i

      do i = 1, size(a, 1)
         c(i) = dot_jet_real(a(i, :), b)
      end do
   end function matmul_jet2_real1

   !> a b.
   pure function matmul_jet1_real2(a, b) result(c)
      !> A matrix or a vector.
      type(jet_t), intent(in) :: a(:)
      !> A vector or a matrix.
      real(wp), intent(in) :: b(:, :)
      !> Their product.
      type(jet_t) :: c(size(b, 2))
      integer :: i

      do i = 1, size(b, 2)
         c(i) = dot_jet_real(a, b(:, i))
      end do
   end function matmul_jet1_real2

   !> a b.
   pure function matmul_jet2_real2(a, b) result(c)
      !> A matrix or a vector.
      type(jet_t), intent(in) :: a(:, :)
      !> A vector or a matrix.
      real(wp), intent(in) :: b(:, :)
      !> Their product.
      type(jet_t) :: c(size(a, 1), size(b, 2))
      integer :: i, j

      do j = 1, size(b, 2)
         do i = 1, size(a, 1)
            c(i, j) = dot_jet_real(a(i, :), b(:, j))
         end do
      end do
   end function matmul_jet2_real2

   !> a b.
   pure function matmul_real2_jet1(a, b) result(c)
      !> A matrix or a vector.
      real(wp), intent(in) :: a(:, :)
      !> A vector or a matrix.
      type(jet_t), intent(in) :: b(:)
      !> Their product.
      type(jet_t) :: c(size(a, 1))
      integer :: i

      do i = 1, size(a, 1)
         c(i) = dot_real_jet(a(i, :), b)
      end do
   end function matmul_real2_jet1

   !> a b.
   pure function matmul_real1_jet2(a, b) result(c)
      !> A matrix or a vector.
      real(wp), intent(in) :: a(:)
      !> A vector or a matrix.
      type(jet_t), intent(in) :: b(:, :)
      !> Their product.
      type(jet_t) :: c(size(b, 2))
      integer :: i

      do i = 1, size(b, 2)
         c(i) = dot_real_jet(a, b(:, i))
      end do
   end function matmul_real1_jet2

   !> a b.
   pure function matmul_real2_jet2(a, b) result(c)
      !> A matrix or a vector.
      real(wp), intent(in) :: a(:, :)
      !> A vector or a matrix.
      type(jet_t), intent(in) :: b(:, :)
      !> Their product.
      type(jet_t) :: c(size(a, 1), size(b, 2))
      integer :: i, j

      do j = 1, size(b, 2)
         do i = 1, size(a, 1)
            c(i, j) = dot_real_jet(a(i, :), b(:, j))
         end do
      end do
   end function matmul_real2_jet2

end module taut_jet_vectors
