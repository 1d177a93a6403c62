"""The inertial converter in full, with crank, lever and clutches, against its mean over a revolution."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ....derivatives.trim import SteadyState, trim
from ....harness.validation import Evidence, Runs
from ....run.results import Result
from ....scene.build import unit
from ....scene.scene import Scene
from ... import build_scene

TURN = 2.0 * math.pi
# the example of the held speeds and of the loads
EXAMPLE: dict[str, Any] = {"gear_ratio": 1.0, "lever_mass": 4.0, "slider_mass": 0.05, "lever_ratio": 1.0, "crank_radius": 0.03,
                           "clutch_arm": 0.05, "substep": 1e-3}  # fmt: skip
STALL = 2.0 / math.pi * 0.05 * 4.0 * 2.0 * 0.03  # k1, kg m²
LARGEST = 4.0 * 2.0 * 0.03 / (4.05 * 0.05)  # w2 / w1
CRANKS, SHARES = (10.0, 20.0), (0.01, 0.25, 0.5, 0.75, 0.95)
FLYWHEEL = 1e6  # kg m², holds a speed to 1e-6 and leaves it to be read as a torque
SEEN, STARTED, REVOLUTIONS = 100, 2, 12  # instants a revolution of a held crank; revolutions left out, and in all
LOADS = (0.5, 1.0, 2.0)  # N.m
WINDS, LOAD, START = (2.0, 2.5, 3.0, 6.0), 13.2435, (2.5, 2.0)  # m/s, N.m, rad/s
SWING, PUSH = 3.0, 1.15  # m/s, of the wind in which the turbine is let go at so many times its speed
STEP = 5e-3  # s; the shaft between turbine and crank begins to vibrate with 9 ms
SETTLED = 8.0  # s
GEAR, ARM, CRANK_INERTIA = 6.0, 0.05, 1.0 + 0.5 * 20.0 * 0.1**2  # of the defaults; m; J1 + m a² r² / 2, kg m²


def scenes() -> dict[str, Scene]:
    """Every run by its name."""
    points = {wind: speeds(state) for wind, state in operating_points(WINDS).items()}
    cranks = {f"crank held at {w:g} rad/s": held(w, {_name(s): s * LARGEST * w for s in SHARES}, EXAMPLE) for w in CRANKS}
    return {
        **cranks,
        **{f"held, {v:g} m/s": held(x[0], {"point": x[1]}, {}) for v, x in points.items()},
        **{f"{T:g} N.m": loaded(T) for T in LOADS},
        **{f"{v:g} m/s": in_wind(v, *x) for v, x in points.items()},
        "swing": in_wind(SWING, *(points[SWING] * (PUSH, 1.0))),
    }


def measure(runs: Runs) -> Evidence:
    """Torques at held speeds, speeds under load and in the wind, and the swing back to the operating point."""
    measured: dict[str, float] = {}
    for w in CRANKS:
        measured |= _at_held_speeds(runs[f"crank held at {w:g} rad/s"], w)
    low, high = (measured[f"torque.20.{s:g}"] for s in SHARES[-2:])
    measured["largest"] = 20.0 * LARGEST * (SHARES[-1] + (SHARES[-1] - SHARES[-2]) * high / (low - high))
    measured |= {f"loaded.{T:g}": mean(runs[f"{T:g} N.m"], "converter.speed", 30.0) for T in LOADS}
    for v in WINDS:
        measured[f"balance.{v:g}"] = mean_torques(runs[f"held, {v:g} m/s"], "point")[0]
        measured[f"turbine.{v:g}"] = mean(runs[f"{v:g} m/s"], "turbine.speed", SETTLED)
        measured[f"pump.{v:g}"] = mean(runs[f"{v:g} m/s"], "converter.speed", SETTLED)
    back, expected = returning(runs["swing"]), expected_return()
    measured |= {"decay": -back.real, "swing": back.imag}
    winds = np.linspace(WINDS[0], WINDS[-1], 17)
    line = list(operating_points(winds.tolist()).values())
    turbine, pump = np.array([speeds(state) for state in line]).T
    growths = np.array([np.repeat(eigenvalues(state).real, 2)[:2] for state in line]).T
    drawn = {
        "winds": winds,
        "averaged.turbine": turbine,
        "averaged.pump": pump,
        "growths": {f"eigenvalue {k + 1}": growth for k, growth in enumerate(growths)},
        "expected": _pair(expected),
        "seen": _pair(back),
    }
    return Evidence(measured, data={**drawn, **_revolutions(runs["3 m/s"])})


def _at_held_speeds(result: Result, crank: float) -> dict[str, float]:
    """Mean torque over that at stall, power taken over power given, and the stall torque."""
    torque = np.asarray(result["stalled.driving_torque"])  # |sin|, with its corners at even samples: Simpson's rule
    weights = np.r_[1.0, np.tile([4.0, 2.0], torque.size // 2)]
    weights[-1] = 1.0
    measured = {f"stall.{crank:g}": float(np.average(torque, weights=weights))}
    for s in SHARES:
        driving, braking = mean_torques(result, _name(s))
        measured[f"torque.{crank:g}.{s:g}"] = driving / (STALL * crank**2)
        measured[f"power.{crank:g}.{s:g}"] = braking / (driving * s * LARGEST)
    return measured


def _name(share: float) -> str:
    return f"percent_{100.0 * share:.0f}"


def held(turbine: float, speeds: Mapping[str, float], parameters: Mapping[str, float]) -> Scene:
    """Converters whose flywheels hold the crank behind a turbine, and each its driven shaft, at a speed in rad/s.

    Beside them one is stalled by its load.
    """
    period = TURN / (turbine * parameters.get("gear_ratio", GEAR))
    given: dict[str, Any] = {**parameters, "crank_inertia": FLYWHEEL, "driven_inertia": FLYWHEEL, "shaft_stiffness": 1e-3,
                             "shaft_damping": 0.0, "turbine_speed": turbine}  # fmt: skip
    units = {name: unit("InertialConverter", **given, start_speed=speed) for name, speed in speeds.items()}
    units["stalled"] = unit("InertialConverter", **given, load_torque=1e3)
    return build_scene(
        units,
        stop_time=REVOLUTIONS * period,
        step=period / SEEN,
        name="inertial-converter",
        title=f"Converters held by flywheels, turbine at {turbine:g} rad/s",
        record={"signals": [f"{name}.{signal}" for name in units for signal in ("speed", "crank_speed", "driving_torque")]},
    )


def loaded(torque: float) -> Scene:
    """The example behind a turbine of constant speed, under a load, near the speed of its equilibrium."""
    speed = 20.0 * LARGEST * (1.0 - torque / (STALL * 400.0))
    return build_scene(
        {"converter": unit("InertialConverter", **EXAMPLE, turbine_speed=20.0, load_torque=torque, start_speed=speed)},
        stop_time=160.0 * TURN / 20.0,
        step=TURN / 20.0 / 20.0,
        name="inertial-converter",
        title=f"Converter under {torque:g} N.m",
        record={"signals": ["converter.speed"]},
    )


def in_wind(wind: float, turbine: float, pump: float, converter: str = "InertialConverter", inertia: float = 15.0) -> Scene:
    """Farm windmill and converter of the defaults in a steady wind from given speeds, under a load that does not pulsate."""
    return build_scene(
        {
            "turbine": unit("WindTurbine", preset="farm windmill", wind=wind, start_speed=turbine, inertia=inertia),
            "converter": unit(converter, load_torque=LOAD, start_speed=pump),
        },
        {"turbine.speed": "converter.turbine_speed", "converter.turbine_torque": "turbine.torque"},
        stop_time=24.0,
        step=STEP,
        name="inertial-converter",
        master={"extrapolation": 1, "bonds": ["turbine.speed * converter.turbine_torque"]},
        title=f"Inertial converter in a wind of {wind:g} m/s",
    )


def operating_points(winds: Sequence[float], inertia: float = 15.0) -> dict[float, SteadyState]:
    """Steady states of the same with the averaged converter, by the wind in m/s."""
    scene = in_wind(winds[0], *START, "AveragedConverter", inertia)
    states = trim(scene, over=("turbine.wind", winds), outputs=["turbine.speed"])
    return {wind: state for wind, state in states.points if wind is not None}


def speeds(state: SteadyState) -> np.ndarray:
    """Of turbine and driven shaft, rad/s."""
    return np.array([state.outputs["turbine.speed"], state.outputs["converter.speed"]])


def eigenvalues(state: SteadyState) -> np.ndarray:
    """Of both speeds, 1/s, the least damped first, of a pair that with a positive imaginary part; not those of samples."""
    assert state.linear is not None
    return np.array([mode.rate for mode in state.linear.modes() if mode.kind == "coupling"])


def expected_return() -> complex:
    """Eigenvalue of the averaged set in the wind of the swing; crank and lever, in the mean, turn with the turbine."""
    (state,) = operating_points([SWING], 15.0 + GEAR**2 * CRANK_INERTIA).values()
    return complex(eigenvalues(state)[0])


def mean_torques(result: Result, unit: str) -> tuple[float, float]:
    """Mean torque on the driven shaft and on the crank in all but the first revolutions, from what flywheels gained."""
    first = STARTED * SEEN
    span = float(result.time[-1] - result.time[first])
    gained = [float(result[f"{unit}.{name}"][-1] - result[f"{unit}.{name}"][first]) for name in ("speed", "crank_speed")]
    return FLYWHEEL * gained[0] / span, -FLYWHEEL * gained[1] / span


def mean(result: Result, signal: str, begin: float) -> float:
    """Mean from `begin` (s) on, weighted by a window that leaves no share of a broken revolution."""
    values = np.asarray(result[signal])[result.time >= begin]
    return float(np.average(values, weights=np.hanning(values.size)))


def returning(result: Result) -> complex:
    """Eigenvalue of the motion of both speeds from 1.5 s to 9 s, the pulsation of the revolutions smoothed away.

    The linear map that takes the speeds a quarter of a second on is fitted; its eigenvalue is exp(lambda d).
    """
    window = np.hanning(241)
    window /= window.sum()
    smooth = np.array([np.convolve(result[f"{unit}.speed"], window, mode="same") for unit in ("turbine", "converter")]).T
    ahead = 50
    seen = smooth[(result.time > 1.5) & (result.time < 9.0)]
    before = np.column_stack((seen[:-ahead], np.ones(len(seen) - ahead)))
    matrix = np.linalg.lstsq(before, seen[ahead:], rcond=None)[0][:2]
    eigenvalues = np.log(np.linalg.eigvals(matrix).astype(complex)) / (ahead * STEP)
    return complex(max(eigenvalues, key=lambda value: value.imag))


def _pair(value: complex) -> str:
    return f"{value.real:.3f} ± {abs(value.imag):.3f} i"


def _revolutions(result: Result) -> dict[str, Any]:
    """The last two revolutions of a run: when the slider drives, and what it passes on."""
    turned, slider, speed, torque = (
        np.asarray(result[f"converter.{name}"]) for name in ("crank_angle", "slider_velocity", "speed", "driving_torque")
    )
    begin = math.floor(turned[-1] / TURN) - 2.0
    last = (turned / TURN >= begin) & (turned / TURN <= begin + 2.0)
    forwards = ARM * speed[last]
    return {
        "revolution": turned[last] / TURN - begin,
        "lever": {"lever's guided end": slider[last]},
        "clutches": {"clutch forwards": forwards, "clutch backwards": -forwards},
        "torque": torque[last],
        "load": np.full(forwards.size, LOAD),
    }
