"""How far the numbers of a run can be trusted: the errors that its repetition showed, and the curves where they differ most."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...run.run_record import Excerpt, SignalRecord, VerificationRecord
from ...run.thresholds import AIM, WARN
from ..charts.blocks import Block, Cells, Text
from ..charts.chart import Chart, Panel, Series
from ..charts.charts import draw_chart
from ..preferred_units import preferred
from ..summary import percent, verification_text

if TYPE_CHECKING:
    from ...run.results import Result

SHOWN = 12  # signals, the worst first


def blocks(result: Result) -> list[Block]:
    """Where the errors come from, those of the signals, the worst first, and the worst of all as two curves."""
    verification = result.info.verification
    parts: list[Block] = [Text([verification_text(verification)], "" if verification.done else "note")]
    if verification.signals:
        parts.append(_table(verification, result))
    if given := verification.excerpt:
        parts.append(draw_chart(_curves(given, result, verification.step)))
    return parts


def _table(verification: VerificationRecord, result: Result) -> Cells:
    signals = verification.signals
    worst = sorted(signals, key=lambda name: -(signals[name].rms or 0.0))
    rows = [
        (
            name,
            percent(signals[name].rms),
            percent(signals[name].max),
            f"{order:.2g}" if (order := signals[name].order) is not None else "",
            _kind(signals[name]),
        )
        for name in worst[:SHOWN]
    ]
    rest = f" The other {len(worst) - SHOWN} signals have smaller errors." if len(worst) > SHOWN else ""
    if missing := len({*result.columns, *result.texts} - {*signals}):  # windows show what units exchange
        rest += f" {missing} recorded signals, which no unit reads, have no error estimate."
    orders = any(order for *_, order, _ in rows)
    return Cells(
        "Errors of signals",
        ("signal", "error, rms", "largest", *(["order"] if orders else []), ""),
        rows if orders else [(*row[:3], row[4]) for row in rows],
        "Errors in % of the signal's standard deviation. Nearly constant signals: in % of their magnitude. Flags and modes: share of "
        f"the time with different values. Above {percent(WARN)} cosimo warns and suggests the step for {percent(AIM)}."
        f"{' Order: observed order of convergence of the three runs.' if orders else ''}{rest}",
        frozenset({1, 2, 3} if orders else {1, 2}),
    )


def _kind(error: SignalRecord) -> str:
    if error.parted:
        return "chaotic: trajectories diverge, statistics agree"
    return "switches at other instants" if error.shifted else ""


def _curves(given: Excerpt, result: Result, step: float) -> Chart:
    name = given.signal
    run, finer = np.asarray(given.run, dtype=float), np.asarray(given.finer, dtype=float)
    unit, factor = preferred(result.measures.get(name, ""), float(np.abs(run).max(initial=0.0)), name)
    lines = (Series("repetition, half the steps", given.time, factor * finer), Series("this run", given.time, factor * run))
    measure = f", {unit}" if unit else ""
    difference = Series("difference", given.time, factor * (run - finer))
    return Chart(
        "Largest difference between the run and its repetition",
        "time, s",
        (Panel(name + measure, lines), Panel("difference" + measure, (difference,))),
        "The signal with the largest error, near the instant of its largest difference: this run, its repetition with half the steps "
        f"(macro step {step:g} s), and this run minus the repetition.",
    )
