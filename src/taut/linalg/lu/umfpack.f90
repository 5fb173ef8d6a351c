!> Factors of sparse matrices by UMFPACK, where the system has it.
module taut_linalg_lu_umfpack
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use, intrinsic :: iso_c_binding, only: c_associated, c_int, c_intptr_t, c_loc, c_null_ptr, c_ptr
   use taut_kinds, only: wp
   use taut_linalg_lu, only: lu_not_finite, lu_t, lu_too_large
   use taut_linalg_umfpack, only: control_size, info_size, umfpack_t
   implicit none (type, external)
   private
   public :: umfpack_lu_t

   !> Its answers: all is well; the matrix is singular. Numbers of its results, from 1 on: the strategy that it takes, and with the
   !! symmetric one entries and operations; else bounds of the entries of L and U, and of the operations.
   integer(c_int), parameter :: umfpack_ok = 0, umfpack_singular = 1
   integer, parameter :: strategy_used = 19, symmetric_entries = 37, symmetric_work = 38, work_bound = 23, lower_bound = 24, &
                         upper_bound = 25
   integer, parameter :: symmetric_strategy = 3
   !> A x = b.
   integer(c_int), parameter :: as_it_is = 0

   !> Whose what the library keeps is. It outlives its owner, for copies of that point to it too: a few bytes.
   type :: ownership_t
      !> Where the owner is; 0 where it is no more.
      integer(c_intptr_t) :: owner = 0
   end type ownership_t

   !> The pattern by columns, the values, and what the library has made of them.
   type, extends(lu_t) :: umfpack_lu_t
      !> Whether the library was found and has taken the pattern: else nothing here is of use.
      logical :: ready = .false.
      type(umfpack_t) :: library
      real(wp), private :: control(control_size) = 0.0_wp, work_of_real = 0.0_wp, numbers_of_real = 0.0_wp
      !> First entry of each column, rows, from 0 on; where each entry of the given pattern goes.
      integer(c_int), allocatable, private :: first(:), row_of(:)
      integer, allocatable, private :: place(:)
      real(wp), allocatable, private :: real_values(:), real_b(:), real_work(:)
      complex(wp), allocatable, private :: complex_values(:), complex_b(:)
      integer(c_int), allocatable, private :: places(:)
      !> What the library keeps, of the real and of the complex matrix; it belongs to one object, and not to its copies.
      type(c_ptr), private :: analysis(2) = c_null_ptr, factors(2) = c_null_ptr
      type(ownership_t), pointer, private :: ownership => null()
   contains
      procedure :: init
      procedure :: work
      procedure :: numbers
      procedure :: factorize_real
      procedure :: factorize_complex
      procedure :: solve_real
      procedure :: solve_complex
      final :: clear
   end type umfpack_lu_t

