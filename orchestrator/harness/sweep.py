"""One scene over the values its [sweep] names: every combination is a run in this process.

What is kept of a run are measures of its recorded signals after the transient and, where [analysis] has a section, the
points of a signal each time an angle passes a multiple of something: the raw material of a bifurcation diagram.

    [analysis]
    transient = 0.5                                                             # s, left out of everything below
    section = { signal = "bearing.x", angle = "bearing.cage_angle", turns = 8 }   # points eight times a turn of the angle
"""

from __future__ import annotations

import itertools
import json
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from signal import Signals
from typing import Any, TypeVar

import numpy as np

from ...components.core.errors import BadInput, nearest
from ..checkpoint import digest
from ..output import write_table
from ..progress import Interrupt
from ..results import Result
from ..run import run
from ..scene.scene import Scene
from ..units.component import find
from .analysis.records import after_transient
from .analysis.sections import section as section_of

T = TypeVar("T")
NOT_RUN = "not run"
KINDS: dict[str, Callable[[np.ndarray], Any]] = {
    "minimum": np.min, "maximum": np.max, "mean": np.mean, "standard deviation": np.std,
}


@dataclass(frozen=True)
class Sweep:
    """What the points of a sweep gave, in the order of the product of its values.

    varied: "unit.parameter" -> values, (n,).  measures: "unit.signal, kind" -> (n,), NaN where a run failed.
    outcomes: "done" or the reason, (n,).  section: per point the values of the section's signal, (k,) each.
    units: unit of measure of every column.  stopped: the signal that has ended it before its last point.
    """

    scene: Scene
    varied: Mapping[str, np.ndarray]
    measures: Mapping[str, np.ndarray]
    outcomes: tuple[str, ...]
    section: tuple[np.ndarray, ...]
    units: Mapping[str, str]
    stopped: Signals | None = None

    def save(self, directory: str | Path) -> Path:
        """Write sweep.csv: one row a point, the first line the column names with units."""
        columns = {**self.varied, **self.measures}
        names = [f"{n}, {self.units[n]}" if self.units[n] else n for n in columns]
        rows = zip(*(c.tolist() for c in columns.values()), self.outcomes, strict=True)
        return write_table(directory, "sweep.csv", [*names, "outcome"], rows)


def points(scene: Scene) -> list[tuple[dict[str, Any], Scene]]:
    """(values by "unit.parameter", the scene with them) of every combination, all checked; raises `BadInput` without [sweep]."""
    if not scene.sweep:
        raise BadInput(f"{scene.name}: sweep", "nothing", "a table of parameters and their values",
                       'Add [sweep] with lines like unit.parameter = [1.0, 2.0], or give --over unit.parameter=0:1:11.')
    combinations = []
    for values in itertools.product(*scene.sweep.values()):
        point = dict(zip(scene.sweep, values, strict=True))
        places = {}
        for name, value in point.items():
            unit, parameter = scene.split(name)
            if not parameter:
                raise BadInput(f"{scene.name}: sweep", repr(name), '"unit.parameter"')
            places[f"units.{unit}.parameters.{parameter}"] = value
        combinations.append((point, scene.with_changes(places)))
    return combinations


def sweep(scene: Scene, *, progress: bool = False, journal: Path | None = None, resume: bool = False) -> Sweep:
    """Run every point; a run that fails leaves NaN and its reason, and the sweep goes on.

    Ctrl-C, SIGTERM and SIGHUP end it with the points it has; the others have the outcome "not run".
    `journal`: a file to which each point is written when it is done. `resume`: points that stand there are not run again.
    """
    combinations = points(scene)
    _check_analysis(scene)
    units = {name: unit_of(scene, name) for name in scene.sweep}
    known = _journal(journal) if journal is not None and resume else {}
    if journal is not None and not resume:
        journal.unlink(missing_ok=True)
    measured: list[dict[str, Any]] = []
    stopped: Signals | None = None
    with Interrupt(lambda: None) as interrupt:  # between two runs; inside of one it has its own
        for _, one in tracked(combinations, scene.title or scene.name, progress):
            key = digest(one) if journal is not None else ""
            point = known.get(key) or _point(one)
            stopped = point if isinstance(point, Signals) else interrupt.wanted
            if isinstance(point, Signals) or stopped is not None:
                break
            if journal is not None and key not in known:
                with open(journal, "a", encoding="utf-8") as file:
                    file.write(json.dumps({"digest": key, **point}) + "\n")
            measured.append(point)
            units |= point["units"]
    measured += [{"row": {}, "section": [], "outcome": NOT_RUN}] * (len(combinations) - len(measured))
    names = dict.fromkeys(name for point in measured for name in point["row"])
    return Sweep(
        scene,
        {name: np.array([values[name] for values, _ in combinations]) for name in scene.sweep},
        {name: np.array([point["row"].get(name, np.nan) for point in measured]) for name in names},
        tuple(point["outcome"] for point in measured),
        tuple(np.array(point["section"], dtype=float) for point in measured), units, stopped,
    )


