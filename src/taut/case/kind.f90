!> A kind of case file: the groups that it may have, and the system that they make.
module taut_case_kind
   use taut_error, only: error_t
   use taut_case_group, only: declared_t
   use taut_case_namelist_file, only: namelist_file_t
   use taut_case_settings, only: settings_t
   use taut_constrained_system, only: state_t
   use taut_constrained_system_tables, only: tabulated_system_t
   implicit none (type, external)
   private
   public :: case_kind_t

   !> What an app knows of its case files.
   type, abstract :: case_kind_t
      !> The groups as they are declared, once if many cases are read.
      type(declared_t), allocatable :: known(:)
   contains
      procedure(declared_groups), deferred :: declare
      procedure(read_case), deferred :: read
      procedure :: write_beside
   end type case_kind_t

   abstract interface
      !> The groups as they are declared.
      subroutine declared_groups(self, groups)
         import :: case_kind_t, declared_t
         implicit none (type, external)
         !> The kind.
         class(case_kind_t), intent(in) :: self
         !> Those that a case file may have.
         type(declared_t), allocatable, intent(out) :: groups(:)
      end subroutine declared_groups

      !> Makes a system of a case file.
      subroutine read_case(self, file, model, start, settings, error)
         import :: case_kind_t, error_t, namelist_file_t, settings_t, state_t, tabulated_system_t
         implicit none (type, external)
         !> The kind.
         class(case_kind_t), intent(in) :: self
         !> The case file.
         type(namelist_file_t), intent(in) :: file
         !> The system.
         class(tabulated_system_t), allocatable, intent(out) :: model
         !> Initial state as given.
         type(state_t), intent(out) :: start
         !> Tolerances and methods.
         type(settings_t), intent(out) :: settings
         !> What is wrong with the file.
         type(error_t), allocatable, intent(inout) :: error
      end subroutine read_case
   end interface

contains

   !> Writes what belongs to the results of a case besides what its methods give: nothing, unless a kind has something.
   subroutine write_beside(self, file, model, folder, error)
      !> The kind.
      class(case_kind_t), intent(in) :: self
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> Its system.
      class(tabulated_system_t), intent(in) :: model
      !> The folder of its results, which is there.
      character(*), intent(in) :: folder
      !> A file that cannot be written.
      type(error_t), allocatable, intent(inout) :: error

      associate (unused_kind => self, unused_file => file, unused_model => model, unused_folder => folder, unused_error => error)
      end associate
   end subroutine write_beside

end module taut_case_kind
