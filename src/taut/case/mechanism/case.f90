!> Mechanisms as a kind of case file.
module taut_case_mechanism_case
   use taut_error, only: error_t, raise
   use taut_case_group, only: declared_t
   use taut_case_kind, only: case_kind_t
   use taut_case_mechanism, only: declare_mechanism, read_mechanism
   use taut_case_mechanism_analysis, only: analysis_t, read_analysis
   use taut_case_mechanism_geometry, only: write_geometry
   use taut_case_namelist_file, only: namelist_file_t
   use taut_case_settings, only: settings_t
   use taut_constrained_system, only: state_t
   use taut_constrained_system_tables, only: tabulated_system_t
   use taut_model_mechanism, only: mechanism_t
   use taut_model_mechanism_report, only: mechanism_report_t
   implicit none (type, external)
   private
   public :: mechanism_case_t

   !> Case files of mechanisms.
   type, extends(case_kind_t) :: mechanism_case_t
   contains
      procedure :: declare
      procedure :: read => read_case
      procedure :: write_beside
   end type mechanism_case_t

contains

   !> Its groups.
   subroutine declare(self, groups)
      !> The kind.
      class(mechanism_case_t), intent(in) :: self
      !> The groups.
      type(declared_t), allocatable, intent(out) :: groups(:)

      associate (unused_kind => self)
      end associate
      call declare_mechanism(groups)
   end subroutine declare

   !> A case file's mechanism, as a system.
   subroutine read_case(self, file, model, start, settings, error)
      !> The kind.
      class(mechanism_case_t), intent(in) :: self
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> The mechanism.
      class(tabulated_system_t), allocatable, intent(out) :: model
      !> Initial state, assembled.
      type(state_t), intent(out) :: start
      !> Tolerances and methods.
      type(settings_t), intent(out) :: settings
      !> What is wrong with the file.
      type(error_t), allocatable, intent(inout) :: error
      type(mechanism_report_t) :: report
      type(analysis_t) :: analysis
      type(mechanism_t), allocatable :: own

      associate (unused_kind => self)
      end associate
      call read_analysis(file, analysis, error)
      if (.not. allocated(error) .and. analysis%kind /= 'dynamics') &
         call raise(error, file%path, 'nothing moves where &analysis asks for '//trim(analysis%kind), &
                    'run the case alone, or ask for "dynamics"')
      if (allocated(error)) return
      allocate (own)
      call read_mechanism(file, own, start, settings, report, error)
      if (.not. allocated(error)) call move_alloc(own, model)
   end subroutine read_case

   !> Where everything is, for pictures.
   subroutine write_beside(self, file, model, folder, error)
      !> The kind.
      class(mechanism_case_t), intent(in) :: self
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> Its mechanism.
      class(tabulated_system_t), intent(in) :: model
      !> The folder of its results.
      character(*), intent(in) :: folder
      !> A file that cannot be written.
      type(error_t), allocatable, intent(inout) :: error

      associate (unused_kind => self)
      end associate
      select type (model)
      type is (mechanism_t)
         call write_geometry(file, model, 'dynamics', folder, error)
      end select
   end subroutine write_beside

end module taut_case_mechanism_case
