!> UMFPACK, the sparse factorization of SuiteSparse, looked up at run time: programs build and run without it.
!!
!! Source: T.A. Davis, Algorithm 832: UMFPACK V4.3, an unsymmetric-pattern multifrontal method, ACM Trans. Math. Softw. 30 (2004)
!! 196-199. Argument meanings are those of its user guide; complex numbers are packed, so that the second arrays, of imaginary
!! parts, are null.
module taut_linalg_umfpack
   use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_double_complex, c_f_procpointer, c_funptr, c_int, c_ptr
   use taut_shared_library, only: open_library, procedure_named
   implicit none (type, external)
   private
   public :: umfpack_t, umfpack_files, control_size, info_size

   !> What the library is called, on Debian 12 and older, on newer ones, and where only its development files tell.
   character(len=16), parameter :: umfpack_files(*) = [character(len=16) :: 'libumfpack.so.5', 'libumfpack.so.6', 'libumfpack.so', &
                                                       'libumfpack.dylib']
   !> Sizes of its arrays of parameters and of results.
   integer, parameter :: control_size = 20, info_size = 90

   abstract interface
      !> Default parameters.
      subroutine set_defaults(control) bind(c)
         import :: c_double
         implicit none (type, external)
         real(c_double), intent(out) :: control(*)
      end subroutine set_defaults

      !> Analysis of a pattern; `values` may be null.
      function analysis_real(rows, columns, first, row, values, symbolic, control, info) bind(c) result(status)
         import :: c_double, c_int, c_ptr
         implicit none (type, external)
         integer(c_int), value :: rows, columns
         integer(c_int), intent(in) :: first(*), row(*)
         type(c_ptr), value :: values
         type(c_ptr), intent(inout) :: symbolic
         real(c_double), intent(in) :: control(*)
         real(c_double), intent(inout) :: info(*)
         integer(c_int) :: status
      end function analysis_real

      !> The same for complex matrices.
      function analysis_complex(rows, columns, first, row, values, imaginary, symbolic, control, info) bind(c) result(status)
         import :: c_double, c_int, c_ptr
         implicit none (type, external)
         integer(c_int), value :: rows, columns
         integer(c_int), intent(in) :: first(*), row(*)
         type(c_ptr), value :: values, imaginary
         type(c_ptr), intent(inout) :: symbolic
         real(c_double), intent(in) :: control(*)
         real(c_double), intent(inout) :: info(*)
         integer(c_int) :: status
      end function analysis_complex

      !> Factorization.
      function factorization_real(first, row, values, symbolic, numeric, control, info) bind(c) result(status)
         import :: c_double, c_int, c_ptr
         implicit none (type, external)
         integer(c_int), intent(in) :: first(*), row(*)
         real(c_double), intent(in) :: values(*), control(*)
         type(c_ptr), value :: symbolic
         type(c_ptr), intent(inout) :: numeric
         real(c_double), intent(inout) :: info(*)
         integer(c_int) :: status
      end function factorization_real

      !> The same for complex matrices.
      function factorization_complex(first, row, values, imaginary, symbolic, numeric, control, info) bind(c) result(status)
         import :: c_double, c_double_complex, c_int, c_ptr
         implicit none (type, external)
         integer(c_int), intent(in) :: first(*), row(*)
         complex(c_double_complex), intent(in) :: values(*)
         real(c_double), intent(in) :: control(*)
         type(c_ptr), value :: imaginary, symbolic
         type(c_ptr), intent(inout) :: numeric
         real(c_double), intent(inout) :: info(*)
         integer(c_int) :: status
      end function factorization_complex

      !> Solution, with workspace of the caller's.
      function solution_real(system, first, row, values, x, b, numeric, control, info, places, work) bind(c) result(status)
         import :: c_double, c_int, c_ptr
         implicit none (type, external)
         integer(c_int), value :: system
         integer(c_int), intent(in) :: first(*), row(*)
         real(c_double), intent(in) :: values(*), b(*), control(*)
         real(c_double), intent(inout) :: x(*), info(*), work(*)
         type(c_ptr), value :: numeric
         integer(c_int), intent(inout) :: places(*)
         integer(c_int) :: status
      end function solution_real

      !> The same for complex matrices.
      function solution_complex(system, first, row, values, imaginary, x, x_imaginary, b, b_imaginary, numeric, control, info, &
                             places, work) bind(c) result(status)
         import :: c_double, c_double_complex, c_int, c_ptr
         implicit none (type, external)
         integer(c_int), value :: system
         integer(c_int), intent(in) :: first(*), row(*)
         complex(c_double_complex), intent(in) :: values(*), b(*)
         complex(c_double_complex), intent(inout) :: x(*)
         type(c_ptr), value :: imaginary, x_imaginary, b_imaginary, numeric
         real(c_double), intent(in) :: control(*)
         real(c_double), intent(inout) :: info(*), work(*)
         integer(c_int), intent(inout) :: places(*)
         integer(c_int) :: status
      end function solution_complex

      !> Of the factors, the order of the columns and the pivots; all else is null.
      function reading_real(lp, lj, lx, up, ui, ux, p, order, pivots, reciprocal, scale, numeric) bind(c) result(status)
         import :: c_double, c_int, c_ptr
         implicit none (type, external)
         type(c_ptr), value :: lp, lj, lx, up, ui, ux, p, scale, numeric
         integer(c_int), intent(inout) :: order(*), reciprocal
         real(c_double), intent(inout) :: pivots(*)
         integer(c_int) :: status
      end function reading_real

      !> The same for complex matrices.
      function reading_complex(lp, lj, lx, lz, up, ui, ux, uz, p, order, pivots, imaginary, reciprocal, scale, numeric) bind(c) &
         result(status)
         import :: c_double_complex, c_int, c_ptr
         implicit none (type, external)
         type(c_ptr), value :: lp, lj, lx, lz, up, ui, ux, uz, p, imaginary, scale, numeric
         integer(c_int), intent(inout) :: order(*), reciprocal
         complex(c_double_complex), intent(inout) :: pivots(*)
         integer(c_int) :: status
      end function reading_complex

      !> Gives memory back; the pointer is null afterwards.
      subroutine release(object) bind(c)
         import :: c_ptr
         implicit none (type, external)
         type(c_ptr), intent(inout) :: object
      end subroutine release
   end interface

   !> Its procedures.
   type :: umfpack_t
      procedure(set_defaults), nopass, pointer :: defaults => null()
      procedure(analysis_real), nopass, pointer :: analyze_real => null()
      procedure(analysis_complex), nopass, pointer :: analyze_complex => null()
      procedure(factorization_real), nopass, pointer :: factorize_real => null()
      procedure(factorization_complex), nopass, pointer :: factorize_complex => null()
      procedure(solution_real), nopass, pointer :: solve_real => null()
      procedure(solution_complex), nopass, pointer :: solve_complex => null()
      procedure(reading_real), nopass, pointer :: read_real => null()
      procedure(reading_complex), nopass, pointer :: read_complex => null()
      procedure(release), nopass, pointer :: free_analysis_real => null(), free_analysis_complex => null()
      procedure(release), nopass, pointer :: free_factors_real => null(), free_factors_complex => null()
   contains
      procedure :: find
   end type umfpack_t

