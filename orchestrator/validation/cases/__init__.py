"""All validation cases by name; a case listed here is run by `cosimo validate`."""

from __future__ import annotations

from ..case import Case
from . import (
    catenary_statics,
    chain_closed_forms,
    clearance,
    defect_frequencies,
    en50318_2002,
    en50318_2018,
    en50367,
    four_bar,
    friction_drive,
    friswell,
    gimbal_closed_forms,
    hertz_textbook,
    hunting,
    inertial_converter,
    iso16281,
    jeffcott,
    link_split,
    lumped_catenary,
    lyapunov_sum,
    pipe_robot_balance,
    pipe_robot_mean_speed,
    pipe_robot_resonance,
    recurrence,
    rov_added_mass,
    rov_allocation,
    rov_closed_forms,
    servo_motor,
    stribeck,
    thermal_scaling,
    varying_compliance,
    wind_pump_closed_forms,
    wind_pump_equilibrium,
    wind_pump_start,
    wrist_rules,
    wrist_stiffness,
)

MODULES = (
    en50318_2002, en50318_2018, en50367, catenary_statics, lumped_catenary,
    varying_compliance, lyapunov_sum, defect_frequencies, hertz_textbook, iso16281, stribeck, clearance,
    recurrence,
    thermal_scaling, friswell, jeffcott,
    rov_closed_forms, rov_allocation, rov_added_mass,
    chain_closed_forms, gimbal_closed_forms, link_split,
    wind_pump_equilibrium, wind_pump_start, wind_pump_closed_forms, inertial_converter,
    friction_drive, servo_motor, hunting,
    pipe_robot_mean_speed, pipe_robot_balance, pipe_robot_resonance,
    wrist_rules, four_bar, wrist_stiffness,
)  # fmt: skip
CASES: dict[str, Case] = {case.name: case for case in (module.CASE for module in MODULES)}
