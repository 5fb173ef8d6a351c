!> A bumpy road and half a car: a rod on two stiff springs; one end of its axle follows the road, the other stays.
!!
!! Equations and data: F. Mazzia and C. Magherini, Test set for initial value problem solvers, release 2.4 (2008), 'Car axis',
!! there of S. Schneider. All lengths are without a unit; M = diag(K), K = epsilon^2 m/2, and gravity is 1.
module car_axis_system
   use taut
   implicit none (type, external)
   private
   public :: car_axis_t, car_axis_start

   !> The rod's ends {x_l, y_l, x_r, y_r} above the axle from the origin to {x_b(t), y_b(t)}.
   type, extends(automatic_system_t) :: car_axis_t
      !> Of the rod and the axle, and of the relaxed springs.
      real(wp) :: length = 1.0_wp, free_length = 0.5_wp
      !> Of the road [1 and rad/s].
      real(wp) :: height = 0.1_wp, frequency = 10.0_wp
      !> Mass of an end, K.
      real(wp) :: inertia = 1.0e-4_wp*10.0_wp/2.0_wp
   contains
      procedure :: phi, potential
   end type car_axis_t

contains

   !> Sizes, and the published start.
   subroutine car_axis_start(model, start)
      !> The model.
      type(car_axis_t), intent(out) :: model
      !> Where it begins.
      type(state_t), intent(out) :: start

      call model%define(n=4, c=2, mass_blocks=[1, 1, 1, 1])
      allocate (model%diagonal_mass(4), source=model%inertia)
      start%x = [0.0_wp, model%free_length, model%length, model%free_length]
      start%v = [-model%free_length/model%length, 0.0_wp, -model%free_length/model%length, 0.0_wp]
   end subroutine car_axis_start

   !> The left spring stays across the axle; the rod keeps its length.
   subroutine phi(self, at, value)
      class(car_axis_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value(:)
      type(jet_t) :: axle(2)

      axle = axle_end(self, at%t)
      value(1) = at%x(1)*axle(1) + at%x(2)*axle(2)
      value(2) = (at%x(1) - at%x(3))**2 + (at%x(2) - at%x(4))**2 - self%length**2
   end subroutine phi

   !> Springs of stiffness 1, and the weight.
   subroutine potential(self, at, value)
      class(car_axis_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value
      type(jet_t) :: axle(2)

      axle = axle_end(self, at%t)
      value = 0.5_wp*(hypot(at%x(1), at%x(2)) - self%free_length)**2 &
              + 0.5_wp*(hypot(at%x(3) - axle(1), at%x(4) - axle(2)) - self%free_length)**2 + self%inertia*(at%x(2) + at%x(4))
   end subroutine potential

   !> Where the end of the axle is that follows the road.
   function axle_end(self, t) result(place)
      class(car_axis_t), intent(in) :: self
      type(jet_t), intent(in) :: t
      type(jet_t) :: place(2)

      place(2) = self%height*sin(self%frequency*t)
      place(1) = sqrt(self%length**2 - place(2)**2)
   end function axle_end

end module car_axis_system
