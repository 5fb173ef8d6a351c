!> What is told of a mechanism before it runs: how far its bodies were moved to assemble it, its degrees of freedom, and which
!! joints have redundant constraints.
module taut_model_mechanism_report
   use taut_kinds, only: wp
   use taut_error, only: to_text
   use taut_constrained_start, only: start_report_t
   use taut_constrained_system, only: state_t
   use taut_constrained_system_tables, only: quantity_t
   use taut_model_mechanism, only: mechanism_t
   use taut_model_mechanism_body, only: pose_t, velocities_of_kind
   use taut_model_mechanism_redundancy, only: components, find_redundancy, names_of, redundancy_t
   use taut_rotation, only: log_rotation
   implicit none (type, external)
   private
   public :: mechanism_report_t, report_start

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
      type(redundancy_t) :: found
      character(:), allocatable :: line
      real(wp) :: moved, turned
      type(quantity_t), allocatable :: list(:)
      integer :: constraints, i, k, number, rank, redundant, velocities

      call find_redundancy(model, assembled, found)
      rank = found%rank
      report%rank = rank
      report%freedoms = model%n - rank
      report%redundant = found%redundant
      report%involved = found%involved
      redundant = model%c - rank
      ! Room for all that there can be: lists that grow one by one take the square of the time.
      allocate (list(10 + (2 + size(components))*size(model%joints) + 2*size(model%bodies)))
      number = 0
      model%remark = ''
      call add('bodies', real(size(model%bodies), wp), '1')
      call add('velocities', real(model%n, wp), '1')
      call add('constraints', real(model%c, wp), '1')
      call add('rank', real(rank, wp), '1')
      call add('degrees_of_freedom', real(report%freedoms, wp), '1')
      call add('redundant_constraints', real(redundant, wp), '1')
      report%text = trim(counted(size(model%bodies), 'body', 'bodies'))//', '// &
                    trim(counted(size(model%joints), 'joint', 'joints'))//': '// &
                    to_text(model%n)//' velocities, '//trim(counted(model%c, 'constraint', 'constraints'))//' of rank '// &
                    to_text(rank)//', '//trim(counted(report%freedoms, 'degree', 'degrees'))//' of freedom'//nl
      call find_computed(model, velocities, constraints, line)
      if (allocated(line)) then
         call add('computed_velocities', real(velocities, wp), '1')
         call add('computed_constraints', real(constraints, wp), '1')
         report%text = report%text//line
      end if
      if (redundant > 0) then
         line = ''
         do i = 1, size(model%joints)
            if (report%redundant(i) == 0) cycle
            call add('redundant:'//model%joints(i)%name, real(report%redundant(i), wp), '1')
            line = line//', '//to_text(report%redundant(i))//' of '//model%joints(i)%name
         end do
         if (len(line) > 2) line = ': '//line(3:)
         report%text = report%text//trim(counted(redundant, 'redundant constraint', 'redundant constraints'))//line//nl
         report%text = report%text//found%text
         do i = 1, size(model%joints)
            if (report%involved(i)) call add('not_unique:'//model%joints(i)%name, 1.0_wp, '1')
         end do
         do i = 1, size(model%joints)
            do k = 1, size(components)
               if (found%unique(k, i) .or. found%loose(k, i)) &
                  call add('unique:'//model%joints(i)%name//'.'//underscored(components(k)), &
                           merge(1.0_wp, 0.0_wp, found%unique(k, i)), '1')
            end do
         end do
         model%remark = trim(counted(redundant, 'redundant constraint', 'redundant constraints'))
         if (any(report%involved)) model%remark = model%remark//': reactions of '// &
                                                  trim(counted(count(report%involved), 'joint', 'joints'))// &
                                                  ' are not unique; those of least norm are given'
      end if
      call model%diagnose(assembled, line)
      if (allocated(line)) then
         report%text = report%text//line//nl
      else if (any(found%nearly)) then
         report%text = report%text//'nearly fitting and taken for redundant: '// &
                       names_of(model, pack([(i, i=1, size(model%joints))], found%nearly))// &
                       '; give axes and points with all digits'//nl
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
         line = trim(model%v_name(maxloc(abs(assembled%v - given%v), 1)))
         report%text = report%text//'velocities corrected: '//line//' by '//to_text(moved)// &
                       trim(merge(' rad/s', ' m/s  ', index(line, '.w', back=.true.) > 0))//', no other by more; '// &
                       trim(merge('gained', 'lost  ', start%energy_gained > 0.0_wp))//' '//to_text(abs(start%energy_gained))// &
                       ' J'//nl
         call add('velocity_correction_energy', start%energy_gained, 'J')
      end if
      model%description = report%text
      model%findings = list(:number)

   contains

      !> One number.
      subroutine add(name, value, unit)
         character(*), intent(in) :: name, unit
         real(wp), intent(in) :: value

         number = number + 1
         list(number) = quantity_t(name, value, unit)
      end subroutine add

   end subroutine report_start

   !> What explicit integrators need not compute.
   subroutine find_computed(model, velocities, constraints, text)
      type(mechanism_t), intent(in) :: model
      !> How many they compute.
      integer, intent(out) :: velocities, constraints
      !> Why not all; not allocated if they do.
      character(:), allocatable, intent(out) :: text
      !> So many are told by their names.
      integer, parameter :: most = 6
      integer :: b, i, pin(size(model%bodies)), root(0:size(model%bodies)), told, total, weld(size(model%bodies))
      integer, allocatable :: followers(:)

      velocities = model%n
      constraints = model%c
      root(0) = 0
      call model%find_parts(root(1:), weld, pin, followers)
      total = size(followers) + count(pin > 0)
      if (total == 0 .or. all(root == 0)) return
      do i = 1, size(model%joints)
         associate (it => model%joints(i))
            if (root(it%body_1) == root(it%body_2)) &
               constraints = constraints - (it%last - it%first + 1) - (it%last_rate - it%first_rate + 1)
         end associate
      end do
      told = 0
      text = ''
      do b = 1, size(pin)
         if (weld(b) > 0) then
            velocities = velocities - velocities_of_kind(model%bodies(b)%kind)
            if (root(b) > 0) call tell(' moves with '//model%bodies(root(b))%name)
            if (root(b) == 0) call tell(' stands still')
         else if (pin(b) > 0) then
            velocities = velocities - 2
            constraints = constraints - 2
            call tell(' turns about '//model%joints(pin(b))%name)
         end if
      end do
      if (total > most) text = text//' and '//to_text(total - most)//' more'
      text = 'with an explicit integrator '//trim(counted(velocities, 'velocity', 'velocities'))//' and '// &
             trim(counted(constraints, 'constraint', 'constraints'))//' are computed, the rest follows:'//text//nl

   contains

      !> One body.
      subroutine tell(what)
         character(*), intent(in) :: what

         told = told + 1
         if (told > most) return
         if (told > 1) text = text//','
         text = text//' '//model%bodies(b)%name//what
      end subroutine tell

   end subroutine find_computed

   !> A name in one word.
   pure function underscored(name) result(word)
      character(*), intent(in) :: name
      character(len=len_trim(name)) :: word
      integer :: i

      word = name
      do i = 1, len(word)
         if (word(i:i) == ' ') word(i:i) = '_'
      end do
   end function underscored

   !> A number and its noun, padded with blanks.
   pure function counted(number, one, many) result(text)
      integer, intent(in) :: number
      character(*), intent(in) :: one, many
      character(len=16 + max(len(one), len(many))) :: text

      text = to_text(number)//' '//trim(many)
      if (number == 1) text = '1 '//one
   end function counted

end module taut_model_mechanism_report
