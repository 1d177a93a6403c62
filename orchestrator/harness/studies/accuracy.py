"""What accuracy costs: a scene at many settings, the error of each against a reference, its CPU time and its counted work.

Conventions are those of SciML's work-precision diagrams: minimum of several warm runs, failures kept with their reason, a
reference from another method. Counted work stands beside seconds, because it does not depend on the machine. A time that no second
measurement confirms is refused. The error of a run is its distance from the reference and, added, the reference's own error.
"""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf, isfinite, isnan, nan
from pathlib import Path
from typing import Any

from ....fmus.versions import version
from ...output import write_table
from ...scene.scene import Scene
from .quantities import Quantity, TimeHistory, errors, percent, quantities_to_judge, recording
from .reference import Reference, reference
from .settings_axes import Setting, finer_inside, macro_steps, pinned, settings, without_effects
from .trial import REPEATS, SCATTER, WORK, Timing, Trial, trial

USELESS = 1.0  # error from which a run is of no use
OWN = "the scene's own settings"
BUDGET = 60.0  # s
PATIENCE = 0.01  # of the budget: a setting is not run again once its runs have taken that long and two of them agree
PROBED = 0.02  # of a run, from whose time that of the whole is estimated
FIRST = 0.6  # of the budget, for how the scene is coupled; the rest for internal steps
DEAREST = 0.05  # of the budget, for one run
REFINED = 4  # settings on the front whose internal steps are varied
COSTS = ("seconds", "calls")
ON_FRONTS = ("series", "size", "changes", "error", "error_with_finer", "largest", "seconds", "work")  # keys of a point in JSON
PACKAGES = ("cosimo", "numpy", "scipy", "numba")
COLUMNS = {  # of accuracy.csv: field of a point -> column
    "series": "series",
    "axis": "axis",
    "size": "size, s or tolerance",
    "outcome": "outcome",
    "reason": "reason",
    "error": "error",
    "error_with_finer": "error with finer settings",
    "largest": "largest distance",
    "seconds": "CPU time, s",
    "median": "median CPU time, s",
    "scatter": "scatter of the CPU time",
}
ABOUT = {  # field of the measurement -> column
    "reference": "reference",
    "second_solution": "second solution",
    "shares": "shared with the reference",
    "machine": "machine",
    "versions": "versions",
}


@dataclass(frozen=True)
class Point:
    """One measured setting.

    series, axis, size, changes: see `Setting`.  outcome: "done", "failed", "refused", "useless" (error above 1) or "skipped"
    (for want of time), with the reason.  errors: distance from the reference, by quantity.  error: the largest of them, the
    reference's own error added.  error_with_finer: the largest error of this setting and of all finer ones of its series: one
    that is small by chance does not count.  largest: distance of a time history at any instant, at most.  seconds, median: CPU
    time, smallest and median; NaN where no two measurements
    agree.  scatter: of the two smallest times, see `Timing`.  work: see `WORK`.
    """

    series: str
    axis: str
    size: float
    changes: Mapping[str, Any]
    outcome: str
    reason: str = ""
    error: float = inf
    error_with_finer: float = inf
    largest: float = nan
    seconds: float = nan
    median: float = nan
    scatter: float = nan
    work: Mapping[str, int] = field(default_factory=dict)
    errors: Mapping[str, float] = field(default_factory=dict)

    def cost(self, kind: str) -> float:
        """Seconds, or a counter of `WORK`."""
        return self.seconds if kind == "seconds" else float(self.work.get(kind, nan))

    def timed(self, timing: Timing | None) -> Point:
        """The point with its times, without those that scatter too much, which the reason names."""
        if timing is None:
            return self
        if timing.scatter > SCATTER:
            text = f"time refused: the two smallest measurements differ by {100.0 * timing.scatter:.0f} %"
            return replace(self, scatter=timing.scatter, reason="; ".join(filter(None, (self.reason, text))))
        return replace(self, seconds=timing.seconds, median=timing.median, scatter=timing.scatter)


