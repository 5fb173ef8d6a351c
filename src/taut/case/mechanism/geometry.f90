!> What a picture of a mechanism needs to know besides its motion: `geometry.csv`, in the folder of the case's results.
!!
!! One row for each thing, of the kinds
!!
!! * `case`: its name; the type is the CRC-32 of the case file in hexadecimal digits;
!! * `analysis`: what the results are, `dynamics`, `equilibrium` or `modes`;
!! * `mechanism`: the type is `planar` or `spatial`, axis 1 is up, against gravity;
!! * `body`: the type is its shape (`rod`, `box`, `sphere`, `cylinder`), `point`, `node` (of a beam) or `inertia` (of which only
!!   that is known); its sides, those of a box of its inertia if it has no shape, of a cylinder two diameters and its length;
!!   axis 1 is the one along which a rod or a cylinder lies;
!! * `point`: a point of body 1 that is written out;
!! * `joint`: its type, points and axes; `side` is across the axis (the direction in which a knife edge points), the length that
!!   of a distance, or the radius of a disc;
!! * `spring`: `spring`, `damper`, or `torsion` about the axis of a joint; `bushing`, with its axes 3 and, across, 1;
!! * `beam`: the element between two nodes;
!! * `force`: where it acts on body 1.
!!
!! Points are in the axes of their bodies [m], directions too; the axes of `ground` are the global ones. What a thing does not
!! have is left empty.
module taut_case_mechanism_geometry
   use, intrinsic :: iso_fortran_env, only: int8, int64
   use taut_kinds, only: wp
   use taut_error, only: error_t
   use taut_case_checksum, only: add_to_checksum
   use taut_case_csv, only: csv_field, csv_t
   use taut_case_number, only: number_text
   use taut_case_namelist_file, only: namelist_file_t
   use taut_model_mechanism, only: mechanism_t
   use taut_model_mechanism_body, only: body_planar, body_planar_point, body_point, body_t
   use taut_model_mechanism_joint, only: joint_t
   use taut_model_mechanism_joint_table, only: joint_types, type_distance, type_fixed, type_spherical
   implicit none (type, external)
   private
   public :: write_geometry

   character(*), parameter :: header = 'kind,name,type,body_1,body_2,x_1,y_1,z_1,x_2,y_2,z_2,'// &
                              'axis_x_1,axis_y_1,axis_z_1,axis_x_2,axis_y_2,axis_z_2,side_x,side_y,side_z,length,'// &
                              'size_x,size_y,size_z'

