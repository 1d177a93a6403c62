"""Verification of a run that is too long to repeat: windows of it are repeated with its steps, and with half of them, inside, too.

Both start from a state that was saved during the run, so a window shows the error of its own steps only. This is the error of the run
if the system forgets its past within a window. A difference that still grows at the end of a window, such as a drifting phase, is
extrapolated over the whole run. `slower` names the signals that do not return to their mean in a window.

States are saved at many instants. The first window, the last, and those in which the recorded signals bend most are repeated, because a
run that rests and then moves has its error where it moves.
"""

from __future__ import annotations

import warnings
from collections.abc import Collection, Iterable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from ...components.core.errors import BadInput, StepFailed
from ..engine.coupling import Endpoint
from ..engine.stepping.discontinuities import jump_times
from ..engine.stepping.loop import FOREVER, Batch, BatchObserver, Needs
from ..opened.open_scene import Course, started
from ..opened.state import State
from ..scene.scene import Scene
from ..scene.shorter_steps import refined
from . import work
from .comparison import Difference, difference
from .thresholds import GROWING, NEGLIGIBLE, UNRELATED, WINDOWS, WINDOWS_PLACES, WINDOWS_SHARE

FEWEST = 8  # macro steps of a window
JUDGED = 0.5  # part of a window behind which it is judged: its start has no difference yet, as the run's own start has none


Chunks = Iterable[tuple[np.ndarray, np.ndarray, Any]]  # of recorded rows: times (n,) s, values (n, columns), texts


class WindowsResult(NamedTuple):
    """differences: by signal, over all windows.  length: s, of one.  begins: s.  slower: signals slower than a window.

    growing: signals whose difference still grows there, and counts as many times as windows fit into the run.  inside: whether
    internal steps were halved, too.
    """

    differences: dict[str, Difference]
    length: float
    begins: tuple[float, ...]
    slower: tuple[str, ...]
    growing: tuple[str, ...]
    inside: bool


def obstacle(scene: Scene) -> str:
    """Why windows of a scene cannot be repeated; "" where they can."""
    coupling, master = scene.coupling, scene.master
    present = {
        "step control": master.control,
        "located events": master.events,
        "faults": scene.faults,
        "signals of tables that jump": jump_times(scene),
        "units with rates of their own": coupling.rates,
    }
    kept = [words for words, there in present.items() if there]
    kept += [
        f"{name}, which cannot go back to an earlier state" for name, one in coupling.interfaces.items() if not one.saves_state
    ]
    kept += [f"{name}, which ends its steps by itself" for name, one in coupling.interfaces.items() if one.may_return_early]
    return ", ".join(kept)


@dataclass
class WindowsWish:
    """Asks a run for its windows, where repeating all of it is too much work or `in_any_case`; `result` and `why` answer."""

    in_any_case: bool = False
    result: WindowsResult | None = None
    why: str = ""

    def needed(self, counted: float) -> bool:
        """Whether the windows of a run of this work are asked for."""
        return self.in_any_case or not work.allows(counted, 2.0)


