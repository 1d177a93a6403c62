"""The page of `cosimo orbit`: branches over a parameter with their bifurcations, or one orbit."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np

from ....derivatives.continuation import Branch, Orbits
from ....derivatives.orbit import Orbit
from ...charts.blocks import Block, Cells, Figure, Text
from ...charts.chart import Chart, Panel, Series
from ...charts.charts import draw_chart
from ..page import Page, Section, write_page

SIGNALS = 3  # that are drawn over a parameter


def for_orbits(study: Orbits, directory: str | Path) -> Path:
    """`report.html` of orbits."""
    blocks: list[Block] = [*_figures(study), *orbit_cells(study)]
    notes = [f"Branch {k}: {'; '.join(branch.ends)}." for k, branch in enumerate(study.branches, 1) if branch.ends]
    notes += [f"{study.parameter} = {value:g}: {reason}." for value, reason in study.gaps]
    if notes:
        blocks.append(Text(notes, "note"))
    lead = "Fixed points of the map over a period, by Newton's method on its exact derivative."
    page = Page(study.scene.title or study.scene.name, lead, [Section("Periodic orbits", blocks)])
    return write_page(page, Path(directory) / "report.html")


def orbit_cells(study: Orbits) -> list[Cells]:
    """Bifurcations and branches as tables; of one orbit its signals and multipliers."""
    if not study.parameter:
        orbit = study.branches[0].points[0]
        rows: list[tuple[str, ...]] = [
            (name, f"{low:.6g}", f"{high:.6g}") for name, low, high in zip(study.signals, orbit.low, orbit.high, strict=True)
        ]
        values = [(f"{v.real:.6g}", f"{v.imag:.6g}", f"{abs(v):.6g}") for v in orbit.multipliers.astype(complex)]
        title = f"Orbit of {orbit.period:.8g} s, {_word(orbit)}"
        right = frozenset({1, 2})
        return [
            Cells(title, ("signal", "minimum", "maximum"), rows, right=right),
            Cells("Multipliers", ("real", "imaginary", "absolute"), values, right=frozenset({0, 1, 2})),
        ]
    marks: list[tuple[str, ...]] = [
        (m.kind, f"{m.orbit.value:.6g}", f"{m.orbit.period:.6g}", f"{m.multiplier.real:.4f}", f"{m.multiplier.imag:.4f}")
        for m in study.marks
    ]
    header = ("bifurcation", study.parameter, "period, s", "multiplier, real", "imaginary")
    branches: list[tuple[str, ...]] = [
        (str(k), str(b.multiple), str(len(b.points)), *_range(b), f"{sum(p.stable for p in b.points)}")
        for k, b in enumerate(study.branches, 1)
    ]
    columns = ("branch", "periods", "orbits", "from", "to", "stable")
    right = frozenset(range(1, 6))
    return [Cells("Bifurcations", header, marks, right=right), Cells("Branches", columns, branches, right=right)]


def _range(branch: Branch) -> tuple[str, str]:
    values = [point.value for point in branch.points]
    return f"{min(values):.6g}", f"{max(values):.6g}"


def _word(orbit: Orbit) -> str:
    return "stable" if orbit.stable else "unstable"


def _figures(study: Orbits) -> list[Figure]:
    if not study.parameter:
        return []
    moving = [k for k in range(len(study.signals)) if any((p.high - p.low)[k] > 0.0 for b in study.branches for p in b.points)]
    drawn = moving[:SIGNALS]
    swings = [_panel(study, f"amplitude of {study.signals[k]}", _amplitudes, k) for k in drawn]
    sections = [_panel(study, f"section of {study.signals[k]}", _sections, k) for k in drawn]
    text = "Solid: stable. Dashed: unstable. At a period doubling the branch of the doubled period begins."
    chart = Chart(
        f"Orbits over {study.parameter}", study.parameter, tuple(swings), f"Half of maximum less minimum. {text}", height=300
    )
    cut = Chart("Sections", study.parameter, tuple(sections), f"Signals at the beginning of each period. {text}", height=300)
    return [draw_chart(chart), draw_chart(cut)]


def _amplitudes(orbit: Orbit) -> np.ndarray:
    return 0.5 * (orbit.high - orbit.low)[None, :]


def _sections(orbit: Orbit) -> np.ndarray:
    return orbit.sections


def _panel(study: Orbits, label: str, of: Callable[[Orbit], np.ndarray], signal: int) -> Panel:
    lines: list[Series] = []
    for branch in study.branches:
        for stretch in _stretches(branch):
            values = np.array([of(point)[:, signal] for point in stretch])
            at = np.array([point.value for point in stretch])
            kind = "line" if stretch[-1].stable else "dashed"
            lines += [Series(_name(branch, stretch[-1]), at, values[:, k], kind) for k in range(values.shape[1])]
    kinds: dict[str, list[tuple[float, float]]] = {}
    for mark in study.marks:
        kinds.setdefault(mark.kind, []).extend((mark.orbit.value, float(v)) for v in of(mark.orbit)[:, signal])
    lines += [Series(kind, np.array(points)[:, 0], np.array(points)[:, 1], "points") for kind, points in kinds.items()]
    return Panel(label, tuple(lines))


def _name(branch: Branch, orbit: Orbit) -> str:
    return _word(orbit) + (f", {branch.multiple} periods" if branch.multiple > 1 else "")


def _stretches(branch: Branch) -> list[list[Orbit]]:
    """Neighbours of one stability; each stretch begins where the last one ends."""
    parts: list[list[Orbit]] = [[branch.points[0]]]
    for before, point in pairwise(branch.points):
        if point.stable == before.stable:
            parts[-1].append(point)
        else:
            parts.append([before, point])
    return [part for part in parts if len(part) > 1] or [branch.points]
