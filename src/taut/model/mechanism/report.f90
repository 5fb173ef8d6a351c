!> What is told of a mechanism before it runs: how far its bodies were moved to assemble it, its degrees of freedom, and which
!! joints have redundant constraints.
module taut_model_mechanism_report
   use taut_kinds, only: wp
   use taut_error, only: to_text
   use taut_constrained_start, only: start_report_t
   use taut_constrained_system, only: state_t
   use taut_constrained_system_tables, only: quantity_t
   use taut_linalg_lapack, only: dpstrf, dtrtrs
   use taut_model_mechanism, only: mechanism_t
   use taut_model_mechanism_body, only: body_t, pose_t, vector_product
   use taut_rotation, only: log_rotation
   implicit none (type, external)
   private
   public :: mechanism_report_t, report_start, find_redundancy

   !> What was found.
   type :: mechanism_report_t
      !> Rank of A, and degrees of freedom.
      integer :: rank = 0, freedoms = 0
      !> For each joint, how many of its rows depend on others: (joints).
      integer, allocatable :: redundant(:)
      !> For each joint, whether it takes part in such a dependence, so that its reactions are not unique: (joints).
      logical, allocatable :: involved(:)
      !> Several lines for people.
      character(:), allocatable :: text
   end type mechanism_report_t

   !> More rows than this are not searched for redundancy: the matrix is dense.
   integer, parameter :: most_rows = 4000
   character, parameter :: nl = new_line('a')

