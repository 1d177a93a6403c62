"""Wrists in motion: forearm, both rows of bones and the hand, from the side and from above."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...harness.charts.blocks import Moving
from ...harness.charts.motion import Kinematics, Picture, Values, polyline
from .records import HAND, wrists

if TYPE_CHECKING:
    from ...run.results import Result

FOREARM, ROW, PALM = 0.12, 0.02, 0.1  # m, of the picture
APART = 0.3  # m, between the two views
SHOWN = (*HAND[:2], "proximal_flexion", "distal_flexion")
CAPTION = (
    "Left, from the side: flexion to the right, both rows in blue. Right, from the back of the hand: radial deviation to the right. "
    "Lengths are those of the picture."
)


def motions(result: Result) -> list[Kinematics]:
    """A picture of each wrist whose flexion and deviation were recorded."""
    return [
        Kinematics(f"{w.unit} in motion", _hand, {n: w.columns[n] for n in SHOWN if n in w.columns}, caption=CAPTION)
        for w in wrists(result)
    ]


def _hand(angle: Values) -> Picture:
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
    return Picture(
        [
            Moving(polyline(side[0], side[1]), "ground"),
            Moving(polyline(*side[1:4]), "second", joints=True),
            Moving(polyline(side[3], side[4]), "part"),
            Moving(polyline((APART, -FOREARM), joint), "ground"),
            Moving(polyline(joint, palm), "part", joints=True),
            Moving(polyline(*edge), "part"),
        ]
    )
