!> Checkpoints: files from which an interrupted run continues bit for bit.
!!
!! A checkpoint is, in this order:
!!
!!     'taut checkpoint' and a line end          16 bytes
!!     version of this format                    32-bit integer
!!     1, to tell the order of the bytes         32-bit integer
!!     length of the archive in bytes            64-bit integer
!!     CRC-32 of the archive                     64-bit integer
!!     the archive                               entries as in `taut_archive`
!!
!! The archive begins with the program that wrote it (version of taut, compiler and its options), its BLAS, the app, the path of
!! the case and its text; then come the finished methods, the recorder, the integration and the counters. The integers are as the
!! machine has them. The file appears under its name when it is complete and on the disk, in the place of the one before.
module taut_case_checkpoint
   use, intrinsic :: iso_fortran_env, only: compiler_options, compiler_version, int32, int64, int8
   use taut_archive, only: archive_t
   use taut_error, only: error_t, raise, to_text
   use taut_kinds, only: wp
   use taut_version, only: version
   use taut_case_blas, only: blas_text
   use taut_case_checksum, only: add_to_checksum
   use taut_case_posix, only: move_file, output_file_t, read_bytes, remove_file
   use taut_case_process, only: caught_signal, process_id
   use taut_ode_pause, only: pause_t
   implicit none (type, external)
   private
   public :: checkpoint_file, program_text, read_checkpoint, store_origin, watch_t, write_checkpoint

   !> Name of the file in the folder of a case's results.
   character(*), parameter :: checkpoint_file = 'checkpoint.taut'

   character(len=16), parameter :: magic = 'taut checkpoint'//new_line('a')
   integer(int32), parameter :: format_version = 2, byte_order = 1
   integer, parameter :: header_length = 40

   !> Pauses an integration when a signal came or the time for a checkpoint has come.
   type, extends(pause_t) :: watch_t
      !> Time between checkpoints [s]; 0 for none but those that signals ask for.
      real(wp) :: interval = 0.0_wp
      integer(int64), private :: next = huge(1_int64)
   contains
      procedure :: start
      procedure :: wanted
   end type watch_t

