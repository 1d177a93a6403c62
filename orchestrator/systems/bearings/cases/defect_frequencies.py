"""Lines of the defects of a ball bearing in the envelope of the simulated acceleration, beside those of kinematics."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ....harness.analysis.signals import uniform
from ....harness.analysis.spectra import envelope_spectrum, peak
from ....harness.validation import Evidence, Runs
from ....run.key_results import after_transient
from ....run.results import Result
from ....scene.scene import Scene
from ....units.component import make
from ... import load_scene

RPM = 2.0 * math.pi / 60.0
BAND = (150.0, 4500.0)  # Hz, of the envelope: from below the bearing's own frequencies to where nothing is left
WITHIN = 3.0  # Hz, around the place where a line is looked for; bins are 0.25 Hz wide
SHOWN = 250.0  # Hz
PITS = {"outer": {"width": math.radians(3.0)}, "inner": {"width": math.radians(3.0)}, "ball": {"width": math.radians(10.0)}}
BEARINGS = {"6205": ("6205", 1797.0), "6306": ("JIS 6306", 1800.0)}  # label -> preset, rpm
RUNS = (("6306", ""), ("6306", "outer"), ("6306", "inner"), ("6205", ""), ("6205", "outer"), ("6205", "inner"), ("6205", "ball"))
ACCELERATION = "bearing.acceleration_x"


@dataclass(frozen=True)
class Spectrum:
    """Envelope spectrum of a run's acceleration, and its rms."""

    frequency: np.ndarray  # Hz
    amplitude: np.ndarray  # m/s2
    rms: float  # m/s2

    def line(self, near: float) -> float:
        """Frequency of the highest line near a frequency, Hz."""
        return peak(self.frequency, self.amplitude, near, WITHIN)[0]

    def height(self, near: float) -> float:
        """Amplitude of the highest line near a frequency, m/s2."""
        return peak(self.frequency, self.amplitude, near, WITHIN)[1]

    def highest(self) -> float:
        """Frequency of the highest line of all, Hz; the slow beats below 5 Hz of lines that nearly meet are not looked at."""
        first = int(np.searchsorted(self.frequency, 5.0))
        return self.line(float(self.frequency[first + int(np.argmax(self.amplitude[first:]))]))


def scenes() -> dict[tuple[str, str], Scene]:
    """Bearings without a pit and with one, by bearing and pit."""
    return {(bearing, pit): _scene(bearing, pit) for bearing, pit in RUNS}


def measure(runs: Runs) -> Evidence:
    """Envelope spectra of the runs, and the lines in them."""
    spectra = {k: spectrum(r) for k, r in runs.items()}
    shown = {f"{bearing}, pit: {pit}": runs[bearing, pit] for bearing, pit in (("6306", "outer"), ("6306", "inner"))}
    envelope = f"of the acceleration along the load between {BAND[0]:g} and {BAND[1]:g} Hz, Hann window, 4 s"
    return Evidence(_measured(spectra), shown=shown, settings={"envelope": envelope}, data=_drawn(spectra))


def _scene(bearing: str, pit: str) -> Scene:
    preset, rpm = BEARINGS[bearing]
    parameters: dict[str, float] = {"speed": rpm * RPM, "damping": 2000.0, "clearance.radial_clearance": 2e-6}
    parameters |= {f"{pit}_defect.{n}": v for n, v in {"depth": 5e-6, **PITS[pit]}.items()} if pit else {}
    return load_scene("outer-ring-defect").with_changes({
        "units.bearing.preset": preset,
        "units.bearing.effects": ["clearance", *([f"{pit}_defect"] if pit else [])],
        "units.bearing.parameters": parameters,
        "stop_time": 4.5,
        "master.step": 1e-4,  # 10 kHz: the highest of the bearing's own frequencies is below 1 kHz
        "analysis.transient": 0.5,
    })  # fmt: skip


def spectrum(result: Result) -> Spectrum:
    """The envelope spectrum of a run after its transient."""
    rate, _, (x,) = uniform(result.time, result[ACCELERATION])
    x = x[after_transient(result)][1:]  # 4 s and not one sample more: whole bins of 0.25 Hz
    return Spectrum(*envelope_spectrum(x, rate, *BAND), float(x.std()))


def _expected(bearing: str, pit: str) -> dict[str, float]:
    component: Any = make("bearing", _scene(bearing, pit).units["bearing"])
    return component.geometry.defect_frequencies(BEARINGS[bearing][1] / 60.0)


def _contrast(spectra: dict[tuple[str, str], Spectrum], bearing: str, pit: str) -> float:
    """Height of the pit's line over what stands in its place without the pit."""
    near = (2.0 if pit == "ball" else 1.0) * _expected(bearing, pit)[pit]
    return spectra[bearing, pit].height(near) / max(spectra[bearing, ""].height(near), 1e-300)


def _measured(spectra: dict[tuple[str, str], Spectrum]) -> dict[str, float]:
    fr, near = BEARINGS["6205"][1] / 60.0, _expected("6205", "ball")
    measured = {
        "6205.outer": spectra["6205", "outer"].line(near["outer"]) / fr,
        "6205.inner": spectra["6205", "inner"].line(near["inner"]) / fr,
        "6205.ball": spectra["6205", "ball"].line(2.0 * near["ball"]) / fr,
        "6205.cage": spectra["6205", "ball"].highest() / fr,
    }
    inner, near = spectra["6306", "inner"], _expected("6306", "inner")
    turn = BEARINGS["6306"][1] / 60.0
    beside = [inner.line(near["inner"] + k * turn) for k in (-2, -1, 0, 1, 2)]
    measured |= {f"{bearing}.{pit}.contrast": _contrast(spectra, bearing, pit) for bearing, pit in RUNS if pit}
    return measured | {
        "6306.outer": spectra["6306", "outer"].highest(),
        "6306.turn": inner.highest(),
        "6306.inner": inner.line(near["inner"]),
        "6306.sideband": np.diff(beside).mean(),
        "6306.healthy.rms": spectra["6306", ""].rms,
        "6306.outer.rms": spectra["6306", "outer"].rms,
        "6306.inner.rms": inner.rms,
    }


def _drawn(spectra: dict[tuple[str, str], Spectrum]) -> dict[str, Any]:
    """Of each bearing with a pit the spectrum up to `SHOWN`, and where kinematics puts the lines."""
    drawn: dict[str, Any] = {}
    for bearing, pit in (run for run in RUNS if run[1]):
        spectrum = spectra[bearing, pit]
        cut = spectrum.frequency <= SHOWN
        drawn[f"{bearing}.{pit}.spectrum"] = {f"pit: {pit}": (spectrum.frequency[cut], spectrum.amplitude[cut])}
        for name, f in _lines(bearing, pit).items():
            drawn[f"{bearing}.{pit}.{name}"] = tuple((k * f, f"{k}×") for k in (1, 2, 3) if k * f < SHOWN)
    return drawn


def _lines(bearing: str, pit: str) -> dict[str, float]:
    f = _expected(bearing, pit)
    shaft = BEARINGS[bearing][1] / 60.0
    return {
        "outer": {"ball passes outer race": f["outer"]},
        "inner": {"ball passes inner race": f["inner"], "shaft": shaft},
        "ball": {"twice the ball's spin": 2.0 * f["ball"], "cage": f["cage"]},
    }[pit]
