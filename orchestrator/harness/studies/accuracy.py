"""What accuracy costs: a scene at many settings, the error of each against a reference, its seconds and its counted work.

Conventions are those of SciML's work-precision diagrams: minimum of several warm runs, failures kept with their reason, a
reference from another method. Beside seconds stands counted work, which is the same on every machine.
"""

from __future__ import annotations

import csv
import json
import os
import platform
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from importlib.metadata import version
from math import inf, isfinite, nan
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from ....components.core.errors import BadInput
from ...results import write_table
from ...scene.scene import Scene
from .knobs import Setting, finer_inside, macro_steps, pinned, settings, without_effects
from .quantities import Quantity, errors, quantities_of, recording
from .reference import Reference, reference
from .trial import REPEATS, WORK, Trial, trial

USELESS = 1.0  # error from which a run tells nothing
OWN = "as it is"
BUDGET = 60.0  # s
PATIENCE = 0.01  # of the budget: a setting is not run again once its runs have taken that long
PROBED = 0.02  # of a run, to tell how long the whole will take
FIRST = 0.6  # of the budget, for how the scene is coupled; the rest for internal steps
DEAREST = 0.05  # of the budget, for one run
REFINED = 4  # settings on the front whose internal steps are varied
COSTS = ("seconds", "calls")
PACKAGES = ("cosimo", "numpy", "scipy", "numba")
LABELS = {"size": "size, s or tolerance", "seconds": "minimum, s", "middle": "median, s"}  # of columns with a unit


@dataclass(frozen=True)
class Point:
    """One measured setting.

    line, knob, size, changes: see `Setting`.  outcome: "done", "failed", "refused", "useless" (error above 1) or "skipped" (for
    want of time), with the reason.  error: the largest of `errors`, by quantity.  held: the largest error of this setting and
    of all finer ones of its line: a small error by chance is none.  seconds, middle: minimum and median.  work: see `WORK`.
    """

    line: str
    knob: str
    size: float
    changes: Mapping[str, Any]
    outcome: str
    reason: str = ""
    error: float = inf
    held: float = inf
    seconds: float = nan
    middle: float = nan
    work: Mapping[str, int] = field(default_factory=dict)
    errors: Mapping[str, float] = field(default_factory=dict)

    def cost(self, kind: str) -> float:
        """Seconds, or a counter of `WORK`."""
        return self.seconds if kind == "seconds" else float(self.work.get(kind, nan))


@dataclass(frozen=True)
class Accuracy:
    """The measured points of a scene.

    how: of the reference.  witness: of its second solution.  floor: by quantity, how far the two agree: errors below it are below
    the reference's own.  machine, versions: where it was measured.  marks: what tells whose it is, as further columns.
    """

    name: str
    title: str
    points: tuple[Point, ...]
    how: str
    witness: str
    floor: Mapping[str, float]
    machine: str
    versions: str
    marks: Mapping[str, str] = field(default_factory=dict)

    @property
    def least(self) -> float:
        """The smallest error of a run that the reference can tell."""
        return max(self.floor.values(), default=inf)

    @property
    def own(self) -> Point:
        """The scene's setting as it is."""
        return next(p for p in self.points if p.line == OWN)

    def front(self, cost: str = "seconds") -> list[Point]:
        """The settings of which none is both cheaper and more accurate, the cheapest first."""
        return front_of(self.points, cost)

    def save(self, directory: str | Path) -> Path:
        """Write accuracy.csv: one row a setting, the first line the column names."""
        return write_points(self, directory)


def front_of(points: Iterable[Point], cost: str) -> list[Point]:
    """See `Accuracy.front`; on no front is what does not come to the end, or is another model, without one of its effects."""
    front: list[Point] = []
    kept = [p for p in points if p.outcome == "done" and p.knob != "effect" and isfinite(p.held)]
    for point in sorted(kept, key=lambda p: (p.cost(cost), p.held)):
        if not front or point.held < front[-1].held:
            front.append(point)
    return front


def accuracy(scene: Scene, *, budget: float = BUDGET, repeats: int = REPEATS,
             told: Callable[[str], None] = lambda text: None) -> Accuracy:
    """Measure the default settings of a scene within a budget of seconds, to which the reference does not count.

    First how the scene is coupled over macro steps, from coarse to fine; then, for the settings on the front, the internal
    steps; then the scene without each of its effects, which shows what they are worth but is no way to run it. What the budget
    does not reach is kept as "skipped". `told` hears what is being done.
    """
    scene = recording(scene)
    quantities = quantities_of(scene)
    steps = macro_steps(scene)
    truth = reference(scene, quantities, steps[-1], told)
    bench = _Bench(scene, quantities, truth, budget, repeats, told)
    bench.left = FIRST * budget
    bench.measure(Setting(OWN, "own", scene.master.step, {}))
    for setting in settings(scene):
        bench.measure(setting)
    points = held(bench.points)
    bench.left += (1.0 - FIRST) * budget
    best = [front_of([p for p in points if p.knob in ("own", "coupling")], cost) for cost in COSTS]
    chosen = {(p.line, p.size): p for p in (points[0], *(p for front in best for p in front[-REFINED:]))}
    for point in chosen.values():
        for setting in finer_inside(scene, Setting(point.line, point.knob, point.size, dict(point.changes))):
            bench.measure(setting)
    for setting in without_effects(scene):
        bench.measure(setting)
    how = ", ".join(f"{p} {version(p)}" for p in PACKAGES)
    return Accuracy(scene.name, scene.title or scene.name, tuple(held(bench.points)), truth.how,
                    "; ".join(w.how for w in truth.witnesses), truth.agreement, machine_name(),
                    f"Python {platform.python_version()}, {how}")


