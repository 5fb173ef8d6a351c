!> The command line that all apps share.
module taut_case_command_line
   use taut_error, only: error_t, raise
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
      !> Whether nothing is printed but errors.
      logical :: quiet = .false.
      !> Whether help or the version is wanted instead.
      logical :: help = .false., version = .false.
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
      character(:), allocatable :: argument
      integer :: i, j

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
         case ('--help', '-h')
            line%help = .true.
         case ('--version')
            line%version = .true.
         case ('--out')
            i = i + 1
            if (i > command_argument_count()) then
               call raise(error, 'command line', '--out has no folder', 'write --out DIR')
               return
            end if
            line%out = get(i)
            if (index(line%out, '-') == 1) then
               call raise(error, 'command line', '--out has no folder but the option '//line%out, &
                          'write --out DIR (./'//line%out//' if that is its name)')
               return
            end if
            if (len(line%out) == 0) call raise(error, 'command line', '--out has an empty folder', 'write --out DIR')
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
      if (size(line%cases) == 0) line%cases = [path_t(default_case)]
   end subroutine read_command_line

   !> The text of `--help`.
   function usage(app, default_case, about, ending) result(text)
      !> Name of the app, its default case, and what it does.
      character(*), intent(in) :: app, default_case, about
      !> Its files and exit codes. Default: those of an app that integrates.
      character(*), intent(in), optional :: ending
      !> Several lines.
      character(:), allocatable :: text
      character, parameter :: nl = new_line('a')

      text = 'usage: '//app//' [CASE.nml ...] [--out DIR] [--quiet] [--help] [--version]'//nl//nl// &
             about//nl//nl// &
             '  CASE.nml   case files; default: '//default_case//nl// &
             '  --out DIR  folder for the results; default: results'//nl// &
             '  --quiet    print nothing but errors'//nl// &
             '  --help     print this'//nl// &
             '  --version  print the version'//nl//nl
      if (present(ending)) then
         text = text//ending
         return
      end if
      text = text//'For each method of a case: DIR/<case>/<method>.csv; for the case: DIR/<case>/summary.csv, and'//nl// &
             'DIR/<case>/model.csv if the system has data to tell.'//nl// &
             'Exit code: 0 if every integration reached its end or a terminal event, 1 otherwise, 2 for a bad command line.'
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
