"""Component -> effect -> the test that holds a known answer of it: closed form, balance, published number, another solver."""

from __future__ import annotations

HERE = "tests/contract/test_effect_sizes.py::test_"
OWN = "tests/systems/"


def _in(file: str, **tests: str) -> dict[str, str]:
    """Effect -> test, of tests of one file."""
    return {effect: f"{OWN}{file}::test_{test}" for effect, test in tests.items()}


def _here(**tests: str) -> dict[str, str]:
    return {effect: HERE + test for effect, test in tests.items()}


PITS = ("inner_defect", "outer_defect", "ball_defect")
# another implementation of the same equations, one sine and cosine a ball, gaps differentiated numerically
BY_EQUATIONS = ("clearance", "contact_damping", "unbalance", *PITS, "load_variation", "speed_ramp")
GEAR = "wind_pump/test_transmissions.py"
SLIPS = ("smoothed_slip", "lugre_slip", "exact_slip")

KNOWN: dict[str, dict[str, str]] = {
    "Pantograph": {
        **_here(contact_loss="a_wire_that_goes_away_pulls_only_without_contact_loss",
                bump_stops="a_stop_pushes_the_head_back_from_the_end_of_its_travel"),
        **_in("railway/test_pantograph.py", lower_frame="eigenfrequencies_of_the_free_oscillation",
              aerodynamic_uplift="lift_grows_with_the_square_of_the_speed",
              frame_friction="frame_friction_holds_against_a_small_change_of_force",
              base_excitation="transmissibility_of_the_base", outer_contact="outer_contact_gives_the_motion_of_the_inner_one"),
    },
    "Catenary": {
        **_here(steady_arm="a_steady_arm_is_a_spring_beside_the_compliance_of_the_wire"),
        **_in("railway/test_statics.py", dropper_slackening="droppers_let_go_one_after_the_other",
              bending_stiffness="bending_stiffness_lowers_the_compliance_by_the_boundary_layer",
              gravity_sag="sag_between_droppers_is_a_parabola", pre_sag="droppers_carry_the_weight_and_the_pre_sag",
              level_support="level_support_raises_the_wire_to_dropper_level"),
        **_in("railway/test_wires.py", damping="mass_proportional_damping_decays_every_mode_alike"),
        **_in("railway/test_catenary.py", second_pantograph="two_forces_superpose_where_droppers_are_bilateral",
              moving_window="window_follows_the_contact_and_forgets_the_rest",
              wire_profile="profile_is_the_height_at_its_positions"),
    },
    "LumpedCatenary": _in("railway/test_lumped.py", inerter="mass_makes_a_forced_oscillation_that_the_inerter_does_not"),
    "BallBearing": {
        **_in("bearings/test_ball_bearing.py", **dict.fromkeys(BY_EQUATIONS, "the_equations_are_those_of_the_docstring"),
              inner_waviness="waves_of_a_race_shake_the_shaft_at_the_known_lines",
              outer_waviness="waves_of_a_race_shake_the_shaft_at_the_known_lines"),
        "given_start": "tests/systems/bearings/test_ball_bearing.py::test_restitution_of_the_contact_damping",
    },
    "DimensionlessBallBearing": _in(
        "bearings/test_ball_bearing.py",
        **dict.fromkeys((*BY_EQUATIONS, "inner_waviness", "outer_waviness"),
                        "dimensional_and_dimensionless_are_the_same_trajectory"),
        given_start="defaults_of_the_dimensionless_bearing_are_the_scaled_ones"),
    "DeepGrooveBearing": {
        **_in("bearings/test_deep_groove.py", **dict.fromkeys(PITS, "a_defect_is_met_at_its_frequency"),
              film="film_thickness_over_speed_and_what_it_does", inner_waviness="lines_of_waviness",
              outer_waviness="lines_of_waviness", published_levers="published_levers_break_the_symmetry_by_under_one_percent",
              linearisation="linearisation_is_the_tangent_and_its_intercept", friction="friction_turns_power_into_heat",
              thermal_growth="growth_is_a_change_of_the_diametral_clearance"),
        **_in("bearings/test_loads.py", damping="dampers_take_power_and_let_go_before_they_pull"),
    },
    "AngularContactConductance": _in(
        "bearings/test_conductance.py", ball_bulk="against_an_independent_computation",
        ring_walls="rings_are_cylinder_walls_with_less_constriction", film="a_film_is_in_series_over_the_area_of_the_ellipse",
        lubricant_path="lubricant_beside_the_contact_conducts_more_than_gas", gas_path="side_paths_have_their_closed_forms",
        convection="side_paths_have_their_closed_forms", radiation="side_paths_have_their_closed_forms"),
    "BearingTemperatures": _in(
        "bearings/test_temperatures.py", housing="steady_state_is_that_of_the_resistances",
        oil_flow="steady_state_is_that_of_the_resistances", radiation="radiation_alone_cools_by_the_fourth_power",
        shaft_heat="heat_supplied_is_stored_or_released"),
    "JeffcottRotor": {
        **_in("rotor/test_jeffcott.py", unbalance="amplitude_and_phase_of_the_unbalance_response",
              internal_damping="onset_of_instability_by_internal_damping",
              orthotropy="orthotropic_supports_split_the_critical_speed_and_whirl_backwards_in_between",
              run_up="run_up_through_the_critical_speed_is_its_convolution_integral"),
        **_here(gravity="a_rotor_sags_by_its_weight_over_its_stiffness"),
    },
    "BeamRotor": {
        **_in("rotor/test_modal.py", gyroscopic="gyroscopic_splitting_of_an_overhung_disk",
              linear_supports="friswells_example_has_the_frequencies_of_an_independent_program"),
        **_in("rotor/test_elements.py", disks="disk_in_the_middle_of_a_light_shaft_is_the_jeffcott_rotor"),
        **_in("rotor/test_beam.py", unbalance="steady_unbalance_response_is_that_of_the_frequency_domain",
              internal_damping="internal_damping_drives_the_rotor_above_the_onset_speed", gravity="sag_is_that_of_beam_theory",
              run_up="a_run_up_passes_the_critical_speed_between_supports_with_damping",
              bearing_a="a_tangent_through_the_port_is_a_spring_in_the_rotor",
              bearing_b="a_tangent_through_the_port_is_a_spring_in_the_rotor"),
        **_in("rotor/test_frame_rotation.py",
              frame_rotation="the_steady_moment_is_polar_inertia_times_speed_times_rate"),
    },
    "GimbalBody": {
        **_in("two_axis_joint/test_gimbal.py", gravity="pendulum_of_any_amplitude", rotor="nutation_of_a_gyroscope",
              smoothed_friction="smoothed_friction_creeps_where_exact_friction_stands",
              lugre_friction="smoothed_friction_creeps_where_exact_friction_stands",
              stick_friction="a_pendulum_with_dry_friction_turns_where_the_work_says_and_stays",
              stops="an_impact_on_a_stop_loses_what_the_law_says"),
        **_in("two_axis_joint/test_gimbal_equations.py", viscous="accelerations_are_those_of_lagrange",
              base_motion="an_accelerating_base_is_another_direction_of_gravity",
              payload="point_masses_give_the_same_torques_and_the_reactions",
              reactions="point_masses_give_the_same_torques_and_the_reactions"),
    },
    "GimbalController": _in("two_axis_joint/test_gimbal_controller.py", scan="the_scan_moves_set_points_and_their_rates"),
    "TorqueMotor": _in(
        "drives/test_torque_motor.py", inductance="current_rises_with_the_time_constant_of_the_winding",
        saturation="the_amplifier_limits_voltage_and_current"),
    "ServoMotor": _in(
        "drives/test_servo_motor.py", inductance="step_response_is_the_exact_one",
        saturation="the_current_limit_gives_a_constant_acceleration",
        shaft_friction="a_shaft_runs_out_under_dry_friction_in_the_exact_time_and_stays"),
    "TwoLinkChain": _in(
        "two_axis_joint/test_two_link_chain.py", gravity="small_motion_in_a_mode_keeps_its_shape_and_frequency",
        viscous="damped_small_motion_is_the_exact_solution", smoothed_friction="lagrange_is_newton_and_euler_at_random_states",
        lugre_friction="bristles_decay_as_exact_standstill_does",
        stick_friction="dry_friction_takes_a_pendulum_from_turn_to_turn_and_holds_it", stops="restitution_of_the_stops",
        reactions="lagrange_is_newton_and_euler_at_random_states"),
    "PlanarLink": _in("two_axis_joint/test_planar_link.py", pinned="a_pinned_link_is_a_pendulum",
                      gravity="a_thrown_link_flies_along_a_parabola_and_turns_evenly"),
    "CompliantJoint": _in("two_axis_joint/test_planar_link.py", clearance="a_joint_with_play_is_free_inside_it",
                          rotation="a_compliant_joint_gives_back_what_it_takes_less_its_losses"),
    "RovHull": {
        **_in("rov/test_hull.py", added_mass="start_from_rest_follows_riccati", coriolis="munk_moment_grows_at_its_rate",
              linear_drag="roll_is_damped_as_the_linear_drag_says", quadratic_drag="terminal_speed",
              restoring="large_roll_has_the_period_of_a_pendulum", current="in_a_uniform_current_all_is_as_in_still_water",
              tether="energy_changes_by_the_power_of_thrust_loads_and_drag"),
        **_here(external="a_force_on_a_hull_gives_it_the_acceleration_of_hull_and_water"),
    },
    "AddedMassForce": {},
    "Thruster": {
        **_in("rov/test_thruster.py", static_curve="the_static_curve_has_the_rows_of_the_sheet",
              polynomial_curve="the_published_polynomial", lag="a_first_order_lag_is_an_exponential",
              motor_lag="the_third_order_lag_is_the_published_transfer_function_to_fourth_order",
              propeller="full_voltage_is_the_full_row_of_the_sheet", inductance="a_small_inductance_changes_little"),
        **_here(status="a_thruster_that_runs_is_there"),
    },
    "WaterCurrent": _in("rov/test_water_current.py", tide="a_gust_and_a_tide_peak_where_they_should",
                        ramp="acceleration_is_the_derivative_of_the_velocity", gust="a_gust_and_a_tide_peak_where_they_should"),
    "RovController": {
        **_in("rov/test_thruster.py", inverse_curve="the_inverse_curve_gives_every_thrust_within_the_limits"),
        **_in("rov/test_rov_controller.py", manoeuvre="a_manoeuvre_goes_through_its_poses"),
    },
    "Tether": _in("rov/test_tether.py", internal_damping="drag_and_damping_only_take_energy",
                  drag="a_taut_tether_in_a_cross_flow_carries_its_drag",
                  current="a_taut_tether_in_a_cross_flow_carries_its_drag"),
    "WindTurbine": {
        **_here(pitch="pitch_is_that_of_the_published_fit"),
        **_in("wind_pump/test_turbine.py", furling="a_furled_rotor_feels_the_wind_at_which_it_turns_away",
              bearing_friction="a_rotor_that_coasts_comes_to_rest_in_the_time_of_the_closed_form"),
    },
    "Wind": _in("wind_pump/test_wind.py", ramp="a_ramp_rises_stays_and_returns",
                daily="a_day_has_its_strongest_and_its_weakest_hour", turbulence="turbulence_has_drydens_correlation",
                gusts="gusts_come_every_period"),
    "FixedTransmission": _in(GEAR, mesh_friction="power_in_is_power_out_and_lost_and_stored"),
    "PlanetaryTransmission": {
        **_in(GEAR, mesh_friction="power_in_is_power_out_and_lost_and_stored",
              dry_brake="a_dry_brake_slips_at_its_torque_and_not_before"),
        **_here(centrifugal_brake="a_centrifugal_brake_takes_the_square_of_the_speed"),
    },
    "AveragedConverter": _in(GEAR, mesh_friction="power_in_is_power_out_and_lost_and_stored"),
    "InertialConverter": {
        **_in("wind_pump/test_converter.py", mesh_friction="gear_friction_takes_its_share_of_the_torque",
              compliant_clutches="slipping_clutches_lose_torque_in_the_second_order_of_their_delay"),
        **_in("wind_pump/test_converter_forces.py", stresses="stresses_at_stall_are_those_of_the_mass_alone"),
    },
    "PistonPump": {
        **_in("wind_pump/test_pumps.py", leakage="leakage_costs_flow_and_seals_cost_torque",
              seal_friction="leakage_costs_flow_and_seals_cost_torque"),
        **_in("wind_pump/test_averaged_pump.py", averaged="mean_of_a_turn"),
    },
    "CentrifugalPump": _in("wind_pump/test_pumps.py", seal_friction="seals_are_felt_at_standstill"),
    "WaterPipe": _in("wind_pump/test_water_pipe.py", friction="head_is_height_and_friction",
                     air_vessel="the_column_swings_on_the_air_at_its_frequency",
                     tank="a_tank_fills_runs_over_and_empties_at_the_instants_of_its_volumes"),
    "FourBar": _in("wrist/test_four_bar.py", pin_damping="virtual_work", rocker_spring="the_spring_stores_what_goes_into_it",
                   coupler_point="the_point_of_the_coupler_moves_as_its_velocity_says"),
    "ForearmTendons": _in(
        "wrist/test_forearm_tendons.py", programme="the_programme_goes_in_straight_lines",
        fibres="passive_fibres_have_a_potential", force_velocity="hills_hyperbola",
        varying_arms="moment_arms_that_vary_are_the_slope_of_the_shortening"),
    "PipeRobot": _in(
        "pipe_robot/test_pipe_robot.py", harmonic_force="sliding_one_way_is_linear_and_of_fourth_order",
        prescribed_motion="mean_speed_at_weak_friction_and_its_convergence",
        unbalance="an_unbalance_shakes_as_a_force_of_its_centrifugal_size", bristles="levels_of_bristles",
        cubic_spring="a_robot_on_a_slope_starts_with_its_mass_hanging_still",
        smoothed_friction="other_frictions_have_the_same_levels_in_steady_sliding",
        lugre_friction="other_frictions_have_the_same_levels_in_steady_sliding",
        tow="mean_friction_is_the_weight_down_the_pipe", route="mean_speed_on_a_slope_and_where_it_turns_back"),
    "RollingPipeRobot": _in(
        "pipe_robot/test_rolling_robot.py", harmonic_force="rolling_and_sliding_are_those_of_another_solver",
        tow="energy_of_a_rolling_robot_grows_by_what_comes_in_less_what_is_lost",
        route="it_holds_on_a_slope_up_to_the_friction_and_rolls_down_forwards"),
    "PipeRoute": {},
    "TowCoupling": _in("pipe_robot/test_tow_coupling.py", slack="a_rope_neither_pushes_nor_sticks"),
    "ExciterProgram": {},
    "ServoController": _in("friction_drive/test_servo_controller.py",
                           quantisation="a_sleeve_between_two_counts_is_seen_at_the_lower_one",
                           reference="the_set_point_follows_its_table"),
    "FrictionWheels": _in(
        "friction_drive/test_friction_wheels.py", **dict.fromkeys(SLIPS, "speed_under_load"),
        trocar_friction="the_seal_holds_a_small_load_and_slides_under_a_large_one",
        gravity="the_weight_slides_down_what_friction_does_not_hold",
        preload_loss="a_lost_wheel_bears_nothing_and_leaves_the_load_to_the_other"),
    "FrictionDrive": {
        **_in("friction_drive/test_drive_monolith.py",
              inductance="even_wheels_with_free_rollers_are_one_motor_with_the_sleeve_on_its_shaft",
              shaft_friction="motors_that_stand_hold_the_sleeve_through_contacts_that_stick",
              # the parts it is compared with are the units with known answers of their own
              **dict.fromkeys(("trocar_friction", "gravity", "preload_loss"), "the_parts_tend_to_the_whole_with_the_step")),
        **_here(**dict.fromkeys(SLIPS, "a_motor_bears_the_friction_of_its_contact_under_every_law")),
    },
    "Wrist": {
        **_in("wrist/test_wrist_motion.py", morphology="inertia_is_lagranges",
              load="a_force_of_a_tendon_is_a_torque_by_its_arms"),
        **_in("wrist/test_wrist_ligaments.py", constraint="a_held_row_leaves_an_oscillator_of_one_degree_of_freedom"),
        **_here(interaction="a_hand_rests_where_its_limit_and_its_stiffness_bear_the_torque"),
    },
    "LigamentBundle": {},
}
