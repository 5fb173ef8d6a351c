!> The BLAS that a program runs with. Sums that threads share are added in another order, and so are those of another kernel:
!! results would depend on where they were had. The apps run with one thread and say which BLAS it was; a program of one's own
!! decides for itself.
module taut_case_blas
   use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_f_pointer, c_f_procpointer, c_funptr, c_int, c_ptr, c_size_t
   use taut_shared_library, only: procedure_named
   implicit none (type, external)
   private
   public :: use_one_thread, blas_text

   abstract interface
      !> Sets the number of threads of a library.
      subroutine set_threads(number) bind(c)
         import :: c_int
         implicit none (type, external)
         !> The number of threads.
         integer(c_int), value :: number
      end subroutine set_threads

      !> What a library tells of itself.
      function tell_text() bind(c) result(text)
         import :: c_ptr
         implicit none (type, external)
         !> A text of C.
         type(c_ptr) :: text
      end function tell_text
   end interface

   interface
      function c_strlen(text) bind(c, name='strlen') result(length)
         import :: c_ptr, c_size_t
         implicit none (type, external)
         type(c_ptr), value :: text
         integer(c_size_t) :: length
      end function c_strlen
   end interface

   !> How libraries call what sets their number of threads.
   character(len=26), parameter :: setters(3) = [character(len=26) :: 'openblas_set_num_threads', 'MKL_Set_Num_Threads', &
                                                 'bli_thread_set_num_threads']

contains

   !> Makes BLAS run with one thread, whatever the environment says, if it is one that can have more. What it is called is
   !! looked up in the running program, so that any BLAS links.
   subroutine use_one_thread()
      procedure(set_threads), pointer :: set
      type(c_funptr) :: found
      integer :: i

      do i = 1, size(setters)
         found = procedure_named(trim(setters(i)))
         if (.not. c_associated(found)) cycle
         call c_f_procpointer(found, set)
         call set(1_c_int)
      end do
   end subroutine use_one_thread

   !> Which BLAS it is: of OpenBLAS its version and the kernel that it chose for this processor, of others what is known.
   function blas_text() result(text)
      !> One line without a comma.
      character(:), allocatable :: text
      character(:), allocatable :: config

      if (c_associated(procedure_named('openblas_get_corename'))) then
         config = said('openblas_get_config')//' '
         ! Such as `OpenBLAS 0.3.21 NO_LAPACKE DYNAMIC_ARCH ...`.
         config = config(:index(config(index(config, ' ') + 1:), ' ') + index(config, ' '))
         text = trim(config)//' '//said('openblas_get_corename')
      else if (c_associated(procedure_named('MKL_Set_Num_Threads'))) then
         text = 'MKL'
      else if (c_associated(procedure_named('bli_thread_set_num_threads'))) then
         text = 'BLIS '//said('bli_info_get_version_str')
      else
         text = 'BLAS'
      end if
      text = text//' 1 thread'
   end function blas_text

   !> What a procedure of the library says of itself; nothing if there is no such procedure.
   function said(name) result(text)
      character(*), intent(in) :: name
      character(:), allocatable :: text
      procedure(tell_text), pointer :: tell
      character(kind=c_char), pointer :: letters(:)
      type(c_funptr) :: found
      type(c_ptr) :: place
      integer :: i, length

      text = ''
      found = procedure_named(name)
      if (.not. c_associated(found)) return
      call c_f_procpointer(found, tell)
      place = tell()
      if (.not. c_associated(place)) return
      length = int(c_strlen(place))
      call c_f_pointer(place, letters, [length])
      deallocate (text)
      allocate (character(len=length) :: text)
      do i = 1, length
         text(i:i) = letters(i)
      end do
   end function said

end module taut_case_blas
