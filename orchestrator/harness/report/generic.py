"""What every report has, whatever the system: tables against references, time series, settings of a run."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ....components.core.errors import BadInput
from ...run.run_info import flattened
from ...run.run_record import EffectsRecord
from ...scene.names import declared
from ..charts.bands import dense_line
from ..charts.blocks import Cells, Facts, Figure, RangeRow, Ranges, Sketch, Text
from ..charts.chart import Grid
from ..charts.signals import axis_of
from ..charts.style import CYCLE, axis, layout, number
from ..preferred_units import preferred
from .used import in_use

if TYPE_CHECKING:
    from ...run.results import Result
    from ..validation.case import Row

UNITS_IN_WORDS = {"in process": "components in process", "FMU": "FMUs"}
SHOWN_SIGNALS = 24  # of a plain run; the rest is in result.csv
# of a scene: in the drawing, among the parameters of the units, on the first page, of no run
_ELSEWHERE = re.compile(r"connections|units\..*\.parameters\.|document\.|explore\.")
_ELEMENT = re.compile(r"\[[\d,]+\]$")
PANEL, GAP, ENTRY = (
    110,
    24,
    29,
)  # px, of a panel of recorded signals at least, between them, of an entry of its legend, in print too
TURN, UNWRAPPED = 2.0 * np.pi, ", unwrapped"  # rad; behind the name of an angle that goes around
WHOLE_WIDTH = 400  # letters of a parameter, such as a table, from which it has the width of the page
UNLIKE = 30.0  # largest over smallest signal, from which they do not share an axis


def range_table(title: str, rows: Sequence[Row], settings: str = "", grouped: bool = False) -> Ranges:
    """Rows of a case as a table with bars; grouped: below lines with their conditions."""
    return Ranges(title, [range_row(row) if grouped else replace(range_row(row), condition="") for row in rows], settings)


def range_row(row: Row) -> RangeRow:
    """A row of a case in the texts that a reader sees."""
    r = row.reference
    low, high = r.low, r.high
    place = None
    if np.isfinite(row.simulated) and not row.missing:
        if low is not None and high is not None:
            place = (row.simulated - low) / (high - low) if high > low else 0.5 + np.sign(row.simulated - low)
        else:  # open: in the middle at the end of the range, and as far inside as the margin is of the end's size
            end = low if low is not None else high
            assert end is not None
            share = row.margin / max(abs(end), abs(row.simulated), 1e-12)
            place = share if low is not None else 1.0 - share
    unit = "" if r.unit == "1" else r.unit
    ends = [number(e, low, high) if e is not None else "" for e in (low, high)]
    text = f"{ends[0]} to {ends[1]}" if all(ends) else (f"at least {ends[0]}" if ends[0] else f"at most {ends[1]}")
    if low == high:
        text = ends[0] if low is not None else "missing"
    digits = ".0f" if 100.0 <= abs(row.margin) < 1e6 else ".2g"
    margin = f"{row.margin:{digits}}".replace("-", "−") if np.isfinite(row.margin) else "–"
    return RangeRow(
        r.named,
        unit,
        row.shown if np.isfinite([row.error, row.parameters]).any() else f"{number(row.simulated, low, high)}, {row.repeated}",
        text,
        margin,
        None if place is None else float(place),
        low is None,
        high is None,
        row.inside,
        row.undecided or row.missing,
        r.standing,
        r.standing,
        r.source + (f" ({r.confidence} confidence)" if r.confidence else ""),
        _verdict(row),
        r.condition,
    )


def _verdict(row: Row) -> str:
    """What the row says, in the words of its column."""
    if row.missing:
        return "not judged"
    if not row.inside:
        return "outside"
    return "undecided" if row.undecided else "within"


def grid_table(grid: Grid) -> Cells:
    """A study's table; columns of numbers flush right, with as many decimals as show four digits of the largest."""
    columns = [_column(values) for values in zip(*grid.rows, strict=True)]
    right = frozenset(i for i, (_, numeric) in enumerate(columns) if numeric)
    return Cells(grid.title, grid.header, list(zip(*(texts for texts, _ in columns), strict=True)), grid.text, right)


def _column(values: Sequence[str | float]) -> tuple[list[str], bool]:
    numbers = [float(v) for v in values if not isinstance(v, str)]
    if len(numbers) < len(values):
        return [v if isinstance(v, str) else number(float(v)) for v in values], False
    largest = max((abs(v) for v in numbers if np.isfinite(v)), default=0.0)
    decimals = int(np.clip(3 - np.floor(np.log10(largest)), 0, 6)) if largest > 0.0 else 0
    return [f"{v:.{decimals}f}".replace("-", "−") if np.isfinite(v) else "–" for v in numbers], True


