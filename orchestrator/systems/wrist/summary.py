"""How far the wrists of a run move, how much they roll, and whether their rows keep the rule."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...harness.summary import Summary, SummaryRow
from ...run.key_results import after_transient
from . import WristKeys
from .records import HAND, bundles, linkages, postures, wrists

if TYPE_CHECKING:
    from ...run.results import Result

HEADLINE = ("flexion_max", "flexion_min", "row_rule_share", "tension_max", "strain_max", "swing")  # what a run is judged by


def summary(result: Result) -> Summary:
    """Of every wrist, ligament bundle and four-bar linkage that was recorded, after the transient."""
    kept = after_transient(result)
    numbers: list[SummaryRow] = []
    for wrist in wrists(result):
        numbers += [
            SummaryRow(
                f"{wrist.unit}.{name}_{word}", float(pick(wrist.signals[name][kept])), "rad", f"{word} of the hand's {name}"
            )
            for name in HAND
            if name in wrist.signals
            for word, pick in (("max", np.max), ("min", np.min))
        ]
        instants = result.scene.analysis_as(WristKeys).postures
        rules = [p.rule for p in postures(wrist, instants, kept.start) if p.rule is not None]
        if rules:
            numbers.append(
                SummaryRow(
                    f"{wrist.unit}.row_rule_share",
                    100.0 * float(np.mean(rules)),
                    "%",
                    "share of the tabulated postures in which both rows move as the rule says",
                )
            )
    for bundle in bundles(result):
        for what, unit in (("tension", "N"), ("strain", "1")):
            values = getattr(bundle, what)
            if values:
                largest = max(values, key=lambda name: float(np.max(values[name][kept])))
                numbers.append(
                    SummaryRow(
                        f"{bundle.unit}.{what}_max",
                        float(np.max(values[largest][kept])),
                        unit,
                        f"largest {what} of a ligament, {largest}",
                    )
                )
    for linkage in linkages(result):
        angle = linkage.signals["output_angle"][kept]
        numbers.append(SummaryRow(f"{linkage.unit}.swing", float(np.ptp(angle)), "rad", "swing of the output link"))
    return tuple(numbers)
