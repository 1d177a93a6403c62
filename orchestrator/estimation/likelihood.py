"""The likelihood of measurements under a filter, as a function of numbers of the scene that it takes as known."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...components.core.errors import BadInput, StepFailed
from ..scene.scene import Scene
from ..settings.estimate import EstimatedSettings, LikelihoodSettings
from .bounds import Bounds
from .filtered_scene import ENSEMBLE, FilteredScene
from .measurements import measurements_of

DIFFERENCES = "differences (how the gain of a filter moves is not among the derivatives of a scene)"


class FilterLikelihood:
    """names, low, high, start: of the numbers x, (n,). The rest of the plan, `estimated` and `states`, is the filter's own."""

    def __init__(self, scene: Scene, plan: LikelihoodSettings, folder: Path, where: str, stack: ExitStack):
        """stack: closes the units. Raises `BadInput` as an estimate, and for measurements whose noise is not given."""
        if both := next((n for n in plan.vary if n in plan.estimated), None):
            raise BadInput(f"{where}: vary", f"{both!r}, which is estimated", "a number that the filter takes as known")
        self._where, vary = where, plan.vary
        measured = measurements_of(plan, scene, folder, {}, where)
        if np.isnan(measured.noise).any():
            raise BadInput(f"{where}: measured", "a measurement without noise", "the noise of each")
        held = {}
        for name, one in vary.items():
            width, start = one.high - one.low, 0.5 * (one.low + one.high) if one.start is None else one.start
            held[name] = EstimatedSettings(start=start, deviation=width, low=one.low - width, high=one.high + width)
        whole = plan.model_copy(update={"estimated": {**held, **plan.estimated}, "suspected": ()})
        first, h = scene.start_time, scene.master.step
        if not measured.time[-1] > first:
            raise BadInput(f"{where}: measured", f"times up to {measured.time[-1]:g} s", f"some behind the start, {first:g} s")
        steps = np.ceil((measured.time[-1] - first) / h)
        scene = scene.with_changes({"stop_time": first + h * (steps + 2.0)})
        self._filtered = FilteredScene(scene, whole, measured, stack, where, int(steps))
        self.names = tuple(vary)
        self.low, self.high = (np.array([getattr(one, end) for one in vary.values()]) for end in ("low", "high"))
        self.start = np.array([one.start for one in held.values()], dtype=float)
        self._step, self._width = plan.step, self.high - self.low

    def __call__(self, x: np.ndarray) -> float:
        """At x, (n,); minus infinity where the scene cannot go on."""
        model = self._filtered.model
        for k, value in enumerate(x):
            model.unknowns[k] = replace(model.unknowns[k], bounds=Bounds(-np.inf, np.inf), mean=float(value), deviation=0.0)
        try:
            run = self._filtered.filter(doubts=False, smooth=False)
            run.run(self._filtered.measured)
        except StepFailed:
            return -np.inf
        density = run.innovations.log_likelihood
        return density if np.isfinite(density) else -np.inf

    def gradient(self, x: np.ndarray) -> np.ndarray:
        """Central differences, (n,), to one side at a bound. Raises `BadInput` for an ensemble, and where the scene cannot go on."""
        if self._filtered.name == ENSEMBLE:
            raise BadInput(
                f"{self._where}: gradient", "the filter 'ensemble'", "'extended' or 'unscented'", "Members are drawn at random."
            )
        slopes = np.empty(x.size)
        for k, step in enumerate(self._step * self._width):
            ends = [x + np.eye(x.size)[k] * (min(max(x[k] + way, self.low[k]), self.high[k]) - x[k]) for way in (-step, step)]
            back, ahead = (self(end) for end in ends)
            if not np.isfinite(ahead - back):
                raise BadInput(
                    "likelihood: x", f"{x.tolist()}, beside which the scene cannot go on", "runs that come to their end"
                )
            slopes[k] = (ahead - back) / (ends[1][k] - ends[0][k])
        return slopes

    def how(self, name: str) -> str:
        """What the derivatives by a number are, in words."""
        return DIFFERENCES
