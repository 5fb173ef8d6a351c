!> Null vectors of A^T of a mechanism: which of them go together, and what forces and moments they make at its joints.
module taut_model_mechanism_null_vectors
   use taut_kinds, only: wp
   use taut_constrained_system, only: state_t
   use taut_linalg_row_selection, only: row_selection_t
   use taut_linalg_sparse_factor, only: sort
   use taut_model_mechanism, only: mechanism_t
   implicit none (type, external)
   private
   public :: null_vector_t, circle_t, lists_t, multipliers_t
   public :: find_null_vector, find_circles, lists_by, loads_of, separate, rank_of

   !> A null vector: its entries that are not zero, the joints that they belong to, and the bodies that these join.
   type :: null_vector_t
      integer, allocatable :: row(:), joint(:), body(:)
      real(wp), allocatable :: value(:)
   end type null_vector_t

   !> Joints whose null vectors go together, and those.
   type :: circle_t
      integer, allocatable :: joint(:), vector(:)
   end type circle_t

   !> Lists of numbers, one for each of many.
   type :: lists_t
      integer, allocatable :: first(:), of(:)
   end type lists_t

   !> Multipliers that are zero between calls: (c) each.
   type :: multipliers_t
      real(wp), allocatable :: all(:), one(:)
   end type multipliers_t

   !> Parts of null vectors and of what they make that are this much smaller than others are zero.
   real(wp), parameter :: nothing = 1.0e-6_wp
   !> A difference of two numbers that is this much smaller than they are is none.
   real(wp), parameter :: round_off = 64.0_wp*epsilon(1.0_wp)

