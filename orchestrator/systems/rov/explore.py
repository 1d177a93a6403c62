"""What a page that computes an underwater vehicle shows: how well it keeps its set point, and what the thrusters do."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...harness.analysis.records import RecordedUnit
from ...harness.explore.figures import LiveFigure
from .records import ERRORS, THRUSTS, Vehicle, vehicles
from .summary import TEXTS

if TYPE_CHECKING:
    from ...run.results import Result


def figures(result: Result) -> tuple[LiveFigure, ...]:
    """Of every vehicle whose position was recorded, as in the summary; none of thrusts that faults change on their way."""
    return tuple(f for v in vehicles(result) for f in _figures(result, v))


def _figures(result: Result, vehicle: Vehicle) -> list[LiveFigure]:
    unit, begin = RecordedUnit(result, vehicle.unit), result.scene.analysis.transient
    thrusters = {k: thruster for k in vehicle.commands if (thruster := unit.driven_by(THRUSTS[k - 1]))}
    controller = next((c for thruster in thrusters.values() if (c := thruster.driven_by("command"))), None)
    rows = []

    def add(name: str, signals: list[str], kind: str, combine: str = "", transient: float = 0.0) -> None:
        measure, text = TEXTS[name]
        if signals and all(signals):
            rows.append(
                LiveFigure(f"{vehicle.unit}.{name}", text, measure, tuple(signals), kind, combine=combine, transient=transient)
            )

    for name, axes in (("position", ERRORS[:3]), ("attitude", ERRORS[3:])):
        if controller is not None and set(axes) <= vehicle.errors.keys():
            add(f"{name}_error_max", [controller.column(a) for a in axes], "maximum", "size", begin)
    if not result.scene.faults:
        add("thrust_max", [unit.column(THRUSTS[k - 1]) for k in vehicle.thrusts], "largest size")
    add("limited_share", [thrusters[k].column("command") for k in thrusters], "share of time at 1", "largest size")
    return rows
