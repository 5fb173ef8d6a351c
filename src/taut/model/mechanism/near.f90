!> Joints that all but repeat each other, or are all but at a dead point: what an exact decision on the rank cannot tell.
!!
!! A linkage in the plane whose hinges are drawn in space holds some motions twice; one axis that is a little off, and it holds
!! still. A driven crank at its dead point is held by its rods. In both cases a row of A is a combination of others but for
!! a small part, which a factorization of A^T with exchanged columns shows: as the last pivots, far below those before.
submodule(taut_model_mechanism) taut_model_mechanism_near
   use taut_error, only: to_text
   use taut_linalg_lapack, only: dgeqp3, dtrtrs
   use taut_model_mechanism_body, only: turned
   use taut_model_mechanism_joint_table, only: joint_kinds
   use taut_rotation, only: cross
   implicit none (type, external)

   !> Rows of unit length repeat others if this is left of them; what is less than the second is dependence as it is to be; what is
   !! left is that far below the others; where nothing is free, larger ones are told.
   real(wp), parameter :: near = 1.0e-5_wp, exact = 1.0e-11_wp, gap = 0.1_wp, near_when_held = 2.0e-2_wp
   !> Rows with less than this part in a combination have none.
   real(wp), parameter :: no_part = 1.0e-3_wp
   !> Larger matrices are not searched.
   integer, parameter :: most_rows = 500

contains

   !> Joints that all but repeat each other.
   module procedure diagnose
      real(wp), allocatable :: part(:, :), r(:, :), tau(:), work(:)
      real(wp) :: left, query(1)
      integer, allocatable :: pivot(:)
      logical :: involved(size(self%joints)), driven(size(self%joints))
      integer :: first, i, info, k, last

      if (self%c == 0 .or. self%c > most_rows .or. self%n > most_rows) return
      call unit_rows(self, at, r)
      allocate (pivot(self%c), source=0)
      allocate (tau(min(self%n, self%c)), source=0.0_wp)
      call dgeqp3(self%n, self%c, r, self%n, pivot, tau, query, -1, info)
      allocate (work(int(query(1))), source=0.0_wp)
      call dgeqp3(self%n, self%c, r, self%n, pivot, tau, work, size(work), info)
      if (info /= 0) return
      ! The first pivot after a gap, and the last that is no exact dependence.
      last = count([(abs(r(i, i)) > exact, i=1, size(tau))])
      left = merge(near_when_held, near, count([(abs(r(i, i)) > near, i=1, size(tau))]) == self%n)
      first = 0
      do i = 2, last
         if (abs(r(i, i)) <= min(left, gap*abs(r(i - 1, i - 1)))) then
            first = i
            exit
         end if
      end do
      if (first == 0) return

      k = first - 1
      part = r(:k, first:last)
      call dtrtrs('U', 'N', 'N', k, last - k, r, self%n, part, k, info)
      if (info /= 0) return
      involved = .false.
      driven = .false.
      do i = 1, last
         if (i <= k) then
            if (maxval(abs(part(i, :))) <= no_part) cycle
         end if
         associate (joint => self%joint_of_row(pivot(i)))
            involved(joint) = .true.
            if (self%rows(pivot(i))%drive > 0) driven(joint) = .true.
         end associate
      end do
      call say_so()

   contains

      !> In words.
      subroutine say_so()
         real(wp) :: angle
         integer :: odd, other

         text = names_of(self, involved)//' all but repeat each other, '//to_text(abs(r(first, first)))//' is left'
         call odd_axis(self, at, involved, odd, other, angle)
         if (any(driven)) then
            text = text//': a dead point, where '//names_of(self, driven)// &
                   ' cannot be driven; drive another joint, or end before it'
         else if (odd > 0) then
            text = text//': the axis of '//self%joints(odd)%name//' is '//to_text(angle)//' rad off that of '// &
                   self%joints(other)%name//'; give it the same, or take a joint that leaves it free, such as a spherical one'
         else
            text = text//'; make them fit to the last digit, or leave one out'
         end if
      end subroutine say_so

   end procedure diagnose

   !> A^T, each set of columns of A of one size and each row of unit length: (n, c).
   subroutine unit_rows(self, at, transposed)
      class(mechanism_t), intent(in) :: self
      type(state_t), intent(in) :: at
      real(wp), allocatable, intent(out) :: transposed(:, :)
      real(wp), allocatable :: a(:, :)
      integer, allocatable :: group(:)
      real(wp) :: length
      integer :: i

      allocate (a(self%c, self%n))
      call self%jacobian(at, a)
      transposed = transpose(a)
      call self%column_groups(group)
      do i = 1, self%n
         length = maxval(abs(a(:, pack([(i, i=1, self%n)], group == group(i)))))
         if (length > 0.0_wp) transposed(i, :) = transposed(i, :)/length
      end do
      do i = 1, self%c
         length = norm2(transposed(:, i))
         if (length > 0.0_wp) transposed(:, i) = transposed(:, i)/length
      end do
   end subroutine unit_rows

   !> Such as A, B and C.
   function names_of(self, which) result(names)
      class(mechanism_t), intent(in) :: self
      logical, intent(in) :: which(:)
      character(:), allocatable :: names
      integer :: i, left

      names = ''
      left = count(which)
      do i = 1, size(which)
         if (.not. which(i)) cycle
         left = left - 1
         if (len(names) > 200) then
            names = names//' and '//to_text(left + 1)//' more'
            return
         end if
         if (len(names) > 0) names = names//trim(merge(' and', ',   ', left == 0))//' '
         names = names//self%joints(i)%name
      end do
   end function names_of

   !> The joint whose axis is a little off those of others that are parallel, and one of these; 0 if there is none.
   subroutine odd_axis(self, at, involved, odd, other, angle)
      class(mechanism_t), intent(in) :: self
      type(state_t), intent(in) :: at
      logical, intent(in) :: involved(:)
      integer, intent(out) :: odd, other
      real(wp), intent(out) :: angle
      type(pose_t) :: it
      real(wp) :: axis(3, size(involved)), off
      integer :: i, j, parallel(size(involved))
      logical :: has_axis(size(involved))

      odd = 0
      other = 0
      angle = near_when_held
      has_axis = .false.
      do i = 1, size(involved)
         if (.not. involved(i) .or. self%planar) cycle
         has_axis(i) = joint_kinds(self%joints(i)%type)%needs_axis
         call self%pose_of(at, self%joints(i)%body_1, it)
         axis(:, i) = turned(it%r, self%joints(i)%frame_1(:, 3))
      end do
      do i = 1, size(involved)
         parallel(i) = 0
         do j = 1, size(involved)
            if (.not. (has_axis(i) .and. has_axis(j)) .or. i == j) cycle
            if (norm2(cross(axis(:, i), axis(:, j))) <= exact) parallel(i) = parallel(i) + 1
         end do
      end do
      do i = 1, size(involved)
         do j = 1, size(involved)
            if (.not. (has_axis(i) .and. has_axis(j)) .or. parallel(i) >= parallel(j)) cycle
            off = norm2(cross(axis(:, i), axis(:, j)))
            if (off <= exact .or. off >= angle) cycle
            angle = off
            odd = i
            other = j
         end do
      end do
   end subroutine odd_axis

end submodule taut_model_mechanism_near
