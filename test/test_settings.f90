!> Tests of the settings of case files: defaults, every option, and what is refused.
module test_settings
   use testing, only: check, check_below, new_test, no_error, test_t
   use test_case, only: check_error, lf, load
   use taut_kinds, only: wp
   use taut_error, only: error_t
   use taut_case_namelist_file, only: namelist_file_t
   use taut_case_model_group, only: model_case_t
   use taut_case_pendulum, only: pendulum_group_t
   use taut_case_settings, only: read_settings, settings_t
   use taut_constrained_method_options, only: method_t
   use taut_constrained_system, only: state_t
   use taut_constrained_system_tables, only: tabulated_system_t
   use taut_model_pendulum, only: pendulum_t
   use taut_ode_options, only: integration_options_t
   implicit none (type, external)
   private
   public :: collect_settings

contains

   !> All tests of this module.
   function collect_settings() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [ &
              new_test('entries and values that cannot be read', unreadable), &
              new_test('defaults of the settings', defaults), &
              new_test('every option of the settings', every_option), &
              new_test('several methods and groups', several), &
              new_test('settings that are not valid', invalid_settings), &
              new_test('the pendulum of a case file', pendulum_case)]
   end function collect_settings

   !> Fails unless the settings of a text are refused with all of the parts.
   subroutine refuse(failure, text, parts, label)
      character(:), allocatable, intent(inout) :: failure
      character(*), intent(in) :: text, parts, label
      type(namelist_file_t) :: file
      type(settings_t) :: settings
      type(error_t), allocatable :: error

      call load(text, file, error)
      call no_error(failure, error)
      if (.not. allocated(error)) call read_settings(file, settings, error)
      call check_error(failure, error, parts, label)
   end subroutine refuse

   subroutine unreadable(failure)
      character(:), allocatable, intent(inout) :: failure

      call refuse(failure, '&integration'//lf//'t_end = 1.0'//lf//'rtoll = 1e-3 /', &
                  'case.nml:3: &integration|no entry rtoll|rtol,', 'an unknown entry')
      call refuse(failure, '&integration'//lf//'rtol(1) = 1e-3 /', 'case.nml:2: &integration|rtol(1)', 'a subscript too many')
      call refuse(failure, '&integration'//lf//'t_end = ten /', 'case.nml:2: &integration|t_end = ten cannot be read|type', &
                  'a word for a number')
      call refuse(failure, '&integration t_end = "1.0" /', 't_end = "1.0" cannot be read', 'text for a number')
      call refuse(failure, '&integration t_end = 1.0 s /', 't_end = 1.0 s cannot be read', 'a unit after a number')
      call refuse(failure, '&integration t_end = 1.0, 2.0 /', 't_end = 1.0, 2.0 cannot be read', 'two numbers for one')
      call refuse(failure, '&integration max_steps = 1.5 /', 'max_steps = 1.5 cannot be read', 'a fraction for an integer')
      call refuse(failure, '&method name = present /', 'case.nml:1: &method|name = present cannot be read|quotation', &
                  'text without quotation marks')
      call refuse(failure, '&method'//lf//'accept_inconsistent = 2.0 /', &
                  'case.nml:2: &method|accept_inconsistent = 2.0 cannot be read', 'a number for a truth value')
      call refuse(failure, '&output every = 3 /', '&output|no entry every|dt', 'an unknown entry of &output')
   end subroutine unreadable

   subroutine defaults(failure)
      character(:), allocatable, intent(inout) :: failure
      type(namelist_file_t) :: file
      type(settings_t) :: settings
      type(error_t), allocatable :: error
      type(integration_options_t) :: plain
      type(method_t) :: plain_method

      call load('&integration / &output /', file, error)
      call read_settings(file, settings, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      associate (o => settings%options)
         call check_below(failure, maxval(abs([settings%t_start, settings%t_end - 10.0_wp, o%rtol - plain%rtol, &
                                               o%atol - plain%atol, o%first_step - plain%first_step, o%min_step - plain%min_step, &
                                               o%max_step - plain%max_step, o%output_dt - plain%output_dt, &
                                               o%projection_limit - plain%projection_limit])), 0.0_wp, 'a default differs')
         call check(failure, o%max_steps == plain%max_steps .and. o%step_control == plain%step_control .and. &
                    o%norm == plain%norm, 'a default differs')
      end associate
      call check(failure, size(settings%methods) == 1, 'there is not one method')
      if (allocated(failure)) return
      call check(failure, settings%methods(1)%label == 'present' .and. settings%methods(1)%method%name == plain_method%name, &
                 'the default method')
   end subroutine defaults

   subroutine every_option(failure)
      character(:), allocatable, intent(inout) :: failure
      type(namelist_file_t) :: file
      type(settings_t) :: settings
      type(error_t), allocatable :: error
      real(wp), allocatable :: read(:)

      call load('&integration t_start = 1, t_end = 2, rtol = 3d-3, atol = 4e-4, first_step = 6.0, min_step = 5.0,'//lf// &
                ' max_step = 7.0, max_steps = 8, step_control = "fixed", norm = "max", projection_limit = 9.0 /'//lf// &
                '&output dt = 0.5 /'//lf//'&method name = "penalty", label = "a_b-c.1", weight = "mass",'//lf// &
                ' stage_projection = "none", state_projection = "position", form = "force", solver = "factor", rcond = 0.1,'// &
                ' alpha = 11, beta = 12, dt = 13, correction_tolerance = 14, stiffness = 15, damping = 16,'// &
                ' projection_tolerance = 17, max_iterations = 18, accept_inconsistent = T /', file, error)
      call read_settings(file, settings, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      associate (o => settings%options, m => settings%methods(1)%method)
         read = [settings%t_start, settings%t_end, 1.0e3_wp*o%rtol, 1.0e4_wp*o%atol, o%first_step, o%min_step, o%max_step, &
                 real(o%max_steps, wp), o%projection_limit]
         call check_below(failure, maxval(abs(read - [1, 2, 3, 4, 6, 5, 7, 8, 9])), 1.0e-12_wp, 'a number of &integration')
         call check(failure, o%step_control == 'fixed' .and. o%norm == 'max', 'a text of &integration')
         call check_below(failure, o%output_dt - 0.5_wp, 0.0_wp, 'dt of &output')
         read = [100.0_wp*m%rcond, m%alpha, m%beta, m%dt, m%correction_tolerance, m%stiffness, m%damping, &
                 m%projection_tolerance, real(m%max_iterations, wp)]
         call check_below(failure, maxval(abs(read - [10, 11, 12, 13, 14, 15, 16, 17, 18])), 1.0e-12_wp, 'a number of &method')
         call check(failure, m%name == 'penalty' .and. m%weight == 'mass' .and. m%stage_projection == 'none' .and. &
                    m%state_projection == 'position' .and. m%form == 'force' .and. m%solver == 'factor' .and. &
                    m%accept_inconsistent, 'a text of &method')
         call check(failure, settings%methods(1)%label == 'a_b-c.1', 'the label')
      end associate
   end subroutine every_option

   subroutine several(failure)
      character(:), allocatable, intent(inout) :: failure
      type(namelist_file_t) :: file
      type(settings_t) :: settings
      type(error_t), allocatable :: error

      ! An option of one method is not inherited by the next.
      call load('&method name = "baumgarte", alpha = 5.0, label = "b5" / &method name = "baumgarte" /', file, error)
      call read_settings(file, settings, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      call check(failure, size(settings%methods) == 2, 'two methods')
      if (allocated(failure)) return
      call check(failure, settings%methods(1)%label == 'b5' .and. settings%methods(2)%label == 'baumgarte', 'labels')
      call check_below(failure, settings%methods(1)%method%alpha - 5.0_wp, 0.0_wp, 'first gain')
      call check_below(failure, settings%methods(2)%method%alpha - 2.0_wp, 0.0_wp, 'second gain')
   end subroutine several

   subroutine invalid_settings(failure)
      character(:), allocatable, intent(inout) :: failure
      character(*), parameter :: i = lf//'&integration ', m = lf//'&method name = "present", '

      call refuse(failure, i//'rtol = 0 /', 'case.nml:2: &integration|rtol = 0', 'rtol zero')
      call refuse(failure, i//'rtol = -1e-3 /', '&integration|rtol', 'rtol negative')
      call refuse(failure, i//'atol = -1e-3 /', '&integration|atol', 'atol negative')
      call refuse(failure, i//'max_step = 0 /', '&integration|max_step', 'max_step zero')
      call refuse(failure, i//'min_step = -1 /', '&integration|min_step', 'min_step negative')
      call refuse(failure, i//'max_steps = 0 /', '&integration|max_steps', 'max_steps zero')
      call refuse(failure, i//'step_control = "fixed" /', '&integration|first_step', 'fixed steps without a step')
      call refuse(failure, i//'step_control = "odd" /', '&integration|"odd"|"odepkg-2009"', 'an unknown step control')
      call refuse(failure, i//'norm = "one" /', '&integration|"one"|"rms"', 'an unknown norm')
      call refuse(failure, lf//'&output dt = -1 /', 'case.nml:2: &output|dt', 'dt negative')
      call refuse(failure, lf//'&method name = "presnt" /', 'case.nml:2: &method|"presnt"|"present"', 'an unknown method')
      call refuse(failure, m//'weight = "odd" /', 'case.nml:2: &method|weight = "odd"|"mass"', 'an unknown weight')
      call refuse(failure, m//'solver = "lu" /', '&method|solver = "lu"|"dgelsd"', 'an unknown solver')
      call refuse(failure, m//'rcond = 1.0 /', '&method|rcond', 'rcond of one')
      call refuse(failure, m//'projection_tolerance = 0 /', '&method|projection_tolerance', 'no tolerance')
      call refuse(failure, m//'label = "a/b" /', '&method|"a/b"', 'a label with a slash')
      call refuse(failure, m//'label = ".." /', '&method|".."', 'a label of dots')
      call refuse(failure, m//'label = "summary" /', '&method|"summary"', 'the label of the summary')
      call refuse(failure, m//'label = "x" /'//m//'label = "x" /', 'case.nml:3: &method|"x"|another', 'two labels alike')
   end subroutine invalid_settings

   subroutine pendulum_case(failure)
      character(:), allocatable, intent(inout) :: failure
      type(namelist_file_t) :: file
      type(model_case_t) :: kind
      class(tabulated_system_t), allocatable :: model
      type(state_t) :: start
      type(settings_t) :: settings
      type(error_t), allocatable :: error

      call load('&integration t_end = 3.0 / &pendulum mass = 2, length = 3, gravity = 4, constraint_copies = 2,'// &
                ' position = 5, 6, velocity(2) = 7 /', file, error)
      allocate (pendulum_group_t :: kind%group)
      call kind%read(file, model, start, settings, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      select type (model)
      class is (pendulum_t)
         call check_below(failure, maxval(abs([model%m, model%l, model%g, start%x, start%v, settings%t_end] - &
                                              [2, 3, 4, 5, 6, 0, 7, 3])), 0.0_wp, 'a value of the pendulum')
         call check(failure, model%c == 2, 'copies of the constraint')
      class default
         call check(failure, .false., 'it is no pendulum')
      end select
   end subroutine pendulum_case

end module test_settings
