"""What a page that computes a pipe robot shows: speed, rests, energy for each metre."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...harness.explore.figures import LiveFigure
from .records import STEADY, RobotRecord, robots
from .summary import TEXTS

if TYPE_CHECKING:
    from ...run.results import Result


def figures(result: Result) -> tuple[LiveFigure, ...]:
    """Of every robot whose position and velocity were recorded, after the transient, as in the summary.

    With an exciter of constant frequency, speed is way over time: the summary takes whole periods, of which a page does not know.
    """
    return tuple(f for robot in robots(result) for f in _figures(result, robot))


def _figures(result: Result, robot: RobotRecord) -> list[LiveFigure]:
    begin, unit = result.scene.analysis.transient, robot.unit
    steady = robot.period[-1] > 0.0 and np.ptp(robot.period) <= STEADY * robot.period[-1]

    def figure(name: str, signal: str, kind: str, over: LiveFigure | None = None) -> LiveFigure:
        measure, text = TEXTS.get(name, ("m/s", "way over time after the transient"))
        return LiveFigure(f"{unit}.{name}", text, measure, (f"{unit}.{signal}",), kind, transient=begin, over=over)

    way = figure("way", "position", "change")
    rows = [way, figure("way_over_time" if steady else "mean_speed", "position", "rate of change")]
    rows.append(figure("rest_share", "mode" if "mode" in robot.signals else "velocity", "share of zeros"))
    if "exciter_power" in robot.signals:
        rows += [
            figure("exciter_energy", "exciter_power", "integral"),
            figure("energy_per_metre", "exciter_power", "integral", way),
        ]
    return rows