contains

   !> Looks for the library.
   subroutine find(self, files, found)
      !> Its procedures.
      class(umfpack_t), intent(inout) :: self
      !> What the library may be called.
      character(*), intent(in) :: files(:)
      !> Whether it is there, with all that is needed of it.
      logical, intent(out) :: found
      type(c_funptr) :: at(13)
      type(c_ptr) :: library
      integer :: i
      character(len=26), parameter :: names(13) = [character(len=26) :: 'umfpack_di_defaults', 'umfpack_di_symbolic', &
         'umfpack_zi_symbolic', 'umfpack_di_numeric', 'umfpack_zi_numeric', 'umfpack_di_wsolve', 'umfpack_zi_wsolve', &
         'umfpack_di_get_numeric', 'umfpack_zi_get_numeric', 'umfpack_di_free_symbolic', 'umfpack_zi_free_symbolic', &
         'umfpack_di_free_numeric', 'umfpack_zi_free_numeric']

      found = .false.
      do i = 1, size(files)
         library = open_library(files(i))
         if (c_associated(library)) exit
      end do
      if (.not. c_associated(library)) return
      do i = 1, size(names)
         at(i) = procedure_named(names(i), library)
         if (.not. c_associated(at(i))) return
      end do
      call c_f_procpointer(at(1), self%defaults)
      call c_f_procpointer(at(2), self%analyze_real)
      call c_f_procpointer(at(3), self%analyze_complex)
      call c_f_procpointer(at(4), self%factorize_real)
      call c_f_procpointer(at(5), self%factorize_complex)
      call c_f_procpointer(at(6), self%solve_real)
      call c_f_procpointer(at(7), self%solve_complex)
      call c_f_procpointer(at(8), self%read_real)
      call c_f_procpointer(at(9), self%read_complex)
      call c_f_procpointer(at(10), self%free_analysis_real)
      call c_f_procpointer(at(11), self%free_analysis_complex)
      call c_f_procpointer(at(12), self%free_factors_real)
      call c_f_procpointer(at(13), self%free_factors_complex)
      found = .true.
   end subroutine find

end module taut_linalg_umfpack
