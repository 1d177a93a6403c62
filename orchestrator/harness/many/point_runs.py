"""The runs of points, one after the other in one thread: units are opened once for all points that differ in numbers alone."""

from __future__ import annotations

import json
import logging
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from signal import Signals
from threading import local
from typing import Any

from ....components.core.errors import BadInput
from ...run.progress import Stop
from ...run.results import Result
from ...run.run import Run, run
from ...scene.names import parameter_of
from ...scene.shorter_steps import asked, asked_for
from ...session.open_scene import OpenScene
from .measures import Row, Task, row_of_result

log = logging.getLogger("cosimo")
_here = local()  # the runs of this thread


def runs_of(task: Task, stop: Stop | None = None) -> PointRuns:
    """The runs of a task in this thread: those of its last batch, where it was of the same task."""
    key = task.base, asked()
    if getattr(_here, "key", None) != key:
        close_runs()
        _here.key, _here.runs = key, PointRuns(task, stop)
    runs: PointRuns = _here.runs
    return runs


def in_threads(task: Task) -> bool:
    """Whether threads can run a task's points: its steps are kernels of the catalogue, and no function of one's own measures them."""
    runs = runs_of(task)
    catalogue = all(unit.component and ":" not in unit.component for unit in runs.scene.units.values())
    return catalogue and not task.keep.functions and runs.open_scene({}) is not None


def row_of(run: Callable[[], Result], task: Task) -> Row:
    """What is kept of a run; every failure is a row with its reason."""
    try:
        result = run()
        if result.outcome == "stopped":
            return Row("not run", stopped=Signals[result.info["signal"]])
        return row_of_result(result, task) if result.outcome == "done" else Row(result.outcome, result.message)
    except BadInput as error:  # a value with which this point cannot start
        return Row("refused", str(error))
    except Exception as error:  # of a user's own code: one point, not all of them
        log.debug("a point of %s", task.name, exc_info=True)
        return Row("failed", f"{type(error).__name__}: {error}")


def close_runs() -> None:
    """Close what the runs of this thread have left open."""
    if hasattr(_here, "runs"):
        _here.runs.close()
        del _here.key, _here.runs


class PointRuns:
    """Runs of a task's scene. Where a scene is kernels alone, other parameters are written into the blocks of its units; every
    number is that of a scene that is read and opened for the point, bit by bit.

    stop: what ends runs from another thread.
    """

    def __init__(self, task: Task, stop: Stop | None = None):
        self._task, self._stop, self.scene = task, stop, task.scene()
        self._stack, self._key = ExitStack(), ""
        self._open_scene: OpenScene | None = None

    def close(self) -> None:
        """Close the units."""
        self._stack.close()
        self._key, self._open_scene = "", None

    def row(self, values: Mapping[str, Any]) -> Row:
        """What is kept of the run with the values of a point; every failure is a row with its reason."""
        return row_of(lambda: self.result(values), self._task)

    def result(self, values: Mapping[str, Any]) -> Result:
        """The run with the values of a point; raises `BadInput` for one that cannot start."""
        numbers = {name: value for name, value in values.items() if self._number(name)}
        open_scene = self.open_scene({name: value for name, value in values.items() if name not in numbers})
        if open_scene is None or not open_scene.takes(numbers):
            return self._anew(values)
        try:
            scene = open_scene.begin_anew(numbers)
        except BadInput:
            return self._anew(values)  # which refuses it as a scene
        with ExitStack() as stack:
            current = Run(scene, stack, in_process=True, native=False, progress=False, again=open_scene, stop=self._stop)
            current.prepare()
            current.observe(None, None, None)
            current.execute(None)
            return current.conclude(None)

    def open_scene(self, changed: Mapping[str, Any]) -> OpenScene | None:
        """The scene with such changes, opened, those of the last point if they were the same; None where it cannot be run again."""
        key = json.dumps(changed, sort_keys=True, default=str) + "."
        if key != self._key:
            self.close()
            scene = self.scene.with_changes(changed) if changed else self.scene
            if all(unit.component and unit.isolation == "none" for unit in scene.units.values()):
                open_scene = OpenScene(asked_for(scene), self._stack, in_process=True)
                self._open_scene = open_scene if open_scene.takes({}) else None
            self._key = key
        return self._open_scene

    def _anew(self, changed: Mapping[str, Any]) -> Result:
        return run(self.scene.with_changes(changed) if changed else self.scene, in_process=True)

    def _number(self, name: str) -> bool:
        """Whether a setting is, by its name, a parameter that no layout depends on."""
        variable = parameter_of(self.scene, name)
        return variable is not None and not variable.structural