contains

   !> Describes the start, and leaves the numbers with the mechanism for its table.
   subroutine report_start(model, given, assembled, start, report)
      !> The mechanism; its findings are set.
      type(mechanism_t), intent(inout) :: model
      !> The start as given.
      type(state_t), intent(in) :: given
      !> The start as assembled.
      type(state_t), intent(in) :: assembled
      !> What the assembly found.
      type(start_report_t), intent(in) :: start
      !> What was found.
      type(mechanism_report_t), intent(out) :: report
      type(pose_t) :: after, before
      character(:), allocatable :: line
      real(wp) :: moved, turned
      integer :: i, rank, redundant

      rank = start%rank
      call find_redundancy(model, assembled, rank, report)
      redundant = model%c - rank
      model%findings = [quantity_t ::]
      model%remark = ''
      call add('bodies', real(size(model%bodies), wp), '1')
      call add('velocities', real(model%n, wp), '1')
      call add('constraints', real(model%c, wp), '1')
      call add('rank', real(rank, wp), '1')
      call add('degrees_of_freedom', real(report%freedoms, wp), '1')
      call add('redundant_constraints', real(redundant, wp), '1')
      report%text = counted(size(model%bodies), 'body', 'bodies')//', '//counted(size(model%joints), 'joint', 'joints')//': '// &
                    to_text(model%n)//' velocities, '//counted(model%c, 'constraint', 'constraints')//' of rank '// &
                    to_text(rank)//', '//counted(report%freedoms, 'degree', 'degrees')//' of freedom'//nl
      if (redundant > 0) then
         line = ''
         do i = 1, size(model%joints)
            if (report%redundant(i) == 0) cycle
            call add('redundant:'//model%joints(i)%name, real(report%redundant(i), wp), '1')
            line = line//', '//to_text(report%redundant(i))//' of '//model%joints(i)%name
         end do
         if (len(line) > 2) line = ': '//line(3:)
         report%text = report%text//counted(redundant, 'redundant constraint', 'redundant constraints')//line//nl
         line = ''
         do i = 1, size(model%joints)
            if (.not. report%involved(i)) cycle
            call add('not_unique:'//model%joints(i)%name, 1.0_wp, '1')
            if (len(line) < 200) line = line//', '//model%joints(i)%name
         end do
         if (len(line) > 2) report%text = report%text// &
            'reactions that are not unique (those of least norm are given): '//line(3:)//nl
         model%remark = counted(redundant, 'redundant constraint', 'redundant constraints')//': reactions of '// &
                        counted(count(report%involved), 'joint', 'joints')// &
                        ' are not unique; those of least norm are given'
      end if
      do i = 1, size(model%bodies)
         call model%pose_of(given, i, before)
         call model%pose_of(assembled, i, after)
         moved = norm2(after%p - before%p)
         turned = norm2(log_rotation(matmul(transpose(before%r), after%r)))
         if (moved <= 1.0e-9_wp .and. turned <= 1.0e-9_wp) cycle
         call add('moved:'//model%bodies(i)%name, moved, 'm')
         call add('turned:'//model%bodies(i)%name, turned, 'rad')
         report%text = report%text//'assembled: '//model%bodies(i)%name//' moved by '//to_text(moved)//' m, turned by '// &
                       to_text(turned)//' rad'//nl
      end do
      moved = maxval(abs(assembled%v - given%v))
      call add('velocity_correction', moved, 'm/s_or_rad/s')
      if (moved > 1.0e-9_wp) then
         line = model%v_name(maxloc(abs(assembled%v - given%v), 1))
         report%text = report%text//'velocities corrected: '//line//' by '//to_text(moved)// &
                       trim(merge(' rad/s', ' m/s  ', index(line, '.w', back=.true.) > 0))//', no other by more; '// &
                       trim(merge('gained', 'lost  ', start%energy_gained > 0.0_wp))//' '//to_text(abs(start%energy_gained))// &
                       ' J'//nl
         call add('velocity_correction_energy', start%energy_gained, 'J')
      end if
      model%description = report%text

   contains

      !> One number.
      subroutine add(name, value, unit)
         character(*), intent(in) :: name, unit
         real(wp), intent(in) :: value

         model%findings = [model%findings, quantity_t(name, value, unit)]
      end subroutine add

   end subroutine report_start

   !> A number and its noun.
   function counted(number, one, many) result(text)
      integer, intent(in) :: number
      character(*), intent(in) :: one, many
      character(:), allocatable :: text

      text = to_text(number)//' '//trim(many)
      if (number == 1) text = '1 '//one
   end function counted

   !> Which rows depend on the others: Cholesky's factorization of A M^-1 A^T, scaled to a unit diagonal, with its rows
   !! exchanged; the rows whose pivots come after the rank are combinations of those before.
   subroutine find_redundancy(model, at, rank, report)
      !> The mechanism and its state.
      type(mechanism_t), intent(in) :: model
      !> The state at which it is evaluated.
      type(state_t), intent(in) :: at
      !> Rank of A.
      integer, intent(in) :: rank
      !> What was found.
      type(mechanism_report_t), intent(out) :: report
      real(wp), allocatable :: dependent(:, :), s(:, :), work(:)
      integer, allocatable :: pivot(:)
      integer :: c, found, i, info, k

      c = model%c
      report%rank = rank
      report%freedoms = model%n - rank
      allocate (report%redundant(size(model%joints)), source=0)
      allocate (report%involved(size(model%joints)), source=.false.)
      if (rank >= c .or. c > most_rows) return
      call scaled_product(model, at, s)
      allocate (work(2*c), pivot(c))
      call dpstrf('L', c, s, c, pivot, found, 1.0e-14_wp, work, info)
      if (info < 0) return
      k = min(rank, found)
      do i = k + 1, c
         associate (j => model%joint_of_row(pivot(i)))
            report%redundant(j) = report%redundant(j) + 1
         end associate
      end do
      ! A dependent row is the sum of y_j times row j: L11^T y = L21^T.
      allocate (dependent(max(1, k), c - k), source=0.0_wp)
      do i = k + 1, c
         dependent(:k, i - k) = s(i, :k)
         report%involved(model%joint_of_row(pivot(i))) = .true.
      end do
      if (k == 0) return
      call dtrtrs('L', 'T', 'N', k, c - k, s, c, dependent, k, info)
      if (info /= 0) return
      do i = 1, k
         if (maxval(abs(dependent(i, :))) > 1.0e-6_wp) report%involved(model%joint_of_row(pivot(i))) = .true.
      end do
   end subroutine find_redundancy

   !> A M^-1 A^T with rows and columns scaled to a unit diagonal.
   subroutine scaled_product(model, at, s)
      type(mechanism_t), intent(in) :: model
      type(state_t), intent(in) :: at
      real(wp), allocatable, intent(out) :: s(:, :)
      real(wp), allocatable :: full(:, :, :), solved(:, :, :), values(:)
      integer, allocatable :: bodies(:, :)
      real(wp) :: inverse(3, 3)
      integer :: b, c, i, j, k, l

      c = model%c
      allocate (s(c, c), full(6, 2, c), solved(6, 2, c), source=0.0_wp)
      allocate (values(size(model%column)), bodies(2, c))
      call model%jacobian_entries(at, values)
      do i = 1, c
         associate (joint => model%joints(model%joint_of_row(i)))
            bodies(:, i) = [joint%body_1, joint%body_2]
         end associate
         do k = 1, 2
            b = bodies(k, i)
            if (b == 0) cycle
            associate (body => model%bodies(b))
               do l = model%first(i), model%first(i + 1) - 1
                  if ((model%source(l) - 1)/6 == k - 1) full(model%source(l) - 6*(k - 1), k, i) = values(l)
               end do
               call invert_inertia(body, inverse)
               solved(1:3, k, i) = full(1:3, k, i)/body%m
               solved(4:6, k, i) = matmul(inverse, full(4:6, k, i))
            end associate
         end do
      end do
      do j = 1, c
         do i = j, c
            do k = 1, 2
               do l = 1, 2
                  if (bodies(k, i) == bodies(l, j) .and. bodies(k, i) > 0) &
                     s(i, j) = s(i, j) + dot_product(full(:, k, i), solved(:, l, j))
               end do
            end do
         end do
      end do
      do i = 1, c
         s(i, i) = sqrt(max(s(i, i), tiny(1.0_wp)))
      end do
      do j = 1, c
         do i = j + 1, c
            s(i, j) = s(i, j)/(s(i, i)*s(j, j))
         end do
      end do
      do i = 1, c
         s(i, i) = 1.0_wp
      end do
   end subroutine scaled_product

   !> The inverse of a body's inertia; zero where it has none.
   pure subroutine invert_inertia(body, inverse)
      type(body_t), intent(in) :: body
      real(wp), intent(out) :: inverse(3, 3)
      real(wp) :: determinant

      inverse = 0.0_wp
      associate (j => body%j)
         inverse(1, :) = vector_product(j(:, 2), j(:, 3))
         inverse(2, :) = vector_product(j(:, 3), j(:, 1))
         inverse(3, :) = vector_product(j(:, 1), j(:, 2))
         determinant = dot_product(j(:, 1), inverse(1, :))
         if (determinant > 0.0_wp) then
            inverse = inverse/determinant
         else
            inverse = 0.0_wp
            if (j(3, 3) > 0.0_wp) inverse(3, 3) = 1.0_wp/j(3, 3)
         end if
      end associate
   end subroutine invert_inertia

end module taut_model_mechanism_report
