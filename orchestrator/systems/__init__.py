"""All validation cases by name; a case listed here is run by `cosimo validate`."""

from __future__ import annotations

from ..harness.validation.case import Case
from .bearings.cases import (
    clearance,
    defect_frequencies,
    hertz_textbook,
    iso16281,
    lyapunov_sum,
    recurrence,
    stribeck,
    thermal_scaling,
    varying_compliance,
)
from .friction_drive.cases import closed_forms as friction_drive
from .friction_drive.cases import hunting, servo_motor
from .pipe_robot.cases import (
    balance as pipe_robot_balance,
)
from .pipe_robot.cases import (
    mean_speed as pipe_robot_mean_speed,
)
from .pipe_robot.cases import (
    resonance as pipe_robot_resonance,
)
from .railway.cases import catenary_statics, en50318_2002, en50318_2018, en50367, lumped_catenary
from .rotor.cases import friswell, jeffcott
from .rov.cases import added_mass as rov_added_mass
from .rov.cases import allocation as rov_allocation
from .rov.cases import closed_forms as rov_closed_forms
from .two_axis_joint.cases import chain_closed_forms, gimbal_closed_forms, link_split
from .wind_pump.cases import (
    closed_forms as wind_pump_closed_forms,
)
from .wind_pump.cases import (
    equilibrium as wind_pump_equilibrium,
)
from .wind_pump.cases import (
    inertial_converter,
)
from .wind_pump.cases import (
    start as wind_pump_start,
)
from .wrist.cases import four_bar
from .wrist.cases import rules as wrist_rules
from .wrist.cases import stiffness as wrist_stiffness

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
