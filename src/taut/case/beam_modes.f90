!> Case files and results of the eigenanalysis of a straight beam.
module taut_case_beam_modes
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_case_csv, only: csv_t
   use taut_case_number, only: number_text
   use taut_case_entries, only: entries_t
   use taut_case_group, only: check_groups, declare_group, declared_t, first_group, group_data_t, read_group
   use taut_case_namelist_file, only: namelist_file_t
   use taut_case_posix, only: make_folder
   use taut_case_process, only: say
   use taut_constrained_modes, only: eigenmodes, modes_options_t, modes_t
   use taut_model_beam, only: beam_t, new_beam, straight_nodes
   use taut_model_beam_section, only: beam_section_t, new_section, rectangular_section
   implicit none (type, external)
   private
   public :: beam_modes_t, declare_beam_modes, read_beam_modes, write_beam_modes

   !> &beam; what it leaves out has the values of Sect. 4.2.
   type, extends(group_data_t) :: beam_group_t
      !> Length [m].
      real(wp) :: length = 0.72_wp
      !> Number of elements.
      integer :: elements = 40
      !> Young's modulus [Pa], Poisson's ratio, density [kg/m^3].
      real(wp) :: young = 73.0e9_wp, poisson = 0.3_wp, density = 2700.0_wp
      !> Sides of the section [m].
      real(wp) :: thickness = 1.0e-3_wp, width = 5.0e-3_wp
      !> Stiffness of the section in place of the rectangle's [N, N m, N m^2]; all zeros for none.
      real(wp) :: stiffness(6, 6) = 0.0_wp
      !> Mass at mid-span [kg].
      real(wp) :: mid_mass = 0.5_wp
      !> One of `support_names`.
      character(len=16) :: supports = 'pinned'
      !> Whether it stays in the plane x-y.
      logical :: planar = .true.
   contains
      procedure :: declare => declare_beam
   end type beam_group_t

   !> &modes.
   type, extends(group_data_t) :: modes_group_t
      !> How many are written.
      integer :: number = 4
   contains
      procedure :: declare => declare_modes
   end type modes_group_t

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

   !> How the ends are held.
   character(len=10), parameter :: support_names(4) = [character(len=10) :: 'pinned', 'clamped', 'cantilever', 'free']

