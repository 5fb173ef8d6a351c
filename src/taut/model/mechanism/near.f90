!> Joints that all but repeat each other, or are all but at a dead point: what an exact decision on the rank cannot tell.
!!
!! A linkage in the plane whose hinges are drawn in space holds some motions twice; one axis that is a little off, and it holds
!! still. A driven crank at its dead point is held by its rods. In both cases a row of A is a combination of others but for
!! a small part, which a factorization of A^T with exchanged columns shows: as the last pivots, far below those before.
!!
!! Which of the two it is, and what is off by how much, the joints of that combination tell by themselves. With multipliers v and
!! a motion z, A^T v = sigma z: if they leave no motion, or an axis is off, they do not fit; if they leave one, they are at a
!! position where motions branch. To shift a joint's point by d changes v^T A z by d.(w x f), to turn its axis by e changes it by
!! e.(w x m + u x f), where f, m are what v makes there and w, u the motion of one body against the other: what takes sigma away is
!! the misfit.
submodule(taut_model_mechanism) taut_model_mechanism_near
   use taut_error, only: to_text
   use taut_linalg_csr, only: csr_t
   use taut_linalg_lapack, only: dgeqp3, dgesvd, dtrtrs
   use taut_linalg_rank, only: independent
   use taut_linalg_scaled_rows, only: scaled_rows_t
   use taut_model_mechanism_body, only: turned
   use taut_model_mechanism_joint_table, only: joint_kinds
   use taut_model_mechanism_row, only: row_dot
   use taut_rotation, only: cross
   implicit none (type, external)

   !> Rows of unit length repeat others if this is left of them; where nothing is free, or an axis is off, larger ones are told;
   !! what is left is that far below the others.
   real(wp), parameter :: near = 1.0e-5_wp, near_when_held = 2.0e-2_wp, gap = 0.1_wp
   !> Rows with less than this part in a combination have none.
   real(wp), parameter :: no_part = 1.0e-3_wp
   !> What is found by geometry explains sigma if it is the misfit within this factor.
   real(wp), parameter :: explains = 5.0_wp
   !> Larger matrices are not searched.
   integer, parameter :: most_rows = 500

   !> A^T in units of its own, and joints whose rows nearly depend on each other.
   type :: search_t
      !> Each set of columns of A of one size, each row of unit length: (n, c). What they were multiplied with: (n), (c).
      real(wp), allocatable :: unit(:, :), column_scale(:), row_scale(:)
      !> What is less is dependence as it is to be: round-off and what the constraints are violated by.
      real(wp) :: exact = 0.0_wp
      !> What is left of the row: 0 if none was found.
      real(wp) :: left = 0.0_wp
      !> Joints that take part, and those of them by a row that is driven: (joints).
      logical, allocatable :: involved(:), driven(:)
   end type search_t

   !> What joints that nearly repeat each other are like.
   type :: misfit_t
      !> The smallest singular value of their rows that is not zero, and the motions that they leave.
      real(wp) :: sigma = 0.0_wp
      integer :: freedoms = 0
      !> For each joint, how far its point [m] or its axis [rad] would have to go: (joints), huge for one that cannot help.
      real(wp), allocatable :: shift(:), tilt(:)
   end type misfit_t

