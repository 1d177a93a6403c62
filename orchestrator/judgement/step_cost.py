"""What a macro step of a unit takes inside, seen over short parts of it: a whole one may hold millions of internal steps.

Parts of the step, each ten times as long as the one before, are made and taken back, until the next one would take too much.
"""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter

from ...components.core.errors import StepFailed
from ..units import Interface, Simulator
from ..units.interface import PortValues

PACE = 10.0  # from one part to the next
SHARES = tuple(PACE**k for k in range(-6, 1))  # of a macro step
MOST_CALLS = 200_000  # operations that a probing step may take
MOST_SECONDS = 0.5  # real time that one may take of a unit that does not count what it does inside: FMUs


@dataclass(frozen=True)
class StepCost:
    """share: part of the step that was made, 1 for all of it. calls: counted operations, seconds: real time of that part."""

    share: float = 1.0
    calls: int = 0
    seconds: float = 0.0

    @property
    def cut(self) -> bool:
        """Whether the whole step takes more than a probe may."""
        return self.share < 1.0

    def text(self, name: str, step: float) -> str:
        """For the reader of a dry run: what was cut, and what a whole `step` (s) would take."""
        counted = f"{self.calls} operations" if self.calls > 1 else f"{self.seconds:.2g} s"
        whole = f"{self.calls / self.share:.2g}" if self.calls > 1 else f"{self.seconds / self.share:.2g} s"
        return (
            f"the probe was cut: {name} takes {counted} for {self.share:g} of its step of {step:g} s, so about {whole} for "
            "a whole one; its time is extrapolated"
        )


def step_cost(unit: Simulator, interface: Interface, values: PortValues, step: float) -> StepCost:
    """The cost of a step of `step` s from where the unit stands, with its inputs held; the unit is left as it was.

    A unit that cannot go back or cannot shorten its steps is not asked, and its step is taken as one that may be made.
    """
    if not interface.saves_state or not interface.variable_step or interface.fixed_step:
        return StepCost()
    try:
        _part(unit, values, SHARES[0] * step)  # which compiles
        for share in SHARES:
            calls, seconds = _part(unit, values, share * step)
            if PACE * max(calls / MOST_CALLS, seconds / MOST_SECONDS if calls <= 1 else 0.0) > 1.0 > share:
                return StepCost(share, calls, seconds)
    except StepFailed:  # the run's own first step will say why
        return StepCost()
    return StepCost(1.0, calls, seconds)


def _part(unit: Simulator, values: PortValues, h: float) -> tuple[int, float]:
    """Counted operations and real time (s) of a step of h, s."""
    state, before, start = unit.save(), _calls(unit), perf_counter()
    try:
        if len(values):
            unit.drive(values, None, None, h)
        unit.step(0.0, h)
        unit.get()
        return _calls(unit) - before, perf_counter() - start
    finally:
        unit.restore(state)
        unit.release(state)


def _calls(unit: Simulator) -> int:
    """The unit's dearest counter."""
    return max((int(n) for n in unit.work().values()), default=0)
