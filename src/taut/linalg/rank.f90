!> What decides on ranks: every number that tells zero from small, each with its reason.
!!
!! Which rows of a constraint matrix A depend on others is decided by `taut_linalg_row_selection` once for all solvers, in the
!! geometry of A and not in S = A K^-1 A^T, where masses and squares hide what is small; `taut_linalg_rank_keeper` carries the
!! decision along a motion. Where S alone is given, `taut_linalg_pseudo_inverse` judges its spectrum.
module taut_linalg_rank
   use taut_kinds, only: wp
   implicit none (type, external)
   private
   public :: doubtful_pivot, independent, exactly_dependent, largest_share, negligible, with_noise, weak_direction, &
             least_direction, most_refinements
   public :: dead_pivot, dead_steps, passed_pivot, pivot_floor, reaction_pivot, weak_pivot, weaker, ill_conditioned, refinements, &
             least_of_independent
   public :: seen_rising, rising_steps, above_violation
   public :: rcond_of_s, rcond_of_root, rcond_of_pivots, widest_range, doubtful_in_s, least_pivot, unit_diagonal
   public :: effective_rank, rank_by_pivots, clear_rank_by_pivots

   ! Rows of A, of length one; see `taut_linalg_row_selection`.

   !> A pivot of S = B B^T below this is a reason to look at the row itself. Above, it is not zero whatever the null vector: the
   !! error of a pivot is some eps |v|^2, and |v| was 300 in chains of 30 loops.
   real(wp), parameter :: doubtful_pivot = 1.0e-4_wp
   !> A row is kept if it has more than this that the others do not have, |B^T v| > 3e-7 |v|: 20 sqrt(eps), below which normal
   !! equations cannot tell. Dependent rows of 700 mechanisms had at most 8e-15, or 100 times the violation of their
   !! constraints; independent ones, with parts as slender as 1e-6, at least 1.1e-7.
   real(wp), parameter :: independent = 3.0e-7_wp
   !> A row that is left out although it has more than this only nearly depends on the others: a mechanism of the size 1 at a
   !! distance of 1e6 from its origin has this much round-off.
   real(wp), parameter :: exactly_dependent = 1.0e-10_wp
   !> Entries of null vectors beyond this ask for another choice of rows: at 1, exchanges would go on for ever between rows that
   !! are equals; without any, entries reach 1e5.
   real(wp), parameter :: largest_share = 2.0_wp
   !> Entries of null vectors below this part of its length are round-off.
   real(wp), parameter :: negligible = 64.0_wp*epsilon(1.0_wp)
   !> Passes through B, at most, that make a null vector exact: one for each direction that round-off has hidden in S, in excess of
   !! the first. They end where they get no further.
   integer, parameter :: most_refinements = 12
   !> Directions of a body's translation or rotation that its rows hold less than this part of how they hold the strongest one are
   !> stretched up to it: with parts as slender as 1e-6, the smallest singular value of independent rows rises from 1e-8 to 1e-3.
   real(wp), parameter :: weak_direction = 0.1_wp
   !> Directions that they hold less than this are not stretched: rows that have no more than that do not count as independent, as
   !> of two guides that are not quite parallel.
   real(wp), parameter :: least_direction = independent
   !> Beside the manifold a dependent row seems independent by about as much as constraints are violated; what exceeds the
   !! second is taken for independent all the same, as Newton's iteration is to see it.
   real(wp), parameter :: noise_factor = 10.0_wp, largest_noise = 1.0e-3_wp

   ! Along a motion; see `taut_linalg_rank_keeper`. Pivots are those of the kept rows, relative to their diagonal entries of S.

   !> A pivot of kept rows below this is a dead point: nothing is left of the row, within the square of 1e-6.
   real(wp), parameter :: dead_pivot = 1.0e-12_wp
   !> Near a dead point, kept rows with a pivot below this are passed over for the moment: to meet them would move the state by the
   !! tolerance of the projection, 1e-12, over the root of the pivot, which is more than the integration is wrong by.
   real(wp), parameter :: passed_pivot = 1.0e-8_wp
   !> With a pivot below this, reactions are not told from round-off: their relative error is eps over the square of the pivot, of
   !! which one factor is that of velocities and the other that of accelerations. A slider-crank had, by dopri5, 8 at 1e-8, 2e-2 at
   !! 1e-7, 7e-5 at 1e-6 and 4e-5 at 1e-5; by dop853 more at the smallest ones.
   real(wp), parameter :: reaction_pivot = 1.0e-5_wp
   !> Passing a dead point takes a step or two; staying there so many accepted steps is a change of the rank.
   integer, parameter :: dead_steps = 5
   !> Kept rows with a pivot below the first, and weaker than those chosen by the second, may no longer be the best choice.
   real(wp), parameter :: weak_pivot = 1.0e-6_wp, weaker = 1.0e-2_wp
   !> Rows that are left out are independent again when motions that the kept rows allow violate them by more than the first,
   !! which is what a row of 1e-6 leaves, and by more than the second times the violation of the constraints, at two accepted steps
   !! running: one of them may be a dead point.
   real(wp), parameter :: seen_rising = 1.0e-6_wp, above_violation = 100.0_wp
   integer, parameter :: rising_steps = 2
   !> With a pivot below each of these, solutions are made exact by so many passes through A, each of which has an error of eps
   !! over the pivot of what it corrects. They end sooner where they get no further.
   real(wp), parameter :: ill_conditioned(2) = [1.0e-5_wp, 1.0e-10_wp]
   integer, parameter :: refinements(0:2) = [0, 1, 6]
   !> Rows that were found independent at this very A have pivots: round-off may leave little of them where masses differ by many
   !! decades, but what it leaves is enough for the passes through A.
   real(wp), parameter :: least_of_independent = epsilon(1.0_wp)**2
   !> What counts as zero among pivots of rows that may have become dependent: round-off.
   real(wp), parameter :: pivot_floor = 16.0_wp*epsilon(1.0_wp)

   ! A symmetric matrix S alone, or any matrix by its singular values.

   !> Singular values of S below this, relative to the largest, are zero: S is formed with an error of some n units of round-off,
   !! so that nothing below carries information for n up to thousands.
   real(wp), parameter :: rcond_of_s = 1.0e-12_wp
   !> The same for matrices that are not squares of others.
   real(wp), parameter :: rcond_of_root = independent
   !> The same for pivots that decide alone: they may exceed the singular value that they stand for by some decades.
   real(wp), parameter :: rcond_of_pivots = 1.0e-8_wp
   !> Pivots and singular values of S above this are safely not zero: they cannot be mistaken for what round-off or a slightly
   !! violated constraint has made out of a zero. Below, they are doubtful.
   real(wp), parameter :: safe_in_s = 1.0e-8_wp
   !> A pivot can be larger than the singular value that it stands for: where singular values can be asked, pivots decide only
   !! if they are that much clearer.
   real(wp), parameter :: clearly = 10.0_wp
   !> Ratio of neighboring singular values that tells 'small' from 'nothing but noise' in the doubtful zone: a chain's spectrum
   !! decays by less from one value to the next.
   real(wp), parameter :: gap = 1.0e3_wp
   !> Where the singular values that count spread more than this, round-off of the large ones hides the small ones, and the
   !! solution is that of the scaled matrix.
   real(wp), parameter :: widest_range = 1.0e-6_wp

contains

   !> How much a row must have that others do not have, where the rows have errors.
   pure function with_noise(threshold, noise) result(least)
      !> What it must have without errors.
      real(wp), intent(in) :: threshold
      !> Relative error of the rows of A, for want of a state that meets the constraints.
      real(wp), intent(in) :: noise
      !> What it must have.
      real(wp) :: least

      least = max(threshold, min(largest_noise, noise_factor*noise))
   end function with_noise

   !> Up to which size, relative to the largest, singular values and pivots of S are doubtful.
   pure function doubtful_in_s(noise) result(doubtful)
      !> Relative error of the rows of A, for want of a state that meets the constraints: singular values of S up to its square
      !! can be made of nothing else.
      real(wp), intent(in) :: noise
      !> Between `rcond_of_s` and 1.
      real(wp) :: doubtful

      doubtful = max(safe_in_s, min(1.0_wp, (noise_factor*noise)**2))
   end function doubtful_in_s

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
