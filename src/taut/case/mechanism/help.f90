!> The groups of a mechanism's case file, in words.
module taut_case_mechanism_help
   implicit none (type, external)
   private
   public :: case_help

   character, parameter :: nl = new_line('a')

contains

   !> The text of `--help-case`.
   function case_help() result(text)
      !> Many lines.
      character(:), allocatable :: text

      text = ''
      text = text//'Groups of a mechanism''s case file (units: m, kg, s, N, rad; what is in brackets is the default). '// &
             'Names are made of letters,'//nl
      text = text//'digits, - and _; the ground is called "ground". Vectors have three numbers; missing ones are zero.'//nl
      text = text//nl
      text = text//'&mechanism   planar (.false.): every body moves in the plane x-y; hold: coordinates that the '// &
             'assembly keeps, and their'//nl
      text = text//'             velocities too, such as "crank", "rod.x", "rod.angle" (plane), "rod.orientation" (space)'//nl
      text = text//'&gravity     acceleration (0, 0, -9.81; in the plane 0, -9.81); without the group there is none'//nl
      text = text//'&body        name, mass; position of the center of mass (0, 0, 0); one of angle (about z), '// &
             'orientation (rotation vector),'//nl
      text = text//'             quaternion (scalar part first), or from and to: ends that give position, axis 1 along '// &
             'them, and length;'//nl
      text = text//'             inertia about the center of mass in body axes: xx, yy, zz, xy, xz, yz (in the plane: '// &
             'the one about z), or'//nl
      text = text//'             shape = "rod" (length or from, to; thickness of its square section (length/1000)), '// &
             '"box" (size: three sides),'//nl
      text = text//'             "sphere" (radius), "cylinder" (radius; length along body axis z); velocity (0), '// &
             'angular_velocity (0), both in'//nl
      text = text//'             global axes, angle_rate (0) about z; position_step, from_step, to_step, angle_step'//nl
      text = text//'&point_mass  name, mass, position, velocity, position_step'//nl
      text = text//'&ground_point  name, position, position_step'//nl
      text = text//'&point       name, body, position, frame: a point of a body, written out; position_step'//nl
      text = text//'&joint       name, type, body_1 ("ground"), body_2: bodies, point masses, points or "ground"; '// &
             'point: shared, or point_1 and'//nl
      text = text//'             point_2 (a side without one takes the other''s; a distance, a coordinate: the center of '// &
             'mass); axis, or axis_1'//nl
      text = text//'             and axis_2 (of a universal joint: at right angles);'//nl
      text = text//'             frame ("global": at the start; "body": point_1, point_2, axis_1, axis_2 in body axes); '// &
             'drive, drive_angle: names'//nl
      text = text//'             of functions; point_step. Types and their rows in space and plane:'//nl
      text = text//'               spherical 3, 2   revolute (axis) 5, 2; angle at the start (0), drive_angle   fixed 6, 3'//nl
      text = text//'               prismatic (axis) 5, 2; drive   cylindrical (axis) 4, -; drive, drive_angle   '// &
             'universal (axis_1, axis_2) 4, -'//nl
      text = text//'               planar (axis: its normal) 3, -   in-line (axis: point of body 2 on a line of body 1) 2, 1'//nl
      text = text//'               distance 1, 1; length (that at the start), drive   coordinate (axis) 1, 1; value '// &
             '(that at the start), drive'//nl
      text = text//'&rolling     name, body, radius, axis of the disc, center (center of mass), normal (0, 0, 1) and '// &
             'plane_point (0, 0, 0)'//nl
      text = text//'&knife_edge  name, body, point, across: the point does not move in this direction, which turns with '// &
             'the body'//nl
      text = text//'&function    name, kind ("constant"): constant: offset (0); ramp: offset + rate (t - start), start '// &
             '(0), finish (never); sine and'//nl
      text = text//'             cosine: offset + amplitude (1) sin(omega t + phase), omega or frequency [Hz], phase '// &
             '(0); step: offset to offset +'//nl
      text = text//'             amplitude from start (0) to finish (start: a jump, for loads only), two smooth '// &
             'derivatives; polynomial: offset +'//nl
      text = text//'             sum of coefficients(k) t^k, up to 20; table: cubic spline through a CSV file, table = '// &
             '"FILE.csv" (path from the'//nl
      text = text//'             folder of the case file) with rows time,value; it must reach from t_start to t_end'//nl
      text = text//'&force       name, body, value, point (center of mass), follow (.false.: keeps its direction; '// &
             '.true.: turns with the body),'//nl
      text = text//'             function: name of a factor'//nl
      text = text//'&moment      the same with value in N m'//nl
      text = text//'&spring      name, body_1 ("ground"), point_1, body_2, point_2 (centers of mass), frame ("global"), '// &
             'or joint: about the axis of'//nl
      text = text//'             a revolute or cylindrical one, within half a turn of free_angle; stiffness (0; a '// &
             'negative one drives away from'//nl
      text = text//'             the free length), damping (0; not negative), free_length or free_angle (that at the '// &
             'start), preload (0; tension'//nl
      text = text//'             is positive)'//nl
      text = text//'&damper      the same'//nl
      text = text//'&beam        name, from, to, elements (4), young [Pa], poisson (0.3), density, thickness (along '// &
             'axis_2), width, axis_2 (0, 1, 0),'//nl
      text = text//'             damping (0) [s]: a beam whose nodes are the bodies name1, name2, ...; in space only'//nl
      text = text//'&event       name, joint, quantity ("angle", "displacement"), value; or point and quantity "x", '// &
             '"y", "z"; an angle also passes'//nl
      text = text//'             half a turn away'//nl
      text = text//'&analysis    kind ("dynamics"; "equilibrium"; "modes" about the equilibrium, of the mechanism '// &
             'without damping), steps (1) of'//nl
      text = text//'             the equilibrium''s load, number (10) of modes'//nl
      text = text//'&output      dt [s] (0: every step), joints ("all"; "none"; names): whose reactions are written'//nl
      text = text//'&integration, &method  as in all apps; the default weight is "mass"'//nl
      text = text//nl
      text = text//'Copies: repeat (1) makes as many of a &body, &point_mass, &ground_point, &point, &joint, &force, '// &
             '&moment, &spring or &damper; # in a'//nl
      text = text//'name stands for the number of the copy, from first (1) on, #-1 for the one before, #+1 for the '// &
             'next; the steps are added from'//nl
      text = text//'copy to copy.'
   end function case_help

end module taut_case_mechanism_help
