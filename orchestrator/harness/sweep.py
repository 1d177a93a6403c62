"""One scene, many runs: the points of a plan, computed here, by a pool of processes or by a cluster, and kept as one data set.

What is kept of a run are statistics of its recorded signals after the transient, the figures of its system, quantities, own
functions and signals on request, and, where [analysis] has a section, the points of a signal each time an angle passes a
multiple of something: the raw material of a bifurcation diagram.

    [analysis]
    transient = 0.5                                                             # s, left out of everything below
    section = { signal = "bearing.x", angle = "bearing.cage_angle", turns = 8 }   # points eight times a turn of the angle
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from signal import Signals
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np

from ...components.core.errors import BadInput
from ..output import locked
from ..results import Result
from ..scene.scene import Scene
from ..settings.plan import SAMPLED, PlanSettings
from .many import store
from .many.execute import compute_here, compute_with
from .many.limits import check_limits, with_rows
from .many.live import Live
from .many.measures import OUTCOMES, Task, check_analysis, prepared
from .many.plan import Points, plan_of, plan_settings, read_plan, unit_of
from .many.repetition import Repeated, compared, ends_and_some, repeat
from .many.workers import Cluster, Pool, Workers, cores

if TYPE_CHECKING:
    from .summary import Summary

NOT_RUN = "not run"
ALONE = 4.0  # s that this process works before it starts others


@dataclass(frozen=True)
class Sweep:
    """What the points of a sweep gave, in the order of its plan.

    varied: "unit.parameter" -> values, (n,), numbers or texts.  measures: "unit.signal, kind" and the like -> (n,), NaN where a
    run failed.  outcomes: "done" or the reason, (n,).  section: per point the values of the section's signal, (k,) each.
    units: unit of measure of every column.  stopped: the signal that has ended it before its last point.
    plan: how the points were chosen.  files: what was written.  efficiency: share of the workers' time in runs.
    repeated: what half of every macro step changes at some points; None where nothing was repeated.
    """

    scene: Scene
    varied: Mapping[str, np.ndarray]
    measures: Mapping[str, np.ndarray]
    outcomes: tuple[str, ...]
    section: tuple[np.ndarray, ...]
    units: Mapping[str, str]
    stopped: Signals | None = None
    plan: PlanSettings = field(default_factory=lambda: PlanSettings(vary={"": [0.0]}))
    files: tuple[Path, ...] = ()
    remarks: tuple[str, ...] = ()
    computed: int = 0
    efficiency: float = 1.0
    located: store.Located | None = None
    repeated: Repeated | None = None

    def signals(self, name: str) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """(time, values), (m,) each, of a kept signal at every point, read as they are asked for; empty where a run failed.

        Raises `BadInput` for a signal that was not kept, and for a sweep without a directory.
        """
        if self.located is None or name not in self.plan.keep.signals:
            raise BadInput("signals", repr(name), "a signal that the plan keeps, of a sweep with a directory")
        return store.signals_of(self.located, name)

    @property
    def done(self) -> np.ndarray:
        """(n,) truth values: points that gave their numbers."""
        return np.array([o == "done" for o in self.outcomes])


def sweep_settings(scene: Scene) -> PlanSettings:
    """The plan of the scene's own [sweep]: every combination; raises `BadInput` without one."""
    if not scene.sweep:
        raise BadInput(
            f"{scene.name}: sweep",
            "nothing",
            "a table of parameters and their values",
            "Add [sweep] with lines like unit.parameter = [1.0, 2.0], or give --over unit.parameter=0:1:11 or --plan.",
        )
    return plan_settings({"vary": scene.sweep}, f"{scene.name}: sweep")


def points(scene: Scene) -> list[tuple[dict[str, Any], Scene]]:
    """(values by "unit.parameter", the scene with them) of every combination of [sweep], all checked; raises `BadInput`."""
    from .many.plan import changes

    plan = plan_of(scene, sweep_settings(scene))
    return [(values, scene.with_changes(changes(scene, values))) for values in map(plan.values, range(plan.size))]


