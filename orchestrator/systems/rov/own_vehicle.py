"""A vehicle of a reader's own: masses and matrices from a file in the form of the trade, and a scene that holds it in place.

    title = "my vehicle"
    axes = "forward-starboard-down"            # or "forward-port-up", as simulators of robots have them
    signs = "matrices"                         # or "derivatives", X_u and the like, which are negative
    mass = 13.5                                # kg; all numbers in SI units, about the origin of the axes
    inertia = [0.26, 0.23, 0.37]
    centre_of_gravity = [0.0, 0.0, 0.0]
    centre_of_buoyancy = [0.0, 0.0, -0.01]
    buoyancy = 131.6
    added_mass = "hull.1"                      # six numbers, six rows of six, or a file of WAMIT's added mass: forward, port, up
    linear_damping = [13.7, 0.0, 33.0, 0.0, 0.8, 0.0]
    quadratic_damping = [[141.0, ...], ...]
    thrusters = [{ position = [0.156, 0.111, 0.085], direction = [1.0, -1.0, 0.0] }, ...]      # one to eight

Source of WAMIT's form (rows of period, i, j, added mass over density and a power of the length): its user manual, chapter 4; from
memory. Deep below the surface added mass does not depend on the period, and that of the shortest one is taken.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ....components.core.errors import BadInput, pick
from ....components.core.files import read_bytes
from ....components.core.measure import STANDARD_GRAVITY
from ....components.rov.controller import NAVIGATION, RovController
from ....components.rov.thrust_curve import T200_COMMAND, T200_THRUST
from ....components.rov.vehicles import AXES
from ...scene.files import read_toml

FLIPS = {"forward-starboard-down": np.ones(6), "forward-port-up": np.array([1.0, -1.0, -1.0, 1.0, -1.0, -1.0])}
SIGNS = {"matrices": 1.0, "derivatives": -1.0}
NUMBERS = {"mass": 0.0, "weight": 0.0, "buoyancy": 0.0, "thrust_ahead": 0.0, "thrust_astern": 0.0,
           "density": 1025.0, "length": 1.0, "depth": 5.0}  # fmt: skip
VECTORS = ("inertia", "centre_of_gravity", "centre_of_buoyancy")
MATRICES = {"added_mass": "added_mass", "linear_damping": "linear_drag", "quadratic_damping": "quadratic_drag"}
KEYS = ("title", "source", "axes", "signs", *NUMBERS, *VECTORS, *MATRICES, "thrusters")
UNEQUAL = 1e-3  # of what both have on the diagonal: by so much two halves of a printed added mass may differ
BOUNDS = {"density": (500.0, 2000.0), "depth": (0.0, 12e3), "thrust_ahead": (0.0, 1e6), "thrust_astern": (0.0, 1e6)}
FAR = 5.0  # buoyancy over weight, and places over the largest radius of gyration: a rod's end has 1.7 of it, kg for N is 9.8
HEAVY = 20.0  # added mass over mass: a vehicle of thin plates has 3
DEFAULT_MASS = 11.5  # kg, of the vehicle that the controller's gains are for
GAINS = {  # of the controller -> power of the ratio of lengths that keeps the motion similar (Froude): mass 3, time 1/2
    "position_gain": 2.0,
    "velocity_gain": 2.5,
    "position_integral_gain": 1.5,
    "attitude_gain": 4.0,
    "rate_gain": 4.5,
    "attitude_integral_gain": 3.5,
    "reach": 1.0,
}


def array(value: Any, shape: tuple[int, ...], where: str) -> np.ndarray:
    """Finite numbers of a shape; raises `BadInput`."""
    try:
        numbers = np.array(value, dtype=float)
    except (TypeError, ValueError):
        numbers = np.zeros(0)
    if numbers.shape != shape or not np.isfinite(numbers).all():
        raise BadInput(
            where, repr(value)[:80], f"{' x '.join(map(str, shape)) or 'a'} finite number{'s' * bool(shape)}, in SI units"
        )
    return numbers


def wamit(path: Path, density: float, length: float) -> np.ndarray:
    """Added mass, (6, 6), of the shortest period of a file of WAMIT's, in its axes; raises `BadInput` with the line."""
    rows: dict[float, np.ndarray] = {}
    for line, text in enumerate(read_bytes(path, "added_mass").decode("latin-1").splitlines(), 1):
        cells = text.split()
        try:
            period, i, j, value = float(cells[0]), int(cells[1]), int(cells[2]), float(cells[3])
            if not (1 <= i <= 6 and 1 <= j <= 6 and np.isfinite(value)):
                raise ValueError
        except (IndexError, ValueError):
            if cells and line > 1:  # the first line may be a title
                raise BadInput(f"{path}, line {line}", repr(text[:60]), "period, i, j from 1 to 6, added mass") from None
            continue
        if period >= 0.0:  # below 0: the infinite one
            matrix = rows.setdefault(period, np.full((6, 6), np.nan))
            if np.isfinite(matrix[i - 1, j - 1]) and matrix[i - 1, j - 1] != value:
                raise BadInput(f"{path}, line {line}", f"a second row {i} {j} of the period {period:g}", "one row of each")
            matrix[i - 1, j - 1] = value
    if not rows:
        raise BadInput(str(path), "no row of a finite period", "rows of period, i, j, added mass")
    shortest = rows[min(rows)]
    if missing := [
        f"{k} {k}" for k in range(1, 7) if np.isnan(shortest[k - 1, k - 1])
    ]:  # off the diagonal WAMIT leaves zeros out
        raise BadInput(str(path), f"no row {', '.join(missing)} of the period {min(rows):g}", "all six modes")
    power = 3.0 + (np.arange(6) > 2)[:, None] + (np.arange(6) > 2)[None, :]
    return np.nan_to_num(shortest) * density * length**power


