!> The version of taut.
module taut_version
   implicit none (type, external)
   private

   !> As in fpm.toml.
   character(*), parameter, public :: version = '0.1.0'
end module taut_version
