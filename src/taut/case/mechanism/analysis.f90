!> The groups &mechanism and &analysis of a mechanism's case file: what holds for all of it.
module taut_case_mechanism_analysis
   use taut_error, only: error_t
   use taut_case_entries, only: entries_t
   use taut_case_group, only: first_group, group_data_t, read_group
   use taut_case_namelist_file, only: namelist_file_t
   implicit none (type, external)
   private
   public :: analysis_t, flags_t, read_analysis, read_flags

   integer, parameter :: most_held = 100

   !> &mechanism.
   type, extends(group_data_t) :: flags_t
      !> Whether every body moves in the plane x-y.
      logical :: planar = .false.
      !> Coordinates that the assembly keeps; not allocated for none.
      character(len=128), allocatable :: hold(:)
   contains
      procedure :: declare => declare_flags
   end type flags_t

   !> &analysis: what is asked for.
   type, extends(group_data_t) :: analysis_t
      !> `dynamics`, `equilibrium`, or `modes` about the equilibrium.
      character(len=11) :: kind = 'dynamics'
      !> Load steps of the equilibrium; modes that are written.
      integer :: steps = 1, number = 10
   contains
      procedure :: declare => declare_analysis
   end type analysis_t

contains

   !> Entries of &mechanism.
   subroutine declare_flags(self, entries)
      !> What the group says.
      class(flags_t), intent(inout) :: self
      !> What passes over them.
      type(entries_t), intent(inout) :: entries

      call entries%group('mechanism', 'what holds for all of it; units are m, kg, s, N and rad, and of a vector what is '// &
                         'missing is zero')
      call entries%item('planar', self%planar, 'whether every body moves in the plane x-y')
      call entries%option('hold', self%hold, 'coordinates that the assembly keeps, and their velocities too: "crank" (all of a '// &
                          'body), "rod.x", "rod.angle" (plane), "rod.orientation" (space)', most_held)
   end subroutine declare_flags

   !> Entries of &analysis.
   subroutine declare_analysis(self, entries)
      !> What the group says.
      class(analysis_t), intent(inout) :: self
      !> What passes over them.
      type(entries_t), intent(inout) :: entries

      call entries%group('analysis', 'what is asked for')
      call entries%item('kind', self%kind, 'a motion, the static equilibrium, or vibration modes about it, with dampers', &
                        [character(len=11) :: 'dynamics', 'equilibrium', 'modes'])
      call entries%item('steps', self%steps, 'steps in which the load of the equilibrium is applied', least=1)
      call entries%item('number', self%number, 'of modes that are written', least=1)
   end subroutine declare_analysis

   !> Reads &mechanism, if it is there.
   subroutine read_flags(file, flags, error)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> What it says.
      type(flags_t), intent(out) :: flags
      !> What is wrong with it.
      type(error_t), allocatable, intent(inout) :: error
      integer :: i

      i = first_group(file, 'mechanism')
      if (i > 0) call read_group(file, file%groups(i), flags, error)
   end subroutine read_flags

   !> Reads &analysis, if it is there.
   subroutine read_analysis(file, analysis, error)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> What is asked for.
      type(analysis_t), intent(out) :: analysis
      !> What is wrong with it.
      type(error_t), allocatable, intent(inout) :: error
      integer :: i

      i = first_group(file, 'analysis')
      if (i > 0) call read_group(file, file%groups(i), analysis, error)
   end subroutine read_analysis

end module taut_case_mechanism_analysis