@dataclass(frozen=True)
class Accuracy:
    """The measured points of a scene.

    reference, second_solution: how they were computed.  agreement: by quantity, how far the two are apart.  shares: what the
    reference has in common with the runs.  mesh_error: by quantity, of the reference's mesh.  machine, versions: where it was
    measured.
    """

    name: str
    title: str
    points: tuple[Point, ...]
    reference: str
    second_solution: str
    agreement: Mapping[str, float]
    machine: str
    versions: str
    shares: str = ""
    mesh_error: Mapping[str, float] = field(default_factory=dict)

    def __repr__(self) -> str:
        """The scene's own settings and the front, a line each."""
        lines = [f"<Accuracy of {self.name}: {len(self.points)} settings>"]
        for point in (self.own, *(p for p in self.front() if p is not self.own)):
            text = f"error {percent(point.error)}, {point.seconds:.3g} s"
            lines.append(f"{point.series}: {text if point.outcome == 'done' else f'{point.outcome}, {point.reason}'}")
        return "\n".join(lines)

    @property
    def uncertainty(self) -> dict[str, float]:
        """The reference's own error by quantity."""
        return {name: error + self.mesh_error.get(name, 0.0) for name, error in self.agreement.items()}

    @property
    def smallest_known(self) -> float:
        """The reference's largest own error: no run is known to have a smaller one."""
        return max(self.uncertainty.values(), default=inf)

    @property
    def own(self) -> Point:
        """The scene's own settings."""
        return next(p for p in self.points if p.series == OWN)

    @property
    def refused_times(self) -> int:
        """Runs that came to their end, but whose time no second measurement confirms."""
        return sum(p.outcome == "done" and isnan(p.seconds) for p in self.points)

    def save(self, directory: str | Path) -> Path:
        """Write accuracy.csv: one row for each point, and in each what is known of the measurement.

        The last two rows, "agreement of the reference" and "mesh error of the reference", have these of each quantity in the place
        of its error.
        """
        names, about = list(self.agreement), [getattr(self, key) for key in ABOUT]
        header = [*COLUMNS.values(), "changes", *WORK, *(f"error of {n}" for n in names), *ABOUT.values()]
        rows = [
            [
                *(_rounded(getattr(p, key)) for key in COLUMNS),
                json.dumps(p.changes),
                *(p.work.get(n, "") for n in WORK),
                *(_rounded(p.errors.get(n, nan)) for n in names),
                *about,
            ]
            for p in self.points
        ]
        blank = [""] * (len(COLUMNS) - 1)
        for series, values in (("agreement of the reference", self.agreement), ("mesh error of the reference", self.mesh_error)):
            numbers = (_rounded(values.get(n, 0.0)) for n in names)
            rows.append([series, *blank, "{}", *([""] * len(WORK)), *numbers, *about])
        return write_table(directory, "accuracy.csv", header, rows)

    def front(self, cost: str = "seconds") -> list[Point]:
        """The settings of which none is both cheaper and more accurate, the cheapest first."""
        return front_of(self.points, cost)

    def to_json(self) -> dict[str, Any]:
        """The fronts as plain data."""
        outcomes = [p.outcome for p in self.points]
        return {
            "name": self.name,
            "reference": self.reference,
            "second_solution": self.second_solution,
            "shared_with_reference": self.shares,
            "agreement": dict(self.agreement),
            "mesh_error": dict(self.mesh_error),
            "machine": self.machine,
            "versions": self.versions,
            "fronts": {cost: [{key: getattr(p, key) for key in ON_FRONTS} for p in self.front(cost)] for cost in COSTS},
            "outcomes": {outcome: outcomes.count(outcome) for outcome in dict.fromkeys(outcomes)},
            "refused_times": self.refused_times,
        }


def _rounded(value: Any) -> Any:
    return float(f"{value:.6g}") if isinstance(value, float) else value


def front_of(points: Iterable[Point], cost: str) -> list[Point]:
    """See `Accuracy.front`; left out is what does not come to the end, has no time, or is another model (without an effect)."""
    front: list[Point] = []
    kept = [
        p
        for p in points
        if p.outcome == "done" and p.axis != "effect" and isfinite(p.error_with_finer) and isfinite(p.cost(cost))
    ]
    for point in sorted(kept, key=lambda p: (p.cost(cost), p.error_with_finer)):
        if not front or point.error_with_finer < front[-1].error_with_finer:
            front.append(point)
    return front


def accuracy(
    scene: Scene, *, budget: float = BUDGET, repeats: int = REPEATS, on_message: Callable[[str], None] = lambda text: None
) -> Accuracy:
    """Measure the default settings of a scene within a budget of seconds, to which the reference does not count.

    First how the scene is coupled over macro steps, from coarse to fine; then, for the settings on the front, the internal
    steps; then the scene without each of its effects, which shows what they are worth but is no way to run it. What the budget
    does not reach is kept as "skipped". repeats: of each run; with 1, times are not confirmed. `on_message` gets what is being
    done.
    """
    scene = recording(scene)
    quantities = quantities_to_judge(scene)
    steps = macro_steps(scene)
    truth = reference(scene, quantities, steps[-1], on_message)
    bench = _Bench(scene, quantities, truth, budget, repeats, on_message)
    bench.left = FIRST * budget
    bench.measure(Setting(OWN, "own", scene.master.step, {}))
    for setting in settings(scene):
        bench.measure(setting)
    points = with_finer_errors(bench.points)
    bench.left += (1.0 - FIRST) * budget
    best = [front_of([p for p in points if p.axis in ("own", "coupling")], cost) for cost in COSTS]
    chosen = {(p.series, p.size): p for p in (points[0], *(p for front in best for p in front[-REFINED:]))}
    for point in chosen.values():
        for setting in finer_inside(scene, Setting(point.series, point.axis, point.size, dict(point.changes))):
            bench.measure(setting)
    for setting in without_effects(scene):
        bench.measure(setting)
    return Accuracy(
        scene.name,
        scene.title or scene.name,
        tuple(with_finer_errors(bench.points)),
        truth.method,
        "; ".join(truth.second),
        truth.agreement,
        machine_name(),
        versions(),
        ", ".join(truth.shares),
        truth.mesh_error,
    )


