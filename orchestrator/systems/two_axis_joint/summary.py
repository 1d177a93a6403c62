"""How far the joints of a run swing, how fast, and how what their equations keep drifts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...harness.summary import Summary, SummaryRow
from . import walkers
from .records import JointRecord, joints

if TYPE_CHECKING:
    from ...run.results import Result

HEADLINE = ("*_angle_max", "*_change", "*.step_length", "*.step_duration")  # what a run is judged by


def summary(result: Result) -> Summary:
    """Of every joint whose angles and rates were recorded, and of every walker."""
    return (*(row for joint in joints(result) for row in _rows(joint)), *walkers.rows(result))


def _rows(joint: JointRecord) -> list[SummaryRow]:
    numbers = []
    for axis in joint.axes:
        key = f"{joint.unit}.{axis.name.replace(' ', '_').replace('.', '_')}"
        numbers += [
            SummaryRow(f"{key}_angle_max", float(np.abs(axis.angle).max()), "rad", f"largest angle of the {axis.name}"),
            SummaryRow(f"{key}_rate_max", float(np.abs(axis.rate).max()), "rad/s", f"largest rate of the {axis.name}"),
        ]
    for name, values in joint.kept.items():
        if name in joint.constant:  # of another one a change over its size says nothing: from rest it is 1
            change = float(np.abs(values - values[0]).max()) / (float(np.abs(values).max()) or 1.0)
            text = f"largest change of the {name} over its size, which the equations keep"
            numbers.append(SummaryRow(f"{joint.unit}.{name}_change", change, "1", text))
    return numbers
