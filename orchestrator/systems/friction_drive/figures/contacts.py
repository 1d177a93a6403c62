"""Contacts of wheels and sleeve: how much of the friction is used, how they slip, and the tractions in their plane."""

from __future__ import annotations

import math

import numpy as np

from ....harness.charts.chart import Chart, Panel, Series
from ..records import Drive

MOST_DRAWN = 6000  # samples of a path
FREE = ("Traction over the kinetic friction at full preload. Free friction: what the traction leaves of the kinetic friction at "
        "the present preload; below 0 a contact holds by its static friction alone.")  # fmt: skip


def contacts_chart(drive: Drive, who: str = "") -> Chart | None:
    """Tractions over the kinetic friction, slips, and the power that the contacts take up, over time."""
    panels, text = [], ""
    loaded = [w for w in drive.wheels if w.traction is not None]
    if loaded and math.isfinite(drive.level):
        used = tuple(Series(f"{w.name} wheel", drive.time, np.hypot(*w.traction) / drive.level) for w in loaded)  # type: ignore[misc]
        panels.append(Panel("traction over friction, 1", used))
    elif loaded:
        panels.append(
            Panel(
                "traction, N",
                tuple(
                    Series(f"{w.name} wheel", drive.time, np.hypot(*w.traction))  # type: ignore[misc]
                    for w in loaded
                ),
            )
        )
    slips = tuple(Series(f"{w.name} wheel", drive.time, 1e3 * np.hypot(*w.slip)) for w in drive.wheels if w.slip is not None)
    if slips:
        panels.append(Panel("slip, mm/s", slips))
    if "margin" in drive.signals and math.isfinite(drive.level):
        least = max(-0.5, float(drive.signals["margin"].min()))
        panels.append(Panel("friction still free, 1", (Series("the wheel that has less", drive.time, drive.signals["margin"]),),
                            y_range=(min(least, 0.0) - 0.05, 1.05)))  # fmt: skip
        text = FREE
    if "contact_power" in drive.signals:
        panels.append(Panel("power taken up, W", (Series("both", drive.time, drive.signals["contact_power"]),)))
    return Chart(f"{who}Contacts", "time, s", tuple(panels), text, height=180) if panels else None


def plane_chart(drive: Drive, who: str = "") -> Chart | None:
    """Path of each traction in the plane of its contact, with the circles of kinetic and static friction."""
    panels = []
    for wheel in drive.wheels:
        if wheel.traction is not None:
            along, around = wheel.traction
            kept = slice(None, None, max(1, math.ceil(along.size / MOST_DRAWN)))
            series = [Series(n, *circle(level), faint=True) for n, level in _levels(drive)]
            series += [Series("traction", around[kept], along[kept]), Series("begin", around[:1], along[:1], "points"),
                       Series("end", around[-1:], along[-1:], "points")]  # fmt: skip
            panels.append(Panel("along the axis, N", tuple(series), title=f"{wheel.name} wheel", x_label="around the axis, N",
                                equal=True))  # fmt: skip
    if not panels:
        return None
    text = "Force of each wheel on the sleeve." + (" Pale: friction at full preload." if math.isfinite(drive.level) else "")
    return Chart(f"{who}Tractions in the plane of contact", "", tuple(panels), text, columns=2, height=330)


def circle(radius: float) -> tuple[np.ndarray, np.ndarray]:
    """The limit of friction, (181,) each."""
    turn = np.linspace(0.0, 2.0 * np.pi, 181)
    return radius * np.cos(turn), radius * np.sin(turn)


def _levels(drive: Drive) -> list[tuple[str, float]]:
    levels = [("kinetic friction", drive.level), ("static friction", drive.static)]
    return [(n, v) for n, v in levels if math.isfinite(v)][: 1 if drive.static == drive.level else 2]
