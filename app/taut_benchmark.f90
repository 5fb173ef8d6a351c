!> Cost of one step of the pendulum, by method; `scripts/benchmark` sets it beside SciPy's.
!!
!! Prints CSV: method, rtol, steps, right-hand sides per step, microseconds per accepted step (best of the repetitions),
!! position error at the end against the closed form of the period.
program taut_benchmark
   use, intrinsic :: iso_fortran_env, only: error_unit, int64, output_unit
   use taut, only: wp, constrained_ode_t, error_t, integration_options_t, integration_result_t, integrator_t, method_t
   use taut_model_pendulum, only: pendulum_t, new_pendulum
   implicit none (type, external)
   integer, parameter :: repetitions = 30
   character(len=24), parameter :: names(4) = [character(len=24) :: 'present', 'present-stage-none', 'baseline', 'baumgarte']
   real(wp), parameter :: tolerances(2) = [1.0e-3_wp, 1.0e-9_wp]
   type(pendulum_t) :: model
   type(error_t), allocatable :: error
   integer :: i, j

   call new_pendulum(model, 1.0_wp, 1.0_wp, 9.81_wp, 1, error)
   write (output_unit, '(a)') 'method,rtol,steps,rhs_per_step,microseconds_per_step,milliseconds,x_end,z_end'
   do j = 1, size(tolerances)
      do i = 1, size(names)
         call measure(trim(names(i)), tolerances(j))
         if (.not. allocated(error)) cycle
         write (error_unit, '(2a)') 'taut_benchmark: ', error%line()
         stop 1, quiet=.true.
      end do
   end do

contains

   !> Integrates 10 s over and over and prints the best time.
   subroutine measure(name, rtol)
      character(*), intent(in) :: name
      real(wp), intent(in) :: rtol
      type(method_t) :: method
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(constrained_ode_t) :: ode
      type(integrator_t) :: integrator
      real(wp) :: best, t, y(4)
      integer(int64) :: after, before, rate
      integer :: k

      method%name = name
      if (name == 'present-stage-none') then
         method%name = 'present'
         method%stage_projection = 'none'
      end if
      options%rtol = rtol
      options%atol = min(1.0e-6_wp, rtol)
      options%max_step = 0.1_wp
      options%first_step = 0.01_wp
      call ode%init(model, method, error)
      if (.not. allocated(error)) call integrator%init(4, options, error)
      if (allocated(error)) return
      best = huge(best)
      do k = 1, repetitions
         t = 0.0_wp
         y = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
         call system_clock(before, rate)
         call integrator%run(ode, t, y, 10.0_wp, result)
         call system_clock(after)
         best = min(best, real(after - before, wp)/real(rate, wp))
      end do
      write (output_unit, '(a, ",", es8.1, ",", i0, ",", f0.2, ",", f0.4, ",", f0.5, 2(",", es23.16))') name, rtol, result%steps, &
         real(result%rhs_evaluations, wp)/result%steps, 1.0e6_wp*best/result%steps, 1.0e3_wp*best, y(1:2)
   end subroutine measure

end program taut_benchmark
