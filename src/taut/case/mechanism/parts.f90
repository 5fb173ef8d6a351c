!> The groups that add parts to a mechanism: the one table of their names, and how they are read.
module taut_case_mechanism_parts
   use taut_error, only: error_t
   use taut_case_group, only: declare_group, declared_t, read_group
   use taut_case_mechanism_beam, only: beam_group_t
   use taut_case_mechanism_bodies, only: body_group_t, ground_point_group_t, point_group_t, point_mass_group_t
   use taut_case_mechanism_bushing, only: bushing_group_t
   use taut_case_mechanism_event, only: event_group_t
   use taut_case_mechanism_function, only: function_group_t
   use taut_case_mechanism_joints, only: joint_group_t, knife_edge_group_t, rolling_group_t
   use taut_case_mechanism_loads, only: gravity_group_t, load_group_t, spring_group_t
   use taut_case_mechanism_part, only: part_t
   use taut_case_namelist_file, only: group_t, namelist_file_t
   use taut_model_mechanism_builder, only: builder_words_t, mechanism_builder_t
   implicit none (type, external)
   private
   public :: declare_parts, read_parts, origins_t, locate_named

   !> A group that adds parts.
   type :: part_kind_t
      character(len=12) :: name
      !> When it is read: what others name comes before them.
      integer :: pass
      !> Whether it may be there more than once.
      logical :: many = .true.
   end type part_kind_t

   type(part_kind_t), parameter :: kinds(*) = [ &
      part_kind_t('gravity', 1, many=.false.), part_kind_t('body', 1), part_kind_t('point_mass', 1), &
      part_kind_t('ground_point', 1), part_kind_t('point', 2), part_kind_t('function', 1), part_kind_t('joint', 3), &
      part_kind_t('rolling', 3), part_kind_t('knife_edge', 3), part_kind_t('force', 4), part_kind_t('moment', 4), &
      part_kind_t('spring', 4), part_kind_t('damper', 4), part_kind_t('bushing', 4), part_kind_t('beam', 1), &
      part_kind_t('event', 5)]

   !> Which group of the file each joint and each function came from.
   type :: origins_t
      !> Number of the last joint, and of the last function, of a group; 0 if it made none: (groups).
      integer, allocatable :: last_joint(:), last_function(:)
   contains
      procedure :: of_joint
      procedure :: of_function
   end type origins_t

