!> What an integration is asked for and what it answers.
module taut_ode_options
   use taut_kinds, only: wp
   use taut_archive, only: archive_t
   use taut_error, only: error_t, raise, to_text
   use taut_ode_event, only: event_record_t
   use taut_ode_note, only: note_t
   use taut_ode_status, only: status_not_started
   implicit none (type, external)
   private
   public :: integration_options_t, integration_result_t

   !> How to integrate; every entry has a default.
   type :: integration_options_t
      !> Stepper: one of `integrator_names`; `dopri5` is the pair of order 5(4) of Dormand and Prince.
      character(len=24) :: integrator = 'dopri5'
      !> `generalized-alpha`: what is left per step of an oscillation whose period is short against the step, 0 to 1.
      real(wp) :: spectral_radius = 0.8_wp
      !> Relative tolerance.
      real(wp) :: rtol = 1.0e-6_wp
      !> Absolute tolerance, in the unit of each component.
      real(wp) :: atol = 1.0e-9_wp
      !> Absolute tolerances of single components: (n); takes the place of `atol` where allocated.
      real(wp), allocatable :: atol_of(:)
      !> First step [s]; 0 for an automatic one.
      real(wp) :: first_step = 0.0_wp
      !> Largest step [s]; the last one before an end or a breakpoint may be longer by 1 %.
      real(wp) :: max_step = huge(1.0_wp)
      !> Smallest step [s]; ten units of round-off of the time if that is more.
      real(wp) :: min_step = 0.0_wp
      !> Largest number of steps, rejected ones included.
      integer :: max_steps = 100000000
      !> Step-size controller: `standard`, `fixed` (steps of `first_step`) or `odepkg-2009`.
      character(len=16) :: step_control = 'standard'
      !> Error norm of the standard controller: `rms` or `max`.
      character(len=8) :: norm = 'rms'
      !> Time between output points [s]; 0 for every step.
      real(wp) :: output_dt = 0.0_wp
      !> Times of the output points [s], in the order in which they are met; takes the place of `output_dt` where allocated. There
      !! are no others then, neither at the start nor at the end.
      real(wp), allocatable :: output_times(:)
      !> A step whose projection bends is rejected, for it may end on another branch: if what follows its first correction
      !! moves the coordinates by more than this, in units of the tolerance (standard controller only).
      real(wp) :: projection_limit = 1.0e-5_wp
   contains
      procedure :: check
   end type integration_options_t

   !> How it went.
   type :: integration_result_t
      !> One of the `status_` constants.
      integer :: status = status_not_started
      !> Time reached [s].
      real(wp) :: t = 0.0_wp
      !> Accepted steps.
      integer :: steps = 0
      !> Rejected tries.
      integer :: rejected = 0
      !> Evaluations of the right-hand side, rejected tries and the automatic first step included; those of output are
      !! not, unless the stepper's continuous extension needs them.
      integer :: rhs_evaluations = 0
      !> Linearizations, factorizations and Newton iterations of an implicit stepper.
      integer :: jacobians = 0, factorizations = 0, newton_iterations = 0
      !> Events met, in order of time.
      type(event_record_t), allocatable :: events(:)
      !> What else is to be said, in order of time.
      type(note_t), allocatable :: notes(:)
      !> Why it ended before its time, in words.
      type(error_t), allocatable :: error
   contains
      procedure :: serialize
   end type integration_result_t

contains

   !> Whether the steps and the output make sense; tolerances and names are the step control's matter.
   subroutine check(self, error)
      !> The options.
      class(integration_options_t), intent(in) :: self
      !> What does not.
      type(error_t), allocatable, intent(inout) :: error
      character(*), parameter :: here = 'integration options'

      if (.not. self%max_step > 0.0_wp) &
         call raise(error, here, 'max_step = '//to_text(self%max_step)//' is not positive', 'give a time in seconds')
      if (.not. self%min_step >= 0.0_wp) &
         call raise(error, here, 'min_step = '//to_text(self%min_step)//' is negative', 'give a time in seconds, or 0')
      if (.not. self%first_step >= 0.0_wp) &
         call raise(error, here, 'first_step = '//to_text(self%first_step)//' is negative', &
                    'give a time in seconds, or 0 for an automatic one')
      if (self%step_control == 'fixed' .and. .not. self%first_step > 0.0_wp) &
         call raise(error, here, 'step_control = "fixed" without a step', 'set first_step to its length in seconds')
      if (self%step_control == 'odepkg-2009' .and. any(self%integrator == [character(len=24) :: 'radau', 'generalized-alpha'])) &
         call raise(error, here, 'step_control = "odepkg-2009" with integrator = "'//trim(self%integrator)//'"', &
                    'use "standard" or "fixed": that test is of Dormand and Prince''s formulas')
      if (self%max_steps < 1) &
         call raise(error, here, 'max_steps = '//to_text(self%max_steps)//' is not positive', 'give a number of steps')
      if (.not. self%output_dt >= 0.0_wp) &
         call raise(error, here, 'output_dt = '//to_text(self%output_dt)//' is negative', &
                    'give a time in seconds, or 0 for every step')
      if (self%min_step > self%max_step) &
         call raise(error, here, 'min_step is larger than max_step', 'exchange them')
      if (self%first_step > 0.0_wp .and. self%first_step < self%min_step) &
         call raise(error, here, 'first_step is smaller than min_step', 'give a longer one, or 0 for an automatic one')
      if (self%step_control == 'fixed' .and. self%first_step > self%max_step) &
         call raise(error, here, 'step_control = "fixed" with first_step longer than max_step', 'leave max_step out')
      if (.not. self%projection_limit > 0.0_wp) &
         call raise(error, here, 'projection_limit = '//to_text(self%projection_limit)//' is not positive', &
                    'give a number of tolerances such as 1e-5')
   end subroutine check

   !> Passes the counts and the events so far through an archive.
   subroutine serialize(self, archive)
      !> The result of an integration that is interrupted.
      class(integration_result_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive
      integer :: count, i, noted

      call archive%item('status', self%status)
      call archive%item('time reached', self%t)
      call archive%item('steps', self%steps)
      call archive%item('rejected', self%rejected)
      call archive%item('rhs evaluations', self%rhs_evaluations)
      call archive%item('jacobians', self%jacobians)
      call archive%item('factorizations', self%factorizations)
      call archive%item('newton iterations', self%newton_iterations)
      count = 0
      if (allocated(self%events)) count = size(self%events)
      call archive%number('events', count)
      if (allocated(archive%error)) return
      if (archive%reading) then
         if (allocated(self%events)) deallocate (self%events)
         allocate (self%events(count))
      end if
      noted = 0
      if (allocated(self%notes)) noted = size(self%notes)
      call archive%number('notes', noted)
      if (allocated(archive%error)) return
      if (archive%reading) self%notes = [(note_t(), i=1, noted)]
      do i = 1, noted
         call archive%item('note', self%notes(i)%code)
         call archive%item('note time', self%notes(i)%t)
      end do
      do i = 1, count
         call archive%item('event', self%events(i)%index)
         call archive%item('event time', self%events(i)%t)
         call archive%list('event state', self%events(i)%y)
      end do
   end subroutine serialize

end module taut_ode_options
