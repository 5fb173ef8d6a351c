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
   use taut_constrained_modes, only: eigenmodes, modes_options_t, modes_t
   use taut_constrained_system, only: state_t
   use taut_model_mechanism, only: mechanism_t
   use taut_model_mechanism_body, only: body_planar, entry_of_velocity, pose_t, velocities_of_kind
   use taut_model_mechanism_report, only: mechanism_report_t
   use taut_rotation, only: log_rotation
   implicit none (type, external)
   private
   public :: run_static_cases, static_t, solve_static

   !> How far a body went [m] or turned [rad], and its name.
   type :: distance_t
      real(wp) :: far = 0.0_wp
      character(:), allocatable :: body
   end type distance_t

   !> A case, solved.
   type :: static_t
      type(mechanism_t) :: model
      type(analysis_t) :: analysis
      type(mechanism_report_t) :: report
      !> The equilibrium, its multipliers, and modes about it.
      type(state_t) :: at
      type(equilibrium_result_t) :: found
      type(modes_t) :: modes
      !> How far the equilibrium is from the start, by the bodies that went farthest and turned most.
      type(distance_t) :: moved, turned
      !> Whether it was not at rest at the start.
      logical :: in_motion = .false.
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
      type(modes_options_t) :: wanted
      type(state_t) :: start

      call read_analysis(file, case%analysis, error)
      if (allocated(error)) return
      call read_mechanism(file, case%model, case%at, settings, case%report, error)
      if (allocated(error)) return
      options%steps = case%analysis%steps
      allocate (options%reach, source=reach_of(case%model, case%at))
      case%in_motion = maxval(abs(case%at%v)) > 0.0_wp
      start = case%at
      call equilibrium(case%model, case%at, case%found, error, options)
      if (.not. allocated(error)) then
         call measure(case, start)
         ! Its modes tell whether it is stable; where there are none, nobody asks.
         wanted%number = case%analysis%number
         call eigenmodes(case%model, case%at, case%modes, error, wanted)
         if (case%analysis%kind == 'equilibrium' .and. allocated(error)) deallocate (error)
      end if
      if (allocated(error)) error%where = file%path//': '//error%where
   end subroutine solve_static

   !> How far a load step may go: a radian, and as far as the bodies are from each other, at least a meter.
   function reach_of(model, at) result(reach)
      type(mechanism_t), intent(in) :: model
      type(state_t), intent(in) :: at
      real(wp) :: reach(model%n)
      real(wp) :: high(3), low(3)
      type(pose_t) :: it
      integer :: i, k

      low = huge(low)
      high = -huge(high)
      do i = 1, size(model%bodies)
         call model%pose_of(at, i, it)
         low = min(low, it%p)
         high = max(high, it%p)
      end do
      reach = max(1.0_wp, maxval(high - low))
      do i = 1, size(model%bodies)
         associate (body => model%bodies(i))
            do k = 1, velocities_of_kind(body%kind)
               if (entry_of_velocity(k, body%kind) > 3) reach(body%before_v + k) = 1.0_wp
            end do
         end associate
      end do
   end function reach_of

   !> How far the equilibrium is from the start.
   subroutine measure(case, start)
      type(static_t), intent(inout) :: case
      type(state_t), intent(in) :: start
      type(pose_t) :: from, to
      real(wp) :: turned
      integer :: i

      do i = 1, size(case%model%bodies)
         associate (body => case%model%bodies(i))
            call case%model%pose_of(start, i, from)
            call case%model%pose_of(case%at, i, to)
            call farthest(case%moved, norm2(to%p - from%p), body%name)
            if (body%kind == body_planar) then
               turned = abs(case%at%x(body%before_x + 3) - start%x(body%before_x + 3))
            else
               turned = norm2(log_rotation(matmul(transpose(from%r), to%r)))
            end if
            call farthest(case%turned, turned, body%name)
         end associate
      end do
   end subroutine measure

   !> The larger of two distances.
   subroutine farthest(distance, far, body)
      type(distance_t), intent(inout) :: distance
      real(wp), intent(in) :: far
      character(*), intent(in) :: body

      if (far <= distance%far) return
      distance%far = far
      distance%body = body
   end subroutine farthest

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
         if (.not. allocated(error)) call table%put(trim(case%model%x_name(i))//','//trim(number_text(case%at%x(i))), error)
      end do
      call case%model%outputs(case%at, case%found%lambda, outputs)
      do i = 1, size(outputs)
         if (.not. allocated(error)) call table%put(trim(case%model%output_name(i))//','//trim(number_text(outputs(i))), error)
      end do
      shown = 0
      if (case%analysis%kind == 'modes') then
         shown = min(case%analysis%number, size(case%modes%frequency))
         if (.not. allocated(error)) call modes%create(out//'/'//file%name//'/modes.csv', error)
         row = 'mode,frequency,growth,damping_ratio'
         do i = 1, case%model%n
            row = row//','//trim(case%model%v_name(i))
         end do
         if (.not. allocated(error)) call modes%put(row, error)
         do j = 1, shown
            row = to_text(j)//','//trim(number_text(case%modes%frequency(j)))//','//trim(number_text(case%modes%growth(j)))// &
                  ','//trim(number_text(damping_ratio(case%modes, j)))
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
      write (line, '(2x, a, i0, a, es9.2, a)') 'equilibrium found, iterations: ', case%found%iterations, '; ', &
         case%found%force_left, ' N or N m out of balance'
      call say(trim(line))
      call tell_equilibrium(case)
      do j = 1, shown
         call tell_mode(case%modes, j)
      end do
      call say('results in '//out//'/'//file%name)
   end subroutine write_static

   !> How the equilibrium lies: how far from the start, and whether it is stable.
   subroutine tell_equilibrium(case)
      type(static_t), intent(in) :: case
      character(len=200) :: line

      if (case%moved%far > 0.0_wp) then
         write (line, '(2x, a, es9.2, 3a)') 'from the start', case%moved%far, ' m (', case%moved%body, ')'
         if (case%turned%far > 0.0_wp) write (line, '(2a, es9.2, 3a)') trim(line), ' and', case%turned%far, ' rad (', &
            case%turned%body, ')'
         call say(trim(line))
      end if
      if (.not. allocated(case%modes%frequency)) return
      if (any(case%modes%growth > 0.0_wp)) then
         write (line, '(2x, a, es9.2, a)') 'unstable: it is left at a rate of', maxval(case%modes%growth), ' 1/s'
         call say(trim(line))
      else if (case%modes%complete) then
         call say('  stable')
      else
         call say('  stable, as far as its '//to_text(size(case%modes%frequency))//' lowest modes tell')
      end if
      if (case%modes%free_motions > 0) &
         call say('  free motions, which nothing resists and nothing loads: '//to_text(case%modes%free_motions))
      if (case%in_motion .and. case%analysis%kind == 'modes') &
         call say('  modes at rest: the velocities of the start, and gyroscopic forces with them, are left out')
   end subroutine tell_equilibrium

   !> A mode.
   subroutine tell_mode(modes, i)
      type(modes_t), intent(in) :: modes
      integer, intent(in) :: i
      character(len=120) :: line

      write (line, '(2x, a, i4, f14.6, a)') 'mode', i, modes%frequency(i), ' Hz'
      if (modes%growth(i) > 0.0_wp) then
         write (line, '(2a, es10.3, a)') trim(line), ', grows with ', modes%growth(i), ' 1/s'
      else if (modes%growth(i) < 0.0_wp .and. modes%frequency(i) > 0.0_wp) then
         write (line, '(2a, es10.3)') trim(line), ', damping ratio ', damping_ratio(modes, i)
      else if (modes%growth(i) < 0.0_wp) then
         write (line, '(2a, es10.3, a)') trim(line), ', dies away with ', -modes%growth(i), ' 1/s'
      else if (modes%frequency(i) <= 0.0_wp) then
         line = trim(line)//', a free motion'
      end if
      call say(trim(line))
   end subroutine tell_mode

   !> -Re(lambda)/|lambda|: between 0 and 1 for a vibration that dies away; of a free motion zero.
   pure real(wp) function damping_ratio(modes, i)
      type(modes_t), intent(in) :: modes
      integer, intent(in) :: i
      real(wp), parameter :: pi = acos(-1.0_wp)

      damping_ratio = -modes%growth(i)/max(hypot(modes%growth(i), 2.0_wp*pi*modes%frequency(i)), tiny(1.0_wp))
   end function damping_ratio

end module taut_case_mechanism_static
