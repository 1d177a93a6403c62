"""Types of real variables by unit of measure, and the units in which tools should show them.

Source: FMI 2.0.4, sections 2.2.2 (units: shown value = factor value + offset) and 2.2.3 (types).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from .interface import Scalar

# unit of measure -> units to show it in, (factor, offset); the first one is the type's
SHOWN = {
    "rad": {"deg": (180.0 / math.pi, 0.0)},
    "rad/s": {"rpm": (30.0 / math.pi, 0.0), "deg/s": (180.0 / math.pi, 0.0)},
    "K": {"degC": (1.0, -273.15)},
    "m": {"mm": (1e3, 0.0)},
}
TYPES = {
    "m": "Length",
    "m/s": "Velocity",
    "m/s2": "Acceleration",
    "m2": "Area",
    "m3": "Volume",
    "rad": "Angle",
    "rad/s": "AngularVelocity",
    "rad/s2": "AngularAcceleration",
    "s": "Time",
    "Hz": "Frequency",
    "kg": "Mass",
    "kg.m2": "MomentOfInertia",
    "N": "Force",
    "N.m": "Torque",
    "N/m": "Stiffness",
    "N.s/m": "Damping",
    "N.m/rad": "AngularStiffness",
    "N.m.s/rad": "AngularDamping",
    "m/N": "Compliance",
    "Pa": "Pressure",
    "J": "Energy",
    "W": "Power",
    "K": "Temperature",
    "W/K": "ThermalConductance",
    "J/K": "HeatCapacity",
    "V": "Voltage",
    "A": "Current",
    "Ohm": "Resistance",
    "H": "Inductance",
    "kg/m3": "Density",
    "m3/s": "VolumeFlowRate",
}
MOVING = "MovingPosition"  # type of inputs that a master is not to hold over a step
SHORT = 0.1  # m: lengths of this size and below are shown in mm
SPINS = ("speed",)  # parts of the names of angular velocities that are shown in rpm


@dataclass(frozen=True)
class Quantity:
    """What a real variable's declaration adds to its unit; "" where it has no such."""

    type: str
    display: str


def quantity(scalar: Scalar) -> Quantity:
    """The type and the display unit of a real variable."""
    return Quantity(MOVING if scalar.moving else TYPES.get(scalar.unit, ""), _display(scalar))


def _display(scalar: Scalar) -> str:
    if scalar.unit == "m":
        return "mm" if 0.0 < typical_size(scalar) <= SHORT else ""
    if scalar.unit == "rad/s":
        return "rpm" if any(part in scalar.name for part in SPINS) else "deg/s"
    return next(iter(SHOWN.get(scalar.unit, {})), "")


def typical_size(scalar: Scalar) -> float:
    """The nominal value: as declared, or of a parameter the size of its start value."""
    start = scalar.start
    if scalar.nominal == 1.0 and scalar.causality in ("parameter", "local") and isinstance(start, float) and math.isfinite(start):
        return abs(start) or 1.0
    return scalar.nominal
