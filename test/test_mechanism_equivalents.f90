!> Mechanisms that are described in two ways, or by another model: one motion.
module test_mechanism_equivalents
   use taut, only: error_t, integration_options_t, integration_result_t, simulate, state_t, wp
   use taut_model_rigid_bodies, only: new_rigid_bodies, rigid_bodies_t, rigid_body_t, spherical_joint_t
   use taut_model_swing, only: new_swing_beam, swing_beam_t, swing_data_t
   use test_case, only: lf
   use testing, only: check, check_below, check_close, new_test, no_error, test_t
   use mechanism_runs, only: entry_of, output, run_file, run_t, run_text
   implicit none (type, external)
   private
   public :: collect_mechanism_equivalents

contains

   !> All tests of this module.
   function collect_mechanism_equivalents() result(tests)
      type(test_t), allocatable :: tests(:)

      tests = [new_test('heavy top against another model', heavy_top), &
               new_test('plane and space give one motion', planar_and_spatial), &
               new_test('a distance is a massless rod', distance_and_rod), &
               new_test('equal orientations give one motion', equal_orientations), &
               new_test('a swing of beam elements against the swing', swing)]
   end function collect_mechanism_equivalents

   !> The same top as a rigid body of Sect. 3.4.1.
   subroutine heavy_top(failure)
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: run
      type(rigid_bodies_t) :: other
      type(rigid_body_t) :: body
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error

      call run_file('heavy_top', 0.5_wp, 1.0e-10_wp, run, failure)
      if (allocated(failure)) return
      ! About its tip, which stays at the origin.
      body%m = 15.0_wp
      body%s = [0.0_wp, 15.0_wp, 0.0_wp]
      body%j(1, 1) = 15.234375_wp
      body%j(2, 2) = 0.46875_wp
      body%j(3, 3) = 15.234375_wp
      call new_rigid_bodies(other, [body], [spherical_joint_t(1, 0)], [0.0_wp, 0.0_wp, -9.81_wp], error)
      at%x = [0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      at%v = [0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 150.0_wp, -4.61538_wp]
      options%rtol = 1.0e-10_wp
      options%atol = 1.0e-10_wp
      call simulate(other, at, 0.5_wp, result, error, options=options)
      call no_error(failure, error)
      call check_below(failure, maxval(abs(run%at%x(4:7) - at%x(4:7))), 1.0e-6_wp, 'orientation')
      call check_below(failure, maxval(abs(run%at%v(4:6) - at%v(4:6))), 1.0e-5_wp, 'angular velocity')
   end subroutine heavy_top

   !> The chain of a case, in the plane and in space.
   subroutine planar_and_spatial(failure)
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: plane, space
      character(*), parameter :: bodies = '&body name = "a", shape = "box", size = 1.0, 0.1, 0.2, mass = 2.0, angle = 0.3, '// &
                                 'position = 0.5, 0.1, 0.0, angle_rate = 1.0 /'//lf// &
                                 '&body name = "b", shape = "box", size = 0.7, 0.1, 0.2, mass = 1.0, angle = -0.4, '// &
                                 'position = 1.2, 0.3, 0.0 /'//lf//'&gravity acceleration = 0.0, -9.81, 0.0 /'//lf// &
                                 '&joint name = "j1", type = "revolute", body_2 = "a", point = 3*0.0, axis = 0.0, 0.0, '// &
                                          '1.0 /'//lf// &
                                 '&joint name = "j2", type = "prismatic", body_1 = "a", body_2 = "b", '// &
                                 'point = 1.0, 0.2, 0.0, axis = 1.0, 0.5, 0.0 /'//lf// &
                                 '&spring name = "s", body_1 = "a", body_2 = "b", stiffness = 50.0 /'//lf// &
                                 '&spring name = "t", joint = "j1", stiffness = 3.0, damping = 0.1, free_angle = 0.5 /'//lf// &
                                 '&force name = "f", body = "b", value = 1.0, 0.5, 0.0, point = 1.3, 0.1, 0.0, '// &
                                 'follow = .true. /'//lf

      call run_text(bodies//'&mechanism planar = .true. /', 1.0_wp, 1.0e-10_wp, plane, failure)
      if (allocated(failure)) return
      call run_text(bodies, 1.0_wp, 1.0e-10_wp, space, failure)
      if (allocated(failure)) return
      call check(failure, plane%model%n == 6 .and. space%model%n == 12, 'three and six velocities each')
      call check_close(failure, entry_of(plane, plane%at, 'b.x'), entry_of(space, space%at, 'b.x'), 1.0e-7_wp, 'x')
      call check_close(failure, entry_of(plane, plane%at, 'b.y'), entry_of(space, space%at, 'b.y'), 1.0e-7_wp, 'y')
      call check_close(failure, entry_of(plane, plane%at, 'b.wz'), entry_of(space, space%at, 'b.wz'), 1.0e-7_wp, 'w')
      call check_close(failure, output(plane, plane%at, 'j2.fx'), output(space, space%at, 'j2.fx'), 1.0e-6_wp, 'reaction')
      call check_close(failure, output(plane, plane%at, 'j2.mz'), output(space, space%at, 'j2.mz'), 1.0e-6_wp, 'moment')
   end subroutine planar_and_spatial

   subroutine distance_and_rod(failure)
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: distance, rod
      character(*), parameter :: mass = '&gravity /'//lf//'&point_mass name = "m", mass = 1.5, position = 0.6, 0.0, -0.8, '// &
                                 'velocity = 0.0, 2.0, 0.0 /'//lf

      call run_text(mass//'&joint name = "d", type = "distance", body_2 = "m", point_1 = 0.0, 0.0, 0.0 /', 2.0_wp, 1.0e-10_wp, &
                    distance, failure)
      if (allocated(failure)) return
      call run_text(mass//'&body name = "rod", shape = "rod", thickness = 0.5, mass = 1e-5, from = 0.0, 0.0, 0.0, to = '// &
               '0.6, 0.0, -0.8, '// &
                    'velocity = 0.0, 1.0, 0.0, angular_velocity = 1.6, 0.0, 1.2 /'//lf// &
                    '&joint name = "s1", type = "spherical", body_2 = "rod", point = 0.0, 0.0, 0.0 /'//lf// &
                    '&joint name = "s2", type = "spherical", body_1 = "rod", body_2 = "m" /', 2.0_wp, 1.0e-10_wp, rod, failure)
      if (allocated(failure)) return
      call check_below(failure, maxval(abs(distance%at%x(1:3) - rod%at%x(1:3))), 2.0e-5_wp, 'position')
      call check_below(failure, maxval(abs(distance%at%v(1:3) - rod%at%v(1:3))), 2.0e-5_wp, 'velocity')
   end subroutine distance_and_rod

   subroutine equal_orientations(failure)
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: one, other
      character(*), parameter :: before = '&gravity /'//lf//'&body name = "b", mass = 1.0, inertia = 0.3, 0.4, 0.5, 0.05, '// &
               '0.02, 0.01, '// &
                                 'position = 0.5, 0.2, 0.1, angular_velocity = 1.0, 2.0, 3.0, ', after = ' /'//lf// &
                                 '&joint name = "j", type = "universal", body_2 = "b", point = 0.0, 0.0, 0.0, '// &
                                 'axis_1 = 1.0, 0.0, 0.0, axis_2 = 0.0, 1.0, 0.0 /'

      call run_text(before//'quaternion = 0.5, 0.5, 0.5, 0.5'//after, 1.0_wp, 1.0e-10_wp, one, failure)
      if (allocated(failure)) return
      call run_text(before//'quaternion = -1.0, -1.0, -1.0, -1.0'//after, 1.0_wp, 1.0e-10_wp, other, failure)
      if (allocated(failure)) return
      call check_below(failure, maxval(abs(one%at%x(1:3) - other%at%x(1:3))), 1.0e-8_wp, 'position')
      call check_below(failure, maxval(abs(one%at%v - other%at%v)), 1.0e-7_wp, 'velocity')
      ! A third of a turn about (1, 1, 1).
      call run_text(before//'orientation = 1.2091995761561452, 1.2091995761561452, 1.2091995761561452'//after, 1.0_wp, 1.0e-10_wp, &
                    other, failure)
      if (allocated(failure)) return
      call check_below(failure, maxval(abs(one%at%v - other%at%v)), 1.0e-7_wp, 'velocity from a rotation vector')
   end subroutine equal_orientations

   !> The paper's swing, its mass on the node and not beside it, its load by functions.
   subroutine swing(failure)
      character(:), allocatable, intent(inout) :: failure
      type(run_t) :: run
      type(swing_beam_t) :: other
      type(integration_options_t) :: options
      type(integration_result_t) :: result
      type(state_t) :: at
      type(error_t), allocatable :: error
      real(wp), parameter :: t_end = 0.01_wp

      call run_file('swing', t_end, 1.0e-6_wp, run, failure)
      if (allocated(failure)) return
      call new_swing_beam(other, swing_data_t(), error)
      call no_error(failure, error)
      at = other%reference_state()
      options%rtol = 1.0e-6_wp
      options%atol = 1.0e-6_wp
      call simulate(other, at, t_end, result, error, options=options)
      call no_error(failure, error)
      if (allocated(failure)) return
      call check(failure, maxval(abs(at%v)) > 1.0e-3_wp, 'it moves')
      call check_below(failure, maxval(abs(run%at%x(:35) - at%x)), 1.0e-6_wp, 'positions of the nodes')
      call check_below(failure, maxval(abs([entry_of(run, run%at, 'middle.vx') - at%v(13)])), 1.0e-4_wp, 'velocity of the middle')
   end subroutine swing

end module test_mechanism_equivalents
