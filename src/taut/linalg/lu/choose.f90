!> Which factors for which pattern: by what they cost.
module taut_linalg_lu_choose
   use taut_kinds, only: wp
   use taut_linalg_lu, only: lu_t
   use taut_linalg_lu_banded, only: banded_lu_t
   use taut_linalg_lu_umfpack, only: umfpack_lu_t
   use taut_linalg_umfpack, only: umfpack_files
   implicit none (type, external)
   private
   public :: choose_lu

   !> A band that takes fewer multiplications, some milliseconds, is not worth a search for another way.
   real(wp), parameter :: little_work = 3.0e7_wp
   !> What UMFPACK does besides multiplying, in multiplications for each number of its factors; measured on plane nets of springs and
   !! of rods, where it is as fast as a band of 45 points and faster than one of 60.
   real(wp), parameter :: per_number = 100.0_wp

contains

   !> Chooses the factors and lays them out.
   subroutine choose_lu(n, row, column, lu, files)
      !> Order of the matrix.
      integer, intent(in) :: n
      !> Row of each entry: (entries).
      integer, intent(in) :: row(:)
      !> Column of each entry: (entries).
      integer, intent(in) :: column(:)
      !> The factors.
      class(lu_t), allocatable, intent(out) :: lu
      !> What UMFPACK may be called; default: what it is called where it is usual.
      character(*), intent(in), optional :: files(:)
      type(umfpack_lu_t), allocatable :: sparse
      logical :: found

      allocate (banded_lu_t :: lu)
      call lu%init(n, row, column)
      if (lu%work() <= little_work) return
      allocate (sparse)
      if (present(files)) then
         call sparse%library%find(files, found)
      else
         call sparse%library%find(umfpack_files, found)
      end if
      if (.not. found) return
      call sparse%init(n, row, column)
      if (.not. sparse%ready) return
      if (sparse%work() + per_number*sparse%numbers() < lu%work()) call move_alloc(sparse, lu)
   end subroutine choose_lu

end module taut_linalg_lu_choose
