"""Macro steps of changing length: estimates of the error of a step, and the controller that chooses the next one.

An error of 1 is what the scene allows: absolute * nominal value + relative * |value|.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Protocol

import numpy as np

from ...settings import ControlSettings
from ...units.interface import Signal
from ..coupling import Coupling
from ..coupling.arrays import is_element
from ..coupling.graph import is_discrete
from .master import Master
from .node import Node

SAFETY = 0.9  # of the step that would just meet the tolerance
SHRINK, GROW = 0.2, 2.0  # limits of one change
HOLD_BELOW, HOLD_ABOVE = 0.8, 1.5  # of the present step: a wish between them leaves it as it is
INTEGRAL, PROPORTIONAL = 0.3, 0.4  # gains of the controller, over the order: Soederlind's PI.3.4 (ACM TOMS 29, 2003)
NEGLIGIBLE = 1e-9  # an error that cannot be distinguished from none
INTERPOLATED_MISS = 0.1  # of the predictor's miss: an input that ended nearer to its value was interpolated


class StepErrorEstimate(Protocol):
    """How a step's error is found. `prepare` comes before the step, `measure` after it."""

    def prepare(self, h: float) -> None:
        """What has to be known before a step of length h."""

    def measure(self, again: Callable[[], None]) -> tuple[float, int]:
        """(error, power of the step that it falls with) of the step just made; `again()` makes it once more, in two halves."""


class Milne:
    """From what predictors of the inputs gave and what the inputs became; needs nothing of the units.

    With inputs of degree p, the predictor is the polynomial through the p + 1 last samples; it misses the value at the end of
    the step by C_p H^(p+1). The input the unit was given errs by a known share of that, on average over the step: by 1/2, 5/12,
    3/8 (p = 0, 1, 2; equal steps) where it was the predictor itself, by 1/2, 1/12, 1/24 where it was interpolated to its new
    value, as in Gauss-Seidel and in iterations: the constants of Adams's formulas, and Milne's device. For unequal steps they
    are integrated. The largest error of all inputs counts; those that change at instants only are left out.
    """

    def __init__(self, master: Master, coupling: Coupling, settings: ControlSettings):
        self._settings, self._master = settings, master
        self._nodes: list[tuple[Node, np.ndarray, np.ndarray]] = []  # with places and nominal values of inputs that are not held
        for node in master.nodes:
            at = [k for k in range(len(node.links)) if k not in node.held]
            signals = [coupling.interfaces[link.target[0]].inputs[link.target[1]] for link in node.links]
            if at:
                self._nodes.append((node, np.array(at), np.array([signals[k].nominal for k in at])))
        self._predicted: list[tuple[np.ndarray, int, tuple[float, float]]] = []  # values, order, shares

    def prepare(self, h: float) -> None:
        self._predicted = []
        self._master.foresee(h)
        for node, at, _ in self._nodes:
            self._predicted.append((node.foreseen()[at], node.n_samples, shares(h, *node.spans)))

    def measure(self, again: Callable[[], None]) -> tuple[float, int]:
        worst, order = 0.0, 3
        for (node, at, nominal), (predicted, count, weights) in zip(self._nodes, self._predicted, strict=True):
            present, ends = node.ends[:, at]
            missed = np.abs(present - predicted)
            interpolated = np.abs(present - ends) < INTERPOLATED_MISS * missed
            allowed = self._settings.absolute * nominal + self._settings.relative * np.abs(present)
            worst = max(worst, float(np.max(np.where(interpolated, weights[1], weights[0]) * missed / allowed)))
            order = min(order, count)
        return worst, order


@lru_cache(maxsize=64)  # steps are held, so the same lengths come again
def shares(h: float, *before: float) -> tuple[float, float]:
    """Mean errors over a step of length h, as shares of the predictor's miss at its end: (extrapolated, interpolated) input.

    `before`: lengths of the steps back to the older samples of the predictor. The errors are those of Newton's formula:
    extrapolation through 0, -h1, -h1 - h2 errs like s (s + h1) (s + h1 + h2), interpolation that has h instead of the oldest
    of these like s (s + h1) (s - h).
    """
    nodes = [0.0, *(-sum(before[: k + 1]) for k in range(len(before)))]
    missed = np.prod([h - node for node in nodes])

    def mean(zeros: list[float]) -> float:
        integral = np.polynomial.polynomial.polyint(np.polynomial.polynomial.polyfromroots(zeros))
        return abs(float(np.polynomial.polynomial.polyval(h, integral) / h / missed))

    return mean(nodes), mean([*nodes[:-1], h])


