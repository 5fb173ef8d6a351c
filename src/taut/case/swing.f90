!> Case files of the swing.
module taut_case_swing
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise
   use taut_case_entries, only: entries_t
   use taut_case_model_group, only: model_group_t
   use taut_constrained_system, only: state_t
   use taut_constrained_system_tables, only: tabulated_system_t
   use taut_model_swing, only: new_swing_beam, new_swing_modal, swing_beam_t, swing_data_t, swing_modal_t
   implicit none (type, external)
   private
   public :: swing_group_t

   !> Largest number of modes in a case file.
   integer, parameter :: most_modes = 50

   !> &swing; what it leaves out has the values of Sect. 4.2.
   type, extends(model_group_t) :: swing_group_t
      !> `beam` or `modal`.
      character(:), allocatable :: model
      !> Modes of the modal one, in order; 0 for none.
      integer, allocatable :: modes(:)
      !> The swing.
      type(swing_data_t) :: data
   contains
      procedure :: declare
      procedure :: build
   end type swing_group_t

contains

   !> Its entries.
   subroutine declare(self, entries)
      !> What the group says.
      class(swing_group_t), intent(inout) :: self
      !> What passes over them.
      type(entries_t), intent(inout) :: entries

      if (.not. allocated(self%model)) self%model = 'beam'
      call entries%group('swing', 'a beam on two links with a mass in its middle, on which a force acts')
      call entries%option('model', self%model, 'beam elements, or vibration modes', [character(len=5) :: 'beam', 'modal'])
      call entries%option('modes', self%modes, 'modal: numbers of the modes', most_modes, least=0)
      associate (it => self%data)
         call entries%item('elements', it%elements, 'beam elements, a multiple of four', least=4)
         call entries%item('length', it%length, 'm', 'length of the beam', above=0.0_wp)
         call entries%item('thickness', it%thickness, 'm', 'in the plane', above=0.0_wp)
         call entries%item('width', it%width, 'm', 'across the plane', above=0.0_wp)
         call entries%item('young', it%young, 'Pa', 'Young''s modulus', above=0.0_wp)
         call entries%item('poisson', it%poisson, '', 'Poisson''s ratio')
         call entries%item('density', it%density, 'kg/m^3', 'density', above=0.0_wp)
         call entries%item('mid_mass', it%mid_mass, 'kg', 'mass in the middle', least=0.0_wp)
         call entries%item('link_1', it%link_1, 'm', 'length of the first link', above=0.0_wp)
         call entries%item('link_2', it%link_2, 'm', 'length of the second link', above=0.0_wp)
         call entries%item('force', it%force, 'N', 'force on the middle at its peak')
         call entries%item('times', it%times, 's', 'when the force begins, peaks and ends')
         call entries%item('gravity', it%gravity, 'm/s^2', 'acceleration of gravity')
         call entries%item('damping', it%damping, 's', 'time constant of the beam''s damping', least=0.0_wp)
      end associate
   end subroutine declare

   !> The swing and its state at rest.
   subroutine build(self, model, start, error)
      !> What the group says.
      class(swing_group_t), intent(in) :: self
      !> The swing.
      class(tabulated_system_t), allocatable, intent(out) :: model
      !> Initial state: at rest, undeformed.
      type(state_t), intent(out) :: start
      !> What is wrong with it.
      type(error_t), allocatable, intent(inout) :: error
      type(swing_beam_t), allocatable :: beam
      type(swing_modal_t), allocatable :: modal
      integer, allocatable :: modes(:)

      modes = [integer ::]
      if (allocated(self%modes)) modes = self%modes(:findloc(self%modes /= 0, .true., 1, back=.true.))
      if (self%model == 'modal') then
         allocate (modal)
         call new_swing_modal(modal, self%data, modes, error)
         if (allocated(error)) return
         allocate (start%x(modal%n_x), start%v(modal%n), start%w(0), source=0.0_wp)
         start%x(4) = 1.0_wp
         call move_alloc(modal, model)
      else if (size(modes) > 0) then
         call raise(error, 'swing', 'modes are named for model = "beam"', 'leave them out, or use model = "modal"')
      else
         allocate (beam)
         call new_swing_beam(beam, self%data, error)
         if (allocated(error)) return
         start = beam%reference_state()
         call move_alloc(beam, model)
      end if
   end subroutine build

end module taut_case_swing