def time_series(result: Result) -> list[Figure]:
    """Recorded signals over time: one panel for each unit of measure and size; a signal that does not change is only named."""
    signals = {n: np.asarray(v, dtype=float) for n, v in result.columns.items() if n != "time"}
    for name, angle in list(signals.items()):
        if result.measures.get(name) == "rad" and _wraps(angle):
            del signals[name]
            known = np.isfinite(angle)  # behind a gap all would be one
            signals[name + UNWRAPPED] = np.where(known, angle, np.nan)
            signals[name + UNWRAPPED][known] = np.unwrap(angle[known])
    constant = [n for n, y in signals.items() if y.size and np.all(y == y[0])]
    names = [n for n in signals if n not in constant]
    shown = names[:SHOWN_SIGNALS]
    measures = {n: result.measures.get(n.removesuffix(UNWRAPPED), "") for n in shown}
    panels = [
        panel
        for unit in dict.fromkeys(measures.values())
        for panel in _panels(unit, {n: signals[n] for n in shown if measures[n] == unit})
    ]
    if not panels:
        return []
    n = len(panels)
    talls = [max(PANEL, ENTRY * len(members)) for _, members in panels]
    inner = sum(talls) + GAP * (n - 1)
    tops = 1.0 - (np.cumsum([0, *talls[:-1]]) + GAP * np.arange(n)) / inner
    data: list[dict[str, Any]] = []
    axes: dict[str, Any] = {"xaxis": axis("time, s", anchor="y" + (str(n) if n > 1 else ""))}
    banded = False
    for i, (measure, members) in enumerate(panels):
        size = max(float(np.nanmax(np.abs(signals[n]), initial=0.0)) for n in members)
        unit, factor = preferred(measure, size, members[0])
        k = "" if i == 0 else str(i + 1)
        top = float(tops[i])
        axes["yaxis" + k] = axis(
            axis_of(unit, list(members)), grid=True, domain=[max(0.0, top - talls[i] / inner), top], anchor="x"
        )
        for j, name in enumerate(members):
            trace, cut = dense_line(
                result.time, factor * signals[name], name, CYCLE[j % len(CYCLE)], 1.4, yaxis="y" + k, legend="legend" + k
            )
            banded |= cut
            data.append(trace)
        axes["legend" + k] = {"x": 1.01, "xanchor": "left", "y": top, "yanchor": "top", "font": {"size": 11}, "orientation": "v"}
    rest = len(names) - SHOWN_SIGNALS
    still = ", ".join(f"{n} = {_value(n, float(signals[n][0]), result)}" for n in constant[:SHOWN_SIGNALS])
    caption = " ".join(
        filter(
            None,
            [
                f"{rest} more signals are in result.csv." if rest > 0 else "",
                f"Constant: {still}{' and others' if len(constant) > SHOWN_SIGNALS else ''}." if constant else "",
                "Bands: from the least to the largest value; zoom in for all samples." if banded else "",
            ],
        )
    )
    margin = {"l": 66, "r": 200, "t": 20, "b": 48}
    return [
        Figure("Recorded signals", {"data": data, "layout": layout(inner + 68, showlegend=True, margin=margin, **axes)}, caption)
    ]


def _wraps(angle: np.ndarray) -> bool:
    """Whether an angle goes around: it stays within a turn, and falls or rises by nearly one, more than once.

    One that leaves the turn counts turns itself; if its rows are nearly a turn apart, unwrapping would turn it backwards.
    """
    known = angle[np.isfinite(angle)]
    return int(np.count_nonzero(np.abs(np.diff(known)) > 0.8 * TURN)) > 1 and float(np.ptp(known)) < 1.01 * TURN


def _value(name: str, value: float, result: Result) -> str:
    unit, factor = preferred(result.measures.get(name, ""), abs(value), name)
    return f"{number(value * factor)} {unit}".rstrip()


def _panels(unit: str, signals: Mapping[str, np.ndarray]) -> list[tuple[str, list[str]]]:
    """(unit, names) of the panels for signals of one unit: those of like size together, no more than there are colours."""
    size = {n: float(np.abs(y[np.isfinite(y)]).max(initial=0.0)) for n, y in signals.items()}
    panels: list[list[str]] = []
    for name in sorted(signals, key=size.__getitem__, reverse=True):
        if not panels or size[panels[-1][0]] > UNLIKE * size[name] or len(panels[-1]) == len(CYCLE):
            panels.append([])
        panels[-1].append(name)
    order = list(signals)
    return [(unit, sorted(panel, key=order.index)) for panel in panels]


def effect_rows(effects: Mapping[str, EffectsRecord]) -> list[tuple[str, str]]:
    """What was on and what was off in every unit, with the reasons; effects of one reason together."""
    rows = []
    for unit, states in effects.items():
        for state, reasons_of in (("on", states.on), ("off", states.off)):
            reasons: dict[str, list[str]] = {}
            for effect, why in reasons_of.items():
                reasons.setdefault(str(why), []).append(effect)
            text = "; ".join(f"{', '.join(names)} ({why})" for why, names in reasons.items())
            rows.append((f"{unit}, {state}", text or "none"))
    return rows


