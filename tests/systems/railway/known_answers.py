"""Component -> effect -> the test that compares it with a known answer."""

from __future__ import annotations

from cosimo.tests.contract.known_answers import here, in_file

KNOWN: dict[str, dict[str, str]] = {
    "Pantograph": {
        **here(
            contact_loss="a_wire_that_goes_away_pulls_only_without_contact_loss",
            bump_stops="a_stop_pushes_the_head_back_from_the_end_of_its_travel",
        ),
        **in_file(
            "railway/test_pantograph.py",
            lower_frame="eigenfrequencies_of_the_free_oscillation",
            aerodynamic_uplift="lift_grows_with_the_square_of_the_speed",
            frame_friction="frame_friction_holds_against_a_small_change_of_force",
            base_excitation="transmissibility_of_the_base",
            outer_contact="outer_contact_gives_the_motion_of_the_inner_one",
        ),
        **in_file(
            "railway/test_pantograph_effects.py",
            two_strips="two_strips_average_the_wire_over_their_distance",
            strip_lift="lift_of_the_strips_adds_to_the_force",
            wire_unevenness="unevenness_is_a_height_of_the_wire",
            measured_unevenness="measured_unevenness_is_a_height_of_the_wire",
            lift_fluctuation="lift_fluctuates_with_its_standard_deviation",
            acceleration="train_accelerates_and_then_keeps_its_speed",
            actuator="actuator_follows_its_command_with_a_lag",
        ),
        **in_file("railway/test_second_wire.py", second_wire="wires_share_the_force_by_their_heights"),
    },
    "Catenary": {
        **here(steady_arm="a_steady_arm_is_a_spring_beside_the_compliance_of_the_wire"),
        **in_file(
            "railway/test_statics.py",
            dropper_slackening="droppers_let_go_one_after_the_other",
            bending_stiffness="bending_stiffness_lowers_the_compliance_by_the_boundary_layer",
            gravity_sag="sag_between_droppers_is_a_parabola",
            pre_sag="droppers_carry_the_weight_and_the_pre_sag",
            level_support="level_support_raises_the_wire_to_dropper_level",
        ),
        **in_file("railway/test_wires.py", damping="mass_proportional_damping_decays_every_mode_alike"),
        **in_file(
            "railway/test_catenary.py",
            second_pantograph="two_forces_superpose_where_droppers_are_bilateral",
            further_pantographs="contact_points_may_change_places",
            moving_window="window_follows_the_contact_and_forgets_the_rest",
            wire_profile="profile_is_the_height_at_its_positions",
            line_profile="profile_of_what_the_wire_hangs_from",
        ),
        **in_file("railway/test_gusts.py", gusts="a_single_wire_answers_as_its_modes_do"),
        **in_file("railway/test_line_temperature.py", temperature="a_fixed_messenger_keeps_the_equation_of_state"),
        **in_file(
            "railway/test_line.py",
            line_table="elasticity_of_a_table_is_that_of_the_network",
            stagger="lateral_position_is_that_of_the_table",
            second_wire="two_wires_share_a_force_as_in_the_network",
        ),
    },
    "LumpedCatenary": in_file("railway/test_lumped.py", inerter="mass_makes_a_forced_oscillation_that_the_inerter_does_not"),
}
