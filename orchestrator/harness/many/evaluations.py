"""Runs that follow from one another, as searches need them: parameters in, columns out, each point computed once."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from signal import raise_signal
from typing import TYPE_CHECKING

import numpy as np

from ....components.core.errors import BadInput, nearest
from ...results import Result
from ...scene.scene import Scene
from ...settings.answers import RangeSettings
from ...settings.plan import KeepSettings
from ...settings.study import wanted
from .measures import Row, Task, measured_run
from .plan import changes, place

if TYPE_CHECKING:
    from ..summary import Summary

Summarize = Callable[[Result], "Summary"]


def keep_for(names: Iterable[str], keep: KeepSettings) -> KeepSettings:
    """What must be kept of a run for columns of these names, and no more."""
    quantities = [n for n in names if _is_quantity(n)]
    others = [n for n in names if n not in quantities]
    return KeepSettings(statistics=False, summary=bool(others), quantities=tuple(dict.fromkeys([*keep.quantities, *quantities])),
                        functions=keep.functions)


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
        raise BadInput(where, repr(name), 'a figure of summary.json, "unit.output, kind", or what an own function gives',
                       nearest(name, names))
    return key


class Evaluations:
    """Runs of a scene at values of parameters within bounds, as points of the unit cube."""

    def __init__(self, scene: Scene, vary: Mapping[str, RangeSettings], keep: KeepSettings, summarize: Summarize | None,
                 observe: Callable[[int], None] = lambda n: None):
        self.names = list(vary)
        for name in self.names:
            place(scene, name)
        self.low, self.high = (np.array([getattr(vary[n], end) for n in self.names]) for end in ("low", "high"))
        self._task = Task.of(scene, keep, summarize)
        self.scene = self._task.scene()
        self._rows: dict[bytes, Row] = {}
        self._last: tuple[bytes, Result | None] = b"", None
        self._observe = observe
        for end in (self.low, self.high):  # bounds that the scene refuses are found before a long search
            self.scene.with_changes(changes(self.scene, dict(zip(self.names, end.tolist(), strict=True))))

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

    def __call__(self, p: np.ndarray) -> Row:
        """The columns at parameters (n,)."""
        key = np.asarray(p, dtype=float).tobytes()
        if key not in self._rows:
            self._run(key, p)
        return self._rows[key]

    def result(self, p: np.ndarray) -> Result | None:
        """The whole run at parameters (n,); None where it cannot start."""
        key = np.asarray(p, dtype=float).tobytes()
        if self._last[0] != key:
            self._run(key, p)
        return self._last[1]

    def _run(self, key: bytes, p: np.ndarray) -> None:
        row, result = measured_run(self.scene, self.values(p), self._task)
        if row.stopped is not None:
            raise_signal(row.stopped)
        self._rows[key], self._last = row, (key, result)
        self._observe(len(self._rows))

    @property
    def history(self) -> list[tuple[np.ndarray, Row]]:
        """All points in the order of their runs."""
        return [(np.frombuffer(key), row) for key, row in self._rows.items()]
