"""Example 5.9.1 of Friswell et al.: whirl frequencies and critical speeds, from the matrices and from the motion in time."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from .....components.rotor.beam import BeamRotor
from .....components.rotor.modal import campbell, critical_speeds, modes
from ....harness.analysis.spectra import peak
from ....harness.validation import Evidence, Runs
from ....run.results import Result
from ....scene.build import unit
from ....scene.scene import Scene
from ... import build_scene

RPM = math.pi / 30.0  # rad/s
SPEEDS = (1000.0, 4000.0)  # rpm
MODES = 6
STEP, DURATION = 5e-4, 20.0  # s; a line of the spectrum is 0.3 rad/s wide, and a parabola through it finds a hundredth of it
CRITICAL = 5  # synchronous critical speeds below the flight of the third forward mode


def scenes() -> dict[str, Scene]:
    """The free whirl at each speed."""
    return {f"{rpm:g} rpm": scene(rpm * RPM) for rpm in SPEEDS}


def measure(runs: Runs) -> Evidence:
    """Rows by speed: `modal` from the matrices at rest and running, `motion` from the free whirl after a sudden start."""
    rotor = BeamRotor(preset="Friswell 5.9.1")
    rotor.initialize(0.0)
    matrices = rotor.matrices()
    whirl = {rpm: modes(matrices, rpm * RPM, MODES) for rpm in (0.0, *SPEEDS)}
    lines = {
        rpm: whirl_lines(runs[f"{rpm:g} rpm"], np.where(whirl[rpm].direction < 0, -1.0, 1.0) * whirl[rpm].frequency)
        for rpm in SPEEDS
    }
    measured = {f"modal.{rpm:g}.{k}": w for rpm in whirl for k, w in enumerate(whirl[rpm].frequency, 1)}
    measured |= {f"motion.{rpm:g}.{k}": abs(w) for rpm in SPEEDS for k, w in enumerate(lines[rpm], 1)}
    measured |= {f"critical.{k}": w for k, w in enumerate(critical_speeds(matrices)[:CRITICAL], 1)}
    return Evidence(measured, data=_diagram(matrices, lines))


def scene(speed: float) -> Scene:
    """The example at constant speed with an unbalance at the first disk; it starts straight and whirls freely, undamped."""
    given: dict[str, Any] = {"start_speed": speed, "substep": 2e-5, "unbalance": {"moment": [1e-4]}}
    rotor = unit("BeamRotor", preset="Friswell 5.9.1", effects=["unbalance"], **given)
    title = f"Friswell, example 5.9.1, at {speed / RPM:.0f} rpm"
    record = {"signals": ["rotor.displacement_x", "rotor.displacement_y"]}
    return build_scene({"rotor": rotor}, stop_time=DURATION, step=STEP, name="friswell-5.9.1", title=title, record=record)


def whirl_lines(result: Result, near: np.ndarray) -> np.ndarray:
    """Frequencies of the lines nearest to given ones, rad/s; negative: backward whirl."""
    z = result["rotor.displacement_x"] + 1j * result["rotor.displacement_y"]
    half = z.size // 2
    frequency = 2.0 * np.pi * np.arange(half) / (z.size * STEP)
    forward, backward = (np.abs(np.fft.fft(part * np.hanning(z.size)))[:half] for part in (z, z.conj()))
    return np.array([math.copysign(peak(frequency, forward if w > 0.0 else backward, abs(w), 3.0)[0], w) for w in near])


def _diagram(matrices, lines: Mapping[float, np.ndarray]) -> dict[str, Any]:
    """What the diagram shows: without gyroscopic moments, there is neither forward nor backward whirl."""
    speed = np.linspace(0.0, 4500.0, 91)
    frequency, direction = campbell(matrices, speed * RPM, MODES)
    drawn: dict[str, Any] = {"speed": speed[[0, -1]]}
    for sign, name in ((1, "forward"), (-1, "backward")):
        columns = np.flatnonzero(direction[-1] == sign)
        x, y = ([v for k in columns for v in (*values(k), np.nan)] for values in (lambda k: speed, lambda k: frequency[:, k]))
        points = [(rpm, abs(w)) for rpm, frequencies in lines.items() for w in frequencies if np.sign(w) == sign]
        drawn[f"{name}.lines"] = {f"{name}, from the matrices": (x, y)} if x else {}
        drawn[f"{name}.points"] = {f"{name}, from the motion": tuple(zip(*points, strict=True))} if x else {}
    return drawn
