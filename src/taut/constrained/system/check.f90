!> The sizes of a `mechanical_system_t`.
submodule(taut_constrained_system) taut_constrained_system_check
   use taut_error, only: raise, to_text
   implicit none (type, external)

   character(*), parameter :: here = 'mechanical system'

contains

   !> States the sizes of a system; to be called once, where the system is set up.
   module procedure define
      self%n = n
      self%c = c
      self%n_phi = c
      if (present(nonholonomic)) self%n_phi = c - nonholonomic
      self%n_x = n
      if (present(n_x)) self%n_x = n_x
      self%n_w = 0
      if (present(n_w)) self%n_w = n_w
      self%mass_blocks = [n]
      if (present(mass_blocks)) self%mass_blocks = mass_blocks
      self%constant_mass = .false.
      if (present(constant_mass)) self%constant_mass = constant_mass
      self%reactive = .false.
      if (present(reactive)) self%reactive = reactive
   end procedure define

   !> Whether the sizes make sense together.
   module procedure check_sizes
      if (self%n < 1) then
         call raise(error, here, 'it has no velocities', 'call its procedure define with its sizes first')
      else if (self%c < 0 .or. self%n_phi < 0 .or. self%n_phi > self%c) then
         call raise(error, here, 'it has '//to_text(self%n_phi)//' holonomic constraints of '//to_text(self%c), &
                    'give define the number of all constraints and how many of them are nonholonomic')
      else if (self%n_x < 1 .or. self%n_w < 0) then
         call raise(error, here, 'a number of coordinates or of other states is negative', &
                    'correct the call of define')
      else if (.not. allocated(self%mass_blocks)) then
         call raise(error, here, 'the blocks of its mass matrix are not stated', 'call its procedure define')
      else if (any(self%mass_blocks < 1) .or. sum(self%mass_blocks) /= self%n) then
         call raise(error, here, 'the blocks of its mass matrix do not add up to '//to_text(self%n)//' rows', &
                    'correct mass_blocks in the call of define')
      end if
      if (allocated(error)) return
      call check_pattern(self, error)
   end procedure check_sizes
   !> Whether the pattern of A, where there is one, is in order.
   subroutine check_pattern(self, error)
      class(mechanical_system_t), intent(in) :: self
      type(error_t), allocatable, intent(inout) :: error
      integer, allocatable :: first(:), column(:)
      integer :: i, k
      character(*), parameter :: remedy = 'correct its procedure pattern'

      call self%pattern(first, column)
      if (.not. (allocated(first) .or. allocated(column))) return
      if (.not. (allocated(first) .and. allocated(column))) then
         call raise(error, here, 'only one of the two arrays of the pattern of A is set', remedy)
         return
      end if
      if (size(first) /= self%c + 1) then
         call raise(error, here, 'the pattern of A has not the beginnings of '//to_text(self%c)//' rows and one more', remedy)
         return
      end if
      if (first(1) /= 1 .or. first(self%c + 1) /= size(column) + 1 .or. any(first(2:) < first(:self%c))) then
         call raise(error, here, 'the rows of the pattern of A do not follow each other from 1 to '//to_text(size(column)), &
                    remedy)
         return
      end if
      do i = 1, self%c
         do k = first(i), first(i + 1) - 1
            if (column(k) < 1 .or. column(k) > self%n) then
               call raise(error, here, 'the pattern of A names column '//to_text(column(k))//' of '//to_text(self%n)// &
                          ' in row '//to_text(i), remedy)
               return
            end if
            if (k == first(i)) cycle
            if (column(k) <= column(k - 1)) then
               call raise(error, here, 'the columns of row '//to_text(i)//' of the pattern of A do not ascend', remedy)
               return
            end if
         end do
      end do
   end subroutine check_pattern

end submodule taut_constrained_system_check
