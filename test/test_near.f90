!> Tests of what is told of joints that all but repeat each other.
module test_near
   use taut, only: error_t, mechanism_builder_t, mechanism_t, state_t, time_function_t, wp
   use taut_error, only: to_text
   use taut_model_mechanism_function, only: function_ramp
   use taut_model_mechanism_redundancy, only: find_redundancy, redundancy_t
   use testing, only: check, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_near

   real(wp), parameter :: o(3) = 0.0_wp, z(3) = [0.0_wp, 0.0_wp, 1.0_wp]

contains

   !> All tests of this module.
   function collect_near() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('an axis that is a little off', tilted), &
               new_test('a drive near its dead point', dead_point), &
               new_test('rods that all but fit', parallel_rods), &
               new_test('a misfit beside what moves', beside_what_moves), &
               new_test('a door whose hinges are not in line', door), &
               new_test('guides that are not parallel', guides), &
               new_test('nothing is said of linkages that fit', fitting)]
   end function collect_near

   !> Four hinges in space, the last of which is tilted: from round-off to what is no mechanism any more.
   subroutine tilted(failure)
      character(:), allocatable, intent(inout) :: failure
      character(:), allocatable :: text
      real(wp), parameter :: tilts(7) = [0.0_wp, 1.0e-10_wp, 1.0e-8_wp, 1.0e-6_wp, 1.0e-4_wp, 1.0e-2_wp, 0.5_wp], &
                             b(3) = [0.0_wp, 0.4_wp, 0.0_wp], c(3) = [1.0_wp, 0.9_wp, 0.0_wp], d(3) = [1.0_wp, 0.0_wp, 0.0_wp]
      integer :: i

      do i = 1, size(tilts)
         block
            type(mechanism_builder_t) :: builder

            call builder%add_body('crank', mass=1.0_wp, shape='rod', thickness=0.02_wp, from=o, to=b)
            call builder%add_body('coupler', mass=1.0_wp, shape='rod', thickness=0.02_wp, from=b, to=c)
            call builder%add_body('rocker', mass=1.0_wp, shape='rod', thickness=0.02_wp, from=d, to=c)
            call builder%add_joint('A', 'revolute', 'ground', 'crank', point=o, axis=z)
            call builder%add_joint('B', 'revolute', 'crank', 'coupler', point=b, axis=z)
            call builder%add_joint('C', 'revolute', 'coupler', 'rocker', point=c, axis=z)
            call builder%add_joint('D', 'revolute', 'ground', 'rocker', point=d, axis=[0.0_wp, tilts(i), 1.0_wp])
            call diagnosis(builder, text, failure)
         end block
         if (allocated(failure)) return
         if (i == 1 .or. i == size(tilts)) then
            call check(failure, text == '', text)
         else
            call check(failure, index(text, 'A, B, C and D') == 1 .and. index(text, 'the axis of D is 1.000E-0') > 0, text)
            call check(failure, (index(text, 'nothing of them can move') > 0) .eqv. tilts(i) > 1.0e-5_wp, 'moves: '//text)
            call check(failure, index(text, 'such as a spherical one') > 0, 'what to do: '//text)
         end if
      end do
   end subroutine tilted

   !> A crank-rocker whose rocker is driven, near where crank and coupler are in a line, and far from it.
   subroutine dead_point(failure)
      character(:), allocatable, intent(inout) :: failure
      character(:), allocatable :: text
      real(wp), parameter :: angles(3) = [1.0_wp, 1.0e-3_wp, 1.0e-5_wp]
      real(wp) :: a(3), b(3), d(3)
      integer :: i

      do i = 1, size(angles)
         block
            type(mechanism_builder_t) :: builder

            builder%planar = .true.
            a = [0.5_wp, 0.0_wp, 0.0_wp]
            b = a + 1.2_wp*[cos(angles(i)), sin(angles(i)), 0.0_wp]
            d = [1.4_wp, -0.7_wp, 0.0_wp]
            call builder%add_function(time_function_t(name='turn', kind=function_ramp, rate=0.5_wp))
            call builder%add_body('crank', mass=0.5_wp, shape='rod', from=o, to=a)
            call builder%add_body('coupler', mass=1.2_wp, shape='rod', from=a, to=b)
            call builder%add_body('rocker', mass=0.8_wp, shape='rod', from=d, to=b)
            call builder%add_joint('O', 'revolute', 'ground', 'crank', point=o)
            call builder%add_joint('A', 'revolute', 'crank', 'coupler', point=a)
            call builder%add_joint('B', 'revolute', 'coupler', 'rocker', point=b)
            call builder%add_joint('C', 'revolute', 'ground', 'rocker', point=d, drive_angle='turn')
            call diagnosis(builder, text, failure)
         end block
         if (allocated(failure)) return
         if (i == 1) then
            call check(failure, text == '', text)
         else
            call check(failure, index(text, 'a dead point, where C cannot be driven') > 0, 'C: '//text)
         end if
      end do
   end subroutine dead_point

   !> A parallelogram with a third rod, which is a little askew: it holds still.
   subroutine parallel_rods(failure)
      character(:), allocatable, intent(inout) :: failure
      character(:), allocatable :: text
      real(wp), parameter :: askew(2) = [0.0_wp, 1.0e-9_wp]
      real(wp) :: from(3), to(3)
      character :: rod
      integer :: i, k

      do i = 1, 2
         block
            type(mechanism_builder_t) :: builder

            builder%planar = .true.
            call builder%add_body('beam', mass=1.0_wp, shape='rod', from=[0.0_wp, 1.0_wp, 0.0_wp], to=[2.0_wp, 1.0_wp, 0.0_wp])
            do k = 1, 3
               rod = achar(iachar('0') + k)
               from = [k - 1.0_wp, 0.0_wp, 0.0_wp]
               to = from + [0.0_wp, 1.0_wp, 0.0_wp]
               if (k == 3) from(1) = from(1) + askew(i)
               call builder%add_body('rod'//rod, mass=1.0_wp, shape='rod', from=from, to=to)
               call builder%add_joint('low'//rod, 'revolute', 'ground', 'rod'//rod, point=from)
               call builder%add_joint('high'//rod, 'revolute', 'rod'//rod, 'beam', point=to)
            end do
            ! One of the rods is too many, however it stands: beside its own misfit nothing else is.
            call diagnosis(builder, text, failure, freedoms=1)
         end block
         if (allocated(failure)) return
         if (i == 1) then
            call check(failure, text == '', text)
         else
            ! The middle rod would have to go half as far as the third one.
            call check(failure, index(text, 'low3') > 0 .and. index(text, 'by about 5.0') > 0 .and. &
                       index(text, 'E-010 m') > 0 .and. index(text, 'leave one out') > 0, 'the third: '//text)
         end if
      end do
   end subroutine parallel_rods

   !> A linkage of hinges in space, one of them tilted or none, each link a rod to the next hinge.
   subroutine add_linkage(builder, places, axis, tilt, last_type)
      type(mechanism_builder_t), intent(inout) :: builder
      real(wp), intent(in) :: places(:, :), axis(3), tilt
      character(*), intent(in) :: last_type
      character :: link, before
      integer :: i, n

      n = size(places, 2)
      do i = 1, n - 1
         link = achar(iachar('0') + i)
         call builder%add_body('link'//link, mass=1.0_wp, shape='rod', thickness=0.02_wp, from=places(:, i), to=places(:, i + 1))
         if (i == 1) call builder%add_joint('J1', 'revolute', 'ground', 'link1', point=places(:, 1), axis=axis)
         before = achar(iachar('0') + i - 1)
         if (i > 1) call builder%add_joint('J'//link, 'revolute', 'link'//before, 'link'//link, point=places(:, i), axis=axis)
      end do
      if (last_type == 'spherical') then
         call builder%add_joint('last', last_type, 'ground', 'link'//link, point=places(:, n))
      else
         call builder%add_joint('last', last_type, 'ground', 'link'//link, point=places(:, n), &
                                axis=axis + [0.0_wp, tilt, 0.0_wp])
      end if
   end subroutine add_linkage

   !> A four-bar beside a pendulum, and a five-bar that keeps one of its two motions; what is to be done frees the motion.
   subroutine beside_what_moves(failure)
      character(:), allocatable, intent(inout) :: failure
      character(:), allocatable :: text
      real(wp), parameter :: tilts(3) = [1.0e-5_wp, 1.0e-4_wp, 1.0e-3_wp], &
                             four(3, 4) = reshape([0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.4_wp, 0.0_wp, &
                                                   1.0_wp, 0.9_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp], [3, 4]), &
                             five(3, 5) = reshape([0.0_wp, 0.0_wp, 0.0_wp, -0.3_wp, 0.8_wp, 0.0_wp, 0.5_wp, 1.3_wp, 0.0_wp, &
                                                   1.3_wp, 0.8_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp], [3, 5])
      integer :: i

      do i = 1, size(tilts)
         block
            type(mechanism_builder_t) :: beside, less

            call add_linkage(beside, four, z, tilts(i), 'revolute')
            call beside%add_body('pendulum', mass=1.0_wp, shape='rod', thickness=0.02_wp, from=[3.0_wp, 0.0_wp, 0.0_wp], &
                                 to=[4.0_wp, 0.0_wp, 0.0_wp])
            call beside%add_joint('P', 'revolute', 'ground', 'pendulum', point=[3.0_wp, 0.0_wp, 0.0_wp], axis=z)
            call diagnosis(beside, text, failure)
            if (allocated(failure)) return
            call check(failure, index(text, 'J1, J2, J3 and last hold each other, and nothing') == 1 .and. &
                       index(text, 'the axis of last is '//to_text(tilts(i))//' rad off') > 0, 'four: '//text)
            call add_linkage(less, five, z, tilts(i), 'revolute')
            call diagnosis(less, text, failure)
            if (allocated(failure)) return
            call check(failure, index(text, 'J1, J2, J3, J4 and last have a motion less') == 1 .and. &
                       index(text, 'the axis of last is '//to_text(tilts(i))//' rad off') > 0, 'five: '//text)
         end block
         if (allocated(failure)) return
      end do
      block
         type(mechanism_builder_t) :: cured

         call add_linkage(cured, four, z, 0.0_wp, 'spherical')
         call diagnosis(cured, text, failure, freedoms=1)
         call check(failure, text == '', 'a spherical joint: '//text)
      end block
   end subroutine beside_what_moves

   !> Two hinges of one body: the second tilted, or beside the axis of the first.
   subroutine door(failure)
      character(:), allocatable, intent(inout) :: failure
      character(:), allocatable :: text
      real(wp), parameter :: sizes(4) = [1.0e-12_wp, 1.0e-9_wp, 1.0e-6_wp, 1.0e-3_wp]
      integer :: i, k

      do i = 1, size(sizes)
         do k = 1, 3
            block
               type(mechanism_builder_t) :: builder

               call builder%add_body('door', mass=1.0_wp, shape='rod', thickness=0.02_wp, from=o, to=[1.0_wp, 0.0_wp, 1.0_wp])
               call builder%add_joint('low', 'revolute', 'ground', 'door', point=o, axis=z)
               select case (k)
               case (1)
                  call builder%add_joint('high', 'revolute', 'ground', 'door', point=z, axis=z + [0.0_wp, sizes(i), 0.0_wp])
               case (2)
                  call builder%add_joint('high', 'revolute', 'ground', 'door', point=z + [0.0_wp, sizes(i), 0.0_wp], axis=z)
               case default
                  ! What is advised against a tilt.
                  call builder%add_joint('high', 'spherical', 'ground', 'door', point=z)
               end select
               call diagnosis(builder, text, failure)
            end block
            if (allocated(failure)) return
            select case (k)
            case (1)
               call check(failure, index(text, 'the axis of high is '//to_text(sizes(i))//' rad off that of low') > 0 .and. &
                          index(text, 'such as a spherical one') > 0, 'tilted: '//text)
            case (2)
               call check(failure, index(text, 'the axis of high is '//to_text(sizes(i))//' m beside that of low') > 0, &
                          'beside: '//text)
            case default
               call check(failure, text == '', text)
            end select
         end do
      end do
   end subroutine door

   !> A second guide with a joint that lets its axis go would still be in the way: it is to be left out.
   subroutine guides(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      character(:), allocatable :: text
      real(wp), parameter :: x(3) = [1.0_wp, 0.0_wp, 0.0_wp]

      call builder%add_body('block', mass=1.0_wp, shape='rod', thickness=0.02_wp, from=o, to=x)
      call builder%add_joint('one', 'prismatic', 'ground', 'block', point=o, axis=x)
      call builder%add_joint('two', 'prismatic', 'ground', 'block', point=x, axis=x + [0.0_wp, 1.0e-4_wp, 0.0_wp])
      call diagnosis(builder, text, failure)
      call check(failure, index(text, 'the axis of two is 1.000E-004 rad off that of one') > 0 .and. &
                 index(text, 'or leave it out') > 0, text)
   end subroutine guides

   !> Linkages with honest motions: in any unit, with axes that nearly agree because they meet in a point, near a change point.
   subroutine fitting(failure)
      character(:), allocatable, intent(inout) :: failure
      character(:), allocatable :: text
      real(wp), parameter :: units(3) = [1.0e-6_wp, 1.0_wp, 1.0e6_wp], cones(3) = [1.0_wp, 1.0e-2_wp, 1.0e-3_wp], &
                             turns(4) = [0.1_wp, 1.3_wp, 2.9_wp, 4.2_wp]
      real(wp) :: places(3, 4)
      integer :: i, j

      do i = 1, size(units)
         block
            type(mechanism_builder_t) :: builder

            places = units(i)*reshape([0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.4_wp, 0.0_wp, 1.0_wp, 0.9_wp, 0.0_wp, 1.0_wp, 0.0_wp, &
                                       0.0_wp], [3, 4])
            call add_linkage(builder, places, z, 0.0_wp, 'revolute')
            call diagnosis(builder, text, failure)
         end block
         if (.not. allocated(failure)) call check(failure, text == '', 'units of '//to_text(units(i))//' m: '//text)
         if (allocated(failure)) return
      end do
      do i = 1, size(cones)
         block
            type(mechanism_builder_t) :: builder

            do j = 1, 4
               places(:, j) = [cones(i)*cos(turns(j)), cones(i)*sin(turns(j)), 1.0_wp]
               places(:, j) = places(:, j)/norm2(places(:, j))
            end do
            call builder%add_body('a', mass=1.0_wp, shape='rod', thickness=0.02_wp, from=places(:, 1), to=places(:, 2))
            call builder%add_body('b', mass=1.0_wp, shape='rod', thickness=0.02_wp, from=places(:, 2), to=places(:, 3))
            call builder%add_body('c', mass=1.0_wp, shape='rod', thickness=0.02_wp, from=places(:, 3), to=places(:, 4))
            call builder%add_joint('J1', 'revolute', 'ground', 'a', point=places(:, 1), axis=places(:, 1))
            call builder%add_joint('J2', 'revolute', 'a', 'b', point=places(:, 2), axis=places(:, 2))
            call builder%add_joint('J3', 'revolute', 'b', 'c', point=places(:, 3), axis=places(:, 3))
            call builder%add_joint('J4', 'revolute', 'ground', 'c', point=places(:, 4), axis=places(:, 4))
            call diagnosis(builder, text, failure)
         end block
         if (.not. allocated(failure)) call check(failure, text == '', 'a cone of '//to_text(cones(i))//' rad: '//text)
         if (allocated(failure)) return
      end do
      ! A parallelogram that is almost flat fits, and yet branches near by.
      do i = 1, 2
         block
            type(mechanism_builder_t) :: builder
            real(wp), parameter :: off(2) = [1.0e-2_wp, 1.0e-7_wp]

            places = 0.0_wp
            places(1:2, 2) = 0.4_wp*[cos(off(i)), sin(off(i))]
            places(1:2, 3) = places(1:2, 2) + [1.0_wp, 0.0_wp]
            places(1, 4) = 1.0_wp
            call add_linkage(builder, places, z, 0.0_wp, 'revolute')
            call diagnosis(builder, text, failure)
         end block
         if (.not. allocated(failure)) call check(failure, (index(text, 'a position where motions branch') > 0) .eqv. i == 2, text)
         if (allocated(failure)) return
      end do
   end subroutine fitting

   !> What is told of a mechanism where it starts; empty if nothing is.
   subroutine diagnosis(builder, text, failure, freedoms)
      type(mechanism_builder_t), intent(inout) :: builder
      character(:), allocatable, intent(out) :: text
      character(:), allocatable, intent(inout) :: failure
      !> How many degrees of freedom it is to have.
      integer, intent(in), optional :: freedoms
      type(mechanism_t) :: mechanism
      type(redundancy_t) :: found
      type(error_t), allocatable :: error
      type(state_t) :: at

      call builder%complete(mechanism, at, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      call mechanism%diagnose(at, text)
      if (.not. allocated(text)) text = ''
      if (.not. present(freedoms)) return
      call find_redundancy(mechanism, at, found)
      call check(failure, mechanism%n - found%rank == freedoms, 'degrees of freedom: '//to_text(mechanism%n - found%rank))
   end subroutine diagnosis

end module test_near
