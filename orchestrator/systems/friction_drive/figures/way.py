"""Way of the sleeve beside its set point, what is left while the set point stands, and what wheels and motors do for it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ....harness.charts.chart import Band, Chart, Panel, Series
from ..records import AXES, Drive, at_rest, starts

DEGREES = 180.0 / np.pi
SCALES = {"feed": (1e3, "mm"), "rotation": (DEGREES, "degrees")}
FINE = {"feed": (1e6, "µm"), "rotation": (DEGREES, "degrees")}
LEAST = 0.2  # of the run, that a drive is at rest at its end, to be looked at
NOTICED = 0.01  # of its band, up to which an error is none
QUANTITIES = (("rate", "rate of the wheel, rad/s"), ("voltage", "voltage, V"), ("current", "current, A"),
              ("torque", "load at the wheel, N.m"))  # fmt: skip


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
    if None in rests or time[-1] - time[first] < LEAST * (time[-1] - time[0]):
        return None
    kept = slice(first, None)
    panels = []
    for axis in AXES:
        factor, unit = FINE[axis]
        errors = [Series(axis if len(drives) == 1 else d.unit, d.time[kept], factor * d.error[axis][kept]) for d in drives
                  if axis in d.error and np.ptp(d.wanted[axis])]  # fmt: skip
        if errors:
            panels.append(Panel(f"error of the {axis}, {unit}", tuple(errors)))
    if not panels:
        return None
    counts = [sum(starts(rest[kept]) for name, rest in d.rests.items() if "shaft" in name) for d in drives]
    phrases = [f"{d.unit}: the shafts break loose {n} time{'' if n == 1 else 's'}" for d, n in zip(drives, counts, strict=True)]
    text = f"From {time[first]:.4g} s on, when all shafts have come to rest. In {'; in '.join(phrases)}."
    if max(counts) > 1:
        text += (" A drive that seeks its set point by an integral, and whose friction falls once it moves, goes past it again "
                 "and again: it hunts.")  # fmt: skip
    return Chart("While the set point stands", "time, s", tuple(panels), text, height=220)


def wheels_chart(drive: Drive, who: str = "") -> Chart | None:
    """Rates, voltages, currents and loads of both wheels over time, those that were recorded."""
    panels = []
    for key, label in QUANTITIES:
        series = tuple(Series(f"{w.name} wheel", drive.time, w.signals[key]) for w in drive.wheels if key in w.signals)
        if series:
            panels.append(Panel(label, series))
    return Chart(f"{who}Wheels and motors", "time, s", tuple(panels), height=180) if panels else None
