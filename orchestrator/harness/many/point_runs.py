"""The runs of points, one after the other in one thread: units are opened once for all points that differ in numbers alone."""

from __future__ import annotations

import json
import logging
import warnings
from collections.abc import Callable, Generator, Mapping
from contextlib import ExitStack
from signal import SIGINT, Signals
from typing import Any

from ....components.core.errors import BadInput, StepFailed
from ...opened.open_scene import Course, OpenScene
from ...run.progress import Interrupt, Stop
from ...run.results import Result
from ...run.run import Run, run
from ...run.run_record import RunRecord, UnitRecord
from ...run.watch import Watch
from ...scene.names import displaced, parameter_of
from .measures import PointResult, Task, row_of_result

log = logging.getLogger("cosimo")
LOOK = 0.2  # s between two looks at signals
Point = tuple[int, Mapping[str, Any]]  # a number of the caller's, values
Ended = Generator[list[tuple[int, PointResult]], None, None]  # rows as they come; none of them at some looks at signals


def only_kernels(task: Task, runs: PointRuns) -> bool:
    """Whether threads can run a task's points: its steps are kernels of the catalogue, and no function of one's own measures them."""
    catalogue = all(kind.of_catalogue for kind in runs.scene.kinds.values())
    return catalogue and not task.keep.functions and runs.open_scene({}) is not None


def row_of(run: Callable[[], Result], task: Task) -> PointResult:
    """What is kept of a run; every failure is a row with its reason."""
    try:
        result = run()
        if result.outcome == "stopped":
            return PointResult("not run", stopped=Signals[result.info.signal])
        return row_of_result(result, task) if result.outcome == "done" else PointResult(result.outcome, result.message)
    except BadInput as error:  # a value with which this point cannot start
        return PointResult("refused", str(error))
    except Exception as error:  # of a user's own code: one point, not all of them
        log.debug("a point of %s", task.name, exc_info=True)
        return PointResult("failed", f"{type(error).__name__}: {error}")


class PointRuns:
    """Runs of a task's scene. Where a scene is kernels alone, other parameters are written into the blocks of its units; every
    number is that of a scene that is read and opened for the point, bit by bit.

    stop: what ends runs from another thread, while they are in one.
    """

    def __init__(self, task: Task):
        self._task, self.scene = task, task.scene()
        self._altered = set(task.alterations.changes(self.scene))  # settings, behind a point's own values
        self.stop: Stop | None = None
        self._stack, self._key = ExitStack(), ""
        self._open_scene: OpenScene | None = None
        self._course: Course | None = None  # of the open scene
        self._numbers: set[tuple[str, ...]] = set()  # names of points that differ in numbers alone

    def close(self) -> None:
        """Close the units."""
        self._stack.close()
        self._key, self._open_scene, self._course = "", None, None

    def row(self, values: Mapping[str, Any]) -> PointResult:
        """What is kept of the run with the values of a point; every failure is a row with its reason."""
        return row_of(lambda: self._result_of_rows(values) or self.result(values), self._task)

    def _result_of_rows(self, values: Mapping[str, Any]) -> Result | None:
        """The run with the values of a point, of which no more is known than figures need: it costs little more than its steps.
        None for functions of one's own, which may look at all of a run, and where it ends early: `result` says why."""
        if self._task.keep.functions or not self._are_numbers(tuple(values)):
            return None
        if (open_scene := self.open_scene({})) is None or not open_scene.takes(values):
            return None
        try:
            if self.stop is not None:  # what all threads share is left alone
                return self._watched(open_scene, values, self.stop)
            with Interrupt() as interrupt, warnings.catch_warnings():
                warnings.simplefilter("ignore", UserWarning)
                return self._watched(open_scene, values, interrupt)
        except (BadInput, StepFailed, ArithmeticError, MemoryError):
            self._course = None
            return None

    def _watched(self, open_scene: OpenScene, numbers: Mapping[str, Any], stop: Stop | Interrupt) -> Result:
        """With these parameters, by name, to the end; raises `BadInput` and `StepFailed`. stop: ends it between two batches of steps.

        `info` has the parameters of the units where a system has figures, which read them.
        """
        scene = displaced(open_scene.first, numbers)
        open_scene.begin_anew(scene)
        if self._course is None or open_scene.master.coupling.bonds:  # an account of energy is that of one run
            self._course = Course(open_scene)
            self._course.stepping.run((), 0)  # it has begun; the observers look at the start below
        stepping, master = self._course.stepping, open_scene.master
        stepping.tick = 0
        watch = Watch(self._course)
        observers = [*watch.recorders, stop, *([watch.monitor] if watch.monitor is not None else [])]
        if isinstance(stop, Interrupt):
            stop.halt = stepping.halt
        self._course.start()
        try:
            for observe in observers:
                observe(0, scene.start_time)
            stepping.run(observers)
        except KeyboardInterrupt:
            return watch.result(scene, RunRecord(outcome="stopped", signal=(stop.taken or SIGINT).name))
        if watch.monitor is not None:
            watch.monitor.close(scene.stop_time)
        if master.no_numbers:
            raise StepFailed(scene.name, scene.stop_time, "an output was no number")
        watch.signals.flush()
        summed_up = open_scene.units.items() if self._task.summarize is not None else ()
        units = {name: UnitRecord(parameters=unit.parameters()) for name, unit in summed_up}
        missed = watch.monitor.missed() if watch.monitor is not None else None
        return watch.result(scene, RunRecord(outcome="done", missed=missed, units=units))

    def _are_numbers(self, names: tuple[str, ...]) -> bool:
        """Whether points that differ in these names differ in numbers alone, of which none is altered."""
        if self._altered.intersection(names):
            return False
        if names not in self._numbers and all(map(self._number, names)):
            self._numbers.add(names)
        return names in self._numbers

    def result(self, values: Mapping[str, Any]) -> Result:
        """The run with the values of a point; raises `BadInput` for one that cannot start."""
        numbers = {name: value for name, value in values.items() if self._number(name)}
        open_scene = self.open_scene({name: value for name, value in values.items() if name not in numbers})
        if open_scene is None or not open_scene.takes(numbers) or self._altered.intersection(numbers):
            return self._anew(values)
        try:
            scene = displaced(open_scene.first, numbers)
            open_scene.begin_anew(scene)
        except BadInput:
            return self._anew(values)  # which refuses it as a scene
        with ExitStack() as stack:
            current = Run(scene, stack, in_process=True, native=False, progress=False, again=open_scene, stop=self.stop)
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
            if not any(kind.outside for kind in scene.kinds.values()):
                altered = self._task.alterations.altered(scene)
                _ = altered.ends  # figures ask for these: known here, they are known of every copy with other numbers
                open_scene = OpenScene(altered, self._stack, in_process=True)
                self._open_scene = open_scene if open_scene.takes({}) else None
            self._key = key
        return self._open_scene

    def _anew(self, changed: Mapping[str, Any]) -> Result:
        return run(
            self.scene.with_changes(changed) if changed else self.scene, in_process=True, alterations=self._task.alterations
        )

    def _number(self, name: str) -> bool:
        """Whether a setting is, by its name, a parameter that no layout depends on."""
        variable = parameter_of(self.scene, name)
        return variable is not None and not variable.structural
