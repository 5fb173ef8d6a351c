!> What procedures of a system claim to be: functions of coordinates and time alone, and a `normalize` that ends what it begins.
module taut_constrained_verify_claims
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_kinds, only: wp
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_constrained_verify_finding, only: entry_name, finding_t, largest, note, size_of, unset
   use taut_linalg_block_diagonal, only: block_diagonal_t
   implicit none (type, external)
   private
   public :: check_arguments, check_normalize

contains

   !> phi, A, b' and M at other velocities: they are the same, for they are functions of coordinates and time. Where there are
   !! states that are not mechanics, b' has their rates, and these may depend on velocities.
   subroutine check_arguments(model, at, allowed, findings)
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> The state at which it is evaluated.
      type(state_t), intent(in) :: at
      !> Difference that is let pass, relative to the largest entry of what is compared.
      real(wp), intent(in) :: allowed
      !> Gets what is found.
      type(finding_t), allocatable, intent(inout) :: findings(:)
      type(state_t) :: faster
      type(block_diagonal_t) :: m
      real(wp), allocatable :: first(:), second(:), a(:, :), a_faster(:, :), k(:, :), k_faster(:, :)
      integer :: i

      faster = at
      faster%v = at%v + [(size_of(at%v)*cos(2.1_wp*i + 0.2_wp), i=1, model%n)]
      allocate (first(model%n_phi), second(model%n_phi), source=unset())
      call model%constraint(at, first)
      call model%constraint(faster, second)
      call compare_columns('phi', 0, first, second, max(largest(first), size_of(at%x)))
      deallocate (first, second)
      allocate (first(model%c), second(model%c), source=unset())
      call model%velocity_rhs(at, first)
      call model%velocity_rhs(faster, second)
      if (model%n_w == 0) call compare_columns("b'", 0, first, second, max(largest(first), size_of(at%v)))
      allocate (a(model%c, model%n), a_faster(model%c, model%n), source=unset())
      call model%jacobian(at, a)
      call model%jacobian(faster, a_faster)
      call m%init(model%mass_blocks)
      m%values(:) = unset()
      call model%mass(at, m)
      k = m%dense()
      call model%mass(faster, m)
      k_faster = m%dense()
      do i = 1, model%n
         call compare_columns('A', i, a(:, i), a_faster(:, i), largest(reshape(a, [size(a)])))
         call compare_columns('M', i, k(:, i), k_faster(:, i), largest(reshape(k, [size(k)])))
      end do

   contains

      !> The first entry that differs.
      subroutine compare_columns(what, column, before, after, scale)
         character(*), intent(in) :: what
         integer, intent(in) :: column
         real(wp), intent(in) :: before(:), after(:), scale
         integer :: row

         do row = 1, size(before)
            if (.not. (ieee_is_finite(before(row)) .and. ieee_is_finite(after(row)))) cycle
            if (abs(after(row) - before(row)) <= allowed*scale) cycle
            call note(what, row, column, after(row), before(row), trim(entry_name(what, row, column))// &
                      ' depends on the velocities, and is to be a function of coordinates and time alone', findings)
            return
         end do
      end subroutine compare_columns

   end subroutine check_arguments

   !> Coordinates that are on their own manifold stay where they are.
   subroutine check_normalize(model, at, allowed, findings)
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> The state at which it is evaluated.
      type(state_t), intent(in) :: at
      !> Difference that is let pass, relative to the largest coordinate.
      real(wp), intent(in) :: allowed
      !> Gets what is found.
      type(finding_t), allocatable, intent(inout) :: findings(:)
      real(wp) :: once(model%n_x), twice(model%n_x)
      integer :: i

      once = at%x
      call model%normalize(once)
      twice = once
      call model%normalize(twice)
      do i = 1, model%n_x
         if (.not. ieee_is_finite(twice(i) - once(i))) cycle
         if (abs(twice(i) - once(i)) <= allowed*size_of(once)) cycle
         call note('x', i, 0, twice(i), once(i), trim(entry_name('x', i, 0))// &
                   ' is changed by normalize, though it has been normalized', findings)
         return
      end do
   end subroutine check_normalize

end module taut_constrained_verify_claims
