"""A filter that goes on while measurements arrive, and what it knows at an instant.

It is the filter of `estimate`, without a smoother. A signal with a delay is compared with what the scene was when it was measured, so
the estimate stands behind the clock by the longest delay of the plan.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import cached_property
from math import isfinite
from typing import Any

import numpy as np

from ...components.core.errors import BadInput, nearest, pick
from ..engine.algorithms import Master
from ..scene.measured import amount
from ..scene.scene import Scene
from .answer import Parameter, shown
from .filtered_scene import FilteredScene, PlanLike, plan_of
from .measurements import Measurements, sensors_of
from .suspects import judged
from .verdict import Verdict, verdict

WINDOW = 2000  # of the last innovations, which the verdict is about


@dataclass(frozen=True)
class Present:
    """What measurements up to now say of an instant, `time`, s. parameters: and inputs.  names: of signals and states."""

    time: float
    parameters: tuple[Parameter, ...]
    _columns: np.ndarray = field(repr=False)
    names: tuple[str, ...]
    values: np.ndarray
    deviations: np.ndarray
    _judge: Callable[[], Verdict] = field(repr=False)

    def __getitem__(self, name: str) -> Parameter:
        """A parameter or an input."""
        known = {p.name: p for p in self.parameters}
        pick(name, known, "assimilate", "an estimated parameter")
        return known[name]

    def covariance(self, names: Sequence[str]) -> np.ndarray:
        """(n, n) of estimated parameters and inputs."""
        known = [p.name for p in self.parameters]
        for name in names:
            pick(name, known, "assimilate", "an estimated parameter")
        T = self._columns[[known.index(name) for name in names]]
        return T @ T.T

    def signal(self, name: str) -> tuple[float, float]:
        """(mean, standard deviation) of a recorded output or a state."""
        pick(name, self.names, "assimilate", "a recorded output or a state")
        k = self.names.index(name)
        return float(self.values[k]), float(self.deviations[k])

    @cached_property
    def verdict(self) -> Verdict:
        """Whether the model explains the last measurements, `WINDOW` at most. It is asked for before the next ones come."""
        return self._judge()

    @property
    def explains(self) -> bool:
        """Whether no test says otherwise."""
        return self.verdict.explains

    def __repr__(self) -> str:
        lines = (f"{p.name}: {shown(p.value, p.deviation)} {'' if p.unit == '1' else p.unit}".rstrip() for p in self.parameters)
        return "\n".join([f"<Estimate at t = {self.time:.9g} s>", *lines])


class Live:
    """An estimate that is held: `assimilate` takes it on."""

    def __init__(self, scene: Scene, plan: PlanLike, inputs: Mapping[str, float], stack: ExitStack):
        """inputs: what acts from the start, by name.  stack: closes the units. Raises `BadInput`."""
        wanted, where, _ = plan_of(plan)
        self._where = f"{where}: assimilate"
        sensors = sensors_of(wanted, scene, where)
        if missing := [n for n, s in zip(sensors.signals, sensors.noise, strict=True) if np.isnan(s)]:
            remedy = "cosimo.estimate finds it from a record."
            raise BadInput(f"{where}: measured", f"no noise of {missing[0]}", "the noise of each signal", remedy)
        steps = int((scene.stop_time - scene.start_time) / scene.master.step)
        doubts = wanted.model_copy(update={"suspected": wanted.suspected or ()})
        self._filtered = FilteredScene(scene, doubts, sensors, stack, where, steps)
        self._sensors, self.model = self._filtered.measured, self._filtered.model
        cells, numbers = self._known(inputs)
        self.model.block.initial[cells] = numbers
        self._filter = self._filtered.filter(bool(doubts.suspected), smooth=False, most=WINDOW)
        self._measured = wanted.measured
        self._last = self.model.block.time + max(m.lag for m in wanted.measured)

    @property
    def time(self) -> float:
        """Where the estimate stands, s."""
        return self.model.block.time

    def assimilate(self, t: float, values: Mapping[str, Any], inputs: Mapping[str, float]) -> Present:
        """On to the time t, s, less the longest delay, with what sensors show at t; inputs: what acts from now on, by name.

        Raises `BadInput` for names, values and times, `StepFailed` where the scene cannot go on.
        """
        if not (isinstance(t, int | float) and isfinite(t) and t > self._last):
            raise BadInput(f"{self._where}: t", f"{t!r} s", f"a time behind {self._last:.9g} s, the last one", "Times rise.")
        which, numbers, units = [], [], dict(zip(self._sensors.signals, self._sensors.units, strict=True))
        for name, value in values.items():
            if name not in units:
                raise BadInput(self._where, repr(name), "a measured signal of the plan", nearest(name, units))
            one = self._measured[k := self._sensors.signals.index(name)]
            if isinstance(value, str) and one.scale != 1.0:
                raise BadInput(f"{self._where}: {name}", f"{value!r} beside scale = {one.scale:g}", "a number")
            number = one.scaled(amount(value, units[name], f"{self._where}: {name}", finite=False))
            if not np.isnan(number):  # a gap
                which.append(k)
                numbers.append(number)
        if infinite := [self._sensors.signals[k] for k, v in zip(which, numbers, strict=True) if not isfinite(v)]:
            raise BadInput(f"{self._where}: {infinite[0]}", "an infinite number", "a number, or NaN for a gap")
        self._filter.belief.put(*self._known(inputs))
        time = np.array([t - self._measured[k].lag for k in which])
        seen = time > self.time
        horizon = t - max(m.lag for m in self._measured)
        self._filter.assimilate(horizon, time[seen], np.array(which, dtype=np.intp)[seen], np.array(numbers)[seen])
        self._last = t
        return self.present()

    def _known(self, inputs: Mapping[str, float]) -> tuple[np.ndarray, np.ndarray]:
        """Cells and numbers, (n,), of inputs that are not estimated."""
        taken = {u.name for u in self.model.unknowns}
        known = {n: v for n, v in inputs.items() if n not in taken}
        return self.model.block.places(known), np.array(list(known.values()), dtype=float)

    def present(self) -> Present:
        """What is known where the estimate stands."""
        track, names = self._filter.track, self._filtered.columns
        kept, belief = list(names), self._filter.belief
        slopes = np.array([u.bounds.slope(v) for u, v in zip(self.model.unknowns, belief.q, strict=True)])
        return Present(
            self.time,
            self._filtered.parameters(belief),
            slopes[:, None] * belief.Tq,
            tuple(names.values()),
            track.values[-1][kept],
            track.columns[-1][kept, 0],
            self._verdict,
        )

    def _verdict(self) -> Verdict:
        belief, innovations = self._filter.belief, self._filter.innovations
        if not innovations.which:
            raise BadInput(f"{self._where}: verdict", "no measurement so far", "a verdict behind some")
        sensors: Measurements = self._sensors
        some = self._filtered.suspected
        suspects = judged(self.model, some, sensors.signals, sensors.units, innovations) if some else []
        deviations = np.sqrt((belief.Tq**2).sum(axis=1))
        return verdict(sensors, innovations, self.model.unknowns, belief.q, deviations, suspects)

    def give(self, master: Master) -> None:
        """Let another opening of the scene stand at the mean of the estimate."""
        self.model.block.give(master)
