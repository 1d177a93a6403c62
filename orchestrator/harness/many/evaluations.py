"""Runs that follow from one another, as searches need them: points in, rows out, each point computed once and kept."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from functools import cached_property
from pathlib import Path
from signal import Signals
from typing import Any, Unpack

import numpy as np

from ...derivatives.along import PointDerivatives
from ...interrupts import Interrupted, interruptible
from ...scene.names import place_of
from ...scene.scene import Scene
from ...settings.answers import RangeSettings
from ...settings.plan import KeepSettings
from ..journal import Stopped
from ..sweep import Sweep, collected_sweep, points_directory
from .columns import check_columns
from .execute import Computing, WorkerOptions
from .measures import PointResult, Task, check_analysis, row_of_result
from .plan import Column, Points, plan_settings
from .repetition import Repeated, compared, repeat
from .store import Store, StoredPlan


class SearchOptions(WorkerOptions, total=False):
    """Who computes the runs of a search. observe: is told how many there were."""

    observe: Callable[[int], None]


@contextmanager
def evaluations(
    scene: Scene,
    vary: Mapping[str, RangeSettings],
    keep: KeepSettings,
    columns: Mapping[str, Iterable[str]],
    directory: str | Path | None,
    **how: Unpack[SearchOptions],
) -> Iterator[Evaluations]:
    """Runs at values of parameters within bounds. columns: that the search needs, by what names them.

    Raises `BadInput` for bounds that the scene refuses, and for columns that no run has.
    """
    for name in vary:
        place_of(scene, name)
    task = Task.of(scene, keep, how.get("summarize"), [name for names in columns.values() for name in names])
    for where, needed in columns.items():
        check_columns(task, needed, where)
    own = task.scene()
    for end in ("low", "high"):  # before a long search
        check_analysis(own.with_changes({name: getattr(bounds, end) for name, bounds in vary.items()}))
    observe = how.get("observe", lambda n: None)
    computing = Computing(task, how.get("jobs", 1), how.get("cluster", ""), lambda rows: observe(computing.computed))
    with points_directory(directory, "cosimo-search-") as folder, computing, ExitStack() as stack:
        runs = Evaluations(scene, vary, task, computing, folder, directory is not None, stack)
        try:
            with interruptible():
                yield runs
        except Interrupted as one:  # also between two runs, where the search itself is at work
            raise runs.stopped(one.signal) from None


class Evaluations:
    """names, low, high: of the parameters, (n,).  scene: that is run; whole: as it was given, with its snapshots."""

    def __init__(
        self,
        scene: Scene,
        vary: Mapping[str, RangeSettings],
        task: Task,
        computing: Computing,
        folder: Path,
        kept: bool,
        stack: ExitStack,
    ):
        self.scene, self.whole, self._vary, self._task = task.scene(), scene, vary, task
        self._computing, self._folder, self._keeps = computing, folder, kept
        self._stack = stack
        self._store = Store.of(task, folder)
        self._asked: dict[int, np.ndarray] = {}  # points by digest, in the order in which they were asked for first
        self._last_slopes: tuple[Any, np.ndarray] = None, np.empty((0, len(vary)))
        self.names = list(vary)
        self.low, self.high = (np.array([getattr(bounds, end) for bounds in vary.values()]) for end in ("low", "high"))

    def start(self) -> np.ndarray:
        """Where a search starts, (n,): as given, else as the scene has it, else in the middle of the bounds."""
        first = []
        for name, bounds in self._vary.items():
            place = place_of(self.scene, name)
            own = self.scene.units[place.unit].parameters.get(place.parameter) if place.parameter else None
            middle = 0.5 * (bounds.low + bounds.high)
            inside = float(own) if isinstance(own, int | float) and bounds.low <= own <= bounds.high else middle
            first.append(bounds.start if bounds.start is not None else inside)
        return np.array(first)

    def values(self, p: np.ndarray) -> dict[str, float]:
        """Parameters (n,) by name."""
        return dict(zip(self.names, np.asarray(p, dtype=float).tolist(), strict=True))

    def __call__(self, points: Sequence[np.ndarray]) -> list[PointResult]:
        """The rows at points (n,) in the parameters' units; those that are not known yet are run, several by workers.

        Raises `Stopped` where a signal has ended them; what they have computed is kept.
        """
        stored = self._stored(points)
        for digest, p in zip(stored.digests.tolist(), points, strict=True):
            self._asked.setdefault(digest, np.asarray(p, dtype=float))
        if (missing := stored.missing()).size and (stopped := self._computing(stored, missing)) is not None:
            raise self.stopped(stopped)
        return list(stored.rows(range(len(points))).values())

    @cached_property
    def derivatives(self) -> PointDerivatives:
        """Those that the scene has; nothing is made for them before."""
        return PointDerivatives(self.scene, self.names, self._stack)

    def slopes(self, p: np.ndarray, numbers: Callable[[PointResult], np.ndarray]) -> np.ndarray:
        """Exact derivatives of numbers (m,) of a row, (m, n), at parameters p (n,); NaN, or no rows, where there are none."""
        if self._task.keep.functions:  # they may look at all of a run
            return np.full((0, len(self.names)), np.nan)
        asked = np.asarray(p, dtype=float).tobytes(), numbers
        kept, matrix = self._last_slopes
        if kept != asked:  # an aim and its limits are asked for one by one
            matrix = self.derivatives(self.values(p), lambda result: numbers(row_of_result(result, self._task)))
            self._last_slopes = asked, matrix
        return matrix

    def repeated(self, points: Sequence[np.ndarray]) -> tuple[list[PointResult | None], Repeated]:
        """Rows at points that were run, with half of every step, None where that is too much work; and what this changes."""
        rows = self(points)
        names = list(dict.fromkeys(n for row in rows for n in row.numbers))
        numbers = dict(zip(names, np.array([row.numbers.at(names) for row in rows]).T, strict=True))
        again = repeat(self._stored(points), range(len(points)), self._computing.jobs, self._computing.cluster)
        return [again.get(k) for k in range(len(points))], compared(range(len(points)), again, numbers)

    def _stored(self, points: Sequence[np.ndarray]) -> StoredPlan:
        columns = np.array(points, dtype=float).T
        vary = dict(zip(self.names, columns.tolist(), strict=True))
        settings = plan_settings({"method": "list", "vary": vary, "keep": self._task.keep})
        plan = Points(settings, {n: Column(c) for n, c in zip(self.names, columns, strict=True)}, len(points))
        return StoredPlan(self._task, plan, self._store)

    def stopped(self, signal: Signals) -> Stopped:
        """What tells of a search that a signal has ended, with the number of its runs that are kept."""
        stopped = Stopped(signal)
        stopped.kept = self.kept
        return stopped

    @property
    def kept(self) -> int:
        """How many runs are kept, of earlier calls, too."""
        return self._store.size

    @property
    def history(self) -> list[tuple[np.ndarray, PointResult]]:
        """All points in the order in which they were asked for first."""
        points = list(self._asked.values())
        return list(zip(points, self(points), strict=True))

    @property
    def asked(self) -> int:
        """How many points were asked for."""
        return len(self._asked)

    @property
    def computed(self) -> int:
        """Runs of this call; the other rows were kept."""
        return self._computing.computed

    def sweep(self) -> Sweep | None:
        """The runs as a sweep, in the order of the search, with its table and data set; None without a directory."""
        if not self._keeps:
            return None
        return collected_sweep(self.whole, self._stored(list(self._asked.values())), self._folder, computed=self.computed)
