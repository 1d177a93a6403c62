"""What is kept of one run: numbers with units, a section's points, time histories."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from signal import Signals
from typing import TYPE_CHECKING, Any

import numpy as np

from ....components.core.errors import BadInput, pick
from ...run.dependence import depends_on, source_of
from ...run.instability import unfollowed
from ...run.key_results import STATISTICS, KeyResults, after_transient
from ...run.results import Result
from ...scene.scene import KnownSystems, Scene, read_scene
from ...scene.shorter_steps import Alterations, alterations_inside
from ...settings.plan import KeepSettings
from ..analysis.sections import section as section_of
from ..half_answers import half_answers, has_sums
from ..studies.quantities import TimeHistory, quantities_of, recording

if TYPE_CHECKING:
    from ..summary import Summary

Summarize = Callable[[Result], "Summary"]  # the figures of a run, by an importable function
OUTCOMES = ("done", "failed", "unstable", "refused", "killed", "not run")


@dataclass
class PointResult:
    """What a point gives. outcome: of `OUTCOMES`, with its reason; of one that is done, why it may be unstable.

    numbers: by column.  section: (k,).  time: (m,) s of the kept signals.  signals: by name, (m,).  stopped: the
    signal that has ended the run.
    """

    outcome: str
    reason: str = ""
    numbers: KeyResults = field(default_factory=KeyResults)
    section: np.ndarray = field(default_factory=lambda: np.zeros(0))
    time: np.ndarray = field(default_factory=lambda: np.zeros(0))
    signals: dict[str, np.ndarray] = field(default_factory=dict)
    stopped: Signals | None = None

    @property
    def units(self) -> dict[str, str]:
        """Units of measure of columns and of kept signals."""
        return self.numbers.units

    def values(self, names: Iterable[str]) -> np.ndarray:
        """(n,) numbers of columns; NaN where there is none, and where the run is not done."""
        return (self.numbers if self.outcome == "done" else KeyResults()).at(names)


@dataclass(frozen=True)
class Task:
    """A scene and what is kept of its runs, as plain data that another process can take.

    data, name: of the scene.  systems: that it knows.
    base: digest of what the results of all points depend on: scene, what is kept, own code, version.
    named: columns that are asked for, of which a point says where they are a part of a sum.
    alterations: of the scene at every point, behind the point's values.
    """

    data: Mapping[str, Any]
    name: str
    systems: KnownSystems
    keep: KeepSettings
    summarize: Summarize | None
    base: str
    alterations: Alterations
    named: tuple[str, ...] = ()

    @classmethod
    def of(cls, scene: Scene, keep: KeepSettings, summarize: Summarize | None, named: Iterable[str] = ()) -> Task:
        """Of a scene, which then records what is kept; raises `BadInput` for signals that it does not have."""
        scene = prepared(scene, keep)
        for text in keep.functions:
            function_of(text)
        summarize = summarize if keep.summary else None
        functions, alterations = {text: source_of(text) for text in keep.functions}, alterations_inside()
        asked = tuple(dict.fromkeys([*named, *keep.quantities])) if has_sums(scene) else ()
        parts = [keep.model_dump(mode="json"), summarize is not None, functions, alterations, *([asked] if asked else [])]
        key = depends_on(scene, *parts, of="figures")
        return cls(scene.settings(), scene.name, scene.systems, keep, summarize, key[:16], alterations, asked)

    def scene(self) -> Scene:
        """The scene, read anew, without the snapshots, which nothing but a function of one's own can read."""
        scene = read_scene(self.data, self.name, systems=self.systems)
        if self.keep.functions or not scene.record.snapshots:
            return scene
        return scene.with_changes({"record.snapshots": (), "record.snapshot_interval": None})


def prepared(scene: Scene, keep: KeepSettings) -> Scene:
    """The scene with all that is kept among its quantities and recorded signals."""
    wanted = [*scene.study.quantities, *(q for q in keep.quantities if q not in scene.study.quantities)]
    if keep.quantities:
        scene = scene.with_changes({"study.quantities": wanted})
    if wanted:
        scene = recording(scene)
    outputs = [f"{u}.{n}" for u, i in scene.coupling.interfaces.items() for n, s in i.outputs.items() if not s.is_text]
    for name in keep.signals:
        pick(name, outputs, "plan: keep.signals", "an output of a unit")
    recorded = [".".join(end) for end in scene.coupling.signals]
    missing = [s for s in dict.fromkeys(keep.signals) if s not in recorded]
    return scene.with_changes({"record.signals": [*recorded, *missing]}) if missing else scene


