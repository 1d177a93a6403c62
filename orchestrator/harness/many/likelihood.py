"""The likelihood of measurements as a function of parameters, with its gradient: for optimizers and samplers of others."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np

from ....components.core.errors import BadInput
from ...scene.scene import Scene
from ...settings.answers import FitSettings
from .measures import Summarize
from .residuals import residuals_of
from .searches import jacobian


class Likelihood:
    """log p(measurements | x) of a scene without disturbances, with independent normal noise, over parameters x (n,).

    names: of x.  low, high, start: (n,).  exact: of each parameter whether its derivative was exact so far, and why not. Outside of
    its bounds, and where a run fails, it is minus infinity. Close it, or use `with`.
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
        self._of = self._stack.enter_context(residuals_of(scene, settings, None, Path(folder), jobs=1, summarize=summarize))
        wanted, of = self._of.wanted, self._of
        if not wanted.noise_known or wanted.loss != "linear":
            self.close()
            raise BadInput("likelihood", "a measurement without noise, or a loss", "the noise of each, and loss = 'linear'")
        self.names, self.low, self.high, self.start = tuple(of.names), of.low, of.high, of.start()

    def __call__(self, x: np.ndarray) -> float:
        """At x, (n,), in the units of the scene's parameters."""
        if not self._inside(x):
            return -np.inf
        (row,) = self._of.rows([np.asarray(x, dtype=float)])
        return self._of.log_density(row)

    def gradient(self, x: np.ndarray) -> np.ndarray:
        """Its derivatives at x, (n,): by one run with tangents where there are some, else by differences. Raises `BadInput` outside."""
        if not self._inside(x):
            raise BadInput("likelihood: x", f"{np.asarray(x).tolist()}", "finite values within the bounds")
        of, width = self._of, self.high - self.low

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
