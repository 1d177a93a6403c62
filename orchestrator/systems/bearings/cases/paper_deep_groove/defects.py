"""Pits of both races: their lines in the envelope of the acceleration, harmonics, sidebands; and a bearing without pits."""

from __future__ import annotations

import math

import numpy as np

from .....harness.analysis.spectra import envelope_spectrum, peak
from .....harness.validation import Evidence, Runs
from .....run.results import Result
from .....scene.scene import Scene
from .shaft import acceleration, bearing, scene

TURNS = 30.0  # per second
STEP = 5e-5  # s, a fourteenth of the passage of a ball over a pit
TRANSIENT, SEEN = 0.5, 4.0  # s
BAND = (150.0, 4500.0)  # Hz
BIN = 1.0 / SEEN
NEIGHBOURS = 20  # bins to each side, whose median is the level beside a line
GEOMETRY = {"ball_diameter": 9.525e-3, "pitch_diameter": 46e-3}  # 6206, from memory
PIT = {"depth": 5e-6, "width": math.radians(3.0)}
POSITIONS = {"outer": -0.5 * math.pi, "inner": 0.0}  # of the outer race: where the load is
SHOWN = 600.0  # Hz
Spectrum = tuple[np.ndarray, np.ndarray]


def scenes() -> dict[str, Scene]:
    """The shaft at 1800 rpm without clearance, by the race that has a pit: none, the outer, the inner one."""
    return {pit: passing(pit) for pit in ("", *POSITIONS)}


def measure(runs: Runs) -> Evidence:
    """Lines, harmonics and sidebands in the envelopes of the acceleration."""
    spectra = {pit: envelope(result) for pit, result in runs.items()}
    expected = bearing((), **GEOMETRY).geometry.defect_frequencies(TURNS)
    measured: dict[str, float] = {}
    for pit in POSITIONS:
        f, a = spectra[pit]
        near = expected[pit]
        measured[f"{pit}.line"] = peak(f, a, near, 3.0)[0] / TURNS
        measured[f"{pit}.clear"] = min(clearness(f, a, k * near) for k in (1, 2, 3))
        measured[f"{pit}.control"] = height(f, a, near) / height(*spectra[""], near)
        carrier = height(f, a, near)
        sides = [height(f, a, near + k * TURNS) / carrier for k in (-2, -1, 1, 2)]
        measured |= {
            f"{pit}.first": 0.5 * (sides[1] + sides[2]),
            f"{pit}.first.least": min(sides[1:3]),
            f"{pit}.second.least": min(sides[0], sides[3]),
        }
        measured[f"{pit}.largest.db"] = 20.0 * math.log10(max(max(sides), 1e-300))
    harmonics = [k * expected["outer"] for k in (2, 3)]
    measured["harmonics.control"] = max(height(*spectra[""], f) / height(*spectra["outer"], f) for f in harmonics)
    cut = {pit: (f[f <= SHOWN], a[f <= SHOWN]) for pit, (f, a) in spectra.items()}
    marks = {f"{pit}.lines": [(k * expected[pit], f"{k}×") for k in (1, 2, 3) if k * expected[pit] < SHOWN] for pit in POSITIONS}
    return Evidence(
        measured, data={**{pit: {f"pit: {pit}": cut[pit]} for pit in POSITIONS}, **marks, "none": {"no pit": cut[""]}}
    )


def passing(pit: str) -> Scene:
    """The shaft with a pit in the race of that name, or with none."""
    parameters = dict(GEOMETRY)
    if pit:
        parameters |= {f"{pit}_defect.{n}": v for n, v in {**PIT, "position": POSITIONS[pit]}.items()}
    effects = [f"{pit}_defect"] if pit else []
    return scene(TRANSIENT + SEEN, STEP, TURNS, effects, parameters=parameters)


def envelope(result: Result) -> Spectrum:
    """(frequency in Hz, amplitude in m/s2) of the envelope of the acceleration along the load after the transient."""
    kept = result.time > TRANSIENT + 0.5 * STEP
    return envelope_spectrum(acceleration(result, "y")[kept], 1.0 / STEP, *BAND)


def height(f: np.ndarray, a: np.ndarray, near: float) -> float:
    """Amplitude of the line at a frequency, within two bins of it."""
    return peak(f, a, near, 2.0 * BIN)[1]


def clearness(f: np.ndarray, a: np.ndarray, near: float) -> float:
    """Height of a line over the median of its neighbours, dB."""
    k = round(near / BIN)
    return 20.0 * math.log10(height(f, a, near) / float(np.median(a[k - NEIGHBOURS : k + NEIGHBOURS + 1])))
