"""Figures of wrists: motion of hand and rows, postures with the row rule, muscles, ligaments, four-bar linkages.

Read from [analysis]: transient, s, left out of paths and postures; postures, s, instants that are tabulated.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...harness.charts.blocks import Block, Cells
from ...harness.charts.chart import Chart, Panel, Series, filled
from ...harness.charts.charts import draw_chart
from ...run.key_results import after_transient
from . import WristKeys
from .records import HAND, ROWS, Bundle, LinkageRecord, Muscles, WristRecord, bundles, linkages, muscles, postures, wrists

if TYPE_CHECKING:
    from ...harness.validation.case import Row
    from ...run.results import Result

DEGREES = 180.0 / np.pi
NAMES = {"flexion": "flexion", "deviation": "radial deviation", "roll": "roll",
         "proximal_flexion": "flexion of the proximal row", "distal_flexion": "flexion of the distal row"}  # fmt: skip
SHORT = {**NAMES, "deviation": "deviation", "proximal_flexion": "proximal row", "distal_flexion": "distal row"}
KEPT = {True: "yes", False: "no", None: ""}
COLUMNS = (*HAND, *ROWS)
SLACK = 1e-9  # strain over which a ligament that never bears a force is drawn all the same
SHOWN = (
    ("output_angle", "rocker angle, degrees", DEGREES),
    ("ratio", "rocker rate over crank rate, 1", 1.0),
    ("transmission_angle", "transmission angle, degrees", DEGREES),
)


def blocks(result: Result, rows: Sequence[Row] = ()) -> list[Block]:
    """Figures and tables of the wrists and four-bar linkages of a run that were recorded; several wrists are compared."""
    content: list[Block] = []
    begin = after_transient(result).start
    records = wrists(result)
    if records:
        instants = result.scene.analysis_as(WristKeys).postures
        content += [draw_chart(motion_chart(records, instants)), draw_chart(paths_chart(records, instants, begin))]
        content.append(posture_table(records, instants, begin))
        if len(records) > 1 and instants:
            content.append(difference_table(records, instants))
    pulled, bound = muscles(result), bundles(result)
    content += [draw_chart(muscles_chart(m, len(pulled) > 1)) for m in pulled[:1]]  # those of compared wrists have one programme
    if bound:
        content.append(draw_chart(ligaments_chart(bound)))
    content += [draw_chart(linkage_chart(record)) for record in linkages(result)]
    return content


def motion_chart(records: Sequence[WristRecord], instants: Sequence[float] = ()) -> Chart:
    """Angles over the whole run: of one wrist, those of the hand in one panel and those of the rows in another; else by angle."""
    marks = tuple((float(t), "") for t in instants)
    if len(records) == 1:
        record = records[0]
        groups = {"hand, degrees": ("flexion", "deviation", "roll"), "rows, degrees": ("proximal_flexion", "distal_flexion")}
        panels = filled(((label, [Series(NAMES[n], record.time, DEGREES * record.signals[n]) for n in names if n in record.signals])
                         for label, names in groups.items()), x_marks=marks)  # fmt: skip
        text = "Flexion and radial deviation are positive; what a row adds to the flexion of the hand stands below."
    else:
        lines = {n: [Series(r.unit, r.time, DEGREES * r.signals[n]) for r in records if n in r.signals] for n in SHORT}
        panels = filled(((f"{label}, degrees", lines[n]) for n, label in SHORT.items()), x_marks=marks)
        text = "Several wrists in one picture: flexion, radial deviation and roll of the hand, and by how much each row flexes."
    text += " Thin vertical lines: instants of the table of postures." if marks else ""
    return Chart("Motion of the hand and its rows", "time, s", panels, text, height=190 if len(records) > 1 else 0)


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
        "nothing. Axes, stiffness and mass behind the numbers are a choice of this project, from memory or from cadaver data, "
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


def muscles_chart(record: Muscles, one_of_several: bool = False) -> Chart:
    """Activation and force of every muscle, and their torques on the hand."""
    t = record.time
    words = {"flexion": "torque of flexion", "deviation": "torque of radial deviation"}
    parts = {
        "activation, 1": record.activation,
        "force, N": record.force,
        "torque on the hand, N·m": {words[n]: v for n, v in record.torques.items()},
    }
    panels = filled((label, [Series(n, t, v) for n, v in of.items()]) for label, of in parts.items())
    text = (
        "FCR, FCU: flexors on the side of radius and ulna; ECRL, ECRB, ECU: extensors. Moment arms and largest forces are "
        "in part read, in part from memory; the component says which."
    )
    text += f" Shown: those of {record.unit}." if one_of_several else ""
    return Chart("Muscles", "time, s", panels, text)


def ligaments_chart(records: Sequence[Bundle]) -> Chart:
    """Tension and strain of every ligament; of several wrists one of the two, a panel each."""
    panels, never = [], []
    for record in records:
        title = record.unit if len(records) > 1 else ""
        kinds = [(label, v) for label, v in (("tension, N", record.tension), ("strain, 1", record.strain)) if v]
        for label, values in kinds[:1] if title else kinds:
            lines = tuple(Series(n, record.time, v) for n, v in values.items())
            if lines:
                panels.append(Panel(label, lines, title=title))
        never += [f"{title} {n}".strip() for n, v in record.tension.items() if not np.abs(v).max() > SLACK]
    text = (
        "The five pairs are those that Sandow (2008, abstract) calls isometric; attachments and stiffness are a choice of "
        "this project."
    )
    text += f" Without tension throughout: {', '.join(never)}." if never else ""
    return Chart("Ligaments", "time, s", tuple(panels), text, columns=2)


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
