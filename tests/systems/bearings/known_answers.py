"""Component -> effect -> the test that compares it with a known answer."""

from __future__ import annotations

from cosimo.tests.contract.known_answers import in_file

PITS = ("inner_defect", "outer_defect", "ball_defect")
# another implementation of the same equations, one sine and cosine a ball, gaps differentiated numerically
BY_EQUATIONS = ("clearance", "contact_damping", "unbalance", *PITS, "cage_fault", "load_variation", "speed_ramp")

KNOWN: dict[str, dict[str, str]] = {
    "BallBearing": {
        **in_file(
            "bearings/test_ball_bearing.py",
            **dict.fromkeys(BY_EQUATIONS, "the_equations_are_those_of_the_docstring"),
            inner_waviness="waves_of_a_race_shake_the_shaft_at_the_known_lines",
            outer_waviness="waves_of_a_race_shake_the_shaft_at_the_known_lines",
        ),
        "given_start": "tests/systems/bearings/test_ball_bearing.py::test_restitution_of_the_contact_damping",
    },
    "DimensionlessBallBearing": in_file(
        "bearings/test_ball_bearing.py",
        **dict.fromkeys(
            (*BY_EQUATIONS, "inner_waviness", "outer_waviness"), "dimensional_and_dimensionless_are_the_same_trajectory"
        ),
        given_start="defaults_of_the_dimensionless_bearing_are_the_scaled_ones",
    ),
    "DeepGrooveBearing": {
        **in_file(
            "bearings/test_deep_groove.py",
            **dict.fromkeys(PITS, "a_defect_is_met_at_its_frequency"),
            film="film_thickness_over_speed_and_what_it_does",
            inner_waviness="lines_of_waviness",
            outer_waviness="lines_of_waviness",
            published_levers="published_levers_break_the_symmetry_by_under_one_percent",
            linearisation="linearisation_is_the_tangent_and_its_intercept",
            friction="friction_turns_power_into_heat",
            thermal_growth="growth_is_a_change_of_the_diametral_clearance",
        ),
        **in_file("bearings/test_loads.py", damping="dampers_take_power_and_let_go_before_they_pull"),
    },
    "AngularContactConductance": in_file(
        "bearings/test_conductance.py",
        ball_bulk="against_an_independent_computation",
        ring_walls="rings_are_cylinder_walls_with_less_constriction",
        film="a_film_is_in_series_over_the_area_of_the_ellipse",
        lubricant_path="lubricant_beside_the_contact_conducts_more_than_gas",
        gas_path="side_paths_have_their_closed_forms",
        convection="side_paths_have_their_closed_forms",
        radiation="side_paths_have_their_closed_forms",
    ),
    "BearingTemperatures": in_file(
        "bearings/test_temperatures.py",
        housing="steady_state_is_that_of_the_resistances",
        oil_flow="steady_state_is_that_of_the_resistances",
        radiation="radiation_alone_cools_by_the_fourth_power",
        shaft_heat="heat_supplied_is_stored_or_released",
    ),
}