contains

   !> Begins to count the time to the next checkpoint.
   subroutine start(self)
      !> The watch.
      class(watch_t), intent(inout) :: self
      integer(int64) :: now, rate

      self%next = huge(1_int64)
      if (.not. self%interval > 0.0_wp) return
      call system_clock(now, rate)
      self%next = now + int(self%interval*real(rate, wp), int64)
   end subroutine start

   !> Whether to pause.
   logical function wanted(self)
      !> The watch.
      class(watch_t), intent(inout) :: self
      integer(int64) :: now

      wanted = caught_signal() /= 0
      if (wanted .or. .not. self%interval > 0.0_wp) return
      call system_clock(now)
      wanted = now >= self%next
   end function wanted

   !> What a bit-for-bit continuation depends on: the version, the compiler and its options.
   function program_text() result(text)
      !> Three lines.
      character(:), allocatable :: text

      text = 'taut '//version//new_line('a')//'compiler: '//compiler_version()//new_line('a')//'options: '//compiler_options()
   end function program_text

   !> Passes through an archive which program and case it belongs to; restored, they have to be the ones at hand.
   subroutine store_origin(archive, path, app, any_blas, case_path, case_text, error)
      !> The archive.
      type(archive_t), intent(inout) :: archive
      !> Path of the checkpoint, for messages.
      character(*), intent(in) :: path
      !> Name of the app.
      character(*), intent(in) :: app
      !> Whether it may go on with another BLAS, so that the rest of the motion differs by round-off.
      logical, intent(in) :: any_blas
      !> Path of the case file; restored if it is not allocated.
      character(:), allocatable, intent(inout) :: case_path
      !> Its text.
      character(:), allocatable, intent(inout) :: case_text
      !> Another program's or another case's checkpoint.
      type(error_t), allocatable, intent(inout) :: error
      character(:), allocatable :: own, other

      own = program_text()
      other = own
      call archive%list('program', other)
      if (.not. allocated(other)) other = ''
      if (archive%reading .and. .not. allocated(archive%error)) then
         if (other /= own) then
            call raise(error, path, 'the checkpoint was written by another build: '//flat(other), &
                       'restart with the program that wrote it, or run the case anew')
            return
         end if
      end if
      own = blas_text()
      other = own
      call archive%list('blas', other)
      if (.not. allocated(other)) other = ''
      if (archive%reading .and. .not. any_blas .and. .not. allocated(archive%error)) then
         if (other /= own) then
            call raise(error, path, 'the checkpoint was written with another BLAS or kernel: '//other//', not '//own, &
                       'restart on a machine of that kind, or give --any-blas if round-off may differ from here on')
            return
         end if
      end if
      other = app
      call archive%list('app', other)
      if (.not. allocated(other)) other = ''
      if (archive%reading .and. .not. allocated(archive%error)) then
         if (other /= app) then
            call raise(error, path, 'the checkpoint belongs to the app '//other, 'restart it with that app')
            return
         end if
      end if
      call archive%list('case', case_path)
      call archive%list('text of the case', case_text)
   end subroutine store_origin

   !> Lines in one.
   pure function flat(text) result(line)
      character(*), intent(in) :: text
      character(len=len(text)) :: line
      integer :: i

      line = text
      do i = 1, len(text)
         if (text(i:i) == new_line('a')) line(i:i) = ','
      end do
   end function flat

   !> Writes a checkpoint; what was there before stays until it is complete.
   subroutine write_checkpoint(path, archive, error)
      !> Path of the file.
      character(*), intent(in) :: path
      !> What it holds.
      type(archive_t), intent(in) :: archive
      !> A disk that is full, for example.
      type(error_t), allocatable, intent(inout) :: error
      type(output_file_t) :: file
      character(:), allocatable :: temporary
      integer(int64) :: checksum
      logical :: arrived, done

      temporary = path//'.'//to_text(process_id())//'.part'
      checksum = 0
      call add_to_checksum(archive%bytes(:archive%length), checksum)
      ! One of this name is the remainder of a killed process.
      call remove_file(temporary)
      call file%open(temporary, done)
      if (done) then
         call file%put_bytes([transfer(magic, [0_int8]), transfer(format_version, [0_int8]), &
                              transfer(byte_order, [0_int8]), transfer(archive%length, [0_int8]), &
                              transfer(checksum, [0_int8])], done)
         if (done) call file%put_bytes(archive%bytes(:archive%length), done)
         if (done) call file%sync(done)
         call file%close(arrived)
         done = done .and. arrived
         if (done) call move_file(temporary, path, done)
         if (.not. done) call remove_file(temporary)
      end if
      if (.not. done) call raise(error, path, 'the checkpoint cannot be written', &
                                 'make room on the disk or choose a folder that can be written with --out')
   end subroutine write_checkpoint

   !> Reads a checkpoint, all of it or nothing.
   subroutine read_checkpoint(path, archive, error)
      !> Path of the file.
      character(*), intent(in) :: path
      !> What it holds, ready to be read.
      type(archive_t), intent(inout) :: archive
      !> A file that is missing, damaged, no checkpoint, or in a format of another version.
      type(error_t), allocatable, intent(inout) :: error
      integer(int8) :: head(header_length), beyond(1)
      integer(int64) :: checksum, count, expected, length

      call read_bytes(path, 0_int64, head, count)
      if (count < 0) then
         call raise(error, path, 'there is no such checkpoint', &
                    'give the path of a '//checkpoint_file//', which Ctrl-C and --checkpoint SECONDS write')
         return
      end if
      if (count < 16) head = 0
      if (transfer(head(1:16), magic) /= magic) then
         call raise(error, path, 'this is no checkpoint of taut', 'give the path of a '//checkpoint_file)
         return
      end if
      if (count < header_length) then
         call damaged('it ends in its first lines')
         return
      end if
      if (transfer(head(21:24), byte_order) /= byte_order) then
         call raise(error, path, 'the checkpoint was written by a machine with another order of bytes', &
                    'restart on a machine of that kind, or run the case anew')
         return
      end if
      if (transfer(head(17:20), format_version) /= format_version) then
         call raise(error, path, 'the checkpoint has format '//to_text(int(transfer(head(17:20), format_version)))// &
                    ', and this program reads format '//to_text(int(format_version)), &
                    'restart with the version of taut that wrote it, or run the case anew')
         return
      end if
      length = transfer(head(25:32), length)
      expected = transfer(head(33:40), expected)
      call read_bytes(path, header_length + max(0_int64, length) - 1, beyond, count)
      if (length < 1 .or. count /= 1) then
         call damaged('it is shorter than it says')
         return
      end if
      call read_bytes(path, header_length + length, beyond, count)
      if (count /= 0) then
         call damaged('it is longer than it says')
         return
      end if
      if (allocated(archive%bytes)) deallocate (archive%bytes)
      allocate (archive%bytes(length))
      archive%length = length
      call read_bytes(path, int(header_length, int64), archive%bytes, count)
      checksum = 0
      call add_to_checksum(archive%bytes, checksum)
      if (count /= length .or. checksum /= expected) then
         call damaged('its checksum is wrong')
         return
      end if
      call archive%rewind()

   contains

      subroutine damaged(how)
         character(*), intent(in) :: how

         call raise(error, path, 'the checkpoint is damaged: '//how, 'restart from another copy, or run the case anew')
      end subroutine damaged

   end subroutine read_checkpoint

end module taut_case_checkpoint
