!> What a run depends on besides the program: its case file, and the files that are read with it.
module taut_case_identity
   use, intrinsic :: iso_fortran_env, only: int64, int8
   use taut_case_checksum, only: add_to_checksum
   use taut_case_namelist_file, only: namelist_file_t
   use taut_case_posix, only: read_whole
   use taut_case_value, only: split_words, word_t, words_ok
   implicit none (type, external)
   private
   public :: identity, beside

   !> The entry that names a file.
   character(*), parameter :: naming = 'table'

contains

   !> The text of a case file, with a line for each file that it names: two cases with the same one give the same results.
   subroutine identity(file, text)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> Its identity.
      character(:), allocatable, intent(out) :: text
      type(word_t), allocatable :: words(:)
      character(:), allocatable :: content
      character(len=16) :: digits
      integer(int64) :: checksum
      integer :: code, i, j
      logical :: done

      text = file%content
      do i = 1, size(file%groups)
         do j = 1, size(file%groups(i)%entries)
            if (file%groups(i)%entries(j)%base /= naming) cycle
            call split_words(file%groups(i)%entries(j)%value, words, code)
            if (code /= words_ok .or. size(words) == 0) cycle
            call read_whole(beside(file%path, words(1)%text), content, done)
            checksum = 0
            call add_to_checksum(transfer(content, [0_int8]), checksum)
            write (digits, '(z8.8)') checksum
            text = text//new_line('a')//'! '//words(1)%text//' '//trim(digits)
         end do
      end do
   end subroutine identity

   !> A path from the folder of a file; one that begins with a slash is as it is.
   pure function beside(file, path) result(whole)
      !> Path of the file.
      character(*), intent(in) :: file
      !> The path.
      character(*), intent(in) :: path
      !> From the working folder.
      character(:), allocatable :: whole

      whole = path
      if (index(path, '/') /= 1) whole = file(:index(file, '/', back=.true.))//path
   end function beside

end module taut_case_identity