class _Bench:
    """Measures settings until the budget is spent."""

    def __init__(self, scene: Scene, quantities: tuple[Quantity, ...], truth: Reference, budget: float, repeats: int,
                 told: Callable[[str], None]):
        self._scene, self._quantities, self._truth, self._repeats, self._told = scene, quantities, truth, repeats, told
        self.left, self._budget = budget, budget
        self._dear: dict[str, tuple[float, float]] = {}  # line -> size and seconds of its last point
        self.points: list[Point] = []

    def measure(self, setting: Setting) -> None:
        """Append the setting's point."""
        setting = replace(setting, changes={**pinned(self._scene), **setting.changes})
        expected = self._expected(setting)
        known = Point(setting.line, setting.knob, setting.size, setting.changes, "skipped",
                      f"not within the budget of {self._budget:g} s")
        if min(self.left, DEAREST * self._budget) <= expected:
            self.points.append(known)
            return
        self._told(f"{setting.line}, {setting.size:.3g}")
        begin = perf_counter()
        found = trial(self._scene, setting.changes, repeats=self._repeats, patience=PATIENCE * self._budget)
        if found.result is not None:
            self.left -= perf_counter() - begin
            self._dear[setting.line] = (setting.size, found.seconds)
        self.points.append(self._judged(known, found))

    def _expected(self, setting: Setting) -> float:
        """What a run will take, s: by the last one of its line, or by a short part of the first."""
        if setting.line in self._dear:
            size, seconds = self._dear[setting.line]
            return seconds * max(size / setting.size, 1.0)
        if self.left <= 0.0 or not self.points:
            return 0.0
        probe = trial(self._scene, {**setting.changes, "stop_time": PROBED * self._scene.stop_time}, repeats=1)
        return probe.seconds / PROBED if probe.done else 0.0

    def _judged(self, known: Point, found: Trial) -> Point:
        point = replace(known, outcome=found.outcome, reason=found.reason, seconds=found.seconds, middle=found.middle,
                        work=found.work)
        if not found.done:
            return point
        each = errors(self._quantities, found.course, self._truth.course)
        error = max(each.values())
        if not error <= USELESS:
            worst = max(each, key=lambda name: each[name])
            return replace(point, outcome="useless", reason=f"error of {worst}: {100.0 * error:.3g} %", errors=each, error=error)
        return replace(point, error=error, errors=each)


def held(points: Iterable[Point]) -> list[Point]:
    """The points with the largest error of each and of the finer ones of its line."""
    kept = list(points)
    return [replace(p, held=max(q.error for q in kept if q.line == p.line and q.size <= p.size and q.outcome != "skipped"))
            if p.outcome == "done" else p for p in kept]


def machine_name() -> str:
    """The processor and how many of it."""
    name = platform.processor() or platform.machine()
    if os.path.exists("/proc/cpuinfo"):
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        name = next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), name)
    return f"{name}, {os.cpu_count()} cores, {platform.system()}"


PLAIN = ("line", "knob", "size", "outcome", "reason", "error", "held", "seconds", "middle")
ABOUT = ("how", "witness", "machine", "versions")


def write_points(measured: Accuracy, directory: str | Path, name: str = "accuracy.csv") -> Path:
    """The points as a csv file; what is known of the measurement is the same in every row, behind them.

    The last row, of the line "agreement of the reference", has the agreement of each quantity in the place of its error.
    """
    names = list(measured.floor)
    about = {key: getattr(measured, key) for key in ABOUT} | dict(measured.marks)
    header = [LABELS.get(n, n) for n in PLAIN] + ["changes", *WORK, *(f"error of {n}" for n in names), *about]
    rows = [[*(_rounded(getattr(p, key)) for key in PLAIN), json.dumps(p.changes), *(p.work.get(n, "") for n in WORK),
             *(_rounded(p.errors.get(n, nan)) for n in names), *about.values()] for p in measured.points]
    blank = ["" for _ in range(len(PLAIN) - 1)]
    rows.append([AGREEMENT, *blank, "{}", *("" for _ in WORK), *map(_rounded, measured.floor.values()), *about.values()])
    return write_table(directory, name, header, rows)


AGREEMENT = "agreement of the reference"


def _rounded(value: Any) -> Any:
    return float(f"{value:.6g}") if isinstance(value, float) else value


def read_points(path: Path) -> Accuracy:
    """What `write_points` wrote; raises `BadInput` for a file that is none of these."""
    try:
        with open(path, encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        (last,) = (r for r in rows if r["line"] == AGREEMENT)
        names = [c.removeprefix("error of ") for c in last if c.startswith("error of ")]
        points = tuple(_point(r, names) for r in rows if r is not last)
        more = dict(list(last.items())[list(last).index(ABOUT[0]) :])
        floor = {n: float(last[f"error of {n}"]) for n in names}
    except (OSError, ValueError, KeyError) as error:
        raise BadInput(str(path), f"no table of accuracy ({type(error).__name__}: {error})", "one that cosimo accuracy wrote",
                       "Remove it and measure again.") from None
    how, witness, machine, versions = (more.pop(key) for key in ABOUT)
    return Accuracy(path.stem, path.stem, points, how, witness, floor, machine, versions, more)


def _point(row: Mapping[str, str], names: Iterable[str]) -> Point:
    return Point(
        row["line"], row["knob"], float(row[LABELS["size"]]), json.loads(row["changes"]), row["outcome"], row["reason"],
        float(row["error"]), float(row["held"]), float(row[LABELS["seconds"]]), float(row[LABELS["middle"]]),
        {n: int(row[n]) for n in WORK if row[n]},
        {n: v for n in names if not np.isnan(v := float(row[f"error of {n}"]))},
    )
