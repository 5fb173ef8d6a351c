!> The decision on the rank of a constraint matrix: what counts as zero, with each number and its reason in this one place.
!!
!! A row that depends on others shows as a small pivot or singular value of S = A K^-1 A^T, or of A L^-T with K = L L^T. These
!! are judged on matrices scaled to unit rows (unit diagonal for S), so that units of constraints and masses do not matter.
module taut_linalg_rank
   use taut_kinds, only: wp
   implicit none (type, external)
   private
   public :: rcond_of_s, rcond_of_root, rcond_of_pivots, widest_range
   public :: doubtful_in_s, doubtful_in_root, pivot_cut, least_pivot, unit_diagonal
   public :: effective_rank, rank_by_pivots, clear_rank_by_pivots

   !> Singular values of S below this, relative to the largest, are zero: S is formed with an error of some n units of round-off,
   !! so that nothing below carries information for n up to thousands.
   real(wp), parameter :: rcond_of_s = 1.0e-12_wp
   !> The same for A L^-T, whose singular values are the roots of those of S and are not spoiled by squaring: below, they are
   !! round-off of the rows of A themselves.
   real(wp), parameter :: rcond_of_root = 1.0e-9_wp
   !> The same for pivots that decide alone: they may exceed the singular value that they stand for by some decades.
   real(wp), parameter :: rcond_of_pivots = 1.0e-8_wp
   !> Pivots and singular values of S above this are safely not zero: they cannot be mistaken for what round-off or a slightly
   !! violated constraint has made out of a zero. Below, they are doubtful; for A L^-T, its root.
   real(wp), parameter :: safe_in_s = 1.0e-8_wp, safe_in_root = 1.0e-4_wp
   !> A pivot can be larger than the singular value that it stands for: where singular values can be asked, pivots decide only
   !! if they are that much clearer.
   real(wp), parameter :: clearly = 10.0_wp
   !> Ratio of neighboring singular values that tells 'small' from 'nothing but noise' in the doubtful zone: a chain's spectrum
   !! decays by less from one value to the next.
   real(wp), parameter :: gap = 1.0e3_wp
   !> The noise that is let through must stay below this part of what it is compared with.
   real(wp), parameter :: noise_factor = 10.0_wp
   !> Pivots that decide alone are never cut above this for the sake of noise: long chains have such pivots.
   real(wp), parameter :: largest_cut = 1.0e-6_wp
   !> Where the singular values that count spread more than this, round-off of the large ones hides the small ones, and the
   !! solution is that of the scaled matrix.
   real(wp), parameter :: widest_range = 1.0e-6_wp

contains

   !> Up to which size, relative to the largest, singular values and pivots of S are doubtful.
   pure function doubtful_in_s(noise) result(doubtful)
      !> Relative error of the rows of A, for want of a state that meets the constraints: singular values of S up to its square
      !! can be made of nothing else.
      real(wp), intent(in) :: noise
      !> Between `rcond_of_s` and 1.
      real(wp) :: doubtful

      doubtful = max(safe_in_s, min(1.0_wp, (noise_factor*noise)**2))
   end function doubtful_in_s

   !> The same for singular values of A L^-T.
   pure function doubtful_in_root(noise) result(doubtful)
      !> Relative error of the rows of A.
      real(wp), intent(in) :: noise
      !> Between `rcond_of_root` and 1.
      real(wp) :: doubtful

      doubtful = max(safe_in_root, min(1.0_wp, noise_factor*noise))
   end function doubtful_in_root

   !> Pivots of S in a fixed order up to this part of their own diagonal entry are zero.
   pure function pivot_cut(rcond, noise) result(cut)
      !> What counts as zero without noise.
      real(wp), intent(in) :: rcond
      !> Relative error of the rows of A.
      real(wp), intent(in) :: noise
      !> The part.
      real(wp) :: cut

      ! What a slightly violated constraint makes out of a zero is of the order of the square of the violation.
      cut = max(rcond, min(largest_cut, (noise_factor*noise)**2))
   end function pivot_cut

   !> Size of the pivots of a matrix of unit diagonal below which there is round-off alone.
   pure function least_pivot(n) result(least)
      !> Order of the matrix.
      integer, intent(in) :: n
      !> The size.
      real(wp) :: least

      least = max(n, 10)*epsilon(1.0_wp)
   end function least_pivot

   !> The factor of a row and column that gives it a unit diagonal entry; 1 for a row of zeros.
   elemental function unit_diagonal(s) result(scale)
      !> The diagonal entry, not negative.
      real(wp), intent(in) :: s
      !> 1/sqrt(s).
      real(wp) :: scale

      scale = 1.0_wp
      if (s > tiny(1.0_wp)) scale = 1.0_wp/sqrt(s)
   end function unit_diagonal

   !> How many singular values count.
   !!
   !! Those below `rcond` times the largest are zero. Between `rcond` and `doubtful` the first gap of three decades tells:
   !! what lies below it is noise (a constraint that is redundant on the manifold and slightly less so beside it), while
   !! a spectrum that decays without a gap (a long chain) is kept whole.
   pure function effective_rank(s, rcond, doubtful) result(rank)
      !> Singular values in decreasing order.
      real(wp), intent(in) :: s(:)
      !> Relative to the largest: certainly zero below.
      real(wp), intent(in) :: rcond
      !> Relative to the largest: certainly not zero above.
      real(wp), intent(in) :: doubtful
      !> Their number.
      integer :: rank
      integer :: k

      rank = 0
      if (size(s) == 0) return
      if (.not. s(1) > tiny(1.0_wp)) return
      rank = count(s > rcond*s(1))
      do k = 1, rank - 1
         if (s(k + 1) <= doubtful*s(1) .and. s(k) >= gap*s(k + 1)) then
            rank = k
            return
         end if
      end do
   end function effective_rank

   !> The rank by pivots alone, as if they were singular values: they are as good but for a factor.
   pure function rank_by_pivots(p, rcond, doubtful) result(rank)
      !> Pivots of a matrix of unit diagonal in decreasing order.
      real(wp), intent(in) :: p(:)
      !> Relative to the largest: certainly zero below, see `effective_rank`.
      real(wp), intent(in) :: rcond
      !> Relative to the largest: certainly not zero above.
      real(wp), intent(in) :: doubtful
      !> Its rank.
      integer :: rank

      rank = effective_rank(p, max(rcond, epsilon(1.0_wp)), doubtful)
   end function rank_by_pivots

   !> The rank by pivots where they leave no doubt, otherwise -1.
   pure function clear_rank_by_pivots(p, rcond, doubtful) result(rank)
      !> Pivots of a matrix of unit diagonal in decreasing order.
      real(wp), intent(in) :: p(:)
      !> Relative to the largest: certainly zero below, see `effective_rank`.
      real(wp), intent(in) :: rcond
      !> Relative to the largest: certainly not zero above.
      real(wp), intent(in) :: doubtful
      !> Its rank, or -1.
      integer :: rank
      logical :: clear

      rank = count(p > clearly*max(doubtful, rcond))
      clear = rank == size(p)
      if (.not. clear .and. rank > 0) clear = p(rank + 1) <= min(doubtful/clearly, p(rank)/(clearly*gap))
      if (.not. clear) rank = -1
   end function clear_rank_by_pivots

end module taut_linalg_rank
