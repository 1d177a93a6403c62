"""What of a run belongs to its underwater vehicles: track, attitude, thrusts and commands, errors, what should stay constant.

A unit is a vehicle if its position_north, position_east and depth were recorded. Its thrusters and its controller are found by
the scene's connections: what drives thrust[1] ..., what drives that unit's command, and the errors the latter tells.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ....components.rov.controller import RovController
from ...harness.analysis.records import RecordedUnit, recorded_units

if TYPE_CHECKING:
    from ...run.results import Result

POSITION = ("position_north", "position_east", "depth")
ANGLES = ("roll", "pitch", "yaw")
SPEEDS = ("surge", "sway", "heave")
RATES = ("roll_rate", "pitch_rate", "yaw_rate")
ACCELERATIONS = tuple(f"external.acceleration_{a}" for a in "xyz")
QUATERNION = tuple(f"quaternion_{n}" for n in "wxyz")
ERRORS = ("error_north", "error_east", "error_down", "error_roll", "error_pitch", "error_yaw")
WATER = ("north", "east", "down")
THRUSTS = (*(f"thrust[{i}]" for i in range(1, 7)), "further_thrusters.thrust[1]", "further_thrusters.thrust[2]")
FULL = 1.0 - 1e-9  # of the command, from which on a thruster gives all it can
CONSERVING = {"added_mass", "coriolis", "external", "tether"}  # without forces through the latter two


@dataclass(frozen=True)
class Vehicle:
    """The recorded part of a vehicle of a run.

    position: (3, n) north, east, down, m.  axes: (3, 3, n), column j the body's axis j in north, east, down; None where the
    quaternion was not recorded.  signals: angles, speeds, rates, accelerations by name, in SI units; angles are NaN where roll
    and yaw are ambiguous.  thrusts: number of the thruster -> (n,) as the hull receives it, N; commands: likewise.
    errors, scale: what its controller tells.  water: velocity of the water, north, east, down, m/s, those that were recorded
    where they come from.  constants: what the equations keep, by name: (k, n).
    """

    unit: str
    time: np.ndarray
    position: np.ndarray
    axes: np.ndarray | None
    signals: Mapping[str, np.ndarray]
    thrusts: Mapping[int, np.ndarray]
    commands: Mapping[int, np.ndarray]
    errors: Mapping[str, np.ndarray]
    scale: np.ndarray | None
    water: Mapping[str, np.ndarray]
    constants: Mapping[str, np.ndarray]

    @property
    def wanted(self) -> np.ndarray | None:
        """Track of the set point, (3, n), m; None where the controller's errors were not recorded."""
        if not set(ERRORS[:3]) <= self.errors.keys():
            return None
        return self.position + np.array([self.errors[n] for n in ERRORS[:3]])

    def at_limit(self, number: int) -> np.ndarray:
        """Where the thruster's command is at or beyond its limit, (n,)."""
        command = self.commands.get(number)
        return np.zeros(self.time.size, dtype=bool) if command is None else np.abs(command) >= FULL


def vehicles(result: Result) -> list[Vehicle]:
    """The vehicles of a run whose position was recorded, in the order of the scene."""
    return [_vehicle(unit) for unit in recorded_units(result, *POSITION)]


