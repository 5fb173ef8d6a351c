!> What the types of joints are: the one table of their rows, of what can be shown and driven, and where they have a meaning.
!!
!! A new type is an entry here; rows of a new kind are in `row.f90`.
module taut_model_mechanism_joint_table
   use taut_model_mechanism_row, only: row_contact, row_distance, row_dot, row_knife, row_offset, row_point, row_rolling
   implicit none (type, external)
   private
   public :: joint_kind_t, row_plan_t, joint_kinds, joint_types, general_types, number_of_type, in_space, in_plane
   public :: type_distance, type_spherical, type_revolute, type_prismatic, type_cylindrical, type_universal, type_planar, &
             type_fixed, type_in_line, type_coordinate, type_rolling, type_knife_edge

   !> Where a row is needed: in the plane x-y and in space, or in one of them.
   integer, parameter :: everywhere = 0, in_space = 1, in_plane = 2

   !> One row: its kind and the axes of the joint's frames that it takes.
   type :: row_plan_t
      !> One of the `row_` constants.
      integer :: kind = 0
      !> Axis of body 1's frame, of body 2's, and to the side in body 1's (of `row_dot`: the one that b is meant to have, which
      !! its opposite meets as well); 0: none. Below zero: a global axis.
      integer :: a = 0, b = 0, side = 0
      !> `everywhere`, `in_space` or `in_plane`.
      integer :: where = everywhere
   end type row_plan_t

   !> A type of joint.
   type :: joint_kind_t
      !> What it is called.
      character(len=11) :: name
      !> Whether a case file and a program join bodies with it by its name; else it has arguments of its own, and who takes them.
      logical :: general = .true.
      !> Whether it has an angle about its axis, and a displacement along it: both may be shown and driven.
      logical :: has_angle = .false., has_displacement = .false.
      !> Whether a drive of the displacement is the motion of its own row; else it adds one.
      logical :: drives_own_row = .false.
      !> Whether it has a meaning in the plane.
      logical :: planar = .true.
      !> Whether it needs an axis in space, and in the plane.
      logical :: needs_axis = .true., needs_axis_in_plane = .true.
      !> In the plane: whether its axis is the normal, whatever is said.
      logical :: turns_about_normal = .false.
      !> Its rows, in order; those of kind 0 do not count.
      type(row_plan_t) :: rows(6)
      !> What it does, for people.
      character(len=80) :: help
   end type joint_kind_t

   type(row_plan_t), parameter :: none = row_plan_t()
   !> The points coincide; the axes are parallel.
   type(row_plan_t), parameter :: coincide(3) = [row_plan_t(row_point, a=-1), row_plan_t(row_point, a=-2), &
                                                 row_plan_t(row_point, a=-3, where=in_space)]
   type(row_plan_t), parameter :: align(2) = [row_plan_t(row_dot, a=1, b=3, side=3), row_plan_t(row_dot, a=2, b=3, side=3)]
   type(row_plan_t), parameter :: align_in_space(2) = [row_plan_t(row_dot, a=1, b=3, side=3, where=in_space), &
                                                       row_plan_t(row_dot, a=2, b=3, side=3, where=in_space)]

   !> The types, by their numbers.
   type(joint_kind_t), parameter :: joint_kinds(*) = [ &
      joint_kind_t('distance', has_displacement=.true., drives_own_row=.true., needs_axis=.false., needs_axis_in_plane=.false., &
                   rows=[row_plan_t(row_distance), none, none, none, none, none], &
                   help='keeps two points at a distance: a rod without mass'), &
      joint_kind_t('spherical', needs_axis=.false., needs_axis_in_plane=.false., turns_about_normal=.true., &
                   rows=[coincide, none, none, none], help='keeps two points together: a ball, or a pin in the plane'), &
      joint_kind_t('revolute', has_angle=.true., needs_axis_in_plane=.false., rows=[coincide, align_in_space, none], &
                   help='turns about its axis'), &
      joint_kind_t('prismatic', has_displacement=.true., &
                   rows=[row_plan_t(row_offset, a=1), row_plan_t(row_dot, a=1, b=3, side=3, where=in_plane), &
                         row_plan_t(row_offset, a=2, where=in_space), align_in_space, &
                         row_plan_t(row_dot, a=1, b=2, side=2, where=in_space)], help='slides along its axis without turning'), &
      joint_kind_t('cylindrical', has_angle=.true., has_displacement=.true., planar=.false., &
                   rows=[align, row_plan_t(row_offset, a=1), row_plan_t(row_offset, a=2), none, none], &
                   help='slides along its axis and turns about it'), &
      joint_kind_t('universal', planar=.false., rows=[coincide, row_plan_t(row_dot, a=3, b=3), none, none], &
                   help='keeps two points together and two axes at right angles'), &
      joint_kind_t('planar', planar=.false., rows=[align, row_plan_t(row_offset, a=3), none, none, none], &
                   help='moves across its axis and turns about it'), &
      joint_kind_t('fixed', needs_axis=.false., needs_axis_in_plane=.false., turns_about_normal=.true., &
                   rows=[coincide, row_plan_t(row_dot, a=1, b=2, side=2), row_plan_t(row_dot, a=2, b=3, side=3, where=in_space), &
                         row_plan_t(row_dot, a=3, b=1, side=1, where=in_space)], help='lets nothing move'), &
      joint_kind_t('in-line', rows=[row_plan_t(row_offset, a=1), row_plan_t(row_offset, a=2, where=in_space), none, none, none, &
                                    none], help='keeps a point on a line'), &
      joint_kind_t('coordinate', has_displacement=.true., drives_own_row=.true., &
                   rows=[row_plan_t(row_point, a=3), none, none, none, none, none], &
                   help='holds or drives one coordinate of a point'), &
      joint_kind_t('rolling', general=.false., planar=.false., &
                   rows=[row_plan_t(row_contact, a=3, b=3), row_plan_t(row_rolling, a=3, b=3, side=1), &
                         row_plan_t(row_rolling, a=3, b=3, side=2), none, none, none], help='a disc rolls on a plane'), &
      joint_kind_t('knife-edge', general=.false., rows=[row_plan_t(row_knife, b=3), none, none, none, none, none], &
                   help='a point does not move across an edge of its body')]

   !> Their names, in the order of their numbers; those that are general.
   character(len=11), parameter :: joint_types(*) = joint_kinds%name, general_types(*) = pack(joint_types, joint_kinds%general)

   !> Numbers of those that something is said of elsewhere.
   integer, parameter :: type_distance = findloc(joint_types, 'distance', 1), &
                         type_spherical = findloc(joint_types, 'spherical', 1), &
                         type_revolute = findloc(joint_types, 'revolute', 1), &
                         type_prismatic = findloc(joint_types, 'prismatic', 1), &
                         type_cylindrical = findloc(joint_types, 'cylindrical', 1), &
                         type_universal = findloc(joint_types, 'universal', 1), &
                         type_planar = findloc(joint_types, 'planar', 1), &
                         type_fixed = findloc(joint_types, 'fixed', 1), &
                         type_in_line = findloc(joint_types, 'in-line', 1), &
                         type_coordinate = findloc(joint_types, 'coordinate', 1), &
                         type_rolling = findloc(joint_types, 'rolling', 1), &
                         type_knife_edge = findloc(joint_types, 'knife-edge', 1)

contains

   !> The number of a type, 0 if there is none of that name.
   pure integer function number_of_type(name) result(number)
      !> The name; trailing blanks do not count.
      character(*), intent(in) :: name

      do number = size(joint_kinds), 1, -1
         if (joint_kinds(number)%name == name) return
      end do
   end function number_of_type

end module taut_model_mechanism_joint_table