contains

   !> Joints that all but repeat each other.
   module procedure diagnose
      type(search_t) :: all, joints
      type(misfit_t) :: misfit
      logical :: given(self%c)
      integer :: i

      if (self%c == 0 .or. self%c > most_rows .or. self%n > most_rows) return
      given = self%rows%drive > 0
      call scale_rows(self, at, joints)
      all = joints
      call search(self, .not. given, near_when_held, joints)
      if (joints%left > 0.0_wp) then
         call look_at(self, at, joints, misfit)
         if (misfit%sigma > 0.0_wp) call tell_misfit(self, at, joints, misfit, text)
         if (allocated(text)) return
      end if
      if (any(given)) then
         call search(self, [(.true., i=1, self%c)], near, all)
         if (any(all%driven)) then
            text = names_of(self, all%involved)//' all but repeat each other, '//to_text(all%left)//' is left: a dead point, '// &
                   'where '//names_of(self, all%driven)//' cannot be driven; drive another joint, or end before it'
            return
         end if
      end if
      if (joints%left > 0.0_wp .and. joints%left <= near) &
         text = names_of(self, joints%involved)//' are all but at a position where motions branch, '//to_text(joints%left)// &
                ' is left; if the run stops there, start it farther off'
   end procedure diagnose

   !> A^T in units of its own.
   subroutine scale_rows(self, at, it)
      class(mechanism_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(search_t), intent(out) :: it
      !> Round-off of pivots, of coordinates, and what violated constraints may make of it.
      real(wp), parameter :: of_pivots = 1.0e-13_wp, of_coordinates = 16.0_wp*epsilon(1.0_wp), of_violation = 10.0_wp
      type(csr_t) :: a
      type(scaled_rows_t) :: rows
      real(wp) :: coordinate(self%n), length(self%n), phi(self%n_phi)
      integer, allocatable :: group(:)
      integer :: i, k

      call a%set_pattern(self%n, self%first, self%column)
      call self%jacobian_entries(at, a%values)
      call self%column_groups(group)
      call rows%init(a, self%c, group)
      call rows%scale(a, stretch=.false.)
      allocate (it%unit(self%n, self%c), source=0.0_wp)
      do i = 1, self%c
         do k = rows%first(i), rows%first(i + 1) - 1
            it%unit(rows%column(k), i) = rows%b(k)
         end do
      end do
      it%row_scale = rows%row_scale
      it%column_scale = rows%column_scale
      call self%sizes(at, length, coordinate)
      call self%constraint(at, phi)
      it%exact = of_pivots + of_coordinates*maxval([0.0_wp, coordinate/length]) + of_violation*maxval([0.0_wp, abs(phi)])
   end subroutine scale_rows

   !> Joints whose rows nearly depend on each other.
   subroutine search(self, rows, limit, it)
      class(mechanism_t), intent(in) :: self
      !> Those that are looked at: (c).
      logical, intent(in) :: rows(:)
      !> What is left of a row is not more than this, where some motion is free.
      real(wp), intent(in) :: limit
      type(search_t), intent(inout) :: it
      real(wp), allocatable :: part(:, :), r(:, :), tau(:), work(:)
      real(wp) :: largest, query(1)
      integer, allocatable :: number(:), pivot(:)
      integer :: first, i, info, k, last

      allocate (it%involved(size(self%joints)), source=.false.)
      allocate (it%driven(size(self%joints)), source=.false.)
      number = pack([(i, i=1, self%c)], rows)
      if (size(number) == 0) return
      r = it%unit(:, number)
      allocate (pivot(size(number)), source=0)
      allocate (tau(min(self%n, size(number))), source=0.0_wp)
      call dgeqp3(self%n, size(number), r, self%n, pivot, tau, query, -1, info)
      allocate (work(int(query(1))), source=0.0_wp)
      call dgeqp3(self%n, size(number), r, self%n, pivot, tau, work, size(work), info)
      if (info /= 0) return
      ! The first pivot after a gap, and the last that is no exact dependence.
      last = count([(abs(r(i, i)) > it%exact, i=1, size(tau))])
      largest = limit
      if (count([(abs(r(i, i)) > near, i=1, size(tau))]) == self%n) largest = near_when_held
      first = 0
      do i = 2, last
         if (abs(r(i, i)) <= min(largest, gap*abs(r(i - 1, i - 1)))) then
            first = i
            exit
         end if
      end do
      if (first == 0) return
      k = first - 1
      part = r(:k, first:last)
      call dtrtrs('U', 'N', 'N', k, last - k, r, self%n, part, k, info)
      if (info /= 0) return
      it%left = abs(r(first, first))
      do i = 1, last
         if (i <= k) then
            if (maxval(abs(part(i, :))) <= no_part) cycle
         end if
         associate (joint => self%joint_of_row(number(pivot(i))))
            it%involved(joint) = .true.
            if (self%rows(number(pivot(i)))%drive > 0) it%driven(joint) = .true.
         end associate
      end do
   end subroutine search

   !> The smallest singular value of some rows, among the velocities of the bodies that they join, that is not zero, its vectors,
   !! and how many motions the rows leave.
   subroutine spectrum(self, it, rows, sigma, freedoms, motion, multiplier)
      class(mechanism_t), intent(in) :: self
      type(search_t), intent(in) :: it
      !> Which: (c).
      logical, intent(in) :: rows(:)
      !> The smallest that is not zero; 0 if there is none.
      real(wp), intent(out) :: sigma
      integer, intent(out) :: freedoms
      !> In their own units, of length one in those of the search: (n), (c).
      real(wp), intent(out) :: motion(:), multiplier(:)
      real(wp), allocatable :: b(:, :), s(:), u(:, :), vt(:, :), work(:)
      real(wp) :: query(1)
      integer, allocatable :: column(:), number(:)
      integer :: i, info, rank

      sigma = 0.0_wp
      motion = 0.0_wp
      multiplier = 0.0_wp
      number = pack([(i, i=1, self%c)], rows)
      column = pack([(i, i=1, self%n)], [(any(abs(it%unit(i, number)) > 0.0_wp), i=1, self%n)])
      freedoms = size(column)
      if (freedoms == 0) return
      b = it%unit(column, number)
      allocate (s(min(size(b, 1), size(b, 2))), u(size(b, 1), size(b, 1)), vt(size(b, 2), size(b, 2)), source=0.0_wp)
      call dgesvd('A', 'A', size(b, 1), size(b, 2), b, size(b, 1), s, u, size(u, 1), vt, size(vt, 1), query, -1, info)
      allocate (work(int(query(1))), source=0.0_wp)
      call dgesvd('A', 'A', size(b, 1), size(b, 2), b, size(b, 1), s, u, size(u, 1), vt, size(vt, 1), work, size(work), info)
      if (info /= 0) return
      rank = count(s > it%exact)
      freedoms = freedoms - rank
      if (rank == 0) return
      sigma = s(rank)
      motion(column) = u(:, rank)*it%column_scale(column)
      multiplier(number) = vt(rank, :)*it%row_scale(number)
   end subroutine spectrum

   !> What joints that nearly repeat each other leave free, and how far each would have to go to free one motion more.
   subroutine look_at(self, at, it, misfit)
      class(mechanism_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(search_t), intent(in) :: it
      type(misfit_t), intent(out) :: misfit
      type(state_t) :: moving
      type(pose_t) :: one, two
      real(wp) :: f(3), m(3), multiplier(self%c), slip(3), turning(3)
      integer :: j

      moving = at
      call spectrum(self, it, rows_of(self, it), misfit%sigma, misfit%freedoms, moving%v, multiplier)
      allocate (misfit%shift(size(self%joints)), source=huge(1.0_wp))
      allocate (misfit%tilt(size(self%joints)), source=huge(1.0_wp))
      do j = 1, size(self%joints)
         if (.not. it%involved(j)) cycle
         associate (joint => self%joints(j))
            call self%reaction(at, multiplier, j, f, m)
            call self%pose_of(moving, joint%body_1, one)
            call self%pose_of(moving, joint%body_2, two)
            turning = turned(two%r, two%w) - turned(one%r, one%w)
            slip = two%v + turned(two%r, cross(two%w, joint%p_2)) - one%v - &
                   cross(turned(one%r, one%w), two%p + turned(two%r, joint%p_2) - one%p)
         end associate
         misfit%shift(j) = misfit%sigma/max(tiny(1.0_wp), norm2(cross(turning, f)))
         misfit%tilt(j) = misfit%sigma/max(tiny(1.0_wp), norm2(cross(turning, m) + cross(slip, f)))
      end do
   end subroutine look_at

   !> Rows of the joints that take part, but for drives: (c).
   pure function rows_of(self, it) result(rows)
      class(mechanism_t), intent(in) :: self
      type(search_t), intent(in) :: it
      logical :: rows(self%c)

      rows = it%involved(self%joint_of_row) .and. self%rows%drive == 0
   end function rows_of

   !> Says which joint does not fit, by how much, and what to do; nothing where joints leave a motion and no axis is off.
   subroutine tell_misfit(self, at, it, misfit, text)
      class(mechanism_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(search_t), intent(in) :: it
      type(misfit_t), intent(in) :: misfit
      character(:), allocatable, intent(inout) :: text
      character(:), allocatable :: what
      real(wp) :: beside, off
      integer :: odd, other
      logical :: agreed

      call odd_axis(self, at, it, odd, other, off, beside, agreed)
      if (odd > 0) then
         if (.not. (fits(off, misfit%tilt(odd)) .or. fits(beside, misfit%shift(odd)))) odd = 0
      end if
      ! Joints that leave a motion fit, unless others agree on an axis and one does not.
      if (odd > 0 .and. misfit%freedoms > 0 .and. .not. agreed) odd = 0
      if (odd > 0) then
         if (fits(off, misfit%tilt(odd))) then
            what = 'the axis of '//self%joints(odd)%name//' is '//to_text(off)//' rad off that of '//self%joints(other)%name// &
                   '; give it the same, or '
            if (frees_by_turning(self, it, odd, misfit%freedoms)) then
               what = what//'take a joint that leaves it free, such as a spherical one'
            else
               what = what//'leave it out'
            end if
         else
            what = 'the axis of '//self%joints(odd)%name//' is '//to_text(beside)//' m beside that of '//self%joints(other)%name// &
                   '; put them in line, or leave one of them out'
         end if
      else if (misfit%freedoms == 0) then
         what = 'they do not fit by about '//to_text(minval(misfit%shift))//' m; make them fit to the last digit, or leave one out'
      else
         return
      end if
      if (misfit%sigma <= independent) then
         text = names_of(self, it%involved)//' all but repeat each other, and are taken to: '//what
      else if (misfit%freedoms == 0) then
         text = names_of(self, it%involved)//' hold each other, and nothing of them can move: '//what
      else
         text = names_of(self, it%involved)//' have a motion less than they would have if they fitted: '//what
      end if

   contains

      !> Whether a misfit that is seen is the one that is felt.
      pure logical function fits(seen, felt)
         real(wp), intent(in) :: seen, felt

         fits = seen > felt/explains .and. seen < felt*explains
      end function fits

   end subroutine tell_misfit

   !> Whether another motion is free where the axis of a joint is not held.
   logical function frees_by_turning(self, it, j, freedoms) result(frees)
      class(mechanism_t), intent(in) :: self
      type(search_t), intent(in) :: it
      integer, intent(in) :: j, freedoms
      real(wp) :: motion(self%n), multiplier(self%c), sigma
      integer :: left

      call spectrum(self, it, rows_of(self, it) .and. .not. (self%joint_of_row == j .and. self%rows%kind == row_dot), sigma, left, &
                    motion, multiplier)
      frees = left > freedoms
   end function frees_by_turning

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

   !> The joint whose axis is a little off those of others: not parallel to those that are parallel, or, of the same bodies, not
   !! in line.
   subroutine odd_axis(self, at, it, odd, other, off, beside, agreed)
      class(mechanism_t), intent(in) :: self
      type(state_t), intent(in) :: at
      type(search_t), intent(in) :: it
      !> The joint, and one of the others; 0 if there is none.
      integer, intent(out) :: odd, other
      !> The angle [rad] and the distance [m], 0 for what is not off.
      real(wp), intent(out) :: off, beside
      !> Whether more than one has the other axis.
      logical, intent(out) :: agreed
      type(pose_t) :: pose
      real(wp) :: angle, axis(3, size(self%joints)), d(3), distance, place(3, size(self%joints))
      integer :: i, j, parallel(size(self%joints))
      logical :: has_axis(size(self%joints)), in_line

      odd = 0
      other = 0
      off = 0.0_wp
      beside = 0.0_wp
      agreed = .false.
      if (self%planar) return
      has_axis = .false.
      do i = 1, size(self%joints)
         if (.not. it%involved(i)) cycle
         has_axis(i) = joint_kinds(self%joints(i)%type)%needs_axis
         call self%pose_of(at, self%joints(i)%body_1, pose)
         axis(:, i) = turned(pose%r, self%joints(i)%frame_1(:, 3))
         place(:, i) = pose%p + turned(pose%r, self%joints(i)%p_1)
      end do
      parallel = 0
      do i = 1, size(self%joints)
         do j = 1, size(self%joints)
            if (.not. (has_axis(i) .and. has_axis(j)) .or. i == j) cycle
            if (norm2(cross(axis(:, i), axis(:, j))) <= it%exact) parallel(i) = parallel(i) + 1
         end do
      end do
      ! The nearest one, and of two the later.
      do i = 1, size(self%joints)
         do j = 1, size(self%joints)
            if (.not. (has_axis(i) .and. has_axis(j)) .or. i == j) cycle
            if (parallel(i) > parallel(j) .or. (parallel(i) == parallel(j) .and. i < j)) cycle
            angle = norm2(cross(axis(:, i), axis(:, j)))
            if (angle >= near_when_held) cycle
            if (angle <= it%exact) angle = 0.0_wp
            in_line = joint_kinds(self%joints(i)%type)%has_angle .and. joint_kinds(self%joints(j)%type)%has_angle .and. &
                      same_bodies(self%joints(i), self%joints(j))
            distance = 0.0_wp
            d = place(:, i) - place(:, j)
            if (in_line) distance = norm2(cross(d, axis(:, j)))
            if (distance <= it%exact*max(1.0_wp, norm2(d))) distance = 0.0_wp
            if (.not. max(angle, distance) > 0.0_wp) cycle
            if (odd > 0) then
               if (.not. (angle > 0.0_wp .and. (angle < off .or. .not. off > 0.0_wp))) cycle
            end if
            odd = i
            other = j
            off = angle
            beside = distance
            agreed = parallel(j) > 0
         end do
      end do
   end subroutine odd_axis

   !> Whether two joints join the same bodies.
   pure logical function same_bodies(one, two)
      type(joint_t), intent(in) :: one, two

      same_bodies = min(one%body_1, one%body_2) == min(two%body_1, two%body_2) .and. &
                    max(one%body_1, one%body_2) == max(two%body_1, two%body_2)
   end function same_bodies

end submodule taut_model_mechanism_near
