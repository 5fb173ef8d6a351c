!> Procedures of C that are looked up by their names at run time, so that programs link without them.
module taut_shared_library
   use, intrinsic :: iso_c_binding, only: c_char, c_funptr, c_int, c_null_char, c_null_ptr, c_ptr
   implicit none (type, external)
   private
   public :: open_library, procedure_named

   !> Whoever needs a library needs all of it, at once.
   integer(c_int), parameter :: resolve_now = 2_c_int

   interface
      function c_dlopen(name, mode) bind(c, name='dlopen') result(library)
         import :: c_char, c_int, c_ptr
         implicit none (type, external)
         character(kind=c_char), intent(in) :: name(*)
         integer(c_int), value :: mode
         type(c_ptr) :: library
      end function c_dlopen

      function c_dlsym(library, name) bind(c, name='dlsym') result(procedure)
         import :: c_char, c_funptr, c_ptr
         implicit none (type, external)
         type(c_ptr), value :: library
         character(kind=c_char), intent(in) :: name(*)
         type(c_funptr) :: procedure
      end function c_dlsym
   end interface

contains

   !> A library, where the system has it. It stays for as long as the program runs; opened again, it is the same.
   function open_library(name) result(library)
      !> The name of its file.
      character(*), intent(in) :: name
      !> The library; null if it is not there.
      type(c_ptr) :: library

      library = c_dlopen(trim(name)//c_null_char, resolve_now)
   end function open_library

   !> A procedure of a library, or of the running program.
   function procedure_named(name, library) result(procedure)
      !> Its name in C.
      character(*), intent(in) :: name
      !> The library. Default: the program, with all that it is linked with.
      type(c_ptr), intent(in), optional :: library
      !> Where it is; null if it is not there.
      type(c_funptr) :: procedure

      if (present(library)) then
         procedure = c_dlsym(library, trim(name)//c_null_char)
      else
         procedure = c_dlsym(c_null_ptr, trim(name)//c_null_char)
      end if
   end function procedure_named

end module taut_shared_library
