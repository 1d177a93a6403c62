"""Waviness of the rotating and of the fixed ring: the lines of each order, what the balls hide, and what a preload removes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .....harness.analysis.signals import amplitude_at, amplitude_spectrum
from .....harness.analysis.spectra import peak
from .....harness.validation import Evidence, Runs
from .....run.results import Result
from .....scene.scene import Scene
from .shaft import BALL_PASS, BALLS, LENGTH, scene

TURNS = 2.4  # per second: ten times of them lie below a tenth of the lower natural frequency
STEP, INTERVAL = 1e-4, 1e-3  # s
TRANSIENT, SEEN = 0.5, 5.0  # s; 12 turns, bins of 0.2 Hz
AMPLITUDE = 0.01 * LENGTH  # m
ORDERS = tuple(range(2, BALLS + 2))
LOW = tuple(range(2, BALLS - 1))  # whose lines are at order times the speed
PLACES = 8  # for orders, that the effect has
ALL = ORDERS[:PLACES]
PRELOAD = 200.0  # N axial, as much as the weight, beside no radial load: a shaft that stands upright
LARGER = (2.0, 4.0)  # times the amplitude, for the second harmonic
BIN = 1.0 / SEEN
ALONG_ACROSS = {"along": {2: 0.5211, 3: 0.1111, 4: 0.0474}, "across": {2: 1.0421, 3: 0.3333, 4: 0.1895}}  # many balls
SHOWN = 30.0  # Hz


def scenes() -> dict[str | int, Scene]:
    """One scene for each order, some for several orders and for larger waves, and perfect rings, under the weight and preloaded."""
    return {
        "perfect": waves((), True),
        **{k: waves((k,), True) for k in ORDERS},
        "outer": waves(ALL, True, "outer"),
        **{f"{n:g} times": waves((2,), True, times=n) for n in LARGER},
        "perfect, preloaded": waves((), False),
        "preloaded": waves(LOW, False),
    }


def measure(runs: Runs) -> Evidence:
    """Lines in the difference of the motion from that of perfect rings, over the amplitude of the waves."""
    perfect = runs["perfect"]
    inner = {k: difference(runs[k], perfect) for k in ORDERS}
    measured: dict[str, float] = {}
    for k, away in inner.items():
        measured |= {f"line.{k}.{axis}": line(x, k * TURNS) for axis, x in away.items()}
    measured["off"] = max(abs(place(inner[k]["across"], k * TURNS) - k * TURNS) / BIN for k in LOW)
    measured["nothing"] = max(measured[f"line.{k}.{axis}"] for k in (BALLS - 1, BALLS + 1) for axis in ALONG_ACROSS)
    beside = [abs(2.0 - q * BALL_PASS) * TURNS for q in (-1, 1)]
    measured["sidebands.2"] = line(inner[2]["across"], 2.0 * TURNS) / max(line(inner[2]["across"], f) for f in beside)
    for k in (BALLS - 2, BALLS - 1, BALLS, BALLS + 1):
        alias = abs(k - BALL_PASS) * TURNS
        measured |= {f"alias.{k}.{axis}": line(x, alias) for axis, x in inner[k].items()}
    preloaded = difference(runs["preloaded"], runs["perfect, preloaded"])
    measured["preloaded"] = max(
        100.0 * line(preloaded[axis], k * TURNS) / measured[f"line.{k}.{axis}"] for k in LOW for axis in preloaded
    )
    outer = difference(runs["outer"], perfect)
    measured["outer.turn"] = max(line(x, k * TURNS) for k in ALL if _apart(k) for x in outer.values())
    measured["outer.pass"] = line(outer["across"], BALL_PASS * TURNS)
    larger = [difference(runs[f"{n:g} times"], perfect)["across"] for n in LARGER]
    second = [line(x, 4.0 * TURNS) for x in larger]
    measured["harmonic.rate"] = math.log(second[1] / second[0]) / math.log(LARGER[1] / LARGER[0])
    measured["harmonic"] = line(inner[2]["across"], 4.0 * TURNS)
    return Evidence(measured, data={**_lines_of(inner), "amplitude": 1e9 * AMPLITUDE})


def _lines_of(inner: dict[int, dict[str, np.ndarray]]) -> dict[str, Any]:
    """Spectra that stand on their orders, 60 dB from one to the next; what stands at order times speed, and closed forms."""
    spectra = {}
    for k, away in inner.items():
        f, a = spectrum(away["across"])
        height = np.clip(20.0 * np.log10(np.maximum(a, 1e-3)) / 60.0 + 1.0, 0.0, 1.0)
        spectra[f"order {k}"] = f / TURNS, k + 0.9 * height
    few = [k for k in inner if k <= BALLS // 2]
    return {
        "spectra": spectra,
        "orders": list(inner),
        "aliases": [abs(k - BALL_PASS) for k in inner],
        "few": few,
        **{f"{axis}.lines": [line(x[axis], k * TURNS) for k, x in inner.items()] for axis in ALONG_ACROSS},
        **{f"{axis}.many": [limit[k] for k in few] for axis, limit in ALONG_ACROSS.items()},
    }


def waves(orders: tuple[int, ...], loaded: bool, ring: str = "inner", times: float = 1.0) -> Scene:
    """The shaft with waves of some orders on one ring, under the weight or with an axial preload alone; `times` the amplitude."""
    left_out = PLACES - len(orders)
    parameters = (
        {
            f"{ring}_waviness.order": [*orders, *[1] * left_out],
            f"{ring}_waviness.amplitude": [*[times * AMPLITUDE] * len(orders), *[0.0] * left_out],
        }
        if orders
        else {}
    )
    effects = [f"{ring}_waviness"] if orders else []
    weight = {} if loaded else {"gravity": 0.0, "axial": PRELOAD}
    return scene(TRANSIENT + SEEN, STEP, TURNS, effects, interval=INTERVAL, parameters=parameters, **weight)


def _apart(order: int) -> bool:
    """Whether order times the speed lies four bins or more from all multiples of the ball-pass frequency of the outer race."""
    return abs((order / BALL_PASS + 0.5) % 1.0 - 0.5) * BALL_PASS * TURNS >= 4.0 * BIN


def difference(result: Result, perfect: Result) -> dict[str, np.ndarray]:
    """Motion along and across the load less that of the same bearing with perfect rings, in amplitudes of the waves, (n,)."""
    kept = result.time > TRANSIENT + 0.5 * INTERVAL
    return {
        name: (result[column] - perfect[column])[kept] / AMPLITUDE
        for name, column in (("along", "rotor.displacement_y"), ("across", "rotor.displacement_x"))
    }


def line(x: np.ndarray, frequency: float) -> float:
    """Amplitude of a line of the motion."""
    return amplitude_at(x, 1.0 / INTERVAL, frequency)


def place(x: np.ndarray, near: float) -> float:
    """Frequency of the highest line within three bins of a frequency, Hz."""
    return peak(*spectrum(x), near, 3.0 * BIN)[0]


def spectrum(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(frequency in Hz, amplitude) up to the highest shown frequency."""
    f, a = amplitude_spectrum(x, 1.0 / INTERVAL)
    return f[f <= SHOWN], a[f <= SHOWN]