def read_vehicle(path: Path) -> dict[str, Any]:
    """Title, numbers and arrays of a vehicle in body axes forward, starboard, down, matrices positive; raises `BadInput`."""
    data = read_toml(path)
    for key in data:
        pick(key, KEYS, str(path), "a key of a vehicle", "key")
    for key in ("mass", "inertia", "thrusters"):
        if key not in data:
            raise BadInput(str(path), f"no {key}", "mass, inertia and thrusters at least")
    choices: dict[str, Mapping[str, Any]] = {"axes": FLIPS, "signs": SIGNS}
    for key, known in choices.items():
        pick(data.setdefault(key, next(iter(known))), known, f"{path}: {key}", f"one of {', '.join(known)}", key)
    flip, sign = FLIPS[data["axes"]], SIGNS[data["signs"]]
    vehicle: dict[str, Any] = {"title": str(data.get("title", path.stem)), "source": str(data.get("source", path.name))}
    for key in NUMBERS:
        vehicle[key] = float(array(data[key], (), f"{path}: {key}")) if key in data else NUMBERS[key]
    for key in VECTORS:
        vehicle[key] = array(data.get(key, [0.0] * 3), (3,), f"{path}: {key}") * (1.0 if key == "inertia" else flip[:3])
    if "weight" not in data:
        vehicle["weight"] = vehicle["mass"] * STANDARD_GRAVITY
    if "buoyancy" not in data:
        vehicle["buoyancy"] = vehicle["weight"]
    for key in MATRICES:
        given, where = data.get(key), f"{path}: {key}"
        if key == "added_mass" and isinstance(given, str):
            up = FLIPS["forward-port-up"]  # z of a panel program points up from the water, whatever axes the rest has
            vehicle[key] = wamit(path.parent / given, vehicle["density"], vehicle["length"]) * np.outer(up, up)
        elif given is not None:
            square = isinstance(given, list) and bool(given) and isinstance(given[0], list)
            matrix = array(given, (6, 6), where) if square else np.diag(array(given, (6,), where))
            vehicle[key] = sign * matrix * np.outer(flip, flip)
        if key in vehicle and (vehicle[key].diagonal() < 0.0).any():
            raise BadInput(where, "negative numbers on the diagonal", "positive ones", 'Or signs = "derivatives".')
    if "added_mass" in vehicle:
        vehicle["added_mass"] = symmetric(vehicle["added_mass"], f"{path}: added_mass")
    thrusters = data["thrusters"]
    if not isinstance(thrusters, list) or not 1 <= len(thrusters) <= 8 or not all(isinstance(t, dict) for t in thrusters):
        raise BadInput(f"{path}: thrusters", repr(thrusters)[:80], "one to eight tables of position and direction")
    for key in ("position", "direction"):
        vehicle[key] = np.array(
            [array(t.get(key), (3,), f"{path}: thrusters[{i}].{key}") * flip[:3] for i, t in enumerate(thrusters, 1)]
        )
    for i, thruster in enumerate(thrusters, 1):
        for key in thruster:
            pick(key, ("position", "direction"), f"{path}: thrusters[{i}]", "position and direction", "key")
    _refuse_other_units(vehicle, str(path))
    return vehicle


