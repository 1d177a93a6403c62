"""Figures of friction-wheel drives: way and set point, rest, wheels and motors, contacts, moves, energies.

Read from [analysis]: feed_band, rotation_band; see `analysis.friction_drive`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ....components.core.errors import counted
from ...harness.charts.blocks import Block, Cells
from ...harness.charts.chart import Band, Chart, Panel, Series, filled
from ...harness.charts.charts import draw_chart
from ...harness.charts.style import number
from ...harness.preferred_units import preferred
from . import FrictionDriveKeys
from .records import AXES, Drive, at_rest, drives, energies, moves, starts

if TYPE_CHECKING:
    from ...harness.validation.case import Row
    from ...run.results import Result

DEGREES = 180.0 / np.pi
SCALES = {"feed": (1e3, "mm"), "rotation": (DEGREES, "degrees")}
FINE = {"feed": (1e6, "µm"), "rotation": (DEGREES, "degrees")}
SHORTEST_REST = 0.2  # of the run, that a drive is at rest at its end, to be looked at
NOTICED = 0.01  # of its band, up to which an error is none
QUANTITIES = (("rate", "speed of the wheel"), ("voltage", "voltage, V"), ("current", "current, A"),
              ("torque", "load at the wheel, N.m"))  # fmt: skip
MOST_DRAWN = 6000  # samples of a path
FREE = ("Traction over the kinetic friction at full preload. Free friction: what the traction leaves of the kinetic friction at "
        "the present preload; below 0 a contact holds by its static friction alone.")  # fmt: skip
MOST = 16  # rows of one drive
NAMES = {"motors": "into the motors", "wheels": "from the wheels into the contacts", "contacts": "taken up by the contacts",
         "sleeve": "gained by sleeve, weight, deflections"}  # fmt: skip


def blocks(result: Result, rows: Sequence[Row] = ()) -> list[Block]:
    """Figures and tables of every drive whose feed and rotation were recorded; several share the figure of their way."""
    records = drives(result)
    if not records:
        return []
    keys = result.scene.analysis_as(FrictionDriveKeys)
    bands = {"feed": keys.feed_band, "rotation": keys.rotation_band}
    charts = [way_chart(records, bands), rest_chart(records)]
    for drive in records:
        who = f"{drive.unit}: " if len(records) > 1 else ""
        charts += [wheels_chart(drive, who), contacts_chart(drive, who), plane_chart(drive, who)]
    drawn: list[Block] = [draw_chart(c) for c in charts if c is not None]
    tables = [moves_table(records, bands), rests_table(records), energies_table(records)]
    return drawn[:1] + [t for t in tables if t is not None][:1] + drawn[1:] + [t for t in tables if t is not None][1:]


def way_chart(drives: Sequence[Drive], bands: Mapping[str, float]) -> Chart:
    """Feed and rotation over time with their set points, and the errors with the bands in which they count as settled."""
    panels = []
    for axis in AXES:
        factor, unit = SCALES[axis]
        wanted: dict[bytes, Series] = {}
        for d in drives:
            if axis in d.wanted:
                name = "set point" if len(drives) == 1 else f"{d.unit}: set point"
                wanted.setdefault(d.wanted[axis].tobytes(), Series(name, d.time, factor * d.wanted[axis], faint=True))
        own = [Series(axis if len(drives) == 1 else d.unit, d.time, factor * d.way[axis]) for d in drives]
        common = [Series("set point", s.x, s.y, faint=True) for s in wanted.values()] if len(wanted) == 1 else wanted.values()
        panels.append(Panel(f"{axis}, {unit}", (*common, *own)))
    for axis in AXES:
        factor, unit = SCALES[axis]
        errors = tuple(Series("error" if len(drives) == 1 else d.unit, d.time, factor * d.error[axis]) for d in drives
                       if axis in d.error)  # fmt: skip
        if any(np.abs(d.error[axis]).max() > NOTICED * bands[axis] for d in drives if axis in d.error):
            band = Band("settled", -factor * bands[axis], factor * bands[axis])
            panels.append(Panel(f"error of the {axis}, {unit}", errors, bands=(band,)))
    text = "Errors are set point less way. Shaded: the band in which a move counts as settled." if len(panels) > 2 else ""
    return Chart("Way of the sleeve", "time, s", tuple(panels), text, height=200)


def rest_chart(drives: Sequence[Drive]) -> Chart | None:
    """Errors from where every drive has come to rest on; None where one does not, or only at the end."""
    rests = [at_rest(d) for d in drives]
    first = max((k for k in rests if k is not None), default=0)
    time = drives[0].time
    if None in rests or time[-1] - time[first] < SHORTEST_REST * (time[-1] - time[0]):
        return None
    kept = slice(first, None)
    having = {axis: [d for d in drives if axis in d.error and np.ptp(d.wanted[axis])] for axis in AXES}
    panels = filled(
        (f"error of the {axis}, {unit}", [Series(axis if len(drives) == 1 else d.unit, d.time[kept], by * d.error[axis][kept])
                                          for d in having[axis]])
        for axis, (by, unit) in FINE.items()
    )  # fmt: skip
    if not panels:
        return None
    counts = [sum(starts(rest[kept]) for name, rest in d.rests.items() if "shaft" in name) for d in drives]
    phrases = [f"{d.unit}: the shafts break loose {counted(n, 'time')}" for d, n in zip(drives, counts, strict=True)]
    text = f"From {time[first]:.4g} s on, when all shafts have come to rest. In {'; in '.join(phrases)}."
    if max(counts) > 1:
        text += (" A drive that seeks its set point by an integral, and whose friction falls once it moves, goes past it again "
                 "and again: it hunts.")  # fmt: skip
    return Chart("While the set point stands", "time, s", panels, text, height=220)


def wheels_chart(drive: Drive, who: str = "") -> Chart | None:
    """Rates, voltages, currents and loads of both wheels over time, those that were recorded."""
    turning, factor = preferred("rad/s", 1.0, "speed")
    units = {"rate": (f", {turning}", factor)}
    panels = filled(
        (label + unit, [Series(f"{w.name} wheel", drive.time, by * w.signals[key]) for w in drive.wheels if key in w.signals])
        for key, label in QUANTITIES
        for unit, by in (units.get(key, ("", 1.0)),)
    )
    return Chart(f"{who}Wheels and motors", "time, s", panels, height=180) if panels else None


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


def moves_table(drives: Sequence[Drive], bands: Mapping[str, float]) -> Cells | None:
    """Every change of a set point, with the time to settle, overshoot and the error that is left; None without one."""
    rows: list[tuple[str, ...]] = []
    for d in drives:
        drive_moves = moves(d, bands)
        for m in drive_moves[:MOST]:
            factor, unit = SCALES[m.axis]
            settling_time = "not" if m.settling_time is None else number(m.settling_time)
            cells = (number(m.begin), number(m.lasts), *(f"{number(factor * v)} {unit}" for v in (m.way, m.overshoot, m.left)))
            rows.append((d.unit, m.axis, *cells, settling_time))
        if len(drive_moves) > MOST:
            rows.append((d.unit, f"and {len(drive_moves) - MOST} more", *[""] * 6))
    if not rows:
        return None
    limits = " and ".join(f"{number(SCALES[a][0] * b)} {SCALES[a][1]}" for a, b in bands.items())
    text = (f"Settled: from the start of the change until the error stays within {limits}, up to the next change. Left: set "
            "point less position at its end.")  # fmt: skip
    header = ("drive", "axis", "start, s", "duration, s", "way", "overshoot", "left", "settled after, s")
    return Cells("Moves", header, rows, text, frozenset(range(2, 8)))


def rests_table(drives: Sequence[Drive]) -> Cells | None:
    """How long contacts, shafts and seal stand, and how often they break loose; None where nothing can stand exactly."""
    rows = [(d.unit, name, number(100.0 * _share(d.time, rest)), str(starts(rest)))
            for d in drives for name, rest in d.rests.items()]  # fmt: skip
    if not rows:
        return None
    return Cells("Rest", ("drive", "what", "stands, % of the time", "breaks loose, times"), rows,
                 "By the samples of the record: what is shorter than the step between them is not counted.",
                 frozenset({2, 3}))  # fmt: skip


def _share(time: np.ndarray, rest: np.ndarray) -> float:
    return float(np.sum(rest[:-1] * np.diff(time)) / (time[-1] - time[0])) if time[-1] > time[0] else 0.0


def energies_table(drives: Sequence[Drive]) -> Cells | None:
    """Where the energy goes, J over the record; None where no power was recorded."""
    rows = []
    for d in drives:
        rows += [(d.unit, NAMES[name], number(1e3 * value)) for name, value in energies(d).items()]
    text = ("Over the record, from its samples. What the motors get and the wheels do not give is heat of windings, friction "
            "of shafts and gears, and motion; what contacts do not take up moves and lifts the sleeve and is lost in the "
            "seal.")  # fmt: skip
    return Cells("Energies", ("drive", "energy", "mJ"), rows, text, frozenset({2})) if rows else None
