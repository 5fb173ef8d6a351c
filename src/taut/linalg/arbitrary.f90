!> Numbers that follow no pattern, the same in every run: a vector of them has a part in all directions.
module taut_linalg_arbitrary
   use taut_kinds, only: wp
   implicit none (type, external)
   private
   public :: arbitrary

contains

   !> One of them. In a loop of another file it is no vector function, whose library every program would load at its start.
   elemental function arbitrary(k) result(value)
      !> Which one.
      integer, intent(in) :: k
      !> Between -1 and 1.
      real(wp) :: value

      value = sin(real(k, wp)**2)
   end function arbitrary

end module taut_linalg_arbitrary
