!> One entrant of `scripts/benchmark`: integrates a problem over and over and tells what one run costs.
!!
!!     taut_benchmark PROBLEM SIZE METHOD RTOL ATOL MAX_STEP T_END SECONDS
!!
!! METHOD is a name of `method_names`; `-stage-none` behind it turns the projection of stages off, `-whole` has all coordinates
!! of a system computed that has a smaller one, `-phi` leaves of the system phi alone, and the name of an integrator behind that
!! takes it. MAX_STEP [s] of 0 is none. Runs are repeated until SECONDS of processor time are spent; with 0 there is one. Printed
!! are a line of names, one of numbers (steps, right-hand sides, Jacobians, processor time of the fastest run [s]),
!! and the last state {x; v}, a number a line.
program taut_benchmark
   use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
   use taut, only: wp, constrained_ode_t, error_t, integration_options_t, integration_result_t, integrator_t, &
                   mechanical_system_t, mechanism_t, method_t, raise, read_mechanism, state_t, status_name, status_reached_end
   use car_axis_system, only: car_axis_start, car_axis_t
   use phi_alone_systems, only: phi_alone
   use taut_constrained_method_choose, only: new_constrained_ode
   use taut_constrained_stepper_choose, only: choose_constrained_stepper, integrator_names
   use taut_model_chain, only: chain_t, new_chain
   use taut_model_mechanism_builder, only: mechanism_builder_t
   use taut_model_n_four_bar, only: n_four_bar_t, new_n_four_bar
   use taut_model_pendulum, only: new_pendulum, pendulum_t
   use taut_model_swing, only: new_swing_beam, swing_beam_t, swing_data_t
   use taut_ode_stepper, only: stepper_t
   implicit none (type, external)
   !> A measured batch of runs takes at least this long [s]: clocks are coarse.
   real(wp), parameter :: shortest_batch = 1.0e-3_wp
   real(wp), parameter :: gravity = 9.81_wp
   class(mechanical_system_t), allocatable :: model
   type(error_t), allocatable :: error
   type(state_t) :: start

   if (command_argument_count() /= 8) then
      call raise(error, 'command line', 'there are not eight arguments', &
                 'give PROBLEM SIZE METHOD RTOL ATOL MAX_STEP T_END SECONDS')
   end if
   if (.not. allocated(error)) call new_problem(argument(1), nint(number(2)), model, start, error)
   if (.not. allocated(error)) call measure(argument(3), number(4), number(5), number(6), number(7), number(8), error)
   if (allocated(error)) then
      write (error_unit, '(2a)') 'taut_benchmark: ', error%line()
      stop 1, quiet=.true.
   end if