class _Bench:
    """Measures settings until the budget is spent."""

    def __init__(
        self,
        scene: Scene,
        quantities: tuple[Quantity, ...],
        truth: Reference,
        budget: float,
        repeats: int,
        on_message: Callable[[str], None],
    ):
        self._scene, self._quantities, self._truth, self._repeats = scene, quantities, truth, repeats
        self._on_message = on_message
        self.left, self._budget = budget, budget
        self._last: dict[str, tuple[float, float]] = {}  # series -> size and seconds of its last point
        self.points: list[Point] = []

    def measure(self, setting: Setting) -> None:
        """Append the setting's point."""
        setting = replace(setting, changes={**pinned(self._scene), **setting.changes})
        expected = self._expected(setting)
        point = Point(
            setting.series, setting.axis, setting.size, setting.changes, "skipped", f"not within the budget of {self._budget:g} s"
        )
        if min(self.left, DEAREST * self._budget) <= expected:
            self.points.append(point)
            return
        self._on_message(f"{setting.series}, {setting.size:.3g}")
        run = trial(
            self._scene, setting.changes, repeats=self._repeats, patience=PATIENCE * self._budget, confirm=self._repeats > 1
        )
        if run.times:
            self.left -= run.elapsed
            self._last[setting.series] = (setting.size, run.seconds)
        self.points.append(judged(point, run, self._quantities, self._truth.history, self._truth.uncertainty))

    def _expected(self, setting: Setting) -> float:
        """What a run will take, s: by the last one of its series, or by a short part of the first."""
        if setting.series in self._last:
            size, seconds = self._last[setting.series]
            return seconds * max(size / setting.size, 1.0)
        if self.left <= 0.0 or not self.points:
            return 0.0
        stop = self._scene.start_time + PROBED * self._scene.duration
        probe = trial(self._scene, {**setting.changes, "stop_time": stop}, repeats=1)
        return probe.seconds / PROBED if probe.done else 0.0


def judged(
    point: Point, run: Trial, quantities: Sequence[Quantity], reference: TimeHistory, uncertainty: Mapping[str, float]
) -> Point:
    """The point with what its run gave, and its errors; "useless" where one is above `USELESS`. uncertainty: of the reference."""
    point = replace(point, outcome=run.outcome, reason=run.reason, work=run.work)
    if not run.done:
        return point.timed(run.timing)
    history = run.history
    distances = errors(quantities, history, reference)
    lacking = [q.name for q in quantities if q.name not in distances]
    if not distances:
        return replace(point, outcome="refused", reason=f"has none of the quantities: {', '.join(lacking)}").timed(run.timing)
    each = {name: distance + uncertainty.get(name, 0.0) for name, distance in distances.items()}
    worst = max(each, key=lambda name: each[name])
    largest = max(q.largest(history, reference) for q in quantities if q.name in distances)
    reason = f"without {', '.join(lacking)}, which it does not have" if lacking else point.reason
    point = replace(point, errors=distances, error=each[worst], largest=largest, reason=reason)
    if not each[worst] <= USELESS:
        point = replace(point, outcome="useless", reason=f"error of {worst}: {100.0 * each[worst]:.3g} %")
    return point.timed(run.timing)


def with_finer_errors(points: Iterable[Point]) -> list[Point]:
    """The points with the largest error of each and of the finer ones of its series.

    A setting that differs in its macro step alone is of the same series, whatever it is called there.
    """
    kept = list(points)
    but_step = [{place: value for place, value in p.changes.items() if place != "master.step"} for p in kept]

    def largest(p: Point) -> float:
        alike = but_step[kept.index(p)]
        return max(
            q.error
            for q, other in zip(kept, but_step, strict=True)
            if (q.series == p.series or other == alike) and q.size <= p.size and q.outcome != "skipped"
        )

    return [replace(p, error_with_finer=largest(p)) if p.outcome == "done" else p for p in kept]


def machine_name() -> str:
    """The processor and how many of it."""
    name = platform.processor() or platform.machine()
    if os.path.exists("/proc/cpuinfo"):
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        name = next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), name)
    return f"{name}, {os.cpu_count()} cores, {platform.system()}"


def versions() -> str:
    """Of Python and of the packages that numbers and times depend on."""
    return ", ".join((f"Python {platform.python_version()}", *(f"{p} {version(p)}" for p in PACKAGES)))
