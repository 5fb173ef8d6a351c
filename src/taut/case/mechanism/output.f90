!> &output of a mechanism.
module taut_case_mechanism_output
   use taut_case_entries, only: entries_t
   use taut_case_settings, only: longest_name, output_group_t
   implicit none (type, external)
   private
   public :: mechanism_output_t

   !> What all models have, and the joints whose reactions are written.
   type, extends(output_group_t) :: mechanism_output_t
      !> Names; `all` or `none` alone; not allocated for all.
      character(len=longest_name), allocatable :: joints(:)
   contains
      procedure :: declare
   end type mechanism_output_t

   integer, parameter :: most_joints = 100000

contains

   !> Its entries.
   subroutine declare(self, entries)
      !> What the group says.
      class(mechanism_output_t), intent(inout) :: self
      !> What passes over them.
      type(entries_t), intent(inout) :: entries

      call self%output_group_t%declare(entries)
      call entries%option('joints', self%joints, 'joints whose reactions are written: names, "all" or "none"; without: all', &
                          most_joints)
   end subroutine declare

end module taut_case_mechanism_output
