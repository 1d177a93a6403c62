"""The likelihood of measurements as a function of parameters, with its gradient: for optimizers and samplers of others."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np

from ....components.core.errors import BadInput
from ...estimation.likelihood import FilterLikelihood
from ...scene.scene import Scene
from ...settings.answers import FitSettings
from ...settings.estimate import LikelihoodSettings
from ...settings.messages import validated
from .measures import Summarize
from .plan import read_settings
from .residuals import Residuals, residuals_of
from .searches import jacobian


class Likelihood:
    """log p(measurements | x) of a scene, with independent normal noise, over parameters x (n,).

    Of a plan with `measured`, as `cosimo estimate` has it, and [vary], it is the likelihood of the filter's innovations: disturbances and
    what is estimated are integrated over. Of a plan of a fit nothing disturbs the scene. names: of x.  low, high, start: (n,).  exact: of
    each parameter whether its derivative was exact so far, and why not. Outside of its bounds, and where a run fails, it is minus
    infinity. Close it, or use `with`.
    """

    def __init__(
        self,
        scene: Scene,
        settings: FitSettings | Mapping[str, Any] | str | Path,
        folder: str | Path = ".",
        summarize: Summarize | None = None,
    ):
        """Arguments as of a fit. Raises `BadInput`, also for measurements without a standard deviation."""
        self._stack = ExitStack()
        self._of: Residuals | FilterLikelihood
        data, name, folder = read_settings(settings, "likelihood", scene, Path(folder))
        try:
            if isinstance(data, Mapping) and "measured" in data:
                plan = validated(LikelihoodSettings, data, name)
                self._of = FilterLikelihood(scene, plan, folder, name, self._stack)
            else:
                self._of = self._stack.enter_context(residuals_of(scene, data, None, folder, jobs=1, summarize=summarize))
                wanted = self._of.wanted
                if not wanted.noise_known or wanted.loss != "linear":
                    raise BadInput(
                        "likelihood", "a measurement without noise, or a loss", "the noise of each, and loss = 'linear'"
                    )
        except BadInput:
            self.close()
            raise
        self.names, self.low, self.high = tuple(self._of.names), self._of.low, self._of.high
        self.start = self._of.start

    def __call__(self, x: np.ndarray) -> float:
        """At x, (n,), in the units of the scene's parameters."""
        if not self._inside(x):
            return -np.inf
        if isinstance(self._of, FilterLikelihood):
            return self._of(np.asarray(x, dtype=float))
        (row,) = self._of.rows([np.asarray(x, dtype=float)])
        return self._of.log_density(row)

    def gradient(self, x: np.ndarray) -> np.ndarray:
        """Its derivatives at x, (n,): by one run with tangents where there are some, else by differences, see `exact`.

        Raises `BadInput` outside, and for an ensemble of a filter.
        """
        if not self._inside(x):
            raise BadInput("likelihood: x", f"{np.asarray(x).tolist()}", "finite values within the bounds")
        of, width = self._of, self.high - self.low
        if isinstance(of, FilterLikelihood):
            return of.gradient(np.asarray(x, dtype=float))

        def values(points: Any) -> list[np.ndarray]:
            p = [self.low + u * width for u in points]
            return [of(q, row) for q, row in zip(p, of.rows(p), strict=True)]

        p = np.asarray(x, dtype=float)
        (row,) = of.rows([p])
        residuals = of(p, row)
        if not np.isfinite(residuals).all():
            raise BadInput("likelihood: x", f"a run that is {row.outcome}: {row.reason}", "a run that comes to its end")
        of.first(p, row)
        J = jacobian(values, (p - self.low) / width, of.wanted.step, of.names, of.slopes(p) * width) / width
        return -J.T @ residuals

    @property
    def exact(self) -> dict[str, str]:
        """Of each parameter."""
        return {n: self._of.how(n) for n in self.names}

    def _inside(self, x: np.ndarray) -> bool:
        x = np.asarray(x, dtype=float)
        if x.shape != self.low.shape:
            raise BadInput("likelihood: x", f"shape {x.shape}", f"({self.low.size},): {', '.join(self.names)}")
        return bool(np.isfinite(x).all() and (x >= self.low).all() and (x <= self.high).all())

    def close(self) -> None:
        """Close the units."""
        self._stack.close()

    def __enter__(self) -> Likelihood:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