contains

   !> The problem and its start.
   subroutine new_problem(name, size, model, start, error)
      character(*), intent(in) :: name
      integer, intent(in) :: size
      class(mechanical_system_t), allocatable, intent(out) :: model
      type(state_t), intent(out) :: start
      type(error_t), allocatable, intent(inout) :: error
      type(chain_t), allocatable :: chain
      type(n_four_bar_t), allocatable :: loops
      type(pendulum_t), allocatable :: pendulum
      type(mechanism_builder_t) :: builder
      type(car_axis_t), allocatable :: car_axis
      type(mechanism_t), allocatable :: mechanism, spring
      type(swing_beam_t), allocatable :: swing

      select case (name)
      case ('pendulum')
         allocate (pendulum)
         call new_pendulum(pendulum, 1.0_wp, 1.0_wp, gravity, 1, error)
         start%x = [1.0_wp, 0.0_wp]
         start%v = [0.0_wp, 0.0_wp]
         call move_alloc(pendulum, model)
      case ('chain')
         allocate (chain)
         call new_chain(chain, size, 1.0_wp, 1.0_wp, gravity, error)
         if (.not. allocated(error)) call chain%start(0.0_wp, start)
         call move_alloc(chain, model)
      case ('four-bar')
         allocate (loops)
         call new_n_four_bar(loops, size, 1.0_wp, 1.0_wp, gravity, error)
         if (.not. allocated(error)) call loops%start(0.0_wp, 1.0_wp, start)
         call move_alloc(loops, model)
      case ('spring')
         ! A mass of 1 kg at {1, 0} on a spring from the origin that is relaxed there.
         allocate (spring)
         builder%planar = .true.
         builder%gravity = [0.0_wp, -gravity, 0.0_wp]
         call builder%add_body('mass', mass=1.0_wp, inertia=[1.0_wp], position=[1.0_wp, 0.0_wp, 0.0_wp])
         call builder%add_spring('ground', 'mass', point_1=[0.0_wp, 0.0_wp, 0.0_wp], stiffness=10.0_wp**size, free_length=1.0_wp)
         call builder%complete(spring, start, error)
         call move_alloc(spring, model)
      case ('swing')
         allocate (swing)
         call new_swing_beam(swing, swing_data_t(elements=size), error)
         if (.not. allocated(error)) start = swing%reference_state()
         call move_alloc(swing, model)
      case ('car-axis')
         allocate (car_axis)
         call car_axis_start(car_axis, start)
         call move_alloc(car_axis, model)
      case default
         ! The other names are those of cases, with the tolerances and methods of the command line.
         allocate (mechanism)
         call read_mechanism('cases/mechanism/'//name//'.nml', mechanism, start, error)
         call move_alloc(mechanism, model)
      end select
   end subroutine new_problem

   !> Integrates over and over, and prints the best time and the last state.
   subroutine measure(method_name, rtol, atol, max_step, t_end, seconds, error)
      character(*), intent(in) :: method_name
      real(wp), intent(in) :: rtol, atol, max_step, t_end, seconds
      type(error_t), allocatable, intent(inout) :: error
      type(method_t) :: method
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      class(constrained_ode_t), allocatable :: ode
      type(integrator_t) :: integrator
      class(stepper_t), allocatable :: stepper
      real(wp), allocatable :: y(:), y_start(:)
      real(wp) :: batch_end, batch_start, best, spent, t
      integer :: i, k, repetitions

      method%name = method_name
      do k = 1, size(integrator_names)
         i = index(method%name, '-'//trim(integrator_names(k)))
         if (i == 0) cycle
         method%name = method%name(:i - 1)
         options%integrator = integrator_names(k)
      end do
      i = index(method%name, '-phi')
      if (i > 0) then
         method%name = method%name(:i - 1)
         call phi_alone(start, model, error)
         if (allocated(error)) return
      end if
      i = index(method%name, '-whole')
      if (i > 0) then
         method%name = method%name(:i - 1)
         method%reduce = .false.
      end if
      i = index(method%name, '-stage-none')
      if (i > 0) then
         method%name = method%name(:i - 1)
         method%stage_projection = 'none'
      end if
      options%rtol = rtol
      options%atol = atol
      if (max_step > 0.0_wp) options%max_step = max_step
      call choose_constrained_stepper(options, method, stepper, error)
      if (.not. allocated(error)) call new_constrained_ode(ode, model, method, error, stepper)
      if (.not. allocated(error)) call integrator%init(ode%size(), options, error, stepper)
      if (allocated(error)) return
      allocate (y(ode%size()), y_start(ode%size()))
      call ode%pack(start, y_start)

      ! The first run warms up, and says how many make a batch.
      repetitions = 1
      spent = 0.0_wp
      best = huge(best)
      do
         call cpu_time(batch_start)
         do k = 1, repetitions
            t = 0.0_wp
            y(:) = y_start
            call integrator%run(ode, t, y, t_end, result)
            if (result%status /= status_reached_end) exit
         end do
         call cpu_time(batch_end)
         if (result%status /= status_reached_end) then
            if (allocated(result%error)) call move_alloc(result%error, error)
            call raise(error, 'benchmark', 'the run ended as '//status_name(result%status), 'try a stricter tolerance')
            return
         end if
         best = min(best, (batch_end - batch_start)/repetitions)
         spent = spent + (batch_end - batch_start)
         if (spent >= seconds) exit
         repetitions = max(1, min(10000, ceiling(shortest_batch/max(best, 1.0e-7_wp))))
      end do

      write (output_unit, '(a)') 'steps,rhs,jacobians,seconds'
      write (output_unit, '(3(i0, ","), es23.16)') result%steps, result%rhs_evaluations, result%jacobians, best
      write (output_unit, '(es24.16e3)') y
   end subroutine measure

   !> The i-th argument of the command line.
   function argument(i)
      integer, intent(in) :: i
      character(:), allocatable :: argument
      integer :: length

      call get_command_argument(i, length=length)
      allocate (character(length) :: argument)
      if (length > 0) call get_command_argument(i, argument)
   end function argument

   !> The i-th argument as a number.
   function number(i)
      integer, intent(in) :: i
      real(wp) :: number
      character(:), allocatable :: text
      integer :: status

      text = argument(i)
      number = 0.0_wp
      read (text, *, iostat=status) number
      if (status /= 0 .and. .not. allocated(error)) &
         call raise(error, 'command line', '"'//text//'" is not a number', 'see the head of its source')
   end function number

end program taut_benchmark
