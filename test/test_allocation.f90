!> Nothing is allocated inside a step: several times the steps, the same number of heap allocations.
module test_allocation
   use, intrinsic :: iso_fortran_env, only: int64
   use allocation_counter, only: allocations, counts_matter
   use automatic_systems, only: borrowed_t, without_derivatives
   use beams, only: hung_beam
   use squeezer, only: new_squeezer, squeezer_start
   use systems, only: new_compound, new_coupler, new_particle, sleigh
   use taut, only: constrained_ode_t, error_t, integration_options_t, integration_result_t, integrator_t, &
                   mechanical_system_t, method_names, method_t, state_t, wp
   use taut_constrained_method_choose, only: new_constrained_ode
   use taut_constrained_stepper_choose, only: choose_constrained_stepper
   use taut_linalg_csr, only: csr_t
   use taut_linalg_normal_solver, only: normal_solver_t
   use taut_linalg_normal_solver_choose, only: choose_solver, solver_names
   use taut_model_chain, only: chain_t, new_chain
   use taut_model_pendulum, only: new_pendulum, pendulum_t
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_model_beam, only: beam_t
   use taut_case_mechanism, only: read_mechanism
   use taut_case_namelist_file, only: namelist_file_t
   use taut_case_settings, only: settings_t
   use taut_model_mechanism, only: mechanism_t
   use taut_model_mechanism_report, only: mechanism_report_t
   use taut_model_modal_body, only: modal_body_t, new_modal_body
   use taut_model_rigid_bodies, only: new_rigid_bodies, rigid_bodies_t, rigid_body_t, spherical_joint_t
   use taut_ode_stepper, only: stepper_t
   use test_normal_solver, only: factorize, rows_of
   use testing, only: check, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_allocation