contains

   !> The groups of a case file.
   subroutine declare_beam_modes(groups)
      !> The groups.
      type(declared_t), allocatable, intent(out) :: groups(:)
      type(beam_group_t) :: beam
      type(modes_group_t) :: modes

      call declare_group(groups, beam)
      call declare_group(groups, modes)
   end subroutine declare_beam_modes

   !> Entries of &beam.
   subroutine declare_beam(self, entries)
      !> What the group says.
      class(beam_group_t), intent(inout) :: self
      !> What passes over them.
      type(entries_t), intent(inout) :: entries

      call entries%group('beam', 'a straight beam along x')
      call entries%item('length', self%length, 'm', 'length', above=0.0_wp)
      call entries%item('elements', self%elements, 'number of elements', least=1, most=most_elements)
      call entries%item('young', self%young, 'Pa', 'Young''s modulus', above=0.0_wp)
      call entries%item('poisson', self%poisson, '', 'Poisson''s ratio')
      call entries%item('density', self%density, 'kg/m^3', 'density', above=0.0_wp)
      call entries%item('thickness', self%thickness, 'm', 'side of the section along axis 2', above=0.0_wp)
      call entries%item('width', self%width, 'm', 'side of the section along axis 3', above=0.0_wp)
      call entries%item('stiffness', self%stiffness, 'N, N m, N m^2', &
                        'matrix of the section: axial, two of shear, torsion, two of bending; zeros: that of the rectangle')
      call entries%item('mid_mass', self%mid_mass, 'kg', 'mass in the middle', least=0.0_wp)
      call entries%item('supports', self%supports, 'how its ends are held', support_names)
      call entries%item('planar', self%planar, 'whether it stays in the plane x-y')
   end subroutine declare_beam

   !> Entries of &modes.
   subroutine declare_modes(self, entries)
      !> What the group says.
      class(modes_group_t), intent(inout) :: self
      !> What passes over them.
      type(entries_t), intent(inout) :: entries

      call entries%group('modes', 'what is written')
      call entries%item('number', self%number, 'number of modes, the lowest first', least=1)
   end subroutine declare_modes

   !> Reads a case file and solves it.
   subroutine read_beam_modes(file, problem, error)
      !> The case file.
      type(namelist_file_t), intent(in) :: file
      !> The case.
      type(beam_modes_t), intent(out) :: problem
      !> What is wrong with the file, or why there is no solution.
      type(error_t), allocatable, intent(inout) :: error
      type(beam_group_t) :: beam
      type(modes_group_t) :: modes
      type(modes_options_t) :: options
      type(declared_t), allocatable :: groups(:)
      integer :: i

      call declare_beam_modes(groups)
      call check_groups(file, groups, error)
      do i = 1, size(file%groups)
         if (allocated(error)) return
         if (file%groups(i)%name == 'beam') then
            call read_group(file, file%groups(i), beam, error)
         else
            call read_group(file, file%groups(i), modes, error)
         end if
      end do
      if (allocated(error)) return
      call build(beam, problem%beam, error)
      if (.not. allocated(error)) &
         call block_velocities(problem%beam%nodes, trim(beam%supports), beam%planar, options%blocked, error)
      call locate(file, 'beam', error)
      if (allocated(error)) return
      i = problem%beam%n - size(options%blocked)
      if (modes%number > i) call raise(error, 'modes', 'number = '//to_text(modes%number)//' is more than there are modes', &
                                       'give '//to_text(i)//' or less, or more elements')
      call locate(file, 'modes', error)
      if (allocated(error)) return
      problem%number = modes%number
      options%damped = .false.
      call eigenmodes(problem%beam, problem%beam%reference_state(), problem%modes, error, options)
      if (allocated(error)) error%where = file%path//': '//error%where
   end subroutine read_beam_modes

   !> The beam from what was read.
   subroutine build(group, beam, error)
      type(beam_group_t), intent(in) :: group
      type(beam_t), intent(out) :: beam
      type(error_t), allocatable, intent(inout) :: error
      type(beam_section_t) :: section
      real(wp), allocatable :: positions(:, :), orientations(:, :)

      if (group%mid_mass > 0.0_wp .and. mod(group%elements, 2) /= 0) &
         call raise(error, 'beam', 'elements = '//to_text(group%elements)//' leaves no node at mid-span for mid_mass', &
                    'give an even number')
      if (allocated(error)) return
      call rectangular_section(section, group%young, group%poisson, group%density, group%thickness, group%width, error)
      if (allocated(error)) return
      ! In parentheses: the section is rebuilt, and its old mass and inertia with it.
      if (any(abs(group%stiffness) > 0.0_wp)) &
         call new_section(section, group%stiffness, (section%mass), (section%inertia), error)
      if (allocated(error)) return
      call straight_nodes([0.0_wp, 0.0_wp, 0.0_wp], [group%length, 0.0_wp, 0.0_wp], group%elements, [0.0_wp, 1.0_wp, 0.0_wp], &
                          positions, orientations)
      call new_beam(beam, positions, orientations, section, error)
      if (.not. allocated(error)) call beam%add_mass(1 + group%elements/2, group%mid_mass, error)
   end subroutine build

   !> Names the group, if the file has it, or the file.
   subroutine locate(file, group, error)
      type(namelist_file_t), intent(in) :: file
      character(*), intent(in) :: group
      type(error_t), allocatable, intent(inout) :: error
      integer :: k

      if (.not. allocated(error)) return
      k = first_group(file, group)
      if (k > 0) call file%locate(file%groups(k), error)
      if (k == 0) error%where = file%path//': '//error%where
   end subroutine locate

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
      character(len=80) :: line
      real(wp) :: shape(6, problem%beam%nodes)
      integer :: i, j, k

      folder = out//'/'//file%name
      call make_folder(folder)
      call frequencies%create(folder//'/frequencies.csv', error)
      if (.not. allocated(error)) call shapes%create(folder//'/shapes.csv', error)
      if (.not. allocated(error)) call frequencies%put('mode,frequency,motion,symmetry', error)
      if (.not. allocated(error)) call shapes%put('mode,node,x,u_x,u_y,u_z,r_x,r_y,r_z', error)
      if (.not. quiet .and. .not. allocated(error)) call say(file%name//': mode, frequency [Hz], motion')
      do i = 1, problem%number
         if (allocated(error)) exit
         shape = reshape(problem%modes%shapes(:, i), [6, problem%beam%nodes])
         call describe(problem%beam, shape, motion, symmetry)
         write (line, '(i6, f14.4, 4a)') i, problem%modes%frequency(i), '  ', symmetry, ' ', motion
         if (.not. quiet) call say(trim(line))
         call frequencies%put(to_text(i)//','//trim(number_text(problem%modes%frequency(i)))//','//motion//','//symmetry, error)
         shape = shape/reference_entry(shape, problem%beam%x_reference(7*problem%beam%nodes - 6))
         do j = 1, problem%beam%nodes
            if (allocated(error)) exit
            row = to_text(i)//','//to_text(j)//','//trim(number_text(problem%beam%x_reference(7*j - 6)))
            do k = 1, 6
               row = row//','//trim(number_text(shape(k, j)))
            end do
            call shapes%put(row, error)
         end do
      end do
      if (.not. allocated(error)) call frequencies%finish(error)
      if (.not. allocated(error)) call shapes%finish(error)
      if (.not. allocated(error)) then
         if (.not. quiet) call say('results in '//folder)
         return
      end if
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

end module taut_case_beam_modes
