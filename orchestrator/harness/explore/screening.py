"""Which parameters of a scene a page offers first: those that move its figures most, by a few elementary effects."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...scene.scene import Scene
from ..many.plan import from_columns
from ..sweep import sweep

if TYPE_CHECKING:
    from ...run.results import Result
    from ..summary import Summary

SHARE = 0.1  # of its value, by which a parameter moves
BASES = 2  # points that effects start from: the scene, and one beside it
SEED = 20261126


def screened(scene: Scene, values: Mapping[str, float], limits: Mapping[str, tuple[float, float]], jobs: int | None) -> list[str]:
    """The parameters by "unit.parameter", those first whose change of 10 % moves a figure of the system by most of its size.

    A radial plan of elementary effects (Campolongo et al., Computer Physics Communications 182 (2011) 978): around each base each
    parameter moves alone. values: of the scene.
    """
    names = [name for name, value in values.items() if value]
    if not names:
        return []
    moved = np.random.default_rng(SEED).choice((-0.5, 0.5), len(names)) * SHARE
    rows = []
    for base in range(BASES):
        start = [_within(values[n] * (1.0 + base * moved[i]), limits[n]) for i, n in enumerate(names)]
        rows.append(start)
        for i, name in enumerate(names):
            up = _within(start[i] + SHARE * abs(values[name]), limits[name])
            rows.append([*start[:i], up if up != start[i] else start[i] - SHARE * abs(values[name]), *start[i + 1 :]])
    columns = {name: [row[i] for row in rows] for i, name in enumerate(names)}
    points = sweep(scene, from_columns(columns), jobs=jobs, summarize=_summary, verify=False)
    return _ranked(names, points.measures)


def _summary(result: Result) -> Summary:
    """Of a worker's run, too: it has to have a name."""
    return tuple(result.summary)


def _within(value: float, limits: tuple[float, float]) -> float:
    return float(min(max(value, limits[0]), limits[1]))


def _ranked(names: Sequence[str], measures: Mapping[str, np.ndarray]) -> list[str]:
    """measures: (bases * (1 + parameters),) each."""
    effects = np.zeros(len(names))
    for numbers in measures.values():
        of_base = np.asarray(numbers, dtype=float).reshape(BASES, len(names) + 1)
        size = np.nanmax(np.abs(of_base)) if np.isfinite(of_base).any() else 0.0
        if size > 0.0:
            change = np.abs(of_base[:, 1:] - of_base[:, :1])
            effects = np.maximum(effects, np.nan_to_num(np.where(np.isfinite(change), change, 0.0).mean(axis=0) / size))
    return [names[i] for i in np.argsort(-effects, kind="stable")]
