"""The pantograph under the wire, which moves past it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ....components.railway.mesh import NO_WIRE
from ...harness.analysis.records import RecordedUnit
from ...harness.charts.blocks import Moving
from ...harness.charts.formulas import known_below, not_above
from ...harness.charts.motion import Kinematics, Picture, Values, polyline
from .records import passages

if TYPE_CHECKING:
    from ...run.results import Result

FEWEST = 10  # snapshots
STRIP = 0.8  # m, half of the head's length in the picture
FRAME = 40.0  # mm, the frame below the head at rest
CAPTION = (
    "Heights in mm over the wire's place of rest, lengths in m from the contact point. Blue: the contact wire. Dark: head and "
    f"frame of the pantograph, the frame {FRAME:g} mm lower than its coordinate."
)


def motions(result: Result) -> list[Kinematics]:
    """A picture of the foremost pantograph, where the run has snapshots of the wire."""
    name = f"{all_passages[0].catenary}.wire_profile.height" if (all_passages := passages(result)) else ""
    if name not in result.snapshots or result.snapshots[name].time.size < FEWEST:
        return []
    unit = RecordedUnit(result, all_passages[0].pantograph)
    signals = {what: unit.column(f"{what}_height") for what in ("head", "frame")}
    if not all(signals.values()):
        return []
    title = "The pantograph under the wire"
    return [Kinematics(title, _under_the_wire, signals, {}, {"wire": name}, CAPTION, ("m", "mm"), equal=False)]


def _under_the_wire(values: Values) -> Picture:
    heights = known_below(values["wire"], 0.99 * NO_WIRE)
    inner = heights[:, 1:-1] + 0.0 * (
        heights[:, :-2] + heights[:, 2:]
    )  # beside its end a point is drawn towards where no wire is
    heights = 1e3 * np.concatenate([heights[:, :1], inner, heights[:, -1:]], axis=1)
    points = heights.shape[1]
    offsets = np.arange(points) - 0.5 * (points - 1)  # 1 m apart, the contact point in the middle
    # the coordinate of a head that is pressed into the contact's spring is above the wire
    head, frame = not_above(1e3 * values["head"], heights[:, points // 2]), 1e3 * values["frame"]
    below = frame - FRAME
    return Picture(
        [
            Moving(np.stack([np.broadcast_to(offsets, heights.shape), heights], axis=-1), "second"),
            Moving(polyline((-STRIP, head), (STRIP, head)), "part"),
            Moving(polyline((0.0, head), (0.0, below)), "load"),
            Moving(polyline((-2.0 * STRIP, below), (2.0 * STRIP, below), (6.0 * STRIP, below - FRAME)), "part"),
        ]
    )
