"""What thrusters give and what the controller misses: thrusts with their limits, errors against the set point."""

from __future__ import annotations

import numpy as np

from ....harness.charts.blocks import Cells
from ....harness.charts.chart import Chart, Panel, Series
from ....harness.charts.style import number
from ..records import ERRORS, Vehicle
from .motion import DEGREES


def thrusts_chart(vehicle: Vehicle, who: str = "") -> Chart:
    """Thrust of every thruster, marked where its command is at the limit; the share of the wrench where limits keep some back."""
    series = [Series(f"thruster {k}", vehicle.time, F) for k, F in vehicle.thrusts.items()]
    times = [(vehicle.time[vehicle.at_limit(k)], F[vehicle.at_limit(k)]) for k, F in vehicle.thrusts.items()]
    at, what = (np.concatenate(parts) for parts in zip(*times, strict=True))
    series += [Series("at its limit", at, what, "dots")] if at.size else []
    panels = [Panel("thrust, N", tuple(series))]
    if vehicle.commands:
        commands = tuple(Series(f"thruster {k}", vehicle.time, c) for k, c in vehicle.commands.items())
        panels.append(Panel("command, 1", commands))
    text = "As the hull receives them."
    if vehicle.scale is not None and vehicle.scale.min() < 1.0:
        panels.append(
            Panel("share of wrench, 1", (Series("given of what is wanted", vehicle.time, vehicle.scale),), y_range=(-0.05, 1.1))
        )
    elif vehicle.scale is not None:
        text += " The limits of the thrusters kept nothing back of what the controller wanted."
    return Chart(f"{who}Thrusts", "time, s", tuple(panels), text, height=190)


def thrusts_table(vehicle: Vehicle, who: str = "") -> Cells:
    """Least, greatest and mean size of every thrust, and how long its command was at the limit."""
    whole = float(vehicle.time[-1] - vehicle.time[0]) or 1.0
    rows = []
    for k, F in vehicle.thrusts.items():
        limited = float(np.trapezoid(vehicle.at_limit(k).astype(float), vehicle.time)) / whole
        mean = float(np.trapezoid(np.abs(F), vehicle.time)) / whole
        share = f"{100.0 * limited:.3g} %" if k in vehicle.commands else "not recorded"
        rows.append((f"thruster {k}", number(float(F.min())), number(float(F.max())), number(mean), share))
    return Cells(
        f"{who}Thrusters",
        ("", "least, N", "greatest, N", "mean size, N", "time at its limit"),
        rows,
        right=frozenset({1, 2, 3, 4}),
    )


def errors_chart(vehicle: Vehicle, who: str = "") -> Chart:
    """Set point less pose over time."""
    panels = []
    for label, names, factor in (("error of the position, m", ERRORS[:3], 1.0),
                                 ("error of the attitude, degrees", ERRORS[3:], DEGREES)):  # fmt: skip
        series = tuple(
            Series(n.removeprefix("error_"), vehicle.time, factor * vehicle.errors[n]) for n in names if n in vehicle.errors
        )
        panels += [Panel(label, series)] if series else []
    text = "Set point less pose: position in north, east, down, attitude as the rotation vector in body axes."
    return Chart(f"{who}Errors against the set point", "time, s", tuple(panels), text, height=200)


def errors_table(vehicle: Vehicle, start: int, who: str = "") -> Cells:
    """Root mean square and largest error of every axis from the sample `start` on."""
    rows = []
    for name, values in vehicle.errors.items():
        angle = name in ERRORS[3:]
        kept = values[start:] * (DEGREES if angle else 1e3)
        unit = "degrees" if angle else "mm"
        rms = float(np.sqrt(np.mean(np.square(kept))))
        rows.append((name.removeprefix("error_"), unit, f"{rms:.3g}", f"{np.abs(kept).max():.3g}"))
    begin = float(vehicle.time[start])
    return Cells(
        f"{who}Errors",
        ("", "unit", "root mean square", "largest"),
        rows,
        f"From {begin:.4g} s on." if begin > vehicle.time[0] else "",
        right=frozenset({2, 3}),
    )