class Doubling:
    """From a step and the same step in two halves, which are kept; needs units that save their state.

    Their difference over 2^(p+1) - 1 is the halves' error, with inputs of degree p (Richardson). It counts in every output
    that is handed over or a number of its own, whether it is recorded or not, but for those that change at instants only. It costs
    three steps of the units for two.
    """

    def __init__(self, master: Master, coupling: Coupling, settings: ControlSettings):
        self._master, self._settings = master, settings
        known = [(end, k, coupling.interfaces[end[0]].outputs[end[1]]) for end, k in master.positions.items()]
        ends = [(k, one) for end, k, one in known if end in master.network.handed_over or counts_alone(end[1], one)]
        self._at = np.array([k for k, signal in ends if not is_discrete(signal)], dtype=int)
        self._nominal = np.array([signal.nominal for _, signal in ends if not is_discrete(signal)])
        self._counts = 1

    def prepare(self, h: float) -> None:
        self._counts = max((node.n_samples for node in self._master.nodes if node.sources), default=1)

    def measure(self, again: Callable[[], None]) -> tuple[float, int]:
        whole = np.array(self._master.signals)[self._at]
        again()
        halves = np.array(self._master.signals)[self._at]
        allowed = self._settings.absolute * self._nominal + self._settings.relative * np.abs(halves)
        largest = float(np.fmax.reduce(np.abs(halves - whole) / allowed, initial=0.0))  # NaN: an output that nothing uses
        return largest / (2.0**self._counts - 1.0), self._counts + 1


def counts_alone(name: str, signal: Signal) -> bool:
    """Whether an output is a number of its own: no text, and no element of an array."""
    return not signal.is_text and not is_element(name)


class Controller:
    """Chooses the length of the next step, in ticks: a whole number of `unit`, from `unit` to `longest`.

    A PI controller moves a wish after every step, from the error the step would have had if it had been as long as the wish. The
    step follows only when the wish has gone below 0.8 or above 1.5 of it. Otherwise it is held: where two units integrate the
    same flow, their copies part a little with every change of the step (Kyllingstad 2025, arXiv 2512.13845). They still do
    where the error swings by more than that in every period; `max_step` then keeps the step at what is always right.
    A step with an error above 1 shortens the next one at once.
    """

    def __init__(self, first: int, unit: int, longest: int):
        self.unit, self.longest = unit, longest
        self.length = self._rounded(first)
        self.wish, self.error = float(self.length), 1.0

    def _rounded(self, ticks: float) -> int:
        return max(min(int(ticks), self.longest) // self.unit, 1) * self.unit

    def accept(self, ticks: int, error: float, order: int) -> None:
        """A step of so many ticks had this error, and is kept; one that a stop has cut short tells nothing but an excess."""
        if error > 1.0:
            self.reject(ticks, error, order)
        elif ticks >= HOLD_BELOW * self.length:
            error = max(error, NEGLIGIBLE) * (self.wish / (SAFETY * ticks)) ** order
            factor = error ** (-(INTEGRAL + PROPORTIONAL) / order) * self.error ** (PROPORTIONAL / order)
            self.wish = max(min(self.wish * min(max(factor, SHRINK), GROW), float(self.longest)), float(self.unit))
            self.error = error
            if not HOLD_BELOW * self.length <= self.wish <= HOLD_ABOVE * self.length:
                self.length = self._rounded(self.wish)

    def reject(self, ticks: int, error: float, order: int) -> None:
        """A step of so many ticks had an error above 1."""
        self._shorten(ticks * min(max(SAFETY * error ** (-1.0 / order), SHRINK), HOLD_BELOW))

    def fail(self, ticks: int) -> None:
        """A step of so many ticks could not be completed by a unit."""
        self._shorten(ticks * SHRINK)

    def _shorten(self, ticks: float) -> None:
        self.length = self._rounded(ticks)
        self.wish, self.error = float(self.length), 1.0

    def state(self) -> dict[str, float]:
        """What the next choices depend on, for a checkpoint."""
        return {name: value for name, value in vars(self).items() if name not in ("unit", "longest")}

    def set_state(self, state: Mapping[str, float]) -> None:
        """Go on from a `state`."""
        vars(self).update(state)
