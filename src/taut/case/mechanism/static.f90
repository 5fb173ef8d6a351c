!> Static equilibrium and vibration modes of mechanisms: `analysis = "equilibrium"` and `"modes"`.
module taut_case_mechanism_static
   use, intrinsic :: iso_fortran_env, only: error_unit
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_case_command_line, only: command_line_t, read_command_line
   use taut_case_csv, only: csv_t
   use taut_case_number, only: number_text
   use taut_case_mechanism_geometry, only: write_geometry
   use taut_case_mechanism, only: read_mechanism
   use taut_case_mechanism_analysis, only: analysis_t, read_analysis
   use taut_case_namelist_file, only: check_names, namelist_file_t
   use taut_case_posix, only: make_folder
   use taut_case_process, only: say
   use taut_case_settings, only: settings_t
   use taut_constrained_equilibrium, only: equilibrium, equilibrium_options_t, equilibrium_result_t
   use taut_constrained_modes, only: eigenmodes, modes_t
   use taut_constrained_system, only: state_t
   use taut_model_mechanism, only: mechanism_t
   use taut_model_mechanism_report, only: mechanism_report_t
   implicit none (type, external)
   private
   public :: run_static_cases, static_t, solve_static

   !> A case, solved.
   type :: static_t
      type(mechanism_t) :: model
      type(analysis_t) :: analysis
      type(mechanism_report_t) :: report
      !> The equilibrium, its multipliers, and modes about it.
      type(state_t) :: at
      type(equilibrium_result_t) :: found
      type(modes_t) :: modes
   end type static_t

contains

   !> Runs the case files of the command line if they ask for statics; otherwise says so and does nothing.
   subroutine run_static_cases(app, default_case, asked, code)
      !> Name of the app.
      character(*), intent(in) :: app
      !> Its default case.
      character(*), intent(in) :: default_case
      !> Whether they were asked for.
      logical, intent(out) :: asked
      !> Exit code: 0, or 1 if something is wrong.
      integer, intent(out) :: code
      type(command_line_t) :: line
      type(namelist_file_t), allocatable :: files(:)
      type(static_t), allocatable :: cases(:)
      type(analysis_t) :: analysis
      type(error_t), allocatable :: error
      integer :: i, static

      asked = .false.
      code = 1
      call read_command_line(app, default_case, line, error)
      ! What is wrong here is told by the application.
      if (allocated(error)) return
      if (line%help .or. line%version .or. line%help_case .or. line%reference .or. allocated(line%runs)) return
      allocate (files(size(line%cases)), cases(size(line%cases)))
      static = 0
      do i = 1, size(files)
         call files(i)%load(line%cases(i)%text, error)
         if (allocated(error)) return
         call read_analysis(files(i), analysis, error)
         if (allocated(error)) then
            asked = .true.
            write (error_unit, '(3a)') app, ': ', error%line()
            return
         end if
         if (analysis%kind /= 'dynamics') static = static + 1
      end do
      if (static == 0) return
      asked = .true.
      if (static < size(files)) &
         call raise(error, 'command line', 'some cases ask for dynamics and some for statics', 'run them apart')
      call check_names(files, error)
      ! Everything is solved before anything is written.
      do i = 1, size(files)
         if (.not. allocated(error)) call solve_static(files(i), cases(i), error)
      end do
      do i = 1, size(files)
         if (.not. allocated(error)) call write_static(files(i), cases(i), line%out, line%quiet, error)
      end do
      if (allocated(error)) then
         write (error_unit, '(3a)') app, ': ', error%line()
      else
         code = 0
      end if
   end subroutine run_static_cases

   !> Reads and solves a case.
   subroutine solve_static(file, case, error)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> What it says and what was found.
      type(static_t), intent(out) :: case
      !> What is wrong, or why there is no equilibrium.
      type(error_t), allocatable, intent(inout) :: error
      type(settings_t) :: settings
      type(equilibrium_options_t) :: options

      call read_analysis(file, case%analysis, error)
      if (allocated(error)) return
      call read_mechanism(file, case%model, case%at, settings, case%report, error)
      if (allocated(error)) return
      options%steps = case%analysis%steps
      call equilibrium(case%model, case%at, case%found, error, options)
      if (case%analysis%kind == 'modes' .and. .not. allocated(error)) &
         call eigenmodes(case%model, case%at, case%modes, error)
      if (allocated(error)) error%where = file%path//': '//error%where
   end subroutine solve_static

   !> Writes `out/<case>/equilibrium.csv` and, of modes, `out/<case>/modes.csv`.
   subroutine write_static(file, case, out, quiet, error)
      type(namelist_file_t), intent(in) :: file
      type(static_t), intent(in) :: case
      character(*), intent(in) :: out
      logical, intent(in) :: quiet
      type(error_t), allocatable, intent(inout) :: error
      type(csv_t) :: modes, table
      character(:), allocatable :: row
      character(len=120) :: line
      real(wp) :: outputs(case%model%n_outputs)
      integer :: i, j, shown

      call make_folder(out//'/'//file%name)
      call write_geometry(file, case%model, case%analysis%kind, out//'/'//file%name, error)
      if (allocated(error)) return
      call table%create(out//'/'//file%name//'/equilibrium.csv', error)
      if (.not. allocated(error)) call table%put('name,value', error)
      do i = 1, case%model%n_x - case%model%n_counters
         if (.not. allocated(error)) call table%put(case%model%x_name(i)//','//trim(number_text(case%at%x(i))), error)
      end do
      call case%model%outputs(case%at, case%found%lambda, outputs)
      do i = 1, size(outputs)
         if (.not. allocated(error)) call table%put(case%model%output_name(i)//','//trim(number_text(outputs(i))), error)
      end do
      shown = 0
      if (case%analysis%kind == 'modes') then
         shown = min(case%analysis%number, size(case%modes%frequency))
         if (.not. allocated(error)) call modes%create(out//'/'//file%name//'/modes.csv', error)
         row = 'mode,frequency,growth'
         do i = 1, case%model%n
            row = row//','//case%model%v_name(i)
         end do
         if (.not. allocated(error)) call modes%put(row, error)
         do j = 1, shown
            row = to_text(j)//','//trim(number_text(case%modes%frequency(j)))//','//trim(number_text(case%modes%growth(j)))
            do i = 1, case%model%n
               row = row//','//trim(number_text(case%modes%shapes(i, j)))
            end do
            if (.not. allocated(error)) call modes%put(row, error)
         end do
         if (.not. allocated(error)) call modes%finish(error)
      end if
      if (.not. allocated(error)) call table%finish(error)
      if (allocated(error)) then
         call table%discard()
         call modes%discard()
         return
      end if
      if (quiet) return
      call say(file%name//': '//case%report%text)
      write (line, '(2x, a, i0, a, es9.2, a)') 'equilibrium found in ', case%found%iterations, ' iterations, ', &
         case%found%force_left, ' N or N m out of balance'
      call say(trim(line))
      do j = 1, shown
         write (line, '(2x, a, i4, f14.6, a)') 'mode', j, case%modes%frequency(j), ' Hz'
         call say(trim(line))
         write (line, '(8x, a, es10.3, a)') 'grows with ', case%modes%growth(j), ' 1/s'
         if (case%modes%growth(j) > 0.0_wp) call say(trim(line))
      end do
   end subroutine write_static

end module taut_case_mechanism_static
