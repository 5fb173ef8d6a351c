!> CSV files that appear under their name only when they are complete.
module taut_case_csv
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_case_posix, only: move_file, output_file_t, process_id, remove_file
   implicit none (type, external)
   private
   public :: csv_t, number_text

   !> A file that is being written.
   type :: csv_t
      !> Final path.
      character(:), allocatable :: path
      character(:), allocatable, private :: temporary
      type(output_file_t), private :: file
      logical, private :: is_open = .false.
   contains
      procedure :: create
      procedure :: put
      procedure :: finish
      procedure :: discard
   end type csv_t

contains

   !> Opens a temporary file beside the final one.
   subroutine create(self, path, error)
      !> The file.
      class(csv_t), intent(inout) :: self
      !> Final path.
      character(*), intent(in) :: path
      !> A folder that cannot be written.
      type(error_t), allocatable, intent(inout) :: error

      self%path = path
      self%temporary = path//'.'//to_text(process_id())//'.part'
      call self%file%open(self%temporary, self%is_open)
      if (.not. self%is_open) &
         call raise(error, path, 'the file cannot be written', 'choose a folder that can be written with --out')
   end subroutine create

   !> Writes one line.
   subroutine put(self, line, error)
      !> The file.
      class(csv_t), intent(inout) :: self
      !> Text without a line end.
      character(*), intent(in) :: line
      !> A disk that is full, for example.
      type(error_t), allocatable, intent(inout) :: error
      logical :: done

      if (.not. self%is_open) return
      call self%file%put(line, done)
      if (.not. done) call broken(self, error)
   end subroutine put

   !> Completes the file and gives it its name.
   subroutine finish(self, error)
      !> The file.
      class(csv_t), intent(inout) :: self
      !> A disk that is full, for example; an older file of the same name is left as it was.
      type(error_t), allocatable, intent(inout) :: error
      logical :: done

      if (.not. self%is_open) return
      self%is_open = .false.
      call self%file%close(done)
      if (.not. done) then
         call broken(self, error)
         return
      end if
      call move_file(self%temporary, self%path, done)
      if (done) return
      call remove_file(self%temporary)
      call raise(error, self%path, 'the finished file cannot be moved to its place', &
                 'see whether something else has this name, or choose another folder with --out')
   end subroutine finish

   !> Removes what was written so far.
   subroutine discard(self)
      !> The file.
      class(csv_t), intent(inout) :: self
      logical :: ignored

      if (.not. self%is_open) return
      call self%file%close(ignored)
      call remove_file(self%temporary)
      self%is_open = .false.
   end subroutine discard

   !> A failed output.
   subroutine broken(self, error)
      type(csv_t), intent(inout) :: self
      type(error_t), allocatable, intent(inout) :: error

      call self%discard()
      call remove_file(self%temporary)
      call raise(error, self%path, 'the file cannot be completed', 'make room on the disk and run again')
   end subroutine broken

   !> A number in full precision.
   function number_text(value) result(text)
      !> The number.
      real(wp), intent(in) :: value
      !> Seventeen significant digits, right-adjusted.
      character(len=24) :: text

      write (text, '(es24.16e3)') value
   end function number_text

end module taut_case_csv
