!> Case files of the chain.
module taut_case_chain
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise
   use taut_case_namelist_file, only: namelist_file_t
   use taut_case_settings, only: settings_t, read_settings, shared_groups
   use taut_constrained_system, only: state_t
   use taut_model_chain, only: chain_t, new_chain
   implicit none (type, external)
   private
   public :: read_chain

   real(wp), parameter :: degree = acos(-1.0_wp)/180.0_wp

contains

   !> Reads a case file.
   subroutine read_chain(file, model, start, settings, error)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> The chain.
      type(chain_t), intent(out) :: model
      !> Initial state: straight, at rest.
      type(state_t), intent(out) :: start
      !> Tolerances and methods.
      type(settings_t), intent(out) :: settings
      !> What is wrong with the file.
      type(error_t), allocatable, intent(inout) :: error
      character(*), parameter :: names = 'rods, mass, length, gravity, angle'
      real(wp) :: mass, length, gravity, angle
      integer :: rods, i, j, status
      character(len=200) :: message
      namelist /chain/ rods, mass, length, gravity, angle

      rods = 10
      mass = 1.0_wp
      length = 1.0_wp
      gravity = 9.81_wp
      angle = 0.0_wp
      call file%only_groups([character(len=11) :: 'chain', shared_groups], error, many=['method'])
      if (allocated(error)) return
      do i = 1, size(file%groups)
         if (file%groups(i)%name /= 'chain') cycle
         do j = 1, size(file%groups(i)%entries)
            read (file%groups(i)%entries(j)%text, nml=chain, iostat=status, iomsg=message)
            if (status /= 0) call file%complain(file%groups(i), j, message, names, error)
         end do
         if (allocated(error)) return
         call new_chain(model, rods, mass, length, gravity, error)
         if (.not. abs(angle) <= 360.0_wp) &
            call raise(error, 'chain', 'angle is not between -360 and 360', 'give degrees below the horizontal')
         call file%locate(file%groups(i), error)
      end do
      if (.not. allocated(error) .and. model%n == 0) call new_chain(model, rods, mass, length, gravity, error)
      if (allocated(error)) return
      call model%start(angle*degree, start)
      call read_settings(file, settings, error)
   end subroutine read_chain

end module taut_case_chain
