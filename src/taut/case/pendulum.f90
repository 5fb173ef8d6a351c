!> Case files of the pendulum.
module taut_case_pendulum
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise
   use taut_case_namelist_file, only: namelist_file_t
   use taut_case_settings, only: settings_t, read_settings, shared_groups
   use taut_constrained_system, only: state_t
   use taut_model_pendulum, only: pendulum_t, new_pendulum
   implicit none (type, external)
   private
   public :: read_pendulum

contains

   !> Reads a case file; what it leaves out has the values of Sect. 4.1.
   subroutine read_pendulum(file, model, start, settings, error)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> The pendulum.
      type(pendulum_t), intent(out) :: model
      !> Initial state as given.
      type(state_t), intent(out) :: start
      !> Tolerances and methods.
      type(settings_t), intent(out) :: settings
      !> What is wrong with the file.
      type(error_t), allocatable, intent(inout) :: error
      character(*), parameter :: names = 'mass, length, gravity, constraint_copies, position, velocity'
      real(wp) :: mass, length, gravity, position(2), velocity(2)
      integer :: constraint_copies, i, j, status
      character(len=200) :: message
      namelist /pendulum/ mass, length, gravity, constraint_copies, position, velocity

      mass = 1.0_wp
      length = 1.0_wp
      gravity = 9.81_wp
      constraint_copies = 1
      position = [1.0_wp, 0.0_wp]
      velocity = 0.0_wp
      call file%only_groups([character(len=11) :: 'pendulum', shared_groups], error, many=['method'])
      if (allocated(error)) return
      do i = 1, size(file%groups)
         if (file%groups(i)%name /= 'pendulum') cycle
         do j = 1, size(file%groups(i)%entries)
            read (file%groups(i)%entries(j)%text, nml=pendulum, iostat=status, iomsg=message)
            if (status /= 0) call file%complain(file%groups(i), j, message, names, error)
         end do
         if (allocated(error)) return
         call new_pendulum(model, mass, length, gravity, constraint_copies, error)
         if (.not. all(abs([position, velocity]) <= huge(1.0_wp))) &
            call raise(error, 'pendulum', 'position or velocity is not a number', 'give metres and metres per second')
         call file%locate(file%groups(i), error)
      end do
      if (model%n == 0) call new_pendulum(model, mass, length, gravity, constraint_copies, error)
      if (allocated(error)) return
      allocate (start%w(0))
      start%x = position
      start%v = velocity
      call read_settings(file, settings, error)
   end subroutine read_pendulum

end module taut_case_pendulum