contains

   !> Nothing said yet, of a group of this name.
   subroutine new_part(name, part)
      character(*), intent(in) :: name
      class(part_t), allocatable, intent(out) :: part

      select case (name)
      case ('gravity')
         allocate (gravity_group_t :: part)
      case ('body')
         allocate (body_group_t :: part)
      case ('point_mass')
         allocate (point_mass_group_t :: part)
      case ('ground_point')
         allocate (ground_point_group_t :: part)
      case ('point')
         allocate (point_group_t :: part)
      case ('function')
         allocate (function_group_t :: part)
      case ('joint')
         allocate (joint_group_t :: part)
      case ('rolling')
         allocate (rolling_group_t :: part)
      case ('knife_edge')
         allocate (knife_edge_group_t :: part)
      case ('force')
         allocate (load_group_t :: part)
      case ('moment')
         allocate (part, source=load_group_t(moment=.true.))
      case ('spring')
         allocate (spring_group_t :: part)
      case ('damper')
         allocate (part, source=spring_group_t(damper=.true.))
      case ('bushing')
         allocate (bushing_group_t :: part)
      case ('beam')
         allocate (beam_group_t :: part)
      case ('event')
         allocate (event_group_t :: part)
      end select
   end subroutine new_part

   !> Adds them to the groups that a case file may have.
   subroutine declare_parts(groups)
      !> The groups so far.
      type(declared_t), allocatable, intent(inout) :: groups(:)
      class(part_t), allocatable :: part
      integer :: i

      do i = 1, size(kinds)
         call new_part(trim(kinds(i)%name), part)
         call declare_group(groups, part, many=kinds(i)%many)
      end do
   end subroutine declare_parts

   !> Reads all of them, in an order in which names are known before they are used.
   subroutine read_parts(file, builder, origins, error)
      !> The case file, whose groups were checked.
      type(namelist_file_t), intent(in) :: file
      !> Takes the parts.
      type(mechanism_builder_t), intent(inout) :: builder
      !> Where joints and functions come from.
      type(origins_t), intent(out) :: origins
      !> What is wrong first.
      type(error_t), allocatable, intent(inout) :: error
      integer :: i, k, pass

      builder%words = builder_words_t(anchors='a &body, &point_mass, &point, &ground_point or "ground"', &
                                      add='add it, or correct the name', ground_point='a &ground_point', &
                                      point_mass='&point_mass', bushing='&bushing')
      allocate (origins%last_joint(size(file%groups)), origins%last_function(size(file%groups)), source=0)
      do pass = 1, maxval(kinds%pass)
         do i = 1, size(file%groups)
            k = kind_of(file%groups(i)%name)
            if (k == 0) cycle
            if (kinds(k)%pass /= pass) cycle
            associate (joints => builder%joint_count, functions => builder%function_count)
               k = joints + functions
               call read_part(file, file%groups(i), builder, error)
               if (allocated(error)) return
               if (joints + functions == k) cycle
               if (pass == 1) origins%last_function(i) = functions
               if (pass > 1) origins%last_joint(i) = joints
            end associate
         end do
      end do
   end subroutine read_parts

   !> The number of a group in the table; 0 if it adds no parts.
   pure integer function kind_of(name) result(number)
      character(*), intent(in) :: name

      do number = size(kinds), 1, -1
         if (kinds(number)%name == name) return
      end do
   end function kind_of

   !> Reads one.
   subroutine read_part(file, group, builder, error)
      type(namelist_file_t), intent(in) :: file
      type(group_t), intent(in) :: group
      type(mechanism_builder_t), intent(inout) :: builder
      type(error_t), allocatable, intent(inout) :: error
      class(part_t), allocatable :: part
      integer :: copy, noted

      noted = 0
      if (allocated(builder%notes)) noted = size(builder%notes)
      call new_part(group%name, part)
      part%case_path = file%path
      part%planar = builder%planar
      call read_group(file, group, part, error)
      if (allocated(error)) return
      if (.not. allocated(part%name)) part%name = ''
      call part%check_copies(error)
      call locate_named(file, group, part%name, error)
      do copy = 0, part%repeat - 1
         if (allocated(error)) return
         call part%add(builder, copy)
         if (copy == 0) call locate_notes(file, group, part%copied(0), noted, builder)
         if (.not. allocated(builder%error)) cycle
         call move_alloc(builder%error, error)
         call locate_named(file, group, part%copied(copy), error)
      end do
      if (allocated(builder%notes) .and. part%repeat > 1) builder%notes = builder%notes(:min(noted + 1, size(builder%notes)))
   end subroutine read_part

   !> Names the place of what was noted of a part; its other copies say the same.
   subroutine locate_notes(file, group, name, noted, builder)
      type(namelist_file_t), intent(in) :: file
      type(group_t), intent(in) :: group
      character(*), intent(in) :: name
      !> Notes before it.
      integer, intent(in) :: noted
      type(mechanism_builder_t), intent(inout) :: builder
      type(error_t), allocatable :: one
      integer :: i

      if (.not. allocated(builder%notes)) return
      do i = noted + 1, size(builder%notes)
         one = builder%notes(i)
         call locate_named(file, group, name, one)
         builder%notes(i) = one
         deallocate (one)
      end do
   end subroutine locate_notes

   !> Names the place in the file and the thing.
   subroutine locate_named(file, group, name, error)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> The group.
      type(group_t), intent(in) :: group
      !> Name of what it describes; may be empty.
      character(*), intent(in) :: name
      !> The error, if there is one.
      type(error_t), allocatable, intent(inout) :: error

      call file%locate(group, error)
      if (allocated(error) .and. len_trim(name) > 0) error%where = error%where//' "'//trim(name)//'"'
   end subroutine locate_named

   !> The group that a joint came from.
   pure integer function of_joint(self, number) result(group)
      !> The origins.
      class(origins_t), intent(in) :: self
      !> The joint.
      integer, intent(in) :: number

      group = findloc(self%last_joint >= number, .true., 1)
   end function of_joint

   !> The group that a function came from.
   pure integer function of_function(self, number) result(group)
      !> The origins.
      class(origins_t), intent(in) :: self
      !> The function.
      integer, intent(in) :: number

      group = findloc(self%last_function >= number, .true., 1)
   end function of_function

end module taut_case_mechanism_parts
