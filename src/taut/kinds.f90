!> The working precision, defined once for the whole library.
module taut_kinds
   use, intrinsic :: iso_fortran_env, only: real64
   implicit none (type, external)
   private

   !> Kind of every real number in taut: IEEE double precision.
   integer, parameter, public :: wp = real64
end module taut_kinds