contains

   !> Writes `folder/geometry.csv`.
   subroutine write_geometry(file, model, analysis, folder, error)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> The mechanism, complete.
      type(mechanism_t), intent(in) :: model
      !> `dynamics`, `equilibrium` or `modes`.
      character(*), intent(in) :: analysis
      !> The folder, which is there.
      character(*), intent(in) :: folder
      !> A file that cannot be written.
      type(error_t), allocatable, intent(inout) :: error
      type(csv_t) :: table
      logical :: node(size(model%bodies))
      integer :: i

      call table%create(folder//'/geometry.csv', error)
      if (allocated(error)) return
      call table%put(header, error)
      call put('case', csv_field(file%name), checksum(file%content))
      call put('analysis', '', trim(analysis))
      call put('mechanism', '', trim(merge('planar ', 'spatial', model%planar)), axis_1=upwards(model))
      node = .false.
      do i = 1, size(model%elements)
         node([model%elements(i)%body_1, model%elements(i)%body_2]) = .true.
      end do
      do i = 1, size(model%bodies)
         call put_body(model%bodies(i), node(i))
      end do
      do i = 1, size(model%elements)
         associate (it => model%elements(i))
            call put('beam', '', '', it%body_1, it%body_2)
         end associate
      end do
      do i = 1, size(model%points)
         associate (it => model%points(i))
            call put('point', it%name, '', it%body, p_1=it%at)
         end associate
      end do
      do i = 1, size(model%joints)
         call put_joint(model%joints(i))
      end do
      do i = 1, size(model%springs)
         call put_spring(i)
      end do
      do i = 1, size(model%bushings)
         associate (it => model%bushings(i))
            call put('spring', it%name, 'bushing', it%body_1, it%body_2, it%p_1, it%p_2, it%frame_1(:, 3), it%frame_2(:, 3), &
                     it%frame_2(:, 1))
         end associate
      end do
      do i = 1, size(model%loads)
         associate (it => model%loads(i))
            if (.not. it%moment) call put('force', it%name, '', it%body, p_1=it%point)
         end associate
      end do
      if (.not. allocated(error)) call table%finish(error)
      call table%discard()

   contains

      !> A body.
      subroutine put_body(body, is_node)
         type(body_t), intent(in) :: body
         logical, intent(in) :: is_node
         real(wp) :: along(3)

         if (is_node) then
            call put('body', body%name, 'node')
         else if (any(body%kind == [body_point, body_planar_point])) then
            call put('body', body%name, 'point')
         else
            select case (body%shape)
            case ('rod', 'cylinder')
               along = 0.0_wp
               along(body%axis) = 1.0_wp
               call put('body', body%name, trim(body%shape), axis_1=along, size=body%size)
            case ('')
               call put('body', body%name, 'inertia', size=sides_of_inertia(body))
            case default
               call put('body', body%name, trim(body%shape), size=body%size)
            end select
         end if
      end subroutine put_body

      !> A joint.
      subroutine put_joint(joint)
         type(joint_t), intent(in) :: joint

         if (any(joint%type == [type_distance, type_fixed, type_spherical])) then
            call put('joint', joint%name, trim(joint_types(joint%type)), joint%body_1, joint%body_2, joint%p_1, joint%p_2, &
                     length=joint%length)
         else
            call put('joint', joint%name, trim(joint_types(joint%type)), joint%body_1, joint%body_2, joint%p_1, joint%p_2, &
                     joint%frame_1(:, 3), joint%frame_2(:, 3), joint%frame_2(:, 1), joint%length)
         end if
      end subroutine put_joint

      !> A spring, a damper, or what acts about the axis of a joint.
      subroutine put_spring(number)
         integer, intent(in) :: number

         associate (it => model%springs(number))
            if (it%joint == 0) then
               call put('spring', it%name, trim(merge('spring', 'damper', abs(it%stiffness) > 0.0_wp)), it%body_1, it%body_2, &
                        it%p_1, it%p_2, length=it%free)
            else
               associate (joint => model%joints(it%joint))
                  call put('spring', it%name, 'torsion', joint%body_1, joint%body_2, joint%p_1, joint%p_2, &
                           joint%frame_1(:, 3), joint%frame_2(:, 3), joint%frame_2(:, 1))
               end associate
            end if
         end associate
      end subroutine put_spring

      !> One row; what is not there is empty.
      subroutine put(kind, name, type, body_1, body_2, p_1, p_2, axis_1, axis_2, side, length, size)
         character(*), intent(in) :: kind, name, type
         integer, intent(in), optional :: body_1, body_2
         real(wp), intent(in), optional :: p_1(3), p_2(3), axis_1(3), axis_2(3), side(3), length, size(3)

         if (allocated(error)) return
         call table%put(kind//','//name//','//type//','//body_name(body_1)//','//body_name(body_2)//vector(p_1)//vector(p_2)// &
                        vector(axis_1)//vector(axis_2)//vector(side)//number(length)//vector(size), error)
      end subroutine put

      !> The name of a body, or of the ground.
      function body_name(body) result(text)
         integer, intent(in), optional :: body
         character(:), allocatable :: text

         text = ''
         if (.not. present(body)) return
         text = 'ground'
         if (body > 0) text = model%bodies(body)%name
      end function body_name

   end subroutine write_geometry

   !> Three numbers, a comma before each.
   function vector(value) result(text)
      real(wp), intent(in), optional :: value(3)
      character(:), allocatable :: text

      text = ',,,'
      if (present(value)) text = number(value(1))//number(value(2))//number(value(3))
   end function vector

   !> A number with a comma before it.
   function number(value) result(text)
      real(wp), intent(in), optional :: value
      character(:), allocatable :: text

      text = ','
      if (present(value)) text = ','//trim(number_text(value))
   end function number

   !> Against gravity; y in the plane, and z without gravity.
   pure function upwards(model) result(up)
      type(mechanism_t), intent(in) :: model
      real(wp) :: up(3)

      up = [0.0_wp, 0.0_wp, 1.0_wp]
      if (model%planar) up = [0.0_wp, 1.0_wp, 0.0_wp]
      if (.not. model%planar .and. norm2(model%gravity) > 0.0_wp) up = -model%gravity/norm2(model%gravity)
   end function upwards

   !> The sides of a box along body axes that has the moments of inertia of a body, zero in the plane [m].
   pure function sides_of_inertia(body) result(sides)
      type(body_t), intent(in) :: body
      real(wp) :: sides(3)
      integer :: k

      sides = 0.0_wp
      if (body%kind == body_planar) return
      ! A side a across b and c: a^2 = 6 (J_b + J_c - J_a)/m.
      do k = 1, 3
         sides(k) = sqrt(max(6.0_wp*(body%j(1, 1) + body%j(2, 2) + body%j(3, 3) - 2.0_wp*body%j(k, k))/body%m, 0.0_wp))
      end do
   end function sides_of_inertia

   !> The CRC-32 of a text, in hexadecimal digits.
   function checksum(content) result(text)
      character(*), intent(in) :: content
      character(len=8) :: text
      integer(int64) :: value

      value = 0
      call add_to_checksum(transfer(content, [0_int8], len(content)), value)
      write (text, '(z8.8)') value
   end function checksum

end module taut_case_mechanism_geometry
