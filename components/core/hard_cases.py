"""Hard cases of components: where a model is at its limits, and the claims that hold there all the same.

Each system declares those of its components in its `hard_cases.py`, as HARD_CASES = {component: {name: HardCase}}. Nothing that
runs imports those files; tests and the command `cosimo stability --hard-cases` look them up and say how far each claim is from
its limit.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, ClassVar

import numpy as np

from .component import Component

Quantity = str | Callable[[Component], float | Sequence[float] | np.ndarray]  # an output, "energy", or what a function says
Value = float | Sequence[float] | np.ndarray
ENERGY = "energy"


def outputs(component: Component) -> np.ndarray:
    """All outputs."""
    return component.y


def events(component: Component) -> float:
    """Number of events so far."""
    return float(component.work["events"])


@dataclass(frozen=True)
class InputSignal:
    """An input over time. at: time in s -> value.  smooth: a parabola in each step through its start, middle and end, else the
    value at its start.  before: what the component is initialized with, where that is not the value at 0."""

    at: Callable[[float], float]
    smooth: bool = True
    before: float | None = None

    @property
    def start(self) -> float:
        """Value for the initialization."""
        return self.at(0.0) if self.before is None else self.before


def jumps(start: float, *changes: tuple[float, float]) -> InputSignal:
    """`start`, also for the initialization, then in the first step that begins at or after each time, s, the value with it."""
    return InputSignal(lambda t: next((value for time, value in reversed(changes) if t >= time - 1e-9), start), False, start)


def ramp(rate: float, start: float = 0.0) -> InputSignal:
    """Grows from `start` by `rate` a second."""
    return InputSignal(lambda t: start + rate * t)


def sine(swing: float, rate: float, mean: float = 0.0) -> InputSignal:
    """mean + swing sin(rate t); rate in rad/s."""
    return InputSignal(lambda t: mean + swing * math.sin(rate * t))


def seen(component: Component, quantity: Quantity) -> np.ndarray:
    """Present values of a quantity, (k,)."""
    if not isinstance(quantity, str):
        return np.array(quantity(component), dtype=float, ndmin=1)  # a copy: it may have been a view of the state
    return np.array([component.energy() if quantity == ENERGY else component.get(quantity)])


@dataclass(frozen=True)
class Claim:
    """Something that has to hold during a run: what is `reached` stays at or below the `limit`.

    of: what is looked at.  text: what it says, where the kind of claim and the quantity do not say it.
    """

    kind: ClassVar[str] = ""
    of: Quantity
    limit: float
    text: str = ""

    def reached(self, component: Component, times: np.ndarray, values: np.ndarray) -> float:
        """How much of the limit was used. times: (n,), s; values: (n, k), from the start on."""
        raise NotImplementedError

    @property
    def label(self) -> str:
        """The claim in words."""
        what = self.text or (self.of if isinstance(self.of, str) else "")
        return f"{self.kind}: {what}" if what else self.kind


@dataclass(frozen=True)
class AtMost(Claim):
    """The magnitude stays at or below the limit."""

    kind = "at most"

    def reached(self, component: Component, times: np.ndarray, values: np.ndarray) -> float:
        """Largest magnitude."""
        return float(np.abs(values).max())


@dataclass(frozen=True)
class AtLeast(Claim):
    """Never below `low`, but for what rounding takes: the limit."""

    kind = "never below"
    low: float = 0.0

    def reached(self, component: Component, times: np.ndarray, values: np.ndarray) -> float:
        """How far below."""
        return max(0.0, self.low - float(values.min()))


@dataclass(frozen=True)
class Invariant(Claim):
    """Stays what it is at the start, or at `value`, a number or a function of time.

    share: the limit is a part of the largest magnitude instead of a number in the quantity's unit.
    """

    kind = "invariant"
    value: Value | Callable[[float], float] | None = None
    share: bool = False

    def reached(self, component: Component, times: np.ndarray, values: np.ndarray) -> float:
        """Largest deviation."""
        wanted: Any = values[0] if self.value is None else self.value
        if callable(wanted):
            wanted = np.array([wanted(t) for t in times])[:, None]
        scale = np.abs(values).max() if self.share else 1.0
        return float(np.abs(values - wanted).max() / (scale or 1.0))


@dataclass(frozen=True)
class Ends(Claim):
    """At the end of the run it is `value`; `share` as of an `Invariant`."""

    kind = "ends"
    value: Value = 0.0
    share: bool = False

    def reached(self, component: Component, times: np.ndarray, values: np.ndarray) -> float:
        """Deviation at the end."""
        return float(np.abs(values[-1] - self.value).max() / (np.abs(self.value).max() if self.share else 1.0))


@dataclass(frozen=True)
class BoundedEnergy(Claim):
    """Energy never grows above that of any time before, by more than the limit as a part of its largest value."""

    kind = "bounded energy"
    of: Quantity = ENERGY
    limit: float = 1e-9

    def reached(self, component: Component, times: np.ndarray, values: np.ndarray) -> float:
        """Largest growth."""
        growth = float((values - np.minimum.accumulate(values, axis=0)).max())
        return growth / (float(np.abs(values).max()) or 1.0)


@dataclass(frozen=True)
class Falling(BoundedEnergy):
    """What is looked at never grows."""

    kind = "never grows"
    limit: float = 0.0


@dataclass(frozen=True)
class Reaches(Claim):
    """At some time it is `high` or more: something has moved at all."""

    kind = "reaches"
    limit: float = 0.0
    high: float = 0.0

    def reached(self, component: Component, times: np.ndarray, values: np.ndarray) -> float:
        """How far below it stayed."""
        return max(0.0, self.high - float(values.max()))


@dataclass(frozen=True)
class Like(Claim):
    """It ends as in another run. instead: fields of the case that the other run has instead.  mirror: what is looked at there, if
    not the same; `share` as of an `Invariant`."""

    kind = "ends as another run"
    instead: Mapping[str, Any] = field(default_factory=dict)
    mirror: Quantity | None = None
    share: bool = False

    def reached(self, component: Component, times: np.ndarray, values: np.ndarray) -> float:
        """Largest difference. values: (2, k), of the end of both runs."""
        scale = np.abs(values[1]).max() if self.share else 1.0
        return float(np.abs(values[0] - values[1]).max() / (scale or 1.0))


@dataclass(frozen=True)
class Finite(Claim):
    """Every output stays finite, and within so many of its nominal values."""

    kind = "outputs over nominal values"
    of: Quantity = ""
    limit: float = 1e3

    def reached(self, component: Component, times: np.ndarray, values: np.ndarray) -> float:
        """Largest output over its nominal value."""
        return float(np.abs(values).max())


@dataclass(frozen=True)
class Refused:
    """No run at all: one message that says what to do. words: of the message.

    when: "construction", "initialize", or "step", where the state before the failed step can be taken back.
    accepted: parameters and inputs instead of those of the case with which it runs: how sharp the refusal is.
    """

    kind: ClassVar[str] = "refused"
    words: str
    when: str = "initialize"
    accepted: Mapping[str, Any] = field(default_factory=dict)

    @property
    def label(self) -> str:
        """The claim in words."""
        return f'refused at {self.when}: "{self.words}"'


@dataclass(frozen=True)
class HardCase:
    """One case of one component.

    text: what is hard about it.  holds: what has to hold; besides, states and outputs stay finite in every case that is not
    refused.
    inputs: numbers, or signals over time.  run: its duration and its macro steps, s.  name: that of the table, unique among those
    of the component.
    """

    text: str
    holds: Sequence[Claim] | Refused
    _: KW_ONLY
    effects: tuple[str, ...] = ()
    parameters: Mapping[str, Any] = field(default_factory=dict)
    inputs: Mapping[str, float | InputSignal] = field(default_factory=dict)
    run: tuple[float, float] = (0.1, 1e-3)
    name: str = ""

    @property
    def steps(self) -> int:
        """Number of macro steps."""
        return round(self.run[0] / self.run[1])
