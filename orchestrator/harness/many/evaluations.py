"""Runs that follow from one another, as searches need them: points in, columns out, each point computed once and kept."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...results import Result
from ...scene.scene import Scene
from ...settings.answers import RangeSettings
from ...settings.plan import KeepSettings
from ..journal import Stopped
from ..sweep import POINTS, Sweep, collected_sweep, points_directory
from .columns import check_columns, is_quantity
from .execute import Computing
from .executors import BatchRows
from .measures import Row, Task, check_analysis
from .plan import Column, Points, changes, place, plan_settings
from .repetition import Repeated, compared, repeat
from .store import Store

if TYPE_CHECKING:
    from ..summary import Summary

Summarize = Callable[[Result], "Summary"]
Observe = Callable[[int], None]
RECENT = 256  # rows that are in memory


def keep_for(names: Iterable[str], keep: KeepSettings) -> KeepSettings:
    """What must be kept of a run for columns of these names, and no more."""
    quantities = [n for n in names if is_quantity(n)]
    others = [n for n in names if n not in quantities]
    return KeepSettings(
        statistics=False,
        summary=bool(others),
        quantities=tuple(dict.fromkeys([*keep.quantities, *quantities])),
        functions=keep.functions,
    )


def default_quantities(scene: Scene, keep: KeepSettings) -> tuple[str, ...]:
    """What an answer is about where nothing is asked for: the numbers, not the time histories, of the plan and of [study]."""
    return tuple(q for q in dict.fromkeys([*keep.quantities, *scene.study.quantities]) if is_quantity(q))


@dataclass(frozen=True)
class SearchSettings:
    """Where the runs of a search are kept, and who computes them: as those of a sweep. observe: is told how many there were."""

    directory: str | Path | None = None
    jobs: int | None = 1
    scheduler: str = ""
    observe: Observe = lambda n: None


class Evaluations:
    """Runs of a scene at values of parameters within bounds, kept as the points of a sweep; a context that ends its processes.

    columns: that the search needs, by what names them.  computed: runs of this call.  Raises `BadInput` for bounds that the scene
    refuses, and for columns that no run has.
    """

    def __init__(
        self,
        scene: Scene,
        vary: Mapping[str, RangeSettings],
        keep: KeepSettings,
        summarize: Summarize | None,
        search: SearchSettings,
        columns: Mapping[str, Iterable[str]],
    ):
        self.names = list(vary)
        for name in self.names:
            place(scene, name)
        self.low, self.high = (np.array([getattr(vary[n], end) for n in self.names]) for end in ("low", "high"))
        self._own, self._keep, self._search = scene, keep, search
        self._task = Task.of(scene, keep, summarize)
        for where, needed in columns.items():
            check_columns(self._task, needed, where)
        self.scene = self._task.scene()
        for end in (self.low, self.high):  # before a long search
            check_analysis(self.scene.with_changes(changes(self.scene, self.values(end))))
        self._points: dict[int, np.ndarray] = {}  # that were asked for, by digest, in this order
        self._computing = Computing(search.jobs, search.scheduler, self._count)
        self.computed = 0

    def __enter__(self) -> Evaluations:
        with ExitStack() as stack:
            self._directory = stack.enter_context(points_directory(self._search.directory, "cosimo-search-"))
            self._store = Store(self._directory / POINTS / self._task.base)
            self._row = lru_cache(RECENT)(self._store.row)
            stack.enter_context(self._computing)
            self._stack = stack.pop_all()
        return self

    def __exit__(self, *error: object) -> None:
        self._stack.__exit__(*error)  # type: ignore[arg-type]

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
        digests = plan.digests(self._task.base)
        for digest, p in zip(digests.tolist(), points, strict=True):
            self._points.setdefault(digest, np.asarray(p, dtype=float))
        if (missing := self._store.missing(digests)).size:
            stopped = self._computing(self._task, plan, digests, missing, self._store)
            if stopped is not None:
                signal = Stopped(stopped)
                signal.kept = self._store.size
                raise signal
        return self._rows(digests)

    def repeated(self, points: Sequence[np.ndarray]) -> tuple[list[Row | None], Repeated]:
        """Rows at points that were run, with half of every step, None where that takes too long; and what this changes."""
        rows, plan = self(points), self._plan(points)
        names = dict.fromkeys(n for row in rows for n in row.numbers)
        numbers = {n: np.array([row.numbers.get(n, np.nan) for row in rows]) for n in names}
        folder = self._directory / POINTS / self._task.base
        again = repeat(self._task, plan, plan.digests(self._task.base), range(len(points)), folder)
        return [again.get(k) for k in range(len(points))], compared(range(len(points)), again, numbers)

    def _plan(self, points: Sequence[np.ndarray]) -> Points:
        columns = np.array(points, dtype=float).T
        settings = plan_settings(
            {"method": "list", "vary": dict(zip(self.names, columns.tolist(), strict=True)), "keep": self._keep}
        )
        return Points(settings, {n: Column(c) for n, c in zip(self.names, columns, strict=True)}, len(points))

    def _rows(self, digests: np.ndarray) -> list[Row]:
        return [self._row(place) for place in self._store.places(digests).tolist()]

    def _count(self, rows: BatchRows, workers: int) -> None:
        self.computed += rows.table.num_rows
        self._search.observe(self.computed)

    @property
    def history(self) -> list[tuple[np.ndarray, Row]]:
        """All points in the order in which they were asked for first."""
        return list(zip(self._points.values(), self._rows(np.array(list(self._points))), strict=True))

    def sweep(self) -> Sweep | None:
        """The runs as a sweep, in the order of the search, with its table and data set; None without a directory."""
        if self._search.directory is None:
            return None
        plan = self._plan(list(self._points.values()))
        return collected_sweep(self._own, plan, self._directory, self._store, self._task, computed=self.computed)
