"""Runs that follow from one another, as searches need them: points in, columns out, each point computed once and kept."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import numpy as np

from ....components.core.errors import BadInput, nearest
from ...output import locked
from ...results import Result
from ...scene.scene import Scene
from ...settings.answers import RangeSettings
from ...settings.plan import KeepSettings
from ...settings.study import wanted
from ..journal import Stopped
from ..sweep import ALONE, Sweep, collected_sweep
from . import store
from .batches import SUFFIX, BatchReport
from .execute import compute_here, compute_with
from .measures import Row, Task, prepared
from .plan import Column, Points, changes, place, plan_settings
from .repetition import Repeated, compared, repeat
from .workers import Cluster, Pool, Workers, cores

if TYPE_CHECKING:
    from ..summary import Summary

Summarize = Callable[[Result], "Summary"]
Observe = Callable[[int], None]
RECENT = 256  # rows that are in memory


def keep_for(names: Iterable[str], keep: KeepSettings) -> KeepSettings:
    """What must be kept of a run for columns of these names, and no more."""
    quantities = [n for n in names if _is_quantity(n)]
    others = [n for n in names if n not in quantities]
    return KeepSettings(
        statistics=False,
        summary=bool(others),
        quantities=tuple(dict.fromkeys([*keep.quantities, *quantities])),
        functions=keep.functions,
    )


def default_quantities(scene: Scene, keep: KeepSettings) -> tuple[str, ...]:
    """What an answer is about where nothing is asked for: the numbers, not the time histories, of the plan and of [study]."""
    return tuple(q for q in dict.fromkeys([*keep.quantities, *scene.study.quantities]) if _is_quantity(q))


def _is_quantity(name: str) -> bool:
    if ", " in name:
        with suppress(BadInput):
            return wanted(name).kind != "time history"
    return False


def column_name(names: Iterable[str], name: str, where: str) -> str:
    """A quantity as the columns of a sweep have it; raises `BadInput` with near names."""
    key = str(wanted(name)) if _is_quantity(name) else name
    names = list(names)
    if key not in names:
        raise BadInput(
            where,
            repr(name),
            'a figure of summary.json, "unit.output, kind", or what an own function gives',
            nearest(name, names),
        )
    return key


@dataclass(frozen=True)
class Computing:
    """Where the runs of a search are computed and kept: as those of a sweep."""

    directory: str | Path | None = None
    jobs: int | None = 1
    scheduler: str = ""
    observe: Observe = lambda n: None


class Evaluations:
    """Runs of a scene at values of parameters within bounds, kept as the points of a sweep; a context that ends its processes.

    computed: runs of this call.  Raises `BadInput` for bounds that the scene refuses.
    """

    def __init__(
        self,
        scene: Scene,
        vary: Mapping[str, RangeSettings],
        keep: KeepSettings,
        summarize: Summarize | None,
        computing: Computing,
    ):
        self.names = list(vary)
        for name in self.names:
            place(scene, name)
        if computing.jobs is not None and computing.jobs < 1:
            raise BadInput("--jobs", str(computing.jobs), "at least 1")
        self.low, self.high = (np.array([getattr(vary[n], end) for n in self.names]) for end in ("low", "high"))
        self._own, self._keep, self._computing = scene, keep, computing
        self._task = Task.of(scene, keep, summarize)
        self.scene = self._task.scene()
        for end in (self.low, self.high):  # before a long search
            self.scene.with_changes(changes(self.scene, self.values(end)))
        self._base = store.base_of(prepared(scene, keep), self._task)
        self._points: dict[int, np.ndarray] = {}  # that were asked for, by digest, in this order
        self._lies: dict[int, tuple[Path, int]] = {}  # where a digest's row is
        self._parts: set[Path] = set()  # that are in `_lies`
        self._row = lru_cache(RECENT)(store.read_row)
        self._workers: Workers | None = None
        self.computed = 0
        self._report = BatchReport()

    def __enter__(self) -> Evaluations:
        with ExitStack() as stack:
            directory = self._computing.directory
            self._directory = (
                stack.enter_context(locked(directory))
                if directory is not None
                else Path(stack.enter_context(TemporaryDirectory(prefix="cosimo-search-")))
            )
            self._folder = store.points_folder(self._directory, self._base)
            self._look()
            self._stack = stack.pop_all()
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        with self._stack:
            if self._workers is not None:
                (self._workers.close if kind is None else self._workers.stop)()

    def start(self, vary: Mapping[str, RangeSettings]) -> np.ndarray:
        """Where a search starts, (n,): as given, else as the scene has it, else in the middle of the bounds."""
        first = []
        for name, low, high in zip(self.names, self.low, self.high, strict=True):
            unit, parameter = self.scene.split(name)
            own = self.scene.units[unit].parameters.get(parameter) if unit in self.scene.units else None
            inside = isinstance(own, int | float) and low <= own <= high
            given = vary[name].start
            first.append(given if given is not None else float(own) if inside else 0.5 * (low + high))  # type: ignore[arg-type]
        return np.array(first)

    def values(self, p: np.ndarray) -> dict[str, float]:
        """Parameters (n,) by name."""
        return dict(zip(self.names, np.asarray(p, dtype=float).tolist(), strict=True))

    def __call__(self, points: Sequence[np.ndarray]) -> list[Row]:
        """The rows at points (n,) in the parameters' units; those that are not known yet are run, several by workers.

        Raises `Stopped` where a signal has ended them; what they have computed is kept.
        """
        plan = self._plan(points)
        digests = plan.digests(self._base)
        self._points.update(
            {d: np.asarray(p, dtype=float) for d, p in zip(digests.tolist(), points, strict=True) if d not in self._points}
        )
        missing = [k for k, d in enumerate(digests.tolist()) if d not in self._lies]
        missing = list({int(digests[k]): k for k in reversed(missing)}.values())[::-1]  # each once
        if missing:
            self._compute(plan, digests, np.array(missing))
        return [self._row(*self._lies[d]) for d in digests.tolist()]

    def repeated(self, points: Sequence[np.ndarray]) -> tuple[list[Row | None], Repeated]:
        """Rows at points that were run, with half of every macro step, None where that takes too long; and what this changes."""
        rows, plan = self(points), self._plan(points)
        names = dict.fromkeys(n for row in rows for n in row.numbers)
        numbers = {n: np.array([row.numbers.get(n, np.nan) for row in rows]) for n in names}
        again = repeat(self._task, plan, plan.digests(self._base), range(len(points)), self._folder)
        return [again.get(k) for k in range(len(points))], compared(range(len(points)), again, numbers)

    def _plan(self, points: Sequence[np.ndarray]) -> Points:
        columns = np.array(points, dtype=float).T
        settings = plan_settings(
            {"method": "list", "vary": dict(zip(self.names, columns.tolist(), strict=True)), "keep": self._keep}
        )
        return Points(settings, {n: Column(c) for n, c in zip(self.names, columns, strict=True)}, len(points))

    def _compute(self, plan: Points, digests: np.ndarray, missing: np.ndarray) -> None:
        workers = self._pool() if missing.size > 1 else None
        if workers is None:
            stopped = compute_here(self._task, plan, digests, missing, self._folder, self)
        else:
            stopped = compute_with(workers, self._task, plan, digests, missing, self._folder.resolve(), self, compiled=True)
        self._look()
        if stopped is not None:
            self._workers = None
            signal = Stopped(stopped)
            signal.kept = len(self._lies)
            raise signal

    def _pool(self) -> Workers | None:
        """Workers, from when they pay: the first run is of this process, which compiles for them."""
        if self._workers is not None:
            return self._workers
        jobs, here = self._computing.jobs, self._computing
        if here.scheduler:
            self._workers = Cluster(here.scheduler)
        elif (jobs if jobs is not None else cores() if self._report.seconds > ALONE else 1) > 1:
            self._workers = Pool(jobs or cores())
        return self._workers

    def count(self, report: BatchReport) -> None:
        """A batch has ended."""
        self.computed += report.done + report.failed
        self._report.seconds += report.seconds
        self._computing.observe(self.computed)

    def _look(self) -> None:
        """Find what has been written since the last look."""
        for path in sorted(set(self._folder.glob("*" + SUFFIX)) - self._parts):
            self._parts.add(path)
            self._lies.update({d: (path, k) for k, d in enumerate(store.digests_in(path))})

    @property
    def history(self) -> list[tuple[np.ndarray, Row]]:
        """All points in the order in which they were asked for first."""
        return [(p, self._row(*self._lies[d])) for d, p in self._points.items()]

    def sweep(self) -> Sweep | None:
        """The runs as a sweep, in the order of the search, with its table and data set; None without a directory."""
        if self._computing.directory is None:
            return None
        plan = self._plan(list(self._points.values()))
        return collected_sweep(self._own, plan, self._directory, self._base, computed=self.computed)
