!> The group &beam of a mechanism's case file.
module taut_case_mechanism_beam
   use taut_kinds, only: wp
   use taut_error, only: raise
   use taut_case_entries, only: entries_t
   use taut_case_mechanism_part, only: declare_vector, part_t
   use taut_model_mechanism_builder, only: mechanism_builder_t
   implicit none (type, external)
   private
   public :: beam_group_t

   !> &beam.
   type, extends(part_t) :: beam_group_t
      real(wp), allocatable :: from(:), to(:), young, density, thickness, width, axis_2(:)
      integer :: elements = 4
      real(wp) :: poisson = 0.3_wp, damping = 0.0_wp
   contains
      procedure :: declare
      procedure :: add
   end type beam_group_t

contains

   !> Its entries.
   subroutine declare(self, entries)
      !> What the group says.
      class(beam_group_t), intent(inout) :: self
      !> What passes over them.
      type(entries_t), intent(inout) :: entries

      if (.not. allocated(self%axis_2)) self%axis_2 = [0.0_wp, 1.0_wp, 0.0_wp]
      call entries%group('beam', 'a straight beam of finite-volume elements, in space only; its nodes are the bodies name1, '// &
                         'name2, ...')
      call self%declare_name(entries)
      call declare_vector(entries, self%planar, 'from', self%from, 'm', 'one end')
      call declare_vector(entries, self%planar, 'to', self%to, 'm', 'the other end')
      call entries%item('elements', self%elements, 'number of elements')
      call entries%option('young', self%young, 'Pa', 'Young''s modulus')
      call entries%item('poisson', self%poisson, '', 'Poisson''s ratio')
      call entries%option('density', self%density, 'kg/m^3', 'density')
      call entries%option('thickness', self%thickness, 'm', 'along axis_2')
      call entries%option('width', self%width, 'm', 'across axis_2')
      call declare_vector(entries, self%planar, 'axis_2', self%axis_2, '', 'direction of the thickness')
      call entries%item('damping', self%damping, 's', 'time constant of its damping')
   end subroutine declare

   !> Adds a beam.
   subroutine add(self, builder, copy)
      !> What the group says.
      class(beam_group_t), intent(in) :: self
      !> Takes it.
      type(mechanism_builder_t), intent(inout) :: builder
      !> There is one.
      integer, intent(in) :: copy

      if (.not. (allocated(self%from) .and. allocated(self%to))) &
         call raise(builder%error, '', 'from and to are not both given', 'give both')
      if (.not. (allocated(self%young) .and. allocated(self%density) .and. allocated(self%thickness) .and. &
                 allocated(self%width))) &
         call raise(builder%error, '', 'its material or its section is not given', 'give young, density, thickness and width')
      if (allocated(builder%error)) return
      call builder%add_beam(self%copied(copy), self%from, self%to, self%elements, self%young, self%density, self%thickness, &
                            self%width, self%poisson, self%axis_2, self%damping)
   end subroutine add

end module taut_case_mechanism_beam
