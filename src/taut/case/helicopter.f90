!> Case files of the helicopter blade.
module taut_case_helicopter
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise
   use taut_case_namelist_file, only: namelist_file_t, group_t
   use taut_case_settings, only: settings_t, read_settings, shared_groups
   use taut_constrained_system, only: state_t
   use taut_model_helicopter, only: helicopter_t, helicopter_data_t, new_helicopter
   implicit none (type, external)
   private
   public :: read_helicopter

contains

   !> Reads a case file; what it leaves out has the values of Table 3 and Sect. 4.3.
   !!
   !! A method that enforces the constraint does without the control system's stiffness K_c, as the paper's `baseline` and
   !! `present` do; the method `unconstrained` has it, as the paper's `penalty`.
   subroutine read_helicopter(file, model, start, settings, error)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> The blade.
      type(helicopter_t), intent(out) :: model
      !> Initial state as given.
      type(state_t), intent(out) :: start
      !> Tolerances and methods.
      type(settings_t), intent(out) :: settings
      !> What is wrong with the file.
      type(error_t), allocatable, intent(inout) :: error
      type(helicopter_data_t) :: data
      real(wp) :: position(2), velocity(2)
      integer :: i

      position = 0.0_wp
      velocity = 0.0_wp
      call file%only_groups([character(len=11) :: 'helicopter', shared_groups], error, many=['method'])
      if (allocated(error)) return
      do i = 1, size(file%groups)
         if (file%groups(i)%name /= 'helicopter') cycle
         call read_blade(file, file%groups(i), data, position, velocity, error)
         if (allocated(error)) return
         call new_helicopter(model, data, error)
         if (.not. all(abs([position, velocity]) <= huge(1.0_wp))) &
            call raise(error, 'helicopter', 'position or velocity is not a number', 'give rad and rad/s')
         call file%locate(file%groups(i), error)
      end do
      if (model%n == 0) call new_helicopter(model, data, error)
      if (allocated(error)) return
      allocate (start%w(0))
      start%x = position
      start%v = velocity
      call read_settings(file, settings, error)
   end subroutine read_helicopter

   !> &helicopter.
   subroutine read_blade(file, group, data, position, velocity, error)
      type(namelist_file_t), intent(in) :: file
      type(group_t), intent(in) :: group
      type(helicopter_data_t), intent(inout) :: data
      real(wp), intent(inout) :: position(2), velocity(2)
      type(error_t), allocatable, intent(inout) :: error
      character(*), parameter :: names = 'omega, radius, i_b, i_f, i_x, gamma, x_beta, x_theta, y_theta, b_mean, b_cosine, '// &
                                 'b_sine, length, control_frequency, m_beta0, m_beta1, phi_beta1, m_theta0, m_theta1, '// &
                                 'phi_theta1, position, velocity'
      real(wp) :: omega, radius, i_b, i_f, i_x, gamma, x_beta, x_theta, y_theta, b_mean(3), b_cosine(3), b_sine(3), length, &
                  control_frequency, m_beta0, m_beta1, phi_beta1, m_theta0, m_theta1, phi_theta1
      integer :: i, status
      character(len=200) :: message
      namelist /helicopter/ omega, radius, i_b, i_f, i_x, gamma, x_beta, x_theta, y_theta, b_mean, b_cosine, b_sine, length, &
         control_frequency, m_beta0, m_beta1, phi_beta1, m_theta0, m_theta1, phi_theta1, position, velocity

      omega = data%omega
      radius = data%radius
      i_b = data%i_b
      i_f = data%i_f
      i_x = data%i_x
      gamma = data%gamma
      x_beta = data%x_beta
      x_theta = data%x_theta
      y_theta = data%y_theta
      b_mean = data%b_mean
      b_cosine = data%b_cosine
      b_sine = data%b_sine
      length = data%length
      control_frequency = data%control_frequency
      m_beta0 = data%m_beta0
      m_beta1 = data%m_beta1
      phi_beta1 = data%phi_beta1
      m_theta0 = data%m_theta0
      m_theta1 = data%m_theta1
      phi_theta1 = data%phi_theta1
      do i = 1, size(group%entries)
         read (group%entries(i)%text, nml=helicopter, iostat=status, iomsg=message)
         if (status /= 0) call file%complain(group, i, message, names, error)
      end do
      data = helicopter_data_t(omega, radius, i_b, i_f, i_x, gamma, x_beta, x_theta, y_theta, b_mean, b_cosine, b_sine, length, &
                               control_frequency, m_beta0, m_beta1, phi_beta1, m_theta0, m_theta1, phi_theta1)
   end subroutine read_blade

end module taut_case_helicopter
