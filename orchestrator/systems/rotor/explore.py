"""What a page that computes a rotor shows: its largest displacement and where it is, forces and ball loads of its bearings."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...harness.analysis.records import RecordedUnit
from ...harness.explore.figures import LiveFigure
from .records import ROTOR, RotorRecord, rotors

if TYPE_CHECKING:
    from ...run.results import Result


def figures(result: Result) -> tuple[LiveFigure, ...]:
    """Of every rotor whose speed was recorded, after the transient, as in the summary."""
    return tuple(f for rotor in rotors(result) for f in _figures(result, rotor))


def _figures(result: Result, rotor: RotorRecord) -> list[LiveFigure]:
    unit, begin, rows = RecordedUnit(result, rotor.unit), result.scene.analysis.transient, []

    def add(name: str, text: str, measure: str, signals: list[str], kind: str, combine: str = "") -> None:
        rows.append(LiveFigure(f"{rotor.unit}.{name}", text, measure, tuple(signals), kind, combine=combine, transient=begin))

    speed = f"{rotor.unit}.{ROTOR['speed']}"
    if {"x", "y"} <= rotor.signals.keys():
        way = [f"{rotor.unit}.{ROTOR[axis]}" for axis in "xy"]
        add("displacement_max", "largest displacement where it is watched", "m", way, "maximum", "size")
        add("speed_at_max", "speed at the largest displacement", "rad/s", [*way, speed], "at the largest")
    for port, signals in rotor.ports.items():
        bearing = unit.driven_by(f"{port}.force_x")
        if bearing is not None and {"force_x", "force_y"} <= signals.keys():
            force = [bearing.column(n) for n in ("force_x", "force_y")]
            add(f"{port}.force_max", f"largest radial force at {port}", "N", force, "maximum", "size")
        if bearing is not None and "max_ball_load" in signals:
            add(f"{port}.ball_load_max", f"largest load of a ball at {port}", "N", [bearing.column("max_ball_load")], "maximum")
    add("speed_end", "speed at the end", "rad/s", [speed], "end")
    return rows
