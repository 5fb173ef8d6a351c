!> Case files and results of the eigenanalysis of a straight beam.
module taut_case_beam_modes
   use, intrinsic :: iso_fortran_env, only: output_unit
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_case_csv, only: csv_t, number_text
   use taut_case_namelist_file, only: namelist_file_t
   use taut_case_posix, only: make_folder
   use taut_constrained_modes, only: eigenmodes, modes_options_t, modes_t
   use taut_model_beam, only: beam_t, new_beam, straight_nodes
   use taut_model_beam_section, only: beam_section_t, new_section, rectangular_section
   implicit none (type, external)
   private
   public :: beam_modes_t, read_beam_modes, write_beam_modes

   !> A case and its solution.
   type :: beam_modes_t
      !> The beam, along x.
      type(beam_t) :: beam
      !> All its modes.
      type(modes_t) :: modes
      !> How many are written.
      integer :: number = 0
   end type beam_modes_t

   !> Matrices are dense: more elements than this take minutes.
   integer, parameter :: most_elements = 500

contains

   !> Reads a case file and solves it; what it leaves out has the values of Sect. 4.2.
   subroutine read_beam_modes(file, problem, error)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> The case.
      type(beam_modes_t), intent(out) :: problem
      !> What is wrong with the file, or why there is no solution.
      type(error_t), allocatable, intent(inout) :: error
      character(*), parameter :: beam_names = 'length, elements, young, poisson, density, thickness, width, stiffness, '// &
                                              'mid_mass, supports, planar', modes_names = 'number'
      real(wp) :: length, young, poisson, density, thickness, width, stiffness(6, 6), mid_mass
      integer :: elements, i, j, number, status
      logical :: planar
      character(len=16) :: supports
      character(len=200) :: message
      type(modes_options_t) :: options
      namelist /beam/ length, elements, young, poisson, density, thickness, width, stiffness, mid_mass, supports, planar
      namelist /modes/ number

      length = 0.72_wp
      elements = 40
      young = 73.0e9_wp
      poisson = 0.3_wp
      density = 2700.0_wp
      thickness = 1.0e-3_wp
      width = 5.0e-3_wp
      stiffness = 0.0_wp
      mid_mass = 0.5_wp
      supports = 'pinned'
      planar = .true.
      number = 4
      call file%only_groups([character(len=5) :: 'beam', 'modes'], error)
      do i = 1, size(file%groups)
         if (allocated(error)) return
         do j = 1, size(file%groups(i)%entries)
            if (file%groups(i)%name == 'beam') then
               read (file%groups(i)%entries(j)%text, nml=beam, iostat=status, iomsg=message)
               if (status /= 0) call file%complain(file%groups(i), j, message, beam_names, error)
            else
               read (file%groups(i)%entries(j)%text, nml=modes, iostat=status, iomsg=message)
               if (status /= 0) call file%complain(file%groups(i), j, message, modes_names, error)
            end if
         end do
      end do
      if (.not. allocated(error)) then
         call build()
         call locate('beam')
      end if
      if (allocated(error)) return
      call block_velocities(problem%beam%nodes, trim(supports), planar, options%blocked, error)
      call locate('beam')
      if (allocated(error)) return
      i = problem%beam%n - size(options%blocked)
      if (number < 1) call raise(error, 'modes', 'number = '//to_text(number)//' is not positive', 'give 1 or more')
      if (number > i) call raise(error, 'modes', 'number = '//to_text(number)//' is more than there are modes', &
                                 'give '//to_text(i)//' or less, or more elements')
      call locate('modes')
      if (allocated(error)) return
      problem%number = number
      call eigenmodes(problem%beam, problem%beam%reference_state(), problem%modes, error, options)
      if (allocated(error)) error%where = file%path//': '//error%where

   contains

      !> The beam from what was read.
      subroutine build()
         type(beam_section_t) :: section
         real(wp), allocatable :: positions(:, :), orientations(:, :)
         character(*), parameter :: here = 'beam'

         if (.not. (length > 0.0_wp .and. length <= huge(length))) &
            call raise(error, here, 'length = '//to_text(length)//' is not positive', 'give it in m')
         if (elements < 1) call raise(error, here, 'elements = '//to_text(elements)//' is not positive', 'give 1 or more')
         if (elements > most_elements) call raise(error, here, 'elements = '//to_text(elements)//' is too many', &
                                                  'give '//to_text(most_elements)//' or less')
         if (.not. (mid_mass >= 0.0_wp .and. mid_mass <= huge(mid_mass))) &
            call raise(error, here, 'mid_mass = '//to_text(mid_mass)//' is negative', 'give it in kg, or 0')
         if (mid_mass > 0.0_wp .and. mod(elements, 2) /= 0) &
            call raise(error, here, 'elements = '//to_text(elements)//' leaves no node at mid-span for mid_mass', &
                       'give an even number')
         if (.not. allocated(error)) &
            call rectangular_section(section, young, poisson, density, thickness, width, error)
         if (.not. allocated(error) .and. .not. all(ieee_is_finite(stiffness))) &
            call raise(error, here, 'an entry of stiffness is not a number', 'give N, N m and N m^2')
         if (allocated(error)) return
         ! In parentheses: the section is rebuilt, and its old mass and inertia with it.
         if (any(abs(stiffness) > 0.0_wp)) &
            call new_section(section, stiffness, (section%mass), (section%inertia), error)
         if (allocated(error)) return
         call straight_nodes([0.0_wp, 0.0_wp, 0.0_wp], [length, 0.0_wp, 0.0_wp], elements, [0.0_wp, 1.0_wp, 0.0_wp], &
                             positions, orientations)
         call new_beam(problem%beam, positions, orientations, section, error)
         if (.not. allocated(error)) call problem%beam%add_mass(1 + elements/2, mid_mass, error)
      end subroutine build

      !> Names the group, if the file has it, or the file.
      subroutine locate(group)
         character(*), intent(in) :: group
         integer :: k

         if (.not. allocated(error)) return
         if (index(error%where, file%path) == 1) return
         do k = 1, size(file%groups)
            if (file%groups(k)%name /= group) cycle
            call file%locate(file%groups(k), error)
            return
         end do
         error%where = file%path//': '//error%where
      end subroutine locate

   end subroutine read_beam_modes

   !> The velocities that supports and the plane take away.
   subroutine block_velocities(nodes, supports, planar, blocked, error)
      integer, intent(in) :: nodes
      character(*), intent(in) :: supports
      logical, intent(in) :: planar
      integer, allocatable, intent(out) :: blocked(:)
      type(error_t), allocatable, intent(inout) :: error
      logical :: fixed(6, nodes)
      integer :: i

      fixed = .false.
      ! Out of the plane: linear velocity 3, angular velocities 1 and 2.
      if (planar) fixed(3:5, :) = .true.
      select case (supports)
      case ('pinned')
         fixed(1:3, [1, nodes]) = .true.
      case ('clamped')
         fixed(:, [1, nodes]) = .true.
      case ('cantilever')
         fixed(:, 1) = .true.
      case ('free')
      case default
         call raise(error, 'beam', 'there are no supports "'//supports//'"', &
                    'use "pinned", "clamped", "cantilever" or "free"')
      end select
      if (all(fixed)) call raise(error, 'beam', 'nothing of it can move', 'give more elements')
      blocked = pack([(i, i=1, 6*nodes)], reshape(fixed, [6*nodes]))
   end subroutine block_velocities

   !> Writes `out/<case>/frequencies.csv` and `out/<case>/shapes.csv`.
   subroutine write_beam_modes(file, problem, out, quiet, error)
      !> The case file, for its name.
      type(namelist_file_t), intent(in) :: file
      !> The solved case.
      type(beam_modes_t), intent(in) :: problem
      !> Folder for the results.
      character(*), intent(in) :: out
      !> Whether nothing is printed.
      logical, intent(in) :: quiet
      !> A file that cannot be written.
      type(error_t), allocatable, intent(inout) :: error
      type(csv_t) :: frequencies, shapes
      character(:), allocatable :: folder, motion, row, symmetry
      real(wp) :: shape(6, problem%beam%nodes)
      integer :: i, j, k

      folder = out//'/'//file%name
      call make_folder(folder)
      call frequencies%create(folder//'/frequencies.csv', error)
      if (.not. allocated(error)) call shapes%create(folder//'/shapes.csv', error)
      if (.not. allocated(error)) call frequencies%put('mode,frequency,motion,symmetry', error)
      if (.not. allocated(error)) call shapes%put('mode,node,x,u_x,u_y,u_z,r_x,r_y,r_z', error)
      if (.not. quiet .and. .not. allocated(error)) write (output_unit, '(2a)') file%name, ': mode, frequency [Hz], motion'
      do i = 1, problem%number
         if (allocated(error)) exit
         shape = reshape(problem%modes%shapes(:, i), [6, problem%beam%nodes])
         call describe(problem%beam, shape, motion, symmetry)
         if (.not. quiet) write (output_unit, '(i6, f14.4, 4a)') i, problem%modes%frequency(i), '  ', symmetry, ' ', motion
         call frequencies%put(to_text(i)//','//number(problem%modes%frequency(i))//','//motion//','//symmetry, error)
         shape = shape/reference_entry(shape, problem%beam%x_reference(7*problem%beam%nodes - 6))
         do j = 1, problem%beam%nodes
            if (allocated(error)) exit
            row = to_text(i)//','//to_text(j)//','//number(problem%beam%x_reference(7*j - 6))
            do k = 1, 6
               row = row//','//number(shape(k, j))
            end do
            call shapes%put(row, error)
         end do
      end do
      if (.not. allocated(error)) call frequencies%finish(error)
      if (.not. allocated(error)) call shapes%finish(error)
      if (.not. allocated(error)) return
      call frequencies%discard()
      call shapes%discard()
   end subroutine write_beam_modes

   !> The largest displacement of a shape with its sign; the largest rotation where nothing is displaced.
   pure function reference_entry(shape, length) result(value)
      real(wp), intent(in) :: shape(:, :), length
      real(wp) :: value
      integer :: place(2)

      place = maxloc(abs(shape(1:3, :)))
      if (abs(shape(place(1), place(2))) <= 1.0e-9_wp*length*maxval(abs(shape))) place = maxloc(abs(shape))
      value = shape(place(1), place(2))
   end function reference_entry

   !> What moves most, by kinetic energy, and how the motion looks in a mirror at mid-span.
   subroutine describe(beam, shape, motion, symmetry)
      type(beam_t), intent(in) :: beam
      real(wp), intent(in) :: shape(:, :)
      character(:), allocatable, intent(out) :: motion, symmetry
      real(wp) :: mirrored, part(4)
      integer :: i, n

      n = beam%nodes
      part = 0.0_wp
      mirrored = 0.0_wp
      do i = 1, n
         associate (s => shape(:, i), m => beam%m(i), j => beam%inertia(:, :, i))
            part = part + [m*s(1)**2, m*s(2)**2 + j(3, 3)*s(6)**2, m*s(3)**2 + j(2, 2)*s(5)**2, j(1, 1)*s(4)**2]
         end associate
         associate (s => shape(:, i), mirror => shape(:, n + 1 - i))
            mirrored = mirrored + beam%m(i)*(dot_product(s(2:3), mirror(2:3)) - s(1)*mirror(1)) + &
                       beam%inertia(1, 1, i)*s(4)*mirror(4)
         end associate
      end do
      select case (maxloc(part, 1))
      case (1)
         motion = 'axial'
      case (2)
         motion = 'bending'
      case (3)
         motion = 'bending-across'
      case default
         motion = 'torsion'
      end select
      symmetry = 'none'
      if (mirrored > 0.5_wp*sum(part)) symmetry = 'symmetric'
      if (mirrored < -0.5_wp*sum(part)) symmetry = 'antisymmetric'
   end subroutine describe

   !> A number without blanks.
   function number(value) result(text)
      real(wp), intent(in) :: value
      character(:), allocatable :: text

      text = trim(adjustl(number_text(value)))
   end function number

end module taut_case_beam_modes
