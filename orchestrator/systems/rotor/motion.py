"""Orbits of rotors in motion, over their last turns."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...harness.charts.blocks import Motion, Moving
from ...harness.charts.motion import MOST, polyline, trace
from .records import rotors

if TYPE_CHECKING:
    from ...results import Result

TURNS = 10  # that a picture shows
MICROMETRES = 1e6


def motions(result: Result) -> list[Motion]:
    """A picture of each rotor whose displacement was recorded."""
    pictures = []
    for record in rotors(result):
        ways = {"the watched place": record.signals} | {f"at {port}": signals for port, signals in record.ports.items()}
        ways = {name: way for name, way in ways.items() if {"x", "y"} <= way.keys()}
        speed = float(np.abs(record.signals["speed"][-1]))
        if not ways or not speed:
            continue
        begin = record.time[-1] - 2.0 * np.pi * TURNS / speed
        rows = np.flatnonzero(record.time >= begin)[-MOST:]
        lines: list[Moving] = [Moving(polyline((0.0, 0.0)), "ground", joints=True)]
        for k, way in enumerate(ways.values()):
            x, y = MICROMETRES * way["x"][rows], MICROMETRES * way["y"][rows]
            lines += [trace(x, y), Moving(polyline((x, y)), ("second", "part", "load")[k % 3], joints=True)]
        named = ", ".join(f"{name} ({look})" for name, look in zip(ways, ("blue", "dark", "orange"), strict=False))
        text = f"The last {TURNS} turns at most, in µm: {named}. The dot that stands still is the place of rest."
        pictures.append(Motion(f"{record.unit}: orbits", record.time[rows], lines, ("µm", "µm"), text))
    return pictures
