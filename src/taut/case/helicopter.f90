!> Case files of the helicopter blade.
module taut_case_helicopter
   use taut_kinds, only: wp
   use taut_error, only: error_t
   use taut_case_entries, only: entries_t
   use taut_case_model_group, only: model_group_t
   use taut_constrained_system, only: state_t
   use taut_constrained_system_tables, only: tabulated_system_t
   use taut_model_helicopter, only: helicopter_t, helicopter_data_t, new_helicopter
   implicit none (type, external)
   private
   public :: helicopter_group_t

   !> &helicopter; what it leaves out has the values of Table 3 and Sect. 4.3.
   !!
   !! A method that enforces the constraint does without the control system's stiffness K_c, as the paper's `baseline` and
   !! `present` do; the method `unconstrained` has it, as the paper's `penalty`.
   type, extends(model_group_t) :: helicopter_group_t
      !> The blade.
      type(helicopter_data_t) :: data
      !> Initial angles of flap and pitch [rad], and their rates [rad/s].
      real(wp) :: position(2) = 0.0_wp, velocity(2) = 0.0_wp
   contains
      procedure :: declare
      procedure :: build
   end type helicopter_group_t

contains

   !> Its entries.
   subroutine declare(self, entries)
      !> What the group says.
      class(helicopter_group_t), intent(inout) :: self
      !> What passes over them.
      type(entries_t), intent(inout) :: entries

      call entries%group('helicopter', 'a rigid blade that flaps and pitches, held by its pitch link')
      associate (it => self%data)
         call entries%item('omega', it%omega, 'rad/s', 'rotor speed', above=0.0_wp)
         call entries%item('radius', it%radius, 'm', 'rotor radius', above=0.0_wp)
         call entries%item('i_b', it%i_b, 'kg m^2', 'inertia of flap', above=0.0_wp)
         call entries%item('i_f', it%i_f, 'kg m^2', 'inertia of pitch', above=0.0_wp)
         call entries%item('i_x', it%i_x, 'kg m^2', 'inertia that couples them')
         call entries%item('gamma', it%gamma, '', 'Lock number', least=0.0_wp)
         call entries%item('x_beta', it%x_beta, 'm', 'flap hinge from the axis of rotation', least=0.0_wp)
         call entries%item('x_theta', it%x_theta, 'm', 'point A from the flap hinge, along the blade')
         call entries%item('y_theta', it%y_theta, 'm', 'point A from the flap hinge, across the blade')
         call entries%item('b_mean', it%b_mean, 'm', 'point B: mean of x, y, z')
         call entries%item('b_cosine', it%b_cosine, 'm', 'point B: what goes with cos(omega t)')
         call entries%item('b_sine', it%b_sine, 'm', 'point B: what goes with sin(omega t)')
         call entries%item('length', it%length, 'm', 'length of the pitch link', above=0.0_wp)
         call entries%item('control_frequency', it%control_frequency, '1/rev', &
                           'of the pitch on the control system''s stiffness', least=0.0_wp)
         call entries%item('m_beta0', it%m_beta0, 'N m', 'flap moment: constant part')
         call entries%item('m_beta1', it%m_beta1, 'N m', 'flap moment: factor of cos(omega t + phi_beta1)')
         call entries%item('phi_beta1', it%phi_beta1, 'rad', 'its phase')
         call entries%item('m_theta0', it%m_theta0, 'N m', 'pitch moment: constant part')
         call entries%item('m_theta1', it%m_theta1, 'N m', 'pitch moment: factor of cos(omega t + phi_theta1)')
         call entries%item('phi_theta1', it%phi_theta1, 'rad', 'its phase')
      end associate
      call entries%item('position', self%position, 'rad', 'flap and pitch at the start')
      call entries%item('velocity', self%velocity, 'rad/s', 'their rates at the start')
   end subroutine declare

   !> The blade and its start.
   subroutine build(self, model, start, error)
      !> What the group says.
      class(helicopter_group_t), intent(in) :: self
      !> The blade.
      class(tabulated_system_t), allocatable, intent(out) :: model
      !> Initial state as given.
      type(state_t), intent(out) :: start
      !> What is wrong with it.
      type(error_t), allocatable, intent(inout) :: error
      type(helicopter_t), allocatable :: own

      allocate (own)
      call new_helicopter(own, self%data, error)
      allocate (start%w(0))
      start%x = self%position
      start%v = self%velocity
      call move_alloc(own, model)
   end subroutine build

end module taut_case_helicopter
