!> Makes of the rows of A, taken in the middle of a displacement, a discrete derivative of phi: A_m d is the difference of phi, to
!> round-off and at any length of d.
!!
!! Each row is corrected along the part of d that belongs to its own coordinates, so that its pattern stays:
!! a_m = a + (phi(x_new) - phi(x) - a d) d^T/(d^T d).
!!
!! Source: O. Gonzalez, Time integration and discrete Hamiltonian systems, J. Nonlinear Sci. 6 (1996) 449-467.
module taut_constrained_discrete_derivative
   use taut_kinds, only: wp
   use taut_linalg_csr, only: csr_t
   implicit none (type, external)
   private
   public :: meet_difference

contains

   !> Corrects the first rows.
   pure subroutine meet_difference(a, d, difference)
      !> A in the middle, corrected.
      class(csr_t), intent(inout) :: a
      !> The displacement: (n).
      real(wp), intent(in), contiguous :: d(:)
      !> What A_m d shall be: (n_phi).
      real(wp), intent(in), contiguous :: difference(:)
      integer :: behind, i, k, row
      real(wp) :: excess, length

      do i = 1, size(difference)
         if (a%full) then
            row = (i - 1)*a%n + 1
            behind = row + a%n - 1
         else
            row = a%first(i)
            behind = a%first(i + 1) - 1
         end if
         excess = difference(i)
         length = 0.0_wp
         do k = row, behind
            excess = excess - a%values(k)*along(k)
            length = length + along(k)**2
         end do
         if (length <= 0.0_wp) cycle
         do k = row, behind
            a%values(k) = a%values(k) + excess/length*along(k)
         end do
      end do

   contains

      !> The entry of d that belongs to an entry of A.
      pure real(wp) function along(k)
         integer, intent(in) :: k

         if (a%full) then
            along = d(k - row + 1)
         else
            along = d(a%column(k))
         end if
      end function along

   end subroutine meet_difference

end module taut_constrained_discrete_derivative
