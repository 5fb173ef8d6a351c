!> The group &beam of a mechanism's case file: a run of finite-volume beam elements, whose nodes are bodies.
module taut_case_mechanism_beam
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_case_mechanism_bodies, only: add_body
   use taut_case_mechanism_names, only: locate_named, name_length, parts_t
   use taut_case_namelist_file, only: group_t, namelist_file_t
   use taut_model_beam, only: beam_t, new_beam, straight_nodes
   use taut_model_beam_section, only: beam_section_t, rectangular_section
   use taut_model_mechanism, only: element_t
   use taut_model_mechanism_body, only: body_spatial, body_t
   implicit none (type, external)
   private
   public :: read_beam

   !> Elements beyond this take minutes.
   integer, parameter :: most_elements = 1000

contains

   !> &beam. Its nodes are the bodies name1, name2, ... from one end to the other.
   subroutine read_beam(file, group, parts, error)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> The group.
      type(group_t), intent(in) :: group
      !> What was read so far; added to.
      type(parts_t), intent(inout) :: parts
      !> What is wrong.
      type(error_t), allocatable, intent(inout) :: error
      character(*), parameter :: names = 'name, from, to, elements, young, poisson, density, thickness, width, axis_2, damping'
      character(len=name_length) :: name
      character(len=200) :: message
      real(wp) :: axis_2(3), damping, density, from(3), poisson, thickness, to(3), width, young
      integer :: elements, i, status
      type(beam_section_t) :: section
      type(beam_t) :: made
      type(body_t) :: node
      type(element_t) :: one
      real(wp), allocatable :: orientations(:, :), positions(:, :)
      namelist /beam/ name, from, to, elements, young, poisson, density, thickness, width, axis_2, damping

      name = ''
      from = 0.0_wp
      to = 0.0_wp
      elements = 4
      young = 0.0_wp
      poisson = 0.3_wp
      density = 0.0_wp
      thickness = 0.0_wp
      width = 0.0_wp
      axis_2 = [0.0_wp, 1.0_wp, 0.0_wp]
      damping = 0.0_wp
      do i = 1, size(group%entries)
         read (group%entries(i)%text, nml=beam, iostat=status, iomsg=message)
         if (status /= 0) call file%complain(group, i, message, names, error)
      end do
      if (parts%model%planar) call raise(error, '', 'a beam is in space', 'leave out planar = .true.')
      if (elements < 1 .or. elements > most_elements) &
         call raise(error, '', 'elements = '//to_text(elements)//' is not between 1 and '//to_text(most_elements), &
                  'give a small number')
      if (.not. (norm2(to - from) > 0.0_wp .and. norm2(to - from) <= huge(1.0_wp))) &
         call raise(error, '', 'from and to are the same point or not numbers', 'set its ends apart')
      if (.not. allocated(error)) then
         if (.not. norm2(axis_2) > 0.0_wp .or. abs(dot_product(axis_2, to - from)) > 0.999_wp*norm2(axis_2)*norm2(to - from)) &
            call raise(error, '', 'axis_2 is along the beam', 'give the direction of its thickness, across the beam')
      end if
      if (.not. allocated(error)) call rectangular_section(section, young, poisson, density, thickness, width, error)
      if (.not. allocated(error)) then
         call straight_nodes(from, to, elements, axis_2, positions, orientations)
         call new_beam(made, positions, orientations, section, error, damping=damping)
      end if
      do i = 1, elements + 1
         if (allocated(error)) exit
         node%name = trim(name)//to_text(i)
         node%kind = body_spatial
         node%m = made%m(i)
         node%j = made%inertia(:, :, i)
         node%position = positions(:, i)
         node%orientation = orientations(:, i)
         call add_body(node, parts, error)
         if (i == 1 .or. allocated(error)) cycle
         one%body_2 = size(parts%model%bodies)
         one%body_1 = one%body_2 - 1
         one%element = made%elements(i - 1)
         parts%model%elements = [parts%model%elements, one]
      end do
      call locate_named(file, group, name, error)
   end subroutine read_beam

end module taut_case_mechanism_beam
