!> Checksums that tell a damaged file from a whole one: CRC-32 as in ISO 3309, Ethernet and zip files.
module taut_case_checksum
   use, intrinsic :: iso_fortran_env, only: int8, int64
   use taut_case_posix, only: read_bytes
   implicit none (type, external)
   private
   public :: add_to_checksum, checksum_of_file

   integer(int64), parameter :: polynomial = int(z'EDB88320', int64), all_bits = int(z'FFFFFFFF', int64)

contains

   !> The table of CRC-32: the remainder of each byte.
   pure function table() result(remainder)
      integer(int64) :: remainder(0:255)
      integer(int64) :: i
      integer :: bit

      do i = 0, 255
         remainder(i) = i
         do bit = 1, 8
            if (btest(remainder(i), 0)) then
               remainder(i) = ieor(ishft(remainder(i), -1), polynomial)
            else
               remainder(i) = ishft(remainder(i), -1)
            end if
         end do
      end do
   end function table

   !> Continues a checksum.
   pure subroutine add_to_checksum(bytes, checksum)
      !> What comes next.
      integer(int8), intent(in) :: bytes(:)
      !> Checksum of what came before, 0 at the start; on return, of all.
      integer(int64), intent(inout) :: checksum
      integer(int64) :: remainder(0:255), state
      integer(int64) :: i

      remainder = table()
      state = ieor(checksum, all_bits)
      do i = 1, size(bytes, kind=int64)
         state = ieor(remainder(iand(ieor(state, int(bytes(i), int64)), 255_int64)), ishft(state, -8))
      end do
      checksum = ieor(state, all_bits)
   end subroutine add_to_checksum

   !> Continues a checksum with a part of a file.
   subroutine checksum_of_file(path, first, last, checksum, done)
      !> Path of the file.
      character(*), intent(in) :: path
      !> The byte before the part.
      integer(int64), intent(in) :: first
      !> The last byte of the part.
      integer(int64), intent(in) :: last
      !> Checksum of what came before; on return, of all.
      integer(int64), intent(inout) :: checksum
      !> Whether the file has all these bytes.
      logical, intent(out) :: done
      integer(int8), allocatable :: buffer(:)
      integer(int64) :: at, count

      allocate (buffer(65536))
      at = first
      done = .true.
      do while (at < last)
         call read_bytes(path, at, buffer, count)
         done = count > 0
         if (.not. done) return
         count = min(count, last - at)
         call add_to_checksum(buffer(:count), checksum)
         at = at + count
      end do
   end subroutine checksum_of_file

end module taut_case_checksum
