"""The lumped catenary beside the distributed one: what it gets right, and what it cannot know."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from .....components.railway.contact import wire_height
from ....harness.analysis.signals import ButterworthFilter, uniform, window
from ....harness.validation import Evidence, Runs, done
from ....harness.validation.reference import Row, TableRow
from ....run.results import Result
from ....run.run import run
from ... import load_scene
from ..records import Passage, analysis_window, passages
from ..runs import WITHOUT_PICTURES, at_speed, numbers, reference_run
from .catenary_statics import resting_catenary

SPEEDS = (250.0, 300.0)  # km/h
SLOW = 10.0  # km/h; droppers pass at 0.4 Hz, and everything answers nearly as at rest
STATIC_TOLERANCE = 0.05  # of the mean uplift
MEAN_TOLERANCE = 0.02  # of the distributed mean: the base springs see heights that differ by up to a third of the uplift
DISTRIBUTED, LUMPED, INERTER = "distributed", "lumped mass", "inerter"


def measure(runs: Runs) -> Evidence:
    """Three models at two speeds and in the quasi-static limit."""
    results = {name: {v: _run(name, v, runs) for v in (*SPEEDS, SLOW)} for name in (DISTRIBUTED, LUMPED, INERTER)}
    statistics = {name: {v: numbers(r) for v, r in of_speed.items()} for name, of_speed in results.items()}
    rows = [_mean_row(statistics, v) for v in SPEEDS] + [_static_row(results[DISTRIBUTED][SLOW], results[LUMPED][SLOW])]
    names = ("mean", "std", "std_0_5", "std_5_20", "max", "min", "height_range_mm", "uplift_mm")
    drawn: dict[str, Any] = {
        "filter": str(ButterworthFilter()),
        "models": [(name, f"{v:g}", *(s[n] for n in names)) for name, of in statistics.items() for v, s in of.items()],
        **{f"{name}.{n}": statistics[name][SPEEDS[0]][n] for name in results for n in ("std", "std_5_20")},
    }
    return Evidence(rows=tuple(rows), data={**drawn, **_overlay(results, SPEEDS[0]), **_overlay(results, SPEEDS[1])})


def _run(name: str, speed: float, runs: Runs) -> Result:
    if name == DISTRIBUTED and speed in SPEEDS:
        return reference_run(speed, runs.options)
    if name == DISTRIBUTED:
        return done(run(at_speed(load_scene("en50318-2002"), speed, WITHOUT_PICTURES), in_process=True))
    scene = load_scene("lumped-catenary")
    effects = [e for e in scene.units["catenary"].effects if e != "inerter"] + ["inerter"] * (name == INERTER)
    return done(run(at_speed(scene, speed, {"units.catenary.effects": effects}), in_process=True))


def _mean_row(statistics: Mapping[str, Mapping[float, Mapping[str, float]]], speed: float) -> Row:
    mean = statistics[DISTRIBUTED][speed]["mean"]
    low, high = (1.0 - MEAN_TOLERANCE) * mean, (1.0 + MEAN_TOLERANCE) * mean
    source = "the distributed catenary at the same speed, ± 2 %"
    reference = TableRow("mean force of the lumped mass", "mean", f"{speed:g} km/h", "N", low, high, "computed", source)
    return Row(reference, statistics[LUMPED][speed]["mean"])


def _static_row(distributed: Result, lumped: Result) -> Row:
    """Uplift of the contact point must agree where inertia plays no part; the wire's shape at rest is not the lumped model's."""
    rest = resting_catenary("en50318-2002", {}, bending=False).mesh
    zero = np.zeros_like(rest.mass)
    x, height = _in_window(distributed)
    uplift = height - np.array([wire_height(position, zero, 0, rest) for position in x])
    difference = np.interp(x, *_in_window(lumped)) - uplift
    row = TableRow(
        "rms difference of the uplift at the contact point, lumped less distributed",
        "uplift",
        f"{SLOW:g} km/h, quasi-static",
        "mm",
        None,
        1e3 * STATIC_TOLERANCE * float(uplift.mean()),
        "computed",
        "the distributed catenary; tolerance 5 % of the mean uplift: the train is slow, not at rest",
    )
    return Row(row, 1e3 * float(np.sqrt(np.mean(difference**2))))


def _in_window(result: Result) -> tuple[np.ndarray, np.ndarray]:
    record = passages(result)[0].record
    cut = window(record.position, *analysis_window(result))
    return record.position[cut], record.height[cut]


def _overlay(results: Mapping[str, Mapping[float, Result]], speed: float) -> dict[str, Any]:
    """Filtered contact force and height of the contact point over its position in the window, by model."""
    low_pass = ButterworthFilter()
    drawn: dict[str, Any] = {f"force.{speed:g}": {}, f"height.{speed:g}": {}}
    for name, of_speed in results.items():
        passage: Passage = passages(of_speed[speed])[0]
        rate, _, (x, f, h) = uniform(passage.record.time, passage.record.position, passage.record.force, passage.record.height)
        cut = window(x, *analysis_window(of_speed[speed]))
        drawn[f"force.{speed:g}"][name] = x[cut], low_pass.apply(f, rate)[cut]
        drawn[f"height.{speed:g}"][name] = x[cut], 1e3 * h[cut]
    return drawn
