"""Component -> effect -> the test that compares it with a known answer."""

from __future__ import annotations

from cosimo.tests.contract.known_answers import in_file

KNOWN: dict[str, dict[str, str]] = {
    "PipeRobot": in_file(
        "pipe_robot/test_pipe_robot.py",
        harmonic_force="sliding_one_way_is_linear_and_of_fourth_order",
        prescribed_motion="mean_speed_at_weak_friction_and_its_convergence",
        unbalance="an_unbalance_shakes_as_a_force_of_its_centrifugal_size",
        bristles="levels_of_bristles",
        cubic_spring="a_robot_on_a_slope_starts_with_its_mass_hanging_still",
        smoothed_friction="other_frictions_have_the_same_levels_in_steady_sliding",
        lugre_friction="other_frictions_have_the_same_levels_in_steady_sliding",
        tow="mean_friction_is_the_weight_down_the_pipe",
        route="mean_speed_on_a_slope_and_where_it_turns_back",
    ),
    "RollingPipeRobot": in_file(
        "pipe_robot/test_rolling_robot.py",
        harmonic_force="rolling_and_sliding_are_those_of_another_solver",
        tow="energy_of_a_rolling_robot_grows_by_what_comes_in_less_what_is_lost",
        route="it_holds_on_a_slope_up_to_the_friction_and_rolls_down_forwards",
    ),
    "PipeRoute": {},
    "TowCoupling": in_file("pipe_robot/test_tow_coupling.py", slack="a_rope_neither_pushes_nor_sticks"),
    "ExciterProgram": {},
}
