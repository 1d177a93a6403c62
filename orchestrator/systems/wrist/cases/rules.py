"""The wrist's rules: what the rows do in every posture, roll, isometric ligaments, reciprocity, decay of energy."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ....harness.validation import Evidence, Runs
from ....run.results import Result
from ....scene.build import unit
from ....scene.scene import Scene
from ... import build_scene, load_scene
from .. import WristKeys
from ..records import postures, wrists

DEGREES = 180.0 / math.pi
# posture -> flexion, radial deviation in degrees; the torques that hold them are those of a stiffness of 1 N.m/rad
HELD = {"flexion": (40.0, 0.0), "extension": (-40.0, 0.0), "radial": (0.0, 15.0), "ulnar": (0.0, -25.0)}
OTHER_TILTS = {"morphology": {"proximal_tilt": math.radians(10.0), "distal_tilt": math.radians(35.0)}}
BIAS, STEP = (0.4, -0.2), 2e-3  # N.m: about which, and by which the torques are changed for the compliance
SETTLED = 5.0  # s
CALM: dict[str, Any] = {"proximal_damping": 0.05, "distal_damping": 0.05}  # N.m.s/rad, with which they rest after that time
HAND = ("flexion", "deviation", "roll", "proximal_angle", "distal_angle", "proximal_flexion", "distal_flexion")


def measure(runs: Runs) -> Evidence:
    """Wrists at rest under held torques, one that swings out with its ligaments, and the scene moved by muscles."""
    held, compliance, swing, moved = runs.values()
    measured: dict[str, float] = {}
    for wrist in ("flexion", "extension", "radial", "ulnar", "ulnar_other", "half_flexion", "half_radial"):
        measured |= {f"{wrist}.{n}": DEGREES * held[f"{wrist}.{n}"][-1] for n in HAND}
    measured["roll.largest"] = max(abs(measured[f"{wrist}.roll"]) for wrist in HELD)
    measured["half.share"] = measured["half_flexion.proximal_flexion"] / measured["half_flexion.flexion"]
    crossed = [_slope(compliance, "deviation", "flexion"), _slope(compliance, "flexion", "deviation")]
    measured["reciprocity"] = crossed[0] / crossed[1]
    measured["reciprocity.size"] = abs(crossed[0]) / _slope(compliance, "flexion", "flexion")
    energy = swing["wrist.mechanical_energy"] + swing["ligaments.stored_energy"]
    heat = swing["wrist.dissipation"] + swing["ligaments.dissipation"]
    lost = float(np.sum(0.5 * (heat[1:] + heat[:-1]) * np.diff(swing.time)))
    measured["energy.rise"] = float(np.diff(energy).max())
    measured["energy.balance"] = lost / float(energy[0] - energy[-1])
    measured["strain.isometric"] = max(float(np.abs(swing[f"isometric.strain[{i}]"]).max()) for i in range(1, 6))
    measured["strain.beside"] = max(float(np.abs(swing[f"ligaments.strain[{i}]"]).max()) for i in range(1, 6))
    (record,) = wrists(moved)
    for p in postures(record, moved.scene.analysis_as(WristKeys).postures):
        name = f"kept.{p.name}"
        measured[name] = min(measured.get(name, 1.0), float(p.rule is True))
    measured["roll.moved"] = DEGREES * float(np.abs(record.signals["roll"]).max())
    drawn = {
        f"{kind}.{row}": [measured[f"{prefix}{unit}.{row}_flexion"] for unit in units]
        for kind, prefix, units in (("rules", "", HELD), ("half", "half_", ("flexion", "radial")))
        for row in ("proximal", "distal")
    }
    angles = [(unit, *(round(measured[f"{unit}.{n}"], 3) for n in ("proximal_angle", "distal_angle", "roll"))) for unit in HELD]
    return Evidence(measured, data={**drawn, "angles": angles})


def scenes() -> dict[str, Scene]:
    """Postures held by torques; four torques about one of them; a wrist that swings with its ligaments; the shipped scene."""
    torques = {name: [math.radians(v) for v in angles] for name, angles in HELD.items()}
    units = {name: _wrist(held, CALM) for name, held in torques.items()}
    units["ulnar_other"] = _wrist(torques["ulnar"], CALM | OTHER_TILTS)
    units |= {f"half_{name}": _wrist(torques[name], CALM | {"coupling_model": "opensim_half"}) for name in ("flexion", "radial")}
    held = _scene(units, [f"{u}.{n}" for u in units for n in HAND], SETTLED, 0.02)
    near = {}
    for i, name in enumerate(("flexion", "deviation")):
        for sign in (-1.0, 1.0):
            torque = [b + sign * STEP * (j == i) for j, b in enumerate(BIAS)]
            near[f"{name}_{'less' if sign < 0.0 else 'more'}"] = _wrist(torque, CALM, ("morphology", "constraint"))
    compliance = _scene(near, [f"{u}.{n}" for u in near for n in HAND[:2]], SETTLED, 0.02)
    swinging = {
        "wrist": _wrist((0.0, 0.0), {"start_proximal_angle": 0.6, "start_distal_angle": -0.3}),
        "ligaments": unit("LigamentBundle", damping=0.02),
        "isometric": unit("LigamentBundle", off_axis=[0.0] * 5),
    }
    signals = [*(f"wrist.{n}" for n in (*HAND, "mechanical_energy", "dissipation")), "ligaments.stored_energy",
               "ligaments.dissipation", "ligaments.strain", "isometric.strain"]  # fmt: skip
    swing = _scene(swinging, signals, 2.0, 5e-4, ("wrist.* -> ligaments.*", "ligaments.* -> wrist.*", "wrist.* -> isometric.*"))
    return {"held postures": held, "compliance": compliance, "swing": swing, "moved by muscles": load_scene("wrist-motion")}


def _wrist(torques: Sequence[float], parameters: Mapping[str, Any], effects: Sequence[str] = ("morphology",)) -> dict[str, Any]:
    return unit("Wrist", effects=effects, tau_flexion=torques[0], tau_deviation=torques[1], **parameters)


def _scene(units: dict[str, Any], signals: list[str], stop: float, step: float, connections: tuple[str, ...] = ()) -> Scene:
    analysis = {"system": "wrist"} if connections else {"system": "wrist", "postures": [stop]}
    return build_scene(
        units,
        connections,
        stop_time=stop,
        step=step,
        name="wrist-rules",
        title="Wrists",
        master={"extrapolation": 1} if connections else {},
        record={"signals": signals},
        analysis=analysis,
    )


def _slope(result: Result, angle: str, torque: str) -> float:
    """Change of an angle by a torque of the hand, rad/(N.m), by central differences."""
    more, less = (float(result[f"{torque}_{way}.{angle}"][-1]) for way in ("more", "less"))
    return (more - less) / (2.0 * STEP)
