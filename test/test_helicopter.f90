!> The helicopter blade of Sect. 4.3 against what the paper says.
module test_helicopter
   use, intrinsic :: ieee_arithmetic, only: ieee_negative_inf, ieee_positive_inf, ieee_value
   use taut, only: consistent_start, constrained_ode_t, error_t, finding_t, integration_options_t, integration_result_t, &
                  method_t, quantity_t, sample_t, start_report_t, state_t, verify, wp
   use taut_case_helicopter, only: helicopter_group_t
   use taut_case_model_group, only: model_case_t
   use taut_case_namelist_file, only: namelist_file_t
   use taut_case_settings, only: settings_t
   use taut_constrained_method_choose, only: new_constrained_ode
   use taut_constrained_system_tables, only: tabulated_system_t
   use taut_model_helicopter, only: helicopter_data_t, helicopter_t, new_helicopter
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   use blades, only: fly, paper, sampler_t, strict, tilting
   implicit none (type, external)
   private
   public :: collect_helicopter

   real(wp), parameter :: pi = acos(-1.0_wp)

contains

   !> All tests of this module.
   function collect_helicopter() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('the numbers of Table 3', table_3), &
               new_test('the blade at rest hangs on the vertical link', at_rest), &
               new_test('the model passes its own check', model_is_consistent), &
               new_test('steps of the paper, constraint', steps_constraint), &
               new_test('steps of the paper, stiffness', steps_stiffness), &
               new_test('a stiffer control system does not converge', stiffer_control), &
               new_test('an implicit integrator makes a stiff control system a constraint', implicit_control), &
               new_test('energy without damping and load', energy_is_kept), &
               new_test('the stiffness acts where the constraint does not', stiffness_or_constraint), &
               new_test('a start that is not enforced stays', start_stays), &
               new_test('data that make no sense', bad_data), &
               new_test('the shipped case is the paper''s', shipped_case)]
   end function collect_helicopter

   subroutine table_3(failure)
      character(:), allocatable, intent(inout) :: failure
      type(helicopter_data_t) :: data
      type(helicopter_t) :: model
      type(quantity_t), allocatable :: list(:)
      type(error_t), allocatable :: error
      integer :: i

      call new_helicopter(model, data, error)
      call no_error(failure, error)
      call check_close(failure, model%nu_beta**2, 1.0625_wp, 1.0e-14_wp, 'flap frequency ratio, squared')
      call check_close(failure, model%k_p, 0.25_wp, 1.0e-15_wp, 'pitch-flap coupling')
      call check_close(failure, model%k_c, 1.6538e4_wp, 0.5_wp, 'control stiffness')
      call check_close(failure, data%omega, 40.0_wp, 0.0_wp, 'rotor speed')
      call check_close(failure, data%i_b, 416.67_wp, 0.0_wp, 'flap inertia')
      call check_close(failure, data%i_f, 9.375e-2_wp, 0.0_wp, 'pitch inertia')
      call check_close(failure, data%i_x, 1.875e-2_wp, 0.0_wp, 'coupling inertia')
      call check_close(failure, data%gamma, 8.0_wp, 0.0_wp, 'Lock number')
      list = model%quantities()
      do i = 1, size(list)
         call check(failure, is_plain(list(i)%name) .and. is_plain(list(i)%unit), 'quantities have no commas')
         if (list(i)%name == 'nu_beta_squared') call check_close(failure, list(i)%value, 1.0625_wp, 1.0e-14_wp, 'in the list')
      end do
      call check(failure, size(list) >= 16, 'all of the table is told')
   end subroutine table_3

   pure logical function is_plain(text)
      character(*), intent(in) :: text

      is_plain = len(text) > 0 .and. index(text, ',') == 0
   end function is_plain

   !> A(0) = (0.25, 0.2, 0), B 0.15 m below it.
   subroutine at_rest(failure)
      character(:), allocatable, intent(inout) :: failure
      type(helicopter_data_t) :: data
      type(helicopter_t) :: model
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp) :: a(1, 2), phi(1)

      call new_helicopter(model, data, error)
      at%x = [0.0_wp, 0.0_wp]
      at%v = [0.0_wp, 0.0_wp]
      call model%constraint(at, phi)
      call check_below(failure, phi(1), 1.0e-16_wp, 'the link has its length')
      call model%jacobian(at, a)
      ! Vertical: flap raises A by x_theta, pitch by y_theta.
      call check_close(failure, a(1, 1), 0.05_wp, 1.0e-16_wp, 'arm of flap')
      call check_close(failure, a(1, 2), 0.2_wp, 1.0e-16_wp, 'arm of pitch')
      ! A quarter turn of flap brings A above the hinge: x_theta up, y_theta across.
      at%x = [0.5_wp*pi, 0.0_wp]
      call model%constraint(at, phi)
      call check_close(failure, phi(1), norm2([0.2_wp - 0.25_wp, 0.0_wp, 0.05_wp + 0.15_wp]) - 0.15_wp, 1.0e-15_wp, 'flap')
      ! A quarter turn of pitch brings it y_theta up.
      at%x = [0.0_wp, 0.5_wp*pi]
      call model%constraint(at, phi)
      call check_close(failure, phi(1), norm2([0.0_wp, -0.2_wp, 0.2_wp + 0.15_wp]) - 0.15_wp, 1.0e-15_wp, 'pitch')
   end subroutine at_rest

   subroutine model_is_consistent(failure)
      character(:), allocatable, intent(inout) :: failure
      type(helicopter_data_t) :: data
      type(helicopter_t) :: model
      type(finding_t), allocatable :: findings(:)
      type(state_t) :: at
      type(error_t), allocatable :: error
      integer :: i, moving

      do moving = 0, 1
         data = helicopter_data_t()
         if (moving == 1) data = tilting()
         call new_helicopter(model, data, error)
         do i = 1, 3
            at%t = 0.013_wp*i
            at%x = [0.3_wp*i, -0.5_wp + 0.2_wp*i]
            at%v = [2.0_wp*i, 0.5_wp - 3.0_wp*i]
            call verify(model, at, findings, error)
            call no_error(failure, error)
            if (size(findings) > 0) call check(failure, .false., findings(1)%message)
         end do
      end do
   end subroutine model_is_consistent

   subroutine steps_constraint(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=8), parameter :: names(2) = [character(len=8) :: 'present', 'baseline']
      character(len=11), parameter :: controls(2) = [character(len=11) :: 'standard', 'odepkg-2009']
      type(helicopter_data_t) :: data
      type(integration_result_t) :: result
      type(sampler_t) :: sampler
      type(state_t) :: at
      integer :: i, j

      do j = 1, 2
         do i = 1, 2
            sampler = sampler_t()
            at = state_t()
            call fly(data, trim(names(i)), paper(controls(j)), 2.0_wp, result, sampler, failure, at)
            call check(failure, result%steps == 200, trim(names(i))//', '//trim(controls(j))//': 200 steps')
            call check(failure, result%rejected == 0, trim(names(i))//', '//trim(controls(j))//': none rejected')
            if (names(i) == 'present') then
               call check_below(failure, sampler%worst_phi, 1.0e-12_wp, 'compliance')
               call check_below(failure, sampler%worst_phidot, 1.0e-12_wp, 'compliance of the velocity')
               call check_below(failure, sampler%mu, 1.0e-6_wp, 'mu is essentially zero')
            end if
         end do
      end do
   end subroutine steps_constraint

   !> Tries, because the paper does not tell accepted and rejected steps apart; by the honest error test.
   subroutine steps_stiffness(failure)
      character(:), allocatable, intent(inout) :: failure
      type(helicopter_data_t) :: data
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(sampler_t) :: sampler
      type(state_t) :: at

      options = paper('standard')
      call fly(data, 'unconstrained', options, 2.0_wp, result, sampler, failure, at)
      call check_close(failure, real(result%steps + result%rejected, wp), 700.0_wp, 70.0_wp, 'steps and rejected tries')
      call check(failure, result%steps > 450 .and. result%rejected > 100, 'many are rejected')
      options%norm = 'max'
      at = state_t()
      call fly(data, 'unconstrained', options, 2.0_wp, result, sampler, failure, at)
      call check_close(failure, real(result%steps + result%rejected, wp), 700.0_wp, 70.0_wp, 'the same with the other norm')
   end subroutine steps_stiffness

   !> A hundred times the stiffness: the paper's tolerance lets the oscillation grow, a strict one does not.
   subroutine stiffer_control(failure)
      character(:), allocatable, intent(inout) :: failure
      type(helicopter_data_t) :: data
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(sampler_t) :: sampler
      type(state_t) :: at

      data%control_frequency = 105.0_wp
      call fly(data, 'unconstrained', paper('standard'), 2.0_wp, result, sampler, failure, at)
      call check(failure, sampler%worst_phi > 0.1_wp, 'the link is violated by its own length')
      call check(failure, result%steps > 20*200, 'and the steps are many')
      options = paper('standard')
      options%rtol = 1.0e-6_wp
      options%atol = 1.0e-8_wp
      at = state_t()
      sampler = sampler_t()
      call fly(data, 'unconstrained', options, 2.0_wp, result, sampler, failure, at)
      call check_below(failure, sampler%worst_phi, 1.0e-6_wp, 'a strict tolerance converges')
   end subroutine stiffer_control

   !> Ten thousand times the stiffness: as many steps as with the constraint, and theta = -K_p beta.
   subroutine implicit_control(failure)
      character(:), allocatable, intent(inout) :: failure
      type(helicopter_data_t) :: data
      type(integration_options_t) :: options
      type(integration_result_t) :: constrained, stiff
      type(sampler_t) :: sampler
      type(state_t) :: at

      ! At the start all is zero, the load too: what tells the size of things is where they go.
      options = integration_options_t(integrator='radau', rtol=1.0e-6_wp, atol=1.0e-6_wp, first_step=1.0e-3_wp)
      call fly(data, 'present', options, 2.0_wp, constrained, sampler, failure, at)
      data%control_frequency = 1050.0_wp
      at = state_t()
      call fly(data, 'unconstrained', options, 2.0_wp, stiff, sampler, failure, at)
      call check_close(failure, real(stiff%steps, wp), real(constrained%steps, wp), 0.1_wp*constrained%steps, 'steps')
      call check(failure, 10*stiff%jacobians <= stiff%steps, 'few Jacobians')
      call check(failure, abs(at%v(1)) > 1.0_wp, 'the blade flaps')
      call check_below(failure, at%x(2) + 0.25_wp*at%x(1), 1.0e-8_wp, 'pitch follows flap')
   end subroutine implicit_control

   subroutine energy_is_kept(failure)
      character(:), allocatable, intent(inout) :: failure
      type(helicopter_data_t) :: data
      type(integration_result_t) :: result
      type(sampler_t) :: sampler
      type(state_t) :: at

      data%gamma = 0.0_wp
      data%m_beta1 = 0.0_wp
      at%x = [0.1_wp, 0.0_wp]
      at%v = [1.0_wp, 0.0_wp]
      call fly(data, 'present', strict(), 2.0_wp, result, sampler, failure, at)
      call check(failure, sampler%first_energy > 1.0e3_wp, 'there is energy')
      call check_below(failure, sampler%worst_energy/sampler%first_energy, 2.0e-9_wp, 'change of energy')
   end subroutine energy_is_kept

   !> Methods that enforce the constraint do without K_c; the system as given is not changed.
   subroutine stiffness_or_constraint(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=24), parameter :: names(4) = [character(len=24) :: 'present', 'baseline', 'baumgarte', 'unconstrained']
      type(helicopter_data_t) :: data
      type(helicopter_t) :: model
      class(constrained_ode_t), allocatable :: ode
      type(method_t) :: method
      type(sample_t) :: s
      type(error_t), allocatable :: error
      real(wp) :: dydt(4), y(4)
      integer :: i, info

      call new_helicopter(model, data, error)
      ! On the manifold to first order only, so that the stiffness has something to act on.
      y = [0.08_wp, -0.01_wp, 0.4_wp, -0.1_wp]
      do i = 1, size(names)
         method%name = names(i)
         call new_constrained_ode(ode, model, method, error)
         call no_error(failure, error)
         call ode%rhs(0.3_wp, y, dydt, info)
         call ode%sample(0.3_wp, y, s, info)
         if (names(i) == 'unconstrained') then
            call check_close(failure, s%outputs(1), 16537.5_wp*(y(2) + 0.25_wp*y(1))/0.2_wp, 1.0e-8_wp, 'force of the stiffness')
            call check_close(failure, dot_product([-data%i_x, data%i_f], dydt(3:4)) + data%i_f*1600.0_wp*y(2) &
                             - data%i_x*1600.0_wp*y(1), -0.2_wp*s%outputs(1), 1.0e-8_wp, 'it acts on the pitch')
            call check(failure, s%phi > 1.0e-4_wp .and. s%rank == 1, 'the constraint is evaluated')
         else
            call check_close(failure, s%outputs(1), s%lambda(1), 0.0_wp, trim(names(i))//': force of the link')
         end if
      end do
      call check(failure, model%enforced, 'the system as given stays as it is')
   end subroutine stiffness_or_constraint

   subroutine start_stays(failure)
      character(:), allocatable, intent(inout) :: failure
      type(helicopter_data_t) :: data
      type(helicopter_t) :: model
      type(method_t) :: method
      type(start_report_t) :: report
      type(state_t) :: at
      type(error_t), allocatable :: error

      call new_helicopter(model, data, error)
      at%x = [0.1_wp, 0.2_wp]
      at%v = [0.3_wp, 0.4_wp]
      method%name = 'unconstrained'
      call consistent_start(model, method, at, report, error)
      call no_error(failure, error)
      call check_below(failure, maxval(abs([at%x, at%v] - [0.1_wp, 0.2_wp, 0.3_wp, 0.4_wp])), 0.0_wp, 'nothing is moved')
      call check(failure, report%freedoms == 2, 'both coordinates are free')
      method%name = 'present'
      call consistent_start(model, method, at, report, error)
      call check(failure, report%moved_x > 0.01_wp .and. report%freedoms == 1, 'what is enforced is mended')
   end subroutine start_stays

   subroutine bad_data(failure)
      character(:), allocatable, intent(inout) :: failure
      type(helicopter_data_t) :: good, data

      data = good
      data%omega = 0.0_wp
      call refused(data, 'omega = 0 is not positive', failure)
      data = good
      data%length = 0.0_wp
      call refused(data, 'length = 0 is not positive', failure)
      data = good
      data%i_b = -1.0_wp
      call refused(data, 'i_b = -1.0000 is not positive', failure)
      data = good
      data%i_f = 0.0_wp
      call refused(data, 'i_f = 0 is not positive', failure)
      data = good
      data%i_x = -7.0_wp
      call refused(data, 'the mass matrix is not positive definite', failure)
      data = good
      data%gamma = -8.0_wp
      call refused(data, 'gamma = -8.0000 is negative', failure)
      data = good
      data%radius = 0.1_wp
      call refused(data, 'is not larger than x_beta', failure)
      data = good
      data%y_theta = 0.0_wp
      call refused(data, 'no arm', failure)
      data = good
      data%control_frequency = -1.0_wp
      call refused(data, 'control_frequency = -1.0000 is negative', failure)
      data = good
      data%b_sine(2) = ieee_value(1.0_wp, ieee_positive_inf)
      call refused(data, 'a coordinate of point A or B', failure)
      data = good
      data%phi_beta1 = ieee_value(1.0_wp, ieee_negative_inf)
      call refused(data, 'a moment or its phase', failure)
   end subroutine bad_data

   !> What the case file says is what its absence means.
   subroutine shipped_case(failure)
      character(:), allocatable, intent(inout) :: failure
      type(helicopter_data_t) :: good
      type(namelist_file_t) :: file
      type(model_case_t) :: kind
      class(tabulated_system_t), allocatable :: model
      type(settings_t) :: settings
      type(state_t) :: start
      type(error_t), allocatable :: error

      call file%load('cases/helicopter/figure10.nml', error)
      allocate (helicopter_group_t :: kind%group)
      if (.not. allocated(error)) call kind%read(file, model, start, settings, error)
      call no_error(failure, error)
      if (allocated(error)) return
      select type (model)
      class is (helicopter_t)
         call check_close(failure, model%data%omega, good%omega, 0.0_wp, 'rotor speed')
         call check_below(failure, maxval(abs([model%data%i_b, model%data%i_f, model%data%i_x] - &
                                              [good%i_b, good%i_f, good%i_x])), 0.0_wp, 'inertias')
         call check_below(failure, maxval(abs([model%data%b_mean - good%b_mean, model%data%b_sine, model%data%b_cosine])), &
                          0.0_wp, 'B')
         call check_close(failure, model%data%phi_beta1, good%phi_beta1, 1.0e-15_wp, 'phase of the load')
         call check_close(failure, model%k_c, 16537.5_wp, 1.0e-10_wp, 'control stiffness')
         call check(failure, model%output_name(1) == 'link_force' .and. model%n_outputs == 1, 'the link force is told')
      class default
         call check(failure, .false., 'it is no blade')
      end select
      call check(failure, size(settings%methods) == 3, 'three methods')
      call check(failure, settings%methods(3)%label == 'penalty', 'label')
      call check(failure, settings%methods(3)%method%name == 'unconstrained', 'the stiffness in place of the constraint')
   end subroutine shipped_case

   subroutine refused(data, text, failure)
      type(helicopter_data_t), intent(in) :: data
      character(*), intent(in) :: text
      character(:), allocatable, intent(inout) :: failure
      type(helicopter_t) :: model
      type(error_t), allocatable :: error

      call new_helicopter(model, data, error)
      call check(failure, allocated(error), 'refused: '//text)
      if (.not. allocated(error)) return
      call check(failure, index(error%line(), 'helicopter: ') == 1 .and. index(error%line(), text) > 0, error%line())
      call check(failure, index(error%line(), new_line('a')) == 0 .and. len(error%remedy) > 0, 'one line with a remedy')
   end subroutine refused

end module test_helicopter
