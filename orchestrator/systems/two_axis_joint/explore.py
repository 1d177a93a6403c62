"""What a page that computes joints with two axes shows: how far they swing, and how what the equations keep drifts."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...harness.analysis.records import RecordedUnit
from ...harness.explore.figures import LiveFigure
from . import walkers
from .records import ENERGY, JointRecord, joints

if TYPE_CHECKING:
    from ...run.results import Result


def figures(result: Result) -> tuple[LiveFigure, ...]:
    """Of every joint that is one unit and whose angles and rates were recorded, as in the summary."""
    of_joints = [f for joint in joints(result) if joint.unit in result.scene.units for f in _figures(result, joint)]
    return tuple(of_joints + _steps(result))


def _figures(result: Result, joint: JointRecord) -> list[LiveFigure]:
    rows = []
    for axis in joint.axes:
        key, short = f"{joint.unit}.{axis.name.replace(' ', '_').replace('.', '_')}", axis.name.partition(" ")[0]
        for what, unit in (("angle", "rad"), ("rate", "rad/s")):
            text, signal = f"largest {what} of the {axis.name}", f"{joint.unit}.{short}_{what}"
            if signal in result.columns:
                rows.append(LiveFigure(f"{key}_{what}_max", text, unit, (signal,), "largest size"))
    if "energy" in joint.constant and (energy := RecordedUnit(result, joint.unit).column(ENERGY)):
        text = "largest change of the energy over its size"
        rows.append(LiveFigure(f"{joint.unit}.energy_change", text, "1", (energy,), "largest drift"))
    return rows


def _steps(result: Result) -> list[LiveFigure]:
    """Of every walker: its last step, as in the summary."""
    return [
        LiveFigure(f"{u.name}.{n}", text, unit, (f"{u.name}.{n}",), "end")
        for u in walkers.walkers(result)
        for n, unit, text in walkers.STEP
        if u.has(n)
    ]
