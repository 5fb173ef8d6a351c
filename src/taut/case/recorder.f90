!> The observer that writes a method's CSV file and gathers its row of the summary.
module taut_case_recorder
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_case_columns, only: choose_columns, column_name, column_value, rank_column
   use taut_case_csv, only: csv_t
   use taut_case_extremes, only: extremes_t
   use taut_case_progress, only: progress_t
   use taut_case_row, only: row_t
   use taut_case_settings, only: settings_t
   use taut_constrained_balance, only: energy_balance_t
   use taut_constrained_method, only: constrained_ode_t, sample_t
   use taut_constrained_system_tables, only: tabulated_system_t
   use taut_ode_observer, only: observer_t
   use taut_ode_step, only: step_t
   use taut_ode_system, only: ode_system_t, rhs_ok
   implicit none (type, external)
   private
   public :: recorder_t

   !> Writes every output point as one line.
   type, extends(observer_t) :: recorder_t
      !> Largest violations at the written points.
      real(wp) :: max_phi = 0.0_wp, max_phidot = 0.0_wp, max_phiddot = 0.0_wp
      !> Energy and work at the written points.
      type(energy_balance_t) :: balance
      !> Smallest rank of A at the written points.
      integer :: min_rank = huge(1)
      !> Number of written points.
      integer :: points = 0
      !> The file.
      type(csv_t) :: csv
      !> Extremes, and whether those of the system's vectors are among them.
      type(extremes_t) :: extremes
      logical :: of_vectors = .true.
      !> The progress line.
      type(progress_t) :: progress
      real(wp), private :: t_start = 0.0_wp, t_end = 1.0_wp
      type(sample_t), private :: sample
      !> Which columns are written: (columns).
      logical, allocatable, private :: wanted(:)
      !> The column that is an integer, and entries of {x; v; w}.
      integer, private :: rank = 0, states = 0
      type(row_t), private :: row
   contains
      procedure :: create
      procedure :: prepare
      procedure :: observe
      procedure :: follow
      procedure :: serialize
   end type recorder_t

contains

   !> Opens the file and writes its header.
   subroutine create(self, path, model, settings, error)
      !> The recorder.
      class(recorder_t), intent(inout) :: self
      !> Path of the CSV file.
      character(*), intent(in) :: path
      !> The system, for the names of its coordinates.
      class(tabulated_system_t), intent(in) :: model
      !> Columns, extremes and times.
      type(settings_t), intent(in) :: settings
      !> A file that cannot be written, or a column that does not exist.
      type(error_t), allocatable, intent(inout) :: error
      integer :: i

      call self%prepare(model, settings, error)
      if (allocated(error)) return
      call self%csv%create(path, error)
      if (allocated(error)) return
      do i = 1, size(self%wanted)
         if (self%wanted(i)) call self%row%add(trim(column_name(model, i)))
      end do
      call self%csv%put(self%row%letters(:self%row%used), error)
   end subroutine create

   !> Gets ready without a file, for `serialize` to restore one.
   subroutine prepare(self, model, settings, error)
      !> The recorder.
      class(recorder_t), intent(inout) :: self
      !> The system.
      class(tabulated_system_t), intent(in) :: model
      !> Columns, extremes and times.
      type(settings_t), intent(in) :: settings
      !> A column that does not exist.
      type(error_t), allocatable, intent(inout) :: error

      self%t_start = settings%t_start
      self%t_end = settings%t_end
      call choose_columns(model, settings%columns, settings%place_of_columns, self%wanted, error)
      self%rank = rank_column(model)
      self%states = model%n_x + model%n + model%n_w
      if (.not. allocated(error)) call self%extremes%init(model, settings%extremes, self%of_vectors, error)
      self%follows = self%extremes%n > 0
      call self%row%create()
   end subroutine prepare

   !> Looks at a step.
   subroutine follow(self, ode, step, t_last, error)
      !> The recorder.
      class(recorder_t), intent(inout) :: self
      !> The formulation that is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> The step.
      class(step_t), intent(inout) :: step
      !> Its end, or where an event ends it [s].
      real(wp), intent(in) :: t_last
      !> A state that cannot be evaluated.
      type(error_t), allocatable, intent(inout) :: error

      select type (ode)
      class is (constrained_ode_t)
         call self%extremes%follow(ode, step, t_last, error)
      end select
   end subroutine follow

   !> Passes what was gathered so far, and the file, through an archive.
   subroutine serialize(self, archive, folder, error)
      !> The recorder: at work, or prepared.
      class(recorder_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive
      !> The folder of the file.
      character(*), intent(in) :: folder
      !> The file does not arrive on the disk, or is not there any more.
      type(error_t), allocatable, intent(inout) :: error

      call archive%item('largest phi', self%max_phi)
      call archive%item('largest phidot', self%max_phidot)
      call archive%item('largest phiddot', self%max_phiddot)
      call self%balance%serialize(archive)
      call archive%item('smallest rank', self%min_rank)
      call archive%item('points', self%points)
      call self%extremes%serialize(archive)
      call self%csv%serialize(archive, folder, error)
   end subroutine serialize

   !> Writes one point.
   subroutine observe(self, ode, t, h, y, error)
      !> The recorder.
      class(recorder_t), intent(inout) :: self
      !> The formulation that is integrated.
      class(ode_system_t), intent(inout) :: ode
      !> Time [s].
      real(wp), intent(in) :: t
      !> The step [s].
      real(wp), intent(in) :: h
      !> State: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> A state that cannot be evaluated, or a file that cannot be written.
      type(error_t), allocatable, intent(inout) :: error
      integer :: info
      character(:), allocatable :: why

      select type (ode)
      class is (constrained_ode_t)
         call ode%sample(t, y, self%sample, info)
         if (info /= rhs_ok) then
            call ode%failure(why)
            call raise(error, 'output', 'the multipliers at t = '//to_text(t)//' s cannot be computed: '//why, &
                       'tighten the tolerances')
            return
         end if
         call self%balance%see(ode, self%sample)
      class default
         call raise(error, 'output', 'only constrained systems can be recorded', 'use another observer')
         return
      end select

      call self%extremes%see(t, h, y, self%sample)
      if (self%csv%is_open()) call write_point()
      associate (s => self%sample)
         self%points = self%points + 1
         self%max_phi = max(self%max_phi, s%phi)
         self%max_phidot = max(self%max_phidot, s%phidot)
         self%max_phiddot = max(self%max_phiddot, s%phiddot)
         self%min_rank = min(self%min_rank, s%rank)
      end associate
      call self%progress%update(abs(t - self%t_start)/max(abs(self%t_end - self%t_start), tiny(1.0_wp)))

   contains

      !> Writes the row of a point.
      subroutine write_point()
         integer :: i

         call self%row%clear()
         do i = 1, size(self%wanted)
            if (.not. self%wanted(i)) cycle
            if (i == self%rank) then
               call self%row%add(self%sample%rank)
            else
               call self%row%add(column_value(i, self%states, t, h, y, self%sample))
            end if
         end do
         call self%csv%put(self%row%letters(:self%row%used), error)
      end subroutine write_point

   end subroutine observe

end module taut_case_recorder