def _refuse_other_units(vehicle: Mapping[str, Any], where: str) -> None:
    """Raise `BadInput` for numbers that no vehicle has in SI units: most are in kg for N, in mm, or of another sign."""
    mass, inertia, force = vehicle["mass"], vehicle["inertia"], vehicle["weight"]

    def refuse(wrong: bool, key: str, actual: str, expected: str, remedy: str = "") -> None:
        if wrong:
            raise BadInput(f"{where}: {key}", actual, expected, remedy)

    for key, (low, high) in BOUNDS.items():
        number = vehicle[key]
        refuse(
            not low <= number <= high,
            key,
            f"{number:g}",
            f"{low:g} to {high:g}",
            "All numbers are in SI units; depth is downwards.",
        )
    refuse(min(mass, *inertia) <= 0.0, "mass, inertia", f"{mass:g}, {inertia.tolist()}", "numbers above 0")
    over = inertia.max() / (inertia.sum() - inertia.max())
    refuse(over > 1.01, "inertia", f"{inertia.tolist()}", "none above the sum of both others, as of any body")
    own = mass * STANDARD_GRAVITY
    refuse(not 0.9 < force / own < 1.1, "weight", f"{force:g} N", f"{own:g} N, mass times g, or no weight", "It is a force.")
    lift = vehicle["buoyancy"] / force
    refuse(not 1.0 / FAR < lift < FAR, "buoyancy", f"{lift:.3g} of the weight", "nearly the weight, N", "It is a force.")
    size = FAR * (float(inertia.max()) / mass) ** 0.5
    places = {**{key: vehicle[key] for key in VECTORS[1:]}, "thrusters": vehicle["position"]}
    for key, place in places.items():
        lever = float(np.linalg.norm(place, axis=-1).max())
        refuse(lever > size, key, f"a place {lever:g} m from the origin", f"at most {size:.2g} m with this mass and inertia")
    if "added_mass" in vehicle:
        share = vehicle["added_mass"].diagonal()[:3].max() / mass
        refuse(
            share > HEAVY, "added_mass", f"{share:.3g} times the mass", f"at most {HEAVY:g} times", "Check density and length."
        )


def symmetric(matrix: np.ndarray, where: str) -> np.ndarray:
    """The mean of both halves of an added mass, (6, 6); raises `BadInput` where they differ by more than the digits of a table."""
    scale = np.sqrt(np.outer(matrix.diagonal(), matrix.diagonal()))
    unequal = np.abs(matrix - matrix.T) > UNEQUAL * scale
    if unequal.any():
        i, j = np.argwhere(unequal)[0]
        raise BadInput(
            where,
            f"{matrix[i, j]:g} for {AXES[i]} by {AXES[j]} and {matrix[j, i]:g} for {AXES[j]} by {AXES[i]}",
            "a symmetric matrix",
            "A body in ideal water has one. Check signs, or give the mean of both.",
        )
    return 0.5 * (matrix + matrix.T)


def hull_unit(vehicle: Mapping[str, Any]) -> dict[str, Any]:
    """The unit of the hull: only effects that the file has numbers for."""
    n = len(vehicle["position"])
    effects, values = (
        ["coriolis", "restoring", "current"],
        dict[str, Any]({"mass": vehicle["mass"], "start_depth": vehicle["depth"]}),
    )
    values |= {f"inertia_{a}": float(v) for a, v in zip("xyz", vehicle["inertia"], strict=True)}
    values |= {f"centre_of_gravity_{a}": float(v) for a, v in zip("xyz", vehicle["centre_of_gravity"], strict=True)}
    values["restoring"] = {"weight": vehicle["weight"], "buoyancy": vehicle["buoyancy"]} | {
        f"centre_of_buoyancy_{a}": float(v) for a, v in zip("xyz", vehicle["centre_of_buoyancy"], strict=True)
    }
    beside = ~np.eye(3, dtype=bool)
    for key, effect in MATRICES.items():
        if key not in vehicle:
            continue
        m = vehicle[key]
        effects.append(effect)
        values[effect] = dict(zip(AXES, m.diagonal().tolist(), strict=True))
        if np.count_nonzero(m - np.diag(m.diagonal())):
            effects.append(f"{effect}_coupling")
            upper = np.triu_indices(3, 1)
            parts = (
                {"force": m[:3, :3][upper], "mixed": m[:3, 3:], "moment": m[3:, 3:][upper]}
                if key == "added_mass"
                else {
                    "force_by_speed": m[:3, :3][beside],
                    "force_by_rate": m[:3, 3:],
                    "moment_by_speed": m[3:, :3],
                    "moment_by_rate": m[3:, 3:][beside],
                }
            )
            values[f"{effect}_coupling"] = {name: np.ravel(part).tolist() for name, part in parts.items()}
    if n > 6:
        effects.append("further_thrusters")
    return {"component": "RovHull", "effects": effects, "parameters": values | places(vehicle)}


