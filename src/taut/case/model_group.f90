!> Case files whose model is one group: what the apps of the paper's examples share.
module taut_case_model_group
   use taut_error, only: error_t
   use taut_case_group, only: check_groups, declare_group, declared_t, first_group, group_data_t, read_group
   use taut_case_kind, only: case_kind_t
   use taut_case_namelist_file, only: namelist_file_t
   use taut_case_settings, only: declare_shared, read_settings, settings_t
   use taut_constrained_system, only: state_t
   use taut_constrained_system_tables, only: tabulated_system_t
   implicit none (type, external)
   private
   public :: model_group_t, model_case_t

   !> A group that says all of a model and its start.
   type, abstract, extends(group_data_t) :: model_group_t
   contains
      procedure(build_model), deferred :: build
   end type model_group_t

   !> Case files of such a model.
   type, extends(case_kind_t) :: model_case_t
      !> The model's group with its defaults.
      class(model_group_t), allocatable :: group
   contains
      procedure :: declare
      procedure :: read => read_model
   end type model_case_t

   abstract interface
      !> Makes the system of what was read.
      subroutine build_model(self, model, start, error)
         import :: error_t, model_group_t, state_t, tabulated_system_t
         implicit none (type, external)
         !> What the group says.
         class(model_group_t), intent(in) :: self
         !> The system.
         class(tabulated_system_t), allocatable, intent(out) :: model
         !> Initial state as given.
         type(state_t), intent(out) :: start
         !> What is wrong with it.
         type(error_t), allocatable, intent(inout) :: error
      end subroutine build_model
   end interface

contains

   !> The groups of such a case file.
   subroutine declare(self, groups)
      !> The kind.
      class(model_case_t), intent(in) :: self
      !> The model's and those that all apps share.
      type(declared_t), allocatable, intent(out) :: groups(:)

      call declare_group(groups, self%group)
      call declare_shared(groups)
   end subroutine declare

   !> Reads a case file; what it leaves out has its default.
   subroutine read_model(self, file, model, start, settings, error)
      !> The kind.
      class(model_case_t), intent(in) :: self
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
      type(declared_t), allocatable :: known(:)

      if (allocated(self%known)) then
         call read_known(self, self%known, file, model, start, settings, error)
      else
         call self%declare(known)
         call read_known(self, known, file, model, start, settings, error)
      end if
   end subroutine read_model

   !> Reads a case file of which the groups are known.
   subroutine read_known(self, known, file, model, start, settings, error)
      type(model_case_t), intent(in) :: self
      type(declared_t), intent(in) :: known(:)
      type(namelist_file_t), intent(in) :: file
      class(tabulated_system_t), allocatable, intent(out) :: model
      type(state_t), intent(out) :: start
      type(settings_t), intent(out) :: settings
      type(error_t), allocatable, intent(inout) :: error
      class(model_group_t), allocatable :: own
      integer :: i

      call check_groups(file, known, error)
      if (allocated(error)) return
      allocate (own, source=self%group)
      i = first_group(file, known(1)%name)
      if (i > 0) call read_group(file, file%groups(i), own, error)
      if (allocated(error)) return
      call own%build(model, start, error)
      if (i > 0) call file%locate(file%groups(i), error)
      if (.not. allocated(error)) call read_settings(file, settings, error)
   end subroutine read_known

end module taut_case_model_group
