!> Two rods, hinged to the ground and to each other, by the builder of mechanisms: released from the horizontal.
program double_pendulum
   use taut
   implicit none (type, external)
   type(mechanism_builder_t) :: builder
   type(mechanism_t) :: mechanism
   type(state_t) :: at
   type(integration_result_t) :: result
   type(error_t), allocatable :: error
   real(wp), parameter :: o(3) = 0.0_wp, x(3) = [1.0_wp, 0.0_wp, 0.0_wp], y(3) = [0.0_wp, 1.0_wp, 0.0_wp]

   builder%gravity = [0.0_wp, 0.0_wp, -9.81_wp]
   call builder%add_body('upper', mass=1.0_wp, shape='rod', from=o, to=x)
   call builder%add_body('lower', mass=1.0_wp, shape='rod', from=x, to=2.0_wp*x)
   call builder%add_joint('A', 'revolute', 'ground', 'upper', point=o, axis=y)
   call builder%add_joint('B', 'revolute', 'upper', 'lower', point=x, axis=y)
   call builder%complete(mechanism, at, error)
   if (.not. allocated(error)) call simulate(mechanism, at, 1.0_wp, result, error)
   if (allocated(error)) error stop error%line()
   print '(a, i0, a, es9.2, a)', 'steps: ', result%steps, ', energy, 0 at the start: ', mechanism%energy(at), ' J'
   print '(a, 2f12.8, a)', 'center of the lower rod:', at%x(8), at%x(10), ' m'
end program double_pendulum
