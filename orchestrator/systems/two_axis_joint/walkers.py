"""Walkers of a run: their steps as numbers, as a figure, in motion and on a page that computes them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...harness.analysis.records import RecordedUnit, recorded_units
from ...harness.charts.blocks import Moving
from ...harness.charts.chart import Chart, Panel, Series
from ...harness.charts.motion import Kinematics, Picture, Values, polyline
from ...harness.summary import SummaryRow

if TYPE_CHECKING:
    from ...run.results import Result

LEGS = ("stance_angle", "swing_angle", "foot_position")
STEP = (("step_duration", "s", "duration of the last step"), ("step_length", "m", "length of the last step"),
        ("strike_angle", "rad", "standing leg right after the last impact"))  # fmt: skip
LONGEST = 20.0  # s
DEGREES = 180.0 / np.pi


def walkers(result: Result) -> list[RecordedUnit]:
    """The units of a run that walk, whose legs and foot were recorded."""
    return [u for u in recorded_units(result) if u.component is not None and u.has(*LEGS)]


def rows(result: Result) -> list[SummaryRow]:
    """How many steps each walker has made, and what the last one was."""
    numbers = []
    for u in walkers(result):
        if u.has("steps"):
            numbers.append(SummaryRow(f"{u.name}.steps", float(u["steps"][-1]), "1", "steps"))
        numbers += [SummaryRow(f"{u.name}.{n}", float(u[n][-1]), unit, text) for n, unit, text in STEP if u.has(n)]
    return numbers


def chart(result: Result, begin: float) -> Chart | None:
    """Both legs of each walker, rate over angle: a gait is a closed line of two branches, joined by the jump at the impact."""
    panels = []
    for u in walkers(result):
        if not u.has("stance_rate", "swing_rate"):
            continue
        kept = slice(int(np.searchsorted(u.time, begin - 1e-12)), None)
        series = tuple(Series(f"{n} leg", DEGREES * u[f"{n}_angle"][kept], DEGREES * u[f"{n}_rate"][kept], "dots")
                       for n in ("stance", "swing"))  # fmt: skip
        panels.append(Panel("rate, degrees/s", series, title=u.name, x_label="angle from the slope's normal, degrees"))
    if not panels:
        return None
    text = "Each leg stands, jumps at the impact, and swings. Lines that lie on one another: a gait."
    return Chart("Walking", "", tuple(panels), text, columns=2, height=330)


def motions(result: Result) -> list[Kinematics]:
    """A picture of each walker on its slope."""
    pictures = []
    for u in walkers(result):
        signals = {n: u.column(n) for n in LEGS}
        sizes = {n: f"{u.name}.{n}" for n in ("leg_length", "slope")}
        pictures.append(
            Kinematics(f"{u.name} in motion", _legs, signals, sizes, caption="Dark: the standing leg.", longest=LONGEST)
        )
    return pictures


def _legs(values: Values) -> Picture:
    """Slope and both legs, x to the right, y up; the slope falls to the right."""
    stance, swing, foot, length, slope = (values[n] for n in (*LEGS, "leg_length", "slope"))

    def seen(along, height):
        return along * np.cos(slope) + height * np.sin(slope), height * np.cos(slope) - along * np.sin(slope)

    hip = foot - length * np.sin(stance), length * np.cos(stance)
    other = hip[0] + length * np.sin(swing), hip[1] - length * np.cos(swing)
    ground = polyline(seen(foot - 2.0 * length, 0.0 * foot), seen(foot + 2.0 * length, 0.0 * foot))
    return Picture([
        Moving(ground, "ground"),
        Moving(polyline(seen(*hip), seen(*other)), "second", joints=True),
        Moving(polyline(seen(foot, 0.0 * foot), seen(*hip)), "part", joints=True),
    ])  # fmt: skip
