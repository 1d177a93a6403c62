"""One run of a study: a scene with changes, its outcome, its cost in seconds and in counted work, and its columns.

CPU times are compared only where another measurement of the same run confirms them. A time that is not confirmed depends on the
load of the machine and not on the setting; it is measured again, and refused if the measurements still differ. CPU time is not
lengthened by programs that take turns on the processor, but by those that share its caches and clock.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from math import inf, nan
from statistics import median
from time import perf_counter
from typing import Any

import numpy as np

from ....components.core.errors import BadInput, StepFailed
from ...run.results import Result
from ...run.run import run
from ...run.work import hand_overs, macro_steps
from ...scene.scene import Scene
from ..journal import once
from .quantities import TimeHistory

SCATTER = 0.2  # of the smallest time, by which the next one may be longer
ATTEMPTS = 6  # measurements until a time is refused


@dataclass(frozen=True)
class Timing:
    """Measured times of one thing, s, at least one."""

    times: tuple[float, ...]

    @property
    def seconds(self) -> float:
        """The smallest."""
        return min(self.times)

    @property
    def median(self) -> float:
        """Half of them are longer."""
        return median(self.times)

    @property
    def spread(self) -> float:
        """Largest minus smallest; NaN for a single measurement, which nothing confirms."""
        return max(self.times) - self.seconds if len(self.times) > 1 else nan

    @property
    def scatter(self) -> float:
        """The second smallest over the smallest, minus 1; NaN for a single measurement."""
        first, *rest = sorted(self.times)
        return (rest[0] / first - 1.0 if first > 0.0 else inf) if rest else nan

    @property
    def confirmed(self) -> bool:
        """Whether two measurements agree within `SCATTER`."""
        return self.scatter <= SCATTER


def repeated(measure: Callable[[], float], *, repeats: int, patience: float = inf, confirm: bool = True) -> Timing:
    """Times that `measure` gives, s: `repeats` of them, fewer where they take more than `patience` seconds together.

    confirm: at least two, and up to `ATTEMPTS` while no two agree.
    """
    times: list[float] = []

    def needed() -> bool:
        if not times or (len(times) < repeats and sum(times) < patience):
            return True
        return confirm and (len(times) < 2 or (len(times) < ATTEMPTS and not Timing(tuple(times)).confirmed))

    while needed():
        times.append(measure())
    return Timing(tuple(times))


REPEATS = 3  # timed runs
PATIENCE = 2.0  # s: runs are not repeated any more once they have taken this together
WARMING = 3  # macro steps
_warm: set[tuple[Any, ...]] = set()  # kernels that this process has compiled or loaded from the disk


@dataclass(frozen=True)
class Trial:
    """What one setting gave.

    outcome: "done", "failed" (in the run, or unstable) or "refused" (before it), with the reason.  times: of warm runs' stepping,
    CPU time, s; where units have processes of their own, elapsed time.  work: counted in one run, by `WORK`.  time, columns: the
    recorded signals of the last run, partial after a failure, nothing where it was refused.  elapsed: real time that all of it
    took, s.
    """

    outcome: str
    reason: str
    times: tuple[float, ...] = ()
    work: Mapping[str, int] = field(default_factory=dict)
    time: np.ndarray | None = None
    columns: Mapping[str, np.ndarray] = field(default_factory=dict)
    elapsed: float = 0.0

    @property
    def done(self) -> bool:
        """Whether the run came to its end."""
        return self.outcome == "done"

    @property
    def timing(self) -> Timing | None:
        """None without a run."""
        return Timing(self.times) if self.times else None

    @property
    def seconds(self) -> float:
        """The smallest time of a run; NaN without one."""
        return min(self.times, default=nan)

    @property
    def history(self) -> TimeHistory:
        """The recorded signals; only of a trial that has run."""
        assert self.time is not None
        return TimeHistory(self.time, self.columns)


class _Ended(Exception):
    """A run that failed, which is not repeated."""


def trial(
    scene: Scene,
    changes: Mapping[str, Any] | None = None,
    *,
    repeats: int = REPEATS,
    patience: float = PATIENCE,
    confirm: bool = False,
) -> Trial:
    """Run the scene with changes, in process, up to `repeats` times or until the runs have taken `patience` seconds together.

    confirm: more often, until two times agree; see `repeated`. What has to be compiled is compiled first, by a run of a few
    steps that does not count. Failures are kept with their reason, and a study's journal keeps the trial.
    """
    try:
        changed = scene.with_changes(changes) if changes else scene
    except BadInput as error:
        return Trial("refused", str(error))
    return once("trial", (changed, repeats, patience, confirm), lambda: _trial(changed, repeats, patience, confirm), Trial)


def _trial(scene: Scene, repeats: int, patience: float, confirm: bool) -> Trial:
    start = perf_counter()
    try:
        _warm_up(scene)
    except BadInput as error:
        return Trial("refused", str(error), elapsed=perf_counter() - start)
    in_workers = any(kind.in_worker for kind in scene.kinds.values())

    def once_more() -> Trial:
        result = run(scene, in_process=True).unless_stopped()
        outcome = "done" if result.outcome == "done" else "failed"
        timing = result.info.timing
        seconds = 0.0 if timing is None else timing.run if in_workers else timing.cpu
        return Trial(outcome, result.message, (seconds,), work_of(result), result.time, result.columns)

    tried = repeated_trial(once_more, repeats=repeats, patience=patience, confirm=confirm)
    return replace(tried, elapsed=perf_counter() - start)


def repeated_trial(attempt: Callable[[], Trial], *, repeats: int, patience: float, confirm: bool) -> Trial:
    """The last of several attempts with the times of all, see `repeated`; what fails is not repeated.

    An attempt that raises `BadInput` is refused, one that raises `StepFailed` has failed.
    """
    last: list[Trial] = []

    def measure() -> float:
        last[:] = [attempt()]
        if not last[0].done:
            raise _Ended
        return last[0].seconds

    try:
        times = repeated(measure, repeats=repeats, patience=patience, confirm=confirm).times
    except (BadInput, StepFailed) as error:
        return Trial("refused" if isinstance(error, BadInput) else "failed", str(error))
    except _Ended:
        return last[0]
    return replace(last[0], times=times)


def _warm_up(scene: Scene) -> None:
    master = scene.master
    key = (
        *((kind.value, kind.settings.effects, kind.settings.preset) for kind in scene.kinds.values()),
        master.algorithm,
        master.extrapolation,
        master.control is None,
    )
    if key not in _warm:
        _warm.add(key)
        stop = min(scene.stop_time, scene.start_time + WARMING * master.step)
        run(
            scene.with_changes({"stop_time": stop, "record.interval": None, "record.snapshot_interval": None, "faults": ()}),
            in_process=True,
        ).unless_stopped()


WORK = ("macro_steps", "hand_overs", "unit_steps", "derivative_calls", "iterations", "rollbacks", "events", "calls")


def work_of(result: Result) -> dict[str, int]:
    """Counted work of a run.

    hand_overs: macro steps, or iterations where there are more of them, times units.  unit_steps: internal steps of all units.
    derivative_calls: of those that count them.  iterations, rollbacks, events: of the master and the units.  calls: of each
    unit the largest of its counters, which is its most frequent operation, summed, and the hand-overs: one number for the work
    of a run, the same on every machine.
    """
    counters = result.info.counters
    master, stepping, units = counters.master, counters.stepping, counters.units.values()

    def total(name: str) -> int:
        return sum(int(unit.get(name, 0)) for unit in units)

    steps, handed_over = macro_steps(counters), hand_overs(counters)
    return {
        "macro_steps": steps,
        "hand_overs": handed_over,
        "unit_steps": total("steps"),
        "derivative_calls": total("derivative_calls"),
        "iterations": int(master.get("iterations", 0)),
        "rollbacks": int(master.get("restores", 0) + (stepping.restores if stepping else 0)),
        "events": (stepping.events if stepping else 0) + total("events"),
        "calls": sum(max((int(n) for n in unit.values()), default=0) for unit in units) + handed_over,
    }
