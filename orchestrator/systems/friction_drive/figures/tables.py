"""Moves, rest of contacts, shafts and seal, and energies, in numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ....harness.charts.blocks import Cells
from ....harness.charts.style import number
from ..records import Drive, energies, moves, starts
from .way import SCALES

MOST = 16  # rows of one drive
NAMES = {"motors": "into the motors", "wheels": "from the wheels into the contacts", "contacts": "taken up by the contacts",
         "sleeve": "gained by sleeve, weight, deflections"}  # fmt: skip


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