def places(vehicle: Mapping[str, Any]) -> dict[str, Any]:
    """Places and directions of thrusters as parameters of hull and controller; where there are fewer, the defaults stay for the rest."""
    values: dict[str, Any] = {}
    for name, table in (("thruster", vehicle["position"]), ("thruster_direction", vehicle["direction"])):
        for a, column in zip("xyz", table.T, strict=True):
            default = RovController.variables
            filled = [*column.tolist(), *[default[f"{name}_{a}[{i}]"].start for i in range(len(column) + 1, 7)]]
            values[f"{name}_{a}"] = filled[:6]
            if len(column) > 6:
                further = [*column[6:].tolist(), *([default[f"further_thrusters.{name}_{a}[2]"].start] * (8 - len(column)))]
                values.setdefault("further_thrusters", {})[f"{name}_{a}"] = further
    return values


def vehicle_scene(path: Path, sensors: bool = False) -> dict[str, Any]:
    """A scene in which the vehicle of a file keeps its place in a current, as `scene_text` takes it.

    sensors: with noise, bias and lost samples between hull and controller. Gains are those of the small vehicle, scaled so that the
    motion is similar (Froude) for the mass; so are the lag of the thrusters and the current, which are choices of ours.
    """
    vehicle = read_vehicle(path)
    n, ahead, astern = len(vehicle["position"]), T200_THRUST[-1], -T200_THRUST[0]
    limits = vehicle["thrust_ahead"] or ahead, vehicle["thrust_astern"] or vehicle["thrust_ahead"] or astern
    curve = {
        "command": list(T200_COMMAND),
        "thrust": [force * (limits[0] / ahead if force > 0.0 else limits[1] / astern) for force in T200_THRUST],
    }
    ratio = (vehicle["mass"] / DEFAULT_MASS) ** (1.0 / 3.0)
    variables = RovController.variables
    gains = {}
    for gain, power in GAINS.items():
        starts = [v.start * ratio**power for name, v in variables.items() if name.partition("[")[0] == gain]
        gains[gain] = starts if len(starts) > 1 else starts[0]
    control: dict[str, Any] = {"set_depth": vehicle["depth"], **gains, "inverse_curve": curve}
    control |= {"forward_limit": 0.99 * limits[0], "reverse_limit": 0.99 * limits[1]} | places(vehicle)
    further = control.setdefault("further_thrusters", {}) if n > 6 else {}
    control["available"] = [1.0 if i < n else 0.0 for i in range(6)]
    if n > 6:
        further["available"] = [1.0, 1.0 if n > 7 else 0.0]
    command = [f"command[{i}]" if i < 7 else f"further_thrusters.command[{i - 6}]" for i in range(1, n + 1)]
    names = [f"thruster_{i}" for i in range(1, n + 1)]
    pairs = list(zip(names, command, strict=True))
    lag = 0.1 * ratio**0.5  # s, a choice of ours as that of the small vehicle
    units: dict[str, Any] = {"current": {"component": "WaterCurrent", "parameters": {"speed": 0.1 * ratio**0.5}}}
    for name in names:
        values = {"substep": 0.02, "static_curve": curve, "lag": {"time_constant": lag}}
        units[name] = {"component": "Thruster", "effects": ["static_curve", "lag"], "parameters": values}
    units["hull"] = hull_unit(vehicle)
    seen = ["hull.* -> controller.*"]
    if sensors:
        units["sensors"] = {"component": "RovSensors", "effects": ["noise", "bias", "dropout"]}
        seen = ["hull.* -> sensors.*", "sensors.navigation <-> controller.navigation"]
    units["controller"] = {
        "component": "RovController",
        "effects": ["inverse_curve", *["further_thrusters"] * (n > 6)],
        "parameters": control,
    }
    return {
        "title": f"{vehicle['title']} keeps its place in a current",
        "stop_time": 60.0,
        "connections": [
            "current.* -> hull.current.*",
            *seen,
            *(f"controller.{c} -> {t}.command" for t, c in pairs),
            *(f"{t}.thrust -> hull.{c.replace('command', 'thrust')}" for t, c in pairs),
        ],
        "units": units,
        "master": {"step": 0.02, "extrapolation": 0, "order": ["current", *names, "hull", *["sensors"] * sensors, "controller"]},
        "record": {
            "signals": [
                *(f"hull.{n}" for n in ("position_north", "position_east", "depth", "roll", "pitch", "yaw", "attitude_valid")),
                *(f"hull.{n}" for n in NAVIGATION[3:]),
                *(f"controller.error_{a}" for a in ("north", "east", "down", "roll", "pitch", "yaw")),
                *(f"controller.{c}" for c in command),
                "controller.scale",
                *(f"{t}.thrust" for t in names),
            ]
        },
        "analysis": {"system": "rov", "transient": 20.0},
    }
