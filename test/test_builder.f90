!> Tests of building a mechanism part by part.
module test_builder
   use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_value
   use taut, only: block_diagonal_t, error_t, integration_options_t, integration_result_t, mechanism_builder_t, mechanism_t, &
                   simulate, state_t, status_reached_end, wp
   use taut_error, only: to_text
   use taut_name_index, only: name_index_t
   use taut_rotation, only: rotate
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   implicit none (type, external)
   private
   public :: collect_builder

   real(wp), parameter :: o(3) = 0.0_wp

contains

   !> All tests of this module.
   function collect_builder() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('names are found again', names_found), &
               new_test('a double pendulum keeps its energy and its joints', double_pendulum), &
               new_test('a spring, a load and an event', spring_and_load), &
               new_test('columns of springs, and bodies by their names', spring_columns), &
               new_test('shapes lie along their ends', shapes_by_ends), &
               new_test('elastic rows are the stiff part of the force', elastic_rows), &
               new_test('what is wrong first is told', faults), &
               new_test('what leaves the plane is refused', out_of_plane), &
               new_test('events have names of their own, and values', faulty_events), &
               new_test('what may not be meant is noted', noted)]
   end function collect_builder

   subroutine names_found(failure)
      character(:), allocatable, intent(inout) :: failure
      type(name_index_t) :: index
      character(len=8) :: name
      integer :: i

      call check(failure, index%find('a') == 0, 'an empty index')
      do i = 1, 1000
         write (name, '(a, i0)') 'rod', i
         call index%add(name, i)
      end do
      do i = 1, 1000
         write (name, '(a, i0)') 'rod', i
         call check(failure, index%find(name) == i, 'its number')
      end do
      call check(failure, index%find('rod0') == 0 .and. index%count == 1000, 'no other')
      call check(failure, index%nearest_to('rod10001') == 'rod1000', 'one letter too many: '//index%nearest_to('rod10001'))
      call check(failure, index%nearest_to('wheel') == '' .and. index%nearest_to('x') == '', 'nothing near')
      call index%add('rod7', 5)
      call check(failure, index%find('rod7') == 5 .and. index%count == 1000, 'a number is replaced')
   end subroutine names_found

   !> Two rods in space, hinged about y.
   subroutine build(builder)
      type(mechanism_builder_t), intent(inout) :: builder

      builder%gravity = [0.0_wp, 0.0_wp, -9.81_wp]
      call builder%add_body('upper', mass=1.0_wp, shape='rod', from=o, to=[1.0_wp, 0.0_wp, 0.0_wp])
      call builder%add_body('lower', mass=1.0_wp, shape='rod', from=[1.0_wp, 0.0_wp, 0.0_wp], to=[2.0_wp, 0.0_wp, 0.0_wp])
      call builder%add_joint('A', 'revolute', 'ground', 'upper', point=o, axis=[0.0_wp, 1.0_wp, 0.0_wp])
      call builder%add_joint('B', 'revolute', 'upper', 'lower', point=[1.0_wp, 0.0_wp, 0.0_wp], axis=[0.0_wp, 1.0_wp, 0.0_wp])
   end subroutine build

   subroutine double_pendulum(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(integration_result_t) :: result
      type(error_t), allocatable :: error
      real(wp) :: energy
      real(wp), allocatable :: phi(:)

      call build(builder)
      call builder%complete(mechanism, at, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      call check(failure, mechanism%n == 12 .and. mechanism%c == 10, 'sizes')
      energy = mechanism%energy(at)
      call simulate(mechanism, at, 1.0_wp, result, error, options=integration_options_t(rtol=1.0e-9_wp, atol=1.0e-12_wp))
      call no_error(failure, error)
      call check(failure, result%status == status_reached_end, 'the end is reached')
      call check_close(failure, mechanism%energy(at), energy, 1.0e-6_wp, 'energy')
      allocate (phi(mechanism%n_phi))
      call mechanism%constraint(at, phi)
      call check_below(failure, maxval(abs(phi)), 1.0e-12_wp, 'joints')
   end subroutine double_pendulum

   subroutine spring_and_load(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp) :: f(3), g(1)

      call builder%add_point_mass('m', mass=2.0_wp, position=[2.0_wp, 0.0_wp, 0.0_wp])
      call builder%add_ground_point('P', o)
      call builder%add_spring('P', 'm', stiffness=10.0_wp, free_length=1.5_wp)
      call builder%add_load('m', [0.0_wp, 3.0_wp, 0.0_wp])
      call builder%add_event('passes', 'x', 1.25_wp, point='m')
      call builder%complete(mechanism, at, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      call mechanism%force(at, f)
      ! Tension 10 (2 - 1.5) towards P.
      call check_below(failure, maxval(abs(f - [-5.0_wp, 3.0_wp, 0.0_wp])), 1.0e-14_wp, 'force')
      call mechanism%event_values(at, g)
      call check_close(failure, g(1), 0.75_wp, 1.0e-15_wp, 'event')
   end subroutine spring_and_load

   !> f = f_s - B^T k g in a state that moves, and B is the derivative of the length of a spring.
   subroutine elastic_rows(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: mechanism
      type(state_t) :: at, near
      type(error_t), allocatable :: error
      type(block_diagonal_t) :: stiffness
      integer, allocatable :: column(:), first(:)
      real(wp), allocatable :: b(:), b_near(:), d(:), f(:), g(:), g_near(:), sigma(:), soft(:)
      real(wp), parameter :: step = 1.0e-6_wp
      integer :: i, j, k

      call build(builder)
      call builder%add_spring('ground', 'lower', [0.5_wp, 0.3_wp, 1.0_wp], [1.7_wp, 0.1_wp, 0.0_wp], stiffness=100.0_wp, &
                              damping=3.0_wp, preload=2.0_wp)
      call builder%add_spring('lower', 'upper', [1.9_wp, 0.1_wp, 0.0_wp], [0.2_wp, 0.0_wp, 0.1_wp], damping=5.0_wp)
      call builder%add_spring(joint='B', stiffness=20.0_wp, free_angle=0.4_wp)
      call builder%add_beam('beam', [0.0_wp, 1.0_wp, 0.0_wp], [1.0_wp, 1.0_wp, 0.0_wp], 2, young=1.0e7_wp, density=1000.0_wp, &
                            thickness=0.05_wp, width=0.05_wp, axis_2=[0.0_wp, 0.0_wp, 1.0_wp], damping=1.0e-3_wp)
      call builder%complete(mechanism, at, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      do i = 1, mechanism%n
         at%v(i) = 0.1_wp*sin(3.0_wp*i)
      end do
      call mechanism%displace(0.03_wp*at%v, at%x)
      call mechanism%normalize(at%x)
      call mechanism%elastic_pattern(first, column)
      call check(failure, mechanism%n_elastic == 14 .and. size(first) == 15, 'two springs and two elements')
      allocate (b(size(column)), b_near(size(column)), g(14), g_near(14), sigma(14), f(mechanism%n), soft(mechanism%n), &
                d(mechanism%n))
      call mechanism%elastic_stiffness(stiffness)
      call mechanism%elastic_rows(at, g, b)
      call stiffness%multiply(g, sigma)
      call mechanism%force(at, f)
      call mechanism%soft_force(at, soft)
      do i = 1, 14
         do k = first(i), first(i + 1) - 1
            soft(column(k)) = soft(column(k)) - b(k)*sigma(i)
         end do
      end do
      call check_below(failure, maxval(abs(f - soft)), 1.0e-9_wp*maxval(abs(f)), 'force')
      at%v = 0.0_wp
      near = at
      call mechanism%elastic_rows(at, g, b)
      ! An angle has other derivatives, too, where the axes are not parallel.
      do k = first(1), first(2) - 1
         j = column(k)
         d = 0.0_wp
         d(j) = step
         near%x = at%x
         call mechanism%displace(d, near%x)
         call mechanism%elastic_rows(near, g_near, b_near)
         call check_close(failure, (g_near(1) - g(1))/step, b(k), 1.0e-5_wp, 'derivative')
      end do
   end subroutine elastic_rows

   !> A spring with a damper that is pulled at, and one about a hinge: what they do, and how they are chosen.
   subroutine spring_columns(failure)
      character(:), allocatable, intent(inout) :: failure
      character(len=14), parameter :: names(4) = [character(len=14) :: 'about.moment', 'about.angle', 'between.force', &
                                                  'between.length']
      real(wp), parameter :: angle = 0.3_wp, far = 2.5_wp, fast = 0.4_wp
      type(mechanism_builder_t) :: builder, faulty
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp), allocatable :: lambda(:), values(:)
      integer :: i, k

      call build(builder)
      call builder%add_point_mass('bob', 1.0_wp, position=[0.0_wp, far, 0.0_wp], velocity=[0.0_wp, fast, 0.0_wp])
      call builder%add_spring(body_2='bob', point_1=o, stiffness=100.0_wp, damping=5.0_wp, free_length=2.0_wp, preload=1.0_wp, &
                              name='between')
      call builder%add_spring(joint='A', stiffness=10.0_wp, free_angle=-angle, name='about')
      faulty = builder
      call builder%show_springs(['about  ', 'between'])
      call builder%complete(mechanism, at, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      allocate (lambda(mechanism%c), values(mechanism%n_outputs), source=0.0_wp)
      call mechanism%outputs(at, lambda, values)
      k = mechanism%n_outputs - 4
      do i = 1, 4
         call check(failure, mechanism%output_name(k + i) == names(i), 'a name: '//trim(mechanism%output_name(k + i)))
      end do
      call check_close(failure, values(k + 1), 10.0_wp*angle, 1.0e-14_wp, 'moment')
      call check_close(failure, values(k + 2), 0.0_wp, 1.0e-14_wp, 'angle')
      call check_close(failure, values(k + 3), 1.0_wp + 100.0_wp*(far - 2.0_wp) + 5.0_wp*fast, 1.0e-13_wp, 'force')
      call check_close(failure, values(k + 4), far, 1.0e-14_wp, 'length')
      associate (bob => mechanism%bodies(max(1, mechanism%body_index('bob'))))
         call check(failure, trim(bob%name) == 'bob' .and. at%v(bob%before_v + 2) > 0.0_wp, 'the velocities of bob')
      end associate
      call check(failure, mechanism%body_index('bod') == 0, 'no such body')
      call faulty%show_springs(['betwen'])
      call check(failure, allocated(faulty%error), 'no such spring')
      if (allocated(failure)) return
      call check(failure, index(faulty%error%line(), 'did you mean "between"') > 0, faulty%error%line())
      deallocate (faulty%error)
      call faulty%add_spring(joint='A', stiffness=1.0_wp, name='upper')
      call faulty%show_springs()
      call check(failure, allocated(faulty%error), 'a body has the name')
      deallocate (faulty%error)
      call faulty%add_spring(joint='A', stiffness=1.0_wp, name='about')
      call faulty%show_springs(['about'])
      call check(failure, allocated(faulty%error), 'two of one name')
   end subroutine spring_columns

   !> Moments of inertia along and across a line from end to end that is askew, and in the plane; a size that belongs to another
   !! axis.
   subroutine shapes_by_ends(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp), parameter :: from(3) = [0.3_wp, -0.2_wp, 0.1_wp], along(3) = [1.0_wp, 2.0_wp, -2.0_wp]/3.0_wp, l = 3.0_wp, &
                             r = 0.25_wp, m = 1.2_wp
      character(len=8), parameter :: shapes(4) = [character(len=8) :: 'rod', 'box', 'sphere', 'cylinder']
      real(wp), parameter :: by_axis(4) = m*[0.5_wp**2/6.0_wp, 0.5_wp**2/6.0_wp, 0.1_wp*l*l, 0.5_wp*r*r], &
                             across(4) = m*[(l*l + 0.5_wp**2)/12.0_wp, (l*l + 0.5_wp**2)/12.0_wp, 0.1_wp*l*l, &
                                            (l*l + 3.0_wp*r*r)/12.0_wp]
      integer :: i, k

      do k = 1, 2
         call start(k == 2)
         call builder%add_body('rod', mass=m, shape='rod', thickness=0.5_wp, from=from_of(k), to=to_of(k))
         call builder%add_body('box', mass=m, shape='box', size=[l, 0.5_wp, 0.5_wp], from=from_of(k), to=to_of(k))
         call builder%add_body('sphere', mass=m, shape='sphere', from=from_of(k), to=to_of(k))
         call builder%add_body('cylinder', mass=m, shape='cylinder', radius=r, from=from_of(k), to=to_of(k))
         call builder%complete(mechanism, at, error)
         call no_error(failure, error)
         if (allocated(failure)) return
         do i = 1, 4
            associate (body => mechanism%bodies(i))
               call check_close(failure, body%j(3, 3), across(i), 1.0e-14_wp, shapes(i)//' across')
               if (k == 1) call check_close(failure, body%j(1, 1), by_axis(i), 1.0e-14_wp, shapes(i)//' along')
               if (k == 1) call check_close(failure, norm2(rotate(body%orientation, [1.0_wp, 0.0_wp, 0.0_wp]) - along), 0.0_wp, &
                                            1.0e-14_wp, shapes(i))
            end associate
         end do
      end do

      call start(.false.)
      call builder%add_body('can', mass=m, shape='cylinder', radius=r, length=l)
      call builder%complete(mechanism, at, error)
      call no_error(failure, error)
      if (allocated(failure)) return
      call check_close(failure, mechanism%bodies(1)%j(3, 3), by_axis(4), 1.0e-14_wp, 'without ends along axis 3')
      call builder%add_body('b', mass=m, shape='box', size=[0.5_wp, 0.5_wp, l], from=from_of(1), to=to_of(1))
      call builder%complete(mechanism, at, error)
      call check(failure, allocated(error), 'a box across its ends')
      if (allocated(failure)) return
      call check(failure, index(error%line(), 'body "b": its size along from, to is 0.5000 m, but they are 3.0000 m') == 1, &
                 error%line())

   contains

      subroutine start(planar)
         logical, intent(in) :: planar
         type(mechanism_builder_t) :: empty

         builder = empty
         builder%planar = planar
      end subroutine start

      function from_of(case) result(point)
         integer, intent(in) :: case
         real(wp) :: point(3)

         point = from
         if (case == 2) point(3) = 0.0_wp
      end function from_of

      function to_of(case) result(point)
         integer, intent(in) :: case
         real(wp) :: point(3)

         point = from + l*along
         if (case == 2) point = [from(1) + 0.6_wp*l, from(2) - 0.8_wp*l, 0.0_wp]
      end function to_of

   end subroutine shapes_by_ends

   subroutine faults(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder
      type(mechanism_t) :: mechanism
      type(state_t) :: at
      type(error_t), allocatable :: error

      call build(builder)
      call builder%add_joint('C', 'revolute', 'upper', 'louver', point=o, axis=[0.0_wp, 1.0_wp, 0.0_wp])
      call builder%add_joint('A', 'welded', 'upper', 'lower')
      call builder%complete(mechanism, at, error)
      call check(failure, allocated(error), 'it is told')
      if (allocated(failure)) return
      call check(failure, index(error%line(), 'joint "C": body_2 = "louver"') == 1, 'the first one: '//error%line())
      call check(failure, index(error%remedy, 'did you mean "lower"?') == 1, 'the nearest name: '//error%remedy)
      deallocate (error, builder%error)
      call builder%add_joint('A', 'spherical', 'upper', 'lower', point=o)
      call builder%complete(mechanism, at, error)
      call check(failure, index(error%line(), 'joint "A": the name is taken') == 1, error%line())
      deallocate (error, builder%error)
      call builder%add_body('x', mass=1.0_wp)
      call builder%complete(mechanism, at, error)
      call check(failure, index(error%line(), 'body "x": it has neither inertia nor shape') == 1, error%line())
   end subroutine faults

   subroutine out_of_plane(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder

      builder%planar = .true.
      call builder%add_body('a', mass=1.0_wp, inertia=[0.1_wp])
      call builder%add_load('a', [1.0_wp, 1.0_wp, 0.0_wp])
      call builder%add_load('a', [0.0_wp, 0.0_wp, 1.0_wp], moment=.true.)
      call check(failure, .not. allocated(builder%error), 'what stays in it is taken')
      call builder%add_load('a', [1.0_wp, 1.0_wp, 1.0e-9_wp], 'f')
      call check(failure, index(told(builder), 'force "f": it leaves the plane') == 1, 'a force: '//told(builder))
      if (allocated(builder%error)) deallocate (builder%error)
      call builder%add_load('a', [1.0e-9_wp, 0.0_wp, 1.0_wp], 'm', moment=.true.)
      call check(failure, index(told(builder), 'moment "m": it leaves the plane') == 1, 'a moment: '//told(builder))
   end subroutine out_of_plane

   subroutine faulty_events(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder

      call build(builder)
      call builder%add_event('low', 'angle', 0.5_wp, joint='A')
      call builder%add_event('high', 'angle', -0.5_wp, joint='A')
      call check(failure, .not. allocated(builder%error), 'two of them')
      call builder%add_event('low', 'angle', 0.1_wp, joint='B')
      call check(failure, index(told(builder), 'event "low": the name is taken') == 1, told(builder))
      if (allocated(builder%error)) deallocate (builder%error)
      call builder%add_event('never', 'angle', ieee_value(1.0_wp, ieee_positive_inf), joint='A')
      call check(failure, index(told(builder), 'event "never": its value is not a number') == 1, told(builder))
   end subroutine faulty_events

   subroutine noted(failure)
      character(:), allocatable, intent(inout) :: failure
      type(mechanism_builder_t) :: builder

      call build(builder)
      call builder%add_joint('far', 'spherical', 'upper', 'lower', point=[19.0_wp, 0.0_wp, 0.0_wp])
      call builder%add_joint('free', 'prismatic', 'upper', 'lower', point=[1.0e3_wp, 0.0_wp, 0.0_wp], &
                             axis=[1.0_wp, 0.0_wp, 0.0_wp])
      call builder%add_body('turned', mass=1.0_wp, inertia=[1.0_wp, 1.0_wp, 1.0_wp], angle=-6.28_wp)
      call builder%add_load('upper', [0.0_wp, 1.0_wp, 0.0_wp], point=[19.0_wp, 0.0_wp, 0.0_wp], name='near')
      call check(failure, .not. (allocated(builder%notes) .or. allocated(builder%error)), 'nothing yet')
      call builder%add_body('more', mass=1.0_wp, inertia=[1.0_wp, 1.0_wp, 1.0_wp], angle=-6.29_wp)
      call builder%add_joint('farther', 'spherical', 'upper', 'more', point=[20.6_wp, 0.0_wp, 0.0_wp])
      call check(failure, .not. allocated(builder%error), 'it is taken: '//told(builder))
      if (.not. allocated(failure)) call check(failure, allocated(builder%notes), 'something')
      if (allocated(failure)) return
      call check(failure, size(builder%notes) == 2, 'an angle, a joint far off one of its bodies')
      call builder%add_load('upper', [0.0_wp, 1.0_wp, 0.0_wp], point=[20.6_wp, 0.0_wp, 0.0_wp], name='pull')
      call builder%add_load('upper', [0.0_wp, 0.0_wp, 1.0_wp], point=[20.6_wp, 0.0_wp, 0.0_wp], moment=.true.)
      call builder%add_spring(body_1='upper', body_2='lower', point_1=[0.6_wp, 0.0_wp, 0.0_wp], &
                              point_2=[0.0_wp, 40.0_wp, 0.0_wp], stiffness=1.0_wp, name='wire')
      call builder%add_point('sensor', 'upper', [20.6_wp, 0.0_wp, 0.0_wp])
      call check(failure, .not. allocated(builder%error), 'they are taken: '//told(builder))
      call check(failure, size(builder%notes) == 5, 'a force, a spring and a sensor: '//to_text(size(builder%notes)))
      if (allocated(failure)) return
      call check(failure, index(builder%notes(1)%line(), 'body "more": angle = -6.2900') == 1, builder%notes(1)%line())
      call check(failure, index(builder%notes(2)%line(), &
                                'joint "farther": its point is 20.1000 m from the center of "upper"') == 1, builder%notes(2)%line())
      call check(failure, index(builder%notes(3)%line(), 'force "pull": its point is 20.1000 m') == 1, builder%notes(3)%line())
      call check(failure, index(builder%notes(4)%line(), 'spring "wire": its second point is') == 1, builder%notes(4)%line())
      call check(failure, index(builder%notes(5)%line(), 'point "sensor": it is 20.1000 m') == 1, builder%notes(5)%line())
   end subroutine noted

   !> What a builder complains of.
   function told(builder) result(line)
      type(mechanism_builder_t), intent(in) :: builder
      character(:), allocatable :: line

      line = ''
      if (allocated(builder%error)) line = builder%error%line()
   end function told

end module test_builder
