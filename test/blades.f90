!> Flights of the helicopter blade that several suites use.
module blades
   use taut, only: constrained_ode_t, error_t, integration_options_t, integration_result_t, method_t, observer_t, &
                  ode_system_t, sample_t, simulate, state_t, status_reached_end, wp
   use taut_model_helicopter, only: helicopter_data_t, helicopter_t, new_helicopter
   use testing, only: check, no_error
   implicit none (type, external)
   private
   public :: fly, known_motion_t, motion_at, paper, sampler_t, strict, tilting

   !> Samples every point.
   type, extends(observer_t) :: sampler_t
      integer :: points = 0
      real(wp) :: worst_phi = 0.0_wp, worst_phidot = 0.0_wp, worst_phiddot = 0.0_wp, worst_energy = 0.0_wp
      real(wp) :: worst_lambda = 0.0_wp, worst_motion = 0.0_wp, first_energy = 0.0_wp, force = 0.0_wp, mu = 0.0_wp
      !> What the motion is compared with, if it is allocated.
      class(known_motion_t), allocatable :: expected
   contains
      procedure :: observe
   end type sampler_t

   !> Motion in closed form: constant + Re(amplitude exp(i omega t)) + free decay of each coordinate by itself.
   type :: known_motion_t
      real(wp) :: omega = 0.0_wp, constant(2) = 0.0_wp
      complex(wp) :: amplitude(2) = (0.0_wp, 0.0_wp), free(2) = (0.0_wp, 0.0_wp), exponent(2) = (0.0_wp, 0.0_wp)
   end type known_motion_t

contains

   !> The state's sample, its extremes, and its distance from a known motion.
   subroutine observe(self, ode, t, h, y, error)
      class(sampler_t), intent(inout) :: self
      class(ode_system_t), intent(inout) :: ode
      real(wp), intent(in) :: t, h
      real(wp), intent(in), contiguous :: y(:)
      type(error_t), allocatable, intent(inout) :: error
      type(sample_t) :: s
      integer :: info

      select type (ode)
      class is (constrained_ode_t)
         call ode%sample(t, y, s, info)
      end select
      if (self%points == 0) self%first_energy = s%energy
      self%points = self%points + 1
      self%worst_phi = max(self%worst_phi, s%phi)
      self%worst_phidot = max(self%worst_phidot, s%phidot)
      self%worst_phiddot = max(self%worst_phiddot, s%phiddot)
      self%worst_energy = max(self%worst_energy, abs(s%energy - self%first_energy))
      self%worst_lambda = max(self%worst_lambda, abs(s%lambda(1)))
      self%force = s%outputs(1)
      self%mu = max(self%mu, abs(s%mu(1)))
      if (allocated(self%expected)) self%worst_motion = max(self%worst_motion, maxval(abs(y - motion_at(self%expected, t))))
      associate (unused_step => h, unused_error => error)
      end associate
   end subroutine observe

   !> {beta, theta, their rates} of a known motion.
   pure function motion_at(expected, t) result(y)
      class(known_motion_t), intent(in) :: expected
      real(wp), intent(in) :: t
      real(wp) :: y(4)
      complex(wp) :: driven(2), free(2), i_omega

      i_omega = cmplx(0.0_wp, expected%omega, wp)
      driven = expected%amplitude*exp(i_omega*t)
      free = expected%free*exp(expected%exponent*t)
      y(1:2) = expected%constant + real(driven + free, wp)
      y(3:4) = real(i_omega*driven + expected%exponent*free, wp)
   end function motion_at

   !> Options at the paper's tolerances.
   function paper(control) result(options)
      character(*), intent(in) :: control
      type(integration_options_t) :: options

      options%rtol = 1.0e-2_wp
      options%atol = 1.0e-4_wp
      options%first_step = 0.01_wp
      options%max_step = 0.01_wp
      options%step_control = control
   end function paper

   !> Options at 1e-11.
   function strict() result(options)
      type(integration_options_t) :: options

      options%rtol = 1.0e-11_wp
      options%atol = 1.0e-11_wp
      options%max_step = 0.01_wp
   end function strict

   !> Integrates a blade by a method, from rest at the origin if no start is given.
   subroutine fly(data, name, options, t_end, result, sampler, failure, at)
      type(helicopter_data_t), intent(in) :: data
      character(*), intent(in) :: name
      type(integration_options_t), intent(in) :: options
      real(wp), intent(in) :: t_end
      type(integration_result_t), intent(out) :: result
      type(sampler_t), intent(inout) :: sampler
      character(:), allocatable, intent(inout) :: failure
      type(state_t), intent(inout) :: at
      type(helicopter_t) :: model
      type(method_t) :: method
      type(error_t), allocatable :: error

      call new_helicopter(model, data, error)
      call no_error(failure, error)
      if (allocated(error)) return
      if (.not. allocated(at%x)) at%x = [0.0_wp, 0.0_wp]
      if (.not. allocated(at%v)) at%v = [0.0_wp, 0.0_wp]
      method%name = name
      call simulate(model, at, t_end, result, error, method, options, sampler)
      call no_error(failure, error)
      call check(failure, result%status == status_reached_end, name//': the end is reached')
   end subroutine fly

   !> All of B moves.
   function tilting() result(data)
      type(helicopter_data_t) :: data

      data%b_mean = [0.27_wp, 0.17_wp, -0.12_wp]
      data%b_cosine = [0.01_wp, -0.02_wp, 0.03_wp]
      data%b_sine = [-0.015_wp, 0.005_wp, 0.02_wp]
   end function tilting

end module blades
