"""Component -> effect -> the test that compares it with a known answer."""

from __future__ import annotations

from cosimo.tests.contract.known_answers import here, in_file

KNOWN: dict[str, dict[str, str]] = {
    "RovHull": {
        **in_file(
            "rov/test_hull.py",
            added_mass="start_from_rest_follows_riccati",
            coriolis="munk_moment_grows_at_its_rate",
            linear_drag="roll_is_damped_as_the_linear_drag_says",
            quadratic_drag="terminal_speed",
            restoring="large_roll_has_the_period_of_a_pendulum",
            current="in_a_uniform_current_all_is_as_in_still_water",
            tether="energy_changes_by_the_power_of_thrust_loads_and_drag",
        ),
        **in_file("rov/test_water_particles.py", pressure_gradient="a_neutral_hull_moves_with_the_water_of_a_wave"),
        **in_file("rov/test_eight_thrusters.py", further_thrusters="eight_thrusts_are_their_columns_of_the_matrix"),
        **here(external="a_force_on_a_hull_gives_it_the_acceleration_of_hull_and_water"),
    },
    "AddedMassForce": {},
    "Thruster": {
        **in_file(
            "rov/test_thruster.py",
            static_curve="the_static_curve_has_the_rows_of_the_sheet",
            polynomial_curve="the_published_polynomial",
            lag="a_first_order_lag_is_an_exponential",
            motor_lag="the_third_order_lag_is_the_published_transfer_function_to_fourth_order",
            propeller="full_voltage_is_the_full_row_of_the_sheet",
            inductance="a_small_inductance_changes_little",
        ),
        **here(status="a_thruster_that_runs_is_there"),
    },
    "WaterCurrent": {
        **in_file(
            "rov/test_water_current.py",
            tide="a_gust_and_a_tide_peak_where_they_should",
            ramp="acceleration_is_the_derivative_of_the_velocity",
            gust="a_gust_and_a_tide_peak_where_they_should",
        ),
        **in_file(
            "rov/test_waves.py",
            waves="the_flow_has_a_potential_and_keeps_volume_bottom_and_surface",
            spectrum="a_sea_has_its_height_and_its_motion_at_depth",
        ),
    },
    "RovController": {
        **in_file("rov/test_thruster.py", inverse_curve="the_inverse_curve_gives_every_thrust_within_the_limits"),
        **in_file("rov/test_rov_controller.py", manoeuvre="a_manoeuvre_goes_through_its_poses"),
        **in_file("rov/test_eight_thrusters.py", further_thrusters="the_commands_of_eight_thrusters_give_the_wanted_wrench"),
    },
    "Tether": in_file(
        "rov/test_tether.py",
        internal_damping="drag_and_damping_only_take_energy",
        drag="a_taut_tether_in_a_cross_flow_carries_its_drag",
        current="a_taut_tether_in_a_cross_flow_carries_its_drag",
    ),
}
