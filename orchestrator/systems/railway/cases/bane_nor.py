"""Rules of a public rule book, applied to the runs of the reference models: what a line, a train and a speed have to be."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from .....components.railway.line.dropper_table import line_of
from .....components.railway.line.from_table import resolved_sections
from ....harness.validation import Evidence, Runs
from ....harness.validation.limits_of_run import Rules
from ....harness.validation.reference import Row, compare, load_table
from .. import RailwayKeys
from ..records import SECOND, STRIPS, Passage, analysis_window, of_each, passages, wave_speed
from ..runs import KMH, ac_simple_run, reference_run

if TYPE_CHECKING:
    from ....run.results import Result

SPACED = ((250.0, "250 km/h and above"), (120.0, "above 120, below 250 km/h"), (80.0, "above 80, up to 120 km/h"))
SLOWEST = "up to 80 km/h"
HIGH = 200.0  # km/h, above which heights have a range; below, the rule has a nominal height alone
WHOLES = (".both_wires", ".both_strips")


def measure(runs: Runs) -> Evidence:
    """The rule of the wave speed on every run of the reference models; the rows' condition names the run."""
    table = load_table("bane-nor")
    results = [(f"EN 50318:2018 AC simple, {v:g} km/h", ac_simple_run(v, runs.options)[0]) for v in (275.0, 320.0)]
    results += [(f"EN 50318:2002, {v:g} km/h", reference_run(v, runs.options)) for v in (250.0, 300.0)]
    rows: list[Row] = []
    lines: list[tuple[str, float, float, float]] = []
    for name, result in results:
        rows += compare(tuple(replace(r, condition=name) for r in table.under("AC")[:1]), measures(result))
        passage = _whole(result)[0]
        wave = wave_speed(result, passage.catenary) or math.nan
        lines.append((name, passage.speed / KMH, wave / KMH, passage.speed / wave))
    return Evidence(rows=tuple(rows), settings={}, data={"lines": lines})


def measures(result: Result) -> dict[str, float]:
    """Of each pantograph, see `of_each`, by the rows' measures; without those that a run does not tell."""
    return of_each(result, lambda i: _measures(result, passages(result)[i]))


def rules(result: Result) -> list[Rules]:
    """The conditions that hold for each pantograph of a run; for another supply than AC there is no rule."""
    supply = result.scene.analysis_as(RailwayKeys).supply
    held = []
    for passage in _whole(result):
        speed, numbers = round(passage.speed / KMH, 3), _measures(result, passage)
        conditions: list[str] = [supply]
        if "spacing" in numbers:
            conditions.append(f"{supply}, pantographs, {spaced(speed)}")
        if "height_low" in numbers and speed > HIGH:
            conditions.append(f"{supply}, heights, above {HIGH:g} km/h")
        held.append(Rules(passage.pantograph, tuple(conditions), numbers))
    return held


def spaced(speed: float) -> str:
    """The range of speeds, in words of the table, to which a speed in km/h belongs."""
    fastest = SPACED[0][0]
    return next((words for low, words in SPACED if speed > low or speed == low == fastest), SLOWEST)


def _whole(result: Result) -> list[Passage]:
    return [passage for passage in passages(result) if not passage.part]


def _measures(result: Result, passage: Passage) -> dict[str, float]:
    wave, unit = wave_speed(result, passage.catenary), passage.pantograph
    for ending in (*WHOLES, SECOND, STRIPS):
        unit = unit.removesuffix(ending)
    values = result.info.units[unit].parameters
    numbers = {"speed_ratio": passage.speed / wave} if wave else {}
    if "static_force" in values:
        numbers["static_force"] = float(values["static_force"])
    others = [
        abs(p.record.position[0] - passage.record.position[0]) for p in _whole(result) if p.pantograph != passage.pantograph
    ]
    if others:
        numbers["spacing"] = float(min(others))
    return numbers | _heights(result, passage)


def _heights(result: Result, passage: Passage) -> dict[str, float]:
    """Of the contact wire at the supports of the window, as a line's table gives them; a table without heights has none."""
    catenary, _ = result.scene.split(f"{passage.catenary}.")
    values = result.info.units[catenary].parameters
    if "line_table.table" not in values:
        return {}
    start, end = analysis_window(result)
    lowest: dict[float, float] = {}  # where sections overlap, one wire is raised
    for s in resolved_sections(line_of(values)):
        for x, support in zip(s.x.round(6).tolist(), s.supports, strict=True):
            if start - 1e-6 <= x <= end + 1e-6:
                lowest[x] = min(support.contact_height, lowest.get(x, math.inf))
    known = np.array([*lowest.values()])
    return {"height_low": float(known.min()), "height_high": float(known.max())} if known.size and known.min() > 0.0 else {}
