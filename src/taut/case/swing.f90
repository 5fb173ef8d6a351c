!> Case files of the swing.
module taut_case_swing
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise
   use taut_case_namelist_file, only: namelist_file_t, group_t
   use taut_case_settings, only: settings_t, read_settings, shared_groups
   use taut_constrained_system, only: state_t
   use taut_constrained_system_tables, only: tabulated_system_t
   use taut_model_swing, only: new_swing_beam, new_swing_modal, swing_beam_t, swing_data_t, swing_modal_t
   implicit none (type, external)
   private
   public :: read_swing

   !> Largest number of modes in a case file.
   integer, parameter :: most_modes = 50

   !> A model of the swing as a case file has it.
   type :: choice_t
      character(len=32) :: model = 'beam'
      integer :: modes(most_modes) = 0
      type(swing_data_t) :: data
   end type choice_t

contains

   !> Reads a case file; what it leaves out has the values of Sect. 4.2.
   subroutine read_swing(file, model, start, settings, error)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> The swing.
      class(tabulated_system_t), allocatable, intent(out) :: model
      !> Initial state: at rest, undeformed.
      type(state_t), intent(out) :: start
      !> Tolerances and methods.
      type(settings_t), intent(out) :: settings
      !> What is wrong with the file.
      type(error_t), allocatable, intent(inout) :: error
      type(choice_t) :: choice
      integer :: i

      call file%only_groups([character(len=11) :: 'swing', shared_groups], error, many=['method'])
      if (allocated(error)) return
      do i = 1, size(file%groups)
         if (file%groups(i)%name /= 'swing') cycle
         call read_choice(file, file%groups(i), choice, error)
         if (allocated(error)) return
         call build(choice, model, start, error)
         call file%locate(file%groups(i), error)
      end do
      if (.not. allocated(model) .and. .not. allocated(error)) call build(choice, model, start, error)
      if (allocated(error)) return
      call read_settings(file, settings, error)
   end subroutine read_swing

   !> The system and its state at rest.
   subroutine build(choice, model, start, error)
      type(choice_t), intent(in) :: choice
      class(tabulated_system_t), allocatable, intent(out) :: model
      type(state_t), intent(out) :: start
      type(error_t), allocatable, intent(inout) :: error
      type(swing_beam_t), allocatable :: beam
      type(swing_modal_t), allocatable :: modal

      select case (choice%model)
      case ('beam')
         if (any(choice%modes /= 0)) then
            call raise(error, 'swing', 'modes are named for model = "beam"', 'leave them out, or use model = "modal"')
            return
         end if
         allocate (beam)
         call new_swing_beam(beam, choice%data, error)
         if (allocated(error)) return
         start = beam%reference_state()
         call move_alloc(beam, model)
      case ('modal')
         allocate (modal)
         call new_swing_modal(modal, choice%data, choice%modes(:findloc(choice%modes /= 0, .true., 1, back=.true.)), error)
         if (allocated(error)) return
         allocate (start%x(modal%n_x), start%v(modal%n), start%w(0), source=0.0_wp)
         start%x(4) = 1.0_wp
         call move_alloc(modal, model)
      case default
         call raise(error, 'swing', 'model = "'//trim(choice%model)//'" is unknown', 'use "beam" or "modal"')
      end select
   end subroutine build

   !> &swing.
   subroutine read_choice(file, group, choice, error)
      type(namelist_file_t), intent(in) :: file
      type(group_t), intent(in) :: group
      type(choice_t), intent(inout) :: choice
      type(error_t), allocatable, intent(inout) :: error
      character(*), parameter :: names = 'model, modes, elements, length, thickness, width, young, poisson, density, '// &
                                 'mid_mass, link_1, link_2, force, times, gravity, damping'
      character(len=len(choice%model)) :: model
      integer :: modes(most_modes), elements, i, status
      real(wp) :: length, thickness, width, young, poisson, density, mid_mass, link_1, link_2, force(3), times(3), &
                  gravity(3), damping
      character(len=200) :: message
      namelist /swing/ model, modes, elements, length, thickness, width, young, poisson, density, mid_mass, link_1, link_2, &
         force, times, gravity, damping

      model = choice%model
      modes = choice%modes
      associate (data => choice%data)
         elements = data%elements
         length = data%length
         thickness = data%thickness
         width = data%width
         young = data%young
         poisson = data%poisson
         density = data%density
         mid_mass = data%mid_mass
         link_1 = data%link_1
         link_2 = data%link_2
         force = data%force
         times = data%times
         gravity = data%gravity
         damping = data%damping
      end associate
      do i = 1, size(group%entries)
         read (group%entries(i)%text, nml=swing, iostat=status, iomsg=message)
         if (status /= 0) call file%complain(group, i, message, names, error)
      end do
      choice = choice_t(model, modes, swing_data_t(elements, length, thickness, width, young, poisson, density, mid_mass, &
                                                   link_1, link_2, force, times, gravity, damping))
   end subroutine read_choice

end module taut_case_swing
