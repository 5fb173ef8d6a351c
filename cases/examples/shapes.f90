!> Ritz shapes: three masses in a row, in two shapes that are symmetric, which is all the freedom that is left. Constraints
!> hold the first mass and the last one: two independent rows of A, two independent shapes X, and one independent row of A X.
!>
!> Held alike both are met. Held apart they are mildly inconsistent (Sect. 3.4.2): no symmetric shape meets both, and half of what
!> they are apart is left of each.
module row_system
   use taut
   implicit none (type, external)

   type, extends(automatic_system_t) :: row_t
      real(wp) :: k = 100.0_wp                         ! springs between walls and masses [N/m]
      real(wp) :: at_1 = 0.01_wp, at_3 = 0.01_wp      ! where the first and the last mass are held [m]
   contains
      procedure :: phi, potential
   end type row_t

contains

   subroutine phi(self, at, value)
      class(row_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value(:)
      value = [at%x(1) - self%at_1, at%x(3) - self%at_3]
   end subroutine phi

   subroutine potential(self, at, value)
      class(row_t), intent(in) :: self
      type(jet_state_t), intent(in) :: at
      type(jet_t), intent(out) :: value
      value = 0.5_wp*self%k*(at%x(1)**2 + (at%x(2) - at%x(1))**2 + (at%x(3) - at%x(2))**2 + at%x(3)**2)
   end subroutine potential

end module row_system

program shapes
   use taut
   use row_system
   implicit none (type, external)
   type(row_t) :: row
   type(ritz_t) :: reduced
   type(state_t) :: at
   type(integration_result_t) :: result
   type(start_report_t) :: full, start
   class(constrained_ode_t), allocatable :: ode
   type(sample_t) :: s
   type(error_t), allocatable :: error
   type(method_t) :: method
   real(wp), parameter :: apart(2) = [0.0_wp, 1.0e-3_wp]            ! [m]
   integer :: i, info

   call row%define(n=3, c=2, mass_blocks=[1, 1, 1])
   row%diagonal_mass = [1.0_wp, 2.0_wp, 1.0_wp]
   method%accept_inconsistent = .true.                              ! without it the second one is refused, with what is left
   print '(a8, 3a12, a14)', 'apart', 'rank of A', 'rank of AX', 'left', 'status'
   do i = 1, size(apart)
      row%at_3 = row%at_1 + apart(i)
      at = state_t(x=[0.0_wp, 0.0_wp, 0.0_wp], v=[0.0_wp, 0.0_wp, 0.0_wp])
      call consistent_start(row, method, at, full, error)
      call new_ritz(reduced, row, reshape([1.0_wp, 1.4_wp, 1.0_wp, 1.0_wp, -1.4_wp, 1.0_wp], [3, 2]), [(0.0_wp, info=1, 3)], error)
      at = state_t(x=[0.0_wp, 0.0_wp], v=[0.0_wp, 0.0_wp])
      call simulate(reduced, at, 1.0_wp, result, error, method, start=start, ode=ode)
      if (allocated(error)) error stop 'it could not begin'
      call ode%sample(at%t, [at%x, at%v], s, info)
      print '(es8.1, 2i12, es12.2, a14)', apart(i), full%rank, start%rank, s%phi, status_name(result%status)
   end do
end program shapes
