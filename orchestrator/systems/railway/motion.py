"""The pantograph under the wire, which moves past it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...harness.analysis.records import RecordedUnit
from ...harness.charts.blocks import Motion, Moving
from ...harness.charts.motion import polyline
from .figures.wire import profile
from .records import Passage, passages

if TYPE_CHECKING:
    from ...results import Result

FEWEST = 10  # snapshots
STRIP = 0.8  # m, half of the head's length in the picture
FRAME = 40.0  # mm, the frame below the head at rest


def motions(result: Result) -> list[Motion]:
    """A picture of the foremost pantograph, where the run has snapshots of the wire."""
    name = f"{all_passages[0].catenary}.wire_profile.height" if (all_passages := passages(result)) else ""
    pictures = [_motion(result, all_passages[0], name)] if name in result.snapshots else []
    return [picture for picture in pictures if picture is not None]


def _motion(result: Result, passage: Passage, name: str) -> Motion | None:
    """The wire about the pantograph, from the snapshots of that name, with its head and its frame; None of too few."""
    times, _, offsets, heights = profile(result, passage, name)
    unit = RecordedUnit(result, passage.pantograph)
    recorded = [unit.optional("head_height"), unit.optional("frame_height")]
    if times.size < FEWEST or any(h is None for h in recorded):
        return None
    head, frame = (np.interp(times, result.time, 1e3 * h) for h in recorded if h is not None)
    # the coordinate of a head that is pressed into the contact's spring is above the wire
    head = np.fmin(head, heights[:, heights.shape[1] // 2])
    none = np.zeros(times.size)
    below = frame - FRAME
    lines = [
        Moving(np.stack([np.broadcast_to(offsets, heights.shape), heights], axis=-1), "second"),
        Moving(polyline((none - STRIP, head), (none + STRIP, head)), "part"),
        Moving(polyline((none, head), (none, below)), "load"),
        Moving(polyline((none - 2.0 * STRIP, below), (none + 2.0 * STRIP, below), (none + 6.0 * STRIP, below - FRAME)), "part"),
    ]
    text = (
        "Heights in mm over the wire's place of rest, lengths in m from the contact point. Blue: the contact wire. Dark: head and "
        f"frame of the pantograph, the frame {FRAME:g} mm lower than its coordinate."
    )
    return Motion("The pantograph under the wire", times, lines, ("m", "mm"), text, equal=False)
