"""Postures in numbers: angles of hand and rows, whether the rows keep the rule, what differs from the first wrist."""

from __future__ import annotations

from collections.abc import Sequence

from ....harness.charts.blocks import Cells
from ..records import HAND, ROWS, WristRecord, postures
from .motion import DEGREES

KEPT = {True: "yes", False: "no", None: ""}
COLUMNS = (*HAND, *ROWS)


def _degrees(angle: float | None) -> str:
    """An angle in rad as degrees; "" for none."""
    return "" if angle is None else f"{DEGREES * angle:.2f}".replace("-", "−")


def posture_table(records: Sequence[WristRecord], instants: Sequence[float], start: int) -> Cells:
    """Angles at the given instants, or where they are largest after the transient; and the row rule there."""
    rows = []
    for record in records:
        for p in postures(record, instants, start):
            angles = (_degrees(p.values.get(n)) for n in COLUMNS)
            rows.append((record.unit, f"{p.time:.4g}", p.name, *angles, KEPT[p.rule]))
    text = (
        "Row rule, from the abstract of Sandow (2020): in flexion both rows flex, in radial deviation the proximal row "
        "flexes and the distal one extends, and the reverse in extension and ulnar deviation; between these the rule says "
        "nothing. Axes, stiffness and mass behind the numbers are a choice of this project, recalled or from cadaver data, "
        "as the components say."
    )
    header = (
        "wrist",
        "at, s",
        "posture",
        "flexion, deg",
        "radial deviation, deg",
        "roll, deg",
        "proximal row flexes, deg",
        "distal row flexes, deg",
        "row rule kept",
    )
    return Cells("Postures", header, rows, text, frozenset({1, *range(3, 8)}))


def difference_table(records: Sequence[WristRecord], instants: Sequence[float]) -> Cells:
    """What every further wrist does otherwise than the first at the same instants."""
    first = postures(records[0], instants)
    rows = []
    for record in records[1:]:
        for here, there in zip(postures(record, instants), first, strict=True):
            both = [(here.values.get(n), there.values.get(n)) for n in COLUMNS]
            changes = (_degrees(None if a is None or b is None else a - b) for a, b in both)
            rows.append((record.unit, f"{here.time:.4g}", there.name, *changes))
    header = (
        "wrist",
        "at, s",
        f"posture of {records[0].unit}",
        "flexion, deg",
        "radial deviation, deg",
        "roll, deg",
        "proximal row flexes, deg",
        "distal row flexes, deg",
    )
    return Cells(
        f"Against {records[0].unit}",
        header,
        rows,
        "Angles less those of the first wrist, at the same instants.",
        frozenset({1, *range(3, 8)}),
    )
