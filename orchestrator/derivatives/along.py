"""Derivatives of functions of a run: along the derivatives of its signals, at one point after another.

A function of a run is a function of its signals. Its derivative by a parameter is that along their tangents, by differences in the
space of signals: nothing but the function is repeated, so that these have many digits.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace

import numpy as np

from ...components.core.errors import BadInput, StepFailed
from ...components.core.kernels import COMPILED
from ..run.results import Result
from ..scene.names import displaced, numerical_of
from ..scene.scene import Scene

ALONG = 1e-5  # length of differences in the space of signals, relative to the largest value of the signal that moves most
AGREE = 1e-3  # relative: two derivatives are one number
Values = Callable[[Result], np.ndarray]  # (m,) numbers of a run


def length(base: Result, tangents: Mapping[str, np.ndarray], at: float) -> float:
    """Of differences along tangents of the recorded signals, by a parameter that is `at`; 0 where these are not finite."""
    shares = [
        np.max(np.abs(t)) / size for s, t in tangents.items() if (size := np.max(np.abs(base.columns[s]), initial=0.0)) > 0.0
    ]
    fastest = max(shares, default=0.0)
    return ALONG / max(fastest, 1.0 / max(abs(at), 1.0)) if np.isfinite(fastest) else 0.0


def along(
    base: Result, tangents: Mapping[str, np.ndarray], values: Values, first: np.ndarray, parameter: str, at: float, step: float
) -> tuple[np.ndarray, np.ndarray]:
    """(derivative (m,) of numbers of a run, the difference (m,) of the derivatives to either side), over so long a step.

    first: the numbers of the run itself, (m,).
    """
    ahead, back = (
        values(
            replace(
                base,
                columns={s: base.columns[s] + way * t for s, t in tangents.items()},
                scene=displaced(base.scene, {parameter: at + way}),
            )
        )
        for way in (step, -step)
    )
    return (ahead - back) / (2.0 * step), (ahead - 2.0 * first + back) / step


class PointDerivatives:
    """Derivatives of numbers of a run by parameters, at one point after another.

    points: how many.  reasons: of parameters that have none, by name.  missing: of the others, at how many points there was none.
    """

    def __init__(self, scene: Scene, names: Sequence[str], stack: ExitStack):
        """`stack` closes the units. A scene without derivatives is no error: each parameter has the reason."""
        self.points, self.missing = 0, dict.fromkeys(names, 0)
        self.reasons = numerical_of(scene, names)
        try:
            if not COMPILED:
                raise BadInput(scene.name, "no Numba", "machine code, which derivatives are made of")
            from .tangent_block import TangentBlock
            from .tangent_run import recorded

            self._block, self._recorded = TangentBlock(scene, stack), recorded
        except BadInput as error:
            self.reasons = dict.fromkeys(names, str(error))
            return
        known = self._block.parameters()
        if unknown := [n for n in names if n not in known]:  # the run that the tangents follow cannot have their numbers
            self.reasons = dict.fromkeys(names, f"{', '.join(unknown)}: not a real parameter that derivatives can be taken by")

    def __call__(self, point: Mapping[str, float], values: Values) -> np.ndarray:
        """(m, n) at a point, in the order of its names; NaN where there is none, as by a parameter at the boundary of a decision."""
        names = [n for n in point if n not in self.reasons]
        if not names:
            return np.full((0, len(point)), np.nan)
        self.points += 1
        try:
            base, tangents, at_tie = self._recorded(self._block, point, names)
        except StepFailed:
            self.missing.update({n: self.missing[n] + 1 for n in names})
            return np.full((0, len(point)), np.nan)
        first = values(base)
        columns = dict.fromkeys(point, np.full(first.shape, np.nan))
        for name, by, tied in zip(names, tangents, at_tie, strict=True):
            step = length(base, by, point[name])
            if step and not tied:
                column, bend = along(base, by, values, first, name, point[name], step)
                if np.linalg.norm(bend) <= AGREE * np.linalg.norm(column):
                    columns[name] = column
            self.missing[name] += int(np.isnan(columns[name]).any())
        return np.stack(list(columns.values()), axis=1)

    def how(self, parameter: str) -> str:
        """What the derivatives by a parameter were, in words."""
        if reason := self.reasons.get(parameter):
            return f"differences ({reason})"
        missing = self.missing[parameter]
        return f"exact, but differences at {missing} of {self.points} points" if missing else "exact"