def run_blocks(result: Result) -> list[Facts]:
    """The run's effects, settings, counters and versions, as run.json holds them."""
    titles = {
        "settings": "Co-simulation settings",
        "counters": "Work done",
        "timing": "Time taken, s",
        "versions": "Versions",
        "scene": "Scene as run",
    }
    effects = [Facts("Effects", effect_rows(result.info.effects))] if result.info.effects else []
    written = result.info.to_json()
    return [*effects, *_units(result, written["units"])] + [
        Facts(title, _in_words(key, flattened(written[key])), True, beside=key in ("counters", "timing", "versions"))
        for key, title in titles.items()
        if key in written
    ]


def _units(result: Result, written: Mapping[str, Any]) -> list[Facts]:
    """The parameters of the units, each in a unit for a reader; units that are alike in one list."""
    alike: dict[tuple[tuple[str, str], ...], list[str]] = {}
    for unit, record in written.items():
        try:
            known = declared(result.scene, unit)
        except BadInput:  # of a scene that is read back without its files
            known = {}
        arrays: dict[str, list[float | str]] = {}
        values = record.get("parameters", {})
        for name in in_use(result.scene, unit, values):
            arrays.setdefault(_ELEMENT.sub("[…]", name), []).append(values[name])
        of_unit = {k: v for k, v in record.items() if k != "parameters"}
        rows = _in_words("units", flattened(of_unit))
        for name, numbers in arrays.items():
            variable = known.get(name) or known.get(name.removesuffix("[…]")) or known.get(name.replace("…", "1"))
            rows.append((name, _measured(numbers, getattr(variable, "unit", "1") or "1", name)))
        alike.setdefault(tuple(rows), []).append(unit)
    facts = []
    for listed, units in alike.items():
        facts.append(Facts(f"{', '.join(units)}: parameters", [row for row in listed if len(row[1]) <= WHOLE_WIDTH], True))
        facts += [Facts(f"{', '.join(units)}: {name}", [("", text)], True) for name, text in listed if len(text) > WHOLE_WIDTH]
    return facts


def _measured(values: Sequence[Any], declared_unit: str, name: str) -> str:
    """Values of one parameter in a unit for a reader, six digits."""
    numbers = [v for v in values if isinstance(v, float)]
    if len(numbers) < len(values):
        return ", ".join(text for value in values for _, text in flattened(value))
    unit, factor = preferred(declared_unit, max(map(abs, numbers), default=0.0), name)
    return f"{', '.join(f'{v * factor:.6g}' for v in numbers)} {unit}".rstrip()


def _in_words(key: str, rows: Sequence[tuple[str, str]]) -> list[tuple[str, str]]:
    """Settings for a reader: what is not used is off; of the scene what stands nowhere else; arrays in a line each."""
    if key == "scene":
        return [(name, value) for name, value in rows if value not in ("", "None", "none") and not _ELSEWHERE.match(name)]
    if key == "settings":
        return [(name, {"None": "off", "none": "off", "False": "off", "True": "on"}.get(value, value)) for name, value in rows]
    arrays: dict[str, list[str]] = {}
    for name, value in rows:
        arrays.setdefault(_ELEMENT.sub("[…]", name), []).append(value)
    return [(name, ", ".join(values)) for name, values in arrays.items()]


def units_and_connections(result: Result) -> list[Sketch | Text]:
    """The scene as a drawing; of one that is read back, without the files that it names, a sentence."""
    try:
        return [Sketch("Units and connections", result.scene.show())]
    except BadInput as error:
        return [Text([f"No drawing of units and connections: {error}"], "note")]


def run_line(result: Result) -> str:
    """The run in one line: step, master, packaging, cost."""
    info, master = result.info, result.scene.master
    kinds = sorted({UNITS_IN_WORDS.get(u.kind, u.kind) for u in info.units.values()} - {""})
    steps = f"at {1e3 * master.step:g} ms" if master.control is None else f"with controlled steps ({master.control.method})"
    parts = [f"{master.algorithm} {steps}, extrapolation of degree {master.extrapolation}"]
    if kinds:
        parts.append("units as " + " and ".join(kinds))
    if (timing := info.timing) is not None:
        parts.append(f"{timing.simulated:.3g} s simulated in {timing.run:.2g} s after {timing.start:.2g} s of start")
    if info.versions:
        parts.append(", ".join(f"{k} {v}" for k, v in info.versions.items() if k in ("cosimo", "numpy", "numba")))
    return "; ".join(parts) + "."
