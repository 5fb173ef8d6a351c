!> Names in the case file of a mechanism: numbered by repetition, each once, and looked up.
module taut_case_mechanism_names
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_case_namelist_file, only: group_t, namelist_file_t
   use taut_model_mechanism, only: mechanism_t
   use taut_model_mechanism_body, only: ground_pose, pose_t
   use taut_rotation, only: matrix_of_quaternion
   implicit none (type, external)
   private
   public :: anchor_t, parts_t, name_length, expand, check_name, check_repeat, find_anchor, find_function, find_joint, &
             locate_named, start_pose

   !> Longest name.
   integer, parameter :: name_length = 64

   !> What a joint or a load may be fixed to: the ground, a body, or a point of either.
   type :: anchor_t
      !> What it is called.
      character(:), allocatable :: name
      !> The body; 0 is the ground.
      integer :: body = 0
      !> Whether it is a point, and where in the body's axes [m].
      logical :: is_point = .false.
      real(wp) :: at(3) = 0.0_wp
   end type anchor_t

   !> What was read so far.
   type :: parts_t
      type(mechanism_t) :: model
      !> The ground first.
      type(anchor_t), allocatable :: anchors(:)
   end type parts_t

contains

   !> A name with # replaced by a number, #+2 and #-1 by others.
   function expand(text, number) result(name)
      !> Such as rod#, or rod#-1 for the one before.
      character(*), intent(in) :: text
      !> The number.
      integer, intent(in) :: number
      !> Such as rod7.
      character(:), allocatable :: name
      integer :: i, last, shift, status

      name = trim(text)
      i = index(name, '#')
      if (i == 0) return
      shift = 0
      last = i
      if (i + 2 <= len(name)) then
         if (scan(name(i + 1:i + 1), '+-') == 1) then
            last = i + 1
            do while (last < len(name))
               if (verify(name(last + 1:last + 1), '0123456789') > 0) exit
               last = last + 1
            end do
            if (last > i + 1) read (name(i + 1:last), *, iostat=status) shift
            if (last == i + 1) last = i
         end if
      end if
      name = name(:i - 1)//to_text(number + shift)//name(last + 1:)
   end function expand

   !> A repeated group must number its names.
   subroutine check_repeat(repeat, name, error)
      !> How often.
      integer, intent(in) :: repeat
      !> The name as written.
      character(*), intent(in) :: name
      !> A number that is not positive, a name without #.
      type(error_t), allocatable, intent(inout) :: error

      if (repeat < 1 .or. repeat > 100000) &
         call raise(error, '', 'repeat = '//to_text(repeat)//' is not between 1 and 100000', 'give the number of copies')
      if (repeat > 1 .and. index(name, '#') == 0) &
         call raise(error, '', 'the name has no # for the number of the copy', 'write a name such as "rod#"')
   end subroutine check_repeat

   !> A name must be fit for the header of a table, and no other's.
   subroutine check_name(name, others, error)
      !> The name.
      character(*), intent(in) :: name
      !> What there is already.
      type(anchor_t), intent(in) :: others(:)
      !> What is wrong with it.
      type(error_t), allocatable, intent(inout) :: error
      integer :: i

      if (len_trim(name) == 0) then
         call raise(error, '', 'it has no name', 'give name = "..."')
      else if (verify(trim(name), 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-') > 0) then
         call raise(error, '', 'its name has a character that is not allowed', 'use letters, digits, - and _')
      end if
      do i = 1, size(others)
         if (others(i)%name == name) then
            call raise(error, '', 'the name is taken: there are two of it', 'rename one of them (bodies, points and joints '// &
                       'share the columns of the table)')
            return
         end if
      end do
   end subroutine check_name

   !> The ground, a body or a point of this name.
   subroutine find_anchor(parts, name, what, anchor, error)
      !> What was read so far.
      type(parts_t), intent(in) :: parts
      !> The name.
      character(*), intent(in) :: name
      !> The entry that it stands in.
      character(*), intent(in) :: what
      !> What it names.
      type(anchor_t), intent(out) :: anchor
      !> There is none.
      type(error_t), allocatable, intent(inout) :: error
      integer :: i

      do i = 1, size(parts%anchors)
         if (parts%anchors(i)%name /= trim(name)) cycle
         anchor = parts%anchors(i)
         return
      end do
      if (len_trim(name) == 0) then
         call raise(error, '', what//' is not given', 'name a body, a point or "ground"')
      else
         call raise(error, '', what//' = "'//trim(name)//'": there is no body or point of this name', &
                    'name a &body, &point_mass, &point, &ground_point or "ground"')
      end if
   end subroutine find_anchor

   !> Number of a function; 0 for no name.
   subroutine find_function(parts, name, what, number, error)
      !> What was read so far.
      type(parts_t), intent(in) :: parts
      !> The name.
      character(*), intent(in) :: name
      !> The entry that it stands in.
      character(*), intent(in) :: what
      !> Its index.
      integer, intent(out) :: number
      !> There is none.
      type(error_t), allocatable, intent(inout) :: error

      if (len_trim(name) == 0) then
         number = 0
         return
      end if
      do number = 1, size(parts%model%functions)
         if (parts%model%functions(number)%name == trim(name)) return
      end do
      call raise(error, '', what//' = "'//trim(name)//'": there is no &function of this name', 'add it, or correct the name')
   end subroutine find_function

   !> Number of a joint.
   subroutine find_joint(parts, name, what, number, error)
      !> What was read so far.
      type(parts_t), intent(in) :: parts
      !> The name.
      character(*), intent(in) :: name
      !> The entry that it stands in.
      character(*), intent(in) :: what
      !> Its index.
      integer, intent(out) :: number
      !> There is none.
      type(error_t), allocatable, intent(inout) :: error

      do number = 1, size(parts%model%joints)
         if (parts%model%joints(number)%name == trim(name)) return
      end do
      call raise(error, '', what//' = "'//trim(name)//'": there is no &joint of this name', 'add it, or correct the name')
   end subroutine find_joint

   !> Names the place in the file and the thing.
   subroutine locate_named(file, group, name, error)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> The group.
      type(group_t), intent(in) :: group
      !> Name of what it describes.
      character(*), intent(in) :: name
      !> The error, if there is one.
      type(error_t), allocatable, intent(inout) :: error

      if (.not. allocated(error)) return
      ! A complaint about an entry has its place already.
      if (index(error%where, file%path) == 1) return
      call file%locate(group, error)
      if (len_trim(name) > 0) error%where = error%where//' "'//trim(name)//'"'
   end subroutine locate_named

   !> Where a body is at the start.
   function start_pose(parts, body) result(it)
      !> What was read so far.
      type(parts_t), intent(in) :: parts
      !> The body; 0 is the ground.
      integer, intent(in) :: body
      !> Its pose, without velocities.
      type(pose_t) :: it

      call ground_pose(it)
      if (body == 0) return
      it%p = parts%model%bodies(body)%position
      it%r = matrix_of_quaternion(parts%model%bodies(body)%orientation)
   end function start_pose

end module taut_case_mechanism_names