contains

   !> Takes a pattern, of which the library finds the order once for all.
   subroutine init(self, n, row, column)
      !> The factors, with the library found.
      class(umfpack_lu_t), intent(inout) :: self
      !> Order of the matrix.
      integer, intent(in) :: n
      !> Row of each entry: (entries).
      integer, intent(in) :: row(:)
      !> Column of each entry: (entries).
      integer, intent(in) :: column(:)

      self%n = n
      self%row = row
      self%column = column
      call by_columns(self)
      allocate (self%real_values(size(self%row_of)), self%real_b(n), self%places(n))
      call self%library%defaults(self%control)
      ! Room for the workspace of complex solutions that are improved.
      allocate (self%real_work(10*n))
      call analyze(self)
   end subroutine init

   !> Has the library find an order, for real matrices.
   subroutine analyze(self)
      type(umfpack_lu_t), intent(inout) :: self
      real(wp) :: info(info_size)

      allocate (self%ownership)
      self%ownership%owner = address_of(self)
      self%ready = self%library%analyze_real(self%n, self%n, self%first, self%row_of, c_null_ptr, self%analysis(1), self%control, &
                                             info) == umfpack_ok
      if (.not. self%ready) return
      if (nint(info(strategy_used)) == symmetric_strategy) then
         self%work_of_real = 0.5_wp*info(symmetric_work)
         self%numbers_of_real = info(symmetric_entries)
      else
         self%work_of_real = 0.5_wp*info(work_bound)
         self%numbers_of_real = info(lower_bound) + info(upper_bound)
      end if
   end subroutine analyze

   !> Where an object is.
   function address_of(self) result(address)
      type(umfpack_lu_t), intent(in), target :: self
      integer(c_intptr_t) :: address

      address = transfer(c_loc(self%n), address)
   end function address_of

   !> Whether what the library keeps is this object's. An address alone does not tell: a copy may be where the owner has been.
   logical function is_owner(self)
      type(umfpack_lu_t), intent(in) :: self

      is_owner = associated(self%ownership)
      if (is_owner) is_owner = self%ownership%owner == address_of(self)
   end function is_owner

   !> A copy has nothing of the library's yet: it gets its own, of the values that it has.
   subroutine own(self)
      type(umfpack_lu_t), intent(inout) :: self
      logical :: had(2)
      integer :: info

      if (is_owner(self)) return
      had = [c_associated(self%factors(1)), c_associated(self%factors(2))]
      self%analysis(:) = c_null_ptr
      self%factors(:) = c_null_ptr
      call analyze(self)
      if (had(1)) call compute_real(self, info)
      if (had(2)) call compute_complex(self, info)
   end subroutine own

   !> Sorts the pattern by columns and rows; entries that are named twice are one.
   subroutine by_columns(self)
      type(umfpack_lu_t), intent(inout) :: self
      integer :: count(self%n + 1), by_row(size(self%row)), in_order(size(self%row)), i, j, k, last

      associate (row => self%row, column => self%column)
         call sort(row, [(k, k=1, size(row))], by_row)
         call sort(column, by_row, in_order)
         allocate (self%first(self%n + 1), self%place(size(row)))
         count = 0
         last = 0
         do i = 1, size(row)
            k = in_order(i)
            j = in_order(max(1, i - 1))
            if (i == 1 .or. row(k) /= row(j) .or. column(k) /= column(j)) last = last + 1
            self%place(k) = last
            count(column(k) + 1) = last
         end do
         allocate (self%row_of(last))
         self%first(1) = 0_c_int
         do j = 1, self%n
            self%first(j + 1) = int(max(count(j + 1), int(self%first(j))), c_int)
         end do
         do k = 1, size(row)
            self%row_of(self%place(k)) = int(row(k) - 1, c_int)
         end do
      end associate

   contains

      !> Entries in the order of a key, those of the same key as they were.
      subroutine sort(key, before, after)
         integer, intent(in) :: key(:), before(:)
         integer, intent(out) :: after(:)
         integer :: next(self%n + 1), l

         next = 0
         do l = 1, size(key)
            next(key(l) + 1) = next(key(l) + 1) + 1
         end do
         next(1) = 1
         do l = 1, self%n
            next(l + 1) = next(l) + next(l + 1)
         end do
         do l = 1, size(before)
            after(next(key(before(l)))) = before(l)
            next(key(before(l))) = next(key(before(l))) + 1
         end do
      end subroutine sort

   end subroutine by_columns

   !> Multiplications of the factorization, as the analysis expects them.
   function work(self) result(number)
      !> The factors, laid out.
      class(umfpack_lu_t), intent(in) :: self
      !> How many.
      real(wp) :: number

      number = self%work_of_real
   end function work

   !> Numbers of the factors, as the analysis expects them.
   function numbers(self) result(number)
      !> The factors, laid out.
      class(umfpack_lu_t), intent(in) :: self
      !> How many.
      real(wp) :: number

      number = self%numbers_of_real
   end function numbers

   !> Factorizes a real matrix.
   subroutine factorize_real(self, values, info)
      !> The factors.
      class(umfpack_lu_t), intent(inout) :: self
      !> The entries: (entries of the pattern).
      real(wp), intent(in) :: values(:)
      !> As `lu_t` has it.
      integer, intent(out) :: info
      integer :: k

      call own(self)
      info = lu_not_finite
      self%real_values(:) = 0.0_wp
      do k = 1, size(values)
         if (.not. ieee_is_finite(values(k))) return
         self%real_values(self%place(k)) = self%real_values(self%place(k)) + values(k)
      end do
      call compute_real(self, info)
   end subroutine factorize_real

   !> The factors of the values.
   subroutine compute_real(self, info)
      type(umfpack_lu_t), intent(inout) :: self
      integer, intent(out) :: info
      real(wp) :: told(info_size)
      integer(c_int) :: status

      call self%library%free_factors_real(self%factors(1))
      status = self%library%factorize_real(self%first, self%row_of, self%real_values, self%analysis(1), self%factors(1), &
                                           self%control, told)
      info = 0
      if (status == umfpack_singular) then
         info = zero_pivot_real(self)
      else if (status /= umfpack_ok) then
         info = lu_too_large
      end if
   end subroutine compute_real

   !> The column of the first pivot that vanishes.
   integer function zero_pivot_real(self)
      type(umfpack_lu_t), intent(in) :: self
      real(wp) :: pivots(self%n)
      integer(c_int) :: order(self%n), reciprocal, status

      status = self%library%read_real(c_null_ptr, c_null_ptr, c_null_ptr, c_null_ptr, c_null_ptr, c_null_ptr, c_null_ptr, order, &
                                      pivots, reciprocal, c_null_ptr, self%factors(1))
      zero_pivot_real = order(max(1, findloc(abs(pivots) > 0.0_wp, .false., 1))) + 1
   end function zero_pivot_real

   !> Factorizes a complex matrix.
   subroutine factorize_complex(self, values, info)
      !> The factors.
      class(umfpack_lu_t), intent(inout) :: self
      !> The entries: (entries of the pattern).
      complex(wp), intent(in) :: values(:)
      !> As `lu_t` has it.
      integer, intent(out) :: info
      integer :: k

      call own(self)
      if (.not. allocated(self%complex_values)) allocate (self%complex_values(size(self%row_of)), self%complex_b(self%n))
      info = lu_not_finite
      self%complex_values(:) = (0.0_wp, 0.0_wp)
      do k = 1, size(values)
         if (.not. (ieee_is_finite(real(values(k))) .and. ieee_is_finite(aimag(values(k))))) return
         self%complex_values(self%place(k)) = self%complex_values(self%place(k)) + values(k)
      end do
      call compute_complex(self, info)
   end subroutine factorize_complex

   !> The factors of the values, with the order of the columns that is found for the first of them.
   subroutine compute_complex(self, info)
      type(umfpack_lu_t), intent(inout) :: self
      integer, intent(out) :: info
      real(wp) :: told(info_size)
      integer(c_int) :: status

      status = umfpack_ok
      if (.not. c_associated(self%analysis(2))) &
         status = self%library%analyze_complex(self%n, self%n, self%first, self%row_of, c_null_ptr, c_null_ptr, &
                                               self%analysis(2), self%control, told)
      call self%library%free_factors_complex(self%factors(2))
      if (status == umfpack_ok) &
         status = self%library%factorize_complex(self%first, self%row_of, self%complex_values, c_null_ptr, self%analysis(2), &
                                                 self%factors(2), self%control, told)
      info = 0
      if (status == umfpack_singular) then
         info = zero_pivot_complex(self)
      else if (status /= umfpack_ok) then
         info = lu_too_large
      end if
   end subroutine compute_complex

   !> The column of the first pivot that vanishes.
   integer function zero_pivot_complex(self)
      type(umfpack_lu_t), intent(in) :: self
      complex(wp) :: pivots(self%n)
      integer(c_int) :: order(self%n), reciprocal, status

      status = self%library%read_complex(c_null_ptr, c_null_ptr, c_null_ptr, c_null_ptr, c_null_ptr, c_null_ptr, c_null_ptr, &
                                         c_null_ptr, c_null_ptr, order, pivots, c_null_ptr, reciprocal, c_null_ptr, &
                                         self%factors(2))
      zero_pivot_complex = order(max(1, findloc(abs(pivots) > 0.0_wp, .false., 1))) + 1
   end function zero_pivot_complex

   !> Solves with the factors of the real matrix.
   subroutine solve_real(self, x)
      !> The factors.
      class(umfpack_lu_t), intent(inout) :: self
      !> Right-hand side, replaced by the solution: (n).
      real(wp), intent(inout) :: x(:)
      real(wp) :: told(info_size)
      integer(c_int) :: status

      call own(self)
      self%real_b(:) = x
      status = self%library%solve_real(as_it_is, self%first, self%row_of, self%real_values, x, self%real_b, self%factors(1), &
                                       self%control, told, self%places, self%real_work)
   end subroutine solve_real

   !> Solves with the factors of the complex matrix.
   subroutine solve_complex(self, x)
      !> The factors.
      class(umfpack_lu_t), intent(inout) :: self
      !> Right-hand side, replaced by the solution: (n).
      complex(wp), intent(inout) :: x(:)
      real(wp) :: told(info_size)
      integer(c_int) :: status

      call own(self)
      self%complex_b(:) = x
      status = self%library%solve_complex(as_it_is, self%first, self%row_of, self%complex_values, c_null_ptr, x, c_null_ptr, &
                                          self%complex_b, c_null_ptr, self%factors(2), self%control, told, self%places, &
                                          self%real_work)
   end subroutine solve_complex

   !> Gives back what the library holds.
   subroutine clear(self)
      !> The factors.
      type(umfpack_lu_t), intent(inout) :: self

      if (.not. is_owner(self)) return
      self%ownership%owner = 0
      if (c_associated(self%factors(1))) call self%library%free_factors_real(self%factors(1))
      if (c_associated(self%factors(2))) call self%library%free_factors_complex(self%factors(2))
      if (c_associated(self%analysis(1))) call self%library%free_analysis_real(self%analysis(1))
      if (c_associated(self%analysis(2))) call self%library%free_analysis_complex(self%analysis(2))
   end subroutine clear

end module taut_linalg_lu_umfpack
