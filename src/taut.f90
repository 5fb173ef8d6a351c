!> taut adds kinematic constraints to mechanical systems written as ordinary differential equations.
!!
!! A system is an extension of `mechanical_system_t`: it states its sizes with `define` and supplies M (`mass`),
!! f (`force`), phi (`constraint`), A (`jacobian`) and b'' (`acceleration_rhs`). Then
!!
!!     type(state_t) :: at
!!     type(integration_result_t) :: result
!!     type(error_t), allocatable :: error
!!     at%x = [1.0_wp, 0.0_wp]
!!     at%v = [0.0_wp, 0.0_wp]
!!     call simulate(system, at, 10.0_wp, result, error)
!!
!! brings the initial state to the constraints and integrates to t = 10 s with positions and velocities that comply to
!! 1e-12. Options: `method_t`, `integration_options_t`; output: `trajectory_t` or an observer of one's own; `verify`
!! checks a system's derivatives.
module taut
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   use taut_jet, only: jet_t, jet, operator(+), operator(-), operator(*), operator(/), operator(**), assignment(=), &
                       operator(==), operator(/=), operator(<), operator(<=), operator(>), operator(>=), &
                       abs, acos, asin, atan, atan2, cos, cosh, exp, hypot, log, max, min, sign, sin, sinh, sqrt, tan, tanh, &
                       distance, dot_product, matmul, norm2, sum, &
                       quaternion_conjugate, quaternion_product, quaternion_rate, rotate, rotate_back
   use taut_error, only: error_t, raise
   use taut_version, only: version
   use taut_case_mechanism, only: read_mechanism
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_pseudo_inverse, only: pseudo_inverse_t, path_name
   use taut_ode_system, only: ode_system_t, rhs_ok, rhs_retry, rhs_failed, rhs_no_projection, rhs_cannot, inside_step, &
                              step_end, evaluated_step_end
   use taut_ode_status, only: status_name, status_reached_end, status_event, status_step_too_small, &
                              status_too_many_steps, status_not_finite, status_rhs_failed, status_projection_failed, &
                              status_output_failed, status_not_started, status_interrupted, status_no_progress
   use taut_ode_note, only: note_t, note_bound_by_stability, note_no_time
   use taut_ode_pause, only: pause_t
   use taut_ode_event, only: events_t, event_record_t
   use taut_ode_observer, only: observer_t, trajectory_t
   use taut_ode_step_control, only: controller_constants_t, step_control_t
   use taut_ode_stepper, only: stepper_t, work_t
   use taut_ode_stepper_choose, only: integrator_names
   use taut_ode_integrate, only: integrator_t
   use taut_ode_options, only: integration_options_t, integration_result_t
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_constrained_system_automatic, only: automatic_system_t, jet_state_t
   use taut_constrained_system_tables, only: name_length, quantity_t, tabulated_system_t
   use taut_constrained_method_options, only: method_t, method_names
   use taut_constrained_projection, only: projector_t
   use taut_constrained_start, only: consistent_start, start_report_t
   use taut_constrained_balance, only: energy_balance_t
   use taut_constrained_method, only: constrained_ode_t, sample_t
   use taut_constrained_method_choose, only: check_method, new_constrained_ode
   use taut_constrained_history, only: history_t
   use taut_constrained_problem, only: constrained_problem_t
   use taut_constrained_projection_matrices, only: projection_matrices
   use taut_constrained_ritz, only: new_ritz, ritz_t
   use taut_constrained_model_events, only: model_events_t
   use taut_constrained_simulate, only: simulate, simulation_t
   use taut_constrained_equilibrium, only: equilibrium, equilibrium_options_t, equilibrium_result_t
   use taut_constrained_modes, only: eigenmodes, modes_options_t, modes_t
   use taut_constrained_verify, only: verify, finding_t
   use taut_model_chain, only: chain_model_t => chain_t, new_chain_model => new_chain
   use taut_model_n_four_bar, only: n_four_bar_model_t => n_four_bar_t, new_n_four_bar_model => new_n_four_bar
   use taut_model_pendulum, only: new_pendulum_model => new_pendulum, pendulum_model_t => pendulum_t
   use taut_model_beam, only: beam_t, new_beam, straight_nodes
   use taut_model_beam_section, only: beam_section_t, new_section, rectangular_section
   use taut_model_mechanism, only: mechanism_t
   use taut_model_mechanism_assembly, only: assemble_mechanism => assemble
   use taut_model_mechanism_body, only: pose_t
   use taut_model_mechanism_builder, only: mechanism_builder_t
   use taut_model_mechanism_function, only: time_function_t
   use taut_model_mechanism_report, only: mechanism_report_t
   use taut_model_modal_body, only: modal_body_t, new_modal_body
   use taut_model_posed_system, only: posed_system_t
   use taut_model_rigid_bodies, only: new_rigid_bodies, rigid_bodies_t, rigid_body_t, spherical_joint_t
   use taut_rotation, only: exp_rotation, log_rotation, matrix_of_quaternion, quaternion_body_rate, quaternion_conjugate, &
                            quaternion_normalized, quaternion_of_axes, quaternion_of_matrix, quaternion_of_vector, &
                            quaternion_product, quaternion_rate, right_tangent, right_tangent_inverse, rotate, rotate_back, skew, &
                            vector_of_quaternion
   implicit none (type, external)
   private
   public :: beam_t, new_beam, straight_nodes, beam_section_t, new_section, rectangular_section
   public :: mechanism_t, mechanism_builder_t, mechanism_report_t, read_mechanism, assemble_mechanism, pose_t, time_function_t
   public :: model_events_t
   public :: posed_system_t, modal_body_t, new_modal_body, new_rigid_bodies, rigid_bodies_t, rigid_body_t, spherical_joint_t
   public :: jet_t, jet, operator(+), operator(-), operator(*), operator(/), operator(**), assignment(=)
   public :: operator(==), operator(/=), operator(<), operator(<=), operator(>), operator(>=)
   public :: abs, acos, asin, atan, atan2, cos, cosh, exp, hypot, log, max, min, sign, sin, sinh, sqrt, tan, tanh
   ! Under names that leave the plain ones to programs of one's own.
   public :: chain_model_t, new_chain_model, n_four_bar_model_t, new_n_four_bar_model, new_pendulum_model, pendulum_model_t
   public :: distance, dot_product, matmul, norm2, sum
   public :: skew, exp_rotation, log_rotation, right_tangent, right_tangent_inverse, rotate, rotate_back
   public :: quaternion_product, quaternion_conjugate, quaternion_rate, quaternion_body_rate, quaternion_normalized
   public :: quaternion_of_vector, vector_of_quaternion, matrix_of_quaternion, quaternion_of_matrix, quaternion_of_axes
   public :: wp, error_t, raise, version
   public :: automatic_system_t, jet_state_t, mechanical_system_t, tabulated_system_t, state_t, quantity_t, name_length
   public :: block_diagonal_t
   public :: new_ritz, ritz_t
   public :: simulation_t, archive_t, pause_t
   public :: simulate, method_t, method_names, integration_options_t, integration_result_t
   public :: history_t, observer_t, trajectory_t, events_t, event_record_t, sample_t, constrained_ode_t, energy_balance_t
   public :: check_method, new_constrained_ode, constrained_problem_t
   public :: consistent_start, start_report_t, verify, finding_t, projection_matrices
   public :: equilibrium, equilibrium_options_t, equilibrium_result_t, eigenmodes, modes_options_t, modes_t
   public :: integrator_names, stepper_t, step_control_t, controller_constants_t, work_t
   public :: ode_system_t, integrator_t, projector_t, pseudo_inverse_t, path_name
   public :: rhs_ok, rhs_retry, rhs_failed, rhs_no_projection, rhs_cannot, inside_step, step_end, evaluated_step_end
   public :: status_name, status_reached_end, status_event, status_step_too_small, status_too_many_steps, &
             status_not_finite, status_rhs_failed, status_projection_failed, status_output_failed, status_not_started, &
             status_interrupted, status_no_progress
   public :: note_t, note_bound_by_stability, note_no_time
end module taut
