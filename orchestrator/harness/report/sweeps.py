"""Charts of a sweep: the bifurcation diagram of its section, and the extremes of its signals."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import TYPE_CHECKING

from ..charts.blocks import Block, Cells, Text
from ..charts.chart import Chart, Panel, Series
from ..charts.style import number
from ..many.repetition import NONE_REPEATED
from ..summary import percent
from .bifurcation import section_panel
from .trust import SHOWN

MOST_GROUPS = 7  # colours of lines

if TYPE_CHECKING:
    from ..many.repetition import Repeated
    from ..sweep import Sweep


def section_chart(sweep: Sweep) -> Chart | None:
    """The section's points over the last parameter, a panel for each combination of the others."""
    if not any(s.size for s in sweep.section) or list(sweep.varied.values())[-1].dtype.kind != "f":
        return None
    wanted = sweep.scene.analysis.section
    assert wanted is not None
    last, signal = list(sweep.varied)[-1], wanted.signal
    label, panels = f"{signal}, {sweep.units[f'{signal}, mean']}", []
    for title, members in _groups(sweep):
        panels.append(section_panel(label, sweep.varied[last][members], [sweep.section[i] for i in members], title=title))
    text = (
        f"Every point is {wanted.signal} at one passage of {wanted.angle}, {wanted.turns:g} a turn, after the "
        "transient. One point above a value: the motion has the period of the passages; some: a multiple of it; a cloud: "
        "quasi-periodic or chaotic."
    )
    return Chart("Bifurcation diagram", _label(sweep, last), tuple(panels), text, height=360)


def measures_chart(sweep: Sweep) -> Chart | None:
    """Extremes of every signal over the last parameter, drawn where it has several numbers."""
    last = list(sweep.varied)[-1]
    if len(set(sweep.varied[last].tolist())) < 2 or not sweep.measures:
        return None
    panels = []
    wanted = sweep.scene.analysis.section
    angle = wanted.angle if wanted is not None else ""  # its extremes are those of a turn
    for signal in dict.fromkeys(n.rpartition(", ")[0] for n in sweep.measures):
        if signal == angle:
            continue
        series = []
        for title, members in _groups(sweep):
            for kind in ("minimum", "maximum"):
                name = f"{signal}, {kind}"
                label = f"{kind}, {title}" if title else kind
                series.append(Series(label, sweep.varied[last][members], sweep.measures[name][members], "line"))
        unit = sweep.units[f"{signal}, maximum"]
        panels.append(Panel(unit if unit != "1" else "", tuple(series), title=signal))
    return Chart("Extremes of the signals", _label(sweep, last), tuple(panels), "After the transient.", columns=2)


def few_groups(sweep: Sweep) -> bool:
    """Whether lines over the last parameter can be drawn: a grid, of not too many combinations of the others."""
    *others, last = sweep.varied.values()
    combinations = len(set(zip(*others, strict=True))) if others else 1
    return sweep.plan.method == "grid" and last.dtype.kind == "f" and combinations <= MOST_GROUPS and bool(sweep.measures)


def trust(sweep: Sweep) -> list[Block]:
    """Which points were repeated, and the errors of the columns, the worst first."""
    blocks: list[Block] = [Text([trust_text(sweep)], "" if sweep.repeated is not None else "note")]
    if (repeated := sweep.repeated) is not None and repeated.errors:
        worst = sorted(repeated.errors, key=lambda name: -repeated.shares[name])
        rows = [
            (
                name,
                error_of(repeated, name),
                sweep.units.get(name, ""),
                percent(repeated.shares[name]),
                _point(sweep, repeated.at[name]),
            )
            for name in worst[:SHOWN]
        ]
        rest = f" The other {len(worst) - SHOWN} columns have smaller ones." if len(worst) > SHOWN else ""
        blocks.append(
            Cells(
                "Errors of columns",
                ("column", "±", "unit", "share", "at"),
                rows,
                "±: twice the largest change at the repeated points when all steps are halved. Share: "
                "of the column's largest size; of a signal's statistics, of the largest of them. The points of a "
                f"section have no error.{rest}",
                frozenset({1, 3}),
            )
        )
    return blocks


def trust_text(sweep: Sweep) -> str:
    """In one sentence."""
    text = sweep.repeated.summary(len(sweep.outcomes)) if sweep.repeated is not None else NONE_REPEATED
    return f"{text[0].upper()}{text[1:]}."


def error_of(repeated: Repeated | None, name: str) -> str:
    """The largest error of a column."""
    return number(repeated.errors[name]) if repeated is not None and name in repeated.errors else "not known"


def _point(sweep: Sweep, k: int) -> str:
    """The values of a point."""
    values = ((name, column[k]) for name, column in sweep.varied.items())
    return ", ".join(f"{name} = {v if isinstance(v, str) else number(float(v))}{_unit(sweep, name)}" for name, v in values)


def _groups(sweep: Sweep) -> Iterator[tuple[str, list[int]]]:
    """(name, points) of every combination of all parameters but the last."""
    *others, _ = sweep.varied.values()
    names = list(sweep.varied)[:-1]
    keys = [tuple(v[i] for v in others) for i in range(len(sweep.outcomes))]
    for key, members in itertools.groupby(range(len(keys)), key=keys.__getitem__):
        values = (v if isinstance(v, str) else number(float(v)) for v in key)
        yield ", ".join(f"{n} = {v}{_unit(sweep, n)}" for n, v in zip(names, values, strict=True)), list(members)


def _label(sweep: Sweep, name: str) -> str:
    return f"{name},{_unit(sweep, name)}" if _unit(sweep, name) else name


def _unit(sweep: Sweep, name: str) -> str:
    unit = sweep.units[name]
    return f" {unit}" if unit not in ("", "1") else ""
