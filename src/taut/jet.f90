!> Numbers that carry derivatives along: a value, first derivatives in four directions at once, and the second derivative in the
!! first of them.
!!
!! A function that is written with them in the place of real numbers gives its own derivatives, exact to round-off. Where x moves
!! along a path, x(s), the first direction holds {x, dx/ds, d2x/ds2} and the result is {f, df/ds, d2f/ds2}: a Taylor series that
!! is cut off. Where columns of a Jacobian are asked for, each direction is one of them.
!!
!! All operators, comparisons (of values) and functions have the names that real numbers have, and reals and integers mix with jets;
!! `distance` of two points, or of the columns of two matrices, is one more. A function that gives an array allocates it where its
!! size is not known to the compiler.
module taut_jet
   use taut_jet_comparison, only: operator(==), operator(/=), operator(<), operator(<=), operator(>), operator(>=)
   use taut_jet_functions, only: operator(**), abs, acos, asin, atan, atan2, cos, cosh, exp, log, max, min, sign, sin, sinh, &
                                 tan, tanh
   use taut_jet_lengths, only: distance, hypot, norm2, sqrt
   use taut_jet_number, only: jet_t, jet, operator(+), operator(-), operator(*), operator(/), assignment(=)
   use taut_jet_rotation, only: quaternion_conjugate, quaternion_product, quaternion_rate, rotate, rotate_back
   use taut_jet_vectors, only: cross, dot_product, matmul, sum
   implicit none (type, external)
   private
   public :: jet_t, jet, operator(+), operator(-), operator(*), operator(/), operator(**), assignment(=)
   public :: operator(==), operator(/=), operator(<), operator(<=), operator(>), operator(>=)
   public :: abs, acos, asin, atan, atan2, cos, cosh, exp, hypot, log, max, min, sign, sin, sinh, sqrt, tan, tanh
   public :: quaternion_conjugate, quaternion_product, quaternion_rate, rotate, rotate_back
   public :: cross, distance, dot_product, matmul, norm2, sum
end module taut_jet
