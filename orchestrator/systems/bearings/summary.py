"""Vibration of the bearings of a run: rms, extremes, kurtosis; the frequencies of defects."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...harness.summary import Summary, SummaryRow
from .records import BearingRecord, bearings, since

if TYPE_CHECKING:
    from ...run.results import Result

LINES = {"cage": "cage (FTF)", "outer": "outer race (BPFO)", "inner": "inner race (BPFI)", "ball": "spin of a ball (BSF)"}
HEADLINE = ("*_rms", "*_kurtosis", "ball_load_max")  # what a run is judged by
INPUTS = ("speed", "load", "*load*", "*defect.*", "*clearance", "balls", "ball_diameter", "pitch_diameter", "damping")


def summary(result: Result) -> Summary:
    """Of every bearing whose displacement was recorded, after the transient."""
    return tuple(row for b in bearings(result) for row in _rows(b, result.scene.analysis.transient))


def _rows(bearing: BearingRecord, begin: float) -> list[SummaryRow]:
    kept = since(bearing.time, begin)
    numbers = []
    for name, values in bearing.signals.items():
        if not name.startswith(("displacement", "acceleration")):
            continue
        x, called, unit = values[kept], name.replace("_", " "), bearing.measures.get(name) or "1"
        centred = x - x.mean()
        rms = float(np.sqrt(np.mean(centred**2)))
        numbers += [
            SummaryRow(f"{bearing.unit}.{name}_rms", rms, unit, f"{called}, rms about the mean"),
            SummaryRow(f"{bearing.unit}.{name}_peak_to_peak", float(np.ptp(x)), unit, f"{called}, peak to peak"),
        ]
        if rms > 0.0:
            kurtosis = float(np.mean(centred**4)) / rms**4
            numbers.append(SummaryRow(f"{bearing.unit}.{name}_kurtosis", kurtosis, "1", f"{called}, kurtosis; a sine has 1.5"))
    if "max_ball_load" in bearing.signals:
        load, unit = float(bearing.signals["max_ball_load"][kept].max()), bearing.measures.get("max_ball_load") or "1"
        numbers.append(SummaryRow(f"{bearing.unit}.ball_load_max", load, unit, "largest load of a ball"))
    per_time = "Hz" if "m/s2" in bearing.measures.values() or "m" in bearing.measures.values() else "1"
    numbers += [
        SummaryRow(f"{bearing.unit}.{name}_frequency", bearing.frequencies[name], per_time, f"{text}, {bearing.basis}")
        for name, text in LINES.items()
        if name in bearing.frequencies
    ]
    return numbers
