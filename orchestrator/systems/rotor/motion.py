"""Orbits of rotors in motion, over their last turns."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...harness.analysis.records import RecordedUnit
from ...harness.charts.blocks import Moving
from ...harness.charts.formulas import last
from ...harness.charts.motion import MOST, Kinematics, Picture, Values, polyline, trace
from .records import ROTOR, rotors

if TYPE_CHECKING:
    from ...run.results import Result

TURNS = 10  # that a picture shows
MICROMETRES = 1e6
LOOKS = {"second": "blue", "part": "dark", "load": "orange"}


def motions(result: Result) -> list[Kinematics]:
    """A picture of each rotor that turns and whose displacement was recorded."""
    pictures = []
    for record in rotors(result):
        unit = RecordedUnit(result, record.unit)
        ways = {"the watched place": [unit.column(ROTOR[axis]) for axis in "xy"]}
        ways |= {f"at {port}": [unit.column(f"{port}.displacement_{axis}") for axis in "xy"] for port in record.ports}
        ways = {name: way for name, way in ways.items() if all(way)}
        if not ways or not record.signals["speed"][-1]:
            continue
        signals = {f"{axis} {name}": column for name, way in ways.items() for axis, column in zip("xy", way, strict=True)}
        looks = [list(LOOKS)[k % len(LOOKS)] for k in range(len(ways))]
        named = ", ".join(f"{name} ({LOOKS[look]})" for name, look in zip(ways, looks, strict=True))
        pictures.append(
            Kinematics(
                f"{record.unit}: orbits",
                lambda values, ways=ways, looks=looks: _orbits(values, ways, looks),  # type: ignore[misc]
                signals | {"speed": unit.column(ROTOR["speed"])},
                caption=f"The last {TURNS} turns at most, in µm: {named}. The dot that stands still is the place of rest.",
                labels=("µm", "µm"),
                begin=lambda values: last(values["time"]) - 2.0 * np.pi * TURNS / np.abs(last(values["speed"])),
                fewest=MOST,
            )
        )
    return pictures


def _orbits(values: Values, ways: list[str], looks: list[str]) -> Picture:
    lines = [Moving(polyline((0.0, 0.0)), "ground", joints=True)]
    for name, look in zip(ways, looks, strict=True):
        x, y = (MICROMETRES * values[f"{axis} {name}"] for axis in "xy")
        lines += [trace(x, y), Moving(polyline((x, y)), look, joints=True)]
    return Picture(lines)
