!> Columns of a sparse matrix that can be found together: those that share no row.
module taut_linalg_coloring
   implicit none (type, external)
   private
   public :: color_columns

contains

   !> Gives every column a color so that no row has entries in two columns of one color; first come, first served.
   !!
   !! Source: A.R. Curtis, M.J.D. Powell, J.K. Reid, On the estimation of sparse Jacobian matrices, J. Inst. Maths Applics 13 (1974)
   !! 117-119.
   pure subroutine color_columns(first, column, color, colors)
      !> First entry of each row in `column`, and the number of entries plus one at the end: (rows + 1).
      integer, intent(in) :: first(:)
      !> Column of each entry.
      integer, intent(in) :: column(:)
      !> Color of each column, from 1: (columns).
      integer, intent(out) :: color(:)
      !> How many there are.
      integer, intent(out) :: colors
      integer :: begin(size(color) + 1), row_of(size(column)), filled(size(color)), taken_for(size(color))
      integer :: i, j, k, l

      ! The rows of each column.
      begin(:) = 0
      do k = 1, size(column)
         begin(column(k) + 1) = begin(column(k) + 1) + 1
      end do
      begin(1) = 1
      do j = 1, size(color)
         begin(j + 1) = begin(j + 1) + begin(j)
      end do
      filled(:) = 0
      do i = 1, size(first) - 1
         do k = first(i), first(i + 1) - 1
            j = column(k)
            row_of(begin(j) + filled(j)) = i
            filled(j) = filled(j) + 1
         end do
      end do

      color(:) = 0
      colors = 0
      taken_for(:) = 0
      do j = 1, size(color)
         do l = begin(j), begin(j + 1) - 1
            i = row_of(l)
            do k = first(i), first(i + 1) - 1
               if (color(column(k)) > 0) taken_for(color(column(k))) = j
            end do
         end do
         do l = 1, colors + 1
            if (taken_for(l) /= j) exit
         end do
         color(j) = l
         colors = max(colors, l)
      end do
   end subroutine color_columns

end module taut_linalg_coloring
