!> Which joints prevent the same motion more than once, in which directions, and which components of their reactions are unique.
!!
!! Null vectors of A^T tell: each is a set of multipliers that load nothing. The reactions that one of them makes circulate in a
!! loop of joints. Those of moments alone belong to rotations that are prevented more than once, those with forces to shifts; and
!! a component of a reaction is unique if no null vector has a part in it.
module taut_model_mechanism_redundancy
   use taut_kinds, only: wp
   use taut_error, only: to_text
   use taut_constrained_system, only: state_t
   use taut_linalg_csr, only: csr_t
   use taut_linalg_rank, only: exactly_dependent
   use taut_linalg_row_selection, only: row_selection_t
   use taut_model_mechanism, only: mechanism_t
   use taut_model_mechanism_body, only: body_point, body_planar_point, pose_t
   use taut_model_mechanism_null_vectors, only: circle_t, find_circles, find_null_vector, lists_by, lists_t, loads_of, &
                                                 multipliers_t, null_vector_t, rank_of, separate
   use taut_rotation, only: cross
   implicit none (type, external)
   private
   public :: redundancy_t, find_redundancy, names_of, components

   !> What a reaction is told apart into: by its axis, or, of joints without one, as a whole.
   character(len=13), parameter :: components(6) = [character(len=13) :: 'force', 'force along', 'force across', 'moment', &
                                                    'moment along', 'moment across']

   !> What was found.
   type :: redundancy_t
      !> Rank of A.
      integer :: rank = 0
      !> For each joint, how many of its rows depend on others: (joints).
      integer, allocatable :: redundant(:)
      !> For each joint, whether not all of its reactions are unique: (joints).
      logical, allocatable :: involved(:)
      !> For each joint, whether one of its rows depends on others but for a little: (joints).
      logical, allocatable :: nearly(:)
      !> Of joints that are involved, which of `components` are unique, and which the joint has and are not: (6, joints).
      logical, allocatable :: unique(:, :), loose(:, :)
      !> Lines for people, empty without redundancy.
      character(:), allocatable :: text
   end type redundancy_t

   !> What is said of joints, and of how many sets of joints like these.
   type :: sentence_t
      integer, allocatable :: joint(:)
      character(:), allocatable :: what, besides
      integer :: times = 1
   end type sentence_t

   !> Of more null vectors that hang together directions are not told: the matrices are dense.
   integer, parameter :: most_vectors = 300
   character, parameter :: nl = new_line('a')