def function_of(text: str) -> Callable[[Result], Any]:
    """The function "module:function"; raises `BadInput`."""
    module, _, name = text.partition(":")
    try:
        function = getattr(import_module(module), name)
    except Exception as error:  # a module may raise anything while it is imported
        raise BadInput(
            "plan: keep.functions",
            repr(text),
            "module:function that can be imported",
            f"{type(error).__name__}: {error}. The folder of a module of your own belongs into PYTHONPATH.",
        ) from None
    return function


def row_of_result(result: Result, task: Task) -> PointResult:
    """What is kept of a run. Numbers first named stay: a quantity that is a statistic as well is one column. What cannot be measured
    fails the point, and leaves the others of its numbers."""
    row = PointResult("done", "; ".join(unfollowed(result.info.missed)))
    for part in (_statistics, _summary, _quantities, _functions):
        try:
            row.numbers.add(part(result, task))
        except BadInput as error:
            row.outcome, row.reason = "failed", str(error)
    if task.named and row.outcome == "done":
        numbers = task.summarize(result) if task.summarize is not None else ()
        row.reason = "; ".join([*filter(None, [row.reason]), *half_answers(result, task.named, numbers)])
    try:
        row.section = section_points(result)
    except BadInput as error:
        row.outcome, row.reason = "failed", str(error)
    if task.keep.signals:
        row.time = result.time
        row.signals = {name: result[name] for name in task.keep.signals}
        if (interval := task.keep.interval) is not None:
            start = result.scene.start_time
            row.time = start + interval * np.arange(int((result.end - start) / interval * (1.0 + 1e-12)) + 1)
            row.signals = {name: np.interp(row.time, result.time, x) for name, x in row.signals.items()}
        row.units.update({name: result.measures.get(name, "") for name in task.keep.signals})
    return row


Numbers = Iterator[tuple[str, float, str]]  # name, value, unit


def _statistics(result: Result, task: Task) -> Numbers:
    if task.keep.statistics:
        kept = after_transient(result)
        for name, column in result.columns.items():
            for kind, function in STATISTICS.items():
                yield f"{name}, {kind}", function(column[kept]), result.measures[name]


def _summary(result: Result, task: Task) -> Numbers:
    if task.summarize is not None:
        yield from ((row.name, row.value, row.unit) for row in task.summarize(result))


def _quantities(result: Result, task: Task) -> Numbers:
    if result.scene.study.quantities:
        history = TimeHistory(result.time, result.columns)
        yield from ((q.name, q.value(history), q.unit) for q in quantities_of(result.scene) if q.kind != "time history")


def _functions(result: Result, task: Task) -> Numbers:
    for text in task.keep.functions:
        try:
            value = function_of(text)(result)
            items = value.items() if isinstance(value, Mapping) else [(text.partition(":")[2], value)]
            yield from ((str(name), float(number), "") for name, number in items)
        except Exception as error:  # the user's own code
            raise BadInput(f"function {text}", f"{type(error).__name__}: {error}", "a number, or numbers by name") from None


def section_points(result: Result) -> np.ndarray:
    """Values of the section's signal, (k,), where its angle passes multiples of a turn over `turns`; none without a section."""
    wanted = result.scene.analysis.section
    if wanted is None:
        return np.zeros(0)
    kept = after_transient(result)
    spacing = 2.0 * np.pi / wanted.turns
    return section_of(result[wanted.angle][kept], spacing, result[wanted.signal][kept])[0]


def check_analysis(scene: Scene) -> None:
    """Refuse, before the first run, a section, a transient or a window that no run could have."""
    from ..studies.quantities import quantities_to_judge

    recorded = [".".join(end) for end in scene.coupling.signals]
    section, transient = scene.analysis.section, scene.analysis.transient
    for key, name in (("signal", section.signal), ("angle", section.angle)) if section is not None else ():
        pick(name, recorded, f"{scene.name}: analysis.section.{key}", "a recorded signal")
    if not transient < scene.duration:
        raise BadInput(
            f"{scene.name}: analysis.transient", f"{transient:g} s", f"less than the length of the run, {scene.duration:g} s"
        )
    if scene.study.quantities:
        quantities_to_judge(scene)
    scene.analysis.check(scene)