def sweep(
    scene: Scene,
    plan: PlanSettings | Mapping[str, Any] | str | Path | None = None,
    directory: str | Path | None = None,
    *,
    jobs: int | None = 1,
    scheduler: str = "",
    add: int = 0,
    retry: bool = False,
    progress: bool = False,
    summarize: Callable[[Result], Summary] | None = None,
    cube: np.ndarray | None = None,
    limits: str = "",
    conditions: Sequence[str] = (),
    verify: bool = True,
) -> Sweep:
    """Run the points of a plan, by default of the scene's [sweep]; one that fails leaves NaN and its reason.

    `directory`: where the points, the table and the data set go; what is there of the same scene is not run again. `jobs`:
    processes of this machine, 1: this one, None: all cores where it pays; `scheduler`: address of a Dask cluster instead.
    `add`: further points of a sampled plan. `retry`: points that have failed run again. `summarize`: figures of a run.
    `cube`: points (n, d) of the unit cube in the place of the method's own. `limits`, `conditions`: a validation table whose rows
    are limits, and which of them. `verify`: whether some points, those at the ends and three at random, run again with half of
    every macro step, as far as they take no more than 5 s. Neither the number of workers nor their order changes a number.
    Ctrl-C, SIGTERM and SIGHUP end it with the points it has; the others have the outcome "not run". Raises `BadInput`.
    """
    settings = sweep_settings(scene) if plan is None else read_plan(plan) if isinstance(plan, str | Path) else plan_settings(plan)
    settings = with_rows(settings, table=limits, conditions=conditions)
    chosen = plan_of(scene, _with_more(settings, add), cube)
    check_analysis(scene)
    task = Task.of(scene, settings.keep, summarize)
    with ExitStack() as stack:
        folder = (
            stack.enter_context(locked(directory))
            if directory is not None
            else Path(stack.enter_context(TemporaryDirectory(prefix="cosimo-sweep-")))
        )
        base = store.base_of(prepared(scene, settings.keep), task)
        parts, digests = store.points_folder(folder, base), chosen.digests(base)
        missing = store.locate_points(parts, digests, retry).missing
        stopped = None
        title = f"Sweep of {scene.title or scene.name}"
        with Live(folder, title, chosen.size, chosen.size - missing.size, progress) as live:
            if missing.size:
                stopped = _compute(task, chosen, digests, missing, parts, live, jobs, scheduler)
            efficiency = live.efficiency()
            if verify and stopped is None:
                live.repeating()
            collected = collected_sweep(
                scene,
                chosen,
                folder,
                base,
                digests=digests,
                stopped=stopped,
                kept=directory is not None,
                computed=missing.size,
                efficiency=efficiency,
                verify=task if verify else None,
            )
            live.end("stopped" if stopped is not None else "done")
    if collected.measures and stopped is None:
        check_limits(settings.limits, collected.units)
    return collected


def _with_more(settings: PlanSettings, add: int) -> PlanSettings:
    """The plan with further points of its sequence."""
    if not add:
        return settings
    if settings.method not in SAMPLED or settings.method == "latin-hypercube" or add < 0:
        raise BadInput(
            "--add",
            f"{add} with method {settings.method!r}",
            "a number of points of method 'sobol' or 'random'",
            "A grid or a list is extended in its plan; a Latin hypercube cannot be.",
        )
    return plan_settings(
        {**settings.model_dump(exclude_unset=True), "vary": settings.vary, "points": (settings.points or 0) + add}
    )


def _compute(
    task: Task, plan: Points, digests: np.ndarray, missing: np.ndarray, folder: Path, live: Live, jobs: int | None, scheduler: str
) -> Signals | None:
    if jobs is not None and jobs < 1:
        raise BadInput("--jobs", str(jobs), "at least 1")
    if not scheduler and jobs is None:  # what is short is done before other processes have started; and compiled for them
        if (stopped := compute_here(task, plan, digests, missing, folder, live, ALONE)) is not None:
            return stopped
        missing, jobs = store.locate_points(folder, digests).missing, cores()
        if not missing.size:
            return None
    count = min(jobs or 1, missing.size)
    if not scheduler and count == 1:
        return compute_here(task, plan, digests, missing, folder, live)
    workers: Workers = Cluster(scheduler) if scheduler else Pool(count)
    live.workers = workers.count
    try:
        stopped = compute_with(workers, task, plan, digests, missing, folder.resolve(), live)
    except BaseException:
        workers.stop()
        raise
    if stopped is None:
        workers.close()
    return stopped


def collected_sweep(
    scene: Scene,
    plan: Points,
    folder: Path,
    base: str,
    *,
    digests: np.ndarray | None = None,
    stopped: Signals | None = None,
    kept: bool = True,
    computed: int = 0,
    efficiency: float = 1.0,
    verify: Task | None = None,
) -> Sweep:
    """The points as they lie in the folder, with table and data set where they stay there; `verify`: whose runs to repeat."""
    parts = store.points_folder(folder, base)
    digests = plan.digests(base) if digests is None else digests
    located = store.locate_points(parts, digests)
    collected = store.collect(located, folder)
    repeated = None
    if verify is not None and stopped is None:
        places = ends_and_some(plan, collected.outcomes == OUTCOMES.index("done"))
        repeated = compared(places, repeat(verify, plan, digests, places, parts), collected.numbers)
    varied = {name: column.labels for name, column in plan.columns.items()}
    units = {name: unit_of(scene, name) for name in plan.columns} | dict(collected.units)
    units |= {n: limit.unit for n, limit in plan.settings.limits.items() if units.get(n) == ""}  # own functions say none
    files: list[Path] = []
    if kept:
        about = store.provenance(scene, plan, base, units)
        about |= {"verification": repeated.to_json()} if repeated is not None else {}
        store.write_provenance(folder, about)
        files.append(store.write_tables(folder, varied, units, collected))
        attributes = {
            "title": scene.title or scene.name,
            "source": f"cosimo {about['versions']['cosimo']}",
            "provenance": _json(about),
        }
        data = store.write_data_set(folder, varied, units, collected, located, attributes, plan.settings.keep.interval)
        files += [data] if data is not None else []
    outcomes = tuple(
        OUTCOMES[o] if OUTCOMES[o] in ("done", NOT_RUN) else collected.reasons[r]
        for o, r in zip(collected.outcomes, collected.reason, strict=True)
    )
    return Sweep(
        scene,
        varied,
        dict(collected.numbers),
        outcomes,
        collected.section,
        units,
        stopped,
        plan.settings,
        tuple(files),
        (*plan.remarks, *(repeated.messages() if repeated is not None else ())),
        computed,
        efficiency,
        located if kept else None,
        repeated,
    )


def _json(content: Any) -> str:
    import json

    return json.dumps(content)
