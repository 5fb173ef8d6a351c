!> The observer that writes a method's CSV file and gathers its row of the summary.
module taut_case_recorder
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_case_csv, only: csv_t
   use taut_case_progress, only: progress_t
   use taut_case_row, only: row_t
   use taut_constrained_balance, only: energy_balance_t
   use taut_constrained_method, only: constrained_ode_t, sample_t
   use taut_constrained_system, only: state_t
   use taut_constrained_system_tables, only: tabulated_system_t
   use taut_ode_observer, only: observer_t
   use taut_ode_system, only: ode_system_t, rhs_ok
   use taut_spelling, only: nearest_name
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
      !> The progress line.
      type(progress_t) :: progress
      real(wp), private :: t_start = 0.0_wp, t_end = 1.0_wp
      type(sample_t), private :: sample
      !> Which columns are written: (columns).
      logical, allocatable, private :: wanted(:)
      type(row_t), private :: row
      integer, private :: column = 0
   contains
      procedure :: create
      procedure :: prepare
      procedure :: observe
      procedure :: serialize
   end type recorder_t

contains

   !> Opens the file and writes its header.
   subroutine create(self, path, model, columns, t_start, t_end, error)
      !> The recorder.
      class(recorder_t), intent(inout) :: self
      !> Path of the CSV file.
      character(*), intent(in) :: path
      !> The system, for the names of its coordinates.
      class(tabulated_system_t), intent(in) :: model
      !> Columns to write besides the time, with * for any characters; blank ones do not count, and none means all.
      character(*), intent(in) :: columns(:)
      !> Start, for the progress line [s].
      real(wp), intent(in) :: t_start
      !> End, for the progress line [s].
      real(wp), intent(in) :: t_end
      !> A file that cannot be written, or a column that does not exist.
      type(error_t), allocatable, intent(inout) :: error
      integer :: i

      call self%prepare(model, columns, t_start, t_end, error)
      if (allocated(error)) return
      call self%csv%create(path, error)
      if (allocated(error)) return
      do i = 1, size(self%wanted)
         if (self%wanted(i)) call self%row%add(column_name(model, i))
      end do
      call self%csv%put(self%row%letters(:self%row%used), error)
   end subroutine create

   !> Gets ready without a file, for `serialize` to restore one.
   subroutine prepare(self, model, columns, t_start, t_end, error)
      !> The recorder.
      class(recorder_t), intent(inout) :: self
      !> The system.
      class(tabulated_system_t), intent(in) :: model
      !> Columns to write besides the time, as in `create`.
      character(*), intent(in) :: columns(:)
      !> Start, for the progress line [s].
      real(wp), intent(in) :: t_start
      !> End, for the progress line [s].
      real(wp), intent(in) :: t_end
      !> A column that does not exist.
      type(error_t), allocatable, intent(inout) :: error
      logical :: met(size(columns))
      character(:), allocatable :: meant, name
      character(len=len(columns)), allocatable :: names(:)
      integer :: i, j

      self%t_start = t_start
      self%t_end = t_end
      allocate (self%wanted(10 + model%n_x + model%n + model%n_w + 2*model%c + model%n_outputs), &
                source=all(columns == ''))
      call self%row%create()
      self%wanted(1) = .true.
      ! The angle that a counter belongs to is among the outputs.
      call leave_out_counters(self, model)
      if (all(columns == '')) return
      met = columns == ''
      do i = 1, size(self%wanted)
         name = column_name(model, i)
         do j = 1, size(columns)
            if (columns(j) == '') cycle
            if (.not. matches(name, trim(columns(j)))) cycle
            met(j) = .true.
            self%wanted(i) = .true.
         end do
      end do
      call leave_out_counters(self, model)
      do j = 1, size(columns)
         if (met(j)) cycle
         if (.not. allocated(names)) allocate (names(size(self%wanted)))
         ! One by one: gfortran 12 does not survive texts of several lengths in a constructor.
         do i = 1, size(self%wanted)
            names(i) = column_name(model, i)
         end do
         meant = trim(nearest_name(columns(j), names))
         if (len(meant) > 0) meant = 'did you mean "'//meant//'"? Or '
         call raise(error, '&output', 'there is no column "'//trim(columns(j))//'"', &
                    meant//'take names from the first line of a result with all columns; * stands for any characters')
      end do
   end subroutine prepare

   !> Coordinates that only count turns are no columns.
   subroutine leave_out_counters(self, model)
      type(recorder_t), intent(inout) :: self
      class(tabulated_system_t), intent(in) :: model

      self%wanted(2 + model%n_x - model%n_counters + 1:2 + model%n_x) = .false.
   end subroutine leave_out_counters

   !> Name of a column; the columns are those of `observe`.
   function column_name(model, i) result(name)
      class(tabulated_system_t), intent(in) :: model
      integer, intent(in) :: i
      character(:), allocatable :: name
      character(len=10), parameter :: violations(7) = [character(len=10) :: 'phi', 'phidot', 'phiddot', 'phi_raw', &
                                                       'phidot_raw', 'energy', 'work']
      integer :: j

      j = i - 2
      if (j < 1) then
         name = merge('t', 'h', i == 1)
         return
      end if
      if (j <= model%n_x) then
         name = trim(model%x_name(j))
         return
      end if
      j = j - model%n_x
      if (j <= model%n) then
         name = trim(model%v_name(j))
         return
      end if
      j = j - model%n
      if (j <= model%n_w) then
         name = 'w'//to_text(j)
         return
      end if
      j = j - model%n_w
      if (j <= size(violations)) then
         name = trim(violations(j))
         return
      end if
      j = j - size(violations)
      if (j <= model%c) then
         name = numbered('mu', j, model%c)
         return
      end if
      j = j - model%c
      if (j <= model%c) then
         name = numbered('lambda', j, model%c)
         return
      end if
      j = j - model%c
      name = 'rank'
      if (j > 1) name = trim(model%output_name(j - 1))
   end function column_name

   !> A name with its number, which is left out if there is only one.
   function numbered(name, i, count) result(text)
      character(*), intent(in) :: name
      integer, intent(in) :: i, count
      character(:), allocatable :: text

      text = name
      if (count > 1) text = name//to_text(i)
   end function numbered

   !> Whether a name is what a pattern says, where * stands for any characters, or none. A star that was met takes one character
   !! more where what follows it does not fit; only the last star is tried anew, which is enough.
   pure function matches(name, pattern) result(answer)
      character(*), intent(in) :: name, pattern
      logical :: answer
      integer :: i, j, star, taken

      i = 1
      j = 1
      star = 0
      taken = 0
      do while (i <= len(name))
         if (j <= len(pattern)) then
            if (pattern(j:j) == '*') then
               star = j
               taken = i
               j = j + 1
               cycle
            else if (pattern(j:j) == name(i:i)) then
               i = i + 1
               j = j + 1
               cycle
            end if
         end if
         answer = star > 0
         if (.not. answer) return
         taken = taken + 1
         i = taken
         j = star + 1
      end do
      answer = verify(pattern(j:), '*') == 0
   end function matches

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

      !> Writes the row of a point; the columns are those of `column_name`.
      subroutine write_point()
         integer :: i

         call self%row%clear()
         self%column = 0
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
            call add(self, s%work)
            do i = 1, size(s%mu)
               call add(self, s%mu(i))
            end do
            do i = 1, size(s%lambda)
               call add(self, s%lambda(i))
            end do
            self%column = self%column + 1
            if (self%wanted(self%column)) call self%row%add(s%rank)
            do i = 1, size(s%outputs)
               call add(self, s%outputs(i))
            end do
            call self%csv%put(self%row%letters(:self%row%used), error)
         end associate
      end subroutine write_point

   end subroutine observe

   !> Appends a number to the row if its column is written.
   subroutine add(self, value)
      type(recorder_t), intent(inout) :: self
      real(wp), intent(in) :: value

      self%column = self%column + 1
      if (self%wanted(self%column)) call self%row%add(value)
   end subroutine add

end module taut_case_recorder
