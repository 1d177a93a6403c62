"""One run of an open scene as it is watched: the only place where recorders and the monitor of instability are put on its steps, and
where a result is made of them. Runs to the end, points of many runs and sessions differ in what else observes, and in what they say of it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from pathlib import Path

from ..engine.coupling import Coupling
from ..opened.open_scene import Course, remarks_of
from ..scene.scene import Scene
from .instability import InstabilityMonitor, energy_warnings
from .recorders import Recorder, reading
from .results import Result, result_of
from .rows import Rows
from .run_record import RunRecord


def measures_of(coupling: Coupling) -> dict[str, str]:
    """Units of measure of the recorded signals, by "unit.output"."""
    return {f"{u}.{n}": coupling.interfaces[u].outputs[n].unit for u, n in coupling.signals}


class Watch:
    """What a course records and is stopped by. signals, arrays: recorders of the signals, and of snapshots by "unit.array".

    monitor: None where no units feed one another.
    """

    def __init__(
        self,
        course: Course,
        *,
        table: Rows | None = None,
        arrays: Callable[[str, Sequence[str]], Rows] | None = None,
        beside: Path | None = None,
        every_step: bool = False,
    ):
        """table: where the rows go, default: memory.  arrays: makes the table of a snapshot by its name and its elements, without it
        there are none.  beside: folder of the checkpoint from which the run goes on.  every_step: a row of each macro step."""
        scene, master, units = course.open_scene.scene, course.open_scene.master, course.open_scene.units
        coupling, end, step = master.coupling, course.stepping.end, scene.master.step
        places, texts = {end: k for k, end in enumerate(master.positions)}, coupling.recorded_texts
        self.course, self.measures = course, measures_of(coupling)

        def every(interval: float | None) -> Fraction:
            """Ticks; each macro step ends at one."""
            return course.open_scene.clock.multiple(interval, step) if interval and not every_step else Fraction(1)

        self.signals = Recorder(
            table if table is not None else Rows([*self.measures], [f"{u}.{n}" for u, n in texts]),
            master.sample,
            len(places),
            every(scene.record.interval),
            end,
            of_master=True,
            texts=reading(units, texts, texts=True) if texts else None,
            # what the master reads in every step anyway is kept as a whole; picking columns can wait to the end of the run
            picked=[places[signal] for signal in coupling.signals],
            beside=beside,
        )
        self.arrays: dict[str, Recorder] = {}
        for (unit, array), names in coupling.snapshots.items():
            if arrays is None:
                break
            name = f"{unit}.{array}"
            self.arrays[name] = Recorder(
                arrays(name, [f"{unit}.{n}" for n in names]),
                units[unit].reader(names),
                len(names),
                every(scene.record.snapshot_interval),
                end,
                columns=course.stepping.watch([(unit, n) for n in names]),
                beside=beside,
            )
        steps, coupled = int(scene.duration / step), any(len(group) > 1 for group in coupling.groups)
        self.monitor = InstabilityMonitor(master, steps, course.account) if coupled else None

    @property
    def recorders(self) -> list[Recorder]:
        """Those of the signals and of the snapshots."""
        return [self.signals, *self.arrays.values()]

    def warnings(self, scene: Scene, caught: Sequence[str] = ()) -> list[str]:
        """What a user should know. caught: warnings of units."""
        course = self.course
        return [*remarks_of(scene, course.open_scene.units), *caught, *course.warnings(), *energy_warnings(course.account)]

    def result(self, scene: Scene, info: RunRecord, directory: Path | None = None) -> Result:
        """What was recorded and is flushed; directory: where it is stored."""
        arrays = {name: recorder.table for name, recorder in self.arrays.items()}
        return result_of(scene, self.signals.table, arrays, self.measures, info, directory)
