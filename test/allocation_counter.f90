!> Counts heap allocations of the whole program: takes the place of the C library's `malloc` and its kin, and passes on to
!! those of the GNU C library.
!!
!! GNU Fortran keeps what expressions need meanwhile on the stack. Others do not (flang: results of functions that are arrays, what is
!! formed between brackets): their counts say nothing of the code.
module allocation_counter
   use, intrinsic :: iso_c_binding, only: c_ptr, c_size_t
   use, intrinsic :: iso_fortran_env, only: compiler_version, int64
   implicit none (type, external)
   private
   public :: allocations, counts_matter

   !> Whether allocations are those that the code asks for.
   logical, parameter :: counts_matter = index(compiler_version(), 'GCC') > 0

   !> Allocations since the program's start.
   integer(int64), protected :: allocations = 0

   interface
      function gnu_malloc(size) bind(c, name='__libc_malloc') result(memory)
         import :: c_ptr, c_size_t
         implicit none (type, external)
         integer(c_size_t), value :: size
         type(c_ptr) :: memory
      end function gnu_malloc

      function gnu_calloc(count, size) bind(c, name='__libc_calloc') result(memory)
         import :: c_ptr, c_size_t
         implicit none (type, external)
         integer(c_size_t), value :: count, size
         type(c_ptr) :: memory
      end function gnu_calloc

      function gnu_realloc(old, size) bind(c, name='__libc_realloc') result(memory)
         import :: c_ptr, c_size_t
         implicit none (type, external)
         type(c_ptr), value :: old
         integer(c_size_t), value :: size
         type(c_ptr) :: memory
      end function gnu_realloc
   end interface

contains

   function counted_malloc(size) bind(c, name='malloc') result(memory)
      integer(c_size_t), value :: size
      type(c_ptr) :: memory

      allocations = allocations + 1
      memory = gnu_malloc(size)
   end function counted_malloc

   function counted_calloc(count, size) bind(c, name='calloc') result(memory)
      integer(c_size_t), value :: count, size
      type(c_ptr) :: memory

      allocations = allocations + 1
      memory = gnu_calloc(count, size)
   end function counted_calloc

   function counted_realloc(old, size) bind(c, name='realloc') result(memory)
      type(c_ptr), value :: old
      integer(c_size_t), value :: size
      type(c_ptr) :: memory

      allocations = allocations + 1
      memory = gnu_realloc(old, size)
   end function counted_realloc

end module allocation_counter
