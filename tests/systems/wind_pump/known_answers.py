"""Component -> effect -> the test that compares it with a known answer."""

from __future__ import annotations

from cosimo.tests.contract.known_answers import here, in_file

GEAR = "wind_pump/test_transmissions.py"

KNOWN: dict[str, dict[str, str]] = {
    "WindTurbine": {
        **here(pitch="pitch_is_that_of_the_published_fit"),
        **in_file(
            "wind_pump/test_turbine.py",
            furling="a_furled_rotor_feels_the_wind_at_which_it_turns_away",
            bearing_friction="a_rotor_that_coasts_comes_to_rest_in_the_time_of_the_closed_form",
        ),
    },
    "Wind": in_file(
        "wind_pump/test_wind.py",
        ramp="a_ramp_rises_stays_and_returns",
        daily="a_day_has_its_strongest_and_its_weakest_hour",
        turbulence="turbulence_has_drydens_correlation",
        gusts="gusts_come_every_period",
    ),
    "FixedTransmission": in_file(GEAR, mesh_friction="power_in_is_power_out_and_lost_and_stored"),
    "PlanetaryTransmission": {
        **in_file(
            GEAR,
            mesh_friction="power_in_is_power_out_and_lost_and_stored",
            dry_brake="a_dry_brake_slips_at_its_torque_and_not_before",
        ),
        **here(centrifugal_brake="a_centrifugal_brake_takes_the_square_of_the_speed"),
    },
    "AveragedConverter": in_file(GEAR, mesh_friction="power_in_is_power_out_and_lost_and_stored"),
    "InertialConverter": {
        **in_file(
            "wind_pump/test_converter.py",
            mesh_friction="gear_friction_takes_its_share_of_the_torque",
            compliant_clutches="slipping_clutches_lose_torque_in_the_second_order_of_their_delay",
        ),
        **in_file("wind_pump/test_converter_forces.py", stresses="stresses_at_stall_are_those_of_the_mass_alone"),
    },
    "PistonPump": {
        **in_file(
            "wind_pump/test_pumps.py",
            leakage="leakage_costs_flow_and_seals_cost_torque",
            seal_friction="leakage_costs_flow_and_seals_cost_torque",
        ),
        **in_file("wind_pump/test_averaged_pump.py", averaged="mean_of_a_turn"),
    },
    "CentrifugalPump": in_file("wind_pump/test_pumps.py", seal_friction="seals_are_felt_at_standstill"),
    "WaterPipe": in_file(
        "wind_pump/test_water_pipe.py",
        friction="head_is_height_and_friction",
        air_vessel="the_column_swings_on_the_air_at_its_frequency",
        tank="a_tank_fills_runs_over_and_empties_at_the_instants_of_its_volumes",
    ),
}
