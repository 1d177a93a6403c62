"""Statistics of the contact force of every pantograph of a run, after EN 50317 and EN 50318."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ....components.railway.mesh import NO_WIRE
from ...harness.analysis.signals import window
from ...harness.summary import Summary, SummaryRow, rows
from .records import analysis_window, lateral_position, measured, passages, statistics

if TYPE_CHECKING:
    from ...run.results import Result
    from .contact import ContactStatistics
    from .records import Passage

TEXTS = {
    "mean": ("N", "mean force"),
    "std": ("N", "standard deviation"),
    "std_0_5": ("N", "standard deviation 0-5 Hz"),
    "std_5_20": ("N", "standard deviation 5-20 Hz"),
    "statistical_max": ("N", "statistical maximum, mean + 3 σ"),
    "statistical_min": ("N", "statistical minimum, mean - 3 σ"),
    "max": ("N", "actual maximum"),
    "min": ("N", "actual minimum"),
    "loss_raw": ("%", "contact loss, unfiltered force"),
    "loss_filtered": ("%", "contact loss, filtered force"),
    "arcs": ("1", "losses of contact of more than 5 ms, unfiltered force (limit of EN 50317, from memory)"),
    "arcing": ("%", "share of the time with loss of contact of more than 5 ms"),
    "longest_arc_ms": ("ms", "longest loss of contact, if of more than 5 ms"),
    "height_range_mm": ("mm", "range of the contact point's height"),
    "uplift_mm": ("mm", "maximum uplift at a support"),
    "lateral_mm": ("mm", "largest lateral position of the contact wire at the contact point"),
}
OF_THE_WHOLE = ("arcs", "arcing", "longest_arc_ms")  # no arc burns at a strip or a wire while the other keeps contact
OF_A_WIRE_THAT_IS_THERE = ("loss_raw", "loss_filtered", "statistical_max", "statistical_min", "height_range_mm")
HEADLINE = ("mean", "std", "max", "min", "loss_raw", "uplift_mm")  # what a run is judged by
INPUTS = (  # what a reader of a run looks for first
    "speed",
    "static_force",
    "line_table.table",
    "contact_wire_tension",
    "messenger_tension",
    "contact_wire_mass",
    "messenger_mass",
    "span_length",
    "spans",
    "head_mass",
    "frame_mass",
    "contact_stiffness",
)


def summary(result: Result) -> Summary:
    """In the window of analysis, of the force filtered as the settings of the statistics say."""
    numbers: list[SummaryRow] = []
    for i, passage in enumerate(passages(result)):
        texts = {name: (unit, f"{text}, of {passage.part}") for name, (unit, text) in TEXTS.items()} if passage.part else TEXTS
        values = {**shown(passage, statistics(result, pantograph=i)), **_lateral(result, passage)}
        numbers += rows(passage.pantograph, values, texts, bool(passage.part))
    return tuple(numbers)


def _lateral(result: Result, passage: Passage) -> dict[str, float]:
    """Of the first contact wire in the window of analysis, where it was recorded."""
    if passage.part or (sideways := lateral_position(result, passage)) is None:
        return {}
    inside = window(passage.record.position, *analysis_window(result))
    return {"lateral_mm": 1e3 * float(np.abs(sideways[inside]).max())}


def shown(passage: Passage, of_it: ContactStatistics) -> dict[str, float]:
    """The statistics that say something of this passage, in the order of `TEXTS`."""
    values = measured(of_it)
    left_out = (() if passage.supports else ("uplift_mm",)) + (OF_THE_WHOLE if passage.part else ())
    if passage.part and (passage.record.height >= 0.5 * NO_WIRE).any():  # of an overlap: where the wire is not, its force is 0
        left_out += OF_A_WIRE_THAT_IS_THERE
    return {name: values[name] for name in TEXTS if name in values and name not in left_out}
