"""Rows, roll and arcs over all postures: held by torques in runs, and by the kinematics of the component on a grid."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ......components.wrist.kinematics import OPENSIM_HALF, RULES, Axes, inverse, jacobian, pose, row_rotation
from .....harness.validation import Evidence, Runs
from .....run.results import Result
from .....scene.build import unit
from .....scene.scene import Scene
from .... import build_scene

NAME = "paper-wrist"
DEGREES = 180.0 / math.pi
FLEXIONS, DEVIATIONS = np.radians(np.linspace(-60.0, 60.0, 49)), np.radians(np.linspace(-25.0, 20.0, 37))
TILTS = {"15, 45": (15.0, 45.0), "15, 42": (15.0, 42.0), "25, 42": (25.0, 42.0)}  # degrees, of both axes
STANDARD = "15, 45"
HELD = {"flexion": (40.0, 0.0), "extension": (-40.0, 0.0), "radial": (0.0, 15.0), "ulnar": (0.0, -25.0),
        "far flexion": (60.0, 0.0), "far extension": (-60.0, 0.0), "far radial": (0.0, 20.0)}  # fmt: skip
HELD_SIGNALS = ("flexion", "deviation", "roll", "proximal_angle", "proximal_flexion", "distal_flexion")
SMALL = 1.0  # degrees, postures for shares and slopes
PUSHED = ((60.0, 0.0), (-60.0, 0.0), (0.0, 20.0), (0.0, -25.0), (60.0, -25.0), (-60.0, 20.0))  # degrees, far out
MIDDLE = ((20.0, 0.0), (-20.0, 0.0), (0.0, 8.0), (0.0, -8.0))  # degrees
ROLLING = 0.02  # N.m about the long axis of the hand
CALM = {"proximal_damping": 0.2, "distal_damping": 0.2}
SETTLED = 4.0  # s
SIGNS = {"flexion": (1, 1), "extension": (-1, -1), "radial": (1, -1), "ulnar": (-1, 1)}


def scenes() -> dict[str, Scene]:
    """Wrists held in postures, each set of tilts near rest, and wrists with a torque about the long axis of the hand."""
    small = {f"small, {name}": _small_scene(axes(name)) for name in TILTS}
    return {"held": _held_scene(), **small, "rolling": _rolling_scene()}


def measure(runs: Runs) -> Evidence:
    """Roll, its stiffness, the arcs of the proximal row, the distal axis, and what the rows do in four directions."""
    measured: dict[str, float] = {}
    held = _held(runs["held"])
    for name in HELD:
        measured |= {f"roll.{name}": DEGREES * held[name]["roll"], f"proximal.{name}": DEGREES * held[name]["proximal_angle"]}
    for name, (first, second) in SIGNS.items():
        angles = held[name]["proximal_flexion"], held[name]["distal_flexion"]
        measured[f"signs.{name}"] = float(angles[0] * first > math.radians(1.0) and angles[1] * second > math.radians(1.0))
    measured["half.radial"] = DEGREES * held["half radial"]["proximal_flexion"]
    measured["arc.flexion"] = measured["proximal.far flexion"] - measured["proximal.far extension"]
    measured["arc.deviation"] = measured["proximal.far radial"] - measured["proximal.ulnar"]
    measured["arc.ratio"] = measured["arc.flexion"] / measured["arc.deviation"]
    fields = {}
    for name in TILTS:
        fields[name] = rolls = _rolls(axes(name))
        most = float(np.abs(rolls).max())
        largest = max(_rotation(f, d, float(rolls[i, k])) for i, f in enumerate(FLEXIONS) for k, d in enumerate(DEVIATIONS))
        measured |= {f"roll.most.{name}": DEGREES * most, f"roll.share.{name}": 100.0 * most / largest}
        measured |= {f"{what}.{name}": v for what, v in zip(("s", "p", "slope"), _small(runs[f"small, {name}"]), strict=True)}
    measured |= _arc() | _distal_axis() | _roll_stiffness(runs["rolling"])
    flexes = ("proximal_flexion", "distal_flexion", "roll")
    drawn = {
        "roll": (DEGREES * FLEXIONS, DEGREES * DEVIATIONS, DEGREES * fields[STANDARD].T),
        "held.flexion": [flexion for flexion, _ in HELD.values()],
        "held.deviation": [deviation for _, deviation in HELD.values()],
        "rows": [(n, *(round(DEGREES * held[n][s], 2) for s in flexes)) for n in HELD],
    }
    return Evidence(measured, data=drawn)


def axes(name: str) -> Axes:
    """Axes of a set of tilts."""
    first, second = TILTS[name]
    return Axes(RULES, math.radians(first), math.radians(second), 0.02)


def wrist(
    torques: Sequence[float] | np.ndarray, parameters: Mapping[str, Any] = CALM, effects: Sequence[str] = ("morphology",)
) -> dict[str, Any]:
    """A unit under torques in flexion and deviation, N.m."""
    return unit("Wrist", effects=effects, tau_flexion=float(torques[0]), tau_deviation=float(torques[1]), **parameters)


def held_scene(units: Mapping[str, Any], signals: Sequence[str], stop: float = SETTLED) -> Scene:
    """Wrists side by side, until they rest."""
    record = {"signals": [f"{u}.{s}" for u in units for s in signals], "interval": stop}
    return build_scene(units, stop_time=stop, step=0.02, name=NAME, title="Wrists held by torques", record=record)


def _held_scene() -> Scene:
    """With 1 N.m/rad a torque is the angle it holds."""
    units = {f"w{k}": wrist(np.radians(angles)) for k, angles in enumerate(HELD.values())}
    units["half"] = wrist(np.radians(HELD["radial"]), {**CALM, "coupling_model": "opensim_half"})
    return held_scene(units, HELD_SIGNALS)


def _held(result: Result) -> dict[str, dict[str, float]]:
    """Angles at the end, rad, by posture and signal."""
    return {
        name: {s: float(result[f"{wrist}.{s}"][-1]) for s in HELD_SIGNALS}
        for wrist, name in zip(result.scene.units, (*HELD, "half radial"), strict=True)
    }


def _rolls(at: Axes) -> np.ndarray:
    """Roll over the postures, (flexions, deviations), rad."""
    return np.array([[inverse(f, d, at)[2] for d in DEVIATIONS.tolist()] for f in FLEXIONS.tolist()])


def _rotation(flexion: float, deviation: float, roll: float) -> float:
    """Angle of the hand's whole rotation, rad, from its trace: Rz Rx Ry."""
    c, s = (np.cos([flexion, deviation, roll]), np.sin([flexion, deviation, roll]))
    trace = c[0] * c[2] - s[0] * s[1] * s[2] + c[0] * c[1] + c[1] * c[2]
    return math.acos(max(-1.0, min(1.0, 0.5 * (float(trace) - 1.0))))


