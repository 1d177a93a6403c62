"""One opening of a scene for a filter, from the survey of its cells on: for a record, or for measurements that are going to come."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ..scene.scene import Scene, read_toml
from ..settings.estimate import EstimateSettings
from ..settings.messages import validated
from .answer import Parameter
from .beliefs import Belief, Ensemble, Extended, Unscented
from .filtering import Filter
from .measurements import Measurements
from .model import Model
from .suspects import Suspected, suspected

EXTENDED, UNSCENTED, ENSEMBLE = "extended", "unscented", "ensemble"
PlanLike = EstimateSettings | Mapping[str, Any] | str | Path


def plan_of(plan: PlanLike, folder: str | Path = ".") -> tuple[EstimateSettings, str, Path]:
    """A checked plan, its name in messages, and the folder of its files; raises `BadInput`."""
    where, folder = "plan", Path(folder)
    if isinstance(plan, str | Path):
        where, folder = Path(plan).name, Path(plan).parent
        plan = read_toml(Path(plan), where, "plan")
    return validated(EstimateSettings, plan, where), where, folder


class FilteredScene:
    """A model of the scene, beliefs of what is not known of it, and filters that take them on.

    name: of the kind of filter.  noise: (k,) of the signals, NaN for what is not known.  suspected: what the last filter doubts.
    """

    def __init__(self, scene: Scene, plan: EstimateSettings, measured: Measurements, stack: ExitStack, where: str, steps: int):
        """steps: macro steps that are going to be made.  stack: closes the units."""
        self.plan, self.where = plan, where
        self.model = model = Model(scene, plan, stack, steps, where)
        self.name = plan.filter or (ENSEMBLE if model.large else EXTENDED)
        self.measured = measured.within(model.block.time, np.inf)
        self.noise = measured.noise
        self.suspected: Suspected | None = None

    def _belief(self, doubts: bool) -> Belief:
        if self.name == ENSEMBLE:
            return Ensemble(self.model, self.plan.members, self.plan.inflation, self.plan.seed)
        if self.name == UNSCENTED:
            return Unscented(self.model)
        belief = Extended(self.model)
        if doubts:
            some = self.suspected = suspected(self.model, self.plan.suspected, self.measured.signals, self.noise, self.where)
            belief = Extended(self.model, some.cells, some.by)
            belief.sensitivities = some.start.copy()
        return belief

    def filter(self, doubts: bool, smooth: bool, most: int | None = None) -> Filter:
        """A filter at the start; doubts: with what the verdict doubts.  smooth, most: as of `Filter`."""
        rows = np.concatenate([self.model.y_rows, self.model.state_rows])
        return Filter(self.model, self._belief(doubts), self.measured.signals, self.noise, rows, smooth, most)

    @cached_property
    def columns(self) -> dict[int, str]:
        """What a track keeps: places of its columns, and names, each once, of recorded signals and of states."""
        model = self.model
        names = model.state_names()
        every = [*model.signals, *(names.get(int(c), "") for c in model.live[model.state_rows])]
        return {k: n for k, n in enumerate(every) if n and n not in every[:k]}

    def parameters(self, belief: Belief) -> tuple[Parameter, ...]:
        """Parameters and inputs as they are believed."""
        deviations = np.sqrt((belief.Tq**2).sum(axis=1))
        return tuple(Parameter.of(u, v, d) for u, v, d in zip(self.model.unknowns, belief.q, deviations, strict=True))
