program t
   use taut
   use taut_model_pendulum
   implicit none
   type(pendulum_t) :: p
   type(error_t), allocatable :: error
   type(state_t) :: at
   type(integration_result_t) :: r
   type(integration_options_t) :: o
   type(method_t) :: m
   type(constrained_ode_t) :: ode
   type(sample_t) :: s
   integer :: i, j, info
   character(24) :: names(7), sp(7)
   real(wp), allocatable :: y(:)
   call new_pendulum(p, 1.0_wp, 1.0_wp, 9.81_wp, 1, error)
   o%step_control = 'odepkg-2009'; o%max_step=0.1_wp; o%first_step=0.01_wp
   names = [character(24) :: 'baseline','baumgarte','present','present','present','braun-goldfarb','coordinate-projection']
   sp='none'; sp(4)='position';sp(5)='position-velocity'
   do j=1,3
   if (j==3) then; o%step_control='standard'; o%max_step=0.05_wp; end if
   do i=1,7
     m%name=names(i); m%state_projection=sp(i)
     o%rtol=merge(1e-9_wp,1e-3_wp,j==2); o%atol=merge(1e-9_wp,1e-6_wp,j==2)
     at%t=0; at%x=[1.0_wp,0.0_wp]; at%v=[0.0_wp,0.0_wp]
     call simulate(p,at,10.0_wp,r,error,m,o,ode=ode)
     if (allocated(error)) print *, error%line()
     allocate(y(ode%size())); call ode%pack(at,y); call ode%sample(10.0_wp,y,s,info)
     print '(a,1x,a,1x,a,3i7,i8,*(es12.3))', names(i),sp(i)(1:18),status_name(r%status),r%steps,r%rejected, &
 r%rhs_evaluations,ode%projector%iterations, &
  s%phi,s%phidot,s%phi_raw,s%energy
     deallocate(y)
   end do
   end do
end program