contains

   !> The null vector of a row that is left out.
   subroutine find_null_vector(model, selection, k, null)
      !> The mechanism.
      type(mechanism_t), intent(in) :: model
      !> Its rows, selected.
      type(row_selection_t), intent(inout) :: selection
      !> The row.
      integer, intent(in) :: k
      !> Its null vector.
      type(null_vector_t), intent(out) :: null
      integer, allocatable :: body(:), row(:)
      real(wp), allocatable :: value(:)
      integer :: i

      call selection%null_vector(k, row, value)
      null%row = pack(row, abs(value) > nothing*selection%rows%row_scale(row))
      null%value = pack(value, abs(value) > nothing*selection%rows%row_scale(row))
      null%joint = set_of(model%joint_of_row(null%row))
      body = [(model%joints(null%joint(i))%body_1, model%joints(null%joint(i))%body_2, i=1, size(null%joint))]
      null%body = set_of(pack(body, body > 0))
   end subroutine find_null_vector

   !> Each number once, ascending.
   pure function set_of(list) result(set)
      integer, intent(in) :: list(:)
      integer, allocatable :: set(:)
      integer :: i

      set = list
      call sort(set)
      set = pack(set, [(i == 1 .or. set(max(i - 1, 1)) /= set(i), i=1, size(set))])
   end function set_of

   !> Whether a set has all that another one has; both ascending.
   pure logical function contains_all(set, other)
      integer, intent(in) :: set(:), other(:)
      integer :: i, k

      k = 1
      do i = 1, size(set)
         if (k > size(other)) exit
         if (set(i) == other(k)) k = k + 1
      end do
      contains_all = k > size(other)
   end function contains_all

   !> Null vectors are one circle with those of no other bodies than its own: a loop has one, loops that share a body have two.
   subroutine find_circles(bodies, null, circle)
      !> How many bodies there are.
      integer, intent(in) :: bodies
      !> Null vectors.
      type(null_vector_t), intent(in) :: null(:)
      !> Those that go together.
      type(circle_t), allocatable, intent(out) :: circle(:)
      type(lists_t) :: by_size, of_circle
      integer :: last_at(bodies), number_at(bodies), circle_of(size(null))
      integer, allocatable :: circle_at(:), founder(:), joint(:), next(:)
      integer :: at, entries, i, k, known, rare

      ! Of each body, the circles that it is in, as a chain.
      allocate (circle_at(sum([(size(null(k)%body), k=1, size(null))])), source=0)
      allocate (next, source=circle_at)
      allocate (founder(size(null)), source=0)
      last_at = 0
      number_at = 0
      entries = 0
      known = 0
      ! The largest come first.
      by_size = lists_by([(bodies + 1 - size(null(k)%body), k=1, size(null))], bodies + 1)
      do i = 1, size(null)
         k = by_size%of(i)
         associate (body => null(k)%body)
            rare = body(minloc(number_at(body), 1))
            at = last_at(rare)
            do while (at > 0)
               if (contains_all(null(founder(circle_at(at)))%body, body)) exit
               at = next(at)
            end do
            if (at > 0) then
               circle_of(k) = circle_at(at)
               cycle
            end if
            known = known + 1
            founder(known) = k
            circle_of(k) = known
            circle_at(entries + 1:entries + size(body)) = known
            next(entries + 1:entries + size(body)) = last_at(body)
            last_at(body) = [(entries + at, at=1, size(body))]
            number_at(body) = number_at(body) + 1
            entries = entries + size(body)
         end associate
      end do
      of_circle = lists_by(circle_of, known)
      allocate (circle(known))
      do i = 1, known
         circle(i)%vector = of_circle%of(of_circle%first(i):of_circle%first(i + 1) - 1)
         joint = [(null(circle(i)%vector(k))%joint, k=1, size(circle(i)%vector))]
         circle(i)%joint = set_of(joint)
      end do
   end subroutine find_circles

   !> For each key from 1 on, the places where it stands, ascending.
   pure function lists_by(key, keys) result(lists)
      !> The keys.
      integer, intent(in) :: key(:)
      !> The largest one there may be.
      integer, intent(in) :: keys
      !> A list for each.
      type(lists_t) :: lists
      integer :: i, next(keys)

      allocate (lists%first(keys + 1), lists%of(size(key)), source=0)
      do i = 1, size(key)
         lists%first(key(i) + 1) = lists%first(key(i) + 1) + 1
      end do
      lists%first(1) = 1
      do i = 1, keys
         lists%first(i + 1) = lists%first(i) + lists%first(i + 1)
      end do
      next = lists%first(:keys)
      do i = 1, size(key)
         lists%of(next(key(i))) = i
         next(key(i)) = next(key(i)) + 1
      end do
   end function lists_by

   !> What null vectors make at joints, forces and moments in global axes, (3, joints, vectors) each, with the largest as 1, or 0
   !! where there is nothing but round-off.
   subroutine loads_of(model, at, null, vector, joint, lambda, force, moment)
      !> The mechanism.
      type(mechanism_t), intent(in) :: model
      !> The state at which it is looked at.
      type(state_t), intent(in) :: at
      !> Null vectors.
      type(null_vector_t), intent(in) :: null(:)
      !> Which of them.
      integer, intent(in) :: vector(:)
      !> At which joints.
      integer, intent(in) :: joint(:)
      !> Workspace.
      type(multipliers_t), intent(inout) :: lambda
      !> Forces, relative to the largest: (3, joints, vectors).
      real(wp), allocatable, intent(out) :: force(:, :, :)
      !> Moments, likewise.
      real(wp), allocatable, intent(out) :: moment(:, :, :)
      real(wp) :: f(3), largest(2), m(3)
      integer :: i, j, k

      allocate (force(3, size(joint), size(vector)), moment(3, size(joint), size(vector)))
      largest = 0.0_wp
      do k = 1, size(vector)
         associate (it => null(vector(k)))
            lambda%all(it%row) = it%value
            do j = 1, size(joint)
               call model%reaction(at, lambda%all, joint(j), force(:, j, k), moment(:, j, k))
               do i = 1, size(it%row)
                  if (model%joint_of_row(it%row(i)) /= joint(j)) cycle
                  lambda%one(it%row(i)) = it%value(i)
                  call model%reaction(at, lambda%one, joint(j), f, m)
                  lambda%one(it%row(i)) = 0.0_wp
                  ! The moment of a force through the joint's point is a difference of two; what round-off leaves is none.
                  if (norm2(m) <= round_off*norm2(f)*norm2(model%joints(joint(j))%p_2)) m = 0.0_wp
                  largest = max(largest, [norm2(f), norm2(m)])
               end do
            end do
            lambda%all(it%row) = 0.0_wp
         end associate
      end do
      where (largest <= 0.0_wp) largest = huge(1.0_wp)
      force = force/largest(1)
      moment = moment/largest(2)
   end subroutine loads_of

   !> Combines columns so that those of x are orthonormal but for the last ones, which are zero; y goes with them.
   subroutine separate(x, y, rank)
      !> Columns.
      real(wp), intent(inout) :: x(:, :)
      !> As many.
      real(wp), intent(inout) :: y(:, :)
      !> Columns of x that are not zero.
      integer, intent(out) :: rank
      real(wp) :: largest, length, t
      integer :: best, j, k

      rank = 0
      largest = 0.0_wp
      do k = 1, size(x, 2)
         best = k
         length = norm2(x(:, k))
         do j = k + 1, size(x, 2)
            if (norm2(x(:, j)) <= length) cycle
            best = j
            length = norm2(x(:, j))
         end do
         largest = max(largest, length)
         if (length <= nothing*max(1.0_wp, largest)) return
         x(:, [k, best]) = x(:, [best, k])
         y(:, [k, best]) = y(:, [best, k])
         x(:, k) = x(:, k)/length
         y(:, k) = y(:, k)/length
         do j = k + 1, size(x, 2)
            t = dot_product(x(:, k), x(:, j))
            x(:, j) = x(:, j) - t*x(:, k)
            y(:, j) = y(:, j) - t*y(:, k)
         end do
         rank = k
      end do
   end subroutine separate

   !> How many columns are independent.
   integer function rank_of(x) result(rank)
      !> The columns.
      real(wp), intent(in) :: x(:, :)
      real(wp) :: left(size(x, 1), size(x, 2)), none(1, size(x, 2))

      left = x
      none = 0.0_wp
      call separate(left, none, rank)
   end function rank_of

end module taut_model_mechanism_null_vectors
