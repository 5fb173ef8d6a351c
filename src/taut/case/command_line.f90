!> The command line that all apps share.
module taut_case_command_line
   use taut_error, only: error_t, raise
   use taut_kinds, only: wp
   implicit none (type, external)
   private
   public :: command_line_t, read_command_line, usage

   !> What was asked for.
   type :: command_line_t
      !> Name of the app.
      character(:), allocatable :: app
      !> Case files.
      type(path_t), allocatable :: cases(:)
      !> Folder for the results.
      character(:), allocatable :: out
      !> Checkpoint to continue from; not allocated if there is none.
      character(:), allocatable :: restart
      !> Time between checkpoints [s]; 0 for none.
      real(wp) :: checkpoint = 0.0_wp
      !> List of runs of a case with blanks; not allocated if there is none.
      character(:), allocatable :: runs
      !> Whether the folder was given.
      logical :: out_given = .false.
      !> Whether a checkpoint may have been written with another BLAS.
      logical :: any_blas = .false.
      !> Whether nothing is printed but errors.
      logical :: quiet = .false.
      !> Whether help or the version is wanted instead.
      logical :: help = .false., version = .false.
      !> Whether the entries of a case file are wanted instead, as a text or in Markdown.
      logical :: help_case = .false., reference = .false.
   end type command_line_t

   !> A path.
   type, public :: path_t
      !> Its text.
      character(:), allocatable :: text
   end type path_t