contains

   !> Looks for redundant constraints.
   subroutine find_redundancy(model, at, found)
      !> The mechanism.
      type(mechanism_t), intent(in) :: model
      !> The state at which it is looked at, its constraints met.
      type(state_t), intent(in) :: at
      !> What was found.
      type(redundancy_t), intent(out) :: found
      type(csr_t) :: a
      type(row_selection_t) :: selection
      type(null_vector_t), allocatable :: null(:)
      type(circle_t), allocatable :: circle(:)
      type(multipliers_t) :: lambda
      integer, allocatable :: group(:)
      integer :: i, k

      allocate (found%redundant(size(model%joints)), source=0)
      allocate (found%involved(size(model%joints)), source=.false.)
      allocate (found%nearly(size(model%joints)), source=.false.)
      allocate (found%unique(size(components), size(model%joints)), source=.false.)
      allocate (found%loose(size(components), size(model%joints)), source=.false.)
      found%text = ''
      if (model%c == 0) return
      call a%set_pattern(model%n, model%first, model%column)
      call model%jacobian_entries(at, a%values)
      call model%column_groups(group)
      call selection%init(a, model%c, group, 0.0_wp)
      call selection%select(a, 0.0_wp)
      found%rank = selection%rank
      if (found%rank == model%c) return
      allocate (null(count(.not. (selection%kept .or. selection%rows%empty))))
      allocate (lambda%all(model%c), lambda%one(model%c), source=0.0_wp)
      k = 0
      do i = 1, model%c
         if (selection%kept(i)) cycle
         found%redundant(model%joint_of_row(i)) = found%redundant(model%joint_of_row(i)) + 1
         if (selection%rows%empty(i)) cycle
         k = k + 1
         call find_null_vector(model, selection, i, null(k))
         found%involved(null(k)%joint) = .true.
         if (selection%distance(i) > exactly_dependent) found%nearly(model%joint_of_row(i)) = .true.
      end do
      call tell_ignored(model, selection, found%text)
      call find_circles(size(model%bodies), null, circle)
      call tell_circles(model, at, null, circle, lambda, found%text)
      call tell_reactions(model, at, null, lambda, found)
   end subroutine find_redundancy

   !> Names joints that ask something of a body that it has not.
   subroutine tell_ignored(model, selection, text)
      type(mechanism_t), intent(in) :: model
      type(row_selection_t), intent(in) :: selection
      character(:), allocatable, intent(inout) :: text
      integer :: b, ignored(size(model%joints)), i

      ignored = 0
      do i = 1, model%c
         if (selection%rows%empty(i)) ignored(model%joint_of_row(i)) = ignored(model%joint_of_row(i)) + 1
      end do
      do i = 1, size(ignored)
         if (ignored(i) == 0) cycle
         associate (joint => model%joints(i))
            b = 0
            if (is_point(joint%body_1)) b = joint%body_1
            if (is_point(joint%body_2)) b = joint%body_2
            if (b > 0) then
               text = text//joint%name//': '//counted(ignored(i), 'rotation')//trim(merge(' is ', ' are', ignored(i) == 1))// &
                      ' asked of '//model%bodies(b)%name//', which is a point mass and has none: '// &
                      trim(merge('it is   ', 'they are', ignored(i) == 1))//' ignored'//nl
            else
               text = text//joint%name//': '//counted(ignored(i), 'row')//trim(merge(' moves', ' move ', ignored(i) == 1))// &
                      ' nothing: '//trim(merge('it is   ', 'they are', ignored(i) == 1))//' ignored'//nl
            end if
         end associate
      end do

   contains

      pure logical function is_point(b)
         integer, intent(in) :: b

         is_point = .false.
         if (b > 0) is_point = model%bodies(b)%kind == body_point .or. model%bodies(b)%kind == body_planar_point
      end function is_point

   end subroutine tell_ignored

   !> For each circle what is prevented more than once; circles that are alike are told once.
   subroutine tell_circles(model, at, null, circle, lambda, text)
      type(mechanism_t), intent(in) :: model
      type(state_t), intent(in) :: at
      type(null_vector_t), intent(in) :: null(:)
      type(circle_t), intent(in) :: circle(:)
      type(multipliers_t), intent(inout) :: lambda
      character(:), allocatable, intent(inout) :: text
      type(sentence_t), allocatable :: sentence(:)
      type(sentence_t) :: one
      integer :: i, j

      allocate (sentence(0))
      do i = 1, size(circle)
         call describe_circle(model, at, null, circle(i), lambda, one%what)
         one%joint = circle(i)%joint
         do j = 1, size(sentence)
            if (sentence(j)%what == one%what .and. size(sentence(j)%joint) == size(one%joint)) exit
         end do
         if (j > size(sentence)) then
            sentence = [sentence, one]
         else
            sentence(j)%times = sentence(j)%times + 1
         end if
      end do
      do j = 1, size(sentence)
         text = text//names_of(model, sentence(j)%joint)
         if (sentence(j)%times > 1) text = text//' and '//to_text(sentence(j)%times - 1)//' more groups like these'
         text = text//': '//sentence(j)%what//nl
      end do
   end subroutine tell_circles

   !> The rotations and shifts that joints of a circle prevent more than once.
   subroutine describe_circle(model, at, null, circle, lambda, predicate)
      type(mechanism_t), intent(in) :: model
      type(state_t), intent(in) :: at
      type(null_vector_t), intent(in) :: null(:)
      type(circle_t), intent(in) :: circle
      type(multipliers_t), intent(inout) :: lambda
      character(:), allocatable, intent(out) :: predicate
      real(wp), allocatable :: f(:, :), force(:, :, :), m(:, :), moment(:, :, :)
      real(wp) :: axis(3), one(3), other(3)
      integer :: i, n, rotations, shifts, along, across
      logical :: named, parallel

      n = size(circle%vector)
      if (n > most_vectors) then
         predicate = 'motions are prevented '//to_text(n)//' times too often'
         return
      end if
      call loads_of(model, at, null, circle%vector, circle%joint, lambda, force, moment)
      axis = 0.0_wp
      parallel = .true.
      do i = 1, size(circle%joint)
         one = axis_of(model, at, circle%joint(i))
         if (.not. norm2(one) > 0.5_wp) cycle
         if (norm2(axis) > 0.5_wp) parallel = parallel .and. norm2(cross(one, axis)) < 1.0e-3_wp
         axis = one
      end do
      parallel = parallel .and. norm2(axis) > 0.5_wp
      if (.not. parallel) axis = 0.0_wp
      f = reshape(force, [3*size(circle%joint), n])
      m = reshape(moment, [3*size(circle%joint), n])
      call separate(f, m, shifts)
      rotations = n - shifts
      named = .false.
      predicate = ''
      ! Vectors without forces come last.
      other = 0.0_wp
      if (rotations == 1) other = direction_of(m(:, n))
      call split(reshape(m(:, shifts + 1:), [3, size(circle%joint), rotations]), along, across)
      call add(rotations, 'rotation', along, across, other)
      if (shifts == 1) other = direction_of(f(:, 1))
      call split(reshape(f(:, :shifts), [3, size(circle%joint), shifts]), along, across)
      call add(shifts, 'shift', along, across, other)
      predicate = predicate//trim(merge(' is  ', ' are ', n == 1))//' prevented '// &
                  trim(merge('twice         ', 'more than once', n <= 6))

   contains

      !> How many of the directions that columns span, column by column of one kind, are along the axis and across it.
      subroutine split(column, along, across)
         real(wp), intent(in) :: column(:, :, :)
         integer, intent(out) :: along, across
         real(wp) :: part(3, size(column, 2), size(column, 3)), rest(3, size(column, 2), size(column, 3))
         integer :: j, k

         do k = 1, size(column, 3)
            do j = 1, size(column, 2)
               part(:, j, k) = dot_product(axis, column(:, j, k))*axis
               rest(:, j, k) = column(:, j, k) - part(:, j, k)
            end do
         end do
         across = size(column, 3) - rank_of(reshape(part, [3*size(column, 2), size(column, 3)]))
         along = size(column, 3) - rank_of(reshape(rest, [3*size(column, 2), size(column, 3)]))
      end subroutine split

      !> Number and directions of one kind of motion.
      subroutine add(number, noun, along, across, direction)
         integer, intent(in) :: number, along, across
         character(*), intent(in) :: noun
         real(wp), intent(in) :: direction(3)

         if (number == 0) return
         if (len(predicate) > 0) predicate = predicate//' and '
         if (.not. parallel .and. number == 1) then
            predicate = predicate//counted(1, noun)//trim(merge(' about', ' along', noun == 'rotation'))//' '// &
                        direction_text(direction)
         else if (parallel .and. along == number) then
            predicate = predicate//counted(number, noun)//trim(merge(' about', ' along', noun == 'rotation'))//the_axis()
         else if (parallel .and. across == number) then
            predicate = predicate//counted(number, noun)//' across'//the_axis()
         else if (parallel .and. number == 1) then
            predicate = predicate//counted(1, noun)//' oblique to'//the_axis()
         else
            predicate = predicate//counted(number, noun)
         end if
      end subroutine add

      !> The axis by its direction, or, the second time, by a pronoun.
      function the_axis() result(text)
         character(:), allocatable :: text

         text = ' them'
         if (.not. named) text = ' the parallel axes '//direction_text(axis)
         named = .true.
      end function the_axis

   end subroutine describe_circle

   !> The direction in which a column of vectors is largest.
   pure function direction_of(column) result(direction)
      real(wp), intent(in) :: column(:)
      real(wp) :: direction(3)
      integer :: i, largest

      largest = 1
      do i = 1, size(column), 3
         if (norm2(column(i:i + 2)) > norm2(column(largest:largest + 2))) largest = i
      end do
      direction = column(largest:largest + 2)
   end function direction_of

   !> For each joint whose reactions are not all unique, which are and which are not; joints that are alike are told once.
   subroutine tell_reactions(model, at, null, lambda, found)
      type(mechanism_t), intent(in) :: model
      type(state_t), intent(in) :: at
      type(null_vector_t), intent(in) :: null(:)
      type(multipliers_t), intent(inout) :: lambda
      type(redundancy_t), intent(inout) :: found
      type(sentence_t), allocatable :: sentence(:)
      type(sentence_t) :: one
      type(lists_t) :: member, rows
      integer, allocatable :: vector(:)
      integer :: i, j, k

      ! The null vectors of each joint, by their joints one after the other.
      vector = [((k, i=1, size(null(k)%joint)), k=1, size(null))]
      member = lists_by([(null(k)%joint, k=1, size(null))], size(found%involved))
      rows = lists_by(model%joint_of_row, size(found%involved))
      allocate (sentence(0))
      do j = 1, size(found%involved)
         if (.not. found%involved(j)) cycle
         call describe_reactions(model, at, null, vector(member%of(member%first(j):member%first(j + 1) - 1)), &
                                 rows%of(rows%first(j):rows%first(j + 1) - 1), j, lambda, one%what, one%besides, &
                                 found%unique(:, j), found%loose(:, j))
         one%joint = [j]
         do i = 1, size(sentence)
            if (sentence(i)%what == one%what .and. sentence(i)%besides == one%besides) exit
         end do
         if (i > size(sentence)) then
            sentence = [sentence, one]
         else
            sentence(i)%joint = [sentence(i)%joint, j]
         end if
      end do
      do i = 1, size(sentence)
         found%text = found%text//'reactions that are not unique (those of least norm are given): '//sentence(i)%what//' of '// &
                names_of(model, sentence(i)%joint)
         if (len(sentence(i)%besides) > 0) found%text = found%text//'; unique: '//sentence(i)%besides
         found%text = found%text//nl
      end do
   end subroutine tell_reactions

   !> The components of a joint's reaction that are not unique, and those that are.
   subroutine describe_reactions(model, at, null, vector, rows, j, lambda, what, besides, is_unique, is_loose)
      type(mechanism_t), intent(in) :: model
      type(state_t), intent(in) :: at
      type(null_vector_t), intent(in) :: null(:)
      integer, intent(in) :: vector(:), rows(:), j
      type(multipliers_t), intent(inout) :: lambda
      character(:), allocatable, intent(out) :: what, besides
      logical, intent(inout) :: is_unique(:), is_loose(:)
      type(null_vector_t) :: row(size(rows))
      real(wp), allocatable :: f(:, :, :), f_row(:, :, :), m(:, :, :), m_row(:, :, :)
      real(wp) :: axis(3)
      integer :: i

      call loads_of(model, at, null, vector, [j], lambda, f, m)
      do i = 1, size(rows)
         row(i)%row = rows(i:i)
         row(i)%value = [1.0_wp]
      end do
      call loads_of(model, at, row, [(i, i=1, size(rows))], [j], lambda, f_row, m_row)
      axis = axis_of(model, at, j)
      what = ''
      besides = ''
      call judge(1, f(:, 1, :), f_row(:, 1, :))
      call judge(4, m(:, 1, :), m_row(:, 1, :))
      what = what(3:)
      if (len(besides) > 0) besides = besides(3:)

   contains

      !> One of the two, along the axis and across it.
      subroutine judge(c, null_loads, row_loads)
         !> Which of `components` it is as a whole.
         integer, intent(in) :: c
         real(wp), intent(in) :: null_loads(:, :), row_loads(:, :)
         real(wp) :: along(3, 3)
         integer :: i

         if (.not. norm2(axis) > 0.5_wp) then
            call note(c, null_loads, row_loads)
            return
         end if
         do i = 1, 3
            along(:, i) = axis*axis(i)
         end do
         call note(c + 1, matmul(along, null_loads), matmul(along, row_loads))
         call note(c + 2, null_loads - matmul(along, null_loads), row_loads - matmul(along, row_loads))
      end subroutine judge

      !> One component, if the joint has it.
      subroutine note(c, null_loads, row_loads)
         integer, intent(in) :: c
         real(wp), intent(in) :: null_loads(:, :), row_loads(:, :)
         real(wp) :: left(3, size(null_loads, 2)), none(1, size(null_loads, 2))
         integer :: has, loose

         has = rank_of(row_loads)
         if (has == 0) return
         left = null_loads
         none = 0.0_wp
         call separate(left, none, loose)
         is_unique(c) = loose == 0
         is_loose(c) = loose > 0
         if (loose == 0) then
            besides = besides//', '//trim(components(c))
         else
            what = what//', '//trim(components(c))
            if (loose == 1 .and. has > 1) what = what//' in the direction '//direction_text(left(:, 1))
         end if
      end subroutine note

   end subroutine describe_reactions

   !> The axis of a joint in global axes; zero for one without.
   function axis_of(model, at, j) result(axis)
      type(mechanism_t), intent(in) :: model
      type(state_t), intent(in) :: at
      integer, intent(in) :: j
      real(wp) :: axis(3)
      type(pose_t) :: two

      call model%pose_of(at, model%joints(j)%body_2, two)
      axis = matmul(two%r, model%joints(j)%frame_2(:, 3))
   end function axis_of

   !> Names of joints, of many the first ones.
   function names_of(model, joint) result(text)
      !> The mechanism.
      type(mechanism_t), intent(in) :: model
      !> Their numbers.
      integer, intent(in) :: joint(:)
      !> Separated by commas.
      character(:), allocatable :: text
      integer :: i

      text = ''
      do i = 1, size(joint)
         if (len(text) > 200) then
            text = text//' and '//to_text(size(joint) - i + 1)//' more'
            exit
         end if
         if (i > 1) text = text//', '
         text = text//model%joints(joint(i))%name
      end do
   end function names_of

   !> A number in words, if it is small, and what is counted.
   function counted(number, noun) result(text)
      integer, intent(in) :: number
      character(*), intent(in) :: noun
      character(:), allocatable :: text
      character(len=5), parameter :: words(6) = ['one  ', 'two  ', 'three', 'four ', 'five ', 'six  ']

      if (number <= size(words)) then
         text = trim(words(number))//' '//noun
      else
         text = to_text(number)//' '//noun
      end if
      if (number > 1) text = text//'s'
   end function counted

   !> A direction with three digits, its first entry that is not zero positive.
   function direction_text(direction) result(text)
      real(wp), intent(in) :: direction(3)
      character(:), allocatable :: digits, text
      integer :: e(3), i

      e = nint(1.0e3_wp*direction/norm2(direction))
      if (e(findloc(e /= 0, .true., 1)) < 0) e = -e
      text = '('
      do i = 1, 3
         if (i > 1) text = text//', '
         if (e(i) < 0) text = text//'-'
         text = text//to_text(abs(e(i))/1000)
         digits = to_text(1000 + modulo(abs(e(i)), 1000))
         if (digits /= '1000') text = text//'.'//digits(2:verify(digits, '0', back=.true.))
      end do
      text = text//')'
   end function direction_text

end module taut_model_mechanism_redundancy
