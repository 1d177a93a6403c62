"""Events between the units: instants at which signals of a scene change their sign."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ..algorithms import Master
from ..coupling import Coupling
from ..coupling.graph import Endpoint, is_discrete

PATIENCE = 40  # trials, after which the bracket is halved; for a smooth signal ten are enough


class Crossings:
    """Watches signals for changes of sign, and finds the first instant behind one.

    A signal that is 0 has the sign it had before; one that starts at 0 has none yet. Truth values change sign about 1/2. Of
    two changes within one step nothing is seen.
    """

    def __init__(self, master: Master, ends: Sequence[Endpoint], coupling: Coupling):
        self._signals, self._places = master.signals, [master.positions[end] for end in ends]
        self._levels = [0.5 if is_discrete(coupling.interfaces[u].outputs[n]) else 0.0 for u, n in ends]
        self.signs = [0.0] * len(ends)
        self.start = [0.0] * len(ends)

    def values(self) -> list[float]:
        """The signals now, from where they change their sign."""
        return [self._signals[k] - level for k, level in zip(self._places, self._levels, strict=True)]

    def start_step(self) -> None:
        """A new step starts here."""
        self.start = self.values()
        self.signs = [
            sign if value == 0.0 else (1.0 if value > 0.0 else -1.0) for sign, value in zip(self.signs, self.start, strict=True)
        ]

    def changed(self) -> bool:
        """Whether a signal has another sign than when the step started."""
        return any(sign * value < 0.0 for sign, value in zip(self.signs, self.values(), strict=True))

    def first(self, tick: int, ahead: int, resolution: int, step: Callable[[int], None]) -> tuple[int, int]:
        """Ticks before and behind the first change in a step that has been made from `tick` to `ahead`.

        `step(tick)` makes the step again, to another end; the last such call is for the tick behind the change. The two are not
        more than `resolution` apart. Regula falsi, Illinois variant (Dowell, Jarratt, BIT 11, 1971).
        """
        low, high, before, behind, at, trials = tick, ahead, self.start, self.values(), ahead, 0
        lighter = [1.0, 1.0]  # weights of the values at the two ends
        while high - low > resolution:
            shares = [
                lighter[0] * a / (lighter[0] * a - lighter[1] * b)
                for sign, a, b in zip(self.signs, before, behind, strict=True)
                if sign * b < 0.0
            ]
            guess = low + round(min(shares) * (high - low)) if trials < PATIENCE else (low + high) // 2
            margin = min(resolution, (high - low) // 2)
            was, at, trials = at, min(max(guess, low + margin), high - margin), trials + 1
            step(at)
            if self.changed():
                lighter = [lighter[0] / 2.0 if was == high else 1.0, 1.0]
                high, behind = at, self.values()
            else:
                lighter = [1.0, lighter[1] / 2.0 if was == low else 1.0]
                low, before = at, self.values()
        if at != high:
            step(high)
        return low, high
