"""The error of single macro steps: when a run has ended, two steps of half the length are compared with one, at some instants.

    d = rms(x(t + H) by two steps - x(t + H) by one) 2^(p + 1) / (2^(p + 1) - 1) / std(x)

is Richardson's estimate of what one macro step H is wrong by, for a coupling that extrapolates with degree p. It shows held
forces that are wrong though they change little from step to step. A small d does not prove that a run is right: errors add up
over the steps, or die out between them.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...components.core.errors import StepFailed
from ..engine.algorithms.energy import EnergyAccount
from ..engine.algorithms.master import Master
from ..engine.coupling.graph import Endpoint
from ..engine.stepping.loop import Steppable, Stepping
from ..engine.stepping.observers import BatchObserver
from ..scene.scene import Scene

SAMPLES = 24  # instants of a run
APART = 3  # macro steps from one to the next, at least


class RepeatedSteps(BatchObserver):
    """Keeps the state at some instants while the run goes on, which changes nothing; the steps are repeated when it has ended."""

    def __init__(self, master: Master, stepping: Stepping, steps: int, account: EnergyAccount | None = None):
        """`steps`: of the whole run, about. `account`: takes part in steps where it corrects them."""
        self._master, self._stepping = master, stepping
        self._stepper: Steppable = account if account is not None and account.correction else master
        self._every, self._calls = max(steps // SAMPLES, APART), 0
        self._saved: list[tuple[int, float, Any]] = []

    def __call__(self, tick: int, t: float) -> None:
        self._calls += 1
        if self._calls % self._every == 0 and self._fits(tick):
            self._saved.append((tick, t, self._stepper.save()))

    def _fits(self, tick: int) -> bool:
        """Whether another step from a tick ends before the run does."""
        return tick + self._stepping.stride <= self._stepping.end

    def keeps(self, n: int) -> range:
        """As in `BatchObserver`."""
        return range(self._every - 1 - self._calls % self._every, n, self._every)

    def observe_saved(self, saved: Sequence[tuple[int, float, Any]]) -> None:
        """As in `BatchObserver`; in batches, no account takes part in steps."""
        self._saved += [one for one in saved if self._fits(one[0])]

    def observe_batch(self, ticks: range, times: object, rows: np.ndarray) -> None:
        """As in `BatchObserver`."""
        self._calls += len(ticks)

    def errors(self) -> Mapping[Endpoint, float]:
        """Estimated error of a macro step (rms) by signal, in the signal's unit; empty where a step cannot be repeated.

        The units are not where the run has ended afterwards.
        """
        master, stepper = self._master, self._stepper
        h = self._stepping.clock.seconds(self._stepping.stride)
        differences = []
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                for _, t, saved in self._saved:
                    stepper.restore(saved)
                    stepper.step(t, h)
                    whole = np.array(master.sample(), dtype=float)
                    stepper.restore(saved)
                    stepper.step(t, 0.5 * h)
                    stepper.step(t + 0.5 * h, 0.5 * h)
                    differences.append(np.array(master.sample(), dtype=float) - whole)
            except StepFailed:
                return {}
            finally:
                for _, _, saved in self._saved:
                    for node, state in zip(master.nodes, getattr(saved, "master", saved).units, strict=True):
                        node.unit.release(state)
        if not differences:
            return {}
        with np.errstate(all="ignore"):
            rms = np.sqrt(np.mean(np.square(differences), axis=0)) / (1.0 - 0.5 ** (master.degree + 1))
        return dict(zip(master.positions, rms.tolist(), strict=True))


def repeatable(scene: Scene) -> bool:
    """Whether steps of a scene can be repeated: fixed steps of coupled components of ours, which keep their whole state."""
    coupling = scene.coupling
    own = all(unit.component and ":" not in unit.component and unit.isolation == "none" for unit in scene.units.values())
    return (own and any(len(group) > 1 for group in coupling.groups) and not coupling.rates and not scene.faults
            and scene.master.control is None and not scene.master.events
            and all(one.saves_state and not one.may_return_early for one in coupling.interfaces.values()))
