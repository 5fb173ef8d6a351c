!> What a misspelt name may have been meant to be.
module taut_spelling
   implicit none (type, external)
   private
   public :: nearest_name

contains

   !> The nearest of some names, if it is near enough to have been meant; empty otherwise.
   pure function nearest_name(name, known) result(meant)
      !> The name as written.
      character(*), intent(in) :: name
      !> Those that there are; blank ones do not count.
      character(*), intent(in) :: known(:)
      !> One of them, or nothing.
      character(len=len(known)) :: meant
      integer :: best, distance, i

      meant = ''
      ! A third of the letters may be wrong, one in any case, but not all.
      best = max(1, len_trim(name)/3) + 1
      do i = 1, size(known)
         if (abs(len_trim(known(i)) - len_trim(name)) >= best .or. len_trim(known(i)) == 0) cycle
         distance = edits(trim(name), trim(known(i)))
         if (distance >= min(best, len_trim(name))) cycle
         best = distance
         meant = known(i)
      end do
   end function nearest_name

   !> Letters to insert, remove, replace or exchange with the next (Damerau and Levenshtein, without overlaps).
   pure integer function edits(one, two) result(distance)
      character(*), intent(in) :: one, two
      integer :: cost, i, j, rows(0:len(two), 0:2)

      ! Rows i - 2, i - 1 and i of the table of distances between beginnings.
      rows(:, 1) = 0
      rows(:, 2) = [(j, j=0, len(two))]
      do i = 1, len(one)
         rows(:, 0) = rows(:, 1)
         rows(:, 1) = rows(:, 2)
         rows(0, 2) = i
         do j = 1, len(two)
            cost = merge(0, 1, one(i:i) == two(j:j))
            rows(j, 2) = min(rows(j - 1, 2) + 1, rows(j, 1) + 1, rows(j - 1, 1) + cost)
            if (i == 1 .or. j == 1) cycle
            if (one(i - 1:i) == two(j:j)//two(j - 1:j - 1)) rows(j, 2) = min(rows(j, 2), rows(max(j - 2, 0), 0) + 1)
         end do
      end do
      distance = rows(len(two), 2)
   end function edits

end module taut_spelling
