!> The working precision, defined once for the whole library.
module taut_kinds
   use, intrinsic :: iso_fortran_env, only: int64, real64
   implicit none (type, external)
   private
   public :: last_place

   !> Kind of every real number in taut: IEEE double precision.
   integer, parameter, public :: wp = real64

contains

   !> The value of the last bit of a number that is positive and normal: `spacing`, without its calls.
   pure function last_place(value) result(ulp)
      !> The number.
      real(wp), intent(in) :: value
      !> A power of two.
      real(wp) :: ulp
      integer(int64), parameter :: mantissa = 2_int64**52 - 1_int64

      ulp = epsilon(1.0_wp)*transfer(iand(transfer(value, mantissa), not(mantissa)), value)
   end function last_place

end module taut_kinds