class Windows(BatchObserver):
    """Keeps the state at some instants of a run, which changes nothing; windows are repeated from there when it has ended."""

    def __init__(self, course: Course, signals: Sequence[Endpoint], steps: int, angles: Collection[str] = ()):
        """signals: that the master reads.  steps: of the whole run, about.  angles: signals in rad."""
        self._course, self._stepping, self._angles = course, course.stepping, angles
        self._names = [".".join(end) for end in signals]
        # a window is one step at H and two at H/2, so that its cost is three times its share of the run
        self._steps = max(int(steps * WINDOWS_SHARE / (3 * WINDOWS)), FEWEST)
        self._every = max(steps // WINDOWS_PLACES, 1)
        self._saved: list[State] = []
        self._packed: list[dict[str, Any]] = []  # the first of them, for a file
        self._all = True  # whether they are of the whole run

    def __call__(self, tick: int, t: float) -> None:
        step, rest = divmod(tick, self._stepping.stride)
        if rest == 0 and (step % self._every == 0 or step == self._last) and self._fits(tick):
            self._saved.append(self._course.save())

    def _fits(self, tick: int) -> bool:
        """Whether a window from a tick ends before the run does."""
        return tick + self._steps * self._stepping.stride <= self._stepping.end

    @property
    def _last(self) -> int:
        """The step before the last window."""
        return self._stepping.end // self._stepping.stride - self._steps

    def needs(self, tick: int, length: int) -> Needs:
        """See `BatchObserver.needs`."""
        next_step = tick // self._stepping.stride + 1
        last = self._last - next_step
        return Needs(states=(range(-next_step % self._every, FOREVER, self._every), range(max(last, 0), last + 1)))

    def see(self, batch: Batch) -> None:
        """See `BatchObserver.see`; in batches, no account takes part in steps."""
        self._saved += [self._course.keep(tick, state) for tick, _, state in batch.saved if self._fits(tick)]

    def answer(self, wish: WindowsWish, rows: Chunks) -> None:
        """Repeat the windows; call it when the run has ended. rows: what it has recorded."""
        if not self._all:
            wish.why = "the part before the checkpoint has kept none of its windows"
        elif not self._saved or not self._names:
            wish.why = "no connection has a signal to compare" if self._saved else "the run has too few macro steps for windows"
        else:
            try:
                wish.result = self.compare(rows)
            except StepFailed as error:
                wish.why = f"a repeated window failed: {error}"

    def state(self) -> list[dict[str, Any]]:
        """Where windows begin, for a checkpoint."""
        self._packed += [self._course.pack(state) for state in self._saved[len(self._packed) :]]
        return self._packed

    def set_state(self, state: Sequence[dict[str, Any]] | None) -> None:
        """Go on from a `state`; None of a run that has kept none."""
        self._all, self._packed = state is not None, [*(state or ())]
        self._saved = [self._course.unpack(packed) for packed in self._packed]

    def compare(self, recorded: Chunks) -> WindowsResult:
        """Repeat the windows; the units are not where the run has ended afterwards. Raises `StepFailed`."""
        h = self._stepping.clock.seconds(self._stepping.stride)
        begins = np.array([self._stepping.clock.time(state.tick) for state in self._saved])
        judged = np.where(begins > self._stepping.clock.time(0), JUDGED * self._steps, 0).astype(
            int
        )  # what is judged comes behind
        chosen = places(bends(recorded, begins + judged * h, begins + self._steps * h))
        pairs, inside = self._repeated([self._saved[k] for k in chosen], h)
        slower = tuple(name for k, name in enumerate(self._names) if all(_crossings(two[:, k]) < 2 for _, two in pairs))
        differences, growing = {}, []
        for k, name in enumerate(self._names):
            one, two = (
                np.concatenate([pair[i][judged[place] :, k] for place, pair in zip(chosen, pairs, strict=True)]) for i in (0, 1)
            )
            gap = difference(one, two, angle=name in self._angles)
            if gap.rms > NEGLIGIBLE and self._grows([pair[0][:, k] - pair[1][:, k] for pair in pairs]):
                growing.append(name)
                longer = (self._stepping.end // self._stepping.stride) / self._steps
                factor = max(min(longer, UNRELATED / gap.rms), 1.0)
                gap = replace(gap, rms=factor * gap.rms, largest=factor * gap.largest)
            differences[name] = gap
        return WindowsResult(differences, self._steps * h, tuple(begins[chosen].tolist()), slower, tuple(growing), inside)

    def _repeated(self, states: Sequence[State], h: float) -> tuple[list[tuple[np.ndarray, np.ndarray]], bool]:
        """Signals of the windows from these states, with steps of h and of h/2 at the same instants; whether internal steps were
        halved, too."""
        end, pairs = self._stepping.tick, []
        with warnings.catch_warnings(), ExitStack() as stack:
            warnings.simplefilter("ignore")
            finer = self._finer(stack)
            try:
                for state in states:
                    one = self._stepped(self._course, state, h, self._steps)
                    pairs.append((one, self._stepped(finer, state, 0.5 * h, 2 * self._steps)[1::2]))
            finally:
                self._stepping.tick = end  # the run has ended, whatever was repeated of it
                for state in self._saved:
                    state.release()
        return pairs, finer is not self._course

    def _grows(self, gaps: Sequence[np.ndarray]) -> bool:
        """Whether the difference of a signal grows from the third to the last quarter of most windows, and of all together: in one
        with an event in its last quarter it does, and that of its run does not."""
        half = np.arange(int(JUDGED * self._steps), self._steps)
        third, last = (np.array([np.square(gap[at]).mean() for gap in gaps]) for at in np.array_split(half, 2))
        return bool(2 * (last > GROWING**2 * third).sum() > last.size and last.mean() > GROWING**2 * third.mean())

    def _finer(self, stack: ExitStack) -> Course:
        """What makes steps with half of the internal steps; the run's own course where no unit has some, or states cannot go there."""
        scene = self._course.open_scene.scene
        inner = refined(scene, 0.5)
        fixed = scene.master.energy_correction or not all(i.packs_state for i in scene.coupling.interfaces.values())
        if not inner or fixed:
            return self._course
        try:
            return stack.enter_context(started(scene.with_changes(inner)))
        except (BadInput, StepFailed):  # such as an internal step that fits no longer
            return self._course

    def _stepped(self, course: Course, state: State, h: float, n: int) -> np.ndarray:
        """The signals behind each of n steps of a course from a state of the run, (n, signals)."""
        course.restore(state if course is self._course else course.unpack(self._course.pack(state)))
        steps = course.stretch(h, range(n))
        if steps.failure is not None:
            raise steps.failure
        return steps.rows


def bends(rows: Chunks, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """(m, columns): how much each recorded column bends between times low and high (m,), s, as share of its largest bend.

    A bend is the second difference of three rows.
    """
    largest, whole = np.zeros((low.size, 0)), np.zeros(0)
    for time, values, _ in rows:
        if not largest.size:
            largest, whole = np.zeros((low.size, values.shape[1])), np.zeros(values.shape[1])
        if time.size < 3 or not values.size:
            continue
        bend = np.nan_to_num(np.abs(np.diff(values, 2, axis=0)), posinf=0.0)
        whole = np.maximum(whole, bend.max(axis=0))
        ends = [np.searchsorted(time[1:-1], edges) for edges in (low, high)]
        for k, (first, behind) in enumerate(zip(*ends, strict=True)):
            if behind > first:
                largest[k] = np.maximum(largest[k], bend[first:behind].max(axis=0))
    return largest / np.where(whole > 0.0, whole, 1.0)


def places(bending: np.ndarray) -> list[int]:
    """Of m windows the first, the last, and those that show most of what the others do not; bending: (m, columns)."""
    m = len(bending)
    chosen = list(dict.fromkeys([0, m - 1]))
    while len(chosen) < min(WINDOWS, m):
        shown = bending[chosen].max(axis=0)
        gains = np.maximum(bending - shown, 0.0).sum(axis=1)
        gains[chosen] = -1.0
        even = np.abs(np.arange(m)[:, None] - chosen).min(axis=1)  # where nothing bends, far from the others
        chosen.append(max(range(m), key=lambda k: (gains[k], even[k])))
    return sorted(chosen)


def _crossings(values: np.ndarray) -> int:
    """How often a signal crosses its mean; many times for one that stands still."""
    if np.ptp(values) <= 1e-9 * np.abs(values).max(initial=0.0):
        return FEWEST
    return int(np.count_nonzero(np.diff(values > values.mean())))
