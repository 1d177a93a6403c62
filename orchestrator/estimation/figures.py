"""Key results of a run as measurements tell them: over paths that the smoothed estimate leaves possible.

A path is drawn from its end to its start, over what each column of the filter was made of, as the smoother goes back. So all that
follows from states, parameters and disturbances together is in it, and a figure of the path needs no further run.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite

import numpy as np

from ...components.core.errors import BadInput, nearest
from ..run.key_results import STATISTICS, KeyResults, after_transient, known_results
from ..run.results import Result
from ..run.run_record import RunRecord, UnitRecord
from ..scene.names import displaced
from ..scene.scene import Scene
from .answer import FigureBand
from .filtered_scene import FilteredScene
from .filtering import Track

PATHS = 200  # drawn: ends of bands are known to about a sixth of a deviation
MISSING = 0.05  # of the paths: a figure that more of them do not have is left out


def drawn_paths(track: Track, rows: Sequence[int], seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Of a track with its way back: (rows over time (k, n, S), numbers q of the unknowns at the end (p, S)); the first path is the mean."""
    rng, some = np.random.default_rng(seed), list(rows)
    mean, covariance = track.at_end()
    sizes, axes = np.linalg.eigh(covariance)
    drawn = (axes * np.sqrt(np.maximum(sizes, 0.0))) @ axes.T @ rng.standard_normal((mean.size, PATHS))
    a = mean[:, None] + np.hstack([np.zeros((mean.size, 1)), drawn])
    q, values = track.q[-1][:, None] + track.q_columns[-1] @ a, []
    for k in range(len(track.time) - 1, -1, -1):
        if k < len(track.back):
            w, A, C = track.back[k]
            a = w[:, None] + A @ a
            if C.any():
                sizes, axes = np.linalg.eigh(C)
                a[:, 1:] += (axes * np.sqrt(np.maximum(sizes, 0.0))) @ rng.standard_normal((sizes.size, PATHS))
        values.append(track.values[k][some][:, None] + track.columns[k][some] @ a)
    return np.array(values[::-1]), q


def kind_of(scene: Scene, figure: str, where: str) -> tuple[str, str]:
    """The signal and the kind of "unit.output, kind"; raises `BadInput`."""
    signal, _, kind = (part.strip() for part in figure.rpartition(","))
    known = [".".join(end) for end in scene.coupling.signals]
    if signal not in known or kind not in STATISTICS:
        expected = f'"unit.output, kind" of a recorded output, with a kind of {", ".join(STATISTICS)}'
        raise BadInput(f"{where}: figures", repr(figure), expected, nearest(signal, known) if signal not in known else "")
    return signal, kind


def figure_bands(filtered: FilteredScene, track: Track, where: str) -> tuple[FigureBand, ...]:
    """Headline figures of the scene, and those that the plan names, which all paths have."""
    model, scene = filtered.model, filtered.model.scene
    wanted = [(name, *kind_of(scene, name, where)) for name in filtered.plan.figures]
    ends = [".".join(end) for end in scene.coupling.signals]
    units = {
        n: scene.coupling.interfaces[end[0]].outputs[end[1]].unit for n, end in zip(ends, scene.coupling.signals, strict=True)
    }
    places = [model.signals.index(n) for n in ends]
    base = Result(scene, np.array(track.time), {}, {}, units, RunRecord(outcome="done"))
    if not wanted and not known_results(_path(filtered, base, ends, np.array(track.values)[:, places], {})):
        return ()
    inputs = {f"{unit}.{name}" for unit, interface in scene.coupling.interfaces.items() for name in interface.inputs}
    values, q = drawn_paths(track, places)
    of_paths: list[KeyResults] = []
    for s in range(values.shape[2]):
        numbers = {u.name: u.bounds.outer(v) for u, v in zip(model.unknowns, q[:, s], strict=True) if u.name not in inputs}
        result = _path(filtered, base, ends, values[:, :, s], numbers)
        rows = after_transient(result)
        figures = known_results(result)
        figures.add((name, STATISTICS[kind](result[signal][rows]), units[signal]) for name, signal, kind in wanted)
        of_paths.append(figures)
    bands = []
    for name, unit in of_paths[0].units.items():
        numbers_of = np.array([figures.get(name, np.nan) for figures in of_paths])
        known = numbers_of[1:][np.isfinite(numbers_of[1:])]
        if isfinite(numbers_of[0]) and known.size >= (1.0 - MISSING) * PATHS:
            low, high = np.quantile(known, [0.025, 0.975])
            bands.append(
                FigureBand(name, unit, float(known.mean()), float(known.std()), float(low), float(high), float(numbers_of[0]))
            )
    return tuple(bands)


def _path(filtered: FilteredScene, base: Result, ends: Sequence[str], values: np.ndarray, numbers: dict[str, float]) -> Result:
    """A run that goes along a path, (k, n), with some numbers of parameters."""
    own = {u.name: u.component.parameters for u in filtered.model.block.layout.units}
    parts = {unit: {n: numbers.get(f"{unit}.{n}", v) for n, v in some.items()} for unit, some in own.items()}
    info = RunRecord(outcome="done", units={unit: UnitRecord(parameters=some) for unit, some in parts.items()})
    scene = displaced(base.scene, numbers)
    return Result(scene, base.time, dict(zip(ends, values.T, strict=True)), {}, base.measures, info)
