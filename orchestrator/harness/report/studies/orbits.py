"""The page of `cosimo orbit`: branches over a parameter with their bifurcations, or one orbit."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import pairwise
from pathlib import Path

import numpy as np

from ....derivatives.continuation import Branch, Orbits
from ....derivatives.motions import CHAOTIC, MOTION_COLUMNS, NEITHER, NONE, PERIODIC, REGULAR
from ....derivatives.orbit import Orbit
from ....derivatives.orbit_map import OrbitMap
from ....scene.names import measure_of
from ....scene.scene import Scene
from ...charts.blocks import Block, Cells, Figure, Text
from ...charts.chart import Chart, Panel, Picture, Series
from ...charts.charts import draw_chart
from ...preferred_units import preferred
from ..page import Page, Section, write_page

KINDS = (PERIODIC, CHAOTIC, NEITHER, REGULAR, NONE)
SIGNALS = 3  # that are drawn over a parameter


def _shown(scene: Scene, name: str, values: Iterable[float]) -> tuple[str, float]:
    """A parameter or a signal with the unit in which values of such a size are read, and the factor to that unit."""
    unit, _, output = name.partition(".")
    signal = scene.coupling.interfaces[unit].outputs.get(output) if unit in scene.units else None
    measure = signal.unit if signal is not None else measure_of(scene, name)
    text, factor = preferred(measure, max(map(abs, values), default=0.0), name)
    return f"{name}, {text}" if text else name, factor


def _place(scene: Scene, name: str, value: float) -> str:
    """A value of a parameter in a note."""
    label, factor = _shown(scene, name, [value])
    return f"{name} = {factor * value:g} {label.removeprefix(name)[2:]}".rstrip()


def _over(study: Orbits) -> tuple[str, float]:
    """The parameter as `_shown`, of all values of the study."""
    return _shown(
        study.scene, study.parameter, [p.value for b in study.branches for p in b.points] + [m.value for m in study.motions]
    )


def for_orbits(study: Orbits, directory: str | Path) -> Path:
    """`report.html` of orbits."""
    blocks: list[Block] = [*_figures(study), *orbit_cells(study)]
    notes = [f"Branch {k}: {'; '.join(branch.ends)}." for k, branch in enumerate(study.branches, 1) if branch.ends]
    notes += [f"{_place(study.scene, study.parameter, value)}: {reason}." for value, reason in study.gaps]
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
            (label, f"{low * factor:.6g}", f"{high * factor:.6g}")
            for name, low, high in zip(study.signals, orbit.low, orbit.high, strict=True)
            for label, factor in (_shown(study.scene, name, (low, high)),)
        ]
        values = [(f"{v.real:.6g}", f"{v.imag:.6g}", f"{abs(v):.6g}") for v in orbit.multipliers.astype(complex)]
        title = f"Orbit of {orbit.period:.8g} s, {_word(orbit)}"
        right = frozenset({1, 2})
        return [
            Cells(title, ("signal", "minimum", "maximum"), rows, right=right),
            Cells("Multipliers", ("real", "imaginary", "absolute"), values, right=frozenset({0, 1, 2})),
        ]
    over, by = _over(study)
    marks: list[tuple[str, ...]] = [
        (m.kind, f"{m.orbit.value * by:.6g}", f"{m.orbit.period:.6g}", f"{m.multiplier.real:.4f}", f"{m.multiplier.imag:.4f}")
        for m in study.marks
    ]
    regimes = [
        (
            f"{m.value * by:.6g}",
            m.kind,
            str(m.stable),
            str(m.periods or "-"),
            f"{m.exponent:.4g}",
            f"{m.error:.2g}" if m.error else "-",
        )
        for m in study.motions
    ]
    header = ("bifurcation", over, "period, s", "multiplier, real", "imaginary")
    branches: list[tuple[str, ...]] = [
        (str(k), str(b.multiple), str(len(b.points)), *_range(b, by), f"{sum(p.stable for p in b.points)}")
        for k, b in enumerate(study.branches, 1)
    ]
    columns = ("branch", "periods", "orbits", "from", "to", "stable")
    right = frozenset(range(1, 6))
    cells = [Cells("Bifurcations", header, marks, right=right), Cells("Branches", columns, branches, right=right)]
    return [*cells, Cells("Motions", (over, *MOTION_COLUMNS), regimes, right=right - {1})] if regimes else cells


def for_orbit_map(study: OrbitMap, directory: str | Path) -> Path:
    """`report.html` of orbits over two parameters."""
    (over, by), (across, up) = _axes(study)
    x, y = [by * motion.value for motion in study.rows[0][1].motions], [up * value for value, _ in study.rows]
    map_of = Picture(x, y, study.exponents, "largest exponent, 1/s", "diverging", (0.0,))
    kinds: dict[str, list[tuple[float, float]]] = {}
    for value, mark in study.marks:
        kinds.setdefault(mark.kind, []).append((by * mark.orbit.value, up * value))
    points = tuple(Series(kind, np.array(at)[:, 0], np.array(at)[:, 1], "points") for kind, at in kinds.items())
    chaotic = np.array(
        [(by * m.value, up * value) for value, row in study.rows for m in row.motions if m.kind == CHAOTIC]
    ).reshape(-1, 2)
    text = (
        "The largest Lyapunov exponent: of a stable orbit where one was found, else measured along a run. Above 0 (line) the motion is "
        "chaotic where the exponent is larger than its error, at the dots. Other motions may exist beside the one that is shown."
    )
    dots = Series("chaotic", chaotic[:, 0], chaotic[:, 1], "points")
    chart = Chart("Largest exponents", over, (Panel(across, (dots,), picture=map_of),), text, height=420)
    bifurcations = Chart("Bifurcations", over, (Panel(across, points),), height=420)
    blocks: list[Block] = [draw_chart(chart), draw_chart(bifurcations), map_cells(study)]
    notes = [
        f"{_place(study.scene, study.across, v)}, {_place(study.scene, study.over, at)}: {why}."
        for v, row in study.rows
        for at, why in row.gaps
    ]
    notes += [
        f"{_place(study.scene, study.across, v)}, branch {k}: {'; '.join(branch.ends)}."
        for v, row in study.rows
        for k, branch in enumerate(row.branches, 1)
    ]
    blocks.append(Text(notes, "note"))
    lead = "Fixed points of the map over a period, and exponents of motions where none is stable."
    page = Page(study.scene.title or study.scene.name, lead, [Section("Periodic orbits over two parameters", blocks)])
    return write_page(page, Path(directory) / "report.html")


def _axes(study: OrbitMap) -> tuple[tuple[str, float], tuple[str, float]]:
    """Both parameters as `_shown`."""
    at = [motion.value for motion in study.rows[0][1].motions]
    return _shown(study.scene, study.over, at), _shown(study.scene, study.across, [value for value, _ in study.rows])


def map_cells(study: OrbitMap) -> Cells:
    """For each value of the second parameter how many of the first have motions of each kind, and which are chaotic."""
    (over, by), (across, up) = _axes(study)
    rows = []
    for value, row in study.rows:
        kinds = [motion.kind for motion in row.motions]
        which = ", ".join(f"{by * motion.value:.4g}" for motion in row.motions if motion.kind == CHAOTIC)
        rows.append((f"{up * value:.4g}", *(str(kinds.count(kind)) for kind in KINDS), str(len(row.marks)), which))
    header = (across, *KINDS, "bifurcations", f"chaotic at {over}")
    return Cells("Motions", header, rows, right=frozenset(range(len(KINDS) + 2)))


def _range(branch: Branch, by: float) -> tuple[str, str]:
    values = [by * point.value for point in branch.points]
    return f"{min(values):.6g}", f"{max(values):.6g}"


def _word(orbit: Orbit) -> str:
    return "stable" if orbit.stable else "unstable"


def _figures(study: Orbits) -> list[Figure]:
    if not study.parameter:
        return []
    moving = [k for k in range(len(study.signals)) if any((p.high - p.low)[k] > 0.0 for b in study.branches for p in b.points)]
    drawn = moving[:SIGNALS]
    over, by = _over(study)
    swings = [_panel(study, "amplitude", _amplitudes, k, by) for k in drawn]
    sections = [_panel(study, "section", _sections, k, by) for k in drawn]
    text = "Solid: stable. Dashed: unstable. At a period doubling the branch of the doubled period begins."
    chart = Chart(f"Orbits over {study.parameter}", over, tuple(swings), f"Half of maximum less minimum. {text}", height=300)
    cut = Chart("Sections", over, tuple(sections), f"Signals at the beginning of each period. {text}", height=300)
    return [draw_chart(chart), draw_chart(cut)]


def _amplitudes(orbit: Orbit) -> np.ndarray:
    return 0.5 * (orbit.high - orbit.low)[None, :]


def _sections(orbit: Orbit) -> np.ndarray:
    return orbit.sections


def _panel(study: Orbits, what: str, of: Callable[[Orbit], np.ndarray], signal: int, by: float) -> Panel:
    """by: factor of the parameter."""
    points = [point for branch in study.branches for point in branch.points]
    label, factor = _shown(study.scene, study.signals[signal], [float(v) for p in points for v in of(p)[:, signal]])
    lines: list[Series] = []
    for branch in study.branches:
        for stretch in _stretches(branch):
            values = factor * np.array([of(point)[:, signal] for point in stretch])
            at = by * np.array([point.value for point in stretch])
            kind = "line" if stretch[-1].stable else "dashed"
            lines += [Series(_name(branch, stretch[-1]), at, values[:, k], kind) for k in range(values.shape[1])]
    kinds: dict[str, list[tuple[float, float]]] = {}
    for mark in study.marks:
        kinds.setdefault(mark.kind, []).extend((by * mark.orbit.value, factor * float(v)) for v in of(mark.orbit)[:, signal])
    lines += [Series(kind, np.array(at)[:, 0], np.array(at)[:, 1], "points") for kind, at in kinds.items()]
    return Panel(f"{what} of {label}", tuple(lines))


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
