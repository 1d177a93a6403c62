"""Muscles and ligaments over time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....harness.charts.chart import Chart, Panel, Series
from ..records import Bundle, Muscles

SLACK = 1e-9  # strain over which a ligament that never bears a force is drawn all the same


def muscles_chart(record: Muscles, one_of_several: bool = False) -> Chart:
    """Activation and force of every muscle, and their torques on the hand."""
    t = record.time
    panels = [Panel("activation, 1", tuple(Series(n, t, v) for n, v in record.activation.items()))]
    if record.force:
        panels.append(Panel("force, N", tuple(Series(n, t, v) for n, v in record.force.items())))
    if record.torques:
        words = {"flexion": "torque of flexion", "deviation": "torque of radial deviation"}
        panels.append(Panel("torque on the hand, N·m", tuple(Series(words[n], t, v) for n, v in record.torques.items())))
    text = (
        "FCR, FCU: flexors on the side of radius and ulna; ECRL, ECRB, ECU: extensors. Moment arms and largest forces are "
        "in part read, in part recalled; the component says which."
    )
    text += f" Shown: those of {record.unit}." if one_of_several else ""
    return Chart("Muscles", "time, s", tuple(panels), text)


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
