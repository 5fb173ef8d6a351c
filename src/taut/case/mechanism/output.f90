!> &output of a mechanism.
module taut_case_mechanism_output
   use taut_case_entries, only: entries_t
   use taut_case_settings, only: longest_name, output_group_t
   implicit none (type, external)
   private
   public :: mechanism_output_t

   !> What all models have, the joints whose reactions are written, and the springs.
   type, extends(output_group_t) :: mechanism_output_t
      !> Names; `all` or `none` alone; not allocated for all.
      character(len=longest_name), allocatable :: joints(:)
      !> Names of springs, dampers and bushings; `all` alone; not allocated for none.
      character(len=longest_name), allocatable :: springs(:)
   contains
      procedure :: declare
   end type mechanism_output_t

   integer, parameter :: most_names = 100000

contains

   !> Its entries.
   subroutine declare(self, entries)
      !> What the group says.
      class(mechanism_output_t), intent(inout) :: self
      !> What passes over them.
      type(entries_t), intent(inout) :: entries

      call self%output_group_t%declare(entries)
      call entries%option('joints', self%joints, 'joints whose reactions are written: names, "all" or "none"; without: all', &
                          most_names)
      call entries%option('springs', self%springs, 'springs and dampers whose force and length, about a joint moment and '// &
                          'angle, and bushings whose force and moment are written: names, or "all"; without: none', most_names)
   end subroutine declare

end module taut_case_mechanism_output
