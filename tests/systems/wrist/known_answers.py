"""Component -> effect -> the test that compares it with a known answer."""

from __future__ import annotations

from cosimo.tests.contract.known_answers import here, in_file

KNOWN: dict[str, dict[str, str]] = {
    "FourBar": in_file(
        "wrist/test_four_bar.py",
        pin_damping="virtual_work",
        rocker_spring="the_spring_stores_what_goes_into_it",
        coupler_point="the_point_of_the_coupler_moves_as_its_velocity_says",
    ),
    "ForearmTendons": in_file(
        "wrist/test_forearm_tendons.py",
        programme="the_programme_goes_in_straight_lines",
        fibres="passive_fibres_have_a_potential",
        force_velocity="hills_hyperbola",
        varying_arms="moment_arms_that_vary_are_the_slope_of_the_shortening",
    ),
    "Wrist": {
        **in_file(
            "wrist/test_wrist_motion.py", morphology="inertia_is_lagranges", load="a_force_of_a_tendon_is_a_torque_by_its_arms"
        ),
        **in_file("wrist/test_wrist_ligaments.py", constraint="a_held_row_leaves_an_oscillator_of_one_degree_of_freedom"),
        **here(interaction="a_hand_rests_where_its_limit_and_its_stiffness_bear_the_torque"),
    },
    "LigamentBundle": {},
}
