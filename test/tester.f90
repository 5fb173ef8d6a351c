!> Runs every test, or those whose name contains the first argument.
program tester
   use, intrinsic :: iso_fortran_env, only: output_unit
   use testing, only: outcome_t, run_suite
   use test_allocation, only: collect_allocation
   use test_assembly, only: collect_assembly
   use test_automatic, only: collect_automatic
   use test_builder, only: collect_builder
   use test_bushing, only: collect_bushing
   use test_balance, only: collect_balance
   use test_completion, only: collect_completion
   use test_doubt, only: collect_doubt
   use test_blow, only: collect_blow
   use test_case, only: collect_case
   use test_chain, only: collect_chain
   use test_linalg, only: collect_linalg
   use test_lu, only: collect_lu
   use test_constrained, only: collect_constrained
   use test_helicopter, only: collect_helicopter
   use test_extremes, only: collect_extremes
   use test_faults, only: collect_faults
   use test_first_look, only: collect_first_look
   use test_discrete_derivative, only: collect_discrete_derivative
   use test_energy_preserving, only: collect_energy_preserving
   use test_generalized_alpha, only: collect_generalized_alpha
   use test_history, only: collect_history
   use test_jet, only: collect_jet
   use test_kinds, only: collect_kinds
   use test_helicopter_motion, only: collect_helicopter_motion
   use test_pendulum, only: collect_pendulum
   use test_ode, only: collect_ode
   use test_ode_edges, only: collect_ode_edges
   use test_explicit_pair, only: collect_explicit_pair
   use test_stepper, only: collect_stepper
   use test_dop853, only: collect_dop853
   use test_problem, only: collect_problem
   use test_projection_check, only: collect_projection_check
   use test_projection_matrices, only: collect_projection_matrices
   use test_settings, only: collect_settings
   use test_structure, only: collect_structure
   use test_methods, only: collect_methods
   use test_mechanism, only: collect_mechanism
   use test_mechanism_drives, only: collect_mechanism_drives
   use test_mechanism_equivalents, only: collect_mechanism_equivalents
   use test_mechanism_motion, only: collect_mechanism_motion
   use test_mechanism_redundancy, only: collect_mechanism_redundancy
   use test_modal_body, only: collect_modal_body
   use test_model_events, only: collect_model_events
   use test_radau, only: collect_radau
   use test_read_mechanism, only: collect_read_mechanism
   use test_restart, only: collect_restart
   use test_reduced, only: collect_reduced
   use test_rank, only: collect_rank, collect_rank_study
   use test_reactions, only: collect_reactions
   use test_ritz, only: collect_ritz
   use test_rigid_bodies, only: collect_rigid_bodies
   use test_squeezer, only: collect_squeezer
   use test_large_statics, only: collect_large_statics
   use test_statics, only: collect_statics
   use test_swing, only: collect_swing
   use test_system, only: collect_system
   use test_turns, only: collect_turns
   use test_units, only: collect_units
   use test_variants, only: collect_variants
   use test_textbook, only: collect_textbook
   use test_verify, only: collect_verify
   use test_welds, only: collect_welds
   use test_normal_solver, only: collect_normal_solver
   use test_rotation, only: collect_rotation
   use test_beam, only: collect_beam
   use test_beam_element, only: collect_beam_element
   use test_beam_section, only: collect_beam_section
   use test_nodes, only: collect_nodes
   use test_number, only: collect_number
   use test_entries, only: collect_entries
   use test_equilibrium, only: collect_equilibrium
   use test_modes, only: collect_modes
   use test_n_four_bar, only: collect_n_four_bar
   use test_near, only: collect_near
   implicit none (type, external)
   type(outcome_t) :: outcome
   character(len=100) :: only

   only = ''
   if (command_argument_count() > 0) call get_command_argument(1, only)
   call run_suite('kinds', collect_kinds(), trim(only), outcome)
   call run_suite('linalg', collect_linalg(), trim(only), outcome)
   call run_suite('lu', collect_lu(), trim(only), outcome)
   call run_suite('weighted projection', collect_normal_solver(), trim(only), outcome)
   call run_suite('structure', collect_structure(), trim(only), outcome)
   call run_suite('chain', collect_chain(), trim(only), outcome)
   call run_suite('N-four-bar', collect_n_four_bar(), trim(only), outcome)
   call run_suite('projection matrices', collect_projection_matrices(), trim(only), outcome)
   call run_suite('ode', collect_ode(), trim(only), outcome)
   call run_suite('explicit pair', collect_explicit_pair(), trim(only), outcome)
   call run_suite('stepper', collect_stepper(), trim(only), outcome)
   call run_suite('dop853', collect_dop853(), trim(only), outcome)
   call run_suite('projection check', collect_projection_check(), trim(only), outcome)
   call run_suite('ode edges', collect_ode_edges(), trim(only), outcome)
   call run_suite('pendulum', collect_pendulum(), trim(only), outcome)
   call run_suite('helicopter', collect_helicopter(), trim(only), outcome)
   call run_suite('helicopter motion', collect_helicopter_motion(), trim(only), outcome)
   call run_suite('system', collect_system(), trim(only), outcome)
   call run_suite('balance', collect_balance(), trim(only), outcome)
   call run_suite('completion', collect_completion(), trim(only), outcome)
   call run_suite('doubt', collect_doubt(), trim(only), outcome)
   call run_suite('blow', collect_blow(), trim(only), outcome)
   call run_suite('constrained', collect_constrained(), trim(only), outcome)
   call run_suite('problem', collect_problem(), trim(only), outcome)
   call run_suite('history', collect_history(), trim(only), outcome)
   call run_suite('methods', collect_methods(), trim(only), outcome)
   call run_suite('jet', collect_jet(), trim(only), outcome)
   call run_suite('automatic', collect_automatic(), trim(only), outcome)
   call run_suite('allocation', collect_allocation(), trim(only), outcome)
   call run_suite('modal body', collect_modal_body(), trim(only), outcome)
   call run_suite('model events', collect_model_events(), trim(only), outcome)
   call run_suite('radau', collect_radau(), trim(only), outcome)
   call run_suite('discrete derivative', collect_discrete_derivative(), trim(only), outcome)
   call run_suite('energy-preserving', collect_energy_preserving(), trim(only), outcome)
   call run_suite('generalized-alpha', collect_generalized_alpha(), trim(only), outcome)
   call run_suite('builder', collect_builder(), trim(only), outcome)
   call run_suite('bushing', collect_bushing(), trim(only), outcome)
   call run_suite('read mechanism', collect_read_mechanism(), trim(only), outcome)
   call run_suite('restart', collect_restart(), trim(only), outcome)
   call run_suite('rank', collect_rank(), trim(only), outcome)
   call run_suite('reactions', collect_reactions(), trim(only), outcome)
   call run_suite('ritz', collect_ritz(), trim(only), outcome)
   call run_suite('rigid bodies', collect_rigid_bodies(), trim(only), outcome)
   call run_suite('squeezer', collect_squeezer(), trim(only), outcome)
   call run_suite('swing', collect_swing(), trim(only), outcome)
   call run_suite('textbook', collect_textbook(), trim(only), outcome)
   call run_suite('verify', collect_verify(), trim(only), outcome)
   call run_suite('welds', collect_welds(), trim(only), outcome)
   call run_suite('faults', collect_faults(), trim(only), outcome)
   call run_suite('case', collect_case(), trim(only), outcome)
   call run_suite('extremes', collect_extremes(), trim(only), outcome)
   call run_suite('numbers as text', collect_number(), trim(only), outcome)
   call run_suite('lists of runs', collect_variants(), trim(only), outcome)
   call run_suite('entries', collect_entries(), trim(only), outcome)
   call run_suite('settings', collect_settings(), trim(only), outcome)
   call run_suite('rotation', collect_rotation(), trim(only), outcome)
   call run_suite('beam section', collect_beam_section(), trim(only), outcome)
   call run_suite('beam element', collect_beam_element(), trim(only), outcome)
   call run_suite('nodes', collect_nodes(), trim(only), outcome)
   call run_suite('beam', collect_beam(), trim(only), outcome)
   call run_suite('equilibrium', collect_equilibrium(), trim(only), outcome)
   call run_suite('modes', collect_modes(), trim(only), outcome)
   call run_suite('near', collect_near(), trim(only), outcome)
   call run_suite('first look', collect_first_look(), trim(only), outcome)
   call run_suite('statics', collect_statics(), trim(only), outcome)
   call run_suite('large statics', collect_large_statics(), trim(only), outcome)
   call run_suite('turns', collect_turns(), trim(only), outcome)
   call run_suite('units', collect_units(), trim(only), outcome)
   call run_suite('assembly', collect_assembly(), trim(only), outcome)
   call run_suite('mechanism', collect_mechanism(), trim(only), outcome)
   call run_suite('mechanism motion', collect_mechanism_motion(), trim(only), outcome)
   call run_suite('mechanism drives', collect_mechanism_drives(), trim(only), outcome)
   call run_suite('mechanism equivalents', collect_mechanism_equivalents(), trim(only), outcome)
   call run_suite('reduced', collect_reduced(), trim(only), outcome)
   call run_suite('mechanism redundancy', collect_mechanism_redundancy(), trim(only), outcome)
   ! Slow ones, run by name.
   if (only == 'rank study') call run_suite('rank study', collect_rank_study(), trim(only), outcome)
   write (output_unit, '(i0, a, i0, a)') outcome%passed, ' passed, ', outcome%failed, ' failed'
   if (outcome%failed > 0) stop 1, quiet=.true.
end program tester
