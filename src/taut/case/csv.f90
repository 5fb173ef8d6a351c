!> CSV files that appear under their name only when they are complete.
module taut_case_csv
   use, intrinsic :: iso_fortran_env, only: error_unit, int64
   use taut_archive, only: archive_t
   use taut_error, only: error_t, raise, to_text
   use taut_case_checksum, only: checksum_of_file
   use taut_case_posix, only: move_file, output_file_t, remove_file
   use taut_case_process, only: process_id
   implicit none (type, external)
   private
   public :: csv_t, csv_field

   !> A file that is being written.
   type :: csv_t
      !> Final path.
      character(:), allocatable :: path
      !> Whether a checkpoint refers to the unfinished file, so that a failure leaves it in its place.
      logical :: in_checkpoint = .false.
      character(:), allocatable, private :: temporary
      type(output_file_t), private :: file
      logical, private :: opened = .false.
      !> What is known to have arrived: number of bytes, and their checksum.
      integer(int64), private :: synced = 0, checksum = 0
   contains
      procedure :: create
      procedure :: put
      procedure :: is_open
      procedure :: finish
      procedure :: discard
      procedure :: keep
      procedure :: serialize
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

      integer :: i

      self%path = path
      self%in_checkpoint = .false.
      self%synced = 0
      self%checksum = 0
      ! A process that was killed may have left a file, and its number may be ours now.
      do i = 1, 1000
         self%temporary = path//'.'//to_text(process_id())//'-'//to_text(i)//'.part'
         call self%file%open(self%temporary, self%opened)
         if (self%opened) exit
      end do
      if (.not. self%opened) &
         call raise(error, path, 'the file cannot be written', 'choose a folder that can be written with --out')
   end subroutine create

   !> Whether lines can be written.
   pure logical function is_open(self)
      !> The file.
      class(csv_t), intent(in) :: self

      is_open = self%opened
   end function is_open

   !> Writes one line.
   subroutine put(self, line, error)
      !> The file.
      class(csv_t), intent(inout) :: self
      !> Text without a line end.
      character(*), intent(in) :: line
      !> A disk that is full, for example.
      type(error_t), allocatable, intent(inout) :: error
      logical :: done

      if (.not. self%opened) return
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

      if (.not. self%opened) return
      self%opened = .false.
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

   !> Removes what was written so far, unless a checkpoint needs it.
   subroutine discard(self)
      !> The file.
      class(csv_t), intent(inout) :: self
      logical :: ignored

      if (.not. self%opened) return
      call self%file%close(ignored)
      if (.not. self%in_checkpoint) call remove_file(self%temporary)
      self%opened = .false.
   end subroutine discard

   !> Closes the file and leaves what was written so far under its temporary name, for a later `serialize`.
   subroutine keep(self)
      !> The file.
      class(csv_t), intent(inout) :: self
      logical :: ignored

      if (.not. self%opened) return
      call self%file%close(ignored)
      self%opened = .false.
   end subroutine keep

   !> Passes a file that is being written through an archive: its length so far and a checksum. Restored, it is the file
   !! that was left under its temporary name, cut to that length.
   subroutine serialize(self, archive, folder, error)
      !> The file: open if it is stored, not open if it is restored.
      class(csv_t), intent(inout) :: self
      !> The folder it is in.
      character(*), intent(in) :: folder
      !> The archive.
      type(archive_t), intent(inout) :: archive
      !> What was written does not arrive, or is not there any more.
      type(error_t), allocatable, intent(inout) :: error
      character(:), allocatable :: name, temporary_name
      integer(int64) :: checksum, length
      logical :: busy, done, known

      if (.not. archive%reading) then
         call self%file%sync(done)
         length = self%file%position()
         if (done) call checksum_of_file(self%temporary, self%synced, length, self%checksum, done)
         if (.not. done) then
            call broken(self, error)
            return
         end if
         self%synced = length
      end if
      if (.not. archive%reading) then
         name = self%path(index(self%path, '/', back=.true.) + 1:)
         temporary_name = self%temporary(index(self%temporary, '/', back=.true.) + 1:)
      end if
      call archive%list('file', name)
      call archive%list('unfinished file', temporary_name)
      call archive%item('bytes', self%synced)
      call archive%item('checksum', self%checksum)
      if (.not. archive%reading .or. allocated(archive%error)) return
      ! What is restored is overwritten: it must be a file of this folder, and an unfinished one.
      if (.not. (is_plain(name) .and. is_plain(temporary_name) .and. self%synced >= 0)) then
         call raise(error, folder, 'the checkpoint names files that no run writes', 'run the case anew')
         return
      end if
      self%path = folder//'/'//name
      self%temporary = folder//'/'//temporary_name
      ! A run that was killed after the file was finished, and before the next checkpoint, left it under its final name.
      if (.not. holds(self%temporary) .and. holds(self%path)) call move_file(self%path, self%temporary, done)
      if (.not. holds(self%temporary)) then
         call raise(error, self%temporary, 'the unfinished file is not what the checkpoint says', &
                    'restart from a checkpoint whose files were left in place, or run the case anew')
         return
      end if
      call self%file%reopen(self%temporary, self%synced, self%opened, busy, known)
      if (.not. known) write (error_unit, '(2a)') self%temporary, &
         ': note: the file system has no locks: see that no other process writes this file'
      self%in_checkpoint = self%opened
      if (busy) then
         call raise(error, self%temporary, 'another process writes the unfinished file', 'see whether the run still goes on')
      else if (.not. self%opened) then
         call raise(error, self%temporary, 'the unfinished file cannot be written', &
                    'see to the permissions of the file and of its folder')
      end if

   contains

      !> Whether a name is that of a file of results in its folder.
      logical function is_plain(name)
         character(:), allocatable, intent(in) :: name

         is_plain = allocated(name)
         if (is_plain) is_plain = index(name, '/') == 0 .and. index(name, '.csv') > 1 .and. index(name, achar(0)) == 0
      end function is_plain

      !> Whether a file begins with what was stored.
      logical function holds(path)
         character(*), intent(in) :: path

         checksum = 0
         call checksum_of_file(path, 0_int64, self%synced, checksum, done)
         holds = done .and. checksum == self%checksum
      end function holds

   end subroutine serialize

   !> A failed output.
   subroutine broken(self, error)
      type(csv_t), intent(inout) :: self
      type(error_t), allocatable, intent(inout) :: error

      call self%discard()
      if (self%in_checkpoint) then
         call raise(error, self%path, 'the file cannot be completed', &
                    'make room on the disk and continue from the last checkpoint with --restart')
      else
         call remove_file(self%temporary)
         call raise(error, self%path, 'the file cannot be completed', 'make room on the disk and run again')
      end if
   end subroutine broken

   !> A text as a field of a table: in quotation marks if it has a comma, a quotation mark or a line end.
   pure function csv_field(text) result(field)
      !> The text.
      character(*), intent(in) :: text
      !> What is written.
      character(:), allocatable :: field
      integer :: i

      field = text
      if (scan(text, ',"'//achar(10)//achar(13)) == 0) return
      field = '"'
      do i = 1, len(text)
         field = field//text(i:i)
         if (text(i:i) == '"') field = field//'"'
      end do
      field = field//'"'
   end function csv_field

end module taut_case_csv