def _small_scene(at: Axes) -> Scene:
    """A wrist in flexion, one in radial deviation, and one whose distal row moves alone."""
    small = math.radians(SMALL)
    given = {**CALM, "morphology.proximal_tilt": at.proximal_tilt, "morphology.distal_tilt": at.distal_tilt}
    # of the last one: J^T e = (q2 component along both axes), so that q1 stays zero
    alone = {"distal_torque": small, "proximal_torque": small * math.cos(at.proximal_tilt + at.distal_tilt)}
    units = {
        "flexion": wrist((small, 0.0), given),
        "radial": wrist((0.0, small), given),
        "ahead": wrist((0.0, 0.0), {**given, **alone}),
    }
    return held_scene(units, ("flexion", "deviation", "proximal_flexion", "proximal_angle"))


def _small(result: Result) -> tuple[float, float, float]:
    """(proximal share in flexion, proximal flexion per radial deviation, slope of the path of no proximal motion)."""

    def value(wrist: str, name: str) -> float:
        return float(result[f"{wrist}.{name}"][-1])

    return (
        value("flexion", "proximal_flexion") / value("flexion", "flexion"),
        value("radial", "proximal_flexion") / value("radial", "deviation"),
        abs(value("ahead", "deviation") / value("ahead", "flexion")),
    )


def _arc() -> dict[str, float]:
    """Largest angle, degrees, of the proximal row's axis of rotation to its main direction: rules, and halves as a control."""
    measured = {}
    for name, at in (("rules", axes(STANDARD)), ("half", Axes(OPENSIM_HALF, 0.0, 0.0, 0.0))):
        turning = []
        for f in FLEXIONS[::4].tolist():
            for d in DEVIATIONS[::4].tolist():
                q1, q2, _ = inverse(f, d, at)
                turned = np.array(row_rotation(q1, q2, at)[1:])
                if np.linalg.norm(turned) > 0.02:  # of a row that hardly turns there is no axis
                    turning.append(turned / np.linalg.norm(turned))
        directions = np.array(turning)
        main = np.linalg.svd(directions)[2][0]
        measured[f"axis.{name}"] = DEGREES * float(np.arccos(np.clip(np.abs(directions @ main), 0.0, 1.0)).max())
    return measured


def _distal_axis() -> dict[str, float]:
    """Largest turn of the distal axis out of its place at rest, and its difference from 2 asin(sin(e_p + e_d) sin(q1 / 2))."""
    at = axes(STANDARD)
    rest = np.array(pose(0.0, 0.0, at).hand_2)
    crossing = math.sin(at.proximal_tilt + at.distal_tilt)
    turns, errors = [], []
    for f in FLEXIONS.tolist():
        for d in (DEVIATIONS[0], 0.0, DEVIATIONS[-1]):
            q1, q2, _ = inverse(f, float(d), at)
            turn = 2.0 * math.asin(0.5 * float(np.linalg.norm(np.array(pose(q1, q2, at).hand_2) - rest)))
            turns.append(turn)
            errors.append(abs(turn - 2.0 * math.asin(crossing * abs(math.sin(0.5 * q1)))))
    return {"distal.turn": DEGREES * max(turns), "distal.error": DEGREES * max(errors)}


def _rolling_scene() -> Scene:
    """Two wrists in each posture, with a torque about the long axis of the hand either way."""
    at = axes(STANDARD)
    units = {}
    for k, angles in enumerate(np.radians(PUSHED + MIDDLE)):
        q1, q2, _ = inverse(float(angles[0]), float(angles[1]), at)
        by_roll = jacobian(q1, q2, at)[2]
        for sign in (-1.0, 1.0):
            more = {"proximal_torque": sign * ROLLING * float(by_roll[0]), "distal_torque": sign * ROLLING * float(by_roll[1])}
            units[f"w{k}_{'less' if sign < 0.0 else 'more'}"] = wrist(
                angles, {**CALM, **more, "start_proximal_angle": q1, "start_distal_angle": q2}
            )
    return held_scene(units, ("roll",))


def _roll_stiffness(result: Result) -> dict[str, float]:
    """Least torque about the long axis per roll over the passive stiffness, 1 N.m/rad, far out and in the middle."""
    rolls = [float(result[f"w{k}_more.roll"][-1] - result[f"w{k}_less.roll"][-1]) for k in range(len(PUSHED + MIDDLE))]
    stiffness = [2.0 * ROLLING / abs(r) for r in rolls]
    return {"roll.stiffness": min(stiffness[: len(PUSHED)]), "roll.stiffness.middle": min(stiffness[len(PUSHED) :])}
