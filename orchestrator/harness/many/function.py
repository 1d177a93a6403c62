"""A scene as a function: parameters in, figures of its run out, for optimizers and samplers that ask for one point after the other."""

from __future__ import annotations

import signal
import warnings
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from itertools import chain
from typing import Any

import numpy as np

from ....components.core.errors import BadInput
from ...run.progress import Stop
from ...scene.names import place_of
from ...scene.scene import Scene
from ...scene.written_units import scaled_names
from ...session.session import Session
from ...settings.plan import KeepSettings
from ...settings.study import wanted
from .columns import as_column, check_columns, column_name, keep_for
from .execute import by_threads, cores
from .measures import PointResult, Summarize, Task
from .point_runs import PointRuns, only_kernels


class Function:
    """y = f(x): a run of a scene with the parameters x gives its figures y. Close it, or use `with`.

    f(x): x (k,) -> y (m,); x (n, k) -> y (n, m), by threads where the scene is kernels alone. A single parameter or figure that was
    given as a text, and not in a list, has no axis of its own. A run that fails gives NaN, and `reason` says why.
    parameters, figures: names, k and m.  start: (k,) values that the scene itself has.  units: of the figures.
    reasons: of the last call, a text for each point, empty where the run is whole.  f can be sent to other processes.
    """

    def __init__(
        self,
        scene: Scene,
        parameters: str | Sequence[str],
        figures: str | Sequence[str],
        *,
        summarize: Summarize | None = None,
        threads: int | None = None,
    ):
        """summarize: gives the figures of the scene's system.  threads: at most, for many points; None: one for each core.

        Raises `BadInput` for a name that the scene does not have.
        """
        if threads is not None and threads < 1:
            raise BadInput("function: threads", str(threads), "at least 1")
        self._single = isinstance(parameters, str), isinstance(figures, str)
        self.figures = tuple([figures] if isinstance(figures, str) else figures)
        self._names, self._scales = scaled_names(
            scene, [parameters] if isinstance(parameters, str) else parameters, "function: parameters"
        )
        self.parameters = self._names
        if not self.parameters or not self.figures:
            raise BadInput("function", "no parameter or no figure", "one or more of both")
        self.start = (_start(scene, self._names) - self._scales[1]) / self._scales[0]
        scene = scene.with_changes({"study.quantities": ()}) if scene.study.quantities else scene
        self._task = Task.of(scene, keep_for(self.figures, KeepSettings()), summarize, self.figures)
        self._columns = [as_column(name) for name in self.figures]
        self._threads = threads
        self.reasons: tuple[str, ...] = ("",)
        self._units: tuple[str, ...] = ()
        self._warned: list[str] = []
        for name in self.figures:
            if "," in name:
                wanted(name)  # says which kinds there are
        all_known = check_columns(self._task, self.figures, "function: figures")
        self._open()
        if not all_known:  # figures of a system show in a run
            (row,) = self._rows(self.start[None])
            for name in self.figures if row.outcome == "done" else ():
                column_name(row.numbers, name, "function: figures")
            self._learn([row])

    def _open(self) -> None:
        """Begin with the runs of one thread."""
        self._runs = [PointRuns(self._task)]
        if only_kernels(self._task, self._runs[0]):
            self._runs += [PointRuns(self._task) for _ in range(1, self._threads or cores())]

    def __call__(self, x: Any) -> Any:
        """The figures at x, NaN where a run fails; raises `BadInput` for an x of another shape."""
        given = np.asarray(x, dtype=float)
        k, single = len(self.parameters), given.ndim == 0 and self._single[0]
        if self._single[0] and (single or given.ndim == 1):
            given, many = given.reshape(-1, 1), not single
        else:
            many = given.ndim == 2
        if given.ndim not in (1, 2) or given.shape[-1] != k:
            raise BadInput("function: x", f"an array of shape {np.shape(x)}", f"({k},) or (n, {k}): {', '.join(self.parameters)}")
        rows = self._rows(np.atleast_2d(given))
        self._learn(rows)
        y = np.array([row.values(self._columns) for row in rows]).reshape(len(rows), len(self._columns))
        self.reasons = tuple(_reason(row, values, self.figures) for row, values in zip(rows, y, strict=True))
        y = y[:, 0] if self._single[1] else y
        return y if many else float(y[0]) if self._single[1] else y[0]

    @property
    def units(self) -> tuple[str, ...]:
        """Of the figures; before the first call from a run at `start`. "" where no run has come to its end."""
        if not self._units:
            self._learn(self._rows(self.start[None]))
        return self._units or ("",) * len(self.figures)

    def _learn(self, rows: Sequence[PointResult]) -> None:
        for row in rows:
            if row.outcome == "done":
                if row.reason and row.reason not in self._warned:  # of a figure that is a part alone, or not followed
                    self._warned.append(row.reason)
                    warnings.warn(row.reason, stacklevel=3)
                self._units = tuple(row.units.get(name, "") for name in self._columns)

    @property
    def reason(self) -> str:
        """Why the last call has given NaN, at its first such point; "" where it has not."""
        return next(filter(None, self.reasons), "")

    def _rows(self, x: np.ndarray) -> list[PointResult]:
        """Of points (n, k)."""
        if not self._runs:
            raise BadInput("function", "a call of a function that is closed", "one that is open")
        points = [dict(zip(self._names, p.tolist(), strict=True)) for p in x * self._scales[0] + self._scales[1]]
        count = min(len(self._runs), len(points))
        if count == 1 and len(self._runs) == 1:
            rows = [self._runs[0].row(point) for point in points]
        elif count == 1:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", UserWarning)
                self._runs[0].stop = Stop()  # costs less than handlers of signals
                rows = [self._runs[0].row(point) for point in points]
        else:
            ended = dict(chain.from_iterable(by_threads(self._runs[:count], iter(enumerate(points)))))
            rows = [ended[place] for place in range(len(points))]
        for row in rows:
            if row.stopped is not None:
                signal.raise_signal(row.stopped)
        return rows

    def close(self) -> None:
        """Close the units."""
        for runs in self._runs:
            runs.close()
        self._runs = []

    def __enter__(self) -> Function:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<Function of {self._task.name}: {', '.join(self.parameters)} -> {', '.join(self.figures)}>"

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if name != "_runs"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._open()


def _reason(row: PointResult, values: np.ndarray, figures: Sequence[str]) -> str:
    if row.outcome != "done":
        return row.reason or row.outcome
    missing = [name for name, value in zip(figures, values, strict=True) if np.isnan(value)]
    return f"no number: {', '.join(missing)}" if missing else ""


def _start(scene: Scene, names: Sequence[str]) -> np.ndarray:
    """(k,) values that a scene has; raises `BadInput` for names of what is no number that can be set."""
    values = []
    with ExitStack() as stack:
        session = stack.enter_context(Session(scene))
        for name in names:
            place = place_of(scene, name)
            value: Any = None
            if place.parameter and place.parameter not in scene.coupling.interfaces[place.unit].outputs:
                value = session[f"{place.unit}.{place.parameter}"]
            elif not place.unit:
                value = scene.settings()
                for key in place.keys:
                    value = value.get(key) if isinstance(value, Mapping) else None
            if isinstance(value, bool) or not isinstance(value, int | float):
                expected = "a parameter that is a number, or an input that nothing drives"
                raise BadInput("function: parameters", repr(name), expected)
            scene.with_changes({name: value})  # an input that is driven is refused
            values.append(float(value))
    return np.array(values)
