!> A simulation that is stored and restored at every few steps is, bit for bit, the one that was left alone.
module test_restart
   use, intrinsic :: iso_fortran_env, only: int64
   use systems, only: jumping_load, new_compound, new_coupler, new_particle, sleigh
   use taut, only: archive_t, error_t, integration_options_t, mechanical_system_t, method_names, method_t, pause_t, &
                   simulation_t, state_t, status_interrupted, tabulated_system_t, trajectory_t, wp
   use taut_constrained_model_events, only: model_events_t
   use taut_error, only: to_text
   use taut_model_n_four_bar, only: n_four_bar_t, new_n_four_bar
   use taut_model_pendulum, only: new_pendulum, pendulum_t
   use taut_model_swing, only: new_swing_beam, swing_beam_t, swing_data_t
   use testing, only: check, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_restart

   !> Pauses every few questions.
   type, extends(pause_t) :: often_t
      integer :: every = 3, asked = 0
   contains
      procedure :: wanted
   end type often_t

contains

   !> All tests of this module.
   function collect_restart() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('every method continues bit for bit', every_method), &
               new_test('every step control and output continues', every_control), &
               new_test('singular positions are passed as without a pause', singular_positions), &
               new_test('breakpoints, other states, quaternions and redundancy continue', systems_continue), &
               new_test('the swing and its events continue', swing_continues), &
               new_test('a backward integration continues', backward), &
               new_test('an archive of something else is refused', foreign), &
               new_test('an archive that ends too early is refused', truncated)]
   end function collect_restart

   logical function wanted(self)
      class(often_t), intent(inout) :: self

      self%asked = self%asked + 1
      wanted = mod(self%asked, self%every) == 0
   end function wanted

   !> Whether two numbers have the same bits.
   elemental logical function identical(a, b)
      real(wp), intent(in) :: a, b

      identical = transfer(a, 1_int64) == transfer(b, 1_int64)
   end function identical

   !> Runs a case twice, once with its memory thrown away and restored at every pause, and compares.
   subroutine compare(name, model, at, t_end, method, options, failure)
      character(*), intent(in) :: name
      class(mechanical_system_t), intent(in) :: model
      type(state_t), intent(in) :: at
      real(wp), intent(in) :: t_end
      type(method_t), intent(in) :: method
      type(integration_options_t), intent(in) :: options
      character(:), allocatable, intent(inout) :: failure
      type(simulation_t) :: whole
      type(simulation_t), allocatable :: piece, next
      type(trajectory_t) :: one, other
      type(model_events_t), allocatable :: events
      type(archive_t) :: archive
      type(often_t) :: pause
      type(error_t), allocatable :: error
      integer :: pauses
      logical :: same

      select type (model)
      class is (tabulated_system_t)
         if (model%n_events > 0) then
            allocate (events)
            call events%init(model)
         end if
      end select
      call whole%init(model, error, method, options)
      if (.not. allocated(error)) call whole%run(at, t_end, error, one, events)
      call no_error(failure, error)
      allocate (piece)
      call piece%init(model, error, method, options)
      if (.not. allocated(error)) call piece%run(at, t_end, error, other, events, pause=pause)
      call no_error(failure, error)
      pauses = 0
      do while (piece%result%status == status_interrupted)
         pauses = pauses + 1
         call archive%clear()
         call piece%serialize(archive)
         allocate (next)
         call next%init(model, error, method, options)
         call archive%rewind()
         call next%serialize(archive)
         call no_error(failure, archive%error)
         call check(failure, archive%at_end(), name//': all of the archive is read')
         call move_alloc(next, piece)
         call piece%resume(other, events, pause)
         if (allocated(failure)) return
      end do
      call check(failure, pauses > 0, name//': there were pauses')
      call check(failure, piece%result%status == whole%result%status, name//': same end')
      call check(failure, one%points == other%points .and. one%points > 1, name//': same number of points')
      if (allocated(failure)) return
      same = all(identical(one%t(:one%points), other%t(:one%points))) .and. &
             all(identical(one%y(:, :one%points), other%y(:, :one%points))) .and. &
             all(identical(whole%at%x, piece%at%x)) .and. all(identical(whole%at%v, piece%at%v)) .and. &
             identical(whole%at%t, piece%at%t)
      call check(failure, same, name//': same points, bit for bit')
      call check(failure, whole%result%steps == piece%result%steps .and. &
                 whole%result%rejected == piece%result%rejected .and. &
                 whole%result%rhs_evaluations == piece%result%rhs_evaluations .and. &
                 whole%ode%projector%newton%iterations == piece%ode%projector%newton%iterations .and. &
                 size(whole%result%events) == size(piece%result%events), name//': same counts')
      if (allocated(failure)) return
      if (size(whole%result%events) > 0) &
         call check(failure, all(identical(whole%result%events%t, piece%result%events%t)), name//': same events')
   end subroutine compare

   subroutine pendulum(model, at, copies)
      type(pendulum_t), intent(out) :: model
      type(state_t), intent(out) :: at
      integer, intent(in) :: copies
      type(error_t), allocatable :: error

      call new_pendulum(model, 1.0_wp, 1.0_wp, 9.81_wp, copies, error)
      at%x = [1.0_wp, 0.0_wp]
      at%v = [0.0_wp, 0.0_wp]
      allocate (at%w(0))
   end subroutine pendulum

   subroutine every_method(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(state_t) :: at
      type(method_t) :: method
      type(integration_options_t) :: implicit, options
      integer :: i

      call pendulum(model, at, 1)
      implicit%integrator = 'radau'
      do i = 1, size(method_names)
         method = method_t(name=method_names(i))
         method%stiffness = 1.0e4_wp
         call compare(trim(method%name), model, at, 1.0_wp, method, options, failure)
         call compare(trim(method%name)//', implicit', model, at, 1.0_wp, method, implicit, failure)
      end do
      method = method_t(stage_projection='none')
      call compare('stages without projection', model, at, 1.0_wp, method, options, failure)
      method = method_t(state_projection='none', form='force', weight='mass', solver='factor')
      call compare('other options', model, at, 1.0_wp, method, options, failure)
      method = method_t(name='minimal-coordinates', independent='partitioning')
      call compare('partitioning', model, at, 2.0_wp, method, options, failure)
      method = method_t(name='minimal-coordinates', stage_projection='none', state_projection='none')
      call compare('positions that drift', model, at, 1.0_wp, method, options, failure)
   end subroutine every_method

   subroutine every_control(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(state_t) :: at
      type(integration_options_t) :: options

      call pendulum(model, at, 1)
      options%output_dt = 0.013_wp
      call compare('output between the steps', model, at, 1.0_wp, method_t(), options, failure)
      options%integrator = 'dop853'
      call compare('order 8', model, at, 3.0_wp, method_t(), options, failure)
      options%integrator = 'dopri5'
      options%step_control = 'odepkg-2009'
      call compare('the error test of 2009', model, at, 1.0_wp, method_t(), options, failure)
      options%step_control = 'fixed'
      options%first_step = 0.02_wp
      call compare('fixed steps', model, at, 1.0_wp, method_t(), options, failure)
      options = integration_options_t(rtol=1.0e-2_wp, atol=1.0e-2_wp, projection_limit=1.0e-12_wp)
      call compare('many rejected steps', model, at, 3.0_wp, method_t(), options, failure)
   end subroutine every_control

   subroutine systems_continue(failure)
      character(:), allocatable, intent(inout) :: failure
      type(integration_options_t) :: options
      type(pendulum_t) :: model
      type(state_t) :: at
      type(error_t), allocatable :: error

      call pendulum(model, at, 3)
      call compare('redundant', model, at, 1.0_wp, method_t(), options, failure)
      call new_pendulum(model, 1.0_wp, 1.0e-6_wp, 9.81e-6_wp, 3, error)
      call no_error(failure, error)
      at%x = [1.0e-6_wp, 0.0_wp]
      options%atol = 1.0e-12_wp
      call compare('small', model, at, 1.0_wp, method_t(), options, failure)
      options = integration_options_t(integrator='radau', atol=1.0e-12_wp)
      call compare('small, implicit', model, at, 1.0_wp, method_t(), options, failure)
      options = integration_options_t()
      at%x = [1.0_wp, 0.0_wp]
      at%v = [0.0_wp, 1.0_wp]
      call compare('a load that jumps', new_particle(jumping_load), at, 2.0_wp, method_t(), options, failure)
      at%x = [0.0_wp, 0.0_wp, 0.3_wp]
      at%v = [1.0_wp, 0.5_wp, 0.4_wp]
      call compare('sleigh', new_particle(sleigh), at, 2.0_wp, method_t(), options, failure)
      at%x = [0.6_wp, -0.8_wp, 0.8_wp, 0.6_wp]
      at%v = [0.0_wp, 0.0_wp, 0.0_wp]
      call compare('quaternion', new_compound(), at, 1.0_wp, method_t(), options, failure)
      at%x = [0.6_wp, -0.8_wp, 0.0_wp]
      at%v = [0.0_wp, 0.0_wp, 0.0_wp]
      call compare('coupler', new_coupler(3), at, 1.0_wp, method_t(), options, failure)
      options%integrator = 'radau'
      call compare('coupler, implicit', new_coupler(3), at, 1.0_wp, method_t(), options, failure)
      options%integrator = 'generalized-alpha'
      call compare('coupler, generalized-alpha', new_coupler(3), at, 1.0_wp, method_t(), options, failure)
   end subroutine systems_continue

   !> Rows are held near the flat positions of a four-bar, and passed over.
   subroutine singular_positions(failure)
      character(:), allocatable, intent(inout) :: failure
      character(6), parameter :: integrators(*) = ['dopri5', 'dop853', 'radau ']
      integer, parameter :: digits(*) = [6, 9, 12]
      type(n_four_bar_t) :: model
      type(state_t) :: at
      type(error_t), allocatable :: error
      integer :: i, j

      call new_n_four_bar(model, 2, 1.0_wp, 1.0_wp, 9.81_wp, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      call model%start(0.0_wp, 1.0_wp, at)
      do i = 1, size(integrators)
         do j = 1, size(digits)
            call compare(trim(integrators(i))//', tolerance 1e-'//to_text(digits(j)), model, at, 3.0_wp, method_t(), &
                         integration_options_t(integrator=integrators(i), rtol=10.0_wp**(-digits(j)), &
                                               atol=10.0_wp**(-digits(j) - 3)), failure)
         end do
      end do
   end subroutine singular_positions

   subroutine swing_continues(failure)
      character(:), allocatable, intent(inout) :: failure
      type(swing_beam_t) :: swing
      type(swing_data_t) :: data
      type(integration_options_t) :: options
      type(error_t), allocatable :: error

      call new_swing_beam(swing, data, error)
      call no_error(failure, error)
      options = integration_options_t(rtol=1.0e-3_wp, atol=1.0e-6_wp, output_dt=5.0e-4_wp)
      call compare('swing', swing, swing%reference_state(), 2.0e-3_wp, method_t(), options, failure)
      options%integrator = 'radau'
      call compare('swing, implicit', swing, swing%reference_state(), 0.15_wp, method_t(), options, failure)
      options%integrator = 'generalized-alpha'
      call compare('swing, generalized-alpha', swing, swing%reference_state(), 0.15_wp, method_t(), options, failure)
   end subroutine swing_continues

   subroutine backward(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(state_t) :: at

      call pendulum(model, at, 1)
      at%t = 2.0_wp
      call compare('backward', model, at, 1.0_wp, method_t(), integration_options_t(output_dt=0.1_wp), failure)
   end subroutine backward

   !> The archive of a run of the pendulum that pauses at once.
   subroutine archive_of_pendulum(archive, simulation, failure)
      type(archive_t), intent(inout) :: archive
      type(simulation_t), intent(inout) :: simulation
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(state_t) :: at
      type(error_t), allocatable :: error
      type(often_t) :: pause

      call pendulum(model, at, 1)
      call simulation%init(model, error)
      call simulation%run(at, 1.0_wp, error, pause=pause)
      call no_error(failure, error)
      call archive%clear()
      call simulation%serialize(archive)
      call archive%rewind()
   end subroutine archive_of_pendulum

   subroutine foreign(failure)
      character(:), allocatable, intent(inout) :: failure
      type(archive_t) :: archive
      type(simulation_t) :: simulation
      type(error_t), allocatable :: error

      call archive_of_pendulum(archive, simulation, failure)
      call simulation%init(new_compound(), error)
      call no_error(failure, error)
      call simulation%serialize(archive)
      call check(failure, allocated(archive%error), 'another state is refused')
      if (allocated(failure)) return
      call check(failure, index(archive%error%line(), '"mu before projection" has another size') > 0, &
                 'and the entry named: '//archive%error%line())
   end subroutine foreign

   subroutine truncated(failure)
      character(:), allocatable, intent(inout) :: failure
      type(archive_t) :: archive
      type(simulation_t) :: simulation
      integer :: i

      call archive_of_pendulum(archive, simulation, failure)
      do i = 1, 50
         archive%length = archive%length - 7
         call archive%rewind()
         call simulation%serialize(archive)
         call check(failure, allocated(archive%error), 'a short archive is refused')
      end do
   end subroutine truncated

end module test_restart