contains

   !> All tests of this module.
   function collect_allocation() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('the counter counts', counter_counts), &
               new_test('no method allocates inside a step', methods_do_not_allocate), &
               new_test('no solver allocates inside a step', solvers_do_not_allocate), &
               new_test('no refinement allocates', refinements_do_not_allocate), &
               new_test('no kind of system allocates inside a step', systems_do_not_allocate), &
               new_test('no part of a mechanism allocates', mechanisms_do_not_allocate), &
               new_test('no rigid or modal body allocates', bodies_do_not_allocate), &
               new_test('no system without derivatives allocates', automatic_systems_do_not_allocate)]
   end function collect_allocation

   subroutine counter_counts(failure)
      character(:), allocatable, intent(inout) :: failure
      ! Volatile: else the compiler may do without it.
      real(wp), allocatable, volatile :: some(:)
      integer(int64) :: before

      before = allocations
      allocate (some(1000), source=1.0_wp)
      call check(failure, allocations > before .and. size(some) == 1000, 'an allocation is seen')
   end subroutine counter_counts

   !> Allocations of one integration, and its steps.
   subroutine count_run(model, x, v, method, t_end, counted, steps, failure, integrator_name)
      class(mechanical_system_t), intent(in) :: model
      real(wp), intent(in) :: x(:), v(:), t_end
      type(method_t), intent(in) :: method
      integer(int64), intent(out) :: counted
      integer, intent(out) :: steps
      character(:), allocatable, intent(inout) :: failure
      character(*), intent(in), optional :: integrator_name
      class(constrained_ode_t), allocatable :: ode
      type(integrator_t) :: integrator
      class(stepper_t), allocatable :: stepper
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      type(state_t) :: at
      real(wp), allocatable :: y(:)
      integer(int64) :: before
      real(wp) :: t

      options%max_step = 0.01_wp
      if (present(integrator_name)) options%integrator = integrator_name
      call new_constrained_ode(ode, model, method, error)
      call no_error(failure, error)
      call choose_constrained_stepper(options, method, stepper, error)
      call integrator%init(ode%size(), options, error, stepper)
      call no_error(failure, error)
      allocate (at%x, source=x)
      allocate (at%v, source=v)
      allocate (at%w(0), y(ode%size()))
      call ode%pack(at, y)
      t = 0.0_wp
      before = allocations
      call integrator%run(ode, t, y, t_end, result)
      counted = allocations - before
      steps = result%steps
   end subroutine count_run

   subroutine compare_runs(name, model, x, v, method, failure, integrator_name)
      character(*), intent(in) :: name
      class(mechanical_system_t), intent(in) :: model
      real(wp), intent(in) :: x(:), v(:)
      type(method_t), intent(in) :: method
      character(:), allocatable, intent(inout) :: failure
      character(*), intent(in), optional :: integrator_name
      integer(int64) :: few, many
      integer :: steps_few, steps_many

      call count_run(model, x, v, method, 0.1_wp, few, steps_few, failure, integrator_name)
      call count_run(model, x, v, method, 1.0_wp, many, steps_many, failure, integrator_name)
      call check(failure, steps_many > 2*steps_few, name//': more steps')
      call check(failure, many == few .or. .not. counts_matter, name//': more allocations for more steps')
   end subroutine compare_runs

   subroutine methods_do_not_allocate(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(method_t) :: method
      type(error_t), allocatable :: error
      integer :: i

      call new_pendulum(model, 1.0_wp, 1.0_wp, 9.81_wp, 1, error)
      method%stiffness = 1.0e3_wp
      do i = 1, size(method_names)
         method%name = method_names(i)
         call compare_runs(trim(method%name), model, [1.0_wp, 0.0_wp], [0.0_wp, 0.0_wp], method, failure)
      end do
      method%name = 'present'
      method%stage_projection = 'none'
      call compare_runs('stages not projected', model, [1.0_wp, 0.0_wp], [0.0_wp, 0.0_wp], method, failure)
      method%form = 'force'
      method%weight = 'given'
      call compare_runs('force form', model, [1.0_wp, 0.0_wp], [0.0_wp, 0.0_wp], method, failure)
   end subroutine methods_do_not_allocate

   subroutine solvers_do_not_allocate(failure)
      character(:), allocatable, intent(inout) :: failure
      type(pendulum_t) :: model
      type(chain_t) :: chain
      type(state_t) :: at
      type(method_t) :: method
      type(error_t), allocatable :: error
      integer :: i

      call new_pendulum(model, 1.0_wp, 1.0_wp, 9.81_wp, 3, error)
      call new_chain(chain, 7, 1.0_wp, 1.0_wp, 9.81_wp, error)
      call chain%start(0.0_wp, at)
      do i = 1, size(solver_names)
         method%solver = solver_names(i)
         call compare_runs(trim(solver_names(i)), model, [1.0_wp, 0.0_wp], [0.0_wp, 0.0_wp], method, failure)
         call compare_runs('chain, '//trim(solver_names(i)), chain, at%x, at%v, method, failure)
      end do
   end subroutine solvers_do_not_allocate

   !> Two rows that differ by a thousandth: what S has of them is refined.
   subroutine refinements_do_not_allocate(failure)
      character(:), allocatable, intent(inout) :: failure
      type(csr_t) :: a
      type(block_diagonal_t) :: k
      class(normal_solver_t), allocatable :: onto
      real(wp) :: d(3), lambda(2), r(2)
      integer(int64) :: before
      integer :: i, info

      a = rows_of(reshape([1.0_wp, 1.0_wp, 0.0_wp, 1.0e-3_wp, 1.0_wp, 1.0_wp], [2, 3]))
      call k%init([1, 1, 1])
      do i = 1, size(solver_names)
         call choose_solver(solver_names(i), a, 2, [1, 1, 1], 0.0_wp, onto)
         call factorize(onto, a, k, .true., info)
         if (onto%refinements == 0) cycle
         d(:) = [1.0_wp, 2.0_wp, 3.0_wp]
         before = allocations
         call onto%project(a, [0.0_wp, 0.0_wp], d, r, lambda)
         call check(failure, allocations == before .or. .not. counts_matter, trim(solver_names(i))//': a refinement allocates')
      end do
      call choose_solver('sparse', a, 2, [1, 1, 1], 0.0_wp, onto)
      call factorize(onto, a, k, .true., info)
      call check(failure, onto%refinements > 0, 'there is nothing to refine')
   end subroutine refinements_do_not_allocate

   subroutine automatic_systems_do_not_allocate(failure)
      character(:), allocatable, intent(inout) :: failure
      class(borrowed_t), allocatable :: model
      type(chain_t) :: chain
      type(method_t) :: method
      type(state_t) :: at
      type(error_t), allocatable :: error

      call new_chain(chain, 9, 1.0_wp, 1.0_wp, 9.81_wp, error)
      call chain%start(0.3_wp, at)
      model = without_derivatives(chain)
      call compare_runs('chain', model, at%x, at%v, method, failure)
      call model%find_structure(at)
      call compare_runs('chain of known structure', model, at%x, at%v, method, failure)
      model = without_derivatives(new_squeezer())
      at = squeezer_start()
      call count_short(model, at)
      call model%find_structure(at)
      call count_short(model, at)

   contains

      !> The squeezer takes many steps in a short time.
      subroutine count_short(model, at)
         class(mechanical_system_t), intent(in) :: model
         type(state_t), intent(in) :: at
         integer(int64) :: few, many
         integer :: steps_few, steps_many

         call count_run(model, at%x, at%v, method, 0.002_wp, few, steps_few, failure)
         call count_run(model, at%x, at%v, method, 0.02_wp, many, steps_many, failure)
         call check(failure, steps_many > 3*steps_few .and. (many == few .or. .not. counts_matter), &
                    'squeezer: more allocations for more steps')
      end subroutine count_short

   end subroutine automatic_systems_do_not_allocate

   subroutine systems_do_not_allocate(failure)
      character(:), allocatable, intent(inout) :: failure
      type(method_t) :: method
      type(beam_t) :: beam
      real(wp), allocatable :: v(:)

      call compare_runs('coupler', new_coupler(3), [0.6_wp, -0.8_wp, 0.0_wp], [0.0_wp, 0.0_wp, 0.0_wp], method, failure)
      call compare_runs('compound pendulum', new_compound(), [0.3_wp, -0.4_wp, 0.8_wp, 0.6_wp], [0.0_wp, 0.0_wp, 0.0_wp], &
                        method, failure)
      call compare_runs('sleigh', new_particle(sleigh), [0.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, 1.0_wp], method, failure)
      beam = hung_beam()
      allocate (v(beam%n), source=0.0_wp)
      call compare_runs('beam', beam, beam%x_reference, v, method, failure)
      call compare_runs('compound pendulum, implicit', new_compound(), [0.3_wp, -0.4_wp, 0.8_wp, 0.6_wp], &
                        [0.0_wp, 0.0_wp, 0.0_wp], method, failure, 'radau')
      call compare_runs('sleigh, implicit', new_particle(sleigh), [0.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, 1.0_wp], method, &
                        failure, 'radau')
      call compare_runs('beam, implicit', beam, beam%x_reference, v, method, failure, 'radau')
      call compare_runs('beam, generalized-alpha', beam, beam%x_reference, v, method, failure, 'generalized-alpha')
   end subroutine systems_do_not_allocate

   !> What a mechanism computes inside a step, alone: the linear algebra of larger ones allocates by itself in some libraries.
   subroutine mechanisms_do_not_allocate(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=20), parameter :: names(6) = [character(len=20) :: 'governor', 'andrews', 'rolling_disc', 'slider_crank', &
                                                  'spatial_slider_crank', 'heavy_top']
      type(namelist_file_t) :: file
      type(mechanism_t) :: model
      type(mechanism_report_t) :: report
      type(settings_t) :: settings
      type(state_t) :: at
      type(error_t), allocatable :: error
      integer :: i

      do i = 1, size(names)
         call file%load('cases/mechanism/'//trim(names(i))//'.nml', error)
         if (.not. allocated(error)) call read_mechanism(file, model, at, settings, report, error)
         call no_error(failure, error)
         if (allocated(failure)) return
         call count_calls(trim(names(i)), model, at, failure)
      end do
   end subroutine mechanisms_do_not_allocate

   !> Two bodies off their centers of mass on spherical joints; a body with two shapes on a link.
   subroutine bodies_do_not_allocate(failure)
      character(:), allocatable, intent(inout) :: failure
      type(rigid_bodies_t) :: rigid
      type(modal_body_t) :: modal
      type(rigid_body_t) :: body
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp) :: inertia(3, 3, 3), position(3, 3), rotation(3, 2, 3), shape(3, 2, 3)
      integer :: i

      body%m = 2.0_wp
      body%s = [0.1_wp, 0.2_wp, -0.1_wp]
      body%j = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.2_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.9_wp], [3, 3])
      call new_rigid_bodies(rigid, [body, body], [spherical_joint_t(1, 0), spherical_joint_t(2, 1, [0.0_wp, 0.0_wp, 1.0_wp])], &
                            [0.0_wp, 0.0_wp, -9.81_wp], error)
      call no_error(failure, error)
      at%x = [([0.1_wp, 0.2_wp, 0.3_wp, 0.8_wp, 0.6_wp, 0.0_wp, 0.0_wp], i=1, 2)]
      at%v = [(0.1_wp*i, i=1, 12)]
      allocate (at%w(0))
      call count_calls('rigid bodies', rigid, at, failure)

      do i = 1, 3
         position(:, i) = [real(i, wp), 0.0_wp, 0.1_wp]
         inertia(:, :, i) = 0.01_wp*body%j
         shape(:, :, i) = reshape(0.1_wp*[1.0_wp, 0.3_wp, 0.2_wp, -0.2_wp, 0.5_wp, 0.7_wp], [3, 2])*i
         rotation(:, :, i) = 0.5_wp*shape(:, :, i)
      end do
      call new_modal_body(modal, position, [0.3_wp, 0.4_wp, 0.5_wp], inertia, shape, rotation, &
                          reshape([10.0_wp, 1.0_wp, 1.0_wp, 20.0_wp], [2, 2]), error)
      call no_error(failure, error)
      call modal%link(1, [0.0_wp, 0.0_wp, 1.0_wp], 1.0_wp, error)
      at%x = [0.1_wp, 0.2_wp, 0.3_wp, 0.8_wp, 0.6_wp, 0.0_wp, 0.0_wp, 0.01_wp, 0.02_wp]
      at%v = [(0.1_wp*i, i=1, 8)]
      call count_calls('modal body', modal, at, failure)
   end subroutine bodies_do_not_allocate

   !> Calls everything that is called inside a step.
   subroutine count_calls(name, model, start, failure)
      character(*), intent(in) :: name
      class(mechanical_system_t), intent(in) :: model
      type(state_t), intent(in) :: start
      character(:), allocatable, intent(inout) :: failure
      type(block_diagonal_t) :: m
      type(state_t) :: at
      real(wp), allocatable :: a(:, :), b(:), entries(:), f(:), x(:)
      integer, allocatable :: column(:), first(:)
      character(len=16), parameter :: parts(9) = [character(len=16) :: 'mass', 'force', 'constraint', 'jacobian', &
                                                  'velocity_rhs', 'acceleration_rhs', 'x_rate', 'v_of_x_rate', 'displace']
      integer(int64) :: before(10)
      integer :: i

      at = start
      call m%init(model%mass_blocks)
      call model%pattern(first, column)
      i = 0
      if (allocated(column)) i = size(column)
      allocate (a(model%c, model%n), b(model%c), entries(i), f(model%n), x(model%n_x), source=0.0_wp)
      before(1) = allocations
      if (.not. model%constant_mass) call model%mass(at, m)
      before(2) = allocations
      call model%force(at, f)
      before(3) = allocations
      call model%constraint(at, b(:model%n_phi))
      before(4) = allocations
      call model%jacobian(at, a)
      if (allocated(column)) call model%jacobian_entries(at, entries)
      before(5) = allocations
      call model%velocity_rhs(at, b)
      before(6) = allocations
      call model%acceleration_rhs(at, b)
      before(7) = allocations
      call model%x_rate(at, at%v, x)
      before(8) = allocations
      call model%v_of_x_rate(at, x, f)
      before(9) = allocations
      call model%displace(f, at%x)
      call model%normalize(at%x)
      before(10) = allocations
      do i = 1, size(parts)
         call check(failure, before(i + 1) == before(i) .or. .not. counts_matter, name//' allocates in '//trim(parts(i)))
      end do
   end subroutine count_calls

end module test_allocation
