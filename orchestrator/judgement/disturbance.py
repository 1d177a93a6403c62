"""Whether a coupled run lets a small disturbance grow: two runs from one start, in one of which all inputs are pushed once.

The difference of the two runs is taken in every exchanged signal, relative to its nominal value. Its second difference over time is
judged: this removes a constant or linear drift, such as that of a free body that was pushed, and keeps the growth rate of an
oscillation. The first fourth of the run is for transients. The growth is the largest second difference of the last fourth over that
of the second fourth. A run with short steps shows what grows without the coupling, such as a chaotic motion or a wave that returns;
this growth is allowed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from itertools import count

import numpy as np

from ...components.core.errors import BadInput, StepFailed
from ..engine.coupling import Endpoint
from ..engine.coupling.checks import free
from ..scene.scene import Scene
from ..session.open_scene import started
from ..settings import IterationSettings
from .thresholds import CLEAR, FASTER, ITERATION_NOISE, SETTLED, SURE

PUSH = 1e-5  # of an input or its nominal value: small against every bend of a contact, large against rounding and iterations
GOLDEN = 0.6180339887498949  # its multiples spread evenly over an interval
BEFORE = 3  # steps before the push, which fill the histories of the inputs
FEWEST = 32  # steps that tell growth from a transient
FIRST = 4  # steps that show the push itself


ACCURACY = 1.005  # of a limit: the shortest step seen to be unstable over the longest one seen to be stable


@dataclass(frozen=True)
class GrowthRate:
    """What became of a disturbance in a look of `time` seconds.

    factor: of the last fourth over the second one; infinite where a run failed, which `failure` tells, 0 where little is left.
    steps: made to find out.
    """

    factor: float
    time: float
    steps: int
    failure: str = ""

    def text(self, h: float) -> str:
        """How it grew with steps of h, s."""
        if self.failure or self.factor == math.inf:
            return self.failure or "grows out of nothing"
        return f"grows by a factor of 2.7 in {0.5 * self.time / (h * math.log(self.factor)):.3g} steps"


@dataclass(frozen=True)
class IntrinsicGrowth:
    """What disturbances do by themselves, seen with short steps. sizes: largest second differences, (n,), `h` seconds apart."""

    sizes: np.ndarray
    h: float

    def factor(self, time: float) -> float:
        """The largest one of looks of about so many seconds, as far as there are any; 1 where that is none."""
        factors = []
        for share in np.geomspace(0.5, 2.0, 9) ** 0.5:  # a wave comes back a little sooner or later than to other steps
            n = int(min(share * time / self.h, self.sizes.size))
            factors.append(_factor(self.sizes[:n]) if n >= FEWEST else 1.0)
        return largest if SURE < (largest := max(factors)) < math.inf else 1.0

    def allows(self, growth: GrowthRate, even: float) -> bool:
        """Whether a growth is no more than what comes by itself; `even`: a factor that chance may give."""
        return not growth.failure and growth.factor <= even * max(self.factor(growth.time), 1.0) ** FASTER


def sizes(differences: np.ndarray) -> np.ndarray:
    """Largest second differences over time of differences of two runs, (n, signals): (n - 2,)."""
    return np.abs(np.diff(differences, 2, axis=0)).max(axis=1, initial=0.0)


def growth_of(differences: np.ndarray, h: float, steps: int, noise: float = 0.0) -> GrowthRate:
    """Of `sizes` of differences, (n,), h seconds apart; below `noise` they mean nothing. steps: all that were needed for them."""
    window = differences.size // 4
    if differences[-window:].max() <= max(differences[:window].max() / CLEAR, noise):
        return GrowthRate(0.0, h * differences.size, steps)
    return GrowthRate(_factor(differences), h * differences.size, steps)


def _factor(differences: np.ndarray) -> float:
    """The last fourth over the second one; or over the start, where a bound, such as a contact that opens, has been reached."""
    window, start, largest = differences.size // 4, differences[:FIRST].max(), differences.max()
    if largest > CLEAR * start:
        return float(largest / start) if start > 0.0 else math.inf
    early, late = differences[window : 2 * window].max(), differences[3 * window : 4 * window].max()
    return float(late / early) if early > 0.0 else math.inf


class Disturbed:
    """A scene that was started once and is run from there again and again, with any macro step; its units are in this process.

    Raises `BadInput` for units that cannot go back to a start or cannot change the length of a step, and `StepFailed` where
    the scene does not start.
    """

    def __init__(self, scene: Scene, stack: ExitStack):
        if iterative := "iteration" in scene.master.abilities.options:
            tolerance = min(SETTLED, (scene.master.iteration or IterationSettings()).tolerance)
            scene = scene.with_changes({"master.iteration.tolerance": tolerance, "master.iteration.not_converged": "warn"})
        self._noise = ITERATION_NOISE if iterative else 0.0
        self._coupling = coupling = scene.coupling
        for able, what in (
            ("save their state", [n for n, i in coupling.interfaces.items() if not i.saves_state]),
            ("change the length of a step", [n for n, i in coupling.interfaces.items() if not free(i)]),
        ):
            if what:
                raise BadInput(f"{scene.name}: stability", ", ".join(what), f"units that {able}")
        self.scene, self._course = scene, stack.enter_context(started(scene, watched=()))
        self.open_scene, self._start = self._course.open_scene, self._course.save()
        self._nominal = np.array([coupling.interfaces[u].outputs[n].nominal for u, n in self.open_scene.signals])

    @property
    def longest(self) -> float:
        """The longest macro step that the scene's run has room for, s."""
        return self.scene.duration / (FEWEST + BEFORE + 1)

    def growth(self, h: float, steps: int) -> GrowthRate:
        """Of a disturbance in at most so many macro steps of length h, s, and not beyond the scene's stop time."""
        whole = self._fitting(h, steps)
        growth, steps_done = GrowthRate(0.0, 0.0, 0), 0
        for n in dict.fromkeys((max(whole // 4, FEWEST), whole)):  # a short look first: most steps are far from a limit
            differences, more, failure = self._sizes(h, n)
            steps_done += more
            if failure:
                return GrowthRate(math.inf, n * h, steps_done, failure)
            growth = growth_of(differences, h, steps_done, self._noise)
            if growth.factor == 0.0 or growth.factor > CLEAR:
                break
        return growth

    def intrinsic_growth(self, h: float, time: float) -> IntrinsicGrowth:
        """What disturbances do in so many seconds, seen with steps of h, s; nothing where the run fails."""
        differences, _, _ = self._sizes(h, self._fitting(h, math.ceil(time / h)))
        return IntrinsicGrowth(differences, h)

    def _fitting(self, h: float, steps: int) -> int:
        return max(min(steps, int(self.scene.duration / h * (1.0 + 1e-9)) - BEFORE - 1), FEWEST)

    def _sizes(self, h: float, n: int) -> tuple[np.ndarray, int, str]:
        """Sizes of what n steps behind the push make of it, the steps made, and why there are fewer."""
        calm, failure = self._run(h, n, pushed=False)
        if failure:
            return np.zeros(0), len(calm), failure
        pushed, failure = self._run(h, n, pushed=True)
        if failure:
            return np.zeros(0), len(calm) + len(pushed), failure
        return sizes((pushed - calm) / self._nominal), 2 * n, ""

    def _run(self, h: float, n: int, *, pushed: bool) -> tuple[np.ndarray, str]:
        """The signals behind each of n steps that follow the push, (n, signals), and why they are fewer, if they are."""
        self._course.restore(self._start)
        rows = np.zeros((0, self._nominal.size))
        try:
            for steps in (range(BEFORE), range(BEFORE, BEFORE + 1), range(BEFORE + 1, n + BEFORE + 1)):
                self.open_scene.push(self._pushes() if pushed and steps.start == BEFORE else {})
                taken = self._course.stretch(h, steps)
                rows = taken.rows if steps.start > BEFORE else rows
                if taken.failure is not None:
                    raise taken.failure
        except (StepFailed, OverflowError, np.linalg.LinAlgError) as error:  # what grows may end anywhere
            return rows, str(error)
        finally:
            self.open_scene.push({})
        return rows, ""

    def _pushes(self) -> dict[Endpoint, float]:
        """Of every input that changes inside steps, every other one to the opposite side.

        By a part of its own, or the push of an input could cancel what the pushes of others make of the output that it comes from.
        """
        parts, pushes = (1.0 + GOLDEN * i % 1.0 for i in count()), {}
        for unit in self.open_scene.order:
            for k, (name, value) in enumerate(self.open_scene.inputs(unit).items()):
                if (unit, name) not in self.open_scene.jumping:
                    nominal = self._coupling.interfaces[unit].inputs[name].nominal
                    pushes[unit, name] = next(parts) * PUSH * math.copysign(max(abs(value), abs(nominal)), (-1) ** k * nominal)
        return pushes


def longest_stable(
    growth: Callable[[float], GrowthRate],
    own: IntrinsicGrowth,
    even: float,
    first: float,
    least: float,
    most: float,
    pace: float = 2.0,
) -> tuple[float, str, float]:
    """(longest stable step, what the next longer one did, the longest or shortest step that was tried), s.

    own, even: the growth that is allowed, see `IntrinsicGrowth.allows`.  first, least, most: steps, s.  The longest stable step is infinite
    where `most` is stable, and 0 where `least` is not.  pace: factor of one trial to the next.
    """
    seen = ""

    def grows(h: float) -> bool:
        nonlocal seen
        measured = growth(h)
        if unstable := not own.allows(measured, even):
            seen = f"at {h:.4g} s: {measured.text(h)}"
        return unstable

    h = low = high = min(first, most)
    if grows(h):
        while grows(h := h / pace):
            high = h
            if h <= least:
                return 0.0, seen, h
        low = h
    else:
        while not grows(h := min(pace * h, most)):
            low = h
            if h == most:
                return math.inf, "", h
        high = h
    tried = high
    while high > ACCURACY * low:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if grows(middle) else (middle, high)
        tried = high
    return low, seen, tried
