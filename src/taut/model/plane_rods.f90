!> What planar mechanisms of equal rods in a vertical plane have in common.
module taut_model_plane_rods
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_constrained_system_tables, only: name_length, tabulated_system_t
   implicit none (type, external)
   private
   public :: plane_rods_t

   !> A mechanism of rods of one length, x horizontal and z upward.
   type, abstract, extends(tabulated_system_t) :: plane_rods_t
      !> Length of a rod [m].
      real(wp) :: l = 1.0_wp
      !> Gravity, against z [m/s^2].
      real(wp) :: g = 9.81_wp
   contains
      procedure :: set_rods
      procedure :: v_name
   end type plane_rods_t

contains

   !> Takes length and gravity, and looks at the mass.
   subroutine set_rods(self, here, m, l, g, error)
      !> The mechanism.
      class(plane_rods_t), intent(inout) :: self
      !> Its name in messages.
      character(*), intent(in) :: here
      !> Mass of a rod or of a point [kg].
      real(wp), intent(in) :: m
      !> Length of a rod [m].
      real(wp), intent(in) :: l
      !> Gravity [m/s^2].
      real(wp), intent(in) :: g
      !> A value that makes no sense.
      type(error_t), allocatable, intent(inout) :: error

      if (.not. (m > 0.0_wp .and. m <= huge(m))) &
         call raise(error, here, 'mass = '//to_text(m)//' is not positive and finite', 'give a mass in kg')
      if (.not. (l > 0.0_wp .and. l <= huge(l))) &
         call raise(error, here, 'length = '//to_text(l)//' is not positive and finite', 'give a length in m')
      if (.not. abs(g) <= huge(g)) call raise(error, here, 'gravity is not a number', 'give an acceleration in m/s^2')
      self%l = l
      self%g = g
   end subroutine set_rods

   !> That of the coordinate with a v before it.
   function v_name(self, i) result(name)
      !> The mechanism.
      class(plane_rods_t), intent(in) :: self
      !> Index of the velocity.
      integer, intent(in) :: i
      !> Such as vx1.
      character(len=name_length) :: name

      name = 'v'//trim(self%x_name(i))
   end function v_name

end module taut_model_plane_rods
