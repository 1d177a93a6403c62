"""Steps that an FMU discards: what it made of one goes on in shorter ones, where the FMU says how far it got or can go back."""

from __future__ import annotations

from collections.abc import Mapping
from math import floor, inf
from typing import Any

SHORTEST = 2.0**-12  # of a macro step
TRIES = 100  # discarded steps in one macro step
NEAR = 1e-9  # of a step: it is as long as another one but for rounding


class ShorterSteps:
    """Lengths of the steps of one FMU within a macro step of which it has discarded some.

    count: macro steps with discarded ones.  shortest: step that was tried, s.  length: no longer one is to be tried now, s.
    """

    def __init__(self, interface: Any, wanted: bool):
        """interface: of the model description.  wanted: whether the unit is to make shorter steps by itself."""
        self.count, self.shortest, self.length = 0, inf, inf
        self._one_length = not interface.canHandleVariableCommunicationStepSize
        self._fixed = float(interface.fixedInternalStepSize or 0.0)
        self.wanted, self.may_go_back = wanted, wanted and not self._one_length

    def begin(self, h: float) -> None:
        """A macro step of length h begins."""
        self.length, self._whole, self._tries = h, h, 0

    @property
    def after(self) -> str:
        """For the message about another failure in this macro step."""
        return ", after a step that it had discarded" if self._tries else ""

    def next(self, left: float) -> float:
        """The length of the next step, s, of what is left; no remainder that is rounding."""
        return left if left <= self.length * (1.0 + NEAR) else self.length

    def discarded(self, h: float, progress: float | None, back: bool) -> str:
        """A step of length h was discarded: the next ones are to be shorter, if `wanted`. Returns why there are none, or "".

        progress: so far the FMU got, s; None: not told.  back: it is where the step began.
        """
        if self._one_length:
            return "; no shorter step was tried: canHandleVariableCommunicationStepSize is false"
        if progress is None and not back:
            return "; no shorter step was tried: it tells no last successful time and cannot restore a state"
        if progress is None or progress <= 0.0 or (back and progress < SHORTEST * self._whole):
            self.length = h / 2.0
        elif back:
            self.length = progress
        if self._fixed:
            self.length = floor(self.length / self._fixed + NEAR) * self._fixed
        self._tries += 1
        if self._fixed > self.length:
            return f"; its fixed internal step is {self._fixed:g} s"
        if self.length < SHORTEST * self._whole or self._tries > TRIES:
            return f"; so it did with {self._tries - 1} shorter steps, down to {min(self.shortest, h):.3g} s"
        self.count, self.shortest = self.count + (self._tries == 1), min(self.shortest, self.length)
        return ""

    def work(self) -> dict[str, float]:
        """For a unit's counters; nothing where no step was discarded."""
        return {"discarded": self.count, "shortest": self.shortest} if self.count else {}


def warnings_of(counters: Mapping[str, Mapping[str, float]]) -> list[str]:
    """One warning for each unit, by name, whose FMU has discarded steps that were tried again; counters: of all units."""
    return [
        f"{unit}: {n:.0f} step{'s' * (n > 1)} that the FMU discarded {'were' if n > 1 else 'was'} tried again with shorter ones, "
        f"down to {one.get('shortest', 0.0):.3g} s"
        for unit, one in counters.items()
        if (n := one.get("discarded", 0))
    ]
