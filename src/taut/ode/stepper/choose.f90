!> Which stepper an integration takes, by name: the one place where steppers are told apart.
module taut_ode_stepper_choose
   use taut_error, only: error_t, raise
   use taut_ode_stepper, only: stepper_t
   use taut_ode_stepper_dop853, only: dop853_t
   use taut_ode_stepper_dormand_prince, only: dormand_prince_t
   use taut_ode_stepper_radau, only: radau_t
   implicit none (type, external)
   private
   public :: choose_stepper, integrator_names, refuse_name

   !> All of them.
   character(len=16), parameter :: integrator_names(*) = [character(len=16) :: 'dopri5', 'dop853', 'radau']

contains

   !> The stepper of a name.
   subroutine choose_stepper(name, stepper, error)
      !> One of `integrator_names`, may be padded.
      character(*), intent(in) :: name
      !> The stepper, to be initialized; not allocated if there is none of that name.
      class(stepper_t), allocatable, intent(out) :: stepper
      !> A name that is unknown.
      type(error_t), allocatable, intent(inout) :: error

      select case (name)
      case ('dopri5')
         allocate (dormand_prince_t :: stepper)
      case ('dop853')
         allocate (dop853_t :: stepper)
      case ('radau')
         allocate (radau_t :: stepper)
      case default
         call refuse_name(name, integrator_names, error)
         return
      end select
      stepper%name = name
   end subroutine choose_stepper

   !> A name that is none of those that are known.
   subroutine refuse_name(name, known, error)
      !> The name.
      character(*), intent(in) :: name
      !> Those that are.
      character(*), intent(in) :: known(:)
      !> Says so.
      type(error_t), allocatable, intent(inout) :: error
      character(:), allocatable :: list
      integer :: i

      list = ''
      do i = 1, size(known)
         list = list//', "'//trim(known(i))//'"'
      end do
      call raise(error, 'integration options', 'integrator = "'//trim(name)//'" is unknown', 'use one of '//list(3:))
   end subroutine refuse_name

end module taut_ode_stepper_choose
