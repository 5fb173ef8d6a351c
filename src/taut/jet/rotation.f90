!> Rotations of jets by unit quaternions, their scalar part first: see `taut_rotation`.
module taut_jet_rotation
   use taut_kinds, only: wp
   use taut_jet_number, only: jet_t, operator(*), operator(+), operator(-)
   use taut_jet_vectors, only: cross, dot_product
   implicit none (type, external)
   private
   public :: rotate, rotate_back, quaternion_conjugate, quaternion_product, quaternion_rate

   interface rotate
      module procedure :: rotate_jet, rotate_real
   end interface rotate

   interface rotate_back
      module procedure :: rotate_back_jet, rotate_back_real
   end interface rotate_back

   interface quaternion_conjugate
      module procedure :: conjugate
   end interface quaternion_conjugate

   interface quaternion_product
      module procedure :: product_jet
   end interface quaternion_product

   interface quaternion_rate
      module procedure :: rate
   end interface quaternion_rate

contains

   !> R u: from body to global axes.
   pure function rotate_jet(q, u) result(v)
      !> Unit quaternion.
      type(jet_t), intent(in) :: q(4)
      !> In body axes.
      type(jet_t), intent(in) :: u(3)
      !> In global axes.
      type(jet_t) :: v(3)
      type(jet_t) :: c(3)

      c = 2.0_wp*cross(q(2:4), u)
      v = u + q(1)*c + cross(q(2:4), c)
   end function rotate_jet

   !> R u, of a vector that is fixed in the body.
   pure function rotate_real(q, u) result(v)
      !> Unit quaternion.
      type(jet_t), intent(in) :: q(4)
      !> In body axes.
      real(wp), intent(in) :: u(3)
      !> In global axes.
      type(jet_t) :: v(3)
      type(jet_t) :: c(3)

      c = 2.0_wp*cross(q(2:4), u)
      v = u + q(1)*c + cross(q(2:4), c)
   end function rotate_real

   !> R^T u: from global to body axes.
   pure function rotate_back_jet(q, u) result(v)
      !> Unit quaternion.
      type(jet_t), intent(in) :: q(4)
      !> In global axes.
      type(jet_t), intent(in) :: u(3)
      !> In body axes.
      type(jet_t) :: v(3)

      v = rotate_jet(conjugate(q), u)
   end function rotate_back_jet

   !> R^T u, of a vector that is fixed in space.
   pure function rotate_back_real(q, u) result(v)
      !> Unit quaternion.
      type(jet_t), intent(in) :: q(4)
      !> In global axes.
      real(wp), intent(in) :: u(3)
      !> In body axes.
      type(jet_t) :: v(3)

      v = rotate_real(conjugate(q), u)
   end function rotate_back_real

   !> The inverse rotation.
   pure function conjugate(q) result(r)
      !> A quaternion.
      type(jet_t), intent(in) :: q(4)
      !> {q0, -q}.
      type(jet_t) :: r(4)

      r(1) = q(1)
      r(2:4) = -q(2:4)
   end function conjugate

   !> p q: first q, then p.
   pure function product_jet(p, q) result(r)
      !> The first quaternion.
      type(jet_t), intent(in) :: p(4)
      !> The second quaternion.
      type(jet_t), intent(in) :: q(4)
      !> Their product.
      type(jet_t) :: r(4)

      r(1) = p(1)*q(1) - dot_product(p(2:4), q(2:4))
      r(2:4) = p(1)*q(2:4) + q(1)*p(2:4) + cross(p(2:4), q(2:4))
   end function product_jet

   !> qdot = q {0, W}/2.
   pure function rate(q, w) result(r)
      !> Unit quaternion.
      type(jet_t), intent(in) :: q(4)
      !> Angular velocity in body axes [rad/s].
      type(jet_t), intent(in) :: w(3)
      !> Its rate [1/s].
      type(jet_t) :: r(4)

      r(1) = -0.5_wp*dot_product(q(2:4), w)
      r(2:4) = 0.5_wp*(q(1)*w + cross(q(2:4), w))
   end function rate

end module taut_jet_rotation
