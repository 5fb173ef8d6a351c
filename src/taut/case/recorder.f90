!> The observer that writes a method's CSV file and gathers its row of the summary.
module taut_case_recorder
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_case_csv, only: csv_t, number_text
   use taut_case_progress, only: progress_t
   use taut_constrained_formulation, only: constrained_ode_t, sample_t
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_ode_observer, only: observer_t
   use taut_ode_system, only: ode_system_t, rhs_ok
   implicit none (type, external)
   private
   public :: recorder_t

   !> Writes every output point as one line.
   type, extends(observer_t) :: recorder_t
      !> Largest violations at the written points.
      real(wp) :: max_phi = 0.0_wp, max_phidot = 0.0_wp, max_phiddot = 0.0_wp
      !> Energy at the last written point less that at the first [J].
      real(wp) :: energy_drift = 0.0_wp
      !> Smallest rank of A at the written points.
      integer :: min_rank = huge(1)
      !> Number of written points.
      integer :: points = 0
      !> The file.
      type(csv_t) :: csv
      !> The progress line.
      type(progress_t) :: progress
      real(wp), private :: t_start = 0.0_wp, t_end = 1.0_wp, first_energy = 0.0_wp
      type(sample_t), private :: sample
      character(:), allocatable, private :: line
      integer, private :: used = 0
   contains
      procedure :: create
      procedure :: prepare
      procedure :: observe
      procedure :: store
   end type recorder_t

contains

   !> Opens the file and writes its header.
   subroutine create(self, path, model, t_start, t_end, error)
      !> The recorder.
      class(recorder_t), intent(inout) :: self
      !> Path of the CSV file.
      character(*), intent(in) :: path
      !> The system, for the names of its coordinates.
      class(mechanical_system_t), intent(in) :: model
      !> Start and end, for the progress line [s].
      real(wp), intent(in) :: t_start, t_end
      !> A file that cannot be written.
      type(error_t), allocatable, intent(inout) :: error
      character(:), allocatable :: header
      integer :: i

      call self%prepare(model, t_start, t_end)
      header = 't,h'
      do i = 1, model%n_x
         header = header//','//model%x_name(i)
      end do
      do i = 1, model%n
         header = header//','//model%v_name(i)
      end do
      do i = 1, model%n_w
         header = header//',w'//to_text(i)
      end do
      header = header//',phi,phidot,phiddot,phi_raw,phidot_raw,energy'// &
               numbered('mu', model%c)//numbered('lambda', model%c)//',rank'
      do i = 1, model%n_outputs
         header = header//','//model%output_name(i)
      end do
      call self%csv%create(path, error)
      if (.not. allocated(error)) call self%csv%put(header, error)
   end subroutine create

   !> Gets ready without a file, for `store` to restore one.
   subroutine prepare(self, model, t_start, t_end)
      !> The recorder.
      class(recorder_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Start and end, for the progress line [s].
      real(wp), intent(in) :: t_start, t_end

      self%t_start = t_start
      self%t_end = t_end
      allocate (character(len=25*(9 + model%n_x + model%n + model%n_w + 2*model%c + model%n_outputs)) :: self%line)
   end subroutine prepare

   !> Passes what was gathered so far, and the file, through an archive.
   subroutine store(self, archive, folder, error)
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
      call archive%item('energy drift', self%energy_drift)
      call archive%item('first energy', self%first_energy)
      call archive%item('smallest rank', self%min_rank)
      call archive%item('points', self%points)
      call self%csv%store(archive, folder, error)
   end subroutine store

   !> Column names: one without a number if there is only one.
   pure function numbered(name, count) result(text)
      character(*), intent(in) :: name
      integer, intent(in) :: count
      character(:), allocatable :: text
      integer :: i

      text = ''
      if (count == 1) text = ','//name
      if (count < 2) return
      do i = 1, count
         text = text//','//name//to_text(i)
      end do
   end function numbered

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
      integer :: i, info
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
      class default
         call raise(error, 'output', 'only constrained systems can be recorded', 'use another observer')
         return
      end select

      self%used = 0
      call add(self, t)
      call add(self, h)
      do i = 1, size(y)
         call add(self, y(i))
      end do
      associate (s => self%sample)
         call add(self, s%phi)
         call add(self, s%phidot)
         call add(self, s%phiddot)
         call add(self, s%phi_raw)
         call add(self, s%phidot_raw)
         call add(self, s%energy)
         do i = 1, size(s%mu)
            call add(self, s%mu(i))
         end do
         do i = 1, size(s%lambda)
            call add(self, s%lambda(i))
         end do
         call add_text(self, to_text(s%rank))
         do i = 1, size(s%outputs)
            call add(self, s%outputs(i))
         end do
         call self%csv%put(self%line(1:self%used - 1), error)
         if (self%points == 0) self%first_energy = s%energy
         self%points = self%points + 1
         self%energy_drift = s%energy - self%first_energy
         self%max_phi = max(self%max_phi, s%phi)
         self%max_phidot = max(self%max_phidot, s%phidot)
         self%max_phiddot = max(self%max_phiddot, s%phiddot)
         self%min_rank = min(self%min_rank, s%rank)
      end associate
      call self%progress%update(abs(t - self%t_start)/max(abs(self%t_end - self%t_start), tiny(1.0_wp)))
   end subroutine observe

   !> Appends a number and a comma to the line, without leading blanks.
   subroutine add(self, value)
      type(recorder_t), intent(inout) :: self
      real(wp), intent(in) :: value
      character(len=24) :: text
      integer :: first

      text = number_text(value)
      first = verify(text, ' ')
      call add_text(self, text(first:))
   end subroutine add

   !> Appends a text and a comma to the line.
   subroutine add_text(self, text)
      type(recorder_t), intent(inout) :: self
      character(*), intent(in) :: text

      self%line(self%used + 1:self%used + len(text) + 1) = text//','
      self%used = self%used + len(text) + 1
   end subroutine add_text

end module taut_case_recorder
