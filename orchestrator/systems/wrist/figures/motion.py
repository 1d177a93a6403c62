"""Hand and rows over time, and against each other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....harness.charts.chart import Chart, Panel, Series
from ..records import WristRecord

DEGREES = 180.0 / np.pi
NAMES = {"flexion": "flexion", "deviation": "radial deviation", "roll": "roll",
         "proximal_flexion": "flexion of the proximal row", "distal_flexion": "flexion of the distal row"}  # fmt: skip
SHORT = {**NAMES, "deviation": "deviation", "proximal_flexion": "proximal row", "distal_flexion": "distal row"}


def motion_chart(records: Sequence[WristRecord], instants: Sequence[float] = ()) -> Chart:
    """Angles over the whole run: of one wrist, those of the hand in one panel and those of the rows in another; else by angle."""
    marks = tuple((float(t), "") for t in instants)
    if len(records) == 1:
        record = records[0]
        groups = {"hand, degrees": ("flexion", "deviation", "roll"), "rows, degrees": ("proximal_flexion", "distal_flexion")}
        panels = [Panel(label, tuple(Series(NAMES[n], record.time, DEGREES * record.signals[n]) for n in names
                                     if n in record.signals), x_marks=marks)
                  for label, names in groups.items() if any(n in record.signals for n in names)]  # fmt: skip
        text = "Flexion and radial deviation are positive; what a row adds to the flexion of the hand stands below."
    else:
        panels = []
        for name, label in SHORT.items():
            lines = tuple(Series(r.unit, r.time, DEGREES * r.signals[name]) for r in records if name in r.signals)
            if lines:
                panels.append(Panel(f"{label}, degrees", lines, x_marks=marks))
        text = "Several wrists in one picture: flexion, radial deviation and roll of the hand, and by how much each row flexes."
    text += " Thin vertical lines: instants of the table of postures." if marks else ""
    return Chart("Motion of the hand and its rows", "time, s", tuple(panels), text, height=190 if len(records) > 1 else 0)


def paths_chart(records: Sequence[WristRecord], instants: Sequence[float], start: int) -> Chart:
    """Where the hand goes in the plane of its two angles, and how the rows share it; of one wrist with the instants as points."""

    def path(x: str, y: str, label_x: str, label_y: str, title: str) -> Panel | None:
        lines = [Series(r.unit, DEGREES * r.signals[x][start:], DEGREES * r.signals[y][start:]) for r in records
                 if {x, y} <= r.signals.keys()]  # fmt: skip
        if not lines:
            return None
        if len(records) == 1 and instants:
            at, above = (DEGREES * np.interp(instants, records[0].time, records[0].signals[n]) for n in (x, y))
            lines.append(Series("instants of the table of postures", at, above, "points"))
        return Panel(f"{label_y}, degrees", tuple(lines), title=title, x_label=f"{label_x}, degrees", equal=True)

    panels = (
        path("flexion", "deviation", "flexion", "radial deviation", "hand"),
        path("proximal_flexion", "distal_flexion", "flexion of the proximal row", "of the distal row", "rows"),
    )
    text = "Where the hand goes."
    if panels[1] is not None:
        text = (
            "Left, where the hand goes. Right, how the rows share it: by the rule of Sandow (2020, abstract) they go to the "
            "upper right in flexion, to the lower left in extension, to the lower right in radial and to the upper left in "
            "ulnar deviation. The directions of the rows' axes, and with them the slopes, are a choice of this project."
        )
    return Chart("Paths", "", tuple(p for p in panels if p is not None), text, columns=2, height=340)
