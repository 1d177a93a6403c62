"""One scene, many runs: the points of a plan, computed here, by processes or by a cluster, and kept as one data set.

What is kept of a run are statistics of its recorded signals after the transient, the figures of its system, quantities, own
functions and signals on request, and, where [analysis] has a section, the points of a signal each time an angle passes a
multiple of something: the raw material of a bifurcation diagram.

    [analysis]
    transient = 0.5                                                             # s, left out of everything below
    section = { signal = "bearing.x", angle = "bearing.cage_angle", turns = 8 }   # points eight times a turn of the angle
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from signal import Signals
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from ...components.core.errors import BadInput
from ...fmus.versions import version
from ..output import locked
from ..run.progress import terminal_bar
from ..scene.scene import Scene
from ..settings.plan import SAMPLED, PlanSettings
from .many.columns import check_columns, column_name
from .many.execute import Computing, WorkerOptions
from .many.files import Sweep, collect, write_data_set, write_provenance, write_tables
from .many.limits import check_limits, with_rows
from .many.measures import Summarize, Task, check_analysis
from .many.plan import plan_of, plan_settings
from .many.repetition import compared, ends_and_some, repeat
from .many.store import Store, StoredPlan


class AnswerOptions(WorkerOptions, total=False):
    """Who computes the runs of an answer, and what is shown and repeated of them: as `sweep` has it."""

    progress: bool
    verify: bool


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
    plan = plan_of(scene, sweep_settings(scene))
    return [(values, scene.with_changes(values)) for values in map(plan.values, range(plan.size))]


def sweep(
    scene: Scene,
    plan: PlanSettings | Mapping[str, Any] | str | Path | None = None,
    directory: str | Path | None = None,
    *,
    jobs: int | None = 1,
    cluster: str = "",
    add: int = 0,
    retry: bool = False,
    progress: bool = False,
    summarize: Summarize | None = None,
    cube: np.ndarray | None = None,
    limits: str = "",
    conditions: Sequence[str] = (),
    verify: bool = True,
    columns: Sequence[str] = (),
) -> Sweep:
    """Run the points of a plan, by default of the scene's [sweep]; one that fails leaves NaN and its reason.

    `directory`: where the points, the table and the data set go; what is there of the same scene is not run again. `jobs`:
    threads or processes of this machine, 1: this thread, None: all cores where it pays; `cluster`: address of a Dask scheduler instead.
    `add`: further points of a sampled plan. `retry`: points that have failed run again. `summarize`: figures of a run.
    `cube`: points (n, d) of the unit cube in the place of the method's own. `limits`, `conditions`: a validation table whose rows
    are limits, and which of them. `verify`: whether some points, those at the ends and three at random, run again with half of
    every macro step, as far as their counted work allows. `columns`: that an answer needs; those and the limits' that no run has
    are refused before the first run, figures of a system behind the first. Neither the number of workers nor their order changes a number.
    Ctrl-C, SIGTERM and SIGHUP end it with the points it has; the others have the outcome "not run". Raises `BadInput`.
    """
    settings = sweep_settings(scene) if plan is None else plan_settings(plan, scene=scene)
    settings = with_rows(settings, table=limits, conditions=conditions, scene=scene)
    chosen = plan_of(scene, _with_more(settings, add), cube)
    task = Task.of(scene, settings.keep, summarize, (*columns, *settings.limits))
    check_analysis(task.scene())
    known = all([check_columns(task, settings.limits, "limits"), check_columns(task, columns, "quantities")])
    with points_directory(directory, "cosimo-sweep-") as folder:
        points = StoredPlan(task, chosen, Store.of(task, folder))
        missing = points.missing(retry)
        stopped = None
        with (
            _counted(f"Sweep of {scene.title or scene.name}", chosen.size, missing.size, progress) as observe,
            Computing(task, jobs, cluster, observe) as computing,
        ):
            first = missing[:0] if known else missing[:1]
            if first.size:
                stopped = computing(points, first)
                for row in points.rows(first.tolist()).values():
                    if row.outcome == "done":
                        check_limits(settings.limits, row.units)
                        for name in columns:
                            column_name(row.numbers, name, "quantities")
            if missing.size > first.size and stopped is None:
                stopped = computing(points, missing[first.size :])
        collected = collected_sweep(
            scene,
            points,
            folder,
            stopped=stopped,
            kept=directory is not None,
            computed=missing.size,
            verify=verify and stopped is None,
            jobs=jobs,
            cluster=cluster,
        )
    if collected.measures and stopped is None:
        check_limits(settings.limits, collected.units)
    return collected


@contextmanager
def points_directory(directory: str | Path | None, prefix: str) -> Iterator[Path]:
    """The directory, locked, where one is given; else a temporary one."""
    if directory is not None:
        with locked(directory) as path:
            yield path
    else:
        with TemporaryDirectory(prefix=prefix) as temporary:
            yield Path(temporary)


@contextmanager
def _counted(title: str, total: int, missing: int, progress: bool) -> Iterator[Callable[[Sequence[Any]], None]]:
    """What is told of rows, and shows on a terminal how many of all there are."""
    if not (progress and sys.stderr.isatty()):
        yield lambda rows: None
        return
    with terminal_bar("{task.completed:g}/{task.total:g}") as bar:
        shown = bar.add_task(title, total=total, completed=total - missing)
        yield lambda rows: bar.advance(shown, len(rows))


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


def collected_sweep(
    scene: Scene,
    points: StoredPlan,
    folder: Path,
    *,
    stopped: Signals | None = None,
    kept: bool = True,
    computed: int = 0,
    verify: bool = False,
    jobs: int | None = 1,
    cluster: str = "",
) -> Sweep:
    """The points as they lie in their store, with table and data set where the folder is kept; `verify`: some are run again, by
    `jobs` or a `cluster`."""
    collected = collect(scene, points)
    repeated = None
    if verify:
        chosen = ends_and_some(points.plan, collected.done)
        repeated = compared(chosen, repeat(points, chosen, jobs, cluster), collected.measures)
    files: list[Path] = []
    if kept:
        verification = {} if repeated is None else {"verification": repeated.to_json()}
        attributes = {
            "title": scene.title or scene.name,
            "source": f"cosimo {version('cosimo')}",
            "provenance": write_provenance(folder, scene, points, collected.units, verification),
        }
        data = write_data_set(folder, collected, points, attributes)
        files = [write_tables(folder, collected), *([data] if data is not None else [])]
    return replace(
        collected,
        stopped=stopped,
        files=tuple(files),
        remarks=(
            *points.store.remarks,
            *points.plan.remarks,
            *collected.doubts,
            *(repeated.messages() if repeated is not None else ()),
        ),
        computed=computed,
        points=points if kept else None,
        repeated=repeated,
    )