contains

   !> Reads the arguments of the program.
   subroutine read_command_line(app, default_case, line, error)
      !> Name of the app.
      character(*), intent(in) :: app
      !> Case file that is run if none is given.
      character(*), intent(in) :: default_case
      !> What was asked for.
      type(command_line_t), intent(out) :: line
      !> An argument that is not known.
      type(error_t), allocatable, intent(inout) :: error
      character(:), allocatable :: argument, value
      integer :: i, j, status

      line%app = app
      line%out = 'results'
      allocate (line%cases(0))
      i = 0
      do while (i < command_argument_count())
         i = i + 1
         argument = get(i)
         select case (argument)
         case ('--quiet')
            line%quiet = .true.
         case ('--any-blas')
            line%any_blas = .true.
         case ('--help', '-h')
            line%help = .true.
         case ('--help-case')
            line%help_case = .true.
         case ('--help-case=markdown')
            line%reference = .true.
         case ('--version')
            line%version = .true.
         case ('--out')
            call value_of('a folder', 'DIR', value)
            if (allocated(error)) return
            line%out = value
            line%out_given = .true.
         case ('--restart')
            call value_of('a checkpoint', 'FILE', value)
            if (allocated(error)) return
            line%restart = value
         case ('--runs')
            call value_of('a list of runs', 'FILE', value)
            if (allocated(error)) return
            line%runs = value
         case ('--checkpoint')
            call value_of('a time', 'SECONDS', value)
            if (allocated(error)) return
            read (value, *, iostat=status) line%checkpoint
            if (status /= 0 .or. .not. (line%checkpoint > 0.0_wp .and. line%checkpoint < 1.0e9_wp)) then
               call raise(error, 'command line', '--checkpoint '//value//' is no time', 'write --checkpoint 600 for ten minutes')
               return
            end if
         case ('')
            call raise(error, 'command line', 'there is an empty argument', 'give the paths of case files')
         case default
            if (argument(1:1) == '-') then
               call raise(error, 'command line', 'there is no option '//argument, 'see '//app//' --help')
               return
            end if
            do j = 1, size(line%cases)
               if (line%cases(j)%text == argument) call raise(error, 'command line', argument//' is given twice', 'give it once')
            end do
            line%cases = [line%cases, path_t(argument)]
         end select
      end do
      if (allocated(line%runs)) then
         if (size(line%cases) /= 1) &
            call raise(error, 'command line', '--runs needs one case', 'give the path of a case file with blanks such as @1@')
         if (allocated(line%restart) .or. line%checkpoint > 0.0_wp .or. line%out_given) &
            call raise(error, 'command line', '--runs writes no files', &
                       'leave --out, --checkpoint and --restart out')
      else if (allocated(line%restart)) then
         if (size(line%cases) > 1) &
            call raise(error, 'command line', '--restart continues one case, and there are several', &
                       'give that case alone, or none')
      else if (size(line%cases) == 0) then
         line%cases = [path_t(default_case)]
      end if

   contains

      !> The argument after an option.
      subroutine value_of(what, name, value)
         character(*), intent(in) :: what, name
         character(:), allocatable, intent(out) :: value

         value = ''
         i = i + 1
         if (i > command_argument_count()) then
            call raise(error, 'command line', argument//' has no '//what(index(what, ' ') + 1:), 'write '//argument//' '//name)
            return
         end if
         value = get(i)
         if (index(value, '-') == 1) then
            call raise(error, 'command line', argument//' has no '//what(index(what, ' ') + 1:)//' but the option '//value, &
                       'write '//argument//' '//name//' (./'//value//' if that is its name)')
         else if (len(value) == 0) then
            call raise(error, 'command line', argument//' has an empty '//what(index(what, ' ') + 1:), &
                       'write '//argument//' '//name)
         end if
      end subroutine value_of

   end subroutine read_command_line

   !> The text of `--help`.
   function usage(app, default_case, about, ending) result(text)
      !> Name of the app.
      character(*), intent(in) :: app
      !> Its default case.
      character(*), intent(in) :: default_case
      !> What it does, in one line.
      character(*), intent(in) :: about
      !> Its files and exit codes. Default: those of an app that integrates.
      character(*), intent(in), optional :: ending
      !> Several lines.
      character(:), allocatable :: text
      character, parameter :: nl = new_line('a')

      text = 'usage: '//app//' [CASE.nml ...] [--out DIR] [--checkpoint SECONDS] [--restart FILE]'//nl// &
             repeat(' ', 8 + len(app))//'[--runs FILE] [--any-blas] [--quiet] [--help] [--help-case] [--version]'//nl//nl// &
             about//nl//nl// &
             '  CASE.nml              case files; default: '//default_case//nl// &
             '  --out DIR             folder for the results; default: results'//nl// &
             '  --checkpoint SECONDS  write DIR/<case>/checkpoint.taut so often (wall time)'//nl// &
             '  --restart FILE        continue from such a checkpoint, bit for bit, in the folder that it is in'//nl// &
             '  --runs FILE           print a row for each run of this list and write no files; a line is a name and the'//nl// &
             '                        values of the blanks @1@, @2@, ... of the case, with a tab before each value'//nl// &
             '  --any-blas            let it continue with another BLAS or kernel: round-off differs from there on'//nl// &
             '  --quiet               print nothing but errors'//nl// &
             '  --help                print this'//nl// &
             '  --help-case           print what a case file may say; --help-case=markdown: as a page'//nl// &
             '  --version             print the version, the compiler and its options'//nl//nl
      if (present(ending)) then
         text = text//ending
         return
      end if
      text = text//'For each method of a case: DIR/<case>/<method>.csv; for the case: DIR/<case>/summary.csv, and'//nl// &
             'DIR/<case>/model.csv if the system has data to tell.'//nl// &
             'SIGINT (Ctrl-C), SIGTERM and SIGUSR1 write a checkpoint and end the run.'//nl// &
             'Exit code: 0 if every integration reached its end or a terminal event, 75 if a signal interrupted it,'//nl// &
             '1 otherwise, 2 for a bad command line.'
   end function usage

   !> One argument.
   function get(i) result(argument)
      integer, intent(in) :: i
      character(:), allocatable :: argument
      integer :: length

      call get_command_argument(i, length=length)
      allocate (character(len=length) :: argument)
      if (length > 0) call get_command_argument(i, argument)
   end function get

end module taut_case_command_line