def _point(one: Scene) -> dict[str, Any] | Signals:
    """What a point gives; the signal that has stopped it, which is no failure of the point."""
    point: dict[str, Any] = {"row": {}, "section": [], "outcome": "", "units": {}}
    try:
        result = run(one, in_process=True)
        if result.outcome == "stopped":
            return Signals[result.info["signal"]]
        point["outcome"] = "done" if result.outcome == "done" else result.message
        if result.outcome == "done":
            point["units"] = {f"{n}, {kind}": result.measures[n] for n in result.columns for kind in KINDS}
            point["row"] = measures(result)
            point["section"] = section_points(result).tolist()
    except BadInput as error:  # a value with which this point cannot start, or has no section
        point["outcome"] = str(error)
    return point


def _journal(path: Path) -> dict[str, dict[str, Any]]:
    """Points by the digest of their scenes; a last line that was not written to its end is left out."""
    written = {}
    with suppress(OSError):
        for line in path.read_text(encoding="utf-8").splitlines():
            with suppress(ValueError, KeyError, TypeError):
                point = json.loads(line)
                if {"row", "section", "outcome", "units"} <= point.keys():
                    written[point["digest"]] = point
    return written


def unit_of(scene: Scene, name: str) -> str:
    """Unit of measure of a swept parameter; "" for one of an FMU."""
    unit, parameter = scene.split(name)
    component = scene.units[unit].component
    return find(component, unit).variables[parameter].unit if component else ""


def _check_analysis(scene: Scene) -> None:
    """Refuse, before the first run, a section or a transient that no run could have."""
    recorded = [".".join(end) for end in scene.coupling.signals]
    section, transient = scene.analysis.section, scene.analysis.transient
    for key, name in (("signal", section.signal), ("angle", section.angle)) if section is not None else ():
        if name not in recorded:
            raise BadInput(f"{scene.name}: analysis.section.{key}", repr(name), "a recorded signal", nearest(name, recorded))
    if not transient < scene.stop_time:
        raise BadInput(f"{scene.name}: analysis.transient", f"{transient:g} s",
                       f"less than the length of the run, {scene.stop_time:g} s")


def measures(result: Result) -> dict[str, float]:
    """"unit.signal, kind" -> number, of every recorded signal after the transient."""
    kept = after_transient(result)
    return {f"{n}, {kind}": float(f(c[kept])) for n, c in result.columns.items() for kind, f in KINDS.items()}


def section_points(result: Result) -> np.ndarray:
    """Values of the section's signal, (k,), where its angle passes multiples of a turn over `turns`; none without a section."""
    wanted = result.scene.analysis.section
    if wanted is None:
        return np.zeros(0)
    kept = after_transient(result)
    spacing = 2.0 * np.pi / wanted.turns
    return section_of(result[wanted.angle][kept], spacing, result[wanted.signal][kept])[0]


def tracked(items: Sequence[T], title: str, progress: bool) -> Iterable[T]:
    """The items one by one, with a progress bar on a terminal."""
    if not (progress and sys.stderr.isatty()):
        return items
    from rich.console import Console
    from rich.progress import track

    return iter(track(items, description=title, console=Console(stderr=True), transient=True))
