"""Wrists in motion: forearm, both rows of bones and the hand, from the side and from above."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...harness.charts.blocks import Motion, Moving
from ...harness.charts.motion import instants, polyline
from .records import HAND, WristRecord, wrists

if TYPE_CHECKING:
    from ...results import Result

FOREARM, ROW, PALM = 0.12, 0.02, 0.1  # m, of the picture
APART = 0.3  # m, between the two views


def motions(result: Result) -> list[Motion]:
    """A picture of each wrist whose flexion and deviation were recorded."""
    rows = instants(result.time)
    return [_motion(record, rows) for record in wrists(result) if {*HAND[:2]} <= record.signals.keys()]


def _motion(record: WristRecord, rows: np.ndarray) -> Motion:
    angle = {name: values[rows] for name, values in record.signals.items()}
    proximal = angle.get("proximal_flexion", 0.5 * angle["flexion"])
    distal = proximal + angle.get("distal_flexion", angle["flexion"] - proximal)
    side = [(0.0, -FOREARM), (0.0, 0.0)]
    for turned, length in ((proximal, ROW), (distal, ROW), (angle["flexion"], PALM)):
        side.append((side[-1][0] + length * np.sin(turned), side[-1][1] + length * np.cos(turned)))
    deviation = angle["deviation"]
    joint = (APART, 2.0 * ROW)
    palm = (APART + PALM * np.sin(deviation), 2.0 * ROW + PALM * np.cos(deviation))
    width = 0.35 * PALM
    edge = [(palm[0] + s * width * np.cos(deviation), palm[1] - s * width * np.sin(deviation)) for s in (-1.0, 1.0)]
    lines = [
        Moving(polyline(side[0], side[1]), "ground"),
        Moving(polyline(*side[1:4]), "second", joints=True),
        Moving(polyline(side[3], side[4]), "part"),
        Moving(polyline((APART, -FOREARM), joint), "ground"),
        Moving(polyline(joint, palm), "part", joints=True),
        Moving(polyline(*edge), "part"),
    ]
    text = "Left, from the side: flexion to the right, both rows in blue. Right, from the back of the hand: radial deviation to the right."
    return Motion(f"{record.unit} in motion", record.time[rows], lines, caption=text + " Lengths are those of the picture.")