def _vehicle(unit: RecordedUnit) -> Vehicle:
    signals = unit.recorded((*ANGLES, *SPEEDS, *RATES, *ACCELERATIONS))
    valid = unit.optional("attitude_valid")
    if valid is not None:
        signals |= {n: np.where(valid > 0.5, signals[n], np.nan) for n in ("roll", "yaw") if n in signals}
    thrusts = {k: _arrived(unit, name) for k, name in enumerate(THRUSTS, 1) if unit.column(name)}
    thrusters = {k: thruster for k, name in enumerate(THRUSTS, 1) if (thruster := unit.driven_by(name))}
    commands = {k: thruster["command"] for k, thruster in thrusters.items() if thruster.column("command")}
    controller = next((c for thruster in thrusters.values() if (c := thruster.driven_by("command"))), None)
    scale = controller.optional("scale") if controller else None
    errors = _errors(unit, controller) if controller else {}
    water = unit.recorded({axis: f"current.velocity_{axis}" for axis in WATER})
    position, quaternion = np.array(list(unit.recorded(POSITION).values())), unit.recorded(QUATERNION)
    axes = axes_of(*quaternion.values()) if len(quaternion) == len(QUATERNION) else None
    constants = {} if axes is None else _constants(unit, position, axes, signals)
    return Vehicle(unit.name, unit.time, position, axes, signals, thrusts, commands, errors, scale, water, constants)


def _errors(unit: RecordedUnit, controller: RecordedUnit) -> dict[str, np.ndarray]:
    """Wanted pose less that of the vehicle, by name: as the controller tells it, unless sensors stand between the two.

    Then from its set points and the vehicle's own pose; none where the controller is not known or the pose was not recorded.
    """
    sources = [controller.source(name) for name in (*POSITION, *QUATERNION)]
    if all(not source or source.startswith(f"{unit.name}.") for source in sources):
        return controller.recorded(ERRORS)
    component, true = controller.component, unit.recorded((*POSITION, *QUATERNION))
    if not isinstance(component, RovController) or len(true) < 7:
        return {}
    from scipy.spatial.transform import Rotation

    wanted = component.set_points(unit.time)
    errors = {e: wanted[:, j] - true[n] for j, (e, n) in enumerate(zip(ERRORS, POSITION, strict=False))}
    attitude = Rotation.from_quat(np.array([true[f"quaternion_{a}"] for a in "xyzw"]).T)
    turn = (attitude.inv() * Rotation.from_euler("ZYX", wanted[:, :2:-1])).as_rotvec().T
    return errors | dict(zip(ERRORS[3:], turn, strict=True))


def _arrived(unit: RecordedUnit, input_: str) -> np.ndarray:
    """What arrives at an input that is recorded where it begins: faults change it on its way."""
    arrived, t = unit[input_].copy(), unit.time
    for fault in unit.result.scene.faults:
        inside = (t >= fault.begin) & (t < (np.inf if fault.end is None else fault.end))
        if fault.signal not in (unit.source(input_), f"{unit.name}.{input_}") or not inside.any():
            continue
        if fault.kind == "offset":
            arrived[inside] += fault.value
        else:  # a dropped thrust is that of an input nobody drives
            arrived[inside] = {"override": fault.value, "freeze": arrived[np.argmax(inside)], "drop": 0.0}[fault.kind]
    return arrived


def axes_of(w: np.ndarray, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Rotation matrices of unit quaternions, (3, 3, n)."""
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )


def _constants(
    unit: RecordedUnit, position: np.ndarray, axes: np.ndarray, signals: Mapping[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """Kinetic energy, (1, n), impulse and its moment about the origin of the world's axes, (3, n), of a body in a perfect fluid.

    Empty for a vehicle with drag, weight, current, or anything driven, and where velocities were not recorded.
    """
    component: Any = unit.component
    driven = any(unit.source(n) for n in component.inputs) if component is not None else True
    if driven or "coriolis" not in component.on or not set(component.on) <= CONSERVING or component.u.any():
        return {}
    if not {*SPEEDS, *RATES} <= signals.keys() or not hasattr(component, "masses"):
        return {}
    velocity = np.array([signals[n] for n in (*SPEEDS, *RATES)])
    momentum = sum(component.masses()) @ velocity
    impulse, moment = (np.einsum("ijn,jn->in", axes, part) for part in (momentum[:3], momentum[3:]))
    energy = 0.5 * np.einsum("in,in->n", velocity, momentum)[None]
    return {"energy": energy, "impulse": impulse, "moment of impulse": moment + np.cross(position.T, impulse.T).T}
