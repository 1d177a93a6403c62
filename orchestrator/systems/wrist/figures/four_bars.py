"""A four-bar linkage over its crank angle."""

from __future__ import annotations

import numpy as np

from ....harness.charts.chart import Chart, Panel, Series
from ..records import LinkageRecord
from .motion import DEGREES

SHOWN = (
    ("output_angle", "rocker angle, degrees", DEGREES),
    ("ratio", "rocker rate over crank rate, 1", 1.0),
    ("transmission_angle", "transmission angle, degrees", DEGREES),
)


def linkage_chart(record: LinkageRecord) -> Chart:
    """Rocker angle, ratio and transmission angle over the crank angle, and the path of a point of the coupler."""
    crank, signals = DEGREES * record.crank, record.signals
    panels = []
    for name, label, factor in SHOWN:
        if name in signals:
            line = Series(label.partition(",")[0], crank, factor * signals[name])
            panels.append(Panel(label, (line,), x_label="crank angle, degrees"))
    if {"coupler_point.x", "coupler_point.y"} <= signals.keys():
        x, y = (1e3 * signals[f"coupler_point.{n}"] for n in "xy")
        path = Series("point of the coupler", x, y)
        panels.append(Panel("across the ground, mm", (path,), x_label="along the ground, mm", equal=True))
    text = "At transmission angles of 0 and 180 degrees coupler and rocker are in one line, and the ratio is infinite."
    if "transmission_angle" in signals:
        ends = DEGREES * np.array([signals["transmission_angle"].min(), signals["transmission_angle"].max()])
        text += f" Here it goes from {ends[0]:.2f} to {ends[1]:.2f} degrees."
    text += (
        " That a gear of the wrist is such a linkage is a reading of the abstract of Sandow (2020); lengths are a choice of "
        "this project."
    )
    return Chart(f"Four-bar linkage {record.unit}", "", tuple(panels), text, columns=2, height=260)
