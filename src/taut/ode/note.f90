!> What is to be said of an integration that is no error.
module taut_ode_note
   use taut_kinds, only: wp
   use taut_error, only: to_text
   implicit none (type, external)
   private
   public :: note_t, note_bound_by_stability, note_no_time, note_no_progress

   !> Steps are as long as stability allows, not accuracy; the end is where it began; steps do not get on, though the
   !! derivatives are right.
   integer, parameter :: note_bound_by_stability = 1, note_no_time = 2, note_no_progress = 3

   !> One thing.
   type :: note_t
      !> One of the `note_` constants.
      integer :: code = 0
      !> Time at which it was found [s].
      real(wp) :: t = 0.0_wp
   contains
      procedure :: text
   end type note_t

contains

   !> The note in words, padded with blanks.
   pure function padded(self) result(text)
      class(note_t), intent(in) :: self
      character(len=200) :: text

      select case (self%code)
      case (note_bound_by_stability)
         text = 'from t = '//to_text(self%t)//' s on steps are bound by stability and not by accuracy: an implicit integrator '// &
                '(radau) would take longer ones'
      case (note_no_time)
         text = 'the state was at t = '//to_text(self%t)//' s: the end already'
      case (note_no_progress)
         text = 'from t = '//to_text(self%t)//' s on steps hardly get on; the derivatives of the constraints are right there: '// &
                'look for constraints that contradict each other or take an implicit integrator if the forces are stiff'
      case default
         text = ''
      end select
   end function padded

   !> The note in words.
   pure function text(self)
      !> The note.
      class(note_t), intent(in) :: self
      !> One line without commas.
      character(len=len_trim(padded(self))) :: text

      text = padded(self)
   end function text

end module taut_ode_note
