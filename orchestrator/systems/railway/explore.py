"""What a page that computes a railway scene shows: the statistics of the first pantograph, and the conditions of its table."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from ...harness.analysis.signals import ButterworthFilter
from ...harness.explore.figures import LiveFigure
from .records import LATERAL, analysis_window, passages
from .summary import TEXTS

if TYPE_CHECKING:
    from ...run.results import Result

FIXED = ("*.span_length", "*.start_position")  # the window of analysis follows from them
KINDS = {
    "mean": "mean",
    "std": "standard deviation",
    "statistical_max": "mean + 3 σ",
    "statistical_min": "mean - 3 σ",
    "max": "maximum",
    "min": "minimum",
}


def figures(result: Result) -> tuple[LiveFigure, ...]:
    """Of the foremost pantograph, as in the summary."""
    passage = passages(result)[0]
    if passage.pantograph not in result.scene.units:  # the sum of two collectors
        return ()
    unit = passage.pantograph
    start, end = analysis_window(result)
    window = (f"{unit}.contact_position", start, end)
    force = (f"{unit}.contact_force",)
    cutoff = ButterworthFilter().cutoff
    rows = [_figure(unit, name, force, kind, cutoff=cutoff, window=window) for name, kind in KINDS.items()]
    rows.append(_figure(unit, "loss_raw", force, "share not above zero", window=window))
    watched = [n for n in result.columns if n.startswith(f"{passage.catenary}.support_uplift[")]
    inside = tuple(n for n, x in zip(watched, passage.supports, strict=True) if start - 1e-6 <= x <= end + 1e-6)
    if inside:
        rows.append(_figure(unit, "uplift_mm", inside, "maximum", factor=1e3))  # over the whole run
    if (sideways := f"{passage.catenary}.{LATERAL}") in result.columns:
        rows.append(_figure(unit, "lateral_mm", (sideways,), "largest size", factor=1e3, window=window))
    return tuple(rows)


def _figure(unit: str, name: str, signals: tuple[str, ...], kind: str, **more: object) -> LiveFigure:
    measure, text = TEXTS[name]
    return LiveFigure(f"{unit}.{name}", text, measure, signals, kind, measure=name, **more)  # type: ignore[arg-type]


def conditions(result: Result, names: Iterable[str]) -> Mapping[str, Mapping[str, float]]:
    """Condition of a table, such as "250 km/h" -> the parameters that say so."""
    unit = passages(result)[0].pantograph
    speeds = {name: re.fullmatch(r"([\d.]+) km/h", name) for name in names}
    return {name: {f"{unit}.speed": float(speed[1]) / 3.6} for name, speed in speeds.items() if speed}
