"""Component -> effect -> the test that compares it with a known answer."""

from __future__ import annotations

from cosimo.tests.contract.known_answers import in_file

HIGH_ORDER = "tests/core/test_high_order.py::test_a_pendulum_of_any_amplitude_converges_with_order_eight"

KNOWN: dict[str, dict[str, str]] = {
    "GimbalBody": {
        **in_file(
            "two_axis_joint/test_gimbal.py",
            gravity="pendulum_of_any_amplitude",
            rotor="nutation_of_a_gyroscope",
            smoothed_friction="smoothed_friction_creeps_where_exact_friction_stands",
            lugre_friction="smoothed_friction_creeps_where_exact_friction_stands",
            stick_friction="a_pendulum_with_dry_friction_turns_where_the_work_says_and_stays",
            stops="an_impact_on_a_stop_loses_what_the_law_says",
        ),
        "high_order": HIGH_ORDER,
        **in_file(
            "two_axis_joint/test_gimbal_equations.py",
            viscous="accelerations_are_those_of_lagrange",
            base_motion="an_accelerating_base_is_another_direction_of_gravity",
            payload="point_masses_give_the_same_torques_and_the_reactions",
            reactions="point_masses_give_the_same_torques_and_the_reactions",
        ),
    },
    "GimbalController": in_file("two_axis_joint/test_gimbal_controller.py", scan="the_scan_moves_set_points_and_their_rates"),
    "TwoLinkChain": {
        "high_order": HIGH_ORDER,
        **in_file(
            "two_axis_joint/test_two_link_chain.py",
            gravity="small_motion_in_a_mode_keeps_its_shape_and_frequency",
            viscous="damped_small_motion_is_the_exact_solution",
            smoothed_friction="lagrange_is_newton_and_euler_at_random_states",
            lugre_friction="bristles_decay_as_exact_standstill_does",
            stick_friction="dry_friction_takes_a_pendulum_from_turn_to_turn_and_holds_it",
            stops="restitution_of_the_stops",
            springs="a_spring_throws_a_link_out_with_the_energy_of_its_preload",
            reactions="lagrange_is_newton_and_euler_at_random_states",
        ),
    },
    "PlanarLink": in_file(
        "two_axis_joint/test_planar_link.py",
        pinned="a_pinned_link_is_a_pendulum",
        gravity="a_thrown_link_flies_along_a_parabola_and_turns_evenly",
    ),
    "CompliantJoint": in_file(
        "two_axis_joint/test_planar_link.py",
        clearance="a_joint_with_play_is_free_inside_it",
        rotation="a_compliant_joint_gives_back_what_it_takes_less_its_losses",
    ),
}
